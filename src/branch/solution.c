/* The curve of periodic orbits of one sequence of events.
 *
 * Zeros of tests are bracketed in arclength along the step and found by Brent's method; each evaluation is a
 * point of the curve, solved to rounding. The event-driven flow has the last word: whether it meets the
 * prescribed events.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/solution.h"

#include "branch/sequence.h"
#include "orbit/poincare.h"
#include "orbit/sequence.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The most segments per period for the multipliers. With ten modes and more the segments would take most of
 * the time of a point, only to resolve multipliers below 1e-40, which do not matter for stability. */
enum { segments_most = 24 };

saltus_status saltus_orbits_open(saltus_orbits *o, saltus_message *message) {
    saltus_status status = saltus_system_new(&o->family.spec, &o->system, message);
    if (status != SALTUS_OK)
        return status;
    o->n = saltus_system_dimension(o->system);
    o->solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    if (!o->solver)
        return saltus_branch_no_memory(message);
    status = saltus_flow_single(o->system, 0, &o->options.flow, &o->flow, message);
    o->cocycle.most = segments_most;
    if (status == SALTUS_OK)
        status = saltus_cocycle_flow(&o->cocycle, o->system, 1, &o->options.flow, &o->tangent, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_new(&o->family, &o->options, &o->shooting, message);
    if (status != SALTUS_OK)
        return status;
    o->equations = &o->shooting->equations;
    o->collects = saltus_cocycle_takes(&o->cocycle, o->system, 1, &o->options.flow);
    return status;
}

saltus_status saltus_orbits_open_other(const saltus_orbits *o, saltus_orbits *other) {
    *other = (saltus_orbits){.family = o->family, .origin = o->origin, .options = o->options};
    double *rtol = &other->options.flow.rtol;
    *rtol = *rtol < 1e-4 ? 10 * *rtol : *rtol / 10;
    return saltus_orbits_open(other, NULL);
}

void saltus_orbits_close(saltus_orbits *o) {
    saltus_shooting_free(o->shooting);
    saltus_flow_free(o->flow);
    saltus_flow_free(o->tangent);
    saltus_cocycle_close(&o->cocycle);
    saltus_system_free(o->system);
    if (o->solver)
        gsl_root_fsolver_free(o->solver);
    *o = (saltus_orbits){.n = 0};
}

saltus_status saltus_orbits_noted(saltus_orbits *o, saltus_status status) {
    o->starved |= status == SALTUS_NO_MEMORY;
    return status;
}

double saltus_orbits_border(double origin, double unit, double border, int side) {
    double found = (border - origin) / unit;
    /* At most one rounding separates the quotient from the number that gives the border back. */
    for (int way = -1; way <= 1; way += 2) {
        double next = nextafter(found, way * INFINITY);
        if (origin + unit * found != border && origin + unit * next == border)
            found = next;
    }
    while (side ? origin + unit * found > border : origin + unit * found < border)
        found = nextafter(found, side ? -INFINITY : INFINITY);
    return found;
}

saltus_status saltus_orbits_tune(saltus_orbits *o, const double *parameters, double omega,
                                 saltus_message *message) {
    saltus_spec spec = saltus_family_spec(&o->family, parameters, omega);
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(&spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_flow_retune(o->flow, 0, system, message);
    if (status == SALTUS_OK)
        status = saltus_flow_retune(o->tangent, 0, system, message);
    if (status != SALTUS_OK) {
        saltus_system_free(system);
        return saltus_orbits_noted(o, status);
    }
    saltus_system_free(o->system);
    o->system = system;
    return status;
}

void saltus_solution_clear(saltus_solution *s) {
    saltus_curve_clear(&s->at);
    free(s->breaches);
    saltus_lap_close(&s->survey.lap);
    *s = (saltus_solution){.value = 0};
}

double saltus_solution_heading(const saltus_solution *s) {
    return s->at.tangent[s->at.unknowns - 1];
}

void saltus_solution_head(saltus_solution *s, double heading) {
    if (saltus_solution_heading(s) * heading < 0)
        saltus_curve_turn(&s->at);
}

saltus_scaled saltus_orbits_closing(saltus_shooting *shooting, bool flips) {
    const saltus_dense_lu *lu = saltus_shooting_factor(shooting, flips ? 2 : 0);
    return (saltus_scaled){lu->sign, lu->log_modulus};
}

saltus_status saltus_solution_see(saltus_orbits *o, saltus_solution *s, saltus_message *message) {
    const saltus_breach *breaches = o->shooting->breaches.items;
    s->breach_count = o->shooting->breaches.count;
    if (s->breach_count > s->breach_room) {
        free(s->breaches);
        s->breaches = calloc((size_t)s->breach_count, sizeof *s->breaches);
        s->breach_room = s->breaches ? s->breach_count : 0;
        if (!s->breaches) {
            s->breach_count = 0;
            return saltus_orbits_noted(o, saltus_branch_no_memory(message));
        }
    }
    const double *u = s->at.u, *parameters = u + o->equations->count;
    saltus_shooting_extract(o->shooting, u, &s->sequence, s->state);
    for (int d = 0; d < o->family.parameters; d++)
        s->parameter[d] = parameters[d];
    s->value = o->origin + o->family.unit[0] * parameters[0];
    s->at.residual = o->equations->size;
    s->onward = o->shooting->onward;
    s->speed = o->shooting->flow_speed;
    s->growth = saltus_shooting_growth(o->shooting);
    s->worst = (saltus_breach){.value = -1};
    for (int k = 0; k < s->breach_count; k++) {
        s->breaches[k] = breaches[k];
        if (breaches[k].value > s->worst.value)
            s->worst = breaches[k];
    }
    if (o->family.parameters == 1)
        s->flip = saltus_orbits_closing(o->shooting, true);
    s->grazes_ahead = 0;
    s->survey.follows = s->survey.walked = false;
    s->survey.label[0] = 0;
    s->survey.past_place = 0;
    for (int k = 0; k < 3; k++)
        s->survey.circle[k] = NAN;
    return SALTUS_OK;
}

/* See saltus_solution_place and _restore; from the states at the first cuts, so many as are `given`. */
static saltus_status place(saltus_orbits *o, const saltus_sequence *sequence, const double *parameters,
                           const double *states, int given, bool polish, saltus_solution *out,
                           saltus_message *message) {
    saltus_equations *e = o->equations;
    int iterations = 0;
    saltus_status status = saltus_shooting_shape(o->shooting, sequence, message);
    if (status == SALTUS_OK && !saltus_curve_reserve(&out->at, e->unknowns))
        status = saltus_branch_no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(o->shooting, parameters, states, given, out->at.u, message);
    if (status == SALTUS_OK && polish)
        status = saltus_newton(e, out->at.u, NULL, NULL, true, &iterations, message);
    else if (status == SALTUS_OK)
        status = saltus_equations_evaluate(e, out->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, out, message);
    out->at.ahead = 0;
    out->at.iterations = iterations;
    if (status == SALTUS_OK && o->family.parameters == 1)
        status = saltus_curve_orient(e, NULL, &out->at, message);
    return saltus_orbits_noted(o, status);
}

saltus_status saltus_solution_place(saltus_orbits *o, const saltus_sequence *sequence,
                                    const double *parameters, const double *state, bool polish,
                                    saltus_solution *out, saltus_message *message) {
    return place(o, sequence, parameters, state, 1, polish, out, message);
}

saltus_status saltus_solution_restore(saltus_orbits *o, const saltus_sequence *sequence,
                                      const double *parameters, const double *states, bool polish,
                                      saltus_solution *out, saltus_message *message) {
    return place(o, sequence, parameters, states, sequence->cuts, polish, out, message);
}

void saltus_orbits_reshape(saltus_orbits *o, const saltus_solution *s) {
    saltus_orbits_noted(o, saltus_shooting_shape(o->shooting, &s->sequence, NULL));
}

double saltus_solution_period(const saltus_solution *s) {
    return 2 * M_PI * s->sequence.periods / s->sequence.omega;
}

double saltus_solution_way(const saltus_solution *s) {
    return s->speed * s->sequence.speed * saltus_solution_period(s);
}

bool saltus_solution_rests(const saltus_solution *s, const saltus_solution *near) {
    const double nothing = 1e-6, shrunk = 1e-3;
    return s->sequence.omega > 0 && s->sequence.count == 0 &&
           saltus_solution_way(s) < (near ? fmax(nothing, shrunk * saltus_solution_way(near)) : nothing);
}

bool saltus_solution_visit(saltus_orbits *o, const saltus_solution *from, double ahead,
                           saltus_solution *out) {
    saltus_status status = saltus_curve_visit(o->equations, &from->at, ahead, &out->at, NULL);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, out, NULL);
    return saltus_orbits_noted(o, status) == SALTUS_OK;
}

const saltus_breach *saltus_solution_slowest(const saltus_solution *s) {
    const saltus_breach *slowest = NULL;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind == SALTUS_BREACH_SPEED && (!slowest || s->breaches[k].value > slowest->value))
            slowest = &s->breaches[k];
    return slowest;
}

