/* saltus simulate: a trajectory as a file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "base/progress.h"
#include "flow/options.h"
#include "progress.h"

static const cli_option periods = CLI_NUMBER(
    "--periods", "n",
    "forcing periods to record; without forcing units of time, or with --from periods of the orbit", 0, 1,
    1e6);
static const cli_option transient =
    CLI_NUMBER("--transient", "m", "as many to run before the recording", 0, 0, 1e12);
static const cli_option samples =
    CLI_NUMBER("--samples", "k", "samples per forcing period, without forcing per unit of time", 200, 1, 1e5);

static void show(void *context, double periods, double all) {
    static const double pause = 0.1; /* seconds between two lines */
    double *told = context, now = saltus_seconds();
    if (*told == 0 || now - *told > pause) {
        progress_line("%.0f of %.0f periods", periods, all);
        *told = now;
    }
}

static saltus_status simulate(const cli_request *request, cli_setup *setup, const char **cut,
                              saltus_message *message) {
    const long recorded = cli_whole(request, "--periods"), waited = cli_whole(request, "--transient");
    const saltus_flow_options flow = request->flow;
    saltus_classify_options describing = saltus_classify_defaults();
    saltus_trajectory record = {0};
    saltus_motion motion = {0};
    saltus_status status = SALTUS_OK;
    cli_origin origin = {.command = NULL};
    double told = 0;
    describing.flow = flow;
    if (!request->output || !recorded)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "simulate: needs --periods n and -o file.h5 or file.csv");
    if (cli_on_orbit(setup) && waited)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "--transient %ld: not with --from %s, on which there is nothing to wait for",
                           waited, setup->start.rests ? "an equilibrium" : "an orbit");
    if (cli_on_orbit(setup))
        status = cli_orbit(request, setup, &describing, &motion, message);
    /* An equilibrium repeats after any time. */
    const saltus_trajectory_plan plan = {.points = motion.periods ? motion.section_states : motion.state,
                                         .orbit = motion.eigenvalues ? 1 : motion.periods,
                                         .transient = waited,
                                         .periods = recorded,
                                         .per_period = (int)cli_whole(request, "--samples"),
                                         .progress = {cli_shows_progress(request) ? show : NULL, &told}};
    if (status == SALTUS_OK)
        status = saltus_trajectory_follow(setup->system, setup->start.state, &flow, &plan, &record, message);
    const bool ended_early = status == SALTUS_INTERRUPTED && record.samples > 0;
    if (cli_shows_progress(request) && (status == SALTUS_OK || ended_early))
        progress_line(ended_early ? "interrupted, writing ..." : "writing ...");
    if (status == SALTUS_OK || ended_early)
        status = cli_origin_new(request, &origin, message);
    if (status == SALTUS_OK)
        status = saltus_write_trajectory(request->output, &setup->scene, setup->system, &flow, &record,
                                         &origin.told, message);
    cli_progress_end(request);
    cli_origin_clear(&origin);
    if (status == SALTUS_OK && !cli_given(request, "--quiet") && !request->to_stdout)
        printf("%s: %lld sample%s, %lld event%s over %.9g %s\n", request->output, record.samples,
               record.samples == 1 ? "" : "s", record.event_count, record.event_count == 1 ? "" : "s",
               record.time[record.samples - 1],
               !saltus_system_forced(setup->system)   ? "T"
               : record.time[record.samples - 1] == 1 ? "period"
                                                      : "periods");
    saltus_trajectory_clear(&record);
    saltus_motion_clear(&motion);
    if (status == SALTUS_OK && ended_early)
        *cut = "the file holds what was simulated so far";
    return status;
}

const cli_command cmd_simulate = {
    .name = "simulate",
    .summary = "a trajectory as a file",
    .usage = "SCENE [--set key=value ...] [--from orbit] --periods n [--transient m] -o run.h5|csv",
    .help =
        "Run the flow from the scene's initial state and write states, events and stroboscopic points. "
        "With --from an orbit or an equilibrium the record stays on it, stable or not; with a sweep's row "
        "without a period it begins on the row's motion.",
    .needs_scene = true,
    .endings = cli_records,
    .kind = "trajectory",
    .tables = CLI_TABLES(CLI_TABLE(saltus_flow_table, flow, NULL)),
    .options = CLI_OPTIONS(&cli_set, &cli_section, &cli_from, &periods, &transient, &samples, &cli_output),
    .examples = CLI_EXAMPLES(
        {"simulate impact-oscillator --periods 20 -o run.csv",
         "samples and events of 20 periods of the forcing as a table"},
        {"simulate two-mass --periods 5 --transient 500 -o run.h5", "after 500 periods, as HDF5"},
        {"plot run.h5 -o run.png", "draw it"}),
    .see = "plot export orbit",
    .work = simulate,
};
