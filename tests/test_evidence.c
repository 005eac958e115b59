/* What a verdict or an exponent reports of its run, computed again from the run: impacts counted, section
 * points taken and judged, laminar phases found.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <signal.h>

static saltus_system *struck_oscillator(double c, double omega, double d) {
    saltus_spec spec = oscillator_spec(c, 1, 1, omega);
    add_stop(&spec, d, 0.8, SALTUS_UPPER);
    return build(&spec);
}

/* Two masses, with settings up to a NULL; with `second` the stop limits the second mass alone. */
static saltus_system *two_masses(const char *const *settings, bool second) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load("two-mass", &scene, &message), &message);
    for (int k = 0; settings[k]; k++)
        check_ok(saltus_scene_set(&scene, settings[k], &message), &message);
    if (second) {
        scene.spec.stops[0].weight[0] = 0;
        scene.spec.stops[0].weight[1] = 1;
    }
    return build(&scene.spec);
}

static const char *const torus[] = {"omega=1.7133", "d=-0.1797", "r=0.323", "c=0.07",
                                    "c2=0.07",      "m2=1.57",   "k2=2.51", NULL};
static const char *const leaving[] = {"omega=1.6467", "d=-0.0687", "r=0.871", "c=0.035",
                                      "c2=0.035",     "m2=0.77",   "k2=2.1",  NULL};

static saltus_motion classify(const saltus_system *system, const double *start, long long transient,
                              long long measure) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[4];
    options.transient = transient;
    options.measure = measure;
    options.lifetime = options.measure / 24;
    if (start)
        memcpy(state, start, (size_t)saltus_system_dimension(system) * sizeof *state);
    else
        check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    return motion;
}

static saltus_lyapunov measure(const saltus_system *system, const double *state,
                               const saltus_lyapunov_options *options) {
    saltus_message message = {.text = ""};
    saltus_lyapunov l;
    check_ok(saltus_lyapunov_run(system, state, options, &l, &message), &message);
    return l;
}

/* A single undisturbed trajectory is the flow's own: its events after the transient are counted again, and it
 * ends where the flow does. */
static void events_of_a_run_are_recounted(void **unused) {
    (void)unused;
    static const char *const none[] = {NULL};
    saltus_spec chatter = oscillator_spec(0.05, 1, 1, 0.4);
    add_stop(&chatter, 0, 0.5, SALTUS_UPPER);
    saltus_system *systems[] = {struck_oscillator(0.1, 1, 1), struck_oscillator(0.1, 2.6, 0),
                                two_masses(none, false), two_masses(torus, true), build(&chatter)};
    const long long transients[] = {0, 17, 300, 400, 60};
    for (int k = 0; k < 5; k++)
        for (int whole = 1; whole <= 3; whole += 2) {
            saltus_lyapunov_options options = saltus_lyapunov_defaults();
            saltus_message message = {.text = ""};
            saltus_event event;
            double start[4], end[4];
            options.members = 1;
            options.transient = transients[k];
            options.interval = whole;
            options.periods = 600 * whole;
            check_ok(saltus_system_default_state(systems[k], start, &message), &message);
            saltus_lyapunov l = measure(systems[k], start, &options);
            assert_true(l.transient >= options.transient && l.periods <= options.periods);
            assert_int_equal(l.periods % whole, 0);
            check_near(l.time, (double)l.periods * saltus_system_period(systems[k]), 1e-9 * l.time);
            saltus_flow *flow = open_flow(systems[k], &options.flow, 0, start);
            check_ok(saltus_flow_advance(flow, (saltus_time){l.transient, 0}, 0, &event, &message), &message);
            saltus_flow_info before = saltus_flow_information(flow, 0);
            check_ok(
                saltus_flow_advance(flow, (saltus_time){l.transient + l.periods, 0}, 0, &event, &message),
                &message);
            saltus_flow_info after = saltus_flow_information(flow, 0);
            saltus_flow_state(flow, 0, end);
            check_near(l.impacts_per_period * (double)l.periods, (double)(after.impacts - before.impacts),
                       1e-6);
            check_near(l.sticks_per_period * (double)l.periods, (double)(after.sticks - before.sticks), 1e-6);
            assert_true((l.sticks_per_period > 0) == (k == 4) && l.impacts_per_period > 0);
            /* No exponent is more accurate than the flow's steps. */
            if (l.lost == 0)
                assert_true(l.standard_errors[0] >=
                            0.5 * (double)(after.steps - before.steps) * options.flow.rtol / l.time);
            for (int i = 0; i < l.dimension; i++)
                check_near(l.state[i], end[i], 1e-6);
            saltus_flow_free(flow);
            saltus_lyapunov_clear(&l);
        }
    for (int k = 0; k < 5; k++)
        saltus_system_free(systems[k]);
}

