/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"

#include "base/field.h"
#include "ranks.h"
#include "record/output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const cli_option sweep_over = CLI_OPTION(
    "--over", CLI_KEYS, "key=values",
    "an axis: key=lo:hi:n, key=lo:hi:n:log or key=v1,v2,...; once or twice, the first runs fastest");
const cli_option sweep_json = CLI_OPTION("--json", CLI_FLAG, NULL, "a summary as one JSON object on stdout");

/* Most lines of a table; the remaining classes are summed up. */
enum { lines_max = 12 };

/* Number of trajectories that ended on an attractor of basins. */
typedef struct share {
    int attractor;
    long long count;
} share;

static int larger_share(const void *a, const void *b) {
    const share *x = a, *y = b;
    return x->count != y->count ? (x->count < y->count ? 1 : -1) : x->attractor - y->attractor;
}

static double percent(long long part, long long whole) {
    return whole > 0 ? 100 * (double)part / (double)whole : 0;
}

/* Number of trajectories in the tally: all in the file, or without a file those of this run. */
static long long counted(const sweep_report *report) {
    long long sum = 0;
    for (int k = 0; k < report->tally.count; k++)
        sum += report->tally.classes[k].count;
    return sum;
}

static double rate(const sweep_report *report) {
    return report->seconds > 0 ? (double)report->computed / report->seconds : 0;
}

/* Whether a class occurred. */
static bool is_met(const sweep_report *report, const char *label) {
    int k = 0;
    while (k < report->tally.count && strcmp(report->tally.classes[k].label, label) != 0)
        k++;
    return k < report->tally.count;
}

/* What failed trajectories are, and how undecided ones could be decided. */
static void print_hint(const sweep_order *order, const sweep_report *report) {
    const saltus_sweep_options *o = saltus_sweep_choices(order->sweep);
    bool measured = o->keep & SALTUS_KEEP_LYAPUNOV;
    if (is_met(report, "failed"))
        puts("failed: the flow could not start, or gave up; saltus classify tells it of a point");
    if (is_met(report, "beyond a stop"))
        puts("beyond a stop: the start lies there; another one, or another d, would tell");
    if (order->basins)
        return;
    if (is_met(report, "irregular") && !measured)
        printf(
            "irregular: no period up to %d T was found; --what lyapunov would tell chaos from the others\n",
            o->longest);
    else if (is_met(report, "irregular") && o->measure > 0)
        printf("irregular: chaos watched for %lld periods, too few for a --lifetime of %lld; a larger "
               "--measure would tell\n",
               o->measure, o->lifetime);
    if (is_met(report, "undecided") && measured && o->measure > 0)
        printf("undecided: exponents that %lld periods do not tell from zero; a larger --measure would\n",
               o->measure);
}

static void print_table(const sweep_order *order, const sweep_report *report, const saltus_sweep_file *file,
                        const share *shares, const sweep_tally *none) {
    const saltus_sweep *sweep = order->sweep;
    printf("%s: %lld point%s, %lld trajector%s%s%s\n", saltus_sweep_scene(sweep)->name,
           saltus_sweep_points(sweep), saltus_sweep_points(sweep) == 1 ? "" : "s", report->rows,
           report->rows == 1 ? "y" : "ies", order->quiet ? "" : " in ",
           order->quiet       ? ""
           : order->to_stdout ? "standard output"
                              : order->path);
    /* Of basins the attractors, and what came to none; of sweeps the motions. */
    const long long all = shares ? file->row_count : counted(report);
    const sweep_tally *tally = shares ? none : &report->tally;
    long long rest = all;
    if (shares)
        printf("%-20s %12s %9s %18s\n", "attractor", "trajectories", "share", "largest multiplier");
    else if (tally->count)
        printf("%-16s %12s %9s\n", "motion", "trajectories", "share");
    for (int k = 0; k < file->attractor_count && k < lines_max && shares; k++)
        printf("%-20s %12lld %7.2f %% %18.4g\n", file->attractor_label[shares[k].attractor], shares[k].count,
               percent(shares[k].count, all), file->attractor_multiplier[shares[k].attractor]);
    if (shares && file->attractor_count > lines_max)
        printf("%d others\n", file->attractor_count - lines_max);
    for (int k = 0; k < tally->count && (shares || k < lines_max); k++) {
        const sweep_class *class = &tally->classes[k];
        char text[SALTUS_LABEL_MAX + 16];
        snprintf(text, sizeof text, "%s%s", shares ? "none: " : "", class->label);
        printf("%-*s %12lld %7.2f %%\n", shares ? 20 : 16, text, class->count, percent(class->count, all));
        rest -= class->count;
    }
    if (!shares && tally->count > lines_max) {
        char others[32];
        snprintf(others, sizeof others, "%d others", tally->count - lines_max);
        printf("%-16s %12lld %7.2f %%\n", others, rest, percent(rest, all));
    }
    print_hint(order, report);
    if (report->computed)
        printf("%.3g s, %.4g trajectories/s%s\n", report->seconds, rate(report),
               report->computed < report->rows ? "; the others were there" : "");
    else
        printf("all were there\n");
}

