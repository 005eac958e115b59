/* Events on the step's polynomial. The contract is at the head of flow.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include "base/dense.h"

#include <float.h>
#include <math.h>
#include <string.h>

static int degree_of(const saltus_flow *flow, int lane) {
    return (int)flow->work.lane->degree[lane];
}

/* c_k = factor * series_k step^k, for the gap series of a stop or the force series of a contact. */
static void scaled_series(const saltus_flow *flow, int lane, const double *all, int which, int first,
                          double factor, int degree, double step, double *c) {
    const double *series = all + saltus_work_series_place(&flow->work, which, first, lane);
    for (int k = 0; k <= degree; k++) {
        c[k] = factor * series[k * flow->lanes];
        factor *= step;
    }
}

/* The gap of a face over the step, in s = t / step. Known zeros at the start are set exactly. */
static void gap_polynomial(const saltus_flow *flow, int lane, int face, double step, double *c) {
    const saltus_face f = flow->lane[lane].system->faces[face];
    const saltus_face_state *known = &flow->lane[lane].face[face];
    scaled_series(flow, lane, flow->work.gap, f.stop, 0, f.side, degree_of(flow, lane), step, c);
    c[0] -= f.d;
    if (known->shadow) {
        c[0] = known->gap;
        c[1] = known->rate * step;
    }
    for (int k = 0; k < known->touch; k++)
        c[k] = 0;
}

/* Minus the force of a lane's k-th held contact over the step; its degree is two less than a gap's. */
static void force_polynomial(const saltus_flow *flow, int lane, int contact, double step, double *c) {
    scaled_series(flow, lane, flow->work.hold.force, contact, 0, -1, degree_of(flow, lane) - 2, step, c);
}

/* First rise of c through zero on (0, 1]; the first `touch` coefficients, zeros at the start, are divided
 * out. A start above zero is a rise at once, unless c falls from there: then rounding has lifted it, and the
 * rise after the fall is sought. */
static bool first_rise(const double *c, int degree, int touch, double *root) {
    while (touch < degree && c[touch] == 0)
        touch++;
    if (c[touch] > 0 && !(touch + 1 <= degree && c[touch + 1] < 0)) {
        *root = 0;
        return true;
    }
    /* Most polynomials stay negative even with all positive terms at their largest. */
    double bound = c[touch];
    for (int k = touch + 1; k <= degree; k++)
        bound += c[k] > 0 ? c[k] : 0;
    if (bound < -1e-14 * fabs(c[touch]))
        return false;
    return saltus_isolate_rise(c + touch, degree - touch, root);
}

/* The rise through zero of a polynomial of degree 4 that starts at or below zero, by Newton's method from its
 * parabola's zero; infinite if the parabola has none. */
static double rise_of_quartic(const double *c) {
    enum { rounds = 2 };
    const double inside = c[1] * c[1] - 4 * c[2] * c[0];
    double t = c[0] < 0 ? 2 * c[0] / (-c[1] - sqrt(inside)) : -c[1] / c[2];
    for (int k = 0; k < rounds && t > 0; k++) {
        const double value = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4]))),
                     slope = c[1] + t * (2 * c[2] + t * (3 * c[3] + t * 4 * c[4]));
        t -= value / slope;
    }
    return t > 0 ? t : INFINITY;
}

double saltus_events_forecast(const saltus_flow *flow, int lane) {
    const saltus_lane *self = &flow->lane[lane];
    double c[SALTUS_DEGREE_MAX + 1], soonest = INFINITY;
    if (self->target.coasting)
        return soonest;
    for (int f = 0; f < self->system->face_count; f++)
        if (self->face[f].touch == 1 || self->face[f].shadow) {
            gap_polynomial(flow, lane, f, 1, c);
            soonest = fmin(soonest, rise_of_quartic(c));
        }
    return soonest;
}

/* The earliest event wins; of two at the same time, the one proposed first. */
static void propose(saltus_first_event *first, saltus_event_kind kind, int face, double time) {
    if (!(time > first->time || (time == first->time && first->kind != SALTUS_STEP)))
        *first = (saltus_first_event){time, kind, face};
}

static void search_gaps(const saltus_flow *flow, int lane, double step, saltus_first_event *first) {
    const saltus_lane *self = &flow->lane[lane];
    double c[SALTUS_DEGREE_MAX + 1], root;
    for (int f = 0; f < self->system->face_count; f++) {
        const saltus_face_state *known = &self->face[f];
        bool open = known->touch == 0 && !known->shadow && flow->work.lane->margin[f][lane] < 0;
        if (self->hold.faces >> f & 1 || open)
            continue;
        gap_polynomial(flow, lane, f, step, c);
        if (first_rise(c, degree_of(flow, lane), known->touch, &root))
            propose(first, SALTUS_IMPACT, f, root * step);
    }
}

