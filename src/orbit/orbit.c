/* Newton shooting for periodic orbits.
 *
 * At first the flow finds its events itself: x(pT) - x(0) = 0 with the exact derivative through all events.
 * The sequence of impacts may then change on the way. This must fail near grazing, where the derivative grows
 * without bound. Then the events of the best iterate are prescribed and their times become unknowns; an orbit
 * found this way is accepted if the flow follows it. The two formulations alternate. If tangent vectors grow
 * strongly, the orbit is cut into segments (multiple shooting).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/orbit.h"

#include "base/dense.h"
#include "flow/flow.h"
#include "orbit/multipliers.h"
#include "orbit/sequence.h"
#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { turns_max = 3 };

/* Growth over one segment above which Newton's equations lose too many digits. */
static const double growth_max = 1e5;
/* Beyond this many scales of the system rounding exceeds any tolerance. */
static const double size_max = 1e8;

typedef struct search {
    const saltus_orbit_options *options;
    int n, periods;
    saltus_shooting *shooting;
    saltus_flow *flow;     /* event-driven, without tangent vectors */
    saltus_system *system; /* the flow's, once the period has changed; else NULL */
    saltus_lap lap;
    double *u; /* the shooting's unknowns */
    /* The best orbit so far: its sequence, and its state at the sequence's base. */
    saltus_sequence sequence;
    double state[SALTUS_STATE_MAX];
    double residual;
    int iterations; /* over all formulations */
} search;

/* Set up the unknowns for a sequence, from the best state, which is at the sequence's base. */
static saltus_status adopt(search *s, const saltus_sequence *sequence, saltus_message *message) {
    saltus_status status = saltus_shooting_shape(s->shooting, sequence, message);
    if (status != SALTUS_OK)
        return status;
    const size_t unknowns = (size_t)s->shooting->equations.unknowns;
    double *u = realloc(s->u, unknowns * sizeof *u);
    if (!u)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    s->u = u;
    return saltus_shooting_fill(s->shooting, NULL, s->state, 1, s->u, message);
}

/* Cut into equal segments; their number follows from the growth around the orbit. */
static void cut_sequence(saltus_sequence *sequence, int segments, double growth) {
    int wanted = segments > 0 ? segments : (int)ceil(log(fmax(growth, 1)) / log(growth_max));
    sequence->cuts = wanted < 1 ? 1 : wanted > SALTUS_CUTS_MAX ? SALTUS_CUTS_MAX : wanted;
    for (int j = 0; j < sequence->cuts; j++)
        sequence->cut[j] = sequence->base + (double)j * sequence->periods / sequence->cuts;
}

/* Newton's method from the best state, with the events of a sequence. If there is no orbit, it may run off so
 * far that rounding hides the forcing: that is a failure, too. */
static saltus_status solve(search *s, const saltus_sequence *sequence, saltus_message *message) {
    saltus_sequence cut = *sequence;
    int iterations = 0, segments = s->options->segments;
    saltus_equations *equations = &s->shooting->equations;
    cut_sequence(&cut, 1, 1);
    saltus_status status = adopt(s, &cut, message);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(equations, s->u, message);
    double growth = status == SALTUS_OK ? saltus_shooting_growth(s->shooting) : 1, size = 0;
    if (status == SALTUS_OK && (segments > 1 || (segments == 0 && growth > growth_max))) {
        cut_sequence(&cut, segments, growth);
        status = adopt(s, &cut, message);
    }
    equations->begun = equations->known;
    if (status == SALTUS_OK)
        status = saltus_newton(equations, s->u, NULL, NULL, true, &iterations, message);
    s->iterations += iterations;
    s->residual = equations->size;
    if (status == SALTUS_OK || s->residual < INFINITY)
        saltus_shooting_extract(s->shooting, s->u, &s->sequence, s->state);
    if (status == SALTUS_OK && s->sequence.omega > 0) {
        /* The event-driven flow gets the omega of the best orbit. */
        saltus_system *tuned = NULL;
        status = saltus_system_clocked(saltus_flow_system(s->flow, 0), s->sequence.omega, &tuned, message);
        if (status == SALTUS_OK)
            status = saltus_flow_retune(s->flow, 0, tuned, message);
        saltus_system_free(status == SALTUS_OK ? s->system : tuned);
        s->system = status == SALTUS_OK ? tuned : s->system;
    }
    const double *scale = saltus_system_scale(s->shooting->full.system);
    for (int i = 0; i < s->n; i++)
        size = fmax(size, fabs(s->state[i]) / scale[i]);
    if (status != SALTUS_OK || size < size_max)
        return status;
    return saltus_fail(
        message, SALTUS_NO_CONVERGENCE,
        "Newton's iteration ran away to a state of %.3g times the usual size, where rounding hides "
        "the residual",
        size);
}

