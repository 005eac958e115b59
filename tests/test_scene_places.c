/* A refusal of a scene names the line and key at fault in any layout: every key of several layouts is damaged
 * in turn. All layouts of a scene give the same scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

/* In the layouts below a key-value pair in block style is between < and >, one in flow style between ^ and >;
 * these are damaged. */
enum { text_size = 4096, key_size = 32 };

static const char *const pipes[] = {
    /* Block style with comments that look like keys. */
    "# omega: 1 {[\n"
    "<model: pipe>\n"
    "\n"
    " # r: 3\n"
    "<title: C#4 at a:b> # xi: {\n"
    "<N: 2>\n"
    "<omega: 37>   # omega: 2\n"
    "#d: 1\n"
    "stops: # two\n"
    "  - <d: 0.03>\n"
    "    # d: 7\n"
    "    <r: 0.5>\n"
    "\n"
    "    <xi: 0.3>\n"
    "  - <xi: 0.6>\n"
    "    <d: 0.04> # r: 1\n"
    "    <r: 0.6>\n"
    "    <sides: both>\n"
    "initial:\n"
    "  <v: [0.1, 0.2]>\n"
    "  <q: [0.001]>\n",
    /* The same with carriage returns, a byte order mark, and dashes in the column of their key. */
    "\xef\xbb\xbf<model: pipe>\r\n"
    "\r\n"
    "<title: \"r: 1 # d: [\">\r\n"
    "<N: 2>\r\n"
    "<omega: 37>\t# r: 1\r\n"
    "stops:\r\n"
    "- {^d: 0.03>, ^r: 0.5>, ^xi: 0.3>}\r\n"
    "- <xi: 0.6>\r\n"
    "  <d: 0.04>\r\n"
    "  <r: 0.6>\r\n"
    "  <sides: both>\r\n"
    "initial: {^v: [0.1,0.2]>,\r\n"
    "  ^q: [0.001]>}\r\n",
    /* JSON. */
    "{\n"
    " ^\"model\": \"pipe\">,\n"
    " ^\"title\": \"a \\\"d\\\": 1, {\\\\\">,\n"
    " ^\"N\": 2>,\n"
    "\n"
    " ^\"omega\": 37>,\n"
    " \"stops\": [\n"
    "  {\n"
    "   ^\"d\": 0.03>,\n"
    "   ^\"r\": 0.5>,\n"
    "   ^\"xi\": 0.3>\n"
    "  },\n"
    "  {\n"
    "   ^\"xi\": 0.6>,\n"
    "   ^\"d\": 0.04>,\n"
    "   ^\"r\": 0.6>,\n"
    "   ^\"sides\": \"both\">\n"
    "  }\n"
    " ],\n"
    " \"initial\": {\n"
    "  ^\"v\": [0.1,\n"
    "   0.2]>,\n"
    "  ^\"q\": [0.001]>\n"
    " }\n"
    "}\n",
    /* JSON without blanks, on one line. */
    "{^\"model\":\"pipe\">,^\"N\":2>,^\"omega\":37>,\"stops\":[{^\"d\":0.03>,^\"r\":0.5>,^\"xi\":0.3>},{^"
    "\"xi\":0.6>,^\"d\":0.04>,^\"r\":0.6>,^\"sides\":\"both\">}],\"initial\":{^\"v\":[0.1,0.2]>,^\"q\":[0."
    "001]>}}",
    /* Everything is indented; a quoted title spans lines; entries are on the lines below their dashes. */
    "---\n"
    "  <model: pipe>\n"
    "  <title: \"two\n"
    "   omega: 1\n"
    "   lines\">\n"
    "  <N : 2>\n"
    "  <\"omega\" : 37>\n"
    "  stops:\n"
    "    -\n"
    "      <d: 0.03>\n"
    "      <r: 0.5>\n"
    "      <xi: 0.3>\n"
    "    -\n"
    "      <xi: 0.6>\n"
    "      <d: 0.04>\n"
    "      <'r': 0.6>\n"
    "      <sides: both>\n"
    "  initial:\n"
    "    <v:\n"
    "    - 0.1\n"
    "    - 0.2>\n"
    "    <q: [ 0.001 ]>\n",
    /* A line of a quoted text may end with a backslash, and quotes may be doubled; keys come in another
       order. */
    "<title: \"one \\\n"
    "  line\">\n"
    "stops: [{^d: 0.03>,\n"
    " ^r: 0.5>,\n"
    " ^xi: 0.3>},\n"
    " {^xi: 0.6>,\n"
    " ^sides: both>, # {\n"
    " ^d: 0.04>, ^r: 0.6>}]\n"
    "initial:\n"
    " <q: [0.001]>\n"
    " <v: [0.1, 0.2]>\n"
    "<N: 2>\n"
    "<model: 'pipe'>\n"
    "<omega: 37>\n",
};

