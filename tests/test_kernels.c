/* The inner loops of the integrators: steps as long as the tolerance allows, special cases with their own
 * loops.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"

#include <gsl/gsl_complex_math.h>
#include <gsl/gsl_eigen.h>

enum { order_max = 12, modes_max = 17, columns_max = 4 };

/* Coefficients c_k h^k of a polynomial of a degree on [0, h], from its values at equal distances. */
static void coefficients_of(const double *values, int degree, double *c) {
    double difference[order_max + 1], product[order_max + 1] = {1};
    memcpy(difference, values, (size_t)(degree + 1) * sizeof *difference);
    memset(c, 0, (size_t)(degree + 1) * sizeof *c);
    for (int k = 0; k <= degree; k++) {
        for (int j = 0; j <= k; j++)
            c[j] += difference[0] * product[j];
        for (int j = 0; j < degree - k; j++)
            difference[j] = (difference[j + 1] - difference[j]) * degree / (k + 1);
        for (int j = k + 1; j > 0 && k < degree; j--)
            product[j] = (j <= k ? -product[j] * k / degree : 0) + product[j - 1];
        product[0] *= -(double)k / degree;
    }
}

/* The largest of |q|, |v| / (velocity unit) and |e|. */
static double norm_of(const saltus_system *system, const double *state) {
    const int dof = saltus_system_dof(system);
    const double *scale = saltus_system_scale(system);
    double norm = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        norm = fmax(norm, fabs(state[i]) * (i >= dof && i < 2 * dof ? scale[0] / scale[dof] : 1));
    return norm;
}

/* The step at which the last two terms of the last step's series would reach the tolerance. */
static double length_allowed(const saltus_flow *flow, int order, double tolerance) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    const int n = saltus_system_dimension(system);
    const double step = saltus_flow_step_length(flow, 0);
    double values[scene_dimension_max][order_max + 1], state[scene_dimension_max], allowed = INFINITY;
    double last[2][scene_dimension_max];
    for (int j = 0; j <= order; j++) {
        saltus_flow_dense(flow, 0, step * j / order, state);
        for (int i = 0; i < n; i++)
            values[i][j] = state[i];
    }
    for (int i = 0; i < n; i++) {
        double c[order_max + 1];
        coefficients_of(values[i], order, c);
        last[0][i] = c[order - 1];
        last[1][i] = c[order];
    }
    saltus_flow_dense(flow, 0, 0, state);
    for (int k = 0; k < 2; k++)
        allowed = fmin(allowed, step * pow(tolerance / norm_of(system, last[k]), 1.0 / (order - 1 + k)));
    return allowed;
}

/* A step ends just before the last two terms of the series reach the tolerance; only steps limited by
 * stability are shorter, and all alike. */
static void steps_are_as_long_as_the_tolerance_allows(void **unused) {
    (void)unused;
    int free_steps = 0;
    for (int name = 0; name < scenes; name++)
        for (int trial = 0; trial < 6; trial++) {
            scene s = scene_of((scene_name)name);
            s.spec.stop_count = 0;
            saltus_system *system = build(&s.spec);
            saltus_flow_options options = saltus_flow_defaults();
            const int order = 8 + trial % 4;
            double longest = 0, lengths[30], allowed[30];
            options.integrator = SALTUS_TAYLOR;
            options.order = order;
            options.rtol = trial % 2 ? 1e-6 : 1e-5;
            options.atol = trial % 3 == 0 ? 2 * options.rtol * norm_of(system, s.state) : 0;
            saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
            for (int k = 0; k < 30; k++) {
                double state[scene_dimension_max];
                saltus_flow_state(flow, 0, state);
                const double size = norm_of(system, state);
                advance(flow, 1e6, SALTUS_WATCH_STEP);
                lengths[k] = saltus_flow_step_length(flow, 0);
                allowed[k] = length_allowed(flow, order, options.atol + options.rtol * size);
                longest = fmax(longest, lengths[k]);
            }
            for (int k = 0; k < 30; k++) {
                const double share = lengths[k] / allowed[k];
                if (!(share < 0.99) || (share < 0.95 && lengths[k] < longest * (1 - 1e-12)))
                    fail_msg("scene %d, order %d, step %d: %.4f of what is allowed", name, order, k, share);
                free_steps += share > 0.95;
            }
            saltus_flow_free(flow);
            saltus_system_free(system);
        }
    assert_true(free_steps > 1000);
}

