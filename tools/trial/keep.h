/* Finished work is kept as files in the folder of --keep, so that an interrupted trial can continue.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRIAL_KEEP_H
#define SALTUS_TRIAL_KEEP_H

#include "survey.h"

/* Open what is kept under a name, after the line with the version; NULL if nothing is kept. */
FILE *trial_kept(const trial_request *request, const char *name);
/* trial_keep_begin gives a stream to write to. trial_keep stores it under a name, if a folder is set, and
 * returns it for reading from the beginning; NULL if writing failed. */
FILE *trial_keep_begin(void);
FILE *trial_keep(const trial_request *request, const char *name, FILE *stream);

#endif
