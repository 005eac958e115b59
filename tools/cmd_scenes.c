/* saltus scenes: lists and prints the built-in scenes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include <string.h>

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
    return cli_refuse(CLI_BAD_INPUT, "%s: no built-in scene of that name; saltus scenes lists them",
                      request->scene);
}

const cli_command cmd_scenes = {
    .name = "scenes",
    .summary = "the built-in scenes, and how scenes are written",
    .usage = "[NAME]",
    .help =
        "List the built-in scenes, or print one as YAML, to start a scene of one's own from.\nA scene is a "
        "YAML file, as these are. One stop stands under stop:, several as a list under stops:, each with d "
        "(clearance), r (restitution), sides (upper, lower or both) and its place: xi on the pipe, weight: "
        "[1, 0] of the masses. On the command line --set d=0.9 changes all stops, --set d2=0.9 r2=0.7 the "
        "second one, also after d=; what would leave nothing of an earlier setting is refused (d= after d2=, "
        "d1= beside d= of a single stop, x= beside q1=, --over of what --set gives). --set sides=none takes "
        "the stops away, and d=... makes one where there is none. The "
        "same keys are axes of --over and --in.\nThe initial state stands under initial: as lists q "
        "(displacements, or amplitudes of modes) and v (their rates); --set q1=0.2 v1=0 changes single "
        "entries, and q1, v1, ... are axes of --over. Without initial: the system starts from a small "
        "displacement. Random initial states are drawn by --seeds k, differently for each --seed s: k of "
        "them by saltus classify, the scene's own and k - 1 others at each point by saltus sweep.\n"
        "Displacement diagrams, largest and smallest displacements, root mean squares and spectra are of the "
        "first stop's coordinate. observe: in a scene, or --set observe=, chooses another displacement: "
        "stop2 is that of the second stop, q2 that entry of the state, 0.3 the place xi = 0.3 of a "
        "pipe.\nEquations of one's own stand under model: instead of a name; saltus help text tells how.",
    .options = (const cli_option *const[]){NULL},
    .examples = CLI_EXAMPLES(
        {"scenes", "list them"}, {"scenes two-stops > mine.yaml", "a scene to change"},
        {"check mine.yaml --set d2=0.9 q1=0.2",
         "what it means with another second clearance and another start"},
        {"sweep two-mass --set observe=q2 --over omega=0.9:1.3:200 -o x2.h5", "diagrams of the second mass"}),
    .see = "text check classify",
    .run = list_scenes,
};
