/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "manual.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

const cli_command *const manual_commands[] = {&cmd_classify, &cmd_diagnose, &cmd_simulate, &cmd_orbit,
                                              &cmd_continue, &cmd_lyapunov, &cmd_spectrum, &cmd_sweep,
                                              &cmd_basins,   &cmd_plot,     &cmd_export,   &cmd_paper,
                                              &cmd_scenes,   &cmd_check,    NULL};

const manual_topic *const manual_topics[] = {&topic_text, NULL};

const manual_topic *manual_find_topic(const char *name) {
    int k = 0;
    while (manual_topics[k] && strcmp(manual_topics[k]->name, name) != 0)
        k++;
    return manual_topics[k];
}

static const char scenes_and_exits[] =
    "SCENE is a YAML file, the name of a built-in scene (saltus scenes), or - for standard input.\n"
    "Exit status: 0 done, 1 not completed or interrupted (stderr says why), 2 bad input.";

void manual_list(FILE *file) {
    fprintf(file, "saltus %s: non-smooth dynamics of structures that hit rigid stops\n\n", SALTUS_VERSION);
    for (int k = 0; manual_commands[k]; k++)
        fprintf(file, "  saltus %-9s %s\n", manual_commands[k]->name, manual_commands[k]->usage);
    fprintf(file, "\n%s\nsaltus help COMMAND tells more.\n", scenes_and_exits);
    for (int k = 0; manual_topics[k]; k++)
        fprintf(file, "saltus help %s: %s.\n", manual_topics[k]->name, manual_topics[k]->summary);
}

/* The default of an option as written on the command line; empty if there is none. */
static const char *default_of(const cli_entry *entry, char text[SALTUS_FIELD_TEXT_MAX]) {
    const saltus_option *o = entry->option;
    const cli_option *own = entry->own;
    text[0] = '\0';
    if (own && own->kind == CLI_WHOLE && own->fallback >= own->min)
        snprintf(text, SALTUS_FIELD_TEXT_MAX, "%.0f", own->fallback);
    else if (o && o->field.type == SALTUS_CHOICE)
        snprintf(text, SALTUS_FIELD_TEXT_MAX, "%s", saltus_word_of(o->field.words, (int)o->fallback));
    else if (o && !o->field.words && !o->automatic)
        snprintf(text, SALTUS_FIELD_TEXT_MAX, o->field.type == SALTUS_REAL ? "%g" : "%.0f", o->fallback);
    return text;
}

/* The meaning of an option, with its possible words. */
static const char *meaning_of(const cli_entry *entry, char text[SALTUS_FIELD_TEXT_MAX]) {
    char demand[SALTUS_FIELD_TEXT_MAX];
    bool words = entry->option && entry->option->field.words;
    const char *list = words ? saltus_option_demand(entry->option, demand) + strlen("must be ") : "";
    snprintf(text, SALTUS_FIELD_TEXT_MAX, "%s%s%s", entry->help, words ? ": " : "", list);
    return text;
}

/* Print text in lines of at most 80 characters, with an empty line between paragraphs. */
static void put_wrapped(const char *text, FILE *file) {
    enum { width = 80 };
    for (size_t column = 0; *text;) {
        size_t length = strcspn(text, " \n");
        if (column && column + 1 + length > width) {
            fputc('\n', file);
            column = 0;
        }
        fprintf(file, "%s%.*s", column ? " " : "", (int)length, text);
        column += length + (column > 0);
        text += length;
        if (*text == '\n') {
            fputs("\n\n", file);
            column = 0;
        }
        text += *text != '\0';
    }
    fputc('\n', file);
}

void manual_help(const cli_command *command, FILE *file) {
    cli_entry entry;
    char text[SALTUS_FIELD_TEXT_MAX], head[64];
    fprintf(file, "saltus %s %s\n\n", command->name, command->usage);
    put_wrapped(command->help, file);
    fputs("\noptions\n", file);
    for (int k = 0; cli_entry_at(command, k, &entry); k++) {
        snprintf(head, sizeof head, "%s %s", entry.flag, entry.argument ? entry.argument : "");
        fprintf(file, "  %-24s %s", head, meaning_of(&entry, text));
        if (*default_of(&entry, text))
            fprintf(file, " (default %s)", text);
        fputc('\n', file);
    }
    fputs("\nexamples\n", file);
    for (const cli_example *e = command->examples; e->line; e++)
        fprintf(file, "  # %s\n  saltus %s\n", e->what, e->line);
    if (command->notes) {
        fputs("\nnotes\n", file);
        put_wrapped(command->notes, file);
    }
    fprintf(file, "\nsee also: saltus help %s\n", command->see);
}

