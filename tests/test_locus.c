/* Curves of special points in two parameters: on the curves of closed forms, and, for two masses and the
 * pipe, with each point checked by an independent search.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "reference.h"

/* A curve in the plane of two parameters, from an orbit at the example's second parameter. */
typedef struct closed_curve {
    closed_example example;
    long double omega;
    saltus_point_kind kind;
    const char *key[2];
    double low[2], high[2];
} closed_curve;

static const closed_curve curves[] = {
    {closed_one_period, 1.1L, SALTUS_POINT_LP, {"omega", "d"}, {0.6, 0.5}, {1.8, 2}},
    {closed_one_period, 1.1L, SALTUS_POINT_PD, {"omega", "d"}, {0.6, 0.5}, {1.8, 2}},
    {closed_one_period, 1.1L, SALTUS_POINT_GR, {"omega", "d"}, {0.6, 0.5}, {1.8, 2}},
    {closed_one_period_loaded, 1.2L, SALTUS_POINT_LP, {"omega", "d"}, {0.8, 0.5}, {1.9, 2}},
    {closed_one_period_loaded, 1.2L, SALTUS_POINT_PD, {"omega", "d"}, {0.8, 0.5}, {1.9, 2}},
    {closed_one_period_loaded, 1.2L, SALTUS_POINT_GR, {"omega", "d"}, {0.8, 0.5}, {1.9, 2}},
    {closed_two_periods, 0.85L, SALTUS_POINT_LP, {"omega", "d"}, {0.78, -0.3}, {1.1, 0.3}},
    {closed_two_periods, 0.85L, SALTUS_POINT_PD, {"omega", "d"}, {0.78, -0.3}, {1.1, 0.3}},
    {closed_two_periods, 0.85L, SALTUS_POINT_GR, {"omega", "d"}, {0.78, -0.3}, {1.1, 0.3}},
    {closed_mirrored_bubble, 2.5L, SALTUS_POINT_LP, {"omega", "d"}, {1, 0.5}, {4, 2}},
    {closed_mirrored_bubble, 2.5L, SALTUS_POINT_GR, {"omega", "d"}, {1, 0.5}, {4, 2}},
    {closed_mirrored, 3.6L, SALTUS_POINT_BP, {"omega", "d"}, {2.3, 0.7}, {4, 1.4}},
    {closed_one_period, 1.1L, SALTUS_POINT_LP, {"omega", "r"}, {0.6, 0.6}, {1.8, 0.9}},
    {closed_one_period, 1.1L, SALTUS_POINT_PD, {"omega", "F"}, {0.6, 0.3}, {1.8, 0.6}},
    {closed_two_periods, 0.85L, SALTUS_POINT_PD, {"omega", "c"}, {0.6, 0.04}, {1.2, 0.12}},
    {closed_mirrored_bubble, 2.5L, SALTUS_POINT_LP, {"omega", "k"}, {1, 0.7}, {4, 1.3}},
    {closed_one_period_loaded, 1.2L, SALTUS_POINT_GR, {"omega", "F0"}, {0.8, 0}, {1.9, 0.3}},
    {closed_mirrored_bubble, 1.14L, SALTUS_POINT_BP, {"F", "omega"}, {0.8, 1}, {2, 1.6}},
};

static saltus_branch_options locus_options(saltus_point_kind kind, const char *const *key, const double *low,
                                           const double *high) {
    saltus_branch_options options = branch_along(key[0], low[0], high[0]);
    snprintf(options.key[1], sizeof options.key[1], "%s", key[1]);
    options.low[1] = low[1];
    options.high[1] = high[1];
    options.locus = kind;
    return options;
}

/* The closed form's special point near a place in the plane, sought along one parameter; returns the distance
 * along it, INFINITY if there is none. */
static double along_key(closed_oscillator o, const char *key, saltus_point_kind kind, closed_orbit *orbit) {
    long double value = *closed_value(&o, key);
    for (long double width = 1e-7L; width < 2e-3L; width *= 10) {
        long double lo = value - width, hi = value + 1.1L * width;
        bool there = kind == SALTUS_POINT_LP   ? closed_fold(&o, key, lo, hi, orbit)
                     : kind == SALTUS_POINT_PD ? closed_flip(&o, key, lo, hi, orbit)
                     : kind == SALTUS_POINT_BP ? closed_pitchfork(&o, key, lo, hi, orbit)
                                               : closed_grazing(&o, key, lo, hi, orbit);
        if (there)
            return (double)fabsl(*closed_value(&orbit->oscillator, key) - value);
    }
    return INFINITY;
}

/* The smaller of the distances along both parameters; without a grazing impact nearby, the distance of the
 * maximum between impacts from the stop. */
static double off_curve(const closed_oscillator *start, const closed_curve *c, const double *place,
                        closed_orbit *orbit) {
    closed_oscillator o = *start;
    closed_orbit found;
    for (int i = 0; i < 2; i++)
        *closed_value(&o, c->key[i]) = place[i];
    double first = along_key(o, c->key[0], c->kind, orbit), second = along_key(o, c->key[1], c->kind, &found);
    if (second < first)
        *orbit = found;
    double off = fmin(first, second);
    if (c->kind == SALTUS_POINT_GR && isinf(off) && closed_orbit_at(&o, 1, orbit))
        off = (double)fabsl(orbit->margin);
    return off;
}

static bool on_border(const closed_curve *c, const double *place) {
    for (int i = 0; i < 2; i++)
        if (place[i] == c->low[i] || place[i] == c->high[i])
            return true;
    return false;
}

/* A point lies on its curve, with its critical multiplier. */
static void check_on_curve(const closed_curve *c, const closed_oscillator *o,
                           const saltus_branch_point *point) {
    closed_orbit orbit = {.impacts = 0};
    double off = off_curve(o, c, point->value, &orbit);
    if (!(off < 1e-9))
        fail_msg("%s at %s = %.12g, %s = %.12g is %.3g off its curve", saltus_point_word(c->kind), c->key[0],
                 point->value[0], c->key[1], point->value[1], off);
    assert_true(point->admissible);
    if (point->kind == SALTUS_POINT_EP) {
        /* The curve ends at the range's border, or at grazing, where the impact's speed vanishes. */
        assert_true(on_border(c, point->value) || orbit.impact[0].speed < 1e-9L);
        return;
    }
    if (point->kind == SALTUS_POINT_GR_LP || point->kind == SALTUS_POINT_GR_PD) {
        assert_true(orbit.impact[0].speed < 1e-9L);
        return;
    }
    assert_int_equal(point->kind, c->kind);
    if (c->kind == SALTUS_POINT_GR || orbit.impact[0].speed < 1e-3L)
        return;
    check_near(point->multipliers[0].re, c->kind == SALTUS_POINT_PD ? -1 : 1, 1e-7);
    check_near(point->multipliers[1].re, (double)orbit.multiplier[1][0], 1e-7);
}

/* The specification has the point's parameters; arclength is measured in the plane, in units of the ranges;
 * steps are counted and no longer than requested. */
static void check_order(const saltus_branch_options *options, const branch_record *record) {
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *b = &record->point[k], *a = k ? b - 1 : NULL;
        double apart[2], length = 0;
        for (int i = 0; i < 2; i++) {
            saltus_direction direction;
            saltus_message message = {.text = ""};
            double value, unit = options->high[i] - options->low[i];
            check_ok(saltus_spec_direction(&b->spec, options->key[i], &direction, &value, &message),
                     &message);
            assert_true(value == b->value[i] && value >= options->low[i] && value <= options->high[i]);
            apart[i] = a ? (b->value[i] - a->value[i]) / unit : 0;
        }
        assert_int_equal(b->parent, -1);
        if (!a || a->branch != b->branch) {
            assert_int_equal(b->branch, a ? a->branch + 1 : 0);
            assert_int_equal(b->step, 0);
            assert_int_equal(b->kind, options->locus);
            assert_true(b->arclength == 0);
            assert_true(!a || a->kind == SALTUS_POINT_EP);
            continue;
        }
        assert_int_equal(b->step, a->step + 1);
        if (b->kind == SALTUS_POINT_EP) {
            assert_true(b->reason[0]);
            if (strstr(b->reason, "ends"))
                continue; /* the last point of the curve again */
        } else {
            assert_string_equal(b->reason, "");
        }
        /* The step is measured along the tangent, states included; its parts in the plane are the
         * headings'. */
        length = hypot(apart[0], apart[1]);
        double ahead = b->arclength - a->arclength, unit = options->high[0] - options->low[0];
        assert_true(length <= ahead * 1.1 && length <= options->step_max * 1.2);
        check_near(0.5 * (a->heading + b->heading) * ahead, b->value[0] - a->value[0], 0.05 * unit * ahead);
    }
}

static branch_record run_curve(const closed_curve *c, closed_oscillator *o,
                               const saltus_branch_options *options) {
    closed_orbit orbit;
    *o = closed_example_of(c->example);
    o->omega = c->omega;
    assert_true(closed_orbit_at(o, 1, &orbit) && orbit.admissible);
    saltus_spec spec = closed_spec(o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    return branch_run(&spec, o->periods, state, options);
}

static void curves_in_closed_form(void **unused) {
    (void)unused;
    skip_where_slow();
    for (size_t c = 0; c < sizeof curves / sizeof curves[0]; c++) {
        closed_oscillator o;
        int ways[2] = {0};
        saltus_branch_options options =
            locus_options(curves[c].kind, curves[c].key, curves[c].low, curves[c].high);
        branch_record record = run_curve(&curves[c], &o, &options);
        for (int k = 0; k < record.count; k++) {
            assert_in_range(record.point[k].branch, 0, 1);
            ways[record.point[k].branch]++;
            check_on_curve(&curves[c], &o, &record.point[k]);
        }
        for (int way = 0; way < 2; way++)
            assert_in_range(ways[way], 5, 2000);
        check_order(&options, &record);
        branch_forget(&record);
    }
}

/* A curve that leaves the range ends on its border to the last bit, even at values that are not round. */
static void borders_are_met_to_the_last_bit(void **unused) {
    (void)unused;
    unsigned long long seed = 5;
    int met = 0;
    for (int k = 0; k < 12; k++) {
        closed_curve c = curves[k % 2];
        closed_oscillator o;
        for (int i = 0; i < 4; i++) {
            seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
            double aside = 0.03 * (double)(seed >> 11) * 0x1p-53;
            (i % 2 ? c.low : c.high)[i / 2] += aside;
        }
        c.omega = k % 2 ? 1 : 1.56L;
        saltus_branch_options options = locus_options(c.kind, c.key, c.low, c.high);
        options.step = options.step_max = 0.06;
        branch_record record = run_curve(&c, &o, &options);
        for (int j = 0; j < record.count; j++)
            if (record.point[j].kind == SALTUS_POINT_EP && strstr(record.point[j].reason, "range")) {
                assert_true(on_border(&c, record.point[j].value));
                met++;
            }
        check_order(&options, &record);
        branch_forget(&record);
    }
    assert_true(met >= 12);
}

/* One way only, up or down in the second parameter, from a point found up or down along the first: the same
 * points as in both ways, and no more than requested. */
static void one_way(void **unused) {
    enum { count = 14 };
    (void)unused;
    for (int direction = 1; direction >= -1; direction -= 2) {
        closed_curve c = curves[direction > 0 ? 0 : 1];
        closed_oscillator o;
        c.omega = direction > 0 ? 1.56L : 1;
        saltus_branch_options options = locus_options(c.kind, c.key, c.low, c.high);
        options.step = options.step_max = 0.06;
        branch_record both = run_curve(&c, &o, &options);
        int from = 0;
        while (direction < 0 && both.point[from].branch == 0)
            from++;
        options.direction = direction;
        options.points = count;
        branch_record one = run_curve(&c, &o, &options);
        assert_int_equal(one.count, count);
        assert_true(direction * (one.point[1].value[1] - one.point[0].value[1]) > 0);
        for (int k = 0; k < count; k++)
            for (int i = 0; i < 2; i++)
                check_near(one.point[k].value[i], both.point[from + k].value[i], 1e-12);
        assert_int_equal(one.point[count - 1].kind, SALTUS_POINT_EP);
        assert_non_null(strstr(one.point[count - 1].reason, "as many points as asked for"));
        branch_forget(&one);
        branch_forget(&both);
    }
}

/* An interrupted curve of any kind continues with the same bits from any of its points. */
static void an_interrupted_curve_goes_on(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof curves / sizeof curves[0]; k++) {
        closed_curve c = curves[k];
        closed_oscillator o = closed_example_of(c.example);
        closed_orbit orbit;
        saltus_branch_options options = locus_options(c.kind, c.key, c.low, c.high);
        options.step = options.step_max = 0.06;
        o.omega = c.omega;
        assert_true(closed_orbit_at(&o, 1, &orbit));
        saltus_spec spec = closed_spec(&o);
        const double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
        assert_true(branch_check_resumed(&spec, o.periods, state, &options, 5) > 1);
    }
}

