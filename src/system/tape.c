/* Arranges a tape's steps in rows. Steps of one kind and depth whose operands are in the same rows become one
 * step on adjacent elements. A family of equations then costs as many steps as one equation, and a single
 * trajectory has its elements side by side in packs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/tape.h"

#include "base/memory.h"
#include "system/compile.h"

#include <stdlib.h>
#include <string.h>

enum { total_max = 64 }; /* most elements that are summed side by side */
enum { pack_max = 8 };   /* elements of the widest pack, to which rows of a single trajectory are padded */

/* A register: its position, and what it is for. */
typedef struct home {
    int row, element; /* row -1: none yet */
    int level;
    int newness;             /* the higher, the later coefficient k becomes known; 0: an order before, as for
                                displacements */
    unsigned long long kind; /* kind of the step that computes it; steps of equal kinds share a row */
    bool delicate;           /* may be infinite or NaN; shares no row */
    bool accelerates;        /* an acceleration */
    bool used;               /* an operand of some step */
} home;

typedef struct arranger {
    const saltus_tape_steps *steps;
    saltus_tape *tape;
    home *homes;                /* [register] */
    int *first;                 /* [row][2]: position of each row for both widths */
    int *members, member_count; /* steps of the row that is being made */
    int rows;
    bool choices;
    int *stamps, stamp;                  /* marks of columns and diagonals visited */
    int reach;                           /* above the number of elements of any row */
    saltus_list made, terms, weights[2]; /* rows, their terms, slots of their weights */
    bool failed;
} arranger;

/* Append a copy of an entry. */
static void push(arranger *m, saltus_list *list, const void *entry, size_t size) {
    void *copy = saltus_list_grow(list, size, &m->failed);
    if (copy)
        memcpy(copy, entry, size);
}

static void add_slot(arranger *m, int width, int slot) {
    push(m, &m->weights[width], &slot, sizeof slot);
}

static int padded(int count) {
    return (count + pack_max - 1) / pack_max * pack_max;
}

/* Add a row of `count` elements. */
static int add_row(arranger *m, int count) {
    const int row = m->rows++;
    m->first[2 * row] = m->tape->elements[0];
    m->first[2 * row + 1] = m->tape->elements[1];
    m->tape->elements[0] += padded(count);
    m->tape->elements[1] += count;
    return row;
}

static void settle(arranger *m, int place, int row, int element, int level, int newness) {
    m->homes[place].row = row;
    m->homes[place].element = element;
    m->homes[place].level = level;
    m->homes[place].newness = newness;
}

static saltus_tape_operand operand_at(const arranger *m, int row, int element, bool spread,
                                      unsigned depends) {
    return (saltus_tape_operand){
        {m->first[2 * row] + element, m->first[2 * row + 1] + element}, spread, depends};
}

static saltus_tape_operand operand_of(const arranger *m, int place, bool spread) {
    const home *h = &m->homes[place];
    return operand_at(m, h->row, h->element, spread, m->steps->depends[place]);
}

/* The k-th register that a step needs at its own order; -1: a combination's number, -2: beyond the last. */
static int needs(const saltus_tape_steps *steps, const saltus_tape_step *s, int k) {
    if (s->code == SALTUS_TAPE_COMBINE)
        return k < s->count ? steps->terms[s->first + k].from : -2;
    bool one = s->code == SALTUS_TAPE_SQUARE || s->code == SALTUS_TAPE_FUNCTION;
    return k == 0 ? s->a : k == 1 && !one ? s->b : k == 1 && s->a2 >= 0 ? s->a2 : -2;
}

/* Whether a step is a combination that only the tape's outputs use. */
static bool is_last(const arranger *m, const saltus_tape_step *s) {
    return s->code == SALTUS_TAPE_COMBINE && !m->homes[s->out].used;
}

