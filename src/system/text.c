/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/text.h"

#include "system/lasting.h"
#include "system/system.h"
#include "system/text_build.h"

#include <math.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A model made from text. The graphs for all whole-number parameters used so far are in a list that only
 * grows, so that several threads may build systems. */
typedef struct text_model {
    saltus_model model; /* must be the first member: the library sees only this */
    atomic_int owners;
    saltus_parsed_text text;
    saltus_list owned; /* void *: arrays used here and in `text` */
    char *source;
    int *parameter_line;
    _Atomic(saltus_equations_graph *) graphs;
} text_model;

static const text_model *of_model(const saltus_model *model) {
    return (const text_model *)(const void *)model;
}

/* The graph for a specification, or NULL if it has not been built. */
static const saltus_equations_graph *graph_of(const saltus_spec *spec) {
    const text_model *m = of_model(spec->model);
    const saltus_equations_graph *g = atomic_load_explicit(&m->graphs, memory_order_acquire);
    for (bool same = false; g && !same; g = same ? g : g->next) {
        same = true;
        for (int k = 0; same && k < m->text.parameter_count; k++)
            same = !m->text.parameters[k].integer || g->parameters[k] == spec->parameters[k];
    }
    return g;
}

static saltus_status shape(const saltus_spec *spec, int *dof, int *extra, saltus_message *message) {
    text_model *m = (text_model *)(void *)(uintptr_t)spec->model;
    const saltus_equations_graph *g = graph_of(spec);
    if (!g) {
        saltus_equations_graph *made, *first = atomic_load(&m->graphs);
        saltus_status status = saltus_equations_graph_new(&m->text, spec->parameters, &made, message);
        if (status != SALTUS_OK)
            return status;
        /* Another thread may have built the same graph meanwhile; duplicates do no harm. */
        do
            made->next = first;
        while (!atomic_compare_exchange_weak(&m->graphs, &first, made));
        g = made;
    }
    *dof = g->dof;
    *extra = g->extra;
    return SALTUS_OK;
}

/* Evaluate all nodes of a graph for a specification, at a state (NULL: zero) and a phase. */
static void evaluate(const saltus_equations_graph *g, const saltus_spec *spec, const double *state,
                     double phase, double *values) {
    static const double zero[SALTUS_STATE_MAX];
    double period = 1;
    if (spec->model->forcing >= 0)
        period = 2 * M_PI / spec->parameters[spec->model->forcing];
    saltus_graph_evaluate(&g->graph, spec->parameters, state ? state : zero, phase * period, phase, values);
}

/* The same in memory that the caller frees; NULL: there is none. */
static double *values_at(const saltus_equations_graph *g, const saltus_spec *spec, const double *state,
                         double phase) {
    double *values = malloc((size_t)g->graph.count * sizeof *values);
    if (values)
        evaluate(g, spec, state, phase, values);
    return values;
}

/* Set clearances and restitutions that are expressions. */
static void complete(saltus_spec *spec) {
    const saltus_equations_graph *g = graph_of(spec);
    double *values = g ? values_at(g, spec, NULL, 0) : NULL;
    for (int s = 0; values && s < spec->stop_count && s < g->stop_count; s++) {
        if (g->stops[s].clearance >= 0)
            spec->stops[s].d = values[g->stops[s].clearance];
        if (g->stops[s].restitution >= 0)
            spec->stops[s].r = values[g->stops[s].restitution];
    }
    free(values);
}

static void normal(const saltus_spec *spec, int dof, const saltus_stop *stop, double *n) {
    const saltus_equations_graph *g = graph_of(spec);
    const int s = (int)(stop - spec->stops);
    double *values = values_at(g, spec, NULL, 0);
    for (int i = 0; i < dof; i++)
        n[i] = !values ? NAN : s < g->stop_count ? values[g->stops[s].normal[i]] : 0;
    free(values);
}

static void reserve(saltus_system *system) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    saltus_coefficients *c = &system->coefficients;
    c->slots = g->tape->slot_count;
    c->slot = saltus_arena_doubles(&system->arena, (size_t)c->slots);
    system->numbers = saltus_arena_doubles(&system->arena, (size_t)g->graph.count);
}

/* A typical length of displacements: the smallest clearance, else the first nonzero initial displacement,
 * else 1. */
