/* Systems: the constant description of a structure, its forcing and its stops.
 *
 * A system is built from a specification (a model, its parameters, its stops), checked, and never changed
 * afterwards; any number of flows may share it. Everything is nondimensional unless a model says otherwise.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_H
#define SALTUS_SYSTEM_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stddef.h>

SALTUS_API_BEGIN

enum {
    SALTUS_PARAMETERS_MAX = 24, /* parameters of one model */
    SALTUS_STOPS_MAX = 12,      /* stops of one scene; a two-sided stop counts once */
    SALTUS_FACES_MAX = 24,      /* one-sided contacts: two for a two-sided stop */
    SALTUS_STATE_MAX = 288,     /* length of a state */
    SALTUS_OBSERVE_MAX = 40     /* bytes of the observed displacement's name */
};

/* An entry of an option or parameter table; it serves defaults, checks, `--set`, `--help` and file
 * headers. */
typedef struct saltus_parameter {
    const char *name;    /* the symbol used in scenes, on the command line and in results */
    bool integer;        /* whole numbers only */
    double fallback;     /* default */
    double min, max;     /* admissible range */
    bool open_min;       /* min itself is not admissible */
    bool open_max;       /* max itself is not admissible */
    const char *meaning; /* one phrase, with the unit if there is one */
    const char *given;   /* it has an effect only if this parameter (NULL: always) ... */
    double above;        /* ... is greater than this */
} saltus_parameter;

typedef struct saltus_model saltus_model;

/* Number of built-in models and the k-th one (NULL beyond the last). Static storage. */
int saltus_model_count(void);
const saltus_model *saltus_model_at(int k);
/* The built-in model with that name, or NULL. */
const saltus_model *saltus_model_find(const char *name);
const char *saltus_model_name(const saltus_model *model);
const char *saltus_model_summary(const saltus_model *model);
/* The complete equations of a model from text as one JSON object, which result files store; else NULL. */
const char *saltus_model_text(const saltus_model *model);
/* Whether two models are equal: the same built-in model, or equal texts. */
bool saltus_model_same(const saltus_model *a, const saltus_model *b);
/* The parameter table of a model and its length. */
const saltus_parameter *saltus_model_parameters(const saltus_model *model, int *count);
/* Index of a parameter in the model's table, or -1. */
int saltus_model_parameter_index(const saltus_model *model, const char *name);

/* What a model's displacements belong to. */
typedef enum saltus_structure {
    SALTUS_STRUCTURE_LINE,  /* a line with a displacement at every place xi: a pipe, a beam */
    SALTUS_STRUCTURE_BODIES /* separate bodies */
} saltus_structure;

/* How texts and figures refer to a model's quantities; symbols in UTF-8. */
typedef struct saltus_notation {
    saltus_structure structure;
    const char
        *displacement; /* symbol of the displacement, of the line at a place or of a body by its number */
    const char *coordinate; /* symbol of the state's displacements, which a number follows */
    const char *part;       /* what the k-th displacement belongs to: "mode", "mass" */
    const char *time;       /* symbol */
    int response;           /* forcing periods per response cycle: 2 for parametric forcing */
} saltus_notation;

/* Static storage. */
const saltus_notation *saltus_model_notation(const saltus_model *model);

typedef enum saltus_sides { SALTUS_UPPER = 1, SALTUS_LOWER = 2, SALTUS_BOTH = 3 } saltus_sides;

/* A rigid stop. Its coordinate g is a linear function of the displacements: eta(xi) of a pipe, weight[0] x1 +
 * weight[1] x2 of an oscillator, or given by a text; a text's constant term is moved into the faces'
 * clearances. An upper stop forbids g > d, a lower one g < -d. */