static void put_json(const sweep_order *order, const sweep_report *report, const saltus_sweep_file *file,
                     const share *shares) {
    const saltus_sweep *sweep = order->sweep;
    const sweep_tally *tally = &report->tally;
    const long long all = counted(report);
    printf("{\"version\": \"%s\", \"scene\": ", SALTUS_VERSION);
    saltus_put_string(stdout, saltus_sweep_scene(sweep)->name);
    printf(", \"file\": ");
    saltus_put_string(stdout, order->path);
    printf(", \"kind\": \"%s\", \"complete\": true, \"points\": %lld, \"passes\": [",
           order->basins ? "basins" : "sweep", saltus_sweep_points(sweep));
    for (int k = 0; k < saltus_sweep_pass_count(sweep); k++)
        printf("%s\"%s\"", k ? ", " : "", saltus_pass_word(saltus_sweep_pass_at(sweep, k)));
    printf("], \"seeds\": %d, \"rows\": %lld, \"computed\": %lld, \"seconds\": %.6g, "
           "\"trajectories_per_second\": %.6g, \"ranks\": %d, \"classes\": [",
           saltus_sweep_choices(sweep)->seeds, report->rows, report->computed, report->seconds, rate(report),
           report->ranks);
    for (int k = 0; k < tally->count; k++)
        printf("%s{\"label\": \"%s\", \"count\": %lld, \"share\": %.17g}", k ? ", " : "",
               tally->classes[k].label, tally->classes[k].count, percent(tally->classes[k].count, all) / 100);
    printf(shares ? "], \"attractors\": [" : "]");
    for (int k = 0; k < file->attractor_count && shares; k++) {
        const int a = shares[k].attractor;
        printf("%s{\"label\": \"%s\", \"largest_multiplier\": ", k ? ", " : "", file->attractor_label[a]);
        if (isfinite(file->attractor_multiplier[a]))
            printf("%.17g", file->attractor_multiplier[a]);
        else
            printf("null");
        printf(", \"count\": %lld, \"share\": %.17g}", shares[k].count,
               percent(shares[k].count, file->row_count) / 100);
    }
    printf(shares ? "]}\n" : "}\n");
}

static saltus_status print_report(const sweep_order *order, sweep_report *report, bool json,
                                  saltus_message *message) {
    saltus_sweep_file file = {.row_count = 0};
    share *shares = NULL;
    sweep_tally none = {0};
    saltus_status status = SALTUS_OK;
    bool read = (order->basins || report->computed < report->rows) && saltus_path_ends(order->path, ".h5");
    if (read)
        status = saltus_sweep_file_read(order->path, &file, message);
    /* After a resumed run, count all rows of the file. */
    const bool anew = status == SALTUS_OK && read && report->computed < report->rows;
    if (anew)
        sweep_tally_clear(&report->tally);
    for (long long k = 0; k < file.row_count && anew && status == SALTUS_OK; k++)
        status = sweep_tally_add(&report->tally, &file.rows[k], message);
    if (status == SALTUS_OK && file.attractor_count > 0) {
        shares = calloc((size_t)file.attractor_count, sizeof *shares);
        if (!shares)
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the shares of the attractors");
    }
    for (int k = 0; k < file.attractor_count && shares; k++)
        shares[k].attractor = k;
    for (long long k = 0; k < file.row_count && shares; k++)
        if (file.rows[k].attractor >= 0)
            shares[file.rows[k].attractor].count++;
    if (shares)
        qsort(shares, (size_t)file.attractor_count, sizeof *shares, larger_share);
    /* Trajectories without an attractor, by what is told of each. */
    for (long long k = 0; k < file.row_count && shares && status == SALTUS_OK; k++)
        if (file.rows[k].attractor < 0)
            status = sweep_tally_add(&none, &file.rows[k], message);
    sweep_tally_sort(&none);
    sweep_tally_sort(&report->tally);
    if (status == SALTUS_OK && json)
        put_json(order, report, &file, shares);
    else if (status == SALTUS_OK)
        print_table(order, report, &file, shares, &none);
    free(shares);
    sweep_tally_clear(&none);
    saltus_sweep_file_clear(&file);
    return status;
}

