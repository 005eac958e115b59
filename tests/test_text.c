/* Systems from text against the built-in models, and expressions against numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "system/system.h"
#include "system/text.h"

#include <limits.h>

#define LIST(array)                                                                                          \
    { array, sizeof array / sizeof array[0] }

/* A choice by parameters evaluates only its branch: the other here is not a number. */
static const saltus_equation oscillator_motion[] = {
    {"x1",
     "if(c > 0, -c*x1', sqrt(-1 - x1^2)) - if(k < 0, log(-1 - x1^2), k*x1) - c2*(x1' - x2') - k2*(x1 - x2) - "
     "z + F*cos(omega*t) + F0",
     1},
    {"x2", "-c2*(x2' - x1') - k2*(x2 - x1) + F2*cos(omega*t) + F02", 2}};
static const saltus_equation oscillator_states[] = {{"z", "kz*x1' - z/tz", 3}};
static const saltus_equation oscillator_mass[] = {{"x1", "m", 4}, {"x2", "m2", 5}};

/* The first mass, independent of N: every parameter must occur. */
static const saltus_equation oscillator_seen[] = {{"seen", "x1 - x2 + 0*N", 8}};

/* The parameters of a built-in model under the same names. */
static int parameters_of(const char *model, saltus_text_parameter *list) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(saltus_model_find(model), &count);
    for (int k = 0; k < count; k++)
        list[k] = (saltus_text_parameter){.name = p[k].name,
                                          .fallback = p[k].fallback,
                                          .min = p[k].min,
                                          .max = p[k].max,
                                          .integer = p[k].integer};
    return count;
}

static const saltus_model *oscillator_text(void) {
    static const saltus_text_stop stops[] = {{{"coordinate", "x1 - x2", 6}, {"d", NULL, 0}, {"r", NULL, 0}}};
    saltus_text_parameter parameters[SALTUS_PARAMETERS_MAX];
    saltus_text text = {.origin = "test",
                        .parameters = parameters,
                        .parameter_count = parameters_of("oscillator", parameters),
                        .stops = stops,
                        .stop_count = 1,
                        .motion = LIST(oscillator_motion),
                        .mass = LIST(oscillator_mass),
                        .states = LIST(oscillator_states),
                        .observe = LIST(oscillator_seen),
                        .forcing = {"forcing", "omega", 7}};
    saltus_message message = {.text = ""};
    const saltus_model *model = NULL;
    check_ok(saltus_text_model_new(&text, &model, &message), &message);
    return model;
}

/* The built-in pipe's equations (model.md, section 1). */
static const saltus_equation pipe_families[] = {{"q", "N", 1}};
static const saltus_equation pipe_let[] = {
    {"u", "u0*(1 + sigma*sin(omega*t))", 2},
    {"du", "u0*sigma*omega*cos(omega*t)", 3},
    {"l[i]", "i*pi", 4},
    {"S", "sum(j, 1, N, l[j]^2*q[j]^2)/2", 5},
    {"dS", "sum(j, 1, N, l[j]^2*q[j]*q[j]')", 6},
    {"pushed[i]", "sum(j, 1, N, if(mod(i + j, 2) == 1, 4*i*j/(i^2 - j^2)*q[j]', 0))", 7},
    {"bent[i]", "sum(j, 1, N, if(mod(i + j, 2) == 1, -8*i*j^3/(i^2 - j^2)^2*q[j], 0)) - l[i]^2/2*q[i]", 8},
};
static const saltus_equation pipe_motion[] = {
    {"q[i]",
     "-alpha*l[i]^4*q[i]' - 2*sqrt(beta)*u*pushed[i] - (l[i]^4 - u^2*l[i]^2)*q[i]"
     " - sqrt(beta)*du*bent[i] - kappa*l[i]^2*q[i]*(S + alpha*dS)",
     9}};

static const saltus_model *pipe_text(void) {
    static const saltus_text_stop stops[] = {
        {{"coordinate", "sum(i, 1, N, sin(i*pi*place)*q[i])", 10}, {"d", NULL, 0}, {"r", NULL, 0}}};
    saltus_text_parameter parameters[SALTUS_PARAMETERS_MAX];
    int count = parameters_of("pipe", parameters);
    parameters[count++] = (saltus_text_parameter){.name = "place", .fallback = 0.5, .min = 0, .max = 1};
    saltus_text text = {.origin = "test",
                        .parameters = parameters,
                        .parameter_count = count,
                        .stops = stops,
                        .stop_count = 1,
                        .families = LIST(pipe_families),
                        .let = LIST(pipe_let),
                        .motion = LIST(pipe_motion),
                        .forcing = {"forcing", "omega", 7}};
    saltus_message message = {.text = ""};
    const saltus_model *model = NULL;
    check_ok(saltus_text_model_new(&text, &model, &message), &message);
    return model;
}

