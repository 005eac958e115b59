/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_options.h"

#include "ranks.h"

#include <stdlib.h>
#include <string.h>

#define PLACE(member) offsetof(cli_request, member)

const cli_option sweep_over = {
    "--over",
    CLI_LIST,
    PLACE(over),
    0,
    0,
    0,
    "key=values",
    "an axis: key=lo:hi:n, key=lo:hi:n:log or key=v1,v2,...; once or twice, the first runs fastest"};
const cli_option sweep_at_most = {
    "--at-most", CLI_WHOLE, PLACE(most), 2000,
    1,           1e9,       "n",         "periods to wait at most until the least period is certain"};
const cli_option sweep_record = {
    "--record", CLI_WHOLE, PLACE(record), 100, 1, 1e9, "k", "periods recorded of a motion without a period"};
const cli_option sweep_longest = {
    "--longest", CLI_WHOLE, PLACE(longest), 20, 1, 256, "p", "longest period looked for"};
const cli_option sweep_lanes = {
    "--lanes", CLI_WHOLE, PLACE(lanes), -1, 1, 64, "k", "trajectories side by side on a core, at most"};
const cli_option sweep_threads = {"--threads",
                                  CLI_WHOLE,
                                  PLACE(threads),
                                  -1,
                                  1,
                                  4096,
                                  "k",
                                  "threads, of each process where several run together (default: all cores)"};
const cli_option sweep_rtol = {"--rtol", CLI_REAL, PLACE(rtol), 1e-10,
                               1e-15,    1e-3,     "x",         "relative tolerance of the flow"};
const cli_option sweep_atol = {
    "--atol", CLI_REAL, PLACE(atol), 1e-14, 0, 1, "x", "absolute tolerance of the flow, in displacements"};
const cli_option sweep_resume = {
    "--resume", CLI_FLAG, PLACE(resume), 0, 0, 0, NULL, "go on with the interrupted run in the file of -o"};
const cli_option sweep_json = {"--json", CLI_FLAG, PLACE(json), 0,
                               0,        0,        NULL,        "a summary as one JSON object on stdout"};

saltus_sweep_options sweep_read_options(const cli_request *request) {
    saltus_sweep_options o = saltus_sweep_defaults();
    int order = o.flow.order;
    o.flow = cli_flow_options(request);
    o.flow.order = order;
    o.transient = request->most;
    o.record = request->record;
    o.longest = (int)request->longest;
    o.lanes = request->lanes > 0 ? (int)request->lanes : 0;
    o.threads = request->threads > 0 ? (int)request->threads : ranks_threads();
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
        saltus_message reason = {""};
        status = saltus_axis_read(request->over.items[k], &axes[k], &lists[k], &reason);
        if (status != SALTUS_OK)
            saltus_fail(message, status, "--over %.490s", reason.text);
    }
    if (status == SALTUS_OK)
        status = saltus_sweep_new(scene, axes, count, options, sweep, message);
    for (int k = 0; k < SALTUS_AXES_MAX; k++)
        free(lists[k]);
    return status;
}
