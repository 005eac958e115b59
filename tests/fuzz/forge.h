/* Forged HDF5 files: sound to the HDF5 library, while everything in them that our readers rely on - what is
 * there, types, shapes, values - is as the fuzzer has it.
 *
 * A file that the library itself has written is taken apart into groups, attributes and datasets; a stream of
 * bytes says which of them to change and how; all are written again by the HDF5 library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FORGE_H
#define SALTUS_TESTS_FORGE_H

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { FORGE_ITEMS_MAX = 192, FORGE_RANK_MAX = 6 };

typedef enum forge_kind { FORGE_GROUP, FORGE_ATTRIBUTE, FORGE_DATASET } forge_kind;

/* A part of a file. A value of an attribute has rank 0 where it is a scalar. */
typedef struct forge_item {
    forge_kind kind;
    char owner[64], name[64]; /* path of the group; "" and the path for a group itself */
    hid_t type;
    int rank;
    hsize_t size[FORGE_RANK_MAX];
    unsigned char *bytes; /* as stored */
    size_t length;
} forge_item;

/* A file taken apart. */
typedef struct forge_file {
    forge_item items[FORGE_ITEMS_MAX];
    int count;
} forge_file;

/* Bytes that are used up one after the other; zeros follow the last one. */
typedef struct forge_stream {
    const uint8_t *at, *end;
} forge_stream;

unsigned forge_byte(forge_stream *stream);

/* Take a file apart. */
bool forge_read(const char *path, forge_file *file);
/* Write it again, changed as the stream says, and put the library's seal behind it. */
bool forge_write(const forge_file *file, forge_stream *stream, const char *path);

#endif
