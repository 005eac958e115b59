/* Points of codimension two at which curves of folds or tori of orbits of twice a period end, located by the
 * equations of the shorter orbits.
 *
 * GPD, LP-PD, PD-NS and R2 lie on the curve of flips of the shorter orbits, which is regular there. Each is
 * the zero of a function along it: the flip's criticality, a multiplier minus 1, the squared modulus of a
 * pair minus 1, the product of the null vectors. CP, where the folding orbits become their own mirror images,
 * is the zero of the criticality along the curve of branch points of such orbits. R4 is where the curve of
 * tori of the shorter orbits has the angle pi/2, which is an unknown there. Where an impact loses its speed
 * the end lies on the curve of that grazing, of shorter orbits or of the same.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/join.h"

#include "branch/locus_starts.h"
#include "branch/sequence.h"

#include <math.h>
#include <string.h>

/* The search along a curve of flips, or of tori, of the shorter orbits. */
typedef struct shorter {
    saltus_extended x;
    double *u;              /* unknowns from which the curve is sought, the shooting's */
    saltus_locus_point on;  /* its first point */
    saltus_curve_point at;  /* a point ahead of that */
    saltus_point_kind kind; /* the kind of point that is sought */
    double apart;           /* width of the differences for it */
    double exponent;        /* of the determinant for it */
    int parts; /* at grazing: how many of these orbits are one of the curve; R4: after them a free vibration
                  comes back or turns round */
    bool without; /* GR-PD: it is the orbit without the grazing impact that flips */
} shorter;

/* s->on.orbit becomes the one with these unknowns. */
static saltus_status see_orbit(shorter *s, const double *u) {
    saltus_solution *orbit = &s->on.orbit;
    saltus_equations *e = s->x.orbits.equations;
    if (!saltus_curve_reserve(&orbit->at, e->unknowns))
        return SALTUS_NO_MEMORY;
    memcpy(orbit->at.u, u, (size_t)e->unknowns * sizeof *u);
    saltus_status status = saltus_equations_evaluate(e, orbit->at.u, NULL);
    return status == SALTUS_OK ? saltus_solution_see(&s->x.orbits, orbit, NULL) : status;
}

/* Evaluate the orbit at s->at without its grazing impact by a separate shooting, which the caller frees. */
static saltus_status evaluate_without(shorter *s, saltus_shooting **shooting) {
    const saltus_status status = see_orbit(s, s->at.u);
    const saltus_sequence less = saltus_corner_without(&s->x, &s->on.orbit);
    return status == SALTUS_OK ? saltus_orbits_evaluate(&s->x.orbits, &s->on.orbit, &less, shooting, NULL)
                               : status;
}

/* The function of that kind on the curve of grazing, at the orbit at s->at; the breach is that of another
 * impact that grazes, too. */
static saltus_status measure_grazing(shorter *s, double *value) {
    saltus_locus_test corners[SALTUS_CORNERS_MAX];
    const saltus_status status = see_orbit(s, s->at.u);
    *value = NAN;
    const int count = status == SALTUS_OK ? saltus_corner_measure(&s->x, &s->at, &s->on.orbit, corners) : 0;
    for (int k = 0; k < count; k++)
        if (corners[k].kind == s->kind && corners[k].without == s->without) {
            const saltus_scaled own = corners[k].value;
            s->exponent = isnan(s->exponent) && own.mantissa != 0 ? own.exponent : s->exponent;
            *value = saltus_scaled_in(own, s->exponent);
        }
    return status;
}

/* The function that is zero at the point sought, on the curve `ahead` of s->on. From multipliers: the one
 * closest to 1, minus 1; the squared modulus, minus 1, of the pair closest to the unit circle; or, without
 * the grazing impact, how far in angle a pair on the circle is from coming to 1 or -1 after some orbits. */
