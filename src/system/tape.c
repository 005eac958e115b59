/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/tape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A list that grows. */
typedef struct list {
    void *items;
    int count, room;
} list;

/* A tape being made. What a node has become stands in `place`: a register, or -1 where it has none yet. */
typedef struct maker {
    saltus_graph *graph;
    saltus_tape *tape;
    int *place, *slot_of, *uses;
    int placed; /* nodes that `place`, `slot_of` and `uses` have room for */
    list steps, terms, slots, depends, linear;
    bool failed;
} maker;

/* A number times a node, and sums of such: nodes of factors depend on parameters alone. Node -1: the number.
 */
typedef struct summand {
    int factor, node;
} summand;

static void *grow(maker *m, list *l, size_t size) {
    if (l->count == l->room) {
        int room = 2 * l->room + 32;
        void *items = realloc(l->items, (size_t)room * size);
        if (!items) {
            m->failed = true;
            return NULL;
        }
        l->items = items;
        l->room = room;
    }
    return (char *)l->items + (size_t)l->count++ * size;
}

/* Nodes may have been added to the graph since. */
static bool follow_graph(maker *m) {
    int count = m->graph->count;
    int **const arrays[] = {&m->place, &m->slot_of, &m->uses};
    m->failed = m->failed || m->graph->full;
    if (m->failed || count <= m->placed)
        return !m->failed;
    for (int k = 0; k < 3; k++) {
        int *longer = realloc(*arrays[k], 2 * (size_t)count * sizeof *longer);
        if (!longer) {
            m->failed = true;
            return false;
        }
        for (int j = m->placed; j < 2 * count; j++)
            longer[j] = k < 2 ? -1 : 0;
        *arrays[k] = longer;
    }
    m->placed = 2 * count;
    return true;
}

static const saltus_graph_node *node_at(const maker *m, int node) {
    return &m->graph->nodes[node];
}

static bool is_number(const maker *m, int node) {
    return (node_at(m, node)->depends & ~(unsigned)SALTUS_OF_PARAMETERS) == 0;
}

static int slot_of(maker *m, int node) {
    if (!follow_graph(m))
        return 0;
    if (m->slot_of[node] < 0) {
        int *slot = grow(m, &m->slots, sizeof *slot);
        if (!slot)
            return 0;
        *slot = node;
        m->slot_of[node] = m->slots.count - 1;
    }
    return m->slot_of[node];
}

static int new_register(maker *m, unsigned depends, bool linear) {
    unsigned *entry = grow(m, &m->depends, sizeof *entry);
    bool *flag = grow(m, &m->linear, sizeof *flag);
    if (!entry || !flag)
        return 0;
    *entry = depends;
    *flag = linear;
    return m->depends.count - 1;
}

static bool is_linear(const maker *m, int place) {
    return ((const bool *)m->linear.items)[place];
}

static int add_step(maker *m, saltus_tape_step step) {
    if (step.out < 0)
        step.out = new_register(m, step.depends, step.code == SALTUS_TAPE_COMBINE && step.linear);
    saltus_tape_step *entry = grow(m, &m->steps, sizeof *entry);
    if (!entry)
        return 0;
    *entry = step;
    return step.out;
}

static int register_of(maker *m, int node);

/* A node as a factor times a node that is no such product itself. */
static summand split(maker *m, int node) {
    saltus_graph *g = m->graph;
    summand s = {saltus_graph_constant(g, 1), node};
    for (;;) {
        const saltus_graph_node n = g->nodes[s.node];
        if (n.operation == SALTUS_OP_MULTIPLY && is_number(m, n.operand[0])) {
            s.factor = saltus_graph_apply(g, SALTUS_OP_MULTIPLY, s.factor, n.operand[0]);
            s.node = n.operand[1];
        } else if (n.operation == SALTUS_OP_MULTIPLY && is_number(m, n.operand[1])) {
            s.factor = saltus_graph_apply(g, SALTUS_OP_MULTIPLY, s.factor, n.operand[1]);
            s.node = n.operand[0];
        } else if (n.operation == SALTUS_OP_DIVIDE && is_number(m, n.operand[1])) {
            s.factor = saltus_graph_apply(g, SALTUS_OP_DIVIDE, s.factor, n.operand[1]);
            s.node = n.operand[0];
        } else if (n.operation == SALTUS_OP_MULTIPLY) {
            /* (c x) (d y) = (c d) (x y) */
            summand a = split(m, n.operand[0]), b = split(m, n.operand[1]);
            s.factor = saltus_graph_apply(g, SALTUS_OP_MULTIPLY, s.factor,
                                          saltus_graph_apply(g, SALTUS_OP_MULTIPLY, a.factor, b.factor));
            s.node = saltus_graph_apply(g, SALTUS_OP_MULTIPLY, a.node, b.node);
            return s;
        } else
            return s;
    }
}

