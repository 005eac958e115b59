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

/* Whether a step begins at grazing, with an impact of zero speed. If multipliers pass through grazing
 * unchanged, as in planar flows, the determinants there are only rounding. */
static bool begins_at_grazing(const saltus_solution *from) {
    const double still = 1e-9;
    for (int k = 0; k < from->breach_count; k++)
        if (from->breaches[k].kind == SALTUS_BREACH_SPEED && fabs(from->breaches[k].value) < still)
            return true;
    return false;
}

/* Locate a special point between `from` and `to` by its test and insert it in order of arclength. */
static int add(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to,
               saltus_point_kind kind, saltus_test test, double target, saltus_special *specials, int count,
               saltus_solution *scratch) {
    double near = saltus_test_value(test, target, from, from);
    double far = saltus_test_value(test, target, to, from);
    saltus_special found = {.kind = kind, .test = test, .target = target, .ahead = to->at.ahead};
    const double rounding = 1e-8;
    if (!saltus_test_crosses(near, far) ||
        (test != SALTUS_TEST_VALUE && fabs(near) < rounding * fabs(far) && begins_at_grazing(from)))
        return count;
    if (far != 0) {
        saltus_zero zero = saltus_solution_zero(o, test, target, from, to, scratch);
        found.ahead = zero.ahead;
        found.accuracy = zero.accuracy;
        if (!zero.found && kind != SALTUS_POINT_BP && kind != SALTUS_POINT_HB)
            return count;
        if (!zero.found) /* singular: interpolated later */
            found.ahead = to->at.ahead * near / (near - far);
    }
    return saltus_special_insert(found, specials, count);
}

/* Add the pairs on the unit circle. If a single multiplier crosses the circle in the same step, a pair of
 * real ones may pass the product 1 as well, so that the test has its old sign at the end of the step.
 * Therefore the test is evaluated at folds and flips too. */
