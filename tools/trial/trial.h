/* The paper's claims, what each asks of trajectories, what was found, and the trajectories themselves.
 *
 * A survey has the results over a figure of the paper for every value and start, by the event-driven flow or
 * by the naive method, in a common form so that both can be judged alike.
 *
 * A clause states what trajectories do over a range of a figure. Its share is the fraction of all
 * trajectories there (values times starts) that do so. A claim made of clauses holds if every clause has a
 * share of at least 95 %, does not hold if no clause has 50 %, and holds in part otherwise.
 *
 * Whatever fails ends the program (bench/must.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_H
#define SALTUS_TRIAL_H

#include "bench/must.h"
#include "saltus/saltus.h"

enum { trial_starts = 8, trial_label_max = 32, trial_figures = 8, trial_clauses_max = 4, trial_steps = 5 };

/* The range of a figure: a scene and one key that takes the values step, 2 step, ... */
typedef struct trial_figure {
    const char *name;    /* name in surveys and files */
    const char *scene;   /* a built-in scene */
    const char *setting; /* key=value; NULL: none */
    const char *key;
    double step;
    int count, quick; /* values are step * (1 ... count); with --quick only every quick-th */
    int sparse;       /* the naive method visits every sparse-th value */
    double
        admissible; /* starts keep to this clearance, so that they are the same at all values; NAN: no stop */
} trial_figure;

extern const trial_figure trial_figure_list[trial_figures];
/* The figure of a name, which must be in the list. */
const trial_figure *trial_figure_find(const char *name);

typedef enum trial_kind {
    TRIAL_FREE,      /* periodic, no contact */
    TRIAL_IMPACTS,   /* n/p */
    TRIAL_CHATTER,   /* periodic with lasting contacts */
    TRIAL_HELD,      /* permanently in contact */
    TRIAL_IRREGULAR, /* no period up to 20 */
    TRIAL_FAILED,    /* the flow gave up; with the naive method: numbers grew without bound */
    TRIAL_KINDS
} trial_kind;

extern const char *const trial_kind_words[TRIAL_KINDS];

/* Result of one trajectory. */
typedef struct trial_cell {
    double value;
    trial_kind kind;
    int impacts, periods; /* n per orbit, p; 0 without a period */
    bool chaotic;         /* largest exponent positive by three standard errors; exact surveys only */
    double lyapunov;      /* NAN for the naive method */
    double rate;          /* impacts per forcing period */
    double contact;       /* fraction of the time in lasting contact */
    double reach;         /* largest |displacement|; with the naive method only at section points */
    double depth;         /* largest penetration; 0 in exact surveys */
} trial_cell;

typedef struct trial_survey {
    const trial_figure *figure;
    int values; /* number of values; cells: values x starts */
    trial_cell *cells;
} trial_survey;

/* The steps of surveys by the naive method; the first one, 0, stands for the event-driven flow. */
extern const double trial_h[trial_steps];

/* The surveys made so far; with `quick` they are coarser. */
typedef struct trial_bench {
    bool quick;
    trial_survey surveys[trial_figures][trial_steps];
} trial_bench;

/* survey.c */
/* The survey of a figure, made on first use and owned by the bench. `step`: index into trial_h. */
const trial_survey *trial_survey_of(trial_bench *bench, const char *figure, int step);
void trial_bench_clear(trial_bench *bench);

/* "4/4", "chatter/2", "held", "irregular", ... */
void trial_label(const trial_cell *cell, char label[trial_label_max]);

/* How often each label was met; labels beyond the room are not counted. */
typedef struct trial_tally {
    int kinds, all;
    struct trial_count {
        char label[trial_label_max];
        int count;
    } of[256];
} trial_tally;

/* Count a label; the labels stay in the order of their counts. */
void trial_tally_add(trial_tally *tally, const char *label);

/* Initial states of a scene (trial_starts x dimension), the same at all values of a figure: the first is the
 * scene's own, the others are Gaussian with the system's scales, on the admissible side of `clearance` (NAN:
 * no stop). */
