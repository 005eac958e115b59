/* Surveys: the results over a figure of the paper for every value and start, by the event-driven flow or by
 * the naive method, in a common form so that both can be judged alike.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_SURVEY_H
#define SALTUS_TRIAL_SURVEY_H

#include "saltus/saltus.h"

enum { trial_starts = 8, trial_label_max = 32, trial_figures = 8 };

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
/* NULL if there is none of that name. */
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
    int start;
    trial_kind kind;
    int impacts, periods; /* n per orbit, p; 0 without a period */
    bool chaotic;         /* largest exponent positive by three standard errors; exact surveys only */
    double lyapunov;      /* NAN for the naive method */
    double rate;          /* impacts per forcing period */
    double speed;         /* largest impact speed */
    double contact;       /* fraction of the time in lasting contact */
    double reach;         /* largest |displacement|; with the naive method only at section points */
    double depth;         /* largest penetration; 0 in exact surveys */
} trial_cell;

/* "4/4", "chatter/2", "held", "irregular", ... */
void trial_label(const trial_cell *cell, char label[trial_label_max]);

typedef struct trial_survey {
    const trial_figure *figure;
    double h;   /* step of the naive method; 0: the event-driven flow */
    int values; /* number of values; cells: values x starts */
    trial_cell *cells;
} trial_survey;

/* Options: coarse or not, and the folder for finished surveys (NULL: none). */
typedef struct trial_request {
    bool quick;
    const char *keep;
} trial_request;

/* Finished work is kept as files in the folder, so that an interrupted trial can continue. Open what is kept
 * under a name, after the line with the version; NULL if nothing is kept. */
FILE *trial_kept(const trial_request *request, const char *name);
/* Store a stream (NULL: it could not be made) under a name, if a folder is set, and rewind it. Errors:
 * SALTUS_IO. */
saltus_status trial_keep(const trial_request *request, const char *name, FILE *stream,
                         saltus_message *message);

/* Make a survey by either method; the cells of `survey` are allocated. */
saltus_status trial_survey_exact(trial_survey *survey, saltus_message *message);
saltus_status trial_survey_naive(trial_survey *survey, saltus_message *message);

/* The scene of a figure. */
saltus_status trial_scene(const trial_figure *figure, saltus_scene *scene, saltus_message *message);
/* Initial states of a scene (trial_starts x dimension), the same at all values of a figure: the first is the
 * scene's own, the others are Gaussian with the system's scales, on the admissible side of `clearance` (NAN:
 * no stop). Errors: SALTUS_NO_MEMORY, those of systems. */
saltus_status trial_draw_starts(const saltus_scene *scene, double clearance, unsigned long seed,
                                double *states, saltus_message *message);

#endif
