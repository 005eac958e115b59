/* Reading a scene's strings with libcyaml.
 *
 * The schema is the union of all models' keys and is made from their tables, so that a new model needs no
 * change here. All scalars are strings: whether a key belongs to the scene's model and what its value must be
 * is decided later, where a better sentence can be written. libcyaml tells what it dislikes only through its
 * log, which is caught here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"

#include <cyaml/cyaml.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { optional = CYAML_FLAG_POINTER | CYAML_FLAG_OPTIONAL };

static const cyaml_schema_value_t string_entry = {
    CYAML_VALUE_STRING(CYAML_FLAG_POINTER, char, 0, CYAML_UNLIMITED)};

#define STRING(key, type, member) CYAML_FIELD_STRING_PTR(key, optional, type, member, 0, CYAML_UNLIMITED)
#define STRINGS(key, type, member, count, min, max)                                                          \
    CYAML_FIELD_SEQUENCE_COUNT(key, optional, type, member, count, &string_entry, min, max)

static const cyaml_schema_field_t stop_fields[] = {
    STRING("xi", saltus_raw_stop, value[stop_xi]),
    STRING("d", saltus_raw_stop, value[stop_d]),
    STRING("r", saltus_raw_stop, value[stop_r]),
    STRING("sides", saltus_raw_stop, value[stop_sides]),
    STRINGS("weight", saltus_raw_stop, weight, weight_count, 1, 2),
    CYAML_FIELD_END,
};

static const cyaml_schema_value_t stop_entry = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, saltus_raw_stop, stop_fields)};

static const cyaml_schema_field_t initial_fields[] = {
    STRINGS("q", saltus_raw_initial, list[initial_q], count[initial_q], 0, SALTUS_SCENE_STATE_MAX),
    STRINGS("v", saltus_raw_initial, list[initial_v], count[initial_v], 0, SALTUS_SCENE_STATE_MAX),
    STRINGS("z", saltus_raw_initial, list[initial_z], count[initial_z], 0, SALTUS_SCENE_STATE_MAX),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t fixed_fields[] = {
    STRING("model", saltus_raw_scene, model),
    STRING("title", saltus_raw_scene, title),
    CYAML_FIELD_MAPPING_PTR("stop", optional, saltus_raw_scene, stop, stop_fields),
    CYAML_FIELD_SEQUENCE_COUNT("stops", optional, saltus_raw_scene, stops, stops_count, &stop_entry, 0,
                               SALTUS_STOPS_MAX),
    CYAML_FIELD_MAPPING_PTR("initial", optional, saltus_raw_scene, initial, initial_fields),
};

enum { fixed_count = sizeof fixed_fields / sizeof fixed_fields[0] };

/* The first complaint in libcyaml's log, and the path to it. */
typedef struct complaint {
    char problem[160];
    char unknown[48]; /* a key that the schema lacks */
    char field[48];   /* innermost key that is known */
    char top[48];     /* outermost one */
    int entry;        /* of the outermost list, from 0 */
    int line;         /* near the problem */
} complaint;

static void catch (cyaml_log_t level, void *context, const char *format, va_list arguments) {
    complaint *c = context;
    char text[160], name[48] = "";
    int line = 0, entry = 0;
    (void)level;
    vsnprintf(text, sizeof text, format, arguments);
    text[strcspn(text, "\n")] = '\0';
    const char *mark = strstr(text, "(line: ");
    if (mark && !c->line && sscanf(mark, "(line: %d", &line) == 1)
        c->line = line;
    if (sscanf(text, " in mapping field '%47[^']'", name) == 1) {
        if (!c->field[0])
            strcpy(c->field, name);
        strcpy(c->top, name);
    } else if (sscanf(text, " in sequence entry '%d'", &entry) == 1) {
        c->entry = entry > 0 ? entry - 1 : 0;
    } else if (!c->problem[0] && !strstr(text, "Backtrace")) {
        strcpy(c->problem, strncmp(text, "Load: ", 6) == 0 ? text + 6 : text);
        sscanf(c->problem, "Unexpected key: %47[^\n]", c->unknown);
    }
}

static bool known_name(const saltus_reading *reading, const char *name) {
    for (int k = 0; k < reading->name_count; k++)
        if (strcmp(reading->names[k], name) == 0)
            return true;
    return false;
}

/* The schema's value and its fields are one block: the value first. */
typedef struct schema {
    cyaml_schema_value_t scene;
    cyaml_schema_field_t fields[];
} schema;

