/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "progress.h"
#include "ranks.h"
#include "scene/scene.h"
#include "target.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const cli_option cli_set =
    CLI_SETTINGS_OPTION("--set", settings, "key=value ...", "change parameters of the scene");
const cli_option cli_section = CLI_TEXT_OPTION(
    "--section", section, "section",
    "what an orbit without forcing returns to, for scenes of equations: maxima, \"impact: 1, side: lower\" "
    "or "
    "\"zero: x - 1, direction: up\"; the scene's own unless given, else maxima of the observed displacement");
const cli_option cli_json = CLI_FLAG_OPTION("--json", json, "one JSON object on stdout");
const cli_option cli_output =
    CLI_TEXT_OPTION("-o", output, "file", "where the result goes; - is standard output (not for HDF5)");
const cli_option cli_resume =
    CLI_FLAG_OPTION("--resume", resume, "go on with the interrupted run in the file of -o");
const cli_option cli_force = CLI_FLAG_OPTION(
    "--force", force, "replace what is there, also an interrupted run or another kind of file");
const cli_option cli_from = CLI_TEXT_OPTION(
    "--from", from, "orbit",
    "start from this orbit: file.json, branch.h5:12 (row), branch.h5:PD1, sweep.h5:12 or basins.h5:12");

const char *const cli_figures[] = {".png", ".pdf", ".svg", NULL};
const char *const cli_figures_or_table[] = {".png", ".pdf", ".svg", ".csv", NULL};
const char *const cli_records[] = {".h5", ".csv", NULL};

static const cli_option quiet =
    CLI_FLAG_OPTION("--quiet", quiet, "no progress line, and no word on what was written");
static const cli_option format = CLI_TEXT_OPTION("--format", format, "ending",
                                                 "with -o -: png, pdf, svg or csv, as far as -o can have it");

