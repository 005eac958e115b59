/* Stop signals: whenever one arrives, a command ends as interrupted with a message, or it has completed its
 * work; files are whole. A signal pending at the program's start arrives before any work; one sent by a
 * made-up gnuplot arrives while the program waits for a figure; the growing journal shows when a sweep is
 * near its end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _GNU_SOURCE
#include "folder.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { words_max = 32, patience_ms = 20000, slow_points = 1000 };

/* A working folder, with one for the made-up gnuplot and one for nameless files. */
typedef struct fixture {
    char folder[64], tools[80], nameless[80], paper[80], path[4200];
    struct fixture *late; /* the child that is signalled twice, seconds apart; it runs beside the others */
    pid_t late_child;
    struct fixture *slow; /* the sweep that is stopped for seconds meanwhile */
    pid_t slow_child;
    double begun, held_since; /* slow_child */
} fixture;

static const char *path_in(const fixture *f, const char *name, char path[320]) {
    snprintf(path, 320, "%s/%s", f->folder, name);
    return path;
}

static fixture *make_fixture(void) {
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    setenv("SOURCE_DATE_EPOCH", "0", 1);
    snprintf(f->tools, sizeof f->tools, "%s/tools", f->folder);
    snprintf(f->nameless, sizeof f->nameless, "%s/nameless", f->folder);
    snprintf(f->paper, sizeof f->paper, "%s/paper", f->folder);
    mkdir(f->tools, 0777);
    mkdir(f->nameless, 0777);
    mkdir(f->paper, 0777);
    snprintf(f->path, sizeof f->path, "%s:%s", f->tools, getenv("PATH"));
    return f;
}

static int open_fixture(void **state) {
    fixture *f = make_fixture();
    f->late = make_fixture();
    f->slow = make_fixture();
    *state = f;
    return 0;
}

static void empty(const fixture *f) {
    folder_files(f->tools, true);
    folder_files(f->nameless, true);
    folder_files(f->paper, true);
    rmdir(f->paper);
    rmdir(f->tools);
    rmdir(f->nameless);
    folder_files(f->folder, true);
}

static void remove_fixture(fixture *f) {
    empty(f);
    rmdir(f->folder);
    free(f);
}

static void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* A gnuplot that performs an action and then leaves a fake picture. */
static void make_gnuplot(const fixture *f, const char *does) {
    char path[128], text[512];
    snprintf(path, sizeof path, "%s/gnuplot", f->tools);
    snprintf(text, sizeof text, "#!/bin/sh\n%s\nprintf %%080d 0\nprintf 'IEND....'\n", does);
    write_text(path, text);
    chmod(path, 0755);
}

/* The initial signal state of a child. */
typedef enum beginning { plainly, pending, ignoring } beginning;

/* Start a command (words separated by blanks) in the folder, with its output in `out` and `err`. */
static pid_t start(const fixture *f, const char *line, beginning how, int number) {
    char copy[512], command[] = SALTUS_COMMAND, *words[words_max + 1] = {command}, *rest = copy;
    int count = 1;
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok_r(rest, " ", &rest); word && count < words_max;
         word = strtok_r(NULL, " ", &rest))
        words[count++] = word;
    /* Before the child exists, so that the signal is ignored from the start. */
    if (how == ignoring)
        signal(number, SIG_IGN);
    pid_t child = fork();
    if (child != 0) {
        signal(number, SIG_DFL);
        assert_true(child > 0);
        return child;
    }
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, number);
    bool ready = chdir(f->folder) == 0 && freopen("out", "w", stdout) && freopen("err", "w", stderr);
    setenv("PATH", f->path, 1);
    setenv("TMPDIR", f->nameless, 1);
    if (how == pending) {
        sigprocmask(SIG_BLOCK, &set, NULL);
        raise(number);
    }
    if (ready)
        execv(command, words);
    _exit(99);
}

static void pause_ms(double ms) {
    struct timespec time = {(time_t)(ms / 1000), (long)(1e6 * fmod(ms, 1000))};
    nanosleep(&time, NULL);
}

