/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/status.h"

#include <stdarg.h>
#include <stdio.h>

const char *saltus_status_name(saltus_status status) {
    switch (status) {
    case SALTUS_OK:
        return "ok";
    case SALTUS_BAD_INPUT:
        return "bad input";
    case SALTUS_NO_MEMORY:
        return "out of memory";
    case SALTUS_NO_CONVERGENCE:
        return "no convergence";
    case SALTUS_STALLED:
        return "stalled";
    case SALTUS_SINGULAR:
        return "singular";
    case SALTUS_IO:
        return "input or output failed";
    case SALTUS_INTERRUPTED:
        return "interrupted";
    }
    return "unknown status";
}

saltus_status saltus_fail(saltus_message *message, saltus_status status, const char *format, ...) {
    if (message) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(message->text, sizeof message->text, format, arguments);
        va_end(arguments);
    }
    return status;
}
