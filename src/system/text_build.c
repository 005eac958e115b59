/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/text_build.h"

#include "base/word.h"

#include "system/system.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { locals_max = 400, depth_max = 200 };

/* Displacements or first-order states of one name: `count` members of a family, or a single one (count 0). */
typedef struct quantity {
    const char *name;
    int count, first; /* `first`: index of the first member */
} quantity;

typedef struct quantities {
    quantity *items;
    int count;
} quantities;

typedef struct division {
    int divisor, begin; /* divisor's node, and the operator's position in the text */
    const saltus_parsed *equation;
} division;

/* A graph being built. */
typedef struct builder {
    const saltus_parsed_text *text;
    const double *parameters;
    saltus_equations_graph *made;
    saltus_graph *graph;
    quantities kinds[2]; /* displacements, and first-order states */
    struct {
        const char *name;
        int length;
        double value;
    } local[locals_max];           /* indices of families and sums */
    int locals, own, depth;        /* locals from `own` on belong to the equation being read */
    saltus_list *known;            /* [abbreviation]: the nodes (int) of its members; -1: not known yet */
    saltus_list divisions;         /* division: those by anything but numbers */
    bool restituting;              /* the closing speed may occur in what is being read */
    bool at_rest;                  /* read displacements, velocities and states as zero */
    const saltus_parsed *equation; /* the one being read, for messages */
    saltus_list scratch;           /* void *: temporary arrays */
    saltus_status status;
    saltus_message *message;
} builder;

/* Report an error, if it is the first one; returns node 0, the constant 0, with which callers may go on. */
static int refuse(builder *b, const saltus_expression_term *term, const char *format, ...) {
    char sentence[400];
    va_list arguments;
    if (b->status != SALTUS_OK)
        return 0;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    char place[32] = "";
    if (term)
        snprintf(place, sizeof place, "column %d: ", term->begin + 1);
    b->status = saltus_fail(b->message, SALTUS_BAD_INPUT, "%s:%d: %s: %s%s",
                            b->equation && b->equation->origin ? b->equation->origin : b->text->origin,
                            b->equation ? b->equation->line : 0, b->equation ? b->equation->name : "model",
                            place, sentence);
    return 0;
}

static bool no_memory(builder *b, const void *array) {
    if (!array && b->status == SALTUS_OK)
        b->status = saltus_fail(b->message, SALTUS_NO_MEMORY, "no memory for the equations");
    return !array;
}

void *saltus_text_keep(saltus_list *owned, size_t count, size_t size) {
    void **entry = saltus_list_add(owned, sizeof *entry);
    return entry ? *entry = calloc(count + 1, size) : NULL;
}

void saltus_text_release(saltus_list *owned) {
    for (int k = 0; k < owned->count; k++)
        free(((void **)owned->items)[k]);
    free(owned->items);
    *owned = (saltus_list){.items = NULL};
}

/* Memory that lives as long as the graph or, for scratch, only while building. NULL after an error. */
static void *keep(builder *b, size_t count, size_t size) {
    void *array = saltus_text_keep(&b->made->owned, count, size);
    return no_memory(b, array) ? NULL : array;
}

static void *scratch(builder *b, size_t count, size_t size) {
    void *array = saltus_text_keep(&b->scratch, count, size);
    return no_memory(b, array) ? NULL : array;
}

static bool is_named(const char *name, const char *text, int length) {
    return strncmp(name, text, (size_t)length) == 0 && name[length] == '\0';
}

static int apply(builder *b, saltus_operation operation, int x, int y) {
    return saltus_graph_apply(b->graph, operation, x, y);
}

/* What a node depends on apart from `these`. */
static unsigned depends_beyond(const builder *b, int node, unsigned these) {
    return b->graph->nodes[node].depends & ~these;
}

static int node_of(builder *b, int term);

/* The value of an index or a bound of a sum, which must be a constant whole number. */
static int whole_of(builder *b, int term, const char *what) {
    const saltus_expression_term *t = &b->equation->right.terms[term];
    int node = node_of(b, term);
    const saltus_graph_node *n = &b->graph->nodes[node];
    if (n->operation != SALTUS_OP_CONSTANT || n->value != floor(n->value) || fabs(n->value) > 1e6)
        return refuse(b, t, "%s must be a whole number made of numbers, indices and whole-number parameters",
                      what);
    return (int)n->value;
}

/* The index of the member of a quantity that a term refers to, checked. */
static int member_of(builder *b, const saltus_expression_term *term, const quantity *q) {
    if (q->count == 0 && term->first < 0)
        return q->first;
    if (q->count == 0)
        return refuse(b, term, "%s is not a family and takes no index", q->name);
    if (term->first < 0)
        return refuse(b, term, "%s is a family of %d; say which one, such as %s[1]", q->name, q->count,
                      q->name);
    int index = whole_of(b, term->first, "an index");
    if (index < 1 || index > q->count)
        return refuse(b, term, "%s[%d]: the index must be from 1 to %d", q->name, index, q->count);
    return q->first + index - 1;
}

/* Accepts x3 for x[3], with *number = 3. */
static const quantity *find_quantity(const quantities *list, const char *name, int length, int *number) {
    int digits = 0;
    *number = 0;
    for (int k = 0; k < list->count; k++)
        if (is_named(list->items[k].name, name, length))
            return &list->items[k];
    while (digits < length - 1 && name[length - 1 - digits] >= '0' && name[length - 1 - digits] <= '9')
        digits++;
    if (digits == 0 || digits > 6 || name[length - digits] == '0')
        return NULL;
    for (int k = 0; k < list->count; k++)
        if (list->items[k].count > 0 && is_named(list->items[k].name, name, length - digits)) {
            *number = atoi(name + length - digits);
            return *number <= list->items[k].count ? &list->items[k] : NULL;
        }
    return NULL;
}

