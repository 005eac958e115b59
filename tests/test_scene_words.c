/* Scenes read letter by letter: misspelt words, numbers and characters just inside and outside the limits,
 * settings that change exactly what they name.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"

enum { words_max = 40 };

/* The text must be refused; returns the message after its origin. */
static const char *refusal(const char *text, size_t length, saltus_message *message) {
    saltus_scene scene;
    assert_int_equal(saltus_scene_parse(text, length, "s", &scene, message), SALTUS_BAD_INPUT);
    assert_int_equal(strncmp(message->text, "s:", 2), 0);
    return message->text;
}

static int distance(const char *a, const char *b) {
    int table[40][40], m = (int)strlen(a), n = (int)strlen(b);
    for (int i = 0; i <= m; i++)
        for (int j = 0; j <= n; j++) {
            int changed = i && j ? table[i - 1][j - 1] + (a[i - 1] != b[j - 1]) : 99;
            int dropped = i ? table[i - 1][j] + 1 : 99, added = j ? table[i][j - 1] + 1 : 99;
            int least = changed < dropped ? changed : dropped;
            table[i][j] = i + j == 0 ? 0 : least < added ? least : added;
        }
    return table[m][n];
}

/* The words suggested for an unknown key `word`, in a scene that begins with `before`. */
typedef struct offer {
    char word[words_max][64];
    int count;
} offer;

static offer offered(const char *before, const char *word) {
    saltus_message message;
    char text[256];
    offer o = {.count = 0};
    snprintf(text, sizeof text, "%s%s: 1", before, word);
    refusal(text, strlen(text), &message);
    char *list = strstr(message.text, "the keys here are ");
    list = list ? list + 18 : NULL;
    if (!list) {
        list = strstr(message.text, "did you mean ");
        if (!list)
            fail_msg("%s", message.text);
        list += 13;
        assert_int_equal(list[strlen(list) - 1], '?');
        list[strlen(list) - 1] = '\0';
    }
    for (char *c = strtok(list, ", "); c; c = strtok(NULL, ", "))
        snprintf(o.word[o.count++], sizeof o.word[0], "%s", c);
    return o;
}

/* One letter may be wrong, and one more for every four, up to three; the nearest key is suggested, of equally
 * near ones the first. Words of one or two letters are not matched. */
static void check_word(const char *before, const char *word, const offer *all) {
    const char *nearest = NULL;
    size_t length = strlen(word);
    int least = 99, allowed = length < 3 ? -1 : length >= 8 ? 3 : length >= 4 ? 2 : 1;
    for (int k = 0; k < all->count; k++) {
        int far = distance(word, all->word[k]);
        if (far == 0)
            return;
        if (strlen(all->word[k]) > 2 && far < least) {
            least = far;
            nearest = all->word[k];
        }
    }
    offer o = offered(before, word);
    if (least <= allowed) {
        assert_int_equal(o.count, 1);
        if (strcmp(o.word[0], nearest) != 0)
            fail_msg("%s: %s is offered, %s is nearer", word, o.word[0], nearest);
    } else
        assert_int_equal(o.count, all->count);
}

static void near_misses_are_named(void **state) {
    static const char *const before[] = {"model: pipe\n", "model: oscillator\n",
                                         "model: pipe\nstop: {d: 1}\ninitial:\n  ", "model: pipe\nstop:\n  ",
                                         "model: oscillator\nstops:\n- "};
    static const char *const keys[] = {
        "model title N alpha beta kappa u0 sigma omega stop stops initial observe",
        "model title N m c k F F0 m2 c2 k2 F2 F02 kz tz omega stop stops initial observe", "q v z",
        "xi d r sides", "weight d r sides"};
    (void)state;
    for (size_t b = 0; b < sizeof before / sizeof before[0]; b++) {
        offer all = offered(before[b], "QQQQQQQQQQ");
        char listed[256] = "";
        for (int k = 0; k < all.count; k++)
            snprintf(listed + strlen(listed), sizeof listed - strlen(listed), "%s%s", k ? " " : "",
                     all.word[k]);
        assert_string_equal(listed, keys[b]);
        for (int k = 0; k < all.count; k++) {
            const char *key = all.word[k];
            int n = (int)strlen(key);
            char word[40];
            for (int i = 0; i < n; i++) {
                snprintf(word, sizeof word, "%.*s%s", i, key, key + i + 1);
                if (n > 1)
                    check_word(before[b], word, &all);
                snprintf(word, sizeof word, "%.*sj%s", i, key, key + i);
                check_word(before[b], word, &all);
                snprintf(word, sizeof word, "%sjjj%.*s", key, i, "jjjjjjjj");
                check_word(before[b], word, &all);
                for (int l = i; l < n; l++)
                    for (int h = l; h < n; h += 2) {
                        snprintf(word, sizeof word, "%s", key);
                        word[i] = word[l] = word[h] = 'j';
                        check_word(before[b], word, &all);
                    }
            }
        }
    }
}

