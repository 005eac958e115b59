/* The kernel compiled for a single system from text gives the bits of the interpreting one, wherever a flow
 * switches. If nothing can be compiled, nothing is lost or left behind.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "folder.h"

#include "flow/flow.h"
#include "system/kept.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { columns_max = 24, lanes_max = 8, events_max = 200, file_name_max = 700 };

/* A system whose tape has rows of all kinds but one. */
static const char every_kind[] =
    "model:\n"
    "  parameters: {N: {default: 2, min: 1, max: 9, integer: true}, F: 0.8, omega: 1, k: 1.5}\n"
    "  families: {x: N}\n"
    "  let: {S: \"sum(j, 1, N, x[j]^2)\", dS: \"sum(j, 1, N, x[j]*x[j]')\"}\n"
    "  motion:\n"
    "    x[i]: -x[i]/(1 + x[i]^2) - k*sin(x[i]) - 0.1*x[i]' - x[i]*(S + 0.1*dS) - if(i < N, z*x[i+1], z^2)\n"
    "      + if(F > 0.5, F*cos(omega*t), exp(-x[i]^2)) + 0.1*atan2(x[1], 2 + z) + 0.1*x[i]'*z\n"
    "  states: {z: \"x1*sqrt(2 + x2^2) - z - z^3\"}\n"
    "  forcing: omega\n"
    "stop: {coordinate: \"x1 + 0.5*x2\", d: 0.3, r: 0.8}\n";

/* The other kind: operands that are not adjacent. */
static const char apart[] =
    "model:\n"
    "  parameters: {N: {default: 4, min: 1, max: 9, integer: true}, F: 0.8, omega: 1}\n"
    "  families: {x: N}\n"
    "  motion: {\"x[i]\": \"-x[i] - x[i]^3 - 0.5*x[i]' + 0.1*x[i]'*x[5-i] + F*cos(omega*t)\"}\n"
    "  forcing: omega\n"
    "stop: {coordinate: \"x[1]\", d: 0.3, r: 0.8}\n";

/* Lasting contacts: the load presses it on its stops for half of each period. */
static const char held[] = "model:\n"
                           "  parameters: {F: 1.3, omega: 0.7, k: 1.5}\n"
                           "  motion:\n"
                           "    x: -k*x - x^3 - 0.1*x' + 0.3*(y - x) + F*cos(omega*t)\n"
                           "    y: -y - 0.2*y' + 0.3*(x - y)*z + 0.1\n"
                           "  states: {z: \"1 + x - z\"}\n"
                           "  forcing: omega\n"
                           "stops:\n"
                           "  - {coordinate: \"x + 0.2*y\", d: 0.1, r: 0.1, sides: both}\n"
                           "  - {coordinate: \"y\", d: 0.1, r: 0.2}\n";

/* A way to run a scene, given by name or text; lanes beside the first differ by their states. */
typedef struct way {
    const char *name, *text;
    bool wide, tangents;
    int directions;
} way;

static const way ways[] = {{"every kind", every_kind, false, false, 0},
                           {"every kind", every_kind, false, true, 2},
                           {"every kind", every_kind, true, false, 0},
                           {"chain", NULL, true, false, 0},
                           {"gear-rattle", NULL, false, false, 0},
                           {"impact-damper", NULL, false, true, 2},
                           {"apart", apart, true, true, 0},
                           {"held", held, false, true, 2},
                           {"held", held, true, false, 0},
                           {"duffing", NULL, false, true, 0}};
enum { way_count = sizeof ways / sizeof ways[0] };

/* The test's own folder for compiled functions. */
static char cache[] = "/tmp/saltus_compiled_XXXXXX", kept[64];

static saltus_system *system_of(const way *w) {
    saltus_scene scene = {.title = ""};
    saltus_message message = {.text = ""};
    saltus_status status = w->text ? saltus_scene_parse(w->text, strlen(w->text), w->name, &scene, &message)
                                   : saltus_scene_load(w->name, &scene, &message);
    check_ok(status, &message);
    saltus_system *system = build(&scene.spec);
    saltus_scene_clear(&scene);
    return system;
}

static void start(saltus_flow *flow, int lane) {
    const saltus_system *system = saltus_flow_system(flow, lane);
    saltus_message message = {.text = ""};
    double state[SALTUS_STATE_MAX];
    for (int i = 0; i < saltus_system_dimension(system); i++)
        state[i] = 0.1 * sin(1 + i + 0.3 * lane) * saltus_system_scale(system)[i];
    check_ok(saltus_flow_start(flow, lane, (saltus_time){0, 0.2}, state, &message), &message);
    saltus_flow_aim(flow, lane, (saltus_time){8, 0}, SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK);
}