/* If no trajectory came to a motion, report why: the error that classification gives for the first one. */
static saltus_status tell_failure(const saltus_sweep *sweep, const sweep_report *report,
                                  saltus_message *message) {
    saltus_message reason = {.text = ""};
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_motion motion = {0};
    double state[SALTUS_STATE_MAX];
    saltus_classify_options how = saltus_classify_defaults();
    const bool failed = is_met(report, saltus_verdict_word(SALTUS_FAILED)),
               beyond = is_met(report, saltus_verdict_word(SALTUS_BEYOND));
    if ((!failed && !beyond) || report->tally.count > failed + beyond)
        return SALTUS_OK;
    how.flow = saltus_sweep_choices(sweep)->flow;
    how.measure = 0;
    saltus_status status = saltus_sweep_scene_at(sweep, 0, &scene, &reason);
    if (status == SALTUS_OK)
        status = saltus_system_new(&scene.spec, &system, &reason);
    if (status == SALTUS_OK)
        status = saltus_scene_state(&scene, system, state, &reason);
    if (status == SALTUS_OK)
        status = saltus_classify(system, state, &how, &motion, &reason);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return saltus_fail(message, failed ? SALTUS_STALLED : SALTUS_BAD_INPUT,
                       "no trajectory could be followed%s%.400s",
                       status == SALTUS_OK ? "" : "; the first: ", reason.text);
}

static saltus_status make_sweep(const cli_request *request, bool basins, const saltus_scene *scene,
                                const saltus_sweep_options *options, saltus_sweep **sweep,
                                saltus_message *message) {
    saltus_axis axes[SALTUS_AXES_MAX];
    double *lists[SALTUS_AXES_MAX] = {NULL};
    const cli_list *over = cli_values(request, "--over"), *settings = cli_values(request, "--set");
    saltus_status status = SALTUS_OK;
    /* The axes of basins are entries of the initial state: q1, v1, z1 or names from a text model. */
    for (int k = 0; k < over->count && basins; k++) {
        char key[64];
        snprintf(key, sizeof key, "%.*s", (int)strcspn(over->items[k], "="), over->items[k]);
        if (saltus_spec_state_index(&scene->spec, key) < 0)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "--over %.300s: must be an entry of the initial state, such as %s",
                               over->items[k], saltus_model_text(scene->spec.model) ? "x or x'" : "q1 or v1");
    }
    if (over->count > SALTUS_AXES_MAX)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "--over %.100s: only two axes can be given",
                             over->items[SALTUS_AXES_MAX]);
    for (int k = 0; k < over->count && status == SALTUS_OK; k++) {
        saltus_message reason = {.text = ""};
        status = saltus_axis_read(over->items[k], &axes[k], &lists[k], &reason);
        if (status != SALTUS_OK)
            saltus_fail(message, status, "--over %.490s", reason.text);
        else
            status = cli_check_twice(request, scene, settings->count, "--over", over->items[k], message);
    }
    if (status == SALTUS_OK && options->adaptive && options->transient == 0)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "--at-most 0: must be at least 1");
    if (status == SALTUS_OK)
        status = saltus_sweep_new(scene, axes, over->count, options, sweep, message);
    for (int k = 0; k < SALTUS_AXES_MAX; k++)
        free(lists[k]);
    return status;
}

int sweep_command(const cli_request *request, bool basins, const saltus_sweep_options *options) {
    volatile sig_atomic_t stop = 0;
    saltus_scene scene = {.initial_count = 0};
    saltus_message message = {.text = ""};
    saltus_sweep_options how = *options;
    saltus_sweep *sweep = NULL;
    sweep_report report;
    cli_origin origin = {.command = NULL};
    how.flow.stop = &stop;
    if (how.threads == 0)
        how.threads = ranks_threads();
    saltus_status status = cli_load_scene(request, &scene, &message);
    /* Defaults for --what: clouds for diagrams over one parameter, only classes over two. CSV files hold only
     * rows. */
    if (status == SALTUS_OK && !basins && !cli_given(request, "--what") &&
        cli_values(request, "--over")->count == 1 && !saltus_path_ends(request->output, ".csv"))
        how.keep = SALTUS_KEEP_TURNING | (scene.spec.stop_count ? SALTUS_KEEP_IMPACTS : 0);
    if (status == SALTUS_OK)
        status = make_sweep(request, basins, &scene, &how, &sweep, &message);
    if (status == SALTUS_OK)
        status = cli_origin_new(request, &origin, &message);
    const sweep_order order = {.sweep = sweep,
                               .stop = &stop,
                               .path = request->output,
                               .origin = &origin.told,
                               .basins = basins,
                               .resume = cli_given(request, "--resume"),
                               .quiet = cli_given(request, "--quiet"),
                               .to_stdout = request->to_stdout};
    int code = run_sweep(&order, status, &message, &report);
    if (code == CLI_DONE && report.first)
        code = cli_report(print_report(&order, &report, cli_given(request, "--json"), &message), &message);
    if (code == CLI_DONE && report.first)
        code = cli_report(tell_failure(sweep, &report, &message), &message);
    sweep_tally_clear(&report.tally);
    saltus_sweep_free(sweep);
    saltus_scene_clear(&scene);
    cli_origin_clear(&origin);
    return code;
}
