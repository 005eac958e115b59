/* What trajectories settle on: orbits just past a flip, orbits with very many impacts, slow departures from
 * an unstable orbit; the effect of each option; attractors from random states against states drawn and
 * classified one by one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_sticking.h"
#include "recount.h"

#include <gsl/gsl_randist.h>

static saltus_motion classify(const saltus_system *system, const double *state,
                              const saltus_classify_options *options) {
    saltus_message message = {.text = ""};
    saltus_motion motion;
    check_ok(saltus_classify(system, state, options, &motion, &message), &message);
    return motion;
}

static saltus_system *closed_system(const closed_oscillator *o) {
    saltus_spec spec = closed_spec(o);
    return build(&spec);
}

static double distance(const double *a, const double *b) {
    return fmax(fabs(a[0] - b[0]), fabs(a[1] - b[1]));
}

/* Beyond the flip of a branch of orbits of n periods, at lower or higher omega. */
typedef struct past_flip {
    closed_oscillator oscillator;
    double half[2]; /* the unstable orbit of n periods */
} past_flip;

static past_flip beyond_flip(closed_example example, long double lo, long double hi, double by) {
    closed_oscillator o = closed_example_of(example);
    closed_orbit flip, orbit;
    past_flip past;
    assert_true(closed_flip(&o, "omega", lo, hi, &flip));
    past.oscillator = flip.oscillator;
    past.oscillator.omega += by;
    assert_true(closed_orbit_at(&past.oscillator, 1, &orbit));
    assert_true(orbit.admissible && orbit.multiplier[0][0] < -1);
    past.half[0] = (double)orbit.state[0];
    past.half[1] = (double)orbit.state[1];
    return past;
}

