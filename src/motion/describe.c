/* What is said of an orbit or a rest: its contact events, section points and extremes once around, its name,
 * its symmetry.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A rest that Newton's method moves further than this, relative to the system's scales, is another one. */
static const double same_rest = 3e-3;
static const double same_image = 1e-7; /* a mirror image that is the orbit itself */

/* Multipliers inside the unit circle, by more than their own accuracy; one too small to be resolved is
 * inside. */
bool saltus_motion_stopped(const saltus_flow_options *options) {
    return options->stop && *options->stop;
}

bool saltus_motion_orbit_stable(const saltus_orbit *orbit) {
    for (int i = 0; i < orbit->dimension; i++)
        if (orbit->multipliers[i].log_modulus >= -1e-10)
            return false;
    return true;
}

/* Newton can ask for no more than the flow's tolerance gives. */
saltus_orbit_options saltus_motion_shooting(const saltus_classify_options *options) {
    saltus_orbit_options shooting = saltus_orbit_defaults();
    shooting.flow = options->flow;
    shooting.tolerance = fmax(1e-12, 100 * options->flow.rtol);
    return shooting;
}

/* Room for one event more. */
static bool append_event(saltus_motion *motion, const saltus_event *event) {
    if ((motion->event_count & (motion->event_count - 1)) == 0) {
        size_t room = motion->event_count ? 2 * (size_t)motion->event_count : 1;
        saltus_event *grown = realloc(motion->events, room * sizeof *grown);
        if (!grown)
            return false;
        motion->events = grown;
    }
    motion->events[motion->event_count++] = *event;
    return true;
}

bool saltus_event_strikes(const saltus_event *event) {
    return (event->kind == SALTUS_IMPACT || event->kind == SALTUS_STICK) && event->velocity_before != 0;
}

void saltus_tally_event(saltus_tally *tally, const saltus_system *system, const saltus_event *event) {
    if (event->kind != SALTUS_IMPACT && event->kind != SALTUS_STICK && event->kind != SALTUS_RELEASE)
        return;
    tally->events++;
    tally->sticks += event->kind == SALTUS_STICK;
    tally->releases += event->kind == SALTUS_RELEASE;
    if (event->kind != SALTUS_IMPACT)
        tally->rebounds |= saltus_system_face(system, event->face).r > 0;
    /* More than a stick and its release: the impacts before it may lie at the end, before the section. */
    tally->chatter = tally->rebounds && tally->events > 2;
    if (saltus_event_strikes(event)) {
        tally->impacts++;
        tally->by_face[event->face]++;
    }
}

static void see_displacement(const saltus_system *system, const double *state, saltus_motion *motion) {
    const double *observer = saltus_system_observer(system);
    double g = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        g = fma(observer[i], state[i], g);
    motion->largest = fmax(motion->largest, g);
    motion->smallest = fmin(motion->smallest, g);
}

/* A turning point or a contact event: how far the observed displacement goes there. */
static void see_event(const saltus_system *system, const saltus_flow *flow, const saltus_event *event,
                      saltus_motion *motion) {
    double after[SALTUS_STATE_MAX];
    if (event->kind == SALTUS_TURNING || saltus_system_face(system, event->face).stop == 0) {
        motion->largest = fmax(motion->largest, event->displacement);
        motion->smallest = fmin(motion->smallest, event->displacement);
        return;
    }
    saltus_flow_state(flow, 0, after);
    see_displacement(system, after, motion);
}

/* Once around the orbit from its section point: events, section points, extremes. */
static saltus_status walk_orbit(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                saltus_tally *tally, saltus_message *message) {
    size_t n = (size_t)motion->dimension;
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, motion->state, message);
    motion->largest = -INFINITY;
    motion->smallest = INFINITY;
    see_displacement(system, motion->state, motion);
    for (int k = 0; k < motion->periods && status == SALTUS_OK;) {
        saltus_event event;
        status = saltus_flow_advance(flow, (saltus_time){k + 1, 0},
                                     SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING, &event, message);
        if (status != SALTUS_OK)
            break;
        double *point = motion->section_states + (size_t)((k + 1) % motion->periods) * n;
        if (event.kind == SALTUS_REACHED) {
            if (++k < motion->periods)
                saltus_flow_state(flow, 0, point);
        } else if (event.kind == SALTUS_TURNING)
            see_event(system, flow, &event, motion);
        else {
            see_event(system, flow, &event, motion);
            if (!append_event(motion, &event))
                return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the events");
            saltus_tally_event(tally, system, &event);
        }
    }
    return status;
}

