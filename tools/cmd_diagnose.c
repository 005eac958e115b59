/* saltus diagnose: the one-page sheet of a motion.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "motion/options.h"

static const cli_option data =
    CLI_OPTION("--data", CLI_TEXT, "file.h5", "keep the data there, and gnuplot's script beside it (.gp)");

/* Record one orbit of a periodic motion; of any other motion a representative stretch, and section points. */
static saltus_status record_motion(const saltus_system *system, const saltus_flow_options *flow,
                                   const saltus_motion *motion, saltus_trajectory *record,
                                   saltus_trajectory *section, saltus_message *message) {
    enum {
        unsettled_periods = 240,
        resting_periods = 4,
        orbit_samples = 960,
        samples = 240,
        section_points = 2000
    };
    const bool settled = saltus_verdict_settled(motion->verdict);
    long long periods = motion->periods ? motion->periods : settled ? resting_periods : unsettled_periods;
    int per_period = periods * samples < orbit_samples ? orbit_samples / (int)periods : samples;
    /* Restart in each period: a trajectory would leave an unstable orbit. */
    const saltus_trajectory_plan plan = {.periods = periods,
                                         .per_period = per_period,
                                         .points = motion->section_states,
                                         .orbit = motion->stable ? 0 : motion->periods};
    saltus_status status = saltus_trajectory_follow(system, motion->state, flow, &plan, record, message);
    return status == SALTUS_OK && !settled
               ? saltus_trajectory_record(system, motion->state, flow, 0, section_points, 1, section, message)
               : status;
}

static saltus_status diagnose(const cli_request *request, cli_setup *setup, const char **cut,
                              saltus_message *message) {
    enum { line_samples = 1024, density_samples = 256 };
    if (!request->output)
        return saltus_fail(message, SALTUS_BAD_INPUT, "diagnose: needs -o file.png, file.pdf or file.svg");
    const saltus_scene *scene = &setup->scene;
    saltus_classify_options how = cli_classify_options(request);
    saltus_motion motion = {0};
    saltus_trajectory record = {0}, section = {0};
    saltus_spectra spectra = {0};
    saltus_status status = cli_motion(request, setup, &how, &motion, message);
    const saltus_system *system = setup->system;
    const bool classified = status == SALTUS_OK, periodic = motion.verdict == SALTUS_PERIODIC,
               settled = saltus_verdict_settled(motion.verdict), analysed = periodic || !settled;
    if (classified && interrupt_asked())
        status = SALTUS_INTERRUPTED;
    if (status == SALTUS_OK)
        status = record_motion(system, &how.flow, &motion, &record, &section, message);
    if (status == SALTUS_OK && analysed) {
        /* Spectrum of the observed displacement, up to the frequencies that the page shows. */
        saltus_spectrum_options options = saltus_spectrum_defaults();
        options.flow = how.flow;
        options.quantity_count = 1;
        options.per_period = periodic ? line_samples : density_samples;
        options.periods = periodic ? 2LL * motion.periods : 0;
        status = saltus_motion_spectra(system, &motion, &options, &spectra, message);
    }
    if (status == SALTUS_OK) {
        const saltus_diagnosis diagnosis = {&motion, &record, settled ? NULL : &section,
                                            analysed ? &spectra : NULL};
        status = saltus_write_sheet(request->output, scene, system, &how.flow, &diagnosis, &request->look,
                                    cli_text(request, "--data"), message);
    }
    if (status == SALTUS_OK || (classified && interrupt_asked()))
        saltus_write_motion_text(stdout, scene, system, &motion);
    cli_tell_written(request, "figure", status);
    saltus_spectra_clear(&spectra);
    saltus_trajectory_clear(&section);
    saltus_trajectory_clear(&record);
    saltus_motion_clear(&motion);
    *cut = status != SALTUS_OK && interrupt_asked() ? "no figure was drawn" : NULL;
    return status;
}

const cli_command cmd_diagnose = {
    .name = "diagnose",
    .summary = "a motion on one page",
    .usage = "SCENE [--set key=value ...] [--from orbit] -o sheet.png|pdf|svg [--data out.h5]",
    .help = "Classify the motion and draw it on one page: phase portrait with stroboscopic points and the "
            "stop, time history, impact map, shapes of the structure, spectrum, multipliers; without a "
            "period the stroboscopic section and the convergence of the largest exponent. With --from an "
            "orbit or an equilibrium it is that, stable or not.",
    .needs_scene = true,
    .endings = cli_figures,
    .kind = "trajectory",
    .tables = CLI_TABLES(CLI_TABLE(saltus_classify_table, classify, NULL)),
    .options = CLI_OPTIONS(&cli_set, &cli_section, &cli_from, &cli_output, &data, CLI_FIGURE_OPTIONS),
    .examples =
        CLI_EXAMPLES({"diagnose chatter -o chatter.png", "one page of figures about a motion with chatter"},
                     {"diagnose impact-oscillator --set F=0.6 -o sheet.pdf --size two-columns",
                      "for a journal, 175 mm wide"},
                     {"diagnose impact-oscillator -o sheet.png --data sheet.h5",
                      "keep the record and the script of the figure"}),
    .see = "classify spectrum lyapunov",
    .work = diagnose,
};
