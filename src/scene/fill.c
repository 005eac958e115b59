/* From a scene's strings to numbers, stops and an initial state, checked with a trial system.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

static saltus_status fill_number(const saltus_source *source, saltus_place place, const char *text,
                                 double *value) {
    const char *complaint = saltus_read_number(text, value);
    return complaint ? saltus_value_fail(source, place, text, complaint) : SALTUS_OK;
}

static saltus_status fill_model(const saltus_source *source, const saltus_raw_scene *raw,
                                saltus_scene *scene) {
    saltus_words names = {""};
    for (int k = 0; k < saltus_model_count(); k++)
        saltus_words_add(&names, saltus_model_name(saltus_model_at(k)));
    if (!raw->model)
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT, "model: missing; the models are %s",
                                  names.text);
    const saltus_model *model = saltus_model_find(raw->model);
    if (!model) {
        saltus_quoted quoted = saltus_quote(raw->model);
        return saltus_place_fail(source, (saltus_place){NULL, 0, "model"},
                                 "model = %s: unknown; the models are %s", quoted.text, names.text);
    }
    scene->spec = saltus_spec_defaults(model);
    return SALTUS_OK;
}

static saltus_status fill_title(const saltus_source *source, const saltus_raw_scene *raw,
                                saltus_scene *scene) {
    const char *title = raw->title ? raw->title : "";
    size_t length = strlen(title);
    saltus_place place = {NULL, 0, "title"};
    if (length >= sizeof scene->title)
        return saltus_place_fail(source, place, "title: too long; at most %d bytes are possible",
                                 (int)sizeof scene->title - 1);
    for (size_t k = 0; k < length; k++)
        if ((unsigned char)title[k] < 0x20 || title[k] == 0x7f)
            return saltus_place_fail(source, place, "title: must be one line without control characters");
    memcpy(scene->title, title, length + 1);
    return SALTUS_OK;
}

static saltus_status fill_parameters(const saltus_source *source, const saltus_reading *reading,
                                     saltus_scene *scene) {
    const saltus_model *model = scene->spec.model;
    for (int k = 0; k < reading->name_count; k++) {
        const char *text = reading->raw->parameter[k], *key = reading->names[k];
        if (!text)
            continue;
        int index = saltus_model_parameter_index(model, key);
        if (index < 0) {
            /* A parameter of another model. */
            const char *keys[SALTUS_TOP_KEYS_MAX];
            int count = saltus_top_keys(model, keys);
            return saltus_place_fail(source, (saltus_place){NULL, 0, key},
                                     "\"%s\": not a key of the model %s; its keys are %s", key,
                                     saltus_model_name(model), saltus_words_of(keys, count).text);
        }
        saltus_status status =
            fill_number(source, (saltus_place){NULL, 0, key}, text, &scene->spec.parameters[index]);
        if (status != SALTUS_OK)
            return status;
    }
    return SALTUS_OK;
}

static saltus_status fail_without_clearance(const saltus_source *source, const char *top, int entry) {
    int line = 0;
    for (int k = 0; k < stop_keys && !line; k++)
        line = saltus_place_line(source, (saltus_place){top, entry, saltus_stop_keys[k]}, false);
    if (!line)
        line = saltus_place_line(source, (saltus_place){NULL, 0, top}, false);
    char number[16] = "";
    if (strcmp(top, "stops") == 0)
        snprintf(number, sizeof number, " %d", entry + 1);
    return saltus_source_fail(source, line, SALTUS_BAD_INPUT,
                              "stop%s: d is missing; a stop needs its clearance d", number);
}

static saltus_status fill_stop(const saltus_source *source, const char *top, int entry,
                               const saltus_raw_stop *raw, saltus_scene *scene) {
    saltus_stop *stop = &scene->spec.stops[entry];
    *stop = saltus_stop_defaults();
    if (!raw->value[stop_d])
        return fail_without_clearance(source, top, entry);
    for (int k = 0; k < stop_keys; k++) {
        saltus_place place = {top, entry, saltus_stop_keys[k]};
        const char *text = k == stop_weight ? NULL : raw->value[k];
        if (!text && !(k == stop_weight && raw->weight))
            continue;
        saltus_status status = saltus_check_placing(source, place, scene->spec.model, k);
        const char *complaint = NULL;
        if (status == SALTUS_OK && k == stop_weight) {
            stop->weight[0] = stop->weight[1] = 0;
            for (unsigned i = 0; i < raw->weight_count && status == SALTUS_OK; i++)
                status = fill_number(source, place, raw->weight[i], &stop->weight[i]);
        } else if (status == SALTUS_OK)
            complaint = saltus_read_stop(stop, k, text);
        if (complaint)
            status = saltus_value_fail(source, place, text, complaint);
        if (status != SALTUS_OK)
            return status;
    }
    return SALTUS_OK;
}

