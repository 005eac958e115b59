/* Small linear algebra: inverses, solutions, eigenvalues of a matrix and of a product of matrices,
 * orthonormal vectors, arenas.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/dense.h"
#include "base/periodic.h"

#include <gsl/gsl_rng.h>

enum { n_max = 16 };

static gsl_rng *rng;

static void random_matrix(int count, double *a) {
    for (int i = 0; i < count; i++)
        a[i] = 2 * gsl_rng_uniform(rng) - 1;
}

static void multiply(const double *a, const double *b, int n, double *out) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int k = 0; k < n; k++)
                sum += a[i * n + k] * b[k * n + j];
            out[i * n + j] = sum;
        }
}

static void inverses_undo(void **unused) {
    (void)unused;
    for (int n = 1; n <= SALTUS_DENSE_INVERSE_MAX; n++) {
        double a[n_max * n_max], kept[n_max * n_max], inverse[n_max * n_max], product[n_max * n_max];
        random_matrix(n * n, a);
        if (n > 1)
            a[0] = 0; /* a pivot must be searched */
        memcpy(kept, a, sizeof a);
        assert_true(saltus_dense_inverse(a, n, inverse));
        assert_memory_equal(a, kept, (size_t)(n * n) * sizeof *a);
        for (int side = 0; side < 2; side++) {
            multiply(side ? a : inverse, side ? inverse : a, n, product);
            for (int i = 0; i < n * n; i++)
                check_near(product[i], i % (n + 1) == 0, 1e-11);
        }
        if (n > 1) {
            for (int j = 0; j < n; j++)
                a[(n - 1) * n + j] = 2 * a[j];
            assert_false(saltus_dense_inverse(a, n, inverse));
        }
    }
    double zero = 0, one;
    assert_false(saltus_dense_inverse(&zero, 1, &one));
    assert_true(saltus_dense_inverse(&zero, 0, &one));
}

static void solutions_solve(void **unused) {
    (void)unused;
    for (int n = 1; n <= 12; n++) {
        double a[n_max * n_max], kept[n_max * n_max], b[n_max], x[n_max];
        int pivots[n_max];
        random_matrix(n * n, a);
        random_matrix(n, x);
        if (n > 1)
            a[0] = 0;
        memcpy(kept, a, sizeof a);
        for (int i = 0; i < n; i++) {
            b[i] = 0;
            for (int j = 0; j < n; j++)
                b[i] += a[i * n + j] * x[j];
        }
        assert_true(saltus_dense_solve(a, n, b, pivots));
        for (int i = 0; i < n; i++)
            check_near(b[i], x[i], 1e-10);
        memcpy(a, kept, sizeof a);
        for (int j = 0; j < n; j++)
            a[j] = 0;
        assert_false(saltus_dense_solve(a, n, b, pivots));
    }
}

/* Power sums of eigenvalues are traces of powers: of the matrix itself, and of a product. */
static void check_traces(const double *a, int n, const double *real, const double *imaginary,
                         double tolerance) {
    double power[n_max * n_max], next[n_max * n_max], size = 1;
    memcpy(power, a, (size_t)(n * n) * sizeof *a);
    for (int k = 1; k <= n; k++) {
        double trace = 0, sum = 0, rest = 0;
        for (int i = 0; i < n; i++) {
            const double modulus = pow(hypot(real[i], imaginary[i]), k),
                         angle = k * atan2(imaginary[i], real[i]);
            trace += power[i * n + i];
            sum += modulus * cos(angle);
            rest += modulus * sin(angle);
            size = fmax(size, modulus);
        }
        check_near(sum, trace, tolerance * size);
        check_near(rest, 0, tolerance * size);
        multiply(power, a, n, next);
        memcpy(power, next, (size_t)(n * n) * sizeof *a);
    }
}

