/* Private: the curve of periodic orbits of one sequence of events, and what the event-driven flow says of its
 * points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_SOLUTION_H
#define SALTUS_BRANCH_SOLUTION_H

#include "branch/curve.h"
#include "orbit/multipliers.h"
#include "orbit/shooting.h"
#include "system/system.h"

#include <math.h>
#include <string.h>

/* What the event-driven flow says of an orbit of a prescribed sequence. */
typedef struct saltus_survey {
    bool follows; /* the flow meets the prescribed events and no others */
    bool walked;  /* the flow completed the orbit; false: only `follows` is known */
    saltus_lap lap;
    long long impacts;
    int sticking_intervals;
    char label[SALTUS_LABEL_MAX];
    saltus_multiplier multipliers[SALTUS_STATE_MAX]; /* NAN where not known */
    int multiplier_count, unstable;                  /* of them */
    double trivial; /* trivial multiplier, along the flow, if the period is an unknown */
    double log_volume, sum_rule;
    double circle[3]; /* products of 1 - mu_i and 1 + mu_i over all multipliers, and of mu_i mu_j - 1 over all
                         pairs of them: zero where a multiplier is 1 or -1, or a pair is on the unit circle */
    double past[3], past_place; /* the same at a previous point, and its arclength from here; 0: not known */
} saltus_survey;

/* A point of the curve: an orbit. */
typedef struct saltus_solution {
    saltus_curve_point at;
    saltus_sequence sequence;       /* with the event times of this orbit */
    double state[SALTUS_STATE_MAX]; /* at its base */
    double parameter[2], value;     /* `value` of the first parameter */
    saltus_scaled flip;             /* saltus_orbits_closing, zero where a multiplier is -1 */
    double onward, speed; /* if the period is an unknown: speed of the flow across the anchor's hyperplane,
                             and in all directions, in units of that at the anchor */
    double growth;        /* greatest growth of perturbations over a segment */
    saltus_breach *breaches;
    int breach_count, breach_room;
    saltus_breach worst; /* the greatest; value -1 if none is greater */
    double grazes_ahead; /* arclength to where the slowest impact loses its speed, as its square has fallen
                            since the point before; 0: it has not, or that is not known */
    saltus_survey survey;
} saltus_solution;

/* The orbits of a family, with all that is needed to compute them. */
typedef struct saltus_orbits {
    saltus_family family;
    double origin; /* value of the first parameter where its unknown is 0 */
    saltus_orbit_options options;
    saltus_shooting *shooting;
    saltus_equations *equations; /* the shooting's */
    saltus_system *system;       /* of the flows */
    saltus_flow *flow, *tangent; /* event-driven, without and with tangent vectors */
    saltus_cocycle cocycle;
    bool collects; /* the shooting can fill `cocycle` as it goes */
    gsl_root_fsolver *solver;
    int n;
    bool starved; /* memory was lacking, perhaps only for an attempt */
} saltus_orbits;

/* A special point, at arclength `ahead` of a solution, and the accuracy of the parameter there. */
typedef struct saltus_zero {
    bool found;
    double ahead, accuracy;
} saltus_zero;

/* Close in any case. */
saltus_status saltus_orbits_open(saltus_orbits *orbits, saltus_message *message);
/* The same orbits, of a flow of another tolerance: what differs is the flow's error. */
saltus_status saltus_orbits_open_other(const saltus_orbits *orbits, saltus_orbits *other);
/* What another flow, or a few points, tell of errors counts so many times: they may by chance differ by less.
 */
static const double saltus_cautious = 4;
void saltus_orbits_close(saltus_orbits *orbits);
/* Note if a status says that memory was lacking, and return it. Failures of mere attempts are passed over,
 * but not this one: the run ends with the step. */
saltus_status saltus_orbits_noted(saltus_orbits *orbits, saltus_status status);

/* The parameter unknown at a border of the range of a parameter with this origin and unit. Its value is never
 * beyond the border, not even by rounding: the parameter's domain may end there. `side`: 0 low, 1 high. */
double saltus_orbits_border(double origin, double unit, double border, int side);
/* Retune the event-driven flows to these parameters, and to a sequence's omega. */
saltus_status saltus_orbits_tune(saltus_orbits *orbits, const double *parameters, double omega,
                                 saltus_message *message);

/* Free the arrays. A zeroed one is accepted. */
void saltus_solution_clear(saltus_solution *solution);
/* The tangent's component in the parameter. */
double saltus_solution_heading(const saltus_solution *solution);
/* Reverse the tangent if its component in the parameter has not the sign of `heading`. */
void saltus_solution_head(saltus_solution *solution, double heading);
/* `out` becomes the orbit of a sequence from a state at its base, polished by Newton's method at these
 * parameters or only evaluated. With one parameter it gets a tangent, of either sign; it is not surveyed. The
 * shooting takes on the sequence. */
