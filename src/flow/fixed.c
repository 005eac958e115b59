/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/fixed.h"

#include <stdio.h>
#include <stdlib.h>

enum {
    rows_max = 64,    /* of a tape compiled with tangent vectors: the compiler takes a tenth of a second for
                         each, or more; twice as many without */
    delay = 50,       /* ms that a run asks before the compiler starts: at least this ... */
    delay_a_row = 10, /* ... and at least this per row */
    steps_between = 64
};

/* Names in src/system/tape_kernel.h, by code. */
#define NAME(code) [SALTUS_TAPE_##code] = #code,
static const char *const kinds[] = {SALTUS_TAPE_CODES(NAME)};

static void put_operands(FILE *out, const saltus_tape_operand *x, int count) {
    for (int k = 0; k < count; k++)
        fprintf(out, "{{%d, %d}, %d, %uu}, ", x[k].place[0], x[k].place[1], x[k].spread, x[k].depends);
}

static void put_row(FILE *out, const saltus_tape_row *s) {
    fprintf(out, "{%d, %d, %d, %d, ", (int)s->code, (int)s->function, s->count, s->level);
    saltus_tape_operand operands[] = {s->out, s->a, s->b, s->a2, s->b2};
    for (int k = 0; k < 5 && s->count == 1; k++)
        operands[k].spread = true;
    put_operands(out, operands, 5);
    fprintf(out, "%a, %d, %d, %d, %d, %d, %d, %d, %d, {%d, %d}}, ", s->sign, s->linear, s->paired, s->turned,
            s->sparse, s->first, s->terms, s->numbers, s->spread_terms, s->weight[0], s->weight[1]);
}

/* How many row terms the tape's rows use. */
static int count_terms(const saltus_tape *tape) {
    int most = 0;
    for (const saltus_tape_row *s = tape->rows; s < tape->rows + tape->row_count; s++) {
        const int last = s->first + (s->code == SALTUS_TAPE_GATHER ? s->count : s->terms);
        most = last > most ? last : most;
    }
    return most;
}

static int own_elements(const saltus_tape_row *row) {
    return row->code == SALTUS_TAPE_TOTAL ? 1 : row->count;
}

/* Whether an operand of `count` elements may read any element of a row, packs' ends included. */
static bool touches(const saltus_tape_row *row, const saltus_tape_operand *x, int count) {
    return x->place[0] < row->out.place[0] + own_elements(row) + SALTUS_PACK_MAX &&
           x->place[0] + (x->spread ? 1 : count + SALTUS_PACK_MAX) > row->out.place[0];
}

/* Whether a row's coefficients are needed at their own order only: it is a sum that only accelerations and
 * other sums read, element by element. A term that begins elsewhere may reach over the row's ends. */
static bool passes(const saltus_tape *tape, const saltus_tape_row *row) {
    bool alone = row->code == SALTUS_TAPE_COMBINE || row->code == SALTUS_TAPE_TOTAL;
    for (const saltus_tape_row *s = tape->rows; s < tape->rows + tape->row_count && alone; s++) {
        const bool sums = s->code == SALTUS_TAPE_COMBINE || s->code == SALTUS_TAPE_TOTAL;
        const saltus_tape_operand operands[] = {s->a, s->b, s->a2, s->b2};
        for (int k = 0; k < 4 && !sums && s->code != SALTUS_TAPE_GATHER; k++)
            alone = alone && !touches(row, &operands[k], s->count);
        for (int t = s->numbers; t < s->terms && sums; t++) {
            const saltus_tape_row_term *term = &tape->row_terms[s->first + t];
            alone = alone &&
                    (term->spread || term->place[0] == row->out.place[0] || !touches(row, term, s->count));
        }
    }
    return alone && row - tape->rows >= tape->steady_rows;
}

static void put_passing(FILE *out, const saltus_tape *tape) {
    fprintf(out, "static const bool fixed_passing[%d] = {", tape->elements[1] + 1);
    for (const saltus_tape_row *s = tape->rows; s < tape->rows + tape->row_count; s++)
        for (int e = 0; e < own_elements(s) && passes(tape, s); e++)
            fprintf(out, "[%d] = 1, ", s->out.place[1] + e);
    fputs("}; ", out);
}

