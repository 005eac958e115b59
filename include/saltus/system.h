/* Systems: the constant description of a structure, its forcing and its stops.
 *
 * A system is built once from a specification (a model, its parameters, its stops), checked, and never
 * written again; any number of flows may share it. Everything is nondimensional unless a model says
 * otherwise.
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
    SALTUS_FACES_MAX = 24,      /* one-sided contacts: two for each two-sided stop */
    SALTUS_STATE_MAX = 288,     /* length of a state */
    SALTUS_OBSERVE_MAX = 40     /* bytes of the name of what is observed */
};

/* One entry of an option or parameter table: it gives the default, the check, `--set`, `--help` and file
 * headers. */
typedef struct saltus_parameter {
    const char *name;    /* the symbol used in scenes, on the command line and in results */
    bool integer;        /* whole numbers only */
    double fallback;     /* default */
    double min, max;     /* admissible range */
    bool open_min;       /* min itself is not admissible */
    bool open_max;       /* max itself is not admissible */
    const char *meaning; /* one phrase, with the unit where there is one */
    const char *given;   /* it has an effect only where the parameter of this name (NULL: always) ... */
    double above;        /* ... is greater than this */
} saltus_parameter;

typedef struct saltus_model saltus_model;

/* Number of models and the k-th one (NULL beyond the last). Static storage. */
int saltus_model_count(void);
const saltus_model *saltus_model_at(int k);
/* The model of that name, or NULL. */
const saltus_model *saltus_model_find(const char *name);
const char *saltus_model_name(const saltus_model *model);
const char *saltus_model_summary(const saltus_model *model);
/* The equations of a model from text as one JSON object, whole: what files of results keep; NULL for a
 * built-in one. */
const char *saltus_model_text(const saltus_model *model);
/* Whether two models are one: the same built-in one, or of equal texts. */
bool saltus_model_same(const saltus_model *a, const saltus_model *b);
/* The parameter table of a model and its length. */
const saltus_parameter *saltus_model_parameters(const saltus_model *model, int *count);
/* Index of a parameter in the model's table, or -1. */
int saltus_model_parameter_index(const saltus_model *model, const char *name);

/* What a model's displacements belong to. */
typedef enum saltus_structure {
    SALTUS_STRUCTURE_LINE,  /* a line, which has a displacement at every place xi of it: a pipe, a beam */
    SALTUS_STRUCTURE_BODIES /* separate bodies */
} saltus_structure;

/* How texts and figures speak of a model; symbols in UTF-8. */
typedef struct saltus_notation {
    saltus_structure structure;
    const char
        *displacement;      /* symbol of the displacement: of the line at a place, of a body by its number */
    const char *coordinate; /* symbol of the state's displacements, with their number */
    const char *part;       /* what the k-th of them is called: "mode", "mass" */
    const char *time;       /* symbol */
    int response;           /* forcing periods of a response cycle: 2 where the forcing is parametric */
} saltus_notation;

/* Static storage. */
const saltus_notation *saltus_model_notation(const saltus_model *model);

typedef enum saltus_sides { SALTUS_UPPER = 1, SALTUS_LOWER = 2, SALTUS_BOTH = 3 } saltus_sides;

/* A rigid stop. The contact coordinate g is a linear function of the displacements: eta(xi) of a pipe,
 * weight[0] x1 + weight[1] x2 of an oscillator; of a text also a constant part, which is taken off the faces'
 * clearances. An upper stop forbids g > d, a lower one g < -d. */
typedef struct saltus_stop {
    double xi;        /* position along the pipe, 0 < xi < 1 (pipe only) */
    double weight[2]; /* the coordinate that the stop limits (oscillator only) */
    double d;         /* clearance; negative is a pre-load, possible for a one-sided stop only */
    double r;         /* coefficient of restitution, 0 <= r <= 1; its limit at small closing speeds */
    saltus_sides sides;
} saltus_stop;

