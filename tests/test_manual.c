/* The manual: examples work as typed, pages document every option and are valid for man, bash completion
 * follows the tables.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"

#include <sys/stat.h>

static const char *const commands[] = {"classify", "diagnose", "simulate", "orbit",  "continue",
                                       "lyapunov", "spectrum", "sweep",    "basins", "plot",
                                       "export",   "paper",    "scenes",   "check"};
enum { command_count = sizeof commands / sizeof commands[0] };

/* The exit status of a shell line in its own folder, with `saltus` on the PATH and a gnuplot that writes an
 * empty picture of the requested kind. */
static int shell(fixture *f, const char *line) {
    char text[2048];
    snprintf(text, sizeof text, "cd %s && (PATH=%s:$PATH; %s) >out 2>err", f->folder, f->folder, line);
    int outcome = system(text);
    return WIFEXITED(outcome) ? WEXITSTATUS(outcome) : 128;
}

static void put_tools(fixture *f) {
    FILE *file = fopen(path_in(f, "gnuplot"), "w");
    assert_non_null(file);
    fputs("#!/bin/sh\ncat >script\ncase $(grep -m 1 '^set terminal' script) in\n"
          "*png*) printf '\\211PNG\\r\\n\\032\\n'; printf %080d 0; printf 'IEND....' ;;\n"
          "*pdf*) printf '%%PDF-1.5\\n'; printf %080d 0; printf '%%%%EOF\\n' ;;\n"
          "*) printf '<?xml version=\"1.0\"?><svg>'; printf %080d 0; printf '</svg>\\n' ;;\nesac\n",
          file);
    fclose(file);
    chmod(path_in(f, "gnuplot"), 0755);
    assert_int_equal(symlink(SALTUS_COMMAND, path_in(f, "saltus")), 0);
}

/* The examples of each page in a new folder, in order: files that one needs come from those before. */
static void examples_work_as_typed(void **state) {
    (void)state;
    for (int k = 0; k < command_count; k++) {
        void *own = NULL;
        open_fixture(&own);
        fixture *f = own;
        char line[64];
        int examples = 0;
        put_tools(f);
        snprintf(line, sizeof line, "help %s", commands[k]);
        char *help = told(f, line), *rest = strstr(help, "\nexamples\n");
        assert_non_null(rest);
        for (char *at = strtok_r(rest, "\n", &rest); at; at = strtok_r(NULL, "\n", &rest)) {
            if (strncmp(at, "  saltus ", 9) != 0)
                continue;
            if (shell(f, at) != 0)
                fail_msg("%s: %s", at, said(f, "err"));
            examples += strstr(at, commands[k]) != NULL;
        }
        free(help);
        /* Lines of other commands lead to the page's own. */
        assert_true(examples >= 2);
        shell(f, "rm -r figures");
        close_fixture(&own);
    }
}

/* Both ways of asking give the same help. */
static void help_is_told_by_name_too(void **state) {
    char line[64];
    for (int k = 0; k < command_count; k++) {
        snprintf(line, sizeof line, "help %s", commands[k]);
        char *named = told(*state, line);
        snprintf(line, sizeof line, "%s --help", commands[k]);
        char *asked = told(*state, line);
        assert_string_equal(named, asked);
        assert_non_null(strstr(named, "\nsee also: saltus help "));
        free(named);
        free(asked);
    }
    char *version = told(*state, "-V");
    assert_string_equal(version, "saltus " SALTUS_VERSION "\n");
    free(version);
    assert_int_equal(run(*state, "help unheard-of"), 2);
    assert_int_equal(run(*state, "help classify sweep"), 2);
}

/* The possible values are in the refusal of any other, and all of it in the option's line of the help. */
static void help_names_what_may_be_chosen(void **state) {
    static const struct {
        const char *command, *option, *line;
    } cases[] = {{"plot", "--view", "plot s.h5 -o s.png"},
                 {"plot", "--show", "plot b.h5 -o s.png"},
                 {"sweep", "--start", "sweep impact-oscillator --over omega=1,1.1 -o s.h5 --force"},
                 {"continue", "--locus", "continue impact-oscillator --in omega=1:1.1 -o c.h5"}};
    assert_int_equal(run(*state, "sweep impact-oscillator --over omega=1,1.1 -o s.h5"), 0);
    assert_int_equal(run(*state, "continue impact-oscillator --in omega=1:1.01 -o b.h5"), 0);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char line[160];
        snprintf(line, sizeof line, "%s %s unheard-of", cases[k].line, cases[k].option);
        assert_int_equal(run(*state, line), 2);
        char *refusal = said(*state, "err"), *words = strstr(refusal, "must be ");
        snprintf(line, sizeof line, "help %s", cases[k].command);
        char *help = told(*state, line), *tells = strstr(help, "\noptions\n");
        snprintf(line, sizeof line, "  %s ", cases[k].option);
        tells = tells ? strstr(tells, line) : NULL;
        assert_true(words && tells);
        *strchr(tells, '\n') = '\0';
        int count = 0;
        for (char *word = strtok_r(words + strlen("must be "), ", \n", &words); word;
             word = strtok_r(NULL, ", \n", &words), count++)
            if (strcmp(word, "or") != 0 && !strstr(tells, word))
                fail_msg("%s: %s is not in its help", cases[k].option, word);
        assert_true(count > 2);
        free(refusal);
        free(help);
    }
}

