/* The oscillator's vector field, order by order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_OSCILLATOR_KERNEL_H
#define SALTUS_SYSTEM_OSCILLATOR_KERNEL_H

#include "system/oscillator.h"

#define MODEL_NAME "oscillator"

/* The model has so few operations that loops specialised for certain terms gain nothing. */
enum { model_rows_common = 0, model_rows_varied = 0, model_rows_plain = SALTUS_WIDE ? 2 : 1 };
#define model_common_terms(rows) 0u

enum { drive_force, model_drives };
enum { table_force, model_tables };
enum { model_series_count, model_rows_ahead = 0, model_columns_apart = true, model_abreast = 1 };
enum { vary_cosine, model_vary_drives }; /* derivative of cos(omega t + phase) */

static void model_load(saltus_work *w, int lane, const saltus_system *system) {
    double coefficient = 1;
    for (int k = 0; k < w->order_span; k++) {
        w->loaded.table[(size_t)k * (size_t)w->lanes + (size_t)lane] =
            (k + 1) & 2 ? -coefficient : coefficient;
        coefficient *= system->omega / (k + 1);
    }
}

KERNEL_INLINE void model_forcing(frame f, int order, lane_t sine, lane_t cosine) {
    for (int k = 0; k <= order; k += ORDERS_AT_ONCE)
        for (int j = 0; j < ORDERS_AT_ONCE; j += ORDERS_PER_PACK)
            *DRIVE_PACK(drive_force, k + j) = *TABLE(table_force, k + j) * lane_alternate(cosine, sine, j);
}

/* Nothing has to be prepared, and there is no second copy of the state's series to keep. */
#define model_start(f, c) ((void)0)
#define model_place(f, k, c, velocity, displacement) ((void)(displacement))

/* d cos(theta + omega t) / d omega = -(elapsed + t) sin(theta + omega t), where `elapsed` is the time since
 * theta was fixed. */
KERNEL_INLINE void model_vary_forcing(frame f, int d, int order, lane_t sine, lane_t cosine) {
    const lane_t elapsed = *f.elapsed, omega = *SCALAR(oscillator_omega),
                 rate = *VARY_SCALAR(d, oscillator_omega);
    lane_t before = lane_constant(0);
    for (int k = 0; k <= order; k++) {
        const lane_t s = sine, scale = omega * (1.0 / (k + 1));
        *VARY_DRIVE(d, vary_cosine, k) = -rate * (elapsed * s + before);
        before = s;
        sine = scale * cosine;
        cosine = -scale * s;
    }
}

/* Add the derivative of the field along a parameter direction, at order k of the trajectory. */
KERNEL_INLINE void model_source(frame f, int k, int c, int d, double inverse, saltus_pack *next) {
    const saltus_pack *q = JET(f.q, k, 0), *v = JET(f.v, k, 0);
    const saltus_pack *column[] = {VARY_ROW(d, oscillator_k1), VARY_ROW(d, oscillator_c1),
                                   VARY_ROW(d, oscillator_k2), VARY_ROW(d, oscillator_c2)};
    const lane_t start = row_element(v, 0);
    for (int p = 0; p < f.packs; p++) {
        saltus_pack sum = {0};
        for (int j = 0; j < f.dof; j++) {
            sum = saltus_pack_fma(column[2 * j][p], lane_spread(row_element(q, j)), sum);
            sum = saltus_pack_fma(column[2 * j + 1][p], lane_spread(row_element(v, j)), sum);
        }
        if (f.terms & SALTUS_TERM_EXTRA)
            sum = saltus_pack_fma(VARY_ROW(d, oscillator_maxwell)[p], lane_spread(*EXTRA(k, 0)), sum);
        sum = saltus_pack_fnma(VARY_ROW(d, oscillator_force)[p], lane_spread(*DRIVE(drive_force, k)), sum);
        sum = saltus_pack_fnma(ROW(oscillator_force)[p], lane_spread(*VARY_DRIVE(d, vary_cosine, k)), sum);
        if (k == 0)
            sum -= VARY_ROW(d, oscillator_load)[p];
        next[p] = saltus_pack_fnma(sum, inverse - (saltus_pack){0}, next[p]);
    }
    if (f.terms & SALTUS_TERM_EXTRA)
        *EXTRA(k + 1, c) += inverse * lane_fma(*VARY_SCALAR(d, oscillator_kz), start,
                                               -*VARY_SCALAR(d, oscillator_rate_z) * *EXTRA(k, 0));
}

/* Coefficient k + 1 of q' and of the Maxwell force, for the trajectory (c = 0) or a tangent vector. */
KERNEL_INLINE void model_order(frame f, int k, int c, const int abreast, double inverse, saltus_pack *next) {
    (void)abreast;
    const saltus_pack *q = JET(f.q, k, c), *velocity = JET(f.v, k, c);
    const saltus_pack *column[] = {ROW(oscillator_k1), ROW(oscillator_c1), ROW(oscillator_k2),
                                   ROW(oscillator_c2)};
    for (int p = 0; p < f.packs; p++) {
        saltus_pack sum = {0};
        for (int j = 0; j < f.dof; j++) {
            sum = saltus_pack_fma(column[2 * j][p], lane_spread(row_element(q, j)), sum);
            sum = saltus_pack_fma(column[2 * j + 1][p], lane_spread(row_element(velocity, j)), sum);
        }
        if (f.terms & SALTUS_TERM_EXTRA)
            sum = saltus_pack_fma(ROW(oscillator_maxwell)[p], lane_spread(*EXTRA(k, c)), sum);
        if ((f.terms & SALTUS_TERM_FORCED) && c == 0)
            sum = saltus_pack_fnma(ROW(oscillator_force)[p], lane_spread(*DRIVE(drive_force, k)), sum);
        if (k == 0 && c == 0)
            sum -= ROW(oscillator_load)[p];
        next[p] = sum * -inverse;
    }
    if (f.terms & SALTUS_TERM_EXTRA)
        *EXTRA(k + 1, c) = inverse * lane_fma(*SCALAR(oscillator_kz), row_element(velocity, 0),
                                              -*SCALAR(oscillator_rate_z) * *EXTRA(k, c));
}

#endif
