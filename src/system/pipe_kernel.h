/* The pipe's vector field, order by order (model.md, section 1).
 *
 * With P = S + alpha S' (S' = 2 S1) all terms proportional to q_i share one scalar series,
 *   W = kappa P - u^2 - sqrt(beta) u' / 2,
 * and the field is
 *   q_i'' = - alpha lambda_i^4 v_i - lambda_i^4 q_i - lambda_i^2 W q_i
 *           - (G 2 sqrt(beta) u v)_i - (B sqrt(beta) u' q)_i
 * where W contains B's diagonal. The three products of a scalar series and a row are formed side by side,
 * before G, B and lambda^2 act on them; the cubic term then costs one product per order, S half of one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_PIPE_KERNEL_H
#define SALTUS_SYSTEM_PIPE_KERNEL_H

#include "system/pipe.h"

#define MODEL_NAME "pipe"

/* Systems of up to this many rows have loops of their own: with the terms that most have, without and with
 * parameter columns, or with any; fewer where hardly a processor lacks wider packs. `model_abreast`: this
 * many packs of tangent vectors are expanded side by side. */
#if defined __x86_64__ && SALTUS_PACK == 2
enum { rows_wide = 8 };
#else
enum { rows_wide = 16 };
#endif
enum {
    model_rows_common = SALTUS_WIDE        ? rows_wide
                        : SALTUS_PACK == 4 ? 2
                                           : 4,
    model_rows_varied = SALTUS_WIDE ? 0 : 1,
    model_rows_plain = SALTUS_WIDE ? 0 : 2,
    model_abreast = SALTUS_WIDE || ROW_BLOCK_MAX < 4 ? 1 : 4
};
KERNEL_INLINE unsigned model_common_terms(int rows) {
    return SALTUS_TERM_FORCED | SALTUS_TERM_CUBIC | (SALTUS_WIDE && rows == 1 ? 0 : SALTUS_TERM_COUPLED);
}

/* Modes of a lone trajectory with straight code of its own, if it has the common terms and the forcing
 * matters at all orders. */
#if !SALTUS_WIDE && SALTUS_PACK == 8
#define MODEL_ALONE(X) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8)
#elif !SALTUS_WIDE && SALTUS_PACK == 4
#define MODEL_ALONE(X) X(1) X(2) X(3) X(4)
#endif
KERNEL_INLINE unsigned model_alone_terms(int modes) {
    return SALTUS_TERM_FORCED | SALTUS_TERM_CUBIC | (modes > 1 ? SALTUS_TERM_COUPLED : 0);
}

/* 2 sqrt(beta) u, sqrt(beta) u' and the part -u^2 - sqrt(beta) u' / 2 of W. */
enum { drive_velocity, drive_gradient, drive_tension, model_drives };
enum { table_velocity, table_gradient, table_tension, table_tension2, model_tables };
enum { series_square, series_tension, model_series_count };
enum { model_columns_apart = true };
enum { vary_velocity, vary_gradient, vary_tension, vary_all_tension, model_vary_drives };
enum {
    ahead_resting, /* sums begun for the next order */
    ahead_moving,
    ahead_square,
    ahead_start,  /* lambda^2 q_0 */
    ahead_second, /* lambda^2 q_1 */
    ahead_first,  /* lambda^2 + W_0 */
    model_rows_ahead
};

/* Coefficients of sin(omega t + phase) are omega^k / k! times sine, cosine, -sine, -cosine in turn; the
 * tables contain the signs. They are zero beyond the orders that matter. */
static void model_load(saltus_work *w, int lane, const saltus_system *system) {
    const saltus_coefficients *c = &system->coefficients;
    double root_beta = c->scalar[pipe_root_beta], u0 = c->scalar[pipe_u0], sigma = c->scalar[pipe_sigma];
    double single = 1, twice = 1;
    for (int k = 0; k < w->order_span; k++) {
        double *t = w->loaded.table + (size_t)k * (size_t)w->lanes + lane;
        size_t stride = (size_t)w->order_span * (size_t)w->lanes;
        double matters = c->terms & SALTUS_TERM_FORCED && k <= w->forcing.lane[lane];
        double sine = k & 2 ? -matters : matters, cosine = (k + 1) & 2 ? -matters : matters;
        t[table_velocity * stride] = 2 * root_beta * u0 * sigma * single * sine;
        t[table_gradient * stride] = root_beta * u0 * sigma * system->omega * single * cosine;
        t[table_tension * stride] = -2 * u0 * u0 * sigma * single * sine;
        t[table_tension2 * stride] = 0.5 * u0 * u0 * sigma * sigma * twice * cosine;
        single *= system->omega / (k + 1);
        twice *= 2 * system->omega / (k + 1);
    }
}