/* Several trajectories: the means are joined, and counts are those of all. */
static void members_make_the_whole(void **unused) {
    (void)unused;
    saltus_system *systems[] = {struck_oscillator(0.1, 1, 1), struck_oscillator(0.1, 0.8, 0)};
    static const int members[] = {1, 3, 8, 21};
    double start[2] = {-0.3, 0.1};
    for (int k = 0; k < 2; k++)
        for (int m = 0; m < 4; m++) {
            saltus_lyapunov_options options = saltus_lyapunov_defaults();
            options.members = members[m];
            options.exponents = 0;
            options.transient = 100;
            options.precision = 0.05;
            saltus_lyapunov l = measure(systems[k], start, &options);
            double mean = 0, half = 0.5 * (l.half[0] + l.half[1]);
            assert_true(l.members == members[m] && l.periods % members[m] == 0 && l.agree && l.precise);
            for (int i = 0; i < l.members; i++)
                mean += l.member_exponents[i] / l.members;
            check_near(mean, l.exponents[0], 1e-12);
            check_near(half, l.exponents[0], 3 * l.standard_errors[0] + 1e-12);
            assert_true(l.half_errors[0] > 0 && l.half_errors[1] > 0);
            if (k == 1) {
                /* Half the run: the error is larger by about the square root of two, and independent. */
                double halves = 0.5 * hypot(l.half_errors[0], l.half_errors[1]);
                check_near(halves, l.standard_errors[0], 0.6 * l.standard_errors[0]);
                assert_true(l.independent > 20 && l.independent < 50 * (double)l.periods);
                assert_true(l.standard_errors[0] <= 0.05 * l.exponents[0]);
                for (int i = 1; i < l.members; i++)
                    assert_true(l.member_exponents[i] != l.member_exponents[0]);
            }
            double square = 0;
            for (int i = 0; i < l.members; i++)
                square += (l.member_exponents[i] - mean) * (l.member_exponents[i] - mean);
            /* On an orbit all members measure the same value, so that is no smaller error; if they differ it
             * is by chance. */
            if (k == 0 && l.members > 1)
                assert_true(l.standard_errors[0] >= 0.999 * sqrt(square / (l.members - 1) / l.members));
            check_near(l.impacts_per_period, k ? 2.336 : 1, k ? 0.02 : 0.01);
            check_near(l.sum, -0.1 + l.impacts_per_period / l.period * 2 * log(0.8), 1e-6);
            const saltus_lyapunov_progress *last = &l.history[l.history_count - 1];
            check_near(last->time, l.time, 1e-9 * l.time);
            check_near(last->exponent, l.exponents[0], 1e-12);
            check_near(last->standard_error, l.standard_errors[0], 1e-12);
            saltus_lyapunov_clear(&l);
        }
    for (int k = 0; k < 2; k++)
        saltus_system_free(systems[k]);
}

/* Trajectories that share the work start at different times in the last half of the transient: of a free
 * motion whose impacts cease as it decays, later starts see fewer impacts. */
