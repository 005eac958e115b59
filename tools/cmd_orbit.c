/* saltus orbit: one periodic orbit by Newton's method, stable or not.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "orbit/options.h"
#include "progress.h"

static const cli_option periods = CLI_NUMBER(
    "--periods", "p", "period of the orbit, in forcing periods, without forcing in returns to the section", 0,
    1, 1e6);
static const cli_option transient = CLI_NUMBER(
    "--transient", "n", "without --from: periods of the flow before Newton's method begins", 200, 0, 1e12);
static const cli_option mirror =
    CLI_OPTION("--mirror", CLI_FLAG, NULL, "begin with the mirror image of the start");
static const cli_option verbose = CLI_OPTION("--verbose", CLI_FLAG, NULL, "Newton's residuals on stderr");

static const cli_option unstable =
    CLI_OPTION("--unstable", CLI_FLAG, NULL,
               "instead list all orbits, stable or not, of periods up to p (default 8) near the trajectory");

static void print_step(void *context, int iteration, double residual, const char *what) {
    (void)context;
    fprintf(stderr, "step %2d  residual %.3e  %s\n", iteration, residual, what);
}

static void show_share(void *context, double done, double all) {
    (void)context;
    progress_line("searching: %3.0f %%", 100 * done / all);
}

/* All orbits along a trajectory; in JSON one object per orbit and line, in the format of classify. */
static saltus_status harvest(const cli_request *request, const cli_setup *setup, const char **cut,
                             saltus_message *message) {
    const int longest = (int)cli_whole(request, "--periods");
    const bool json = cli_given(request, "--json");
    saltus_classify_options describing = saltus_classify_defaults();
    saltus_harvest_options how = request->harvest;
    saltus_harvest found = {0};
    how.longest = longest ? longest : how.longest;
    how.transient = cli_whole(request, "--transient");
    how.state = setup->start.state;
    how.progress.show = cli_shows_progress(request) ? show_share : NULL;
    saltus_status status = saltus_harvest_run(setup->system, &how, &found, message);
    cli_progress_end(request);
    if (status == SALTUS_OK && json && found.count == 0)
        fprintf(stderr,
                "saltus: orbit: no periodic orbit of a period up to %d T was found in %lld period%s\n",
                how.longest, found.periods, found.periods == 1 ? "" : "s");
    if (status == SALTUS_OK && !json)
        saltus_write_harvest_text(stdout, &setup->scene, setup->system, &found);
    describing.flow = how.flow;
    describing.flow.stop = NULL; /* write all orbits found even after an interruption */
    for (int k = 0; k < found.count && status == SALTUS_OK && json; k++) {
        saltus_motion motion = {0};
        status = saltus_motion_describe(setup->system, &found.orbits[k].orbit, &describing, &motion, message);
        if (status == SALTUS_OK)
            saltus_write_motion_json(stdout, &setup->scene, setup->system, &motion);
        saltus_motion_clear(&motion);
    }
    saltus_harvest_clear(&found);
    if (status == SALTUS_OK && interrupt_asked())
        *cut = "these are the orbits found so far";
    return status;
}

/* Newton's method from the settled trajectory, the file's orbit, or its mirror image. With forcing: an orbit
 * of `periods` forcing periods; without: one of as many returns to the section, or the orbit of --from, and
 * without periods an equilibrium. */
static saltus_status find_orbits(const cli_request *request, cli_setup *setup, const char **cut,
                                 saltus_message *message) {
    if (cli_given(request, "--unstable"))
        return harvest(request, setup, cut, message);
    const int given = (int)cli_whole(request, "--periods"), periods = given ? given : setup->start.periods;
    const bool forced = saltus_system_forced(setup->system), json = cli_given(request, "--json");
    const saltus_equilibrium_options resting = saltus_equilibrium_defaults();
    const saltus_start *start = &setup->start;
    saltus_classify_options describing = saltus_classify_defaults();
    saltus_orbit_options how = request->orbit;
    double *state = setup->start.state;
    saltus_equilibrium rest = {0};
    saltus_orbit orbit = {0};
    saltus_motion motion = {0};
    saltus_status status = SALTUS_OK;
    if (!periods && forced)
        return saltus_fail(message, SALTUS_BAD_INPUT, "orbit: needs --periods p, or --from an orbit");
    describing.flow = forced ? how.flow : request->harvest.flow;
    if (how.tolerance < 100 * how.flow.rtol)
        how.tolerance = 100 * how.flow.rtol;
    if (cli_given(request, "--verbose"))
        how.history = print_step;
    if (!cli_on_orbit(setup))
        status = saltus_motion_settle(setup->system, &request->orbit.flow, cli_whole(request, "--transient"),
                                      state, message);
    if (status == SALTUS_OK && cli_given(request, "--mirror"))
        status = saltus_motion_mirror(setup->system, &request->orbit.flow, state, message);
    if (status != SALTUS_OK)
        return status;
    if (!periods)
        status = saltus_equilibrium_find(setup->system, state, &resting, &rest, message);
    else if (!forced && start->own_period && periods == start->periods)
        status = saltus_motion_cycle(setup->system, state, &describing, &motion, message);
    else if (!forced)
        status = saltus_motion_returning(setup->system, state, periods, &describing, &motion, message);
    else
        status = saltus_orbit_find(setup->system, periods, state, &how, &orbit, message);
    if (status == SALTUS_OK && orbit.state)
        status = cli_same_orbit(request, setup, orbit.state, message);
    if (status == SALTUS_OK && orbit.state)
        status = saltus_motion_describe(setup->system, &orbit, &describing, &motion, message);
    if (status == SALTUS_OK && periods)
        cli_print_motion(request, setup, &motion);
    else if (status == SALTUS_OK)
        (json ? saltus_write_equilibrium_json : saltus_write_equilibrium_text)(stdout, &setup->scene,
                                                                               setup->system, &rest);
    saltus_equilibrium_clear(&rest);
    saltus_orbit_clear(&orbit);
    saltus_motion_clear(&motion);
    return status;
}

const cli_command cmd_orbit = {
    .name = "orbit",
    .summary = "find periodic orbits, stable or not",
    .usage = "SCENE [--set key=value ...] --periods p [--from orbit] [--unstable] [--json]",
    .help = "Find a periodic orbit by Newton's method and report it as classify does, stable or not. It "
            "begins with the scene's settled trajectory, or with the orbit of a file (of classify, orbit or "
            "continue --json, a branch, or a row of a sweep, run again unless its file keeps a state), whose "
            "parameters hold where --set does not say otherwise. With "
            "--unstable --json there is one orbit on each line; orbits.json:3 then names the third. Without "
            "forcing p counts returns to the section, as in classify, and the period is found too; without "
            "--periods an equilibrium is found, with its eigenvalues.",
    .needs_scene = true,
    .tables = CLI_TABLES(CLI_TABLE(saltus_orbit_table, orbit, NULL),
                         CLI_TABLE(saltus_harvest_table, harvest, NULL)),
    .options = CLI_OPTIONS(&cli_set, &cli_section, &periods, &cli_from, &transient, &mirror, &unstable,
                           &cli_json, &verbose),
    .examples = CLI_EXAMPLES(
        {"orbit impact-oscillator --periods 1 --json > orbit.json",
         "the orbit of period one, kept as a start"},
        {"orbit impact-oscillator --from orbit.json --set omega=1.01", "the same orbit at another frequency"},
        {"orbit impact-oscillator --periods 2 --unstable --search 500",
         "all orbits of one or two periods near the trajectory"}),
    .see = "classify continue",
    .work = find_orbits,
};
