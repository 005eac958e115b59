/* Private: the options of classifications and of Lyapunov exponents, declared once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_OPTIONS_H
#define SALTUS_MOTION_OPTIONS_H

#include "base/field.h"
#include "saltus/motion.h"

/* The longest that can be looked for, in forcing periods. */
enum { SALTUS_LONGEST_PERIOD = 1024 };

/* Of saltus_classify_options and of saltus_lyapunov_options. */
extern const saltus_option_table saltus_classify_table, saltus_lyapunov_table;

#endif
