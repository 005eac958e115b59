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
    SALTUS_ORDER_MIN = 8,   /* of Taylor series */
    SALTUS_ORDER_MAX = 40,
    SALTUS_SCALARS_MAX = 12,
    SALTUS_ROWS_MAX = 8,
    SALTUS_COUPLINGS_MAX = 2
};

/* The numbers a model's kernel works with. Scalars and rows may differ between the lanes of one flow;
 * couplings depend on the number of degrees of freedom alone and are shared. */
typedef struct saltus_coefficients {
    double scalar[SALTUS_SCALARS_MAX];
    double *row[SALTUS_ROWS_MAX];           /* each dof long */
    double *coupling[SALTUS_COUPLINGS_MAX]; /* each dof x dof, row-major; zero where i + j is even */
    int rows, couplings;
    double *slot; /* of a tape */
    int slots;
    unsigned terms; /* which terms the scene has (saltus_term) */
} saltus_coefficients;

/* A clearance that is so small a part of what else is known of a motion's size tells nothing of that. */
#define SALTUS_NO_CLEARANCE 1e-4

/* Whether the flow keeps volumes, as saltus_system_conservative of a scene with forcing, too. */
bool saltus_system_keeps_volume(const saltus_system *system);

enum saltus_term {
    SALTUS_TERM_FORCED = 1,
    SALTUS_TERM_CUBIC = 2,
    SALTUS_TERM_COUPLED = 4,
    SALTUS_TERM_EXTRA = 8
};

/* The observed displacement. */
typedef struct saltus_observer {
    double *row;             /* of the displacements */
    int stop;                /* whose coordinate it is; -1: none's */
    int first;               /* the first stop whose coordinate it is; the number of stops: none's */
    int quantity;            /* of those that the model's text observes; -1: none */
    double place;            /* on a line; NAN: it is not the displacement at a place */
    const char *name;        /* NULL: what the model's notation says. The model's, the spec's or ... */
    saltus_state_name entry; /* ... that of a displacement */
} saltus_observer;

struct saltus_system {
    saltus_arena arena;
    saltus_spec spec;
    int dof, extra, dimension;
    double omega, period;
    bool forced;
    bool mirror, mirror_shift;
    bool guarded; /* states may leave where the equations have a value: sqrt, log, asin, acos, powers */
    /* Beyond 1 collocation pays for a single trajectory: how many times longer a step the motion allows than
     * the fastest decay, over how many times as much it costs. */
    double stiffness_ratio;
    double rate;  /* bound on the modulus of the linear part's eigenvalues */
    double decay; /* bound on its decay rates */
    int face_count;
    saltus_face faces[SALTUS_FACES_MAX];
    unsigned by_speed;                     /* faces whose restitution depends on the closing speed, as bits */
    double *stop_normal[SALTUS_STOPS_MAX]; /* n */
    double
        offset[SALTUS_STOPS_MAX]; /* the constant part of a coordinate n.q + offset: it is in the faces' d */
    double *stop_impulse[SALTUS_STOPS_MAX]; /* M^-1 n / (n M^-1 n): normal . impulse = 1 */
    double *inverse_mass;                   /* dof x dof */
    saltus_observer observer;
    double *scale;
    double *linear; /* rates of velocities and extra states by the state, near rest: [dof + extra][dimension];
                       NULL where that is much (spectrum.h) */
    double *damping, *stiffness; /* q'' + damping q' + stiffness q: the part exact in the stiff integrator */
    saltus_coefficients coefficients;
    const saltus_tape *tape; /* of a system from text, otherwise NULL; the model's */
    double *numbers;         /* values of its graph's nodes; those that are numbers are right */
};

/* The sizes that a face's gap is the difference of: rounding moves it by parts in 1e16 of these. */
double saltus_system_gap_size(const saltus_system *system, int face, const double *state);
/* Whether a state is off a face (-1), on it but for rounding (0) or beyond it (1). */
int saltus_system_gap_sign(const saltus_system *system, int face, const double *state);