static bool build_schema(saltus_reading *reading) {
    size_t most = (size_t)saltus_model_count() * SALTUS_PARAMETERS_MAX;
    reading->names = calloc(most, sizeof *reading->names);
    schema *made = calloc(1, sizeof *made + (fixed_count + most + 1) * sizeof made->fields[0]);
    reading->schema = made;
    if (!reading->names || !made)
        return false;
    for (int m = 0; m < saltus_model_count(); m++) {
        int count;
        const saltus_parameter *table = saltus_model_parameters(saltus_model_at(m), &count);
        for (int k = 0; k < count; k++)
            if (!known_name(reading, table[k].name))
                reading->names[reading->name_count++] = table[k].name;
    }
    memcpy(made->fields, fixed_fields, sizeof fixed_fields);
    for (int k = 0; k < reading->name_count; k++)
        made->fields[fixed_count + k] = (cyaml_schema_field_t){
            .key = reading->names[k],
            .data_offset = (uint32_t)(offsetof(saltus_raw_scene, parameter) + (size_t)k * sizeof(char *)),
            .value = {CYAML_VALUE_STRING(optional, char, 0, CYAML_UNLIMITED)},
        };
    made->scene = (cyaml_schema_value_t){
        .type = CYAML_MAPPING,
        .flags = CYAML_FLAG_POINTER,
        .data_size = (uint32_t)(sizeof(saltus_raw_scene) + (size_t)reading->name_count * sizeof(char *)),
        .mapping = {.fields = made->fields},
    };
    return true;
}

/* What kind of value a key wants, for a value of another kind. */
static const char *wanted_kind(const char *field) {
    if (strcmp(field, "stop") == 0)
        return "must be a mapping with the keys of a stop: stop: {d: ..., r: ...}";
    if (strcmp(field, "stops") == 0)
        return "must be a list of stops: stops: [{d: ...}, {d: ...}]";
    if (strcmp(field, "initial") == 0)
        return "must be a mapping of lists: initial: {q: [...], v: [...]}";
    if (strcmp(field, "weight") == 0)
        return "must be a list of 1 or 2 numbers, such as [1, -1]";
    for (int k = 0; k < initial_lists; k++)
        if (strcmp(field, saltus_initial_keys[k]) == 0)
            return "must be a list of numbers";
    return "must be a single value, not a list or a mapping";
}

/* What libcyaml allocates, frees and moves, through this file's own calls. */
static void *provide(void *context, void *old, size_t size) {
    (void)context;
    if (size == 0) {
        free(old);
        return NULL;
    }
    return realloc(old, size);
}

/* The keys that are possible below `top` ("": at the top level). */
static int possible_keys(const saltus_model *model, const char *top, const char **keys) {
    if (!top[0])
        return saltus_top_keys(model, keys);
    if (strcmp(top, "stop") == 0 || strcmp(top, "stops") == 0)
        return saltus_model_stop_keys(model, keys);
    memcpy(keys, saltus_initial_keys, sizeof saltus_initial_keys);
    return initial_lists;
}

static saltus_status fail_unknown(const saltus_source *source, const saltus_reading *reading,
                                  const complaint *c) {
    saltus_place place = {c->top[0] ? c->top : NULL, c->entry, c->unknown};
    int line = saltus_place_line(source, place, false);
    saltus_quoted name = saltus_quote(c->unknown);
    char value[32];
    bool named = saltus_place_value(source, (saltus_place){NULL, 0, "model"}, value, sizeof value);
    const saltus_model *model = named ? saltus_model_find(value) : NULL;
    for (int k = 0; !c->top[0] && k < stop_keys; k++)
        if (strcmp(c->unknown, saltus_stop_keys[k]) == 0)
            return saltus_source_fail(source, line, SALTUS_BAD_INPUT,
                                      "%s: belongs to a stop; write stop: {%s: ...}", name.text, c->unknown);
    if (c->top[0] && known_name(reading, c->unknown))
        return saltus_source_fail(source, line, SALTUS_BAD_INPUT,
                                  "%s: belongs to the top level, not below %s", name.text, c->top);
    if (!model)
        return saltus_source_fail(
            source, line, SALTUS_BAD_INPUT,
            "%s: unknown key; a scene names its model (model: pipe, say) and that model's keys", name.text);
    const char *keys[SALTUS_TOP_KEYS_MAX];
    int count = possible_keys(model, c->top, keys);
    return saltus_unknown_key(source, line, c->unknown, keys, count);
}

