/* Special points on a step: found by the signs of tests, located, and judged.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/special.h"

#include "branch/sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An orbit at least this far from its mirror image is not symmetric. */
static const double asymmetric = 1e-7;

bool saltus_test_crosses(double a, double c) {
    return isfinite(a) && isfinite(c) && a != 0 && a * c <= 0;
}

int saltus_special_insert(saltus_special found, saltus_special *specials, int count) {
    int k = count;
    for (; k > 0 && specials[k - 1].ahead > found.ahead; k--)
        specials[k] = specials[k - 1];
    specials[k] = found;
    return count + 1;
}

/* Whether a step begins or ends at grazing, with an impact of zero speed. If multipliers pass through grazing
 * unchanged, as in planar flows, the determinants there are only rounding. */
static bool grazes(const saltus_solution *end) {
    const double still = 1e-9;
    for (int k = 0; k < end->breach_count; k++)
        if (end->breaches[k].kind == SALTUS_BREACH_SPEED && fabs(end->breaches[k].value) < still)
            return true;
    return false;
}

/* A place on a step with its tests' values, NAN where one is not compared, and the number of multipliers
 * that are not inside the unit circle. */
typedef struct place {
    double ahead, value[SALTUS_TEST_PAIR + 1];
    int outside; /* -1: not known */
} place;

/* Whether a test's zero between two places is known. Rounding may put it on the other side of a place so
 * close that the tests' zeros cannot be told apart. */
static bool is_known(const saltus_special *specials, int count, saltus_test test, double first, double last) {
    const double close = 1e-7;
    for (int k = 0; k < count; k++)
        if (specials[k].test == test && specials[k].ahead >= first - close &&
            specials[k].ahead <= last + close)
            return true;
    return false;
}

/* Locate a special point between two places ahead of `from` by its test and insert it in order of arclength.
 * `near` and `far`: the test's values there. */
static int add(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to, const double ends[2],
               double near, double far, saltus_special found, saltus_special *specials, int count,
               saltus_solution *scratch) {
    const double values[] = {near, far}, rounding = 1e-8, gap = 1e-10;
    if (!saltus_test_crosses(near, far) ||
        (found.test != SALTUS_TEST_VALUE && is_known(specials, count, found.test, ends[0], ends[1])) ||
        (found.test != SALTUS_TEST_VALUE &&
         ((ends[0] == 0 && fabs(near) < rounding * fabs(far) && grazes(from)) ||
          (found.test != SALTUS_TEST_PAIR && ends[1] == to->at.ahead && fabs(far) < rounding * fabs(near) &&
           grazes(to)))))
        return count;
    found.ahead = ends[1];
    if (far != 0) {
        const bool whole = ends[0] == 0 && ends[1] == to->at.ahead && found.test != SALTUS_TEST_PAIR;
        const saltus_zero zero = saltus_solution_zero_between(o, found.test, found.target, from,
                                                              whole ? to : NULL, ends, values, scratch);
        found.ahead = zero.ahead;
        found.accuracy = zero.accuracy;
        /* Where there are no orbits with the value a sharp bracket only holds the gap between others. */
        const bool leaps = zero.found && found.test == SALTUS_TEST_VALUE &&
                           fabs(scratch->value - found.target) > gap * o->family.unit[0];
        const bool singular = found.kind == SALTUS_POINT_BP || found.kind == SALTUS_POINT_HB;
        found.lost = leaps || (!zero.found && !singular);
        if (!zero.found) /* singular: interpolated later */
            found.ahead = ends[0] + (ends[1] - ends[0]) * near / (near - far);
    }
    if (found.test != SALTUS_TEST_VALUE && is_known(specials, count, found.test, found.ahead, found.ahead))
        return count;
    return saltus_special_insert(found, specials, count);
}

/* The same along the whole step. */
static int add_along(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to,
                     saltus_special found, saltus_special *specials, int count, saltus_solution *scratch) {
    const double ends[] = {0, to->at.ahead};
    return add(o, from, to, ends, saltus_test_value(found.test, found.target, from, from),
               saltus_test_value(found.test, found.target, to, from), found, specials, count, scratch);
}

/* `hidden`: bits of the tests that are not compared there. */
static place place_of(const saltus_solution *s, const saltus_solution *from, double ahead, unsigned hidden) {
    const double inside = -1e-5; /* logarithm of the modulus */
    place own = {.ahead = ahead, .outside = s->survey.unstable < 0 ? -1 : 0};
    for (int k = 0; k < s->survey.multiplier_count && own.outside >= 0; k++)
        own.outside += s->survey.multipliers[k].log_modulus > inside;
    for (int test = 0; test <= SALTUS_TEST_PAIR; test++)
        own.value[test] = hidden >> test & 1 ? NAN : saltus_test_value((saltus_test)test, 0, s, from);
    return own;
}