static void names_of_scenes_are_offered(void **state) {
    (void)state;
    saltus_scene scene;
    saltus_message message;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        char word[64];
        const char *name = saltus_scene_builtin_name(k);
        if (strlen(name) < 4)
            continue;
        snprintf(word, sizeof word, "%s", name);
        word[0] = 'j';
        assert_int_equal(saltus_scene_load(word, &scene, &message), SALTUS_BAD_INPUT);
        const char *list = strstr(message.text, "built-in scenes: ");
        assert_true(list && strstr(list, k == 0 || strncmp(name, "fig", 3) != 0 ? name : "fig"));
        /* A part of a name, or a name with more around it. */
        snprintf(word, sizeof word, "my-%s-2", name);
        assert_int_equal(saltus_scene_load(word, &scene, &message), SALTUS_BAD_INPUT);
        assert_true(strstr(message.text, "built-in scenes: ") &&
                    strstr(strstr(message.text, "built-in scenes: "), name));
        int commas = 0;
        for (const char *c = strstr(message.text, "built-in scenes: "); *c; c++)
            commas += *c == ',';
        assert_true(commas < saltus_scene_builtin_count() / 2);
        snprintf(word, sizeof word, "%.*s", (int)strlen(name) - 1, name);
        if (saltus_scene_load(word, &scene, &message) == SALTUS_OK) {
            saltus_scene_clear(&scene);
            continue;
        }
        assert_true(strstr(strstr(message.text, "built-in scenes: "), name) != NULL);
    }
    /* Without a near one all are listed; two letters are too few for a part of a name. */
    static const char *const far[] = {"xyzxyzxyz", "pi", "fi"};
    for (int w = 0; w < 3; w++) {
        assert_int_equal(saltus_scene_load(far[w], &scene, &message), SALTUS_BAD_INPUT);
        int commas = 0;
        for (const char *c = strstr(message.text, "built-in scenes: "); *c; c++)
            commas += *c == ',';
        assert_int_equal(commas, saltus_scene_builtin_count() - 1);
    }
}

/* A name that is no file: with characters of a path it is reported as a missing file, otherwise names are
 * suggested. */