typedef struct saltus_stop {
    double xi;        /* position along the pipe, 0 < xi < 1 (pipe only) */
    double weight[2]; /* weights of the coordinate (oscillator only) */
    double d;         /* clearance; negative: a pre-load, for one-sided stops only */
    double r;         /* restitution, 0 <= r <= 1; if it depends on the closing speed, its limit at 0 */
    saltus_sides sides;
} saltus_stop;

/* Ranges of a stop's keys (xi, d, r), in the form of a parameter table. */
const saltus_parameter *saltus_stop_parameters(int *count);

/* The specification of a system: plain values, owned by the caller. */
typedef struct saltus_spec {
    const saltus_model *model;
    double parameters[SALTUS_PARAMETERS_MAX]; /* in the order of the model's table */
    saltus_stop stops[SALTUS_STOPS_MAX];
    int stop_count;
    /* The observed displacement, for turning points, extremes, spectra and diagrams: a displacement by its
     * name (saltus_system_state_name), a stop's coordinate (stop1, stop2, ...), a quantity from the text's
     * `observe`, or a place on a line (0.3). "": the text's first quantity if it is a sum of displacements,
     * else the first stop's coordinate, else the middle of a line or the first displacement. */
    char observe[SALTUS_OBSERVE_MAX];
    double clock; /* model without forcing: 2 pi / clock is the unit in which times are counted; 0 stands for
                     2 pi, i.e. units of time */
} saltus_spec;

/* The key that places a stop of the model (xi, weight or coordinate) and the *count numbers of a stop for it;
 * one is written as a number, several as a list. */
const char *saltus_model_stop_key(const saltus_model *model);
const double *saltus_stop_place(const saltus_model *model, const saltus_stop *stop, int *count);

/* The scene's expression for a stop's coordinate, or for its d or r; NULL if there is none. */
typedef enum saltus_stop_part {
    SALTUS_STOP_COORDINATE,
    SALTUS_STOP_CLEARANCE,
    SALTUS_STOP_RESTITUTION
} saltus_stop_part;
const char *saltus_stop_text(const saltus_spec *spec, int stop, saltus_stop_part part);
/* The expression of a restitution that depends on `speed`, the closing speed; NULL: r is a number. */
const char *saltus_restitution_law(const saltus_spec *spec, int stop);

/* The model's defaults, without stops. */
saltus_spec saltus_spec_defaults(const saltus_model *model);
/* The value of a `--set` key: a parameter of the model, or d, r, xi (of all stops), d1, r2, ... (of one). NaN
 * if there is no such key or stop, or if the stops differ under a common key. */
double saltus_spec_get(const saltus_spec *spec, const char *name);
/* Whether the k-th parameter has an effect with the present values of the others. */
bool saltus_spec_matters(const saltus_spec *spec, int k);
/* Whether two specifications have equal models, parameters and stops. */
bool saltus_spec_equal(const saltus_spec *a, const saltus_spec *b);
/* A stop with xi = 1/2, weight = (1, 0), d = 1, r = 0.9, upper side. */
saltus_stop saltus_stop_defaults(void);

/* A direction in parameter space: the rates of all numbers of a specification. */
typedef struct saltus_direction {
    double parameter[SALTUS_PARAMETERS_MAX]; /* in the order of the model's table */
    double d[SALTUS_STOPS_MAX], r[SALTUS_STOPS_MAX], xi[SALTUS_STOPS_MAX];
    double clock;
} saltus_direction;

/* The direction of a `--set` key: a parameter of the model other than a whole number, d, r, xi (of all stops)
 * or d1, r2, ... (of one). `value` (may be NULL) receives its present value. Errors: SALTUS_BAD_INPUT (no
 * such key, a whole number, stops that differ under a common key, derivative not defined at present). */
saltus_status saltus_spec_direction(const saltus_spec *spec, const char *key, saltus_direction *direction,
                                    double *value, saltus_message *message);