static double first_step(const saltus_spec *spec, const saltus_flow_options *options, const double *state,
                         const double *tangent, const saltus_direction *direction) {
    saltus_system *system = build(spec);
    saltus_flow *flow = open_flow(system, options, 0.1, state);
    saltus_message message = {.text = ""};
    if (direction) {
        saltus_flow_set_directions(flow, direction);
        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0.1}, state, &message), &message);
    }
    if (tangent)
        saltus_flow_set_tangents(flow, 0, tangent);
    advance(flow, 1e6, SALTUS_WATCH_STEP);
    const double length = saltus_flow_step_length(flow, 0);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return length;
}

/* A tangent vector of an unforced linear system is a trajectory of it and limits steps like one: the shorter
 * step counts. A tangent vector has no absolute tolerance, and none below 1e-13. */
static void tangent_vectors_ask_for_steps_of_their_own(void **unused) {
    (void)unused;
    saltus_spec specs[] = {oscillator_spec(0.2, 1.3, 0, 0.3), oscillator_spec(0.2, 1.3, 0, 0.3),
                           pipe_spec(4, 9)};
    set_parameter(&specs[1], "N", 2);
    set_parameter(&specs[1], "k2", 3);
    set_parameter(&specs[1], "kz", 0.6);
    set_parameter(&specs[2], "sigma", 0);
    set_parameter(&specs[2], "kappa", 0);
    const double slow[scene_dimension_max] = {1e-3, 0, 1e-4, 2e-4, 0, 0, 1e-3, 0},
                 fast[scene_dimension_max] = {0, 3, 0, 0.02, 5, 0.1, 0.3, 1};
    for (int k = 0; k < 3; k++)
        for (int swap = 0; swap < 2; swap++)
            for (int tight = 0; tight < 2; tight++) {
                saltus_flow_options options = saltus_flow_defaults(), column = options;
                const double *state = swap ? slow : fast, *tangent = swap ? fast : slow;
                options.order = 12;
                options.rtol = tight ? 1e-15 : 1e-10;
                options.atol = swap ? 0.5 : 0;
                options.integrator = SALTUS_TAYLOR;
                column = options;
                column.rtol = fmax(column.rtol, 1e-13);
                column.atol = 0;
                double own = first_step(&specs[k], &options, state, NULL, NULL),
                       its = first_step(&specs[k], &column, tangent, NULL, NULL);
                options.columns = 1;
                check_near(first_step(&specs[k], &options, state, tangent, NULL) / fmin(own, its), 1, 1e-9);
            }
}

/* The largest modulus of the eigenvalues of the field's linear part at rest. */
static double fastest_rate(const saltus_spec *spec) {
    saltus_system *system = build(spec);
    saltus_flow_options options = saltus_flow_defaults();
    const int n = saltus_system_dimension(system);
    double zero[scene_dimension_max] = {0}, columns[scene_dimension_max * scene_dimension_max], fastest = 0;
    options.columns = n;
    saltus_flow *flow = open_flow(system, &options, 0, zero);
    saltus_flow_tangent_field(flow, 0, columns);
    gsl_matrix_view matrix = gsl_matrix_view_array(columns, (size_t)n, (size_t)n);
    gsl_vector_complex *values = gsl_vector_complex_alloc((size_t)n);
    gsl_eigen_nonsymm_workspace *work = gsl_eigen_nonsymm_alloc((size_t)n);
    assert_int_equal(gsl_eigen_nonsymm(&matrix.matrix, values, work), 0);
    for (int i = 0; i < n; i++)
        fastest = fmax(fastest, gsl_complex_abs(gsl_vector_complex_get(values, (size_t)i)));
    gsl_eigen_nonsymm_free(work);
    gsl_vector_complex_free(values);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return fastest;
}

/* At rest the step is the largest possible: at most six times the shortest time scale of field or forcing,
 * and not much less. */
