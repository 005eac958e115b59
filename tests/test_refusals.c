/* The answers of commands to bad input: an exit status, and one message with its words and numbers in order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

static void put_text(fixture *f, const char *name, const char *text) {
    FILE *file = fopen(path_in(f, name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* Scenes that differ from all built-in ones, and one branch of an orbit with two masses. */
static int prepare(void **state) {
    open_fixture(state);
    put_text(*state, "twice.yaml", "model: oscillator\nc: 0.05\nF: 1\nomega: 2.7\nstop: {d: 0, r: 0.8}\n");
    put_text(*state, "start.yaml",
             "model: pipe\nN: 3\nomega: 42\nstop: {d: 0.01}\ninitial: {q: [0.002, 0, 0]}\n");
    put_text(*state, "lacking.yaml", "# a comment\nomega: 42\n");
    put_text(*state, "model.yaml", "omega: 42\n# a comment\nstop: {d: 0.1}\nmodel: tube\n");
    free(told(*state, "continue two-mass --in F=0.4:0.6 --points 1 -o two.h5"));
    free(told(*state, "continue fig7d --set N=2 omega=24 --in omega=20:30 --points 1 -o pipe.h5"));
    free(told(*state, "sweep impact-oscillator --over omega=0.9:1.1:2 --what impacts --quiet -o sweep.h5"));
    return 0;
}

/* Whether a message begins with the first of the words between bars, and has the others in order. */
static bool says(const char *sentence, const char *words) {
    const char *at = sentence;
    for (const char *word = words; word; word = strchr(word, '|') ? strchr(word, '|') + 1 : NULL) {
        char part[200];
        snprintf(part, sizeof part, "%.*s", (int)strcspn(word, "|"), word);
        const char *found = strstr(at, part);
        if (!found || (word == words && found != sentence))
            return false;
        at = found + strlen(part);
    }
    return true;
}

/* Check nothing on stdout, one message on stderr, no file `never`. */
static void check_refused(fixture *f, const char *line, int status, const char *words) {
    int got = run(f, line);
    char *out = said(f, "out"), *err = said(f, "err"), *end = strchr(err, '\n');
    if (got != status || out[0] || strncmp(err, "saltus: ", 8) != 0 || !end || end[1] ||
        !says(err + 8, words))
        fail_msg("%s: exit status %d, stdout '%s', stderr '%s' instead of '%s'", line, got, out, err, words);
    static const char *const endings[] = {"never", "never.h5", "never.csv", "never.png"};
    for (size_t k = 0; k < sizeof endings / sizeof endings[0]; k++)
        assert_int_equal(access(path_in(f, endings[k]), F_OK), -1);
    free(out);
    free(err);
}

