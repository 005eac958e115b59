/* saltus classify: what does the system settle on?
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"

static const cli_option *const options[] = {&cli_set,       &cli_json,       &cli_seeds,   &cli_seed,
                                            &cli_transient, &cli_longest,    &cli_measure, &cli_rtol,
                                            &cli_atol,      &cli_integrator, &cli_quiet,   NULL};

static saltus_status classify_once(const cli_request *request, const saltus_scene *scene,
                                   const saltus_system *system, const double *state, bool *cut,
                                   saltus_message *message) {
    saltus_classify_options how = cli_classify_options(request);
    saltus_motion motion;
    saltus_status status = saltus_classify(system, state, &how, &motion, message);
    cli_progress_end(request);
    if (status != SALTUS_OK)
        return status;
    (request->json ? saltus_write_motion_json : saltus_write_motion_text)(stdout, scene, system, &motion);
    *cut = interrupt_asked() && motion.verdict == SALTUS_UNDECIDED;
    saltus_motion_clear(&motion);
    return SALTUS_OK;
}

static saltus_status classify_seeds(const cli_request *request, const saltus_scene *scene,
                                    const saltus_system *system, bool *cut, saltus_message *message) {
    saltus_classify_options how = cli_classify_options(request);
    saltus_attractors found;
    saltus_status status = saltus_attractors_find(system, (int)request->seeds, (unsigned long)request->seed,
                                                  &how, &found, message);
    cli_progress_end(request);
    if (status != SALTUS_OK)
        return status;
    saltus_write_attractors(stdout, scene, system, &found, request->json);
    *cut = found.seeds < request->seeds;
    saltus_attractors_clear(&found);
    return SALTUS_OK;
}

static int run(const cli_request *request) {
    saltus_scene scene;
    saltus_system *system;
    saltus_message message = {""};
    double state[SALTUS_SCENE_STATE_MAX];
    int code = cli_build(request, &scene, &system, state);
    if (code != CLI_DONE)
        return code;
    bool cut = false;
    saltus_status status = request->seeds ? classify_seeds(request, &scene, system, &cut, &message)
                                          : classify_once(request, &scene, system, state, &cut, &message);
    saltus_system_free(system);
    if (status == SALTUS_OK && cut)
        return interrupt_report("this is what was found so far");
    return cli_report(status, &message);
}

const cli_command cmd_classify = {
    .name = "classify",
    .usage = "SCENE [--set key=value ...] [--json] [--seeds k]",
    .help = "Settle on the attractor, find its least period, polish the orbit by Newton's method and report "
            "n/p, contacts,\n"
            "events, multipliers, stability and symmetry.",
    .needs_scene = true,
    .options = options,
    .run = run,
};