/* The wait status of a child; one that does not end fails the test. */
static int end_of(pid_t child) {
    int outcome = 0;
    for (int waited = 0; waitpid(child, &outcome, WNOHANG) == 0; waited++) {
        if (waited > patience_ms) {
            kill(child, SIGKILL);
            fail_msg("a command does not end");
        }
        pause_ms(1);
    }
    return outcome;
}

/* Whether a process catches a signal; false if unknown. */
static bool catches(pid_t process, int number) {
    char path[64], line[256];
    unsigned long long caught = 0;
    snprintf(path, sizeof path, "/proc/%d/status", (int)process);
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file))
        sscanf(line, "SigCgt: %llx", &caught);
    if (file)
        fclose(file);
    return caught >> (number - 1) & 1;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    if (f->late_child)
        end_of(f->late_child);
    if (f->slow_child) {
        kill(f->slow_child, SIGKILL);
        end_of(f->slow_child);
    }
    remove_fixture(f->late);
    remove_fixture(f->slow);
    remove_fixture(f);
    return 0;
}

static long long size_of(const char *path) {
    struct stat facts;
    return stat(path, &facts) == 0 ? (long long)facts.st_size : -1;
}

static double clock_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Start the sweep that is stopped when part of it is done: a row takes more than forty bytes of the
 * journal. */
static void begin_slow(fixture *f) {
    char journal[320], line[160];
    if (f->slow_child)
        return;
    path_in(f->slow, "slow.h5.journal", journal);
    snprintf(
        line, sizeof line,
        "sweep impact-oscillator --over omega=0.9:1.1:%d --transient 60 --record 10 --what max --threads 1 "
        "-o slow.h5",
        slow_points);
    f->begun = clock_now();
    f->slow_child = start(f->slow, line, plainly, SIGTERM);
    for (int k = 0; k < 10 * patience_ms && size_of(journal) < 40 * slow_points; k++)
        pause_ms(0.1);
    kill(f->slow_child, SIGSTOP);
    f->held_since = clock_now();
}

/* Start the child whose figure takes seconds, with a signal before and one after them. */
static void begin_late(fixture *f) {
    begin_slow(f);
    if (f->late_child)
        return;
    make_gnuplot(f->late, "kill -TERM $PPID; sleep 0.7; kill -TERM $PPID; sleep 0.2");
    assert_int_equal(end_of(start(f->late, "sweep impact-oscillator --over omega=0.9:1.1:3 --quiet -o s.h5",
                                  plainly, SIGTERM)),
                     0);
    f->late_child = start(f->late, "plot s.h5 -o late.png", plainly, SIGTERM);
}

static char *said(const fixture *f, const char *where) {
    char path[320];
    size_t length;
    return read_all(path_in(f, where, path), &length);
}

/* Check exit status 1, one message about the interruption, and no partial file. */
static void check_interrupted(const fixture *f, int outcome, const char *what) {
    char *text = said(f, "err"), *end = strchr(text, '\n');
    if (!WIFEXITED(outcome) || WEXITSTATUS(outcome) != 1)
        fail_msg("%s: status %#x: %s", what, (unsigned)outcome, text);
    if (strncmp(text, "saltus: interrupted; ", 21) != 0 || !end || end[1])
        fail_msg("%s says: %s", what, text);
    free(text);
    assert_int_equal(folder_files(f->nameless, true), 0);
}

/* The message says whether there is a result yet: some commands print what they have. */
static void check_sentence(const fixture *f, const char *what) {
    char *out = said(f, "out"), *err = said(f, "err");
    bool none = strstr(err, "there is no result yet") != NULL, part = strstr(err, "so far") != NULL;
    bool page = strstr(err, "no figure was drawn") != NULL, figure = strstr(out, "figure: ") != NULL;
    if ((none && out[0]) || (page && (figure || !out[0])) || (none + part + page > 1))
        fail_msg("%s prints '%s' and says '%s'", what, out, err);
    free(out);
    free(err);
}

static bool is_there(const fixture *f, const char *name) {
    char path[320];
    return access(path_in(f, name, path), F_OK) == 0;
}

/* Count the files of a folder whose names contain a part. */
static int named(const char *folder, const char *part) {
    DIR *open = opendir(folder);
    int count = 0;
    for (struct dirent *entry = open ? readdir(open) : NULL; entry; entry = readdir(open))
        count += strstr(entry->d_name, part) != NULL;
    if (open)
        closedir(open);
    return count;
}

