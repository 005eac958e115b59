/* The points that a run gives out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/trail.h"

#include "branch/point.h"
#include "orbit/held.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A special point that was given out. */
typedef struct visited {
    saltus_point_kind kind;
    int branch, periods;
    char label[2][SALTUS_LABEL_MAX]; /* at it and beyond it */
    double value, period;            /* period 0: none */
    double accuracy;                 /* of the value; 0: not known */
    bool joined;                     /* a branch joins another one there, and has not been on it */
    double state[SALTUS_STATE_MAX];
} visited;

static double period_of(const saltus_branch_point *point) {
    return isfinite(point->period) ? point->period : 0;
}

void saltus_trail_drop(saltus_trail *t) {
    saltus_branch_point point;
    while (saltus_trail_take(t, &point))
        saltus_branch_point_clear(&point);
}

void saltus_trail_clear(saltus_trail *t) {
    saltus_trail_drop(t);
    free(t->visited.items);
    free(t->queue.items);
}

void saltus_trail_begin(saltus_trail *t, int number, int parent, int depth, bool fresh) {
    t->number = number;
    t->parent = parent;
    t->depth = depth;
    t->regular = t->made = 0;
    t->arclength = t->shown = 0;
    t->step = t->options->step;
    t->fresh = fresh;
    t->following = true;
}

bool saltus_trail_switches(const saltus_trail *t) {
    return t->following && t->depth < t->options->switches;
}

saltus_branch_start saltus_trail_leaving(const saltus_trail *t) {
    return (saltus_branch_start){.parent = t->number, .depth = t->depth + 1};
}

/* Sets of kinds. At `marginal` ones a multiplier is on the unit circle to rounding, or an eigenvalue on the
 * imaginary axis. Branches of orbits, or of equilibria, end where they meet a point of the other sets that
 * was visited. The places of `sharply` known ones are zeros of smooth functions. */
static const unsigned marginal = 1u << SALTUS_POINT_LP | 1u << SALTUS_POINT_PD | 1u << SALTUS_POINT_BP |
                                 1u << SALTUS_POINT_NS | 1u << SALTUS_POINT_HB,
                      orbits_meet = 1u << SALTUS_POINT_LP | 1u << SALTUS_POINT_PD | 1u << SALTUS_POINT_NS |
                                    1u << SALTUS_POINT_GR | 1u << SALTUS_POINT_CH | 1u << SALTUS_POINT_ST,
                      sharply = 1u << SALTUS_POINT_LP | 1u << SALTUS_POINT_PD | 1u << SALTUS_POINT_NS |
                                1u << SALTUS_POINT_GR | 1u << SALTUS_POINT_CH,
                      rests_meet = 1u << SALTUS_POINT_LP | 1u << SALTUS_POINT_BE;

/* The branch on which a special point was given out before; -1: none. Points of branches that cross, or begin
 * at one another, differ in kind or period. Where impacts die one after the other, points lie close together
 * without being the same; they differ in the number of impacts. Folds of cycles near a homoclinic orbit
 * differ only in their period. */
static int find_visited(const saltus_trail *t, const saltus_system *system, const saltus_branch_point *point,
                        const double *points) {
    const int count = points ? point->periods : 1;
    const double unit = t->options->high[0] - t->options->low[0];
    const char *at = point->label, *after = point->label_after;
    for (int k = 0; k < t->visited.count; k++) {
        const visited *v = (const visited *)t->visited.items + k;
        /* At both, the same two motions meet, in either order. Beyond the end of chatter there are orbits
         * with any number of impacts. */
        const bool same = v->kind == SALTUS_POINT_CH ||
                          (strcmp(v->label[0], at) == 0 && strcmp(v->label[1], after) == 0) ||
                          (strcmp(v->label[0], after) == 0 && strcmp(v->label[1], at) == 0);
        const bool sharp = sharply >> v->kind & 1 && v->accuracy > 0 && isfinite(point->accuracy);
        const double close_value = !same    ? 1e-11
                                   : !sharp ? 1e-7
                                            : fmin(1e-7, 1e-9 + 10 * (v->accuracy + point->accuracy) / unit);
        const double close_state = same ? 1e-5 : 1e-7;
        if (!v->joined && v->kind == point->kind && v->periods == point->periods &&
            saltus_trail_same_period(v->period, period_of(point)) &&
            fabs(v->value - point->value[0]) < close_value * unit &&
            saltus_orbit_passes(system, points ? points : point->state, count, v->state, close_state))
            return v->branch;
    }
    return -1;
}

