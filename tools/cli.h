/* Shared by the subcommands: option tables, scenes from the command line, exit codes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_CLI_H
#define SALTUS_TOOLS_CLI_H

#include "base/field.h"
#include "saltus/saltus.h"

enum {
    CLI_DONE = 0,
    CLI_FAILED = 1,
    CLI_BAD_INPUT = 2,
    CLI_LIST_MAX = 256,   /* files, settings, ... per option */
    CLI_OPTIONS_MAX = 64, /* options per command */
    CLI_WORDS_MAX = 1024
};

/* An option given on the command line, with its values; the value of a flag is the flag itself. */
typedef struct cli_list {
    const char *flag;
    const char *items[CLI_LIST_MAX];
    int count;
} cli_list;

typedef struct cli_command cli_command;
typedef struct cli_setup cli_setup;

/* A parsed command line. */
typedef struct cli_request {
    const cli_command *command;
    const char *scene; /* the first of the inputs */
    const char *inputs[CLI_LIST_MAX];
    int input_count;
    /* Options of the library, initialised with the defaults of their tables; flows stop at the program's
     * signal flag. */
    saltus_flow_options flow;
    saltus_orbit_options orbit;
    saltus_harvest_options harvest;
    saltus_branch_options branch;
    saltus_classify_options classify;
    saltus_lyapunov_options lyapunov;
    saltus_spectrum_options spectrum;
    saltus_sweep_options sweep;
    saltus_figure_options look; /* layout options of figures, for all commands that draw */
    cli_list given[CLI_OPTIONS_MAX];
    int given_count;
    bool help;
    const char *output; /* where the result is written: the file of -o, or a temporary file that is copied to
                           standard output */
    bool to_stdout;
    const char *words[CLI_WORDS_MAX]; /* words of the command line that affect the results */
    int word_count;
} cli_request;

/* Options of the first three kinds may be given once. Repeated values are refused: repeated keys (the part
 * before '=') of CLI_KEYS and CLI_SETTINGS, repeated texts of CLI_LIST and CLI_FILES. The last two kinds take
 * all arguments up to the next option, CLI_SETTINGS only those of the form key=value. */
typedef enum cli_kind { CLI_FLAG, CLI_TEXT, CLI_WHOLE, CLI_KEYS, CLI_LIST, CLI_SETTINGS, CLI_FILES } cli_kind;

/* An option of the command line itself; it defines parsing, range check, default and help. */
typedef struct cli_option {
    const char *name; /* "--seeds" */
    cli_kind kind;
    const char *argument; /* name of the value in --help; NULL for a flag */
    const char *help;
    double fallback, min, max; /* of a whole number; no default if fallback < min */
    const char *const *words;  /* what a text may be or begin with, NULL-terminated; NULL: anything */
} cli_option;

#define CLI_OPTION(name, kind, argument, help)                                                               \
    { name, kind, argument, help, 0, 0, 0, NULL }
#define CLI_NUMBER(name, argument, help, fallback, min, max)                                                 \
    { name, CLI_WHOLE, argument, help, fallback, min, max, NULL }
#define CLI_CHOICE(name, argument, help, words)                                                              \
    { name, CLI_TEXT, argument, help, 0, 0, 0, words }

/* Library options of a command: all options in a table that have a flag, except those in `without`. `offset`
 * locates the record in cli_request. An option that occurs in several tables is set in all of them; the
 * command's own option with the same flag takes precedence. */
typedef struct cli_table {
    const saltus_option_table *options;
    size_t offset;
    const char *without; /* "--measure --lanes", or NULL */
} cli_table;
#define CLI_TABLE(table, member, without)                                                                    \
    { &table, offsetof(cli_request, member), without }
/* Terminated lists of tables, options and examples. */
#define CLI_TABLES(...)                                                                                      \
    (const cli_table[]) {                                                                                    \
        __VA_ARGS__, {                                                                                       \
            NULL, 0, NULL                                                                                    \
        }                                                                                                    \
    }
#define CLI_OPTIONS(...)                                                                                     \
    (const cli_option *const[]) {                                                                            \
        __VA_ARGS__, NULL                                                                                    \
    }
#define CLI_EXAMPLES(...)                                                                                    \
    (const cli_example[]) {                                                                                  \
        __VA_ARGS__, {                                                                                       \
            NULL, NULL                                                                                       \
        }                                                                                                    \
    }

