/* Once around an orbit with a prescribed sequence: residuals, Jacobian and breaches.
 *
 * The orbit is walked in pieces between cuts and marks. A mark at time t contributes its equation's gradient
 * as a row, and adds to the column of t the shift caused by a delay (saltus_strike).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/shooting.h"

#include <math.h>
#include <string.h>

/* Present state of the walk. */
typedef struct walk {
    saltus_shooting *p;
    saltus_flow *flow;
    bool whole;      /* the flow has all tangent vectors; otherwise none */
    bool collects;   /* collect the derivative in short segments */
    double period;   /* of the flow's system */
    const double *u; /* unscaled unknowns */
    double time;     /* in periods */
    bool driven;
    double held_since[SALTUS_FACES_MAX]; /* when each face began to hold */
} walk;

double saltus_shooting_omega(const saltus_shooting *p, const double *u) {
    return p->sequence.omega > 0 ? saltus_spec_omega(&p->family.spec) * exp(-u[p->count - 1]) : 0;
}

/* Copy the flow's parameter columns into the matrix. */
static void take_parameters(const saltus_response *r, double *answer) {
    for (int d = 0; d < r->directions; d++)
        for (int i = 0; i < r->n && r->place[d] >= 0; i++)
            answer[i * r->unknowns + r->place[d]] = r->tangents[(r->n + d) * r->n + i];
}

/* Start a segment, whose state is the unknowns from `first` on, and whose first mark's time that at `times`,
 * with the flow's vectors there. */
static void start_response(saltus_response *r, saltus_flow *flow, int first, int times) {
    const size_t size = (size_t)(r->n * r->unknowns) * sizeof *r->answer;
    r->state = first;
    r->times = times;
    r->passed = 0;
    saltus_flow_tangents(flow, 0, r->tangents);
    memset(r->answer, 0, size);
    memset(r->next, 0, size);
    for (int i = 0; i < r->n; i++)
        for (int k = 0; k < r->n; k++)
            r->answer[i * r->unknowns + first + k] = r->tangents[k * r->n + i];
    take_parameters(r, r->answer);
}

static void begin_piece(saltus_response *r, saltus_flow *flow) {
    const int n = r->n;
    memset(r->tangents, 0, (size_t)(n * (n + r->directions)) * sizeof *r->tangents);
    for (int i = 0; i < n; i++)
        r->tangents[i * n + i] = 1;
    for (int d = 0; d < r->directions; d++)
        for (int i = 0; i < n && r->place[d] >= 0; i++)
            r->tangents[(n + d) * n + i] = r->answer[i * r->unknowns + r->place[d]];
    saltus_flow_set_tangents(flow, 0, r->tangents);
}

/* Multiply the columns from `first` on by the derivative over the piece. */
static void carry_columns(saltus_response *r, int first, int count) {
    const int n = r->n, m = r->unknowns;
    for (int i = 0; i < n && count > 0; i++) {
        double *restrict to = r->next + i * m + first;
        memset(to, 0, (size_t)count * sizeof *to);
        for (int k = 0; k < n; k++) {
            const double *restrict column = r->answer + k * m + first;
            const double share = r->tangents[k * n + i];
            for (int j = 0; j < count; j++)
                to[j] = fma(share, column[j], to[j]);
        }
    }
}

/* The other unknowns belong to other segments or later marks: they have no effect yet, and zeros in both
 * matrices since the segment's start. */
static void end_piece(saltus_response *r, saltus_flow *flow) {
    saltus_flow_tangents(flow, 0, r->tangents);
    carry_columns(r, r->state, r->n);
    carry_columns(r, r->times, r->passed);
    take_parameters(r, r->next);
    SALTUS_SWAP(r->answer, r->next);
}

/* The derivatives of a quantity at a mark by the unknowns, in units of `scale`, from its gradient along the
 * tangent vectors, its rate per period, and the matrix before the piece that led to the mark. Unknown `own`
 * is the mark's time, in periods. */
