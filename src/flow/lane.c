/* Access to a flow's lanes: states and tangent vectors in plain layout, dense output.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/quiet.h"

const saltus_system *saltus_flow_system(const saltus_flow *flow, int lane) {
    return flow->lane[lane].system;
}
int saltus_flow_columns(const saltus_flow *flow) {
    return flow->options.columns;
}
saltus_time saltus_flow_time(const saltus_flow *flow, int lane) {
    return saltus_quiet_time(flow, lane);
}
unsigned saltus_flow_contacts(const saltus_flow *flow, int lane) {
    return flow->lane[lane].hold.faces;
}
saltus_flow_info saltus_flow_information(const saltus_flow *flow, int lane) {
    return saltus_quiet_information(flow, lane);
}
double saltus_flow_step_length(const saltus_flow *flow, int lane) {
    const saltus_lane_numbers *numbers = flow->work.lane;
    return numbers->taken[lane] > 0 ? numbers->advance[lane] : flow->lane[lane].step.length;
}
saltus_time saltus_flow_step_begin(const saltus_flow *flow, int lane) {
    const saltus_lane_numbers *numbers = flow->work.lane;
    saltus_time begin = saltus_quiet_time(flow, lane);
    if (numbers->taken[lane] == 0)
        return flow->lane[lane].step.begin;
    begin.cycle -= begin.phase < numbers->from[lane];
    begin.phase = numbers->from[lane];
    return begin;
}

void saltus_lane_gather(const saltus_flow *flow, int lane, int column, double *vector) {
    const saltus_work *w = &flow->work;
    for (int i = 0; i < flow->dof; i++) {
        vector[i] = w->state.q[saltus_work_place(w, 0, column, i, lane)];
        vector[flow->dof + i] = w->state.v[saltus_work_place(w, 0, column, i, lane)];
    }
    for (int i = 0; i < flow->extra; i++)
        vector[2 * flow->dof + i] = w->state.e[saltus_work_extra_place(w, 0, column, i, lane)];
}

void saltus_lane_scatter(saltus_flow *flow, int lane, int column, const double *vector) {
    saltus_work *w = &flow->work;
    for (int i = 0; i < flow->dof; i++) {
        w->state.q[saltus_work_place(w, 0, column, i, lane)] = vector[i];
        w->state.v[saltus_work_place(w, 0, column, i, lane)] = vector[flow->dof + i];
    }
    for (int i = 0; i < flow->extra; i++)
        w->state.e[saltus_work_extra_place(w, 0, column, i, lane)] = vector[2 * flow->dof + i];
}

void saltus_flow_state(const saltus_flow *flow, int lane, double *state) {
    saltus_lane_gather(flow, lane, 0, state);
}

void saltus_flow_tangents(const saltus_flow *flow, int lane, double *tangents) {
    for (int c = 0; c < flow->options.columns; c++)
        saltus_lane_gather(flow, lane, c + 1, tangents + c * flow->dimension);
}

static void scatter_tangents(saltus_flow *flow, int lane, const double *tangents) {
    for (int c = 0; c < flow->options.columns; c++)
        saltus_lane_scatter(flow, lane, c + 1, tangents + c * flow->dimension);
}

void saltus_flow_set_tangents(saltus_flow *flow, int lane, const double *tangents) {
    flow->lane[lane].settled = false;
    scatter_tangents(flow, lane, tangents);
}

void saltus_lane_gather_all(saltus_flow *flow, int lane) {
    saltus_flow_state(flow, lane, flow->state);
    saltus_flow_tangents(flow, lane, flow->tangents);
}

void saltus_lane_scatter_all(saltus_flow *flow, int lane) {
    saltus_lane_scatter(flow, lane, 0, flow->state);
    scatter_tangents(flow, lane, flow->tangents);
}

void saltus_flow_delays(const saltus_flow *flow, int lane, double *delays) {
    for (int c = 0; c < flow->options.columns; c++)
        delays[c] = flow->lane[lane].delay[c];
}

static double series_value(const double *series, size_t stride, int degree, double time) {
    double sum = 0;
    for (int k = degree; k >= 0; k--)
        sum = sum * time + series[(size_t)k * stride];
    return sum;
}

void saltus_flow_dense(const saltus_flow *flow, int lane, double since, double *state) {
    const saltus_work *w = &flow->work;
    const int degree = (int)w->lane->degree[lane];
    size_t orders = saltus_work_place(w, 1, 0, 0, 0), extras = saltus_work_extra_place(w, 1, 0, 0, 0);
    for (int i = 0; i < flow->dof; i++) {
        size_t place = saltus_work_place(w, 0, 0, i, lane);
        state[i] = series_value(w->jet.q + place, orders, degree, since);
        state[flow->dof + i] = series_value(w->jet.v + place, orders, degree, since);
    }
    for (int i = 0; i < flow->extra; i++)
        state[2 * flow->dof + i] =
            series_value(w->jet.e + saltus_work_extra_place(w, 0, 0, i, lane), extras, degree, since);
}

int saltus_flow_state_at(const saltus_flow *flow, int lane, saltus_time time, double *state) {
    const double length = saltus_flow_step_length(flow, lane), period = flow->lane[lane].system->period;
    const double since = saltus_time_between(saltus_flow_step_begin(flow, lane), time) * period;
    const int order = saltus_time_compare(time, saltus_flow_time(flow, lane));
    if (order <= 0)
        saltus_flow_dense(flow, lane, order < 0 && since < length ? since : length, state);
    return order;
}
