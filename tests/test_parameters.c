/* Parameter columns against differences of whole runs and against closed forms.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "reference.h"

enum { dimension_max = 24, columns_max = dimension_max + SALTUS_DIRECTIONS_MAX, levels = 4 };

/* A motion for checking derivatives. */
typedef struct motion {
    saltus_spec spec;
    saltus_integrator integrator;
    double state[dimension_max];
    double start, end; /* periods */
    double step;       /* first step of the differences, relative to the parameter */
} motion;

typedef struct run_result {
    double state[dimension_max];
    saltus_flow_info info;
} run_result;

static run_result run_shifted(const motion *m, const saltus_direction *direction, double amount) {
    saltus_spec spec = saltus_spec_shifted(&m->spec, direction, amount);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    run_result result;
    options.rtol = 1e-14;
    options.integrator = m->integrator;
    saltus_flow *flow = open_flow(system, &options, m->start, m->state);
    advance(flow, m->end, 0);
    saltus_flow_state(flow, 0, result.state);
    result.info = saltus_flow_information(flow, 0);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return result;
}

/* Extrapolated differences (Richardson) with steps h, h/2, ...: central, or forward if the parameter is at
 * its lowest value. */
static void differentiate(const motion *m, const saltus_direction *direction, double h, bool forward, int n,
                          double *derivative) {
    double table[levels][dimension_max];
    run_result centre = run_shifted(m, direction, 0);
    for (int k = 0; k < levels; k++, h /= 2) {
        run_result above = run_shifted(m, direction, h),
                   below = forward ? centre : run_shifted(m, direction, -h);
        assert_int_equal(above.info.sticks, centre.info.sticks);
        assert_int_equal(below.info.sticks, centre.info.sticks);
        for (int i = 0; i < n; i++)
            table[k][i] = (above.state[i] - below.state[i]) / (forward ? h : 2 * h);
    }
    for (int j = 1; j < levels; j++)
        for (int k = levels - 1; k >= j; k--)
            for (int i = 0; i < n; i++)
                table[k][i] += (table[k][i] - table[k - 1][i]) / (exp2(forward ? j : 2 * j) - 1);
    memcpy(derivative, table[levels - 1], (size_t)n * sizeof *derivative);
}

/* The flow also carries the identity's columns: they must have no effect. */
static saltus_flow *open_columns(const motion *m, const saltus_system *system,
                                 const saltus_direction *directions, int count) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_flow *flow = NULL;
    options.rtol = 1e-14;
    options.integrator = m->integrator;
    options.columns = saltus_system_dimension(system) + count;
    options.directions = count;
    check_ok(saltus_flow_new(&system, 1, &options, &flow, &message), &message);
    saltus_flow_set_directions(flow, directions);
    check_ok(saltus_flow_start(flow, 0, (saltus_time){0, m->start}, m->state, &message), &message);
    return flow;
}

static saltus_direction direction_of(const saltus_spec *spec, const char *key, double *value) {
    saltus_direction direction;
    saltus_message message = {.text = ""};
    check_ok(saltus_spec_direction(spec, key, &direction, value, &message), &message);
    return direction;
}

/* The parameter column of one key at the motion's end. */
static void column_of(const motion *m, const char *key, double *column) {
    double columns[columns_max * dimension_max];
    saltus_direction direction = direction_of(&m->spec, key, NULL);
    saltus_system *system = build(&m->spec);
    saltus_flow *flow = open_columns(m, system, &direction, 1);
    size_t n = (size_t)saltus_system_dimension(system);
    advance(flow, m->end, 0);
    saltus_flow_tangents(flow, 0, columns);
    memcpy(column, columns + n * n, n * sizeof *column);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* The largest difference of two vectors relative to the second, in the system's units. */
static double distance(const saltus_system *system, const double *a, const double *b) {
    const double *scale = saltus_system_scale(system);
    double difference = 0, size = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++) {
        difference = fmax(difference, fabs(a[i] - b[i]) / scale[i]);
        size = fmax(size, fabs(b[i]) / scale[i]);
    }
    return size > 0 ? difference / size : difference;
}

