/* Reading an orbit to start from: JSON written by this program, a point of a branch file, a row of a sweep.
 *
 * The parameters of a JSON object are read like a scene, with the same checks and messages.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/hdf5.h"
#include "saltus/record.h"
#include "scene/scene.h"
#include "system/system.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { path_size = 4096, word_size = 64 };

/* A file's name and the part of it that is selected. */
typedef struct source {
    char path[path_size];
    char part[word_size]; /* after the last colon; "" for the whole file */
} source;

/* The text as a whole number from 1 on; 0 if it is none. */
static long part_number(const char *text) {
    size_t digits = strspn(text, "0123456789");
    return digits > 0 && digits < 10 && text[digits] == '\0' ? atol(text) : 0;
}

/* The row selected by "12" or "PD1"; -1 if there is none. */
static int find_row(const saltus_branch_file *file, const char *part) {
    long number = part_number(part), seen = 0;
    if (number)
        return number <= file->point_count ? (int)number - 1 : -1;
    for (int k = 1; k < SALTUS_POINT_KINDS; k++) {
        const char *word = saltus_point_word((saltus_point_kind)k);
        size_t length = strlen(word);
        if (strncmp(part, word, length) != 0)
            continue;
        number = part[length] ? part_number(part + length) : 1;
        for (int row = 0; number && row < file->point_count; row++)
            if (file->points[row].kind == (saltus_point_kind)k && ++seen == number)
                return row;
    }
    return -1;
}

static saltus_status read_point(const source *s, saltus_start *start, saltus_message *message) {
    saltus_branch_file file;
    saltus_status status = saltus_branch_file_read(s->path, &file, message);
    if (status != SALTUS_OK)
        return status;
    int row = find_row(&file, s->part);
    if (!s->part[0])
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "%.300s: holds a branch of %d points; name one of them, as in %.100s:12 or "
                             "%.100s:PD1",
                             s->path, file.point_count, s->path, s->path);
    else if (row < 0)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "%.300s: has no point %s; its rows go from 1 to %d, special points are named "
                             "like PD1",
                             s->path, s->part, file.point_count);
    else if (file.dimension > SALTUS_SCENE_STATE_MAX)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: the state is too long", s->path);
    if (status == SALTUS_OK) {
        const saltus_branch_point *point = &file.points[row];
        *start = (saltus_start){.spec = point->spec,
                                .periods = point->periods,
                                .own_period = point->trivial_multiplier != 0,
                                .rests = point->periods == 0,
                                .dimension = file.dimension};
        memcpy(start->state, point->state, (size_t)file.dimension * sizeof *start->state);
        snprintf(start->label, sizeof start->label, "%s", point->label);
    }
    if (status == SALTUS_OK)
        saltus_model_retain(start->spec.model);
    saltus_branch_file_clear(&file);
    return status;
}

__attribute__((format(printf, 3, 4))) static saltus_status refuse(const source *s, saltus_message *message,
                                                                  const char *format, ...) {
    char what[200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s%s%s: %s", s->path, s->part[0] ? ":" : "", s->part,
                       what);
}

/* The text of line `number`, counted from 1; false if there are fewer lines. */
static bool find_line(const char **text, size_t *length, long number) {
    const char *at = *text, *end = *text + *length;
    for (long k = 1; k < number && at < end; k++) {
        const char *feed = memchr(at, '\n', (size_t)(end - at));
        at = feed ? feed + 1 : end;
    }
    const char *feed = at < end ? memchr(at, '\n', (size_t)(end - at)) : NULL;
    *length = (size_t)((feed ? feed : end) - at);
    *text = at;
    return *length > 0;
}

