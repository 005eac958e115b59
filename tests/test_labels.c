/* The description of an orbit or equilibrium - label, counts, section points, events, extremes, symmetry -
 * against closed forms and against a recount along the flow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_sticking.h"
#include "recount.h"

static saltus_motion settle_from(const saltus_system *system, const double *state) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    options.measure = 0;
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    return motion;
}

/* The description of an orbit found from a guess, stable or not. */
static saltus_motion describe_from(const saltus_system *system, int periods, const double *guess) {
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    saltus_motion motion;
    shooting.tolerance = 1e-11;
    check_ok(saltus_orbit_find(system, periods, guess, &shooting, &orbit, &message), &message);
    check_ok(saltus_motion_describe(system, &orbit, &options, &motion, &message), &message);
    saltus_orbit_clear(&orbit);
    return motion;
}

static void check_label(const saltus_motion *motion, const char *format, ...) {
    char text[32];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    assert_string_equal(motion->label, text);
}

/* Counts, section points and extremes of a motion against a second walk around it. */
static void check_recount(const saltus_system *system, const saltus_motion *motion) {
    recount r = recount_from(system, motion->state, motion->periods);
    long long sum = 0;
    int n = motion->dimension, strikes = 0, sticks = 0, releases = 0;
    if (r.chatter)
        check_label(motion, "chatter/%d", motion->periods);
    else
        check_label(motion, "%lld/%d", r.impacts, motion->periods);
    assert_int_equal(motion->impacts, r.chatter ? -1 : r.impacts);
    assert_int_equal(motion->sticking_intervals, r.sticks);
    assert_int_equal(motion->face_count, saltus_system_face_count(system));
    for (int f = 0; f < motion->face_count; f++) {
        assert_int_equal(motion->impacts_by_face[f], r.by_face[f]);
        sum += r.by_face[f];
    }
    assert_int_equal(sum, r.impacts);
    for (int k = 0; k < motion->event_count; k++) {
        const saltus_event *event = &motion->events[k];
        double time = saltus_time_periods(event->time);
        assert_true(time >= 0 && time <= motion->periods);
        assert_true(k == 0 || time >= saltus_time_periods(event[-1].time));
        strikes += event->kind != SALTUS_RELEASE && event->velocity_before != 0;
        releases += event->kind == SALTUS_RELEASE;
        sticks += event->kind == SALTUS_STICK;
    }
    assert_int_equal(strikes, r.impacts);
    assert_int_equal(sticks, r.sticks);
    assert_int_equal(releases, r.releases);
    double size = r.largest - r.smallest;
    check_near(motion->largest, r.largest, 2e-6 * size);
    check_near(motion->smallest, r.smallest, 2e-6 * size);
    assert_true(motion->largest >= r.largest - 1e-13 * size && motion->smallest <= r.smallest + 1e-13 * size);
    for (int k = 0; k < motion->periods; k++) {
        saltus_flow_options options = saltus_flow_defaults();
        double point[16];
        saltus_flow *flow = open_flow(system, &options, 0, motion->state);
        if (k > 0)
            advance(flow, k, 0);
        saltus_flow_state(flow, 0, point);
        for (int i = 0; i < n; i++)
            check_near(motion->section_states[k * n + i], point[i], 1e-10);
        saltus_flow_free(flow);
    }
}

