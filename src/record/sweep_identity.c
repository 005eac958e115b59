/* Identity of a sweep: a text that is equal for equal sweeps, and whose first difference can be named.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/sweep_output.h"
#include "sweep/options.h"

#include <stdarg.h>
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

/* A line, after the prefix. */
__attribute__((format(printf, 3, 4))) static void put(FILE *file, const char *prefix, const char *format,
                                                      ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs(prefix, file);
    vfprintf(file, format, arguments);
    fputc('\n', file);
    va_end(arguments);
}

void saltus_sweep_identity_put(FILE *file, const saltus_sweep_file *head, const char *prefix) {
    const saltus_spec *spec = &head->spec;
    char number[SALTUS_NUMBER_MAX], text[SALTUS_FIELD_TEXT_MAX];
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    put(file, prefix, "version = %s", head->version);
    put(file, prefix, "kind = %s", head->basins ? "basins" : "sweep");
    put(file, prefix, "model = %s", saltus_model_name(spec->model));
    for (int k = 0; k < count; k++)
        put(file, prefix, "%s = %s", p[k].name, saltus_number(spec->parameters[k], number));
    if (spec->observe[0])
        put(file, prefix, "observe = %s", spec->observe);
    put(file, prefix, "stops = %d", spec->stop_count);
    for (int s = 0; s < spec->stop_count; s++) {
        fprintf(file, "%sstop %d = ", prefix, s + 1);
        saltus_put_stop(file, spec, s);
        fputc('\n', file);
    }
    put(file, prefix, "initial entries = %d", head->initial_count);
    for (int k = 0; k < head->initial_count; k++)
        put(file, prefix, "initial entry %d = %s", k + 1, saltus_number(head->initial[k], number));
    put(file, prefix, "axes = %d", head->axis_count);
    /* A grid by its ends and count, a list value by value. */
    for (int k = 0; k < head->axis_count; k++) {
        const saltus_axis *axis = &head->axes[k];
        const int step = axis->spacing == SALTUS_LIST || axis->count == 1 ? 1 : axis->count - 1;
        put(file, prefix, "axis %d = %s", k + 1, axis->key);
        put(file, prefix, "%s values = %d", axis->key, axis->count);
        put(file, prefix, "%s spacing = %s", axis->key,
            saltus_word_of(saltus_spacing_words, (int)axis->spacing));
        for (int i = 0; i < axis->count; i += step)
            put(file, prefix, "%s value %d = %s", axis->key, i + 1,
                saltus_number(saltus_axis_value(axis, i), number));
    }
    for (int k = 0; k < saltus_sweep_table.count; k++) {
        const saltus_option *option = &saltus_sweep_table.options[k];
        const char *value = saltus_field_text(&option->field, &head->options, text);
        /* `keep` is 0. */
        if (!option->apart)
            put(file, prefix, "%s = %s", option->field.name, value[0] ? value : "rows");
    }
}

char *saltus_sweep_identity_text(const saltus_sweep_file *head) {
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream)
        saltus_sweep_identity_put(stream, head, "");
    return saltus_close_text(stream, &text);
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
    /* The option of the command line that sets the entry, if that has another name than the entry. A fixed
     * time has an option of its own, --transient. */
    char name[64];
    snprintf(name, sizeof name, "%.*s", b.name_length, b.name);
    const saltus_option *option = saltus_option_find(&saltus_sweep_table, name);
    const bool fixed = strcmp(name, "transient") == 0 && strstr(here, "\nadaptive = no\n");
    const char *flag = option && option->flag && strcmp(option->flag + strlen("--"), name) != 0 && !fixed
                           ? option->flag
                           : "";
    return saltus_fail(message, SALTUS_BAD_INPUT,
                       "%s: is of another sweep: %.*s%s%s%s is %.*s there and %.*s now", path, a.name_length,
                       a.name, flag[0] ? " (" : "", flag, flag[0] ? ")" : "", a.value_length, a.value,
                       b.value_length, b.value);
}
