/* Builds a tree of values from libyaml's events.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/document.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

enum {
    deepest = 64, /* lists and mappings around a value, the outermost not counted */
    most_nodes = 1 << 22,
    most_keys = 1024, /* per mapping: each new key is compared with all earlier ones */
    chunk_size = 1 << 15
};

/* Memory is handed out from chunks that are freed together. */
typedef struct saltus_chunk {
    struct saltus_chunk *next;
    size_t used, size;
    char bytes[];
} saltus_chunk;

/* A list or a mapping that is still open. */
typedef struct container {
    saltus_node *node, *last; /* last: its last child */
    char bracket;             /* '[' or '{'; 0 in block style */
} container;

typedef struct builder {
    const saltus_source *source;
    saltus_document *document;
    yaml_parser_t parser;
    const char *text; /* after the byte order mark, if there is one */
    size_t length;
    container open[deepest + 1];
    int depth; /* number of open containers */
    const char *key;
    int key_line;
    int nodes;
    bool complete; /* the document has ended */
} builder;

__attribute__((format(printf, 4, 0))) static saltus_status
fail_at(const saltus_source *source, int line, saltus_status status, const char *format, va_list arguments) {
    enum { origin_shown = 160 };
    saltus_message sentence;
    vsnprintf(sentence.text, sizeof sentence.text, format, arguments);
    /* Escapes in the text may have put line feeds into the words quoted here. */
    for (char *c = sentence.text; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = ' ';
    if (!source->origin)
        return saltus_fail(source->message, status, "%s", sentence.text);
    size_t length = strlen(source->origin);
    const char *origin = length > origin_shown ? source->origin + length - origin_shown : source->origin;
    const char *dots = origin == source->origin ? "" : "...";
    saltus_fault fault = {.line = line > 0 ? line + source->lines_before : 0};
    if (fault.line)
        return saltus_fail_at(source->message, status, fault, "%s%s:%d: %s", dots, origin, fault.line,
                              sentence.text);
    return saltus_fail(source->message, status, "%s%s: %s", dots, origin, sentence.text);
}

saltus_status saltus_source_fail(const saltus_source *source, int line, saltus_status status,
                                 const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fail_at(source, line, status, format, arguments);
    va_end(arguments);
    return status;
}

saltus_status saltus_node_fail(const saltus_source *source, const saltus_node *node, const char *format,
                               ...) {
    va_list arguments;
    va_start(arguments, format);
    fail_at(source, node->key_line, SALTUS_BAD_INPUT, format, arguments);
    va_end(arguments);
    if (source->message && node->key)
        snprintf(source->message->key, sizeof source->message->key, "%s", node->key);
    return SALTUS_BAD_INPUT;
}

/* Refuse a second document, with a cause that callers check. */
static saltus_status fail_several(const builder *b, int line, const char *complaint) {
    saltus_source_fail(b->source, line, SALTUS_BAD_INPUT, "holds more than one %s document%s",
                       b->source->language, complaint);
    if (b->source->message)
        b->source->message->cause = SALTUS_CAUSE_SEVERAL;
    return SALTUS_BAD_INPUT;
}

static saltus_status no_memory(const builder *b) {
    return saltus_source_fail(b->source, 0, SALTUS_NO_MEMORY, "no memory for reading it");
}

size_t saltus_letter_bytes(const char *text, size_t left) {
    const unsigned char *p = (const unsigned char *)text;
    size_t length = p[0] < 0x80                   ? 1
                    : p[0] >= 0xc2 && p[0] < 0xe0 ? 2
                    : p[0] >= 0xe0 && p[0] < 0xf0 ? 3
                    : p[0] >= 0xf0 && p[0] < 0xf5 ? 4
                                                  : 0;
    if (length == 0 || length > left)
        return 0;
    for (size_t k = 1; k < length; k++)
        if ((p[k] & 0xc0) != 0x80)
            return 0;
    bool overlong = (p[0] == 0xe0 && p[1] < 0xa0) || (p[0] == 0xf0 && p[1] < 0x90);
    bool outside = (p[0] == 0xed && p[1] > 0x9f) || (p[0] == 0xf4 && p[1] > 0x8f);
    return overlong || outside ? 0 : length;
}

static saltus_status check_text(const saltus_source *source) {
    const unsigned char *p = (const unsigned char *)source->text;
    int line = 1;
    for (size_t k = 0; k < source->length;) {
        size_t step = saltus_letter_bytes(source->text + k, source->length - k);
        bool control = p[k] < 0x20 && p[k] != '\t' && p[k] != '\n' && p[k] != '\r';
        if (control || p[k] == 0x7f)
            return saltus_source_fail(source, line, SALTUS_BAD_INPUT,
                                      "not a text file (it holds the byte 0x%02x)", p[k]);
        if (step == 0)
            return saltus_source_fail(source, line, SALTUS_BAD_INPUT,
                                      "not a text file in UTF-8 (byte 0x%02x)", p[k]);
        line += p[k] == '\n';
        k += step;
    }
    return SALTUS_OK;
}

/* `size` bytes, zeroed; NULL when there is no memory. */
static void *take(saltus_document *document, size_t size) {
    size = (size + 7) / 8 * 8;
    saltus_chunk *chunk = document->memory;
    if (!chunk || chunk->size - chunk->used < size) {
        size_t room = size > chunk_size ? size : chunk_size;
        chunk = calloc(1, sizeof *chunk + room);
        if (!chunk)
            return NULL;
        chunk->size = room;
        chunk->next = document->memory;
        document->memory = chunk;
    }
    chunk->used += size;
    return chunk->bytes + chunk->used - size;
}

void saltus_document_close(saltus_document *document) {
    for (saltus_chunk *chunk = document->memory, *next; chunk; chunk = next) {
        next = chunk->next;
        free(chunk);
    }
    *document = (saltus_document){NULL, NULL};
}

const saltus_node *saltus_node_member(const saltus_node *node, const char *key) {
    const saltus_node *child = node && node->kind == SALTUS_NODE_MAPPING ? node->first : NULL;
    while (child && strcmp(child->key, key) != 0)
        child = child->next;
    return child;
}

const saltus_node *saltus_node_child(const saltus_node *node, int k) {
    const saltus_node *child = k < 0 ? NULL : node->first;
    while (child && k-- > 0)
        child = child->next;
    return child;
}

/* Byte offset of a mark (libyaml counts characters). */
static size_t byte_of(const builder *b, yaml_mark_t mark) {
    size_t place = 0;
    for (size_t k = 0; place < b->length; place++)
        if (((unsigned char)b->text[place] & 0xc0) != 0x80 && k++ == mark.index)
            break;
    return place;
}

static int line_of(yaml_mark_t mark) {
    return (int)mark.line + 1;
}

/* Whether the text is a single bracketed list or mapping that is cut off: from `place` to the end nothing
 * closes it or separates values. */
static bool breaks_off(const builder *b, size_t place) {
    size_t begin = 0;
    while (begin < b->length && strchr(" \t\r\n", b->text[begin]))
        begin++;
    while (place < b->length && !strchr(",]}\n", b->text[place]))
        place++;
    return begin < b->length && strchr("[{", b->text[begin]) && place == b->length;
}

/* Whether only the word of a key precedes `place` in its line. */
static bool opens_line(const builder *b, size_t place) {
    while (place > 0 && b->text[place - 1] != '\n')
        if (strchr(":\"'[]{}", b->text[--place]))
            return false;
    return true;
}

/* Explain a syntax error: what is wrong at the place where libyaml's parser failed and what would be right,
 * judged by the characters there. Rare cases keep libyaml's own words. May move *line to where the fault
 * begins. */
static void explain_syntax(const builder *b, size_t place, int *line, char *what, size_t room) {
    const yaml_parser_t *p = &b->parser;
    const container *inner = b->depth ? &b->open[b->depth - 1] : NULL;
    size_t begin = byte_of(b, p->context_mark);
    bool scanning = p->error == YAML_SCANNER_ERROR;
    char found = place < b->length ? b->text[place] : '\0';
    char context = p->context && begin < b->length ? b->text[begin] : '\0';
    bool quotes = scanning && (context == '"' || context == '\'');
    char sign = (char)(found && strchr("@`%", found)         ? found
                       : context && strchr("*&!|>", context) ? context
                                                             : 0);
    char bracket[64] = "";
    if (inner && inner->bracket)
        snprintf(bracket, sizeof bracket, "the %c of line %d is not closed", inner->bracket,
                 inner->node->line + b->source->lines_before);
    if (quotes && !found) {
        *line = line_of(p->context_mark);
        snprintf(what, room, "the quotation mark (%c) of line %d is not closed", context,
                 *line + b->source->lines_before);
    } else if (quotes)
        snprintf(what, room, "what follows the backslash is no escape; write \\\\ for a backslash itself");
    else if (sign)
        snprintf(what, room, "no value begins with %c; put it in quotation marks", sign);
    else if (bracket[0] && !found)
        snprintf(what, room, "%s", bracket);
    else if (bracket[0] && strchr("]}", found))
        snprintf(what, room, "found %c, but %s", found, bracket);
    else if (bracket[0])
        snprintf(what, room, "a comma is missing, or %s", bracket);
    else if (found == '\t')
        snprintf(what, room, "found a tab; indent with spaces");
    else if (scanning && p->context && p->context_mark.line < p->problem_mark.line) {
        *line = line_of(p->context_mark);
        snprintf(what, room, "line %d has no value; write key: value, with a blank behind the colon",
                 *line + b->source->lines_before);
    } else if (found && strchr("]}", found))
        snprintf(what, room, "found %c, but no bracket is open", found);
    else if (found && (!scanning || strchr(":-?", found)))
        snprintf(what, room, "%s",
                 opens_line(b, place)
                     ? "this does not go with what stands above; begin all keys of a mapping, and all dashes "
                       "of a list, in one column"
                     : "no value goes on like this; put one that holds ': ', begins with '- ' or goes on "
                       "behind a bracket or a quotation mark wholly in quotation marks");
    else
        snprintf(what, room, "%s", p->problem ? p->problem : "cannot be parsed");
}

static saltus_status fail_syntax(const builder *b) {
    const yaml_parser_t *p = &b->parser;
    char what[300];
    if (p->error == YAML_MEMORY_ERROR)
        return no_memory(b);
    if (p->error ==
        YAML_READER_ERROR) { /* a character that YAML has, but as nothing that could stand in a text */
        int line = 1;
        for (size_t k = 0; k < p->problem_offset && k < b->length; k++)
            line += b->text[k] == '\n';
        return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT, "not valid %s: the character U+%04X",
                                  b->source->language, (unsigned)p->problem_value);
    }
    int line = line_of(p->problem_mark);
    if (b->complete && p->error == YAML_PARSER_ERROR)
        return fail_several(b, line, ": what stands here does not belong to the first");
    size_t place = byte_of(b, p->problem_mark);
    explain_syntax(b, place, &line, what, sizeof what);
    saltus_status status = saltus_source_fail(b->source, line, SALTUS_BAD_INPUT,
                                              "not valid %s here or below: %s", b->source->language, what);
    if (b->source->message && breaks_off(b, place))
        b->source->message->cause = SALTUS_CAUSE_CUT_OFF;
    return status;
}

