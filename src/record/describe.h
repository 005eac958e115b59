/* Words and numbers shared by the writers and the figures.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_DESCRIBE_H
#define SALTUS_RECORD_DESCRIBE_H

#include "base/field.h"
#include "saltus/record.h"

#include <stdbool.h>
#include <stdio.h>

/* Write a number that reads back exactly. */
void saltus_put_number(FILE *file, double value);
/* Several, each after a comma. */
void saltus_put_numbers(FILE *file, const double *values, int count);
/* Plural ending of a noun: "" if count is 1, otherwise "s". */
const char *saltus_plural(long long count);

/* All kinds of events; contact events begin at SALTUS_CONTACT_EVENTS. */
enum { SALTUS_CONTACT_EVENTS = 3 };
extern const saltus_word saltus_event_words[], saltus_side_words[];

const char *saltus_event_word(saltus_event_kind kind); /* "impact", "stick", "release", ... */
const char *saltus_side_word(int side);                /* +1 upper, -1 lower */
const char *saltus_sides_word(saltus_sides sides);     /* "upper", "lower", "both" */
/* The integrator actually used for a system; resolves automatic. */
const char *saltus_integrator_used(const saltus_system *system, saltus_integrator asked);
/* Velocity after an event; 0 once a contact holds. */
double saltus_event_after(const saltus_event *event);

/* The label, with the word stable or unstable if known; fits 64 bytes. */
void saltus_motion_summary(const saltus_motion *motion, char text[64]);
/* Symbols and terms of the system's model for texts and figures. */
const saltus_notation *saltus_notation_of(const saltus_system *system);
/* Whether a key of --set, possibly with the number of a stop, is the property `name` of stop s. */
bool saltus_key_means(const char *key, const char *name, int s);
/* Impacts per response cycle: the principal parametric response of a pipe takes 2 T. NaN where n or p is
 * unknown. */
double saltus_impacts_per_response(const saltus_system *system, const saltus_motion *motion);
/* Whether to show a parameter: it has an effect and is not an optional element that is absent. */
bool saltus_parameter_shown(const saltus_spec *spec, int k);
/* Where a stop acts, as `key = value` with so many digits. */
void saltus_put_stop_place(FILE *file, const saltus_spec *spec, int stop, int digits);
/* A stop as `key = value` phrases with all digits. */
void saltus_put_stop(FILE *file, const saltus_spec *spec, int stop);
/* The comment lines at the head of a CSV table: what it is, scene, label of the motion (NULL: omitted),
 * model, parameters and stops. */
void saltus_put_table_head(FILE *file, const char *what, const saltus_scene *scene, const char *motion,
                           const saltus_spec *spec);
/* Tolerances and integrator as `key = value` phrases. */
void saltus_put_tolerances(FILE *file, const saltus_system *system, const saltus_flow_options *flow);
/* Whether the multiplier k is the first of a complex conjugate pair. */
bool saltus_multiplier_pair(const saltus_motion *motion, int k);
/* The leading eigenvalues of an equilibrium as a line for people, one of each complex pair. `held`: they
 * belong to the motion in contact. */
void saltus_put_eigenvalues(FILE *file, const saltus_eigenvalue *eigenvalues, int count, bool held);
/* The first word of a line for people, padded to the common width. */
void saltus_put_word(FILE *file, const char *word);
/* The title, parameters and stops as lines for people. */
void saltus_put_scene(FILE *file, const saltus_scene *scene, const saltus_system *system);

/* A number and its standard error as text, with as many digits as the error justifies. */
typedef struct saltus_uncertain {
    char value[40], error[40];
} saltus_uncertain;

/* The texts of both numbers. */
saltus_uncertain saltus_uncertain_text(double value, double error);

/* Fate of nearby trajectories according to the largest exponent. */
typedef enum saltus_sense {
    SALTUS_SENSE_SEPARATE,   /* positive by more than three standard errors */
    SALTUS_SENSE_APPROACH,   /* negative by more than three */
    SALTUS_SENSE_KEEP,       /* zero, and known to be */
    SALTUS_SENSE_UNRESOLVED, /* not distinguishable from zero */
    SALTUS_SENSE_MEET        /* -infinity */
} saltus_sense;

/* The fate that the largest exponent tells. */
saltus_sense saltus_lyapunov_sense(const saltus_lyapunov *lyapunov);
const char *saltus_sense_word(saltus_sense sense); /* "positive", "negative", "zero", "unresolved", "lost" */
/* How a system can lose directions of the state space: in lasting contact, or also in impacts with r = 0. */
const char *saltus_lost_words(const saltus_system *system);

/* Spectra with their scene, system and options. */
typedef struct saltus_spectra_source {
    const saltus_scene *scene;
    const saltus_system *system;
    const saltus_motion *motion;
    const saltus_spectra *spectra;
    const saltus_flow_options *flow;
} saltus_spectra_source;

/* "8 orbits of 4 T, 4096 samples a period", "2048 T, Welch with 31 segments of 128 T, ..." */
void saltus_spectra_method(const saltus_spectra *spectra, char *text, size_t room);
/* Comment lines and one row per line or bin, as CSV; failures are left in the file's error flag. All
 * quantities of a motion have their lines and bins in the same places; constant quantities have none. */
void saltus_put_spectra_table(const saltus_spectra_source *source, FILE *file);

#endif
