/* Tables of branches and trajectories as CSV are the numbers of their files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

#include "saltus/saltus.h"

#include <math.h>
#include <sys/stat.h>

enum { fields_max = 128 };

static int prepare(void **state) {
    open_fixture(state);
    free(told(*state, "continue impact-oscillator --in omega=0.99:1.01 -o branch.h5"));
    free(told(*state, "simulate impact-oscillator --periods 3 --samples 16 -o run.h5"));
    free(told(*state, "simulate impact-oscillator --periods 3 --samples 16 -o run.csv"));
    free(told(*state, "export branch.h5 -o points.csv"));
    free(told(*state, "export branch.h5 --table events -o events.csv"));
    free(told(*state, "export run.h5 -o samples.csv"));
    free(told(*state, "export run.h5 --table events -o contacts.csv"));
    free(told(*state, "export run.h5 --table strobe -o strobe.csv"));
    FILE *scene = fopen(path_in(*state, "seen.yaml"), "w");
    assert_non_null(scene);
    fputs("model:\n  parameters: {c: 0.2, omega: 1.2}\n  motion: {x: -c*x' - x + cos(omega*t)}\n"
          "  forcing: omega\n  observe: {energy: \"x'^2/2\", double_x: 2*x}\n"
          "stop: {coordinate: x, d: 1.3, r: 0.8}\n",
          scene);
    fclose(scene);
    free(told(*state, "simulate seen.yaml --periods 2 --samples 16 -o seen.h5"));
    free(told(*state, "simulate seen.yaml --periods 2 --samples 16 -o seen2.csv"));
    free(told(*state, "export seen.h5 -o seen.csv"));
    return 0;
}

/* A table of comma-separated values; comments are left out. */
typedef struct csv {
    char *text, *field[4096][fields_max];
    int rows, columns; /* the names are row 0 */
} csv;

static csv *read_csv(fixture *f, const char *name) {
    csv *t = calloc(1, sizeof *t);
    size_t length;
    assert_non_null(t);
    t->text = read_all(path_in(f, name), &length);
    char *lines = t->text;
    assert_int_equal(strncmp(lines, "# Saltus ", 9), 0);
    for (char *line; (line = strsep(&lines, "\n")) != NULL;) {
        if (!*line || *line == '#')
            continue;
        int columns = 0;
        for (char *field; (field = strsep(&line, ",")) != NULL;)
            t->field[t->rows][columns++] = field;
        assert_true(t->rows == 0 || columns == t->columns);
        t->columns = columns;
        assert_true(++t->rows < 4096);
    }
    return t;
}

static void free_csv(csv *t) {
    free(t->text);
    free(t);
}

static const char *text_at(const csv *t, int row, const char *name) {
    for (int k = 0; k < t->columns; k++)
        if (strcmp(t->field[0][k], name) == 0)
            return t->field[row + 1][k];
    fail_msg("there is no column %s", name);
    return "";
}

static double number_at(const csv *t, int row, const char *name) {
    return strtod(text_at(t, row, name), NULL);
}

/* Every point of a branch, with its parameters by name, and every event. */
static void a_branch_is_all_there(void **state) {
    saltus_branch_file file;
    saltus_message message = {.text = ""};
    assert_int_equal(saltus_branch_file_read(path_in(*state, "branch.h5"), &file, &message), SALTUS_OK);
    csv *points = read_csv(*state, "points.csv"), *events = read_csv(*state, "events.csv");
    assert_int_equal(points->rows - 1, file.point_count);
    int seen = 0;
    for (int k = 0; k < file.point_count; k++) {
        const saltus_branch_point *p = &file.points[k];
        char quoted[64];
        assert_true(number_at(points, k, "omega") == p->value[0]);
        assert_true(number_at(points, k, "F") == saltus_spec_get(&p->spec, "F"));
        assert_true(number_at(points, k, "row") == k + 1);
        assert_true(number_at(points, k, "q1") == p->state[0] && number_at(points, k, "v1") == p->state[1]);
        assert_true(number_at(points, k, "multiplier2_re") == p->multipliers[1].re &&
                    number_at(points, k, "multiplier2_im") == p->multipliers[1].im &&
                    number_at(points, k, "log_modulus2") == p->multipliers[1].log_modulus);
        assert_true(number_at(points, k, "d1") == p->spec.stops[0].d &&
                    number_at(points, k, "r1") == p->spec.stops[0].r &&
                    number_at(points, k, "weight1_1") == p->spec.stops[0].weight[0]);
        snprintf(quoted, sizeof quoted, "\"%s\"", p->label);
        assert_string_equal(text_at(points, k, "motion"), quoted);
        const char *kind = saltus_point_word(p->kind);
        assert_string_equal(text_at(points, k, "kind"), kind[0] ? kind : "regular");
        for (int e = 0; e < p->event_count; e++, seen++)
            assert_true(number_at(events, seen, "velocity_before") == p->events[e].velocity_before &&
                        number_at(events, seen, "row") == k + 1);
    }
    for (int k = 0; k < points->columns; k++)
        assert_true(!strstr(points->field[0][k], "xi") && !strstr(points->field[0][k], "stops"));
    assert_true(seen > 0 && events->rows - 1 == seen);
    free_csv(points);
    free_csv(events);
    saltus_branch_file_clear(&file);
}

