/* Where a branch of cycles ends.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/ending.h"

#include "branch/rest.h"
#include "orbit/held.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Along a cycle from a state up to `until`, in its period, of that a part. Without `rest`: the slowest point
 * so far to `slowest` (n), the speed there, in the state's scales, to *least; with `rest`, a state: the least
 * distance from it so far to *least. */
static saltus_status go_along(saltus_orbits *o, const double *from, double until, const double *rest,
                              double *slowest, double *least) {
    enum { parts = 8 };
    const saltus_time end = saltus_time_after((saltus_time){0, 0}, until);
    saltus_event event = {.kind = SALTUS_STEP};
    double state[SALTUS_STATE_MAX], field[SALTUS_STATE_MAX];
    const double *scale = saltus_system_scale(o->system);
    saltus_status status = saltus_flow_start(o->flow, 0, (saltus_time){0, 0}, from, NULL);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED) {
        status = saltus_flow_advance(o->flow, end, SALTUS_WATCH_STEP, &event, NULL);
        const double length = status == SALTUS_OK ? saltus_flow_step_length(o->flow, 0) : 0;
        for (int k = 0; k < parts && rest && status == SALTUS_OK; k++) {
            saltus_flow_dense(o->flow, 0, length * k / parts, state);
            *least = fmin(*least, saltus_system_distance(o->system, state, rest));
        }
        if (rest || status != SALTUS_OK)
            continue;
        double speed = 0; /* in the state's scales */
        saltus_flow_field(o->flow, 0, field);
        for (int i = 0; i < o->n; i++)
            speed = hypot(speed, field[i] / scale[i]);
        if (speed < *least) {
            *least = speed;
            saltus_flow_state(o->flow, 0, slowest);
        }
    }
    return status;
}

/* The same once around a cycle, from cut to cut: where errors grow the flow would leave it. */
static saltus_status go_around(saltus_orbits *o, const saltus_solution *s, const double *rest,
                               double *slowest, double *least) {
    const saltus_sequence *own = &s->sequence;
    double *states;
    *least = INFINITY;
    saltus_status status = saltus_solution_states_at(o, s, own, &states, NULL);
    if (status == SALTUS_OK)
        status = saltus_orbits_tune(o, s->parameter, own->omega / own->periods, NULL);
    for (int j = 0; j < own->cuts && status == SALTUS_OK; j++) {
        const double next = j + 1 < own->cuts ? own->cut[j + 1] : own->base + own->periods;
        status = go_along(o, states + j * o->n, (next - own->cut[j]) / own->periods, rest, slowest, least);
    }
    free(states);
    return status;
}

/* The equilibrium that a cycle passes most slowly. */
typedef struct passed {
    bool found;
    double distance; /* from the cycle, in the system's scales */
    bool saddle;
    unsigned contacts; /* faces that it is held against */
    double state[SALTUS_STATE_MAX];
    double complex growing, decaying, second; /* of a saddle: the exponents nearest to the imaginary axis, and
                                                 the next one beside that of them which is nearer to it */
} passed_rest;

/* Find the exponents from eigenvalues by decreasing real part. */
static void tell_exponents(const saltus_eigenvalue *rates, int count, passed_rest *passed) {
    int last = 0;
    while (last + 1 < count && rates[last + 1].re > 0)
        last++;
    passed->growing = rates[last].re + I * rates[last].im;
    passed->decaying = rates[last + 1].re + I * rates[last + 1].im;
    const bool grows = creal(passed->growing) < -creal(passed->decaying);
    const int next = grows ? last - 1 : last + 2;
    passed->second = next >= 0 && next < count ? rates[next].re + I * rates[next].im : INFINITY;
}

