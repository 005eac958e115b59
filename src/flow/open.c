/* Opening flows: all memory is allocated and all choices that depend on the scene are made here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"
#include "flow/options.h"
#include "flow/quiet.h"
#include "system/spectrum.h"

#include <gsl/gsl_pow_int.h>
#include <math.h>
#include <stdlib.h>

const saltus_word saltus_integrator_words[] = {{"automatic", SALTUS_AUTOMATIC},
                                               {"taylor", SALTUS_TAYLOR},
                                               {"radau", SALTUS_RADAU},
                                               {"mixed", SALTUS_MIXED},
                                               {NULL, 0}};

static const saltus_option choices[] = {SALTUS_FLOW_CHOICES(saltus_flow_options, , 1e-13, 1e-16)};
const saltus_option_table saltus_flow_table = SALTUS_TABLE(choices);

saltus_flow_options saltus_flow_defaults(void) {
    saltus_flow_options options = {0};
    saltus_options_fill(&saltus_flow_table, &options);
    return options;
}

/* Steps after which a period is given up. Continuation, whose effort has no period of its own, has no
 * practical limit: it must try what may lie behind an event at any price. */
static double steps_usual(const saltus_flow_options *options) {
    return options->effort && options->effort->period > 0 ? SALTUS_EFFORT_IN_PERIOD : 1e8;
}

/* The order if the tolerance bounds the steps: about six orders for five digits, near the fastest as measured
 * on single reference orbits and on sweeps in lanes. At tight tolerances a higher order buys a margin in
 * accuracy. */
static int order_by_tolerance(double digits) {
    const double margin = 0.35 * gsl_pow_2(fmax(0, digits - 12));
    int order = 2 * (int)lround(0.6 * digits + 1.45 + margin);
    return order < SALTUS_ORDER_MIN ? SALTUS_ORDER_MIN : order;
}

/* If stability bounds the steps, a lower order that reaches as far within the tolerance is faster. Whether
 * one does is judged by the fastest lightly damped modes; what impacts excite beyond these needs four orders
 * for five digits (measured on pipes of 8, 10 and 12 modes). */
static int degree_for(const saltus_system *system, const saltus_eigenvalues *eigenvalues, double rtol) {
    const double digits = -log10(rtol);
    const int most = order_by_tolerance(digits);
    int order = 2 * (int)lround(0.4 * digits + 1);
    order = order < SALTUS_ORDER_MIN ? SALTUS_ORDER_MIN : order;
    while (order < most && !saltus_system_outruns(system, eigenvalues, order,
                                                  exp((lgamma(order + 1) - digits * M_LN10) / order)))
        order += 2;
    return order < most ? order : most;
}

/* Whether two systems have the same vector field up to its numbers. Systems from text need equal tapes,
 * because one tape serves all lanes: integer parameters can give the same text different tapes. */
static bool same_field(const saltus_system *a, const saltus_system *b) {
    if (a->tape && b->tape)
        return a->tape == b->tape || saltus_tape_equal(a->tape, b->tape);
    return saltus_model_same(a->spec.model, b->spec.model);
}

/* Whether two systems have the same field, states and faces. */
static bool same_shape(const saltus_system *a, const saltus_system *b) {
    bool same = same_field(a, b) && a->dof == b->dof && a->extra == b->extra &&
                a->face_count == b->face_count && a->spec.stop_count == b->spec.stop_count;
    for (int f = 0; same && f < a->face_count; f++)
        same = a->faces[f].stop == b->faces[f].stop && a->faces[f].side == b->faces[f].side;
    return same;
}

/* Whether a flow uses collocation, which runs one trajectory at a time. Where several could run side by side,
 * series remain faster up to a higher stiffness, the more so the less of a pack one of them fills. */
static bool collocates(const saltus_system *system, int lanes, saltus_integrator integrator) {
    const double gain = lanes > 1 ? fmax(1, fmin(3, 18.0 / system->dof)) : 1;
    return integrator == SALTUS_AUTOMATIC ? system->stiffness_ratio > gain : integrator != SALTUS_TAYLOR;
}