static saltus_flow *open_way(const way *w, const saltus_system *system) {
    const saltus_system *all[lanes_max];
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    static const char *const keys[] = {"omega", "d"};
    saltus_direction directions[2];
    saltus_flow *flow = NULL;
    const int lanes = w->wide ? saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX) : 1,
              dimension = saltus_system_dimension(system);
    options.rtol = 1e-10;
    options.integrator = SALTUS_TAYLOR;
    options.directions = w->directions;
    options.columns = (w->tangents ? dimension : 0) + w->directions;
    assert_in_range(options.columns, 0, columns_max);
    for (int l = 0; l < lanes; l++)
        all[l] = system;
    check_ok(saltus_flow_new(all, lanes, &options, &flow, &message), &message);
    for (int d = 0; d < w->directions; d++)
        check_ok(saltus_spec_direction(saltus_system_spec(system), keys[d], &directions[d], NULL, &message),
                 &message);
    saltus_flow_set_directions(flow, directions);
    for (int l = 0; l < lanes; l++)
        start(flow, l);
    return flow;
}

/* From now on a flow is interpreted. */
static void interpret(saltus_flow *flow) {
    saltus_fixed_close(&flow->fixed);
    flow->fixed = (saltus_fixed){.compiled = NULL};
}

static int asked, held_asked; /* calls of the compiled function; with held contacts */
static saltus_compiled_function *compiled_function;
static void count_expansions(void *work, int from, int to) {
    asked++;
    held_asked += ((const saltus_work *)work)->hold.count > 0;
    compiled_function(work, from, to);
}

/* The next events of two flows agree to the last bit; false: neither has any more. */
static bool check_same_event(const way *w, saltus_flow *a, saltus_flow *b, int *left) {
    const int dimension = a->dimension, columns = saltus_flow_columns(a);
    saltus_flow *const both[] = {a, b};
    double state[2][SALTUS_STATE_MAX], tangents[2][SALTUS_STATE_MAX * columns_max];
    saltus_message message = {.text = ""};
    saltus_event event[2];
    int lane[2];
    for (int k = 0; k < 2; k++) {
        check_ok(saltus_flow_run(both[k], &lane[k], &event[k], &message), &message);
        saltus_flow_state(both[k], lane[k], state[k]);
        saltus_flow_tangents(both[k], lane[k], tangents[k]);
    }
    const saltus_time times[] = {saltus_flow_time(a, lane[0]), saltus_flow_time(b, lane[1])};
    if (lane[0] != lane[1] || event[0].kind != event[1].kind || times[0].cycle != times[1].cycle ||
        times[0].phase != times[1].phase ||
        memcmp(state[0], state[1], (size_t)dimension * sizeof(double)) != 0 ||
        memcmp(tangents[0], tangents[1], (size_t)(dimension * columns) * sizeof(double)) != 0)
        fail_msg("%s, %s, %d columns: event %d of lane %d at %.17g, and %d of lane %d at %.17g", w->name,
                 w->wide ? "lanes" : "alone", columns, (int)event[0].kind, lane[0],
                 saltus_time_periods(times[0]), (int)event[1].kind, lane[1], saltus_time_periods(times[1]));
    *left -= event[0].kind == SALTUS_REACHED;
    for (int k = 0; k < 2 && event[0].kind != SALTUS_REACHED; k++)
        saltus_flow_aim(both[k], lane[k], (saltus_time){8, 0}, SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK);
    return *left > 0;
}

/* Run a way twice: interpreted, and compiled from event `from` on. */
static void check_way(const way *w, const saltus_system *system, saltus_compiled_function *function,
                      int from) {
    saltus_flow *plain = open_way(w, system), *other = open_way(w, system);
    int left = w->wide ? saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX) : 1, events = 0;
    interpret(plain);
    interpret(other);
    asked = held_asked = 0;
    compiled_function = function;
    do {
        if (events == from)
            other->fixed.function = count_expansions;
    } while (check_same_event(w, plain, other, &left) && ++events < events_max);
    assert_true(asked > 0 && (w->text != held || held_asked > 0));
    saltus_flow_free(plain);
    saltus_flow_free(other);
}

static bool has_compiler(void) {
    char how[512];
    saltus_system *system = system_of(&ways[0]);
    assert_true(saltus_fixed_tell(system, how, sizeof how));
    saltus_system_free(system);
    return strncmp(how, "interpreted: ", 13) != 0;
}

static void pause_briefly(void) {
    nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
}