static void search_forces(const saltus_flow *flow, int lane, double step, saltus_first_event *first) {
    const saltus_contact_map *hold = &flow->lane[lane].hold;
    double c[SALTUS_DEGREE_MAX + 1], root;
    for (int k = 0; k < hold->count; k++) {
        force_polynomial(flow, lane, k, step, c);
        c[0] -= flow->lane[lane].face[hold->face[k]].pull;
        if (first_rise(c, degree_of(flow, lane) - 2, 0, &root))
            propose(first, SALTUS_RELEASE, hold->face[k], root * step);
    }
}

/* Whether the held contacts also fix the observed displacement: accelerations a - push (pull . a) leave it
 * unchanged. */
static bool observer_held(const saltus_lane *self) {
    const saltus_contact_map *hold = &self->hold;
    const double *observer = self->system->observer.row;
    const int n = self->system->dof;
    double left = 0, size = 0;
    if (hold->count == 0)
        return false;
    for (int i = 0; i < n; i++) {
        double moved = observer[i];
        for (int k = 0; k < hold->count; k++)
            moved -= saltus_dot(observer, hold->push + k * n, n) * hold->pull[k * n + i];
        left = fmax(left, fabs(moved));
        size = fmax(size, fabs(observer[i]));
    }
    return left <= 1e-12 * size;
}

/* The observed velocity over a step, in s = t / step, with the zero at its start set exactly if the lane
 * `starts_at` one. Returns how many leading coefficients are zero; -1: the velocity is zero throughout. */
static int velocity_polynomial(const saltus_flow *flow, int lane, double step, bool starts_at, double *c) {
    const saltus_lane *self = &flow->lane[lane];
    const int degree = degree_of(flow, lane) - 1;
    double size = 0;
    int touch = 0;
    if (observer_held(self))
        return -1;
    scaled_series(flow, lane, flow->work.gap, self->system->observer.first, 1, 1, degree, step, c);
    for (int k = 0; k <= degree; k++) {
        c[k] *= k + 1;
        size += fabs(c[k]);
    }
    /* If contacts fix the observed point only rounding is left. After a turning point, an impact without
     * rebound or a release, the first coefficients are zero up to rounding. */
    if (size <= 1e-12 * self->system->scale[self->system->dof])
        return -1;
    while (touch < 3 && (fabs(c[touch]) <= 1e-13 * size || (touch == 0 && starts_at)))
        c[touch++] = 0;
    return touch;
}

/* Zeros of the observed velocity, rising or falling. */
static void search_turning(const saltus_flow *flow, int lane, double step, saltus_first_event *first) {
    const int degree = degree_of(flow, lane) - 1;
    double c[SALTUS_DEGREE_MAX + 1] = {0}, root;
    const int touch = velocity_polynomial(flow, lane, step, flow->lane[lane].turned, c);
    const double sign = touch >= 0 && c[touch] > 0 ? -1 : 1;
    for (int k = 0; k <= degree; k++)
        c[k] *= sign;
    if (touch >= 0 && c[touch] != 0 && first_rise(c, degree, touch, &root))
        propose(first, SALTUS_TURNING, -1, root * step);
}

/* Shift the origin of a polynomial to its zero `root`, of odd order, and rescale [root, 1] to [0, 1]. */
static void restart_at_zero(double *c, int degree, double root) {
    double factor = 1;
    for (int k = 0; k < degree; k++)
        for (int j = degree - 1; j >= k; j--)
            c[j] = fma(root, c[j + 1], c[j]);
    for (int k = 0; k <= degree; k++, factor *= 1 - root)
        c[k] *= factor;
    c[0] = 0;
}

static void raise_extreme(const saltus_lane *self, const double *c, int degree, double s, double step,
                          saltus_extreme *extreme) {
    const double first = 1e-6, last = 1e-4;
    double value = c[degree];
    for (int k = degree - 1; k >= 0; k--)
        value = fma(value, s, c[k]);
    if (!(value > extreme->inner))
        return;
    saltus_time time = saltus_time_after(self->now, s * step / self->system->period);
    if (value > extreme->value) {
        extreme->value = value;
        extreme->time = time;
    }
    if (saltus_time_between(self->target.since, time) > first &&
        saltus_time_between(time, self->target.until) > last) {
        extreme->inner = value;
        extreme->inner_time = time;
    }
}

