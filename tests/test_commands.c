/* The output of commands: help with its defaults, and summaries of sweeps with made-up rows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"
#include "json.h"
#include "made_sweep.h"
#include "text_lines.h"

#include <hdf5.h>
#include <sys/stat.h>
#include <time.h>

enum { classes_max = 40 };

static void check_told(fixture *f, const char *line, const char *wanted) {
    char *text = told(f, line);
    assert_string_equal(text, wanted);
    free(text);
}

/* However it is requested, help is the same and succeeds; without a request it goes to stderr as bad
 * input. */
static void help_has_many_names(void **state) {
    char *usage = told(*state, "--help"), *rest = usage;
    int commands = 0;
    check_told(*state, "-h", usage);
    check_told(*state, "help", usage);
    check_told(*state, "--version", "saltus " SALTUS_VERSION "\n");
    assert_int_equal(run(*state, ""), 2);
    char *out = said(*state, "out"), *err = said(*state, "err");
    assert_string_equal(out, "");
    assert_string_equal(err, usage);
    free(out);
    free(err);
    for (char *line = strtok_r(rest, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        char name[16], with[64], head[64];
        if (strncmp(line, "  saltus ", 9) != 0)
            continue;
        assert_int_equal(sscanf(line + 9, "%15s", name), 1);
        snprintf(with, sizeof with, "%s --help", name);
        char *help = told(*state, with);
        snprintf(with, sizeof with, "%s -h", name);
        check_told(*state, with, help);
        /* Its first line is the one in the list. */
        snprintf(head, sizeof head, "saltus %s ", name);
        assert_int_equal(strncmp(help, head, strlen(head)), 0);
        size_t length = strcspn(help, "\n") - strlen(head);
        assert_int_equal(strlen(line) - 19, length);
        assert_int_equal(strncmp(line + 19, help + strlen(head), length), 0);
        free(help);
        commands++;
    }
    assert_int_equal(commands, 14);
    free(usage);
}

/* Commands and library have the same defaults where options mean the same. */
static void told_defaults_are_those_of_the_library(void **state) {
    const saltus_flow_options flow = saltus_flow_defaults();
    const saltus_classify_options classify = saltus_classify_defaults();
    const saltus_sweep_options sweep = saltus_sweep_defaults();
    const saltus_lyapunov_options lyapunov = saltus_lyapunov_defaults();
    const saltus_harvest_options harvest = saltus_harvest_defaults();
    const saltus_branch_options branch = saltus_branch_defaults();
    const struct {
        const char *command, *option;
        double value;
    } table[] = {
        {"classify", "--transient", (double)classify.transient},
        {"classify", "--longest", classify.longest},
        {"classify", "--measure", (double)classify.measure},
        {"classify", "--rtol", classify.flow.rtol},
        {"classify", "--atol", classify.flow.atol},
        {"diagnose", "--transient", (double)classify.transient},
        {"diagnose", "--longest", classify.longest},
        {"diagnose", "--measure", (double)classify.measure},
        {"diagnose", "--rtol", classify.flow.rtol},
        {"diagnose", "--atol", classify.flow.atol},
        {"simulate", "--rtol", flow.rtol},
        {"simulate", "--atol", flow.atol},
        {"orbit", "--segments", saltus_orbit_defaults().segments},
        {"orbit", "--search", (double)harvest.periods},
        {"orbit", "--most", harvest.most},
        {"orbit", "--rtol", harvest.flow.rtol},
        {"orbit", "--atol", harvest.flow.atol},
        {"continue", "--step", branch.step},
        {"continue", "--step-max", branch.step_max},
        {"continue", "--points", branch.points},
        {"continue", "--switch", branch.switches},
        {"continue", "--transient", (double)classify.transient},
        {"continue", "--longest", classify.longest},
        {"continue", "--rtol", branch.orbit.flow.rtol},
        {"continue", "--atol", branch.orbit.flow.atol},
        {"lyapunov", "--precision", lyapunov.precision},
        {"lyapunov", "--transient", (double)lyapunov.transient},
        {"lyapunov", "--periods", (double)lyapunov.periods},
        {"lyapunov", "--members", lyapunov.members},
        {"lyapunov", "--interval", lyapunov.interval},
        {"lyapunov", "--seed", (double)lyapunov.seed},
        {"lyapunov", "--rtol", lyapunov.flow.rtol},
        {"lyapunov", "--atol", lyapunov.flow.atol},
        {"spectrum", "--transient", (double)classify.transient},
        {"spectrum", "--longest", classify.longest},
        {"spectrum", "--rtol", saltus_spectrum_defaults().flow.rtol},
        {"spectrum", "--atol", saltus_spectrum_defaults().flow.atol},
        {"sweep", "--seeds", sweep.seeds},
        {"sweep", "--seed", (double)sweep.seed},
        {"sweep", "--at-most", (double)sweep.transient},
        {"sweep", "--longest", sweep.longest},
        {"sweep", "--record", (double)sweep.record},
        {"sweep", "--measure", (double)sweep.measure},
        {"sweep", "--rtol", sweep.flow.rtol},
        {"sweep", "--atol", sweep.flow.atol},
        {"basins", "--at-most", (double)sweep.transient},
        {"basins", "--longest", sweep.longest},
        {"basins", "--rtol", sweep.flow.rtol},
        {"basins", "--atol", sweep.flow.atol},
    };
    char *help = NULL;
    for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
        char text[64];
        if (k == 0 || strcmp(table[k].command, table[k - 1].command) != 0) {
            free(help);
            snprintf(text, sizeof text, "%s --help", table[k].command);
            help = told(*state, text);
        }
        snprintf(text, sizeof text, "\n  %s ", table[k].option);
        const char *line = strstr(help, text);
        assert_non_null(line);
        const char *end = strchr(line + 1, '\n'), *number = strstr(line, "(default ");
        double value = NAN;
        if (number && number < end)
            value = strtod(number + strlen("(default "), NULL);
        /* Real numbers are printed with six digits. */
        if (!(fabs(value - table[k].value) <= 5e-6 * table[k].value))
            fail_msg("%s %s: the default is told as %g, the library's is %g", table[k].command,
                     table[k].option, value, table[k].value);
    }
    free(help);
}

