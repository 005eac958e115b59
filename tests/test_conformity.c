/* What the library requires of every model, tried on all built-in scenes: series agree with the field,
 * tangent vectors and parameter columns are derivatives, the trace is the field's, a claimed symmetry holds,
 * and files describe the same system. No model is named here: a new one is tried as soon as a scene has it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "folder.h"

#include <unistd.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

enum { levels = 4, columns_max = 24 };

/* A scene in motion: a state off all stops, at a phase without special symmetry. */
typedef struct subject {
    const char *name;
    saltus_spec spec;
    saltus_system *system;
    double phase, state[SALTUS_STATE_MAX];
    int n, dof;
} subject;

/* The k-th built-in scene, with its stops or without, some way into its motion. */
static subject subject_of(int k, bool stops) {
    subject s = {.name = saltus_scene_builtin_name(k), .phase = 0.1};
    saltus_scene scene;
    saltus_message message = {.text = ""};
    double start[SALTUS_STATE_MAX];
    check_ok(saltus_scene_load(s.name, &scene, &message), &message);
    s.spec = scene.spec;
    if (!stops)
        s.spec.stop_count = 0;
    s.system = build(&s.spec);
    s.n = saltus_system_dimension(s.system);
    s.dof = saltus_system_dof(s.system);
    check_ok(saltus_system_default_state(s.system, start, &message), &message);
    if (scene.initial_count)
        memcpy(start, scene.initial, (size_t)s.n * sizeof *start);
    /* A bit of everything, so that no coefficient of the series is zero. */
    for (int i = 0; i < s.n; i++)
        start[i] += 0.01 * saltus_system_scale(s.system)[i] * sin(1 + 2 * i);
    if (saltus_system_check_state(s.system, start, &message) != SALTUS_OK)
        for (int i = 0; i < s.n; i++)
            start[i] -= 0.02 * saltus_system_scale(s.system)[i] * sin(1 + 2 * i);
    check_ok(saltus_system_check_state(s.system, start, &message), &message);
    memcpy(s.state, start, sizeof s.state);
    saltus_scene_clear(&scene); /* the system keeps the model */
    return s;
}

static saltus_flow *open_at(const subject *s, int columns, double rtol) {
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = rtol;
    options.columns = columns;
    return open_flow(s->system, &options, s->phase, s->state);
}

/* Largest difference of two vectors in units of the state's scale, relative to the second one's size. */
static double distance(const subject *s, const double *a, const double *b) {
    const double *scale = saltus_system_scale(s->system);
    double difference = 0, size = 0;
    for (int i = 0; i < s->n; i++) {
        difference = fmax(difference, fabs(a[i] - b[i]) / scale[i]);
        size = fmax(size, fabs(b[i]) / scale[i]);
    }
    return size > 0 ? difference / size : difference;
}

/* The model's field, from the first order of its series, in GSL's form. */
static int field(double time, const double *state, double *derivative, void *context) {
    const subject *s = ((void **)context)[0];
    saltus_message message = {.text = ""};
    double periods = s->phase + time / saltus_system_period(s->system), whole = floor(periods);
    saltus_flow *flow = ((void **)context)[1];
    if (saltus_flow_place(flow, 0, (saltus_time){(long long)whole, periods - whole}, state, 0, &message) !=
        SALTUS_OK)
        return GSL_EBADFUNC;
    saltus_flow_field(flow, 0, derivative);
    return GSL_SUCCESS;
}

/* Between impacts the flow solves its own field's equations, so all orders of the series agree with the
 * first. */