/* The same with complex pairs, corners on the way, and orbits cut into segments. */
static void an_interrupted_curve_of_the_pipe_goes_on(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {38.5, 0.0345}, high[2] = {42.2, 0.0361};
    reference r = read_reference("fig7d");
    for (int tori = 0; tori < 2; tori++) {
        saltus_branch_options options =
            locus_options(tori ? SALTUS_POINT_NS : SALTUS_POINT_GR, key, low, high);
        options.orbit.segments = tori ? 3 : 0;
        options.step_max = 0.04;
        options.direction = -1;
        assert_true(branch_check_resumed(&r.spec, r.periods, r.states[0], &options, 8) > 1);
    }
}

/* One damped degree of freedom has no complex pair on the unit circle: the search reports that none was
 * found. */
static void no_torus(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_one_period);
    closed_orbit orbit;
    const double low[2] = {0.6, 0.5}, high[2] = {1.8, 2};
    const char *const key[2] = {"omega", "d"};
    saltus_branch_options options = locus_options(SALTUS_POINT_NS, key, low, high);
    saltus_branch *branch = NULL;
    saltus_message message = {.text = ""};
    const saltus_branch_point *point;
    o.omega = 1.1L;
    assert_true(closed_orbit_at(&o, 1, &orbit));
    saltus_spec spec = closed_spec(&o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    check_ok(saltus_branch_new(&spec, 1, state, &options, &branch, &message), &message);
    assert_int_equal(saltus_branch_step(branch, &point, &message), SALTUS_NO_CONVERGENCE);
    assert_null(point);
    assert_non_null(strstr(message.text, "NS"));
    saltus_branch_free(branch);
}

/* Scenes without closed forms. */

/* The slowest impact speed of an orbit, or the speed that its nearest free maximum lacks to touch, in units
 * of the system's speeds. */
static double slowest_contact(const saltus_system *system, int periods, const double *state) {
    saltus_flow_options options = saltus_flow_defaults();
    double scale = saltus_system_scale(system)[saltus_system_dof(system)], slowest = INFINITY;
    double d = saltus_system_face(system, 0).d;
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (;;) {
        saltus_event event = advance(flow, periods, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING);
        if (event.kind == SALTUS_REACHED)
            break;
        if (event.kind == SALTUS_IMPACT)
            slowest = fmin(slowest, fabs(event.velocity_before));
        if (event.kind == SALTUS_TURNING && event.velocity_before < 0)
            slowest = fmin(slowest, sqrt(2 * fabs(event.velocity_before * (event.displacement - d))));
    }
    saltus_flow_free(flow);
    return slowest / scale;
}

/* The multiplier nearest to the unit circle. */
static const saltus_multiplier *critical(const saltus_orbit *orbit) {
    int nearest = 0;
    for (int i = 1; i < orbit->dimension; i++)
        if (fabs(orbit->multipliers[i].log_modulus) < fabs(orbit->multipliers[nearest].log_modulus))
            nearest = i;
    return &orbit->multipliers[nearest];
}

/* The orbit found again at the point's parameters is the same, with the multiplier or grazing of the point.
 * Close to grazing, where curves meet, multipliers are not determined. */
static void check_anew(const saltus_branch_point *point, saltus_point_kind kind) {
    saltus_system *system = build(&point->spec);
    double slowest = slowest_contact(system, point->periods, point->state);
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    if (kind == SALTUS_POINT_GR) {
        assert_true(slowest < 1e-6);
    } else if (slowest > 1e-4) {
        check_ok(saltus_orbit_find(system, point->periods, point->state, &options, &orbit, &message),
                 &message);
        for (int i = 0; i < point->dimension; i++)
            check_near(orbit.state[i] / saltus_system_scale(system)[i],
                       point->state[i] / saltus_system_scale(system)[i], 1e-9);
        const saltus_multiplier *mu = critical(&orbit);
        check_near(mu->log_modulus, 0, 1e-7);
        if (kind == SALTUS_POINT_NS)
            assert_true(fabs(mu->im) > 1e-3);
        else
            check_near(mu->re, kind == SALTUS_POINT_PD ? -1 : 1, 1e-7);
        saltus_orbit_clear(&orbit);
    }
    saltus_system_free(system);
}

static void check_curve_anew(const saltus_spec *spec, int periods, const double *state,
                             const saltus_branch_options *options, int least, bool closed) {
    branch_record record = branch_run(spec, periods, state, options);
    int checked = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *point = &record.point[k];
        if (point->kind == SALTUS_POINT_EP || point->kind >= SALTUS_POINT_CP)
            continue;
        assert_int_equal(point->kind, options->locus);
        assert_true(point->admissible);
        check_anew(point, options->locus);
        checked++;
    }
    assert_true(checked >= least);
    check_order(options, &record);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *point = &record.point[k], *first = point - point->step;
        bool back = strstr(point->reason, "closed") != NULL;
        if (point->kind != SALTUS_POINT_EP)
            continue;
        assert_int_equal(back, closed);
        if (back)
            for (int i = 0; i < 2; i++)
                check_near(point->value[i], first->value[i],
                           options->step_max * (options->high[i] - options->low[i]));
    }
    branch_forget(&record);
}

/* The motion that a scene settles on from rest. */
static saltus_motion settled(const saltus_spec *spec) {
    saltus_classify_options how = saltus_classify_defaults();
    saltus_system *system = build(spec);
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[4];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &how, &motion, &message), &message);
    saltus_system_free(system);
    return motion;
}

/* Two masses, one of which hits a stop: flips, and tori whose curve ends where their pair of multipliers
 * meets at -1. Beyond, the pair is real with product 1, and the orbit is not special. */
static void two_masses(void **unused) {
    (void)unused;
    static const struct {
        saltus_point_kind kind;
        const char *key[2];
        double low[2], high[2];
        bool closed;
    } rows[] = {{SALTUS_POINT_PD, {"m2", "k"}, {0.3, 0.05}, {3, 4}, true},
                {SALTUS_POINT_NS, {"omega", "c2"}, {1.4, 0.03}, {1.75, 0.1}, false},
                {SALTUS_POINT_NS, {"omega", "k2"}, {1.4, 0.7}, {1.75, 2.2}, false},
                {SALTUS_POINT_NS, {"omega", "m"}, {1.4, 0.7}, {1.75, 1.3}, false},
                {SALTUS_POINT_PD, {"omega", "d"}, {1.4, 0.4}, {1.75, 1.6}, false},
                {SALTUS_POINT_PD, {"omega", "r"}, {1.4, 0.3}, {1.75, 0.99}, false}};
    saltus_spec spec = oscillator_spec(0.035, 1, 1.1, 1.63);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "k2", 1.7);
    set_parameter(&spec, "c2", 0.07);
    add_stop(&spec, 1, 0.7, SALTUS_UPPER);
    spec.stops[0].weight[0] = 0;
    spec.stops[0].weight[1] = 1;
    saltus_motion motion = settled(&spec);
    assert_string_equal(motion.label, "1/2");
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_branch_options options = locus_options(rows[k].kind, rows[k].key, rows[k].low, rows[k].high);
        options.step_max = rows[k].closed ? 0.015 : 0.03;
        check_curve_anew(&spec, 2, motion.state, &options, 25, rows[k].closed);
    }
    saltus_motion_clear(&motion);
}

/* A curve of flips of the pipe and the curves that meet it, for several tests. */
typedef struct pipe_flips_network {
    reference reference;
    saltus_branch_options options;
    branch_record record;
} pipe_flips_network;

/* It is made when a test asks for it: the sanitized build's do not. */
static pipe_flips_network made;

static const pipe_flips_network *find_network(void) {
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {38, 0.034}, high[2] = {46, 0.036};
    if (made.record.count > 0)
        return &made;
    made.reference = read_reference("fig7d");
    made.options = locus_options(SALTUS_POINT_PD, key, low, high);
    made.options.switches = 1;
    made.options.step_max = 0.04;
    made.record =
        branch_run(&made.reference.spec, made.reference.periods, made.reference.states[0], &made.options);
    return &made;
}

static int drop_network(void **unused) {
    (void)unused;
    branch_forget(&made.record);
    return 0;
}

/* Where a curve of flips ends at grazing, the curve of grazing has a corner, found by other equations. */
static void curves_meet_at_corners(void **unused) {
    (void)unused;
    skip_where_slow();
    const pipe_flips_network *network = find_network();
    static const char *const turned[2] = {"d", "omega"};
    static const double from[2] = {0.034, 38}, to[2] = {0.0365, 46};
    const reference *r = &network->reference;
    saltus_branch_options other = locus_options(SALTUS_POINT_GR, turned, from, to);
    branch_record flips = network->record;
    other.step_max = 0.04;
    branch_record grazing = branch_run(&r->spec, r->periods, r->states[0], &other);
    int met = 0;
    for (int k = 0; k < flips.count; k++) {
        const double *at = flips.point[k].value;
        double nearest = INFINITY;
        if (flips.point[k].kind != SALTUS_POINT_GR_PD || flips.point[k].locus != SALTUS_POINT_PD)
            continue;
        for (int j = 0; j < grazing.count; j++)
            if (grazing.point[j].kind == SALTUS_POINT_GR_PD)
                nearest = fmin(nearest, fabs(grazing.point[j].value[0] - at[1]) / at[1] +
                                            fabs(grazing.point[j].value[1] - at[0]) / at[0]);
        check_near(nearest, 0, 1e-9);
        met++;
    }
    assert_int_equal(met, 2);
    branch_forget(&grazing);
}