/* The stable orbit has twice the period and lies 0.09 to 0.001 from its half. */
static void orbits_past_their_flip_are_whole(void **unused) {
    (void)unused;
    for (int digits = 3; digits <= 7; digits++) {
        double apart = 2.85 * pow(10, -0.5 * digits), start[2];
        past_flip past = beyond_flip(closed_two_periods, 0.92L, 0.95L, pow(10, -digits));
        saltus_system *system = closed_system(&past.oscillator);
        saltus_classify_options options = saltus_classify_defaults();
        start[0] = past.half[0] + 0.97 * apart;
        start[1] = past.half[1] + 0.26 * apart;
        options.measure = 0;
        saltus_motion motion = classify(system, start, &options);
        assert_string_equal(motion.label, "2/4");
        assert_true(motion.stable && motion.impacts == 2);
        check_near(distance(motion.section_states, motion.section_states + 4), 2 * apart, apart);
        recount r = recount_from(system, motion.state, 4);
        assert_int_equal(r.impacts, 2);
        check_near(distance(r.end, motion.state), 0, 1e-10);
        saltus_motion_clear(&motion);
        options.longest = 3;
        options.transient = 500;
        motion = classify(system, start, &options);
        assert_string_equal(motion.label, "irregular");
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* On an unstable orbit and near it: a motion that leaves slowly has not settled on that orbit, nor is it
 * chaotic as long as it was seen only in that neighbourhood. */
static void slow_departures_are_no_verdict(void **unused) {
    (void)unused;
    static const struct {
        closed_example example;
        double lo, hi, by, beside;
    } rows[] = {{closed_one_period, 0.9, 1, -1e-4, 0},
                {closed_one_period, 0.9, 1, -1e-4, 1e-5},
                {closed_one_period, 0.9, 1, -1e-5, 1e-3},
                {closed_one_period_loaded, 1.1, 1.2, -1e-4, 1e-4},
                {closed_two_periods, 0.92, 0.95, 1e-4, 0},
                {closed_two_periods, 0.92, 0.95, 1e-4, 1e-4},
                {closed_two_periods, 0.95, 0.97, -1e-5, 0},
                {closed_two_periods_light, 0.9, 0.95, 1e-6, 0},
                {closed_two_periods_light, 0.98, 0.995, -1e-5, 1e-5}};
    int positive = 0;
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        past_flip past = beyond_flip(rows[k].example, rows[k].lo, rows[k].hi, rows[k].by);
        saltus_system *system = closed_system(&past.oscillator);
        saltus_classify_options options = saltus_classify_defaults();
        double start[2] = {past.half[0] + rows[k].beside, past.half[1]};
        options.transient = 700;
        options.measure = 8000;
        options.lifetime = options.measure / 24;
        saltus_motion motion = classify(system, start, &options);
        if (motion.verdict == SALTUS_PERIODIC) {
            assert_true(motion.stable);
            assert_int_equal(motion.periods, 2 * past.oscillator.periods);
            assert_true(distance(motion.state, past.half) > 1e-3);
        } else if (motion.verdict != SALTUS_UNDECIDED && motion.verdict != SALTUS_LONG_PERIOD &&
                   motion.verdict != SALTUS_TRANSIENT)
            fail_msg("row %d: %s: %s", (int)k, motion.label, motion.reason);
        /* A positive exponent is no separation yet: from rounding to the extent takes 37 of its times. */
        if (motion.verdict == SALTUS_UNDECIDED && motion.lyapunov > 3 * motion.lyapunov_error) {
            double each = (double)motion.evidence.periods / motion.evidence.members,
                   rate = motion.lyapunov * saltus_system_period(system);
            const char *told = strstr(motion.reason, "measuring some ");
            assert_true(each * rate < -log(1e-16) && strstr(motion.reason, "not come apart") && told);
            check_near(strtod(told + 15, NULL) / motion.evidence.members * rate, -1.2 * log(1e-16), 3);
            positive++;
        }
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
    assert_true(positive >= 3);
}

/* Near a fold: from beside the unstable orbit to the stable one on one side; just before the fold, where
 * hundreds of points nearly recur without an orbit, to the free response. */
static void folds_let_pass(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_one_period);
    closed_orbit fold, stable, unstable;
    saltus_classify_options options = saltus_classify_defaults();
    assert_true(closed_fold(&o, "omega", 1.4L, 1.7L, &fold));
    options.measure = 0;
    for (int digits = 3; digits <= 5; digits++) {
        o.omega = fold.oscillator.omega - powl(0.1L, digits);
        assert_true(closed_orbit_at(&o, 1, &stable) && closed_orbit_at(&o, -1, &unstable));
        assert_true(stable.multiplier[0][0] < 1 && unstable.multiplier[0][0] > 1);
        saltus_system *system = closed_system(&o);
        for (int side = -1; side <= 1; side++) {
            double start[2], to[2] = {(double)stable.state[0], (double)stable.state[1]},
                             from[2] = {(double)unstable.state[0], (double)unstable.state[1]};
            for (int i = 0; i < 2; i++)
                start[i] = from[i] + 0.02 * side * (to[i] - from[i]);
            saltus_motion motion = classify(system, start, &options);
            if (side == 1) {
                assert_string_equal(motion.label, "1/1");
                check_near(distance(motion.state, to), 0, 1e-9);
            } else if (side == -1)
                assert_string_equal(motion.label, "0/1");
            else if (motion.verdict == SALTUS_PERIODIC)
                assert_true(motion.stable && distance(motion.state, from) > distance(to, from) / 2);
            saltus_motion_clear(&motion);
        }
        saltus_system_free(system);
        o.omega = fold.oscillator.omega + powl(0.1L, digits);
        system = closed_system(&o);
        double start[2] = {(double)fold.state[0], (double)fold.state[1]};
        saltus_motion motion = classify(system, start, &options);
        assert_string_equal(motion.label, "0/1");
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* A slow force presses a light mass against the stop for half its period, where it bounces hundreds of times,
 * completely or not; counted again by closed-form flights. */
static void hundreds_of_impacts_are_counted(void **unused) {
    (void)unused;
    static const double table[][2] = {{-0.05, 0.995}, {0, 0.995}, {0, 0.999}, {0, 0.9}};
    for (int k = 0; k < 4; k++) {
        closed_oscillator o = {.c = 0.1L,
                               .k = 0.3L,
                               .F = 0.5L,
                               .F0 = table[k][0],
                               .omega = 0.05L,
                               .r = table[k][1],
                               .periods = 1};
        saltus_system *system = closed_system(&o);
        saltus_classify_options options = saltus_classify_defaults();
        double start[2] = {-0.1, 0};
        options.measure = 0;
        options.transient = 200;
        saltus_motion motion = classify(system, start, &options);
        char label[32];
        if (k == 3) {
            assert_string_equal(motion.label, "chatter/1");
            assert_int_equal(motion.impacts, -1);
            assert_true(motion.impacts_by_face[0] > 150 && motion.sticking_intervals == 1);
        } else {
            /* From the first impact to the same one a period later. */
            long double period = closed_period(&o),
                        first = saltus_time_periods(motion.events[0].time) * period;
            closed_impact impact = {first, motion.events[0].velocity_before, 1};
            int count = 0;
            for (; impact.time < first + 0.9999L * period; count++) {
                long double x[2];
                closed_after(&o, &impact, x);
                impact = closed_bounce(&o, impact.time, x);
            }
            check_near((double)((impact.time - first) / period), 1, 1e-9);
            assert_true(count > 150);
            assert_int_equal(motion.impacts, count);
            assert_int_equal(motion.event_count, count);
            assert_int_equal(motion.impacts_by_face[0], count);
            snprintf(label, sizeof label, "%d/1", count);
            assert_string_equal(motion.label, label);
        }
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

typedef struct reports {
    int calls, most;
    double last, at_most;
    volatile sig_atomic_t stop;
} reports;

static void report(void *context, double periods, double at_most) {
    reports *r = context;
    assert_true(periods > r->last);
    r->last = periods;
    r->at_most = at_most;
    r->stop = ++r->calls >= r->most;
}

static const closed_oscillator chaotic = {
    .c = 0.04L, .k = 1, .F = 0.363L, .F0 = -1, .omega = 0.9166L, .r = 0.9L, .periods = 2};

static void options_take_effect(void **unused) {
    (void)unused;
    saltus_system *system = closed_system(&chaotic);
    saltus_classify_options options = saltus_classify_defaults();
    double start[2] = {-0.2, 0.1};
    reports seen = {.most = 1000000};
    volatile sig_atomic_t stop = 1;
    assert_true(options.transient == 20000 && options.measure == 256000 && options.longest == 64);
    assert_true(!options.progress.show && options.flow.rtol == saltus_flow_defaults().rtol);
    options.measure = 0;
    options.transient = 777;
    options.progress = (saltus_progress){report, &seen};
    options.flow.stop = &seen.stop;
    saltus_motion motion = classify(system, start, &options);
    assert_string_equal(motion.label, "irregular");
    assert_false(saltus_verdict_settled(motion.verdict));
    assert_int_equal(motion.transient, 777);
    assert_true(seen.calls > 3 && seen.last == 777 && seen.at_most == 777);
    assert_true(isnan(motion.lyapunov) && isnan(motion.lyapunov_error) && motion.evidence.periods == 0);
    assert_true(motion.periods == 0 && motion.mirror == SALTUS_MIRROR_NONE && motion.reason[0]);
    /* The state is the flow's. */
    double end[2];
    saltus_flow *flow = open_flow(system, &options.flow, 0, start);
    for (int k = 1; k <= 777; k++)
        advance(flow, k, 0);
    saltus_flow_state(flow, 0, end);
    saltus_flow_free(flow);
    assert_true(motion.state[0] == end[0] && motion.state[1] == end[1]);
    saltus_motion_clear(&motion);
    seen = (reports){.most = 3};
    options.transient = 20000;
    motion = classify(system, start, &options);
    assert_true(seen.calls == 3 && (double)motion.transient == seen.last && seen.last < 1000);
    assert_string_equal(motion.label, "undecided");
    saltus_motion_clear(&motion);
    options.progress.show = NULL;
    options.flow.stop = &stop;
    motion = (saltus_motion){0};
    saltus_message message = {.text = ""};
    saltus_status status = saltus_classify(system, start, &options, &motion, &message);
    assert_true(status == SALTUS_INTERRUPTED || (status == SALTUS_OK && motion.verdict == SALTUS_UNDECIDED));
    saltus_motion_clear(&motion);
    options.flow.stop = NULL;
    options.transient = 1000;
    options.measure = 32000;
    motion = classify(system, start, &options);
    assert_string_equal(motion.label, "chaotic");
    assert_true(motion.evidence.periods > 0 && motion.evidence.periods <= 32000);
    assert_int_equal(motion.evidence.members, 8);
    assert_int_equal(motion.transient, 1000 / 10);
    recount r = recount_from(system, motion.state, 400);
    check_near(motion.largest, r.largest, 1e-2);
    check_near(motion.smallest, r.smallest, 1e-2);
    saltus_motion_clear(&motion);
    /* A short transient is run in full before an exponent is measured. */
    options.transient = 600;
    motion = classify(system, start, &options);
    assert_string_equal(motion.label, "chaotic");
    assert_int_equal(motion.transient, 600);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

/* A motion without a verdict has no measured values: if measuring is not allowed, too short, or stopped by
 * the caller. Its extent is reported unless it was stopped. */
static void what_is_not_measured_is_no_number(void **unused) {
    (void)unused;
    saltus_system *system = closed_system(&chaotic);
    const double start[2] = {-0.2, 0.1};
    for (int k = 0; k < 3; k++) {
        saltus_classify_options options = saltus_classify_defaults();
        reports seen = {.most = k == 2 ? 1 : 1000000};
        options.transient = 100;
        options.measure = k == 1 ? 100 : 0;
        options.progress = (saltus_progress){report, &seen};
        options.flow.stop = &seen.stop;
        saltus_motion motion = classify(system, start, &options);
        const saltus_evidence *e = &motion.evidence;
        assert_string_equal(motion.label, k == 2 ? "undecided" : "irregular");
        assert_true(isnan(motion.lyapunov) && isnan(motion.lyapunov_error));
        assert_true(e->periods == 0 && e->history_count == 0 && !e->history && e->left == 0);
        assert_true(isnan(e->zero_one) && isnan(e->zero_one_quartiles[0]) && isnan(e->zero_one_quartiles[1]));
        assert_true(isnan(e->dimension) && isnan(e->dimension_error) && isnan(e->broadband));
        assert_true(isnan(e->half[0]) && isnan(e->half[1]) && isnan(e->half_errors[0]) &&
                    isnan(e->half_errors[1]) && isnan(e->impacts_per_period));
        assert_true(e->curves == 0 && e->laminar_period == 0 && !e->left_for[0] && !e->stable_orbit[0]);
        recount r = recount_from(system, motion.state, 400);
        if (k < 2) {
            check_near(motion.largest, 0, 1e-12); /* the stop */
            check_near(motion.smallest, r.smallest, 0.02 * fabs(r.smallest));
        } else
            assert_true(motion.largest == motion.state[0] && motion.smallest == motion.state[0]);
        saltus_motion_clear(&motion);
    }
    saltus_system_free(system);
}

/* The requested integrator is reported for any motion; without an orbit there is no mirror image. */
static void what_was_asked_for_is_told(void **unused) {
    (void)unused;
    static const saltus_integrator integrators[] = {SALTUS_AUTOMATIC, SALTUS_RADAU};
    const double start[2] = {0.1, 0};
    for (int k = 0; k < 6; k++) {
        saltus_spec spec = oscillator_spec(0.3, 1, k % 3 ? 0.5 : 0, 1.1);
        add_stop(&spec, 0.2, 0.5, SALTUS_BOTH);
        saltus_system *system = build(&spec);
        saltus_classify_options options = saltus_classify_defaults();
        options.flow.integrator = integrators[k / 3];
        options.measure = 0;
        options.transient = k % 3 == 2 ? 1 : 2000;
        saltus_motion motion = classify(system, start, &options);
        assert_true(motion.integrator == options.flow.integrator);
        if (k % 3 == 2)
            /* Impacts are counted by side, over the stated number of periods. */
            assert_true(motion.verdict == SALTUS_IRREGULAR && motion.mirror == SALTUS_MIRROR_OPEN &&
                        motion.counted == 400 && motion.impacts_by_face[0] >= 400 &&
                        motion.impacts_by_face[1] >= 400);
        else
            assert_true(saltus_verdict_settled(motion.verdict) && motion.mirror != SALTUS_MIRROR_NONE);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

static void options_out_of_range_are_refused(void **unused) {
    (void)unused;
    saltus_system *system = closed_system(&chaotic);
    double start[2] = {-0.2, 0.1}, beyond[2] = {0.2, 0};
    for (int k = 0; k < 6; k++) {
        saltus_classify_options options = saltus_classify_defaults();
        saltus_motion motion;
        saltus_message message = {.text = ""};
        options.transient = k == 0 ? 0 : 1;
        options.longest = k == 1 ? 0 : k == 2 ? 1025 : k == 3 ? 1024 : 1;
        options.measure = k == 4 ? -1 : 0;
        saltus_status status = saltus_classify(system, k == 5 ? beyond : start, &options, &motion, &message);
        assert_int_equal(status, k == 3 ? SALTUS_OK : SALTUS_BAD_INPUT);
        assert_int_equal(message.text[0] != 0, k != 3);
        assert_true(k == 3 || (motion.state == NULL && motion.dimension == 0));
        saltus_motion_clear(&motion);
    }
    saltus_system_free(system);
}

/* Orbits are sought up to the longest period only, unless an exponent shows that there is one. */
static void longest_is_the_longest(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_two_periods);
    closed_orbit orbit;
    o.omega = 0.82L;
    assert_true(closed_orbit_at(&o, 1, &orbit));
    saltus_system *system = closed_system(&o);
    double start[2] = {(double)orbit.state[0] + 1e-3, (double)orbit.state[1]};
    for (int longest = 1; longest <= 3; longest++)
        for (long long measure = 0; measure <= 16000; measure += 16000) {
            saltus_classify_options options = saltus_classify_defaults();
            options.longest = longest;
            options.transient = 1000;
            options.measure = measure;
            options.lifetime = options.measure / 24;
            saltus_motion motion = classify(system, start, &options);
            assert_string_equal(motion.label, longest > 1 || measure ? "1/2" : "irregular");
            assert_true(longest > 1 || measure == 0 || motion.transient > 1000);
            assert_true(motion.verdict != SALTUS_PERIODIC ||
                        (motion.evidence.periods == 0 && !motion.reason[0]));
            saltus_motion_clear(&motion);
        }
    saltus_system_free(system);
}

/* The next random state as in the header: Gaussian with the system's scales, beyond no stop. */
static void draw(const saltus_system *system, gsl_rng *rng, double *state) {
    do
        for (int i = 0; i < saltus_system_dimension(system); i++)
            state[i] = gsl_ran_gaussian(rng, saltus_system_scale(system)[i]);
    while (saltus_system_check_state(system, state, NULL) != SALTUS_OK);
}

static bool same_orbit(const saltus_motion *a, const saltus_motion *b) {
    if (strcmp(a->label, b->label) != 0)
        return false;
    if (!saltus_verdict_settled(a->verdict))
        return true;
    for (int p = 0; p < a->periods; p++)
        if (distance(a->section_states + 2 * p, b->state) < 1e-6)
            return true;
    return a->periods == 0 && distance(a->state, b->state) < 1e-6;
}

/* Each initial state's motion is counted for one attractor; attractors are distinct, most frequent first.
 * Scenes: a bistable one, one whose orbit has two section points, a mirror pair, a load that may be at
 * rest. */
static void shares_are_those_of_single_states(void **unused) {
    (void)unused;
    enum { seeds = 24 };
    int several = 0;
    for (int scene = 0; scene < 6; scene++) {
        closed_oscillator o = closed_example_of(scene == 0   ? closed_one_period
                                                : scene == 1 ? closed_two_periods
                                                             : closed_mirrored);
        o.omega = scene == 0 ? 1.4L : scene == 1 ? 0.82L : 3;
        if (scene == 3)
            o = (closed_oscillator){.c = 0.3L, .k = 1, .F0 = -0.2L, .omega = 1, .d = -0.1L, .r = 0.5L};
        if (scene == 4) {
            o = closed_example_of(closed_two_periods_light);
            o.omega = 0.9902L;
        }
        if (scene == 5)
            o = chaotic;
        saltus_system *system = closed_system(&o);
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_attractors found;
        int shares[seeds] = {0}, sum = 0;
        double state[2];
        options.measure = 0;
        options.transient = scene == 5 ? 200 : 2000;
        check_ok(saltus_attractors_find(system, seeds, 5, &options, &found, &message), &message);
        assert_int_equal(found.seeds, seeds);
        gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
        gsl_rng_set(rng, 5);
        for (int k = 0; k < seeds; k++) {
            int here = -1;
            draw(system, rng, state);
            saltus_motion motion = classify(system, state, &options);
            for (int a = 0; a < found.count; a++)
                if (same_orbit(&found.motions[a], &motion)) {
                    assert_int_equal(here, -1);
                    here = a;
                }
            assert_true(here >= 0);
            shares[here]++;
            saltus_motion_clear(&motion);
        }
        gsl_rng_free(rng);
        for (int a = 0; a < found.count; a++) {
            assert_int_equal(found.shares[a], shares[a]);
            assert_true(a == 0 || found.shares[a] <= found.shares[a - 1]);
            sum += found.shares[a];
        }
        assert_int_equal(sum, seeds);
        if (scene == 4)
            assert_true(found.count == 2 && found.motions[0].periods != found.motions[1].periods);
        if (scene == 5)
            assert_true(found.count == 1 && found.motions[0].verdict == SALTUS_IRREGULAR);
        several += found.count > 1;
        saltus_attractors_clear(&found);
        assert_true(!found.motions && found.count == 0);
        saltus_system_free(system);
    }
    assert_true(several >= 2);
}

/* A caller who stops at the n-th report: the motion in progress ends, and the whole run. Reported shares grow
 * by whole motions and by parts of one. */
typedef struct caller {
    int told, stop_at;
    double last;
    volatile sig_atomic_t stop;
} caller;

static void stop_in_time(void *context, double done, double seeds) {
    caller *c = context;
    assert_true(!c->stop && seeds == 9 && done >= c->last && done < seeds);
    c->last = done;
    c->stop = ++c->told == c->stop_at;
}

static void a_stop_ends_the_search_for_attractors(void **unused) {
    (void)unused;
    closed_oscillator settling = closed_example_of(closed_one_period);
    for (int k = 0; k < 2; k++) {
        saltus_system *system = closed_system(k ? &chaotic : &settling);
        for (int at = 1; at <= 5; at += 2) {
            saltus_classify_options options = saltus_classify_defaults();
            saltus_message message = {.text = ""};
            saltus_attractors found;
            caller c = {.stop_at = at, .last = -1};
            int sum = 0;
            options.measure = 0;
            options.transient = 200;
            options.progress = (saltus_progress){stop_in_time, &c};
            options.flow.stop = &c.stop;
            check_ok(saltus_attractors_find(system, 9, 5, &options, &found, &message), &message);
            assert_int_equal(c.told, at);
            assert_true(found.seeds == (int)c.last || found.seeds == (int)c.last + 1);
            assert_true(found.seeds < 9);
            for (int a = 0; a < found.count; a++) {
                sum += found.shares[a];
                /* Only complete motions are left, without a sign of the stop. */
                assert_null(strstr(found.motions[a].reason, "(stopped)"));
            }
            assert_int_equal(sum, found.seeds);
            saltus_attractors_clear(&found);
        }
        saltus_system_free(system);
    }
}

static void seeds_are_within_limits(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_one_period);
    saltus_system *system = closed_system(&o);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_attractors found;
    saltus_message message = {.text = ""};
    volatile sig_atomic_t stop = 1;
    assert_int_equal(saltus_attractors_find(system, 0, 1, &options, &found, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_attractors_find(system, 1000001, 1, &options, &found, &message),
                     SALTUS_BAD_INPUT);
    check_ok(saltus_attractors_find(system, 1, 1, &options, &found, &message), &message);
    assert_true(found.count == 1 && found.shares[0] == 1 && found.seeds == 1);
    saltus_attractors_clear(&found);
    options.flow.stop = &stop;
    check_ok(saltus_attractors_find(system, 5, 1, &options, &found, &message), &message);
    assert_true(found.count == 0 && found.seeds == 0);
    saltus_attractors_clear(&found);
    saltus_attractors_clear(&found);
    saltus_system_free(system);
}

/* The closest recurrence reported for a motion without a period: the minimum over periods p of the largest
 * distance between the last p + 2 points and those p earlier. */
static void the_closest_recurrence_is_recounted(void **unused) {
    (void)unused;
    enum { periods = 100, longest = 5 };
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 2.92);
    add_stop(&spec, 0, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_classify_options options = saltus_classify_defaults();
    const double start[2] = {-0.3, 0.1};
    double points[periods + 1][2] = {{-0.3, 0.1}}, closest = INFINITY, told;
    options.transient = periods;
    options.longest = longest;
    options.measure = 0;
    saltus_motion motion = classify(system, start, &options);
    saltus_flow *flow = open_flow(system, &options.flow, 0, start);
    for (int k = 1; k <= periods; k++) {
        saltus_event event;
        saltus_message message = {.text = ""};
        check_ok(saltus_flow_advance(flow, (saltus_time){k, 0}, 0, &event, &message), &message);
        saltus_flow_state(flow, 0, points[k]);
    }
    for (int p = 1; p <= longest; p++) {
        double largest = 0;
        for (int k = 0; k < p + 2; k++)
            largest =
                fmax(largest, saltus_system_distance(system, points[periods - k], points[periods - k - p]));
        closest = fmin(closest, largest);
    }
    const char *place = strstr(motion.reason, "closest recurrence ");
    assert_non_null(place);
    assert_int_equal(sscanf(place, "closest recurrence %lf of the state's scale", &told), 1);
    check_near(told, closest, 0.051 * closest);
    saltus_flow_free(flow);
    saltus_motion_clear(&motion);
    /* For too few points none is reported. */
    options.transient = 2;
    motion = classify(system, start, &options);
    assert_null(strstr(motion.reason, "recurrence"));
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orbits_past_their_flip_are_whole),
        cmocka_unit_test(slow_departures_are_no_verdict),
        cmocka_unit_test(folds_let_pass),
        cmocka_unit_test(hundreds_of_impacts_are_counted),
        cmocka_unit_test(the_closest_recurrence_is_recounted),
        cmocka_unit_test(options_take_effect),
        cmocka_unit_test(what_is_not_measured_is_no_number),
        cmocka_unit_test(what_was_asked_for_is_told),
        cmocka_unit_test(options_out_of_range_are_refused),
        cmocka_unit_test(longest_is_the_longest),
        cmocka_unit_test(shares_are_those_of_single_states),
        cmocka_unit_test(a_stop_ends_the_search_for_attractors),
        cmocka_unit_test(seeds_are_within_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
