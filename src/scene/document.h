/* Private: a YAML or JSON text as a tree of values that know their places.
 *
 * JSON is read as the part of YAML that it is. Left out of YAML on purpose: aliases, tags, several documents
 * in one text, keys that are not single words, a key given twice. Depth, number of values and keys of one
 * mapping are bounded, so that no text costs more than its length suggests.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SCENE_DOCUMENT_H
#define SALTUS_SCENE_DOCUMENT_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stddef.h>

/* A text being read, and where complaints about it go. */
typedef struct saltus_source {
    const char *text; /* need not end with NUL */
    size_t length;
    const char *origin;      /* names it in messages; NULL: messages begin with the sentence */
    const char *language;    /* "YAML" or "JSON", for messages */
    int lines_before;        /* of the origin, where the text is only a part of it */
    saltus_message *message; /* may be NULL */
} saltus_source;

typedef enum saltus_node_kind { SALTUS_NODE_SCALAR, SALTUS_NODE_LIST, SALTUS_NODE_MAPPING } saltus_node_kind;

/* A value. */
typedef struct saltus_node saltus_node;
struct saltus_node {
    saltus_node_kind kind;
    bool quoted;              /* a scalar in quotation marks or a block of text: no number, no null */
    int line, column;         /* where it begins, from 1 */
    int key_line;             /* of its key; of the value itself where it has none */
    const char *key;          /* of a member of a mapping, otherwise NULL */
    const char *text;         /* of a scalar, otherwise NULL */
    int count;                /* of children */
    const saltus_node *first; /* child; further ones by `next`, in the text's order */
    const saltus_node *next;
};

typedef struct saltus_document {
    const saltus_node *root;     /* NULL: the text is empty but for comments */
    struct saltus_chunk *memory; /* of all nodes and their words */
} saltus_document;

/* Read a text. On success the document is to be closed. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY; the
 * document is then empty. Causes: SALTUS_CAUSE_CUT_OFF, SALTUS_CAUSE_SEVERAL (message->line: where the second
 * value begins). */
saltus_status saltus_document_read(const saltus_source *source, saltus_document *document);
/* An empty document is accepted. */
void saltus_document_close(saltus_document *document);

/* The member of a mapping; NULL when there is none, or `node` is no mapping or NULL. */
const saltus_node *saltus_node_member(const saltus_node *node, const char *key);
/* The k-th child, from 0; NULL when there is none. */
const saltus_node *saltus_node_child(const saltus_node *node, int k);

/* Write "origin:line: " and a sentence into the source's message; no line when it is 0. Returns `status`. */
saltus_status saltus_source_fail(const saltus_source *source, int line, saltus_status status,
                                 const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;
/* Likewise for input that is wrong at a node: with its line, or its key's, and the key in the message. */
saltus_status saltus_node_fail(const saltus_source *source, const saltus_node *node, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

#endif
