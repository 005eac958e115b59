/* Scenes: built-in ones, files, JSON, settings, and a message for every possible error.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "saltus/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static saltus_scene parse(const char *text) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    if (saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message) != SALTUS_OK)
        fail_msg("%s", message.text);
    return scene;
}

static saltus_scene load(const char *name) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    if (saltus_scene_load(name, &scene, &message) != SALTUS_OK)
        fail_msg("%s", message.text);
    return scene;
}

static void expect_words(const saltus_message *message, const char *words, const char *about) {
    if (!strstr(message->text, words))
        fail_msg("for '%s': got '%s', expected '%s'", about, message->text, words);
}

/* The text is refused with a message that begins with these words. */
static void refused(const char *text, const char *words) {
    saltus_scene scene, before;
    saltus_message message = {.text = ""};
    memset(&scene, 0x5a, sizeof scene);
    before = scene;
    assert_int_equal(saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message), SALTUS_BAD_INPUT);
    assert_memory_equal(&scene, &before, sizeof scene);
    assert_int_equal(strncmp(message.text, "my.yaml:", 8), 0);
    expect_words(&message, words, text);
    assert_null(strchr(message.text, '\n'));
}

static void set(saltus_scene *scene, const char *assignment) {
    saltus_message message = {.text = ""};
    if (saltus_scene_set(scene, assignment, &message) != SALTUS_OK)
        fail_msg("%s: %s", assignment, message.text);
}

static void set_refused(const saltus_scene *scene, const char *assignment, const char *words) {
    saltus_scene changed = *scene;
    saltus_message message = {.text = ""};
    assert_int_equal(saltus_scene_set(&changed, assignment, &message), SALTUS_BAD_INPUT);
    assert_memory_equal(&changed, scene, sizeof changed);
    expect_words(&message, words, assignment);
}

static double get(const saltus_scene *scene, const char *name) {
    return saltus_spec_get(&scene->spec, name);
}

static void builtin_scenes_build(void **state) {
    (void)state;
    assert_true(saltus_scene_builtin_count() >= 21);
    assert_string_equal(saltus_scene_builtin_name(0), "pipe");
    assert_null(saltus_scene_builtin_name(-1));
    assert_null(saltus_scene_builtin_name(saltus_scene_builtin_count()));
    assert_null(saltus_scene_builtin_text(saltus_scene_builtin_count()));
    assert_null(saltus_scene_builtin_text(-1));
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        saltus_scene scene = load(saltus_scene_builtin_name(k));
        saltus_system *system = NULL;
        saltus_message message = {.text = ""};
        double start[SALTUS_SCENE_STATE_MAX];
        assert_string_equal(scene.name, saltus_scene_builtin_name(k));
        assert_true(scene.title[0] != '\0');
        /* A built-in scene's text gives the scene, and its name cannot be taken for a path. */
        saltus_scene same = {.name = ""};
        const char *text = saltus_scene_builtin_text(k);
        assert_int_equal(saltus_scene_parse(text, strlen(text), scene.name, &same, &message), SALTUS_OK);
        assert_string_equal(same.name, scene.name);
        assert_string_equal(same.title, scene.title);
        assert_memory_equal(same.spec.parameters, scene.spec.parameters, sizeof same.spec.parameters);
        assert_true(saltus_model_same(same.spec.model, scene.spec.model) &&
                    same.spec.stop_count == scene.spec.stop_count);
        assert_true(same.initial_count == scene.initial_count);
        assert_null(strpbrk(scene.name, "/."));
        assert_int_equal(saltus_system_new(&scene.spec, &system, &message), SALTUS_OK);
        if (scene.initial_count == 0)
            assert_int_equal(saltus_system_default_state(system, start, &message), SALTUS_OK);
        else
            assert_int_equal(scene.initial_count, saltus_system_dimension(system));
        saltus_system_free(system);
        saltus_scene_clear(&same);
        saltus_scene_clear(&scene);
    }
}

