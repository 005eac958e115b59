/* Private: periodic orbits of a prescribed sequence of events, with the event times among the unknowns.
 *
 * The unknowns are the states at the cuts (one cut: single shooting), the times of the marks and the
 * parameter. The equations are continuity around the orbit and one for each mark: zero gap at impacts and
 * sticks, zero force at releases. All of them are smooth in the unknowns, also where the speed of an impact
 * passes through zero, which is why orbits near grazing are found and followed in this form (the literature's
 * "formulation with unknowns at the impacts"). Whether stops are respected between the marks is another
 * question, answered by the extremes collected on the way.
 *
 * Where the scene is not forced the period is an unknown too, by the logarithm of its ratio to the family's,
 * and one more equation says where on the orbit its base is: on the hyperplane through `anchor`
 * that `across` is normal to.
 *
 * A mark may be `driven`: from there to the next mark the flow finds its events itself, as it must through
 * complete chatter. A sequence without marks, driven from its base, is ordinary shooting.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SHOOTING_H
#define SALTUS_ORBIT_SHOOTING_H

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
    double
        omega; /* with which a scene without forcing counts the orbit's times; 0: the period is no unknown */
    /* With omega; `across` and the flow's `speed` at the anchor in scaled units. */
    double anchor[SALTUS_STATE_MAX], across[SALTUS_STATE_MAX], speed;
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

/* What the orbits are orbits of: a specification and one or two directions from it. The parameter unknowns
 * are 0 at the specification, in units of `unit`. Without a direction there is one parameter, which does
 * nothing. */
typedef struct saltus_family {
    saltus_spec spec;
    int parameters; /* 0, 1 or 2 */
    saltus_direction direction[2];
    double unit[2];
} saltus_family;

/* The specification at values of the parameter unknowns (as many as there are parameters), and with a
 * sequence's omega where that is not 0. */
saltus_spec saltus_family_spec(const saltus_family *family, const double *parameters, double omega);
/* A flow's system becomes that one, `*system` is freed and becomes it too, and `at` the parameters. Errors: a
 * parameter at which there is no derivative, those of saltus_system_new; all is then as it was. */
saltus_status saltus_family_tune(const saltus_family *family, const double *parameters, double omega,
                                 saltus_flow *flow, saltus_system **system, double *at,
                                 saltus_message *message);
/* How many unknowns the orbits of a sequence in n dimensions have, but for the parameters. */
int saltus_sequence_unknowns(const saltus_sequence *sequence, int n);
/* The period of a sequence becomes an unknown, its base lies where the flow now is: on the hyperplane on
 * which the observed velocity is zero, where `turning`, which rests lie on too; otherwise on one across the
 * flow. */
void saltus_sequence_anchor(saltus_sequence *sequence, saltus_flow *flow, bool turning);

/* A workspace for the orbits of a family. */
saltus_status saltus_shooting_new(const saltus_family *family, const saltus_orbit_options *options,
                                  saltus_shooting **shooting, saltus_message *message);
void saltus_shooting_free(saltus_shooting *shooting);
/* Take on a sequence: afterwards the unknowns are, all in scaled units, the states at the cuts, the times of
 * the marks, the period's where it is one, the parameters. */
saltus_status saltus_shooting_shape(saltus_shooting *shooting, const saltus_sequence *sequence,
                                    saltus_message *message);
/* The equations of the sequence: continuity and the marks. With two parameters there are two unknowns more
 * than equations, which is one too many for Newton's method. */
saltus_equations *saltus_shooting_equations(saltus_shooting *shooting);
const saltus_sequence *saltus_shooting_sequence(const saltus_shooting *shooting);
/* Of the unknowns but for the parameters. */
const double *saltus_shooting_scale(const saltus_shooting *shooting);
/* The system at the parameters of the last evaluation. */
const saltus_system *saltus_shooting_system(const saltus_shooting *shooting);

/* Put a state at the base into unknowns, the cuts' states following from it by the flow. */
saltus_status saltus_shooting_fill(saltus_shooting *shooting, const double *parameters, const double *state,
                                   double *u, saltus_message *message);
/* The sequence with the event times of `u`, and the state at the base. */
void saltus_shooting_extract(const saltus_shooting *shooting, const double *u, saltus_sequence *sequence,
                             double *state);
/* The states at the cuts (cuts x dimension, the shooting's own), unscaled. */
const double *saltus_shooting_states(saltus_shooting *shooting, const double *u);

/* The largest growth of a scaled perturbation over a segment, at the last evaluation. */
double saltus_shooting_growth(const saltus_shooting *shooting);
/* The speed of the flow across the anchor's hyperplane where the orbit closes, in units of that at the
 * anchor, at the last evaluation, 0 without an anchor; and its *speed in all directions. */
double saltus_shooting_onward(const saltus_shooting *shooting, double *speed);
/* From now on each evaluation of the equations puts the derivative around the orbit into a cocycle, in short
 * segments; NULL: no longer. Not where the period is an unknown. */
void saltus_shooting_collect(saltus_shooting *shooting, saltus_cocycle *cocycle);
/* Whether a cocycle has been filled so at these unknowns, or at those that Newton's last step led to them. */
bool saltus_shooting_collected(const saltus_shooting *shooting, const double *u);
/* What the last evaluation saw of the orbit between its marks; `count` entries. */
const saltus_breach *saltus_shooting_breaches(const saltus_shooting *shooting, int *count);
/* The scale of normal speeds, in which breaches give them. */
double saltus_shooting_speed_scale(const saltus_shooting *shooting);
/* The first of the equations (as many as the dimension) that close the orbit: in their rows of the Jacobian,
 * -1 on the diagonal of the first columns is the state at the base, which is subtracted. */
int saltus_shooting_closing_row(const saltus_shooting *shooting);
/* The determinant of the equations with x(pT) + x(0) in place of x(pT) - x(0), the one parameter fixed: zero
 * where a multiplier is -1, and smooth through grazing. */
void saltus_shooting_flip(saltus_shooting *shooting, int *sign, double *log_determinant);

#endif
