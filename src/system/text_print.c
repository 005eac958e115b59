/* Writes graphs as text (equations as they are understood), and finds terms without a value.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/text_build.h"

#include "base/field.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Binding strength of printed terms; weaker parts are put in parentheses. */
enum { of_sum, of_product, of_power, of_atom };

/* Limits, because nodes that several others use are written out each time. */
enum { nodes_max = 2000, parts_max = 256 };

typedef struct printer {
    FILE *file;
    const saltus_graph *graph;
    const saltus_parameter *parameters;
    const saltus_state_name *states;
    int left; /* nodes that may still be written */
} printer;

/* A product or a sum taken apart: numbers combined, everything else in the order of the text. */
typedef struct parts {
    int node[parts_max], count;
    bool minus[parts_max]; /* of summands */
    double number;
} parts;

static void put_node(printer *p, int node, int within);

/* Take a product or, if `sum`, a sum apart. False if there are too many parts. */
static bool collect(const saltus_graph *g, int node, bool sum, bool minus, parts *all) {
    const saltus_graph_node *n = &g->nodes[node];
    const bool difference = n->operation == SALTUS_OP_SUBTRACT;
    if (!sum && n->operation == SALTUS_OP_CONSTANT) {
        all->number *= n->value;
        return true;
    }
    if (sum ? difference || n->operation == SALTUS_OP_ADD : n->operation == SALTUS_OP_MULTIPLY)
        return collect(g, n->operand[0], sum, minus, all) &&
               collect(g, n->operand[1], sum, minus != difference, all);
    if (all->count == parts_max)
        return false;
    all->minus[all->count] = minus;
    all->node[all->count++] = node;
    return true;
}

static void put_number(printer *p, double value) {
    char text[SALTUS_NUMBER_MAX];
    fputs(saltus_number(value, text), p->file);
}

/* Whether a summand begins with a minus sign: -2, -k*x. */
static bool is_negative(const saltus_graph *g, int node) {
    parts all = {.number = 1};
    return collect(g, node, false, false, &all) && all.number < 0;
}

/* Print a product without its sign, numbers and parameters first. */
static void put_product(printer *p, int node) {
    const saltus_graph *g = p->graph;
    parts all = {.number = 1};
    const char *star = "";
    if (!collect(g, node, false, false, &all)) {
        fputs("...", p->file);
        return;
    }
    if (fabs(all.number) != 1 || all.count == 0) {
        put_number(p, fabs(all.number));
        star = "*";
    }
    for (int moving = 0; moving < 2; moving++)
        for (int k = 0; k < all.count; k++)
            if (((g->nodes[all.node[k]].depends & ~(unsigned)SALTUS_OF_PARAMETERS) != 0) == moving) {
                fputs(star, p->file);
                put_node(p, all.node[k], all.count > 1 || *star ? of_product + 1 : of_product);
                star = "*";
            }
}

static void put_sum(printer *p, int node) {
    parts all = {.number = 0};
    if (!collect(p->graph, node, true, false, &all)) {
        fputs("...", p->file);
        return;
    }
    for (int k = 0; k < all.count; k++) {
        bool minus = all.minus[k] != is_negative(p->graph, all.node[k]);
        fputs(k ? (minus ? " - " : " + ") : (minus ? "-" : ""), p->file);
        put_product(p, all.node[k]);
    }
}

static void put_call(printer *p, const saltus_graph_node *n) {
    static const char *const comparisons[] = {" < ", " <= ", " == "};
    const int chosen =
        (int)n->operation - SALTUS_OP_CHOOSE_LESS; /* by which comparison; negative: no choice */
    int function = chosen < 0 ? 0 : SALTUS_FUNCTION_if;
    while (chosen < 0 && saltus_function_operation((saltus_function)function) != n->operation)
        function++;
    fprintf(p->file, "%s(", saltus_function_name((saltus_function)function));
    for (int k = 0; k < saltus_operation_operands(n->operation); k++) {
        fputs(k == 0 ? "" : k == 1 && chosen >= 0 ? comparisons[chosen] : ", ", p->file);
        put_node(p, n->operand[k], of_sum);
    }
    fputc(')', p->file);
}

/* The binding strength of a node. */
static int strength(const saltus_graph *g, int node) {
    switch (g->nodes[node].operation) {
    case SALTUS_OP_ADD:
    case SALTUS_OP_SUBTRACT:
        return of_sum;
    case SALTUS_OP_MULTIPLY:
        return is_negative(g, node) ? of_sum : of_product;
    case SALTUS_OP_DIVIDE:
        return of_product;
    case SALTUS_OP_POWER:
        return of_power;
    case SALTUS_OP_CONSTANT:
        return g->nodes[node].value < 0 ? of_sum : of_atom;
    default:
        return of_atom;
    }
}

