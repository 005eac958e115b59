/* Continuation of periodic orbits.
 *
 * Pseudo-arclength steps (curve.h) on the equations of a prescribed sequence of events (solution.h). Between
 * two points the tests are compared; every zero is located and given out in its place (special.h). A breach,
 * an impact of no speed, a free maximum on a stop, a contact force of zero, ends the sequence: the branch
 * goes on with another one (change.h). The event-driven flow has the last word on every point.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/progress.h"
#include "branch/archive.h"
#include "branch/boundary.h"
#include "branch/change.h"
#include "branch/ending.h"
#include "branch/equilibria.h"
#include "branch/hopf.h"
#include "branch/locus.h"
#include "branch/options.h"
#include "branch/point.h"
#include "branch/sequence.h"
#include "branch/special.h"
#include "orbit/poincare.h"
#include "orbit/returns.h"
#include "orbit/sequence.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char range_ends[] = "end of the parameter's range";
static const char enough_points[] = "as many points as asked for";

/* What the next step of a run does. */
typedef enum run_phase {
    RUN_BEGIN,  /* take up the next start */
    RUN_FOLLOW, /* go on along the branch under way */
    RUN_REST    /* go on along the branches of equilibria */
} run_phase;

/* The last places where impacts were born, one after the other. */
enum { run_length = 4 };
typedef struct birth_run {
    int count;
    double place[run_length]; /* parameter unknowns, the last one last */
} birth_run;

/* The branch under way. */
typedef struct trace {
    int number, parent, depth;
    int regular;             /* points given out but for special ones */
    int made;                /* points given out */
    double arclength, shown; /* of `here`; of the last regular point given out */
    double step;
    bool fresh; /* no step made since the branch was switched to */
    birth_run run;
    double first_value;
    int returns;      /* of the last point, to the section of a scene without forcing; -1: not known, ... */
    double counted;   /* ... and its value */
    saltus_lap first; /* section points of the orbit it began with */
    saltus_solution *here;
} trace;

/* A special point that has been given out. */
typedef struct visited {
    saltus_point_kind kind;
    int branch, periods;
    char label[2][SALTUS_LABEL_MAX]; /* at it and beyond it */
    double value;
    double *state;
} visited;

struct saltus_branch {
    saltus_branch_options options;
    const volatile sig_atomic_t *stop; /* asked for between steps, never within one */
    saltus_orbits orbits;
    double range[2]; /* of the parameter unknown */
    saltus_starts starts;
    run_phase phase;
    trace trace;
    saltus_solution solutions[5];
    saltus_solution *next, *trial, *spare, *other; /* beside the trace's `here` */
    saltus_special specials[SALTUS_BRANCH_VALUES_MAX + 9];
    double targets[SALTUS_BRANCH_VALUES_MAX + 1];
    saltus_point_kind target_kinds[SALTUS_BRANCH_VALUES_MAX + 1];
    visited *visited;
    int visited_count;
    saltus_branch_point *queue; /* points made but not yet given out */
    int queue_count, queue_next, queue_room;
    saltus_branch_point given;
    long long given_count;
    saltus_locus *locus;           /* NULL: none is followed yet */
    saltus_equilibria *equilibria; /* branches of equilibria that come first; NULL: none, or all are done */
};

static saltus_status no_memory(saltus_message *message) {
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
}

/* The given state is made an orbit of least period, and its sequence the start of both ways. */
static saltus_status open_starts(saltus_branch *b, int periods, const double *state,
                                 saltus_message *message) {
    saltus_orbits *o = &b->orbits;
    saltus_orbit orbit = {0};
    saltus_lap lap = {.keeps_events = true};
    saltus_orbit_options options = o->options;
    options.phase = 0;
    options.flow.stop = b->stop;
    const bool cycle = o->options.free_period;
    saltus_branch_start start = {.parent = -1};
    saltus_system *clocked = NULL;
    const double at_start[2] = {0};
    saltus_status status =
        cycle ? saltus_cycle_polish(o->system, state, &options, &orbit, &clocked, &lap, message)
              : saltus_return_polish(o->flow, periods, state, &options, &orbit, &lap, message);
    start.state = orbit.state;
    if (status == SALTUS_OK && cycle)
        status = saltus_orbits_tune(o, at_start, orbit.omega, message);
    if (status == SALTUS_OK)
        status =
            saltus_sequence_make(o->flow, orbit.periods, cycle, start.state, &lap, &start.sequence, message);
    saltus_system_free(clocked);
    for (int heading = 1; heading >= -1 && status == SALTUS_OK; heading -= 2)
        if (b->options.direction * heading >= 0) {
            start.heading = heading;
            status = saltus_starts_add(&b->starts, o->n, &start, message);
        }
    saltus_orbit_clear(&orbit);
    saltus_lap_close(&lap);
    return status;
}

saltus_status saltus_branch_new(const saltus_spec *spec, int periods, const double *state,
                                const saltus_branch_options *options, saltus_branch **branch,
                                saltus_message *message) {
    *branch = NULL;
    saltus_branch *b = calloc(1, sizeof *b);
    if (!b)
        return no_memory(message);
    saltus_orbits *o = &b->orbits;
    b->options = *options;
    b->stop = options->orbit.flow.stop;
    b->trace.here = &b->solutions[0];
    b->next = &b->solutions[1];
    b->trial = &b->solutions[2];
    b->spare = &b->solutions[3];
    b->other = &b->solutions[4];
    o->options = options->orbit;
    o->options.flow.stop = NULL;
    o->family = (saltus_family){.spec = *spec, .parameters = 1, .unit = {options->high[0] - options->low[0]}};
    saltus_status status =
        saltus_spec_direction(spec, options->key[0], &o->family.direction[0], &o->origin, message);
    if (status == SALTUS_OK)
        status = saltus_branch_check(options, spec, message);
    if (status == SALTUS_OK)
        status = saltus_orbits_open(o, message);
    const bool rests = periods == 0 && !options->orbit.free_period && status == SALTUS_OK &&
                       !saltus_system_forced(o->system);
    o->options.free_period |= rests;
    const bool of_rests = options->locus == SALTUS_POINT_HB || options->locus == SALTUS_POINT_BE;
    if (status == SALTUS_OK && of_rests && saltus_system_forced(o->system))
        status =
            saltus_fail(message, SALTUS_BAD_INPUT,
                        "locus = %s: the scene is forced: it has no equilibria, which such points are of",
                        saltus_point_word(options->locus));
    if (status == SALTUS_OK)
        status = rests ? saltus_equilibria_new(spec, options, state, &b->starts, &b->equilibria, message)
                       : open_starts(b, periods, state, message);
    if (status != SALTUS_OK) {
        saltus_branch_free(b);
        return status;
    }
    b->range[0] = saltus_orbits_border(o->origin, o->family.unit[0], options->low[0], 0);
    b->range[1] = saltus_orbits_border(o->origin, o->family.unit[0], options->high[0], 1);
    for (int k = 0; k < options->value_count; k++) {
        b->targets[k] = options->values[k];
        b->target_kinds[k] = SALTUS_POINT_UZ;
    }
    *branch = b;
    return status;
}

static void drop_queue(saltus_branch *b) {
    for (int k = b->queue_next; k < b->queue_count; k++)
        saltus_branch_point_clear(&b->queue[k]);
    b->queue_count = b->queue_next = 0;
}

void saltus_branch_free(saltus_branch *b) {
    if (!b)
        return;
    saltus_starts_clear(&b->starts);
    drop_queue(b);
    saltus_branch_point_clear(&b->given);
    free(b->queue);
    for (int k = 0; k < b->visited_count; k++)
        free(b->visited[k].state);
    free(b->visited);
    for (int k = 0; k < 5; k++)
        saltus_solution_clear(&b->solutions[k]);
    saltus_locus_free(b->locus);
    saltus_equilibria_free(b->equilibria);
    saltus_lap_close(&b->trace.first);
    saltus_orbits_close(&b->orbits);
    free(b);
}

static saltus_branch_point *queue_place(saltus_branch *b, saltus_message *message) {
    if (b->queue_count == b->queue_room) {
        int room = b->queue_room ? 2 * b->queue_room : 8;
        saltus_branch_point *grown = realloc(b->queue, (size_t)room * sizeof *grown);
        if (!grown) {
            no_memory(message);
            return NULL;
        }
        b->queue = grown;
        b->queue_room = room;
    }
    return &b->queue[b->queue_count];
}

/* Whether a point and one visited change between the same motions, in either direction. */
static bool same_labels(const visited *v, const saltus_branch_point *point) {
    const char *at = point->label, *after = point->label_after;
    return (strcmp(v->label[0], at) == 0 && strcmp(v->label[1], after) == 0) ||
           (strcmp(v->label[0], after) == 0 && strcmp(v->label[1], at) == 0);
}