void manual_topic_help(const manual_topic *topic, FILE *file) {
    fprintf(file, "saltus help %s: %s\n", topic->name, topic->summary);
    for (const manual_part *p = topic->parts; p->kind != MANUAL_END; p++) {
        bool goes_on = p->kind == MANUAL_COMMAND && p[-1].kind == MANUAL_COMMAND;
        bool explains = p->kind == MANUAL_WORDS && p[-(p > topic->parts)].kind == MANUAL_TERM;
        if (!goes_on && !explains && p->kind != MANUAL_LINES)
            fputc('\n', file);
        if (p->kind == MANUAL_WORDS)
            put_wrapped(p->text, file);
        else if (p->kind == MANUAL_LINES)
            for (const char *at = p->text; *at; at += strcspn(at, "\n") + 1)
                fprintf(file, "    %.*s\n", (int)strcspn(at, "\n"), at);
        else
            fprintf(file, "%s%s%s\n", p->kind == MANUAL_COMMAND ? "    saltus " : "", p->text,
                    p->kind == MANUAL_FILE || p->kind == MANUAL_TERM ? ":" : "");
    }
    fprintf(file, "\nsee also: saltus help %s\n", topic->see);
}

/* Print text for man: hyphens stay hyphens, and no line is taken for a request. Lines are separated by the
 * request `between`; NULL: by line breaks. */
static void put_roff(const char *text, const char *between, FILE *file) {
    bool begins = true;
    for (const char *c = text; *c; begins = *c++ == '\n')
        if (*c == '\\')
            fputs("\\e", file);
        else if (*c == '-')
            fputs("\\-", file);
        else {
            if (begins && (*c == '.' || *c == '\''))
                fputs("\\&", file);
            if (*c == '\n' && between)
                fprintf(file, "\n%s", between);
            fputc(*c, file);
        }
}

static void put_see(const char *see, FILE *file) {
    fputs(".SH SEE ALSO\n.BR saltus (1)", file);
    for (const char *at = see; *at;) {
        size_t length = strcspn(at, " ");
        fprintf(file, ",\n.BR saltus\\-%.*s (%c)", (int)length, at,
                strncmp(at, "text", length) == 0 ? '5' : '1');
        at += length + (at[length] == ' ');
    }
    fputc('\n', file);
}

/* Print a part of a page between two literal texts. */
static void put_part(const char *before, const char *text, const char *behind, FILE *file) {
    fputs(before, file);
    put_roff(text, ".PP", file);
    fputs(behind, file);
}

static void put_title(const char *name, const char *section, FILE *file) {
    fputs(".TH SALTUS", file);
    for (const char *c = name; *c; c++)
        fprintf(file, "%s%c", c == name ? "\\-" : "", *c - 'a' + 'A');
    fprintf(file, " %s\n", section);
}

void manual_topic_page(const manual_topic *topic, FILE *file) {
    put_title(topic->name, "5 \"\" \"Saltus " SALTUS_VERSION "\" \"File formats\"", file);
    fprintf(file, ".SH NAME\nsaltus\\-%s \\- %s\n.SH DESCRIPTION\n", topic->name, topic->summary);
    for (const manual_part *p = topic->parts; p->kind != MANUAL_END; p++) {
        bool code = p->kind == MANUAL_LINES || p->kind == MANUAL_COMMAND;
        bool before = p > topic->parts && p->kind == MANUAL_COMMAND && p[-1].kind == MANUAL_COMMAND;
        fputs(p->kind == MANUAL_HEAD   ? ".SH "
              : p->kind == MANUAL_TERM ? ".TP\n\\fB"
              : p->kind == MANUAL_FILE ? ".PP\n"
              : code && !before        ? ".PP\n.nf\n.RS\n"
              : p->kind == MANUAL_WORDS && p > topic->parts && p[-1].kind != MANUAL_TERM &&
                      p[-1].kind != MANUAL_HEAD
                  ? ".PP\n"
                  : "",
              file);
        if (p->kind == MANUAL_COMMAND)
            fputs("saltus ", file);
        put_roff(p->text, p->kind == MANUAL_LINES ? NULL : ".PP", file);
        fputs(p->kind == MANUAL_TERM    ? "\\fR\n"
              : p->kind == MANUAL_FILE  ? ":\n"
              : p->kind == MANUAL_LINES ? ".RE\n.fi\n"
                                        : "\n",
              file);
        if (p->kind == MANUAL_COMMAND && p[1].kind != MANUAL_COMMAND)
            fputs(".RE\n.fi\n", file);
    }
    put_see(topic->see, file);
}

