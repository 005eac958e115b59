/* Lyapunov exponents against independent results: multipliers in 128-bit arithmetic and in closed form, exact
 * impact maps iterated here, identities; and whether stated errors are true.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "allocations.h"
#include "branch_check.h"
#include "reference.h"

#include "saltus/average.h"
#include "saltus/lyapunov.h"

#include <complex.h>

static long allocations, failing = -1;

static bool refuse(void) {
    return ++allocations == failing;
}

/* Options for a short run from a state that has nearly settled. */
static saltus_lyapunov_options short_options(int members) {
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    if (!long_version()) {
        options.members = members;
        options.transient = 100;
    }
    return options;
}

static saltus_lyapunov run_from(const saltus_system *system, const double *state,
                                const saltus_lyapunov_options *options) {
    saltus_message message = {.text = ""};
    saltus_lyapunov result;
    check_ok(saltus_lyapunov_run(system, state, options, &result, &message), &message);
    return result;
}

/* A built-in scene with settings (separated by blanks). */
static saltus_system *scene_system(const char *name, const char *settings, double *state) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    char copy[256];
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    snprintf(copy, sizeof copy, "%s", settings);
    for (char *rest = copy, *word; (word = strtok_r(rest, " ", &rest));)
        check_ok(saltus_scene_set(&scene, word, &message), &message);
    saltus_system *system = build(&scene.spec);
    check_ok(saltus_scene_state(&scene, system, state, &message), &message);
    saltus_scene_clear(&scene);
    return system;
}

static saltus_lyapunov run_scene(const char *name, const char *settings,
                                 const saltus_lyapunov_options *options) {
    double state[64];
    saltus_system *system = scene_system(name, settings, state);
    saltus_lyapunov result = run_from(system, state, options);
    saltus_system_free(system);
    return result;
}

static void check_sum_rule(const saltus_lyapunov *l) {
    check_near(l->sum, l->sum_rule, 1e-6);
}

static double sum_of(const saltus_lyapunov *l) {
    double sum = 0;
    for (int k = 0; k < l->count; k++)
        sum += l->exponents[k];
    return sum;
}

/* Properties of every result. */
static void check_whole(const saltus_lyapunov *l) {
    assert_int_equal(l->periods % l->members, 0);
    check_near(l->time, (double)l->periods * l->period, 1e-9 * l->time);
    for (int k = 0; k < l->count; k++) {
        assert_true(!isnan(l->exponents[k]) && l->standard_errors[k] >= 0);
        if (k > 0)
            assert_true(l->exponents[k] <=
                        l->exponents[k - 1] + hypot(l->standard_errors[k], l->standard_errors[k - 1]));
    }
    for (int k = 1; k < l->history_count; k++)
        assert_true(l->history[k].time > l->history[k - 1].time);
    if (l->count == l->dimension && l->lost == 0) {
        check_near(l->sum, sum_of(l), 1e-9 * fabs(l->sum) + 1e-12);
        check_sum_rule(l);
    } else
        assert_true(isnan(l->sum) && isnan(l->sum_rule));
}

/* The exponents of an orbit are the logarithms of its multipliers' moduli over `time`; `close` is the
 * accuracy of these. */
static void check_orbit(const saltus_lyapunov *l, const double *log_moduli, int count, double time,
                        double close, const char *what) {
    check_whole(l);
    for (int k = 0; k < count; k++) {
        double apart = fabs(l->exponents[k] - log_moduli[k] / time);
        if (!(apart <= 3 * l->standard_errors[k] + close))
            fail_msg("%s, exponent %d: %.12g should be %.12g, %.3g beyond the error %.3g", what, k + 1,
                     l->exponents[k], log_moduli[k] / time, apart, l->standard_errors[k]);
    }
    if (!(l->precise && l->agree))
        fail_msg("%s: precise %d, agree %d", what, l->precise, l->agree);
    assert_true(fabs(l->half[0] - l->half[1]) <= 4 * hypot(l->half_errors[0], l->half_errors[1]));
}

/* From a disturbed state of each reference orbit, for both numbers of exponents. */
static void reference_orbits(void **unused) {
    (void)unused;
    static const char *const names[] = {"fig7d", "fig7b", "sdof14", "chatter25"};
    for (int k = 0; k < 4; k++)
        for (int all = getenv("SALTUS_SANITIZED") ? 1 : 0; all < (k < 3 || long_version() ? 2 : 1); all++) {
            reference r = read_reference(names[k]);
            saltus_system *system = build(&r.spec);
            saltus_lyapunov_options options = short_options(2);
            double log_moduli[16];
            options.exponents = all ? 0 : r.multiplier_count;
            options.seed = 3;
            saltus_lyapunov l = run_from(system, r.states[0], &options);
            for (int m = 0; m < r.multiplier_count; m++)
                log_moduli[m] = log(hypot(r.multipliers[m][0], r.multipliers[m][1]));
            check_orbit(&l, log_moduli, r.multiplier_count, r.periods * saltus_system_period(system), 1e-8,
                        names[k]);
            assert_int_equal(l.lost, k == 3 ? 2 : 0);
            check_near(l.sticks_per_period, (double)r.sticking / r.periods, 0.01);
            if (k < 3)
                check_near(l.impacts_per_period, r.event_count / (double)r.periods, 0.01);
            check_near(l.kaplan_yorke, 0, 0);
            saltus_lyapunov_clear(&l);
            saltus_system_free(system);
        }
}

