/* Problems from the files of data/reference, and repeated runs of the integrators once around them.
 *
 * Short runs are timed in batches. Tangent vectors come from Saltus itself, from the rivals' variational
 * equations with saltation matrices, or from central differences of the rival's period map, as requested.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "bench.h"

#include <complex.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>

/* A run, or a batch of them, with room for what it hands out. */
typedef struct outcome {
    rival_event events[4096];
    double state[reference_dimension];
    rival_result result;
} outcome;

double median(double *values, int count) {
    gsl_sort(values, 1, (size_t)count);
    return gsl_stats_median_from_sorted_data(values, 1, (size_t)count);
}

/* Eigenvalues of a matrix given by columns, unordered. */
static bool eigenvalues(int n, const double *columns, double complex *values) {
    const size_t size = (size_t)n;
    gsl_matrix *matrix = gsl_matrix_alloc(size, size);
    gsl_vector_complex *found = gsl_vector_complex_alloc(size);
    gsl_eigen_nonsymm_workspace *workspace = gsl_eigen_nonsymm_alloc(size);
    gsl_eigen_nonsymm_params(0, 1, workspace);
    for (size_t i = 0; i < size; i++)
        for (size_t j = 0; j < size; j++)
            gsl_matrix_set(matrix, i, j, columns[j * size + i]);
    const bool done = gsl_eigen_nonsymm(matrix, found, workspace) == 0;
    for (size_t k = 0; k < size && done; k++) {
        const gsl_complex value = gsl_vector_complex_get(found, k);
        values[k] = GSL_REAL(value) + GSL_IMAG(value) * I;
    }
    gsl_eigen_nonsymm_free(workspace);
    gsl_vector_complex_free(found);
    gsl_matrix_free(matrix);
    return done;
}

bool problem_open(const char *folder, const char *name, const char *what, problem *p) {
    double columns[reference_dimension * reference_dimension] = {0};
    double complex values[reference_dimension];
    saltus_message message = {.text = ""};
    saltus_system *system = NULL;
    *p = (problem){.name = name, .what = what, .start = p->orbit.states[0]};
    if (!reference_read(folder, name, &p->orbit))
        return false;
    const int n = p->orbit.n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            columns[j * n + i] = p->orbit.monodromy[i][j];
    if (saltus_system_new(&p->orbit.spec, &system, &message) != SALTUS_OK ||
        !eigenvalues(n, columns, values)) {
        fprintf(stderr, "saltus_bench: %s: %s\n", name, message.text);
        saltus_system_free(system);
        return false;
    }
    for (int k = 0; k < 2; k++) {
        int largest = k;
        for (int l = k + 1; l < n; l++)
            if (cabs(values[l]) > cabs(values[largest]))
                largest = l;
        const double complex value = values[largest];
        values[largest] = values[k];
        p->leading[k][0] = creal(value);
        p->leading[k][1] = cimag(value);
    }
    p->integrator = saltus_system_integrator(system);
    p->stiff = strcmp(p->integrator, "mixed") == 0;
    for (int e = 0; e < p->orbit.event_count; e++)
        p->impacts += p->orbit.kind[e] == 'i';
    saltus_system_free(system);
    return true;
}

/* Largest error of the times of impacts and releases in T, among those the reference lists. A missing or
 * additional event counts as an error of one period, except that a method may end a chatter after fewer
 * impacts than listed, and that events after the listed ones of a chatter are ignored. Sticks are ignored
 * too: the accumulation point of the impacts is extrapolated, not located. NAN if there are no events. */
static double event_error(const reference *r, const rival_result *found) {
    const int count = found->count < found->capacity ? found->count : found->capacity;
    double worst = r->event_count > 0 ? 0 : NAN;
    int k = 0;
    for (int e = 0; e < r->event_count; e++) {
        if (r->kind[e] == 's')
            while (k < count && found->events[k].kind == RIVAL_IMPACT)
                k++;
        const char kind = k < count ? "isr"[found->events[k].kind] : 0;
        int after = e; /* the next event that is no impact */
        while (after < r->event_count && r->kind[after] == 'i')
            after++;
        if (r->kind[e] == 'i' && kind == 's' && after < r->event_count && r->kind[after] == 's')
            continue;
        if (kind != r->kind[e])
            return 1;
        if (kind != 's')
            worst = fmax(worst, fmin(1, fabs(found->events[k].time_over_T - r->time[e])));
        k++;
    }
    return r->sticking == 0 && k < count ? 1 : worst;
}

