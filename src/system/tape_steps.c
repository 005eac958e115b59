/* Makes steps on registers from the nodes of a graph.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/tape_steps.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Steps being made. place[node] is a node's register, -1 if it has none yet. */
typedef struct maker {
    saltus_graph *graph;
    saltus_tape_steps *made;
    int *place, *slot_of, *uses;
    int dof;
    int placed; /* capacity of `place`, `slot_of` and `uses` in nodes */
    saltus_list steps, terms, slots, depends, linear;
    saltus_list sums, parts; /* sums that have been factored out (shared_sum, part) */
    bool failed;
} maker;

/* A term of a sum: factor times node. Factors depend on parameters alone; node -1: the factor alone. */
typedef struct summand {
    int factor, node;
} summand;

/* Append a copy of an entry. */
static void push(maker *m, saltus_list *list, const void *entry, size_t size) {
    void *copy = saltus_list_grow(list, size, &m->failed);
    if (copy)
        memcpy(copy, entry, size);
}

static void add_summand(maker *m, saltus_list *sum, summand s) {
    push(m, sum, &s, sizeof s);
}

/* Enlarge the arrays after nodes were added to the graph. False after a failure. */
static bool follow_graph(maker *m) {
    int count = m->graph->count;
    int **const arrays[] = {&m->place, &m->slot_of, &m->uses};
    m->failed = m->failed || m->graph->full;
    if (m->failed || count <= m->placed)
        return !m->failed;
    for (int k = 0; k < 3; k++) {
        int *longer = realloc(*arrays[k], 2 * (size_t)count * sizeof *longer);
        if (!longer) {
            m->failed = true;
            return false;
        }
        for (int j = m->placed; j < 2 * count; j++)
            longer[j] = k < 2 ? -1 : 0;
        *arrays[k] = longer;
    }
    m->placed = 2 * count;
    return true;
}

static const saltus_graph_node *node_at(const maker *m, int node) {
    return &m->graph->nodes[node];
}

static int apply(maker *m, saltus_operation operation, int a, int b) {
    return saltus_graph_apply(m->graph, operation, a, b);
}

static int constant(maker *m, double value) {
    return saltus_graph_constant(m->graph, value);
}

static bool is_number(const maker *m, int node) {
    return (node_at(m, node)->depends & ~(unsigned)SALTUS_OF_PARAMETERS) == 0;
}

static int slot_of(maker *m, int node) {
    if (!follow_graph(m))
        return 0;
    if (m->slot_of[node] < 0) {
        m->slot_of[node] = m->slots.count;
        push(m, &m->slots, &node, sizeof node);
    }
    return m->slot_of[node];
}

static int new_register(maker *m, unsigned depends, bool linear) {
    push(m, &m->depends, &depends, sizeof depends);
    push(m, &m->linear, &linear, sizeof linear);
    return m->failed ? 0 : m->depends.count - 1;
}

static bool is_linear(const maker *m, int place) {
    return ((const bool *)m->linear.items)[place];
}

static int add_step(maker *m, saltus_tape_step step) {
    if (step.out < 0)
        step.out = new_register(m, step.depends, step.code == SALTUS_TAPE_COMBINE && step.linear);
    push(m, &m->steps, &step, sizeof step);
    return step.out;
}

/* The register of a node, made if it has none yet. A function brings its derivative along, which may contain
 * the very node that asked for the function, as tanh(x)^2 does for tanh(x): callers that requested registers
 * of operands must check whether their own node has got one meanwhile. */
static int register_of(maker *m, int node);

/* The value of a constant whole number between -8 and 8; else 0. */
static int small_power(const maker *m, int node) {
    double value = node_at(m, node)->value;
    return node_at(m, node)->operation == SALTUS_OP_CONSTANT && fabs(value) <= 8 && value == floor(value)
               ? (int)value
               : 0;
}