/* The parameters of the figures, from model.md's table and the cases' own equations. */
static void builtin_values(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double n, omega, d, r;
        int stops;
        saltus_sides sides;
    } known[] = {
        {"pipe", 5, 42, 0.035, 0.9, 1, SALTUS_UPPER},
        {"fig2", 5, 20, 0, 0, 0, 0},
        {"fig3", 1, 14, 0.035, 0.8, 1, SALTUS_BOTH},
        {"fig4a", 5, 10, 0.03, 0.9, 1, SALTUS_UPPER},
        {"fig4b", 5, 20, 0.036, 0.9, 1, SALTUS_UPPER},
        {"fig5", 5, 30, 0.03, 0.9, 1, SALTUS_UPPER},
        {"fig6", 5, 20, 0.035, 0.9, 1, SALTUS_UPPER},
        {"fig7a", 5, 38, 0.03, 0.9, 1, SALTUS_UPPER},
        {"fig7b", 5, 43, 0.03, 0.9, 1, SALTUS_UPPER},
        {"fig7c", 5, 10, 0.035, 0.9, 1, SALTUS_UPPER},
        {"fig7d", 5, 42, 0.035, 0.9, 1, SALTUS_UPPER},
        {"fig8", 5, 42, 0.035, 0.8, 1, SALTUS_UPPER},
        {"chatter", 5, 10, 0.025, 0.9, 1, SALTUS_UPPER},
        {"impact-oscillator", 1, 1, 1, 0.8, 1, SALTUS_UPPER},
        {"near-grazing", 1, 0.81, 0, 0.9, 1, SALTUS_UPPER},
        {"budd-dux", 1, 2.8, 0, 0.8, 1, SALTUS_UPPER},
        {"budd-chatter", 1, 4.85, 0.01, 0.8, 1, SALTUS_UPPER},
        {"bouncing-ball", 1, 1, 0, 0.5, 1, SALTUS_LOWER},
        {"vibrating-table", 1, 1, 0, 0.5, 1, SALTUS_LOWER},
        {"impact-pair", 1, 1, 1.5, 0.8, 1, SALTUS_BOTH},
        {"two-mass", 2, 1.6, 0.3, 0.8, 1, SALTUS_UPPER},
    };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        saltus_scene scene = load(known[k].name);
        const saltus_stop *stop = &scene.spec.stops[0];
        assert_true(get(&scene, "N") == known[k].n && get(&scene, "omega") == known[k].omega);
        assert_int_equal(scene.spec.stop_count, known[k].stops);
        if (known[k].stops)
            assert_true(stop->d == known[k].d && stop->r == known[k].r && stop->sides == known[k].sides);
    }
    saltus_scene two = load("two-mass");
    assert_true(two.spec.stops[0].weight[0] == 1 && two.spec.stops[0].weight[1] == -1);
    saltus_scene ball = load("bouncing-ball");
    assert_true(ball.initial_count == 2 && ball.initial[0] == 1 && ball.initial[1] == 0);
    assert_true(get(&ball, "F0") == -9.8 && get(&ball, "k") == 0 && get(&ball, "F") == 0);
}

/* The scene objects of the reference results, as in their JSON files. */
static void json_is_read(void **state) {
    (void)state;
    saltus_scene chatter = parse(
        "{\"model\": \"pipe\", \"N\": 5, \"sigma\": 0.2, \"alpha\": 0.005, \"beta\": 0.64, \"kappa\": 5000, "
        "\"u0\": 4.5, \"omega\": 10.0, "
        "\"stop\": {\"xi\": 0.5, \"d\": 0.025, \"r\": 0.9, \"sides\": \"upper\"}}");
    assert_true(get(&chatter, "omega") == 10 && get(&chatter, "beta") == 0.64);
    assert_true(chatter.spec.stops[0].d == 0.025 && chatter.spec.stops[0].sides == SALTUS_UPPER);
    saltus_scene single = parse("{\n \"model\": \"pipe\",\n \"N\": 1,\n \"sigma\": 0.2,\n \"alpha\": 0.005,\n"
                                " \"beta\": 0.64,\n \"kappa\": 5000,\n \"u0\": 4.5,\n \"omega\": 14.0,\n"
                                " \"stop\": {\n  \"xi\": 0.5,\n  \"d\": 0.035,\n  \"r\": 0.8,\n"
                                "  \"sides\": \"both\"\n }\n}\n");
    assert_true(get(&single, "N") == 1 && single.spec.stops[0].sides == SALTUS_BOTH);
    refused("{\"model\": \"pipe\",\n \"stop\": {\"d\": 0.03,\n \"r\": 1.5}}",
            "my.yaml:3: r = 1.5: must be at least 0");
}