static void respond_at_mark(const saltus_response *r, const double *gradient, double rate, double scale,
                            int own, double *restrict row) {
    memset(row, 0, (size_t)r->unknowns * sizeof *row);
    for (int i = 0; i < r->n; i++) {
        const double *restrict answer = r->answer + i * r->unknowns;
        const double share = gradient[i] / scale;
        for (int j = r->state; j < r->state + r->n; j++)
            row[j] = fma(share, answer[j], row[j]);
        for (int j = r->times; j < r->times + r->passed; j++)
            row[j] = fma(share, answer[j], row[j]);
    }
    for (int d = 0; d < r->directions; d++)
        if (r->place[d] >= 0)
            row[r->place[d]] = gradient[r->n + d] / scale;
    row[own] += rate / scale;
}

/* Append the derivative over a piece, by columns, to that from the segment's beginning. */
static void collect_piece(saltus_shooting *p, const double *piece) {
    saltus_collection *c = &p->collection;
    const int n = p->n;
    if (c->begun) {
        memset(c->work, 0, (size_t)(n * n) * sizeof(double));
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++)
                for (int i = 0; i < n; i++)
                    c->work[j * n + i] = fma(piece[k * n + i], c->since[j * n + k], c->work[j * n + i]);
        SALTUS_SWAP(c->since, c->work);
    } else {
        memcpy(c->since, piece, (size_t)(n * n) * sizeof *piece);
    }
    c->begun = true;
}

/* Add the derivative since the segment's beginning to the cocycle. */
static saltus_status add_segment(walk *w, saltus_message *message) {
    w->p->collection.begun = false;
    return saltus_cocycle_add(w->p->collection.into, w->p->collection.since, message);
}

/* End a segment with the piece. */
static saltus_status collect_segment(walk *w, saltus_message *message) {
    collect_piece(w->p, w->p->response.tangents);
    w->p->collection.begin = saltus_time_periods(saltus_flow_time(w->flow, 0));
    return add_segment(w, message);
}

/* After a step within a piece: end the segment, and the piece, if another step would make it too long. */
static saltus_status after_step(void *context, saltus_message *message) {
    walk *w = context;
    const saltus_collection *c = &w->p->collection;
    const double length = saltus_time_periods(saltus_flow_time(w->flow, 0)) - c->begin,
                 step = saltus_flow_step_length(w->flow, 0) / w->period;
    if ((length + step) * c->into->density <= 1)
        return SALTUS_OK;
    end_piece(&w->p->response, w->flow);
    saltus_status status = collect_segment(w, message);
    begin_piece(&w->p->response, w->flow);
    return status;
}

static void note_breach(saltus_breaches *list, saltus_breach_kind kind, double value, int mark, int face,
                        double time) {
    if (list->count < list->room)
        list->items[list->count++] =
            (saltus_breach){.kind = kind, .value = value, .mark = mark, .face = face, .time = time};
}

/* Coast, noting how close the flow came to a breach: gaps of free faces, forces of holding faces. */
static saltus_status coast(walk *w, double until, int mark, saltus_message *message) {
    saltus_shooting *p = w->p;
    saltus_extreme extremes[SALTUS_FACES_MAX];
    unsigned contacts = saltus_flow_contacts(w->flow, 0);
    double begin = saltus_time_periods(saltus_flow_time(w->flow, 0));
    for (int f = 0; f < SALTUS_FACES_MAX; f++)
        extremes[f] = (saltus_extreme){.value = -INFINITY, .inner = -INFINITY};
    saltus_status status = saltus_flow_coast_by_steps(w->flow, 0, saltus_time_of(until), extremes,
                                                      w->collects ? after_step : NULL, w, message);
    for (int f = 0; f < saltus_system_face_count(p->full.system) && status == SALTUS_OK; f++) {
        const saltus_extreme *extreme = &extremes[f];
        bool held = contacts >> f & 1;
        saltus_breach_kind kind = held ? SALTUS_BREACH_FORCE : SALTUS_BREACH_GAP;
        double scale = held ? p->force : p->length;
        /* Just after a release, or an impact without rebound, the gap is zero, its maximum rounding. */
        if (extreme->value > -INFINITY && saltus_time_periods(extreme->time) - begin > 1e-6)
            note_breach(&p->breaches, kind, extreme->value / scale, mark, f,
                        saltus_time_periods(extreme->time));
        /* The touch of an impact without speed must not hide another one. */
        if (extreme->value > extreme->inner && extreme->inner > -INFINITY)
            note_breach(&p->breaches, kind, extreme->inner / scale, mark, f,
                        saltus_time_periods(extreme->inner_time));
    }
    return status;
}