void manual_page(const cli_command *command, FILE *file) {
    cli_entry entry;
    char text[SALTUS_FIELD_TEXT_MAX];
    put_title(command ? command->name : "", "1 \"\" \"Saltus " SALTUS_VERSION "\" \"User commands\"", file);
    if (!command) {
        fputs(".SH NAME\nsaltus \\- non\\-smooth dynamics of structures that hit rigid stops\n"
              ".SH SYNOPSIS\n\\fBsaltus\\fR \\fIcommand\\fR ...\n.br\n"
              "\\fBsaltus help\\fR [\\fIcommand\\fR]\n.br\n\\fBsaltus \\-\\-version\\fR\n.SH COMMANDS\n",
              file);
        for (int k = 0; manual_commands[k]; k++)
            fprintf(file, ".TP\n.BR saltus\\-%s (1)\n%s\n", manual_commands[k]->name,
                    manual_commands[k]->summary);
        for (int k = 0; manual_topics[k]; k++)
            fprintf(file, ".TP\n.BR saltus\\-%s (5)\n%s\n", manual_topics[k]->name,
                    manual_topics[k]->summary);
        put_part(".SH NOTES\n", scenes_and_exits,
                 "\n.SH EXAMPLES\n.TP\n\\fBsaltus classify impact\\-oscillator\\fR\nwhat the scene "
                 "settles on\n.TP\n\\fBsaltus scenes impact\\-oscillator > mine.yaml\\fR\na scene to "
                 "change\n",
                 file);
        return;
    }
    fprintf(file, ".SH NAME\nsaltus\\-%s \\- %s\n.SH SYNOPSIS\n\\fBsaltus %s\\fR ", command->name,
            command->summary, command->name);
    put_part("", command->usage, "\n", file);
    put_part(".SH DESCRIPTION\n", command->help, "\n.SH OPTIONS\n", file);
    for (int k = 0; cli_entry_at(command, k, &entry); k++) {
        put_part(".TP\n\\fB", entry.flag, "\\fR", file);
        if (entry.argument)
            put_part(" \\fI", entry.argument, "\\fR", file);
        put_part("\n", meaning_of(&entry, text), "", file);
        if (*default_of(&entry, text))
            put_part(" (default ", text, ")", file);
        fputc('\n', file);
    }
    fputs(".SH EXAMPLES\n", file);
    for (const cli_example *e = command->examples; e->line; e++) {
        put_part(".TP\n\\fBsaltus ", e->line, "\\fR\n", file);
        put_part("", e->what, "\n", file);
    }
    if (command->notes)
        put_part(".SH NOTES\n", command->notes, "\n", file);
    put_see(command->see, file);
}

/* The completion of an option's value: its words; file names where any text is allowed. */
static void put_choices(const cli_command *command, const cli_entry *entry, FILE *file) {
    const saltus_word *choices = entry->option ? entry->option->field.words : NULL;
    const char *const *words = entry->own ? entry->own->words : NULL;
    const char *const *endings = !words && strcmp(entry->flag, "--format") == 0 ? command->endings : NULL;
    if (!choices && !words && !endings)
        return;
    fprintf(file, "        %s) words='", entry->flag);
    for (; choices && choices->word; choices++)
        fprintf(file, "%s ", choices->word);
    for (; words && *words; words++)
        fprintf(file, "%s ", *words);
    for (; endings && *endings; endings++)
        if (strcmp(*endings, ".h5") != 0)
            fprintf(file, "%s ", *endings + 1);
    fputs("' ;;\n", file);
}

