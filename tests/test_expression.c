/* Expressions: their values, their errors, and the series made of them, against plain evaluation.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "system/system.h"
#include "system/text.h"

static void values(void **unused) {
    (void)unused;
    const double pi = acos(-1.0);
    const struct {
        const char *text;
        double value;
    } known[] = {
        {"2", 2},
        {"1 + 2*3", 7},
        {"(1 + 2)*3", 9},
        {"2^3^2", 512},
        {"-2^2", -4},
        {"(-2)^2", 4},
        {"2^-1", 0.5},
        {"2*-3", -6},
        {"7 - 3 - 2", 2},
        {"12/3/2", 2},
        {"1.5e2 + .5", 150.5},
        {"pi", pi},
        {"2*pi/3", 2 * pi / 3},
        {"sqrt(2)", sqrt(2)},
        {"exp(log(3))", exp(log(3))},
        {"sin(1)^2 + cos(1)^2", 1},
        {"tan(0.5)", tan(0.5)},
        {"asin(0.3) + acos(0.3)", pi / 2},
        {"atan2(-1, -1)", -3 * pi / 4},
        {"sinh(1) + cosh(1)", exp(1)},
        {"tanh(0.3)", tanh(0.3)},
        {"abs(-3) + sign(-2) + step(0) + sign(0)", 3},
        {"min(3, 1, 2) + max(3, 1, 2)", 4},
        {"mod(-1, 3)", 2},
        {"if(1 < 2, 10, 20) + if(2 <= 1, 1, 2) + if(1 != 1, 5, 6)", 18},
        {"if(1 < 2, 1, 1/0)", 1},
        {"sum(i, 1, 4, i^2)", 30},
        {"sum(i, 1, 3, sum(j, 1, i, j))", 10},
        {"sum(i, 3, 2, 1/0)", 0},
        {"+3", 3},
    };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        double value = 0;
        saltus_message message = {.text = ""};
        if (saltus_constant_value(known[k].text, &value, &message) != SALTUS_OK)
            fail_msg("%s: %s", known[k].text, message.text);
        check_near(value, known[k].value, 4e-16 * (1 + fabs(known[k].value)));
    }
}

static void errors_tell_the_column(void **unused) {
    (void)unused;
    static const struct {
        const char *text, *words;
    } known[] = {
        {"", "column 1: the expression ends too early"},
        {"1 +", "column 4: the expression ends too early"},
        {"1 2", "column 3: an operator is expected"},
        {"2x", "column 2: an operator is missing"},
        {"(1 + 2", "column 1: this parenthesis is not closed"},
        {"1)", "column 2: an operator is expected"},
        {"sin(1, 2)", "column 1: sin takes 1 argument, not 2"},
        {"atan2(1)", "column 1: atan2 takes 2 arguments, not 1"},
        {"sine(1)", "column 1: there is no function of this name"},
        {"if(1, 2, 3)", "column 4: the first argument of if must be a comparison"},
        {"1 < 2", "column 1: a comparison can only be"},
        {"1 = 2", "column 3: = cannot stand here"},
        {"a'", "column 1: a is no displacement"},
        {"3 $ 4", "column 3: an operator is expected"},
        {"1e400", "column 1: the number is too large"},
        {".", "column 1: a number has no digits"},
        {"1/0", "column 2: a division by zero"},
        {"sum(1, 1, 2, 3)", "column 5: the first argument of sum"},
        {"sum(i, 1, 1.5, 3)", "column 11: the last index of a sum must be a whole number"},
    };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        double value;
        saltus_message message = {.text = ""};
        assert_int_equal(saltus_constant_value(known[k].text, &value, &message), SALTUS_BAD_INPUT);
        if (!strstr(message.text, known[k].words))
            fail_msg("%s: \"%s\" does not say \"%s\"", known[k].text, message.text, known[k].words);
    }
    char deep[1000];
    double value;
    memset(deep, '(', sizeof deep - 1);
    deep[sizeof deep - 1] = '\0';
    assert_int_equal(saltus_constant_value(deep, &value, NULL), SALTUS_BAD_INPUT);
}

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
static unsigned draw(unsigned below) {
    random_state = random_state * 6364136223846793005UL + 1442695040888963407UL;
    return (unsigned)(random_state >> 33) % below;
}

static int grow(tree *t, int depth) {
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
static void print(const tree *t, int k, char *text, size_t *used) {
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

static double plain(const tree *t, int k, const double *leaf) {
    int kind = t->node[k].kind;
    double l = t->node[k].left < 0 ? 0 : plain(t, t->node[k].left, leaf),
           r = t->node[k].right < 0 ? 0 : plain(t, t->node[k].right, leaf), number = t->node[k].number;
    switch (kind < first_function ? kind : first_function) {
    case leaf_number:
        return number;
    case plus:
        return l + r;
    case minus:
        return l - r;
    case times:
        return l * r;
    case over:
        return l / (2 + r * r);
    case power:
        return number == floor(number) ? pow(tanh(l), number) : pow(2 + tanh(l), number);
    case first_function:
        break;
    default:
        return leaf[kind];
    }
    switch (kind - first_function) {
    case 0:
        return sin(l);
    case 1:
        return cos(l);
    case 2:
        return exp(tanh(l));
    case 3:
        return tanh(l);
    case 4:
        return sqrt(2 + l * l);
    case 5:
        return log(2 + l * l);
    case 6:
        return atan(l);
    case 7:
        return sinh(tanh(l));
    case 8:
        return cosh(tanh(l));
    case 9:
        return tan(tanh(l));
    case 10:
        return asin(0.5 * sin(l));
    case 11:
        return acos(0.5 * sin(l));
    default:
        return atan2(l, 2 + r * r);
    }
}

/* x'' = a tanh of one expression, z' = that of another: what flows of such systems are compared with. */
typedef struct pair {
    tree motion, rate;
    double a;
} pair;

