/* Building systems: refusals with their messages, and properties of the built system.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "system/spectrum.h"
#include "system/state.h"

#include <complex.h>
#include <limits.h>

static void expect_refusal(const saltus_spec *spec, const char *word) {
    saltus_message message = {.text = ""};
    saltus_system *system = (saltus_system *)1;
    assert_int_equal(saltus_system_new(spec, &system, &message), SALTUS_BAD_INPUT);
    assert_null(system);
    if (!strstr(message.text, word))
        fail_msg("\"%s\" does not name \"%s\"", message.text, word);
}

static void refused_parameters(void **unused) {
    (void)unused;
    static const struct {
        const char *name;
        double value;
    } rows[] = {{"N", 0},     {"N", 2.5},    {"N", 65},      {"alpha", -1}, {"beta", 1},      {"beta", -0.1},
                {"omega", 0}, {"omega", -3}, {"omega", NAN}, {"kappa", -1}, {"u0", INFINITY}, {"sigma", NAN}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = pipe_spec(3, 20);
        set_parameter(&spec, rows[k].name, rows[k].value);
        expect_refusal(&spec, rows[k].name);
    }
}

static void refused_stops(void **unused) {
    (void)unused;
    static const struct {
        double xi, d, r;
        saltus_sides sides;
        const char *word;
    } rows[] = {{0, 0.03, 0.9, SALTUS_UPPER, "xi"},          {1, 0.03, 0.9, SALTUS_UPPER, "xi"},
                {0.5, 0.03, 1.2, SALTUS_UPPER, "r = 1.2"},   {0.5, 0.03, -0.1, SALTUS_UPPER, "r = -0.1"},
                {0.5, -0.01, 0.9, SALTUS_BOTH, "d = -0.01"}, {0.5, 0, 0.9, SALTUS_BOTH, "d = 0"},
                {0.5, NAN, 0.9, SALTUS_UPPER, "d"},          {0.5, 0.03, NAN, SALTUS_UPPER, "r"},
                {1e-9, 0.03, 0.9, SALTUS_UPPER, "xi"},       {0.5, 0.03, 0.9, (saltus_sides)0, "sides"}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = pipe_spec(3, 20);
        add_stop(&spec, rows[k].d, rows[k].r, rows[k].sides);
        spec.stops[0].xi = rows[k].xi;
        expect_refusal(&spec, rows[k].word);
    }
    saltus_spec twice = pipe_spec(3, 20);
    add_stop(&twice, 0.03, 0.9, SALTUS_UPPER);
    add_stop(&twice, 0.03, 0.5, SALTUS_BOTH);
    expect_refusal(&twice, "same");
    saltus_spec crossed = pipe_spec(3, 20);
    add_stop(&crossed, -0.03, 0.9, SALTUS_UPPER);
    add_stop(&crossed, 0.02, 0.9, SALTUS_LOWER);
    expect_refusal(&crossed, "room");
}

static void refused_oscillators(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    add_stop(&spec, 1, 0.9, SALTUS_UPPER);
    spec.stops[0].weight[1] = 1;
    expect_refusal(&spec, "weight");
    spec.stops[0].weight[0] = spec.stops[0].weight[1] = 0;
    expect_refusal(&spec, "weight");
    spec = oscillator_spec(0.1, 1, 1, 1);
    set_parameter(&spec, "m", 0);
    expect_refusal(&spec, "m = 0");
}

/* A refusal states numbers in order, those of the offending stop. */
static void refusals_tell_the_numbers(void **unused) {
    (void)unused;
    static const struct {
        const char *name;
        double value;
        const char *text;
    } parameters[] = {{"alpha", 11, "alpha = 11: must be at least 0 and at most 10 ("},
                      {"beta", 1, "beta = 1: must be at least 0 and less than 1 ("},
                      {"omega", -2, "omega = -2: must be greater than 0 and at most 100000 ("},
                      {"N", 2.5, "N = 2.5: must be a whole number ("},
                      {"N", 65, "N = 65: must be at least 1 and at most 64 ("}};
    for (size_t k = 0; k < sizeof parameters / sizeof parameters[0]; k++) {
        saltus_spec spec = pipe_spec(3, 20);
        set_parameter(&spec, parameters[k].name, parameters[k].value);
        expect_refusal(&spec, parameters[k].text);
    }
    static const struct {
        saltus_stop stops[3];
        const char *text;
    } rows[] = {{{{0.5, {1, 0}, 0.1, 0.5, 1}, {0.3, {0, 1}, 0.1, 1.5, 1}, {0.2, {1, 1}, 0.1, 0.5, 1}},
                 "stop 2: r = 1.5: must be at least 0 and at most 1 ("},
                {{{0.5, {1, 0}, 0.1, 0.5, 1}, {0.3, {0, 1}, 0.1, 0.5, 1}, {0.2, {1, 1}, -0.25, 0.5, 3}},
                 "stop 3: d = -0.25: must be greater than 0"},
                {{{0.5, {1, 0}, 0.1, 0.5, 1}, {0.3, {0, 1}, 0.1, 0.5, 4}, {0.2, {1, 1}, 0.25, 0.5, 3}},
                 "stop 2: sides: must be"},
                {{{0.5, {1, 0}, 0.1, 0.5, 1}, {0.3, {0, 1}, -0.3, 0.5, 1}, {0.3, {0, 1}, 0.2, 0.5, 2}},
                 "stops 2 and 3: d = -0.3 and d = 0.2 leave"},
                {{{0.5, {1, 0}, 0.1, 0.5, 1}, {0.3, {0, 1}, 0.2, 0.5, 3}, {0.3, {0, 1}, 0.2, 0.5, 2}},
                 "stops 2 and 3 limit"}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++)
        for (int pipe = 0; pipe < 2; pipe++) {
            saltus_spec spec = pipe ? pipe_spec(3, 20) : oscillator_spec(0.1, 1, 1, 1);
            set_parameter(&spec, "N", pipe ? 3 : 2);
            memcpy(spec.stops, rows[k].stops, sizeof rows[k].stops);
            spec.stop_count = 3;
            expect_refusal(&spec, rows[k].text);
        }
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    memcpy(spec.stops, rows[0].stops, sizeof rows[0].stops);
    spec.stops[1].r = 0.5;
    spec.stop_count = 3;
    expect_refusal(&spec, "stop 2: weight names mass 2");
    set_parameter(&spec, "N", 2);
    spec.stops[2].weight[1] = spec.stops[2].weight[0] = 0;
    expect_refusal(&spec, "stop 3: weight = [0, 0]");
    spec.stops[2].weight[1] = INFINITY;
    expect_refusal(&spec, "stop 3: weight: must be finite");
    spec.stops[2].weight[1] = 2;
    spec.stop_count = SALTUS_STOPS_MAX + 1;
    expect_refusal(&spec, "stops: 13 given, at most 12");
    /* A single stop is not numbered. */
    spec.stop_count = 1;
    spec.stops[0].r = 1.5;
    saltus_message message = {.text = ""};
    saltus_system *system = NULL;
    assert_int_equal(saltus_system_new(&spec, &system, &message), SALTUS_BAD_INPUT);
    assert_int_equal(strncmp(message.text, "r = 1.5: ", 9), 0);
    spec.stop_count = 3;
    spec.stops[0].r = 0.5;
    spec.stops[0].d = 10;
    spec.stops[1].sides = SALTUS_LOWER;
    spec.stops[1].d = 0.5;
    system = build(&spec);
    assert_int_equal(saltus_system_check_state(system, (double[]){0, -0.75, 0, 0}, &message),
                     SALTUS_BAD_INPUT);
    assert_non_null(
        strstr(message.text, "the displacement -0.75 at stop 2 is beyond its lower side (d = 0.5)"));
    saltus_system_free(system);
}