static int extent_of(const char *path, const char *name) {
    hsize_t extent[8] = {0};
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), set = H5Dopen2(file, name, H5P_DEFAULT),
          space = H5Dget_space(set);
    assert_true(H5Sget_simple_extent_dims(space, extent, NULL) > 0);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
    return (int)extent[0];
}

/* A run reports the file's samples and events, and the requested periods. */
static void a_run_tells_what_its_file_holds(void **state) {
    fixture *f = *state;
    char *text = told(f, "simulate impact-oscillator --periods 4 --transient 7 --samples 12 -o run.h5"),
         wanted[80];
    snprintf(wanted, sizeof wanted, "run.h5: %d samples, %d events over 4 periods\n",
             extent_of(path_in(f, "run.h5"), "trajectory/time"),
             extent_of(path_in(f, "run.h5"), "events/time"));
    assert_string_equal(text, wanted);
    free(text);
}

/* Keep the last command's output under another name. */
static void keep(fixture *f, const char *name) {
    char from[320];
    snprintf(from, sizeof from, "%s", path_in(f, "out"));
    assert_int_equal(rename(from, path_in(f, name)), 0);
}

/* Newton's method starts at an orbit from a file, stable or not, without following the motion until it
 * settles. */
static void an_orbit_of_a_file_is_where_it_begins(void **state) {
    fixture *f = *state;
    FILE *file = fopen(path_in(f, "flip.yaml"), "w");
    assert_non_null(file);
    fputs("model: oscillator\nc: 0.05\nF: 1\nomega: 2.6\nstop: {d: 0, r: 0.8}\n", file);
    fclose(file);
    /* Beyond its flip the orbit exists, unstable. */
    free(told(f, "orbit flip.yaml --periods 1 --json"));
    keep(f, "orbit.json");
    char *text[2], *steps[2];
    for (int k = 0; k < 2; k++) {
        assert_int_equal(
            run(f, k ? "orbit flip.yaml --from orbit.json --set omega=2.7 --json --verbose --transient 9"
                     : "orbit flip.yaml --from orbit.json --set omega=2.7 --json --verbose"),
            0);
        text[k] = said(f, "out");
        steps[k] = said(f, "err");
    }
    assert_string_equal(text[0], text[1]);
    assert_string_equal(steps[0], steps[1]);
    json *orbit = json_read(text[0]);
    assert_string_equal(json_text_at(orbit, "label"), "1/1");
    assert_true(json_at(orbit, "stable")->kind == JSON_FALSE);
    keep(f, "unstable.json");
    char *again = told(f, "orbit flip.yaml --from unstable.json --json");
    json *same = json_read(again);
    for (const json *x = json_at(orbit, "state")->first, *y = json_at(same, "state")->first; x;
         x = x->next, y = y->next)
        check_near(y->number, x->number, 1e-10);
    json_free(orbit);
    json_free(same);
    free(again);
    for (int k = 0; k < 2; k++) {
        free(text[k]);
        free(steps[k]);
    }
}

/* A continuation reports the numbers of points and branches of its JSON, one way or both; in the singular if
 * there is one. */
static void a_branch_tells_its_points(void **state) {
    static const char *const ways[] = {"up", "down", "both"};
    fixture *f = *state;
    for (int k = 0; k < 3; k++) {
        char line[160], wanted[120];
        int points = 0, branches = 0;
        snprintf(line, sizeof line,
                 "continue impact-oscillator --in omega=0.99:1.01 --points 3 --direction %s --json -o b.h5",
                 ways[k]);
        char *text = told(f, line);
        for (const char *at = text; *at; at += *at == '\n', points++) {
            json *point = json_value(&at);
            int branch = (int)json_number_at(point, "branch");
            branches = branch >= branches ? branch + 1 : branches;
            json_free(point);
        }
        free(text);
        text = told(f, "continue impact-oscillator --in omega=0.99:1.01 -o b.h5 --resume");
        snprintf(wanted, sizeof wanted, "impact-oscillator: %d points on %d branch%s in b.h5\n", points,
                 branches, branches == 1 ? "" : "es");
        assert_int_equal(strncmp(text, wanted, strlen(wanted)), 0);
        free(text);
        remove(path_in(f, "b.h5"));
    }
}

