/* Return codes and messages shared by every room of the library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_STATUS_H
#define SALTUS_STATUS_H

/* What stands between these two is the library's interface: C's names, seen outside of the shared library. */
#ifdef __GNUC__
#define SALTUS_API_VISIBLE(action) _Pragma(action)
#else
#define SALTUS_API_VISIBLE(action)
#endif
#ifdef __cplusplus
#define SALTUS_API_BEGIN SALTUS_API_VISIBLE("GCC visibility push(default)") extern "C" {
#define SALTUS_API_END                                                                                       \
    }                                                                                                        \
    SALTUS_API_VISIBLE("GCC visibility pop")
#else
#define SALTUS_API_BEGIN SALTUS_API_VISIBLE("GCC visibility push(default)")
#define SALTUS_API_END SALTUS_API_VISIBLE("GCC visibility pop")
#endif

SALTUS_API_BEGIN

#define SALTUS_VERSION "0.1.0"
/* The version of the library that is loaded, which may be another than that of the header. */
const char *saltus_version(void);

/* What a call returns: zero, or a negative number that says why the call could not do its work. Why a
 * computation *ended* (time reached, section, impact, ...) is a different question with an answer of its own.
 */
typedef enum saltus_status {
    SALTUS_OK = 0,
    SALTUS_BAD_INPUT = -1,      /* an argument, a scene or an option is not acceptable */
    SALTUS_NO_MEMORY = -2,      /* an allocation failed; nothing was changed */
    SALTUS_NO_CONVERGENCE = -3, /* an iteration did not reach its tolerance */
    SALTUS_STALLED = -4,        /* the flow could not proceed: step or impact sequence without progress */
    SALTUS_SINGULAR = -5,       /* a linear system or a derivative is singular (grazing, say) */
    SALTUS_IO = -6,             /* a file or a child process failed */
    SALTUS_INTERRUPTED = -7     /* the caller asked to stop (saltus_flow_options.stop) */
} saltus_status;

/* What exactly went wrong, where callers go on differently. */
typedef enum saltus_cause {
    SALTUS_CAUSE_OTHER = 0, /* the status says all that a caller needs */
    SALTUS_CAUSE_CUT_OFF,   /* a text ends within a value that is not closed */
    SALTUS_CAUSE_SEVERAL    /* a text goes on behind its only value */
} saltus_cause;

/* One clear sentence about a failure, and what it is about, written by the call that failed. Owned by the
 * caller. */
typedef struct saltus_message {
    char text[512];
    saltus_cause cause;
    char key[32]; /* the key at fault; "" where the fault is not in one key's value */
    int stop;     /* the stop that the key belongs to, from 1; 0: none */
    int line;     /* of the text that was read, from 1; 0: none */
} saltus_message;

/* How a long call tells how far it is, a member of its options; `show` NULL: nobody asks. It is called now
 * and then, with how much is done of all that may have to be done at most, in the unit that the options name.
 * To stop is another matter: saltus_flow_options.stop, which `show` may raise. */
typedef struct saltus_progress {
    void (*show)(void *context, double done, double all);
    void *context;
} saltus_progress;

/* The name of a status, for messages ("no convergence"). Never NULL. */
const char *saltus_status_name(saltus_status status);

/* Write a formatted sentence into `message` (which may be NULL) and return `status`. One that is too long
 * loses its middle, with "..." in its place. */
saltus_status saltus_fail(saltus_message *message, saltus_status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* What a message is about, beside its sentence: the fields of saltus_message (`key` may be NULL). */
typedef struct saltus_fault {
    saltus_cause cause;
    const char *key;
    int stop, line;
} saltus_fault;

/* As saltus_fail, with these fields; saltus_fail leaves them zero. */
saltus_status saltus_fail_at(saltus_message *message, saltus_status status, saltus_fault fault,
                             const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;

SALTUS_API_END
#endif
