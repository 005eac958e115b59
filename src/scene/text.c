/* The model of a scene that contains its own equations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/text.h"
#include "base/field.h"
#include "scene/scene.h"
#include "system/system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* A text being read. */
typedef struct reading {
    const saltus_source *source;
    saltus_text text;
    saltus_text_parameter parameters[SALTUS_PARAMETERS_MAX];
    saltus_text_stop stops[SALTUS_STOPS_MAX];
    saltus_list owned; /* void *: other memory that the text points to */
} reading;

static saltus_status no_memory(const reading *r) {
    return saltus_source_fail(r->source, 0, SALTUS_NO_MEMORY, "no memory for the model");
}

static saltus_status read_value(const reading *r, const saltus_node *node, double *value) {
    saltus_message reason = {.text = ""};
    if (node->kind != SALTUS_NODE_SCALAR)
        return saltus_kind_fail(r->source, node, "a number or an expression of numbers");
    saltus_status status = saltus_constant_value(node->text, value, &reason);
    return status == SALTUS_OK ? status
                               : saltus_source_fail(r->source, node->line, status, "%s = %s: %s",
                                                    node->key ? node->key : "entry", node->text, reason.text);
}

/* name: default, or {default, min, max, integer, meaning}. */
static saltus_status read_parameter(reading *r, const saltus_node *node) {
    static const char *const keys[] = {"default", "min", "max", "integer", "meaning"};
    saltus_text_parameter *p = &r->parameters[r->text.parameter_count];
    double *const numbers[] = {&p->fallback, &p->min, &p->max};
    saltus_status status = SALTUS_OK;
    if (r->text.parameter_count == SALTUS_PARAMETERS_MAX)
        return saltus_node_fail(r->source, node, "%s: at most %d parameters are possible", node->key,
                                SALTUS_PARAMETERS_MAX);
    r->text.parameter_count++;
    *p = (saltus_text_parameter){.name = node->key, .min = -1e300, .max = 1e300, .line = node->key_line};
    if (node->kind == SALTUS_NODE_SCALAR)
        return read_value(r, node, &p->fallback);
    if (node->kind != SALTUS_NODE_MAPPING)
        return saltus_kind_fail(r->source, node,
                                "a number, or a mapping such as {default: 1, min: 0, meaning: mass}");
    if (!saltus_node_member(node, "default"))
        return saltus_node_fail(r->source, node, "%s: default is missing", node->key);
    for (const saltus_node *m = node->first; m && status == SALTUS_OK; m = m->next) {
        const int k = saltus_key_index(m->key, keys, 5);
        const bool word = m->kind == SALTUS_NODE_SCALAR;
        if (k < 3)
            status = read_value(r, m, numbers[k]);
        else if (k == 3 && word && (strcmp(m->text, "true") == 0 || strcmp(m->text, "false") == 0))
            p->integer = strcmp(m->text, "true") == 0;
        else if (k == 3)
            status = saltus_kind_fail(r->source, m, "true or false");
        else if (k == 4 && word)
            p->meaning = m->text;
        else
            status = saltus_unknown_key(r->source, m->key_line, m->key, keys, 5);
    }
    if (status == SALTUS_OK && p->integer && p->fallback != floor(p->fallback))
        status = saltus_node_fail(r->source, node, "%s: the default must be a whole number", node->key);
    if (status == SALTUS_OK && !(p->min <= p->fallback && p->fallback <= p->max))
        status = saltus_node_fail(r->source, node, "%s: the default must lie between min and max", node->key);
    return status;
}