static unsigned long long mix(unsigned long long x) {
    x = (x ^ x >> 31) * 0x9e3779b97f4a7c15ULL;
    return (x ^ x >> 29) * 0xbf58476d1ce4e5b9ULL + 1;
}

/* A hash of what the steps of one row have in common; 0: the step has a row of its own. A combination is
 * hashed by the set of rows that it uses, in any order; accelerations form one row whatever they use. A
 * collision would cost time, nothing else. */
static unsigned long long kind_of(const arranger *m, const saltus_tape_step *s) {
    const saltus_tape_steps *steps = m->steps;
    bool alone =
        s->code == SALTUS_TAPE_FUNCTION || s->code == SALTUS_TAPE_CHOOSE || m->homes[s->out].delicate;
    unsigned long long rows = 0;
    for (int k = 0, place; (place = needs(steps, s, k)) != -2 && !alone; k++) {
        bool before = is_last(m, s);
        alone = place >= 0 && m->homes[place].delicate;
        for (int j = 0; j < k && !before; j++) {
            int other = needs(steps, s, j);
            before = place < 0 ? other < 0 : other >= 0 && m->homes[other].row == m->homes[place].row;
        }
        if (!before)
            rows += mix(place < 0 ? 1 : (unsigned long long)m->homes[place].row + 2);
    }
    return alone ? 0
                 : mix(rows + mix((unsigned long long)s->code * 64 + s->depends * 4 + s->linear * 2u +
                                  m->homes[s->out].accelerates)) |
                       1;
}

static const saltus_tape_step *member(const arranger *m, int e) {
    return &m->steps->items[m->members[e]];
}

/* The operand of all members: one element, a part of a row, or a gathering made for it. */
static saltus_tape_operand collect_operand(arranger *m, bool second, int level) {
    const int count = m->member_count, place = second ? member(m, 0)->b : member(m, 0)->a;
    const home *start = &m->homes[place];
    bool same = count > 1, piece = true;
    unsigned depends = 0;
    for (int e = 0; e < count; e++) {
        const int other = second ? member(m, e)->b : member(m, e)->a;
        same = same && other == place;
        piece = piece && m->homes[other].row == start->row && m->homes[other].element == start->element + e;
        depends |= m->steps->depends[other];
    }
    if (same || piece)
        return operand_of(m, place, same);
    const int row = add_row(m, count);
    saltus_tape_row gather = {.code = SALTUS_TAPE_GATHER,
                              .count = count,
                              .level = level,
                              .out = operand_at(m, row, 0, false, depends),
                              .first = m->terms.count};
    for (int e = 0; e < count; e++) {
        const saltus_tape_row_term term = operand_of(m, second ? member(m, e)->b : member(m, e)->a, true);
        push(m, &m->terms, &term, sizeof term);
    }
    push(m, &m->made, &gather, sizeof gather);
    return gather.out;
}

/* An entry of the matrix of a row of combinations: the weight of a source element in a result's `element`. */
typedef struct incidence {
    int element, row, from, slot; /* source; row -1: none, the weight counts alone */
    int newness;
    unsigned depends;
    bool taken;
} incidence;

static int earlier(const void *a, const void *b) {
    const incidence *x = a, *y = b;
    int order[] = {x->newness - y->newness, x->row - y->row, x->from - y->from, x->element - y->element};
    for (int k = 0; k < 4; k++)
        if (order[k])
            return order[k];
    return 0;
}

/* Cost of a load that overlaps two recent stores, in loads of one element. */
enum { overlap = 6 };

/* Whether a block's entries lie on so few diagonals that diagonals cost less than columns. With choices,
 * branches that are not taken may hold anything, so diagonals must not reach over the ends of their row. */
