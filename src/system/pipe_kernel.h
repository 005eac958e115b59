/* The pipe's vector field, order by order (model.md, section 1).
 *
 * With P = S + alpha S' (S' = 2 S1) all terms that multiply q_i itself share one scalar series,
 *   W = kappa P - u^2 - sqrt(beta) u' / 2,
 * and the field is
 *   q_i'' = - alpha lambda_i^4 v_i - lambda_i^4 q_i - lambda_i^2 W q_i - (G 2 sqrt(beta) u v)_i - (B
 * sqrt(beta) u' q)_i with B's diagonal gone into W. The three products of a scalar series and a row are
 * formed side by side, before G, B and lambda^2 act on them; the cubic term then costs one product per order,
 * and half a one for S.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_PIPE_KERNEL_H
#define SALTUS_SYSTEM_PIPE_KERNEL_H

#include "system/pipe.h"

#define MODEL_NAME "pipe"

/* 2 sqrt(beta) u, sqrt(beta) u', the part -u^2 - sqrt(beta) u' / 2 of W, and all of the trajectory's W. */
enum { drive_velocity, drive_gradient, drive_tension, drive_all_tension, model_drives };
enum { table_velocity, table_gradient, table_tension, table_tension_gradient, table_tension2, model_tables };
enum { series_square, series_tension, model_series };
enum { vary_velocity, vary_gradient, vary_tension, vary_all_tension, model_vary_drives };
enum { ahead_tension, ahead_gradient, ahead_velocity, ahead_square, model_rows_ahead };

/* Orders of sin(omega t + phase) are omega^k / k! times sine, cosine, -sine, -cosine in turn; the signs go
 * into the tables. Beyond the orders that matter all is zero. */
static void model_load(saltus_work *w, int lane, const saltus_system *system) {
    const saltus_coefficients *c = &system->coefficients;
    double root_beta = c->scalar[pipe_root_beta], u0 = c->scalar[pipe_u0], sigma = c->scalar[pipe_sigma];
    double single = 1, twice = 1;
    for (int k = 0; k < w->order_span; k++) {
        double *t = w->table + (size_t)k * (size_t)w->lanes + lane;
        size_t stride = (size_t)w->order_span * (size_t)w->lanes;
        double matters = c->terms & SALTUS_TERM_FORCED && k <= c->forcing_orders;
        double sine = k & 2 ? -matters : matters, cosine = (k + 1) & 2 ? -matters : matters;
        t[table_velocity * stride] = 2 * root_beta * u0 * sigma * single * sine;
        t[table_gradient * stride] = root_beta * u0 * sigma * system->omega * single * cosine;
        t[table_tension * stride] = -2 * u0 * u0 * sigma * single * sine;
        t[table_tension_gradient * stride] = -0.5 * t[table_gradient * stride];
        t[table_tension2 * stride] = 0.5 * u0 * u0 * sigma * sigma * twice * cosine;
        single *= system->omega / (k + 1);
        twice *= 2 * system->omega / (k + 1);
    }
}

KERNEL_INLINE void model_forcing(frame f, int order, lane_t sine, lane_t cosine) {
    const lane_t *root_beta = SCALAR(pipe_root_beta), *u0 = SCALAR(pipe_u0), *sigma = SCALAR(pipe_sigma);
    const lane_t sine2 = 2.0 * sine * cosine, cosine2 = 1.0 - 2.0 * sine * sine;
    const int last = order < f.forcing ? order : f.forcing;
    for (int k = 0; k <= last; k += ORDERS_PER_PACK) {
        const saltus_pack s = lane_alternate(sine, cosine, k), c = lane_alternate(cosine, sine, k);
        saltus_pack tension = *TABLE(table_tension2, k) * lane_alternate(cosine2, sine2, k);
        tension = saltus_pack_fma(*TABLE(table_tension_gradient, k), c, tension);
        *DRIVE_PACK(drive_tension, k) = saltus_pack_fma(*TABLE(table_tension, k), s, tension);
        *DRIVE_PACK(drive_velocity, k) = *TABLE(table_velocity, k) * s;
        *DRIVE_PACK(drive_gradient, k) = *TABLE(table_gradient, k) * c;
    }
    for (int k = 0; k < f.order_span; k += ORDERS_PER_PACK)
        *DRIVE_PACK(drive_all_tension, k) = (saltus_pack){0};
    *DRIVE(drive_velocity, 0) += 2.0 * *root_beta * *u0;
    *DRIVE(drive_tension, 0) -= *u0 * *u0 * (1.0 + 0.5 * *sigma * *sigma);
}

