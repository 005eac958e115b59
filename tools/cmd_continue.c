/* saltus continue: a branch of periodic orbits, or a curve of special points in two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PLACE(member) offsetof(cli_request, member)

enum { values_max = 256 };

static const cli_option range = {
    "--in", CLI_TEXT, PLACE(range), 0, 0, 0, "key=lo:hi", "the parameter to continue in, and its range"};
static const cli_option locus = {"--locus",
                                 CLI_TEXT,
                                 PLACE(locus),
                                 0,
                                 0,
                                 0,
                                 "kind",
                                 "follow the first LP, PD, NS, BP or GR met on the way in two parameters"};
static const cli_option second_range = {
    "--and", CLI_TEXT, PLACE(second_range), 0, 0, 0, "key=lo:hi", "the second parameter of a locus"};
static const cli_option periods = {"--periods",
                                   CLI_WHOLE,
                                   PLACE(periods),
                                   0,
                                   1,
                                   1e6,
                                   "p",
                                   "period of the orbit to start from, where it is not that of --from"};
static const cli_option step = {"--step", CLI_REAL, PLACE(step), 0.005,
                                1e-9,     1,        "s",         "first step, where the whole range is 1"};
static const cli_option step_max = {
    "--step-max", CLI_REAL, PLACE(step_max), 0.03, 1e-9, 1, "s", "largest step, likewise"};
static const cli_option points = {"--points", CLI_WHOLE, PLACE(points), 2000,
                                  1,          1e7,       "n",           "points at most, on each branch"};
static const cli_option direction = {
    "--direction", CLI_TEXT, PLACE(direction), 0, 0, 0, "way", "up, down or both (default both)"};
static const cli_option switches = {
    "--switch", CLI_WHOLE, PLACE(switches), 0, 0, 1000, "k", "also follow what branches off, to this depth"};
static const cli_option values = {
    "--at", CLI_TEXT, PLACE(values), 0,
    0,      0,        "v[,v...]",    "values of the parameter to compute a point (UZ) at"};
static const cli_option resume = {
    "--resume", CLI_FLAG, PLACE(resume), 0, 0, 0, NULL, "go on with the interrupted run in the file of -o"};

static const cli_option json = {"--json", CLI_FLAG, PLACE(json), 0,
                                0,        0,        NULL,        "one JSON object for each point on stdout"};

static const cli_option *const options[] = {
    &cli_set,  &cli_from,      &range,          &locus,     &second_range, &periods,
    &step,     &step_max,      &points,         &direction, &switches,     &values,
    &resume,   &cli_transient, &cli_longest,    &json,      &cli_quiet,    &cli_output,
    &cli_rtol, &cli_atol,      &cli_integrator, NULL};

/* One run: what it starts from, where it goes and what it has made. */
typedef struct run_state {
    const cli_request *request;
    saltus_scene scene;
    saltus_system *system;
    saltus_start start;
    saltus_branch_options options;
    double values[values_max];
    saltus_branch *branch;
    saltus_branch_output *output;
    saltus_branch_file earlier; /* what an interrupted run left */
    int rows, branches;
    bool interrupted;
} run_state;

static bool read_values(const char *text, run_state *run) {
    const saltus_branch_options *o = &run->options;
    while (text) {
        char *end;
        if (run->options.value_count == values_max) {
            fprintf(stderr, "saltus: --at %s: only %d values can be given\n", text, values_max);
            return false;
        }
        double value = strtod(text, &end);
        if (end == text || !isfinite(value) || (*end && *end != ',')) {
            fprintf(stderr, "saltus: --at %s: must be numbers with commas between them\n", text);
            return false;
        }
        if (value < o->low[0] || value > o->high[0]) {
            fprintf(stderr, "saltus: --at %g: is outside the range of --in, %g to %g\n", value, o->low[0],
                    o->high[0]);
            return false;
        }
        run->values[run->options.value_count++] = value;
        text = *end ? end + 1 : NULL;
    }
    run->options.values = run->values;
    return true;
}

static bool read_direction(const char *text, int *way) {
    *way = !text || strcmp(text, "both") == 0 ? 0 : strcmp(text, "up") == 0 ? 1 : -1;
    if (*way >= 0 || strcmp(text, "down") == 0)
        return true;
    fprintf(stderr, "saltus: --direction %s: must be up, down or both\n", text);
    return false;
}