static void names_that_cannot_be_files(void **state) {
    (void)state;
    saltus_scene scene;
    saltus_message message;
    char name[5000];
    memset(name, 'x', sizeof name);
    name[4999] = '\0';
    assert_int_equal(saltus_scene_load(name, &scene, &message), SALTUS_BAD_INPUT);
    assert_int_equal(
        strncmp(message.text, "\"xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx...\": neither a file", 57), 0);
    name[4000] = '/';
    assert_int_equal(saltus_scene_load(name, &scene, &message), SALTUS_IO);
    assert_non_null(strstr(message.text, "x: no such file"));
    assert_int_equal(saltus_scene_load("/dev/null/x", &scene, &message), SALTUS_IO);
    assert_string_equal(message.text, "/dev/null/x: cannot be opened (Not a directory)");
    assert_int_equal(saltus_scene_load("x.yaml", &scene, &message), SALTUS_IO);
    assert_string_equal(message.text, "x.yaml: no such file");
    assert_int_equal(saltus_scene_load("/", &scene, &message), SALTUS_IO);
    assert_string_equal(message.text, "/: is a directory, not a scene file");
    static const char *const none[] = {NULL, ""};
    for (int k = 0; k < 2; k++) {
        assert_int_equal(saltus_scene_load(none[k], &scene, &message), SALTUS_BAD_INPUT);
        assert_int_equal(strncmp(message.text, "no scene given", 14), 0);
    }
    /* A file's name without folder and ending. */
    static const char *const origins[][2] = {
        {"a/b.c/d.e.yaml", "d.e"}, {"a.b/c", "c"}, {".hidden", ".hidden"},
        {"a/.x.yaml", ".x"},       {"a.", "a"},    {"", ""}};
    for (int k = 0; k < 6; k++) {
        check_ok(saltus_scene_parse("model: pipe", 11, origins[k][0], &scene, &message), &message);
        assert_string_equal(scene.name, origins[k][1]);
    }
    check_ok(saltus_scene_parse("model: pipe", 11, NULL, &scene, &message), &message);
    assert_string_equal(scene.name, "scene");
    for (int length = 126; length < 130; length++) {
        name[length] = '\0';
        check_ok(saltus_scene_parse("model: pipe", 11, name, &scene, &message), &message);
        assert_int_equal(strlen(scene.name), length < 127 ? length : 127);
        name[length] = 'x';
    }
    assert_int_equal(saltus_scene_parse(NULL, 50, NULL, &scene, &message), SALTUS_BAD_INPUT);
    assert_int_equal(strncmp(message.text, "scene: is empty", 15), 0);
}

static void origins_and_values_are_cut(void **state) {
    (void)state;
    saltus_scene scene;
    saltus_message message;
    char origin[200], wanted[300], text[200];
    for (int length = 158; length < 164; length++) {
        for (int k = 0; k < length; k++)
            origin[k] = (char)('a' + k % 26);
        origin[length] = '\0';
        assert_int_equal(saltus_scene_parse("\n\nx: 1\n", 7, origin, &scene, &message), SALTUS_BAD_INPUT);
        snprintf(wanted, sizeof wanted, "%s%s:3: ", length > 160 ? "..." : "",
                 origin + (length > 160 ? length - 160 : 0));
        assert_int_equal(strncmp(message.text, wanted, strlen(wanted)), 0);
    }
    static const char *const ends[] = {
        "", "b", "bc", "\xc3\xa9", "\xc3\xa9x", "\xe2\x82\xac", "\xe2\x82\xacx"};
    for (int first = 36; first < 44; first++)
        for (size_t e = 0; e < sizeof ends / sizeof ends[0]; e++) {
            char value[64];
            memset(value, 'a', sizeof value);
            strcpy(value + first, ends[e]);
            size_t length = strlen(value), kept = length;
            if (length > 40)
                kept = first >= 40                        ? 40
                       : (unsigned char)ends[e][0] < 0x80 ? 40
                       : first + strlen(ends[e]) <= 40 || (first + (ends[e][0] == '\xc3' ? 2 : 3)) <= 40
                           ? 40
                           : (size_t)first;
            snprintf(text, sizeof text, "model: pipe\nomega: %s\n", value);
            snprintf(wanted, sizeof wanted, "s:2: omega = \"%.*s%s\": must be", (int)kept, value,
                     kept < length ? "..." : "");
            refusal(text, strlen(text), &message);
            if (strncmp(message.text, wanted, strlen(wanted)) != 0)
                fail_msg("%s instead of %s", message.text, wanted);
        }
    /* Keys up to the length of the reader's own notes, with their line. */
    for (int length = 40; length < 48; length++) {
        char key[64];
        memset(key, 'k', sizeof key);
        key[length] = '\0';
        snprintf(text, sizeof text, "model: pipe\n%s: 1\n", key);
        snprintf(wanted, sizeof wanted, "s:2: \"%.40s%s\": unknown key", key, length > 40 ? "..." : "");
        refusal(text, strlen(text), &message);
        assert_int_equal(strncmp(message.text, wanted, strlen(wanted)), 0);
    }
    char long_key[256] = "";
    memset(long_key, 'k', 200);
    snprintf(wanted, sizeof wanted, "model: pipe\n%s: 1\n", long_key);
    refusal(wanted, strlen(wanted), &message);
    assert_non_null(strstr(message.text, "\"kkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkk...\": unknown key"));
    scene = (saltus_scene){.spec = saltus_spec_defaults(saltus_model_find("pipe"))};
    assert_int_equal(saltus_scene_set(&scene, "omega=a\x1f\x7f\t ~", &message), SALTUS_BAD_INPUT);
    assert_int_equal(strncmp(message.text, "omega = \"a    ~\": ", 18), 0);
}

