/* What a trajectory does while it is recorded: measures, counts and clouds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "flow/flow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

size_t saltus_cloud_entry(int which, int dimension) {
    return which == SALTUS_CLOUD_TURNING   ? sizeof(double)
           : which == SALTUS_CLOUD_IMPACTS ? sizeof(saltus_sweep_impact)
                                           : (size_t)dimension * sizeof(double);
}

/* Add an entry to a cloud, if that cloud is kept. */
static void add(saltus_watch *watch, int which, const void *entry) {
    saltus_cloud *cloud = &watch->clouds[which];
    size_t size = saltus_cloud_entry(which, saltus_system_dimension(watch->lap.system));
    if (!(watch->keep >> which & 1))
        return;
    if (cloud->count == cloud->room) {
        size_t room = 2 * cloud->room + 64;
        void *grown = realloc(cloud->entries, room * size);
        if (!grown) {
            watch->sound = false;
            return;
        }
        cloud->entries = grown;
        cloud->room = room;
    }
    memcpy((char *)cloud->entries + cloud->count++ * size, entry, size);
}

static int sign_of(double velocity) {
    return (velocity > 0) - (velocity < 0);
}

static int heading_of(const saltus_system *system, const double *state) {
    return sign_of(saltus_system_observed(system, state + saltus_system_dof(system)));
}

void saltus_watch_begin(saltus_watch *watch, const saltus_system *system, unsigned keep, bool counts,
                        saltus_time time, const double *state, bool touching, double square) {
    watch->keep = keep;
    watch->begin = watch->touched = time;
    watch->touching = touching;
    watch->contact = watch->largest_speed = 0;
    watch->heading = heading_of(system, state);
    watch->sound = true;
    watch->counts = counts;
    watch->returns = (saltus_crossings){0};
    for (int k = 0; k < SALTUS_CLOUDS; k++)
        watch->clouds[k].count = 0;
    saltus_lap_begin(&watch->lap, system, state);
    watch->lap.square = -square;
    saltus_watch_section(watch, state);
}

/* Note a turning point of the observed displacement: a smooth one, or an impact that reverses its velocity.
 * An impact on the observed point's own stop always counts as one. */
static void see_turn(saltus_watch *watch, const saltus_event *event, const double *state) {
    const saltus_system *system = watch->lap.system;
    bool contact = event->kind != SALTUS_TURNING;
    int heading = contact ? heading_of(system, state) : sign_of(event->velocity_before);
    bool own = contact && saltus_system_stop_observed(system, saltus_system_face(system, event->face).stop);
    bool turns = !contact || (own ? saltus_event_strikes(event) : heading * watch->heading < 0);
    double displacement = saltus_event_displacement(system, event, state);
    if (turns)
        add(watch, SALTUS_CLOUD_TURNING, &displacement);
    watch->heading = heading;
}

void saltus_watch_event(saltus_watch *watch, const saltus_event *event, const double *state, bool touching) {
    saltus_lap_add(&watch->lap, event, state);
    if (saltus_event_strikes(event)) {
        const saltus_sweep_impact impact = {event->time.phase, event->velocity_before, event->face};
        watch->largest_speed = fmax(watch->largest_speed, fabs(impact.speed));
        add(watch, SALTUS_CLOUD_IMPACTS, &impact);
    }
    see_turn(watch, event, state);
    if (event->kind != SALTUS_TURNING && touching != watch->touching) {
        if (watch->touching)
            watch->contact += saltus_time_between(watch->touched, event->time);
        watch->touched = event->time;
        watch->touching = touching;
    }
}

void saltus_watch_turning(void *watch, double displacement, int heading) {
    const saltus_event event = {
        .kind = SALTUS_TURNING, .face = -1, .velocity_before = heading, .displacement = displacement};
    saltus_watch_event(watch, &event, NULL, false);
}

void saltus_watch_returns(saltus_watch *watch, const saltus_flow *flow, int lane, const saltus_event *event,
                          const double *now) {
    double state[SALTUS_STATE_MAX];
    saltus_time time;
    if (!watch->counts)
        return;
    memcpy(state, now, (size_t)saltus_system_dimension(watch->lap.system) * sizeof *state);
    saltus_crossings_take(&watch->returns, flow, lane, event, now);
    while (saltus_crossings_count(&watch->returns, flow, lane, state, &time))
        add(watch, SALTUS_CLOUD_STROBES, state);
}

void saltus_watch_section(saltus_watch *watch, const double *state) {
    if (!watch->counts)
        add(watch, SALTUS_CLOUD_STROBES, state);
}

void saltus_watch_orbit(saltus_watch *watch, const double *points, int periods) {
    watch->clouds[SALTUS_CLOUD_STROBES].count = 0;
    for (int k = 1; k <= periods; k++)
        add(watch, SALTUS_CLOUD_STROBES, points + k % periods * saltus_system_dimension(watch->lap.system));
}

void saltus_watch_measure(saltus_watch *watch, saltus_time end, const double *state, double square,
                          saltus_sweep_row *row) {
    double length = saltus_time_between(watch->begin, end), contact = watch->contact,
           last = saltus_system_observed(watch->lap.system, state);
    if (watch->touching)
        contact += saltus_time_between(watch->touched, end);
    row->recorded = end.cycle - watch->begin.cycle;
    row->largest = fmax(watch->lap.largest, last);
    row->smallest = fmin(watch->lap.smallest, last);
    watch->lap.square += square;
    watch->lap.watched = length;
    row->rms = saltus_lap_rms(&watch->lap);
    row->largest_speed = watch->largest_speed;
    row->impact_rate = (double)watch->lap.impacts / length;
    row->contact_fraction = contact / length;
}

void saltus_watch_close(saltus_watch *watch) {
    for (int k = 0; k < SALTUS_CLOUDS; k++)
        free(watch->clouds[k].entries);
    *watch = (saltus_watch){0};
}