/* How many switches lead to a branch. */
static int depth_of(const branch_record *record, int branch) {
    int depth = 0;
    for (int k = 0; k < record->count; k++)
        if (record->point[k].branch == branch && record->point[k].parent >= 0) {
            branch = record->point[k].parent;
            depth++;
            k = -1;
        }
    return depth;
}

/* Whether a curve of a kind passes a place. */
static bool passes(const branch_record *record, saltus_point_kind locus, const double *place) {
    for (int k = 0; k < record->count; k++)
        if (record->point[k].locus == locus && fabs(record->point[k].value[0] - place[0]) < 1e-8 &&
            fabs(record->point[k].value[1] - place[1]) < 1e-8)
            return true;
    return false;
}

/* Points name their curve's kind. Where curves meet all have been followed up to the allowed depth, and none
 * twice: no two leave the range at one place. */
static void check_network(const branch_record *record, const saltus_branch_options *options) {
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k];
        int depth = depth_of(record, p->branch);
        assert_true(depth <= options->switches);
        assert_true(depth > 0 || p->locus == options->locus);
        if (p->kind < SALTUS_POINT_CP && p->kind != SALTUS_POINT_EP)
            assert_int_equal(p->kind, p->locus);
        for (int j = 0; j < k && p->kind == SALTUS_POINT_EP && strstr(p->reason, "range"); j++) {
            const saltus_branch_point *q = &record->point[j];
            bool ends = q->kind == SALTUS_POINT_EP && strstr(q->reason, "range") && q->locus == p->locus;
            assert_false(ends && fabs(p->value[0] - q->value[0]) < 1e-7 &&
                         fabs(p->value[1] - q->value[1]) < 1e-7);
        }
        if (depth == options->switches)
            continue;
        bool grazes = p->kind >= SALTUS_POINT_GR_LP && p->kind <= SALTUS_POINT_GR_BP;
        if (grazes)
            assert_true(passes(record, SALTUS_POINT_GR, p->value));
        if (p->kind == SALTUS_POINT_GR_LP)
            assert_true(passes(record, SALTUS_POINT_LP, p->value));
        if (p->kind == SALTUS_POINT_GR_PD)
            assert_true(passes(record, SALTUS_POINT_PD, p->value));
        if (p->kind == SALTUS_POINT_GR_NS)
            assert_true(passes(record, SALTUS_POINT_NS, p->value));
        if (p->kind == SALTUS_POINT_GR_BP)
            assert_true(passes(record, SALTUS_POINT_BP, p->value));
    }
}

/* Whether two points lie at the same place of the plane. */
static bool at_one_place(const saltus_branch_point *p, const saltus_branch_point *q) {
    return fabs(q->value[0] / p->value[0] - 1) < 1e-8 && fabs(q->value[1] / p->value[1] - 1) < 1e-8;
}

/* The sine of the angle at which two curves leave one place: the curve that begins at `first`, and one of
 * another kind. */
static double turn_between(const branch_record *record, const saltus_branch_options *options,
                           const saltus_branch_point *first, saltus_point_kind other) {
    double smallest = INFINITY;
    for (int k = 1; k + 1 < record->count; k++) {
        const saltus_branch_point *q = &record->point[k];
        bool begins = q->step == 0;
        if (q->locus != other || !at_one_place(first, q) || (!begins && at_one_place(q, q - 1)))
            continue;
        double way[2][2];
        for (int i = 0; i < 2; i++) {
            double unit = options->high[i] - options->low[i];
            way[0][i] = (first[1].value[i] - first->value[i]) / unit;
            way[1][i] = (q[begins ? 1 : -1].value[i] - q->value[i]) / unit;
        }
        smallest = fmin(smallest, fabs(way[0][0] * way[1][1] - way[0][1] * way[1][0]) /
                                      (hypot(way[0][0], way[0][1]) * hypot(way[1][0], way[1][1])));
    }
    return smallest;
}

/* Where flips meet grazing two curves of grazing are followed: of the orbits without impact whose amplitude
 * is the gap, and of the orbits of twice the period with one impact and another touch; the latter leaves
 * along the curve of flips. */
static void corners_start_grazing(void **unused) {
    (void)unused;
    closed_curve c = curves[1];
    closed_oscillator o;
    closed_orbit orbit;
    saltus_branch_options options = locus_options(c.kind, c.key, c.low, c.high);
    options.switches = 1;
    branch_record record = run_curve(&c, &o, &options);
    int grazing[3] = {0}, ends = 0;
    check_network(&record, &options);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        long double phase;
        if (p->locus != SALTUS_POINT_GR)
            continue;
        o.omega = p->value[0];
        o.periods = p->periods;
        if (p->periods == 1)
            check_near((double)closed_amplitude(&o, &phase), p->value[1], 1e-9);
        else if (p->step > 0) {
            o.d = p->value[1];
            assert_true(closed_orbit_at(&o, 1, &orbit));
            check_near((double)orbit.margin, 0, 1e-9);
        } else
            check_near(turn_between(&record, &options, p, SALTUS_POINT_PD), 0, 0.02);
        ends += p->kind == SALTUS_POINT_EP && on_border(&c, p->value) && p->periods == 1;
        grazing[p->periods]++;
    }
    assert_true(grazing[1] > 20 && grazing[2] > 20);
    assert_int_equal(ends, 2);
    branch_forget(&record);
}

/* The curves of a kind leave the range at the same places in both runs. */
static void check_same_ends(const branch_record *one, const branch_record *other, saltus_point_kind locus,
                            int expected) {
    int ends = 0;
    for (int k = 0; k < one->count; k++) {
        const saltus_branch_point *p = &one->point[k];
        double nearest = INFINITY;
        if (p->locus != locus || p->kind != SALTUS_POINT_EP || !strstr(p->reason, "range"))
            continue;
        for (int j = 0; j < other->count; j++) {
            const saltus_branch_point *q = &other->point[j];
            if (q->locus == locus && q->kind == SALTUS_POINT_EP)
                nearest =
                    fmin(nearest, fabs(q->value[0] / p->value[0] - 1) + fabs(q->value[1] / p->value[1] - 1));
        }
        check_near(nearest, 0, 1e-10);
        ends++;
    }
    assert_int_equal(ends, expected);
}

/* The pipe: the curve of flips has a double multiplier -1 twice, where tori begin, and meets grazing twice.
 * The curve of grazing is the one found directly. */
static void corners_start_the_curves_that_meet_there(void **unused) {
    (void)unused;
    skip_where_slow();
    const pipe_flips_network *network = find_network();
    const reference *r = &network->reference;
    const branch_record *record = &network->record;
    int count[SALTUS_POINT_KINDS] = {0};
    check_network(record, &network->options);
    for (int k = 0; k < record->count; k++)
        count[record->point[k].locus] += record->point[k].step == 0;
    assert_true(count[SALTUS_POINT_PD] == 2 && count[SALTUS_POINT_GR] == 3 && count[SALTUS_POINT_NS] == 4);
    for (int k = 0; k < record->count; k += 3)
        if (record->point[k].kind == SALTUS_POINT_NS)
            check_anew(&record->point[k], SALTUS_POINT_NS);
    saltus_branch_options alone = network->options;
    alone.locus = SALTUS_POINT_GR;
    alone.switches = 0;
    branch_record grazing = branch_run(&r->spec, r->periods, r->states[0], &alone);
    check_same_ends(&grazing, record, SALTUS_POINT_GR, 2);
    branch_forget(&grazing);
}

/* An oscillator whose folds, flips and grazings meet. */
static saltus_spec meeting_curves(void) {
    saltus_spec spec = oscillator_spec(0.12504, 1, 1.1739, 2.0486);
    set_parameter(&spec, "F0", 0.11951);
    add_stop(&spec, 0.42605, 0.40661, SALTUS_UPPER);
    return spec;
}

/* Grazing of orbits of two periods with one impact left ends where that impact vanishes too. There the
 * response sin(w T) of the orbit of one period to an impact, w the damped frequency, is zero: omega = 2 w,
 * and the gap is the orbit's amplitude. The curves of grazing and of flips of the orbits of one period pass
 * there. */
static void check_join(const branch_record *record, int k) {
    const saltus_branch_point *p = &record->point[k];
    const long double c = 0.12504L, omega = 2 * sqrtl(1 - c * c / 4), square = omega * omega;
    assert_true(p->kind == SALTUS_POINT_GR_PD && p->locus == SALTUS_POINT_GR && p->periods == 2);
    check_near(p->value[0], (double)omega, 1e-10);
    check_near(p->value[1],
               (double)(0.11951L + 1.1739L / sqrtl((1 - square) * (1 - square) + c * c * square)), 1e-10);
    for (int flips = 0; flips < 2; flips++) {
        saltus_point_kind locus = flips ? SALTUS_POINT_PD : SALTUS_POINT_GR;
        bool found = false;
        for (int j = 0; j < record->count; j++) {
            const saltus_branch_point *q = &record->point[j];
            found |= q->locus == locus && q->periods == 1 && q->step == 0 &&
                     fabs(q->value[0] - p->value[0]) < 1e-9 && fabs(q->value[1] - p->value[1]) < 1e-9;
        }
        assert_true(found);
    }
}

/* Folds, flips and grazings of an oscillator and of its period-doubled orbits meet in many points, in some of
 * which two impacts graze. Each curve is followed once and ends at a border, at a named point or where such
 * points accumulate. Every grazing orbit touches its stop. */
static void networks_of_curves(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {1.2292, 0.12782}, high[2] = {3.2778, 0.85211};
    saltus_spec spec = meeting_curves();
    saltus_motion motion = settled(&spec);
    int curves_at[3] = {0}, found[SALTUS_POINT_KINDS] = {0}, joins = 0;
    /* The first fold is on the branch of doubled period. */
    for (int switches = 1; switches < 3; switches++) {
        saltus_branch_options options = locus_options(SALTUS_POINT_LP, key, low, high);
        options.switches = switches;
        options.step_max = 0.03;
        branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
        check_network(&record, &options);
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            curves_at[switches] += p->step == 0;
            found[p->kind] += switches == 2;
            if (p->kind == SALTUS_POINT_EP && !strstr(p->reason, "range"))
                assert_true(p[-1].kind >= SALTUS_POINT_CP && p[-1].branch == p->branch);
            if (strstr(p->reason, "half the period") && switches == 2) {
                check_join(&record, k - 1);
                joins++;
            }
            if (p->kind == SALTUS_POINT_GR) {
                saltus_system *own = build(&p->spec);
                /* The speed goes as the square root of the gap. */
                check_near(pow(slowest_contact(own, p->periods, p->state), 2), 0, 1e-9);
                saltus_system_free(own);
            }
        }
        branch_forget(&record);
    }
    assert_true(curves_at[1] > 2 && curves_at[2] > curves_at[1]);
    assert_int_equal(joins, 1);
    assert_true(found[SALTUS_POINT_GR_LP] > 4 && found[SALTUS_POINT_GR_PD] > 4 &&
                found[SALTUS_POINT_GR_GR] > 1);
    saltus_motion_clear(&motion);
}

