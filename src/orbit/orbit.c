/* Newton shooting for periodic orbits.
 *
 * First the flow finds its events itself: x(pT) - x(0) = 0 with the exact derivative through all events,
 * which lets the sequence of impacts change on the way. Where that fails, as it must near grazing, where the
 * derivative grows without bound, the events of the best iterate are prescribed and their times become
 * unknowns; the orbit found so is accepted if the flow follows it. The two take turns. Strong growth of the
 * tangent vectors cuts the orbit into segments (multiple shooting).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/multipliers.h"
#include "orbit/sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { turns_max = 3 };

/* Growth over one segment beyond which Newton's equations lose too many digits. */
static const double growth_max = 1e5;
/* Beyond this many scales of the system rounding alone exceeds any tolerance. */
static const double size_max = 1e8;

saltus_orbit_options saltus_orbit_defaults(void) {
    return (saltus_orbit_options){
        .flow = saltus_flow_defaults(), .phase = 0, .iterations = 20, .tolerance = 1e-12};
}

/* One search: the workspace and the best orbit so far. */
typedef struct search {
    saltus_shooting *shooting;
    saltus_flow *flow; /* event-driven, without tangent vectors */
    saltus_lap lap;
    int n;
    saltus_sequence sequence;
    double *state, *start, *u; /* `start`: of a sequence under trial */
    int unknowns_room;
    double residual;
    int iterations;
} search;

static saltus_status adopt(search *s, const saltus_sequence *sequence, const double *state,
                           saltus_message *message) {
    saltus_status status = saltus_shooting_shape(s->shooting, sequence, message);
    if (status != SALTUS_OK)
        return status;
    int unknowns = saltus_shooting_unknowns(s->shooting);
    if (unknowns > s->unknowns_room) {
        double *grown = realloc(s->u, (size_t)unknowns * sizeof *grown);
        if (!grown)
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
        s->u = grown;
        s->unknowns_room = unknowns;
    }
    return saltus_shooting_fill(s->shooting, 0, state, s->u, message);
}

/* Equal segments, their number from the growth over the whole orbit. */
static void cut_sequence(saltus_sequence *sequence, int segments, double growth) {
    int wanted = segments > 0 ? segments : (int)ceil(log(fmax(growth, 1)) / log(growth_max));
    sequence->cuts = wanted < 1 ? 1 : wanted > SALTUS_CUTS_MAX ? SALTUS_CUTS_MAX : wanted;
    for (int j = 0; j < sequence->cuts; j++)
        sequence->cut[j] = sequence->base + (double)j * sequence->periods / sequence->cuts;
}

/* Where there is no orbit Newton's method may run so far that all the forcing does is lost in rounding. */
static saltus_status check_size(const search *s, saltus_message *message) {
    const double *scale = saltus_system_scale(saltus_shooting_system(s->shooting));
    double size = 0;
    for (int i = 0; i < s->n; i++)
        size = fmax(size, fabs(s->state[i]) / scale[i]);
    if (size < size_max)
        return SALTUS_OK;
    return saltus_fail(
        message, SALTUS_NO_CONVERGENCE,
        "Newton's iteration ran away to a state of %.3g times the usual size, where rounding hides "
        "the residual",
        size);
}

