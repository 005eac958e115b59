/* Where curves of special orbits join those of shorter ones. The method stands in join.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/join.h"

#include <math.h>
#include <string.h>

/* Whether an orbit that grazes, and again after each part of its period, also touches at another time. */
static bool touches_elsewhere(const saltus_extended *x, const saltus_solution *s, int parts) {
    const double together = 1e-7, near = 1e-4, part = (double)s->sequence.periods / (parts > 1 ? parts : 2);
    const saltus_mark *own = &s->sequence.mark[x->mark];
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind <= SALTUS_BREACH_GAP && fabs(s->breaches[k].value) < together &&
            fabs(remainder(s->breaches[k].time - own->time, part)) > near)
            return true;
    return false;
}

/* The halves of an orbit are all but alike. */
static const double close_by = 6e-3;

/* What falls to nothing along a curve, as its arclength does: the distance from a shorter orbit, a breach,
 * the root of one, or the greatest speed of the slow impacts. */
typedef enum measure { BY_BREACH, BY_DISTANCE, BY_SPEED, BY_ROOT } measure;

static double left_of(saltus_extended *x, measure by, int parts, const saltus_solution *s) {
    const double slow = 1e-2;
    double speed = 0;
    if (by == BY_DISTANCE)
        return saltus_solution_part_distance(&x->orbits, s, parts, NULL);
    if (by != BY_SPEED)
        return by == BY_ROOT ? sqrt(fabs(saltus_corner_breach(x, s))) : saltus_corner_breach(x, s);
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind == SALTUS_BREACH_SPEED && -s->breaches[k].value < slow)
            speed = fmax(speed, -s->breaches[k].value);
    return speed;
}

/* How far the residual and rounding may have moved, in the plane, a point at which the equations were just
 * evaluated: aside of the curve, as the least singular value across it tells. NAN if that fails. */
static double moved_by_residual(saltus_extended *x, const saltus_curve_point *at) {
    const double rounding = 1e-15;
    const int m = at->unknowns, c = x->orbits.equations->count;
    double values[2], aside[2], *plane = x->points + SALTUS_SAMPLES_MOST * m;
    if (saltus_orbits_noted(&x->orbits, saltus_null_plane(&x->equations, plane, values, NULL)) != SALTUS_OK)
        return NAN;
    const double one = saltus_dot(plane, at->tangent, m), other = saltus_dot(plane + m, at->tangent, m);
    for (int d = 0; d < 2; d++)
        aside[d] = one * plane[m + c + d] - other * plane[c + d];
    return fmax(at->residual, rounding) / values[1] * hypot(aside[0], aside[1]);
}

/* `at` becomes the place where what is left by a measure is nothing, extrapolated from places on the curve of
 * `here` so far apart before one `ahead` of it, where the equations are regular; *spread: how far off in the
 * plane it would be with one of them less, or by the residuals of all. False if the equations fail. */