/* A power: by products for a small whole exponent, else by exp and log. */
static int rewrite_power(maker *m, int a, int b) {
    int power = small_power(m, b), result = a;
    if (!power)
        return apply(m, SALTUS_OP_EXP, apply(m, SALTUS_OP_MULTIPLY, b, apply(m, SALTUS_OP_LOG, a, -1)), -1);
    /* Repeated squaring: x^6 = (x x^2)^2. */
    for (int bit = 1 << (int)log2(abs(power)) >> 1; bit > 0; bit >>= 1) {
        result = apply(m, SALTUS_OP_MULTIPLY, result, result);
        if (abs(power) & bit)
            result = apply(m, SALTUS_OP_MULTIPLY, a, result);
    }
    return power > 0 ? result : apply(m, SALTUS_OP_DIVIDE, constant(m, 1), result);
}

/* Split a node into a factor of parameters and a node without such a factor. */
static summand split(maker *m, int node) {
    saltus_graph *g = m->graph;
    summand s = {constant(m, 1), node};
    for (;;) {
        const saltus_graph_node n = g->nodes[s.node];
        if (n.operation == SALTUS_OP_MULTIPLY && is_number(m, n.operand[0])) {
            s.factor = apply(m, SALTUS_OP_MULTIPLY, s.factor, n.operand[0]);
            s.node = n.operand[1];
        } else if (n.operation == SALTUS_OP_MULTIPLY && is_number(m, n.operand[1])) {
            s.factor = apply(m, SALTUS_OP_MULTIPLY, s.factor, n.operand[1]);
            s.node = n.operand[0];
        } else if (n.operation == SALTUS_OP_DIVIDE && is_number(m, n.operand[1])) {
            s.factor = apply(m, SALTUS_OP_DIVIDE, s.factor, n.operand[1]);
            s.node = n.operand[0];
        } else if (n.operation == SALTUS_OP_POWER && small_power(m, n.operand[1]) > 1) {
            /* (c x)^2 = c^2 x^2; the product takes over the power's use count. */
            const int power = s.node;
            s.node = rewrite_power(m, n.operand[0], n.operand[1]);
            if (!follow_graph(m))
                return s;
            m->uses[s.node] = m->uses[s.node] > m->uses[power] ? m->uses[s.node] : m->uses[power];
        } else if (n.operation == SALTUS_OP_MULTIPLY) {
            /* (c x) (d y) = (c d) (x y) */
            summand a = split(m, n.operand[0]), b = split(m, n.operand[1]);
            s.factor =
                apply(m, SALTUS_OP_MULTIPLY, s.factor, apply(m, SALTUS_OP_MULTIPLY, a.factor, b.factor));
            s.node = apply(m, SALTUS_OP_MULTIPLY, a.node, b.node);
            return s;
        } else
            return s;
    }
}

/* Add factor * node to a sum. Nested sums that nothing else uses are expanded. */
static void collect(maker *m, int factor, int node, saltus_list *sum, bool outermost) {
    saltus_graph *g = m->graph;
    if (m->failed)
        return;
    if (is_number(m, node)) {
        add_summand(m, sum, (summand){apply(m, SALTUS_OP_MULTIPLY, factor, node), -1});
        return;
    }
    summand part = split(m, node);
    const saltus_graph_node n = g->nodes[part.node];
    bool sums = n.operation == SALTUS_OP_ADD || n.operation == SALTUS_OP_SUBTRACT;
    if (!follow_graph(m))
        return;
    factor = apply(m, SALTUS_OP_MULTIPLY, factor, part.factor);
    if (sums && (outermost || m->uses[part.node] <= 1) && m->place[part.node] < 0) {
        int other =
            n.operation == SALTUS_OP_ADD ? factor : apply(m, SALTUS_OP_MULTIPLY, factor, constant(m, -1));
        collect(m, factor, n.operand[0], sum, false);
        collect(m, other, n.operand[1], sum, false);
        return;
    }
    add_summand(m, sum, (summand){factor, part.node});
}