/* A number, a list of them, or a list of rows. */
static saltus_status read_constant(reading *r, const saltus_node *node, saltus_text_constant *made) {
    int rows = node->kind == SALTUS_NODE_LIST ? node->count : 0, columns = 0, at = 0;
    saltus_status status = SALTUS_OK;
    if (node->kind == SALTUS_NODE_MAPPING || (node->kind == SALTUS_NODE_LIST && rows == 0))
        return saltus_kind_fail(r->source, node, "a number, a vector [..] or a matrix [[..], ..]");
    if (rows && node->first->kind == SALTUS_NODE_LIST)
        columns = node->first->count;
    double *values = saltus_text_keep(&r->owned, (size_t)(rows ? rows : 1) * (size_t)(columns ? columns : 1),
                                      sizeof *values);
    if (!values)
        return no_memory(r);
    *made = (saltus_text_constant){node->key, rows, columns, values, node->key_line};
    if (!rows)
        return read_value(r, node, values);
    for (const saltus_node *row = node->first; row && status == SALTUS_OK; row = row->next) {
        bool list = row->kind == SALTUS_NODE_LIST;
        if (row->kind == SALTUS_NODE_MAPPING || list != (columns > 0) || (list && row->count != columns))
            return saltus_source_fail(
                r->source, row->line, SALTUS_BAD_INPUT,
                "%s: all rows must be lists of equally many numbers, or all entries numbers", node->key);
        for (const saltus_node *entry = list ? row->first : row; entry && status == SALTUS_OK;
             entry = list ? entry->next : NULL)
            status = read_value(r, entry, &values[at++]);
    }
    return status;
}

/* Left sides mapped to right sides; entries of a mass matrix are named "x1,x2". */
static saltus_status read_equations(reading *r, const saltus_node *node, saltus_equation_list *list) {
    int count = 0, at = 0;
    if (node->kind != SALTUS_NODE_MAPPING)
        return saltus_kind_fail(r->source, node, "a mapping of names to expressions");
    for (const saltus_node *e = node->first; e; e = e->next)
        count += e->kind == SALTUS_NODE_MAPPING ? e->count : 1;
    saltus_equation *items = saltus_text_keep(&r->owned, (size_t)count, sizeof *items);
    if (!items)
        return no_memory(r);
    for (const saltus_node *e = node->first; e; e = e->next) {
        bool row = e->kind == SALTUS_NODE_MAPPING && strcmp(node->key, "mass") == 0;
        if (e->kind != SALTUS_NODE_SCALAR && !row)
            return saltus_kind_fail(
                r->source, e, "an expression; one with a comma, or that begins with *, [ or &, needs quotes");
        for (const saltus_node *entry = row ? e->first : e; entry; entry = row ? entry->next : NULL) {
            char *pair = row ? saltus_text_keep(&r->owned, strlen(e->key) + strlen(entry->key) + 1, 1) : NULL;
            if (entry->kind != SALTUS_NODE_SCALAR)
                return saltus_kind_fail(r->source, entry, "an expression");
            if (row && !pair)
                return no_memory(r);
            if (row)
                sprintf(pair, "%s,%s", e->key, entry->key);
            items[at++] = (saltus_equation){row ? pair : entry->key, entry->text, entry->key_line};
        }
    }
    *list = (saltus_equation_list){items, at};
    return SALTUS_OK;
}

/* Inside { } a comma ends a value, even within parentheses: {x: min(a, b)} has a key "b)", which is
 * refused. */
static saltus_status check_commas(const saltus_source *source, const saltus_node *node) {
    saltus_status status = SALTUS_OK;
    const saltus_node *before = NULL;
    for (const saltus_node *m = node->first; m && status == SALTUS_OK; before = m, m = m->next) {
        int open = 0;
        for (const char *c = m->key ? m->key : ""; *c && open >= 0; c++)
            open += (*c == '(') - (*c == ')');
        if (open < 0 && before && before->kind == SALTUS_NODE_SCALAR)
            status = saltus_node_fail(source, m,
                                      "%.40s: is no name; an expression with a comma needs quotation marks "
                                      "inside { }: {%.40s: \"%.80s, %.40s\"}",
                                      m->key, before->key, before->text, m->key);
        else
            status = check_commas(source, m);
    }
    return status;
}