/* Read a text that must be one object. */
static saltus_status read_document(const source *s, const saltus_source *json, saltus_document *document) {
    const char *end = json->text + json->length, *begin = json->text;
    while (begin < end && strchr(" \t\r\n", *begin) && *begin)
        begin++;
    if (begin == end || *begin != '{')
        return refuse(s, json->message, "is no orbit: neither a JSON object nor an HDF5 file");
    saltus_status status = saltus_document_read(json, document);
    if (status != SALTUS_OK && json->message->cause == SALTUS_CAUSE_CUT_OFF) {
        refuse(s, json->message, "is cut off: the JSON object does not end");
        json->message->cause = SALTUS_CAUSE_CUT_OFF;
    }
    return status;
}

/* Read the object that describes the orbit: the whole text, one of its lines, or an entry of a list of
 * attractors. *json tells what was read. */
static saltus_status find_object(const source *s, saltus_source *json, saltus_document *document,
                                 const saltus_node **object) {
    saltus_message *message = json->message;
    const char *text = json->text;
    size_t length = json->length;
    long number = part_number(s->part);
    if (s->part[0] && !number)
        return refuse(s, message, "in a JSON file orbits are named by their number, from 1");
    saltus_status status = read_document(s, json, document);
    const saltus_node *list = status == SALTUS_OK ? saltus_node_member(document->root, "attractors") : NULL;
    *object = document->root;
    if (list) {
        if (!number)
            return refuse(s, message, "holds a list of attractors; name one, as in FILE:1");
        *object = saltus_node_member(saltus_node_child(list, (int)number - 1), "motion");
        return *object ? SALTUS_OK : refuse(s, message, "there is no such attractor in the file");
    }
    if (number > 1 || (number && status != SALTUS_OK)) {
        saltus_document_close(document);
        if (!find_line(&text, &length, number))
            return refuse(s, message, "there is no such line in the file");
        json->text = text;
        json->length = length;
        json->lines_before = (int)number - 1;
        status = read_document(s, json, document);
        *object = document->root;
    } else if (status != SALTUS_OK && message->cause == SALTUS_CAUSE_SEVERAL &&
               find_line(&text, &length, message->line) && *text == '{')
        return refuse(s, message, "holds several orbits; name one by its line, as in FILE:1");
    return status;
}

/* The text of a member of an object; NULL if there is none. */
static const char *word_of(const saltus_node *object, const char *key) {
    const saltus_node *node = saltus_node_member(object, key);
    return node && node->kind == SALTUS_NODE_SCALAR && node->quoted ? node->text : NULL;
}

/* A finite number; false for anything else. */
static bool number_of(const saltus_node *node, double *number) {
    return node && node->kind == SALTUS_NODE_SCALAR && !node->quoted &&
           !saltus_read_number(node->text, number);
}

static saltus_status read_parameters(const source *s, const saltus_source *json, const saltus_node *object,
                                     saltus_start *start) {
    const saltus_node *parameters = saltus_node_member(object, "parameters");
    const char *name = word_of(parameters, "model");
    const saltus_node *text = saltus_node_member(parameters, "model");
    const saltus_model *model = name ? saltus_model_find(name) : NULL;
    if (!model && !(text && text->kind == SALTUS_NODE_MAPPING))
        return refuse(s, json->message, "parameters: must be an object that names a known model");
    int count = 0;
    const saltus_parameter *p = model ? saltus_model_parameters(model, &count) : NULL;
    for (int k = 0; k <= count; k++) {
        const char *key = k < count ? p[k].name : "stops";
        if (!saltus_node_member(parameters, key))
            return refuse(s, json->message, "parameters: %s is missing", key);
    }
    saltus_scene scene;
    saltus_status status = saltus_scene_read(json, parameters, true, &scene);
    if (status == SALTUS_OK)
        start->spec = scene.spec;
    return status;
}

