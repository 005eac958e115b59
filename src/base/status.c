/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *saltus_version(void) {
    return SALTUS_VERSION;
}

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

/* Whether a byte of UTF-8 goes on with the character before it. */
static int goes_on(char byte) {
    return ((unsigned char)byte & 0xc0) == 0x80;
}

/* A sentence that is too long, because of a file's name mostly, loses its middle: it begins with what it is
 * about and ends with what is wrong. */
static void shorten(saltus_message *message, const char *whole, size_t length) {
    size_t begin = 200, end = length - (sizeof message->text - 1 - begin - strlen("..."));
    while (begin > 0 && goes_on(whole[begin]))
        begin--;
    while (goes_on(whole[end]))
        end++;
    snprintf(message->text, sizeof message->text, "%.*s...%s", (int)begin, whole, whole + end);
}

__attribute__((format(printf, 2, 0))) static void write_sentence(saltus_message *message, const char *format,
                                                                 va_list arguments) {
    va_list again;
    va_copy(again, arguments);
    int length = vsnprintf(message->text, sizeof message->text, format, arguments);
    char *whole = length >= (int)sizeof message->text ? malloc((size_t)length + 1) : NULL;
    if (whole) {
        vsnprintf(whole, (size_t)length + 1, format, again);
        shorten(message, whole, (size_t)length);
        free(whole);
    }
    va_end(again);
}

saltus_status saltus_fail(saltus_message *message, saltus_status status, const char *format, ...) {
    va_list arguments;
    if (!message)
        return status;
    va_start(arguments, format);
    write_sentence(message, format, arguments);
    va_end(arguments);
    message->cause = SALTUS_CAUSE_OTHER;
    message->key[0] = '\0';
    message->stop = message->line = 0;
    return status;
}

saltus_status saltus_fail_at(saltus_message *message, saltus_status status, saltus_fault fault,
                             const char *format, ...) {
    va_list arguments;
    if (!message)
        return status;
    va_start(arguments, format);
    write_sentence(message, format, arguments);
    va_end(arguments);
    message->cause = fault.cause;
    snprintf(message->key, sizeof message->key, "%s", fault.key ? fault.key : "");
    message->stop = fault.stop;
    message->line = fault.line;
    return status;
}
