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

enum { done = 0, failed = 1, bad_input = 2 };

static saltus_status print_claim(const trial_claim *claim, trial_bench *bench, saltus_message *message) {
    trial_finding finding;
    saltus_status status = trial_judge(claim, bench, &finding, message);
    if (status == SALTUS_OK) {
        trial_write_row(stdout, claim, &finding);
        printf("\n");
        trial_write_section(stdout, claim, &finding);
    }
    trial_finding_clear(&finding);
    return status;
}

static const trial_claim *find_claim(const char *id) {
    for (int k = 0; trial_claim_at(k); k++)
        if (strcmp(trial_claim_at(k)->id, id) == 0)
            return trial_claim_at(k);
    return NULL;
}

static saltus_status print_steps(trial_bench *bench, saltus_message *message) {
    char *rows_text = NULL;
    size_t size;
    FILE *rows = open_memstream(&rows_text, &size);
    if (!rows)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for rows");
    saltus_status status = trial_write_steps(stdout, rows, &bench->request, message);
    fclose(rows);
    printf("\n%s", status == SALTUS_OK ? rows_text : "");
    free(rows_text);
    return status;
}

/* Execute one word of the command line; `next` points to the word after it, or is NULL. */
static saltus_status obey(const char *word, char *const *next, trial_bench *bench, saltus_message *message) {
    if (find_claim(word))
        return print_claim(find_claim(word), bench, message);
    if (strcmp(word, "naive") == 0)
        return print_steps(bench, message);
    if (strcmp(word, "naive-figures") == 0)
        return trial_write_figures(stdout, bench, message);
    if (strcmp(word, "naive-claims") == 0)
        return trial_write_shares(stdout, bench, message);
    if (strcmp(word, "naive-points") == 0)
        return trial_write_step_points(stdout, bench->request.quick, message);
    if (strcmp(word, "page") == 0 && next[0])
        return trial_write_page(bench, next[0], message);
    return saltus_fail(message, SALTUS_BAD_INPUT,
                       "no claim %s: F2a ... F8, naive, naive-figures, naive-claims, naive-points or page "
                       "FOLDER",
                       word);
}

/* Process the options; returns the remaining words, NULL-terminated, or NULL after a message. */
static char **read_options(char **arguments, trial_request *request) {
    char **words = arguments, **free_place = arguments;
    for (; *arguments; arguments++) {
        if (strcmp(*arguments, "--quick") == 0)
            request->quick = true;
        else if (strcmp(*arguments, "--keep") == 0 && arguments[1])
            request->keep = *++arguments;
        else if (**arguments == '-')
            return NULL;
        else
            *free_place++ = *arguments;
    }
    *free_place = NULL;
    return words;
}

int main(int count, char **arguments) {
    trial_bench bench = {.request = {.quick = false}};
    saltus_message message = {.text = ""};
    saltus_status status = SALTUS_OK;
    char **words = count > 1 ? read_options(arguments + 1, &bench.request) : NULL;
    if (!words || !*words) {
        fprintf(stderr, "usage: saltus_trial [--quick] [--keep FOLDER] CLAIM ... | naive | naive-figures | "
                        "naive-claims | naive-points | page FOLDER\n");
        return bad_input;
    }
    if (bench.request.keep && mkdir(bench.request.keep, 0777) && errno != EEXIST)
        status = saltus_fail(&message, SALTUS_IO, "cannot make the folder %s", bench.request.keep);
    const bool page = strcmp(*words, "page") == 0;
    for (; status == SALTUS_OK && *words; words += 1 + page)
        status = obey(*words, words + 1, &bench, &message);
    trial_bench_clear(&bench);
    if (status != SALTUS_OK)
        fprintf(stderr, "saltus_trial: %s\n", message.text);
    return status == SALTUS_OK ? done : status == SALTUS_BAD_INPUT ? bad_input : failed;
}