/* Largest distance of the two leading multipliers from the nearest eigenvalues of a monodromy matrix, given
 * by columns; NAN if the eigenvalues cannot be computed. */
static double multiplier_error(const problem *p, const double *columns) {
    const int n = p->orbit.n;
    double complex values[reference_dimension];
    double worst = 0;
    for (int i = 0; i < n * n; i++)
        if (!isfinite(columns[i]))
            return NAN;
    if (!eigenvalues(n, columns, values))
        return NAN;
    for (int k = 0; k < 2; k++) {
        double nearest = INFINITY;
        for (int l = 0; l < n; l++)
            nearest = fmin(nearest, cabs(values[l] - (p->leading[k][0] + p->leading[k][1] * I)));
        worst = fmax(worst, nearest);
    }
    return worst;
}

/* Once around the orbit. */
static bool around(saltus_flow *flow, const double *state0, int periods, rival_result *result) {
    saltus_event event;
    result->count = 0;
    if (saltus_flow_start(flow, 0, (saltus_time){0, 0}, state0, NULL) != SALTUS_OK)
        return false;
    while (saltus_flow_advance(flow, (saltus_time){periods, 0}, SALTUS_WATCH_CONTACT, &event, NULL) ==
           SALTUS_OK) {
        const rival_event_kind kind = event.kind == SALTUS_IMPACT  ? RIVAL_IMPACT
                                      : event.kind == SALTUS_STICK ? RIVAL_STICK
                                                                   : RIVAL_RELEASE;
        if (event.kind == SALTUS_REACHED)
            return true;
        if (result->count < result->capacity)
            result->events[result->count] =
                (rival_event){.kind = kind, .time_over_T = saltus_time_periods(event.time)};
        result->count++;
    }
    return false;
}

