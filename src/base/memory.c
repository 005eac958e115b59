/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

enum { alignment = 64 };

double *saltus_arena_doubles(saltus_arena *arena, size_t count) {
    unsigned char *place = arena->base ? arena->base + arena->used : NULL;
    size_t bytes = count * sizeof(double);
    arena->used += (bytes + alignment - 1) / alignment * alignment;
    return (double *)(void *)place;
}

bool saltus_arena_open(saltus_arena *arena) {
    size_t bytes = arena->used + alignment;
    arena->base = aligned_alloc(alignment, bytes);
    if (arena->base) {
        memset(arena->base, 0, bytes);
        arena->used = 0;
    }
    return arena->base != NULL;
}

bool saltus_arena_again(saltus_arena *arena) {
    return !arena->base && saltus_arena_open(arena);
}

void saltus_arena_close(saltus_arena *arena) {
    free(arena->base);
    *arena = (saltus_arena){0};
}

void *saltus_list_add(saltus_list *list, size_t size) {
    if (list->count == list->room) {
        int room = 2 * list->room + 32;
        void *items = realloc(list->items, (size_t)room * size);
        if (!items)
            return NULL;
        list->items = items;
        list->room = room;
    }
    return (char *)list->items + (size_t)list->count++ * size;
}

void *saltus_list_grow(saltus_list *list, size_t size, bool *failed) {
    void *entry = saltus_list_add(list, size);
    *failed |= !entry;
    return entry;
}

void saltus_swap(void *a, void *b, size_t size) {
    unsigned char *one = a, *other = b;
    for (size_t k = 0; k < size; k++) {
        const unsigned char kept = one[k];
        one[k] = other[k];
        other[k] = kept;
    }
}