/* Orders k, k + 1, ... of the drives, as many as a pack holds; for odd k sine and cosine are exchanged. */
KERNEL_INLINE void model_forcing_orders(frame f, int k, saltus_pack s, saltus_pack c, saltus_pack twice) {
    const saltus_pack gradient = *TABLE(table_gradient, k) * c;
    saltus_pack tension = saltus_pack_fma(*TABLE(table_tension, k), s, *TABLE(table_tension2, k) * twice);
    *DRIVE_PACK(drive_velocity, k) = *TABLE(table_velocity, k) * s;
    *DRIVE_PACK(drive_gradient, k) = gradient;
    *DRIVE_PACK(drive_tension, k) = tension - 0.5 * gradient;
}

KERNEL_INLINE void model_forcing(frame f, int order, lane_t sine, lane_t cosine) {
    const lane_t *root_beta = SCALAR(pipe_root_beta), *u0 = SCALAR(pipe_u0), *sigma = SCALAR(pipe_sigma);
    const lane_t sine2 = 2.0 * sine * cosine, cosine2 = 1.0 - 2.0 * sine * sine;
    const int last = order < f.forcing ? order : f.forcing;
    for (int k = 0; k <= last; k += ORDERS_AT_ONCE)
        for (int j = 0; j < ORDERS_AT_ONCE; j += ORDERS_PER_PACK)
            model_forcing_orders(f, k + j, lane_alternate(sine, cosine, j), lane_alternate(cosine, sine, j),
                                 lane_alternate(cosine2, sine2, j));
    *DRIVE(drive_velocity, 0) += 2.0 * *root_beta * *u0;
    *DRIVE(drive_tension, 0) -= *u0 * *u0 * (1.0 + 0.5 * *sigma * *sigma);
}

/* Pack p of a row that columns side by side have in common. */
#define COMMON(row, p) ((row)[abreast == 1 ? (p) : (p) % f.packs])

/* Before the first order: lambda^2 q_0, and coefficient 0 of S or of its derivative in a tangent vector. */
KERNEL_INLINE void model_start(frame f, int c) {
    saltus_pack product[ROW_PACKS_MAX];
    for (int p = 0; p < f.packs; p++)
        AHEAD(ahead_start, c)[p] = ROW(pipe_lambda2)[p] * JET(f.q, 0, c)[p];
    for (int p = 0; p < f.packs; p++)
        product[p] = AHEAD(ahead_start, 0)[p] * JET(f.q, 0, c)[p];
    saltus_pack sum = row_sum(product, f.dof, f.packs) * (c ? 1.0 : 0.5);
    *SERIES(series_square, 0, c) = lane_of(sum);
}

/* Sums for an even order k and the next one, formed side by side because one pass over the older coefficients
 * serves both, and for as many rows as the registers hold. Every sum adds the newest coefficients last. */
typedef struct model_pair {
    saltus_pack now[ROW_PACKS_MAX], next[ROW_PACKS_MAX];
} model_pair;

/* Product of a scalar series and a jet. The series' coefficients top .. bottom times the jet's coefficients
 * from `oldest` on contribute to order k; those one index higher contribute to order k + 1. */
KERNEL_INLINE const saltus_pack *model_convolve(frame f, const lane_t *series, int top, int bottom,
                                                const saltus_pack *oldest, const int count, saltus_pack *now,
                                                saltus_pack *next) {
    saltus_pack later = lane_spread(series[top + 1]);
    for (int m = top; m >= bottom; m--, oldest += ORDER_STRIDE) {
        const saltus_pack number = lane_spread(series[m]);
        for (int p = 0; p < count; p++) {
            const saltus_pack coefficient = oldest[p];
            now[p] = saltus_pack_fma(number, coefficient, now[p]);
            next[p] = saltus_pack_fma(later, coefficient, next[p]);
        }
        later = number;
    }
    return oldest;
}

/* Contribution of the inner coefficients to S and S' at order k + 1. For the trajectory it is half the sum
 * over m = 1 .. k of q_m q_{k+1-m}, whose products come in equal pairs. */
