/* The oscillator's vector field, order by order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_OSCILLATOR_KERNEL_H
#define SALTUS_SYSTEM_OSCILLATOR_KERNEL_H

#include "system/oscillator.h"

#define MODEL_NAME "oscillator"

enum { table_forcing, model_tables };
enum { series_forcing, model_series };
enum { model_products = 1 };

static void model_load(saltus_work *w, int lane, const saltus_system *system) {
    double coefficient = 1;
    for (int k = 0; k <= w->order; k++) {
        w->table[(size_t)k * (size_t)w->lanes + (size_t)lane] = coefficient;
        coefficient *= system->omega / (k + 1);
    }
}

KERNEL_INLINE void model_forcing(saltus_work *w, shape s, int order, int forcing_order, lane_t sine, lane_t cosine) {
    (void)forcing_order;
    lane_t wave[4] = {cosine, -sine, -cosine, sine};
    for (int k = 0; k <= order; k++)
        *SERIES(series_forcing, k, 0) = *TABLE(table_forcing, k) * wave[k % 4];
}

/* Coefficient k of q'' and of the Maxwell force's rate, for the trajectory (c = 0) or a tangent vector. */
KERNEL_INLINE void model_order(saltus_work *w, shape s, unsigned terms, int k, int c) {
    const saltus_pack *q = JET(w->q, k, c), *v = JET(w->v, k, c);
    const saltus_pack *column[] = {ROWS(oscillator_k1), ROWS(oscillator_c1), ROWS(oscillator_k2), ROWS(oscillator_c2)};
    saltus_pack *acceleration = JET(w->v, k + 1, c);
    for (int p = 0; p < s.packs; p++) {
        saltus_pack sum = {0};
        for (int j = 0; j < w->dof; j++) {
            sum = saltus_pack_fma(column[2 * j][p], lane_spread(row_element(q, j)), sum);
            sum = saltus_pack_fma(column[2 * j + 1][p], lane_spread(row_element(v, j)), sum);
        }
        if (terms & SALTUS_TERM_EXTRA)
            sum = saltus_pack_fma(ROWS(oscillator_maxwell)[p], lane_spread(*EXTRA(k, c)), sum);
        if ((terms & SALTUS_TERM_FORCED) && c == 0)
            sum = saltus_pack_fnma(ROWS(oscillator_force)[p], lane_spread(*SERIES(series_forcing, k, 0)), sum);
        if (k == 0 && c == 0)
            sum -= ROWS(oscillator_load)[p];
        acceleration[p] = -sum;
    }
    if (terms & SALTUS_TERM_EXTRA)
        *EXTRA(k + 1, c) =
            lane_fma(*SCALAR(oscillator_kz), row_element(v, 0), -*SCALAR(oscillator_rate_z) * *EXTRA(k, c));
}

#endif
