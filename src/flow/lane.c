/* What a flow tells about its lanes: states and tangent vectors in plain layout, dense output.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

const saltus_system *saltus_flow_system(const saltus_flow *flow, int lane) {
    return flow->lane[lane].system;
}
int saltus_flow_columns(const saltus_flow *flow) {
    return flow->options.columns;
}
saltus_time saltus_flow_time(const saltus_flow *flow, int lane) {
    return flow->lane[lane].now;
}
unsigned saltus_flow_contacts(const saltus_flow *flow, int lane) {
    return flow->lane[lane].contacts;
}
saltus_flow_info saltus_flow_information(const saltus_flow *flow, int lane) {
    return flow->lane[lane].info;
}
double saltus_flow_step_length(const saltus_flow *flow, int lane) {
    return flow->lane[lane].step;
}
saltus_time saltus_flow_step_begin(const saltus_flow *flow, int lane) {
    return flow->lane[lane].begin;
}

/* One column of the work's start rows to or from a plain vector. */
void saltus_lane_gather(const saltus_flow *flow, int lane, int column, double *vector) {
    const saltus_work *w = &flow->work;
    for (int i = 0; i < flow->dof; i++) {
        vector[i] = w->xq[column * w->row + i * w->stride + lane];
        vector[flow->dof + i] = w->xv[column * w->row + i * w->stride + lane];
    }
    for (int i = 0; i < flow->extra; i++)
        vector[2 * flow->dof + i] = w->xe[column * w->extra_row + i * w->stride + lane];
}

void saltus_lane_scatter(saltus_flow *flow, int lane, int column, const double *vector) {
    saltus_work *w = &flow->work;
    for (int i = 0; i < flow->dof; i++) {
        w->xq[column * w->row + i * w->stride + lane] = vector[i];
        w->xv[column * w->row + i * w->stride + lane] = vector[flow->dof + i];
    }
    for (int i = 0; i < flow->extra; i++)
        w->xe[column * w->extra_row + i * w->stride + lane] = vector[2 * flow->dof + i];
}

void saltus_lane_gather_all(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    saltus_lane_gather(flow, lane, 0, self->state);
    for (int c = 0; c < flow->options.columns; c++)
        saltus_lane_gather(flow, lane, c + 1, self->tangents + c * flow->dimension);
}

void saltus_lane_scatter_all(saltus_flow *flow, int lane) {
    const saltus_lane *self = &flow->lane[lane];
    saltus_lane_scatter(flow, lane, 0, self->state);
    for (int c = 0; c < flow->options.columns; c++)
        saltus_lane_scatter(flow, lane, c + 1, self->tangents + c * flow->dimension);
}

void saltus_flow_state(const saltus_flow *flow, int lane, double *state) {
    saltus_lane_gather(flow, lane, 0, state);
}

void saltus_flow_tangents(const saltus_flow *flow, int lane, double *tangents) {
    for (int c = 0; c < flow->options.columns; c++)
        saltus_lane_gather(flow, lane, c + 1, tangents + c * flow->dimension);
}

void saltus_flow_set_tangents(saltus_flow *flow, int lane, const double *tangents) {
    for (int c = 0; c < flow->options.columns; c++)
        saltus_lane_scatter(flow, lane, c + 1, tangents + c * flow->dimension);
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
    size_t orders = saltus_work_jet(w, 1, 0), extras = saltus_work_extra_jet(w, 1, 0);
    for (int i = 0; i < flow->dof; i++) {
        size_t place = (size_t)(i * w->stride + lane);
        state[i] = series_value(w->q + place, orders, w->order, since);
        state[flow->dof + i] = series_value(w->v + place, orders, w->order, since);
    }
    for (int i = 0; i < flow->extra; i++)
        state[2 * flow->dof + i] = series_value(w->e + i * w->stride + lane, extras, w->order, since);
}

int saltus_flow_state_at(const saltus_flow *flow, int lane, saltus_time time, double *state) {
    saltus_time begin = saltus_flow_step_begin(flow, lane);
    double length = saltus_flow_step_length(flow, lane),
           since = ((double)(time.cycle - begin.cycle) + (time.phase - begin.phase)) *
                   saltus_system_period(saltus_flow_system(flow, lane));
    int order = saltus_time_compare(time, saltus_flow_time(flow, lane));
    if (order <= 0)
        saltus_flow_dense(flow, lane, order < 0 && since < length ? since : length, state);
    return order;
}