/* A place where no mode moves by a millionth cannot have a stop; two stops a thousandth of a millionth apart
 * are one. */
static void limits_of_stops(void **unused) {
    (void)unused;
    for (int side = 0; side < 2; side++) {
        saltus_spec spec = pipe_spec(1, 20);
        add_stop(&spec, 0.1, 0.5, SALTUS_UPPER);
        add_stop(&spec, 0.2, 0.5, SALTUS_UPPER);
        spec.stops[1].xi = asin((side ? 1.01e-6 : 0.99e-6)) / M_PI;
        if (side)
            saltus_system_free(build(&spec));
        else
            expect_refusal(&spec, "stop 2: xi = 3.1");
        for (int sign = -1; sign <= 1; sign += 2) {
            spec.stops[1].xi = 0.5;
            spec.stops[1].d = 0.1 * (1 + sign * (side ? 1.1e-9 : 0.9e-9));
            if (side)
                saltus_system_free(build(&spec));
            else
                expect_refusal(&spec, "stops 1 and 2 limit");
        }
    }
}

/* Typical magnitudes: the smallest clearance, without any the response to the forces, without either the
 * unit; velocities by the faster of forcing and spring; modes of a pipe decrease with their number. */
static void scales_are_typical(void **unused) {
    (void)unused;
    static const double clearances[][3] = {{0.5, -0.2, 0.3}, {0, 0.7, 2}, {0.3, 0, 0.4}, {0, 0, 0}};
    for (int k = 0; k < 8; k++)
        for (int two = 0; two < 2; two++) {
            saltus_spec spec = oscillator_spec(0.1, k % 2 ? 40 : 1.5, k == 7 ? 0 : -0.6, 2);
            set_parameter(&spec, "m", 1.4);
            set_parameter(&spec, "F0", k == 7 ? 0 : -0.2);
            set_parameter(&spec, "N", 1 + two);
            set_parameter(&spec, "m2", 0.3);
            set_parameter(&spec, "k2", k % 3 ? 11 : 0.01);
            set_parameter(&spec, "kz", 0.7);
            for (int s = 0; s < (k % 4 == 3 ? 1 : 3) && k < 6; s++) {
                add_stop(&spec, clearances[k % 4][s], 0.5, SALTUS_UPPER);
                spec.stops[s].weight[0] = 1 + s;
            }
            double length = 0;
            for (int s = 0; s < spec.stop_count; s++)
                if (spec.stops[s].d != 0 && (length == 0 || fabs(spec.stops[s].d) < length))
                    length = fabs(spec.stops[s].d);
            const double stiffness = k % 2 ? 40 : 1.5, joint = two ? saltus_spec_get(&spec, "k2") : 0;
            if (length == 0)
                length = k == 7 ? 1 : 0.8 / (stiffness + 1.4 * 4);
            saltus_system *system = build(&spec);
            const double *scale = saltus_system_scale(system);
            check_near(scale[0], length, 1e-15);
            check_near(scale[1 + two], length * fmax(2, sqrt((stiffness + joint) / 1.4)), 1e-13);
            if (two) {
                check_near(scale[1], length, 1e-15);
                check_near(scale[3], length * fmax(2, sqrt(joint / 0.3)), 1e-13);
            }
            check_near(scale[2 + 2 * two], length * 0.7, 1e-15);
            saltus_system_free(system);
        }
    saltus_spec spec = pipe_spec(9, 20);
    saltus_system *system = build(&spec);
    const double *scale = saltus_system_scale(system);
    for (int i = 0; i < 9; i++) {
        check_near(scale[i] * (i + 1) * (i + 1), scale[0], 1e-15);
        check_near(scale[9 + i] * (i + 1), scale[9], 1e-15);
        check_near(scale[9 + i], 10 * (i + 1) * scale[i], 1e-15);
    }
    saltus_system_free(system);
}

