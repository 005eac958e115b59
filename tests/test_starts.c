/* Orbits to start from, read from JSON: every form of reference, every field, every refusal.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"

#include <unistd.h>

enum { orbits = 3, dimension = 4 };

typedef struct fixture {
    char folder[32], path[80];
    saltus_scene scene;
    saltus_system *system;
    saltus_motion motion[orbits];
    double state[orbits][dimension];
} fixture;

static int open_fixture(void **state) {
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    snprintf(f->path, sizeof f->path, "%s/o.json", f->folder);
    strcpy(f->scene.name, "made");
    f->scene.spec = oscillator_spec(0.125, 2.5, 1.5, 1.75);
    set_parameter(&f->scene.spec, "N", 2);
    set_parameter(&f->scene.spec, "m2", 3.25);
    for (int s = 0; s < 2; s++) {
        add_stop(&f->scene.spec, 1 + s, 0.75 - 0.25 * s, s ? SALTUS_LOWER : SALTUS_BOTH);
        f->scene.spec.stops[s].weight[1] = -0.5 * s - 0.5;
    }
    f->system = build(&f->scene.spec);
    for (int k = 0; k < orbits; k++) {
        for (int i = 0; i < dimension; i++)
            f->state[k][i] = 0.01 * (k + 1) + 0.125 * i;
        f->motion[k] = (saltus_motion){.periods = k + 2,
                                       .impacts = 5 + k,
                                       .dimension = dimension,
                                       .state = f->state[k],
                                       .section_states = NULL};
        snprintf(f->motion[k].label, sizeof f->motion[k].label, "%d/%d", 5 + k, k + 2);
    }
    *state = f;
    return 0;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    rmdir(f->folder);
    saltus_system_free(f->system);
    free(f);
    return 0;
}

static void save(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* The JSON of motions, one per line; freed by the caller. */
static char *json_of(const fixture *f, int first, int count) {
    char *text = NULL;
    size_t length;
    FILE *stream = open_memstream(&text, &length);
    for (int k = first; k < first + count; k++)
        saltus_write_motion_json(stream, &f->scene, f->system, &f->motion[k]);
    fclose(stream);
    char *copy = strdup(text);
    free(text);
    return copy;
}

static void check_start(const fixture *f, const char *source, int orbit) {
    saltus_message message;
    saltus_start start;
    check_ok(saltus_start_read(source, NULL, &start, &message), &message);
    assert_int_equal(start.periods, orbit + 2);
    assert_int_equal(start.dimension, dimension);
    assert_memory_equal(start.state, f->state[orbit], sizeof f->state[orbit]);
    assert_string_equal(start.label, f->motion[orbit].label);
    assert_ptr_equal(start.spec.model, f->scene.spec.model);
    assert_memory_equal(start.spec.parameters, f->scene.spec.parameters, sizeof start.spec.parameters);
    assert_int_equal(start.spec.stop_count, 2);
    for (int s = 0; s < 2; s++) {
        const saltus_stop *a = &start.spec.stops[s], *b = &f->scene.spec.stops[s];
        assert_true(a->d == b->d && a->r == b->r && a->weight[0] == b->weight[0] &&
                    a->weight[1] == b->weight[1] && a->sides == b->sides);
    }
}

/* The message begins with the source, followed by this. */
static void check_refused(const char *source, const char *words) {
    saltus_message message = {.text = ""};
    saltus_start start;
    char wanted[300];
    snprintf(wanted, sizeof wanted, "%s: %s", source, words);
    assert_int_equal(saltus_start_read(source, NULL, &start, &message), SALTUS_BAD_INPUT);
    if (strncmp(message.text, wanted, strlen(wanted)) != 0)
        fail_msg("'%s' instead of '%s'", message.text, wanted);
}

