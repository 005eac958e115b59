/* Harvest of unstable periodic orbits.
 *
 * A chaotic trajectory comes close to its unstable orbits: a point that almost recurs after p periods is a
 * guess for Newton's method (Auerbach et al., Phys. Rev. Lett. 58 (1987) 2387-2389). Every period of the
 * trajectory is compared with the `longest` ones before it; for each p the closest returns are kept, at most
 * a fixed number, so time and memory grow with the trajectory's length and with `longest` alone. A return
 * counts where its distance is a minimum along the trajectory, and smaller than after any divisor of p, which
 * would be a shorter orbit's. The candidates are polished by increasing period, closest first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/harvest.h"

#include "base/memory.h"

#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Section points of the same orbit agree to Newton's accuracy; distinct orbits do not. */
static const double same_point = 1e-6;

/* The close returns of a trajectory: the last points in a ring, the best returns of each period. Index p - 1
 * stands for period p. */
typedef struct close_returns {
    saltus_arena arena;
    int n, longest, slots, ring;
    long long count;
    double *points;              /* the ring */
    double *now, *last, *before; /* distances from the points p earlier, at the last three points */
    double *distance, *state;    /* of the returns kept: slots per period */
    int *used;                   /* slots in use */
} close_returns;

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

/* Largest difference of two states, each component relative to the system's scale; `sign` mirrors the first.
 */
static double distance_between(const saltus_system *system, double sign, const double *a, const double *b) {
    const double *scale = saltus_system_scale(system);
    double largest = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        largest = fmax(largest, fabs(sign * a[i] - b[i]) / scale[i]);
    return largest;
}

static void reserve(close_returns *r) {
    size_t n = (size_t)r->n, longest = (size_t)r->longest, slots = (size_t)r->slots;
    r->points = saltus_arena_doubles(&r->arena, n * (size_t)r->ring);
    r->now = saltus_arena_doubles(&r->arena, longest);
    r->last = saltus_arena_doubles(&r->arena, longest);
    r->before = saltus_arena_doubles(&r->arena, longest);
    r->distance = saltus_arena_doubles(&r->arena, longest * slots);
    r->state = saltus_arena_doubles(&r->arena, longest * slots * n);
    r->used = (int *)(void *)saltus_arena_doubles(&r->arena, longest);
}

static double *point_at(const close_returns *r, long long k) {
    return r->points + (size_t)(k % r->ring) * (size_t)r->n;
}

static double *state_at(const close_returns *r, int p, int slot) {
    return r->state + (size_t)((p - 1) * r->slots + slot) * (size_t)r->n;
}

static double *distance_at(const close_returns *r, int p, int slot) {
    return r->distance + (p - 1) * r->slots + slot;
}

/* Keep a return if it is among the closest. Of two that are nearer to each other than they recur, and so near
 * the same orbit, the closer one stays. */
static void keep(const saltus_system *system, close_returns *r, int p, double distance, const double *state) {
    int place = -1, farthest = 0, used = r->used[p - 1];
    for (int slot = 0; slot < used; slot++) {
        double between = distance_between(system, 1, state_at(r, p, slot), state);
        if (between <= fmax(distance, *distance_at(r, p, slot)))
            place = slot;
        if (*distance_at(r, p, slot) > *distance_at(r, p, farthest))
            farthest = slot;
    }
    if (place < 0)
        place = used < r->slots ? r->used[p - 1]++ : farthest;
    if (place < used && *distance_at(r, p, place) <= distance)
        return;
    *distance_at(r, p, place) = distance;
    memcpy(state_at(r, p, place), state, (size_t)r->n * sizeof *state);
}

/* Whether the return to the last point but one after p periods is a candidate. */
static bool is_candidate(const close_returns *r, int p, double recurrence) {
    double distance = r->last[p - 1];
    if (!(distance < recurrence && distance <= r->before[p - 1] && distance <= r->now[p - 1]))
        return false;
    for (int q = 1; q <= p / 2; q++)
        if (p % q == 0 && r->last[q - 1] <= distance)
            return false;
    return true;
}

