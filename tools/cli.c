/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "progress.h"
#include "ranks.h"
#include "record/output.h"
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
    CLI_OPTION("--set", CLI_SETTINGS, "key=value ...", "change parameters of the scene");
const cli_option cli_section = CLI_OPTION(
    "--section", CLI_TEXT, "section",
    "what an orbit without forcing returns to, for scenes of equations: maxima, \"impact: 1, side: lower\" "
    "or \"zero: x - 1, direction: up\"; the scene's own unless given, else maxima of the observed "
    "displacement");
const cli_option cli_json = CLI_OPTION("--json", CLI_FLAG, NULL, "one JSON object on stdout");
const cli_option cli_output =
    CLI_OPTION("-o", CLI_TEXT, "file", "where the result goes; - is standard output (not for HDF5)");
const cli_option cli_resume =
    CLI_OPTION("--resume", CLI_FLAG, NULL, "go on with the interrupted run in the file of -o");
const cli_option cli_force = CLI_OPTION(
    "--force", CLI_FLAG, NULL, "replace what is there, also an interrupted run or another kind of file");
const cli_option cli_from = CLI_OPTION(
    "--from", CLI_TEXT, "orbit",
    "start from this orbit: file.json, branch.h5:12 (row), branch.h5:PD1, sweep.h5:12 or basins.h5:12");
/* Widths of figures by name, in mm. */
static const char *const size_words[] = {"column", "two-columns", NULL};
static const double size_widths[] = {85, 175};
const cli_option cli_size =
    CLI_CHOICE("--size", "WxH",
               "on paper, with type of 7 to 8 pt: column (85 mm wide), two-columns (175 mm), W or WxH in mm",
               size_words);
const cli_option cli_no_heading =
    CLI_OPTION("--no-heading", CLI_FLAG, NULL, "panels and legends alone, no words above them");
const cli_option cli_title =
    CLI_OPTION("--title", CLI_TEXT, "text", "heading in place of the figure's own; \"\": none");
const cli_option cli_keep_script =
    CLI_OPTION("--keep-script", CLI_TEXT, "file.gp", "keep gnuplot's script, with the data in it");
const cli_option cli_swap = CLI_OPTION("--swap", CLI_FLAG, NULL, "exchange the axes");
const cli_option cli_log = CLI_OPTION(
    "--log", CLI_LIST, "key", "logarithmic axis: a parameter or what is shown (speed, ...); may be repeated");

const char *const cli_figures[] = {".png", ".pdf", ".svg", NULL};
const char *const cli_figures_or_table[] = {".png", ".pdf", ".svg", ".csv", NULL};
const char *const cli_records[] = {".h5", ".csv", NULL};

static const cli_option quiet =
    CLI_OPTION("--quiet", CLI_FLAG, NULL, "no progress line, and no word on what was written");
static const cli_option format =
    CLI_OPTION("--format", CLI_TEXT, "ending", "with -o -: png, pdf, svg or csv, as far as -o can have it");

