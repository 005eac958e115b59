/* How many orders a step's series need.
 *
 * Most steps use their series' full degree. A flight between the impacts of a chatter, or the last step to a
 * near target, ends much earlier, and a few orders suffice. The first orders are expanded first; the gap's
 * series then tells how long the flight will last. How many more orders that takes follows from these and
 * from a bound on the linear part's rate, and is checked: the event must come in the first half of the step
 * that the tolerance allows. Otherwise the expansion goes on to the full degree. Only a lane's own state
 * decides, so its bits do not depend on its neighbours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <math.h>

enum { first_orders = 4 };
/* A step that the tolerance allows must be this many times as long as the way ahead. */
static const double margin = 2;
/* In periods; a step of this length advances time in spite of rounding. */
static const double clock = 1e-12;

/* The longest stable step of a lower degree, which at worst falls in proportion to it. */
static double stable_step(const saltus_flow *flow, int lane, int degree) {
    return flow->work.lane->limit[lane] * degree / flow->lane[lane].degree;
}

double saltus_flow_brief(const saltus_system *system, int degree, double rtol) {
    const int less = degree - 2;
    return exp((log(rtol) + lgamma(less + 1)) / less) / (margin * system->rate);
}

/* The degree whose step covers the way ahead, estimated from the first orders: each further order adds a
 * factor of at most rate * time / order. At most the lane's own. */
static int degree_for(const saltus_flow *flow, int lane, double ahead) {
    const double reached = margin * ahead, turn = reached * flow->lane[lane].system->rate;
    const double part = reached / flow->work.lane->step[lane];
    double term = part * part * part * part;
    int degree = first_orders;
    while (degree < flow->lane[lane].degree && !(term <= 1 && reached <= stable_step(flow, lane, degree))) {
        term *= turn / (degree + 1) * (turn / (degree + 2));
        degree += 2;
    }
    return degree < flow->lane[lane].degree ? degree : flow->lane[lane].degree;
}

static void set_degree(saltus_flow *flow, int lane, int degree) {
    flow->work.lane->degree[lane] = degree;
    flow->shortened |= degree < flow->lane[lane].degree;
}

static void set_full_degrees(saltus_flow *flow) {
    for (int l = 0; l < flow->lanes; l++)
        flow->work.lane->degree[l] = flow->lane[l].degree;
    flow->shortened = false;
    saltus_work_settle_degrees(&flow->work);
}

static void expand(saltus_flow *flow, int from, int to) {
    saltus_fixed_expand(&flow->fixed, flow->kernel, flow->lane[0].system, &flow->work, from, to);
}

/* After the first orders: choose the degrees of the lanes in the set `hasty`, store their ways ahead. */
static void choose_degrees(saltus_flow *flow, unsigned hasty, double *ahead) {
    saltus_work *w = &flow->work;
    for (int l = 0; l < flow->lanes; l++)
        if (hasty >> l & 1)
            w->lane->degree[l] = first_orders;
    saltus_work_settle_degrees(w);
    flow->kernel->measure(w);
    for (int l = 0; l < flow->lanes; l++) {
        if (!(hasty >> l & 1))
            continue;
        ahead[l] = fmin(w->lane->left[l], saltus_events_forecast(flow, l));
        set_degree(flow, l, degree_for(flow, l, ahead[l]));
    }
    saltus_work_settle_degrees(w);
}

static bool is_short(const saltus_flow *flow, int lane) {
    return flow->work.lane->degree[lane] < flow->lane[lane].degree;
}

/* Restore full degrees in lanes whose series do not reach far enough; whether there are any. */
static bool raise_degrees(saltus_flow *flow, const double *ahead) {
    saltus_work *w = &flow->work;
    bool missed = false;
    for (int l = 0; l < flow->lanes; l++)
        if (is_short(flow, l) && !(margin * ahead[l] <= w->lane->step[l])) {
            w->lane->degree[l] = flow->lane[l].degree;
            missed = true;
        }
    saltus_work_settle_degrees(w);
    return missed;
}

/* Set the degree of each lane's next step. Tangent vectors that have just been set, or that an impact has
 * changed, hold transients that soon die away, for which a high degree reaches farthest. Once stability
 * bounds the steps of a lower degree too, more orders are of no use. */
static void choose_pace(saltus_flow *flow) {
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        const saltus_pace pace = self->settled ? self->later : self->first;
        flow->shortened |= pace.degree != self->degree;
        self->degree = pace.degree;
        flow->work.lane->limit[l] = flow->work.lane->reach[l] = pace.limit;
    }
}

/* Whether transients have died away: by the step just expanded, or that of the lower degree. */
static void judge_pace(saltus_flow *flow) {
    const double settled = 0.8, unsettled = 0.6; /* of the longest stable step */
    saltus_work *w = &flow->work;
    double step[SALTUS_LANES_MAX], degree[SALTUS_LANES_MAX];
    unsigned asked = 0;
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        step[l] = w->lane->step[l];
        degree[l] = w->lane->degree[l];
        if (degree[l] < self->degree || self->first.degree == self->later.degree)
            continue;
        if (!self->settled) {
            asked |= 1u << l;
            w->lane->degree[l] = self->later.degree;
        } else {
            self->settled = step[l] > unsettled * self->later.limit;
        }
    }
    if (!asked)
        return;
    saltus_work_settle_degrees(w);
    flow->kernel->measure(w);
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        if (asked >> l & 1)
            self->settled = w->lane->step[l] > settled * self->later.limit;
        w->lane->step[l] = step[l];
        w->lane->degree[l] = degree[l];
    }
    saltus_work_settle_degrees(w);
}

bool saltus_flow_expand(saltus_flow *flow) {
    saltus_work *w = &flow->work;
    double ahead[SALTUS_LANES_MAX];
    unsigned hasty = 0;
    if (flow->transients)
        choose_pace(flow);
    if (flow->shortened)
        set_full_degrees(flow);
    for (unsigned left = saltus_lanes_but(flow, flow->quiet); left; left &= left - 1) {
        const int l = __builtin_ctz(left);
        const saltus_lane *self = &flow->lane[l];
        if (self->target.aimed && self->hold.count == 0 &&
            (self->flight <= self->brief || w->lane->left[l] <= self->brief)) {
            hasty |= 1u << l;
            w->lane->reach[l] = w->lane->limit[l];
        }
    }
    const int full = w->degree_most;
    if (hasty) {
        expand(flow, 0, first_orders);
        choose_degrees(flow, hasty, ahead);
    }
    const int some = w->degree_most;
    if (!hasty || some > first_orders) {
        expand(flow, hasty ? first_orders : 0, some);
        if (!hasty && !flow->transients && !flow->shortened)
            return false;
        flow->kernel->measure(w);
    }
    if (flow->transients)
        judge_pace(flow);
    if (!flow->shortened)
        return true;
    if (raise_degrees(flow, ahead)) {
        if (some < full)
            expand(flow, some, w->degree_most);
        flow->kernel->measure(w);
    }
    for (int l = 0; l < flow->lanes; l++)
        if (is_short(flow, l))
            w->lane->step[l] = fmin(w->lane->step[l], fmax(margin * ahead[l], clock * w->lane->period[l]));
    return true;
}
