/* Fuzz target: the scene reader, from YAML to a checked system and its default state.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_message message = {.text = ""};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_status status = saltus_scene_parse((const char *)data, size, "fuzz.yaml", &scene, &message);
    fuzz_check_refusal(status, &message);
    if (status != SALTUS_OK)
        return 0;
    /* What is a scene has a system: the reader has tried that. */
    fuzz_check(saltus_system_new(&scene.spec, &system, &message) == SALTUS_OK, message.text);
    fuzz_check_refusal(saltus_system_default_state(system, state, &message), &message);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    return 0;
}