static saltus_status solve(search *s, const saltus_sequence *sequence, const saltus_orbit_options *options,
                           saltus_message *message) {
    saltus_sequence cut = *sequence;
    int iterations = 0;
    cut_sequence(&cut, 1, 1);
    saltus_status status = adopt(s, &cut, s->state, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_evaluate(s->shooting, s->u, message);
    double growth = status == SALTUS_OK ? saltus_shooting_growth(s->shooting) : 1;
    if (status == SALTUS_OK && (options->segments > 1 || (options->segments == 0 && growth > growth_max))) {
        cut_sequence(&cut, options->segments, growth);
        status = adopt(s, &cut, s->state, message);
    }
    if (status == SALTUS_OK)
        status = saltus_shooting_correct(s->shooting, s->u, NULL, NULL, true, &iterations, message);
    s->iterations += iterations;
    s->residual = saltus_shooting_residual(s->shooting);
    if (status == SALTUS_OK || s->residual < INFINITY)
        saltus_shooting_extract(s->shooting, s->u, &s->sequence, s->state);
    return status == SALTUS_OK ? check_size(s, message) : status;
}

/* Bring the state from the sequence's base to the section's phase. */
static saltus_status to_section(search *s, double phase, int periods, saltus_message *message) {
    double base = s->sequence.base, whole = floor(base), ahead = phase - (base - whole);
    saltus_event event;
    if (ahead == 0)
        return SALTUS_OK;
    saltus_time start = {(long long)whole, base - whole};
    saltus_time until = {start.cycle + (ahead < 0), phase};
    /* The base lies within the orbit: to the section point that is a whole number of orbits away. */
    until.cycle += (periods - until.cycle % periods) % periods;
    saltus_status status = saltus_flow_start(s->flow, 0, start, s->state, message);
    if (status == SALTUS_OK)
        status = saltus_flow_advance(s->flow, until, 0, &event, message);
    saltus_flow_state(s->flow, 0, s->state);
    return status;
}

/* One sequence from the state at its base; accepted if the event-driven flow follows the orbit found. */
static saltus_status solve_sequence(search *s, const saltus_sequence *sequence,
                                    const saltus_orbit_options *options, saltus_message *message) {
    saltus_status status = solve(s, sequence, options, message);
    if (status != SALTUS_OK)
        return status;
    status = saltus_sequence_walk(sequence, s->flow, s->state, &s->lap, message);
    bool follows = status == SALTUS_OK && saltus_sequence_follows(&s->sequence, &s->lap);
    if (follows || status == SALTUS_NO_MEMORY)
        return status;
    return saltus_fail(message, SALTUS_NO_CONVERGENCE,
                       "an impact grazes: the orbit with these %d events passes through a stop",
                       s->sequence.count);
}

/* The event times become unknowns. */
static saltus_status solve_prescribed(search *s, int periods, const saltus_orbit_options *options,
                                      saltus_message *message) {
    saltus_sequence sequence;
    saltus_status status = saltus_sequence_make(s->flow, periods, s->state, &s->lap, &sequence, message);
    return status == SALTUS_OK ? solve_sequence(s, &sequence, options, message) : status;
}

static bool grazes(const saltus_message *message) {
    return strstr(message->text, "grazes") != NULL;
}

/* How far the search has gone from its start, scaled. */
static double moved(const search *s) {
    return saltus_system_distance(saltus_shooting_system(s->shooting), s->state, s->start);
}

/* Whether near the guess there is an orbit with one impact less than the flow meets, which it cannot follow:
 * then that impact is to blame. */
static bool passes_through(search *s, int periods, const double *guess, const saltus_orbit_options *options,
                           saltus_message *message) {
    enum { tries = 8 };
    const double nearby = 0.3;
    size_t bytes = (size_t)s->n * sizeof *guess;
    saltus_sequence met = {.periods = periods, .base = options->phase, .driven = true};
    memcpy(s->state, guess, bytes);
    s->sequence = met;
    if (to_section(s, 0, periods, message) != SALTUS_OK ||
        saltus_sequence_make(s->flow, periods, s->state, &s->lap, &met, message) != SALTUS_OK)
        return false;
    memcpy(s->start, s->state, bytes);
    for (int out = 0; out < met.count && out < tries; out++) {
        saltus_sequence fewer = met;
        for (int k = out; k + 1 < fewer.count; k++)
            fewer.mark[k] = fewer.mark[k + 1];
        fewer.count--;
        memcpy(s->state, s->start, bytes);
        if (solve_sequence(s, &fewer, options, message) != SALTUS_OK && grazes(message) && moved(s) < nearby)
            return true;
    }
    return false;
}

/* The cause that a failure names: an orbit found that passes through a stop says more than a residual. */
static saltus_status blame(search *s, int periods, const double *guess, const saltus_orbit_options *options,
                           saltus_status status, const saltus_message *plain, saltus_message *prescribed,
                           saltus_message *message) {
    bool tell = grazes(prescribed) || (status != SALTUS_NO_MEMORY && status != SALTUS_BAD_INPUT &&
                                       passes_through(s, periods, guess, options, prescribed));
    return saltus_fail(message, tell ? SALTUS_NO_CONVERGENCE : status, "%s",
                       tell ? prescribed->text : plain->text);
}

static saltus_status find(search *s, int periods, const double *guess, const saltus_orbit_options *options,
                          saltus_message *message) {
    saltus_sequence driven = {.periods = periods, .base = options->phase, .driven = true};
    saltus_message plain = {""}, later = {""}, prescribed = {""};
    saltus_status first = SALTUS_OK;
    memcpy(s->state, guess, (size_t)s->n * sizeof *guess);
    for (int turn = 0; turn < turns_max; turn++) {
        saltus_status status = solve(s, &driven, options, turn ? &later : &plain);
        if (status == SALTUS_OK)
            return status;
        if (turn == 0)
            first = status;
        if (first == SALTUS_NO_MEMORY || first == SALTUS_BAD_INPUT ||
            saltus_system_face_count(saltus_shooting_system(s->shooting)) == 0)
            break;
        status = to_section(s, 0, periods, &later);
        if (status == SALTUS_OK)
            status = solve_prescribed(s, periods, options, grazes(&prescribed) ? &later : &prescribed);
        if (status == SALTUS_OK)
            return to_section(s, options->phase, periods, message);
        if (!(s->residual < INFINITY) || to_section(s, options->phase, periods, &later) != SALTUS_OK)
            break;
    }
    return blame(s, periods, guess, options, first, &plain, &prescribed, message);
}

static saltus_status open_search(search *s, const saltus_system *system, const saltus_orbit_options *options,
                                 saltus_message *message) {
    int n = saltus_system_dimension(system);
    s->n = n;
    s->lap.keeps_events = true;
    s->state = calloc(2 * (size_t)n, sizeof *s->state);
    s->start = s->state ? s->state + n : NULL;
    saltus_status status =
        s->state ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    if (status == SALTUS_OK)
        status = saltus_flow_single(system, 0, &options->flow, &s->flow, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_new(saltus_system_spec(system), NULL, 0, 1, options, &s->shooting, message);
    return status;
}

saltus_status saltus_orbit_find(const saltus_system *system, int periods, const double *guess,
                                const saltus_orbit_options *options, saltus_orbit *orbit,
                                saltus_message *message) {
    *orbit = (saltus_orbit){.dimension = saltus_system_dimension(system), .periods = periods};
    search s = {0};
    size_t n = (size_t)orbit->dimension;
    saltus_status status = open_search(&s, system, options, message);
    if (status == SALTUS_OK)
        status = find(&s, periods, guess, options, message);
    orbit->residual = s.residual;
    orbit->iterations = s.iterations;
    orbit->state = calloc(n, sizeof *orbit->state);
    if (status == SALTUS_OK && !orbit->state)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    if (status == SALTUS_OK) {
        memcpy(orbit->state, s.state, n * sizeof *s.state);
        status = saltus_orbit_multipliers(system, options, orbit, message);
    }
    saltus_shooting_free(s.shooting);
    saltus_flow_free(s.flow);
    saltus_lap_close(&s.lap);
    free(s.state);
    free(s.u);
    if (status != SALTUS_OK)
        saltus_orbit_clear(orbit);
    return status;
}

void saltus_orbit_clear(saltus_orbit *orbit) {
    free(orbit->state);
    free(orbit->monodromy);
    free(orbit->multipliers);
    *orbit = (saltus_orbit){0};
}