/* Ranges of the keys of a stop (xi, d, r), in the form of the parameter tables. */
const saltus_parameter *saltus_stop_parameters(int *count);

/* What a system is built from: plain values, owned by the caller. */
typedef struct saltus_spec {
    const saltus_model *model;
    double parameters[SALTUS_PARAMETERS_MAX]; /* in the order of the model's table */
    saltus_stop stops[SALTUS_STOPS_MAX];
    int stop_count;
    /* The displacement that turning points, extremes, spectra and diagrams are of: a displacement by its name
     * (saltus_system_state_name), a stop's coordinate (stop1, stop2, ...), a quantity that a text observes,
     * or a place on a line (0.3). "": the text's first quantity, where that is a sum of displacements, else
     * the first stop's coordinate, else the middle of a line or the first displacement. */
    char observe[SALTUS_OBSERVE_MAX];
    double clock; /* of a model without forcing: the angular frequency whose period times are counted in; 0
                     stands for 2 pi, which counts them in units of time */
} saltus_spec;

/* The key that places a stop of the model, xi or weight, and its numbers in a stop: *count of them, where one
 * is written as a number and more as a list. */
const char *saltus_model_stop_key(const saltus_model *model);
const double *saltus_stop_place(const saltus_model *model, const saltus_stop *stop, int *count);

/* What the scene's text says of a stop's coordinate, or of its d or r where they are expressions; NULL where
 * it says nothing, and for built-in models. */
typedef enum saltus_stop_part {
    SALTUS_STOP_COORDINATE,
    SALTUS_STOP_CLEARANCE,
    SALTUS_STOP_RESTITUTION
} saltus_stop_part;
const char *saltus_stop_text(const saltus_spec *spec, int stop, saltus_stop_part part);
/* The expression of a restitution that depends on the closing speed, `speed`; NULL: r is a number. */
const char *saltus_restitution_law(const saltus_spec *spec, int stop);

/* The model's defaults without any stop. */
saltus_spec saltus_spec_defaults(const saltus_model *model);
/* The value of a key of `--set`: a parameter of the model, or d, r, xi (of all stops), d1, r2, ... (of one).
 * NaN where there is no such key or no such stop, and where the stops differ under a common key. */
double saltus_spec_get(const saltus_spec *spec, const char *name);
/* Whether the k-th parameter has an effect, given the others. */
bool saltus_spec_matters(const saltus_spec *spec, int k);
/* Whether two specifications describe the same system: equal models, parameters and stops. */
bool saltus_spec_equal(const saltus_spec *a, const saltus_spec *b);
/* A stop with the defaults xi = 1/2, weight = (1, 0), d = 1, r = 0.9, upper side. */
saltus_stop saltus_stop_defaults(void);

/* A direction in parameter space: the rate at which a specification changes with one number. */
typedef struct saltus_direction {
    double parameter[SALTUS_PARAMETERS_MAX]; /* in the order of the model's table */
    double d[SALTUS_STOPS_MAX], r[SALTUS_STOPS_MAX], xi[SALTUS_STOPS_MAX];
    double clock;
} saltus_direction;

/* The direction of a key of `--set`: a parameter of the model other than a whole number, or d, r, xi (of all
 * stops) or d1, r2, ... (of one). `value` (may be NULL) receives the key's present value. Errors:
 * SALTUS_BAD_INPUT (no such key, a whole number, stops that differ under a common key, derivative not
 * defined at the present value). */
saltus_status saltus_spec_direction(const saltus_spec *spec, const char *key, saltus_direction *direction,
                                    double *value, saltus_message *message);
/* The angular frequency that times are counted by: the forcing's, or the clock of a model without one. */
double saltus_spec_omega(const saltus_spec *spec);
void saltus_spec_set_omega(saltus_spec *spec, double omega);
/* The direction of that number. */
saltus_direction saltus_spec_omega_direction(const saltus_spec *spec);
/* spec + amount * direction. */
saltus_spec saltus_spec_shifted(const saltus_spec *spec, const saltus_direction *direction, double amount);

