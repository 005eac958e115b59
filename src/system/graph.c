/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/graph.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_graph_open(saltus_graph *graph) {
    *graph = (saltus_graph){.full = false};
    saltus_graph_constant(graph, 0);
    return !graph->full;
}

void saltus_graph_close(saltus_graph *graph) {
    free(graph->nodes);
    free(graph->buckets);
    *graph = (saltus_graph){.full = false};
}

static double sign_of(double x) {
    return (x > 0) - (x < 0);
}

static double step_of(double x) {
    return x >= 0;
}

/* Operations with one operand. */
static double (*const functions[SALTUS_OP_CHOOSE_LESS])(double) = {
    [SALTUS_OP_SQRT] = sqrt, [SALTUS_OP_EXP] = exp,      [SALTUS_OP_LOG] = log,      [SALTUS_OP_SIN] = sin,
    [SALTUS_OP_COS] = cos,   [SALTUS_OP_TAN] = tan,      [SALTUS_OP_ASIN] = asin,    [SALTUS_OP_ACOS] = acos,
    [SALTUS_OP_ATAN] = atan, [SALTUS_OP_SINH] = sinh,    [SALTUS_OP_COSH] = cosh,    [SALTUS_OP_TANH] = tanh,
    [SALTUS_OP_ABS] = fabs,  [SALTUS_OP_SIGN] = sign_of, [SALTUS_OP_STEP] = step_of,
};

int saltus_operation_operands(saltus_operation operation) {
    if (operation < SALTUS_OP_ADD || operation >= SALTUS_OP_CHOOSE_LESS)
        return operation < SALTUS_OP_ADD ? 0 : 4;
    return functions[operation] ? 1 : 2;
}

double saltus_operation_value(saltus_operation operation, const double x[4]) {
    switch (operation) {
    case SALTUS_OP_ADD:
        return x[0] + x[1];
    case SALTUS_OP_SUBTRACT:
        return x[0] - x[1];
    case SALTUS_OP_MULTIPLY:
        return x[0] * x[1];
    case SALTUS_OP_DIVIDE:
        return x[0] / x[1];
    case SALTUS_OP_POWER:
        return pow(x[0], x[1]);
    case SALTUS_OP_ATAN2:
        return atan2(x[0], x[1]);
    case SALTUS_OP_MOD:
        return x[0] - x[1] * floor(x[0] / x[1]);
    case SALTUS_OP_MIN:
        return x[1] < x[0] ? x[1] : x[0];
    case SALTUS_OP_MAX:
        return x[1] > x[0] ? x[1] : x[0];
    case SALTUS_OP_CHOOSE_LESS:
        return x[0] < x[1] ? x[2] : x[3];
    case SALTUS_OP_CHOOSE_LESS_EQUAL:
        return x[0] <= x[1] ? x[2] : x[3];
    case SALTUS_OP_CHOOSE_EQUAL:
        return x[0] == x[1] ? x[2] : x[3];
    default: /* leaves have no operands */
        return saltus_operation_operands(operation) ? functions[operation](x[0]) : NAN;
    }
}

/* Compares bits, so that zeros of different sign are different constants. */
static bool equal(const saltus_graph_node *a, const saltus_graph_node *b) {
    return a->operation == b->operation && a->index == b->index &&
           memcmp(&a->value, &b->value, sizeof a->value) == 0 &&
           memcmp(a->operand, b->operand, sizeof a->operand) == 0;
}

/* The bucket that holds an equal node, or the empty one where the node belongs: where the hash of its
 * contents (FNV-1a over its words, mixed at the end) points to, or further on. */
static int *bucket_of(const saltus_graph *graph, const saltus_graph_node *node) {
    unsigned long long bits, hash = 14695981039346656037ULL;
    memcpy(&bits, &node->value, sizeof bits);
    const unsigned long long words[] = {(unsigned)node->operation,  bits,
                                        (unsigned)node->index,      (unsigned)node->operand[0],
                                        (unsigned)node->operand[1], (unsigned)node->operand[2],
                                        (unsigned)node->operand[3]};
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        hash = (hash ^ words[k]) * 1099511628211ULL;
    unsigned long long mask = (unsigned long long)graph->bucket_count - 1, at = (hash ^ hash >> 29) & mask;
    while (graph->buckets[at] >= 0 && !equal(&graph->nodes[graph->buckets[at]], node))
        at = (at + 1) & mask;
    return &graph->buckets[at];
}