static const char *const oscillators[] = {
    "<model: oscillator>\n"
    "<N: 2>\n"
    "<m: 3>\n"
    "<m2: 4>\n"
    "<kz: 1.5>\n"
    "<tz: 2>\n"
    "stop:\n"
    "  <d: 0.3>\n"
    "  <weight: [1, -1]>\n"
    "  <sides: lower>\n"
    "  <r: 0>\n"
    "initial:\n"
    "  <z: [0.1]>\n"
    "  <v: [0.2, 0.3]>\n",
    "{^model: oscillator>,\n"
    "^N: 2>,\n"
    "^m: 3>,\n"
    "^m2: 4>, # r: 1\n"
    "^title: kz:1>,\n"
    "^kz: 1.5>,\n"
    "^tz: 2>,\n"
    "stop: {\n"
    "^d: 0.3>,\n"
    "^weight: [1,-1]>,\n"
    "^sides: lower>,\n"
    "^r: 0>},\n"
    "initial: {\n"
    "^z: [0.1]>,\n"
    "^v: [0.2, 0.3]>}\n"
    "}\n",
    "stop: {^weight: [1, -1]>, ^sides: lower>,\n"
    "  ^d: 0.3>, ^r: 0>}\n"
    "<kz: 1.5>\n"
    "<m2: 4>\n"
    "<N: 2>\n"
    "initial: {^v: [0.2, 0.3]>, ^z: [0.1]>}\n"
    "<tz: 2>\n"
    "<model: oscillator>\n"
    "<m: 3>\n",
};

static const char *const chains[] = {
    /* Lists of dashes below keys of stops. */
    "<model: oscillator>\n"
    "<title: 'x: \\'>\n"
    "<N: 2>\n"
    "stops:\n"
    "- <sides: lower>\n"
    "  <weight:\n"
    "  - 1\n"
    "  - -1>\n"
    "  <d: 0.3>\n"
    "  <r: 0>\n"
    "- <d: 0.5>\n"
    "  <weight:\n"
    "    - 0\n"
    "    - 1>\n"
    "  <r: 0.5>\n"
    "initial:\n"
    "  <q:\n"
    "  - -0.1\n"
    "  - 0>\n"
    "  <v: [0.2, 0.3]>\n"
    "<k: 2>\n",
    "{^model: oscillator>,\n"
    "^N: 2>,\n"
    "^k: 2>,\n"
    "stops: [{\n"
    "^sides: lower>,\n"
    "^weight: [1,-1]>,\n"
    "^d: 0.3>,\n"
    "^r: 0>\n"
    "},\n"
    "{^d: 0.5>,\n"
    "^weight: [0, 1]>,\n"
    "^r: 0.5>}],\n"
    "initial: {^q: [-0.1, 0]>,\n"
    "^v: [0.2, 0.3]>}}\n",
};

/* A pair between marks: its number, place, key and value. */
typedef struct site {
    bool flow;
    int line, column;
    char key[key_size], written[key_size], value[128]; /* `written`: the key with its quotes */
} site;

/* Write the layout without marks, with pair `which` replaced; false if there are fewer pairs. */
static bool write_layout(const char *layout, int which, const char *instead, char *text, site *found) {
    size_t used = 0, begin = strncmp(layout, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    int number = 0, line = 1;
    bool here = false, any = false;
    for (const char *c = layout; *c; c++) {
        if (*c == '<' || *c == '^') {
            here = number++ == which;
            if (!here)
                continue;
            any = true;
            size_t length = strcspn(c + 1, ">"), colon = strcspn(c + 1, ":"), name = colon;
            while (c[name] == ' ')
                name--;
            bool quoted = c[1] == '"' || c[1] == '\'';
            found->flow = *c == '^';
            found->line = line;
            found->column = (int)(used - begin);
            snprintf(found->written, sizeof found->written, "%.*s", (int)name, c + 1);
            snprintf(found->key, sizeof found->key, "%.*s", (int)name - 2 * quoted, c + 1 + quoted);
            snprintf(found->value, sizeof found->value, "%.*s", (int)(length - colon - 1), c + 2 + colon);
            if (instead) {
                used += (size_t)snprintf(text + used, text_size - used, "%s", instead);
                c += length;
            }
            continue;
        }
        if (*c == '>')
            continue;
        text[used++] = *c;
        if (*c == '\n') {
            line++;
            begin = used;
        }
    }
    text[used] = '\0';
    return any;
}

static saltus_scene parse(const char *text) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    if (saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message) != SALTUS_OK)
        fail_msg("%s\n%s", message.text, text);
    return scene;
}

