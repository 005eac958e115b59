/* Private to the files branch*.c: the state of a continuation.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_BRANCH_PRIVATE_H
#define SALTUS_ORBIT_BRANCH_PRIVATE_H

#include "orbit/sequence.h"
#include "saltus/branch.h"

/* Values of the parameter that may be asked for. */
enum { SALTUS_BRANCH_VALUES_MAX = 1000 };

/* Functions whose zeros along a branch are special points. */
typedef enum saltus_test {
    SALTUS_TEST_FOLD,   /* the parameter's share of the tangent */
    SALTUS_TEST_FLIP,   /* determinant of the equations with x(pT) + x(0) instead of x(pT) - x(0) */
    SALTUS_TEST_PAIR,   /* product of mu_i mu_j - 1 over all pairs */
    SALTUS_TEST_BRANCH, /* determinant of the Jacobian bordered by the step's direction */
    SALTUS_TEST_BREACH, /* the largest breach */
    SALTUS_TEST_VALUE,  /* parameter minus `target` */
    SALTUS_TESTS
} saltus_test;

/* A point on the solution curve. */
typedef struct saltus_solution {
    int unknowns, room;
    double *u, *tangent;
    double ahead; /* arclength from the anchor */
    int iterations;
    double residual;
    double test[SALTUS_TESTS];
    saltus_breach worst;
    bool follows; /* the event-driven flow follows the sequence */
    saltus_multiplier *multipliers;
    double log_volume, sum_rule;
    int unstable;
} saltus_solution;

/* Where a branch begins. */
typedef struct saltus_branch_start {
    saltus_sequence sequence;
    double value;
    double *state;   /* at the base */
    double *tangent; /* NULL: heads where `heading` says */
    int unknowns;
    int heading, parent, depth;
    bool grazes; /* doubled at grazing: the impact without speed in one half only */
    bool locus;  /* the first point of a locus, with its inner tangent */
    int mark;    /* of grazing: the impact that has no speed */
} saltus_branch_start;

/* A curve of special points in the plane of two parameters, in units of their ranges. The orbits along a line
 * across it form an inner branch, on which the special point is found. */
typedef struct saltus_locus {
    bool on;
    saltus_direction direction[2];
    saltus_spec spec; /* as the run began */
    double origin[2], unit[2];
    double plane[2], tangent[2], normal[2];
    double first[2], first_way[2]; /* the first point, and the way taken from it */
    double *before; /* unknowns of the last point but one, `stride` from the last; NULL: none */
    double *inner;  /* tangent of the inner branch */
    double stride;
    int mark, made;
    bool edge; /* the next point lies on the border of the range */
} saltus_locus;

struct saltus_branch {
    saltus_branch_options options;
    saltus_spec spec; /* as the run began */
    saltus_direction direction;
    double origin, unit;
    saltus_shooting *shooting;
    saltus_flow *flow;     /* event-driven, without tangent vectors */
    saltus_system *system; /* of the flow */
    saltus_lap lap;
    int n;
    const volatile sig_atomic_t *stop; /* asked for between steps, never within one */
    saltus_branch_start *starts;
    int start_count, start_next;
    saltus_solution here, next, trial;
    double target, reference[2];       /* of VALUE; log moduli of the determinants at the step's begin */
    double step, arclength, shown;     /* `shown`: arclength of the last regular point given out */
    char last_label[SALTUS_LABEL_MAX]; /* of the last accepted point */
    long long last_impacts;
    int last_sticks;
    bool fresh; /* no step made since the branch was switched to */
    int number, parent, depth, points;
    double *first; /* the first orbit's points at section phase 0 (first_count of them) and its parameter */
    int first_count;
    double first_value;
    int made; /* points given out on this branch, special ones too */
    bool tail_changed;
    bool running;
    bool starved;               /* memory was lacking, be it for something that was only tried */
    double *state;              /* n */
    saltus_branch_point *queue; /* points made but not yet given out */
    int queue_count, queue_next, queue_room;
    saltus_branch_point given;
    saltus_locus locus;
};

/* branch_visit.c */
/* Note whether a status tells that memory was lacking, and return it. Where failures of what is only tried
 * are passed over, that one must not be: the run ends with the step. */
saltus_status saltus_branch_noted(saltus_branch *b, saltus_status status);
bool saltus_solution_room(saltus_solution *solution, int unknowns, int dimension);
void saltus_solution_clear(saltus_solution *solution);
/* branch.c */
void saltus_solution_swap(saltus_solution *a, saltus_solution *c);
/* Turn the tangent round where `sense` is negative. */
void saltus_solution_point(saltus_solution *solution, double sense);
/* The point of the curve on the hyperplane at arclength `ahead` from `here`. Errors: no such point near. */
saltus_status saltus_branch_visit(saltus_branch *b, double ahead, saltus_solution *out,
                                  saltus_message *message);
/* The tests of a solution that the shooting has just evaluated. */
saltus_status saltus_branch_test(saltus_branch *b, saltus_solution *out, saltus_message *message);
/* The system of the event-driven flow becomes that of a parameter value. */
saltus_status saltus_branch_tune(saltus_branch *b, double value, saltus_message *message);
/* Let the event-driven flow judge a solution. */
saltus_status saltus_branch_walk(saltus_branch *b, saltus_solution *solution, saltus_message *message);
/* Walk, and multipliers. */
saltus_status saltus_branch_survey(saltus_branch *b, saltus_solution *solution, saltus_message *message);
/* How far an orbit of an even period is from closing after half of it, scaled; INFINITY for an odd one.
 * Leaves another lap behind. */