/* Take the trajectory's next point, just written into the ring. */
static void take_point(const saltus_system *system, close_returns *r, double recurrence) {
    double *oldest = r->before;
    long long k = r->count++;
    r->before = r->last;
    r->last = r->now;
    r->now = oldest;
    for (int p = 1; p <= r->longest; p++)
        r->now[p - 1] = k >= p ? distance_between(system, 1, point_at(r, k), point_at(r, k - p)) : INFINITY;
    for (int p = 1; p <= r->longest && k > p + 1; p++)
        if (is_candidate(r, p, recurrence))
            keep(system, r, p, r->last[p - 1], point_at(r, k - 1 - p));
}

static saltus_status initial_state(const saltus_system *system, const saltus_harvest_options *options,
                                   double *state, saltus_message *message) {
    enum { tries_max = 10000 };
    int n = saltus_system_dimension(system), dof = saltus_system_dof(system);
    const double *scale = saltus_system_scale(system);
    if (options->state) {
        memcpy(state, options->state, (size_t)n * sizeof *state);
        return SALTUS_OK;
    }
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    if (!rng)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a random state");
    gsl_rng_set(rng, options->seed);
    bool admissible = false;
    for (int k = 0; k < tries_max && !admissible; k++) {
        for (int i = 0; i < n; i++)
            state[i] = gsl_ran_gaussian(rng, scale[i]);
        admissible = saltus_system_check_state(system, state, NULL) == SALTUS_OK;
    }
    saltus_status status = admissible ? SALTUS_OK : saltus_system_default_state(system, state, message);
    for (int i = dof; i < 2 * dof && !admissible; i++)
        state[i] = gsl_ran_gaussian(rng, scale[i]);
    gsl_rng_free(rng);
    return status;
}

static bool goes_on(const saltus_harvest_options *options, double done) {
    bool stopped = options->flow.stop && *options->flow.stop;
    return !stopped && (!options->progress || options->progress(options->context, done));
}

/* The trajectory, period by period; the first half of the work. */
static saltus_status run_trajectory(const saltus_system *system, const saltus_harvest_options *options,
                                    close_returns *r, saltus_harvest *harvest, saltus_message *message) {
    enum { between_reports = 256 };
    long long total = options->transient + options->periods;
    saltus_flow_options flow_options = options->flow;
    saltus_flow *flow = NULL;
    flow_options.columns = flow_options.directions = 0;
    saltus_status status = initial_state(system, options, r->points, message);
    if (status == SALTUS_OK)
        status = saltus_flow_new(&system, 1, &flow_options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, r->points, message);
    for (long long k = 0; k < total && status == SALTUS_OK; k++) {
        saltus_event event;
        double *point = point_at(r, r->count);
        if (k % between_reports == 0 && !goes_on(options, 0.5 * (double)k / (double)total))
            break;
        status = saltus_flow_advance(flow, (saltus_time){k + 1, 0}, 0, &event, message);
        if (status != SALTUS_OK)
            break;
        saltus_flow_state(flow, 0, point);
        for (int i = 0; i < r->n; i++)
            if (!(fabs(point[i]) < 1e8 * saltus_system_scale(system)[i]))
                status =
                    saltus_fail(message, SALTUS_STALLED,
                                "the motion grows without bound: %.3g after %lld periods", point[i], k + 1);
        harvest->periods = k + 1;
        if (k >= options->transient)
            take_point(system, r, options->recurrence);
    }
    saltus_flow_free(flow);
    return status == SALTUS_INTERRUPTED ? SALTUS_OK : status;
}

/* Impacts, and sticking after complete chatter, which makes them infinite. */
static void count_event(const saltus_system *system, const saltus_event *event, saltus_harvest_orbit *found) {
    bool impact = event->kind != SALTUS_RELEASE && event->velocity_before != 0;
    found->sticking_intervals += event->kind == SALTUS_STICK;
    found->impacts_by_face[event->face] += impact;
    if (impact && found->impacts >= 0)
        found->impacts++;
    if (impact && event->kind == SALTUS_STICK && saltus_system_face(system, event->face).r > 0)
        found->impacts = -1;
}

/* Once around the orbit: section points and contact events. */
static saltus_status walk_orbit(const saltus_system *system, saltus_flow *flow, saltus_harvest_orbit *found,
                                saltus_message *message) {
    size_t n = (size_t)found->orbit.dimension;
    int periods = found->orbit.periods;
    found->section_states = calloc(n * (size_t)periods, sizeof *found->section_states);
    if (!found->section_states)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for an orbit");
    memcpy(found->section_states, found->orbit.state, n * sizeof *found->section_states);
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, found->orbit.state, message);
    for (int k = 0; k < periods && status == SALTUS_OK;) {
        saltus_event event;
        status = saltus_flow_advance(flow, (saltus_time){k + 1, 0}, SALTUS_WATCH_CONTACT, &event, message);
        if (status == SALTUS_OK && event.kind != SALTUS_REACHED)
            count_event(system, &event, found);
        else if (++k < periods)
            saltus_flow_state(flow, 0, found->section_states + (size_t)k * n);
    }
    return status;
}

