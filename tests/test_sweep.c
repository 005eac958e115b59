/* Sweeps: axes, the same bits for any division of the work, correct classes, clouds and measures, hysteresis,
 * reported failures. SALTUS_LONG_TESTS=1: more ways to divide the work, every allocation, more seeds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "allocations.h"
#include "check.h"
#include "sweep_check.h"

enum { dimension_max = 40 };

/* Allocations are counted while `failing` is set: with one thread. */
static long allocations, failing = -1;

static bool refuse(void) {
    return failing >= 0 && ++allocations == failing;
}

static void axes_have_their_values(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_axis axis;
    double *list;
    check_ok(saltus_axis_read("omega=0.1:55:1000", &axis, &list, &message), &message);
    assert_null(list);
    assert_string_equal(axis.key, "omega");
    assert_int_equal(axis.count, 1000);
    assert_true(saltus_axis_value(&axis, 0) == 0.1 && saltus_axis_value(&axis, 999) == 55);
    check_near(saltus_axis_value(&axis, 333), 0.1 + 54.9 * 333 / 999, 1e-13);
    check_ok(saltus_axis_read("d=0.046:0:47", &axis, &list, &message), &message);
    assert_true(saltus_axis_value(&axis, 0) == 0.046 && saltus_axis_value(&axis, 46) == 0);
    check_near(saltus_axis_value(&axis, 1), 0.045, 1e-17);
    check_ok(saltus_axis_read("alpha=1e-4:1e-2:5:log", &axis, &list, &message), &message);
    assert_int_equal(axis.spacing, SALTUS_LOGARITHMIC);
    assert_true(saltus_axis_value(&axis, 0) == 1e-4 && saltus_axis_value(&axis, 4) == 1e-2);
    check_near(saltus_axis_value(&axis, 2), 1e-3, 1e-18);
    check_ok(saltus_axis_read("r=0.9,0.5,0.7", &axis, &list, &message), &message);
    assert_int_equal(axis.count, 3);
    assert_true(axis.low == 0.9 && axis.high == 0.7 && saltus_axis_value(&axis, 1) == 0.5);
    free(list);
    check_ok(saltus_axis_read("q1=-3e-2", &axis, &list, &message), &message);
    assert_int_equal(axis.count, 1);
    assert_true(saltus_axis_value(&axis, 0) == -3e-2);
    free(list);
    /* Numbers may be expressions; separators in parentheses belong to them. */
    check_ok(saltus_axis_read("omega=pi/2:atan2(1,-1):2^5+1", &axis, &list, &message), &message);
    assert_int_equal(axis.count, 33);
    check_near(axis.low, acos(-1) / 2, 1e-16);
    check_near(axis.high, 0.75 * acos(-1), 1e-15);
    check_ok(saltus_axis_read("d=-(1/4),min(1,2),3", &axis, &list, &message), &message);
    assert_int_equal(axis.count, 3);
    assert_true(axis.low == -0.25 && saltus_axis_value(&axis, 1) == 1 && axis.high == 3);
    free(list);
}

static void bad_axes_are_refused(void **unused) {
    (void)unused;
    static const char *const texts[] = {"",
                                        "omega",
                                        "=1:2:3",
                                        "omega=",
                                        "omega=1:2",
                                        "omega=1:2:1",
                                        "omega=:",
                                        "omega=1:2:3:",
                                        "omega=1:2:x",
                                        "omega=1:2:2.5",
                                        "omega=1:2:3:lag",
                                        "omega=:2:3",
                                        "q1=:2:3",
                                        "q1=1x:2:3",
                                        "q1=1::3",
                                        "q1=1:2x:3",
                                        "q1=1:2:3:log1",
                                        "q1=1:2:3log",
                                        "omega=1:1:5",
                                        "d=1,,2",
                                        "d=1,2,",
                                        "d=,1",
                                        "d=1;2",
                                        "d=nan",
                                        "d=1,inf",
                                        "d=0:nan:4",
                                        "d=0:1:4:log",
                                        "d=-1:1:4:log",
                                        "omega=1:2:1e9",
                                        "omega=1:2:3:log:4",
                                        "omega=a:2:3",
                                        "omega=1:b:3",
                                        "averyveryveryveryveryveryverylongkey=1:2:3",
                                        "omega=1:2:-3",
                                        "omega=1:2:",
                                        "omega=1:2*(3:4",
                                        "omega=1/0:2:3",
                                        "d=1,(2,3)"};
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
        saltus_message message = {.text = ""};
        saltus_axis axis;
        double *list;
        if (saltus_axis_read(texts[k], &axis, &list, &message) != SALTUS_BAD_INPUT)
            fail_msg("accepted: %s", texts[k]);
        assert_null(list);
        assert_true(strlen(message.text) > 20);
    }
}

static void check_refused(const char *scene_name, const char *settings, const char *first, const char *second,
                          const saltus_sweep_options *options) {
    saltus_scene scene = scene_of(scene_name, settings);
    saltus_message message = {.text = ""};
    saltus_axis axes[2];
    double *lists[2] = {NULL, NULL};
    saltus_sweep *sweep = NULL;
    check_ok(saltus_axis_read(first, &axes[0], &lists[0], &message), &message);
    if (second)
        check_ok(saltus_axis_read(second, &axes[1], &lists[1], &message), &message);
    if (saltus_sweep_new(&scene, axes, second ? 2 : 1, options, &sweep, &message) != SALTUS_BAD_INPUT)
        fail_msg("accepted: %s with %s, %s, %s", scene_name, settings, first, second ? second : "");
    assert_null(sweep);
    assert_true(strlen(message.text) > 10);
    free(lists[0]);
    free(lists[1]);
}

static void bad_sweeps_are_refused(void **unused) {
    (void)unused;
    const saltus_sweep_options good = saltus_sweep_defaults();
    check_refused("pipe", "", "N=1,2,3", NULL, &good);
    check_refused("pipe", "", "nothing=1:2:3", NULL, &good);
    check_refused("pipe", "", "omega=-1:2:3", NULL, &good);
    check_refused("pipe", "", "r=0.5,1.5", NULL, &good);
    check_refused("pipe", "", "omega=1:2:3", "omega=2:3:4", &good);
    check_refused("pipe", "", "q99=0:0.1:3", NULL, &good);
    check_refused("pipe", "free", "d=0.01:0.02:3", NULL, &good);
    check_refused("pipe", "sides=both", "d=-0.01:0.02:4", NULL, &good);
    saltus_sweep_options bad[10];
    for (int k = 0; k < 10; k++)
        bad[k] = good;
    bad[9].measure = -1;
    bad[0].seeds = 0;
    bad[1].passes = 0;
    bad[2].passes = 8;
    bad[3].longest = 257;
    bad[4].record = 0;
    bad[5].transient = 0;
    bad[6].lanes = -1;
    bad[7].threads = -1;
    bad[8].flow.rtol = 1;
    for (int k = 0; k < 10; k++)
        check_refused("pipe", "", "omega=20:30:3", NULL, &bad[k]);
    saltus_sweep_options carried = good;
    carried.passes = 1u << SALTUS_PASS_UP;
    check_refused("pipe", "", "q1=0:0.01:3", NULL, &carried);
    carried = good;
    carried.seeds = 10000;
    check_refused("pipe", "", "omega=20:30:100000", "d=0.03:0.04:10", &carried);
}

