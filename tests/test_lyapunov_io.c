/* Lyapunov exponents as text, JSON, CSV and figure, also if they are infinite, unknown or inconsistent.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"
#include "reference.h"

#include "figure/caption.h"
#include "figure/sheet.h"
#include "record/describe.h"

#include <sys/stat.h>
#include <unistd.h>

enum { directions = 4, points = 40 };

/* A made-up result with its scene, in its own folder. */
typedef struct fixture {
    char folder[64];
    saltus_scene scene;
    saltus_system *system;
    saltus_lyapunov_options options;
    saltus_lyapunov result;
    double exponents[directions], errors[directions], state[directions], members[2];
    saltus_lyapunov_progress history[points];
    char *text; /* last output */
} fixture;

/* Chaos: one direction grows. The values are exact in binary, so that sums can be compared as text. */
static void fill(fixture *f) {
    static const double exponents[directions] = {0.75, -0.5, -1.25, -4},
                        errors[] = {0.0625, 0.25, 0.5, 0.125};
    saltus_lyapunov *l = &f->result;
    memcpy(f->exponents, exponents, sizeof exponents);
    memcpy(f->errors, errors, sizeof errors);
    for (int k = 0; k < directions; k++)
        f->state[k] = 0.1 * k;
    f->members[0] = 0.6875;
    f->members[1] = 0.8125;
    for (int k = 0; k < points; k++)
        f->history[k] = (saltus_lyapunov_progress){10 * pow(1.3, k), 0.75 + cos(k) / (k + 1), 1.0 / (k + 1)};
    *l = (saltus_lyapunov){.dimension = directions,
                           .count = directions,
                           .exponents = f->exponents,
                           .standard_errors = f->errors,
                           .state = f->state,
                           .sum = -5,
                           .sum_rule = -5.5,
                           .kaplan_yorke = 2.2,
                           .impacts_per_period = 1.5,
                           .sticks_per_period = 0.25,
                           .period = 2,
                           .time = 8000,
                           .periods = 4000,
                           .transient = 1000,
                           .half = {0.5, 1},
                           .half_errors = {0.0625, 0.0625},
                           .independent = 321,
                           .members = 2,
                           .member_exponents = f->members,
                           .agree = true,
                           .precise = true,
                           .history = f->history,
                           .history_count = points};
    f->options = saltus_lyapunov_defaults();
    f->options.precision = 0.1;
    f->options.exponents = 0;
}

static int open_fixture(void **state) {
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    f->scene.spec = pipe_spec(2, 10);
    add_stop(&f->scene.spec, 0.035, 0.9, SALTUS_UPPER);
    strcpy(f->scene.name, "a_b \"quoted\"");
    strcpy(f->scene.title, "it's ^2 {braces} 100%");
    f->system = build(&f->scene.spec);
    *state = f;
    return 0;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    rmdir(f->folder);
    saltus_system_free(f->system);
    free(f->text);
    free(f);
    return 0;
}

static int refill(void **state) {
    fill(*state);
    return 0;
}

static int empty_folder(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    return 0;
}

/* All directions, or the last ones, end in a lasting contact. */
static void lose(fixture *f, int count) {
    for (int k = directions - count; k < directions; k++) {
        f->exponents[k] = -INFINITY;
        f->errors[k] = 0;
    }
    f->result.lost = count;
    f->result.sum = f->result.sum_rule = NAN;
    for (int m = 0; m < 2 && count == directions; m++)
        f->members[m] = f->result.half[m] = -INFINITY;
}

typedef void writer(FILE *file, const saltus_scene *scene, const saltus_system *system,
                    const saltus_lyapunov_options *options, const saltus_lyapunov *lyapunov);

static const char *written(fixture *f, writer *write) {
    size_t length;
    free(f->text);
    FILE *stream = open_memstream(&f->text, &length);
    write(stream, &f->scene, f->system, &f->options, &f->result);
    fclose(stream);
    return f->text;
}

static void check_says(const char *text, const char *words) {
    if (!strstr(text, words))
        fail_msg("'%s' is not said in:\n%s", words, text);
}

static const char *path_in(const fixture *f, const char *name, char path[128]) {
    snprintf(path, 128, "%s/%s", f->folder, name);
    return path;
}

static saltus_status write_file(const fixture *f, const char *path, saltus_message *message) {
    return saltus_write_convergence(path, &f->scene, f->system, &f->options, &f->result, NULL, message);
}

