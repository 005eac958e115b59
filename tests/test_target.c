/* What a command may write to: no existing file is lost silently.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

#include <sys/stat.h>

static void put_text(fixture *f, const char *name, const char *text) {
    FILE *file = fopen(path_in(f, name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* A copy of a file with a byte in its middle changed, or without its last half. */
static void spoil(fixture *f, const char *name, const char *copy, bool cut) {
    size_t length;
    char *bytes = read_all(path_in(f, name), &length);
    FILE *file = fopen(path_in(f, copy), "wb");
    assert_non_null(file);
    bytes[length / 2] ^= 0x55;
    assert_int_equal(fwrite(bytes, 1, cut ? length / 2 : length, file), cut ? length / 2 : length);
    fclose(file);
    free(bytes);
}

/* Finished results of each kind, and an interrupted one of each. */
static int prepare(void **state) {
    open_fixture(state);
    put_text(*state, "scene.yaml", "model: oscillator\nc: 0.1\nF: 0.5\nomega: 1\nstop: {d: 1, r: 0.8}\n");
    free(told(*state, "continue impact-oscillator --in omega=0.99:1.01 --points 2 -o branch.h5"));
    free(told(*state, "sweep impact-oscillator --over omega=0.9:1.1:2 --quiet -o sweep.h5"));
    free(told(*state, "simulate impact-oscillator --periods 1 -o run.h5"));
    free(told(*state, "export sweep.h5 -o table.csv"));
    free(told(*state, "export run.h5 -o samples.csv"));
    free(told(*state, "export run.h5 --table events -o events.csv"));
    free(told(*state, "export sweep.h5 --table impacts -o impacts.csv"));
    free(told(*state, "continue impact-oscillator --in omega=0.9:1.1 --direction down --locus PD --and "
                      "d=0.9:1.1 -o locus.h5"));
    free(told(*state, "spectrum impact-oscillator --quiet -o lines.csv"));
    spoil(*state, "sweep.h5", "halved.h5", true);
    spoil(*state, "branch.h5", "worn.h5", false);
    put_text(*state, "notes.csv", "a,b\n1,2\n");
    put_text(*state, "notes.h5", "not HDF5\n");
    put_text(*state, "notes.svg", "no picture\n");
    put_text(*state, "data.gp", "plot sin(x)\n");
    put_text(*state, "empty.csv", "");
    put_text(*state, "cut.csv", "# Saltus 0.1.0 trajectory\n# scene: x\n# complete: 0\ntime_over_T\n0\n");
    put_text(*state, "left.csv.journal", "what an interrupted run has left\n");
    char line[512];
    assert_int_equal(
        link(path_in(*state, "sweep.h5"), strcat(strcpy(line, ((fixture *)*state)->folder), "/other.csv")),
        0);
    assert_int_equal(symlink("branch.h5", path_in(*state, "link.h5")), 0);
    assert_int_equal(mkdir(path_in(*state, "folder"), 0777), 0);
    assert_int_equal(mkdir(path_in(*state, "folder.csv"), 0777), 0);
    return 0;
}

static int clear_up(void **state) {
    rmdir(path_in(*state, "folder"));
    rmdir(path_in(*state, "folder.csv"));
    return close_fixture(state);
}

/* Check the exit status, nothing on stdout, and one message on stderr with this begin and this part. */
static void check_refused(fixture *f, const char *line, int status, const char *begin, const char *part) {
    int got = run(f, line);
    char *out = said(f, "out"), *err = said(f, "err"), *end = strchr(err, '\n');
    if (got != status || out[0] || strncmp(err, "saltus: ", 8) != 0 || !end || end[1] ||
        strncmp(err + 8, begin, strlen(begin)) != 0 || !strstr(err, part))
        fail_msg("%s: exit status %d, stdout '%s', stderr '%s'", line, got, out, err);
    free(out);
    free(err);
}