static int constant_of(builder *b, const saltus_expression_term *term, const saltus_text_constant *c) {
    const saltus_expression_term *terms = b->equation->right.terms;
    int index[2] = {0, 0}, wanted = (c->rows > 0) + (c->columns > 0), given = 0;
    for (int k = term->first; k >= 0 && given < 3; k = terms[k].next, given++)
        if (given < 2)
            index[given] = whole_of(b, k, "an index");
    if (given != wanted)
        return refuse(b, term, "%s is a %s and takes %d ind%s", c->name,
                      wanted == 0   ? "number"
                      : wanted == 1 ? "vector"
                                    : "matrix",
                      wanted, wanted == 1 ? "ex" : "ices");
    int sizes[2] = {c->rows, c->columns};
    for (int k = 0; k < wanted; k++)
        if (index[k] < 1 || index[k] > sizes[k])
            return refuse(b, term, "%s: index %d must be from 1 to %d", c->name, index[k], sizes[k]);
    int place = wanted == 0 ? 0 : wanted == 1 ? index[0] - 1 : (index[0] - 1) * c->columns + index[1] - 1;
    return saltus_graph_constant(b->graph, c->values[place]);
}

/* Read an equation's right side, with the index bound if its left side has one. */
static int right_side(builder *b, const saltus_parsed *equation, int index) {
    const saltus_parsed *outer = b->equation;
    const int locals = b->locals, own = b->own;
    b->equation = equation;
    if (++b->depth > depth_max || locals == locals_max)
        return refuse(b, NULL, "is defined by itself, or through too many other abbreviations");
    b->own = locals;
    if (equation->index[0]) {
        b->local[locals].name = equation->index;
        b->local[locals].length = (int)strlen(equation->index);
        b->local[locals].value = index;
        b->locals++;
    }
    int node = node_of(b, equation->right.root);
    b->locals = locals;
    b->own = own;
    b->depth--;
    if (b->status == SALTUS_OK)
        b->equation = outer;
    return node;
}

/* The equation of a member: its own if there is one, else the family's. */
static const saltus_parsed *equation_for(const saltus_parsed_list *list, const char *base, int length,
                                         int number) {
    const saltus_parsed *found = NULL;
    for (int k = 0; k < list->count; k++)
        if (is_named(list->items[k].base, base, length)) {
            if (list->items[k].number == number && !list->items[k].index[0])
                return &list->items[k];
            if (list->items[k].index[0] && number > 0)
                found = &list->items[k];
        }
    return found;
}

/* The node of an abbreviation's member, which is read once; -1: no abbreviation has that name. */
static int let_of(builder *b, const saltus_expression_term *term, const char *name) {
    const saltus_parsed_list *let = &b->text->let;
    bool known = false;
    for (int k = 0; k < let->count; k++)
        known |= is_named(let->items[k].base, name, term->length);
    if (!known)
        return -1;
    int number = term->first >= 0 ? whole_of(b, term->first, "an index") : 0;
    if (term->first >= 0 && (number < 1 || number > 100000))
        return refuse(b, term, "%.*s[%d]: an index begins at 1", term->length, name, number);
    const saltus_parsed *equation = equation_for(let, name, term->length, number);
    if (!equation)
        return refuse(b, term, number ? "%.*s[%d] is not defined" : "%.*s needs an index", term->length, name,
                      number);
    if (b->at_rest)
        return right_side(b, equation, number);
    saltus_list *known_of = &b->known[equation - let->items];
    while (known_of->count <= number) {
        int *entry = saltus_list_add(known_of, sizeof *entry);
        if (no_memory(b, entry))
            return 0;
        *entry = -1;
    }
    if (((int *)known_of->items)[number] < 0) {
        const int node = right_side(b, equation, number);
        ((int *)known_of->items)[number] = node;
    }
    return ((int *)known_of->items)[number];
}

static int state_of(builder *b, const saltus_expression_term *term, const char *name) {
    for (int kind = 0; kind < 2; kind++) {
        int number;
        const quantity *q = find_quantity(&b->kinds[kind], name, term->length, &number);
        if (!q)
            continue;
        if (kind && term->rate)
            return refuse(b, term, "%s is a first-order state and has no velocity", q->name);
        int member = number ? q->first + number - 1 : member_of(b, term, q);
        if (b->status != SALTUS_OK || b->at_rest)
            return 0;
        const int first = kind ? 2 * b->made->dof : term->rate ? b->made->dof : 0;
        return saltus_graph_leaf(b->graph, SALTUS_OP_STATE, first + member);
    }
    return -1;
}

/* Report an unknown name and suggest a similar one. */
static int refuse_name(builder *b, const saltus_expression_term *term, const char *name) {
    const saltus_parsed_text *t = b->text;
    const int room =
        t->parameter_count + t->constant_count + t->let.count + b->kinds[0].count + b->kinds[1].count;
    const char **words = scratch(b, (size_t)room, sizeof *words);
    char word[SALTUS_NAME_MAX];
    int count = 0;
    if (!words)
        return 0;
    for (int k = 0; k < t->parameter_count; k++)
        words[count++] = t->parameters[k].name;
    for (int k = 0; k < t->constant_count; k++)
        words[count++] = t->constants[k].name;
    for (int k = 0; k < t->let.count; k++)
        words[count++] = t->let.items[k].base;
    for (int kind = 0; kind < 2; kind++)
        for (int k = 0; k < b->kinds[kind].count; k++)
            words[count++] = b->kinds[kind].items[k].name;
    snprintf(word, sizeof word, "%.*s", term->length, name);
    const char *meant = saltus_nearest_word(word, words, count);
    return refuse(b, term, "%.*s: nothing has this name%s%s%s", term->length, name,
                  meant ? "; did you mean " : "", meant ? meant : "", meant ? "?" : "");
}

