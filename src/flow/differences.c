/* Columns of a flow compared with differences of whole runs, for `saltus check --derivatives`.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include "base/progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { levels = 3, attempts = 4 };
static const double first_step = 1e-3, tolerance = 1e-6, rounding = 1e-12;

/* What the compared runs share: they begin at phase 0 and last equally long. */
typedef struct comparison {
    const saltus_system *system;
    const double *state;
    double end;            /* periods */
    saltus_flow_info info; /* of the undisturbed run */
    const volatile sig_atomic_t *stop;
} comparison;

/* The variable of a column: an entry of the state, or a direction of the specification. */
typedef struct variable {
    int entry; /* -1: a direction */
    saltus_direction direction;
    double unit; /* first step of the differences */
} variable;

static saltus_flow_options options_of(const comparison *c, int columns, int directions) {
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-14;
    options.columns = columns;
    options.directions = directions;
    options.stop = c->stop;
    return options;
}

/* Set the common end: shortly after the first contact; run up to it once. */
static saltus_status find_end(comparison *c, saltus_message *message) {
    static const double short_run = 0.25, longest = 10, beyond = 0.02;
    const saltus_flow_options options = options_of(c, 0, 0);
    saltus_flow *flow = NULL;
    saltus_event event = {.kind = SALTUS_REACHED};
    saltus_status status = saltus_flow_new(&c->system, 1, &options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, c->state, message);
    if (status == SALTUS_OK && c->system->face_count)
        status = saltus_flow_advance(flow, saltus_time_of(longest), SALTUS_WATCH_CONTACT, &event, message);
    c->end = event.kind == SALTUS_REACHED ? short_run : saltus_time_periods(event.time) + beyond;
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, c->state, message);
    if (status == SALTUS_OK)
        status = saltus_flow_advance(flow, saltus_time_of(c->end), 0, &event, message);
    if (status == SALTUS_OK)
        c->info = saltus_flow_information(flow, 0);
    saltus_flow_free(flow);
    return status;
}

/* The state at the end of a run, or its derivative by `column`; false if the run passes other events. */
static bool run(const comparison *c, const saltus_system *system, const double *state, const variable *column,
                double *result) {
    const bool directed = column && column->entry < 0;
    const saltus_flow_options options = options_of(c, column != NULL, directed);
    double tangent[SALTUS_STATE_MAX] = {0};
    saltus_flow *flow = NULL;
    saltus_event event;
    bool good = saltus_flow_new(&system, 1, &options, &flow, NULL) == SALTUS_OK;
    if (good && directed)
        saltus_flow_set_directions(flow, &column->direction);
    good = good && saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, NULL) == SALTUS_OK;
    if (good && column) {
        if (!directed)
            tangent[column->entry] = 1;
        saltus_flow_set_tangents(flow, 0, tangent);
    }
    good = good && saltus_flow_advance(flow, saltus_time_of(c->end), 0, &event, NULL) == SALTUS_OK;
    if (good) {
        const saltus_flow_info info = saltus_flow_information(flow, 0);
        if (column)
            saltus_flow_tangents(flow, 0, result);
        else
            saltus_flow_state(flow, 0, result);
        good = info.impacts == c->info.impacts && info.sticks == c->info.sticks &&
               info.releases == c->info.releases;
    }
    saltus_flow_free(flow);
    return good;
}

static bool run_shifted(const comparison *c, const variable *v, double amount, double *result) {
    double state[SALTUS_STATE_MAX];
    memcpy(state, c->state, (size_t)c->system->dimension * sizeof *state);
    if (v->entry >= 0) {
        state[v->entry] += amount;
        return run(c, c->system, state, NULL, result);
    }
    saltus_spec spec = saltus_spec_shifted(&c->system->spec, &v->direction, amount);
    saltus_system *system = NULL;
    bool good = saltus_system_new(&spec, &system, NULL) == SALTUS_OK && run(c, system, state, NULL, result);
    saltus_system_free(system);
    return good;
}

/* Extrapolated differences with steps h, h/2, h/4; one-sided if one side is impossible. Returns how far the
 * last two extrapolations lie apart, in the system's scales; infinite if a run is impossible. */