/* Numbers have two digits of their error. */
static void numbers_have_the_digits_their_errors_leave(void **state) {
    static const struct {
        double value, error;
        const char *texts[2];
    } cases[] = {{0.748712, 0.0022, {"0.7487", "0.0022"}},
                 {-0.748712, 0.00996, {"-0.749", "0.010"}},
                 {123.456, 7.77, {"123.5", "7.8"}},
                 {123.456, 40, {"123", "40"}},
                 {-0.0224304763, 8.3e-8, {"-0.022430476", "8.3e-08"}},
                 {0.0001, 0.01, {"0.000", "0.010"}},
                 {3.25e-9, 1e-10, {"3.25e-09", "1.0e-10"}},
                 {-2.5e7, 1.2e6, {"-2.50e+07", "1.2e+06"}},
                 {0, 2e-9, {"0.0e+00", "2.0e-09"}},
                 {0.5, 0, {"0.5", "0"}},
                 {0.5, INFINITY, {"0.5", "unknown"}},
                 {-INFINITY, 0, {"-infinity", "0"}},
                 {1.0 / 3, 1e-30, {"0.333333333333333", "1.0e-30"}}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_uncertain text = saltus_uncertain_text(cases[k].value, cases[k].error);
        assert_string_equal(text.value, cases[k].texts[0]);
        assert_string_equal(text.error, cases[k].texts[1]);
    }
    saltus_line line = {.length = 0};
    saltus_line_uncertain(&line, -3.25e-9, 1e-10);
    assert_string_equal(line.text, "−3.25·10^{−9} ± 1.0·10^{−10}");
}

static void the_sign_is_told_beyond_three_errors(void **state) {
    fixture *f = *state;
    assert_string_equal(saltus_sense_word(saltus_lyapunov_sense(&f->result)), "positive");
    f->errors[0] = 0.3;
    assert_string_equal(saltus_sense_word(saltus_lyapunov_sense(&f->result)), "zero");
    f->result.precise = false;
    assert_string_equal(saltus_sense_word(saltus_lyapunov_sense(&f->result)), "unresolved");
    f->exponents[0] = -1;
    assert_string_equal(saltus_sense_word(saltus_lyapunov_sense(&f->result)), "negative");
    f->errors[0] = INFINITY;
    assert_string_equal(saltus_sense_word(saltus_lyapunov_sense(&f->result)), "unresolved");
    lose(f, directions);
    assert_string_equal(saltus_sense_word(saltus_lyapunov_sense(&f->result)), "lost");
}

static void json_tells_all(void **state) {
    fixture *f = *state;
    const char *json = written(f, saltus_write_lyapunov_json);
    assert_string_equal(strchr(json, '\n'), "\n");
    check_says(json, "{\"version\": \"" SALTUS_VERSION "\", \"scene\": \"a_b \\\"quoted\\\"\", ");
    check_says(json, "\"largest\": 0.75, \"standard_error\": 0.0625, \"sign\": \"positive\"");
    check_says(json,
               "\"exponents\": [0.75, -0.5, -1.25, -4], \"standard_errors\": [0.0625, 0.25, 0.5, 0.125]");
    check_says(json, "\"dimension\": 4, \"lost\": 0, \"sum\": -5, \"sum_rule\": -5.5, \"kaplan_yorke\": 2.2");
    check_says(json,
               "\"impacts_per_period\": 1.5, \"sticks_per_period\": 0.25, \"period\": 2, \"time\": 8000");
    check_says(json, "\"periods\": 4000, \"transient\": 1000, \"halves\": [0.5, 1]");
    check_says(json, "\"half_errors\": [0.0625, 0.0625], \"independent\": 321, \"members\": 2");
    check_says(json, "\"member_exponents\": [0.6875, 0.8125], \"agree\": true, \"precise\": true, \"slow\": "
                     "false, \"state\": [0, ");
    check_says(json, "\"precision\": 0.1");
    check_says(json, "\"d\": 0.035");
    const char *at = find_key(json, "state");
    for (int k = 0; k < directions; k++)
        assert_true(next_number(&at) == f->state[k]);
}

