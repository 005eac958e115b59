/* Harvest of unstable periodic orbits: close returns of a trajectory, polished by period, the closest first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/harvest.h"

#include "base/progress.h"
#include "flow/effort.h"
#include "orbit/options.h"
#include "orbit/returns.h"
#include "signal/random.h"
#include "system/state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Inputs, tools and results of a search. */
typedef struct search {
    const saltus_system *system;
    const saltus_harvest_options *options;
    saltus_flow *flow;
    saltus_returns *returns;
    saltus_harvest *harvest;
} search;

static bool goes_on(const search *s, double done) {
    const volatile sig_atomic_t *stop = s->options->flow.stop;
    if (!saltus_stop_asked(stop))
        saltus_progress_show(s->options->progress, done, 1);
    return !saltus_stop_asked(stop);
}

/* Run the trajectory period by period; the first half of the work. */
static saltus_status run_trajectory(search *s, saltus_message *message) {
    enum { between_reports = 256 };
    long long transient = s->options->transient, total = transient + s->options->periods;
    double state[SALTUS_STATE_MAX];
    saltus_random random;
    saltus_status status = SALTUS_OK;
    if (s->options->state)
        memcpy(state, s->options->state, (size_t)saltus_system_dimension(s->system) * sizeof *state);
    else
        status =
            saltus_state_random(s->system, saltus_random_seed(&random, s->options->seed), state, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(s->flow, 0, (saltus_time){0, 0}, state, message);
    for (long long k = 0; k < total && status == SALTUS_OK; k++) {
        saltus_event event;
        if (k % between_reports == 0 && !goes_on(s, 0.5 * (double)k / (double)total))
            break;
        status = saltus_flow_advance(s->flow, (saltus_time){k + 1, 0}, 0, &event, message);
        if (status != SALTUS_OK)
            break;
        saltus_flow_state(s->flow, 0, state);
        status = saltus_state_bounded(s->system, state, saltus_flow_contacts(s->flow, 0), k + 1, message);
        s->harvest->periods = k + 1;
        if (k >= transient)
            saltus_returns_add(s->returns, state, 0);
    }
    return status == SALTUS_INTERRUPTED ? SALTUS_OK : status;
}

static void clear_orbit(saltus_harvest_orbit *found) {
    saltus_orbit_clear(&found->orbit);
    free(found->section_states);
    *found = (saltus_harvest_orbit){0};
}

/* Index of the known orbit that passes through a state at section phase 0; -1 if there is none. */
static int find_known(const saltus_system *system, const saltus_harvest *harvest, int periods,
                      const double *state, double distance) {
    for (int k = 0; k < harvest->count; k++)
        if (harvest->orbits[k].orbit.periods == periods &&
            saltus_orbit_passes(system, harvest->orbits[k].section_states, periods, state, distance))
            return k;
    return -1;
}

/* Polish a guess to an orbit, reduce it to its least period and walk around it. `found` is empty (periods 0)
 * if Newton fails; the only error is lack of memory. */
static saltus_status polish(const search *s, int periods, const double *guess, saltus_harvest_orbit *found,
                            saltus_message *message) {
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_message reason;
    shooting.flow = s->options->flow;
    shooting.tolerance = s->options->tolerance;
    shooting.iterations = 10; /* a guess that needs more is too far from any orbit */
    *found = (saltus_harvest_orbit){.mirror = -1};
    saltus_lap lap = {0};
    saltus_status status =
        saltus_return_polish(s->flow, periods, guess, &shooting, &found->orbit, &lap, &reason);
    if (status == SALTUS_OK) {
        found->section_states = lap.points;
        lap.points = NULL;
        found->impacts = saltus_lap_impacts(&lap);
        memcpy(found->impacts_by_face, lap.impacts_by_face, sizeof lap.impacts_by_face);
        found->sticking_intervals = saltus_lap_sticking(&lap);
    }
    saltus_lap_close(&lap);
    return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "%s", reason.text) : SALTUS_OK;
}

/* Append an orbit to the list. Drops it if it is empty or known already, or if the list is full. */
static saltus_status append(const search *s, saltus_harvest_orbit *found, saltus_message *message) {
    saltus_harvest *h = s->harvest;
    if (found->orbit.periods == 0 || h->count == s->options->most ||
        find_known(s->system, h, found->orbit.periods, found->orbit.state, SALTUS_SAME_POINT) >= 0) {
        clear_orbit(found);
        return SALTUS_OK;
    }
    saltus_harvest_orbit *grown = realloc(h->orbits, ((size_t)h->count + 1) * sizeof *grown);
    if (!grown) {
        clear_orbit(found);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d orbits", h->count + 1);
    }
    h->orbits = grown;
    h->orbits[h->count++] = *found;
    return SALTUS_OK;
}

