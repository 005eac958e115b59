/* The linear part of the vector field at a lane's state.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <string.h>

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