static bool on_diagonals(arranger *m, const incidence *list, int count, int members) {
    int columns = 0, diagonals = 0;
    bool aligned = true;
    m->stamp++;
    for (int k = 0; k < count; k++) {
        int *column = &m->stamps[list[k].from],
            *diagonal = &m->stamps[2 * m->reach + list[k].from - list[k].element];
        columns += *column != m->stamp;
        diagonals += *diagonal != m->stamp;
        *column = *diagonal = m->stamp;
        aligned = aligned && list[k].from == list[k].element;
    }
    return members > 1 && columns > 1 && (aligned || (diagonals + overlap < columns && !m->choices));
}

/* Add terms for the entries of one block of the matrix: its columns, or its diagonals. */
static void add_terms(arranger *m, incidence *block, int count, bool diagonal, int *slots,
                      saltus_tape_row *row) {
    const int members = row->count;
    for (int k = 0; k < count; k++) {
        if (block[k].taken)
            continue;
        const int shift = block[k].from - block[k].element;
        saltus_tape_row_term made = {.place = {-1, -1}, .spread = !diagonal};
        if (block->row >= 0)
            made = operand_at(m, block->row, diagonal ? shift : block[k].from, !diagonal, 0);
        for (int e = 0; e < members; e++)
            slots[e] = -1;
        for (int j = k; j < count; j++)
            if (!block[j].taken && slots[block[j].element] < 0 &&
                (diagonal ? block[j].from - block[j].element == shift : block[j].from == block[k].from)) {
                block[j].taken = true;
                slots[block[j].element] = block[j].slot;
                made.depends |= block[j].depends;
            }
        push(m, &m->terms, &made, sizeof made);
        for (int e = 0; e < members; e++)
            row->sparse = row->sparse || slots[e] < 0;
        for (int width = 0; width < 2; width++)
            for (int e = 0; e < (width ? members : padded(members)); e++)
                add_slot(m, width, e < members ? slots[e] : -1);
        row->terms++;
    }
}

static void add_combinations(arranger *m, saltus_tape_row *row) {
    const saltus_tape_steps *steps = m->steps;
    int count = 0, k = 0, beside = 1; /* elements that a single combination sums side by side */
    for (int e = 0; e < m->member_count; e++)
        count += member(m, e)->count;
    incidence *list = calloc((size_t)count + 1, sizeof *list);
    for (int j = 0; j < count && m->member_count == 1 && count >= 4; j++) {
        const int from = steps->terms[member(m, 0)->first + j].from;
        if (from >= 0 && m->homes[from].element >= beside)
            beside = m->homes[from].element + 1;
    }
    if (beside > 1 && beside <= total_max && !m->choices) {
        row->code = SALTUS_TAPE_TOTAL;
        row->count = beside;
    }
    int *slots = calloc((size_t)row->count, sizeof *slots);
    if (!list || !slots) {
        m->failed = true;
        goto out;
    }
    for (int e = 0; e < m->member_count; e++)
        for (int j = 0; j < member(m, e)->count; j++) {
            const saltus_tape_term *term = &steps->terms[member(m, e)->first + j];
            const home *h = term->from < 0 ? NULL : &m->homes[term->from];
            list[k++] = (incidence){.element = row->code == SALTUS_TAPE_TOTAL && h ? h->element : e,
                                    .row = h ? h->row : -1,
                                    .from = h ? h->element : 0,
                                    .slot = term->slot,
                                    .depends = h ? steps->depends[term->from] : 0,
                                    .newness = h ? h->newness : -1};
        }
    qsort(list, (size_t)count, sizeof *list, earlier);
    row->first = m->terms.count;
    row->weight[0] = m->weights[0].count;
    row->weight[1] = m->weights[1].count;
    for (int pass = 0; pass < 2; pass++) {
        for (int from = 0, to; from < count && !m->failed; from = to) {
            for (to = from; to < count && list[to].row == list[from].row; to++)
                ;
            const bool diagonal = list[from].row >= 0 && on_diagonals(m, list + from, to - from, row->count);
            if (diagonal == (pass == 1))
                add_terms(m, list + from, to - from, diagonal, slots, row);
            if (list[from].row < 0 && pass == 0)
                row->numbers = row->terms;
        }
        row->spread_terms = pass == 0 ? row->terms : row->spread_terms;
    }
out:
    free(list);
    free(slots);
}

