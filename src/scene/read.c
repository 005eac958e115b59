/* From the tree of a scene's text to numbers, stops and an initial state, checked with a trial system.
 *
 * First all keys and the kinds of their values are checked, in the order of the text, then the values are
 * read: which keys the scene may have depends on its model.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"
#include "system/system.h"

#include <stdio.h>
#include <string.h>

/* Whether a key is a parameter of `model` (may be NULL) or of any built-in model. */
static bool is_parameter(const saltus_model *model, const char *key) {
    if (model && saltus_model_parameter_index(model, key) >= 0)
        return true;
    for (int k = 0; k < saltus_model_count(); k++)
        if (saltus_model_parameter_index(saltus_model_at(k), key) >= 0)
            return true;
    return false;
}

/* Refuse an unknown key in the mapping `top`; NULL: at the top level. */
static saltus_status fail_unknown(const saltus_source *source, const saltus_node *node, const char *top,
                                  const saltus_model *model) {
    const char *keys[SALTUS_TOP_KEYS_MAX];
    saltus_quoted name = saltus_quote(node->key);
    int count = initial_lists;
    if (!top && saltus_key_index(node->key, saltus_stop_keys, stop_keys) < stop_keys)
        return saltus_node_fail(source, node, "%s: belongs to a stop; write stop: {%s: ...}", name.text,
                                node->key);
    if (top && is_parameter(model, node->key))
        return saltus_node_fail(source, node, "%s: belongs to the top level, not below %s", name.text, top);
    if (!model)
        return saltus_node_fail(
            source, node, "%s: unknown key; a scene names its model (model: pipe, say) and that model's keys",
            name.text);
    if (!top)
        count = saltus_top_keys(model, keys);
    else if (strcmp(top, "initial") != 0)
        count = saltus_model_stop_keys(model, keys);
    else
        memcpy(keys, saltus_initial_keys, sizeof saltus_initial_keys);
    return saltus_unknown_key(source, node->key_line, node->key, keys, count);
}

/* Whether a value is of the given kind and its children, if any, are of the kind `children`. */
static bool has_kind(const saltus_node *node, saltus_node_kind kind, saltus_node_kind children) {
    bool fits = node->kind == kind;
    for (const saltus_node *child = node->first; child && fits; child = child->next)
        fits = child->kind == children;
    return fits;
}

static const char single[] = "a single value, not a list or a mapping";

static saltus_status check_stop(const saltus_source *source, const saltus_node *stop, const char *top,
                                const saltus_model *model) {
    for (const saltus_node *node = stop->first; node; node = node->next) {
        int key = saltus_key_index(node->key, saltus_stop_keys, stop_keys);
        if (key == stop_keys)
            return fail_unknown(source, node, top, model);
        if (key != stop_weight && node->kind != SALTUS_NODE_SCALAR)
            return saltus_kind_fail(source, node, single);
        if (key == stop_weight &&
            !(has_kind(node, SALTUS_NODE_LIST, SALTUS_NODE_SCALAR) && node->count >= 1 && node->count <= 2))
            return saltus_kind_fail(source, node, "a list of 1 or 2 numbers, such as [1, -1]");
    }
    return SALTUS_OK;
}

static saltus_status check_initial(const saltus_source *source, const saltus_node *initial,
                                   const saltus_model *model) {
    if (initial->kind != SALTUS_NODE_MAPPING)
        return saltus_kind_fail(source, initial, "a mapping of lists: initial: {q: [...], v: [...]}");
    for (const saltus_node *node = initial->first; node; node = node->next) {
        if (saltus_key_index(node->key, saltus_initial_keys, initial_lists) == initial_lists)
            return fail_unknown(source, node, "initial", model);
        if (!has_kind(node, SALTUS_NODE_LIST, SALTUS_NODE_SCALAR))
            return saltus_kind_fail(source, node, "a list of numbers");
        if (node->count > SALTUS_SCENE_STATE_MAX)
            return saltus_node_fail(source, node, "%s: too many entries; at most %d are possible", node->key,
                                    SALTUS_SCENE_STATE_MAX);
    }
    return SALTUS_OK;
}