/* Whether a special point was given out before: the branch of it, -1 for none. Points of branches that cross
 * or begin at one another are not alike: they differ in kind or in period. Where impacts die one after the
 * other points lie close together without being the same; they differ in the number of impacts. */
static int find_visited(const saltus_branch *b, const saltus_branch_point *point) {
    for (int k = 0; k < b->visited_count; k++) {
        const visited *v = &b->visited[k];
        bool same = same_labels(v, point);
        double close_value = same ? 1e-7 : 1e-11, close_state = same ? 1e-5 : 1e-7;
        if (v->kind == point->kind && v->periods == point->periods &&
            fabs(v->value - point->value[0]) < close_value * b->orbits.family.unit[0] &&
            saltus_system_distance(b->orbits.system, v->state, point->state) < close_state)
            return v->branch;
    }
    return -1;
}

static saltus_status remember(saltus_branch *b, const saltus_branch_point *point, saltus_message *message) {
    size_t n = (size_t)point->dimension;
    visited *grown = realloc(b->visited, ((size_t)b->visited_count + 1) * sizeof *grown);
    if (grown)
        b->visited = grown;
    double *state = calloc(n, sizeof *state);
    if (!grown || !state) {
        free(state);
        return no_memory(message);
    }
    memcpy(state, point->state, n * sizeof *state);
    grown[b->visited_count++] = (visited){.kind = point->kind,
                                          .branch = point->branch,
                                          .periods = point->periods,
                                          .value = point->value[0],
                                          .state = state};
    memcpy(grown[b->visited_count - 1].label[0], point->label, SALTUS_LABEL_MAX);
    memcpy(grown[b->visited_count - 1].label[1], point->label_after, SALTUS_LABEL_MAX);
    return SALTUS_OK;
}

static bool is_kept(saltus_point_kind kind) {
    return kind == SALTUS_POINT_LP || kind == SALTUS_POINT_PD || kind == SALTUS_POINT_NS ||
           kind == SALTUS_POINT_GR || kind == SALTUS_POINT_CH || kind == SALTUS_POINT_ST;
}

/* Whether the locus that was asked for has been begun. */
static bool on_locus(const saltus_branch *b) {
    return b->locus || b->equilibria;
}

/* What is to be said of a point beside what its solution tells. */
typedef struct notice {
    saltus_point_kind kind;
    double ahead, accuracy;
    const char *reason, *addition; /* two parts; NULL: nothing */
    const char *after;             /* label beyond; NULL: none */
    double value;                  /* 0: the solution's */
    bool change;                   /* of events: label and counts are those of `here` */
    const saltus_breach *grazing;  /* the touch at grazing; NULL: none is known */
} notice;

static void tell_returns(const saltus_branch *b, int returns, int before, double until, char *reason) {
    snprintf(reason, SALTUS_REASON_MAX, "returns to the section: %d, were %d until %s = %.12g%s", returns,
             before, b->options.key[0], until, returns ? "" : "; another section would count the orbit");
}

/* How often an orbit of a period of its own comes back to its section. One that does not meet it has the
 * solution's own state in the place of a section point. */
static int count_returns(const saltus_solution *s, int periods, const double *point, int n) {
    return periods == 1 && memcmp(point, s->state, (size_t)n * sizeof *point) == 0 ? 0 : periods;
}

/* Orbits of a period of their own go on where they lose or gain a return to their section, a maximum, say:
 * the first point behind says so, and since which value. */
static void compare_returns(saltus_branch *b, const saltus_solution *s, saltus_branch_point *point) {
    trace *t = &b->trace;
    if (!(s->sequence.omega > 0) || !s->survey.walked)
        return;
    int returns = count_returns(s, point->periods, point->state, point->dimension);
    if (t->returns >= 0 && returns != t->returns && !point->reason[0])
        tell_returns(b, returns, t->returns, t->counted, point->reason);
    t->returns = returns;
    t->counted = point->value[0];
}

/* A surveyed solution goes into the queue. A branch ends with its point of kind EP; where it has been at a
 * special point before, and where there are enough points, it ends too. */
static saltus_status give(saltus_branch *b, const saltus_solution *s, notice what, saltus_message *message) {
    trace *t = &b->trace;
    saltus_branch_point *point = queue_place(b, message);
    if (!point)
        return SALTUS_NO_MEMORY;
    saltus_status status = saltus_point_make(&b->orbits, s, what.change, point, message);
    if (status != SALTUS_OK)
        return status;
    const saltus_survey *before = &t->here->survey;
    if (what.change && before->label[0]) {
        memcpy(point->label, before->label, sizeof point->label);
        point->impacts = before->impacts;
        point->sticking_intervals = before->sticking_intervals;
    }
    /* There a multiplier is on the unit circle but for rounding. */
    if (what.kind == SALTUS_POINT_LP || what.kind == SALTUS_POINT_PD || what.kind == SALTUS_POINT_BP ||
        what.kind == SALTUS_POINT_NS)
        point->stable = false;
    point->kind = what.kind;
    point->branch = t->number;
    point->parent = t->parent;
    point->step = t->regular;
    point->arclength = t->arclength + what.ahead;
    point->value[0] = what.value != 0 ? what.value : s->value;
    point->accuracy = what.accuracy + DBL_EPSILON * fabs(point->value[0]);
    /* Only the event-driven flow tells these, to its tolerance. */
    if (what.kind == SALTUS_POINT_CH || what.kind == SALTUS_POINT_ST)
        point->accuracy += b->orbits.options.flow.rtol * b->orbits.family.unit[0];
    snprintf(point->label_after, sizeof point->label_after, "%s", what.after ? what.after : "");
    snprintf(point->reason, sizeof point->reason, "%s%s", what.reason ? what.reason : "",
             what.addition ? what.addition : "");
    compare_returns(b, s, point);
    if (is_kept(point->kind)) {
        int earlier = find_visited(b, point);
        if (earlier < 0)
            status = remember(b, point, message);
        else
            snprintf(point->reason, sizeof point->reason,
                     earlier == t->number ? "the branch is closed: it has come back to this %s"
                                          : "this %s is on branch %d",
                     saltus_point_word(point->kind), earlier);
        if (earlier >= 0)
            point->kind = SALTUS_POINT_EP;
    }
    if (point->kind != SALTUS_POINT_EP && t->made + 1 >= b->options.points) {
        point->kind = SALTUS_POINT_EP;
        snprintf(point->reason, sizeof point->reason, "%s", enough_points);
    }
    if ((point->kind == SALTUS_POINT_GR || point->kind == SALTUS_POINT_BE) && what.grazing)
        saltus_point_mark_grazing(&b->orbits, what.grazing, point);
    if (point->kind == SALTUS_POINT_EP)
        b->phase = RUN_BEGIN;
    b->queue_count++;
    t->made++;
    return status;
}

static saltus_status end(saltus_branch *b, const saltus_solution *s, double ahead, const char *reason,
                         saltus_message *message) {
    return give(b, s, (notice){.kind = SALTUS_POINT_EP, .ahead = ahead, .accuracy = NAN, .reason = reason},
                message);
}

/* A solution on a border of the range, which the rounding of its unknown may miss. */
static saltus_status end_at_border(saltus_branch *b, saltus_solution *s, double ahead,
                                   saltus_message *message) {
    s->value = s->parameter[0] == b->range[1] ? b->options.high[0] : b->options.low[0];
    return end(b, s, ahead, range_ends, message);
}

static void swap(saltus_solution **a, saltus_solution **b) {
    saltus_solution *kept = *a;
    *a = *b;
    *b = kept;
}

/* The returns of `trial`, as far along the step as that; -1 where it cannot be had. */
static int returns_at(saltus_branch *b, double ahead) {
    saltus_lap lap = {0};
    saltus_message ignored;
    saltus_status status = saltus_solution_visit(&b->orbits, b->trace.here, ahead, b->trial, &ignored);
    if (status == SALTUS_OK)
        status = saltus_orbits_noted(&b->orbits, saltus_cycle_around(&b->orbits, b->trial, &lap, &ignored));
    int returns = status == SALTUS_OK ? count_returns(b->trial, lap.periods, lap.points, b->orbits.n) : -1;
    saltus_lap_close(&lap);
    return returns;
}

/* The returns, `before` on `here`, have become others on `next`, the last point given out: a point is put
 * before it wherever one comes or goes, where the section's function has an extremum of zero. By the side on
 * which the orbit meets it, as the isolation of zeros is sharp to rounding. */
