/* The inner loops of collocation, for one instruction set. Included by collocation.c once for each, with
 *   PACK       doubles in a pack,
 *   TARGET     the attribute that allows the instructions,
 *   NAME(x)    x with the instruction set's name attached,
 *   FMA(a,b,c) a b + c.
 * SPDX-License-Identifier: GPL-3.0-or-later */

#define INLINE TARGET static inline __attribute__((always_inline))
#define PER_ROW (SALTUS_RADAU_NODES / PACK)
#define PER_HALF (SALTUS_RADAU_PAIRS / PACK)

typedef double NAME(pack) __attribute__((vector_size(8 * PACK), may_alias));
typedef int64_t NAME(bits) __attribute__((vector_size(8 * PACK), may_alias));
#define pack NAME(pack)
#define bits NAME(bits)

INLINE pack NAME(splat)(double a) {
    return a - (pack){0};
}

typedef struct NAME(complex_pack) {
    pack re, im;
} NAME(complex_pack);
#define complex_pack NAME(complex_pack)

INLINE complex_pack NAME(load)(const double *row, int p) {
    return (complex_pack){((const pack *)(const void *)row)[p],
                          ((const pack *)(const void *)(row + SALTUS_RADAU_PAIRS))[p]};
}

INLINE void NAME(store)(double *row, int p, complex_pack z) {
    ((pack *)(void *)row)[p] = z.re;
    ((pack *)(void *)(row + SALTUS_RADAU_PAIRS))[p] = z.im;
}

INLINE complex_pack NAME(times)(complex_pack a, complex_pack b) {
    return (complex_pack){FMA(-a.im, b.im, a.re * b.re), FMA(a.im, b.re, a.re * b.im)};
}

/* c - a b */
INLINE complex_pack NAME(minus_times)(complex_pack c, complex_pack a, complex_pack b) {
    return (complex_pack){FMA(a.im, b.im, FMA(-a.re, b.re, c.re)), FMA(-a.im, b.re, FMA(-a.re, b.im, c.im))};
}

INLINE complex_pack NAME(invert)(complex_pack a) {
    pack size = FMA(a.re, a.re, a.im * a.im);
    return (complex_pack){a.re / size, -a.im / size};
}

/* LU factors in place without pivoting, inverted pivots on the diagonal; the first `uncoupled` unknowns are
 * not coupled among themselves. The matrices are 1 plus a dissipative part; if a pivot should come out small
 * all the same, the iteration that uses the factors does not converge and the step is halved. */
INLINE void NAME(decompose)(double *matrix, int n, int uncoupled, int p) {
#define AT(i, j) (matrix + ((i)*n + (j)) * SALTUS_RADAU_NODES)
    for (int k = 0; k < n; k++) {
        complex_pack inverse = NAME(invert)(NAME(load)(AT(k, k), p));
        NAME(store)(AT(k, k), p, inverse);
        int first = k < uncoupled ? uncoupled : k + 1;
        for (int i = first; i < n; i++) {
            complex_pack factor = NAME(times)(NAME(load)(AT(i, k), p), inverse);
            NAME(store)(AT(i, k), p, factor);
            for (int j = first; j < n; j++)
                NAME(store)
            (AT(i, j), p, NAME(minus_times)(NAME(load)(AT(i, j), p), factor, NAME(load)(AT(k, j), p)));
        }
    }
}

#define ROW(x, i) ((x) + (order ? order[i] : (i)) * SALTUS_RADAU_NODES)

/* sum - matrix x over some unknowns. Two chains halve the latency. */
INLINE complex_pack NAME(reduce)(complex_pack sum, const double *matrix, const double *x, const int *order,
                                 int first, int end, int p) {
    complex_pack other = {{0}, {0}};
    int j = first;
    for (; j + 1 < end; j += 2) {
        sum =
            NAME(minus_times)(sum, NAME(load)(matrix + j * SALTUS_RADAU_NODES, p), NAME(load)(ROW(x, j), p));
        other = NAME(minus_times)(other, NAME(load)(matrix + (j + 1) * SALTUS_RADAU_NODES, p),
                                  NAME(load)(ROW(x, j + 1), p));
    }
    if (j < end)
        sum =
            NAME(minus_times)(sum, NAME(load)(matrix + j * SALTUS_RADAU_NODES, p), NAME(load)(ROW(x, j), p));
    return (complex_pack){sum.re + other.re, sum.im + other.im};
}

