/* Private: the curve of periodic orbits of one sequence of events, and what the event-driven flow makes of
 * its points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_SOLUTION_H
#define SALTUS_BRANCH_SOLUTION_H

#include "branch/curve.h"
#include "orbit/multipliers.h"
#include "orbit/shooting.h"

#include <math.h>

/* What the event-driven flow makes of an orbit of a prescribed sequence. */
typedef struct saltus_survey {
    bool follows; /* the flow meets the events that are prescribed, and no others */
    bool walked;  /* the flow came around; false: nothing but `follows` is known */
    saltus_lap lap;
    long long impacts;
    int sticking_intervals;
    char label[SALTUS_LABEL_MAX];
    saltus_multiplier *multipliers; /* NAN where not known */
    int multiplier_count, unstable; /* of them */
    double trivial;                 /* multiplier along the flow, of orbits whose period is an unknown */
    double log_volume, sum_rule;
    double pair; /* product over all pairs of multipliers of mu_i mu_j - 1: zero where a pair is on the unit
                    circle */
} saltus_survey;

/* A point of the curve: an orbit. */
typedef struct saltus_solution {
    saltus_curve_point at;
    saltus_sequence sequence;   /* with the event times of this orbit */
    double *state;              /* at its base */
    double parameter[2], value; /* `value` of the first parameter */
    saltus_scaled flip;   /* determinant of the equations with x(pT) + x(0) for x(pT) - x(0): zero where a
                             multiplier is -1, and smooth through grazing */
    double onward, speed; /* of a period of its own: the flow's speed across the anchor, and in all
                             directions, in units of that there */
    double growth;        /* of perturbations over a segment, at most */
    saltus_breach *breaches;
    int breach_count, breach_room;
    saltus_breach worst; /* of them; value at least -1 */
    saltus_survey survey;
} saltus_solution;

/* The orbits of a family, with all that is needed to compute them. */
typedef struct saltus_orbits {
    saltus_family family;
    double origin; /* of the first parameter */
    saltus_orbit_options options;
    saltus_shooting *shooting;
    saltus_equations *equations; /* the shooting's */
    saltus_system *system;       /* of the flows */
    saltus_flow *flow, *tangent; /* event-driven, without and with tangent vectors */
    saltus_cocycle cocycle;
    bool collects; /* the shooting can fill it on the way */
    gsl_root_fsolver *solver;
    int n;
    bool starved; /* memory was lacking, be it for something that was only tried */
} saltus_orbits;

/* Close in any case. */
saltus_status saltus_orbits_open(saltus_orbits *orbits, saltus_message *message);
void saltus_orbits_close(saltus_orbits *orbits);
/* Note whether a status tells that memory was lacking, and return it. Where failures of what is only tried
 * are passed over, that one must not be: the run ends with the step. */
saltus_status saltus_orbits_noted(saltus_orbits *orbits, saltus_status status);

/* The parameter unknown at which a parameter with this origin and unit meets a border of its range, from
 * within: never beyond it by a rounding, as the parameter's domain may end there. `side`: 0 low, 1 high. */
double saltus_orbits_border(double origin, double unit, double border, int side);
/* The system of the event-driven flows becomes that of parameters, and of a sequence's omega. */
saltus_status saltus_orbits_tune(saltus_orbits *orbits, const double *parameters, double omega,
                                 saltus_message *message);

void saltus_solution_clear(saltus_solution *solution);
/* The parameter's share of the tangent. */
double saltus_solution_heading(const saltus_solution *solution);
/* Turn the tangent round if the parameter does not go the way that `heading` has the sign of. */
void saltus_solution_head(saltus_solution *solution, double heading);
/* An orbit of a sequence from a state at its base becomes `out`; polished at these parameters, or only
 * evaluated. With one parameter it has a tangent, of either sign; it is not surveyed. The shooting takes on
 * the sequence. */
saltus_status saltus_solution_place(saltus_orbits *orbits, const saltus_sequence *sequence,
                                    const double *parameters, const double *state, bool polish,
                                    saltus_solution *out, saltus_message *message);
/* How far an orbit of a period of its own moves in its period at the speed that it has at its base, scaled.
 */
double saltus_solution_way(const saltus_solution *solution);
/* Whether an orbit of a period of its own is none, but an equilibrium, which closes after any time: how far
 * it moves is nothing, or nothing beside what another one near it does (NULL: none). */
bool saltus_solution_rests(const saltus_solution *solution, const saltus_solution *near);
/* Whether a solution is one of the sequence that the shooting has. */
bool saltus_solution_fits(const saltus_orbits *orbits, const saltus_solution *solution);
/* Fill in what the shooting has just seen at out->at.u: all but the tangent and the survey. */
saltus_status saltus_solution_see(saltus_orbits *orbits, saltus_solution *out, saltus_message *message);
/* The point of the curve at arclength `ahead` from another. Errors: no such point near. */
saltus_status saltus_solution_visit(saltus_orbits *orbits, const saltus_solution *from, double ahead,
                                    saltus_solution *out, saltus_message *message);
/* Let the event-driven flow go around a solution that has the shooting's sequence. */
saltus_status saltus_solution_walk(saltus_orbits *orbits, saltus_solution *solution, saltus_message *message);
/* Once around an orbit of a period of its own, from return to return (orbit/poincare.h). Errors: those of the
 * flow, SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_around(saltus_orbits *orbits, const saltus_solution *solution, saltus_lap *lap,
                                  saltus_message *message);
/* What a solution that has been surveyed is called: n/p, with the returns of one of a period of its own; ""
 * where it has not. */