static int name_of(builder *b, const saltus_expression_term *term) {
    const char *name = b->equation->right.text + term->begin;
    for (int k = b->locals - 1; k >= b->own; k--)
        if (b->local[k].length == term->length && memcmp(b->local[k].name, name, (size_t)term->length) == 0)
            return saltus_graph_constant(b->graph, b->local[k].value);
    int node = state_of(b, term, name);
    if (node < 0 && term->rate)
        return refuse(b, term, "%.*s is no displacement, so it has no velocity %.*s'", term->length, name,
                      term->length, name);
    for (int k = 0; k < b->text->parameter_count && node < 0; k++)
        if (is_named(b->text->parameters[k].name, name, term->length))
            node = b->text->parameters[k].integer ? saltus_graph_constant(b->graph, b->parameters[k])
                                                  : saltus_graph_leaf(b->graph, SALTUS_OP_PARAMETER, k);
    if (node < 0 && is_named("pi", name, term->length))
        node = saltus_graph_constant(b->graph, 3.14159265358979323846);
    if (node < 0 && is_named("speed", name, term->length))
        node = saltus_graph_leaf(b->graph, SALTUS_OP_SPEED, -1);
    const bool time = is_named("t", name, term->length);
    if (node < 0 && (time || is_named("phase", name, term->length)))
        node =
            b->text->forcing
                ? saltus_graph_leaf(b->graph, time ? SALTUS_OP_TIME : SALTUS_OP_PHASE, -1)
                : refuse(b, term, "%.*s: the system has no forcing; name its angular frequency under forcing",
                         term->length, name);
    for (int k = 0; k < b->text->constant_count && node < 0; k++)
        if (is_named(b->text->constants[k].name, name, term->length))
            node = constant_of(b, term, &b->text->constants[k]);
    if (node < 0)
        node = let_of(b, term, name);
    if (node < 0)
        return refuse_name(b, term, name);
    /* Also in an abbreviation that a restitution has used before. */
    if (!b->restituting && b->graph->nodes[node].depends & SALTUS_OF_SPEED)
        return refuse(b, term, "speed: the closing speed belongs to a restitution r");
    return node;
}

static bool switches(builder *b, const saltus_expression_term *term, int node) {
    if (b->status == SALTUS_OK && depends_beyond(b, node, SALTUS_OF_PARAMETERS))
        refuse(b, term, "%s of a state or of time switches the equations, which is not possible yet",
               saltus_function_name(term->function));
    return b->status == SALTUS_OK;
}

/* if(a < b, yes, no). If constants decide, the other branch is not even read. */
static int choice_of(builder *b, const saltus_expression_term *term) {
    static const saltus_operation choices[] = {[SALTUS_SYNTAX_LESS] = SALTUS_OP_CHOOSE_LESS,
                                               [SALTUS_SYNTAX_LESS_EQUAL] = SALTUS_OP_CHOOSE_LESS_EQUAL,
                                               [SALTUS_SYNTAX_GREATER] = SALTUS_OP_CHOOSE_LESS,
                                               [SALTUS_SYNTAX_GREATER_EQUAL] = SALTUS_OP_CHOOSE_LESS_EQUAL,
                                               [SALTUS_SYNTAX_EQUAL] = SALTUS_OP_CHOOSE_EQUAL,
                                               [SALTUS_SYNTAX_UNEQUAL] = SALTUS_OP_CHOOSE_EQUAL};
    const saltus_expression_term *terms = b->equation->right.terms, *test = &terms[term->first];
    int x = node_of(b, test->first), y = node_of(b, terms[test->first].next);
    const int yes = test->next, no = terms[yes].next;
    const bool turned = test->kind == SALTUS_SYNTAX_GREATER || test->kind == SALTUS_SYNTAX_GREATER_EQUAL;
    const bool exchanged = test->kind == SALTUS_SYNTAX_UNEQUAL;
    if (turned) {
        const int other = x;
        x = y;
        y = other;
    }
    const saltus_graph_node *p = &b->graph->nodes[x], *q = &b->graph->nodes[y];
    if (b->status == SALTUS_OK && p->operation == SALTUS_OP_CONSTANT && q->operation == SALTUS_OP_CONSTANT) {
        const double operand[] = {p->value, q->value, !exchanged, exchanged};
        return node_of(b, saltus_operation_value(choices[test->kind], operand) != 0 ? yes : no);
    }
    if (!switches(b, term, x) || !switches(b, term, y))
        return 0;
    const int first = node_of(b, yes), second = node_of(b, no);
    return saltus_graph_choose(b->graph, choices[test->kind], x, y, exchanged ? second : first,
                               exchanged ? first : second);
}

/* sum(i, first, last, what): zero if last is below first. */
static int sum_of(builder *b, const saltus_expression_term *term) {
    const saltus_expression_term *terms = b->equation->right.terms, *index = &terms[term->first];
    int from = index->next, to = terms[from].next, what = terms[to].next, sum = 0;
    if (index->kind != SALTUS_SYNTAX_NAME || index->rate || index->first >= 0)
        return refuse(b, index, "the first argument of sum must be the name of an index, such as i");
    int first = whole_of(b, from, "the first index of a sum"),
        last = whole_of(b, to, "the last index of a sum");
    if (b->locals == locals_max)
        return refuse(b, term, "sums are nested too deeply");
    int local = b->locals++;
    b->local[local].name = b->equation->right.text + index->begin;
    b->local[local].length = index->length;
    for (int i = first; i <= last && b->status == SALTUS_OK && !b->graph->full; i++) {
        b->local[local].value = i;
        sum = apply(b, SALTUS_OP_ADD, sum, node_of(b, what));
    }
    b->locals--;
    return sum;
}