/* One of Saltus' integrators, as a rival. */
static bool run_own(int integrator, const saltus_spec *spec, const double *state0, int periods,
                    double tolerance, rival_result *result) {
    const int repeats = result->repeats > 1 ? result->repeats : 1;
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    options.rtol = tolerance;
    options.atol = 1e-3 * tolerance;
    options.integrator = (saltus_integrator)integrator;
    bool done = saltus_system_new(spec, &system, NULL) == SALTUS_OK &&
                saltus_flow_single(system, result->tangents ? saltus_system_dimension(system) : 0, &options,
                                   &flow, NULL) == SALTUS_OK;
    const double before = processor_seconds();
    for (int k = 0; k < repeats && done; k++)
        done = around(flow, state0, periods, result);
    result->cpu_seconds = (processor_seconds() - before) / repeats;
    if (done) {
        saltus_flow_state(flow, 0, result->state);
        result->field_evaluations = (long)saltus_flow_information(flow, 0).field_evaluations;
        if (result->tangents)
            saltus_flow_tangents(flow, 0, result->tangents);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
    return done;
}

const method own_methods[own_method_count] = {
    {"Saltus Taylor", "taylor", run_own, SALTUS_TAYLOR, .own = true, .tangents = true},
    {"Saltus Radau", "radau", run_own, SALTUS_RADAU, .own = true, .tangents = true},
    {"Saltus mixed", "mixed", run_own, SALTUS_MIXED, .own = true, .tangents = true},
};

/* A batch of runs from a state. */
static bool run(const problem *p, const method *m, double rtol, int batch, const double *start,
                double *tangents, outcome *out) {
    out->result = (rival_result){.events = out->events,
                                 .capacity = sizeof out->events / sizeof out->events[0],
                                 .state = out->state,
                                 .tangents = tangents,
                                 .repeats = batch};
    return m->run(m->which, &p->orbit.spec, start, p->orbit.periods, rtol, &out->result);
}

/* The median over repeated batches; the first run determines the length and number of batches. */
static bool repeat(const problem *p, const method *m, double rtol, const effort *e, double *tangents,
                   outcome *out) {
    enum { repeats_max = 64, batch_max = 2000 };
    const double shortest_batch = 3e-4;
    double seconds[repeats_max];
    if (!run(p, m, rtol, 1, p->start, tangents, out))
        return false;
    if (out->result.cpu_seconds > e->patience)
        return true;
    const int batch = (int)fmin(batch_max, ceil(shortest_batch / out->result.cpu_seconds));
    int repeats = (int)fmin(fmin(repeats_max, e->repeats), e->budget / (batch * out->result.cpu_seconds));
    repeats = repeats < 3 ? 3 : repeats;
    for (int k = 0; k < repeats; k++) {
        if (!run(p, m, rtol, batch, p->start, tangents, out))
            return false;
        seconds[k] = out->result.cpu_seconds;
    }
    out->result.cpu_seconds = median(seconds, repeats);
    return true;
}

/* Central differences of the rival's period map, with the step that balances the local error against the
 * third derivative. */
static bool differentiate(const problem *p, const method *m, double rtol, double *columns, outcome *out) {
    const int n = p->orbit.n;
    double seconds = 0, plus[reference_dimension];
    long evaluations = 0;
    for (int k = 0; k < 2 * n; k++) {
        const int j = k / 2, sign = k % 2 ? -1 : 1;
        const double step = cbrt(rtol) * (j < n / 2 ? 1e-2 : 1);
        double start[reference_dimension];
        memcpy(start, p->start, (size_t)n * sizeof *start);
        start[j] += sign * step;
        if (!run(p, m, rtol, 1, start, NULL, out))
            return false;
        seconds += out->result.cpu_seconds;
        evaluations += out->result.field_evaluations;
        for (int i = 0; i < n; i++)
            if (sign > 0)
                plus[i] = out->state[i];
            else
                columns[j * n + i] = (plus[i] - out->state[i]) / (2 * step);
    }
    out->result.cpu_seconds = seconds;
    out->result.field_evaluations = evaluations;
    return true;
}

condition measure_condition(const problem *p, double amount) {
    static const method exact = {.run = run_own, .which = SALTUS_AUTOMATIC};
    const reference *r = &p->orbit;
    condition worst = {0, 0};
    outcome out;
    /* The largest components of displacement and velocity at the section. */
    double size[2] = {0, 0};
    for (int point = 0; point < r->periods; point++)
        for (int i = 0; i < r->n; i++)
            size[i >= r->n / 2] = fmax(size[i >= r->n / 2], fabs(r->states[point][i]));
    for (int k = 0; k < 2 * r->n; k++) {
        double start[reference_dimension];
        memcpy(start, r->states[0], (size_t)r->n * sizeof *start);
        start[k / 2] += (k % 2 ? -amount : amount) * size[k / 2 >= r->n / 2];
        if (!run(p, &exact, 1e-15, 1, start, NULL, &out))
            continue;
        worst.events = fmax(worst.events, event_error(r, &out.result));
        worst.state = fmax(worst.state, reference_error(r, out.state, 0));
    }
    return worst;
}

measure measure_method(const problem *p, const method *m, double rtol, derivative how, const effort *e) {
    double columns[reference_dimension * reference_dimension];
    outcome out;
    measure found = {.rtol = rtol, .how = derivative_none};
    if (!repeat(p, m, rtol, e, NULL, &out))
        return found;
    found.done = true;
    found.event_error = event_error(&p->orbit, &out.result);
    found.state_error = reference_error(&p->orbit, out.state, 0);
    found.seconds = out.result.cpu_seconds;
    found.evaluations = (double)out.result.field_evaluations;
    const double expected = found.seconds * p->orbit.n;
    if (how == derivative_none || !(expected < 5 * e->patience) ||
        !(how == derivative_tangents ? repeat(p, m, rtol, e, columns, &out)
                                     : differentiate(p, m, rtol, columns, &out)))
        return found;
    found.multiplier_error = multiplier_error(p, columns);
    found.derivative_seconds = out.result.cpu_seconds;
    found.derivative_evaluations = (double)out.result.field_evaluations;
    found.how = isnan(found.multiplier_error) ? derivative_none : how;
    return found;
}
