/* saltus_trial: the claims of the 2020 paper, row by row, against the event-driven flow.
 *
 *     saltus_trial F5b F7b               these rows, with their evidence
 *     saltus_trial naive                 the naive method at d = 0.03, omega = 43 against its step
 *     saltus_trial naive-figures         where it differs, figure by figure; naive-claims: claim by claim
 *     saltus_trial naive-points          the data of data/figures/naive.png
 *     saltus_trial page FOLDER           everything, as paper.md and paper/ in the folder
 *
 * Options: --quick is coarser; --keep FOLDER stores finished surveys, a trajectory on each line, and reuses
 * those stored. Run it in the project's folder, which contains data/reference.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "claims.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Execute one word of the command line; `next` is the word after it, or NULL. */
static saltus_status obey(const char *word, const char *next, trial_bench *bench, saltus_message *message) {
    int k = 0;
    saltus_status status;
    while (trial_claim_at(k) && strcmp(trial_claim_at(k)->id, word) != 0)
        k++;
    const trial_claim *claim = trial_claim_at(k);
    if (claim) {
        trial_finding finding;
        status = trial_judge(claim, bench, &finding, message);
        if (status == SALTUS_OK) {
            trial_write_row(stdout, claim, &finding);
            printf("\n");
            trial_write_section(stdout, claim, &finding);
        }
        trial_finding_clear(&finding);
        return status;
    }
    if (strcmp(word, "naive") == 0) {
        /* The rows come after the table. */
        char *rows_text = NULL;
        size_t size;
        FILE *rows = open_memstream(&rows_text, &size);
        if (!rows)
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for rows");
        status = trial_write_steps(stdout, rows, &bench->request, message);
        fclose(rows);
        printf("\n%s", status == SALTUS_OK ? rows_text : "");
        free(rows_text);
        return status;
    }
    if (strcmp(word, "naive-figures") == 0)
        return trial_write_figures(stdout, bench, message);
    if (strcmp(word, "naive-claims") == 0)
        return trial_write_shares(stdout, bench, message);
    if (strcmp(word, "naive-points") == 0)
        return trial_write_step_points(stdout, bench->request.quick, message);
    if (strcmp(word, "page") == 0 && next)
        return trial_write_page(bench, next, message);
    return saltus_fail(message, SALTUS_BAD_INPUT,
                       "no claim %s: F2a ... F8, naive, naive-figures, naive-claims, naive-points or page "
                       "FOLDER",
                       word);
}

int main(int count, char **arguments) {
    enum { done, failed, bad_input };
    trial_bench bench = {.request = {.quick = false}};
    saltus_message message = {.text = ""};
    saltus_status status = SALTUS_OK;
    int words = 0; /* moved to the front of the arguments, without the options */
    bool good = true;
    for (int k = 1; k < count && good; k++)
        if (strcmp(arguments[k], "--quick") == 0)
            bench.request.quick = true;
        else if (strcmp(arguments[k], "--keep") == 0 && arguments[k + 1])
            bench.request.keep = arguments[++k];
        else if (arguments[k][0] == '-')
            good = false;
        else
            arguments[words++] = arguments[k];
    if (!good || words == 0) {
        fprintf(stderr, "usage: saltus_trial [--quick] [--keep FOLDER] CLAIM ... | naive | naive-figures | "
                        "naive-claims | naive-points | page FOLDER\n");
        return bad_input;
    }
    if (bench.request.keep && mkdir(bench.request.keep, 0777) && errno != EEXIST)
        status = saltus_fail(&message, SALTUS_IO, "cannot make the folder %s", bench.request.keep);
    const bool page = strcmp(arguments[0], "page") == 0;
    for (int k = 0; k < words && status == SALTUS_OK; k += 1 + page)
        status = obey(arguments[k], k + 1 < words ? arguments[k + 1] : NULL, &bench, &message);
    trial_bench_clear(&bench);
    if (status != SALTUS_OK)
        fprintf(stderr, "saltus_trial: %s\n", message.text);
    return status == SALTUS_OK ? done : status == SALTUS_BAD_INPUT ? bad_input : failed;
}