static void clear_orbit(saltus_harvest_orbit *found) {
    saltus_orbit_clear(&found->orbit);
    free(found->section_states);
    *found = (saltus_harvest_orbit){0};
}

/* The least divisor of the period after which the orbit already closes. */
static int least_period(const saltus_system *system, const saltus_harvest_orbit *found) {
    int periods = found->orbit.periods, n = found->orbit.dimension;
    for (int p = 1; p <= periods / 2; p++)
        if (periods % p == 0 && distance_between(system, 1, found->section_states + (size_t)(p * n),
                                                 found->section_states) < same_point)
            return p;
    return periods;
}

/* Whether the orbit passes nearer than `distance` to a state at section phase 0. */
static bool passes(const saltus_system *system, const saltus_harvest_orbit *found, const double *state,
                   double distance) {
    for (int k = 0; k < found->orbit.periods; k++)
        if (distance_between(system, 1, found->section_states + (size_t)(k * found->orbit.dimension), state) <
            distance)
            return true;
    return false;
}

static int find_known(const saltus_system *system, const saltus_harvest *harvest, int periods,
                      const double *state, double distance) {
    for (int k = 0; k < harvest->count; k++)
        if (harvest->orbits[k].orbit.periods == periods &&
            passes(system, &harvest->orbits[k], state, distance))
            return k;
    return -1;
}

/* From a guess to an orbit of least period, walked; an empty one (periods 0) where Newton fails. Running out
 * of memory is the only error. */
static saltus_status polish(const saltus_system *system, saltus_flow *flow,
                            const saltus_harvest_options *options, int periods, const double *guess,
                            saltus_harvest_orbit *found, saltus_message *message) {
    enum { iterations_max = 10 }; /* a guess that needs more is none */
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_message reason;
    shooting.flow = options->flow;
    shooting.tolerance = options->tolerance;
    shooting.iterations = iterations_max;
    *found = (saltus_harvest_orbit){.mirror = -1};
    saltus_status status = saltus_orbit_find(system, periods, guess, &shooting, &found->orbit, &reason);
    if (status == SALTUS_OK)
        status = walk_orbit(system, flow, found, &reason);
    int least = status == SALTUS_OK ? least_period(system, found) : periods;
    if (status == SALTUS_OK && least < periods) {
        saltus_harvest_orbit longer = *found;
        status = polish(system, flow, options, least, longer.orbit.state, found, message);
        clear_orbit(&longer);
        return status;
    }
    if (status != SALTUS_OK)
        clear_orbit(found);
    return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "%s", reason.text) : SALTUS_OK;
}

