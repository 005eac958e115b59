/* The claims of the paper, row by row, with the conditions on trajectories that they make, and the rule.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

enum { long_period = 4, response_cycle = 2 };
static const double seldom = 0.1; /* impacts per period */

static bool touches(const trial_cell *cell) {
    return cell->rate > 0 || cell->contact > 0;
}

/* No period up to 20. */
static bool irregular(const trial_cell *cell) {
    return cell->kind == TRIAL_IRREGULAR;
}

bool trial_irregular_impacts(const trial_cell *cell) {
    return cell->kind == TRIAL_IRREGULAR && touches(cell);
}

/* Periodic, no lasting contact. */
static bool regular(const trial_cell *cell) {
    return cell->kind == TRIAL_FREE || cell->kind == TRIAL_IMPACTS;
}

bool trial_no_contact(const trial_cell *cell) {
    return cell->kind != TRIAL_FAILED && !touches(cell);
}

/* Less than one impact in ten periods, none lasting. */
static bool weak_contact(const trial_cell *cell) {
    return cell->kind != TRIAL_FAILED && cell->rate < seldom && !(cell->contact > 0);
}

/* Periodic, two impacts per orbit or more. */
static bool several_impacts(const trial_cell *cell) {
    return cell->kind == TRIAL_CHATTER || (cell->kind == TRIAL_IMPACTS && cell->impacts > 1);
}

/* Periodic with impacts, a period of T or one response cycle, 2 T. */
static bool one_cycle(const trial_cell *cell) {
    return cell->kind == TRIAL_IMPACTS && cell->periods <= response_cycle;
}

/* Contact and no period up to 20, or one above 4 T, or chatter. */
static bool complex(const trial_cell *cell) {
    bool regular = cell->kind == TRIAL_IMPACTS && cell->periods <= long_period;
    return cell->kind != TRIAL_FAILED && cell->kind != TRIAL_HELD && touches(cell) && !regular;
}

bool trial_sticks(const trial_cell *cell) {
    return cell->contact > 0 && cell->kind != TRIAL_HELD && cell->kind != TRIAL_FAILED;
}

static bool held(const trial_cell *cell) {
    return cell->kind == TRIAL_HELD;
}

