/* saltus sweep: many trajectories over one or two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "run_sweep.h"
#include "sweep/options.h"

#include <string.h>

static const cli_option transient =
    CLI_NUMBER("--transient", "m",
               "run so many periods and record --record further ones, whatever the motion", -1, 0, 1e9);
static const char *const starts[] = {"reset", "carry", "both", NULL};
static const cli_option start = CLI_CHOICE(
    "--start", "how",
    "reset (each point anew), carry (from point to point, up and down), both (default reset)", starts);
/* What --what may list, and what is kept for it. */
static const char *const kept[] = {"turning", "impacts", "stroboscopic", "lyapunov", "class", "max", NULL};
static const unsigned kept_bits[] = {
    SALTUS_KEEP_TURNING, SALTUS_KEEP_IMPACTS, SALTUS_KEEP_STROBOSCOPIC, SALTUS_KEEP_LYAPUNOV, 0, 0};
static const cli_option what =
    CLI_CHOICE("--what", "list",
               "kept beside the rows: turning, impacts, stroboscopic, lyapunov; class and max are "
               "always told (default turning,impacts over one axis, class over two)",
               kept);

static int run(const cli_request *request) {
    static const unsigned passes[] = {1u << SALTUS_PASS_RESET, 1u << SALTUS_PASS_UP | 1u << SALTUS_PASS_DOWN,
                                      (1u << SALTUS_PASSES) - 1};
    const long transient_given = cli_whole(request, "--transient");
    const char *what = cli_text(request, "--what");
    saltus_sweep_options how = request->sweep;
    unsigned seen = 0; /* which words of --what have been met */
    int chosen = 0;
    if (!cli_given(request, "--over") || !request->output)
        return cli_refuse(CLI_BAD_INPUT, "sweep: needs --over key=lo:hi:n and -o file.h5 or file.csv");
    if (transient_given >= 0 && cli_given(request, "--at-most"))
        return cli_refuse(CLI_BAD_INPUT, "--at-most and --transient: one of them; with --transient every "
                                         "trajectory runs for a fixed time");
    how.adaptive = transient_given < 0;
    if (!how.adaptive)
        how.transient = transient_given;
    how.keep = 0;
    for (const char *c = what; c;) {
        size_t length = strcspn(c, ",");
        int k = 0;
        while (kept[k] && !(strlen(kept[k]) == length && strncmp(kept[k], c, length) == 0))
            k++;
        if (kept[k] && seen >> k & 1)
            return cli_refuse(CLI_BAD_INPUT, "--what %s: %s is given twice", what, kept[k]);
        if (!kept[k])
            return cli_refuse(CLI_BAD_INPUT,
                              "--what %s: must be a list of turning, impacts, stroboscopic, class, lyapunov "
                              "and max with commas between them",
                              what);
        seen |= 1u << k;
        how.keep |= kept_bits[k];
        c = c[length] ? c + length + 1 : NULL;
    }
    if (!cli_choose(request, "--start", starts, &chosen))
        return CLI_BAD_INPUT;
    how.passes = passes[chosen];
    if ((request->to_stdout || strcmp(request->output, "-") == 0) &&
        how.keep & (SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC))
        return cli_refuse(CLI_BAD_INPUT,
                          "-o -: turning points, impacts and stroboscopic points are kept in .h5 files only");
    return sweep_command(request, false, &how);
}

const cli_command cmd_sweep = {
    .name = "sweep",
    .summary = "many trajectories over one or two parameters",
    .usage = "SCENE [--set key=value ...] --over omega=lo:hi:n [--over d=lo:hi:n] -o sweep.h5|csv",
    .help = "Run trajectories over a grid of one or two parameters (or entries of the initial state), on all "
            "cores and, started by mpirun, on many machines; classify each and keep what its diagrams need. "
            "A trajectory is recorded as soon as its least period is certain, over one orbit; where it is "
            "not after --at-most periods, over --record of them. With --what lyapunov the largest exponent "
            "is told of each: of an orbit from its multipliers, of a motion without a period as measured "
            "with a tangent vector, and with it whether that is quasi-periodic, chaotic or on its way to a "
            "longer period. An interrupted run is finished by --resume, with the same bits. saltus plot "
            "draws the file, saltus export writes its tables.",
    .needs_scene = true,
    .together = true,
    .endings = cli_records,
    .kind = "sweep",
    .resumes = true,
    .tables = CLI_TABLES(CLI_TABLE(saltus_sweep_table, sweep, NULL)),
    .options = CLI_OPTIONS(&cli_set, &cli_section, &sweep_over, &start, &what, &transient, &cli_output,
                           &cli_resume, &sweep_json),
    .notes = "A least period is certain when the trajectory comes back to within 1e-9 of the state's scale, "
             "closes in on that, has as many impacts each time, and returns after a small random "
             "disturbance, which it would not to an unstable orbit. Where iteration is slow or cannot tell "
             "n/p from 2n/2p, Newton's method and the multipliers decide. What has no period up to --longest "
             "after --at-most periods is irregular; with --what lyapunov it is judged by the rules of saltus "
             "classify, from the one trajectory of the row. A start beyond a stop is told as that.\n"
             "--start carry follows the attractor from point to point, up and down, and keeps both apart, so "
             "that hysteresis shows. --seeds k starts from k initial states at each point and counts the "
             "distinct attractors. What --what does not ask for is not computed.\n"
             "Trajectories run side by side in SIMD lanes, on all cores, and under mpirun on many machines. "
             "The file is the same, byte for byte, for any number of lanes, threads and processes, and "
             "however often a run was killed and finished by --resume. It is plain HDF5 (layout in "
             "saltus/record.h), for h5py, MATLAB and Julia.",
    .examples = CLI_EXAMPLES({"sweep impact-oscillator --over omega=0.8:1.2:81 -o sweep.h5",
                              "a bifurcation diagram over 81 frequencies"},
                             {"plot sweep.h5 -o sweep.png", "draw it"},
                             {"sweep impact-oscillator --over omega=0.8:1.2:21 --over d=0.5:1.5:21 -o map.h5",
                              "a map of motions over two parameters"},
                             {"sweep pipe --over d=0.02,0.025,0.03 --set omega=41 --seeds 2 -o rows.csv",
                              "three clearances from two initial states each, as a table"}),
    .see = "plot export basins",
    .run = run,
};
