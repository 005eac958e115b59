/* The oscillator's vector field, order by order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_OSCILLATOR_KERNEL_H
#define SALTUS_SYSTEM_OSCILLATOR_KERNEL_H

#include "system/oscillator.h"

#define MODEL_NAME "oscillator"

enum { drive_force, model_drives };
enum { table_force, model_tables };
enum { model_series, model_rows_ahead = 0 };

static void model_load(saltus_work *w, int lane, const saltus_system *system) {
    double coefficient = 1;
    for (int k = 0; k < w->order_span; k++) {
        w->table[(size_t)k * (size_t)w->lanes + (size_t)lane] = (k + 1) & 2 ? -coefficient : coefficient;
        coefficient *= system->omega / (k + 1);
    }
}

KERNEL_INLINE void model_forcing(frame f, int order, lane_t sine, lane_t cosine) {
    for (int k = 0; k <= order; k += ORDERS_PER_PACK)
        *DRIVE_PACK(drive_force, k) = *TABLE(table_force, k) * lane_alternate(cosine, sine, k);
}

/* Coefficient k + 1 of q' and of the Maxwell force, for the trajectory (c = 0) or a tangent vector. */
KERNEL_INLINE void model_order(frame f, int k, int c, double inverse, const saltus_pack *velocity,
                               saltus_pack *next) {
    const saltus_pack *q = JET(f.q, k, c);
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