/* Whether a text is a number as JSON writes it (RFC 8259, section 6): YAML allows others, such as 1.e-6. */
static bool is_json_number(const char *text) {
    static const char digits[] = "0123456789";
    text += *text == '-';
    size_t count = strspn(text, digits);
    bool good = count > 0 && (count == 1 || *text != '0');
    text += count;
    if (*text == '.') {
        count = strspn(++text, digits);
        good = good && count > 0;
        text += count;
    }
    if (*text == 'e' || *text == 'E') {
        text++;
        text += *text == '+' || *text == '-';
        count = strspn(text, digits);
        good = good && count > 0;
        text += count;
    }
    return good && !*text;
}

/* Write a value as JSON after what is `before` it, with its key if it has one: JSON's numbers as they are,
 * everything else in quotation marks. */
static void put_json(FILE *out, const char *before, const saltus_node *node) {
    const char *ends = node->kind == SALTUS_NODE_LIST ? "[]" : "{}", *comma = "";
    fputs(before, out);
    if (node->key) {
        saltus_put_string(out, node->key);
        fputs(": ", out);
    }
    if (node->kind == SALTUS_NODE_SCALAR) {
        if (!node->quoted && is_json_number(node->text))
            fputs(node->text, out);
        else
            saltus_put_string(out, node->text);
        return;
    }
    fputc(ends[0], out);
    for (const saltus_node *child = node->first; child; child = child->next, comma = ", ")
        put_json(out, comma, child);
    fputc(ends[1], out);
}

/* Write the model's mapping as one JSON object, with the scene's stops and initial state in it. */
static void put_model(FILE *out, const reading *r, const saltus_node *model, const saltus_node *initial) {
    const char *comma = "";
    fputc('{', out);
    for (const saltus_node *child = model->first; child; child = child->next)
        if (strcmp(child->key, "contacts") != 0 && strcmp(child->key, "start") != 0) {
            put_json(out, comma, child);
            comma = ", ";
        }
    for (int s = 0; s < r->text.stop_count; s++) {
        const saltus_text_stop *stop = &r->stops[s];
        const saltus_equation *const parts[] = {&stop->coordinate, &stop->d, &stop->r};
        fputs(s ? ", {" : ", \"contacts\": [{", out);
        for (int k = 0; k < 3; k++)
            if (parts[k]->text) {
                fputs(k ? ", " : "", out);
                saltus_put_string(out, parts[k]->name);
                fputs(": ", out);
                saltus_put_string(out, parts[k]->text);
            }
        fputs(s + 1 < r->text.stop_count ? "}" : "}]", out);
    }
    if (initial) {
        saltus_node start = *initial;
        start.key = "start";
        put_json(out, ", ", &start);
    }
    fputc('}', out);
}

/* Read the coordinate of a stop, and clearance and restitution if they are expressions. */
static saltus_status read_stop(reading *r, const saltus_node *node) {
    saltus_text_stop *stop = &r->stops[r->text.stop_count++];
    const saltus_node *coordinate = saltus_node_member(node, "coordinate");
    if (!coordinate || coordinate->kind != SALTUS_NODE_SCALAR)
        return saltus_source_fail(
            r->source, node->line, SALTUS_BAD_INPUT,
            "stop: coordinate is missing; it says what the stop limits, such as coordinate: x");
    *stop = (saltus_text_stop){.coordinate = {"coordinate", coordinate->text, coordinate->key_line}};
    const char *const keys[] = {"d", "r"};
    saltus_equation *const places[] = {&stop->d, &stop->r};
    for (int k = 0; k < 2; k++) {
        const saltus_node *number = saltus_node_member(node, keys[k]);
        double value;
        *places[k] = (saltus_equation){keys[k], NULL, node->line};
        if (number && number->kind == SALTUS_NODE_SCALAR && saltus_read_number(number->text, &value))
            *places[k] = (saltus_equation){keys[k], number->text, number->key_line};
    }
    return SALTUS_OK;
}