/* Coefficient 0 of S, or of its derivative along a tangent vector. */
KERNEL_INLINE void model_square_start(frame f, int c) {
    saltus_pack product[ROW_PACKS_MAX];
    for (int p = 0; p < f.packs; p++)
        product[p] = ROW(pipe_lambda2)[p] * JET(f.q, 0, 0)[p] * JET(f.q, 0, c)[p];
    saltus_pack sum = row_sum(product, f.dof, f.packs) * (c ? 1.0 : 0.5);
    *SERIES(series_square, 0, c) = lane_of(sum);
}

/* Sums over the inner coefficients m = 1 .. k of q_m delta_{k+1-m}; the trajectory's own are halved, as its
 * products come in equal pairs, and are formed for two orders at a time. */
KERNEL_INLINE saltus_pack model_square_inner(frame f, int k, int c, int p) {
    if (c > 0)
        return jet_product(&JET(f.q, 0, 0)[p], &JET(f.q, k + 1, c)[p], ORDER_STRIDE, 1, k + 1);
    if (k % 2)
        return AHEAD(ahead_square, 0)[p];
    const int half = k / 2;
    const saltus_pack middle = JET(f.q, half + 1, 0)[p];
    saltus_pack sum = {0}, next = {0};
    for (int m = 1; m <= half; m++) {
        sum = saltus_pack_fma(JET(f.q, m, 0)[p], JET(f.q, k + 1 - m, 0)[p], sum);
        next = saltus_pack_fma(JET(f.q, m, 0)[p], JET(f.q, k + 2 - m, 0)[p], next);
    }
    AHEAD(ahead_square, 0)[p] = saltus_pack_fma(0.5 * middle, middle, next);
    return sum;
}

/* W_k = (u part) + kappa (S_k + alpha (k + 1) S_{k+1}), spread. (k + 1) S_{k+1} is formed here, from v_k = (k
 * + 1) q_{k+1} where the newest coefficient takes part. */
KERNEL_INLINE saltus_pack model_tension(frame f, int k, int c, double inverse, const saltus_pack *velocity) {
    const saltus_pack kappa = lane_spread(*SCALAR(pipe_kappa)), alpha = lane_spread(*SCALAR(pipe_alpha));
    saltus_pack rate[ROW_PACKS_MAX];
    if (k == 0)
        model_square_start(f, c);
    for (int p = 0; p < f.packs; p++) {
        const saltus_pack lambda2 = ROW(pipe_lambda2)[p];
        saltus_pack sum = model_square_inner(f, k, c, p) * (lambda2 * (k + 1.0));
        if (c > 0)
            sum = saltus_pack_fma(lambda2 * JET(f.v, k, 0)[p], JET(f.q, 0, c)[p], sum);
        rate[p] = saltus_pack_fma(lambda2 * JET(f.q, 0, 0)[p], velocity[p], sum);
    }
    saltus_pack known = kappa * lane_spread(*SERIES(series_square, k, c));
    if (c == 0)
        known += lane_spread(*DRIVE(drive_tension, k));
    saltus_pack next = row_sum(rate, f.dof, f.packs), tension = saltus_pack_fma(kappa * alpha, next, known);
    *SERIES(series_square, k + 1, c) = lane_of(next * inverse);
    *(c ? SERIES(series_tension, k, c) : DRIVE(drive_all_tension, k)) = lane_of(tension);
    return tension;
}

/* The three products of a scalar series and a row at one order, but for the terms with the newest W and v. */
typedef struct model_products {
    saltus_pack tension, gradient, velocity;
} model_products;

/* The products of order k, and on the way what is known of those of order k + 1: one loop over the older
 * coefficients serves two orders. The trajectory's W_k is yet to come and zero until then. */