static void members_start_apart(void **unused) {
    (void)unused;
    static const int members[] = {1, 2, 4, 9};
    saltus_spec spec = oscillator_spec(0.02, 1, 0, 1);
    add_stop(&spec, 1e-3, 1, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    const double start[2] = {-100, 0.3};
    for (int k = 0; k < 4; k++) {
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        long long count = members[k], impacts = 0;
        options.members = members[k];
        options.transient = 100;
        options.periods = 200 * count;
        saltus_lyapunov l = measure(system, start, &options);
        long long lead = l.transient - options.transient; /* in which the vectors rotate, the same */
        assert_true(l.periods == options.periods && lead < 60);
        for (int m = 0; m < count; m++) {
            long long from = options.transient - options.transient / 2 * m / count + lead;
            saltus_flow *flow = open_flow(system, &options.flow, 0, start);
            advance(flow, (double)from, 0);
            impacts -= saltus_flow_information(flow, 0).impacts;
            advance(flow, (double)(from + 200), 0);
            impacts += saltus_flow_information(flow, 0).impacts;
            saltus_flow_free(flow);
        }
        assert_true(impacts > 40 * count);
        check_near(l.impacts_per_period * (double)l.periods, (double)impacts, 2);
        saltus_lyapunov_clear(&l);
    }
    saltus_system_free(system);
}

/* Some of several trajectories on a chaotic transient have left for an orbit with a negative exponent: they
 * do not measure the same quantity, and no mean of theirs is precise, unless the requested precision is
 * coarser than their distance. */
static void members_that_part_do_not_agree(void **unused) {
    (void)unused;
    static const double asked[] = {0.01, 0.5, 1.2, 3, 6, 20};
    saltus_spec spec = oscillator_spec(0, 1, 1, 2.544);
    add_stop(&spec, 0, 0.91, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    double start[2] = {-0.3, 0.1};
    int agreed = 0, apart = 0;
    for (int members = 4; members <= 8; members += 4)
        for (int k = 0; k < 6; k++) {
            saltus_lyapunov_options options = saltus_lyapunov_defaults();
            double least = INFINITY, largest = -INFINITY, spread = 0;
            options.members = members;
            options.transient = 100;
            options.periods = 600 * members;
            options.precision = asked[k];
            saltus_lyapunov l = measure(system, start, &options);
            for (int m = 0; m < members; m++) {
                least = fmin(least, l.member_exponents[m]);
                largest = fmax(largest, l.member_exponents[m]);
                spread = fmax(spread, fabs(l.member_exponents[m] - l.exponents[0]));
            }
            assert_true(least < -0.02 && largest > 0.02);
            assert_int_equal(l.agree, spread <= asked[k] * fabs(l.exponents[0]));
            assert_true(l.agree || !l.precise);
            agreed += l.agree;
            apart += !l.agree;
            saltus_lyapunov_clear(&l);
        }
    assert_true(agreed >= 2 && apart >= 4);
    saltus_system_free(system);
}

/* A precise exponent has the requested precision, or 1e-6 per period; one that is not has used all its time.
 * The caller's columns of the flow do not matter. */
static void precision_is_what_was_asked_for(void **unused) {
    (void)unused;
    saltus_spec free_spec = oscillator_spec(0, 1, 1, 0.3183);
    saltus_system *systems[] = {struck_oscillator(0.1, 1, 1), struck_oscillator(0.1, 0.8, 0),
                                build(&free_spec), build(&free_spec)};
    static const double precisions[] = {1e-7, 0.03, 0.3};
    const double start[2] = {-0.3, 0.1};
    int precise = 0, beyond = 0;
    for (int k = 0; k < 12; k++) {
        const saltus_system *system = systems[k / 3];
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        options.members = 3;
        options.transient = 200;
        options.periods = 3000;
        options.flow.rtol = k < 9 ? 1e-10 : 1e-6; /* steps that leave more than 1e-6 in a period */
        options.precision = precisions[k % 3];
        saltus_lyapunov l = measure(system, start, &options);
        double asked = options.precision * fabs(l.exponents[0]), per_period = 1e-6 / l.period;
        assert_true(!l.precise || l.standard_errors[0] <= fmax(asked, per_period));
        assert_true(l.periods <= options.periods);
        assert_true(k < 9 || !l.precise);
        precise += l.precise;
        beyond += l.precise && l.standard_errors[0] > asked;
        if (!l.precise) /* no trajectory could have run for its shortest stretch */
            assert_true(l.transient > 500 || l.periods > options.periods * 3 / 4);
        if (k % 3 == 2) {
            options.flow.columns = 7;
            options.flow.directions = 1;
            saltus_lyapunov again = measure(system, start, &options);
            assert_true(again.exponents[0] == l.exponents[0] && again.periods == l.periods &&
                        again.standard_errors[0] == l.standard_errors[0]);
            saltus_lyapunov_clear(&again);
        }
        saltus_lyapunov_clear(&l);
    }
    assert_true(precise >= 4 && precise <= 7 && beyond >= 1);
    for (int k = 0; k < 4; k++)
        saltus_system_free(systems[k]);
}

/* What a caller is shown during a run. */
typedef struct witness {
    const saltus_lyapunov *result;
    double period;
    double last, at_most;
    int silent, calls, stop_after;
    volatile sig_atomic_t stop;
} witness;

static void watch(void *context, double periods, double at_most) {
    witness *w = context;
    assert_true(at_most == w->at_most && periods >= w->last && !w->stop);
    w->silent += periods == 0;
    w->calls += periods > 0;
    w->last = periods;
    if (periods > 0) {
        assert_true(w->result->history_count > 0 && w->result->history_count <= w->calls);
        check_near(w->result->history[w->result->history_count - 1].time, periods * w->period,
                   1e-9 * periods * w->period);
    }
    w->stop = w->stop_after > 0 && w->calls >= w->stop_after;
}

/* A caller who stops the flows by their flag, at the n-th report. */
typedef struct interrupter {
    volatile sig_atomic_t stop;
    int calls, stop_at;
} interrupter;

static void interrupt(void *context, double done, double all) {
    interrupter *i = context;
    assert_true(done >= 0 && done <= all);
    if (++i->calls == i->stop_at)
        i->stop = 1;
}

static void progress_is_told(void **unused) {
    (void)unused;
    saltus_system *system = struck_oscillator(0.1, 0.8, 0);
    double start[2] = {-0.3, 0.1};
    for (int stop_after = 0; stop_after < 12; stop_after += 6) {
        saltus_lyapunov l = {0};
        saltus_message message = {.text = ""};
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        witness w = {
            .result = &l, .period = 2 * M_PI / 0.8, .at_most = 8 * 700 + 5, .stop_after = stop_after};
        options.transient = 300;
        options.periods = (long long)w.at_most;
        options.precision = 1e-9;
        options.progress = (saltus_progress){watch, &w};
        options.flow.stop = &w.stop;
        check_ok(saltus_lyapunov_run(system, start, &options, &l, &message), &message);
        assert_true(w.silent >= 2 && !l.precise && (double)l.periods <= w.at_most);
        if (stop_after)
            assert_int_equal(w.calls, stop_after);
        else /* to the end: less than one look at each trajectory is left */
            assert_true(w.last > w.at_most - 8 && (double)l.periods >= 0.75 * w.last);
        saltus_lyapunov_clear(&l);
    }
    interrupter at_once = {.stop_at = 1};
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    options.progress = (saltus_progress){interrupt, &at_once};
    options.flow.stop = &at_once.stop;
    saltus_lyapunov l = measure(system, start, &options);
    assert_true(at_once.calls <= 2 && l.periods <= 8 * 50 && !l.precise);
    saltus_lyapunov_clear(&l);
    saltus_system_free(system);
}

/* When the list of estimates is full every second one is removed, from the first on; the others stay
 * unchanged. A free mass, in steps so inaccurate that its exponent is never precise. */
static void every_second_estimate_is_kept(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(1, 0, 0, 2 * M_PI);
    saltus_system *system = build(&spec);
    const double rest[2] = {0, 0};
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    options.members = 1;
    options.precision = 1e-14;
    options.transient = 0;
    options.flow.rtol = 1e-3;
    options.flow.order = 8;
    options.periods = 20000;
    saltus_lyapunov few = measure(system, rest, &options);
    options.periods = 2030000;
    saltus_lyapunov many = measure(system, rest, &options);
    assert_true(!few.precise && !many.precise && few.history_count > 80);
    assert_true(many.history_count > 128 && many.history_count < 512);
    for (int k = 0; 2 * k + 3 < few.history_count; k++) {
        assert_true(many.history[k].time == few.history[2 * k + 1].time);
        assert_true(many.history[k].exponent == few.history[2 * k + 1].exponent);
        assert_true(many.history[k].standard_error == few.history[2 * k + 1].standard_error);
    }
    for (int k = 1; k < many.history_count; k++)
        assert_true(many.history[k].time > many.history[k - 1].time);
    check_near(many.history[many.history_count - 1].exponent, many.exponents[0], 1e-12);
    check_near(many.exponents[0], 0, 3 * many.standard_errors[0]);
    saltus_lyapunov_clear(&few);
    saltus_lyapunov_clear(&many);
    saltus_system_free(system);
}

/* A seed disturbs the initial state slightly; without one the trajectory is the given one. */
static void seeds_disturb(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 0.61803398874989485);
    saltus_system *system = build(&spec);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    const double *scale = saltus_system_scale(system);
    double start[2] = {0.5, 0.2}, energy = 0.5 * 0.5 + 0.2 * 0.2, before = 0;
    options.members = 1;
    options.transient = 20;
    options.periods = 300;
    for (unsigned long seed = 0; seed < 4; seed++) {
        options.seed = seed;
        saltus_lyapunov l = measure(system, start, &options);
        double moved = l.state[0] * l.state[0] + l.state[1] * l.state[1] - energy;
        double size = 2 * hypot(0.5 * scale[0], 0.2 * scale[1]) * 1e-6;
        if (seed == 0)
            check_near(moved, 0, 1e-9);
        else
            assert_true(fabs(moved) > 0.01 * size && fabs(moved) < 5 * size && moved != before);
        before = moved;
        saltus_lyapunov_clear(&l);
    }
    saltus_system_free(system);
}

/* The section of a torus has as many dimensions as there are zero exponents: 1 of four, 2 of two, 4 of four.
 * With too few exponents it is unknown. */
static void dimension_of_tori(void **unused) {
    (void)unused;
    static const char *const undamped[] = {"c=0", "c2=0", "omega=1.77", "d=100", NULL};
    saltus_spec spec = oscillator_spec(0, 1, 1, 0.3183);
    saltus_system *systems[] = {two_masses(torus, true), build(&spec), two_masses(undamped, false)};
    static const double expected[] = {1, 2, 4};
    for (int k = 0; k < 3; k++) {
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        saltus_message message = {.text = ""};
        double start[4];
        int n = saltus_system_dimension(systems[k]);
        check_ok(saltus_system_default_state(systems[k], start, &message), &message);
        options.transient = 500;
        options.members = 2;
        options.periods = 4000;
        for (options.exponents = 0; options.exponents <= 2; options.exponents++) {
            saltus_lyapunov l = measure(systems[k], start, &options);
            bool enough =
                options.exponents == 0 || options.exponents == n || (k == 0 && options.exponents > 1);
            check_near(l.exponents[0] * l.period, 0, 1e-3);
            if (enough)
                check_near(l.kaplan_yorke, expected[k], 1e-9);
            else
                assert_true(isnan(l.kaplan_yorke));
            if (options.exponents == 0)
                check_near(l.sum, l.sum_rule, 1e-6);
            else if (options.exponents < n)
                assert_true(isnan(l.sum) && isnan(l.sum_rule));
            saltus_lyapunov_clear(&l);
        }
        saltus_system_free(systems[k]);
    }
}

/* Volumes shrink by damping over mass, for any motion, and by the restitution squared at each impact. */
static void volumes_of_two_masses(void **unused) {
    (void)unused;
    static const char *const settings[] = {"m=1.7", "m2=0.6",    "c=0.13", "c2=0.21",
                                           "r=0.7", "omega=1.6", NULL};
    saltus_system *system = two_masses(settings, false);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    double start[4] = {0};
    options.exponents = 0;
    options.precision = 0.1;
    options.periods = 8000;
    options.transient = 200;
    saltus_lyapunov l = measure(system, start, &options);
    assert_true(l.impacts_per_period > 0);
    check_near(l.sum_rule, -(0.13 + 0.21) / 1.7 - 0.21 / 0.6 + l.impacts_per_period / l.period * 2 * log(0.7),
               1e-3);
    check_near(l.sum, l.sum_rule, 1e-6);
    saltus_lyapunov_clear(&l);
    saltus_system_free(system);
}

/* A transient longer than requested is reported, and does not affect the exponents. */
static void drift_is_left_out(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.01, 1, 0.5, 1.7);
    add_stop(&spec, 1, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    double start[2] = {0.9, 0};
    for (int asked = 0; asked <= 2000; asked += 2000) {
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        options.transient = asked;
        options.exponents = 0;
        saltus_lyapunov l = measure(system, start, &options);
        assert_true(l.transient >= asked && l.precise && l.agree);
        check_near(l.exponents[0], -0.005, 3 * l.standard_errors[0] + 1e-9);
        check_near(l.impacts_per_period, 0, 0);
        saltus_lyapunov_clear(&l);
    }
    saltus_system_free(system);
}

/* `count` section points from a state on; returns the impacts between. */
static double *section_points(const saltus_system *system, const double *state, int count,
                              long long *impacts) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    int n = saltus_system_dimension(system);
    double *points = calloc((size_t)(n * count), sizeof *points);
    assert_non_null(points);
    options.rtol = 1e-10;
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (int k = 0; k < count; k++) {
        saltus_event event;
        check_ok(saltus_flow_advance(flow, (saltus_time){k + 1, 0}, 0, &event, &message), &message);
        saltus_flow_state(flow, 0, points + k * n);
    }
    *impacts = saltus_flow_information(flow, 0).impacts;
    saltus_flow_free(flow);
    return points;
}

