/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/kept.h"

#include "base/memory.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { key_length = 32, name_max = 96, day = 24 * 3600 };

typedef struct entry {
    char name[name_max];
    time_t used; /* modification time: when made or last used, to a day */
} entry;

static int latest_first(const void *a, const void *b) {
    const entry *one = a, *other = b;
    return one->used != other->used ? (one->used < other->used) - (one->used > other->used)
                                    : strcmp(one->name, other->name);
}

void saltus_kept_trim(const char *folder) {
    DIR *all = opendir(folder);
    const time_t now = time(NULL);
    saltus_list functions = {.items = NULL};
    struct stat s;
    for (const struct dirent *d; all && (d = readdir(all));) {
        const char *name = d->d_name;
        const size_t length = strlen(name);
        const bool keyed = strspn(name, "0123456789abcdef") == key_length && name[key_length] == '-';
        const bool function = keyed && strcmp(name + length - 3, ".so") == 0;
        /* Temporary files: a compiler's unfinished output, its source, its turn. */
        const bool passing = (keyed && strstr(name, ".so.")) || strncmp(name, "source.", 7) == 0 ||
                             strncmp(name, "busy.", 5) == 0;
        if (length >= name_max || !(function || passing) ||
            fstatat(dirfd(all), name, &s, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(s.st_mode))
            continue;
        entry *own = function ? saltus_list_add(&functions, sizeof *own) : NULL;
        if (own) {
            strcpy(own->name, name);
            own->used = s.st_mtime;
        } else if (!function && now - s.st_mtime > day)
            unlinkat(dirfd(all), name, 0);
    }
    entry *kept = functions.items;
    if (functions.count > 0)
        qsort(kept, (size_t)functions.count, sizeof *kept, latest_first);
    for (int k = 0; k < functions.count; k++)
        if (k >= SALTUS_KEPT_MOST || now - kept[k].used > (time_t)SALTUS_KEPT_DAYS * day)
            unlinkat(dirfd(all), kept[k].name, 0);
    free(functions.items);
    if (all)
        closedir(all);
}

void saltus_kept_use(const char *path) {
    struct stat s;
    if (stat(path, &s) == 0 && time(NULL) - s.st_mtime > day)
        utimensat(AT_FDCWD, path, NULL, AT_SYMLINK_NOFOLLOW);
}
