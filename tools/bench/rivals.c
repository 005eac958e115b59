/* The integrators of GSL and of SUNDIALS on a structure with rigid stops, and the list of all rivals.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "rival_step.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <stdio.h>

#ifdef SALTUS_WITH_SUNDIALS
#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#endif

struct gsl_run {
    gsl_odeiv2_system system;
    gsl_odeiv2_step *stepper;
    gsl_odeiv2_control *control;
    gsl_odeiv2_evolve *evolve;
    double *error;
    struct rival_step last;
};

static int gsl_rate(double tau, const double state[], double rate[], void *field) {
    scene_rate(field, tau, state, rate);
    return GSL_SUCCESS;
}

static void gsl_restart(void *stepper, double tau) {
    (void)tau;
    gsl_odeiv2_evolve_reset(((struct gsl_run *)stepper)->evolve);
}

static bool gsl_take(void *stepper, double *tau, double end, double *length) {
    struct gsl_run *run = stepper;
    const bool done = gsl_odeiv2_evolve_apply(run->evolve, run->control, run->stepper, &run->system, tau, end,
                                              length, run->last.end) == GSL_SUCCESS;
    run->last.length = run->evolve->last_step;
    return done;
}

static bool gsl_again(void *stepper, double length) {
    struct gsl_run *run = stepper;
    const gsl_odeiv2_evolve *evolve = run->evolve;
    memcpy(run->last.trial, evolve->y0, evolve->dimension * sizeof *run->last.trial);
    return gsl_odeiv2_step_apply(run->stepper, run->last.start, length, run->last.trial, run->error,
                                 evolve->dydt_in, run->last.trial_rate, &run->system) == GSL_SUCCESS;
}

static bool run_gsl(int which, const saltus_spec *spec, const double *state0, int periods, double tolerance,
                    rival_result *result) {
    struct scene_field *field = begin(spec, state0, tolerance, result);
    bool done = false;
    (void)which;
    if (!field)
        return false;
    gsl_error_handler_t *const handler = gsl_set_error_handler_off();
    const size_t dimension = field->count;
    struct gsl_run run = {.system = {gsl_rate, NULL, dimension, field},
                          .stepper = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, dimension),
                          .control = gsl_odeiv2_control_standard_new(tolerance, tolerance, 1, 0),
                          .evolve = gsl_odeiv2_evolve_alloc(dimension),
                          .error = malloc(3 * dimension * sizeof *run.error)};
    if (run.stepper && run.control && run.evolve && run.error) {
        run.last = (struct rival_step){.field = field,
                                       .begin = run.evolve->y0,
                                       .begin_rate = run.evolve->dydt_in,
                                       .end = field->vector,
                                       .end_rate = run.evolve->dydt_out,
                                       .trial = run.error + dimension,
                                       .trial_rate = run.error + 2 * dimension,
                                       .stepper = &run,
                                       .restart = gsl_restart,
                                       .take = gsl_take,
                                       .again = gsl_again};
        done = run_repeatedly(field, periods, result, take_steps, &run.last);
    }
    free(run.error);
    if (run.evolve)
        gsl_odeiv2_evolve_free(run.evolve);
    if (run.control)
        gsl_odeiv2_control_free(run.control);
    if (run.stepper)
        gsl_odeiv2_step_free(run.stepper);
    free(field);
    gsl_set_error_handler(handler);
    return done;
}

#ifdef SALTUS_WITH_SUNDIALS

_Static_assert(sizeof(realtype) == sizeof(double), "SUNDIALS has to be built for double precision");

struct sundials_run {
    struct scene_field *field;
    SUNContext context;
    N_Vector state, start;
    void *memory;
    SUNNonlinearSolver iteration; /* Adams */
    SUNMatrix jacobian;           /* BDF */
    SUNLinearSolver solver;
    double *unit;   /* the identity matrix */
    bool repeating; /* a step is being repeated up to an event that is already known */
};

static double *values(N_Vector vector) {
    return N_VGetArrayPointer(vector);
}

static int sundials_rate(realtype tau, N_Vector state, N_Vector rate, void *run) {
    scene_rate(((struct sundials_run *)run)->field, tau, values(state), values(rate));
    return 0;
}

