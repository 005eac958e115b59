/* Files of finished work in the folder of --keep, so that an interrupted trial goes on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_KEEP_H
#define SALTUS_TRIAL_KEEP_H

#include "survey.h"

/* What is kept under a name, behind the line that says by which version; NULL where nothing is kept there. */
FILE *trial_kept(const trial_request *request, const char *name);
/* A stream for what is to be kept under a name, or for passing on only where nothing is kept. `trial_keep`
 * ends the writing and gives it back to be read from the begin; NULL when it could not be written. */
FILE *trial_keep_begin(void);
FILE *trial_keep(const trial_request *request, const char *name, FILE *stream);

#endif