/* Make room for one more node and keep the hash table at most half full. */
static bool reserve(saltus_graph *graph) {
    if (graph->count < graph->room)
        return true;
    int room = graph->room ? 2 * graph->room : 64;
    if (room > SALTUS_GRAPH_NODES_MAX)
        return false;
    saltus_graph_node *nodes = realloc(graph->nodes, (size_t)room * sizeof *nodes);
    if (!nodes)
        return false;
    graph->nodes = nodes;
    int *buckets = realloc(graph->buckets, 2 * (size_t)room * sizeof *buckets);
    if (!buckets)
        return false;
    graph->buckets = buckets;
    graph->bucket_count = 2 * room;
    graph->room = room;
    for (int k = 0; k < graph->bucket_count; k++)
        buckets[k] = -1;
    for (int k = 0; k < graph->count; k++)
        *bucket_of(graph, &nodes[k]) = k;
    return true;
}

static int add_node(saltus_graph *graph, saltus_graph_node node) {
    if (graph->full || !reserve(graph)) {
        graph->full = true;
        return 0;
    }
    int *bucket = bucket_of(graph, &node);
    if (*bucket < 0) {
        *bucket = graph->count;
        graph->nodes[graph->count++] = node;
    }
    return *bucket;
}

static const saltus_graph_node none = {.index = -1, .operand = {-1, -1, -1, -1}};

int saltus_graph_constant(saltus_graph *graph, double value) {
    saltus_graph_node node = none;
    node.operation = SALTUS_OP_CONSTANT;
    node.value = value == 0 ? 0 : value;
    return add_node(graph, node);
}

int saltus_graph_leaf(saltus_graph *graph, saltus_operation leaf, int index) {
    saltus_graph_node node = none;
    node.operation = leaf;
    node.index = index;
    node.depends = leaf == SALTUS_OP_PARAMETER ? SALTUS_OF_PARAMETERS
                   : leaf == SALTUS_OP_STATE   ? SALTUS_OF_STATES
                   : leaf == SALTUS_OP_SPEED   ? SALTUS_OF_SPEED
                                               : SALTUS_OF_TIME | SALTUS_OF_PARAMETERS;
    return add_node(graph, node);
}

static bool is_constant(const saltus_graph *graph, int node, double value) {
    return graph->nodes[node].operation == SALTUS_OP_CONSTANT && graph->nodes[node].value == value;
}

/* An existing node that equals an operation, such as x for x + 0; -1: there is none. */
static int simpler(saltus_graph *graph, saltus_operation operation, int a, int b) {
    switch (operation) {
    case SALTUS_OP_ADD:
        return is_constant(graph, a, 0) ? b : is_constant(graph, b, 0) ? a : -1;
    case SALTUS_OP_SUBTRACT:
        if (a == b)
            return 0;
        if (is_constant(graph, a, 0))
            return saltus_graph_apply(graph, SALTUS_OP_MULTIPLY, saltus_graph_constant(graph, -1), b);
        return is_constant(graph, b, 0) ? a : -1;
    case SALTUS_OP_MULTIPLY:
        if (is_constant(graph, a, 0) || is_constant(graph, b, 0))
            return 0;
        return is_constant(graph, a, 1) ? b : is_constant(graph, b, 1) ? a : -1;
    case SALTUS_OP_DIVIDE:
        return is_constant(graph, b, 1) || is_constant(graph, a, 0) ? a : -1;
    case SALTUS_OP_POWER:
        return is_constant(graph, b, 1) ? a : is_constant(graph, b, 0) ? saltus_graph_constant(graph, 1) : -1;
    default:
        return -1;
    }
}

/* The node of an operation whose operands are in canonical order; folded if all are constants. */
static int add_operation(saltus_graph *graph, saltus_operation operation, const int operand[4]) {
    saltus_graph_node node = none;
    double value[4] = {0};
    bool fixed = true;
    node.operation = operation;
    for (int k = 0; k < saltus_operation_operands(operation); k++) {
        const saltus_graph_node *own = &graph->nodes[operand[k]];
        node.operand[k] = operand[k];
        node.depends |= own->depends;
        value[k] = own->value;
        fixed = fixed && own->operation == SALTUS_OP_CONSTANT;
    }
    return fixed ? saltus_graph_constant(graph, saltus_operation_value(operation, value))
                 : add_node(graph, node);
}

int saltus_graph_apply(saltus_graph *graph, saltus_operation operation, int a, int b) {
    bool symmetric = operation == SALTUS_OP_ADD || operation == SALTUS_OP_MULTIPLY;
    int result = simpler(graph, operation, a, b);
    if (result >= 0)
        return result;
    return add_operation(graph, operation,
                         (const int[4]){symmetric && b < a ? b : a, symmetric && b < a ? a : b});
}

