/* What the tests of sweeps share: a sweep in one call, its results as packed bytes, one point by itself.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_SWEEP_CHECK_H
#define SALTUS_TESTS_SWEEP_CHECK_H

#include "check.h"

/* A scene by name with settings, one after the other, separated by blanks. "free" takes the stops away. */
static inline saltus_scene scene_of(const char *name, const char *settings) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    char text[256];
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    snprintf(text, sizeof text, "%s", settings);
    for (char *rest = text, *word; (word = strtok_r(rest, " ", &rest));)
        if (strcmp(word, "free") == 0)
            scene.spec.stop_count = 0;
        else
            check_ok(saltus_scene_set(&scene, word, &message), &message);
    return scene;
}

static inline saltus_sweep *sweep_of(const saltus_scene *scene, const char *first, const char *second,
                                     const saltus_sweep_options *options) {
    saltus_message message = {.text = ""};
    saltus_axis axes[2];
    double *lists[2] = {NULL, NULL};
    saltus_sweep *sweep = NULL;
    check_ok(saltus_axis_read(first, &axes[0], &lists[0], &message), &message);
    if (second)
        check_ok(saltus_axis_read(second, &axes[1], &lists[1], &message), &message);
    check_ok(saltus_sweep_new(scene, axes, second ? 2 : 1, options, &sweep, &message), &message);
    free(lists[0]);
    free(lists[1]);
    return sweep;
}

/* Results as packed bytes, one block per place. */
typedef struct outcome {
    const saltus_sweep *sweep;
    long long places, first, step, tasks, handed; /* tasks first, first + step, ... */
    void **block;
    size_t *size;
} outcome;

static inline outcome open_outcome(const saltus_sweep *sweep) {
    outcome o = {.sweep = sweep, .places = saltus_sweep_points(sweep) * saltus_sweep_pass_count(sweep)};
    o.block = calloc((size_t)o.places, sizeof *o.block);
    o.size = calloc((size_t)o.places, sizeof *o.size);
    assert_true(o.block && o.size);
    return o;
}

static inline void close_outcome(outcome *o) {
    for (long long k = 0; k < o->places; k++)
        free(o->block[k]);
    free(o->block);
    free(o->size);
}

static inline long long next_task(void *context) {
    outcome *o = context;
    return o->handed < o->tasks ? o->first + o->step * o->handed++ : -1;
}

static inline saltus_status keep_result(void *context, const saltus_sweep_result *result,
                                        saltus_message *message) {
    outcome *o = context;
    size_t size = saltus_sweep_packed_size(o->sweep, result);
    void *block = malloc(size);
    if (!block)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a result");
    saltus_sweep_pack(o->sweep, result, block);
    free(o->block[result->place]);
    o->block[result->place] = block;
    o->size[result->place] = size;
    return SALTUS_OK;
}

/* Run every step-th task from `first` on, downwards where step is negative. */
static inline void run_part(outcome *o, long long first, long long step) {
    saltus_message message = {.text = ""};
    saltus_sweep_feed feed = {.context = o, .next = next_task, .take = keep_result};
    long long all = saltus_sweep_tasks(o->sweep);
    o->first = first;
    o->step = step;
    o->handed = 0;
    o->tasks = step > 0 ? (all - first + step - 1) / step : first + 1;
    check_ok(saltus_sweep_run(o->sweep, &feed, &message), &message);
}

static inline saltus_sweep_result result_at(const outcome *o, long long place) {
    saltus_sweep_result result;
    assert_non_null(o->block[place]);
    assert_true(saltus_sweep_unpack(o->sweep, o->block[place], o->size[place], &result));
    assert_true(result.place == place);
    return result;
}

static inline void check_same_bits(const outcome *a, const outcome *b, const char *what) {
    assert_true(a->places == b->places);
    for (long long k = 0; k < a->places; k++)
        if (!a->block[k] || !b->block[k] || a->size[k] != b->size[k] ||
            memcmp(a->block[k], b->block[k], a->size[k]) != 0)
            fail_msg("%s: place %lld of %lld differs", what, k, a->places);
}

static inline saltus_system *system_at(const saltus_sweep *sweep, long long point) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    check_ok(saltus_sweep_scene_at(sweep, point, &scene, &message), &message);
    return build(&scene.spec);
}

static inline saltus_motion motion_from(const saltus_system *system, const double *state, int longest) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    options.transient = 2000;
    options.longest = longest;
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    return motion;
}

/* What saltus_classify says from the trajectory's end is what the row says. Returns whether it is settled. */
static inline bool check_label(const outcome *o, long long place, int seed) {
    saltus_sweep_result result = result_at(o, place);
    const saltus_sweep_row *row = &result.rows[seed];
    char label[32];
    saltus_sweep_label(row, label);
    if (!saltus_verdict_settled(row->verdict))
        return false;
    saltus_system *system = system_at(o->sweep, place % saltus_sweep_points(o->sweep));
    saltus_motion motion = motion_from(system, result.states + seed * saltus_sweep_dimension(o->sweep),
                                       saltus_sweep_choices(o->sweep)->longest);
    assert_string_equal(label, motion.label);
    if (row->verdict == SALTUS_PERIODIC)
        assert_int_equal(row->sticking, motion.sticking_intervals);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return true;
}

/* One point: the scene's own values, `key` once more. */
typedef struct single {
    saltus_sweep *sweep;
    outcome outcome;
    saltus_sweep_result result;
    char label[32];
} single;

static inline single run_single(const saltus_scene *scene, const char *key, double value,
                                const saltus_sweep_options *options) {
    char axis[64];
    single s;
    snprintf(axis, sizeof axis, "%s=%.17g", key, value);
    s.sweep = sweep_of(scene, axis, NULL, options);
    s.outcome = open_outcome(s.sweep);
    run_part(&s.outcome, 0, 1);
    s.result = result_at(&s.outcome, 0);
    saltus_sweep_label(s.result.rows, s.label);
    return s;
}

static inline void close_single(single *s) {
    close_outcome(&s->outcome);
    saltus_sweep_free(s->sweep);
}

#endif