static void check_direction(const motion *m, const char *key, double fallback, double tolerance) {
    double value, column[dimension_max], expected[dimension_max];
    saltus_direction direction = direction_of(&m->spec, key, &value);
    saltus_system *system = build(&m->spec);
    bool forward = value == 0 && strcmp(key, "kappa") == 0;
    column_of(m, key, column);
    differentiate(m, &direction, m->step * (value != 0 ? fabs(value) : fallback), forward,
                  saltus_system_dimension(system), expected);
    double error = distance(system, column, expected);
    if (!(error <= tolerance))
        fail_msg("%s: the column is off by %.3g of its size, beyond %.3g", key, error, tolerance);
    saltus_system_free(system);
}

/* All keys of a list, separated by blanks. */
static void check_keys(const motion *m, const char *keys, double tolerance) {
    char key[16];
    int length;
    for (const char *at = keys; sscanf(at, "%15s%n", key, &length) == 1; at += length)
        check_direction(m, key, strcmp(key, "kappa") == 0 ? 5000 : 1, tolerance);
}

static motion reference_motion(const char *name, double start, double end) {
    reference r = read_reference(name);
    motion m = {.spec = r.spec, .start = start, .end = end, .step = 1e-3};
    memcpy(m.state, r.states[0], (size_t)r.n * sizeof(double));
    return m;
}

static motion pipe_motion(double modes, double omega, double d, double end) {
    motion m = {.spec = pipe_spec(modes, omega), .end = end, .step = 1e-3};
    add_stop(&m.spec, d, 0.9, SALTUS_UPPER);
    m.state[0] = 0.01;
    if (modes > 1)
        m.state[1] = 0.004;
    m.state[(int)modes] = 0.15;
    return m;
}

static const char *const all_pipe_keys = "alpha beta kappa u0 sigma omega d r xi";

static void impacting_pipe(void **unused) {
    (void)unused;
    motion m = reference_motion("fig7d", 0, 2);
    check_keys(&m, all_pipe_keys, 1e-9);
}

/* Complete chatter, sticking, release. */
static void chattering_pipe(void **unused) {
    (void)unused;
    motion m = reference_motion("chatter25", 0, 0.7);
    m.step = 1e-4;
    check_keys(&m, all_pipe_keys, 1e-5);
    m.end = 2.2;
    check_keys(&m, all_pipe_keys, 1e-5);
}

/* Terms that the direction has and the scene lacks. */
static void reduced_pipes(void **unused) {
    (void)unused;
    motion steady = pipe_motion(5, 30, 0.02, 2), linear = pipe_motion(4, 20, 0.015, 1.5),
           still = pipe_motion(3, 20, 0.015, 1.5), dry = still;
    set_parameter(&steady.spec, "sigma", 0);
    check_keys(&steady, all_pipe_keys, 1e-8);
    set_parameter(&linear.spec, "kappa", 0);
    set_parameter(&linear.spec, "u0", 2);
    check_keys(&linear, all_pipe_keys, 1e-9);
    set_parameter(&still.spec, "u0", 0);
    check_keys(&still, all_pipe_keys, 1e-9);
    set_parameter(&dry.spec, "beta", 0);
    check_keys(&dry, "alpha kappa u0 sigma omega d r xi", 1e-9);
}

static void other_pipes(void **unused) {
    (void)unused;
    motion one = pipe_motion(1, 14, 0.035, 3), free_flight = pipe_motion(5, 30.5, 0.03, 2);
    one.spec.stops[0].sides = SALTUS_BOTH;
    check_keys(&one, all_pipe_keys, 1e-9);
    free_flight.spec.stop_count = 0;
    check_keys(&free_flight, "alpha beta kappa u0 sigma omega", 1e-9);
}

static void stiff_pipe(void **unused) {
    (void)unused;
    motion m = pipe_motion(12, 38, 0.02, 1.5), sticking = pipe_motion(12, 10, 0.02, 1.3),
           five = reference_motion("fig7d", 0, 1);
    m.integrator = five.integrator = SALTUS_RADAU;
    m.start = 0.2;
    check_keys(&m, all_pipe_keys, 1e-7);
    sticking.spec.stops[0].xi = 0.45;
    sticking.spec.stops[0].r = 0.4;
    sticking.step = 1e-4;
    check_keys(&sticking, "alpha beta kappa u0 sigma omega d xi", 1e-5);
    sticking.step = 5e-3; /* almost no effect of r is left after the contact */
    check_keys(&sticking, "r", 1e-5);
    check_keys(&five, all_pipe_keys, 1e-9);
}

