/* A sweep: checking its grid and options, and numbering its places, rows and tasks.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"
#include "sweep/options.h"

#include "system/system.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { setting_size = 80 };
static const long long rows_max = 1000000000LL;

const char *saltus_pass_word(saltus_pass pass) {
    return saltus_word_of(saltus_pass_words, 1 << pass);
}

/* Whether a key names an entry of the initial state: x or x' of a text model, or a numbered q, v or z. */
static bool is_start_key(const saltus_spec *spec, const char *key) {
    int number = 0;
    for (int k = 0; k < 3 && number == 0 && saltus_model_parameter_index(spec->model, key) < 0; k++)
        saltus_key_numbered(key, (const char[]){"qvz"[k], '\0'}, &number);
    return number > 0 || saltus_spec_state_index(spec, key) >= 0;
}

static saltus_status set_value(saltus_scene *scene, const saltus_axis *axis, int k, saltus_message *message) {
    char setting[setting_size];
    snprintf(setting, sizeof setting, "%s=%.17g", axis->key, saltus_axis_value(axis, k));
    return saltus_scene_set(scene, setting, message);
}

/* Check that the scene accepts every value of an axis, and that none changes the number of unknowns. */
static saltus_status check_axis(saltus_sweep *sweep, int axis, saltus_message *message) {
    const saltus_axis *a = &sweep->axes[axis];
    saltus_direction direction;
    saltus_status status = SALTUS_OK;
    if (is_start_key(&sweep->scene.spec, a->key))
        sweep->moves_start = true;
    else
        status = saltus_spec_direction(&sweep->scene.spec, a->key, &direction, NULL, message);
    saltus_scene scene = sweep->scene;
    for (int k = 0; k < a->count && status == SALTUS_OK; k++)
        status = set_value(&scene, a, k, message);
    for (int k = 0; k < axis && status == SALTUS_OK; k++)
        if (saltus_scene_overrides(&sweep->scene, a->key, sweep->axes[k].key) ||
            saltus_scene_overrides(&sweep->scene, sweep->axes[k].key, a->key))
            status =
                saltus_fail(message, SALTUS_BAD_INPUT, "%s and %s: the same is given twice, for two axes",
                            sweep->axes[k].key, a->key);
    return status;
}

static saltus_status take_axes(saltus_sweep *sweep, const saltus_axis *axes, int count,
                               saltus_message *message) {
    sweep->points = 1;
    for (int k = 0; k < count; k++) {
        sweep->axes[k] = axes[k];
        sweep->axis_count = k + 1;
        if (axes[k].count < 1)
            return saltus_fail(message, SALTUS_BAD_INPUT, "%s: an axis needs at least one value",
                               axes[k].key);
        if (axes[k].list) {
            size_t bytes = (size_t)axes[k].count * sizeof *axes[k].list;
            sweep->lists[k] = malloc(bytes);
            if (!sweep->lists[k])
                return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the values of %s", axes[k].key);
            memcpy(sweep->lists[k], axes[k].list, bytes);
            sweep->axes[k].list = sweep->lists[k];
        }
        saltus_status status = check_axis(sweep, k, message);
        if (status != SALTUS_OK)
            return status;
        sweep->points *= axes[k].count;
    }
    return SALTUS_OK;
}

/* Check the system of one point. *fitting: the integrator for the stiffest system so far; sweep->system: the
 * one with the most terms, which stands for all. */
static saltus_status check_point(saltus_sweep *sweep, long long point, saltus_integrator *fitting,
                                 saltus_message *message) {
    saltus_system *system = NULL;
    saltus_status status = saltus_sweep_system(sweep, point, &system, message);
    if (status != SALTUS_OK)
        return status;
    if (system->stiffness_ratio > 1 && saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX) == 1)
        *fitting = SALTUS_MIXED;
    else if (system->stiffness_ratio > 1 && *fitting == SALTUS_AUTOMATIC)
        *fitting = SALTUS_TAYLOR;
    bool fuller = !sweep->system || (system->coefficients.terms & ~sweep->system->coefficients.terms);
    saltus_system *other = fuller ? sweep->system : system;
    if (fuller)
        sweep->system = system;
    saltus_system_free(other);
    return SALTUS_OK;
}