static passed_rest cycle_passes(saltus_orbits *o, const saltus_solution *s) {
    saltus_equilibrium_options how = saltus_equilibrium_defaults();
    saltus_equilibrium rest = {0};
    passed_rest passed = {.found = false};
    double slowest[SALTUS_STATE_MAX] = {0}, speed;
    saltus_status status = go_around(o, s, NULL, slowest, &speed);
    if (status == SALTUS_OK)
        status = saltus_equilibrium_find(o->system, slowest, &how, &rest, NULL);
    if (status == SALTUS_OK)
        status = go_around(o, s, rest.state, slowest, &passed.distance);
    if (saltus_orbits_noted(o, status) == SALTUS_OK) {
        passed.found = true;
        passed.contacts = rest.contacts;
        memcpy(passed.state, rest.state, (size_t)o->n * sizeof *rest.state);
        const saltus_growing counts = saltus_eigenvalues_growing(rest.eigenvalues, rest.eigenvalue_count);
        passed.saddle =
            counts.growing && counts.growing + counts.decaying == rest.eigenvalue_count && counts.decaying;
        if (passed.saddle)
            tell_exponents(rest.eigenvalues, rest.eigenvalue_count, &passed);
    }
    saltus_equilibrium_clear(&rest);
    return passed;
}

/* The derivative of a cycle's parameter, and of its period, along the curve. */
static double slope(const saltus_orbits *o, const saltus_solution *s, double *stretching) {
    const int period = s->at.unknowns - 2;
    *stretching = saltus_solution_period(s) * s->at.tangent[period] * o->shooting->scale[period];
    return saltus_solution_heading(s) / *stretching;
}

/* A homoclinic orbit towards which the period grows. */
typedef struct homoclinic {
    bool found;
    double parameter, accuracy; /* an unknown */
    int passages;               /* of saddles, in a period */
} homoclinic;

/* Where the period grows because a cycle stays ever longer near a saddle, its distance from that falls as
 * exp(-r T), 1/r being the sum of the inverse rates at which it is left and approached, and the parameter
 * goes to its limit as exp(-l T), for the exponents l beside that the imaginary axis. With several passages
 * in a period each has its share of T; the distance tells how many. From the slopes at two cycles follow the
 * coefficients of the two slowest terms, and the limit; and how well they lead from one to the other. */
static homoclinic seek_homoclinic(saltus_orbits *o, const saltus_solution *at, const passed_rest *passed,
                                  saltus_solution *back) {
    enum { halvings = 6, passages_most = 4 };
    const double whole = 0.3, apart = 1.01;
    const double out = creal(passed->growing), in = -creal(passed->decaying), rate = 1 / (1 / out + 1 / in);
    double complex one = out < in ? passed->growing : -passed->decaying, other = conj(one);
    double stretching, lead = 1 / creal(one), shorter = 0;
    homoclinic limit = {.found = false};
    const double after = slope(o, at, &stretching);
    passed_rest before = {.found = false};
    for (int k = 0; k < halvings && !before.found; k++, lead *= 0.5) {
        const bool there = saltus_solution_visit(o, at, -lead / stretching, back);
        shorter = there ? saltus_solution_period(at) - saltus_solution_period(back) : 0;
        if (shorter > 0.5 * lead && shorter < 2 * lead)
            before = cycle_passes(o, back);
    }
    if (!before.found || before.contacts != passed->contacts || !(before.distance > passed->distance))
        return limit;
    const double found = rate * shorter / log(before.distance / passed->distance);
    const bool turns = cimag(passed->growing) != 0 || cimag(passed->decaying) != 0;
    const int passages = (int)fmin(fmax(round(found), 1), passages_most);
    limit.found = fabs(found - passages) < whole || (turns && found > 0.5 && found < 2);
    if (cimag(one) == 0)
        other =
            fmax(apart * creal(one), fmin(fmin(fmax(out, in), fabs(creal(passed->second))), 2 * creal(one)));
    one /= passages;
    other /= passages;
    const double complex fall = cexp(-one * shorter), other_fall = cexp(-other * shorter);
    const double first = slope(o, back, &stretching);
    const double complex a = (first * other_fall - after) / (fall - other_fall), b = -first - a;
    const double rest = creal(a * fall / one + b * other_fall / other);
    const double way = creal(a * (1 - fall) / one + b * (1 - other_fall) / other);
    const double misses = fabs(way - (back->parameter[0] - at->parameter[0]));
    limit.parameter = at->parameter[0] - rest;
    limit.passages = passages;
    limit.accuracy = misses + 10 * o->options.flow.rtol;
    return limit;
}