static saltus_status check_options(const saltus_flow_options *o, saltus_message *message) {
    saltus_status status = saltus_options_check(&saltus_flow_table, o, message);
    if (status != SALTUS_OK)
        return status;
    if (o->columns < 0 || o->columns > 256)
        return saltus_fail(message, SALTUS_BAD_INPUT, "columns = %d: must be from 0 to 256", o->columns);
    if (o->directions < 0 || o->directions > SALTUS_DIRECTIONS_MAX || o->directions > o->columns)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "directions = %d: must be from 0 to %d, and no more than columns = %d",
                           o->directions, SALTUS_DIRECTIONS_MAX, o->columns);
    return SALTUS_OK;
}

static saltus_status check_lanes(const saltus_system *const *systems, int lanes, int most, bool stiff,
                                 const saltus_flow_options *options, saltus_message *message) {
    if (lanes < 1 || lanes > most || (stiff && lanes > 1))
        return saltus_fail(message, SALTUS_BAD_INPUT, "lanes = %d: must be from 1 to %d (%s)", lanes,
                           stiff ? 1 : most,
                           stiff ? "the stiff integrator runs one trajectory at a time"
                                 : "what this processor's vectors hold");
    if (lanes > 1 && options->directions)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "directions = %d: parameter columns need a flow of one lane", options->directions);
    for (int l = 1; l < lanes; l++)
        if (!same_shape(systems[0], systems[l]) ||
            systems[0]->coefficients.terms != systems[l]->coefficients.terms)
            return saltus_fail(
                message, SALTUS_BAD_INPUT,
                "systems side by side must have the same model, size, terms and kind of stops");
    return SALTUS_OK;
}

static void reserve(saltus_flow *flow) {
    saltus_arena *arena = &flow->arena;
    const size_t maps = SALTUS_FACES_MAX * (size_t)flow->dof, dimension = (size_t)flow->dimension,
                 columns = (size_t)flow->options.columns;
    flow->state = saltus_arena_doubles(arena, dimension);
    flow->tangents = saltus_arena_doubles(arena, dimension * columns);
    flow->before = saltus_arena_doubles(arena, dimension);
    flow->after = saltus_arena_doubles(arena, dimension);
    flow->trial = saltus_arena_doubles(arena, dimension);
    flow->scratch.push = saltus_arena_doubles(arena, maps);
    flow->scratch.pull = saltus_arena_doubles(arena, maps);
    flow->scratch.change_rows = saltus_arena_doubles(arena, maps);
    for (int l = 0; l < flow->lanes; l++) {
        flow->lane[l].hold.push = saltus_arena_doubles(arena, maps);
        flow->lane[l].hold.pull = saltus_arena_doubles(arena, maps);
        flow->lane[l].delay = saltus_arena_doubles(arena, columns);
    }
    for (int d = 0; d < flow->options.directions; d++)
        saltus_variation_reserve(&flow->parameter[d].variation, flow->lane[0].system, arena);
}

/* Load a system and, behind the stops' rows, one for the observed displacement, which need not be a stop's
 * coordinate. */
static void load_system(saltus_work *work, const saltus_kernel *kernel, int lane, const saltus_system *system,
                        int degree, saltus_damping damping) {
    const int rows = work->stops;
    work->stops = system->spec.stop_count;
    kernel->load(work, lane, system, degree, damping);
    work->stops = rows;
    double *row = work->loaded.normal + system->spec.stop_count * work->row;
    for (int i = 0; i < system->dof; i++)
        row[i * work->lanes + lane] = system->observer.row[i];
}

/* The order of series that accuracy alone asks for. */
static int usual_order(const saltus_flow_options *o) {
    return o->order ? o->order : order_by_tolerance(-log10(o->rtol));
}

