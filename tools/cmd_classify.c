/* saltus classify: what does the system settle on?
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "motion/options.h"
#include "progress.h"

#include <math.h>

static const cli_option seeds =
    CLI_NUMBER("--seeds", "k", "classify from k random initial states, list the attractors", 0, 1, 1e6);
static const cli_option seed =
    CLI_NUMBER("--seed", "s", "seed of the random initial states", 1, 0, 4294967295.0);

static const char so_far[] = "this is what was found so far";

static void show_seeds(void *context, double done, double seeds) {
    (void)context;
    /* Short enough for 30 columns. */
    progress_line("%.0f of %.0f seeds done + %.0f %%", floor(done), seeds, 100 * (done - floor(done)));
}

static saltus_status classify(const cli_request *request, cli_setup *setup, const char **cut,
                              saltus_message *message) {
    const long seeds = cli_whole(request, "--seeds"), seed = cli_whole(request, "--seed");
    saltus_classify_options how = cli_classify_options(request);
    saltus_attractors found;
    saltus_motion motion;
    saltus_status status;
    if (seeds && cli_shows_progress(request))
        how.progress.show = show_seeds;
    if (seeds)
        status =
            saltus_attractors_find(setup->system, (int)seeds, (unsigned long)seed, &how, &found, message);
    else
        status = saltus_classify(setup->system, setup->start.state, &how, &motion, message);
    cli_progress_end(request);
    if (status != SALTUS_OK)
        return status;
    if (seeds) {
        saltus_write_attractors(stdout, &setup->scene, setup->system, &found, cli_given(request, "--json"));
        *cut = found.seeds < seeds ? so_far : NULL;
        saltus_attractors_clear(&found);
    } else {
        cli_print_motion(request, setup, &motion);
        *cut = interrupt_asked() && motion.verdict == SALTUS_UNDECIDED ? so_far : NULL;
        saltus_motion_clear(&motion);
    }
    return SALTUS_OK;
}

const cli_command cmd_classify = {
    .name = "classify",
    .summary = "what a system settles on",
    .usage = "SCENE [--set key=value ...] [--json] [--seeds k]",
    .help = "Settle on the attractor, find its least period, polish the orbit by Newton's method and report "
            "n/p, contacts, events, multipliers, stability and symmetry.",
    .needs_scene = true,
    .tables = CLI_TABLES(CLI_TABLE(saltus_classify_table, classify, NULL)),
    .options = CLI_OPTIONS(&cli_set, &cli_section, &cli_json, &seeds, &seed),
    .notes =
        "n/p means n impacts in p forcing periods; chatter/p has infinitely many impacts, which end in "
        "sticking; held means that the contact never opens. Without forcing p counts returns to the section, "
        "the maxima of what is observed (a lasting contact or complete chatter is one); the period is told "
        "in units of time, and the multiplier 1 along the flow, trivial_multiplier, apart from the others; "
        "state is the highest of them, and time_over_T counts the orbit's own period. While fewer than 8 "
        "returns have come, up to 20 times --transient is waited for them, if that takes no more steps of "
        "the "
        "flow.\n"
        "Periodic: found by Newton's method, and stable. Chaotic: the largest Lyapunov exponent is positive "
        "by 3 standard errors over the whole run and by 2 in each half of it; none of 8 trajectories has "
        "left the motion, for so long that its mean lifetime is at least --lifetime periods with 95 % "
        "confidence (M trajectories of L periods: M L / 3; the bound is printed); and no stable orbit of a "
        "period up to 64 lies amid it. Transient: one has left, or a stable orbit lies amid it, with where "
        "it ends and the lifetime from the times of escape. Quasi-periodic: an exponent of zero, known to "
        "5e-5 per period, section points on closed curves with a spectrum of lines, and no locking to an "
        "orbit of up to 1024 periods. Long-period: the exponent is negative, no period was found, or "
        "rounding decides which. Irregular: no period found, exponents not measured, or not for long enough. "
        "Undecided: measured, with what is lacking and how long a run would tell. Intermittency is noted; "
        "the 0-1 test and the correlation dimension of the section points stand beside the exponent as "
        "second opinions.\n"
        "--json gives label, impacts (null with chatter), periods, sticking_intervals, impacts_by_side, "
        "state (displacements, then velocities, at section phase 0), section_states, events (event, side, "
        "time_over_T, normal_velocity_before), multipliers ([re, im] by decreasing modulus; of a rest "
        "without forcing eigenvalues, by decreasing real part) with log_moduli, stable, mirror, residual, "
        "sum_rule; of motions without a period lyapunov with lyapunov_standard_error, lifetime_at_least and "
        "evidence; reason, parameters, version.",
    .examples = CLI_EXAMPLES(
        {"classify impact-oscillator", "the motion that the built-in scene settles on"},
        {"classify pipe --set omega=41 d=0.03 --json", "the same at other parameters, as one JSON object"},
        {"classify impact-pair --seeds 20",
         "the attractors that 20 random initial states lead to, with their shares"}),
    .see = "orbit diagnose lyapunov sweep",
    .work = classify,
};