/* The mirror image of a state after `later` of the flow, in a scene with that symmetry. */
static saltus_status mirror_after(const saltus_system *system, saltus_flow *flow, const double *state,
                                  saltus_time later, double *image, saltus_message *message) {
    saltus_event event;
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    if (status == SALTUS_OK && saltus_time_periods(later) > 0)
        status = saltus_flow_advance(flow, later, 0, &event, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_state(flow, 0, image);
    for (int i = 0; i < saltus_system_dimension(system); i++)
        image[i] = -image[i];
    return SALTUS_OK;
}

/* q(t + pT/2) = -q(t), where half the orbit is an allowed shift: p even for a pulsation, odd for a direct
 * force. */
static saltus_status find_mirror(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                 saltus_message *message) {
    bool shift, symmetric = saltus_system_mirror_symmetric(system, &shift);
    motion->mirror = symmetric ? SALTUS_MIRROR_PAIR : SALTUS_MIRROR_NONE;
    int n = motion->dimension;
    double image[SALTUS_STATE_MAX];
    for (int i = 0; i < n; i++)
        image[i] = -motion->state[i];
    bool at_centre = !shift && saltus_section_distance(system, image, motion->state) < same_image;
    if (symmetric && at_centre)
        motion->mirror = SALTUS_MIRROR_SELF;
    if (!symmetric || at_centre || (motion->periods % 2 == 1) != shift)
        return SALTUS_OK;
    saltus_time half = {motion->periods / 2, shift ? 0.5 : 0};
    saltus_status status = mirror_after(system, flow, motion->state, half, image, message);
    if (status == SALTUS_OK && saltus_section_distance(system, image, motion->state) < same_image)
        motion->mirror = SALTUS_MIRROR_SELF;
    return status;
}

static void write_label(saltus_motion *motion, bool chatter) {
    size_t room = sizeof motion->label;
    if (motion->kind == SALTUS_EQUILIBRIUM)
        snprintf(motion->label, room, "equilibrium");
    else if (motion->kind == SALTUS_HELD)
        snprintf(motion->label, room, "held");
    else if (motion->kind == SALTUS_QUASIPERIODIC)
        snprintf(motion->label, room, "quasi-periodic");
    else if (motion->kind == SALTUS_CHAOTIC)
        snprintf(motion->label, room, "chaotic");
    else if (motion->kind == SALTUS_UNSETTLED)
        snprintf(motion->label, room, motion->evidence.left ? "transient" : "long-period");
    else if (motion->kind == SALTUS_UNDECIDED)
        snprintf(motion->label, room, "undecided");
    else if (chatter) {
        snprintf(motion->label, room, "chatter/%d", motion->periods);
        motion->impacts = -1;
    } else
        snprintf(motion->label, room, "%lld/%d", motion->impacts, motion->periods);
}

/* Force per modal mass of the contacts that hold at the motion's state. */
static saltus_status measure_forces(const saltus_system *system, const saltus_classify_options *options,
                                    saltus_motion *motion, saltus_message *message) {
    saltus_flow *flow = NULL;
    saltus_status status = saltus_flow_new(&system, 1, &options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, motion->state, message);
    if (status == SALTUS_OK)
        saltus_flow_forces(flow, 0, motion->contact_force);
    saltus_flow_free(flow);
    return status;
}

bool saltus_motion_open(const saltus_system *system, const saltus_flow_options *flow, saltus_motion *motion) {
    *motion = (saltus_motion){.kind = SALTUS_UNDECIDED,
                              .dimension = saltus_system_dimension(system),
                              .lyapunov = NAN,
                              .lyapunov_error = NAN,
                              .integrator = flow->integrator,
                              .face_count = saltus_system_face_count(system)};
    saltus_motion_forget_evidence(motion);
    motion->state = calloc((size_t)motion->dimension, sizeof *motion->state);
    return motion->state;
}

/* Copy what Newton's method and the multipliers say. */
static bool take_orbit(const saltus_orbit *orbit, double period, saltus_motion *motion) {
    size_t n = (size_t)orbit->dimension;
    motion->kind = SALTUS_PERIODIC;
    motion->periods = orbit->periods;
    motion->residual = orbit->residual;
    motion->iterations = orbit->iterations;
    motion->sticks = orbit->sticks;
    motion->log_volume = orbit->log_volume;
    motion->sum_rule = orbit->sum_rule;
    motion->stable = saltus_motion_orbit_stable(orbit);
    motion->multiplier_count = orbit->dimension;
    motion->multipliers = calloc(n, sizeof *motion->multipliers);
    motion->section_states = calloc(n * (size_t)motion->periods, sizeof *motion->section_states);
    if (!motion->multipliers || !motion->section_states)
        return false;
    memcpy(motion->multipliers, orbit->multipliers, n * sizeof *motion->multipliers);
    memcpy(motion->state, orbit->state, n * sizeof *motion->state);
    memcpy(motion->section_states, orbit->state, n * sizeof *motion->state);
    saltus_motion_forget_evidence(motion);
    motion->reason[0] = 0;
    motion->lyapunov = orbit->multipliers[0].log_modulus / (motion->periods * period);
    motion->lyapunov_error = 0;
    return true;
}

saltus_status saltus_motion_take(const saltus_system *system, saltus_flow *flow, const saltus_orbit *orbit,
                                 const saltus_classify_options *options, saltus_motion *motion,
                                 saltus_message *message) {
    saltus_tally tally = {0};
    if (!take_orbit(orbit, saltus_system_period(system), motion))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the orbit");
    saltus_status status = walk_orbit(system, flow, motion, &tally, message);
    motion->impacts = tally.impacts;
    /* A start on the section may come to rest at once, without an event; what is released has been held. */
    motion->sticking_intervals = tally.sticks > tally.releases ? tally.sticks : tally.releases;
    memcpy(motion->impacts_by_face, tally.by_face, sizeof tally.by_face);
    if (status == SALTUS_OK && motion->event_count == 0 && saltus_flow_contacts(flow, 0)) {
        motion->kind = SALTUS_HELD;
        status = measure_forces(system, options, motion, message);
    }
    if (status == SALTUS_OK)
        status = find_mirror(system, flow, motion, message);
    write_label(motion, tally.chatter);
    return status;
}

/* The least divisor of the orbit's period after which its section points repeat. */
static int repeats_after(const saltus_system *system, const saltus_classify_options *options,
                         const saltus_motion *motion) {
    double same = fmax(1e-8, 1e4 * options->flow.rtol);
    for (int p = 1; p <= motion->periods / 2; p++)
        if (motion->periods % p == 0 &&
            saltus_section_distance(system, motion->section_states + (size_t)(p * motion->dimension),
                                    motion->state) < same)
            return p;
    return motion->periods;
}

/* Describe an orbit; its least period goes to *least. */
static saltus_status describe(const saltus_system *system, const saltus_orbit *orbit,
                              const saltus_classify_options *options, saltus_motion *motion, int *least,
                              saltus_message *message) {
    saltus_flow_options flow_options = options->flow;
    saltus_flow *flow = NULL;
    flow_options.columns = 0;
    flow_options.directions = 0;
    saltus_status status = saltus_flow_new(&system, 1, &flow_options, &flow, message);
    if (status == SALTUS_OK && !saltus_motion_open(system, &options->flow, motion))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the orbit");
    if (status == SALTUS_OK)
        status = saltus_motion_take(system, flow, orbit, options, motion, message);
    if (status == SALTUS_OK)
        *least = repeats_after(system, options, motion);
    saltus_flow_free(flow);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}

saltus_status saltus_motion_describe(const saltus_system *system, const saltus_orbit *orbit,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     saltus_message *message) {
    int least = 0, same;
    *motion = (saltus_motion){0};
    saltus_status status = describe(system, orbit, options, motion, &least, message);
    if (status != SALTUS_OK || least == orbit->periods)
        return status;
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    saltus_orbit shorter = {0};
    saltus_motion_clear(motion);
    status = saltus_orbit_find(system, least, orbit->state, &shooting, &shorter, message);
    if (status == SALTUS_OK)
        status = describe(system, &shorter, options, motion, &same, message);
    saltus_orbit_clear(&shorter);
    return status;
}

saltus_status saltus_motion_mirror(const saltus_system *system, const saltus_flow_options *options,
                                   double *state, saltus_message *message) {
    bool shift;
    if (!saltus_system_mirror_symmetric(system, &shift))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the scene has no mirror symmetry");
    saltus_flow_options plain = *options;
    saltus_flow *flow = NULL;
    plain.columns = 0;
    plain.directions = 0;
    saltus_status status = saltus_flow_new(&system, 1, &plain, &flow, message);
    if (status == SALTUS_OK)
        status = mirror_after(system, flow, state, (saltus_time){0, shift ? 0.5 : 0}, state, message);
    saltus_flow_free(flow);
    return status;
}

saltus_status saltus_motion_settle(const saltus_system *system, const saltus_flow_options *options,
                                   long long periods, double *state, saltus_message *message) {
    saltus_flow_options plain = *options;
    saltus_flow *flow = NULL;
    saltus_event event;
    plain.columns = 0;
    plain.directions = 0;
    saltus_status status = saltus_flow_new(&system, 1, &plain, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    if (status == SALTUS_OK && periods > 0)
        status = saltus_flow_advance(flow, (saltus_time){periods, 0}, 0, &event, message);
    if (status == SALTUS_OK)
        saltus_flow_state(flow, 0, state);
    saltus_flow_free(flow);
    return status;
}

/* A rest is a fixed point of the map over any time: polished as one, its multipliers decide on stability.
 * Where Newton's matrix is singular (a continuum of rests) the state stays as found and is not called stable.
 */
static saltus_status polish_rest(const saltus_system *system, const saltus_classify_options *options,
                                 saltus_motion *motion, saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    saltus_orbit rest = {0};
    saltus_status status = saltus_orbit_find(system, 1, motion->state, &shooting, &rest, message);
    if (status == SALTUS_OK && saltus_section_distance(system, rest.state, motion->state) < same_rest) {
        memcpy(motion->state, rest.state, (size_t)motion->dimension * sizeof *motion->state);
        motion->stable = saltus_motion_orbit_stable(&rest);
        motion->residual = rest.residual;
        motion->iterations = rest.iterations;
        motion->lyapunov = rest.multipliers[0].log_modulus / saltus_system_period(system);
        motion->lyapunov_error = 0;
    }
    saltus_orbit_clear(&rest);
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}

saltus_status saltus_motion_rest(const saltus_system *system, saltus_flow *flow,
                                 const saltus_classify_options *options, saltus_motion *motion,
                                 saltus_message *message) {
    bool shift;
    saltus_status status = SALTUS_OK;
    saltus_flow_state(flow, 0, motion->state);
    if (motion->kind != SALTUS_UNDECIDED)
        status = polish_rest(system, options, motion, message);
    motion->largest = -INFINITY;
    motion->smallest = INFINITY;
    see_displacement(system, motion->state, motion);
    if (motion->kind != SALTUS_UNDECIDED) {
        motion->mirror =
            saltus_system_mirror_symmetric(system, &shift) ? SALTUS_MIRROR_PAIR : SALTUS_MIRROR_NONE;
        if (fabs(motion->largest) < 1e-9 * saltus_system_scale(system)[0] &&
            motion->mirror == SALTUS_MIRROR_PAIR)
            motion->mirror = SALTUS_MIRROR_SELF;
    }
    if (status == SALTUS_OK && motion->kind == SALTUS_HELD)
        status = measure_forces(system, options, motion, message);
    write_label(motion, false);
    return status;
}

saltus_status saltus_motion_survey(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                   saltus_message *message) {
    enum { periods = 400 };
    saltus_event event = {.kind = SALTUS_STEP};
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, motion->state, message);
    motion->largest = -INFINITY;
    motion->smallest = INFINITY;
    see_displacement(system, motion->state, motion);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED) {
        status = saltus_flow_advance(flow, (saltus_time){periods, 0},
                                     SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING, &event, message);
        if (status == SALTUS_OK && event.kind != SALTUS_REACHED)
            see_event(system, flow, &event, motion);
    }
    write_label(motion, false);
    /* The verdict stands without the last extremes. */
    return status == SALTUS_INTERRUPTED ? SALTUS_OK : status;
}

void saltus_motion_clear(saltus_motion *motion) {
    free(motion->state);
    free(motion->section_states);
    free(motion->events);
    free(motion->multipliers);
    free(motion->evidence.history);
    *motion = (saltus_motion){0};
}

bool saltus_motion_settled(const saltus_motion *motion) {
    return motion->kind == SALTUS_PERIODIC || motion->kind == SALTUS_EQUILIBRIUM ||
           motion->kind == SALTUS_HELD;
}