/* Scenes are listed with their titles; a named one is printed unchanged. */
static void scenes_are_listed_and_printed(void **state) {
    char *list = told(*state, "scenes"), *rest = list;
    for (int k = 0; k < saltus_scene_builtin_count(); k++) {
        const char *name = saltus_scene_builtin_name(k);
        saltus_message message = {.text = ""};
        saltus_scene scene;
        check_ok(saltus_scene_load(name, &scene, &message), &message);
        char *line = strtok_r(rest, "\n", &rest);
        size_t length = strlen(name);
        assert_non_null(line);
        assert_true(strncmp(line, name, length) == 0 && line[length] == ' ');
        assert_string_equal(line + length + strspn(line + length, " "), scene.title);
        saltus_scene_clear(&scene);
    }
    assert_null(strtok_r(rest, "\n", &rest));
    free(list);
    for (int k = 0; k < saltus_scene_builtin_count(); k += saltus_scene_builtin_count() - 1) {
        char line[64];
        snprintf(line, sizeof line, "scenes %s", saltus_scene_builtin_name(k));
        check_told(*state, line, saltus_scene_builtin_text(k));
    }
}

/* The check of a scene prints all of its numbers with their meanings. */
static void a_checked_scene_is_told(void **state) {
    static const char *const texts[] = {"model: pipe\nN: 3\nalpha: 0.006\nomega: 41.25\nsigma: 0.3\nstops:\n "
                                        " - {d: 0.03, r: 0.7, xi: 0.25, sides: "
                                        "lower}\n  - {d: 0.04, r: 0.8, xi: 0.75, sides: both}\n",
                                        "model: oscillator\nN: 2\nc: 0.125\nk2: 1.75\nF: 0.3\nomega: "
                                        "0.123456789012\nstop: {d: 0.35, r: 0.65, "
                                        "weight: [0.5, -1.5]}\n"};
    static const char *const sides[] = {"", "upper side", "lower side", "both sides"};
    fixture *f = *state;
    for (int m = 0; m < 2; m++) {
        saltus_message message = {.text = ""};
        saltus_scene scene;
        text_lines lines;
        int count;
        FILE *file = fopen(path_in(f, "mine.yaml"), "w");
        assert_non_null(file);
        fputs(texts[m], file);
        fclose(file);
        check_ok(saltus_scene_load(path_in(f, "mine.yaml"), &scene, &message), &message);
        saltus_system *system = build(&scene.spec);
        lines.text = told(f, "check mine.yaml");
        lines.at = lines.text;
        const saltus_parameter *p = saltus_model_parameters(scene.spec.model, &count);
        char head[200];
        lines_next(&lines, "mine: ok", NULL, 0);
        snprintf(head, sizeof head, "model: %s (%s)", saltus_model_name(scene.spec.model),
                 saltus_model_summary(scene.spec.model));
        lines_next(&lines, head, NULL, 0);
        snprintf(head, sizeof head, "state: %d numbers (q1, ", saltus_system_dimension(system));
        assert_int_equal(strncmp(lines.at, head, strlen(head)), 0);
        lines.at = strchr(lines.at, '\n') + 1;
        for (int k = 0; k < count; k++) {
            const char *end = strchr(lines.at, '\n'), *at = strstr(lines.at, p[k].name);
            assert_true(end && at && at < end);
            assert_int_equal(strncmp(end - strlen(p[k].meaning), p[k].meaning, strlen(p[k].meaning)), 0);
            double value = strtod(at + strlen(p[k].name), NULL), exact = scene.spec.parameters[k];
            check_near(value, exact, 5.1e-9 * fabs(exact));
            lines.at = end + 1;
        }
        for (int s = 0; s < scene.spec.stop_count; s++) {
            const saltus_stop *stop = &scene.spec.stops[s];
            snprintf(head, sizeof head, "stop %d: %s, d = %g, r = %g, ", s + 1, sides[stop->sides], stop->d,
                     stop->r);
            if (m == 0)
                lines_next(&lines, head, "xi = ", 1, stop->xi);
            else
                lines_next(&lines, head, "weight = [", 2, stop->weight[0], stop->weight[1]);
        }
        lines_next(&lines, "metric of impacts: the identity", NULL, 0);
        lines_next(&lines, "symmetry: none found under a change of all signs", NULL, 0);
        snprintf(head, sizeof head, ", integrator %s", saltus_system_integrator(system));
        lines_next(&lines, "forcing period T = ", head, 1, saltus_system_period(system));
        lines_end(&lines);
        saltus_system_free(system);
    }
}

