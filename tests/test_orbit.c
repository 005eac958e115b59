/* Orbit finding: Newton's method converges quadratically to the reference orbits from disturbed states, for
 * any section phase, tolerance and number of segments; orbits near grazing, where the plain method fails;
 * failures with their reasons.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_orbits.h"
#include "orbit/orbit.h"
#include "reference.h"

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_rng.h>

enum { history_max = 256, size_max = 16 };

/* Residuals of one search, and whether event times became unknowns. */
typedef struct history {
    int count;
    double residual[history_max];
    int step[history_max];
    int last; /* the largest step number */
    bool prescribed;
} history;

static void remember(void *context, int iteration, double residual, const char *what) {
    history *h = context;
    h->last = iteration > h->last ? iteration : h->last;
    h->prescribed |= strcmp(what, "stroboscopic map") != 0;
    if (h->count < history_max) {
        h->step[h->count] = iteration;
        h->residual[h->count++] = residual;
    }
}

/* A small residual is at most a constant times the square of the one before, down to rounding. */
static void check_quadratic(const history *h) {
    const double constant = 500, floor = 1e-13;
    assert_true(h->count >= 2);
    for (int k = 0; k + 1 < h->count; k++)
        if (h->residual[k] < 1e-3 && h->residual[k] > floor)
            assert_true(h->residual[k + 1] <= fmax(constant * h->residual[k] * h->residual[k], floor));
    assert_true(h->residual[h->count - 1] <= floor);
}

static saltus_orbit find(const saltus_system *system, int periods, const double *guess,
                         const saltus_orbit_options *options) {
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    check_ok(saltus_orbit_find(system, periods, guess, options, &orbit, &message), &message);
    return orbit;
}

/* The multipliers that the reference lists, and all of them by the sum rule. */
static void check_multipliers(const reference *r, const saltus_orbit *orbit) {
    for (int k = 0; k < r->multiplier_count; k++) {
        double modulus = hypot(r->multipliers[k][0], r->multipliers[k][1]);
        check_near(orbit->multipliers[k].re, r->multipliers[k][0], 1e-8 * modulus);
        check_near(fabs(orbit->multipliers[k].im), fabs(r->multipliers[k][1]), 1e-8 * modulus);
    }
    assert_int_equal(orbit->sticks, r->sticking > 0);
    if (r->sticking)
        return;
    double sum = 0;
    for (int k = 0; k < orbit->dimension; k++) {
        const saltus_multiplier *mu = &orbit->multipliers[k];
        sum += mu->log_modulus;
        check_near(hypot(mu->re, mu->im), exp(mu->log_modulus), 1e-12 * exp(mu->log_modulus));
        assert_true(k == 0 || mu->log_modulus <= mu[-1].log_modulus);
    }
    check_near(sum, orbit->sum_rule, 1e-8);
    check_near(orbit->log_volume, orbit->sum_rule, 1e-8);
}

static void disturb(gsl_rng *random, double size, int n, const double *state, double *guess) {
    for (int i = 0; i < n; i++)
        guess[i] = state[i] * (1 + size * (2 * gsl_rng_uniform(random) - 1));
}

static const char *const names[] = {"fig7d", "fig7b", "sdof14", "chatter25"};
enum { name_count = 4 };

/* From random states 1e-3 away. */
static void quadratic_convergence(void **unused) {
    (void)unused;
    gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
    for (int f = 0; f < name_count; f++) {
        reference r = read_reference(names[f]);
        saltus_system *system = build(&r.spec);
        for (int k = 0; k < 6; k++) {
            history h = {0};
            saltus_orbit_options options = saltus_orbit_defaults();
            options.history = remember;
            options.context = &h;
            double guess[size_max];
            disturb(random, 1e-3, r.n, r.states[0], guess);
            saltus_orbit orbit = find(system, r.periods, guess, &options);
            check_quadratic(&h);
            check_near(reference_distance(&r, orbit.state, 0), 0, 1e-11);
            check_near(orbit.residual, 0, 1e-12);
            check_multipliers(&r, &orbit);
            saltus_orbit_clear(&orbit);
        }
        saltus_system_free(system);
    }
    gsl_rng_free(random);
}

