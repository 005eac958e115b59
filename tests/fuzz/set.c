/* Fuzz target: settings as of --set, applied one after the other. The first line names a built-in scene by a
 * letter, every further line is one setting.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "fuzz.h"

enum { settings_max = 64 };

/* A refused setting leaves the scene as it was; an accepted one may still make no system, but says why. */
static void apply(saltus_scene *scene, const char *setting) {
    saltus_message message = {.text = ""};
    saltus_scene before = *scene;
    saltus_system *system = NULL;
    saltus_status status = saltus_scene_set(scene, setting, &message);
    fuzz_check_refusal(status, &message);
    if (status != SALTUS_OK) {
        fuzz_check(memcmp(&before, scene, sizeof before) == 0, "a refused setting has changed the scene");
        return;
    }
    message.text[0] = '\0';
    fuzz_check_refusal(saltus_system_new(&scene->spec, &system, &message), &message);
    saltus_system_free(system);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    memset(&scene, 0, sizeof scene);
    if (size < 2)
        return 0;
    int which = data[0] % saltus_scene_builtin_count();
    const char *builtin = saltus_scene_builtin_text(which);
    fuzz_check(saltus_scene_parse(builtin, strlen(builtin), saltus_scene_builtin_name(which), &scene,
                                  &message) == SALTUS_OK,
               message.text);
    char *text = fuzz_text(data + 1, size - 1), *line = text;
    for (int k = 0; line && k < settings_max; k++) {
        char *end = strchr(line, '\n');
        if (end)
            *end = '\0';
        apply(&scene, line);
        line = end ? end + 1 : NULL;
    }
    free(text);
    saltus_scene_clear(&scene);
    return 0;
}