/* Check the systems at the ends of the axes and at each entry of a list. If some are stiff all trajectories
 * use one integrator, so that it does not depend on which ones run side by side. */
static saltus_status check_corners(saltus_sweep *sweep, saltus_message *message) {
    const saltus_axis *across = &sweep->axes[0];
    const int rows = sweep->axis_count > 1 ? sweep->axes[1].count : 1;
    saltus_integrator fitting = SALTUS_AUTOMATIC;
    const bool every_row = sweep->axis_count > 1 && sweep->axes[1].list;
    saltus_status status = SALTUS_OK;
    for (int j = 0; j < rows && status == SALTUS_OK; j += every_row || rows < 2 ? 1 : rows - 1)
        for (int k = 0; k < across->count && status == SALTUS_OK;
             k += across->list || across->count < 2 ? 1 : across->count - 1)
            status = check_point(sweep, (long long)j * across->count + k, &fitting, message);
    if (sweep->options.flow.integrator == SALTUS_AUTOMATIC)
        sweep->options.flow.integrator = fitting;
    if (status == SALTUS_OK)
        sweep->dimension = saltus_system_dimension(sweep->system);
    return status;
}

static saltus_status check_starts(const saltus_sweep *sweep, saltus_message *message) {
    const saltus_scene *scene = &sweep->scene;
    if (scene->initial_count && scene->initial_count != sweep->dimension)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: initial state has %d entries, the system needs %d",
                           scene->name, scene->initial_count, sweep->dimension);
    if (sweep->moves_start && sweep->options.passes != 1u << SALTUS_PASS_RESET)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "an axis of initial states goes with a reset pass only, not with up or down");
    if (sweep->points > rows_max / sweep->pass_count / sweep->options.seeds)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%lld points with %d passes and %d seeds: more than %lld trajectories",
                           sweep->points, sweep->pass_count, sweep->options.seeds, rows_max);
    return SALTUS_OK;
}

saltus_status saltus_sweep_new(const saltus_scene *scene, const saltus_axis *axes, int axis_count,
                               const saltus_sweep_options *options, saltus_sweep **sweep,
                               saltus_message *message) {
    *sweep = NULL;
    if (axis_count < 1 || axis_count > SALTUS_AXES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "a sweep needs one or two axes, not %d", axis_count);
    saltus_status status = saltus_sweep_check(options, message);
    if (status != SALTUS_OK)
        return status;
    saltus_sweep *made = calloc(1, sizeof *made);
    if (!made)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the sweep");
    made->scene = *scene;
    made->options = *options;
    made->options.flow.columns = made->options.flow.directions = 0;
    for (int k = 0; k < SALTUS_PASSES; k++)
        if (options->passes >> k & 1)
            made->passes[made->pass_count++] = (saltus_pass)k;
    status = take_axes(made, axes, axis_count, message);
    if (status == SALTUS_OK)
        status = check_corners(made, message);
    if (status == SALTUS_OK)
        status = check_starts(made, message);
    if (status == SALTUS_OK) {
        /* The flow's options are valid if a flow can be made with them. */
        const saltus_system *system = made->system;
        saltus_flow *flow = NULL;
        status = saltus_flow_new(&system, 1, &made->options.flow, &flow, message);
        saltus_flow_free(flow);
    }
    if (status == SALTUS_OK)
        *sweep = made;
    else
        saltus_sweep_free(made);
    return status;
}

void saltus_sweep_free(saltus_sweep *sweep) {
    if (!sweep)
        return;
    for (int k = 0; k < SALTUS_AXES_MAX; k++)
        free(sweep->lists[k]);
    saltus_system_free(sweep->system);
    free(sweep);
}