/* Flow to a time, coasting or with the flow's own events; `mark` is the next mark. If that is a release, it
 * is prescribed: once the contact holds, the flow coasts to the mark. */
static saltus_status run_piece(walk *w, double until, int mark, saltus_message *message) {
    const saltus_sequence *s = &w->p->sequence;
    const int awaited = mark < s->count && s->mark[mark].kind == SALTUS_RELEASE ? s->mark[mark].face : -1;
    const unsigned watch = SALTUS_WATCH_STICK | (w->collects ? SALTUS_WATCH_STEP : 0);
    saltus_event event;
    saltus_status status;
    if (!(until >= w->time))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "prescribed events change their order");
    if (w->whole)
        begin_piece(&w->p->response, w->flow);
    w->time = until;
    if (!w->driven)
        return coast(w, until, mark, message);
    do {
        status = saltus_flow_advance(w->flow, saltus_time_of(until), watch, &event, message);
        if (status == SALTUS_OK && event.kind == SALTUS_STEP)
            status = after_step(w, message);
        if (status == SALTUS_OK && event.kind == SALTUS_STICK) {
            w->held_since[event.face] = saltus_time_periods(event.time);
            if (event.face == awaited)
                return coast(w, until, mark, message);
        }
    } while (status == SALTUS_OK && event.kind != SALTUS_REACHED);
    return status;
}

/* Start at a cut, where the state is an unknown; `mark` is the next mark. */
static saltus_status open_segment(walk *w, int cut, int mark, unsigned contacts, saltus_message *message) {
    saltus_shooting *p = w->p;
    const double *state = w->u + cut * p->n;
    w->time = p->collection.begin = p->sequence.cut[cut];
    p->collection.begun = false;
    /* If the flow finds its events itself, it must resolve what the start touches. */
    saltus_status status =
        w->driven && contacts == 0
            ? saltus_flow_start(w->flow, 0, saltus_time_of(w->time), state, message)
            : saltus_flow_place(w->flow, 0, saltus_time_of(w->time), state, contacts, message);
    if (status == SALTUS_OK && w->whole)
        start_response(&p->response, w->flow, cut * p->n, p->sequence.cuts * p->n + mark);
    return status;
}

static saltus_status pass_mark(walk *w, int k, saltus_message *message) {
    saltus_shooting *p = w->p;
    const saltus_mark *mark = &p->sequence.mark[k];
    const double scale = mark->kind == SALTUS_RELEASE ? p->force : p->length;
    const int own = p->sequence.cuts * p->n + k, m = p->equations.unknowns;
    double gradient[SALTUS_STATE_MAX + SALTUS_DIRECTIONS_MAX], shift[SALTUS_STATE_MAX],
        speed_gradient[SALTUS_STATE_MAX + SALTUS_DIRECTIONS_MAX];
    saltus_strike strike = {.equation_gradient = gradient,
                            .speed_gradient = k == p->speed_mark ? speed_gradient : NULL,
                            .shift = shift};
    saltus_status status = run_piece(w, w->u[own], k, message);
    if (status == SALTUS_OK)
        status = saltus_flow_strike(w->flow, 0, mark->kind, mark->face, &strike, message);
    if (status != SALTUS_OK)
        return status;
    p->equations.residual[own] = strike.equation / scale;
    /* Note the contact interval or the impact speed. */
    if (mark->kind == SALTUS_RELEASE)
        note_breach(&p->breaches, SALTUS_BREACH_HOLD, w->held_since[mark->face] - w->time, k, mark->face,
                    w->time);
    else
        note_breach(&p->breaches, SALTUS_BREACH_SPEED, -strike.speed / p->speed, k, mark->face, w->time);
    if (mark->kind == SALTUS_STICK)
        w->held_since[mark->face] = w->time;
    w->driven = mark->driven;
    if (!w->whole)
        return status;
    respond_at_mark(&p->response, gradient, strike.equation_rate * w->period, scale, own,
                    p->equations.jacobian + (size_t)own * (size_t)m);
    if (k == p->speed_mark)
        respond_at_mark(&p->response, speed_gradient, strike.speed_rate * w->period, scale / w->period, own,
                        p->speed_row);
    end_piece(&p->response, w->flow);
    if (w->collects) {
        /* The mark's time depends on the state: the flow's tangent vectors passed it at a fixed time. */
        double *tangents = p->response.tangents;
        for (int j = 0; j < p->n; j++)
            for (int i = 0; i < p->n; i++)
                tangents[j * p->n + i] -= shift[i] * (gradient[j] / strike.equation_rate);
        collect_piece(p, tangents);
        /* Where the next pieces end, and with them the Jacobian, does not depend on this. */
        if (saltus_cocycle_ends(p->collection.into, p->collection.since))
            status = add_segment(w, message);
    }
    for (int i = 0; i < p->n; i++)
        p->response.answer[i * m + own] = shift[i] * w->period;
    p->response.passed++;
    return status;
}