KERNEL_INLINE void model_square(frame f, int k, int first, const int count, model_pair *inner) {
    const int half = k / 2;
    const saltus_pack *low = &JET(f.q, half, 0)[first], *high = &JET(f.q, half + 1, 0)[first];
    saltus_pack now[ROW_BLOCK_MAX], next[ROW_BLOCK_MAX], below[ROW_BLOCK_MAX];
    for (int p = 0; p < count; p++) {
        now[p] = (saltus_pack){0};
        below[p] = high[p];
        next[p] = 0.5 * below[p] * below[p];
    }
    for (int m = half; m > 0; m--, low -= ORDER_STRIDE) {
        high += ORDER_STRIDE;
        for (int p = 0; p < count; p++) {
            const saltus_pack one = low[p];
            now[p] = saltus_pack_fma(one, below[p], now[p]);
            below[p] = high[p];
            next[p] = saltus_pack_fma(one, below[p], next[p]);
        }
    }
    for (int p = 0; p < count; p++) {
        inner->now[first + p] = now[p];
        inner->next[first + p] = next[p];
    }
}

/* The same for a tangent vector: the sum over m = 1 .. k of q_m delta_{k+1-m}. */
KERNEL_INLINE void model_mixed(frame f, int k, int c, const int abreast, int first, const int count,
                               model_pair *inner) {
    const saltus_pack *own = &JET(f.q, k + 1, c)[first], *q = &JET(f.q, 1, 0)[first];
    saltus_pack now[ROW_BLOCK_MAX], next[ROW_BLOCK_MAX], above[ROW_BLOCK_MAX];
    for (int p = 0; p < count; p++) {
        now[p] = next[p] = (saltus_pack){0};
        above[p] = own[p];
    }
    for (int m = 1; m <= k; m++, q += ORDER_STRIDE) {
        own -= ORDER_STRIDE;
        for (int p = 0; p < count; p++) {
            const saltus_pack coefficient = COMMON(q, p);
            next[p] = saltus_pack_fma(coefficient, above[p], next[p]);
            above[p] = own[p];
            now[p] = saltus_pack_fma(coefficient, above[p], now[p]);
        }
    }
    for (int p = 0; p < count; p++) {
        inner->now[first + p] = now[p];
        inner->next[first + p] = saltus_pack_fma(COMMON(q, p), above[p], next[p]);
    }
}

/* 2 sqrt(beta) u times v, without the contribution of order k's newest velocities. */
KERNEL_INLINE void model_moving(frame f, int k, int c, int first, const int count, model_pair *out) {
    const lane_t *series = DRIVE(drive_velocity, 0);
    const int top = k < f.forcing ? k : f.forcing;
    saltus_pack now[ROW_BLOCK_MAX], next[ROW_BLOCK_MAX];
    for (int p = 0; p < count; p++)
        now[p] = next[p] = (saltus_pack){0};
    const saltus_pack *v = model_convolve(f, series, top, 1, &JET(f.v, k - top, c)[first], count, now, next);
    const saltus_pack newest = lane_spread(series[1]);
    for (int p = 0; p < count; p++) {
        out->now[first + p] = now[p];
        out->next[first + p] = saltus_pack_fma(newest, v[p], next[p]);
    }
}