double saltus_branch_half_distance(saltus_branch *b, const saltus_solution *solution, bool mirrored);
/* The zero of a test between `here` and `ahead`, at which the test has the value `far`; `trial` becomes the
 * point there. False if it cannot be had. */
bool saltus_branch_locate(saltus_branch *b, saltus_test test, double ahead, double far, double *accuracy);
/* The point where branches cross near `ahead`, as `trial`: its equations are singular, so it is interpolated
 * from points around it. */
bool saltus_branch_crossing(saltus_branch *b, double ahead, double *accuracy);
/* Whether a complex pair of multipliers is on the unit circle, not two real ones whose product is 1. */
bool saltus_branch_pair_on_circle(const saltus_branch *b, const saltus_solution *solution);

/* branch_point.c */
/* Put a surveyed solution into the queue. */
saltus_status saltus_branch_emit(saltus_branch *b, const saltus_solution *solution, saltus_point_kind kind,
                                 double accuracy, const char *after, const char *reason,
                                 saltus_message *message);
/* The same as the last point of its branch. */
saltus_status saltus_branch_end(saltus_branch *b, const saltus_solution *solution, double accuracy,
                                const char *reason, saltus_message *message);
void saltus_branch_point_clear(saltus_branch_point *point);
/* Forget the points not yet given out. */
void saltus_branch_drop_queue(saltus_branch *b);
/* Keep the label of the walk just made as the last one. */
void saltus_branch_remember(saltus_branch *b);

/* branch_frame.c */
/* Take on a sequence and put `here` on it, with a tangent of either sign; polished at this parameter, or only
 * evaluated. */
saltus_status saltus_branch_place(saltus_branch *b, const saltus_sequence *sequence, double value,
                                  const double *state, bool polish, saltus_message *message);
/* Move the base of `here` to the middle of the longest flight when an event comes near it, and cut the orbit
 * into more segments when perturbations grow too much over one. `tracked` (may be NULL) is a mark whose index
 * follows; *changed says whether the unknowns are others now. */
saltus_status saltus_branch_reframe(saltus_branch *b, int *tracked, bool *changed, saltus_message *message);

/* branch_switch.c */
/* Keep a start, to be begun at later. */
saltus_status saltus_branch_add_start(saltus_branch *b, const saltus_branch_start *start,
                                      saltus_message *message);
/* Keep the special point at `trial` as the first one of a locus; `mark` for grazing, else -1. */
saltus_status saltus_branch_capture(saltus_branch *b, int mark, saltus_message *message);
/* The start of a branch of twice the period at a grazing point, with an impact more in one of its halves:
 * `more` and `less` are the sequences on the two sides of grazing. */
saltus_status saltus_branch_switch_grazing(saltus_branch *b, const saltus_sequence *more,
                                           const saltus_sequence *less, double value, double *state,
                                           saltus_message *message);
/* Where `trial` joins the orbits of half the period its equations are singular: the flip's place on the
 * branch of half the period. False if there is none near. */
bool saltus_branch_flip_of_half(saltus_branch *b, double *value, double *accuracy);
/* Starts of branches that leave at `trial`, which the shooting has just evaluated. */
saltus_status saltus_branch_switch(saltus_branch *b, saltus_point_kind kind, saltus_message *message);

/* branch_special.c */
/* All special points of the step from `here` to `next`, in order, the end of the range among them. */
saltus_status saltus_branch_special_points(saltus_branch *b, int *given, saltus_message *message);

/* branch_change.c */
/* Try both ways along the tangent of `here`, the one nearer to `old` first: whether the flow follows the
 * sequence a little way on; then `next` is a point there. */
bool saltus_branch_go_on(saltus_branch *b, const double *old);
/* Go on with another sequence of events at `trial`, where the present one ceases to be admissible, or end the
 * branch. `goes_on`: `here` is the change itself and `next` a point beyond, the way to which is to be made.
 */
saltus_status saltus_branch_change(saltus_branch *b, double accuracy, bool *goes_on, saltus_message *message);
/* Where between `here` and `next` the label changes though the prescribed events stay: in the part of the
 * sequence that is left to the flow. Gives the point out. */
saltus_status saltus_branch_relabel(saltus_branch *b, saltus_message *message);
/* Make the sequence of `here` anew from what the flow does, where chatter has become complete. */
saltus_status saltus_branch_retrace(saltus_branch *b, saltus_message *message);
/* The same where the flow's events cannot be followed between `here` and `ahead`. */
saltus_status saltus_branch_leap(saltus_branch *b, double ahead, const char *why, saltus_message *message);

/* branch_locus.c */
saltus_status saltus_locus_open(saltus_branch *b, saltus_message *message);
saltus_status saltus_locus_begin(saltus_branch *b, const saltus_branch_start *start, saltus_message *message);
saltus_status saltus_locus_advance(saltus_branch *b, saltus_message *message);
void saltus_locus_close(saltus_branch *b);

#endif