/* The bytes of the files that must not change, one after the other. */
static char *kept(fixture *f, size_t *length) {
    static const char *const names[] = {"scene.yaml",  "branch.h5", "sweep.h5",    "run.h5",    "table.csv",
                                        "samples.csv", "lines.csv", "notes.csv",   "notes.h5",  "data.gp",
                                        "events.csv",  "locus.h5",  "impacts.csv", "halved.h5", "worn.h5"};
    char *all = NULL;
    *length = 0;
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        size_t size;
        char *one = read_all(path_in(f, names[k]), &size);
        all = realloc(all, *length + size + 1);
        assert_non_null(all);
        memcpy(all + *length, one, size);
        *length += size;
        free(one);
    }
    return all;
}

static void what_is_there_is_kept(void **state) {
    static const char input[] = "is the same file as the input", kind[] = "another kind of file",
                      interrupted[] = "holds an interrupted run";
    static const struct {
        const char *line;
        int status;
        const char *begin, *part;
    } cases[] = {
        /* inputs, under any name */
        {"export sweep.h5 -o other.csv", 2, "-o other.csv: ", input},
        {"continue impact-oscillator --from branch.h5:1 --in omega=0.99:1.01 -o branch.h5", 2,
         "-o branch.h5: ", "the input branch.h5:1"},
        {"continue impact-oscillator --from ./branch.h5:1 --in omega=0.99:1.01 -o link.h5", 2,
         "-o link.h5: ", input},
        {"continue impact-oscillator --force --from branch.h5:1 --in omega=0.99:1.01 -o branch.h5", 2,
         "-o branch.h5: ", input},
        /* endings */
        {"export sweep.h5 -o sweep.h5", 2, "-o sweep.h5: ", "the ending must be .csv"},
        {"export sweep.h5 -o scene.yaml", 2, "-o scene.yaml: ", "the ending must be .csv"},
        {"export sweep.h5 -o .csv", 2, "-o .csv: ", "the ending must be .csv"},
        {"sweep scene.yaml --over d=1,2 -o scene.yaml", 2, "-o scene.yaml: ", "must be .h5 or .csv"},
        {"continue impact-oscillator --in omega=1:2 -o x.csv", 2, "-o x.csv: ", "must be .h5"},
        {"simulate impact-oscillator --periods 1 -o x.png", 2, "-o x.png: ", "must be .h5 or .csv"},
        {"plot sweep.h5 -o x.csv", 2, "-o x.csv: ", "must be .png, .pdf or .svg"},
        {"lyapunov impact-oscillator -o x.h5", 2, "-o x.h5: ", "must be .png, .pdf, .svg or .csv"},
        {"diagnose impact-oscillator -o x.png --data x.csv", 2, "--data x.csv: ", "must be .h5"},
        /* other kinds */
        {"sweep impact-oscillator --over d=1,2 -o branch.h5", 2, "-o branch.h5: ", "(branch, not sweep)"},
        {"continue impact-oscillator --in omega=0.99:1.01 -o sweep.h5", 2,
         "-o sweep.h5: ", "(sweep, not branch)"},
        {"basins impact-oscillator --over q1=0,0.1 --over v1=0,1 -o sweep.h5", 2, "-o sweep.h5: ", kind},
        {"simulate impact-oscillator --periods 1 -o sweep.h5", 2, "-o sweep.h5: ", kind},
        {"simulate impact-oscillator --periods 1 -o notes.h5", 2, "-o notes.h5: ", kind},
        {"export sweep.h5 -o notes.csv", 2, "-o notes.csv: ", kind},
        {"plot sweep.h5 -o notes.svg", 2, "-o notes.svg: ", kind},
        {"diagnose impact-oscillator -o x.png --data sweep.h5", 2, "--data sweep.h5: ", kind},
        {"diagnose impact-oscillator -o x.png --data data.h5", 2, "--data data.gp: ", kind},
        /* tables of another kind, by their first line */
        {"sweep impact-oscillator --over d=1,2 -o samples.csv", 2,
         "-o samples.csv: ", "(trajectory table, not sweep table)"},
        {"basins impact-oscillator --over q1=0,0.1 --over v1=0,1 -o table.csv", 2,
         "-o table.csv: ", "(sweep table, not basins table)"},
        {"simulate impact-oscillator --periods 1 -o table.csv", 2, "-o table.csv: ", kind},
        {"simulate impact-oscillator --periods 1 -o lines.csv", 2, "-o lines.csv: ", kind},
        {"spectrum impact-oscillator -o table.csv", 2, "-o table.csv: ", kind},
        {"lyapunov impact-oscillator -o lines.csv", 2,
         "-o lines.csv: ", "(spectrum table, not largest Lyapunov exponent table)"},
        {"export sweep.h5 -o samples.csv", 2, "-o samples.csv: ", "(trajectory table, not sweep table)"},
        {"export run.h5 -o table.csv", 2, "-o table.csv: ", kind},
        {"export sweep.h5 --table impacts -o table.csv", 2,
         "-o table.csv: ", "(sweep table, not sweep impacts table)"},
        {"export sweep.h5 --table turning -o impacts.csv", 2, "-o impacts.csv: ", kind},
        {"export run.h5 --table events -o samples.csv", 2,
         "-o samples.csv: ", "(trajectory table, not trajectory events table)"},
        {"export run.h5 --table strobe -o events.csv", 2, "-o events.csv: ", kind},
        {"export branch.h5 --table events -o events.csv", 2, "-o events.csv: ", kind},
        {"continue impact-oscillator --in omega=0.99:1.01 -o locus.h5", 2,
         "-o locus.h5: ", "(locus, not branch)"},
        {"continue impact-oscillator --in omega=0.9:1.1 --locus PD --and d=0.9:1.1 -o branch.h5", 2,
         "-o branch.h5: ", "(branch, not locus)"},
        {"export sweep.h5 --table stroboscopic -o table.csv", 2,
         "-o table.csv: ", "(sweep table, not sweep stroboscopic table)"},
        {"export sweep.h5 --table stroboscopic -o -", 2,
         "sweep.h5: ", "did not keep stroboscopic, only rows, turning, impacts"},
        {"export nothere.h5 -o table.csv", 2, "nothere.h5: ", "cannot be opened"},
        /* damaged files */
        {"sweep impact-oscillator --over d=1,2 -o halved.h5", 2,
         "-o halved.h5: is there, an HDF5 file that is ",
         "damaged or cut off; another name, or --force to replace it"},
        {"sweep impact-oscillator --over d=1,2 -o worn.h5", 2, "-o worn.h5: is there, an HDF5 file that is ",
         "damaged"},
        {"continue impact-oscillator --in omega=1:2 -o worn.h5", 2, "-o worn.h5: is there, ", "damaged"},
        {"simulate impact-oscillator --periods 1 -o halved.h5", 2, "-o halved.h5: is there, ", "damaged"},
        {"diagnose impact-oscillator -o x.png --data worn.h5", 2, "--data worn.h5: is there, ", "damaged"},
        /* what was interrupted */
        {"sweep impact-oscillator --over d=1,2 --what max -o left.csv", 2, "-o left.csv: ", interrupted},
        {"export sweep.h5 -o left.csv", 2, "-o left.csv: ", interrupted},
        {"simulate impact-oscillator --periods 1 -o cut.csv", 2,
         "-o cut.csv: ", "holds an interrupted run; --force begins anew"},
        {"sweep impact-oscillator --over d=1,2 -o x.h5 --resume --force", 2, "--resume and --force: ", ""},
        /* places */
        {"sweep impact-oscillator --over d=1,2 -o nowhere/x.h5", 2,
         "-o nowhere/x.h5: ", "the folder nowhere cannot be used: No such file"},
        {"export sweep.h5 -o sweep.h5/x.csv", 2, "-o sweep.h5/x.csv: ", "sweep.h5 is no folder"},
        {"export sweep.h5 -o folder.csv", 2, "-o folder.csv: ", "is a folder"},
        /* the scene does not exist, but the target is checked first */
        {"diagnose nothere -o nowhere/x.png", 2, "-o nowhere/x.png: ", "the folder nowhere"},
        {"lyapunov nothere -o nowhere/x.png", 2, "-o nowhere/x.png: ", "the folder nowhere"},
        {"spectrum nothere -o nowhere/x.png", 2, "-o nowhere/x.png: ", "the folder nowhere"},
        {"simulate nothere --periods 1 -o nowhere/x.h5", 2, "-o nowhere/x.h5: ", "the folder nowhere"},
        {"continue nothere --in d=1:2 -o nowhere/x.h5", 2, "-o nowhere/x.h5: ", "the folder nowhere"},
        {"basins nothere --over q1=0,1 --over v1=0,1 -o nowhere/x.h5", 2,
         "-o nowhere/x.h5: ", "the folder nowhere"},
        {"plot sweep.h5 -o nowhere/x.png", 2, "-o nowhere/x.png: ", "the folder nowhere"},
        {"plot sweep.h5 -o x.png --keep-script nowhere/x.gp", 2,
         "--keep-script nowhere/x.gp: ", "the folder nowhere"},
        {"diagnose nothere -o x.png --data nowhere/x.h5", 2, "--data nowhere/x.h5: ", "the folder nowhere"},
        /* standard output */
        {"continue impact-oscillator --in omega=1:2 -o -", 2, "-o -: HDF5 cannot ", "standard output"},
        {"simulate impact-oscillator --periods 1 -o - --format h5", 2, "-o -: HDF5 cannot ", ""},
        {"plot sweep.h5 -o - --format csv", 2, "--format csv: ", ".png, .pdf or .svg"},
        {"plot sweep.h5 -o x.png --format png", 2, "--format png: ", "-o -"},
        {"spectrum impact-oscillator --json -o -", 2, "-o -: --json ", ""},
        {"sweep impact-oscillator --over d=1,2 --resume -o -", 2, "-o -: --resume ", ""},
    };
    size_t before, after;
    char *first = kept(*state, &before);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        check_refused(*state, cases[k].line, cases[k].status, cases[k].begin, cases[k].part);
    char *second = kept(*state, &after);
    assert_int_equal(before, after);
    assert_memory_equal(first, second, before);
    free(first);
    free(second);
    assert_int_equal(access(path_in(*state, "x.png"), F_OK), -1);
}

