/* Private: running gnuplot.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_GNUPLOT_H
#define SALTUS_FIGURE_GNUPLOT_H

#include "saltus/status.h"

#include <stdio.h>

/* Run gnuplot on a script (read from its beginning) that draws to standard output; what it draws, complete,
 * in *picture, the caller's to close. The user's own start-up files are not read. Errors: SALTUS_IO with
 * gnuplot's complaint; *picture is NULL then. */
saltus_status saltus_gnuplot_run(FILE *script, FILE **picture, saltus_message *message);

#endif