const saltus_scene *saltus_sweep_scene(const saltus_sweep *sweep) {
    return &sweep->scene;
}
int saltus_sweep_axis_count(const saltus_sweep *sweep) {
    return sweep->axis_count;
}
const saltus_axis *saltus_sweep_axis(const saltus_sweep *sweep, int axis) {
    return &sweep->axes[axis];
}
const saltus_sweep_options *saltus_sweep_choices(const saltus_sweep *sweep) {
    return &sweep->options;
}
int saltus_sweep_dimension(const saltus_sweep *sweep) {
    return sweep->dimension;
}
long long saltus_sweep_points(const saltus_sweep *sweep) {
    return sweep->points;
}
int saltus_sweep_pass_count(const saltus_sweep *sweep) {
    return sweep->pass_count;
}
saltus_pass saltus_sweep_pass_at(const saltus_sweep *sweep, int k) {
    return sweep->passes[k];
}
long long saltus_sweep_rows(const saltus_sweep *sweep) {
    return sweep->pass_count * sweep->points * sweep->options.seeds;
}

saltus_status saltus_sweep_scene_at(const saltus_sweep *sweep, long long point, saltus_scene *scene,
                                    saltus_message *message) {
    saltus_status status = SALTUS_OK;
    *scene = sweep->scene;
    for (int k = 0; k < sweep->axis_count && status == SALTUS_OK; k++) {
        status = set_value(scene, &sweep->axes[k], (int)(point % sweep->axes[k].count), message);
        point /= sweep->axes[k].count;
    }
    return status;
}

saltus_status saltus_sweep_system(const saltus_sweep *sweep, long long point, saltus_system **system,
                                  saltus_message *message) {
    saltus_scene scene;
    *system = NULL;
    saltus_status status = saltus_sweep_scene_at(sweep, point, &scene, message);
    return status == SALTUS_OK ? saltus_system_new(&scene.spec, system, message) : status;
}

/* Number of tasks of the k-th pass: points if each starts anew, otherwise lines along the first axis. */
static long long pass_tasks(const saltus_sweep *sweep, int k) {
    return sweep->passes[k] == SALTUS_PASS_RESET ? sweep->points : sweep->points / sweep->axes[0].count;
}

static int pass_of(const saltus_sweep *sweep, long long *task) {
    int k = 0;
    while (k + 1 < sweep->pass_count && *task >= pass_tasks(sweep, k))
        *task -= pass_tasks(sweep, k++);
    return k;
}

long long saltus_sweep_tasks(const saltus_sweep *sweep) {
    long long sum = 0;
    for (int k = 0; k < sweep->pass_count; k++)
        sum += pass_tasks(sweep, k);
    return sum;
}

int saltus_sweep_task_length(const saltus_sweep *sweep, long long task) {
    return sweep->passes[pass_of(sweep, &task)] == SALTUS_PASS_RESET ? 1 : sweep->axes[0].count;
}

long long saltus_sweep_task_place(const saltus_sweep *sweep, long long task, int k) {
    int pass = pass_of(sweep, &task), count = sweep->axes[0].count;
    long long first = pass * sweep->points;
    switch (sweep->passes[pass]) {
    case SALTUS_PASS_UP:
        return first + task * count + k;
    case SALTUS_PASS_DOWN:
        return first + task * count + (count - 1 - k);
    default:
        return first + task;
    }
}

long long saltus_sweep_task_of(const saltus_sweep *sweep, long long place) {
    const int pass = (int)(place / sweep->points);
    const long long point = place % sweep->points;
    long long first = 0;
    for (int k = 0; k < pass; k++)
        first += pass_tasks(sweep, k);
    return first + (sweep->passes[pass] == SALTUS_PASS_RESET ? point : point / sweep->axes[0].count);
}

void saltus_sweep_label(const saltus_sweep_row *row, char label[SALTUS_LABEL_MAX]) {
    saltus_verdict_label((saltus_verdict)row->verdict, row->impacts, row->periods, label);
}

saltus_sweep_row saltus_sweep_row_of(saltus_verdict verdict) {
    return (saltus_sweep_row){.verdict = (int)verdict,
                              .attractor = -1,
                              .largest = NAN,
                              .smallest = NAN,
                              .rms = NAN,
                              .impact_rate = NAN,
                              .largest_speed = NAN,
                              .contact_fraction = NAN,
                              .lyapunov = NAN,
                              .lyapunov_error = NAN,
                              .lifetime_at_least = NAN,
                              .period = NAN};
}