static saltus_status locate_returns(saltus_branch *b, int before, saltus_message *message) {
    enum { halvings = 60 };
    const double sharp = 1e-13;
    const int last = b->queue_count - 1, after = b->trace.returns;
    double low = 0;
    saltus_status status = SALTUS_OK;
    int count = returns_at(b, 0);
    if (count != before)
        return status;
    while (status == SALTUS_OK && count != after && b->trace.made + 1 < b->options.points) {
        double high = b->next->at.ahead;
        int beyond = after;
        for (int k = 0; k < halvings && high - low > sharp && beyond >= 0; k++) {
            const double middle = 0.5 * (low + high);
            const int found = returns_at(b, middle);
            *(found == count ? &low : &high) = middle;
            beyond = found == count ? beyond : found;
        }
        /* At its begin the step may have led over another change, which has been told. */
        if (beyond < 0 || high < 1e-9 || returns_at(b, high) != beyond)
            break;
        const double error = b->orbits.options.flow.rtol + fabs(saltus_solution_heading(b->trial)) * sharp;
        notice what = {.ahead = high, .accuracy = error * b->orbits.family.unit[0]};
        char reason[SALTUS_REASON_MAX];
        tell_returns(b, beyond, count, b->trial->value, reason);
        what.reason = reason;
        status = saltus_solution_survey(&b->orbits, b->trial, message);
        b->trace.returns = beyond;
        if (status == SALTUS_OK)
            status = give(b, b->trial, what, message);
        low = high;
        count = beyond;
    }
    b->trace.returns = after;
    if (count == after && status == SALTUS_OK)
        b->queue[last].reason[0] = 0;
    for (int k = last; k + 1 < b->queue_count; k++) {
        saltus_branch_point point = b->queue[k];
        b->queue[k] = b->queue[k + 1];
        b->queue[k + 1] = point;
    }
    return status;
}

/* `next` becomes `here`, and a regular point where it is far enough from the last, or `must` be one. `bends`:
 * both have the same sequence. */
static saltus_status accept(saltus_branch *b, bool bends, bool must, const char *reason,
                            saltus_message *message) {
    trace *t = &b->trace;
    saltus_status status = SALTUS_OK;
    int order[SALTUS_MARKS_MAX];
    double apart = t->arclength + b->next->at.ahead - t->shown;
    if (must || apart >= 0.02 * b->options.step_max || t->regular == 0) {
        const int returns = t->returns;
        status = give(b, b->next, (notice){.ahead = b->next->at.ahead, .accuracy = NAN, .reason = reason},
                      message);
        if (status == SALTUS_OK && bends && returns >= 0 && t->returns != returns && b->phase == RUN_FOLLOW)
            status = locate_returns(b, returns, message);
        t->shown = t->arclength + b->next->at.ahead;
        t->regular++;
    }
    t->arclength += b->next->at.ahead;
    t->fresh = false;
    swap(&t->here, &b->next);
    if (bends)
        saltus_curve_bend(&b->next->at, &t->here->at);
    if (status == SALTUS_OK && b->phase == RUN_FOLLOW)
        saltus_solution_reframe(&b->orbits, true, false, t->here, b->trial, order);
    return status;
}

/* A start that a branch has come to from its other end is not begun at: the branch is done. */
static void drop_starts(saltus_branch *b, const saltus_branch_point *point) {
    int kept = 0;
    for (int k = 0; k < b->starts.count; k++) {
        saltus_branch_start *start = &b->starts.start[k];
        double value = b->orbits.origin + b->orbits.family.unit[0] * start->parameter;
        if (start->origin == point->kind && start->sequence.periods == point->periods &&
            fabs(value - point->value[0]) < 1e-7 * b->orbits.family.unit[0]) {
            saltus_start_clear(start);
        } else {
            b->starts.start[kept++] = *start;
        }
    }
    b->starts.count = kept;
}

/* Branches that leave at `at` are kept for later. */
static saltus_status add_starts(saltus_branch *b, const saltus_solution *at, saltus_point_kind kind,
                                const saltus_sequence *beyond, saltus_message *message) {
    saltus_branch_start like = {.parent = b->trace.number, .depth = b->trace.depth + 1};
    saltus_message why = {.text = ""};
    if (b->trace.depth >= b->options.switches || b->phase != RUN_FOLLOW)
        return SALTUS_OK;
    saltus_status status = kind == SALTUS_POINT_GR
                               ? saltus_starts_graze(&b->orbits, at, beyond, &like, &b->starts, &why)
                               : saltus_starts_leave(&b->orbits, at, kind, &like, &b->starts, &why);
    if (status == SALTUS_NO_MEMORY)
        return no_memory(message);
    saltus_branch_point *point = &b->queue[b->queue_count - 1];
    if (status != SALTUS_OK)
        snprintf(point->reason, sizeof point->reason, "not switched to what leaves here: %.120s", why.text);
    return SALTUS_OK;
}

/* A locus begins at `at`: the points on the way to it are not wanted. */
static saltus_status open_locus(saltus_branch *b, const saltus_solution *at, const saltus_sequence *beyond,
                                saltus_message *message) {
    saltus_message why = {.text = ""};
    drop_queue(b);
    const saltus_spec *spec = &b->orbits.family.spec;
    const saltus_sequence *s = &at->sequence;
    saltus_status status =
        b->options.locus == SALTUS_POINT_HB
            ? saltus_equilibria_take_up(spec, &b->options, s->contacts, at->state, at->parameter[0],
                                        s->omega / s->periods, &b->starts, &b->equilibria, &why)
            : saltus_locus_new(spec, &b->options, at, beyond, &b->locus, &why);
    return status == SALTUS_OK
               ? status
               : saltus_fail(message, status, "no curve of %s points can be begun at %s = %.12g: %.200s",
                             saltus_point_word(b->options.locus), b->options.key[0], at->value, why.text);
}

/* Whether an orbit is the branch's first one. */
static bool has_come_back(saltus_branch *b, const saltus_solution *s) {
    const saltus_lap *first = &b->trace.first;
    saltus_lap lap = {0};
    saltus_message ignored;
    const double *state = s->survey.lap.points;
    bool known = true;
    if (s->sequence.omega > 0) {
        known =
            saltus_orbits_noted(&b->orbits, saltus_cycle_around(&b->orbits, s, &lap, &ignored)) == SALTUS_OK;
        state = lap.points;
    }
    bool back = known && saltus_orbit_passes(b->orbits.system, first->points, first->periods, state,
                                             SALTUS_SAME_POINT);
    saltus_lap_close(&lap);
    return back;
}

/* At a pitchfork the parameter turns back in the very place where the other branch crosses: of a fold and a
 * branch point that cannot be told apart only the branch point is given. */
static bool is_pitchfork(const saltus_branch_point *last, const saltus_special *special) {
    return ((last->kind == SALTUS_POINT_LP && special->kind == SALTUS_POINT_BP) ||
            (last->kind == SALTUS_POINT_BP && special->kind == SALTUS_POINT_LP)) &&
           isfinite(last->accuracy + special->accuracy) &&
           fabs(last->value[0] - special->value) <= last->accuracy + special->accuracy;
}

/* That cycles shrink to an equilibrium: what is left of their distance, and their period. */
static saltus_status tell_shrinking(saltus_branch *b, const saltus_solution *at, char *reason,
                                    saltus_message *message) {
    saltus_passed passed = {.found = false};
    saltus_status status = saltus_cycle_passes(&b->orbits, at, &passed, message);
    int length = snprintf(reason, SALTUS_REASON_MAX, "the orbit shrinks to an equilibrium: period %.9g",
                          2 * M_PI * at->sequence.periods / at->sequence.omega);
    if (passed.found)
        snprintf(reason + length, SALTUS_REASON_MAX - (size_t)length, ", distance %.2g", passed.distance);
    return status;
}

/* The shortest step that is cut where a longer one has led astray. */
static const double step_least = 1e-5;

/* Whether `at`, where the cycles of a step seem to have shrunk to nothing, tells of the Hopf point in
 * which they end: that of the equilibrium, by its own equation, which lies in the very same place. */
static saltus_status find_hopf(saltus_branch *b, const saltus_special *special, const saltus_solution *at,
                               saltus_shrunk *hopf, saltus_message *message) {
    const double close = 1e-6, alike = 1e-3, slack = 10;
    const saltus_solution *here = b->trace.here;
    saltus_status status = saltus_cycle_shrinks(&b->orbits, at, hopf, message);
    const double omega = (special->sharp ? at : here)->sequence.omega / here->sequence.periods;
    const double unit = b->orbits.family.unit[0];
    const double apart = fabs(hopf->parameter - (special->sharp ? at : here)->parameter[0]);
    const double most = special->sharp ? slack * special->accuracy / unit + close : b->next->at.ahead;
    hopf->found = hopf->found && apart < most && fabs(log(hopf->omega / omega)) < alike;
    return status;
}

/* Whether a step has led off the cycles: an equilibrium solves their equations with any period. */
static bool is_equilibrium(const saltus_branch *b, const saltus_solution *next) {
    const double shrunk = 1e-3;
    return next->sequence.omega > 0 && next->sequence.count == 0 &&
           next->speed < shrunk * b->trace.here->speed;
}