/* Raise `extreme` to the local maxima of c on (0, 1). If another step follows, a maximum at the end counts
 * too: rounding may hide it from both steps. */
static void collect_maxima(const saltus_lane *self, const double *c, int degree, double step, bool last,
                           saltus_extreme *extreme) {
    double slope[SALTUS_DEGREE_MAX + 1], begin = 0, end = 0, size = 0, root;
    int touch = 0;
    for (int k = 0; k < degree; k++) {
        slope[k] = (k + 1) * c[k + 1];
        end += slope[k];
        size += fabs(slope[k]);
    }
    const bool level = !last && fabs(end) <= 1e-13 * size;
    for (int turns = 0; turns < degree; turns++) {
        double sign = slope[touch] > 0 ? -1 : 1;
        for (int k = touch; k < degree; k++)
            slope[k] *= sign;
        if (slope[touch] == 0 || !saltus_isolate_rise(slope + touch, degree - 1 - touch, &root)) {
            if (sign < 0 && level)
                raise_extreme(self, c, degree, 1, step, extreme);
            return;
        }
        begin += root * (1 - begin);
        if (sign < 0)
            raise_extreme(self, c, degree, begin, step, extreme);
        restart_at_zero(slope, degree - 1, root);
        for (int k = 0; k < degree; k++)
            slope[k] *= sign;
        touch = 1;
    }
}

/* Raise the lane's extremes to the local maxima of gaps and of minus the contact forces within the step. */
static void collect_extremes(const saltus_flow *flow, int lane, double step) {
    const saltus_lane *self = &flow->lane[lane];
    const int degree = degree_of(flow, lane);
    const bool last = step == flow->work.lane->left[lane];
    double c[SALTUS_DEGREE_MAX + 1];
    for (int f = 0; f < self->system->face_count; f++)
        if (!(self->hold.faces >> f & 1)) {
            gap_polynomial(flow, lane, f, step, c);
            collect_maxima(self, c, degree, step, last, &self->target.extremes[f]);
        }
    for (int k = 0; k < self->hold.count; k++) {
        force_polynomial(flow, lane, k, step, c);
        collect_maxima(self, c, degree - 2, step, last, &self->target.extremes[self->hold.face[k]]);
    }
}

saltus_first_event saltus_events_first(saltus_flow *flow, int lane, double step) {
    const saltus_lane *self = &flow->lane[lane];
    saltus_first_event first = {step, SALTUS_STEP, -1};
    if (self->target.coasting) {
        if (self->target.extremes)
            collect_extremes(flow, lane, step);
        return first;
    }
    search_gaps(flow, lane, step, &first);
    if (self->hold.count)
        search_forces(flow, lane, step, &first);
    if (self->target.watch & SALTUS_WATCH_TURNING && self->step.turns)
        search_turning(flow, lane, step, &first);
    return first;
}

/* The highest term of a row's velocity: Taylor series of velocities and displacements have one degree, so the
 * gap's derivative lacks it. Without it the carried rate would differ from the state's. */
static double velocity_term(const saltus_flow *flow, int lane, const double *row) {
    const saltus_work *w = &flow->work;
    double sum = 0;
    const double *newest = w->jet.v + saltus_work_place(w, degree_of(flow, lane), 0, 0, lane);
    for (int i = 0; i < flow->dof && !flow->collocated; i++)
        sum += row[i] * newest[i * flow->lanes];
    return sum;
}

/* Zero of the velocity c in (0, 1], if it is negative at 0 and its derivative is surely positive: by Newton's
 * method, to about 1e-8, more than a turning point needs, whose displacement hardly depends on its place.
 * False if it is not sure. */
static bool quick_rise(const double *c, int degree, double *root) {
    enum { rounds = 20 };
    double slowest = c[1], end = c[0] + c[1];
    for (int k = 2; k <= degree; k++) {
        slowest += c[k] < 0 ? k * c[k] : 0;
        end += c[k];
    }
    if (!(slowest > 0) || !(c[0] < 0) || !(end > -c[0] * 1e-9))
        return false;
    double place = c[0] / (c[0] - end);
    for (int k = 0; k < rounds; k++) {
        double value = c[degree], slope = 0;
        for (int j = degree - 1; j >= 0; j--) {
            slope = slope * place + value;
            value = value * place + c[j];
        }
        const double next = place - value / slope, moved = fabs(next - place);
        if (!(next > 0 && next <= 1))
            return false;
        place = next;
        if (moved <= 3e-5 * place) {
            *root = place;
            return true;
        }
    }
    return false;
}