/* A signal before any work: every command notices it soon. */
static void a_signal_before_the_work_ends_every_command(void **state) {
    static const char *const lines[] = {
        "classify fig7c --transient 100000000 --measure 0",
        "classify fig7c --measure 1000000000",
        "classify fig7d --json --seeds 100000",
        "diagnose fig7c --measure 1000000000 -o never.png",
        "simulate fig7c --periods 1000000 --samples 1 -o run.csv",
        "simulate fig7c --periods 10 --transient 100000000 -o never.csv",
        "orbit fig7d --periods 4 --transient 100000000",
        "orbit fig7a --unstable --search 100000000",
        "continue fig7d --in omega=38:46 --step-max 0.0003 -o never.h5",
        "lyapunov fig7c --precision 1e-8 --periods 1000000000",
        "lyapunov fig7c --transient 1000000000 --json",
        "lyapunov pipe --set N=40 omega=10",
        "spectrum fig7c --transient 100000000 --periods 1000000 -o never.png",
        "sweep fig6 --over omega=12:54:5000 -o never.h5",
        "sweep fig6 --over omega=12:54:5000 --quiet -o never.csv",
        "basins fig6 --over q1=-0.01:0.01:300 --over v1=-1:1:300 --quiet -o never.h5",
        "paper --quiet -o paper",
        "paper --figure 5 -o paper"};
    static const int signals[] = {SIGTERM, SIGINT, SIGHUP};
    const fixture *f = *state;
    begin_late(*state);
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        int number = signals[k % 3];
        check_interrupted(f, end_of(start(f, lines[k], pending, number)), lines[k]);
        check_sentence(f, lines[k]);
        assert_int_equal(named(f->folder, "never"), 0);
        assert_int_equal(named(f->folder, ".part"), 0);
        assert_int_equal(named(f->paper, ".h5"), 0);
        assert_int_equal(named(f->paper, ".png"), 0);
    }
}

/* What a check has printed before stays. */
static void a_check_of_derivatives_ends_soon(void **state) {
    const fixture *f = *state;
    check_interrupted(f, end_of(start(f, "check duffing --set omega=1e-6 --derivatives", pending, SIGINT)),
                      "check");
}

/* An interrupted measurement reports the transient it has run. */
static void a_transient_that_is_cut_off_is_not_told_as_run(void **state) {
    const fixture *f = *state;
    check_interrupted(f, end_of(start(f, "lyapunov fig7c --transient 1000000000 --json", pending, SIGTERM)),
                      "lyapunov");
    char *text = said(f, "out"), *at = strstr(text, "\"transient\": ");
    assert_non_null(at);
    assert_true(strtod(at + 13, NULL) < 1e6);
    assert_non_null(strstr(at + 13, "\"transient\": 1000000000,"));
    free(text);
}

/* A sweep that is stopped before it begins keeps an earlier file and its journal. */
static void a_signal_before_a_sweep_leaves_what_was_there(void **state) {
    static const char line[] =
        "sweep impact-oscillator --over omega=0.9:1.1:3 --threads 1 --quiet -o kept.h5";
    const fixture *f = *state;
    char path[320];
    size_t before, after;
    assert_int_equal(end_of(start(f, line, plainly, SIGTERM)), 0);
    char *first = read_all(path_in(f, "kept.h5", path), &before);
    check_interrupted(f, end_of(start(f, "sweep fig6 --over omega=12:54:5000 -o kept.h5", pending, SIGTERM)),
                      "sweep");
    char *second = read_all(path, &after);
    assert_int_equal(before, after);
    assert_memory_equal(first, second, before);
    assert_false(is_there(f, "kept.h5.journal"));
    free(first);
    free(second);
}

/* As for a program started by nohup or after the shell's `trap ''`. */
static void ignored_signals_stay_ignored(void **state) {
    static const int signals[] = {SIGTERM, SIGINT, SIGHUP};
    const fixture *f = *state;
    for (int k = 0; k < 3; k++) {
        pid_t child =
            start(f, "lyapunov impact-oscillator --transient 2000 --periods 20000", ignoring, signals[k]);
        pause_ms(8);
        kill(child, signals[k]);
        assert_int_equal(end_of(child), 0);
    }
}

