/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/collocation.h"

#include "base/dense.h"
#include "flow/kernel_list.h"

#include <gsl/gsl_math.h>
#include <lapacke.h>
#include <math.h>
#include <string.h>

#define DECLARE(isa) extern const saltus_collocation_kernel saltus_collocation_##isa;
SALTUS_COLLOCATIONS(DECLARE)

#define ADDRESS(isa) &saltus_collocation_##isa,
static const saltus_collocation_kernel *const kernels[] = {SALTUS_COLLOCATIONS(ADDRESS)};

const saltus_collocation_kernel *saltus_collocation_find(int pack) {
    size_t k = 0;
    while (kernels[k]->pack != pack)
        k++;
    return kernels[k];
}

enum { n = SALTUS_RADAU_NODES };

void saltus_legendre_values(double s, int count, double *values) {
    double x = 2 * s - 1, before = 0, value = 1;
    for (int k = 0; k < count; k++) {
        values[k] = value;
        double next = ((2 * k + 1) * x * value - k * before) / (k + 1);
        before = value;
        value = next;
    }
}

/* P_n - P_{n-1}, whose zeros are the right Radau points. */
static double radau_polynomial(double s) {
    double p[n + 1];
    saltus_legendre_values(s, n + 1, p);
    return p[n] - p[n - 1];
}

/* By bisection between the sign changes on a grid that is fine where the points are dense. */
static bool find_nodes(double *node) {
    enum { grid = 4000 };
    int found = 0;
    double low = 0;
    for (int k = 1; k < grid && found < n - 1; k++) {
        double high = gsl_pow_2(sin(0.5 * M_PI * k / grid));
        bool sign = radau_polynomial(low) > 0;
        if ((radau_polynomial(high) > 0) != sign) {
            double a = low, b = high, middle = 0.5 * (a + b);
            while (middle > a && middle < b) {
                *((radau_polynomial(middle) > 0) == sign ? &a : &b) = middle;
                middle = 0.5 * (a + b);
            }
            node[found++] = middle;
        }
        low = high;
    }
    node[n - 1] = 1;
    return found == n - 1;
}

/* Integrals of P_k from 0 to s, (P_{k+1} - P_{k-1}) / (4 k + 2). */
static void integral_values(double s, double *values) {
    double p[n + 1];
    saltus_legendre_values(s, n + 1, p);
    values[0] = s;
    for (int k = 1; k < n; k++)
        values[k] = (p[k + 1] - p[k - 1]) / (4 * k + 2);
}

static void multiply(double (*a)[n], double (*b)[n], double (*product)[n]) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int k = 0; k < n; k++)
                sum = fma(a[i][k], b[k][j], sum);
            product[i][j] = sum;
        }
}

/* Eigenvectors of the integration matrix as it acts on columns; real and imaginary parts form the basis. */
static bool find_pairs(saltus_collocation *method) {
    double a[n * n], vectors[n * n], re[n], im[n], basis[n][n];
    /* The rows of `integral` are the columns of S, so in LAPACK's order it is S itself. */
    memcpy(a, method->integral, sizeof a);
    if (LAPACKE_dgeev(LAPACK_COL_MAJOR, 'N', 'V', n, a, n, re, im, NULL, n, vectors, n) != 0)
        return false;
    int pairs = 0;
    for (int k = 0; k + 1 < n; k++)
        if (im[k] > 0) {
            method->pair[pairs] = re[k];
            method->pair[SALTUS_RADAU_PAIRS + pairs] = im[k];
            for (int i = 0; i < n; i++) {
                basis[pairs][i] = vectors[k * n + i];
                basis[SALTUS_RADAU_PAIRS + pairs][i] = -vectors[(k + 1) * n + i];
            }
            pairs++;
        }
    memcpy(method->to_nodes, basis, sizeof basis);
    return pairs == SALTUS_RADAU_PAIRS &&
           saltus_dense_inverse(&method->to_nodes[0][0], n, &method->to_pairs[0][0]);
}

/* P_k(2 s - 1) = sum_j (-1)^(k + j) binomial(k, j) binomial(k + j, j) s^j. */
static void fill_monomials(double (*m)[n]) {
    memset(m, 0, sizeof(saltus_node_matrix));
    for (int k = 0; k < n; k++) {
        double term = k % 2 ? -1 : 1;
        for (int j = 0; j <= k; j++) {
            m[k][j] = term;
            term *= -(double)(k - j) * (k + j + 1) / ((double)(j + 1) * (j + 1));
        }
    }
}

bool saltus_collocation_build(saltus_collocation *method) {
    saltus_node_matrix values, integrals;
    if (!find_nodes(method->node))
        return false;
    for (int i = 0; i < n; i++) {
        double p[n], s[n];
        saltus_legendre_values(method->node[i], n, p);
        integral_values(method->node[i], s);
        for (int k = 0; k < n; k++) {
            values[k][i] = p[k];
            integrals[k][i] = s[k];
        }
    }
    if (!saltus_dense_inverse(&values[0][0], n, &method->legendre[0][0]))
        return false;
    multiply(method->legendre, integrals, method->integral);
    multiply(method->integral, method->integral, method->integral2);
    fill_monomials(method->monomial);
    return find_pairs(method);
}
