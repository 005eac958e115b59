/* Scenes with equations as models: refusals with their places, stops and starts that use the text, and result
 * files that contain the whole model.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

#include "check.h"
#include "json.h"

static const char valve[] = "title: valve\n"
                            "model:\n"
                            "  parameters: {kappa: 1.25, delta: 10, beta: 20, q: {default: 7, min: 0}}\n"
                            "  motion:\n"
                            "    x: -kappa*x' - (x + delta) + p\n"
                            "  states:\n"
                            "    p: beta*(q - x*sqrt(p))\n"
                            "stop: {coordinate: x, d: 0, r: 0.8, sides: lower}\n"
                            "initial: {x: 0.5, x': 0.1*delta, p: 2*delta}\n";

static void refused(const char *text, const char *words) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    if (saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message) == SALTUS_OK)
        fail_msg("not refused: %s", text);
    if (!strstr(message.text, words))
        fail_msg("\"%s\" does not say \"%s\" for\n%s", message.text, words, text);
}

/* A model with one line more or another right side, refused with its line. */
static void errors_tell_the_line(void **unused) {
    (void)unused;
    static const struct {
        const char *model, *words;
    } known[] = {
        {"  motion:\n    x: -k*x\n", "my.yaml:3: x: column 2: k: nothing has this name"},
        {"  motion:\n    x: -x +\n", "my.yaml:3: x: column 5: the expression ends too early"},
        {"  parameters: {k: 1}\n  motion:\n    x: -k*x\n    k: 1\n",
         "my.yaml:5: k: is a parameter already (line 2)"},
        {"  motion:\n    t: 1\n", "my.yaml:3: t: this name is reserved"},
        {"  parameters: {damping_of_this_one_and_only_one: 1}\n  motion: {x: -x}\n",
         "my.yaml:2: damping_of_this_one_and_only_one: a name must have 1 to 31 characters"},
        {"  motion:\n    d2: 1\n", "my.yaml:3: d2: this name is reserved"},
        {"  motion:\n    x: -x\n  forcing: omega\n", "my.yaml:4: forcing: omega is not a parameter"},
        {"  motion:\n    x: -x + cos(t)\n", "my.yaml:3: x: column 10: t: the system has no forcing"},
        {"  motion:\n    x: -x - sign(x')\n", "switches the equations, which is not possible yet"},
        {"  motion:\n    x: -x - y'\n  states:\n    y: 1\n", "y is a first-order state and has no velocity"},
        {"  motion:\n    x[i]: -x[i]\n", "my.yaml:3: x[i]: x is not among the families"},
        {"  motion:\n    x': -x\n",
         "my.yaml:3: x': a left side has no prime: the acceleration of x stands under x"},
        {"  families: {x: 2}\n  motion:\n    x[i]: -x[i]\n    x[1]': 1\n",
         "my.yaml:5: x[1]': a left side has no prime"},
        {"  families: {x: 2}\n  motion:\n    x[i]: -x[i]\n    x[1]foo: 1\n",
         "my.yaml:5: x[1]foo: must be a name, or a name with one index"},
        {"  families: {x: 2}\n  motion:\n    x[i]: -x[i]\n  mass:\n    x[2]junk: 3\n",
         "my.yaml:6: x[2]junk: must be a name, or a name with one index"},
        {"  families: {x: 3}\n  motion:\n    x[i]: -x[i+1]\n", "x[4]: the index must be from 1 to 3"},
        {"  families: {x: 3}\n  motion:\n    x[i]: -x\n", "x is a family of 3; say which one, such as x[1]"},
        {"  families: {x: 3}\n  motion:\n    x[1]: -x[1]\n", "x[2] has no equation"},
        {"  let: {a: b, b: a}\n  motion:\n    x: a\n", "is defined by itself"},
        {"  parameters: {k: {min: 1}}\n  motion: {x: 1}\n", "my.yaml:2: k: default is missing"},
        {"  parameters: {k: {default: 0, min: 1}}\n  motion: {x: 1}\n",
         "k: the default must lie between min and max"},
        {"  parameters: {k: fast}\n  motion: {x: 1}\n", "my.yaml:2: k = fast: "},
        {"  parameters: {k: 1, omega: 2}\n  motion:\n    x: -x + cos(omega*t)\n  forcing: omega\n",
         "my.yaml:2: k: no equation has this parameter"},
        {"  parameters: {omega: 2}\n  motion:\n    x: -x + cos(0.5*omega*t)\n  forcing: omega\n",
         "my.yaml:4: x: time must enter with the period of the forcing"},
        {"  parameters: {omega: 2, phi: 0}\n  forcing: omega\n  motion:\n    y: -y\n    x: cos((omega + "
         "phi)*t)\n",
         "my.yaml:6: x: time must enter with the period of the forcing"},
        {"  parameters: {kappa: 1}\n  motion:\n    x: -kapa*x\n",
         "my.yaml:4: x: column 2: kapa: nothing has this name; did you mean kappa?"},
        {"  let: {drag: x'}\n  motion:\n    x: -x - darg\n", "column 6: darg: nothing has this name; did you "
                                                             "mean drag?"},
        {"  motion:\n    x: 2*sine(x)\n",
         "my.yaml:3: x: column 3: there is no function of this name; did you mean sin?"},
        {"  motion:\n    x: 1/(2*x - x - x)\n",
         "my.yaml:3: x: column 2: a division by what is zero everywhere"},
        {"  motion:\n    x: x/(1 - 1)\n", "my.yaml:3: x: column 2: a division by zero"},
        {"  motion:\n    x: atan2(x)\n", "my.yaml:3: x: column 1: atan2 takes 2 arguments, not 1"},
        {"  let: {y: min(1, 2)}\n  motion:\n    x: -x*y\n",
         "my.yaml:2: 2): is no name; an expression with a comma needs quotation marks inside { }: {y: "
         "\"min(1, 2)\"}"},
        {"  motion: {x: -x}\nstop: {coordinate: max(x, 0), d: 1}\n", "my.yaml:3: 0): is no name"},
        {"  motion:\n    x: *x\n", "put an expression that begins with * in quotation marks"},
        {"  motion:\n    x: - x\n", "begins with '- '"},
        {"  motion:\n    x: &a*x\n", "no value begins with &; put it in quotation marks"},
        {"  motion: {x: 1}\n  when: []\n", "my.yaml:3: when: is not possible yet"},
        {"  motion: {x: 1}\n  sates: {y: 1}\n", "my.yaml:3: \"sates\": unknown key; did you mean states?"},
        {"  parameters: {}\n", "motion is missing"},
        {"  motion: {x: 1}\n  mass: {y: 2}\n", "my.yaml:3: y: y is no displacement"},
        {"  motion: {x: 1}\n  mass: {x: 1 + x}\n",
         "mass: one that depends on the state or on time is not possible yet"},
        {"  motion: {x: 1}\nstop: {d: 1}\n", "my.yaml:3: stop: coordinate is missing"},
        {"  motion: {x: 1}\nstop: {coordinate: x^2, d: 1}\n",
         "my.yaml:3: coordinate: a coordinate that is not linear"},
        {"  motion: {x: 1}\n  states: {z: 1}\nstop: {coordinate: x + z, d: 1}\n",
         "my.yaml:4: coordinate: must be a sum of displacements"},
        {"  motion: {x: 1}\n  parameters: {omega: 1}\n  forcing: omega\nstop: {coordinate: x + cos(omega*t), "
         "d: 1}\n",
         "my.yaml:5: coordinate: a coordinate that moves in time is not possible yet"},
        {"  states: {x: -x}\n", "model: motion is missing; it holds the equations of displacements"},
        {"  motion: {x: speed}\nstop: {coordinate: x, d: 1}\n",
         "my.yaml:2: x: column 1: speed: the closing speed belongs to a restitution r"},
        {"  motion: {x: 1}\nstop: {coordinate: x, d: 1, r: 0.9 - 0.1*x}\n",
         "my.yaml:3: r: must be made of numbers and parameters, and the closing speed"},
        {"  motion: {x: 1}\nstop: {coordinate: x, d: speed, r: 0.5}\n",
         "my.yaml:3: d: column 1: speed: the closing speed belongs to a restitution r"},
        {"  let: {g: 0.5 + 0.1*speed}\n  motion: {x: 1 - x}\n  section: {zero: g}\n"
         "stop: {coordinate: x, d: 1, r: g}\n",
         "section: zero: column 1: speed: the closing speed belongs to a restitution r"},
        {"  motion: {x: 1}\nstop: {coordinate: x, d: 1, r: 1.5 - speed}\n",
         "my.yaml:3: r = 1.5: must be at least 0 and at most 1"},
        {"  motion: {x: 1}\nstop: {coordinate: x}\n", "d is missing"},
        {"  motion: {x: 1}\ninitial: {y: 1}\n", "my.yaml:3: y: y is no displacement, velocity or state"},
    };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        char text[500];
        snprintf(text, sizeof text, "model:\n%s", known[k].model);
        refused(text, known[k].words);
    }
    refused("model: duffing\nc: 3\nkk: 4\n", "my.yaml:1: model = \"duffing\": is a scene, not a model");
    refused("model: spring\nc: 3\nkk: 4\n", "my.yaml:1: model = \"spring\": unknown; the models are pipe");
    /* A divisor that is zero at the defaults, or only sometimes, is not refused. */
    saltus_scene scene;
    saltus_message message = {.text = ""};
    static const char good[] = "model:\n  parameters: {a: 0, n: 1}\n  motion:\n    x: a/(1 + a) - x/(n - "
                               "1 + x) + 1/(x - x')\n";
    check_ok(saltus_scene_parse(good, strlen(good), "my.yaml", &scene, &message), &message);
    saltus_scene_clear(&scene);
}

