/* `key=value` settings.
 *
 * A value that is wrong whatever the other values are is refused here, by building a system that differs from
 * the model's defaults in this value only, which also gives the message. Conditions on several values are
 * checked when the real system is built, so settings may come in any order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"

#include "system/system.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { key_size = 32, value_size = 128 };

typedef struct setting {
    char key[key_size];
    char value[value_size];
} setting;

static saltus_status refuse_value(const setting *s, const char *complaint, saltus_message *message) {
    saltus_quoted quoted = saltus_quote(s->value);
    return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = s->key}, "%s = %s: %s", s->key,
                          quoted.text, complaint);
}

/* Whether a value is possible at all, with all other values at the model's defaults. */
static saltus_status check_alone(const saltus_spec *spec, saltus_message *message) {
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(spec, &system, message);
    saltus_system_free(system);
    return status;
}

static saltus_status set_parameter(saltus_scene *scene, int index, double value, const setting *s,
                                   saltus_message *message) {
    saltus_spec alone = saltus_spec_defaults(scene->spec.model);
    alone.parameters[index] = value;
    saltus_status status = check_alone(&alone, message);
    if (status != SALTUS_OK)
        return status;
    scene->spec.parameters[index] = value;
    if (scene->initial_count == 0)
        return SALTUS_OK;
    int dimension = saltus_spec_dimension(&scene->spec, NULL);
    if (dimension != scene->initial_count)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = s->key},
                              "%s = %s: the scene's initial state has %d entries, but the system would have "
                              "%d; change the initial state in the scene",
                              s->key, s->value, scene->initial_count, dimension);
    return SALTUS_OK;
}

/* Set one key of a stop, without checking its range. */
static saltus_status assign(saltus_stop *stop, int key, const setting *s, saltus_message *message) {
    const char *complaint = NULL;
    if (key == stop_weight) { /* "1" or "1,-1" */
        const size_t length = strcspn(s->value, ",");
        char first[value_size];
        snprintf(first, sizeof first, "%.*s", (int)length, s->value);
        stop->weight[1] = 0;
        if (saltus_read_number(first, &stop->weight[0]) ||
            (s->value[length] && saltus_read_number(s->value + length + 1, &stop->weight[1])))
            complaint = "must be 1 or 2 numbers, such as 1,-1";
        else if (stop->weight[0] == 0 && stop->weight[1] == 0)
            complaint = "a stop must limit at least one mass";
    } else
        complaint = saltus_read_stop(stop, key, s->value);
    return complaint ? refuse_value(s, complaint, message) : SALTUS_OK;
}

/* `number`: the stop, from 1; 0: all stops. */
static saltus_status set_stop(saltus_scene *scene, int key, int number, const setting *s,
                              saltus_message *message) {
    saltus_spec *spec = &scene->spec, alone = saltus_spec_defaults(spec->model);
    const saltus_fault fault = {.key = s->key};
    if (!saltus_model_has_stop_key(spec->model, key))
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%s: a stop of the model %s is placed by %s",
                              s->key, spec->model->name, spec->model->stop_key);
    if (key == stop_coordinate)
        return saltus_fail_at(
            message, SALTUS_BAD_INPUT, fault,
            "%s: where a stop acts is part of the scene's equations; change it in the scene", s->key);
    if (key == stop_sides && number == 0 && strcmp(s->value, "none") == 0) {
        spec->stop_count = 0;
        return SALTUS_OK;
    }
    if (spec->stop_count == 0 && (key != stop_d || number > 1))
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                              "%s: the scene has no stop; d=... makes one, so set d first", s->key);
    if (number > spec->stop_count && spec->stop_count > 0)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%s: the scene has %d stop%s", s->key,
                              spec->stop_count, spec->stop_count > 1 ? "s" : "");
    for (int k = 0; k < spec->stop_count && (key == stop_d || key == stop_r); k++) {
        const char *text =
            saltus_stop_text(spec, k, key == stop_d ? SALTUS_STOP_CLEARANCE : SALTUS_STOP_RESTITUTION);
        if (text && (number == 0 || number == k + 1))
            return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                                  "%s: is %.200s in the scene; the names in it are what can be set", s->key,
                                  text);
    }
    alone.stops[0] = saltus_stop_defaults();
    alone.stop_count = 1;
    saltus_status status = assign(&alone.stops[0], key, s, message);
    if (status == SALTUS_OK && key != stop_weight)
        status = check_alone(&alone, message);
    if (status == SALTUS_OK && spec->stop_count == 0)
        spec->stops[spec->stop_count++] = saltus_stop_defaults();
    for (int k = 0; k < spec->stop_count && status == SALTUS_OK; k++)
        if (number == 0 || number == k + 1)
            status = assign(&spec->stops[k], key, s, message);
    return status;
}

