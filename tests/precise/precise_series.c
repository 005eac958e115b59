/* Taylor coefficients of systems from text, with those of their tangent vectors and parameter columns,
 * against the same in 113 bits. Every coefficient is right to 1e-13 of the sum of the moduli of the terms
 * that it is made of: what the order of a sum and the rounding of its terms can do.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "random_text.h"

#include "flow/flow.h"
#include "precise/real.h"

enum { order_max = 16, columns = 4, steps_max = 20000, systems = 1000, quick_systems = 100 };

/* Series in 113 bits. A function of a series follows from its derivative's: y' = f'(a) a'. */
typedef enum kind { given, sum, difference, product, quotient, function } kind;

typedef struct series {
    kind kind;
    int a, b; /* operands; of a function: the operand and the derivative's series */
    real (*value)(real);
    real c[order_max + 1];
    real moduli[order_max + 1]; /* sums of the moduli of the terms of c */
} series;

static series all[steps_max];
static int used;

/* A series and its derivatives by the initial state and the parameter. */
typedef struct dual {
    int value, by[columns];
} dual;

static int add(kind what, int a, int b) {
    assert_true(used < steps_max);
    all[used] = (series){.kind = what, .a = a, .b = b};
    return used++;
}

static int number(real value) {
    int k = add(given, -1, -1);
    all[k].c[0] = value;
    return k;
}

static dual constant(real value) {
    int zero = number(0);
    return (dual){number(value), {zero, zero, zero, zero}};
}

static dual combine(kind what, dual x, dual y) {
    dual z = {.value = add(what, x.value, y.value)};
    for (int k = 0; k < columns; k++)
        if (what == product)
            z.by[k] = add(sum, add(product, x.by[k], y.value), add(product, x.value, y.by[k]));
        else if (what == quotient)
            z.by[k] = add(quotient, add(difference, x.by[k], add(product, z.value, y.by[k])), y.value);
        else
            z.by[k] = add(what, x.by[k], y.by[k]);
    return z;
}

/* The derivative's series may be made after this: it is needed one order less. */
static int begin_function(int a, real (*value)(real)) {
    int k = add(function, a, -1);
    all[k].value = value;
    return k;
}

static dual end_function(int place, dual a, int derivative) {
    dual z = {.value = place};
    all[place].b = derivative;
    for (int k = 0; k < columns; k++)
        z.by[k] = add(product, derivative, a.by[k]);
    return z;
}

static dual exponential(dual a) {
    int y = begin_function(a.value, expq);
    return end_function(y, a, y);
}

static dual sine(dual a, bool co) {
    int s = begin_function(a.value, sinq), c = begin_function(a.value, cosq);
    int minus = add(difference, number(0), s);
    all[s].b = c;
    all[c].b = minus;
    return co ? end_function(c, a, minus) : end_function(s, a, c);
}

/* sinh and cosh */
static dual hyperbolic(dual a, bool co) {
    int s = begin_function(a.value, sinhq), c = begin_function(a.value, coshq);
    all[s].b = c;
    all[c].b = s;
    return co ? end_function(c, a, s) : end_function(s, a, c);
}

/* tan with sign +1, tanh with -1: the derivative is 1 + sign y^2. */
static dual tangent(dual a, int sign) {
    int y = begin_function(a.value, sign > 0 ? tanq : tanhq);
    return end_function(y, a, add(sign > 0 ? sum : difference, number(1), add(product, y, y)));
}

static dual power_of(dual a, real exponent) {
    int whole = (int)exponent;
    if (exponent == whole) {
        dual y = a;
        for (int k = 1; k < whole; k++)
            y = combine(product, y, a);
        return y;
    }
    dual logarithm = end_function(begin_function(a.value, logq), a, add(quotient, number(1), a.value));
    return exponential(combine(product, constant(exponent), logarithm));
}

/* asin with sign +1, acos with -1 */
static dual inverse_sine(dual a, int sign) {
    dual one = constant(1), rest = combine(difference, one, combine(product, a, a));
    dual slope = combine(quotient, constant(sign), power_of(rest, 0.5));
    return end_function(begin_function(a.value, sign > 0 ? asinq : acosq), a, slope.value);
}