/* Collect a node, times a factor, into a sum. Sums that nothing else uses are taken apart. */
static void collect(maker *m, int factor, int node, list *sum, bool outermost) {
    saltus_graph *g = m->graph;
    if (m->failed)
        return;
    if (is_number(m, node)) {
        summand *s = grow(m, sum, sizeof *s);
        if (s)
            *s = (summand){saltus_graph_apply(g, SALTUS_OP_MULTIPLY, factor, node), -1};
        return;
    }
    summand part = split(m, node);
    const saltus_graph_node n = g->nodes[part.node];
    bool sums = n.operation == SALTUS_OP_ADD || n.operation == SALTUS_OP_SUBTRACT;
    if (!follow_graph(m))
        return;
    factor = saltus_graph_apply(g, SALTUS_OP_MULTIPLY, factor, part.factor);
    if (sums && (outermost || m->uses[part.node] <= 1) && m->place[part.node] < 0) {
        int other = n.operation == SALTUS_OP_ADD
                        ? factor
                        : saltus_graph_apply(g, SALTUS_OP_MULTIPLY, factor, saltus_graph_constant(g, -1));
        collect(m, factor, n.operand[0], sum, false);
        collect(m, other, n.operand[1], sum, false);
        return;
    }
    summand *s = grow(m, sum, sizeof *s);
    if (s)
        *s = (summand){factor, part.node};
}

/* Terms of one node together, and the numbers. */
static void merge(maker *m, list *sum) {
    summand *s = sum->items;
    int kept = 0;
    for (int k = 0; k < sum->count; k++) {
        int j = 0;
        while (j < kept && s[j].node != s[k].node)
            j++;
        if (j < kept)
            s[j].factor = saltus_graph_apply(m->graph, SALTUS_OP_ADD, s[j].factor, s[k].factor);
        else
            s[kept++] = s[k];
    }
    sum->count = kept;
}

/* A sum as a step of its own. */
static int combine(maker *m, int node) {
    list sum = {.items = NULL};
    collect(m, saltus_graph_constant(m->graph, 1), node, &sum, true);
    merge(m, &sum);
    /* The registers first: their steps come before this one. */
    for (int k = 0; k < sum.count && !m->failed; k++)
        if (((summand *)sum.items)[k].node >= 0)
            register_of(m, ((summand *)sum.items)[k].node);
    saltus_tape_step step = {.code = SALTUS_TAPE_COMBINE,
                             .first = m->terms.count,
                             .count = sum.count,
                             .out = -1,
                             .depends = node_at(m, node)->depends,
                             .linear = true};
    for (int k = 0; k < sum.count && !m->failed; k++) {
        summand s = ((summand *)sum.items)[k];
        saltus_tape_term *term = grow(m, &m->terms, sizeof *term);
        if (term)
            *term = (saltus_tape_term){slot_of(m, s.factor), s.node < 0 ? -1 : register_of(m, s.node)};
        step.linear = step.linear && (s.node < 0 || (!m->failed && is_linear(m, m->place[s.node])));
    }
    free(sum.items);
    return m->failed ? 0 : add_step(m, step);
}

/* A whole number between -8 and 8, and which one; 0: none. */
static int small_power(const maker *m, int node) {
    double value = node_at(m, node)->value;
    return node_at(m, node)->operation == SALTUS_OP_CONSTANT && fabs(value) <= 8 && value == floor(value)
               ? (int)value
               : 0;
}

/* A power by products where the exponent is a small whole number, otherwise by exp and log. */
static int rewrite_power(maker *m, int a, int b) {
    saltus_graph *g = m->graph;
    int power = small_power(m, b), result = a;
    if (!power)
        return saltus_graph_apply(
            g, SALTUS_OP_EXP,
            saltus_graph_apply(g, SALTUS_OP_MULTIPLY, b, saltus_graph_apply(g, SALTUS_OP_LOG, a, -1)), -1);
    /* Squares first: x^6 = (x x^2)^2. */
    for (int bit = 1 << (int)log2(abs(power)) >> 1; bit > 0; bit >>= 1) {
        result = saltus_graph_apply(g, SALTUS_OP_MULTIPLY, result, result);
        if (abs(power) & bit)
            result = saltus_graph_apply(g, SALTUS_OP_MULTIPLY, a, result);
    }
    return power > 0 ? result : saltus_graph_apply(g, SALTUS_OP_DIVIDE, saltus_graph_constant(g, 1), result);
}

/* Functions without a rule of their own, by others: tan a = sin a / cos a, tanh a = 1 - 2 / (exp(2 a) + 1).
 */