static bool read_locus(const char *text, saltus_point_kind *kind) {
    static const saltus_point_kind known[] = {SALTUS_POINT_LP, SALTUS_POINT_PD, SALTUS_POINT_NS,
                                              SALTUS_POINT_BP, SALTUS_POINT_GR};
    *kind = SALTUS_POINT_REGULAR;
    for (size_t k = 0; text && k < sizeof known / sizeof known[0]; k++)
        if (strcmp(text, saltus_point_word(known[k])) == 0)
            *kind = known[k];
    if (!text || *kind != SALTUS_POINT_REGULAR)
        return true;
    fprintf(stderr, "saltus: --locus %s: must be LP, PD, NS, BP or GR\n", text);
    return false;
}

/* The options of the continuation from the command line; false after a message. */
static bool read_options(run_state *run) {
    const cli_request *r = run->request;
    saltus_branch_options *o = &run->options;
    *o = saltus_branch_defaults();
    if (!r->output || !r->range) {
        fprintf(stderr, "saltus: continue: needs --in key=low:high and -o branch.h5\n");
        return false;
    }
    if (!r->locus != !r->second_range) {
        fprintf(stderr, "saltus: continue: --locus and --and belong together\n");
        return false;
    }
    o->orbit.flow = cli_flow_options(r);
    o->orbit.tolerance = fmax(o->orbit.tolerance, 100 * o->orbit.flow.rtol);
    /* A largest step below the usual first one bounds that too. */
    o->step = r->step == step.fallback ? fmin(r->step, r->step_max) : r->step;
    o->step_max = r->step_max;
    o->points = (int)r->points;
    o->switches = (int)r->switches;
    return cli_parse_range("--in", r->range, o->key[0], &o->low[0], &o->high[0]) &&
           (!r->second_range ||
            cli_parse_range("--and", r->second_range, o->key[1], &o->low[1], &o->high[1])) &&
           read_locus(r->locus, &o->locus) && read_direction(r->direction, &o->direction) &&
           read_values(r->values, run);
}

/* Without --from: the orbit that the scene settles on. */
static saltus_status classify_start(run_state *run, saltus_message *message) {
    saltus_classify_options how = cli_classify_options(run->request);
    saltus_motion motion = {0};
    saltus_status status = saltus_classify(run->system, run->start.state, &how, &motion, message);
    cli_progress_end(run->request);
    if (status == SALTUS_OK && motion.periods < 1 && interrupt_asked())
        status = SALTUS_INTERRUPTED;
    if (status == SALTUS_OK && motion.periods < 1)
        status =
            saltus_fail(message, SALTUS_BAD_INPUT,
                        "%s: its motion is no periodic orbit to start from, but %s%s%s; name one by --from",
                        run->scene.name, motion.label, motion.reason[0] ? ": " : "", motion.reason);
    if (status == SALTUS_OK) {
        run->start.spec = run->scene.spec;
        run->start.periods = motion.periods;
        run->start.dimension = motion.dimension;
        memcpy(run->start.state, motion.state, (size_t)motion.dimension * sizeof *motion.state);
    }
    saltus_motion_clear(&motion);
    return status;
}

static int begin_anew(run_state *run, saltus_message *message) {
    const cli_request *r = run->request;
    int code = r->from ? cli_build_from(r, &run->scene, &run->system, &run->start)
                       : cli_build(r, &run->scene, &run->system, run->start.state);
    if (code != CLI_DONE)
        return code;
    saltus_status status = r->from ? SALTUS_OK : classify_start(run, message);
    if (r->periods)
        run->start.periods = (int)r->periods;
    return cli_report(status, message);
}

static bool same_spec(const saltus_spec *a, const saltus_spec *b) {
    int count;
    bool same = a->model == b->model && a->stop_count == b->stop_count;
    saltus_model_parameters(a->model, &count);
    for (int k = 0; k < count; k++)
        same = same && a->parameters[k] == b->parameters[k];
    for (int s = 0; s < a->stop_count && same; s++) {
        const saltus_stop *x = &a->stops[s], *y = &b->stops[s];
        same = x->xi == y->xi && x->weight[0] == y->weight[0] && x->weight[1] == y->weight[1] &&
               x->d == y->d && x->r == y->r && x->sides == y->sides;
    }
    return same;
}

