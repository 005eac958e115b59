/* Parameter columns: derivatives of the state with respect to a number on which the system depends.
 *
 * A parameter column holds y = dx / d lambda at fixed phase. Within a step the kernel integrates y' = Df y +
 * df / d lambda at fixed time since the step's begin. A step of fixed phase lasts h ~ 1 / omega, so a change
 * of the forcing's frequency adds -(h / omega) f d omega at its end. At an event the derivatives of the gap
 * and of the velocity law along lambda are added to those along the column; then the saltation of contact.c
 * applies unchanged. A held contact keeps y on the derivative of its constraint, n dq + dn q - dd = 0 and n
 * dv + dn v = 0.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include "base/dense.h"

#include <math.h>

/* A column's parameter; NULL for an ordinary tangent vector. */
static const saltus_parameter_column *parameter_of(const saltus_flow *flow, int column) {
    int direction = column - (flow->options.columns - flow->options.directions);
    return direction >= 0 ? &flow->parameter[direction] : NULL;
}

void saltus_directions_load(saltus_flow *flow) {
    for (int d = 0; d < flow->options.directions; d++) {
        saltus_parameter_column *own = &flow->parameter[d];
        saltus_variation_fill(&own->variation, flow->lane[0].system, &own->direction);
        flow->kernel->vary(&flow->work, 0, d, &own->variation);
        if (flow->radau)
            saltus_radau_vary(flow->radau, d, &own->variation);
    }
}

void saltus_directions_publish(saltus_flow *flow) {
    saltus_work *w = &flow->work;
    const saltus_lane *self = &flow->lane[0];
    double push[SALTUS_FACES_MAX * SALTUS_MODES_MAX], pull[SALTUS_FACES_MAX * SALTUS_MODES_MAX];
    int n = flow->dof, count = self->hold.count;
    for (int d = 0; w->vary.tilts && d < flow->options.directions; d++) {
        saltus_contact_map_vary(self->system, &self->hold, 0, &flow->parameter[d].variation, push, pull);
        for (int m = 0; m < count; m++)
            for (int i = 0; i < n; i++) {
                size_t place = saltus_work_place(w, 0, d * count + m, i, 0);
                w->vary.push[place] = push[m * n + i];
                w->vary.pull[place] = pull[m * n + i];
            }
    }
}

void saltus_columns_rephase(saltus_flow *flow, int lane, double step) {
    const saltus_lane *self = &flow->lane[lane];
    bool known = false;
    for (int c = flow->options.columns - flow->options.directions; c < flow->options.columns; c++) {
        double rate = parameter_of(flow, c)->variation.omega, *delta = flow->trial;
        if (rate == 0)
            continue;
        if (!known)
            saltus_flow_field(flow, lane, flow->before);
        known = true;
        saltus_lane_gather(flow, lane, c + 1, delta);
        for (int i = 0; i < flow->dimension; i++)
            delta[i] = fma(-step / self->system->omega * rate, flow->before[i], delta[i]);
        saltus_lane_scatter(flow, lane, c + 1, delta);
    }
}

double saltus_column_normal(const saltus_flow *flow, int lane, int face, int column, const double *vector,
                            const double *delta) {
    const saltus_system *system = flow->lane[lane].system;
    const saltus_parameter_column *own = parameter_of(flow, column);
    saltus_face f = system->faces[face];
    double change = own ? f.side * saltus_dot(own->variation.normal[f.stop], vector, flow->dof) : 0;
    return saltus_face_normal(system, face, delta) + change;
}

double saltus_column_gap(const saltus_flow *flow, int lane, int face, int column) {
    const saltus_lane *self = &flow->lane[lane];
    const saltus_parameter_column *own = parameter_of(flow, column);
    const saltus_face f = self->system->faces[face];
    double moved = own ? own->variation.d[f.stop] - f.side * own->variation.offset[f.stop] : 0;
    return saltus_column_normal(flow, lane, face, column, flow->state,
                                flow->tangents + column * flow->dimension) -
           moved;
}

void saltus_column_impact(saltus_flow *flow, int lane, const saltus_contact_map *map, unsigned elastic,
                          const double *velocity, int column) {
    const saltus_lane *self = &flow->lane[lane];
    const saltus_parameter_column *own = parameter_of(flow, column);
    double *delta = flow->tangents + column * flow->dimension + flow->dof;
    double push[SALTUS_FACES_MAX * SALTUS_MODES_MAX], pull[SALTUS_FACES_MAX * SALTUS_MODES_MAX];
    int n = flow->dof;
    saltus_contact_map_carry(map, n, delta);
    if (!own)
        return;
    saltus_contact_map_vary(self->system, map, elastic, &own->variation, push, pull);
    for (int k = 0; k < map->count; k++) {
        double size = saltus_dot(map->pull + k * n, velocity, n),
               change = saltus_dot(pull + k * n, velocity, n);
        for (int i = 0; i < n; i++)
            delta[i] -= push[k * n + i] * size + map->push[k * n + i] * change;
    }
}

void saltus_column_settle(saltus_flow *flow, int lane, int column) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_contact_map *map = &self->hold;
    int n = flow->dof;
    double *delta = flow->tangents + column * flow->dimension, excess[SALTUS_FACES_MAX];
    if (!parameter_of(flow, column)) {
        saltus_contact_map_apply(map, n, delta);
        saltus_contact_map_apply(map, n, delta + n);
        return;
    }
    for (int k = 0; k < map->count; k++)
        excess[k] = saltus_column_gap(flow, lane, map->face[k], column);
    saltus_contact_map_share_out(map, n, excess, delta);
    for (int k = 0; k < map->count; k++)
        excess[k] = saltus_column_normal(flow, lane, map->face[k], column, flow->state + n, delta + n);
    saltus_contact_map_share_out(map, n, excess, delta + n);
}

double saltus_column_observer(const saltus_flow *flow, int column, const double *vector) {
    const saltus_parameter_column *own = parameter_of(flow, column);
    return own ? saltus_dot(own->variation.observer, vector, flow->dof) : 0;
}
