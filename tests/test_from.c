/* Any orbit of any file: the commands with --from.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"
#include "json.h"

#include <hdf5.h>

enum { orbit_periods = 5, dimension = 10 };

static void put_text(fixture *f, const char *name, const char *text) {
    FILE *file = fopen(path_in(f, name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* An unstable orbit amid the motion of a scene, a branch of such orbits, sweeps and basins. */
static int prepare(void **state) {
    open_fixture(state);
    char *text = told(*state, "orbit fig7a --unstable --periods 5 --search 500 --json");
    assert_non_null(strstr(text, "\"label\": \"3/5\""));
    put_text(*state, "orbits.json", text);
    assert_non_null(strchr(text, '\n'));
    *strchr(text, '\n') = '\0';
    assert_non_null(strstr(text, "\"stable\": false"));
    put_text(*state, "orbit.json", text);
    free(text);
    free(told(*state, "sweep fig6 --over omega=36:46:4 --over d=0.033:0.037:2 --at-most 200 --what "
                      "stroboscopic --quiet -o map.h5"));
    free(told(*state, "sweep fig6 --over omega=36:46:4 --seeds 2 --at-most 200 --quiet -o plain.h5"));
    free(told(*state, "sweep fig6 --over q1=0:0.01:2 --at-most 200 --quiet -o states.h5"));
    free(told(*state,
              "basins fig7b --set d=0.02955 --over q1=-0.03:0.03:3 --over v1=-0.6:0.6:2 --at-most 3000 "
              "-o basins.h5 --quiet"));
    return 0;
}

static json *object_of(fixture *f, const char *line) {
    char *text = told(f, line);
    json *object = json_read(text);
    free(text);
    return object;
}

/* The stroboscopic points of a record; how many there are. */
static int read_strobes(fixture *f, const char *name, double *states, int room) {
    hid_t file = H5Fopen(path_in(f, name), H5F_ACC_RDONLY, H5P_DEFAULT);
    hid_t set = H5Dopen2(file, "strobe/states", H5P_DEFAULT), space = H5Dget_space(set);
    hsize_t size[2];
    H5Sget_simple_extent_dims(space, size, NULL);
    assert_true((int)size[1] == dimension && (int)size[0] <= room);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, states) >= 0);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
    return (int)size[0];
}

/* The record of an unstable orbit repeats for any requested time; the trajectory from the same state does
 * not. */
static void an_unstable_orbit_is_not_left(void **state) {
    enum { periods = 150 };
    static double states[periods * dimension];
    for (int own = 0; own < 2; own++) {
        char line[1024];
        if (own) {
            json *o = object_of(*state, "orbit fig7a --from orbit.json --json");
            int used =
                snprintf(line, sizeof line, "simulate fig7a --periods 150 --samples 4 -o own.h5 --set");
            for (int i = 0; i < dimension; i++) {
                char path[16];
                snprintf(path, sizeof path, "state.%d", i);
                used += snprintf(line + used, sizeof line - (size_t)used, " %c%d=%.17g", i < 5 ? 'q' : 'v',
                                 i % 5 + 1, json_number_at(o, path));
            }
            json_free(o);
        } else
            snprintf(line, sizeof line,
                     "simulate fig7a --from orbit.json --periods 150 --samples 4 -o own.h5");
        free(told(*state, line));
        assert_int_equal(read_strobes(*state, "own.h5", states, periods), periods);
        double apart = 0;
        for (int k = orbit_periods; k < periods; k++)
            for (int i = 0; i < dimension / 2; i++)
                apart =
                    fmax(apart, fabs(states[k * dimension + i] - states[k % orbit_periods * dimension + i]));
        assert_true(own ? apart > 1e-3 : apart < 1e-10);
    }
}

/* Exponents are the logarithms of the multipliers over the orbit's time, and add up as the trace says. */
static void exponents_are_those_of_the_multipliers(void **state) {
    json *orbit = object_of(*state, "orbit fig7a --from orbit.json --json"),
         *l = object_of(*state, "lyapunov fig7a --from orbit.json --all --json");
    double time = 2 * acos(-1) / 38 * orbit_periods;
    for (int k = 0; k < dimension; k++) {
        char path[32];
        snprintf(path, sizeof path, "log_moduli.%d", k);
        double wanted = json_number_at(orbit, path) / time;
        snprintf(path, sizeof path, "exponents.%d", k);
        assert_true(fabs(json_number_at(l, path) - wanted) <= 1e-9 * (1 + fabs(wanted)));
    }
    assert_true(json_number_at(l, "exponents.0") > 1);
    assert_true(fabs(json_number_at(l, "sum") - json_number_at(l, "sum_rule")) < 1e-7);
    json_free(orbit);
    json_free(l);
}