static motion oscillator_motion(void) {
    motion m = {.spec = oscillator_spec(0.12, 1.3, 0.8, 0.9), .end = 3, .step = 1e-3};
    set_parameter(&m.spec, "m", 1.4);
    set_parameter(&m.spec, "F0", 0.1);
    m.state[0] = 0.1;
    m.state[1] = 0.2;
    return m;
}

static motion chattering_mass(void) {
    motion m = oscillator_motion();
    m.state[0] = 0.05;
    m.step = 1e-4;
    add_stop(&m.spec, 0.1, 0.6, SALTUS_UPPER);
    set_parameter(&m.spec, "F0", 0.4);
    return m;
}

static void one_mass(void **unused) {
    (void)unused;
    motion m = oscillator_motion();
    add_stop(&m.spec, 0.3, 0.8, SALTUS_BOTH);
    check_keys(&m, "m c k F F0 omega d r", 1e-9);
    set_parameter(&m.spec, "kz", 0.7);
    set_parameter(&m.spec, "tz", 1.9);
    m.state[2] = 0.05;
    check_keys(&m, "m c k F F0 omega kz tz d r", 1e-9);
    m.integrator = SALTUS_RADAU;
    check_keys(&m, "m c k F F0 omega kz tz d r", 1e-8);
    m.integrator = SALTUS_TAYLOR;
    set_parameter(&m.spec, "F", 0);
    m.state[1] = 0.9;
    check_keys(&m, "m c k F F0 omega kz tz d r", 1e-9);
    motion chatter = chattering_mass();
    check_keys(&chatter, "m c k F F0 omega d r", 1e-5);
}

static motion two_mass_motion(void) {
    motion m = oscillator_motion();
    set_parameter(&m.spec, "N", 2);
    set_parameter(&m.spec, "m2", 0.8);
    set_parameter(&m.spec, "c2", 0.05);
    set_parameter(&m.spec, "k2", 0.9);
    set_parameter(&m.spec, "F2", 0.3);
    set_parameter(&m.spec, "F02", -0.1);
    return m;
}

static const char *const two_mass_keys = "m c k F F0 m2 c2 k2 F2 F02 omega";

static void two_masses(void **unused) {
    (void)unused;
    motion m = two_mass_motion();
    add_stop(&m.spec, 0.25, 0.8, SALTUS_UPPER);
    m.spec.stops[0].weight[1] = -1;
    add_stop(&m.spec, 0.6, 0.6, SALTUS_BOTH);
    check_keys(&m, two_mass_keys, 1e-8);
    check_keys(&m, "d1 d2 r1 r2", 1e-8);
    /* Mass 1 rests on its stop and is hit there by mass 2: an impulse at each. */
    motion held = two_mass_motion();
    set_parameter(&held.spec, "F0", 3);
    set_parameter(&held.spec, "F2", 0.8);
    add_stop(&held.spec, 0, 0.5, SALTUS_UPPER);
    add_stop(&held.spec, 0.1, 0.7, SALTUS_UPPER);
    held.spec.stops[1].weight[0] = -1;
    held.spec.stops[1].weight[1] = 1;
    memset(held.state, 0, sizeof held.state);
    held.state[0] = -0.05;
    held.step = 1e-4;
    check_keys(&held, two_mass_keys, 1e-5);
    check_keys(&held, "d1 d2 r1 r2", 1e-5);
    held.integrator = SALTUS_RADAU;
    check_keys(&held, two_mass_keys, 1e-5);
    check_keys(&held, "d1 d2 r1 r2", 1e-5);
}

/* The time of the first event of a kind, in periods, and its derivative by the parameter column. */
static double event_time(const motion *m, const saltus_spec *spec, const saltus_direction *direction,
                         saltus_event_kind kind, double *delay) {
    saltus_system *system = build(spec);
    double delays[columns_max];
    saltus_flow *flow = open_columns(m, system, direction, 1);
    saltus_event event = advance(flow, m->end, 1u << kind);
    assert_int_equal(event.kind, kind);
    saltus_flow_delays(flow, 0, delays);
    *delay = delays[saltus_system_dimension(system)] / saltus_system_period(system);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return saltus_time_periods(event.time);
}

