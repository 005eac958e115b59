/* Points of codimension two on a locus.
 *
 * A curve of folds has a cusp where the second derivative along the null vector vanishes; a double multiplier
 * on the unit circle (R1, R2) where left and right null vectors are orthogonal; on a curve of tori the angle
 * tells the resonances. Any of them ends where another impact dies or is born. A curve of grazing passes
 * through points where the orbit is special too, seen with the impact (one side of the curve) or without it
 * (the other side).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/corner.h"

#include "branch/sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static saltus_scaled plain(double value) {
    return (saltus_scaled){value, 0};
}

double saltus_corner_breach(const saltus_extended *x, const saltus_solution *s) {
    const double near = 1e-4;
    double worst = -1;
    if (x->kind != SALTUS_POINT_GR)
        return s->worst.value;
    const saltus_mark *own = &s->sequence.mark[x->mark];
    for (int k = 0; k < s->breach_count; k++) {
        const saltus_breach *breach = &s->breaches[k];
        bool touch = breach->face == own->face && fabs(breach->time - own->time) < near;
        /* On an orbit that is its own mirror image the impact's image grazes too. */
        bool image = x->mirrored && breach->face != own->face &&
                     fabs(fabs(breach->time - own->time) - 0.5 * s->sequence.periods) < near;
        if (!touch && !image && !(breach->mark == x->mark && breach->kind == SALTUS_BREACH_SPEED))
            worst = fmax(worst, breach->value);
    }
    return worst;
}

/* Determinants of the equations, the parameters fixed, that the shooting has last evaluated: as they are, and
 * with an orbit that closes on minus its begin. False without memory. */
static bool determinants(saltus_shooting *shooting, int n, saltus_scaled *fold, saltus_scaled *flip) {
    const saltus_equations *e = saltus_shooting_equations(shooting);
    int c = e->count, row = saltus_shooting_closing_row(shooting);
    saltus_dense_lu lu = {.n = 0};
    double *a = calloc((size_t)(c * c), sizeof *a);
    bool room = a && saltus_dense_lu_open(&lu, c);
    for (int turned = 0; turned < 2 && room; turned++) {
        for (int i = 0; i < c; i++)
            memcpy(a + i * c, e->jacobian + i * e->unknowns, (size_t)c * sizeof *a);
        for (int i = 0; i < n && turned; i++)
            a[(row + i) * c + i] += 2;
        saltus_dense_factor(&lu, a);
        *(turned ? flip : fold) = (saltus_scaled){lu.sign, lu.log_modulus};
    }
    saltus_dense_lu_close(&lu);
    free(a);
    return room;
}

/* By how much the square of the modulus of the largest complex pair of multipliers exceeds 1; NAN where there
 * is none. The equations have one cut: the event times are eliminated from the derivative around the orbit.
 * False without memory. */
static bool pair_excess(saltus_shooting *shooting, int n, double *excess) {
    const saltus_equations *e = saltus_shooting_equations(shooting);
    int marks = e->count - n, m = e->unknowns;
    saltus_dense_lu lu = {.n = 0};
    double *work = calloc((size_t)(n * n + 2 * n + marks * (marks + n) + 1), sizeof *work);
    double *monodromy = work, *real = work + n * n, *imaginary = real + n, *times = imaginary + n;
    double *columns = times + marks * marks;
    *excess = NAN;
    bool room = work && (marks == 0 || saltus_dense_lu_open(&lu, marks)), sound = room;
    for (int i = 0; i < marks && sound; i++) {
        memcpy(times + i * marks, e->jacobian + (n + i) * m + n, (size_t)marks * sizeof *times);
        for (int j = 0; j < n; j++)
            columns[j * marks + i] = -e->jacobian[(n + i) * m + j];
    }
    if (sound && marks) {
        sound = saltus_dense_factor(&lu, times);
        if (sound)
            saltus_dense_resolve(&lu, false, n, columns);
    }
    for (int i = 0; i < n && sound; i++)
        for (int j = 0; j < n; j++) {
            monodromy[i * n + j] = e->jacobian[i * m + j] + (i == j);
            for (int k = 0; k < marks; k++)
                monodromy[i * n + j] += e->jacobian[i * m + n + k] * columns[j * marks + k];
        }
    if (sound && saltus_dense_eigenvalues(monodromy, n, real, imaginary))
        for (int i = 0; i < n; i++)
            if (imaginary[i] > 0)
                *excess = fmax(*excess, real[i] * real[i] + imaginary[i] * imaginary[i] - 1);
    saltus_dense_lu_close(&lu);
    free(work);
    return room;
}