/* Judged again from its final state, the motion has the same test results. */
static void opinions_are_repeated(void **unused) {
    (void)unused;
    skip_where_slow();
    enum { count = 1500 };
    saltus_system *systems[] = {struck_oscillator(0.1, 0.8, 0), two_masses(torus, true),
                                struck_oscillator(0, 2.8, 0)};
    const double starts[][4] = {{-0.3, 0.1}, {0}, {-0.3, 0.1}};
    const saltus_verdict kinds[] = {SALTUS_CHAOTIC, SALTUS_QUASIPERIODIC, SALTUS_CHAOTIC};
    for (int k = 0; k < 3; k++) {
        saltus_motion m = classify(systems[k], k == 1 ? NULL : starts[k], 2000, 64000);
        const saltus_evidence *e = &m.evidence;
        const double *scale = saltus_system_scale(systems[k]), *observer = saltus_system_observer(systems[k]);
        int n = saltus_system_dimension(systems[k]);
        long long impacts;
        double *points = section_points(systems[k], m.state, count, &impacts), series[count], weights[4],
               broadband;
        assert_int_equal(m.verdict, kinds[k]);
        for (int i = 0; i < n; i++)
            weights[i] = 1 / scale[i];
        for (int j = 0; j < count; j++) {
            series[j] = 0;
            for (int i = 0; i < n / 2; i++)
                series[j] += observer[i] * points[j * n + i];
        }
        saltus_series_points set = {points, weights, count, n};
        saltus_series_options options = saltus_series_defaults();
        saltus_series_chaos chaos;
        saltus_series_curve curve;
        saltus_series_dimension d;
        saltus_message message = {.text = ""};
        check_ok(saltus_series_chaos_test(series, count, &options, &chaos, &message), &message);
        check_ok(saltus_series_closed_curve(&set, &options, &curve, &message), &message);
        check_ok(saltus_series_correlation_dimension(&set, &options, &d, &message), &message);
        check_ok(saltus_series_broadband(series, count, &broadband, &message), &message);
        check_near(e->zero_one, chaos.k, 0.12);
        check_near(e->zero_one_quartiles[0], chaos.lower, 0.15);
        check_near(e->zero_one_quartiles[1], chaos.upper, 0.15);
        assert_true(e->zero_one_quartiles[0] <= e->zero_one && e->zero_one <= e->zero_one_quartiles[1]);
        check_near(e->dimension, d.dimension, 0.1 + 2 * hypot(d.error, e->dimension_error));
        assert_true(e->dimension_error > 0.2 * d.error && e->dimension_error < 5 * d.error);
        check_near(e->broadband, broadband, 0.02 + 0.3 * broadband);
        assert_int_equal(e->curves, curve.closed ? curve.curves : 0);
        check_near(e->impacts_per_period, (double)impacts / count, 0.02 * e->impacts_per_period);
        assert_true(e->members == 8 && e->periods % 8 == 0 && e->periods <= 64000 && e->left == 0);
        assert_true(e->left_for[0] == 0 && e->laminar_period == 0 && e->longest_phase == 0 &&
                    e->laminar == 0);
        check_near(e->history[e->history_count - 1].time,
                   (double)e->periods * saltus_system_period(systems[k]),
                   1e-9 * (double)e->periods * saltus_system_period(systems[k]));
        check_near(e->history[e->history_count - 1].exponent, m.lyapunov, 1e-12);
        check_near(e->history[e->history_count - 1].standard_error, m.lyapunov_error, 1e-12);
        for (int h = 1; h < e->history_count; h++)
            assert_true(e->history[h].time > e->history[h - 1].time);
        check_near(0.5 * (e->half[0] + e->half[1]), m.lyapunov,
                   m.lyapunov_error + 2 * hypot(e->half_errors[0], e->half_errors[1]));
        if (m.verdict == SALTUS_CHAOTIC) {
            assert_true(m.lyapunov > 3 * m.lyapunov_error);
            for (int h = 0; h < 2; h++)
                assert_true(e->half[h] > 2 * e->half_errors[h] && e->half_errors[h] > m.lyapunov_error);
        } else
            check_near(m.lyapunov * saltus_system_period(systems[k]), 0, 2e-3);
        free(points);
        saltus_motion_clear(&m);
    }
    for (int k = 0; k < 3; k++)
        saltus_system_free(systems[k]);
}