/* The tape as C constants, on one line. */
static void put_tape(FILE *out, const saltus_tape *tape) {
    const saltus_tape_operand none = {.place = {0, 0}};
    fputs("#define SALTUS_FIXED_TAPE static const saltus_tape_row_term fixed_terms[] = {", out);
    put_operands(out, tape->row_terms, count_terms(tape));
    put_operands(out, &none, 1);
    fputs("}; static const saltus_tape_operand fixed_outputs[] = {", out);
    put_operands(out, tape->outputs, tape->output_count);
    fputs("}; static const saltus_tape_row fixed_rows[] = {", out);
    for (int k = 0; k < tape->row_count; k++)
        put_row(out, &tape->rows[k]);
    fputs("}; ", out);
    put_passing(out, tape);
    fputs("static const bool fixed_absent[] = {", out);
    for (int k = 0; k < tape->weights[1]; k++)
        fprintf(out, "%d, ", tape->weight_slot[1][k] < 0);
    fprintf(out,
            "}; static const saltus_tape fixed_tape = {.row_count = %d, .steady_rows = %d, "
            ".steady_by_order = %d, .elements = {%d, %d}, .weights = {%d, %d}, "
            ".output_row = %d, .rows = (saltus_tape_row *)fixed_rows, "
            ".row_terms = (saltus_tape_row_term *)fixed_terms, "
            ".outputs = (saltus_tape_operand *)fixed_outputs, .state = {",
            tape->row_count, tape->steady_rows, tape->steady_by_order, tape->elements[0], tape->elements[1],
            tape->weights[0], tape->weights[1], tape->output_row);
    put_operands(out, tape->state, 3);
    fputs("}, .time = ", out);
    put_operands(out, &tape->time, 1);
    fputs(".phase = ", out);
    put_operands(out, &tape->phase, 1);
    fputs("};\n", out);
}

static void put_rows(FILE *out, const char *name, const saltus_tape *tape, int first, int last) {
    fprintf(out, "#define %s(X)", name);
    for (int k = first; k < last; k++)
        fprintf(out, " X(%s, %d)", kinds[tape->rows[k].code], k);
    fputc('\n', out);
}

/* A saltus_compile_source; also NULL for tapes that are too long to compile. */
static char *make_source(const void *from, const saltus_compile_shape *shape) {
    const saltus_system *system = from;
    const saltus_tape *tape = system->tape;
    char *text = NULL;
    size_t size;
    const int most = shape->columns ? rows_max : 2 * rows_max;
    FILE *out = tape->row_count <= most ? open_memstream(&text, &size) : NULL;
    if (!out)
        return NULL;
    fprintf(out,
            "#define _POSIX_C_SOURCE 200809L\n#define SALTUS_WIDE %d\n#define SALTUS_KERNEL_NAME %s\n"
            "#define SALTUS_FIXED_PACK %d\n#define SALTUS_FIXED_WORK %zu\n#define SALTUS_FIXED_DOF %d\n"
            "#define SALTUS_FIXED_EXTRA %d\n#define SALTUS_FIXED_ORDER %d\n#define SALTUS_FIXED_COLUMNS %d\n"
            "#define SALTUS_FIXED_DIRECTIONS %d\n",
            shape->wide, SALTUS_COMPILED_NAME, saltus_kernel_find(system->spec.model->kernel, 0)->lanes,
            sizeof(saltus_work), system->dof, system->extra, shape->order, shape->columns, shape->directions);
    put_tape(out, tape);
    put_rows(out, "SALTUS_FIXED_STEADY", tape, 0, tape->steady_rows);
    put_rows(out, "SALTUS_FIXED_ROWS", tape, tape->steady_rows, tape->row_count);
    fputs(saltus_kernel_text, out);
    bool failed = ferror(out) != 0;
    failed = fclose(out) != 0 || failed;
    if (!failed)
        return text;
    free(text);
    return NULL;
}

static int delay_for(const saltus_tape *tape) {
    const int own = tape->row_count * delay_a_row;
    return own > delay ? own : delay;
}

saltus_fixed saltus_fixed_open(const saltus_kernel *kernel, const saltus_system *system,
                               const saltus_work *work) {
    if (!system->tape)
        return (saltus_fixed){.compiled = NULL};
    const saltus_compile_shape shape = {.flags = kernel->flags,
                                        .wide = kernel->lanes > 1,
                                        .order = work->order,
                                        .columns = work->columns,
                                        .directions = work->directions,
                                        .delay = delay_for(system->tape)};
    saltus_compiled *compiled = saltus_compiled_hold(system->tape->compiled, &shape);
    return (saltus_fixed){.compiled = compiled, .function = compiled ? saltus_compiled_get(compiled) : NULL};
}

void saltus_fixed_close(saltus_fixed *fixed) {
    saltus_compiled_release(fixed->compiled);
}

bool saltus_fixed_ask(saltus_fixed *fixed, const saltus_system *system) {
    fixed->function = fixed->compiled ? saltus_compiled_ask(fixed->compiled, make_source, system) : NULL;
    return fixed->function != NULL;
}

void saltus_fixed_expand(saltus_fixed *fixed, const saltus_kernel *kernel, const saltus_system *system,
                         saltus_work *work, int from, int to) {
    if (fixed->compiled && !fixed->function && ++fixed->steps == steps_between) {
        fixed->steps = 0;
        saltus_fixed_ask(fixed, system);
    }
    if (fixed->function)
        fixed->function(work, from, to);
    else
        kernel->expand(work, from, to);
}

bool saltus_fixed_tell(const saltus_system *system, char *text, size_t size) {
    if (!system->tape || system->stiffness_ratio > 1)
        return false;
    const saltus_compile_shape shape = {.flags = saltus_kernel_find(system->spec.model->kernel, 1)->flags,
                                        .delay = delay_for(system->tape)};
    saltus_compile_tell(&shape, make_source, system, text, size);
    return true;
}