/* Scenes whose systems differ in terms along the grid, that stick, that are stiff, that have no stop or two,
 * with everything recorded or nothing. */
typedef struct division {
    const char *scene, *settings, *first, *second;
    unsigned keep, passes;
    int seeds;
    bool fixed;
} division;

static const division divisions[] = {
    {"pipe", "", "omega=38:44:5", "d=0.03,0.035", 15, 1, 2, false},
    {"pipe", "omega=43", "d=0.0294:0.0301:5", NULL, 1, 7, 1, false},
    {"pipe", "N=2", "sigma=0:0.3:4", "kappa=0,5000", 15, 1, 1, true},
    {"pipe", "N=2 u0=2", "sigma=0.3:0:4", NULL, 0, 6, 2, false},
    {"pipe", "d=0.035", "omega=10:12:2", NULL, 8, 3, 2, false},
    {"pipe", "free N=3", "omega=10:40:6", NULL, 5, 3, 1, false},
    {"chatter", "N=3", "d=0.022:0.027:4", NULL, 15, 1, 1, true},
    {"pipe", "N=10", "omega=40,42", NULL, 14, 1, 1, true},
    {"fig3", "", "omega=12:20:6", NULL, 15, 5, 3, false},
    {"impact-oscillator", "sides=both", "omega=0.6:2.4:9", "d=0.3,0.6", 15, 1, 1, false},
    {"two-mass", "", "c=0:0.1:5", NULL, 9, 7, 2, true},
    {"vibrating-table", "", "F=0:2:9", NULL, 7, 1, 1, false},
    {"impact-pair", "", "q1=-1.6:1.6:9", NULL, 3, 1, 1, false},
    {"relief-valve", "", "q=8.6,8.2,7.4,6.5,5,3", NULL, 15, 7, 2, false},
    {"flutter", "", "u=6:8.2:6", NULL, 15, 6, 1, true},
};

static saltus_sweep_options divided(const division *d, int lanes, int threads) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = d->keep;
    options.passes = d->passes;
    options.seeds = d->seeds;
    options.seed = 5;
    options.adaptive = !d->fixed;
    options.transient = d->fixed ? 20 : 150;
    options.record = 10;
    options.measure = 500;
    options.longest = 8;
    options.lanes = lanes;
    options.threads = threads;
    return options;
}

static outcome run_division(const division *d, int lanes, int threads, long long step, saltus_sweep **sweep) {
    saltus_scene scene = scene_of(d->scene, d->settings);
    saltus_sweep_options options = divided(d, lanes, threads);
    *sweep = sweep_of(&scene, d->first, d->second, &options);
    saltus_scene_clear(&scene);
    outcome o = open_outcome(*sweep);
    if (step < 0)
        run_part(&o, saltus_sweep_tasks(*sweep) - 1, step);
    else
        for (long long first = 0; first < step; first++)
            run_part(&o, first, step);
    return o;
}

static void bits_do_not_depend_on_the_division(void **unused) {
    (void)unused;
    skip_where_slow();
    /* lanes, threads, stride through the tasks: backwards, in two or three runs as ranks would */
    static const int ways[][3] = {{8, 3, 3}, {4, 1, -1}, {0, 1, 1}, {0, 2, 2}};
    const size_t count = long_version() ? sizeof ways / sizeof ways[0] : 2;
    for (size_t k = 0; k < sizeof divisions / sizeof divisions[0]; k++) {
        saltus_sweep *sweep, *other;
        outcome reference = run_division(&divisions[k], 1, 1, 1, &sweep);
        for (size_t w = 0; w < count; w++) {
            outcome o = run_division(&divisions[k], ways[w][0], ways[w][1], ways[w][2], &other);
            char what[128];
            snprintf(what, sizeof what, "case %zu (%s, %s), lanes %d, threads %d, step %d", k,
                     divisions[k].scene, divisions[k].first, ways[w][0], ways[w][1], ways[w][2]);
            check_same_bits(&reference, &o, what);
            close_outcome(&o);
            saltus_sweep_free(other);
        }
        close_outcome(&reference);
        saltus_sweep_free(sweep);
    }
}

/* A damaged block is refused or read without harm. */
static void damaged_blocks_are_refused(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("impact-oscillator", "");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = 7;
    options.seeds = 2;
    single s = run_single(&scene, "omega", 1.3, &options);
    size_t size = s.outcome.size[0];
    unsigned char *copy = malloc(size);
    saltus_sweep_result result;
    assert_non_null(copy);
    for (size_t cut = 0; cut < size; cut++)
        assert_false(saltus_sweep_unpack(s.sweep, s.outcome.block[0], cut, &result));
    memcpy(copy, s.outcome.block[0], size);
    for (size_t at = 0; at < 6 * sizeof(long long); at++)
        for (int flip = 1; flip < 256; flip *= 2) {
            copy[at] ^= (unsigned char)flip;
            assert_false(saltus_sweep_unpack(s.sweep, copy, size, &result));
            copy[at] ^= (unsigned char)flip;
        }
    assert_true(saltus_sweep_unpack(s.sweep, copy, size, &result));
    free(copy);
    close_single(&s);
}

static double scaled_distance(const saltus_system *system, const double *a, const double *b) {
    const double *scale = saltus_system_scale(system);
    double largest = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        largest = fmax(largest, fabs(a[i] - b[i]) / scale[i]);
    return largest * scale[0];
}

/* Stroboscopic points, impacts and extremes of a row are those of the orbit that Newton's method finds. */
static void check_clouds(const single *s, const saltus_system *system, const saltus_motion *motion,
                         double tolerance) {
    const saltus_sweep_row *row = s->result.rows;
    const double unit =
        saltus_system_scale(system)[saltus_system_dof(system)] / saltus_system_scale(system)[0];
    int shift = 0, n = motion->dimension, impacts = 0;
    double nearest = INFINITY;
    assert_int_equal(s->result.strobe_counts[0], motion->periods);
    for (int k = 0; k < motion->periods; k++) {
        double distance = scaled_distance(system, motion->section_states + k * n, s->result.strobes);
        shift = distance < nearest ? k : shift;
        nearest = fmin(nearest, distance);
    }
    for (int k = 0; k < motion->periods; k++)
        check_near(scaled_distance(system, motion->section_states + (k + shift) % motion->periods * n,
                                   s->result.strobes + k * n),
                   0, tolerance);
    check_near(row->largest, motion->largest, tolerance);
    check_near(row->smallest, motion->smallest, tolerance);
    if (motion->impacts < 0)
        return;
    assert_int_equal(s->result.impact_counts[0], motion->impacts);
    for (int half = 0; half < 2; half++)
        for (int e = 0; e < motion->event_count; e++) {
            const saltus_event *event = &motion->events[e];
            bool later = event->time.cycle >= shift;
            if (event->kind != SALTUS_IMPACT || later == (half == 1))
                continue;
            const saltus_sweep_impact *impact = &s->result.impacts[impacts++];
            check_near(impact->phase, event->time.phase, 1e-8);
            check_near(impact->speed / unit, event->velocity_before / unit, tolerance);
            assert_int_equal(impact->face, event->face);
        }
    assert_int_equal(impacts, motion->impacts);
}