int cli_refuse(int code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("saltus: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return code;
}

/* Whether a list of flags, separated by blanks, contains the flag. */
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

/* Whether a library option is hidden by the command's own option, or by one of an earlier table, with the
 * same flag. */
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

bool cli_entry_at(const cli_command *command, int number, cli_entry *entry) {
    /* Whether -o accepts a format that can be written sequentially, so not only HDF5. */
    bool piped = false;
    for (int k = 0; command->endings && command->endings[k]; k++)
        piped |= strcmp(command->endings[k], ".h5") != 0;
    const cli_option *const common[] = {&quiet, command->endings ? &cli_force : NULL, piped ? &format : NULL,
                                        NULL};
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

/* Set the value of a library option in all tables of the command that have it. Whole numbers may be written
 * like 1e6. */
static bool set_members(const saltus_option *option, const char *text, cli_request *request) {
    for (const cli_table *table = request->command->tables; table->options; table++)
        for (int k = 0; k < table->options->count; k++) {
            const saltus_option *o = &table->options->options[k];
            void *record = (char *)request + table->offset;
            char *end = NULL, demand[SALTUS_FIELD_TEXT_MAX];
            if (!takes(table, o) || strcmp(o->flag, option->flag) != 0)
                continue;
            const double value = strtod(text, &end);
            const bool number = !o->field.words && end != text && *end == '\0' && isfinite(value);
            if ((saltus_field_read(&o->field, text, record) ||
                 (number && saltus_field_set_number(&o->field, value, record))) &&
                saltus_option_admits(o, record))
                continue;
            const char *kind = o->field.words                 ? ""
                               : o->field.type == SALTUS_REAL ? "a number "
                                                              : "a whole number ";
            const char *what = saltus_option_demand(o, demand) + strlen("must be ");
            const char *zero = strncmp(what, "0 or ", 5) == 0 ? "0 or " : "";
            const char *of = *kind && strncmp(what, "at least ", 9) == 0 ? "of " : "";
            return cli_refuse(false, "%s %s: must be %s%s%s%s", o->flag, text, zero, kind, of,
                              what + strlen(zero));
        }
    return true;
}

const cli_list *cli_values(const cli_request *request, const char *flag) {
    static const cli_list none = {.count = 0};
    for (int k = 0; k < request->given_count; k++)
        if (strcmp(request->given[k].flag, flag) == 0)
            return &request->given[k];
    return &none;
}

bool cli_given(const cli_request *request, const char *flag) {
    return cli_values(request, flag)->count > 0;
}

const char *cli_text(const cli_request *request, const char *flag) {
    return cli_values(request, flag)->items[0];
}

long cli_whole(const cli_request *request, const char *flag) {
    const char *text = cli_text(request, flag);
    const cli_option *const *own = request->command->options;
    while (!text && strcmp((*own)->name, flag) != 0)
        own++;
    return (long)(text ? strtod(text, NULL) : (*own)->fallback);
}

/* Check a value and append it to its option's values. Repeated values are refused; of key=value only the key
 * counts. */
static bool add_value(const cli_option *own, const char *text, cli_list *list) {
    const bool keyed = own && (own->kind == CLI_KEYS || own->kind == CLI_SETTINGS);
    const size_t length = keyed ? strcspn(text, "=") : strlen(text);
    char *end = NULL;
    double value = own && own->kind == CLI_WHOLE ? strtod(text, &end) : 0;
    if (end && (end == text || *end || !(value == floor(value)) || value < own->min || value > own->max))
        return cli_refuse(false, "%s %s: must be a whole number from %.10g to %.10g", own->name, text,
                          own->min, own->max);
    if (list->count == CLI_LIST_MAX)
        return cli_refuse(false, "%s %s: only %d can be given", list->flag, text, CLI_LIST_MAX);
    for (int k = 0; k < list->count; k++) {
        const char *other = list->items[k];
        if (strncmp(text, other, length) == 0 && (other[length] == '\0' || (keyed && other[length] == '=')))
            return cli_refuse(false, "%s %s: %.*s is given twice", list->flag, text, (int)length, text);
    }
    list->items[list->count++] = text;
    return true;
}

static void keep_words(cli_request *request, int count, const char *const *words) {
    for (int k = 0; k < count && request->word_count < CLI_WORDS_MAX; k++)
        request->words[request->word_count++] = words[k];
}

/* Process one option with its values; returns the number of arguments used, 0 after a message. */
static int take_option(int count, const char *const *arguments, cli_request *request) {
    /* Options that do not affect the results, only how the run proceeds and where its results go. */
    static const char apart[] = "-o --json --resume --force --quiet --format";
    const cli_command *command = request->command;
    const char *name = arguments[0];
    cli_entry entry;
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
        request->help = true;
        return 1;
    }
    int number = 0;
    while (cli_entry_at(command, number, &entry) && strcmp(entry.flag, name) != 0)
        number++;
    if (!cli_entry_at(command, number, &entry))
        return cli_refuse(0, "%s: unknown option of saltus %s; see saltus %s --help", name, command->name,
                          command->name);
    const cli_option *own = entry.own;
    int place = 0, used = 0;
    while (place < request->given_count && strcmp(request->given[place].flag, name) != 0)
        place++;
    if (place < request->given_count && !(own && own->kind >= CLI_KEYS))
        return cli_refuse(0, "%s: is given twice", name);
    request->given_count += place == request->given_count;
    cli_list *list = &request->given[place];
    list->flag = entry.flag;
    const bool flag = own && own->kind == CLI_FLAG, sets = own && own->kind == CLI_SETTINGS;
    if (sets && (count < 2 || arguments[1][0] == '-' || !strchr(arguments[1], '=')))
        return cli_refuse(0, "--set%s%s: must be followed by key=value", count > 1 ? " " : "",
                          count > 1 ? arguments[1] : "");
    if (!flag && count < 2)
        return cli_refuse(0, "%s: needs a value (%s)", name, entry.argument);
    if (!own && !set_members(entry.option, arguments[1], request))
        return 0;
    used = flag ? 0 : 1;
    do
        if (!add_value(own, arguments[used++], list))
            return 0;
    while (own && own->kind >= CLI_SETTINGS && used < count && arguments[used][0] != '-' &&
           (!sets || strchr(arguments[used], '=')));
    if (!lists(apart, name) && !(entry.option && entry.option->apart))
        keep_words(request, used, arguments);
    return used;
}

bool cli_parse(const cli_command *command, int count, const char *const *arguments, cli_request *request) {
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
    const int room = command->inputs ? command->inputs : 1;
    for (int k = 0, used = 1; k < count; k += used) {
        const char *word = arguments[k];
        used = word[0] == '-' && word[1] != '\0' ? take_option(count - k, arguments + k, request) : -1;
        if (used == 0)
            return false;
        if (used > 0)
            continue;
        /* The scene, or an input file. */
        used = 1;
        keep_words(request, 1, arguments + k);
        for (int other = 0; other < request->input_count && command->inputs; other++)
            if (strcmp(word, request->inputs[other]) == 0)
                return cli_refuse(false, "%s: is given twice", word);
        if (request->input_count == room && command->inputs)
            return cli_refuse(false, "%s: only %d files can be given", word, room);
        if (request->input_count == room)
            return cli_refuse(false, "%s: unexpected; the %s is already %s", word,
                              command->needs_scene ? "scene" : "file", request->inputs[0]);
        request->inputs[request->input_count++] = word;
    }
    request->scene = request->inputs[0];
    request->output = cli_text(request, "-o");
    if (command->needs_scene && !request->scene && !request->help)
        return cli_refuse(false, "%s: needs a scene, a YAML file or one of `saltus scenes`", command->name);
    return true;
}

/* Set the layout of figures from the options; false after a message. */
static bool choose_look(cli_request *request) {
    saltus_figure_options *look = &request->look;
    const cli_list *logarithmic = cli_values(request, "--log");
    const char *size = cli_text(request, "--size"), *output = request->output;
    bool sized = true;
    look->no_heading = cli_given(request, "--no-heading");
    look->title = cli_text(request, "--title");
    look->script = cli_text(request, "--keep-script");
    look->swap = cli_given(request, "--swap");
    look->logarithmic = logarithmic->items;
    look->logarithmic_count = logarithmic->count;
    int named = 0;
    while (size && size_words[named] && strcmp(size, size_words[named]) != 0)
        named++;
    if (size && size_words[named])
        look->width = size_widths[named];
    else if (size) { /* W or WxH */
        char *end = NULL;
        const bool hexadecimal = size[0] == '0' && size[1] == 'x';
        look->width = strtod(size, &end);
        sized = end != size && look->width > 0 && isfinite(look->width);
        if (sized && *end == 'x' && isdigit((unsigned char)end[1])) {
            look->height = strtod(end + 1, &end);
            sized = look->height > 0 && isfinite(look->height);
        }
        sized = sized && isdigit((unsigned char)size[0]) && !hexadecimal && *end == '\0';
    }
    if (!sized)
        return cli_refuse(false, "--size %s: must be column, two-columns, W or WxH in mm, such as 85x100",
                          size);
    for (int k = 0; k < look->logarithmic_count; k++)
        if (!isalpha((unsigned char)look->logarithmic[k][0]) || strpbrk(look->logarithmic[k], "~=:,. "))
            return cli_refuse(false, "--log %s: must be a parameter or what is shown, such as omega or speed",
                              look->logarithmic[k]);
    if (look->script && !saltus_path_ends(look->script, ".gp"))
        return cli_refuse(false, "--keep-script %s: the ending must be .gp", look->script);
    saltus_message message = {.text = ""};
    bool drawn = output && (saltus_path_ends(output, ".png") || saltus_path_ends(output, ".pdf") ||
                            saltus_path_ends(output, ".svg"));
    const char *given = size               ? "--size"
                        : look->script     ? "--keep-script"
                        : look->title      ? "--title"
                        : look->no_heading ? "--no-heading"
                                           : NULL;
    if (!drawn && given && request->command->endings && (!output || saltus_path_ends(output, ".csv")))
        return cli_refuse(false, "%s: there is no figure: -o file.png, file.pdf or file.svg is needed",
                          given);
    if (!drawn || saltus_figure_check(output, look, &message) == SALTUS_OK)
        return true;
    return cli_refuse(false, "%s%s: %s", size ? "--size " : "-o ", size ? size : output, message.text);
}

int cli_check(const cli_command *command, cli_request *request) {
    target out;
    const int code = target_open(command, request, &out);
    return code == CLI_DONE && !choose_look(request) ? CLI_BAD_INPUT : code;
}

int cli_run(const cli_command *command, cli_request *request) {
    target out = {.descriptor = -1};
    cli_setup setup;
    saltus_message message = {.text = ""};
    const char *cut = NULL;
    /* The first rank checks the files; all ranks use its outcome. */
    int code = ranks_here() == 0 ? target_open(command, request, &out) : CLI_DONE;
    if (command->together)
        code = ranks_agree(code);
    if (code == CLI_DONE && !choose_look(request))
        code = CLI_BAD_INPUT;
    if (code == CLI_DONE)
        code = command->work ? cli_build(request, &setup) : command->run(request);
    if (code == CLI_DONE && command->work) {
        saltus_status status = command->work(request, &setup, &cut, &message);
        cli_clear(&setup);
        code = cut ? interrupt_report(cut) : cli_report(status, &message);
    }
    return target_close(&out, code);
}

int cli_report_cause(saltus_status status, const saltus_message *message) {
    if (status == SALTUS_INTERRUPTED)
        return interrupt_report("there is no result yet");
    if (status != SALTUS_OK)
        fprintf(stderr, "saltus: %s\n", message->text[0] ? message->text : saltus_status_name(status));
    return status == SALTUS_OK ? CLI_DONE : status == SALTUS_BAD_INPUT ? CLI_BAD_INPUT : CLI_FAILED;
}

int cli_report(saltus_status status, const saltus_message *message) {
    return cli_report_cause(status != SALTUS_OK && interrupt_asked() ? SALTUS_INTERRUPTED : status, message);
}

saltus_status cli_check_twice(const cli_request *request, const saltus_scene *scene, int count,
                              const char *flag, const char *later, saltus_message *message) {
    const cli_list *settings = cli_values(request, "--set");
    for (int k = 0; k < count; k++)
        if (saltus_scene_overrides(scene, later, settings->items[k]))
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%s %.100s: leaves nothing of --set %.100s, the same is given twice", flag,
                               later, settings->items[k]);
    return SALTUS_OK;
}

