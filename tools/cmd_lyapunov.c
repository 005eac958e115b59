/* saltus lyapunov: Lyapunov exponents with standard errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "motion/options.h"
#include "progress.h"

static const cli_option all = CLI_OPTION("--all", CLI_FLAG, NULL, "all exponents, not the largest one alone");

/* Show the progress of a measurement; `context` is its result. */
static void show(void *context, double done, double at_most) {
    const saltus_lyapunov *l = context;
    char found[64] = "";
    if (l->history_count > 0)
        snprintf(found, sizeof found, ", exponent %.5g +- %.2g", l->history[l->history_count - 1].exponent,
                 l->history[l->history_count - 1].standard_error);
    progress_line("%.0f %% of at most %.0f periods%s", 100 * done / at_most, at_most, found);
}

static saltus_status measure(const cli_request *request, cli_setup *setup, const char **cut,
                             saltus_message *message) {
    const int given = request->lyapunov.exponents, dimension = saltus_system_dimension(setup->system);
    const bool all = cli_given(request, "--all"), shown = cli_shows_progress(request),
               json = cli_given(request, "--json");
    saltus_lyapunov_options how = request->lyapunov;
    saltus_lyapunov result = {0};
    saltus_status status;
    bool interrupted = false;
    if (all)
        how.exponents = 0;
    if (all && cli_given(request, "--exponents"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "--all and --exponents %d: only one can be given",
                           given);
    if (how.exponents > dimension)
        return saltus_fail(message, SALTUS_BAD_INPUT, "--exponents %d: the scene has %d", given, dimension);
    if (cli_on_orbit(setup)) {
        /* The exponents of an orbit or an equilibrium follow from its multipliers or eigenvalues. */
        if (request->output)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "-o %.200s: the exponents of %s converge to nothing, they are those of its %s",
                               request->output, setup->start.rests ? "an equilibrium" : "an orbit",
                               setup->start.rests ? "eigenvalues" : "multipliers");
        saltus_classify_options describing = saltus_classify_defaults();
        saltus_motion motion = {0};
        describing.flow = how.flow;
        status = cli_orbit(request, setup, &describing, &motion, message);
        const int count = how.exponents ? how.exponents : saltus_system_dimension(setup->system);
        if (status == SALTUS_OK)
            status = saltus_motion_exponents(setup->system, &motion, &how.flow, count, &result, message);
        saltus_motion_clear(&motion);
    } else {
        how.progress = (saltus_progress){shown ? show : NULL, &result};
        if (shown)
            progress_line("settling: %lld periods", how.transient);
        status = saltus_lyapunov_run(setup->system, setup->start.state, &how, &result, message);
        interrupted = result.interrupted;
        cli_progress_end(request);
    }
    /* The numbers come first, so that they are not lost if the figure fails. */
    if (status == SALTUS_OK)
        (json ? saltus_write_lyapunov_json : saltus_write_lyapunov_text)(stdout, &setup->scene, setup->system,
                                                                         &how, &result);
    if (status == SALTUS_OK && request->output) {
        status = saltus_write_convergence(request->output, &setup->scene, setup->system, &how, &result,
                                          &request->look, message);
        if (!json)
            cli_tell_written(request, "convergence", status);
    }
    if (status == SALTUS_OK && interrupted)
        *cut = "the numbers rest on what was measured so far";
    saltus_lyapunov_clear(&result);
    return status;
}

const cli_command cmd_lyapunov = {
    .name = "lyapunov",
    .summary = "Lyapunov exponents with standard errors",
    .usage = "SCENE [--set key=value ...] [--from orbit] [--all | --exponents k] [--json] [-o "
             "convergence.png|pdf|svg|csv]",
    .help = "Measure Lyapunov exponents, per unit of time, of the motion that the scene settles on, with "
            "standard errors: how fast nearby trajectories separate (the largest one), sum rule and "
            "dimension (--all). They belong to the stroboscopic map; impacts, chatter and sticking are taken "
            "along exactly. -o shows how the estimate converged. With --from an orbit they are those of its "
            "multipliers, stable or not, without forcing with the zero along the flow; with --from an "
            "equilibrium the real parts of its eigenvalues. The errors then say how accurately these are "
            "known.",
    .needs_scene = true,
    .endings = cli_figures_or_table,
    .kind = "largest Lyapunov exponent",
    .tables = CLI_TABLES(CLI_TABLE(saltus_lyapunov_table, lyapunov, NULL)),
    .options =
        CLI_OPTIONS(&cli_set, &cli_section, &cli_from, &all, &cli_json, &cli_output, CLI_FIGURE_OPTIONS),
    .notes =
        "Tangent vectors pass impacts by saltation matrices, and chatter, sticking and release by their "
        "limit maps. Directions lost in a lasting contact have exponent -infinity, and are named so. The "
        "standard error comes of an autoregressive fit to batches, for regular motion of how far the sums "
        "swing; the run ends when the precision asked for is reached and its halves and trajectories agree, "
        "or, "
        "after a sixteenth of --periods, where the error hardly falls (by less than to 0.6 while the run "
        "grows "
        "eightfold): neighbours then separate in bursts, between quiet stretches of all lengths.",
    .examples = CLI_EXAMPLES({"lyapunov pipe --all", "all exponents, the sum rule and the dimension"},
                             {"lyapunov near-grazing --precision 0.05 -o convergence.png",
                              "the largest one to 5 %, and how it converged"}),
    .see = "classify spectrum",
    .work = measure,
};