/* Whether these bytes are one character, found by decoding and encoding again. */
static bool is_character(const unsigned char *b, size_t length) {
    unsigned long code = b[0];
    if (length > 1) {
        code &= 0x7fu >> length;
        for (size_t k = 1; k < length; k++) {
            if ((b[k] & 0xc0) != 0x80)
                return false;
            code = code << 6 | (b[k] & 0x3f);
        }
    }
    size_t needed = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    unsigned lead[] = {0, 0, 0xc0, 0xe0, 0xf0};
    bool led =
        length == 1 ? b[0] < 0x80 : (unsigned)(b[0] & (0xff00u >> (length + 1)) & 0xff) == lead[length];
    return led && needed == length && code <= 0x10ffff && !(code >= 0xd800 && code <= 0xdfff);
}

static void characters_are_those_of_utf8(void **state) {
    static const unsigned char next[] = {0x20, 0x7f, 0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc0, 0xff};
    enum { nexts = sizeof next };
    (void)state;
    saltus_scene scene;
    saltus_message message;
    for (int lead = 0x80; lead < 0x100; lead++)
        for (int k = 0; k < nexts * 9; k++) {
            /* A comment after a line, ended by the character itself or by a letter. */
            unsigned char text[32] = "model: pipe\n\n#";
            size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2, at = 14;
            const unsigned char tail[3] = {next[k % nexts], k / nexts % 3 == 1 ? 0xc0 : 0x80 + k / nexts,
                                           k / nexts / 3 == 1 ? 0x7e : 0xbf};
            text[at] = (unsigned char)lead;
            memcpy(text + at + 1, tail, length - 1);
            bool good = is_character(text + at, length);
            saltus_status status = saltus_scene_parse((const char *)text, at + length, "s", &scene, &message);
            bool told = status != SALTUS_OK && strstr(message.text, "s:3: not a text file in UTF-8");
            if (told == good)
                fail_msg("%02x %02x: %s", lead, tail[0], status ? message.text : "taken");
            if (good) {
                status = saltus_scene_parse((const char *)text, at + length - 1, "s", &scene, &message);
                assert_true(status == SALTUS_BAD_INPUT &&
                            strstr(message.text, "s:3: not a text file in UTF-8"));
            }
        }
    for (int c = 0; c < 0x80; c++) {
        char text[] = "model: pipe\n# ?\n";
        text[14] = (char)c;
        saltus_status status = saltus_scene_parse(text, sizeof text - 1, "s", &scene, &message);
        bool control = (c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7f;
        char wanted[80];
        snprintf(wanted, sizeof wanted, "s:2: not a text file (it holds the byte 0x%02x)", (unsigned)c);
        assert_int_equal(status, control ? SALTUS_BAD_INPUT : SALTUS_OK);
        if (control)
            assert_string_equal(message.text, wanted);
    }
}

static void a_mebibyte_is_the_most(void **state) {
    enum { most = 1 << 20 };
    (void)state;
    char path[] = "/tmp/saltus-large-XXXXXX", *text = malloc(most + 1);
    saltus_scene scene;
    saltus_message message;
    memset(text, 'x', most + 1);
    memcpy(text, "model: pipe\nomega: 3\n#", 22);
    for (size_t length = most; length <= most + 1; length++) {
        saltus_status wanted = length > most ? SALTUS_BAD_INPUT : SALTUS_OK;
        int file = mkstemp(path);
        assert_true(file >= 0);
        FILE *stream = fdopen(file, "wb");
        fwrite(text, 1, length, stream);
        fclose(stream);
        assert_int_equal(saltus_scene_parse(text, length, "s", &scene, &message), wanted);
        assert_int_equal(saltus_scene_load(path, &scene, &message), wanted);
        assert_true(wanted ? strstr(message.text, "too large") != NULL : scene.spec.parameters[6] == 3);
        remove(path);
        strcpy(path + strlen(path) - 6, "XXXXXX");
    }
    free(text);
}

/* Damage below valid lines is reported in its own line. */
static void damaged_yaml_has_its_line(void **state) {
    static const struct {
        const char *text, *words;
        int line; /* counted from the damaged one */
    } damaged[] = {{"\tN: 3\n", "not valid YAML here or below: found a tab", 0},
                   {"N: @3\n", "not valid YAML here or below: ", 0},
                   {"? [a, b]\n: 3\n", "keys must be single words", 0},
                   {"? omega\n: [1]\n", "omega: must be a single value", 0},
                   {"u0: *a\n", "aliases", 0}};
    (void)state;
    saltus_message message;
    for (int lines = 1; lines < 4; lines++)
        for (size_t k = 0; k < sizeof damaged / sizeof damaged[0]; k++) {
            static const char *const good[] = {"", "model: pipe\n", "model: pipe\nalpha: &a 1\n",
                                               "model: pipe\nalpha: &a 1\n\n# x\nbeta: 0.5\n"};
            static const int count[] = {0, 1, 2, 5};
            char text[200], wanted[100];
            if (strchr(damaged[k].text, '*') && lines < 2)
                continue;
            snprintf(text, sizeof text, "%s%s", good[lines], damaged[k].text);
            snprintf(wanted, sizeof wanted, "s:%d: %s", count[lines] + 1 + damaged[k].line, damaged[k].words);
            refusal(text, strlen(text), &message);
            if (strncmp(message.text, wanted, strlen(wanted)) != 0)
                fail_msg("%s instead of %s", message.text, wanted);
        }
}

static void numbers_are_decimal(void **state) {
    static const char *const good[] = {"1",    "+1",   "1.",     ".5",  "1e3",
                                       "1E-3", "1e+3", "0.25e1", "007", "1e-400"};
    static const char *const bad[] = {"",   ".",    "+",   "e5",  "1e",  "1e5e", "1-",
                                      "1 ", "0x10", "1_0", "1,0", "1d3", "#"};
    static const char *const infinite[] = {"nan",  "NaN",      "NAN",  "inf", "Inf",
                                           "-inf", "infinity", ".inf", "1f"};
    (void)state;
    saltus_scene scene = {.spec = saltus_spec_defaults(saltus_model_find("oscillator"))};
    saltus_message message;
    int index = saltus_model_parameter_index(scene.spec.model, "F0");
    char text[64];
    for (size_t k = 0; k < sizeof good / sizeof good[0]; k++) {
        snprintf(text, sizeof text, "F0=%s", good[k]);
        check_ok(saltus_scene_set(&scene, text, &message), &message);
        assert_true(scene.spec.parameters[index] == strtod(good[k], NULL));
    }
    scene.spec.parameters[index] = 7;
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        snprintf(text, sizeof text, "F0=%s", bad[k]);
        assert_int_equal(saltus_scene_set(&scene, text, &message), SALTUS_BAD_INPUT);
        snprintf(text, sizeof text, "F0 = \"%s\": must be a number", bad[k]);
        assert_string_equal(message.text, text);
    }
    for (size_t k = 0; k < sizeof infinite / sizeof infinite[0]; k++) {
        snprintf(text, sizeof text, "F0=%s", infinite[k]);
        assert_int_equal(saltus_scene_set(&scene, text, &message), SALTUS_BAD_INPUT);
        snprintf(text, sizeof text, "F0 = \"%s\": must be a finite number", infinite[k]);
        assert_string_equal(message.text, text);
    }
    assert_int_equal(saltus_scene_set(&scene, "F0=-2e308", &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "must be a finite number; this one is too large"));
    assert_true(scene.spec.parameters[index] == 7);
}

