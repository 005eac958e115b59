/* saltus plot: a file of results as a figure.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const cli_option show =
    CLI_TEXT_OPTION("--show", show, "what",
                    "speed (largest of an orbit), impacts (the speed of each), displacement, velocity, "
                    "period or amplitude (largest and smallest displacement)");

static const cli_option range = CLI_KEYS_OPTION(
    "--range", parts, "key=lo:hi",
    "part of a parameter's range to draw; once for each parameter, and for a sweep's view (its name as key)");

static const cli_option label =
    CLI_LIST_OPTION("--label", labels, "place,text",
                    "write text in the plane, such as omega=42,d=0.035,4/4; may be repeated");

static const cli_option view =
    CLI_TEXT_OPTION("--view", view, "name",
                    "of a sweep: turning, impacts, stroboscopic (over one axis), class, attractors, largest, "
                    "rms, speed, rate, contact, lyapunov or settled");

static const cli_option over = CLI_FILES_OPTION("--over", over, "file.h5 ...",
                                                "draw files of saltus continue over a sweep: branches over a "
                                                "diagram, curves of special points over a map");

static const cli_option swap = CLI_FLAG_OPTION("--swap", look.swap, "exchange the axes");
static const cli_option log_axes =
    CLI_LIST_OPTION("--log", logarithmic, "key",
                    "logarithmic axis: a parameter or what is shown (speed, ...); may be repeated");

static const cli_option *const options[] = {&cli_output,        &show, &range,    &label, &view, &over,
                                            CLI_FIGURE_OPTIONS, &swap, &log_axes, NULL};

/* What the options point to. */
typedef struct plot_wishes {
    saltus_plot_part parts[CLI_LIST_MAX];
    saltus_plot_label labels[CLI_LIST_MAX];
} plot_wishes;

/* The words of saltus_show and saltus_view, in their order after the automatic choice. */
static const char *const shows[] = {"speed",     "impacts", "displacement", "velocity", "period",
                                    "amplitude", NULL};
static const char *const views[] = {"turning", "impacts", "stroboscopic", "class",   "attractors", "largest",
                                    "rms",     "speed",   "rate",         "contact", "lyapunov",   "settled",
                                    NULL};

/* "key=value," at the beginning of a text; what follows it, or NULL. */
static const char *read_place(const char *text, char key[SALTUS_KEY_MAX], double *value) {
    size_t length = strcspn(text, "=,");
    if (length == 0 || length >= SALTUS_KEY_MAX || text[length] != '=')
        return NULL;
    memcpy(key, text, length);
    key[length] = '\0';
    const char *end = saltus_read_number_until(text + length + 1, ",", value);
    return end && *end == ',' ? end + 1 : NULL;
}

static bool read_wishes(const cli_request *request, plot_wishes *wishes) {
    for (int k = 0; k < request->parts.count; k++) {
        saltus_plot_part *part = &wishes->parts[k];
        if (!cli_parse_range(&range, request->parts.items[k], part->key, &part->low, &part->high))
            return false;
    }
    for (int k = 0; k < request->labels.count; k++) {
        saltus_plot_label *wanted = &wishes->labels[k];
        const char *rest = request->labels.items[k];
        for (int axis = 0; axis < 2 && rest; axis++)
            rest = read_place(rest, wanted->key[axis], &wanted->value[axis]);
        if (!rest || !*rest)
            return cli_refuse(false, "--label %s: must have the form key=value,key=value,text",
                              request->labels.items[k]);
        wanted->text = rest;
    }
    return true;
}

/* What only a sweep can be asked for. */
static int draw_sweep(const cli_request *request, const plot_wishes *wishes) {
    saltus_message message = {.text = ""};
    saltus_sweep_view how = {.look = request->look,
                             .parts = wishes->parts,
                             .part_count = request->parts.count,
                             .branches = request->over.items,
                             .branch_count = request->over.count};
    int chosen = -1;
    if (!cli_choose(&view, request->view, views, &chosen))
        return CLI_BAD_INPUT;
    how.view = (saltus_view)(chosen + 1);
    if (request->input_count > 1 || request->show || request->labels.count)
        return cli_refuse(
            CLI_BAD_INPUT,
            "plot: --view and --over are of one sweep, --show and --label of files of saltus continue");
    const saltus_status status = saltus_plot_sweep(request->output, request->inputs[0], &how, &message);
    return cli_report(cli_tell_written(request, "figure", status), &message);
}

