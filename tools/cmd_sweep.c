/* saltus sweep: many trajectories over one or two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"
#include "sweep_options.h"
#include "sweep_print.h"

#include <string.h>

#define PLACE(member) offsetof(cli_request, member)

static const cli_option transient = {
    "--transient",
    CLI_WHOLE,
    PLACE(transient),
    -1,
    0,
    1e9,
    "m",
    "run so many periods and record --record further ones, whatever the motion"};
static const cli_option seeds = {"--seeds", CLI_WHOLE, PLACE(seeds), 1,
                                 1,         10000,     "k",          "initial states at each point"};
static const cli_option start = {"--start",
                                 CLI_TEXT,
                                 PLACE(start),
                                 0,
                                 0,
                                 0,
                                 "how",
                                 "reset (each point anew), carry (from point to point, up and down), "
                                 "both (default reset)"};
static const cli_option what = {
    "--what",
    CLI_TEXT,
    PLACE(what),
    0,
    0,
    0,
    "list",
    "kept beside the rows: turning, impacts, stroboscopic, lyapunov; class and max are always told "
    "(default turning,impacts over one axis, class over two)"};

static const cli_option measure = {
    "--measure",
    CLI_WHOLE,
    PLACE(measure),
    8000,
    0,
    1e9,
    "n",
    "with --what lyapunov: periods at most to measure a motion without a period; chaos is asserted from an "
    "eighth of them on (at least 500), 0: undecided"};

static const cli_option *const options[] = {
    &cli_set,       &sweep_over, &start,        &seeds,      &cli_seed,   &what,           &sweep_at_most,
    &sweep_longest, &transient,  &sweep_record, &measure,    &cli_output, &sweep_resume,   &sweep_lanes,
    &sweep_threads, &cli_quiet,  &sweep_json,   &sweep_rtol, &sweep_atol, &cli_integrator, NULL};

/* A word of a list with commas, and the bits that it stands for. */
typedef struct word {
    const char *text;
    unsigned bits;
} word;

static bool take_word(const word *known, int count, const char *text, size_t length, unsigned *bits) {
    for (int k = 0; k < count; k++)
        if (strlen(known[k].text) == length && strncmp(known[k].text, text, length) == 0) {
            *bits |= known[k].bits;
            return true;
        }
    return false;
}

static bool read_what(const char *text, unsigned *keep) {
    static const word known[] = {{"turning", SALTUS_KEEP_TURNING},
                                 {"impacts", SALTUS_KEEP_IMPACTS},
                                 {"stroboscopic", SALTUS_KEEP_STROBOSCOPIC},
                                 {"lyapunov", SALTUS_KEEP_LYAPUNOV},
                                 {"class", 0},
                                 {"max", 0}};
    *keep = 0;
    for (const char *c = text; c;) {
        size_t length = strcspn(c, ",");
        if (!take_word(known, sizeof known / sizeof known[0], c, length, keep)) {
            fprintf(
                stderr,
                "saltus: --what %s: must be a list of turning, impacts, stroboscopic, class, lyapunov and "
                "max with commas between them\n",
                text);
            return false;
        }
        c = c[length] ? c + length + 1 : NULL;
    }
    return true;
}

static bool read_start(const char *text, unsigned *passes) {
    static const word known[] = {{"reset", 1u << SALTUS_PASS_RESET},
                                 {"carry", 1u << SALTUS_PASS_UP | 1u << SALTUS_PASS_DOWN},
                                 {"both", (1u << SALTUS_PASSES) - 1}};
    *passes = 0;
    if (!text)
        text = known[0].text;
    if (take_word(known, sizeof known / sizeof known[0], text, strlen(text), passes))
        return true;
    fprintf(stderr, "saltus: --start %s: must be reset, carry or both\n", text);
    return false;
}

/* What nobody has chosen: the diagrams of one parameter, the names of motions over two. A table of rows has
 * room for nothing else. */
static unsigned usual_clouds(const cli_request *request, const saltus_scene *scene) {
    const char *ending = strrchr(request->output, '.');
    if (request->over.count > 1 || (ending && strcmp(ending, ".csv") == 0))
        return 0;
    return SALTUS_KEEP_TURNING | (scene->spec.stop_count ? SALTUS_KEEP_IMPACTS : 0);
}

/* The options from the command line; false after a message. */
static bool read_options(const cli_request *request, saltus_sweep_options *o) {
    if (!request->over.count || !request->output) {
        fprintf(stderr, "saltus: sweep: needs --over key=lo:hi:n and -o file.h5 or file.csv\n");
        return false;
    }
    if (request->transient >= 0 && request->most != (long)sweep_at_most.fallback) {
        fprintf(stderr, "saltus: --at-most and --transient: one of them; with --transient every trajectory "
                        "runs for a fixed time\n");
        return false;
    }
    *o = sweep_read_options(request);
    o->seeds = (int)request->seeds;
    o->seed = (unsigned long)request->seed;
    o->measure = request->measure;
    o->adaptive = request->transient < 0;
    if (!o->adaptive)
        o->transient = request->transient;
    return read_what(request->what, &o->keep) && read_start(request->start, &o->passes);
}

static int run(const cli_request *request) {
    saltus_scene scene;
    saltus_sweep *sweep = NULL;
    saltus_sweep_options how;
    saltus_message message = {""};
    if (!read_options(request, &how))
        return CLI_BAD_INPUT;
    saltus_status status = cli_load_scene(request, &scene, &message);
    if (status == SALTUS_OK && !request->what)
        how.keep = usual_clouds(request, &scene);
    if (status == SALTUS_OK)
        status = sweep_make(request, &scene, &how, &sweep, &message);
    sweep_order order = {
        .sweep = sweep, .path = request->output, .resume = request->resume, .quiet = request->quiet};
    int code = sweep_finish(&order, status, request->json, &message);
    saltus_sweep_free(sweep);
    return code;
}

const cli_command cmd_sweep = {
    .name = "sweep",
    .usage = "SCENE [--set key=value ...] --over omega=lo:hi:n [--over d=lo:hi:n] -o sweep.h5|csv",
    .help =
        "Run trajectories over a grid of one or two parameters (or entries of the initial state), on all "
        "cores and,\n"
        "started by mpirun, on many machines; classify each and keep what its diagrams need. A "
        "trajectory is\n"
        "recorded as soon as its least period is certain, over one orbit; where it is not after --at-most "
        "periods,\n"
        "over --record of them. With --what lyapunov the largest exponent is told of each: of an orbit from "
        "its\n"
        "multipliers, of a motion without a period as measured with a tangent vector, and with it whether "
        "that "
        "is\n"
        "quasi-periodic, chaotic or on its way to a longer period. An interrupted run is finished by "
        "--resume, with the same bits. saltus "
        "plot draws the\n"
        "file, saltus export writes its tables.",
    .needs_scene = true,
    .together = true,
    .options = options,
    .run = run,
};