saltus_status saltus_solution_place(saltus_orbits *orbits, const saltus_sequence *sequence,
                                    const double *parameters, const double *state, bool polish,
                                    saltus_solution *out, saltus_message *message);
/* The same from the states at all cuts (cuts x n): where errors of the flow grow much along the orbit, the
 * state at its base does not tell them. */
saltus_status saltus_solution_restore(saltus_orbits *orbits, const saltus_sequence *sequence,
                                      const double *parameters, const double *states, bool polish,
                                      saltus_solution *out, saltus_message *message);
/* The shooting takes on the sequence of a solution again, after attempts with others. */
void saltus_orbits_reshape(saltus_orbits *orbits, const saltus_solution *solution);
/* For an orbit whose period is an unknown: that period; and the scaled distance that it would move in it at
 * the speed at its base. */
double saltus_solution_period(const saltus_solution *solution);
double saltus_solution_way(const saltus_solution *solution);
/* Whether an orbit whose period is an unknown is really an equilibrium, which closes after any time: it
 * hardly moves, absolutely or compared with an orbit `near` it (may be NULL). */
bool saltus_solution_rests(const saltus_solution *solution, const saltus_solution *near);
/* The determinant of the equations last evaluated by a shooting at fixed parameters: zero at a fold. `flips`:
 * for an orbit that closes on minus its beginning, zero at a flip, and smooth through grazing. */
saltus_scaled saltus_orbits_closing(saltus_shooting *shooting, bool flips);
/* Fill in everything but tangent and survey from the shooting's last evaluation, at out->at.u. */
saltus_status saltus_solution_see(saltus_orbits *orbits, saltus_solution *out, saltus_message *message);
/* The point of the curve at arclength `ahead` from another. False if there is no such point near. */
bool saltus_solution_visit(saltus_orbits *orbits, const saltus_solution *from, double ahead,
                           saltus_solution *out);
/* The breach of the slowest prescribed impact; NULL: there is none. */
const saltus_breach *saltus_solution_slowest(const saltus_solution *solution);
/* Predict where the slowest impact of `s` loses its speed from a point before, of the same sequence, that is
 * s->at.ahead behind. */
void saltus_solution_expect_grazing(saltus_solution *s, const saltus_solution *before);
/* The point of the curve where the slowest impact of another loses its speed, by an equation of its own, and
 * how accurately the parameter is known. Not found: Newton's method does not converge at once. */
saltus_zero saltus_solution_graze(saltus_orbits *orbits, const saltus_solution *from, saltus_solution *out);
/* Let the event-driven flow go around a solution that has the shooting's sequence. False if there is no flow
 * at its parameters. */
bool saltus_solution_walk(saltus_orbits *orbits, saltus_solution *solution);
/* Once around an orbit whose period is an unknown, from return to return (orbit/poincare.h). False if the
 * flow fails. */
bool saltus_cycle_around(saltus_orbits *orbits, const saltus_solution *solution, saltus_lap *lap);
/* `lap`, which the caller closes, gets all section points of a surveyed orbit, with forcing from the first
 * one, `point`, on. False: they are not known. */
bool saltus_solution_section(saltus_orbits *orbits, const saltus_solution *solution, const double *point,
                             saltus_lap *lap);
/* The least period of a surveyed orbit with forcing that is in flight at times, in periods; that of its
 * sequence if it cannot be told. */
int saltus_solution_least_period(saltus_orbits *orbits, const saltus_solution *solution);
/* The label of a surveyed solution: n/p, where p is the number of returns if the period is an unknown; "" if
 * it was not surveyed or these are not known. */
void saltus_solution_label(saltus_orbits *orbits, const saltus_solution *solution,
                           char label[SALTUS_LABEL_MAX]);
/* Walk, and compute the multipliers on the way. */
saltus_status saltus_solution_survey(saltus_orbits *orbits, saltus_solution *solution,
                                     saltus_message *message);
/* Note what a survey tells of the point before, at arclength `place` from its own. */
static inline void saltus_survey_follow(saltus_survey *survey, const saltus_survey *past, double place) {
    memcpy(survey->past, past->circle, sizeof survey->past);
    survey->past_place = place;
}
/* The number of prescribed impacts, and the scaled speeds of the slowest and the fastest; without any
 * INFINITY and -INFINITY. */
int saltus_solution_speed_range(const saltus_solution *solution, double *slowest, double *fastest);
/* The speeds towards the stop of the impacts among the marks; 0 for other marks. */
void saltus_solution_speeds(const saltus_orbits *orbits, const saltus_solution *solution, double *speed);
/* The state at `time` through the prescribed events. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_solution_state_at(saltus_orbits *orbits, const saltus_solution *solution, double time,
                                       double *state, saltus_message *message);
/* The states at the cuts of another sequence of the same orbit, of part of its period or of several times it
 * (cuts x n), which the caller frees in any case; each from the last cut before: errors of the flow may grow
 * too much from the base. Errors: as above. */