/* The text is refused with this line, followed by these words. */
static void check_refusal(const char *text, int line, const char *words) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    char wanted[256];
    snprintf(wanted, sizeof wanted, "my.yaml:%d: %s", line, words);
    assert_int_equal(saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message), SALTUS_BAD_INPUT);
    if (strncmp(message.text, wanted, strlen(wanted)) != 0)
        fail_msg("'%s' instead of '%s' for\n%s", message.text, wanted, text);
}

static bool is_list(const site *s) {
    return strchr("qvzw", s->key[0]) != NULL;
}

/* A value that cannot be read, and one outside the key's range. */
static void damage_value(const char *layout, int which, const site *s) {
    static const struct {
        const char *key, *value;
    } beyond[] = {{"N", "99"}, {"omega", "-1"}, {"r", "7"},   {"xi", "1.5"},
                  {"m", "-2"}, {"m2", "-2"},    {"kz", "-3"}, {"tz", "-1"}};
    char text[text_size], pair[256], words[128];
    site again;
    bool list = is_list(s);
    if (strcmp(s->key, "title") == 0)
        return;
    snprintf(pair, sizeof pair, list ? "%s: [x-1]" : "%s: x-1", s->written);
    write_layout(layout, which, pair, text, &again);
    snprintf(words, sizeof words, "%s = \"x-1\": ", s->key);
    check_refusal(text, s->line, words);
    for (size_t k = 0; k < sizeof beyond / sizeof beyond[0]; k++) {
        if (strcmp(s->key, beyond[k].key) != 0)
            continue;
        snprintf(pair, sizeof pair, "%s: %s", s->written, beyond[k].value);
        write_layout(layout, which, pair, text, &again);
        check_refusal(text, s->line, "");
        saltus_scene scene;
        saltus_message message = {.text = ""};
        saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message);
        snprintf(words, sizeof words, "%s = %s: ", s->key, beyond[k].value);
        assert_non_null(strstr(message.text, words));
    }
}

/* A list or mapping instead of a single value, and vice versa. */
static void damage_kind(const char *layout, int which, const site *s) {
    static const char *const wrong[2][3] = {{"[1, 2]", "{a: 1}", "[]"}, {"7", "{a: 1}", "\"\""}};
    char text[text_size], pair[256], words[64];
    site again;
    bool list = is_list(s);
    for (int k = 0; k < 3; k++) {
        snprintf(pair, sizeof pair, "%s: %s", s->written, wrong[list][k]);
        write_layout(layout, which, pair, text, &again);
        snprintf(words, sizeof words, "%s: must be a %s", s->key, list ? "list of" : "single value");
        /* A mapping as the model consists of equations. */
        bool equations = strcmp(s->key, "model") == 0 && wrong[list][k][0] == '{';
        check_refusal(text, s->line, equations ? "\"a\": unknown key; the keys here are parameters" : words);
    }
}

