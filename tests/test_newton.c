/* Newton's method, tangents and null vectors for equations with known solutions.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "made_equations.h"

#include "allocations.h"

#include <errno.h>

static bool lacking;

static bool refuse(void) {
    if (lacking)
        errno = ENOMEM;
    return lacking;
}

static double dot(const double *a, const double *b, int count) {
    double sum = 0;
    for (int j = 0; j < count; j++)
        sum += a[j] * b[j];
    return sum;
}

/* The equations must be as an evaluation at u left them. */
static void check_evaluated_at(made *m, const double *u) {
    double residual[made_unknowns_max], jacobian[made_unknowns_max * made_unknowns_max], size = 0;
    m->function(m, u, residual, jacobian);
    assert_memory_equal(residual, m->e.residual, (size_t)m->e.count * sizeof *residual);
    assert_memory_equal(jacobian, m->e.jacobian, (size_t)(m->e.count * m->e.unknowns) * sizeof *jacobian);
    for (int i = 0; i < m->e.count; i++)
        size = fmax(size, fabs(residual[i]));
    assert_true(m->e.size == size);
}

/* At a fixed parameter, from nearby, damped or not: the solution to rounding, with the parameter to the last
 * bit. */
static void solutions_are_found(void **state) {
    (void)state;
    unsigned long long seed = 1;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2)
        for (int k = 0; k < 20; k++) {
            made m;
            saltus_message message = {.text = ""};
            double exact[made_unknowns_max], tangent[made_unknowns_max], u[made_unknowns_max];
            int iterations;
            made_open_helix(&m, unknowns, &seed);
            made_helix_at(unknowns, 4 * made_random(&seed), exact, tangent);
            for (int j = 0; j < unknowns; j++)
                u[j] = exact[j] + (j < m.e.count ? 0.3 * made_random(&seed) : 0);
            check_ok(saltus_newton(&m.e, u, NULL, NULL, k % 2, &iterations, &message), &message);
            check_near(made_apart(u, exact, unknowns), 0, 1e-14);
            assert_true(u[unknowns - 1] == exact[unknowns - 1]);
            /* The equations are linear at a fixed parameter. */
            assert_in_range(iterations, 1, 3);
            check_evaluated_at(&m, u);
            made_close(&m);
        }
}

/* On a hyperplane: the solution is on the curve and in the plane. */
static void hyperplanes_are_kept_to(void **state) {
    (void)state;
    unsigned long long seed = 2;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2)
        for (int k = 0; k < 20; k++) {
            made m;
            saltus_message message = {.text = ""};
            double exact[made_unknowns_max], normal[made_unknowns_max], anchor[made_unknowns_max],
                u[made_unknowns_max], on[made_unknowns_max], unused[made_unknowns_max];
            int iterations;
            made_open_helix(&m, unknowns, &seed);
            made_helix_at(unknowns, 4 * made_random(&seed), exact, normal);
            for (int j = 0; j < unknowns; j++) {
                anchor[j] = exact[j] + 0.05 * normal[j];
                u[j] = anchor[j] + 0.01 * made_random(&seed);
            }
            check_ok(saltus_newton(&m.e, u, normal, anchor, false, &iterations, &message), &message);
            check_near(dot(normal, u, unknowns) - dot(normal, anchor, unknowns), 0, 1e-14);
            made_helix_at(unknowns, u[unknowns - 1], on, unused);
            check_near(made_apart(u, on, unknowns), 0, 1e-14);
            assert_true(m.e.size <= m.e.tolerance);
            made_close(&m);
        }
}

/* From a point of the curve to a near one residuals suffice, with the Jacobian computed once at the end; to a
 * far one they do not, and the result is as without them. */