/* The same scene as text: parameters equal by name, the same stop. */
static saltus_spec in_text(const saltus_spec *spec, const saltus_model *model) {
    saltus_spec text = saltus_spec_defaults(model);
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    for (int k = 0; k < count; k++)
        set_parameter(&text, p[k].name, spec->parameters[k]);
    text.stop_count = spec->stop_count;
    memcpy(text.stops, spec->stops, sizeof text.stops);
    if (saltus_model_parameter_index(model, "place") >= 0 && spec->stop_count)
        set_parameter(&text, "place", spec->stops[0].xi);
    return text;
}

enum { dimension_max = 24, columns_max = 24, state_max = 80 };
static const double pi = 3.14159265358979323846;

/* Run both through the same events: states, tangent vectors and a parameter column agree at the end. */
static void compare(const saltus_spec *spec, const saltus_model *model, const double *start, double end,
                    const char *key, int impacts_at_least) {
    saltus_spec other = in_text(spec, model);
    const saltus_spec *const specs[] = {spec, &other};
    double state[2][dimension_max], columns[2][(dimension_max + 1) * dimension_max];
    saltus_flow_info info[2];
    int n = 0;
    for (int k = 0; k < 2; k++) {
        saltus_system *system = build(specs[k]);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_direction direction;
        saltus_message message = {.text = ""};
        saltus_flow *flow = NULL;
        n = saltus_system_dimension(system);
        options.rtol = 1e-13;
        options.integrator = SALTUS_TAYLOR;
        options.columns = n + 1;
        options.directions = 1;
        const char *own = k && strcmp(key, "xi") == 0 ? "place" : key;
        check_ok(saltus_spec_direction(specs[k], own, &direction, NULL, &message), &message);
        check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
        saltus_flow_set_directions(flow, &direction);
        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0.2}, start, &message), &message);
        advance(flow, end, 0);
        saltus_flow_state(flow, 0, state[k]);
        saltus_flow_tangents(flow, 0, columns[k]);
        info[k] = saltus_flow_information(flow, 0);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
    assert_true(info[0].impacts >= impacts_at_least);
    assert_int_equal(info[0].impacts, info[1].impacts);
    saltus_system *system = build(spec);
    const double *scale = saltus_system_scale(system);
    for (int i = 0; i < n; i++)
        check_near(state[1][i], state[0][i], 1e-9 * scale[i]);
    for (int c = 0; c <= n; c++) {
        double size = 0;
        for (int i = 0; i < n; i++)
            size = fmax(size, fabs(columns[0][c * n + i]) / scale[i]);
        for (int i = 0; i < n; i++)
            if (!(fabs(columns[1][c * n + i] - columns[0][c * n + i]) <= 1e-7 * size * scale[i]))
                fail_msg("%s, column %d, entry %d: %.15g instead of %.15g", key, c, i, columns[1][c * n + i],
                         columns[0][c * n + i]);
    }
    saltus_system_free(system);
}

static void the_oscillator(void **unused) {
    (void)unused;
    static const char *const keys[] = {"omega", "m", "m2", "c", "k", "k2", "F", "F0", "tz", "kz", "d", "r"};
    const saltus_model *model = oscillator_text();
    saltus_spec spec = oscillator_spec(0.1, 1.2, 0.8, 0.9);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "m", 1.4);
    set_parameter(&spec, "m2", 0.7);
    set_parameter(&spec, "c2", 0.06);
    set_parameter(&spec, "k2", 0.9);
    set_parameter(&spec, "F2", 0.4);
    set_parameter(&spec, "F02", 0.05);
    set_parameter(&spec, "kz", 0.7);
    set_parameter(&spec, "tz", 1.9);
    add_stop(&spec, 0.25, 0.8, SALTUS_UPPER);
    spec.stops[0].weight[1] = -1;
    const double start[5] = {0.02, -0.03, 0.2, 0.35, 0.05};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        compare(&spec, model, start, 4, keys[k], 3);
    saltus_model_release(model);
}