/* The orbit does not depend on which multipliers are wanted. Near 1 all are computed, and with a single
 * segment only where no tangent vector grows too much. */
static void multipliers_as_wanted(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    int alone = 0;
    for (int f = 0; f < name_count; f++) {
        reference r = read_reference(names[f]);
        saltus_system *system = build(&r.spec);
        saltus_orbit_options options = saltus_orbit_defaults();
        saltus_orbit leading, none, all = find(system, r.periods, r.states[0], &options);
        check_ok(saltus_orbit_search(system, r.periods, r.states[0], &options, SALTUS_MULTIPLIERS_LEADING,
                                     &leading, &message),
                 &message);
        check_ok(saltus_orbit_search(system, r.periods, r.states[0], &options, SALTUS_MULTIPLIERS_NONE, &none,
                                     &message),
                 &message);
        assert_memory_equal(leading.state, all.state, (size_t)r.n * sizeof *all.state);
        assert_memory_equal(none.state, all.state, (size_t)r.n * sizeof *all.state);
        assert_int_equal(none.multiplier_count, 0);
        assert_true(leading.multiplier_count == 1 || leading.multiplier_count == r.n);
        check_near(leading.multipliers[0].log_modulus, all.multipliers[0].log_modulus, 1e-7);
        alone += leading.multiplier_count == 1;
        saltus_orbit_clear(&leading);
        saltus_orbit_clear(&none);
        saltus_orbit_clear(&all);
        saltus_system_free(system);
    }
    assert_true(alone > 0);
}

/* A search with other options; its orbit is followed to phase 0 and compared there. */
static void check_variant(const reference *r, gsl_rng *random, const saltus_orbit_options *options,
                          double tolerance) {
    saltus_system *system = build(&r->spec);
    double start[size_max], guess[size_max], state[size_max];
    saltus_flow *flow = open_flow(system, &options->flow, 0, r->states[0]);
    advance(flow, options->phase, 0);
    saltus_flow_state(flow, 0, start);
    saltus_flow_free(flow);
    disturb(random, 1e-3, r->n, start, guess);
    saltus_orbit orbit = find(system, r->periods, guess, options);
    flow = open_flow(system, &options->flow, options->phase, orbit.state);
    advance(flow, 1, 0);
    saltus_flow_state(flow, 0, state);
    check_near(reference_distance(r, state, 1 % r->periods), 0, tolerance);
    check_multipliers(r, &orbit);
    saltus_flow_free(flow);
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
}

/* The same orbit for any section phase, tolerance and number of segments. */
static void same_orbit_any_way(void **unused) {
    (void)unused;
    static const double phases[] = {0.21, 0.5, 0.83};
    static const int segments[] = {1, 2, 5};
    gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
    for (int f = 0; f < 3; f++) {
        reference r = read_reference(names[f]);
        for (int k = 0; k < 3; k++) {
            saltus_orbit_options options = saltus_orbit_defaults();
            options.phase = phases[k];
            check_variant(&r, random, &options, 1e-11);
            options.phase = 0;
            options.segments = segments[k];
            check_variant(&r, random, &options, 1e-11);
            options.phase = phases[k];
            options.flow.rtol = k ? 1e-12 : 1e-14;
            check_variant(&r, random, &options, 1e-11);
        }
    }
    gsl_rng_free(random);
}

/* Complete chatter and sticking leave two multipliers that are zero exactly. */
static void sticking_orbit(void **unused) {
    (void)unused;
    reference r = read_reference("chatter25");
    saltus_system *system = build(&r.spec);
    gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
    saltus_orbit_options options = saltus_orbit_defaults();
    for (int k = 0; k < 4; k++) {
        double guess[size_max];
        disturb(random, 1e-3, r.n, r.states[0], guess);
        options.segments = k;
        saltus_orbit orbit = find(system, r.periods, guess, &options);
        check_near(orbit.multipliers[0].re, -0.9106262547, 1e-7);
        check_near(orbit.multipliers[0].im, 0, 0);
        for (int i = r.n - 2; i < r.n; i++) {
            assert_true(orbit.multipliers[i].re == 0 && orbit.multipliers[i].im == 0);
            assert_true(isinf(orbit.multipliers[i].log_modulus) && orbit.multipliers[i].log_modulus < 0);
        }
        assert_true(orbit.multipliers[r.n - 3].re != 0);
        check_near(reference_distance(&r, orbit.state, 0), 0, 1e-11);
        saltus_orbit_clear(&orbit);
    }
    gsl_rng_free(random);
    saltus_system_free(system);
}

