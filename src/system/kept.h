/* Private: keeps the folder of compiled functions small.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_KEPT_H
#define SALTUS_SYSTEM_KEPT_H

enum {
    SALTUS_KEPT_DAYS = 60,  /* a function is removed this long after its last use */
    SALTUS_KEPT_MOST = 1000 /* functions kept */
};

/* Remove functions that have not been used for SALTUS_KEPT_DAYS, the least recently used ones beyond
 * SALTUS_KEPT_MOST, and day-old leftovers of interrupted compilers. Other files stay. Safe at any time in any
 * process: a loaded function stays loaded, and whoever misses a file compiles it again. */
void saltus_kept_trim(const char *folder);
/* Record that a file of the folder is in use now. */
void saltus_kept_use(const char *path);

#endif