static void values_and_defaults(void **state) {
    (void)state;
    saltus_scene plain = parse("model: pipe\n");
    assert_string_equal(plain.name, "my");
    assert_string_equal(plain.title, "");
    assert_true(plain.spec.stop_count == 0 && plain.initial_count == 0 && get(&plain, "N") == 5);
    saltus_scene scene =
        parse("\xef\xbb\xbf# comment\r\nmodel: oscillator\r\ntitle: two \xc3\xa9toiles\r\nN: 2\r\n"
              "kz: 1e0\r\nstops:\r\n- {d: .5, weight: [1]}\r\n- d: +2.5e-1\r\n  weight: [0, 1]\r\n"
              "  r: 0\r\n  sides: lower\r\ninitial: {v: [1, 2], z: [-3]}\r\n");
    assert_string_equal(scene.title, "two \xc3\xa9toiles");
    assert_int_equal(scene.spec.stop_count, 2);
    assert_true(scene.spec.stops[0].d == 0.5 && scene.spec.stops[0].r == 0.9 &&
                scene.spec.stops[0].weight[1] == 0);
    assert_true(scene.spec.stops[1].d == 0.25 && scene.spec.stops[1].weight[0] == 0);
    assert_true(scene.spec.stops[1].sides == SALTUS_LOWER && scene.spec.stops[1].r == 0);
    static const double expected[] = {0, 0, 1, 2, -3};
    assert_int_equal(scene.initial_count, 5);
    assert_memory_equal(scene.initial, expected, sizeof expected);
    saltus_scene touching = parse("model: oscillator\nstop: {d: 1}\ninitial: {q: [1]}\n");
    assert_true(touching.initial[0] == 1);
}

static void bad_structure(void **state) {
    (void)state;
    refused("", "my.yaml: is empty");
    refused(" \n\n# nothing here\n", "my.yaml: is empty");
    refused("---\n", "must be a mapping");
    refused("[1, 2]\n", "must be a mapping");
    refused("just words\n", "must be a mapping");
    refused("model: pipe\n---\nmodel: pipe\n", "more than one YAML document");
    refused("model: pipe\n\tN: 3\n", "not valid YAML here or below: found a tab");
    refused("model: \"pipe\nN: 3\n", "not valid YAML");
    refused("{model: pipe\n", "not valid YAML");
    refused("model: pipe\n? [a, b]\n: 3\n", "keys must be single words");
    refused("omega: 2\n", "my.yaml: model: missing; the models are pipe, oscillator");
    refused("N: 2\nmodel: pip\n", "my.yaml:2: model = \"pip\": unknown; the models are pipe, oscillator");
    refused("model:\n", "my.yaml:1: model = \"\": unknown");
    refused("model: [pipe]\n", "my.yaml:1: model: must be a single value");
    refused("model: pipe\ntitle: \"a\\nb\"\n", "my.yaml:2: title: must be one line");
    refused("model: pipe\nomega: 1\nN: 3\nomega: 2\n", "my.yaml:4: omega: given twice");
    refused("model: pipe\nstop:\n d: 1\n d: 2\n", "my.yaml:4: d: given twice");
    refused("title: &a x\nmodel: *a\n", "my.yaml:2: aliases");
    refused("title: &a [x]\nmodel: pipe\n", "my.yaml:1: title: must be a single value");
}