/* W and sqrt(beta) u' times q, the stiffness added to W_0. model_order adds W's last two coefficients. */
KERNEL_INLINE void model_resting(frame f, int k, int c, const int abreast, int first, const int count,
                                 model_pair *pull, model_pair *slope) {
    const bool cubic = f.terms & SALTUS_TERM_CUBIC;
    const lane_t *tension = cubic ? SERIES(series_tension, 0, 0) : DRIVE(drive_tension, 0);
    const lane_t *gradient = DRIVE(drive_gradient, 0);
    const saltus_pack *q = &JET(f.q, 0, c)[first];
    const saltus_pack *stiff = (k == 0 ? ROW(pipe_lambda2) : AHEAD(ahead_first, 0)) + first;
    saltus_pack t[ROW_BLOCK_MAX], t_next[ROW_BLOCK_MAX], g[ROW_BLOCK_MAX], g_next[ROW_BLOCK_MAX];
    for (int p = 0; p < count; p++) {
        t[p] = t_next[p] = (saltus_pack){0};
        g[p] = g_next[p] = (saltus_pack){0};
    }
    const int bottom = k < 2 ? 1 : k - 1;
    q = model_convolve(f, gradient, k, bottom, q, count, g, g_next);
    int m = k < 2 ? 0 : k - 2;
    if (m > f.forcing) {
        q = model_convolve(f, tension, m, f.forcing + 1, q, count, t, t_next);
        m = f.forcing;
    }
    saltus_pack later = lane_spread(tension[m + 1]), steeper = lane_spread(gradient[m + 1]);
    for (; m > 0; m--, q += ORDER_STRIDE) {
        const saltus_pack number = lane_spread(tension[m]), steep = lane_spread(gradient[m]);
        for (int p = 0; p < count; p++) {
            const saltus_pack coefficient = q[p];
            t[p] = saltus_pack_fma(number, coefficient, t[p]);
            t_next[p] = saltus_pack_fma(later, coefficient, t_next[p]);
            g[p] = saltus_pack_fma(steep, coefficient, g[p]);
            g_next[p] = saltus_pack_fma(steeper, coefficient, g_next[p]);
        }
        later = number;
        steeper = steep;
    }
    const saltus_pack mildest = lane_spread(gradient[0]);
    for (int p = 0; p < count; p++) {
        const saltus_pack coefficient = q[p], newest = q[p + ORDER_STRIDE], own = COMMON(stiff, p);
        if (k > 0)
            t_next[p] = saltus_pack_fma(later, coefficient, t_next[p]);
        g_next[p] = saltus_pack_fma(steeper, coefficient, g_next[p]);
        pull->now[first + p] = saltus_pack_fma(own, coefficient, t[p]);
        slope->now[first + p] = saltus_pack_fma(mildest, coefficient, g[p]);
        pull->next[first + p] = saltus_pack_fma(own, newest, t_next[p]);
        slope->next[first + p] = saltus_pack_fma(mildest, newest, g_next[p]);
    }
}

/* Extra term of a tangent vector: its own W times the trajectory, without the last two coefficients of W. */
KERNEL_INLINE void model_tangent(frame f, int k, int c, const int abreast, int first, const int count,
                                 model_pair *pull) {
    const lane_t *own[ROW_BLOCK_MAX];
    const saltus_pack *q = &JET(f.q, 2, 0)[first];
    saltus_pack now[ROW_BLOCK_MAX], next[ROW_BLOCK_MAX], later[ROW_BLOCK_MAX];
    for (int p = 0; p < count; p++) {
        own[p] = SERIES(series_tension, 0, abreast == 1 ? c : c + p / f.packs);
        now[p] = pull->now[first + p];
        next[p] = pull->next[first + p];
        later[p] = lane_spread(own[p][k - 1]);
    }
    for (int m = k - 2; m >= 0; m--, q += ORDER_STRIDE)
        for (int p = 0; p < count; p++) {
            const saltus_pack number = lane_spread(own[p][m]), coefficient = COMMON(q, p);
            now[p] = saltus_pack_fma(number, coefficient, now[p]);
            next[p] = saltus_pack_fma(later[p], coefficient, next[p]);
            later[p] = number;
        }
    for (int p = 0; p < count; p++) {
        pull->now[first + p] = now[p];
        pull->next[first + p] = saltus_pack_fma(later[p], COMMON(q, p), next[p]);
    }
}

/* A frame for the rows of several columns as if they were one. */
KERNEL_INLINE frame side_by_side(frame f, const int abreast) {
    if (abreast > 1) {
        f.block = f.packs *= abreast;
        f.rest = 1;
    }
    return f;
}

