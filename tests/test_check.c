/* saltus check: printed equations read back as the same system, and wrong derivatives are reported.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

#include "check.h"

/* All kinds of operations, with signs and operator precedence that printing may get wrong. */
static const char tangle[] =
    "model:\n"
    "  parameters: {a: 0.7, b: 1.3, n: 2.5, omega: 1.1}\n"
    "  constants: {K: [[2, -1], [-1, 3]]}\n"
    "  let: {e: y - x, f: \"sum(i, 1, 2, K[1, i]*a^i)\"}\n"
    "  motion:\n"
    "    x: -(a - b)*x - (-x)^2 + a/(b*(1 + e^2)) - a/b/n - (a/b)/(n/a) + 2*-x\n"
    "    y: \"if(a < b, -x^3 - f*y, y) - (x + y)^2 + exp(-x^2)/sqrt(1 + x^2) - tanh(x - (y - p))\"\n"
    "  mass: {x: {x: 2, y: 0.5}, y: {y: a + b}}\n"
    "  states: {p: \"-n*(p - x*y') + abs(a - b)*sin(omega*t)*cos(2*omega*t - 1) - (2 - p)^(b + 1)\"}\n"
    "  forcing: omega\n";

/* Write the scene whose equations are the printed right sides. */
static void read_back(const saltus_system *system, char *text, size_t room) {
    const saltus_spec *spec = saltus_system_spec(system);
    const int dof = saltus_system_dof(system), all = dof + saltus_system_extra(system);
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    size_t used = (size_t)snprintf(text, room, "model:\n  parameters: {");
    for (int k = 0; k < count; k++)
        if (!p[k].integer)
            used += (size_t)snprintf(text + used, room - used, "%s: %.17g, ", p[k].name, spec->parameters[k]);
    used += (size_t)snprintf(text + used, room - used, "}\n%s  observe:\n    all: 0",
                             saltus_system_forced(system) ? "  forcing: omega\n" : "");
    for (int k = 0; k < count; k++) /* otherwise those of the stops would be unused */
        if (!p[k].integer)
            used += (size_t)snprintf(text + used, room - used, " + %s", p[k].name);
    used += (size_t)snprintf(text + used, room - used, "\n");
    for (int i = 0; i < all; i++) {
        char *right = saltus_system_right_side(system, i);
        assert_non_null(right);
        used += (size_t)snprintf(text + used, room - used, "%s    %s: \"%s\"\n",
                                 i == 0     ? "  motion:\n"
                                 : i == dof ? "  states:\n"
                                            : "",
                                 saltus_system_state_name(system, i < dof ? i : i + dof).text, right);
        free(right);
    }
    assert_true(used < room);
}

static void check_read_back(const saltus_scene *scene) {
    char text[20000];
    saltus_message message = {.text = ""};
    saltus_scene again;
    saltus_spec free_spec = scene->spec;
    free_spec.stop_count = 0;
    saltus_system *system = build(&free_spec);
    const saltus_flow_options options = saltus_flow_defaults();
    read_back(system, text, sizeof text);
    check_ok(saltus_scene_parse(text, strlen(text), "again", &again, &message), &message);
    saltus_system *other = build(&again.spec);
    const int n = saltus_system_dimension(system);
    assert_int_equal(saltus_system_dimension(other), n);
    for (int k = 0; k < 8; k++) {
        double state[SALTUS_STATE_MAX], field[2][SALTUS_STATE_MAX], size = 0;
        for (int i = 0; i < n; i++)
            state[i] = 0.6 * sin(3.1 * k + 1.7 * i + 0.3);
        const saltus_system *const both[] = {system, other};
        for (int s = 0; s < 2; s++) {
            saltus_flow *flow = open_flow(both[s], &options, 0.07 + 0.11 * k, state);
            saltus_flow_field(flow, 0, field[s]);
            saltus_flow_free(flow);
        }
        for (int i = 0; i < n; i++)
            size = fmax(size, fabs(field[0][i]));
        for (int i = 0; i < n; i++)
            /* A state may be outside a function's domain, then in both systems. */
            if (!(isnan(field[0][i]) && isnan(field[1][i])) &&
                !(fabs(field[0][i] - field[1][i]) <= 1e-13 * size))
                fail_msg("entry %d: %.17g became %.17g in\n%s", i, field[0][i], field[1][i], text);
    }
    saltus_system_free(other);
    saltus_system_free(system);
    saltus_scene_clear(&again);
}

static void equations_read_back(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_scene scene;
    int texts = 0;
    check_ok(saltus_scene_parse(tangle, strlen(tangle), "tangle", &scene, &message), &message);
    check_read_back(&scene);
    saltus_scene_clear(&scene);
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        check_ok(saltus_scene_load(saltus_scene_builtin_name(k), &scene, &message), &message);
        if (saltus_model_text(scene.spec.model)) {
            check_read_back(&scene);
            texts++;
        }
        saltus_scene_clear(&scene);
    }
    assert_true(texts >= 2);
}

/* The report of a system from text: names of states, equations, masses at impacts. */
static void a_text_is_told(void **state) {
    FILE *file = fopen(path_in(*state, "two.yaml"), "w");
    assert_non_null(file);
    fputs("model:\n  parameters: {m: 2, k: 3}\n  motion:\n    x: -k*(x - y)\n    y: -k*(y - x) - 0.1*y'\n"
          "  mass: {x: m, y: 4}\nstop: {coordinate: x - y, d: 1/4, r: 0.5}\n",
          file);
    fclose(file);
    char *text = told(*state, "check two.yaml");
    static const char *const lines[] = {"state: 4 numbers (x, y, x', y')\n",
                                        "  x'' = ",
                                        "  y'' = ",
                                        "metric of impacts: masses 2, 4\n",
                                        "symmetry: none found",
                                        "no forcing: time is counted in units of 1, "};
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++)
        if (!strstr(text, lines[k]))
            fail_msg("no line \"%s\" in\n%s", lines[k], text);
    free(text);
}

/* Every column of all models' scenes agrees; at a kink, which has no derivative, the one that the program
 * takes does not, and is named. */
static void wrong_derivatives_are_told(void **state) {
    static const char *const scenes[] = {"duffing", "chain --set N=3", "two-mass", "fig7d --set N=2"};
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        char line[100];
        snprintf(line, sizeof line, "check %s --derivatives", scenes[k]);
        char *text = told(*state, line);
        assert_non_null(strstr(text, "\n  by r1 "));
        assert_null(strstr(text, "not compared"));
        free(text);
    }
    FILE *file = fopen(path_in(*state, "kink.yaml"), "w");
    assert_non_null(file);
    fputs("model:\n  parameters: {k: 1, p: 0}\n  motion: {x: \"-k*x + max(p, 0)\"}\n", file);
    fclose(file);
    assert_int_equal(run(*state, "check kink.yaml --derivatives"), 1);
    char *text = said(*state, "out"), *wrong = strstr(text, "WRONG");
    assert_non_null(wrong);
    assert_non_null(strstr(text, "  by p        WRONG"));
    assert_null(strstr(wrong + 1, "WRONG"));
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equations_read_back),
        cmocka_unit_test_setup_teardown(a_text_is_told, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(wrong_derivatives_are_told, open_fixture, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
