/* Private: the folder of compiled functions is kept small.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_KEPT_H
#define SALTUS_SYSTEM_KEPT_H

enum {
    SALTUS_KEPT_DAYS = 60,  /* since a function was used last */
    SALTUS_KEPT_MOST = 1000 /* functions */
};

/* Remove from a folder the functions that have not been used for so long, and of more than so many those used
 * longest ago; also what compilers that were ended have left. Any process may do so at any time: a function
 * that another one runs stays with that one, and who does not find a file makes it anew. Other files stay. */
void saltus_kept_trim(const char *folder);
/* Note that a file there is used now. */
void saltus_kept_use(const char *path);

#endif