/* `trial` becomes the Hopf point that it tells of; where that is not found, no more is said than that the
 * cycles shrink to an equilibrium. */
static saltus_status become_hopf(saltus_branch *b, saltus_special *special, saltus_message *message) {
    saltus_shrunk hopf;
    saltus_status status = find_hopf(b, special, b->trial, &hopf, message);
    if (status == SALTUS_OK && hopf.found)
        status = saltus_cycle_shrink(&b->orbits, &hopf, b->trial, message);
    if (status != SALTUS_OK)
        return status;
    special->kind = hopf.found ? SALTUS_POINT_HB : SALTUS_POINT_EP;
    special->value = b->trial->value;
    special->accuracy = hopf.found ? b->orbits.family.unit[0] * hopf.accuracy : NAN;
    return status;
}

/* Whether a step has been too long to see where the cycles shrink to nothing. */
static saltus_status misses_hopf(saltus_branch *b, bool *misses, saltus_message *message) {
    const saltus_solution *here = b->trace.here, *next = b->next;
    saltus_special special;
    saltus_shrunk hopf;
    *misses = is_equilibrium(b, next);
    if (*misses || here->sequence.count > 0 ||
        !saltus_special_hopf(&b->orbits, here, next, &special, b->trial))
        return SALTUS_OK;
    bool is_one;
    saltus_status status =
        saltus_special_visit(&b->orbits, here, next->at.ahead, &special, b->trial, &is_one, message);
    if (status != SALTUS_OK || !is_one)
        return status;
    status = find_hopf(b, &special, b->trial, &hopf, message);
    *misses = !special.sharp || !hopf.found;
    return status;
}

/* Whether the fold at `trial` cannot be told from the Hopf point in which the cycles end soon after: there
 * the parameter stands still, and rounding turns it. */
static saltus_status is_of_hopf(saltus_branch *b, const saltus_special *special, bool *is,
                                saltus_message *message) {
    const double small = 0.2;
    const saltus_solution *at = b->trial;
    saltus_shrunk hopf;
    *is = special->kind == SALTUS_POINT_LP && at->sequence.omega > 0 && at->sequence.count == 0 &&
          at->speed < small * b->trace.here->speed;
    if (!*is)
        return SALTUS_OK;
    saltus_status status = saltus_cycle_shrinks(&b->orbits, at, &hopf, message);
    const double apart = b->orbits.family.unit[0] * fabs(hopf.parameter - at->parameter[0]);
    *is = status == SALTUS_OK && hopf.found && apart <= special->accuracy;
    return status;
}

/* One special point of the step from `here` to `next`. */
static saltus_status give_special(saltus_branch *b, saltus_special *special, saltus_message *message) {
    trace *t = &b->trace;
    bool is_one, is_none = false;
    saltus_status status =
        saltus_special_visit(&b->orbits, t->here, b->next->at.ahead, special, b->trial, &is_one, message);
    if (status == SALTUS_OK && is_one)
        status = is_of_hopf(b, special, &is_none, message);
    is_one = is_one && !is_none;
    if (status == SALTUS_OK && is_one && special->kind == SALTUS_POINT_HB)
        status = become_hopf(b, special, message);
    if (status != SALTUS_OK || !is_one)
        return status;
    if (b->options.locus && b->options.locus == special->kind &&
        (!special->end || special->kind == SALTUS_POINT_HB))
        return open_locus(b, b->trial, NULL, message);
    notice what = {.kind = special->kind,
                   .ahead = special->ahead,
                   .accuracy = special->accuracy,
                   .reason = special->end,
                   .value = special->value};
    if (special->kind == SALTUS_POINT_REGULAR) {
        if (!has_come_back(b, b->trial))
            return status;
        /* The other way from the same start leads around the same branch. */
        if (b->starts.begun == 1 && b->starts.count > 0 && b->starts.start[0].heading) {
            saltus_branch_start other = saltus_starts_take(&b->starts);
            saltus_start_clear(&other);
        }
        what.kind = SALTUS_POINT_EP;
        what.reason = "the branch is closed: it has come back";
        return give(b, b->trial, what, message);
    }
    saltus_branch_point *last = b->queue_count ? &b->queue[b->queue_count - 1] : NULL;
    if (last && is_pitchfork(last, special)) {
        if (special->kind == SALTUS_POINT_LP)
            return status;
        saltus_branch_point_clear(last);
        b->queue_count--;
        t->made--;
    }
    status = give(b, b->trial, what, message);
    if (status == SALTUS_OK && special->end && b->phase == RUN_FOLLOW) {
        char reason[SALTUS_REASON_MAX];
        drop_starts(b, &b->queue[b->queue_count - 1]);
        if (special->kind == SALTUS_POINT_HB) {
            status = tell_shrinking(b, b->trial, reason, message);
            what.reason = reason;
        }
        if (status != SALTUS_OK)
            return status;
        what.kind = SALTUS_POINT_EP;
        return give(b, b->trial, what, message);
    }
    if (status == SALTUS_OK && (special->kind == SALTUS_POINT_PD || special->kind == SALTUS_POINT_BP))
        status = add_starts(b, b->trial, special->kind, NULL, message);
    return status;
}

/* All special points of the step from `here` to `next`, in order. */
static saltus_status give_specials(saltus_branch *b, saltus_message *message) {
    const trace *t = &b->trace;
    int targets = b->options.value_count;
    if (t->first.points && t->regular > 10) {
        b->targets[targets] = t->first_value;
        b->target_kinds[targets++] = SALTUS_POINT_REGULAR;
    }
    int count = saltus_special_find(&b->orbits, t->here, b->next, t->fresh, b->targets, b->target_kinds,
                                    targets, b->specials, b->trial);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < count && status == SALTUS_OK && b->phase == RUN_FOLLOW && !on_locus(b); k++)
        status = give_special(b, &b->specials[k], message);
    return status;
}

/* At grazing itself the flow meets the impact or not by chance: the survey is that of an orbit just before.
 */
static saltus_status survey_before(saltus_branch *b, saltus_message *message) {
    const double back = 1e-7;
    saltus_message ignored;
    if (b->next->at.ahead <= 10 * back ||
        saltus_solution_visit(&b->orbits, b->trace.here, b->next->at.ahead - back, b->trial, &ignored) !=
            SALTUS_OK)
        return saltus_solution_survey(&b->orbits, b->next, message);
    saltus_status status = saltus_solution_survey(&b->orbits, b->trial, message);
    saltus_survey_swap(b->trial, b->next);
    return status;
}

/* `spare`, so far along the branch, becomes `here`. */
static saltus_status go_on_at(saltus_branch *b, double distance, saltus_message *message) {
    trace *t = &b->trace;
    t->arclength += distance;
    b->spare->at.ahead = 0;
    swap(&t->here, &b->spare);
    t->step = fmin(t->step, b->options.step);
    t->shown = t->arclength;
    saltus_status status = give(b, t->here, (notice){.accuracy = NAN}, message);
    t->regular++;
    return status;
}

/* Another impact is born at a place; or one dies, and the run ends. */
static void note_birth(birth_run *run, bool born, double place) {
    if (run->count == run_length)
        memmove(run->place, run->place + 1, (size_t)--run->count * sizeof *run->place);
    run->count = born ? run->count + 1 : 0;
    if (born)
        run->place[run->count - 1] = place;
}

/* Whether births follow one another in a geometric sequence: how far from the last of them it ends. */
static bool accumulates(const birth_run *run, double *rest) {
    const double steady = 0.05, slowest = 0.95, least = 1e-10;
    double ratio[run_length - 2];
    if (run->count < run_length)
        return false;
    for (int k = 0; k < run_length - 2; k++)
        ratio[k] = (run->place[k + 2] - run->place[k + 1]) / (run->place[k + 1] - run->place[k]);
    *rest = (run->place[run_length - 1] - run->place[run_length - 2]) * ratio[1] / (1 - ratio[1]);
    return ratio[1] > 0 && ratio[1] < slowest && fabs(ratio[1] - ratio[0]) < steady * ratio[1] &&
           fabs(*rest) > least;
}

/* Where births accumulate the branch goes on beyond them, with complete chatter, if that is found:
 * *completes; `far` as there. */
static saltus_status complete_run(saltus_branch *b, bool far, bool *completes, saltus_message *message) {
    trace *t = &b->trace;
    saltus_change change;
    double rest;
    *completes = accumulates(&t->run, &rest) &&
                 saltus_change_complete(&b->orbits, t->here, t->run.place[run_length - 1] + rest, rest, far,
                                        b->range, b->trial, b->spare, b->other, &change);
    if (!*completes)
        return saltus_shooting_shape(b->orbits.shooting, &t->here->sequence, message);
    t->run.count = 0;
    notice what = {.kind = change.kind,
                   .accuracy = change.accuracy,
                   .reason = change.reason,
                   .after = change.after,
                   .change = true};
    saltus_status status = give(b, b->trial, what, message);
    return status == SALTUS_OK && b->phase == RUN_FOLLOW ? go_on_at(b, change.distance, message) : status;
}