static void unknown_keys(void **state) {
    (void)state;
    refused("model: pipe\n# omgea: 1\nomgea: 3\n", "my.yaml:3: \"omgea\": unknown key; did you mean omega?");
    refused("model: pipe\nfoo: 3\n",
            "my.yaml:2: \"foo\": unknown key; the keys here are model, title, N, alpha, beta, "
            "kappa, u0, sigma, omega, stop, stops, initial");
    refused("foo: 3\n", "my.yaml:1: \"foo\": unknown key; a scene names its model");
    refused("model: oscillator\nkappa: 3\n",
            "my.yaml:2: \"kappa\": not a key of the model oscillator; its keys are");
    refused("model: pipe\nd: 0.03\n", "my.yaml:2: \"d\": belongs to a stop");
    refused("model: pipe\nstop:\n  d: 1\n  omega: 3\n", "my.yaml:4: \"omega\": belongs to the top level");
    refused("model: pipe\nstops:\n- d: 1\n- d: 2\n  side: both\n",
            "my.yaml:5: \"side\": unknown key; did you mean "
            "sides?");
    refused("model: pipe\ninitial:\n  p: [1]\n", "my.yaml:3: \"p\": unknown key; the keys here are q, v, z");
    refused("model: pipe\nstop: {d: 0.03, weight: [1]}\n",
            "my.yaml:2: weight: a stop of the model pipe is placed by xi");
    refused("model: oscillator\nstop:\n  d: 1\n  xi: 1\n",
            "my.yaml:4: xi: a stop of the model oscillator is placed by");
}

static void bad_numbers(void **state) {
    (void)state;
    refused("model: pipe\nomega: nan\n", "my.yaml:2: omega = \"nan\": must be a finite number");
    refused("model: pipe\nomega: .inf\n", "my.yaml:2: omega = \".inf\": must be a finite number");
    refused("model: pipe\nomega:\n", "my.yaml:2: omega = \"\": must be a number");
    refused("model: pipe\nomega: \"\"\n", "my.yaml:2: omega = \"\": must be a number");
    refused("model: pipe\nomega: 42 Hz\n", "my.yaml:2: omega = \"42 Hz\": must be a number");
    refused("model: pipe\nomega: 0x10\n", "must be a number");
    refused("model: pipe\nomega: 1e\n", "must be a number");
    refused("model: pipe\nomega: 1e999\n", "too large");
    refused("model: pipe\nomega: -1\n", "my.yaml:2: omega = -1: must be greater than 0");
    refused("model: pipe\nN: 2.5\n", "my.yaml:2: N = 2.5: must be a whole number");
    refused("model: pipe\nN: 65\n", "my.yaml:2: N = 65: must be at least 1 and at most 64");
    refused("model: pipe\nN: [1]\n", "my.yaml:2: N: must be a single value");
    refused("model: pipe\nN: {a: 1}\n", "my.yaml:2: N: must be a single value");
}

