/* The promises of equilibrium.h: equilibria are at rest under the flow with the contact forces found, for any
 * guess; eigenvalues are those of the motion nearby; options and refusals.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <complex.h>

static saltus_equilibrium rest(const saltus_system *system, const double *guess) {
    saltus_equilibrium_options options = saltus_equilibrium_defaults();
    saltus_message message = {.text = ""};
    saltus_equilibrium found;
    check_ok(saltus_equilibrium_find(system, guess, &options, &found, &message), &message);
    return found;
}

/* Two masses under loads, the second one not 1; stops on one mass, on the other from both sides, and on their
 * distance. */
static saltus_spec loaded(double load, double second) {
    saltus_spec spec = oscillator_spec(0.3, 2, 0, 1);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "m", 3);
    set_parameter(&spec, "m2", 0.4);
    set_parameter(&spec, "k2", 1.5);
    set_parameter(&spec, "c2", 0.2);
    set_parameter(&spec, "F0", load);
    set_parameter(&spec, "F02", second);
    add_stop(&spec, 0.7, 0.5, SALTUS_UPPER);
    add_stop(&spec, 0.9, 0.6, SALTUS_BOTH);
    add_stop(&spec, 0.6, 0.7, SALTUS_LOWER);
    spec.stops[0].weight[0] = 2;
    spec.stops[1].weight[0] = 0;
    spec.stops[1].weight[1] = 1;
    spec.stops[2].weight[0] = 1;
    spec.stops[2].weight[1] = -1;
    return spec;
}

/* Forces balance, K x = loads - sum of normal times contact force; contact forces push, gaps are those of the
 * state, and the flow has the same forces and stays there. */
static void check_rest(const saltus_spec *spec, const saltus_system *system, const saltus_equilibrium *e) {
    double k = saltus_spec_get(spec, "k"), k2 = saltus_spec_get(spec, "k2");
    double balance[2] = {saltus_spec_get(spec, "F0") - (k + k2) * e->state[0] + k2 * e->state[1],
                         saltus_spec_get(spec, "F02") + k2 * e->state[0] - k2 * e->state[1]};
    int held = 0;
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        const double *n = saltus_system_stop_normal(system, face.stop);
        double gap = face.side * (n[0] * e->state[0] + n[1] * e->state[1]) - face.d;
        bool holds = e->contacts >> f & 1;
        held += holds;
        check_near(e->gap[f], gap, 1e-14);
        assert_true(holds ? e->gap[f] == 0 && e->contact_force[f] > 0
                          : e->gap[f] < 0 && e->contact_force[f] == 0);
        for (int i = 0; i < 2; i++)
            balance[i] -= face.side * n[i] * e->contact_force[f];
    }
    for (int i = 0; i < 2; i++) {
        check_near(balance[i], 0, 1e-13);
        assert_true(e->state[2 + i] == 0);
    }
    for (int f = saltus_system_face_count(system); f < SALTUS_FACES_MAX; f++)
        assert_true(e->contact_force[f] == 0);
    assert_int_equal(e->dimension, saltus_system_dimension(system));
    assert_int_equal(e->eigenvalue_count, e->dimension - 2 * held);
    assert_true(e->residual >= 0 && e->residual <= 1e-12);
    assert_true(e->iterations >= 1);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &options, 0, e->state);
    double forces[SALTUS_FACES_MAX], after[4];
    assert_int_equal(saltus_flow_contacts(flow, 0), e->contacts);
    saltus_flow_forces(flow, 0, forces);
    for (int f = 0; f < saltus_system_face_count(system); f++)
        check_near(e->contact_force[f], forces[f], 1e-12);
    advance(flow, 2, 0);
    saltus_flow_state(flow, 0, after);
    for (int i = 0; i < 4; i++)
        check_near(after[i], e->state[i], 1e-10);
    saltus_flow_free(flow);
}

/* A linear chain has one equilibrium for any loads, found from any guess, inside the stops, on them and
 * beyond; velocities of the guess do not matter. */
static void rests_of_a_loaded_chain(void **unused) {
    (void)unused;
    static const double guesses[][4] = {
        {0, 0, 0, 0}, {5, -3, 1, 2}, {0.35, 0.9, 0, 0}, {-2, 4, 0, -9}, {0.35, 0.55, 7, 0}};
    unsigned seen = 0;
    for (double load = -4; load <= 4; load += 0.617)
        for (double second = -3; second <= 3; second += 0.731) {
            saltus_spec spec = loaded(load, second);
            saltus_system *system = build(&spec);
            saltus_equilibrium first = rest(system, guesses[0]);
            check_rest(&spec, system, &first);
            seen |= 1u << first.contacts;
            /* Each solution gives the next set of contacts: two Newton steps each, none in vain. */
            int held = 0;
            for (int f = 0; f < SALTUS_FACES_MAX; f++)
                held += first.contacts >> f & 1;
            assert_in_range(first.iterations, 1, 2 * (held + 1));
            /* From the equilibrium itself the held faces are touched, and tried first. */
            saltus_equilibrium same = rest(system, first.state);
            assert_int_equal(same.contacts, first.contacts);
            assert_in_range(same.iterations, 1, 2);
            saltus_equilibrium_clear(&same);
            for (size_t g = 1; g < sizeof guesses / sizeof guesses[0]; g++) {
                saltus_equilibrium other = rest(system, guesses[g]);
                assert_int_equal(other.contacts, first.contacts);
                for (int i = 0; i < 4; i++)
                    check_near(other.state[i], first.state[i], 1e-13);
                saltus_equilibrium_clear(&other);
            }
            assert_true(first.stable && first.instability == 0);
            saltus_equilibrium_clear(&first);
            assert_null(first.state);
            saltus_system_free(system);
        }
    /* No contact, one of each kind, and two at once must occur. */
    int kinds = 0;
    for (unsigned contacts = 0; contacts < 16; contacts++)
        kinds += seen >> contacts & 1;
    assert_true((seen & 1) && kinds >= 6);
}