/* `scratch` becomes the orbit at a place, surveyed. False: there is none on this curve. */
static bool look(saltus_orbits *o, const saltus_solution *from, double ahead, saltus_solution *scratch) {
    return saltus_solution_visit(o, from, ahead, scratch) && !saltus_special_strays(o, from, scratch) &&
           saltus_orbits_noted(o, saltus_solution_survey(o, scratch, NULL)) == SALTUS_OK;
}

enum { places_max = 32, tested_max = 8 };

/* Insert a place between the first and the last one, unless the curve is not reached there, or there is no
 * more room. Returns the new number. */
static int insert(saltus_orbits *o, const saltus_solution *from, double ahead, unsigned hidden,
                  saltus_solution *scratch, place *places, int known) {
    int at = known;
    if (known == places_max || !(ahead > places[0].ahead) || !(ahead < places[known - 1].ahead) ||
        !look(o, from, ahead, scratch))
        return known;
    for (; places[at - 1].ahead > ahead; at--)
        places[at] = places[at - 1];
    places[at] = place_of(scratch, from, ahead, hidden);
    return known + 1;
}

/* How many multipliers may cross the unit circle at zeros of tests between two places; a test that is hidden
 * at one of them may have a zero. */
static int crossings_between(const place *a, const place *b) {
    int count = 0;
    for (int test = 0; test <= SALTUS_TEST_PAIR; test++) {
        const double before = a->value[test], after = b->value[test];
        if (isnan(before) || isnan(after) || saltus_test_crosses(before, after))
            count += test == SALTUS_TEST_PAIR ? 2 : 1;
    }
    return count;
}

/* Where two multipliers cross the unit circle, places in between: two flips are two zeros of one test, and so
 * may be a torus and a place where two real multipliers have the product 1. Towards grazing, where
 * multipliers grow without bound, these may be close to each other compared with the step. */
static int part_crossings(saltus_orbits *o, const saltus_solution *from, saltus_solution *scratch,
                          place *places, int known) {
    const double coarse = 0.05 * places[known - 1].ahead, fine = 1e-6 * places[known - 1].ahead;
    for (int k = 1; k < known;) {
        const double width = places[k].ahead - places[k - 1].ahead;
        const int before = known, change = abs(places[k].outside - places[k - 1].outside);
        const bool told = places[k - 1].outside >= 0 && places[k].outside >= 0;
        const bool lacks = change > crossings_between(&places[k - 1], &places[k]);
        if (told && change > 1 && width > (lacks ? fine : coarse))
            known = insert(o, from, places[k].ahead - 0.5 * width, 0, scratch, places, known);
        k += known == before;
    }
    return known;
}

/* A value that has changed its sign between two others may be rounding, as where a pair of multipliers of
 * orbits without damping meets at -1 and both go on along the circle. */
static void hide_rounding(place *places, int known, double ahead) {
    const double rounding = 1e-9;
    for (int k = 1; k + 1 < known; k++)
        for (int test = 0; test <= SALTUS_TEST_PAIR && places[k].ahead == ahead; test++) {
            const double size = fmin(fabs(places[k - 1].value[test]), fabs(places[k + 1].value[test]));
            if (fabs(places[k].value[test]) < rounding * size)
                places[k].value[test] = NAN;
        }
}

/* Places with the products of saltus_survey there, NAN where these are not known. */
typedef struct samples {
    double ahead[9], value[3][9];
    int count;
} samples;

/* Insert a place in order. */
static void add_sample(samples *s, double ahead, const double product[3]) {
    int k = s->count++;
    for (; k > 0 && s->ahead[k - 1] > ahead; k--) {
        s->ahead[k] = s->ahead[k - 1];
        for (int f = 0; f < 3; f++)
            s->value[f][k] = s->value[f][k - 1];
    }
    s->ahead[k] = ahead;
    for (int f = 0; f < 3; f++)
        s->value[f][k] = product[f];
}

/* Whether a product may cross zero between sample k and the next one and come back, by the sample before or
 * the one beyond. */
static bool dips_after(const samples *s, int f, int k, double *lowest) {
    const double deep = 0.8, *x = s->ahead, *y = s->value[f];
    if (k > 0 && saltus_curve_dips(x + k - 1, y + k - 1, deep, lowest))
        return true;
    if (k + 2 >= s->count)
        return false;
    const double back[] = {-x[k + 2], -x[k + 1], -x[k]}, value[] = {y[k + 2], y[k + 1], y[k]};
    const bool dips = saltus_curve_dips(back, value, deep, lowest);
    *lowest = -*lowest;
    return dips;
}