KERNEL_INLINE model_products model_convolve_two(frame f, int k, int c, int p) {
    const bool cubic = f.terms & SALTUS_TERM_CUBIC;
    const lane_t *tension = DRIVE(cubic ? drive_all_tension : drive_tension, 0);
    const lane_t *gradient = DRIVE(drive_gradient, 0), *velocity = DRIVE(drive_velocity, 1);
    const saltus_pack *q = &JET(f.q, k, c)[p], *v = &JET(f.v, k, c)[p], start = JET(f.q, 0, c)[p];
    const int forced = k <= f.forcing ? k : f.forcing + 1;
    model_products sum = {{0}, {0}, {0}}, next = {{0}, {0}, {0}};
    int m = 0;
    for (; m < forced; m++, q -= ORDER_STRIDE) {
        v -= ORDER_STRIDE;
        sum.tension = saltus_pack_fma(lane_spread(tension[m]), *q, sum.tension);
        next.tension = saltus_pack_fma(lane_spread(tension[m + 1]), *q, next.tension);
        sum.gradient = saltus_pack_fma(lane_spread(gradient[m]), *q, sum.gradient);
        next.gradient = saltus_pack_fma(lane_spread(gradient[m + 1]), *q, next.gradient);
        sum.velocity = saltus_pack_fma(lane_spread(velocity[m]), *v, sum.velocity);
        next.velocity = saltus_pack_fma(lane_spread(velocity[m + 1]), *v, next.velocity);
    }
    for (; m < (cubic ? k : 0); m++, q -= ORDER_STRIDE) {
        sum.tension = saltus_pack_fma(lane_spread(tension[m]), *q, sum.tension);
        next.tension = saltus_pack_fma(lane_spread(tension[m + 1]), *q, next.tension);
    }
    sum.gradient = saltus_pack_fma(lane_spread(gradient[k]), start, sum.gradient);
    if (!cubic || c > 0)
        sum.tension = saltus_pack_fma(lane_spread(tension[k]), start, sum.tension);
    AHEAD(ahead_tension, c)[p] = next.tension;
    AHEAD(ahead_gradient, c)[p] = saltus_pack_fma(lane_spread(gradient[k + 1]), start, next.gradient);
    AHEAD(ahead_velocity, c)[p] = next.velocity;
    return sum;
}

/* The products of an odd order k, begun at order k - 1. */
KERNEL_INLINE model_products model_convolve_rest(frame f, int k, int c, int p) {
    const bool cubic = f.terms & SALTUS_TERM_CUBIC;
    const lane_t *tension = DRIVE(cubic ? drive_all_tension : drive_tension, 0);
    const saltus_pack q = JET(f.q, k, c)[p], v = JET(f.v, k - 1, c)[p];
    model_products sum = {AHEAD(ahead_tension, c)[p], AHEAD(ahead_gradient, c)[p],
                          AHEAD(ahead_velocity, c)[p]};
    sum.tension = saltus_pack_fma(lane_spread(tension[0]), q, sum.tension);
    sum.gradient = saltus_pack_fma(lane_spread(*DRIVE(drive_gradient, 0)), q, sum.gradient);
    sum.velocity = saltus_pack_fma(lane_spread(*DRIVE(drive_velocity, 1)), v, sum.velocity);
    if (!cubic || c > 0)
        sum.tension = saltus_pack_fma(lane_spread(tension[k]), JET(f.q, 0, c)[p], sum.tension);
    else if (k > 1)
        sum.tension = saltus_pack_fma(lane_spread(tension[k - 1]), JET(f.q, 1, c)[p], sum.tension);
    return sum;
}

/* What only a tangent vector has: its own W times the trajectory. */
KERNEL_INLINE saltus_pack model_tangent(frame f, int k, int c, int p, saltus_pack sum) {
    for (int m = 0; m < k; m++)
        sum = saltus_pack_fma(lane_spread(*SERIES(series_tension, m, c)), JET(f.q, k - m, 0)[p], sum);
    return sum;
}

/* v_{k+1} = (coefficient k of q'') / (k + 1) for the trajectory (c = 0) or a tangent vector; `velocity` is
 * v_k. Sums are ordered so that what depends on the newest coefficients comes last. */
KERNEL_INLINE void model_order(frame f, int k, int c, double inverse, const saltus_pack *velocity,
                               saltus_pack *next) {
    const bool cubic = f.terms & SALTUS_TERM_CUBIC, coupled = f.terms & SALTUS_TERM_COUPLED;
    const bool forced = f.terms & SALTUS_TERM_FORCED;
    saltus_pack tension[ROW_PACKS_MAX], resting[ROW_PACKS_MAX], moving[ROW_PACKS_MAX];
    for (int p = 0; p < f.packs; p++) {
        model_products sum = k % 2 ? model_convolve_rest(f, k, c, p) : model_convolve_two(f, k, c, p);
        if (cubic && c > 0)
            sum.tension = model_tangent(f, k, c, p, sum.tension);
        tension[p] = sum.tension;
        resting[p] = sum.gradient;
        moving[p] = saltus_pack_fma(lane_spread(*DRIVE(drive_velocity, 0)), velocity[p], sum.velocity);
        next[p] = -ROW(pipe_stiffness)[p] * JET(f.q, k, c)[p];
    }
    if (coupled && forced)
        row_couple(next, f.coupling[pipe_gradient], resting, f.dof, f.packs);
    for (int p = 0; p < f.packs; p++) {
        saltus_pack sum = saltus_pack_fnma(ROW(pipe_lambda2)[p], tension[p], next[p]);
        next[p] = saltus_pack_fnma(ROW(pipe_damping)[p], velocity[p], sum);
    }
    if (coupled)
        row_couple(next, f.coupling[pipe_gyroscopic], moving, f.dof, f.packs);
    for (int p = 0; p < f.packs; p++)
        next[p] *= inverse;
    if (!cubic)
        return;
    const saltus_pack newest = model_tension(f, k, c, inverse, velocity);
    for (int p = 0; p < f.packs; p++)
        next[p] = saltus_pack_fnma(newest, JET(f.q, 0, 0)[p] * (ROW(pipe_lambda2)[p] * inverse), next[p]);
}

