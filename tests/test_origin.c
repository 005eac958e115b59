/* Result files record how they were made.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

#include "saltus/saltus.h"

#include <hdf5.h>
#include <sys/stat.h>

/* A text of a file, freed by the caller; "" if missing. */
static char *text_of(fixture *f, const char *name, const char *what) {
    hid_t file = H5Fopen(path_in(f, name), H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    if (H5Lexists(file, what, H5P_DEFAULT) <= 0) {
        H5Fclose(file);
        return strdup("");
    }
    hid_t set = H5Dopen2(file, what, H5P_DEFAULT), type = H5Dget_type(set);
    char *text = calloc(1, H5Tget_size(type) + 1);
    assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) >= 0);
    H5Tclose(type);
    H5Dclose(set);
    H5Fclose(file);
    return text;
}

static void tells(fixture *f, const char *name, const char *what, const char *expected) {
    char *text = text_of(f, name, what);
    assert_string_equal(text, expected);
    free(text);
}

static const char scene[] = "title: one impact a period   # as written\n"
                            "model: oscillator\n"
                            "c: 0.1\nF: 1\nomega: 1\n"
                            "stop: {d: 1.2, r: 0.7}\n";

static void put_scene(fixture *f, const char *name) {
    FILE *file = fopen(path_in(f, name), "w");
    fputs(scene, file);
    fclose(file);
}

/* The command without the parts on which results do not depend, as shell words; the scene as in its file; the
 * requested date. */
static void files_tell_command_scene_and_date(void **state) {
    fixture *f = *state;
    put_scene(f, "it's mine.yaml");
    static const struct {
        const char *line, *file, *command;
    } known[] = {
        {"simulate \"it's mine.yaml\" --set F=1.1 omega=1.02 --periods 5 --quiet -o run.h5", "run.h5",
         "saltus simulate 'it'\\''s mine.yaml' --set F=1.1 omega=1.02 --periods 5"},
        {"sweep \"it's mine.yaml\" -o sweep.h5 --threads 2 --over omega=0.9:1:3 --lanes 1 --json", "sweep.h5",
         "saltus sweep 'it'\\''s mine.yaml' --over omega=0.9:1:3"},
        {"basins \"it's mine.yaml\" -o plane.h5 --over q1=0:1:2 --over v1=0:1:2 --force", "plane.h5",
         "saltus basins 'it'\\''s mine.yaml' --over q1=0:1:2 --over v1=0:1:2"},
        {"continue \"it's mine.yaml\" --in omega=0.98:1.02 -o branch.h5 --step 0.02", "branch.h5",
         "saltus continue 'it'\\''s mine.yaml' --in omega=0.98:1.02 --step 0.02"},
    };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        if (run(f, known[k].line) != 0)
            fail_msg("%s: %s", known[k].line, said(f, "err"));
        tells(f, known[k].file, "command", known[k].command);
        tells(f, known[k].file, "scene_text", scene);
        tells(f, known[k].file, "date", "2000-02-29T00:00:00Z");
    }
}

/* For a built-in scene its text; for one from standard input none. */
static void where_the_scene_comes_from(void **state) {
    fixture *f = *state;
    assert_int_equal(run(f, "simulate impact-oscillator --periods 3 -o run.h5"), 0);
    for (int k = 0; k < saltus_scene_builtin_count(); k++)
        if (strcmp(saltus_scene_builtin_name(k), "impact-oscillator") == 0)
            tells(f, "run.h5", "scene_text", saltus_scene_builtin_text(k));
    put_scene(f, "mine.yaml");
    assert_int_equal(run(f, "simulate - --periods 3 -o piped.h5 <mine.yaml"), 0);
    tells(f, "piped.h5", "command", "saltus simulate - --periods 3");
    tells(f, "piped.h5", "scene_text", "");
    /* A named pipe can be read only once. */
    assert_int_equal(mkfifo(path_in(f, "pipe.yaml"), 0600), 0);
    char writer[200];
    snprintf(writer, sizeof writer, "cd %s && cat mine.yaml >pipe.yaml &", f->folder);
    assert_int_equal(system(writer), 0);
    assert_int_equal(run(f, "simulate pipe.yaml --periods 3 -o named.h5"), 0);
    tells(f, "named.h5", "scene_text", "");
}

/* A resumed run keeps the origin of the first. */
static void a_resumed_run_keeps_its_origin(void **state) {
    fixture *f = *state;
    static const char *const files[] = {"sweep.h5", "branch.h5"};
    static const char *const lines[] = {
        "sweep impact-oscillator --over omega=0.9:1:5 --resume -o sweep.h5",
        "continue impact-oscillator --in omega=0.98:1.02 --resume -o branch.h5"};
    assert_int_equal(run(f, "sweep impact-oscillator --over omega=0.9:1:5 -o sweep.h5"), 0);
    assert_int_equal(run(f, "continue impact-oscillator --in omega=0.98:1.02 -o branch.h5"), 0);
    setenv("SOURCE_DATE_EPOCH", "0", 1);
    for (int k = 0; k < 2; k++) {
        if (run(f, lines[k]) != 0)
            fail_msg("%s: %s", lines[k], said(f, "err"));
        tells(f, files[k], "date", "2000-02-29T00:00:00Z");
    }
    assert_int_equal(run(f, "sweep impact-oscillator --over omega=0.9:1:5 --force -o sweep.h5"), 0);
    tells(f, "sweep.h5", "date", "1970-01-01T00:00:00Z");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(files_tell_command_scene_and_date, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(where_the_scene_comes_from, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(a_resumed_run_keeps_its_origin, open_fixture, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
