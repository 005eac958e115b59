/* The page of verdicts: rules, table, a section for each claim, and the results of the naive method.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

enum { claims_max = 32 };

trial_finding trial_judge(const trial_claim *claim, trial_bench *bench) {
    trial_finding finding = {.numbers = NULL};
    size_t size[2];
    FILE *numbers = open_memstream(&finding.numbers, &size[0]);
    FILE *prose = open_memstream(&finding.prose, &size[1]);
    saltus_message message = {.text = ""};
    if (numbers && prose)
        finding.verdict = (claim->judge ? claim->judge : trial_judge_clauses)(claim, bench, numbers, prose);
    if (!numbers || !prose || fclose(numbers) || fclose(prose))
        must(saltus_fail(&message, SALTUS_NO_MEMORY, "no memory for a finding"), &message);
    return finding;
}

void trial_finding_clear(trial_finding *finding) {
    free(finding->numbers);
    free(finding->prose);
}

void trial_write_row(FILE *file, const trial_claim *claim, const trial_finding *finding) {
    fprintf(file, "| %s | %s: %s | **%s** | %s | ", claim->id, claim->where, claim->says,
            trial_verdict_words[finding->verdict], finding->numbers);
    if (claim->picture)
        fprintf(file, "[%s](%s) | ", claim->picture, claim->picture);
    else
        fprintf(file, "`build/saltus paper --figure %s` | ", claim->figure);
    fprintf(file, "`build/saltus_trial %s` |\n", claim->id);
}

void trial_write_section(FILE *file, const trial_claim *claim, const trial_finding *finding) {
    fprintf(file, "### %s: %s\n\n%s: %s.\n\n", claim->id, trial_verdict_words[finding->verdict], claim->where,
            claim->says);
    bool fresh = true;
    for (const char *c = finding->prose; *c; c++) {
        fprintf(file, "%s%c", fresh ? "- " : "", *c);
        fresh = *c == '\n';
    }
    fprintf(file, "\n");
}

static void write_head(FILE *file, bool quick) {
    const int coarser = quick ? trial_figure_find("5")->quick : 1;
    fprintf(file,
            "# The 2020 paper on trial\n\nClaims of Wang et al. 2020, doi 10.6052/0459-1879-20-137, against "
            "what the same equations do when every impact is located. One command writes this page, its "
            "tables and its figures: `sh tools/trial.sh%s`. `build/saltus_trial F5b` computes one row anew "
            "and prints it with what it rests on.\n\n",
            quick ? " --quick" : "");
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

static void write_naive(FILE *file, FILE *rows, trial_bench *bench) {
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
    trial_write_steps(file, rows, bench->quick);
    int coarser = bench->quick ? trial_figure_find("5")->quick : 1;
    fprintf(file,
            "\n![Stroboscopic points and impacts per period of the naive method against its "
            "step](figures/naive.png)\n\n### Figure by figure\n\nAt values %g apart in omega (%g in d), from "
            "the same initial states: the part of the trajectories that the naive method classes otherwise, "
            "doublings of the period of impact motion aside. *Kind* is one of free, impacts, chatter, held, "
            "irregular; *deepest* is the largest penetration of the stop. Figure 2, without a stop, is the "
            "control. `build/saltus_trial naive-figures` repeats it.\n\n",
            coarser * trial_figure_find("5")->sparse * trial_figure_find("5")->step,
            coarser * trial_figure_find("4a")->sparse * trial_figure_find("4a")->step);
    trial_write_figures(file, bench);
    fputs("\n### Clause by clause\n\nShares of the clauses by both methods, at the same values. Where the "
          "naive method agrees with the paper and the exact flow does not, the claim is the method's doing. "
          "`build/saltus_trial naive-claims` repeats it.\n\n",
          file);
    trial_write_shares(file, bench);
}

void trial_write_page(trial_bench *bench, const char *folder) {
    enum { page, windows, classes, steps, files };
    static const char *const names[files] = {"paper.md", "paper/windows.csv", "paper/classes.csv",
                                             "paper/naive-steps.csv"};
    trial_finding findings[claims_max];
    FILE *file[files] = {NULL};
    saltus_message message = {.text = ""};
    int count = 0;
    bool good = true;
    for (; trial_claim_at(count) && count < claims_max; count++) {
        fprintf(stderr, "saltus_trial: %s\n", trial_claim_at(count)->id);
        findings[count] = trial_judge(trial_claim_at(count), bench);
    }
    for (int k = 0; k < files; k++) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", folder, names[k]);
        file[k] = fopen(path, "w");
        good = good && file[k];
    }
    if (good) {
        write_head(file[page], bench->quick);
        write_table(file[page], findings, count);
        write_naive(file[page], file[steps], bench);
        fprintf(file[page], "\n## Claim by claim\n\n");
        for (int k = 0; k < count; k++)
            trial_write_section(file[page], trial_claim_at(k), &findings[k]);
        trial_write_windows(file[windows], bench);
        trial_write_classes(file[classes], bench);
    }
    for (int k = 0; k < files; k++) {
        good = good && !(file[k] && ferror(file[k]));
        good = !(file[k] && fclose(file[k])) && good;
    }
    if (!good)
        must(saltus_fail(&message, SALTUS_IO, "cannot write paper.md and paper/*.csv in %s", folder),
             &message);
    for (int k = 0; k < count; k++)
        trial_finding_clear(&findings[k]);
}