/* Each sentence of the commands. */
static void sentences_name_what_is_wrong(void **state) {
    static const struct {
        const char *line;
        int status;
        const char *words;
    } cases[] = {
        {"unheard-of x", 2, "unheard-of: unknown command"},
        {"classify --json", 2, "classify: needs a scene"},
        {"classify pipe two-mass", 2, "two-mass: |already pipe"},
        {"export a.h5 b.h5 -o never.csv", 2, "b.h5: |the file is already a.h5"},
        {"lyapunov pipe --unheard-of 3", 2, "--unheard-of: |saltus lyapunov; |saltus lyapunov --help"},
        {"classify pipe --longest", 2, "--longest: needs a value (p)"},
        {"classify pipe --set", 2, "--set: must be "},
        {"classify pipe --set omega", 2, "--set omega: must be "},
        {"classify pipe --set --json", 2, "--set --json: must be "},
        {"classify pipe --longest 2000", 2, "--longest 2000: must be a whole number from 1 to 1024"},
        {"classify pipe --rtol 0.5", 2, "--rtol 0.5: must be a number from 1e-15 to 0.001"},
        {"classify pipe --atol -2", 2, "--atol -2: must be a number from 0 to 1"},
        {"classify pipe --set r=1.25 --rtol 1e-9", 2, "--set r=1.25: r = 1.25: "},
        {"classify pipe --set omega=41 sides=left", 2, "--set sides=left: sides = \"left\": "},
        {"classify pipe --integrator euler", 2, "--integrator euler: |automatic, taylor, radau or mixed"},
        {"sweep pipe --integrator euler --over d=0.01,0.02 -o never.h5", 2, "--integrator euler: "},
        {"orbit pipe --from two.h5:1", 2, "two.h5:1: |model"},
        {"orbit two-mass --from two.h5:1 --integrator euler", 2, "--integrator euler: "},
        {"check start.yaml --set N=4", 2, "--set N=4: N = 4: |6 entries|8"},
        {"orbit two-mass --from two.h5:1 --set q1=0.01", 2, "--set of an initial state |--from"},
        {"check lacking.yaml", 2, "lacking.yaml: model: missing; |pipe, oscillator"},
        {"check model.yaml", 2, "model.yaml:4: model = \"tube\": unknown; |pipe, oscillator"},

        {"diagnose pipe", 2, "diagnose: needs -o "},
        {"simulate pipe --periods 3", 2, "simulate: needs --periods n and -o "},
        {"orbit pipe", 2, "orbit: needs --periods p"},
        {"scenes nosuch", 2, "nosuch: no built-in scene"},

        {"continue pipe -o never.h5", 2, "continue: needs --in "},
        {"continue pipe --in omega=40:44", 2, "continue: needs --in "},
        {"continue pipe --in omega=40:44 --locus PD -o never.h5", 2, "continue: --locus and --and "},
        {"continue pipe --in omega=40:44 --and d=0.02:0.04 -o never.h5", 2, "continue: --locus and --and "},
        {"continue pipe --in omega=40:44 --locus EP --and d=0.02:0.04 -o never.h5", 2,
         "--locus EP: |LP, PD, NS, BP, GR, HB or BE"},
        {"continue pipe --in omega=40:44 --direction left -o never.h5", 2,
         "--direction left: |up, down or both"},
        {"continue pipe --in omega=40:44 --at 41,49,48 -o never.h5", 2, "--at 49: |of --in, 40 to 44"},
        {"continue pipe --in omega=40:44 --at 39 -o never.h5", 2, "--at 39: |of --in, 40 to 44"},
        {"continue pipe --in omega=40:44 --at 41,x,42 -o never.h5", 2, "--at x,42: must be numbers"},
        {"continue pipe --in omega=40:44 --at 41,42x -o never.h5", 2, "--at 42x: must be numbers"},
        {"continue pipe --in omega=40:44 --at 41, -o never.h5", 2, "--at : must be numbers"},
        {"continue twice.yaml --in omega=2.69:2.71 --transient 3 -o never.h5", 2,
         "twice: its motion is no periodic orbit |, but irregular: no stable orbit |; name one by --from"},
        {"continue impact-oscillator --set F=0 --in F=0:1 -o never.h5", 2,
         "F=0:1: with F = 1 the scene is forced"},

        {"lyapunov pipe --all --exponents 3", 2, "--all and --exponents 3: "},
        {"lyapunov pipe --set N=3 --exponents 7", 2, "--exponents 7: the scene has 6"},
        {"spectrum pipe -o never.bmp", 2, "-o never.bmp: the ending "},
        {"spectrum pipe --samples 50", 2, "--samples 50: |multiple of 4"},
        {"spectrum pipe --of q1 --of v1 --of q2 --of v2", 2, "--of q2: only 2 "},
        {"spectrum pipe --set N=3 --of q1 --of v4", 2, "--of v4"},

        {"sweep pipe --over d=0.01:0.02:2", 2, "sweep: needs --over "},
        {"sweep pipe --over d=0.01,0.02 --transient 5 --at-most 6 -o never.h5", 2,
         "--at-most and --transient: "},
        {"sweep pipe --over d=0.01,0.02 --start down -o never.h5", 2, "--start down: |reset, carry or both"},
        {"sweep pipe --over d=0.01,0.02 --what max, -o never.h5", 2, "--what max,: must be "},
        {"sweep pipe --over d=0.01:0.02:2 --over r=0.7:0.8:3 --over xi=0.3:0.4:4 -o never.h5", 2,
         "--over xi=0.3:0.4:4: only two "},
        {"sweep pipe --over d=0.01:0.02:2 --over r=0.7:x:3 -o never.h5", 2, "--over r=0.7:x:3: "},
        {"basins pipe --over q1=0:0.01:2 --over v1=0:1:2", 2, "basins: needs --over "},
        {"basins pipe --over q1=0:0.01:2 -o never.h5", 2, "basins: needs --over "},
        {"basins pipe --over q1=0:1:2 --over v1=0:1:2 --over v2=0:1:2 -o never.h5", 2,
         "basins: needs --over "},
        {"basins pipe --over q1=0:0.01:2 --over d=0.1:1:3 -o never.h5", 2, "--over d=0.1:1:3: "},
        {"basins pipe --over q0=0:1:3 --over q1=0:0.01:2 -o never.h5", 2, "--over q0=0:1:3: "},
        {"basins pipe --over qx=0:1:3 --over q1=0:0.01:2 -o never.h5", 2, "--over qx=0:1:3: "},

        {"export . -o never.csv", 2, ".: is a folder, not a file"},
        {"plot / -o never.png", 2, "/: is a folder, not a file"},
        {"export sweep.h5", 2, "export: needs a file and -o "},
        {"export sweep.h5 --table all -o never.csv", 2,
         "--table all: |rows, turning, impacts, stroboscopic, points, events, samples or strobe"},
        {"export sweep.h5 --table points -o never.csv", 2,
         "--table points: |rows, turning, impacts or stroboscopic"},
        {"export two.h5 --table rows -o never.csv", 2, "two.h5: holds a branch, which has no table rows"},
        {"plot sweep.h5", 2, "plot: needs a file and -o "},
        {"plot sweep.h5 --show speeds -o never.png", 2, "--show speeds: "},
        {"plot sweep.h5 --view all -o never.png", 2, "--view all: must be turning, "},
        {"plot two.h5 --label F=0.5,a -o never.png", 2, "--label F=0.5,a: must have the form "},
        {"plot two.h5 --label F=1,c=2,b --label F=1,c=2, -o never.png", 2, "--label F=1,c=2,: must have "},
        {"plot two.h5 --label F=1,c=nan,a -o never.png", 2, "--label F=1,c=nan,a: must have the form "},
        {"plot two.h5 --label F=,c=1,a -o never.png", 2, "--label F=,c=1,a: must have the form "},
        {"plot sweep.h5 --view impacts --show speed -o never.png", 2, "plot: --view and --over are of "},
        {"plot sweep.h5 --title A --label F=1,c=2,a -o never.png", 2,
         "label a: its place must be in what the figure shows, omega and impacts"},
        {"plot two.h5 --label F=1,c=2,b -o never.png", 2,
         "label b: its place must be in what the figure shows, F and speed"},
        {"plot sweep.h5 two.h5 --view speed -o never.png", 2, "plot: --view and --over are of one sweep"},
        {"plot two.h5 two.h5 -o never.png", 2, "two.h5: is given twice"},
        {"paper --size wide -o never", 2, "--size wide: must be column, two-columns, W or WxH "},
        {"paper --size 10 -o never", 2, "--size 10: a figure of 10 x 0 mm: "},
        {"spectrum pipe --of q1,q2,q3", 2, "--of q3: only 2 can be given"},
        {"spectrum pipe --of velocity,velocity", 2, "--of velocity: is given twice"},
        {"sweep pipe --over omega=1:2:3:lin -o never.h5", 2,
         "--over omega=1:2:3:lin: after the count only log"},
        {"sweep pipe --over omega=1:2:3 --what class,class -o never.h5", 2,
         "--what class,class: class is given twice"},

        /* admissible, but too much: reported soon, with the cause */
        {"classify pipe --set omega=1e-300", 1,
         "a forcing period, T = 6.28319e+300, |omega = 1e-300 is too small"},
        {"classify impact-oscillator --set omega=1e-300", 1,
         "a forcing period, |omega = 1e-300 is too small"},
        {"simulate pipe --set omega=1e-300 --periods 1 -o never.h5", 1,
         "a forcing |omega = 1e-300 is too small"},
        {"simulate pipe --set omega=1e-300 --periods 1 --transient 9 -o never.h5", 1,
         "a forcing |omega = 1e-300 is "},
        {"orbit pipe --set omega=1e-300 --periods 1", 1, "a forcing period, |omega = 1e-300 is too small"},
        {"lyapunov pipe --set omega=1e-300", 1, "a forcing period, |omega = 1e-300 is too small"},
        {"classify pipe --set d=-5", 1, "a stop holds the system at q1 = -4.344, |a pre-load of this size "},
        {"classify pipe --set d=-100", 1, "a forcing period, |: d = -100 is too great a pre-load"},
        {"diagnose pipe --set d=-5 -o never.png", 1, "a stop holds the system at q1 = -4.344, "},
        {"spectrum pipe --set d=-5", 1, "a stop holds the system at q1 = -4.344, "},
        {"lyapunov pipe --set d=-5", 1, "a stop holds the system at q1 = -4.344, "},
        {"orbit pipe --set d=-5 --periods 1", 1, "a stop holds the system at q1 = -4.344, "},
        {"orbit pipe --set d=-5 --unstable", 1, "a stop holds the system at q1 = |a pre-load of this size "},
        {"continue pipe --set d=-5 --in omega=41:43 -o never.h5", 1,
         "a stop holds the system at q1 = -4.344"},
        {"classify relief-valve --set q=1e10", 1, "a unit of time, |: q = 1e+10 is too great"},
        {"classify chain --set c=1e9", 1, "a forcing period, |: c = 1e+09 is too great"},
        {"classify impact-oscillator --set c=1e9", 1, "a forcing period, |: c = 1e+09 is too great"},
        {"lyapunov relief-valve --set q=1e10", 1, "a unit of time, |: q = 1e+10 is too great"},
        {"orbit relief-valve --set q=1e10 --periods 1", 1, "a unit of time, |: q = 1e+10 is too great"},
        {"classify pipe --set d=-1e6", 1, "the step falls to 0 "},

        {"orbit fig7c --unstable --json --search 10 --periods 1 --transient 0", 0,
         "orbit: no periodic orbit of a period up to 1 T was found in 10 periods"},

        {"paper pipe", 2, "pipe: unexpected; paper "},
        {"paper --figure 1", 2, "--figure 1: must be from 2 to 8"},
        {"paper --figure 22", 2, "--figure 22: must be from 2 to 8"},
        {"paper --format bmp", 2, "--format bmp: must be png, pdf or svg"},
        {"paper --figure 3 -o sweep.h5/never", 2, "paper: -o sweep.h5/never: no folder |: Not a directory"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        check_refused(*state, cases[k].line, cases[k].status, cases[k].words);
}

/* key=low:high, in all commands: complete, with finite numbers in order. */
static void ranges_have_one_form(void **state) {
    static const char *const commands[][2] = {
        {"continue two-mass -o never.h5", "--in"},
        {"continue two-mass --in F=0.4:0.6 --locus PD -o never.h5", "--and"},
        {"plot two.h5 -o never.png", "--range"},
    };
    static const char *const texts[] = {"F",
                                        "F=",
                                        "F=:",
                                        "F=1",
                                        "F=1:",
                                        "F=:1",
                                        "=1:2",
                                        "F=1:2x",
                                        "F=1x:2",
                                        "F=2:1",
                                        "F=1:1",
                                        "F=0:nan",
                                        "F=0:inf",
                                        "F=1=:2",
                                        "F==1:2",
                                        "F=pi:",
                                        "F=1:F",
                                        "F=1:1/0",
                                        "a-key-of-more-than-thirty-characters=1:2"};
    char line[300], words[120];
    for (size_t c = 0; c < sizeof commands / sizeof commands[0]; c++)
        for (size_t k = c; k < sizeof texts / sizeof texts[0]; k += c ? 6 : 1) {
            snprintf(line, sizeof line, "%s %s %s", commands[c][0], commands[c][1], texts[k]);
            snprintf(words, sizeof words, "%s %s: must have the form key=low:high", commands[c][1], texts[k]);
            check_refused(*state, line, 2, words);
        }
}

/* An interrupted run can be resumed only by its own command line: another scene, key, range or locus, or a
 * setting that the run does not have, is another run, and the message names the original. */
static void another_run_is_not_gone_on_with(void **state) {
    static const char *const two[] = {"m=1.5",         "tz=2",          "omega=2",    "d=0.5",     "r=0.9",
                                      "weight=0.5,-1", "weight=1,-0.5", "sides=both", "sides=none"};
    static const char *const pipe[] = {"alpha=0.01", "omega=25", "xi=0.25", "sides=lower"};
    static const char *const same_two[] = {"F=0.5", "weight=1,-1", "d=0.3 r=0.8", "sides=upper", "N=2"};
    static const struct {
        const char *line, *own;
        const char *const *other;
        size_t count;
    } runs[] = {
        {"continue two-mass --in F=0.4:0.6 --points 1 -o two.h5 --resume",
         "two.h5 holds another run (of two-mass in F from 0.4 to 0.6)", two, sizeof two / sizeof two[0]},
        {"continue fig7d --in omega=20:30 --points 1 -o pipe.h5 --resume",
         "pipe.h5 holds another run (of fig7d in omega from 20 to 30)", pipe, sizeof pipe / sizeof pipe[0]}};
    static const char *const lines[] = {"continue impact-oscillator --in F=0.4:0.6",
                                        "continue pipe --in F=0.4:0.6",
                                        "continue two-mass --in omega=0.4:0.6",
                                        "continue two-mass --in F=0.3:0.6",
                                        "continue two-mass --in F=0.4:0.7",
                                        "continue two-mass --in F=0.4:0.6 --locus PD --and c=0.05:0.2"};
    char line[300], words[200];
    for (int m = 0; m < 2; m++) {
        snprintf(words, sizeof words, "--resume: %s", runs[m].own);
        for (size_t k = 0; k < runs[m].count; k++) {
            snprintf(line, sizeof line, "%s --set %s", runs[m].line, runs[m].other[k]);
            check_refused(*state, line, 2, words);
        }
    }
    snprintf(words, sizeof words, "--resume: %s", runs[0].own);
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        snprintf(line, sizeof line, "%s --resume -o two.h5", lines[k]);
        check_refused(*state, line, 2, words);
    }
    /* Unchanged settings may be repeated. */
    for (size_t k = 0; k < sizeof same_two / sizeof same_two[0]; k++) {
        snprintf(line, sizeof line, "%s --set %s --quiet", runs[0].line, same_two[k]);
        free(told(*state, line));
    }
}

/* Saved numbers are checked before use: one out of bounds, fewer numbers, fewer points than stated; the file
 * stays as it is. */
static void what_a_run_goes_on_from_is_checked(void **state) {
    static const char line[] = "continue impact-oscillator --in omega=0.99:1.01 --resume -o b.h5";
    static const char damaged[] =
        "--resume: b.h5: what the run goes on from is damaged or belongs to another run";
    fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_scene scene;
    saltus_branch_file file;
    saltus_branch *branch;
    const saltus_branch_point *point;
    double *numbers;
    int count, parameters;
    char path[sizeof f->path];
    snprintf(path, sizeof path, "%s", path_in(f, "b.h5"));
    check_ok(saltus_scene_load("impact-oscillator", &scene, &message), &message);
    free(told(f, "continue impact-oscillator --in omega=0.99:1.01 -o b.h5"));
    check_ok(saltus_branch_file_read(path, &file, &message), &message);
    assert_true(file.complete && file.resume_count == 0);
    saltus_model_parameters(file.spec.model, &parameters);
    check_ok(saltus_branch_new(&file.spec, file.periods, file.state, &file.options, &branch, &message),
             &message);
    for (int k = 0; k < 5; k++)
        check_ok(saltus_branch_step(branch, &point, &message), &message);
    check_ok(saltus_branch_save(branch, &numbers, &count, &message), &message);
    saltus_branch_free(branch);
    for (int k = 0; k < 8; k++) {
        /* Change the version, a parameter, the number of points, whether there is a locus, the number of the
         * next branch; then fewer numbers, fewer points, and finally nothing. */
        const int places[] = {0, 16, 14 + parameters, 15 + parameters, 17 + parameters};
        saltus_branch_output *output;
        int points = k == 6 ? 4 : 5, given = k == 5 ? count - 1 : count;
        double *copy = calloc((size_t)count, sizeof *copy);
        assert_non_null(copy);
        memcpy(copy, numbers, (size_t)count * sizeof *copy);
        if (k < 5)
            copy[places[k]] = k == 1 ? 0.5 * copy[places[k]] + 1 : NAN;
        check_ok(saltus_branch_output_open(path, &scene, file.periods, file.state, &file.options, NULL,
                                           &output, &message),
                 &message);
        for (int i = 0; i < points; i++)
            check_ok(saltus_branch_output_add(output, &file.points[i], &message), &message);
        saltus_branch_output_resume(output, copy, given);
        check_ok(saltus_branch_output_close(output, false, &message), &message);
        if (k < 7)
            check_refused(f, line, 2,
                          k < 6 ? damaged : "--resume: b.h5: it has 4 points and goes on after the 5th");
        else
            free(told(f, line));
    }
    free(numbers);
    saltus_branch_file_clear(&file);
    remove(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sentences_name_what_is_wrong),
        cmocka_unit_test(ranges_have_one_form),
        cmocka_unit_test(another_run_is_not_gone_on_with),
        cmocka_unit_test(what_a_run_goes_on_from_is_checked),
    };
    return cmocka_run_group_tests(tests, prepare, close_fixture);
}