/* For each face two functions that rise through zero at an event: the gap (or -n.f where it holds), and minus
 * the speed towards the stop at the top of a flight, which breaks up steps that hold two zeros of the gap.
 * The gap's zero at the start is divided out. */
static int sundials_roots(realtype tau, N_Vector vector, realtype *root, void *data) {
    const struct sundials_run *run = data;
    struct scene_field *field = run->field;
    const double *state = values(vector);
    const double elapsed = tau - field->contact_time;
    for (int face = 0; face < field->faces; face++, root += 2) {
        const int order = face == field->contact_face ? field->contact_order : 0;
        root[0] = root[1] = -1;
        if (run->repeating)
            continue;
        if (field->sticking) {
            if (face == field->contact_face)
                root[0] = -pressing(field, face, tau, state);
        } else if (order > 0 && elapsed <= 0) {
            root[1] = 1;
        } else {
            root[0] = contact_gap(field, face, state);
            for (int k = 0; k < order; k++)
                root[0] /= elapsed;
            root[1] = -normal_speed(field, face, state);
        }
    }
    return 0;
}

/* The face whose event a root is; -1 for the top of a flight. */
static int face_hit(const struct scene_field *field, const int *found) {
    for (int face = 0; face < field->faces; face++)
        if (found[2 * face])
            return face;
    return -1;
}

/* Repeats the step that contains an event, up to the event's time: the interpolant has a lower order than the
 * step. */
static bool arkode_redo(struct sundials_run *run, int face, double *tau) {
    struct scene_field *field = run->field;
    double reached, step;
    if (ARKStepGetCurrentTime(run->memory, &reached) || ARKStepGetLastStep(run->memory, &step))
        return false;
    const double start = reached - step, length = *tau - start;
    if (ARKStepGetDky(run->memory, start, 0, run->start))
        return false;
    double force_start = 0;
    if (field->sticking)
        force_start = pressing(field, face, start, values(run->start));
    if (length > short_step * step) {
        run->repeating = true;
        double arrived;
        const bool done = !ARKStepReset(run->memory, start, run->start) &&
                          !ARKStepSetInitStep(run->memory, length) &&
                          !ARKStepSetStopTime(run->memory, *tau) &&
                          ARKStepEvolve(run->memory, *tau, run->state, &arrived, ARK_NORMAL) >= 0;
        run->repeating = false;
        if (!done)
            return false;
    }
    if (field->sticking)
        polish_release(field, tau, values(run->state), -force_start / length);
    else
        polish_contact(field, face, tau, values(run->state));
    return true;
}

static bool arkode_integrate(void *it, double end, rival_result *result) {
    struct sundials_run *run = it;
    struct scene_field *field = run->field;
    double tau = 0, usual = field->first_step, due = INFINITY;
    int face = -1;
    bool restart = true;
    while (tau < end) {
        if (restart &&
            (ARKStepReset(run->memory, tau, run->state) ||
             ARKStepSetInitStep(run->memory, fmin(fmin(usual, flight_allowance * due), end - tau)) ||
             ARKStepSetStopTime(run->memory, end)))
            return false;
        int found[2 * faces_max];
        const int status = ARKStepEvolve(run->memory, end, run->state, &tau, ARK_NORMAL);
        if (status < 0 || (status == ARK_ROOT_RETURN && ARKStepGetRootInfo(run->memory, found)))
            return false;
        restart = status == ARK_ROOT_RETURN && (face = face_hit(field, found)) >= 0;
        if (!restart)
            continue;
        double step;
        if (ARKStepGetLastStep(run->memory, &step) || !arkode_redo(run, face, &tau))
            return false;
        if (!(due < usual) || step > usual)
            usual = step;
        due = INFINITY;
        if (field->sticking)
            release(field, tau, values(run->state), result);
        else
            due = rebound(field, face, tau, values(run->state), result);
    }
    return true;
}

static void swallow_message(int code, const char *module, const char *function, char *message, void *data) {
    (void)code, (void)module, (void)function, (void)message, (void)data;
}

/* The library's own makes one pass per vector, zero coefficients included; on vectors as short as these it
 * takes three times as long as the vector field. */
