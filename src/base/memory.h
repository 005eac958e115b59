/* Arenas, one aligned block per object carved into arrays: an object is allocated once, checked once and
 * freed once. And lists that grow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_MEMORY_H
#define SALTUS_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* An arena is used in two passes over the same code: measuring (base == NULL: only `used` grows) and handing
 * out, with saltus_arena_open in between; or in a loop, do { ... } while (saltus_arena_again(&arena)). */
typedef struct saltus_arena {
    unsigned char *base;
    size_t used;
} saltus_arena;

/* Reserve `count` doubles, aligned to 64 bytes and zeroed. NULL while measuring. */
double *saltus_arena_doubles(saltus_arena *arena, size_t count);

/* Allocate the measured number of bytes, zeroed and aligned to 64; false if there is no memory. */
bool saltus_arena_open(saltus_arena *arena);
/* Asked after each pass, whether one is left: after the first one it allocates. Without memory there is no
 * second one, and `base` stays NULL. */
bool saltus_arena_again(saltus_arena *arena);

/* Free what the arena holds. A zeroed arena is accepted. */
void saltus_arena_close(saltus_arena *arena);

/* Entries of one size one after the other; a zeroed one is empty. `items` is to be freed. */
typedef struct saltus_list {
    void *items;
    int count, room;
} saltus_list;

/* Room for one entry more of `size` bytes, at the end; NULL when there is no memory. */
void *saltus_list_add(saltus_list *list, size_t size);
/* The same; then `failed` is raised. */
void *saltus_list_grow(saltus_list *list, size_t size, bool *failed);

#endif