/* Take an orbit over into the list, or drop it where the list has it already or is full. */
static saltus_status sort_in(const saltus_system *system, const saltus_harvest_options *options,
                             saltus_harvest *harvest, saltus_harvest_orbit *found, saltus_message *message) {
    if (found->orbit.periods == 0 || harvest->count == options->most ||
        find_known(system, harvest, found->orbit.periods, found->orbit.state, same_point) >= 0) {
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

/* A point of the orbit's mirror image: -x, from half a period later where the symmetry needs that shift. */
static saltus_status mirror_image(const saltus_system *system, saltus_flow *flow, const double *state,
                                  double *image, saltus_message *message) {
    bool shift;
    saltus_event event;
    saltus_system_mirror_symmetric(system, &shift);
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    if (status == SALTUS_OK && shift)
        status = saltus_flow_advance(flow, (saltus_time){0, 0.5}, 0, &event, message);
    saltus_flow_state(flow, 0, image);
    for (int i = 0; i < saltus_system_dimension(system); i++)
        image[i] = -image[i];
    return status;
}

/* Polish a guess and take what comes of it; with symmetry its mirror image too. `image` has room for a state.
 */
static saltus_status try_guess(const saltus_system *system, saltus_flow *flow,
                               const saltus_harvest_options *options, int periods, const double *guess,
                               saltus_harvest *harvest, double *image, saltus_message *message) {
    bool shift;
    int before = harvest->count;
    saltus_harvest_orbit found;
    saltus_status status = polish(system, flow, options, periods, guess, &found, message);
    harvest->candidates++;
    harvest->converged += status == SALTUS_OK && found.orbit.periods > 0;
    if (status == SALTUS_OK)
        status = sort_in(system, options, harvest, &found, message);
    if (status != SALTUS_OK || harvest->count == before || !saltus_system_mirror_symmetric(system, &shift))
        return status;
    const saltus_harvest_orbit *taken = &harvest->orbits[before];
    if (mirror_image(system, flow, taken->orbit.state, image, NULL) != SALTUS_OK ||
        passes(system, taken, image, same_point))
        return SALTUS_OK;
    status = polish(system, flow, options, taken->orbit.periods, image, &found, message);
    return status == SALTUS_OK ? sort_in(system, options, harvest, &found, message) : status;
}

/* The closest return of a period that is still to be tried; -1 when none is left. */
static int closest_slot(const close_returns *r, int p) {
    int closest = -1;
    for (int slot = 0; slot < r->used[p - 1]; slot++)
        if (*distance_at(r, p, slot) < (closest < 0 ? INFINITY : *distance_at(r, p, closest)))
            closest = slot;
    return closest;
}

/* All candidates, by period and distance; the second half of the work. */
static saltus_status polish_returns(const saltus_system *system, const saltus_harvest_options *options,
                                    close_returns *r, saltus_harvest *harvest, saltus_message *message) {
    saltus_flow_options flow_options = options->flow;
    saltus_flow *flow = NULL;
    double *image = calloc((size_t)r->n, sizeof *image);
    flow_options.columns = flow_options.directions = 0;
    saltus_status status = image ? saltus_flow_new(&system, 1, &flow_options, &flow, message)
                                 : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the harvest");
    bool wanted = true;
    for (int p = 1; p <= r->longest && status == SALTUS_OK && wanted; p++)
        for (int slot = closest_slot(r, p); slot >= 0 && status == SALTUS_OK && wanted;
             slot = closest_slot(r, p)) {
            wanted = harvest->count < options->most && goes_on(options, 0.5 + 0.5 * (p - 1) / r->longest);
            /* What recurs far less closely than it is near a known orbit shadows that one. */
            double distance = 0.3 * *distance_at(r, p, slot);
            if (wanted && find_known(system, harvest, p, state_at(r, p, slot), distance) < 0)
                status = try_guess(system, flow, options, p, state_at(r, p, slot), harvest, image, message);
            *distance_at(r, p, slot) = INFINITY;
        }
    free(image);
    saltus_flow_free(flow);
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
    saltus_flow_options flow_options = options->flow;
    saltus_flow *flow = NULL;
    if (harvest->count)
        qsort(harvest->orbits, (size_t)harvest->count, sizeof *harvest->orbits, by_period);
    if (!saltus_system_mirror_symmetric(system, &shift))
        return SALTUS_OK;
    flow_options.columns = flow_options.directions = 0;
    flow_options.stop = NULL; /* what has been found is arranged in any case */
    double *image = calloc((size_t)harvest->dimension, sizeof *image);
    saltus_status status = image ? saltus_flow_new(&system, 1, &flow_options, &flow, message)
                                 : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the harvest");
    for (int k = 0; k < harvest->count && status == SALTUS_OK; k++) {
        const saltus_orbit *orbit = &harvest->orbits[k].orbit;
        status = mirror_image(system, flow, orbit->state, image, message);
        if (status == SALTUS_OK)
            harvest->orbits[k].mirror = find_known(system, harvest, orbit->periods, image, same_point);
    }
    free(image);
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
    close_returns r = {.n = harvest->dimension,
                       .longest = options->longest,
                       .slots = options->tries,
                       .ring = options->longest + 2};
    reserve(&r);
    if (!saltus_arena_open(&r.arena))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the harvest");
    reserve(&r);
    for (int p = 0; p < r.longest; p++)
        r.now[p] = r.last[p] = r.before[p] = INFINITY;
    status = run_trajectory(system, options, &r, harvest, message);
    if (status == SALTUS_OK)
        status = polish_returns(system, options, &r, harvest, message);
    if (status == SALTUS_OK)
        status = arrange(system, options, harvest, message);
    saltus_arena_close(&r.arena);
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
