/* saltus orbit: one periodic orbit by Newton's method, stable or not.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"

#include <unistd.h>

#define PLACE(member) offsetof(cli_request, member)

static const cli_option periods = {
    "--periods", CLI_WHOLE, PLACE(periods), 0, 1, 1e6, "p", "period of the orbit, in forcing periods"};
static const cli_option transient = {"--transient",
                                     CLI_WHOLE,
                                     PLACE(transient),
                                     200,
                                     0,
                                     1e12,
                                     "n",
                                     "without --from: periods of the flow before Newton's method begins"};
static const cli_option mirror = {
    "--mirror", CLI_FLAG, PLACE(mirror), 0, 0, 0, NULL, "begin with the mirror image of the start"};
static const cli_option segments = {
    "--segments", CLI_WHOLE, PLACE(segments), 0, 0, 100000, "k", "shooting segments; 0: chosen"};
static const cli_option verbose = {"--verbose", CLI_FLAG, PLACE(verbose), 0,
                                   0,           0,        NULL,           "Newton's residuals on stderr"};

static const cli_option unstable = {
    "--unstable",
    CLI_FLAG,
    PLACE(unstable),
    0,
    0,
    0,
    NULL,
    "instead list all orbits, stable or not, of periods up to p (default 8) near the trajectory"};
static const cli_option search = {
    "--search", CLI_WHOLE, PLACE(search), 5000,
    10,         1e9,       "n",           "with --unstable: periods searched for close returns"};
static const cli_option most = {"--most", CLI_WHOLE, PLACE(most), 1000,
                                1,        1e6,       "m",         "with --unstable: orbits at most"};

static const cli_option *const options[] = {&cli_set,  &periods,  &cli_from, &transient,      &mirror,
                                            &unstable, &search,   &most,     &segments,       &cli_json,
                                            &verbose,  &cli_rtol, &cli_atol, &cli_integrator, NULL};

static void print_step(void *context, int iteration, double residual, const char *what) {
    (void)context;
    fprintf(stderr, "step %2d  residual %.3e  %s\n", iteration, residual, what);
}

static saltus_orbit_options shooting_options(const cli_request *request) {
    saltus_orbit_options how = saltus_orbit_defaults();
    how.flow = cli_flow_options(request);
    how.segments = (int)request->segments;
    if (how.tolerance < 100 * how.flow.rtol)
        how.tolerance = 100 * how.flow.rtol;
    if (request->verbose)
        how.history = print_step;
    return how;
}

/* Where Newton's method begins: the settled trajectory or the file's orbit, or its mirror image. */
static saltus_status prepare(const cli_request *request, const saltus_system *system, double *state,
                             saltus_message *message) {
    saltus_flow_options flow = cli_flow_options(request);
    saltus_status status = SALTUS_OK;
    if (!request->from)
        status = saltus_motion_settle(system, &flow, request->transient, state, message);
    if (status == SALTUS_OK && request->mirror)
        status = saltus_motion_mirror(system, &flow, state, message);
    return status;
}

static saltus_status find(const cli_request *request, const saltus_scene *scene, const saltus_system *system,
                          int p, const double *state, saltus_message *message) {
    saltus_orbit_options how = shooting_options(request);
    saltus_classify_options describing = saltus_classify_defaults();
    saltus_orbit orbit = {0};
    saltus_motion motion = {0};
    describing.flow = how.flow;
    saltus_status status = saltus_orbit_find(system, p, state, &how, &orbit, message);
    if (status == SALTUS_OK)
        status = saltus_motion_describe(system, &orbit, &describing, &motion, message);
    if (status == SALTUS_OK)
        (request->json ? saltus_write_motion_json : saltus_write_motion_text)(stdout, scene, system, &motion);
    saltus_motion_clear(&motion);
    saltus_orbit_clear(&orbit);
    return status;
}