/* A signal sent at once to a process and to its group counts once; the figure is finished. Half a second
 * later the next signal ends the program even while it cannot react. */
static void a_late_second_signal_ends_the_program(void **state) {
    fixture *f = *state;
    begin_late(f);
    assert_int_equal(
        end_of(start(f, "sweep impact-oscillator --over omega=0.9:1.1:3 --quiet -o s.h5", plainly, SIGTERM)),
        0);
    make_gnuplot(f, "kill -TERM $PPID; kill -INT $PPID");
    assert_int_equal(end_of(start(f, "plot s.h5 -o twice.png", plainly, SIGTERM)), 0);
    assert_true(is_there(f, "twice.png"));
    int outcome = end_of(f->late_child);
    f->late_child = 0;
    assert_true(WIFSIGNALED(outcome) && WTERMSIG(outcome) == SIGTERM);
    assert_false(is_there(f->late, "late.png"));
    assert_int_equal(folder_files(f->late->nameless, true), 0);
}

/* Without a terminal a long sweep prints now and then, on a line of its own, how much is done, at what speed,
 * and the time left at that speed. */
static void a_long_sweep_is_told_in_lines(void **state) {
    fixture *f = *state;
    double part, rate, left;
    long long done, all;
    int used = 0;
    begin_slow(f);
    double held = clock_now() - f->held_since;
    if (held < 2.1)
        pause_ms(1000 * (2.1 - held));
    kill(f->slow_child, SIGCONT);
    assert_int_equal(end_of(f->slow_child), 0);
    f->slow_child = 0;
    double passed = clock_now() - f->begun;
    char *text = said(f->slow, "err"), unit[8] = "";
    long long before = 0;
    for (const char *line = text; *line; line += used) {
        used = 0;
        int read = sscanf(line, "saltus: %lf %% (%lld of %lld points), %lf points/s, %lf %7s left\n%n", &part,
                          &done, &all, &rate, &left, unit, &used);
        /* Hours are left where the other tests took minutes, all of which the sweep was held. */
        const double seconds = strcmp(unit, "s") == 0     ? 1
                               : strcmp(unit, "min") == 0 ? 60
                               : strcmp(unit, "h") == 0   ? 3600
                                                          : 0;
        if (read != 6 || !used || seconds == 0 || !(fabs(part - 100. * (double)done / (double)all) <= 0.0501))
            fail_msg("a sweep of %d points says %s", slow_points, line);
        assert_true(all == slow_points && done >= all / 10 && done > before && done <= all);
        if (line == text)
            assert_true((double)done / rate >= 2.09 && (double)done / rate <= passed);
        double rest = (double)(all - done) / rate / seconds;
        assert_true(left >= rest * (1 - 1e-3) - (seconds > 60 ? 0.051 : 0) && left < rest * (1 + 1e-3) + 1);
        before = done;
    }
    assert_true(before > 0);
    free(text);
}

/* If only the figure is left it is finished, and the command has completed. */
static void a_signal_during_the_last_figure_is_too_late(void **state) {
    static const char *const lines[] = {
        "diagnose impact-oscillator -o late.png",
        "lyapunov impact-oscillator --transient 20 --periods 1800 -o late.svg",
        "spectrum impact-oscillator --samples 64 -o late.pdf", "plot s.h5 -o late.png",
        "plot s.h5 --title late -o late.svg"};
    const fixture *f = *state;
    assert_int_equal(
        end_of(start(f, "sweep impact-oscillator --over omega=0.9:1.1:3 --quiet -o s.h5", plainly, SIGTERM)),
        0);
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        const char *name = strstr(lines[k], "late.");
        make_gnuplot(f, ":");
        assert_int_equal(end_of(start(f, lines[k], plainly, SIGTERM)), 0);
        char *undisturbed = said(f, "out"), path[320];
        assert_int_equal(remove(path_in(f, name, path)), 0);
        make_gnuplot(f, "kill -TERM $PPID");
        int outcome = end_of(start(f, lines[k], plainly, SIGTERM));
        char *out = said(f, "out"), *err = said(f, "err");
        if (outcome != 0 || err[0] || strcmp(out, undisturbed) != 0 || !strstr(out, name))
            fail_msg("%s: status %#x: %s%s", lines[k], (unsigned)outcome, out, err);
        assert_int_equal(remove(path), 0);
        assert_int_equal(folder_files(f->nameless, true), 0);
        free(undisturbed);
        free(out);
        free(err);
    }
}