/* A trajectory is drawn whole, in one way. */
static int draw_trajectory(const cli_request *request) {
    const saltus_figure_options *look = &request->look;
    saltus_message message = {.text = ""};
    if (request->input_count > 1 || request->show || request->view || request->parts.count ||
        request->labels.count || request->over.count || look->swap || look->logarithmic_count)
        return cli_refuse(CLI_BAD_INPUT,
                          "plot: %s: is a trajectory, which is drawn alone, whole and in one way",
                          request->inputs[0]);
    const saltus_status status = saltus_plot_trajectory(request->output, request->inputs[0], look, &message);
    return cli_report(cli_tell_written(request, "figure", status), &message);
}

static int run(const cli_request *request) {
    saltus_message message = {.text = ""};
    saltus_plot_options how = saltus_plot_defaults();
    plot_wishes wishes;
    int chosen = -1;
    if (!request->input_count || !request->output)
        return cli_refuse(CLI_BAD_INPUT, "plot: needs a file and -o figure.png, figure.pdf or figure.svg");
    if (!cli_choose(&show, request->show, shows, &chosen) || !read_wishes(request, &wishes))
        return CLI_BAD_INPUT;
    how.look = request->look;
    if (strcmp(saltus_file_identify(request->inputs[0]).kind, "trajectory") == 0)
        return draw_trajectory(request);
    if (request->view || request->over.count)
        return draw_sweep(request, &wishes);
    how.show = (saltus_show)(chosen + 1);
    how.parts = wishes.parts;
    how.part_count = request->parts.count;
    how.labels = wishes.labels;
    how.label_count = request->labels.count;
    const saltus_status status =
        saltus_plot(request->output, request->inputs, request->input_count, &how, &message);
    return cli_report(cli_tell_written(request, "figure", status), &message);
}

static const cli_example examples[] = {
    {"sweep impact-oscillator --over omega=0.9:1.1:21 -o sweep.h5", "something to draw"},
    {"plot sweep.h5 --view impacts -o speeds.png", "impact speeds over the frequency"},
    {"continue impact-oscillator --in omega=0.9:1.1 -o branch.h5", "the branch that belongs to it"},
    {"plot sweep.h5 --over branch.h5 -o both.pdf --size column",
     "the branch over the diagram, one column of a journal wide"},
    {NULL, NULL}};

const cli_command cmd_plot = {
    .name = "plot",
    .summary = "files of results as figures",
    .usage =
        "FILE.h5 [FILE.h5 ...] -o figure.png|pdf|svg [--show what | --view name] [--over file.h5 ...] ...",
    .help = "Draw a file of saltus sweep or basins: a diagram over one axis with the class of motion along "
            "it, a map over two; or files of saltus continue. Branches of periodic orbits: solid where "
            "stable, dashed where not, n/p along them, special points marked; without forcing amplitudes of "
            "cycles and equilibria. Curves of special points, over their two parameters: solid where they "
            "bound stable orbits, dotted where not. Several files of one sort are laid over each other. A "
            "file of saltus simulate: phase portrait and time history.",
    .inputs = CLI_LIST_MAX,
    .endings = cli_figures,
    .options = options,
    .notes = "A motion has one colour and texture in all figures, by its n/p alone. Dense clouds are "
             "density-shaded rasters in vector axes. --view of a sweep shows the largest displacement, "
             "impact speed, rate, contact, settling time or the number of attractors. --over lays branches "
             "over a diagram (turning points, impacts, speed, section), curves of special points over a map.",
    .examples = examples,
    .see = "sweep continue simulate export",
    .run = run,
};
