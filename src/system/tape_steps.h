/* Private: the steps of a tape on registers, one for each series.
 *
 * They are made from a graph's nodes as few as can be, and serve to arrange the tape's rows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TAPE_STEPS_H
#define SALTUS_SYSTEM_TAPE_STEPS_H

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

typedef struct saltus_tape_steps {
    saltus_tape_step *items;
    saltus_tape_term *terms;
    unsigned *depends; /* of each register */
    int count, registers;
    int *state_register; /* of each of so many states; -1: nothing depends on it */
    int states;
    int time, phase; /* registers of these; -1 */
    int *outputs;    /* registers of the roots */
    int output_count;
    int *slot_node; /* the node whose value a slot has */
    int slot_count;
} saltus_tape_steps;

/* The steps that make the given roots; `dof` displacements and as many velocities among so many states. Nodes
 * are added to the graph. False when there is no memory, or the graph is full; they are closed in any case.
 */
bool saltus_tape_steps_make(saltus_tape_steps *steps, saltus_graph *graph, const int *roots, int root_count,
                            int dof, int states);
void saltus_tape_steps_close(saltus_tape_steps *steps);

#endif
