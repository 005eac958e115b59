/* saltus diagnose: the one-page sheet about a motion.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include <unistd.h>

static const cli_option *const options[] = {&cli_set,        &cli_output,  &cli_data, &cli_transient,
                                            &cli_longest,    &cli_measure, &cli_rtol, &cli_atol,
                                            &cli_integrator, &cli_quiet,   NULL};

/* One orbit of a periodic motion; enough of the rest to see what it does. */
static saltus_status record_motion(const saltus_system *system, const saltus_flow_options *flow,
                                   const saltus_motion *motion, saltus_record *record,
                                   saltus_message *message) {
    enum { undecided_periods = 400, resting_periods = 4, samples = 240 };
    long long periods = motion->periods                  ? motion->periods
                        : !saltus_motion_settled(motion) ? undecided_periods
                                                         : resting_periods;
    return saltus_record_run(system, motion->state, flow, 0, periods, samples, record, message);
}

static int run(const cli_request *request) {
    saltus_scene scene;
    saltus_system *system;
    saltus_message message = {""};
    saltus_motion motion = {0};
    saltus_record record = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    if (!request->output) {
        fprintf(stderr, "saltus: diagnose: needs -o file.png, file.pdf or file.svg\n");
        return CLI_BAD_INPUT;
    }
    int code = cli_build(request, &scene, &system, state);
    if (code != CLI_DONE)
        return code;
    saltus_classify_options how = cli_classify_options(request);
    saltus_status status = saltus_classify(system, state, &how, &motion, &message);
    cli_progress_end(request);
    if (status == SALTUS_OK)
        status = record_motion(system, &how.flow, &motion, &record, &message);
    if (status == SALTUS_OK)
        status = saltus_write_sheet(&scene, system, &motion, &record, &how.flow, request->output,
                                    request->data, &message);
    if (status == SALTUS_OK) {
        saltus_write_motion_text(stdout, &scene, system, &motion);
        printf("figure: %s\n", request->output);
    }
    saltus_record_clear(&record);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return cli_report(status, &message);
}

const cli_command cmd_diagnose = {
    .name = "diagnose",
    .usage = "SCENE [--set key=value ...] -o sheet.png|pdf|svg [--data out.h5]",
    .help = "Classify the motion and draw it on one page: phase portrait with stroboscopic points and the "
            "stop, time\n"
            "history, impact map, shapes of the structure.",
    .needs_scene = true,
    .options = options,
    .run = run,
};
