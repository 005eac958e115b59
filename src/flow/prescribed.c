/* Prescribed events: the flow through a sequence of events that is given, not found.
 *
 * Between prescribed events the stops are ignored, so everything here depends smoothly on the state, the
 * parameters and the event times, also through grazing. An event at time t requires an equation of the state
 * before it (gap or force is zero) and acts by its law P. A tangent vector passes it by DP at fixed t, and
 * delaying t changes the state after it at the rate DP f- - f+. Solving the equation for t turns these into
 * the saltation matrix of contact.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <math.h>
#include <string.h>

saltus_status saltus_flow_place(saltus_flow *flow, int lane, saltus_time time, const double *state,
                                unsigned contacts, saltus_message *message) {
    saltus_lane *self = &flow->lane[lane];
    saltus_status status = saltus_time_check(time, message);
    if (status == SALTUS_OK && contacts >> self->system->face_count)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "contacts = %#x: the scene has faces 0 to %d",
                             contacts, self->system->face_count - 1);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_restart(flow, lane, time, state);
    if (!saltus_contacts_set(flow, lane, contacts))
        return saltus_fail(message, SALTUS_STALLED, "these contacts cannot hold together");
    saltus_contact_map_settle(self->system, &self->hold, flow->state);
    saltus_lane_scatter_all(flow, lane);
    return SALTUS_OK;
}

saltus_status saltus_flow_coast_by_steps(saltus_flow *flow, int lane, saltus_time until,
                                         saltus_extreme *extremes, saltus_step_function *after, void *context,
                                         saltus_message *message) {
    saltus_lane *self = &flow->lane[lane];
    saltus_event event = {.kind = SALTUS_STEP};
    double ahead = saltus_time_between(self->now, until);
    if (!(ahead >= 0))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "prescribed events change their order");
    if (ahead == 0)
        return SALTUS_OK;
    self->target.coasting = true;
    self->target.since = self->now;
    self->target.extremes = extremes;
    saltus_status status = SALTUS_OK;
    while (status == SALTUS_OK && event.kind == SALTUS_STEP) {
        saltus_flow_aim(flow, lane, until, after ? SALTUS_WATCH_STEP : 0);
        status = saltus_flow_run(flow, &lane, &event, message);
        if (status == SALTUS_OK && event.kind == SALTUS_STEP)
            status = after(context, message);
    }
    self->target.coasting = false;
    return status;
}

saltus_status saltus_flow_coast(saltus_flow *flow, int lane, saltus_time until, saltus_extreme *extremes,
                                saltus_message *message) {
    return saltus_flow_coast_by_steps(flow, lane, until, extremes, NULL, NULL, message);
}

/* The release equation: the acceleration towards a held face if it were released, its rate, and its gradient
 * along the columns. The other contacts hold. */
static bool release_equation(saltus_flow *flow, int lane, int face, saltus_strike *strike) {
    saltus_lane *self = &flow->lane[lane];
    saltus_work *w = &flow->work;
    double acceleration[SALTUS_MODES_MAX], jerk[SALTUS_MODES_MAX], delta[SALTUS_MODES_MAX];
    unsigned contacts = self->hold.faces;
    if (!saltus_contacts_set(flow, lane, contacts & ~(1u << face)))
        return false;
    w->lane->phase[lane] = self->now.phase;
    flow->kernel->expand(w, 0, 2);
    for (int i = 0; i < flow->dof; i++) {
        acceleration[i] = w->jet.v[saltus_work_place(w, 1, 0, i, lane)];
        jerk[i] = 2 * w->jet.v[saltus_work_place(w, 2, 0, i, lane)];
    }
    strike->equation = saltus_face_normal(self->system, face, acceleration);
    strike->equation_rate = saltus_face_normal(self->system, face, jerk);
    for (int c = 0; c < flow->options.columns; c++) {
        for (int i = 0; i < flow->dof; i++)
            delta[i] = w->jet.v[saltus_work_place(w, 1, c + 1, i, lane)];
        strike->equation_gradient[c] = saltus_column_normal(flow, lane, face, c, acceleration, delta);
    }
    return saltus_contacts_set(flow, lane, contacts);
}

/* Apply the event's law to state and tangent vectors; flow->before becomes DP f-. */
static bool apply_law(saltus_flow *flow, int lane, saltus_event_kind kind, int face) {
    saltus_lane *self = &flow->lane[lane];
    int n = flow->dof;
    unsigned elastic = kind == SALTUS_IMPACT ? 1u << face : 0;
    double velocity[SALTUS_MODES_MAX];
    memset(self->face, 0, sizeof self->face);
    if (kind == SALTUS_RELEASE) {
        self->face[face].touch = 3; /* gap, its rate and its acceleration are zero */
        return saltus_contacts_set(flow, lane, self->hold.faces & ~(1u << face));
    }
    saltus_contact_map *map = &flow->scratch;
    if (!saltus_contact_map_build(self->system, self->hold.faces | 1u << face, elastic, flow->state + n, map))
        return false;
    memcpy(velocity, flow->state + n, (size_t)n * sizeof *velocity);
    saltus_contact_map_apply(map, n, flow->state + n);
    saltus_contact_map_carry(map, n, flow->before + n);
    for (int c = 0; c < flow->options.columns; c++)
        saltus_column_impact(flow, lane, map, elastic, velocity, c);
    if (kind == SALTUS_IMPACT) {
        self->face[face].touch = 1;
        return true;
    }
    /* A stick also puts displacements onto the stop: DP removes the approach from their rates. */
    memcpy(flow->before, flow->state + n, (size_t)n * sizeof *velocity);
    if (!saltus_contacts_set(flow, lane, self->hold.faces | 1u << face))
        return false;
    saltus_flow_keep_contacts(flow, lane);
    return true;
}

saltus_status saltus_flow_strike(saltus_flow *flow, int lane, saltus_event_kind kind, int face,
                                 saltus_strike *strike, saltus_message *message) {
    saltus_lane *self = &flow->lane[lane];
    saltus_lane_gather_all(flow, lane);
    saltus_field_at(flow, lane, flow->state, self->now.phase, &self->hold, flow->before);
    strike->speed = saltus_face_normal(self->system, face, flow->state + flow->dof);
    strike->speed_rate = saltus_face_normal(self->system, face, flow->before + flow->dof);
    for (int c = 0; strike->speed_gradient && c < flow->options.columns; c++)
        strike->speed_gradient[c] = saltus_column_normal(flow, lane, face, c, flow->state + flow->dof,
                                                         flow->tangents + c * flow->dimension + flow->dof);
    bool sound = true;
    if (kind == SALTUS_RELEASE) {
        sound = self->hold.faces >> face & 1 && release_equation(flow, lane, face, strike);
    } else {
        strike->equation = saltus_system_gap(self->system, face, flow->state);
        strike->equation_rate = strike->speed;
        for (int c = 0; c < flow->options.columns; c++)
            strike->equation_gradient[c] = saltus_column_gap(flow, lane, face, c);
    }
    if (!sound || !apply_law(flow, lane, kind, face))
        return saltus_fail(message, SALTUS_STALLED, "a prescribed event has no solution");
    saltus_field_at(flow, lane, flow->state, self->now.phase, &self->hold, flow->after);
    for (int i = 0; i < flow->dimension; i++)
        strike->shift[i] = flow->before[i] - flow->after[i];
    saltus_lane_scatter_all(flow, lane);
    saltus_flow_break(flow, false);
    return SALTUS_OK;
}
