/* Random systems x'' = tanh(..) - x, z' = tanh(..) as text, with the expressions as trees for whoever
 * evaluates them in a way of its own.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_RANDOM_TEXT_H
#define SALTUS_TESTS_RANDOM_TEXT_H

#include "check.h"

#include "system/system.h"
#include "system/text.h"

/* A random expression of x, x', a state z, the forcing and a parameter: its text, and itself for plain
 * evaluation.
 */
enum { nodes_max = 64, text_max = 2000 };
typedef struct tree {
    struct {
        int kind, left, right;
        double number;
    } node[nodes_max];
    int count;
} tree;
enum { leaf_x, leaf_v, leaf_z, leaf_t, leaf_a, leaf_number, plus, minus, times, over, power, first_function };
static const char *const function_names[] = {"sin",  "cos",  "exp", "tanh", "sqrt", "log",  "atan",
                                             "sinh", "cosh", "tan", "asin", "acos", "atan2"};
enum { functions = sizeof function_names / sizeof function_names[0] };

static unsigned long random_state = 20;
static inline unsigned draw(unsigned below) {
    random_state = random_state * 6364136223846793005UL + 1442695040888963407UL;
    return (unsigned)(random_state >> 33) % below;
}

static inline int grow(tree *t, int depth) {
    const int place = t->count++;
    int kind = depth == 0 || t->count > nodes_max - 8 ? (int)draw(6) : (int)draw(first_function + functions);
    t->node[place].kind = kind;
    t->node[place].number = 0.25 * (1 + draw(8)) * (draw(2) ? 1 : -1);
    t->node[place].left = kind >= plus ? grow(t, depth - 1) : -1;
    bool two = (kind >= plus && kind <= over) || kind == first_function + 12;
    t->node[place].right = two ? grow(t, depth - 1) : -1;
    if (kind == power)
        t->node[place].number = (double)(2 + draw(4)) - (draw(3) == 0 ? 0.5 : 0);
    return place;
}

/* What is divided by or taken the root of is kept away from zero. */
static inline void print(const tree *t, int k, char *text, size_t *used) {
    int kind = t->node[k].kind, left = t->node[k].left, right = t->node[k].right;
    static const char *const leaves[] = {"x", "x'", "z", "sin(omega*t)", "a"};
#define PUT(...) (*used += (size_t)snprintf(text + *used, text_max - *used, __VA_ARGS__))
    if (kind == leaf_number)
        PUT("(%g)", t->node[k].number);
    else if (kind < leaf_number)
        PUT("%s", leaves[kind]);
    else if (kind <= over) {
        PUT("(");
        print(t, left, text, used);
        PUT(kind == plus ? " + " : kind == minus ? " - " : kind == times ? "*" : "/(2 + ");
        if (kind == over)
            PUT("(");
        print(t, right, text, used);
        PUT(kind == over ? ")^2))" : ")");
    } else if (kind == power) {
        bool whole = t->node[k].number == floor(t->node[k].number);
        PUT(whole ? "tanh(" : "(2 + tanh(");
        print(t, left, text, used);
        PUT(whole ? ")^%g" : "))^%g", t->node[k].number);
    } else {
        int f = kind - first_function;
        PUT("%s(", function_names[f]);
        PUT(f == 4 || f == 5                       ? "2 + ("
            : f == 2 || f == 7 || f == 8 || f == 9 ? "tanh("
            : f >= 10 && f < 12                    ? "0.5*sin("
                                                   : "(");
        print(t, left, text, used);
        PUT(f == 4 || f == 5 ? ")^2" : ")");
        if (f == 12) {
            PUT(", 2 + (");
            print(t, right, text, used);
            PUT(")^2");
        }
        PUT(")");
    }
}

/* x'' = tanh(motion) - x and z' = tanh(rate), with the parameters a = 0.6 and omega = 0.5. */
typedef struct pair {
    tree motion, rate;
    double a;
    char text[2][text_max + 40];
} pair;

static inline pair random_pair(int depth) {
    pair p = {.a = 0.6, .text = {"tanh(", "tanh("}};
    for (int k = 0; k < 2; k++) {
        tree *t = k ? &p.rate : &p.motion;
        size_t used = strlen(p.text[k]);
        grow(t, depth);
        print(t, 0, p.text[k], &used);
        snprintf(p.text[k] + used, sizeof p.text[k] - used, k ? ")" : ") - x");
    }
    return p;
}

static inline const saltus_model *model_of(const pair *p) {
    const saltus_equation motion[] = {{"x", p->text[0], 1}}, states[] = {{"z", p->text[1], 2}};
    const saltus_equation seen = {"seen", "a*x", 4};
    const saltus_text_parameter parameters[] = {{.name = "a", .fallback = 0.6, .min = -9, .max = 9},
                                                {.name = "omega", .fallback = 0.5, .min = 0, .max = 9}};
    const saltus_text text = {.origin = "test",
                              .parameters = parameters,
                              .parameter_count = 2,
                              .motion = {motion, 1},
                              .states = {states, 1},
                              .observe = {&seen, 1}, /* a parameter must be somewhere */
                              .forcing = {"forcing", "omega", 3}};
    const saltus_model *model;
    saltus_message message = {.text = ""};
    if (saltus_text_model_new(&text, &model, &message) != SALTUS_OK)
        fail_msg("%s\n%s\n%s", message.text, p->text[0], p->text[1]);
    return model;
}

#endif