/* Continuity: the state at a segment's end equals that at the next cut. */
static saltus_status match(walk *w, int cut, saltus_message *message) {
    saltus_shooting *p = w->p;
    const int n = p->n, m = p->equations.unknowns, next = (cut + 1) % p->sequence.cuts;
    double end[SALTUS_STATE_MAX];
    saltus_flow_state(w->flow, 0, end);
    for (int i = 0; i < n; i++)
        p->equations.residual[cut * n + i] = (end[i] - w->u[next * n + i]) / p->scale[i];
    if (!w->whole)
        return SALTUS_OK;
    end_piece(&p->response, w->flow);
    for (int i = 0; i < n; i++) {
        double *row = p->equations.jacobian + (size_t)(cut * n + i) * (size_t)m;
        for (int j = 0; j < m; j++)
            row[j] = p->response.answer[i * m + j] / p->scale[i];
        row[next * n + i] -= 1 / p->scale[i];
    }
    return w->collects ? collect_segment(w, message) : SALTUS_OK;
}

/* The last equation for an orbit of unknown period: the distance of its base from the anchor's hyperplane. */
static void find_aside(saltus_shooting *p) {
    const saltus_sequence *s = &p->sequence;
    double *aside = &p->equations.residual[p->count - 1];
    *aside = 0;
    for (int i = 0; i < p->n; i++)
        *aside += s->across[i] / p->scale[i] * (p->plain[i] - s->anchor[i]);
}

saltus_spec saltus_family_spec(const saltus_family *family, const double *parameters, double omega) {
    saltus_spec spec = family->spec;
    if (omega > 0)
        saltus_spec_set_omega(&spec, omega);
    for (int d = 0; d < family->parameters; d++)
        spec = saltus_spec_shifted(&spec, &family->direction[d], family->unit[d] * parameters[d]);
    return spec;
}

