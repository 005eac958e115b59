/* Private: the options of a sweep, declared once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SWEEP_OPTIONS_H
#define SALTUS_SWEEP_OPTIONS_H

#include "base/field.h"
#include "saltus/sweep.h"

/* The fields of saltus_sweep_options. */
extern const saltus_option_table saltus_sweep_table;
extern const saltus_word saltus_pass_words[], saltus_spacing_words[];

/* Whether the options are in range. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_sweep_check(const saltus_sweep_options *options, saltus_message *message);

#endif
