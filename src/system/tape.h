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

#include "system/graph.h"

#include <stddef.h>

typedef enum saltus_tape_code {
    SALTUS_TAPE_COMBINE,  /* sum of slot * register, and a slot alone at order 0 */
    SALTUS_TAPE_MULTIPLY, /* a * b */
    SALTUS_TAPE_SQUARE,   /* a * a */
    SALTUS_TAPE_DIVIDE,   /* a / b */
    SALTUS_TAPE_CHOOSE,   /* a where a slot is 1, b where it is 0 */
    SALTUS_TAPE_FUNCTION  /* of a; the derivative's series is b */
} saltus_tape_code;

typedef struct saltus_tape_step {
    saltus_tape_code code;
    saltus_operation function;
    int out, a, b;    /* registers; of a function: the operand, and the series of its derivative ... */
    double sign;      /* ... times this */
    int a2, b2;       /* the same of a second operand; -1: there is none */
    int first, count; /* of a combination: its terms; of a choice, first: its slot */
    unsigned depends; /* as of a node of the graph */
    bool linear;      /* what it is made of has no coefficients beyond order 1 */
} saltus_tape_step;

typedef struct saltus_tape_term {
    int slot;
    int from; /* register; -1: the slot alone */
} saltus_tape_term;

typedef struct saltus_tape {
    saltus_tape_step *steps;
    saltus_tape_term *terms;
    int *state_register; /* of each state; -1: nothing depends on it */
    int time, phase;     /* registers of these; -1 */
    int *outputs;        /* registers of the roots */
    int *slot_node;      /* the node whose value a slot has */
    unsigned *depends;   /* of each register */
    int step_count, term_count, state_count, output_count, slot_count, register_count;
} saltus_tape;

/* Make the tape of the given roots; `dimension` states. Nodes are added to the graph. NULL when there is no
 * memory, or the graph is full. */
saltus_tape *saltus_tape_new(saltus_graph *graph, const int *roots, int root_count, int dimension);
void saltus_tape_free(saltus_tape *tape);
/* Whether two tapes have the same steps: their systems can be lanes of one flow. */
bool saltus_tape_equal(const saltus_tape *a, const saltus_tape *b);

#endif
