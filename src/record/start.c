/* Reading an orbit to start from: JSON that this program wrote, or a point of a branch file.
 *
 * The parameters of a JSON object are handed to the scene reader as a scene of their own, so their checks and
 * their sentences are those of scenes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/hdf5.h"
#include "record/json_read.h"
#include "saltus/record.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { largest_file = 1 << 28, path_size = 4096, word_size = 64 };

/* A file's name and the part of it that is meant. */
typedef struct source {
    char path[path_size];
    char part[word_size]; /* behind the last colon; "" for the whole file */
} source;

static saltus_status split_source(const char *text, source *s, saltus_message *message) {
    struct stat facts;
    const char *colon = strrchr(text, ':');
    size_t length = strlen(text);
    bool whole = stat(text, &facts) == 0 || !colon || strchr(colon, '/') || strlen(colon) > word_size;
    if (!whole)
        length = (size_t)(colon - text);
    if (length == 0 || length >= path_size)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: is no file name", text);
    memcpy(s->path, text, length);
    s->path[length] = '\0';
    snprintf(s->part, sizeof s->part, "%s", whole ? "" : colon + 1);
    if (stat(s->path, &facts) != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: cannot be opened (%s)", s->path,
                           strerror(errno));
    if (S_ISDIR(facts.st_mode))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: is a folder, not a file with an orbit",
                           s->path);
    return SALTUS_OK;
}

/* A number from 1 that is all of the text; 0 otherwise. */
static long part_number(const char *text) {
    size_t digits = strspn(text, "0123456789");
    return digits > 0 && digits < 10 && text[digits] == '\0' ? atol(text) : 0;
}

/* The row that "12" or "PD1" names; -1 when there is none. */
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
        *start = (saltus_start){.spec = point->spec, .periods = point->periods, .dimension = file.dimension};
        memcpy(start->state, point->state, (size_t)file.dimension * sizeof *start->state);
        snprintf(start->label, sizeof start->label, "%s", point->label);
    }
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

/* The whole file; *text is to be freed. */
static saltus_status read_text(const source *s, char **text, size_t *length, saltus_message *message) {
    FILE *file = fopen(s->path, "rb");
    struct stat facts;
    *text = NULL;
    if (!file)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: cannot be opened (%s)", s->path,
                           strerror(errno));
    bool plain = fstat(fileno(file), &facts) == 0 && S_ISREG(facts.st_mode);
    saltus_status status = SALTUS_OK;
    if (!plain || facts.st_size > largest_file)
        status = refuse(s, message, plain ? "is too large for an orbit" : "is not a plain file");
    else if (!(*text = malloc((size_t)facts.st_size + 1)))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for reading %.300s", s->path);
    else
        *length = fread(*text, 1, (size_t)facts.st_size, file);
    fclose(file);
    return status;
}

/* The text of line `number`, counted from 1; false when there are not so many. */
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

/* The object that describes the orbit: the whole text, one of its lines, or one of a list of attractors. */
static saltus_status find_object(const source *s, const char *text, size_t length, saltus_json *object,
                                 saltus_message *message) {
    const char *rest, *end = text + length;
    long number = part_number(s->part);
    saltus_json list, entry;
    if (s->part[0] && !number)
        return refuse(s, message, "in a JSON file orbits are named by their number, from 1");
    bool good = saltus_json_parse(text, length, object, &rest);
    if (good && rest == end && saltus_json_member_of(*object, "attractors", &list)) {
        if (!number)
            return refuse(s, message, "holds a list of attractors; name one, as in FILE:1");
        if (!saltus_json_element(list, (int)number - 1, &entry) ||
            !saltus_json_member_of(entry, "motion", object))
            return refuse(s, message, "there is no such attractor in the file");
        return SALTUS_OK;
    }
    if (good && rest < end && *rest == '{' && !number)
        return refuse(s, message, "holds several orbits; name one by its line, as in FILE:1");
    if (number > 1 || (number && rest < end)) {
        if (!find_line(&text, &length, number))
            return refuse(s, message, "there is no such line in the file");
        end = text + length;
        good = saltus_json_parse(text, length, object, &rest);
    }
    if (good && rest == end && *object->at == '{')
        return SALTUS_OK;
    bool begun = object->at < end && *object->at == '{';
    return refuse(s, message,
                  !begun               ? "is no orbit: neither a JSON object nor an HDF5 file"
                  : object->end >= end ? "is cut off: the JSON object does not end"
                                       : "is no sound JSON");
}

