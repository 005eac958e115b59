/* Expressions: their values, their errors, and the series made of them, against plain evaluation.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "random_text.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

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

static int field(double t, const double *y, double *rate, void *context) {
    const pair *p = context;
    const double leaf[] = {y[0], y[1], y[2], sin(0.5 * t), p->a};
    rate[0] = y[1];
    rate[1] = tanh(plain(&p->motion, 0, leaf)) - y[0];
    rate[2] = tanh(plain(&p->rate, 0, leaf));
    return isfinite(rate[1] + rate[2]) ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* Flows of random systems solve their equations, evaluated directly; tangent vectors and parameter columns
 * are differences of solutions. */
static void random_systems(void **unused) {
    (void)unused;
    const double span = 0.7, start[3] = {0.3, -0.4, 0.2};
    for (int trial = 0; trial < 300; trial++) {
        pair p = random_pair(3);
        const saltus_model *model = model_of(&p);
        saltus_message message = {.text = ""};
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
                             expected, p.text[0], p.text[1]);
            }
        }
        saltus_flow_free(flow);
        saltus_system_free(system);
        saltus_model_release(model);
    }
}

/* Steep tanh, as in friction laws: far from its step it is 1 to the last bit, at the step accurate to
 * rounding. */
static void steep_friction(void **unused) {
    (void)unused;
    const saltus_equation motion[] = {{"x", "-tanh(x'/1e-6) - x", 1}};
    const saltus_text text = {.origin = "test", .motion = {motion, 1}};
    const saltus_model *model;
    saltus_message message = {.text = ""};
    check_ok(saltus_text_model_new(&text, &model, &message), &message);
    saltus_spec spec = saltus_spec_defaults(model);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    const double start[2] = {0.2, 1}, span = 0.1;
    options.rtol = 1e-15;
    saltus_flow *flow = open_flow(system, &options, 0, start);
    double state[2], rate[2];
    advance(flow, span / saltus_system_period(system), 0);
    saltus_flow_state(flow, 0, state);
    check_near(state[0], 1.2 * cos(span) + sin(span) - 1, 1e-14);
    check_near(state[1], -1.2 * sin(span) + cos(span), 1e-14);
    const double slow[2] = {0, 1e-20};
    check_ok(saltus_flow_place(flow, 0, (saltus_time){0, 0}, slow, 0, &message), &message);
    saltus_flow_field(flow, 0, rate);
    check_near(rate[1], -1e-14, 1e-29);
    saltus_flow_free(flow);
    saltus_system_free(system);
    saltus_model_release(model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values),
        cmocka_unit_test(errors_tell_the_column),
        cmocka_unit_test(random_systems),
        cmocka_unit_test(steep_friction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
