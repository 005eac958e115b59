/* Repeated runs of the integrators on a reference orbit.
 *
 * Short runs are timed in batches. Tangent vectors come from Saltus itself, from the rivals' variational
 * equations with saltation matrices, or from central differences of the rival's period map, as requested.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>

/* The result of one run, and its mean time over a batch. */
typedef struct outcome {
    happened events;
    double state[reference_dimension];
    double evaluations, seconds;
} outcome;

double median(double *values, int count) {
    gsl_sort(values, 1, (size_t)count);
    return gsl_stats_median_from_sorted_data(values, 1, (size_t)count);
}

static saltus_flow *open_flow(const problem *p, saltus_integrator integrator, double rtol, bool tangents) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    options.rtol = rtol;
    options.atol = 1e-3 * rtol;
    options.integrator = integrator;
    return saltus_flow_single(p->system, tangents ? p->orbit.n : 0, &options, &flow, NULL) == SALTUS_OK
               ? flow
               : NULL;
}

/* Once around the orbit. */
static bool around(const problem *p, saltus_flow *flow, const double *start, outcome *out) {
    const saltus_time end = {p->orbit.periods, 0};
    saltus_event event;
    out->events.count = 0;
    if (saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, NULL) != SALTUS_OK)
        return false;
    do {
        if (saltus_flow_advance(flow, end, SALTUS_WATCH_CONTACT, &event, NULL) != SALTUS_OK)
            return false;
        const rival_event_kind kind = event.kind == SALTUS_IMPACT  ? RIVAL_IMPACT
                                      : event.kind == SALTUS_STICK ? RIVAL_STICK
                                                                   : RIVAL_RELEASE;
        if (event.kind != SALTUS_REACHED && out->events.count < happened_max)
            out->events.events[out->events.count++] =
                (rival_event){.kind = kind, .time_over_T = saltus_time_periods(event.time)};
    } while (event.kind != SALTUS_REACHED);
    return true;
}

/* The mean over a batch of runs from a state. */
static bool run(const problem *p, const method *m, double rtol, int batch, const double *start, outcome *out,
                double *tangents) {
    if (m->rival) {
        rival_result result = {.events = out->events.events,
                               .capacity = happened_max,
                               .state = out->state,
                               .tangents = tangents,
                               .repeats = batch};
        if (!m->rival->run(&p->orbit.spec, start, p->orbit.periods, rtol, &result))
            return false;
        out->events.count = result.count < happened_max ? result.count : happened_max;
        out->evaluations = (double)result.field_evaluations;
        out->seconds = result.cpu_seconds;
        return true;
    }
    saltus_flow *flow = open_flow(p, m->own, rtol, tangents != NULL);
    bool done = flow != NULL;
    const double before = processor_seconds();
    for (int b = 0; b < batch && done; b++)
        done = around(p, flow, start, out);
    out->seconds = (processor_seconds() - before) / batch;
    if (done) {
        saltus_flow_state(flow, 0, out->state);
        out->evaluations = (double)saltus_flow_information(flow, 0).field_evaluations;
        if (tangents)
            saltus_flow_tangents(flow, 0, tangents);
    }
    saltus_flow_free(flow);
    return done;
}

/* The median over repeated batches; the first run determines the length and number of batches. */
static bool repeat(const problem *p, const method *m, double rtol, const effort *e, outcome *out,
                   double *tangents) {
    enum { repeats_max = 64, batch_max = 2000 };
    const double shortest_batch = 3e-4;
    double seconds[repeats_max];
    if (!run(p, m, rtol, 1, p->start, out, tangents))
        return false;
    if (out->seconds > e->patience)
        return true;
    const int batch = (int)fmin(batch_max, ceil(shortest_batch / out->seconds));
    int repeats = (int)fmin(fmin(repeats_max, e->repeats), e->budget / (batch * out->seconds));
    repeats = repeats < 3 ? 3 : repeats;
    for (int k = 0; k < repeats; k++) {
        if (!run(p, m, rtol, batch, p->start, out, tangents))
            return false;
        seconds[k] = out->seconds;
    }
    out->seconds = median(seconds, repeats);
    return true;
}

/* Central differences of the rival's period map, with the step that balances the local error against the
 * third derivative. */
static bool differentiate(const problem *p, const method *m, double rtol, outcome *out, double *columns) {
    const int n = p->orbit.n;
    double seconds = 0, evaluations = 0, plus[reference_dimension];
    for (int j = 0; j < n; j++) {
        const bool displacement = j < n / 2;
        const double step = cbrt(rtol) * (displacement ? 1e-2 : 1);
        for (int sign = 1; sign >= -1; sign -= 2) {
            double start[reference_dimension];
            memcpy(start, p->start, (size_t)n * sizeof *start);
            start[j] += sign * step;
            if (!run(p, m, rtol, 1, start, out, NULL))
                return false;
            seconds += out->seconds;
            evaluations += out->evaluations;
            for (int i = 0; i < n; i++)
                if (sign > 0)
                    plus[i] = out->state[i];
                else
                    columns[j * n + i] = (plus[i] - out->state[i]) / (2 * step);
        }
    }
    out->seconds = seconds;
    out->evaluations = evaluations;
    return true;
}

condition measure_condition(const problem *p, double amount) {
    const reference *r = &p->orbit;
    condition worst = {0, 0};
    outcome out;
    saltus_flow *flow = open_flow(p, SALTUS_AUTOMATIC, 1e-15, false);
    /* The largest components of displacement and velocity at the section. */
    double size[2] = {0, 0};
    for (int point = 0; point < r->periods; point++)
        for (int i = 0; i < r->n; i++)
            size[i >= r->n / 2] = fmax(size[i >= r->n / 2], fabs(r->states[point][i]));
    for (int k = 0; k < 2 * r->n && flow; k++) {
        double start[reference_dimension];
        memcpy(start, r->states[0], (size_t)r->n * sizeof *start);
        start[k / 2] += (k % 2 ? -amount : amount) * size[k / 2 >= r->n / 2];
        if (!around(p, flow, start, &out))
            continue;
        saltus_flow_state(flow, 0, out.state);
        worst.events = fmax(worst.events, problem_event_error(p, &out.events));
        worst.state = fmax(worst.state, reference_error(r, out.state, 0));
    }
    saltus_flow_free(flow);
    return worst;
}

measure measure_method(const problem *p, const method *m, double rtol, derivative how, const effort *e) {
    double columns[reference_dimension * reference_dimension];
    outcome out;
    measure found = {.rtol = rtol, .how = derivative_none};
    if (!repeat(p, m, rtol, e, &out, NULL))
        return found;
    found.done = true;
    found.event_error = problem_event_error(p, &out.events);
    found.state_error = reference_error(&p->orbit, out.state, 0);
    found.seconds = out.seconds;
    found.evaluations = out.evaluations;
    const double expected = out.seconds * p->orbit.n;
    if (how == derivative_none || !(expected < 5 * e->patience) ||
        !(how == derivative_tangents ? repeat(p, m, rtol, e, &out, columns)
                                     : differentiate(p, m, rtol, &out, columns)))
        return found;
    found.multiplier_error = problem_multiplier_error(p, columns);
    found.derivative_seconds = out.seconds;
    found.derivative_evaluations = out.evaluations;
    found.how = isnan(found.multiplier_error) ? derivative_none : how;
    return found;
}