/* A scene with two stops and every field set. */
static saltus_scene two_stops(const char *model) {
    saltus_scene scene = {.spec = saltus_spec_defaults(saltus_model_find(model))};
    bool pipe = strcmp(model, "pipe") == 0;
    set_parameter(&scene.spec, "N", 2);
    for (int s = 0; s < 2; s++) {
        add_stop(&scene.spec, 0.3 + 0.1 * s, 0.7 + 0.1 * s, s ? SALTUS_BOTH : SALTUS_UPPER);
        scene.spec.stops[s].xi = 0.3 + 0.2 * s;
        scene.spec.stops[s].weight[0] = pipe ? scene.spec.stops[s].weight[0] : 1 - s;
        scene.spec.stops[s].weight[1] = s;
    }
    for (int k = 0; k < SALTUS_SCENE_STATE_MAX; k++)
        scene.initial[k] = 17;
    return scene;
}

/* Apply the setting, and compare with the expected scene. */
static void check_setting(const saltus_scene *before, const char *setting, const saltus_scene *wanted) {
    saltus_message message;
    saltus_scene after = *before;
    check_ok(saltus_scene_set(&after, setting, &message), &message);
    if (memcmp(&after, wanted, sizeof after) != 0)
        fail_msg("%s changes something else", setting);
}