/* The object's member `parameters` as the text of a scene, to be freed; NULL when there is no memory. */
static char *scene_text(saltus_json parameters, const saltus_model *model) {
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    saltus_json value;
    int count;
    const saltus_parameter *p = saltus_model_parameters(model, &count);
    if (!stream)
        return NULL;
    fprintf(stream, "{model: %s", saltus_model_name(model));
    for (int k = 0; k <= count; k++) {
        const char *key = k < count ? p[k].name : "stops";
        if (saltus_json_member_of(parameters, key, &value))
            fprintf(stream, ", %s: %.*s", key, (int)(value.end - value.at), value.at);
    }
    fputs("}\n", stream);
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

static saltus_status read_parameters(const source *s, saltus_json object, saltus_start *start,
                                     saltus_message *message) {
    saltus_json parameters, value;
    char word[word_size];
    int count;
    if (!saltus_json_member_of(object, "parameters", &parameters) ||
        !saltus_json_member_of(parameters, "model", &value) || !saltus_json_word(value, word, sizeof word) ||
        !saltus_model_find(word))
        return refuse(s, message, "parameters: must be an object that names a known model");
    const saltus_model *model = saltus_model_find(word);
    const saltus_parameter *p = saltus_model_parameters(model, &count);
    for (int k = 0; k <= count; k++)
        if (!saltus_json_member_of(parameters, k < count ? p[k].name : "stops", &value))
            return refuse(s, message, "parameters: %s is missing", k < count ? p[k].name : "stops");
    char *text = scene_text(parameters, model);
    if (!text)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for reading %.300s", s->path);
    saltus_scene scene;
    saltus_message reason = {.text = ""};
    saltus_status status = saltus_scene_parse(text, strlen(text), "parameters", &scene, &reason);
    free(text);
    if (status != SALTUS_OK)
        return saltus_fail(message, status, "%.200s: %.280s", s->path, reason.text);
    start->spec = scene.spec;
    return SALTUS_OK;
}

static saltus_status read_state(const source *s, saltus_json object, saltus_start *start,
                                saltus_message *message) {
    saltus_json state, entry;
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(&start->spec, &system, message);
    if (status != SALTUS_OK)
        return status;
    start->dimension = saltus_system_dimension(system);
    saltus_system_free(system);
    if (!saltus_json_member_of(object, "state", &state) || *state.at != '[')
        return refuse(s, message, "state: must be a list of numbers");
    int count = saltus_json_count(state);
    if (count != start->dimension || count > SALTUS_SCENE_STATE_MAX)
        return refuse(s, message, "state: has %d entries, its parameters make it %d", count,
                      start->dimension);
    for (int i = 0; i < count; i++)
        if (!saltus_json_element(state, i, &entry) || !saltus_json_number(entry, &start->state[i]))
            return refuse(s, message, "state: entry %d must be a finite number", i + 1);
    return SALTUS_OK;
}

static saltus_status read_object(const source *s, saltus_json object, saltus_start *start,
                                 saltus_message *message) {
    saltus_json value;
    char word[word_size] = "";
    double periods = 0;
    if (!saltus_json_member_of(object, "version", &value) || !saltus_json_word(value, word, sizeof word))
        return refuse(s, message,
                      "is not an orbit of classify, orbit or continue --json: it has no key version");
    /* A point of a branch keeps its n/p under `motion`, and its own label under `label`. */
    if ((saltus_json_member_of(object, "motion", &value) || saltus_json_member_of(object, "label", &value)) &&
        saltus_json_word(value, word, sizeof word))
        snprintf(start->label, sizeof start->label, "%.31s", word);
    if (!saltus_json_member_of(object, "periods", &value) || !saltus_json_number(value, &periods) ||
        periods != floor(periods) || periods < 0 || periods > 1e6)
        return refuse(s, message, "periods: must be a whole number from 1 to 1000000");
    if (periods == 0)
        return refuse(s, message, "holds no periodic orbit (the motion is %.31s, periods is 0)",
                      start->label);
    start->periods = (int)periods;
    saltus_status status = read_parameters(s, object, start, message);
    return status == SALTUS_OK ? read_state(s, object, start, message) : status;
}

static saltus_status read_json(const source *s, saltus_start *start, saltus_message *message) {
    char *text;
    size_t length = 0;
    saltus_json object;
    saltus_status status = read_text(s, &text, &length, message);
    if (status == SALTUS_OK && length == 0)
        status = refuse(s, message, "is empty");
    if (status == SALTUS_OK)
        status = find_object(s, text, length, &object, message);
    if (status == SALTUS_OK)
        status = read_object(s, object, start, message);
    free(text);
    return status;
}

/* Whether the file says that it is HDF5; whether it is sound is found out by reading it. */
static bool is_hdf5(const char *path) {
    char head[8] = "";
    FILE *file = fopen(path, "rb");
    bool read = file && fread(head, 1, sizeof head, file) == sizeof head;
    if (file)
        fclose(file);
    return read && memcmp(head, "\x89HDF\r\n\x1a\n", sizeof head) == 0;
}

saltus_status saltus_start_read(const char *text, saltus_start *start, saltus_message *message) {
    source s;
    *start = (saltus_start){0};
    saltus_status status = split_source(text, &s, message);
    if (status != SALTUS_OK)
        return status;
    return is_hdf5(s.path) ? read_point(&s, start, message) : read_json(&s, start, message);
}

static int degrees_of_freedom(const saltus_spec *spec) {
    saltus_spec without = *spec;
    saltus_system *system = NULL;
    without.stop_count = 0;
    if (saltus_system_new(&without, &system, NULL) != SALTUS_OK)
        return -1;
    int dimension = saltus_system_dimension(system);
    saltus_system_free(system);
    return dimension;
}

saltus_status saltus_start_apply(const saltus_start *start, const char *name, saltus_scene *scene,
                                 saltus_message *message) {
    const char *model = saltus_model_name(scene->spec.model);
    if (start->spec.model != scene->spec.model)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is an orbit of the model %s, the scene's is %s", name,
                           saltus_model_name(start->spec.model), model);
    int dimension = degrees_of_freedom(&scene->spec);
    if (dimension >= 0 && dimension != start->dimension)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: its orbit has N = %g and a state of %d entries, the scene N = %g and %d",
                           name, saltus_spec_get(&start->spec, "N"), start->dimension,
                           saltus_spec_get(&scene->spec, "N"), dimension);
    if (start->spec.stop_count != scene->spec.stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: its orbit has %d stop%s, the scene %d", name,
                           start->spec.stop_count, start->spec.stop_count == 1 ? "" : "s",
                           scene->spec.stop_count);
    /* A title describes the scene as it was written. */
    if (!saltus_spec_equal(&scene->spec, &start->spec))
        scene->title[0] = '\0';
    scene->spec = start->spec;
    scene->initial_count = 0;
    return SALTUS_OK;
}