static void series_belong_to_the_field(void **unused) {
    (void)unused;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        subject s = subject_of(k, false);
        const double part = 0.2, span = part * saltus_system_period(s.system);
        saltus_flow *flow = open_at(&s, 0, 1e-14), *single = open_at(&s, 0, 1e-14);
        void *context[] = {&s, single};
        gsl_odeiv2_system equations = {field, NULL, (size_t)s.n, context};
        gsl_odeiv2_driver *driver =
            gsl_odeiv2_driver_alloc_y_new(&equations, gsl_odeiv2_step_rk8pd, 1e-4 * span, 1e-14, 1e-13);
        double state[SALTUS_STATE_MAX], expected[SALTUS_STATE_MAX], time = 0;
        memcpy(expected, s.state, sizeof expected);
        assert_int_equal(gsl_odeiv2_driver_apply(driver, &time, span, expected), GSL_SUCCESS);
        advance(flow, s.phase + part, 0);
        saltus_flow_state(flow, 0, state);
        if (!(distance(&s, state, expected) < 1e-10))
            fail_msg("%s: the flow is off its field's solution by %.3g", s.name,
                     distance(&s, state, expected));
        gsl_odeiv2_driver_free(driver);
        saltus_flow_free(single);
        saltus_flow_free(flow);
        saltus_system_free(s.system);
    }
}

/* The result of a run: its state and events. */
typedef struct outcome {
    double state[SALTUS_STATE_MAX];
    saltus_flow_info met;
} outcome;

static outcome run(const subject *s, const saltus_spec *spec, const double *state, double end) {
    saltus_system *system = build(spec);
    saltus_flow_options options = saltus_flow_defaults();
    outcome result;
    options.rtol = 1e-14;
    saltus_flow *flow = open_flow(system, &options, s->phase, state);
    advance(flow, end, 0);
    saltus_flow_state(flow, 0, result.state);
    result.met = saltus_flow_information(flow, 0);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return result;
}

/* The time just after the third impact, or after two periods if there are fewer; none after a stick. */
static double time_after_impacts(const subject *s, int *impacts) {
    saltus_flow *flow = open_at(s, 0, 1e-14);
    saltus_event event = {.kind = SALTUS_IMPACT, .time = {0, s->phase}};
    *impacts = 0;
    double end = s->phase + 10, last = s->phase;
    while (*impacts < 4 && event.kind == SALTUS_IMPACT) {
        event = advance(flow, end, SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK);
        double now = saltus_time_periods(event.time);
        if (event.kind == SALTUS_REACHED)
            last = end;
        else if (event.kind == SALTUS_STICK || *impacts == 3)
            end = last + 0.4 * (now - last);
        else
            last = now;
        *impacts += event.kind == SALTUS_IMPACT;
    }
    *impacts = *impacts > 3 ? 3 : *impacts;
    saltus_flow_free(flow);
    return event.kind == SALTUS_REACHED ? s->phase + 10 : end;
}

/* The derivative of the state at `end` by an amount along `towards` (of the start) or `direction` (of the
 * parameters): central differences at steps h, h/2, ..., extrapolated (Richardson). False if their events
 * differ or they do not agree with each other. */
static bool differentiate(const subject *s, const double *towards, const saltus_direction *direction,
                          double h, double end, double *derivative) {
    double table[levels][SALTUS_STATE_MAX], before[SALTUS_STATE_MAX];
    const outcome centre = run(s, &s->spec, s->state, end);
    for (int k = 0; k < levels; k++, h /= 2) {
        outcome side[2];
        for (int j = 0; j < 2; j++) {
            const double amount = j ? -h : h;
            saltus_spec spec = direction ? saltus_spec_shifted(&s->spec, direction, amount) : s->spec;
            double state[SALTUS_STATE_MAX];
            for (int i = 0; i < s->n; i++)
                state[i] = s->state[i] + (towards ? amount * towards[i] : 0);
            side[j] = run(s, &spec, state, end);
            if (side[j].met.impacts != centre.met.impacts || side[j].met.sticks != centre.met.sticks)
                return false;
        }
        for (int i = 0; i < s->n; i++)
            table[k][i] = (side[0].state[i] - side[1].state[i]) / (2 * h);
    }
    for (int j = 1; j < levels; j++)
        for (int k = levels - 1; k >= j; k--) {
            memcpy(before, table[k], sizeof before);
            for (int i = 0; i < s->n; i++)
                table[k][i] += (table[k][i] - table[k - 1][i]) / (exp2(2 * j) - 1);
        }
    memcpy(derivative, table[levels - 1], (size_t)s->n * sizeof *derivative);
    return distance(s, before, derivative) < 1e-7;
}