static void json_has_null_for_what_is_infinite_or_unknown(void **state) {
    fixture *f = *state;
    lose(f, 2);
    f->result.kaplan_yorke = NAN;
    const char *json = written(f, saltus_write_lyapunov_json);
    check_says(json,
               "\"exponents\": [0.75, -0.5, null, null], \"standard_errors\": [0.0625, 0.25, null, null]");
    check_says(json, "\"lost\": 2, \"sum\": null, \"sum_rule\": null, \"kaplan_yorke\": null");
    lose(f, directions);
    f->errors[0] = INFINITY;
    json = written(f, saltus_write_lyapunov_json);
    check_says(json, "\"largest\": null, \"standard_error\": null, \"sign\": \"lost\"");
    check_says(json, "\"halves\": [null, null]");
    assert_null(strstr(json, "nan"));
    assert_null(strstr(json, "inf"));
}

static void text_says_what_it_means(void **state) {
    fixture *f = *state;
    const char *text = written(f, saltus_write_lyapunov_text);
    check_says(text, "a_b \"quoted\": largest Lyapunov exponent 0.750 +- 0.062\n  it's ^2 {braces} 100%\n");
    check_says(text, "0.750 +- 0.062 per unit of time, 1.50 +- 0.12 per period (T = 2)\n");
    check_says(text, "positive: nearby trajectories separate, e-fold in 0.6667 periods\n");
    check_says(text, "exponents add up to -5; trace and restitution give -5.5 (difference 5.0e-01)\n");
    check_says(text, "Kaplan-Yorke 2.2 in the stroboscopic section, 3.2 with time\n");
    check_says(text, "0.500 +- 0.062 in the first half, 1.000 +- 0.062 in the second (5.7 standard errors");
    check_says(text, "2, each alone from 0.6875 to 0.8125: they agree\n");
    check_says(text, "1.5 per period; sticks: 0.25 per period\n");
    check_says(text, "4000 periods (8000 units of time)");
    check_says(text, "transient     1000 periods\n");
    check_says(text, "reached: the standard error is 8.3 % of the exponent\n");
    f->exponents[0] = -0.25;
    text = written(f, saltus_write_lyapunov_text);
    check_says(text, "negative: nearby trajectories approach each other, e-fold in 2 periods\n");
    f->exponents[0] = 0.125;
    text = written(f, saltus_write_lyapunov_text);
    check_says(text, "zero within the error");
    /* The requested precision is reported as reached if it is met. */
    f->exponents[0] = 0.5;
    f->errors[0] = 0.125;
    f->options.precision = 0.25;
    text = written(f, saltus_write_lyapunov_text);
    check_says(text, "reached: the standard error is 25 % of the exponent\n");
    f->result.precise = false;
    text = written(f, saltus_write_lyapunov_text);
    check_says(text, "NOT reached: too few values, though the standard error is 25 % of the exponent\n");
    f->result.precise = true;
    f->options.precision = 0.249;
    text = written(f, saltus_write_lyapunov_text);
    check_says(text, "reached: the standard error is 2.5e-01 per period\n");
}

static void text_says_what_is_wrong(void **state) {
    fixture *f = *state;
    f->result.agree = f->result.precise = false;
    f->result.transient = 1251;
    f->result.count = 3;
    f->result.kaplan_yorke = NAN;
    f->options.precision = 0.01;
    const char *text = written(f, saltus_write_lyapunov_text);
    check_says(text, "they DO NOT AGREE\n");
    check_says(text, "coexisting attractors");
    check_says(text, "NOT reached: the standard error is 8.3 % of the exponent, 1 % was asked for\n");
    check_says(text, "1251 periods: 1000 as asked for, then until directions and exponent had settled\n");
    check_says(text, "needs all 4 exponents\n");
    check_says(text, "Kaplan-Yorke: needs more exponents");
    f->errors[0] = INFINITY;
    text = written(f, saltus_write_lyapunov_text);
    check_says(text, "largest Lyapunov exponent 0.75 +- unknown\n");
    check_says(text, "NOT reached: too few values for a standard error\n");
}

static void text_names_lost_directions(void **state) {
    fixture *f = *state;
    lose(f, 2);
    const char *text = written(f, saltus_write_lyapunov_text);
    check_says(text, "4          -infinity  lost in lasting contacts\n");
    check_says(text, "does not apply: 2 of 4 directions are lost in lasting contacts\n");
    lose(f, directions);
    text = written(f, saltus_write_lyapunov_text);
    check_says(text, "largest Lyapunov exponent -infinity\n");
    check_says(text, "every direction is lost in lasting contacts: nearby trajectories become one\n");
    assert_null(strstr(text, "nan"));
    assert_null(strstr(text, "precision"));
}

