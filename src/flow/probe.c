/* The field at single points, by short series in the lanes' narrow works (that of tangent vectors in the
 * stepping work): derivatives and contact forces.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <string.h>

saltus_work *saltus_probe_at(saltus_flow *flow, int lane, const double *state, double phase,
                             const saltus_contact_map *hold, int order) {
    saltus_work *probe = &flow->probe[lane];
    size_t n = (size_t)flow->dof * sizeof(double);
    memcpy(probe->xq, state, n);
    memcpy(probe->xv, state + flow->dof, n);
    if (flow->extra)
        memcpy(probe->xe, state + 2 * flow->dof, (size_t)flow->extra * sizeof(double));
    probe->phase[0] = phase;
    probe->contacts = hold ? hold->count : 0;
    if (hold)
        saltus_contact_map_publish(hold, probe, 0, hold->count);
    flow->narrow->expand(probe, order);
    return probe;
}

void saltus_field_at(saltus_flow *flow, int lane, const double *state, double phase,
                     const saltus_contact_map *hold, double *derivative) {
    saltus_work *probe = saltus_probe_at(flow, lane, state, phase, hold, 1);
    memcpy(derivative, state + flow->dof, (size_t)flow->dof * sizeof(double));
    memcpy(derivative + flow->dof, probe->v + saltus_work_jet(probe, 1, 0),
           (size_t)flow->dof * sizeof(double));
    if (flow->extra)
        memcpy(derivative + 2 * flow->dof, probe->e + saltus_work_extra_jet(probe, 1, 0),
               (size_t)flow->extra * sizeof(double));
}

void saltus_flow_field(saltus_flow *flow, int lane, double *derivative) {
    saltus_lane *self = &flow->lane[lane];
    saltus_lane_gather(flow, lane, 0, self->state);
    saltus_field_at(flow, lane, self->state, self->now.phase, &self->hold, derivative);
}

void saltus_flow_tangent_field(saltus_flow *flow, int lane, double *derivatives) {
    saltus_lane *self = &flow->lane[lane];
    saltus_work *w = &flow->work;
    int n = flow->dof;
    for (int l = 0; l < flow->lanes; l++)
        w->phase[l] = flow->lane[l].now.phase;
    saltus_lane_gather_all(flow, lane);
    flow->kernel->expand(w, 1);
    for (int c = 0; c < flow->options.columns; c++) {
        double *out = derivatives + c * flow->dimension;
        const double *velocity = w->v + saltus_work_jet(w, 1, c + 1) + lane;
        const double *extra = w->e + saltus_work_extra_jet(w, 1, c + 1) + lane;
        memcpy(out, self->tangents + c * flow->dimension + n, (size_t)n * sizeof *out);
        for (int i = 0; i < n; i++)
            out[n + i] = velocity[i * w->stride];
        for (int i = 0; i < flow->extra; i++)
            out[2 * n + i] = extra[i * w->stride];
    }
}

/* The probe's force row is n.f; per modal mass means divided by n M^-1 n of the face. */
void saltus_flow_forces(saltus_flow *flow, int lane, double *forces) {
    saltus_lane *self = &flow->lane[lane];
    memset(forces, 0, SALTUS_FACES_MAX * sizeof *forces);
    saltus_lane_gather(flow, lane, 0, self->state);
    saltus_work *probe = saltus_probe_at(flow, lane, self->state, self->now.phase, &self->hold, 1);
    for (int k = 0; k < self->hold.count; k++) {
        int face = self->hold.face[k];
        const double *normal = self->system->stop_normal[self->system->faces[face].stop];
        double compliance = 0;
        for (int i = 0; i < flow->dof; i++)
            for (int j = 0; j < flow->dof; j++)
                compliance += normal[i] * self->system->inverse_mass[i * flow->dof + j] * normal[j];
        forces[face] = probe->force[(size_t)k * (size_t)(probe->order + 2)] / compliance;
    }
}