/* The displacements and extra states of a rest, the first few of them. */
static void tell_place(const saltus_orbits *o, const double *state, char *text, size_t room) {
    enum { most = 3 };
    const double nothing = 1e-12, *scale = saltus_system_scale(o->system);
    const int dof = o->system->dof, count = dof + o->system->extra;
    int length = 0;
    for (int k = 0; k < count && k < most; k++) {
        const int i = k < dof ? k : dof + k;
        const double value = fabs(state[i]) < nothing * scale[i] ? 0 : state[i];
        length += snprintf(text + length, room - (size_t)length, "%s%.5g", k ? ", " : "", value);
    }
    if (count > most)
        snprintf(text + length, room - (size_t)length, ", ..");
}

bool saltus_cycle_tell_saddle(saltus_orbits *o, const saltus_solution *at, bool lost, const char *key,
                              saltus_solution *scratch, char *reason) {
    const double near = 1e-2, still = 1e-3;
    const double stretching = fabs(at->at.tangent[at->at.unknowns - 2]);
    char place[64], passages[48] = "";
    if (!(at->sequence.omega > 0 && fabs(saltus_solution_heading(at)) < still * stretching))
        return false;
    const passed_rest passed = cycle_passes(o, at);
    const bool meets = passed.found && passed.distance < near && passed.saddle;
    const homoclinic limit = meets ? seek_homoclinic(o, at, &passed, scratch) : (homoclinic){.found = false};
    if (!limit.found && !lost)
        return false;
    const double unit = o->family.unit[0];
    tell_place(o, passed.state, place, sizeof place);
    if (limit.passages > 1)
        snprintf(passages, sizeof passages, " or heteroclinic, %d saddles a period", limit.passages);
    if (limit.found)
        snprintf(reason, SALTUS_REASON_MAX,
                 "homoclinic%s: the period grows without bound, here %.6g at a distance of %.2g from a "
                 "saddle%s (%.60s; exponents %.4g, %.4g), at %.31s = %.15g +- %.1g",
                 passages, saltus_solution_period(at), passed.distance, passed.contacts ? " on a stop" : "",
                 place, creal(passed.growing), creal(passed.decaying), key,
                 o->origin + unit * limit.parameter, unit * limit.accuracy);
    else if (meets)
        snprintf(reason, SALTUS_REASON_MAX,
                 "the parameter stands still while the period changes, here %.6g at a distance of %.2g from "
                 "a saddle",
                 saltus_solution_period(at), passed.distance);
    else
        snprintf(reason, SALTUS_REASON_MAX,
                 "the parameter stands still while the period changes, here %.6g; no saddle is near",
                 saltus_solution_period(at));
    return true;
}

/* The fold of equilibria near the slowest point of a cycle. At the cycle's parameter there are none. */
static bool seek_birth(saltus_orbits *o, const saltus_solution *s, double *parameter) {
    saltus_rests r = {.family = o->family, .origin = {o->origin}, .special = {.kind = SALTUS_POINT_LP}};
    const saltus_equations *e = &r.equations;
    saltus_curve_point at = {.unknowns = 0};
    double slowest[SALTUS_STATE_MAX] = {0}, speed, along = 0;
    bool found = false;
    saltus_status status = go_around(o, s, NULL, slowest, &speed);
    if (status == SALTUS_OK)
        status = saltus_flow_start(o->flow, 0, (saltus_time){0, 0}, slowest, NULL);
    if (status == SALTUS_OK && !saltus_flow_contacts(o->flow, 0)) {
        status = saltus_rests_open(&r, NULL);
        if (status == SALTUS_OK)
            status = saltus_rests_begin(&r, 0, slowest, s->parameter, &at, NULL);
        if (status == SALTUS_OK)
            status = saltus_rests_null_vectors(&r, at.u, r.special.right, r.special.left, NULL);
        if (status == SALTUS_OK)
            status = saltus_newton(&r.equations, at.u, NULL, NULL, true, &at.iterations, NULL);
        for (int i = 0; i < r.size && status == SALTUS_OK; i++)
            along += r.special.left[i] * e->jacobian[i * e->unknowns + r.size];
        if (status == SALTUS_OK) {
            /* The second derivative of the parameter along the curve of equilibria has the sign of the
             * special equation's derivative along the null vector, over that of the others by the parameter.
             */
            const double bend =
                saltus_dot(e->jacobian + r.size * e->unknowns, r.special.right, r.size) * along;
            *parameter = at.u[r.size];
            found = bend * (s->parameter[0] - *parameter) < 0;
        }
        o->starved |= r.starved;
        saltus_curve_clear(&at);
        saltus_rests_close(&r);
    }
    saltus_orbits_noted(o, status);
    return found;
}

