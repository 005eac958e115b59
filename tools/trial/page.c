/* The page of verdicts: rules, table, a section for each claim, and the results of the naive method.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "page.h"

#include "compare.h"
#include "steps.h"

#include <stdlib.h>

enum { claims_max = 32 };

void trial_write_row(FILE *file, const trial_claim *claim, const trial_finding *finding) {
    fprintf(file, "| %s | %s: %s | **%s** | %s | ", claim->id, claim->where, claim->says,
            trial_verdict_word(finding->verdict), finding->numbers_text);
    if (claim->picture)
        fprintf(file, "[%s](%s) | ", claim->picture, claim->picture);
    else
        fprintf(file, "`build/saltus paper --figure %s` | ", claim->figure);
    fprintf(file, "`build/saltus_trial %s` |\n", claim->id);
}

void trial_write_section(FILE *file, const trial_claim *claim, const trial_finding *finding) {
    fprintf(file, "### %s: %s\n\n%s: %s.\n\n", claim->id, trial_verdict_word(finding->verdict), claim->where,
            claim->says);
    bool fresh = true;
    for (const char *c = finding->prose_text; *c; c++) {
        fprintf(file, "%s%c", fresh ? "- " : "", *c);
        fresh = *c == '\n';
    }
    fprintf(file, "\n");
}

static void write_how(FILE *file, const trial_request *request) {
    int coarser = request->quick ? trial_figure_find("5")->quick : 1;
    fprintf(file,
            "**How.** Each figure's range is visited in steps of %g in omega (%g for Figure 8; %g in d)%s, "
            "at each value from %d initial states, ",
            coarser * trial_figure_find("5")->step, coarser * trial_figure_find("8a")->step,
            coarser * trial_figure_find("4a")->step, coarser > 1 ? ", a coarse run" : "", (int)trial_starts);
    fputs("the same at all values: the scene's own and random ones. A trajectory counts as periodic when a "
          "period up to 20 T has become certain within 500 periods; otherwise its largest exponent is "
          "measured over at most 2000 periods. *Chaotic* is proven by that; *irregular* is everything "
          "without a period up to 20. n/p is n impacts in p forcing periods.\n\n",
          file);
}

static void write_head(FILE *file, const trial_request *request) {
    fprintf(file,
            "# The 2020 paper on trial\n\nClaims of Wang et al. 2020, doi 10.6052/0459-1879-20-137, against "
            "what the same equations do when every impact is located. One command writes this page, its "
            "tables and its figures: `sh tools/trial.sh%s`. `build/saltus_trial F5b` computes one row anew "
            "and prints it with what it rests on.\n\n",
            request->quick ? " --quick" : "");
    write_how(file, request);
    fputs("**Rule.** A claim is made of clauses. The share of a clause is the part of the trajectories in "
          "its range that do what it says. A claim *holds* where every clause has 95 % and more, *does not "
          "hold* where none has 50 %, and else holds *in part*. Claims about one motion are judged likewise "
          "by the share of random initial states that lead to it; what the others are asked is said in their "
          "sections.\n\n",
          file);
}

static const char *const trial_head =
    "| id | claim | verdict | numbers | figure | command |\n| --- | --- | --- | --- | --- | --- |\n";

static void write_table(FILE *file, const trial_finding *findings, int count) {
    int tally[3] = {0};
    fprintf(file, "## Verdicts\n\n%s", trial_head);
    for (int k = 0; k < count; k++) {
        trial_write_row(file, trial_claim_at(k), &findings[k]);
        tally[findings[k].verdict]++;
    }
    fprintf(file, "\nOf %d claims %d hold, %d hold in part, %d do not hold.\n\n", count, tally[TRIAL_HOLDS],
            tally[TRIAL_IN_PART], tally[TRIAL_DOES_NOT_HOLD]);
    fprintf(file, "[paper/windows.csv](paper/windows.csv) lists, for each figure, the ranges of one dominant "
                  "class with the share of the starts that come to it\nand the part proven chaotic; "
                  "[paper/classes.csv](paper/classes.csv) how many starts come to which kind at each "
                  "value.\n\n![Kinds of motion against the pulsation frequency, with the ranges that the "
                  "paper names](figures/trial.png)\n\n![Kinds of motion against the "
                  "clearance](figures/trial-clearance.png)\n\n");
}

static saltus_status write_naive(FILE *file, FILE *rows, trial_bench *bench, saltus_message *message) {
    fputs("## How much is the method's doing\n\nThe paper integrates with a fixed fourth-order Runge-Kutta "
          "step and looks for contact at step ends; it does not give the step. `tests/naive` does the same, "
          "under the name of *the naive method* (not for use): a velocity that points into the stop is "
          "reversed at the first step end beyond it, the displacement stays where it is. A motion's class is "
          "told from 61 section points with a tolerance for the jitter of impacts that are noticed up to h "
          "late (`tests/naive/naive_class.h`); reversals at successive steps count as one impact.\n\n### d = "
          "0.03, omega = 43, step by step\n\nThe paper says 4/5; the exact flow has one stable orbit, 3/5. "
          "The column 4/5 counts starts that come to four impacts in five periods or a multiple of both. "
          "`build/saltus_trial naive` repeats the table.\n\n",
          file);
    saltus_status status = trial_write_steps(file, rows, &bench->request, message);
    if (status != SALTUS_OK)
        return status;
    int coarser = bench->request.quick ? trial_figure_find("5")->quick : 1;
    fprintf(file,
            "\n![Stroboscopic points and impacts per period of the naive method against its "
            "step](figures/naive.png)\n\n### Figure by figure\n\nAt values %g apart in omega (%g in d), from "
            "the same initial states: the part of the trajectories that the naive method classes otherwise, "
            "doublings of the period of impact motion aside. *Kind* is one of free, impacts, chatter, held, "
            "irregular; *deepest* is the largest penetration of the stop. Figure 2, without a stop, is the "
            "control. `build/saltus_trial naive-figures` repeats it.\n\n",
            coarser * trial_figure_find("5")->sparse * trial_figure_find("5")->step,
            coarser * trial_figure_find("4a")->sparse * trial_figure_find("4a")->step);
    status = trial_write_figures(file, bench, message);
    if (status != SALTUS_OK)
        return status;
    fputs("\n### Clause by clause\n\nShares of the clauses by both methods, at the same values. Where the "
          "naive method agrees with the paper and the exact flow does not, the claim is the method's doing. "
          "`build/saltus_trial naive-claims` repeats it.\n\n",
          file);
    return trial_write_shares(file, bench, message);
}

static saltus_status judge_all(trial_bench *bench, trial_finding *findings, int *count,
                               saltus_message *message) {
    saltus_status status = SALTUS_OK;
    for (*count = 0; trial_claim_at(*count) && *count < claims_max && status == SALTUS_OK; (*count)++) {
        fprintf(stderr, "saltus_trial: %s\n", trial_claim_at(*count)->id);
        status = trial_judge(trial_claim_at(*count), bench, &findings[*count], message);
    }
    return status;
}

typedef struct page_files {
    FILE *page, *windows, *classes, *steps;
} page_files;

static FILE *open_in(const char *folder, const char *name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return fopen(path, "w");
}

/* False if a file could not be written completely. */
static bool close_files(page_files *files) {
    FILE *all[] = {files->page, files->windows, files->classes, files->steps};
    bool good = true;
    for (int k = 0; k < 4; k++) {
        good &= all[k] && !ferror(all[k]);
        good &= !all[k] || !fclose(all[k]);
    }
    return good;
}