static bool extrapolate(saltus_extended *x, saltus_locus_point *here, double ahead, double apart, int samples,
                        measure by, int parts, saltus_locus_point *at, double *spread) {
    const double sharpest = 1e-13, sharp = 1e-11;
    int m = here->at.unknowns;
    double rest[SALTUS_SAMPLES_MOST], moved[SALTUS_SAMPLES_MOST], *u = x->points;
    saltus_locus_point before = {.corner_count = 0};
    bool found = true;
    /* A residual moves the place by its size divided by the remainder, and spoils the bend even more. */
    here->at.bent = false;
    for (int k = 0; k < samples && found; k++) {
        /* Orbits with slow impacts are close to those without them, on which a long step would end. */
        const bool follows = by == BY_SPEED && k > 0;
        if (follows)
            SALTUS_SWAP(*at, before);
        /* Rounding may be more than the first tolerance. */
        double tolerance = sharpest;
        found = saltus_locus_reach(x, follows ? &before.at : &here->at,
                                   follows ? -apart : ahead - (k + 1) * apart, &tolerance, sharp, &at->at);
        moved[k] = found ? moved_by_residual(x, &at->at) : NAN;
        found = found && saltus_locus_see_orbit(x, at);
        rest[k] = found ? left_of(x, by, parts, &at->orbit) : NAN;
        for (int j = 0; j < m && found; j++)
            u[j * samples + k] = at->at.u[j];
    }
    at->at.ahead = *spread = 0;
    for (int j = 0; j < m && found; j++) {
        at->at.u[j] = saltus_curve_interpolate(rest, u + j * samples, samples);
        at->at.ahead += (at->at.u[j] - here->at.u[j]) * here->at.tangent[j];
    }
    /* The halves may change places, which changes the distance's sign, but not the parameters. */
    for (int k = 0; k < samples && found && by == BY_DISTANCE && x->kind != SALTUS_POINT_GR; k++)
        rest[k] *= rest[k];
    for (int j = x->orbits.equations->count, d = 0; d < 2 && found; d++) {
        const double *values = u + (j + d) * samples;
        at->at.u[j + d] = saltus_curve_interpolate(rest, values, samples);
        *spread = hypot(*spread, at->at.u[j + d] - saltus_curve_interpolate(rest, values, samples - 1));
    }
    for (int k = 0; k < samples && found; k++) {
        double own[SALTUS_SAMPLES_MOST] = {0};
        own[k] = moved[k];
        *spread += fabs(saltus_curve_interpolate(rest, own, samples));
    }
    saltus_locus_point_clear(&before);
    return found && saltus_locus_see_orbit(x, at);
}

/* How many impacts have hardly a speed. */
static int count_slow(const saltus_solution *s) {
    const double slow = 1e-5;
    int count = 0;
    for (int k = 0; k < s->breach_count; k++)
        count += s->breaches[k].kind == SALTUS_BREACH_SPEED && fabs(s->breaches[k].value) < slow;
    return count;
}

void saltus_locus_sharpen_end(saltus_extended *x, saltus_locus_point *here, saltus_locus_point *at) {
    static const double apart[] = {3e-3, 1e-3, 3e-4, 1e-4};
    enum { spacings = sizeof apart / sizeof apart[0] };
    const double far = 1e-4, trusted = 1e-9;
    const int m = here->at.unknowns, c = x->orbits.equations->count;
    const double place = at->at.ahead;
    if (saltus_halved_touch(x, SALTUS_POINT_GR_LP, 0, INFINITY, at))
        return;
    /* Where several impacts have no speed the equations are singular, and solved by chance nearby: a function
     * may show its slope there, but its zero is elsewhere. */
    if (count_slow(&at->orbit) > 1)
        at->doubt = NAN;
    if (at->doubt <= trusted || saltus_halved_still(x, at->corners[0].kind, far, at))
        return;
    double spread, least = INFINITY, second = INFINITY, ahead = place, doubt = INFINITY;
    double *u = x->kept, *located = u + m, *other = u + 2 * m;
    const size_t size = (size_t)m * sizeof *u;
    const bool bent = here->at.bent;
    memcpy(located, at->at.u, size);
    for (int k = 0; k < 2 * spacings; k++) {
        const bool sound = extrapolate(x, here, place, apart[k / 2], SALTUS_SAMPLES_MOST,
                                       k % 2 ? BY_ROOT : BY_BREACH, 0, at, &spread);
        const double moved = hypot(at->at.u[c] - located[c], at->at.u[c + 1] - located[c + 1]);
        if (!sound || !(spread < second) || !(moved < far))
            continue;
        if (spread < least) {
            memcpy(other, u, size);
            second = least;
            memcpy(u, at->at.u, size);
            least = spread;
            ahead = at->at.ahead;
        } else {
            memcpy(other, at->at.u, size);
            second = spread;
        }
        /* How far the two best are apart says more than their own spread. */
        if (isfinite(second))
            doubt = least + hypot(u[c] - other[c], u[c + 1] - other[c + 1]);
    }
    here->at.bent = bent;
    const bool sharper = isfinite(doubt) && !(at->doubt <= doubt);
    memcpy(at->at.u, sharper ? u : located, size);
    at->at.ahead = sharper ? ahead : place;
    at->doubt = sharper ? doubt : at->doubt;
    saltus_locus_survey_orbit(x, at);
}