static void the_largest_step_follows_the_fastest_rate(void **unused) {
    (void)unused;
    const double rest[scene_dimension_max] = {0};
    for (int k = 0; k < 32; k++) {
        saltus_spec spec =
            k < 24 ? oscillator_spec(k % 3 * 4, k % 4 * 2, 0, k % 5 ? 0.3 : 9) : pipe_spec(1 + k % 5, 5);
        if (k < 24) {
            set_parameter(&spec, "m", k % 2 ? 1 : 2.5);
            set_parameter(&spec, "N", 1 + k / 12);
            set_parameter(&spec, "k2", k % 7);
            set_parameter(&spec, "m2", 0.4);
            set_parameter(&spec, "c2", k % 2);
            set_parameter(&spec, "kz", k / 6 % 2 ? 3 : 0);
            set_parameter(&spec, "tz", k % 2 ? 0.05 : 20);
        } else {
            set_parameter(&spec, "sigma", 0);
            set_parameter(&spec, "alpha", k % 2 ? 0.005 : 0); /* without forcing the field sets the rate */
        }
        saltus_flow_options options = saltus_flow_defaults();
        options.integrator = SALTUS_TAYLOR;
        const double rate = fmax(fastest_rate(&spec), saltus_spec_get(&spec, "omega")),
                     turns = rate * first_step(&spec, &options, rest, NULL, NULL);
        if (!(turns <= 6 * (1 + 1e-12) && turns > 1.5))
            fail_msg("case %d: %.3g times the shortest time", k, turns);
    }
}

/* The derivative by the force begins at zero and moves like a mass from rest under unit force; its size is
 * what it grows to, the size of a state at rest a millionth of its growth. */
static void parameter_columns_are_judged_by_their_growth(void **unused) {
    (void)unused;
    const double rest[5] = {0};
    saltus_spec still = oscillator_spec(0.2, 1.3, 0, 2.1), driven = oscillator_spec(0.2, 1.3, 1, 2.1);
    saltus_flow_options options = saltus_flow_defaults(), loose;
    saltus_message message = {.text = ""};
    saltus_direction direction;
    double value;
    options.atol = 0;
    options.integrator = SALTUS_TAYLOR;
    for (int order = 9; order <= 12; order++) {
        options.order = order;
        options.rtol = 1e-10;
        options.columns = options.directions = 0;
        loose = options;
        loose.rtol = 1e-4;
        double expected = first_step(&driven, &loose, rest, NULL, NULL),
               longest = first_step(&still, &options, rest, NULL, NULL);
        check_ok(saltus_spec_direction(&still, "F", &direction, &value, &message), &message);
        options.columns = options.directions = 1;
        double found = first_step(&still, &options, rest, NULL, &direction);
        assert_true(expected < 0.9 * longest);
        check_near(found / expected, 1, 1e-6);
    }
}

/* A pipe's state and tangent vectors after a short time, the last two of four being parameter columns; held
 * on its stop if it begins there. */
typedef struct outcome {
    double state[2 * modes_max], tangents[columns_max * 2 * modes_max];
} outcome;

/* Remove a vector's component along the normal. */
static void level(const saltus_system *system, double *vector) {
    const double *normal = saltus_system_stop_normal(system, 0);
    double along = 0, square = 0;
    for (int i = 0; i < saltus_system_dof(system); i++) {
        along += normal[i] * vector[i];
        square += normal[i] * normal[i];
    }
    for (int i = 0; i < saltus_system_dof(system); i++)
        vector[i] -= along / square * normal[i];
}

