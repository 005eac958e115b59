/* Harvest of unstable periodic orbits: a trajectory's close returns, polished by increasing period, closest
 * first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/harvest.h"

#include "orbit/returns.h"
#include "system/state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

saltus_harvest_options saltus_harvest_defaults(void) {
    return (saltus_harvest_options){.flow = saltus_flow_defaults(),
                                    .longest = 8,
                                    .transient = 100,
                                    .periods = 5000,
                                    .recurrence = 0.1,
                                    .tries = 40,
                                    .most = 1000,
                                    .tolerance = 1e-11,
                                    .seed = 1};
}

static saltus_status initial_state(const saltus_system *system, const saltus_harvest_options *options,
                                   double *state, saltus_message *message) {
    if (options->state) {
        memcpy(state, options->state, (size_t)saltus_system_dimension(system) * sizeof *state);
        return SALTUS_OK;
    }
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    if (!rng)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a random state");
    gsl_rng_set(rng, options->seed);
    saltus_status status = saltus_state_random(system, rng, state, message);
    gsl_rng_free(rng);
    return status;
}

static bool goes_on(const saltus_harvest_options *options, double done) {
    bool stopped = options->flow.stop && *options->flow.stop;
    return !stopped && (!options->progress || options->progress(options->context, done));
}

/* The trajectory, period by period; the first half of the work. */
static saltus_status run_trajectory(const saltus_system *system, saltus_flow *flow,
                                    const saltus_harvest_options *options, saltus_returns *returns,
                                    saltus_harvest *harvest, saltus_message *message) {
    enum { between_reports = 256 };
    long long total = options->transient + options->periods;
    double state[SALTUS_STATE_MAX];
    saltus_status status = initial_state(system, options, state, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    for (long long k = 0; k < total && status == SALTUS_OK; k++) {
        saltus_event event;
        if (k % between_reports == 0 && !goes_on(options, 0.5 * (double)k / (double)total))
            break;
        status = saltus_flow_advance(flow, (saltus_time){k + 1, 0}, 0, &event, message);
        if (status != SALTUS_OK)
            break;
        saltus_flow_state(flow, 0, state);
        status = saltus_state_bounded(system, state, k + 1, message);
        harvest->periods = k + 1;
        if (k >= options->transient)
            saltus_returns_add(returns, state);
    }
    return status == SALTUS_INTERRUPTED ? SALTUS_OK : status;
}

static void clear_orbit(saltus_harvest_orbit *found) {
    saltus_orbit_clear(&found->orbit);
    free(found->section_states);
    *found = (saltus_harvest_orbit){0};
}

static int find_known(const saltus_system *system, const saltus_harvest *harvest, int periods,
                      const double *state, double distance) {
    for (int k = 0; k < harvest->count; k++)
        if (harvest->orbits[k].orbit.periods == periods &&
            saltus_orbit_passes(system, harvest->orbits[k].section_states, periods, state, distance))
            return k;
    return -1;
}

/* From a guess to an orbit of least period, walked; an empty one (periods 0) where Newton fails. Running out
 * of memory is the only error. */
static saltus_status polish(saltus_flow *flow, const saltus_harvest_options *options, int periods,
                            const double *guess, saltus_harvest_orbit *found, saltus_message *message) {
    enum { iterations_max = 10 }; /* a guess that needs more is none */
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_message reason;
    shooting.flow = options->flow;
    shooting.tolerance = options->tolerance;
    shooting.iterations = iterations_max;
    *found = (saltus_harvest_orbit){.mirror = -1};
    saltus_lap lap = {0};
    saltus_status status =
        saltus_return_polish(flow, periods, guess, &shooting, &found->orbit, &lap, &reason);
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

/* Take an orbit over into the list, or drop it where the list has it already or is full. */
static saltus_status sort_in(const saltus_system *system, const saltus_harvest_options *options,
                             saltus_harvest *harvest, saltus_harvest_orbit *found, saltus_message *message) {
    if (found->orbit.periods == 0 || harvest->count == options->most ||
        find_known(system, harvest, found->orbit.periods, found->orbit.state, SALTUS_SAME_POINT) >= 0) {
        clear_orbit(found);
        return SALTUS_OK;
    }
    if ((harvest->count & (harvest->count - 1)) == 0) {
        size_t room = harvest->count ? 2 * (size_t)harvest->count : 1;
        saltus_harvest_orbit *grown = realloc(harvest->orbits, room * sizeof *grown);
        if (!grown) {
            clear_orbit(found);
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d orbits", harvest->count + 1);
        }
        harvest->orbits = grown;
    }
    harvest->orbits[harvest->count++] = *found;
    return SALTUS_OK;
}

/* Polish a guess and take what comes of it; with symmetry its mirror image too. */
static saltus_status try_guess(const saltus_system *system, saltus_flow *flow,
                               const saltus_harvest_options *options, int periods, const double *guess,
                               saltus_harvest *harvest, saltus_message *message) {
    bool shift;
    double image[SALTUS_STATE_MAX];
    int before = harvest->count;
    saltus_harvest_orbit found;
    saltus_status status = polish(flow, options, periods, guess, &found, message);
    harvest->candidates++;
    harvest->converged += status == SALTUS_OK && found.orbit.periods > 0;
    if (status == SALTUS_OK)
        status = sort_in(system, options, harvest, &found, message);
    if (status != SALTUS_OK || harvest->count == before || !saltus_system_mirror_symmetric(system, &shift))
        return status;
    const saltus_harvest_orbit *taken = &harvest->orbits[before];
    saltus_time half = {0, shift ? 0.5 : 0};
    if (saltus_mirror_image(flow, taken->orbit.state, half, image, NULL) != SALTUS_OK ||
        saltus_orbit_passes(system, taken->section_states, taken->orbit.periods, image, SALTUS_SAME_POINT))
        return SALTUS_OK;
    status = polish(flow, options, taken->orbit.periods, image, &found, message);
    return status == SALTUS_OK ? sort_in(system, options, harvest, &found, message) : status;
}

/* All candidates, by period and distance; the second half of the work. */
static saltus_status polish_returns(const saltus_system *system, saltus_flow *flow,
                                    const saltus_harvest_options *options, saltus_returns *returns,
                                    saltus_harvest *harvest, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    for (int p = 1; p <= options->longest && status == SALTUS_OK; p++) {
        saltus_return closest;
        while (status == SALTUS_OK && saltus_returns_next(returns, p, &closest)) {
            if (harvest->count >= options->most || !goes_on(options, 0.5 + 0.5 * (p - 1) / options->longest))
                return SALTUS_OK;
            /* What recurs far less closely than it is near a known orbit shadows that one. */
            if (find_known(system, harvest, p, closest.state, 0.3 * closest.distance) < 0)
                status = try_guess(system, flow, options, p, closest.state, harvest, message);
        }
    }
    return status;
}

static int by_period(const void *a, const void *b) {
    const saltus_orbit *x = &((const saltus_harvest_orbit *)a)->orbit,
                       *y = &((const saltus_harvest_orbit *)b)->orbit;
    double difference = x->multipliers[0].log_modulus - y->multipliers[0].log_modulus;
    if (x->periods != y->periods)
        return x->periods - y->periods;
    if (fabs(difference) > 1e-6)
        return difference < 0 ? -1 : 1;
    /* Mirror images: their order must not hang on rounding. */
    for (int i = 0; i < x->dimension; i++)
        if (x->state[i] != y->state[i])
            return x->state[i] < y->state[i] ? -1 : 1;
    return 0;
}

/* Sort the list and join mirror images. */
static saltus_status arrange(const saltus_system *system, const saltus_harvest_options *options,
                             saltus_harvest *harvest, saltus_message *message) {
    bool shift;
    double image[SALTUS_STATE_MAX];
    saltus_flow_options flow_options = options->flow;
    saltus_flow *flow = NULL;
    if (harvest->count)
        qsort(harvest->orbits, (size_t)harvest->count, sizeof *harvest->orbits, by_period);
    if (!saltus_system_mirror_symmetric(system, &shift))
        return SALTUS_OK;
    flow_options.stop = NULL; /* what has been found is arranged in any case */
    saltus_status status = saltus_flow_single(system, 0, &flow_options, &flow, message);
    for (int k = 0; k < harvest->count && status == SALTUS_OK; k++) {
        const saltus_orbit *orbit = &harvest->orbits[k].orbit;
        status = saltus_mirror_image(flow, orbit->state, (saltus_time){0, shift ? 0.5 : 0}, image, message);
        if (status == SALTUS_OK)
            harvest->orbits[k].mirror = find_known(system, harvest, orbit->periods, image, SALTUS_SAME_POINT);
    }
    saltus_flow_free(flow);
    return status;
}

static saltus_status check_options(const saltus_system *system, const saltus_harvest_options *options,
                                   saltus_message *message) {
    enum { longest_max = 256, tries_max = 10000 };
    if (!saltus_system_forced(system))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "the scene has no forcing: its periodic orbits have no period to count in");
    if (options->longest < 1 || options->longest > longest_max)
        return saltus_fail(message, SALTUS_BAD_INPUT, "longest = %d: must be from 1 to %d", options->longest,
                           longest_max);
    if (options->transient < 0 || options->periods < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "transient must be at least 0, periods at least 1 (%lld, %lld)",
                           options->transient, options->periods);
    if (!(options->recurrence > 0) || !(options->tolerance > 0))
        return saltus_fail(message, SALTUS_BAD_INPUT, "recurrence and tolerance must be greater than 0");
    if (options->tries < 1 || options->tries > tries_max || options->most < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "tries must be from 1 to %d, most at least 1",
                           tries_max);
    return SALTUS_OK;
}

/* A caller who has once refused to go on is not asked again. */
typedef struct caller {
    const saltus_harvest_options *options;
    bool refused;
} caller;

static bool ask(void *context, double done) {
    caller *self = context;
    self->refused = self->refused || !self->options->progress(self->options->context, done);
    return !self->refused;
}

saltus_status saltus_harvest_run(const saltus_system *system, const saltus_harvest_options *wishes,
                                 saltus_harvest *harvest, saltus_message *message) {
    caller self = {.options = wishes};
    saltus_harvest_options asking = *wishes, *options = &asking;
    asking.progress = wishes->progress ? ask : NULL;
    asking.context = &self;
    *harvest = (saltus_harvest){.face_count = saltus_system_face_count(system),
                                .dimension = saltus_system_dimension(system)};
    saltus_status status = check_options(system, options, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow *flow = NULL;
    saltus_returns *returns = NULL;
    status = saltus_flow_single(system, 0, &options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_returns_new(system, options->longest, options->tries, options->recurrence, &returns,
                                    message);
    if (status == SALTUS_OK)
        status = run_trajectory(system, flow, options, returns, harvest, message);
    if (status == SALTUS_OK)
        status = polish_returns(system, flow, options, returns, harvest, message);
    if (status == SALTUS_OK)
        status = arrange(system, options, harvest, message);
    saltus_returns_free(returns);
    saltus_flow_free(flow);
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