/* An example; it works as typed after the examples before it have run. */
typedef struct cli_example {
    const char *line, *what; /* `line` without "saltus"; `what` it does */
} cli_example;

/* One subcommand. */
struct cli_command {
    const char *name;
    const char *summary; /* "find one periodic orbit"; shown after the name */
    const char *usage;   /* what follows the name */
    const char *help;    /* one paragraph per line */
    const char *notes;   /* on the meaning of the results, one paragraph per line; NULL: none */
    bool needs_scene;
    bool together;              /* several ranks may share its work */
    int inputs;                 /* most input files; 0: one */
    const char *const *endings; /* endings allowed for -o, NULL-terminated; NULL: it writes no file */
    const char *kind; /* of its HDF5 files and tables, in the words of saltus_file_identify; NULL: that of the
                         first input */
    bool resumes;     /* can continue an interrupted run */
    const cli_table *tables;          /* terminated by an entry without options; NULL: none */
    const cli_option *const *options; /* its own options, NULL-terminated; --quiet, --force (with -o) and
                                         --format (unless only HDF5 is possible) are added automatically */
    const cli_example *examples;      /* terminated by an entry without a line */
    const char *see;                  /* related commands: "plot export" */
    int (*run)(const cli_request *request);
    /* Called instead of `run` if not NULL, with the scene built. After an interruption it may set *cut to a
     * message on what was kept. */
    saltus_status (*work)(const cli_request *request, cli_setup *setup, const char **cut,
                          saltus_message *message);
};

extern const cli_command cmd_classify, cmd_diagnose, cmd_simulate, cmd_scenes, cmd_check, cmd_orbit,
    cmd_continue, cmd_lyapunov, cmd_plot, cmd_spectrum, cmd_sweep, cmd_basins, cmd_export, cmd_paper;

extern const cli_option cli_set, cli_section, cli_json, cli_output, cli_from, cli_resume, cli_force, cli_size,
    cli_no_heading, cli_title, cli_keep_script, cli_swap, cli_log;

/* Endings of figures; of figures or tables; of records. */
extern const char *const cli_figures[], *const cli_figures_or_table[], *const cli_records[];

/* The layout options of every command that draws. */
#define CLI_FIGURE_OPTIONS &cli_size, &cli_no_heading, &cli_title, &cli_keep_script

/* The scene, system and start that most subcommands work on. */
struct cli_setup {
    saltus_scene scene; /* with all --set applied */
    saltus_system *system;
    saltus_start start; /* the motion of --from; if there is none, or none with a state, `state` is the
                           initial state and `dimension` is 0 */
};

/* One option of a command, its own or the library's. */
typedef struct cli_entry {
    const char *flag, *argument, *help; /* argument NULL: it takes no value */
    const cli_option *own;              /* NULL: a library option */
    const saltus_option *option;        /* NULL: an option of the command line itself */
} cli_entry;

/* The number-th option of a command: first its own, then library options, then automatic ones. False if there
 * are fewer. */
bool cli_entry_at(const cli_command *command, int number, cli_entry *entry);
/* Fill a request from the arguments after the subcommand; false after a message on stderr. */
bool cli_parse(const cli_command *command, int count, const char *const *arguments, cli_request *request);
/* The values of an option on the command line; an empty list if it was not given. */
const cli_list *cli_values(const cli_request *request, const char *flag);
bool cli_given(const cli_request *request, const char *flag);
/* Its only value; NULL if it was not given. */
const char *cli_text(const cli_request *request, const char *flag);
/* The value of a command's own CLI_WHOLE option, or its default. */
long cli_whole(const cli_request *request, const char *flag);
/* Check that the output files may be written, then run a parsed command. Returns the exit code. */
int cli_run(const cli_command *command, cli_request *request);
/* The same check alone, of a command that writes to files. */
int cli_check(const cli_command *command, cli_request *request);
/* Print "saltus: ..." on stderr; a failure after a signal is reported as an interruption. Returns the exit
 * code for the status. */