static double random_between(unsigned long *state, double low, double high) {
    *state = (*state * 1103515245UL + 12345UL) & 0x7fffffffUL;
    return low + (high - low) * (double)*state / 0x7fffffff;
}

/* Random points of the pipe: the sweep's class and clouds. */
static void classes_and_clouds_of_random_points(void **unused) {
    (void)unused;
    enum { points = 12 };
    unsigned long random = 20;
    int settled = 0;
    for (int k = 0; k < points; k++) {
        char settings[64];
        saltus_sweep_options options = saltus_sweep_defaults();
        options.keep = 7;
        options.transient = 800;
        snprintf(settings, sizeof settings, "d=%.9g", random_between(&random, 0.02, 0.045));
        saltus_scene scene = scene_of("pipe", settings);
        single s = run_single(&scene, "omega", random_between(&random, 10, 55), &options);
        if (check_label(&s.outcome, 0, 0) && s.result.rows->verdict == SALTUS_PERIODIC) {
            saltus_system *system = system_at(s.sweep, 0);
            saltus_motion motion = motion_from(system, s.result.states, 20);
            settled++;
            check_clouds(&s, system, &motion, 1e-9);
            saltus_motion_clear(&motion);
            saltus_system_free(system);
        }
        close_single(&s);
    }
    assert_true(settled >= 5);
}

/* At a loose tolerance the flow's errors alternate from period to period; this is no longer period. */
static void loose_tolerances_count_right(void **unused) {
    (void)unused;
    static const struct {
        const char *settings;
        double omega;
    } points[] = {{"d=1.03831417 r=0.0381567677 F=0.925788319", 1.18154506},
                  {"d=-0.159727253 r=0.588332784 F=0.67946292", 0.883188435},
                  {"d=1.27423044 r=0.241813366 F=0.612479339", 1.08603446},
                  {"d=0.609494624 r=0.354652039 F=0.989087915", 0.643706111}};
    for (int k = 0; k < 4; k++)
        for (double rtol = 1e-6; rtol > 1e-10; rtol /= 10) {
            saltus_scene scene = scene_of("impact-oscillator", points[k].settings);
            saltus_sweep_options options = saltus_sweep_defaults();
            options.flow.rtol = rtol;
            options.flow.atol = 1e-4 * rtol;
            single s = run_single(&scene, "omega", points[k].omega, &options);
            check_label(&s.outcome, 0, 0);
            close_single(&s);
        }
}

/* With a loose tolerance an orbit is recognised less strictly: one that chatters and sticks is the same, and
 * settles no later than with a tight one. */
static void loose_tolerances_settle_no_later(void **unused) {
    (void)unused;
    long long before = 0;
    for (double rtol = 1e-3; rtol > 1e-10; rtol /= 100) {
        saltus_scene scene = scene_of("chatter", "");
        saltus_sweep_options options = saltus_sweep_defaults();
        options.flow.rtol = rtol;
        options.flow.atol = 1e-4 * rtol;
        single s = run_single(&scene, "d", 0.025, &options);
        assert_string_equal(s.label, "chatter/2");
        assert_true(s.result.rows->settled >= before);
        before = s.result.rows->settled;
        close_single(&s);
    }
}

/* With the exponent, measured over at most a number of periods. */
static saltus_sweep_options measured(long long periods) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = SALTUS_KEEP_LYAPUNOV;
    options.measure = periods;
    options.lifetime = options.measure / 24;
    return options;
}

/* The exponent of a settled row is that of the orbit that classification finds from there. */
static void check_exponent(const single *s, double tolerance) {
    const saltus_sweep_row *row = s->result.rows;
    saltus_system *system = system_at(s->sweep, 0);
    saltus_motion motion = motion_from(system, s->result.states, 20);
    assert_string_equal(s->label, motion.label);
    if (isinf(motion.lyapunov))
        assert_true(row->lyapunov == -INFINITY);
    else
        check_near(row->lyapunov, motion.lyapunov, tolerance);
    assert_true(row->lyapunov_error == 0);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

static void exponents_of_what_has_settled(void **unused) {
    (void)unused;
    skip_where_slow();
    enum { points = 10 };
    static const struct {
        const char *scene, *settings, *key;
        double value;
        const char *label;
    } cases[] = {{"chatter", "", "d", 0.025, "chatter/2"},
                 {"vibrating-table", "r=0.3 F=1.4", "F", 1.4, "chatter/1"},
                 {"pipe", "sigma=0 N=1", "d", 0.02, "held"},
                 {"pipe", "sigma=0 N=1", "d", 0.05, "equilibrium"},
                 {"bouncing-ball", "", "r", 0.5, "held"},
                 {"impact-oscillator", "", "omega", 1.3, "1/1"},
                 {"pipe", "free N=3 omega=20", "omega", 20, "0/2"}};
    const saltus_sweep_options options = measured(0);
    unsigned long random = 20;
    int settled = 0;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_scene scene = scene_of(cases[k].scene, cases[k].settings);
        single s = run_single(&scene, cases[k].key, cases[k].value, &options);
        assert_string_equal(s.label, cases[k].label);
        check_exponent(&s, 1e-6);
        close_single(&s);
    }
    for (int k = 0; k < points; k++) {
        char settings[64];
        snprintf(settings, sizeof settings, "d=%.9g", random_between(&random, 0.02, 0.045));
        saltus_scene scene = scene_of("pipe", settings);
        single s = run_single(&scene, "omega", random_between(&random, 10, 55), &options);
        if (saltus_verdict_settled(s.result.rows->verdict)) {
            check_exponent(&s, 1e-6);
            settled++;
        } else
            assert_true(s.result.rows->verdict == SALTUS_IRREGULAR && isnan(s.result.rows->lyapunov));
        close_single(&s);
    }
    assert_true(settled >= 4);
}

/* The pipe's chaos at omega = 10, d = 0.035, with the exponent 0.756 +- 0.01 by an independent computation
 * and 0.7482 +- 0.0015 over 332,800 periods: the exponents of 20 trajectories scatter by their standard
 * errors. */
static void chaos_and_its_exponent(void **unused) {
    (void)unused;
    skip_where_slow();
    enum { seeds = 20 };
    saltus_scene scene = scene_of("pipe", "d=0.035");
    saltus_sweep_options options = measured(8000);
    double mean = 0, squares = 0, scatter = 0;
    options.seeds = seeds;
    single s = run_single(&scene, "omega", 10, &options);
    for (int k = 0; k < seeds; k++) {
        const saltus_sweep_row *row = &s.result.rows[k];
        assert_int_equal(row->verdict, SALTUS_CHAOTIC);
        assert_int_equal(row->attractor, 0);
        assert_true(fabs(row->lyapunov - 0.7482) < 3.5 * row->lyapunov_error);
        assert_true(row->lyapunov > 3 * row->lyapunov_error && row->lyapunov_error < 0.1);
        mean += row->lyapunov / seeds;
        squares += row->lyapunov_error * row->lyapunov_error;
    }
    for (int k = 0; k < seeds; k++)
        scatter += pow((s.result.rows[k].lyapunov - mean) / s.result.rows[k].lyapunov_error, 2);
    check_near(mean, 0.756, 0.01 + 3 * sqrt(squares) / seeds);
    assert_true(scatter > 6 && scatter < 44); /* chi-square of 19 degrees of freedom: 0.1 to 99.9 % */
    close_single(&s);
}

