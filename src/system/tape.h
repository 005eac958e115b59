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
    SALTUS_TAPE_FUNCTION, /* of a; the derivative's series is b */
    SALTUS_TAPE_RATE,     /* a displacement a times its velocity: half the derivative of a * a */
    SALTUS_TAPE_INTEGRAL, /* a * a, where b = a * a' is there as well */
    SALTUS_TAPE_SINE,     /* sine and, in b, cosine of a, which is linear in time; of rows only */
    SALTUS_TAPE_TOTAL,    /* one combination of the elements of rows; of rows only */
    SALTUS_TAPE_GATHER    /* a row of elements that stand apart; of rows only */
} saltus_tape_code;

/* All of them, by name. */
#define SALTUS_TAPE_CODES(X)                                                                                 \
    X(COMBINE)                                                                                               \
    X(MULTIPLY) X(SQUARE) X(DIVIDE) X(CHOOSE) X(FUNCTION) X(RATE) X(INTEGRAL) X(SINE) X(TOTAL) X(GATHER)

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

typedef struct saltus_tape {
    saltus_tape_step *steps;
    saltus_tape_term *terms;
    int *state_register; /* of each state; -1: nothing depends on it */
    int time, phase;     /* registers of these; -1 */
    int *outputs;        /* registers of the roots */
    int *slot_node;      /* the node whose value a slot has */
    unsigned *depends;   /* of each register */
    int step_count, term_count, state_count, output_count, slot_count, register_count;
    /* The same in rows; those that depend on no state come first. */
    saltus_tape_row *rows;
    int row_count, steady_rows;
    bool steady_by_order;            /* rows that depend on no state need one another order by order */
    saltus_tape_row_term *row_terms; /* of all combinations and gatherings */
    int *weight_slot[2], weights[2]; /* slots of the weights; -1: a zero */
    int elements[2];                 /* of all rows */
    saltus_tape_operand state[3];    /* displacements, velocities, extra states */
    saltus_tape_operand time_at, phase_at, *output_at;
    bool output_row; /* the accelerations are one row */
    /* What has been compiled for it; NULL: nothing is. */
    struct saltus_compiled_list *compiled;
} saltus_tape;

/* Make the tape of the given roots; `dof` displacements and as many velocities among `dimension` states.
 * Nodes are added to the graph. NULL when there is no memory, or the graph is full. */
saltus_tape *saltus_tape_new(saltus_graph *graph, const int *roots, int root_count, int dof, int dimension);
/* Arrange a tape's steps in rows; part of making it. False: no memory. */
bool saltus_tape_arrange(saltus_tape *tape, int dof);
void saltus_tape_free(saltus_tape *tape);
/* Whether two tapes have the same steps: their systems can be lanes of one flow. */
bool saltus_tape_equal(const saltus_tape *a, const saltus_tape *b);

#endif