/* Textbook Newton's method on the stroboscopic map, with full steps only. */
static bool plain_newton(const saltus_system *system, int periods, const double *guess, double *state) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_flow *flow = NULL;
    const saltus_time begin = {0, 0}, end = {periods, 0};
    double residual[2] = {INFINITY, 0}, m[4], after[2];
    options.columns = 2;
    memcpy(state, guess, 2 * sizeof *state);
    check_ok(saltus_flow_new(&system, 1, &options, &flow, &message), &message);
    for (int k = 0; k < 20; k++) {
        saltus_event event;
        if (saltus_flow_start(flow, 0, begin, state, NULL) != SALTUS_OK ||
            saltus_flow_advance(flow, end, 0, &event, NULL) != SALTUS_OK)
            break;
        saltus_flow_state(flow, 0, after);
        saltus_flow_tangents(flow, 0, m);
        for (int i = 0; i < 2; i++)
            residual[i] = after[i] - state[i];
        if (hypot(residual[0], residual[1]) < 1e-12)
            break;
        /* Stored by columns: m[0], m[1] is the first one. */
        double a = m[0] - 1, b = m[2], c = m[1], d = m[3] - 1, determinant = a * d - b * c;
        state[0] -= (d * residual[0] - b * residual[1]) / determinant;
        state[1] -= (a * residual[1] - c * residual[0]) / determinant;
    }
    saltus_flow_free(flow);
    return hypot(residual[0], residual[1]) < 1e-12;
}

typedef struct rough {
    closed_oscillator oscillator;
    long double speed;
    double size; /* size of the disturbance */
    int lost;    /* from at least this many starts the plain method fails */
} rough;

/* Slow impacts; for the slower one the starts are so rough that the plain method often fails. */
static void near_grazing(void **unused) {
    (void)unused;
    enum { starts = 20 };
    const closed_oscillator slow = {
        .c = 0.04L, .k = 1, .F = 0.3600268471098L, .F0 = -1, .omega = 0.80089L, .r = 0.9L, .periods = 2};
    const closed_oscillator demo = {
        .c = 0.1L, .k = 1, .F = 0.1001L, .omega = 1, .d = 1, .r = 0.8L, .periods = 1};
    const rough rows[] = {{slow, 0.0066749810816L, 1e-3, 10}, {demo, 0.0127569343L, 0.1, 0}};
    gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
    for (int row = 0; row < 2; row++) {
        const closed_oscillator *o = &rows[row].oscillator;
        closed_orbit closed;
        assert_true(closed_orbit_at(o, 1, &closed) && closed.admissible);
        check_near((double)(closed.impact[0].speed - rows[row].speed), 0, 1e-9);
        saltus_spec spec = closed_spec(o);
        saltus_system *system = build(&spec);
        int lost = 0;
        for (int k = 0; k < starts; k++) {
            double guess[2], state[2];
            for (int i = 0; i < 2; i++)
                guess[i] = (double)closed.state[i] + rows[row].size * (2 * gsl_rng_uniform(random) - 1);
            saltus_orbit_options options = saltus_orbit_defaults();
            saltus_orbit orbit = find(system, o->periods, guess, &options);
            for (int i = 0; i < 2; i++) {
                check_near(orbit.state[i], (double)closed.state[i], 1e-11);
                check_near(orbit.multipliers[i].re, (double)closed.multiplier[i][0], 1e-7);
                check_near(fabs(orbit.multipliers[i].im), (double)fabsl(closed.multiplier[i][1]), 1e-7);
            }
            lost += !plain_newton(system, o->periods, guess, state) ||
                    hypot(state[0] - orbit.state[0], state[1] - orbit.state[1]) > 1e-6;
            saltus_orbit_clear(&orbit);
        }
        print_message("speed %.4Lg: the plain method fails from %d of %d starts\n", rows[row].speed, lost,
                      starts);
        assert_true(lost >= rows[row].lost);
        saltus_system_free(system);
    }
    gsl_rng_free(random);
}