/* Move the state from the sequence's base on to a time within the orbit. */
static saltus_status to_time(search *s, double time, saltus_message *message) {
    const double base = s->sequence.base;
    const saltus_time start = {(long long)base, base - floor(base)},
                      until = {(long long)time + (time < base ? s->periods : 0), time - floor(time)};
    return time == base ? SALTUS_OK : saltus_state_carry(s->flow, start, until, s->state, message);
}

/* Solve for a sequence from the state at its base; accept the orbit if the event-driven flow follows it. If
 * it does not, because the orbit passes through a stop, *passing is the number of the orbit's events. */
static saltus_status solve_sequence(search *s, const saltus_sequence *sequence, int *passing) {
    saltus_message ignored;
    saltus_status status = solve(s, sequence, &ignored);
    if (status != SALTUS_OK)
        return status;
    status = saltus_sequence_walk(sequence, s->flow, s->state, &s->lap, NULL, &ignored);
    bool follows = status == SALTUS_OK && saltus_sequence_follows(&s->sequence, &s->lap);
    if (follows || status == SALTUS_NO_MEMORY)
        return status;
    *passing = s->sequence.count;
    return SALTUS_NO_CONVERGENCE;
}

/* Look for an orbit near the guess with one impact less than the flow meets, which the flow cannot follow:
 * then that impact grazes. Returns the number of its events, -1 if there is none. */
static int find_passing(search *s, const double *guess) {
    enum { tries = 8 };
    const double nearby = 0.3;
    const saltus_system *system = s->shooting->full.system;
    size_t bytes = (size_t)s->n * sizeof *guess;
    double start[SALTUS_STATE_MAX];
    saltus_message ignored;
    saltus_sequence met = {.periods = s->periods, .base = s->options->phase, .driven = true};
    memcpy(s->state, guess, bytes);
    s->sequence = met;
    if (to_time(s, 0, &ignored) != SALTUS_OK ||
        saltus_sequence_make(s->flow, s->periods, false, s->state, &s->lap, &met, &ignored) != SALTUS_OK)
        return -1;
    memcpy(start, s->state, bytes);
    for (int out = 0; out < met.count && out < tries; out++) {
        saltus_sequence fewer = met;
        int passing = -1;
        for (int k = out; k + 1 < fewer.count; k++)
            fewer.mark[k] = fewer.mark[k + 1];
        fewer.count--;
        memcpy(s->state, start, bytes);
        solve_sequence(s, &fewer, &passing);
        if (passing >= 0 && saltus_system_distance(system, s->state, start) < nearby)
            return passing;
    }
    return -1;
}

/* The sequence that the flow meets from the best state, which moves to its base, where a free period
 * begins. */
static saltus_status meet(search *s, saltus_sequence *met, saltus_message *message) {
    saltus_status status =
        saltus_sequence_make(s->flow, s->periods, s->options->free_period, s->state, &s->lap, met, message);
    if (status != SALTUS_OK || !s->options->free_period)
        return status;
    for (int k = 0; k < met->count; k++)
        met->mark[k].time -= met->base;
    met->base = met->cut[0] = 0;
    return status;
}

/* Move a state beside an impact to the middle of the flight up to the next event, in the time *later, in
 * periods: from the impact itself, rounding would decide whether the flow meets it again after one orbit. */
static saltus_status leave_stop(saltus_flow *flow, double phase, double *state, double *later,
                                saltus_message *message) {
    static const double touching = 1e-9, own = 1e-6; /* sooner it is the impact itself */
    const saltus_system *system = saltus_flow_system(flow, 0);
    const double length = saltus_system_scale(system)[0];
    const saltus_time start = {0, phase};
    saltus_event event = {.kind = SALTUS_REACHED, .time = start};
    unsigned touches = 0;
    *later = 0;
    for (int f = 0; f < saltus_system_face_count(system); f++)
        if (fabs(saltus_system_gap(system, f, state)) < touching * length)
            touches |= 1u << f;
    if (!touches)
        return SALTUS_OK;
    saltus_status status = saltus_flow_start(flow, 0, start, state, message);
    if (status != SALTUS_OK || !(touches & ~saltus_flow_contacts(flow, 0)))
        return status;
    do
        status = saltus_flow_advance(flow, (saltus_time){1, phase}, SALTUS_WATCH_CONTACT, &event, message);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED &&
           saltus_time_between(start, event.time) < own);
    *later = 0.5 * saltus_time_between(start, event.time);
    return status == SALTUS_OK
               ? saltus_state_carry(flow, start, saltus_time_after(start, *later), state, message)
               : status;
}

