/* saltus plot: a file of results as a figure.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The words of saltus_show and saltus_view, in their order after automatic. */
static const char *const shows[] = {"speed",     "impacts", "displacement", "velocity", "period",
                                    "amplitude", NULL};
static const char *const views[] = {"turning", "impacts", "stroboscopic", "class",   "attractors", "largest",
                                    "rms",     "speed",   "rate",         "contact", "lyapunov",   "settled",
                                    NULL};

static const cli_option show =
    CLI_CHOICE("--show", "what",
               "speed (largest of an orbit), impacts (the speed of each), displacement, velocity, "
               "period or amplitude (largest and smallest displacement)",
               shows);

static const cli_option range = CLI_OPTION(
    "--range", CLI_KEYS, "key=lo:hi",
    "part of a parameter's range to draw; once for each parameter, and for a sweep's view (its name as key)");

static const cli_option label = CLI_OPTION(
    "--label", CLI_LIST, "place,text",
    "write text at a place, such as omega=42,d=0.035,4/4 or, over one parameter, with what is shown "
    "of it, omega=42,speed=0.3,here; may be repeated");

static const cli_option view =
    CLI_CHOICE("--view", "name",
               "of a sweep: turning, impacts, stroboscopic (over one axis), class, attractors, largest, "
               "rms, speed, rate, contact, lyapunov or settled",
               views);

static const cli_option over = CLI_OPTION("--over", CLI_FILES, "file.h5 ...",
                                          "draw files of saltus continue over a sweep: branches over a "
                                          "diagram, curves of special points over a map");

/* Read the values of --range and --label; false after a message. */
static bool read_wishes(const cli_list *ranges, saltus_plot_part *parts, const cli_list *texts,
                        saltus_plot_label *labels) {
    for (int k = 0; k < ranges->count; k++)
        if (!cli_parse_range("--range", ranges->items[k], parts[k].key, &parts[k].low, &parts[k].high))
            return false;
    for (int k = 0; k < texts->count; k++) {
        saltus_plot_label *wanted = &labels[k];
        const char *rest = texts->items[k];
        for (int axis = 0; axis < 2 && rest; axis++) { /* "key=value," */
            const size_t length = strcspn(rest, "=,");
            const bool named = length > 0 && length < SALTUS_KEY_MAX && rest[length] == '=';
            snprintf(wanted->key[axis], SALTUS_KEY_MAX, "%.*s", named ? (int)length : 0, rest);
            const char *end =
                named ? saltus_read_number_until(rest + length + 1, ",", &wanted->value[axis]) : NULL;
            rest = end && *end == ',' ? end + 1 : NULL;
        }
        if (!rest || !*rest)
            return cli_refuse(false, "--label %s: must have the form key=value,key=value,text",
                              texts->items[k]);
        wanted->text = rest;
    }
    return true;
}

static int run(const cli_request *request) {
    const cli_list *ranges = cli_values(request, "--range"), *labels = cli_values(request, "--label"),
                   *over = cli_values(request, "--over");
    const saltus_figure_options *look = &request->look;
    const bool several = request->input_count > 1, shows_what = cli_given(request, "--show"),
               has_view = cli_given(request, "--view");
    const char *first = request->inputs[0];
    saltus_message message = {.text = ""};
    saltus_status status;
    saltus_plot_part parts[CLI_LIST_MAX];
    saltus_plot_label placed[CLI_LIST_MAX];
    int shown = -1, viewed = -1;
    if (!first || !request->output)
        return cli_refuse(CLI_BAD_INPUT, "plot: needs a file and -o figure.png, figure.pdf or figure.svg");
    if (!cli_choose(request, "--show", shows, &shown) || !read_wishes(ranges, parts, labels, placed))
        return CLI_BAD_INPUT;
    if (strcmp(saltus_file_identify(first).kind, "trajectory") == 0) {
        if (several || shows_what || has_view || ranges->count || labels->count || over->count ||
            look->swap || look->logarithmic_count)
            return cli_refuse(CLI_BAD_INPUT,
                              "plot: %s: is a trajectory, which is drawn alone, whole and in one way", first);
        status = saltus_plot_trajectory(request->output, first, look, &message);
    } else if (has_view || over->count) { /* options for sweeps only */
        if (!cli_choose(request, "--view", views, &viewed))
            return CLI_BAD_INPUT;
        if (several || shows_what)
            return cli_refuse(CLI_BAD_INPUT,
                              "plot: --view and --over are of one sweep, --show of files of saltus continue");
        const saltus_sweep_view how = {.look = *look,
                                       .view = (saltus_view)(viewed + 1),
                                       .parts = parts,
                                       .part_count = ranges->count,
                                       .labels = placed,
                                       .label_count = labels->count,
                                       .branches = over->items,
                                       .branch_count = over->count};
        status = saltus_plot_sweep(request->output, first, &how, &message);
    } else {
        saltus_plot_options how = saltus_plot_defaults();
        how.look = *look;
        how.show = (saltus_show)(shown + 1);
        how.parts = parts;
        how.part_count = ranges->count;
        how.labels = placed;
        how.label_count = labels->count;
        status = saltus_plot(request->output, request->inputs, request->input_count, &how, &message);
    }
    return cli_report(cli_tell_written(request, "figure", status), &message);
}

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
    .options = CLI_OPTIONS(&cli_output, &show, &range, &label, &view, &over, CLI_FIGURE_OPTIONS, &cli_swap,
                           &cli_log),
    .notes = "A motion has one colour and texture in all figures, by its n/p alone. Dense clouds are "
             "density-shaded rasters in vector axes. --view of a sweep shows the largest displacement, "
             "impact speed, rate, contact, settling time or the number of attractors. --over lays branches "
             "over a diagram (turning points, impacts, speed, section), curves of special points over a map.",
    .examples = CLI_EXAMPLES(
        {"sweep impact-oscillator --over omega=0.9:1.1:21 -o sweep.h5", "something to draw"},
        {"plot sweep.h5 --view impacts -o speeds.png", "impact speeds over the frequency"},
        {"continue impact-oscillator --in omega=0.9:1.1 -o branch.h5", "the branch that belongs to it"},
        {"plot sweep.h5 --over branch.h5 -o both.pdf --size column",
         "the branch over the diagram, one column of a journal wide"}),
    .see = "sweep continue simulate export",
    .run = run,
};