/* Add one at a state of n numbers. */
static void add_visited(saltus_trail *t, const visited *fresh, const double *state, int n, bool *starved) {
    visited *own = saltus_list_grow(&t->visited, sizeof *own, starved);
    if (!own)
        return;
    *own = *fresh;
    memcpy(own->state, state, (size_t)n * sizeof *state);
}

int saltus_trail_find(const saltus_trail *t, const saltus_system *system, saltus_point_kind kind,
                      double period, double value, const double *points, int count, bool joined,
                      int *branch) {
    const double close_value = 1e-7 * (t->options->high[0] - t->options->low[0]), close_state = 1e-5;
    for (int k = 0; k < t->visited.count; k++) {
        const visited *v = (const visited *)t->visited.items + k;
        if (v->kind != kind || !saltus_trail_same_period(v->period, period) || (joined && !v->joined) ||
            !(fabs(v->value - value) < close_value) ||
            !saltus_orbit_passes(system, points, count, v->state, close_state))
            continue;
        if (branch)
            *branch = v->branch;
        return k + 1;
    }
    return 0;
}

int saltus_trail_join(saltus_trail *t, const saltus_system *system, saltus_point_kind kind, double period,
                      double value, const double *state, bool *starved) {
    const visited fresh = {
        .kind = kind, .branch = t->number, .period = period, .value = value, .joined = true};
    add_visited(t, &fresh, state, saltus_system_dimension(system), starved);
    return t->visited.count;
}

bool saltus_trail_keeps(saltus_point_kind kind) {
    return orbits_meet >> kind & 1;
}

/* Choose a critical multiplier, or pair: the nearest to the circle or axis, those of its sign first; one of
 * two equal ones, which rounding may have made a pair, the nearest to their place. It is not known where
 * rounding hides that it is critical. */
static bool choose_critical(saltus_branch_point *point, int sign, bool pair, bool equal, bool *critical) {
    const double other_sign = 1, hidden = 1e-2; /* the first of the logarithm */
    saltus_multiplier *mu = point->multipliers;
    double least = INFINITY;
    int found = -1;
    for (int k = 0; k < point->multiplier_count; k++) {
        const double off = equal ? hypot(mu[k].re - sign, mu[k].im)
                                 : fabs(mu[k].log_modulus) + (sign * mu[k].re < 0 ? other_sign : 0);
        if (critical[k] || !(off < least) || (!equal && (mu[k].im != 0) != pair))
            continue;
        least = off;
        found = k;
    }
    if (found >= 0)
        critical[found] = critical[found + (pair && !equal)] = true;
    if (found >= 0 && sign && !equal && fabs(mu[found].re - sign) > hidden)
        mu[found] = (saltus_multiplier){NAN, NAN, NAN};
    return found >= 0;
}

/* The number of multipliers outside the unit circle, or of eigenvalues with positive real part, at a point of
 * this kind on a curve of a `marginal` kind. Rounding decides on which side the critical ones are. They are
 * not counted. Along an orbit of twice the period a flip's multiplier is 1. */
