/* The inner loops of collocation. The build compiles this file once per instruction set, with
 *   SALTUS_COLLOCATION_NAME  the name of the table entry defined here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/collocation.h"

#include "base/simd.h"

enum {
    packs_per_row = SALTUS_RADAU_NODES / SALTUS_PACK,
    packs_per_half = SALTUS_RADAU_PAIRS / SALTUS_PACK,
    tile = SALTUS_PACK / 2 /* rows worked on side by side */
};

typedef struct complex_pack {
    saltus_pack re, im;
} complex_pack;

KERNEL_INLINE complex_pack load(const double *row, int p) {
    return (complex_pack){((const saltus_pack *)(const void *)row)[p],
                          ((const saltus_pack *)(const void *)(row + SALTUS_RADAU_PAIRS))[p]};
}

KERNEL_INLINE void store(double *row, int p, complex_pack z) {
    ((saltus_pack *)(void *)row)[p] = z.re;
    ((saltus_pack *)(void *)(row + SALTUS_RADAU_PAIRS))[p] = z.im;
}

KERNEL_INLINE complex_pack times(complex_pack a, complex_pack b) {
    return (complex_pack){saltus_pack_fnma(a.im, b.im, a.re * b.re),
                          saltus_pack_fma(a.im, b.re, a.re * b.im)};
}

/* c - a b */
KERNEL_INLINE complex_pack minus_times(complex_pack c, complex_pack a, complex_pack b) {
    return (complex_pack){saltus_pack_fma(a.im, b.im, saltus_pack_fnma(a.re, b.re, c.re)),
                          saltus_pack_fnma(a.im, b.re, saltus_pack_fnma(a.re, b.im, c.im))};
}

KERNEL_INLINE complex_pack invert(complex_pack a) {
    saltus_pack size = saltus_pack_fma(a.re, a.re, a.im * a.im);
    return (complex_pack){a.re / size, -a.im / size};
}

/* LU factors in place, without pivoting, diagonal inverted; the first `uncoupled` unknowns are not coupled
 * among themselves. The matrices are 1 plus a dissipative part. Should a pivot be small nevertheless, the
 * iteration that uses the factors does not converge and the step is halved. */
KERNEL_INLINE void decompose(double *matrix, int n, int uncoupled, int p) {
#define AT(i, j) (matrix + ((i)*n + (j)) * SALTUS_RADAU_NODES)
    for (int k = 0; k < n; k++) {
        complex_pack inverse = invert(load(AT(k, k), p));
        store(AT(k, k), p, inverse);
        int first = k < uncoupled ? uncoupled : k + 1;
        for (int i = first; i < n; i++) {
            complex_pack factor = times(load(AT(i, k), p), inverse);
            store(AT(i, k), p, factor);
            for (int j = first; j < n; j++)
                store(AT(i, j), p, minus_times(load(AT(i, j), p), factor, load(AT(k, j), p)));
        }
    }
}

#define ROW(x, i) ((x) + (order ? order[i] : (i)) * SALTUS_RADAU_NODES)

/* sum - matrix x over unknowns `first` to `end` - 1. Two chains halve the latency. */
KERNEL_INLINE complex_pack reduce(complex_pack sum, const double *matrix, const double *x, const int *order,
                                  int first, int end, int p) {
    complex_pack other = {{0}, {0}};
    int j = first;
    for (; j + 1 < end; j += 2) {
        sum = minus_times(sum, load(matrix + j * SALTUS_RADAU_NODES, p), load(ROW(x, j), p));
        other = minus_times(other, load(matrix + (j + 1) * SALTUS_RADAU_NODES, p), load(ROW(x, j + 1), p));
    }
    if (j < end)
        sum = minus_times(sum, load(matrix + j * SALTUS_RADAU_NODES, p), load(ROW(x, j), p));
    return (complex_pack){sum.re + other.re, sum.im + other.im};
}

KERNEL_INLINE void substitute(const double *matrix, int n, int uncoupled, const int *order, double *x,
                              int p) {
    for (int i = uncoupled; i < n; i++)
        store(ROW(x, i), p, reduce(load(ROW(x, i), p), AT(i, 0), x, order, 0, i, p));
    for (int i = n - 1; i >= 0; i--) {
        int first = i < uncoupled ? uncoupled : i + 1;
        complex_pack sum = reduce(load(ROW(x, i), p), AT(i, 0), x, order, first, n, p);
        store(ROW(x, i), p, times(sum, load(AT(i, i), p)));
    }
#undef AT
#undef ROW
}

/* x = K^-1 x */
KERNEL_INLINE void solve_free(const saltus_stages *s, double *x, int p) {
    substitute(s->linear.lu, s->dof, s->linear.uncoupled, s->linear.order, x, p);
}