static saltus_status read_stops(reading *r, const saltus_node *root, const saltus_node *contacts) {
    const saltus_node *one = contacts ? NULL : saltus_node_member(root, "stop");
    const saltus_node *several = contacts ? contacts : saltus_node_member(root, "stops");
    saltus_status status = SALTUS_OK;
    r->text.stops = r->stops;
    if (one && !several && one->kind == SALTUS_NODE_MAPPING)
        return read_stop(r, one);
    if (several && several->kind == SALTUS_NODE_LIST && several->count <= SALTUS_STOPS_MAX)
        for (const saltus_node *node = several->first; node && status == SALTUS_OK; node = node->next)
            if (node->kind == SALTUS_NODE_MAPPING)
                status = read_stop(r, node);
    return status;
}

/* Read one of two words as 1 or -1. */
static saltus_status read_way(reading *r, const saltus_node *node, const char *one, const char *other,
                              int *way) {
    *way = strcmp(node->text, one) == 0 ? 1 : -1;
    return *way > 0 || strcmp(node->text, other) == 0
               ? SALTUS_OK
               : saltus_node_fail(r->source, node, "section: %s = %.40s: must be %s or %s", node->key,
                                  node->text, one, other);
}

/* maxima, or {zero: expression, direction: up or down}, or {impact: 1, side: upper}. */
static saltus_status read_section(reading *r, const saltus_node *node) {
    static const char *const keys[] = {"zero", "direction", "impact", "side"};
    saltus_poincare *section = &r->text.poincare;
    const bool zero = saltus_node_member(node, "zero"), impact = saltus_node_member(node, "impact");
    saltus_status status = SALTUS_OK;
    double number;
    if (node->kind == SALTUS_NODE_SCALAR && strcmp(node->text, "maxima") == 0)
        return SALTUS_OK;
    if (node->kind != SALTUS_NODE_MAPPING)
        return saltus_kind_fail(
            r->source, node,
            "maxima, or a mapping such as {zero: x - 1, direction: up} or {impact: 1, side: upper}");
    for (const saltus_node *m = node->first; m && status == SALTUS_OK; m = m->next) {
        if (m->kind != SALTUS_NODE_SCALAR)
            status = saltus_kind_fail(r->source, m, "a single value");
        else if (strcmp(m->key, "zero") == 0) {
            section->kind = SALTUS_POINCARE_ZERO;
            r->text.zero = (saltus_equation){"section: zero", m->text, m->key_line};
        } else if (strcmp(m->key, "direction") == 0)
            status = read_way(r, m, "up", "down", &section->direction);
        else if (strcmp(m->key, "side") == 0)
            status = read_way(r, m, "upper", "lower", &section->side);
        else if (strcmp(m->key, "impact") != 0)
            status = saltus_unknown_key(r->source, m->key_line, m->key, keys, 4);
        else if (saltus_read_number(m->text, &number) || number != floor(number) || number < 1 ||
                 number > SALTUS_STOPS_MAX)
            status = saltus_node_fail(r->source, m, "section: impact = %.40s: must be the number of a stop",
                                      m->text);
        else {
            section->kind = SALTUS_POINCARE_IMPACT;
            section->stop = (int)number - 1;
        }
    }
    if (status == SALTUS_OK && zero == impact)
        status = saltus_node_fail(r->source, node, "section: must have either zero or impact");
    else if (status == SALTUS_OK && ((zero && section->side) || (impact && section->direction)))
        status = saltus_node_fail(r->source, node, "section: direction goes with zero, side with impact");
    if (section->direction == 0)
        section->direction = 1;
    return status;
}

