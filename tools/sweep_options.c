/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_options.h"

#include "ranks.h"

#include <stdlib.h>
#include <string.h>

const cli_option sweep_over = CLI_KEYS_OPTION(
    "--over", over, "key=values",
    "an axis: key=lo:hi:n, key=lo:hi:n:log or key=v1,v2,...; once or twice, the first runs fastest");
const cli_option sweep_json = CLI_FLAG_OPTION("--json", json, "a summary as one JSON object on stdout");

saltus_sweep_options sweep_read_options(const cli_request *request) {
    saltus_sweep_options o = request->sweep;
    if (o.threads == 0)
        o.threads = ranks_threads();
    return o;
}

saltus_status sweep_make(const cli_request *request, const saltus_scene *scene,
                         const saltus_sweep_options *options, saltus_sweep **sweep, saltus_message *message) {
    saltus_axis axes[SALTUS_AXES_MAX];
    double *lists[SALTUS_AXES_MAX] = {NULL};
    int count = request->over.count;
    saltus_status status = SALTUS_OK;
    if (count > SALTUS_AXES_MAX)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "--over %.100s: only two axes can be given",
                             request->over.items[SALTUS_AXES_MAX]);
    for (int k = 0; k < count && status == SALTUS_OK; k++) {
        saltus_message reason = {.text = ""};
        status = saltus_axis_read(request->over.items[k], &axes[k], &lists[k], &reason);
        if (status != SALTUS_OK)
            saltus_fail(message, status, "--over %.490s", reason.text);
    }
    if (status == SALTUS_OK && options->adaptive && options->transient == 0)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "--at-most 0: must be at least 1");
    if (status == SALTUS_OK)
        status = saltus_sweep_new(scene, axes, count, options, sweep, message);
    for (int k = 0; k < SALTUS_AXES_MAX; k++)
        free(lists[k]);
    return status;
}