/* The figures of the paper are refused before the first is made, with the folder named. */
static void all_figures_are_checked_first(void **state) {
    fixture *f = *state;
    put_text(f, "folder/fig4b.png", "no picture\n");
    check_refused(f, "paper --quick --figure 4 -o folder", 2,
                  "-o folder/fig4b.png: ", "another kind of file");
    remove(path_in(f, "folder/fig4b.png"));
    assert_int_equal(folder_files(path_in(f, "folder"), false), 0);
    check_refused(f, "paper --quick -o -", 2, "-o -: ", "name a folder");
    check_refused(f, "paper --quick -o notes.csv", 2, "paper: -o notes.csv: ", "Not a directory");
    assert_int_equal(access(path_in(f, "-"), F_OK), -1);
}

/* A folder without write permission is named; the superuser has none. */
static void a_locked_folder_is_named(void **state) {
    if (geteuid() == 0)
        skip();
    chmod(path_in(*state, "folder"), 0555);
    check_refused(*state, "export sweep.h5 -o folder/x.csv", 2, "-o folder/x.csv: in the folder folder ",
                  "Permission denied");
    check_refused(*state, "paper -o folder", 2,
                  "paper: -o folder: nothing can be written there: ", "Permission denied");
    check_refused(*state, "paper -o folder/x", 2,
                  "paper: -o folder/x: no folder can be made there: ", "Permission denied");
    chmod(path_in(*state, "folder"), 0777);
}

