/* One hybrid trajectory of a structure with rigid stops, integrated by established libraries.
 *
 * These are the programs that Saltus is compared with. All of them share one hand-written vector field, one
 * impact law and one rule for ending a chatter, so what they differ in is the integrator and the location of
 * events. Every quantity is nondimensional; model.md defines the symbols.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVALS_H
#define SALTUS_BENCH_RIVALS_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { RIVAL_UPPER = 0, RIVAL_LOWER, RIVAL_BOTH, RIVAL_FREE } rival_sides;

/* One or two masses in a chain, driven by F cos(omega t); a single mass uses only the first entries. */
typedef struct {
    double m[2], c[2], k[2]; /* mass, damper and spring towards the support or the mass before */
    double force[2], load[2];
    double weight[2]; /* the coordinate that the stop limits */
} rival_oscillator;

/* A pipe pinned at both ends, or an oscillator, and its stop. */
typedef struct {
    int modes;    /* number N of Galerkin modes, at least 1; oscillator: of masses, 1 or 2 */
    double omega; /* forcing frequency, positive; the period is T = 2 pi / omega also without forcing */
    double d;     /* clearance */
    double r;     /* restitution coefficient, in [0, 1] */
    rival_sides sides;
    const rival_oscillator *oscillator; /* NULL: a pipe, and the parameters that follow are its own */
    double alpha;                       /* Kelvin-Voigt damping */
    double beta;                        /* fluid mass over total mass, in [0, 1) */
    double kappa;                       /* axial-stretching stiffness */
    double u0;                          /* mean flow velocity */
    double sigma;                       /* relative amplitude of the pulsation; 0 makes the flow steady */
    double xi;                          /* position of the stop, in (0, 1) */
} rival_scene;

typedef enum { RIVAL_IMPACT = 0, RIVAL_STICK = 1, RIVAL_RELEASE = 2 } rival_event_kind;

typedef struct {
    double time_over_T;     /* time in forcing periods; for a stick, the point where the impacts accumulate */
    double normal_velocity; /* speed towards the stop just before an impact, positive; otherwise 0 */
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

/* Integrates from tau = 0 and `state0` (2 N values: q then q', on the free side of the stop or at rest on it)
 * to exactly tau = periods * T. `rtol` (at least 0) and `atol` (positive) are the library's local tolerances
 * on every component of the state, those of the variational equations included.
 * Thread-safe except where its table entry says otherwise. False if the start lies beyond the stop, memory
 * was lacking, the library gave up or an event was not located; in the last two cases the result ends there.
 */
typedef bool (*rival_run)(const rival_scene *scene, const double *state0, int periods, double rtol,
                          double atol, rival_result *result);

typedef struct {
    const char *name; /* library and method; static storage */
    const char *key;  /* one word, for files */
    rival_run run;
    bool tangents; /* whether it carries the variational equations */
    bool stiff;    /* meant for stiff problems */
} rival;

/* All rivals built in, `saltus_rival_count` of them; those of SUNDIALS only where SALTUS_WITH_SUNDIALS was
 * defined, those of Boost.Odeint where SALTUS_WITH_ODEINT was. The ones of GSL switch GSL's process-wide
 * error handler off while they run. */
extern const rival saltus_rivals[];
extern const int saltus_rival_count;
/* ", NAME VERSION" of each library but GSL. */
void saltus_rivals_versions(char *text, size_t size);

/* Boost.Odeint: events are located on the dense output of dopri5; Fehlberg 7(8) has none, so its steps are
 * repeated. */
bool rival_odeint_dopri5(const rival_scene *scene, const double *state0, int periods, double rtol,
                         double atol, rival_result *result);
bool rival_odeint_fehlberg78(const rival_scene *scene, const double *state0, int periods, double rtol,
                             double atol, rival_result *result);
const char *rival_odeint_version(void);

#ifdef __cplusplus
}
#endif
#endif