int saltus_graph_choose(saltus_graph *graph, saltus_operation comparison, int a, int b, int yes, int no) {
    return yes == no ? yes : add_operation(graph, comparison, (const int[4]){a, b, yes, no});
}

/* An operation in the derivatives below. */
#define APPLY(operation, a, b) saltus_graph_apply(g, SALTUS_OP_##operation, a, b)

int saltus_graph_outer_derivative(saltus_graph *g, int node) {
    const saltus_operation operation = g->nodes[node].operation;
    const int a = g->nodes[node].operand[0];
    int one = saltus_graph_constant(g, 1), square = APPLY(MULTIPLY, a, a);
    switch (operation) {
    case SALTUS_OP_SQRT:
        return APPLY(DIVIDE, saltus_graph_constant(g, 0.5), node);
    case SALTUS_OP_EXP:
        return node;
    case SALTUS_OP_LOG:
        return APPLY(DIVIDE, one, a);
    case SALTUS_OP_SIN:
        return APPLY(COS, a, -1);
    case SALTUS_OP_COS:
        return APPLY(SUBTRACT, 0, APPLY(SIN, a, -1));
    case SALTUS_OP_TAN:
        return APPLY(ADD, one, APPLY(MULTIPLY, node, node));
    case SALTUS_OP_ASIN:
        return APPLY(DIVIDE, one, APPLY(SQRT, APPLY(SUBTRACT, one, square), -1));
    case SALTUS_OP_ACOS:
        return APPLY(DIVIDE, saltus_graph_constant(g, -1), APPLY(SQRT, APPLY(SUBTRACT, one, square), -1));
    case SALTUS_OP_ATAN:
        return APPLY(DIVIDE, one, APPLY(ADD, one, square));
    case SALTUS_OP_SINH:
        return APPLY(COSH, a, -1);
    case SALTUS_OP_COSH:
        return APPLY(SINH, a, -1);
    case SALTUS_OP_TANH:
        return APPLY(SUBTRACT, one, APPLY(MULTIPLY, node, node));
    case SALTUS_OP_ABS:
        return APPLY(SIGN, a, -1);
    default: /* sign and step are piecewise constant */
        return 0;
    }
}

static int differentiate(saltus_graph *g, int node, const int *d) {
    const saltus_graph_node n = g->nodes[node];
    int a = n.operand[0], b = n.operand[1], da = a < 0 ? 0 : d[a], db = b < 0 ? 0 : d[b];
    switch (n.operation) {
    case SALTUS_OP_ADD:
        return APPLY(ADD, da, db);
    case SALTUS_OP_SUBTRACT:
        return APPLY(SUBTRACT, da, db);
    case SALTUS_OP_MULTIPLY:
        return APPLY(ADD, APPLY(MULTIPLY, da, b), APPLY(MULTIPLY, a, db));
    case SALTUS_OP_DIVIDE:
        return APPLY(DIVIDE, APPLY(SUBTRACT, da, APPLY(MULTIPLY, node, db)), b);
    case SALTUS_OP_POWER: { /* a^b -> b a^(b - 1) a' + a^b log(a) b' */
        int lower = APPLY(POWER, a, APPLY(SUBTRACT, b, saltus_graph_constant(g, 1)));
        int first = APPLY(MULTIPLY, APPLY(MULTIPLY, b, lower), da);
        return db == 0 ? first
                       : APPLY(ADD, first, APPLY(MULTIPLY, APPLY(MULTIPLY, node, APPLY(LOG, a, -1)), db));
    }
    case SALTUS_OP_ATAN2:
        return APPLY(DIVIDE, APPLY(SUBTRACT, APPLY(MULTIPLY, b, da), APPLY(MULTIPLY, a, db)),
                     APPLY(ADD, APPLY(MULTIPLY, a, a), APPLY(MULTIPLY, b, b)));
    case SALTUS_OP_MOD: /* floor(a / b) = (a - mod) / b */
        return APPLY(SUBTRACT, da, APPLY(MULTIPLY, APPLY(DIVIDE, APPLY(SUBTRACT, a, node), b), db));
    case SALTUS_OP_MIN:
        return saltus_graph_choose(g, SALTUS_OP_CHOOSE_LESS, b, a, db, da);
    case SALTUS_OP_MAX:
        return saltus_graph_choose(g, SALTUS_OP_CHOOSE_LESS, a, b, db, da);
    case SALTUS_OP_CHOOSE_LESS:
    case SALTUS_OP_CHOOSE_LESS_EQUAL:
    case SALTUS_OP_CHOOSE_EQUAL:
        return saltus_graph_choose(g, n.operation, a, b, d[n.operand[2]], d[n.operand[3]]);
    default:
        return da ? APPLY(MULTIPLY, saltus_graph_outer_derivative(g, node), da) : 0;
    }
}