static saltus_status read_object(const source *s, const saltus_source *json, const saltus_node *object,
                                 saltus_start *start) {
    saltus_message *message = json->message;
    double periods = 0, period;
    if (!word_of(object, "version"))
        return refuse(s, message,
                      "is not an orbit of classify, orbit or continue --json: it has no key version");
    /* A branch point stores n/p under `motion` and its own label under `label`. */
    const char *motion = word_of(object, "motion"), *label = motion ? motion : word_of(object, "label");
    if (label)
        snprintf(start->label, sizeof start->label, "%s", label);
    if (!number_of(saltus_node_member(object, "periods"), &periods) || periods != floor(periods) ||
        periods < 0 || periods > 1e6)
        return refuse(s, message, "periods: must be a whole number from 1 to 1000000");
    start->rests = periods == 0 && saltus_node_member(object, "eigenvalues");
    if (periods == 0 && !start->rests)
        return refuse(s, message, "holds no periodic orbit (the motion is %s, periods is 0)", start->label);
    start->periods = (int)periods;
    saltus_status status = read_parameters(s, json, object, start);
    start->own_period = saltus_node_member(object, "trivial_multiplier") != NULL;
    if (status == SALTUS_OK && start->own_period) {
        if (!number_of(saltus_node_member(object, "period"), &period) || !(period > 0))
            return refuse(s, message, "period: must be a number greater than 0");
        saltus_spec_set_omega(&start->spec, 2 * M_PI / period);
    }
    saltus_system *system = NULL;
    if (status == SALTUS_OK)
        status = saltus_system_new(&start->spec, &system, message);
    start->dimension = status == SALTUS_OK ? saltus_system_dimension(system) : 0;
    saltus_system_free(system);
    const saltus_node *state = saltus_node_member(object, "state");
    if (status != SALTUS_OK)
        return status;
    if (!state || state->kind != SALTUS_NODE_LIST)
        return refuse(s, message, "state: must be a list of numbers");
    if (state->count != start->dimension || state->count > SALTUS_SCENE_STATE_MAX)
        return refuse(s, message, "state: has %d entries, its parameters make it %d", state->count,
                      start->dimension);
    int i = 0;
    for (const saltus_node *entry = state->first; entry; entry = entry->next, i++)
        if (!number_of(entry, &start->state[i]))
            return refuse(s, message, "state: entry %d must be a finite number", i + 1);
    return SALTUS_OK;
}

static saltus_status read_json(const source *s, saltus_start *start, saltus_message *message) {
    enum { largest_file = 1 << 28 };
    struct stat facts;
    FILE *file = fopen(s->path, "rb");
    char *text = NULL;
    size_t length = 0;
    const saltus_node *object = NULL;
    saltus_document document = {NULL, NULL};
    saltus_status status = SALTUS_OK;
    if (!file)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: cannot be opened (%s)", s->path,
                           strerror(errno));
    bool plain = fstat(fileno(file), &facts) == 0 && S_ISREG(facts.st_mode);
    if (!plain || facts.st_size > largest_file)
        status = refuse(s, message, plain ? "is too large for an orbit" : "is not a plain file");
    else if (!(text = malloc((size_t)facts.st_size + 1)))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for reading %.300s", s->path);
    else if ((length = fread(text, 1, (size_t)facts.st_size, file)) == 0)
        status = refuse(s, message, "is empty");
    fclose(file);
    saltus_source json = {
        .text = text, .length = length, .origin = s->path, .language = "JSON", .message = message};
    if (status == SALTUS_OK)
        status = find_object(s, &json, &document, &object);
    if (status == SALTUS_OK)
        status = read_object(s, &json, object, start);
    saltus_document_close(&document);
    free(text);
    return status;
}

/* The motion of a row, at the parameters of its grid point, with a state on it: one that the file keeps, or
 * the last of the same trajectory run again. */
