/* Eigenvalues in 128 bits: Hessenberg form by rotations, then the QR method with Wilkinson's shift (Golub and
 * Van Loan, Matrix Computations, chapter 7). In complex numbers, where one eigenvalue is split off at a time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "shoot.h"

/* A rotation of the coordinates p and q: (a, b) becomes (cosine a + sine b, -conj(sine) a + cosine b). */
typedef struct rotation {
    real cosine;
    complex_real sine;
} rotation;

/* The rotation that takes (a, b) to (length, 0), up to a phase. */
static rotation rotation_onto(complex_real a, complex_real b) {
    real x = real_modulus(a), y = real_modulus(b), length = real_hypot(x, y);
    if (y == 0)
        return (rotation){1, 0};
    if (x == 0)
        return (rotation){0, complex_conjugate(b) / y};
    return (rotation){x / length, a / x * complex_conjugate(b) / length};
}

static void rotate_rows(int n, complex_real *a, int p, int q, rotation t) {
    for (int j = 0; j < n; j++) {
        complex_real above = a[p * n + j], below = a[q * n + j];
        a[p * n + j] = t.cosine * above + t.sine * below;
        a[q * n + j] = t.cosine * below - complex_conjugate(t.sine) * above;
    }
}

static void rotate_columns(int n, complex_real *a, int p, int q, rotation t) {
    for (int i = 0; i < n; i++) {
        complex_real left = a[i * n + p], right = a[i * n + q];
        a[i * n + p] = t.cosine * left + complex_conjugate(t.sine) * right;
        a[i * n + q] = t.cosine * right - t.sine * left;
    }
}

static void hessenberg(int n, complex_real *a) {
    for (int k = 0; k < n - 2; k++)
        for (int i = k + 2; i < n; i++) {
            rotation t = rotation_onto(a[(k + 1) * n + k], a[i * n + k]);
            rotate_rows(n, a, k + 1, i, t);
            rotate_columns(n, a, k + 1, i, t);
            a[i * n + k] = 0;
        }
}

/* The eigenvalue of the last 2 x 2 block that is closer to its last entry. */
static complex_real shift(int n, const complex_real *a, int last) {
    complex_real p = a[(last - 1) * n + last - 1], s = a[last * n + last];
    complex_real product = a[(last - 1) * n + last] * a[last * n + last - 1];
    complex_real half = (p - s) / 2, root = complex_root(half * half + product);
    complex_real one = half + root, other = half - root;
    complex_real large = real_modulus(one) > real_modulus(other) ? one : other;
    return real_modulus(large) > 0 ? s - product / large : s;
}

/* One step on the rows and columns first..last. */
static void sweep(int n, complex_real *a, int first, int last) {
    rotation turns[model_dimension];
    complex_real mu = shift(n, a, last);
    for (int i = first; i <= last; i++)
        a[i * n + i] -= mu;
    for (int i = first; i < last; i++) {
        turns[i] = rotation_onto(a[i * n + i], a[(i + 1) * n + i]);
        rotate_rows(n, a, i, i + 1, turns[i]);
    }
    for (int i = first; i < last; i++)
        rotate_columns(n, a, i, i + 1, turns[i]);
    for (int i = first; i <= last; i++)
        a[i * n + i] += mu;
}

/* By decreasing modulus; of a pair the one with the positive imaginary part first. */
static int later(const void *one, const void *other) {
    const complex_real *a = one, *b = other;
    real x = real_modulus(*a), y = real_modulus(*b);
    if (real_abs(x - y) > real_pow(10, -14) * (x + y))
        return x < y ? 1 : -1;
    return (imaginary_part(*a) < imaginary_part(*b)) - (imaginary_part(*a) > imaginary_part(*b));
}

bool eigenvalues(int n, complex_real *a, complex_real *values) {
    enum { sweeps_most = 4000 };
    real size = 0;
    for (int i = 0; i < n * n; i++)
        size = real_max(size, real_modulus(a[i]));
    const real nothing = size * real_pow(2, 1 - real_bits);
    hessenberg(n, a);
    int last = n - 1;
    for (int k = 0; last > 0 && k < sweeps_most; k++) {
        int first = last;
        while (first > 0 && real_modulus(a[first * n + first - 1]) > nothing)
            first--;
        if (first == last)
            last--;
        else
            sweep(n, a, first, last);
    }
    for (int i = 0; i < n; i++)
        values[i] = a[i * n + i];
    qsort(values, n, sizeof *values, later);
    return last == 0;
}