/* A motion with impacts has the properties of its closed form; the contacts are listed by face. */
static void check_closed(const saltus_system *system, const closed_orbit *closed,
                         const saltus_motion *motion) {
    const closed_oscillator *o = &closed->oscillator;
    double period = (double)closed_period(o), stiff = fmax(1, 1 / (double)fabsl(closed->impact[0].speed));
    assert_int_equal(motion->verdict, SALTUS_PERIODIC);
    assert_true(saltus_verdict_settled(motion->verdict));
    check_label(motion, "%d/%d", closed->impacts, o->periods);
    assert_int_equal(motion->impacts, closed->impacts);
    assert_int_equal(motion->periods, o->periods);
    assert_int_equal(motion->dimension, 2);
    assert_int_equal(motion->event_count, closed->impacts);
    assert_int_equal(motion->sticking_intervals, 0);
    assert_false(motion->sticks);
    for (int k = 0; k < closed->impacts; k++) {
        const saltus_event *event = &motion->events[k];
        int face = closed->impact[k].side > 0 ? 0 : 1;
        double speed = (double)(closed->impact[k].side * closed->impact[k].speed);
        assert_int_equal(event->kind, SALTUS_IMPACT);
        assert_int_equal(event->face, face);
        assert_int_equal(motion->impacts_by_face[face], 1);
        check_near(saltus_time_periods(event->time), (double)closed->impact[k].time / period, 1e-10 * stiff);
        check_near(event->velocity_before, speed, 1e-10 * stiff);
        check_near(event->velocity_after, -(double)o->r * speed, 1e-10 * stiff);
    }
    for (int i = 0; i < 2; i++) {
        check_near(motion->state[i], (double)closed->state[i], 1e-10);
        check_near(motion->multipliers[i].re, (double)closed->multiplier[i][0], 1e-9 * stiff);
        check_near(fabs(motion->multipliers[i].im), (double)fabsl(closed->multiplier[i][1]), 1e-9 * stiff);
    }
    double modulus = (double)hypotl(closed->multiplier[0][0], closed->multiplier[0][1]);
    assert_int_equal(motion->multiplier_count, 2);
    assert_int_equal(motion->stable, modulus < 1);
    check_near(motion->lyapunov, log(modulus) / (o->periods * period), 1e-9 * stiff);
    assert_true(motion->lyapunov_error == 0 && motion->evidence.periods == 0 && motion->reason[0] == 0);
    double volume = 2 * closed->impacts * log((double)o->r) - (double)o->c * o->periods * period;
    check_near(motion->log_volume, volume, 1e-9);
    check_near(motion->sum_rule, volume, 1e-9);
    assert_true(motion->residual <= 1e-11 && motion->residual >= 0);
    check_near(motion->largest, (double)o->d, 1e-12);
    check_recount(system, motion);
}

static const struct {
    closed_example example;
    long double omega;
    int branch;
} rows[] = {{closed_one_period, 1.1L, 1},         {closed_one_period, 1.5L, 1},
            {closed_one_period, 1.5L, -1},        {closed_one_period, 0.85L, 1},
            {closed_one_period_loaded, 1.2L, 1},  {closed_one_period_loaded, 1.6L, -1},
            {closed_two_periods, 0.82L, 1},       {closed_two_periods, 0.94L, 1},
            {closed_two_periods_light, 0.85L, 1}, {closed_mirrored, 3.6L, 1},
            {closed_mirrored, 2.9L, 1},           {closed_mirrored_bubble, 2.5L, 1},
            {closed_mirrored_bubble, 1.14L, 1}};

/* Nearby motions settle on stable orbits; all orbits are described correctly. */
static void closed_orbits_are_told(void **unused) {
    (void)unused;
    int stable = 0;
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        closed_oscillator o = closed_example_of(rows[k].example);
        closed_orbit orbit;
        o.omega = rows[k].omega;
        assert_true(closed_orbit_at(&o, rows[k].branch, &orbit) && orbit.admissible);
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        double beside[2] = {(double)orbit.state[0] - 1e-4, (double)orbit.state[1] + 1e-4};
        saltus_mirror mirror = o.mirrored ? SALTUS_MIRROR_SELF : SALTUS_MIRROR_NONE;
        saltus_motion motion = describe_from(system, o.periods, beside);
        check_closed(system, &orbit, &motion);
        assert_int_equal(motion.mirror, mirror);
        saltus_motion_clear(&motion);
        if (hypotl(orbit.multiplier[0][0], orbit.multiplier[0][1]) < 1) {
            stable++;
            motion = settle_from(system, beside);
            /* It may have settled at any of the orbit's section points. */
            double shift = INFINITY;
            for (int p = 0; p < o.periods; p++)
                shift = fmin(shift, hypot(motion.section_states[2 * p] - (double)orbit.state[0],
                                          motion.section_states[2 * p + 1] - (double)orbit.state[1]));
            check_near(shift, 0, 1e-10);
            check_recount(system, &motion);
            assert_true(motion.stable && motion.mirror == mirror && motion.transient > 0);
            saltus_motion_clear(&motion);
        }
        saltus_system_free(system);
    }
    assert_true(stable >= 6);
}

/* With a loose tolerance of the flow Newton's method requires no more than that: the same motion, to that
 * accuracy. */