static saltus_status take_row(const source *s, const saltus_sweep_file *file, const saltus_sweep *sweep,
                              long long row, saltus_start *start, saltus_message *message) {
    const saltus_sweep_row *told = &file->rows[row];
    const bool periodic = told->verdict == SALTUS_PERIODIC;
    const int attractor = told->attractor;
    const double *kept = NULL;
    char other[SALTUS_LABEL_MAX];
    saltus_sweep_row again;
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_status status = SALTUS_OK;
    saltus_sweep_label(told, start->label);
    if (file->basins && attractor >= 0 && file->attractor_points[attractor] > 0)
        kept = file->attractor_states + file->attractor_first[attractor] * file->dimension;
    else if (!file->basins && file->strobe_count && file->strobe_count[row] > 0)
        kept = file->strobes + file->strobe_first[row] * file->dimension;
    if (kept)
        memcpy(start->state, kept, (size_t)file->dimension * sizeof *kept);
    else if ((status = saltus_sweep_row_again(sweep, row, &again, start->state, message)) == SALTUS_OK) {
        saltus_sweep_label(&again, other);
        if (strcmp(start->label, other) != 0)
            status = refuse(s, message,
                            "is %s there, but %s when run again; the sweep was made by another program",
                            start->label, other);
    }
    if (status == SALTUS_OK)
        status = saltus_sweep_scene_at(sweep, row / file->options.seeds % file->points, &scene, message);
    if (status == SALTUS_OK)
        status = saltus_system_new(&scene.spec, &system, message);
    if (status != SALTUS_OK)
        return status;
    const bool forced = saltus_system_forced(system);
    saltus_system_free(system);
    start->spec = scene.spec;
    start->periods = periodic ? told->periods : 0;
    start->dimension = file->dimension;
    start->rests = !forced && (told->verdict == SALTUS_EQUILIBRIUM || told->verdict == SALTUS_HELD);
    start->own_period = !forced && periodic && told->period > 0;
    if (start->own_period)
        saltus_spec_set_omega(&start->spec, 2 * M_PI / told->period);
    return SALTUS_OK;
}

/* A row of a sweep or of basins, in the order of saltus export. */
static saltus_status read_row(const source *s, const volatile sig_atomic_t *stop, saltus_start *start,
                              saltus_message *message) {
    saltus_sweep_file file;
    saltus_sweep *sweep = NULL;
    saltus_status status = saltus_sweep_file_read(s->path, &file, message);
    if (status != SALTUS_OK)
        return status;
    const long number = part_number(s->part);
    const int verdict = number >= 1 && number <= file.row_count ? file.rows[number - 1].verdict : 0;
    if (number < 1 || number > file.row_count)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "%.300s: holds a sweep of %lld rows; name one of them, as in %.100s:12", s->path,
                             file.row_count, s->path);
    else if (saltus_verdict_nothing((saltus_verdict)verdict))
        status = refuse(s, message, "its trajectory has come to nothing (%s)",
                        saltus_verdict_word((saltus_verdict)verdict));
    if (status == SALTUS_OK) {
        saltus_scene scene = {.spec = file.spec, .initial_count = file.initial_count};
        saltus_sweep_options options = file.options;
        saltus_message reason = {.text = ""};
        memcpy(scene.initial, file.initial, sizeof scene.initial);
        options.flow.stop = stop;
        status = saltus_sweep_new(&scene, file.axes, file.axis_count, &options, &sweep, &reason);
        if (status != SALTUS_OK)
            status = saltus_fail(message, status, "%.200s: %.280s", s->path, reason.text);
    }
    if (status == SALTUS_OK && saltus_sweep_dimension(sweep) != file.dimension)
        status = refuse(s, message, "its states have %d entries, its parameters make it %d", file.dimension,
                        saltus_sweep_dimension(sweep));
    if (status == SALTUS_OK)
        status = take_row(s, &file, sweep, number - 1, start, message);
    if (status == SALTUS_OK)
        saltus_model_retain(start->spec.model);
    saltus_sweep_free(sweep);
    saltus_sweep_file_clear(&file);
    return status;
}

/* A branch of orbits without forcing may end where the orbit has shrunk to an equilibrium: there it is one.
 */
