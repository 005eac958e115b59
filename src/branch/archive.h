/* Private: the state from which a run can go on, written as numbers and read back to the last bit.
 *
 * Each function serves both directions: writing, it appends the numbers of its argument; reading, it fills
 * the argument from them. The numbers may come from a file that anybody has written: every whole number is
 * checked against bounds, every array against the numbers left, and what must be finite for being so.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_ARCHIVE_H
#define SALTUS_BRANCH_ARCHIVE_H

#include "branch/rest.h"
#include "branch/special.h"

typedef struct saltus_archive {
    bool reading;
    const double *given; /* reading: the numbers; the caller's */
    double *made;        /* writing: the numbers, to be freed */
    size_t count, room;  /* numbers present; writing: room for them */
    size_t at;           /* reading: index of the next number */
    bool sound;          /* all numbers read so far are within their bounds; true at first */
    bool starved;        /* memory was lacking */
    int n, faces;        /* of the system: dimension and number of faces */
} saltus_archive;

/* Numbers that are missing or out of bounds read as zero (or the lower bound); `sound` becomes false. */
void saltus_archive_real(saltus_archive *archive, double *value); /* may be infinite or NAN */
void saltus_archive_scaled(saltus_archive *archive, saltus_scaled *number);
void saltus_archive_finite(saltus_archive *archive, double *values, size_t count);
/* Returns the number read or, writing, `value`. */
long long saltus_archive_whole(saltus_archive *archive, long long value, long long low, long long high);
/* The same for the length of an array whose entries take at least `each` numbers. */
size_t saltus_archive_length(saltus_archive *archive, size_t length, size_t each);
bool saltus_archive_flag(saltus_archive *archive, bool value);
/* One `among` a set of kinds, as bits; any other makes the archive unsound. */
saltus_point_kind saltus_archive_kind(saltus_archive *archive, saltus_point_kind kind, unsigned among);
void saltus_archive_label(saltus_archive *archive, char label[SALTUS_LABEL_MAX]);
/* A list of `count` things of `size` bytes and at least `each` numbers each: archives the count; reading, the
 * list is replaced by a zeroed one. Returns the list. */
void *saltus_archive_list(saltus_archive *archive, void *things, int *count, size_t size, size_t each);
/* An event sequence. */
void saltus_archive_sequence(saltus_archive *archive, saltus_sequence *sequence);
/* The point's room is grown as needed. */
void saltus_archive_point(saltus_archive *archive, saltus_curve_point *point);
/* A solution that has the shooting's sequence, with its survey, as far as later steps use it. */
void saltus_archive_solution(saltus_archive *archive, const saltus_orbits *orbits, saltus_solution *solution);
/* An equilibrium and the scales of the equations' rows; reading, the equations are shaped for it. Errors:
 * those of the evaluation. */
saltus_status saltus_archive_rest(saltus_archive *archive, saltus_rests *rests, saltus_rest *rest,
                                  saltus_message *message);
/* How finely the orbits so far were cut for their multipliers, if the period is an unknown; else nothing. */
void saltus_archive_orbits(saltus_archive *archive, saltus_orbits *orbits);
/* The sequence for which a shooting is shaped; reading, it is shaped again. Marks belong to the segments in
 * which they were then, wherever they are now. */
void saltus_archive_shape(saltus_archive *archive, saltus_shooting *shooting);
/* Reading replaces the present starts. */
void saltus_archive_starts(saltus_archive *archive, saltus_starts *starts);

#endif