KERNEL_INLINE complex_pack dot(const double *pull, const double *x, int n, int p) {
    complex_pack sum = {{0}, {0}};
    for (int i = 0; i < n; i++) {
        complex_pack z = load(x + i * SALTUS_RADAU_NODES, p);
        saltus_pack factor = saltus_pack_splat(pull[i]);
        sum.re = saltus_pack_fma(factor, z.re, sum.re);
        sum.im = saltus_pack_fma(factor, z.im, sum.im);
    }
    return sum;
}

/* Entry of 1 - h mu Jv - (h mu)^2 Jq. */
KERNEL_INLINE complex_pack entry(complex_pack mu, complex_pack square, double one, double damp,
                                 double stiff) {
    saltus_pack d = saltus_pack_splat(-damp), s = saltus_pack_splat(-stiff);
    return (complex_pack){saltus_pack_fma(d, mu.re, saltus_pack_fma(s, square.re, saltus_pack_splat(one))),
                          saltus_pack_fma(d, mu.im, s * square.im)};
}

static void factor(saltus_stages *s) {
    int n = s->dof;
    for (int p = 0; p < packs_per_half; p++) {
        complex_pack mu = load(s->method->pair, p);
        mu.re *= s->step;
        mu.im *= s->step;
        complex_pack square = times(mu, mu);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                int at = s->linear.order[i] * n + s->linear.order[j];
                store(s->linear.lu + (i * n + j) * SALTUS_RADAU_NODES, p,
                      entry(mu, square, i == j, s->linear.damp[at], s->linear.stiff[at]));
            }
        decompose(s->linear.lu, n, s->linear.uncoupled, p);
    }
}

static void factor_contacts(saltus_stages *s) {
    int n = s->dof, m = s->contact.count;
    for (int p = 0; p < packs_per_half; p++) {
        for (int c = 0; c < m; c++) {
            double *reply = s->contact.reply + c * n * SALTUS_RADAU_NODES;
            for (int i = 0; i < n; i++)
                store(reply + i * SALTUS_RADAU_NODES, p,
                      (complex_pack){saltus_pack_splat(s->contact.push[c * n + i]), {0}});
            solve_free(s, reply, p);
            for (int r = 0; r < m; r++)
                store(s->contact.schur + (r * m + c) * SALTUS_RADAU_NODES, p,
                      dot(s->contact.pull + r * n, reply, n, p));
        }
        decompose(s->contact.schur, m, 0, p);
    }
}

/* Solve for the contact forces and subtract their effect: the corrected accelerations do not enter the stops.
 * `force` holds the pull rows times the residual (rounding, or a start off the contact), then the forces. */
KERNEL_INLINE void hold(const saltus_stages *s, double *x, double *force, int p) {
    int n = s->dof, m = s->contact.count;
    for (int c = 0; c < m; c++) {
        double *row = force + c * SALTUS_RADAU_NODES;
        complex_pack residual = load(row, p), reply = dot(s->contact.pull + c * n, x, n, p);
        store(row, p, (complex_pack){reply.re - residual.re, reply.im - residual.im});
    }
    substitute(s->contact.schur, m, 0, NULL, force, p);
    for (int c = 0; c < m; c++) {
        complex_pack f = load(force + c * SALTUS_RADAU_NODES, p);
        for (int i = 0; i < n; i++) {
            double *row = x + i * SALTUS_RADAU_NODES;
            const double *reply = s->contact.reply + (c * n + i) * SALTUS_RADAU_NODES;
            store(row, p, minus_times(load(row, p), f, load(reply, p)));
        }
    }
}

/* Add `rows` rows of 16 times a matrix to the sums. */
KERNEL_INLINE void multiply(const double *in, int rows, const double *m, saltus_pack (*sum)[packs_per_row]) {
    for (int k = 0; k < SALTUS_RADAU_NODES; k++) {
        const saltus_pack *line = (const saltus_pack *)(const void *)(m + k * SALTUS_RADAU_NODES);
        for (int r = 0; r < rows; r++) {
            saltus_pack factor = saltus_pack_splat(in[r * SALTUS_RADAU_NODES + k]);
            for (int p = 0; p < packs_per_row; p++)
                sum[r][p] = saltus_pack_fma(factor, line[p], sum[r][p]);
        }
    }
}

KERNEL_INLINE void apply_rows(const double *in, int rows, const double *m, double *out, bool add) {
    saltus_pack sum[tile][packs_per_row], *target = (saltus_pack *)(void *)out;
    for (int r = 0; r < rows; r++)
        for (int p = 0; p < packs_per_row; p++)
            sum[r][p] = add ? target[r * packs_per_row + p] : (saltus_pack){0};
    multiply(in, rows, m, sum);
    for (int r = 0; r < rows; r++)
        for (int p = 0; p < packs_per_row; p++)
            target[r * packs_per_row + p] = sum[r][p];
}

static void apply(const double *in, int rows, const double *m, double *out) {
    int r = 0;
    for (; r + tile <= rows; r += tile)
        apply_rows(in + r * SALTUS_RADAU_NODES, tile, m, out + r * SALTUS_RADAU_NODES, false);
    for (; r < rows; r++)
        apply_rows(in + r * SALTUS_RADAU_NODES, 1, m, out + r * SALTUS_RADAU_NODES, false);
}