static outcome run_pipe(saltus_spec spec, int columns, int directions, bool held,
                        saltus_integrator integrator) {
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_flow *flow = NULL;
    const int dof = saltus_system_dof(system), n = 2 * dof;
    outcome begin = {.state = {0}}, out = begin;
    options.integrator = integrator;
    options.order = dof % 2 ? 21 : 0;
    options.columns = columns;
    options.directions = directions;
    options.rtol = 1e-12;
    for (int i = 0; i < dof; i++) {
        begin.state[i] = (i % 3 - 0.7) * 0.02 / ((i + 1) * (i + 1));
        begin.state[dof + i] = (0.8 - i % 2) * 0.2 / (i + 1);
        for (int c = 0; c < columns - directions; c++) {
            begin.tangents[c * n + i] = cos(2 * i + c) / (i + 1);
            begin.tangents[c * n + dof + i] = sin(i + 2 * c) * 10;
        }
    }
    for (int c = 0; held && c < columns; c++) {
        level(system, begin.tangents + c * n);
        level(system, begin.tangents + c * n + dof);
    }
    if (held) {
        double shape = saltus_system_shape(system, begin.state, spec.stops[0].xi);
        level(system, begin.state + dof);
        saltus_system_free(system);
        spec.stops[0].d = shape;
        system = build(&spec);
    }
    check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
    if (directions) {
        saltus_direction along[2];
        double value;
        check_ok(saltus_spec_direction(&spec, "sigma", &along[0], &value, &message), &message);
        check_ok(saltus_spec_direction(&spec, "kappa", &along[1], &value, &message), &message);
        saltus_flow_set_directions(flow, along);
    }
    check_ok(saltus_flow_place(flow, 0, (saltus_time){0, 0.3}, begin.state, held, &message), &message);
    saltus_flow_set_tangents(flow, 0, begin.tangents);
    check_ok(saltus_flow_coast(flow, 0, (saltus_time){0, 0.37}, NULL, &message), &message);
    saltus_flow_state(flow, 0, out.state);
    saltus_flow_tangents(flow, 0, out.tangents);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return out;
}

/* Entries agree relative to the largest of their kind. */
static void check_alike(const double *a, const double *b, int dof, double tolerance) {
    for (int half = 0; half < 2; half++) {
        double size = 1e-300;
        for (int i = 0; i < dof; i++)
            size = fmax(size, fabs(b[half * dof + i]));
        for (int i = 0; i < dof; i++)
            check_near(a[half * dof + i] / size, b[half * dof + i] / size, tolerance);
    }
}

/* A term dropped because its number is zero has no effect: a tiny number instead gives the same motion. Both
 * integrators pass the same points for all numbers of modes, terms, columns and contacts that have their own
 * loops. */
static void all_loops_lead_to_the_same_point(void **unused) {
    (void)unused;
    static const int sizes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 17};
    static const char *const names[] = {"beta", "sigma", "kappa"};
    for (int k = 0; k < (int)(sizeof sizes / sizeof sizes[0]); k++)
        for (int gone = 0; gone < 8; gone++) {
            const int modes = sizes[k],
                      columns = gone % 2         ? columns_max
                                : (k + gone) % 4 ? 1
                                                 : 0,
                      directions = columns == columns_max ? 2 : 0;
            const bool held = modes > 1 && (k + gone / 2) % 2;
            saltus_spec zero = pipe_spec(modes, 12), small;
            add_stop(&zero, 0.5, 0.5, SALTUS_UPPER);
            zero.stops[0].xi = 0.37;
            set_parameter(&zero, "alpha", 1e-4);
            if (directions)
                set_parameter(&zero, "beta", 0.3);
            small = zero;
            for (int t = 0; t < 3; t++)
                if (gone >> t & 1) {
                    set_parameter(&zero, names[t], 0);
                    set_parameter(&small, names[t], 1e-200);
                }
            outcome without = run_pipe(zero, columns, directions, held, SALTUS_TAYLOR),
                    with = run_pipe(small, columns, directions, held, SALTUS_TAYLOR),
                    stiff = run_pipe(zero, columns, directions, held, SALTUS_RADAU);
            check_alike(without.state, with.state, modes, 1e-11);
            check_alike(without.state, stiff.state, modes, 1e-9);
            for (int c = 0; c < columns; c++) {
                const int at = 2 * modes * c;
                check_alike(without.tangents + at, with.tangents + at, modes, 1e-10);
                check_alike(without.tangents + at, stiff.tangents + at, modes, 1e-8);
            }
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_are_as_long_as_the_tolerance_allows),
        cmocka_unit_test(tangent_vectors_ask_for_steps_of_their_own),
        cmocka_unit_test(the_largest_step_follows_the_fastest_rate),
        cmocka_unit_test(parameter_columns_are_judged_by_their_growth),
        cmocka_unit_test(all_loops_lead_to_the_same_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