static saltus_status check_keys(const saltus_source *source, const saltus_node *root, bool others,
                                const saltus_model *model) {
    saltus_status status = SALTUS_OK;
    for (const saltus_node *node = root->first; node && status == SALTUS_OK; node = node->next) {
        if (strcmp(node->key, "stops") == 0) {
            if (!has_kind(node, SALTUS_NODE_LIST, SALTUS_NODE_MAPPING))
                status = saltus_kind_fail(source, node, "a list of stops: stops: [{d: ...}, {d: ...}]");
            else if (node->count > SALTUS_STOPS_MAX)
                status = saltus_node_fail(source, node, "stops: too many; at most %d are possible",
                                          SALTUS_STOPS_MAX);
            for (const saltus_node *stop = node->first; stop && status == SALTUS_OK; stop = stop->next)
                status = check_stop(source, stop, "stops", model);
        } else if (strcmp(node->key, "stop") == 0)
            status = node->kind == SALTUS_NODE_MAPPING
                         ? check_stop(source, node, "stop", model)
                         : saltus_kind_fail(source, node,
                                            "a mapping with the keys of a stop: stop: {d: ..., r: ...}");
        else if (strcmp(node->key, "initial") == 0)
            status = model && model->text ? SALTUS_OK : check_initial(source, node, model);
        else if (strcmp(node->key, "model") == 0 && model && model->text)
            continue;
        else if (strcmp(node->key, "model") == 0 || strcmp(node->key, "title") == 0 ||
                 strcmp(node->key, "observe") == 0 || is_parameter(model, node->key))
            status = node->kind == SALTUS_NODE_SCALAR ? SALTUS_OK : saltus_kind_fail(source, node, single);
        else if (!others)
            status = fail_unknown(source, node, NULL, model);
    }
    return status;
}

/* Fail with "key = value: complaint"; for entries of a list the key is that of the list. */
static saltus_status fail_value(const saltus_source *source, const saltus_node *node, const char *key,
                                const char *complaint) {
    saltus_quoted quoted = saltus_quote(node->text);
    return saltus_node_fail(source, node, "%s = %s: %s", key, quoted.text, complaint);
}

static saltus_status read_number(const saltus_source *source, const saltus_node *node, const char *key,
                                 double *value) {
    const char *complaint = saltus_read_number(node->text, value);
    return complaint ? fail_value(source, node, key, complaint) : SALTUS_OK;
}

static saltus_status read_numbers(const saltus_source *source, const saltus_node *list, double *values) {
    saltus_status status = SALTUS_OK;
    for (const saltus_node *node = list->first; node && status == SALTUS_OK; node = node->next)
        status = read_number(source, node, list->key, values++);
    return status;
}

static saltus_status fail_model(const saltus_source *source, const saltus_node *root) {
    const saltus_node *node = saltus_node_member(root, "model");
    saltus_words names = {""};
    for (int k = 0; k < saltus_model_count(); k++)
        saltus_words_add(&names, saltus_model_name(saltus_model_at(k)));
    if (!node)
        return saltus_source_fail(source, 0, SALTUS_BAD_INPUT,
                                  "model: missing; the models are %s, or a mapping with equations",
                                  names.text);
    saltus_quoted quoted = saltus_quote(node->text);
    for (int k = 0; k < saltus_builtin_count; k++)
        if (strcmp(saltus_builtins[k].name, node->text) == 0)
            return saltus_node_fail(source, node,
                                    "model = %s: is a scene, not a model; saltus scenes %s > mine.yaml makes "
                                    "one to change",
                                    quoted.text, node->text);
    return saltus_node_fail(source, node,
                            "model = %s: unknown; the models are %s, or a mapping with equations",
                            quoted.text, names.text);
}

