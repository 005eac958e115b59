/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/volume.h"

#include "base/bits.h"

#include <math.h>

double saltus_trace_over_step(const saltus_flow *flow, int lane, const gsl_integration_glfixed_table *table,
                              long long *steps) {
    const saltus_system *system = saltus_flow_system(flow, lane);
    const double period = saltus_system_period(system), end = saltus_flow_time(flow, lane).phase;
    double sum = 0, length = saltus_flow_step_length(flow, lane);
    long long made = saltus_flow_information(flow, lane).steps;
    bool fresh = made != *steps;
    *steps = made;
    for (size_t k = 0; k < SALTUS_TRACE_POINTS && fresh; k++) {
        double at, weight, state[SALTUS_STATE_MAX];
        gsl_integration_glfixed_point(0, length, k, &at, &weight, table);
        saltus_flow_dense(flow, lane, at, state);
        const double phase = end - (length - at) / period;
        sum += weight * saltus_system_trace(system, state, phase - floor(phase));
    }
    return sum;
}

int saltus_lost_directions(const saltus_flow *flow, int lane, const saltus_event *event) {
    int lost = 2 * saltus_count_bits(saltus_flow_contacts(flow, lane));
    bool dead =
        event->kind == SALTUS_IMPACT && saltus_system_restitution(saltus_flow_system(flow, lane), event->face,
                                                                  fabs(event->velocity_before)) == 0;
    return lost > 0 ? lost : dead;
}