/* The smallest distance of a free maximum from the stop, in the system's scale. */
static double nearest_maximum(const saltus_branch_point *point) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = build(&point->spec);
    saltus_flow *flow = open_flow(system, &options, 0, point->state);
    double nearest = INFINITY, d = saltus_system_face(system, 0).d;
    long long impacts = 0;
    for (saltus_event event = {.kind = SALTUS_TURNING}; event.kind != SALTUS_REACHED;) {
        event = advance(flow, point->periods, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING);
        impacts += event.kind == SALTUS_IMPACT;
        if (event.kind == SALTUS_TURNING && event.velocity_before < 0)
            nearest = fmin(nearest, fabs(event.displacement - d) / saltus_system_scale(system)[0]);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
    /* At a maximum on the stop rounding decides between a turning point and one more impact. */
    return impacts > point->impacts ? 0 : nearest;
}

/* A fold of orbits with a long run of impacts: after the last one another is about to be born, closer to the
 * stop than any tolerance. The curve of folds ends where that maximum touches. */
static void folds_end_in_long_runs(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {4.54986, 0.0138054}, high[2] = {9.09972, 0.0368144};
    saltus_spec spec = pipe_spec(1, 6.4998);
    set_parameter(&spec, "alpha", 0.003635);
    add_stop(&spec, 0.023009, 0.43493, SALTUS_UPPER);
    saltus_motion motion = settled(&spec);
    saltus_branch_options options = locus_options(SALTUS_POINT_LP, key, low, high);
    options.direction = 1;
    branch_record folds = branch_run(&spec, motion.periods, motion.state, &options);
    const saltus_branch_point *corner = &folds.point[folds.count - 2];
    assert_int_equal(corner->kind, SALTUS_POINT_GR_LP);
    assert_int_equal(corner[1].kind, SALTUS_POINT_EP);
    for (int k = 0; k < folds.count; k++) {
        const saltus_branch_point *p = &folds.point[k];
        check_near(p->multipliers[0].re, 1, 1e-6);
        if (p < corner)
            assert_true(nearest_maximum(p) > 1e-11);
        else
            check_near(nearest_maximum(p), 0, 1e-13);
    }
    branch_forget(&folds);
    saltus_motion_clear(&motion);
}

/* A curve of grazing in four pieces, joined where two impacts graze, is closed and followed once around. */
static void a_polygon_of_grazings_is_closed(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {1.67064, 0.092649}, high[2] = {4.45504, 0.61766};
    saltus_spec spec = oscillator_spec(0.071149, 1, 1.4735, 2.7844);
    set_parameter(&spec, "F0", 0.14981);
    add_stop(&spec, 0.30883, 0.86455, SALTUS_UPPER);
    saltus_motion motion = settled(&spec);
    saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
    options.switches = 1;
    branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
    check_network(&record, &options);
    const saltus_branch_point *last = &record.point[record.count - 1], *first = last - last->step;
    assert_non_null(strstr(last->reason, "closed"));
    int corners = 0;
    for (const saltus_branch_point *p = first; p <= last; p++) {
        corners += p->kind == SALTUS_POINT_GR_GR;
        for (const saltus_branch_point *q = first; q < p && p < last - 1; q++)
            assert_false(p->kind == SALTUS_POINT_GR_GR && p->value[0] == q->value[0]);
    }
    assert_int_equal(corners, 4);
    for (int i = 0; i < 2; i++)
        check_near(last->value[i], first->value[i], 1e-10);
    assert_true(branch_check_resumed(&spec, motion.periods, motion.state, &options, 27) > 1);
    branch_forget(&record);
    saltus_motion_clear(&motion);
}

/* The relative distance from a place to the nearest point of a kind on curves of the kind `locus`. */
static double nearest_of(const branch_record *record, saltus_point_kind kind, saltus_point_kind locus,
                         double first, double second) {
    double nearest = INFINITY;
    for (int k = 0; k < record->count; k++)
        if (record->point[k].kind == kind && record->point[k].locus == locus)
            nearest = fmin(nearest, fabs(record->point[k].value[0] / first - 1) +
                                        fabs(record->point[k].value[1] / second - 1));
    return nearest;
}

static const saltus_branch_point *first_of(const branch_record *record, saltus_point_kind kind,
                                           saltus_point_kind locus) {
    for (int k = 0; k < record->count; k++)
        if (record->point[k].kind == kind && record->point[k].locus == locus)
            return &record->point[k];
    fail_msg("no %s on a curve of %s", saltus_point_word(kind), saltus_point_word(locus));
    return NULL;
}

/* Two masses that hit each other. */
static saltus_spec hitting_masses(void) {
    saltus_spec spec = oscillator_spec(0.1379, 1, 1.1, 0.6546);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "m2", 2.9486);
    set_parameter(&spec, "k2", 3.859);
    set_parameter(&spec, "c2", 0.065);
    add_stop(&spec, 0.8867, 0.7901, SALTUS_UPPER);
    spec.stops[0].weight[0] = 1;
    spec.stops[0].weight[1] = -1;
    return spec;
}

/* Two such masses under a force, with a grazing orbit. */
typedef struct grazing_masses {
    double F, c, m2, c2, k2, r, omega, d, state[4];
} grazing_masses;

/* Follow the curve of grazing of these orbits with two largest steps. */
static void follow_twice(const grazing_masses *row, int periods, const saltus_branch_options *options,
                         const double step_max[2], branch_record record[2]) {
    saltus_spec spec = hitting_masses();
    set_parameter(&spec, "F", row->F);
    set_parameter(&spec, "c", row->c);
    set_parameter(&spec, "m2", row->m2);
    set_parameter(&spec, "c2", row->c2);
    set_parameter(&spec, "k2", row->k2);
    set_parameter(&spec, "omega", row->omega);
    spec.stops[0].d = row->d;
    spec.stops[0].r = row->r;
    for (int run = 0; run < 2; run++) {
        saltus_branch_options own = *options;
        own.step_max = step_max[run];
        record[run] = branch_run(&spec, periods, row->state, &own);
    }
}

/* Both runs have the same corners; returns how many there are of a kind (SALTUS_POINT_REGULAR: of any), in
 * both together. */
static int same_corners(const branch_record record[2], saltus_point_kind kind) {
    int found = 0;
    for (int run = 0; run < 2; run++)
        for (int k = 0; k < record[run].count; k++) {
            const saltus_branch_point *p = &record[run].point[k];
            if (p->kind < SALTUS_POINT_CP || p->kind == SALTUS_POINT_EP)
                continue;
            found += kind == SALTUS_POINT_REGULAR || p->kind == kind;
            check_near(nearest_of(&record[1 - run], p->kind, p->locus, p->value[0], p->value[1]), 0, 1e-9);
        }
    return found;
}

/* Along a curve of grazing multipliers change fast, and pairs that leave the unit circle return: long steps
 * find exactly the corners of short ones. */
static void long_steps_pass_no_torus(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {0.3, 0.02}, high[2] = {2, 4}, step_max[2] = {0.02, 0.1};
    static const grazing_masses rows[] = {
        {1.1,
         0.12282240196421325,
         2.2628832070365767,
         0.022996186046293284,
         1.9636738144529202,
         0.58107855495315452,
         0.65068374448158339,
         0.80766701245276507,
         {-0.84560997562796314, -1.6519539252958104, 0.039754100857746784, 0.069822715841760627}},
        {1.1,
         0.020621213386250187,
         2.3052456796017129,
         0.13206690301425605,
         3.5340886291285512,
         0.57975317882570443,
         0.63285477755059782,
         0.59781987679158877,
         {-1.6902923313345002, -2.2881071161722111, 0.038664332862463367, 0.040225845638947932}}};
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        branch_record record[2];
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        follow_twice(&rows[row], 1, &options, step_max, record);
        int found = 0;
        for (int run = 0; run < 2; run++)
            for (int k = 0; k < record[run].count; k++) {
                const saltus_branch_point *p = &record[run].point[k];
                if (p->kind != SALTUS_POINT_GR_NS)
                    continue;
                found++;
                check_near(nearest_of(&record[1 - run], p->kind, p->locus, p->value[0], p->value[1]), 0,
                           1e-7);
            }
        assert_true(found > 4 && record[1].count < record[0].count);
        branch_forget(&record[0]);
        branch_forget(&record[1]);
    }
}

/* Under slow forcing multipliers rotate with each free oscillation in a period: with steps of twice the
 * length the same folds, flips and pairs meet grazing. */
static void slow_forcing_hides_no_corner(void **unused) {
    (void)unused;
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {-0.5, 0.3}, high[2] = {4, 2}, step_max[2] = {0.01, 0.02};
    static const grazing_masses rows[] = {
        {1,
         0.19374358547938214,
         1.0291367344803528,
         0.11567891057359382,
         1.4740381742942446,
         0.8945357806651293,
         0.42025678504957154,
         0.22612320869874986,
         {1.5946182613467028, 1.817461515241145, 0.08961065190426751, 0.10573772721283964}},
        {1,
         0.19247768836710913,
         1.350921475190987,
         0.02307009912804732,
         3.9958919610187436,
         0.5737014582811413,
         0.54471047585839,
         0.4005766420013232,
         {3.3273370595495124, 3.697785696689828, 0.738285497003844, 0.8213059736912839}}};
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        branch_record record[2];
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        options.direction = -1;
        follow_twice(&rows[row], 1, &options, step_max, record);
        assert_true(same_corners(record, SALTUS_POINT_REGULAR) > 10 && record[1].count < record[0].count);
        branch_forget(&record[0]);
        branch_forget(&record[1]);
    }
}

/* Where a multiplier passes through infinity, a pair leaves the unit circle, becomes real, and returns past 1
 * or -1 at once: the product over pairs keeps its sign, and only the number inside the circle tells. */
static void pairs_beside_infinity_are_found(void **unused) {
    (void)unused;
    skip_unless_long();
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {-0.5, 0.42}, high[2] = {4, 2.4}, step_max[2] = {0.01, 0.02};
    static const grazing_masses rows[] = {
        {1.11006,
         0.113099,
         0.326711,
         0.0454107,
         3.29767,
         0.510226,
         1.82794,
         0.1379589406847085,
         {-0.2785278875387858, -0.416460653568262, 0.029098148890993727, 0.0340103002948454}},
        {1.08122,
         0.129419,
         0.715479,
         0.121365,
         3.69092,
         0.356253,
         1.06467,
         0.2573906379571963,
         {-0.9077113940397181, -1.1642635025404366, 0.12200272285219604, 0.14410472155166687}}};
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        branch_record record[2];
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        options.direction = -1;
        options.points = 4000;
        follow_twice(&rows[row], 1, &options, step_max, record);
        assert_true(same_corners(record, SALTUS_POINT_GR_NS) > 6);
        branch_forget(&record[0]);
        branch_forget(&record[1]);
    }
}

