/* Private: what a built system holds, and what a model provides.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_PRIVATE_H
#define SALTUS_SYSTEM_PRIVATE_H

#include "base/memory.h"
#include "base/word.h"
#include "saltus/system.h"
#include "system/tape.h"

enum {
    SALTUS_MODES_MAX = 128, /* degrees of freedom */
    SALTUS_ORDER_MIN = 8,   /* order of Taylor series */
    SALTUS_ORDER_MAX = 40,
    SALTUS_SCALARS_MAX = 12,
    SALTUS_ROWS_MAX = 8,
    SALTUS_COUPLINGS_MAX = 2
};

/* The numbers that a model's kernel works with. Scalars and rows may differ between the lanes of one flow;
 * couplings depend only on the number of degrees of freedom and are shared. */
typedef struct saltus_coefficients {
    double scalar[SALTUS_SCALARS_MAX];
    double *row[SALTUS_ROWS_MAX];           /* [dof] each */
    double *coupling[SALTUS_COUPLINGS_MAX]; /* each dof x dof, row-major; zero where i + j is even */
    int rows, couplings;
    double *slot; /* values of a tape's slots */
    int slots;
    unsigned terms; /* which terms the scene has (saltus_term) */
} saltus_coefficients;

/* A clearance below this fraction of another estimate of the motion's size says nothing about that size. */
#define SALTUS_NO_CLEARANCE 1e-4

/* Whether the flow preserves volumes between impacts. */
bool saltus_system_traceless(const saltus_system *system);
/* Whether the flow preserves volumes: as saltus_system_conservative, but also for scenes with forcing. */
bool saltus_system_keeps_volume(const saltus_system *system);

enum saltus_term {
    SALTUS_TERM_FORCED = 1,
    SALTUS_TERM_CUBIC = 2,
    SALTUS_TERM_COUPLED = 4,
    SALTUS_TERM_EXTRA = 8
};

/* The observed displacement. */
typedef struct saltus_observer {
    double *row;             /* [dof]: weights of the displacements */
    int stop;                /* the stop whose coordinate was chosen; -1: none */
    int first;               /* the first stop with this coordinate; the number of stops: none */
    int quantity;            /* index into what the model's text observes; -1: none */
    double place;            /* place on a line; NAN: not the displacement at a place */
    const char *name;        /* NULL: the model's notation names it. Owned by the model, the spec or ... */
    saltus_state_name entry; /* ... this: the name of a displacement */
} saltus_observer;

struct saltus_system {
    saltus_arena arena;
    saltus_spec spec;
    int dof, extra, dimension;
    double omega, period;
    bool forced;
    bool mirror, mirror_shift;
    bool guarded; /* states may leave the domain of sqrt, log, asin, acos or powers in the equations */
    /* Above 1 collocation pays for a single trajectory: (step that the motion allows / step that the fastest
     * decay allows) / relative cost of a step. */
    double stiffness_ratio;
    double rate;  /* upper bound on the moduli of the linear part's eigenvalues */
    double decay; /* upper bound on its decay rates */
    int face_count;
    saltus_face faces[SALTUS_FACES_MAX];
    unsigned by_speed;                     /* faces whose restitution depends on the closing speed, as bits */
    double *stop_normal[SALTUS_STOPS_MAX]; /* n, [dof] */
    double
        offset[SALTUS_STOPS_MAX]; /* constant part of the coordinate n.q + offset, included in the faces' d */
    double *stop_impulse[SALTUS_STOPS_MAX]; /* M^-1 n / (n M^-1 n): normal . impulse = 1 */
    double stop_reach[SALTUS_STOPS_MAX];    /* |n|, at most 1: how far it moves when the modes move by 1 */
    double stop_reply[SALTUS_STOPS_MAX];    /* |n| |M^-1 n| / (n M^-1 n) */
    double *inverse_mass;                   /* dof x dof */
    saltus_observer observer;
    double *scale;
    double *linear; /* derivatives of the rates of velocities and extra states by the state, near rest: [dof +
                       extra][dimension]; NULL for large systems (spectrum.h) */
    double *damping, *stiffness; /* the part q'' + damping q' + stiffness q, exact in the stiff integrator */
    saltus_coefficients coefficients;
    const saltus_tape *tape; /* of a system from text, else NULL; owned by the model */
    double *numbers;         /* values of its graph's nodes; valid for those of parameters alone */
};