int cli_refuse(int code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("saltus: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return code;
}

/* Whether a list of flags with blanks between them has the flag. */
static bool lists(const char *flags, const char *flag) {
    size_t length = strlen(flag);
    for (const char *at = flags; at && (at = strstr(at, flag)); at += length)
        if ((at == flags || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return true;
    return false;
}

static bool takes(const cli_table *table, const saltus_option *option) {
    return option->flag && !lists(table->without, option->flag);
}

/* Whether the option of the library is hidden by an own one or by one of an earlier table. */
static bool is_hidden(const cli_command *command, const saltus_option *option) {
    for (int k = 0; command->options[k]; k++)
        if (strcmp(command->options[k]->name, option->flag) == 0)
            return true;
    for (const cli_table *table = command->tables; table->options; table++)
        for (int k = 0; k < table->options->count; k++) {
            const saltus_option *other = &table->options->options[k];
            if (other == option)
                return false;
            if (takes(table, other) && strcmp(other->flag, option->flag) == 0)
                return true;
        }
    return false;
}

/* Whether -o can have an ending of which the file can be written from begin to end. */
static bool can_be_piped(const cli_command *command) {
    int k = 0;
    while (command->endings && command->endings[k] && strcmp(command->endings[k], ".h5") == 0)
        k++;
    return command->endings && command->endings[k];
}

bool cli_entry_at(const cli_command *command, int number, cli_entry *entry) {
    const cli_option *const common[] = {&quiet, command->endings ? &cli_force : NULL,
                                        can_be_piped(command) ? &format : NULL, NULL};
    const cli_option *own = NULL;
    for (int k = 0; !own && command->options[k]; k++)
        own = number-- == 0 ? command->options[k] : NULL;
    for (const cli_table *table = command->tables; !own && table && table->options; table++)
        for (int k = 0; k < table->options->count; k++) {
            const saltus_option *o = &table->options->options[k];
            if (takes(table, o) && !is_hidden(command, o) && number-- == 0) {
                *entry = (cli_entry){o->flag, o->argument, o->field.meaning, NULL, o};
                return true;
            }
        }
    for (int k = 0; !own && common[k]; k++)
        own = number-- == 0 ? common[k] : NULL;
    if (own)
        *entry = (cli_entry){own->name, own->argument, own->help, own, NULL};
    return own != NULL;
}

/* Nothing twice: no key, what stands before '=', no text. */
static bool parse_list_item(const cli_option *option, const char *text, cli_list *list) {
    const bool keyed = option->kind == CLI_KEYS || option->kind == CLI_SETTINGS;
    const size_t length = keyed ? strcspn(text, "=") : strlen(text);
    if (list->count == CLI_LIST_MAX)
        return cli_refuse(false, "%s %s: only %d can be given", option->name, text, CLI_LIST_MAX);
    for (int k = 0; k < list->count; k++) {
        const char *other = list->items[k];
        if (strncmp(text, other, length) == 0 && (other[length] == '\0' || (keyed && other[length] == '=')))
            return cli_refuse(false, "%s %s: %.*s is given twice", option->name, text, (int)length, text);
    }
    list->items[list->count++] = text;
    return true;
}

const cli_option cli_size =
    CLI_TEXT_OPTION("--size", size, "WxH",
                    "on paper, with type of 8 pt: column (85 mm wide), two-columns (175 mm), W or WxH in mm");
const cli_option cli_no_heading =
    CLI_FLAG_OPTION("--no-heading", look.no_heading, "panels and legends alone, no words above them");
const cli_option cli_title =
    CLI_TEXT_OPTION("--title", look.title, "text", "heading in place of the figure's own; \"\": none");
const cli_option cli_keep_script =
    CLI_TEXT_OPTION("--keep-script", look.script, "file.gp", "keep gnuplot's script, with the data in it");

static bool parse_value(const cli_option *option, const char *text, cli_request *request) {
    char *place = (char *)request + option->offset, *end = NULL;
    if (option->kind == CLI_TEXT) {
        *(const char **)(void *)place = text;
        return true;
    }
    if (option->kind >= CLI_KEYS)
        return parse_list_item(option, text, (cli_list *)(void *)place);
    double value = strtod(text, &end);
    bool number = end != text && *end == '\0' && isfinite(value);
    if (!number || value != floor(value) || value < option->min || value > option->max)
        return cli_refuse(false, "%s %s: must be a whole number from %.10g to %.10g", option->name, text,
                          option->min, option->max);
    *(long *)(void *)place = (long)value;
    return true;
}

/* Whole numbers may be written as 1e6, too. */
static bool read_member(const saltus_option *option, const char *text, void *record) {
    char *end = NULL;
    if (saltus_field_read(&option->field, text, record))
        return saltus_option_admits(option, record);
    double value = strtod(text, &end);
    return !option->field.words && end != text && *end == '\0' && isfinite(value) &&
           saltus_field_set_number(&option->field, value, record) && saltus_option_admits(option, record);
}

static bool refuse_member(const saltus_option *option, const char *text) {
    char demand[SALTUS_FIELD_TEXT_MAX];
    const char *kind = option->field.words                 ? ""
                       : option->field.type == SALTUS_REAL ? "a number "
                                                           : "a whole number ";
    const char *what = saltus_option_demand(option, demand) + strlen("must be ");
    const char *zero = strncmp(what, "0 or ", 5) == 0 ? "0 or " : "";
    const char *of = *kind && strncmp(what, "at least ", 9) == 0 ? "of " : "";
    return cli_refuse(false, "%s %s: must be %s%s%s%s", option->flag, text, zero, kind, of,
                      what + strlen(zero));
}

/* Into all tables of the command that have the option. */
static bool set_members(const cli_command *command, const char *flag, const char *text,
                        cli_request *request) {
    for (const cli_table *table = command->tables; table->options; table++)
        for (int k = 0; k < table->options->count; k++) {
            const saltus_option *o = &table->options->options[k];
            if (!takes(table, o) || strcmp(o->flag, flag) != 0)
                continue;
            if (!read_member(o, text, (char *)request + table->offset))
                return refuse_member(o, text);
        }
    return true;
}

static void set_defaults(const cli_command *command, cli_request *request) {
    *request = (cli_request){.command = command,
                             .flow = saltus_flow_defaults(),
                             .orbit = saltus_orbit_defaults(),
                             .harvest = saltus_harvest_defaults(),
                             .branch = saltus_branch_defaults(),
                             .classify = saltus_classify_defaults(),
                             .lyapunov = saltus_lyapunov_defaults(),
                             .spectrum = saltus_spectrum_defaults(),
                             .sweep = saltus_sweep_defaults(),
                             .look = saltus_figure_defaults()};
    saltus_flow_options *const flows[] = {
        &request->flow,          &request->orbit.flow,    &request->harvest.flow, &request->branch.orbit.flow,
        &request->classify.flow, &request->spectrum.flow, &request->sweep.flow,   &request->lyapunov.flow};
    for (size_t k = 0; k < sizeof flows / sizeof flows[0]; k++)
        flows[k]->stop = interrupt_flag();
    for (int k = 0; command->options[k]; k++)
        if (command->options[k]->kind == CLI_WHOLE)
            *(long *)(void *)((char *)request + command->options[k]->offset) =
                (long)command->options[k]->fallback;
}

/* The number of an option of the command; false when it has none of that name. */
static bool find_entry(const cli_command *command, const char *flag, int *number, cli_entry *entry) {
    for (*number = 0; cli_entry_at(command, *number, entry); ++*number)
        if (strcmp(entry->flag, flag) == 0)
            return true;
    return false;
}

bool cli_given(const cli_request *request, const char *flag) {
    cli_entry entry;
    int number;
    return find_entry(request->command, flag, &number, &entry) && request->given >> number & 1;
}

/* Take one option and its value; returns the number of arguments used, 0 after a message. */
static int take_option(const cli_command *command, int count, char **arguments, cli_request *request) {
    const char *name = arguments[0];
    cli_entry entry;
    int number, taken = 0;
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
        request->help = true;
        return 1;
    }
    if (!find_entry(command, name, &number, &entry))
        return cli_refuse(0, "%s: unknown option of saltus %s; see saltus %s --help", name, command->name,
                          command->name);
    const cli_option *own = entry.own;
    if (request->given >> number & 1 && !(own && own->kind >= CLI_KEYS))
        return cli_refuse(0, "%s: is given twice", name);
    request->given |= 1ull << number;
    if (own && own->kind == CLI_FLAG) {
        *(bool *)((char *)request + own->offset) = true;
        return 1;
    }
    const bool sets = own && own->kind == CLI_SETTINGS;
    if (sets && (count < 2 || arguments[1][0] == '-' || !strchr(arguments[1], '=')))
        return cli_refuse(0, "--set%s%s: must be followed by key=value", count > 1 ? " " : "",
                          count > 1 ? arguments[1] : "");
    if (count < 2)
        return cli_refuse(0, "%s: needs a value (%s)", name, entry.argument);
    if (!own)
        return set_members(command, name, arguments[1], request) ? 2 : 0;
    do
        if (!parse_value(own, arguments[1 + taken++], request))
            return 0;
    while (own->kind >= CLI_SETTINGS && 1 + taken < count && arguments[1 + taken][0] != '-' &&
           (!sets || strchr(arguments[1 + taken], '=')));
    return 1 + taken;
}

/* An argument without an option: the scene, or one of the files. */
static bool take_input(const cli_command *command, const char *text, cli_request *request) {
    int room = command->inputs ? command->inputs : 1;
    if (request->input_count < room) {
        request->inputs[request->input_count++] = text;
        return true;
    }
    if (command->inputs)
        return cli_refuse(false, "%s: only %d files can be given", text, room);
    return cli_refuse(false, "%s: unexpected; the scene is already %s", text, request->inputs[0]);
}

/* Options that change how a run goes and where its results go, not the results. */
static bool goes_without_saying(const cli_command *command, const char *flag) {
    static const cli_option *const own[] = {&cli_output, &cli_json, &cli_resume, &cli_force, &quiet, &format};
    cli_entry entry;
    int number;
    bool found = find_entry(command, flag, &number, &entry) && entry.option && entry.option->apart;
    for (size_t k = 0; k < sizeof own / sizeof own[0] && !found; k++)
        found = strcmp(flag, own[k]->name) == 0;
    return found;
}

static void keep_words(cli_request *request, int count, char **words) {
    for (int k = 0; k < count && request->word_count < CLI_WORDS_MAX; k++)
        request->words[request->word_count++] = words[k];
}

bool cli_parse(const cli_command *command, int count, char **arguments, cli_request *request) {
    set_defaults(command, request);
    for (int k = 0; k < count;) {
        if (arguments[k][0] == '-' && arguments[k][1] != '\0') {
            int used = take_option(command, count - k, arguments + k, request);
            if (used == 0)
                return false;
            if (!goes_without_saying(command, arguments[k]))
                keep_words(request, used, arguments + k);
            k += used;
            continue;
        }
        keep_words(request, 1, arguments + k);
        if (!take_input(command, arguments[k++], request))
            return false;
    }
    request->scene = request->inputs[0];
    if (command->needs_scene && !request->scene && !request->help)
        return cli_refuse(false, "%s: needs a scene, a YAML file or one of `saltus scenes`", command->name);
    return true;
}

/* "column", "two-columns", "W" or "WxH". */
static bool read_size(const char *text, double *width, double *height) {
    static const struct {
        const char *word;
        double width;
    } words[] = {{"column", 85}, {"two-columns", 175}};
    char *end = NULL;
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        if (strcmp(text, words[k].word) == 0) {
            *width = words[k].width;
            return true;
        }
    *width = strtod(text, &end);
    if (end != text && *end == 'x' && isdigit((unsigned char)end[1])) {
        *height = strtod(end + 1, &end);
        if (!(*height > 0))
            return false;
    }
    bool hexadecimal = text[0] == '0' && text[1] == 'x';
    return isdigit((unsigned char)text[0]) && !hexadecimal && *end == '\0' && *width > 0 &&
           isfinite(*width) && isfinite(*height);
}

/* How a figure is laid out, with the options that are not members of its own; false after a message. */
static bool choose_look(cli_request *request) {
    saltus_figure_options *look = &request->look;
    look->logarithmic = request->logarithmic.items;
    look->logarithmic_count = request->logarithmic.count;
    if (request->size && !read_size(request->size, &look->width, &look->height))
        return cli_refuse(false, "--size %s: must be column, two-columns, W or WxH in mm, such as 85x60",
                          request->size);
    for (int k = 0; k < look->logarithmic_count; k++)
        if (!isalpha((unsigned char)look->logarithmic[k][0]) || strpbrk(look->logarithmic[k], "~=:,. "))
            return cli_refuse(false, "--log %s: must be a parameter or what is shown, such as omega or speed",
                              look->logarithmic[k]);
    if (look->script && !cli_ends_in(look->script, ".gp"))
        return cli_refuse(false, "--keep-script %s: the ending must be .gp", look->script);
    saltus_message message = {.text = ""};
    const char *output = request->output;
    bool drawn =
        output && (cli_ends_in(output, ".png") || cli_ends_in(output, ".pdf") || cli_ends_in(output, ".svg"));
    const char *given = request->size      ? "--size"
                        : look->script     ? "--keep-script"
                        : look->title      ? "--title"
                        : look->no_heading ? "--no-heading"
                                           : NULL;
    if (!drawn && given && (!output || cli_ends_in(output, ".csv")))
        return cli_refuse(false, "%s: there is no figure: -o file.png, file.pdf or file.svg is needed",
                          given);
    if (!drawn || saltus_figure_check(output, look, &message) == SALTUS_OK)
        return true;
    return cli_refuse(false, "%s%s: %s", request->size ? "--size " : "-o ",
                      request->size ? request->size : output, message.text);
}

static int work_on_scene(const cli_command *command, const cli_request *request) {
    cli_setup setup;
    saltus_message message = {.text = ""};
    const char *cut = NULL;
    int code = cli_build(request, &setup);
    if (code != CLI_DONE)
        return code;
    saltus_status status = command->work(request, &setup, &cut, &message);
    cli_clear(&setup);
    return cut ? interrupt_report(cut) : cli_report(status, &message);
}

int cli_run(const cli_command *command, cli_request *request) {
    target out = {.descriptor = -1};
    /* What the first rank finds out holds for all. */
    int code = ranks_here() == 0 ? target_open(command, request, &out) : CLI_DONE;
    if (command->together)
        code = ranks_agree(code);
    if (code == CLI_DONE && !choose_look(request))
        code = CLI_BAD_INPUT;
    if (code == CLI_DONE)
        code = command->work ? work_on_scene(command, request) : command->run(request);
    return target_close(&out, code);
}

int cli_code(saltus_status status) {
    return status == SALTUS_OK ? CLI_DONE : status == SALTUS_BAD_INPUT ? CLI_BAD_INPUT : CLI_FAILED;
}

int cli_report_cause(saltus_status status, const saltus_message *message) {
    if (status == SALTUS_INTERRUPTED)
        return interrupt_report("there is no result yet");
    if (status != SALTUS_OK)
        fprintf(stderr, "saltus: %s\n", message->text[0] ? message->text : saltus_status_name(status));
    return cli_code(status);
}

int cli_report(saltus_status status, const saltus_message *message) {
    return cli_report_cause(status != SALTUS_OK && interrupt_asked() ? SALTUS_INTERRUPTED : status, message);
}

saltus_status cli_apply_settings(const cli_request *request, saltus_scene *scene, saltus_message *message) {
    for (int k = 0; k < request->settings.count; k++) {
        saltus_message reason = {.text = ""};
        saltus_status status = saltus_scene_set(scene, request->settings.items[k], &reason);
        if (status != SALTUS_OK)
            return saltus_fail(message, status, "--set %.100s: %.380s", request->settings.items[k],
                               reason.text);
    }
    if (request->section) {
        saltus_message reason = {.text = ""};
        saltus_status status = saltus_scene_set_section(scene, request->section, &reason);
        if (status != SALTUS_OK)
            return saltus_fail(message, status, "--section %.100s: %.380s", request->section, reason.text);
    }
    /* A title describes the scene as it was written; changed, it would contradict the parameters beside it.
     */
    size_t used = 0;
    for (int k = 0; k < request->settings.count && used + 1 < sizeof scene->title; k++)
        used += (size_t)snprintf(scene->title + used, sizeof scene->title - used, "%s%s",
                                 k ? " " : "changed: ", request->settings.items[k]);
    if (used >= sizeof scene->title)
        strcpy(scene->title + sizeof scene->title - sizeof "...", "...");
    return SALTUS_OK;
}

/* A scene from standard input. */
static saltus_status read_stdin(saltus_scene *scene, saltus_message *message) {
    enum { most = 1 << 20 };
    char *text = malloc(most);
    if (!text)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the scene");
    size_t length = fread(text, 1, most, stdin);
    saltus_status status;
    if (ferror(stdin))
        status = saltus_fail(message, SALTUS_BAD_INPUT, "standard input cannot be read: %s", strerror(errno));
    else if (length == most)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "standard input: is too long for a scene");
    else
        status = saltus_scene_parse(text, length, "stdin", scene, message);
    free(text);
    return status;
}

saltus_status cli_read_scene(const char *name, saltus_scene *scene, saltus_message *message) {
    saltus_status status =
        strcmp(name, "-") == 0 ? read_stdin(scene, message) : saltus_scene_load(name, scene, message);
    return status == SALTUS_IO ? SALTUS_BAD_INPUT : status;
}

saltus_status cli_load_scene(const cli_request *request, saltus_scene *scene, saltus_message *message) {
    saltus_status status = cli_read_scene(request->scene, scene, message);
    return status == SALTUS_OK ? cli_apply_settings(request, scene, message) : status;
}

/* The orbit of --from, and its parameters and stops where the command line does not set them. */
static saltus_status read_start(const cli_request *request, saltus_scene *scene, saltus_start *start,
                                saltus_message *message) {
    saltus_status status = saltus_start_read(request->from, start, message);
    if (status == SALTUS_OK)
        status = saltus_start_apply(start, request->from, scene, message);
    if (status == SALTUS_OK)
        status = cli_apply_settings(request, scene, message);
    if (status == SALTUS_OK && scene->initial_count && start->dimension)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "--set of an initial state is not possible with --from, which gives the state");
    return status;
}

