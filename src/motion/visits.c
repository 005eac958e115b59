/* Returns of an unforced trajectory to its section.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/visits.h"

#include "system/system.h"

#include <stdlib.h>

bool saltus_visits_open(saltus_visits *v, int dimension, int longest) {
    *v = (saltus_visits){0};
    bool sound = saltus_settling_open(&v->settling, dimension, longest);
    v->times = calloc((size_t)v->settling.size, sizeof *v->times);
    return sound && v->times;
}

void saltus_visits_close(saltus_visits *v) {
    saltus_settling_close(&v->settling);
    free(v->times);
    *v = (saltus_visits){0};
}

void saltus_visits_reset(saltus_visits *v, const saltus_system *system) {
    saltus_settling_reset(&v->settling, system, 0);
    v->returns = (saltus_crossings){0};
}

bool saltus_visits_next(saltus_visits *v, const saltus_flow *flow, int lane, saltus_flow_info done,
                        double *state) {
    saltus_time time;
    if (!saltus_crossings_count(&v->returns, flow, lane, state, &time))
        return false;
    v->times[v->settling.count % v->settling.size] = saltus_time_periods(time);
    saltus_settling_add(&v->settling, state, done.impacts, done.sticks + done.releases);
    return true;
}

double saltus_visits_last(const saltus_visits *v) {
    return v->times[(v->settling.count - 1) % v->settling.size];
}

double saltus_visits_taken(const saltus_visits *v, int returns) {
    long long now = v->settling.count - 1;
    return saltus_visits_last(v) - v->times[(now - returns) % v->settling.size];
}

saltus_status saltus_visits_count(const saltus_visits *v, const saltus_system *system,
                                  saltus_system **counted, saltus_message *message) {
    enum { few = 16 };
    const saltus_settling *r = &v->settling;
    *counted = NULL;
    if (r->count < few)
        return SALTUS_OK;
    int span = r->count <= r->size ? (int)r->count - 1 : r->size - 1;
    double omega = saltus_spec_omega(saltus_system_spec(system)) * span / saltus_visits_taken(v, span);
    return saltus_system_clocked(system, omega, counted, message);
}