/* The text of a scalar event, stored in the document; NULL with an error in *status. */
static const char *keep_text(const builder *b, const yaml_event_t *event, saltus_status *status) {
    size_t length = event->data.scalar.length;
    if (memchr(event->data.scalar.value, '\0', length)) {
        *status = saltus_source_fail(b->source, line_of(event->start_mark), SALTUS_BAD_INPUT,
                                     "a text with the character NUL in it is not possible");
        return NULL;
    }
    char *text = take(b->document, length + 1);
    if (text)
        memcpy(text, event->data.scalar.value, length);
    else
        *status = no_memory(b);
    return text;
}

static saltus_status add_key(builder *b, const saltus_node *mapping, const yaml_event_t *event) {
    saltus_status status = SALTUS_OK;
    int line = line_of(event->start_mark);
    if (event->type != YAML_SCALAR_EVENT)
        return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT, "keys must be single words");
    if (mapping->count == most_keys)
        return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT,
                                  "too many keys in one mapping; at most %d are possible", most_keys);
    b->key = keep_text(b, event, &status);
    b->key_line = line;
    const saltus_node *first = b->key ? saltus_node_member(mapping, b->key) : NULL;
    if (first)
        return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT,
                                  "%.60s: given twice, first in line %d; keep one of them", b->key,
                                  first->key_line + b->source->lines_before);
    return status;
}