/* Grazing orbits of three periods become orbits of one period, which thus graze three times: their curve ends
 * there, on the curve of grazing of the shorter orbits, at the same place for all steps. */
static void curves_of_grazing_join_those_of_a_third(void **unused) {
    (void)unused;
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {-0.5, 0.3}, high[2] = {4, 2.4}, step_max[2] = {0.01, 0.02};
    static const grazing_masses rows[] = {
        {1.16108,
         0.0748201,
         2.24241,
         0.0180169,
         1.23318,
         0.782939,
         0.786252,
         0.350623,
         {-0.43018668049665354, -0.6934990334474017, 0.4113933818867015, -0.4281699717641522}},
        {0.672012,
         0.0352322,
         1.64707,
         0.132963,
         0.324558,
         0.514503,
         1.61762,
         0.385312,
         {0.028949234814749796, 1.5107778352193575, 0.9562487131592474, 0.0014626424361016239}}};
    /* The first one's curves are long. */
    for (size_t row = long_version() ? 0 : 1; row < sizeof rows / sizeof rows[0]; row++) {
        branch_record record[2];
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        follow_twice(&rows[row], 3, &options, step_max, record);
        same_corners(record, SALTUS_POINT_REGULAR);
        int joins = 0;
        for (int run = 0; run < 2; run++)
            for (int k = 0; k < record[run].count; k++) {
                const saltus_branch_point *end = &record[run].point[k];
                if (!strstr(end->reason, "part of the period"))
                    continue;
                joins++;
                assert_int_equal(end->kind, SALTUS_POINT_EP);
                assert_int_equal(end[-1].kind, SALTUS_POINT_GR_GR);
                saltus_branch_options own = options;
                own.points = 3;
                branch_record shorter = branch_run(&end->spec, 1, end->state, &own);
                check_near(
                    nearest_of(&shorter, SALTUS_POINT_GR, SALTUS_POINT_GR, end->value[0], end->value[1]), 0,
                    1e-8);
                branch_forget(&shorter);
            }
        assert_int_equal(joins, row ? 2 : 4);
        branch_forget(&record[0]);
        branch_forget(&record[1]);
    }
}

/* Orbits of four periods lose the speeds of all their impacts but one to first order, where an orbit of one
 * period grazes: each impact undoes what the others do, and the orbit's halves are alike to second order.
 * Their curve ends there, where those of shorter orbits end. */
static void all_impacts_die_at_once(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {0.774503, 0.457195}, high[2] = {2.47841, 1.21919},
                        step_max[2] = {0.02, 0.01}, state[] = {1.0873439329355987, 0.448973399209425};
    saltus_spec spec = oscillator_spec(0.046, 1, 1, 0.761991);
    add_stop(&spec, 1.54901, 0.489292, SALTUS_UPPER);
    add_stop(&spec, 1.54901, 0.483529, SALTUS_LOWER);
    for (int run = 0; run < 2; run++) {
        saltus_branch_options options = locus_options(SALTUS_POINT_PD, key, low, high);
        options.switches = 2;
        options.step_max = step_max[run];
        branch_record record = branch_run(&spec, 1, state, &options);
        const saltus_branch_point *flip = first_of(&record, SALTUS_POINT_GR_PD, SALTUS_POINT_PD);
        int ends = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            if (p->kind != SALTUS_POINT_EP || p->periods != 4)
                continue;
            assert_true(p[-1].kind == SALTUS_POINT_GR_GR);
            for (int i = 0; i < 2; i++)
                check_near(p->value[i], flip->value[i], 1e-9);
            ends++;
        }
        assert_int_equal(ends, 2);
        branch_forget(&record);
    }
}

/* A branch of orbits of three periods begins where an orbit of one period grazes: the curve of grazing of
 * that orbit is followed, not of its threefold repetition, in which any impact could be born or die. */
static void a_shorter_orbit_grazes_once(void **unused) {
    (void)unused;
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {-0.5, 0.3}, high[2] = {4, 2.4};
    static const double state[] = {1.6644267151650356, -1.3355986012213794};
    saltus_spec spec = oscillator_spec(0.0203996, 1, 0.5, 0.905356);
    add_stop(&spec, 1.76408, 0.742446, SALTUS_UPPER);
    saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
    branch_record record = branch_run(&spec, 3, state, &options);
    int ends = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        assert_int_equal(p->periods, 1);
        assert_true(p->kind != SALTUS_POINT_GR_GR);
        if (p->kind != SALTUS_POINT_EP)
            continue;
        ends++;
        assert_string_equal(p->reason, "end of the parameters' range");
    }
    assert_int_equal(ends, 2);
    branch_forget(&record);
}

/* Two corners of a kind closer together than steps are long leave the signs of their test functions
 * unchanged: steps of either length find both. */
static void close_corners_are_told_apart(void **unused) {
    (void)unused;
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {-1.5, 0.3}, high[2] = {3, 2}, step_max[2] = {0.01, 0.02};
    static const double state[] = {-1.0491482613244538, 0.3026843690337992};
    saltus_spec spec = oscillator_spec(0.0149699, 1, 0.232547, 1.2007);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, -1.036585607614276, 0.803199, SALTUS_UPPER);
    branch_record record[2];
    saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
    options.direction = -1;
    for (int run = 0; run < 2; run++) {
        options.step_max = step_max[run];
        record[run] = branch_run(&spec, 1, state, &options);
    }
    assert_true(same_corners(record, SALTUS_POINT_GR_LP) > 10);
    branch_forget(&record[0]);
    branch_forget(&record[1]);
}

/* Without its stop the pipe is its own mirror image, and so may its orbits be: where others branch off a
 * curve of grazing crosses theirs, and its equations are singular. The place is as sharp as any, and no fold.
 * Where the pipe is free the stop does not matter: the branch points are at one frequency. The orbits that
 * branch off, and their images, graze on both sides of there. */
static void grazing_passes_a_crossing(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {0.005, 10}, high[2] = {0.08, 60}, step_max[2] = {0.01, 0.02};
    static const double state[] = {-0.043541447763617534, -0.34106758705984724};
    saltus_spec spec = pipe_spec(1, 32.2089);
    set_parameter(&spec, "u0", 3.82929);
    set_parameter(&spec, "sigma", 0.316321);
    set_parameter(&spec, "alpha", 0.00331081);
    add_stop(&spec, 0.04768315347851244, 0.429931, SALTUS_UPPER);
    branch_record record[2];
    saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
    options.direction = -1;
    for (int run = 0; run < 2; run++) {
        options.step_max = step_max[run];
        record[run] = branch_run(&spec, 2, state, &options);
    }
    assert_true(same_corners(record, SALTUS_POINT_GR_LP) > 6);
    assert_int_equal(same_corners(record, SALTUS_POINT_GR_BP), 4);
    branch_forget(&record[0]);
    branch_forget(&record[1]);
    options.switches = 1;
    options.low[1] = 19;
    record[0] = branch_run(&spec, 2, state, &options);
    double place = NAN;
    int broken = 0, free = 0;
    for (int k = 0; k < record[0].count; k++) {
        const saltus_branch_point *p = &record[0].point[k];
        place = p->kind == SALTUS_POINT_GR_BP ? p->value[1] : place;
        if (p->locus == SALTUS_POINT_BP)
            check_near(p->value[1], place, 1e-10);
        free += p->locus == SALTUS_POINT_BP && p->kind == SALTUS_POINT_EP && p->value[0] == high[0];
        broken += p->locus == SALTUS_POINT_GR && p->parent >= 0 && p->step == 0 && p->value[1] == place;
    }
    assert_true(free == 1 && broken == 2);
    branch_forget(&record[0]);
}

/* Stops at one distance to both sides that rebound differently: the scene is not symmetric, but the motion
 * that only touches them is, and touches both. Of orbits that hit one and touch the other there are two
 * curves, which begin on that of free motion where half a period is a whole number of free oscillations. */
static void grazing_joins_a_symmetric_motion(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {1, 0.4}, high[2] = {1.6, 0.7}, step_max[] = {0.02, 0.01, 0.005};
    static const double c[] = {0.236, 0.226};
    for (int row = 0; row < 2; row++) {
        saltus_spec spec = oscillator_spec(c[row], 1, 1, 0.568947);
        add_stop(&spec, 1.32534, row ? 0.884679 : 0.415591, SALTUS_UPPER);
        add_stop(&spec, 1.32534, row ? 0.932972 : 0.638022, SALTUS_LOWER);
        saltus_motion motion = settled(&spec);
        const double square = 0.25 * (1 - 0.25 * c[row] * c[row]), omega = sqrt(square);
        const double d = 1 / hypot(1 - square, c[row] * omega);
        for (int run = 0; run < 3; run++) {
            saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
            options.switches = 1;
            options.step_max = step_max[run];
            branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
            int joins = 0, hits = 0, touches = 0, parent = -1;
            for (int k = 0; k < record.count; k++) {
                const saltus_branch_point *p = &record.point[k];
                if (p->kind == SALTUS_POINT_GR_BP) {
                    check_near(p->value[0], d, 1e-9);
                    check_near(p->value[1], omega, 1e-9);
                    parent = p->branch;
                    joins++;
                }
                if (parent < 0 || p->parent != parent || p->locus != SALTUS_POINT_GR || p->step < 3)
                    continue;
                const double at = p->value[1], off = p->value[0] - 1 / hypot(1 - at * at, c[row] * at);
                hits += fabs(off) > 1e-6 && p->grazing_side < 0 && p->step == 3;
                touches += fabs(off) < 1e-9 && p->step == 3;
            }
            assert_true(joins == 1 && hits == 1 && touches == 2);
            branch_forget(&record);
        }
        saltus_motion_clear(&motion);
    }
}

/* The same where both stops rebound alike. Of the orbits that hit one stop a branch ends where they graze
 * both; their folds end on the branch points of those that hit both, and do not come back as their mirror
 * images. All is so whatever the steps are, also where several impacts lose their speed at once. */