static bool test_at(void *context, double ahead, double *value) {
    shorter *s = context;
    const double on = 1e-6;
    const bool pair = s->kind == SALTUS_POINT_PD_NS, grazes = s->x.kind == SALTUS_POINT_GR,
               comes_back = s->kind == SALTUS_POINT_R4,
               multipliers = pair || comes_back || s->kind == SALTUS_POINT_LP_PD;
    saltus_orbits *o = &s->x.orbits;
    saltus_shooting *without = NULL;
    double rounding, re[SALTUS_STATE_MAX], im[SALTUS_STATE_MAX];
    saltus_status status = saltus_curve_visit(&s->x.equations, &s->on.at, ahead, &s->at, NULL);
    if (status == SALTUS_OK && grazes && !comes_back)
        status = measure_grazing(s, value);
    else if (status == SALTUS_OK && !comes_back)
        *value = saltus_extended_double(&s->x, &rounding);
    if (status == SALTUS_OK && (s->kind == SALTUS_POINT_GPD || s->kind == SALTUS_POINT_CP))
        status = saltus_extended_criticality(&s->x, s->at.u, s->apart, value);
    if (status == SALTUS_OK && comes_back)
        status = evaluate_without(s, &without);
    else if (status == SALTUS_OK && multipliers)
        status = saltus_equations_evaluate(o->equations, s->at.u, NULL);
    int count = 0;
    if (status == SALTUS_OK && multipliers) {
        count = saltus_corner_multipliers(o, without ? without : o->shooting, re, im);
        *value = INFINITY;
    }
    for (int k = 0; k < count; k++) {
        const double square = re[k] * re[k] + im[k] * im[k];
        const bool fits = comes_back ? im[k] > 0 && fabs(square - 1) < on : (im[k] != 0) == pair;
        const double own = comes_back ? remainder(s->parts * atan2(im[k], re[k]), M_PI)
                           : pair     ? square - 1
                                      : re[k] - 1;
        if (fits && fabs(own) < fabs(*value))
            *value = own;
    }
    saltus_shooting_free(without);
    return saltus_orbits_noted(o, status) == SALTUS_OK && isfinite(*value);
}

/* s->at becomes the zero of the test near s->on, where the test is almost linear; *doubt as for
 * saltus_locus_doubt, or NULL. False if there is none. */
static bool find_zero(shorter *s, double *doubt) {
    /* As the period changes free vibrations turn evenly; and long orbits change much with the parameters, and
     * are known less well, which *doubt tells. */
    const bool own = s->parts == 1, far = own || s->kind == SALTUS_POINT_R4;
    const int rounds = far ? 8 : 4;
    const double first = 1e-5, farthest = far ? 2e-2 : 1e-3, still = own ? 1e-6 : 1e-9;
    double place = 0, begin = NAN, value = NAN;
    bool found = test_at(s, first, &value) && test_at(s, place, &begin);
    const double slope = (value - begin) / first;
    value = begin;
    for (int k = 0; k < rounds && found; k++) {
        place -= value / slope;
        found = fabs(place) < farthest && test_at(s, place, &value);
    }
    found = found && fabs(value) < still * fabs(slope);
    if (found && doubt) {
        shorter other = *s;
        other.on.orbit = (saltus_solution){.value = 0};
        other.at = (saltus_curve_point){.unknowns = 0};
        const bool opened = saltus_extended_open_other(&s->x, &other.x) == SALTUS_OK;
        *doubt = saltus_locus_doubt(test_at, s, opened ? &other : NULL, place, &s->at, &other.at,
                                    s->x.orbits.equations->count);
        saltus_solution_clear(&other.on.orbit);
        saltus_curve_clear(&other.at);
        saltus_extended_close_other(&s->x, &other.x);
        found = test_at(s, place, &value);
    }
    return found;
}

/* The same for GPD and CP, whose test is made of differences: their width is the one at which the place
 * changes least from the width before. */
static bool find_change(shorter *s, double *doubt) {
    enum { widths = 6 };
    double place[widths], least = INFINITY;
    int best = 0;
    for (int k = 0; k < widths; k++) {
        s->apart = k == 0 ? 0.032 : 0.5 * s->apart;
        place[k] = find_zero(s, NULL) ? s->at.ahead : NAN;
        const double change = k > 0 ? fabs(place[k] - place[k - 1]) : NAN;
        if (change < least) {
            least = change;
            best = k;
        }
    }
    s->apart = ldexp(0.032, -best);
    const bool found = best > 0 && find_zero(s, doubt);
    *doubt += least;
    return found;
}

/* s->on becomes a point of a curve of the shorter orbits, or of the symmetric ones, near the orbit of `at`:
 * of flips (PD), of branch points (BP), of grazing of a mark (GR), or that of angle pi/2 on the curve of tori
 * (NS). The caller closes `s` in any case. */