/* Two multipliers may cross the unit circle, or one may cross it and come back, so that neither their number
 * outside nor the signs of tests tell. The products of saltus_survey fall towards zero there: places where
 * the parabolas through their values, also at the point before the step, are lowest. If that one is not
 * known, as on the first step of a branch, points within the step take its place; so they do for an orbit
 * that grazes. Where curves cross, and a branch may turn back into itself, that would be the crossing. At the
 * start of a `fresh` branch a multiplier is 1. */
static int part_dips(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to, bool fresh,
                     int product_count, saltus_solution *scratch, place *places, int known) {
    enum { most = sizeof((samples *)0)->ahead / sizeof(double) };
    const double all = to->at.ahead;
    const saltus_survey *survey = &from->survey;
    double lowest = 0, start[] = {fresh ? NAN : survey->circle[0], survey->circle[1], survey->circle[2]};
    samples s = {.count = 0};
    if (saltus_test_crosses(places[0].value[SALTUS_TEST_CROSSING],
                            places[known - 1].value[SALTUS_TEST_CROSSING]))
        return known;
    if (survey->past_place < 0)
        add_sample(&s, survey->past_place, survey->past);
    if (isfinite(survey->circle[1]))
        add_sample(&s, 0, start);
    add_sample(&s, all, to->survey.circle);
    for (double within = 0.5 * all; s.count < 3; within *= 0.5) {
        const int before = known;
        known = insert(o, from, within, 0, scratch, places, known);
        if (known == before)
            return known;
        hide_rounding(places, known, within);
        add_sample(&s, within, scratch->survey.circle);
    }
    for (int k = s.ahead[0] < 0; k + 1 < s.count;) {
        const int before = known;
        bool dips = false;
        for (int f = 0; f < product_count && !dips && s.count < most; f++)
            dips = dips_after(&s, f, k, &lowest);
        if (dips)
            known = insert(o, from, lowest, 0, scratch, places, known);
        if (known > before) {
            hide_rounding(places, known, lowest);
            add_sample(&s, lowest, scratch->survey.circle);
        }
        k += known == before;
    }
    return known;
}

/* Where a branch turns back into itself at `ahead`, a fold beyond is the image of one before, and so is the
 * end of the step of an orbit before: a place between that and the crossing. `early`: this close to it
 * the tangent is rounding. */
static double image_of_fold(const saltus_special *specials, int count, double ahead, double early,
                            const saltus_solution *to) {
    double beyond = to->at.ahead;
    for (int k = 0; k < count; k++)
        if (specials[k].test == SALTUS_TEST_FOLD && specials[k].ahead > ahead + 2 * early)
            beyond = fmin(beyond, specials[k].ahead);
    return ahead - 0.5 * (beyond - ahead);
}

/* Whether an orbit lacks the multiplier 1 or -1 of a fold, flip or crossing: where an impact has zero speed
 * the equations are singular for other reasons. But next to grazing multipliers change so fast that even at a
 * true flip, known to 13 digits, the multiplier need not be near -1. */
static bool lacks_multiplier(const saltus_solution *at, saltus_point_kind kind) {
    const double close = 0.05, wanted = kind == SALTUS_POINT_PD ? -1 : 1;
    const saltus_survey *survey = &at->survey;
    bool lacks = survey->walked && survey->multiplier_count > 0;
    for (int k = 0; k < survey->multiplier_count && lacks; k++)
        lacks = hypot(survey->multipliers[k].re - wanted, survey->multipliers[k].im) > close;
    return lacks;
}

/* Whether a pair stays on the unit circle, as of orbits without damping: it crosses by rounding only. */
static bool stays_on_circle(const saltus_solution *from, const saltus_solution *to) {
    const double rounding = 1e-9;
    return fabs(saltus_pair_off_circle(&from->survey)) < rounding &&
           fabs(saltus_pair_off_circle(&to->survey)) < rounding;
}

/* Add the zeros of tests. A test may have two zeros on a step around the zero of another one: where a branch
 * turns back into orbits that it has passed already, all other tests do; and where a single multiplier
 * crosses the unit circle, a pair of real ones may pass the product 1. So the tests are compared at the zeros
 * of others, too, or just before them where the equations are singular. At the start of a `fresh` branch
 * determinants are rounding, as far as the square root of the error of the parameter there, except that of
 * flips at a branch of twice the period: the next place is beyond it. */