/* Whether no displacement within a step leaves a range, by its start and all terms to either side. */
static bool stays_within(const double *series, int stride, int degree, double step, double low, double high) {
    double factor = 1, up = 0, down = 0;
    for (int k = 1; k <= degree; k++) {
        factor *= step;
        const double term = series[k * stride] * factor;
        up += term > 0 ? term : 0;
        down += term < 0 ? term : 0;
    }
    const double rounding = 1e-14 * (fabs(series[0]) + up - down);
    return series[0] + up + rounding < high && series[0] + down - rounding > low;
}

/* Of two neighbouring steps' polynomials each may see a turning point where they meet, because the highest
 * orders of displacement and velocity differ by the tolerance: so near to the end, the next step begins with
 * the zero. A zero that has been found is divided out, so that the next one is the first again. */
void saltus_events_turnings(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    const double step = flow->work.lane->advance[lane], end = 1 - 10 * flow->options.rtol;
    const double *series =
        flow->work.gap + saltus_work_series_place(&flow->work, self->system->observer.first, 0, lane);
    const bool meets = 1u << self->pending.kind & SALTUS_WATCH_CONTACT;
    const saltus_turnings *t = &self->target.turnings;
    double velocity[SALTUS_DEGREE_MAX + 1], *c = velocity, root = 0;
    int degree = degree_of(flow, lane) - 1, heading = 1;
    if (t->low && stays_within(series, flow->lanes, degree + 1, step, *t->low, *t->high)) {
        self->passing = false;
        return;
    }
    const int touch = velocity_polynomial(flow, lane, step, self->passing, c);
    self->passing = false;
    c += touch > 0 ? touch : 0;
    degree -= touch;
    while (touch >= 0 && degree > 0 && root <= end && c[0] != 0) {
        double displacement = 0;
        const int sign = c[0] > 0 ? -1 : 1;
        heading *= sign;
        for (int k = 0; k <= degree; k++)
            c[k] *= sign;
        if (!quick_rise(c, degree, &root) && !first_rise(c, degree, 0, &root))
            return;
        if (root >= 1 && meets)
            return;
        for (int k = degree_of(flow, lane); k >= 0; k--)
            displacement = displacement * (root * step) + series[k * flow->lanes];
        t->take(t->context, displacement, heading);
        self->passing = root > end && !meets;
        for (int k = degree - 1; k > 0; k--)
            c[k] += root * c[k + 1];
        c++;
        degree--;
    }
}

double saltus_events_acceleration(const saltus_flow *flow, int lane, int row, const double *observer,
                                  double since) {
    const double *series = flow->work.gap + saltus_work_series_place(&flow->work, row, 0, lane);
    const int degree = degree_of(flow, lane);
    double sum = degree * velocity_term(flow, lane, observer);
    double number = degree;
    for (int k = degree; k >= 2; k--, number -= 1)
        sum = sum * since + number * (number - 1) * series[k * flow->lanes];
    return sum;
}

bool saltus_events_carry(saltus_flow *flow, int lane, double step, int event_face, double *gap) {
    saltus_lane *self = &flow->lane[lane];
    int degree = degree_of(flow, lane);
    double c[SALTUS_DEGREE_MAX + 1];
    if (self->target.coasting) {
        memset(self->face, 0, sizeof self->face);
        return true;
    }
    for (int f = 0; f < self->system->face_count; f++) {
        saltus_face_state *known = &self->face[f];
        if (f == event_face || self->hold.faces >> f & 1 || (known->touch == 0 && !known->shadow))
            continue;
        gap_polynomial(flow, lane, f, step, c);
        const saltus_face face = self->system->faces[f];
        double value = 0, rate = 0, power = step, near = 1e-6 * (fabs(face.d) + self->system->scale[0]);
        double number = degree;
        for (int k = degree; k > 0; k--, number -= 1) {
            value += c[k];
            rate += number * c[k];
            power *= step;
        }
        value += c[0];
        rate += face.side * velocity_term(flow, lane, self->system->stop_normal[face.stop]) * power;
        *gap = value;
        if (value > near)
            return false;
        if (step > 0)
            *known = (saltus_face_state){
                .shadow = value > -near, .gap = value < 0 ? value : -DBL_MIN, .rate = rate / step};
    }
    return true;
}
