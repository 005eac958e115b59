/* Private: the options of classifications, of Lyapunov exponents and of spectra, declared once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_OPTIONS_H
#define SALTUS_MOTION_OPTIONS_H

#include "base/field.h"
#include "saltus/motion.h"
#include "saltus/spectrum.h"

/* The longest period that can be looked for, in forcing periods. */
enum { SALTUS_LONGEST_PERIOD = 1024 };

/* The fields of saltus_classify_options, saltus_lyapunov_options, and saltus_spectrum_options except the
 * quantities. */
extern const saltus_option_table saltus_classify_table, saltus_lyapunov_table, saltus_spectrum_table;

#endif