static double typical_length(const saltus_system *system, const saltus_equations_graph *g) {
    enum { phases = 4 };
    bool between;
    double length = saltus_least_clearance(system, &between);
    /* A clearance that is tiny beside the initial displacement is not typical. */
    double begin = 0;
    for (int i = 0; i < system->dof && begin == 0; i++)
        if (g->state[i].initial >= 0)
            begin = fabs(system->numbers[g->state[i].initial]);
    if (length < SALTUS_NO_CLEARANCE * begin)
        length = begin;
    /* Nor is one far below what the forcing moves, but between two sides; nor one far beyond both. The
     * response to the forcing alone is the greatest acceleration at rest, over the square of the angular
     * frequency. */
    double response = 0;
    for (int k = 0; k < phases && g->forced && length > 0; k++) {
        double *values = values_at(g, &system->spec, NULL, (double)k / phases);
        for (int i = 0; i < system->dof && values; i++)
            response = fmax(response, fabs(values[g->field[i]]));
        free(values);
    }
    response /= g->forced ? system->omega * system->omega : 1;
    response = isfinite(response) ? response : 0;
    const double moved = fmax(begin, response);
    if (!between && begin == 0 && length < 1e-6 * response)
        length = 0;
    if (moved > 0 && length > 1e5 * moved)
        length = moved;
    return length > 0 && isfinite(length) ? length : 1;
}

/* The field at a state: accelerations, then rates, in the order of the tape's outputs. */
static void field_at(const saltus_system *system, const saltus_equations_graph *g, const double *state,
                     double phase, double *values, double *field) {
    evaluate(g, &system->spec, state, phase, values);
    for (int i = 0; i < system->dof + system->extra; i++)
        field[i] = values[g->field[i]];
}

/* Measure the linear part at the reference state by differences: its diagonal for the stiff integrator,
 * bounds on its eigenvalues (rows of the first-order form) and decay rates, scales of velocities. How
 * strongly an extra state pulls at accelerations counts by the rate of the loops that this reply closes with
 * its dependence on displacements and velocities, which moved and drag it; the rate of a loop does not depend
 * on the scales, while beside a small clearance any pull would look stiff. */
static void measure_rates(saltus_system *system, const saltus_equations_graph *g, const double *reference,
                          double *values) {
    const int n = system->dof, all = n + system->extra, dimension = system->dimension;
    double state[SALTUS_STATE_MAX], above[SALTUS_STATE_MAX], below[SALTUS_STATE_MAX], loops = 0;
    double pull[SALTUS_STATE_MAX] = {0}, drag[SALTUS_STATE_MAX] = {0}, decay = 0, stiffness = 0, damping = 0;
    double reply[SALTUS_STATE_MAX] = {0}, moved[SALTUS_STATE_MAX] = {0}, dragged[SALTUS_STATE_MAX] = {0};
    memcpy(state, reference, (size_t)dimension * sizeof *state);
    for (int j = 0; j < dimension; j++) {
        const double h = 1e-5 * system->scale[j];
        state[j] = reference[j] + h;
        field_at(system, g, state, 0.13, values, above);
        state[j] = reference[j] - h;
        field_at(system, g, state, 0.13, values, below);
        state[j] = reference[j];
        for (int i = 0; i < all; i++) {
            double slope = (above[i] - below[i]) / (2 * h);
            if (!isfinite(slope))
                continue;
            if (system->linear)
                system->linear[i * dimension + j] = slope;
            if (j < n)
                pull[i] += fabs(slope);
            else if (j < 2 * n || i >= n)
                drag[i] += fabs(slope);
            else
                reply[j - 2 * n] = fmax(reply[j - 2 * n], fabs(slope));
            if (i >= n && j < n)
                moved[i - n] = fmax(moved[i - n], fabs(slope));
            else if (i >= n && j < 2 * n)
                dragged[i - n] = fmax(dragged[i - n], fabs(slope));
            if (i < n && j == i)
                system->stiffness[i] = fmax(-slope, 0);
            if (i < n && j == n + i)
                system->damping[i] = fmax(-slope, 0);
            if (j == n + i)
                decay = fmax(decay, -slope);
        }
    }
    for (int i = 0; i < all; i++) {
        stiffness = fmax(stiffness, i < n ? pull[i] : 0);
        damping = fmax(damping, drag[i]);
    }
    for (int k = 0; k < system->extra; k++)
        loops = fmax(loops, cbrt(reply[k] * moved[k]) + sqrt(reply[k] * dragged[k]));
    damping += loops;
    /* Without forcing, all forces on a displacement show how fast it is: feedback may hide its own
     * stiffness. */
    for (int i = 0; i < n; i++)
        if (g->state[n + i].scale < 0)
            system->scale[n + i] =
                system->scale[i] * (g->forced ? fmax(system->omega, fmax(sqrt(system->stiffness[i]), 1e-3))
                                    : pull[i] > 0 ? sqrt(pull[i])
                                                  : 1);
    system->decay = decay;
    system->rate = fmax(fmax(sqrt(stiffness), damping), g->forced ? system->omega : 1e-3);
    /* The jumps of a relaxation oscillation are as fast as its stiffness, however slow it is between them. */
    double lasting = g->forced ? system->omega : sqrt(stiffness);
    for (int i = 0; i < n && g->forced; i++)
        lasting = fmax(lasting, saltus_lasting_rate(pull[i], drag[i]));
    system->stiffness_ratio = damping / (200 * lasting);
}