static dual inverse_tangent(dual a) {
    dual slope = combine(quotient, constant(1), combine(sum, constant(1), combine(product, a, a)));
    return end_function(begin_function(a.value, atanq), a, slope.value);
}

static dual above_two(dual a) {
    return combine(sum, constant(2), combine(product, a, a));
}

static dual function_of(int which, dual a, dual b) {
    switch (which) {
    case 0:
        return sine(a, false);
    case 1:
        return sine(a, true);
    case 2:
        return exponential(tangent(a, -1));
    case 3:
        return tangent(a, -1);
    case 4:
        return power_of(above_two(a), 0.5);
    case 5:
        a = above_two(a);
        return end_function(begin_function(a.value, logq), a, add(quotient, number(1), a.value));
    case 6:
        return inverse_tangent(a);
    case 7:
        return hyperbolic(tangent(a, -1), false);
    case 8:
        return hyperbolic(tangent(a, -1), true);
    case 9:
        return tangent(tangent(a, -1), 1);
    case 10:
        return inverse_sine(combine(product, constant(0.5), sine(a, false)), 1);
    case 11:
        return inverse_sine(combine(product, constant(0.5), sine(a, false)), -1);
    default:
        return inverse_tangent(combine(quotient, a, above_two(b)));
    }
}

/* The series of a tree, its leaves being x, x', z, sin(omega t) and a. */
static dual series_of(const tree *t, int k, const dual *leaf) {
    int kind = t->node[k].kind;
    if (kind < leaf_number)
        return leaf[kind];
    if (kind == leaf_number)
        return constant(t->node[k].number);
    dual a = series_of(t, t->node[k].left, leaf),
         b = t->node[k].right < 0 ? a : series_of(t, t->node[k].right, leaf);
    double number = t->node[k].number;
    switch (kind) {
    case plus:
        return combine(sum, a, b);
    case minus:
        return combine(difference, a, b);
    case times:
        return combine(product, a, b);
    case over:
        return combine(quotient, a, above_two(b));
    case power:
        a = tangent(a, -1);
        return power_of(number == floor(number) ? a : combine(sum, constant(2), a), number);
    default:
        return function_of(kind - first_function, a, b);
    }
}

static void advance_order(series *y, int k) {
    const series *a = y->kind == given ? NULL : &all[y->a], *b = y->kind == given ? NULL : &all[y->b];
    real c = 0, moduli = 0;
    switch (y->kind) {
    case given:
        y->moduli[k] = real_abs(y->c[k]);
        return;
    case sum:
    case difference:
        c = y->kind == sum ? a->c[k] + b->c[k] : a->c[k] - b->c[k];
        moduli = a->moduli[k] + b->moduli[k];
        break;
    case product:
        for (int j = 0; j <= k; j++) {
            c += a->c[j] * b->c[k - j];
            moduli += a->moduli[j] * b->moduli[k - j];
        }
        break;
    case quotient:
        c = a->c[k];
        moduli = a->moduli[k];
        for (int j = 0; j < k; j++) {
            c -= y->c[j] * b->c[k - j];
            moduli += y->moduli[j] * b->moduli[k - j];
        }
        c /= b->c[0];
        moduli = (moduli + real_abs(c) * b->moduli[0]) / real_abs(b->c[0]);
        break;
    case function:
        for (int j = 1; j <= k; j++) {
            c += j * a->c[j] * b->c[k - j] / k;
            moduli += j * a->moduli[j] * b->moduli[k - j] / k;
        }
        if (k == 0)
            c = y->value(a->c[0]);
        break;
    }
    y->c[k] = c;
    y->moduli[k] = moduli;
}

/* The value of a function is as uncertain as its operand: what is missing in its moduli at order 0, where the
 * derivative may come later. */
static void complete_moduli(void) {
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < used; k++)
            if (all[k].kind == function)
                all[k].moduli[0] =
                    real_abs(all[k].c[0]) + real_abs(all[all[k].b].c[0]) * all[all[k].a].moduli[0];
            else
                advance_order(&all[k], 0);
}

/* One more order of a state from its rate's. */
static void integrate(int state, int rate, int k) {
    all[state].c[k] = all[rate].c[k - 1] / k;
    all[state].moduli[k] = all[rate].moduli[k - 1] / k;
}