/* The lines of a table from its columns' names on. */
static const char *rows_of(const char *text) {
    while (*text == '#')
        text = strchr(text, '\n') + 1;
    return text;
}

/* A record written as HDF5 exports the same CSV as one written directly, with all that the scene observes. */
static void a_record_is_all_there(void **state) {
    static const char *const files[][2] = {{"samples.csv", "run.csv"}, {"seen.csv", "seen2.csv"}};
    for (int k = 0; k < 2; k++) {
        char *own = said(*state, files[k][0]), *wanted = said(*state, files[k][1]);
        assert_string_equal(rows_of(own), rows_of(wanted));
        assert_int_equal(strncmp(own, wanted, strstr(own, "# options") - own), 0);
        free(own);
        free(wanted);
    }
    csv *samples = read_csv(*state, "samples.csv"), *wanted = read_csv(*state, "run.csv"),
        *contacts = read_csv(*state, "contacts.csv"), *strobe = read_csv(*state, "strobe.csv"),
        *seen = read_csv(*state, "seen.csv");
    assert_true(samples->rows > 48 && samples->rows == wanted->rows);
    assert_true(number_at(seen, 3, "double_x") == 2 * number_at(seen, 3, "x"));
    free_csv(seen);
    for (int row = 0; row < contacts->rows - 1; row++) {
        int at = (int)number_at(contacts, row, "row");
        assert_string_equal(text_at(contacts, row, "kind"), text_at(wanted, at, "event"));
        assert_true(number_at(contacts, row, "time") == number_at(wanted, at, "time_over_T"));
    }
    assert_true(contacts->rows > 1);
    assert_int_equal(strobe->rows - 1, 3);
    for (int row = 0; row < 3; row++)
        assert_true(number_at(strobe, row, "time_over_T") == row);
    assert_true(number_at(strobe, 0, "q1") == number_at(samples, 0, "q1"));
    free_csv(samples);
    free_csv(wanted);
    free_csv(contacts);
    free_csv(strobe);
}

/* The drawing of a record: gnuplot's script has every sample once, and a point where a period begins. */
static void a_record_is_drawn(void **state) {
    fixture *f = *state;
    FILE *file = fopen(path_in(f, "gnuplot"), "w");
    assert_non_null(file);
    fputs("#!/bin/sh\ncat >script\nprintf '\\211PNG\\r\\n'\nprintf %080d 0\nprintf 'IEND....'\n", file);
    fclose(file);
    chmod(path_in(f, "gnuplot"), 0755);
    char *usual = strdup(getenv("PATH")), path[4200];
    snprintf(path, sizeof path, "%s:%s", f->folder, usual);
    setenv("PATH", path, 1);
    free(told(f, "plot run.h5 -o run.png"));
    assert_int_equal(run(f, "plot run.h5 --view class -o run.png"), 2);
    setenv("PATH", usual, 1);
    free(usual);
    csv *samples = read_csv(f, "samples.csv");
    char *script = said(f, "script"), *at = strstr(script, "$orbit << EOD\n");
    assert_non_null(at);
    at = strchr(at, '\n') + 1;
    int begins = 0;
    for (int row = 0; row < samples->rows - 1; row++, at = strchr(at, '\n') + 1) {
        double time, x, v;
        while (*at == '#' || *at == '\n') /* an empty line where the velocity jumps */
            at = strchr(at, '\n') + 1;
        assert_int_equal(sscanf(at, "%lf %lf %lf", &time, &x, &v), 3);
        assert_true(fabs(time - number_at(samples, row, "time_over_T")) <= 1e-8);
        assert_true(fabs(x - number_at(samples, row, "displacement")) <= 1e-8);
        assert_true(fabs(v - number_at(samples, row, "velocity")) <= 1e-8);
    }
    at += strspn(at, "\n");
    assert_int_equal(strncmp(at, "EOD\n", 4), 0);
    at = strstr(at, "$strobe << EOD\n");
    assert_non_null(at);
    for (at = strchr(strchr(at, '\n') + 1, '\n') + 1; strncmp(at, "EOD\n", 4) != 0;
         at = strchr(at, '\n') + 1, begins++) {
        double time;
        assert_int_equal(sscanf(at, "%*f %*f %lf", &time), 1);
        assert_true(time == begins);
    }
    assert_int_equal(begins, 3);
    free(script);
    free_csv(samples);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_branch_is_all_there),
        cmocka_unit_test(a_record_is_all_there),
        cmocka_unit_test(a_record_is_drawn),
    };
    return cmocka_run_group_tests(tests, prepare, close_fixture);
}