static void residuals_alone_lead_near(void **state) {
    (void)state;
    unsigned long long seed = 7;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2)
        for (int far = 0; far < 2; far++) {
            made m;
            saltus_message message = {.text = ""};
            double from[made_unknowns_max], normal[made_unknowns_max], anchor[made_unknowns_max],
                u[2][made_unknowns_max], on[made_unknowns_max], unused[made_unknowns_max];
            int iterations[2];
            made_open_helix(&m, unknowns, &seed);
            made_helix_at(unknowns, 0.3, from, normal);
            for (int k = 0; k < 2; k++) {
                m.e.measure = made_measure;
                m.e.hasty = k;
                check_ok(saltus_equations_evaluate(&m.e, from, &message), &message);
                for (int j = 0; j < unknowns; j++)
                    u[k][j] = anchor[j] = from[j] + (far ? 0.8 : 1e-3) * normal[j];
                made_count(&m, 0, SALTUS_OK);
                check_ok(saltus_newton(&m.e, u[k], normal, anchor, false, &iterations[k], &message),
                         &message);
                if (k && !far) {
                    assert_int_equal(m.evaluations, 1);
                    assert_in_range(m.measurements, 2, 8);
                    assert_true(m.e.size <= 0.1 * m.e.tolerance);
                }
                made_helix_at(unknowns, u[k][unknowns - 1], on, unused);
                check_near(made_apart(u[k], on, unknowns), 0, 1e-14);
                assert_true(made_apart(m.e.place, u[k], unknowns) < 1e-8);
            }
            check_near(made_apart(u[0], u[1], unknowns), 0, 1e-14);
            assert_int_equal(iterations[0], iterations[1]);
            made_close(&m);
        }
}

/* At a fixed parameter residuals alone lead on from a point that is all but a solution, with its own
 * Jacobian; from farther away each step computes one. */
static void residuals_alone_finish(void **state) {
    (void)state;
    static const double distances[] = {1e-8, 1e-7, -3e-7, 1e-4, 0.1};
    for (size_t k = 0; k < sizeof distances / sizeof *distances; k++) {
        const bool close = fabs(distances[k]) < 1e-6;
        made m;
        saltus_message message = {.text = ""};
        int iterations;
        double u[2] = {0.8 + distances[k], 0.6};
        made_open(&m, 2, made_ellipse, 1, 1);
        m.e.measure = made_measure;
        m.e.hasty = true;
        made_count(&m, 0, SALTUS_OK);
        check_ok(saltus_newton(&m.e, u, NULL, NULL, true, &iterations, &message), &message);
        check_near(u[0], 0.8, 1e-13);
        assert_true(u[1] == 0.6);
        assert_true(m.e.size <= m.e.tolerance);
        if (close) {
            assert_int_equal(m.evaluations, 1);
            assert_in_range(m.measurements, 1, 2);
            assert_int_equal(iterations, m.measurements);
        } else {
            assert_in_range(m.evaluations, 2, 6);
            assert_int_equal(m.measurements, 0);
        }
        made_close(&m);
    }
}

/* Without a known Jacobian, or if residuals alone fail, each step computes its own. */
static void residuals_that_do_not_help(void **state) {
    (void)state;
    made m;
    saltus_message message = {.text = ""};
    int iterations;
    double u[2] = {1, 0}, normal[2] = {0, 1}, anchor[2];
    made_open(&m, 2, made_ellipse, 1, 1);
    m.e.measure = made_measure;
    m.e.hasty = true;
    anchor[0] = 1;
    anchor[1] = 0.01;
    memcpy(u, anchor, sizeof u);
    check_ok(saltus_newton(&m.e, u, normal, anchor, false, &iterations, &message), &message);
    assert_int_equal(m.measurements, 0);
    m.border = 0.9999;
    memcpy(u, anchor, sizeof u);
    made_count(&m, 0, SALTUS_OK);
    assert_int_equal(saltus_newton(&m.e, u, normal, anchor, false, &iterations, &message), SALTUS_STALLED);
    assert_int_equal(m.measurements, 1);
    assert_true(u[0] == 1);
    made_close(&m);
}

/* atan (x - y) = 0: from far away full steps diverge, damped ones do not. */
static void arc(const made *m, const double *u, double *residual, double *jacobian) {
    (void)m;
    double x = u[0] - u[1];
    residual[0] = atan(x);
    jacobian[0] = 1 / (1 + x * x);
    jacobian[1] = -jacobian[0];
}

static void damping_reaches_further(void **state) {
    (void)state;
    made m;
    saltus_message message = {.text = ""};
    int iterations;
    made_open(&m, 2, arc, 0, 0);
    for (int damped = 0; damped < 2; damped++) {
        double u[2] = {3.5, 0.5};
        saltus_status status = saltus_newton(&m.e, u, NULL, NULL, damped, &iterations, &message);
        assert_int_equal(status == SALTUS_OK, damped);
        if (damped)
            check_near(u[0], 0.5, 1e-12);
    }
    made_close(&m);
}

/* A long chain of growth before which all is forgotten: from y = 0 the next solution is far away for y2,
 * although the residual is small, and no damped step to it lowers the residual. */