/* The angular frequency by which times are counted: the forcing's or, without forcing, the clock. */
double saltus_spec_omega(const saltus_spec *spec);
void saltus_spec_set_omega(saltus_spec *spec, double omega);
/* The direction of this angular frequency. */
saltus_direction saltus_spec_omega_direction(const saltus_spec *spec);
/* spec + amount * direction. */
saltus_spec saltus_spec_shifted(const saltus_spec *spec, const saltus_direction *direction, double amount);

typedef struct saltus_system saltus_system;

/* A one-sided contact as the flow sees it: gap(q) = side normal . q - d <= 0. */
typedef struct saltus_face {
    int stop; /* index into the spec's stops */
    int side; /* +1 upper, -1 lower */
    double d; /* clearance */
    double r; /* restitution; if it depends on the closing speed, its limit at 0 */
} saltus_face;

/* Check a specification and build a system from it, to be freed with saltus_system_free. On failure *system
 * is NULL and `message` (may be NULL) names the key, its value and what would be right.
 * Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_system_new(const saltus_spec *spec, saltus_system **system, saltus_message *message);
/* NULL is accepted. */
void saltus_system_free(saltus_system *system);

/* The specification that the system was built from; it belongs to the system. */
const saltus_spec *saltus_system_spec(const saltus_system *system);
/* Degrees of freedom (modes), extra first-order states, and the length of a state vector: displacements q,
 * then velocities q', then extra states. */
int saltus_system_dof(const saltus_system *system);
int saltus_system_extra(const saltus_system *system);
int saltus_system_dimension(const saltus_system *system);
/* The name of a state entry in --set, files and figures. */
typedef struct saltus_state_name {
    char text[40];
} saltus_state_name;
/* Names from a text are its own, x, x' and p, and x1, x1' for families; in built-in models they are q1, v1,
 * z1 for displacements, velocities and extra states, counted from 1. */
saltus_state_name saltus_system_state_name(const saltus_system *system, int entry);
/* The entry with that name, or -1. x_dot means x'; q1, v1, z1 also work for models from text unless the text
 * has these names. -1 also for parameters' names, which take precedence. */
int saltus_system_state_index(const saltus_system *system, const char *name);
/* The same for a specification, which need not make a system: only its whole-number parameters matter. The
 * length of the state and, unless `dof` is NULL, the number of displacements. If there is no valid length it
 * is -1, names are empty and indices -1. */
int saltus_spec_dimension(const saltus_spec *spec, int *dof);
saltus_state_name saltus_spec_state_name(const saltus_spec *spec, int entry);
int saltus_spec_state_index(const saltus_spec *spec, const char *name);
/* In a model from text, the right side of an acceleration (entries 0 to dof - 1) or of an extra state's rate
 * (from dof on) as the program understands it: masses divided out, numbers combined. The caller frees it.
 * NULL for a built-in model, or if there is no memory. */
char *saltus_system_right_side(const saltus_system *system, int entry);
/* Forcing period T = 2 pi / omega, the unit of sections and event phases. */
double saltus_system_period(const saltus_system *system);
/* Whether the vector field depends on time. */
bool saltus_system_forced(const saltus_system *system);
/* Whether q -> -q maps the system, stops included, onto itself; if *shift, together with a shift by half a
 * forcing period: q(t) -> -q(t + T/2), the symmetry of a directly forced system. */
bool saltus_system_mirror_symmetric(const saltus_system *system, bool *shift);
int saltus_system_face_count(const saltus_system *system);
saltus_face saltus_system_face(const saltus_system *system, int face);
/* A face's restitution at a closing speed; most do not depend on it. */
double saltus_system_restitution(const saltus_system *system, int face, double speed);
/* Row vector n of a stop, g = n . q (length dof). */
const double *saltus_system_stop_normal(const saltus_system *system, int stop);
/* Inverse of the mass matrix, dof x dof, row-major. */
const double *saltus_system_inverse_mass(const saltus_system *system);
/* Gap of a face for a state; negative off the stop, positive beyond it. */
double saltus_system_gap(const saltus_system *system, int face, const double *state);
/* Typical magnitude of each state entry (length dimension), for random initial states and scaled
 * distances. */
