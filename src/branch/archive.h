/* Private: what a run goes on from, taken down as numbers and read back to the last bit.
 *
 * One function for each thing serves both ways: writing, it appends the thing's numbers; reading, it fills
 * the thing from them. What is read may come from a file that anybody has written: every whole number has
 * its bounds, every array fits into what is left, and numbers that must be finite are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_ARCHIVE_H
#define SALTUS_BRANCH_ARCHIVE_H

#include "branch/rest.h"
#include "branch/special.h"

typedef struct saltus_archive {
    bool reading;
    const double *given; /* reading: the numbers, the caller's */
    double *made;        /* writing: the numbers, to be freed */
    size_t count, room;  /* numbers there are; writing: room for them */
    size_t at;           /* reading: the next one */
    bool sound;          /* all that was read is within its bounds; true at first */
    bool starved;        /* memory was lacking */
    int n, faces;        /* of the system: dimension and faces */
} saltus_archive;

/* Reading what is not there, or is out of bounds, gives zero (or the lower bound), and is not sound. */
void saltus_archive_real(saltus_archive *archive, double *value); /* may be infinite or NAN */
void saltus_archive_finite(saltus_archive *archive, double *values, size_t count);
/* Returns the number that was read; writing, `value`. */
long long saltus_archive_whole(saltus_archive *archive, long long value, long long low, long long high);
/* The same for the length of an array of which each entry takes `each` numbers or more. */
size_t saltus_archive_length(saltus_archive *archive, size_t length, size_t each);
bool saltus_archive_flag(saltus_archive *archive, bool value);
saltus_point_kind saltus_archive_kind(saltus_archive *archive, saltus_point_kind kind);
void saltus_archive_label(saltus_archive *archive, char label[SALTUS_LABEL_MAX]);
/* Things of a size, each of `each` numbers or more: how many there are; reading, room for them takes the
 * place of `things`. Returns where they are. */
void *saltus_archive_list(saltus_archive *archive, void *things, int *count, size_t size, size_t each);
/* An array of `count` finite numbers; reading, it is allocated. */
void saltus_archive_array(saltus_archive *archive, double **values, size_t count);

void saltus_archive_sequence(saltus_archive *archive, saltus_sequence *sequence);
/* The point's room is grown as needed. */
void saltus_archive_point(saltus_archive *archive, saltus_curve_point *point);
/* A solution with its survey, as far as later steps may use it. */
void saltus_archive_solution(saltus_archive *archive, saltus_solution *solution);
/* An equilibrium of the equations, with the scales of their rows; reading, they become its own. Errors: those
 * of the evaluation. */
saltus_status saltus_archive_rest(saltus_archive *archive, saltus_rests *rests, saltus_rest *rest,
                                  saltus_message *message);
/* What orbits of periods of their own have shown of those to come: nothing of others. */
void saltus_archive_orbits(saltus_archive *archive, saltus_orbits *orbits);
/* The sequence that a shooting has, which reading it takes on: marks belong to the segments that they were in
 * when it did, wherever they are now. */
void saltus_archive_shape(saltus_archive *archive, saltus_shooting *shooting);
/* The point at which the Jacobian of the shooting's equations is known, which the next step begins with;
 * reading, they are evaluated there again. After their shape. */
void saltus_archive_known(saltus_archive *archive, saltus_orbits *orbits);
/* Reading replaces the starts that there are. */
void saltus_archive_starts(saltus_archive *archive, saltus_starts *starts);

#endif