static int linear_combination(int count, realtype *factor, N_Vector *vectors, N_Vector sum) {
    const sunindextype length = NV_LENGTH_S(sum);
    double *total = NV_DATA_S(sum);
    enum { most = 32 };
    const double *term[most];
    double weight[most];
    int terms = 0;
    if (count > most)
        return -1;
    for (int k = 0; k < count; k++)
        if (factor[k] != 0) {
            term[terms] = NV_DATA_S(vectors[k]);
            weight[terms++] = factor[k];
        }
    for (sunindextype i = 0; i < length; i++) {
        double value = 0;
        for (int k = 0; k < terms; k++)
            value += weight[k] * term[k][i];
        total[i] = value;
    }
    return 0;
}

static bool arkode_set_up(struct sundials_run *run, double tolerance) {
    int rising[2 * faces_max] = {1, 1, 1, 1};
    run->memory = ARKStepCreate(sundials_rate, NULL, 0, run->state, run->context);
    return run->memory && !ARKStepSetErrHandlerFn(run->memory, swallow_message, NULL) &&
           !ARKStepSetTableNum(run->memory, ARKODE_DIRK_NONE, ARKODE_FEHLBERG_13_7_8) &&
           !ARKStepSetInterpolantType(run->memory, ARK_INTERP_HERMITE) &&
           !ARKStepSetInterpolantDegree(run->memory, 3) && !ARKStepSetUserData(run->memory, run) &&
           !ARKStepSStolerances(run->memory, tolerance, tolerance) &&
           !ARKStepSetMaxNumSteps(run->memory, -1) &&
           (run->field->faces == 0 ||
            (!ARKStepRootInit(run->memory, 2 * run->field->faces, sundials_roots) &&
             !ARKStepSetRootDirection(run->memory, rising) && !ARKStepSetNoInactiveRootWarn(run->memory)));
}

/* The interpolant of a multistep method has the method's own order, so that the state at a root needs no
 * redoing. */
static bool cvode_integrate(void *it, double end, rival_result *result) {
    struct sundials_run *run = it;
    struct scene_field *field = run->field;
    double tau = 0;
    int face = -1;
    bool restart = true;
    while (tau < end) {
        if (restart && (CVodeReInit(run->memory, tau, run->state) || CVodeSetStopTime(run->memory, end)))
            return false;
        int found[2 * faces_max];
        const int status = CVode(run->memory, end, run->state, &tau, CV_NORMAL);
        if (status < 0 || (status == CV_ROOT_RETURN && CVodeGetRootInfo(run->memory, found)))
            return false;
        restart = status == CV_ROOT_RETURN && (face = face_hit(field, found)) >= 0;
        if (restart && field->sticking)
            release(field, tau, values(run->state), result);
        else if (restart)
            rebound(field, face, tau, values(run->state), result);
    }
    return true;
}

static int cvode_jacobian(realtype tau, N_Vector state, N_Vector rate, SUNMatrix jacobian, void *data,
                          N_Vector spare1, N_Vector spare2, N_Vector spare3) {
    (void)rate, (void)spare1, (void)spare2, (void)spare3;
    const struct sundials_run *run = data;
    tangent_rates(run->field, tau, values(state), 2 * run->field->modes, run->unit,
                  SUNDenseMatrix_Data(jacobian));
    return 0;
}

