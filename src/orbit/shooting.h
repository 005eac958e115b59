/* Private: periodic orbits with a prescribed sequence of events, whose times are among the unknowns.
 *
 * The unknowns are the states at the cuts (one cut: single shooting), the times of the marks and the
 * parameter. The equations are continuity around the orbit and one for each mark: zero gap at impacts and
 * sticks, zero force at releases. All are smooth in the unknowns, even where an impact speed passes through
 * zero. Therefore orbits near grazing are found and followed in this form (in the literature, the
 * "formulation with unknowns at the impacts"). Extremes collected on the way show whether the stops are
 * respected between marks.
 *
 * Without forcing the period is an unknown, too, as the logarithm of its ratio to the family's period. One
 * more equation puts the orbit's base on the hyperplane through `anchor` that is normal to `across`.
 *
 * After a `driven` mark the flow finds its events itself up to the next mark, as it must through complete
 * chatter. A sequence without marks, driven from its base, is ordinary shooting.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SHOOTING_H
#define SALTUS_ORBIT_SHOOTING_H

#include "base/memory.h"
#include "flow/flow.h"
#include "orbit/multipliers.h"
#include "orbit/newton.h"
#include "saltus/orbit.h"

enum { SALTUS_MARKS_MAX = 192, SALTUS_CUTS_MAX = 32 };

typedef struct saltus_mark {
    saltus_event_kind kind; /* SALTUS_IMPACT, SALTUS_STICK or SALTUS_RELEASE */
    int face;
    double time; /* in periods; base <= time <= base + periods */
    bool driven;
} saltus_mark;

/* Times are in periods from section phase 0; the orbit is cut open at its base. */
typedef struct saltus_sequence {
    int periods;
    double base;       /* in [0, periods), away from events */
    unsigned contacts; /* lasting contacts at the base */
    bool driven;       /* driven from the base to the first mark */
    int count;
    saltus_mark mark[SALTUS_MARKS_MAX];
    int cuts; /* >= 1; cut 0 is the base */
    double cut[SALTUS_CUTS_MAX];
    double
        omega; /* by which a scene without forcing counts an orbit's times; 0: the period is not an unknown */
    /* If omega > 0. `across`, and the flow's `speed` at the anchor, are in scaled units. */
    double anchor[SALTUS_STATE_MAX], across[SALTUS_STATE_MAX], speed;
} saltus_sequence;

typedef enum saltus_breach_kind {
    SALTUS_BREACH_SPEED, /* an impact's speed: value = -speed */
    SALTUS_BREACH_GAP,   /* a local maximum of a gap between events */
    SALTUS_BREACH_FORCE, /* a local maximum of the negative contact force */
    SALTUS_BREACH_HOLD   /* minus the length of a contact interval: value = begin - end */
} saltus_breach_kind;

/* A quantity that is negative for an admissible orbit, in units of the system's scale. */
typedef struct saltus_breach {
    saltus_breach_kind kind;
    double value;
    int mark; /* SPEED, HOLD: its mark (HOLD: the release); otherwise the mark after the piece */
    int face;
    double time;
} saltus_breach;

/* A family of orbits: a specification and up to two directions from it. The parameter unknowns are 0 at the
 * specification, in units of `unit`. Without a direction there is one parameter without effect. */
typedef struct saltus_family {
    saltus_spec spec;
    int parameters; /* 0, 1 or 2 */
    saltus_direction direction[2];
    double unit[2];
} saltus_family;

/* The specification at given parameter unknowns (family->parameters of them), with omega unless that is 0. */
saltus_spec saltus_family_spec(const saltus_family *family, const double *parameters, double omega);
/* A flow, the system made for it (NULL: another's, that of the specification), and the parameters and omega
 * that it has. */
typedef struct saltus_tuned {
    saltus_flow *flow;
    saltus_system *system;
    double at[2], omega;
} saltus_tuned;
/* Give it the system of these parameters and omega, which replaces (and frees) the present one. Errors: no
 * derivative at a parameter, those of saltus_system_new; nothing is changed then. */
saltus_status saltus_family_tune(const saltus_family *family, const double *parameters, double omega,
                                 saltus_tuned *tuned, saltus_message *message);
void saltus_tuned_clear(saltus_tuned *tuned);
/* Number of unknowns, without parameters, of the orbits of a sequence in n dimensions. */
int saltus_sequence_unknowns(const saltus_sequence *sequence, int n);
/* Make the period of a sequence an unknown, with its base at the flow's present state: on the hyperplane of
 * zero observed velocity if `turning`, which also contains rests, otherwise on one across the flow. */
void saltus_sequence_anchor(saltus_sequence *sequence, saltus_flow *flow, bool turning);

