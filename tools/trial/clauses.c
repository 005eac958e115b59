/* Claims about ranges: the share of trajectories that satisfy them, what the others do, and where the claim
 * is true.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "claims.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { kept_labels = 256, shown_labels = 7, shortest_range = 3 };

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

typedef struct label_count {
    char label[trial_label_max];
    int count;
} label_count;

static int more_frequent(const void *a, const void *b) {
    const label_count *x = a, *y = b;
    return x->count != y->count ? (x->count < y->count ? 1 : -1) : strcmp(x->label, y->label);
}

/* Kinds and labels within a range, most frequent first. */
static void write_labels(FILE *file, const trial_survey *survey, double low, double high) {
    label_count counts[kept_labels] = {0};
    int kinds = 0, all = 0, shown = 0;
    for (int k = 0; k < survey->values * trial_starts; k++) {
        char label[trial_label_max];
        int at = 0;
        if (!within(&survey->cells[k], low, high, survey->figure->step))
            continue;
        trial_label(&survey->cells[k], label);
        while (at < kinds && strcmp(counts[at].label, label) != 0)
            at++;
        if (at == kept_labels)
            continue;
        if (at == kinds)
            memcpy(counts[kinds++].label, label, sizeof label);
        counts[at].count++;
        all++;
    }
    qsort(counts, (size_t)kinds, sizeof counts[0], more_frequent);
    for (int k = 0; k < kinds && k < shown_labels; k++, shown++)
        fprintf(file, "%s%s %.0f %%", k ? ", " : "", counts[k].label, 100.0 * counts[k].count / all);
    if (shown < kinds)
        fprintf(file, ", %d others", kinds - shown);
}

static saltus_status judge_clause(const trial_clause *clause, trial_bench *bench, double *share,
                                  trial_finding *finding, saltus_message *message) {
    const trial_survey *survey;
    double least = INFINITY, most = 0, contact = 0, all = 0, chaotic = 0, longer = 0;
    saltus_status status = trial_bench_survey(bench, clause->figure, -1, &survey, message);
    if (status != SALTUS_OK)
        return status;
    *share = trial_share(survey, clause, 1);
    fprintf(finding->numbers, "%s %g-%g: %.1f %%", survey->figure->key, clause->low, clause->high,
            100 * *share);
    fprintf(finding->prose, "%s %g-%g, asked: %s. %.1f %% of the trajectories. Found: ", survey->figure->key,
            clause->low, clause->high, clause->words, 100 * *share);
    write_labels(finding->prose, survey, clause->low, clause->high);
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
    fprintf(finding->prose,
            "; %.0f %% chaotic by their exponents, %.0f %% irregular with a negative one: longer periods; "
            "%.3g to %.3g impacts per period; in contact %.1f %% of the time on average.\n",
            100 * chaotic / all, 100 * longer / all, least, most, 100 * contact / all);
    return SALTUS_OK;
}

saltus_status trial_judge_clauses(const trial_claim *claim, trial_bench *bench, trial_finding *finding,
                                  saltus_message *message) {
    const trial_survey *survey;
    double shares[trial_clauses_max];
    const int count = trial_clause_count(claim);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < count && status == SALTUS_OK; k++) {
        fprintf(finding->numbers, "%s", k ? "; " : "");
        status = judge_clause(&claim->clauses[k], bench, &shares[k], finding, message);
    }
    if (status == SALTUS_OK)
        finding->verdict = trial_verdict_of(shares, count);
    for (int k = 0; k < count && status == SALTUS_OK; k++) {
        const trial_clause *clause = &claim->clauses[k];
        if (k && clause->asks == claim->clauses[k - 1].asks)
            continue;
        status = trial_bench_survey(bench, clause->figure, -1, &survey, message);
        if (status != SALTUS_OK)
            break;
        fprintf(finding->prose, "In the whole figure: %s for %s ", clause->words, survey->figure->key);
        /* The ranges where at least half of the starts satisfy the condition. */
        int shorter = 0, written = 0;
        for (int v = 0, end; v < survey->values; v = end + 1) {
            for (end = v; end < survey->values; end++) {
                int fit = 0;
                for (int s = 0; s < trial_starts; s++)
                    fit += clause->asks(&survey->cells[end * trial_starts + s]);
                if (2 * fit < trial_starts)
                    break;
            }
            if (end - v >= shortest_range)
                fprintf(finding->prose, "%s%g-%g", written++ ? ", " : "",
                        survey->cells[v * trial_starts].value, survey->cells[(end - 1) * trial_starts].value);
            else
                shorter += end > v;
        }
        if (!written)
            fprintf(finding->prose, "nowhere over %d values in a row or more", shortest_range);
        if (shorter)
            fprintf(finding->prose, ", and %d shorter ranges", shorter);
        fprintf(finding->prose, ".\n");
    }
    return status;
}