/* Beside grazing the square of a speed is linear in the parameter, and the curve straight in what matters. */
void saltus_solution_expect_grazing(saltus_solution *s, const saltus_solution *before) {
    const saltus_breach *now = saltus_solution_slowest(s);
    for (int k = 0; k < before->breach_count && now; k++) {
        const saltus_breach *then = &before->breaches[k];
        const double fall = then->value * then->value - now->value * now->value;
        if (then->kind == SALTUS_BREACH_SPEED && then->mark == now->mark && fall > 0)
            s->grazes_ahead = s->at.ahead * (now->value * now->value / fall);
    }
}

/* The time of an impact without speed is an extremum of its gap, so that in the hyperplanes of arclength,
 * where the curve turns within a distance like the impact's speed, Newton's method hardly converges. With the
 * speed as one more equation instead it is regular there. */
saltus_zero saltus_solution_graze(saltus_orbits *o, const saltus_solution *from, saltus_solution *out) {
    enum { iterations_max = 8 };
    const double nothing = 1e-13;
    saltus_equations *e = o->equations;
    saltus_zero zero = {.accuracy = INFINITY};
    const saltus_breach *impact = saltus_solution_slowest(from);
    const int m = e->unknowns, c = e->count;
    const int own = impact ? from->sequence.cuts * o->n + impact->mark : 0;
    saltus_status status = saltus_curve_reserve(&out->at, m) ? SALTUS_OK : SALTUS_NO_MEMORY;
    if (!impact || saltus_orbits_noted(o, status) != SALTUS_OK)
        return zero;
    const double *row = saltus_shooting_speed_row(o->shooting, impact->mark);
    double length = INFINITY, before = INFINITY;
    for (int j = 0; j < m; j++)
        out->at.u[j] = from->at.u[j] + from->grazes_ahead * from->at.tangent[j];
    for (int k = 0; k < iterations_max && status == SALTUS_OK && length > nothing; k++) {
        status = saltus_equations_evaluate(e, out->at.u, NULL);
        if (status == SALTUS_OK)
            status = saltus_equations_step(e, row, e->jacobian[own * m + own]);
        before = length;
        length = saltus_length(e->step, m);
        if (status != SALTUS_OK || !(length < 0.5 * before))
            break;
        for (int j = 0; j < m; j++)
            out->at.u[j] += e->step[j];
        zero.accuracy = o->family.unit[0] * fabs(e->step[c]);
        out->at.iterations = k + 1;
    }
    saltus_shooting_speed_row(o->shooting, -1);
    if (status == SALTUS_OK)
        status =
            length < sqrt(nothing) ? saltus_equations_evaluate(e, out->at.u, NULL) : SALTUS_NO_CONVERGENCE;
    if (status == SALTUS_OK && !(e->size <= e->tolerance))
        status = SALTUS_NO_CONVERGENCE;
    if (status == SALTUS_OK)
        status = saltus_curve_orient(e, from->at.tangent, &out->at, NULL);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, out, NULL);
    zero.ahead = out->at.ahead =
        saltus_dot(out->at.u, from->at.tangent, m) - saltus_dot(from->at.u, from->at.tangent, m);
    zero.found = saltus_orbits_noted(o, status) == SALTUS_OK;
    return zero;
}