/* The eigenvalues are the roots of the characteristic polynomial of the chain: free, with either mass held,
 * and with their distance held. */
static void eigenvalues_of_a_loaded_chain(void **unused) {
    (void)unused;
    static const struct {
        double load, second;
        unsigned contacts;
        double m, c, k; /* of the only free motion; 0: both masses are free */
    } rows[] = {{0, 0, 0, 0, 0, 0},
                {2, 0.3, 1, 0.4, 0.2, 1.5},
                {-0.23, 3, 2, 3, 0.5, 3.5},
                {-1.3, 1.5, 8, 3.4, 0.3, 2}};
    const double guess[4] = {0};
    for (int row = 0; row < 4; row++) {
        saltus_spec spec = loaded(rows[row].load, rows[row].second);
        saltus_system *system = build(&spec);
        saltus_equilibrium e = rest(system, guess);
        double sum = 0;
        assert_int_equal(e.contacts, rows[row].contacts);
        for (int i = 0; i < e.eigenvalue_count; i++) {
            double complex s = e.eigenvalues[i].re + e.eigenvalues[i].im * I;
            double complex one = 3 * s * s + 0.5 * s + 3.5, two = 0.4 * s * s + 0.2 * s + 1.5,
                           join = 0.2 * s + 1.5;
            double complex value =
                row == 0 ? one * two - join * join : rows[row].m * s * s + rows[row].c * s + rows[row].k;
            check_near(cabs(value), 0, 1e-12);
            sum += e.eigenvalues[i].re;
            if (i > 0)
                assert_true(e.eigenvalues[i].re < e.eigenvalues[i - 1].re ||
                            (e.eigenvalues[i].re == e.eigenvalues[i - 1].re &&
                             e.eigenvalues[i].im < e.eigenvalues[i - 1].im));
        }
        if (row == 0)
            check_near(sum, saltus_system_trace(system, e.state, 0), 1e-13);
        saltus_equilibrium_clear(&e);
        saltus_system_free(system);
    }
}

/* The same with a Maxwell element beside the first spring: its force is a state of the first order, whichever
 * mass is held. */
static void eigenvalues_with_a_maxwell_element(void **unused) {
    (void)unused;
    static const struct {
        double load, second;
        unsigned contacts;
        int count;
    } rows[] = {{0, 0, 0, 5}, {2, 0.3, 1, 3}, {-0.23, 3, 2, 3}, {-1.3, 1.5, 8, 3}};
    const double guess[5] = {0}, kz = 0.8, tz = 0.7;
    for (int row = 0; row < 4; row++) {
        saltus_spec spec = loaded(rows[row].load, rows[row].second);
        set_parameter(&spec, "kz", kz);
        set_parameter(&spec, "tz", tz);
        saltus_system *system = build(&spec);
        saltus_equilibrium e = rest(system, guess);
        assert_int_equal(e.contacts, rows[row].contacts);
        assert_int_equal(e.eigenvalue_count, rows[row].count);
        assert_true(e.stable);
        for (int i = 0; i < e.eigenvalue_count; i++) {
            double complex s = e.eigenvalues[i].re + e.eigenvalues[i].im * I, relax = s + 1 / tz,
                           one = (3 * s * s + 0.5 * s + 3.5) * relax + kz * s,
                           two = 0.4 * s * s + 0.2 * s + 1.5, join = 0.2 * s + 1.5;
            double complex value = row == 0   ? one * two - join * join * relax
                                   : row == 1 ? two * relax
                                   : row == 2 ? one
                                              : (3.4 * s * s + 0.3 * s + 2) * relax + kz * s;
            check_near(cabs(value), 0, 1e-11);
        }
        saltus_equilibrium_clear(&e);
        saltus_system_free(system);
    }
}