/* Each step of the flow adds an error of its tolerance to an exponent. Without any other, as in an undamped
 * linear motion, the standard error is that of the steps of a flow that stops at turning points and once in
 * each cycle, for any number of earlier disturbances. */
static void steps_leave_their_error(void **unused) {
    (void)unused;
    static const double omegas[] = {1, 0.5};
    for (int k = 0; k < 8; k++) {
        double omega = omegas[k / 4], rtol = k & 1 ? 1e-10 : 1e-7, state[2] = {1, 0};
        enum { periods = 100 };
        saltus_scene scene = scene_of("impact-oscillator", "c=0 d=30 F=0 q1=1");
        saltus_sweep_options options = measured(1000);
        options.adaptive = k & 2;
        options.transient = 100;
        options.record = 50;
        options.flow.rtol = rtol;
        options.flow.atol = 1e-4 * rtol;
        single s = run_single(&scene, "omega", omega, &options);
        saltus_spec_set_omega(&scene.spec, 1); /* a cycle is a period */
        saltus_system *system = build(&scene.spec);
        saltus_flow *flow = open_flow(system, &options.flow, 0, state);
        for (int p = 1; p <= periods; p++)
            while (advance(flow, p, SALTUS_WATCH_TURNING).kind != SALTUS_REACHED)
                ;
        double steps = (double)saltus_flow_information(flow, 0).steps / periods,
               error = steps * rtol / saltus_system_period(system);
        assert_string_equal(s.label, "undecided");
        check_near(s.result.rows->lyapunov, 0, error);
        check_near(s.result.rows->lyapunov_error, error, 0.1 * error);
        saltus_flow_free(flow);
        saltus_system_free(system);
        close_single(&s);
    }
}

static void check_verdict(const char *name, const char *settings, const char *key, double value,
                          const char *label, double exponent, double errors) {
    saltus_scene scene = scene_of(name, settings);
    const saltus_sweep_options options = measured(8000);
    single s = run_single(&scene, key, value, &options);
    const saltus_sweep_row *row = s.result.rows;
    if (strcmp(s.label, label) != 0)
        fail_msg("%s %s %s=%g: %s instead of %s", name, settings, key, value, s.label, label);
    if (fabs(row->lyapunov - exponent) > errors * row->lyapunov_error + 1e-9)
        fail_msg("%s: exponent %g +- %g instead of %g", label, row->lyapunov, row->lyapunov_error, exponent);
    close_single(&s);
}

/* Exponents of long periods from their multipliers: saltus classify with a longest period of 64 and more. */
static void verdicts_without_a_period(void **unused) {
    (void)unused;
    check_verdict("impact-oscillator", "c=0 d=30 q1=1", "omega", 1.7320508, "quasi-periodic", 0, 5);
    check_verdict("impact-oscillator", "c=0 d=30 F0=0.3 q1=0.4", "omega", 0.61803, "quasi-periodic", 0, 5);
    check_verdict("pipe", "d=0.030875", "omega", 53.305084745762713, "quasi-periodic", 0, 5);
    /* Two free oscillations and the forcing: section points fill a surface, not a curve. */
    check_verdict("two-mass", "free c=0 c2=0 q1=0.4 q2=-0.3", "omega", 1.7133, "undecided", 0, 5);
    check_verdict("pipe", "d=0.035", "omega", 50.035535535, "long-period", -0.425140947, 5);
    check_verdict("pipe", "d=0.035", "omega", 50.744744745, "long-period", -0.7023903178, 5);
    check_verdict("pipe", "d=0.035", "omega", 53.254254254, "long-period", -0.3887199749, 5);
}

/* Additional requests change nothing else: all but a row's verdict and exponent. */
static void exponents_leave_the_rest_alone(void **unused) {
    (void)unused;
    skip_where_slow();
    static const struct {
        const char *settings;
        double omega;
        bool fixed;
    } cases[] = {
        {"d=0.035", 10, false}, {"d=0.035", 10, true}, {"d=0.035", 42, false}, {"d=0.035", 42, true}};
    for (int k = 0; k < 4; k++) {
        saltus_scene scene = scene_of("pipe", cases[k].settings);
        saltus_sweep_options with = measured(1000);
        with.keep |= SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC;
        with.adaptive = !cases[k].fixed;
        with.transient = cases[k].fixed ? 200 : 500;
        saltus_sweep_options without = with;
        without.keep &= ~(unsigned)SALTUS_KEEP_LYAPUNOV;
        single a = run_single(&scene, "omega", cases[k].omega, &with),
               b = run_single(&scene, "omega", cases[k].omega, &without);
        const saltus_sweep_row *x = a.result.rows, *y = b.result.rows;
        assert_true(x->impacts == y->impacts && x->periods == y->periods && x->recorded == y->recorded &&
                    x->largest == y->largest && x->smallest == y->smallest &&
                    x->impact_rate == y->impact_rate && x->largest_speed == y->largest_speed &&
                    x->contact_fraction == y->contact_fraction);
        assert_true(a.result.turning_counts[0] == b.result.turning_counts[0] &&
                    a.result.strobe_counts[0] == b.result.strobe_counts[0]);
        assert_memory_equal(a.result.strobes, b.result.strobes,
                            (size_t)a.result.strobe_counts[0] * 10 * sizeof(double));
        assert_true(isnan(y->lyapunov) && isnan(y->lyapunov_error) && isfinite(x->lyapunov));
        assert_int_equal(y->verdict, k < 2 ? SALTUS_IRREGULAR : SALTUS_PERIODIC);
        assert_int_equal(x->verdict, k < 2 ? SALTUS_CHAOTIC : SALTUS_PERIODIC);
        close_single(&a);
        close_single(&b);
    }
}

/* The verdicts agree with the more thorough ones of classification, in a region of much chaos. */
static void verdicts_are_those_of_classification(void **unused) {
    (void)unused;
    skip_where_slow();
    static const double points[][2] = {{3.04396, 0.0160301},  {3.10979, 0.012242},  {3.17298, 0.00623677},
                                       {3.00617, 0.0107657},  {3.07625, 0.019749},  {3.23848, 0.00395883},
                                       {2.98076, 0.0151182},  {3.00445, 0.0106066}, {3.03221, 0.00435469},
                                       {3.24867, 0.000491112}};
    const saltus_sweep_options options = measured(8000);
    int chaotic = 0;
    for (size_t k = 0; k < sizeof points / sizeof points[0]; k++) {
        char settings[96];
        saltus_message message = {.text = ""};
        saltus_classify_options how = saltus_classify_defaults();
        saltus_motion motion;
        snprintf(settings, sizeof settings, "c=0.02 r=0.8 d=%.9g", points[k][1]);
        saltus_scene scene = scene_of("impact-oscillator", settings);
        single s = run_single(&scene, "omega", points[k][0], &options);
        saltus_system *system = system_at(s.sweep, 0);
        how.measure = 64000;
        check_ok(saltus_classify(system, s.result.states, &how, &motion, &message), &message);
        /* Classification follows eight times as many trajectories: one may leave that the row's does not. */
        bool sees_more = motion.verdict == SALTUS_TRANSIENT;
        if (strcmp(s.label, motion.label) != 0 && !sees_more)
            fail_msg("%s omega=%g: %s, classification says %s", settings, points[k][0], s.label,
                     motion.label);
        if (motion.verdict == SALTUS_CHAOTIC) {
            double errors = hypot(s.result.rows->lyapunov_error, motion.lyapunov_error);
            check_near(s.result.rows->lyapunov, motion.lyapunov, 4 * errors);
        }
        chaotic += s.result.rows->verdict == SALTUS_CHAOTIC || s.result.rows->verdict == SALTUS_TRANSIENT;
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        close_single(&s);
    }
    assert_int_equal(chaotic, 5);
}