/* Add a value at the current position: the root, the value of the last key, or the next entry of a list. */
static saltus_status add_value(builder *b, const yaml_event_t *event) {
    const bool scalar = event->type == YAML_SCALAR_EVENT, list = event->type == YAML_SEQUENCE_START_EVENT;
    const int line = line_of(event->start_mark);
    container *parent = b->depth ? &b->open[b->depth - 1] : NULL;
    saltus_status status = SALTUS_OK;
    if (!scalar && b->depth > deepest)
        return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT,
                                  "lists and mappings are nested too deep; at most %d levels are possible",
                                  deepest);
    if (b->nodes++ == most_nodes)
        return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT,
                                  "too many values; at most %d are possible", most_nodes);
    saltus_node *node = take(b->document, sizeof *node);
    if (!node)
        return no_memory(b);
    node->line = line;
    node->column = (int)event->start_mark.column + 1;
    node->key = b->key;
    node->key_line = b->key ? b->key_line : line;
    b->key = NULL;
    *(!parent ? &b->document->root : parent->last ? &parent->last->next : &parent->node->first) = node;
    if (parent) {
        parent->last = node;
        parent->node->count++;
    }
    node->kind = scalar ? SALTUS_NODE_SCALAR : list ? SALTUS_NODE_LIST : SALTUS_NODE_MAPPING;
    if (scalar) {
        node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
        node->text = keep_text(b, event, &status);
        return status;
    }
    bool flow = list ? event->data.sequence_start.style == YAML_FLOW_SEQUENCE_STYLE
                     : event->data.mapping_start.style == YAML_FLOW_MAPPING_STYLE;
    b->open[b->depth++] = (container){.node = node, .bracket = (char)(!flow ? 0 : list ? '[' : '{')};
    return SALTUS_OK;
}

