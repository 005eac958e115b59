/* The field and the contact forces at single points, by short series in the lanes' narrow works; that of
 * tangent vectors in the stepping work.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <string.h>

saltus_work *saltus_probe_at(saltus_flow *flow, int lane, const double *state, double phase,
                             const saltus_contact_map *hold, int order) {
    saltus_work *probe = &flow->probe[lane];
    size_t n = (size_t)flow->dof * sizeof(double);
    memcpy(probe->state.q, state, n);
    memcpy(probe->state.v, state + flow->dof, n);
    if (flow->extra)
        memcpy(probe->state.e, state + 2 * flow->dof, (size_t)flow->extra * sizeof(double));
    probe->lane->phase[0] = phase;
    probe->hold.count = hold->count;
    saltus_contact_map_publish(hold, probe, 0, hold->count);
    flow->narrow->expand(probe, 0, order);
    return probe;
}

void saltus_field_at(saltus_flow *flow, int lane, const double *state, double phase,
                     const saltus_contact_map *hold, double *derivative) {
    saltus_work *probe = saltus_probe_at(flow, lane, state, phase, hold, 1);
    size_t n = (size_t)flow->dof * sizeof(double);
    memcpy(derivative, state + flow->dof, n);
    memcpy(derivative + flow->dof, probe->jet.v + saltus_work_place(probe, 1, 0, 0, 0), n);
    if (flow->extra)
        memcpy(derivative + 2 * flow->dof, probe->jet.e + saltus_work_extra_place(probe, 1, 0, 0, 0),
               (size_t)flow->extra * sizeof(double));
}

void saltus_flow_field(saltus_flow *flow, int lane, double *derivative) {
    const saltus_lane *self = &flow->lane[lane];
    saltus_lane_gather(flow, lane, 0, flow->state);
    saltus_field_at(flow, lane, flow->state, self->now.phase, &self->hold, derivative);
}

void saltus_flow_tangent_field(saltus_flow *flow, int lane, double *derivatives) {
    saltus_work *w = &flow->work;
    for (int l = 0; l < flow->lanes; l++)
        w->lane->phase[l] = flow->lane[l].now.phase;
    flow->kernel->expand(w, 0, 1);
    for (int c = 0; c < flow->options.columns; c++) {
        double *out = derivatives + c * flow->dimension;
        for (int i = 0; i < flow->dof; i++) {
            out[i] = w->state.v[saltus_work_place(w, 0, c + 1, i, lane)];
            out[flow->dof + i] = w->jet.v[saltus_work_place(w, 1, c + 1, i, lane)];
        }
        for (int i = 0; i < flow->extra; i++)
            out[2 * flow->dof + i] = w->jet.e[saltus_work_extra_place(w, 1, c + 1, i, lane)];
    }
}

/* The probe's force row is n.f with accelerations f; the force is that divided by n M^-1 n of the face. */
void saltus_flow_forces(saltus_flow *flow, int lane, double *forces) {
    const saltus_lane *self = &flow->lane[lane];
    memset(forces, 0, SALTUS_FACES_MAX * sizeof *forces);
    saltus_lane_gather(flow, lane, 0, flow->state);
    saltus_work *probe = saltus_probe_at(flow, lane, flow->state, self->now.phase, &self->hold, 1);
    for (int k = 0; k < self->hold.count; k++) {
        int face = self->hold.face[k];
        forces[face] = probe->hold.force[saltus_work_series_place(probe, k, 0, 0)] /
                       saltus_system_compliance(self->system, face);
    }
}
