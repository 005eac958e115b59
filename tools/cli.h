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
    CLI_LIST_MAX = 256,   /* files, settings, ... of one option */
    CLI_OPTIONS_MAX = 64, /* of one command */
    CLI_WORDS_MAX = 1024
};

/* An option that is on the command line, with its values; of a flag the one value is the flag. */
typedef struct cli_list {
    const char *flag;
    const char *items[CLI_LIST_MAX];
    int count;
} cli_list;

typedef struct cli_command cli_command;
typedef struct cli_setup cli_setup;

/* What the command line says. */
typedef struct cli_request {
    const cli_command *command;
    const char *scene; /* the first of the inputs */
    const char *inputs[CLI_LIST_MAX];
    int input_count;
    /* What the library is told, with the defaults of its tables; flows end at the program's flag for signals.
     */
    saltus_flow_options flow;
    saltus_orbit_options orbit;
    saltus_harvest_options harvest;
    saltus_branch_options branch;
    saltus_classify_options classify;
    saltus_lyapunov_options lyapunov;
    saltus_spectrum_options spectrum;
    saltus_sweep_options sweep;
    saltus_figure_options look; /* a command finds all that is asked of figures here */
    cli_list given[CLI_OPTIONS_MAX];
    int given_count;
    bool help;
    const char *output; /* where the result is made: the file of -o, or what is copied to standard output */
    bool to_stdout;
    const char *words[CLI_WORDS_MAX]; /* of the command line, but for what the results do not depend on */
    int word_count;
} cli_request;

/* Of the first three kinds an option is given once. The keys of a CLI_KEYS option and of --set, what stands
 * before '=', are given once each; so are the texts of a CLI_LIST option and of a CLI_FILES option. The last
 * two kinds take all up to the next option, --set what is key=value. */
typedef enum cli_kind { CLI_FLAG, CLI_TEXT, CLI_WHOLE, CLI_KEYS, CLI_LIST, CLI_SETTINGS, CLI_FILES } cli_kind;

/* An option of the command line alone: it gives the parser, the range check, the default and a line of the
 * help. */
typedef struct cli_option {
    const char *name; /* "--seeds" */
    cli_kind kind;
    const char *argument; /* how the value is called in --help; NULL for a flag */
    const char *help;
    double fallback, min, max; /* of a whole number, which has no default where that lies below the least */
} cli_option;

#define CLI_OPTION(name, kind, argument, help)                                                               \
    { name, kind, argument, help, 0, 0, 0 }

/* Options of the library that a command takes, all those of a table that have a flag. The member of the
 * request that they go to, and flags that the command does not take. An option of several tables goes to all
 * of them; a command's own option of the same flag goes before. */
typedef struct cli_table {
    const saltus_option_table *options;
    size_t offset;
    const char *without; /* "--measure --lanes", or NULL */
} cli_table;
#define CLI_TABLE(table, member, without)                                                                    \
    { &table, offsetof(cli_request, member), without }

/* An example, which works as typed where those before it have run. */
typedef struct cli_example {
    const char *line, *what; /* without "saltus"; what it does */
} cli_example;

/* One subcommand. */
struct cli_command {
    const char *name;
    const char *summary; /* "find one periodic orbit", behind the name */
    const char *usage;   /* what follows the name */
    const char *help;    /* paragraphs, one in a line */
    const char *notes;   /* likewise: what its results mean; NULL: nothing more to say */
    bool needs_scene;
    bool together;                    /* several ranks share its work */
    int inputs;                       /* how many files it takes; 0: one */
    const char *const *endings;       /* that the file of -o may have, NULL-terminated; NULL: no such file */
    const char *kind;                 /* of its HDF5 files and tables, as saltus_file_identify tells it;
                                         NULL: that of the first input */
    bool resumes;                     /* goes on with an interrupted run */
    const cli_table *tables;          /* the last without options; NULL: none */
    const cli_option *const *options; /* its own; NULL-terminated; --quiet, with -o --force, and
                                         --format where it need not be HDF5, go without saying */
    const cli_example *examples;      /* the last without a line */
    const char *see;                  /* commands that go with it: "plot export" */
    int (*run)(const cli_request *request);
    /* In place of `run`: what is done with a scene that has been built. *cut, where it is set, says what is
     * there of a run that was interrupted. */
    saltus_status (*work)(const cli_request *request, cli_setup *setup, const char **cut,
                          saltus_message *message);
};

extern const cli_command cmd_classify, cmd_diagnose, cmd_simulate, cmd_scenes, cmd_check, cmd_orbit,
    cmd_continue, cmd_lyapunov, cmd_plot, cmd_spectrum, cmd_sweep, cmd_basins, cmd_export, cmd_paper;

extern const cli_option cli_set, cli_section, cli_json, cli_output, cli_from, cli_resume, cli_force, cli_size,
    cli_no_heading, cli_title, cli_keep_script, cli_swap, cli_log;

/* Endings of figures; of figures that may be tables; of records. */
extern const char *const cli_figures[], *const cli_figures_or_table[], *const cli_records[];