int saltus_solution_speed_range(const saltus_solution *s, double *slowest, double *fastest) {
    int count = 0;
    *slowest = INFINITY;
    *fastest = -INFINITY;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind == SALTUS_BREACH_SPEED) {
            *slowest = fmin(*slowest, -s->breaches[k].value);
            *fastest = fmax(*fastest, -s->breaches[k].value);
            count++;
        }
    return count;
}

void saltus_solution_speeds(const saltus_orbits *o, const saltus_solution *s, double *speed) {
    for (int k = 0; k < s->sequence.count; k++)
        speed[k] = 0;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind == SALTUS_BREACH_SPEED)
            speed[s->breaches[k].mark] = -s->breaches[k].value * o->shooting->speed;
}

/* Walk along a sequence from the states at its cuts, filling `cocycle` (may be NULL) unless that is `given`,
 * but for what the flow's events add. */
static saltus_status walk(saltus_orbits *o, const saltus_sequence *sequence, const double *states,
                          saltus_cocycle *cocycle, bool given, saltus_lap *lap, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    if (given)
        cocycle->sum_rule = cocycle->zeros = cocycle->mirrored = 0;
    else if (cocycle)
        status = saltus_cocycle_open(cocycle, o->system, sequence->periods, sequence->omega > 0, message);
    return status == SALTUS_OK ? saltus_sequence_walk(sequence, cocycle && !given ? o->tangent : o->flow,
                                                      states, lap, cocycle, message)
                               : status;
}