/* n M^-1 n of a face: what a unit of its contact force makes of the acceleration across it. */
double saltus_system_compliance(const saltus_system *system, int face);

/* The numbers of a stop, in the order of saltus_stop_parameters. */
enum { SALTUS_STOP_XI, SALTUS_STOP_D, SALTUS_STOP_R, SALTUS_STOP_NUMBERS };

/* Newton's law of a face at a closing speed. */
typedef struct saltus_rebound {
    double r;     /* restitution: the rebound's speed is r speed */
    double slope; /* d(r speed) / d speed */
} saltus_rebound;
saltus_rebound saltus_system_rebound(const saltus_system *system, int face, double speed);

/* How a system changes along a direction in parameter space: the derivative of all that a flow takes from it.
 */
typedef struct saltus_variation {
    const saltus_direction *direction; /* must live on */
    saltus_coefficients coefficients;  /* scalars and rows; `terms`: those that the derivative needs on */
    double omega;
    double d[SALTUS_STOPS_MAX], r[SALTUS_STOPS_MAX];
    double offset[SALTUS_STOPS_MAX];
    bool tilts;                        /* normals or impulses change: projections at contacts with them */
    double *normal[SALTUS_STOPS_MAX];  /* of n */
    double *impulse[SALTUS_STOPS_MAX]; /* of M^-1 n / (n M^-1 n) */
    double *inverse_mass;              /* dof x dof */
    double *observer;                  /* of the observed displacement's row */
} saltus_variation;

/* The derivative of a face's restitution at a closing speed along a variation. */
double saltus_variation_restitution(const saltus_variation *variation, const saltus_system *system, int face,
                                    double speed);

/* Whether the section that the model's text chooses is one of the scene: it is not forced, and has the stop.
 * Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_spec_check_poincare(const saltus_spec *spec, saltus_message *message);

/* A system like another that counts time by another omega. Errors: those of saltus_system_new. */
saltus_status saltus_system_clocked(const saltus_system *system, double omega, saltus_system **clocked,
                                    saltus_message *message);

/* One more owner of a model, and one less. Built-in models are not counted; NULL is accepted. */
void saltus_model_retain(const saltus_model *model);
void saltus_model_release(const saltus_model *model);

/* Choose what a system observes, as its specification says, into its observer. Errors: SALTUS_BAD_INPUT, with
 * all that could be observed. */
saltus_status saltus_observer_choose(saltus_system *system, saltus_message *message);

/* Whether the derivative along a direction is defined. Errors: SALTUS_BAD_INPUT, with the parameter. */
saltus_status saltus_spec_differentiable(const saltus_spec *spec, const saltus_direction *direction,
                                         saltus_message *message);
/* Reserve a variation's arrays (called for measuring and again for handing out), and fill them in. */
void saltus_variation_reserve(saltus_variation *variation, const saltus_system *system, saltus_arena *arena);
void saltus_variation_fill(saltus_variation *variation, const saltus_system *system,
                           const saltus_direction *direction);

/* One model: a const table entry. A new model is one file with such an entry, one line in models.c and one in
 * the build's list of kernels. */