/* Refuse an unknown key and list all valid ones: parameters, keys of stops, and names of states of a text. */
static saltus_status refuse_key(const saltus_scene *scene, const setting *s, saltus_message *message) {
    const saltus_model *model = scene->spec.model;
    const char *keys[SALTUS_PARAMETERS_MAX + stop_keys + 2 + SALTUS_STATE_MAX];
    saltus_state_name names[SALTUS_STATE_MAX];
    const saltus_source none = {.message = message};
    int count = model->parameter_count;
    for (int k = 0; k < count; k++)
        keys[k] = model->parameters[k].name;
    count += saltus_model_stop_keys(model, keys + count);
    if (model->text) /* the coordinate of a stop in a text model cannot be set */
        for (int k = 0; k < count; k++)
            if (strcmp(keys[k], model->stop_key) == 0)
                keys[k] = keys[--count];
    keys[count++] = "observe";
    if (model->text)
        keys[count++] = "section";
    for (int i = 0; model->text && i < saltus_spec_dimension(&scene->spec, NULL); i++) {
        names[i] = saltus_spec_state_name(&scene->spec, i);
        keys[count++] = names[i].text;
    }
    return saltus_unknown_key(&none, 0, s->key, keys, count);
}

/* What a key stands for. */
typedef struct target {
    enum { of_nothing, of_parameter, of_stop, of_observed, of_section, of_entry, of_lacking_entry } what;
    int index;  /* of the parameter, of the stop's key, of the entry, or of the list that lacks it */
    int number; /* of the stop, from 1; 0: all stops */
} target;

static target find_target(const saltus_scene *scene, const char *key) {
    const saltus_model *model = scene->spec.model;
    target t = {of_parameter, saltus_model_parameter_index(model, key), 0};
    if (t.index >= 0)
        return t;
    for (int k = 0; k < stop_keys; k++)
        if (saltus_key_numbered(key, saltus_stop_keys[k], &t.number))
            return (target){of_stop, k, t.number};
    if (strcmp(key, "observe") == 0)
        return (target){of_observed, 0, 0};
    if (strcmp(key, "section") == 0)
        return (target){of_section, 0, 0};
    t.index = saltus_spec_state_index(&scene->spec, key);
    if (t.index >= 0)
        return (target){of_entry, t.index, 0};
    for (int k = 0; k < initial_lists; k++)
        if (saltus_key_numbered(key, saltus_initial_keys[k], &t.number) && t.number > 0)
            return (target){of_lacking_entry, k, 0};
    return (target){of_nothing, 0, 0};
}