/* A label of motions and its count. */
typedef struct class_count {
    char label[32];
    int count;
} class_count;

/* Count the classes of rows, most frequent first, then by name. */
static int count_classes(const saltus_sweep_row *rows, long long row_count, class_count classes[]) {
    int count = 0;
    for (long long k = 0; k < row_count; k++) {
        class_count one = {.count = 1};
        int at = 0;
        saltus_sweep_label(&rows[k], one.label);
        while (at < count && strcmp(classes[at].label, one.label) != 0)
            at++;
        assert_true(at < classes_max);
        if (at == count)
            classes[count++] = one;
        else
            classes[at].count++;
    }
    for (int i = 1; i < count; i++)
        for (int k = i; k > 0; k--) {
            class_count *a = &classes[k - 1], *b = &classes[k], kept = *a;
            if (a->count > b->count || (a->count == b->count && strcmp(a->label, b->label) < 0))
                break;
            *a = *b;
            *b = kept;
        }
    return count;
}

static void check_classes(const json *summary, const class_count *classes, int count, int rows) {
    assert_int_equal(json_count(json_at(summary, "classes")), count);
    for (int k = 0; k < count; k++) {
        char path[64];
        snprintf(path, sizeof path, "classes.%d.label", k);
        assert_string_equal(json_text_at(summary, path), classes[k].label);
        snprintf(path, sizeof path, "classes.%d.count", k);
        assert_true(json_number_at(summary, path) == classes[k].count);
        snprintf(path, sizeof path, "classes.%d.share", k);
        check_near(json_number_at(summary, path), (double)classes[k].count / rows, 1e-15);
    }
}

/* How many labels the rows get. */
static int kinds = 5;

static void fill_kinds(made_place *m) {
    for (int s = 0; s < m->seeds; s++) {
        /* Smaller numbers are more frequent; sometimes two labels are equally frequent. */
        int k = (int)((m->place * m->seeds + s) % (2 * kinds - 1)), name = k < kinds ? k : (k - kinds) / 2;
        m->row[s] = made_periodic((7 * name) % 23, 1 + name % 3);
    }
}

static saltus_scene oscillator_scene(void) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    check_ok(saltus_scene_load("impact-oscillator", &scene, &message), &message);
    return scene;
}

static saltus_axis axis_of(int count) {
    return (saltus_axis){.key = "omega", .low = 0.9, .high = 1.1, .count = count};
}

/* Resuming a journal that lacks some places: its rows are kept and counted, in any kind of file, and the
 * computed ones are reported. A table of rows is not read again: then the classes are those of this run. */
static void a_resumed_sweep_counts_what_it_computes(void **state) {
    enum { points = 4, passes = 3, places = points * passes, seeds = 2, rows = places * seeds };
    static const char *const names[] = {"a\"b\\c.h5", "rows.csv"};
    const saltus_scene scene = oscillator_scene();
    const saltus_axis axis = axis_of(points);
    fixture *f = *state;
    saltus_sweep_options options = saltus_sweep_defaults();
    options.seeds = seeds;
    options.passes = 7;
    kinds = 5;
    for (int k = 0; k < 8; k++) {
        const char *name = names[k % 2];
        /* Missing: nothing, one in the last line, all of that and one in the line before, all but one. */
        const int lacking[] = {0, 1, 5, places - 1}, left = lacking[k / 2];
        char line[256];
        class_count classes[classes_max];
        made_write(path_in(f, name), &scene, &axis, 1, &options, fill_kinds, places - left);
        snprintf(
            line, sizeof line,
            "sweep impact-oscillator --over omega=0.9:1.1:%d --what max --seeds %d --start both --threads 1 "
            "--resume -o '%s' --json",
            points, seeds, name);
        char *text = told(f, line);
        json *summary = json_read(text);
        assert_string_equal(json_text_at(summary, "version"), SALTUS_VERSION);
        assert_string_equal(json_text_at(summary, "scene"), "impact-oscillator");
        assert_string_equal(json_text_at(summary, "file"), name);
        assert_string_equal(json_text_at(summary, "kind"), "sweep");
        assert_int_equal(json_at(summary, "complete")->kind, JSON_TRUE);
        assert_int_equal(json_count(json_at(summary, "passes")), passes);
        assert_string_equal(json_text_at(summary, "passes.0"), "reset");
        assert_string_equal(json_text_at(summary, "passes.1"), "up");
        assert_string_equal(json_text_at(summary, "passes.2"), "down");
        assert_true(json_number_at(summary, "points") == points);
        assert_true(json_number_at(summary, "seeds") == seeds);
        assert_true(json_number_at(summary, "rows") == rows);
        assert_true(json_number_at(summary, "ranks") == 1);
        double computed = json_number_at(summary, "computed"), seconds = json_number_at(summary, "seconds");
        assert_true(computed == left * seeds && seconds >= 0);
        check_near(json_number_at(summary, "trajectories_per_second") * seconds, computed, 2e-5 * computed);
        if (k % 2 == 0) {
            saltus_sweep_file file = made_read(path_in(f, name));
            assert_true(file.complete && file.row_count == rows);
            check_classes(summary, classes, count_classes(file.rows, rows, classes), rows);
            saltus_sweep_file_clear(&file);
        } else {
            double sum = 0, share = 0;
            for (const json *c = json_at(summary, "classes")->first; c; c = c->next) {
                sum += json_number_at(c, "count");
                share += json_number_at(c, "share");
            }
            assert_true(sum == computed);
            check_near(share, left > 0, 1e-12);
        }
        json_free(summary);
        free(text);
        char journal[64];
        snprintf(journal, sizeof journal, "%s.journal", name);
        assert_int_equal(access(path_in(f, journal), F_OK), -1);
        remove(path_in(f, name));
    }
}