/* Polish a guess and append the orbit; in a symmetric system also its mirror image. */
static saltus_status try_guess(const search *s, int periods, const double *guess, saltus_message *message) {
    bool shift;
    double image[SALTUS_STATE_MAX];
    saltus_harvest *h = s->harvest;
    int before = h->count;
    saltus_harvest_orbit found;
    saltus_status status = polish(s, periods, guess, &found, message);
    h->candidates++;
    h->converged += found.orbit.periods > 0;
    if (status == SALTUS_OK)
        status = append(s, &found, message);
    if (status != SALTUS_OK || h->count == before || !saltus_system_mirror_symmetric(s->system, &shift))
        return status;
    const saltus_harvest_orbit *new = &h->orbits[before];
    saltus_time half = {0, shift ? 0.5 : 0};
    if (saltus_mirror_image(s->flow, new->orbit.state, half, image, NULL) != SALTUS_OK ||
        saltus_orbit_passes(s->system, new->section_states, new->orbit.periods, image, SALTUS_SAME_POINT))
        return SALTUS_OK;
    status = polish(s, new->orbit.periods, image, &found, message);
    return status == SALTUS_OK ? append(s, &found, message) : status;
}

static int by_period(const void *a, const void *b) {
    const saltus_orbit *x = &((const saltus_harvest_orbit *)a)->orbit,
                       *y = &((const saltus_harvest_orbit *)b)->orbit;
    double difference = x->multipliers[0].log_modulus - y->multipliers[0].log_modulus;
    if (x->periods != y->periods)
        return x->periods - y->periods;
    if (fabs(difference) > 1e-6)
        return difference < 0 ? -1 : 1;
    /* Mirror images have equal multipliers: rounding must not decide their order. */
    for (int i = 0; i < x->dimension; i++)
        if (x->state[i] != y->state[i])
            return x->state[i] < y->state[i] ? -1 : 1;
    return 0;
}

/* Sort the list and link mirror images. */
static saltus_status arrange(const search *s, saltus_message *message) {
    bool shift;
    double image[SALTUS_STATE_MAX];
    saltus_harvest *h = s->harvest;
    saltus_flow_options options = s->options->flow;
    saltus_flow *flow = NULL;
    if (h->count)
        qsort(h->orbits, (size_t)h->count, sizeof *h->orbits, by_period);
    if (!saltus_system_mirror_symmetric(s->system, &shift))
        return SALTUS_OK;
    options.stop = NULL; /* arrange what was found even after a stop request */
    saltus_status status = saltus_flow_single(s->system, 0, &options, &flow, message);
    for (int k = 0; k < h->count && status == SALTUS_OK; k++) {
        const saltus_orbit *orbit = &h->orbits[k].orbit;
        status = saltus_mirror_image(flow, orbit->state, (saltus_time){0, shift ? 0.5 : 0}, image, message);
        if (status == SALTUS_OK)
            h->orbits[k].mirror = find_known(s->system, h, orbit->periods, image, SALTUS_SAME_POINT);
    }
    saltus_flow_free(flow);
    return status;
}

saltus_status saltus_harvest_run(const saltus_system *system, const saltus_harvest_options *options,
                                 saltus_harvest *harvest, saltus_message *message) {
    search s = {.system = system, .options = options, .harvest = harvest};
    saltus_effort effort;
    const saltus_flow_options flow = saltus_effort_begin(&options->flow, system, &effort);
    const saltus_returns_wanted wanted = {1, options->longest, options->tries, options->recurrence,
                                          1, INFINITY};
    *harvest = (saltus_harvest){.face_count = saltus_system_face_count(system),
                                .dimension = saltus_system_dimension(system)};
    saltus_status status =
        saltus_system_forced(system)
            ? saltus_options_check(&saltus_harvest_table, options, message)
            : saltus_fail(message, SALTUS_BAD_INPUT,
                          "the scene has no forcing: its periodic orbits have no period to count in");
    if (status == SALTUS_OK)
        status = saltus_flow_single(system, 0, &flow, &s.flow, message);
    if (status == SALTUS_OK)
        status = saltus_returns_new(system, &wanted, &s.returns, message);
    if (status == SALTUS_OK)
        status = run_trajectory(&s, message);
    /* Polish all candidates, by period and distance; the second half of the work. */
    bool goes = true;
    for (int p = 1; p <= options->longest && status == SALTUS_OK && goes; p++) {
        saltus_return closest;
        while (status == SALTUS_OK && goes && saltus_returns_next(s.returns, p, &closest)) {
            goes = harvest->count < options->most && goes_on(&s, 0.5 + 0.5 * (p - 1) / options->longest);
            /* A trajectory much closer to a known orbit than to its own return only shadows that orbit. */
            if (goes && find_known(system, harvest, p, closest.state, 0.3 * closest.distance) < 0)
                status = try_guess(&s, p, closest.state, message);
        }
    }
    if (status == SALTUS_OK)
        status = arrange(&s, message);
    saltus_returns_free(s.returns);
    saltus_flow_free(s.flow);
    if (status != SALTUS_OK)
        saltus_harvest_clear(harvest);
    return status;
}

void saltus_harvest_clear(saltus_harvest *harvest) {
    for (int k = 0; k < harvest->count; k++)
        clear_orbit(&harvest->orbits[k]);
    free(harvest->orbits);
    *harvest = (saltus_harvest){0};
}
