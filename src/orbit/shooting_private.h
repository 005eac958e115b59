/* Private to the files shooting*.c: the work space.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SHOOTING_PRIVATE_H
#define SALTUS_ORBIT_SHOOTING_PRIVATE_H

#include "base/memory.h"
#include "flow/flow.h"
#include "orbit/shooting.h"

/* Derivatives of the state along an orbit by the unknowns of the orbit's equations (`answer`). The orbit is
 * walked in pieces. Over a piece the flow carries n tangent vectors from the identity, A, and the parameter
 * columns from their present values; the matrix of n rows is multiplied by A at the end of each piece. A mark
 * whose time is an unknown adds to the column of that time. */
typedef struct saltus_response {
    int n, unknowns;                  /* rows and columns of `answer` */
    int plain;                        /* number of unknown states and times, which come first */
    int directions;                   /* parameter columns of the flow */
    int place[SALTUS_DIRECTIONS_MAX]; /* the unknown of each direction, -1: none */
    double *tangents;      /* (n + directions) x n: the flow's tangent vectors at the end of the last piece */
    double *answer, *next; /* n x unknowns each */
} saltus_response;

/* Collects the derivative along the orbit in short segments, for a cocycle if one is wanted. */
typedef struct saltus_collection {
    saltus_cocycle *into;
    double *since, *work; /* derivative from the segment's beginning to the piece's, by columns */
    bool begun;           /* `since` is not the identity */
    double begin;         /* beginning of the segment */
    bool whole;           /* the last evaluation has filled the cocycle */
} saltus_collection;

/* Admissibility of the orbit between its marks, as seen by a walk. */
typedef struct saltus_breaches {
    saltus_breach *items;
    int count, room;
} saltus_breaches;

struct saltus_shooting {
    /* Set on creation. */
    saltus_family family;
    int n;
    double length, speed, force;          /* scales of gaps, normal speeds, normal accelerations */
    double state_scale[SALTUS_STATE_MAX]; /* of the first system, whatever the parameters */
    saltus_tuned full, bare;              /* with all tangent vectors, and with none */
    /* For the present sequence. */
    saltus_sequence sequence;
    int count; /* number of equations, and of unknowns without parameters */
    saltus_equations equations;
    saltus_arena arena;
    double *scale;     /* [count] */
    double *plain;     /* unscaled unknowns */
    int speed_mark;    /* whose speed_row is wanted; -1: none */
    double *speed_row; /* see saltus_shooting_speed_row */
    /* For the walks around the orbit. */
    saltus_response response;
    saltus_collection collection;
    saltus_breaches breaches;
    double onward, flow_speed; /* see saltus_shooting_onward */
    double steps;              /* usual integrator steps per period; 0: not known */
};

/* The omega in the unknowns; 0 if it is not one of them. */
double saltus_shooting_omega(const saltus_shooting *shooting, const double *u);
/* Walk along the first `segments` segments with one of the two flows: residuals and, with the full flow, rows
 * of the Jacobian, independent of the states at later cuts. Errors: those of the flow; marks out of order. */
saltus_status saltus_shooting_along(saltus_shooting *shooting, saltus_tuned *by, int segments,
                                    const double *u, saltus_message *message);
/* Once around: residuals and breaches at u, with and without Jacobian. `self` is the shooting. Errors: as
 * above. */
saltus_status saltus_shooting_around(void *self, const double *u, saltus_message *message);
saltus_status saltus_shooting_residual(void *self, const double *u, saltus_message *message);

#endif