struct saltus_model {
    const char *name;
    const char *kernel; /* under which its kernels are listed */
    const char *summary;
    const saltus_parameter *parameters;
    int parameter_count;
    saltus_notation notation;
    const char *stop_key; /* which key places a stop: "xi", "weight" or "coordinate" */
    size_t stop_place;    /* offset of its numbers in a saltus_stop, and how many they are */
    int stop_numbers;     /* none: the model's text says it */
    int forcing;      /* the parameter that is the angular frequency; -1: none, time is counted in units */
    const char *text; /* of one from saltus_text_model_new, otherwise NULL (saltus_model_text) */
    /* What the text says of a stop: 0 its coordinate, 1 its clearance, 2 its restitution; NULL: nothing. */
    const char *(*coordinate)(const saltus_model *model, int stop, int which);
    void (*own)(const saltus_model *model,
                int change); /* count owners, free without any; NULL: none counted */
    /* Checks that no single range can express; the sizes. */
    saltus_status (*shape)(const saltus_spec *spec, int *dof, int *extra, saltus_message *message);
    /* Restitutions that depend on the closing speed: of a stop at a speed, and their derivative along a
     * direction. Whether a stop's does; NULL: none. */
    bool (*by_speed)(const saltus_spec *spec, int stop);
    saltus_rebound (*rebound)(const saltus_system *system, int stop, double speed);
    double (*rebound_change)(const saltus_system *system, int stop, double speed,
                             const saltus_direction *direction);
    /* Fill in what stops take from parameters; NULL: nothing. After `shape`. */
    void (*complete)(saltus_spec *spec);
    /* Row vector n of a stop; NAN without memory. */
    void (*normal)(const saltus_spec *spec, int dof, const saltus_stop *stop, double *normal);
    int rows, couplings; /* of its coefficients */
    /* Reserve what else there is (called for measuring and again for handing out); NULL: nothing. */
    void (*reserve)(saltus_system *system);
    /* Fill coefficients, inverse mass, scale, modal part, rate, symmetry. */
    void (*build)(saltus_system *system);
    /* Derivative of coefficients and inverse mass along a direction; all is zero beforehand. */
    void (*vary)(const saltus_system *system, const saltus_direction *direction, saltus_variation *variation);
    /* Derivative of a stop's normal with respect to xi; NULL where stops are not placed by xi. */
    void (*tilt)(int dof, const saltus_stop *stop, double *normal);
    /* Why the derivative with respect to a parameter is not defined at its present value; NULL if it is, and
     * for a model in which it always is. */
    const char *(*obstacle)(const saltus_spec *spec, int parameter);
    /* What the model's text says of the initial state, over a default one; NULL: nothing. */
    void (*start)(const saltus_system *system, double *state);
    double (*trace)(const saltus_system *system, const double *state, double phase);
    double (*deflection)(const saltus_system *system, const double *state, double xi); /* NULL: of bodies */
    /* Names and right sides that a text gives (saltus_system_state_name, saltus_system_right_side); NULL:
     * names are those of all built-in models. After `shape`. */
    saltus_state_name (*state_name)(const saltus_spec *spec, int dof, int entry);
    char *(*right_side)(const saltus_system *system, int entry);
    /* The k-th observed quantity's name, NULL beyond the last one, and the values of all. NULL: there are
     * none. */
    const char *(*observable)(const saltus_model *model, int k);
    void (*observe)(const saltus_system *system, const double *state, double phase, double *values);
    /* What the text says of the section, and its expression's value at a state. */
    saltus_poincare poincare;
    double (*crossing)(const saltus_system *system, const double *state);
    /* The row of the k-th observed quantity; false where it is no sum of displacements. */
    bool (*observable_row)(const saltus_system *system, int k, double *row);
    /* Whether the equations have a value at a state: asked where `guarded` says that some may have none. */
    bool (*defined)(const saltus_system *system, const double *state, double phase);
    /* What in the equations has no value at a state, or none close by: "sqrt(p) has no value where p = -1".
     * False: all is well. NULL: nothing can go wrong. */
    bool (*fault)(const saltus_system *system, const double *state, double phase, saltus_message *what);
};

/* Whether the equations have a value at a state. */
bool saltus_system_defined(const saltus_system *system, const double *state, double phase);
/* What in them has none there or close by, as a sentence; false: nothing. */
bool saltus_system_fault(const saltus_system *system, const double *state, double phase,
                         saltus_message *what);

/* The first entries of a state by name: "x, y" or, of many, "q1 to q5". */
enum { SALTUS_NAMES_MAX = 128 };
const char *saltus_system_list_names(const saltus_system *system, int count, char names[SALTUS_NAMES_MAX]);

extern const saltus_model saltus_pipe;
extern const saltus_model saltus_oscillator;

#endif