/* Whether f(-x, t + T/2) = -f(x, t) or, if not `shift`, f(-x, t) = -f(x, t), tested at generic points. */
static bool is_odd(const saltus_system *system, const saltus_equations_graph *g, bool shift, double *values) {
    enum { points = 4 };
    double state[SALTUS_STATE_MAX], here[SALTUS_STATE_MAX], there[SALTUS_STATE_MAX];
    for (int k = 0; k < points; k++) {
        const double phase = fmod(0.137 + 0.381966 * k, 1);
        for (int i = 0; i < system->dimension; i++)
            state[i] = system->scale[i] * sin(1.7 * k + 2.3 * i + 0.4);
        field_at(system, g, state, phase, values, here);
        for (int i = 0; i < system->dimension; i++)
            state[i] = -state[i];
        field_at(system, g, state, fmod(phase + (shift ? 0.5 : 0), 1), values, there);
        double size = 0, sum = 0;
        for (int i = 0; i < system->dof + system->extra; i++) {
            size = fmax(size, fabs(here[i]) + fabs(there[i]));
            sum = fmax(sum, fabs(here[i] + there[i]));
        }
        if (!(sum <= 1e-11 * size))
            return false;
    }
    return true;
}

/* The text of a stop's coordinate (0), clearance (1) or restitution (2). */
static const char *coordinate(const saltus_model *model, int stop, int which) {
    const saltus_parsed_text *t = &of_model(model)->text;
    const saltus_parsed_list *const lists[] = {&t->coordinates, &t->clearances, &t->restitutions};
    return stop < lists[which]->count ? lists[which]->items[stop].text : NULL;
}

/* The row of an observed quantity. A test at a generic state confirms that it is a sum of displacements. */
static bool observable_row(const saltus_system *system, int k, double *row) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    const saltus_observed_nodes *observed = &g->observed[k];
    double state[SALTUS_STATE_MAX] = {0}, *values = system->numbers, expected = 0;
    if (!observed->sum)
        return false;
    const double rest = values[observed->node];
    for (int i = 0; i < system->dimension; i++)
        state[i] = sin(1.0 + i);
    for (int i = 0; i < system->dof; i++) {
        row[i] = values[observed->row[i]];
        expected += row[i] * state[i];
    }
    evaluate(g, &system->spec, state, 0.37, values);
    double error = fabs(values[observed->node] - expected);
    evaluate(g, &system->spec, NULL, 0, values);
    return rest == 0 && error <= 1e-12 * fabs(expected);
}

static void build(saltus_system *system) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    const saltus_tape *tape = g->tape;
    const int n = system->dof;
    double reference[SALTUS_STATE_MAX] = {0}, *values = system->numbers;
    system->tape = tape;
    system->forced = g->forced;
    system->guarded = g->partial.root_count > 0;
    system->coefficients.scalar[0] = system->omega;
    system->coefficients.terms =
        (g->forced ? SALTUS_TERM_FORCED : 0) | (system->extra ? SALTUS_TERM_EXTRA : 0);
    evaluate(g, &system->spec, NULL, 0, values);
    for (int s = 0; s < system->spec.stop_count && s < g->stop_count; s++)
        system->offset[s] = values[g->stops[s].offset];
    const double length = typical_length(system, g);
    for (int i = 0; i < system->dimension; i++) {
        if (g->state[i].initial >= 0)
            reference[i] = values[g->state[i].initial];
        double own = g->state[i].scale >= 0 ? fabs(values[g->state[i].scale])
                     : i < 2 * n            ? length
                                            : fabs(reference[i]);
        system->scale[i] = own > 0 && isfinite(own) ? own : 1;
    }
    for (int i = 0; i < n * n; i++)
        system->inverse_mass[i] = values[g->inverse_mass[i]];
    measure_rates(system, g, reference, values);
    system->mirror_shift = g->forced;
    system->mirror = is_odd(system, g, g->forced, values);
    evaluate(g, &system->spec, NULL, 0, values);
    for (int s = 0; s < tape->slot_count; s++)
        system->coefficients.slot[s] = values[tape->slot_node[s]];
}

/* The derivative of a node of parameters (and speed) along a direction, at a closing speed; 0 for node -1. */
static double varied(const saltus_system *system, const saltus_equations_graph *g,
                     const saltus_direction *direction, int node, double speed) {
    double sum = 0;
    for (int p = 0; p < system->spec.model->parameter_count && node >= 0; p++)
        if (g->derivatives[p] && direction->parameter[p] != 0)
            sum += direction->parameter[p] *
                   saltus_graph_at_speed(&g->graph, g->derivatives[p][node], system->numbers, speed);
    return sum;
}

