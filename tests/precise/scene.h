/* Reads a scene and a start from the JSON of `saltus orbit` or from a reference file, and writes references.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRECISE_SCENE_H
#define PRECISE_SCENE_H

#include "shoot.h"

/* The shortest decimal number that is read as this double. */
typedef struct decimal {
    char text[32];
} decimal;
decimal shortest_decimal(double value);

/* The model, the number of periods, the impacts counted (-1: not said) and the start. On failure: what is
 * missing or not known here. */
const char *scene_read(const char *text, model *m, int *periods, int *impacts, real *state);
/* The matrix of a reference file, n x n; false if there is none. */
bool scene_read_matrix(const char *text, int n, real *matrix);

/* What is known of a closed orbit. */
typedef struct orbit {
    const model *model;
    int periods;
    const passage *passage;
    const real *matrix; /* derivative of the period map, row-major */
    bool known;         /* the matrix was given */
    real residual;
} orbit;

/* The reference file of an orbit; false without multipliers, or when it cannot be written. */
bool scene_write(FILE *file, const orbit *o);

#endif