/* Compile all functions at the same time, then compare; kept functions give the same bits. */
static void same_bits(void **unused) {
    (void)unused;
    saltus_system *system[way_count];
    saltus_flow *flow[way_count];
    unsigned kinds = 0;
    int patience = 60000 / 5; /* pauses before compiling counts as failed */
    if (!has_compiler())
        skip();
    for (int again = 0; again < 2; again++) {
        for (int k = 0; k < way_count; k++) {
            system[k] = system_of(&ways[k]);
            flow[k] = open_way(&ways[k], system[k]);
            for (int r = 0; r < system[k]->tape->row_count; r++)
                kinds |= 1u << system[k]->tape->rows[r].code;
        }
        for (int left = way_count; left > 0; pause_briefly()) {
            left = way_count;
            for (int k = 0; k < way_count; k++)
                left -= saltus_fixed_ask(&flow[k]->fixed, system[k]);
            assert_true(left == 0 || --patience > 0);
        }
        for (int k = 0; k < way_count; k++) {
            saltus_compiled_function *function = flow[k]->fixed.function;
            check_way(&ways[k], system[k], function, 0);
            check_way(&ways[k], system[k], function, 3);
            saltus_flow_free(flow[k]);
            saltus_system_free(system[k]);
        }
        assert_int_equal(folder_files(kept, false), way_count);
    }
    assert_int_equal(kinds, (1u << (SALTUS_TAPE_GATHER + 1)) - 1);
    /* No child process is left to wait for. */
    assert_true(waitpid(-1, NULL, WNOHANG) == -1 && errno == ECHILD);
}

/* Ask for a function until it is there, or until it is clear that it will not be. */
static bool comes(const way *w) {
    saltus_system *system = system_of(w);
    saltus_flow *flow = open_way(w, system);
    bool ready = false;
    for (int k = 0; k < 60 && !ready; k++, pause_briefly())
        ready = saltus_fixed_ask(&flow->fixed, system);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return ready;
}

/* Neither files nor folders that others can write to are used. */
static void foreign_files(void **unused) {
    (void)unused;
    char file[file_name_max], before[512], after[512];
    if (!has_compiler())
        skip();
    saltus_system *system = system_of(&ways[0]);
    DIR *folder = opendir(kept);
    assert_non_null(folder);
    assert_true(comes(&ways[0]));
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        snprintf(file, sizeof file, "%s/%s", kept, entry->d_name);
        if (entry->d_name[0] != '.')
            assert_int_equal(chmod(file, 0722), 0);
    }
    closedir(folder);
    setenv("SALTUS_COMPILE", "false", 1);
    assert_false(comes(&ways[0]));
    unsetenv("SALTUS_COMPILE");
    saltus_fixed_tell(system, before, sizeof before);
    assert_int_equal(chmod(kept, 0777), 0);
    saltus_fixed_tell(system, after, sizeof after);
    assert_int_equal(chmod(kept, 0700), 0);
    assert_null(strstr(before, "interpreted: "));
    assert_non_null(strstr(after, "interpreted: there is no folder"));
    saltus_system_free(system);
    folder_files(kept, true);
}

static void put_file(const char *name, int days_ago) {
    char path[2 * file_name_max];
    snprintf(path, sizeof path, "%s/%s", kept, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fclose(file), 0);
    const struct timespec then = {.tv_sec = time(NULL) - (time_t)days_ago * 24 * 3600}, both[] = {then, then};
    assert_int_equal(utimensat(AT_FDCWD, path, both, 0), 0);
}

static bool is_there(const char *name) {
    char path[2 * file_name_max];
    snprintf(path, sizeof path, "%s/%s", kept, name);
    return access(path, F_OK) == 0;
}

/* Functions unused for long are removed, and of too many the longest unused; nothing else is. Loading a
 * function from its file counts as use. */