/* Of a duplicate pair the second is named; of an unknown key before it, that key. */
static void add_keys(const char *layout, int which, const site *s) {
    char text[text_size], pair[600], words[96], between[80];
    site again;
    int inner = 0;
    for (const char *c = s->value; *c; c++)
        inner += *c == '\n';
    snprintf(between, sizeof between, s->flow ? ",\n\n%*s" : "\n\n%*s", s->column, "");
    snprintf(pair, sizeof pair, "%s:%s%s%s: %s", s->written, s->value, between, s->written, s->value);
    write_layout(layout, which, pair, text, &again);
    snprintf(words, sizeof words, "%s: given twice, first in line %d; keep one of them", s->key, s->line);
    check_refusal(text, s->line + inner + 2, words);
    snprintf(pair, sizeof pair, "%s:%s%sweird: 1", s->written, s->value, between);
    write_layout(layout, which, pair, text, &again);
    check_refusal(text, s->line + inner + 2, "\"weird\": unknown key; the keys here are ");
    /* Of two unknown keys the first is reported. A duplicate key is reported before its wrong value. */
    snprintf(pair, sizeof pair, "weird: 1%sstrange: 2%s%s:%s", between, between, s->written, s->value);
    write_layout(layout, which, pair, text, &again);
    check_refusal(text, s->line, "\"weird\": unknown key; the keys here are ");
    snprintf(pair, sizeof pair, "weird: 1%sweird: 2%s%s:%s", between, between, s->written, s->value);
    write_layout(layout, which, pair, text, &again);
    snprintf(words, sizeof words, "weird: given twice, first in line %d; ", s->line);
    check_refusal(text, s->line + 2, words);
    snprintf(pair, sizeof pair, "%s: {a: 1}%s%s:%s", s->written, between, s->written, s->value);
    write_layout(layout, which, pair, text, &again);
    snprintf(words, sizeof words, "%s: given twice, first in line %d; ", s->key, s->line);
    check_refusal(text, s->line + 2, words);
}

static void check_same(const saltus_scene *a, const saltus_scene *b) {
    assert_ptr_equal(a->spec.model, b->spec.model);
    assert_memory_equal(a->spec.parameters, b->spec.parameters, sizeof a->spec.parameters);
    assert_int_equal(a->spec.stop_count, b->spec.stop_count);
    for (int s = 0; s < a->spec.stop_count; s++) {
        const saltus_stop *p = &a->spec.stops[s], *q = &b->spec.stops[s];
        assert_true(p->xi == q->xi && p->d == q->d && p->r == q->r && p->sides == q->sides &&
                    p->weight[0] == q->weight[0] && p->weight[1] == q->weight[1]);
    }
    assert_int_equal(a->initial_count, b->initial_count);
    assert_memory_equal(a->initial, b->initial, sizeof a->initial);
}

static void each_key_is_found(const char *const *layouts, size_t count) {
    char text[text_size];
    site s;
    saltus_scene first = {.initial_count = 0};
    for (size_t k = 0; k < count; k++) {
        write_layout(layouts[k], -1, NULL, text, &s);
        saltus_scene scene = parse(text);
        if (k == 0)
            first = scene;
        check_same(&scene, &first);
        for (int which = 0; write_layout(layouts[k], which, NULL, text, &s); which++) {
            damage_value(layouts[k], which, &s);
            damage_kind(layouts[k], which, &s);
            add_keys(layouts[k], which, &s);
        }
    }
}

static void each_key_of_a_pipe_is_found(void **state) {
    (void)state;
    each_key_is_found(pipes, sizeof pipes / sizeof pipes[0]);
}

static void each_key_of_an_oscillator_is_found(void **state) {
    (void)state;
    each_key_is_found(oscillators, sizeof oscillators / sizeof oscillators[0]);
}

static void each_key_of_a_chain_is_found(void **state) {
    (void)state;
    each_key_is_found(chains, sizeof chains / sizeof chains[0]);
}