static void check_told(const saltus_motion *m, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (!strstr(m->reason, text))
        fail_msg("\"%s\" is not in \"%s\"", text, m->reason);
}

/* The numbers in the reason are those of the evidence: for chaos, for a torus, for one observed too briefly,
 * and for a decay too slow for a period to show. */
static void reasons_tell_the_evidence(void **unused) {
    (void)unused;
    saltus_spec undamped = oscillator_spec(0, 1, 1, 0.6180339887498949),
                slow = oscillator_spec(2e-5, 1, 1, 0.6180339887498949);
    saltus_system *systems[] = {struck_oscillator(0.1, 0.8, 0), build(&undamped), two_masses(torus, true),
                                build(&slow)};
    static const saltus_verdict kinds[] = {SALTUS_CHAOTIC, SALTUS_QUASIPERIODIC, SALTUS_UNDECIDED,
                                           SALTUS_LONG_PERIOD};
    static const long long measures[] = {16000, 16000, 4000, 16000};
    for (int k = 0; k < 4; k++) {
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_motion m;
        double start[4] = {-0.3, 0.1}, period = saltus_system_period(systems[k]);
        if (k == 2)
            check_ok(saltus_system_default_state(systems[k], start, &message), &message);
        options.transient = 100;
        options.measure = measures[k];
        options.lifetime = options.measure / 24;
        options.longest = 37;
        check_ok(saltus_classify(systems[k], start, &options, &m, &message), &message);
        const saltus_evidence *e = &m.evidence;
        assert_int_equal(m.verdict, kinds[k]);
        if (k == 0) {
            check_told(&m, "largest exponent %.4g +- %.1g per unit of time over %lld periods", m.lyapunov,
                       m.lyapunov_error, e->periods);
            check_told(&m, "none of %d trajectories", e->members);
        } else if (k == 1) {
            check_told(&m, "largest exponent %.1e +- %.0e per unit of time", m.lyapunov, m.lyapunov_error);
            check_told(&m, "fill %d closed curve, all but %.1e", e->curves, e->broadband);
        } else if (k == 2) {
            double short_by = 3 * m.lyapunov_error / fmax(fabs(m.lyapunov), 1e-3 / period);
            check_told(&m, "largest exponent %.3g +- %.1g per unit of time over %lld periods", m.lyapunov,
                       m.lyapunov_error, e->periods);
            check_told(&m, "halves %.3g and %.3g)", e->half[0], e->half[1]);
            check_told(&m, e->curves ? "points fill closed curves" : "points fill no closed curve");
            check_told(&m, "some %.1e periods", 1.2 * (double)e->periods * fmax(short_by * short_by, 2));
        } else {
            assert_string_equal(m.label, "long-period");
            check_near(m.lyapunov, -1e-5, 4 * m.lyapunov_error);
            check_told(&m, "largest exponent %.4g +- %.1g per unit of time", m.lyapunov, m.lyapunov_error);
            check_told(&m, "longer than %d T", options.longest);
        }
        saltus_motion_clear(&m);
        saltus_system_free(systems[k]);
    }
}