/* Size of the terms whose difference is a face's gap: rounding moves the gap by parts in 1e16 of it. */
double saltus_system_gap_size(const saltus_system *system, int face, const double *state);
/* -1: the state is off the face; 0: on it up to rounding; 1: beyond it. */
int saltus_system_gap_sign(const saltus_system *system, int face, const double *state);

/* n M^-1 n of a face: the normal acceleration due to a unit contact force. */
double saltus_system_compliance(const saltus_system *system, int face);

/* The numbers of a stop, in the order of saltus_stop_parameters. */
enum { SALTUS_STOP_XI, SALTUS_STOP_D, SALTUS_STOP_R, SALTUS_STOP_NUMBERS };

/* Newton's impact law of a face at a closing speed. */
typedef struct saltus_rebound {
    double r;     /* restitution: the rebound speed is r speed */
    double slope; /* d(r speed) / d speed */
} saltus_rebound;
saltus_rebound saltus_system_rebound(const saltus_system *system, int face, double speed);

/* Derivative of a system along a direction in parameter space: of everything that a flow takes from it. */
typedef struct saltus_variation {
    const saltus_direction *direction; /* must outlive the variation */
    saltus_coefficients coefficients;  /* scalars and rows; `terms`: those that it needs in the flow */
    double omega;
    double d[SALTUS_STOPS_MAX], r[SALTUS_STOPS_MAX];
    double offset[SALTUS_STOPS_MAX];
    bool tilts;                        /* normals or impulses change, and with them projections at contacts */
    double *normal[SALTUS_STOPS_MAX];  /* derivative of n */
    double *impulse[SALTUS_STOPS_MAX]; /* derivative of M^-1 n / (n M^-1 n) */
    double *inverse_mass;              /* dof x dof */
    double *observer;                  /* derivative of the observer's row */
} saltus_variation;

/* The derivative of a face's restitution at a closing speed along a variation. */
double saltus_variation_restitution(const saltus_variation *variation, const saltus_system *system, int face,
                                    double speed);

/* Check that the section of the model's text suits the scene: no forcing, a stop that exists. Errors:
 * SALTUS_BAD_INPUT. */
saltus_status saltus_spec_check_poincare(const saltus_spec *spec, saltus_message *message);

/* A copy of a system that counts time by another omega. Errors: those of saltus_system_new. */
saltus_status saltus_system_clocked(const saltus_system *system, double omega, saltus_system **clocked,
                                    saltus_message *message);

/* Add and remove an owner of a model. Built-in models are not counted; NULL is accepted. */
void saltus_model_retain(const saltus_model *model);
void saltus_model_release(const saltus_model *model);

/* Set a system's observer as its specification says. Errors: SALTUS_BAD_INPUT, with all possible choices. */
saltus_status saltus_observer_choose(saltus_system *system, saltus_message *message);

/* Check that the derivative along a direction is defined. Errors: SALTUS_BAD_INPUT, with the parameter. */
saltus_status saltus_spec_differentiable(const saltus_spec *spec, const saltus_direction *direction,
                                         saltus_message *message);
/* Reserve a variation's arrays (called once to measure, once to hand out), and fill them in. */
void saltus_variation_reserve(saltus_variation *variation, const saltus_system *system, saltus_arena *arena);
void saltus_variation_fill(saltus_variation *variation, const saltus_system *system,
                           const saltus_direction *direction);

/* One model: a const table entry. A new model is one file with such an entry, one line in models.c and one in
 * the build's list of kernels. */