typedef struct saltus_system saltus_system;

/* One one-sided contact as the flow sees it: gap(q) = normal . q - d <= 0. */
typedef struct saltus_face {
    int stop; /* index into the spec's stops */
    int side; /* +1 upper, -1 lower */
    double d; /* clearance */
    double r; /* restitution; where it depends on the closing speed, its limit at 0 */
} saltus_face;

/* Check a specification and build a system from it.
 * On success *system is a new object to be freed with saltus_system_free; on failure it is NULL and `message`
 * (may be NULL) names the key, the value and what would be right.
 * Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_system_new(const saltus_spec *spec, saltus_system **system, saltus_message *message);
/* NULL is accepted. */
void saltus_system_free(saltus_system *system);

const saltus_spec *saltus_system_spec(const saltus_system *system);
/* Degrees of freedom (modes), extra first-order states, and the length of a state vector:
 * displacements q, then velocities q', then the extra states. */
int saltus_system_dof(const saltus_system *system);
int saltus_system_extra(const saltus_system *system);
int saltus_system_dimension(const saltus_system *system);
/* What an entry of the state is called in --set, in files and in figures, and which one a name means. */
typedef struct saltus_state_name {
    char text[40];
} saltus_state_name;
/* Of a model from text the text's own names, x, x' and p, and x1, x1' of families; of a built-in one q1, v1,
 * z1: displacements, velocities, further states, from 1. */
saltus_state_name saltus_system_state_name(const saltus_system *system, int entry);
/* The entry of that name, or -1. x_dot is x', and q1, v1, z1 count entries of any model where no name of its
 * text is the same. Parameters come first. */
int saltus_system_state_index(const saltus_system *system, const char *name);
/* The same for a specification, whatever its stops and whether or not its numbers make a system: its
 * whole-number parameters tell. The length of the state and, where `dof` is not NULL, the number of
 * displacements, -1 where there is none; names are empty and indices -1 there, too. */
int saltus_spec_dimension(const saltus_spec *spec, int *dof);
saltus_state_name saltus_spec_state_name(const saltus_spec *spec, int entry);
int saltus_spec_state_index(const saltus_spec *spec, const char *name);
/* The right side of an acceleration (entries 0 to dof - 1) or of a further state's rate (from dof on), as
 * the model from text understands it: masses divided out, numbers folded. To be freed by the caller; NULL for
 * a built-in model, and where memory is lacking. */
char *saltus_system_right_side(const saltus_system *system, int entry);
/* Forcing period T = 2 pi / omega, the unit in which sections and event phases are counted. */
double saltus_system_period(const saltus_system *system);
/* Whether the vector field depends on time. */
bool saltus_system_forced(const saltus_system *system);
/* Whether q -> -q maps the system, stops included, onto itself. With `shift`, together with a shift by half a
 * forcing period: q(t) -> -q(t + T/2), the symmetry of a directly forced system. */
bool saltus_system_mirror_symmetric(const saltus_system *system, bool *shift);
int saltus_system_face_count(const saltus_system *system);
saltus_face saltus_system_face(const saltus_system *system, int face);
/* A face's restitution at a closing speed, which most do not depend on. */
double saltus_system_restitution(const saltus_system *system, int face, double speed);
/* Row vector n with g = n.q for a stop (length dof). */
const double *saltus_system_stop_normal(const saltus_system *system, int stop);
/* The inverse of the mass matrix, dof x dof: the metric of impacts. */
const double *saltus_system_inverse_mass(const saltus_system *system);
/* Gap normal.q - d of a face for a state; negative inside, positive beyond the stop. */
double saltus_system_gap(const saltus_system *system, int face, const double *state);
/* A typical magnitude of each state component (length dimension), for random initial states and scaled
 * distances. */