static double clock_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The reported time and speed, in text and in JSON, are those of the computed part: the time is at most the
 * command's, and their product is the amount of work. */
static void a_sweep_tells_its_time_and_speed(void **state) {
    enum { points = 5, passes = 3, places = points * passes };
    const saltus_scene scene = oscillator_scene();
    const saltus_axis axis = axis_of(points);
    fixture *f = *state;
    saltus_sweep_options options = saltus_sweep_defaults();
    options.passes = 7;
    kinds = 5;
    for (int k = 0; k < 4; k++) {
        const int left = k < 2 ? 2 : places;
        char line[256], end[40] = "";
        double seconds, rate;
        int used = 0;
        made_write(path_in(f, "s.h5"), &scene, &axis, 1, &options, fill_kinds, places - left);
        snprintf(
            line, sizeof line,
            "sweep impact-oscillator --over omega=0.9:1.1:%d --what max --start both --threads 1 --resume "
            "-o s.h5%s",
            points, k % 2 ? " --json" : "");
        double begin = clock_now();
        char *text = told(f, line);
        double wall = clock_now() - begin;
        if (k % 2) {
            json *summary = json_read(text);
            seconds = json_number_at(summary, "seconds");
            rate = json_number_at(summary, "trajectories_per_second");
            json_free(summary);
        } else {
            char *last = strstr(text, " trajectories/s");
            assert_non_null(last);
            while (last[-1] != '\n')
                last--;
            assert_int_equal(sscanf(last, "%lf s, %lf trajectories/s%n", &seconds, &rate, &used), 2);
            snprintf(end, sizeof end, "%s\n", left < places ? "; the others were there" : "");
            assert_string_equal(last + used, end);
        }
        assert_true(seconds > 0 && seconds <= 1.005 * wall);
        check_near(rate * seconds, left, 0.006 * left);
        free(text);
        remove(path_in(f, "s.h5"));
    }
}

/* The text lists at most twelve labels, each with its count and share, and the rest together. */
static void a_table_of_classes_has_twelve_lines(void **state) {
    static const int tried[] = {1, 12, 13, 20};
    enum { points = 97 };
    const saltus_scene scene = oscillator_scene();
    const saltus_axis axis = axis_of(points);
    const saltus_sweep_options options = saltus_sweep_defaults();
    fixture *f = *state;
    for (size_t t = 0; t < sizeof tried / sizeof tried[0]; t++) {
        class_count classes[classes_max];
        kinds = tried[t];
        made_write(path_in(f, "s.h5"), &scene, &axis, 1, &options, fill_kinds, points);
        saltus_sweep_file file = made_read(path_in(f, "s.h5"));
        int count = count_classes(file.rows, points, classes), shown = 0, sum = 0;
        assert_int_equal(count, kinds);
        saltus_sweep_file_clear(&file);
        char *text = told(f, "sweep impact-oscillator --over omega=0.9:1.1:97 --what max --resume -o s.h5"),
             *rest = text;
        char *line = strtok_r(rest, "\n", &rest);
        assert_string_equal(line, "impact-oscillator: 97 points, 97 trajectories in s.h5");
        line = strtok_r(NULL, "\n", &rest);
        assert_int_equal(strncmp(line, "motion ", 7), 0);
        for (; shown < count && shown < 12; shown++) {
            char label[32];
            int number;
            double share;
            line = strtok_r(NULL, "\n", &rest);
            assert_int_equal(sscanf(line, "%31s %d %lf %%", label, &number, &share), 3);
            assert_string_equal(label, classes[shown].label);
            assert_int_equal(number, classes[shown].count);
            check_near(share, 100.0 * number / points, 0.0051);
            sum += number;
        }
        line = strtok_r(NULL, "\n", &rest);
        if (count > 12) {
            int others, number;
            double share;
            assert_int_equal(sscanf(line, "%d others %d %lf %%", &others, &number, &share), 3);
            assert_true(others == count - 12 && number == points - sum);
            check_near(share, 100.0 * number / points, 0.0051);
            line = strtok_r(NULL, "\n", &rest);
        }
        assert_string_equal(line, "all were there");
        assert_null(strtok_r(NULL, "\n", &rest));
        free(text);
        remove(path_in(f, "s.h5"));
    }
}