static int field(double t, const double *y, double *rate, void *context) {
    const pair *p = context;
    const double leaf[] = {y[0], y[1], y[2], sin(0.5 * t), p->a};
    rate[0] = y[1];
    rate[1] = tanh(plain(&p->motion, 0, leaf)) - y[0];
    rate[2] = tanh(plain(&p->rate, 0, leaf));
    return isfinite(rate[1] + rate[2]) ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* Flows of random systems are solutions of their plain equations, and their tangent vectors and parameter
 * columns differences of solutions. */
static void random_systems(void **unused) {
    (void)unused;
    const double span = 0.7, start[3] = {0.3, -0.4, 0.2};
    for (int trial = 0; trial < 300; trial++) {
        pair p = {.a = 0.6};
        char texts[2][text_max + 40] = {"tanh(", "tanh("};
        for (int k = 0; k < 2; k++) {
            size_t used = 5;
            grow(k ? &p.rate : &p.motion, 3);
            print(k ? &p.rate : &p.motion, 0, texts[k], &used);
            snprintf(texts[k] + used, sizeof texts[k] - used, k ? ")" : ") - x");
        }
        const saltus_equation motion[] = {{"x", texts[0], 1}}, states[] = {{"z", texts[1], 2}};
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
            fail_msg("%s\n%s\n%s", message.text, texts[0], texts[1]);
        saltus_spec spec = saltus_spec_defaults(model);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_direction direction;
        saltus_flow *flow = NULL;
        options.rtol = 1e-14;
        options.columns = 4;
        options.directions = 1;
        check_ok(saltus_spec_direction(&spec, "a", &direction, NULL, &message), &message);
        check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
        saltus_flow_set_directions(flow, &direction);
        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message), &message);
        advance(flow, span / saltus_system_period(system), 0);
        double state[3], columns[12];
        saltus_flow_state(flow, 0, state);
        saltus_flow_tangents(flow, 0, columns);
        for (int c = -1; c < 4; c++) {
            double end[2][3];
            const double h = 1e-3;
            for (int side = 0; side < (c < 0 ? 1 : 2); side++) {
                pair q = p;
                double y[3], t = 0;
                memcpy(y, start, sizeof y);
                if (c == 3)
                    q.a += side ? -h : h;
                else if (c >= 0)
                    y[c] += side ? -h : h;
                gsl_odeiv2_system equations = {field, NULL, 3, &q};
                gsl_odeiv2_driver *driver =
                    gsl_odeiv2_driver_alloc_y_new(&equations, gsl_odeiv2_step_rk8pd, 1e-3, 1e-14, 1e-13);
                assert_int_equal(gsl_odeiv2_driver_apply(driver, &t, span, y), GSL_SUCCESS);
                gsl_odeiv2_driver_free(driver);
                memcpy(end[side], y, sizeof y);
            }
            for (int i = 0; i < 3; i++) {
                double expected = c < 0 ? end[0][i] : (end[0][i] - end[1][i]) / (2 * h);
                double got = c < 0 ? state[i] : columns[3 * c + i];
                if (!(fabs(got - expected) <= (c < 0 ? 1e-11 : 3e-4) * (1 + fabs(expected))))
                    fail_msg("column %d, entry %d: %.15g instead of %.15g\nx'' = %s\nz' = %s", c, i, got,
                             expected, texts[0], texts[1]);
            }
        }
        saltus_flow_free(flow);
        saltus_system_free(system);
        saltus_model_release(model);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values),
        cmocka_unit_test(errors_tell_the_column),
        cmocka_unit_test(random_systems),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