static void check_refused(const saltus_scene *before, const char *setting, const char *words) {
    saltus_message message;
    saltus_scene after = *before;
    assert_int_equal(saltus_scene_set(&after, setting, &message), SALTUS_BAD_INPUT);
    assert_memory_equal(&after, before, sizeof after);
    if (strncmp(message.text, words, strlen(words)) != 0)
        fail_msg("%s: %s instead of %s", setting, message.text, words);
}

static void settings_change_what_they_name(void **state) {
    static const char *const models[] = {"pipe", "oscillator"};
    (void)state;
    for (int m = 0; m < 2; m++) {
        int count;
        const saltus_parameter *p = saltus_model_parameters(saltus_model_find(models[m]), &count);
        saltus_scene before = two_stops(models[m]), wanted;
        char text[128], words[128];
        for (int k = 0; k < count; k++) {
            const double value[] = {p[k].min, p[k].max, p[k].min + 0.25 * (p[k].max - p[k].min)};
            for (int v = 0; v < 3; v++) {
                bool open = (v == 0 && p[k].open_min) || (v == 1 && p[k].open_max);
                snprintf(text, sizeof text, "%s=%.17g", p[k].name, value[v]);
                snprintf(words, sizeof words, "%s = %.10g: must be ", p[k].name, value[v]);
                wanted = before;
                wanted.spec.parameters[k] = value[v];
                if (open || (p[k].integer && value[v] != floor(value[v])))
                    check_refused(&before, text, words);
                else
                    check_setting(&before, text, &wanted);
            }
            snprintf(text, sizeof text, "%s=%.17g", p[k].name, nextafter(p[k].max, INFINITY));
            snprintf(words, sizeof words, "%s = ", p[k].name);
            check_refused(&before, text, words);
            snprintf(text, sizeof text, "%s=%.17g", p[k].name, nextafter(p[k].min, -INFINITY));
            check_refused(&before, text, words);
        }
    }
}