void cli_clear(cli_setup *setup) {
    saltus_system_free(setup->system);
    saltus_start_release(&setup->start);
    saltus_scene_clear(&setup->scene);
    setup->system = NULL;
}

int cli_build(const cli_request *request, cli_setup *setup) {
    saltus_message message = {.text = ""};
    *setup = (cli_setup){.system = NULL};
    saltus_status status = cli_load_scene(request, &setup->scene, &message);
    if (status == SALTUS_OK && request->from)
        status = read_start(request, &setup->scene, &setup->start, &message);
    if (status == SALTUS_OK)
        status = saltus_system_new(&setup->scene.spec, &setup->system, &message);
    if (status == SALTUS_OK && !setup->start.dimension)
        status = saltus_scene_state(&setup->scene, setup->system, setup->start.state, &message);
    if (status != SALTUS_OK)
        cli_clear(setup);
    return cli_report(status, &message);
}

bool cli_on_orbit(const cli_setup *setup) {
    return cli_names_orbit(setup) && setup->start.dimension > 0;
}
bool cli_names_orbit(const cli_setup *setup) {
    return setup->start.periods > 0;
}

/* An orbit of --from, at the parameters that hold. */
static saltus_status orbit_of_start(const cli_request *request, const cli_setup *setup,
                                    const saltus_classify_options *how, saltus_motion *motion,
                                    saltus_message *message) {
    const saltus_start *start = &setup->start;
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_orbit orbit = {0};
    saltus_message reason = {.text = ""};
    saltus_status status;
    char period[32] = "";
    shooting.flow = how->flow;
    shooting.tolerance = fmax(shooting.tolerance, 100 * how->flow.rtol);
    if (start->own_period) {
        status = saltus_motion_cycle(setup->system, start->state, how, motion, &reason);
    } else {
        snprintf(period, sizeof period, " of period %d T", start->periods);
        status = saltus_orbit_find(setup->system, start->periods, start->state, &shooting, &orbit, &reason);
    }
    if (status == SALTUS_NO_CONVERGENCE || status == SALTUS_SINGULAR)
        status = SALTUS_BAD_INPUT;
    if (status != SALTUS_OK)
        saltus_fail(message, status, "--from %.200s: is no orbit%s here: %.200s", request->from, period,
                    reason.text);
    else if (!start->own_period)
        status = saltus_motion_describe(setup->system, &orbit, how, motion, message);
    saltus_orbit_clear(&orbit);
    return status;
}