void manual_completion(FILE *file) {
    fputs(
        "# Completion of saltus in bash; made from the commands' tables of options.\n"
        "_saltus() {\n"
        "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words= scenes= flag= k\n"
        "    COMPREPLY=()\n"
        "    [ \"$before\" = = ] && return\n"
        "    for ((k = COMP_CWORD - 1; k > 1; k--)); do\n"
        "        case ${COMP_WORDS[k]} in -*) flag=${COMP_WORDS[k]} && break ;; esac\n"
        "    done\n"
        "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n        words='",
        file);
    for (int k = 0; manual_commands[k]; k++)
        fprintf(file, "%s ", manual_commands[k]->name);
    fputs("help --help --version -V'\n    else case ${COMP_WORDS[1]} in\n", file);
    for (int k = 0; manual_commands[k]; k++) {
        cli_entry entry;
        fprintf(file, "    %s)\n        case $before in\n", manual_commands[k]->name);
        for (int j = 0; cli_entry_at(manual_commands[k], j, &entry); j++)
            put_choices(manual_commands[k], &entry, file);
        fputs("        *) words='", file);
        for (int j = 0; cli_entry_at(manual_commands[k], j, &entry); j++)
            fprintf(file, "%s ", entry.flag);
        fputs("--help' ;;\n        esac ;;\n", file);
    }
    fputs("    help) words='", file);
    for (int k = 0; manual_commands[k]; k++)
        fprintf(file, "%s ", manual_commands[k]->name);
    for (int k = 0; manual_topics[k]; k++)
        fprintf(file, "%s%s", manual_topics[k]->name, manual_topics[k + 1] ? " " : "");
    fputs("' ;;\n    esac fi\n    if [ \"$COMP_CWORD\" -eq 2 ]; then case ${COMP_WORDS[1]} in\n    scenes",
          file);
    for (int k = 0; manual_commands[k]; k++)
        if (manual_commands[k]->needs_scene)
            fprintf(file, "|%s", manual_commands[k]->name);
    fputs(") scenes='", file);
    for (int k = 0; k < saltus_scene_builtin_count(); k++)
        fprintf(file, "%s%s", k ? " " : "", saltus_scene_builtin_name(k));
    /* Keys are those of the scene on the line, which the program itself knows. */
    fputs("' ;;\n    esac fi\n"
          "    case $before in --set|--over|--in|--and) words= ;; esac\n"
          "    case $flag,$before in --set,*|*,--over|*,--in|*,--and)\n"
          "        words+=\" $(\"${COMP_WORDS[0]}\" help --keys \"${COMP_WORDS[1]}\" \"$flag\" "
          "\"${COMP_WORDS[2]}\" "
          "2>/dev/null)\"\n"
          "    esac\n"
          "    COMPREPLY=($(compgen -W \"$words $scenes\" -- \"$word\"))\n"
          "    case ${COMPREPLY[0]} in *=) compopt -o nospace 2>/dev/null ;; esac\n"
          "}\n"
          "complete -o default -F _saltus saltus\n",
          file);
}

int manual_keys(const char *command, const char *flag, const char *name, FILE *file) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    const saltus_status status = saltus_scene_load(name, &scene, &message);
    if (status != SALTUS_OK)
        return cli_report(status, &message);
    int count, keys;
    const saltus_spec *spec = &scene.spec;
    const saltus_parameter *parameters = saltus_model_parameters(spec->model, &count),
                           *of_stops = saltus_stop_parameters(&keys);
    const bool follows = strcmp(flag, "--in") == 0 || strcmp(flag, "--and") == 0,
               starts = strcmp(command, "basins") == 0 && strcmp(flag, "--over") == 0;
    /* Parameters; the values of all stops, their sides last, and of each of several; the initial state. */
    const int of_each = keys + 1, stops = spec->stop_count > 1 ? spec->stop_count + 1 : spec->stop_count;
    for (int k = 0; k < count + of_each * stops && !starts; k++) {
        const int own = (k - count) % of_each, stop = k < count ? 0 : (k - count) / of_each;
        const char *key = k < count ? parameters[k].name : own < keys ? of_stops[own].name : "sides";
        char text[SALTUS_KEY_MAX + 16];
        saltus_direction direction;
        snprintf(text, sizeof text, stop ? "%s%d" : "%s", key, stop);
        if ((strcmp(key, "xi") != 0 || k < count || strcmp(saltus_model_stop_key(spec->model), key) == 0) &&
            (!follows || saltus_spec_direction(spec, text, &direction, NULL, &message) == SALTUS_OK) &&
            (own < keys || k < count || strcmp(flag, "--set") == 0))
            fprintf(file, "%s=\n", text);
    }
    const int dimension = saltus_spec_dimension(spec, NULL);
    for (int k = 0; k < dimension && !follows; k++)
        fprintf(file, "%s=\n", saltus_spec_state_name(spec, k).text);
    saltus_scene_clear(&scene);
    return cli_finish();
}

int manual_write(const char *folder) {
    int commands = 0, topics = 0;
    while (manual_commands[commands])
        commands++;
    while (manual_topics[topics])
        topics++;
    /* The program's page, the completion, then the pages of commands and topics. */
    for (int k = -2; k < commands + topics; k++) {
        const cli_command *command = k >= 0 && k < commands ? manual_commands[k] : NULL;
        const manual_topic *topic = k >= commands ? manual_topics[k - commands] : NULL;
        char path[4096];
        if (k < 0)
            snprintf(path, sizeof path, "%s/saltus.%s", folder, k == -2 ? "1" : "bash");
        else
            snprintf(path, sizeof path, "%s/saltus-%s.%s", folder, command ? command->name : topic->name,
                     command ? "1" : "5");
        FILE *file = fopen(path, "w");
        if (file && k == -1)
            manual_completion(file);
        else if (file && topic)
            manual_topic_page(topic, file);
        else if (file)
            manual_page(command, file);
        bool good = file && !ferror(file);
        if ((file && fclose(file) != 0) || !good)
            return cli_refuse(CLI_FAILED, "%s: cannot be written: %s", path, strerror(errno));
    }
    return CLI_DONE;
}