static void settings_change_their_stop(void **state) {
    static const char *const key[] = {"d", "r", "xi", "sides", "weight"}, *const value[] = {"0.21", "0.25",
                                                                                            "0.125", "lower",
                                                                                            "0.5,-2"};
    (void)state;
    for (int m = 0; m < 2; m++) {
        saltus_scene before = two_stops(m ? "oscillator" : "pipe");
        for (int k = 0; k < 5; k++) {
            char text[64], name[16];
            for (int number = 0; number < 4; number++) {
                saltus_scene wanted = before;
                if (number)
                    snprintf(name, sizeof name, "%s%d", key[k], number);
                else
                    snprintf(name, sizeof name, "%s", key[k]);
                snprintf(text, sizeof text, "%s=%s", name, value[k]);
                for (int s = 0; s < 2; s++) {
                    saltus_stop *stop = &wanted.spec.stops[s];
                    if (number && number != s + 1)
                        continue;
                    stop->d = k == 0 ? 0.21 : stop->d;
                    stop->r = k == 1 ? 0.25 : stop->r;
                    stop->xi = k == 2 ? 0.125 : stop->xi;
                    stop->sides = k == 3 ? SALTUS_LOWER : stop->sides;
                    stop->weight[0] = k == 4 ? 0.5 : stop->weight[0];
                    stop->weight[1] = k == 4 ? -2 : stop->weight[1];
                }
                if (k == (m ? 2 : 4))
                    check_refused(&before, text, name);
                else if (number > 2) {
                    snprintf(name, sizeof name, "%s3: the ", key[k]);
                    check_refused(&before, text, name);
                } else
                    check_setting(&before, text, &wanted);
            }
        }
        static const char *const refused[][2] = {{"d01=1", "\"d01\": unknown key"},
                                                 {"d0=1", "\"d0\": unknown key"},
                                                 {"d999=1", "d999: the scene has 2 stops"},
                                                 {"d1000=1", "\"d1000\": unknown key"},
                                                 {"r=1.5", "r = 1.5: must be"},
                                                 {"r1=-0.5", "r = -0.5: must be"},
                                                 {"sides1=none", "sides1 = \"none\": must be"},
                                                 {"d=x", "d = \"x\": must be a number"},
                                                 {"d2=x", "d2 = \"x\": must be a number"}};
        for (size_t k = 0; k < sizeof refused / sizeof refused[0]; k++)
            check_refused(&before, refused[k][0], refused[k][1]);
    }
    saltus_scene one = two_stops("pipe"), none = one, wanted;
    one.spec.stop_count = 1;
    none.spec.stop_count = 0;
    check_refused(&one, "d2=1", "d2: the scene has 1 stop");
    check_refused(&none, "d2=1", "d2: the scene has no stop");
    check_refused(&none, "r=0.5", "r: the scene has no stop");
    check_refused(&none, "d=x", "d = \"x\"");
    for (int numbered = 0; numbered < 2; numbered++) {
        wanted = none;
        wanted.spec.stop_count = 1;
        wanted.spec.stops[0] = saltus_stop_defaults();
        wanted.spec.stops[0].d = 0.5;
        saltus_message message;
        saltus_scene after = none;
        check_ok(saltus_scene_set(&after, numbered ? "d1=0.5" : "d=0.5", &message), &message);
        const saltus_stop *a = &after.spec.stops[0], *b = &wanted.spec.stops[0];
        assert_true(after.spec.stop_count == 1 && a->d == 0.5 && a->r == b->r && a->xi == b->xi &&
                    a->sides == b->sides && a->weight[0] == b->weight[0] && a->weight[1] == b->weight[1]);
        assert_true(after.spec.stops[1].d == none.spec.stops[1].d);
    }
    wanted = one;
    wanted.spec.stop_count = 0;
    check_setting(&one, "sides=none", &wanted);
    saltus_scene chain = two_stops("oscillator");
    static const char *const weights[][2] = {
        {"weight=0,0", "a stop must limit"}, {"weight=0", "a stop must limit"},
        {"weight=1,", "must be 1 or 2"},     {"weight=,1", "must be 1 or 2"},
        {"weight=1,2,3", "must be 1 or 2"},  {"weight=1;2", "must be 1 or 2"}};
    for (size_t k = 0; k < sizeof weights / sizeof weights[0]; k++) {
        char words[100];
        snprintf(words, sizeof words, "weight = \"%s\": %s", weights[k][0] + 7, weights[k][1]);
        check_refused(&chain, weights[k][0], words);
    }
    wanted = chain;
    wanted.spec.stops[0].weight[0] = wanted.spec.stops[1].weight[0] = 0;
    wanted.spec.stops[0].weight[1] = wanted.spec.stops[1].weight[1] = 3;
    check_setting(&chain, "weight=0,3", &wanted);
    wanted.spec.stops[0].weight[0] = wanted.spec.stops[1].weight[0] = -2;
    wanted.spec.stops[0].weight[1] = wanted.spec.stops[1].weight[1] = 0;
    check_setting(&chain, "weight=-2", &wanted);
}

