/* What saltus sweep and saltus basins share: options, and what was found, in short, on stdout.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_PRINT_H
#define SALTUS_TOOLS_SWEEP_PRINT_H

#include "cli.h"

extern const cli_option sweep_over, sweep_json;

/* Run a sweep over the axes of --over and print what it found on the first rank: a table, or one JSON object
 * with the keys version, scene, file, kind, complete, points, passes, seeds, rows, computed, seconds,
 * trajectories_per_second, ranks, classes (label, count, share), and of basins attractors (label,
 * largest_multiplier, count, share). Where an earlier run has done a part, the numbers are those of the file.
 * `status` and `message` tell how loading the scene went: all ranks take part, also where that failed.
 * Returns the exit code. */
int sweep_command(const cli_request *request, bool basins, saltus_status status, const saltus_scene *scene,
                  const saltus_sweep_options *options, saltus_message *message);

#endif