static void mirror_images_are_one_orbit(void **unused) {
    (void)unused;
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {0.721263, 0.345251}, high[2] = {2.30804, 0.920668},
                        step_max[2] = {0.02, 0.01};
    const double c = 0.291, at = 0.575418, omega = sqrt(0.25 * (1 - 0.25 * c * c));
    saltus_spec spec = oscillator_spec(c, 1, 1, at);
    add_stop(&spec, 1.44253, 0.474783, SALTUS_BOTH);
    saltus_motion motion = settled(&spec);
    branch_record record[2];
    for (int run = 0; run < 2; run++) {
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        options.switches = 1;
        options.step_max = step_max[run];
        record[run] = branch_run(&spec, motion.periods, motion.state, &options);
        double cusp[2] = {NAN, NAN}, nearest = INFINITY;
        for (int k = 0; k < record[run].count; k++) {
            const saltus_branch_point *p = &record[run].point[k];
            if (p->kind == SALTUS_POINT_GR_BP)
                check_near(p->value[1], omega, 1e-9);
            if (p->kind == SALTUS_POINT_CP) {
                assert_true(p->locus == SALTUS_POINT_LP && p->admissible && p[1].kind == SALTUS_POINT_EP);
                memcpy(cusp, p->value, sizeof cusp);
            }
        }
        /* How far it is off the line through two branch points. */
        for (int k = 1; k < record[run].count; k++) {
            const saltus_branch_point *p = &record[run].point[k];
            const double x[2] = {p->value[0] - p[-1].value[0], p->value[1] - p[-1].value[1]},
                         y[2] = {cusp[0] - p->value[0], cusp[1] - p->value[1]};
            if (p->kind == SALTUS_POINT_BP && hypot(y[0], y[1]) < 0.1)
                nearest = fmin(nearest, fabs(x[0] * y[1] - x[1] * y[0]) / hypot(x[0], x[1]));
        }
        check_near(nearest, 0, 5e-4);
        options = branch_along("d", low[0], high[0]);
        options.direction = 1;
        options.step_max = step_max[run];
        branch_record branch = branch_run(&spec, motion.periods, motion.state, &options);
        const saltus_branch_point *end = &branch.point[branch.count - 1];
        assert_true(end[-1].kind == SALTUS_POINT_GR && end->kind == SALTUS_POINT_EP);
        assert_non_null(strstr(end->reason, "mirror images at their grazing"));
        check_near(end->value[0], 1 / hypot(1 - at * at, c * at), 1e-9);
        branch_forget(&branch);
    }
    assert_true(same_corners(record, SALTUS_POINT_CP) == 2 && record[0].count != record[1].count);
    branch_forget(&record[0]);
    branch_forget(&record[1]);
    saltus_motion_clear(&motion);
}

/* Between two equal stops all happens at once where the symmetric free motion grazes and half a period is a
 * whole number of free oscillations: the orbits with impacts fold, flip and break their symmetry. The curve
 * of these branch points goes on from there. To leading order their impacts' speeds grow with the detuning as
 * a solution of a quadratic equation; that of the folds grows on the other side of it. */
static void symmetry_breaks_where_it_folds(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {0.665085, 0.446529}, high[2] = {2.12827, 1.19074},
                        step_max[2] = {0.02, 0.01};
    const double c = 0.12, omega = 0.5 * sqrt(1 - 0.25 * c * c), square = omega * omega;
    saltus_spec spec = oscillator_spec(c, 1, 1, 0.744215);
    add_stop(&spec, 1.33017, 0.948749, SALTUS_BOTH);
    saltus_motion motion = settled(&spec);
    for (int run = 0; run < 2; run++) {
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        options.switches = 1;
        options.step_max = step_max[run];
        branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
        const saltus_branch_point *first = first_of(&record, SALTUS_POINT_BP, SALTUS_POINT_BP), *last = first;
        check_near(first->value[1], omega, 1e-9);
        check_near(first->value[0], 1 / hypot(1 - square, c * omega), 1e-9);
        while (last[1].branch == first->branch)
            last++;
        assert_true(last->step > 50 && last->value[1] > 2 * omega - 0.05);
        assert_string_equal(last->reason, "end of the parameters' range");
        check_anew(&first[last->step / 2], SALTUS_POINT_BP);
        branch_forget(&record);
    }
    saltus_motion_clear(&motion);
}

/* The grazing of orbits of twice the period leaves a flip at grazing almost along the curve of grazing that
 * it crosses, whose orbits it must not be drawn to: so it has to be left along its own tangent. It ends at
 * another such flip, and is found from either end. */
static void grazing_leaves_a_flip_aslant(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {0.97, 0.335}, high[2] = {0.98, 0.355}, step_max[2] = {0.4, 0.2},
                        state[2] = {0.8693461999700857, 0.005582376261226392};
    saltus_spec spec = oscillator_spec(0.191, 1, 1, 0.3472088738910642);
    add_stop(&spec, 0.9753924033153816, 0.508224, SALTUS_UPPER);
    add_stop(&spec, 0.9753924033153816, 0.559742, SALTUS_LOWER);
    for (int run = 0; run < 2; run++) {
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        options.switches = 1;
        options.step_max = step_max[run];
        branch_record record = branch_run(&spec, 1, state, &options);
        const saltus_branch_point *ends[2] = {NULL};
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            const bool twice = p->periods == 2 && (p->step == 0 || p->kind == SALTUS_POINT_EP);
            if (twice)
                ends[p->step > 0] = p;
            assert_true(p->kind != SALTUS_POINT_EP || !strstr(p->reason, "does not go on"));
        }
        assert_non_null(ends[0]);
        assert_true(ends[1] > ends[0] + 5 && ends[1][-1].kind == SALTUS_POINT_GR_PD);
        int met = 0;
        for (int k = 0; k < record.count; k++)
            for (int end = 0; end < 2 && record.point[k].kind == SALTUS_POINT_GR_PD; end++)
                met += record.point[k].periods == 1 && record.point[k].locus == SALTUS_POINT_GR &&
                       at_one_place(&record.point[k], ends[end]);
        assert_int_equal(met, 2);
        check_near(fabs(ends[1]->value[0] - ends[0]->value[0]), 0.0031895, 1e-6);
        branch_forget(&record);
    }
}

/* Whether a curve of grazing of orbits of so many periods begins or passes where a point is. */
static bool grazes_there(const branch_record *record, const saltus_branch_point *p, int periods) {
    bool found = false;
    for (int k = 0; k < record->count; k++)
        found |= record->point[k].locus == SALTUS_POINT_GR && record->point[k].periods == periods &&
                 at_one_place(p, &record->point[k]);
    return found;
}

/* Flips of strongly unstable orbits between two close grazings: orbits of twice the period have arcs of
 * grazing no longer than their distance. If the orbit whose flip meets grazing closes after fewer periods,
 * the flip is not that of the shorter orbit, and no such curve begins. Each curve that begins continues in
 * steps. */
static void grazing_leaves_the_ends_of_short_curves_of_flips(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {0.3273, 0.266}, high[2] = {1.0474, 1.7733};
    static const struct {
        int periods; /* of the flips */
        double at[2], state[4];
    } rows[] = {{4,
                 {0.6981023031109848, 0.36654620995872533},
                 {-0.6172475410864414, -0.9830134559837096, 0.022892105990964112, 0.0398277331717187}},
                {2,
                 {0.766147181252207, 0.32562557932795644},
                 {-0.40489844698468197, -0.728086411871268, -0.0031522536093089217, 0.028753982182374148}}};
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        saltus_spec spec = hitting_masses();
        set_parameter(&spec, key[0], rows[row].at[0]);
        spec.stops[0].d = rows[row].at[1];
        saltus_branch_options options = locus_options(SALTUS_POINT_PD, key, low, high);
        options.switches = 1;
        options.points = 20;
        branch_record record = branch_run(&spec, rows[row].periods, rows[row].state, &options);
        int corners = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            if (p->step == 0) {
                assert_true(k + 2 < record.count && p[2].step == 2);
                continue;
            }
            double stride = hypot((p->value[0] - p[-1].value[0]) / (high[0] - low[0]),
                                  (p->value[1] - p[-1].value[1]) / (high[1] - low[1]));
            assert_true(stride <= 1.2 * options.step_max);
            assert_true(p->admissible);
            if (p->locus == SALTUS_POINT_GR && p->kind == p->locus) {
                saltus_system *system = build(&p->spec);
                check_near(pow(slowest_contact(system, p->periods, p->state), 2), 0, 1e-9);
                saltus_system_free(system);
            }
            if (p->locus == SALTUS_POINT_PD && p->kind == SALTUS_POINT_GR_PD) {
                assert_true(grazes_there(&record, p, 2 * p->periods) !=
                            grazes_there(&record, p, p->periods / 2));
                corners++;
            }
        }
        assert_int_equal(corners, 2);
        branch_forget(&record);
    }
}

/* A curve of tori from grazing to a double multiplier 1. The curves of grazing and of folds through its ends,
 * found directly, have the same corners there, and from either of them the curve of tori begins. */
static void check_tori(double step_max) {
    static const char *const key[2] = {"omega", "d"}, *const turned[2] = {"d", "omega"};
    static const double low[2] = {0.3273, 0.266}, high[2] = {1.0474, 1.7733};
    static const double low_turned[2] = {0.266, 0.3273}, high_turned[2] = {1.7733, 1.0474};
    saltus_spec spec = hitting_masses();
    saltus_motion motion = settled(&spec);
    saltus_branch_options options = locus_options(SALTUS_POINT_NS, key, low, high);
    options.switches = 1;
    options.step_max = step_max;
    branch_record tori = branch_run(&spec, motion.periods, motion.state, &options);
    check_network(&tori, &options);
    const saltus_branch_point *grazes = first_of(&tori, SALTUS_POINT_GR_NS, SALTUS_POINT_NS);
    const saltus_branch_point *meets = first_of(&tori, SALTUS_POINT_R1, SALTUS_POINT_NS);
    const saltus_branch_point *fold = first_of(&tori, SALTUS_POINT_LP, SALTUS_POINT_LP) + 3;
    check_near(nearest_of(&tori, SALTUS_POINT_GR, SALTUS_POINT_GR, grazes->value[0], grazes->value[1]), 0,
               1e-9);
    check_near(nearest_of(&tori, SALTUS_POINT_LP, SALTUS_POINT_LP, meets->value[0], meets->value[1]), 0,
               1e-9);
    for (int folds = 0; folds < 2; folds++) {
        const saltus_branch_point *from = folds ? fold : grazes - 2;
        saltus_point_kind kind = folds ? SALTUS_POINT_LP : SALTUS_POINT_GR;
        options = locus_options(kind, turned, low_turned, high_turned);
        options.switches = 1;
        options.step_max = step_max;
        branch_record own = branch_run(&from->spec, from->periods, from->state, &options);
        check_network(&own, &options);
        check_near(nearest_of(&own, folds ? SALTUS_POINT_R1 : SALTUS_POINT_GR_NS, kind,
                              (folds ? meets : grazes)->value[1], (folds ? meets : grazes)->value[0]),
                   0, 1e-9);
        if (!folds)
            check_near(nearest_of(&own, SALTUS_POINT_R1, SALTUS_POINT_NS, meets->value[1], meets->value[0]),
                       0, 1e-9);
        branch_forget(&own);
    }
    branch_forget(&tori);
    saltus_motion_clear(&motion);
}