const double *saltus_system_scale(const saltus_system *system);
/* Largest difference of two states' entries, relative to their scales. */
double saltus_system_distance(const saltus_system *system, const double *a, const double *b);
/* Row vector of the observed displacement (saltus_spec, observe), length dof. */
const double *saltus_system_observer(const saltus_system *system);
/* Whether a stop limits the observed displacement itself. */
bool saltus_system_stop_observed(const saltus_system *system, int stop);
/* The observed place on a line, 0 < xi < 1; NAN if it is not the displacement at a place. */
double saltus_system_observed_place(const saltus_system *system);
/* The name of the observed displacement: an observed quantity, a stop's coordinate or a displacement; NULL
 * for built-in models that have symbols for it (saltus_notation). */
const char *saltus_system_observed_name(const saltus_system *system);
/* The quantities under `observe` in a model's text: their number, the k-th one's name, and all their values
 * at a state and a phase of the forcing (NaN if there is no memory). */
int saltus_system_observable_count(const saltus_system *system);
const char *saltus_system_observable_name(const saltus_system *system, int k);
void saltus_system_observe(const saltus_system *system, const double *state, double phase, double *values);
/* The observed displacement for a vector of displacements, or its rate for velocities (length dof). */
double saltus_system_observed(const saltus_system *system, const double *vector);
/* The Poincare section of a scene without forcing; its returns count an orbit's periods. */
typedef enum saltus_poincare_kind {
    SALTUS_POINCARE_MAXIMA, /* maxima of the observed displacement, smooth or by an impact */
    SALTUS_POINCARE_IMPACT, /* impacts on a stop */
    SALTUS_POINCARE_ZERO    /* an expression passes through zero */
} saltus_poincare_kind;

typedef struct saltus_poincare {
    saltus_poincare_kind kind;
    int stop;         /* IMPACT: the stop, from 0, ... */
    int side;         /* ... and its face: 1 upper, -1 lower, 0 either */
    int direction;    /* ZERO: 1 rising, -1 falling */
    const char *text; /* ZERO: the expression as written; owned by the model */
} saltus_poincare;

/* The section that the model's text chooses; by default the maxima. */
saltus_poincare saltus_system_poincare(const saltus_system *system);
/* The section's expression times its direction, at a state; NAN if it has none. */
double saltus_system_poincare_value(const saltus_system *system, const double *state);
/* A small admissible initial state for scenes without one. Errors: SALTUS_BAD_INPUT if there is none
 * (pre-loads that contradict each other). */
saltus_status saltus_system_default_state(const saltus_system *system, double *state,
                                          saltus_message *message);
/* Check that a state is finite and beyond no stop (SALTUS_CAUSE_BEYOND); `message` names the stop and the
 * displacement. */
saltus_status saltus_system_check_state(const saltus_system *system, const double *state,
                                        saltus_message *message);
/* Trace of the vector field's Jacobian at a state and a phase of the forcing in [0, 1), for the sum rule of
 * exponents (model.md, section 1). NAN where it has no value, or without memory for large systems. */
double saltus_system_trace(const saltus_system *system, const double *state, double phase);
/* Whether a scene without forcing preserves volumes (zero trace, r = 1), so that orbits form continua. */
bool saltus_system_conservative(const saltus_system *system);
/* Upper bound on the decay rates of the system's linear part. */
double saltus_system_fastest_decay(const saltus_system *system);
/* Displacement at position xi along the structure (0..1): eta(xi) of a pipe, the masses of an oscillator
 * joined by straight lines from the support at xi = 0. */
double saltus_system_shape(const saltus_system *system, const double *state, double xi);
/* Name of the integrator chosen when the system was built ("taylor" or "mixed"). */
const char *saltus_system_integrator(const saltus_system *system);

SALTUS_API_END
#endif