static void put_node(printer *p, int node, int within) {
    const saltus_graph_node n = p->graph->nodes[node];
    const bool wrapped = strength(p->graph, node) < within, power = n.operation == SALTUS_OP_POWER;
    if (p->left-- <= 0) {
        fputs("...", p->file);
        return;
    }
    fputs(wrapped ? "(" : "", p->file);
    switch (n.operation) {
    case SALTUS_OP_CONSTANT:
        put_number(p, n.value);
        break;
    case SALTUS_OP_PARAMETER:
        fputs(p->parameters[n.index].name, p->file);
        break;
    case SALTUS_OP_STATE:
        fputs(p->states[n.index].text, p->file);
        break;
    case SALTUS_OP_TIME:
        fputs("t", p->file);
        break;
    case SALTUS_OP_PHASE:
        fputs("phase", p->file);
        break;
    case SALTUS_OP_SPEED:
        fputs("speed", p->file);
        break;
    case SALTUS_OP_ADD:
    case SALTUS_OP_SUBTRACT:
    case SALTUS_OP_MULTIPLY:
        put_sum(p, node);
        break;
    case SALTUS_OP_DIVIDE:
    case SALTUS_OP_POWER:
        put_node(p, n.operand[0], power ? of_power + 1 : of_product);
        fputc(power ? '^' : '/', p->file);
        put_node(p, n.operand[1], power ? of_power + 1 : of_product + 1);
        break;
    default:
        put_call(p, &n);
    }
    fputs(wrapped ? ")" : "", p->file);
}

char *saltus_graph_text(const saltus_graph *graph, int node, const saltus_parameter *parameters,
                        const saltus_state_name *states) {
    char *text = NULL;
    size_t length;
    FILE *file = open_memstream(&text, &length);
    printer p = {file, graph, parameters, states, nodes_max};
    if (file)
        put_node(&p, node, of_sum);
    return saltus_close_text(file, &text);
}

/* Distance of an operation from where it has no value, relative to the size of its operands: 0 there,
 * INFINITY if it always has a value. `operand` receives the operand that decides. */
static double nearness(const saltus_graph *g, const saltus_graph_node *n, const double *values,
                       const double *sizes, int *operand) {
    const double a = n->operand[0] < 0 ? 0 : values[n->operand[0]];
    *operand = n->operand[n->operation == SALTUS_OP_DIVIDE];
    switch (n->operation) {
    case SALTUS_OP_POWER:
        if (g->nodes[n->operand[1]].operation == SALTUS_OP_CONSTANT &&
            g->nodes[n->operand[1]].value == floor(g->nodes[n->operand[1]].value) &&
            g->nodes[n->operand[1]].value >= 0)
            return INFINITY;
        return fabs(a) / sizes[*operand];
    case SALTUS_OP_SQRT:
    case SALTUS_OP_LOG:
    case SALTUS_OP_DIVIDE:
        return fabs(values[*operand]) / sizes[*operand];
    case SALTUS_OP_ASIN:
    case SALTUS_OP_ACOS:
        return fabs(1 - fabs(a));
    case SALTUS_OP_TAN:
        return fabs(cos(a));
    default:
        return INFINITY;
    }
}

int saltus_graph_fault(const saltus_graph *graph, const int *roots, int root_count, const double *values,
                       const double *scale, int *operand) {
    static const double near = 1e-4;
    bool *needed = calloc((size_t)graph->count, sizeof *needed);
    double *sizes = calloc((size_t)graph->count, sizeof *sizes), best = near;
    int found = -1;
    if (needed)
        saltus_graph_mark(graph, roots, root_count, values, needed);
    for (int k = 0; k < graph->count && needed && sizes; k++) {
        const saltus_graph_node *n = &graph->nodes[k];
        bool sound = true;
        int which;
        /* The size a node would have if nothing in it cancelled. */
        sizes[k] = n->operation == SALTUS_OP_STATE ? fmax(scale[n->index], fabs(values[k]))
                   : n->operation == SALTUS_OP_ADD || n->operation == SALTUS_OP_SUBTRACT
                       ? sizes[n->operand[0]] + sizes[n->operand[1]]
                   : n->operation == SALTUS_OP_MULTIPLY ? sizes[n->operand[0]] * sizes[n->operand[1]]
                                                        : fabs(values[k]);
        for (int j = 0; j < saltus_operation_operands(n->operation); j++)
            sound = sound && isfinite(values[n->operand[j]]);
        if (!needed[k] || !sound || saltus_operation_operands(n->operation) == 0)
            continue;
        const double distance = nearness(graph, n, values, sizes, &which);
        const bool lost = !isfinite(values[k]);
        if (lost || distance <= best) {
            best = distance;
            found = k;
            *operand = which;
        }
        if (lost)
            break;
    }
    free(needed);
    free(sizes);
    return found;
}