/* Merge terms with the same node, and the numbers. */
static void merge(maker *m, saltus_list *sum) {
    summand *s = sum->items;
    int kept = 0;
    for (int k = 0; k < sum->count; k++) {
        int j = 0;
        while (j < kept && s[j].node != s[k].node)
            j++;
        if (j < kept)
            s[j].factor = apply(m, SALTUS_OP_ADD, s[j].factor, s[k].factor);
        else
            s[kept++] = s[k];
    }
    sum->count = kept;
}

/* A term of a factored-out sum: a constant, a factor of parameters, and a node. */
typedef struct part {
    double constant;
    int factor, node;
} part;

/* A factored-out sum: its range of parts, and its node. */
typedef struct shared_sum {
    int first, count, node;
} shared_sum;

/* Split a number into a constant and the rest. */
static double take_constant(maker *m, int node, int *rest) {
    const saltus_graph_node n = *node_at(m, node);
    int a, b;
    if (n.operation == SALTUS_OP_CONSTANT) {
        *rest = constant(m, 1);
        return n.value;
    }
    *rest = node;
    if (n.operation != SALTUS_OP_MULTIPLY && n.operation != SALTUS_OP_DIVIDE)
        return 1;
    double first = take_constant(m, n.operand[0], &a), second = take_constant(m, n.operand[1], &b);
    *rest = apply(m, n.operation, a, b);
    return n.operation == SALTUS_OP_MULTIPLY ? first * second : first / second;
}

static int by_node(const void *a, const void *b) {
    return ((const summand *)a)->node - ((const summand *)b)->node;
}

/* Write a sum as a constant times a sum whose first constant is 1, which equations of a family then share. */
static summand share_sum(maker *m, saltus_list *terms) {
    summand *s = terms->items;
    const int count = terms->count, first = m->parts.count;
    double scale = 1;
    int node = 0;
    qsort(s, (size_t)count, sizeof *s, by_node);
    for (int k = 0; k < count; k++) {
        part own = {.node = s[k].node};
        own.constant = take_constant(m, s[k].factor, &own.factor);
        if (k == 0 && own.constant != 0)
            scale = own.constant;
        own.constant /= scale;
        push(m, &m->parts, &own, sizeof own);
    }
    if (m->failed)
        return (summand){0, 0};
    const part *parts = m->parts.items;
    for (int k = 0; k < m->sums.count; k++) {
        const shared_sum *other = (shared_sum *)m->sums.items + k;
        bool same = other->count == count; /* up to rounding of constants */
        for (int j = 0; j < count && same; j++) {
            const part *a = &parts[first + j], *b = &parts[other->first + j];
            same = a->node == b->node && a->factor == b->factor &&
                   fabs(a->constant - b->constant) <= 1e-15 * fabs(a->constant);
        }
        if (same) {
            m->parts.count = first;
            return (summand){constant(m, scale), other->node};
        }
    }
    for (int k = 0; k < count; k++) {
        int factor =
            apply(m, SALTUS_OP_MULTIPLY, constant(m, parts[first + k].constant), parts[first + k].factor);
        node = apply(m, SALTUS_OP_ADD, node, apply(m, SALTUS_OP_MULTIPLY, factor, s[k].node));
    }
    push(m, &m->sums, &(shared_sum){first, count, node}, sizeof(shared_sum));
    return (summand){constant(m, scale), node};
}

/* Whether `velocity` is the velocity of the displacement `node`. */
static bool is_rate_of(const maker *m, int velocity, int node) {
    const saltus_graph_node *v = node_at(m, velocity), *q = node_at(m, node);
    return v->operation == SALTUS_OP_STATE && q->operation == SALTUS_OP_STATE && q->index < m->dof &&
           v->index == q->index + m->dof;
}

/* If a node is a product with x that nothing else uses, its other operand; else -1. Squares, and products of
 * a displacement with its velocity, cost half a product and are left alone. */