/* Load a lane's system into the stepping work and into the lane's work for single points. */
static void load_lane(saltus_flow *flow, int lane) {
    saltus_eigenvalues eigenvalues = {.count = 0};
    const saltus_flow_options *o = &flow->options;
    const bool collocated = o->integrator == SALTUS_RADAU;
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    if (!collocated)
        saltus_system_eigenvalues(system, &eigenvalues);
    const int steady = collocated ? SALTUS_RADAU_DEGREE
                       : o->order ? o->order
                                  : degree_for(system, &eigenvalues, o->rtol),
              degree = flow->transients && !collocated ? usual_order(o) : steady;
    self->degree = degree;
    /* A requested order is that of every step. */
    self->brief = o->order ? -1 : saltus_flow_brief(system, degree, o->rtol);
    const saltus_damping damping = saltus_system_damping(system, &eigenvalues, degree);
    self->first = (saltus_pace){degree, damping.plain};
    if (flow->radau && !collocated)
        flow->mixture.worth = SALTUS_STIFF_COST * self->first.limit;
    load_system(&flow->work, flow->kernel, lane, system, degree, damping);
    self->later = steady == degree
                      ? self->first
                      : (saltus_pace){steady, saltus_system_step_limit(system, &eigenvalues, steady)};
    self->settled = false;
    load_system(&flow->probe[lane], flow->narrow, 0, system, SALTUS_ORDER_MIN,
                saltus_system_damping(system, &eigenvalues, SALTUS_ORDER_MIN));
}

static saltus_status open_works(saltus_flow *flow, bool stiff) {
    const saltus_system *first = flow->lane[0].system;
    const saltus_flow_options *o = &flow->options;
    const saltus_tolerance tolerance = {o->rtol, o->atol, fmax(o->rtol, 1e-13)};
    const int series = o->integrator == SALTUS_RADAU ? 0 : usual_order(o);
    const int order = stiff && series < SALTUS_RADAU_DEGREE ? SALTUS_RADAU_DEGREE : series;
    saltus_status status =
        saltus_work_open(&flow->work, flow->kernel, first, order, o->columns, o->directions, tolerance);
    for (int l = 0; l < flow->lanes && status == SALTUS_OK; l++)
        status = saltus_work_open(&flow->probe[l], flow->narrow, first, SALTUS_ORDER_MIN, 0, 0, tolerance);
    if (status == SALTUS_OK && stiff)
        status = saltus_radau_open(&flow->radau, first, o->columns, o->directions, tolerance);
    for (int l = 0; l < flow->lanes && status == SALTUS_OK; l++)
        load_lane(flow, l);
    if (status == SALTUS_OK && !stiff)
        flow->fixed = saltus_fixed_open(flow->kernel, first, &flow->work);
    return status;
}

saltus_status saltus_flow_new(const saltus_system *const *systems, int lanes,
                              const saltus_flow_options *options, saltus_flow **flow,
                              saltus_message *message) {
    *flow = NULL;
    const saltus_system *first = systems[0];
    const saltus_kernel *narrow = saltus_kernel_find(first->spec.model->kernel, 1);
    const saltus_kernel *kernel = lanes == 1 ? narrow : saltus_kernel_find(first->spec.model->kernel, 0);
    const bool stiff = collocates(first, lanes, options->integrator);
    saltus_status status = saltus_kernel_check(message);
    if (status == SALTUS_OK)
        status = check_options(options, message);
    if (status == SALTUS_OK)
        status = check_lanes(systems, lanes, kernel->lanes, stiff, options, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow *made = calloc(1, sizeof *made);
    saltus_lane *lane = calloc((size_t)kernel->lanes, sizeof *lane);
    saltus_work *probe = calloc((size_t)kernel->lanes, sizeof *probe);
    if (!made || !lane || !probe) {
        free(made);
        free(lane);
        free(probe);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the flow");
    }
    *made = (saltus_flow){.options = *options,
                          .kernel = kernel,
                          .narrow = narrow,
                          .lanes = kernel->lanes,
                          .dimension = first->dimension,
                          .dof = first->dof,
                          .extra = first->extra,
                          .lane = lane,
                          .probe = probe,
                          .period_steps_max = steps_usual(options)};
    /* Lanes beyond the requested ones rest with the first lane's system. */
    for (int l = 0; l < made->lanes; l++)
        lane[l].system = systems[l < lanes ? l : 0];
    reserve(made);
    status = saltus_arena_open(&made->arena) ? SALTUS_OK : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK) {
        reserve(made);
        status = open_works(made, stiff);
    }
    if (status != SALTUS_OK) {
        saltus_flow_free(made);
        return saltus_fail(message, status, "no memory for the flow");
    }
    *flow = made;
    return SALTUS_OK;
}