static void vary(const saltus_system *system, const saltus_direction *direction,
                 saltus_variation *variation) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    const int n = system->dof;
    variation->coefficients.terms = system->coefficients.terms;
    if (system->spec.model->forcing >= 0)
        variation->coefficients.scalar[0] = direction->parameter[system->spec.model->forcing];
    for (int s = 0; s < g->tape->slot_count; s++)
        variation->coefficients.slot[s] = varied(system, g, direction, g->tape->slot_node[s], 0);
    for (int i = 0; i < n * n; i++)
        variation->inverse_mass[i] = varied(system, g, direction, g->inverse_mass[i], 0);
    for (int s = 0; s < system->spec.stop_count; s++) {
        const saltus_stop_nodes *stop = &g->stops[s];
        variation->d[s] += varied(system, g, direction, stop->clearance, 0);
        variation->r[s] += varied(system, g, direction, stop->restitution, 0);
        variation->offset[s] += varied(system, g, direction, stop->offset, 0);
        for (int i = 0; i < n; i++)
            variation->normal[s][i] += varied(system, g, direction, stop->normal[i], 0);
    }
    for (int i = 0; i < n && system->observer.quantity >= 0; i++)
        variation->observer[i] =
            varied(system, g, direction, g->observed[system->observer.quantity].row[i], 0);
}

static bool by_speed(const saltus_spec *spec, int stop) {
    const saltus_equations_graph *g = graph_of(spec);
    return g && stop < g->stop_count && g->stops[stop].rebound >= 0;
}

static saltus_rebound rebound(const saltus_system *system, int stop, double speed) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    const saltus_stop_nodes *own = &g->stops[stop];
    return (saltus_rebound){saltus_graph_at_speed(&g->graph, own->restitution, system->numbers, speed),
                            saltus_graph_at_speed(&g->graph, own->rebound, system->numbers, speed)};
}

static double rebound_change(const saltus_system *system, int stop, double speed,
                             const saltus_direction *direction) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    return varied(system, g, direction, g->stops[stop].restitution, speed);
}

/* Graphs of up to this many nodes are evaluated without allocating memory. */
enum { common = 400 };

/* Evaluate a part's nodes, in `room` if it suffices, else in memory that the caller frees; NULL: no
 * memory. */
static double *evaluate_part(const saltus_system *system, const saltus_graph_part *part, const double *state,
                             double phase, double room[common]) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    double *values = g->graph.count <= common ? room : malloc((size_t)g->graph.count * sizeof *values);
    if (values)
        saltus_graph_evaluate_some(&g->graph, part->nodes, part->count, system->spec.parameters, state,
                                   phase * system->period, phase, values);
    return values;
}

/* The value of a part with one root; NAN if there is no memory. */
static double value_of_part(const saltus_system *system, const saltus_graph_part *part, const double *state,
                            double phase) {
    double room[common], *values = evaluate_part(system, part, state, phase, room),
                         value = values ? values[part->roots[0]] : NAN;
    if (values != room)
        free(values);
    return value;
}

/* If the trace depends on parameters alone, it was evaluated when the system was built. */
static double trace(const saltus_system *system, const double *state, double phase) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    const int node = g->trace.roots[0];
    return g->graph.nodes[node].depends & ~(unsigned)SALTUS_OF_PARAMETERS
               ? value_of_part(system, &g->trace, state, phase)
               : system->numbers[node];
}

static double crossing(const saltus_system *system, const double *state) {
    return value_of_part(system, &graph_of(&system->spec)->zero, state, 0);
}

static void start(const saltus_system *system, double *state) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    for (int i = 0; i < system->dimension; i++)
        if (g->state[i].initial >= 0)
            state[i] = system->numbers[g->state[i].initial];
}

static saltus_state_name state_name(const saltus_spec *spec, int dof, int entry) {
    const saltus_equations_graph *g = graph_of(spec);
    bool rate = entry >= dof && entry < 2 * dof;
    saltus_state_name name;
    snprintf(name.text, sizeof name.text, "%s%s", g->names[entry < dof ? entry : entry - dof],
             rate ? "'" : "");
    return name;
}

/* A node as text, in the names of the scene; NULL if there is no memory. */
static char *node_text(const saltus_system *system, int node) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    saltus_state_name *names = malloc((size_t)system->dimension * sizeof *names + 1);
    for (int i = 0; names && i < system->dimension; i++)
        names[i] = state_name(&system->spec, system->dof, i);
    char *text = names ? saltus_graph_text(&g->graph, node, system->spec.model->parameters, names) : NULL;
    free(names);
    return text;
}

static char *right_side(const saltus_system *system, int entry) {
    return node_text(system, graph_of(&system->spec)->field[entry]);
}

static const char *observable(const saltus_model *model, int k) {
    const saltus_parsed_list *list = &of_model(model)->text.observe;
    return k < list->count ? list->items[k].name : NULL;
}