/* A signal while a figure is drawn: that is finished, the next is not begun, and --resume makes the rest. */
static void a_signal_during_a_figure_ends_paper(void **state) {
    static const char *const made[] = {"paper/fig4a.h5", "paper/fig4a.png", "paper/fig4b.h5",
                                       "paper/fig4b.png"};
    const fixture *f = *state;
    char data[320];
    struct stat before, after;
    make_gnuplot(f, "kill -TERM $PPID");
    check_interrupted(f, end_of(start(f, "paper --quick --quiet --figure 4 -o paper", plainly, SIGTERM)),
                      "paper");
    for (int k = 0; k < 4; k++) {
        assert_int_equal(is_there(f, made[k]), k < 2);
    }
    assert_int_equal(stat(path_in(f, "paper/fig4a.h5", data), &before), 0);
    make_gnuplot(f, ":");
    assert_int_equal(end_of(start(f, "paper --quick --quiet --figure 4 --resume -o paper", plainly, SIGTERM)),
                     0);
    for (int k = 0; k < 4; k++) {
        assert_true(is_there(f, made[k]));
    }
    assert_int_equal(stat(data, &after), 0);
    assert_int_equal(before.st_size, after.st_size);
    assert_int_equal(folder_files(f->paper, true), 4);
}

/* The largest size of the first sweep's journal, in a paper that is ended when the journal is gone. */
static long long largest_journal(const fixture *f, const char *line, const char *journal) {
    pid_t child = start(f, line, plainly, SIGTERM);
    long long largest = 0;
    for (int k = 0; k < 10 * patience_ms && !(largest && size_of(journal) < 0); k++) {
        long long now = size_of(journal);
        largest = now > largest ? now : largest;
        pause_ms(0.1);
    }
    kill(child, SIGTERM);
    end_of(child);
    folder_files(f->paper, true);
    return largest;
}

/* A signal when a sweep is almost done still ends what follows it. */
static void a_signal_at_the_end_of_a_sweep_ends_paper(void **state) {
    skip_where_slow();
    static const char line[] = "paper --quick --quiet --figure 4 -o paper";
    static const double parts[] = {0.95, 0.85, 0.98}; /* later ones in the long version */
    const size_t trials = long_version() ? sizeof parts / sizeof parts[0] : 1;
    const fixture *f = *state;
    char journal[320];
    make_gnuplot(f, ":");
    path_in(f, "paper/fig4a.h5.journal", journal);
    long long most = largest_journal(f, line, journal);
    assert_true(most > 0);
    for (size_t k = 0; k < trials; k++) {
        pid_t child = start(f, line, plainly, SIGTERM);
        for (int tries = 0; tries < 10 * patience_ms && size_of(journal) < parts[k] * (double)most &&
                            !is_there(f, "paper/fig4a.png");
             tries++)
            pause_ms(0.1);
        kill(child, SIGTERM);
        check_interrupted(f, end_of(child), "paper at the end of a sweep");
        assert_false(is_there(f, "paper/fig4b.png"));
        folder_files(f->paper, true);
    }
}

/* Other signals are not caught: they have their usual effect. */
static void other_signals_end_the_program_at_once(void **state) {
    skip_where_slow();
    static const int signals[] = {SIGQUIT, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGPIPE, SIGIO};
    const struct rlimit none = {0, 0};
    const fixture *f = *state;
    setrlimit(RLIMIT_CORE, &none);
    for (size_t k = 0; k < sizeof signals / sizeof signals[0]; k++) {
        pid_t child = start(f, "lyapunov fig7c --transient 1000000000", plainly, SIGTERM);
        int outcome = 0;
        /* Once this signal is caught, all of them are handled. */
        for (int waited = 0; waited < patience_ms && !catches(child, SIGHUP); waited++)
            pause_ms(1);
        kill(child, signals[k]);
        outcome = end_of(child);
        if (!WIFSIGNALED(outcome) || WTERMSIG(outcome) != signals[k])
            fail_msg("signal %d: status %#x", signals[k], (unsigned)outcome);
    }
}

