/* Names of the oscillator's coefficients, shared by the model and its kernel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_OSCILLATOR_H
#define SALTUS_SYSTEM_OSCILLATOR_H

enum { oscillator_kz, oscillator_rate_z, oscillator_omega };
enum {
    oscillator_k1, /* columns of M^-1 K, then of M^-1 C */
    oscillator_k2,
    oscillator_c1,
    oscillator_c2,
    oscillator_force,   /* M^-1 F */
    oscillator_load,    /* M^-1 F0 */
    oscillator_maxwell, /* M^-1 times the direction of the Maxwell element's force */
    oscillator_rows
};

#endif