/* Without forces each place is an equilibrium of its own; one row has found none. */
static void fill_rests(made_place *m) {
    int k = (int)(m->place % (2 * kinds - 1));
    m->row[0] = made_other(m->place ? SALTUS_EQUILIBRIUM : SALTUS_UNDECIDED);
    m->state[0] = -0.05 * (k < kinds ? k : (k - kinds) / 2);
}

/* The text lists at most twelve attractors by the size of their basins, each with its count and share, then
 * how many are left out and the rows without one. JSON lists all. */
static void a_table_of_attractors_has_twelve_lines(void **state) {
    static const int tried[] = {1, 12, 13, 15};
    enum { rows = 49 };
    const saltus_axis axes[2] = {{.key = "q1", .low = -0.6, .high = 0.6, .count = 7},
                                 {.key = "v1", .low = -0.5, .high = 0.5, .count = 7}};
    static const char line[] =
        "basins impact-oscillator --set k=0 F=0 c=5 --over q1=-0.6:0.6:7 --over v1=-0.5:0.5:7 "
        "--resume -o b.h5";
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message = {.text = ""};
    saltus_scene scene = oscillator_scene();
    fixture *f = *state;
    options.record = 1;
    check_ok(saltus_scene_set(&scene, "k=0", &message), &message);
    check_ok(saltus_scene_set(&scene, "F=0", &message), &message);
    check_ok(saltus_scene_set(&scene, "c=5", &message), &message);
    for (size_t t = 0; t < sizeof tried / sizeof tried[0]; t++) {
        char in_json[160], label[32];
        int number, sum = 0, last = rows;
        double share;
        kinds = tried[t];
        made_write_as(true, path_in(f, "b.h5"), &scene, axes, 2, &options, fill_rests, rows);
        snprintf(in_json, sizeof in_json, "%s --json", line);
        char *text = told(f, in_json);
        json *summary = json_read(text);
        free(text);
        const json *one = json_at(summary, "attractors");
        assert_int_equal(json_count(one), kinds);
        text = told(f, line);
        char *rest = text, *shown = strtok_r(rest, "\n", &rest);
        assert_string_equal(shown, "impact-oscillator: 49 points, 49 trajectories in b.h5");
        shown = strtok_r(NULL, "\n", &rest);
        assert_int_equal(strncmp(shown, "attractor ", 10), 0);
        one = one->first;
        for (int k = 0; k < kinds; k++, one = one->next) {
            int count = (int)json_number_at(one, "count");
            assert_true(count <= last && count > 0);
            check_near(json_number_at(one, "share"), (double)count / rows, 1e-15);
            sum += last = count;
            if (k >= 12)
                continue;
            shown = strtok_r(NULL, "\n", &rest);
            assert_int_equal(sscanf(shown, "%31s %d %lf %%", label, &number, &share), 3);
            assert_string_equal(label, json_text_at(one, "label"));
            assert_int_equal(number, count);
            check_near(share, 100.0 * count / rows, 0.0051);
        }
        assert_int_equal(sum, rows - 1);
        if (kinds > 12) {
            snprintf(label, sizeof label, "%d others", kinds - 12);
            assert_string_equal(strtok_r(NULL, "\n", &rest), label);
        }
        shown = strtok_r(NULL, "\n", &rest);
        assert_int_equal(sscanf(shown, "none: %31s %d %lf %%", label, &number, &share), 3);
        assert_int_equal(number, 1);
        check_near(share, 100.0 / rows, 0.0051);
        assert_string_equal(strtok_r(NULL, "\n", &rest), "all were there");
        assert_null(strtok_r(NULL, "\n", &rest));
        json_free(summary);
        free(text);
        remove(path_in(f, "b.h5"));
    }
}

static void fill_clouds(made_place *m) {
    m->row[0] = made_periodic(1, 1);
    m->turning_count[0] = m->impact_count[0] = 1;
    m->turning[0] = 0.01;
    m->impact[0] = (saltus_sweep_impact){0.1, 0.25, 0};
}

/* Quoted words are one word, and existing files are not computed again: figure 8 from made-up sweeps, with a
 * gnuplot that records its input. */