saltus_status cli_apply_settings(const cli_request *request, saltus_scene *scene, saltus_message *message) {
    const cli_list *settings = cli_values(request, "--set");
    const char *section = cli_text(request, "--section");
    for (int k = 0; k < settings->count + (section != NULL); k++) {
        const char *flag = k < settings->count ? "--set" : "--section";
        const char *text = k < settings->count ? settings->items[k] : section;
        saltus_message reason = {.text = ""};
        saltus_status status =
            (k < settings->count ? saltus_scene_set : saltus_scene_set_section)(scene, text, &reason);
        if (status != SALTUS_OK)
            return saltus_fail(message, status, "%s %.100s: %.380s", flag, text, reason.text);
    }
    for (int k = 1; k < settings->count; k++)
        if (cli_check_twice(request, scene, k, "--set", settings->items[k], message) != SALTUS_OK)
            return SALTUS_BAD_INPUT;
    if (section) {
        char setting[160];
        snprintf(setting, sizeof setting, "section=%s", section);
        if (cli_check_twice(request, scene, settings->count, "--section", setting, message) != SALTUS_OK)
            return SALTUS_BAD_INPUT;
    }
    /* The original title may contradict changed parameters, so the changes replace it. */
    size_t used = 0;
    for (int k = 0; k < settings->count && used + 1 < sizeof scene->title; k++)
        used += (size_t)snprintf(scene->title + used, sizeof scene->title - used, "%s%s",
                                 k ? " " : "changed: ", settings->items[k]);
    if (used >= sizeof scene->title)
        strcpy(scene->title + sizeof scene->title - sizeof "...", "...");
    return SALTUS_OK;
}