saltus_status saltus_family_tune(const saltus_family *family, const double *parameters, double omega,
                                 saltus_tuned *tuned, saltus_message *message) {
    bool same = omega == tuned->omega;
    for (int d = 0; d < family->parameters; d++)
        same = same && parameters[d] == tuned->at[d];
    if (same)
        return SALTUS_OK;
    saltus_spec spec = saltus_family_spec(family, parameters, omega);
    saltus_system *system = NULL;
    saltus_status status = SALTUS_OK;
    for (int d = 0; d < family->parameters && status == SALTUS_OK; d++)
        status = saltus_spec_differentiable(&spec, &family->direction[d], message);
    if (status == SALTUS_OK)
        status = saltus_system_new(&spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_flow_retune(tuned->flow, 0, system, message);
    if (status != SALTUS_OK) {
        saltus_system_free(system);
        return status;
    }
    saltus_system_free(tuned->system);
    tuned->system = system;
    memcpy(tuned->at, parameters, (size_t)family->parameters * sizeof *parameters);
    tuned->omega = omega;
    return SALTUS_OK;
}

void saltus_tuned_clear(saltus_tuned *tuned) {
    saltus_flow_free(tuned->flow);
    saltus_system_free(tuned->system);
}

saltus_status saltus_shooting_along(saltus_shooting *p, saltus_tuned *by, int segments, const double *u,
                                    saltus_message *message) {
    const saltus_sequence *s = &p->sequence;
    for (int j = 0; j < p->count; j++)
        p->plain[j] = u[j] * p->scale[j];
    walk w = {.p = p,
              .flow = by->flow,
              .whole = by == &p->full,
              .collects = by == &p->full && p->collection.into && !(s->omega > 0),
              .u = p->plain,
              .driven = s->driven};
    unsigned contacts = s->contacts;
    long long steps = 0;
    int k = 0;
    for (int f = 0; f < SALTUS_FACES_MAX; f++)
        w.held_since[f] = s->base;
    p->breaches.count = 0;
    /* No mark may lie outside the orbit: Newton's method tries times of millions of periods. */
    for (int j = s->cuts * p->n; j < s->cuts * p->n + s->count; j++)
        if (!(p->plain[j] >= s->base && p->plain[j] <= s->base + s->periods))
            return saltus_fail(message, SALTUS_NO_CONVERGENCE, "prescribed events change their order");
    saltus_status status =
        saltus_family_tune(&p->family, u + p->count, saltus_shooting_omega(p, u), by, message);
    w.period = saltus_system_period(by->system);
    p->collection.whole &= !w.whole;
    if (status == SALTUS_OK && w.collects)
        status = saltus_cocycle_open(p->collection.into, by->system, s->periods, false, message);
    for (int cut = 0; cut < segments && status == SALTUS_OK; cut++) {
        double until = cut + 1 < s->cuts ? s->cut[cut + 1] : s->base + s->periods;
        status = open_segment(&w, cut, k, contacts, message);
        while (status == SALTUS_OK && k < s->count && (cut + 1 == s->cuts || s->mark[k].time < until))
            status = pass_mark(&w, k++, message);
        if (status == SALTUS_OK)
            status = run_piece(&w, until, k, message);
        if (status == SALTUS_OK)
            status = match(&w, cut, message);
        contacts = saltus_flow_contacts(w.flow, 0);
        steps += saltus_flow_information(w.flow, 0).steps;
    }
    if (status == SALTUS_OK && segments == s->cuts && w.whole) {
        /* Newton's method tries states so far out that a period takes a million times as long. Give up a
         * trial that takes many times the steps of previous orbits. */
        const double many = 100, least = 2e4, own = (double)steps / s->periods;
        p->steps = p->steps > 0 ? fmin(own, 2 * p->steps) : own;
        saltus_flow_limit_steps(p->full.flow, fmax(least, many * p->steps));
        saltus_flow_limit_steps(p->bare.flow, fmax(least, many * p->steps));
    }
    if (status == SALTUS_OK && w.collects) {
        saltus_cocycle *into = p->collection.into;
        into->given = true;
        /* A grazing impact has no derivative. */
        p->collection.whole =
            saltus_dense_finite(into->segments, (size_t)into->count * (size_t)(p->n * p->n));
    }
    return status;
}

saltus_status saltus_shooting_around(void *self, const double *u, saltus_message *message) {
    saltus_shooting *p = self;
    const saltus_sequence *s = &p->sequence;
    const int m = p->equations.unknowns;
    saltus_status status = saltus_shooting_along(p, &p->full, s->cuts, u, message);
    if (status != SALTUS_OK)
        return status;
    if (s->omega > 0) {
        double field[SALTUS_STATE_MAX], *row = p->equations.jacobian + (size_t)(p->count - 1) * (size_t)m;
        find_aside(p);
        memset(row, 0, (size_t)m * sizeof *row);
        p->onward = p->flow_speed = 0;
        saltus_flow_field(p->full.flow, 0, field);
        for (int i = 0; i < p->n; i++) {
            row[i] = s->across[i] / p->scale[i];
            p->onward += row[i] * field[i] / s->speed;
            p->flow_speed = hypot(p->flow_speed, field[i] / p->scale[i] / s->speed);
        }
    }
    /* Scale the columns: states and times by their scales, the period's by -omega, parameters by their units.
     */
    for (int j = 0; j < m; j++) {
        const double factor = j < p->response.plain ? p->scale[j]
                              : j < p->count        ? -p->full.omega
                                                    : p->family.unit[j - p->count];
        for (int i = 0; i < p->count; i++)
            p->equations.jacobian[(size_t)i * (size_t)m + (size_t)j] *= factor;
        if (p->speed_mark >= 0)
            p->speed_row[j] *= factor;
    }
    return status;
}

saltus_status saltus_shooting_residual(void *self, const double *u, saltus_message *message) {
    saltus_shooting *p = self;
    saltus_status status = saltus_shooting_along(p, &p->bare, p->sequence.cuts, u, message);
    if (status == SALTUS_OK && p->sequence.omega > 0)
        find_aside(p);
    return status;
}