static int count_outside(saltus_branch_point *point, saltus_point_kind curve, saltus_point_kind kind,
                         bool joins) {
    const bool rest = !point->periods, pair = curve == SALTUS_POINT_NS || (curve == SALTUS_POINT_HB && rest),
               equal = kind == SALTUS_POINT_R1 || kind == SALTUS_POINT_R2 || kind == SALTUS_POINT_BT ||
                       (kind == SALTUS_POINT_R4 && joins);
    const int flip = joins ? 1 : -1;
    const bool flips = kind == SALTUS_POINT_R2 || curve == SALTUS_POINT_PD;
    const int sign = rest || (pair && !equal) ? 0 : flips ? flip : 1;
    saltus_multiplier others[SALTUS_STATE_MAX];
    saltus_eigenvalue rates[SALTUS_STATE_MAX];
    bool critical[SALTUS_STATE_MAX + 1] = {false};
    int count = 0;
    if (!choose_critical(point, sign, pair, equal, critical))
        return point->unstable;
    if (equal)
        choose_critical(point, sign, pair, equal, critical);
    else if (kind == SALTUS_POINT_PD_NS)
        choose_critical(point, pair ? flip : 0, !pair, false, critical);
    else if (kind == SALTUS_POINT_LP_PD)
        choose_critical(point, curve == SALTUS_POINT_PD ? 1 : flip, false, false, critical);
    for (int k = 0; k < point->multiplier_count; k++)
        if (!critical[k]) {
            rates[count] = (saltus_eigenvalue){point->multipliers[k].re, point->multipliers[k].im};
            others[count++] = point->multipliers[k];
        }
    return rest    ? saltus_eigenvalues_growing(rates, count).growing
           : count ? saltus_multipliers_unstable(others, count)
                   : 0;
}

/* `point`: the last in the queue. */
static void judge_stability(const saltus_trail *t, const saltus_notice *what, saltus_branch_point *point) {
    const saltus_point_kind kind = point->locus ? point->locus : what->kind ? what->kind : what->origin;
    const saltus_branch_point *last = t->queue.count > 1 ? point - 1 : NULL;
    const bool again = what->kind == SALTUS_POINT_EP && last && last->branch == t->number &&
                       last->arclength == t->arclength + what->ahead;
    if (again && marginal >> (last->locus ? last->locus : last->kind) & 1) {
        /* The branch ends at a point given out already. */
        point->stable = last->stable;
        point->unstable = last->unstable;
        memcpy(point->multipliers, last->multipliers, (size_t)point->dimension * sizeof *point->multipliers);
    } else if (marginal >> kind & 1) {
        point->stable = false;
        point->unstable = count_outside(point, kind, what->kind, what->joins);
    }
}

void saltus_trail_give(saltus_trail *t, const saltus_system *system, saltus_branch_point *fresh,
                       const double *points, const saltus_notice *what, bool *starved) {
    const saltus_branch_options *o = t->options;
    saltus_branch_point *point = saltus_list_grow(&t->queue, sizeof *point, starved);
    if (!point) {
        saltus_branch_point_clear(fresh);
        t->following = false;
        return;
    }
    *point = *fresh;
    judge_stability(t, what, point);
    point->kind = what->kind;
    point->branch = t->number;
    point->parent = t->parent;
    point->step = point->locus ? t->made : t->regular;
    point->arclength = t->arclength + what->ahead;
    point->value[0] = what->value ? *what->value : point->value[0];
    /* Values are sums of where the run began and a part of the range. */
    point->accuracy = what->accuracy + DBL_EPSILON * fmax(fabs(point->value[0]), o->high[0] - o->low[0]);
    /* These are known only from the event-driven flow, to its tolerance. */
    if (what->kind == SALTUS_POINT_CH || what->kind == SALTUS_POINT_CH_GR || what->kind == SALTUS_POINT_ST)
        point->accuracy += o->orbit.flow.rtol * (o->high[0] - o->low[0]);
    snprintf(point->label_after, sizeof point->label_after, "%s", what->after ? what->after : "");
    snprintf(point->reason, sizeof point->reason, "%s%s", what->reason ? what->reason : "",
             what->addition ? what->addition : "");
    const unsigned meets = point->locus ? 0 : point->periods ? orbits_meet : rests_meet;
    const bool kept = meets >> point->kind & 1;
    const bool crosses = !point->locus && point->periods && point->kind == SALTUS_POINT_BP;
    const int earlier = kept ? find_visited(t, system, point, points) : -1;
    if ((kept && earlier < 0) || crosses) {
        visited own = {.kind = point->kind,
                       .branch = t->number,
                       .periods = point->periods,
                       .value = point->value[0],
                       .period = period_of(point),
                       .accuracy = isfinite(point->accuracy) ? point->accuracy : 0};
        memcpy(own.label[0], point->label, SALTUS_LABEL_MAX);
        memcpy(own.label[1], point->label_after, SALTUS_LABEL_MAX);
        add_visited(t, &own, point->state, point->dimension, starved);
    }
    if (earlier >= 0) {
        point->kind = SALTUS_POINT_EP;
        snprintf(point->reason, sizeof point->reason,
                 earlier == t->number ? "the branch is closed: it has come back to this %s"
                                      : "this %s is on branch %d",
                 saltus_point_word(what->kind), earlier);
    }
    if (point->kind != SALTUS_POINT_EP && t->made + 1 >= o->points) {
        point->kind = SALTUS_POINT_EP;
        snprintf(point->reason, sizeof point->reason, "as many points as asked for");
    }
    if ((point->kind == SALTUS_POINT_GR || point->kind == SALTUS_POINT_BE) && what->grazing)
        saltus_point_mark_grazing(system, what->grazing, point);
    t->following = t->following && point->kind != SALTUS_POINT_EP;
    t->made++;
}