saltus_status cli_read_scene(const char *name, saltus_scene *scene, saltus_message *message) {
    enum { most = 1 << 20 };
    const bool piped = strcmp(name, "-") == 0;
    saltus_status status;
    char *text = piped ? malloc(most) : NULL;
    const size_t length = text ? fread(text, 1, most, stdin) : 0;
    if (!piped)
        status = saltus_scene_load(name, scene, message);
    else if (!text)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the scene");
    else if (ferror(stdin))
        status = saltus_fail(message, SALTUS_BAD_INPUT, "standard input cannot be read: %s", strerror(errno));
    else if (length == most)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "standard input: is too long for a scene");
    else
        status = saltus_scene_parse(text, length, "stdin", scene, message);
    free(text);
    return status == SALTUS_IO ? SALTUS_BAD_INPUT : status;
}

saltus_status cli_load_scene(const cli_request *request, saltus_scene *scene, saltus_message *message) {
    saltus_status status = cli_read_scene(request->scene, scene, message);
    return status == SALTUS_OK ? cli_apply_settings(request, scene, message) : status;
}

void cli_clear(cli_setup *setup) {
    saltus_system_free(setup->system);
    saltus_start_release(&setup->start);
    saltus_scene_clear(&setup->scene);
    setup->system = NULL;
}

