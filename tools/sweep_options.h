/* The options that saltus sweep and saltus basins share, and what they make.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_SWEEP_OPTIONS_H
#define SALTUS_TOOLS_SWEEP_OPTIONS_H

#include "cli.h"

extern const cli_option sweep_over, sweep_json;

/* The options of a sweep from the command line, with as many threads as this process is to have. */
saltus_sweep_options sweep_read_options(const cli_request *request);
/* A sweep over the axes of --over. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status sweep_make(const cli_request *request, const saltus_scene *scene,
                         const saltus_sweep_options *options, saltus_sweep **sweep, saltus_message *message);

#endif