/* Where perturbations grow by many orders of magnitude around the orbit, as after several slow impacts,
 * rounding alone leads the flow away from it. Let the flow begin anew amid flights, from the prescribed
 * states there; survey and cocycle change only if it *follows then. */
static saltus_status walk_in_pieces(saltus_orbits *o, saltus_solution *s, saltus_cocycle *cocycle, bool given,
                                    bool *follows, saltus_message *message) {
    saltus_sequence pieces;
    saltus_lap lap = {.keeps_events = true};
    saltus_sequence_turn(&s->sequence, s->sequence.base, SALTUS_CUTS_MAX, &pieces, NULL);
    if (pieces.cuts <= s->sequence.cuts)
        return SALTUS_OK;
    double *states;
    saltus_status status = saltus_solution_states_at(o, s, &pieces, &states, message);
    /* At grazing it is chance which of the flows meets the impact. */
    if (status == SALTUS_OK)
        status = saltus_sequence_walk(&pieces, cocycle && !given ? o->tangent : o->flow, states, &lap, NULL,
                                      message);
    *follows = status == SALTUS_OK && saltus_sequence_follows(&pieces, &lap);
    if (*follows && cocycle)
        status = walk(o, &pieces, states, cocycle, given, &lap, message);
    if (*follows && status == SALTUS_OK)
        SALTUS_SWAP(s->survey.lap, lap);
    saltus_lap_close(&lap);
    free(states);
    return status;
}

/* Go around the orbit with the flow's own events, filling `cocycle` (may be NULL). A failure of the flow is
 * no error: the solution then does not follow. */
static saltus_status go_around(saltus_orbits *o, saltus_solution *s, saltus_cocycle *cocycle,
                               saltus_message *message) {
    saltus_survey *survey = &s->survey;
    saltus_message why = {.text = ""};
    survey->follows = survey->walked = false;
    survey->lap.keeps_events = true;
    const bool given = cocycle && cocycle->given && saltus_shooting_collected(o->shooting, s->at.u);
    saltus_status status = saltus_orbits_tune(o, s->parameter, s->sequence.omega, message);
    if (status != SALTUS_OK)
        return saltus_orbits_noted(o, status);
    const double *states = saltus_shooting_states(o->shooting, s->at.u);
    status = walk(o, &s->sequence, states, cocycle, given, &survey->lap, &why);
    survey->follows = status == SALTUS_OK && saltus_sequence_follows(&s->sequence, &survey->lap);
    if (!survey->follows && status != SALTUS_NO_MEMORY && !(s->worst.value > 0)) {
        const saltus_status again = walk_in_pieces(o, s, cocycle, given, &survey->follows, &why);
        status = survey->follows || again == SALTUS_NO_MEMORY ? again : status;
    }
    if (saltus_orbits_noted(o, status) == SALTUS_NO_MEMORY)
        return saltus_branch_no_memory(message);
    if (status == SALTUS_OK) {
        survey->walked = true;
        survey->impacts = saltus_lap_impacts(&survey->lap);
        survey->sticking_intervals = saltus_lap_sticking(&survey->lap);
        saltus_lap_label(&survey->lap, survey->label);
    }
    return SALTUS_OK;
}

