/* Collocation and series in turns.
 *
 * In a stiff system, stability keeps series to steps far shorter than the motion requires, and collocation is
 * cheaper. But a step of collocation costs as much as a dozen of series, whatever its length, and three
 * things shorten it: a near event, as between the impacts of a chatter; a near target; and the boundary
 * layers that an impact leaves in the fast modes. There series are cheaper. Only state and target decide, so
 * that a run can be repeated bit by bit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <math.h>

static bool collocation_pays(saltus_flow *flow) {
    saltus_lane *self = &flow->lane[0];
    saltus_mixture *mixture = &flow->mixture;
    if (mixture->worth == 0)
        return true;
    if (fmin(self->flight, flow->work.lane->left[0]) < mixture->worth)
        return false;
    if (!mixture->known)
        mixture->layers =
            saltus_radau_layers(flow->radau, &flow->work, mixture->worth, &self->info.field_evaluations);
    mixture->known = true;
    return mixture->layers <= 0;
}

saltus_status saltus_flow_mix(saltus_flow *flow) {
    saltus_work *w = &flow->work;
    flow->collocated = collocation_pays(flow);
    if (!flow->collocated) {
        if (!saltus_flow_expand(flow))
            flow->kernel->measure(w);
        return SALTUS_OK;
    }
    w->lane->degree[0] = SALTUS_RADAU_DEGREE;
    saltus_work_settle_degrees(w);
    flow->shortened = true; /* series need their own degree again */
    return saltus_radau_step(flow->radau, w, &flow->lane[0].info.field_evaluations);
}

void saltus_flow_break(saltus_flow *flow, bool start) {
    flow->mixture.known = false;
    if (flow->radau)
        (start ? saltus_radau_reset : saltus_radau_impact)(flow->radau);
}