static void loose_tolerances_find_the_same(void **unused) {
    (void)unused;
    static const double tolerances[] = {1e-11, 1e-9, 1e-7, 1e-6};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        closed_oscillator o = closed_example_of(rows[k].example);
        closed_orbit orbit;
        o.omega = rows[k].omega;
        assert_true(closed_orbit_at(&o, rows[k].branch, &orbit));
        if (hypotl(orbit.multiplier[0][0], orbit.multiplier[0][1]) > 0.95L)
            continue;
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        double beside[2] = {(double)orbit.state[0] - 1e-4, (double)orbit.state[1] + 1e-4};
        for (int t = 0; t < 4; t++) {
            saltus_classify_options options = saltus_classify_defaults();
            saltus_message message = {.text = ""};
            saltus_motion motion;
            double far = INFINITY;
            options.measure = 0;
            options.transient = 2000;
            options.flow.rtol = tolerances[t];
            options.flow.atol = 1e-3 * tolerances[t];
            check_ok(saltus_classify(system, beside, &options, &motion, &message), &message);
            check_label(&motion, "%d/%d", orbit.impacts, o.periods);
            assert_true(motion.stable && motion.residual <= fmax(1e-12, 100 * tolerances[t]));
            for (int p = 0; p < o.periods; p++)
                far = fmin(far, hypot(motion.section_states[2 * p] - (double)orbit.state[0],
                                      motion.section_states[2 * p + 1] - (double)orbit.state[1]));
            check_near(far, 0, 1e-10 + 1e4 * tolerances[t]);
            saltus_motion_clear(&motion);
        }
        saltus_system_free(system);
    }
}

/* Beyond the pitchfork one of a pair is found, and mirroring gives the other. */
static void pairs_are_each_others_images(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_mirrored);
    closed_orbit pitchfork, one, other;
    assert_true(closed_pitchfork(&o, "omega", 3.4L, 3.6L, &pitchfork));
    assert_true(closed_pair_at(&pitchfork, "omega", 1, 3, &one));
    assert_true(closed_pair_at(&pitchfork, "omega", -1, 3, &other));
    saltus_spec spec = closed_spec(&one.oscillator);
    saltus_system *system = build(&spec);
    saltus_flow_options flow = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double beside[2] = {(double)one.state[0], (double)one.state[1] + 1e-5}, image[2];
    saltus_motion motion = settle_from(system, beside);
    check_closed(system, &one, &motion);
    assert_int_equal(motion.mirror, SALTUS_MIRROR_PAIR);
    memcpy(image, motion.state, sizeof image);
    check_ok(saltus_motion_mirror(system, &flow, image, &message), &message);
    for (int i = 0; i < 2; i++)
        check_near(image[i], (double)other.state[i], 1e-10);
    check_ok(saltus_motion_mirror(system, &flow, image, &message), &message);
    for (int i = 0; i < 2; i++)
        check_near(image[i], motion.state[i], 1e-10);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    spec.stops[0].sides = SALTUS_UPPER;
    system = build(&spec);
    assert_int_equal(saltus_motion_mirror(system, &flow, image, &message), SALTUS_BAD_INPUT);
    saltus_system_free(system);
}

/* Forced at twice its frequency a straight pipe oscillates with two forcing periods and is its own image one
 * of them later; it hits nothing, or both stops alternately. */
