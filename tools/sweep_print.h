/* What a sweep has found, in short, on stdout.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_PRINT_H
#define SALTUS_TOOLS_SWEEP_PRINT_H

#include "run_sweep.h"

/* As a table, or as one JSON object with the keys version, scene, file, kind, complete, points, passes,
 * seeds, rows, computed, seconds, trajectories_per_second, ranks, classes (label, count, share), and of
 * basins attractors (label, largest_multiplier, count, share). Where an earlier run has done a part, the
 * numbers are those of the file. Errors: those of reading it. */
saltus_status sweep_print(const sweep_order *order, sweep_report *report, bool json, saltus_message *message);

#endif
