/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/status.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *saltus_version(void) {
    return SALTUS_VERSION;
}

const char *saltus_status_name(saltus_status status) {
    static const char *const names[] = {[-SALTUS_OK] = "ok",
                                        [-SALTUS_BAD_INPUT] = "bad input",
                                        [-SALTUS_NO_MEMORY] = "out of memory",
                                        [-SALTUS_NO_CONVERGENCE] = "no convergence",
                                        [-SALTUS_STALLED] = "stalled",
                                        [-SALTUS_SINGULAR] = "singular",
                                        [-SALTUS_IO] = "input or output failed",
                                        [-SALTUS_INTERRUPTED] = "interrupted"};
    const bool known = status <= 0 && status > -(int)(sizeof names / sizeof names[0]);
    return known ? names[-status] : "unknown status";
}

/* Whether a byte continues a UTF-8 character. */
static bool goes_on(char byte) {
    return ((unsigned char)byte & 0xc0) == 0x80;
}

__attribute__((format(printf, 3, 0))) static void fill(saltus_message *message, saltus_fault fault,
                                                       const char *format, va_list arguments) {
    va_list again;
    if (!message)
        return;
    va_copy(again, arguments);
    int length = vsnprintf(message->text, sizeof message->text, format, arguments);
    char *whole = length >= (int)sizeof message->text ? malloc((size_t)length + 1) : NULL;
    if (whole) {
        /* Cut the middle out of a message that is too long (usually because of a file name): the beginning
         * names the subject, the end says what is wrong. */
        size_t begin = 200, end = (size_t)length - (sizeof message->text - 1 - begin - strlen("..."));
        vsnprintf(whole, (size_t)length + 1, format, again);
        while (begin > 0 && goes_on(whole[begin]))
            begin--;
        while (goes_on(whole[end]))
            end++;
        snprintf(message->text, sizeof message->text, "%.*s...%s", (int)begin, whole, whole + end);
        free(whole);
    }
    va_end(again);
    message->cause = fault.cause;
    snprintf(message->key, sizeof message->key, "%s", fault.key ? fault.key : "");
    message->stop = fault.stop;
    message->line = fault.line;
}

saltus_status saltus_fail(saltus_message *message, saltus_status status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fill(message, (saltus_fault){.key = NULL}, format, arguments);
    va_end(arguments);
    return status;
}

saltus_status saltus_fail_at(saltus_message *message, saltus_status status, saltus_fault fault,
                             const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fill(message, fault, format, arguments);
    va_end(arguments);
    return status;
}
