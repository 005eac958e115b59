/* What a sweep has found, in short, on stdout.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_PRINT_H
#define SALTUS_TOOLS_SWEEP_PRINT_H

#include "run_sweep.h"

/* Run a sweep whose preparations ended with `status`, and print what it found on the first rank: a table, or
 * one JSON object with the keys version, scene, file, kind, complete, points, passes, seeds, rows, computed,
 * seconds, trajectories_per_second, ranks, classes (label, count, share), and of basins attractors (label,
 * largest_multiplier, count, share). Where an earlier run has done a part, the numbers are those of the file.
 * Returns the exit code. */
int sweep_finish(const sweep_order *order, saltus_status status, bool json, saltus_message *message);

#endif