static void close_to(const json *object, const char *path, double wanted, double by) {
    const double number = json_number_at(object, path);
    if (!(fabs(number - wanted) <= by))
        fail_msg("%s: %.17g instead of %.17g", path, number, wanted);
}

/* Without forcing the zero along the flow is among the exponents of a cycle; those of an equilibrium are the
 * real parts of its eigenvalues, and a record stays on it. */
static void cycles_and_equilibria_have_exponents(void **state) {
    char *text = told(*state, "classify relief-valve --set q=5 --json");
    put_text(*state, "cycle.json", text);
    free(text);
    json *cycle = object_of(*state, "orbit relief-valve --from cycle.json --json"),
         *l = object_of(*state, "lyapunov relief-valve --from cycle.json --all --json");
    const double period = json_number_at(cycle, "period");
    close_to(l, "exponents.0", 0, 0);
    close_to(l, "exponents.1", json_number_at(cycle, "log_moduli.0") / period, 1e-9);
    close_to(l, "exponents.2", json_number_at(cycle, "log_moduli.1") / period, 1e-6);
    close_to(l, "sum", json_number_at(l, "sum_rule"), 1e-6);
    assert_string_equal(json_text_at(l, "sign"), "zero");
    json_free(cycle);
    json_free(l);
    text = told(*state, "orbit flutter --set u=5 --json");
    put_text(*state, "rest.json", text);
    free(text);
    json *rest = object_of(*state, "orbit flutter --from rest.json --set u=8.7 --json");
    l = object_of(*state, "lyapunov flutter --from rest.json --set u=8.7 --all --json");
    for (int k = 0; k < 4; k++) {
        char one[32], other[32];
        snprintf(one, sizeof one, "exponents.%d", k);
        snprintf(other, sizeof other, "eigenvalues.%d.0", k);
        close_to(l, one, json_number_at(rest, other), 0);
    }
    assert_true(json_number_at(l, "exponents.0") > 1 && json_number_at(l, "exponents.3") < -1);
    json_free(rest);
    json_free(l);
    text = told(*state, "simulate flutter --from rest.json --set u=8.7 --periods 50 -o rest.csv");
    assert_non_null(strstr(text, "10001 samples"));
    free(text);
    text = told(*state, "diagnose flutter --from rest.json --set u=8.7 -o sheet.svg");
    assert_int_equal(strncmp(text, "flutter: equilibrium, unstable\n", 31), 0);
    free(text);
}

/* Where the orbits of a branch have shrunk to an equilibrium, and at folds and flips, exponents are zero as
 * accurately as they are known. */
static void special_points_have_an_exponent_zero(void **state) {
    free(told(*state, "continue relief-valve --set q=8.45 --in q=8.4:8.6 -o hopf.h5 --quiet"));
    free(told(*state, "continue impact-oscillator --set omega=0.8 --in omega=0.7:0.9 -o folds.h5 --quiet"));
    static const char *const lines[] = {"lyapunov relief-valve --from hopf.h5:HB1 --json",
                                        "lyapunov impact-oscillator --from folds.h5:LP1 --json",
                                        "lyapunov impact-oscillator --from folds.h5:PD1 --json"};
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        json *l = object_of(*state, lines[k]);
        assert_string_equal(json_text_at(l, "sign"), "zero");
        assert_true(json_number_at(l, "standard_error") > 0 && json_number_at(l, "standard_error") < 1e-5);
        json_free(l);
    }
    char *text = told(*state, "diagnose relief-valve --from hopf.h5:HB1 -o sheet.svg");
    assert_int_equal(strncmp(text, "relief-valve: equilibrium, ", 27), 0);
    free(text);
}

/* Page and spectrum are those of the orbit itself. */
static void the_orbit_itself_is_described(void **state) {
    char *text = told(*state, "diagnose fig7a --from orbit.json -o sheet.svg");
    assert_int_equal(strncmp(text, "fig7a: 3/5, unstable\n", 21), 0);
    free(text);
    json *spectrum = object_of(*state, "spectrum fig7a --from orbit.json --samples 1024 --json");
    assert_true(json_number_at(spectrum, "spectra.0.broadband_fraction") < 1e-9);
    json_free(spectrum);
    /* At other parameters the orbit is found by Newton's method. */
    text = told(*state, "diagnose fig7a --from orbit.json --set omega=38.001 -o sheet.svg");
    assert_int_equal(strncmp(text, "fig7a: 3/5, unstable\n", 21), 0);
    free(text);
}