/* The scenes of these orbits from their default states, and other orbits found by shooting. */
static void scenes_and_shooting(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const rows[][2] = {{"fig3", ""},        {"two-mass", ""}, {"near-grazing", ""},
                                          {"impact-pair", ""}, {"fig7b", ""},    {"fig6", "omega=14"},
                                          {"fig7d", ""},       {"fig2", ""},     {"chatter", ""}};
    for (int k = 0; k < (long_version() ? 9 : 5); k++) {
        saltus_message message = {.text = ""};
        saltus_classify_options classify = saltus_classify_defaults();
        saltus_lyapunov_options options = short_options(2);
        saltus_motion motion;
        double state[64], log_moduli[64];
        saltus_system *system = scene_system(rows[k][0], rows[k][1], state);
        options.exponents = 0;
        check_ok(saltus_classify(system, state, &classify, &motion, &message), &message);
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        saltus_lyapunov l = run_from(system, long_version() ? state : motion.state, &options);
        int resolved = 0;
        while (resolved < l.count && isfinite(motion.multipliers[resolved].log_modulus)) {
            log_moduli[resolved] = motion.multipliers[resolved].log_modulus;
            resolved++;
        }
        check_orbit(&l, log_moduli, resolved, motion.periods * l.period, 1e-8, rows[k][0]);
        if (motion.impacts >= 0)
            check_near(l.impacts_per_period, (double)motion.impacts / motion.periods, 0.01);
        saltus_lyapunov_clear(&l);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* x'' + c x' + k x = F cos(omega t) + F0 below a stop at x = d, v -> -r v there: flight in closed form. */
typedef struct impactor {
    double c, k, F, F0, omega, d, r;
} impactor;

/* The derivative of the state after free flight of time s by the state before. */
static void free_response(const impactor *o, double s, double e[4]) {
    double a = 0.5 * o->c, w = sqrt(o->k - a * a), decay = exp(-a * s);
    double sine = o->k > 0 ? sin(w * s) / w : s, cosine = o->k > 0 ? cos(w * s) : 1;
    e[0] = decay * (cosine + a * sine);
    e[1] = decay * sine;
    e[2] = -o->k * e[1];
    e[3] = decay * (cosine - a * sine);
}

/* The periodic solution without impact. */
static void steady(const impactor *o, double t, double x[2]) {
    double complex z = o->F / (o->k - o->omega * o->omega + I * o->c * o->omega) * cexp(I * o->omega * t);
    x[0] = creal(z) + o->F0 / o->k;
    x[1] = creal(I * o->omega * z);
}

/* The state (x, v) at time t + s from that at t. */
static void fly(const impactor *o, double t, double s, const double from[2], double to[2]) {
    if (o->k > 0) {
        double e[4], before[2], after[2];
        free_response(o, s, e);
        steady(o, t, before);
        steady(o, t + s, after);
        to[0] = after[0] + e[0] * (from[0] - before[0]) + e[1] * (from[1] - before[1]);
        to[1] = after[1] + e[2] * (from[0] - before[0]) + e[3] * (from[1] - before[1]);
        return;
    }
    double w = o->omega, begin = w * t, end = w * (t + s), f = o->F / w;
    to[0] = from[0] + (from[1] - f * sin(begin)) * s + 0.5 * o->F0 * s * s - f / w * (cos(end) - cos(begin));
    to[1] = from[1] + o->F0 * s + f * (sin(end) - sin(begin));
}

static double acceleration(const impactor *o, double t, double x, double v) {
    return o->F * cos(o->omega * t) + o->F0 - o->c * v - o->k * x;
}

/* The flight time from just after an impact (time t, velocity v < 0) to the next one; *u is the velocity
 * before that. */
static double next_impact(const impactor *o, double t, double v, double *u) {
    const double from[2] = {o->d, v}, stride = 0.01 / o->omega;
    double to[2], a = acceleration(o, t, o->d, v), low = 0, high = stride;
    fly(o, t, high, from, to);
    if (to[0] >= o->d)
        low = a > 0 ? fmin(-v / a, 0.5 * stride) : 1e-6 * stride;
    while (to[0] < o->d) {
        low = high;
        high += stride;
        fly(o, t, high, from, to);
    }
    for (int k = 0; k < 60 && high - low > 1e-15 * high; k++) {
        double middle = 0.5 * (low + high);
        fly(o, t, middle, from, to);
        *(to[0] < o->d ? &low : &high) = middle;
    }
    fly(o, t, high, from, to);
    *u = to[1];
    return high;
}

/* Derivative of the map from (time, velocity) after an impact to those after the next, row-major, by
 * implicit differentiation of x(s) = d. */
static void impact_jacobian(const impactor *o, double t, double v, double s, double u, double j[4]) {
    double e[4], a = acceleration(o, t, o->d, v), b = acceleration(o, t + s, o->d, u);
    free_response(o, s, e);
    double x_time = -(e[0] * v + e[1] * a), u_time = -(e[2] * v + e[3] * a);
    j[0] = -x_time / u;
    j[1] = -e[1] / u;
    j[2] = -o->r * (u_time + b * j[0]);
    j[3] = -o->r * (e[3] + b * j[1]);
}

/* Logarithms of the moduli of both eigenvalues, the larger first. */
static void log_eigenvalues(const double j[4], double log_moduli[2]) {
    double half = 0.5 * (j[0] + j[3]), determinant = j[0] * j[3] - j[1] * j[2];
    double complex root = csqrt(half * half - determinant);
    double first = log(cabs(half + root)), second = log(cabs(half - root));
    log_moduli[0] = fmax(first, second);
    log_moduli[1] = fmin(first, second);
}

static saltus_system *impactor_system(const impactor *o) {
    saltus_spec spec = oscillator_spec(o->c, o->k, o->F, o->omega);
    set_parameter(&spec, "F0", o->F0);
    add_stop(&spec, o->d, o->r, SALTUS_UPPER);
    return build(&spec);
}

/* Check the exponents from the section state before the impact of an orbit with one impact in p periods. */
static void check_one_impact_orbit(const impactor *o, int p, double t, double u, const char *what) {
    double period = 2 * M_PI / o->omega, s = p * period, v = -o->r * u, j[4], log_moduli[2], state[2];
    const double after[2] = {o->d, v};
    impact_jacobian(o, t, v, s, u, j);
    log_eigenvalues(j, log_moduli);
    assert_true(log_moduli[0] < 0);
    check_near(log_moduli[0] + log_moduli[1], 2 * log(o->r) - o->c * s, 1e-10);
    double wait = ceil(t / period) * period - t;
    fly(o, t, wait, after, state);
    saltus_system *system = impactor_system(o);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    options.exponents = 0;
    saltus_lyapunov l = run_from(system, state, &options);
    check_orbit(&l, log_moduli, 2, s, 1e-10, what);
    check_near(l.impacts_per_period, 1.0 / p, 1e-12);
    check_near(l.sum, -o->c + 2 * log(o->r) / s, 1e-9);
    saltus_lyapunov_clear(&l);
    saltus_system_free(system);
}

/* The stable orbit with one impact in p periods, in closed form: E (y0 - x(t)) = y1 - x(t) with states y0
 * after and y1 before the impact and the steady solution x. */
static bool find_one_impact_orbit(const impactor *o, int p, double *t, double *u) {
    double s = 2 * M_PI * p / o->omega, e[4], j[4], log_moduli[2];
    free_response(o, s, e);
    double det = (e[0] - 1) * (e[3] - 1) - e[1] * e[2], right[2] = {o->r * e[1], 1 + o->r * e[3]};
    double w[2] = {((e[3] - 1) * right[0] - e[1] * right[1]) / det,
                   ((e[0] - 1) * right[1] - e[2] * right[0]) / det};
    double complex z = o->F / (o->k - o->omega * o->omega + I * o->c * o->omega);
    double size = cabs(z), rest = o->d - o->F0 / o->k;
    /* x = rest - u w0, x' = -u w1 with x^2 + (x'/omega)^2 = size^2 about the mean. */
    double a = w[0] * w[0] + w[1] * w[1] / (o->omega * o->omega), b = -2 * rest * w[0],
           c = rest * rest - size * size;
    for (int sign = -1; sign <= 1; sign += 2) {
        *u = (-b + sign * sqrt(b * b - 4 * a * c)) / (2 * a);
        if (!(*u > 0))
            continue;
        *t = (atan2(*u * w[1] / o->omega, rest - *u * w[0]) - carg(z)) / o->omega;
        impact_jacobian(o, *t, -o->r * *u, s, *u, j);
        log_eigenvalues(j, log_moduli);
        if (log_moduli[0] < 0)
            return true;
    }
    return false;
}

/* The forced oscillator with one stop (COCO's example), |mu| = 0.58432; near grazing; the undamped one. */
static void one_impact_orbits(void **unused) {
    (void)unused;
    static const struct {
        impactor o;
        int p;
        double phase, speed; /* NAN: not known */
        const char *what;
    } rows[] = {
        {{0.1, 1, 1, 0, 1, 1, 0.8}, 1, 0.0759521649, 1.6957329376, "A = 1"},
        {{0.1, 1, 0.5, 0, 1, 1, 0.8}, 1, 0.1771123597, 0.8370160232, "A = 0.5"},
        {{0.1, 1, 0.2, 0, 1, 1, 0.8}, 1, 0.4992440673, 0.2986128521, "A = 0.2"},
        {{0.1, 1, 0.1001, 0, 1, 1, 0.8}, 1, 1.4957882153, 0.0127569343, "A = 0.1001"},
        {{0.04, 1, 0.3478, -1, 0.81, 0, 0.9}, 2, NAN, NAN, "near grazing"},
        {{0, 1, 1, 0, 2.6, 0, 0.8}, 1, NAN, NAN, "omega = 2.6"},
        {{0, 1, 1, 0, 2.2, 0.1, 0.8}, 1, NAN, NAN, "omega = 2.2"},
        {{0, 1, 1, 0, 3.4, 0, 0.8}, 2, NAN, NAN, "omega = 3.4"},
        {{0, 1, 1, 0, 4.3, 0, 0.8}, 2, NAN, NAN, "omega = 4.3"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        double t = NAN, u = NAN;
        assert_true(find_one_impact_orbit(&rows[k].o, rows[k].p, &t, &u));
        if (!isnan(rows[k].phase)) {
            check_near(t, rows[k].phase, 1e-9);
            check_near(u, rows[k].speed, 1e-9);
        }
        check_one_impact_orbit(&rows[k].o, rows[k].p, t, u, rows[k].what);
    }
}

/* A ball on a vibrating table, x'' = 1 - Gamma cos t above (here: below) it: bounces of k periods land at
 * sin t = k pi (1 - r)/(1 + r)/Gamma and are stable up to a flip at 1.5268 (k = 1, r = 1/2). */
static void bouncing_ball_orbits(void **unused) {
    (void)unused;
    static const double rows[][3] = {
        {1, 1.2, 0.5}, {1, 1.5, 0.5}, {1, 1.06, 0.5}, {2, 2.2, 0.5}, {1, 0.6, 0.8}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        int p = (int)rows[k][0];
        impactor ball = {.F = -rows[k][1], .F0 = 1, .omega = 1, .r = rows[k][2]};
        double s = 2 * M_PI * p, u = s / (1 + ball.r), sine = (0.5 * s - ball.r * u) / ball.F, t = asin(sine);
        double from[2] = {0, -ball.r * u}, to[2], j[4], log_moduli[2];
        t = M_PI - t;
        impact_jacobian(&ball, t, -ball.r * u, s, u, j);
        log_eigenvalues(j, log_moduli);
        if (log_moduli[0] >= 0)
            t = M_PI - t;
        fly(&ball, t, s, from, to);
        check_near(to[0], 0, 1e-13);
        check_near(to[1], u, 1e-13);
        check_one_impact_orbit(&ball, p, t, u, "ball");
    }
}

/* Largest exponent per unit of time of an exact impact map, with an error from `blocks` blocks. */
static void iterate_map(const impactor *o, int impacts, double *exponent, double *error, double *rate) {
    enum { blocks = 20 };
    double t = 0.3, v = -0.5, u, j[4], a = 1, b = 0.3, growth[blocks] = {0}, time[blocks] = {0}, sum = 0,
           span = 0, square = 0;
    for (int k = -1000; k < impacts; k++) {
        double s = next_impact(o, t, v, &u);
        impact_jacobian(o, t, v, s, u, j);
        double first = j[0] * a + j[1] * b, second = j[2] * a + j[3] * b, length = hypot(first, second);
        a = first / length;
        b = second / length;
        t = fmod(t + s, 2 * M_PI / o->omega);
        v = -o->r * u;
        if (k >= 0) {
            int block = (int)((long long)k * blocks / impacts);
            growth[block] += log(length);
            time[block] += s;
        }
    }
    for (int k = 0; k < blocks; k++) {
        sum += growth[k];
        span += time[k];
    }
    for (int k = 0; k < blocks; k++)
        square += pow(growth[k] - time[k] * sum / span, 2);
    *exponent = sum / span;
    *error = sqrt(square * blocks / (blocks - 1)) / span;
    *rate = impacts / span;
}

/* Chaos of a bouncing ball and of Budd and Dux's oscillator; of a damped one both exponents. */
static void exact_impact_maps(void **unused) {
    (void)unused;
    skip_where_slow();
    static const impactor rows[] = {{0, 0, -3, 1, 1, 0, 0.95},
                                    {0, 1, 1, 0, 2.8, 0, 0.8},
                                    {0, 1, 1, 0, 3.2, 0, 0.8},
                                    {0.1, 1, 1, 0, 0.8, 0, 0.8}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        const impactor *o = &rows[k];
        double exponent, error, rate, state[2] = {o->d - 0.3, 0.1};
        iterate_map(o, long_version() ? 20000 : 5000, &exponent, &error, &rate);
        saltus_system *system = impactor_system(o);
        saltus_lyapunov_options options = short_options(8);
        options.exponents = 0;
        options.precision = long_version() ? 0.01 : 0.04;
        saltus_lyapunov l = run_from(system, state, &options);
        check_whole(&l);
        if (!(l.agree && l.precise && l.lost == 0))
            fail_msg("map %d: agree %d, precise %d, lost %d", (int)k, l.agree, l.precise, l.lost);
        check_near(l.exponents[0], exponent, 4 * hypot(error, l.standard_errors[0]));
        check_near(l.impacts_per_period / l.period, rate, 0.05 * rate);
        check_near(l.sum, -o->c + l.impacts_per_period / l.period * 2 * log(o->r), 1e-9);
        check_near(l.kaplan_yorke, 1 + l.exponents[0] / -l.exponents[1], 1e-12);
        saltus_lyapunov_clear(&l);
        saltus_system_free(system);
    }
}

/* Free motion of one mass: exponents are the real parts of the roots of s^2 + c s + 1, for any forcing;
 * without damping the motion is quasi-periodic and they are 0. */
static void linear_oscillators(void **unused) {
    (void)unused;
    static const double rows[][2] = {{0.1, 0.7},  {1.9, 0.7}, {2.5, 3},   {40, 0.3},
                                     {0, 0.3183}, {0, 1.618}, {1e-6, 1.3}};
    for (int k = 0; k < (long_version() ? 7 : 5); k++) {
        double c = rows[k][0], root = c > 2 ? sqrt(0.25 * c * c - 1) : 0, state[2] = {0.2, 0};
        double expected[2] = {-0.5 * c + root, -0.5 * c - root};
        saltus_spec spec = oscillator_spec(c, 1, 0.5, rows[k][1]);
        saltus_system *system = build(&spec);
        saltus_lyapunov_options options = short_options(3);
        options.exponents = 0;
        if (c > 10) { /* a period takes so many steps that a long transient would be given up */
            options.members = 3;
            options.transient = 100;
        }
        if (long_version() && c < 1e-3) { /* the error falls as one over the time, ... */
            options.periods *= 4;
            options.flow.rtol = 1e-13; /* ... down to what the flow's own errors may add to so slow a decay */
        }
        saltus_lyapunov l = run_from(system, state, &options);
        check_orbit(&l, expected, 2, 1, 1e-12, "linear");
        check_near(l.sum_rule, -c, 1e-12 * fmax(c, 1));
        check_near(l.impacts_per_period, 0, 0);
        saltus_lyapunov_clear(&l);
        saltus_system_free(system);
    }
}

static int descending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

/* beta = 0 at rest: uncoupled modes, s^2 + alpha l^4 s + l^4 - u0^2 l^2 = 0; above buckling a saddle. The
 * stiff ones decay by 1e4 and more in a unit of time. */
static void pipe_at_rest(void **unused) {
    (void)unused;
    const double rows[][3] = {{5, 2, 10}, {long_version() ? 12 : 7, 4.5, 5}, {1, 4.5, 2}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        int modes = (int)rows[k][0];
        double rest[24] = {0}, expected[24];
        saltus_spec spec = pipe_spec(modes, 20);
        set_parameter(&spec, "beta", 0);
        set_parameter(&spec, "sigma", 0);
        set_parameter(&spec, "u0", rows[k][1]);
        for (int i = 1; i <= modes; i++) {
            double l2 = i * i * M_PI * M_PI, half = 0.0025 * l2 * l2,
                   square = half * half - l2 * l2 + rows[k][1] * rows[k][1] * l2,
                   root = square > 0 ? sqrt(square) : 0;
            expected[2 * i - 2] = root > 0.99 * half && root < half
                                      ? (l2 * l2 - rows[k][1] * rows[k][1] * l2) / -(half + root)
                                      : -half + root;
            expected[2 * i - 1] = -half - root;
        }
        qsort(expected, 2 * (size_t)modes, sizeof *expected, descending);
        saltus_system *system = build(&spec);
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        options.exponents = (int)rows[k][2];
        options.transient = 10;
        options.members = 1; /* more members would be disturbed and leave the saddle */
        saltus_lyapunov l = run_from(system, rest, &options);
        check_orbit(&l, expected, options.exponents, 1, 1e-9, "pipe at rest");
        saltus_lyapunov_clear(&l);
        saltus_system_free(system);
    }
}

/* Twice the run, another seed, tolerance, interval, number of members or of exponents give the same result
 * within the errors: that of the exact impact map, or, for the pipe, 0.756 +- 0.01 from an independent
 * computation. */
static void chaos_in_many_ways(void **unused) {
    (void)unused;
    static const struct {
        unsigned long seed;
        double precision, rtol, interval;
        int exponents, members;
    } rows[] = {{0, 0.02, 1e-10, 0, 1, 8}, {0, 0.01, 1e-10, 0, 1, 8},   {1, 0.02, 1e-10, 0, 1, 8},
                {2, 0.02, 1e-8, 0, 1, 8},  {3, 0.02, 1e-13, 0, 1, 8},   {4, 0.02, 1e-10, 1, 1, 8},
                {5, 0.02, 1e-10, 5, 1, 8}, {6, 0.02, 1e-10, 0.1, 1, 8}, {7, 0.02, 1e-10, 0, 2, 8},
                {8, 0.02, 1e-10, 0, 1, 3}, {9, 0.02, 1e-10, 0, 1, 17},  {10, 0.02, 1e-10, 0, 2, 1}};
    const impactor damped = {0.1, 1, 1, 0, 0.8, 0, 0.8};
    double exponent[12], error[12], known, known_error, rate;
    iterate_map(&damped, 20000, &known, &known_error, &rate);
    for (int pipe = 0; pipe < 2; pipe++)
        for (int k = 0; k < (pipe && !long_version() ? 1 : 12); k++) {
            saltus_lyapunov_options options = short_options(8);
            double state[10] = {-0.3, 0.1};
            saltus_system *system = pipe ? scene_system("fig6", "omega=10", state) : impactor_system(&damped);
            options.seed = rows[k].seed;
            options.precision = rows[k].precision;
            options.flow.rtol = rows[k].rtol;
            options.interval = rows[k].interval;
            options.exponents = rows[k].exponents;
            options.members = rows[k].members;
            saltus_lyapunov l = run_from(system, state, &options);
            check_whole(&l);
            assert_true(l.precise && l.agree && l.lost == 0);
            assert_int_equal(l.members, rows[k].members);
            assert_int_equal(l.count, rows[k].exponents);
            exponent[k] = l.exponents[0];
            error[k] = l.standard_errors[0];
            check_near(exponent[k], pipe ? 0.756 : known, (pipe ? 0.01 : 4 * known_error) + 4 * error[k]);
            assert_true(error[k] < rows[k].precision * exponent[k]);
            for (int i = 0; i < k; i++)
                check_near(exponent[k], exponent[i], 4 * hypot(error[k], error[i]));
            saltus_lyapunov_clear(&l);
            saltus_system_free(system);
        }
}

/* Kaplan and Yorke's dimension, computed again. */
static double dimension_of(const saltus_lyapunov *l) {
    double sum = 0;
    int k = 0;
    while (k < l->count && sum + l->exponents[k] >= 0)
        sum += l->exponents[k++];
    return k < l->count ? k - sum / l->exponents[k] : NAN;
}

/* All exponents: those computed before are unchanged; the sum rule, the dimension. */
static void whole_spectrum(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    const char *settings = long_version() ? "omega=10" : "omega=10 N=3";
    options.precision = long_version() ? 0.03 : 0.1;
    options.exponents = 0;
    saltus_lyapunov all = run_scene("fig6", settings, &options);
    check_whole(&all);
    assert_int_equal(all.count, long_version() ? 10 : 6);
    check_near(all.sum, all.sum_rule, 1e-7);
    check_near(all.kaplan_yorke, dimension_of(&all), 1e-12);
    assert_true(all.kaplan_yorke > 1.1 && all.kaplan_yorke < 1.5);
    for (int n = 1; n <= 3; n++) {
        options.exponents = n;
        saltus_lyapunov some = run_scene("fig6", settings, &options);
        assert_int_equal(some.count, n);
        for (int k = 0; k < n; k++)
            check_near(some.exponents[k], all.exponents[k],
                       4 * hypot(some.standard_errors[k], all.standard_errors[k]));
        if (n == 1)
            assert_true(isnan(some.kaplan_yorke));
        else
            check_near(some.kaplan_yorke, dimension_of(&some), 1e-12);
        saltus_lyapunov_clear(&some);
    }
    saltus_lyapunov_clear(&all);
}

/* The scatter over seeds agrees with the stated errors: 68 % within one error, chi-square. */
static void errors_are_calibrated(void **unused) {
    (void)unused;
    skip_where_slow();
    static const struct {
        const char *scene, *settings;
        double precision;
        int exponents, members, seeds;
    } rows[] = {{"budd-dux", "", 0.04, 1, 8, 60},
                {"budd-dux", "", 0.04, 0, 1, 60},
                {"budd-dux", "", 0.02, 1, 8, 60},
                {"budd-dux", "omega=3 d=0.1", 0.02, 1, 8, 40},
                {"vibrating-table", "F=3 r=0.95 q1=9", 0.03, 1, 4, 20}, /* with seed 21 one leaves chaos */
                {"fig6", "omega=10", 0.03, 1, 8, 40},
                {"fig6", "d=0.03 omega=14", 0.03, 1, 8, 20}};
    for (int k = 0; k < (long_version() ? 7 : 2); k++) {
        double exponent[60], error[60], mean = 0, square = 0;
        int seeds = long_version() ? rows[k].seeds : 20, within = 0, disagree = 0;
        for (int seed = 0; seed < seeds; seed++) {
            saltus_lyapunov_options options = short_options(8);
            options.precision = rows[k].precision;
            options.exponents = rows[k].exponents;
            options.members = rows[k].members;
            options.seed = 1 + (unsigned long)seed;
            saltus_lyapunov l = run_scene(rows[k].scene, rows[k].settings, &options);
            exponent[seed] = l.exponents[0];
            error[seed] = l.standard_errors[0];
            mean += l.exponents[0] / seeds;
            disagree += !l.agree;
            assert_true(l.precise);
            saltus_lyapunov_clear(&l);
        }
        for (int seed = 0; seed < seeds; seed++) {
            double apart = fabs(exponent[seed] - mean) / error[seed];
            within += apart < 1;
            square += apart * apart;
        }
        double share = within / (double)seeds, free = seeds - 1, spread = 3.5 * sqrt(2 / free);
        if (!(fabs(share - 0.68) < 3.5 * sqrt(0.68 * 0.32 / seeds) && square / free < 1 + spread &&
              square / free > 1 - fmin(spread, 0.8) && disagree == 0))
            fail_msg("%s %s, %d members: %.2f within one error, chi-square %.2f per degree, %d disagree",
                     rows[k].scene, rows[k].settings, rows[k].members, share, square / free, disagree);
    }
}

/* Contacts remove directions: chatter and release, permanent contact, an impact without rebound. If fewer
 * exponents are requested than remain, they are unaffected. */
static void lost_directions(void **unused) {
    (void)unused;
    static const struct {
        const char *scene, *settings;
        int lost, dimension;
    } rows[] = {{"chatter", "", 2, 10},
                {"vibrating-table", "", 2, 2},
                {"bouncing-ball", "", 2, 2},
                {"impact-oscillator", "r=0", 1, 2},
                {"fig6", "sigma=0 d=0.02 q1=0.015", 2, 10},
                {"fig7b", "N=2 sigma=0 d=0.02 q1=0.015", 2, 4},
                {"chatter", "r=0", 2, 10},
                {"two-mass", "r=0 F=1", 2, 4}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++)
        for (int n = rows[k].dimension > 4 && !long_version() ? 1 : 0; n <= 1; n++) {
            saltus_lyapunov_options options = short_options(2);
            options.exponents = n;
            options.periods = long_version() ? 4000 : 400;
            saltus_lyapunov l = run_scene(rows[k].scene, rows[k].settings, &options);
            check_whole(&l);
            if (l.lost != rows[k].lost)
                fail_msg("%s %s: %d directions lost instead of %d", rows[k].scene, rows[k].settings, l.lost,
                         rows[k].lost);
            assert_int_equal(l.dimension, rows[k].dimension);
            for (int i = 0; i < l.count; i++) {
                bool lost = i >= l.dimension - l.lost;
                assert_true(lost == (l.exponents[i] == -INFINITY));
                assert_true(isfinite(l.standard_errors[i]) && (!lost || l.standard_errors[i] == 0));
            }
            if (l.lost == l.dimension)
                assert_true(l.half[0] == -INFINITY && l.member_exponents[0] == -INFINITY && l.agree &&
                            l.precise && l.kaplan_yorke == 0);
            saltus_lyapunov_clear(&l);
        }
}

/* One impact without rebound in a period: mu = a S(T) / v (test_multipliers.c), here from the orbit's event.
 */
static void impact_without_rebound(void **unused) {
    (void)unused;
    const double c = 0.1, omega = 1.5, d = 0.75, damped = sqrt(1 - c * c / 4), period = 2 * M_PI / omega;
    saltus_spec spec = oscillator_spec(c, 1, 1, omega);
    add_stop(&spec, d, 0, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    double state[2] = {0.1, 0};
    saltus_lyapunov l = run_from(system, state, &options);
    assert_int_equal(l.lost, 1);
    saltus_flow_options exact = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &exact, 0, l.state);
    saltus_event event = advance(flow, 2, SALTUS_WATCH_IMPACT);
    double response = exp(-c / 2 * period) * sin(damped * period) / damped;
    double mu = (cos(omega * event.time.phase * period) - d) * response / event.velocity_before;
    double expected = log(fabs(mu));
    check_orbit(&l, &expected, 1, period, 1e-9, "no rebound");
    saltus_flow_free(flow);
    saltus_lyapunov_clear(&l);
    saltus_system_free(system);
}

/* The interval between orthonormalisations does not change the result. */
static void any_interval(void **unused) {
    (void)unused;
    static const double intervals[] = {0, 1, 2, 5, 1.0 / 3, 0.1};
    const char *const scenes[][2] = {
        {"fig7b", long_version() ? "" : "N=2"}, {"two-mass", ""}, {"impact-oscillator", ""}};
    for (size_t s = 0; s < 3; s++) {
        saltus_lyapunov first = {0};
        for (int k = 0; k < 6; k++) {
            saltus_lyapunov_options options = short_options(2);
            options.exponents = s == 0 ? 4 : 0;
            options.interval = intervals[k];
            saltus_lyapunov l = run_scene(scenes[s][0], scenes[s][1], &options);
            check_whole(&l);
            for (int i = 0; i < l.count && k > 0; i++)
                check_near(l.exponents[i], first.exponents[i],
                           3 * hypot(l.standard_errors[i], first.standard_errors[i]) + 1e-12);
            if (k > 0)
                saltus_lyapunov_clear(&l);
            else
                first = l;
        }
        saltus_lyapunov_clear(&first);
    }
}

static void same_numbers_again(void **unused) {
    (void)unused;
    for (unsigned long seed = 0; seed < 2; seed++) {
        saltus_lyapunov_options options = short_options(8);
        options.exponents = 3;
        options.precision = 0.1;
        options.seed = seed;
        saltus_lyapunov a = run_scene("fig6", "omega=10", &options),
                        b = run_scene("fig6", "omega=10", &options);
        assert_memory_equal(a.exponents, b.exponents, 3 * sizeof *a.exponents);
        assert_memory_equal(a.standard_errors, b.standard_errors, 3 * sizeof *a.standard_errors);
        assert_memory_equal(a.state, b.state, 10 * sizeof *a.state);
        assert_memory_equal(a.member_exponents, b.member_exponents, 8 * sizeof *a.member_exponents);
        assert_int_equal(a.history_count, b.history_count);
        assert_true(a.periods == b.periods && a.transient == b.transient);
        saltus_lyapunov_clear(&a);
        saltus_lyapunov_clear(&b);
    }
}

typedef struct caller {
    int calls;
    volatile sig_atomic_t stop;
} caller;

static void stop_at_the_tenth(void *context, double periods, double at_most) {
    caller *c = context;
    assert_true(periods >= 0 && periods <= at_most);
    c->calls += periods > 0;
    c->stop = c->calls >= 10;
}

/* A run that is stopped, or that ends before the precision is reached, says so. */
static void unfinished_runs(void **unused) {
    (void)unused;
    caller c = {0};
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    options.precision = 1e-9;
    options.progress = (saltus_progress){stop_at_the_tenth, &c};
    options.flow.stop = &c.stop;
    saltus_lyapunov l = run_scene("fig6", "omega=10", &options);
    assert_int_equal(c.calls, 10);
    assert_false(l.precise);
    assert_true(l.standard_errors[0] > 0 && l.periods > 0);
    saltus_lyapunov_clear(&l);
    options.progress.show = NULL;
    options.flow.stop = NULL;
    options.periods = 8 * 300;
    l = run_scene("fig6", "omega=10", &options);
    assert_false(l.precise);
    assert_true(l.periods <= 8 * 300 && l.periods >= 8 * 200);
    check_near(l.exponents[0], 0.756, 0.01 + 4 * l.standard_errors[0]);
    saltus_lyapunov_clear(&l);
}

/* Without damping an impact may leave the pipe swinging clear of its stop for a thousand periods: neighbours
 * separate in bursts, errors do not fall, and the run ends at a fraction of its periods. Those of other chaos
 * fall, and an unreachable precision costs all of them. */
static void a_run_whose_error_does_not_fall_ends(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    options.periods = 400000;
    saltus_lyapunov l = run_scene("pipe", "alpha=0 N=5", &options);
    assert_true(l.slow && !l.precise);
    assert_true(l.periods < 400000 / 2);
    assert_true(l.standard_errors[0] > 0.02 * l.exponents[0]);
    saltus_lyapunov_clear(&l);
    options.periods = 100000;
    options.precision = 1e-5;
    l = run_scene("duffing", "F=0.3", &options);
    assert_true(!l.slow && !l.precise);
    assert_true(l.periods > 90000);
    saltus_lyapunov_clear(&l);
}

/* A linear pipe under strong pulsation: the motion grows without bound, as do tangent vectors left alone for
 * long. */
static void growth_without_bound(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_lyapunov result;
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    double state[2] = {0.001, 0}, rest[2] = {0};
    saltus_spec spec = pipe_spec(1, 20);
    set_parameter(&spec, "kappa", 0);
    saltus_system *system = build(&spec);
    assert_int_equal(saltus_lyapunov_run(system, state, &options, &result, &message), SALTUS_STALLED);
    assert_non_null(strstr(message.text, "without bound"));
    assert_null(result.exponents);
    options.interval = 1000;
    options.exponents = 2;
    options.transient = 0;
    options.members = 1;
    assert_int_equal(saltus_lyapunov_run(system, rest, &options, &result, &message), SALTUS_STALLED);
    assert_true(strlen(message.text) > 10);
    options.interval = 0;
    assert_int_equal(saltus_lyapunov_run(system, rest, &options, &result, &message), SALTUS_OK);
    assert_true(result.exponents[0] > 1 && result.precise);
    check_whole(&result);
    assert_true(result.kaplan_yorke <= 2);
    saltus_lyapunov_clear(&result);
    saltus_system_free(system);
}

/* Without a transient: the slow decay of the free motion does not affect the exponents. */
static void slow_decay(void **unused) {
    (void)unused;
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    options.transient = 0;
    options.exponents = 0;
    saltus_lyapunov l = run_scene("impact-oscillator", "c=0.01 omega=1.7 q1=0.9", &options);
    check_near(l.exponents[0], -0.005, 3 * l.standard_errors[0] + 1e-9);
    check_near(l.sum, -0.01, 1e-9);
    saltus_lyapunov_clear(&l);
}

static void check_refused(const saltus_lyapunov_options *options, const char *name) {
    saltus_message message = {.text = ""};
    saltus_lyapunov result;
    double state[2] = {0};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    assert_int_equal(saltus_lyapunov_run(system, state, options, &result, &message), SALTUS_BAD_INPUT);
    if (!strstr(message.text, name))
        fail_msg("no %s in: %s", name, message.text);
    assert_null(result.exponents);
    saltus_lyapunov_clear(&result);
    saltus_system_free(system);
}

#define refused(field, value)                                                                                \
    do {                                                                                                     \
        saltus_lyapunov_options options = saltus_lyapunov_defaults();                                        \
        options.field = value;                                                                               \
        check_refused(&options, strrchr("." #field, '.') + 1);                                               \
    } while (0)

static void bad_options(void **unused) {
    (void)unused;
    refused(exponents, -1);
    refused(exponents, 3);
    refused(members, 0);
    refused(members, 65);
    refused(transient, -1);
    refused(periods, 0);
    refused(periods, 100);
    refused(precision, 0);
    refused(precision, -1);
    refused(precision, NAN);
    refused(interval, -1);
    refused(interval, NAN);
    refused(interval, INFINITY);
    refused(interval, 1.5);
    refused(interval, 0.7);
    refused(interval, 1e-9);
    refused(flow.rtol, 0);
    refused(flow.rtol, 1);
    refused(flow.atol, -1);
}

/* 200 intervals per trajectory are enough; one period less is not. */
static void least_periods(void **unused) {
    (void)unused;
    static const struct {
        int members;
        double interval;
        long long least;
    } rows[] = {{1, 0, 200}, {3, 0, 600}, {2, 3, 1200}, {2, 0.25, 400}, {64, 1, 12800}};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1.3);
    saltus_system *system = build(&spec);
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        saltus_message message = {.text = ""};
        saltus_lyapunov l;
        double state[2] = {0.1, 0};
        options.members = rows[k].members;
        options.interval = rows[k].interval;
        options.periods = rows[k].least - 1;
        options.transient = 0;
        assert_int_equal(saltus_lyapunov_run(system, state, &options, &l, &message), SALTUS_BAD_INPUT);
        options.periods++;
        check_ok(saltus_lyapunov_run(system, state, &options, &l, &message), &message);
        assert_int_equal(l.periods, rows[k].least);
        assert_int_equal(l.members, rows[k].members);
        check_near(l.exponents[0], -0.05, 0.01);
        saltus_lyapunov_clear(&l);
    }
    saltus_system_free(system);
}

/* A state beyond a stop or not finite is refused. */
static void bad_states(void **unused) {
    (void)unused;
    const double states[][2] = {{2, 0}, {NAN, 0}, {0, INFINITY}};
    saltus_system *system = impactor_system(&(impactor){0.1, 1, 0.5, 0, 1, 1, 0.8});
    for (int k = 0; k < 3; k++) {
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        saltus_message message = {.text = ""};
        saltus_lyapunov result;
        assert_int_equal(saltus_lyapunov_run(system, states[k], &options, &result, &message),
                         SALTUS_BAD_INPUT);
        assert_true(strlen(message.text) > 10);
    }
    saltus_system_free(system);
}

static void failing_allocations(void **unused) {
    (void)unused;
    double state[2];
    saltus_system *system = scene_system("impact-oscillator", "", state);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    int refusals = 0;
    options.exponents = 0;
    options.transient = 10;
    options.periods = 200;
    options.members = 1;
    for (long k = 1;; k++) {
        saltus_message message = {.text = ""};
        saltus_lyapunov result;
        allocations = 0;
        failing = k;
        saltus_status status = saltus_lyapunov_run(system, state, &options, &result, &message);
        failing = -1;
        bool spared = allocations < k;
        if (status == SALTUS_OK)
            saltus_lyapunov_clear(&result);
        else
            assert_true(status == SALTUS_NO_MEMORY && result.exponents == NULL && strlen(message.text) > 10);
        refusals += status != SALTUS_OK;
        if (spared)
            break;
    }
    assert_true(refusals > 5);
    saltus_system_free(system);
}

/* Near a resonance with the forcing tangent vectors rotate too slowly to be noticed; the stated error is true
 * nevertheless. The exponent is half the damping. */
static void errors_near_resonance(void **unused) {
    (void)unused;
    const double damping = 0.1, turning = sqrt(1 - damping * damping / 4);
    for (int order = 1; order <= 3; order++)
        for (int power = -6; power <= -2; power++) {
            saltus_spec spec = oscillator_spec(damping, 1, 0.5, 2 * turning / order * (1 + pow(10, power)));
            saltus_system *system = build(&spec);
            saltus_lyapunov_options options = saltus_lyapunov_defaults();
            const double state[2] = {0.1, 0};
            saltus_lyapunov l = run_from(system, state, &options);
            check_near(l.exponents[0], -damping / 2, 3 * l.standard_errors[0]);
            assert_true(l.standard_errors[0] < 0.02 * damping / 2);
            saltus_lyapunov_clear(&l);
            saltus_system_free(system);
        }
}

/* Near a fold motions approach their orbit as slowly as tangent vectors shrink, and errors of the flow
 * displace it far; exponents are still those of the multipliers, within the stated errors. */
static void errors_next_to_a_fold(void **unused) {
    (void)unused;
    static const double away[] = {1e-8, 1e-6, 1e-4};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1.3);
    saltus_branch_options along = branch_along("omega", 0.5, 2);
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    saltus_message message = {.text = ""};
    int checked = 0;
    add_stop(&spec, 0.8, 0.9, SALTUS_UPPER);
    add_stop(&spec, 1.2, 0.5, SALTUS_LOWER);
    double state[2] = {0, 0};
    saltus_system *system = build(&spec);
    check_ok(saltus_motion_settle(system, &options.flow, 500, state, &message), &message);
    saltus_system_free(system);
    branch_record record = branch_run(&spec, 1, state, &along);
    for (int k = 1; k + 1 < record.count && checked < 6; k++) {
        const saltus_branch_point *fold = &record.point[k], *stable = fold[-1].stable ? fold - 1 : fold + 1;
        if (fold->kind != SALTUS_POINT_LP || !stable->stable || stable->kind != SALTUS_POINT_REGULAR)
            continue;
        for (size_t i = 0; i < sizeof away / sizeof *away; i++) {
            double omega =
                fold->value[0] + copysign(away[i] * fold->value[0], stable->value[0] - fold->value[0]);
            saltus_orbit orbit;
            set_parameter(&spec, "omega", omega);
            system = build(&spec);
            check_ok(saltus_orbit_find(system, stable->periods, stable->state, &shooting, &orbit, &message),
                     &message);
            double exponent =
                orbit.multipliers[0].log_modulus / (orbit.periods * saltus_system_period(system));
            if (exponent < 0) {
                saltus_lyapunov l = run_from(system, orbit.state, &options);
                check_near(l.exponents[0], exponent, 3 * l.standard_errors[0]);
                assert_true(l.standard_errors[0] < 0.1 * -exponent);
                saltus_lyapunov_clear(&l);
                checked++;
            }
            saltus_orbit_clear(&orbit);
            saltus_system_free(system);
        }
    }
    assert_true(checked >= 3);
    branch_forget(&record);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference_orbits),      cmocka_unit_test(scenes_and_shooting),
        cmocka_unit_test(one_impact_orbits),     cmocka_unit_test(bouncing_ball_orbits),
        cmocka_unit_test(exact_impact_maps),     cmocka_unit_test(linear_oscillators),
        cmocka_unit_test(pipe_at_rest),          cmocka_unit_test(chaos_in_many_ways),
        cmocka_unit_test(whole_spectrum),        cmocka_unit_test(errors_are_calibrated),
        cmocka_unit_test(lost_directions),       cmocka_unit_test(impact_without_rebound),
        cmocka_unit_test(any_interval),          cmocka_unit_test(same_numbers_again),
        cmocka_unit_test(unfinished_runs),       cmocka_unit_test(a_run_whose_error_does_not_fall_ends),
        cmocka_unit_test(growth_without_bound),  cmocka_unit_test(slow_decay),
        cmocka_unit_test(bad_options),           cmocka_unit_test(bad_states),
        cmocka_unit_test(least_periods),         cmocka_unit_test(failing_allocations),
        cmocka_unit_test(errors_near_resonance), cmocka_unit_test(errors_next_to_a_fold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