int cli_report(saltus_status status, const saltus_message *message);
/* The same, but reports the failure itself even after a signal. */
int cli_report_cause(saltus_status status, const saltus_message *message);
/* Build the scene and system of the command line. With --from, parameters and stops are those of the orbit
 * file unless --set changes them. Returns CLI_DONE, and the setup is to be cleared, or an exit code after a
 * message. */
int cli_build(const cli_request *request, cli_setup *setup);
/* Release what a setup holds. A zeroed one is accepted. */
void cli_clear(cli_setup *setup);
/* Whether --from names a periodic orbit or an equilibrium. */
bool cli_on_orbit(const cli_setup *setup);
/* Whether the orbit found at this state is the one that --from names. At other parameters than its own, and
 * without forcing, any is. Errors: SALTUS_BAD_INPUT. */
saltus_status cli_same_orbit(const cli_request *request, const cli_setup *setup, const double *found,
                             saltus_message *message);
/* The motion that a command works on, to be cleared: the periodic orbit or the equilibrium of --from, stable
 * or not, recomputed at the present parameters; without one, the motion that the start settles on. Errors:
 * those of saltus_orbit_find (SALTUS_BAD_INPUT if the start is no orbit) and of saltus_classify. If the orbit
 * has its own period, the setup's system is replaced by one that counts time by its returns. */
saltus_status cli_motion(const cli_request *request, cli_setup *setup, const saltus_classify_options *how,
                         saltus_motion *motion, saltus_message *message);
/* The same if --from names an orbit or an equilibrium; SALTUS_BAD_INPUT if it leads to neither. */
saltus_status cli_orbit(const cli_request *request, cli_setup *setup, const saltus_classify_options *how,
                        saltus_motion *motion, saltus_message *message);
/* Check that `later`, a key=value of an option, leaves something of each of the first `count` settings of
 * --set. Errors: SALTUS_BAD_INPUT, with a sentence that names both. */
saltus_status cli_check_twice(const cli_request *request, const saltus_scene *scene, int count,
                              const char *flag, const char *later, saltus_message *message);
/* Read a scene by name: a file, a built-in scene, or - for standard input. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY. */
saltus_status cli_read_scene(const char *name, saltus_scene *scene, saltus_message *message);
/* The scene with all --set applied. */
saltus_status cli_load_scene(const cli_request *request, saltus_scene *scene, saltus_message *message);
/* Apply all --set to a scene. */
saltus_status cli_apply_settings(const cli_request *request, saltus_scene *scene, saltus_message *message);
/* Print a line that begins with "saltus: " on stderr; returns `code`. */
__attribute__((format(printf, 2, 3))) int cli_refuse(int code, const char *format, ...);
/* Parse "key=low:high"; false after a message that names the option. */
bool cli_parse_range(const char *flag, const char *text, char key[SALTUS_KEY_MAX], double *low, double *high);
/* Set *which to the index of the option's value in `words` (NULL-terminated); unchanged if the option was not
 * given. False, after a message that lists the words, for any other value. */
bool cli_choose(const cli_request *request, const char *flag, const char *const *words, int *which);
/* Print "figure: file" on stdout if writing succeeded, unless --quiet was given or the result goes to stdout.
 * Returns `status`. */
saltus_status cli_tell_written(const cli_request *request, const char *what, saltus_status status);
/* Print the motion as text, or with --json as one JSON object. */
void cli_print_motion(const cli_request *request, const cli_setup *setup, const saltus_motion *motion);
/* The options of classification, with a progress line if progress is shown. */
saltus_classify_options cli_classify_options(const cli_request *request);
/* Whether progress is shown: on a terminal, without --quiet. */
bool cli_shows_progress(const cli_request *request);
/* Wipe the progress line of cli_classify_options. */
void cli_progress_end(const cli_request *request);
/* Flush stdout; CLI_FAILED with a message if it could not be written. */
int cli_finish(void);

/* origin.c: the origin of a command's results, for their files, with its storage. */
typedef struct cli_origin {
    saltus_origin told;
    char *command, *scene;
    char date[32];
} cli_origin;

/* The command line, the scene's text and the time, which is that of SOURCE_DATE_EPOCH (seconds since 1970) if
 * set. A scene from standard input, or whose file has gone, has no text. To be released. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status cli_origin_new(const cli_request *request, cli_origin *origin, saltus_message *message);
void cli_origin_clear(cli_origin *origin);

#endif
