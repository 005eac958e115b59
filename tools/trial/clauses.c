/* Claims about ranges: the share of trajectories that satisfy them, what the others do, and where the claim
 * is true.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

#include <math.h>
#include <string.h>

enum { shown_labels = 7, shortest_range = 3 };

static bool within(const trial_cell *cell, double low, double high, double step) {
    return cell->value > low - 0.01 * step && cell->value < high + 0.01 * step;
}

double trial_share(const trial_survey *survey, const trial_clause *clause, int every) {
    long all = 0, fit = 0;
    for (int k = 0; k < survey->values * trial_starts; k++) {
        const trial_cell *cell = &survey->cells[k];
        if ((k / trial_starts + 1) % every != 0 ||
            !within(cell, clause->low, clause->high, survey->figure->step))
            continue;
        all++;
        fit += clause->asks(cell);
    }
    return all ? (double)fit / (double)all : NAN;
}

static int more_frequent(const void *a, const void *b) {
    const struct trial_count *x = a, *y = b;
    return x->count != y->count ? (x->count < y->count ? 1 : -1) : strcmp(x->label, y->label);
}

/* Kinds and labels within a range, most frequent first. */
static void write_labels(FILE *file, const trial_survey *survey, double low, double high) {
    trial_tally tally = {.kinds = 0};
    int shown = 0;
    for (int k = 0; k < survey->values * trial_starts; k++) {
        char label[trial_label_max];
        if (!within(&survey->cells[k], low, high, survey->figure->step))
            continue;
        trial_label(&survey->cells[k], label);
        trial_tally_add(&tally, label);
    }
    qsort(tally.of, (size_t)tally.kinds, sizeof *tally.of, more_frequent);
    for (; shown < tally.kinds && shown < shown_labels; shown++)
        fprintf(file, "%s%s %.0f %%", shown ? ", " : "", tally.of[shown].label,
                100.0 * tally.of[shown].count / tally.all);
    if (shown < tally.kinds)
        fprintf(file, ", %d others", tally.kinds - shown);
}

/* Tell what trajectories do in the range of a clause; its share. */
static double judge_clause(const trial_clause *clause, const trial_survey *survey, FILE *numbers,
                           FILE *prose) {
    const double share = trial_share(survey, clause, 1);
    double least = INFINITY, most = 0, contact = 0, all = 0, chaotic = 0, longer = 0;
    fprintf(numbers, "%s %g-%g: %.1f %%", survey->figure->key, clause->low, clause->high, 100 * share);
    fprintf(prose, "%s %g-%g, asked: %s. %.1f %% of the trajectories. Found: ", survey->figure->key,
            clause->low, clause->high, clause->words, 100 * share);
    write_labels(prose, survey, clause->low, clause->high);
    /* How much of the range is chaotic and how much has only a long period, how frequent impacts are, and how
     * long contacts last. */
    for (int k = 0; k < survey->values * trial_starts; k++) {
        const trial_cell *cell = &survey->cells[k];
        if (!within(cell, clause->low, clause->high, survey->figure->step))
            continue;
        all++;
        chaotic += cell->chaotic;
        longer += cell->kind == TRIAL_IRREGULAR && !cell->chaotic && cell->lyapunov < 0;
        contact += cell->contact;
        least = fmin(least, cell->rate);
        most = fmax(most, cell->rate);
    }
    fprintf(prose,
            "; %.0f %% chaotic by their exponents, %.0f %% irregular with a negative one: longer periods; "
            "%.3g to %.3g impacts per period; in contact %.1f %% of the time on average.\n",
            100 * chaotic / all, 100 * longer / all, least, most, 100 * contact / all);
    return share;
}

/* The ranges of a survey where at least half of the starts satisfy a clause's condition. */
static void write_ranges(FILE *prose, const trial_survey *survey, const trial_clause *clause) {
    int shorter = 0, written = 0;
    fprintf(prose, "In the whole figure: %s for %s ", clause->words, survey->figure->key);
    for (int v = 0, end; v < survey->values; v = end + 1) {
        for (end = v; end < survey->values; end++) {
            int fit = 0;
            for (int s = 0; s < trial_starts; s++)
                fit += clause->asks(&survey->cells[end * trial_starts + s]);
            if (2 * fit < trial_starts)
                break;
        }
        if (end - v >= shortest_range)
            fprintf(prose, "%s%g-%g", written++ ? ", " : "", survey->cells[v * trial_starts].value,
                    survey->cells[(end - 1) * trial_starts].value);
        else
            shorter += end > v;
    }
    if (!written)
        fprintf(prose, "nowhere over %d values in a row or more", shortest_range);
    if (shorter)
        fprintf(prose, ", and %d shorter ranges", shorter);
    fprintf(prose, ".\n");
}

trial_verdict trial_judge_clauses(const trial_claim *claim, trial_bench *bench, FILE *numbers, FILE *prose) {
    double shares[trial_clauses_max];
    const trial_clause *clauses = claim->clauses;
    const int count = trial_clause_count(claim);
    for (int k = 0; k < count; k++) {
        fprintf(numbers, "%s", k ? "; " : "");
        shares[k] = judge_clause(&clauses[k], trial_survey_of(bench, clauses[k].figure, 0), numbers, prose);
    }
    for (int k = 0; k < count; k++)
        if (k == 0 || clauses[k].asks != clauses[k - 1].asks)
            write_ranges(prose, trial_survey_of(bench, clauses[k].figure, 0), &clauses[k]);
    return trial_verdict_of(shares, count);
}
