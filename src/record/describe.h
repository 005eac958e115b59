/* Words and numbers that the writers share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_DESCRIBE_H
#define SALTUS_RECORD_DESCRIBE_H

#include "base/field.h"
#include "saltus/motion.h"
#include "saltus/scene.h"

#include <stdbool.h>
#include <stdio.h>

void saltus_put_number(FILE *file, double value);
/* The ending of a noun of which there are so many: "s" or "". */
const char *saltus_plural(long long count);

/* All kinds of events; those of contacts are the last ones, from SALTUS_CONTACT_EVENTS on. */
enum { SALTUS_CONTACT_EVENTS = 3 };
extern const saltus_word saltus_event_words[], saltus_side_words[];

const char *saltus_event_word(saltus_event_kind kind); /* "impact", "stick", "release", ... */
const char *saltus_side_word(int side);                /* +1 upper, -1 lower */
const char *saltus_sides_word(saltus_sides sides);     /* "upper", "lower", "both" */
/* The integrator that is used for a system when `asked` is chosen: what automatic stands for. */
const char *saltus_integrator_used(const saltus_system *system, saltus_integrator asked);
/* Velocity after an event: none once a contact holds. */
double saltus_event_after(const saltus_event *event);

/* The label with the word stable or unstable where that is known; fits 64 bytes. */
void saltus_motion_summary(const saltus_motion *motion, char text[64]);
/* How texts and figures speak of the system's model. */
const saltus_notation *saltus_notation_of(const saltus_system *system);
/* Whether a key of --set, which may end in the number of a stop, is the property `name` of stop s. */
bool saltus_key_means(const char *key, const char *name, int s);
/* Impacts per response cycle: the principal parametric response of a pipe takes 2 T. NaN where n or p is
 * unknown. */
double saltus_impacts_per_response(const saltus_system *system, const saltus_motion *motion);
/* Whether a parameter has an effect worth a caption: not a zero that is the default, nothing of a mass not
 * there. */
bool saltus_parameter_shown(const saltus_spec *spec, int k);
/* What the section of a scene without forcing is: "the maxima of the displacement", "the impacts on stop 1",
 * ... */
void saltus_put_section(FILE *file, const saltus_system *system);
/* A stop as `key = value` phrases with all digits. */
void saltus_put_stop(FILE *file, const saltus_spec *spec, int stop);
/* The comment lines that begin a table of comma-separated values: what it is, its scene, the label of the
 * motion (NULL: none), model, parameters and stops. */
void saltus_put_table_head(FILE *file, const char *what, const saltus_scene *scene, const char *motion,
                           const saltus_spec *spec);
/* How accurately trajectories were followed, and by which integrator, as `key = value` phrases. */
void saltus_put_tolerances(FILE *file, const saltus_system *system, const saltus_flow_options *flow);
/* Whether the multiplier k is the first of a complex conjugate pair. */
bool saltus_multiplier_pair(const saltus_motion *motion, int k);
/* The leading eigenvalues of a rest as a line for people; a complex pair is named once. `held`: of the motion
 * that keeps in contact. */
void saltus_put_eigenvalues(FILE *file, const saltus_eigenvalue *eigenvalues, int count, bool held);
/* The word that begins a line for people, as wide as all others. */
void saltus_put_word(FILE *file, const char *word);
/* The title, parameters and stops as lines for people. */
void saltus_put_scene(FILE *file, const saltus_scene *scene, const saltus_system *system);

#endif