static int cofactor(const maker *m, int node, int x) {
    if (node < 0 || node_at(m, node)->operation != SALTUS_OP_MULTIPLY || m->uses[node] > 1 ||
        m->place[node] >= 0)
        return -1;
    const int a = node_at(m, node)->operand[0], b = node_at(m, node)->operand[1];
    if (a == b || is_rate_of(m, a, b) || is_rate_of(m, b, a))
        return -1;
    return a == x ? b : b == x ? a : -1;
}

/* x y_1 + x y_2 + ... -> x (y_1 + y_2 + ...): one product in place of several. Numbers y_i stay outside. */
static void factor_out(maker *m, saltus_list *sum, int x) {
    saltus_list inner = {.items = NULL}, rest = {.items = NULL};
    for (int k = 0; k < sum->count && !m->failed; k++) {
        const summand s = ((summand *)sum->items)[k];
        const int other = cofactor(m, s.node, x);
        if (other >= 0)
            collect(m, s.factor, other, &inner, false);
        else
            add_summand(m, &rest, s);
    }
    merge(m, &inner);
    int kept = 0;
    for (int k = 0; k < inner.count && !m->failed; k++) {
        const summand s = ((summand *)inner.items)[k];
        if (s.node >= 0)
            ((summand *)inner.items)[kept++] = s;
        else
            add_summand(m, &rest, (summand){s.factor, x});
    }
    inner.count = kept;
    if (!m->failed) {
        summand shared = share_sum(m, &inner);
        shared.node = apply(m, SALTUS_OP_MULTIPLY, x, shared.node);
        add_summand(m, &rest, shared);
    }
    free(inner.items);
    free(sum->items);
    *sum = rest;
    if (follow_graph(m))
        merge(m, sum);
}

/* Longer sums are not factored: the search compares every operand with all terms. */
enum { factored_max = 256 };

/* Factor out common operands of a sum's products, the most frequent first. */
static void factor_sum(maker *m, saltus_list *sum) {
    for (int best = 2, x = -1; best > 1 && sum->count <= factored_max && follow_graph(m); x = -1) {
        best = 1;
        for (int k = 0; k < sum->count; k++) {
            const int node = ((summand *)sum->items)[k].node;
            for (int side = 0; side < 2 && node >= 0; side++) {
                const int own = node_at(m, node)->operand[side];
                int count = 0;
                if (own < 0 || cofactor(m, node, own) < 0)
                    break;
                for (int j = 0; j < sum->count; j++)
                    count += cofactor(m, ((summand *)sum->items)[j].node, own) >= 0;
                if (count > best) {
                    best = count;
                    x = own;
                }
            }
        }
        if (x >= 0)
            factor_out(m, sum, x);
    }
}

/* Make a sum a step of its own. */
static int combine(maker *m, int node) {
    saltus_list sum = {.items = NULL};
    collect(m, constant(m, 1), node, &sum, true);
    merge(m, &sum);
    factor_sum(m, &sum);
    /* Make the registers first, so that their steps precede this one. */
    for (int k = 0; k < sum.count && !m->failed; k++)
        if (((summand *)sum.items)[k].node >= 0)
            register_of(m, ((summand *)sum.items)[k].node);
    if (m->failed || m->place[node] >= 0) {
        free(sum.items);
        return m->failed ? 0 : m->place[node];
    }
    saltus_tape_step step = {.code = SALTUS_TAPE_COMBINE,
                             .first = m->terms.count,
                             .count = sum.count,
                             .out = -1,
                             .depends = node_at(m, node)->depends,
                             .linear = true};
    for (int k = 0; k < sum.count && !m->failed; k++) {
        const summand s = ((summand *)sum.items)[k];
        const saltus_tape_term term = {slot_of(m, s.factor), s.node < 0 ? -1 : register_of(m, s.node)};
        push(m, &m->terms, &term, sizeof term);
        step.linear = step.linear && (s.node < 0 || (!m->failed && is_linear(m, m->place[s.node])));
    }
    free(sum.items);
    return m->failed ? 0 : add_step(m, step);
}