void saltus_graph_differentiate(saltus_graph *graph, int leaf, int count, unsigned among, const bool *needed,
                                int *derivatives) {
    for (int k = 0; k < count; k++) {
        bool leads = false;
        if (graph->nodes[k].depends & ~among || (needed && !needed[k])) {
            derivatives[k] = 0;
            continue;
        }
        for (int j = 0; j < saltus_operation_operands(graph->nodes[k].operation); j++)
            leads |= derivatives[graph->nodes[k].operand[j]] != 0;
        derivatives[k] = k == leaf ? saltus_graph_constant(graph, 1)
                         : leads   ? differentiate(graph, k, derivatives)
                                   : 0;
    }
}

/* The value of a node from the values of its operands. */
static double value_of(const saltus_graph_node *node, const double *parameters, const double *state,
                       double time, double phase, const double *values) {
    double operand[4] = {0};
    for (int j = 0; j < saltus_operation_operands(node->operation); j++)
        operand[j] = values[node->operand[j]];
    return node->operation == SALTUS_OP_CONSTANT    ? node->value
           : node->operation == SALTUS_OP_PARAMETER ? parameters[node->index]
           : node->operation == SALTUS_OP_STATE     ? state[node->index]
           : node->operation == SALTUS_OP_TIME      ? time
           : node->operation == SALTUS_OP_PHASE     ? phase
           : node->operation == SALTUS_OP_SPEED     ? 0
                                                    : saltus_operation_value(node->operation, operand);
}

void saltus_graph_evaluate(const saltus_graph *graph, const double *parameters, const double *state,
                           double time, double phase, double *values) {
    for (int k = 0; k < graph->count; k++)
        values[k] = value_of(&graph->nodes[k], parameters, state, time, phase, values);
}

void saltus_graph_evaluate_some(const saltus_graph *graph, const int *nodes, int count,
                                const double *parameters, const double *state, double time, double phase,
                                double *values) {
    for (int k = 0; k < count; k++)
        values[nodes[k]] = value_of(&graph->nodes[nodes[k]], parameters, state, time, phase, values);
}

double saltus_graph_at_speed(const saltus_graph *graph, int node, const double *values, double speed) {
    const saltus_graph_node *n = &graph->nodes[node];
    double operand[4] = {0};
    if (n->operation == SALTUS_OP_SPEED || !(n->depends & SALTUS_OF_SPEED))
        return n->operation == SALTUS_OP_SPEED ? speed : values[node];
    for (int j = 0; j < saltus_operation_operands(n->operation); j++)
        operand[j] = saltus_graph_at_speed(graph, n->operand[j], values, speed);
    return saltus_operation_value(n->operation, operand);
}

double saltus_graph_ways(const saltus_graph *graph, int node) {
    double *ways = calloc((size_t)node + 1, sizeof *ways), all = INFINITY;
    for (int k = 0; ways && k <= node; k++) {
        ways[k] = 1;
        for (int j = 0; j < saltus_operation_operands(graph->nodes[k].operation); j++)
            ways[k] += graph->nodes[k].depends & SALTUS_OF_SPEED ? ways[graph->nodes[k].operand[j]] : 0;
        all = ways[k];
    }
    free(ways);
    return all;
}

void saltus_graph_mark(const saltus_graph *graph, const int *roots, int root_count, const double *values,
                       bool *needed) {
    for (int k = 0; k < root_count; k++)
        needed[roots[k]] = true;
    for (int k = graph->count - 1; k >= 0; k--) {
        const saltus_graph_node *n = &graph->nodes[k];
        int left_out = -1; /* the operand, 2 or 3, that a choice does not take */
        if (needed[k] && values && n->operation >= SALTUS_OP_CHOOSE_LESS) {
            const double operand[] = {values[n->operand[0]], values[n->operand[1]], 2, 3};
            left_out = 5 - (int)saltus_operation_value(n->operation, operand);
        }
        for (int j = 0; needed[k] && j < saltus_operation_operands(n->operation); j++)
            needed[n->operand[j]] |= j != left_out;
    }
}