static void check_delay(const motion *m, const char *key, saltus_event_kind kind) {
    double value, delay, rough[2], unused;
    saltus_direction direction = direction_of(&m->spec, key, &value);
    event_time(m, &m->spec, &direction, kind, &delay);
    for (int j = 0; j < 2; j++) {
        double h = 5e-4 * value / (j + 1);
        saltus_spec above = saltus_spec_shifted(&m->spec, &direction, h),
                    below = saltus_spec_shifted(&m->spec, &direction, -h);
        rough[j] = (event_time(m, &above, &direction, kind, &unused) -
                    event_time(m, &below, &direction, kind, &unused)) /
                   (2 * h);
    }
    double expected = (4 * rough[1] - rough[0]) / 3;
    check_near(delay, expected, 1e-8 * fabs(expected) + 1e-11);
}

static void event_delays(void **unused) {
    (void)unused;
    static const char *const keys[] = {"omega", "d", "xi", "u0", "alpha"};
    motion m = pipe_motion(5, 30, 0.02, 2);
    m.spec.stops[0].xi = 0.42;
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        check_delay(&m, keys[k], SALTUS_IMPACT);
        check_delay(&m, keys[k], SALTUS_TURNING);
    }
}

/* An observed quantity that depends on parameters, once also equal to a stop's row: the zeros of its velocity
 * move with them. */
static void observed_rows_have_derivatives(void **unused) {
    (void)unused;
    static const char text[] =
        "model:\n"
        "  parameters: {c: 0.6, k: 1.7, omega: 1.1}\n"
        "  motion:\n"
        "    x: -x - 0.1*x' - 0.3*y + cos(omega*t)\n"
        "    y: -k*y - 0.2*y' - 0.3*x - y^3\n"
        "  forcing: omega\n"
        "  observe: {turned: \"c*x + sqrt(1 - c^2)*(y + k*x)\", one: \"x*c/0.6\", own: \"x - k*c*y\"}\n"
        "stops:\n"
        "  - {coordinate: x, d: 5, r: 0.8}\n"
        "  - {coordinate: \"x - k*c*y\", d: 6, r: 0.8}\n";
    static const char *const observed[] = {"turned", "one", "own", "stop1", "stop2", "y"};
    static const char *const keys[] = {"c", "k", "omega"};
    saltus_scene scene = {.title = ""};
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    for (size_t o = 0; o < sizeof observed / sizeof observed[0]; o++)
        for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
            motion m = {.spec = scene.spec, .state = {0.3, -0.2, 0.4, 0.7}, .start = 0.2, .end = 3};
            strcpy(m.spec.observe, observed[o]);
            check_delay(&m, keys[k], SALTUS_TURNING);
        }
    saltus_scene_clear(&scene);
}

/* m x'' + k x = F cos(omega t) at a fixed phase: x = A cos(omega t) + (x0 - A) cos(nu t) + v0 / nu sin(nu t)
 * with A = F / (k - m omega^2) and nu^2 = k / m. */
static void undamped_response(void **unused) {
    (void)unused;
    const double mass = 1.4, k = 1.3, force = 0.8, omega = 0.9, x0 = 0.3, v0 = -0.2, periods = 2.3;
    motion m = {.spec = oscillator_spec(0, k, force, omega), .state = {x0, v0}, .end = periods};
    set_parameter(&m.spec, "m", mass);
    const double stiff = k - mass * omega * omega, a = force / stiff, nu = sqrt(k / mass),
                 t = periods * 2 * M_PI / omega, c = cos(nu * t), s = sin(nu * t), co = cos(omega * t),
                 so = sin(omega * t);
    /* Derivatives of A, nu, omega and t for each key. */
    const struct {
        const char *key;
        double a, nu, omega, t;
    } rows[] = {{"F", 1 / stiff, 0, 0, 0},
                {"k", -a / stiff, nu / (2 * k), 0, 0},
                {"m", a * omega * omega / stiff, -nu / (2 * mass), 0, 0},
                {"omega", 2 * a * mass * omega / stiff, 0, 1, -t / omega}};
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        double da = rows[i / 2].a, dnu = rows[i / 2].nu, domega = rows[i / 2].omega, column[dimension_max];
        double turn = dnu * t + nu * rows[i / 2].t, sweep = domega * t + omega * rows[i / 2].t;
        double x = da * (co - c) - a * so * sweep - (x0 - a) * s * turn + v0 / nu * c * turn -
                   v0 * dnu / (nu * nu) * s;
        double v = -da * (omega * so - nu * s) - a * (domega * so + omega * co * sweep) -
                   (x0 - a) * (dnu * s + nu * c * turn) - v0 * s * turn;
        m.integrator = i % 2 ? SALTUS_RADAU : SALTUS_TAYLOR;
        column_of(&m, rows[i / 2].key, column);
        check_near(column[0], x, 1e-12 * (1 + fabs(x) + fabs(v)));
        check_near(column[1], v, 1e-12 * (1 + fabs(x) + fabs(v)));
    }
}

