/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/list.h"

#include <stdlib.h>

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
