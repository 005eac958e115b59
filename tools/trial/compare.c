/* Comparison of the naive method with the event-driven flow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

#include <math.h>
#include <string.h>

static bool same_label(const trial_cell *a, const trial_cell *b) {
    char x[trial_label_max], y[trial_label_max];
    trial_label(a, x);
    trial_label(b, y);
    return strcmp(x, y) == 0;
}

/* Whether two cells are of the same class. Doublings of the period of an impact motion are ignored, because
 * jitter hides them. */
static bool same_class(const trial_cell *a, const trial_cell *b) {
    bool impacts = a->kind == TRIAL_IMPACTS && b->kind == TRIAL_IMPACTS;
    return same_label(a, b) || (impacts && a->impacts * b->periods == b->impacts * a->periods);
}

void trial_write_figures(FILE *table, trial_bench *bench) {
    fprintf(table, "| figure | h | trajectories | another class than from the same start | a class that no "
                   "start has | another kind | deepest |\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for (int k = 0; k < trial_figures * (trial_steps - 1); k++) {
        const int step = 1 + k % (trial_steps - 1);
        const char *figure = trial_figure_list[k / (trial_steps - 1)].name;
        const trial_survey *exact = trial_survey_of(bench, figure, 0),
                           *naive = trial_survey_of(bench, figure, step);
        double all = 0, class = 0, unknown = 0, kind = 0, depth = 0;
        /* The naive method's trajectories at the values in both surveys. */
        for (int v = 0; v < naive->values; v++) {
            const trial_cell *there = naive->cells + (size_t)v * trial_starts, *right = exact->cells;
            int e = 0;
            while (e < exact->values && !(fabs(right->value - there->value) < 0.01 * exact->figure->step)) {
                right += trial_starts;
                e++;
            }
            for (int s = 0; s < trial_starts && e < exact->values; s++) {
                bool known = false;
                for (int other = 0; other < trial_starts; other++)
                    known |= same_class(&there[s], &right[other]);
                all++;
                class += !same_class(&there[s], &right[s]);
                unknown += !known;
                kind += there[s].kind != right[s].kind;
                depth = fmax(depth, there[s].depth);
            }
        }
        fprintf(table, "| %s | %g | %.0f | %.1f %% | %.1f %% | %.1f %% | %.1e |\n", figure, trial_h[step],
                all, class / (all / 100), unknown / (all / 100), kind / (all / 100), depth);
    }
}

void trial_write_shares(FILE *table, trial_bench *bench) {
    fprintf(table, "| claim | clause | exact |");
    for (int step = 1; step < trial_steps; step++)
        fprintf(table, " h = %g |", trial_h[step]);
    fprintf(table, "\n| --- | --- | --- |");
    for (int step = 1; step < trial_steps; step++)
        fprintf(table, " --- |");
    fprintf(table, "\n");
    for (int k = 0; trial_claim_at(k); k++)
        for (int c = 0; c < trial_clause_count(trial_claim_at(k)); c++) {
            const trial_clause *clause = &trial_claim_at(k)->clauses[c];
            const trial_figure *figure = trial_figure_find(clause->figure);
            fprintf(table, "| %s | %s %g-%g: %s |", trial_claim_at(k)->id, figure->key, clause->low,
                    clause->high, clause->words);
            for (int step = 0; step < trial_steps; step++)
                fprintf(table, " %.0f %% |",
                        100 * trial_share(trial_survey_of(bench, clause->figure, step), clause,
                                          step == 0 ? figure->sparse : 1));
            fprintf(table, "\n");
        }
}

/* The most frequent label among the starts at a value, and its count. */
static int dominant(const trial_cell *cells, char label[trial_label_max]) {
    int best = 0, of_best = 0;
    for (int s = 0; s < trial_starts; s++) {
        int count = 0;
        for (int other = 0; other < trial_starts; other++)
            count += same_label(&cells[s], &cells[other]);
        best = count > of_best ? s : best;
        of_best = count > of_best ? count : of_best;
    }
    trial_label(&cells[best], label);
    return of_best;
}

static void write_ranges(FILE *rows, const trial_survey *survey) {
    char label[trial_label_max], next[trial_label_max];
    for (int k = 0, end; k < survey->values; k = end) {
        int starts = dominant(survey->cells + (size_t)k * trial_starts, label), chaotic = 0;
        for (end = k + 1; end < survey->values; end++) {
            int more = dominant(survey->cells + (size_t)end * trial_starts, next);
            if (strcmp(next, label) != 0)
                break;
            starts += more;
        }
        for (int c = k * trial_starts; c < end * trial_starts; c++)
            chaotic += survey->cells[c].chaotic;
        fprintf(rows, "%s,%s,%g,%g,%d,%s,%.3f,%.3f\n", survey->figure->name, survey->figure->key,
                survey->cells[k * trial_starts].value, survey->cells[(end - 1) * trial_starts].value, end - k,
                label, (double)starts / ((end - k) * trial_starts),
                (double)chaotic / ((end - k) * trial_starts));
    }
}

void trial_write_windows(FILE *rows, trial_bench *bench) {
    fprintf(rows, "figure,key,from,to,values,class,share,chaotic\n");
    for (int k = 0; k < trial_figures; k++)
        write_ranges(rows, trial_survey_of(bench, trial_figure_list[k].name, 0));
}

static void write_counts(FILE *rows, const trial_survey *survey) {
    for (int k = 0; k < survey->values; k++) {
        const trial_cell *cells = survey->cells + (size_t)k * trial_starts;
        int counts[TRIAL_KINDS] = {0};
        double reach = 0;
        for (int s = 0; s < trial_starts; s++) {
            counts[cells[s].kind]++;
            reach = fmax(reach, cells[s].reach);
        }
        fprintf(rows, "%s,%g", survey->figure->name, cells->value);
        for (int kind = 0; kind < TRIAL_KINDS; kind++)
            fprintf(rows, ",%d", counts[kind]);
        fprintf(rows, ",%.6g\n", reach);
    }
}

void trial_write_classes(FILE *rows, trial_bench *bench) {
    fprintf(rows, "figure,value");
    for (int kind = 0; kind < TRIAL_KINDS; kind++)
        fprintf(rows, ",%s", trial_kind_words[kind]);
    fprintf(rows, ",reach\n");
    for (int k = 0; k < trial_figures; k++)
        write_counts(rows, trial_survey_of(bench, trial_figure_list[k].name, 0));
}