static int add_pairs(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to,
                     saltus_special *specials, int count, saltus_solution *scratch) {
    double place[4] = {0}, value[4] = {from->survey.pair};
    saltus_message ignored;
    int places = 1;
    for (int k = 0; k < count && places < 3; k++)
        if (specials[k].kind != SALTUS_POINT_BP && specials[k].ahead > 0 &&
            specials[k].ahead < to->at.ahead &&
            saltus_solution_visit(o, from, specials[k].ahead, scratch, &ignored) == SALTUS_OK &&
            saltus_solution_survey(o, scratch, &ignored) == SALTUS_OK) {
            place[places] = specials[k].ahead;
            value[places++] = scratch->survey.pair;
        }
    place[places] = to->at.ahead;
    value[places++] = to->survey.pair;
    for (int k = 0; k + 1 < places; k++) {
        if (!saltus_test_crosses(value[k], value[k + 1]))
            continue;
        saltus_zero zero = {.found = value[k + 1] == 0, .ahead = place[k + 1]};
        if (!zero.found)
            zero = saltus_solution_zero_between(o, SALTUS_TEST_PAIR, 0, from, &place[k], &value[k], scratch);
        if (zero.found)
            count = saltus_special_insert((saltus_special){.kind = SALTUS_POINT_NS,
                                                           .test = SALTUS_TEST_PAIR,
                                                           .ahead = zero.ahead,
                                                           .accuracy = zero.accuracy},
                                          specials, count);
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
    return from->sequence.omega > 0 &&
           add(o, from, to, SALTUS_POINT_HB, SALTUS_TEST_ONWARD, 0, special, 0, scratch) > 0;
}

int saltus_special_find(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to, bool fresh,
                        const saltus_special *hopf, const double *targets, const saltus_point_kind *kinds,
                        int target_count, saltus_special *specials, saltus_solution *scratch) {
    static const struct {
        saltus_point_kind kind;
        saltus_test test;
    } tests[] = {{SALTUS_POINT_LP, SALTUS_TEST_FOLD},
                 {SALTUS_POINT_PD, SALTUS_TEST_FLIP},
                 {SALTUS_POINT_BP, SALTUS_TEST_CROSSING}};
    int count = 0;
    for (size_t k = 0; k < sizeof tests / sizeof tests[0] && !fresh; k++)
        count = add(o, from, to, tests[k].kind, tests[k].test, 0, specials, count, scratch);
    if (!fresh)
        count = add_pairs(o, from, to, specials, count, scratch);
    for (int k = 0; k < target_count; k++)
        count = add(o, from, to, kinds[k], SALTUS_TEST_VALUE, targets[k], specials, count, scratch);
    if (hopf && hopf->ahead <= to->at.ahead)
        count = saltus_special_insert(*hopf, specials, count);
    return end_at_equilibrium(specials, count, to->at.ahead);
}

/* Distance in arclength between points that show how a test varies near its zero. */
static const double apart = 1e-6;

/* The value of a test, and the parameter, at this distance ahead of `at`. */
static bool test_beside(saltus_orbits *o, saltus_test test, const saltus_solution *at, double ahead,
                        saltus_solution *scratch, double *parameter, double *value) {
    saltus_message ignored;
    saltus_status status = saltus_solution_visit(o, at, ahead, scratch, &ignored);
    if (status == SALTUS_OK && test == SALTUS_TEST_PAIR)
        status = saltus_solution_survey(o, scratch, &ignored);
    *parameter = scratch->parameter[0];
    *value = status == SALTUS_OK ? saltus_test_value(test, 0, scratch, at) : NAN;
    return saltus_orbits_noted(o, status) == SALTUS_OK && isfinite(*value);
}

/* The parameter where a test is zero, by a line through three points around the one at distance `middle`
 * ahead of `at`, and the scatter there of points that should lie on the line. */
static bool zero_around(saltus_orbits *o, saltus_test test, const saltus_solution *at, double middle,
                        saltus_solution *scratch, double *parameter, double *scatter) {
    enum { close_points = 4 };
    const double close = 1e-3 * apart;
    double place[3], value[3], mean = 0;
    for (int k = 0; k < 3; k++) {
        if (!test_beside(o, test, at, middle + (k - 1) * apart, scratch, &place[k], &value[k]))
            return false;
        mean += value[k] / 3;
    }
    double rise = value[2] - value[0], slope = rise != 0 ? (place[2] - place[0]) / rise : 0;
    *parameter = place[1] - slope * mean;
    *scatter = middle == 0 ? fabs(slope * value[1]) : 0;
    for (int k = 0; k < close_points; k++) {
        double ahead = (k < 2 ? k - 2 : k - 1) * close, here, there;
        if (!test_beside(o, test, at, middle + ahead, scratch, &here, &there))
            return false;
        double share = ahead / (2 * apart);
        *scatter = fmax(*scatter, fabs(here - place[1] - share * (place[2] - place[0])) +
                                      fabs(slope * (there - value[1] - share * rise)));
    }
    return isfinite(*parameter);
}

/* Two flows, or a few points, may by chance differ by less than their errors. */
static const double cautious = 4;

/* Orbits of a flow of another tolerance, at a solution of the shooting's sequence. Close both in any case. */
static saltus_status open_other(const saltus_orbits *o, const saltus_solution *at, saltus_orbits *other,
                                saltus_solution *there) {
    saltus_message ignored;
    *other = (saltus_orbits){.family = o->family, .origin = o->origin, .options = o->options};
    *there = (saltus_solution){.value = 0};
    double *rtol = &other->options.flow.rtol;
    *rtol = *rtol < 1e-4 ? 10 * *rtol : *rtol / 10;
    saltus_status status = saltus_orbits_open(other, &ignored);
    if (status == SALTUS_OK)
        status =
            saltus_solution_place(other, &at->sequence, at->parameter, at->state, false, there, &ignored);
    if (status == SALTUS_OK && there->at.unknowns != at->at.unknowns)
        status = SALTUS_NO_CONVERGENCE;
    if (status != SALTUS_OK)
        return status;
    size_t size = (size_t)at->at.unknowns * sizeof *at->at.u;
    memcpy(there->at.u, at->at.u, size);
    memcpy(there->at.tangent, at->at.tangent, size);
    /* Beside a crossing a less accurate prediction might lead to the other curve. */
    there->at.bent = at->at.bent;
    if (at->at.bent)
        memcpy(there->at.bend, at->at.bend, 2 * size);
    there->at.crossing = at->at.crossing;
    there->flip = at->flip;
    return status;
}

double saltus_special_doubt(saltus_orbits *o, saltus_test test, const saltus_solution *at) {
    saltus_orbits other;
    saltus_solution there, scratch = {.value = 0};
    double here, beyond, scatter[2], doubt = INFINITY;
    saltus_status status = open_other(o, at, &other, &there);
    /* At the end of a domain only one side works. */
    for (int side = 0; side < 3 && isinf(doubt) && status == SALTUS_OK; side++) {
        double middle = (side == 2 ? -1 : side) * apart;
        if (zero_around(o, test, at, middle, &scratch, &here, &scatter[0]) &&
            zero_around(&other, test, &there, middle, &scratch, &beyond, &scatter[1]))
            doubt = cautious * o->family.unit[0] * (fabs(beyond - here) + fmax(scatter[0], scatter[1]));
    }
    saltus_orbits_noted(o, other.starved ? SALTUS_NO_MEMORY : status);
    saltus_solution_clear(&there);
    saltus_solution_clear(&scratch);
    saltus_orbits_close(&other);
    return doubt;
}

/* The same for a crossing of curves near `ahead` of `from`, found at parameter `value`. */
static double doubt_of_crossing(saltus_orbits *o, saltus_test by, const saltus_solution *from, double ahead,
                                double reach, double value) {
    saltus_orbits other;
    saltus_solution there, scratch = {.value = 0};
    double doubt = INFINITY;
    saltus_status status = open_other(o, from, &other, &there);
    if (status == SALTUS_OK) {
        there.onward = from->onward;
        if (saltus_solution_crossing(&other, by, &there, ahead, reach, &scratch).found)
            doubt = cautious * fabs(scratch.value - value);
    }
    saltus_orbits_noted(o, other.starved ? SALTUS_NO_MEMORY : status);
    saltus_solution_clear(&there);
    saltus_solution_clear(&scratch);
    saltus_orbits_close(&other);
    return doubt;
}

saltus_status saltus_special_between(saltus_orbits *o, saltus_orbits *own, const saltus_solution *at,
                                     bool mirrored, saltus_solution *between) {
    const double *scale = saltus_shooting_scale(o->shooting), half = 0.5 * at->sequence.periods;
    const int marks = at->sequence.count / 2;
    double state[SALTUS_STATE_MAX], apart[SALTUS_STATE_MAX], singular;
    int order[SALTUS_MARKS_MAX];
    saltus_sequence sequence = at->sequence;
    saltus_message ignored;
    if (!isfinite(saltus_solution_part_distance(o, at, mirrored ? 1 : 2, apart)))
        return SALTUS_NO_CONVERGENCE;
    for (int i = 0; i < o->n; i++)
        state[i] = at->state[i] + (mirrored ? -0.5 : 0.5) * apart[i] * scale[i];
    for (int k = 0; k < marks; k++) {
        const double later = sequence.mark[k + marks].time - sequence.mark[k].time - half;
        sequence.mark[k].time += 0.5 * later;
        sequence.mark[k + marks].time -= 0.5 * later;
    }
    sequence.cuts = 1;
    if (!mirrored) {
        sequence.periods /= 2;
        sequence.count = marks;
    }
    saltus_status status =
        saltus_solution_place(own, &sequence, at->parameter, state, !mirrored, between, &ignored);
    if (!mirrored || status != SALTUS_OK)
        return status;
    /* At the place itself both curves' tangents are possible. */
    double *along = calloc((size_t)between->at.unknowns, sizeof *along);
    if (!along)
        return SALTUS_NO_MEMORY;
    for (int k = 0; k < sequence.count; k++)
        order[k] = k;
    saltus_sequence_carry(&at->sequence, at->at.tangent, &sequence, order, o->n, 1, along);
    status =
        saltus_curve_leaving(own->equations, between->at.u, along, between->at.tangent, &singular, &ignored);
    free(along);
    return status;
}

/* Where the orbits between the halves of those near `at` have a zero of their own test. This locates the
 * place better than the equations of the branch that joins them there, which are singular. */
static saltus_zero zero_between_halves(saltus_orbits *o, const saltus_solution *at, bool mirrored,
                                       double *value) {
    static const double reach[] = {1e-2, 1e-3, 1e-4};
    /* Near the place a residual moves orbits by many times its size. */
    const double near = 1e-3, tolerance = 1e-13;
    saltus_orbits own = {.family = o->family, .origin = o->origin, .options = o->options};
    saltus_solution between = {.value = 0}, side[2] = {{.value = 0}, {.value = 0}}, place = {.value = 0};
    saltus_zero zero = {.found = false};
    saltus_message ignored;
    own.options.tolerance = fmin(own.options.tolerance, tolerance);
    saltus_status status = saltus_orbits_open(&own, &ignored);
    if (status == SALTUS_OK)
        status = saltus_special_between(o, &own, at, mirrored, &between);
    for (int k = 0; k < 3 && status == SALTUS_OK && !zero.found; k++) {
        if (mirrored) {
            zero = saltus_solution_crossing(&own, SALTUS_TEST_CROSSING, &between, 0, reach[k], &place);
        } else if (saltus_solution_visit(&own, &between, -reach[k], &side[0], &ignored) == SALTUS_OK &&
                   saltus_solution_visit(&own, &side[0], 2 * reach[k], &side[1], &ignored) == SALTUS_OK &&
                   saltus_test_crosses(saltus_test_value(SALTUS_TEST_FLIP, 0, &side[0], &side[0]),
                                       saltus_test_value(SALTUS_TEST_FLIP, 0, &side[1], &side[0]))) {
            zero = saltus_solution_zero(&own, SALTUS_TEST_FLIP, 0, &side[0], &side[1], &place);
        }
        zero.found = zero.found && fabs(place.parameter[0] - at->parameter[0]) < near;
        if (zero.found)
            zero.accuracy +=
                mirrored ? doubt_of_crossing(&own, SALTUS_TEST_CROSSING, &between, 0, reach[k], place.value)
                         : saltus_special_doubt(&own, SALTUS_TEST_FLIP, &place);
    }
    *value = place.value;
    saltus_orbits_noted(o, own.starved ? SALTUS_NO_MEMORY : status);
    saltus_solution_clear(&between);
    for (int k = 0; k < 2; k++)
        saltus_solution_clear(&side[k]);
    saltus_solution_clear(&place);
    saltus_orbits_close(&own);
    return zero;
}

/* Whether the branch joins that of half the period at `at`. */
static bool joins_half(saltus_orbits *o, const saltus_solution *at, saltus_special *special) {
    const double apart = saltus_solution_half_distance(o, at, false), unit = o->family.unit[0];
    double value;
    saltus_zero flip = {.found = false};
    if (apart < 2e-2 && at->sequence.count % 2 == 0)
        flip = zero_between_halves(o, at, false, &value);
    if (!(apart < 1e-4 || (flip.found && fabs(value - at->value) < 1e-6 * unit)))
        return false;
    special->kind = SALTUS_POINT_PD;
    special->end = "joins the orbits of half the period";
    if (flip.found) {
        special->value = value;
        special->accuracy = flip.accuracy;
    }
    return true;
}

/* Whether at `at`, a fold, asymmetric orbits join the branch of orbits that are their own mirror images. */
static bool joins_image(saltus_orbits *o, const saltus_solution *from, const saltus_solution *at,
                        saltus_special *special) {
    bool shift;
    if (!saltus_system_mirror_symmetric(o->system, &shift))
        return false;
    double apart = saltus_solution_half_distance(o, at, true), value;
    double before = saltus_solution_half_distance(o, from, true);
    if (!(apart < 1e-3 && apart < 0.05 * before && before > asymmetric))
        return false;
    special->kind = SALTUS_POINT_BP;
    special->end = "joins the orbits that are their own mirror images";
    const saltus_zero crossing = zero_between_halves(o, at, true, &value);
    if (crossing.found) {
        special->value = value;
        special->accuracy = crossing.accuracy;
    }
    return true;
}

/* Whether all multipliers are zero: such orbits neither fold nor flip, but where one of their impacts was
 * just born the tests are zero to rounding. */
static bool forgets_all(const saltus_survey *survey) {
    bool all = survey->walked;
    for (int k = 0; k < survey->multiplier_count; k++)
        all = all && survey->multipliers[k].log_modulus == -INFINITY;
    return all && survey->multiplier_count > 0;
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

saltus_status saltus_special_visit(saltus_orbits *o, const saltus_solution *from, double reach,
                                   saltus_special *special, saltus_solution *at, bool *is_one,
                                   saltus_message *message) {
    saltus_message ignored;
    saltus_zero crossing = {.found = false};
    const double still = 0.2; /* relative to the orbit before */
    const double sharp = 1e-7;
    *is_one = false;
    saltus_test by = special->kind == SALTUS_POINT_HB ? SALTUS_TEST_ONWARD : SALTUS_TEST_CROSSING;
    if (special->kind == SALTUS_POINT_BP || special->kind == SALTUS_POINT_HB)
        crossing = saltus_solution_crossing(o, by, from, special->ahead, reach, at);
    special->sharp = crossing.found;
    if (crossing.found)
        special->accuracy =
            crossing.accuracy + doubt_of_crossing(o, by, from, special->ahead, reach, at->value);
    else if (saltus_solution_visit(o, from, special->ahead, at, &ignored) != SALTUS_OK)
        return SALTUS_OK;
    saltus_status status = saltus_solution_survey(o, at, message);
    if (status != SALTUS_OK)
        return status;
    special->value = at->value;
    *is_one = special->kind == SALTUS_POINT_NS ? saltus_pair_on_circle(&at->survey)
              : special->kind == SALTUS_POINT_HB
                  ? at->speed < still
                  : special->test == SALTUS_TEST_VALUE || !forgets_all(&at->survey);
    bool is_fold = special->kind == SALTUS_POINT_LP || special->kind == SALTUS_POINT_BP;
    bool joins = is_fold && (joins_half(o, at, special) || joins_image(o, from, at, special));
    const bool by_determinant = is_fold || special->kind == SALTUS_POINT_PD;
    if (*is_one && !joins && !crossing.found && special->test != SALTUS_TEST_VALUE)
        special->accuracy += saltus_special_doubt(o, special->test, at);
    const bool vague = at->sequence.omega > 0 || !(special->accuracy < sharp * o->family.unit[0]);
    if (by_determinant && !joins && vague)
        *is_one = *is_one && !lacks_multiplier(at, special->kind);
    return status;
}

bool saltus_special_strays(saltus_orbits *o, const saltus_solution *here, const saltus_solution *next) {
    const double closes = 1e-8, open = 1e-6;
    bool even = here->sequence.periods % 2 == 0;
    if (here->sequence.count == 0)
        return even && saltus_solution_half_distance(o, next, false) < closes &&
               saltus_solution_half_distance(o, here, false) > open;
    for (int mirrored = even ? 0 : 1; mirrored < 2; mirrored++)
        if (saltus_sequence_repeats(&here->sequence, 2, mirrored) > open &&
            saltus_sequence_repeats(&next->sequence, 2, mirrored) < closes)
            return true;
    return false;
}