INLINE void NAME(substitute)(const double *matrix, int n, int uncoupled, const int *order, double *x, int p) {
    for (int i = uncoupled; i < n; i++)
        NAME(store)(ROW(x, i), p, NAME(reduce)(NAME(load)(ROW(x, i), p), AT(i, 0), x, order, 0, i, p));
    for (int i = n - 1; i >= 0; i--) {
        int first = i < uncoupled ? uncoupled : i + 1;
        complex_pack sum = NAME(reduce)(NAME(load)(ROW(x, i), p), AT(i, 0), x, order, first, n, p);
        NAME(store)(ROW(x, i), p, NAME(times)(sum, NAME(load)(AT(i, i), p)));
    }
#undef AT
#undef ROW
}

/* x = K^-1 x */
INLINE void NAME(solve_free)(const saltus_stages *s, double *x, int p) {
    NAME(substitute)(s->lu, s->dof, s->uncoupled, s->order, x, p);
}

INLINE complex_pack NAME(dot)(const double *pull, const double *x, int n, int p) {
    complex_pack sum = {{0}, {0}};
    for (int i = 0; i < n; i++) {
        complex_pack z = NAME(load)(x + i * SALTUS_RADAU_NODES, p);
        pack factor = NAME(splat)(pull[i]);
        sum.re = FMA(factor, z.re, sum.re);
        sum.im = FMA(factor, z.im, sum.im);
    }
    return sum;
}

/* Entry of 1 - h mu Jv - (h mu)^2 Jq. */
INLINE complex_pack NAME(entry)(complex_pack mu, complex_pack square, double one, double damp, double stiff) {
    pack d = NAME(splat)(-damp), s = NAME(splat)(-stiff);
    return (complex_pack){FMA(d, mu.re, FMA(s, square.re, NAME(splat)(one))), FMA(d, mu.im, s * square.im)};
}

TARGET static void NAME(factor)(saltus_stages *s) {
    int n = s->dof;
    for (int p = 0; p < PER_HALF; p++) {
        complex_pack mu = NAME(load)(s->method->pair, p);
        mu.re *= s->step;
        mu.im *= s->step;
        complex_pack square = NAME(times)(mu, mu);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                int at = s->order[i] * n + s->order[j];
                NAME(store)
                (s->lu + (i * n + j) * SALTUS_RADAU_NODES, p,
                 NAME(entry)(mu, square, i == j, s->damp[at], s->stiff[at]));
            }
        NAME(decompose)(s->lu, n, s->uncoupled, p);
    }
}

TARGET static void NAME(factor_contacts)(saltus_stages *s) {
    int n = s->dof, m = s->contacts;
    for (int p = 0; p < PER_HALF; p++) {
        for (int c = 0; c < m; c++) {
            double *reply = s->reply + c * n * SALTUS_RADAU_NODES;
            for (int i = 0; i < n; i++)
                NAME(store)
            (reply + i * SALTUS_RADAU_NODES, p, (complex_pack){NAME(splat)(s->push[c * n + i]), {0}});
            NAME(solve_free)(s, reply, p);
            for (int r = 0; r < m; r++)
                NAME(store)
            (s->schur + (r * m + c) * SALTUS_RADAU_NODES, p, NAME(dot)(s->pull + r * n, reply, n, p));
        }
        NAME(decompose)(s->schur, m, 0, p);
    }
}

/* The contacts' forces are such that the corrected accelerations do not enter the stops. `free` are the rows'
 * products with the residual itself, zero but for rounding and a start that does not satisfy the contact. */