/* The exponent of a verdict is that of a separate measurement. */
static void exponents_are_repeated(void **unused) {
    (void)unused;
    saltus_system *system = struck_oscillator(0, 2.8, 0);
    const double start[2] = {-0.3, 0.1};
    saltus_motion m = classify(system, start, 2000, 64000);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    options.precision = 0.02;
    options.transient = 100;
    saltus_lyapunov l = measure(system, start, &options);
    check_near(m.lyapunov, l.exponents[0], 4 * hypot(m.lyapunov_error, l.standard_errors[0]));
    /* Errors fall with the square root of the time. */
    check_near(m.lyapunov_error / l.standard_errors[0], sqrt((double)l.periods / (double)m.evidence.periods),
               0.5 * sqrt((double)l.periods / (double)m.evidence.periods));
    check_near(m.evidence.impacts_per_period, l.impacts_per_period, 0.02 * l.impacts_per_period);
    saltus_lyapunov_clear(&l);
    saltus_motion_clear(&m);
    saltus_system_free(system);
}

/* Phases in which section points recur after p periods within a fiftieth of their extent, for at least five
 * rounds and twenty points: their share of the time, and the longest. */
static double laminar_part(const saltus_system *system, const double *points, int count, int p,
                           long long *longest) {
    const double *scale = saltus_system_scale(system);
    double extent = 0;
    long long phase = 0, laminar = 0, counted = 0;
    for (int k = 0; k < count; k++)
        for (int i = 0; i < 2; i++)
            extent = fmax(extent, fabs(points[2 * k + i] - points[i]) / scale[i]);
    *longest = 0;
    for (int k = p; k <= count; k++) {
        double apart = INFINITY;
        if (k < count)
            apart = fmax(fabs(points[2 * k] - points[2 * (k - p)]) / scale[0],
                         fabs(points[2 * k + 1] - points[2 * (k - p) + 1]) / scale[1]);
        if (apart < 0.02 * extent) {
            phase++;
            continue;
        }
        if (phase >= 5 * p && phase >= 20) {
            /* Phases in close succession share points. */
            long long begin = k - phase - p > counted ? k - phase - p : counted;
            laminar += k - begin;
            counted = k;
            *longest = phase + p > *longest ? phase + p : *longest;
        }
        phase = 0;
    }
    return (double)laminar / count;
}

/* Chaos near the fold of an orbit of period 12 stays near it for long, repeatedly. */
static void laminar_phases_are_recounted(void **unused) {
    (void)unused;
    enum { stretches = 8, stretch = 2000 };
    saltus_system *system = struck_oscillator(0.1, 2.786, 0);
    const double start[2] = {-0.3, 0.1};
    saltus_motion m = classify(system, start, 2000, 128000);
    long long impacts, longest, lower = INT32_MAX, upper = 0;
    double *points = section_points(system, m.state, stretches * stretch, &impacts), mean = 0, square = 0;
    assert_int_equal(m.verdict, SALTUS_CHAOTIC);
    int p = m.evidence.laminar_period;
    assert_int_equal(p, 12);
    for (int k = 0; k < stretches; k++) {
        double part = laminar_part(system, points + 2 * k * stretch, stretch, p, &longest);
        mean += part / stretches;
        square += part * part / stretches;
        lower = longest < lower ? longest : lower;
        upper = longest > upper ? longest : upper;
        /* No other period has a larger share. */
        for (int other = 1; other < p; other++) {
            long long unused_phase;
            assert_true(laminar_part(system, points + 2 * k * stretch, stretch, other, &unused_phase) <=
                        part + 0.05);
        }
    }
    check_near(m.evidence.laminar, mean, 3.5 * sqrt(square - mean * mean));
    assert_true(m.evidence.longest_phase >= 0.7 * (double)lower &&
                m.evidence.longest_phase <= 1.5 * (double)upper);
    /* Much longer than neighbours need to separate. */
    assert_true((double)m.evidence.longest_phase > 10 / (m.lyapunov * saltus_system_period(system)));
    assert_true(m.evidence.laminar >= 0.05 && m.evidence.laminar <= 1);
    free(points);
    saltus_motion_clear(&m);
    saltus_system_free(system);
}

