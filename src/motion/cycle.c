/* Orbits of scenes without forcing, whose period is unknown, found from a guess.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"
#include "orbit/poincare.h"
#include "system/system.h"

#include <math.h>
#include <stdlib.h>

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
    if (status == SALTUS_OK && !saltus_motion_open(system, &options->flow, motion))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the orbit");
    if (status == SALTUS_OK)
        status = saltus_motion_take(clocked, flow, &orbit, &lap, motion, message);
    saltus_flow_free(flow);
    saltus_system_free(clocked);
    saltus_orbit_clear(&orbit);
    saltus_lap_close(&lap);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
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