static void orbits_are_named_by_their_place(void **state) {
    const fixture *f = *state;
    char source[128], other[96], *text = json_of(f, 1, 1), *all = json_of(f, 0, orbits);
    save(f->path, text);
    check_start(f, f->path, 1);
    snprintf(source, sizeof source, "%s:1", f->path);
    check_start(f, source, 1);
    snprintf(source, sizeof source, "%s:2", f->path);
    check_refused(source, "there is no such line");
    /* Without the end of its line, and over several lines. */
    text[strlen(text) - 1] = '\0';
    save(f->path, text);
    check_start(f, f->path, 1);
    snprintf(source, sizeof source, "%s:1", f->path);
    check_start(f, source, 1);
    strstr(text, ", \"label\"")[1] = '\n';
    save(f->path, text);
    check_start(f, f->path, 1);
    check_start(f, source, 1);
    snprintf(source, sizeof source, "%s:2", f->path);
    check_refused(source, "is no orbit");
    /* Lines, and a blank one among them. */
    save(f->path, all);
    for (int k = 0; k < orbits; k++) {
        snprintf(source, sizeof source, "%s:%d", f->path, k + 1);
        check_start(f, source, k);
        snprintf(source, sizeof source, "%s:00%d", f->path, k + 1);
        check_start(f, source, k);
    }
    static const char *const none[] = {"4", "5", "123456789"}, *const names[] = {"0",  "PD1",        "1x",
                                                                                 "-1", "1234567890", "1.0"};
    for (int k = 0; k < 3; k++) {
        snprintf(source, sizeof source, "%s:%s", f->path, none[k]);
        check_refused(source, "there is no such line");
    }
    for (int k = 0; k < 6; k++) {
        snprintf(source, sizeof source, "%s:%s", f->path, names[k]);
        check_refused(source, "in a JSON file orbits are named by their number");
    }
    check_refused(f->path, "holds several orbits");
    /* A colon in a file's name; one in its folder's; one without a number after it. */
    snprintf(other, sizeof other, "%s/o:2", f->folder);
    save(other, text);
    check_start(f, other, 1);
    snprintf(source, sizeof source, "%s:1", other);
    check_start(f, source, 1);
    snprintf(source, sizeof source, "%s:/o.json", f->folder);
    check_refused(source, "cannot be opened (No such file or directory)");
    saltus_message message;
    saltus_start start;
    assert_int_equal(saltus_start_read(":1", NULL, &start, &message), SALTUS_BAD_INPUT);
    assert_string_equal(message.text, ":1: is no file name");
    assert_int_equal(saltus_start_read("", NULL, &start, &message), SALTUS_BAD_INPUT);
    assert_string_equal(message.text, ": is no file name");
    char longest[4200];
    for (int length = 4095; length < 4097; length++) {
        memset(longest, 'x', sizeof longest);
        longest[length] = '\0';
        assert_int_equal(saltus_start_read(longest, NULL, &start, &message), SALTUS_BAD_INPUT);
        assert_int_equal(strstr(message.text, "is no file name") != NULL, length > 4095);
    }
    free(all);
    free(text);
}

static void attractors_are_named_by_their_place(void **state) {
    fixture *f = *state;
    char source[128], *text = NULL;
    size_t length;
    int shares[orbits] = {3, 2, 1};
    saltus_attractors a = {f->motion, shares, orbits, 6, 6};
    FILE *stream = open_memstream(&text, &length);
    saltus_write_attractors(stream, &f->scene, f->system, &a, true);
    fclose(stream);
    save(f->path, text);
    for (int k = 0; k < orbits; k++) {
        snprintf(source, sizeof source, "%s:%d", f->path, k + 1);
        check_start(f, source, k);
    }
    snprintf(source, sizeof source, "%s:%d", f->path, orbits + 1);
    check_refused(source, "there is no such attractor");
    check_refused(f->path, "holds a list of attractors");
    free(text);
}