/* A load that just reaches a stop: held as soon as the contact force pushes, in any unit of length. */
static void contact_begins_where_the_load_reaches_the_stop(void **unused) {
    (void)unused;
    static const double units[] = {1, 1e-9, 1e9};
    const double guess[2] = {0};
    for (int u = 0; u < 3; u++)
        for (int side = -1; side <= 1; side += 2)
            for (int above = -1; above <= 1; above += 2) {
                double unit = units[u];
                saltus_spec spec = oscillator_spec(0.1, 2, 0, 1);
                set_parameter(&spec, "F0", side * (0.6 + above * 1e-6) * unit);
                add_stop(&spec, 0.3 * unit, 0.5, SALTUS_BOTH);
                saltus_system *system = build(&spec);
                saltus_equilibrium e = rest(system, guess);
                assert_int_equal(e.contacts, above > 0 ? (side > 0 ? 1 : 2) : 0);
                check_near(e.contact_force[side > 0 ? 0 : 1], above > 0 ? 1e-6 * unit : 0, 1e-15 * unit);
                check_near(e.state[0], side * (above > 0 ? 0.3 : 0.3 - 0.5e-6) * unit, 1e-15 * unit);
                saltus_equilibrium_clear(&e);
                saltus_system_free(system);
            }
}

/* Undamped motion near an equilibrium neither grows nor decays: neither unstable nor stable. */
static void undamped_rest_is_not_stable(void **unused) {
    (void)unused;
    const double guess[2] = {0};
    saltus_spec spec = oscillator_spec(0, 4, 0, 1);
    saltus_system *system = build(&spec);
    saltus_equilibrium e = rest(system, guess);
    assert_false(e.stable);
    assert_int_equal(e.instability, 0);
    check_near(e.eigenvalues[0].im, 2, 1e-14);
    check_near(e.eigenvalues[1].im, -2, 1e-14);
    saltus_equilibrium_clear(&e);
    saltus_system_free(system);
}

/* The buckled pipe: a stable equilibrium on either side, and the straight one between with one growing
 * direction, or two if the second mode is unstable too. Velocities of a guess change no bit. */
static void straight_and_buckled(void **unused) {
    (void)unused;
    for (int fast = 0; fast < 2; fast++) {
        saltus_spec spec = pipe_spec(3, 40);
        set_parameter(&spec, "sigma", 0);
        set_parameter(&spec, "beta", 0);
        set_parameter(&spec, "u0", fast ? 7 : 4.5);
        saltus_system *system = build(&spec);
        double straight[6] = {0}, guess[6] = {0.03, 0.001, 0, 0, 0, 0},
               moving[6] = {0.03, 0.001, 0, 3, -2, 1};
        saltus_equilibrium e = rest(system, straight);
        assert_int_equal(e.instability, fast ? 2 : 1);
        assert_false(e.stable);
        for (int i = 0; i < 6; i++)
            assert_true(e.state[i] == 0);
        saltus_equilibrium_clear(&e);
        e = rest(system, guess);
        saltus_equilibrium other = rest(system, moving);
        assert_true(e.stable && e.instability == 0);
        assert_int_equal(other.iterations, e.iterations);
        for (int i = 0; i < 6; i++)
            assert_true(other.state[i] == e.state[i]);
        /* The tolerance bounds the last Newton step, before the one that changed nothing. */
        saltus_equilibrium_options options = saltus_equilibrium_defaults();
        saltus_message message = {.text = ""};
        saltus_equilibrium loose;
        options.tolerance = 1e-3;
        check_ok(saltus_equilibrium_find(system, guess, &options, &loose, &message), &message);
        assert_true(loose.residual <= 1e-3 && loose.residual > e.residual);
        assert_true(loose.iterations < e.iterations);
        saltus_equilibrium_clear(&loose);
        options.tolerance = 1e-12;
        options.iterations = e.iterations - 1;
        assert_int_equal(saltus_equilibrium_find(system, guess, &options, &loose, &message),
                         SALTUS_NO_CONVERGENCE);
        assert_null(loose.state);
        assert_null(loose.eigenvalues);
        options.iterations = e.iterations;
        check_ok(saltus_equilibrium_find(system, guess, &options, &loose, &message), &message);
        saltus_equilibrium_clear(&loose);
        saltus_equilibrium_clear(&e);
        saltus_equilibrium_clear(&other);
        saltus_system_free(system);
    }
}

/* A guess with any entry not finite is refused; a zeroed equilibrium can be cleared. */
static void refused_guesses(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 0, 1);
    saltus_system *system = build(&spec);
    saltus_equilibrium_options options = saltus_equilibrium_defaults();
    saltus_message message = {.text = ""};
    saltus_equilibrium e;
    for (int i = 0; i < 2; i++) {
        double guess[2] = {0};
        guess[i] = i ? NAN : INFINITY;
        assert_int_equal(saltus_equilibrium_find(system, guess, &options, &e, &message), SALTUS_BAD_INPUT);
        assert_null(e.state);
    }
    assert_int_equal(options.iterations, 50);
    assert_true(options.tolerance == 1e-12);
    e = (saltus_equilibrium){0};
    saltus_equilibrium_clear(&e);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rests_of_a_loaded_chain),
        cmocka_unit_test(eigenvalues_of_a_loaded_chain),
        cmocka_unit_test(eigenvalues_with_a_maxwell_element),
        cmocka_unit_test(contact_begins_where_the_load_reaches_the_stop),
        cmocka_unit_test(undamped_rest_is_not_stable),
        cmocka_unit_test(straight_and_buckled),
        cmocka_unit_test(refused_guesses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