/* Make a row of the collected steps. */
static void add_members(arranger *m, int level) {
    const saltus_tape_step *s = member(m, 0);
    saltus_tape_row row = {.code = s->code,
                           .function = s->function,
                           .count = m->member_count,
                           .level = level,
                           .sign = s->sign,
                           .linear = s->linear};
    if (s->code == SALTUS_TAPE_COMBINE)
        add_combinations(m, &row);
    else if (s->code == SALTUS_TAPE_CHOOSE) {
        for (int width = 0; width < 2; width++) {
            row.weight[width] = m->weights[width].count;
            for (int e = 0; e < (width ? 1 : pack_max); e++)
                add_slot(m, width, e == 0 ? s->first : -1);
        }
    }
    if (m->failed)
        return;
    if (s->code != SALTUS_TAPE_COMBINE && s->code != SALTUS_TAPE_FUNCTION) {
        row.a = collect_operand(m, false, level);
        row.b = s->code == SALTUS_TAPE_SQUARE ? row.a : collect_operand(m, true, level);
    } else if (s->code == SALTUS_TAPE_FUNCTION)
        row.a = operand_of(m, s->a, true);
    if (s->code == SALTUS_TAPE_MULTIPLY)
        row.turned = m->homes[s->a].newness > m->homes[s->b].newness;
    /* In a product the spread operand comes first. */
    if (s->code == SALTUS_TAPE_MULTIPLY && row.b.spread && !row.a.spread) {
        saltus_tape_operand other = row.a;
        row.a = row.b;
        row.b = other;
        row.turned = m->homes[s->b].newness > m->homes[s->a].newness;
    }
    const bool early = !(s->depends & SALTUS_OF_STATES) || s->code == SALTUS_TAPE_INTEGRAL;
    const int place = add_row(m, m->member_count);
    for (int e = 0; e < m->member_count; e++)
        settle(m, member(m, e)->out, place, e, level, early ? 0 : level + 1);
    row.out = operand_at(m, place, 0, false, s->depends);
    push(m, &m->made, &row, sizeof row);
}

/* Set the operands of functions once all registers have places, since their derivatives may come later. Sine
 * and cosine of an argument that is linear in time share a row with a recurrence of its own. */
static void finish_functions(arranger *m) {
    saltus_tape *tape = m->tape;
    saltus_tape_row *rows = m->made.items;
    int kept = 0;
    for (int k = 0; k < m->made.count; k++) {
        saltus_tape_row row = rows[k];
        if (row.code == SALTUS_TAPE_FUNCTION) {
            const saltus_tape_step *s = m->steps->items;
            while (s->code != SALTUS_TAPE_FUNCTION ||
                   operand_of(m, s->out, false).place[1] != row.out.place[1])
                s++;
            row.b = operand_of(m, s->b, true);
            row.paired = s->a2 >= 0;
            if (row.paired) {
                row.a2 = operand_of(m, s->a2, true);
                row.b2 = operand_of(m, s->b2, true);
            }
            if (row.linear && row.function == SALTUS_OP_COS)
                continue;
            if (row.linear && row.function == SALTUS_OP_SIN)
                row.code = SALTUS_TAPE_SINE;
            else if (!(row.out.depends & SALTUS_OF_STATES))
                tape->steady_by_order = true;
        }
        rows[kept++] = row;
    }
    m->made.count = kept;
}

static void mark_used(arranger *m) {
    const saltus_tape_steps *steps = m->steps;
    for (int k = 0; k < steps->count; k++) {
        const saltus_tape_step *s = &steps->items[k];
        for (int j = 0, place; (place = needs(steps, s, j)) != -2; j++)
            if (place >= 0)
                m->homes[place].used = true;
        if (s->code == SALTUS_TAPE_FUNCTION)
            m->homes[s->b].used = true;
        if (s->code == SALTUS_TAPE_FUNCTION && s->a2 >= 0)
            m->homes[s->b2].used = true;
    }
}