/* Over a change of events that only the event-driven flow sees, somewhere before `ahead`. */
static saltus_status leap(saltus_branch *b, double ahead, saltus_leap kind, const char *why,
                          saltus_message *message) {
    trace *t = &b->trace;
    saltus_change change;
    bool completes = false;
    saltus_status status = saltus_change_leap(&b->orbits, t->here, ahead, kind, why, b->range, b->trial,
                                              b->spare, b->other, &change, message);
    /* The last births before chatter completes may lie beyond rounding. */
    if (status == SALTUS_OK && change.kind == SALTUS_POINT_EP && t->run.count == run_length) {
        status = complete_run(b, true, &completes, message);
        if (status == SALTUS_OK && !completes)
            status = saltus_change_leap(&b->orbits, t->here, ahead, kind, why, b->range, b->trial, b->spare,
                                        b->other, &change, message);
    }
    if (status != SALTUS_OK || completes)
        return status;
    if (isnan(change.accuracy))
        return end(b, t->here, 0, why, message);
    if (change.at_border)
        return end_at_border(b, b->spare, b->trial->at.ahead, message);
    notice what = {.kind = change.kind,
                   .ahead = b->trial->at.ahead,
                   .accuracy = change.accuracy,
                   .reason = change.reason,
                   .after = change.after,
                   .value = change.value,
                   .change = true};
    if (change.kind == SALTUS_POINT_EP)
        what.addition = "; beyond it no orbit of this period was found";
    if (change.kind != SALTUS_POINT_REGULAR)
        status = give(b, b->trial, what, message);
    if (status != SALTUS_OK || b->phase != RUN_FOLLOW)
        return status;
    return go_on_at(b, b->trial->at.ahead + change.distance, message);
}

/* Whether an orbit grazes at the end of a run of impacts that have hardly any speed: chatter all but
 * completes. */
static bool ends_run(const saltus_solution *s) {
    const double slow = 1e-8, near = 1e-3;
    for (int k = 0; k < s->breach_count; k++) {
        const saltus_breach *b = &s->breaches[k];
        if (b->kind == SALTUS_BREACH_SPEED && b->face == s->worst.face && b->value > -slow &&
            b->time < s->worst.time && s->worst.time - b->time < near)
            return true;
    }
    return false;
}

/* Beyond grazing at `next`, to a point a little further on. */
static saltus_status graze(saltus_branch *b, double accuracy, saltus_message *message) {
    trace *t = &b->trace;
    saltus_orbits *o = &b->orbits;
    saltus_solution *at = b->next;
    saltus_sequence beyond;
    saltus_change change;
    notice what = {.kind = SALTUS_POINT_GR,
                   .ahead = at->at.ahead,
                   .accuracy = accuracy,
                   .change = true,
                   .grazing = &at->worst};
    bool completes, joins = saltus_solution_half_distance(o, at, false) < 1e-4;
    what.accuracy += saltus_special_doubt(o, SALTUS_TEST_BREACH, at);
    saltus_status status = saltus_change_graze(o, at, &beyond, b->spare, b->trial, &change, message);
    if (status != SALTUS_OK)
        return status;
    /* Further impacts are beyond rounding: on to where chatter is complete. */
    if (change.kind == SALTUS_POINT_EP && !joins && (!change.reason || ends_run(at))) {
        status = saltus_shooting_shape(o->shooting, &t->here->sequence, message);
        return status == SALTUS_OK ? leap(b, 2 * at->at.ahead, SALTUS_LEAP_RUN,
                                          "grazings follow one another ever more closely", message)
                                   : status;
    }
    if (b->options.locus == SALTUS_POINT_GR && !joins)
        return open_locus(b, at, &beyond, message);
    bool goes_on = change.kind == SALTUS_POINT_GR && !joins;
    what.reason = joins ? NULL : change.reason;
    what.after = goes_on ? change.after : NULL;
    what.addition = goes_on && change.turns_back ? "; the branch turns back (non-smooth fold)" : NULL;
    status = give(b, at, what, message);
    if (status == SALTUS_OK && !joins)
        status = add_starts(b, at, SALTUS_POINT_GR, &beyond, message);
    if (status != SALTUS_OK || b->phase != RUN_FOLLOW)
        return status;
    if (joins)
        drop_starts(b, &b->queue[b->queue_count - 1]);
    if (!goes_on)
        return end(b, at, at->at.ahead,
                   joins ? "joins the orbits of half the period at their grazing"
                         : "grazing: no orbit of this period goes on with other events",
                   message);
    t->arclength += at->at.ahead;
    note_birth(&t->run, beyond.count > at->sequence.count, at->parameter[0]);
    swap(&t->here, &b->spare);
    swap(&b->next, &b->trial);
    t->step = fmax(b->next->at.ahead, 0.25 * t->step);
    status = give_specials(b, message);
    if (status == SALTUS_OK && b->phase == RUN_FOLLOW && !on_locus(b))
        status = accept(b, true, false, NULL, message);
    return status == SALTUS_OK && b->phase == RUN_FOLLOW && !on_locus(b) && t->run.count == run_length
               ? complete_run(b, false, &completes, message)
               : status;
}

/* Contacts that begin or end where the sequence is left to the flow are located; of the many impacts in the
 * tail of a long run, which come and go all the time, only the number is told. */
static saltus_status settle(saltus_branch *b, saltus_message *message) {
    const saltus_survey *before = &b->trace.here->survey, *after = &b->next->survey;
    bool known = before->label[0], same = !known || strcmp(before->label, after->label) == 0;
    bool chatter = known && (before->impacts < 0) != (after->impacts < 0);
    saltus_change change = {.kind = SALTUS_POINT_REGULAR};
    saltus_status status = SALTUS_OK;
    if ((chatter || (known && before->sticking_intervals != after->sticking_intervals)) &&
        !saltus_change_within(&b->orbits, b->trace.here, b->next, b->trial, &change))
        change.kind = SALTUS_POINT_REGULAR;
    notice what = {.kind = change.kind,
                   .ahead = b->trial->at.ahead,
                   .accuracy = change.accuracy,
                   .reason = change.reason,
                   .after = change.after,
                   .value = b->trial->value,
                   .change = true};
    bool retraced =
        chatter && after->impacts < 0 &&
        saltus_change_retrace(&b->orbits, b->next, b->spare, b->other, &what.value, &what.accuracy);
    if (retraced) {
        b->spare->at.ahead = b->next->at.ahead;
        swap(&b->next, &b->spare);
    }
    if (change.kind != SALTUS_POINT_REGULAR)
        status = give(b, b->trial, what, message);
    if (status != SALTUS_OK || b->phase != RUN_FOLLOW)
        return status;
    return accept(b, !retraced, !same, same ? NULL : "impacts in the tail of a long run come or go", message);
}

static const char still_period[] = "the parameter stands still while the period changes";

/* Where along a branch of cycles the period changes and the parameter stands still: *ended, and the branch
 * ends at `at`, at a homoclinic orbit where it comes near to a saddle. At the explosion of a canard, too, the
 * parameter stands still, but the period stays finite: there the branch ends only where it is `lost`. */
static saltus_status end_at_saddle(saltus_branch *b, const saltus_solution *at, double ahead, bool lost,
                                   bool *ended, saltus_message *message) {
    const double near = 1e-2, still = 1e-3;
    const double stretching = fabs(at->at.tangent[at->at.unknowns - 2]);
    saltus_passed passed = {.found = false};
    char reason[SALTUS_REASON_MAX];
    *ended = false;
    if (!(at->sequence.omega > 0 && fabs(saltus_solution_heading(at)) < still * stretching))
        return SALTUS_OK;
    saltus_status status = saltus_cycle_passes(&b->orbits, at, &passed, message);
    if (status != SALTUS_OK)
        return status;
    const bool meets = passed.found && passed.distance < near && passed.unstable && passed.stable;
    const double period = 2 * M_PI * at->sequence.periods / at->sequence.omega;
    *ended = meets || lost;
    if (!*ended)
        return SALTUS_OK;
    if (meets)
        snprintf(
            reason, sizeof reason,
            "homoclinic: the period grows without bound, here %.6g at a distance of %.2g from a saddle%s",
            period, passed.distance, passed.contacts ? " on a stop" : "");
    else
        snprintf(reason, sizeof reason, "%s, here %.6g; no saddle is near", still_period, period);
    return end(b, at, ahead, reason, message);
}

/* Where cycles with impacts shrink to an equilibrium that touches a stop: *ended, and the branch ends there.
 */