/* All these sums at an even order; those of the next order are stored in AHEAD. */
KERNEL_INLINE void model_two(frame f, int k, int c, const int abreast, model_pair *resting,
                             model_pair *moving, model_pair *inner) {
    const bool cubic = f.terms & SALTUS_TERM_CUBIC, coupled = f.terms & SALTUS_TERM_COUPLED;
    const bool forced = f.terms & SALTUS_TERM_FORCED;
    const frame rows = side_by_side(f, abreast);
    model_pair slope;
    FOR_ROW_BLOCKS(rows, first, count, model_resting(f, k, c, abreast, first, count, resting, &slope));
    if (cubic && c > 0 && k > 0)
        FOR_ROW_BLOCKS(rows, first, count, model_tangent(f, k, c, abreast, first, count, resting));
    for (int p = 0; p < rows.packs; p++) {
        resting->now[p] *= COMMON(ROW(pipe_lambda2), p);
        resting->next[p] *= COMMON(ROW(pipe_lambda2), p);
    }
    if (coupled && forced)
        for (int p = 0; p < rows.packs; p += f.packs)
            row_couple_two(&resting->now[p], f.single ? NULL : &resting->next[p],
                           f.loaded.coupling[pipe_gradient], &slope.now[p], &slope.next[p], f.dof, f.packs);
    FOR_ROW_BLOCKS(rows, first, count, model_moving(f, k, c, first, count, moving));
    if (cubic && c > 0)
        FOR_ROW_BLOCKS(rows, first, count, model_mixed(f, k, c, abreast, first, count, inner));
    else if (cubic)
        FOR_ROW_BLOCKS(rows, first, count, model_square(f, k, first, count, inner));
    else
        for (int p = 0; p < rows.packs; p++)
            inner->now[p] = (saltus_pack){0};
    for (int p = 0; p < rows.packs && !f.single; p++) {
        AHEAD(ahead_resting, c)[p] = resting->next[p];
        AHEAD(ahead_moving, c)[p] = moving->next[p];
        if (cubic)
            AHEAD(ahead_square, c)[p] = inner->next[p];
    }
}

/* W_k = (u part) + kappa (S_k + alpha (k + 1) S_{k+1}), divided by k + 1 and spread over a pack, for each of
 * the columns side by side. */
KERNEL_INLINE void model_tension(frame f, int k, int c, const int abreast, double inverse, saltus_pack *inner,
                                 saltus_pack *last) {
    const saltus_pack *newest = JET(f.q, k + 1, c);
    const saltus_pack kappa = lane_spread(*SCALAR(pipe_kappa)),
                      damping = kappa * lane_spread(*SCALAR(pipe_alpha));
    for (int p = 0; p < f.packs * abreast; p++) {
        inner[p] = saltus_pack_fma(COMMON(AHEAD(ahead_start, 0), p), newest[p],
                                   COMMON(ROW(pipe_lambda2), p) * inner[p]);
        if (c > 0)
            inner[p] = saltus_pack_fma(AHEAD(ahead_start, c)[p], COMMON(JET(f.q, k + 1, 0), p), inner[p]);
    }
    for (int j = 0; j < abreast; j++) {
        saltus_pack known = kappa * lane_spread(*SERIES(series_square, k, c + j));
        if (c == 0)
            known += lane_spread(*DRIVE(drive_tension, k));
        const saltus_pack next = row_sum(inner + j * f.packs, f.dof, f.packs),
                          tension = saltus_pack_fma(damping * (k + 1.0), next, known);
        *SERIES(series_square, k + 1, c + j) = lane_of(next);
        *SERIES(series_tension, k, c + j) = lane_of(tension);
        last[j] = saltus_pack_fma(damping, next, known * inverse);
    }
}

/* The terms with W's last two coefficients, but for the trajectory's last one; in a tangent vector also those
 * of the trajectory's W. */
KERNEL_INLINE void model_pull(frame f, int k, int c, const int abreast, double inverse, saltus_pack *pull) {
    const bool cubic = f.terms & SALTUS_TERM_CUBIC;
    const lane_t *tension = cubic ? SERIES(series_tension, 0, 0) : DRIVE(drive_tension, 0);
    const int packs = f.packs * abreast;
    for (int p = 0; p < packs; p++)
        pull[p] = (saltus_pack){0};
    if (k > 0) {
        const saltus_pack before = lane_spread(tension[k - 1]) * inverse;
        for (int p = 0; p < packs; p++)
            pull[p] = before * AHEAD(ahead_second, c)[p];
    }
    if (c > 0 || !cubic) {
        const saltus_pack now = lane_spread(tension[k]) * inverse;
        for (int p = 0; p < packs; p++)
            pull[p] = saltus_pack_fma(now, AHEAD(ahead_start, c)[p], pull[p]);
    }
    for (int j = 0; j < abreast && k > 0 && c > 0 && cubic; j++) {
        const saltus_pack before = lane_spread(*SERIES(series_tension, k - 1, c + j)) * inverse;
        for (int p = 0; p < f.packs; p++)
            pull[j * f.packs + p] = saltus_pack_fma(before, AHEAD(ahead_second, 0)[p], pull[j * f.packs + p]);
    }
}

