/* Surveys shared by several claims.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "claims.h"

#include <string.h>

const double trial_coarse[trial_coarse_steps] = {0.01, 0.005, 0.001, 0.0002};

saltus_status trial_bench_survey(trial_bench *bench, const char *figure, int step,
                                 const trial_survey **survey, saltus_message *message) {
    int k = 0;
    while (k < trial_figures && trial_figure_at(k) && strcmp(trial_figure_at(k)->name, figure) != 0)
        k++;
    if (k == trial_figures || !trial_figure_at(k))
        return saltus_fail(message, SALTUS_BAD_INPUT, "no figure %s", figure);
    trial_survey *wanted = step < 0 ? &bench->exact[k] : &bench->naive[k][step];
    *survey = wanted;
    return wanted->cells ? SALTUS_OK
                         : trial_survey_get(trial_figure_at(k), step < 0 ? 0 : trial_coarse[step],
                                            &bench->request, wanted, message);
}

void trial_bench_clear(trial_bench *bench) {
    for (int k = 0; k < trial_figures; k++) {
        trial_survey_clear(&bench->exact[k]);
        for (int s = 0; s < trial_coarse_steps; s++)
            trial_survey_clear(&bench->naive[k][s]);
    }
}