static void eigenvalues_have_the_traces_of_powers(void **unused) {
    (void)unused;
    for (int trial = 0; trial < 40; trial++) {
        const int n = 1 + trial % 8;
        double a[n_max * n_max], kept[n_max * n_max], real[n_max], imaginary[n_max];
        random_matrix(n * n, a);
        memcpy(kept, a, sizeof a);
        assert_true(saltus_dense_eigenvalues(a, n, real, imaginary));
        check_traces(kept, n, real, imaginary, 1e-10);
    }
}

/* h r_count ... r_1 has the same eigenvalues, multiplied out or not. */
static void products_have_the_eigenvalues_of_the_whole(void **unused) {
    (void)unused;
    for (int trial = 0; trial < 150; trial++) {
        const int n = 1 + trial % 8, count = trial / 8 % 5;
        double h[n_max * n_max], triangles[5 * n_max * n_max], product[n_max * n_max], whole[n_max * n_max],
            next[n_max * n_max], real[n_max], imaginary[n_max];
        random_matrix(n * n, h);
        random_matrix(count * n * n, triangles);
        for (int k = 0; k < count; k++)
            for (int i = 0; i < n; i++) {
                double *row = triangles + (k * n + i) * n;
                row[i] += row[i] < 0 ? -0.7 : 0.7;
                for (int j = 0; j < i; j++)
                    row[j] = 0;
            }
        if (trial % 7 == 6) /* symmetric: real eigenvalues, some of them equal without triangles */
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++)
                    h[i * n + j] = i == j ? 1 : 0.3;
        for (int i = 0; i < n * n; i++)
            next[i] = i % (n + 1) == 0;
        for (int k = 0; k < count; k++) {
            multiply(triangles + k * n * n, next, n, whole);
            memcpy(next, whole, sizeof next);
        }
        multiply(h, next, n, whole);
        assert_true(saltus_periodic_eigenvalues(h, triangles, n, count, product, real, imaginary));
        check_traces(whole, n, real, imaginary, 1e-9);
        for (int i = 0; i < n; i++)
            if (imaginary[i] != 0) {
                bool paired = false;
                for (int j = 0; j < n; j++)
                    paired |= j != i && real[j] == real[i] && imaginary[j] == -imaginary[i];
                assert_true(paired);
            }
    }
    for (int k = 0; k < 18; k++) {
        double all[18] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3, 0, 4, 5, 0, 0, 6}, product[9], real[3],
               imaginary[3];
        all[k] = k % 2 ? NAN : -INFINITY;
        assert_false(saltus_periodic_eigenvalues(all, all + 9, 3, 1, product, real, imaginary));
    }
}

/* A cyclic permutation looks the same under every usual shift: its eigenvalues are roots of one. */
static void cycles_have_the_roots_of_one(void **unused) {
    (void)unused;
    for (int n = 3; n <= 8; n++) {
        double h[n_max * n_max] = {0}, product[n_max * n_max], real[n_max], imaginary[n_max];
        for (int i = 0; i < n; i++)
            h[(i + 1) % n * n + i] = 1;
        assert_true(saltus_periodic_eigenvalues(h, NULL, n, 0, product, real, imaginary));
        for (int k = 0; k < n; k++) {
            bool found = false;
            for (int i = 0; i < n; i++)
                found |= hypot(real[i] - cos(2 * M_PI * k / n), imaginary[i] - sin(2 * M_PI * k / n)) < 1e-9;
            assert_true(found);
        }
    }
}