static const trial_claim claims[] = {
    {"F2a", "no stop, 0 < omega <= 55",
     "largest displacement about 0.046, reached at few omega; mostly below 0.038", "2", "figures/trial.png",
     .judge = trial_judge_displacement},
    {"F2b", "no stop", "non-periodic for 4 < omega < 14; above, periodic", "2", "figures/trial.png",
     .clauses = {{"2", 4.1, 13.9, irregular, "non-periodic"}, {"2", 14, 55, regular, "periodic"}}},
    {"F3", "N = 1, two-sided, omega = 14, r = 0.8, d = 0.035", "a \"2/1\" motion", "3", NULL,
     .judge = trial_judge_point},
    {"F4a", "omega = 10, against d",
     "stuck to the stop without vibration for d <= 0.025; complex for 0.026 to 0.046; contact weak or "
     "absent from 0.038",
     "4", "figures/trial-clearance.png",
     .clauses = {{"4a", 0, 0.025, held, "held"},
                 {"4a", 0.026, 0.0378, complex, "complex"},
                 {"4a", 0.038, 0.046, weak_contact, "less than an impact in ten periods"}}},
    {"F4b", "omega = 20, against d",
     "stuck for d <= 0.027; complex for 0.028 to 0.035; period-1 impact motion for 0.036 to 0.040; no "
     "contact above",
     "4", "figures/trial-clearance.png",
     .clauses = {{"4b", 0, 0.027, held, "held"},
                 {"4b", 0.028, 0.035, complex, "complex"},
                 {"4b", 0.036, 0.040, one_cycle, "impacts, period T or 2 T"},
                 {"4b", 0.0402, 0.046, trial_no_contact, "no contact"}}},
    {"F5a", "d = 0.03", "non-periodic impact motion for omega in 3-24.6, 35.1-40.4, 52.1-54.4", "5",
     "figures/trial.png",
     .clauses = {{"5", 3, 24.6, trial_irregular_impacts, "non-periodic with impacts"},
                 {"5", 35.1, 40.4, trial_irregular_impacts, "non-periodic with impacts"},
                 {"5", 52.1, 54.4, trial_irregular_impacts, "non-periodic with impacts"}}},
    {"F5b", "d = 0.03", "no contact for 24.7-35", "5", "figures/trial.png",
     .clauses = {{"5", 24.7, 35, trial_no_contact, "no contact"}}},
    {"F5c", "d = 0.03", "several impacts per period, periodic, for 40.5-43.7", "5", "figures/trial.png",
     .clauses = {{"5", 40.5, 43.7, several_impacts, "n/p with n >= 2"}}},
    {"F5d", "d = 0.03", "stuck to the stop without vibration for 43.8-52", "5", "figures/trial.png",
     .clauses = {{"5", 43.8, 52, held, "held"}}},
    {"F6a", "d = 0.035", "periodic motion with several impacts for 15.3-20.5 and 35.6-46.3", "6",
     "figures/trial.png",
     .clauses = {{"6", 15.3, 20.5, several_impacts, "n/p with n >= 2"},
                 {"6", 35.6, 46.3, several_impacts, "n/p with n >= 2"}}},
    {"F6b", "d = 0.035", "complex multi-impact motion for 20.6-24.6 and 46.7-49.1", "6", "figures/trial.png",
     .clauses = {{"6", 20.6, 24.6, complex, "complex"}, {"6", 46.7, 49.1, complex, "complex"}}},
    {"F6c", "d = 0.035", "pre-impact speed decreasing to zero over repeated impacts (sticking) for 20.4-24.7",
     "6", "figures/trial.png", .clauses = {{"6", 20.4, 24.7, trial_sticks, "complete chatter"}}},
    {"F6d", "general", "the number of impacts per period grows with omega within a window", "6",
     "figures/trial.png", .judge = trial_judge_growth},
    {"F7a", "d = 0.03, omega = 38", "chaotic, fractal stroboscopic set", "7", NULL,
     .judge = trial_judge_point},
    {"F7b", "d = 0.03, omega = 43", "4/5: four impacts, five stroboscopic points", "7", "figures/naive.png",
     .judge = trial_judge_point},
    {"F7c", "d = 0.035, omega = 10", "chaotic", "7", NULL, .judge = trial_judge_point},
    {"F7d", "d = 0.035, omega = 42", "4/4: four impacts, four stroboscopic points", "7", "figures/fig7d.png",
     .judge = trial_judge_point},
    {"F8", "d = 0.035, r = 0.8, 0.7, 0.6",
     "smaller r widens the windows of non-periodic impact motion and shrinks the periodic ones", "8",
     "figures/trial.png",
     .clauses = {{"6", 1, 55, trial_irregular_impacts, "r = 0.9, non-periodic with impacts"},
                 {"8a", 1, 55, trial_irregular_impacts, "r = 0.8, the same"},
                 {"8b", 1, 55, trial_irregular_impacts, "r = 0.7, the same"},
                 {"8c", 1, 55, trial_irregular_impacts, "r = 0.6, the same"}},
     .judge = trial_judge_restitution},
};

const trial_claim *trial_claim_at(int k) {
    return k >= 0 && k < (int)(sizeof claims / sizeof claims[0]) ? &claims[k] : NULL;
}

int trial_clause_count(const trial_claim *claim) {
    int count = 0;
    while (count < trial_clauses_max && claim->clauses[count].asks)
        count++;
    return count;
}

const char *const trial_verdict_words[] = {"holds", "holds in part", "does not hold"};

trial_verdict trial_verdict_of(const double *shares, int count) {
    const double all = 0.95, half = 0.5;
    int full = 0, some = 0;
    for (int k = 0; k < count; k++) {
        full += shares[k] >= all;
        some += shares[k] >= half;
    }
    return full == count ? TRIAL_HOLDS : some ? TRIAL_IN_PART : TRIAL_DOES_NOT_HOLD;
}
