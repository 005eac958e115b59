/* Private: periodic orbits of a prescribed sequence of events, with the event times among the unknowns.
 *
 * The unknowns are the states at the cuts (one cut: single shooting), the times of the marks and the
 * parameter. The equations are continuity around the orbit and one for each mark: zero gap at impacts and
 * sticks, zero force at releases. All of them are smooth in the unknowns, also where the speed of an impact
 * passes through zero, which is why orbits near grazing are found and followed in this form (the literature's
 * "formulation with unknowns at the impacts"). Whether stops are respected between the marks is another
 * question, answered by the extremes collected on the way.
 *
 * A mark may be `driven`: from there to the next mark the flow finds its events itself, as it must through
 * complete chatter. A sequence without marks, driven from its base, is ordinary shooting.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SHOOTING_H
#define SALTUS_ORBIT_SHOOTING_H

#include "saltus/orbit.h"

enum { SALTUS_MARKS_MAX = 192, SALTUS_CUTS_MAX = 32 };

typedef struct saltus_mark {
    saltus_event_kind kind; /* SALTUS_IMPACT, SALTUS_STICK or SALTUS_RELEASE */
    int face;
    double time; /* in periods; base <= time <= base + periods */
    bool driven;
} saltus_mark;

/* Times are counted in periods from section phase 0; the orbit is cut open at its base. */
typedef struct saltus_sequence {
    int periods;
    double base;       /* in [0, periods), away from events */
    unsigned contacts; /* lasting contacts at the base */
    bool driven;       /* from the base to the first mark */
    int count;
    saltus_mark mark[SALTUS_MARKS_MAX];
    int cuts; /* >= 1; cut 0 is the base */
    double cut[SALTUS_CUTS_MAX];
} saltus_sequence;

typedef enum saltus_breach_kind {
    SALTUS_BREACH_SPEED, /* an impact's speed: value = -speed */
    SALTUS_BREACH_GAP,   /* a local maximum of a gap between events */
    SALTUS_BREACH_FORCE, /* a local maximum of minus a holding force */
    SALTUS_BREACH_HOLD   /* what is left of a contact interval, negative: value = begin - end */
} saltus_breach_kind;

/* A quantity that must be negative for the orbit to be admissible, in units of the system's scale. */
typedef struct saltus_breach {
    saltus_breach_kind kind;
    double value;
    int mark; /* SPEED, HOLD: which mark (HOLD: the release); otherwise the mark after the piece */
    int face;
    double time;
} saltus_breach;

typedef struct saltus_shooting saltus_shooting;

/* A workspace for orbits of a specification and those along a direction from it (NULL: parameters fixed).
 * `origin` and `unit`: the parameter unknown is (value - origin) / unit. */
saltus_status saltus_shooting_new(const saltus_spec *spec, const saltus_direction *direction, double origin,
                                  double unit, const saltus_orbit_options *options,
                                  saltus_shooting **shooting, saltus_message *message);
void saltus_shooting_free(saltus_shooting *shooting);
/* Follow another direction, from another specification, with the sequence as it is. */
saltus_status saltus_shooting_redirect(saltus_shooting *shooting, const saltus_spec *spec,
                                       const saltus_direction *direction, double origin, double unit,
                                       saltus_message *message);
/* Take on a sequence: afterwards there are saltus_shooting_unknowns() unknowns, all in scaled units: states
 * at the cuts, times of the marks, parameter. */
saltus_status saltus_shooting_shape(saltus_shooting *shooting, const saltus_sequence *sequence,
                                    saltus_message *message);
const saltus_sequence *saltus_shooting_sequence(const saltus_shooting *shooting);
int saltus_shooting_unknowns(const saltus_shooting *shooting);
const double *saltus_shooting_scale(const saltus_shooting *shooting);
/* The system at the parameter of the last evaluation. */
const saltus_system *saltus_shooting_system(const saltus_shooting *shooting);
double saltus_shooting_value(const saltus_shooting *shooting, const double *u);

/* Put a state at the base into unknowns, the cuts' states following from it by the flow. */
saltus_status saltus_shooting_fill(saltus_shooting *shooting, double value, const double *state, double *u,
                                   saltus_message *message);
/* The sequence with the event times of `u`. */
void saltus_shooting_extract(const saltus_shooting *shooting, const double *u, saltus_sequence *sequence,
                             double *state);

/* The states at the cuts (cuts x dimension, the shooting's own), unscaled. */
const double *saltus_shooting_states(saltus_shooting *shooting, const double *u);

/* Residuals and Jacobian at u. Errors: those of the flow; marks out of order. */
saltus_status saltus_shooting_evaluate(saltus_shooting *shooting, const double *u, saltus_message *message);
double saltus_shooting_residual(const saltus_shooting *shooting);
/* The largest growth of a scaled perturbation over a segment. */
double saltus_shooting_growth(const saltus_shooting *shooting);
/* What the last evaluation saw of the orbit between its marks; `count` entries. */
const saltus_breach *saltus_shooting_breaches(const saltus_shooting *shooting, int *count);

/* The speed towards the stop, as of the last evaluation, of the impact that a mark is. */
double saltus_shooting_speed(const saltus_shooting *shooting, int mark);

/* Newton's iteration from u. With `normal` (length unknowns): on the hyperplane normal . (u - anchor) = 0;
 * NULL: at u's parameter. Damped if asked for. Errors: SALTUS_NO_CONVERGENCE, SALTUS_SINGULAR, the flow's. */
saltus_status saltus_shooting_correct(saltus_shooting *shooting, double *u, const double *normal,
                                      const double *anchor, bool damped, int *iterations,
                                      saltus_message *message);
/* Newton's iteration in all unknowns, the parameter among them, by the shortest steps: for equations that
 * leave directions open. Damped. */
saltus_status saltus_shooting_relax(saltus_shooting *shooting, double *u, int *iterations,
                                    saltus_message *message);
/* Unit tangent of the solution curve at the last evaluated point, with tangent . guide > 0; the determinant
 * of the Jacobian bordered by `guide` as sign and log modulus. */
saltus_status saltus_shooting_tangent(saltus_shooting *shooting, const double *guide, double *tangent,
                                      int *sign, double *log_determinant, saltus_message *message);
/* The determinant of the equations with x(pT) + x(0) in place of x(pT) - x(0): zero where a multiplier is -1,
 * and smooth through grazing. */
void saltus_shooting_flip(saltus_shooting *shooting, int *sign, double *log_determinant);
/* Two orthonormal vectors (2 x unknowns) that belong to the smallest singular values of the Jacobian of the
 * last evaluated point, and these: at a branch point both are zero. */
saltus_status saltus_shooting_null_plane(saltus_shooting *shooting, double *vectors, double values[2],
                                         saltus_message *message);

#endif
