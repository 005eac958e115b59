/* What a trajectory does while it is recorded: measures, counts and clouds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void add(saltus_watch *watch, saltus_cloud *cloud, const double *values, size_t count) {
    if (cloud->count + count > cloud->room) {
        size_t room = 2 * cloud->room + count + 64;
        double *grown = realloc(cloud->values, room * sizeof *grown);
        if (!grown) {
            watch->sound = false;
            return;
        }
        cloud->values = grown;
        cloud->room = room;
    }
    memcpy(cloud->values + cloud->count, values, count * sizeof *values);
    cloud->count += count;
}

static int heading_of(const saltus_watch *watch, const double *state) {
    const saltus_system *system = watch->lap.system;
    double velocity = saltus_system_observed(system, state + saltus_system_dof(system));
    return (velocity > 0) - (velocity < 0);
}

void saltus_watch_begin(saltus_watch *watch, const saltus_system *system, unsigned keep, saltus_time time,
                        const double *state, bool touching) {
    watch->keep = keep;
    watch->begin = watch->touched = time;
    watch->touching = touching;
    watch->contact = watch->largest_speed = 0;
    saltus_lap_begin(&watch->lap, system, state);
    watch->turning.count = watch->strobes.count = watch->impacts.count = 0;
    watch->sound = true;
    watch->heading = heading_of(watch, state);
    saltus_watch_section(watch, state);
}

unsigned saltus_watch_mask(void) {
    return SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING;
}

static double periods_between(saltus_time from, saltus_time to) {
    return (double)(to.cycle - from.cycle) + (to.phase - from.phase);
}

static void see_strike(saltus_watch *watch, const saltus_event *event) {
    const double values[] = {event->time.phase, event->velocity_before, event->face};
    watch->largest_speed = fmax(watch->largest_speed, fabs(event->velocity_before));
    if (watch->keep & SALTUS_KEEP_IMPACTS)
        add(watch, &watch->impacts, values, 3);
}

/* The observed displacement turns: by itself, or where an impact reverses its velocity. An impact on the
 * observed point's own stop is a turn by definition. */
static void see_turn(saltus_watch *watch, const saltus_event *event, const double *state) {
    bool contact = event->kind != SALTUS_TURNING;
    int heading =
        contact ? heading_of(watch, state) : (event->velocity_before > 0) - (event->velocity_before < 0);
    bool own = contact && saltus_system_face(watch->lap.system, event->face).stop == 0;
    bool turns = !contact || (own ? saltus_event_strikes(event) : heading * watch->heading < 0);
    double displacement = saltus_event_displacement(watch->lap.system, event, state);
    if (turns && watch->keep & SALTUS_KEEP_TURNING)
        add(watch, &watch->turning, &displacement, 1);
    watch->heading = heading;
}

void saltus_watch_event(saltus_watch *watch, const saltus_event *event, const double *state, bool touching) {
    saltus_lap_add(&watch->lap, event, state);
    if (saltus_event_strikes(event))
        see_strike(watch, event);
    see_turn(watch, event, state);
    if (event->kind != SALTUS_TURNING && touching != watch->touching) {
        if (watch->touching)
            watch->contact += periods_between(watch->touched, event->time);
        watch->touched = event->time;
        watch->touching = touching;
    }
}

void saltus_watch_section(saltus_watch *watch, const double *state) {
    if (watch->keep & SALTUS_KEEP_STROBOSCOPIC)
        add(watch, &watch->strobes, state, (size_t)saltus_system_dimension(watch->lap.system));
}

void saltus_watch_measure(const saltus_watch *watch, saltus_time end, const double *state,
                          saltus_sweep_row *row) {
    double length = periods_between(watch->begin, end), contact = watch->contact,
           last = saltus_system_observed(watch->lap.system, state);
    if (watch->touching)
        contact += periods_between(watch->touched, end);
    row->recorded = end.cycle - watch->begin.cycle;
    row->largest = fmax(watch->lap.largest, last);
    row->smallest = fmin(watch->lap.smallest, last);
    row->largest_speed = watch->largest_speed;
    row->impact_rate = (double)watch->lap.impacts / length;
    row->contact_fraction = contact / length;
}

void saltus_watch_close(saltus_watch *watch) {
    free(watch->turning.values);
    free(watch->strobes.values);
    free(watch->impacts.values);
    *watch = (saltus_watch){0};
}