bool saltus_solution_walk(saltus_orbits *o, saltus_solution *s) {
    return go_around(o, s, NULL, NULL) == SALTUS_OK;
}

bool saltus_cycle_around(saltus_orbits *o, const saltus_solution *s, saltus_lap *lap) {
    const saltus_sequence *own = &s->sequence;
    double time[SALTUS_CUTS_MAX] = {0}, *states;
    saltus_status status = saltus_solution_states_at(o, s, own, &states, NULL);
    for (int j = 1; j < own->cuts; j++)
        time[j] = (own->cut[j] - own->base) / own->periods;
    if (status == SALTUS_OK)
        status = saltus_orbits_tune(o, s->parameter, own->omega / own->periods, NULL);
    if (status == SALTUS_OK)
        status = saltus_lap_cycle(lap, o->flow, states,
                                  &(saltus_pieces){own->cuts - 1, time + 1, states + o->n}, NULL);
    free(states);
    return saltus_orbits_noted(o, status) == SALTUS_OK;
}

bool saltus_solution_section(saltus_orbits *o, const saltus_solution *s, const double *point,
                             saltus_lap *lap) {
    if (s->sequence.omega > 0)
        return saltus_cycle_around(o, s, lap);
    if (!s->survey.walked)
        return false;
    saltus_status status = saltus_orbits_tune(o, s->parameter, 0, NULL);
    if (status == SALTUS_OK)
        status = saltus_lap_around(lap, o->flow, point, s->sequence.periods, NULL);
    return saltus_orbits_noted(o, status) == SALTUS_OK;
}

int saltus_solution_least_period(saltus_orbits *o, const saltus_solution *s) {
    saltus_lap lap = {0};
    const bool known = s->sequence.periods > 1 && s->sequence.omega == 0 &&
                       !saltus_lap_held(&s->survey.lap) &&
                       saltus_solution_section(o, s, s->survey.lap.points, &lap);
    const int least = known ? saltus_lap_least_period(&lap, &o->options.flow) : s->sequence.periods;
    saltus_lap_close(&lap);
    return least;
}

void saltus_solution_label(saltus_orbits *o, const saltus_solution *s, char label[SALTUS_LABEL_MAX]) {
    saltus_lap lap = {0};
    memcpy(label, s->survey.label, SALTUS_LABEL_MAX);
    if (label[0] && s->sequence.omega > 0) {
        label[0] = 0; /* unless the returns are known */
        if (saltus_cycle_around(o, s, &lap))
            saltus_orbit_label(s->survey.impacts, lap.periods, label);
    }
    saltus_lap_close(&lap);
}

/* See saltus_survey. */
static void circle_products(const saltus_multiplier *mu, int n, double circle[3]) {
    double complex product[] = {1, 1, 1};
    for (int i = 0; i < n; i++) {
        const double complex own = mu[i].re + mu[i].im * I;
        product[0] *= 1 - own;
        product[1] *= 1 + own;
        for (int j = 0; j < i; j++)
            product[2] *= own * (mu[j].re + mu[j].im * I) - 1;
    }
    for (int k = 0; k < 3; k++)
        circle[k] = creal(product[k]);
}