/* x, x', z as series of `order`. */
static void solve(const pair *p, const double *start, real time, int order, dual state[3]) {
    const real omega = 0.5;
    used = 0;
    for (int i = 0; i < 3; i++) {
        state[i] = constant(start[i]);
        for (int k = 0; k < columns; k++)
            state[i].by[k] = number(k == i);
    }
    dual argument = constant(omega * time), a = constant(p->a);
    all[argument.value].c[1] = omega;
    a.by[columns - 1] = number(1);
    const dual leaf[] = {state[0], state[1], state[2], sine(argument, false), a};
    dual force = combine(difference, tangent(series_of(&p->motion, 0, leaf), -1), state[0]);
    dual rate = tangent(series_of(&p->rate, 0, leaf), -1);
    const dual rates[3] = {state[1], force, rate};
    for (int k = 0; k < used; k++)
        advance_order(&all[k], 0);
    complete_moduli();
    for (int order_now = 1; order_now <= order; order_now++) {
        for (int i = 0; i < 3; i++) {
            integrate(state[i].value, rates[i].value, order_now);
            for (int k = 0; k < columns; k++)
                integrate(state[i].by[k], rates[i].by[k], order_now);
        }
        for (int k = 0; k < used; k++)
            if (all[k].kind != given || (k > state[2].by[columns - 1] && order_now == 1))
                advance_order(&all[k], order_now);
    }
}

/* A flow at the point, its jets expanded. */
static saltus_flow *expand(const saltus_system *system, double phase, const double *start, int *order) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    saltus_message message = {.text = ""};
    saltus_direction direction;
    options.rtol = 1e-14;
    options.columns = columns;
    options.directions = 1;
    check_ok(saltus_spec_direction(saltus_system_spec(system), "a", &direction, NULL, &message), &message);
    check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
    saltus_flow_set_directions(flow, &direction);
    check_ok(saltus_flow_start(flow, 0, (saltus_time){0, phase}, start, &message), &message);
    flow->work.lane->phase[0] = phase;
    *order = flow->work.order < order_max ? flow->work.order : order_max;
    flow->kernel->expand(&flow->work, 0, *order);
    return flow;
}

static void coefficients_are_right(void **unused) {
    (void)unused;
    const double phase = 0.3;
    long compared = 0, sharp = 0;
    int count = getenv("SALTUS_SANITIZED") ? quick_systems : systems;
    random_state = 2026;
    for (int trial = 0; trial < count; trial++) {
        pair p = random_pair(2 + trial % 4);
        const double start[3] = {0.1 * draw(10), 0.5 - 0.1 * draw(10), 0.3 - 0.1 * draw(6)};
        const saltus_model *model = model_of(&p);
        saltus_spec spec = saltus_spec_defaults(model);
        saltus_system *system = build(&spec);
        int order;
        saltus_flow *flow = expand(system, phase, start, &order);
        const saltus_work *w = &flow->work;
        dual state[3];
        solve(&p, start, phase * (real)saltus_system_period(system), order, state);
        for (int k = 0; k <= order; k++)
            for (int column = 0; column <= columns; column++) {
                const double got[3] = {w->jet.q[saltus_work_place(w, k, column, 0, 0)],
                                       w->jet.v[saltus_work_place(w, k, column, 0, 0)],
                                       w->jet.e[saltus_work_extra_place(w, k, column, 0, 0)]};
                for (int i = 0; i < 3; i++) {
                    const series *right = &all[column ? state[i].by[column - 1] : state[i].value];
                    double error = (double)real_abs(got[i] - right->c[k]), size = (double)right->moduli[k];
                    if (!(error <= 1e-13 * size))
                        fail_msg("coefficient %d of entry %d, column %d: %.17g instead of %.17g, terms of "
                                 "%.3g\n%s\n%s",
                                 k, i, column, got[i], (double)right->c[k], size, p.text[0], p.text[1]);
                    compared++;
                    sharp += size <= 1e3 * real_abs(right->c[k]);
                }
            }
        saltus_flow_free(flow);
        saltus_system_free(system);
        saltus_model_release(model);
    }
    /* Sums that cancel would make the demand empty: mostly they do not. */
    if (!(sharp > 0.5 * (double)compared))
        fail_msg("only %ld of %ld coefficients are of the size of their terms", sharp, compared);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(coefficients_are_right)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