/* What every command that draws can be told of its figure. */
#define CLI_FIGURE_OPTIONS &cli_size, &cli_no_heading, &cli_title, &cli_keep_script

/* What most subcommands work on. */
struct cli_setup {
    saltus_scene scene; /* with all --set applied */
    saltus_system *system;
    saltus_start start; /* the motion of --from; without it, or where that tells no state, its state is the
                           initial one and `dimension` is 0 */
};

/* One option of a command, whoever it belongs to. */
typedef struct cli_entry {
    const char *flag, *argument, *help; /* argument NULL: it takes no value */
    const cli_option *own;              /* NULL: one of the library */
    const saltus_option *option;        /* NULL: the command line's own */
} cli_entry;

/* The options of a command one after the other: its own, those of the library, those that go without saying.
 * False when there is none of that number. */
bool cli_entry_at(const cli_command *command, int number, cli_entry *entry);
/* Fill a request from the arguments after the subcommand; false after a message on stderr. */
bool cli_parse(const cli_command *command, int count, char **arguments, cli_request *request);
/* The values of an option on the command line, whoever it belongs to; none where it is not there. */
const cli_list *cli_values(const cli_request *request, const char *flag);
bool cli_given(const cli_request *request, const char *flag);
/* Its only value; NULL where it is not there. */
const char *cli_text(const cli_request *request, const char *flag);
/* The whole number of a command's own option, or its default. */
long cli_whole(const cli_request *request, const char *flag);
/* Run a command whose arguments have been parsed, once it is certain that it may write where it is to. The
 * exit code. */
int cli_run(const cli_command *command, cli_request *request);
/* The exit code that belongs to a status. */
int cli_code(saltus_status status);
/* "saltus: ..." on stderr, of a failure after a signal that it was interrupted; returns the exit code that
 * belongs to the status. */
int cli_report(saltus_status status, const saltus_message *message);
/* The same, but what has gone wrong by itself is told as such, whether there was a signal or not. */
int cli_report_cause(saltus_status status, const saltus_message *message);
/* Build what the command line names: with --from, parameters and stops are those of the orbit file where
 * --set does not say otherwise. On success it is to be cleared; otherwise the message has been
 * printed and the exit code is returned. */
int cli_build(const cli_request *request, cli_setup *setup);
/* Release what a setup holds. A zeroed one is accepted. */
void cli_clear(cli_setup *setup);
/* Whether --from has told a periodic orbit, and with a state on it. */
bool cli_names_orbit(const cli_setup *setup);
bool cli_on_orbit(const cli_setup *setup);
/* The motion that a command is about: with --from a periodic orbit this very orbit, stable or not, polished
 * at the parameters that hold; otherwise what the start settles on. To be cleared. Errors: those of
 * saltus_orbit_find (a start that is no orbit is SALTUS_BAD_INPUT) and of saltus_classify. Where the orbit
 * has a period of its own the setup's system becomes one that counts by its returns. */
saltus_status cli_motion(const cli_request *request, cli_setup *setup, const saltus_classify_options *how,
                         saltus_motion *motion, saltus_message *message);
/* The same where --from names an orbit: SALTUS_BAD_INPUT if what it leads to is none. */
saltus_status cli_orbit(const cli_request *request, cli_setup *setup, const saltus_classify_options *how,
                        saltus_motion *motion, saltus_message *message);
/* A scene by its name: a file, a built-in one, or - for standard input. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY. */
saltus_status cli_read_scene(const char *name, saltus_scene *scene, saltus_message *message);
/* The scene with all --set applied. */
saltus_status cli_load_scene(const cli_request *request, saltus_scene *scene, saltus_message *message);
/* Apply all --set to a scene. */
saltus_status cli_apply_settings(const cli_request *request, saltus_scene *scene, saltus_message *message);
/* A line on stderr that begins with "saltus: "; returns `code`. */
__attribute__((format(printf, 2, 3))) int cli_refuse(int code, const char *format, ...);
/* "key=low:high"; false after a message that names the option. */
bool cli_parse_range(const char *flag, const char *text, char key[SALTUS_KEY_MAX], double *low, double *high);
/* Which of the words (NULL-terminated) the option's value is; *which stays as it is where it is not there.
 * False after a message that lists the words. */
bool cli_choose(const cli_request *request, const char *flag, const char *const *words, int *which);
/* "figure: file" on stdout where writing it went well, unless --quiet says otherwise or the result itself
 * goes there. Returns `status`, how that went. */
saltus_status cli_tell_written(const cli_request *request, const char *what, saltus_status status);
bool cli_ends_in(const char *path, const char *ending);
/* The motion as text, or as one JSON object where --json asks for that. */
void cli_print_motion(const cli_request *request, const cli_setup *setup, const saltus_motion *motion);
/* With the progress line of a settling motion, where one is shown. */
saltus_classify_options cli_classify_options(const cli_request *request);
/* Whether progress is shown: on a terminal, without --quiet. */
bool cli_shows_progress(const cli_request *request);
/* Wipe the progress line of cli_classify_options. */
void cli_progress_end(const cli_request *request);
/* Flush stdout; CLI_FAILED with a message if it could not be written. */
int cli_finish(void);

#endif