static void chain(const made *m, const double *u, double *residual, double *jacobian) {
    (void)m;
    const double rows[] = {1, 0, 0, -1, -1e3, 1, 0, 0, 0, -1e3, 1 - 4 * u[2], 0};
    residual[0] = u[0] - u[3];
    residual[1] = u[1] - 1e3 * u[0];
    residual[2] = u[2] - 1e3 * u[1] - 2 * u[2] * u[2];
    memcpy(jacobian, rows, sizeof rows);
}

static void growth_hides_no_solution(void **state) {
    (void)state;
    made m;
    int iterations;
    made_open(&m, 4, chain, 0, 0);
    for (int bold = 0; bold < 2; bold++) {
        saltus_message message = {.text = ""};
        double u[4] = {0, 0, 0, 1e-7};
        m.e.bold = bold;
        saltus_status status = saltus_newton(&m.e, u, NULL, NULL, true, &iterations, &message);
        assert_int_equal(status, bold ? SALTUS_OK : SALTUS_NO_CONVERGENCE);
        assert_true(bold || (u[0] == 0 && u[2] == 0));
        check_near(u[2], bold ? (1 - sqrt(1 - 0.8)) / 4 : 0, 1e-12);
        assert_true(u[3] == 1e-7);
    }
    /* Where there is none full steps do not find any. */
    saltus_message message = {.text = ""};
    double none[4] = {0, 0, 0, 2e-7};
    assert_int_not_equal(saltus_newton(&m.e, none, NULL, NULL, true, &iterations, &message), SALTUS_OK);
    made_close(&m);
}

/* A step on a hyperplane that ends in rounding is the last, even if it is the first. */
static void near_points_take_one_evaluation(void **state) {
    (void)state;
    unsigned long long seed = 8;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2)
        for (int far = 0; far < 2; far++) {
            made m;
            saltus_message message = {.text = ""};
            double on[made_unknowns_max], normal[made_unknowns_max], u[made_unknowns_max];
            int iterations;
            made_open_helix(&m, unknowns, &seed);
            made_helix_at(unknowns, 0.7, on, normal);
            for (int j = 0; j < unknowns; j++)
                u[j] = on[j] + (far ? 1e-4 : 1e-12) * made_random(&seed);
            made_count(&m, 0, SALTUS_OK);
            check_ok(saltus_newton(&m.e, u, normal, on, false, &iterations, &message), &message);
            assert_true(far ? m.evaluations > 1 : m.evaluations == 1);
            assert_true(iterations >= 1);
            check_near(made_apart(u, on, unknowns), 0, 1e-14);
            made_close(&m);
        }
}

/* What a history recorded. */
typedef struct told {
    int count;
    double residual[64];
    const char *kind;
} told;

static void tell(void *context, int iteration, double residual, const char *unknowns) {
    told *t = context;
    assert_int_equal(iteration, t->count);
    t->residual[t->count++] = residual;
    t->kind = unknowns;
}

/* Every iteration is reported, and near the end residuals fall quadratically. */
static void convergence_is_quadratic(void **state) {
    (void)state;
    made m;
    saltus_message message = {.text = ""};
    told t = {.count = 0};
    double u[2] = {0.9, 0.6};
    int iterations, squares = 0;
    made_open(&m, 2, made_ellipse, 1, 1);
    m.e.history = tell;
    m.e.context = &t;
    m.e.kind = "made up";
    check_ok(saltus_newton(&m.e, u, NULL, NULL, false, &iterations, &message), &message);
    check_near(u[0], 0.8, 1e-13);
    assert_int_equal(t.count, iterations + 1);
    assert_string_equal(t.kind, "made up");
    /* x' - x* = (x - x*)^2 / 2 x, and the residual is 2 x* (x - x*) + (x - x*)^2. */
    for (int k = 1; k < t.count && t.residual[k] > 1e-13; k++) {
        double error = sqrt(0.64 + t.residual[k - 1]) - 0.8, next = error * error / (2 * (0.8 + error));
        check_near(t.residual[k], 1.6 * next + next * next, 1e-3 * t.residual[k]);
        squares++;
    }
    assert_true(squares >= 2);
    made_close(&m);
}

