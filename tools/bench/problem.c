/* Problems from the files of data/reference.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "problem.h"

#include <complex.h>
#include <gsl/gsl_eigen.h>

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
    saltus_message message = {.text = ""};
    double columns[reference_dimension * reference_dimension] = {0};
    double complex values[reference_dimension];
    *p = (problem){.name = name, .what = what, .start = p->orbit.states[0]};
    if (!reference_read(folder, name, &p->orbit)) {
        free(p->orbit.text);
        return false;
    }
    const int n = p->orbit.n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            columns[j * n + i] = p->orbit.monodromy[i][j];
    if (saltus_system_new(&p->orbit.spec, &p->system, &message) != SALTUS_OK ||
        !eigenvalues(n, columns, values)) {
        fprintf(stderr, "saltus_bench: %s: %s\n", name, message.text);
        problem_close(p);
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
    p->stiff = strcmp(saltus_system_integrator(p->system), "mixed") == 0;
    for (int e = 0; e < p->orbit.event_count; e++)
        p->impacts += p->orbit.kind[e] == 'i';
    return true;
}

bool problem_pipe(int modes, bool stop, problem *p) {
    enum { settling = 24 };
    saltus_message message = {.text = ""};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_spec *spec = &p->orbit.spec;
    saltus_flow *flow = NULL;
    saltus_event event;
    *p = (problem){.name = "pipe", .start = p->orbit.states[1]};
    double *start = p->orbit.states[1];
    p->orbit.n = 2 * modes;
    p->orbit.periods = 1;
    *spec = saltus_spec_defaults(saltus_model_find("pipe"));
    spec->stop_count = stop;
    spec->stops[0] = saltus_stop_defaults();
    spec->stops[0].d = 0.035;
    spec->stops[0].sides = SALTUS_UPPER;
    saltus_status status = saltus_spec_set(spec, "N", modes, &message);
    if (status == SALTUS_OK)
        status = saltus_spec_set(spec, "omega", 42, &message);
    if (status == SALTUS_OK)
        status = saltus_system_new(spec, &p->system, &message);
    if (status == SALTUS_OK)
        status = saltus_system_default_state(p->system, start, &message);
    start[0] = 0.01;
    options.integrator = SALTUS_MIXED;
    options.rtol = 1e-12;
    options.atol = 1e-15;
    if (status == SALTUS_OK)
        status = saltus_motion_settle(p->system, &options, settling, start, &message);
    options.rtol = 1e-14;
    options.atol = 1e-17;
    if (status == SALTUS_OK)
        status = saltus_flow_single(p->system, 0, &options, &flow, &message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message);
    if (status == SALTUS_OK)
        status = saltus_flow_advance(flow, (saltus_time){1, 0}, 0, &event, &message);
    if (status == SALTUS_OK) {
        saltus_flow_state(flow, 0, p->orbit.states[0]);
        p->impacts = (int)saltus_flow_information(flow, 0).impacts;
    } else
        fprintf(stderr, "saltus_bench: N = %d: %s\n", modes, message.text);
    saltus_flow_free(flow);
    return status == SALTUS_OK;
}

void problem_close(problem *p) {
    saltus_system_free(p->system);
    free(p->orbit.text);
    *p = (problem){0};
}

double problem_event_error(const problem *p, const happened *events) {
    const reference *r = &p->orbit;
    double worst = r->event_count > 0 ? 0 : NAN;
    int k = 0;
    for (int e = 0; e < r->event_count; e++) {
        if (r->kind[e] == 's')
            while (k < events->count && events->events[k].kind == RIVAL_IMPACT)
                k++;
        const char kind = k < events->count ? "isr"[events->events[k].kind] : 0;
        int after = e; /* the next event that is no impact */
        while (after < r->event_count && r->kind[after] == 'i')
            after++;
        if (r->kind[e] == 'i' && kind == 's' && after < r->event_count && r->kind[after] == 's')
            continue;
        if (kind != r->kind[e])
            return 1;
        if (kind != 's')
            worst = fmax(worst, fmin(1, fabs(events->events[k].time_over_T - r->time[e])));
        k++;
    }
    return r->sticking == 0 && k < events->count ? 1 : worst;
}

double problem_multiplier_error(const problem *p, const double *columns) {
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