/* A function's step and register precede those of its derivative, which may contain the function. */
static int add_function(maker *m, int node) {
    saltus_graph *g = m->graph;
    const saltus_graph_node n = *node_at(m, node);
    bool two = n.operation == SALTUS_OP_ATAN2;
    saltus_tape_step step = {.code = SALTUS_TAPE_FUNCTION,
                             .function = n.operation,
                             .depends = n.depends,
                             .sign = 1,
                             .a = register_of(m, n.operand[0]),
                             .a2 = two ? register_of(m, n.operand[1]) : -1,
                             .b2 = -1};
    if (m->failed || !follow_graph(m))
        return 0;
    step.out = m->place[node] = new_register(m, n.depends, false);
    step.linear = is_linear(m, step.a) && !two;
    int index = m->steps.count;
    add_step(m, step);
    if (two) {
        /* d atan2(y, x) = (x dy - y dx) / (x^2 + y^2) */
        int y = n.operand[0], x = n.operand[1];
        int size =
            apply(m, SALTUS_OP_ADD, apply(m, SALTUS_OP_MULTIPLY, x, x), apply(m, SALTUS_OP_MULTIPLY, y, y));
        step.b = register_of(m, apply(m, SALTUS_OP_DIVIDE, x, size));
        step.b2 = register_of(m, apply(m, SALTUS_OP_DIVIDE, apply(m, SALTUS_OP_SUBTRACT, 0, y), size));
    } else {
        summand derivative = split(m, saltus_graph_outer_derivative(g, node));
        step.sign = node_at(m, derivative.factor)->value;
        step.b = register_of(m, derivative.node);
    }
    if (!m->failed)
        ((saltus_tape_step *)m->steps.items)[index] = step;
    return step.out;
}

static int add_node(maker *m, int node) {
    const saltus_graph_node n = *node_at(m, node);
    const bool moves = n.operation == SALTUS_OP_STATE;
    saltus_tape_step step = {.out = -1, .depends = n.depends, .a2 = -1, .b2 = -1};
    if (moves || n.operation == SALTUS_OP_TIME || n.operation == SALTUS_OP_PHASE) {
        int place = new_register(m, n.depends, !moves);
        *(moves                           ? &m->made->state_register[n.index]
          : n.operation == SALTUS_OP_TIME ? &m->made->time
                                          : &m->made->phase) = place;
        return place;
    }
    /* Rewrite powers, and tan a = sin a / cos a, by operations that have a rule of their own. */
    if (n.operation == SALTUS_OP_POWER)
        return register_of(m, rewrite_power(m, n.operand[0], n.operand[1]));
    if (n.operation == SALTUS_OP_TAN) {
        int cosine = apply(m, SALTUS_OP_COS, n.operand[0], -1);
        int sine = apply(m, SALTUS_OP_SIN, n.operand[0], -1);
        return register_of(m, apply(m, SALTUS_OP_DIVIDE, sine, cosine));
    }
    summand part = split(m, node);
    if (is_number(m, node) || part.node != node || n.operation == SALTUS_OP_ADD ||
        n.operation == SALTUS_OP_SUBTRACT)
        return combine(m, node);
    if (n.operation == SALTUS_OP_ATAN2 || (n.operation >= SALTUS_OP_SQRT && n.operation <= SALTUS_OP_TANH))
        return add_function(m, node);
    if (n.operation >= SALTUS_OP_CHOOSE_LESS) {
        /* One of two series; parameters decide which. */
        int chosen =
            saltus_graph_choose(m->graph, n.operation, n.operand[0], n.operand[1], constant(m, 1), 0);
        step.code = SALTUS_TAPE_CHOOSE;
        step.a = register_of(m, n.operand[2]);
        step.b = register_of(m, n.operand[3]);
        step.first = slot_of(m, chosen);
        return m->failed ? 0 : add_step(m, step);
    }
    step.a = register_of(m, n.operand[0]);
    step.b = register_of(m, n.operand[1]);
    if (m->failed || m->place[node] >= 0)
        return m->failed ? 0 : m->place[node];
    const bool first = is_rate_of(m, n.operand[0], n.operand[1]);
    if (n.operation == SALTUS_OP_MULTIPLY && first) {
        step.b = step.a;
        step.a = register_of(m, n.operand[1]);
    }
    step.code = n.operation == SALTUS_OP_DIVIDE                      ? SALTUS_TAPE_DIVIDE
                : step.a == step.b                                   ? SALTUS_TAPE_SQUARE
                : first || is_rate_of(m, n.operand[1], n.operand[0]) ? SALTUS_TAPE_RATE
                                                                     : SALTUS_TAPE_MULTIPLY;
    return m->failed ? 0 : add_step(m, step);
}