/* A command that waits for the reader of its output loses none of it to a signal. */
static void a_signal_while_nobody_reads_loses_nothing(void **state) {
    static char block[1 << 16];
    const fixture *f = *state;
    char whole[320], *plain;
    size_t length, heard = 0;
    int ends[2], waiting = 0;
    assert_int_equal(end_of(start(f, "spectrum impact-oscillator --json", plainly, SIGTERM)), 0);
    plain = read_all(path_in(f, "out", whole), &length);
    /* More than a pipe of one page and a buffer hold. */
    assert_true(length > 20000);
    assert_int_equal(pipe(ends), 0);
    assert_true(fcntl(ends[1], F_SETPIPE_SZ, 4096) > 0);
    pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDOUT_FILENO);
        close(ends[0]);
        close(ends[1]);
        execl(SALTUS_COMMAND, "saltus", "spectrum", "impact-oscillator", "--json", (char *)NULL);
        _exit(99);
    }
    close(ends[1]);
    for (int tries = 0; tries < patience_ms && waiting < 4096; tries++) {
        pause_ms(1);
        assert_int_equal(ioctl(ends[0], FIONREAD, &waiting), 0);
    }
    for (int k = 0; k < 2; k++) {
        pause_ms(3);
        kill(child, SIGTERM);
    }
    pause_ms(3);
    for (ssize_t got; (got = read(ends[0], block, sizeof block)) > 0; heard += (size_t)got)
        assert_true(heard + (size_t)got <= length && memcmp(plain + heard, block, (size_t)got) == 0);
    close(ends[0]);
    assert_int_equal(end_of(child), 0);
    assert_int_equal(heard, length);
    free(plain);
}

/* At any moment: completed with the whole file, interrupted with a message, or ended before anything was
 * written. */
static void a_signal_at_any_moment_leaves_whole_files(void **state) {
    static const char *const lines[] = {
        "simulate impact-oscillator --periods 10 -o x.h5",
        "sweep impact-oscillator --over omega=0.9:1.1:8 --quiet --threads 1 -o x.h5",
        "continue impact-oscillator --in omega=0.9:1.1 --points 6 -o x.h5"};
    enum { trials = 36 };
    const fixture *f = *state;
    char path[320];
    path_in(f, "x.h5", path);
    for (int k = 0; k < trials; k++) {
        pid_t child = start(f, lines[k % 3], plainly, SIGTERM);
        pause_ms(0.9 * (k / 3));
        kill(child, SIGTERM);
        int outcome = end_of(child);
        size_t length = 0;
        char *bytes = is_there(f, "x.h5") ? read_all(path, &length) : NULL;
        if (WIFSIGNALED(outcome)) {
            assert_int_equal(WTERMSIG(outcome), SIGTERM);
            assert_null(bytes);
        } else if (WEXITSTATUS(outcome) != 0)
            check_interrupted(f, outcome, lines[k % 3]);
        else
            assert_non_null(bytes);
        assert_int_equal(named(f->folder, ".part"), 0);
        if (bytes)
            assert_true(length > 24 && memcmp(bytes + length - 24, "saltus:", 7) == 0);
        free(bytes);
        remove(path);
        remove(path_in(f, "x.h5.journal", path));
        path_in(f, "x.h5", path);
    }
}

/* A branch computed by the command line, ended by alternating signals after ever longer times and resumed
 * until it is complete; returns how often points were kept. */
static int follow_in_parts(const fixture *f, const char *line, const char *name) {
    char resumed[300], path[320];
    int times = 0;
    path_in(f, name, path);
    snprintf(resumed, sizeof resumed, "%s --resume", line);
    for (int k = 0;; k++) {
        bool goes_on = is_there(f, name);
        pid_t child = start(f, goes_on ? resumed : line, plainly, SIGTERM);
        pause_ms(8 + 4 * k);
        kill(child, k % 3 ? SIGTERM : SIGKILL);
        int outcome = end_of(child);
        times += goes_on;
        if (WIFEXITED(outcome) && WEXITSTATUS(outcome) == 0)
            return times;
        assert_true(WIFSIGNALED(outcome) || WEXITSTATUS(outcome) == 1);
        assert_true(!goes_on || is_there(f, name));
    }
}