static saltus_status note_rest(saltus_start *start, saltus_message *message) {
    const saltus_equilibrium_options how = saltus_equilibrium_defaults();
    const double same = 1e-7; /* relative to the system's scales */
    saltus_equilibrium rest = {0};
    saltus_system *system = NULL;
    if (!start->own_period)
        return SALTUS_OK;
    saltus_status status = saltus_system_new(&start->spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_equilibrium_find(system, start->state, &how, &rest, NULL);
    if (status == SALTUS_OK && saltus_system_distance(system, rest.state, start->state) < same) {
        start->rests = true;
        start->own_period = false;
        start->periods = 0;
        saltus_spec_set_omega(&start->spec, 2 * M_PI); /* the unit of time again */
        strcpy(start->label, saltus_verdict_word(rest.contacts ? SALTUS_HELD : SALTUS_EQUILIBRIUM));
    }
    saltus_equilibrium_clear(&rest);
    saltus_system_free(system);
    return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "no memory for the start") : SALTUS_OK;
}

void saltus_start_release(saltus_start *start) {
    saltus_model_release(start->spec.model);
    *start = (saltus_start){.periods = 0};
}

saltus_status saltus_start_read(const char *text, const volatile sig_atomic_t *stop, saltus_start *start,
                                saltus_message *message) {
    struct stat file;
    source s;
    saltus_message own; /* its cause decides what to try next */
    message = message ? message : &own;
    *start = (saltus_start){0};
    /* What follows the last colon is a part, unless there is a file of the whole name. */
    const char *colon = strrchr(text, ':');
    const bool whole = stat(text, &file) == 0 || !colon || strchr(colon, '/') || strlen(colon) > word_size;
    const size_t length = whole ? strlen(text) : (size_t)(colon - text);
    if (length == 0 || length >= path_size)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: is no file name", text);
    snprintf(s.path, sizeof s.path, "%.*s", (int)length, text);
    snprintf(s.part, sizeof s.part, "%s", whole ? "" : colon + 1);
    if (stat(s.path, &file) != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: cannot be opened (%s)", s.path,
                           strerror(errno));
    if (S_ISDIR(file.st_mode))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: is a folder, not a file with an orbit",
                           s.path);
    const saltus_file_facts facts = saltus_file_identify(s.path);
    const bool rows = strcmp(facts.kind, "sweep") == 0 || strcmp(facts.kind, "basins") == 0;
    saltus_status status = rows         ? read_row(&s, stop, start, message)
                           : facts.hdf5 ? read_point(&s, start, message)
                                        : read_json(&s, start, message);
    if (status == SALTUS_OK)
        status = note_rest(start, message);
    /* A start read from JSON may own a model even after a failure; the other starts share the model of their
     * file. */
    else if (rows || facts.hdf5)
        *start = (saltus_start){0};
    if (status != SALTUS_OK)
        saltus_start_release(start);
    return status;
}

saltus_status saltus_start_apply(const saltus_start *start, const char *name, saltus_scene *scene,
                                 saltus_message *message) {
    const char *model = saltus_model_name(scene->spec.model);
    const bool texts = saltus_model_text(start->spec.model) && saltus_model_text(scene->spec.model);
    if (texts && !saltus_model_same(start->spec.model, scene->spec.model))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is an orbit of other equations than the scene's", name);
    if (!saltus_model_same(start->spec.model, scene->spec.model))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is an orbit of the model %s, the scene's is %s", name,
                           saltus_model_name(start->spec.model), model);
    if (start->spec.stop_count != scene->spec.stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: its orbit has %d stop%s, the scene %d", name,
                           start->spec.stop_count, saltus_plural(start->spec.stop_count),
                           scene->spec.stop_count);
    /* The title describes the scene as written, so a changed scene loses it. */
    if (!saltus_spec_equal(&scene->spec, &start->spec))
        scene->title[0] = '\0';
    const saltus_spec own = scene->spec;
    scene->spec = start->spec;
    scene->spec.model = own.model;
    if (own.observe[0])
        memcpy(scene->spec.observe, own.observe, sizeof own.observe);
    scene->initial_count = 0;
    return SALTUS_OK;
}
