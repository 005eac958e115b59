/* Private: the steps of a tape, on registers that hold one series each.
 *
 * They are made from a graph's nodes, as few as possible; tape.c arranges them in rows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TAPE_STEPS_H
#define SALTUS_SYSTEM_TAPE_STEPS_H

#include "system/graph.h"

#include <stddef.h>

typedef enum saltus_tape_code {
    SALTUS_TAPE_COMBINE,  /* sum of slot * register; a slot without register counts at order 0 */
    SALTUS_TAPE_MULTIPLY, /* a * b */
    SALTUS_TAPE_SQUARE,   /* a * a */
    SALTUS_TAPE_DIVIDE,   /* a / b */
    SALTUS_TAPE_CHOOSE,   /* a if the slot is 1, b if it is 0 */
    SALTUS_TAPE_FUNCTION, /* of a; b is the series of its derivative */
    SALTUS_TAPE_RATE,     /* displacement a times its velocity: half the derivative of a * a */
    SALTUS_TAPE_INTEGRAL, /* a * a for a displacement a, from b = a * a' */
    SALTUS_TAPE_SINE,     /* sine and, in b, cosine of a, which is linear in time; rows only */
    SALTUS_TAPE_TOTAL,    /* one combination of the elements of rows; rows only */
    SALTUS_TAPE_GATHER    /* a row of elements from different places; rows only */
} saltus_tape_code;

/* All codes, by name. */
#define SALTUS_TAPE_CODES(X)                                                                                 \
    X(COMBINE)                                                                                               \
    X(MULTIPLY) X(SQUARE) X(DIVIDE) X(CHOOSE) X(FUNCTION) X(RATE) X(INTEGRAL) X(SINE) X(TOTAL) X(GATHER)

typedef struct saltus_tape_step {
    saltus_tape_code code;
    saltus_operation function;
    int out, a, b;    /* registers; FUNCTION: operand, and series of the derivative, ... */
    double sign;      /* ... which is to be multiplied by this */
    int a2, b2;       /* FUNCTION: the same for a second operand; -1: none */
    int first, count; /* COMBINE: its terms; CHOOSE: `first` is its slot */
    unsigned depends; /* bits as in saltus_graph_node */
    bool linear;      /* operands have no coefficients beyond order 1 */
} saltus_tape_step;

typedef struct saltus_tape_term {
    int slot;
    int from; /* register; -1: the slot alone, at order 0 */
} saltus_tape_term;

typedef struct saltus_tape_steps {
    saltus_tape_step *items;
    saltus_tape_term *terms;
    unsigned *depends; /* [register] */
    int count, registers;
    int *state_register; /* [states]: register of each state; -1: unused */
    int states;
    int time, phase; /* registers of these; -1: unused */
    int *outputs;    /* registers of the roots */
    int output_count;
    int *slot_node; /* [slot]: the node whose value the slot has */
    int slot_count;
} saltus_tape_steps;

/* Make the steps that compute the given roots, with `dof` displacements and as many velocities among the
 * states, adding nodes to the graph. False, with the steps closed: no memory, or the graph is full. */
bool saltus_tape_steps_make(saltus_tape_steps *steps, saltus_graph *graph, const int *roots, int root_count,
                            int dof, int states);
void saltus_tape_steps_close(saltus_tape_steps *steps);

#endif
