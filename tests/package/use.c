/* A user's program: one impact of the default pipe.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <saltus/saltus.h>

#include <stdio.h>

int main(void) {
    saltus_message message = {""};
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_event event;
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_flow_options options = saltus_flow_defaults();
    if (saltus_scene_load("pipe", &scene, &message) != SALTUS_OK ||
        saltus_system_new(&scene.spec, &system, &message) != SALTUS_OK ||
        saltus_system_default_state(system, state, &message) != SALTUS_OK)
        return 1;
    const saltus_system *const systems[] = {system};
    if (saltus_flow_new(systems, 1, &options, &flow, &message) != SALTUS_OK ||
        saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, &message) != SALTUS_OK ||
        saltus_flow_advance(flow, (saltus_time){100, 0}, SALTUS_WATCH_IMPACT, &event, &message) != SALTUS_OK)
        return 1;
    printf("first impact at %.6f T, speed %.6f\n", saltus_time_periods(event.time), event.velocity_before);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return event.kind != SALTUS_IMPACT;
}