saltus_status saltus_flow_single(const saltus_system *system, int columns, const saltus_flow_options *options,
                                 saltus_flow **flow, saltus_message *message) {
    saltus_flow_options own = *options;
    own.columns = columns;
    own.directions = 0;
    return saltus_flow_new(&system, 1, &own, flow, message);
}

/* Load the lane's system and the directions into all works anew. */
static void reload(saltus_flow *flow, int lane) {
    saltus_quiet_end(flow, lane);
    saltus_quiet_break(flow, lane);
    if (flow->lanes == 1)
        saltus_work_forget(&flow->work);
    saltus_work_forget(&flow->probe[lane]);
    load_lane(flow, lane);
    if (flow->radau)
        saltus_radau_retune(flow->radau, flow->lane[lane].system);
    saltus_directions_load(flow);
    saltus_contacts_publish(flow, lane);
}

void saltus_flow_set_directions(saltus_flow *flow, const saltus_direction *directions) {
    for (int d = 0; d < flow->options.directions; d++)
        flow->parameter[d].direction = directions[d];
    if (flow->options.directions)
        reload(flow, 0);
}

void saltus_flow_limit_steps(saltus_flow *flow, double per_period) {
    flow->quiet = 0;
    flow->period_steps_max = per_period > 0 ? per_period : steps_usual(&flow->options);
}

void saltus_flow_expect_transients(saltus_flow *flow) {
    flow->transients = true;
    for (int l = 0; l < flow->lanes; l++)
        reload(flow, l);
}

saltus_status saltus_flow_retune(saltus_flow *flow, int lane, const saltus_system *system,
                                 saltus_message *message) {
    saltus_lane *self = &flow->lane[lane];
    if (!same_shape(self->system, system))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "a flow can be given a system of the same model, size and kind of stops only");
    if (flow->lanes > 1 && self->system->coefficients.terms != system->coefficients.terms)
        return saltus_fail(message, SALTUS_BAD_INPUT, "systems side by side must have the same terms");
    self->system = system;
    self->hold.faces = 0;
    self->hold.count = 0;
    reload(flow, lane);
    return SALTUS_OK;
}

void saltus_flow_free(saltus_flow *flow) {
    if (!flow)
        return;
    for (int l = 0; l < flow->lanes; l++)
        saltus_work_close(&flow->probe[l]);
    saltus_work_close(&flow->work);
    saltus_fixed_close(&flow->fixed);
    saltus_radau_close(flow->radau);
    saltus_arena_close(&flow->arena);
    free(flow->lane);
    free(flow->probe);
    free(flow);
}

/* One trajectory of many modes fills the packs too, and does not leave the cache: of 16 modes it is faster
 * than lanes by a third, of 24 twice as fast. So are a few trajectories of fewer modes one after the other,
 * whose rows together take fewer packs than one for each mode: two of 5 modes take three quarters of the time
 * of two lanes. Text is interpreted, or compiled, once for all lanes. */
int saltus_flow_width(const saltus_system *system, saltus_integrator integrator, long long trajectories) {
    enum { many = 14 };
    static const double worth = 0.8; /* of the packs of a row in lanes */
    const int all = saltus_kernel_find(system->spec.model->kernel, 0)->lanes, n = system->dof;
    const bool few = (double)trajectories * ((n + all - 1) / all) < worth * n;
    const bool alone = trajectories < 2 || (!system->tape && (n > many || few));
    const int width = alone ? 1 : all;
    return collocates(system, width, integrator) ? 1 : width;
}

bool saltus_flow_restarts_in_series(const saltus_system *system, saltus_integrator integrator) {
    return integrator == SALTUS_AUTOMATIC && 3 * system->stiffness_ratio <= system->dof;
}