/* The default initial state keeps the same distance from a stop in its way, relative to how far the modes
 * move there, wherever the stop is and in any unit of length. */
static void default_states_keep_their_distance(void **unused) {
    (void)unused;
    double first = 0;
    for (int k = 0; k < 12; k++) {
        saltus_spec spec = k < 6 ? pipe_spec(1, 20) : oscillator_spec(0.1, 1, 1, 1);
        saltus_message message = {.text = ""};
        double state[2];
        add_stop(&spec, k % 2 ? -0.004 : 0, 0.5, k % 3 ? SALTUS_UPPER : SALTUS_LOWER);
        spec.stops[0].xi = 0.02 + 0.09 * k;
        spec.stops[0].weight[0] = 0.1 * (k - 5);
        if (k == 9)
            spec.stops[0].d = -1000;
        saltus_system *system = build(&spec);
        check_ok(saltus_system_default_state(system, state, &message), &message);
        const double reach = fabs(saltus_system_stop_normal(system, 0)[0]),
                     scale = saltus_system_scale(system)[0],
                     kept = -saltus_system_gap(system, 0, state) / (reach * scale);
        const bool moved = fabs(state[0]) != 0.2 * scale;
        if (moved) {
            first = first ? first : kept;
            check_near(kept / first, 1, 1e-10);
        }
        assert_true(moved || kept > 0.04);
        saltus_system_free(system);
    }
    assert_true(first > 0);
}