/* Small eigenvalues of a graded product keep their digits: the factors are diagonal in a rotated frame. */
static void small_eigenvalues_keep_their_digits(void **unused) {
    (void)unused;
    enum { n = 3, count = 4 };
    double h[n * n] = {0}, triangles[count * n * n] = {0}, product[n * n], real[n], imaginary[n];
    const double grade[n] = {1, 1e-4, 1e-8};
    for (int i = 0; i < n; i++) {
        h[i * n + i] = grade[i];
        for (int k = 0; k < count; k++)
            for (int j = i; j < n; j++)
                triangles[(k * n + i) * n + j] = i == j ? grade[i] : 0.3 * grade[i];
    }
    assert_true(saltus_periodic_eigenvalues(h, triangles, n, count, product, real, imaginary));
    for (int i = 0; i < n; i++) {
        const double expected = pow(grade[i], count + 1);
        bool found = false;
        for (int j = 0; j < n; j++)
            found |= fabs(real[j] - expected) <= 1e-9 * expected && imaginary[j] == 0;
        assert_true(found);
    }
}

static void vectors_become_orthonormal(void **unused) {
    (void)unused;
    for (int n = 1; n <= 9; n++)
        for (int count = 1; count <= n; count++) {
            double a[n_max * n_max], q[n_max * n_max], length[n_max], work[33 * n_max];
            assert_true(saltus_dense_orthonormal_work(count) <= (int)(sizeof work / sizeof *work));
            random_matrix(n * count, a);
            memcpy(q, a, sizeof a);
            assert_true(saltus_dense_orthonormal(q, n, count, length, work));
            for (int k = 0; k < count; k++) {
                double rest[n_max], square = 0;
                memcpy(rest, a + k * n, (size_t)n * sizeof *rest);
                for (int j = 0; j <= k; j++) {
                    double product = 0, part = 0;
                    for (int i = 0; i < n; i++) {
                        product += q[j * n + i] * q[k * n + i];
                        part += q[j * n + i] * a[k * n + i];
                    }
                    check_near(product, j == k, 1e-14);
                    for (int i = 0; i < n && j < k; i++)
                        rest[i] -= part * q[j * n + i];
                    if (j == k)
                        check_near(fabs(part), length[k], 1e-13);
                }
                for (int i = 0; i < n; i++)
                    square += rest[i] * rest[i];
                check_near(sqrt(square), length[k], 1e-13);
            }
            a[n * count - 1] = INFINITY;
            assert_false(saltus_dense_orthonormal(a, n, count, length, work));
        }
}

static void arenas_hand_out_what_they_measured(void **unused) {
    (void)unused;
    saltus_arena arena = {0};
    double *place[20];
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < 20; k++) {
            place[k] = saltus_arena_doubles(&arena, (size_t)(3 * k));
            assert_true((place[k] != NULL) == (pass == 1));
        }
        if (pass == 0)
            assert_true(saltus_arena_open(&arena));
    }
    for (int k = 0; k < 20; k++) {
        assert_true((uintptr_t)place[k] % 64 == 0);
        for (int i = 0; i < 3 * k; i++)
            assert_true(place[k][i] == 0);
        for (int i = 0; i < 3 * k; i++)
            place[k][i] = k; /* later ones are not affected */
    }
    saltus_arena_close(&arena);
    assert_null(arena.base);
    saltus_arena_close(&arena);
}

/* A product of factors, each a normal matrix times a triangle in a rotated frame, with given eigenvalues: a
 * real number or a pair per block, `grade` times smaller in each factor from block to block. They are found
 * to the digits that the factors hold. */