/* Adams with a fixed-point iteration; BDF with Newton's method and the exact Jacobian, factorised by LU. */
static bool cvode_set_up(struct sundials_run *run, int method, double tolerance) {
    int rising[2 * faces_max] = {1, 1, 1, 1};
    const sunindextype n = 2 * run->field->modes;
    run->memory = CVodeCreate(method, run->context);
    if (!run->memory || CVodeSetErrHandlerFn(run->memory, swallow_message, NULL) ||
        CVodeInit(run->memory, sundials_rate, 0, run->state) || CVodeSetUserData(run->memory, run) ||
        CVodeSStolerances(run->memory, tolerance, tolerance) || CVodeSetMaxNumSteps(run->memory, -1))
        return false;
    if (method == CV_ADAMS)
        run->iteration = SUNNonlinSol_FixedPoint(run->state, 0, run->context);
    if (method == CV_ADAMS && (!run->iteration || CVodeSetNonlinearSolver(run->memory, run->iteration)))
        return false;
    if (method == CV_BDF) {
        run->unit = calloc((size_t)(n * n), sizeof *run->unit);
        run->jacobian = SUNDenseMatrix(n, n, run->context);
        run->solver = run->jacobian ? SUNLinSol_Dense(run->state, run->jacobian, run->context) : NULL;
        for (sunindextype i = 0; i < n && run->unit; i++)
            run->unit[i * n + i] = 1;
        if (!run->unit || !run->solver || CVodeSetLinearSolver(run->memory, run->solver, run->jacobian) ||
            CVodeSetJacFn(run->memory, cvode_jacobian))
            return false;
    }
    return run->field->faces == 0 ||
           (!CVodeRootInit(run->memory, 2 * run->field->faces, sundials_roots) &&
            !CVodeSetRootDirection(run->memory, rising) && !CVodeSetNoInactiveRootWarn(run->memory));
}

/* ARKODE, if `which` is none of CVODE's. CVODE resets its count of steps when it restarts. */
static bool run_sundials(int which, const saltus_spec *spec, const double *state0, int periods,
                         double tolerance, rival_result *result) {
    const bool arkode = which == 0;
    if (result->tangents && which == CV_BDF)
        return false;
    struct sundials_run run = {.field = begin(spec, state0, tolerance, result)};
    bool done = false;
    if (!run.field)
        return false;
    if (SUNContext_Create(NULL, &run.context) == 0) {
        const sunindextype dimension = (sunindextype)run.field->count;
        run.state = N_VMake_Serial(dimension, run.field->vector, run.context);
        run.start = N_VNew_Serial(dimension, run.context);
    }
    if (run.state)
        run.state->ops->nvlinearcombination = linear_combination;
    if (run.state && run.start &&
        (arkode ? arkode_set_up(&run, tolerance) : cvode_set_up(&run, which, tolerance))) {
        done = run_repeatedly(run.field, periods, result, arkode ? arkode_integrate : cvode_integrate, &run);
        if (arkode && ARKStepGetNumSteps(run.memory, &result->steps))
            done = false;
        result->steps /= result->repeats > 1 ? result->repeats : 1;
    }
    if (run.memory)
        (arkode ? ARKStepFree : CVodeFree)(&run.memory);
    if (run.iteration)
        SUNNonlinSolFree(run.iteration);
    if (run.solver)
        SUNLinSolFree(run.solver);
    if (run.jacobian)
        SUNMatDestroy(run.jacobian);
    if (run.state)
        N_VDestroy(run.state);
    if (run.start)
        N_VDestroy(run.start);
    if (run.context)
        SUNContext_Free(&run.context);
    free(run.unit);
    free(run.field);
    return done;
}

#endif

const method saltus_rivals[] = {
    {"GSL rk8pd", "gsl", run_gsl, .tangents = true},
#ifdef SALTUS_WITH_SUNDIALS
    {"SUNDIALS ARKODE 8(7)", "arkode", run_sundials, .tangents = true},
    {"SUNDIALS CVODE Adams", "adams", run_sundials, CV_ADAMS, .tangents = true},
    {"SUNDIALS CVODE BDF", "bdf", run_sundials, CV_BDF, .stiff = true},
#endif
#ifdef SALTUS_WITH_ODEINT
    {"Boost.Odeint dopri5", "dopri5", rival_odeint, odeint_dopri5, .tangents = true},
    {"Boost.Odeint Fehlberg 7(8)", "fehlberg78", rival_odeint, odeint_fehlberg78, .tangents = true},
#endif
};
const int saltus_rival_count = sizeof saltus_rivals / sizeof saltus_rivals[0];

void saltus_rivals_versions(char *text, size_t size) {
    char sundials[32] = "";
    const char *boost = "";
#ifdef SALTUS_WITH_SUNDIALS
    SUNDIALSGetVersion(sundials, sizeof sundials);
#endif
#ifdef SALTUS_WITH_ODEINT
    boost = rival_odeint_version();
#endif
    snprintf(text, size, "%s%s%s%s", *sundials ? ", SUNDIALS " : "", sundials, *boost ? ", Boost " : "",
             boost);
}