/* What orbits on a curve of folds or tori may become without grazing: those of half the period (2), or such
 * that are their own mirror images (1), whichever is nearer; 0: neither. */
static int may_join(saltus_extended *x, const saltus_solution *s) {
    const double are = 1e-6;
    if ((x->kind != SALTUS_POINT_LP && x->kind != SALTUS_POINT_NS) || x->mirrored || s->sequence.count % 2)
        return 0;
    const bool halves = s->sequence.periods % 2 == 0;
    if (x->kind == SALTUS_POINT_LP && x->orbits.system->mirror) {
        const double image = saltus_solution_part_distance(&x->orbits, s, 1, NULL);
        if (image > are && !(halves && saltus_solution_part_distance(&x->orbits, s, 2, NULL) < image))
            return 1;
    }
    return halves ? 2 : 0;
}

/* Locate the place of unknowns u, known to `least`, where the curve joins that of orbits of half the period
 * or less, by the equations of these alone, as a point of this kind. False if that fails. */
static bool locate_join(saltus_extended *x, saltus_point_kind kind, int parts, const double *u, double least,
                        saltus_locus_point *at) {
    const double close = 1e-9, slack = 100;
    memcpy(at->at.u, u, (size_t)x->equations.unknowns * sizeof *u);
    return saltus_locus_see_orbit(x, at) &&
           (parts == 1 ? saltus_halved_still(x, kind, fmax(close, slack * least), at)
                       : saltus_halved_touch(x, kind, parts, fmax(close, slack * least), at));
}

/* The kind of place at which a curve of grazing joins shorter orbits, `at`. */
static saltus_point_kind kind_of_join(const saltus_extended *x, const saltus_solution *at, int parts) {
    return parts > 2 || touches_elsewhere(x, at, parts) ? SALTUS_POINT_GR_GR
           : parts == 2                                 ? SALTUS_POINT_GR_PD
                                                        : SALTUS_POINT_GR_BP;
}

/* Beyond a long run of impacts rounding hides at the base how an orbit differs from its mirror image, and
 * moves the place where they become one this far in the plane. */
static const double far_hidden = 1e-3;

static bool is_hidden(saltus_extended *x, const saltus_solution *s) {
    const double hidden = 1e-6;
    return !x->mirrored && saltus_solution_part_distance(&x->orbits, s, 1, NULL) < hidden;
}

saltus_point_kind saltus_locus_join_near(saltus_extended *x, saltus_locus_point *at) {
    const double small = 1e-3, near = 1e-6;
    int parts = x->kind == SALTUS_POINT_GR ? at->orbit.sequence.periods : 0;
    while (parts > 1 && !(saltus_solution_part_distance(&x->orbits, &at->orbit, parts, NULL) < small))
        parts--;
    const bool joins = parts > 1 ? saltus_halved_touch(x, SALTUS_POINT_GR_PD, parts, near, at)
                                 : parts == 1 && is_hidden(x, &at->orbit) &&
                                       saltus_halved_still(x, SALTUS_POINT_GR_BP, far_hidden, at);
    return joins ? kind_of_join(x, &at->orbit, parts) : SALTUS_POINT_REGULAR;
}