static void the_pipe(void **unused) {
    (void)unused;
    static const char *const keys[] = {"omega", "alpha", "beta", "kappa", "u0", "sigma", "d", "r", "xi"};
    const saltus_model *model = pipe_text();
    for (int modes = 1; modes <= 5; modes += 2) {
        saltus_spec spec = pipe_spec(modes, 42);
        double start[10] = {0};
        add_stop(&spec, 0.012, 0.9, SALTUS_UPPER);
        spec.stops[0].xi = 0.4;
        start[0] = 0.006;
        start[modes] = 0.12;
        if (modes > 1)
            start[1] = 0.002;
        for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
            compare(&spec, model, start, 1.5, keys[k], 1);
    }
    saltus_model_release(model);
}

/* Trajectories of a text in lanes have the bits of single ones, with tangent vectors. */
static void lanes_of(const saltus_spec *spec, int periods) {
    enum { lanes = 16 };
    saltus_system *system = build(spec);
    const saltus_system *all[lanes];
    const int n = saltus_system_dimension(system),
              width = saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX);
    const double *scale = saltus_system_scale(system);
    static double start[lanes][state_max], state[2][state_max], columns[2][2 * state_max];
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_event event;
    saltus_flow *flow, *alone;
    options.columns = 2;
    options.integrator = SALTUS_TAYLOR;
    assert_true(n <= state_max && width > 1 && width <= lanes);
    for (int l = 0; l < width; l++) {
        all[l] = system;
        for (int i = 0; i < n; i++)
            start[l][i] = 0.2 * scale[i] * sin(1.0 + 0.7 * l + 2.3 * i);
    }
    check_ok(saltus_flow_new(all, width, &options, &flow, &message), &message);
    for (int l = 0; l < width; l++) {
        check_ok(saltus_flow_start(flow, l, (saltus_time){0, 0.1}, start[l], &message), &message);
        saltus_flow_aim(flow, l, (saltus_time){periods, 0.01 * l}, 0);
    }
    for (int left = width, lane; left > 0; left--)
        check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
    for (int l = 0; l < width; l++) {
        check_ok(saltus_flow_new(all, 1, &options, &alone, &message), &message);
        check_ok(saltus_flow_start(alone, 0, (saltus_time){0, 0.1}, start[l], &message), &message);
        check_ok(saltus_flow_advance(alone, (saltus_time){periods, 0.01 * l}, 0, &event, &message), &message);
        for (int way = 0; way < 2; way++) {
            saltus_flow_state(way ? flow : alone, way ? l : 0, state[way]);
            saltus_flow_tangents(way ? flow : alone, way ? l : 0, columns[way]);
        }
        assert_memory_equal(state[0], state[1], (size_t)n * sizeof(double));
        assert_memory_equal(columns[0], columns[1], 2 * (size_t)n * sizeof(double));
        saltus_flow_free(alone);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Products of rows and of separate elements, quotients, functions, a choice, a chain. */
static const char *const many_kinds[] = {
    "-x[i] - 0.1*x[i]' - x[i]*sum(j, 1, N, j*x[j]^2) + if(F > 0.5, sqrt(-1 - x[i]^2), F*cos(omega*t))",
    "-x[i]/(1 + x[i]^2) - sin(x[i]) + sum(j, 1, N, if(j > i, x[j]*x[i]'/j, 0)) + F*exp(sin(omega*t))",
    "if(i > 1, x[i-1], 0) - 2*x[i] + if(i < N, x[i+1], 0) - 0.02*x[i]'*(1 + sin(omega*t))^2 + F*0",
};

static const saltus_model *family_text(const char *motion, double forcing) {
    static const saltus_equation families[] = {{"x", "N", 1}};
    const saltus_equation equations[] = {{"x[i]", motion, 2}};
    const saltus_text_parameter parameters[] = {
        {.name = "N", .fallback = 3, .min = 1, .max = 40, .integer = true},
        {.name = "F", .fallback = forcing, .min = 0, .max = 1},
        {.name = "omega", .fallback = 1, .min = 0, .max = 9}};
    saltus_text text = {.origin = "test",
                        .parameters = parameters,
                        .parameter_count = 3,
                        .families = LIST(families),
                        .motion = LIST(equations),
                        .forcing = {"forcing", "omega", 7}};
    saltus_message message = {.text = ""};
    const saltus_model *model = NULL;
    check_ok(saltus_text_model_new(&text, &model, &message), &message);
    return model;
}

static void text_in_lanes(void **unused) {
    (void)unused;
    const saltus_model *pipe = pipe_text();
    saltus_spec spec = pipe_spec(5, 42);
    add_stop(&spec, 0.012, 0.9, SALTUS_UPPER);
    saltus_spec text = in_text(&spec, pipe);
    lanes_of(&text, 6);
    saltus_model_release(pipe);
    for (size_t k = 0; k < sizeof many_kinds / sizeof many_kinds[0]; k++)
        for (int members = 1; members <= 21; members += 4) {
            const saltus_model *model = family_text(many_kinds[k], 0.2);
            spec = saltus_spec_defaults(model);
            set_parameter(&spec, "N", members);
            lanes_of(&spec, 1);
            saltus_model_release(model);
        }
}

/* A chain of equal masses between walls oscillates in its modes sin(pi j i / (N + 1)), with the frequencies 2
 * sin(pi j / (2 (N + 1))). */
static void chain_modes(void **unused) {
    (void)unused;
    const saltus_model *model =
        family_text("if(i > 1, x[i-1], 0) - 2*x[i] + if(i < N, x[i+1], 0) + F*cos(omega*t)", 0);
    for (int masses = 7; masses <= 40; masses += 11) {
        saltus_spec spec = saltus_spec_defaults(model);
        set_parameter(&spec, "N", masses);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        const double part = pi / (masses + 1);
        double state[state_max] = {0};
        options.rtol = 1e-14;
        options.integrator = SALTUS_TAYLOR;
        for (int i = 0; i < masses; i++)
            state[i] = sin(part * (i + 1)) + 0.5 * sin(3 * part * (i + 1));
        saltus_flow *flow = open_flow(system, &options, 0, state);
        advance(flow, 2, 0);
        saltus_flow_state(flow, 0, state);
        for (int i = 0; i < masses; i++)
            check_near(state[i],
                       sin(part * (i + 1)) * cos(2 * sin(part / 2) * 4 * pi) +
                           0.5 * sin(3 * part * (i + 1)) * cos(2 * sin(3 * part / 2) * 4 * pi),
                       1e-11);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
    saltus_model_release(model);
}

/* One text, two fields: an integer parameter chooses the exponent. Such systems share no flow. */
static void whole_parameters(void **unused) {
    (void)unused;
    static const saltus_equation motion[] = {{"x", "-x - x^n + F*cos(omega*t)", 1}};
    static const saltus_text_parameter parameters[] = {
        {.name = "n", .fallback = 2, .min = 1, .max = 9, .integer = true},
        {.name = "F", .fallback = 0.1, .min = 0, .max = 1},
        {.name = "omega", .fallback = 1, .min = 0, .max = 9}};
    saltus_text text = {.origin = "test",
                        .parameters = parameters,
                        .parameter_count = 3,
                        .motion = LIST(motion),
                        .forcing = {"forcing", "omega", 7}};
    saltus_message message = {.text = ""};
    const saltus_model *model = NULL;
    check_ok(saltus_text_model_new(&text, &model, &message), &message);
    saltus_spec spec = saltus_spec_defaults(model);
    saltus_system *square = build(&spec), *cube, *stronger;
    set_parameter(&spec, "F", 0.4);
    stronger = build(&spec);
    set_parameter(&spec, "n", 3);
    cube = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    assert_int_equal(saltus_flow_new((const saltus_system *[]){square, cube}, 2, &options, &flow, &message),
                     SALTUS_BAD_INPUT);
    check_ok(saltus_flow_new((const saltus_system *[]){square, stronger}, 2, &options, &flow, &message),
             &message);
    assert_int_equal(saltus_flow_retune(flow, 0, cube, &message), SALTUS_BAD_INPUT);
    check_ok(saltus_flow_retune(flow, 0, stronger, &message), &message);
    saltus_flow_free(flow);
    saltus_system_free(square);
    saltus_system_free(cube);
    saltus_system_free(stronger);
    saltus_model_release(model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_oscillator), cmocka_unit_test(the_pipe),         cmocka_unit_test(text_in_lanes),
        cmocka_unit_test(chain_modes),    cmocka_unit_test(whole_parameters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