static void the_folder_stays_small(void **unused) {
    (void)unused;
    static const char key[] = "0123456789abcdef0123456789abcdef", other[] = "notes of the user's.so";
    char old[64], young[64], left[64], under_way[64], name[file_name_max];
    snprintf(old, sizeof old, "%s-alone-20-0-0.so", key);
    snprintf(young, sizeof young, "%s-alone-20-2-0.so", key);
    snprintf(left, sizeof left, "%s-alone-20-0-0.so.1f.2e", key);
    snprintf(under_way, sizeof under_way, "%s-alone-20-2-0.so.1f.2e", key);
    put_file(old, SALTUS_KEPT_DAYS + 1);
    put_file(young, SALTUS_KEPT_DAYS - 1);
    put_file(left, 2);
    put_file("source.abcdef", 2);
    put_file(under_way, 0);
    put_file("source.ghijkl", 0);
    put_file(other, 10 * SALTUS_KEPT_DAYS);
    saltus_kept_trim(kept);
    assert_false(is_there(old) || is_there(left) || is_there("source.abcdef"));
    assert_true(is_there(young) && is_there(under_way) && is_there("source.ghijkl") && is_there(other));
    assert_int_equal(folder_files(kept, false), 4);
    for (int k = 0; k < SALTUS_KEPT_MOST + 7; k++) {
        snprintf(name, sizeof name, "%.28s%04x-lanes-20-0-0.so", key, k);
        put_file(name, k % 7);
    }
    saltus_kept_trim(kept);
    /* The young file, now the oldest of all, has also gone, with seven of those of six days. */
    assert_int_equal(folder_files(kept, false), SALTUS_KEPT_MOST + 3);
    assert_false(is_there(young));
    for (int k = 0; k < SALTUS_KEPT_MOST + 7; k++) {
        snprintf(name, sizeof name, "%.28s%04x-lanes-20-0-0.so", key, k);
        assert_true(k % 7 == 6 || is_there(name));
    }
    folder_files(kept, true);
    put_file(young, SALTUS_KEPT_DAYS - 1);
    snprintf(name, sizeof name, "%s/%s", kept, young);
    saltus_kept_use(name);
    put_file(old, SALTUS_KEPT_DAYS + 1);
    if (has_compiler()) /* A run that needs another function also trims. */
        comes(&ways[4]);
    else
        saltus_kept_trim(kept);
    assert_true(is_there(young) && !is_there(old));
    struct stat s;
    assert_int_equal(stat(name, &s), 0);
    assert_true(time(NULL) - s.st_mtime < 3600);
    while (has_compiler() && !comes(&ways[4]))
        pause_briefly();
    folder_files(kept, true);
}

static double milliseconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

/* The compiler starts after the stated delay, not before: its substitute here leaves a mark. */
static void short_runs_do_without(void **unused) {
    (void)unused;
    char compiler[80], mark[80], how[512];
    snprintf(compiler, sizeof compiler, "%s/compiler", cache);
    snprintf(mark, sizeof mark, "%s/mark", cache);
    FILE *script = fopen(compiler, "w");
    assert_non_null(script);
    fprintf(script, "#!/bin/sh\n: >%s\n", mark);
    assert_int_equal(fclose(script), 0);
    assert_int_equal(chmod(compiler, 0700), 0);
    setenv("SALTUS_COMPILE", compiler, 1);
    saltus_system *system = system_of(&ways[0]);
    saltus_flow *flow = open_way(&ways[0], system);
    assert_true(saltus_fixed_tell(system, how, sizeof how));
    const char *told = strstr(how, "more than ");
    assert_non_null(told);
    const double delay = atof(told + strlen("more than ")), begin = milliseconds();
    assert_true(delay >= 50);
    double asked_last = begin;
    while (milliseconds() < begin + 0.5 * delay) {
        saltus_fixed_ask(&flow->fixed, system);
        asked_last = milliseconds();
    }
    for (int k = 0; k < 40; k++)
        pause_briefly();
    const bool early = access(mark, F_OK) == 0 && asked_last < begin + delay;
    while (milliseconds() < begin + delay)
        pause_briefly();
    for (int k = 0; k < 2000 && access(mark, F_OK) != 0; k++, pause_briefly())
        saltus_fixed_ask(&flow->fixed, system);
    const bool begun = access(mark, F_OK) == 0;
    saltus_flow_free(flow);
    saltus_system_free(system);
    unsetenv("SALTUS_COMPILE");
    unlink(mark);
    unlink(compiler);
    assert_false(early);
    assert_true(begun);
}

/* Many systems at once: no more compilers than processors are at work, the others wait, and all come. The
 * substitute here notes how many it meets. */