/* A fixed run gives the classes of an adaptive one and the measures of its orbits, and records exactly the
 * requested periods, to which the measures of other motions belong. */
static void fixed_runs(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("pipe", "d=0.035");
    saltus_sweep_options fixed = saltus_sweep_defaults(), adaptive = saltus_sweep_defaults();
    fixed.keep = 7;
    fixed.adaptive = false;
    fixed.transient = 300;
    fixed.record = 56;
    static const double omegas[] = {16, 42, 45, 51};
    int orbits = 0;
    for (int k = 0; k < 4; k++) {
        single a = run_single(&scene, "omega", omegas[k], &adaptive);
        single f = run_single(&scene, "omega", omegas[k], &fixed);
        const saltus_sweep_row *row = f.result.rows;
        assert_string_equal(a.label, f.label);
        assert_int_equal(row->recorded, 56);
        assert_int_equal(f.result.strobe_counts[0], 56);
        check_near((double)f.result.impact_counts[0], row->impact_rate * 56, 1e-9);
        if (row->verdict == SALTUS_PERIODIC && 56 % row->periods == 0)
            check_near(row->impact_rate * row->periods, row->impacts, 1e-9);
        double largest = -INFINITY, smallest = INFINITY, speed = 0;
        for (long long i = 0; i < f.result.turning_counts[0]; i++) {
            largest = fmax(largest, f.result.turning[i]);
            smallest = fmin(smallest, f.result.turning[i]);
        }
        for (long long i = 0; i < f.result.impact_counts[0]; i++)
            speed = fmax(speed, fabs(f.result.impacts[i].speed));
        const bool orbit = row->verdict == SALTUS_PERIODIC;
        const double near = orbit ? 1e-9 : 0;
        check_near(row->largest, largest, near);
        check_near(row->smallest, smallest, near);
        check_near(row->largest_speed, speed, near);
        const saltus_sweep_row *other = orbit ? a.result.rows : row;
        check_near(row->largest, other->largest, near);
        check_near(row->smallest, other->smallest, near);
        check_near(row->largest_speed, other->largest_speed, near);
        check_near(row->rms, other->rms, near);
        check_near(row->contact_fraction, other->contact_fraction, near);
        orbits += orbit;
        close_single(&a);
        close_single(&f);
    }
    assert_int_equal(orbits, 3);
}

/* Measures of the sticking reference orbit: contact from stick to release, speeds, extremes sampled densely.
 */
static void measures_of_a_sticking_orbit(void **unused) {
    (void)unused;
    enum { samples = 2000 };
    saltus_scene scene = scene_of("chatter", "");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = 7;
    single s = run_single(&scene, "d", 0.025, &options);
    const saltus_sweep_row *row = s.result.rows;
    assert_string_equal(s.label, "chatter/2");
    assert_int_equal(row->sticking, 1);
    saltus_system *system = system_at(s.sweep, 0);
    saltus_motion motion = motion_from(system, s.result.states, 20);
    double contact = 0, speed = 0, smallest = INFINITY, largest = -INFINITY, state[dimension_max];
    for (int e = 0; e < motion.event_count; e++) {
        double at = saltus_time_periods(motion.events[e].time);
        contact += motion.events[e].kind == SALTUS_RELEASE ? at : 0;
        contact -= motion.events[e].kind == SALTUS_STICK ? at : 0;
        speed = fmax(speed, fabs(motion.events[e].velocity_before));
    }
    check_near(row->contact_fraction, (contact < 0 ? contact + 2 : contact) / 2, 1e-8);
    check_near(row->largest_speed, speed, 1e-8);
    saltus_flow_options flow_options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &flow_options, 0, motion.state);
    for (int k = 1; k <= 2 * samples; k++) {
        advance(flow, (double)k / samples, 0);
        saltus_flow_state(flow, 0, state);
        double gap = saltus_system_gap(system, 0, state) + 0.025;
        smallest = fmin(smallest, gap);
        largest = fmax(largest, gap);
    }
    check_near(row->largest, largest, 1e-12);
    assert_true(row->smallest <= smallest + 1e-12 && row->smallest > smallest - 1e-6);
    saltus_flow_free(flow);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    close_single(&s);
}

/* Two masses, the first observed by a stop out of reach: at their collisions its velocity reverses without a
 * zero, and has its extreme. */
static void extremes_where_another_stop_is_hit(void **unused) {
    (void)unused;
    enum { samples = 1000 };
    saltus_scene scene = scene_of("two-mass", "");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = SALTUS_KEEP_TURNING;
    scene.spec.stops[1] = scene.spec.stops[0];
    scene.spec.stops[0].weight[1] = 0;
    scene.spec.stops[0].d = 10;
    scene.spec.stop_count = 2;
    single s = run_single(&scene, "omega", 1.68, &options);
    assert_string_equal(s.label, "1/1");
    saltus_system *system = system_at(s.sweep, 0);
    saltus_flow *flow = open_flow(system, &options.flow, 0, s.result.states);
    double state[4], largest = -INFINITY;
    for (int k = 1; k <= samples; k++) {
        double until = (double)k / samples;
        while (advance(flow, until, SALTUS_WATCH_IMPACT).kind == SALTUS_IMPACT) {
            saltus_flow_state(flow, 0, state);
            largest = fmax(largest, state[0]);
        }
    }
    assert_true(largest > 0.15);
    check_near(s.result.rows->largest, largest, 1e-9);
    assert_int_equal(s.result.turning_counts[0] % 2, 0);
    saltus_flow_free(flow);
    saltus_system_free(system);
    close_single(&s);
}

/* The stable 4/4 orbit of omega = 42, d = 0.035, followed by Newton's method to another omega, as initial
 * state. */
