/* The page of verdicts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_PAGE_H
#define SALTUS_TRIAL_PAGE_H

#include "claims.h"

/* Write a claim as a row of the table, or as a section. */
void trial_write_row(FILE *file, const trial_claim *claim, const trial_finding *finding);
void trial_write_section(FILE *file, const trial_claim *claim, const trial_finding *finding);

/* Judge everything and write paper.md, and paper/windows.csv, classes.csv and naive-steps.csv, into a folder.
 * Errors: those of the judges, SALTUS_IO. */
saltus_status trial_write_page(trial_bench *bench, const char *folder, saltus_message *message);

#endif