static void given_eigenvalues_are_found(void **unused) {
    (void)unused;
    enum { count_max = 5 };
    static const double grades[] = {1, 1, 0.3, 0.1};
    for (int trial = 0; trial < 160; trial++) {
        const int n = 2 + trial % 7, count = trial / 7 % (count_max + 1);
        const double grade = grades[trial % 4], turn = trial % 3 ? 0.4 + 0.1 * (trial % 20) : 0;
        double h[n_max * n_max] = {0}, triangles[count_max * n_max * n_max] = {0}, q[n_max * n_max],
                         next[n_max * n_max], product[n_max * n_max], whole[n_max * n_max], work[2 * n_max];
        double real[n_max], imaginary[n_max], modulus[n_max], angle[n_max], frame[n_max * n_max];
        bool taken[n_max] = {false};
        for (int i = 0; i < n; i++) {
            const int block = turn != 0 ? i / 2 : i;
            const bool paired = turn != 0 && (i % 2 == 1 || i + 1 < n);
            const double size = pow(grade, block), own = 1 + 0.3 * block;
            modulus[i] = own * size;
            angle[i] = paired ? (i % 2 ? -turn : turn) : block % 2 ? M_PI : 0;
            h[i * n + i] = modulus[i] * cos(angle[i]);
            if (paired)
                h[i * n + (i ^ 1)] = -modulus[i] * sin(angle[i]);
            for (int k = 0; k < count; k++) {
                modulus[i] *= size * (1 + 0.1 * k);
                for (int j = i; j < n; j++)
                    triangles[(k * n + i) * n + j] = i == j                             ? size * (1 + 0.1 * k)
                                                     : (turn != 0 ? j / 2 : j) == block ? 0
                                                                                        : 0.2 * size;
            }
        }
        /* M = h r_count ... r_1 becomes Q M Q^T: r_1 Q^T = q_1 s_1, r_2 q_1 = q_2 s_2, ..., Q h q_count. */
        random_matrix(n * n, next);
        saltus_dense_qr(next, n, q, work);
        multiply(q, h, n, whole);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                frame[i * n + j] = q[j * n + i];
        for (int k = 0; k < count; k++) {
            multiply(triangles + k * n * n, frame, n, next);
            memcpy(triangles + k * n * n, next, (size_t)(n * n) * sizeof *next);
            saltus_dense_qr(triangles + k * n * n, n, frame, work);
        }
        multiply(whole, frame, n, h);
        assert_true(saltus_periodic_eigenvalues(h, triangles, n, count, product, real, imaginary));
        const double lost = pow(grade, turn != 0 ? (n - 1) / 2 : n - 1);
        for (int i = 0; i < n; i++) {
            double nearest = INFINITY;
            int which = 0;
            for (int j = 0; j < n; j++) {
                double away =
                    hypot(real[j] - modulus[i] * cos(angle[i]), imaginary[j] - modulus[i] * sin(angle[i]));
                if (!taken[j] && away < nearest) {
                    nearest = away;
                    which = j;
                }
            }
            taken[which] = true;
            if (!(nearest <= 2e-13 / lost * modulus[i]))
                fail_msg("trial %d: %.3g of the eigenvalue %.3g, %.3g lost", trial, nearest / modulus[i],
                         modulus[i], lost);
        }
    }
}

/* The reciprocal condition is 1 / (|a| |1 / a|) in the column norm for a matrix that needs no scaling, and 0
 * for one that is singular or not finite. */
static void conditions_are_told(void **unused) {
    (void)unused;
    saltus_dense_lu lu;
    assert_true(saltus_dense_lu_open(&lu, 2));
    for (int k = 0; k < 10; k++) {
        const double near = 1 - pow(10, -k), scale[2] = {ldexp(1, 3 * k), ldexp(1, -7 * k)};
        double a[4] = {1, near, near, 1};
        assert_true(saltus_dense_factor(&lu, a));
        check_near(lu.reciprocal / ((1 - near) / (1 + near)), 1, 1e-6);
        check_near(lu.log_modulus, log1p(-near * near), 1e-6);
        for (int i = 0; i < 4; i++)
            a[i] *= scale[i / 2];
        assert_true(saltus_dense_factor(&lu, a));
        const double factor = lu.reciprocal / ((1 - near) / (1 + near));
        assert_true(factor > 0.24 && factor < 4.1); /* powers of two, one off at the worst */
        check_near(lu.log_modulus, log1p(-near * near) - 4 * k * log(2), 1e-6);
    }
    for (int k = 0; k < 10; k++) {
        double a[4] = {2, 1, 1, 3};
        assert_true(saltus_dense_factor(&lu, a) && lu.sign == 1 && lu.reciprocal > 0.1);
        if (k < 8)
            a[k / 2] = k % 2 ? NAN : -INFINITY;
        else
            a[0] = k == 8 ? 1.0 / 3 : 0, a[1] = k == 8 ? 1 : 0;
        assert_false(saltus_dense_factor(&lu, a));
        assert_true(lu.sign == 0 && lu.log_modulus == -INFINITY && lu.reciprocal == 0);
    }
    saltus_dense_lu_close(&lu);
    assert_true(lu.n == 0 && lu.arena.base == NULL);
    saltus_dense_lu_close(&lu);
}