/* A ball that falls by g = F0 / m from 0 to d and bounces once, at t1 = sqrt(2 d / g) with w = sqrt(2 d g):
 * x = d - r w s + g s^2 / 2 with s = t - t1. */
static void bouncing_ball(void **unused) {
    (void)unused;
    const double d = 0.7, r = 0.8, g = 1.9, t1 = sqrt(2 * d / g), w = sqrt(2 * d * g), t = 1.3 * t1,
                 s = t - t1;
    motion m = {.spec = oscillator_spec(0, 0, 0, 2 * M_PI), .end = t};
    set_parameter(&m.spec, "F0", g);
    add_stop(&m.spec, d, r, SALTUS_UPPER);
    /* Derivatives of d, r, g and omega for each key. */
    const struct {
        const char *key;
        double d, r, g, omega;
    } rows[] = {
        {"d", 1, 0, 0, 0}, {"r", 0, 1, 0, 0}, {"F0", 0, 0, 1, 0}, {"m", 0, 0, -g, 0}, {"omega", 0, 0, 0, 1}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        double dd = rows[i].d, dr = rows[i].r, dg = rows[i].g, column[dimension_max], delay;
        double late = t1 * (dd / (2 * d) - dg / (2 * g)), dw = w * (dd / (2 * d) + dg / (2 * g)),
               ds = -rows[i].omega * t / (2 * M_PI) - late;
        double x = dd - (dr * w + r * dw) * s - r * w * ds + dg * s * s / 2 + g * s * ds,
               v = -dr * w - r * dw + dg * s + g * ds;
        saltus_direction direction = direction_of(&m.spec, rows[i].key, NULL);
        check_near(event_time(&m, &m.spec, &direction, SALTUS_IMPACT, &delay), t1, 1e-14);
        check_near(delay, late + rows[i].omega * t1 / (2 * M_PI), 1e-14);
        column_of(&m, rows[i].key, column);
        check_near(column[0], x, 1e-14);
        check_near(column[1], v, 1e-14);
    }
}