int cli_build(const cli_request *request, cli_setup *setup) {
    const char *from = cli_text(request, "--from");
    saltus_scene *scene = &setup->scene;
    saltus_message message = {.text = ""};
    *setup = (cli_setup){.system = NULL};
    saltus_status status = cli_load_scene(request, scene, &message);
    if (status == SALTUS_OK && from)
        status = saltus_start_read(from, interrupt_flag(), &setup->start, &message);
    if (status == SALTUS_OK && from)
        status = saltus_start_apply(&setup->start, from, scene, &message);
    if (status == SALTUS_OK && from)
        status = cli_apply_settings(request, scene, &message);
    const int dimension = status == SALTUS_OK && from ? saltus_spec_dimension(&scene->spec, NULL) : -1;
    if (dimension >= 0 && dimension != setup->start.dimension)
        status =
            saltus_fail(&message, SALTUS_BAD_INPUT,
                        "%.200s: its orbit has N = %g and a state of %d entries, the scene N = %g and %d",
                        from, saltus_spec_get(&setup->start.spec, "N"), setup->start.dimension,
                        saltus_spec_get(&scene->spec, "N"), dimension);
    if (status == SALTUS_OK && scene->initial_count && setup->start.dimension)
        status = saltus_fail(&message, SALTUS_BAD_INPUT,
                             "--set of an initial state is not possible with --from, which gives the state");
    if (status == SALTUS_OK)
        status = saltus_system_new(&scene->spec, &setup->system, &message);
    if (status == SALTUS_OK && !setup->start.dimension)
        status = saltus_scene_state(scene, setup->system, setup->start.state, &message);
    if (status != SALTUS_OK)
        cli_clear(setup);
    return cli_report(status, &message);
}

bool cli_on_orbit(const cli_setup *setup) {
    return setup->start.periods > 0 || setup->start.rests;
}

saltus_status cli_same_orbit(const cli_request *request, const cli_setup *setup, const double *found,
                             saltus_message *message) {
    const double another = 1e-3;
    const saltus_start *start = &setup->start;
    const bool known = cli_given(request, "--from") && start->dimension > 0 && start->periods > 0 &&
                       !start->own_period && saltus_spec_equal(&start->spec, &setup->scene.spec);
    const double apart = known ? saltus_system_distance(setup->system, start->state, found) : 0;
    return apart < another
               ? SALTUS_OK
               : saltus_fail(
                     message, SALTUS_BAD_INPUT,
                     "--from %.200s: the orbit is not found again, but another one, %.2g of the state's "
                     "scale away: errors of the flow grow too much along it",
                     cli_text(request, "--from"), apart);
}