static int rewrite(maker *m, int node) {
    saltus_graph *g = m->graph;
    const saltus_graph_node n = *node_at(m, node);
    int a = n.operand[0], one = saltus_graph_constant(g, 1);
    if (n.operation == SALTUS_OP_POWER)
        return rewrite_power(m, a, n.operand[1]);
    if (n.operation == SALTUS_OP_TAN)
        return saltus_graph_apply(g, SALTUS_OP_DIVIDE, saltus_graph_apply(g, SALTUS_OP_SIN, a, -1),
                                  saltus_graph_apply(g, SALTUS_OP_COS, a, -1));
    if (n.operation != SALTUS_OP_TANH)
        return node;
    int twice = saltus_graph_apply(g, SALTUS_OP_EXP, saltus_graph_apply(g, SALTUS_OP_ADD, a, a), -1);
    int part = saltus_graph_apply(g, SALTUS_OP_DIVIDE, saltus_graph_constant(g, 2),
                                  saltus_graph_apply(g, SALTUS_OP_ADD, one, twice));
    return saltus_graph_apply(g, SALTUS_OP_SUBTRACT, one, part);
}

/* The step of a function comes before those of its derivative, which may be made of the function: so it has
 * its register first. */
static int add_function(maker *m, int node) {
    saltus_graph *g = m->graph;
    const saltus_graph_node n = *node_at(m, node);
    bool two = n.operation == SALTUS_OP_ATAN2;
    saltus_tape_step step = {.code = SALTUS_TAPE_FUNCTION,
                             .function = n.operation,
                             .depends = n.depends,
                             .sign = 1,
                             .a = register_of(m, n.operand[0]),
                             .a2 = two ? register_of(m, n.operand[1]) : -1,
                             .b2 = -1};
    if (m->failed || !follow_graph(m))
        return 0;
    step.out = m->place[node] = new_register(m, n.depends, false);
    step.linear = is_linear(m, step.a) && !two;
    int index = m->steps.count;
    add_step(m, step);
    if (two) {
        /* d atan2(y, x) = (x dy - y dx) / (x^2 + y^2) */
        int y = n.operand[0], x = n.operand[1];
        int size = saltus_graph_apply(g, SALTUS_OP_ADD, saltus_graph_apply(g, SALTUS_OP_MULTIPLY, x, x),
                                      saltus_graph_apply(g, SALTUS_OP_MULTIPLY, y, y));
        step.b = register_of(m, saltus_graph_apply(g, SALTUS_OP_DIVIDE, x, size));
        step.b2 = register_of(m, saltus_graph_apply(g, SALTUS_OP_DIVIDE,
                                                    saltus_graph_apply(g, SALTUS_OP_SUBTRACT, 0, y), size));
    } else {
        summand derivative = split(m, saltus_graph_outer_derivative(g, node));
        step.sign = node_at(m, derivative.factor)->value;
        step.b = register_of(m, derivative.node);
    }
    if (!m->failed)
        ((saltus_tape_step *)m->steps.items)[index] = step;
    return step.out;
}

/* One of two series; which one is decided by parameters alone. */
static int add_choice(maker *m, int node) {
    saltus_graph *g = m->graph;
    const saltus_graph_node n = *node_at(m, node);
    int one = saltus_graph_constant(g, 1);
    int chosen = saltus_graph_choose(g, n.operation, n.operand[0], n.operand[1], one, 0);
    saltus_tape_step step = {.code = SALTUS_TAPE_CHOOSE,
                             .out = -1,
                             .depends = n.depends,
                             .a = register_of(m, n.operand[2]),
                             .b = register_of(m, n.operand[3]),
                             .a2 = -1,
                             .b2 = -1,
                             .first = slot_of(m, chosen)};
    return m->failed ? 0 : add_step(m, step);
}

static int add_leaf(maker *m, int node) {
    const saltus_graph_node n = *node_at(m, node);
    int place = new_register(m, n.depends, n.operation != SALTUS_OP_STATE);
    if (n.operation == SALTUS_OP_STATE)
        m->tape->state_register[n.index] = place;
    else
        *(n.operation == SALTUS_OP_TIME ? &m->tape->time : &m->tape->phase) = place;
    return place;
}

