/* saltus lyapunov: Lyapunov exponents with standard errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"

#include <math.h>
#include <unistd.h>

#define PLACE(member) offsetof(cli_request, member)

static const cli_option all = {"--all", CLI_FLAG, PLACE(all), 0,
                               0,       0,        NULL,       "all exponents, not the largest one alone"};
static const cli_option exponents = {
    "--exponents", CLI_WHOLE, PLACE(exponents), 0, 1, 1000, "k", "the k largest exponents (default 1)"};
static const cli_option precision = {"--precision",
                                     CLI_REAL,
                                     PLACE(precision),
                                     0.01,
                                     1e-9,
                                     1,
                                     "x",
                                     "stop when the largest exponent's relative error is below x"};
static const cli_option transient = {"--transient", CLI_WHOLE, PLACE(transient),          1000, 0,
                                     1e12,          "n",       "periods before measuring"};
static const cli_option periods = {
    "--periods", CLI_WHOLE, PLACE(periods), 1e6, 1, 1e15, "n", "periods measured at most, all together"};
static const cli_option members = {
    "--members", CLI_WHOLE, PLACE(members), 8, 1, 64, "m", "trajectories that share the work"};
static const cli_option interval = {"--interval",
                                    CLI_REAL,
                                    PLACE(interval),
                                    0,
                                    0,
                                    1000,
                                    "x",
                                    "periods between orthonormalisations; 0: chosen from the growth"};
static const cli_option seed = {
    "--seed",    CLI_WHOLE,
    PLACE(seed), 0,
    0,           4294967295.0,
    "s",         "seed of the first directions; other than 0 the start is disturbed, too"};
static const cli_option rtol = {"--rtol", CLI_REAL, PLACE(rtol), 1e-10,
                                1e-15,    1e-3,     "x",         "relative tolerance of the flow"};
static const cli_option atol = {
    "--atol", CLI_REAL, PLACE(atol), 1e-14, 0, 1, "x", "absolute tolerance of the flow, in displacements"};

static const cli_option *const options[] = {
    &cli_set, &all,      &exponents, &precision, &transient, &periods,        &members,    &interval,
    &seed,    &cli_json, &cli_quiet, &rtol,      &atol,      &cli_integrator, &cli_output, NULL};

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
        fprintf(stderr, "\rmeasuring: %lld of at most %lld periods", done, at_most);
        if (l->history_count > 0)
            fprintf(stderr, ", exponent %.5g +- %.2g", l->history[l->history_count - 1].exponent,
                    l->history[l->history_count - 1].standard_error);
        fputs("\033[K", stderr);
        fflush(stderr);
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

static saltus_status measure(const saltus_system *system, const double *state,
                             const saltus_lyapunov_options *how, watch *w, saltus_message *message) {
    if (w->shown)
        fprintf(stderr, "settling: %lld periods", how->transient);
    saltus_status status = saltus_lyapunov_run(system, state, how, &w->result, message);
    if (w->shown)
        fputs("\r\033[K", stderr);
    return status;
}

/* The numbers first: a figure that cannot be drawn does not take them along. */
static saltus_status deliver(const cli_request *request, const saltus_scene *scene,
                             const saltus_system *system, const saltus_lyapunov_options *how,
                             const saltus_lyapunov *result, saltus_message *message) {
    (request->json ? saltus_write_lyapunov_json : saltus_write_lyapunov_text)(stdout, scene, system, how,
                                                                              result);
    if (!request->output)
        return SALTUS_OK;
    saltus_status status = saltus_write_convergence(scene, system, how, result, request->output, message);
    if (status == SALTUS_OK && !request->json)
        printf("convergence: %s\n", request->output);
    return status;
}

static int run(const cli_request *request) {
    saltus_scene scene;
    saltus_system *system;
    saltus_message message = {""};
    saltus_lyapunov_options how;
    watch w = {.shown = !request->quiet && isatty(STDERR_FILENO) == 1};
    double state[SALTUS_SCENE_STATE_MAX];
    int code = cli_build(request, &scene, &system, state);
    if (code != CLI_DONE)
        return code;
    saltus_status status = choose(request, system, &w, &how, &message);
    if (status == SALTUS_OK && request->output)
        status = saltus_convergence_check(request->output, &message);
    if (status == SALTUS_OK)
        status = measure(system, state, &how, &w, &message);
    if (status == SALTUS_OK)
        status = deliver(request, &scene, system, &how, &w.result, &message);
    if (status == SALTUS_OK && w.interrupted)
        code = interrupt_report("the numbers rest on what was measured so far");
    saltus_lyapunov_clear(&w.result);
    saltus_system_free(system);
    return status == SALTUS_OK ? code : cli_report(status, &message);
}

const cli_command cmd_lyapunov = {
    .name = "lyapunov",
    .usage = "SCENE [--set key=value ...] [--all | --exponents k] [--json] [-o convergence.png|pdf|svg|csv]",
    .help = "Measure Lyapunov exponents, per unit of time, of the motion that the scene settles on, with "
            "standard errors:\n"
            "how fast nearby trajectories separate (the largest one), sum rule and dimension (--all). They "
            "belong to the\n"
            "stroboscopic map; impacts, chatter and sticking are taken along exactly. -o shows how the "
            "estimate converged.",
    .needs_scene = true,
    .options = options,
    .run = run,
};
