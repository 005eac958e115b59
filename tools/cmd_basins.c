/* saltus basins: which attractor each initial state of a plane leads to.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"
#include "sweep/options.h"

static int run(const cli_request *request) {
    saltus_sweep_options how = request->sweep;
    if (cli_values(request, "--over")->count != 2 || !request->output)
        return cli_refuse(CLI_BAD_INPUT,
                          "basins: needs --over q1=lo:hi:n --over v1=lo:hi:n and -o basins.h5");
    how.record = 1;
    return sweep_command(request, true, &how);
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
