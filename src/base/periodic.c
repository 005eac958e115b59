/* Periodic QR iteration with two implicit shifts (Bojanczyk, Golub & Van Dooren, SPIE 1770 (1992) 31-42;
 * Kressner, BIT 41 (2001) 467-495). It is the QR iteration on the product, but every reflection passes
 * through the factors one by one: h stays upper Hessenberg, the others stay triangular, and rounding errors
 * are relative to each factor, not to the product. Eigenvalues far below the largest therefore keep their
 * digits as long as no single factor loses them. Only the shifts are taken from the product.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/periodic.h"

#include "base/dense.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

/* The reflection I - beta v v^T on `size` entries from `at` on. */
typedef struct reflector {
    int at, size;
    double v[3], beta;
} reflector;

/* Rows and columns [low, high) are active. */
typedef struct periodic {
    double *h, *triangles, *product;
    int n, count, low, high;
} periodic;

/* The reflector that maps x, with entries `stride` apart, onto its first entry. */
static reflector reflector_of(const double *x, int stride, int at, int size) {
    reflector reflection = {.at = at, .size = size, .v = {1, 0, 0}, .beta = 0};
    double first = x[0], rest = 0, sum = 0;
    for (int i = 1; i < size; i++)
        rest = fmax(rest, fabs(x[i * stride]));
    if (rest == 0)
        return reflection;
    double largest = fmax(rest, fabs(first));
    for (int i = 0; i < size; i++)
        sum += x[i * stride] / largest * (x[i * stride] / largest);
    double turned = -copysign(largest * sqrt(sum), first);
    reflection.beta = (turned - first) / turned;
    for (int i = 1; i < size; i++)
        reflection.v[i] = x[i * stride] / (first - turned);
    return reflection;
}

/* Reflect the vectors number `from` to `to` - 1, which are `across` apart. Their entries are `step` apart;
 * the first entry that changes in vector 0 is at x. */
static inline void reflect(const reflector *reflection, double *x, int step, int across, int from, int to) {
    for (int k = from; k < to; k++) {
        double *vector = x + k * across, sum = 0;
        for (int i = 0; i < reflection->size; i++)
            sum += reflection->v[i] * vector[i * step];
        for (int i = 0; i < reflection->size; i++)
            vector[i * step] -= reflection->beta * sum * reflection->v[i];
    }
}

/* Similarity transformation of the product h r_count ... r_1. The reflector acts on h's rows, from `column`
 * on, and on the columns of r_1. New reflectors from the left make r_1 triangular again; they in turn act on
 * the columns of the next factor, and so on up to the columns of h. */
static void turn_product(const periodic *p, const reflector *reflection, int column) {
    reflector through[2] = {*reflection};
    int n = p->n, count = 1, begin = reflection->at, end = begin + reflection->size;
    reflect(reflection, p->h + begin * n, n, 1, column, p->high);
    for (int k = 0; k < p->count; k++) {
        double *triangle = p->triangles + (size_t)k * (size_t)(n * n);
        for (int m = 0; m < count; m++)
            reflect(&through[m], triangle + through[m].at, 1, n, p->low, end);
        count = 0;
        for (int j = begin; j + 1 < end; j++) {
            through[count] = reflector_of(triangle + j * n + j, n, j, end - j);
            reflect(&through[count++], triangle + j * n, n, 1, j, p->high);
            for (int i = j + 1; i < end; i++)
                triangle[i * n + j] = 0;
        }
    }
    for (int m = 0; m < count; m++)
        reflect(&through[m], p->h + through[m].at, 1, n, p->low, p->high);
}

/* The product r_count ... r_1 within the active rows and columns. */
static void multiply_out(const periodic *p) {
    const int n = p->n, low = p->low, high = p->high;
    double *out = p->product;
    memset(out, 0, (size_t)(n * n) * sizeof *out);
    for (int i = low; i < high; i++)
        out[i * n + i] = 1;
    for (int k = 0; k < p->count; k++) {
        const double *triangle = p->triangles + (size_t)k * (size_t)(n * n);
        for (int i = low; i < high; i++) {
            for (int j = i; j < high; j++)
                out[i * n + j] *= triangle[i * n + i];
            for (int l = i + 1; l < high; l++)
                for (int j = l; j < high; j++)
                    out[i * n + j] += triangle[i * n + l] * out[l * n + j];
        }
    }
}

/* Entry (i, j) of h times the triangles' product. */
static double entry(const periodic *p, int i, int j) {
    double sum = 0;
    for (int k = i > p->low ? i - 1 : p->low; k <= j; k++)
        sum += p->h[i * p->n + k] * p->product[k * p->n + j];
    return sum;
}

/* The last 2 x 2 block of h times the triangles' product within the active rows, row by row. */
static void last_pair(const periodic *p, double *m) {
    for (int i = 0; i < 4; i++)
        m[i] = entry(p, p->high - 2 + i / 2, p->high - 2 + i % 2);
}