/* How many steps an integrator takes in the second period of a motion without impacts. */
static double steps_in_a_period(const saltus_system *system, saltus_integrator integrator) {
    saltus_flow_options options = saltus_flow_defaults();
    double state[2 * 14];
    options.rtol = 1e-10;
    options.atol = 1e-13;
    options.integrator = integrator;
    assert_int_equal(saltus_system_default_state(system, state, NULL), SALTUS_OK);
    saltus_flow *flow = open_flow(system, &options, 0, state);
    advance(flow, 1, 0);
    const long long first = saltus_flow_information(flow, 0).steps;
    advance(flow, 2, 0);
    const saltus_flow_info info = saltus_flow_information(flow, 0);
    assert_true(info.impacts == 0);
    saltus_flow_free(flow);
    return (double)(info.steps - first);
}

/* Collocation is mixed in if stability makes Taylor's steps so short that a motion takes some three times as
 * many of them for each mode, which is how much more a step of collocation costs; where several trajectories
 * run in lanes, the more of these the less of a pack one of them fills. For masses: if damping is faster than
 * the forcing by some two hundred, in any unit of time; so strongly damped, they only creep by themselves. */
static void the_integrator_follows_the_stiffness(void **unused) {
    (void)unused;
    const double omegas[] = {20, 42, 55};
    int stiff = 0, all = 0;
    for (int modes = 5; modes <= 14; modes++)
        for (int k = 0; k < 12; k++) {
            const bool stop = k % 2, damped = k / 2 % 2;
            saltus_spec spec = pipe_spec(damped ? modes / 2 : modes, omegas[k / 4]);
            if (stop)
                add_stop(&spec, 0.3, 0.5, SALTUS_UPPER);
            /* The damping of mode i goes with i^4. */
            set_parameter(&spec, "alpha", damped ? 0.005 * 16 : 0.005);
            saltus_system *system = build(&spec);
            const bool chosen = strcmp(saltus_system_integrator(system), "mixed") == 0,
                       alone = saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX) == 1;
            const double ratio =
                steps_in_a_period(system, SALTUS_TAYLOR) / steps_in_a_period(system, SALTUS_RADAU);
            const int dof = saltus_system_dof(system);
            const double low = 2.2 * dof, high = 4.2 * dof, gain = fmax(1, fmin(3, 18.0 / dof));
            if (!(chosen ? ratio > low : ratio < high) || !(alone ? ratio > gain * low : ratio < gain * high))
                fail_msg("%d modes, omega = %g, %s stop, %s: %s though Taylor takes %.0f times as many steps",
                         modes, omegas[k / 4], stop ? "a" : "no", damped ? "damped" : "plain",
                         saltus_system_integrator(system), ratio);
            assert_true(chosen || !alone);
            saltus_system_free(system);
            stiff += chosen;
            all++;
        }
    assert_true(stiff > all / 4 && stiff < all * 4 / 5);
    for (int k = 0; k < 24; k++) {
        const double unit = pow(7, k % 4 - 1), mass = k / 4 % 2 ? 3 : 1, over = k / 8 % 2 ? 1.1 : 0.9;
        const double stiffness = k < 8 ? 0.25 : 8;
        saltus_spec spec = oscillator_spec(0, 0, 0, 1 / unit);
        set_parameter(&spec, "m", mass);
        set_parameter(&spec, "k", stiffness * mass / (unit * unit));
        set_parameter(&spec, "c", 100 * over * mass / unit);
        saltus_system *system = build(&spec);
        assert_string_equal(saltus_system_integrator(system), over > 1 ? "mixed" : "taylor");
        saltus_system_free(system);
    }
}