void trial_draw_starts(const saltus_scene *scene, double clearance, unsigned long seed, double *states);

typedef enum trial_verdict { TRIAL_HOLDS, TRIAL_IN_PART, TRIAL_DOES_NOT_HOLD } trial_verdict;

extern const char *const trial_verdict_words[];
/* The verdict by the clauses' shares, as above. */
trial_verdict trial_verdict_of(const double *shares, int count);

typedef bool trial_predicate(const trial_cell *cell);

/* Conditions on trajectories that are asked for beyond the claims' own clauses. */
bool trial_irregular_impacts(const trial_cell *cell); /* no period up to 20, with impacts */
bool trial_no_contact(const trial_cell *cell);
bool trial_sticks(const trial_cell *cell); /* lasting contacts, but not permanently */

typedef struct trial_clause {
    const char *figure;
    double low, high; /* both included */
    trial_predicate *asks;
    const char *words; /* "non-periodic with impacts" */
} trial_clause;

typedef struct trial_claim trial_claim;
/* Judge a claim, and write a phrase for the table, and a paragraph, in Markdown. */
typedef trial_verdict trial_judgement(const trial_claim *claim, trial_bench *bench, FILE *numbers,
                                      FILE *prose);

struct trial_claim {
    const char *id, *where, *says;
    const char *figure;  /* figure of the paper, as drawn by `saltus paper --figure`; surveyed if it has a
                            range */
    const char *picture; /* a picture made by the trial, beside the page; NULL: only the paper's figure */
    trial_clause clauses[trial_clauses_max];
    trial_judgement *judge; /* NULL: judged by its clauses, which otherwise are only told */
};

/* claims.c */
const trial_claim *trial_claim_at(int k); /* NULL beyond the last */
int trial_clause_count(const trial_claim *claim);

/* Judges. */
trial_judgement trial_judge_clauses, trial_judge_displacement, trial_judge_growth, trial_judge_restitution,
    trial_judge_point;

/* The share of a clause among every so many values of a survey. */
double trial_share(const trial_survey *survey, const trial_clause *clause, int every);

/* page.c: the page of verdicts. */
typedef struct trial_finding {
    trial_verdict verdict;
    char *numbers, *prose; /* owned by the finding */
} trial_finding;

trial_finding trial_judge(const trial_claim *claim, trial_bench *bench);
void trial_finding_clear(trial_finding *finding);

/* Write a claim as a row of the table, or as a section. */
void trial_write_row(FILE *file, const trial_claim *claim, const trial_finding *finding);
void trial_write_section(FILE *file, const trial_claim *claim, const trial_finding *finding);

/* Judge everything and write paper.md, and paper/windows.csv, classes.csv and naive-steps.csv, into a
 * folder. */
void trial_write_page(trial_bench *bench, const char *folder);

/* compare.c: dependence of figures and claims on the naive method's step. */
/* For each figure: the fraction of trajectories that the naive method classifies differently from the
 * event-driven flow, from the same initial states. */
void trial_write_figures(FILE *table, trial_bench *bench);
/* For each claim made of clauses: the shares of its clauses by both methods, at the values visited by
 * both. */
void trial_write_shares(FILE *table, trial_bench *bench);

/* For each figure, the ranges with one dominant class, and the number of starts of each kind at each
 * value. */
void trial_write_windows(FILE *rows, trial_bench *bench);
void trial_write_classes(FILE *rows, trial_bench *bench);

/* steps.c: the naive method at d = 0.03, omega = 43, for a series of steps. */
/* Write the results of the naive method for fig7b, with steps from 0.02 down to 1e-5 (quick: 1e-4), both
 * simple fractions of 1 and fractions of the period: as a table in Markdown, and then as CSV rows. */
void trial_write_steps(FILE *table, FILE *rows, bool quick);
/* Data of a figure: section points and impacts per period against the step, thirty steps per decade, and at
 * the end the points of the exact orbit. */
void trial_write_step_points(FILE *file, bool quick);

#endif