/* Clearance and restitution may be expressions of parameters: their columns follow, and --set of the
 * parameter moves them. The initial state is the text's. */
static void stops_and_starts_follow_parameters(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {c: 0.1, gap: 0.3, loss: 0.2, F: 1, omega: 1.1}\n"
                               "  motion: {x: \"-c*x' - x + F*cos(omega*t)\"}\n"
                               "  forcing: omega\n"
                               "stop: {coordinate: 2*x, d: 2*gap, r: 1 - loss, sides: both}\n"
                               "initial: {x: gap/3, x': -loss}\n";
    saltus_scene scene;
    saltus_message message = {.text = ""};
    double state[2];
    check_ok(saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message), &message);
    check_ok(saltus_scene_set(&scene, "gap=0.6", &message), &message);
    saltus_system *system = build(&scene.spec);
    saltus_face face = saltus_system_face(system, 0);
    check_near(face.d, 1.2, 1e-15);
    check_near(face.r, 0.8, 1e-15);
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_near(state[0], 0.2, 1e-15);
    check_near(state[1], -0.2, 1e-15);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

/* A constant part of a coordinate shifts the stop: the motion and its derivatives are the same, up to
 * rounding, as with the shifted clearance, on either side. */
static void a_constant_part_shifts_the_stop(void **unused) {
    (void)unused;
    static const char form[] = "model:\n"
                               "  parameters: {c: 0.1, gap: 0.25, F: 1, omega: 1.1}\n"
                               "  let: {place: gap + x}\n"
                               "  motion: {x: \"-c*x' - x + F*cos(omega*t)\"}\n"
                               "  observe: {seen: x + gap}\n"
                               "  forcing: omega\n"
                               "stops:\n  - {coordinate: %s, d: %s, r: 0.8}\n  - {coordinate: %s, d: %s, r: "
                               "0.7, sides: lower}\n";
    static const char *const words[2][4] = {{"2*place - 1", "0.125", "x - 2*gap", "0.25"},
                                            {"2*x", "1.125 - 2*gap", "x", "0.25 - 2*gap"}};
    double states[2][2], columns[2][2][2];
    for (int k = 0; k < 2; k++) {
        char text[800];
        saltus_scene scene;
        saltus_message message = {.text = ""};
        snprintf(text, sizeof text, form, words[k][0], words[k][1], words[k][2], words[k][3]);
        check_ok(saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message), &message);
        saltus_system *system = build(&scene.spec);
        assert_int_equal(saltus_system_face_count(system), 2);
        check_near(saltus_system_face(system, 0).d, 0.625, 1e-15);
        check_near(saltus_system_face(system, 1).d, -0.25, 1e-15);
        saltus_flow_options options = saltus_flow_defaults();
        options.columns = options.directions = 2;
        saltus_direction directions[2];
        check_ok(saltus_spec_direction(&scene.spec, "gap", &directions[0], NULL, &message), &message);
        check_ok(saltus_spec_direction(&scene.spec, "c", &directions[1], NULL, &message), &message);
        saltus_flow *flow = NULL;
        const saltus_system *one = system;
        check_ok(saltus_flow_new(&one, 1, &options, &flow, &message), &message);
        saltus_flow_set_directions(flow, directions);
        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, (const double[]){0.28, 0.1}, &message),
                 &message);
        advance(flow, 1.3, 0);
        assert_true(saltus_flow_information(flow, 0).impacts >= 3);
        saltus_flow_state(flow, 0, states[k]);
        saltus_flow_tangents(flow, 0, columns[k][0]);
        saltus_flow_free(flow);
        saltus_column_check checks[SALTUS_COLUMN_CHECKS_MAX];
        int count;
        check_ok(saltus_columns_check(system, (const double[]){0.28, 0.1}, NULL, checks, &count, &message),
                 &message);
        for (int c = 0; c < count; c++)
            if (!checks[c].agrees || !(checks[c].difference < 1e-7))
                fail_msg("the column of %s is off by %.3g", checks[c].name, checks[c].difference);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
    for (int i = 0; i < 2; i++) {
        check_near(states[0][i], states[1][i], 1e-12);
        for (int c = 0; c < 2; c++)
            check_near(columns[0][c][i], columns[1][c][i], 1e-11 * (1 + fabs(columns[1][c][i])));
    }
}