/* The same of the orbit without the impacts that graze. What cannot be computed is NAN. False without memory.
 */
static bool without_impact(const saltus_extended *x, const saltus_solution *s, saltus_scaled *fold,
                           saltus_scaled *flip, double *excess) {
    saltus_sequence less;
    saltus_shooting *shooting = NULL;
    saltus_message ignored;
    int order[SALTUS_MARKS_MAX];
    *fold = *flip = plain(NAN);
    *excess = NAN;
    saltus_sequence_graze(&s->sequence, s->breaches, s->breach_count, &less, order);
    less.cuts = 1;
    double *u;
    saltus_status status =
        saltus_orbits_shoot(&x->orbits, &less, s->parameter, s->state, &shooting, &u, &ignored);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(saltus_shooting_equations(shooting), u, &ignored);
    bool room = status != SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        room = determinants(shooting, x->orbits.n, fold, flip) && pair_excess(shooting, x->orbits.n, excess);
    saltus_shooting_free(shooting);
    free(u);
    return room;
}

int saltus_corner_measure(const saltus_extended *x, const saltus_curve_point *point, const saltus_solution *s,
                          saltus_corner *corners) {
    static const saltus_point_kind grazing[] = {[SALTUS_POINT_LP] = SALTUS_POINT_GR_LP,
                                                [SALTUS_POINT_PD] = SALTUS_POINT_GR_PD,
                                                [SALTUS_POINT_NS] = SALTUS_POINT_GR_NS,
                                                [SALTUS_POINT_BP] = SALTUS_POINT_GR_BP,
                                                [SALTUS_POINT_GR] = SALTUS_POINT_GR_GR};
    double excess, theta = x->extra ? point->u[point->unknowns - 1] : 0;
    saltus_scaled fold, flip, other_fold, other_flip;
    int count = 0;
    corners[count++] = (saltus_corner){grazing[x->kind], plain(saltus_corner_breach(x, s)), true};
    switch (x->kind) {
    case SALTUS_POINT_LP:
        corners[count++] = (saltus_corner){SALTUS_POINT_CP, plain(saltus_extended_cusp(x)), false};
        corners[count++] = (saltus_corner){SALTUS_POINT_R1, plain(saltus_extended_double(x)), false};
        break;
    case SALTUS_POINT_PD:
        corners[count++] = (saltus_corner){SALTUS_POINT_R2, plain(saltus_extended_double(x)), false};
        break;
    case SALTUS_POINT_NS:
        corners[count++] = (saltus_corner){SALTUS_POINT_R1, plain(theta), true};
        corners[count++] = (saltus_corner){SALTUS_POINT_R2, plain(theta - M_PI), true};
        corners[count++] = (saltus_corner){SALTUS_POINT_R3, plain(theta - 2 * M_PI / 3), false};
        corners[count++] = (saltus_corner){SALTUS_POINT_R4, plain(theta - M_PI / 2), false};
        break;
    case SALTUS_POINT_GR:
        if (!determinants(x->orbits.shooting, x->orbits.n, &fold, &flip) ||
            !without_impact(x, s, &other_fold, &other_flip, &excess))
            return -1;
        corners[count++] = (saltus_corner){SALTUS_POINT_GR_LP, fold, false};
        corners[count++] = (saltus_corner){SALTUS_POINT_GR_PD, flip, false};
        corners[count++] =
            (saltus_corner){x->mirrored ? SALTUS_POINT_GR_BP : SALTUS_POINT_GR_LP, other_fold, false};
        corners[count++] = (saltus_corner){SALTUS_POINT_GR_PD, other_flip, false};
        corners[count++] = (saltus_corner){SALTUS_POINT_GR_NS, plain(excess), false};
        break;
    default:
        break;
    }
    return count;
}