static void observe(const saltus_system *system, const double *state, double phase, double *values) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    double *all = values_at(g, &system->spec, state, phase);
    for (int k = 0; k < g->observed_count; k++)
        values[k] = all ? all[g->observed[k].node] : NAN;
    free(all);
}

static bool defined(const saltus_system *system, const double *state, double phase) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    double room[common], *values = evaluate_part(system, &g->partial, state, phase, room);
    bool good = values != NULL;
    for (int k = 0; k < g->partial.root_count && good; k++)
        good = isfinite(values[g->partial.roots[k]]);
    /* The term without a value may belong to a branch that is not taken. */
    if (values && !good) {
        evaluate(g, &system->spec, state, phase, values);
        good = true;
        for (int i = 0; i < system->dof + system->extra && good; i++)
            good = isfinite(values[g->field[i]]);
    }
    if (values != room)
        free(values);
    return good;
}

static bool fault(const saltus_system *system, const double *state, double phase, saltus_message *what) {
    const saltus_equations_graph *g = graph_of(&system->spec);
    const int count = system->dof + system->extra;
    double *values = values_at(g, &system->spec, state, phase);
    int operand = -1, node = -1;
    if (values)
        node = saltus_graph_fault(&g->graph, g->field, count, values, system->scale, &operand);
    char *whole = node < 0 ? NULL : node_text(system, node),
         *part = node < 0 ? NULL : node_text(system, operand);
    const bool found = whole && part;
    if (found)
        snprintf(what->text, sizeof what->text, "%.200s has %s value where %.100s = %.6g", whole,
                 isfinite(values[node]) ? "hardly a" : "no", part, values[operand]);
    free(whole);
    free(part);
    free(values);
    return found;
}

/* Copy bytes into memory that lives as long as the model; NULL, with *whole set to false, if there is
 * none. */
static void *copied(text_model *m, const void *bytes, size_t size, bool *whole) {
    void *copy = saltus_text_keep(&m->owned, size, 1);
    if (copy && size)
        memcpy(copy, bytes, size);
    *whole = *whole && copy;
    return copy;
}

/* The same for a string; NULL stays NULL. */
static char *copied_text(text_model *m, const char *text, bool *whole) {
    return text ? copied(m, text, strlen(text), whole) : NULL;
}

static saltus_status no_memory(saltus_message *message) {
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the equations");
}

static saltus_status place_failure(const char *origin, const char *name, int line, const char *sentence,
                                   saltus_message *message) {
    return saltus_fail(message, SALTUS_BAD_INPUT, "%s:%d: %s: %s", origin, line, name, sentence);
}

/* Parse a left side: "x", "x[i]", "x[2]", or the names of a matrix entry, "x1,x2", which stay together.
 * Returns what is wrong with it, or NULL. */
static const char *parse_left(const char *name, saltus_parsed *p) {
    const char *open = strchr(name, '[');
    size_t length = open ? (size_t)(open - name) : strlen(name);
    if (strchr(name, ','))
        return NULL;
    if (strchr(name, '\''))
        return "a left side has no prime: the acceleration of x stands under x, the rate of a state p under "
               "p";
    if (length == 0 || length >= sizeof p->base)
        return "a name must have 1 to 31 characters";
    memcpy(p->base, name, length);
    if (!open)
        return NULL;
    char *end;
    size_t inside = strcspn(open + 1, "]");
    if (open[1 + inside] != ']' || open[2 + inside] || inside == 0 || inside >= sizeof p->index)
        return "must be a name, or a name with one index such as x[i] or x[1]";
    memcpy(p->index, open + 1, inside);
    long number = strtol(p->index, &end, 10);
    if (*end)
        return NULL;
    p->index[0] = '\0';
    p->number = (int)number;
    return number < 1 || number > 100000 ? "indices begin at 1" : NULL;
}

/* The entries of scale and initial go by the names of displacements, velocities and states, which are matched
 * as a whole (`by_state`). */
static saltus_status parse_equation(text_model *m, const char *origin, const saltus_equation *e,
                                    bool by_state, saltus_parsed *p, saltus_message *message) {
    saltus_message reason = {.text = ""};
    bool whole = true;
    p->name = copied_text(m, e->name, &whole);
    p->text = copied_text(m, e->text, &whole);
    p->origin = origin;
    p->line = e->line;
    p->right.root = -1;
    if (!whole)
        return no_memory(message);
    if (!p->text)
        return SALTUS_OK;
    const char *wrong = by_state ? NULL : parse_left(p->name, p);
    if (wrong)
        return place_failure(origin, e->name, e->line, wrong, message);
    saltus_status status = saltus_expression_parse(p->text, &p->right, &reason);
    return status == SALTUS_BAD_INPUT ? place_failure(origin, e->name, e->line, reason.text, message)
           : status != SALTUS_OK      ? saltus_fail(message, status, "%s", reason.text)
                                      : SALTUS_OK;
}

