/* Private: a YAML or JSON text as a tree of values with their positions in the text.
 *
 * JSON is read as a subset of YAML. Not supported on purpose: aliases, tags, several documents in one text,
 * keys that are not single words, repeated keys. Depth, number of values and keys per mapping are bounded, so
 * that the cost of a text is proportional to its length.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SCENE_DOCUMENT_H
#define SALTUS_SCENE_DOCUMENT_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stddef.h>

/* A text to be read, and where error messages go. */
typedef struct saltus_source {
    const char *text; /* need not end with a NUL */
    size_t length;
    const char *origin;      /* the text's name in messages; NULL: messages begin with the sentence */
    const char *language;    /* "YAML" or "JSON", for messages */
    int lines_before;        /* lines of the origin before this text, if it is only a part of it */
    saltus_message *message; /* may be NULL */
} saltus_source;

typedef enum saltus_node_kind { SALTUS_NODE_SCALAR, SALTUS_NODE_LIST, SALTUS_NODE_MAPPING } saltus_node_kind;

/* A value. */
typedef struct saltus_node saltus_node;
struct saltus_node {
    saltus_node_kind kind;
    bool quoted;              /* a scalar in quotation marks or a block scalar: never a number or null */
    int line, column;         /* where it begins, counted from 1 */
    int key_line;             /* line of its key, or of the value itself if it has no key */
    const char *key;          /* of a member of a mapping; otherwise NULL */
    const char *text;         /* of a scalar; otherwise NULL */
    int count;                /* number of children */
    const saltus_node *first; /* first child; the others follow by `next`, in the order of the text */
    const saltus_node *next;
};

typedef struct saltus_document {
    const saltus_node *root;     /* NULL: the text contains at most comments */
    struct saltus_chunk *memory; /* holds all nodes and their words */
} saltus_document;

/* Read a text. On success close the document with saltus_document_close. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY; the document is then empty. Causes: SALTUS_CAUSE_CUT_OFF, SALTUS_CAUSE_SEVERAL
 * (message->line: where the second value begins). */
saltus_status saltus_document_read(const saltus_source *source, saltus_document *document);
/* An empty document is accepted. */
void saltus_document_close(saltus_document *document);

/* The member of a mapping; NULL if there is none or if `node` is NULL or no mapping. */
const saltus_node *saltus_node_member(const saltus_node *node, const char *key);
/* The k-th child, from 0; NULL if there is none. */
const saltus_node *saltus_node_child(const saltus_node *node, int k);

/* Write "origin:line: " and a sentence into the source's message and return `status`; line 0: no line. */
saltus_status saltus_source_fail(const saltus_source *source, int line, saltus_status status,
                                 const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;
/* The same for bad input at a node, with the line of the node or its key, and with the key in the message. */
saltus_status saltus_node_fail(const saltus_source *source, const saltus_node *node, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* The bytes of the UTF-8 letter at the beginning of a text that has so many left, at least one; 0 if it is
 * invalid, also overlong forms and surrogates. */
size_t saltus_letter_bytes(const char *text, size_t left);

#endif
