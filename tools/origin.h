/* The origin of a command's results, for their files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_ORIGIN_H
#define SALTUS_TOOLS_ORIGIN_H

#include "cli.h"

/* A saltus_origin with its storage. */
typedef struct cli_origin {
    saltus_origin told;
    char *command, *scene;
    char date[32];
} cli_origin;

/* The command line, the scene's text and the time, which is that of SOURCE_DATE_EPOCH (seconds since 1970) if
 * set. A scene from standard input, or whose file has gone, has no text. To be released. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status cli_origin_new(const cli_request *request, cli_origin *origin, saltus_message *message);
void cli_origin_clear(cli_origin *origin);

#endif