/* For any steps: near the double multiplier the equations are almost singular, and solved by chance. */
static void tori_between_grazing_and_folds(void **unused) {
    (void)unused;
    skip_unless_long();
    static const double step_max[] = {0.015, 0.033, 0.05};
    for (int k = 0; k < 3; k++)
        check_tori(step_max[k]);
}

/* How many multipliers of a point's orbit, over its period divided by `parts`, are within `near` of a
 * number. */
static int multipliers_at(const saltus_branch_point *p, int parts, double re, double im, double near) {
    saltus_orbit_options how = saltus_orbit_defaults();
    saltus_system *system = build(&p->spec);
    saltus_message message = {.text = ""};
    saltus_orbit orbit = {0};
    int found = 0;
    check_ok(saltus_orbit_find(system, p->periods / parts, p->state, &how, &orbit, &message), &message);
    assert_true(saltus_system_distance(system, orbit.state, p->state) < 1e-5);
    for (int k = 0; k < orbit.multiplier_count; k++)
        found += hypot(orbit.multipliers[k].re - re, orbit.multipliers[k].im - im) < near;
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
    return found;
}

/* How far an orbit is from closing after half its period. */
static double half_apart(const saltus_branch_point *p) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = build(&p->spec);
    saltus_flow *flow = open_flow(system, &options, 0, p->state);
    double state[SALTUS_STATE_MAX];
    advance(flow, p->periods / 2, 0);
    saltus_flow_state(flow, 0, state);
    const double apart = saltus_system_distance(system, state, p->state);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return apart;
}

/* Folds and tori of orbits of doubled period end where these become the shorter orbits, which are special
 * there by their own multipliers. No earlier point of the curves is such an orbit, and the place is the same
 * for all steps. */
static void curves_end_where_the_period_halves(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"d", "omega"};
    static const double low[2] = {0.266, 0.3273}, high[2] = {1.7733, 1.0474};
    static const struct {
        saltus_point_kind locus, end;
        int periods;
        double at[2], state[4];
    } rows[] = {
        {SALTUS_POINT_NS,
         SALTUS_POINT_PD_NS,
         2,
         {0.6604541547294549, 0.37132127692996086},
         {-0.8686649937552099, -1.1880021403392536, 0.0890699216672925, 0.04642330739399654}},
        {SALTUS_POINT_LP,
         SALTUS_POINT_GPD,
         2,
         {0.5093262656902307, 1.1587535044792654},
         {-4.664247120245111, -5.811667126410108, 0.8384083642879604, 1.0272540994195634}},
        {SALTUS_POINT_NS,
         SALTUS_POINT_R2,
         2,
         {0.9404362620481127, 0.2711156191839782},
         {-0.26897500480168285, -0.3847890256776381, -0.010501218903823193, 0.03935937294255122}},
        {SALTUS_POINT_NS,
         SALTUS_POINT_LP_PD,
         2,
         {0.4968124409243967, 1.5342782179177883},
         {-6.159534476101665, -7.664458680143566, 1.6432278730874634, 1.8543613959038354}},
        {SALTUS_POINT_LP,
         SALTUS_POINT_R4,
         4,
         {0.698816299286873, 0.33711862407051885},
         {-0.6859807450269525, -0.9593413174137825, 0.04666913979593943, 0.03998631936364573}},
    };
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        saltus_spec spec = hitting_masses();
        set_parameter(&spec, "omega", rows[row].at[0]);
        spec.stops[0].d = rows[row].at[1];
        saltus_branch_options options = locus_options(rows[row].locus, key, low, high);
        double place[2][2];
        for (int run = 0; run < 2; run++) {
            options.step_max = run ? 0.05 : 0.03;
            options.points = 60;
            branch_record record = branch_run(&spec, rows[row].periods, rows[row].state, &options);
            const saltus_branch_point *end = NULL;
            for (int k = 0; k < record.count; k++) {
                const saltus_branch_point *p = &record.point[k];
                if (p->kind == p->locus)
                    assert_true(half_apart(p) > 1e-5);
                else if (p->kind == rows[row].end)
                    end = p;
                assert_null(strstr(p->reason, "corner"));
            }
            assert_non_null(end);
            assert_int_equal(end[1].kind, SALTUS_POINT_EP);
            assert_true(half_apart(end) < 1e-9 && end->residual < 1e-9);
            const bool quarter = rows[row].end == SALTUS_POINT_R4;
            /* A double multiplier depends on the parameters like a square root. */
            const bool twice = rows[row].end == SALTUS_POINT_R2, folds = rows[row].end == SALTUS_POINT_LP_PD;
            if (quarter)
                assert_int_equal(multipliers_at(end, 4, 0, 1, 1e-9), 1);
            else
                assert_int_equal(multipliers_at(end, 2, -1, 0, twice ? 1e-5 : 1e-9), 1 + twice);
            assert_int_equal(!quarter && multipliers_at(end, 2, 1, 0, 1e-5) > 0, folds);
            memcpy(place[run], end->value, sizeof place[run]);
            branch_forget(&record);
        }
        for (int d = 0; d < 2; d++)
            assert_true(fabs(place[1][d] - place[0][d]) < 1e-9 * (high[d] - low[d]));
    }
}

/* An interruption on any of the switched curves, or between two, changes no bit of what follows: which curves
 * wait and which are done is kept. */
static void an_interrupted_network_goes_on(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {1.2292, 0.12782}, high[2] = {3.2778, 0.85211};
    static const double from[2] = {38, 0.034}, to[2] = {46, 0.036};
    saltus_spec spec = meeting_curves();
    saltus_motion motion = settled(&spec);
    saltus_branch_options options = locus_options(SALTUS_POINT_LP, key, low, high);
    options.switches = 2;
    options.step = options.step_max = 0.1;
    assert_true(branch_check_resumed(&spec, motion.periods, motion.state, &options, 200) > 2);
    saltus_motion_clear(&motion);
    if (!long_version())
        return;
    reference r = read_reference("fig7d");
    options = locus_options(SALTUS_POINT_PD, key, from, to);
    options.switches = 1;
    assert_true(branch_check_resumed(&r.spec, r.periods, r.states[0], &options, 120) > 1);
}

/* Grazing of orbits that branch off from mirror symmetric ones: such an orbit touches one of the stops once,
 * where it may have another impact on the other, and closes. */
static void check_broken_grazing(const saltus_branch_point *p) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = build(&p->spec);
    saltus_flow *flow = open_flow(system, &options, 0, p->state);
    int by_side[2] = {0};
    double end[2];
    for (int k = 0; k < p->event_count; k++)
        by_side[p->events[k].face]++;
    assert_int_equal(abs(by_side[0] - by_side[1]), p->event_count % 2);
    check_near(slowest_contact(system, p->periods, p->state), 0, 1e-6);
    advance(flow, p->periods, 0);
    saltus_flow_state(flow, 0, end);
    /* Up to the effect of an impact of such a speed. */
    check_near(saltus_system_distance(system, end, p->state), 0, 1e-5);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Grazing of mirror symmetric orbits, with branch points and folds on the way. The curve of grazing tells
 * these apart by the symmetry of a null vector; the curves of folds and of branch points, which have other
 * equations, end at the same places. */
static void symmetric_grazing(void **unused) {
    (void)unused;
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {0.20374, 0.1}, high[2] = {0.81494, 2};
    saltus_spec spec = oscillator_spec(0.064962, 1, 0.81997, 0.40747);
    add_stop(&spec, 0.5, 0.68926, SALTUS_BOTH);
    saltus_motion motion = settled(&spec);
    saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
    options.switches = 1;
    options.step_max = 0.03;
    branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
    int ends[SALTUS_POINT_KINDS] = {0}, broken = 0, joined = 0;
    check_network(&record, &options);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        bool leaves = p->locus == SALTUS_POINT_GR && p->parent >= 0;
        if (leaves && p->step == 0) {
            check_near(turn_between(&record, &options, p, SALTUS_POINT_BP), 0, 0.05);
            broken++;
        } else if (leaves && p->kind == SALTUS_POINT_GR) {
            check_broken_grazing(p);
        } else if (leaves && p->kind == SALTUS_POINT_GR_BP) {
            bool known = false;
            for (int j = 0; j < k; j++)
                known |= record.point[j].kind == SALTUS_POINT_GR_BP && record.point[j].parent < 0 &&
                         at_one_place(p, &record.point[j]);
            assert_true(known);
            joined++;
        }
        bool folds = p->locus == SALTUS_POINT_LP && p->kind == SALTUS_POINT_GR_LP;
        if (!folds && !(p->locus == SALTUS_POINT_BP && p->kind == SALTUS_POINT_GR_BP))
            continue;
        double nearest = INFINITY;
        for (int j = 0; j < record.count; j++)
            if (record.point[j].locus == SALTUS_POINT_GR && record.point[j].kind == p->kind)
                nearest = fmin(nearest, fabs(record.point[j].value[0] / p->value[0] - 1) +
                                            fabs(record.point[j].value[1] / p->value[1] - 1));
        check_near(nearest, 0, 1e-9);
        ends[p->kind]++;
    }
    assert_true(ends[SALTUS_POINT_GR_LP] > 0 && ends[SALTUS_POINT_GR_BP] > 0);
    /* Of seven branch points at grazing six are joined, by three curves. */
    assert_true(broken == 4 && joined == 3);
    branch_forget(&record);
    saltus_motion_clear(&motion);
}

