/* Private: a list that grows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_LIST_H
#define SALTUS_BASE_LIST_H

#include <stddef.h>

/* Entries of one size one after the other; a zeroed one is empty. `items` is to be freed. */
typedef struct saltus_list {
    void *items;
    int count, room;
} saltus_list;

/* Room for one entry more of `size` bytes, at the end; NULL when there is no memory. */
void *saltus_list_add(saltus_list *list, size_t size);

#endif