/* Without impact a strongly damped oscillator has the multipliers exp(s T), s^2 + c s + k = 0. */
static void small_multipliers_in_closed_form(void **unused) {
    (void)unused;
    for (double c = 4; c <= 24; c *= 1.5) {
        saltus_spec spec = oscillator_spec(c, 1, 1, 1);
        saltus_system *system = build(&spec);
        saltus_orbit_options options = saltus_orbit_defaults();
        double guess[2] = {-0.5, 0.1}, root = sqrt(c * c / 4 - 1), period = saltus_system_period(system);
        saltus_orbit orbit = find(system, 1, guess, &options);
        double exact = -(c / 2 + root) * period;
        check_near(orbit.multipliers[1].log_modulus, exact, 1e-9);
        check_near(orbit.multipliers[1].re / exp(exact), 1, 1e-4);
        check_near(orbit.multipliers[0].log_modulus, (root - c / 2) * period, 1e-9);
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
}

/* Moduli of the eigenvalues of a 4 x 4 matrix by decreasing size. */
static void larger_eigenvalues(const double *matrix, double *modulus) {
    double copy[16];
    memcpy(copy, matrix, sizeof copy);
    gsl_matrix_view view = gsl_matrix_view_array(copy, 4, 4);
    gsl_vector_complex *values = gsl_vector_complex_alloc(4);
    gsl_eigen_nonsymm_workspace *work = gsl_eigen_nonsymm_alloc(4);
    assert_int_equal(gsl_eigen_nonsymm(&view.matrix, values, work), 0);
    for (int i = 0; i < 4; i++) {
        gsl_complex value = gsl_vector_complex_get(values, (size_t)i);
        double size = hypot(GSL_REAL(value), GSL_IMAG(value));
        int k = i;
        for (; k > 0 && modulus[k - 1] < size; k--)
            modulus[k] = modulus[k - 1];
        modulus[k] = size;
    }
    gsl_eigen_nonsymm_free(work);
    gsl_vector_complex_free(values);
}

/* Mass 1 on a strong damper, and on it mass 2 with a stop: three multipliers are the larger eigenvalues of
 * the monodromy matrix, and the product of all four is exp(-(c + 2 c2) p T) times r^2 for each impact. */
static void small_multipliers_with_impacts(void **unused) {
    (void)unused;
    static const double dampers[] = {4, 8, 16, 24};
    for (int k = 0; k < 4; k++) {
        saltus_spec spec = oscillator_spec(dampers[k], 1, 0, 1.1);
        set_parameter(&spec, "N", 2);
        set_parameter(&spec, "c2", 0.1);
        set_parameter(&spec, "F2", 1);
        add_stop(&spec, 1, 0.8, SALTUS_UPPER);
        spec.stops[0].weight[0] = 0;
        spec.stops[0].weight[1] = 1;
        saltus_system *system = build(&spec);
        saltus_classify_options options = saltus_classify_defaults();
        saltus_motion motion;
        saltus_message message = {.text = ""};
        double state[4] = {0}, values[4];
        check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        assert_true(motion.impacts > 0);
        saltus_orbit_options find_options = saltus_orbit_defaults();
        saltus_orbit orbit = find(system, motion.periods, motion.state, &find_options);
        double smallest = 2 * (double)motion.impacts * log(0.8) -
                          (dampers[k] + 2 * 0.1) * motion.periods * saltus_system_period(system);
        larger_eigenvalues(orbit.monodromy, values);
        for (int i = 0; i < 3; i++) {
            check_near(exp(orbit.multipliers[i].log_modulus), values[i], 1e-9);
            smallest -= log(values[i]);
        }
        check_near(orbit.multipliers[3].log_modulus, smallest, 1e-7);
        check_near(fabs(orbit.multipliers[3].re) / exp(smallest), 1, 1e-4);
        saltus_motion_clear(&motion);
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
}

static void check_empty(const saltus_orbit *orbit) {
    assert_true(!orbit->state && !orbit->monodromy && !orbit->multipliers);
    assert_true(orbit->dimension == 0 && orbit->periods == 0 && orbit->iterations == 0);
}

/* A search that must fail with a status and a message that names the cause. */
static void check_fails(const saltus_spec *spec, int periods, double x, double v, saltus_status status,
                        const char *cause) {
    saltus_system *system = build(spec);
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    double guess[2] = {x, v};
    history h = {0};
    options.history = remember;
    options.context = &h;
    saltus_status found = saltus_orbit_find(system, periods, guess, &options, &orbit, &message);
    /* A formulation goes on while its steps lower the residual, and ends with the first that does not. */
    for (int k = 1; k + 1 < h.count; k++)
        if (h.step[k] > 0 && h.step[k + 1] > 0)
            assert_true(h.step[k + 1] == h.step[k] + 1 && h.residual[k] < h.residual[k - 1]);
    assert_string_equal(saltus_status_name(found), saltus_status_name(status));
    if (!strstr(message.text, cause))
        fail_msg("\"%s\" does not speak of \"%s\"", message.text, cause);
    check_empty(&orbit);
    saltus_system_free(system);
}

/* Resonance without damping; a stop beyond the fold of the only orbits (Budd & Dux). */
static void no_orbit(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0.5, 1);
    check_fails(&spec, 1, 0.1, 0, SALTUS_NO_CONVERGENCE, "residual");
    closed_oscillator o = {.k = 1, .F = 1, .omega = 2.8L, .r = 0.8L, .periods = 1};
    o.d = 1.05L * closed_undamped_fold(1, o.omega, o.r);
    spec = closed_spec(&o);
    check_fails(&spec, 1, -3, 0, SALTUS_NO_CONVERGENCE, "residual");
}

/* A free mass may stand anywhere; with r = 1 a ball bounces to any height. */
static void orbits_not_isolated(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 0, 1);
    set_parameter(&spec, "F0", 1);
    check_fails(&spec, 1, 0, 0, SALTUS_SINGULAR, "not isolated");
    spec = oscillator_spec(0, 0, 0.5, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, 1, SALTUS_LOWER);
    check_fails(&spec, 1, 3, 3, SALTUS_SINGULAR, "not isolated");
}

