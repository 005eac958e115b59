/* Private: how the state on the way around an orbit answers to the unknowns of the orbit's equations.
 *
 * The way is walked in pieces. Over a piece the flow carries n tangent vectors from the identity, A, and the
 * parameters' columns from their present values; the answer to all unknowns is a matrix of n rows, which a
 * piece multiplies by A. A mark whose time is an unknown adds a column of its own.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_RESPONSE_H
#define SALTUS_ORBIT_RESPONSE_H

#include "base/memory.h"
#include "flow/flow.h"

typedef struct saltus_response {
    int n, unknowns;                  /* rows and columns of the answer */
    int plain;                        /* of the unknowns: states and times, which come first */
    int directions;                   /* parameter columns of the flow */
    int place[SALTUS_DIRECTIONS_MAX]; /* the unknown that each of them belongs to, -1 for none */
    double *tangents;      /* (n + directions) x n: the flow's tangent vectors at the last piece's end */
    double *answer, *next; /* n x unknowns each */
} saltus_response;

/* Take the matrices from an arena, in both of its passes. */
void saltus_response_reserve(saltus_response *response, saltus_arena *arena);
/* At the begin of a segment, whose state is unknowns from `first` on: what the flow's vectors are there. */
void saltus_response_start(saltus_response *response, saltus_flow *flow, int first);
void saltus_response_begin_piece(saltus_response *response, saltus_flow *flow);
void saltus_response_end_piece(saltus_response *response, saltus_flow *flow);
/* The row of the equation of a mark, in units of `scale`, from the answer before the piece that led to it;
 * unknown `own` is the mark's time, in periods. */
void saltus_response_mark(const saltus_response *response, const saltus_strike *strike, double scale, int own,
                          double period, double *row);

#endif
