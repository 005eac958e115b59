/* Private to the files shooting*.c: the workspace.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SHOOTING_PRIVATE_H
#define SALTUS_ORBIT_SHOOTING_PRIVATE_H

#include "orbit/response.h"
#include "orbit/shooting.h"

/* A flow, and the parameters and the sequence's omega that its system has. */
typedef struct saltus_tuned {
    saltus_flow *flow;
    saltus_system *system;
    double at[2], omega;
} saltus_tuned;

/* The derivative along the orbit in short segments, which goes to a cocycle where there is one. */
typedef struct saltus_collection {
    saltus_cocycle *into;
    double *since, *work; /* derivative from the segment's begin to the piece's, by columns */
    bool begun;           /* it is not the identity */
    double begin;         /* of the segment */
    bool whole;           /* it has gone there in the last evaluation */
} saltus_collection;

/* What a walk saw of the orbit between its marks. */
typedef struct saltus_breaches {
    saltus_breach *items;
    int count, room;
} saltus_breaches;

struct saltus_shooting {
    /* Settled when it is made. */
    saltus_family family;
    int n;
    double length, speed, force;          /* scales of gaps, normal speeds, normal accelerations */
    double state_scale[SALTUS_STATE_MAX]; /* of the first system, however the parameters change */
    saltus_tuned full, bare;              /* with all tangent vectors, and without any */
    /* Of the sequence it has taken on. */
    saltus_sequence sequence;
    int count; /* of the equations, and of the unknowns but for the parameters */
    saltus_equations equations;
    saltus_arena arena;
    double *scale; /* count */
    double *plain; /* the unknowns unscaled */
    /* Of the walks around it. */
    saltus_response response;
    saltus_collection collection;
    saltus_breaches breaches;
    double onward, flow_speed; /* as saltus_shooting_onward gives them */
    double steps;              /* of the integrator in a period, as usual here; 0: not known */
};

/* The omega of unknowns; 0 where it is none of them. */
double saltus_shooting_omega(const saltus_shooting *shooting, const double *u);
/* Along the first so many segments with one of the two flows: their residuals, with the full one their rows
 * of the Jacobian, whatever the states at later cuts may be. Errors: those of the flow; marks out of order.
 */
saltus_status saltus_shooting_along(saltus_shooting *shooting, saltus_tuned *by, int segments,
                                    const double *u, saltus_message *message);
/* Once around: residuals and breaches at u, with the Jacobian, or without. `self` is the shooting. Errors:
 * those of the flow; marks out of order. */
saltus_status saltus_shooting_around(void *self, const double *u, saltus_message *message);
saltus_status saltus_shooting_residual(void *self, const double *u, saltus_message *message);

#endif