static void bad_stops(void **state) {
    (void)state;
    refused("model: pipe\n\nstop:\n  # r: 1\n  d: 0.3 # r: 1\n\n  r: 1.2\n",
            "my.yaml:7: r = 1.2: must be at least 0 and at most 1 (coefficient of restitution)");
    refused("model: pipe\nstops:\n  - {d: 0.03, r: 0.5, xi: 0.3}\n  - d: 0.02\n    r: 1.2\n",
            "my.yaml:5: stop 2: r = 1.2");
    refused("model: pipe\nstop: {d: 1}\nstops: [{d: 2}]\n", "my.yaml:3: stops: stop is given too");
    refused("model: pipe\nstop: 3\n", "my.yaml:2: stop: must be a mapping");
    refused("model: pipe\nstop:\n", "my.yaml:2: stop: must be a mapping");
    refused("model: pipe\nstops: {d: 1}\n", "my.yaml:2: stops: must be a list");
    refused("model: pipe\nstops: [1]\n", "my.yaml:2: stops: must be a list");
    refused("model: pipe\nstop:\n  r: 0.5\n", "my.yaml:3: stop: d is missing");
    refused("model: pipe\nstops:\n- d: 1\n- r: 1\n", "my.yaml:4: stop 2: d is missing");
    refused("model: pipe\nstops: [{d: 1}, {d: 2}, {d: 3}, {d: 4}, {d: 5}, {d: 6}, {d: 7}, {d: 8}, {d: 9}, "
            "{d: 10}, {d: 11}, {d: 12}, {d: 13}]\n",
            "my.yaml:2: stops: too many; at most 12");
    refused("model: pipe\nstop:\n  d: 0.03\n  sides: left\n",
            "my.yaml:4: sides = \"left\": must be upper, lower or");
    refused("model: pipe\nstop: {d: -1, sides: both}\n",
            "my.yaml:2: d = -1: must be greater than 0 with sides: both");
    refused("model: pipe\nstops: [{d: 0.03}, {d: 0.03}]\n",
            "my.yaml:2: stops 1 and 2 limit the same coordinate");
    refused("model: oscillator\nstop: {d: 1, weight: [1, 2, 3]}\n",
            "my.yaml:2: weight: must be a list of 1 or 2");
    refused("model: oscillator\nstop: {d: 1, weight: []}\n", "my.yaml:2: weight: must be a list of 1 or 2");
    refused("model: oscillator\nstop: {d: 1, weight: 1}\n", "my.yaml:2: weight: must be a list of 1 or 2");
    refused("model: oscillator\nstop: {d: 1, weight: [x]}\n", "my.yaml:2: weight = \"x\": must be a number");
    refused("model: oscillator\nstop: {d: 1, weight: [0, 1]}\n", "my.yaml:2: stop 1: weight names mass 2");
}

static void bad_initial_states(void **state) {
    (void)state;
    refused("model: pipe\ninitial:\n  v: [1]\n  q: [1, 2, 3, 4, 5, 6]\nN: 5\n",
            "my.yaml:4: q: too many entries (6)");
    refused("model: pipe\ninitial: {z: [1]}\n", "my.yaml:2: z: too many entries (1)");
    refused("model: pipe\ninitial: {q: [a]}\n", "my.yaml:2: q = \"a\": must be a number");
    refused("model: pipe\ninitial: {q: [nan]}\n", "my.yaml:2: q = \"nan\": must be a finite number");
    refused("model: pipe\ninitial: {q: 1}\n", "my.yaml:2: q: must be a list of numbers");
    refused("model: pipe\ninitial: [1]\n", "my.yaml:2: initial: must be a mapping of lists");
    refused("model: pipe\nstop: {d: 0.01}\ninitial: {q: [1]}\n",
            "my.yaml:3: initial state: the displacement 1 at");
}

static void not_text(void **state) {
    (void)state;
    saltus_scene scene;
    saltus_message message = {.text = ""};
    refused("model: pipe\n# \xc3\x28\n", "my.yaml:2: not a text file in UTF-8 (byte 0xc3)");
    refused("model: pipe\n\n# \x1b[31m\n", "my.yaml:3: not a text file (it holds the byte 0x1b)");
    refused("\xff\xfem", "not a text file in UTF-8");
    refused("# \xed\xa0\x80\n", "not a text file in UTF-8");
    refused("# \xc0\x80\n", "not a text file in UTF-8");
    refused("# \xf4\x90\x80\x80\n", "not a text file in UTF-8");
    refused("# \xe2\x82", "not a text file in UTF-8");
    assert_int_equal(saltus_scene_parse("model: pipe\n\0\n", 14, "b", &scene, &message), SALTUS_BAD_INPUT);
    expect_words(&message, "b:2: not a text file (it holds the byte 0x00)", "NUL");
    assert_int_equal(saltus_scene_parse(NULL, 0, NULL, &scene, NULL), SALTUS_BAD_INPUT);
}

