/* `key=value` settings.
 *
 * What one value alone shows to be wrong is refused here, by building a system that differs from the model's
 * defaults in this value only: the sentence is then the system's own. What depends on several values is left
 * to the building of the real system, so that settings may come in any order.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

enum { key_size = 32, value_size = 128 };

typedef struct setting {
    char key[key_size];
    char value[value_size];
} setting;

static saltus_status split(const char *assignment, setting *s, const saltus_source *source) {
    saltus_quoted quoted = saltus_quote(assignment);
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment)
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT, "%s: must have the form key=value",
                                  quoted.text);
    size_t key = (size_t)(equals - assignment), value = strlen(equals + 1);
    if (key >= key_size || value >= value_size)
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT, "%s: too long for a setting", quoted.text);
    memcpy(s->key, assignment, key);
    s->key[key] = '\0';
    memcpy(s->value, equals + 1, value + 1);
    return SALTUS_OK;
}

static saltus_status fail_value(const saltus_source *source, const setting *s, const char *complaint) {
    saltus_quoted quoted = saltus_quote(s->value);
    return saltus_source_fail(source, 0, SALTUS_BAD_INPUT, "%s = %s: %s", s->key, quoted.text, complaint);
}

static saltus_status check_alone(const saltus_spec *spec, saltus_message *message) {
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(spec, &system, message);
    saltus_system_free(system);
    return status;
}

/* The state's length that the parameters ask for. Parameters whose ranges are met always build without stops.
 */
static int dimension_of(const saltus_spec *spec, int *dof) {
    saltus_spec free_of_stops = *spec;
    saltus_system *system = NULL;
    free_of_stops.stop_count = 0;
    if (saltus_system_new(&free_of_stops, &system, NULL) != SALTUS_OK)
        return -1;
    int dimension = saltus_system_dimension(system);
    *dof = saltus_system_dof(system);
    saltus_system_free(system);
    return dimension;
}

static saltus_status set_parameter(saltus_scene *scene, int index, const setting *s,
                                   const saltus_source *source) {
    double value;
    int dof = 0;
    const char *complaint = saltus_read_number(s->value, &value);
    if (complaint)
        return fail_value(source, s, complaint);
    saltus_spec alone = saltus_spec_defaults(scene->spec.model);
    alone.parameters[index] = value;
    saltus_status status = check_alone(&alone, source->message);
    if (status != SALTUS_OK)
        return status;
    scene->spec.parameters[index] = value;
    if (scene->initial_count == 0)
        return SALTUS_OK;
    int dimension = dimension_of(&scene->spec, &dof);
    if (dimension < 0)
        return saltus_source_fail(source, 0, SALTUS_NO_MEMORY, "no memory for the system");
    if (dimension != scene->initial_count)
        return saltus_source_fail(
            source, 0, SALTUS_BAD_INPUT,
            "%s = %s: the scene's initial state has %d entries, but the system would have %d; "
            "change the initial state in the scene",
            s->key, s->value, scene->initial_count, dimension);
    return SALTUS_OK;
}

/* "1" or "1,-1". */
static saltus_status read_weight(const setting *s, double weight[2], const saltus_source *source) {
    static const char *const form = "must be 1 or 2 numbers, such as 1,-1";
    char first[value_size];
    size_t length = strcspn(s->value, ",");
    memcpy(first, s->value, length);
    first[length] = '\0';
    weight[1] = 0;
    if (saltus_read_number(first, &weight[0]) ||
        (s->value[length] && saltus_read_number(s->value + length + 1, &weight[1])))
        return fail_value(source, s, form);
    if (weight[0] == 0 && weight[1] == 0)
        return fail_value(source, s, "a stop must limit at least one mass");
    return SALTUS_OK;
}

/* Set one key of one stop, without any check of its range. */
static void assign(saltus_stop *stop, int key, const saltus_stop *from) {
    switch (key) {
    case stop_xi:
        stop->xi = from->xi;
        break;
    case stop_d:
        stop->d = from->d;
        break;
    case stop_r:
        stop->r = from->r;
        break;
    case stop_sides:
        stop->sides = from->sides;
        break;
    default:
        memcpy(stop->weight, from->weight, sizeof stop->weight);
    }
}

/* Read the value of a stop's key into a stop with defaults elsewhere, and check it alone. */
static saltus_status read_stop_value(const saltus_model *model, int key, const setting *s, saltus_stop *stop,
                                     const saltus_source *source) {
    saltus_spec alone = saltus_spec_defaults(model);
    double value = 0;
    *stop = saltus_stop_defaults();
    if (key == stop_weight)
        return read_weight(s, stop->weight, source);
    const char *complaint =
        key == stop_sides ? saltus_read_sides(s->value, &stop->sides) : saltus_read_number(s->value, &value);
    if (complaint)
        return fail_value(source, s, complaint);
    if (key == stop_xi)
        stop->xi = value;
    else if (key == stop_d)
        stop->d = value;
    else if (key == stop_r)
        stop->r = value;
    alone.stops[0] = *stop;
    alone.stop_count = 1;
    return check_alone(&alone, source->message);
}

