/* The list of models.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/system.h"

#include <string.h>

static const saltus_model *const models[] = {
    &saltus_pipe,
    &saltus_oscillator,
};

int saltus_model_count(void) {
    return (int)(sizeof models / sizeof models[0]);
}

const saltus_model *saltus_model_at(int k) {
    return k >= 0 && k < saltus_model_count() ? models[k] : NULL;
}

const saltus_model *saltus_model_find(const char *name) {
    for (int k = 0; k < saltus_model_count(); k++)
        if (strcmp(models[k]->name, name) == 0)
            return models[k];
    return NULL;
}

const char *saltus_model_name(const saltus_model *model) {
    return model->name;
}

const char *saltus_model_summary(const saltus_model *model) {
    return model->summary;
}

const saltus_parameter *saltus_model_parameters(const saltus_model *model, int *count) {
    *count = model->parameter_count;
    return model->parameters;
}

const saltus_notation *saltus_model_notation(const saltus_model *model) {
    return &model->notation;
}

const char *saltus_model_stop_key(const saltus_model *model) {
    return model->stop_key;
}

const double *saltus_stop_place(const saltus_model *model, const saltus_stop *stop, int *count) {
    *count = model->stop_numbers;
    return (const double *)(const void *)((const char *)stop + model->stop_place);
}

int saltus_model_parameter_index(const saltus_model *model, const char *name) {
    for (int k = 0; k < model->parameter_count; k++)
        if (strcmp(model->parameters[k].name, name) == 0)
            return k;
    return -1;
}

void saltus_model_retain(const saltus_model *model) {
    if (model && model->own)
        model->own(model, 1);
}

void saltus_model_release(const saltus_model *model) {
    if (model && model->own)
        model->own(model, -1);
}

const char *saltus_model_text(const saltus_model *model) {
    return model->text;
}

bool saltus_model_same(const saltus_model *a, const saltus_model *b) {
    return a == b || (a && b && a->text && b->text && strcmp(a->text, b->text) == 0);
}

const char *saltus_stop_text(const saltus_spec *spec, int stop, saltus_stop_part part) {
    return spec->model->coordinate ? spec->model->coordinate(spec->model, stop, (int)part) : NULL;
}

const char *saltus_restitution_law(const saltus_spec *spec, int stop) {
    bool law = spec->model->by_speed && spec->model->by_speed(spec, stop);
    return law ? saltus_stop_text(spec, stop, SALTUS_STOP_RESTITUTION) : NULL;
}