static int add_tested(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to, bool fresh,
                      saltus_special *specials, bool *hidden, saltus_solution *scratch) {
    static const saltus_special kinds[] = {{.kind = SALTUS_POINT_LP, .test = SALTUS_TEST_FOLD},
                                           {.kind = SALTUS_POINT_PD, .test = SALTUS_TEST_FLIP},
                                           {.kind = SALTUS_POINT_BP, .test = SALTUS_TEST_CROSSING},
                                           {.kind = SALTUS_POINT_NS, .test = SALTUS_TEST_PAIR}};
    const double beyond = 1e-4, just = 1e-3;
    const bool far_from_flip = lacks_multiplier(from, SALTUS_POINT_PD) && !grazes(from);
    const unsigned vague = ~(far_from_flip ? 1u << SALTUS_TEST_FLIP : 0u);
    place places[places_max] = {place_of(from, from, 0, fresh ? vague : 0),
                                place_of(to, from, to->at.ahead, 0)};
    int count = 0, known = 2;
    if (fresh)
        known = insert(o, from, beyond, 0, scratch, places, known);
    /* At grazing all multipliers but one may be lost in rounding: how many are outside an orbit before tells.
     */
    if (places[known - 1].outside < 0)
        known = insert(o, from, (1 - just) * to->at.ahead, ~(1u << SALTUS_TEST_PAIR), scratch, places, known);
    const int kind_count = stays_on_circle(from, to) ? 3 : 4;
    known = part_dips(o, from, to, fresh, kind_count - 1, scratch, places, known);
    for (int pass = 0; pass < 2; pass++) {
        known = part_crossings(o, from, scratch, places, known);
        for (int k = 0; k < kind_count; k++) {
            const saltus_test test = kinds[k].test;
            const int before = count, compared = known;
            place last = places[0];
            for (int j = 1; j < compared && count < tested_max; j++) {
                const double ends[] = {last.ahead, places[j].ahead};
                if (isnan(places[j].value[test]) && j + 1 < compared)
                    continue;
                count = add(o, from, to, ends, last.value[test], places[j].value[test], kinds[k], specials,
                            count, scratch);
                last = places[j];
            }
            for (int j = 0; j < count && count > before; j++) {
                const double ahead = specials[j].ahead;
                if (specials[j].test != test || test > SALTUS_TEST_CROSSING)
                    continue;
                if (test == SALTUS_TEST_CROSSING) {
                    const double early = just * to->at.ahead,
                                 image = image_of_fold(specials, count, ahead, early, to);
                    const int without = known;
                    known = insert(o, from, ahead - early, 1u << test | 1u << SALTUS_TEST_FOLD, scratch,
                                   places, known);
                    *hidden = *hidden || (known == without && known < places_max && ahead > early);
                    known =
                        insert(o, from, image, fresh && image < beyond ? vague : 0, scratch, places, known);
                } else {
                    known = insert(o, from, ahead, fresh && ahead < beyond ? vague : 1u << test, scratch,
                                   places, known);
                }
            }
        }
    }
    return count;
}

/* Where an orbit shrinks to an equilibrium the curve goes on, to the same orbits half a period later, so the
 * branch ends there. Close to that place other zeros are dropped: the parameter turns there, and the flow's
 * direction, which borders the other determinants, is lost. */
static int end_at_equilibrium(saltus_special *specials, int count, double reach) {
    const double near = 0.05 * reach;
    int kept = 0;
    double hopf = INFINITY;
    for (int k = 0; k < count; k++)
        if (specials[k].kind == SALTUS_POINT_HB)
            hopf = specials[k].ahead;
    for (int k = 0; k < count; k++) {
        bool own = specials[k].kind == SALTUS_POINT_HB;
        if (own)
            specials[k].end = "the orbit shrinks to an equilibrium";
        if (own || specials[k].ahead < hopf - near)
            specials[kept++] = specials[k];
    }
    return kept;
}

bool saltus_special_hopf(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to,
                         saltus_special *special, saltus_solution *scratch) {
    const saltus_special wanted = {.kind = SALTUS_POINT_HB, .test = SALTUS_TEST_ONWARD};
    return from->sequence.omega > 0 && add_along(o, from, to, wanted, special, 0, scratch) > 0;
}

int saltus_special_find(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to, bool fresh,
                        const saltus_special *hopf, const saltus_special *wanted, int wanted_count,
                        saltus_special *specials, bool *hidden, saltus_solution *scratch) {
    *hidden = false;
    int count = add_tested(o, from, to, fresh, specials, hidden, scratch);
    for (int k = 0; k < wanted_count; k++)
        count = add_along(o, from, to, wanted[k], specials, count, scratch);
    if (hopf && hopf->ahead <= to->at.ahead)
        count = saltus_special_insert(*hopf, specials, count);
    return end_at_equilibrium(specials, count, to->at.ahead);
}

/* Distance in arclength between points that show how a test varies near its zero. */
static const double apart = 1e-6;

/* The value of a test, and the parameter, at this distance ahead of `at`. Where an orbit touches in several
 * places at once the greatest breach has a corner, so one `touch` is followed. */
