/* Private: derivatives of the state along an orbit by the unknowns of the orbit's equations (`answer`).
 *
 * The orbit is walked in pieces. Over a piece the flow carries n tangent vectors from the identity, A, and
 * the parameter columns from their present values; the matrix of n rows is multiplied by A at the end of each
 * piece. A mark whose time is an unknown adds to the column of that time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_RESPONSE_H
#define SALTUS_ORBIT_RESPONSE_H

#include "base/memory.h"
#include "flow/flow.h"

typedef struct saltus_response {
    int n, unknowns;                  /* rows and columns of `answer` */
    int plain;                        /* number of unknown states and times, which come first */
    int directions;                   /* parameter columns of the flow */
    int place[SALTUS_DIRECTIONS_MAX]; /* the unknown of each direction, -1: none */
    double *tangents;      /* (n + directions) x n: the flow's tangent vectors at the end of the last piece */
    double *answer, *next; /* n x unknowns each */
} saltus_response;

/* Take the matrices from an arena, in both of its passes. */
void saltus_response_reserve(saltus_response *response, saltus_arena *arena);
/* Start a segment, whose state is the unknowns from `first` on, with the flow's vectors there. */
void saltus_response_start(saltus_response *response, saltus_flow *flow, int first);
void saltus_response_begin_piece(saltus_response *response, saltus_flow *flow);
void saltus_response_end_piece(saltus_response *response, saltus_flow *flow);
/* The derivatives of a quantity at a mark by the unknowns, in units of `scale`, from its gradient along the
 * tangent vectors, its rate per period, and the matrix before the piece that led to the mark. Unknown `own`
 * is the mark's time, in periods. */
void saltus_response_mark(const saltus_response *response, const double *gradient, double rate, double scale,
                          int own, double *row);

#endif