static saltus_status take_event(builder *b, const yaml_event_t *event) {
    const saltus_node *within = b->depth ? b->open[b->depth - 1].node : NULL;
    int line = line_of(event->start_mark);
    switch (event->type) {
    case YAML_DOCUMENT_START_EVENT:
        return b->complete ? fail_several(b, line, "; keep one in a file") : SALTUS_OK;
    case YAML_DOCUMENT_END_EVENT:
        b->complete = true;
        return SALTUS_OK;
    case YAML_ALIAS_EVENT:
        return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT,
                                  "aliases (*name) are not possible; write the value itself, and put an "
                                  "expression that begins with * in quotation marks");
    case YAML_SCALAR_EVENT:
    case YAML_SEQUENCE_START_EVENT:
    case YAML_MAPPING_START_EVENT:
        if (event->type == YAML_SCALAR_EVENT           ? event->data.scalar.tag
            : event->type == YAML_SEQUENCE_START_EVENT ? event->data.sequence_start.tag
                                                       : event->data.mapping_start.tag)
            return saltus_source_fail(b->source, line, SALTUS_BAD_INPUT,
                                      "tags (!name) are not possible; write the value alone");
        return within && within->kind == SALTUS_NODE_MAPPING && !b->key ? add_key(b, within, event)
                                                                        : add_value(b, event);
    case YAML_SEQUENCE_END_EVENT:
    case YAML_MAPPING_END_EVENT:
        b->depth--;
        return SALTUS_OK;
    default:
        return SALTUS_OK;
    }
}

saltus_status saltus_document_read(const saltus_source *source, saltus_document *document) {
    static const char byte_order_mark[] = "\xef\xbb\xbf";
    *document = (saltus_document){NULL, NULL};
    builder b = {.source = source, .document = document, .text = source->text, .length = source->length};
    saltus_status status = check_text(source);
    if (status != SALTUS_OK)
        return status;
    if (b.length >= 3 && memcmp(b.text, byte_order_mark, 3) == 0) {
        b.text += 3;
        b.length -= 3;
    }
    if (!yaml_parser_initialize(&b.parser))
        return no_memory(&b);
    yaml_parser_set_encoding(&b.parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&b.parser, (const unsigned char *)b.text, b.length);
    for (bool ended = false; !ended && status == SALTUS_OK;) {
        yaml_event_t event;
        if (!yaml_parser_parse(&b.parser, &event)) {
            status = fail_syntax(&b);
            break;
        }
        status = take_event(&b, &event);
        ended = event.type == YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&b.parser);
    if (status != SALTUS_OK)
        saltus_document_close(document);
    return status;
}
