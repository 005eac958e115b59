/* When and how fast does a pipe hit its stop for the first time? The four steps of every program: a scene, a
 * system built from it, a flow, and what the flow tells. first_impact [SCENE [key=value ...]]
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <saltus/saltus.h>

#include <stdio.h>

int main(int count, char **arguments) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_event event = {.kind = SALTUS_REACHED};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_flow_options options = saltus_flow_defaults();

    /* A file or a built-in scene, changed as by --set. */
    saltus_status status = saltus_scene_load(count > 1 ? arguments[1] : "pipe", &scene, &message);
    for (int k = 2; k < count && status == SALTUS_OK; k++)
        status = saltus_scene_set(&scene, arguments[k], &message);
    /* The system is checked here, and never changes afterwards. */
    if (status == SALTUS_OK)
        status = saltus_system_new(&scene.spec, &system, &message);
    if (status == SALTUS_OK)
        status = saltus_system_default_state(system, state, &message);
    if (status == SALTUS_OK)
        status = saltus_flow_new(&(const saltus_system *){system}, 1, &options, &flow, &message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, &message);
    /* On to the first impact, for 100 forcing periods at most. */
    if (status == SALTUS_OK)
        status = saltus_flow_advance(flow, (saltus_time){100, 0}, SALTUS_WATCH_IMPACT, &event, &message);
    if (status != SALTUS_OK)
        fprintf(stderr, "%s\n", message.text);
    else if (event.kind == SALTUS_IMPACT)
        printf("first impact at %.6f T, speed %.6f\n", saltus_time_periods(event.time),
               event.velocity_before);
    else
        printf("no impact in 100 T\n");
    saltus_flow_free(flow);
    saltus_system_free(system);
    return status != SALTUS_OK;
}