/* `number`: the stop that is meant, from 1; 0 for all. */
static saltus_status set_stop(saltus_scene *scene, int key, int number, const setting *s,
                              const saltus_source *source) {
    saltus_spec *spec = &scene->spec;
    const char *own = saltus_model_stop_key(spec->model);
    saltus_stop read;
    if ((key == stop_xi || key == stop_weight) && strcmp(saltus_stop_keys[key], own) != 0)
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT, "%s: a stop of the model %s is placed by %s",
                                  s->key, saltus_model_name(spec->model), own);
    if (key == stop_sides && number == 0 && strcmp(s->value, "none") == 0) {
        spec->stop_count = 0;
        return SALTUS_OK;
    }
    if (spec->stop_count == 0 && (key != stop_d || number > 1))
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT,
                                  "%s: the scene has no stop; d=... makes one, so set d first", s->key);
    if (number > spec->stop_count && spec->stop_count > 0)
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT, "%s: the scene has %d stop%s", s->key,
                                  spec->stop_count, spec->stop_count > 1 ? "s" : "");
    saltus_status status = read_stop_value(spec->model, key, s, &read, source);
    if (status != SALTUS_OK)
        return status;
    if (spec->stop_count == 0)
        spec->stops[spec->stop_count++] = saltus_stop_defaults();
    for (int k = 0; k < spec->stop_count; k++)
        if (number == 0 || number == k + 1)
            assign(&spec->stops[k], key, &read);
    return SALTUS_OK;
}

static saltus_status set_initial(saltus_scene *scene, int list, int number, const setting *s,
                                 const saltus_source *source) {
    double value;
    int dof = 0, dimension = dimension_of(&scene->spec, &dof);
    const char *complaint = saltus_read_number(s->value, &value);
    if (complaint)
        return fail_value(source, s, complaint);
    if (dimension < 0)
        return saltus_source_fail(source, 0, SALTUS_NO_MEMORY, "no memory for the system");
    int room[initial_lists] = {dof, dof, dimension - 2 * dof}, first[initial_lists] = {0, dof, 2 * dof};
    if (number > room[list])
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT, "%s: the initial state has %d entr%s %s",
                                  s->key, room[list], room[list] == 1 ? "y" : "ies",
                                  saltus_initial_keys[list]);
    if (scene->initial_count == 0)
        memset(scene->initial, 0, sizeof scene->initial);
    scene->initial_count = dimension;
    scene->initial[first[list] + number - 1] = value;
    return SALTUS_OK;
}

/* Whether `key` is `name`, or `name` with a number from 1 behind it (0: none). */
static bool numbered(const char *key, const char *name, int *number) {
    size_t length = strlen(name);
    const char *digits = key + length;
    if (strncmp(key, name, length) != 0 || strspn(digits, "0123456789") != strlen(digits) ||
        digits[0] == '0' || strlen(digits) > 3)
        return false;
    *number = atoi(digits);
    return true;
}

static saltus_status fail_unknown(const saltus_scene *scene, const char *key, const saltus_source *source) {
    int count, stops;
    const saltus_parameter *table = saltus_model_parameters(scene->spec.model, &count);
    const char *keys[SALTUS_PARAMETERS_MAX + stop_keys + initial_lists];
    for (int k = 0; k < count; k++)
        keys[k] = table[k].name;
    stops = saltus_model_stop_keys(scene->spec.model, keys + count);
    return saltus_unknown_key(source, 0, key, keys, count + stops);
}

static saltus_status apply(saltus_scene *scene, const setting *s, const saltus_source *source) {
    int number = 0, index = saltus_model_parameter_index(scene->spec.model, s->key);
    if (index >= 0)
        return set_parameter(scene, index, s, source);
    for (int k = 0; k < stop_keys; k++)
        if (numbered(s->key, saltus_stop_keys[k], &number))
            return set_stop(scene, k, number, s, source);
    for (int k = 0; k < initial_lists; k++)
        if (numbered(s->key, saltus_initial_keys[k], &number) && number > 0)
            return set_initial(scene, k, number, s, source);
    return fail_unknown(scene, s->key, source);
}

saltus_status saltus_scene_set(saltus_scene *scene, const char *assignment, saltus_message *message) {
    saltus_source source = {.text = "", .message = message};
    saltus_scene changed = *scene;
    setting s;
    saltus_status status = split(assignment, &s, &source);
    if (status == SALTUS_OK)
        status = apply(&changed, &s, &source);
    if (status == SALTUS_OK)
        *scene = changed;
    return status;
}
