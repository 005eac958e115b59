/* Claims about whole figures: largest displacement, growth of impacts, effect of restitution.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

#include <gsl/gsl_statistics.h>
#include <math.h>

static const double claimed = 0.046, about = 0.05, bound = 0.038;

/* F2a for each start: "about 0.046" means within 5 %, and so does "reached"; "few" is less than a tenth,
 * "mostly" at least half of the values of omega. */
trial_verdict trial_judge_displacement(const trial_claim *claim, trial_bench *bench, FILE *numbers,
                                       FILE *prose) {
    const double few = 0.1;
    const trial_survey *survey = trial_survey_of(bench, claim->figure, 0);
    double shares[3] = {0};
    fprintf(prose,
            "Asked of each start over the whole range, as three clauses: the largest |displacement| is "
            "within 5 %% of %g; it comes that near or beyond at less than a tenth of omega; it stays "
            "below %g at half of omega.\n",
            claimed, bound);
    for (int start = 0; start < trial_starts; start++) {
        const double values = survey->values;
        double largest = 0, at = NAN;
        int near = 0, below = 0; /* number of values of omega */
        for (int k = 0; k < survey->values; k++) {
            const trial_cell *cell = &survey->cells[k * trial_starts + start];
            at = cell->reach > largest ? cell->value : at;
            largest = fmax(largest, cell->reach);
            near += cell->reach > (1 - about) * claimed;
            below += cell->reach < bound;
        }
        shares[0] += (double)(fabs(largest - claimed) <= about * claimed) / trial_starts;
        shares[1] += (double)(near / values < few) / trial_starts;
        shares[2] += (double)(below / values >= 0.5) / trial_starts;
        fprintf(prose,
                "%s: largest |displacement| %.5f at omega = %g; within 5 %% of the claimed %g and beyond "
                "at %.1f %%, below %g at %.1f %% of the values of omega.\n",
                start ? "A random start" : "The scene's own start", largest, at, claimed, 100 * near / values,
                bound, 100 * below / values);
        if (start == 0)
            fprintf(numbers, "scene's own start: largest %.5f at omega = %g, below %g at %.0f %% of omega; ",
                    largest, at, bound, 100 * below / values);
    }
    fprintf(numbers,
            "of %d starts, largest as claimed: %.0f %%, at few omega: %.0f %%, mostly below: %.0f %%",
            (int)trial_starts, 100 * shares[0], 100 * shares[1], 100 * shares[2]);
    return trial_verdict_of(shares, 3);
}

/* F6d: in every range for which other claims state impact motions. Growth means a rank correlation above
 * 1/2. */
trial_verdict trial_judge_growth(const trial_claim *claim, trial_bench *bench, FILE *numbers, FILE *prose) {
    static const trial_clause windows[] = {
        {.figure = "5", .low = 3, .high = 24.6},    {.figure = "5", .low = 35.1, .high = 40.4},
        {.figure = "5", .low = 40.5, .high = 43.7}, {.figure = "5", .low = 52.1, .high = 54.4},
        {.figure = "6", .low = 15.3, .high = 20.5}, {.figure = "6", .low = 20.6, .high = 24.6},
        {.figure = "6", .low = 35.6, .high = 46.3}, {.figure = "6", .low = 46.7, .high = 49.1}};
    enum { window_count = sizeof windows / sizeof windows[0] };
    int grow = 0;
    (void)claim;
    fprintf(prose,
            "Asked in each window that F5 and F6 name impact motions for: a rank correlation of impacts "
            "per period with omega above 1/2. The share is that of the windows.\n");
    for (int k = 0; k < window_count; k++) {
        const trial_survey *survey = trial_survey_of(bench, windows[k].figure, 0);
        double correlation = NAN, first = NAN, last = NAN;
        /* All trajectories there without lasting contacts. */
        const size_t room = (size_t)survey->values * trial_starts;
        size_t count = 0;
        double *table = must_allocate(4 * room, sizeof *table), *rates = table + room;
        for (size_t c = 0; c < room; c++) {
            const trial_cell *cell = &survey->cells[c];
            if (cell->value < windows[k].low - 1e-9 || cell->value > windows[k].high + 1e-9 ||
                cell->contact > 0)
                continue;
            table[count] = cell->value;
            rates[count++] = cell->rate;
        }
        if (count > 2) {
            const size_t part = count / 10 + 1;
            correlation = gsl_stats_spearman(table, 1, rates, 1, count, table + 2 * room);
            first = gsl_stats_mean(rates, 1, part);
            last = gsl_stats_mean(rates + count - part, 1, part);
        }
        free(table);
        grow += correlation > 0.5;
        fprintf(prose,
                "Figure %s, omega %g-%g: from %.2f impacts per period in the first tenth to %.2f in the "
                "last, rank correlation %.2f.\n",
                windows[k].figure, windows[k].low, windows[k].high, first, last, correlation);
    }
    double share = (double)grow / window_count;
    fprintf(numbers, "grows in %d of %d windows", grow, (int)window_count);
    return trial_verdict_of(&share, 1);
}

/* F8: fractions of omega's range, averaged over the starts. */
trial_verdict trial_judge_restitution(const trial_claim *claim, trial_bench *bench, FILE *numbers,
                                      FILE *prose) {
    static const char *const figures[] = {"6", "8a", "8b", "8c"}, *const r[] = {"0.9", "0.8", "0.7", "0.6"};
    double irregular[4], periodic[4];
    int widens = 0, shrinks = 0;
    (void)claim;
    fprintf(prose,
            "Asked from each r to the next smaller one: non-periodic impact motion takes more of omega's "
            "range, periodic motion with contact less of it; six comparisons.\n");
    for (int k = 0; k < 4; k++) {
        const trial_survey *survey = trial_survey_of(bench, figures[k], 0);
        double width = survey->figure->step * survey->figure->count;
        trial_clause all = {.low = 0, .high = width, .asks = trial_irregular_impacts};
        irregular[k] = width * trial_share(survey, &all, 1);
        all.asks = trial_sticks;
        double sticks = width * trial_share(survey, &all, 1);
        all.asks = trial_no_contact;
        double none = width * trial_share(survey, &all, 1);
        periodic[k] = width - irregular[k] - none;
        fprintf(prose,
                "r = %s: of omega's range of %g, %.2f non-periodic with impacts, %.2f periodic with "
                "contact, %.2f without contact; %.2f with complete chatter.\n",
                r[k], width, irregular[k], periodic[k], none, sticks);
        fprintf(numbers,
                "%sr = %s: %.1f non-periodic, %.1f periodic with contact, %.1f with complete chatter",
                k ? "; " : "", r[k], irregular[k], periodic[k], sticks);
        widens += k > 0 && irregular[k] > irregular[k - 1];
        shrinks += k > 0 && periodic[k] < periodic[k - 1];
    }
    fprintf(prose,
            "From each r to the next smaller one the former grow in %d cases of 3, the latter shrink in "
            "%d.\n",
            widens, shrinks);
    double share = (widens + shrinks) / 6.0;
    return trial_verdict_of(&share, 1);
}