static saltus_status read_parameters(const saltus_source *source, const saltus_node *root,
                                     saltus_scene *scene) {
    const saltus_model *model = scene->spec.model;
    saltus_status status = SALTUS_OK;
    for (const saltus_node *node = root->first; node && status == SALTUS_OK; node = node->next) {
        int index = saltus_model_parameter_index(model, node->key);
        if (index >= 0)
            status = read_number(source, node, node->key, &scene->spec.parameters[index]);
        else if (is_parameter(NULL, node->key)) {
            const char *keys[SALTUS_TOP_KEYS_MAX];
            int count = saltus_top_keys(model, keys);
            status = saltus_node_fail(source, node, "\"%s\": not a key of the model %s; its keys are %s",
                                      node->key, saltus_model_name(model), saltus_words_of(keys, count).text);
        }
    }
    return status;
}

/* `number` is the stop's number, from 1, if there are several; 0: the only one. */
static saltus_status read_stop(const saltus_source *source, const saltus_node *node, int number,
                               const saltus_model *model, saltus_stop *stop) {
    *stop = saltus_stop_defaults();
    if (!saltus_node_member(node, "d")) {
        char which[16] = "";
        if (number)
            snprintf(which, sizeof which, " %d", number);
        return saltus_source_fail(source, node->line, SALTUS_BAD_INPUT,
                                  "stop%s: d is missing; a stop needs its clearance d", which);
    }
    saltus_status status = SALTUS_OK;
    for (const saltus_node *value = node->first; value && status == SALTUS_OK; value = value->next) {
        int key = saltus_key_index(value->key, saltus_stop_keys, stop_keys);
        const char *complaint = NULL;
        if (!saltus_model_has_stop_key(model, key))
            status = saltus_node_fail(source, value, "%s: a stop of the model %s is placed by %s", value->key,
                                      saltus_model_name(model), model->stop_key);
        else if (key == stop_coordinate ||
                 (model->text && key != stop_sides && saltus_read_stop(stop, key, value->text)))
            continue; /* already read by the model */
        else if (key == stop_weight) {
            stop->weight[0] = stop->weight[1] = 0;
            status = read_numbers(source, value, stop->weight);
        } else if ((complaint = saltus_read_stop(stop, key, value->text)))
            status = fail_value(source, value, value->key, complaint);
    }
    return status;
}

static saltus_status read_stops(const saltus_source *source, const saltus_node *root, saltus_scene *scene) {
    const saltus_node *one = saltus_node_member(root, "stop"), *several = saltus_node_member(root, "stops");
    saltus_spec *spec = &scene->spec;
    saltus_status status = SALTUS_OK;
    if (one && several)
        return saltus_node_fail(source, several, "stops: stop is given too; keep one of them");
    const saltus_node *node = one ? one : several ? several->first : NULL;
    for (; node && status == SALTUS_OK; node = one ? NULL : node->next, spec->stop_count++)
        status = read_stop(source, node, one ? 0 : spec->stop_count + 1, spec->model,
                           &spec->stops[spec->stop_count]);
    return status;
}

/* Add the line of the value at fault, or of the stop that lacks it, to the system's message. */
static saltus_status fail_system(const saltus_source *source, const saltus_node *root, saltus_status status,
                                 const saltus_message *reason) {
    const saltus_node *owner = root;
    if (reason->stop > 0) {
        const saltus_node *one = saltus_node_member(root, "stop");
        owner = one ? one : saltus_node_child(saltus_node_member(root, "stops"), reason->stop - 1);
    }
    const saltus_node *value = saltus_node_member(owner, reason->key);
    int line = value ? value->key_line : owner && owner != root ? owner->line : 0;
    saltus_source_fail(source, line, status, "%s", reason->text);
    if (source->message) {
        memcpy(source->message->key, reason->key, sizeof reason->key);
        source->message->stop = reason->stop;
    }
    return status;
}