/* Replace the first `from` after `behind`; freed by the caller. */
static char *replaced(const char *text, const char *behind, const char *from, const char *to) {
    const char *at = strstr(text, behind);
    assert_non_null(at);
    at = strstr(at, from);
    assert_non_null(at);
    char *made = malloc(strlen(text) + strlen(to) + 1);
    sprintf(made, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    return made;
}

static void every_member_is_wanted(void **state) {
    const fixture *f = *state;
    char *text = json_of(f, 0, 1), *made, from[64], to[64], words[96];
    int count;
    const saltus_parameter *p = saltus_model_parameters(f->scene.spec.model, &count);
    for (int k = 0; k <= count; k++) {
        const char *key = k < count ? p[k].name : "stops";
        snprintf(from, sizeof from, "\"%s\": ", key);
        snprintf(to, sizeof to, "\"no_%s\": ", key);
        snprintf(words, sizeof words, "parameters: %s is missing", key);
        save(f->path, made = replaced(text, "\"parameters\"", from, to));
        check_refused(f->path, words);
        free(made);
        if (k == count)
            continue;
        snprintf(to, sizeof to, "\"%s\": -1e300, \"x\": ", key);
        snprintf(words, sizeof words, "parameters:1: %s = -1e300", key);
        save(f->path, made = replaced(text, "\"parameters\"", from, to));
        saltus_message message;
        saltus_start start;
        assert_int_equal(saltus_start_read(f->path, NULL, &start, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, key));
        assert_int_equal(strncmp(message.text, f->path, strlen(f->path)), 0);
        free(made);
    }
    static const struct {
        const char *behind, *from, *to, *words;
    } damage[] = {
        {"\"version\"", "\"version\"", "\"revision\"",
         "is not an orbit of classify, orbit or continue --json"},
        {"\"version\"", "\"version\": \"", "\"version\": 3, \"x\": \"", "is not an orbit of classify"},
        {"\"periods\"", "\"periods\": 2", "\"periods\": 1000001", "periods: must be a whole number from 1"},
        {"\"periods\"", "\"periods\": 2", "\"periods\": -1", "periods: must be a whole number from 1"},
        {"\"periods\"", "\"periods\": 2", "\"periods\": 1.5", "periods: must be a whole number from 1"},
        {"\"periods\"", "\"periods\": 2", "\"periods\": null", "periods: must be a whole number from 1"},
        {"\"periods\"", "\"periods\"", "\"perlods\"", "periods: must be a whole number from 1"},
        {"\"periods\"", "\"periods\": 2", "\"periods\": 0",
         "holds no periodic orbit (the motion is 5/2, periods is 0)"},
        {"\"state\"", "\"state\": [", "\"state\": [0.5, ", "state: has 5 entries, its parameters make it 4"},
        {"\"state\"", "\"state\": [", "\"state\": [], \"x\": [",
         "state: has 0 entries, its parameters make it 4"},
        {"\"state\"", "\"state\": [", "\"state\": null, \"x\": [", "state: must be a list of numbers"},
        {"\"state\"", "\"state\"", "\"stat\"", "state: must be a list of numbers"},
        {"\"parameters\"", "\"model\": \"oscillator\"", "\"model\": \"beam\"",
         "parameters: must be an object that names a known model"},
        {"\"parameters\"", "\"model\": \"oscillator\"", "\"model\": 3",
         "parameters: must be an object that names a known model"},
        {"\"parameters\"", "\"model\"", "\"modell\"",
         "parameters: must be an object that names a known model"},
        {"\"parameters\"", "\"parameters\"", "\"parameter\"",
         "parameters: must be an object that names a known model"},
    };
    for (size_t k = 0; k < sizeof damage / sizeof damage[0]; k++) {
        save(f->path, made = replaced(text, damage[k].behind, damage[k].from, damage[k].to));
        check_refused(f->path, damage[k].words);
        free(made);
    }
    for (int i = 0; i < dimension; i++) {
        snprintf(from, sizeof from, "%.17g", f->state[0][i]);
        snprintf(words, sizeof words, "state: entry %d must be a finite number", i + 1);
        static const char *const bad[] = {"null", "\"1\"", "[1]", "1e999", "true"};
        for (int b = 0; b < 5; b++) {
            save(f->path, made = replaced(text, "\"state\"", from, bad[b]));
            check_refused(f->path, words);
            free(made);
        }
    }
    /* The largest period, and another program's label that is too long or missing. */
    saltus_message message;
    saltus_start start;
    save(f->path, made = replaced(text, "\"periods\"", "\"periods\": 2", "\"periods\": 1000000"));
    check_ok(saltus_start_read(f->path, NULL, &start, &message), &message);
    assert_int_equal(start.periods, 1000000);
    free(made);
    save(f->path,
         made = replaced(text, "\"label\"", "\"5/2\"", "\"1234567890123456789012345678901234567890\""));
    check_ok(saltus_start_read(f->path, NULL, &start, &message), &message);
    assert_string_equal(start.label, "1234567890123456789012345678901");
    free(made);
    save(f->path, made = replaced(text, "\"label\"", "\"label\"", "\"motion\": \"6/3\", \"label\""));
    check_ok(saltus_start_read(f->path, NULL, &start, &message), &message);
    assert_string_equal(start.label, "6/3");
    free(made);
    save(f->path, made = replaced(text, "\"label\"", "\"label\"", "\"name\""));
    check_ok(saltus_start_read(f->path, NULL, &start, &message), &message);
    assert_string_equal(start.label, "");
    free(made);
    /* Unknown members are skipped, with up to 64 nested lists. */
    for (int depth = 1; depth < 200000; depth = depth < 40   ? 2 * depth
                                                : depth < 80 ? depth + 1
                                                             : 30 * depth) {
        char *nest = calloc((size_t)depth * 2 + 32, 1);
        assert_non_null(nest);
        strcpy(nest, "\"more\": ");
        memset(nest + 8, '[', (size_t)depth);
        memset(nest + 8 + depth, ']', (size_t)depth);
        strcat(nest, ", \"label\"");
        save(f->path, made = replaced(text, "\"label\"", "\"label\"", nest));
        saltus_status status = saltus_start_read(f->path, NULL, &start, &message);
        assert_int_equal(status, depth <= 64 ? SALTUS_OK : SALTUS_BAD_INPUT);
        free(nest);
        free(made);
    }
    check_refused("/dev/null", "is not a plain file");
    check_refused(f->folder, "is a folder, not a file with an orbit");
    free(text);
}

/* A scene takes parameters and stops of its own shape; its title stays if nothing changes. */
static void starts_are_applied_to_their_like(void **state) {
    const fixture *f = *state;
    saltus_message message;
    saltus_start start = {.spec = f->scene.spec, .periods = 2, .dimension = dimension};
    for (int change = 0; change < 5; change++) {
        saltus_scene scene = f->scene;
        strcpy(scene.title, "as written");
        scene.initial_count = 4;
        if (change == 1)
            set_parameter(&scene.spec, "k", 7);
        if (change == 2)
            scene.spec.stops[1].r = 0.125;
        if (change == 3)
            scene.spec.stops[0].sides = SALTUS_UPPER;
        if (change == 4)
            set_parameter(&scene.spec, "N", 1);
        check_ok(saltus_start_apply(&start, "o", &scene, &message), &message);
        assert_string_equal(scene.title, change ? "" : "as written");
        assert_int_equal(scene.initial_count, 0);
        assert_memory_equal(&scene.spec, &start.spec, sizeof scene.spec);
    }
    for (int change = 0; change < 3; change++) {
        static const char *const words[] = {"o: is an orbit of the model oscillator, the scene's is pipe",
                                            "o: its orbit has 2 stops, the scene 1",
                                            "o: its orbit has 1 stop, the scene 2"};
        saltus_scene scene = f->scene, before;
        saltus_start other = start;
        if (change == 0)
            scene.spec = pipe_spec(2, 3);
        scene.spec.stop_count -= change == 1;
        other.spec.stop_count -= change == 2;
        before = scene;
        assert_int_equal(saltus_start_apply(&other, "o", &scene, &message), SALTUS_BAD_INPUT);
        assert_string_equal(message.text, words[change]);
        assert_memory_equal(&scene, &before, sizeof scene);
    }
}

/* A scene keeps its title if the orbit has its parameters and stops, whatever is in the padding and unused
 * parts of these structs; any other value removes the title. */
static void titles_stay_with_equal_parameters(void **state) {
    fixture *f = *state;
    const saltus_spec *own = &f->scene.spec;
    saltus_message message;
    for (int change = -1; change < 7; change++) {
        saltus_scene scene = f->scene;
        saltus_start start;
        memset(&start, 0xa5, sizeof start);
        start.dimension = dimension;
        start.spec.model = own->model;
        start.spec.stop_count = own->stop_count;
        memcpy(start.spec.parameters, own->parameters, sizeof own->parameters);
        for (int s = 0; s < own->stop_count; s++) {
            saltus_stop *stop = &start.spec.stops[s];
            stop->xi = own->stops[s].xi;
            memcpy(stop->weight, own->stops[s].weight, sizeof stop->weight);
            stop->d = own->stops[s].d;
            stop->r = own->stops[s].r;
            stop->sides = own->stops[s].sides;
        }
        saltus_stop *last = &start.spec.stops[own->stop_count - 1];
        double *const values[] = {&last->xi, &last->weight[0], &last->weight[1],
                                  &last->d,  &last->r,         &start.spec.parameters[1]};
        if (change >= 0 && change < 6)
            *values[change] *= 1.0625;
        if (change == 6)
            last->sides = SALTUS_UPPER;
        bool equal = change < 0;
        strcpy(scene.title, "as it was written");
        assert_int_equal(saltus_spec_equal(&start.spec, own), equal);
        check_ok(saltus_start_apply(&start, "o", &scene, &message), &message);
        assert_string_equal(scene.title, equal ? "as it was written" : "");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orbits_are_named_by_their_place),
        cmocka_unit_test(attractors_are_named_by_their_place),
        cmocka_unit_test(every_member_is_wanted),
        cmocka_unit_test(starts_are_applied_to_their_like),
        cmocka_unit_test(titles_stay_with_equal_parameters),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