static bool open_shorter(shorter *s, const saltus_extended *whole, const saltus_locus_point *at,
                         const saltus_sequence *sequence, saltus_point_kind locus, int mark, bool mirrored) {
    const double sharp = 1e-12, far = 1e-4;
    const bool turns = locus == SALTUS_POINT_NS;
    *s = (shorter){.exponent = NAN,
                   .x = {.kind = locus,
                         .orbits = whole->orbits,
                         .mark = mark,
                         .mirrored = mirrored,
                         .extra = turns || locus == SALTUS_POINT_BP,
                         .copies = 1 + turns,
                         .sharp = true,
                         .equations = {.self = &s->x,
                                       .evaluate = saltus_extended_evaluate,
                                       .tolerance = sharp,
                                       .iterations = whole->equations.iterations}}};
    saltus_orbits *o = &s->x.orbits;
    o->shooting = NULL;
    saltus_status status = saltus_orbits_shoot(&whole->orbits, &at->orbit, sequence, &o->shooting, NULL);
    o->equations = status == SALTUS_OK ? &o->shooting->equations : NULL;
    if (saltus_orbits_noted(o, status) != SALTUS_OK)
        return false;
    s->u = o->equations->trial;
    const int c = o->equations->count;
    bool found = false;
    /* One parameter is kept fixed, or the angle. */
    for (int tried = 0; tried < 2 - turns && !found; tried++) {
        const int k = turns ? c + 2 : c + 1 - tried;
        status = saltus_locus_take_up(&s->x, &s->on, s->u, turns ? 0.5 * M_PI : 0, NULL);
        if (status == SALTUS_OK)
            status = saltus_locus_find_first(&s->x, &s->on, k, NULL);
        found =
            saltus_orbits_noted(o, status) == SALTUS_OK &&
            hypot(s->on.at.u[c] - s->u[c], s->on.at.u[c + 1] - s->u[c + 1]) < far &&
            saltus_orbits_noted(o, saltus_equations_evaluate(o->equations, s->on.at.u, NULL)) == SALTUS_OK;
    }
    return found;
}

/* The kind of point on the curve of flips near s->on, from the multipliers there. */
static saltus_point_kind name_flip(shorter *s, saltus_point_kind locus) {
    const double near = 1e-3;
    double re[SALTUS_STATE_MAX], im[SALTUS_STATE_MAX];
    const int count = saltus_corner_multipliers(&s->x.orbits, s->x.orbits.shooting, re, im);
    int flips = 0, folds = 0;
    for (int k = 0; k < count; k++) {
        flips += hypot(re[k] + 1, im[k]) < near;
        folds += hypot(re[k] - 1, im[k]) < near;
    }
    if (locus == SALTUS_POINT_LP)
        return flips == 1 && !folds ? SALTUS_POINT_GPD : SALTUS_POINT_REGULAR;
    return flips == 2            ? SALTUS_POINT_R2
           : flips == 1 && folds ? SALTUS_POINT_LP_PD
           : flips == 1          ? SALTUS_POINT_PD_NS
                                 : SALTUS_POINT_REGULAR;
}

/* Move a mark to the time of that of a shorter orbit which is meant; returns which it is, -1: there is none.
 */
static int find_mark(const saltus_sequence *once, saltus_mark *mark) {
    const double near = 1e-3, time = mark->time;
    double least = near;
    int found = -1;
    for (int k = 0; k < once->count; k++) {
        const double apart = remainder(once->mark[k].time - time, once->periods);
        if (once->mark[k].face != mark->face || !(fabs(apart) < least))
            continue;
        least = fabs(apart);
        mark->time = time + apart;
        found = k;
    }
    return found;
}

/* `at` becomes the shorter orbit with these unknowns, traversed as often as its own sequence tells, which has
 * all its marks or, where some have no speed, only some of them. False if that cannot be. */
static bool go_through(saltus_extended *x, shorter *s, const double *unknowns, saltus_locus_point *at) {
    saltus_sequence whole = at->orbit.sequence;
    const saltus_sequence *once = &s->on.orbit.sequence;
    saltus_shooting *shooting = NULL;
    saltus_status status = see_orbit(s, unknowns);
    const bool all = whole.count == once->count * (whole.periods / once->periods);
    for (int k = 0; k < whole.count; k++)
        if (all)
            whole.mark[k].time = once->mark[k % once->count].time + k / once->count * once->periods;
        else if (find_mark(once, &whole.mark[k]) < 0)
            return false;
    if (status == SALTUS_OK)
        status = saltus_orbits_shoot(&x->orbits, &s->on.orbit, &whole, &shooting, NULL);
    const bool found = saltus_orbits_noted(&x->orbits, status) == SALTUS_OK;
    if (found)
        memcpy(at->at.u, shooting->equations.trial, (size_t)x->orbits.equations->unknowns * sizeof(double));
    saltus_shooting_free(shooting);
    return found && saltus_locus_survey_orbit(x, at);
}