saltus_status saltus_solution_states_at(const saltus_orbits *orbits, const saltus_solution *solution,
                                        const saltus_sequence *cut, double **states, saltus_message *message);
/* Cut such a sequence, with the same base, like the solution; where errors grow much in one orbit, one of
 * several times it at each of these, or at some. */
void saltus_solution_cuts(const saltus_solution *solution, saltus_sequence *cut);
/* Cut the orbit open elsewhere, into more segments, or with fewer marks (`trims`), if that is better
 * (sequence.h), or if it `leaves` a base that is about to touch a stop. `scratch` is overwritten. order
 * (SALTUS_MARKS_MAX entries; may be NULL): the former index of each mark. False: solution and shooting are as
 * before. */
bool saltus_solution_reframe(saltus_orbits *orbits, bool trims, bool leaves, saltus_solution *solution,
                             saltus_solution *scratch, int *order);
/* The same with more segments: for orbits along which perturbations grow and shrink again, which the growth
 * over a segment does not show. False: there are not more, though the base may have moved. */
bool saltus_solution_refine(saltus_orbits *orbits, saltus_solution *solution, saltus_solution *scratch,
                            int *order);
/* Whether the base of the orbit last evaluated by the shooting, whose period is an unknown, lies beyond a
 * stop. */
bool saltus_solution_base_beyond(const saltus_orbits *orbits, const saltus_solution *solution);

/* A separate shooting for another sequence of a solution (as for saltus_solution_states_at), which the caller
 * frees in any case, and the solution's unknowns, in its equations' `trial`; orbits->shooting stays as it is.
 * Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_orbits_shoot(const saltus_orbits *orbits, const saltus_solution *at,
                                  const saltus_sequence *sequence, saltus_shooting **shooting,
                                  saltus_message *message);
/* The same, and evaluate its equations there. */
saltus_status saltus_orbits_evaluate(const saltus_orbits *orbits, const saltus_solution *at,
                                     const saltus_sequence *sequence, saltus_shooting **shooting,
                                     saltus_message *message);
/* The scaled distance of an orbit from one that closes after one of `parts` equal parts of the period,
 * INFINITY unless these are whole periods; 1: from one that is its own mirror image, half a period later. The
 * scaled difference goes to `apart` (n; may be NULL) if it is known. */
double saltus_solution_part_distance(saltus_orbits *orbits, const saltus_solution *solution, int parts,
                                     double *apart);
/* Whether a curve, or branch, joins at an orbit those of half the period or such that are their own mirror
 * images: from the distances from these, as above, `before` at an orbit and `apart` at the one that is so far
 * `ahead` of it. They fall evenly to nothing at the join, where the equations are singular: orbits as close
 * as the cube root of their residual cannot be told from it. */
bool saltus_orbits_join(const saltus_orbits *orbits, double before, double apart, double ahead);
/* The breach of a grazing orbit that makes the change. A maximum of the gap at an impact of zero speed is
 * that impact's own touch; and where impacts die just as the orbit touches elsewhere, so that rounding
 * decides which breach is the worst, it is a death. */
const saltus_breach *saltus_solution_touch(const saltus_solution *at);

/* The logarithm of the modulus of the pair of complex multipliers that is closest to the unit circle;
 * INFINITY if there is none. */
double saltus_pair_off_circle(const saltus_survey *survey);

/* Functions whose zeros along a branch are special points. */
typedef enum saltus_test {
    SALTUS_TEST_FOLD,     /* the tangent's component in the parameter */
    SALTUS_TEST_FLIP,     /* `flip` */
    SALTUS_TEST_CROSSING, /* `crossing` */
    SALTUS_TEST_PAIR,     /* `pair` of the survey */
    SALTUS_TEST_BREACH,
    SALTUS_TEST_ONWARD, /* `onward` */
    SALTUS_TEST_VALUE   /* parameter minus a target */
} saltus_test;

/* The value of a test at a solution; determinants in units of that at `from`. */
double saltus_test_value(saltus_test test, double target, const saltus_solution *solution,
                         const saltus_solution *from);
/* The zero of a test between `from` and `to`; `out` becomes the point there. */
saltus_zero saltus_solution_zero(saltus_orbits *orbits, saltus_test test, double target,
                                 const saltus_solution *from, const saltus_solution *to,
                                 saltus_solution *out);
/* The same between two places ahead of `from`, with the test's values there; `to` (may be NULL) is the point
 * at the second one. */
saltus_zero saltus_solution_zero_between(saltus_orbits *orbits, saltus_test test, double target,
                                         const saltus_solution *from, const saltus_solution *to,
                                         const double ends[2], const double values[2], saltus_solution *out);
/* `out` becomes the point near `ahead` of `from` where curves cross: the zero of the test CROSSING or, at an
 * equilibrium, ONWARD; `reach` as for saltus_curve_crossing. */
saltus_zero saltus_solution_crossing(saltus_orbits *orbits, saltus_test by, const saltus_solution *from,
                                     double ahead, double reach, saltus_solution *out);

#endif