static void a_pulsation_swings_in_two_periods(void **unused) {
    (void)unused;
    for (int stops = 0; stops <= 1; stops++) {
        saltus_spec spec = pipe_spec(1, 12);
        set_parameter(&spec, "u0", 2.5);
        set_parameter(&spec, "sigma", 0.4);
        if (stops)
            add_stop(&spec, 0.01, 0.5, SALTUS_BOTH);
        saltus_system *system = build(&spec);
        double start[2] = {0.005, 0}, swung[2];
        saltus_motion motion = settle_from(system, start);
        saltus_flow_options flow = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        check_recount(system, &motion);
        assert_int_equal(motion.periods, 2);
        assert_int_equal(motion.mirror, SALTUS_MIRROR_SELF);
        assert_int_equal(motion.impacts > 0, stops);
        assert_int_equal(motion.impacts_by_face[0], motion.impacts_by_face[1]);
        memcpy(swung, motion.state, sizeof swung);
        check_ok(saltus_motion_settle(system, &flow, 1, swung, &message), &message);
        check_ok(saltus_motion_mirror(system, &flow, swung, &message), &message);
        check_near(swung[0], motion.state[0], 1e-10);
        check_near(swung[1], motion.state[1], 1e-8);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* Impacts without rebound are counted, chatter is not; contact lasts from the impact to the release. */
static void orbits_that_rest_are_told(void **unused) {
    (void)unused;
    static const double table[][3] = {{0.4, -0.6, 0},  {0.4, 0.2, 0},   {0.8, -0.4, 0}, {1.2, 0, 0},
                                      {2.4, 0, 0},     {2.8, 0.2, 0},   {3.2, 0.2, 0},  {2, 0.6, 0},
                                      {0.4, -0.4, .3}, {0.8, 0.2, 0.3}, {1.2, .6, 0.3}, {0.4, 0.4, 0.1}};
    bool two_impacts = false, two_periods = false;
    for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
        closed_oscillator o = closed_sticking_example(table[k][0], table[k][1], table[k][2]);
        closed_sticking closed = closed_sticking_of(&o);
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        double start[2] = {(double)closed.state[0][0] - 1e-3, 0.01 + (double)closed.state[0][1]};
        saltus_motion motion = settle_from(system, start);
        int n = 0, p = motion.periods, shift = 0;
        assert_int_equal(p, closed.periods);
        for (int s = 1; s < p; s++)
            if (fabs(motion.state[0] - (double)closed.state[s][0]) < 1e-6)
                shift = s;
        for (int s = 0; s < p; s++)
            for (int i = 0; i < 2; i++)
                check_near(motion.section_states[2 * s + i], (double)closed.state[(s + shift) % p][i], 1e-13);
        if (closed.chatter)
            check_label(&motion, "chatter/%d", p);
        else
            check_label(&motion, "%d/%d", closed.impacts, p);
        assert_int_equal(motion.sticking_intervals, 1);
        assert_true(motion.sticks && motion.stable);
        assert_true(motion.multipliers[0].re == 0 && motion.multipliers[0].log_modulus == -INFINITY);
        assert_true(motion.lyapunov == -INFINITY);
        for (int e = 0; e < motion.event_count; e++) {
            const saltus_event *event = &motion.events[e];
            if (event->kind == SALTUS_RELEASE) {
                check_near(event->time.phase, (double)(closed.release / closed_period(&o)), 1e-13);
                n++;
            }
        }
        assert_int_equal(n, 1);
        assert_true(closed.chatter ? motion.impacts == -1 && motion.impacts_by_face[0] > 5
                                   : motion.impacts_by_face[0] == closed.impacts);
        check_near(motion.largest, (double)o.d, 1e-15);
        check_near(motion.smallest, (double)closed.smallest, 4e-6);
        check_recount(system, &motion);
        two_impacts |= closed.impacts == 2 && !closed.chatter;
        two_periods |= p == 2;
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
    assert_true(two_impacts && two_periods);
}

/* The times of the impacts of one chatter, in periods, with the accumulation point last; *state is the
 * orbit's at the next section. */
static int chatter_times(const saltus_system *system, double phase, double *times, int room, double *state) {
    saltus_flow_options options = saltus_flow_defaults();
    double rest[2] = {saltus_system_face(system, 0).d, 0};
    saltus_flow *flow = open_flow(system, &options, phase, rest);
    saltus_event event;
    int count = 0;
    do {
        event = advance(flow, 2, SALTUS_WATCH_CONTACT);
        if (event.kind == SALTUS_IMPACT || event.kind == SALTUS_STICK) {
            assert_true(count < room);
            times[count++] = saltus_time_periods(event.time);
        }
    } while (event.kind != SALTUS_STICK && event.kind != SALTUS_REACHED);
    assert_int_equal(event.kind, SALTUS_STICK);
    saltus_flow_free(flow);
    flow = open_flow(system, &options, phase, rest);
    advance(flow, 1, 0);
    saltus_flow_state(flow, 0, state);
    saltus_flow_free(flow);
    return count;
}

/* A system whose load puts the section `part` of the way from impact `from_end` before the chatter's last one
 * to the next; from_end = 0: just after the accumulation point. *impacts counts the impacts. */
static saltus_system *chatter_at_section(double omega, double r, double load, int from_end, double part,
                                         double *state, int *impacts) {
    double loads[2] = {load, load + 1e-3}, late[2] = {NAN, NAN}, times[64];
    saltus_system *system = NULL;
    for (int step = 0; step < 8; step++) {
        int now = step > 0;
        closed_oscillator o = closed_sticking_example(omega, loads[now], r);
        saltus_spec spec = closed_spec(&o);
        saltus_system_free(system);
        system = build(&spec);
        double release = acos((double)((o.k * o.d - o.F0) / o.F)) / (2 * M_PI);
        *impacts = chatter_times(system, release - 0.01, times, 64, state);
        const double *from = &times[*impacts - 1 - from_end];
        late[now] = *from + part * (from_end ? from[1] - from[0] : 1e-6) - 1;
        if (step == 0 || fabs(late[1]) < 1e-13)
            continue;
        double next = loads[1] - late[1] * (loads[1] - loads[0]) / (late[1] - late[0]);
        if (step < 7) {
            loads[0] = loads[1];
            late[0] = late[1];
            loads[1] = next;
        }
    }
    check_near(late[1], 0, 1e-10);
    return system;
}

/* A load moves the chatter through the section: the motion is the same wherever it cuts the chatter, also
 * between the last impact simulated and the accumulation point. */
static void chatter_is_told_wherever_the_section_lies(void **unused) {
    (void)unused;
    static const double table[][3] = {{0.4, 0.1, -0.55}, {0.4, 0.5, -0.23}, {1, 0.1, 0.47}},
                        parts[] = {0.02, 0.3, 0.6, 0.98};
    int first_sticks = 0;
    for (int k = 0; k < 3; k++)
        for (int from_end = 0; from_end < 3; from_end++)
            for (int part = 0; part < 4; part++) {
                double state[2];
                int impacts;
                saltus_system *system = chatter_at_section(table[k][0], table[k][1], table[k][2], from_end,
                                                           parts[part], state, &impacts);
                saltus_motion motion = describe_from(system, 1, state);
                check_label(&motion, "chatter/1");
                assert_int_equal(motion.impacts, -1);
                assert_int_equal(motion.sticking_intervals, 1);
                assert_true(abs((int)motion.impacts_by_face[0] - impacts) <= 1);
                assert_true(motion.stable);
                first_sticks += motion.events[0].kind == SALTUS_STICK;
                saltus_motion_clear(&motion);
                saltus_system_free(system);
            }
    assert_true(first_sticks > 0);
}

/* Any rebound, however small, leads to chatter, even if only one impact is simulated. */
static void little_rebound_is_chatter(void **unused) {
    (void)unused;
    bool three = false;
    for (int digits = 2; digits <= 10; digits += 4) {
        closed_oscillator o = closed_sticking_example(0.4L, 0.4L, powl(0.1L, digits));
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        double start[2] = {(double)o.d, 0};
        saltus_motion motion = settle_from(system, start);
        check_label(&motion, "chatter/1");
        assert_int_equal(motion.impacts, -1);
        check_recount(system, &motion);
        three |= motion.event_count == 3;
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
    assert_true(three);
}

/* Two masses with stops for one or both. The observed displacement is that of the first stop; its extremes
 * may be corners at impacts on another stop. Also between two stops, with and without rebound. */
static void assorted_orbits_are_recounted(void **unused) {
    (void)unused;
    static const struct {
        double omega, d2, r, weight[2];
        saltus_sides sides;
    } two_mass[] = {{1.6, 0.3, 0.8, {1, -1}, SALTUS_UPPER}, {1.2, 0.2, 0.5, {1, -1}, SALTUS_BOTH},
                    {0.9, 0.3, 0.2, {1, -1}, SALTUS_UPPER}, {0.7, 0.1, 0, {0.5, -1}, SALTUS_BOTH},
                    {1.1, 0.4, 0.6, {0, 1}, SALTUS_LOWER},  {0.5, 0.2, 0.1, {-1, 1}, SALTUS_UPPER}};
    int corners = 0, periodic = 0, images = 0;
    for (size_t k = 0; k < sizeof two_mass / sizeof two_mass[0]; k++) {
        saltus_spec spec = oscillator_spec(0.2, 1, 0.5, two_mass[k].omega);
        set_parameter(&spec, "N", 2);
        set_parameter(&spec, "c2", 0.2);
        add_stop(&spec, k % 2 ? 0.6 : 50, 0.4, SALTUS_UPPER);
        add_stop(&spec, two_mass[k].d2, two_mass[k].r, two_mass[k].sides);
        memcpy(spec.stops[1].weight, two_mass[k].weight, sizeof spec.stops[1].weight);
        saltus_system *system = build(&spec);
        double start[4] = {0};
        saltus_motion motion = settle_from(system, start);
        if (motion.verdict == SALTUS_PERIODIC) {
            periodic++;
            assert_int_equal(motion.mirror, SALTUS_MIRROR_NONE);
            check_recount(system, &motion);
            for (int e = 0; e < motion.event_count; e++)
                corners += saltus_system_face(system, motion.events[e].face).stop == 1;
        }
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
    assert_true(corners >= 4 && periodic >= 4);
    for (int k = 0; k < 6; k++) {
        saltus_spec spec = oscillator_spec(0.1, 1, 1, 0.3 + 0.2 * k);
        add_stop(&spec, 0.3, k % 2 ? 0.3 : 0, SALTUS_BOTH);
        saltus_system *system = build(&spec);
        double start[2] = {0.1, 0};
        saltus_motion motion = settle_from(system, start);
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        check_recount(system, &motion);
        assert_true(motion.mirror == SALTUS_MIRROR_SELF || motion.mirror == SALTUS_MIRROR_PAIR);
        images += motion.mirror == SALTUS_MIRROR_SELF;
        if (motion.mirror == SALTUS_MIRROR_SELF) {
            assert_int_equal(motion.impacts_by_face[0], motion.impacts_by_face[1]);
            check_near(motion.largest, -motion.smallest, 1e-9);
        }
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
    assert_true(images >= 2);
}

/* An orbit sought with twice its period is described with its own; one of doubled period keeps that close to
 * its flip, 1e-2 to 1e-4 from its half. */
static void least_periods_are_told(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_two_periods), at;
    closed_orbit flip, orbit;
    saltus_motion motion;
    assert_true(closed_flip(&o, "omega", 0.92L, 0.95L, &flip));
    for (int digits = 4; digits <= 8; digits += 2) {
        double apart = 0.9 * pow(10, -0.5 * digits), far = 0;
        at = o;
        at.omega = flip.oscillator.omega + powl(0.1L, digits);
        assert_true(closed_orbit_at(&at, 1, &orbit) && orbit.multiplier[0][0] < -1);
        saltus_spec spec = closed_spec(&at);
        saltus_system *system = build(&spec);
        double guess[2] = {(double)orbit.state[0], (double)orbit.state[1]};
        for (int times = 1; times <= 3; times++) {
            motion = describe_from(system, 2 * times, guess);
            check_label(&motion, "1/2");
            check_near(motion.state[0], guess[0], 1e-9);
            check_near(motion.state[1], guess[1], 1e-9);
            assert_int_equal(motion.event_count, 1);
            assert_false(motion.stable);
            assert_true(motion.lyapunov > 0);
            saltus_motion_clear(&motion);
        }
        guess[0] += 2.75 * apart;
        guess[1] += 0.75 * apart;
        motion = describe_from(system, 4, guess);
        check_label(&motion, "2/4");
        for (int i = 0; i < 2; i++)
            far = fmax(far, fabs(motion.section_states[4 + i] - motion.state[i]));
        assert_true(far > 2 * apart);
        assert_true(motion.stable && motion.multipliers[0].re > 0);
        check_recount(system, &motion);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* An orbit that repeats after a part of its period but cannot be found with that period (one of a family, or
 * a drift too slow to be seen) is not described: the status is that of the search, and nothing must be freed.
 * With the period of the repetition it is described. */
static void a_least_period_that_is_not_found(void **unused) {
    (void)unused;
    for (int k = 0; k < 2; k++) {
        saltus_spec spec = oscillator_spec(0, k, k ? 1e-10 : 0.5, 1);
        if (k)
            add_stop(&spec, 1, 0.5, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        double state[2] = {0.2, 0}, monodromy[4] = {1, 0, 0, 1};
        saltus_multiplier multipliers[2] = {{1, 0, 0}, {1, 0, 0}};
        saltus_orbit orbit = {.dimension = 2,
                              .state = state,
                              .monodromy = monodromy,
                              .multipliers = multipliers},
                     found;
        saltus_orbit_options shooting = saltus_orbit_defaults();
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message finding = {.text = ""}, message = {.text = ""};
        saltus_motion motion;
        shooting.tolerance = 1e-11;
        const saltus_status status = saltus_orbit_find(system, 1, state, &shooting, &found, &finding);
        assert_true(k ? status != SALTUS_OK : status == SALTUS_SINGULAR);
        for (orbit.periods = 1; orbit.periods <= 3; orbit.periods++) {
            const saltus_status expected = orbit.periods == 1 ? SALTUS_OK : status;
            assert_int_equal(saltus_motion_describe(system, &orbit, &options, &motion, &message), expected);
            if (orbit.periods == 1) {
                check_label(&motion, "0/1");
                assert_memory_equal(motion.state, state, sizeof state);
            } else {
                assert_string_equal(message.text, finding.text);
                assert_true(!motion.state && !motion.events && motion.dimension == 0 && !motion.label[0]);
            }
            saltus_motion_clear(&motion);
        }
        saltus_system_free(system);
    }
}

/* Along a branch each point has the label, counts and events with which its orbit alone is described. */
static void branches_say_it_as_classification_does(void **unused) {
    (void)unused;
    const closed_oscillator starts[] = {
        closed_sticking_example(0.8L, -0.4L, 0), closed_sticking_example(0.4L, 0.2L, 0),
        closed_sticking_example(2.4L, 0, 0),     closed_sticking_example(0.8L, 0.2L, 0.3L),
        closed_example_of(closed_mirrored),      closed_example_of(closed_two_periods)};
    for (int k = 0; k < 6; k++) {
        closed_oscillator o = starts[k];
        saltus_branch_options options = saltus_branch_defaults();
        saltus_message message = {.text = ""};
        saltus_branch *branch;
        const saltus_branch_point *point;
        double start[2];
        int periods = o.periods, compared = 0;
        if (k < 4) {
            closed_sticking closed = closed_sticking_of(&o);
            periods = closed.periods;
            for (int i = 0; i < 2; i++)
                start[i] = (double)closed.state[0][i];
        } else {
            closed_orbit closed;
            o.omega = k == 4 ? 3.6L : 0.82L;
            assert_true(closed_orbit_at(&o, 1, &closed));
            for (int i = 0; i < 2; i++)
                start[i] = (double)closed.state[i];
        }
        saltus_spec spec = closed_spec(&o);
        strcpy(options.key[0], "omega");
        options.low[0] = (double)o.omega - 0.05;
        options.high[0] = (double)o.omega + 0.05;
        options.points = 5;
        options.step = options.step_max = 0.02;
        check_ok(saltus_branch_new(&spec, periods, start, &options, &branch, &message), &message);
        for (;;) {
            check_ok(saltus_branch_step(branch, &point, &message), &message);
            if (!point)
                break;
            if (point->kind != SALTUS_POINT_REGULAR || !point->admissible)
                continue;
            saltus_system *system = build(&point->spec);
            saltus_motion motion = describe_from(system, point->periods, point->state);
            assert_string_equal(point->label, motion.label);
            assert_int_equal(point->impacts, motion.impacts);
            assert_int_equal(point->sticking_intervals, motion.sticking_intervals);
            for (int e = 0; motion.impacts >= 0 && e < motion.event_count; e++) {
                assert_int_equal(point->event_count, motion.event_count);
                assert_int_equal(point->events[e].kind, motion.events[e].kind);
                check_near(saltus_time_periods(point->events[e].time),
                           saltus_time_periods(motion.events[e].time), 1e-8);
            }
            compared++;
            saltus_motion_clear(&motion);
            saltus_system_free(system);
        }
        assert_true(compared >= 3);
        saltus_branch_free(branch);
    }
}

/* Equilibria of an oscillator: where the spring holds it, with its exponent, and on a stop with the load's
 * force. */
static void rests_are_told(void **unused) {
    (void)unused;
    static const double dampings[] = {0.2, 5};
    double start[2] = {0.1, 0};
    for (int k = 0; k < 6; k++) {
        double c = dampings[k % 2], load = k < 2 ? 0 : 0.4, d = k < 4 ? 1 : 0.15, mass = k < 4 ? 2 : 1;
        saltus_spec spec = oscillator_spec(c, 2, 0, 1);
        set_parameter(&spec, "F0", load);
        set_parameter(&spec, "m", mass);
        add_stop(&spec, d, 0.5, load == 0 ? SALTUS_BOTH : SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_motion motion = settle_from(system, start);
        bool held = load / 2 > d;
        double place = held ? d : load / 2;
        check_label(&motion, held ? "held" : "equilibrium");
        assert_int_equal(motion.verdict, held ? SALTUS_HELD : SALTUS_EQUILIBRIUM);
        assert_true(saltus_verdict_settled(motion.verdict) && motion.stable);
        assert_int_equal(motion.periods, 0);
        assert_true(motion.impacts == 0 && motion.event_count == 0);
        check_near(motion.state[0], place, 1e-12);
        check_near(motion.state[1], 0, 1e-12);
        assert_true(motion.largest == motion.smallest);
        check_near(motion.largest, motion.state[0], 1e-15);
        check_near(motion.contact_force[0], held ? load - 2 * d : 0, 1e-12);
        assert_int_equal(motion.mirror, load == 0 ? SALTUS_MIRROR_SELF : SALTUS_MIRROR_NONE);
        double rate = c / (2 * mass), root = sqrt(fmax(0, rate * rate - 2 / mass));
        if (held)
            assert_true(motion.lyapunov == -INFINITY);
        else
            check_near(motion.lyapunov, root - rate, 1e-9);
        assert_true(motion.lyapunov_error == 0 && motion.residual <= 1e-11);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* Always pressed by a pulsating force: held, with the force at phase 0, and period 1. */
static void a_pulsating_load_holds(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 2, 0.3, 1.3);
    set_parameter(&spec, "F0", 1.5);
    add_stop(&spec, 0.4, 0.5, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    double start[2] = {0, 0};
    saltus_motion motion = settle_from(system, start);
    check_label(&motion, "held");
    assert_int_equal(motion.periods, 1);
    assert_true(motion.event_count == 0 && motion.sticking_intervals == 0 && motion.impacts == 0);
    check_near(motion.contact_force[0], 1.5 + 0.3 - 2 * 0.4, 1e-12);
    check_near(motion.state[0], 0.4, 1e-15);
    check_near(motion.largest, 0.4, 1e-15);
    check_near(motion.smallest, 0.4, 1e-15);
    assert_true(motion.sticks && motion.stable && saltus_verdict_settled(motion.verdict));
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

/* Only orbits and equilibria count as settled. */
static void what_has_settled(void **unused) {
    (void)unused;
    for (int k = 0; k < SALTUS_VERDICTS; k++)
        assert_int_equal(saltus_verdict_settled((saltus_verdict)k),
                         k == SALTUS_PERIODIC || k == SALTUS_EQUILIBRIUM || k == SALTUS_HELD);
}

/* Settling over whole periods does what the flow does, in one piece or several. */
static void settling_is_the_flow(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_one_period);
    saltus_spec spec = closed_spec(&o);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double whole[2] = {0.2, 0.1}, parts[2] = {0.2, 0.1}, end[2];
    saltus_flow *flow = open_flow(system, &options, 0, whole);
    check_ok(saltus_motion_settle(system, &options, 0, whole, &message), &message);
    assert_true(whole[0] == 0.2 && whole[1] == 0.1);
    check_ok(saltus_motion_settle(system, &options, 7, whole, &message), &message);
    check_ok(saltus_motion_settle(system, &options, 3, parts, &message), &message);
    check_ok(saltus_motion_settle(system, &options, 4, parts, &message), &message);
    advance(flow, 7, 0);
    saltus_flow_state(flow, 0, end);
    for (int i = 0; i < 2; i++) {
        assert_true(whole[i] == end[i]);
        check_near(parts[i], end[i], 1e-10);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Inputs that the flow refuses are refused everywhere, with a message; nothing must be freed, and the state
 * is unchanged. */
static void what_the_flow_refuses_is_refused(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_mirrored);
    closed_orbit closed;
    o.omega = 3.6L;
    assert_true(closed_orbit_at(&o, 1, &closed));
    saltus_spec spec = closed_spec(&o);
    saltus_system *system = build(&spec);
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    double state[2] = {(double)closed.state[0], (double)closed.state[1]}, beyond = 2 * (double)o.d;
    check_ok(saltus_orbit_find(system, 1, state, &shooting, &orbit, &message), &message);
    for (int k = 0; k < 3; k++) {
        saltus_classify_options options = saltus_classify_defaults();
        saltus_motion motion;
        saltus_attractors attractors;
        state[0] = k == 0 ? beyond : (double)closed.state[0];
        options.flow.rtol = k == 1 ? 0 : options.flow.rtol;
        options.flow.atol = k == 2 ? -1 : options.flow.atol;
        const double kept[2] = {state[0], state[1]};
        message = (saltus_message){.text = ""};
        assert_int_equal(saltus_classify(system, state, &options, &motion, &message), SALTUS_BAD_INPUT);
        assert_true(message.text[0] && !motion.state && !motion.events && motion.dimension == 0);
        saltus_motion_clear(&motion);
        assert_int_equal(saltus_motion_mirror(system, &options.flow, state, &message), SALTUS_BAD_INPUT);
        assert_int_equal(saltus_motion_settle(system, &options.flow, 1, state, &message), SALTUS_BAD_INPUT);
        assert_true(state[0] == kept[0] && state[1] == kept[1]);
        if (k == 0)
            continue;
        message = (saltus_message){.text = ""};
        assert_int_equal(saltus_motion_describe(system, &orbit, &options, &motion, &message),
                         SALTUS_BAD_INPUT);
        assert_true(message.text[0] && !motion.state && motion.dimension == 0);
        assert_int_equal(saltus_attractors_find(system, 3, 1, &options, &attractors, &message),
                         SALTUS_BAD_INPUT);
        assert_true(!attractors.motions && !attractors.shares && attractors.count == 0);
    }
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_orbits_are_told),
        cmocka_unit_test(loose_tolerances_find_the_same),
        cmocka_unit_test(pairs_are_each_others_images),
        cmocka_unit_test(a_pulsation_swings_in_two_periods),
        cmocka_unit_test(orbits_that_rest_are_told),
        cmocka_unit_test(chatter_is_told_wherever_the_section_lies),
        cmocka_unit_test(little_rebound_is_chatter),
        cmocka_unit_test(assorted_orbits_are_recounted),
        cmocka_unit_test(least_periods_are_told),
        cmocka_unit_test(a_least_period_that_is_not_found),
        cmocka_unit_test(branches_say_it_as_classification_does),
        cmocka_unit_test(rests_are_told),
        cmocka_unit_test(a_pulsating_load_holds),
        cmocka_unit_test(what_has_settled),
        cmocka_unit_test(settling_is_the_flow),
        cmocka_unit_test(what_the_flow_refuses_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