/* Rows that depend on no state come first, then the order is by level. */
static int row_order(const void *a, const void *b) {
    const saltus_tape_row *x = a, *y = b;
    int moves_x = (x->out.depends & SALTUS_OF_STATES) != 0,
        moves_y = (y->out.depends & SALTUS_OF_STATES) != 0;
    if (moves_x != moves_y)
        return moves_x - moves_y;
    if (x->level != y->level)
        return x->level - y->level;
    /* Gatherings precede the rows that use them. */
    int late_x = x->code != SALTUS_TAPE_GATHER, late_y = y->code != SALTUS_TAPE_GATHER;
    return late_x != late_y ? late_x - late_y : x->out.place[1] - y->out.place[1];
}

/* Mark registers that may be infinite or NaN in branches that are not taken. Without choices they would
 * show. */
static void mark_delicate(arranger *m) {
    const saltus_tape_steps *steps = m->steps;
    for (int k = 0; k < steps->count; k++)
        m->choices = m->choices || steps->items[k].code == SALTUS_TAPE_CHOOSE;
    /* Functions may precede the steps of their series: repeat until nothing changes. */
    for (bool changed = m->choices; changed;) {
        changed = false;
        for (int k = 0; k < steps->count; k++) {
            const saltus_tape_step *s = &steps->items[k];
            bool own = s->code == SALTUS_TAPE_DIVIDE ||
                       (s->code == SALTUS_TAPE_FUNCTION && s->function != SALTUS_OP_SIN &&
                        s->function != SALTUS_OP_COS);
            for (int j = 0, place; (place = needs(steps, s, j)) != -2; j++)
                own = own || (place >= 0 && m->homes[place].delicate);
            if (s->code == SALTUS_TAPE_CHOOSE || !own || m->homes[s->out].delicate)
                continue;
            m->homes[s->out].delicate = changed = true;
        }
    }
}

/* Set the levels: steps lie one above their operands, unused combinations at the top. Returns the highest. */
static int find_levels(arranger *m) {
    const saltus_tape_steps *steps = m->steps;
    int levels = 0;
    for (int k = 0; k < steps->count; k++) {
        const saltus_tape_step *s = &steps->items[k];
        int level =
            s->code == SALTUS_TAPE_INTEGRAL; /* an integral lies above its rate, whose step may come later */
        for (int j = 0, place; (place = needs(steps, s, j)) != -2; j++)
            if (place >= 0 && m->homes[place].level > level)
                level = m->homes[place].level;
        m->homes[s->out].level = level + 1;
        levels = level + 1 > levels ? level + 1 : levels;
    }
    for (int k = 0; k < steps->count; k++)
        if (is_last(m, &steps->items[k]))
            m->homes[steps->items[k].out].level = levels;
    return levels;
}

/* Arrange all steps of a level in rows, kind by kind. */
static void arrange_level(arranger *m, int level, bool *done) {
    const saltus_tape_steps *steps = m->steps;
    for (int k = 0; k < steps->count; k++)
        if (!done[k] && m->homes[steps->items[k].out].level == level) {
            saltus_tape_step *s = &steps->items[k];
            const home *a = &m->homes[s->a], *b = &m->homes[s->b];
            /* The operand of the earlier row comes first, so that q * u and u * q are of one kind. */
            if (s->code == SALTUS_TAPE_MULTIPLY &&
                (b->row < a->row || (b->row == a->row && b->element < a->element))) {
                const int other = s->a;
                s->a = s->b;
                s->b = other;
            }
            m->homes[s->out].kind = kind_of(m, s);
        }
    for (int k = 0; k < steps->count && !m->failed; k++) {
        if (done[k] || m->homes[steps->items[k].out].level != level)
            continue;
        const unsigned long long kind = m->homes[steps->items[k].out].kind;
        m->member_count = 0;
        for (int j = k; j < steps->count; j++) {
            const home *h = &m->homes[steps->items[j].out];
            if (j == k || (kind && !done[j] && h->level == level && h->kind == kind)) {
                m->members[m->member_count++] = j;
                done[j] = true;
            }
        }
        add_members(m, level);
    }
}