/* Tangent vectors are derivatives with respect to the start, impacts included. */
static void tangent_vectors_are_derivatives(void **unused) {
    (void)unused;
    int through_impacts = 0, tried = 0;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        subject s = subject_of(k, true);
        int impacts;
        const double end = time_after_impacts(&s, &impacts);
        double columns[columns_max * SALTUS_STATE_MAX];
        assert_true(s.n <= columns_max);
        saltus_flow *flow = open_at(&s, s.n, 1e-14);
        advance(flow, end, 0);
        saltus_flow_tangents(flow, 0, columns);
        for (int c = 0; c < s.n; c++) {
            double towards[SALTUS_STATE_MAX] = {0}, expected[SALTUS_STATE_MAX];
            towards[c] = 1;
            if (!differentiate(&s, towards, NULL, 2e-3 * saltus_system_scale(s.system)[c], end, expected))
                continue;
            const double *column = columns + (size_t)c * (size_t)s.n;
            if (!(distance(&s, column, expected) < 1e-6))
                fail_msg("%s: tangent vector %d is off by %.3g of its size after %d impacts", s.name, c,
                         distance(&s, column, expected), impacts);
            tried++;
            through_impacts += impacts > 0;
        }
        saltus_flow_free(flow);
        saltus_system_free(s.system);
    }
    /* For few starts do differences meet another sequence of events. */
    assert_true(tried >= 5 * saltus_scene_builtin_count());
    assert_true(through_impacts >= tried / 2);
}

/* The column of every parameter that can be varied is the derivative by it. */
static void parameter_columns_are_derivatives(void **unused) {
    (void)unused;
    static const char *const of_stops[] = {"d", "r", "xi"};
    int tried = 0;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        subject s = subject_of(k, true);
        int impacts, count;
        const double end = time_after_impacts(&s, &impacts);
        const saltus_parameter *parameters = saltus_model_parameters(s.spec.model, &count);
        for (int p = 0; p < count + 3; p++) {
            const char *key = p < count ? parameters[p].name : of_stops[p - count];
            saltus_direction direction;
            saltus_message message = {.text = ""};
            double value, column[(SALTUS_DIRECTIONS_MAX + 1) * SALTUS_STATE_MAX], expected[SALTUS_STATE_MAX];
            if (saltus_spec_direction(&s.spec, key, &direction, &value, &message) != SALTUS_OK || value == 0)
                continue;
            saltus_spec above = saltus_spec_shifted(&s.spec, &direction, 1e-4 * fabs(value));
            saltus_system *possible = NULL;
            if (saltus_system_new(&above, &possible, &message) != SALTUS_OK)
                continue; /* at its bound */
            saltus_system_free(possible);
            if (!differentiate(&s, NULL, &direction, 1e-4 * fabs(value), end, expected))
                continue;
            saltus_flow_options options = saltus_flow_defaults();
            saltus_flow *flow = NULL;
            options.rtol = 1e-14;
            options.columns = options.directions = 1;
            check_ok(saltus_flow_new((const saltus_system *[]){s.system}, 1, &options, &flow, &message),
                     &message);
            saltus_flow_set_directions(flow, &direction);
            check_ok(saltus_flow_start(flow, 0, (saltus_time){0, s.phase}, s.state, &message), &message);
            advance(flow, end, 0);
            saltus_flow_tangents(flow, 0, column);
            double error = distance(&s, column, expected);
            if (!(error < 1e-6))
                fail_msg("%s: the column of %s is off by %.3g of its size after %d impacts", s.name, key,
                         error, impacts);
            saltus_flow_free(flow);
            tried++;
        }
        saltus_system_free(s.system);
    }
    assert_true(tried >= 4 * saltus_scene_builtin_count());
}