static saltus_status end_at_boundary(saltus_branch *b, bool *ended, saltus_message *message) {
    saltus_zero zero;
    double value;
    *ended = saltus_boundary_reach(&b->orbits, b->trace.here, b->next, b->trial, &zero, &value);
    if (!*ended)
        return saltus_shooting_shape(b->orbits.shooting, &b->trace.here->sequence, message);
    notice what = {.kind = SALTUS_POINT_BE,
                   .ahead = zero.ahead,
                   .accuracy = zero.accuracy,
                   .reason = "the orbit shrinks to an equilibrium on a stop",
                   .value = value,
                   .grazing = &b->trial->breaches[0]};
    saltus_status status = saltus_solution_survey(&b->orbits, b->trial, message);
    if (status == SALTUS_OK)
        status = give(b, b->trial, what, message);
    if (status != SALTUS_OK || b->phase != RUN_FOLLOW)
        return status;
    drop_starts(b, &b->queue[b->queue_count - 1]);
    what.kind = SALTUS_POINT_EP;
    return give(b, b->trial, what, message);
}

/* Whether the parameter does not change along the branch, but for rounding. */
static bool is_vertical(const saltus_solution *s) {
    return fabs(saltus_solution_heading(s)) < 1e-10;
}

/* Whether orbits of one value of the parameter may form a family, as far as their multipliers tell: one of
 * them is 1, beside that along the flow. */
static bool is_of_family(const saltus_solution *s) {
    const double close = 1e-6;
    bool one = s->sequence.omega == 0 || !s->survey.walked;
    for (int k = 0; k < s->survey.multiplier_count && !one; k++)
        one = hypot(s->survey.multipliers[k].re - 1, s->survey.multipliers[k].im) < close;
    return one;
}

/* The length of a step at whose end an orbit breaches, though `next` does not, as on a border of the range on
 * which an impact rebounds no more; 0: none is found, ever closer to `next`. */
static double hidden_breach(saltus_branch *b) {
    enum { halvings = 10 };
    double rest = b->next->at.ahead;
    saltus_message ignored;
    for (int k = 0; k < halvings; k++) {
        rest *= 0.5;
        if (saltus_solution_visit(&b->orbits, b->trace.here, b->next->at.ahead - rest, b->trial, &ignored) ==
                SALTUS_OK &&
            b->trial->worst.value > 0 && b->trial->worst.kind == SALTUS_BREACH_GAP)
            return b->next->at.ahead - rest;
    }
    return 0;
}

/* Whether a step has led to orbits that close, or are their own mirror images, after half of the period, from
 * orbits that do not: the branch meets theirs, and the step was too long to see it turn back there. */
static bool has_strayed(saltus_branch *b) {
    const double closes = 1e-8, open = 1e-6;
    const saltus_solution *here = b->trace.here, *next = b->next;
    bool even = here->sequence.periods % 2 == 0;
    if (here->sequence.count == 0)
        return even && saltus_solution_half_distance(&b->orbits, next, false) < closes &&
               saltus_solution_half_distance(&b->orbits, here, false) > open;
    for (int mirrored = even ? 0 : 1; mirrored < 2; mirrored++)
        if (saltus_sequence_repeats(&here->sequence, 2, mirrored) > open &&
            saltus_sequence_repeats(&next->sequence, 2, mirrored) < closes)
            return true;
    return false;
}

/* The speed of an orbit's impacts in the system's scale, where they are all alike; NAN where they are not, or
 * where there are none. */
static double common_speed(const saltus_solution *s) {
    const double alike = 1e-6;
    double least = INFINITY, most = -INFINITY;
    int count = 0;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind == SALTUS_BREACH_SPEED) {
            least = fmin(least, -s->breaches[k].value);
            most = fmax(most, -s->breaches[k].value);
            count++;
        }
    return count > 1 && count == s->sequence.count && most - least < alike ? 0.5 * (least + most) : NAN;
}

/* Whether all impacts of a cycle of a planar flow lose their speed at once on the step ahead. Such a cycle
 * forgets when they are, so that where they have no speed its equations are singular twice, and lead
 * anywhere. */
static bool fades(const saltus_branch *b) {
    const double slow = 0.3, share = 0.5;
    const saltus_solution *here = b->trace.here, *next = b->next;
    const double before = common_speed(here), after = common_speed(next);
    const double way = (next->parameter[0] - here->parameter[0]) * saltus_solution_heading(here);
    return b->orbits.n == 2 && here->sequence.omega > 0 && !here->sequence.contacts &&
           !here->sequence.driven && before > 0 && before < slow && !(after > share * before && way > 0);
}

/* Where that is, the cycle without impacts tells: it touches its stops there. *done: it does, and the branch
 * goes on with it. */
static saltus_status fade(saltus_branch *b, bool *done, saltus_message *message) {
    static const double reach[] = {1e-4, 1e-3, 3e-3, 1e-2, 3e-2};
    enum { reaches = sizeof reach / sizeof reach[0] };
    saltus_orbits *o = &b->orbits;
    const saltus_solution *here = b->trace.here;
    const double heading = saltus_solution_heading(here);
    saltus_message ignored;
    saltus_zero zero = {.found = false};
    saltus_sequence bare = here->sequence;
    bare.count = 0;
    *done = false;
    for (int k = 0; k < reaches && !zero.found; k++) {
        const double parameter = here->parameter[0] + copysign(reach[k], heading);
        if (parameter < b->range[0] || parameter > b->range[1] ||
            saltus_solution_place(o, &bare, &parameter, here->state, true, b->spare, &ignored) != SALTUS_OK ||
            b->spare->worst.value > 0 || saltus_solution_survey(o, b->spare, &ignored) != SALTUS_OK ||
            !b->spare->survey.follows)
            continue;
        saltus_solution_head(b->spare, -heading);
        const double back = reach[k] / fabs(saltus_solution_heading(b->spare));
        if (saltus_solution_visit(o, b->spare, back, b->other, &ignored) == SALTUS_OK &&
            b->other->worst.value > 0)
            zero = saltus_solution_zero(o, SALTUS_TEST_BREACH, 0, b->spare, b->other, b->trial);
    }
    if (!zero.found || o->starved)
        return saltus_shooting_shape(o->shooting, &here->sequence, message);
    *done = true;
    notice what = {.kind = SALTUS_POINT_GR,
                   .ahead = fabs((b->trial->parameter[0] - here->parameter[0]) / heading),
                   .accuracy = zero.accuracy + saltus_special_doubt(o, SALTUS_TEST_BREACH, b->trial),
                   .reason = "impacts die",
                   .after = b->spare->survey.label,
                   .change = true,
                   .grazing = &b->trial->worst};
    saltus_status status = saltus_solution_survey(o, b->trial, message);
    if (status == SALTUS_OK)
        status = give(b, b->trial, what, message);
    if (status != SALTUS_OK || b->phase != RUN_FOLLOW)
        return status;
    b->trace.run.count = 0;
    saltus_solution_head(b->spare, heading);
    return go_on_at(b, what.ahead + zero.ahead, message);
}

/* Whether the last of ever shorter steps has left Newton's method with a residual that rounding may be to
 * blame for. */
static bool lacks_digits(const saltus_orbits *o) {
    return o->equations->size < 1e3 * o->equations->tolerance;
}

