/* saltus lyapunov: Lyapunov exponents with standard errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "progress.h"

static const cli_option all = CLI_FLAG_OPTION("--all", all, "all exponents, not the largest one alone");
static const cli_option exponents =
    CLI_WHOLE_OPTION("--exponents", exponents, "k", 0, 1, 1000, "the k largest exponents (default 1)");
static const cli_option precision =
    CLI_REAL_OPTION("--precision", precision, "x", 0.01, 1e-9, 1,
                    "stop when the largest exponent's relative error is below x");
static const cli_option transient =
    CLI_WHOLE_OPTION("--transient", transient, "n", 1000, 0, 1e12, "periods before measuring");
static const cli_option periods =
    CLI_WHOLE_OPTION("--periods", periods, "n", 1e6, 1, 1e15, "periods measured at most, all together");
static const cli_option members =
    CLI_WHOLE_OPTION("--members", members, "m", 8, 1, 64, "trajectories that share the work");
static const cli_option interval =
    CLI_REAL_OPTION("--interval", interval, "x", 0, 0, 1000,
                    "periods between orthonormalisations; 0: chosen from the growth");
static const cli_option seed =
    CLI_WHOLE_OPTION("--seed", seed, "s", 0, 0, 4294967295.0,
                     "seed of the first directions; other than 0 the start is disturbed, too");
static const cli_option *const options[] = {
    &cli_set,    &cli_from,          &all,  &exponents, &precision,      &transient,      &periods,
    &members,    &interval,          &seed, &cli_json,  &cli_loose_rtol, &cli_loose_atol, &cli_integrator,
    &cli_output, CLI_FIGURE_OPTIONS, NULL};

/* A measurement under way. */
typedef struct watch {
    saltus_lyapunov result;
    bool shown; /* a line on the terminal */
    bool interrupted;
} watch;

static bool show(void *context, long long done, long long at_most) {
    watch *w = context;
    const saltus_lyapunov *l = &w->result;
    w->interrupted = interrupt_asked();
    if (w->shown) {
        char found[64] = "";
        if (l->history_count > 0)
            snprintf(found, sizeof found, ", exponent %.5g +- %.2g",
                     l->history[l->history_count - 1].exponent,
                     l->history[l->history_count - 1].standard_error);
        progress_line("measuring: %lld of at most %lld periods%s", done, at_most, found);
    }
    return !w->interrupted;
}

static saltus_status choose(const cli_request *request, const saltus_system *system, watch *w,
                            saltus_lyapunov_options *how, saltus_message *message) {
    int n = saltus_system_dimension(system);
    *how = saltus_lyapunov_defaults();
    how->flow = cli_flow_options(request);
    how->flow.stop = NULL; /* what was measured is wanted: `show` ends the measurement */
    how->exponents = request->all ? 0 : request->exponents ? (int)request->exponents : 1;
    how->members = (int)request->members;
    how->transient = request->transient;
    how->periods = request->periods;
    how->precision = request->precision;
    how->interval = request->interval;
    how->seed = (unsigned long)request->seed;
    how->progress = show;
    how->context = w;
    if (request->all && request->exponents)
        return saltus_fail(message, SALTUS_BAD_INPUT, "--all and --exponents %ld: only one can be given",
                           request->exponents);
    if (request->exponents > n)
        return saltus_fail(message, SALTUS_BAD_INPUT, "--exponents %ld: the scene has %d", request->exponents,
                           n);
    return SALTUS_OK;
}

/* The numbers first: a figure that cannot be drawn does not take them along. */
static saltus_status deliver(const cli_request *request, const cli_setup *setup,
                             const saltus_lyapunov_options *how, const saltus_lyapunov *result,
                             const saltus_figure_options *look, saltus_message *message) {
    (request->json ? saltus_write_lyapunov_json : saltus_write_lyapunov_text)(stdout, &setup->scene,
                                                                              setup->system, how, result);
    if (!request->output)
        return SALTUS_OK;
    saltus_status status =
        saltus_write_convergence(&setup->scene, setup->system, how, result, look, request->output, message);
    if (status == SALTUS_OK && !request->json)
        cli_tell_written(request, "convergence");
    return status;
}

/* With --from an orbit: its exponents are known from its multipliers. */
static saltus_status run_orbit(const cli_request *request, const cli_setup *setup,
                               const saltus_lyapunov_options *how, saltus_lyapunov *result,
                               saltus_message *message) {
    saltus_classify_options describing = saltus_classify_defaults();
    saltus_motion motion;
    if (request->output)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "-o %.200s: the exponents of an orbit converge to nothing, they are those of its "
                           "multipliers",
                           request->output);
    describing.flow = how->flow;
    describing.flow.stop = interrupt_flag();
    saltus_status status = cli_motion(request, setup, &describing, &motion, message);
    int count = how->exponents ? how->exponents : saltus_system_dimension(setup->system);
    if (status == SALTUS_OK)
        status = saltus_motion_exponents(setup->system, &motion, count, result, message);
    saltus_motion_clear(&motion);
    return status;
}

static int run(const cli_request *request) {
    cli_setup setup;
    saltus_message message = {.text = ""};
    saltus_lyapunov_options how;
    watch w = {.shown = cli_shows_progress(request)};
    saltus_figure_options look;
    if (!cli_figure_options(request, &look))
        return CLI_BAD_INPUT;
    int code = cli_build(request, &setup);
    if (code != CLI_DONE)
        return code;
    saltus_status status = choose(request, setup.system, &w, &how, &message);
    if (status == SALTUS_OK && cli_on_orbit(&setup))
        status = run_orbit(request, &setup, &how, &w.result, &message);
    else if (status == SALTUS_OK) {
        if (w.shown)
            progress_line("settling: %lld periods", how.transient);
        status = saltus_lyapunov_run(setup.system, setup.start.state, &how, &w.result, &message);
        if (w.shown)
            progress_line("%s", "");
    }
    if (status == SALTUS_OK)
        status = deliver(request, &setup, &how, &w.result, &look, &message);
    if (status == SALTUS_OK && w.interrupted)
        code = interrupt_report("the numbers rest on what was measured so far");
    saltus_lyapunov_clear(&w.result);
    saltus_system_free(setup.system);
    return status == SALTUS_OK ? code : cli_report(status, &message);
}

const cli_command cmd_lyapunov = {
    .name = "lyapunov",
    .usage = "SCENE [--set key=value ...] [--from orbit] [--all | --exponents k] [--json] [-o "
             "convergence.png|pdf|svg|csv]",
    .help = "Measure Lyapunov exponents, per unit of time, of the motion that the scene settles on, with "
            "standard errors:\n"
            "how fast nearby trajectories separate (the largest one), sum rule and dimension (--all). They "
            "belong to the\n"
            "stroboscopic map; impacts, chatter and sticking are taken along exactly. -o shows how the "
            "estimate converged.\n"
            "With --from an orbit they are those of its multipliers, stable or not.",
    .needs_scene = true,
    .endings = cli_figures_or_table,
    .options = options,
    .run = run,
};
