/* The naive method at d = 0.03, omega = 43, step by step.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_STEPS_H
#define SALTUS_TRIAL_STEPS_H

#include "survey.h"

/* Write what the naive method makes of fig7b, from 0.02 down to 1e-5 (quick: to 1e-4), with steps that are a
 * fraction of 1 and with steps that divide the period: a table in Markdown, and the same as CSV rows. Errors:
 * SALTUS_NO_MEMORY, those of scenes. */
saltus_status trial_write_steps(FILE *table, FILE *rows, const trial_request *request,
                                saltus_message *message);
/* For a figure: section points and impacts per period against the step, thirty steps to a decade, and the
 * points of the exact orbit at the end. */
saltus_status trial_write_step_points(FILE *file, bool quick, saltus_message *message);

#endif