/* One step along the branch under way. */
static saltus_status advance(saltus_branch *b, saltus_message *message) {
    saltus_orbits *o = &b->orbits;
    trace *t = &b->trace;
    const saltus_curve_bound bound = {o->equations->count, b->range[0], b->range[1]};
    saltus_zero breach = {.accuracy = NAN};
    saltus_message why = {.text = ""};
    int reached;
    saltus_status status =
        saltus_curve_step(o->equations, &t->here->at, &t->step, &bound, 1, &b->next->at, &reached, &why);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, b->next, message);
    if (status == SALTUS_NO_MEMORY)
        return no_memory(message);
    bool ended = false;
    if (status == SALTUS_NO_CONVERGENCE && lacks_digits(o) &&
        saltus_solution_refine(o, t->here, b->trial, (int[SALTUS_MARKS_MAX]){0})) {
        t->step = b->options.step;
        return SALTUS_OK;
    }
    if (status != SALTUS_OK) {
        status = end_at_saddle(b, t->here, 0, true, &ended, message);
        if (ended || status != SALTUS_OK)
            return status;
        return leap(b, 2 * t->step, SALTUS_LEAP_LOST, why.text, message);
    }
    if (fades(b) && b->options.locus == SALTUS_POINT_REGULAR) {
        status = fade(b, &ended, message);
        if (ended || status != SALTUS_OK)
            return status;
    }
    if (has_strayed(b) && b->next->at.ahead > step_least) {
        t->step = 0.5 * b->next->at.ahead;
        return SALTUS_OK;
    }
    bool misses = false;
    status = misses_hopf(b, &misses, message);
    if (status != SALTUS_OK)
        return status;
    if (misses && b->next->at.ahead > step_least) {
        t->step = 0.5 * b->next->at.ahead;
        return SALTUS_OK;
    }
    if (misses && is_equilibrium(b, b->next))
        return end(b, t->here, 0, "the curve cannot be told from the equilibria near it", message);
    /* A touch in the very place where the orbit is cut open would not be seen. */
    if (saltus_solution_base_beyond(o, b->next) && b->next->at.ahead > step_least) {
        int order[SALTUS_MARKS_MAX];
        t->step = 0.5 * b->next->at.ahead;
        status = saltus_shooting_shape(o->shooting, &t->here->sequence, message);
        if (status == SALTUS_OK)
            saltus_solution_reframe(o, false, true, t->here, b->trial, order);
        return status;
    }
    bool breached = b->next->worst.value > 0;
    if (breached) {
        breach = saltus_solution_zero(o, SALTUS_TEST_BREACH, 0, t->here, b->next, b->trial);
        if (!breach.found)
            return leap(b, b->next->at.ahead, SALTUS_LEAP_EVENTS, "events change", message);
        swap(&b->next, &b->trial);
        reached = -1;
        for (int k = 0; k < 2; k++)
            if (fabs(b->next->parameter[0] - b->range[k]) < saltus_at_border) {
                b->next->parameter[0] = b->range[k];
                reached = 0;
            }
    }
    status = breached ? survey_before(b, message) : saltus_solution_survey(o, b->next, message);
    if (status != SALTUS_OK)
        return status;
    saltus_breach_kind kind = b->next->worst.kind;
    if (saltus_boundary_is_near(t->here, b->next))
        status = end_at_boundary(b, &ended, message);
    if (ended || status != SALTUS_OK)
        return status;
    if (is_vertical(t->here) && is_vertical(b->next)) {
        if (is_of_family(b->next))
            return end(b, b->next, b->next->at.ahead,
                       "the orbits of one value of the parameter form a family", message);
        status = end_at_saddle(b, b->next, b->next->at.ahead, false, &ended, message);
        if (ended || status != SALTUS_OK)
            return status;
    }
    if (!breached && !b->next->survey.follows) {
        bool free = t->here->survey.impacts >= 0 && t->here->survey.sticking_intervals == 0;
        double hidden = free && reached >= 0 ? hidden_breach(b) : 0;
        if (hidden == 0)
            return leap(b, b->next->at.ahead, SALTUS_LEAP_EVENTS, "events change", message);
        t->step = hidden;
        return SALTUS_OK;
    }
    status = give_specials(b, message);
    if (status != SALTUS_OK || b->phase != RUN_FOLLOW || on_locus(b))
        return status;
    t->step = saltus_curve_next_step(t->step, b->next->at.iterations, b->options.step_max);
    if (reached >= 0)
        return end_at_border(b, b->next, b->next->at.ahead, message);
    if (breached && (kind == SALTUS_BREACH_HOLD || kind == SALTUS_BREACH_FORCE))
        return leap(b, b->next->at.ahead, SALTUS_LEAP_EVENTS, "the contact changes", message);
    if (breached)
        return graze(b, breach.accuracy, message);
    return settle(b, message);
}

/* Where no branch can be begun at a start that was switched to, one point says why. */
static saltus_status give_up(saltus_branch *b, const saltus_branch_start *start, const char *why,
                             saltus_message *message) {
    saltus_message ignored;
    saltus_status status = saltus_solution_place(&b->orbits, &start->sequence, &start->parameter,
                                                 start->state, false, b->trace.here, &ignored);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(&b->orbits, b->trace.here, &ignored);
    if (!start->origin || status != SALTUS_OK)
        return status == SALTUS_NO_MEMORY ? no_memory(message) : SALTUS_OK;
    char reason[SALTUS_REASON_MAX];
    snprintf(reason, sizeof reason, "nothing was found to follow from this %s: %.100s",
             saltus_point_word(start->origin), why);
    return end(b, b->trace.here, 0, reason, message);
}

/* The first point of a branch: regular, with what was asked for at its value. */
static saltus_status give_first(saltus_branch *b, const saltus_branch_start *start, saltus_message *message) {
    trace *t = &b->trace;
    saltus_status status = give(b, t->here, (notice){.accuracy = NAN}, message);
    t->regular = 1;
    for (int k = 0; k < b->options.value_count && status == SALTUS_OK && b->phase == RUN_FOLLOW; k++)
        if (b->options.values[k] == t->here->value)
            status = give(b, t->here, (notice){.kind = SALTUS_POINT_UZ}, message);
    double bound = start->heading > 0 ? b->range[1] : b->range[0];
    if (status == SALTUS_OK && start->heading && t->here->parameter[0] == bound && b->phase == RUN_FOLLOW)
        status = give(b, t->here, (notice){.kind = SALTUS_POINT_EP, .reason = range_ends}, message);
    return status;
}

/* Keep the section points of `here` as those of the branch's first orbit. */
static saltus_status keep_first(saltus_branch *b, saltus_message *message) {
    trace *t = &b->trace;
    saltus_message ignored;
    saltus_lap_close(&t->first);
    t->first_value = t->here->value;
    saltus_status status =
        saltus_orbits_tune(&b->orbits, t->here->parameter, t->here->sequence.omega, message);
    if (status != SALTUS_OK)
        return status;
    saltus_status around = t->here->sequence.omega > 0
                               ? saltus_cycle_around(&b->orbits, t->here, &t->first, &ignored)
                               : saltus_lap_around(&t->first, b->orbits.flow, t->here->survey.lap.points,
                                                   t->here->sequence.periods, &ignored);
    return around == SALTUS_NO_MEMORY ? no_memory(message) : SALTUS_OK;
}

static saltus_status begin_at(saltus_branch *b, const saltus_branch_start *start, saltus_message *message) {
    saltus_orbits *o = &b->orbits;
    trace *t = &b->trace;
    saltus_message why = {.text = ""};
    int order[SALTUS_MARKS_MAX];
    *t = (trace){.number = b->starts.begun - 1,
                 .returns = -1,
                 .parent = start->parent,
                 .depth = start->depth,
                 .step = b->options.step,
                 .fresh = start->tangent != NULL,
                 .first = t->first,
                 .here = t->here};
    saltus_lap_close(&t->first);
    b->phase = RUN_FOLLOW;
    if (start->origin == SALTUS_POINT_HB || start->origin == SALTUS_POINT_BE) {
        saltus_status found = start->origin == SALTUS_POINT_HB
                                  ? saltus_hopf_begin(o, start, t->here, &why)
                                  : saltus_boundary_begin(o, start, t->here, &why);
        if (found == SALTUS_OK)
            found = saltus_solution_survey(o, t->here, &why);
        if (found == SALTUS_OK)
            found = give_first(b, start, message);
        if (found == SALTUS_OK)
            return keep_first(b, message);
        b->phase = RUN_BEGIN;
        return found == SALTUS_NO_MEMORY ? no_memory(message) : give_up(b, start, why.text, message);
    }
    if (start->grazes) {
        bool found =
            saltus_change_pass(o, &start->sequence, &start->parameter, start->state, NULL, t->here, b->next);
        if (found)
            return accept(b, true, false, NULL, message);
        b->phase = RUN_BEGIN;
        return give_up(b, start, "the flow follows no such orbit", message);
    }
    saltus_status status = saltus_solution_place(o, &start->sequence, &start->parameter, start->state,
                                                 !start->tangent, t->here, &why);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(o, t->here, message);
    if (status == SALTUS_NO_MEMORY)
        return no_memory(message);
    if (status != SALTUS_OK) {
        b->phase = RUN_BEGIN;
        return SALTUS_OK;
    }
    if (start->tangent)
        memcpy(t->here->at.tangent, start->tangent, (size_t)start->unknowns * sizeof *start->tangent);
    else
        saltus_solution_head(t->here, start->heading);
    status = give_first(b, start, message);
    if (status == SALTUS_OK)
        status = keep_first(b, message);
    if (status == SALTUS_OK && !start->tangent)
        saltus_solution_reframe(o, true, false, t->here, b->trial, order);
    return status;
}

static saltus_status begin(saltus_branch *b, saltus_message *message) {
    saltus_branch_start start = saltus_starts_take(&b->starts);
    saltus_status status = begin_at(b, &start, message);
    saltus_start_clear(&start);
    return status;
}

/* One more point of the locus. */
static saltus_status advance_locus(saltus_branch *b, saltus_message *message) {
    bool more;
    saltus_branch_point *point = queue_place(b, message);
    if (!point)
        return SALTUS_NO_MEMORY;
    saltus_status status = saltus_locus_step(b->locus, point, &more, message);
    b->queue_count += status == SALTUS_OK && more;
    return status;
}