static void close_shorter(saltus_extended *x, shorter *s) {
    x->orbits.starved |= s->x.orbits.starved;
    saltus_extended_close(&s->x);
    saltus_shooting_free(s->x.orbits.shooting);
    saltus_locus_point_clear(&s->on);
    saltus_curve_clear(&s->at);
}

/* The impacts of all parts of an orbit in one: the sequence of an orbit of so much less period that has or
 * touches at all of them. Returns the mark in it that `slow` becomes; -1: there are other events than
 * impacts. */
static int lay_together(const saltus_sequence *whole, int parts, int slow, saltus_sequence *once) {
    *once = *whole;
    once->periods /= parts;
    once->cuts = 1;
    once->count = 0;
    for (int k = 0; k < whole->count; k++) {
        saltus_mark own = whole->mark[k];
        if (own.kind != SALTUS_IMPACT)
            return -1;
        while (own.time >= once->base + once->periods)
            own.time -= once->periods;
        int at = once->count;
        if (find_mark(once, &own) >= 0)
            continue;
        for (; at > 0 && once->mark[at - 1].time > own.time; at--)
            once->mark[at] = once->mark[at - 1];
        once->mark[at] = own;
        once->count++;
    }
    saltus_mark own = whole->mark[slow];
    return find_mark(once, &own);
}

/* `at` becomes the zero of the test, if the shorter orbits could be opened and have one no farther away than
 * this. Closes them. */
static bool finish(saltus_extended *x, shorter *s, bool opened, double farthest, saltus_locus_point *at) {
    double doubt = NAN;
    const int c = opened ? s->x.orbits.equations->count : 0;
    const bool found = opened && find_zero(s, &doubt) && (s->parts != 1 || !isnan(doubt)) &&
                       hypot(s->at.u[c] - s->u[c], s->at.u[c + 1] - s->u[c + 1]) < farthest &&
                       go_through(x, s, s->at.u, at);
    if (found)
        at->doubt = doubt;
    close_shorter(x, s);
    return found;
}

bool saltus_halved_touch(saltus_extended *x, saltus_point_kind kind, int parts, double farthest,
                         saltus_locus_point *at) {
    const double alike = 1e-5, near = 1e-6;
    const saltus_breach *touch = saltus_solution_slowest(&at->orbit);
    saltus_sequence once;
    shorter s;
    const saltus_sequence *whole = &at->orbit.sequence;
    const int given = parts > 1 ? parts : 1;
    parts = given > 1 ? given : 2;
    for (int k = whole->periods; k > parts; k--)
        parts = k % given == 0 && saltus_solution_part_distance(&x->orbits, &at->orbit, k, NULL) < alike
                    ? k
                    : parts;
    const int mark =
        touch && parts > 1 && whole->periods % parts == 0
            ? lay_together(whole, parts, x->kind == SALTUS_POINT_GR ? x->mark : touch->mark, &once)
            : -1;
    const saltus_point_kind kinds[] = {parts > 2 ? SALTUS_POINT_R4 : kind, SALTUS_POINT_GR_LP,
                                       SALTUS_POINT_GR_PD};
    bool found = false;
    for (int k = 0; k < (kind == SALTUS_POINT_R4 ? 1 : 3) && mark >= 0 && !found; k++) {
        saltus_solution_cuts(&at->orbit, &once);
        const bool opened = open_shorter(&s, x, at, &once, SALTUS_POINT_GR, mark, false);
        s.kind = kinds[k];
        s.parts = parts;
        s.without = s.kind == SALTUS_POINT_GR_PD && whole->count < parts * once.count;
        found = finish(x, &s, opened, k ? fmin(near, farthest) : farthest, at);
    }
    return found;
}