struct saltus_model {
    const char *name;
    const char *kernel; /* name of its kernels */
    const char *summary;
    const saltus_parameter *parameters;
    int parameter_count;
    saltus_notation notation;
    const char *stop_key; /* the key that places a stop: "xi", "weight" or "coordinate" */
    size_t stop_place;    /* offset of the key's numbers in a saltus_stop, and ... */
    int stop_numbers;     /* ... how many they are; 0: the model's text places stops */
    int forcing;          /* index of the angular frequency parameter; -1: none, time is counted in units */
    const char *text;     /* of a model from saltus_text_model_new, else NULL (saltus_model_text) */
    /* The text for a stop's coordinate (0), clearance (1) or restitution (2); returns NULL if it has none. */
    const char *(*coordinate)(const saltus_model *model, int stop, int which);
    void (*own)(const saltus_model *model,
                int change); /* count owners, free the model without any; NULL: static */
    /* Checks beyond the ranges of single parameters; sets the sizes. */
    saltus_status (*shape)(const saltus_spec *spec, int *dof, int *extra, saltus_message *message);
    /* For restitutions that depend on the closing speed: whether a stop's does, Newton's law at a speed, and
     * its derivative along a direction. NULL: none does. */
    bool (*by_speed)(const saltus_spec *spec, int stop);
    saltus_rebound (*rebound)(const saltus_system *system, int stop, double speed);
    double (*rebound_change)(const saltus_system *system, int stop, double speed,
                             const saltus_direction *direction);
    /* Set stop values that are expressions of parameters; NULL: there are none. After `shape`. */
    void (*complete)(saltus_spec *spec);
    /* Row vector n of a stop; NAN if there is no memory. */
    void (*normal)(const saltus_spec *spec, int dof, const saltus_stop *stop, double *normal);
    int rows, couplings; /* numbers of rows and couplings in the coefficients */
    /* Reserve further arrays (called once to measure, once to hand out); NULL: none. */
    void (*reserve)(saltus_system *system);
    /* Set coefficients, inverse mass, scale, modal part, rate, symmetry. */
    void (*build)(saltus_system *system);
    /* Derivative of coefficients and inverse mass along a direction; all zero before the call. */
    void (*vary)(const saltus_system *system, const saltus_direction *direction, saltus_variation *variation);
    /* Derivative of a stop's normal with respect to xi; NULL where stops are not placed by xi. */
    void (*tilt)(int dof, const saltus_stop *stop, double *normal);
    /* Why the derivative by a parameter has no value at present; NULL if it has. NULL: it always has. */
    const char *(*obstacle)(const saltus_spec *spec, int parameter);
    /* Overwrite a default state with the initial values of the model's text; NULL: nothing. */
    void (*start)(const saltus_system *system, double *state);
    double (*trace)(const saltus_system *system, const double *state, double phase);
    double (*deflection)(const saltus_system *system, const double *state, double xi); /* NULL: bodies */
    /* Names and right sides from a text (saltus_system_state_name, saltus_system_right_side); NULL: the names
     * of built-in models. After `shape`. */
    saltus_state_name (*state_name)(const saltus_spec *spec, int dof, int entry);
    char *(*right_side)(const saltus_system *system, int entry);
    /* The k-th observed quantity's name, NULL beyond the last; all values. NULL: there are none. */
    const char *(*observable)(const saltus_model *model, int k);
    void (*observe)(const saltus_system *system, const double *state, double phase, double *values);
    /* The section chosen by the text, and the value of its expression at a state. */
    saltus_poincare poincare;
    double (*crossing)(const saltus_system *system, const double *state);
    /* The row of the k-th observed quantity; false if it is not a sum of displacements. */
    bool (*observable_row)(const saltus_system *system, int k, double *row);
    /* Whether the equations have a value at a state; called only if `guarded`. */
    bool (*defined)(const saltus_system *system, const double *state, double phase);
    /* Describe the term that has no value at a state, or none close by: "sqrt(p) has no value where p = -1".
     * False: there is none. NULL: nothing can go wrong. */
    bool (*fault)(const saltus_system *system, const double *state, double phase, saltus_message *what);
};

/* Whether the equations have a value at a state. */
bool saltus_system_defined(const saltus_system *system, const double *state, double phase);
/* Describe the term that has none there or close by; false: there is none. */
bool saltus_system_fault(const saltus_system *system, const double *state, double phase,
                         saltus_message *what);

/* The names of the first entries of a state: "x, y" or, for many, "q1 to q5". */
enum { SALTUS_NAMES_MAX = 128 };
const char *saltus_system_list_names(const saltus_system *system, int count, char names[SALTUS_NAMES_MAX]);
/* The number of the quantity of this name that a text observes; -1: there is none. */
int saltus_system_observable_index(const saltus_system *system, const char *name);

extern const saltus_model saltus_pipe;
extern const saltus_model saltus_oscillator;

#endif
