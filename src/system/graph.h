/* Private: equations as a graph. Equal expressions are one node (hash-consing), constants are folded, and a
 * node comes after those that it is made of, so that one pass in the order of nodes evaluates all. Nothing
 * here knows how a graph is walked: series, intervals or another machine.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_GRAPH_H
#define SALTUS_SYSTEM_GRAPH_H

#include "saltus/status.h"

#include <stdbool.h>

typedef enum saltus_operation {
    SALTUS_OP_CONSTANT,
    SALTUS_OP_PARAMETER, /* leaves: `index` tells which one */
    SALTUS_OP_STATE,
    SALTUS_OP_TIME,  /* from the last phase 0, in [0, T) */
    SALTUS_OP_PHASE, /* time / T */
    SALTUS_OP_SPEED, /* at which a contact closes, of restitutions only; 0 where a graph is evaluated */
    SALTUS_OP_ADD,   /* of a and b, and so on */
    SALTUS_OP_SUBTRACT,
    SALTUS_OP_MULTIPLY,
    SALTUS_OP_DIVIDE,
    SALTUS_OP_POWER,
    SALTUS_OP_SQRT, /* of a, and so on */
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
    SALTUS_OP_ATAN2, /* of a and b, from here on */
    SALTUS_OP_MOD,   /* a - b floor(a / b) */
    SALTUS_OP_ABS,   /* these switch, and belong to what depends on parameters alone */
    SALTUS_OP_SIGN,
    SALTUS_OP_STEP,
    SALTUS_OP_MIN,
    SALTUS_OP_MAX,
    SALTUS_OP_CHOOSE_LESS,       /* a < b ? c : d */
    SALTUS_OP_CHOOSE_LESS_EQUAL, /* a <= b ? c : d */
    SALTUS_OP_CHOOSE_EQUAL       /* a == b ? c : d */
} saltus_operation;

/* On what the value of a node depends, as bits. */
enum { SALTUS_OF_PARAMETERS = 1, SALTUS_OF_TIME = 2, SALTUS_OF_STATES = 4, SALTUS_OF_SPEED = 8 };

typedef struct saltus_graph_node {
    saltus_operation operation;
    unsigned depends;
    double value;   /* of a constant */
    int index;      /* of a leaf */
    int operand[4]; /* nodes before this one; -1: none */
} saltus_graph_node;

enum { SALTUS_GRAPH_NODES_MAX = 1 << 20 };

typedef struct saltus_graph {
    saltus_graph_node *nodes;
    int count, room;
    int *buckets; /* hash table of nodes: open addressing, -1 empty */
    int bucket_count;
    bool full; /* memory or the largest number of nodes has run out: what was added since is node 0 */
} saltus_graph;

/* An empty graph, but for the constant 0 as node 0. */
bool saltus_graph_open(saltus_graph *graph);
void saltus_graph_close(saltus_graph *graph);

/* The node of a value, a leaf or an operation on nodes: the one that there is, or a new one. Constants are
 * folded and what changes nothing is left out (x + 0, 1 x, 0 x, x^1). */
int saltus_graph_constant(saltus_graph *graph, double value);
int saltus_graph_leaf(saltus_graph *graph, saltus_operation leaf, int index);
int saltus_graph_apply(saltus_graph *graph, saltus_operation operation, int a, int b);
int saltus_graph_choose(saltus_graph *graph, saltus_operation comparison, int a, int b, int yes, int no);

/* Number of operands of an operation. */
int saltus_operation_operands(saltus_operation operation);
/* What an operation makes of numbers. */
typedef double saltus_operation_function(saltus_operation operation, const double operand[4]);
saltus_operation_function saltus_operation_value;

/* For each of the first `count` nodes that are `needed` (NULL: all) and depend on nothing but what is `among`
 * the node of its derivative with respect to a leaf; 0, the constant 0, where it does not depend on it, and
 * for all other nodes. */
void saltus_graph_differentiate(saltus_graph *graph, int leaf, int count, unsigned among, const bool *needed,
                                int *derivatives);
/* The derivative of a function of one operand with respect to that operand. */
int saltus_graph_outer_derivative(saltus_graph *graph, int node);
/* Values of all nodes; leaves are taken from the arrays. */
void saltus_graph_evaluate(const saltus_graph *graph, const double *parameters, const double *state,
                           double time, double phase, double *values);
/* The same of some nodes, in their order: those that they are made of must be among them. */
void saltus_graph_evaluate_some(const saltus_graph *graph, const int *nodes, int count,
                                const double *parameters, const double *state, double time, double phase,
                                double *values);
/* The value of a node at a closing speed, from the values of those that do not depend on it. It follows every
 * way through the node's operands: of nodes with at most SALTUS_AT_SPEED_MAX of them (saltus_graph_ways). */
enum { SALTUS_AT_SPEED_MAX = 10000 };
double saltus_graph_at_speed(const saltus_graph *graph, int node, const double *values, double speed);
double saltus_graph_ways(const saltus_graph *graph, int node);
/* Mark what the given nodes are made of, themselves included (count entries of `needed`, set to false
 * before); where `values` are given (otherwise NULL), of a choice only the one that is made with them. */
void saltus_graph_mark(const saltus_graph *graph, const int *roots, int root_count, const double *values,
                       bool *needed);

#endif