/* Top-level keys in a stop and keys of a stop at top level: the message says where they belong. */
static void keys_in_the_wrong_place_are_sent_home(void **state) {
    static const char *const stop_keys[] = {"xi", "d", "r", "sides", "weight"}, *const tops[] = {"stop",
                                                                                                 "initial"};
    (void)state;
    char text[256], words[128];
    for (int m = 0; m < 2; m++) {
        const char *model = m ? "oscillator" : "pipe";
        int count;
        const saltus_parameter *p = saltus_model_parameters(saltus_model_find(model), &count);
        for (int k = 0; k < 5; k++) {
            snprintf(text, sizeof text, "model: %s\n\n%s: 1\n", model, stop_keys[k]);
            snprintf(words, sizeof words, "\"%s\": belongs to a stop; write stop: {%s: ...}", stop_keys[k],
                     stop_keys[k]);
            check_refusal(text, 3, words);
        }
        for (int k = 0; k < count; k++) {
            for (int t = 0; t < 2; t++) {
                snprintf(text, sizeof text, "model: %s\n%s:\n\n  %s: 1\n", model, tops[t], p[k].name);
                snprintf(words, sizeof words, "\"%s\": belongs to the top level, not below %s", p[k].name,
                         tops[t]);
                check_refusal(text, 4, words);
            }
            if (saltus_model_parameter_index(saltus_model_find(m ? "pipe" : "oscillator"), p[k].name) >= 0)
                continue;
            snprintf(text, sizeof text, "%s: 1\nmodel: %s\n", p[k].name, m ? "pipe" : "oscillator");
            snprintf(words, sizeof words, "\"%s\": not a key of the model %s; its keys are model, title, N, ",
                     p[k].name, m ? "pipe" : "oscillator");
            check_refusal(text, 1, words);
        }
    }
    /* Without a model its keys cannot be listed, and the next entry is not taken for it. An unknown model is
     * reported before any key. */
    static const char *const models[] = {
        "",         "model: beam\n",     "model: pipes-of-a-very-long-name-indeed-it-is\n",
        "model:\n", "model:\npipe: 1\n", "model: # none\n\"pipe\": 1\n"};
    for (int k = 0; k < 6; k++) {
        snprintf(text, sizeof text, "weird: 1\n%s", models[k]);
        bool named = k == 1 || k == 2;
        check_refusal(text, named ? 2 : 1,
                      named ? "model = \"" : "\"weird\": unknown key; a scene names its model");
    }
}

static void stops_without_clearance_are_placed(void **state) {
    static const char *const keys[] = {"xi: 0.5", "r: 0.5", "sides: both"};
    (void)state;
    char text[256];
    for (int k = 0; k < 3; k++) {
        snprintf(text, sizeof text, "model: pipe\nstop:\n\n  %s\n", keys[k]);
        check_refusal(text, 4, "stop: d is missing");
        snprintf(text, sizeof text, "model: pipe\nstops:\n- {d: 1, %s}\n-\n  %s\n", keys[k], keys[k]);
        check_refusal(text, 5, "stop 2: d is missing");
    }
    check_refusal("model: oscillator\nstop:\n\n  weight: [1]\n", 4, "stop: d is missing");
    check_refusal("model: pipe\n\nstop: {}\n", 3, "stop: d is missing");
    check_refusal("model: pipe\n\nstops:\n- d: 1\n- {}\n", 5, "stop 2: d is missing");
    /* A missing key with an impossible default: the stop is named. */
    check_refusal("model: pipe\nN: 2\n\nstops:\n- d: 0.1\n- d: 0.1\n", 4, "stops 1 and 2 limit the same");
}

static void lists_have_their_lengths(void **state) {
    (void)state;
    char text[1024], words[128];
    for (int k = 0; k < 3; k++) {
        const int room = k < 2 ? 2 : 1,
                  lengths[] = {room + 1, SALTUS_SCENE_STATE_MAX, SALTUS_SCENE_STATE_MAX + 1};
        for (int l = 0; l < 3; l++) {
            snprintf(text, sizeof text, "model: oscillator\nN: 2\nkz: 1\ninitial:\n\n  %c: [0", "qvz"[k]);
            for (int i = 1; i < lengths[l]; i++)
                strcat(text, ", 0");
            strcat(text, "]\n");
            snprintf(words, sizeof words,
                     l < 2 ? "%c: too many entries (%d); the system has %d"
                           : "%c: too many entries; at most %d are possible",
                     "qvz"[k], l < 2 ? lengths[l] : SALTUS_SCENE_STATE_MAX, room);
            check_refusal(text, 6, words);
        }
    }
    for (int stops = 12; stops < 14; stops++) {
        strcpy(text, "model: pipe\nN: 3\nstops:\n");
        for (int s = 0; s < stops; s++)
            snprintf(text + strlen(text), 64, "- {d: 0.1, xi: 0.%02d}\n", 7 * s + 1);
        if (stops > 12)
            check_refusal(text, 3, "stops: too many; at most 12 are possible");
        else
            assert_int_equal(parse(text).spec.stop_count, 12);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_key_of_a_pipe_is_found),
        cmocka_unit_test(each_key_of_an_oscillator_is_found),
        cmocka_unit_test(each_key_of_a_chain_is_found),
        cmocka_unit_test(keys_in_the_wrong_place_are_sent_home),
        cmocka_unit_test(stops_without_clearance_are_placed),
        cmocka_unit_test(lists_have_their_lengths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