bool saltus_trail_wants(const saltus_trail *t, double ahead) {
    return t->arclength + ahead - t->shown >= 0.02 * t->options->step_max || t->regular == 0;
}

void saltus_trail_shown(saltus_trail *t, double ahead) {
    t->shown = t->arclength + ahead;
    t->regular++;
}

void saltus_trail_jump(saltus_trail *t, double ahead) {
    t->arclength += ahead;
    t->shown = t->arclength;
    t->step = fmin(t->step, t->options->step);
}

saltus_branch_point *saltus_trail_last(saltus_trail *t) {
    return t->queue.count ? (saltus_branch_point *)t->queue.items + t->queue.count - 1 : NULL;
}

void saltus_trail_drop_last(saltus_trail *t) {
    saltus_branch_point_clear(saltus_trail_last(t));
    t->queue.count--;
    t->made--;
}

bool saltus_trail_take(saltus_trail *t, saltus_branch_point *point) {
    if (t->next == t->queue.count)
        return false;
    *point = ((saltus_branch_point *)t->queue.items)[t->next++];
    if (t->next == t->queue.count)
        t->next = t->queue.count = 0;
    return true;
}

void saltus_trail_archive(saltus_trail *t, saltus_archive *a) {
    enum { numbers_min = 9 }; /* per visited point */
    t->visited.items =
        saltus_archive_list(a, t->visited.items, &t->visited.count, sizeof(visited), numbers_min);
    t->visited.room = a->reading ? t->visited.count : t->visited.room;
    for (int k = 0; k < t->visited.count; k++) {
        visited *v = (visited *)t->visited.items + k;
        v->kind = saltus_archive_kind(a, v->kind, ~0u);
        v->branch = (int)saltus_archive_whole(a, v->branch, 0, INT_MAX);
        v->periods = (int)saltus_archive_whole(a, v->periods, 0, INT_MAX);
        saltus_archive_label(a, v->label[0]);
        saltus_archive_label(a, v->label[1]);
        saltus_archive_finite(a, &v->value, 1);
        saltus_archive_finite(a, &v->period, 1);
        saltus_archive_finite(a, &v->accuracy, 1);
        saltus_archive_finite(a, v->state, (size_t)a->n);
        v->joined = saltus_archive_flag(a, v->joined);
    }
    t->number = (int)saltus_archive_whole(a, t->number, 0, INT_MAX);
    t->parent = (int)saltus_archive_whole(a, t->parent, -1, INT_MAX);
    t->depth = (int)saltus_archive_whole(a, t->depth, 0, INT_MAX);
    t->regular = (int)saltus_archive_whole(a, t->regular, 0, INT_MAX);
    t->made = (int)saltus_archive_whole(a, t->made, 0, INT_MAX);
    saltus_archive_finite(a, &t->arclength, 1);
    saltus_archive_finite(a, &t->shown, 1);
    saltus_archive_finite(a, &t->step, 1);
    t->fresh = saltus_archive_flag(a, t->fresh);
    t->following = saltus_archive_flag(a, t->following);
    a->sound = a->sound && (!a->reading || !t->following || t->step > 0);
}