static bool same_way(const saltus_branch_options *a, const saltus_branch_options *b) {
    bool same = a->locus == b->locus;
    for (int k = 0; k < 2; k++)
        same = same && strcmp(a->key[k], b->key[k]) == 0 &&
               (!a->key[k][0] || (a->low[k] == b->low[k] && a->high[k] == b->high[k]));
    return same;
}

/* Whether the command line asks for the run that is in the file. */
static bool same_run(const run_state *run, saltus_message *message) {
    const saltus_branch_file *file = &run->earlier;
    saltus_scene changed = {.spec = file->spec};
    if (strcmp(run->scene.name, file->scene) == 0 && run->scene.spec.model == file->spec.model &&
        same_way(&run->options, &file->options) &&
        cli_apply_settings(run->request, &changed, message) == SALTUS_OK &&
        same_spec(&changed.spec, &file->spec))
        return true;
    saltus_fail(message, SALTUS_BAD_INPUT,
                "--resume: %.200s holds another run (of %.60s in %s from %g to %g); repeat its command line",
                run->request->output, file->scene, file->options.key[0], file->options.low[0],
                file->options.high[0]);
    return false;
}

/* Take over the start, the options and the points of an interrupted run. */
static int begin_again(run_state *run, saltus_message *message) {
    saltus_branch_file *file = &run->earlier;
    saltus_status status = saltus_branch_file_read(run->request->output, file, message);
    if (status == SALTUS_OK)
        status = saltus_scene_load(run->request->scene, &run->scene, message);
    if (status == SALTUS_OK && !same_run(run, message))
        status = SALTUS_BAD_INPUT;
    if (status == SALTUS_OK && file->dimension > SALTUS_SCENE_STATE_MAX)
        status =
            saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: the state is too long", run->request->output);
    if (status == SALTUS_OK) {
        run->scene.spec = file->spec;
        snprintf(run->scene.name, sizeof run->scene.name, "%s", file->scene);
        snprintf(run->scene.title, sizeof run->scene.title, "%s", file->title);
        run->start.periods = file->periods;
        memcpy(run->start.state, file->state, (size_t)file->dimension * sizeof *file->state);
        run->options = file->options;
        run->options.orbit.flow.stop = interrupt_flag();
        status = saltus_system_new(&file->spec, &run->system, message);
    }
    return cli_report(status == SALTUS_IO ? SALTUS_BAD_INPUT : status, message);
}

/* A progress line where stderr is a terminal. */
static void show_progress(const run_state *run, const saltus_branch_point *point) {
    if (run->request->quiet || !isatty(STDERR_FILENO))
        return;
    double largest = point->dimension ? exp(point->multipliers[0].log_modulus) : 0;
    fprintf(stderr, "\rbranch %d  step %d  %s = %.9g  %s  largest multiplier %.4g%s%s\033[K", point->branch,
            point->step, run->options.key[0], point->value[0], point->label, largest,
            point->kind == SALTUS_POINT_REGULAR ? "" : "  ", saltus_point_word(point->kind));
    fflush(stderr);
}

/* One point into the file, the table and, if wished, onto stdout. */
static saltus_status keep(run_state *run, const saltus_branch_point *point, saltus_message *message) {
    run->rows++;
    if (point->branch >= run->branches)
        run->branches = point->branch + 1;
    if (run->request->json)
        saltus_write_point_json(stdout, &run->scene, run->system, point);
    return saltus_branch_output_add(run->output, point, message);
}

static saltus_status follow(run_state *run, saltus_message *message) {
    const saltus_branch_point *point = NULL;
    saltus_status status = SALTUS_OK;
    do {
        status = saltus_branch_step(run->branch, &point, message);
        if (status == SALTUS_OK && point) {
            status = keep(run, point, message);
            show_progress(run, point);
        }
    } while (status == SALTUS_OK && point && !ferror(stdout));
    run->interrupted = status == SALTUS_INTERRUPTED;
    if (!run->request->quiet && isatty(STDERR_FILENO))
        fprintf(stderr, "\r\033[K");
    return run->interrupted ? SALTUS_OK : status;
}

/* The points of the interrupted run that stand go into the new file first. */
static saltus_status take_over(run_state *run, saltus_message *message) {
    const saltus_branch_file *file = &run->earlier;
    int kept = file->point_count;
    saltus_status status = SALTUS_OK;
    if (file->point_count && !file->complete)
        status = saltus_branch_resume(run->branch, file->points, file->point_count, &kept, message);
    for (int k = 0; k < kept && status == SALTUS_OK; k++)
        status = keep(run, &file->points[k], message);
    return status;
}