static saltus_status read_key(reading *r, const saltus_node *node) {
    enum { parameters, constants, families, forcing = 7, observe, section = 10, planned, count = 15 };
    static const char *const keys[count] = {"parameters", "constants", "families", "let",     "motion",
                                            "mass",       "states",    "forcing",  "observe", "scale",
                                            "section",    "cyclic",    "drift",    "when",    "modes"};
    saltus_text *t = &r->text;
    saltus_equation_list *const lists[count] = {
        [families] = &t->families, &t->let,  &t->motion, &t->mass, &t->states,
        [observe] = &t->observe,   &t->scale};
    const int key = saltus_key_index(node->key, keys, count);
    saltus_status status = SALTUS_OK;
    if (strcmp(node->key, "contacts") == 0 || strcmp(node->key, "start") == 0)
        return SALTUS_OK; /* only in files of results, for the scene's stops and initial state */
    if (key == count)
        return saltus_unknown_key(r->source, node->key_line, node->key, keys, count);
    if (key >= planned)
        return saltus_node_fail(r->source, node, "%s: is not possible yet", node->key);
    if (lists[key])
        return read_equations(r, node, lists[key]);
    if (key == section)
        return read_section(r, node);
    if (key == forcing) {
        if (node->kind != SALTUS_NODE_SCALAR)
            return saltus_kind_fail(r->source, node,
                                    "the name of the parameter that is the angular frequency");
        t->forcing = (saltus_equation){"forcing", node->text, node->key_line};
        return SALTUS_OK;
    }
    if (node->kind != SALTUS_NODE_MAPPING)
        return saltus_kind_fail(r->source, node,
                                key == parameters ? "a mapping of names to values"
                                                  : "a mapping of names to numbers, vectors and matrices");
    saltus_text_constant *constant = NULL;
    if (key == constants)
        t->constants = constant = saltus_text_keep(&r->owned, (size_t)node->count, sizeof *constant);
    if (key == constants && !constant)
        return no_memory(r);
    for (const saltus_node *m = node->first; m && status == SALTUS_OK; m = m->next)
        status =
            key == parameters ? read_parameter(r, m) : read_constant(r, m, &constant[t->constant_count++]);
    return status;
}

saltus_status saltus_scene_read_text(const saltus_source *source, const saltus_node *root,
                                     const saltus_source *place, const saltus_node *node,
                                     const saltus_model **model) {
    const saltus_node *initial = saltus_node_member(root, "initial"),
                      *contacts = saltus_node_member(node, "contacts");
    char *json = NULL;
    size_t length = 0;
    reading r = {.source = place,
                 .text = {.origin = place->origin ? place->origin : "scene",
                          .scene = source->origin ? source->origin : "scene"}};
    saltus_status status = check_commas(place, node);
    r.text.parameters = r.parameters;
    if (status == SALTUS_OK)
        status = check_commas(source, root);
    for (const saltus_node *key = node->first; key && status == SALTUS_OK; key = key->next)
        status = read_key(&r, key);
    if (status == SALTUS_OK && r.text.motion.count == 0)
        status = saltus_node_fail(
            place, node,
            "model: motion is missing; it holds the equations of displacements, such as x: -x - 0.1*x'%s",
            r.text.states.count ? ", of which there must be one beside the states" : "");
    r.source = source;
    if (!initial)
        initial = saltus_node_member(node, "start");
    if (status == SALTUS_OK && initial)
        status = read_equations(&r, initial, &r.text.initial);
    if (status == SALTUS_OK)
        status = read_stops(&r, root, contacts);
    FILE *out = status == SALTUS_OK ? open_memstream(&json, &length) : NULL;
    if (out)
        put_model(out, &r, node, initial);
    if (status == SALTUS_OK && !saltus_close_text(out, &json))
        status = no_memory(&r);
    r.text.source = json;
    if (status == SALTUS_OK)
        status = saltus_text_model_new(&r.text, model, source->message);
    free(json);
    saltus_text_release(&r.owned);
    return status;
}