saltus_status cli_motion(const cli_request *request, cli_setup *setup, const saltus_classify_options *how,
                         saltus_motion *motion, saltus_message *message) {
    const saltus_start *start = &setup->start;
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_orbit orbit = {0};
    saltus_message reason = {.text = ""};
    saltus_status status;
    char period[32] = "";
    *motion = (saltus_motion){0};
    shooting.flow = how->flow;
    shooting.tolerance = fmax(shooting.tolerance, 100 * how->flow.rtol);
    if (!cli_on_orbit(setup)) {
        status = saltus_classify(setup->system, start->state, how, motion, message);
        cli_progress_end(request);
    } else if (start->rests)
        status = saltus_motion_equilibrium(setup->system, start->state, how, motion, &reason);
    else if (start->own_period)
        status = saltus_motion_cycle(setup->system, start->state, how, motion, &reason);
    else {
        snprintf(period, sizeof period, " of period %d T", start->periods);
        status = saltus_orbit_find(setup->system, start->periods, start->state, &shooting, &orbit, &reason);
    }
    if (cli_on_orbit(setup) && status != SALTUS_OK) {
        if (status == SALTUS_NO_CONVERGENCE || status == SALTUS_SINGULAR)
            status = SALTUS_BAD_INPUT;
        saltus_fail(message, status, "--from %.200s: is no %s%s here: %.200s", cli_text(request, "--from"),
                    start->rests ? "equilibrium" : "orbit", period, reason.text);
    } else if (period[0]) {
        status = cli_same_orbit(request, setup, orbit.state, message);
        if (status == SALTUS_OK)
            status = saltus_motion_describe(setup->system, &orbit, how, motion, message);
    }
    saltus_orbit_clear(&orbit);
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
    if (status != SALTUS_OK || motion->periods > 0 || motion->eigenvalues)
        return status;
    status =
        saltus_fail(message, SALTUS_BAD_INPUT, "--from %.200s: is %.60s there, and comes to no orbit here",
                    cli_text(request, "--from"), setup->start.label);
    saltus_motion_clear(motion);
    return status;
}

bool cli_parse_range(const char *flag, const char *text, char key[SALTUS_KEY_MAX], double *low,
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
    return good || cli_refuse(false, "%s %s: must have the form key=low:high, low below high", flag, text);
}

bool cli_choose(const cli_request *request, const char *flag, const char *const *words, int *which) {
    const char *text = cli_text(request, flag);
    int k = 0;
    while (text && words[k] && strcmp(text, words[k]) != 0)
        k++;
    if (!text || words[k]) {
        *which = text ? k : *which;
        return true;
    }
    fprintf(stderr, "saltus: %s %s: must be %s", flag, text, words[0]);
    for (k = 1; words[k]; k++)
        fprintf(stderr, "%s%s", words[k + 1] ? ", " : " or ", words[k]);
    fputc('\n', stderr);
    return false;
}

saltus_status cli_tell_written(const cli_request *request, const char *what, saltus_status status) {
    if (status == SALTUS_OK && !cli_given(request, "--quiet") && !request->to_stdout)
        printf("%s: %s\n", what, request->output);
    return status;
}

bool cli_shows_progress(const cli_request *request) {
    return !cli_given(request, "--quiet") && isatty(STDERR_FILENO) == 1;
}

static void show_periods(void *context, double periods, double at_most) {
    (void)context;
    progress_line("%.0f %% of at most %.0f periods", 100 * periods / at_most, at_most);
}

void cli_progress_end(const cli_request *request) {
    if (cli_shows_progress(request))
        progress_line("%s", "");
}

void cli_print_motion(const cli_request *request, const cli_setup *setup, const saltus_motion *motion) {
    (cli_given(request, "--json") ? saltus_write_motion_json
                                  : saltus_write_motion_text)(stdout, &setup->scene, setup->system, motion);
}

saltus_classify_options cli_classify_options(const cli_request *request) {
    saltus_classify_options options = request->classify;
    /* Unless --measure is given, measure long enough for the required lifetime. */
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