INLINE void NAME(hold)(const saltus_stages *s, double *x, double *force, int p) {
    int n = s->dof, m = s->contacts;
    for (int c = 0; c < m; c++) {
        double *row = force + c * SALTUS_RADAU_NODES;
        complex_pack residual = NAME(load)(row, p), reply = NAME(dot)(s->pull + c * n, x, n, p);
        NAME(store)(row, p, (complex_pack){reply.re - residual.re, reply.im - residual.im});
    }
    NAME(substitute)(s->schur, m, 0, NULL, force, p);
    for (int c = 0; c < m; c++) {
        complex_pack f = NAME(load)(force + c * SALTUS_RADAU_NODES, p);
        for (int i = 0; i < n; i++) {
            double *row = x + i * SALTUS_RADAU_NODES;
            const double *reply = s->reply + (c * n + i) * SALTUS_RADAU_NODES;
            NAME(store)(row, p, NAME(minus_times)(NAME(load)(row, p), f, NAME(load)(reply, p)));
        }
    }
}

enum { NAME(tile) = PACK / 2 };

/* `rows` rows of 16 times a matrix, added to the accumulators. */
INLINE void NAME(multiply)(const double *in, int rows, const double *m, pack (*sum)[PER_ROW]) {
    for (int k = 0; k < SALTUS_RADAU_NODES; k++) {
        const pack *line = (const pack *)(const void *)(m + k * SALTUS_RADAU_NODES);
        for (int r = 0; r < rows; r++) {
            pack factor = NAME(splat)(in[r * SALTUS_RADAU_NODES + k]);
            for (int p = 0; p < PER_ROW; p++)
                sum[r][p] = FMA(factor, line[p], sum[r][p]);
        }
    }
}

INLINE void NAME(apply_rows)(const double *in, int rows, const double *m, double *out, bool add) {
    pack sum[NAME(tile)][PER_ROW], *target = (pack *)(void *)out;
    for (int r = 0; r < rows; r++)
        for (int p = 0; p < PER_ROW; p++)
            sum[r][p] = add ? target[r * PER_ROW + p] : (pack){0};
    NAME(multiply)(in, rows, m, sum);
    for (int r = 0; r < rows; r++)
        for (int p = 0; p < PER_ROW; p++)
            target[r * PER_ROW + p] = sum[r][p];
}

TARGET static void NAME(apply)(const double *in, int rows, const double *m, double *out) {
    int r = 0;
    for (; r + NAME(tile) <= rows; r += NAME(tile))
        NAME(apply_rows)(in + r * SALTUS_RADAU_NODES, NAME(tile), m, out + r * SALTUS_RADAU_NODES, false);
    for (; r < rows; r++)
        NAME(apply_rows)(in + r * SALTUS_RADAU_NODES, 1, m, out + r * SALTUS_RADAU_NODES, false);
}

/* hat = residual of some modes, in the eigenvectors' basis. */
INLINE void NAME(residual)(saltus_stages *s, int column, int mode, int rows) {
    double r[NAME(tile) * SALTUS_RADAU_NODES] __attribute__((aligned(64)));
    size_t place = ((size_t)column * (size_t)s->dof + (size_t)mode) * SALTUS_RADAU_NODES;
    for (int i = 0; i < rows; i++)
        for (int p = 0; p < PER_ROW; p++) {
            const double *field = s->field[p] + (size_t)column * s->row + (size_t)((mode + i) * PACK);
            size_t at = (size_t)(i * PER_ROW + p);
            ((pack *)(void *)r)[at] =
                *(const pack *)(const void *)field - ((const pack *)(const void *)(s->a + place))[at];
        }
    NAME(apply_rows)(r, rows, s->method->to_pairs[0], s->hat + mode * SALTUS_RADAU_NODES, false);
}