/* A file of the same kind is replaced, with --force any other; an empty file is nothing to lose. */
static void the_same_kind_is_replaced(void **state) {
    static const char *const lines[] = {
        "sweep impact-oscillator --over omega=0.9:1.1:3 --quiet -o again.h5",
        "sweep impact-oscillator --over omega=0.9:1.1:3 --quiet -o again.h5",
        "continue impact-oscillator --in omega=0.99:1.01 --points 2 --force -o again.h5",
        "continue impact-oscillator --in omega=0.99:1.01 --points 2 -o again.h5",
        "simulate impact-oscillator --periods 1 -o again.h5 --force",
        "export sweep.h5 -o empty.csv",
        "export sweep.h5 -o empty.csv",
        "simulate impact-oscillator --periods 1 -o empty.csv --force",
        "simulate impact-oscillator --periods 1 -o empty.csv",
        "export run.h5 -o empty.csv",
        "export run.h5 --table events -o empty.csv --force",
        "export run.h5 --table events -o empty.csv",
        "continue impact-oscillator --in omega=.9:1.1 --direction down --locus PD --and d=.9:1 -o locus.h5",
        "lyapunov impact-oscillator -o empty.csv --force",
        "lyapunov impact-oscillator -o empty.csv",
        "diagnose impact-oscillator -o x.svg --data again.h5 --quiet --force",
        "diagnose impact-oscillator -o x.svg --data again.h5 --quiet",
        "sweep impact-oscillator --over d=1,2 --what max --quiet -o left.csv --force",
        "sweep impact-oscillator --over d=1,2 --what max --quiet -o left.csv"};
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++)
        free(told(*state, lines[k]));
}

