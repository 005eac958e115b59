/* Zeros of a step's polynomial.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_ISOLATE_H
#define SALTUS_FLOW_ISOLATE_H

#include "system/system.h"

#include <stdbool.h>

enum { SALTUS_DEGREE_MAX = SALTUS_ORDER_MAX };

/* The first s in (0, 1] at which p(s) = sum c_k s^k rises through zero, given p <= 0 just after s = 0 or p(0)
 * > 0 (then the first rise after p has fallen below zero is found). A maximum that only touches zero is no
 * rise.
 *
 * Method: subdivision in Bernstein form (the coefficients bound the polynomial, so an interval is discarded
 * only with proof) until p is monotone, convex or concave on an interval; a concave piece is decided by the
 * sign of p at its maximum, evaluated with compensation (Graillat, Langlois & Louvet, "Compensated Horner
 * scheme", 2005), as accurate as twice the working precision. Two roots in one step therefore count as much
 * as one: nothing depends on sign changes at the ends. Returns whether there is one. */
bool saltus_isolate_rise(const double *c, int degree, double *root);

/* p(s) with the error of twice the working precision, rounded to double. */
double saltus_compensated(const double *c, int degree, double s);

#endif