/* hat = residual (field - accelerations) of some modes in the eigenvectors' basis. */
KERNEL_INLINE void residual(saltus_stages *s, int column, int mode, int rows) {
    double r[tile * SALTUS_RADAU_NODES] __attribute__((aligned(64)));
    size_t place = ((size_t)column * (size_t)s->dof + (size_t)mode) * SALTUS_RADAU_NODES;
    for (int i = 0; i < rows; i++)
        for (int p = 0; p < packs_per_row; p++) {
            const double *field = s->field[p] + (size_t)column * s->row + (size_t)((mode + i) * SALTUS_PACK);
            size_t at = (size_t)(i * packs_per_row + p);
            ((saltus_pack *)(void *)r)[at] = *(const saltus_pack *)(const void *)field -
                                             ((const saltus_pack *)(const void *)(s->a + place))[at];
        }
    apply_rows(r, rows, s->method->to_pairs[0], s->hat + mode * SALTUS_RADAU_NODES, false);
}

static void correct(saltus_stages *s, int column) {
    double force[SALTUS_FACES_MAX * SALTUS_RADAU_NODES] __attribute__((aligned(64)));
    int n = s->dof, i = 0;
    for (; i + tile <= n; i += tile)
        residual(s, column, i, tile);
    for (; i < n; i++)
        residual(s, column, i, 1);
    for (int p = 0; p < packs_per_half; p++) {
        for (int c = 0; c < s->contact.count; c++)
            store(force + c * SALTUS_RADAU_NODES, p, dot(s->contact.pull + c * n, s->hat, n, p));
        solve_free(s, s->hat, p);
        if (s->contact.count)
            hold(s, s->hat, force, p);
    }
    double *a = s->a + (size_t)column * (size_t)n * SALTUS_RADAU_NODES;
    for (i = 0; i + tile <= n; i += tile)
        apply_rows(s->hat + i * SALTUS_RADAU_NODES, tile, s->method->to_nodes[0], a + i * SALTUS_RADAU_NODES,
                   true);
    for (; i < n; i++)
        apply_rows(s->hat + i * SALTUS_RADAU_NODES, 1, s->method->to_nodes[0], a + i * SALTUS_RADAU_NODES,
                   true);
}

/* The field's arguments for some modes; their largest changes are collected in `change`. */
KERNEL_INLINE void integrate_rows(saltus_stages *s, int column, int mode, int rows, saltus_pack *change) {
    saltus_pack v[tile][packs_per_row] = {{{0}}}, q[tile][packs_per_row] = {{{0}}};
    size_t place = (size_t)column * (size_t)s->dof + (size_t)mode;
    const double *a = s->a + place * SALTUS_RADAU_NODES;
    multiply(a, rows, s->method->integral[0], v);
    multiply(a, rows, s->method->integral2[0], q);
    saltus_pack h = saltus_pack_splat(s->step);
    for (int i = 0; i < rows; i++)
        for (int p = 0; p < packs_per_row; p++) {
            saltus_pack v0 = saltus_pack_splat(s->v0[place + (size_t)i]),
                        q0 = saltus_pack_splat(s->q0[place + (size_t)i]);
            saltus_pack node = ((const saltus_pack *)(const void *)s->method->node)[p];
            size_t at = (size_t)column * s->row + (size_t)((mode + i) * SALTUS_PACK);
            saltus_pack *newest = (saltus_pack *)(void *)(s->v[p] + at),
                        *moved = (saltus_pack *)(void *)(s->q[p] + at);
            saltus_pack speed = saltus_pack_fma(h, v[i][p], v0),
                        position = saltus_pack_fma(h, saltus_pack_fma(h, q[i][p], node * v0), q0);
            change[0] = saltus_pack_max_size(change[0], position - *moved);
            change[1] = saltus_pack_max_size(change[1], speed - *newest);
            *newest = speed;
            *moved = position;
        }
}

static void integrate(saltus_stages *s, int column) {
    saltus_pack change[2] = {{0}, {0}};
    int i = 0;
    for (; i + tile / 2 <= s->dof && tile > 1; i += tile / 2)
        integrate_rows(s, column, i, tile / 2, change);
    for (; i < s->dof; i++)
        integrate_rows(s, column, i, 1, change);
    for (int k = 0; k < 2; k++)
        s->change[2 * column + k] = saltus_pack_largest(change[k]);
}

extern const saltus_collocation_kernel SALTUS_COLLOCATION_NAME;
const saltus_collocation_kernel SALTUS_COLLOCATION_NAME = {
    .pack = SALTUS_PACK,
    .factor = factor,
    .factor_contacts = factor_contacts,
    .correct = correct,
    .integrate = integrate,
    .apply = apply,
};