/* No solution, too few iterations, a singular matrix. */
static void failures_are_told_apart(void **state) {
    (void)state;
    made m;
    saltus_message message = {.text = ""};
    int iterations;
    made_open(&m, 2, made_parabola, 1, 0);
    double none[2] = {0.3, -1};
    assert_int_equal(saltus_newton(&m.e, none, NULL, NULL, true, &iterations, &message),
                     SALTUS_NO_CONVERGENCE);
    assert_non_null(strstr(message.text, "residual"));
    assert_in_range(iterations, 1, m.e.iterations);
    double flat[2] = {0, -1};
    assert_int_equal(saltus_newton(&m.e, flat, NULL, NULL, true, &iterations, &message), SALTUS_SINGULAR);
    double solved[2] = {0.5, 0.25}, near[2] = {0.50001, 0.25};
    m.e.iterations = 0;
    check_ok(saltus_newton(&m.e, solved, NULL, NULL, true, &iterations, &message), &message);
    assert_int_equal(iterations, 0);
    assert_true(solved[0] == 0.5);
    assert_int_equal(saltus_newton(&m.e, near, NULL, NULL, true, &iterations, &message),
                     SALTUS_NO_CONVERGENCE);
    assert_true(near[0] == 0.50001);
    made_close(&m);
}

/* A failing evaluation: lack of memory and interruption end the iteration at once, wherever they occur; after
 * other failures the step is not taken, and the point before remains. */
static void failed_evaluations(void **state) {
    (void)state;
    static const saltus_status failures[] = {SALTUS_NO_MEMORY, SALTUS_INTERRUPTED, SALTUS_STALLED,
                                             SALTUS_SINGULAR};
    made m;
    int iterations, stood = 0;
    made_open(&m, 2, made_ellipse, 1, 1);
    for (int f = 0; f < 4; f++)
        for (int k = 1; k < 4; k++) {
            saltus_message message = {.text = ""};
            double u[2] = {0.9, 0.6}, start[2] = {0.9, 0.6};
            made_count(&m, k, failures[f]);
            saltus_status status = saltus_newton(&m.e, u, NULL, NULL, false, &iterations, &message);
            if (f < 2 || k == 1) {
                assert_int_equal(status, failures[f]);
                assert_int_equal(m.evaluations, k);
                assert_non_null(strstr(message.text, "fails"));
                assert_true(k > 1 || (u[0] == start[0] && u[1] == start[1]));
                assert_true(isinf(m.e.size));
                continue;
            }
            assert_int_equal(status, SALTUS_NO_CONVERGENCE);
            check_evaluated_at(&m, u);
            stood++;
        }
    assert_true(stood >= 4);
    made_close(&m);
}

/* The determinant of rows of n numbers, by elimination with row pivots. */
static double determinant(long double *rows, int n) {
    long double product = 1;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k; i < n; i++)
            if (fabsl(rows[i * n + k]) > fabsl(rows[pivot * n + k]))
                pivot = i;
        if (pivot != k)
            product = -product;
        for (int j = 0; j < n; j++) {
            long double kept = rows[k * n + j];
            rows[k * n + j] = rows[pivot * n + j];
            rows[pivot * n + j] = kept;
        }
        product *= rows[k * n + k];
        for (int i = k + 1; i < n; i++)
            for (int j = n - 1; j >= k; j--)
                rows[i * n + j] -= rows[i * n + k] / rows[k * n + k] * rows[k * n + j];
    }
    return (double)product;
}

/* Tangents of unit length on the side of the guide, and the determinant bordered by the guide. */
static void tangents_and_determinants(void **state) {
    (void)state;
    unsigned long long seed = 4;
    int positive = 0;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2)
        for (int k = 0; k < 20; k++) {
            made m;
            saltus_message message = {.text = ""};
            double u[made_unknowns_max], exact[made_unknowns_max], guide[made_unknowns_max],
                tangent[made_unknowns_max], log_modulus;
            long double rows[made_unknowns_max * made_unknowns_max];
            int sign;
            made_open_helix(&m, unknowns, &seed);
            made_helix_at(unknowns, 4 * made_random(&seed), u, exact);
            for (int j = 0; j < unknowns; j++)
                guide[j] = made_random(&seed);
            double way = copysign(1, dot(guide, exact, unknowns));
            check_ok(saltus_equations_evaluate(&m.e, u, &message), &message);
            for (int j = 0; j < m.e.count * unknowns; j++)
                rows[j] = m.e.jacobian[j];
            for (int j = 0; j < unknowns; j++)
                rows[m.e.count * unknowns + j] = guide[j];
            check_ok(saltus_curve_tangent(&m.e, guide, tangent, &sign, &log_modulus, &message), &message);
            for (int j = 0; j < unknowns; j++)
                check_near(tangent[j], way * exact[j], 1e-12);
            double modulus = determinant(rows, unknowns);
            assert_int_equal(sign, modulus > 0 ? 1 : -1);
            check_near(log_modulus, log(fabs(modulus)), 1e-12);
            positive += sign > 0;
            made_close(&m);
        }
    assert_true(positive > 10 && positive < 70);
}