/* One more point of the equilibria; once all are done the cycles that have left them follow. */
static saltus_status advance_equilibria(saltus_branch *b, saltus_message *message) {
    bool more;
    saltus_branch_point *point = queue_place(b, message);
    if (!point)
        return SALTUS_NO_MEMORY;
    saltus_status status = saltus_equilibria_step(b->equilibria, point, &more, message);
    b->queue_count += status == SALTUS_OK && more;
    if (status == SALTUS_OK && !more && !b->options.locus) {
        saltus_equilibria_free(b->equilibria);
        b->equilibria = NULL;
    }
    return status;
}

saltus_status saltus_branch_step(saltus_branch *b, const saltus_branch_point **point,
                                 saltus_message *message) {
    saltus_status status = SALTUS_OK;
    *point = NULL;
    saltus_branch_point_clear(&b->given);
    while (status == SALTUS_OK && b->queue_next == b->queue_count) {
        if (saltus_stop_asked(b->stop))
            return saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
        b->queue_next = b->queue_count = 0;
        if (b->locus) {
            status = advance_locus(b, message);
            if (status == SALTUS_OK && b->queue_count == 0)
                return status;
        } else if (b->equilibria) {
            status = advance_equilibria(b, message);
            if (status == SALTUS_OK && b->queue_count == 0 && b->options.locus)
                return status;
        } else if (b->phase == RUN_FOLLOW) {
            status = advance(b, message);
        } else if (b->starts.count > 0) {
            status = begin(b, message);
        } else if (b->options.locus) {
            return saltus_fail(message, SALTUS_NO_CONVERGENCE, "no %s point was found along %s = %g to %g",
                               saltus_point_word(b->options.locus), b->options.key[0], b->options.low[0],
                               b->options.high[0]);
        } else {
            return SALTUS_OK;
        }
        if (b->orbits.starved)
            return no_memory(message);
        /* While the first point of a locus is sought, the points on the way are not wanted. */
        if (b->options.locus && !on_locus(b))
            drop_queue(b);
    }
    if (status != SALTUS_OK)
        return status;
    b->given = b->queue[b->queue_next++];
    b->given_count++;
    *point = &b->given;
    return status;
}

/* Numbers that must be these; false where others are read. */
static bool archive_same(saltus_archive *a, const double *own, int count) {
    bool same = true;
    for (int k = 0; k < count; k++) {
        double number = own[k];
        saltus_archive_real(a, &number);
        same = same && number == own[k];
    }
    return same;
}

/* Which run it is, as far as it can be told: false where the numbers belong to another one. */
static bool archive_identity(saltus_branch *b, saltus_archive *a) {
    const saltus_branch_options *o = &b->options;
    const saltus_spec *spec = &b->orbits.family.spec;
    int parameters;
    saltus_model_parameters(spec->model, &parameters);
    /* The first number is the version of what follows. */
    const double own[] = {4,         a->n,         a->faces,    o->low[0],     o->high[0],
                          o->locus,  o->low[1],    o->high[1],  o->step,       o->step_max,
                          o->points, o->direction, o->switches, o->value_count};
    bool same = archive_same(a, own, sizeof own / sizeof own[0]);
    same = archive_same(a, spec->parameters, parameters) && same;
    return archive_same(a, o->values, o->value_count) && same;
}

static void archive_visited(saltus_branch *b, saltus_archive *a) {
    enum { numbers_min = 6 }; /* of a visited point */
    size_t count = saltus_archive_length(a, (size_t)b->visited_count, numbers_min);
    if (a->reading && a->sound) {
        b->visited = calloc(count + 1, sizeof *b->visited);
        a->starved = a->starved || !b->visited;
        b->visited_count = b->visited ? (int)count : 0;
    }
    for (int k = 0; k < b->visited_count; k++) {
        visited *v = &b->visited[k];
        v->kind = (saltus_point_kind)saltus_archive_whole(a, v->kind, 0, SALTUS_POINT_KINDS - 1);
        v->branch = (int)saltus_archive_whole(a, v->branch, 0, INT_MAX);
        v->periods = (int)saltus_archive_whole(a, v->periods, 1, INT_MAX);
        saltus_archive_label(a, v->label[0]);
        saltus_archive_label(a, v->label[1]);
        saltus_archive_finite(a, &v->value, 1);
        saltus_archive_array(a, &v->state, (size_t)a->n);
    }
}

/* The branch under way. */
static void archive_trace(saltus_branch *b, saltus_archive *a) {
    trace *t = &b->trace;
    saltus_lap *first = &t->first;
    t->number = (int)saltus_archive_whole(a, t->number, 0, INT_MAX);
    t->parent = (int)saltus_archive_whole(a, t->parent, -1, INT_MAX);
    t->depth = (int)saltus_archive_whole(a, t->depth, 0, INT_MAX);
    t->regular = (int)saltus_archive_whole(a, t->regular, 0, INT_MAX);
    t->made = (int)saltus_archive_whole(a, t->made, 0, INT_MAX);
    saltus_archive_finite(a, &t->arclength, 1);
    saltus_archive_finite(a, &t->shown, 1);
    saltus_archive_finite(a, &t->step, 1);
    a->sound = a->sound && (!a->reading || (t->step > 0 && t->step <= b->options.step_max));
    t->fresh = saltus_archive_flag(a, t->fresh);
    t->run.count = (int)saltus_archive_whole(a, t->run.count, 0, run_length);
    saltus_archive_finite(a, t->run.place, (size_t)t->run.count);
    saltus_archive_finite(a, &t->first_value, 1);
    t->returns = (int)saltus_archive_whole(a, t->returns, -1, INT_MAX);
    saltus_archive_finite(a, &t->counted, 1);
    size_t periods = first->points ? (size_t)first->periods : 0;
    periods = saltus_archive_length(a, periods, (size_t)a->n);
    if (a->reading && a->sound && periods && !saltus_lap_reserve(first, (int)periods, a->n))
        a->starved = true;
    first->periods = first->points ? (int)periods : 0;
    saltus_archive_finite(a, first->points, (size_t)first->periods * (size_t)a->n);
    saltus_archive_shape(a, b->orbits.shooting);
    saltus_archive_solution(a, t->here);
    a->sound = a->sound && (!a->reading || saltus_solution_fits(&b->orbits, t->here));
}

/* All that later steps depend on, between two of them. */
static saltus_status archive_run(saltus_branch *b, saltus_archive *a, saltus_message *message) {
    static const char foreign[] = "what the run goes on from is damaged or belongs to another run";
    saltus_status status = SALTUS_OK;
    a->n = b->orbits.n;
    a->faces = saltus_system_face_count(b->orbits.system);
    a->sound = true;
    a->sound = archive_identity(b, a) && a->sound;
    b->given_count = saltus_archive_whole(a, b->given_count, 0, INT_MAX);
    if (saltus_archive_flag(a, b->locus != NULL)) {
        status = saltus_locus_archive(&b->orbits.family.spec, &b->options, &b->locus, a, message);
    } else {
        b->phase =
            (run_phase)saltus_archive_whole(a, b->equilibria ? RUN_REST : b->phase, RUN_BEGIN, RUN_REST);
        saltus_archive_starts(a, &b->starts);
        saltus_archive_orbits(a, &b->orbits);
        if (b->phase == RUN_REST && !b->equilibria)
            status = saltus_equilibria_new(&b->orbits.family.spec, &b->options, NULL, &b->starts,
                                           &b->equilibria, message);
        if (b->phase == RUN_REST) {
            if (status == SALTUS_OK)
                status = saltus_equilibria_archive(b->equilibria, a, message);
            b->phase = RUN_BEGIN;
        } else {
            saltus_equilibria_free(b->equilibria);
            b->equilibria = NULL;
            archive_visited(b, a);
        }
        if (b->phase == RUN_FOLLOW)
            archive_trace(b, a);
    }
    if (status == SALTUS_NO_MEMORY || a->starved)
        return no_memory(message);
    bool whole = a->sound && (!a->reading || a->at == a->count);
    return status == SALTUS_OK && whole ? status : saltus_fail(message, SALTUS_BAD_INPUT, foreign);
}

saltus_status saltus_branch_save(saltus_branch *b, double **state, int *count, saltus_message *message) {
    saltus_archive archive = {.reading = false};
    *state = NULL;
    *count = 0;
    if (b->queue_next < b->queue_count || (b->locus && !saltus_locus_rests(b->locus)) ||
        (b->equilibria && !saltus_equilibria_rests(b->equilibria)))
        return SALTUS_OK;
    saltus_status status = archive_run(b, &archive, message);
    if (status != SALTUS_OK) {
        free(archive.made);
        return status;
    }
    *state = archive.made;
    *count = (int)archive.count;
    return status;
}

saltus_status saltus_branch_resume(saltus_branch *b, const double *state, int count, int *kept,
                                   saltus_message *message) {
    saltus_archive archive = {.reading = true, .given = state, .count = (size_t)count};
    saltus_status status = archive_run(b, &archive, message);
    *kept = status == SALTUS_OK ? (int)b->given_count : 0;
    return status;
}