saltus_status saltus_orbit_all_multipliers(saltus_flow *flow, const saltus_orbit_options *options,
                                           saltus_orbit *orbit, saltus_message *message) {
    saltus_orbit_options way = *options;
    double point[SALTUS_STATE_MAX], later = 0;
    saltus_status status = SALTUS_OK;
    memcpy(point, orbit->state, (size_t)orbit->dimension * sizeof *point);
    if (!options->free_period)
        status = leave_stop(flow, options->phase, orbit->state, &later, message);
    way.phase = fmod(options->phase + later, 1);
    if (status == SALTUS_OK)
        status = saltus_orbit_multipliers(saltus_flow_system(flow, 0), &way, orbit, message);
    memcpy(orbit->state, point, (size_t)orbit->dimension * sizeof *point);
    return status;
}

/* Move the state of an orbit found with prescribed events to a phase: with the times of its impacts, as the
 * flow, which meets them earlier or later, might enlarge rounding on the way by all of the orbit's growth. */
static saltus_status settle_at(search *s, double phase, saltus_message *message) {
    saltus_sequence cut = s->sequence;
    bool flies = !cut.driven && !cut.contacts;
    for (int k = 0; k < cut.count; k++)
        flies = flies && cut.mark[k].kind == SALTUS_IMPACT && !cut.mark[k].driven &&
                remainder(cut.mark[k].time - phase, cut.periods) != 0;
    if (!flies || phase == cut.base)
        return to_time(s, phase, message);
    cut.cuts = 2;
    cut.cut[0] = cut.base;
    cut.cut[1] = phase + (phase < cut.base ? cut.periods : 0);
    saltus_status status = adopt(s, &cut, message);
    if (status == SALTUS_OK)
        memcpy(s->state, saltus_shooting_states(s->shooting, s->u) + s->n, (size_t)s->n * sizeof *s->state);
    return status;
}

/* Alternate between the two formulations, each from the result of the other. If an orbit was found that
 * passes through a stop, the message says so, as that explains more than a residual. */
static saltus_status find(search *s, const double *guess, saltus_message *message) {
    const double phase = s->options->free_period ? 0 : s->options->phase;
    saltus_sequence driven = {.periods = s->periods, .base = phase, .driven = true};
    saltus_message plain = {.text = ""}, ignored;
    double later;
    int passing = -1;
    memcpy(s->state, guess, (size_t)s->n * sizeof *guess);
    saltus_status first = leave_stop(s->flow, phase, s->state, &later, message);
    if (first != SALTUS_OK)
        return first;
    if (!s->options->free_period)
        driven.base = fmod(phase + later, s->periods);
    else {
        first = saltus_shooting_shape(s->shooting, &driven, message);
        if (first == SALTUS_OK)
            first = meet(s, &driven, message);
        if (first != SALTUS_OK)
            return first;
        driven.count = 0;
        driven.contacts = 0;
        driven.driven = true;
    }
    for (int turn = 0; turn < turns_max; turn++) {
        saltus_sequence met;
        int events = -1;
        saltus_status status = solve(s, &driven, turn ? &ignored : &plain);
        if (status == SALTUS_OK)
            return s->options->free_period ? status : to_time(s, phase, message);
        if (turn == 0)
            first = status;
        if (first == SALTUS_NO_MEMORY || first == SALTUS_BAD_INPUT ||
            saltus_system_face_count(saltus_flow_system(s->flow, 0)) == 0)
            break;
        status = to_time(s, 0, &ignored);
        if (status == SALTUS_OK)
            status = meet(s, &met, &ignored);
        if (status == SALTUS_OK)
            status = solve_sequence(s, &met, &events);
        if (status == SALTUS_OK)
            return settle_at(s, phase, message);
        passing = passing < 0 ? events : passing;
        if (!(s->residual < INFINITY) || to_time(s, driven.base, &ignored) != SALTUS_OK)
            break;
    }
    if (passing < 0 && first != SALTUS_NO_MEMORY && first != SALTUS_BAD_INPUT && !s->options->free_period)
        passing = find_passing(s, guess);
    return passing < 0 ? saltus_fail(message, first, "%s", plain.text)
                       : saltus_fail(message, SALTUS_NO_CONVERGENCE,
                                     "an impact grazes: the orbit with these %d events passes through a stop",
                                     passing);
}