static void titles_of_the_paper_are_whole(void **state) {
    static const char *const restitution[] = {"r=0.8", "r=0.7", "r=0.6"};
    fixture *f = *state;
    char path[4200], *usual = strdup(getenv("PATH"));
    FILE *file = fopen(path_in(f, "gnuplot"), "w");
    assert_non_null(file);
    fputs("#!/bin/sh\ncat >>scripts\nprintf %080d 0\nprintf 'IEND....'\n", file);
    fclose(file);
    chmod(path_in(f, "gnuplot"), 0755);
    for (int k = 0; k < 3; k++) {
        const saltus_axis axis = {.key = "omega", .low = 0.055, .high = 55, .count = 125};
        saltus_sweep_options options = saltus_sweep_defaults();
        saltus_message message = {.text = ""};
        saltus_scene scene;
        char name[16];
        check_ok(saltus_scene_load("fig8", &scene, &message), &message);
        check_ok(saltus_scene_set(&scene, restitution[k], &message), &message);
        options.transient = 200;
        options.keep = SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS;
        snprintf(name, sizeof name, "fig8%c.h5", 'a' + k);
        made_write(path_in(f, name), &scene, &axis, 1, &options, fill_clouds, axis.count);
    }
    snprintf(path, sizeof path, "%s:%s", f->folder, usual);
    setenv("PATH", path, 1);
    char *text = told(f, "paper --quick --figure 8 --resume -o ."), *scripts = said(f, "scripts");
    setenv("PATH", usual, 1);
    const char *at = text, *title = scripts;
    for (int k = 0; k < 3; k++)
        for (int view = 0; view < 2; view++) {
            char words[80];
            snprintf(words, sizeof words, "pipe with a one-sided stop, r = %s", restitution[k] + 2);
            title = strstr(title, words);
            assert_non_null(title);
            title += strlen(words);
            at = view ? at : strstr(at, "all were there\n");
            assert_non_null(at);
            snprintf(words, sizeof words, "figure: ./fig8%c-%s.png\n", 'a' + k,
                     view ? "velocity" : "displacement");
            at = strstr(at, words);
            assert_non_null(at);
        }
    free(scripts);
    free(text);
    free(usual);
    folder_files(f->folder, true);
}

static int undecided_rows;
static saltus_verdict undecided_verdict;

static void fill_undecided(made_place *m) {
    m->row[0] = m->place < undecided_rows ? made_other(undecided_verdict) : made_periodic(1, 1);
}

/* A hint is printed only if motions are left irregular or undecided and more can be done about it. */
static void what_could_be_decided_is_told(void **state) {
    static const struct {
        int undecided;
        saltus_verdict verdict;
        unsigned keep;
        long long measure;
        const char *more, *hint, *number;
    } cases[] = {
        {0, SALTUS_IRREGULAR, 0, 32000, "--what max", NULL, NULL},
        {2, SALTUS_IRREGULAR, 0, 32000, "--what max", "irregular: no period up to 7 T ", "--what lyapunov"},
        {0, SALTUS_UNDECIDED, SALTUS_KEEP_LYAPUNOV, 900, "--what lyapunov --measure 900", NULL, NULL},
        {2, SALTUS_IRREGULAR, SALTUS_KEEP_LYAPUNOV, 900, "--what lyapunov --measure 900",
         "irregular: chaos watched for 900 periods, too few for a --lifetime of 10000", "--measure"},
        {1, SALTUS_UNDECIDED, SALTUS_KEEP_LYAPUNOV, 900, "--what lyapunov --measure 900",
         "undecided: exponents that 900 periods ", "--measure"},
        {3, SALTUS_UNDECIDED, SALTUS_KEEP_LYAPUNOV, 1, "--what lyapunov --measure 1",
         "undecided: exponents that 1 periods ", "--measure"},
        {3, SALTUS_IRREGULAR, SALTUS_KEEP_LYAPUNOV, 0, "--what lyapunov --measure 0", NULL, NULL},
    };
    enum { points = 3 };
    const saltus_scene scene = oscillator_scene();
    const saltus_axis axis = axis_of(points);
    fixture *f = *state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_sweep_options options = saltus_sweep_defaults();
        char line[256];
        options.keep = cases[k].keep;
        options.measure = cases[k].measure;
        options.longest = 7;
        undecided_rows = cases[k].undecided;
        undecided_verdict = cases[k].verdict;
        made_write(path_in(f, "s.h5"), &scene, &axis, 1, &options, fill_undecided, points);
        snprintf(line, sizeof line,
                 "sweep impact-oscillator --over omega=0.9:1.1:%d --longest 7 --resume -o s.h5 %s", points,
                 cases[k].more);
        char *text = told(f, line),
             *hint = strstr(text, cases[k].verdict == SALTUS_IRREGULAR ? "\nirregular: " : "\nundecided: ");
        if (!hint != !cases[k].hint)
            fail_msg("%s says:\n%s", line, text);
        if (hint) {
            assert_int_equal(strncmp(hint + 1, cases[k].hint, strlen(cases[k].hint)), 0);
            assert_non_null(strstr(hint, cases[k].number));
        }
        free(text);
        remove(path_in(f, "s.h5"));
    }
}