/* The lowest position of a mass on an orbit of one period, by parabolas through its path. */
static double reach_down(const saltus_branch_point *point) {
    enum { pieces = 8192 };
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = build(&point->spec);
    saltus_flow *flow = open_flow(system, &options, 0, point->state);
    double before[2], after[2] = {point->state[0], point->state[1]}, reach = 0;
    double step = 2 * acos(-1) / (saltus_spec_get(&point->spec, "omega") * pieces);
    for (int k = 1; k <= pieces; k++) {
        memcpy(before, after, sizeof after);
        advance(flow, (double)k / pieces, 0);
        saltus_flow_state(flow, 0, after);
        if (before[1] < 0 && after[1] >= 0)
            reach = fmax(reach, 0.5 * before[1] * before[1] * step / (after[1] - before[1]) - before[0]);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
    return reach;
}

/* A mass chatters on one stop and touches another, which has no effect: the curve of the touch is where that
 * stop stands at the reach of the mass alone. It ends where the mass alone stops chattering completely,
 * interrupted or not. */
static void grazing_ends_with_chatter(void **unused) {
    (void)unused;
    static const struct {
        double c, F, F0, r, omega, high;
    } rows[] = {{0.1, 2, 0.5, 0.3, 1.2, 1.29}, {0.1, 2, 0.3, 0.3, 1.1, 1.4}, {0.2, 1.5, 0.4, 0.4, 0.9, 1.5}};
    static const char *const key[2] = {"d2", "omega"};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = oscillator_spec(rows[k].c, 1, rows[k].F, rows[k].omega);
        set_parameter(&spec, "F0", rows[k].F0);
        add_stop(&spec, 0, rows[k].r, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_classify_options how = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_motion motion;
        const double start[2] = {-0.5, 0};
        check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
        assert_string_equal(motion.label, "chatter/1");
        /* The mass alone. */
        saltus_branch_options up = branch_along("omega", 0.8 * rows[k].omega, rows[k].high);
        up.direction = 1;
        branch_record alone = branch_run(&spec, 1, motion.state, &up);
        int ends = 0;
        while (ends < alone.count && alone.point[ends].kind != SALTUS_POINT_CH)
            ends++;
        assert_true(ends < alone.count);
        const saltus_branch_point *chatter = &alone.point[ends];
        double reach = reach_down(chatter);
        /* With the other stop. */
        add_stop(&spec, 5, 0.7, SALTUS_LOWER);
        const double low[2] = {0.3 * reach, 0.8 * rows[k].omega}, high[2] = {6, rows[k].high};
        saltus_branch_options options = locus_options(SALTUS_POINT_GR, key, low, high);
        branch_record record = branch_run(&spec, 1, motion.state, &options);
        int corners = 0;
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            assert_string_equal(p->label, "chatter/1");
            if (p->kind != SALTUS_POINT_CH_GR) {
                assert_true(p->kind == SALTUS_POINT_GR || p->kind == SALTUS_POINT_EP);
                continue;
            }
            corners++;
            check_near(p->value[1], chatter->value[0], 1e-9);
            check_near(p->value[0], reach, 1e-9);
            assert_true(j + 1 < record.count && p[1].kind == SALTUS_POINT_EP);
        }
        assert_int_equal(corners, 1);
        assert_true(k > 0 || branch_check_resumed(&spec, 1, motion.state, &options, record.count / 8) > 4);
        branch_forget(&record);
        branch_forget(&alone);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* At a cusp both parameters turn back, and the curve leaves to the side from which it came. */
static void folds_have_cusps(void **unused) {
    (void)unused;
    static const struct {
        double c, r, d, F, omega;
    } rows[] = {{0.125561, 0.674443, -0.192737, 1.0072, 0.806906},
                {0.0819887, 0.512876, 0.391993, 1.02048, 0.68369}};
    static const char *const key[2] = {"omega", "d"};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = oscillator_spec(rows[k].c, 1, rows[k].F, rows[k].omega);
        set_parameter(&spec, "F0", 0.3);
        add_stop(&spec, rows[k].d, rows[k].r, SALTUS_UPPER);
        saltus_motion motion = settled(&spec);
        const double low[2] = {0.6 * rows[k].omega, rows[k].d - 0.6},
                     high[2] = {1.5 * rows[k].omega, rows[k].d + 0.6};
        saltus_branch_options options = locus_options(SALTUS_POINT_LP, key, low, high);
        branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
        int cusps = 0;
        for (int p = 1; p + 1 < record.count; p++) {
            const saltus_branch_point *at = &record.point[p], *before = at - 1, *after = at + 1;
            if (at->kind != SALTUS_POINT_CP)
                continue;
            cusps++;
            check_near(at->heading, 0, 1e-8);
            for (int i = 0; i < 2; i++)
                assert_true((before->value[i] - at->value[i]) * (after->value[i] - at->value[i]) > 0);
            check_near(at->multipliers[0].re, 1, 1e-7);
        }
        assert_int_equal(cusps, 1);
        branch_forget(&record);
        saltus_motion_clear(&motion);
    }
}

/* On a curve of flips a second multiplier reaches -1; on a curve of tori the angle is a third, a quarter and
 * finally half of the circle. */
static void resonances(void **unused) {
    (void)unused;
    skip_where_slow();
    const pipe_flips_network *network = find_network();
    static const char *const key[2] = {"omega", "d"};
    static const double from[2] = {38.5, 0.0345}, to[2] = {42.2, 0.0361};
    const double pi = acos(-1);
    const reference *r = &network->reference;
    int found[SALTUS_POINT_KINDS] = {0};
    saltus_branch_options options = locus_options(SALTUS_POINT_NS, key, from, to);
    branch_record own = branch_run(&r->spec, r->periods, r->states[0], &options);
    for (int tori = 0; tori < 2; tori++) {
        const branch_record *record = tori ? &own : &network->record;
        for (int k = 0; k < record->count; k++) {
            const saltus_branch_point *p = &record->point[k];
            const saltus_multiplier *mu = p->multipliers;
            double angle = p->kind == SALTUS_POINT_R2   ? pi
                           : p->kind == SALTUS_POINT_R3 ? 2 * pi / 3
                           : p->kind == SALTUS_POINT_R4 ? pi / 2
                                                        : NAN;
            if (isnan(angle) || (!tori && p->locus != SALTUS_POINT_PD))
                continue;
            found[p->kind]++;
            /* A double multiplier depends on its place like a square root. */
            check_near(fabs(atan2(mu[0].im, mu[0].re)), angle, p->kind == SALTUS_POINT_R2 ? 1e-3 : 1e-8);
            check_near(mu[0].log_modulus + mu[1].log_modulus, 0, 1e-7);
            /* Neither of the two counts. */
            assert_int_equal(p->unstable, 0);
        }
    }
    branch_forget(&own);
    assert_true(found[SALTUS_POINT_R2] == 3 && found[SALTUS_POINT_R3] == 1 && found[SALTUS_POINT_R4] == 1);
}

static void check_pipe_curve(saltus_point_kind kind, const double *low, const double *high, int least) {
    const char *const key[2] = {"omega", "d"};
    skip_unless_long();
    reference r = read_reference("fig7d");
    saltus_branch_options options = locus_options(kind, key, low, high);
    options.step_max = 0.04;
    check_curve_anew(&r.spec, r.periods, r.states[0], &options, least, false);
}

static const double pipe_low[2] = {35, 0.03}, pipe_high[2] = {56, 0.04};

static void pipe_folds(void **unused) {
    (void)unused;
    check_pipe_curve(SALTUS_POINT_LP, pipe_low, pipe_high, 25);
}

static void pipe_flips(void **unused) {
    (void)unused;
    check_pipe_curve(SALTUS_POINT_PD, pipe_low, pipe_high, 15);
}

static void pipe_grazing(void **unused) {
    (void)unused;
    check_pipe_curve(SALTUS_POINT_GR, pipe_low, pipe_high, 20);
}

static void pipe_tori(void **unused) {
    (void)unused;
    const double low[2] = {38.5, 0.0345}, high[2] = {42.2, 0.03545};
    check_pipe_curve(SALTUS_POINT_NS, low, high, 10);
}

/* The curve ends where the pair meets at 1 or -1: beyond, it is real with product 1, and the orbit is not
 * special. */
static void tori_end_at_resonance(void **unused) {
    (void)unused;
    const double low[2] = {38.5, 0.0345}, high[2] = {42.2, 0.0361};
    check_pipe_curve(SALTUS_POINT_NS, low, high, 10);
}

/* Two masses that hit each other eleven times in a period, at last with a millionth of the first speed: a run
 * of impacts so steep that it hides from the flow, from tolerances and from distances at the section. Every
 * curve ends at the range's border or where its last point says what it is, and the curve of tori from the
 * folds' double multiplier 1 leads to grazing. */
static void long_runs_end_no_curve(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const key[2] = {"omega", "d"};
    static const double low[2] = {0.68, 0.5}, high[2] = {0.75, 0.63};
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 0.681524);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "c2", 0.1);
    add_stop(&spec, 0.581022, 0.358061, SALTUS_UPPER);
    spec.stops[0].weight[0] = 1;
    spec.stops[0].weight[1] = -1;
    saltus_motion motion = settled(&spec);
    saltus_branch_options options = locus_options(SALTUS_POINT_LP, key, low, high);
    options.switches = 2;
    options.step = 0.01;
    options.step_max = 0.04;
    branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
    bool twice = false;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_EP)
            assert_true(strstr(p->reason, "range") ||
                        (p->step > 1 && p[-1].kind >= SALTUS_POINT_CP && at_one_place(p, p - 1)));
        twice = twice || (p->locus == SALTUS_POINT_GR && p->periods == 2 && p->step > 10);
    }
    assert_true(twice);
    const saltus_branch_point *folds = first_of(&record, SALTUS_POINT_R1, SALTUS_POINT_LP),
                              *tori = first_of(&record, SALTUS_POINT_R1, SALTUS_POINT_NS);
    for (int i = 0; i < 2; i++)
        check_near(tori->value[i], folds->value[i], 1e-9 * (high[i] - low[i]));
    first_of(&record, SALTUS_POINT_GR_NS, SALTUS_POINT_NS);
    branch_forget(&record);
    saltus_motion_clear(&motion);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_in_closed_form),
        cmocka_unit_test(borders_are_met_to_the_last_bit),
        cmocka_unit_test(one_way),
        cmocka_unit_test(an_interrupted_curve_goes_on),
        cmocka_unit_test(an_interrupted_curve_of_the_pipe_goes_on),
        cmocka_unit_test(no_torus),
        cmocka_unit_test(two_masses),
        cmocka_unit_test(curves_meet_at_corners),
        cmocka_unit_test(corners_start_grazing),
        cmocka_unit_test(corners_start_the_curves_that_meet_there),
        cmocka_unit_test(networks_of_curves),
        cmocka_unit_test(folds_end_in_long_runs),
        cmocka_unit_test(tori_between_grazing_and_folds),
        cmocka_unit_test(long_steps_pass_no_torus),
        cmocka_unit_test(slow_forcing_hides_no_corner),
        cmocka_unit_test(pairs_beside_infinity_are_found),
        cmocka_unit_test(curves_of_grazing_join_those_of_a_third),
        cmocka_unit_test(all_impacts_die_at_once),
        cmocka_unit_test(a_shorter_orbit_grazes_once),
        cmocka_unit_test(close_corners_are_told_apart),
        cmocka_unit_test(grazing_passes_a_crossing),
        cmocka_unit_test(grazing_joins_a_symmetric_motion),
        cmocka_unit_test(mirror_images_are_one_orbit),
        cmocka_unit_test(symmetry_breaks_where_it_folds),
        cmocka_unit_test(grazing_leaves_a_flip_aslant),
        cmocka_unit_test(curves_end_where_the_period_halves),
        cmocka_unit_test(grazing_leaves_the_ends_of_short_curves_of_flips),
        cmocka_unit_test(a_polygon_of_grazings_is_closed),
        cmocka_unit_test(an_interrupted_network_goes_on),
        cmocka_unit_test(symmetric_grazing),
        cmocka_unit_test(grazing_ends_with_chatter),
        cmocka_unit_test(folds_have_cusps),
        cmocka_unit_test(resonances),
        cmocka_unit_test(pipe_folds),
        cmocka_unit_test(pipe_flips),
        cmocka_unit_test(pipe_grazing),
        cmocka_unit_test(pipe_tori),
        cmocka_unit_test(tori_end_at_resonance),
        cmocka_unit_test(long_runs_end_no_curve),
    };
    return cmocka_run_group_tests(tests, NULL, drop_network);
}