static saltus_status read_initial(const saltus_source *source, const saltus_node *initial,
                                  const saltus_system *system, saltus_scene *scene) {
    int dof = saltus_system_dof(system), extra = saltus_system_extra(system);
    int room[initial_lists] = {dof, dof, extra}, first[initial_lists] = {0, dof, 2 * dof};
    scene->initial_count = saltus_system_dimension(system);
    for (const saltus_node *list = initial->first; list; list = list->next) {
        int k = saltus_key_index(list->key, saltus_initial_keys, initial_lists);
        if (list->count > room[k])
            return saltus_node_fail(source, list, "%s: too many entries (%d); the system has %d", list->key,
                                    list->count, room[k]);
        saltus_status status = read_numbers(source, list, &scene->initial[first[k]]);
        if (status != SALTUS_OK)
            return status;
    }
    saltus_message reason;
    saltus_status status = saltus_system_check_state(system, scene->initial, &reason);
    return status == SALTUS_OK ? status
                               : saltus_source_fail(source, initial->key_line, status, "%s", reason.text);
}

static saltus_status read_scene(const saltus_source *source, const saltus_node *root, bool others,
                                const saltus_model *model, saltus_scene *made) {
    saltus_status status = check_keys(source, root, others, model);
    if (status != SALTUS_OK)
        return status;
    if (!model)
        return fail_model(source, root);
    made->spec = saltus_spec_defaults(model);
    const saltus_node *title = saltus_node_member(root, "title");
    if (title && strlen(title->text) >= sizeof made->title)
        return saltus_node_fail(source, title, "title: too long; at most %d bytes are possible",
                                (int)sizeof made->title - 1);
    for (const char *c = title ? title->text : ""; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            return saltus_node_fail(source, title, "title: must be one line without control characters");
    if (title)
        strcpy(made->title, title->text);
    status = read_parameters(source, root, made);
    if (status == SALTUS_OK)
        status = read_stops(source, root, made);
    const saltus_node *observe = saltus_node_member(root, "observe"),
                      *initial = saltus_node_member(root, "initial");
    if (status != SALTUS_OK)
        return status;
    if (observe && strlen(observe->text) >= sizeof made->spec.observe)
        return fail_value(source, observe, observe->key, "too long for a name");
    if (observe)
        strcpy(made->spec.observe, observe->text);

    saltus_system *system = NULL;
    saltus_message reason;
    status = saltus_system_new(&made->spec, &system, &reason);
    if (status != SALTUS_OK)
        return fail_system(source, root, status, &reason);
    if (initial && !model->text)
        status = read_initial(source, initial, system, made);
    saltus_system_free(system);
    if (status == SALTUS_OK && saltus_spec_check_poincare(&made->spec, &reason) != SALTUS_OK)
        return fail_system(source, saltus_node_member(root, "model"), SALTUS_BAD_INPUT, &reason);
    return status;
}

saltus_status saltus_scene_read(const saltus_source *source, const saltus_node *root, bool others,
                                saltus_scene *scene) {
    saltus_scene made = {.initial_count = 0};
    const saltus_model *model = NULL; /* by name or from its text, to be released; NULL: the key is absent */
    saltus_status status = SALTUS_OK;
    if (root->kind != SALTUS_NODE_MAPPING)
        return saltus_source_fail(source, root->line, SALTUS_BAD_INPUT,
                                  "must be a mapping of keys to values that begins with model: pipe, say");
    const saltus_node *name = saltus_node_member(root, "model");
    const bool word = name && name->kind == SALTUS_NODE_SCALAR;
    if (name && name->kind == SALTUS_NODE_MAPPING)
        status = saltus_scene_read_text(source, root, source, name, &model);
    else if (word && strpbrk(name->text, "/."))
        status = saltus_scene_read_model_file(source, root, &model);
    else if (word && name->text[0] && !(model = saltus_model_find(name->text)))
        status = fail_model(source, root);
    if (status == SALTUS_OK)
        status = read_scene(source, root, others, model, &made);
    if (status == SALTUS_OK)
        *scene = made;
    else
        saltus_model_release(model);
    return status;
}