/* Malicious texts, slow or deeply nested, are refused at once in the usual way. */
static void hostile_texts(void **state) {
    (void)state;
    enum { size = 1 << 20 };
    static const char *const units[] = {"[",  "{", "- ", "a: {", "? ",   "&a ",
                                        "\"", "!", "# ", "- [",  "a:\n", "'"};
    char *text = malloc(size + 2);
    assert_non_null(text);
    for (size_t u = 0; u < sizeof units / sizeof units[0]; u++) {
        saltus_scene scene;
        saltus_message message = {.text = ""};
        size_t length = strlen(units[u]);
        for (size_t k = 0; k < size; k++)
            text[k] = units[u][k % length];
        assert_int_equal(saltus_scene_parse(text, size, "deep", &scene, &message), SALTUS_BAD_INPUT);
        assert_int_equal(saltus_scene_parse(text, size + 1, "deep", &scene, &message), SALTUS_BAD_INPUT);
        expect_words(&message, "deep: too large", units[u]);
    }
    free(text);
}

static void write_file(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void load_refused(const char *source, saltus_status status, const char *words) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    assert_int_equal(saltus_scene_load(source, &scene, &message), status);
    expect_words(&message, words, source);
}

static void files(void **state) {
    (void)state;
    char folder[] = "/tmp/saltus-scene-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/fig2.own.yaml", folder);
    write_file(path, "model: pipe\nomega: 3\n");
    saltus_scene scene = load(path);
    assert_string_equal(scene.name, "fig2.own");
    assert_true(get(&scene, "omega") == 3);
    write_file(path, "model: pipe\nomega: -3\n");
    load_refused(path, SALTUS_BAD_INPUT, ".yaml:2: omega = -3: must be greater than 0");
    assert_int_equal(chmod(path, 0), 0);
    if (access(path, R_OK) != 0) /* root reads everything */
        load_refused(path, SALTUS_IO, "cannot be opened");
    assert_int_equal(unlink(path), 0);
    load_refused(path, SALTUS_IO, "no such file");
    load_refused(folder, SALTUS_IO, "is a directory");
    assert_int_equal(rmdir(folder), 0);
    load_refused("/dev/zero", SALTUS_BAD_INPUT, "too large");
    load_refused("/dev/null", SALTUS_BAD_INPUT, "is empty");
}

static void unknown_names(void **state) {
    (void)state;
    load_refused("chater", SALTUS_BAD_INPUT,
                 "\"chater\": neither a file nor a built-in scene; built-in scenes: chatter");
    load_refused("fig7", SALTUS_BAD_INPUT, "fig7a, fig7b, fig7c, fig7d");
    load_refused("grazing", SALTUS_BAD_INPUT, "built-in scenes: near-grazing");
    load_refused("no-such-thing-at-all", SALTUS_BAD_INPUT, "built-in scenes: pipe, fig2, fig3");
    load_refused("", SALTUS_BAD_INPUT, "no scene given");
    load_refused("./pipe", SALTUS_IO, "no such file");
}

static void settings(void **state) {
    (void)state;
    saltus_scene scene = load("pipe");
    set(&scene, "omega=50");
    set(&scene, "N=3");
    set(&scene, "d=0.02");
    set(&scene, "r=1");
    set(&scene, "xi=0.25");
    set(&scene, "sides=both");
    assert_true(get(&scene, "omega") == 50 && get(&scene, "N") == 3);
    const saltus_stop *stop = &scene.spec.stops[0];
    assert_true(stop->d == 0.02 && stop->r == 1 && stop->xi == 0.25 && stop->sides == SALTUS_BOTH);
    set(&scene, "q2=0.001");
    set(&scene, "v3=-1e-3");
    assert_true(scene.initial_count == 6 && isnan(scene.initial[0]) && scene.initial[1] == 0.001);
    assert_true(scene.initial[5] == -1e-3);
    set_refused(&scene, "N=4", "N = 4: the scene's initial state has 6 entries, but the system would have 8");
    set(&scene, "N=3");
    set(&scene, "sides=none");
    assert_int_equal(scene.spec.stop_count, 0);
    set_refused(&scene, "r=0.5", "r: the scene has no stop; d=... makes one");
    set_refused(&scene, "d2=0.5", "d2: the scene has no stop");
    set(&scene, "d=0.03");
    assert_int_equal(scene.spec.stop_count, 1);
    assert_true(stop->d == 0.03 && stop->r == 0.9 && stop->xi == 0.5 && stop->sides == SALTUS_UPPER);
}

