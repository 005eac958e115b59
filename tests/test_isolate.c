/* The isolator alone, on polynomials with known roots.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "flow/isolate.h"

#include <gsl/gsl_rng.h>

/* c <- c (s - root) */
static void multiply_root(double *c, int *degree, double root) {
    c[*degree + 1] = c[*degree];
    for (int k = *degree; k >= 1; k--)
        c[k] = c[k - 1] - root * c[k];
    c[0] *= -root;
    ++*degree;
}

static void scale(double *c, int degree, double factor) {
    for (int k = 0; k <= degree; k++)
        c[k] *= factor;
}

static void expect_root(const double *c, int degree, double expected, double tolerance) {
    double root = NAN;
    assert_true(saltus_isolate_rise(c, degree, &root));
    check_near(root, expected, tolerance);
}

static void expect_none(const double *c, int degree) {
    double root;
    assert_false(saltus_isolate_rise(c, degree, &root));
}

/* -(s - a)(s - a - 2^-43) rises through zero at a and falls 1.1e-13 later: the excess is 3e-27. The
 * coefficients are exact for a = 1/2 and a = 0 + 2^-10, so the roots are as stated. */
static void two_roots_close_together(void **unused) {
    (void)unused;
    const double gap = ldexp(1, -43), places[] = {0.5, 0.25, ldexp(1, -10)};
    for (int k = 0; k < 3; k++) {
        double a = places[k], c[3] = {-a * (a + gap), 2 * a + gap, -1};
        expect_root(c, 2, a, 1e-16);
        /* times (2 - s): still exact, now a cubic */
        double cubic[4] = {2 * c[0], 2 * c[1] - c[0], 2 * c[2] - c[1], -c[2]};
        expect_root(cubic, 3, a, 1e-16);
    }
}

/* A maximum 2^-90 below zero is no root, nor is one that touches zero; one as little above is a root. */
static void nearly_double_roots(void **unused) {
    (void)unused;
    const double tiny = ldexp(1, -52);
    double below[3] = {-0.25 - tiny, 1, -1}, touching[3] = {-0.25, 1, -1}, above[3] = {-0.25 + tiny, 1, -1};
    expect_none(below, 2);
    expect_none(touching, 2);
    expect_root(above, 2, 0.5 - sqrt(tiny), 1e-15);
    double quartic[5] = {-0.0625 - tiny, 0, 0.5, 0, -1}; /* -(s^2 - 1/4)^2 - tiny */
    expect_none(quartic, 4);
    quartic[0] = -0.0625;
    expect_none(quartic, 4);
}

static void roots_at_the_ends(void **unused) {
    (void)unused;
    double at_end[3] = {-1, 0.5, 0.5}; /* (s - 1)(s + 2) / 2 */
    double beyond[3] = {-1 - 1e-15, 0.5, 0.5};
    double leaving[3] = {0, -1, 0.5}; /* zero at the start, falling, back at 2 */
    double back[3] = {0, -1, 1};      /* zero at the start, back at 1 */
    expect_root(at_end, 2, 1, 0);
    expect_none(beyond, 2);
    expect_none(leaving, 2);
    expect_root(back, 2, 1, 0);
}

/* From a start above zero, the rise after a dip below zero counts. */
static void start_above(void **unused) {
    (void)unused;
    double c[4] = {1}, d[4] = {1};
    int degree = 0;
    multiply_root(c, &degree, 0.25);
    multiply_root(c, &degree, 0.75);
    expect_root(c, degree, 0.75, 1e-15);
    degree = 0;
    multiply_root(d, &degree, 0.25);
    multiply_root(d, &degree, 1.5);
    expect_none(d, degree);
}

static void constants_and_zeros(void **unused) {
    (void)unused;
    double negative[5] = {-1, 0, 0, 0, 0}, zero[5] = {0}, line[2] = {-0.5, 1};
    expect_none(negative, 4);
    expect_none(zero, 4);
    expect_root(line, 1, 0.5, 0);
}

/* The uncertainty of a simple root due to rounding of the coefficients. */
static double conditioning(const double *c, int degree, double root) {
    double slope = 0, size = 0;
    for (int k = degree; k >= 1; k--)
        slope = slope * root + k * c[k];
    for (int k = 0; k <= degree; k++)
        size += fabs(c[k]);
    return 1e-15 * (degree + 1) * size / fabs(slope);
}

/* Random products of real roots inside and outside the interval, up to degree 24: the first rise must be the
 * least inner root at which the sign changes from negative to positive. */
static void random_products(void **unused) {
    (void)unused;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    for (int trial = 0; trial < 20000; trial++) {
        double c[SALTUS_DEGREE_MAX + 1] = {1}, inner[4];
        int degree = 0, count = (int)gsl_rng_uniform_int(rng, 5);
        for (int k = 0; k < count; k++) {
            inner[k] = 0.02 + 0.96 * gsl_rng_uniform(rng);
            for (int j = k; j > 0 && inner[j] < inner[j - 1]; j--) {
                double swap = inner[j];
                inner[j] = inner[j - 1];
                inner[j - 1] = swap;
            }
        }
        bool separate = true;
        for (int k = 1; k < count; k++)
            separate &= inner[k] - inner[k - 1] > 1e-3;
        if (!separate)
            continue;
        for (int k = 0; k < count; k++)
            multiply_root(c, &degree, inner[k]);
        for (int k = (int)gsl_rng_uniform_int(rng, 12); k > 0; k--)
            multiply_root(c, &degree, 1.5 + 3 * gsl_rng_uniform(rng));
        scale(c, degree, (c[0] > 0 ? -1 : 1) / fabs(c[0]));
        /* p(0) = -1: the first inner root is the first rise. */
        if (count)
            expect_root(c, degree, inner[0], 1e-15 + conditioning(c, degree, inner[0]));
        else
            expect_none(c, degree);
    }
    gsl_rng_free(rng);
}

static void compensated_values(void **unused) {
    (void)unused;
    /* (s - 1)^8 near 1: plain evaluation has no correct digit there. */
    double c[9] = {1, -8, 28, -56, 70, -56, 28, -8, 1}, s = 1 + ldexp(1, -7);
    check_near(saltus_compensated(c, 8, s), ldexp(1, -56), 1e-15 * ldexp(1, -56));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_roots_close_together), cmocka_unit_test(nearly_double_roots),
        cmocka_unit_test(roots_at_the_ends),        cmocka_unit_test(start_above),
        cmocka_unit_test(constants_and_zeros),      cmocka_unit_test(random_products),
        cmocka_unit_test(compensated_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