/* If every state is periodic the search is refused as not isolated, or finds two multipliers 1. */
static void families_of_orbits(void **unused) {
    (void)unused;
    for (int stop = 0; stop < 2; stop++) {
        saltus_spec spec = oscillator_spec(0, 1, 0, stop ? 2 : 1);
        if (stop)
            add_stop(&spec, 0, 1, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_orbit_options options = saltus_orbit_defaults();
        saltus_message message = {.text = ""};
        saltus_orbit orbit;
        double guess[2] = {-0.3, 0.2};
        saltus_status status = saltus_orbit_find(system, 1, guess, &options, &orbit, &message);
        if (status == SALTUS_OK)
            for (int i = 0; i < 2; i++) {
                check_near(orbit.multipliers[i].re, 1, 1e-6);
                check_near(orbit.multipliers[i].im, 0, 1e-6);
            }
        else
            assert_int_equal(status, SALTUS_SINGULAR);
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
}

/* From an orbit that passes through its stop, with no other nearby: the message says so. */
static void orbit_passes_through_stop(void **unused) {
    (void)unused;
    static const closed_oscillator rows[] = {{.c = 0.0173L,
                                              .k = 1,
                                              .F = 0.8164L,
                                              .F0 = 0.3718L,
                                              .omega = 2.824L,
                                              .d = 0.4882L,
                                              .r = 0.7172L,
                                              .periods = 3},
                                             {.c = 0.172L,
                                              .k = 1,
                                              .F = 1.788L,
                                              .F0 = 0.2994L,
                                              .omega = 2.538L,
                                              .d = 0.6261L,
                                              .r = 0.3917L,
                                              .periods = 3}};
    for (int k = 0; k < 2; k++) {
        closed_orbit orbit[2];
        int which = 0;
        for (int i = 0; i < 2; i++)
            assert_true(closed_orbit_at(&rows[k], i ? 1 : -1, &orbit[i]));
        which = fabsl(orbit[1].margin) < fabsl(orbit[0].margin);
        assert_true(orbit[which].margin < 0 && orbit[which].margin > -0.01L);
        saltus_spec spec = closed_spec(&rows[k]);
        check_fails(&spec, 3, (double)orbit[which].state[0], (double)orbit[which].state[1],
                    SALTUS_NO_CONVERGENCE, "passes through a stop");
    }
}

/* Random searches from states of orbits that pass through their stop: an orbit found closes under the flow,
 * and a failure never blames the input. */
static void searches_at_random(void **unused) {
    (void)unused;
    enum { draws = 1500 };
    gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
    int blamed = 0;
    for (int k = 0; k < draws; k++) {
        closed_oscillator o = {.c = 0.3 * gsl_rng_uniform(random),
                               .k = 1,
                               .F = 2 * gsl_rng_uniform(random),
                               .F0 = 2 * gsl_rng_uniform(random) - 1,
                               .omega = 0.3 + 3 * gsl_rng_uniform(random),
                               .d = 2 * gsl_rng_uniform(random) - 0.5,
                               .r = gsl_rng_uniform(random),
                               .periods = 1 + (int)gsl_rng_uniform_int(random, 3)};
        closed_orbit through;
        if (!closed_orbit_at(&o, gsl_rng_uniform(random) < 0.5 ? 1 : -1, &through) || through.admissible ||
            through.impact[0].speed < 0 || through.margin < -0.3L || through.state[0] >= o.d)
            continue;
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        saltus_orbit_options options = saltus_orbit_defaults();
        saltus_message message = {.text = ""};
        saltus_orbit orbit;
        double guess[2] = {(double)through.state[0], (double)through.state[1]}, state[2];
        saltus_status status = saltus_orbit_find(system, o.periods, guess, &options, &orbit, &message);
        blamed += status == SALTUS_BAD_INPUT;
        if (status == SALTUS_OK) {
            saltus_flow *flow = open_flow(system, &options.flow, 0, orbit.state);
            advance(flow, o.periods, 0);
            saltus_flow_state(flow, 0, state);
            check_near(hypot(state[0] - orbit.state[0], state[1] - orbit.state[1]), 0, 1e-9);
            saltus_flow_free(flow);
        } else {
            assert_true(message.text[0]);
        }
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
    gsl_rng_free(random);
    assert_int_equal(blamed, 0);
}

/* The statements of orbit.h about a result, checked anew: the residual is the distance by which the orbit
 * fails to close, the monodromy matrix is the derivative by differences, at any phase. */
static void results_found_anew(void **unused) {
    (void)unused;
    const double step = 1e-6;
    closed_oscillator o = closed_example_of(closed_two_periods);
    o.omega = 0.85L;
    closed_orbit closed;
    assert_true(closed_orbit_at(&o, 1, &closed));
    saltus_spec spec = closed_spec(&o);
    saltus_system *system = build(&spec);
    const double *scale = saltus_system_scale(system);
    for (int k = 0; k < 3; k++) {
        saltus_orbit_options options = saltus_orbit_defaults();
        double start[2] = {(double)closed.state[0], (double)closed.state[1]}, end[2], side[2][2];
        options.phase = 0.3 * k;
        options.tolerance = k ? 1e-12 : 1e-4;
        saltus_flow *flow = open_flow(system, &options.flow, 0, start);
        advance(flow, options.phase, 0);
        saltus_flow_state(flow, 0, start);
        start[0] += 1e-4;
        saltus_orbit orbit = find(system, 2, start, &options);
        assert_int_equal(orbit.dimension, 2);
        assert_int_equal(orbit.periods, 2);
        assert_false(orbit.sticks);
        assert_true(orbit.residual <= options.tolerance && orbit.iterations >= 1);
        check_near(orbit.log_volume, 2 * log(0.9) - 0.08 * 2 * saltus_system_period(system), 1e-10);
        check_near(orbit.sum_rule, orbit.log_volume, 1e-10);
        saltus_flow_free(flow);
        flow = open_flow(system, &options.flow, options.phase, orbit.state);
        advance(flow, 2 + options.phase, 0);
        saltus_flow_state(flow, 0, end);
        check_near(fmax(fabs(end[0] - orbit.state[0]) / scale[0], fabs(end[1] - orbit.state[1]) / scale[1]),
                   orbit.residual, 1e-12);
        saltus_flow_free(flow);
        for (int j = 0; j < 2; j++) {
            for (int sign = 0; sign < 2; sign++) {
                double beside[2] = {orbit.state[0], orbit.state[1]};
                beside[j] += sign ? step : -step;
                flow = open_flow(system, &options.flow, options.phase, beside);
                advance(flow, 2 + options.phase, 0);
                saltus_flow_state(flow, 0, side[sign]);
                saltus_flow_free(flow);
            }
            for (int i = 0; i < 2; i++)
                check_near(orbit.monodromy[2 * i + j], (side[1][i] - side[0][i]) / (2 * step), 1e-6);
        }
        saltus_orbit_clear(&orbit);
        assert_null(orbit.state);
    }
    saltus_system_free(system);
}

/* Newton's method makes no more steps than allowed, and reports each with its residual; a search that needs
 * more fails. */
static void iterations_are_limited(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_one_period);
    o.omega = 1.1L;
    closed_orbit closed;
    assert_true(closed_orbit_at(&o, 1, &closed));
    saltus_spec spec = closed_spec(&o);
    saltus_system *system = build(&spec);
    double guess[2] = {(double)closed.state[0] + 0.05, (double)closed.state[1] - 0.05};
    history whole = {0};
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    options.history = remember;
    options.context = &whole;
    saltus_orbit orbit = find(system, 1, guess, &options);
    assert_false(whole.prescribed);
    assert_int_equal(whole.count, orbit.iterations + 1);
    for (int k = 0; k + 2 < whole.count; k++)
        assert_true(whole.residual[k + 1] < whole.residual[k]);
    saltus_orbit_clear(&orbit);
    options.tolerance = 0.5 * whole.residual[0];
    whole = (history){0};
    orbit = find(system, 1, guess, &options);
    assert_true(orbit.residual <= options.tolerance);
    saltus_orbit_clear(&orbit);
    whole = (history){0};
    options.tolerance = 1e-12;
    for (options.iterations = 2; options.iterations >= 0; options.iterations--) {
        whole = (history){0};
        saltus_status status = saltus_orbit_find(system, 1, guess, &options, &orbit, &message);
        assert_int_equal(whole.last, options.iterations);
        if (options.iterations == 0) {
            assert_int_equal(status, SALTUS_NO_CONVERGENCE);
            assert_null(orbit.state);
        }
        saltus_orbit_clear(&orbit);
    }
    saltus_system_free(system);
    options = saltus_orbit_defaults();
    assert_true(options.phase == 0 && options.iterations == 20 && options.tolerance == 1e-12);
    assert_int_equal(options.segments, 0);
}

/* At the limit of rounding a step that increases the residual is taken back. The reported residual is the
 * least of the search and belongs to the orbit: a search from it without steps finds the same. */
static void a_step_that_does_not_help_is_taken_back(void **unused) {
    (void)unused;
    static const closed_example examples[] = {closed_one_period, closed_two_periods};
    static const double omegas[] = {1.1, 0.85};
    gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
    int found = 0;
    for (int k = 0; k < 40; k++) {
        closed_oscillator o = closed_example_of(examples[k % 2]);
        closed_orbit closed;
        o.omega = omegas[k % 2];
        assert_true(closed_orbit_at(&o, 1, &closed));
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        saltus_orbit_options options = saltus_orbit_defaults();
        saltus_message message = {.text = ""};
        saltus_orbit orbit, again;
        history h = {0};
        const double state[2] = {(double)closed.state[0], (double)closed.state[1]};
        double guess[2];
        disturb(random, 1e-3, 2, state, guess);
        options.history = remember;
        options.context = &h;
        options.tolerance = k % 4 < 2 ? 1e-15 : 3e-16;
        const bool cut = k % 3 > 0;
        options.segments = 1 + k % 3;
        saltus_status status = saltus_orbit_find(system, o.periods, guess, &options, &orbit, &message);
        if (status == SALTUS_OK && !h.prescribed) {
            double least = INFINITY;
            for (int j = 0; j < h.count; j++)
                least = fmin(least, h.residual[j]);
            assert_true(orbit.residual == least && least <= options.tolerance);
            options.iterations = 0;
            options.tolerance = 1;
            options.segments = 1;
            options.history = NULL;
            check_ok(saltus_orbit_find(system, o.periods, orbit.state, &options, &again, &message), &message);
            assert_true(cut ? again.residual < 1e-14 : again.residual == orbit.residual);
            saltus_orbit_clear(&again);
            found++;
        } else {
            assert_true(status == SALTUS_OK || status == SALTUS_NO_CONVERGENCE);
        }
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
    assert_true(found >= 10);
    gsl_rng_free(random);
}

/* A request that no search can fulfil is refused with its number, with and without forcing; values at the
 * limits are accepted. */
static void requests_out_of_range_are_refused(void **unused) {
    (void)unused;
    static const struct {
        int periods, iterations;
        double phase;
        const char *word; /* NULL: valid input */
    } rows[] = {{0, 20, 0, "periods = 0:"},     {-1, 20, 0, "periods = -1:"},
                {1, -1, 0, "iterations = -1:"}, {1, 20, 1, "phase = 1:"},
                {1, 20, 1.5, "phase = 1.5:"},   {1, 20, -0.25, "phase = -0.25:"},
                {1, 20, NAN, "phase = "},       {1, 0, 0, NULL},
                {1, 20, 0.9375, NULL}};
    for (int forced = 0; forced < 2; forced++) {
        saltus_spec spec = oscillator_spec(forced ? 0.1 : 0, 1, forced ? 0.8 : 0, 1.1);
        saltus_system *system = build(&spec);
        const double guess[2] = {0.2, 0.1};
        for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
            saltus_orbit_options options = saltus_orbit_defaults();
            saltus_message message = {.text = ""};
            saltus_orbit orbit;
            options.iterations = rows[k].iterations;
            options.phase = rows[k].phase;
            options.free_period = !forced;
            saltus_status status =
                saltus_orbit_find(system, rows[k].periods, guess, &options, &orbit, &message);
            assert_true((status == SALTUS_BAD_INPUT) == (rows[k].word != NULL));
            if (rows[k].word && !strstr(message.text, rows[k].word))
                fail_msg("\"%s\" does not say \"%s\"", message.text, rows[k].word);
            if (status != SALTUS_OK)
                check_empty(&orbit);
            saltus_orbit_clear(&orbit);
            check_empty(&orbit);
        }
        saltus_system_free(system);
    }
}

/* The period of a forced scene's orbits cannot be an unknown. */
static void forced_periods_are_known(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    double guess[2] = {0.1, 0};
    options.free_period = true;
    assert_int_equal(saltus_orbit_find(system, 1, guess, &options, &orbit, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "forced"));
    check_empty(&orbit);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quadratic_convergence),
        cmocka_unit_test(multipliers_as_wanted),
        cmocka_unit_test(same_orbit_any_way),
        cmocka_unit_test(sticking_orbit),
        cmocka_unit_test(near_grazing),
        cmocka_unit_test(small_multipliers_in_closed_form),
        cmocka_unit_test(small_multipliers_with_impacts),
        cmocka_unit_test(no_orbit),
        cmocka_unit_test(orbits_not_isolated),
        cmocka_unit_test(families_of_orbits),
        cmocka_unit_test(orbit_passes_through_stop),
        cmocka_unit_test(searches_at_random),
        cmocka_unit_test(results_found_anew),
        cmocka_unit_test(iterations_are_limited),
        cmocka_unit_test(a_step_that_does_not_help_is_taken_back),
        cmocka_unit_test(requests_out_of_range_are_refused),
        cmocka_unit_test(forced_periods_are_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
