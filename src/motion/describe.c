/* The description of an orbit or a rest: its contact events, section points and extremes over one lap, its
 * label, its symmetry.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/effort.h"
#include "motion/motion.h"
#include "orbit/poincare.h"
#include "orbit/returns.h"
#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Relative to the system's scales. If Newton's method moves a rest further, it has found another one. */
static const double same_rest = 3e-3;
static const double same_image = 1e-7; /* a mirror image that is the orbit itself */

/* Whether q(t + pT/2) = -q(t). With forcing the symmetry must allow a shift by half the orbit's period: by
 * whole forcing periods, or by an odd number of half ones. */
static saltus_status find_mirror(const saltus_system *system, saltus_flow *flow, bool cycle,
                                 saltus_motion *motion, saltus_message *message) {
    bool shift, symmetric = saltus_system_mirror_symmetric(system, &shift);
    motion->mirror = symmetric ? SALTUS_MIRROR_PAIR : SALTUS_MIRROR_NONE;
    int n = motion->dimension;
    double image[SALTUS_STATE_MAX];
    for (int i = 0; i < n; i++)
        image[i] = -motion->state[i];
    bool at_centre = !shift && saltus_system_distance(system, image, motion->state) < same_image;
    if (symmetric && at_centre)
        motion->mirror = SALTUS_MIRROR_SELF;
    if (!symmetric || at_centre || (!cycle && (motion->periods % 2 == 1) != shift))
        return SALTUS_OK;
    saltus_time half = {cycle ? 0 : motion->periods / 2, cycle || shift ? 0.5 : 0};
    saltus_status status = saltus_mirror_image(flow, motion->state, half, image, message);
    if (status == SALTUS_OK && saltus_orbit_passes(system, motion->state, 1, image, same_image))
        motion->mirror = SALTUS_MIRROR_SELF;
    return status;
}

/* Forces of the contacts that hold at the motion's state. */
static saltus_status measure_forces(saltus_flow *flow, saltus_motion *motion, saltus_message *message) {
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, motion->state, message);
    if (status == SALTUS_OK)
        saltus_flow_forces(flow, 0, motion->contact_force);
    return status;
}

saltus_status saltus_motion_take(const saltus_system *system, saltus_flow *flow, const saltus_orbit *orbit,
                                 saltus_lap *lap, saltus_motion *motion, saltus_message *message) {
    const bool cycle = orbit->trivial != 0; /* its period is its own, not the forcing's */
    size_t n = (size_t)orbit->dimension;
    motion->periods = lap->periods;
    motion->residual = orbit->residual;
    motion->iterations = orbit->iterations;
    motion->sticks = orbit->sticks;
    motion->log_volume = orbit->log_volume;
    motion->sum_rule = orbit->sum_rule;
    motion->stable = saltus_multipliers_stable(orbit->multipliers, orbit->multiplier_count);
    motion->period = orbit->periods * saltus_system_period(system);
    motion->trivial_multiplier = orbit->trivial;
    motion->multiplier_count = orbit->multiplier_count;
    motion->multipliers = calloc(n, sizeof *motion->multipliers);
    if (!motion->multipliers)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the orbit");
    memcpy(motion->multipliers, orbit->multipliers,
           (size_t)orbit->multiplier_count * sizeof *motion->multipliers);
    memcpy(motion->state, orbit->state, n * sizeof *motion->state);
    saltus_motion_forget_evidence(motion);
    motion->reason[0] = 0;
    motion->lyapunov = orbit->multipliers[0].log_modulus / motion->period;
    motion->lyapunov_error = 0;
    motion->verdict = saltus_lap_held(lap) ? SALTUS_HELD : SALTUS_PERIODIC;
    motion->impacts = saltus_lap_impacts(lap);
    motion->sticking_intervals = saltus_lap_sticking(lap);
    memcpy(motion->impacts_by_face, lap->impacts_by_face, sizeof lap->impacts_by_face);
    motion->counted = motion->periods;
    motion->largest = lap->largest;
    motion->smallest = lap->smallest;
    motion->rms = saltus_lap_rms(lap);
    motion->section_states = lap->points;
    motion->events = lap->events;
    motion->event_count = lap->event_count;
    *lap = (saltus_lap){0};
    saltus_status status = SALTUS_OK;
    if (motion->verdict == SALTUS_HELD)
        status = measure_forces(flow, motion, message);
    if (status == SALTUS_OK)
        status = find_mirror(system, flow, cycle, motion, message);
    if (cycle)
        memcpy(motion->state, motion->section_states, n * sizeof *motion->state);
    saltus_verdict_label(motion->verdict, motion->impacts, motion->periods, motion->label);
    return status;
}

/* The motion of an orbit, on the flow's system; empty on failure. */
static saltus_status open_and_take(saltus_flow *flow, const saltus_orbit *orbit, saltus_lap *lap,
                                   const saltus_classify_options *options, saltus_motion *motion,
                                   saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    const saltus_status status = saltus_motion_open(system, &options->flow, motion)
                                     ? saltus_motion_take(system, flow, orbit, lap, motion, message)
                                     : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the orbit");
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}