/* Give the verdicts in a file the type of an archive: eleven words. */
static void forget_newest_verdict(const char *path) {
    enum { most = 16 };
    int values[most];
    hsize_t extent[4];
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), set = H5Dopen2(file, "rows/verdict", H5P_DEFAULT);
    hid_t space = H5Dget_space(set), type = H5Dget_type(set), old = H5Tenum_create(H5T_NATIVE_INT);
    assert_int_equal(H5Sget_simple_extent_dims(space, extent, NULL), 4);
    assert_true(H5Sget_simple_extent_npoints(space) <= most);
    assert_int_equal(H5Tget_nmembers(type), 12);
    assert_true(
        H5Dread(set, H5Tget_native_type(type, H5T_DIR_DEFAULT), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    for (int v = 0; v < 11; v++)
        assert_true(H5Tenum_insert(old, saltus_verdict_word((saltus_verdict)v), &v) >= 0);
    for (hssize_t k = 0; k < H5Sget_simple_extent_npoints(space); k++)
        values[k] = values[k] == SALTUS_BEYOND ? (int)SALTUS_FAILED : values[k];
    H5Dclose(set);
    assert_true(H5Ldelete(file, "rows/verdict", H5P_DEFAULT) >= 0);
    set = H5Dcreate2(file, "rows/verdict", old, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(set >= 0 && H5Dwrite(set, old, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Dclose(set);
    H5Tclose(old);
    H5Tclose(type);
    H5Sclose(space);
    H5Fclose(file);
}

/* A start beyond a stop is no failure of the flow: rows, tables, summaries and refusals tell it apart; if all
 * starts lie there the exit status is that of classify. In an archive without this verdict such rows have
 * failed. */
static void starts_beyond_a_stop_are_told_apart(void **state) {
    static const char run_it[] = "sweep impact-oscillator --set q1=0.5 --over d=0.1,0.3,1 --quiet -o ";
    fixture *f = *state;
    char line[160];
    for (int k = 0; k < 3; k++) {
        snprintf(line, sizeof line, "%s%s", run_it, k == 0 ? "s.h5" : k == 1 ? "s.csv" : "j.h5 --json");
        char *text = told(f, line);
        assert_non_null(strstr(text, k < 2 ? "\nbeyond a stop               2   66.67 %"
                                           : "{\"label\": \"beyond a stop\", \"count\": 2, "));
        assert_true((strstr(text, "\nbeyond a stop: the start lies there") != NULL) == (k < 2));
        assert_null(strstr(text, "failed"));
        free(text);
    }
    for (int old = 0; old < 2; old++) {
        const char *const word = old ? "failed" : "beyond a stop";
        if (old)
            forget_newest_verdict(path_in(f, "s.h5"));
        free(told(f, "export s.h5 -o e.csv --force"));
        size_t length;
        char *table = read_all(path_in(f, "e.csv"), &length), *rest = table;
        int rows = 0;
        for (char *at = strtok_r(rest, "\n", &rest); at; at = strtok_r(NULL, "\n", &rest)) {
            char name[32] = "", label[32] = "";
            if (sscanf(at, "0.%*[0-9],reset,0,%31[^,]", name) == 1) {
                snprintf(label, sizeof label, ",%s", word);
                assert_string_equal(name, word);
                assert_string_equal(at + strlen(at) - strlen(label), label);
                rows++;
            }
        }
        assert_int_equal(rows, 2);
        free(table);
        assert_int_equal(run(f, "diagnose impact-oscillator --from s.h5:1 -o d.png"), 2);
        char *why = said(f, "err");
        snprintf(line, sizeof line, "s.h5:1: its trajectory has come to nothing (%s)", word);
        assert_non_null(strstr(why, line));
        free(why);
    }
    assert_int_equal(run(f, "sweep impact-oscillator --set q1=0.5 --over d=0.1,0.3 --quiet -o n.csv"),
                     run(f, "classify impact-oscillator --set q1=0.5 d=0.1"));
    assert_int_equal(run(f, "sweep impact-oscillator --set q1=0.5 --over d=0.1,0.3 --quiet -o n.csv --force"),
                     2);
    char *why = said(f, "err");
    assert_non_null(strstr(why, "the displacement 0.5 at stop 1 is beyond its upper side (d = 0.1)"));
    free(why);
    char *text =
        told(f, "basins impact-oscillator --set d=0.1 --over q1=-0.1,0.5 --over v1=0,1 -o n.h5 --quiet");
    assert_non_null(strstr(text, "\nnone: beyond a stop             2   50.00 %"));
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(starts_beyond_a_stop_are_told_apart),
        cmocka_unit_test(help_has_many_names),
        cmocka_unit_test(told_defaults_are_those_of_the_library),
        cmocka_unit_test(a_run_tells_what_its_file_holds),
        cmocka_unit_test(an_orbit_of_a_file_is_where_it_begins),
        cmocka_unit_test(a_branch_tells_its_points),
        cmocka_unit_test(scenes_are_listed_and_printed),
        cmocka_unit_test(a_checked_scene_is_told),
        cmocka_unit_test(a_resumed_sweep_counts_what_it_computes),
        cmocka_unit_test(a_sweep_tells_its_time_and_speed),
        cmocka_unit_test(a_table_of_classes_has_twelve_lines),
        cmocka_unit_test(a_table_of_attractors_has_twelve_lines),
        cmocka_unit_test(titles_of_the_paper_are_whole),
        cmocka_unit_test(what_could_be_decided_is_told),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
