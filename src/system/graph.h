/* Private: equations as a graph. Equal expressions are one node (hash-consing), constants are folded, and
 * nodes come after their operands, so that one pass in the order of nodes evaluates all. How graphs are used
 * (series, intervals, another machine) is not decided here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_GRAPH_H
#define SALTUS_SYSTEM_GRAPH_H

#include "saltus/status.h"

#include <stdbool.h>

typedef enum saltus_operation {
    SALTUS_OP_CONSTANT,
    SALTUS_OP_PARAMETER, /* this leaf and STATE: `index` says which one */
    SALTUS_OP_STATE,
    SALTUS_OP_TIME,  /* since the last phase 0, in [0, T) */
    SALTUS_OP_PHASE, /* time / T */
    SALTUS_OP_SPEED, /* closing speed of a contact, in restitutions only; 0 in saltus_graph_evaluate */
    SALTUS_OP_ADD,   /* binary operations of a and b */
    SALTUS_OP_SUBTRACT,
    SALTUS_OP_MULTIPLY,
    SALTUS_OP_DIVIDE,
    SALTUS_OP_POWER,
    SALTUS_OP_SQRT, /* unary operations of a */
    SALTUS_OP_EXP,
    SALTUS_OP_LOG,
    SALTUS_OP_SIN,
    SALTUS_OP_COS,
    SALTUS_OP_TAN,
    SALTUS_OP_ASIN,
    SALTUS_OP_ACOS,
    SALTUS_OP_ATAN,
    SALTUS_OP_SINH,
    SALTUS_OP_COSH,
    SALTUS_OP_TANH,
    SALTUS_OP_ATAN2, /* binary */
    SALTUS_OP_MOD,   /* a - b floor(a / b) */
    SALTUS_OP_ABS,   /* from here on: piecewise operations, of parameters only */
    SALTUS_OP_SIGN,
    SALTUS_OP_STEP,
    SALTUS_OP_MIN,
    SALTUS_OP_MAX,
    SALTUS_OP_CHOOSE_LESS,       /* a < b ? c : d */
    SALTUS_OP_CHOOSE_LESS_EQUAL, /* a <= b ? c : d */
    SALTUS_OP_CHOOSE_EQUAL       /* a == b ? c : d */
} saltus_operation;

/* What a node's value depends on, as bits. */
enum { SALTUS_OF_PARAMETERS = 1, SALTUS_OF_TIME = 2, SALTUS_OF_STATES = 4, SALTUS_OF_SPEED = 8 };

typedef struct saltus_graph_node {
    saltus_operation operation;
    unsigned depends;
    double value;   /* of a constant */
    int index;      /* of a leaf */
    int operand[4]; /* earlier nodes; -1: none */
} saltus_graph_node;

enum { SALTUS_GRAPH_NODES_MAX = 1 << 20 };

typedef struct saltus_graph {
    saltus_graph_node *nodes;
    int count, room;
    int *buckets; /* hash table of nodes: open addressing, -1 empty */
    int bucket_count;
    bool full; /* out of memory or nodes: everything added since is node 0 */
} saltus_graph;

/* A graph with the constant 0 as its only node, node 0. False: no memory. */
bool saltus_graph_open(saltus_graph *graph);
void saltus_graph_close(saltus_graph *graph);

/* Nodes of a constant, a leaf or an operation, existing ones if possible. Constants are folded and trivial
 * operations simplified (x + 0, 1 x, 0 x, x^1). */
int saltus_graph_constant(saltus_graph *graph, double value);
int saltus_graph_leaf(saltus_graph *graph, saltus_operation leaf, int index);
int saltus_graph_apply(saltus_graph *graph, saltus_operation operation, int a, int b);
int saltus_graph_choose(saltus_graph *graph, saltus_operation comparison, int a, int b, int yes, int no);

/* Number of operands of an operation. */
int saltus_operation_operands(saltus_operation operation);
/* The value of an operation for given operands. */
typedef double saltus_operation_function(saltus_operation operation, const double operand[4]);
saltus_operation_function saltus_operation_value;

/* Differentiate the first `count` nodes by a leaf. derivatives[k] is the node of node k's derivative if k is
 * `needed` (NULL: all are) and depends on nothing but what is `among`; otherwise 0, the zero node. */
void saltus_graph_differentiate(saltus_graph *graph, int leaf, int count, unsigned among, const bool *needed,
                                int *derivatives);
/* The derivative of a function of one operand with respect to that operand. */
int saltus_graph_outer_derivative(saltus_graph *graph, int node);
/* Evaluate all nodes; leaves take their values from the arrays. */
void saltus_graph_evaluate(const saltus_graph *graph, const double *parameters, const double *state,
                           double time, double phase, double *values);
/* The same for some nodes, in their order; their operands must be among them. */
void saltus_graph_evaluate_some(const saltus_graph *graph, const int *nodes, int count,
                                const double *parameters, const double *state, double time, double phase,
                                double *values);
/* The value of a node at a closing speed; `values` holds the nodes that do not depend on it. The recursion
 * visits every path through the operands: a node may have SALTUS_AT_SPEED_MAX of them (saltus_graph_ways). */
enum { SALTUS_AT_SPEED_MAX = 10000 };
double saltus_graph_at_speed(const saltus_graph *graph, int node, const double *values, double speed);
double saltus_graph_ways(const saltus_graph *graph, int node);
/* Mark the given nodes and all nodes that they are made of (graph->count entries of `needed`, false before).
 * With `values` (may be NULL), only the branch of each choice that is taken. */
void saltus_graph_mark(const saltus_graph *graph, const int *roots, int root_count, const double *values,
                       bool *needed);

#endif