/* Text as man shows it: a typed hyphen is \-. */
static bool page_has(const char *page, const char *text) {
    char typed[256];
    size_t used = 0;
    for (; *text && used + 2 < sizeof typed; text++) {
        if (*text == '-')
            typed[used++] = '\\';
        typed[used++] = *text;
    }
    typed[used] = '\0';
    return strstr(page, typed) != NULL;
}

/* A page has its sections, every option of the help, and no line that man would take for a request. */
static void pages_tell_what_the_help_tells(void **state) {
    static const char *const requests[] = {".TH ", ".SH ", ".TP", ".PP", ".BR "};
    static const char *const sections[] = {".SH NAME",    ".SH SYNOPSIS", ".SH DESCRIPTION",
                                           ".SH OPTIONS", ".SH EXAMPLES", ".SH SEE ALSO"};
    char line[64], name[64];
    for (int k = 0; k < command_count; k++) {
        snprintf(line, sizeof line, "help %s", commands[k]);
        char *help = told(*state, line), *rest = help;
        snprintf(line, sizeof line, "help %s --man", commands[k]);
        char *page = told(*state, line);
        const char *last = page;
        for (size_t s = 0; s < sizeof sections / sizeof sections[0]; s++) {
            last = strstr(last, sections[s]);
            assert_non_null(last);
        }
        int options = 0;
        for (char *at = strtok_r(rest, "\n", &rest); at; at = strtok_r(NULL, "\n", &rest))
            if (sscanf(at, "  -%60s", name + 1) == 1 && strncmp(at, "  -", 3) == 0) {
                name[0] = '-';
                assert_true(page_has(page, name));
                options++;
            } else if (strncmp(at, "  saltus ", 9) == 0)
                assert_true(page_has(page, at + 2));
        assert_true(options > 0);
        rest = page;
        for (char *at = strtok_r(rest, "\n", &rest); at; at = strtok_r(NULL, "\n", &rest)) {
            bool known = at[0] != '.' && at[0] != '\'';
            for (size_t r = 0; r < sizeof requests / sizeof requests[0]; r++)
                known = known || strncmp(at, requests[r], strlen(requests[r])) == 0;
            assert_true(known);
        }
        free(help);
        free(page);
    }
}

/* The page of the language: its files, and the commands after them, work as typed, and man shows the same
 * lines. */
