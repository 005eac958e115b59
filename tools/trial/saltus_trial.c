/* saltus_trial: the claims of the 2020 paper, row by row, against the event-driven flow.
 *
 *     saltus_trial F5b F7b               these rows, with their evidence
 *     saltus_trial naive                 the naive method at d = 0.03, omega = 43 against its step
 *     saltus_trial naive-figures         where it differs, figure by figure; naive-claims: claim by claim
 *     saltus_trial naive-points          the data of data/figures/naive.png
 *     saltus_trial page FOLDER           everything, as paper.md and paper/ in the folder
 *
 * --quick is coarser. Run it in the project's folder, which contains data/reference.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

#include <string.h>

const char program_name[] = "saltus_trial";

enum { done, bad_input = 2 };

/* Execute one word of the command line; `next` is the word after it, or NULL. False if it says nothing. */
static bool obey(const char *word, const char *next, trial_bench *bench) {
    int k = 0;
    while (trial_claim_at(k) && strcmp(trial_claim_at(k)->id, word) != 0)
        k++;
    if (trial_claim_at(k)) {
        trial_finding finding = trial_judge(trial_claim_at(k), bench);
        trial_write_row(stdout, trial_claim_at(k), &finding);
        printf("\n");
        trial_write_section(stdout, trial_claim_at(k), &finding);
        trial_finding_clear(&finding);
    } else if (strcmp(word, "naive") == 0)
        trial_write_steps(stdout, stdout, bench->quick);
    else if (strcmp(word, "naive-figures") == 0)
        trial_write_figures(stdout, bench);
    else if (strcmp(word, "naive-claims") == 0)
        trial_write_shares(stdout, bench);
    else if (strcmp(word, "naive-points") == 0)
        trial_write_step_points(stdout, bench->quick);
    else if (strcmp(word, "page") == 0 && next)
        trial_write_page(bench, next);
    else
        return false;
    return true;
}

int main(int count, char **arguments) {
    trial_bench bench = {.quick = false};
    int words = 0; /* moved to the front of the arguments, without the options */
    bool good = true;
    for (int k = 1; k < count; k++)
        if (strcmp(arguments[k], "--quick") == 0)
            bench.quick = true;
        else if (arguments[k][0] == '-')
            good = false;
        else
            arguments[words++] = arguments[k];
    if (!good || words == 0) {
        fprintf(stderr, "usage: saltus_trial [--quick] CLAIM ... | naive | naive-figures | naive-claims | "
                        "naive-points | page FOLDER\n");
        return bad_input;
    }
    const bool page = strcmp(arguments[0], "page") == 0;
    for (int k = 0; k < words && good; k += 1 + page) {
        good = obey(arguments[k], k + 1 < words ? arguments[k + 1] : NULL, &bench);
        if (!good)
            fprintf(stderr,
                    "saltus_trial: no claim %s: F2a ... F8, naive, naive-figures, naive-claims, naive-points "
                    "or page FOLDER\n",
                    arguments[k]);
    }
    trial_bench_clear(&bench);
    return good ? done : bad_input;
}