TARGET static void NAME(correct)(saltus_stages *s, int column) {
    double force[SALTUS_FACES_MAX * SALTUS_RADAU_NODES] __attribute__((aligned(64)));
    int n = s->dof, i = 0;
    for (; i + NAME(tile) <= n; i += NAME(tile))
        NAME(residual)(s, column, i, NAME(tile));
    for (; i < n; i++)
        NAME(residual)(s, column, i, 1);
    for (int p = 0; p < PER_HALF; p++) {
        for (int c = 0; c < s->contacts; c++)
            NAME(store)(force + c * SALTUS_RADAU_NODES, p, NAME(dot)(s->pull + c * n, s->hat, n, p));
        NAME(solve_free)(s, s->hat, p);
        if (s->contacts)
            NAME(hold)(s, s->hat, force, p);
    }
    double *a = s->a + (size_t)column * (size_t)n * SALTUS_RADAU_NODES;
    for (i = 0; i + NAME(tile) <= n; i += NAME(tile))
        NAME(apply_rows)
    (s->hat + i * SALTUS_RADAU_NODES, NAME(tile), s->method->to_nodes[0], a + i * SALTUS_RADAU_NODES, true);
    for (; i < n; i++)
        NAME(apply_rows)
    (s->hat + i * SALTUS_RADAU_NODES, 1, s->method->to_nodes[0], a + i * SALTUS_RADAU_NODES, true);
}

/* The larger of a and |b - c|. */
INLINE pack NAME(larger)(pack a, pack b, pack c) {
    bits size = (bits)(b - c) & INT64_MAX, greater = (pack)size > a;
    return (pack)((greater & size) | (~greater & (bits)a));
}

/* The field's arguments of some modes; the changes are collected. */
INLINE void NAME(integrate_rows)(saltus_stages *s, int column, int mode, int rows, pack *change) {
    pack v[NAME(tile)][PER_ROW] = {{{0}}}, q[NAME(tile)][PER_ROW] = {{{0}}};
    size_t place = (size_t)column * (size_t)s->dof + (size_t)mode;
    const double *a = s->a + place * SALTUS_RADAU_NODES;
    NAME(multiply)(a, rows, s->method->integral[0], v);
    NAME(multiply)(a, rows, s->method->integral2[0], q);
    pack h = NAME(splat)(s->step);
    for (int i = 0; i < rows; i++)
        for (int p = 0; p < PER_ROW; p++) {
            pack v0 = NAME(splat)(s->v0[place + (size_t)i]), q0 = NAME(splat)(s->q0[place + (size_t)i]);
            pack node = ((const pack *)(const void *)s->method->node)[p];
            size_t at = (size_t)column * s->row + (size_t)((mode + i) * PACK);
            pack *newest = (pack *)(void *)(s->v[p] + at), *moved = (pack *)(void *)(s->q[p] + at);
            pack speed = FMA(h, v[i][p], v0), position = FMA(h, FMA(h, q[i][p], node * v0), q0);
            change[0] = NAME(larger)(change[0], position, *moved);
            change[1] = NAME(larger)(change[1], speed, *newest);
            *newest = speed;
            *moved = position;
        }
}

TARGET static void NAME(integrate)(saltus_stages *s, int column) {
    pack change[2] = {{0}, {0}};
    int i = 0;
    for (; i + NAME(tile) / 2 <= s->dof && NAME(tile) > 1; i += NAME(tile) / 2)
        NAME(integrate_rows)(s, column, i, NAME(tile) / 2, change);
    for (; i < s->dof; i++)
        NAME(integrate_rows)(s, column, i, 1, change);
    for (int k = 0; k < 2; k++) {
        double largest = 0;
        for (int l = 0; l < PACK; l++)
            largest = largest > change[k][l] ? largest : change[k][l];
        s->change[2 * column + k] = largest;
    }
}

static const saltus_collocation_kernel NAME(kernel) = {PACK,          NAME(factor),    NAME(factor_contacts),
                                                       NAME(correct), NAME(integrate), NAME(apply)};

#undef INLINE
#undef PER_ROW
#undef PER_HALF
#undef pack
#undef bits
#undef complex_pack
