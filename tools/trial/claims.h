/* The paper's claims, what each asks of trajectories, and what was found.
 *
 * A clause states what trajectories do over a range of a figure. Its share is the fraction of all
 * trajectories there (values times starts) that do so. A claim made of clauses holds if every clause has a
 * share of at least 95 %, does not hold if no clause has 50 %, and holds in part otherwise.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_CLAIMS_H
#define SALTUS_TRIAL_CLAIMS_H

#include "survey.h"

enum { trial_clauses_max = 4, trial_coarse_steps = 4, trial_figures = 8 };

typedef enum trial_verdict { TRIAL_HOLDS, TRIAL_IN_PART, TRIAL_DOES_NOT_HOLD } trial_verdict;

const char *trial_verdict_word(trial_verdict verdict);
/* The verdict by the clauses' shares, as above. */
trial_verdict trial_verdict_of(const double *shares, int count);

typedef bool (*trial_predicate)(const trial_cell *cell);

/* Conditions on trajectories: */
bool trial_irregular(const trial_cell *cell);         /* no period up to 20 */
bool trial_irregular_impacts(const trial_cell *cell); /* irregular, with impacts */
bool trial_regular(const trial_cell *cell);           /* periodic, no lasting contact */
bool trial_no_contact(const trial_cell *cell);
bool trial_weak_contact(const trial_cell *cell);    /* less than one impact in ten periods, none lasting */
bool trial_several_impacts(const trial_cell *cell); /* periodic, two impacts per orbit or more */
bool trial_one_cycle(
    const trial_cell *cell); /* periodic with impacts, a period of T or one response cycle, 2 T */
bool trial_complex(const trial_cell *cell); /* contact and no period up to 20, or one above 4 T, or chatter */
bool trial_sticks(const trial_cell *cell);  /* lasting contacts, but not permanently */
bool trial_held(const trial_cell *cell);

typedef struct trial_clause {
    const char *figure;
    double low, high; /* both included */
    trial_predicate asks;
    const char *words; /* "non-periodic with impacts" */
} trial_clause;

/* The surveys made so far. */
typedef struct trial_bench {
    trial_request request;
    trial_survey exact[trial_figures], naive[trial_figures][trial_coarse_steps];
} trial_bench;

/* The naive method's steps for whole figures. */
extern const double trial_coarse[trial_coarse_steps];

/* The survey of a figure, made on first use and owned by the bench. `step`: index into trial_coarse; -1: the
 * event-driven flow. */
saltus_status trial_bench_survey(trial_bench *bench, const char *figure, int step,
                                 const trial_survey **survey, saltus_message *message);
void trial_bench_clear(trial_bench *bench);

/* Texts are Markdown and owned by the finding. */
typedef struct trial_finding {
    trial_verdict verdict;
    FILE *numbers, *prose; /* written by the judge: a phrase for the table, and a paragraph */
    char *numbers_text, *prose_text;
    size_t numbers_size, prose_size;
} trial_finding;

typedef struct trial_claim trial_claim;
typedef saltus_status trial_judgement(const trial_claim *claim, trial_bench *bench, trial_finding *finding,
                                      saltus_message *message);

struct trial_claim {
    const char *id, *where, *says;
    const char *figure;  /* figure of the paper, as drawn by `saltus paper --figure`; surveyed if it has a
                            range */
    const char *picture; /* a picture made by the trial, beside the page; NULL: only the paper's figure */
    trial_clause clauses[trial_clauses_max];
    trial_judgement *judge; /* NULL: judged by its clauses */
};

const trial_claim *trial_claim_at(int k); /* NULL beyond the last */
int trial_clause_count(const trial_claim *claim);
/* Judge a claim. Clear the finding with trial_finding_clear in any case. */
saltus_status trial_judge(const trial_claim *claim, trial_bench *bench, trial_finding *finding,
                          saltus_message *message);
void trial_finding_clear(trial_finding *finding);

/* Judges. */
trial_judgement trial_judge_clauses, trial_judge_displacement, trial_judge_growth, trial_judge_restitution,
    trial_judge_point;

/* Building blocks of findings. */
double trial_share(const trial_survey *survey, const trial_clause *clause, int every);
/* Kinds and labels within a range, most frequent first. */
void trial_write_labels(FILE *file, const trial_survey *survey, double low, double high, int most);
/* The ranges where at least half of the starts satisfy the condition. */
void trial_write_ranges(FILE *file, const trial_survey *survey, trial_predicate asks);

#endif
