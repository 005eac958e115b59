/* Identity of a sweep: a text that is equal for equal sweeps, and whose first difference can be named.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/sweep_output.h"
#include "sweep/options.h"

#include <stdlib.h>
#include <string.h>

saltus_sweep_file saltus_sweep_head(const saltus_sweep *sweep, bool basins, bool complete) {
    const saltus_scene *scene = saltus_sweep_scene(sweep);
    saltus_sweep_file head = {.version = SALTUS_VERSION,
                              .basins = basins,
                              .complete = complete,
                              .spec = scene->spec,
                              .axis_count = saltus_sweep_axis_count(sweep),
                              .options = *saltus_sweep_choices(sweep),
                              .initial_count = scene->initial_count,
                              .pass_count = saltus_sweep_pass_count(sweep),
                              .points = saltus_sweep_points(sweep),
                              .row_count = saltus_sweep_rows(sweep),
                              .dimension = saltus_sweep_dimension(sweep)};
    snprintf(head.scene, sizeof head.scene, "%s", scene->name);
    snprintf(head.title, sizeof head.title, "%s", scene->title);
    memcpy(head.initial, scene->initial, (size_t)scene->initial_count * sizeof *head.initial);
    for (int k = 0; k < head.axis_count; k++)
        head.axes[k] = *saltus_sweep_axis(sweep, k);
    for (int k = 0; k < head.pass_count; k++)
        head.passes[k] = saltus_sweep_pass_at(sweep, k);
    return head;
}

typedef struct writer {
    FILE *file;
    const char *prefix;
} writer;

static void put_word(const writer *w, const char *name, const char *word) {
    fprintf(w->file, "%s%s = %s\n", w->prefix, name, word);
}

static void put_real(const writer *w, const char *name, double value) {
    char text[SALTUS_NUMBER_MAX];
    put_word(w, name, saltus_number(value, text));
}

static void put_whole(const writer *w, const char *name, long long value) {
    fprintf(w->file, "%s%s = %lld\n", w->prefix, name, value);
}

/* A grid by its ends and count, a list value by value. */
static void put_axis(const writer *w, const saltus_axis *axis, int k) {
    char name[64];
    snprintf(name, sizeof name, "axis %d", k + 1);
    put_word(w, name, axis->key);
    snprintf(name, sizeof name, "%s values", axis->key);
    put_whole(w, name, axis->count);
    snprintf(name, sizeof name, "%s spacing", axis->key);
    put_word(w, name, saltus_word_of(saltus_spacing_words, (int)axis->spacing));
    for (int i = 0; i < axis->count;
         i += axis->spacing == SALTUS_LIST || axis->count == 1 ? 1 : axis->count - 1) {
        snprintf(name, sizeof name, "%s value %d", axis->key, i + 1);
        put_real(w, name, saltus_axis_value(axis, i));
    }
}

void saltus_sweep_identity_put(FILE *file, const saltus_sweep_file *head, const char *prefix) {
    const writer w = {file, prefix};
    const saltus_spec *spec = &head->spec;
    char name[64], text[SALTUS_FIELD_TEXT_MAX];
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    put_word(&w, "version", head->version);
    put_word(&w, "kind", head->basins ? "basins" : "sweep");
    put_word(&w, "model", saltus_model_name(spec->model));
    for (int k = 0; k < count; k++)
        put_real(&w, p[k].name, spec->parameters[k]);
    if (spec->observe[0])
        put_word(&w, "observe", spec->observe);
    put_whole(&w, "stops", spec->stop_count);
    for (int s = 0; s < spec->stop_count; s++) {
        fprintf(file, "%sstop %d = ", prefix, s + 1);
        saltus_put_stop(file, spec, s);
        fputc('\n', file);
    }
    put_whole(&w, "initial entries", head->initial_count);
    for (int k = 0; k < head->initial_count; k++) {
        snprintf(name, sizeof name, "initial entry %d", k + 1);
        put_real(&w, name, head->initial[k]);
    }
    put_whole(&w, "axes", head->axis_count);
    for (int k = 0; k < head->axis_count; k++)
        put_axis(&w, &head->axes[k], k);
    for (int k = 0; k < saltus_sweep_table.count; k++) {
        const saltus_option *option = &saltus_sweep_table.options[k];
        const char *value = saltus_field_text(&option->field, &head->options, text);
        /* `keep` is 0. */
        if (!option->apart)
            put_word(&w, option->field.name, value[0] ? value : "rows");
    }
}

char *saltus_sweep_identity_text(const saltus_sweep_file *head) {
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (!stream)
        return NULL;
    saltus_sweep_identity_put(stream, head, "");
    bool sound = !ferror(stream);
    if (fclose(stream) == 0 && sound)
        return text;
    free(text);
    return NULL;
}

/* Name and value in a line. */
typedef struct entry {
    int name_length, value_length;
    const char *name, *value;
} entry;

static entry entry_of(const char *line) {
    size_t length = strcspn(line, "\n"), name = 0;
    while (name < length && strncmp(line + name, " = ", 3) != 0)
        name++;
    size_t value = name + 3 < length ? name + 3 : length;
    return (entry){(int)(name < 60 ? name : 60), (int)(length - value < 100 ? length - value : 100), line,
                   line + value};
}

saltus_status saltus_sweep_identity_compare(const char *path, const char *there, const char *here,
                                            saltus_message *message) {
    if (strcmp(there, here) == 0)
        return SALTUS_OK;
    size_t k = 0, begin = 0;
    for (; there[k] && there[k] == here[k]; k++)
        if (here[k] == '\n')
            begin = k + 1;
    entry a = entry_of(there + begin), b = entry_of(here + begin);
    if (a.name_length != b.name_length || strncmp(a.name, b.name, (size_t)a.name_length) != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%s: is of another sweep: %.*s is not among its entries", path, b.name_length,
                           b.name);
    return saltus_fail(message, SALTUS_BAD_INPUT, "%s: is of another sweep: %.*s is %.*s there and %.*s now",
                       path, a.name_length, a.name, a.value_length, a.value, b.value_length, b.value);
}