/* The equations are under `model:`, as in a scene, or are the whole file. */
saltus_status saltus_scene_read_model_file(const saltus_source *source, const saltus_node *root,
                                           const saltus_model **model) {
    const saltus_node *name = saltus_node_member(root, "model");
    saltus_source place = {.language = "YAML", .message = source->message};
    saltus_document document = {.root = NULL};
    /* Prepend the folder of the scene to a relative path. */
    const char *slash = name->text[0] == '/' || !source->origin ? NULL : strrchr(source->origin, '/');
    const size_t folder = slash ? (size_t)(slash - source->origin) + 1 : 0;
    char *text = NULL, *path = malloc(folder + strlen(name->text) + 1);
    saltus_message reason = {.text = ""};
    if (!path)
        return saltus_source_fail(source, 0, SALTUS_NO_MEMORY, "no memory for the model");
    sprintf(path, "%.*s%s", (int)folder, folder ? source->origin : "", name->text);
    struct stat info;
    saltus_status status = SALTUS_OK;
    /* A pipe or device could block the reading. */
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode))
        status = saltus_fail(&reason, SALTUS_IO, "%s: is no regular file", path);
    else
        status = saltus_read_file(path, &text, &place.length, &reason);
    /* Report the failure at the scene's line that names the file. */
    if (status != SALTUS_OK)
        status = saltus_source_fail(source, name->key_line, status == SALTUS_IO ? SALTUS_BAD_INPUT : status,
                                    "model: %s", reason.text);
    place.text = text;
    place.origin = path;
    if (status == SALTUS_OK)
        status = saltus_document_read(&place, &document);
    const saltus_node *equations = saltus_node_member(document.root, "model");
    if (!equations)
        equations = document.root;
    if (status == SALTUS_OK && (!equations || equations->kind != SALTUS_NODE_MAPPING))
        status = saltus_source_fail(&place, 0, SALTUS_BAD_INPUT,
                                    "holds no equations; they stand below model: as in a scene, or alone");
    if (status == SALTUS_OK)
        status = saltus_scene_read_text(source, root, &place, equations, model);
    saltus_document_close(&document);
    free(text);
    free(path);
    return status;
}

saltus_status saltus_model_with_section(const saltus_model *model, const char *section,
                                        const saltus_model **made, saltus_message *message) {
    const bool bare = section[0] != '{' && strcmp(section, "maxima") != 0;
    char *wrapped = malloc(strlen(section) + 24), *text = NULL;
    size_t length;
    saltus_document own = {.root = NULL}, chosen = {.root = NULL};
    *made = NULL;
    if (!wrapped)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the model");
    sprintf(wrapped, bare ? "section: {%s}" : "section: %s", section);
    const saltus_source source = {.text = model->text, .length = strlen(model->text), .language = "JSON"},
                        other = {.text = wrapped,
                                 .length = strlen(wrapped),
                                 .language = "YAML",
                                 .message = message};
    saltus_status status = saltus_document_read(&other, &chosen);
    if (status == SALTUS_OK && !chosen.root)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "section: is missing");
    if (status == SALTUS_OK)
        status = check_commas(&other, chosen.root);
    if (status == SALTUS_OK)
        status = saltus_document_read(&source, &own);
    FILE *out = status == SALTUS_OK ? open_memstream(&text, &length) : NULL;
    if (out) {
        put_json(out, "{", saltus_node_member(chosen.root, "section"));
        for (const saltus_node *child = own.root->first; child; child = child->next)
            if (strcmp(child->key, "section") != 0)
                put_json(out, ", ", child);
        fputc('}', out);
    }
    if (status == SALTUS_OK)
        status = saltus_close_text(out, &text)
                     ? saltus_model_of_text(text, made, message)
                     : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the model");
    saltus_document_close(&own);
    saltus_document_close(&chosen);
    free(text);
    free(wrapped);
    return status;
}

saltus_status saltus_model_of_text(const char *text, const saltus_model **model, saltus_message *message) {
    char *whole = malloc(strlen(text) + 16);
    saltus_document document;
    *model = NULL;
    if (!whole)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the model");
    sprintf(whole, "{\"model\": %s}", text);
    const saltus_source source = {
        .text = whole, .length = strlen(whole), .origin = "model", .language = "JSON", .message = message};
    saltus_status status = saltus_document_read(&source, &document);
    if (status == SALTUS_OK) {
        const saltus_node *node = saltus_node_member(document.root, "model");
        status = node && node->kind == SALTUS_NODE_MAPPING
                     ? saltus_scene_read_text(&source, document.root, &source, node, model)
                     : saltus_fail(message, SALTUS_BAD_INPUT, "the model is no mapping");
        saltus_document_close(&document);
    }
    free(whole);
    return status;
}