/* Fill in the leading multiplier alone, from the last Jacobian of Newton's method, if it is *known there: an
 * orbit in one piece, the modulus not so near to 1 that errors might decide on stability. */
static saltus_status tell_leading(const search *s, saltus_orbit *orbit, bool *known,
                                  saltus_message *message) {
    static const double most_growth = 1e4, clear = 1e-3;
    const saltus_equations *e = &s->shooting->equations;
    const saltus_sequence *sequence = &s->shooting->sequence;
    const int n = s->n;
    double real[SALTUS_STATE_MAX], imaginary[SALTUS_STATE_MAX];
    saltus_multiplier leading = {0, 0, -INFINITY};
    *known = false;
    if (!e->known || sequence->count || sequence->cuts > 1 || sequence->omega > 0 ||
        !(saltus_shooting_growth(s->shooting) < most_growth))
        return SALTUS_OK;
    double *matrix = malloc((size_t)(n * n) * sizeof *matrix);
    orbit->multipliers = malloc(sizeof *orbit->multipliers);
    if (!matrix || !orbit->multipliers) {
        free(matrix);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            matrix[i * n + j] = e->jacobian[i * e->unknowns + j] + (i == j);
    const bool found = saltus_dense_eigenvalues(matrix, n, real, imaginary);
    for (int i = 0; i < n && found; i++) {
        const double logarithm = log(hypot(real[i], imaginary[i]));
        if (logarithm > leading.log_modulus)
            leading = (saltus_multiplier){real[i], imaginary[i], logarithm};
    }
    free(matrix);
    *known = found && fabs(leading.log_modulus) > clear;
    if (*known) {
        *orbit->multipliers = leading;
        orbit->multiplier_count = 1;
    } else {
        free(orbit->multipliers);
        orbit->multipliers = NULL;
    }
    return SALTUS_OK;
}

saltus_status saltus_orbit_search(const saltus_system *system, int periods, const double *guess,
                                  const saltus_orbit_options *options, saltus_multipliers_wanted wanted,
                                  saltus_orbit *orbit, saltus_message *message) {
    int n = saltus_system_dimension(system);
    search s = {.options = options, .n = n, .periods = periods, .lap.keeps_events = true};
    *orbit = (saltus_orbit){0};
    if (options->free_period && saltus_system_forced(system))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "the scene is forced: its orbits have the forcing's period");
    *orbit = (saltus_orbit){.dimension = n, .periods = periods};
    saltus_status status = saltus_flow_single(system, 0, &options->flow, &s.flow, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_new(&(saltus_family){.spec = *saltus_system_spec(system)}, options,
                                     &s.shooting, message);
    if (status == SALTUS_OK) {
        s.shooting->equations.hasty = true;
        status = find(&s, guess, message);
    }
    orbit->residual = s.residual;
    orbit->iterations = s.iterations;
    orbit->state = calloc((size_t)n, sizeof *orbit->state);
    if (status == SALTUS_OK && !orbit->state)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    if (status == SALTUS_OK) {
        bool known = wanted == SALTUS_MULTIPLIERS_NONE;
        orbit->omega = saltus_spec_omega(saltus_system_spec(saltus_flow_system(s.flow, 0)));
        const int met = saltus_section_point(
            system, s.state, options->free_period ? 0 : saltus_section_reach(options->flow.rtol),
            orbit->state, NULL);
        if (wanted == SALTUS_MULTIPLIERS_LEADING && met == 0)
            status = tell_leading(&s, orbit, &known, message);
        if (status == SALTUS_OK && !known)
            status = saltus_orbit_all_multipliers(s.flow, options, orbit, message);
    }
    saltus_shooting_free(s.shooting);
    saltus_flow_free(s.flow);
    saltus_system_free(s.system);
    saltus_lap_close(&s.lap);
    free(s.u);
    if (status != SALTUS_OK)
        saltus_orbit_clear(orbit);
    return status;
}

saltus_status saltus_orbit_find(const saltus_system *system, int periods, const double *guess,
                                const saltus_orbit_options *options, saltus_orbit *orbit,
                                saltus_message *message) {
    return saltus_orbit_search(system, periods, guess, options, SALTUS_MULTIPLIERS_ALL, orbit, message);
}

void saltus_orbit_clear(saltus_orbit *orbit) {
    free(orbit->state);
    free(orbit->monodromy);
    free(orbit->multipliers);
    *orbit = (saltus_orbit){0};
}