/* Copy parameters and constants. */
static saltus_status copy_numbers(text_model *m, const saltus_text *text, saltus_message *message) {
    saltus_parsed_text *to = &m->text;
    bool whole = true;
    m->parameter_line = saltus_text_keep(&m->owned, (size_t)text->parameter_count, sizeof *m->parameter_line);
    to->parameters = saltus_text_keep(&m->owned, (size_t)text->parameter_count, sizeof *to->parameters);
    to->constants = saltus_text_keep(&m->owned, (size_t)text->constant_count, sizeof *to->constants);
    to->origin = copied_text(m, text->origin, &whole);
    to->scene = copied_text(m, text->scene ? text->scene : text->origin, &whole);
    to->forcing = copied_text(m, text->forcing.text, &whole);
    m->source = copied_text(m, text->source ? text->source : "", &whole);
    whole = whole && to->parameters && to->constants && m->parameter_line;
    for (; whole && to->parameter_count < text->parameter_count; to->parameter_count++) {
        const saltus_text_parameter *p = &text->parameters[to->parameter_count];
        m->parameter_line[to->parameter_count] = p->line;
        to->parameters[to->parameter_count] =
            (saltus_parameter){.name = copied_text(m, p->name, &whole),
                               .integer = p->integer,
                               .fallback = p->fallback,
                               .min = p->min,
                               .max = p->max,
                               .meaning = copied_text(m, p->meaning ? p->meaning : "", &whole)};
    }
    for (; whole && to->constant_count < text->constant_count; to->constant_count++) {
        saltus_text_constant c = text->constants[to->constant_count];
        size_t count = (size_t)(c.rows ? c.rows : 1) * (size_t)(c.columns ? c.columns : 1);
        c.name = copied_text(m, c.name, &whole);
        c.values = copied(m, c.values, count * sizeof *c.values, &whole);
        to->constants[to->constant_count] = c;
    }
    return whole ? SALTUS_OK : no_memory(message);
}

static void own(const saltus_model *model, int change) {
    text_model *m = (text_model *)(void *)(uintptr_t)model;
    saltus_parsed_text *t = &m->text;
    if (atomic_fetch_add(&m->owners, change) + change > 0)
        return;
    for (size_t l = 0; l < sizeof t->lists / sizeof t->lists[0]; l++)
        for (int k = 0; k < t->lists[l].count; k++)
            saltus_expression_clear(&t->lists[l].items[k].right);
    saltus_text_release(&m->owned);
    for (saltus_equations_graph *g = atomic_load(&m->graphs), *next; g; g = next) {
        next = g->next;
        saltus_equations_graph_free(g);
    }
    free(m);
}

/* Whether a name is reserved, such as t, sin or, also with a number, d. */
static bool is_reserved(const char *name) {
    static const char *const words[] = {"t", "phase", "pi", "speed", "observe"}, *const numbered[] = {
                                                                                     "d", "r", "xi", "sides"};
    int number;
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        if (strcmp(name, words[k]) == 0)
            return true;
    for (size_t k = 0; k < sizeof numbered / sizeof numbered[0]; k++)
        if (saltus_key_numbered(name, numbered[k], &number))
            return true;
    for (int k = 0; k < SALTUS_FUNCTION_COUNT; k++)
        if (strcmp(name, saltus_function_name((saltus_function)k)) == 0)
            return true;
    return false;
}

/* A declared name, what it is, and its line. */
typedef struct declared {
    const char *name, *what;
    int line;
} declared;

static int by_name(const void *a, const void *b) {
    const declared *p = a, *q = b;
    int order = strcmp(p->name, q->name);
    return order ? order : p->line - q->line;
}

/* Check that every name is well-formed, not reserved and declared once. */
static saltus_status check_names(const text_model *m, saltus_message *message) {
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
    const saltus_parsed_text *t = &m->text;
    const struct {
        const saltus_parsed_list *list;
        const char *what;
    } lists[] = {{&t->let, "an abbreviation"}, {&t->motion, "a displacement"}, {&t->states, "a state"}};
    int room = t->parameter_count + t->constant_count, count = 0;
    for (int k = 0; k < 3; k++)
        room += lists[k].list->count;
    declared *all = calloc((size_t)room + 1, sizeof *all);
    if (!all)
        return no_memory(message);
    for (int k = 0; k < t->parameter_count; k++)
        all[count++] = (declared){t->parameters[k].name, "a parameter", m->parameter_line[k]};
    for (int k = 0; k < t->constant_count; k++)
        all[count++] = (declared){t->constants[k].name, "a constant", t->constants[k].line};
    for (int l = 0; l < 3; l++)
        for (int k = 0; k < lists[l].list->count; k++) {
            const saltus_parsed *e = &lists[l].list->items[k];
            /* Equations of a family's members share its name. */
            bool again = false;
            for (int j = 0; j < k && (e->index[0] || e->number); j++)
                again |= strcmp(lists[l].list->items[j].base, e->base) == 0;
            if (!again)
                all[count++] = (declared){e->base, lists[l].what, e->line};
        }
    qsort(all, (size_t)count, sizeof *all, by_name);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < count && status == SALTUS_OK; k++) {
        char sentence[200];
        const char *name = all[k].name, *wrong = NULL;
        if (strlen(name) >= SALTUS_NAME_MAX)
            wrong = "a name must have 1 to 31 characters";
        else if (!*name || (*name >= '0' && *name <= '9') || name[strspn(name, letters)])
            wrong = "a name is made of letters, digits and _, a letter first";
        else if (is_reserved(name))
            wrong = "this name is reserved";
        else if (k > 0 && strcmp(name, all[k - 1].name) == 0) {
            snprintf(sentence, sizeof sentence, "is %s already (line %d)", all[k - 1].what, all[k - 1].line);
            wrong = sentence;
        }
        if (wrong)
            status = place_failure(t->origin, name, all[k].line, wrong, message);
    }
    free(all);
    return status;
}

