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
    saltus_system_free(setup.system);
    return CLI_DONE;
}

const cli_command cmd_scenes = {
    .name = "scenes",
    .usage = "[NAME]",
    .help = "List the built-in scenes, or print one as YAML, to start a scene of one's own from.",
    .options = no_options,
    .run = list_scenes,
};

const cli_command cmd_check = {
    .name = "check",
    .usage = "SCENE [--set key=value ...]",
    .help = "Read a scene, check it and show what it means; nothing is simulated.",
    .needs_scene = true,
    .options = check_options,
    .run = check_scene,
};