static void worked_examples_of_the_language_work(void **unused) {
    (void)unused;
    fixture *own;
    open_fixture((void **)&own);
    char *help = told(own, "help text"), *page = told(own, "help text --man"), *rest = help;
    FILE *file = NULL;
    int files = 0, commands_run = 0, pictures = 0;
    for (char *line = strtok_r(rest, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        char *end = strchr(line, ':');
        bool named = line[0] != ' ' && end && end[1] == '\0' && strstr(line, ".yaml:"),
             typed = strncmp(line, "    saltus ", 11) == 0;
        if (file && (typed || strncmp(line, "    ", 4) != 0)) {
            fclose(file);
            file = NULL;
        }
        if (named) {
            *end = '\0';
            file = fopen(path_in(own, line), "w");
            assert_non_null(file);
            files++;
        } else if (typed) {
            assert_true(page_has(page, line + 4));
            if (run(own, line + 11) != 0)
                fail_msg("%s: %s", line + 4, said(own, "err"));
            commands_run++;
            pictures += strstr(line, ".png") != NULL;
        } else if (file) {
            assert_true(page_has(page, line + 4));
            fprintf(file, "%s\n", line + 4);
        }
    }
    assert_null(file);
    assert_int_equal(files, 3);
    assert_int_equal(pictures, 3);
    assert_true(commands_run >= 9);
    char *other = told(own, "help");
    assert_non_null(strstr(other, "\nsaltus help text: systems written as equations.\n"));
    free(other);
    free(help);
    free(page);
    close_fixture((void **)&own);
}

/* The written pages of all commands and of the program, and the completion, are those printed. */
static void all_pages_are_written(void **state) {
    fixture *f = *state;
    char line[128], name[64];
    mkdir(path_in(f, "pages"), 0777);
    free(told(f, "help --pages pages"));
    for (int k = -1; k < command_count; k++) {
        snprintf(line, sizeof line, "help %s --man", k < 0 ? "" : commands[k]);
        char *page = told(f, line);
        snprintf(name, sizeof name, "pages/saltus%s%s.1", k < 0 ? "" : "-", k < 0 ? "" : commands[k]);
        char *written = said(f, name);
        assert_string_equal(written, page);
        assert_true(k >= 0 || strstr(page, ".BR saltus\\-sweep (1)"));
        unlink(path_in(f, name));
        free(page);
        free(written);
    }
    char *page = told(f, "help text --man"), *topic = said(f, "pages/saltus-text.5");
    assert_string_equal(topic, page);
    free(topic);
    free(page);
    unlink(path_in(f, "pages/saltus-text.5"));
    char *completion = told(f, "help --completion"), *written = said(f, "pages/saltus.bash");
    assert_string_equal(written, completion);
    unlink(path_in(f, "pages/saltus.bash"));
    rmdir(path_in(f, "pages"));
    assert_int_equal(run(f, "help --pages nosuchfolder"), 1);
    free(completion);
    free(written);
}

/* What bash offers after a line of words with an unfinished last one; words with blanks between them. */
static char *offered(fixture *f, const char *words) {
    char line[512];
    snprintf(line, sizeof line,
             "bash -c '. ./completion; COMP_WORDS=(%s); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _saltus; "
             "echo \" ${COMPREPLY[*]} \"'",
             words);
    assert_int_equal(shell(f, line), 0);
    return said(f, "out");
}

static void bash_completes(void **state) {
    static const struct {
        const char *words, *offers, *others;
    } cases[] = {
        {"saltus cl", " classify ", " continue "},
        {"saltus \"\"", " sweep ", " --json "},
        {"saltus sweep impact-o", " impact-oscillator ", " pipe "},
        {"saltus sweep pipe --at", " --at-most ", " --over "},
        {"saltus classify pipe --integrator \"\"", " automatic taylor radau mixed ", " --json "},
        {"saltus continue pipe --locus P", " PD ", " LP "},
        {"saltus continue pipe --direction \"\"", " up down both ", " --in "},
        {"saltus help ba", " basins ", " classify "},
        {"saltus help te", " text ", " classify "},
        {"saltus plot --sw", " --swap ", " --seeds "},
        {"saltus -", " --help --version -V ", " classify "},
        {"saltus plot --view \"\"", " turning impacts ", " speed impacts "},
        {"saltus plot --show \"\"", " speed impacts displacement ", " turning "},
        {"saltus plot --size t", " two-columns ", " column "},
        {"saltus plot --format \"\"", " png pdf svg ", " csv "},
        {"saltus spectrum --format \"\"", " png pdf svg csv ", " h5 "},
        {"saltus simulate --format \"\"", " csv ", " h5 "},
        {"saltus export --table s", " stroboscopic samples strobe ", " rows "},
        {"saltus sweep --start \"\"", " reset carry both ", " --over "},
        {"saltus sweep --what l", " lyapunov ", " max "},
        {"saltus paper --figure \"\"", " 2 3 4 5 6 7 8 ", " 9 "},
        {"saltus paper --format \"\"", " png pdf svg ", " csv "},
        /* keys of the scene before, but no options at once, nothing amid a value, files where those are meant
         */
        {"saltus sweep pipe --set \"\"", " omega= ", " --over "},
        {"saltus sweep pipe --set om", " omega= ", " xi= "},
        {"saltus sweep pipe --set omega = 41 \"\"", " d= ", " classify "},
        {"saltus sweep pipe --set omega = 41 \"\"", " --over ", " classify "},
        {"saltus sweep pipe --set omega = \"\"", "  ", " omega= "},
        {"saltus sweep pipe --set s", " sigma= sides= ", " --"},
        {"saltus sweep pipe --over q", " q1= q2= q3= q4= ", " omega= "},
        {"saltus sweep pipe --over s", " sigma= ", " sides= "},
        {"saltus basins pipe --set d=0.03 --over \"\"", " q5= v1= ", " omega= "},
        {"saltus continue duffing --in \"\"", " F= omega= d= r= ", " x= "},
        {"saltus continue pipe --in omega = 40:41 --locus PD --and \"\"", " d= r= ", " N= "},
        {"saltus continue pipe --in \"\"", " omega= ", " q1= "},
        {"saltus classify two-stops --set d", " d= d1= d2= ", " --"},
        {"saltus classify own.yaml --set c", " c= ", " --"},
        {"saltus classify nosuch.yaml --set \"\"", "  ", "="},
        {"saltus plot --over \"\"", "  ", "="},
        {"saltus plot s.h5 --over \"\"", "  ", "="},
    };
    fixture *f = *state;
    if (system("bash -c : >/dev/null 2>&1") != 0)
        skip();
    char *script = told(f, "help --completion");
    put_tools(f);
    assert_int_equal(shell(f, "saltus scenes impact-oscillator >own.yaml"), 0);
    FILE *file = fopen(path_in(f, "completion"), "w");
    fputs(script, file);
    fclose(file);
    free(script);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char *words = offered(f, cases[k].words);
        if (!strstr(words, cases[k].offers) || strstr(words, cases[k].others))
            fail_msg("after %s bash offers %s", cases[k].words, words);
        free(words);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(examples_work_as_typed),
        cmocka_unit_test(help_is_told_by_name_too),
        cmocka_unit_test(help_names_what_may_be_chosen),
        cmocka_unit_test(pages_tell_what_the_help_tells),
        cmocka_unit_test(worked_examples_of_the_language_work),
        cmocka_unit_test(all_pages_are_written),
        cmocka_unit_test(bash_completes),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
