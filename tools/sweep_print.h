/* Common to saltus sweep and saltus basins: running, and a summary of the results on stdout.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_PRINT_H
#define SALTUS_TOOLS_SWEEP_PRINT_H

#include "cli.h"

extern const cli_option sweep_over, sweep_json;

/* Run a sweep over the axes of --over and print a summary on the first rank: a table, or one JSON object with
 * the keys version, scene, file, kind, complete, points, passes, seeds, rows, computed, seconds,
 * trajectories_per_second, ranks, classes (label, count, share), and of basins attractors (label,
 * largest_multiplier, count, share). After a resumed run the numbers are those of the whole file. `status`
 * and `message` are the outcome of loading the scene; all ranks must call this, even after a failure. Returns
 * the exit code. */
int sweep_command(const cli_request *request, bool basins, saltus_status status, const saltus_scene *scene,
                  const saltus_sweep_options *options, saltus_message *message);

#endif