static saltus_status fill_stops(const saltus_source *source, const saltus_raw_scene *raw,
                                saltus_scene *scene) {
    if (raw->stop && raw->stops)
        return saltus_place_fail(source, (saltus_place){NULL, 0, "stops"},
                                 "stops: stop is given too; keep one of them");
    const char *top = raw->stop ? "stop" : "stops";
    const saltus_raw_stop *stops = raw->stop ? raw->stop : raw->stops;
    scene->spec.stop_count = raw->stop ? 1 : (int)raw->stops_count;
    saltus_status status = SALTUS_OK;
    for (int s = 0; s < scene->spec.stop_count && status == SALTUS_OK; s++)
        status = fill_stop(source, top, s, &stops[s], scene);
    return status;
}

/* The system's sentences begin with the key they are about, after "stop 2: " for one of several stops. */
static int line_of_sentence(const saltus_source *source, const saltus_raw_scene *raw, const char *sentence) {
    int stop = 1, skipped = 0;
    char key[32] = "";
    if (sscanf(sentence, "stop %d: %n", &stop, &skipped) != 1)
        stop = 1;
    sscanf(sentence + skipped, "%31[A-Za-z0-9_]", key);
    const char *top = raw->stop ? "stop" : "stops";
    for (int k = 0; k < stop_keys; k++)
        if (strcmp(key, saltus_stop_keys[k]) == 0) {
            int line = saltus_place_line(source, (saltus_place){top, stop - 1, key}, false);
            return line ? line : saltus_place_line(source, (saltus_place){NULL, 0, top}, false);
        }
    return saltus_place_line(source, (saltus_place){NULL, 0, key}, false);
}

static saltus_status fill_initial(const saltus_source *source, const saltus_raw_initial *raw,
                                  const saltus_system *system, saltus_scene *scene) {
    int dof = saltus_system_dof(system), extra = saltus_system_extra(system);
    int room[initial_lists] = {dof, dof, extra}, first[initial_lists] = {0, dof, 2 * dof};
    scene->initial_count = saltus_system_dimension(system);
    for (int k = 0; k < initial_lists; k++) {
        saltus_place place = {"initial", 0, saltus_initial_keys[k]};
        if ((int)raw->count[k] > room[k])
            return saltus_place_fail(source, place, "%s: too many entries (%u); the system has %d", place.key,
                                     raw->count[k], room[k]);
        for (unsigned i = 0; i < raw->count[k]; i++) {
            saltus_status status =
                fill_number(source, place, raw->list[k][i], &scene->initial[first[k] + (int)i]);
            if (status != SALTUS_OK)
                return status;
        }
    }
    saltus_message sentence;
    saltus_status status = saltus_system_check_state(system, scene->initial, &sentence);
    if (status == SALTUS_OK)
        return SALTUS_OK;
    int line = saltus_place_line(source, (saltus_place){NULL, 0, "initial"}, false);
    return saltus_source_fail(source, line, status, "%s", sentence.text);
}

saltus_status saltus_scene_fill(const saltus_source *source, const saltus_reading *reading,
                                saltus_scene *scene) {
    const saltus_raw_scene *raw = reading->raw;
    saltus_status status = fill_model(source, raw, scene);
    if (status == SALTUS_OK)
        status = fill_title(source, raw, scene);
    if (status == SALTUS_OK)
        status = fill_parameters(source, reading, scene);
    if (status == SALTUS_OK)
        status = fill_stops(source, raw, scene);
    if (status != SALTUS_OK)
        return status;

    saltus_system *system = NULL;
    saltus_message sentence;
    status = saltus_system_new(&scene->spec, &system, &sentence);
    if (status != SALTUS_OK)
        return saltus_source_fail(source, line_of_sentence(source, raw, sentence.text), status, "%s",
                                  sentence.text);
    if (raw->initial)
        status = fill_initial(source, raw->initial, system, scene);
    saltus_system_free(system);
    return status;
}