/* The file of a branch that was interrupted or killed any number of times is that of an undisturbed run, byte
 * for byte. */
static void a_branch_in_parts_is_the_whole_one(void **state) {
    skip_where_slow();
    static const char many_settings[] =
        "continue impact-oscillator --set c=0.12504 F=1.1739 F0=0.11951 d=0.42605 r=0.40661 omega=2.0486 "
        "--in omega=1.2292:3.2778 --locus LP --and d=0.12782:0.85211 --switch 1 --step-max 0.05";
    static const char *const lines[] = {
        "continue impact-oscillator --in omega=0.5:2 --step-max 0.002 --direction up",
        "continue impact-oscillator --in omega=0.9:1.3 --at 1,1.1 --step-max 0.003 --switch 2",
        "continue impact-oscillator --in omega=0.3:3 --step-max 0.005 --locus GR --and d=0.2:3",
        many_settings};
    const fixture *f = *state;
    char line[256], path[320];
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
        size_t length, other;
        snprintf(line, sizeof line, "%s -o whole.h5", lines[k]);
        assert_int_equal(end_of(start(f, line, plainly, SIGTERM)), 0);
        char *whole = read_all(path_in(f, "whole.h5", path), &length);
        snprintf(line, sizeof line, "%s -o parts.h5", lines[k]);
        int times = follow_in_parts(f, line, "parts.h5");
        char *parts = read_all(path_in(f, "parts.h5", path), &other);
        if (times < 1 || length != other || memcmp(whole, parts, length) != 0)
            fail_msg("%s: %d times gone on with, %zu bytes for %zu", lines[k], times, other, length);
        free(whole);
        free(parts);
        remove(path);
        remove(path_in(f, "whole.h5", path));
    }
}

/* Whether a line of a file begins with these words. */
static bool has_line(const fixture *f, const char *name, const char *words) {
    char *text = said(f, name), *rest = text;
    bool found = false;
    for (char *line = strtok_r(rest, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest))
        found = found || strncmp(line, words, strlen(words)) == 0;
    free(text);
    return found;
}

/* Start a command and stop it as soon as it has got so far that there is a result: after ever longer times.
 */
static void stop_midway(const fixture *f, const char *line, const char *result) {
    for (double pause = 100; pause < patience_ms; pause *= 1.5) {
        char path[320];
        remove(path_in(f, result, path));
        pid_t child = start(f, line, plainly, SIGTERM);
        pause_ms(pause);
        kill(child, SIGTERM);
        const int outcome = end_of(child);
        if (WIFEXITED(outcome) && WEXITSTATUS(outcome) == 0)
            fail_msg("%s is done too soon", line);
        if (size_of(path) > 0)
            return;
    }
    fail_msg("%s has no result", line);
}

/* What an interrupted run leaves says so: tables, objects, texts and figures, also those made from its file.
 */
static void what_is_not_complete_says_so(void **state) {
    const fixture *f = *state;
    char path[320];
    make_gnuplot(f, "true");
    stop_midway(f, "lyapunov fig7c --precision 1e-8 --periods 1000000000 --json -o l.csv", "l.csv");
    assert_true(has_line(f, "l.csv", "# complete: 0"));
    char *text = said(f, "out");
    assert_non_null(strstr(text, "\"scene\": \"fig7c\", \"complete\": false, "));
    free(text);
    stop_midway(f, "lyapunov fig7c --precision 1e-8 --periods 1000000000", "out");
    text = said(f, "out");
    assert_non_null(strstr(text, "; interrupted\n"));
    free(text);
    stop_midway(f, "classify pipe --set omega=43 d=0.03 --seeds 100000 --json", "out");
    text = said(f, "out");
    assert_non_null(strstr(text, "\"complete\": false, \"seeds\": "));
    free(text);
    stop_midway(f, "classify pipe --set omega=43 d=0.03 --seeds 100000", "out");
    text = said(f, "out");
    assert_non_null(strstr(text, "random initial states (interrupted)\n"));
    free(text);
    static const char *const files[][2] = {
        {"continue impact-oscillator --in omega=0.5:2 --step-max 0.0002 -o p.h5", "p.h5"},
        {"simulate impact-oscillator --periods 1000000 -o p.h5", "p.h5"},
        {"sweep impact-oscillator --over omega=0.5:2:100000 -o p.h5", "p.h5"}};
    for (size_t k = 0; k < sizeof files / sizeof files[0]; k++) {
        stop_midway(f, files[k][0], files[k][1]);
        assert_int_equal(end_of(start(f, "export p.h5 -o p.csv --force --quiet", plainly, SIGTERM)), 0);
        assert_true(has_line(f, "p.csv", "# complete: 0"));
        end_of(start(f, "plot p.h5 -o p.svg --keep-script p.gp --force", plainly, SIGTERM));
        text = said(f, "p.gp");
        assert_non_null(strstr(text, "(interrupted"));
        free(text);
        remove(path_in(f, "p.h5", path));
        remove(path_in(f, "p.h5.journal", path));
    }
    stop_midway(f, "simulate impact-oscillator --periods 1000000 -o p.csv --force", "p.csv");
    assert_true(has_line(f, "p.csv", "# complete: 0"));
}