/* Add the rows of the states, of time and of the phase. */
static void place_leaves(arranger *m, int dof) {
    const saltus_tape_steps *steps = m->steps;
    saltus_tape *tape = m->tape;
    const int counts[] = {dof, dof, steps->states - 2 * dof};
    for (int part = 0, state = 0; part < 3; part++) {
        const int row = add_row(m, counts[part]);
        tape->state[part] = operand_at(m, row, 0, false, SALTUS_OF_STATES);
        for (int i = 0; i < counts[part]; i++, state++)
            if (steps->state_register[state] >= 0)
                settle(m, steps->state_register[state], row, i, 0, part > 0);
    }
    for (int k = 0; k < 2; k++) {
        const int place = k ? steps->phase : steps->time;
        saltus_tape_operand *at = k ? &tape->phase : &tape->time;
        *at = (saltus_tape_operand){.place = {-1, -1}};
        if (place >= 0) {
            settle(m, place, add_row(m, 1), 0, 0, 0);
            *at = operand_of(m, place, true);
        }
    }
}

static void find_outputs(arranger *m, int dof) {
    const saltus_tape_steps *steps = m->steps;
    saltus_tape *tape = m->tape;
    tape->output_row = true;
    for (int i = 0; i < steps->output_count; i++)
        tape->outputs[i] = operand_of(m, steps->outputs[i], false);
    for (int i = 0; i < dof; i++) {
        const home *h = &m->homes[steps->outputs[i]];
        tape->output_row = tape->output_row && h->element == i && h->row == m->homes[steps->outputs[0]].row;
    }
    for (int k = 0; k < steps->registers && dof; k++)
        if (m->homes[k].row == m->homes[steps->outputs[0]].row && m->homes[k].element >= dof)
            tape->output_row = false;
}

/* Fill a tape with rows made of steps. False: no memory. */
static bool arrange(saltus_tape *tape, const saltus_tape_steps *steps, int dof) {
    const size_t registers = (size_t)steps->registers + 1, count = (size_t)steps->count + 1;
    const int reach = steps->registers + steps->states + 1;
    arranger m = {.steps = steps,
                  .tape = tape,
                  .reach = reach,
                  .homes = calloc(registers, sizeof *m.homes),
                  /* leaves; a row and two gatherings per step */
                  .first = calloc(2 * (3 * count + 8), sizeof *m.first),
                  .members = calloc(count, sizeof *m.members),
                  .stamps = calloc(3 * (size_t)reach, sizeof *m.stamps)};
    bool *done = calloc(count, sizeof *done);
    int levels = 0;
    tape->output_count = steps->output_count;
    tape->outputs = calloc((size_t)tape->output_count + 1, sizeof *tape->outputs);
    m.failed = !m.homes || !m.first || !m.members || !m.stamps || !done || !tape->outputs;
    if (!m.failed) {
        /* Terms on diagonals reach over the ends of their rows, with zero weights. */
        tape->elements[0] = padded(reach) + pack_max;
        for (int i = 0; i < dof; i++)
            m.homes[steps->outputs[i]].accelerates = true;
        for (int k = 0; k < steps->registers; k++)
            m.homes[k].row = -1;
        place_leaves(&m, dof);
        mark_delicate(&m);
        mark_used(&m);
        levels = find_levels(&m);
    }
    for (int level = 1; level <= levels && !m.failed; level++)
        arrange_level(&m, level, done);
    if (!m.failed) {
        finish_functions(&m);
        if (m.made.count)
            qsort(m.made.items, (size_t)m.made.count, sizeof(saltus_tape_row), row_order);
        find_outputs(&m, dof);
        tape->elements[0] += padded(reach) + pack_max;
    }
    tape->rows = m.made.items;
    tape->row_count = m.made.count;
    while (tape->steady_rows < tape->row_count &&
           !(tape->rows[tape->steady_rows].out.depends & SALTUS_OF_STATES))
        tape->steady_rows++;
    tape->row_terms = m.terms.items;
    tape->row_term_count = m.terms.count;
    for (int width = 0; width < 2; width++) {
        tape->weight_slot[width] = m.weights[width].items;
        tape->weights[width] = m.weights[width].count;
    }
    free(m.homes);
    free(m.first);
    free(m.members);
    free(m.stamps);
    free(done);
    return !m.failed;
}