static int call_of(builder *b, const saltus_expression_term *term) {
    const saltus_expression_term *terms = b->equation->right.terms;
    if (term->function == SALTUS_FUNCTION_if)
        return choice_of(b, term);
    if (term->function == SALTUS_FUNCTION_sum)
        return sum_of(b, term);
    int node = node_of(b, term->first), next = terms[term->first].next;
    const bool smooth = term->function <= SALTUS_FUNCTION_tanh;
    const saltus_operation operation = saltus_function_operation(term->function);
    if (!smooth && !switches(b, term, node))
        return 0;
    if (term->function == SALTUS_FUNCTION_sign && next >= 0)
        return refuse(b, term, "dry friction, sign(s, k), is not possible yet");
    if (next < 0)
        return apply(b, operation, node, -1);
    for (; next >= 0 && b->status == SALTUS_OK; next = terms[next].next) {
        int other = node_of(b, next);
        if (!smooth && !switches(b, term, other))
            return 0;
        node = apply(b, operation, node, other);
    }
    return node;
}

/* Refuse divisors that are zero at all test points. Parameters are varied, too. */
static void check_divisions(builder *b) {
    enum { points = 3 };
    double *values = scratch(b, (size_t)b->graph->count, sizeof *values), state[SALTUS_STATE_MAX];
    double *parameters = scratch(b, (size_t)b->text->parameter_count, sizeof *parameters);
    bool *zero = scratch(b, (size_t)b->divisions.count, sizeof *zero);
    const division *all = b->divisions.items;
    for (int point = 0; point < points && b->status == SALTUS_OK; point++) {
        for (int i = 0; i < SALTUS_STATE_MAX; i++)
            state[i] = 0.7 + 0.3 * sin(1.9 * i + 2.3 * point);
        for (int k = 0; k < b->text->parameter_count; k++)
            parameters[k] = b->parameters[k] * (1 + 0.1 * sin(1.1 * k + point)) + 0.05 * cos(k + 1.7 * point);
        saltus_graph_evaluate(b->graph, parameters, state, 0.31 + 0.2 * point, 0.05 + 0.11 * point, values);
        for (int k = 0; k < b->divisions.count; k++)
            zero[k] = (zero[k] || point == 0) && fabs(values[all[k].divisor]) < 1e-14;
    }
    for (int k = 0; k < b->divisions.count && b->status == SALTUS_OK; k++)
        if (zero[k]) {
            b->equation = all[k].equation;
            refuse(b, &(saltus_expression_term){.begin = all[k].begin},
                   "a division by what is zero everywhere");
        }
}

/* The node of a term of the equation being read. After an error b->equation may be a different equation, the
 * one at fault: take an equation's terms before calling this. */
static int node_of(builder *b, int term) {
    const saltus_expression_term *terms = b->equation->right.terms, *t = &terms[term];
    static const saltus_operation operations[] = {
        [SALTUS_SYNTAX_ADD] = SALTUS_OP_ADD,           [SALTUS_SYNTAX_SUBTRACT] = SALTUS_OP_SUBTRACT,
        [SALTUS_SYNTAX_MULTIPLY] = SALTUS_OP_MULTIPLY, [SALTUS_SYNTAX_DIVIDE] = SALTUS_OP_DIVIDE,
        [SALTUS_SYNTAX_POWER] = SALTUS_OP_POWER,
    };
    if (b->status != SALTUS_OK)
        return 0;
    switch (t->kind) {
    case SALTUS_SYNTAX_NUMBER:
        return saltus_graph_constant(b->graph, t->number);
    case SALTUS_SYNTAX_NAME:
        return name_of(b, t);
    case SALTUS_SYNTAX_CALL:
        return call_of(b, t);
    case SALTUS_SYNTAX_NEGATE:
        return apply(b, SALTUS_OP_SUBTRACT, 0, node_of(b, t->first));
    default:
        break;
    }
    int left = node_of(b, t->first), right = node_of(b, terms[t->first].next);
    const saltus_graph_node *divisor = t->kind == SALTUS_SYNTAX_DIVIDE ? &b->graph->nodes[right] : NULL;
    if (divisor && divisor->operation == SALTUS_OP_CONSTANT && divisor->value == 0)
        return refuse(b, t, "a division by zero");
    if (divisor && divisor->operation != SALTUS_OP_CONSTANT) {
        division *entry = saltus_list_add(&b->divisions, sizeof *entry);
        if (no_memory(b, entry))
            return 0;
        *entry = (division){right, t->begin, b->equation};
    }
    return apply(b, operations[t->kind], left, right);
}

/* List displacements or states and their family sizes in the order of the text. Returns the number of
 * members. */