/* A scene without forcing rests. */
static saltus_status find_rest(const cli_request *request, const saltus_scene *scene,
                               const saltus_system *system, const double *state, saltus_message *message) {
    saltus_equilibrium_options how = saltus_equilibrium_defaults();
    saltus_equilibrium rest = {0};
    saltus_status status = saltus_equilibrium_find(system, state, &how, &rest, message);
    if (status == SALTUS_OK)
        (request->json ? saltus_write_equilibrium_json : saltus_write_equilibrium_text)(stdout, scene, system,
                                                                                        &rest);
    saltus_equilibrium_clear(&rest);
    return status;
}

static bool show_share(void *context, double done) {
    (void)context;
    fprintf(stderr, "\rsearching: %3.0f %%", 100 * done);
    fflush(stderr);
    return true;
}

/* One JSON object per line and orbit, as classify writes it. */
static saltus_status write_lines(const saltus_scene *scene, const saltus_system *system,
                                 const saltus_flow_options *flow, const saltus_harvest *harvest,
                                 saltus_message *message) {
    saltus_classify_options describing = saltus_classify_defaults();
    saltus_status status = SALTUS_OK;
    describing.flow = *flow;
    describing.flow.stop = NULL; /* what has been found is told */
    for (int k = 0; k < harvest->count && status == SALTUS_OK; k++) {
        saltus_motion motion = {0};
        status = saltus_motion_describe(system, &harvest->orbits[k].orbit, &describing, &motion, message);
        if (status == SALTUS_OK)
            saltus_write_motion_json(stdout, scene, system, &motion);
        saltus_motion_clear(&motion);
    }
    return status;
}

static saltus_status harvest(const cli_request *request, const saltus_scene *scene,
                             const saltus_system *system, const double *state, saltus_message *message) {
    saltus_harvest_options how = saltus_harvest_defaults();
    saltus_harvest found = {0};
    bool terminal = isatty(STDERR_FILENO);
    how.flow = cli_flow_options(request);
    how.longest = request->periods ? (int)request->periods : how.longest;
    how.transient = request->transient;
    how.periods = request->search;
    how.most = (int)request->most;
    how.state = state;
    how.progress = terminal ? show_share : NULL;
    saltus_status status = saltus_harvest_run(system, &how, &found, message);
    if (terminal)
        fprintf(stderr, "\r%20s\r", "");
    if (status == SALTUS_OK && request->json)
        status = write_lines(scene, system, &how.flow, &found, message);
    else if (status == SALTUS_OK)
        saltus_write_harvest_text(stdout, scene, system, &found);
    saltus_harvest_clear(&found);
    return status;
}

static int run(const cli_request *request) {
    saltus_scene scene;
    saltus_system *system;
    saltus_message message = {""};
    saltus_start start = {.periods = 0};
    int code = request->from ? cli_build_from(request, &scene, &system, &start)
                             : cli_build(request, &scene, &system, start.state);
    if (code != CLI_DONE)
        return code;
    bool forced = saltus_system_forced(system);
    int p = request->periods ? (int)request->periods : start.periods;
    saltus_status status = SALTUS_OK;
    if (!p && forced && !request->unstable)
        status = saltus_fail(&message, SALTUS_BAD_INPUT, "orbit: needs --periods p, or --from an orbit");
    if (status == SALTUS_OK && !request->unstable)
        status = prepare(request, system, start.state, &message);
    if (status == SALTUS_OK)
        status = request->unstable ? harvest(request, &scene, system, start.state, &message)
                 : forced          ? find(request, &scene, system, p, start.state, &message)
                                   : find_rest(request, &scene, system, start.state, &message);
    saltus_system_free(system);
    if (status == SALTUS_OK && request->unstable && interrupt_asked())
        return interrupt_report("these are the orbits found so far");
    return cli_report(status, &message);
}

const cli_command cmd_orbit = {
    .name = "orbit",
    .usage = "SCENE [--set key=value ...] --periods p [--from orbit] [--unstable] [--json]",
    .help = "Find a periodic orbit by Newton's method and report it as classify does, stable or not. It "
            "begins with the\n"
            "scene's settled trajectory, or with the orbit of a file (of classify, orbit or continue --json, "
            "or a branch),\n"
            "whose parameters hold where --set does not say otherwise. With --unstable --json there is one "
            "orbit on each\n"
            "line; orbits.json:3 then names the third.",
    .needs_scene = true,
    .options = options,
    .run = run,
};