bool saltus_halved_still(saltus_extended *x, saltus_point_kind kind, double farthest,
                         saltus_locus_point *at) {
    const double slow = 1e-5;
    const saltus_breach *touch = saltus_solution_slowest(&at->orbit);
    const bool grazes = x->kind == SALTUS_POINT_GR;
    saltus_sequence whole = at->orbit.sequence;
    shorter s;
    if (!touch || !(touch->value > saltus_corner_breach(x, &at->orbit) - slow))
        return false;
    const saltus_mark *own = &at->orbit.sequence.mark[x->mark];
    const saltus_breach same = {.face = own->face, .time = own->time};
    const int mark =
        grazes ? saltus_locus_starts_grazing(&x->orbits, &at->orbit, &same, &whole) : touch->mark;
    if (mark < 0 || whole.periods != at->orbit.sequence.periods)
        return false;
    saltus_solution_cuts(&at->orbit, &whole);
    const bool opened = open_shorter(&s, x, at, &whole, SALTUS_POINT_GR, mark, grazes || x->mirrored);
    s.kind = kind;
    s.without = whole.count > at->orbit.sequence.count;
    s.parts = 1;
    return finish(x, &s, opened, farthest, at);
}

bool saltus_halved_double(saltus_extended *x, saltus_point_kind kind, saltus_locus_point *at) {
    const saltus_sequence whole = at->orbit.sequence;
    shorter s;
    const bool opened = open_shorter(&s, x, at, &whole,
                                     kind == SALTUS_POINT_R2 ? SALTUS_POINT_PD : SALTUS_POINT_LP, 0, false);
    s.kind = kind;
    return finish(x, &s, opened, INFINITY, at);
}

bool saltus_halved_ahead(saltus_extended *x, saltus_point_kind kind, int parts, double near,
                         const saltus_locus_point *here, saltus_locus_point *at) {
    const bool hidden = parts == 1 && x->kind == SALTUS_POINT_GR,
               room = saltus_curve_copy(&here->at, &at->at);
    x->orbits.starved |= !room;
    if (!room || !saltus_locus_see_orbit(x, at) ||
        !(parts == 1 ? saltus_halved_still(x, kind, hidden ? near : INFINITY, at)
                     : saltus_halved_touch(x, kind, parts, INFINITY, at)))
        return false;
    const bool leads = saltus_locus_leads(x, here, near, at);
    at->at.ahead = leads ? at->at.ahead : 0;
    return leads || hidden;
}

bool saltus_halved_resonates(saltus_extended *x, const saltus_locus_point *here, saltus_locus_point *at) {
    const double alike = 1e-4, near = 1e-2;
    int parts = x->kind == SALTUS_POINT_GR ? here->orbit.sequence.periods : 0;
    while (parts > 2 && !(saltus_solution_part_distance(&x->orbits, &here->orbit, parts, NULL) < alike))
        parts--;
    return parts > 2 && saltus_halved_ahead(x, SALTUS_POINT_R4, parts, near, here, at);
}

saltus_point_kind saltus_halved_tell(saltus_extended *x, bool mirrored, saltus_locus_point *at) {
    const double alike = 1e-7;
    saltus_sequence half = at->orbit.sequence;
    double state[SALTUS_STATE_MAX];
    saltus_point_kind kind = mirrored ? SALTUS_POINT_CP : SALTUS_POINT_REGULAR, locus = SALTUS_POINT_PD;
    if (mirrored) {
        locus = SALTUS_POINT_BP;
        half.cuts = 2;
        half.cut[1] = half.base + 0.5 * half.periods;
    } else {
        half = saltus_sequence_part(&half, 2);
    }
    if (!mirrored && half.periods % 2 == 0 && half.count % 2 == 0 &&
        saltus_solution_state_at(&x->orbits, &at->orbit, half.base + 0.5 * half.periods, state, NULL) ==
            SALTUS_OK &&
        saltus_system_distance(x->orbits.system, state, at->orbit.state) < alike) {
        half = saltus_sequence_part(&half, 2);
        locus = SALTUS_POINT_NS;
    }
    const bool turns = locus == SALTUS_POINT_NS;
    double doubt = NAN;
    shorter s;
    if (!mirrored)
        saltus_solution_cuts(&at->orbit, &half);
    if (open_shorter(&s, x, at, &half, locus, 0, mirrored)) {
        kind = s.kind = turns ? SALTUS_POINT_R4 : mirrored ? SALTUS_POINT_CP : name_flip(&s, x->kind);
        const bool by_change = kind == SALTUS_POINT_GPD || kind == SALTUS_POINT_CP;
        const bool found = kind && !turns && (by_change ? find_change : find_zero)(&s, &doubt);
        if (found || turns) {
            go_through(x, &s, found ? s.at.u : s.on.at.u, at);
            at->doubt = doubt;
        } else if (!by_change) {
            kind = SALTUS_POINT_REGULAR;
        }
    }
    close_shorter(x, &s);
    return kind;
}