static int lay_out(builder *b, const saltus_parsed_list *list, quantities *made) {
    int total = 0;
    made->items = keep(b, (size_t)list->count, sizeof *made->items);
    for (int k = 0; k < list->count && b->status == SALTUS_OK; k++) {
        const saltus_parsed *e = &list->items[k];
        int j = 0;
        while (j < made->count && strcmp(made->items[j].name, e->base) != 0)
            j++;
        if (j < made->count)
            continue;
        int members = 0;
        for (int f = 0; f < b->text->families.count && b->status == SALTUS_OK; f++)
            if (strcmp(b->text->families.items[f].base, e->base) == 0) {
                b->equation = &b->text->families.items[f];
                members = whole_of(b, b->equation->right.root, "the size of a family");
                if (members < 1 || members > SALTUS_STATE_MAX)
                    refuse(b, NULL, "%d members: must be from 1 to %d", members, SALTUS_STATE_MAX);
            }
        b->equation = e;
        if (b->status == SALTUS_OK && !members && (e->index[0] || e->number))
            refuse(b, NULL, "%s is not among the families", e->base);
        if (b->status == SALTUS_OK && members && !e->index[0] && !e->number)
            refuse(b, NULL, "%s is a family: write %s[i], or %s[1] for one member", e->base, e->base,
                   e->base);
        made->items[made->count++] = (quantity){e->base, members, total};
        total += members ? members : 1;
    }
    b->equation = NULL;
    return total;
}

/* Read names and right sides of all members of all quantities, into the field from `first` on. */
static void read_members(builder *b, const saltus_parsed_list *equations, const quantities *list, int first) {
    for (int i = 0; i < list->count; i++) {
        const quantity *q = &list->items[i];
        for (int j = 0; j < (q->count ? q->count : 1) && b->status == SALTUS_OK; j++) {
            const int number = q->count ? j + 1 : 0, place = first + q->first + j;
            const saltus_parsed *e = equation_for(equations, q->name, (int)strlen(q->name), number);
            if (number)
                snprintf(b->made->names[place], SALTUS_NAME_MAX, "%.20s%d", q->name, number);
            else
                snprintf(b->made->names[place], SALTUS_NAME_MAX, "%s", q->name);
            if (!e)
                refuse(b, NULL, "%s[%d] has no equation", q->name, number);
            else
                b->made->field[place] = right_side(b, e, number);
        }
    }
}

/* The displacement that a name on a left side refers to; -1 after an error. */
static int displacement_named(builder *b, const char *name) {
    for (int i = 0; i < b->made->dof; i++)
        if (strcmp(b->made->names[i], name) == 0)
            return i;
    refuse(b, NULL, "%s is no displacement", name);
    return -1;
}

/* Read the entries of the mass matrix that an equation sets: one, a family's, or a pair. */
static void read_mass(builder *b, const saltus_parsed *e, int *mass, bool *given) {
    const int n = b->made->dof;
    const char *comma = strchr(e->name, ',');
    b->equation = e;
    if (comma) {
        char first[SALTUS_NAME_MAX];
        snprintf(first, sizeof first, "%.*s", (int)(comma - e->name), e->name);
        int i = displacement_named(b, first), j = i < 0 ? -1 : displacement_named(b, comma + 1);
        int node = j < 0 ? 0 : right_side(b, e, 0);
        if (b->status == SALTUS_OK && given[i * n + j] && mass[i * n + j] != node)
            refuse(b, NULL, "the mass matrix is not symmetric");
        if (b->status == SALTUS_OK) {
            mass[i * n + j] = mass[j * n + i] = node;
            given[i * n + j] = given[j * n + i] = true;
        }
        return;
    }
    bool found = false;
    for (int k = 0; k < b->kinds[0].count; k++) {
        const quantity *q = &b->kinds[0].items[k];
        for (int j = 0; j < (q->count ? q->count : 1) && b->status == SALTUS_OK; j++) {
            const int i = q->first + j;
            const bool same = strcmp(q->name, e->base) == 0, family = e->index[0] && same;
            const bool one = !e->index[0] && (strcmp(b->made->names[i], e->name) == 0 ||
                                              (same && e->number == (q->count ? j + 1 : 0)));
            if (!family && !one)
                continue;
            found = true;
            if (one || !given[i * n + i])
                mass[i * n + i] = right_side(b, e, j + 1);
            given[i * n + i] = true;
        }
    }
    if (!found)
        refuse(b, NULL, "%s is no displacement", e->name);
}

/* Invert the mass matrix, entry by entry as nodes (Gauss-Jordan without pivoting: it is positive definite),
 * and divide the forces by it. */
static void divide_by_mass(builder *b) {
    const int n = b->made->dof;
    int *mass = scratch(b, (size_t)n * (size_t)n, sizeof *mass), *inverse = b->made->inverse_mass;
    bool *given = scratch(b, (size_t)n * (size_t)n, sizeof *given);
    int *sum = scratch(b, (size_t)n, sizeof *sum), *force = b->made->field;
    if (b->status != SALTUS_OK)
        return;
    for (int i = 0; i < n; i++)
        inverse[i * n + i] = mass[i * n + i] = saltus_graph_constant(b->graph, 1);
    for (int k = 0; k < b->text->mass.count && b->status == SALTUS_OK; k++)
        read_mass(b, &b->text->mass.items[k], mass, given);
    for (int k = 0; k < n * n && b->status == SALTUS_OK; k++)
        if (depends_beyond(b, mass[k], SALTUS_OF_PARAMETERS))
            refuse(b, NULL, "mass: one that depends on the state or on time is not possible yet");
    for (int p = 0; p < n && b->status == SALTUS_OK && b->text->mass.count; p++) {
        int *row = &mass[p * n], *other = &inverse[p * n], pivot = row[p];
        for (int j = 0; j < n; j++) {
            row[j] = apply(b, SALTUS_OP_DIVIDE, row[j], pivot);
            other[j] = apply(b, SALTUS_OP_DIVIDE, other[j], pivot);
        }
        for (int i = 0; i < n; i++) {
            int factor = mass[i * n + p];
            for (int j = 0; j < n && i != p && factor != 0; j++) {
                int a = apply(b, SALTUS_OP_MULTIPLY, factor, row[j]);
                int c = apply(b, SALTUS_OP_MULTIPLY, factor, other[j]);
                mass[i * n + j] = apply(b, SALTUS_OP_SUBTRACT, mass[i * n + j], a);
                inverse[i * n + j] = apply(b, SALTUS_OP_SUBTRACT, inverse[i * n + j], c);
            }
        }
    }
    for (int i = 0; i < n && b->status == SALTUS_OK; i++)
        for (int j = 0; j < n; j++)
            sum[i] =
                apply(b, SALTUS_OP_ADD, sum[i], apply(b, SALTUS_OP_MULTIPLY, inverse[i * n + j], force[j]));
    memcpy(force, sum, (size_t)n * sizeof *sum);
}

