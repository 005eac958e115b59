/* The paper's claims, what each asks of trajectories, and what was found.
 *
 * A clause states what trajectories do over a range of a figure. Its share is the fraction of all
 * trajectories there (values times starts) that do so. A claim made of clauses holds if every clause has a
 * share of at least 95 %, does not hold if no clause has 50 %, and holds in part otherwise.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_CLAIMS_H
#define SALTUS_TRIAL_CLAIMS_H

#include "survey.h"

enum { trial_clauses_max = 4, trial_coarse_steps = 4 };

typedef enum trial_verdict { TRIAL_HOLDS, TRIAL_IN_PART, TRIAL_DOES_NOT_HOLD } trial_verdict;

const char *trial_verdict_word(trial_verdict verdict);
/* The verdict by the clauses' shares, as above. */
trial_verdict trial_verdict_of(const double *shares, int count);

typedef bool (*trial_predicate)(const trial_cell *cell);

/* Conditions on trajectories that are asked for beyond the claims' own clauses. */
bool trial_irregular_impacts(const trial_cell *cell); /* no period up to 20, with impacts */
bool trial_no_contact(const trial_cell *cell);
bool trial_sticks(const trial_cell *cell); /* lasting contacts, but not permanently */

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
    trial_judgement *judge; /* NULL: judged by its clauses, which otherwise are only told */
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

/* The share of a clause among every so many values of a survey. */
double trial_share(const trial_survey *survey, const trial_clause *clause, int every);

/* page.c: the page of verdicts. */
/* Write a claim as a row of the table, or as a section. */
void trial_write_row(FILE *file, const trial_claim *claim, const trial_finding *finding);
void trial_write_section(FILE *file, const trial_claim *claim, const trial_finding *finding);

/* Judge everything and write paper.md, and paper/windows.csv, classes.csv and naive-steps.csv, into a folder.
 * Errors: those of the judges, SALTUS_IO. */
saltus_status trial_write_page(trial_bench *bench, const char *folder, saltus_message *message);

/* compare.c: dependence of figures and claims on the naive method's step. */
/* For each figure: the fraction of trajectories that the naive method classifies differently from the
 * event-driven flow, from the same initial states. */
saltus_status trial_write_figures(FILE *table, trial_bench *bench, saltus_message *message);
/* For each claim made of clauses: the shares of its clauses by both methods, at the values visited by
 * both. */
saltus_status trial_write_shares(FILE *table, trial_bench *bench, saltus_message *message);

/* For each figure, the ranges with one dominant class, and the number of starts of each kind at each
 * value. */
saltus_status trial_write_windows(FILE *rows, trial_bench *bench, saltus_message *message);
saltus_status trial_write_classes(FILE *rows, trial_bench *bench, saltus_message *message);

/* steps.c: the naive method at d = 0.03, omega = 43, for a series of steps. */
/* Write the results of the naive method for fig7b, with steps from 0.02 down to 1e-5 (quick: 1e-4), both
 * simple fractions of 1 and fractions of the period: as a table in Markdown and as CSV rows. Errors:
 * SALTUS_NO_MEMORY, those of scenes. */
saltus_status trial_write_steps(FILE *table, FILE *rows, const trial_request *request,
                                saltus_message *message);
/* Data of a figure: section points and impacts per period against the step, thirty steps per decade, and at
 * the end the points of the exact orbit. */
saltus_status trial_write_step_points(FILE *file, bool quick, saltus_message *message);

#endif
