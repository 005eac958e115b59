/* Comparison of the naive method with the event-driven flow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "compare.h"

#include <math.h>
#include <string.h>

/* Fractions of the naive method's trajectories, at the values in both surveys. */
typedef struct difference {
    long all, class, unknown, kind;
    double depth; /* largest penetration relative to the clearance */
} difference;

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

/* The exact cells at a value; NULL where it was not visited. */
static const trial_cell *cells_at(const trial_survey *survey, double value) {
    for (int k = 0; k < survey->values; k++)
        if (fabs(survey->cells[k * trial_starts].value - value) < 0.01 * survey->figure->step)
            return survey->cells + (size_t)k * trial_starts;
    return NULL;
}

static difference differ(const trial_survey *exact, const trial_survey *naive) {
    difference d = {0};
    for (int k = 0; k < naive->values; k++) {
        const trial_cell *there = naive->cells + (size_t)k * trial_starts,
                         *right = cells_at(exact, there->value);
        for (int s = 0; s < trial_starts && right; s++) {
            bool known = false;
            for (int other = 0; other < trial_starts; other++)
                known |= same_class(&there[s], &right[other]);
            d.all++;
            d.class += !same_class(&there[s], &right[s]);
            d.unknown += !known;
            d.kind += there[s].kind != right[s].kind;
            d.depth = fmax(d.depth, there[s].depth);
        }
    }
    return d;
}

static void write_difference(FILE *table, const trial_figure *figure, double h, const difference *d) {
    double all = (double)d->all / 100;
    fprintf(table, "| %s | %g | %ld | %.1f %% | %.1f %% | %.1f %% | %.1e |\n", figure->name, h, d->all,
            (double)d->class / all, (double)d->unknown / all, (double)d->kind / all, d->depth);
}

saltus_status trial_write_figures(FILE *table, trial_bench *bench, saltus_message *message) {
    fprintf(table, "| figure | h | trajectories | another class than from the same start | a class that no "
                   "start has | another kind | deepest |\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for (int k = 0; trial_figure_at(k); k++)
        for (int step = 0; step < trial_coarse_steps; step++) {
            const trial_survey *exact, *naive;
            saltus_status status = trial_bench_survey(bench, trial_figure_at(k)->name, -1, &exact, message);
            if (status == SALTUS_OK)
                status = trial_bench_survey(bench, trial_figure_at(k)->name, step, &naive, message);
            if (status != SALTUS_OK)
                return status;
            difference d = differ(exact, naive);
            write_difference(table, trial_figure_at(k), trial_coarse[step], &d);
        }
    return SALTUS_OK;
}

/* F8 concerns whole figures. */
static const trial_clause of_restitution[] = {
    {"6", 1, 55, trial_irregular_impacts, "r = 0.9, non-periodic with impacts"},
    {"8a", 1, 55, trial_irregular_impacts, "r = 0.8, the same"},
    {"8b", 1, 55, trial_irregular_impacts, "r = 0.7, the same"},
    {"8c", 1, 55, trial_irregular_impacts, "r = 0.6, the same"},
};

static saltus_status write_clause(FILE *table, const char *id, const trial_clause *clause, trial_bench *bench,
                                  saltus_message *message) {
    const trial_survey *survey;
    saltus_status status = trial_bench_survey(bench, clause->figure, -1, &survey, message);
    if (status != SALTUS_OK)
        return status;
    fprintf(table, "| %s | %s %g-%g: %s | %.0f %% |", id, survey->figure->key, clause->low, clause->high,
            clause->words, 100 * trial_share(survey, clause, survey->figure->sparse));
    for (int step = 0; step < trial_coarse_steps; step++) {
        status = trial_bench_survey(bench, clause->figure, step, &survey, message);
        if (status != SALTUS_OK)
            return status;
        fprintf(table, " %.0f %% |", 100 * trial_share(survey, clause, 1));
    }
    fprintf(table, "\n");
    return SALTUS_OK;
}

saltus_status trial_write_shares(FILE *table, trial_bench *bench, saltus_message *message) {
    fprintf(table, "| claim | clause | exact |");
    for (int step = 0; step < trial_coarse_steps; step++)
        fprintf(table, " h = %g |", trial_coarse[step]);
    fprintf(table, "\n| --- | --- | --- |");
    for (int step = 0; step < trial_coarse_steps; step++)
        fprintf(table, " --- |");
    fprintf(table, "\n");
    for (int k = 0; trial_claim_at(k); k++)
        for (int c = 0; c < trial_clause_count(trial_claim_at(k)); c++) {
            const trial_claim *claim = trial_claim_at(k);
            saltus_status status = write_clause(table, claim->id, &claim->clauses[c], bench, message);
            if (status != SALTUS_OK)
                return status;
        }
    for (int c = 0; c < (int)(sizeof of_restitution / sizeof of_restitution[0]); c++) {
        saltus_status status = write_clause(table, "F8", &of_restitution[c], bench, message);
        if (status != SALTUS_OK)
            return status;
    }
    return SALTUS_OK;
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

/* Write the exact survey of every figure in turn. */
static saltus_status write_each(FILE *rows, void write(FILE *rows, const trial_survey *survey),
                                trial_bench *bench, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    for (int k = 0; trial_figure_at(k) && status == SALTUS_OK; k++) {
        const trial_survey *survey;
        status = trial_bench_survey(bench, trial_figure_at(k)->name, -1, &survey, message);
        if (status == SALTUS_OK)
            write(rows, survey);
    }
    return status;
}

saltus_status trial_write_windows(FILE *rows, trial_bench *bench, saltus_message *message) {
    fprintf(rows, "figure,key,from,to,values,class,share,chaotic\n");
    return write_each(rows, write_ranges, bench, message);
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

saltus_status trial_write_classes(FILE *rows, trial_bench *bench, saltus_message *message) {
    fprintf(rows, "figure,value");
    for (int kind = 0; kind < TRIAL_KINDS; kind++)
        fprintf(rows, ",%s", trial_kind_word((trial_kind)kind));
    fprintf(rows, ",reach\n");
    return write_each(rows, write_counts, bench, message);
}