saltus_status saltus_solution_survey(saltus_orbits *o, saltus_solution *s, saltus_message *message) {
    saltus_survey *survey = &s->survey;
    saltus_cocycle *cocycle = &o->cocycle;
    saltus_status status = go_around(o, s, cocycle, message);
    survey->unstable = -1;
    survey->multiplier_count = 0;
    survey->trivial = 0;
    for (int i = 0; i < o->n; i++)
        survey->multipliers[i] = (saltus_multiplier){NAN, NAN, NAN};
    circle_products(survey->multipliers, o->n, survey->circle);
    survey->log_volume = survey->sum_rule = NAN;
    if (status != SALTUS_OK || !survey->walked)
        return status;
    /* Where the flow leaves the orbit that gave the matrices, its sum rule is that of another one. */
    if (cocycle->given && !survey->follows)
        cocycle->sum_rule = NAN;
    status = saltus_cocycle_solve(cocycle, survey->multipliers, &survey->multiplier_count, &survey->trivial,
                                  &survey->log_volume, NULL);
    survey->sum_rule = cocycle->sum_rule;
    survey->unstable = saltus_multipliers_unstable(survey->multipliers, survey->multiplier_count);
    circle_products(survey->multipliers, survey->multiplier_count, survey->circle);
    return saltus_orbits_noted(o, status) == SALTUS_NO_MEMORY ? saltus_branch_no_memory(message) : SALTUS_OK;
}

