/* saltus scenes and saltus check: what can be simulated.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include <string.h>

static const cli_option *const no_options[] = {NULL};
static const cli_option *const check_options[] = {&cli_set, NULL};

static int list_scenes(const cli_request *request) {
    saltus_message message = {.text = ""};
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        const char *name = saltus_scene_builtin_name(k), *text = saltus_scene_builtin_text(k);
        saltus_scene scene;
        if (request->scene && strcmp(request->scene, name) == 0) {
            fputs(text, stdout);
            return CLI_DONE;
        }
        saltus_status status = saltus_scene_parse(text, strlen(text), name, &scene, &message);
        if (status != SALTUS_OK)
            return cli_report(status, &message);
        if (!request->scene)
            printf("%-18s %s\n", name, scene.title);
        saltus_scene_clear(&scene);
    }
    if (!request->scene)
        return CLI_DONE;
    fprintf(stderr, "saltus: %s: no built-in scene of that name; saltus scenes lists them\n", request->scene);
    return CLI_BAD_INPUT;
}

static void print_stop(const saltus_spec *spec, int s) {
    const saltus_model *model = spec->model;
    const saltus_stop *stop = &spec->stops[s];
    const char *coordinate = saltus_stop_text(spec, s, SALTUS_STOP_COORDINATE);
    static const char *const sides[] = {"", "upper", "lower", "both"};
    printf("stop %d: %s side%s, d = %g, r = %g, ", s + 1, sides[stop->sides],
           stop->sides == SALTUS_BOTH ? "s" : "", stop->d, stop->r);
    if (coordinate) {
        printf("coordinate = %s\n", coordinate);
        return;
    }
    int count;
    const double *place = saltus_stop_place(model, stop, &count);
    printf("%s = %s", saltus_model_stop_key(model), count > 1 ? "[" : "");
    for (int k = 0; k < count; k++)
        printf("%s%g", k ? ", " : "", place[k]);
    puts(count > 1 ? "]" : "");
}

static int check_scene(const cli_request *request) {
    cli_setup setup;
    int code = cli_build(request, &setup), count;
    if (code != CLI_DONE)
        return code;
    const saltus_spec *spec = &setup.scene.spec;
    const saltus_parameter *table = saltus_model_parameters(spec->model, &count);
    printf("%s: ok\nmodel: %s (%s)\n", setup.scene.name, saltus_model_name(spec->model),
           saltus_model_summary(spec->model));
    for (int k = 0; k < count; k++)
        printf("  %-6s %-12.9g %s\n", table[k].name, spec->parameters[k], table[k].meaning);
    for (int s = 0; s < spec->stop_count; s++)
        print_stop(spec, s);
    printf("forcing period T = %.15g, integrator %s\n", saltus_system_period(setup.system),
           saltus_system_integrator(setup.system));
    cli_clear(&setup);
    return CLI_DONE;
}

static const cli_example scenes_examples[] = {
    {"scenes", "list them"},
    {"scenes two-stops > mine.yaml", "a scene to change"},
    {"check mine.yaml --set d2=0.9 q1=0.2", "what it means with another second clearance and another start"},
    {NULL, NULL}};

const cli_command cmd_scenes = {
    .name = "scenes",
    .summary = "the built-in scenes, and how scenes are written",
    .usage = "[NAME]",
    .help =
        "List the built-in scenes, or print one as YAML, to start a scene of one's own from.\nA scene is a "
        "YAML file, as these are. One stop stands under stop:, several as a list under stops:, each with d "
        "(clearance), r (restitution), sides (upper, lower or both) and its place: xi on the pipe, weight: "
        "[1, 0] of the masses. On the command line --set d=0.9 changes all stops, --set d2=0.9 r2=0.7 the "
        "second one; --set sides=none takes the stops away, and d=... makes one where there is none. The "
        "same keys are axes of --over and --in.\nThe initial state stands under initial: as lists q "
        "(displacements, or amplitudes of modes) and v (their rates); --set q1=0.2 v1=0 changes single "
        "entries, and q1, v1, ... are axes of --over. Without initial: the system starts from a small "
        "displacement. Random initial states are drawn by --seeds k, differently for each --seed s: k of "
        "them by saltus classify, the scene's own and k - 1 others at each point by saltus sweep.",
    .options = no_options,
    .examples = scenes_examples,
    .see = "check classify",
    .run = list_scenes,
};

static const cli_example check_examples[] = {
    {"check pipe --set N=4 omega=40", "parameters and stops of a scene with changes"},
    {"scenes two-stops | saltus check -", "one from standard input"},
    {NULL, NULL}};

const cli_command cmd_check = {
    .name = "check",
    .summary = "what a scene means",
    .usage = "SCENE [--set key=value ...]",
    .help = "Read a scene, check it and show what it means; nothing is simulated.",
    .needs_scene = true,
    .options = check_options,
    .examples = check_examples,
    .see = "scenes",
    .run = check_scene,
};