/* Derivatives of the drives. The angle theta + omega t changes by (elapsed + t) d omega, `elapsed` being the
 * time since theta was fixed; order k of t times a series is the series' order k - 1. */
KERNEL_INLINE void model_vary_forcing(frame f, int d, int order, lane_t sine, lane_t cosine) {
    const lane_t root_beta = *SCALAR(pipe_root_beta), u0 = *SCALAR(pipe_u0), sigma = *SCALAR(pipe_sigma);
    const lane_t omega = *SCALAR(pipe_omega), rate_omega = *VARY_SCALAR(d, pipe_omega), elapsed = *f.elapsed;
    const lane_t rate_root = *VARY_SCALAR(d, pipe_root_beta), rate_u0 = *VARY_SCALAR(d, pipe_u0);
    const lane_t rate_sigma = *VARY_SCALAR(d, pipe_sigma), pulsation = u0 * sigma * omega;
    const lane_t rate_pulsation = (rate_u0 * sigma + u0 * rate_sigma) * omega + u0 * sigma * rate_omega;
    lane_t s = sine, c = cosine, s2 = 2.0 * sine * cosine, c2 = 1.0 - 2.0 * sine * sine;
    lane_t before_s = lane_constant(0), before_c = before_s, before_s2 = before_s;
    const int last = order < f.vary_orders ? order : f.vary_orders;
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

/* The derivative of W along a direction, at the order k that the trajectory has just passed. */
KERNEL_INLINE void model_vary_tension(frame f, int k, int d) {
    const lane_t rate = *VARY_SCALAR(d, pipe_kappa);
    const lane_t damping = rate * *SCALAR(pipe_alpha) + *SCALAR(pipe_kappa) * *VARY_SCALAR(d, pipe_alpha);
    lane_t tension = k <= f.vary_orders ? *VARY_DRIVE(d, vary_tension, k) : lane_constant(0);
    if (f.terms & SALTUS_TERM_CUBIC)
        tension +=
            rate * *SERIES(series_square, k, 0) + damping * (k + 1.0) * *SERIES(series_square, k + 1, 0);
    *VARY_DRIVE(d, vary_all_tension, k) = tension;
}

/* The derivative of the field itself along a direction, at order k of the trajectory: the same three products
 * with the derivatives of the scalar series. */
KERNEL_INLINE void model_source(frame f, int k, int c, int d, double inverse, saltus_pack *next) {
    const int forced = k < f.vary_orders ? k : f.vary_orders, last = f.terms & SALTUS_TERM_CUBIC ? k : forced;
    saltus_pack source[ROW_PACKS_MAX], resting[ROW_PACKS_MAX], moving[ROW_PACKS_MAX];
    (void)c;
    model_vary_tension(f, k, d);
    for (int p = 0; p < f.packs; p++) {
        const saltus_pack *q = &JET(f.q, k, 0)[p], *v = &JET(f.v, k, 0)[p];
        saltus_pack tension = {0};
        resting[p] = moving[p] = tension;
        for (int m = 0; m <= last; m++)
            tension = saltus_pack_fma(lane_spread(*VARY_DRIVE(d, vary_all_tension, m)), q[-m * ORDER_STRIDE],
                                      tension);
        for (int m = 0; m <= forced; m++) {
            resting[p] = saltus_pack_fma(lane_spread(*VARY_DRIVE(d, vary_gradient, m)), q[-m * ORDER_STRIDE],
                                         resting[p]);
            moving[p] = saltus_pack_fma(lane_spread(*VARY_DRIVE(d, vary_velocity, m)), v[-m * ORDER_STRIDE],
                                        moving[p]);
        }
        source[p] = -ROW(pipe_lambda2)[p] * tension - VARY_ROW(d, pipe_damping)[p] * v[0];
    }
    row_couple(source, f.coupling[pipe_gradient], resting, f.dof, f.packs);
    row_couple(source, f.coupling[pipe_gyroscopic], moving, f.dof, f.packs);
    for (int p = 0; p < f.packs; p++)
        next[p] += source[p] * inverse;
}

#endif