/* The derivatives of a node by the displacements. False: some depend on more than parameters. */
static bool make_row(builder *b, int node, int *row) {
    const int count = node + 1;
    bool *needed = scratch(b, (size_t)b->graph->count, sizeof *needed), constant = true;
    int *derivatives = scratch(b, (size_t)count, sizeof *derivatives);
    if (b->status != SALTUS_OK)
        return constant;
    saltus_graph_mark(b->graph, &node, 1, NULL, needed);
    for (int i = 0; i < b->made->dof; i++) {
        int leaf = saltus_graph_leaf(b->graph, SALTUS_OP_STATE, i);
        saltus_graph_differentiate(b->graph, leaf, count, ~0u, needed, derivatives);
        row[i] = derivatives[node];
        constant = constant && !depends_beyond(b, row[i], SALTUS_OF_PARAMETERS);
    }
    return constant;
}

/* Read a stop's coordinate, which must be linear in the displacements with factors of parameters alone. */
static void read_coordinate(builder *b, const saltus_parsed *e, saltus_stop_nodes *made) {
    const int n = b->made->dof;
    made->normal = keep(b, (size_t)n, sizeof *made->normal);
    b->equation = e;
    int coordinate = right_side(b, e, 0), rest = coordinate;
    if (b->graph->nodes[coordinate].depends & SALTUS_OF_TIME)
        refuse(b, NULL, "a coordinate that moves in time is not possible yet");
    if (!make_row(b, coordinate, made->normal))
        refuse(b, NULL, "a coordinate that is not linear in the displacements is not possible yet");
    for (int i = 0; i < n && b->status == SALTUS_OK; i++) {
        int leaf = saltus_graph_leaf(b->graph, SALTUS_OP_STATE, i);
        rest = apply(b, SALTUS_OP_SUBTRACT, rest, apply(b, SALTUS_OP_MULTIPLY, made->normal[i], leaf));
    }
    if (b->status != SALTUS_OK)
        return;
    b->at_rest = true;
    made->offset = right_side(b, e, 0);
    b->at_rest = false;
    /* Without the terms of the displacements only the constant must be left. */
    double *values = scratch(b, (size_t)b->graph->count, sizeof *values), state[SALTUS_STATE_MAX];
    if (!values)
        return;
    for (int i = 0; i < SALTUS_STATE_MAX; i++)
        state[i] = 0.3 + 0.1 * sin(1.0 + i);
    saltus_graph_evaluate(b->graph, b->parameters, state, 0.3, 0.2, values);
    double size = fabs(values[made->offset]), left = values[rest] - values[made->offset];
    for (int i = 0; i < n; i++)
        size += fabs(values[made->normal[i]]);
    if (b->status == SALTUS_OK && !(fabs(left) <= 1e-12 * size))
        refuse(b, NULL,
               "must be a sum of displacements times numbers, and a number; another dependence is not "
               "possible yet");
}

/* Read a stop: coordinate, clearance, restitution and, if that depends on the closing speed, the derivative
 * of the rebound speed by the closing speed. */
static void read_stop(builder *b, int s) {
    const saltus_parsed *const e[] = {&b->text->clearances.items[s], &b->text->restitutions.items[s]};
    saltus_stop_nodes *made = &b->made->stops[s];
    int *const nodes[] = {&made->clearance, &made->restitution};
    read_coordinate(b, &b->text->coordinates.items[s], made);
    made->rebound = -1;
    for (int k = 0; k < 2 && b->status == SALTUS_OK; k++) {
        b->restituting = k == 1;
        *nodes[k] = e[k]->text ? right_side(b, e[k], 0) : -1;
        b->restituting = false;
    }
    for (int k = 0; k < 2 && b->status == SALTUS_OK; k++) {
        b->equation = e[k];
        if (*nodes[k] >= 0 &&
            depends_beyond(b, *nodes[k], k ? SALTUS_OF_PARAMETERS | SALTUS_OF_SPEED : SALTUS_OF_PARAMETERS))
            refuse(b, NULL, "must be made of numbers and parameters%s", k ? ", and the closing speed" : "");
    }
    const int r = made->restitution;
    if (b->status != SALTUS_OK || r < 0 || !(b->graph->nodes[r].depends & SALTUS_OF_SPEED))
        return;
    const int speed = saltus_graph_leaf(b->graph, SALTUS_OP_SPEED, -1), count = b->graph->count;
    int *derivatives = scratch(b, (size_t)count, sizeof *derivatives);
    if (!derivatives)
        return;
    saltus_graph_differentiate(b->graph, speed, count, SALTUS_OF_PARAMETERS | SALTUS_OF_SPEED, NULL,
                               derivatives);
    made->rebound = apply(b, SALTUS_OP_ADD, r, apply(b, SALTUS_OP_MULTIPLY, speed, derivatives[r]));
    if (!(saltus_graph_ways(b->graph, made->rebound) <= SALTUS_AT_SPEED_MAX))
        refuse(b, NULL, "is too long for a restitution");
}