saltus_tape *saltus_tape_new(saltus_graph *graph, const int *roots, int root_count, int dof, int dimension) {
    saltus_tape_steps steps;
    saltus_tape *tape = calloc(1, sizeof *tape);
    if (!tape || !saltus_tape_steps_make(&steps, graph, roots, root_count, dof, dimension)) {
        free(tape);
        return NULL;
    }
    const bool arranged = arrange(tape, &steps, dof);
    tape->slot_node = steps.slot_node;
    tape->slot_count = steps.slot_count;
    steps.slot_node = NULL;
    saltus_tape_steps_close(&steps);
    if (!arranged) {
        saltus_tape_free(tape);
        return NULL;
    }
    tape->compiled = saltus_compiled_list_new();
    return tape;
}

void saltus_tape_free(saltus_tape *tape) {
    if (!tape)
        return;
    free(tape->rows);
    free(tape->row_terms);
    free(tape->weight_slot[0]);
    free(tape->weight_slot[1]);
    free(tape->outputs);
    free(tape->slot_node);
    saltus_compiled_list_free(tape->compiled);
    free(tape);
}

static bool same_operands(const saltus_tape_operand *a, const saltus_tape_operand *b, int count) {
    bool same = true;
    for (int k = 0; same && k < count; k++)
        same = a[k].place[0] == b[k].place[0] && a[k].place[1] == b[k].place[1] &&
               a[k].spread == b[k].spread && a[k].depends == b[k].depends;
    return same;
}

/* The members not compared follow from the rows. */
bool saltus_tape_equal(const saltus_tape *a, const saltus_tape *b) {
    bool same = a->row_count == b->row_count && a->row_term_count == b->row_term_count &&
                a->slot_count == b->slot_count && a->output_count == b->output_count &&
                a->weights[1] == b->weights[1] && same_operands(&a->time, &b->time, 1) &&
                same_operands(&a->phase, &b->phase, 1) && same_operands(a->state, b->state, 3) &&
                same_operands(a->outputs, b->outputs, a->output_count) &&
                same_operands(a->row_terms, b->row_terms, a->row_term_count);
    for (int k = 0; same && k < a->row_count; k++) {
        const saltus_tape_row *x = &a->rows[k], *y = &b->rows[k];
        const saltus_tape_operand of_x[] = {x->out, x->a, x->b, x->a2, x->b2},
                                  of_y[] = {y->out, y->a, y->b, y->a2, y->b2};
        same = x->code == y->code && x->function == y->function && x->count == y->count &&
               x->sign == y->sign && x->linear == y->linear && x->paired == y->paired &&
               x->turned == y->turned && x->sparse == y->sparse && x->first == y->first &&
               x->terms == y->terms && x->numbers == y->numbers && x->spread_terms == y->spread_terms &&
               x->weight[0] == y->weight[0] && x->weight[1] == y->weight[1] && same_operands(of_x, of_y, 5);
    }
    for (int k = 0; same && k < a->weights[1]; k++)
        same = a->weight_slot[1][k] == b->weight_slot[1][k];
    return same;
}