bool saltus_cycle_tell_birth(saltus_orbits *o, const saltus_solution *here, const saltus_solution *next,
                             const double range[2], const char *key, char *reason) {
    const double little = 1e-3, alike = 0.1, longer = 0.3;
    if (!(next->sequence.omega > 0) || !(here->sequence.omega > 0))
        return false;
    const double period = saltus_solution_period(next), grown = log(period / saltus_solution_period(here)),
                 way = next->parameter[0] - here->parameter[0],
                 left = way * exp(-2 * grown) / -expm1(-2 * grown);
    /* Test only now and then: whenever the period has grown by a certain factor. */
    if (!(grown > 0 && fabs(left) < little) ||
        floor(log(period) / longer) == floor((log(period) - grown) / longer))
        return false;
    double parameter;
    const bool ends = seek_birth(o, next, &parameter) && parameter >= range[0] && parameter <= range[1] &&
                      fabs(parameter - next->parameter[0] - left) < alike * fabs(left);
    if (ends)
        snprintf(
            reason, SALTUS_REASON_MAX,
            "two equilibria are born on the orbit at %s = %.12g: the period grows without bound, here %.6g",
            key, o->origin + o->family.unit[0] * parameter, period);
    return ends;
}

void saltus_cycle_tell_shrinking(saltus_orbits *o, const saltus_solution *at, char *reason) {
    const passed_rest passed = cycle_passes(o, at);
    int length = snprintf(reason, SALTUS_REASON_MAX, "the orbit shrinks to an equilibrium: period %.9g",
                          saltus_solution_period(at));
    if (passed.found)
        snprintf(reason + length, SALTUS_REASON_MAX - (size_t)length, ", distance %.2g", passed.distance);
}

/* How far rounding may have moved the parameter of the Hopf point at u that Newton's method has just found:
 * that of the equations, and that of the real part, from its scatter beside it. */
static double moved_by_rounding(saltus_rests *r, double *u) {
    const double apart = 1e-6, place = u[r->size];
    const saltus_equations *e = &r->equations;
    double value[5], square, part[SALTUS_REST_UNKNOWNS_MAX] = {0}, moved = 0;
    for (int k = 0; k < 5; k++) {
        u[r->size] = place + (k - 2) * apart;
        value[k] = saltus_rests_pair(r, u, r->special.square, &square);
    }
    u[r->size] = place;
    const double bend = value[0] - 4 * value[1] + 6 * value[2] - 4 * value[3] + value[4];
    part[r->size] = 1;
    saltus_dense_resolve(&r->equations.lu, true, 1, part);
    for (int i = 0; i < r->size; i++)
        moved += fabs(part[i]) * (fabs(e->residual[i]) + DBL_EPSILON * saltus_length(u, e->unknowns));
    return moved + fabs(part[r->size]) * (fabs(bend) + fabs(value[2])) / r->rate_scale;
}