/* One sweep of the iteration, from the first column x of (M - a)(M - b), up to a factor, where M is the
 * product and a, b are the eigenvalues of its last 2 x 2 block. Every tenth sweep uses exceptional shifts
 * instead. */
static void sweep(const periodic *p, int iteration) {
    enum { stubborn = 10 };
    const int n = p->n, first = p->low;
    double m[9] = {entry(p, first, first), entry(p, first, first + 1), entry(p, first + 1, first),
                   entry(p, first + 1, first + 1), entry(p, first + 2, first + 1)};
    double largest = 0;
    last_pair(p, m + 5);
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(m[i]));
    for (int i = 0; i < 9 && largest > 0; i++)
        m[i] /= largest;
    double sum = m[5] + m[8], product = m[5] * m[8] - m[6] * m[7];
    if (iteration % stubborn == stubborn - 1) {
        sum = 1.5 * (fabs(m[7]) + fabs(m[2]));
        product = sum * sum / 2.25;
    }
    const double x[3] = {m[0] * (m[0] - sum) + product + m[1] * m[2], m[2] * (m[0] + m[3] - sum),
                         m[2] * m[4]};
    for (int j = p->low - 1; j < p->high - 2; j++) {
        int size = p->high - 1 - j < 3 ? p->high - 1 - j : 3;
        reflector reflection = j < p->low ? reflector_of(x, 1, j + 1, size)
                                          : reflector_of(p->h + (j + 1) * n + j, n, j + 1, size);
        turn_product(p, &reflection, j < p->low ? p->low : j);
        for (int i = j + 2; i < j + 1 + size && j >= p->low; i++)
            p->h[i * n + j] = 0;
    }
}

/* Eigenvalues of the last 1 x 1 or 2 x 2 block of the product. */
static void read_off(const periodic *p, int size, double *real, double *imaginary) {
    int n = p->n, last = p->high - 1;
    double diagonal[2] = {1, 1}, m[4];
    for (int k = 0; k < p->count; k++)
        for (int i = 0; i < size; i++)
            diagonal[i] *=
                p->triangles[((size_t)k * (size_t)n + (size_t)(last - i)) * (size_t)n + (size_t)(last - i)];
    imaginary[last] = 0;
    real[last] = p->h[last * n + last] * diagonal[0];
    if (size == 1)
        return;
    const double *h = p->h + (last - 1) * n + last - 1;
    double determinant = (h[0] * h[n + 1] - h[1] * h[n]) * diagonal[0] * diagonal[1];
    last_pair(p, m);
    double mean = (m[0] + m[3]) / 2, half = (m[0] - m[3]) / 2, square = half * half + m[1] * m[2];
    if (square >= 0) {
        double large = mean + copysign(sqrt(square), mean);
        real[last - 1] = large;
        real[last] = large != 0 ? determinant / large : 0;
        imaginary[last - 1] = 0;
        return;
    }
    double modulus = sqrt(fabs(determinant)), angle = atan2(sqrt(-square), mean);
    real[last - 1] = real[last] = modulus * cos(angle);
    imaginary[last - 1] = modulus * sin(angle);
    imaginary[last] = -imaginary[last - 1];
}

bool saltus_periodic_eigenvalues(double *h, double *triangles, int n, int count, double *product,
                                 double *real, double *imaginary) {
    enum { sweeps_max = 100 };
    periodic p = {.h = h, .triangles = triangles, .product = product, .n = n, .count = count, .high = n};
    double size = 0;
    size_t square = (size_t)n * (size_t)n;
    if (!saltus_dense_finite(h, square) || !saltus_dense_finite(triangles, square * (size_t)count))
        return false;
    for (int i = 0; i < n * n; i++)
        size = fmax(size, fabs(h[i]));
    /* Reduce to Hessenberg form. */
    for (int j = 0; j < n - 2; j++)
        for (int i = n - 1; i > j + 1; i--) {
            const reflector reflection = reflector_of(h + (i - 1) * n + j, n, i - 1, 2);
            turn_product(&p, &reflection, j);
            h[i * n + j] = 0;
        }
    for (int iteration = 0; p.high > 0; iteration++) {
        /* The first row of the trailing block [.., high) that has not split off yet. Multiple eigenvalues
         * split only to the accuracy of the product that the shifts come from, so the tolerance grows. */
        const double rounds = iteration, small = DBL_EPSILON * (1 + rounds * rounds * rounds / 8) * size;
        p.low = p.high - 1;
        while (p.low > 0 && fabs(h[p.low * n + p.low - 1]) > small)
            p.low--;
        if (p.high - p.low > 2 && iteration == sweeps_max)
            return false;
        multiply_out(&p);
        if (p.high - p.low > 2) {
            sweep(&p, iteration);
            continue;
        }
        read_off(&p, p.high - p.low, real, imaginary);
        p.high = p.low;
        iteration = -1;
    }
    return true;
}
