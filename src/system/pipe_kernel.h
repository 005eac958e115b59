/* The pipe's vector field, order by order (model.md, section 1).
 *
 * With P = S + alpha S' (S' = 2 S1) all terms that multiply q_i itself share one scalar series,
 *   W = kappa P - u^2 - sqrt(beta) u' / 2,
 * and the field is
 *   q_i'' = - alpha lambda_i^4 v_i - lambda_i^4 q_i - lambda_i^2 W q_i - 2 sqrt(beta) u (G v)_i - sqrt(beta) u' (B q)_i
 * with B's diagonal gone into W. The cubic term costs one series product per mode and order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_PIPE_KERNEL_H
#define SALTUS_SYSTEM_PIPE_KERNEL_H

#include "system/pipe.h"

#define MODEL_NAME "pipe"

/* Forcing: coefficients of sin(omega t + phase) are omega^k / k! times sine, cosine, -sine, -cosine in turn. */
enum { table_velocity, table_gradient, table_square, table_square2, model_tables };
enum { series_square, series_tension, series_velocity, series_gradient, model_series };
enum { product_gyroscopic, product_gradient, product_curvature, model_products };

static void model_load(saltus_work *w, int lane, const saltus_system *system) {
    const double *s = system->coefficients.scalar;
    double u0 = s[pipe_u0], sigma = s[pipe_sigma], omega = system->omega;
    double single = 1, twice = 1;
    for (int k = 0; k <= w->order; k++) {
        double *t = w->table + (size_t)k * (size_t)w->lanes + lane;
        size_t stride = (size_t)(w->order + 2) * (size_t)w->lanes;
        t[table_velocity * stride] = 2 * s[pipe_root_beta] * u0 * sigma * single;
        t[table_gradient * stride] = s[pipe_root_beta] * u0 * sigma * omega * single;
        t[table_square * stride] = 2 * u0 * u0 * sigma * single;
        t[table_square2 * stride] = -0.5 * u0 * u0 * sigma * sigma * twice;
        single *= omega / (k + 1);
        twice *= 2 * omega / (k + 1);
    }
}

/* Series of the flow velocity: 2 sqrt(beta) u, sqrt(beta) u', and the start of W: -u^2 - sqrt(beta) u' / 2. */
KERNEL_INLINE void model_forcing(saltus_work *w, shape s, int order, int forcing_order, lane_t sine, lane_t cosine) {
    const lane_t *root_beta = SCALAR(pipe_root_beta), *u0 = SCALAR(pipe_u0), *sigma = SCALAR(pipe_sigma);
    lane_t wave[4] = {sine, cosine, -sine, -cosine};
    lane_t sine2 = 2.0 * sine * cosine, cosine2 = 1.0 - 2.0 * sine * sine;
    lane_t wave2[4] = {cosine2, -sine2, -cosine2, sine2};
    int last = (w->terms & SALTUS_TERM_FORCED) ? forcing_order : 0;
    for (int k = last + 1; k <= order; k++)
        *SERIES(series_tension, k, 0) = lane_constant(0);
    for (int k = 0; k <= last; k++) {
        lane_t gradient = *TABLE(table_gradient, k) * wave[(k + 1) % 4];
        lane_t square = lane_fma(*TABLE(table_square, k), wave[k % 4], *TABLE(table_square2, k) * wave2[k % 4]);
        *SERIES(series_velocity, k, 0) = *TABLE(table_velocity, k) * wave[k % 4];
        *SERIES(series_gradient, k, 0) = gradient;
        *SERIES(series_tension, k, 0) = -square - 0.5 * gradient;
    }
    *SERIES(series_velocity, 0, 0) += 2.0 * *root_beta * *u0;
    *SERIES(series_tension, 0, 0) -= *u0 * *u0 * (1.0 + 0.5 * *sigma * *sigma);
}

/* Coefficient n of sum lambda^2 q delta_c over the modes (halved for c = 0, where the two halves of
 * the products are equal). lambda^2 q is kept as a product row: it serves here and beside W. */
KERNEL_INLINE lane_t model_square(saltus_work *w, shape s, int c, int n) {
    saltus_pack *scratch = (saltus_pack *)w->scratch;
    for (int p = 0; p < s.packs; p++) {
        const saltus_pack *curvature = &PRODUCT(product_curvature, 0, 0)[p], *newest = &JET(w->q, n, c)[p];
        saltus_pack sum = jet_product(curvature, newest, ORDER_STRIDE(s), 1, c ? n + 1 : (n + 1) / 2);
        if (c == 0 && n % 2 == 0 && n > 0)
            sum = saltus_pack_fma(0.5 * JET(w->q, n / 2, 0)[p], PRODUCT(product_curvature, n / 2, 0)[p], sum);
        saltus_pack oldest = curvature[0];
        if (c == 0 && n == 0)
            oldest *= 0.5;
        scratch[p] = saltus_pack_fma(oldest, newest[0], sum);
    }
    return row_sum(scratch, w->dof, s.packs);
}

