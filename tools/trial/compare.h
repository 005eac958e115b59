/* How far the figures and claims depend on the naive method's step.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_COMPARE_H
#define SALTUS_TRIAL_COMPARE_H

#include "claims.h"

/* For each figure: the part of trajectories that the naive method classes otherwise than the event-driven
 * flow from the same initial states. */
saltus_status trial_write_figures(FILE *table, trial_bench *bench, saltus_message *message);
/* For each claim made of clauses: the share of each by both methods, at the values that both have visited. */
saltus_status trial_write_shares(FILE *table, trial_bench *bench, saltus_message *message);

/* Ranges of one dominant class, figure by figure, and how many starts come to which kind at each value. */
saltus_status trial_write_windows(FILE *rows, trial_bench *bench, saltus_message *message);
saltus_status trial_write_classes(FILE *rows, trial_bench *bench, saltus_message *message);

#endif