/* A sweep's row gives its parameters, and its stored state or one reached from the scene's own. */
static void rows_and_cells_are_orbits(void **state) {
    static const struct {
        const char *line, *path;
        double value;
    } cases[] = {{"lyapunov fig6 --from map.h5:1 --json", "parameters.omega", 36},
                 {"lyapunov fig6 --from map.h5:6 --json", "parameters.stops.0.d", 0.037},
                 {"lyapunov fig6 --from plain.h5:7 --json", "parameters.omega", 46},
                 {"lyapunov fig7b --from basins.h5:2 --json", "parameters.stops.0.d", 0.02955}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        json *l = object_of(*state, cases[k].line);
        assert_true(fabs(json_number_at(l, cases[k].path) - cases[k].value) < 1e-12);
        json_free(l);
    }
    char *rows = told(*state, "export plain.h5 -o rows.csv"), *orbit;
    free(rows);
    orbit = told(*state, "orbit fig6 --from plain.h5:3");
    assert_int_equal(strncmp(orbit, "fig6: 3/4, stable\n", 18), 0);
    free(orbit);
    /* The record begins on the orbit, without the way to it. */
    free(told(*state, "simulate fig6 --from plain.h5:3 --periods 4 --quiet -o row.csv"));
    FILE *file = fopen(path_in(*state, "row.csv"), "r");
    char line[400];
    double time, q, first = NAN, last = NAN;
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        if (sscanf(line, "%lf,%lf", &time, &q) == 2) {
            first = time == 0 ? q : first;
            last = time == 4 ? q : last;
        }
    fclose(file);
    assert_true(fabs(first - last) < 1e-10 && fabs(first) > 1e-6);
}

/* Rows of further seeds, of passes up and down and of moved initial states are run again. Without forcing the
 * orbit has a period of its own, whether the row keeps a state or not. */
static void any_row_is_a_start(void **state) {
    static const struct {
        const char *line, *label;
    } cases[] = {{"orbit fig6 --from plain.h5:4", "fig6: 3/4, stable\n"},
                 {"orbit fig6 --from states.h5:2", "fig6: "},
                 {"orbit impact-oscillator --from carried.h5:3", "impact-oscillator: 1/2, stable\n"},
                 {"orbit impact-oscillator --from carried.h5:7", "impact-oscillator: 2/2, stable\n"},
                 {"orbit impact-oscillator --from carried.h5:10", "impact-oscillator: 1/2, stable\n"},
                 {"lyapunov relief-valve --from free.h5:1 --exponents 2 --json", "{"},
                 {"lyapunov relief-valve --from returns.h5:1 --exponents 2 --json", "{"},
                 {"orbit relief-valve --from free.h5:2", "relief-valve: equilibrium, stable\n"}};
    free(told(*state, "sweep impact-oscillator --over omega=0.8,0.835,0.84,0.86 --start both --quiet "
                      "-o carried.h5"));
    free(told(*state, "sweep relief-valve --over q=5,9,7 --quiet -o free.h5"));
    free(told(*state, "sweep relief-valve --over q=5:9:2 --what stroboscopic --quiet -o returns.h5"));
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char *text = told(*state, cases[k].line);
        if (strncmp(text, cases[k].label, strlen(cases[k].label)) != 0)
            fail_msg("%s: %.60s", cases[k].line, text);
        if (text[0] == '{') {
            json *l = json_read(text);
            close_to(l, "exponents.0", 0, 0);
            close_to(l, "exponents.1", -0.243911, 1e-6);
            json_free(l);
        }
        free(text);
    }
    /* Without a period a record begins on the motion, not where the scene does. */
    char first[2][200];
    free(told(*state, "simulate relief-valve --from free.h5:3 --periods 1 --quiet -o record0.csv"));
    free(told(*state, "simulate relief-valve --set q=7 --periods 1 --quiet -o record1.csv"));
    for (int k = 0; k < 2; k++) {
        FILE *file = fopen(path_in(*state, k ? "record1.csv" : "record0.csv"), "r");
        assert_non_null(file);
        do
            assert_non_null(fgets(first[k], sizeof first[k], file));
        while (strncmp(first[k], "0,", 2) != 0);
        fclose(file);
    }
    assert_string_not_equal(first[0], first[1]);
}