const double *saltus_system_scale(const saltus_system *system);
/* Largest difference between two states, each entry relative to its scale. */
double saltus_system_distance(const saltus_system *system, const double *a, const double *b);
/* The row vector of the observed displacement, which diagrams show: what the specification chooses
 * (saltus_spec, observe). */
const double *saltus_system_observer(const saltus_system *system);
/* Whether a stop limits that displacement itself. */
bool saltus_system_stop_observed(const saltus_system *system, int stop);
/* Where on a line it is the displacement, 0 < xi < 1; NAN where it is none of a place. */
double saltus_system_observed_place(const saltus_system *system);
/* What it is called: an observed quantity's name, the first stop's coordinate, the first displacement; NULL
 * for built-in models, which have symbols for it (saltus_notation). */
const char *saltus_system_observed_name(const saltus_system *system);
/* The quantities that a model's text names under `observe`: how many, the k-th one's name, and all of them at
 * a state and a phase of the forcing; NaN without memory. */
int saltus_system_observable_count(const saltus_system *system);
const char *saltus_system_observable_name(const saltus_system *system, int k);
void saltus_system_observe(const saltus_system *system, const double *state, double phase, double *values);
/* That displacement of a vector of displacements, or its rate of one of velocities (length dof). */
double saltus_system_observed(const saltus_system *system, const double *vector);
/* The Poincare section of a scene without forcing, whose returns an orbit's period is counted by. */
typedef enum saltus_poincare_kind {
    SALTUS_POINCARE_MAXIMA, /* maxima of the observed displacement, smooth or by an impact */
    SALTUS_POINCARE_IMPACT, /* impacts on a stop */
    SALTUS_POINCARE_ZERO    /* an expression passes through zero */
} saltus_poincare_kind;

typedef struct saltus_poincare {
    saltus_poincare_kind kind;
    int stop;         /* impact: from 0, ... */
    int side;         /* ... 1 its upper face, -1 its lower one, 0 either */
    int direction;    /* zero: 1 rising, -1 falling */
    const char *text; /* zero: the expression as written; the model's */
} saltus_poincare;

/* What the model's text chooses under `section`; else the maxima. */
saltus_poincare saltus_system_poincare(const saltus_system *system);
/* The value of its expression, times its direction, at a state; NAN where it is none. */
double saltus_system_poincare_value(const saltus_system *system, const double *state);
/* A small admissible initial state for scenes that give none. Errors: SALTUS_BAD_INPUT when none could be
 * found (contradicting pre-loads). */
saltus_status saltus_system_default_state(const saltus_system *system, double *state,
                                          saltus_message *message);
/* Check that a state is finite and beyond no stop. `message` names the stop and the displacement. */
saltus_status saltus_system_check_state(const saltus_system *system, const double *state,
                                        saltus_message *message);
/* Trace of the Jacobian of the vector field at a state and a phase of the forcing in [0, 1) (model.md,
 * section 1), for the sum rule of exponents. NAN where it has no value, or no memory for many equations. */
double saltus_system_trace(const saltus_system *system, const double *state, double phase);
/* Whether a scene without forcing keeps volumes: the trace is zero and every stop has r = 1. Nothing attracts
 * then, and orbits form continua. */
bool saltus_system_conservative(const saltus_system *system);
/* Bound on the decay rates of the system's linear part: how fast the fastest direction contracts. */
double saltus_system_fastest_decay(const saltus_system *system);
/* Displacement at position xi along the structure (0..1): eta(xi) of a pipe, the masses of an oscillator
 * joined by straight lines from the support at xi = 0. */
double saltus_system_shape(const saltus_system *system, const double *state, double xi);
/* Name of the integrator chosen when the system was built ("taylor" or "mixed"). */
const char *saltus_system_integrator(const saltus_system *system);

SALTUS_API_END
#endif