static saltus_status write_all(page_files *files, trial_bench *bench, const trial_finding *findings,
                               int count, saltus_message *message) {
    write_head(files->page, &bench->request);
    write_table(files->page, findings, count);
    saltus_status status = write_naive(files->page, files->steps, bench, message);
    fprintf(files->page, "\n## Claim by claim\n\n");
    for (int k = 0; k < count; k++)
        trial_write_section(files->page, trial_claim_at(k), &findings[k]);
    if (status == SALTUS_OK)
        status = trial_write_windows(files->windows, bench, message);
    return status == SALTUS_OK ? trial_write_classes(files->classes, bench, message) : status;
}

saltus_status trial_write_page(trial_bench *bench, const char *folder, saltus_message *message) {
    trial_finding findings[claims_max] = {{.verdict = TRIAL_DOES_NOT_HOLD}};
    int count;
    saltus_status status = judge_all(bench, findings, &count, message);
    if (status == SALTUS_OK) {
        page_files files = {open_in(folder, "paper.md"), open_in(folder, "paper/windows.csv"),
                            open_in(folder, "paper/classes.csv"), open_in(folder, "paper/naive-steps.csv")};
        bool open = files.page && files.windows && files.classes && files.steps;
        if (open)
            status = write_all(&files, bench, findings, count, message);
        if (!close_files(&files) && status == SALTUS_OK)
            status = saltus_fail(message, SALTUS_IO, "cannot write paper.md and paper/*.csv in %s", folder);
    }
    for (int k = 0; k < claims_max; k++)
        trial_finding_clear(&findings[k]);
    return status;
}
