/* saltus spectrum: lines and power spectral density of a motion.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "motion/options.h"

#include <string.h>

static const cli_option of = CLI_OPTION(
    "--of", CLI_LIST, "what",
    "displacement, velocity, q3, v2, a name of the state or one that the scene observes; at most two, such "
    "as q1,q2 (default the first two)");

static saltus_status analyse(const cli_request *request, cli_setup *setup, const char **cut,
                             saltus_message *message) {
    (void)cut;
    const saltus_scene *scene = &setup->scene;
    const cli_list *given = cli_values(request, "--of");
    const bool json = cli_given(request, "--json");
    saltus_classify_options how = cli_classify_options(request);
    saltus_spectrum_options wishes = request->spectrum;
    saltus_motion motion = {0};
    saltus_spectra spectra = {0};
    if (wishes.per_period % 4)
        return saltus_fail(message, SALTUS_BAD_INPUT, "--samples %d: must be a multiple of 4",
                           wishes.per_period);
    int asked = 0;
    for (int k = 0; k < given->count; k++)
        for (const char *at = given->items[k]; at; asked++) {
            const size_t length = strcspn(at, ",");
            char word[64];
            saltus_message reason = {.text = ""};
            snprintf(word, sizeof word, "%.*s", (int)length, at);
            if (asked == SALTUS_QUANTITIES_MAX)
                return saltus_fail(message, SALTUS_BAD_INPUT, "--of %.40s: only %d can be given", at,
                                   SALTUS_QUANTITIES_MAX);
            saltus_quantity *own = &wishes.quantities[asked];
            if (saltus_quantity_parse(setup->system, word, own, &reason) != SALTUS_OK)
                return saltus_fail(message, SALTUS_BAD_INPUT, "--of %s", reason.text);
            if (asked && own->coordinate == wishes.quantities[0].coordinate &&
                own->velocity == wishes.quantities[0].velocity)
                return saltus_fail(message, SALTUS_BAD_INPUT, "--of %.40s: is given twice", word);
            at = at[length] ? at + length + 1 : NULL;
        }
    wishes.quantity_count = asked ? asked : wishes.quantity_count;
    saltus_status status = cli_motion(request, setup, &how, &motion, message);
    const saltus_system *system = setup->system;
    if (status == SALTUS_OK && interrupt_asked() && !saltus_verdict_settled(motion.verdict))
        status = SALTUS_INTERRUPTED;
    if (status == SALTUS_OK)
        status = saltus_motion_spectra(system, &motion, &wishes, &spectra, message);
    if (status == SALTUS_OK && request->output)
        status = saltus_write_spectra(request->output, scene, system, &wishes.flow, &motion, &spectra,
                                      &request->look, message);
    if (status == SALTUS_OK)
        (json ? saltus_write_spectra_json : saltus_write_spectra_text)(stdout, scene, system, &motion,
                                                                       &spectra);
    if (request->output && !json)
        cli_tell_written(request, "written", status);
    saltus_spectra_clear(&spectra);
    saltus_motion_clear(&motion);
    return status;
}

const cli_command cmd_spectrum = {
    .name = "spectrum",
    .summary = "lines and power spectral density of a motion",
    .usage = "SCENE [--set key=value ...] [--from orbit] [--of what] [--json] [-o spectrum.png|pdf|svg|csv]",
    .help =
        "Settle on the attractor and analyse it: of periodic motion the lines of whole orbits, at multiples "
        "of omega/p; otherwise the power spectral density by Welch's method with its confidence band, and "
        "the lines that stand out. Says up to which frequency aliasing leaves it trustworthy.",
    .needs_scene = true,
    .endings = cli_figures_or_table,
    .kind = "spectrum",
    .tables = CLI_TABLES(CLI_TABLE(saltus_spectrum_table, spectrum, NULL),
                         CLI_TABLE(saltus_classify_table, classify, "--measure --lifetime")),
    .options =
        CLI_OPTIONS(&cli_set, &cli_section, &cli_from, &of, &cli_json, &cli_output, CLI_FIGURE_OPTIONS),
    .notes = "Spectra of periodic motion are taken over whole orbits, so that the lines at multiples of "
             "omega/p are exact; other motion gets Welch's density with a confidence band, the lines that "
             "stand out and the broadband fraction. Velocities are the lines and densities of the "
             "displacement, differentiated, so that their jumps do not alias; those of a quantity that the "
             "scene observes are of its samples. The highest trustworthy "
             "frequency is stated and what lies above is greyed.",
    .examples =
        CLI_EXAMPLES({"spectrum pipe", "the strongest lines of displacement and velocity"},
                     {"spectrum pipe --of velocity -o spectrum.csv", "all lines of the velocity as a table"}),
    .see = "lyapunov diagnose",
    .work = analyse,
};