saltus_status cli_motion(const cli_request *request, cli_setup *setup, const saltus_classify_options *how,
                         saltus_motion *motion, saltus_message *message) {
    saltus_status status;
    *motion = (saltus_motion){0};
    if (cli_on_orbit(setup)) {
        status = orbit_of_start(request, setup, how, motion, message);
    } else {
        status = saltus_classify(setup->system, setup->start.state, how, motion, message);
        cli_progress_end(request);
    }
    if (status != SALTUS_OK || motion->trivial_multiplier == 0)
        return status;
    saltus_system *counted;
    status = saltus_motion_count_returns(setup->system, &how->flow, motion, &counted, message);
    if (status == SALTUS_OK) {
        saltus_system_free(setup->system);
        setup->system = counted;
    }
    return status;
}

saltus_status cli_orbit(const cli_request *request, cli_setup *setup, const saltus_classify_options *how,
                        saltus_motion *motion, saltus_message *message) {
    saltus_status status = cli_motion(request, setup, how, motion, message);
    if (status != SALTUS_OK || motion->periods > 0)
        return status;
    status =
        saltus_fail(message, SALTUS_BAD_INPUT, "--from %.200s: is %.60s there, and comes to no orbit here",
                    request->from, setup->start.label);
    saltus_motion_clear(motion);
    return status;
}