/* An inverse is refused if a pivot falls to 1e-13 of the largest entry, in any unit. */
static void inverses_know_their_limits(void **unused) {
    (void)unused;
    double inverse[4];
    for (int k = 0; k < 3; k++) {
        const double unit = pow(10, 8 * (k - 1));
        for (int side = 0; side < 2; side++) {
            const double pivot = (side ? 2e-13 : 0.5e-13) * unit, turned[4] = {pivot, unit, 0, unit},
                         straight[4] = {unit, unit, unit, unit + pivot}, negative = -unit;
            assert_true(saltus_dense_inverse(turned, 2, inverse) == side);
            assert_true(saltus_dense_inverse(straight, 2, inverse) == side);
            assert_true(saltus_dense_inverse(&negative, 1, inverse));
            check_near(inverse[0] * unit, -1, 1e-15);
        }
    }
}

/* Zero columns and vectors stay zero. */
static void nothing_stays_nothing(void **unused) {
    (void)unused;
    enum { n = 4 };
    for (int gone = 0; gone <= n; gone++) {
        double a[n * n], q[n * n], kept[n * n], back[n * n], work[2 * n];
        random_matrix(n * n, a);
        for (int i = 0; i < n * n; i++)
            if (gone == n || i % n == gone)
                a[i] = 0;
        memcpy(kept, a, sizeof a);
        saltus_dense_qr(a, n, q, work);
        multiply(q, a, n, back);
        for (int i = 0; i < n * n; i++)
            check_near(back[i], kept[i], 1e-15);
        if (gone == n)
            for (int i = 0; i < n * n; i++)
                assert_true(a[i] == 0 && q[i] == (i % (n + 1) == 0));
    }
    double vector[n] = {0}, length = 1, work[1 + 32];
    assert_true(saltus_dense_orthonormal(vector, n, 1, &length, work));
    for (int i = 0; i < n; i++)
        assert_true(length == 0 && vector[i] == 0);
    for (int i = 0; i < 2 * n; i++) {
        double two[2 * n] = {1, 2, 3, 4, -1, 1, 5, 1}, lengths[2], room[2 + 64];
        two[i] = i % 2 ? NAN : INFINITY;
        assert_false(saltus_dense_orthonormal(two, n, 2, lengths, room));
        if (i < n)
            assert_false(saltus_dense_orthonormal(two, n, 1, lengths, room));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inverses_undo),
        cmocka_unit_test(solutions_solve),
        cmocka_unit_test(eigenvalues_have_the_traces_of_powers),
        cmocka_unit_test(products_have_the_eigenvalues_of_the_whole),
        cmocka_unit_test(cycles_have_the_roots_of_one),
        cmocka_unit_test(small_eigenvalues_keep_their_digits),
        cmocka_unit_test(given_eigenvalues_are_found),
        cmocka_unit_test(conditions_are_told),
        cmocka_unit_test(inverses_know_their_limits),
        cmocka_unit_test(nothing_stays_nothing),
        cmocka_unit_test(vectors_become_orthonormal),
        cmocka_unit_test(arenas_hand_out_what_they_measured),
    };
    rng = gsl_rng_alloc(gsl_rng_mt19937);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    gsl_rng_free(rng);
    return failed;
}
