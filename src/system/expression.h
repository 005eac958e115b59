/* Private: parses expressions into trees by operator precedence (V. R. Pratt, Top down operator precedence,
 * POPL 1973). The meaning of names is not decided here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_EXPRESSION_H
#define SALTUS_SYSTEM_EXPRESSION_H

#include "system/graph.h"

#include <stdbool.h>

/* Functions with their operations and least and largest numbers of arguments. Not operations are `if`, whose
 * first argument is a comparison, and `sum` with an index's name, first and last value, and a summand. */
#define SALTUS_FUNCTIONS(X)                                                                                  \
    X(sqrt, SQRT, 1, 1)                                                                                      \
    X(exp, EXP, 1, 1)                                                                                        \
    X(log, LOG, 1, 1)                                                                                        \
    X(sin, SIN, 1, 1)                                                                                        \
    X(cos, COS, 1, 1)                                                                                        \
    X(tan, TAN, 1, 1)                                                                                        \
    X(asin, ASIN, 1, 1)                                                                                      \
    X(acos, ACOS, 1, 1)                                                                                      \
    X(atan, ATAN, 1, 1)                                                                                      \
    X(atan2, ATAN2, 2, 2)                                                                                    \
    X(sinh, SINH, 1, 1)                                                                                      \
    X(cosh, COSH, 1, 1)                                                                                      \
    X(tanh, TANH, 1, 1)                                                                                      \
    X(abs, ABS, 1, 1)                                                                                        \
    X(sign, SIGN, 1, 2)                                                                                      \
    X(min, MIN, 2, 16)                                                                                       \
    X(max, MAX, 2, 16)                                                                                       \
    X(step, STEP, 1, 1)                                                                                      \
    X(mod, MOD, 2, 2)                                                                                        \
    X(if, CONSTANT, 3, 3)                                                                                    \
    X(sum, CONSTANT, 4, 4)

#define SALTUS_FUNCTION_NAMED(name, operation, least, most) SALTUS_FUNCTION_##name,
typedef enum saltus_function {
    SALTUS_FUNCTIONS(SALTUS_FUNCTION_NAMED) SALTUS_FUNCTION_COUNT
} saltus_function;

typedef enum saltus_syntax {
    SALTUS_SYNTAX_NUMBER,
    SALTUS_SYNTAX_NAME, /* with the indices of x[i] as arguments */
    SALTUS_SYNTAX_CALL,
    SALTUS_SYNTAX_NEGATE,
    SALTUS_SYNTAX_ADD,
    SALTUS_SYNTAX_SUBTRACT,
    SALTUS_SYNTAX_MULTIPLY,
    SALTUS_SYNTAX_DIVIDE,
    SALTUS_SYNTAX_POWER,
    SALTUS_SYNTAX_LESS, /* from here on: comparisons, allowed only as the first argument of `if` */
    SALTUS_SYNTAX_LESS_EQUAL,
    SALTUS_SYNTAX_GREATER,
    SALTUS_SYNTAX_GREATER_EQUAL,
    SALTUS_SYNTAX_EQUAL,
    SALTUS_SYNTAX_UNEQUAL
} saltus_syntax;

/* A node of the tree. Arguments are nodes chained by `next`, from `first` on; -1 ends a chain. */
typedef struct saltus_expression_term {
    saltus_syntax kind;
    saltus_function function; /* of a call */
    bool rate;                /* of a name: with a prime, x' */
    double number;
    int begin, length; /* position in the text of the name, number or operator */
    int first, next;
} saltus_expression_term;

enum { SALTUS_EXPRESSION_BYTES_MAX = 20000, SALTUS_EXPRESSION_DEPTH_MAX = 100 };

typedef struct saltus_expression {
    const char *text; /* owned by the caller */
    saltus_expression_term *terms;
    int count, root;
} saltus_expression;

/* Parse a text, which must outlive the expression. Clear the expression after success. Errors:
 * SALTUS_BAD_INPUT (the message gives the column in bytes, from 1), SALTUS_NO_MEMORY. */
saltus_status saltus_expression_parse(const char *text, saltus_expression *expression,
                                      saltus_message *message);
/* Free the terms. A zeroed one is accepted. */
void saltus_expression_clear(saltus_expression *expression);

/* The word of a function in texts, and the operation that computes it. */
const char *saltus_function_name(saltus_function function);
saltus_operation saltus_function_operation(saltus_function function);

#endif