static void what_tells_no_motion_is_refused(void **state) {
    static const struct {
        const char *line, *part;
    } cases[] = {
        {"simulate fig6 --periods 1 -o x.h5 --from map.h5", "holds a sweep of 8 rows; name one"},
        {"simulate fig6 --periods 1 -o x.h5 --from map.h5:9", "holds a sweep of 8 rows"},
        {"simulate fig6 --periods 1 -o x.h5 --from map.h5:0", "holds a sweep of 8 rows"},
        {"simulate fig3 --set N=3 --periods 1 -o x.h5 --from plain.h5:1",
         "plain.h5:1: its orbit has N = 5 and"},
        {"simulate fig3 --set N=3 --periods 1 -o x.h5 --from map.h5:1", "map.h5:1: its orbit has N = 5 and"},
        {"simulate flutter --periods 1 -o x.h5 --from rest.json --transient 3", "--transient 3: "},
        {"lyapunov flutter --from rest.json -o x.png", "-o x.png: "},
        {"simulate fig7a --periods 1 -o x.h5 --from orbit.json --transient 3", "--transient 3: "},
        {"simulate two-mass --periods 1 -o x.h5 --from map.h5:1", "is an orbit of the model pipe"},
        {"lyapunov fig7a --from orbit.json -o x.png", "-o x.png: "},
        {"diagnose fig7a -o x.png --from own.h5:1", "own.h5: holds a trajectory"},
        {"diagnose fig7a -o x.png --from orbits.json", "name one by its line"},
        {"diagnose fig7a --from map.h5:1 -o x.png --data map.h5", "--data map.h5: is the same file"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        int status = run(*state, cases[k].line);
        char *out = said(*state, "out"), *err = said(*state, "err"), *end = strchr(err, '\n');
        if (status != 2 || out[0] || strncmp(err, "saltus: ", 8) != 0 || !end || end[1] ||
            !strstr(err, cases[k].part))
            fail_msg("%s: exit status %d, stdout '%s', stderr '%s'", cases[k].line, status, out, err);
        free(out);
        free(err);
    }
}

/* Near a saddle errors grow so much that an orbit's state does not lead back to it: then no other orbit is
 * taken for it. */
static void another_orbit_is_no_start(void **state) {
    static const char *const lines[] = {"orbit well.yaml --from w.h5:EP1",
                                        "continue well.yaml --from w.h5:EP1 --in F=0.3:0.4 -o x.h5",
                                        "simulate well.yaml --from w.h5:EP1 --periods 1 -o x.h5"};
    put_text(*state, "well.yaml",
             "model:\n"
             "  parameters: {F: 0.339, omega: 0.695}\n"
             "  motion: {x: -0.16*x' + x - x^3 + F*cos(omega*t)}\n"
             "  forcing: omega\n"
             "stop: {coordinate: x, d: 1.271, r: 0.71, sides: both}\n"
             "initial: {x: 0.3}\n");
    free(told(*state, "continue well.yaml --in omega=0.09:0.8 --direction down -o w.h5 --quiet"));
    free(told(*state, "orbit well.yaml --from w.h5:20"));
    for (int k = 0; k < 3; k++) {
        int status = run(*state, lines[k]);
        char *err = said(*state, "err");
        if (status != 2 || !strstr(err, "w.h5:EP1: the orbit is not found again, but another one"))
            fail_msg("%s: exit status %d, stderr '%s'", lines[k], status, err);
        assert_int_not_equal(access(path_in(*state, "x.h5"), F_OK), 0);
        free(err);
    }
}

int main(void) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_unstable_orbit_is_not_left),
        cmocka_unit_test(exponents_are_those_of_the_multipliers),
        cmocka_unit_test(cycles_and_equilibria_have_exponents),
        cmocka_unit_test(special_points_have_an_exponent_zero),
        cmocka_unit_test(the_orbit_itself_is_described),
        cmocka_unit_test(rows_and_cells_are_orbits),
        cmocka_unit_test(any_row_is_a_start),
        cmocka_unit_test(what_tells_no_motion_is_refused),
        cmocka_unit_test(another_orbit_is_no_start),
    };
    return cmocka_run_group_tests(tests, prepare, close_fixture);
}