/* Refuse parameters that no equation contains: most of them are misspelt. */
static saltus_status check_used(const text_model *m, saltus_message *message) {
    const saltus_parsed_text *t = &m->text;
    for (int p = 0; p < t->parameter_count; p++) {
        const char *name = t->parameters[p].name;
        const size_t length = strlen(name);
        bool used = p == m->model.forcing;
        for (size_t l = 0; l < sizeof t->lists / sizeof t->lists[0]; l++)
            for (int k = 0; k < t->lists[l].count && !used; k++) {
                const saltus_expression *e = &t->lists[l].items[k].right;
                for (int j = 0; j < e->count && !used; j++)
                    used = e->terms[j].kind == SALTUS_SYNTAX_NAME && (size_t)e->terms[j].length == length &&
                           memcmp(e->text + e->terms[j].begin, name, length) == 0;
            }
        if (!used)
            return place_failure(t->origin, name, m->parameter_line[p], "no equation has this parameter",
                                 message);
    }
    return SALTUS_OK;
}

/* Check that the field has the period of the forcing: otherwise it would jump, since t restarts with each
 * period. Generic points are tested, also with parameters that are zero by default set to other values. */
static saltus_status check_periodic(const text_model *m, const saltus_spec *spec, saltus_message *message) {
    const saltus_equations_graph *g = graph_of(spec);
    if (spec->model->forcing < 0 || !g->forced)
        return SALTUS_OK;
    const double period = 2 * M_PI / spec->parameters[spec->model->forcing];
    const size_t size = (size_t)g->graph.count * sizeof(double);
    double *now = malloc(size), *later = malloc(size), state[SALTUS_STATE_MAX];
    double parameters[SALTUS_PARAMETERS_MAX];
    int worst = -1;
    for (int k = 0; k < 6 && now && later && worst < 0; k++) {
        const double phase = fmod(0.17 + 0.618034 * k, 1);
        for (int i = 0; i < SALTUS_STATE_MAX; i++)
            state[i] = 0.3 + 0.2 * sin(1.3 * i + k);
        for (int p = 0; p < m->text.parameter_count; p++) {
            const saltus_parameter *own = &m->text.parameters[p];
            parameters[p] = spec->parameters[p];
            if (k % 2 && !own->integer && parameters[p] == 0)
                parameters[p] = own->max > 0.7236 ? 0.7236 : own->max > 0 ? own->max : own->min;
        }
        saltus_graph_evaluate(&g->graph, parameters, state, phase * period, phase, now);
        saltus_graph_evaluate(&g->graph, parameters, state, (phase + 1) * period, phase, later);
        for (int i = 0; i < g->dof + g->extra && worst < 0; i++)
            if (fabs(later[g->field[i]] - now[g->field[i]]) > 1e-9 * (1 + fabs(now[g->field[i]])))
                worst = i;
    }
    bool known = now && later;
    free(now);
    free(later);
    if (!known)
        return no_memory(message);
    if (worst < 0)
        return SALTUS_OK;
    const saltus_parsed_list *list = worst < g->dof ? &m->text.motion : &m->text.states;
    const saltus_parsed *own = &list->items[0];
    for (int k = list->count - 1; k >= 0; k--)
        if (strncmp(g->names[worst], list->items[k].base, strlen(list->items[k].base)) == 0)
            own = &list->items[k];
    return place_failure(
        m->text.origin, own->name, own->line,
        "time must enter with the period of the forcing, as in cos(omega*t): t begins anew every period",
        message);
}