saltus_status saltus_motion_describe(const saltus_system *system, const saltus_orbit *orbit,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    saltus_orbit shorter = {0};
    saltus_lap lap = {.keeps_events = true};
    saltus_flow *flow = NULL;
    *motion = (saltus_motion){0};
    saltus_status status = saltus_flow_single(system, 0, &options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_lap_around(&lap, flow, orbit->state, orbit->periods, message);
    int least = status == SALTUS_OK ? saltus_lap_least_period(&lap, &options->flow) : orbit->periods;
    if (least < orbit->periods)
        status = saltus_return_polish(flow, least, orbit->state, &shooting, &shorter, &lap, message);
    if (status == SALTUS_OK)
        status =
            open_and_take(flow, least < orbit->periods ? &shorter : orbit, &lap, options, motion, message);
    saltus_orbit_clear(&shorter);
    saltus_lap_close(&lap);
    saltus_flow_free(flow);
    return status;
}

saltus_status saltus_motion_cycle(const saltus_system *system, const double *guess,
                                  const saltus_classify_options *options, saltus_motion *motion,
                                  saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    saltus_orbit orbit = {0};
    saltus_lap lap = {.keeps_events = true};
    saltus_system *clocked = NULL;
    saltus_flow *flow = NULL;
    *motion = (saltus_motion){0};
    saltus_status status = saltus_cycle_polish(system, guess, &shooting, &orbit, &clocked, &lap, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(clocked, 0, &options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = open_and_take(flow, &orbit, &lap, options, motion, message);
    saltus_flow_free(flow);
    saltus_system_free(clocked);
    saltus_orbit_clear(&orbit);
    saltus_lap_close(&lap);
    return status;
}

saltus_status saltus_motion_cycle_after(const saltus_system *system, double periods, const double *guess,
                                        const saltus_classify_options *options, saltus_motion *motion,
                                        saltus_message *message) {
    saltus_system *counted = NULL;
    *motion = (saltus_motion){0};
    saltus_status status = saltus_system_clocked(
        system, saltus_spec_omega(saltus_system_spec(system)) / periods, &counted, message);
    if (status == SALTUS_OK)
        status = saltus_motion_cycle(counted, guess, options, motion, message);
    saltus_system_free(counted);
    return status;
}

saltus_status saltus_motion_count_returns(const saltus_system *system, const saltus_flow_options *options,
                                          saltus_motion *motion, saltus_system **counted,
                                          saltus_message *message) {
    saltus_lap lap = {.keeps_events = true};
    saltus_flow *flow = NULL;
    saltus_status status =
        saltus_system_clocked(system, 2 * M_PI * motion->periods / motion->period, counted, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(*counted, 0, options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_lap_around(&lap, flow, motion->state, motion->periods, message);
    if (status == SALTUS_OK) {
        free(motion->section_states);
        free(motion->events);
        motion->section_states = lap.points;
        motion->events = lap.events;
        motion->event_count = lap.event_count;
        lap = (saltus_lap){0};
    }
    saltus_lap_close(&lap);
    saltus_flow_free(flow);
    if (status != SALTUS_OK) {
        saltus_system_free(*counted);
        *counted = NULL;
    }
    return status;
}

saltus_status saltus_motion_polish(const saltus_system *system, int periods, const double *state, double near,
                                   const saltus_classify_options *options, saltus_motion *motion,
                                   saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    saltus_orbit orbit = {0};
    *motion = (saltus_motion){0};
    saltus_status status = saltus_orbit_find(system, periods, state, &shooting, &orbit, NULL);
    if (status == SALTUS_OK && saltus_multipliers_stable(orbit.multipliers, orbit.multiplier_count) &&
        saltus_orbit_passes(system, orbit.state, 1, state, near))
        status = saltus_motion_describe(system, &orbit, options, motion, NULL);
    saltus_orbit_clear(&orbit);
    return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "no memory for an orbit") : SALTUS_OK;
}

saltus_status saltus_motion_mirror(const saltus_system *system, const saltus_flow_options *options,
                                   double *state, saltus_message *message) {
    bool shift;
    if (!saltus_system_mirror_symmetric(system, &shift))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the scene has no mirror symmetry");
    saltus_flow *flow = NULL;
    saltus_status status = saltus_flow_single(system, 0, options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_mirror_image(flow, state, (saltus_time){0, shift ? 0.5 : 0}, state, message);
    saltus_flow_free(flow);
    return status;
}

saltus_status saltus_motion_settle(const saltus_system *system, const saltus_flow_options *options,
                                   long long periods, double *state, saltus_message *message) {
    saltus_flow *flow = NULL;
    saltus_effort effort;
    const saltus_flow_options own = saltus_effort_begin(options, system, &effort);
    saltus_status status = saltus_flow_single(system, 0, &own, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_state_carry(flow, (saltus_time){0, 0}, (saltus_time){periods, 0}, state, message);
    if (status == SALTUS_OK && periods > 0)
        status = saltus_state_load(system, state, saltus_flow_contacts(flow, 0), message);
    saltus_flow_free(flow);
    return status;
}

/* Take over what Newton's method has found, its eigenvalues included. */
static void take_rest(saltus_equilibrium *rest, saltus_motion *motion) {
    memcpy(motion->state, rest->state, (size_t)motion->dimension * sizeof *motion->state);
    motion->stable = rest->stable;
    motion->residual = rest->residual;
    motion->iterations = rest->iterations;
    motion->lyapunov = rest->eigenvalue_count ? rest->eigenvalues[0].re : -INFINITY;
    motion->lyapunov_error = 0;
    motion->eigenvalues = rest->eigenvalues;
    motion->eigenvalue_count = rest->eigenvalue_count;
    rest->eigenvalues = NULL;
}

/* Extremes, symmetry and label at motion->state. */
static void describe_rest(const saltus_system *system, saltus_motion *motion) {
    bool shift, rests = motion->verdict != SALTUS_UNDECIDED,
                symmetric = saltus_system_mirror_symmetric(system, &shift);
    motion->largest = motion->smallest = saltus_system_observed(system, motion->state);
    motion->rms = fabs(motion->largest);
    const double nothing[SALTUS_STATE_MAX] = {0};
    const bool upright = saltus_system_distance(system, motion->state, nothing) < 1e-9;
    if (symmetric)
        motion->mirror = !rests ? SALTUS_MIRROR_OPEN : upright ? SALTUS_MIRROR_SELF : SALTUS_MIRROR_PAIR;
    saltus_verdict_label(motion->verdict, motion->impacts, motion->periods, motion->label);
}

saltus_status saltus_motion_rest(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                 saltus_message *message) {
    saltus_status status = SALTUS_OK;
    saltus_flow_state(flow, 0, motion->state);
    if (motion->verdict != SALTUS_UNDECIDED) {
        /* Polish a rest with the contacts that hold there, and take its eigenvalues, if it is isolated. In a
         * continuum of rests the state stays as found and is not called stable. */
        const saltus_equilibrium_options how = saltus_equilibrium_defaults();
        saltus_equilibrium rest = {0};
        status = saltus_equilibrium_find(system, motion->state, &how, &rest, message);
        if (status == SALTUS_OK && rest.contacts == saltus_flow_contacts(flow, 0) &&
            saltus_system_distance(system, rest.state, motion->state) < same_rest)
            take_rest(&rest, motion);
        saltus_equilibrium_clear(&rest);
        status = status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
    }
    describe_rest(system, motion);
    return status == SALTUS_OK && motion->verdict == SALTUS_HELD ? measure_forces(flow, motion, message)
                                                                 : status;
}

saltus_status saltus_motion_equilibrium(const saltus_system *system, const double *guess,
                                        const saltus_classify_options *options, saltus_motion *motion,
                                        saltus_message *message) {
    const saltus_equilibrium_options how = saltus_equilibrium_defaults();
    saltus_equilibrium rest = {0};
    *motion = (saltus_motion){0};
    saltus_status status = saltus_equilibrium_find(system, guess, &how, &rest, message);
    if (status == SALTUS_OK && !saltus_motion_open(system, &options->flow, motion))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the equilibrium");
    if (status == SALTUS_OK) {
        motion->verdict = rest.contacts ? SALTUS_HELD : SALTUS_EQUILIBRIUM;
        memcpy(motion->contact_force, rest.contact_force, sizeof rest.contact_force);
        take_rest(&rest, motion);
        describe_rest(system, motion);
    }
    saltus_equilibrium_clear(&rest);
    return status;
}

saltus_status saltus_motion_survey(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                   saltus_message *message) {
    enum { periods = 400 };
    saltus_lap lap = {0};
    saltus_lap_begin(&lap, system, motion->state);
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, motion->state, message);
    if (status == SALTUS_OK)
        status = saltus_lap_run(&lap, flow, (saltus_time){periods, 0}, true, message);
    bool shift;
    motion->largest = lap.largest;
    motion->smallest = lap.smallest;
    motion->rms = saltus_lap_rms(&lap);
    motion->mirror = saltus_system_mirror_symmetric(system, &shift) ? SALTUS_MIRROR_OPEN : SALTUS_MIRROR_NONE;
    if (status == SALTUS_OK) {
        motion->impacts = saltus_lap_impacts(&lap) < 0 ? -1 : 0;
        memcpy(motion->impacts_by_face, lap.impacts_by_face, sizeof lap.impacts_by_face);
        motion->counted = periods;
    }
    saltus_verdict_label(motion->verdict, motion->impacts, motion->periods, motion->label);
    /* An interruption costs only the last extremes, not the verdict. */
    return status == SALTUS_INTERRUPTED ? SALTUS_OK : status;
}