/* The column of a linear combination is the combination of columns, through chatter and sticking. */
static void combined_directions(void **unused) {
    (void)unused;
    static const char *const keys[] = {"omega", "xi", "d1", "r", "sigma"};
    static const double weights[] = {0.3, -0.7, 0.01, 0.02, 1.1};
    motion m = reference_motion("chatter25", 0, 1.1);
    saltus_system *system = build(&m.spec);
    int n = saltus_system_dimension(system);
    double column[dimension_max], sum[dimension_max] = {0}, columns[columns_max * dimension_max];
    saltus_direction pair[2] = {{.parameter = {0}}, direction_of(&m.spec, "alpha", NULL)};
    for (int k = 0; k < 5; k++) {
        saltus_direction one = direction_of(&m.spec, keys[k], NULL);
        for (int j = 0; j < SALTUS_PARAMETERS_MAX; j++)
            pair[0].parameter[j] += weights[k] * one.parameter[j];
        pair[0].d[0] += weights[k] * one.d[0];
        pair[0].r[0] += weights[k] * one.r[0];
        pair[0].xi[0] += weights[k] * one.xi[0];
        column_of(&m, keys[k], column);
        for (int i = 0; i < n; i++)
            sum[i] += weights[k] * column[i];
    }
    saltus_flow *flow = open_columns(&m, system, pair, 2);
    advance(flow, m.end, 0);
    saltus_flow_tangents(flow, 0, columns);
    column_of(&m, "alpha", column);
    assert_true(distance(system, columns + n * n, sum) < 1e-12);
    assert_true(distance(system, columns + n * (n + 1), column) < 1e-12);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* State and tangent vectors at the end of a motion, in one array. */
static void record(const motion *m, saltus_flow *flow, double *out) {
    saltus_message message = {.text = ""};
    check_ok(saltus_flow_start(flow, 0, (saltus_time){0, m->start}, m->state, &message), &message);
    advance(flow, m->end, 0);
    saltus_flow_state(flow, 0, out);
    saltus_flow_tangents(flow, 0, out + saltus_system_dimension(saltus_flow_system(flow, 0)));
}

/* A flow that gets another system during a contact runs like a new one, bit for bit. */
static void check_retune(const motion *from, const motion *to, const char *key) {
    double fresh[(columns_max + 1) * dimension_max] = {0}, retuned[(columns_max + 1) * dimension_max] = {0};
    saltus_direction direction = direction_of(&to->spec, key, NULL);
    saltus_message message = {.text = ""};
    saltus_system *first = build(&from->spec), *second = build(&to->spec);
    for (int count = 0; count < 2; count++) {
        saltus_flow *flow = open_columns(to, second, &direction, count);
        record(to, flow, fresh);
        saltus_flow_free(flow);
        flow = open_columns(from, first, &direction, count);
        for (int again = 0; again < 2; again++) {
            advance(flow, from->end, SALTUS_WATCH_STICK);
            if (again == 0)
                check_ok(saltus_flow_retune(flow, 0, second, &message), &message);
            record(to, flow, retuned);
            assert_memory_equal(fresh, retuned, sizeof fresh);
            check_ok(saltus_flow_start(flow, 0, (saltus_time){0, to->start}, to->state, &message), &message);
        }
        saltus_flow_free(flow);
    }
    saltus_system_free(first);
    saltus_system_free(second);
}

static void retuned_pipes(void **unused) {
    (void)unused;
    motion m[3] = {reference_motion("chatter25", 0, 1.1), reference_motion("fig7d", 0, 1.2)};
    m[2] = m[1];
    set_parameter(&m[2].spec, "sigma", 0);
    set_parameter(&m[2].spec, "kappa", 0);
    set_parameter(&m[2].spec, "u0", 0);
    m[2].spec.stops[0].xi = 0.3;
    for (int k = 0; k < 9; k++)
        for (int integrator = SALTUS_TAYLOR; integrator <= SALTUS_MIXED; integrator++) {
            m[k / 3].integrator = m[k % 3].integrator = (saltus_integrator)integrator;
            check_retune(&m[k / 3], &m[k % 3], "kappa");
            check_retune(&m[k / 3], &m[k % 3], "xi");
        }
}

static void retuned_masses(void **unused) {
    (void)unused;
    motion one = chattering_mass(), two = one;
    set_parameter(&two.spec, "F", 0);
    set_parameter(&two.spec, "omega", 2);
    check_retune(&one, &two, "m");
    check_retune(&two, &one, "omega");
}

/* Retuning a lane among others is like retuning a single flow. */
static void retuned_lane(void **unused) {
    (void)unused;
    motion one = chattering_mass(), two = one;
    saltus_message message = {.text = ""};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    saltus_event event;
    double state[dimension_max], alone[dimension_max];
    int lane = 0;
    set_parameter(&two.spec, "omega", 2);
    saltus_system *first = build(&one.spec), *second = build(&two.spec);
    const saltus_system *both[] = {first, first};
    check_ok(saltus_flow_new(both, 2, &options, &flow, &message), &message);
    check_ok(saltus_flow_retune(flow, 1, second, &message), &message);
    check_ok(saltus_flow_start(flow, 1, (saltus_time){0, 0}, two.state, &message), &message);
    saltus_flow_aim(flow, 1, (saltus_time){3, 0}, 0);
    check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    saltus_flow_state(flow, 1, state);
    saltus_flow_free(flow);
    flow = open_flow(second, &options, 0, two.state);
    advance(flow, 3, 0);
    saltus_flow_state(flow, 0, alone);
    assert_memory_equal(state, alone, (size_t)saltus_system_dimension(second) * sizeof *state);
    saltus_flow_free(flow);
    saltus_system_free(first);
    saltus_system_free(second);
}

static void unlike_systems_are_refused(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_spec spec = pipe_spec(5, 20), other = spec;
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    add_stop(&spec, 0.03, 0.9, SALTUS_UPPER);
    add_stop(&other, 0.03, 0.9, SALTUS_BOTH);
    saltus_system *system = build(&spec), *unlike = build(&other);
    const saltus_system *both[] = {system, system};
    check_ok(saltus_flow_new(both, 1, &options, &flow, &message), &message);
    assert_int_equal(saltus_flow_retune(flow, 0, unlike, &message), SALTUS_BAD_INPUT);
    saltus_flow_free(flow);
    options.directions = 1;
    assert_int_equal(saltus_flow_new(both, 1, &options, &flow, &message), SALTUS_BAD_INPUT);
    options.columns = 1;
    assert_int_equal(saltus_flow_new(both, 2, &options, &flow, &message), SALTUS_BAD_INPUT);
    saltus_system_free(system);
    saltus_system_free(unlike);
}

static void refused(const saltus_spec *spec, const char *key, const char *sentence) {
    saltus_message message = {.text = ""};
    saltus_direction direction;
    assert_int_equal(saltus_spec_direction(spec, key, &direction, NULL, &message), SALTUS_BAD_INPUT);
    if (!strstr(message.text, sentence))
        fail_msg("%s", message.text);
}

static void directions_by_key(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_direction direction;
    double value;
    saltus_spec spec = pipe_spec(5, 20);
    refused(&spec, "d", "no stop");
    add_stop(&spec, 0.03, 0.9, SALTUS_UPPER);
    add_stop(&spec, 0.03, 0.8, SALTUS_UPPER);
    spec.stops[1].xi = 0.3;
    refused(&spec, "N", "whole number");
    refused(&spec, "r", "the stops differ");
    refused(&spec, "d3", "fewer stops");
    refused(&spec, "sides", "neither");
    check_ok(saltus_spec_direction(&spec, "d", &direction, &value, &message), &message);
    check_near(value, 0.03, 0);
    assert_true(direction.d[0] == 1 && direction.d[1] == 1 && direction.r[0] == 0);
    check_ok(saltus_spec_direction(&spec, "r2", &direction, &value, &message), &message);
    check_near(value, 0.8, 0);
    check_near(saltus_spec_shifted(&spec, &direction, 0.05).stops[1].r, 0.85, 1e-15);
    check_ok(saltus_spec_direction(&spec, "omega", &direction, &value, &message), &message);
    check_near(saltus_spec_shifted(&spec, &direction, 0.5)
                   .parameters[saltus_model_parameter_index(spec.model, "omega")],
               20.5, 0);
    set_parameter(&spec, "beta", 0);
    refused(&spec, "beta", "root of beta");
    spec = oscillator_spec(0, 1, 1, 1);
    add_stop(&spec, 0.03, 0.9, SALTUS_UPPER);
    refused(&spec, "kz", "Maxwell");
    refused(&spec, "xi", "weight");
    refused(&spec, "r2", "only one stop");
    refused(&spec, "d0", "neither");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impacting_pipe),
        cmocka_unit_test(chattering_pipe),
        cmocka_unit_test(reduced_pipes),
        cmocka_unit_test(other_pipes),
        cmocka_unit_test(stiff_pipe),
        cmocka_unit_test(one_mass),
        cmocka_unit_test(two_masses),
        cmocka_unit_test(event_delays),
        cmocka_unit_test(observed_rows_have_derivatives),
        cmocka_unit_test(undamped_response),
        cmocka_unit_test(bouncing_ball),
        cmocka_unit_test(combined_directions),
        cmocka_unit_test(retuned_pipes),
        cmocka_unit_test(retuned_masses),
        cmocka_unit_test(retuned_lane),
        cmocka_unit_test(unlike_systems_are_refused),
        cmocka_unit_test(directions_by_key),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
