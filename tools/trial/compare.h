/* Dependence of figures and claims on the naive method's step.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_COMPARE_H
#define SALTUS_TRIAL_COMPARE_H

#include "claims.h"

/* For each figure: the fraction of trajectories that the naive method classifies differently from the
 * event-driven flow, from the same initial states. */
saltus_status trial_write_figures(FILE *table, trial_bench *bench, saltus_message *message);
/* For each claim made of clauses: the shares of its clauses by both methods, at the values visited by
 * both. */
saltus_status trial_write_shares(FILE *table, trial_bench *bench, saltus_message *message);

/* For each figure, the ranges with one dominant class, and the number of starts of each kind at each
 * value. */
saltus_status trial_write_windows(FILE *rows, trial_bench *bench, saltus_message *message);
saltus_status trial_write_classes(FILE *rows, trial_bench *bench, saltus_message *message);

#endif
