/* Private: builds a graph from parsed equations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TEXT_BUILD_H
#define SALTUS_SYSTEM_TEXT_BUILD_H

#include "base/memory.h"
#include "saltus/system.h"
#include "system/expression.h"
#include "system/tape.h"
#include "system/text.h"

/* A parsed equation. Its left side is `base`, `base[number]` or, for all members of a family,
 * `base[index]`. */
typedef struct saltus_parsed {
    char *name, *text;  /* as written */
    const char *origin; /* its file; owned by the parsed text */
    int line;
    char base[SALTUS_NAME_MAX], index[SALTUS_NAME_MAX];
    int number; /* 0: none */
    saltus_expression right;
} saltus_parsed;

typedef struct saltus_parsed_list {
    saltus_parsed *items;
    int count;
} saltus_parsed_list;

/* A text, copied and parsed. */
typedef struct saltus_parsed_text {
    char *origin, *scene, *forcing; /* scene: file with the stops and the initial state */
    saltus_parameter *parameters;
    int parameter_count;
    saltus_text_constant *constants;
    int constant_count;
    union {
        struct {
            saltus_parsed_list families, let, motion, mass, states, observe, scale, initial;
            saltus_parsed_list zero; /* the section's expression, or empty */
            /* One entry per stop, without text where the spec has a number. */
            saltus_parsed_list coordinates, clearances, restitutions;
        };
        saltus_parsed_list lists[12];
    };
} saltus_parsed_text;

/* Roots that are evaluated together, and all nodes they consist of, in the order of evaluation. */
typedef struct saltus_graph_part {
    int *roots, root_count;
    int *nodes, count;
} saltus_graph_part;

/* Nodes of a stop. */
typedef struct saltus_stop_nodes {
    int *normal;                /* [dof] */
    int offset;                 /* constant part of the coordinate */
    int clearance, restitution; /* -1: a number of the spec */
    int rebound;                /* d(restitution speed) / d speed; -1: speed does not occur */
} saltus_stop_nodes;

/* Nodes of an observed quantity. */
typedef struct saltus_observed_nodes {
    int node;
    int *row; /* [dof]: its derivatives by the displacements, ... */
    bool sum; /* ... and whether they depend on parameters alone */
} saltus_observed_nodes;

/* Nodes of an entry of the state; -1: not in the text. */
typedef struct saltus_state_nodes {
    int scale, initial;
} saltus_state_nodes;

/* The graph of a text for given whole-number parameters, which determine its sizes. */
typedef struct saltus_equations_graph {
    struct saltus_equations_graph *next; /* graph for other whole numbers */
    saltus_list owned;                   /* void *: the arrays below */
    double *parameters;                  /* parameters it was made for; only whole ones matter */
    saltus_graph graph;
    saltus_tape *tape; /* computes accelerations and rates */
    int dof, extra;
    char (*names)[SALTUS_NAME_MAX]; /* names of displacements and states */
    saltus_state_nodes *state;      /* [dimension] */
    saltus_stop_nodes *stops;
    int stop_count;
    saltus_observed_nodes *observed;
    int observed_count;
    int *field;                /* nodes of accelerations, then of the states' rates */
    int *inverse_mass;         /* nodes, dof x dof */
    saltus_graph_part zero;    /* the section's expression; no root: none */
    saltus_graph_part trace;   /* trace of the Jacobian */
    saltus_graph_part partial; /* terms of the field without a value at some states, except divisions */
    bool forced;               /* the field depends on time */
    int **derivatives; /* [parameter][node]: of nodes of parameters and speed; NULL for whole parameters */
} saltus_equations_graph;

/* Build the graph. Errors: SALTUS_BAD_INPUT, with the line, and SALTUS_NO_MEMORY. */
saltus_status saltus_equations_graph_new(const saltus_parsed_text *text, const double *parameters,
                                         saltus_equations_graph **made, saltus_message *message);
void saltus_equations_graph_free(saltus_equations_graph *graph);

/* A node as text, to be freed by the caller; NULL if there is no memory. Very long texts end in "...". */
char *saltus_graph_text(const saltus_graph *graph, int node, const saltus_parameter *parameters,
                        const saltus_state_name *states);
/* Find the operation, among all that the roots consist of, that has no value for the given node values, or
 * almost none; -1: there is none. *operand: its operand that decides. `scale`: typical sizes of the
 * states. */
int saltus_graph_fault(const saltus_graph *graph, const int *roots, int root_count, const double *values,
                       const double *scale, int *operand);

#endif