/* The gap is linear; normals vanish exactly at nodes of a mode. */
static void geometry(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(6, 20);
    add_stop(&spec, 0.03, 0.9, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    const double *normal = saltus_system_stop_normal(system, 0);
    const double expected[6] = {1, 0, -1, 0, 1, 0};
    double state[12] = {0.01, 0.5, 0.002, -0.4, 0.001, 0.1};
    for (int i = 0; i < 6; i++)
        check_near(normal[i], expected[i], 1e-15);
    assert_int_equal(saltus_system_face_count(system), 2);
    check_near(saltus_system_gap(system, 0, state), 0.009 - 0.03, 1e-16);
    check_near(saltus_system_gap(system, 1, state), -0.009 - 0.03, 1e-16);
    check_near(saltus_system_shape(system, state, 0.5), 0.009, 1e-15);
    check_near(saltus_system_shape(system, state, 0), 0, 1e-15);
    check_near(saltus_system_shape(system, state, 1), 0, 1e-15);
    saltus_system_free(system);
}

/* The vector field is that of model.md: evaluated here term by term, and by the flow; its tangent action
 * against central differences, and the trace against the sum of the diagonal. */
static void field_of(const saltus_spec *spec, const double *x, double phase, double *f) {
    int n = (int)saltus_spec_get(spec, "N");
    double alpha = saltus_spec_get(spec, "alpha"), beta = saltus_spec_get(spec, "beta");
    double kappa = saltus_spec_get(spec, "kappa"), u0 = saltus_spec_get(spec, "u0");
    double sigma = saltus_spec_get(spec, "sigma"), omega = saltus_spec_get(spec, "omega");
    double u = u0 * (1 + sigma * sin(2 * M_PI * phase)), rate = u0 * sigma * omega * cos(2 * M_PI * phase);
    double s = 0, s1 = 0;
    for (int k = 1; k <= n; k++) {
        double l2 = k * k * M_PI * M_PI;
        s += 0.5 * l2 * x[k - 1] * x[k - 1];
        s1 += 0.5 * l2 * x[k - 1] * x[n + k - 1];
    }
    for (int i = 1; i <= n; i++) {
        double l2 = i * i * M_PI * M_PI,
               sum = alpha * l2 * l2 * x[n + i - 1] + (l2 * l2 - u * u * l2) * x[i - 1];
        sum += kappa * l2 * x[i - 1] * (s + 2 * alpha * s1) - sqrt(beta) * rate * l2 / 2 * x[i - 1];
        for (int j = 1; j <= n; j++)
            if ((i + j) % 2) {
                double difference = i * i - j * j;
                sum += 2 * sqrt(beta) * u * 4 * i * j / difference * x[n + j - 1];
                sum -= sqrt(beta) * rate * 8 * i * j * j * j / (difference * difference) * x[j - 1];
            }
        f[i - 1] = x[n + i - 1];
        f[n + i - 1] = -sum;
    }
}

static void vector_field(void **unused) {
    (void)unused;
    static const double rows[][5] = {
        /* N, sigma, kappa, beta, alpha */
        {5, 0.2, 5000, 0.64, 0.005}, {5, 0, 5000, 0.64, 0.005}, {3, 0.2, 0, 0.3, 0.01},
        {1, 0.2, 5000, 0.64, 0.005}, {4, 0, 0, 0, 0},           {8, 0.3, 100, 0.5, 0.001},
        {12, 0.2, 5000, 0.64, 0.005}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = pipe_spec(rows[k][0], 17);
        set_parameter(&spec, "sigma", rows[k][1]);
        set_parameter(&spec, "kappa", rows[k][2]);
        set_parameter(&spec, "beta", rows[k][3]);
        set_parameter(&spec, "alpha", rows[k][4]);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        int n = saltus_system_dof(system);
        double x[32], f[32], expected[32], trace = 0;
        for (int i = 0; i < 2 * n; i++)
            x[i] = 0.02 * sin(1.0 + 3 * i) * (i < n ? 1.0 / (i + 1) : 10);
        for (int p = 0; p < 8; p++) {
            saltus_flow *flow = open_flow(system, &options, 0.125 * p, x);
            saltus_flow_field(flow, 0, f);
            field_of(&spec, x, 0.125 * p, expected);
            for (int i = 0; i < 2 * n; i++)
                check_near(f[i], expected[i], 1e-13 * (fabs(expected[i]) + 100 * n * n));
            saltus_flow_free(flow);
        }
        for (int i = 0; i < 2 * n; i++) {
            double h = 1e-5, plus[32], minus[32], kept = x[i];
            x[i] = kept + h;
            field_of(&spec, x, 0.3, plus);
            x[i] = kept - h;
            field_of(&spec, x, 0.3, minus);
            x[i] = kept;
            trace += (plus[i] - minus[i]) / (2 * h);
        }
        check_near(saltus_system_trace(system, x, 0), trace, 1e-8 * (1 + fabs(trace)));
        saltus_system_free(system);
    }
}

static void flow_options_are_checked(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(2, 20);
    saltus_system *system = build(&spec);
    saltus_message message = {.text = ""};
    saltus_flow *flow;
    const saltus_system *const one[] = {system};
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1;
    assert_int_equal(saltus_flow_new(one, 1, &options, &flow, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "rtol"));
    options = saltus_flow_defaults();
    options.order = 3;
    assert_int_equal(saltus_flow_new(one, 1, &options, &flow, &message), SALTUS_BAD_INPUT);
    options = saltus_flow_defaults();
    options.atol = NAN;
    assert_int_equal(saltus_flow_new(one, 1, &options, &flow, &message), SALTUS_BAD_INPUT);
    options = saltus_flow_defaults();
    assert_int_equal(saltus_flow_new(one, 0, &options, &flow, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_flow_new(one, 100, &options, &flow, &message), SALTUS_BAD_INPUT);
    saltus_system_free(system);
}

/* A kernel can be forced by name; an unknown name is refused, not ignored. */
static void forced_instruction_sets(void **unused) {
    (void)unused;
    static const char *const names[] = {"x86-64", "x86-64-v3", "x86-64-v4", "x86-64-v5", ""};
    const char *forced = getenv("SALTUS_ISA");
    char *before = forced ? strdup(forced) : NULL;
    saltus_spec spec = pipe_spec(2, 20);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    for (int k = 0; k < 5; k++) {
        saltus_message message = {.text = ""};
        saltus_flow *flow = NULL;
        setenv("SALTUS_ISA", names[k], 1);
        saltus_status status =
            saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message);
        assert_int_equal(status, k < 3 ? SALTUS_OK : SALTUS_BAD_INPUT);
        assert_int_equal(strstr(message.text, "SALTUS_ISA") != NULL, k >= 3);
        saltus_flow_free(flow);
    }
    if (before)
        setenv("SALTUS_ISA", before, 1);
    else
        unsetenv("SALTUS_ISA");
    free(before);
    saltus_system_free(system);
}

/* A disturbance has about the requested size and passes no stop, however near, also if both directions would;
 * a held face keeps the state and velocity along its normal. */
static void disturbed_states(void **unused) {
    (void)unused;
    const double size = 1e-5;
    saltus_spec spec = pipe_spec(4, 20);
    add_stop(&spec, 1e-9, 0.9, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    const double *scale = saltus_system_scale(system);
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    for (int k = 0; k < 200; k++) {
        const unsigned contacts = k % 2;
        double before[8] = {0}, after[8], normal_velocity = 0, largest = 0;
        before[0] = contacts ? 1e-9 / saltus_system_stop_normal(system, 0)[0] : 0;
        memcpy(after, before, sizeof after);
        saltus_state_disturb(system, rng, size, contacts, after);
        assert_int_equal(saltus_system_check_state(system, after, NULL), SALTUS_OK);
        for (int i = 0; i < 8; i++)
            largest = fmax(largest, fabs(after[i] - before[i]) / scale[i]);
        assert_true(largest > 0.1 * size && largest < 100 * size);
        for (int i = 0; i < 4; i++)
            normal_velocity += saltus_system_stop_normal(system, 0)[i] * (after[4 + i] - before[4 + i]);
        if (contacts) {
            check_near(saltus_system_gap(system, 0, after), 0, 1e-18);
            check_near(normal_velocity, 0, 1e-18);
        }
    }
    gsl_rng_free(rng);
    saltus_system_free(system);
}

/* |T(z)| for the Taylor polynomial T of the exponential. */
static double polynomial_modulus(int order, double complex z) {
    double complex sum = 1, term = 1;
    for (int k = 1; k <= order; k++) {
        term *= z / k;
        sum += term;
    }
    return cabs(sum);
}

/* The largest of these after a step over the eigenvalues, with growing modes taken as decaying. */
static double largest_modulus(const saltus_eigenvalues *known, int order, double step) {
    double largest = 0;
    for (int i = 0; i < known->count; i++) {
        double complex rate = -fabs(known->real[i]) + I * known->imaginary[i];
        largest = fmax(largest, polynomial_modulus(order, rate * step));
    }
    return largest;
}

/* Within the step limit the polynomial of no order lets a mode grow, up to a hundredth of a percent; if
 * stability sets the limit, one grows within two strides of the search beyond it. */
static void steps_end_where_modes_grow(void **unused) {
    (void)unused;
    enum { places = 400 };
    const double modes[] = {1, 2, 3, 5, 8, 12}, tolerated = 1.0001 + 1e-9;
    int bounded = 0;
    for (size_t m = 0; m < sizeof modes / sizeof modes[0]; m++) {
        saltus_spec spec = pipe_spec(modes[m], 42);
        saltus_system *system = build(&spec);
        saltus_eigenvalues known;
        saltus_system_eigenvalues(system, &known);
        for (int order = 8; order <= 40; order += 2) {
            const double limit = saltus_system_step_limit(system, &known, order);
            const double cap = fmin((order > 14 ? 6 : order) / system->rate, 6 / system->omega);
            for (int k = 1; k <= places; k++)
                assert_true(largest_modulus(&known, order, limit * k / places) <= tolerated);
            assert_true(limit > 0 && limit <= cap);
            if (limit < cap * (1 - 1e-9)) {
                assert_true(largest_modulus(&known, order, 1.0404 * limit) > 1.0001);
                bounded++;
            }
        }
        saltus_system_free(system);
    }
    assert_true(bounded > 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(disturbed_states),
        cmocka_unit_test(refused_parameters),
        cmocka_unit_test(refused_stops),
        cmocka_unit_test(refused_oscillators),
        cmocka_unit_test(refusals_tell_the_numbers),
        cmocka_unit_test(limits_of_stops),
        cmocka_unit_test(scales_are_typical),
        cmocka_unit_test(default_states_keep_their_distance),
        cmocka_unit_test(the_integrator_follows_the_stiffness),
        cmocka_unit_test(steps_end_where_modes_grow),
        cmocka_unit_test(geometry),
        cmocka_unit_test(vector_field),
        cmocka_unit_test(flow_options_are_checked),
        cmocka_unit_test(forced_instruction_sets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