static void csv_explains_itself(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[128];
    size_t length;
    check_ok(write_file(f, path_in(f, "a.csv", path), &message), &message);
    char *text = read_all(path, &length), *row = strstr(text, "\ntime,exponent,standard_error\n");
    assert_non_null(row);
    check_says(text,
               "# scene: a_b \"quoted\"\n# title: it's ^2 {braces} 100%\n# model: pipe\n# parameters: N = 2");
    check_says(text, "# stop 1: xi = 0.5, d = 0.035");
    check_says(text, "# result: exponent = 0.75, standard_error = 0.0625\n");
    check_says(text, "# measured: 4000 periods, trajectories: 2, transient: 1000 periods, T = 2\n");
    row = strchr(row + 1, '\n') + 1;
    for (int k = 0; k < points; k++) {
        double time = strtod(row, &row), exponent = strtod(row + 1, &row), error = strtod(row + 1, &row);
        assert_true(time == f->history[k].time && exponent == f->history[k].exponent);
        assert_true(error == f->history[k].standard_error);
        assert_int_equal(*row++, '\n');
    }
    assert_int_equal(*row, '\0');
    free(text);
    lose(f, directions);
    check_ok(write_file(f, path, &message), &message);
    text = read_all(path, &length);
    check_says(text, "# result: exponent = -infinity");
    assert_string_equal(strstr(text, "time,exponent"), "time,exponent,standard_error\n");
    free(text);
}

/* Refusals come before the computation and leave nothing behind; existing files stay. */
static void paths_are_checked_beforehand(void **state) {
    fixture *f = *state;
    static const char *const bad[] = {"a.bmp", "a.txt", "a", ".png", "png", "a.h5", "a.PNG", "a.csv.gz"},
                             *const good[] = {"a.png", "a.pdf", "a.svg", "a.csv"};
    saltus_message message = {.text = ""};
    char path[128];
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        path_in(f, bad[k], path);
        assert_int_equal(saltus_convergence_check(path, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, path));
        assert_non_null(strstr(message.text, ".png, .pdf, .svg or .csv"));
        assert_int_equal(write_file(f, path, &message), SALTUS_BAD_INPUT);
    }
    for (size_t k = 0; k < sizeof good / sizeof good[0]; k++)
        check_ok(saltus_convergence_check(path_in(f, good[k], path), &message), &message);
    assert_int_equal(saltus_convergence_check("", &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_convergence_check(path_in(f, "missing/a.png", path), &message), SALTUS_IO);
    assert_non_null(strstr(message.text, "No such file"));
    assert_int_equal(folder_files(f->folder, false), 0);
    FILE *file = fopen(path_in(f, "a.csv", path), "w");
    fputs("kept", file);
    fclose(file);
    check_ok(saltus_convergence_check(path, &message), &message);
    size_t length;
    char *text = read_all(path, &length);
    assert_string_equal(text, "kept");
    free(text);
    assert_int_equal(folder_files(f->folder, true), 1);
    assert_int_equal(mkdir(path, 0777), 0);
    assert_int_equal(saltus_convergence_check(path, &message), SALTUS_IO);
    assert_non_null(strstr(message.text, "folder"));
    rmdir(path);
}

static void full_disks_are_named(void **state) {
    fixture *f = *state;
    static const char *const names[] = {"full.csv", "full.png"};
    saltus_message message = {.text = ""};
    char path[128];
    for (int k = 0; k < 2; k++) {
        assert_int_equal(symlink("/dev/full", path_in(f, names[k], path)), 0);
        check_ok(saltus_convergence_check(path, &message), &message);
        if (k == 0 || system("gnuplot --version >/dev/null 2>&1") == 0) {
            assert_int_equal(write_file(f, path, &message), SALTUS_IO);
            assert_non_null(strstr(message.text, "No space left"));
        }
        assert_int_equal(folder_files(f->folder, true), 1);
    }
}