/* The file of an interrupted run is neither resumed nor replaced unless an option says so. */
static void an_interrupted_run_is_not_begun_anew_by_accident(void **state) {
    fixture *f = *state;
    static const char *const lines[][2] = {
        {"continue impact-oscillator --in omega=0.5:1.5 --step-max 1e-6 --points 10000000 -o", "cut.h5"},
        {"sweep impact-oscillator --over omega=0.5:1.5:100000 --quiet -o", "cut2.h5"}};
    for (int k = 0; k < 2; k++) {
        char text[1024], line[256], begin[64];
        snprintf(
            text, sizeof text,
            "cd %s && { %s %s %s >out 2>err & child=$!; while kill -0 $child 2>/dev/null && [ ! -e %s ]; "
            "do sleep 0.01; done; kill -TERM $child; wait $child; }",
            f->folder, SALTUS_COMMAND, lines[k][0], lines[k][1], lines[k][1]);
        assert_int_equal(WEXITSTATUS(system(text)), 1);
        size_t before, after;
        char *first = read_all(path_in(f, lines[k][1]), &before);
        snprintf(line, sizeof line, "%s %s", lines[k][0], lines[k][1]);
        snprintf(begin, sizeof begin, "-o %s: holds an interrupted run; ", lines[k][1]);
        check_refused(f, line, 2, begin, "--resume goes on with it, --force begins anew");
        char *second = read_all(path_in(f, lines[k][1]), &after);
        assert_int_equal(before, after);
        assert_memory_equal(first, second, before);
        free(first);
        free(second);
    }
    free(told(f, "continue impact-oscillator --in omega=0.99:1.01 --points 2 --force -o cut.h5"));
    free(told(f, "continue impact-oscillator --in omega=0.99:1.01 --points 2 -o cut.h5"));
}