/* Find the Hopf point from the equilibrium and the eigenvalues nearest to the cycle's state and frequency. */
static saltus_shrunk cycle_shrinks(saltus_orbits *o, const saltus_solution *s) {
    const double omega = s->sequence.omega / s->sequence.periods, sharp = 1e-9;
    saltus_rests r = {.family = o->family,
                      .origin = {o->origin},
                      .special = {.kind = SALTUS_POINT_HB, .square = omega * omega}};
    saltus_rest rest = {.rate_count = 0};
    saltus_shrunk hopf = {.found = false};
    double square;
    saltus_status status = saltus_rests_open(&r, NULL);
    if (status == SALTUS_OK)
        status = saltus_rests_begin(&r, s->sequence.contacts, s->state, s->parameter, &rest.at, NULL);
    if (status == SALTUS_OK)
        status = saltus_newton(&r.equations, rest.at.u, NULL, NULL, true, &rest.at.iterations, NULL);
    if (status == SALTUS_OK) {
        hopf.accuracy = moved_by_rounding(&r, rest.at.u);
        saltus_rests_pair(&r, rest.at.u, r.special.square, &square);
        status = saltus_rest_see(&r, &rest, NULL);
    }
    if (status == SALTUS_OK) {
        hopf.found = hopf.accuracy < sharp && square > 0;
        hopf.parameter = rest.parameter[0];
        hopf.omega = sqrt(square);
        hopf.rate_count = rest.rate_count;
        memcpy(hopf.state, rest.state, sizeof hopf.state);
        memcpy(hopf.rates, rest.rates, sizeof hopf.rates);
    }
    o->starved |= r.starved || status == SALTUS_NO_MEMORY;
    saltus_rest_clear(&rest);
    saltus_rests_close(&r);
    return hopf;
}

bool saltus_cycle_seek_hopf(saltus_orbits *o, const saltus_solution *here, const saltus_solution *next,
                            saltus_solution *at, saltus_solution *scratch, saltus_hopf_ahead *hopf) {
    const double close = 1e-6, alike = 1e-3, slack = 10;
    saltus_special *special = &hopf->special;
    saltus_shrunk *shrunk = &hopf->shrunk;
    const bool rests = saltus_solution_rests(next, here);
    hopf->found = !rests && saltus_special_hopf(o, here, next, special, scratch);
    hopf->is_one = hopf->found && saltus_special_visit(o, here, next->at.ahead, special, at);
    if (!hopf->is_one)
        return rests;
    const saltus_solution *near = special->sharp ? at : here;
    *shrunk = cycle_shrinks(o, at);
    const double most =
        special->sharp ? slack * special->accuracy / o->family.unit[0] + close : next->at.ahead;
    shrunk->found = shrunk->found && fabs(shrunk->parameter - near->parameter[0]) < most &&
                    fabs(log(shrunk->omega * here->sequence.periods / near->sequence.omega)) < alike;
    return here->sequence.count == 0 && !(special->sharp && shrunk->found);
}

bool saltus_cycle_folds(saltus_orbits *o, const saltus_solution *here, const saltus_special *fold,
                        const saltus_solution *at) {
    const double small = 0.2; /* relative to the orbit before */
    if (fold->kind != SALTUS_POINT_LP || !(at->sequence.omega > 0) || at->sequence.count > 0 ||
        at->speed >= small * here->speed)
        return true;
    const saltus_shrunk shrunk = cycle_shrinks(o, at);
    return !shrunk.found || o->family.unit[0] * fabs(shrunk.parameter - at->parameter[0]) > fold->accuracy;
}

/* Multipliers from the eigenvalues at a Hopf point; the imaginary pair gives the trivial one and a 1. */
static void tell_multipliers(const saltus_shrunk *hopf, double period, saltus_survey *survey) {
    int count = 0, pair = 0;
    for (int k = 0; k < hopf->rate_count; k++)
        if (fabs(hopf->rates[k].im - hopf->omega) < fabs(hopf->rates[pair].im - hopf->omega))
            pair = k;
    for (int k = 0; k < hopf->rate_count; k++) {
        const saltus_eigenvalue rate = hopf->rates[k];
        const double log_modulus = rate.re * period, modulus = exp(log_modulus);
        if (k == pair)
            survey->multipliers[count++] = (saltus_multiplier){1, 0, 0};
        else if (k != pair + 1)
            survey->multipliers[count++] = (saltus_multiplier){modulus * cos(rate.im * period),
                                                               modulus * sin(rate.im * period), log_modulus};
    }
    while (count < survey->multiplier_count)
        survey->multipliers[count++] = (saltus_multiplier){0, 0, -INFINITY};
    survey->multiplier_count = count;
    survey->trivial = 1;
    survey->log_volume = 0;
    for (int k = 0; k < count; k++)
        survey->log_volume += survey->multipliers[k].log_modulus;
    survey->unstable = saltus_multipliers_unstable(survey->multipliers, count);
}