/* Read numbers that are listed by the names of states: scale and initial. */
static void read_by_state(builder *b, const saltus_parsed_list *list, bool initial) {
    const int n = b->made->dof, all = n + b->made->extra;
    for (int k = 0; k < list->count && b->status == SALTUS_OK; k++) {
        const saltus_parsed *e = b->equation = &list->items[k];
        int i = 0, node = right_side(b, e, 0);
        size_t length = strlen(e->name);
        bool rate = length > 1 && e->name[length - 1] == '\'';
        bool dotted = length > 4 && strcmp(e->name + length - 4, "_dot") == 0;
        while (i < all && !is_named(b->made->names[i], e->name, (int)(length - (rate ? 1 : dotted ? 4 : 0))))
            i++;
        if (i == all || ((rate || dotted) && i >= n))
            refuse(b, NULL, "%s is no displacement, velocity or state", e->name);
        else if (depends_beyond(b, node, SALTUS_OF_PARAMETERS))
            refuse(b, NULL, "must be made of numbers and parameters");
        else {
            saltus_state_nodes *made = &b->made->state[i >= n || rate || dotted ? i + n : i];
            *(initial ? &made->initial : &made->scale) = node;
        }
    }
}

/* Make a part of roots and all nodes that they consist of. */
static void make_part(builder *b, saltus_graph_part *part, const int *roots, int count) {
    bool *needed = scratch(b, (size_t)b->graph->count, sizeof *needed);
    part->roots = keep(b, (size_t)count, sizeof *roots);
    part->nodes = keep(b, (size_t)b->graph->count, sizeof *part->nodes);
    if (b->status != SALTUS_OK)
        return;
    memcpy(part->roots, roots, (size_t)count * sizeof *roots);
    part->root_count = count;
    saltus_graph_mark(b->graph, roots, count, NULL, needed);
    for (int k = 0; k < b->graph->count; k++)
        if (needed[k])
            part->nodes[part->count++] = k;
}

/* The trace: the sum of the derivatives of each rate by its own velocity or state. */
static void add_trace(builder *b) {
    const int n = b->made->dof, count = b->graph->count;
    int *derivatives = scratch(b, (size_t)count, sizeof *derivatives), trace = 0;
    for (int i = 0; i < n + b->made->extra && derivatives && !b->graph->full; i++) {
        int leaf = saltus_graph_leaf(b->graph, SALTUS_OP_STATE, n + i);
        if (leaf >= count)
            continue; /* nothing depends on it */
        saltus_graph_differentiate(b->graph, leaf, count, ~0u, NULL, derivatives);
        trace = apply(b, SALTUS_OP_ADD, trace, derivatives[b->made->field[i]]);
    }
    make_part(b, &b->made->trace, &trace, 1);
}

/* Find the terms of the field that have no value at some states. Poles do not count: steps shrink before
 * them. */
static void find_partial(builder *b) {
    const saltus_graph *g = b->graph;
    bool *field = scratch(b, (size_t)g->count, sizeof *field);
    int *roots = scratch(b, (size_t)g->count, sizeof *roots), count = 0;
    if (b->status != SALTUS_OK)
        return;
    saltus_graph_mark(g, b->made->field, b->made->dof + b->made->extra, NULL, field);
    for (int k = 0; k < g->count; k++) {
        const saltus_operation operation = g->nodes[k].operation;
        bool partial = operation == SALTUS_OP_SQRT || operation == SALTUS_OP_LOG ||
                       operation == SALTUS_OP_ASIN || operation == SALTUS_OP_ACOS;
        if (operation == SALTUS_OP_POWER) {
            const saltus_graph_node *exponent = &g->nodes[g->nodes[k].operand[1]];
            partial = exponent->operation != SALTUS_OP_CONSTANT || exponent->value != floor(exponent->value);
        }
        if (field[k] && partial && depends_beyond(b, k, SALTUS_OF_PARAMETERS))
            roots[count++] = k;
    }
    make_part(b, &b->made->partial, roots, count);
}

/* Derivatives of all nodes of parameters by each parameter; the tape differentiates those of states. */
static void add_derivatives(builder *b) {
    saltus_equations_graph *made = b->made;
    const int count = b->graph->count;
    for (int p = 0; p < b->text->parameter_count && b->status == SALTUS_OK; p++) {
        if (b->text->parameters[p].integer)
            continue;
        made->derivatives[p] = keep(b, (size_t)count, sizeof **made->derivatives);
        int leaf = saltus_graph_leaf(b->graph, SALTUS_OP_PARAMETER, p);
        if (made->derivatives[p])
            saltus_graph_differentiate(b->graph, leaf, count, SALTUS_OF_PARAMETERS | SALTUS_OF_SPEED, NULL,
                                       made->derivatives[p]);
    }
}