static int register_of(maker *m, int node) {
    if (!follow_graph(m))
        return 0;
    if (m->place[node] < 0) {
        int place = add_node(m, node);
        if (follow_graph(m))
            m->place[node] = place;
    }
    return m->failed ? 0 : m->place[node];
}

bool saltus_tape_steps_make(saltus_tape_steps *made, saltus_graph *graph, const int *roots, int root_count,
                            int dof, int states) {
    *made = (saltus_tape_steps){.time = -1,
                                .phase = -1,
                                .states = states,
                                .state_register = malloc((size_t)(states + 1) * sizeof(int)),
                                .output_count = root_count,
                                .outputs = malloc((size_t)(root_count + 1) * sizeof(int))};
    bool *needed = calloc((size_t)graph->count, sizeof *needed);
    maker m = {.graph = graph,
               .made = made,
               .dof = dof,
               .failed = !needed || !made->state_register || !made->outputs};
    for (int i = 0; i < states && !m.failed; i++)
        made->state_register[i] = -1;
    if (follow_graph(&m))
        saltus_graph_mark(graph, roots, root_count, NULL, needed);
    for (int k = 0; k < graph->count && !m.failed; k++)
        for (int j = 0; needed[k] && j < saltus_operation_operands(graph->nodes[k].operation); j++)
            m.uses[graph->nodes[k].operand[j]]++;
    for (int k = 0; k < root_count && !m.failed; k++)
        m.uses[roots[k]]++;
    free(needed);
    for (int k = 0; k < root_count && !m.failed; k++)
        made->outputs[k] = register_of(&m, roots[k]);
    made->items = m.steps.items;
    made->count = m.steps.count;
    made->terms = m.terms.items;
    made->depends = m.depends.items;
    made->registers = m.depends.count;
    made->slot_node = m.slots.items;
    made->slot_count = m.slots.count;
    free(m.linear.items);
    free(m.sums.items);
    free(m.parts.items);
    free(m.place);
    free(m.slot_of);
    free(m.uses);
    /* If a displacement's product with its velocity is computed too, its square is the integral of that. */
    for (int i = 0; i < made->count && !m.failed; i++) {
        saltus_tape_step *s = &made->items[i];
        for (int j = 0; j < made->count && s->code == SALTUS_TAPE_SQUARE; j++)
            if (made->items[j].code == SALTUS_TAPE_RATE && made->items[j].a == s->a) {
                s->code = SALTUS_TAPE_INTEGRAL;
                s->b = made->items[j].out;
            }
    }
    if (m.failed)
        saltus_tape_steps_close(made);
    return !m.failed;
}

void saltus_tape_steps_close(saltus_tape_steps *steps) {
    free(steps->items);
    free(steps->terms);
    free(steps->depends);
    free(steps->state_register);
    free(steps->outputs);
    free(steps->slot_node);
    *steps = (saltus_tape_steps){0};
}