static bool test_beside(saltus_orbits *o, saltus_test test, const saltus_breach *touch,
                        const saltus_solution *at, double ahead, saltus_solution *scratch, double *parameter,
                        double *value) {
    const bool found = saltus_solution_visit(o, at, ahead, scratch);
    if (found && test == SALTUS_TEST_PAIR)
        saltus_solution_survey(o, scratch, NULL);
    *parameter = scratch->parameter[0];
    *value = found ? saltus_test_value(test, 0, scratch, at) : NAN;
    if (found && test == SALTUS_TEST_BREACH) {
        double nearest = INFINITY;
        for (int k = 0; k < scratch->breach_count; k++) {
            const saltus_breach *b = &scratch->breaches[k];
            if (b->kind == touch->kind && b->face == touch->face && fabs(b->time - touch->time) < nearest) {
                nearest = fabs(b->time - touch->time);
                *value = b->value;
            }
        }
    }
    return isfinite(*value);
}

/* The parabola through three points of `y` one apart, at x from the middle one; *slope: its derivative. */
static double parabola(const double y[3], double x, double *slope) {
    const double rise = 0.5 * (y[2] - y[0]), bend = 0.5 * (y[0] + y[2]) - y[1];
    *slope = rise + 2 * bend * x;
    return y[1] + x * (rise + bend * x);
}

/* The parameter where a test is zero near `at`, by parabolas through three points around the one at distance
 * `middle` ahead of it, and the scatter there of points that should lie on them. */
static bool zero_around(saltus_orbits *o, saltus_test test, const saltus_breach *touch,
                        const saltus_solution *at, double middle, saltus_solution *scratch, double *parameter,
                        double *scatter) {
    static const double close[] = {-2e-3, -1e-3, 1e-3, 2e-3}; /* times `apart` */
    double place[3], value[3], along, rise, here, there, zero = -middle / apart;
    for (int k = 0; k < 3; k++)
        if (!test_beside(o, test, touch, at, middle + (k - 1) * apart, scratch, &place[k], &value[k]))
            return false;
    for (int k = 0; k < 3; k++) {
        const double off = parabola(value, zero, &rise);
        zero -= rise != 0 ? off / rise : 0;
    }
    *parameter = parabola(place, zero, &along);
    parabola(value, zero, &rise);
    const double slope = rise != 0 ? along / rise : 0;
    *scatter = middle == 0 ? fabs(slope * value[1]) : 0;
    for (size_t k = 0; k < sizeof close / sizeof close[0]; k++) {
        if (!test_beside(o, test, touch, at, middle + close[k] * apart, scratch, &here, &there))
            return false;
        *scatter = fmax(*scatter, fabs(here - parabola(place, close[k], &along)) +
                                      fabs(slope * (there - parabola(value, close[k], &rise))));
    }
    return isfinite(*parameter);
}

/* The doubt of saltus_special_doubt or, with `reach`, the same for a crossing of curves near `ahead` of `at`,
 * found at parameter `value`. */
static double doubt_of(saltus_orbits *o, saltus_test test, const saltus_solution *at, double ahead,
                       double reach, double value) {
    /* Orbits of a flow of another tolerance, at a solution of the shooting's sequence. */
    saltus_orbits other;
    saltus_solution there = {.value = 0}, scratch = {.value = 0};
    const saltus_breach touch = *saltus_solution_touch(at);
    const size_t size = (size_t)at->at.unknowns * sizeof *at->at.u;
    double here, beyond, scatter[2], doubt = INFINITY;
    saltus_status status = saltus_orbits_open_other(o, &other);
    if (status == SALTUS_OK)
        status = saltus_solution_place(&other, &at->sequence, at->parameter, at->state, false, &there, NULL);
    if (status == SALTUS_OK && there.at.unknowns != at->at.unknowns)
        status = SALTUS_NO_CONVERGENCE;
    if (status == SALTUS_OK) {
        memcpy(there.at.u, at->at.u, size);
        memcpy(there.at.tangent, at->at.tangent, size);
        /* Beside a crossing a less accurate prediction might lead to the other curve. */
        there.at.bent = at->at.bent;
        if (at->at.bent)
            memcpy(there.at.bend, at->at.bend, 2 * size);
        there.at.crossing = at->at.crossing;
        there.flip = at->flip;
        there.onward = at->onward;
    }
    if (status == SALTUS_OK && reach > 0 &&
        saltus_solution_crossing(&other, test, &there, ahead, reach, &scratch).found)
        doubt = saltus_cautious * fabs(scratch.value - value);
    /* At the end of a domain only one side works. */
    for (int side = 0; side < 3 && isinf(doubt) && status == SALTUS_OK && reach == 0; side++) {
        double middle = (side == 2 ? -1 : side) * apart;
        if (zero_around(o, test, &touch, at, middle, &scratch, &here, &scatter[0]) &&
            zero_around(&other, test, &touch, &there, middle, &scratch, &beyond, &scatter[1]))
            doubt =
                saltus_cautious * o->family.unit[0] * (fabs(beyond - here) + fmax(scatter[0], scatter[1]));
    }
    saltus_orbits_noted(o, other.starved ? SALTUS_NO_MEMORY : status);
    saltus_solution_clear(&there);
    saltus_solution_clear(&scratch);
    saltus_orbits_close(&other);
    return doubt;
}