/* The valve between two impacts, and at the one between, by hand: x'' and p' of the paper's equations. */
static void a_relief_valve(void **unused) {
    (void)unused;
    saltus_scene scene;
    saltus_message message = {.text = ""};
    double state[3], by_hand[3] = {0.5, 1, 20};
    check_ok(saltus_scene_parse(valve, strlen(valve), "my.yaml", &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    check_ok(saltus_system_default_state(system, state, &message), &message);
    assert_memory_equal(state, by_hand, sizeof state);
    assert_false(saltus_system_forced(system));
    check_near(saltus_system_period(system), 1, 0);
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-14;
    saltus_flow *flow = open_flow(system, &options, 0, state);
    advance(flow, 0.2, 0);
    saltus_flow_state(flow, 0, state);
    /* Runge-Kutta of fourth order with steps of 1e-5. */
    for (int k = 0; k < 20000; k++) {
        double rate[4][3], y[3];
        for (int stage = 0; stage < 4; stage++) {
            const double part = stage == 0 ? 0 : stage == 3 ? 1e-5 : 0.5e-5;
            for (int i = 0; i < 3; i++)
                y[i] = by_hand[i] + (stage ? part * rate[stage - 1][i] : 0);
            rate[stage][0] = y[1];
            rate[stage][1] = -1.25 * y[1] - (y[0] + 10) + y[2];
            rate[stage][2] = 20 * (7 - y[0] * sqrt(y[2]));
        }
        for (int i = 0; i < 3; i++)
            by_hand[i] += 1e-5 / 6 * (rate[0][i] + 2 * rate[1][i] + 2 * rate[2][i] + rate[3][i]);
    }
    for (int i = 0; i < 3; i++)
        check_near(state[i], by_hand[i], 1e-11 * (1 + fabs(by_hand[i])));
    saltus_flow_free(flow);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

/* Orbits, branches and sweeps of a text scene are resumed from their files alone, which contain the model. */
static void files_tell_the_model(void **state) {
    free(told(*state, "orbit duffing --periods 1 --json"));
    free(told(*state, "continue duffing --in F=0.24:0.27 -o branch.h5"));
    char *orbit = told(*state, "orbit duffing --from branch.h5:3 --json");
    assert_non_null(strstr(orbit, "\"motion\": {\"x\": "));
    free(orbit);
    free(told(*state, "plot branch.h5 -o branch.png"));
    /* State entries have names; members of a multiplier do not. */
    free(told(*state, "export branch.h5 -o branch.csv"));
    size_t bytes;
    char *table = read_all(path_in(*state, "branch.csv"), &bytes);
    assert_non_null(strstr(table, ",x,x',"));
    assert_non_null(
        strstr(table, ",multiplier1_re,multiplier1_im,multiplier2_re,multiplier2_im,log_modulus1,"));
    free(table);
    free(told(*state, "sweep chain --over F=0.2:0.6:5 --at-most 100 --set N=3 -o sweep.h5"));
    free(told(*state, "plot sweep.h5 -o sweep.png"));
    saltus_branch_file file;
    saltus_message message = {.text = ""};
    check_ok(saltus_branch_file_read(path_in(*state, "branch.h5"), &file, &message), &message);
    saltus_scene scene;
    check_ok(saltus_scene_load("duffing", &scene, &message), &message);
    assert_true(saltus_model_same(file.spec.model, scene.spec.model));
    saltus_branch_file_clear(&file);
    saltus_scene_clear(&scene);
    check_ok(saltus_scene_load("chain", &scene, &message), &message);
    saltus_sweep_file sweep;
    check_ok(saltus_sweep_file_read(path_in(*state, "sweep.h5"), &sweep, &message), &message);
    assert_true(saltus_model_same(sweep.spec.model, scene.spec.model));
    assert_true(saltus_spec_get(&sweep.spec, "N") == 3);
    saltus_sweep_file_clear(&sweep);
    saltus_scene_clear(&scene);
}

/* YAML writes numbers in more ways than JSON: what is told is JSON, and leads back to the same scene. */
static void all_numbers_are_told_as_json(void **state) {
    fixture *f = *state;
    FILE *file = fopen(path_in(f, "numbers.yaml"), "w");
    assert_non_null(file);
    fputs("model:\n"
          "  parameters: {a: 1.e-1, b: 007, c: -.5, e: 1e+2, g: +3, h: 0.25E-1, k: 0, omega: 1.2}\n"
          "  motion: {x: -1e-3*(a + b + c + e + g + h + k)*x' - x + .5*cos(omega*t)}\n"
          "  forcing: omega\n"
          "stop: {coordinate: x, d: 0.3, r: .7, sides: upper}\n",
          file);
    fclose(file);
    char *text = told(f, "classify numbers.yaml --json");
    json_free(json_read(text));
    file = fopen(path_in(f, "numbers.json"), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    free(text);
    text = told(f, "orbit numbers.yaml --from numbers.json --periods 1");
    assert_non_null(strstr(text, "a = 0.1, b = 7, c = -0.5, e = 100, g = 3, h = 0.025, k = 0"));
    free(text);
}

/* Names from a scene are used everywhere: in --set, columns of tables, axes, quantities of spectra, --json;
 * the numbers are those of the state's entries. */
static void names_are_those_of_the_text(void **state) {
    fixture *f = *state;
    FILE *file = fopen(path_in(f, "valve.yaml"), "w");
    assert_non_null(file);
    fprintf(file, "%s", valve);
    fclose(file);
    file = fopen(path_in(f, "seen.yaml"), "w");
    assert_non_null(file);
    for (const char *line = valve; *line; line = strchr(line, '\n') + 1)
        fprintf(file, "%.*s%s", (int)strcspn(line, "\n") + 1, line,
                strncmp(line, "  states", 8) == 0 ? ""
                : strncmp(line, "    p:", 6) == 0 ? "  observe: {lift: x, power: p*x'}\n"
                                                  : "");
    fclose(file);
    free(told(f, "simulate seen.yaml --set x=0.25 x_dot=-0.5 p=19 --periods 1 -o run.csv"));
    size_t length;
    char *table = read_all(path_in(f, "run.csv"), &length), *head = strstr(table, "\ntime_over_T,");
    static const char columns[] = "\ntime_over_T,displacement,velocity,x,x',p,lift,power,stop,side,event\n";
    assert_non_null(head);
    assert_memory_equal(head, columns, strlen(columns));
    double row[8];
    char *at = head + strlen(columns);
    for (int rows = 0; *at; rows++, at = strchr(at, '\n') + 1) {
        for (int k = 0; k < 8; k++, at++)
            row[k] = strtod(at, &at);
        assert_true(row[1] == row[3] && row[2] == row[4] && row[6] == row[3]);
        check_near(row[7], row[5] * row[4], 1e-15 * fabs(row[7]));
        if (rows == 0)
            assert_true(row[3] == 0.25 && row[4] == -0.5 && row[5] == 19);
    }
    free(table);
    free(told(f, "simulate valve.yaml --periods 1 -o run.h5"));
    free(told(f, "export run.h5 -o run2.csv"));
    table = read_all(path_in(f, "run2.csv"), &length);
    assert_non_null(strstr(table, "\ntime_over_T,displacement,velocity,x,x',p,"));
    free(table);
    free(told(f, "basins duffing --over x=-1:1:2 --over x_dot=-1:1:2 -o basins.h5"));
    char *text = told(f, "classify duffing --json");
    assert_non_null(strstr(text, "\"state_names\": [\"x\", \"x'\"], \"state\": ["));
    free(text);
    text = told(f, "spectrum duffing --of x_dot -o spectrum.csv");
    assert_non_null(strstr(text, "\n  x'            mean "));
    free(text);
    assert_int_equal(run(f, "check duffing --set y=1"), 2);
    text = said(f, "err");
    assert_non_null(strstr(text, "\"y\": unknown key; the keys here are "));
    assert_non_null(strstr(text, "omega, sides, d, r, observe, section, x, x'"));
    free(text);
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load("chain", &scene, &message), &message);
    check_ok(saltus_scene_set(&scene, "x4'=0.5", &message), &message);
    assert_true(scene.initial[8] == 0.5);
    assert_int_equal(saltus_scene_set(&scene, "x6'=0.5", &message), SALTUS_BAD_INPUT);
    saltus_scene_clear(&scene);
}

/* A motion that leaves the domain of its equations ends there, in every command, with the failing part and
 * the time: p falls to zero at a time known in closed form, while the rest of the state hardly changes. */
static void faults_end_a_motion(void **state) {
    fixture *f = *state;
    FILE *file = fopen(path_in(f, "empty.yaml"), "w");
    assert_non_null(file);
    /* The branch not chosen has no value on the way: it is not blamed. */
    fputs("model:\n  parameters: {F: 1, omega: 1.1, drain: 0.5}\n  motion: {x: \"-x - 0.1*x' + "
          "F*cos(omega*t) - if(drain < 0, sqrt(p - 100), 1e-3*sqrt(p))\"}\n  states: {p: -drain}\n  forcing: "
          "omega\n"
          "stop: {coordinate: x, d: 0.3, r: 0.8}\ninitial: {x: 0, x': 0, p: 30}\n",
          file);
    fclose(file);
    static const char *const lines[] = {"simulate empty.yaml --periods 20 -o never.csv",
                                        "classify empty.yaml",
                                        "orbit empty.yaml --periods 1",
                                        "continue empty.yaml --in omega=1:1.2 -o never.h5",
                                        "lyapunov empty.yaml",
                                        "simulate empty.yaml --set p=-1 --periods 2 -o never.csv"};
    const double ends = 30 / 0.5 * 1.1 / (2 * acos(-1.0));
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        double when = -1;
        assert_int_equal(run(f, lines[k]), 1);
        char *text = said(f, "err");
        if (sscanf(text, "saltus: the motion ends at %lf periods: sqrt(p) has no value where p = -", &when) !=
            1)
            fail_msg("%s: %s", lines[k], text);
        check_near(when, k == 5 ? 0 : ends, 1e-12 * ends);
        free(text);
    }
    /* What does not depend on the state has no value from the start. */
    file = fopen(path_in(f, "never.yaml"), "w");
    assert_non_null(file);
    fputs("model: {parameters: {p: -1}, motion: {x: -sqrt(p)*x}}\ninitial: {x: 0.5}\n", file);
    fclose(file);
    assert_int_equal(run(f, "simulate never.yaml --periods 2 -o never.csv"), 1);
    char *never = said(f, "err");
    assert_non_null(strstr(never, "at 0 periods: "));
    assert_non_null(strstr(never, "sqrt(p) has no value where p = -1"));
    free(never);
    assert_int_equal(run(f, "sweep empty.yaml --over omega=1:1.2:9 --quiet -o sweep.csv"), 1);
    char *text = said(f, "out"), *why = said(f, "err");
    assert_non_null(strstr(text, "failed                      9  100.00 %"));
    assert_non_null(strstr(why, "saltus: no trajectory could be followed; the first: the motion ends at "));
    free(text);
    free(why);
}

static void put_text(fixture *f, const char *name, const char *text) {
    FILE *file = fopen(path_in(f, name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* Equations in a separate file can be used by scenes beside it, and errors name that file. Results do not
 * need it any more. */
static void models_stand_in_files(void **state) {
    fixture *f = *state;
    put_text(f, "law.yaml",
             "parameters: {c: 0.2, F: 0.3, omega: 2*pi/5}\n"
             "motion: {x: \"-c*x' + x - x^3 + F*cos(omega*t)\"}\nforcing: omega\n");
    put_text(f, "one.yaml",
             "model: law.yaml\nF: 1/4\nstop: {coordinate: x, d: 13/10, r: 4/5}\ninitial: {x: pi/100}\n");
    char here[400], line[600];
    snprintf(here, sizeof here, "%s", path_in(f, "one.yaml"));
    saltus_scene scene;
    saltus_message message = {.text = ""};
    double start[2];
    check_ok(saltus_scene_load(here, &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    assert_true(saltus_spec_get(&scene.spec, "F") == 0.25 && saltus_spec_get(&scene.spec, "d") == 1.3);
    check_near(saltus_system_period(system), 5, 1e-14);
    check_ok(saltus_scene_state(&scene, system, start, &message), &message);
    check_near(start[0], acos(-1.0) / 100, 1e-16);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    /* A whole scene can be used too; only its equations are taken. */
    put_text(f, "two.yaml", "model: one-whole.yaml\n");
    put_text(f, "one-whole.yaml", "model:\n  motion: {x: -x}\nstop: {coordinate: x, d: 1}\n");
    check_ok(saltus_scene_load(path_in(f, "two.yaml"), &scene, &message), &message);
    assert_int_equal(scene.spec.stop_count, 0);
    saltus_scene_clear(&scene);
    free(told(f, "continue one.yaml --in F=0.24:0.27 -o branch.h5"));
    snprintf(line, sizeof line, "%s", path_in(f, "law.yaml"));
    remove(line);
    free(told(f, "plot branch.h5 -o branch.png"));
    assert_int_equal(run(f, "orbit one-whole.yaml --from branch.h5:3"), 2);
    char *text = said(f, "err");
    assert_non_null(strstr(text, "branch.h5:3: is an orbit of other equations than the scene's"));
    free(text);
    static const struct {
        const char *model, *scene, *words;
    } wrong[] = {
        {NULL, "model: law.yaml\n", "wrong.yaml:1: model: "},
        {"motion: {x: -y}\n", "model: law.yaml\n", "law.yaml:1: x: column 2: y: nothing has this name"},
        {"motion: {x: -x}\n", "model: law.yaml\nstop: {coordinate: y, d: 1}\n",
         "wrong.yaml:2: coordinate: column 1: y: nothing has this name"},
        {"motion: {x: -x}\n", "model: law.yaml\n\ninitial: {x: y}\n",
         "wrong.yaml:3: x: column 1: y: nothing"},
        {"motion: {x: -x}\n", "model: law.yaml\nk: 1\n", "wrong.yaml:2: \"k\": not a key of the model text"},
        {"[1, 2]\n", "model: law.yaml\n", "law.yaml: holds no equations"},
        {"model: pipe\n", "model: law.yaml\n", "law.yaml: holds no equations"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        if (wrong[k].model)
            put_text(f, "law.yaml", wrong[k].model);
        put_text(f, "wrong.yaml", wrong[k].scene);
        if (saltus_scene_load(path_in(f, "wrong.yaml"), &scene, &message) == SALTUS_OK)
            fail_msg("not refused: %s", wrong[k].scene);
        if (!strstr(message.text, wrong[k].words))
            fail_msg("\"%s\" does not say \"%s\"", message.text, wrong[k].words);
    }
}

/* The longest names are accepted wherever short ones are. */
static void long_names_are_keys(void **state) {
    fixture *f = *state;
    put_text(f, "long.yaml",
             "model:\n  parameters: {damping_of_the_one_and_only_one: 0.3, omega: 1.1}\n"
             "  motion: {displacement_of_a_long_name: \"-displacement_of_a_long_name - "
             "damping_of_the_one_and_only_one*displacement_of_a_long_name' + "
             "cos(omega*t)\"}\n  forcing: omega\n");
    free(told(f, "continue long.yaml --in damping_of_the_one_and_only_one=0.2:0.4 -o branch.h5"));
    free(told(f, "orbit long.yaml --from branch.h5:2 --json"));
    free(told(f, "plot branch.h5 -o branch.png"));
    free(told(f, "sweep long.yaml --over damping_of_the_one_and_only_one=0.2:0.4:2 --over "
                 "displacement_of_a_long_name_dot=-0.125:0.125:2 -o sweep.h5"));
    free(told(f, "export sweep.h5 -o sweep.csv"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_tell_the_line),
        cmocka_unit_test(stops_and_starts_follow_parameters),
        cmocka_unit_test(a_constant_part_shifts_the_stop),
        cmocka_unit_test(a_relief_valve),
        cmocka_unit_test_setup_teardown(all_numbers_are_told_as_json, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(names_are_those_of_the_text, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(faults_end_a_motion, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(models_stand_in_files, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(long_names_are_keys, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(files_tell_the_model, open_fixture, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
