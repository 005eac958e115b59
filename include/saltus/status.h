/* Return codes and messages used throughout the library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_STATUS_H
#define SALTUS_STATUS_H

/* Declarations between these two have C linkage and are exported from the shared library. */
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
/* Version of the loaded library, which may differ from the header's. */
const char *saltus_version(void);

/* What a call returns: zero, or a negative number that says why the call failed. Why a computation *ended*
 * (time reached, section, impact, ...) is reported separately, by its result. */
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

/* More detail on a failure, where callers need it to decide what to do next. */
typedef enum saltus_cause {
    SALTUS_CAUSE_OTHER = 0, /* the status says everything */
    SALTUS_CAUSE_CUT_OFF,   /* a text ends inside an unclosed value */
    SALTUS_CAUSE_SEVERAL,   /* a text goes on after its first complete value */
    SALTUS_CAUSE_BEYOND     /* a state lies beyond a stop */
} saltus_cause;

/* A sentence about a failure and what it refers to, written by the call that failed. Owned by the caller. */
typedef struct saltus_message {
    char text[512];
    saltus_cause cause;
    char key[32]; /* the key at fault; "" if the fault is not in a single key's value */
    int stop;     /* the stop that the key belongs to, from 1; 0: none */
    int line;     /* line of the text that was read, from 1; 0: none */
} saltus_message;

/* Progress callback of a long call, a member of its options. `show` (NULL: no reports) is called from time to
 * time with the work done and the most that may have to be done, in the unit that the options name. It may
 * raise saltus_flow_options.stop to end the call. */
typedef struct saltus_progress {
    void (*show)(void *context, double done, double all);
    void *context;
} saltus_progress;

/* The name of a status, for messages ("no convergence"). Never NULL. */
const char *saltus_status_name(saltus_status status);

/* Write a formatted sentence into `message` (may be NULL), shortened by "..." in its middle if it is too
 * long. Returns `status`. */
saltus_status saltus_fail(saltus_message *message, saltus_status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* The fields of saltus_message besides its text (`key` may be NULL). */
typedef struct saltus_fault {
    saltus_cause cause;
    const char *key;
    int stop, line;
} saltus_fault;

/* Like saltus_fail, but sets these fields, which saltus_fail leaves zero. */
saltus_status saltus_fail_at(saltus_message *message, saltus_status status, saltus_fault fault,
                             const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;

SALTUS_API_END
#endif