bool cli_parse_range(const cli_option *option, const char *text, char key[SALTUS_KEY_MAX], double *low,
                     double *high) {
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : 0;
    const char *end = NULL;
    bool good = length > 0 && length < SALTUS_KEY_MAX;
    if (good) {
        memcpy(key, text, length);
        key[length] = '\0';
        end = saltus_read_number_until(equals + 1, ":", low);
        good = end && *end == ':' && saltus_read_number_until(end + 1, "", high) && *low < *high;
    }
    if (!good)
        fprintf(stderr, "saltus: %s %s: must have the form key=low:high, low below high\n", option->name,
                text);
    return good;
}

bool cli_choose(const cli_option *option, const char *text, const char *const *words, int *which) {
    int k = 0;
    while (text && words[k] && strcmp(text, words[k]) != 0)
        k++;
    if (!text || words[k]) {
        *which = text ? k : *which;
        return true;
    }
    fprintf(stderr, "saltus: %s %s: must be %s", option->name, text, words[0]);
    for (k = 1; words[k]; k++)
        fprintf(stderr, "%s%s", words[k + 1] ? ", " : " or ", words[k]);
    fputc('\n', stderr);
    return false;
}

saltus_status cli_tell_written(const cli_request *request, const char *what, saltus_status status) {
    if (status == SALTUS_OK && !request->quiet && !request->to_stdout)
        printf("%s: %s\n", what, request->output);
    return status;
}

bool cli_ends_in(const char *path, const char *ending) {
    size_t length = strlen(path), part = strlen(ending);
    return length >= part && strcmp(path + length - part, ending) == 0;
}

bool cli_shows_progress(const cli_request *request) {
    return !request->quiet && isatty(STDERR_FILENO) == 1;
}

static void show_periods(void *context, double periods, double at_most) {
    (void)context;
    progress_line("%.0f %% of at most %.0f periods", 100 * periods / at_most, at_most);
}

void cli_progress_end(const cli_request *request) {
    if (cli_shows_progress(request))
        progress_line("%s", "");
}

saltus_classify_options cli_classify_options(const cli_request *request) {
    saltus_classify_options options = request->classify;
    /* Where nobody has chosen how long to measure, it is long enough for the lifetime. */
    if (!cli_given(request, "--measure") && options.lifetime > options.measure / 4)
        options.measure = 4 * options.lifetime;
    if (cli_shows_progress(request))
        options.progress.show = show_periods;
    return options;
}

int cli_finish(void) {
    if (fflush(stdout) == 0 && !ferror(stdout))
        return CLI_DONE;
    return cli_refuse(CLI_FAILED, "standard output could not be written: %s", strerror(errno));
}