/* Standard output gets exactly the bytes of a file. */
static void standard_output_is_a_file_like_others(void **state) {
    static const struct {
        const char *line, *more, *file;
    } cases[] = {{"simulate impact-oscillator --periods 2", "", "c1.csv"},
                 {"export sweep.h5", "", "c2.csv"},
                 {"spectrum impact-oscillator --samples 64", "--format csv", "c3.csv"},
                 {"lyapunov impact-oscillator --transient 20 --periods 1800", "--format csv", "c4.csv"},
                 {"sweep impact-oscillator --over d=1,2 --what max --quiet", "", "c5.csv"},
                 {"plot sweep.h5", "--format svg", "c6.svg"},
                 {"plot sweep.h5", "", "c7.png"}};
    fixture *f = *state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char line[256];
        snprintf(line, sizeof line, "%s -o %s", cases[k].line, cases[k].file);
        assert_int_equal(run(f, line), 0);
        snprintf(line, sizeof line, "%s -o - %s", cases[k].line, cases[k].more);
        if (run(f, line) != 0)
            fail_msg("%s: %s", line, said(f, "err"));
        size_t wanted, got;
        char *file = read_all(path_in(f, cases[k].file), &wanted), *out = read_all(path_in(f, "out"), &got);
        assert_int_equal(wanted, got);
        assert_memory_equal(file, out, got);
        free(file);
        free(out);
    }
}

/* With standard output full or closed by its reader, this is told as what it is, and no folder stays behind.
 */
static void standard_output_that_cannot_be_written(void **state) {
    static const char *const lines[] = {"export run.h5 -o -", "plot sweep.h5 -o -",
                                        "simulate impact-oscillator --periods 1 -o -"};
    fixture *f = *state;
    char text[512];
    assert_int_equal(mkdir(path_in(f, "temporary"), 0777), 0);
    setenv("TMPDIR", f->path, 1);
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        if (access("/dev/full", W_OK) == 0) {
            snprintf(text, sizeof text, "cd %s && %s %s >/dev/full 2>err", f->folder, SALTUS_COMMAND,
                     lines[k]);
            assert_int_equal(WEXITSTATUS(system(text)), 1);
            char *err = said(f, "err");
            assert_string_equal(err,
                                "saltus: standard output could not be written: No space left on device\n");
            free(err);
        }
        snprintf(text, sizeof text, "cd %s && { sleep 0.01; %s %s 2>err; } | true", f->folder, SALTUS_COMMAND,
                 lines[k]);
        assert_int_equal(system(text), 0);
        char *err = said(f, "err");
        assert_string_equal(err, "");
        free(err);
        assert_int_equal(folder_files(path_in(f, "temporary"), false), 0);
    }
    unsetenv("TMPDIR");
    rmdir(path_in(f, "temporary"));
}

/* A scene from standard input is the same as from its file; that file is an input like any other. */
static void a_scene_comes_from_standard_input(void **state) {
    fixture *f = *state;
    char *wanted = told(f, "orbit scene.yaml --periods 1 --json"), *got;
    assert_int_equal(run(f, "orbit - --periods 1 --json <scene.yaml"), 0);
    got = said(f, "out");
    const char *a = strstr(wanted, "\"label\""), *b = strstr(got, "\"label\"");
    assert_non_null(a);
    assert_non_null(b);
    assert_string_equal(a, b); /* what comes before is the scene's name */
    assert_non_null(strstr(got, "\"scene\": \"stdin\""));
    free(wanted);
    free(got);
    put_text(f, "scene.csv", "model: oscillator\nomega: 1\nstop: {d: 1}\n");
    check_refused(f, "simulate - --periods 1 -o scene.csv <scene.csv", 2,
                  "-o scene.csv: ", "same file as the input -");
    check_refused(f, "check - <notes.csv", 2, "stdin:", "");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_there_is_kept),
        cmocka_unit_test(all_figures_are_checked_first),
        cmocka_unit_test(a_locked_folder_is_named),
        cmocka_unit_test(the_same_kind_is_replaced),
        cmocka_unit_test(an_interrupted_run_is_not_begun_anew_by_accident),
        cmocka_unit_test(standard_output_that_cannot_be_written),
        cmocka_unit_test(a_scene_comes_from_standard_input),
        cmocka_unit_test(standard_output_is_a_file_like_others),
    };
    return cmocka_run_group_tests(tests, prepare, clear_up);
}