double saltus_special_doubt(saltus_orbits *o, saltus_test test, const saltus_solution *at) {
    return doubt_of(o, test, at, 0, 0, 0);
}

saltus_status saltus_special_between(saltus_orbits *o, saltus_orbits *own, const saltus_solution *at,
                                     bool mirrored, saltus_solution *between) {
    const double half = 0.5 * at->sequence.periods;
    const int marks = at->sequence.count / 2;
    double *states, *later = NULL;
    if (!mirrored && at->sequence.periods % 2)
        return SALTUS_NO_CONVERGENCE;
    saltus_sequence sequence = at->sequence, beyond = at->sequence;
    if (!mirrored) {
        sequence.periods /= 2;
        sequence.count = marks;
        saltus_solution_cuts(at, &sequence);
    }
    beyond.base += half;
    beyond.cuts = sequence.cuts;
    for (int j = 0; j < beyond.cuts; j++)
        beyond.cut[j] += half;
    saltus_status status = saltus_solution_states_at(o, at, &sequence, &states, NULL);
    if (status == SALTUS_OK)
        status = saltus_solution_states_at(o, at, &beyond, &later, NULL);
    for (int j = 0; j < sequence.cuts * o->n && status == SALTUS_OK; j++)
        states[j] = 0.5 * (states[j] + (mirrored ? -later[j] : later[j]));
    for (int k = 0; k < marks; k++) {
        const double shift = 0.5 * (at->sequence.mark[k + marks].time - at->sequence.mark[k].time - half);
        sequence.mark[k].time += shift;
        sequence.mark[k + marks].time -= shift;
    }
    if (!mirrored)
        saltus_sequence_even(&sequence);
    if (status == SALTUS_OK)
        status = saltus_solution_restore(own, &sequence, at->parameter, states, !mirrored, between, NULL);
    free(states);
    free(later);
    if (!mirrored || status != SALTUS_OK)
        return status;
    /* At the place itself both curves' tangents are possible. */
    double *along = calloc((size_t)between->at.unknowns, sizeof *along);
    if (!along)
        return SALTUS_NO_MEMORY;
    saltus_sequence_carry(&at->sequence, at->at.tangent, &sequence, NULL, o->n, 1, along);
    status = saltus_curve_leaving(own->equations, between->at.u, along, between->at.tangent, NULL, NULL);
    free(along);
    return status;
}

/* `at`, on the curve of `from`, becomes `orbit`, which is of half the period or its own mirror image. It
 * keeps its tangent. */
static void repeat(saltus_orbits *o, const saltus_solution *from, const saltus_solution *orbit,
                   saltus_solution *at) {
    saltus_sequence sequence = at->sequence;
    const saltus_mark *mark = orbit->sequence.mark;
    const int count = orbit->sequence.count;
    /* Its times may be counted in half of the unit (saltus_sequence_even). */
    const double unit = orbit->sequence.omega > 1.5 * sequence.omega ? 0.5 : 1,
                 part = unit * orbit->sequence.periods;
    for (int k = 0; k < sequence.count; k++)
        sequence.mark[k].time = unit * mark[k % count].time + part * (k / count);
    saltus_sequence asked = sequence;
    asked.base /= unit;
    for (int j = 0; j < asked.cuts; j++)
        asked.cut[j] /= unit;
    double *states;
    saltus_status status = saltus_solution_states_at(o, orbit, &asked, &states, NULL);
    if (status == SALTUS_OK)
        status = saltus_shooting_shape(o->shooting, &sequence, NULL);
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(o->shooting, orbit->parameter, states, sequence.cuts, at->at.u, NULL);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(o->equations, at->at.u, NULL);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, at, NULL);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(o, at, NULL);
    saltus_orbits_noted(o, status);
    free(states);
    saltus_orbits_reshape(o, from);
}

/* Where the orbits between the halves of those near `at` have a zero of their own test: `place` becomes that
 * orbit, opened for other equations. This locates the place better than the equations of the branch that
 * joins them there, which are singular. */