static saltus_status apply(saltus_scene *scene, const setting *s, saltus_message *message) {
    const target t = find_target(scene, s->key);
    const bool number = t.what == of_parameter || t.what == of_entry || t.what == of_lacking_entry;
    int dof = 0, dimension, room;
    double value = 0;
    const char *complaint = number ? saltus_read_number(s->value, &value) : NULL;
    saltus_status status;
    if (complaint)
        return refuse_value(s, complaint, message);
    switch (t.what) {
    case of_parameter:
        return set_parameter(scene, t.index, value, s, message);
    case of_stop:
        status = set_stop(scene, t.index, t.number, s, message);
        return status == SALTUS_OK ? saltus_spec_check_poincare(&scene->spec, message) : status;
    case of_observed:
        /* Valid names depend on the whole scene, so they are checked when the system is built. */
        if (strlen(s->value) >= sizeof scene->spec.observe)
            return refuse_value(s, "too long for a name", message);
        strcpy(scene->spec.observe, s->value);
        return SALTUS_OK;
    case of_entry:
        dimension = saltus_spec_dimension(&scene->spec, NULL);
        /* Entries that are not set stay NAN: the system's default state is known only after all settings. */
        if (scene->initial_count == 0)
            memset(scene->initial, 0, sizeof scene->initial);
        for (int i = 0; i < dimension && scene->initial_count == 0; i++)
            scene->initial[i] = NAN;
        scene->initial_count = dimension;
        scene->initial[t.index] = value;
        return SALTUS_OK;
    case of_lacking_entry: /* such as q7 of a system that has fewer */
        dimension = saltus_spec_dimension(&scene->spec, &dof);
        room = t.index == initial_z ? dimension - 2 * dof : dof;
        return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = s->key},
                              "%s: the initial state has %d entr%s %s", s->key, room, room == 1 ? "y" : "ies",
                              saltus_initial_keys[t.index]);
    default:
        return refuse_key(scene, s, message);
    }
}

bool saltus_scene_overrides(const saltus_scene *scene, const char *later, const char *earlier) {
    char keys[2][key_size];
    snprintf(keys[0], key_size, "%.*s", (int)strcspn(later, "="), later);
    snprintf(keys[1], key_size, "%.*s", (int)strcspn(earlier, "="), earlier);
    const target now = find_target(scene, keys[0]), before = find_target(scene, keys[1]);
    if (now.what == of_nothing || now.what != before.what)
        return false;
    if (strcmp(later, "sides=none") == 0) /* takes the stops away */
        return true;
    return now.index == before.index &&
           (now.number == 0 || now.number == before.number || scene->spec.stop_count == 1);
}

saltus_status saltus_scene_set_section(saltus_scene *scene, const char *section, saltus_message *message) {
    const saltus_model *old = scene->spec.model, *made;
    saltus_spec changed = scene->spec;
    if (!old->text)
        return saltus_fail_at(
            message, SALTUS_BAD_INPUT, (saltus_fault){.key = "section"},
            "section: the model %s has none to choose; scenes of equations without forcing do", old->name);
    saltus_status status = saltus_model_with_section(old, section, &made, message);
    if (status != SALTUS_OK)
        return status;
    changed.model = made;
    status = saltus_spec_check_poincare(&changed, message);
    saltus_model_release(status == SALTUS_OK ? old : made);
    if (status == SALTUS_OK)
        scene->spec = changed;
    return status;
}

saltus_status saltus_scene_set(saltus_scene *scene, const char *assignment, saltus_message *message) {
    static const char section[] = "section=";
    const saltus_quoted quoted = saltus_quote(assignment);
    const char *equals = strchr(assignment, '=');
    saltus_scene changed = *scene;
    setting s;
    if (strncmp(assignment, section, sizeof section - 1) == 0 &&
        saltus_model_parameter_index(scene->spec.model, "section") < 0)
        return saltus_scene_set_section(scene, assignment + sizeof section - 1, message);
    if (!equals || equals == assignment)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: must have the form key=value", quoted.text);
    if (equals - assignment >= key_size || strlen(equals + 1) >= value_size)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: too long for a setting", quoted.text);
    snprintf(s.key, sizeof s.key, "%.*s", (int)(equals - assignment), assignment);
    strcpy(s.value, equals + 1);
    saltus_status status = apply(&changed, &s, message);
    if (status == SALTUS_OK)
        *scene = changed;
    return status;
}

saltus_status saltus_spec_set(saltus_spec *spec, const char *key, double value, saltus_message *message) {
    saltus_scene scene = {.spec = *spec};
    char assignment[key_size + 32];
    if (strlen(key) >= key_size)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.40s...: too long for a key", key);
    snprintf(assignment, sizeof assignment, "%s=%.17g", key, value);
    saltus_status status = saltus_scene_set(&scene, assignment, message);
    if (status == SALTUS_OK && scene.initial_count)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = key},
                              "%s: an entry of the initial state, which a scene has", key);
    if (status == SALTUS_OK)
        *spec = scene.spec;
    return status;
}
