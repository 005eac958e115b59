/* Private: a graph made ready for Taylor series. A tape computes the coefficients of order k of all that the
 * equations are made of, from those of order k and below, in few kinds of steps:
 *
 *   a linear combination of series, its factors being numbers that depend on parameters alone (slots),
 *   a product or a square, a quotient, one of two series by a number that depends on parameters alone,
 *   a function y = f(a), from y' = f'(a) a' with the series of f'(a), which is on the tape as well and needed
 *   one order less than y.
 *
 * The last rule serves every elementary function, and tangent vectors too: those of y are f'(a) times those
 * of a (Griewank & Walther, Evaluating Derivatives, SIAM 2008, chapter 13).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TAPE_H
#define SALTUS_SYSTEM_TAPE_H

#include "system/tape_steps.h"

/* Places of elements exist for both widths of a kernel: [0] with every row filled up to whole packs, as one
 * trajectory has them, and [1] without gaps, for trajectories side by side. */
typedef struct saltus_tape_operand {
    int place[2];
    bool spread;      /* one element for all of a row */
    unsigned depends; /* as of a node of the graph */
} saltus_tape_operand;

/* A term of a row of combinations: a row or a spread element, each element of the result with a weight of its
 * own. place -1: the weights alone, at order 0. */
typedef saltus_tape_operand saltus_tape_row_term;

/* Steps of one kind on neighbouring elements: what the kernel runs. */
typedef struct saltus_tape_row {
    saltus_tape_code code;
    saltus_operation function;
    int count; /* elements */
    int level; /* one more than the highest of its operands */
    saltus_tape_operand out, a, b, a2, b2;
    double sign;
    bool linear, paired; /* paired: of a function, a2 and b2 exist */
    bool turned;         /* of a product: at each order a is known later than b */
    bool sparse;         /* of combinations: some weights are always zero */
    int first, terms;    /* of combinations: row terms; of a gathering: its operands */
    int numbers,
        spread_terms; /* ends of the terms that are numbers alone and of those with spread elements */
    int weight[2];    /* place of its first weight: [term][element], of both widths */
} saltus_tape_row;

/* Rows that depend on no state come first. */
typedef struct saltus_tape {
    saltus_tape_row *rows;
    int row_count, steady_rows;
    bool steady_by_order;            /* rows that depend on no state need one another order by order */
    saltus_tape_row_term *row_terms; /* of all combinations and gatherings */
    int row_term_count;
    int *weight_slot[2], weights[2]; /* slots of the weights; -1: a zero */
    int elements[2];                 /* of all rows */
    saltus_tape_operand state[3];    /* displacements, velocities, extra states */
    saltus_tape_operand time, phase, *outputs;
    int output_count;
    bool output_row; /* the accelerations are one row */
    int *slot_node;  /* the node whose value a slot has */
    int slot_count;
    /* What has been compiled for it; NULL: nothing is. */
    struct saltus_compiled_list *compiled;
} saltus_tape;

/* Make the tape of the given roots; `dof` displacements and as many velocities among `dimension` states.
 * Nodes are added to the graph. NULL when there is no memory, or the graph is full. */
saltus_tape *saltus_tape_new(saltus_graph *graph, const int *roots, int root_count, int dof, int dimension);
void saltus_tape_free(saltus_tape *tape);
/* Whether two tapes have the same rows: their systems can be lanes of one flow. */
bool saltus_tape_equal(const saltus_tape *a, const saltus_tape *b);

#endif
