/* The naive method at d = 0.03, omega = 43, for a series of steps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_STEPS_H
#define SALTUS_TRIAL_STEPS_H

#include "survey.h"

/* Write the results of the naive method for fig7b, with steps from 0.02 down to 1e-5 (quick: 1e-4), both
 * simple fractions of 1 and fractions of the period: as a table in Markdown and as CSV rows. Errors:
 * SALTUS_NO_MEMORY, those of scenes. */
saltus_status trial_write_steps(FILE *table, FILE *rows, const trial_request *request,
                                saltus_message *message);
/* Data of a figure: section points and impacts per period against the step, thirty steps per decade, and at
 * the end the points of the exact orbit. */
saltus_status trial_write_step_points(FILE *file, bool quick, saltus_message *message);

#endif