static int add_node(maker *m, int node) {
    const saltus_graph_node n = *node_at(m, node);
    saltus_tape_step step = {.out = -1, .depends = n.depends, .a2 = -1, .b2 = -1};
    if (n.operation == SALTUS_OP_STATE || n.operation == SALTUS_OP_TIME || n.operation == SALTUS_OP_PHASE)
        return add_leaf(m, node);
    int other = rewrite(m, node);
    if (other != node)
        return register_of(m, other);
    summand part = split(m, node);
    if (is_number(m, node) || part.node != node || n.operation == SALTUS_OP_ADD ||
        n.operation == SALTUS_OP_SUBTRACT)
        return combine(m, node);
    if (n.operation == SALTUS_OP_ATAN2 || (n.operation >= SALTUS_OP_SQRT && n.operation <= SALTUS_OP_COSH))
        return add_function(m, node);
    if (n.operation >= SALTUS_OP_CHOOSE_LESS)
        return add_choice(m, node);
    step.a = register_of(m, n.operand[0]);
    step.b = register_of(m, n.operand[1]);
    step.code = n.operation == SALTUS_OP_DIVIDE ? SALTUS_TAPE_DIVIDE
                : step.a == step.b              ? SALTUS_TAPE_SQUARE
                                                : SALTUS_TAPE_MULTIPLY;
    return m->failed ? 0 : add_step(m, step);
}

/* The register of a node, made where there is none yet. */
static int register_of(maker *m, int node) {
    if (!follow_graph(m))
        return 0;
    if (m->place[node] < 0) {
        int place = add_node(m, node);
        if (follow_graph(m))
            m->place[node] = place;
    }
    return m->failed ? 0 : m->place[node];
}

static void count_uses(maker *m, const int *roots, int root_count) {
    bool *needed = calloc((size_t)m->graph->count, sizeof *needed);
    if (!needed || !follow_graph(m)) {
        m->failed = true;
        free(needed);
        return;
    }
    saltus_graph_mark(m->graph, roots, root_count, needed);
    for (int k = 0; k < m->graph->count; k++)
        for (int j = 0; needed[k] && j < saltus_operation_operands(m->graph->nodes[k].operation); j++)
            m->uses[m->graph->nodes[k].operand[j]]++;
    for (int k = 0; k < root_count; k++)
        m->uses[roots[k]]++;
    free(needed);
}

saltus_tape *saltus_tape_new(saltus_graph *graph, const int *roots, int root_count, int dimension) {
    maker m = {.graph = graph, .tape = calloc(1, sizeof *m.tape)};
    if (!m.tape)
        return NULL;
    saltus_tape *tape = m.tape;
    tape->time = tape->phase = -1;
    tape->state_count = dimension;
    tape->output_count = root_count;
    tape->state_register = malloc((size_t)(dimension + 1) * sizeof *tape->state_register);
    tape->outputs = malloc((size_t)(root_count + 1) * sizeof *tape->outputs);
    m.failed = !tape->state_register || !tape->outputs;
    for (int i = 0; i < dimension && !m.failed; i++)
        tape->state_register[i] = -1;
    if (!m.failed)
        count_uses(&m, roots, root_count);
    for (int k = 0; k < root_count && !m.failed; k++)
        tape->outputs[k] = register_of(&m, roots[k]);
    tape->steps = m.steps.items;
    tape->terms = m.terms.items;
    tape->slot_node = m.slots.items;
    tape->depends = m.depends.items;
    tape->step_count = m.steps.count;
    tape->term_count = m.terms.count;
    tape->slot_count = m.slots.count;
    tape->register_count = m.depends.count;
    free(m.linear.items);
    free(m.place);
    free(m.slot_of);
    free(m.uses);
    if (!m.failed)
        return tape;
    saltus_tape_free(tape);
    return NULL;
}

void saltus_tape_free(saltus_tape *tape) {
    if (!tape)
        return;
    free(tape->steps);
    free(tape->terms);
    free(tape->state_register);
    free(tape->outputs);
    free(tape->slot_node);
    free(tape->depends);
    free(tape);
}

static bool same_step(const saltus_tape_step *a, const saltus_tape_step *b) {
    return a->code == b->code && a->function == b->function && a->out == b->out && a->a == b->a &&
           a->b == b->b && a->sign == b->sign && a->a2 == b->a2 && a->b2 == b->b2 && a->first == b->first &&
           a->count == b->count && a->depends == b->depends && a->linear == b->linear;
}

bool saltus_tape_equal(const saltus_tape *a, const saltus_tape *b) {
    bool same = a->step_count == b->step_count && a->term_count == b->term_count &&
                a->slot_count == b->slot_count && a->register_count == b->register_count &&
                a->state_count == b->state_count && a->output_count == b->output_count &&
                a->time == b->time && a->phase == b->phase;
    for (int i = 0; same && i < a->state_count; i++)
        same = a->state_register[i] == b->state_register[i];
    for (int i = 0; same && i < a->output_count; i++)
        same = a->outputs[i] == b->outputs[i];
    for (int k = 0; same && k < a->step_count; k++)
        same = same_step(&a->steps[k], &b->steps[k]);
    for (int k = 0; same && k < a->term_count; k++)
        same = a->terms[k].slot == b->terms[k].slot && a->terms[k].from == b->terms[k].from;
    return same;
}