static void settings_of_several_stops(void **state) {
    (void)state;
    saltus_scene scene =
        parse("model: oscillator\nN: 2\nkz: 1\nstops:\n- {d: 1}\n- {d: 2, weight: [1, -1]}\n");
    set(&scene, "r=0.5");
    set(&scene, "d2=3");
    set(&scene, "weight1=0,1");
    set(&scene, "sides2=lower");
    set(&scene, "m2=7");
    set(&scene, "c2=0.5");
    set(&scene, "z1=4");
    const saltus_stop *stops = scene.spec.stops;
    assert_true(stops[0].r == 0.5 && stops[1].r == 0.5 && stops[0].d == 1 && stops[1].d == 3);
    assert_true(stops[0].weight[0] == 0 && stops[0].weight[1] == 1 && stops[1].weight[1] == -1);
    assert_true(stops[0].sides == SALTUS_UPPER && stops[1].sides == SALTUS_LOWER);
    assert_true(get(&scene, "m2") == 7 && get(&scene, "c2") == 0.5);
    assert_true(scene.initial_count == 5 && scene.initial[4] == 4);
    set_refused(&scene, "kz=0", "kz = 0: the scene's initial state has 5 entries");
    set_refused(&scene, "d3=1", "d3: the scene has 2 stops");
    set_refused(&scene, "q3=1", "q3: ");
    set_refused(&scene, "z2=1", "z2: ");
    set_refused(&scene, "weight=1,2,3", "weight = \"1,2,3\": must be 1 or 2 numbers");
    set_refused(&scene, "weight=", "must be 1 or 2 numbers");
    set_refused(&scene, "weight=0", "a stop must limit at least one mass");
    set_refused(&scene, "xi=0.5", "xi: a stop of the model oscillator is placed by weight");
}

/* Every key that a stop can have, in every built-in scene, sets its value or is refused without effect. */
static void every_key_of_a_stop(void **state) {
    (void)state;
    static const char *const keys[] = {"xi", "d", "r", "sides", "weight", "coordinate"};
    for (int k = 0; k < saltus_scene_builtin_count(); k++)
        for (int key = 0; key < 6; key++)
            for (int numbered = 0; numbered < 2; numbered++) {
                saltus_scene scene = load(saltus_scene_builtin_name(k)), before;
                char setting[32];
                saltus_message message = {.text = ""};
                if (scene.spec.stop_count == 0) {
                    saltus_scene_clear(&scene);
                    continue;
                }
                saltus_stop *stop = &scene.spec.stops[0];
                const double *const places[] = {&stop->xi, &stop->d, &stop->r, NULL, stop->weight, NULL};
                snprintf(setting, sizeof setting, "%s%s=0.25", keys[key], numbered ? "1" : "");
                memcpy(&before, &scene, sizeof scene);
                if (saltus_scene_set(&scene, setting, &message) == SALTUS_OK)
                    assert_true(places[key] && *places[key] == 0.25);
                else {
                    assert_memory_equal(&before, &scene, sizeof scene);
                    assert_memory_equal(message.text, keys[key], strlen(keys[key]));
                }
                saltus_scene_clear(&scene);
            }
}