bool saltus_cycle_shrink(saltus_orbits *o, const saltus_shrunk *hopf, saltus_solution *out) {
    saltus_sequence sequence = out->sequence;
    sequence.omega = hopf->omega * sequence.periods;
    saltus_status status = saltus_shooting_shape(o->shooting, &sequence, NULL);
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(o->shooting, &hopf->parameter, hopf->state, 1, out->at.u, NULL);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(o->equations, out->at.u, NULL);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, out, NULL);
    if (saltus_orbits_noted(o, status) == SALTUS_OK)
        status = saltus_solution_survey(o, out, NULL);
    if (status == SALTUS_OK && out->survey.walked)
        tell_multipliers(hopf, 2 * M_PI / hopf->omega, &out->survey);
    return status == SALTUS_OK;
}

bool saltus_cycle_of_family(const saltus_solution *s) {
    const double close = 1e-6;
    bool one = s->sequence.omega == 0 || !s->survey.walked;
    for (int k = 0; k < s->survey.multiplier_count && !one; k++)
        one = hypot(s->survey.multipliers[k].re - 1, s->survey.multipliers[k].im) < close;
    return one;
}

/* The speed of an orbit's impacts, scaled, if all two or more are equally fast; otherwise NAN. */
static double common_speed(const saltus_solution *s) {
    const double alike = 1e-6;
    double least, most;
    const int count = saltus_solution_speed_range(s, &least, &most);
    return count > 1 && count == s->sequence.count && most - least < alike ? 0.5 * (least + most) : NAN;
}

/* Whether all impacts of a cycle of a planar flow lose their speed at once on the step ahead. */
static bool fades(const saltus_orbits *o, const saltus_solution *here, const saltus_solution *next) {
    const double slow = 0.3, share = 0.5;
    const double before = common_speed(here), after = common_speed(next);
    const double way = (next->parameter[0] - here->parameter[0]) * saltus_solution_heading(here);
    return o->n == 2 && here->sequence.omega > 0 && !here->sequence.contacts && !here->sequence.driven &&
           before > 0 && before < slow && !(after > share * before && way > 0);
}

saltus_zero saltus_cycle_fades(saltus_orbits *o, const saltus_solution *here, const saltus_solution *next,
                               const double range[2], saltus_solution *at, saltus_solution *bare,
                               saltus_solution *scratch) {
    static const double reach[] = {1e-4, 1e-3, 3e-3, 1e-2, 3e-2};
    enum { reaches = sizeof reach / sizeof reach[0] };
    const double heading = saltus_solution_heading(here);
    saltus_zero zero = {.found = false};
    saltus_sequence without = here->sequence;
    without.count = 0;
    if (!fades(o, here, next))
        return zero;
    for (int k = 0; k < reaches && !zero.found; k++) {
        const double parameter = here->parameter[0] + copysign(reach[k], heading);
        if (parameter < range[0] || parameter > range[1] ||
            saltus_solution_place(o, &without, &parameter, here->state, true, bare, NULL) != SALTUS_OK ||
            bare->worst.value > 0 || saltus_solution_survey(o, bare, NULL) != SALTUS_OK ||
            !bare->survey.follows)
            continue;
        saltus_solution_head(bare, -heading);
        const double back = reach[k] / fabs(saltus_solution_heading(bare));
        if (saltus_solution_visit(o, bare, back, scratch) && scratch->worst.value > 0)
            zero = saltus_solution_zero(o, SALTUS_TEST_BREACH, 0, bare, scratch, at);
    }
    if (!zero.found)
        saltus_orbits_reshape(o, here);
    return zero;
}