/* A shooting and its unknowns, from the states at the first cuts, so many as are `given`. */
static saltus_status shoot(const saltus_orbits *o, const saltus_sequence *sequence, const double *parameters,
                           const double *states, int given, saltus_shooting **shooting,
                           saltus_message *message) {
    saltus_status status = saltus_shooting_new(&o->family, &o->options, shooting, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_shape(*shooting, sequence, message);
    double *u = status == SALTUS_OK ? (*shooting)->equations.trial : NULL;
    return u ? saltus_shooting_fill(*shooting, parameters, states, given, u, message) : status;
}

saltus_status saltus_orbits_shoot(const saltus_orbits *o, const saltus_solution *at,
                                  const saltus_sequence *sequence, saltus_shooting **shooting,
                                  saltus_message *message) {
    double *states;
    saltus_status status = saltus_solution_states_at(o, at, sequence, &states, message);
    if (status == SALTUS_OK)
        status = shoot(o, sequence, at->parameter, states, sequence->cuts, shooting, message);
    free(states);
    return status;
}

saltus_status saltus_orbits_evaluate(const saltus_orbits *o, const saltus_solution *at,
                                     const saltus_sequence *sequence, saltus_shooting **shooting,
                                     saltus_message *message) {
    const saltus_status status = saltus_orbits_shoot(o, at, sequence, shooting, message);
    saltus_equations *e = status == SALTUS_OK ? &(*shooting)->equations : NULL;
    return e ? saltus_equations_evaluate(e, e->trial, message) : status;
}

/* See saltus_solution_state_at. */
static saltus_status find_state(const saltus_orbits *o, const saltus_solution *s, double time, double *state,
                                saltus_message *message) {
    const saltus_sequence *own = &s->sequence;
    const double rounding = 1e-14 * (1 + own->base + own->periods);
    double later = time - own->periods * floor((time - own->base + rounding) / own->periods);
    int k = own->cuts - 1;
    saltus_sequence cut = *own;
    saltus_shooting *shooting = NULL;
    while (k > 0 && own->cut[k] > later + rounding)
        k--;
    for (int i = 0; i < o->n; i++)
        state[i] = k ? s->at.u[k * o->n + i] * o->shooting->scale[i] : s->state[i];
    const double begin = k ? own->cut[k] : own->base;
    if (fabs(later - begin) <= rounding)
        return SALTUS_OK;
    /* It is the state at the second cut of the sequence that begins at the last one before. */
    if (k > 0)
        saltus_sequence_turn(own, begin, 1, &cut, NULL);
    cut.cuts = 2;
    cut.cut[0] = cut.base;
    cut.cut[1] = cut.base + (later - begin);
    saltus_status status = shoot(o, &cut, s->parameter, state, 1, &shooting, message);
    for (int i = 0; i < o->n && status == SALTUS_OK; i++)
        state[i] = shooting->equations.trial[o->n + i] * shooting->scale[i];
    saltus_shooting_free(shooting);
    return status;
}

saltus_status saltus_solution_state_at(saltus_orbits *o, const saltus_solution *s, double time, double *state,
                                       saltus_message *message) {
    return saltus_orbits_noted(o, find_state(o, s, time, state, message));
}

saltus_status saltus_solution_states_at(const saltus_orbits *o, const saltus_solution *s,
                                        const saltus_sequence *cut, double **states,
                                        saltus_message *message) {
    const saltus_sequence *own = &s->sequence;
    saltus_shooting *shooting = NULL;
    double *all = *states = calloc((size_t)(cut->cuts * o->n), sizeof *all);
    saltus_status status = all ? SALTUS_OK : saltus_branch_no_memory(message);
    if (own->cuts > 1 || cut->cuts == 1 || cut->base != own->base || cut->periods != own->periods) {
        for (int j = 0; j < cut->cuts && status == SALTUS_OK; j++)
            status = find_state(o, s, j ? cut->cut[j] : cut->base, all + j * o->n, message);
        return status;
    }
    if (status == SALTUS_OK)
        status = shoot(o, cut, s->parameter, s->state, 1, &shooting, message);
    if (status == SALTUS_OK)
        memcpy(all, saltus_shooting_states(shooting, shooting->equations.trial),
               (size_t)(cut->cuts * o->n) * sizeof *all);
    saltus_shooting_free(shooting);
    return status;
}

void saltus_solution_cuts(const saltus_solution *s, saltus_sequence *out) {
    const double little = 1e2; /* once around; several times around it is a power of that */
    const saltus_sequence *own = &s->sequence;
    const int turns = out->periods > own->periods ? out->periods / own->periods : 1;
    const bool once = own->cuts == 1 && (!(s->growth > little) || own->driven || own->contacts);
    const int all = once ? 1 : turns * own->cuts, every = 1 + (all - 1) / SALTUS_CUTS_MAX;
    out->cuts = 0;
    for (int j = 0; j < all; j += every) {
        const double cut =
            (j % own->cuts ? own->cut[j % own->cuts] : own->base) + (double)(j / own->cuts) * own->periods;
        if (cut < out->base + out->periods)
            out->cut[out->cuts++] = cut;
    }
}

bool saltus_orbits_join(const saltus_orbits *o, double before, double apart, double ahead) {
    return fabs(ahead) * apart < cbrt(o->equations->tolerance) * (before - apart);
}

double saltus_solution_part_distance(saltus_orbits *o, const saltus_solution *s, int parts, double *apart) {
    const int periods = s->sequence.periods;
    const double later = s->sequence.base + (double)periods / (parts == 1 ? 2 : parts);
    double state[SALTUS_STATE_MAX], largest = 0;
    if (periods % parts || saltus_solution_state_at(o, s, later, state, NULL) != SALTUS_OK)
        return INFINITY;
    for (int i = 0; i < o->n; i++) {
        const double own = (state[i] + (parts == 1 ? s->state[i] : -s->state[i])) / o->shooting->scale[i];
        largest = fmax(largest, fabs(own));
        if (apart)
            apart[i] = own;
    }
    return largest;
}

const saltus_breach *saltus_solution_touch(const saltus_solution *at) {
    const double still = 1e-9, near = 1e-5, nothing = 1e-12;
    for (int k = 0; k < at->breach_count && at->worst.kind == SALTUS_BREACH_GAP; k++) {
        const saltus_breach *b = &at->breaches[k];
        const bool own = b->face == at->worst.face && fabs(b->time - at->worst.time) < near;
        if (b->kind == SALTUS_BREACH_SPEED && fabs(b->value) < (own ? still : nothing))
            return b;
    }
    return &at->worst;
}

double saltus_pair_off_circle(const saltus_survey *survey) {
    double off = INFINITY;
    for (int i = 0; i < survey->multiplier_count; i++)
        if (survey->multipliers[i].im != 0 && fabs(survey->multipliers[i].log_modulus) < fabs(off))
            off = survey->multipliers[i].log_modulus;
    return off;
}

double saltus_test_value(saltus_test test, double target, const saltus_solution *s,
                         const saltus_solution *from) {
    switch (test) {
    case SALTUS_TEST_FOLD:
        return saltus_solution_heading(s);
    case SALTUS_TEST_FLIP:
        return saltus_scaled_in(s->flip, from->flip.exponent);
    case SALTUS_TEST_CROSSING:
        return saltus_scaled_in(s->at.crossing, from->at.crossing.exponent);
    case SALTUS_TEST_PAIR:
        return s->survey.circle[2];
    case SALTUS_TEST_BREACH:
        /* A step begins on the admissible side; an impact of zero speed was just inserted or removed. */
        return s == from ? fmin(s->worst.value, -1e-300) : s->worst.value;
    case SALTUS_TEST_ONWARD:
        return s->onward;
    case SALTUS_TEST_VALUE:
        return s->value - target;
    }
    return NAN;
}

/* A zero that is being located. */
typedef struct location {
    saltus_orbits *orbits;
    saltus_test test;
    double target, end; /* end 0: fail where the equations are singular */
    const saltus_solution *from;
    saltus_solution *out;
    double visited; /* where `out` is; NAN: nowhere yet */
} location;

/* `out` becomes the point at `ahead`, predicted from the last one that was visited. Near a crossing that one
 * may lie on the other curve: there all points are predicted from the same one. */
static bool visit(location *l, double ahead) {
    const bool crosses = l->test == SALTUS_TEST_CROSSING || l->test == SALTUS_TEST_ONWARD;
    saltus_orbits *o = l->orbits;
    bool found = false;
    if (l->visited == ahead)
        return true;
    if (isfinite(l->visited) && !crosses)
        found = saltus_orbits_noted(
                    o, saltus_curve_revisit(o->equations, &l->from->at, ahead, &l->out->at)) == SALTUS_OK &&
                !saltus_curve_strays(&l->from->at, &l->out->at) &&
                saltus_solution_see(o, l->out, NULL) == SALTUS_OK;
    found = found || saltus_solution_visit(o, l->from, ahead, l->out);
    l->visited = found ? ahead : NAN;
    return found;
}

static bool test_at(void *context, double ahead, double *value) {
    location *l = context;
    bool found = visit(l, ahead);
    /* The equations may be singular at this very point. */
    for (int side = -1; side <= 1 && l->end != 0 && !found; side += 2)
        found = visit(l, ahead + side * 1e-5 * l->end);
    if (found && l->test == SALTUS_TEST_PAIR)
        found = saltus_solution_survey(l->orbits, l->out, NULL) == SALTUS_OK;
    *value = saltus_test_value(l->test, l->target, l->out, l->from);
    return found;
}

saltus_zero saltus_solution_zero_between(saltus_orbits *o, saltus_test test, double target,
                                         const saltus_solution *from, const saltus_solution *to,
                                         const double ends[2], const double values[2], saltus_solution *out) {
    location l = {.orbits = o, .test = test, .target = target, .from = from, .out = out, .visited = NAN};
    saltus_zero zero = {.accuracy = INFINITY};
    double width;
    l.end = ends[1];
    if (to && saltus_orbits_noted(o, saltus_curve_copy(&to->at, &out->at) ? SALTUS_OK : SALTUS_NO_MEMORY) ==
                  SALTUS_OK)
        l.visited = to->at.ahead;
    if (!saltus_curve_zero(o->solver, test_at, &l, ends, values, &zero.ahead, &width) ||
        !visit(&l, zero.ahead))
        return zero;
    double unit = o->family.unit[0], slope = fabs(saltus_solution_heading(out)) * unit;
    zero.accuracy = slope * width + unit * width * width;
    zero.found = true;
    return zero;
}

saltus_zero saltus_solution_zero(saltus_orbits *o, saltus_test test, double target,
                                 const saltus_solution *from, const saltus_solution *to,
                                 saltus_solution *out) {
    const double ends[] = {0, to->at.ahead};
    const double values[] = {saltus_test_value(test, target, from, from),
                             saltus_test_value(test, target, to, from)};
    return saltus_solution_zero_between(o, test, target, from, to, ends, values, out);
}

saltus_zero saltus_solution_crossing(saltus_orbits *o, saltus_test by, const saltus_solution *from,
                                     double ahead, double reach, saltus_solution *out) {
    location l = {.orbits = o, .test = by, .from = from, .out = out, .visited = NAN};
    double accuracy;
    saltus_status status = saltus_curve_crossing(o->equations, test_at, &l, &from->at, ahead, reach,
                                                 by == SALTUS_TEST_CROSSING, &out->at, &accuracy);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, out, NULL);
    return (saltus_zero){.found = saltus_orbits_noted(o, status) == SALTUS_OK,
                         .ahead = out->at.ahead,
                         .accuracy = o->family.unit[0] * accuracy};
}