/* Killed while it writes, a command leaves no part of a file: it has had no name. */
static void a_killed_run_leaves_no_part(void **state) {
    const fixture *f = *state;
    char path[320];
    const int nameless = open(f->folder, O_TMPFILE | O_WRONLY, 0666);
    if (nameless < 0)
        skip();
    close(nameless);
    const char *line = "simulate impact-oscillator --periods 300 --samples 1000 -o x.csv --force";
    assert_int_equal(end_of(start(f, line, plainly, SIGTERM)), 0);
    size_t length, other;
    char *whole = read_all(path_in(f, "x.csv", path), &length);
    for (int k = 0; k < 24; k++) {
        if (k % 2 == 0)
            remove(path);
        const int before = named(f->folder, ".part");
        pid_t child = start(f, line, plainly, SIGTERM);
        pause_ms(20 * (k / 2));
        kill(child, SIGKILL);
        end_of(child);
        /* What is replaced is whole before and after; only its successor may have had a name just then. */
        assert_in_range(named(f->folder, ".part"), before, before + k % 2);
        if (k % 2 == 1 || is_there(f, "x.csv")) {
            char *bytes = read_all(path, &other);
            assert_int_equal(other, length);
            assert_memory_equal(bytes, whole, length);
            free(bytes);
        } else
            assert_int_equal(end_of(start(f, line, plainly, SIGTERM)), 0);
    }
    free(whole);
    remove(path);
    assert_int_equal(end_of(start(f, "simulate impact-oscillator --periods 3 -o x.csv", plainly, SIGTERM)),
                     0);
    struct stat facts;
    const mode_t mask = umask(0);
    umask(mask);
    assert_int_equal(stat(path, &facts), 0);
    assert_int_equal(facts.st_mode & 0777, 0666 & ~mask);
    assert_int_equal(facts.st_nlink, 1);
}

int main(void) {
    /* A leak check at the program's end stops it by ptrace, and a signal that arrives just then is never
     * delivered. */
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
    setenv("LSAN_OPTIONS", "detect_leaks=0", 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_signal_before_the_work_ends_every_command),
        cmocka_unit_test(a_check_of_derivatives_ends_soon),
        cmocka_unit_test(a_transient_that_is_cut_off_is_not_told_as_run),
        cmocka_unit_test(a_signal_before_a_sweep_leaves_what_was_there),
        cmocka_unit_test(ignored_signals_stay_ignored),
        cmocka_unit_test(other_signals_end_the_program_at_once),
        cmocka_unit_test(a_signal_while_nobody_reads_loses_nothing),
        cmocka_unit_test(a_signal_during_the_last_figure_is_too_late),
        cmocka_unit_test(a_signal_during_a_figure_ends_paper),
        cmocka_unit_test(a_signal_at_the_end_of_a_sweep_ends_paper),
        cmocka_unit_test(a_signal_at_any_moment_leaves_whole_files),
        cmocka_unit_test(a_branch_in_parts_is_the_whole_one),
        cmocka_unit_test(what_is_not_complete_says_so),
        cmocka_unit_test(a_killed_run_leaves_no_part),
        cmocka_unit_test(a_late_second_signal_ends_the_program),
        cmocka_unit_test(a_long_sweep_is_told_in_lines),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