void saltus_solution_label(saltus_orbits *orbits, const saltus_solution *solution,
                           char label[SALTUS_LABEL_MAX]);
/* Walk, and multipliers on the way. */
saltus_status saltus_solution_survey(saltus_orbits *orbits, saltus_solution *solution,
                                     saltus_message *message);
/* A survey made of one solution holds for another. */
void saltus_survey_swap(saltus_solution *a, saltus_solution *b);
/* The speeds towards the stop of the impacts that the marks are; 0 for releases. */
void saltus_solution_speeds(const saltus_orbits *orbits, const saltus_solution *solution, double *speed);
/* The state at a time from the solution's base on, up to one orbit later, through the prescribed events.
 * Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_solution_state_at(saltus_orbits *orbits, const saltus_solution *solution, double time,
                                       double *state, saltus_message *message);
/* The smallest force of a contact over an orbit in contact all the time, as the flow's; NAN for any other.
 * Errors: those of the flow. */
saltus_status saltus_solution_contact_force(saltus_orbits *orbits, const saltus_solution *solution,
                                            double *force, saltus_message *message);
/* Cut the orbit open elsewhere, into more segments, or with fewer marks, where that is better (sequence.h),
 * or where it `leaves` a base that is about to touch a stop; `scratch` is overwritten. order
 * (SALTUS_MARKS_MAX entries; may be NULL): where the marks stood before. False: it is as it was, and so is
 * the shooting.
 */
bool saltus_solution_reframe(saltus_orbits *orbits, bool trims, bool leaves, saltus_solution *solution,
                             saltus_solution *scratch, int *order);
/* The same, if more segments can be had: for orbits along which perturbations grow and shrink again, which
 * the growth over a segment does not show. */
bool saltus_solution_refine(saltus_orbits *orbits, saltus_solution *solution, saltus_solution *scratch);
/* Whether the base of the orbit that the shooting has last evaluated, which has a period of its own, is
 * beyond a stop. */
bool saltus_solution_base_beyond(const saltus_orbits *orbits, const saltus_solution *solution);

/* A shooting of its own for a sequence, and its unknowns at a state at the base: the solution's shooting
 * stays as it is. The caller's, to be freed in any case. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_orbits_shoot(const saltus_orbits *orbits, const saltus_sequence *sequence,
                                  const double *parameters, const double *state, saltus_shooting **shooting,
                                  double **u, saltus_message *message);
/* How far an orbit of an even period is from closing after half of it, scaled; INFINITY for an odd one.
 * `mirrored`: from being its own mirror image. */
double saltus_solution_half_distance(saltus_orbits *orbits, const saltus_solution *solution, bool mirrored);
/* The same, and by what it is `apart` (n), scaled, where that is finite. */
double saltus_solution_halves(saltus_orbits *orbits, const saltus_solution *solution, bool mirrored,
                              double *apart);
/* Whether a complex pair of multipliers is on the unit circle, not two real ones whose product is 1. */
bool saltus_pair_on_circle(const saltus_survey *survey);

/* Functions whose zeros along a branch are special points. */
typedef enum saltus_test {
    SALTUS_TEST_FOLD,     /* the parameter's share of the tangent */
    SALTUS_TEST_FLIP,     /* `flip` */
    SALTUS_TEST_CROSSING, /* `crossing` */
    SALTUS_TEST_PAIR,     /* `pair` of the survey */
    SALTUS_TEST_BREACH,   /* the worst breach */
    SALTUS_TEST_ONWARD,   /* `onward` */
    SALTUS_TEST_VALUE     /* parameter minus a target */
} saltus_test;

/* Where a test function is zero between a solution and one further on, and how sharp that is in the
 * parameter.
 */
typedef struct saltus_zero {
    bool found;
    double ahead, accuracy;
} saltus_zero;

/* The value of a test at a solution, determinants in units of those at another. */
double saltus_test_value(saltus_test test, double target, const saltus_solution *solution,
                         const saltus_solution *from);
/* The zero of a test between `from` and `to`; `out` becomes the point there. */
saltus_zero saltus_solution_zero(saltus_orbits *orbits, saltus_test test, double target,
                                 const saltus_solution *from, const saltus_solution *to,
                                 saltus_solution *out);
/* The same between two places ahead of `from`, with the values of the test there. */
saltus_zero saltus_solution_zero_between(saltus_orbits *orbits, saltus_test test, double target,
                                         const saltus_solution *from, const double ends[2],
                                         const double values[2], saltus_solution *out);
/* So near to where equations are singular, their solutions are told no better than this. */
static inline double saltus_rounding_at(double apart) {
    return 1e-14 / fabs(apart);
}
/* The point where curves cross near `ahead` from `from`, as `out`, where a test is zero, CROSSING or, at an
 * equilibrium, ONWARD: its equations are singular, so it is
 * interpolated from points around it, not further than a tenth of `reach`. */
saltus_zero saltus_solution_crossing(saltus_orbits *orbits, saltus_test by, const saltus_solution *from,
                                     double ahead, double reach, saltus_solution *out);

#endif
