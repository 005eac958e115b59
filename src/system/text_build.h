/* Private: from parsed equations to a graph.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TEXT_BUILD_H
#define SALTUS_SYSTEM_TEXT_BUILD_H

#include "base/memory.h"
#include "saltus/system.h"
#include "system/expression.h"
#include "system/tape.h"
#include "system/text.h"

/* An equation, parsed. Its left side is `base`, `base[number]`, or `base[index]` for all members of a family.
 */
typedef struct saltus_parsed {
    char *name, *text;  /* as written */
    const char *origin; /* the file it stands in; the text's */
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
    char *origin, *scene, *forcing; /* scene: where stops and initial stand */
    saltus_parameter *parameters;
    int parameter_count;
    saltus_text_constant *constants;
    int constant_count;
    union {
        struct {
            saltus_parsed_list families, let, motion, mass, states, observe, scale, initial;
            saltus_parsed_list zero; /* the section's expression, if there is one */
            /* One for each stop; no text where numbers do. */
            saltus_parsed_list coordinates, clearances, restitutions;
        };
        saltus_parsed_list lists[12];
    };
} saltus_parsed_text;

/* Nodes that are wanted together, and all that they are made of, in the order of evaluation. */
typedef struct saltus_graph_part {
    int *roots, root_count;
    int *nodes, count;
} saltus_graph_part;

/* What a graph has of a stop, as nodes. */
typedef struct saltus_stop_nodes {
    int *normal;                /* [dof] */
    int offset;                 /* the constant part of its coordinate */
    int clearance, restitution; /* -1: a number does */
    int rebound;                /* d(restitution speed) / d speed; -1: speed is not in it */
} saltus_stop_nodes;

/* Of an observed quantity. */
typedef struct saltus_observed_nodes {
    int node;
    int *row; /* [dof]: its derivatives by the displacements ... */
    bool sum; /* ... and whether these are made of parameters alone */
} saltus_observed_nodes;

/* Of an entry of the state; -1: the text says nothing. */
typedef struct saltus_state_nodes {
    int scale, initial;
} saltus_state_nodes;

/* The graph of a text for given whole-number parameters, which decide its sizes. */
typedef struct saltus_equations_graph {
    struct saltus_equations_graph *next; /* for other whole numbers */
    saltus_list owned;                   /* void *: the arrays below */
    double *parameters;                  /* those that it was made for; only whole ones matter */
    saltus_graph graph;
    saltus_tape *tape; /* of accelerations and rates */
    int dof, extra;
    char (*names)[SALTUS_NAME_MAX]; /* of displacements and states */
    saltus_state_nodes *state;      /* [dimension] */
    saltus_stop_nodes *stops;
    int stop_count;
    saltus_observed_nodes *observed;
    int observed_count;
    int *field;                /* nodes of accelerations, then of rates */
    int *inverse_mass;         /* nodes, dof x dof */
    saltus_graph_part zero;    /* the section's expression; without a root: none */
    saltus_graph_part trace;   /* of the Jacobian */
    saltus_graph_part partial; /* parts of the field that have no value at some states, divisions apart */
    bool forced;               /* depends on time */
    int **derivatives; /* [parameter][node]: of nodes that numbers are made of; NULL for whole parameters */
} saltus_equations_graph;

/* Build it. Errors: SALTUS_BAD_INPUT with a sentence that tells the line, SALTUS_NO_MEMORY. */
saltus_status saltus_equations_graph_new(const saltus_parsed_text *text, const double *parameters,
                                         saltus_equations_graph **made, saltus_message *message);
void saltus_equations_graph_free(saltus_equations_graph *graph);

/* A node as an expression, to be freed by the caller; NULL without memory. Very long ones end in "...". */
char *saltus_graph_text(const saltus_graph *graph, int node, const saltus_parameter *parameters,
                        const saltus_state_name *states);
/* The operation, among those that the given nodes are made of, that has no value where all nodes have these
 * values, or that is next to where it has none; -1: there is none. *operand: of it, the node that decides.
 * `scale`: typical sizes of the states. */
int saltus_graph_fault(const saltus_graph *graph, const int *roots, int root_count, const double *values,
                       const double *scale, int *operand);

#endif