static saltus_status fail_kind(const saltus_source *source, const complaint *c, int line) {
    if (!c->field[0])
        return saltus_source_fail(source, line, SALTUS_BAD_INPUT,
                                  "must be a mapping of keys to values that begins with model: pipe, say");
    return saltus_source_fail(source, line, SALTUS_BAD_INPUT, "%s: %s", c->field, wanted_kind(c->field));
}

static saltus_status fail_count(const saltus_source *source, const complaint *c, int line) {
    if (strcmp(c->field, "stops") == 0)
        return saltus_source_fail(source, line, SALTUS_BAD_INPUT, "stops: too many; at most %d are possible",
                                  SALTUS_STOPS_MAX);
    if (strcmp(c->field, "weight") == 0)
        return fail_kind(source, c, line);
    return saltus_source_fail(source, line, SALTUS_BAD_INPUT, "%s: too many entries; at most %d are possible",
                              c->field, SALTUS_SCENE_STATE_MAX);
}

/* Write a sentence for what libcyaml refused. */
static saltus_status refuse(const saltus_source *source, const saltus_reading *reading, cyaml_err_t error,
                            const complaint *c) {
    bool nested = c->top[0] && strcmp(c->top, c->field) != 0;
    saltus_place place = {nested ? c->top : NULL, c->entry, c->field};
    bool duplicate = strstr(c->problem, "already seen") != NULL;
    int found = saltus_place_line(source, place, duplicate), line = found ? found : c->line;
    switch (error) {
    case CYAML_ERR_OOM:
        return saltus_source_fail(source, 0, SALTUS_NO_MEMORY, "no memory for reading the scene");
    case CYAML_ERR_ALIAS:
        return saltus_source_fail(source, line, SALTUS_BAD_INPUT,
                                  "aliases (*name) are not possible in scenes; write the value itself");
    case CYAML_ERR_INVALID_KEY:
        return fail_unknown(source, reading, c);
    case CYAML_ERR_INVALID_VALUE:
        return fail_kind(source, c, line);
    case CYAML_ERR_SEQUENCE_ENTRIES_MIN:
    case CYAML_ERR_SEQUENCE_ENTRIES_MAX:
        return fail_count(source, c, line);
    case CYAML_ERR_LIBYAML_PARSER:
        return saltus_source_fail(
            source, c->line, SALTUS_BAD_INPUT, "not valid YAML%s: %s", c->line ? " here or below" : "",
            strncmp(c->problem, "libyaml: ", 9) == 0 ? c->problem + 9 : "cannot be parsed");
    default:
        if (duplicate)
            return saltus_source_fail(source, line, SALTUS_BAD_INPUT, "%s: given twice; keep one of them",
                                      c->field);
        return saltus_source_fail(source, c->line, SALTUS_BAD_INPUT, "not a scene here or below: %s",
                                  c->problem[0] ? c->problem : "keys must be single words");
    }
}

saltus_status saltus_reading_open(const saltus_source *source, saltus_reading *reading) {
    *reading = (saltus_reading){0};
    complaint complaint = {.problem = ""};
    saltus_status status = SALTUS_OK;
    if (!build_schema(reading)) {
        status = saltus_source_fail(source, 0, SALTUS_NO_MEMORY, "no memory for reading the scene");
    } else {
        const schema *made = reading->schema;
        const cyaml_config_t config = {.log_fn = catch,
                                       .log_ctx = &complaint,
                                       .mem_fn = provide,
                                       .log_level = CYAML_LOG_WARNING,
                                       .flags = CYAML_CFG_NO_ALIAS};
        cyaml_err_t error = cyaml_load_data((const uint8_t *)source->text, source->length, &config,
                                            &made->scene, (cyaml_data_t **)&reading->raw, NULL);
        if (error != CYAML_OK)
            status = refuse(source, reading, error, &complaint);
        else if (complaint.problem[0])
            status = saltus_source_fail(source, 0, SALTUS_BAD_INPUT,
                                        "holds more than one YAML document; keep one scene in a file");
        else if (!reading->raw)
            status = saltus_source_fail(source, 0, SALTUS_BAD_INPUT,
                                        "is empty; a scene names at least its model (model: pipe, say)");
    }
    if (status != SALTUS_OK)
        saltus_reading_close(reading);
    return status;
}

void saltus_reading_close(saltus_reading *reading) {
    cyaml_config_t config = {.mem_fn = provide, .flags = CYAML_CFG_NO_ALIAS};
    const schema *made = reading->schema;
    if (reading->raw)
        cyaml_free(&config, &made->scene, reading->raw, 0);
    free(reading->names);
    free(reading->schema);
    *reading = (saltus_reading){0};
}