/* Derivatives of the state along an orbit by the unknowns of the orbit's equations (`answer`). The orbit is
 * walked in pieces. Over a piece the flow carries n tangent vectors from the identity, A, and the parameter
 * columns from their present values; the matrix of n rows is multiplied by A at the end of each piece. A mark
 * whose time is an unknown adds to the column of that time. */
typedef struct saltus_response {
    int n, unknowns;                  /* rows and columns of `answer` */
    int plain;                        /* number of unknown states and times, which come first */
    int directions;                   /* parameter columns of the flow */
    int place[SALTUS_DIRECTIONS_MAX]; /* the unknown of each direction, -1: none */
    int state, times, passed; /* the columns that have an effect: of the state at the segment's start, from
                                 `state` on, and of the times of the marks passed since, from `times` on */
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

/* Work space for the orbits of a family. Others only read it, apart from the equations. */
typedef struct saltus_shooting {
    /* Set on creation. */
    saltus_family family;
    int n;
    double length, speed, force;          /* scales of gaps, normal speeds, normal accelerations */
    double state_scale[SALTUS_STATE_MAX]; /* of the first system, whatever the parameters */
    saltus_tuned full, bare;              /* with all tangent vectors, and with none */
    /* For the present sequence. */
    saltus_sequence sequence;
    int count; /* number of equations, and of unknowns without parameters */
    /* Continuity and marks. With two parameters there are two more unknowns than equations, one too many for
     * Newton's method. */
    saltus_equations equations;
    saltus_arena arena;
    double *scale;     /* [count]: of the unknowns without the parameters */
    double *plain;     /* unscaled unknowns */
    int speed_mark;    /* whose speed_row is wanted; -1: none */
    double *speed_row; /* see saltus_shooting_speed_row */
    /* For the walks around the orbit. */
    saltus_response response;
    saltus_collection collection;
    saltus_breaches breaches; /* found in the last evaluation, in the units of the scales */
    /* Where the orbit closes, in the last evaluation: the flow's speed across the anchor's hyperplane (0
     * without an anchor), and in all directions, in units of that at the anchor. */
    double onward, flow_speed;
    double steps; /* usual integrator steps per period; 0: not known */
} saltus_shooting;

saltus_status saltus_shooting_new(const saltus_family *family, const saltus_orbit_options *options,
                                  saltus_shooting **shooting, saltus_message *message);
void saltus_shooting_free(saltus_shooting *shooting);
/* Set the sequence. The unknowns are then, in scaled units: the states at the cuts, the times of the marks,
 * the period if it is unknown, the parameters. */
saltus_status saltus_shooting_shape(saltus_shooting *shooting, const saltus_sequence *sequence,
                                    saltus_message *message);

/* Fill the unknowns from the states at the first cuts, so many as are `given`, the base among them; the flow
 * gives those at the others. */
saltus_status saltus_shooting_fill(saltus_shooting *shooting, const double *parameters, const double *states,
                                   int given, double *u, saltus_message *message);
/* The sequence with the event times of `u`, and the state at the base. */
void saltus_shooting_extract(const saltus_shooting *shooting, const double *u, saltus_sequence *sequence,
                             double *state);
/* The unscaled states at the cuts (cuts x dimension), owned by the shooting. */
const double *saltus_shooting_states(saltus_shooting *shooting, const double *u);

/* Where the evaluations from now on put the derivatives of the entry of the Jacobian that is this impact's
 * speed, the derivative of its gap by its time, but for what a change of the period does to a speed that is
 * not zero. For one mark at a time, and until the sequence changes. */
const double *saltus_shooting_speed_row(saltus_shooting *shooting, int mark);

/* Largest growth of a scaled perturbation over a segment, in the last evaluation. */
double saltus_shooting_growth(const saltus_shooting *shooting);
/* From now on each evaluation stores the derivative around the orbit in a cocycle, in short segments; NULL:
 * stop. Has no effect if the period is an unknown. */
void saltus_shooting_collect(saltus_shooting *shooting, saltus_cocycle *cocycle);
/* Whether the cocycle was filled at these unknowns, or at those from which Newton's last step led to them. */
bool saltus_shooting_collected(const saltus_shooting *shooting, const double *u);
/* First of the equations (as many as the dimension) that close the orbit. In their rows of the Jacobian, the
 * -1 on the diagonal of the first columns is the subtracted state at the base. */
int saltus_shooting_closing_row(const saltus_shooting *shooting);
/* The factors of the last evaluation's Jacobian with the parameters fixed, and with so much of each state at
 * the base added in the rows that close the orbit. They are in the equations' work space; solutions have an
 * entry for each unknown. */
saltus_dense_lu *saltus_shooting_factor(saltus_shooting *shooting, double added);

/* For shooting*.c. The omega in the unknowns; 0 if it is not one of them. */
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
