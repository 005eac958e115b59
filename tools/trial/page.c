/* The page of verdicts: rules, table, a section for each claim, and the results of the naive method.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "claims.h"

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

static void write_head(FILE *file, const trial_request *request) {
    const int coarser = request->quick ? trial_figure_find("5")->quick : 1;
    fprintf(file,
            "# The 2020 paper on trial\n\nClaims of Wang et al. 2020, doi 10.6052/0459-1879-20-137, against "
            "what the same equations do when every impact is located. One command writes this page, its "
            "tables and its figures: `sh tools/trial.sh%s`. `build/saltus_trial F5b` computes one row anew "
            "and prints it with what it rests on.\n\n",
            request->quick ? " --quick" : "");
    fprintf(file,
            "**How.** Each figure's range is visited in steps of %g in omega (%g for Figure 8; %g in d)%s, "
            "at each value from %d initial states, ",
            coarser * trial_figure_find("5")->step, coarser * trial_figure_find("8a")->step,
            coarser * trial_figure_find("4a")->step, coarser > 1 ? ", a coarse run" : "", (int)trial_starts);
    fputs("the same at all values: the scene's own and random ones. A trajectory counts as periodic when a "
          "period up to 20 T has become certain within 500 periods; otherwise its largest exponent is "
          "measured over at most 2000 periods. *Chaotic* is proven by that; *irregular* is everything "
          "without a period up to 20. n/p is n impacts in p forcing periods.\n\n"
          "**Rule.** A claim is made of clauses. The share of a clause is the part of the trajectories in "
          "its range that do what it says. A claim *holds* where every clause has 95 % and more, *does not "
          "hold* where none has 50 %, and else holds *in part*. Claims about one motion are judged likewise "
          "by the share of random initial states that lead to it; what the others are asked is said in their "
          "sections.\n\n",
          file);
}

static void write_table(FILE *file, const trial_finding *findings, int count) {
    int tally[3] = {0};
    fputs("## Verdicts\n\n| id | claim | verdict | numbers | figure | command |\n"
          "| --- | --- | --- | --- | --- | --- |\n",
          file);
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

saltus_status trial_write_page(trial_bench *bench, const char *folder, saltus_message *message) {
    enum { page, windows, classes, steps, files };
    static const char *const names[files] = {"paper.md", "paper/windows.csv", "paper/classes.csv",
                                             "paper/naive-steps.csv"};
    trial_finding findings[claims_max] = {{.verdict = TRIAL_DOES_NOT_HOLD}};
    FILE *file[files] = {NULL};
    int count = 0;
    saltus_status status = SALTUS_OK;
    for (; trial_claim_at(count) && count < claims_max && status == SALTUS_OK; count++) {
        fprintf(stderr, "saltus_trial: %s\n", trial_claim_at(count)->id);
        status = trial_judge(trial_claim_at(count), bench, &findings[count], message);
    }
    bool good = true;
    for (int k = 0; k < files && status == SALTUS_OK; k++) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", folder, names[k]);
        file[k] = fopen(path, "w");
        good = good && file[k];
    }
    if (status == SALTUS_OK && good) {
        write_head(file[page], &bench->request);
        write_table(file[page], findings, count);
        status = write_naive(file[page], file[steps], bench, message);
        fprintf(file[page], "\n## Claim by claim\n\n");
        for (int k = 0; k < count; k++)
            trial_write_section(file[page], trial_claim_at(k), &findings[k]);
        if (status == SALTUS_OK)
            status = trial_write_windows(file[windows], bench, message);
        if (status == SALTUS_OK)
            status = trial_write_classes(file[classes], bench, message);
    }
    for (int k = 0; k < files; k++) {
        good = good && !(file[k] && ferror(file[k]));
        good = !(file[k] && fclose(file[k])) && good;
    }
    if (!good && status == SALTUS_OK)
        status = saltus_fail(message, SALTUS_IO, "cannot write paper.md and paper/*.csv in %s", folder);
    for (int k = 0; k < claims_max; k++)
        trial_finding_clear(&findings[k]);
    return status;
}
