/* Scenes from files, from text and from the built-in table.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"
#include "system/system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The file's name without folder and ending; a long name is cut between characters, not within one. */
static void set_name(saltus_scene *scene, const char *origin) {
    const char *slash = strrchr(origin, '/'), *base = slash ? slash + 1 : origin, *dot = strrchr(base, '.');
    size_t length = dot && dot != base ? (size_t)(dot - base) : strlen(base), room = sizeof scene->name - 1;
    if (length > room)
        for (length = room; length > 0 && ((unsigned char)base[length] & 0xc0) == 0x80;)
            length--;
    snprintf(scene->name, sizeof scene->name, "%.*s", (int)length, base);
}

saltus_status saltus_scene_parse(const char *text, size_t length, const char *origin, saltus_scene *scene,
                                 saltus_message *message) {
    saltus_source source = {.text = text ? text : "",
                            .length = text ? length : 0,
                            .origin = origin ? origin : "scene",
                            .language = "YAML",
                            .message = message};
    saltus_document document;
    if (source.length > SALTUS_SCENE_BYTES_MAX)
        return saltus_source_fail(&source, 0, SALTUS_BAD_INPUT, "too large for a scene (more than 1 MiB)");
    saltus_status status = saltus_document_read(&source, &document);
    if (status != SALTUS_OK)
        return status;
    if (document.root)
        status = saltus_scene_read(&source, document.root, false, scene);
    else
        status = saltus_source_fail(&source, 0, SALTUS_BAD_INPUT,
                                    "is empty; a scene names at least its model (model: pipe, say)");
    saltus_document_close(&document);
    if (status == SALTUS_OK)
        set_name(scene, source.origin);
    return status;
}

saltus_status saltus_scene_load(const char *source, saltus_scene *scene, saltus_message *message) {
    if (!source || !source[0])
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "no scene given: name a scene file or a built-in scene");
    for (int k = 0; k < saltus_builtin_count; k++)
        if (strcmp(saltus_builtins[k].name, source) == 0)
            return saltus_scene_parse(saltus_builtins[k].text, strlen(saltus_builtins[k].text), source, scene,
                                      message);
    char *text = NULL;
    size_t length = 0;
    saltus_status status = saltus_read_file(source, &text, &length, message);
    if (status == SALTUS_OK)
        status = saltus_scene_parse(text, length, source, scene, message);
    free(text);
    return status;
}

void saltus_scene_clear(saltus_scene *scene) {
    saltus_model_release(scene->spec.model);
    *scene = (saltus_scene){.initial_count = 0};
}

int saltus_scene_builtin_count(void) {
    return saltus_builtin_count;
}

const char *saltus_scene_builtin_name(int k) {
    return k >= 0 && k < saltus_builtin_count ? saltus_builtins[k].name : NULL;
}

const char *saltus_scene_builtin_text(int k) {
    return k >= 0 && k < saltus_builtin_count ? saltus_builtins[k].text : NULL;
}

saltus_status saltus_scene_state(const saltus_scene *scene, const saltus_system *system, double *state,
                                 saltus_message *message) {
    int n = saltus_system_dimension(system), open = n;
    if (scene->initial_count && scene->initial_count != n)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: initial state has %d entries, the system needs %d",
                           scene->name, scene->initial_count, n);
    for (int i = 0; i < scene->initial_count; i++)
        open -= !isnan(scene->initial[i]);
    saltus_status status = open ? saltus_system_default_state(system, state, message) : SALTUS_OK;
    if (status != SALTUS_OK || open == n)
        return status;
    for (int i = 0; i < n; i++)
        if (!isnan(scene->initial[i]))
            state[i] = scene->initial[i];
    return saltus_system_check_state(system, state, message);
}