/* v_{k+1} = (coefficient k of q'') / (k + 1) for the trajectory (c = 0) or tangent vectors side by side. */
KERNEL_INLINE void model_order(frame f, int k, int c, const int abreast, double inverse, saltus_pack *next) {
    const saltus_pack *velocity = JET(f.v, k, c);
    const bool cubic = f.terms & SALTUS_TERM_CUBIC, coupled = f.terms & SALTUS_TERM_COUPLED;
    const saltus_pack steady = lane_spread(*DRIVE(drive_velocity, 0));
    const int packs = f.packs * abreast;
    model_pair resting, moving, inner;
    saltus_pack last[model_abreast] = {{0}};
    if (k % 2 == 0)
        model_two(f, k, c, abreast, &resting, &moving, &inner);
    else
        for (int p = 0; p < packs; p++) {
            resting.now[p] = AHEAD(ahead_resting, c)[p];
            moving.now[p] = AHEAD(ahead_moving, c)[p];
            inner.now[p] = AHEAD(ahead_square, c)[p];
        }
    for (int p = 0; p < packs; p++) {
        next[p] = saltus_pack_fma(COMMON(ROW(pipe_damping), p), velocity[p], resting.now[p]);
        moving.now[p] = saltus_pack_fma(steady, velocity[p], moving.now[p]);
    }
    if (coupled)
        for (int p = 0; p < packs; p += f.packs)
            row_couple(&next[p], f.loaded.coupling[pipe_gyroscopic], &moving.now[p], f.dof, f.packs);
    if (k == 0)
        for (int p = 0; p < packs; p++)
            AHEAD(ahead_second, c)[p] = COMMON(ROW(pipe_lambda2), p) * JET(f.q, 1, c)[p];
    if (cubic)
        model_tension(f, k, c, abreast, inverse, inner.now, last);
    saltus_pack pull[ROW_PACKS_MAX];
    model_pull(f, k, c, abreast, inverse, pull);
    for (int p = 0; p < packs; p++) {
        next[p] = saltus_pack_fma(saltus_pack_splat(-inverse), next[p], -pull[p]);
        if (cubic)
            next[p] = saltus_pack_fnma(last[abreast == 1 ? 0 : p / f.packs], COMMON(AHEAD(ahead_start, 0), p),
                                       next[p]);
    }
    if (k == 0 && c == 0) {
        const saltus_pack tension =
            lane_spread(cubic ? *SERIES(series_tension, 0, 0) : *DRIVE(drive_tension, 0));
        for (int p = 0; p < f.packs; p++)
            AHEAD(ahead_first, 0)[p] = ROW(pipe_lambda2)[p] + tension;
    }
}

/* Derivatives of the drives. The angle theta + omega t changes by (elapsed + t) d omega, where `elapsed` is
 * the time since theta was fixed; order k of t times a series is the series' order k - 1. */
KERNEL_INLINE void model_vary_forcing(frame f, int d, int order, lane_t sine, lane_t cosine) {
    const lane_t root_beta = *SCALAR(pipe_root_beta), u0 = *SCALAR(pipe_u0), sigma = *SCALAR(pipe_sigma);
    const lane_t omega = *SCALAR(pipe_omega), rate_omega = *VARY_SCALAR(d, pipe_omega), elapsed = *f.elapsed;
    const lane_t rate_root = *VARY_SCALAR(d, pipe_root_beta), rate_u0 = *VARY_SCALAR(d, pipe_u0);
    const lane_t rate_sigma = *VARY_SCALAR(d, pipe_sigma), pulsation = u0 * sigma * omega;
    const lane_t rate_pulsation = (rate_u0 * sigma + u0 * rate_sigma) * omega + u0 * sigma * rate_omega;
    lane_t s = sine, c = cosine, s2 = 2.0 * sine * cosine, c2 = 1.0 - 2.0 * sine * sine;
    lane_t before_s = lane_constant(0), before_c = before_s, before_s2 = before_s;
    const int last = order < f.vary.orders ? order : f.vary.orders;
    for (int k = 0; k <= last; k++) {
        const double one = k == 0;
        const lane_t later_s = rate_omega * (elapsed * s + before_s),
                     later_c = rate_omega * (elapsed * c + before_c),
                     later_s2 = rate_omega * (elapsed * s2 + before_s2);
        const lane_t u = u0 * (one + sigma * s), sine_square = 0.5 * (one - c2);
        const lane_t rate_u = rate_u0 * (one + sigma * s) + u0 * (rate_sigma * s + sigma * later_c);
        const lane_t rate_gradient =
            rate_root * pulsation * c + root_beta * (rate_pulsation * c - pulsation * later_s);
        const lane_t square =
            rate_u0 * (one + sigma * (2.0 * s + sigma * sine_square)) +
            u0 * (rate_sigma * (s + sigma * sine_square) + sigma * (later_c + 0.5 * sigma * later_s2));
        *VARY_DRIVE(d, vary_velocity, k) = 2.0 * (rate_root * u + root_beta * rate_u);
        *VARY_DRIVE(d, vary_gradient, k) = rate_gradient;
        *VARY_DRIVE(d, vary_tension, k) = -2.0 * u0 * square - 0.5 * rate_gradient;
        before_s = s;
        before_c = c;
        before_s2 = s2;
        const lane_t scale = omega * (1.0 / (k + 1));
        s = scale * before_c;
        c = -scale * before_s;
        s2 = 2.0 * scale * c2;
        c2 = -2.0 * scale * before_s2;
    }
}