/* The trace is that of the field's derivative. */
static void traces_are_the_fields(void **unused) {
    (void)unused;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        subject s = subject_of(k, false);
        double columns[columns_max * SALTUS_STATE_MAX], sum = 0, size = 0;
        saltus_flow *flow = open_at(&s, s.n, 1e-13);
        saltus_flow_tangent_field(flow, 0, columns);
        for (int i = 0; i < s.n; i++) {
            sum += columns[i * s.n + i];
            size += fabs(columns[i * s.n + i]);
        }
        check_near(saltus_system_trace(s.system, s.state, s.phase), sum, 1e-12 * (1 + size));
        saltus_flow_free(flow);
        saltus_system_free(s.system);
    }
}

/* If a system has the symmetry q -> -q, mirrored starts have mirrored motions, half a period later if it says
 * so. If it has none they have not, unless nothing pushes to one side. */
static void symmetries_hold(void **unused) {
    (void)unused;
    int symmetric = 0, others = 0;
    for (int k = 0; k < 2 * saltus_scene_builtin_count(); k++) {
        subject s = subject_of(k / 2, k % 2);
        bool shift = false, mirror = saltus_system_mirror_symmetric(s.system, &shift);
        saltus_message message = {.text = ""};
        subject image = s;
        outcome a, b;
        for (int i = 0; i < s.n; i++)
            image.state[i] = -s.state[i];
        image.phase += shift ? 0.5 : 0;
        if (!mirror || saltus_system_check_state(s.system, image.state, &message) != SALTUS_OK) {
            others += !mirror;
            saltus_system_free(s.system);
            continue;
        }
        int impacts;
        const double end = time_after_impacts(&s, &impacts);
        a = run(&s, &s.spec, s.state, end);
        b = run(&image, &s.spec, image.state, end + (shift ? 0.5 : 0));
        for (int i = 0; i < s.n; i++)
            b.state[i] = -b.state[i];
        if (!(distance(&s, b.state, a.state) < 1e-9))
            fail_msg("%s: the mirror image is off by %.3g", s.name, distance(&s, b.state, a.state));
        symmetric++;
        saltus_system_free(s.system);
    }
    assert_true(symmetric > 0 && others > 0);
}

/* A motion written as JSON and read back as a start belongs to the same system, to the last bit, as does a
 * scene that the command line prints. */
static void files_tell_the_same_system(void **unused) {
    (void)unused;
    char folder[] = "/tmp/saltus-test-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/orbit.json", folder);
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        subject s = subject_of(k, true);
        saltus_scene scene = {.spec = s.spec};
        saltus_message message = {.text = ""};
        saltus_start start;
        snprintf(scene.name, sizeof scene.name, "%s", s.name);
        saltus_motion motion = {.verdict = SALTUS_PERIODIC, .periods = 3, .impacts = 2, .dimension = s.n};
        strcpy(motion.label, "2/3");
        motion.state = s.state;
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        saltus_write_motion_json(file, &scene, s.system, &motion);
        assert_int_equal(fclose(file), 0);
        check_ok(saltus_start_read(path, NULL, &start, &message), &message);
        assert_true(saltus_spec_equal(&start.spec, &s.spec));
        assert_int_equal(start.periods, 3);
        assert_memory_equal(start.state, s.state, (size_t)s.n * sizeof *s.state);
        saltus_start_release(&start);
        saltus_system_free(s.system);
    }
    folder_files(folder, true);
    rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(series_belong_to_the_field),
        cmocka_unit_test(tangent_vectors_are_derivatives),
        cmocka_unit_test(parameter_columns_are_derivatives),
        cmocka_unit_test(traces_are_the_fields),
        cmocka_unit_test(symmetries_hold),
        cmocka_unit_test(files_tell_the_same_system),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