/* Results with little to draw, by number; false when there is none left. */
static bool make_awkward(fixture *f, int k) {
    fill(f);
    saltus_lyapunov *l = &f->result;
    switch (k) {
    case 0:
        return true;
    case 1: /* a single estimate */
        l->history_count = 1;
        return true;
    case 2: /* none */
        l->history_count = 0;
        f->errors[0] = INFINITY;
        return true;
    case 3:
        lose(f, directions);
        return true;
    case 4: /* estimates that are all the same, and exact */
        for (int j = 0; j < points; j++)
            f->history[j] = (saltus_lyapunov_progress){j + 1, 0.75, 0};
        f->errors[0] = 0;
        return true;
    case 5: /* all at the same time, zero */
        for (int j = 0; j < points; j++)
            f->history[j] = (saltus_lyapunov_progress){5, 0, 0};
        f->exponents[0] = 0;
        return true;
    case 6: /* differences in the tenth digit, over six decades of time */
        for (int j = 0; j < points; j++)
            f->history[j] = (saltus_lyapunov_progress){pow(1.4, j), 0.75 + 1e-10 * sin(j), 1e-10};
        return true;
    case 7: /* huge, and uncertain */
        for (int j = 0; j < points; j++)
            f->history[j] = (saltus_lyapunov_progress){1e12 * (j + 1), 1e9 * sin(j), 1e9};
        f->exponents[0] = -1e9;
        l->agree = l->precise = false;
        return true;
    }
    return false;
}

/* Pictures begin as files of their kind, whatever there is to draw. */
static void figures_are_drawn(void **state) {
    fixture *f = *state;
    static const char *const names[] = {"c.png", "c.pdf", "c.svg"}, *const heads[] = {"\x89PNG", "%PDF",
                                                                                      "<?xml"};
    saltus_message message = {.text = ""};
    char path[128];
    size_t length;
    if (system("gnuplot --version >/dev/null 2>&1") != 0)
        skip();
    for (int k = 0; make_awkward(f, k); k++) {
        check_ok(write_file(f, path_in(f, names[k % 3], path), &message), &message);
        char *picture = read_all(path, &length);
        assert_true(length > 5000);
        assert_memory_equal(picture, heads[k % 3], 4);
        free(picture);
    }
}

/* A panel leaves no settings for the next one, and gnuplot prints nothing. */
static void panels_stand_side_by_side(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[128], command[512];
    if (system("gnuplot --version >/dev/null 2>&1") != 0)
        skip();
    for (int k = 0; make_awkward(f, k); k++) {
        saltus_page page;
        const saltus_course course = {f->result.history, f->result.history_count, f->result.exponents[0],
                                      f->result.standard_errors[0]};
        check_ok(saltus_page_open(&page, "panel.svg", NULL, &message), &message);
        fclose(page.file);
        page.file = fopen(path_in(f, "panel.gp", path), "w");
        saltus_page_begin(&page);
        fputs("set output 'panel.svg'\n", page.file);
        saltus_course_data(&page, &course);
        fputs("set multiplot\n", page.file);
        for (int side = 0; side < 2; side++)
            saltus_course_panel(&page, f->system, &course,
                                (saltus_frame){128 + 800 * side, 752 + 800 * side, 120, 1080});
        fputs("set xlabel ''\nset ylabel ''\nset xrange [-1:1]\nset yrange [-1:1]\nplot x\nshow arrow\nshow "
              "logscale\nunset multiplot\n",
              page.file);
        fclose(page.file);
        snprintf(command, sizeof command,
                 "cd %s && gnuplot panel.gp 2>said; test -s panel.svg && grep -q 'logscaling on none' said "
                 "&& ! grep -q "
                 "-E 'warning|error|line [0-9]|arrow [0-9]+,' said",
                 f->folder);
        if (system(command) != 0) {
            size_t length;
            char *said = read_all(path_in(f, "said", path), &length);
            fail_msg("case %d: gnuplot says %s", k, said);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(numbers_have_the_digits_their_errors_leave, refill),
        cmocka_unit_test_setup(the_sign_is_told_beyond_three_errors, refill),
        cmocka_unit_test_setup(json_tells_all, refill),
        cmocka_unit_test_setup(json_has_null_for_what_is_infinite_or_unknown, refill),
        cmocka_unit_test_setup(text_says_what_it_means, refill),
        cmocka_unit_test_setup(text_says_what_is_wrong, refill),
        cmocka_unit_test_setup(text_names_lost_directions, refill),
        cmocka_unit_test_setup_teardown(csv_explains_itself, refill, empty_folder),
        cmocka_unit_test_setup_teardown(paths_are_checked_beforehand, refill, empty_folder),
        cmocka_unit_test_setup_teardown(full_disks_are_named, refill, empty_folder),
        cmocka_unit_test_setup_teardown(figures_are_drawn, refill, empty_folder),
        cmocka_unit_test_setup_teardown(panels_stand_side_by_side, refill, empty_folder),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