/* The derivative of W along a direction, at the order k that the trajectory has just completed. */
KERNEL_INLINE void model_vary_tension(frame f, int k, int d) {
    const lane_t rate = *VARY_SCALAR(d, pipe_kappa);
    const lane_t damping = rate * *SCALAR(pipe_alpha) + *SCALAR(pipe_kappa) * *VARY_SCALAR(d, pipe_alpha);
    lane_t tension = k <= f.vary.orders ? *VARY_DRIVE(d, vary_tension, k) : lane_constant(0);
    if (f.terms & SALTUS_TERM_CUBIC)
        tension +=
            rate * *SERIES(series_square, k, 0) + damping * (k + 1.0) * *SERIES(series_square, k + 1, 0);
    *VARY_DRIVE(d, vary_all_tension, k) = tension;
}

/* Subtract the derivative of the field along a direction, at order k of the trajectory: the same three
 * products with the derivatives of the scalar series. */
KERNEL_INLINE void model_source(frame f, int k, int c, int d, double inverse, saltus_pack *next) {
    const int forced = k < f.vary.orders ? k : f.vary.orders, last = f.terms & SALTUS_TERM_CUBIC ? k : forced;
    saltus_pack source[ROW_PACKS_MAX], resting[ROW_PACKS_MAX], moving[ROW_PACKS_MAX];
    (void)c;
    model_vary_tension(f, k, d);
    for (int p = 0; p < f.packs; p++) {
        const saltus_pack *q = &JET(f.q, k, 0)[p], *v = &JET(f.v, k, 0)[p];
        const saltus_pack newest = v[0];
        saltus_pack tension = {0}, rest = {0}, motion = {0};
        int m = 0;
        for (; m <= forced; m++, q -= ORDER_STRIDE, v -= ORDER_STRIDE) {
            tension = saltus_pack_fma(lane_spread(*VARY_DRIVE(d, vary_all_tension, m)), *q, tension);
            rest = saltus_pack_fma(lane_spread(*VARY_DRIVE(d, vary_gradient, m)), *q, rest);
            motion = saltus_pack_fma(lane_spread(*VARY_DRIVE(d, vary_velocity, m)), *v, motion);
        }
        for (; m <= last; m++, q -= ORDER_STRIDE)
            tension = saltus_pack_fma(lane_spread(*VARY_DRIVE(d, vary_all_tension, m)), *q, tension);
        resting[p] = rest;
        moving[p] = motion;
        source[p] = ROW(pipe_lambda2)[p] * tension + VARY_ROW(d, pipe_damping)[p] * newest;
    }
    row_couple(source, f.loaded.coupling[pipe_gradient], resting, f.dof, f.packs);
    row_couple(source, f.loaded.coupling[pipe_gyroscopic], moving, f.dof, f.packs);
    for (int p = 0; p < f.packs; p++)
        next[p] -= source[p] * inverse;
}

/* This model keeps no second copy of the state's series. */
KERNEL_INLINE void model_place(frame f, int k, int c, const saltus_pack *velocity,
                               const saltus_pack *displacement) {
    (void)f;
    (void)k;
    (void)c;
    (void)velocity;
    (void)displacement;
}

#endif