static saltus_scene on_the_branch(double omega) {
    enum { steps = 16 };
    saltus_message message = {.text = ""};
    saltus_scene scene = scene_of("pipe", "d=0.035 omega=42");
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_system *system = build(&scene.spec);
    saltus_orbit orbit = {0};
    double state[10];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    saltus_motion motion = motion_from(system, state, 20);
    saltus_system_free(system);
    assert_string_equal(motion.label, "4/4");
    memcpy(state, motion.state, sizeof state);
    saltus_motion_clear(&motion);
    for (int k = 1; k <= steps; k++) {
        set_parameter(&scene.spec, "omega", k == steps ? omega : 42 + (omega - 42) * k / steps);
        system = build(&scene.spec);
        check_ok(saltus_orbit_find(system, 4, state, &shooting, &orbit, &message), &message);
        memcpy(state, orbit.state, sizeof state);
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
    scene.initial_count = 10;
    memcpy(scene.initial, state, sizeof state);
    return scene;
}

/* Start on the orbit near its period doubling at omega = 41.110599407465 (subcritical): 4/4 or irregular
 * above it, for any disturbance; below it neither 4/4 nor 8/8 is stable. */
static void orbits_around_a_period_doubling(void **unused) {
    (void)unused;
    static const double offsets[] = {0.001, 1e-4, 1e-5, 1e-7, -1e-7, -1e-5, -1e-3};
    for (size_t k = 0; k < sizeof offsets / sizeof offsets[0]; k++) {
        double omega = 41.110599407465 + offsets[k];
        saltus_scene scene = on_the_branch(omega);
        saltus_sweep_options options = saltus_sweep_defaults();
        options.transient = 1000;
        for (unsigned long seed = 1; seed <= (long_version() ? 4 : 1); seed++) {
            options.seed = seed;
            single s = run_single(&scene, "omega", omega, &options);
            bool irregular = strcmp(s.label, "irregular") == 0;
            if (!(irregular || strcmp(s.label, offsets[k] > 0 ? "4/4" : "7/8") == 0))
                fail_msg("%s at %g from the period doubling, seed %lu", s.label, offsets[k], seed);
            close_single(&s);
        }
    }
}

/* The unstable straight pipe is left, even if exact. */
static void unstable_rest_is_left(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("pipe", "N=3 q1=0");
    saltus_sweep_options options = saltus_sweep_defaults();
    assert_int_equal(scene.initial_count, 6);
    static const double omegas[] = {42, 45};
    for (int k = 0; k < 2; k++) {
        single s = run_single(&scene, "omega", omegas[k], &options);
        assert_true(s.result.rows->largest > 0.01);
        check_label(&s.outcome, 0, 0);
        close_single(&s);
    }
    scene = scene_of("pipe", "N=1 sigma=0 q1=0 free");
    single s = run_single(&scene, "omega", 42, &options);
    assert_string_equal(s.label, "equilibrium");
    check_near(fabs(s.result.states[0]), sqrt(2 * (4.5 * 4.5 - M_PI * M_PI) / (5000 * M_PI * M_PI)), 1e-9);
    close_single(&s);
}

/* An undamped oscillator at the resonance 2:1 has a continuum of orbits: none is stable, no class. */
static void a_continuum_is_no_attractor(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("impact-oscillator", "c=0 F=0.1 d=5");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.transient = 500;
    single s = run_single(&scene, "omega", 0.5, &options);
    assert_string_equal(s.label, "irregular");
    close_single(&s);
}

/* 4/5 and 7/10 coexist between d = 0.02954 and 0.02994 at omega = 43: each sweep direction stays on its
 * own. */
static void hysteresis(void **unused) {
    (void)unused;
    enum { count = 6 };
    saltus_scene scene = scene_of("pipe", "omega=43");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.passes = 1u << SALTUS_PASS_UP | 1u << SALTUS_PASS_DOWN;
    saltus_sweep *sweep = sweep_of(&scene, "d=0.02953:0.02958:6", NULL, &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    int differ = 0;
    for (int k = 0; k < count; k++) {
        char up[32], down[32];
        check_label(&o, k, 0);
        check_label(&o, count + k, 0);
        saltus_sweep_label(result_at(&o, k).rows, up);
        saltus_sweep_label(result_at(&o, count + k).rows, down);
        differ += strcmp(up, down) != 0;
    }
    assert_true(differ >= 1);
    close_outcome(&o);
    saltus_sweep_free(sweep);
}

/* A state carried to clearances below it; the axis may decrease; one point is also a line. */
static void carried_beyond_the_stop(void **unused) {
    (void)unused;
    static const char *const axes[] = {"d=0.04:-0.01:11", "d=-0.01:0.04:11", "d=0.02"};
    for (int a = 0; a < 3; a++) {
        saltus_scene scene = scene_of("pipe", "N=2 omega=20");
        saltus_sweep_options options = saltus_sweep_defaults();
        options.passes = 7;
        options.transient = 300;
        saltus_sweep *sweep = sweep_of(&scene, axes[a], NULL, &options);
        outcome o = open_outcome(sweep);
        assert_int_equal(saltus_sweep_tasks(sweep), saltus_sweep_points(sweep) + 2);
        run_part(&o, 0, 1);
        for (long long place = 0; place < o.places; place++) {
            assert_true(result_at(&o, place).rows->verdict != SALTUS_FAILED);
            check_label(&o, place, 0);
        }
        close_outcome(&o);
        saltus_sweep_free(sweep);
    }
}

/* A mirror pair is two attractors; each seed's class is that of classification. */
static void seeds_count_attractors(void **unused) {
    (void)unused;
    enum { seeds = 8 };
    saltus_scene scene = scene_of("fig3", "");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.seeds = seeds;
    saltus_sweep *sweep = sweep_of(&scene, "omega=14", NULL, &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    saltus_sweep_result result = result_at(&o, 0);
    int most = 0;
    assert_int_equal(result.rows[0].attractor, 0);
    for (int s = 0; s < seeds; s++) {
        assert_true(check_label(&o, 0, s));
        assert_true(result.rows[s].attractor <= most + 1);
        most = result.rows[s].attractor > most ? result.rows[s].attractor : most;
    }
    assert_int_equal(most, 1);
    close_outcome(&o);
    saltus_sweep_free(sweep);
}

static void check_case(const char *name, const char *settings, const char *key, double value,
                       const char *label) {
    saltus_scene scene = scene_of(name, settings);
    saltus_sweep_options options = saltus_sweep_defaults();
    single s = run_single(&scene, key, value, &options);
    if (strcmp(s.label, label) != 0)
        fail_msg("%s %s %s=%g: %s instead of %s", name, settings, key, value, s.label, label);
    assert_true(check_label(&s.outcome, 0, 0));
    if (strcmp(label, "held") == 0) {
        check_near(s.result.rows->contact_fraction, 1, 0);
        check_near(s.result.rows->largest, s.result.rows->smallest, 1e-15);
        assert_true(s.result.rows->impact_rate == 0);
    }
    close_single(&s);
}

static void rest_and_contact_for_good(void **unused) {
    (void)unused;
    check_case("pipe", "sigma=0.01 r=0.5", "d", 0.01, "held");
    check_case("pipe", "sigma=0.01 r=0", "d", 0.005, "held");
    check_case("pipe", "sigma=0 N=1", "d", 0.02, "held");
    check_case("pipe", "sigma=0 N=1", "d", 0.05, "equilibrium");
    check_case("pipe", "sigma=0 N=3 u0=2.5", "d", 0.03, "equilibrium");
    check_case("pipe", "N=1 omega=10 xi=0.3", "d", 0.005, "held");
    check_case("bouncing-ball", "", "r", 0.5, "held");
    check_case("vibrating-table", "r=0.5", "F", 0.7, "held");
}

/* A table that throws its ball at phase 1/2 holds it at phase 0: the sticking interval contains the section.
 * Shifted by half a period it is the same motion. */
static void sticking_across_the_section(void **unused) {
    (void)unused;
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = 7;
    saltus_scene scene = scene_of("vibrating-table", "r=0.3 F=1.4");
    single plain = run_single(&scene, "F", 1.4, &options), shifted = run_single(&scene, "F", -1.4, &options);
    assert_string_equal(plain.label, "chatter/1");
    assert_string_equal(shifted.label, "chatter/1");
    assert_int_equal(shifted.result.rows->sticking, 1);
    check_near(shifted.result.rows->contact_fraction, plain.result.rows->contact_fraction, 1e-9);
    check_near(shifted.result.rows->largest, plain.result.rows->largest, 1e-9);
    close_single(&plain);
    close_single(&shifted);
}

/* The ball leaves when the table's acceleration is that of gravity, cos(2 pi phase) = 1 / F, though nothing
 * moves before; it never falls through the table. */
static void release_from_rest(void **unused) {
    (void)unused;
    enum { count = 8 };
    saltus_scene scene = scene_of("vibrating-table", "r=0.4");
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep *sweep = sweep_of(&scene, "F=1.001:1.15:8", NULL, &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    for (int k = 0; k < count; k++) {
        saltus_sweep_result result = result_at(&o, k);
        double leaves = 1 - acos(1 / saltus_axis_value(saltus_sweep_axis(sweep, 0), k)) / (2 * M_PI);
        assert_true(result.rows->smallest >= -1e-15);
        assert_true(check_label(&o, k, 0));
        saltus_system *system = system_at(sweep, k);
        double rest[2] = {0, 0};
        saltus_flow *flow = open_flow(system, &options.flow, 0.5, rest);
        saltus_event event = advance(flow, 1, SALTUS_WATCH_RELEASE);
        assert_int_equal(event.kind, SALTUS_RELEASE);
        check_near(saltus_time_periods(event.time), leaves, 1e-7);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
    close_outcome(&o);
    saltus_sweep_free(sweep);
}

/* Starts beyond the stop have a verdict of their own and leave the others alone. */
static void failed_starts(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("impact-oscillator", "omega=1.3");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = 15;
    saltus_sweep *sweep = sweep_of(&scene, "q1=-2:2:9", NULL, &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    for (int k = 0; k < 9; k++) {
        saltus_sweep_result result = result_at(&o, k);
        bool beyond = saltus_axis_value(saltus_sweep_axis(sweep, 0), k) > 1;
        assert_true((result.rows->verdict == SALTUS_BEYOND) == beyond);
        assert_true(saltus_verdict_nothing((saltus_verdict)result.rows->verdict) == beyond);
        if (beyond) {
            assert_int_equal(result.rows->attractor, -1);
            assert_true(isnan(result.rows->largest) && isnan(result.rows->lyapunov));
            assert_int_equal(result.strobe_counts[0], 0);
        } else
            assert_true(check_label(&o, k, 0));
    }
    close_outcome(&o);
    saltus_sweep_free(sweep);
}

/* A motion that grows without bound fails within one period, for any request; what was recorded by then is
 * kept, the rest is unknown. */
static void what_was_recorded_before_a_failure_stays(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("pipe", "kappa=0 N=2 omega=5 d=100");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = 7;
    single first = run_single(&scene, "u0", 3.2, &options);
    long long end = first.result.rows->settled;
    assert_int_equal(first.result.rows->verdict, SALTUS_FAILED);
    assert_true(end > 4 && end < 20);
    options.adaptive = false;
    for (int transient = 0; transient <= 2; transient += 2)
        for (int record = 1; record <= end + 1; record++) {
            options.transient = transient;
            options.record = record;
            single s = run_single(&scene, "u0", 3.2, &options);
            const saltus_sweep_row *row = s.result.rows;
            bool recorded = transient + record < end;
            assert_string_equal(s.label, "failed");
            assert_int_equal(row->settled, end);
            assert_true(row->attractor == -1 && row->periods == 0);
            assert_int_equal(row->recorded, recorded ? record : 0);
            assert_true(isfinite(row->largest) == recorded && isfinite(row->smallest) == recorded);
            assert_true(isfinite(row->impact_rate) == recorded && isfinite(row->largest_speed) == recorded);
            assert_true(isfinite(row->contact_fraction) == recorded && isnan(row->lyapunov));
            assert_true(!recorded || s.result.strobe_counts[0] == record);
            for (int i = 0; i < 4; i++)
                assert_true(isfinite(s.result.states[i]) == recorded);
            close_single(&s);
        }
    close_single(&first);
}

/* Motions that grow without bound fail; others in the same flow have the bits that they have alone. */
static void unbounded_growth_disturbs_nobody(void **unused) {
    (void)unused;
    static const division growing[] = {
        {"pipe", "kappa=0 N=2 omega=0.5 d=1", "u0=0.5,30,1,25,2,40,1.5,3,60,0.8", NULL, 7, 1, 1, false},
        {"pipe", "kappa=0 N=3 d=0.02", "u0=0.5:9:12", NULL, 15, 1, 2, true},
        {"impact-oscillator", "F0=2 r=1 c=0", "omega=0.8:3:12", NULL, 7, 1, 1, false},
    };
    for (int k = 0; k < 3; k++) {
        saltus_sweep *sweep, *other;
        outcome one = run_division(&growing[k], 1, 1, 1, &sweep);
        outcome all = run_division(&growing[k], 0, 2, 1, &other);
        int verdicts[SALTUS_VERDICTS] = {0};
        check_same_bits(&one, &all, growing[k].first);
        for (long long place = 0; place < one.places; place++)
            verdicts[result_at(&one, place).rows->verdict]++;
        assert_int_equal(verdicts[SALTUS_PENDING], 0);
        assert_true(k == 2 || verdicts[SALTUS_FAILED] > 0);
        assert_true(verdicts[SALTUS_FAILED] < one.places);
        close_outcome(&one);
        close_outcome(&all);
        saltus_sweep_free(sweep);
        saltus_sweep_free(other);
    }
}

/* A flow that has overflowed works again after a new start: it sees the stop and gives the states of another
 * flow. */
static void a_flow_recovers_from_overflow(void **unused) {
    (void)unused;
    saltus_scene growing = scene_of("pipe", "kappa=0 N=2 omega=0.5 d=1 u0=25");
    saltus_scene usual = scene_of("pipe", "N=2 omega=20 d=0.02");
    saltus_system *system = build(&usual.spec), *unbounded = build(&growing.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    double start[4], fresh[4], reused[4];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, 30, 0);
    saltus_flow_state(flow, 0, fresh);
    long long impacts = saltus_flow_information(flow, 0).impacts;
    saltus_flow_free(flow);
    flow = open_flow(unbounded, &options, 0, start);
    for (int k = 1; k < 6; k++)
        (void)saltus_flow_advance(flow, (saltus_time){k, 0}, 0, &event, &message);
    check_ok(saltus_flow_retune(flow, 0, system, &message), &message);
    check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message), &message);
    advance(flow, 30, 0);
    saltus_flow_state(flow, 0, reused);
    assert_int_equal(saltus_flow_information(flow, 0).impacts, impacts);
    assert_memory_equal(fresh, reused, sizeof fresh);
    saltus_flow_free(flow);
    saltus_system_free(system);
    saltus_system_free(unbounded);
}

/* A line goes on from a valid state after a motion that grew without bound. */
static void a_line_goes_on_after_a_failure(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("chatter", "N=2");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.passes = 1u << SALTUS_PASS_UP;
    options.transient = 100;
    saltus_sweep *sweep = sweep_of(&scene, "kappa=0,5000,4000", NULL, &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    assert_int_equal(result_at(&o, 0).rows->verdict, SALTUS_FAILED);
    for (int k = 1; k < 3; k++) {
        assert_true(result_at(&o, k).rows->verdict != SALTUS_FAILED);
        check_near(result_at(&o, k).rows->largest, 0.025, 1e-12);
    }
    close_outcome(&o);
    saltus_sweep_free(sweep);
}

static saltus_status take_three(void *context, const saltus_sweep_result *result, saltus_message *message) {
    outcome *o = context;
    saltus_status status = keep_result(context, result, message);
    int taken = 0;
    for (long long k = 0; k < o->places; k++)
        taken += o->block[k] != NULL;
    return status == SALTUS_OK && taken == 3 ? saltus_fail(message, SALTUS_IO, "three are enough") : status;
}

static void an_error_of_the_taker_ends_the_run(void **unused) {
    (void)unused;
    for (int threads = 1; threads <= 3; threads += 2) {
        saltus_scene scene = scene_of("impact-oscillator", "");
        saltus_sweep_options options = saltus_sweep_defaults();
        saltus_message message = {.text = ""};
        options.seeds = 2;
        options.passes = 3;
        options.keep = 7;
        options.threads = threads;
        saltus_sweep *sweep = sweep_of(&scene, "omega=1.1:1.6:30", NULL, &options);
        outcome o = open_outcome(sweep);
        saltus_sweep_feed feed = {.context = &o, .next = next_task, .take = take_three};
        o.step = 1;
        o.tasks = saltus_sweep_tasks(sweep);
        assert_int_equal(saltus_sweep_run(sweep, &feed, &message), SALTUS_IO);
        assert_string_equal(message.text, "three are enough");
        int taken = 0;
        for (long long k = 0; k < o.places; k++)
            taken += o.block[k] != NULL;
        assert_int_equal(taken, 3);
        close_outcome(&o);
        saltus_sweep_free(sweep);
    }
}

/* Rows into an array. */
typedef struct row_keeper {
    const saltus_sweep *sweep;
    saltus_sweep_row *rows;
} row_keeper;

static saltus_status keep_rows(void *context, const saltus_sweep_result *result, saltus_message *message) {
    row_keeper *k = context;
    int seeds = saltus_sweep_choices(k->sweep)->seeds;
    (void)message;
    memcpy(k->rows + result->place * seeds, result->rows, (size_t)seeds * sizeof *k->rows);
    return SALTUS_OK;
}

/* A small sweep without checks. Of its 12 rows those that it did not reach are zero. */
static saltus_status small_sweep(saltus_sweep_row *rows) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    saltus_axis axis;
    saltus_sweep *sweep = NULL;
    double *list = NULL;
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = 15;
    options.seeds = 2;
    options.passes = 3;
    options.threads = 1;
    options.transient = 12;
    options.measure = 60;
    memset(rows, 0, 12 * sizeof *rows);
    saltus_status status = saltus_scene_load("vibrating-table", &scene, &message);
    if (status == SALTUS_OK)
        status = saltus_axis_read("F=0,0.5,1.3", &axis, &list, &message);
    if (status == SALTUS_OK)
        status = saltus_sweep_new(&scene, &axis, 1, &options, &sweep, &message);
    if (status == SALTUS_OK) {
        row_keeper keeper = {.sweep = sweep, .rows = rows};
        saltus_sweep_feed feed = {.context = &keeper, .take = keep_rows};
        status = saltus_sweep_run(sweep, &feed, &message);
    }
    saltus_sweep_free(sweep);
    free(list);
    return status;
}

/* The k-th allocation fails, for all k: an error, or nothing lost. */
static void failing_allocations(void **unused) {
    (void)unused;
    saltus_sweep_row expected[12], rows[12];
    int refused = 0;
    assert_int_equal(small_sweep(expected), SALTUS_OK);
    for (long k = 1;; k += long_version() ? 1 : getenv("SALTUS_SANITIZED") ? 7 : 3) {
        allocations = 0;
        failing = k;
        saltus_status status = small_sweep(rows);
        bool through = allocations < k;
        failing = -1;
        assert_true(status == SALTUS_NO_MEMORY || status == SALTUS_OK);
        for (int r = 0; r < 12 && status == SALTUS_OK; r++)
            if (rows[r].verdict != expected[r].verdict || rows[r].settled != expected[r].settled)
                fail_msg("allocation %ld fails: row %d is lost without an error", k, r);
        if (through)
            break;
        refused += status == SALTUS_NO_MEMORY;
    }
    assert_true(refused > 10);
    if (long_version())
        assert_true(refused > 50);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_have_their_values),
        cmocka_unit_test(bad_axes_are_refused),
        cmocka_unit_test(bad_sweeps_are_refused),
        cmocka_unit_test(bits_do_not_depend_on_the_division),
        cmocka_unit_test(damaged_blocks_are_refused),
        cmocka_unit_test(classes_and_clouds_of_random_points),
        cmocka_unit_test(loose_tolerances_count_right),
        cmocka_unit_test(loose_tolerances_settle_no_later),
        cmocka_unit_test(exponents_of_what_has_settled),
        cmocka_unit_test(chaos_and_its_exponent),
        cmocka_unit_test(steps_leave_their_error),
        cmocka_unit_test(verdicts_without_a_period),
        cmocka_unit_test(exponents_leave_the_rest_alone),
        cmocka_unit_test(verdicts_are_those_of_classification),
        cmocka_unit_test(fixed_runs),
        cmocka_unit_test(measures_of_a_sticking_orbit),
        cmocka_unit_test(extremes_where_another_stop_is_hit),
        cmocka_unit_test(orbits_around_a_period_doubling),
        cmocka_unit_test(unstable_rest_is_left),
        cmocka_unit_test(a_continuum_is_no_attractor),
        cmocka_unit_test(hysteresis),
        cmocka_unit_test(carried_beyond_the_stop),
        cmocka_unit_test(seeds_count_attractors),
        cmocka_unit_test(rest_and_contact_for_good),
        cmocka_unit_test(sticking_across_the_section),
        cmocka_unit_test(release_from_rest),
        cmocka_unit_test(failed_starts),
        cmocka_unit_test(what_was_recorded_before_a_failure_stays),
        cmocka_unit_test(unbounded_growth_disturbs_nobody),
        cmocka_unit_test(a_flow_recovers_from_overflow),
        cmocka_unit_test(a_line_goes_on_after_a_failure),
        cmocka_unit_test(an_error_of_the_taker_ends_the_run),
        cmocka_unit_test(failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