saltus_point_kind saltus_locus_join(saltus_extended *x, saltus_locus_point *here, saltus_locus_point *at) {
    static const double apart[] = {1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5};
    enum { spacings = sizeof apart / sizeof apart[0] };
    const double sharp[] = {1e-10, 1e-10, 1e-8}, trusted = 1e-11;
    const size_t size = (size_t)here->at.unknowns * sizeof(double);
    saltus_point_kind kind = SALTUS_POINT_REGULAR;
    int parts;
    double spread, ahead = 0, least = INFINITY;
    if (x->kind != SALTUS_POINT_GR)
        return saltus_locus_join_halves(x, here, at);
    if (!isfinite(saltus_locus_apart(x, &here->orbit, &parts)))
        return kind;
    double *u = x->kept;
    /* If several breaches fall to zero together, now one is the worst, now another: try the distance too.
     * That may be small of second order, where impacts undo each other's effects: try their speeds. */
    for (int k = 0; k < 3 * spacings && least > trusted; k++) {
        const measure by = k / spacings;
        if (!extrapolate(x, here, 0, apart[k % spacings], 6, by, parts, at, &spread) || !(spread < least) ||
            !(at->at.ahead > 0 && at->at.ahead < 2 * apart[k % spacings]) ||
            !(fabs(saltus_corner_breach(x, &at->orbit)) < sharp[by]) ||
            !(saltus_solution_part_distance(&x->orbits, &at->orbit, parts, NULL) < sharp[by]))
            continue;
        least = spread;
        ahead = at->at.ahead;
        memcpy(u, at->at.u, size);
        kind = kind_of_join(x, &at->orbit, parts);
    }
    if (kind && !locate_join(x, kind, parts, u, least, at)) {
        memcpy(at->at.u, u, size);
        at->doubt = least;
        saltus_locus_survey_orbit(x, at);
    }
    if (kind)
        at->at.ahead = ahead;
    if (!kind && is_hidden(x, &here->orbit) &&
        saltus_halved_ahead(x, SALTUS_POINT_GR_BP, 1, far_hidden, here, at))
        kind = kind_of_join(x, &at->orbit, 1);
    return kind;
}

/* Seek the place just ahead of `here` where what is left by a measure is nothing, from ever nearer and with
 * more or less places: `at` becomes the one that changes least, by less than `best`. False if there is none.
 */
static bool seek_end(saltus_extended *x, saltus_locus_point *here, measure by, int parts, double best,
                     saltus_locus_point *at) {
    static const double apart[] = {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4};
    const int first = by == BY_DISTANCE, end = by == BY_DISTANCE ? 7 : 4;
    const double farthest = 8, sharp = 1e-5, clear = 1e-6;
    const int m = here->at.unknowns, c = x->orbits.equations->count;
    double spread, ahead = 0, before[2] = {NAN, NAN}, *u = x->kept;
    for (int k = 2 * first; k < 2 * end; k++) {
        const double own = apart[k / 2];
        if (!extrapolate(x, here, 0, own, k % 2 ? SALTUS_SAMPLES_MOST : SALTUS_SAMPLES_MOST - 2, by, parts,
                         at, &spread))
            continue;
        /* The change from the attempt before says more than `spread` alone. */
        const double doubt = fmax(spread, hypot(at->at.u[c] - before[0], at->at.u[c + 1] - before[1]));
        const double breach = saltus_corner_breach(x, &at->orbit);
        memcpy(before, at->at.u + c, sizeof before);
        if (doubt < best && at->at.ahead > 0 && at->at.ahead < farthest * own &&
            (by == BY_DISTANCE ? breach < -clear && saltus_solution_part_distance(&x->orbits, &at->orbit,
                                                                                  parts, NULL) < sharp
                               : fabs(breach) < clear)) {
            best = doubt;
            ahead = at->at.ahead;
            memcpy(u, at->at.u, (size_t)m * sizeof *u);
        }
    }
    at->doubt = best;
    if (ahead > 0) {
        memcpy(at->at.u, u, (size_t)m * sizeof *u);
        at->at.ahead = ahead;
    }
    return ahead > 0 && saltus_locus_survey_orbit(x, at);
}