static void settings_change_their_entry(void **state) {
    static const char lists[] = "qvz";
    (void)state;
    for (int m = 0; m < 3; m++) {
        saltus_scene empty = two_stops(m ? "oscillator" : "pipe");
        if (m == 2)
            set_parameter(&empty.spec, "kz", 1);
        const int room[] = {2, 2, m == 2};
        int dimension = 4 + (m == 2);
        saltus_scene full = empty;
        full.initial_count = dimension;
        for (int k = 0; k < dimension; k++)
            full.initial[k] = 0.001 * (k + 1);
        for (int l = 0, at = 0; l < 3; l++) {
            char text[32], words[80];
            for (int i = 0; i < room[l]; i++, at++) {
                saltus_scene wanted = empty;
                snprintf(text, sizeof text, "%c%d=0.125", lists[l], i + 1);
                memset(wanted.initial, 0, sizeof wanted.initial);
                for (int i = 0; i < dimension; i++)
                    wanted.initial[i] = NAN;
                wanted.initial[at] = 0.125;
                wanted.initial_count = dimension;
                check_setting(&empty, text, &wanted);
                wanted = full;
                wanted.initial[at] = 0.125;
                check_setting(&full, text, &wanted);
            }
            snprintf(text, sizeof text, "%c%d=0.125", lists[l], room[l] + 1);
            snprintf(words, sizeof words, "%c%d: the initial state has %d entr%s %c", lists[l], room[l] + 1,
                     room[l], room[l] == 1 ? "y" : "ies", lists[l]);
            check_refused(&full, text, words);
            snprintf(text, sizeof text, "%c=0.125", lists[l]);
            check_refused(&full, text, m ? "\"" : "\"");
            snprintf(text, sizeof text, "%c1=x", lists[l]);
            snprintf(words, sizeof words, "%c1 = \"x\": must be a number", lists[l]);
            check_refused(&full, text, words);
        }
        char words[200];
        snprintf(words, sizeof words,
                 "N = 1: the scene's initial state has %d entries, but the system would have %d;", dimension,
                 dimension - 2);
        check_refused(&full, "N=1", words);
        saltus_scene wanted = full;
        set_parameter(&wanted.spec, "omega", 3);
        check_setting(&full, "omega=3", &wanted);
    }
}

static void settings_have_their_length(void **state) {
    (void)state;
    saltus_scene before = two_stops("oscillator"), wanted = before;
    char text[256], zeros[256];
    memset(zeros, '0', sizeof zeros);
    set_parameter(&wanted.spec, "F0", 5);
    snprintf(text, sizeof text, "F0=%.126s5", zeros);
    check_setting(&before, text, &wanted);
    snprintf(text, sizeof text, "F0=%.127s5", zeros);
    check_refused(&before, text, "\"F0=0000000000000000000000000000000000000...\": too long for a setting");
    memset(zeros, 'k', sizeof zeros);
    snprintf(text, sizeof text, "%.31s=5", zeros);
    check_refused(&before, text, "\"kkkkkkkkkkkkkkkkkkkkkkkkkkkkkkk\": unknown key");
    snprintf(text, sizeof text, "%.32s=5", zeros);
    check_refused(&before, text, "\"kkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkk=5\": too long for a setting");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(near_misses_are_named),          cmocka_unit_test(names_of_scenes_are_offered),
        cmocka_unit_test(names_that_cannot_be_files),     cmocka_unit_test(origins_and_values_are_cut),
        cmocka_unit_test(characters_are_those_of_utf8),   cmocka_unit_test(a_mebibyte_is_the_most),
        cmocka_unit_test(damaged_yaml_has_its_line),      cmocka_unit_test(numbers_are_decimal),
        cmocka_unit_test(settings_change_what_they_name), cmocka_unit_test(settings_change_their_stop),
        cmocka_unit_test(settings_change_their_entry),    cmocka_unit_test(settings_have_their_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
