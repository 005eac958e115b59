/* Private: a graph prepared for Taylor series. A tape computes coefficient k of all series that the equations
 * consist of, from coefficients of order k and below, in few kinds of steps:
 *
 *   a linear combination of series, whose weights (slots) depend on parameters alone,
 *   a product, a square or a quotient, a choice between two series that parameters decide,
 *   a function y = f(a), from y' = f'(a) a' with the series of f'(a), also on the tape up to one order less.
 *
 * The last rule serves every elementary function, and tangent vectors too: those of y are f'(a) times those
 * of a (Griewank & Walther, Evaluating Derivatives, SIAM 2008, chapter 13).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TAPE_H
#define SALTUS_SYSTEM_TAPE_H

#include "system/tape_steps.h"

/* Position of a row or an element, for both widths of a kernel: [0] for one trajectory, where every row is
 * padded to whole packs, and [1] for trajectories side by side, without padding. */
typedef struct saltus_tape_operand {
    int place[2];
    bool spread;      /* one element serves the whole row */
    unsigned depends; /* bits as in saltus_graph_node */
} saltus_tape_operand;

/* A term of a row of combinations: a row or a spread element, with a weight for each element of the result.
 * place -1: the weights alone, at order 0. */
typedef saltus_tape_operand saltus_tape_row_term;

/* Steps of one kind on adjacent elements; the kernel runs these. */
typedef struct saltus_tape_row {
    saltus_tape_code code;
    saltus_operation function;
    int count; /* elements */
    int level; /* one above the highest level of its operands */
    saltus_tape_operand out, a, b, a2, b2;
    double sign;
    bool linear, paired; /* paired: a function with a2 and b2 */
    bool turned;         /* product: a becomes known after b at each order */
    bool sparse;         /* combination: some weights are always zero */
    int first, terms;    /* combination: row terms; gathering: operands */
    int numbers,
        spread_terms; /* ends of the terms that are weights alone, and of those with spread elements */
    int weight[2];    /* combination: first weight, [term][element], for both widths */
} saltus_tape_row;

/* Rows that do not depend on the state come first (steady_rows of them). */
typedef struct saltus_tape {
    saltus_tape_row *rows;
    int row_count, steady_rows;
    bool steady_by_order;            /* steady rows must be computed order by order */
    saltus_tape_row_term *row_terms; /* of all combinations and gatherings */
    int row_term_count;
    int *weight_slot[2], weights[2]; /* slot of each weight, -1: zero; and number of weights */
    int elements[2];                 /* in all rows */
    saltus_tape_operand state[3];    /* displacements, velocities, extra states */
    saltus_tape_operand time, phase, *outputs;
    int output_count;
    bool output_row; /* the accelerations form one row */
    int *slot_node;  /* [slot]: the node whose value the slot has */
    int slot_count;
    /* Compiled functions of this tape; NULL: none. */
    struct saltus_compiled_list *compiled;
} saltus_tape;

/* Make the tape of the given roots, with `dof` displacements and as many velocities among `dimension` states,
 * adding nodes to the graph. NULL: no memory, or the graph is full. */
saltus_tape *saltus_tape_new(saltus_graph *graph, const int *roots, int root_count, int dof, int dimension);
void saltus_tape_free(saltus_tape *tape);
/* Whether two tapes have equal rows, so that their systems can be lanes of one flow. */
bool saltus_tape_equal(const saltus_tape *a, const saltus_tape *b);

#endif