static double differentiate(const comparison *c, const variable *v, double h, double *derivative) {
    double table[levels][SALTUS_STATE_MAX], above[SALTUS_STATE_MAX], below[SALTUS_STATE_MAX], apart = 0;
    const int n = c->system->dimension;
    const bool left = run_shifted(c, v, -h, below), right = run_shifted(c, v, h, above);
    const double high = right ? h : 0, low = left ? -h : 0;
    if (!left && !right)
        return INFINITY;
    for (int k = 0; k < levels; k++) {
        const double part = exp2(-k);
        if (!run_shifted(c, v, part * high, above) || !run_shifted(c, v, part * low, below))
            return INFINITY;
        for (int i = 0; i < n; i++)
            table[k][i] = (above[i] - below[i]) / (part * (high - low));
    }
    for (int j = 1; j < levels; j++)
        for (int k = levels - 1; k >= j; k--)
            for (int i = 0; i < n; i++)
                table[k][i] += (table[k][i] - table[k - 1][i]) / (exp2(left && right ? 2 * j : j) - 1);
    for (int i = 0; i < n; i++) {
        derivative[i] = table[levels - 1][i];
        apart = fmax(apart, fabs(derivative[i] - table[levels - 2][i]) / c->system->scale[i]);
    }
    return apart;
}

/* Compare with the differences that are most certain of themselves: large steps leave the linear range, small
 * ones drown in rounding. */
static void compare(const comparison *c, const variable *v, saltus_column_check *check) {
    double column[SALTUS_STATE_MAX], trial[SALTUS_STATE_MAX], expected[SALTUS_STATE_MAX], least = INFINITY,
                                                                                          off = 0, size = 0;
    bool known = run(c, c->system, c->state, v, column);
    for (int k = 0; k < attempts && known; k++) {
        double apart = differentiate(c, v, v->unit * pow(10, -k), trial);
        if (apart < least) {
            least = apart;
            memcpy(expected, trial, (size_t)c->system->dimension * sizeof *trial);
        }
    }
    const bool found = least < INFINITY;
    for (int i = 0; i < c->system->dimension && found; i++) {
        const double difference = fabs(column[i] - expected[i]) / c->system->scale[i];
        off = difference > off || isnan(difference) ? difference : off;
        size = fmax(size, fabs(expected[i]) / c->system->scale[i]);
    }
    check->difference = !found ? NAN : size > 0 ? off / size : off;
    check->agrees = !found || off <= tolerance * size + 100 * least + rounding;
}

static void check_key(const comparison *c, const char *key, int stop, saltus_column_check *checks,
                      int *count) {
    variable v = {.entry = -1};
    double value;
    saltus_column_check *check = &checks[*count];
    *check = (saltus_column_check){.difference = NAN};
    snprintf(check->name, sizeof check->name, stop ? "%s%d" : "%s", key, stop);
    if (saltus_spec_direction(&c->system->spec, check->name, &v.direction, &value, NULL) != SALTUS_OK)
        return;
    v.unit = first_step * (value != 0 ? fabs(value) : 1);
    compare(c, &v, check);
    ++*count;
}

saltus_status saltus_columns_check(const saltus_system *system, const double *state,
                                   const volatile sig_atomic_t *stop, saltus_column_check *checks, int *count,
                                   saltus_message *message) {
    comparison c = {.system = system, .state = state, .stop = stop};
    saltus_status status = find_end(&c, message);
    const saltus_spec *spec = &system->spec;
    int numbers;
    const saltus_parameter *of_stop = saltus_stop_parameters(&numbers);
    *count = 0;
    for (int i = 0; i < system->dimension && status == SALTUS_OK; i++) {
        const variable v = {.entry = i, .unit = first_step * system->scale[i]};
        saltus_column_check *check = &checks[(*count)++];
        snprintf(check->name, sizeof check->name, "%s", saltus_system_state_name(system, i).text);
        compare(&c, &v, check);
    }
    for (int k = 0; k < spec->model->parameter_count && status == SALTUS_OK; k++)
        if (saltus_spec_matters(spec, k))
            check_key(&c, spec->model->parameters[k].name, 0, checks, count);
    for (int k = 0; k < numbers && status == SALTUS_OK; k++)
        for (int s = 1; s <= spec->stop_count; s++)
            check_key(&c, of_stop[k].name, s, checks, count);
    if (status == SALTUS_OK && saltus_stop_asked(stop))
        status = saltus_fail(message, SALTUS_INTERRUPTED, "interrupted");
    return status;
}