/* A motion that settled on nothing is reported at its present state, as far as it was followed from the
 * default one. */
static void check_course(const saltus_system *system, const saltus_motion *motion) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    double state[4];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    saltus_flow *flow = open_flow(system, &options.flow, 0, state);
    for (long long k = 1; k <= motion->transient; k++)
        advance(flow, (double)k, 0);
    saltus_flow_state(flow, 0, state);
    for (int i = 0; i < 4; i++)
        assert_true(motion->state[i] == state[i]);
    saltus_flow_free(flow);
}

/* A trajectory that has left a chaotic transient is noticed, and is on an orbit of the system: the one found
 * amid the points. */
static void those_who_left_are_named(void **unused) {
    (void)unused;
    saltus_system *system = two_masses(leaving, false);
    saltus_motion end = classify(system, NULL, 20000, 0);
    assert_int_equal(end.verdict, SALTUS_PERIODIC);
    static const long long transients[] = {200, 400, 1600};
    for (int k = 0; k < 3; k++) {
        saltus_motion m = classify(system, NULL, transients[k], 8000);
        assert_int_equal(m.verdict, SALTUS_TRANSIENT);
        assert_true(m.evidence.periods > 0 && m.evidence.periods <= 8000);
        assert_true(m.lyapunov > 0);
        assert_string_equal(m.label, "transient");
        if (m.evidence.left) {
            assert_true(m.evidence.left <= m.evidence.members);
            assert_string_equal(m.evidence.left_for, end.label);
        } else
            assert_string_equal(m.evidence.stable_orbit, end.label);
        assert_true(m.evidence.stable_orbit[0] == 0 || strcmp(m.evidence.stable_orbit, end.label) == 0);
        check_course(system, &m);
        saltus_motion_clear(&m);
    }
    saltus_motion_clear(&end);
    saltus_system_free(system);
}

/* The extremes of a motion without a period: on a torus any 400 periods show them, in chaos at least the stop
 * is reached. */
static void extremes_are_found_again(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_system *systems[] = {two_masses(torus, true), struck_oscillator(0.1, 0.8, 0)};
    for (int k = 0; k < 2; k++) {
        enum { samples = 64 };
        const double start[2] = {-0.3, 0.1}, *observer = saltus_system_observer(systems[k]);
        saltus_motion m = classify(systems[k], k ? start : NULL, 2000, 16000);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        double largest = -INFINITY, smallest = INFINITY, now[4];
        saltus_flow *flow = open_flow(systems[k], &options, 0, m.state);
        for (int j = 0; j < 400 * samples; j++) {
            saltus_event event;
            check_ok(saltus_flow_advance(flow, (saltus_time){j / samples, (double)(j % samples) / samples},
                                         SALTUS_WATCH_TURNING | SALTUS_WATCH_IMPACT, &event, &message),
                     &message);
            saltus_flow_state(flow, 0, now);
            double x = observer[0] * now[0] + (k ? 0 : observer[1] * now[1]);
            largest = fmax(largest, x);
            smallest = fmin(smallest, x);
            j -= event.kind != SALTUS_REACHED;
        }
        check_near(m.largest, largest, k ? 1e-9 : 1e-4);
        check_near(m.smallest, smallest, k ? 0.05 * fabs(smallest) : 1e-3);
        saltus_flow_free(flow);
        saltus_motion_clear(&m);
        saltus_system_free(systems[k]);
    }
}

/* The reports of a run in progress. */
typedef struct listener {
    double last, transient, measure;
    int calls;
    bool measuring;
} listener;

static void listen(void *context, double periods, double at_most) {
    listener *l = context;
    if (at_most == l->measure && !l->measuring) {
        l->measuring = true;
        l->last = 0;
    }
    assert_true(at_most == (l->measuring ? l->measure : l->transient));
    assert_true(periods > l->last && periods <= at_most);
    l->last = periods;
    l->calls += l->measuring;
}

static void listeners_hear_of_it(void **unused) {
    (void)unused;
    saltus_system *system = struck_oscillator(0.1, 0.8, 0);
    double start[2] = {-0.3, 0.1};
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion m;
    listener l = {.transient = 2000, .measure = 33333};
    options.transient = 2000;
    options.measure = 33333;
    options.lifetime = options.measure / 24;
    options.progress = (saltus_progress){listen, &l};
    check_ok(saltus_classify(system, start, &options, &m, &message), &message);
    assert_true(l.measuring && (double)m.evidence.periods == l.last);
    assert_int_equal(m.verdict, SALTUS_CHAOTIC);
    assert_int_equal(m.evidence.history_count, l.calls);
    saltus_motion_clear(&m);
    saltus_system_free(system);
}