/* Numbers by key: set values are read back bit for bit, for one stop or all; errors change nothing. */
static void values_by_key(void **state) {
    (void)state;
    static const char *const keys[] = {"omega", "beta", "d", "r", "xi", "d2", "xi1", "r1"};
    saltus_spec spec = parse("model: pipe\nomega: 20\nstops:\n- {xi: 0.5, d: 0.03}\n"
                             "- {xi: 0.25, d: 0.04}\n")
                           .spec;
    saltus_message message = {.text = ""};
    assert_true(saltus_spec_get(&spec, "omega") == 20 && saltus_spec_get(&spec, "d2") == 0.04);
    assert_true(isnan(saltus_spec_get(&spec, "d")) && isnan(saltus_spec_get(&spec, "d3")) &&
                isnan(saltus_spec_get(&spec, "nothing")) && saltus_spec_get(&spec, "xi1") == 0.5);
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        const double value = 1 / (3.0 + (double)k);
        if (saltus_spec_set(&spec, keys[k], value, &message) != SALTUS_OK)
            fail_msg("%s", message.text);
        assert_true(saltus_spec_get(&spec, keys[k]) == value);
    }
    /* The stops' own values remain since d, r and xi were set for both. */
    assert_true(spec.stops[0].d == 1 / 5.0 && spec.stops[1].d == 1 / 8.0);
    assert_true(spec.stops[1].xi == 1 / 7.0 && spec.stops[0].xi == 1 / 9.0);
    assert_true(spec.stops[1].r == 1 / 6.0 && spec.stops[0].r == 1 / 10.0);
    static const struct {
        const char *key;
        double value;
    } bad[] = {{"r", 1.5}, {"beta", -1}, {"omega", NAN}, {"d3", 1}, {"q1", 0.5}, {"nothing", 1}, {"N", 2.5}};
    const saltus_spec before = spec;
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        message.text[0] = 0;
        assert_int_equal(saltus_spec_set(&spec, bad[k].key, bad[k].value, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, bad[k].key));
        assert_true(saltus_spec_equal(&spec, &before));
    }
}

static void bad_settings(void **state) {
    (void)state;
    saltus_scene scene = load("pipe");
    set_refused(&scene, "r=1.2", "r = 1.2: must be at least 0 and at most 1 (coefficient of restitution)");
    set_refused(&scene, "omega=-1", "omega = -1: must be greater than 0");
    set_refused(&scene, "N=2.5", "N = 2.5: must be a whole number");
    set_refused(&scene, "xi=0", "xi = 0: must be greater than 0 and less than 1");
    set_refused(&scene, "sides=left", "sides = \"left\": must be upper, lower or both");
    set_refused(&scene, "omega", "\"omega\": must have the form key=value");
    set_refused(&scene, "=3", "must have the form key=value");
    set_refused(&scene, "", "must have the form key=value");
    set_refused(&scene, "omega=", "omega = \"\": must be a number");
    set_refused(&scene, "omega=nan", "omega = \"nan\": must be a finite number");
    set_refused(&scene, "omega=1e999", "too large");
    set_refused(&scene, "omega=1x", "omega = \"1x\": must be a number");
    set_refused(&scene, "omega= 1", "must be a number");
    set_refused(&scene, "omgea=1", "\"omgea\": unknown key; did you mean omega?");
    set_refused(&scene, "k=1", "\"k\": unknown key; the keys here are N, alpha");
    set_refused(&scene, "model=pipe", "\"model\": unknown key");
    set_refused(&scene, "q0=1", "\"q0\": unknown key");
    set_refused(&scene, "q6=1", "q6: ");
    set_refused(&scene, "d2=1", "d2: the scene has 1 stop");
    set_refused(&scene, "q99999999999999999999=1", "unknown key");
    char longest[400];
    memset(longest, '1', sizeof longest);
    memcpy(longest, "omega=", 6);
    longest[sizeof longest - 1] = '\0';
    set_refused(&scene, longest, "too long");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(builtin_scenes_build),
        cmocka_unit_test(builtin_values),
        cmocka_unit_test(json_is_read),
        cmocka_unit_test(values_and_defaults),
        cmocka_unit_test(bad_structure),
        cmocka_unit_test(unknown_keys),
        cmocka_unit_test(bad_numbers),
        cmocka_unit_test(bad_stops),
        cmocka_unit_test(bad_initial_states),
        cmocka_unit_test(not_text),
        cmocka_unit_test(hostile_texts),
        cmocka_unit_test(files),
        cmocka_unit_test(unknown_names),
        cmocka_unit_test(settings),
        cmocka_unit_test(settings_of_several_stops),
        cmocka_unit_test(every_key_of_a_stop),
        cmocka_unit_test(bad_settings),
        cmocka_unit_test(values_by_key),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