/* A start that Newton's method cannot polish is not an orbit: bad input. */
static int open_branch(run_state *run, saltus_message *message) {
    const saltus_start *start = &run->start;
    saltus_status status = saltus_branch_new(&run->scene.spec, start->periods, start->state, &run->options,
                                             &run->branch, message);
    if (status != SALTUS_OK && status != SALTUS_NO_MEMORY && status != SALTUS_BAD_INPUT &&
        !interrupt_asked()) {
        saltus_message reason = *message;
        status = saltus_fail(message, SALTUS_BAD_INPUT, "the start is no orbit of period %d T: %.400s",
                             start->periods, reason.text);
    }
    if (status == SALTUS_OK)
        status = saltus_branch_output_open(run->request->output, &run->scene, start->periods, start->state,
                                           &run->options, &run->output, message);
    return cli_report(status, message);
}

/* What the file holds, for people. */
static saltus_status print_table(const run_state *run, saltus_message *message) {
    saltus_branch_file file = {.point_count = 0};
    saltus_status status = saltus_branch_file_read(run->request->output, &file, message);
    if (status != SALTUS_OK)
        return status;
    printf("%s: %d point%s on %d branch%s in %s\n", run->scene.name, run->rows, run->rows == 1 ? "" : "s",
           run->branches, run->branches == 1 ? "" : "es", run->request->output);
    saltus_write_branch_text(stdout, &file);
    saltus_branch_file_clear(&file);
    return status;
}

static int compute(run_state *run) {
    saltus_message message = {""}, closing = {""};
    int code = run->request->resume ? begin_again(run, &message) : begin_anew(run, &message);
    if (code == CLI_DONE)
        code = open_branch(run, &message);
    if (code != CLI_DONE)
        return code;
    saltus_status status = take_over(run, &message);
    if (status == SALTUS_OK && !run->earlier.complete)
        status = follow(run, &message);
    bool complete = status == SALTUS_OK && !run->interrupted && !ferror(stdout);
    saltus_status written = saltus_branch_output_close(run->output, complete, &closing);
    run->output = NULL;
    if (!run->request->json && status == SALTUS_OK && written == SALTUS_OK && run->rows)
        status = print_table(run, &message);
    if (status != SALTUS_OK || written != SALTUS_OK)
        return cli_report(status != SALTUS_OK ? status : written, status != SALTUS_OK ? &message : &closing);
    if (run->interrupted && !run->rows)
        return interrupt_report("no point was found yet");
    if (run->interrupted)
        fprintf(stderr, "saltus: interrupted; %s holds the %d points so far, --resume goes on\n",
                run->request->output, run->rows);
    return run->interrupted ? CLI_FAILED : CLI_DONE;
}

static int run(const cli_request *request) {
    run_state *state = calloc(1, sizeof *state);
    int code = CLI_FAILED;
    if (!state) {
        fprintf(stderr, "saltus: no memory\n");
        return code;
    }
    state->request = request;
    code = read_options(state) ? compute(state) : CLI_BAD_INPUT;
    saltus_branch_output_close(state->output, false, NULL);
    saltus_branch_free(state->branch);
    saltus_branch_file_clear(&state->earlier);
    saltus_system_free(state->system);
    free(state);
    return code;
}

const cli_command cmd_continue = {
    .name = "continue",
    .usage =
        "SCENE [--set key=value ...] [--from orbit] --in omega=lo:hi [--locus PD --and d=lo:hi] -o branch.h5 "
        "[--json]",
    .help = "Follow a periodic orbit as a parameter changes, stable or not, and find where it folds (LP), "
            "flips (PD),\n"
            "bifurcates to a torus (NS), meets another branch (BP) or grazes a stop (GR), and where chatter "
            "completes\n"
            "(CH) or sticking changes (ST). Without --from the start is the orbit that the scene settles on; "
            "with it, the\n"
            "file's parameters hold where --set does not say otherwise. With --locus such points are "
            "followed in two\n"
            "parameters. The file can be plotted, and read, while it grows; with --resume the options are "
            "those of the\n"
            "interrupted run.",
    .needs_scene = true,
    .options = options,
    .run = run,
};
