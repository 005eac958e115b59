/* One hybrid trajectory of a structure with rigid stops, integrated by established libraries.
 *
 * These are the programs that Saltus is compared with. All of them share one hand-written vector field, one
 * impact law and one rule for ending a chatter, so what they differ in is the integrator and the location of
 * events. Every quantity is nondimensional; model.md defines the symbols.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVALS_H
#define SALTUS_BENCH_RIVALS_H

#include "saltus/system.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { RIVAL_IMPACT = 0, RIVAL_STICK = 1, RIVAL_RELEASE = 2 } rival_event_kind;

typedef struct {
    double time_over_T; /* time in forcing periods; for a stick, the point where the impacts accumulate */
    rival_event_kind kind;
} rival_event;

/* Filled by a rival. The caller owns the arrays and sets the first five beforehand. */
typedef struct {
    rival_event *events;    /* room for `capacity` events, in order of time; may be NULL when capacity is 0 */
    int capacity;           /* events beyond it are counted but not stored */
    double *state;          /* 2 N values: q then q' at the end of the run */
    double *tangents;       /* not NULL: the derivative of `state` with respect to the start, 2 N columns of
                               2 N values, from the variational equations and saltation matrices */
    int repeats;            /* number of repetitions of the run; 0 counts as 1 */
    int count;              /* number of events that happened, possibly more than capacity */
    long steps;             /* accepted steps; 0 where they are not counted */
    long field_evaluations; /* evaluations of the vector field, those for events and chatter included */
    double cpu_seconds;     /* processor time of one run, set-up and release of memory left out */
} rival_result;

/* Integrates a pipe or an oscillator, with its first stop if it has one, from tau = 0 and `state0` (2 N
 * values: q then q', on the free side of the stop or at rest on it) to exactly tau = periods * T. `which` is
 * that of the table's entry. `tolerance` (positive) is the library's local one, relative and absolute, on
 * every component of the state, those of the variational equations included. False if the start lies beyond
 * the stop, memory was lacking, the library gave up or an event was not located: the result then ends
 * there. */
typedef bool (*method_run)(int which, const saltus_spec *spec, const double *state0, int periods,
                           double tolerance, rival_result *result);

typedef struct {
    const char *name; /* library and method; static storage */
    const char *key;  /* one word, for files */
    method_run run;
    int which;     /* one of those that `run` knows */
    bool own;      /* one of Saltus */
    bool tangents; /* whether it carries the variational equations */
    bool stiff;    /* meant for stiff problems */
} method;

/* All rivals built in, `saltus_rival_count` of them; those of SUNDIALS only where SALTUS_WITH_SUNDIALS was
 * defined, those of Boost.Odeint where SALTUS_WITH_ODEINT was. The ones of GSL switch GSL's process-wide
 * error handler off while they run. */
extern const method saltus_rivals[];
extern const int saltus_rival_count;
/* ", NAME VERSION" of each library but GSL. */
void saltus_rivals_versions(char *text, size_t size);

/* Boost.Odeint: events are located on the dense output of dopri5; Fehlberg 7(8) has none, so its steps are
 * repeated. */
enum { odeint_dopri5, odeint_fehlberg78 };
bool rival_odeint(int which, const saltus_spec *spec, const double *state0, int periods, double tolerance,
                  rival_result *result);
const char *rival_odeint_version(void);

#ifdef __cplusplus
}
#endif
#endif