static saltus_status fill_model(text_model *m, const saltus_text *text, saltus_message *message) {
    static const saltus_text_stop none;
    const saltus_text_stop *stops = text->stop_count ? text->stops : &none;
    const size_t apart = sizeof(saltus_equation), stops_apart = sizeof *stops;
    saltus_parsed_text *t = &m->text;
    saltus_status status = copy_numbers(m, text, message);
    const struct {
        const char *origin;
        const saltus_equation *items;
        int count;
        size_t stride;
        saltus_parsed_list *to;
    } lists[] = {{t->origin, text->families.items, text->families.count, apart, &t->families},
                 {t->origin, text->let.items, text->let.count, apart, &t->let},
                 {t->origin, text->motion.items, text->motion.count, apart, &t->motion},
                 {t->origin, text->mass.items, text->mass.count, apart, &t->mass},
                 {t->origin, text->states.items, text->states.count, apart, &t->states},
                 {t->origin, text->observe.items, text->observe.count, apart, &t->observe},
                 {t->origin, text->scale.items, text->scale.count, apart, &t->scale},
                 {t->scene, text->initial.items, text->initial.count, apart, &t->initial},
                 {t->scene, &stops->coordinate, text->stop_count, stops_apart, &t->coordinates},
                 {t->scene, &stops->d, text->stop_count, stops_apart, &t->clearances},
                 {t->scene, &stops->r, text->stop_count, stops_apart, &t->restitutions},
                 {t->origin, &text->zero, text->zero.text != NULL, apart, &t->zero}};
    for (size_t k = 0; k < sizeof lists / sizeof lists[0] && status == SALTUS_OK; k++) {
        saltus_parsed_list *to = lists[k].to;
        to->items = saltus_text_keep(&m->owned, (size_t)lists[k].count, sizeof *to->items);
        if (!to->items)
            status = no_memory(message);
        for (; to->count < lists[k].count && status == SALTUS_OK; to->count++) {
            const char *at = (const char *)lists[k].items + (size_t)to->count * lists[k].stride;
            status = parse_equation(m, lists[k].origin, (const saltus_equation *)(const void *)at,
                                    to == &t->scale || to == &t->initial, &to->items[to->count], message);
        }
    }
    if (status == SALTUS_OK)
        status = check_names(m, message);
    for (int k = 0; k < t->parameter_count && t->forcing && status == SALTUS_OK; k++)
        if (strcmp(t->parameters[k].name, t->forcing) == 0)
            m->model.forcing = k;
    if (status != SALTUS_OK || !t->forcing || m->model.forcing >= 0)
        return status;
    char sentence[160];
    snprintf(sentence, sizeof sentence,
             "%.60s is not a parameter; forcing names the one that is the angular frequency", t->forcing);
    return place_failure(t->origin, text->forcing.name, text->forcing.line, sentence, message);
}

/* Members common to all models from text. */
static const saltus_model common_model = {.name = "text",
                                          .kernel = "tape",
                                          .summary = "equations from the scene",
                                          .notation = {.structure = SALTUS_STRUCTURE_BODIES,
                                                       .displacement = "x",
                                                       .coordinate = "x",
                                                       .part = "displacement",
                                                       .time = "t",
                                                       .response = 1},
                                          .stop_key = "coordinate",
                                          .forcing = -1,
                                          .coordinate = coordinate,
                                          .own = own,
                                          .shape = shape,
                                          .by_speed = by_speed,
                                          .rebound = rebound,
                                          .rebound_change = rebound_change,
                                          .complete = complete,
                                          .normal = normal,
                                          .reserve = reserve,
                                          .build = build,
                                          .vary = vary,
                                          .start = start,
                                          .trace = trace,
                                          .state_name = state_name,
                                          .right_side = right_side,
                                          .observable = observable,
                                          .observe = observe,
                                          .crossing = crossing,
                                          .observable_row = observable_row,
                                          .defined = defined,
                                          .fault = fault};

saltus_status saltus_text_model_new(const saltus_text *text, const saltus_model **model,
                                    saltus_message *message) {
    text_model *m = calloc(1, sizeof *m);
    int dof, extra;
    *model = NULL;
    if (!m)
        return no_memory(message);
    atomic_init(&m->owners, 1);
    atomic_init(&m->graphs, NULL);
    m->model = common_model;
    saltus_status status = fill_model(m, text, message);
    m->model.parameters = m->text.parameters;
    m->model.parameter_count = m->text.parameter_count;
    m->model.text = m->source;
    m->model.poincare = text->poincare;
    if (m->text.zero.count)
        m->model.poincare.text = m->text.zero.items[0].text;
    /* Resolve every name once, with the default parameters. */
    const saltus_spec spec = saltus_spec_defaults(&m->model);
    if (status == SALTUS_OK)
        status = shape(&spec, &dof, &extra, message);
    if (status == SALTUS_OK)
        status = check_used(m, message);
    if (status == SALTUS_OK)
        status = check_periodic(m, &spec, message);
    if (status == SALTUS_OK)
        *model = &m->model;
    else
        own(&m->model, -1);
    return status;
}