/* A guide perpendicular to the tangent selects no side; where curves cross there is no tangent. */
static void places_without_tangent(void **state) {
    (void)state;
    made m;
    saltus_message message = {.text = ""};
    double tangent[2], log_modulus, guide[2] = {1, 0}, top[2] = {0, 1}, cross[2] = {0.5, -2};
    int sign;
    made_open(&m, 2, made_ellipse, 1, 1);
    double side[2] = {1, 0};
    check_ok(saltus_equations_evaluate(&m.e, side, &message), &message);
    assert_int_equal(saltus_curve_tangent(&m.e, guide, tangent, &sign, &log_modulus, &message),
                     SALTUS_SINGULAR);
    check_ok(saltus_equations_evaluate(&m.e, top, &message), &message);
    check_ok(saltus_curve_tangent(&m.e, guide, tangent, &sign, &log_modulus, &message), &message);
    assert_true(tangent[0] == 1 && tangent[1] == 0);
    made_close(&m);
    made_open(&m, 2, made_crossing, 0.5, -2);
    check_ok(saltus_equations_evaluate(&m.e, cross, &message), &message);
    assert_int_equal(saltus_curve_tangent(&m.e, guide, tangent, &sign, &log_modulus, &message),
                     SALTUS_SINGULAR);
    made_close(&m);
}

/* Regular points have one null vector, the tangent; the other value is the Jacobian's smallest. Where curves
 * cross both are zero. */
static void null_planes(void **state) {
    (void)state;
    unsigned long long seed = 5;
    saltus_message message = {.text = ""};
    double vectors[2 * made_unknowns_max], values[2];
    made m;
    for (int unknowns = 3; unknowns <= made_unknowns_max; unknowns += 2) {
        double u[made_unknowns_max], exact[made_unknowns_max];
        made_open_helix(&m, unknowns, &seed);
        made_helix_at(unknowns, 3 * made_random(&seed), u, exact);
        check_ok(saltus_equations_evaluate(&m.e, u, &message), &message);
        check_ok(saltus_null_plane(&m.e, vectors, values, &message), &message);
        check_near(fabs(dot(vectors, exact, unknowns)), 1, 1e-13);
        check_near(values[0], 0, 1e-14);
        assert_true(values[1] > 0.1);
        double size = 0;
        for (int i = 0; i < m.e.count; i++)
            size = hypot(size, dot(m.e.jacobian + i * unknowns, vectors + unknowns, unknowns));
        check_near(size, values[1], 1e-13);
        made_close(&m);
    }
    double cross[2] = {1, 1};
    made_open(&m, 2, made_crossing, 1, 1);
    check_ok(saltus_equations_evaluate(&m.e, cross, &message), &message);
    check_ok(saltus_null_plane(&m.e, vectors, values, &message), &message);
    for (int k = 0; k < 2; k++) {
        check_near(values[k], 0, 1e-15);
        check_near(dot(vectors + 2 * k, vectors + 2 * k, 2), 1, 1e-14);
    }
    check_near(dot(vectors, vectors + 2, 2), 0, 1e-14);
    made_close(&m);
}

/* Lack of memory in a decomposition is reported as such. */
static void lack_of_memory(void **state) {
    (void)state;
    made m;
    saltus_message message = {.text = ""};
    double u[2] = {1, 1}, vectors[4], values[2];
    made_open(&m, 2, made_crossing, 1, 1);
    check_ok(saltus_equations_evaluate(&m.e, u, &message), &message);
    lacking = true;
    saltus_status plane = saltus_null_plane(&m.e, vectors, values, &message);
    lacking = false;
    assert_int_equal(plane, SALTUS_NO_MEMORY);
    made_close(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solutions_are_found),
        cmocka_unit_test(hyperplanes_are_kept_to),
        cmocka_unit_test(residuals_alone_lead_near),
        cmocka_unit_test(residuals_alone_finish),
        cmocka_unit_test(residuals_that_do_not_help),
        cmocka_unit_test(damping_reaches_further),
        cmocka_unit_test(growth_hides_no_solution),
        cmocka_unit_test(near_points_take_one_evaluation),
        cmocka_unit_test(convergence_is_quadratic),
        cmocka_unit_test(failures_are_told_apart),
        cmocka_unit_test(failed_evaluations),
        cmocka_unit_test(tangents_and_determinants),
        cmocka_unit_test(places_without_tangent),
        cmocka_unit_test(null_planes),
        cmocka_unit_test(lack_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