/* W_k = (u part) + kappa (S_k + alpha (k + 1) S_{k+1}); S_{k+1} is formed here from q_{k+1}. */
KERNEL_INLINE lane_t model_tension(saltus_work *w, shape s, int k, int c) {
    const lane_t *alpha = SCALAR(pipe_alpha), *kappa = SCALAR(pipe_kappa);
    if (k == 0)
        *SERIES(series_square, 0, c) = model_square(w, s, c, 0);
    lane_t known = *kappa * *SERIES(series_square, k, c), factor = *kappa * *alpha * (k + 1.0);
    if (c == 0)
        known += *SERIES(series_tension, k, 0);
    lane_t next = model_square(w, s, c, k + 1);
    *SERIES(series_square, k + 1, c) = next;
    return *SERIES(series_tension, k, c) = lane_fma(factor, next, known);
}

/* Coefficient k of q'' for the trajectory (c = 0) or a tangent vector. Sums are ordered so that what depends on the
 * newest coefficients comes last. */
KERNEL_INLINE void model_order(saltus_work *w, shape s, unsigned terms, int k, int c) {
    const saltus_pack *lambda2 = ROWS(pipe_lambda2), *damping = ROWS(pipe_damping), *stiffness = ROWS(pipe_stiffness);
    const bool cubic = terms & SALTUS_TERM_CUBIC, forced = terms & SALTUS_TERM_FORCED;
    const bool coupled = terms & SALTUS_TERM_COUPLED;
    const int forcing = forced ? (k < w->forcing_orders ? k : w->forcing_orders) : 0;
    const int tension = cubic ? k : forcing;
    for (int order = c || k ? k + !c : 0; order <= k + !c; order++)
        for (int p = 0; p < s.packs; p++)
            PRODUCT(product_curvature, order, c)[p] = lambda2[p] * JET(w->q, order, c)[p];
    if (coupled && forced)
        row_couple(PRODUCT(product_gradient, k, c), w->coupling[pipe_gradient], JET(w->q, k, c), w->dof, s.packs);
    if (coupled)
        row_couple(PRODUCT(product_gyroscopic, k, c), w->coupling[pipe_gyroscopic], JET(w->v, k, c), w->dof, s.packs);
    saltus_pack newest = lane_spread(cubic ? model_tension(w, s, k, c) : *SERIES(series_tension, 0, 0));
    for (int p = 0; p < s.packs; p++) {
        const saltus_pack *curvature = &PRODUCT(product_curvature, k, c)[p];
        saltus_pack sum = saltus_pack_fma(stiffness[p], JET(w->q, k, c)[p], damping[p] * JET(w->v, k, c)[p]);
        if (coupled && forced)
            sum += series_product(SERIES(series_gradient, 0, 0), SERIES_STRIDE(s), &PRODUCT(product_gradient, k, c)[p],
                                  ORDER_STRIDE(s), 0, forcing + 1);
        if (coupled) {
            const saltus_pack *gyroscopic = &PRODUCT(product_gyroscopic, k, c)[p];
            sum += series_product(SERIES(series_velocity, 0, 0), SERIES_STRIDE(s), gyroscopic, ORDER_STRIDE(s), 1,
                                  forcing + 1);
            sum = saltus_pack_fma(lane_spread(*SERIES(series_velocity, 0, 0)), gyroscopic[0], sum);
        }
        /* W of the trajectory times the column; for a tangent vector also its own W times the trajectory. */
        bool own = cubic && c == 0;
        sum += series_product(SERIES(series_tension, 0, 0), SERIES_STRIDE(s), curvature, ORDER_STRIDE(s), 0,
                              own ? tension : tension + 1);
        if (cubic && c > 0)
            sum += series_product(SERIES(series_tension, 0, c), SERIES_STRIDE(s), &PRODUCT(product_curvature, k, 0)[p],
                                  ORDER_STRIDE(s), 0, k);
        if (cubic)
            sum = saltus_pack_fma(newest, PRODUCT(product_curvature, 0, 0)[p], sum);
        JET(w->v, k + 1, c)[p] = -sum;
    }
}

#endif
