/* Arenas: one aligned block per object, carved into arrays, so that an object is allocated, checked and freed
 * once. Growing lists, and exchanges.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_MEMORY_H
#define SALTUS_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* The same code runs twice over an arena: first it measures (base == NULL: only `used` grows), then it hands
 * out memory, with saltus_arena_open in between. As a loop: do { ... } while (saltus_arena_again(&arena)). */
typedef struct saltus_arena {
    unsigned char *base;
    size_t used;
} saltus_arena;

/* Reserve `count` doubles, aligned to 64 bytes and zeroed. NULL while measuring. */
double *saltus_arena_doubles(saltus_arena *arena, size_t count);

/* Allocate the measured number of bytes, zeroed and aligned to 64; false if there is no memory. */
bool saltus_arena_open(saltus_arena *arena);
/* Loop condition after each pass: allocates after the first pass and returns true if that succeeded, false
 * after the second pass. Without memory there is no second pass and `base` stays NULL. */
bool saltus_arena_again(saltus_arena *arena);

/* Free what the arena holds. A zeroed arena is accepted. */
void saltus_arena_close(saltus_arena *arena);

/* Exchange two things of one type; and any two things of `size` bytes. */
#define SALTUS_SWAP(a, b) saltus_swap(true ? &(a) : &(b), &(b), sizeof(a))
void saltus_swap(void *a, void *b, size_t size);

/* Contiguous entries of one size. A zeroed list is empty. The caller frees `items`. */
typedef struct saltus_list {
    void *items;
    int count, room;
} saltus_list;

/* Append an uninitialised entry of `size` bytes and return it; NULL if there is no memory. */
void *saltus_list_add(saltus_list *list, size_t size);
/* The same, and sets *failed if there is no memory. */
void *saltus_list_grow(saltus_list *list, size_t size, bool *failed);

#endif