static saltus_zero zero_between_halves(saltus_orbits *o, const saltus_solution *at, bool mirrored,
                                       saltus_solution *place) {
    static const double reach[] = {1e-2, 1e-3, 1e-4};
    /* Near the place a residual moves orbits by many times its size. */
    const double near = 1e-3, tolerance = 1e-13;
    saltus_orbits own = {.family = o->family, .origin = o->origin, .options = o->options};
    saltus_solution between = {.value = 0}, side[2] = {{.value = 0}, {.value = 0}};
    saltus_zero zero = {.found = false};
    own.options.tolerance = fmin(own.options.tolerance, tolerance);
    saltus_status status = saltus_orbits_open(&own, NULL);
    if (status == SALTUS_OK)
        status = saltus_special_between(o, &own, at, mirrored, &between);
    for (int k = 0; k < 3 && status == SALTUS_OK && !zero.found; k++) {
        if (mirrored) {
            zero = saltus_solution_crossing(&own, SALTUS_TEST_CROSSING, &between, 0, reach[k], place);
        } else if (saltus_solution_visit(&own, &between, -reach[k], &side[0]) &&
                   saltus_solution_visit(&own, &side[0], 2 * reach[k], &side[1]) &&
                   saltus_test_crosses(saltus_test_value(SALTUS_TEST_FLIP, 0, &side[0], &side[0]),
                                       saltus_test_value(SALTUS_TEST_FLIP, 0, &side[1], &side[0]))) {
            zero = saltus_solution_zero(&own, SALTUS_TEST_FLIP, 0, &side[0], &side[1], place);
        }
        zero.found = zero.found && fabs(place->parameter[0] - at->parameter[0]) < near;
        if (zero.found)
            zero.accuracy += mirrored
                                 ? doubt_of(&own, SALTUS_TEST_CROSSING, &between, 0, reach[k], place->value)
                                 : saltus_special_doubt(&own, SALTUS_TEST_FLIP, place);
    }
    saltus_orbits_noted(o, own.starved ? SALTUS_NO_MEMORY : status);
    saltus_solution_clear(&between);
    for (int k = 0; k < 2; k++)
        saltus_solution_clear(&side[k]);
    saltus_orbits_close(&own);
    return zero;
}

/* Whether at `at`, a fold, the branch joins that of half the period or, `mirrored`, asymmetric orbits join
 * those that are their own mirror images. If the place is found on that branch, `at` becomes the orbit there.
 */
static bool joins(saltus_orbits *o, const saltus_solution *from, saltus_solution *at, bool mirrored,
                  saltus_special *special) {
    if (mirrored && !o->system->mirror)
        return false;
    const double apart = saltus_solution_part_distance(o, at, mirrored ? 1 : 2, NULL),
                 unit = o->family.unit[0],
                 before = saltus_solution_part_distance(o, from, mirrored ? 1 : 2, NULL);
    /* A branch may also begin at such orbits; and beyond a long run of impacts the halves are always all but
     * alike. */
    const bool closes = apart < 0.05 * before;
    if (!(before > asymmetric &&
          (mirrored ? apart < 1e-3 && closes : apart < 2e-2 && at->sequence.count % 2 == 0)))
        return false;
    saltus_solution place = {.value = 0};
    const saltus_zero zero = zero_between_halves(o, at, mirrored, &place);
    const bool found = zero.found && fabs(place.value - at->value) < 1e-6 * unit;
    const bool is_one = mirrored || found || (closes && apart < 1e-4);
    if (is_one && zero.found) {
        special->value = place.value;
        special->accuracy = zero.accuracy;
    }
    if (is_one && found)
        repeat(o, from, &place, at);
    saltus_solution_clear(&place);
    if (!is_one)
        return false;
    special->kind = mirrored ? SALTUS_POINT_BP : SALTUS_POINT_PD;
    special->end = mirrored ? "joins the orbits that are their own mirror images"
                            : "joins the orbits of half the period";
    return true;
}

/* Whether a fold is so close to where the branch joins that of half the period, or orbits that are their own
 * mirror images, that it cannot be told from that place: the equations are singular there, and orbits as
 * close as the cube root of their residual may be found on either branch. The distance of the halves falls
 * evenly to nothing there. */
static bool is_beside_join(saltus_orbits *o, const saltus_solution *from, const saltus_solution *at) {
    bool beside = false;
    for (int mirrored = 0; mirrored < (o->system->mirror ? 2 : 1); mirrored++) {
        const double before = saltus_solution_part_distance(o, from, mirrored ? 1 : 2, NULL),
                     apart = saltus_solution_part_distance(o, at, mirrored ? 1 : 2, NULL);
        beside |= before > asymmetric && saltus_orbits_join(o, before, apart, at->at.ahead);
    }
    return beside;
}