static void compilers_take_turns(void **unused) {
    (void)unused;
    skip_where_slow();
    enum { systems = 20 };
    char compiler[80], log[80], line[80], text[600];
    saltus_system *system[systems];
    saltus_flow *flow[systems];
    if (!has_compiler())
        skip();
    snprintf(compiler, sizeof compiler, "%s/compiler", cache);
    snprintf(log, sizeof log, "%s/log", cache);
    FILE *script = fopen(compiler, "w");
    assert_non_null(script);
    fprintf(script,
            "#!/bin/sh\nmkdir %s/at.$$\nls -d %s/at.* | wc -l >>%s\nsleep 0.1\ncc \"$@\"\nstatus=$?\n"
            "rmdir %s/at.$$\nexit $status\n",
            cache, cache, log, cache);
    assert_int_equal(fclose(script), 0);
    assert_int_equal(chmod(compiler, 0700), 0);
    setenv("SALTUS_COMPILE", compiler, 1);
    for (int k = 0; k < systems; k++) {
        int used = snprintf(text, sizeof text, "model:\n  parameters: {F: 0.8, omega: 1}\n  motion: {x: -x");
        for (int term = 0; term <= k; term++) /* another source for each */
            used += snprintf(text + used, sizeof text - (size_t)used, " - sin(%d*x)", term + 2);
        snprintf(text + used, sizeof text - (size_t)used, " + F*cos(omega*t)}\n  forcing: omega\n");
        const way own = {"many", text, false, false, 0};
        system[k] = system_of(&own);
        flow[k] = open_way(&own, system[k]);
    }
    int ready = 0;
    double longest = 0;
    for (int turn = 0; turn < 12000 && ready < systems; turn++, pause_briefly()) {
        ready = 0;
        for (int k = 0; k < systems; k++) {
            const double begin = milliseconds();
            ready += saltus_fixed_ask(&flow[k]->fixed, system[k]);
            longest = fmax(longest, milliseconds() - begin);
        }
    }
    for (int k = 0; k < systems; k++) {
        saltus_flow_free(flow[k]);
        saltus_system_free(system[k]);
    }
    unsetenv("SALTUS_COMPILE");
    unlink(compiler);
    assert_int_equal(ready, systems);
    FILE *noted = fopen(log, "r");
    int runs = 0, most = 0;
    assert_non_null(noted);
    for (; fgets(line, sizeof line, noted); runs++)
        most = atoi(line) > most ? atoi(line) : most;
    fclose(noted);
    unlink(log);
    assert_int_equal(runs, systems);
    assert_true(most <= sysconf(_SC_NPROCESSORS_ONLN));
    assert_true(longest < 500);
    for (int k = 0; k < 400 && folder_files(kept, false) > systems; k++)
        pause_briefly();
    assert_int_equal(folder_files(kept, true), systems);
}

/* Without a compiler, or with one that fails, runs go on as before and leave no file. */
static void no_compiler(void **unused) {
    (void)unused;
    static const char *const names[] = {"0", "false", "/no/such/compiler", "true"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        setenv("SALTUS_COMPILE", names[k], 1);
        assert_false(comes(&ways[4]));
    }
    unsetenv("SALTUS_COMPILE");
    assert_int_equal(folder_files(kept, false), 0);
}

/* A relative path is ignored; the home folder's is used instead. */
static void no_folder(void **unused) {
    (void)unused;
    char how[512], *home = getenv("HOME") ? strdup(getenv("HOME")) : NULL;
    saltus_system *system = system_of(&ways[0]);
    bool compiler = has_compiler();
    setenv("XDG_CACHE_HOME", "cache", 1);
    setenv("HOME", cache, 1);
    assert_true(saltus_fixed_tell(system, how, sizeof how));
    assert_true(!compiler || strstr(how, "/.cache/saltus: 0)"));
    unsetenv("HOME");
    assert_true(saltus_fixed_tell(system, how, sizeof how));
    assert_non_null(strstr(how, "interpreted: "));
    if (home)
        setenv("HOME", home, 1);
    setenv("XDG_CACHE_HOME", cache, 1);
    saltus_system_free(system);
    free(home);
}

static int make_cache(void **unused) {
    (void)unused;
    unsetenv("SALTUS_COMPILE");
    if (!mkdtemp(cache))
        return -1;
    snprintf(kept, sizeof kept, "%s/saltus", cache);
    return setenv("XDG_CACHE_HOME", cache, 1) || mkdir(kept, 0700);
}

static int remove_cache(void **unused) {
    char own[80];
    (void)unused;
    folder_files(kept, true);
    rmdir(kept);
    for (int k = 0; k < 2; k++) {
        snprintf(own, sizeof own, "%s/.cache%s", cache, k ? "" : "/saltus");
        rmdir(own);
    }
    return rmdir(cache);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(compilers_take_turns),
                                       cmocka_unit_test(no_compiler),
                                       cmocka_unit_test(same_bits),
                                       cmocka_unit_test(foreign_files),
                                       cmocka_unit_test(no_folder),
                                       cmocka_unit_test(short_runs_do_without),
                                       cmocka_unit_test(the_folder_stays_small)};
    return cmocka_run_group_tests(tests, make_cache, remove_cache);
}
