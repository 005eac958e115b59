/* saltus basins: which attractor each initial state of a plane leads to.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"
#include "sweep/options.h"
#include "sweep_print.h"

#include <string.h>

/* Whether every axis is an entry of the initial state (q1, v1, z1 or names from a text model); false after a
 * message. */
static bool check_axes(const cli_list *over, const saltus_scene *scene) {
    for (int k = 0; k < over->count; k++) {
        char key[64];
        snprintf(key, sizeof key, "%.*s", (int)strcspn(over->items[k], "="), over->items[k]);
        if (saltus_spec_state_index(&scene->spec, key) < 0)
            return cli_refuse(false, "--over %s: must be an entry of the initial state, such as %s",
                              over->items[k], saltus_model_text(scene->spec.model) ? "x or x'" : "q1 or v1");
    }
    return true;
}

static int run(const cli_request *request) {
    const cli_list *over = cli_values(request, "--over");
    saltus_sweep_options how = request->sweep;
    saltus_scene scene = {.initial_count = 0};
    saltus_message message = {.text = ""};
    if (over->count != 2 || !request->output)
        return cli_refuse(CLI_BAD_INPUT,
                          "basins: needs --over q1=lo:hi:n --over v1=lo:hi:n and -o basins.h5");
    how.record = 1;
    saltus_status status = cli_load_scene(request, &scene, &message);
    int code = status == SALTUS_OK && !check_axes(over, &scene)
                   ? CLI_BAD_INPUT
                   : sweep_command(request, true, status, &scene, &how, &message);
    saltus_scene_clear(&scene);
    return code;
}

const cli_command cmd_basins = {
    .name = "basins",
    .summary = "which attractor each initial state leads to",
    .usage = "SCENE [--set key=value ...] --over q1=lo:hi:n --over v1=lo:hi:n -o basins.h5",
    .help = "Follow every initial state of a plane to its attractor; the other entries are those of the "
            "scene. Attractors are told apart by their orbits. The file holds, for each state, the "
            "attractor, the periods and the impacts on the way. An interrupted run is finished by --resume; "
            "saltus plot draws the file.",
    .needs_scene = true,
    .together = true,
    .endings = cli_records,
    .kind = "basins",
    .resumes = true,
    .tables = CLI_TABLES(
        CLI_TABLE(saltus_sweep_table, sweep, "--seeds --seed --what --record --measure --lifetime")),
    .options = CLI_OPTIONS(&cli_set, &cli_section, &sweep_over, &cli_output, &cli_resume, &sweep_json),
    .examples = CLI_EXAMPLES({"basins impact-pair --over q1=-1:1:20 --over v1=-1:1:20 -o basins.h5",
                              "20 displacements by 20 velocities"},
                             {"plot basins.h5 -o basins.png", "draw them"}),
    .see = "plot sweep",
    .run = run,
};