bool saltus_locus_fade(saltus_extended *x, saltus_locus_point *here, saltus_locus_point *at) {
    const double little = 1e-3, sharp = 1e-8, near = 1e-4;
    if (x->kind == SALTUS_POINT_GR || !(saltus_corner_breach(x, &here->orbit) > -little))
        return false;
    /* Where the equations fail only very near the end, that is not seen from afar. */
    if (!seek_end(x, here, BY_ROOT, 0, sharp, at))
        return saltus_halved_ahead(x, SALTUS_POINT_GR_LP, 0, near, here, at) ||
               saltus_halved_ahead(x, here->corners[0].kind, 1, near, here, at);
    saltus_halved_touch(x, SALTUS_POINT_GR_LP, 0, INFINITY, at);
    return true;
}

saltus_point_kind saltus_locus_join_halves(saltus_extended *x, saltus_locus_point *here,
                                           saltus_locus_point *at) {
    const int parts = may_join(x, &here->orbit);
    if (!parts)
        return SALTUS_POINT_REGULAR;
    /* From afar demand more accuracy: a step nearer may locate the place better and still not be too
     * close. */
    const double best = saltus_locus_apart(x, &here->orbit, NULL) > close_by ? 3e-9 : 1e-7;
    return seek_end(x, here, BY_DISTANCE, parts, best, at) ? saltus_halved_tell(x, parts == 1, at)
                                                           : SALTUS_POINT_REGULAR;
}

/* How many events an orbit has in the first half of its period. */
static int first_half_count(const saltus_sequence *s) {
    int count = 0;
    while (count < s->count && s->mark[count].time < s->base + 0.5 * s->periods)
        count++;
    return count;
}

bool saltus_locus_halves_ahead(saltus_extended *x, const saltus_locus_point *here,
                               const saltus_locus_point *next, double *ahead) {
    const double small = 0.3, little = 1e-3;
    double from[SALTUS_STATE_MAX], to[SALTUS_STATE_MAX], product = 0;
    /* Where grazing is near the halves become alike with it, and the curve ends there. */
    const int parts = saltus_corner_breach(x, &next->orbit) > -little ? 0 : may_join(x, &next->orbit);
    if (!parts)
        return false;
    const double own = saltus_solution_part_distance(&x->orbits, &here->orbit, parts == 1 ? 1 : 2, from);
    const double other = saltus_solution_part_distance(&x->orbits, &next->orbit, parts == 1 ? 1 : 2, to);
    if (!isfinite(own) || !isfinite(other))
        return false;
    for (int i = 0; i < x->orbits.n; i++)
        product += from[i] * to[i];
    /* The states half a period apart jump as an impact comes to be in the other half. */
    if (other > saltus_alike &&
        first_half_count(&here->orbit.sequence) != first_half_count(&next->orbit.sequence))
        return false;
    const bool folds = x->kind == SALTUS_POINT_LP,
               strays = product < 0 || other < small * own || (folds && own < saltus_alike && other < own);
    /* If Newton's method was drawn onto the flips of the shorter orbits, which solve these equations too, the
     * step was long. */
    *ahead = !strays ? 0 : next->at.ahead * (product < 0 ? 0.9 * own / (own + other) : 0.5);
    return strays || (folds && own < close_by && other < own);
}

double saltus_locus_sharpness(saltus_extended *x, const saltus_locus_point *here, double usual) {
    const double sharp = 1e-12, near = 0.1, share = 1e-4;
    const int parts = may_join(x, &here->orbit);
    if (parts && saltus_solution_part_distance(&x->orbits, &here->orbit, parts, NULL) < near)
        return sharp;
    double slowest, fastest;
    saltus_solution_speed_range(&here->orbit, &slowest, &fastest);
    return x->kind == SALTUS_POINT_GR ? usual : fmin(fmax(share * slowest, sharp), usual);
}