bool saltus_special_forgets(const saltus_survey *survey) {
    bool all = survey->walked;
    for (int k = 0; k < survey->multiplier_count; k++)
        all = all && survey->multipliers[k].log_modulus == -INFINITY;
    return all && survey->multiplier_count > 0;
}

/* Whether a pair of multipliers crosses the unit circle at `ahead`, where the orbit is `at`. Where they
 * change fast rounding moves them off the circle; then orbits just before and beyond tell. `at` is
 * overwritten, and restored. */
static bool crosses_circle(saltus_orbits *o, const saltus_solution *from, double ahead, saltus_solution *at) {
    const double circle = 1e-6, close = 1e-3, off = saltus_pair_off_circle(&at->survey);
    double beside[2];
    if (!(fabs(off) > circle && fabs(off) < close))
        return fabs(off) <= circle;
    for (int k = 0; k < 2; k++)
        beside[k] =
            look(o, from, ahead + (k ? apart : -apart), at) ? saltus_pair_off_circle(&at->survey) : INFINITY;
    return look(o, from, ahead, at) && fabs(beside[0]) < INFINITY && fabs(beside[1]) < INFINITY &&
           beside[0] * beside[1] < 0;
}

bool saltus_special_visit(saltus_orbits *o, const saltus_solution *from, double reach,
                          saltus_special *special, saltus_solution *at) {
    saltus_zero crossing = {.found = false};
    const double still = 0.2; /* relative to the orbit before */
    const double sharp = 1e-7;
    saltus_test by = special->kind == SALTUS_POINT_HB ? SALTUS_TEST_ONWARD : SALTUS_TEST_CROSSING;
    if (special->kind == SALTUS_POINT_BP || special->kind == SALTUS_POINT_HB)
        crossing = saltus_solution_crossing(o, by, from, special->ahead, reach, at);
    special->sharp = crossing.found;
    if (crossing.found)
        special->accuracy = crossing.accuracy + doubt_of(o, by, from, special->ahead, reach, at->value);
    else if (!saltus_solution_visit(o, from, special->ahead, at))
        special->lost = true;
    if (special->lost)
        return false;
    saltus_solution_survey(o, at, NULL);
    special->value = at->value;
    bool is_one = special->kind == SALTUS_POINT_NS ? crosses_circle(o, from, special->ahead, at)
                  : special->kind == SALTUS_POINT_HB
                      ? at->speed < still
                      : special->test == SALTUS_TEST_VALUE || !saltus_special_forgets(&at->survey);
    bool is_fold = special->kind == SALTUS_POINT_LP || special->kind == SALTUS_POINT_BP;
    const bool ends = is_fold && (joins(o, from, at, false, special) || joins(o, from, at, true, special));
    if (special->kind == SALTUS_POINT_LP && !ends && is_beside_join(o, from, at))
        is_one = false;
    /* The multipliers of an orbit that is its own mirror image are squares: rounding alone makes one -1. */
    if (special->kind == SALTUS_POINT_PD && o->system->mirror &&
        (at->sequence.omega > 0 || at->sequence.periods % 2) &&
        saltus_solution_part_distance(o, at, 1, NULL) < asymmetric)
        is_one = false;
    const bool by_determinant = is_fold || special->kind == SALTUS_POINT_PD;
    if (is_one && !ends && !crossing.found && special->test != SALTUS_TEST_VALUE)
        special->accuracy += saltus_special_doubt(o, special->test, at);
    const bool vague = at->sequence.omega > 0 || !(special->accuracy < sharp * o->family.unit[0]);
    /* Where the flow does not complete the orbit, only the place itself can tell. */
    const bool shown = at->survey.walked || isfinite(special->accuracy);
    if (by_determinant && !ends && vague)
        is_one = is_one && shown && !lacks_multiplier(at, special->kind);
    return is_one;
}

/* Halves of orbits that differ by less are alike. */
static const double closes = 1e-8;

bool saltus_special_halves(saltus_orbits *o, const saltus_solution *s) {
    return s->sequence.periods % 2 == 0 &&
           (s->sequence.count == 0 ? saltus_solution_part_distance(o, s, 2, NULL)
                                   : saltus_sequence_repeats(&s->sequence, 2, false)) < closes;
}

bool saltus_special_strays(saltus_orbits *o, const saltus_solution *here, const saltus_solution *next) {
    const double open = 1e-6;
    if (here->sequence.count == 0)
        return saltus_special_halves(o, next) && saltus_solution_part_distance(o, here, 2, NULL) > open;
    return (saltus_special_halves(o, next) && saltus_sequence_repeats(&here->sequence, 2, false) > open) ||
           (saltus_sequence_repeats(&next->sequence, 2, true) < closes &&
            saltus_sequence_repeats(&here->sequence, 2, true) > open);
}