/* Determine the sizes and allocate the arrays. */
static void open_graph(builder *b) {
    const saltus_parsed_text *text = b->text;
    saltus_equations_graph *made = b->made;
    const size_t parameters = (size_t)text->parameter_count;
    b->known = keep(b, (size_t)text->let.count, sizeof *b->known);
    made->derivatives = keep(b, parameters, sizeof *made->derivatives);
    made->parameters = keep(b, parameters, sizeof *made->parameters);
    if (b->status != SALTUS_OK || no_memory(b, saltus_graph_open(b->graph) ? b : NULL))
        return;
    memcpy(made->parameters, b->parameters, parameters * sizeof *made->parameters);
    made->dof = lay_out(b, &text->motion, &b->kinds[0]);
    made->extra = lay_out(b, &text->states, &b->kinds[1]);
    const int n = made->dof, dimension = 2 * n + made->extra;
    if (b->status == SALTUS_OK && (n > SALTUS_MODES_MAX || dimension > SALTUS_STATE_MAX))
        refuse(
            b, NULL,
            "%d displacements and %d states: at most %d displacements and a state of %d numbers are possible",
            n, made->extra, SALTUS_MODES_MAX, SALTUS_STATE_MAX);
    if (b->status != SALTUS_OK)
        return;
    made->stop_count = text->coordinates.count;
    made->observed_count = text->observe.count;
    made->field = keep(b, (size_t)(n + made->extra), sizeof *made->field);
    made->names = keep(b, (size_t)(n + made->extra), sizeof *made->names);
    made->inverse_mass = keep(b, (size_t)n * (size_t)n, sizeof *made->inverse_mass);
    made->stops = keep(b, (size_t)made->stop_count, sizeof *made->stops);
    made->observed = keep(b, (size_t)made->observed_count, sizeof *made->observed);
    made->state = keep(b, (size_t)dimension, sizeof *made->state);
    for (int i = 0; i < dimension && b->status == SALTUS_OK; i++)
        made->state[i] = (saltus_state_nodes){-1, -1};
}

static void build(builder *b) {
    const saltus_parsed_text *text = b->text;
    saltus_equations_graph *made = b->made;
    open_graph(b);
    if (b->status != SALTUS_OK)
        return;
    const int n = made->dof, all = n + made->extra;
    read_members(b, &text->motion, &b->kinds[0], 0);
    read_members(b, &text->states, &b->kinds[1], n);
    if (b->status == SALTUS_OK)
        divide_by_mass(b);
    for (int s = 0; s < made->stop_count && b->status == SALTUS_OK; s++) {
        read_stop(b, s);
        saltus_text_release(&b->scratch);
    }
    /* Observed quantities, and the rows of those that are sums of displacements. */
    for (int k = 0; k < made->observed_count && b->status == SALTUS_OK; k++) {
        saltus_observed_nodes *own = &made->observed[k];
        b->equation = &text->observe.items[k];
        own->row = keep(b, (size_t)n, sizeof *own->row);
        own->node = right_side(b, b->equation, 0);
        own->sum = b->status == SALTUS_OK && make_row(b, own->node, own->row);
        saltus_text_release(&b->scratch);
    }
    if (b->status == SALTUS_OK && text->zero.count) { /* the expression whose zeros are the section */
        b->equation = &text->zero.items[0];
        const int zero = right_side(b, b->equation, 0);
        if (!depends_beyond(b, zero, SALTUS_OF_PARAMETERS | SALTUS_OF_TIME))
            refuse(b, NULL, "must depend on the state");
        make_part(b, &made->zero, &zero, 1);
    }
    read_by_state(b, &text->scale, false);
    read_by_state(b, &text->initial, true);
    b->equation = NULL;
    if (b->status == SALTUS_OK)
        check_divisions(b);
    if (b->status != SALTUS_OK)
        return;
    for (int i = 0; i < all; i++)
        made->forced |= (b->graph->nodes[made->field[i]].depends & SALTUS_OF_TIME) != 0;
    find_partial(b);
    add_trace(b);
    made->tape = saltus_tape_new(b->graph, made->field, all, n, n + all);
    if (made->tape)
        add_derivatives(b);
    if (b->graph->full && 2 * b->graph->room > SALTUS_GRAPH_NODES_MAX)
        refuse(b, NULL, "the equations have too many terms");
    no_memory(b, b->graph->full ? NULL : made->tape);
}

saltus_status saltus_equations_graph_new(const saltus_parsed_text *text, const double *parameters,
                                         saltus_equations_graph **made, saltus_message *message) {
    builder b = {
        .text = text, .parameters = parameters, .made = calloc(1, sizeof *b.made), .message = message};
    *made = b.made;
    if (no_memory(&b, b.made))
        return b.status;
    b.graph = &b.made->graph;
    build(&b);
    for (int k = 0; b.known && k < text->let.count; k++)
        free(b.known[k].items);
    free(b.divisions.items);
    saltus_text_release(&b.scratch);
    if (b.status != SALTUS_OK) {
        saltus_equations_graph_free(b.made);
        *made = NULL;
    }
    return b.status;
}

void saltus_equations_graph_free(saltus_equations_graph *g) {
    if (!g)
        return;
    saltus_text_release(&g->owned);
    saltus_tape_free(g->tape);
    saltus_graph_close(&g->graph);
    free(g);
}

saltus_status saltus_constant_value(const char *text, double *value, saltus_message *message) {
    char name[] = "number", own[1] = "";
    saltus_parsed equation = {.name = name, .text = own};
    saltus_parsed_text nothing = {.origin = own};
    saltus_graph graph = {.full = false};
    builder b = {.text = &nothing, .graph = &graph, .equation = &equation, .message = message};
    saltus_status status = saltus_expression_parse(text, &equation.right, message);
    if (status != SALTUS_OK)
        return status;
    b.made = calloc(1, sizeof *b.made);
    if (!no_memory(&b, b.made) && !no_memory(&b, saltus_graph_open(&graph) ? b.made : NULL)) {
        int node = node_of(&b, equation.right.root);
        if (b.status == SALTUS_OK && !isfinite(graph.nodes[node].value))
            refuse(&b, NULL, "must be a finite number");
        if (b.status == SALTUS_OK)
            *value = graph.nodes[node].value;
    }
    free(b.divisions.items);
    saltus_text_release(&b.scratch);
    saltus_graph_close(&graph);
    saltus_expression_clear(&equation.right);
    free(b.made);
    return b.status;
}