static saltus_motion classify_interrupted(const saltus_system *system, const double *state, interrupter *i) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion m;
    options.transient = 2000;
    options.measure = 16000;
    options.lifetime = options.measure / 24;
    options.progress = (saltus_progress){interrupt, i};
    options.flow.stop = &i->stop;
    check_ok(saltus_classify(system, state, &options, &m, &message), &message);
    return m;
}

/* Results obtained while flows are being stopped are no evidence: neither in the transient nor while an
 * exponent is measured, up to the last report before the verdict. */
static void what_is_stopped_is_no_evidence(void **unused) {
    (void)unused;
    saltus_system *system = struck_oscillator(0.1, 0.8, 0);
    const double start[2] = {-0.3, 0.1};
    interrupter whole = {.stop_at = -1};
    saltus_motion m = classify_interrupted(system, start, &whole);
    assert_int_equal(m.verdict, SALTUS_CHAOTIC);
    int settling = whole.calls - m.evidence.history_count;
    assert_true(settling >= 2);
    saltus_motion_clear(&m);
    const int places[] = {1, settling, settling + 1, whole.calls - 1, whole.calls};
    for (int k = 0; k < 5; k++) {
        interrupter i = {.stop_at = places[k]};
        m = classify_interrupted(system, start, &i);
        assert_int_equal(m.verdict, SALTUS_UNDECIDED);
        assert_string_equal(m.label, "undecided");
        assert_non_null(strstr(m.reason, "(stopped)"));
        assert_true(isnan(m.lyapunov) && isnan(m.lyapunov_error));
        assert_true(m.evidence.periods == 0 && m.evidence.history_count == 0 && !m.evidence.history);
        assert_true(m.transient > 0 && m.transient <= 200);
        assert_true(i.calls <= places[k] + 1);
        saltus_motion_clear(&m);
    }
    saltus_system_free(system);
}

/* Of several motions those complete at the stop are counted. */
static void attractors_until_it_is_stopped(void **unused) {
    (void)unused;
    saltus_system *system = struck_oscillator(0.1, 1, 1);
    for (int motions = 0; motions < 3; motions++) {
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_attractors found;
        interrupter i = {.stop_at = -1};
        int complete = 0;
        options.progress = (saltus_progress){interrupt, &i};
        options.flow.stop = &i.stop;
        options.measure = 0;
        check_ok(saltus_attractors_find(system, motions + 1, 7, &options, &found, &message), &message);
        int calls = i.calls;
        assert_int_equal(found.seeds, motions + 1);
        saltus_attractors_clear(&found);
        if (motions == 0)
            continue;
        /* The same seeds again, up to the first report of the last one. */
        interrupter fewer = {.stop_at = -1};
        options.progress.context = &fewer;
        options.flow.stop = &fewer.stop;
        check_ok(saltus_attractors_find(system, motions, 7, &options, &found, &message), &message);
        saltus_attractors_clear(&found);
        assert_true(fewer.calls < calls);
        interrupter cut = {.stop_at = fewer.calls + 1};
        options.progress.context = &cut;
        options.flow.stop = &cut.stop;
        check_ok(saltus_attractors_find(system, motions + 5, 7, &options, &found, &message), &message);
        for (int k = 0; k < found.count; k++)
            complete += found.shares[k];
        assert_int_equal(complete, found.seeds);
        assert_true(found.seeds == motions || (found.seeds == motions + 1 && cut.calls == calls));
        saltus_attractors_clear(&found);
    }
    saltus_system_free(system);
}

static void defaults_are_those_told(void **unused) {
    (void)unused;
    saltus_lyapunov_options l = saltus_lyapunov_defaults();
    saltus_classify_options c = saltus_classify_defaults();
    saltus_flow_options flow = saltus_flow_defaults();
    assert_true(l.flow.rtol == 1e-10 && l.flow.atol == 1e-14 && l.exponents == 1 && l.members == 8);
    assert_true(l.transient == 1000 && l.periods == 1000000 && l.precision == 0.01 && l.interval == 0);
    assert_true(l.seed == 0 && l.progress.show == NULL);
    assert_true(c.flow.rtol == flow.rtol && c.flow.atol == flow.atol && c.progress.show == NULL);
    assert_true(c.transient == 20000 && c.measure == 256000 && c.longest == 64);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_of_a_run_are_recounted),
        cmocka_unit_test(members_make_the_whole),
        cmocka_unit_test(members_start_apart),
        cmocka_unit_test(members_that_part_do_not_agree),
        cmocka_unit_test(precision_is_what_was_asked_for),
        cmocka_unit_test(progress_is_told),
        cmocka_unit_test(every_second_estimate_is_kept),
        cmocka_unit_test(seeds_disturb),
        cmocka_unit_test(dimension_of_tori),
        cmocka_unit_test(volumes_of_two_masses),
        cmocka_unit_test(drift_is_left_out),
        cmocka_unit_test(opinions_are_repeated),
        cmocka_unit_test(reasons_tell_the_evidence),
        cmocka_unit_test(exponents_are_repeated),
        cmocka_unit_test(laminar_phases_are_recounted),
        cmocka_unit_test(those_who_left_are_named),
        cmocka_unit_test(extremes_are_found_again),
        cmocka_unit_test(listeners_hear_of_it),
        cmocka_unit_test(what_is_stopped_is_no_evidence),
        cmocka_unit_test(attractors_until_it_is_stopped),
        cmocka_unit_test(defaults_are_those_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
