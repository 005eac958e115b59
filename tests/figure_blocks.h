/* What a figure draws, read back: a program called gnuplot that keeps its script instead of drawing it, and
 * the script taken apart into panels, each with its axes, labels, arrows, objects, lines of numbers and
 * rasters. The numbers are those after gnuplot's `using`, so that a test sees what a reader of the figure
 * sees.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FIGURE_BLOCKS_H
#define SALTUS_TESTS_FIGURE_BLOCKS_H

#include "folder.h"

#include <ctype.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    FIGURE_COLUMNS = 6,
    FIGURE_BLOCKS = 80,
    FIGURE_MARKS = 600,
    FIGURE_ELEMENTS = 120,
    FIGURE_PANELS = 8,
    FIGURE_VARIABLES = 60,
    FIGURE_LINE = 6000,
    FIGURE_DEPTH = 8,
    FIGURE_TEXT = 700
};

/* Rows of numbers; a joined row hangs together with the one before it. */
typedef struct figure_rows {
    char name[40];
    int count, room;
    double (*at)[FIGURE_COLUMNS];
    bool *joined;
} figure_rows;

/* A label, arrow or object: its places, each with 's' (of the page), 'g' (of the panel) or 'f' (on the axes)
 * for either coordinate. */
typedef struct figure_mark {
    char kind; /* 'l', 'a' or 'o' */
    int tag;
    char text[FIGURE_TEXT], style[160];
    char system[2][2];
    double place[2][2];
} figure_mark;

/* One thing drawn. `values` are what `using` makes of the block; a raster's pixels follow its rows from
 * below. */
typedef struct figure_element {
    char text[FIGURE_TEXT], style[FIGURE_TEXT], title[160];
    figure_rows values;
    int width, height;
    const unsigned char *pixels;
} figure_element;

typedef struct figure_panel {
    char label[3][256]; /* x, y, second y */
    double range[4][2]; /* x, y, second x, second y */
    bool logarithmic[4];
    double frame[4]; /* left, right, bottom, top as parts of the page */
    figure_mark *mark;
    int mark_count;
    figure_element *element;
    int element_count;
    bool parametric;
    double tic[2];      /* distance of the tics of x and y; 0: gnuplot's choice */
    double tics[2][40]; /* or the places of each */
    int tic_count[2];
    int key_rows; /* most rows of the legend, where it is told */
    bool key;     /* whether a legend is asked for */
    char format[2][24];
} figure_panel;

/* A variable of the script: what stands for it. */
typedef struct figure_variable {
    char name[32], value[FIGURE_TEXT];
} figure_variable;

typedef struct figure {
    char *script;
    size_t length;
    char terminal[160];
    figure_rows *block;
    int block_count;
    figure_panel panel[FIGURE_PANELS];
    int panel_count;
    char function[160]; /* of x, called cut */
    figure_variable variable[FIGURE_VARIABLES];
    int variable_count;
    bool skipped[FIGURE_DEPTH]; /* the blocks of `if` that are open, whether each is left out */
    int depth;
} figure;

/* Put the keeper of scripts first in PATH; the script lies at folder/script. */
static inline void figure_open(const char *folder) {
    char path[300], *paths = malloc(strlen(getenv("PATH")) + 300);
    snprintf(path, sizeof path, "%s/gnuplot", folder);
    FILE *file = fopen(path, "w");
    assert_true(file && paths);
    fprintf(file, "#!/bin/sh\ncat >%s/script\nprintf '<svg>%%080d</svg>\\n' 0\n", folder);
    fclose(file);
    chmod(path, 0755);
    sprintf(paths, "%s:%s", folder, getenv("PATH"));
    setenv("PATH", paths, 1);
    free(paths);
}

/* Expressions of gnuplot */

typedef struct figure_sum {
    const char *at;
    const double *row;
    double x, t;
    const char *function;
} figure_sum;

static inline double figure_choice(figure_sum *s);

static inline bool figure_take(figure_sum *s, const char *word) {
    while (*s->at == ' ')
        s->at++;
    if (strncmp(s->at, word, strlen(word)) != 0)
        return false;
    s->at += strlen(word);
    return true;
}

static inline double figure_atom(figure_sum *s) {
    char *end;
    if (figure_take(s, "-"))
        return -figure_atom(s);
    if (figure_take(s, "(")) {
        double value = figure_choice(s);
        assert_true(figure_take(s, ")"));
        return value;
    }
    if (figure_take(s, "abs(")) {
        double value = figure_choice(s);
        assert_true(figure_take(s, ")"));
        return fabs(value);
    }
    if (figure_take(s, "cut(")) {
        figure_sum inner = {.at = s->function, .row = s->row};
        inner.x = figure_choice(s);
        assert_true(figure_take(s, ")"));
        return figure_choice(&inner);
    }
    if (figure_take(s, "NaN"))
        return NAN;
    if (figure_take(s, "x"))
        return s->x;
    if (figure_take(s, "t"))
        return s->t;
    if (figure_take(s, "$")) {
        long column = strtol(s->at, &end, 10);
        s->at = end;
        assert_in_range(column, 1, FIGURE_COLUMNS);
        return s->row[column - 1];
    }
    double value = strtod(s->at, &end);
    if (end == s->at)
        fail_msg("no expression that is known: %.80s", s->at);
    s->at = end;
    return value;
}

static inline double figure_product(figure_sum *s) {
    double value = figure_atom(s);
    for (;;)
        if (figure_take(s, "*"))
            value *= figure_atom(s);
        else if (figure_take(s, "/"))
            value /= figure_atom(s);
        else
            return value;
}

static inline double figure_total(figure_sum *s) {
    double value = figure_product(s);
    for (;;)
        if (figure_take(s, "+"))
            value += figure_product(s);
        else if (figure_take(s, "-"))
            value -= figure_product(s);
        else
            return value;
}

static inline double figure_order(figure_sum *s) {
    double value = figure_total(s);
    for (;;)
        if (figure_take(s, "=="))
            value = value == figure_total(s);
        else if (figure_take(s, "!="))
            value = value != figure_total(s);
        else if (figure_take(s, "<="))
            value = value <= figure_total(s);
        else if (figure_take(s, ">="))
            value = value >= figure_total(s);
        else if (figure_take(s, "<"))
            value = value < figure_total(s);
        else if (figure_take(s, ">"))
            value = value > figure_total(s);
        else
            return value;
}

static inline double figure_truth(figure_sum *s) {
    return figure_take(s, "!") ? figure_order(s) == 0 : figure_order(s);
}

static inline double figure_both(figure_sum *s) {
    double value = figure_truth(s);
    while (figure_take(s, "&&")) {
        double other = figure_truth(s);
        value = value != 0 && other != 0;
    }
    return value;
}

static inline double figure_choice(figure_sum *s) {
    double value = figure_both(s);
    if (!figure_take(s, "?"))
        return value;
    double yes = figure_choice(s);
    assert_true(figure_take(s, ":"));
    double no = figure_choice(s);
    return value != 0 ? yes : no;
}

/* Blocks */

static inline void figure_add(figure_rows *rows, const double *row, bool joined) {
    if (rows->count == rows->room) {
        rows->room = rows->room ? 2 * rows->room : 64;
        rows->at = realloc(rows->at, (size_t)rows->room * sizeof *rows->at);
        rows->joined = realloc(rows->joined, (size_t)rows->room * sizeof *rows->joined);
        assert_true(rows->at && rows->joined);
    }
    memcpy(rows->at[rows->count], row, sizeof *rows->at);
    rows->joined[rows->count++] = joined;
}

/* The block that begins here; what follows it. */
static inline char *figure_block(figure_rows *rows, char *line) {
    bool joined = false;
    *rows = (figure_rows){.count = 0};
    assert_int_equal(sscanf(line, "%39s", rows->name), 1);
    for (line = strchr(line, '\n') + 1; strncmp(line, "EOD\n", 4) != 0; line = strchr(line, '\n') + 1) {
        double row[FIGURE_COLUMNS] = {0};
        int columns = 0;
        char *at = line, *end;
        if (*line == '#')
            continue;
        for (; *at != '\n'; at = end) {
            row[columns++] = strtod(at, &end);
            if (end == at || columns > FIGURE_COLUMNS)
                fail_msg("block %s holds %.60s", rows->name, line);
        }
        bool there = columns > 0 && !isnan(row[0]);
        if (there)
            figure_add(rows, row, joined);
        joined = there;
    }
    return line + 4;
}

/* Commands */

/* What stands between the first two quotes, with double ones inside as one; what follows it. */
static inline const char *figure_quoted(const char *from, char *text, size_t room) {
    size_t used = 0;
    const char *at = strchr(from, '\'');
    text[0] = '\0';
    if (!at)
        return from;
    for (at++; *at && (*at != '\'' || at[1] == '\''); at++) {
        at += *at == '\'';
        if (used + 1 < room)
            text[used++] = *at;
    }
    text[used] = '\0';
    return at + 1;
}

/* "screen 0.1,graph 0.2": what it says, and what follows it. */
static inline const char *figure_place(const char *at, char system[2], double place[2]) {
    static const char *const words[] = {"screen ", "graph ", "first "};
    for (int k = 0; k < 2; k++) {
        char *end;
        system[k] = k ? system[0] : 'f';
        at += strspn(at, " ,");
        for (int w = 0; w < 3; w++)
            if (strncmp(at, words[w], strlen(words[w])) == 0) {
                system[k] = words[w][0];
                at += strlen(words[w]);
            }
        place[k] = strtod(at, &end);
        at = end;
    }
    return at;
}

static inline void figure_drop(figure_panel *now, char kind, int tag) {
    int kept = 0;
    for (int k = 0; k < now->mark_count; k++)
        if (now->mark[k].kind != kind || (tag && now->mark[k].tag != tag))
            now->mark[kept++] = now->mark[k];
    now->mark_count = kept;
}

static inline void figure_set_mark(figure_panel *now, const char *line, char kind) {
    figure_mark mark = {.kind = kind};
    char *end;
    const char *at = line + strcspn(line + 4, " ") + 5;
    mark.tag = (int)strtol(at, &end, 10);
    if (mark.tag)
        figure_drop(now, kind, mark.tag);
    if (kind == 'l')
        at = figure_quoted(end, mark.text, sizeof mark.text);
    else
        snprintf(mark.text, sizeof mark.text, "%s", end);
    const char *first = strstr(at, kind == 'l' ? "at " : "from "), *second = strstr(at, "to ");
    if (first)
        at = figure_place(first + (kind == 'l' ? 3 : 5), mark.system[0], mark.place[0]);
    if (kind != 'l' && first && second)
        at = figure_place(second + 3, mark.system[1], mark.place[1]);
    snprintf(mark.style, sizeof mark.style, "%s", at);
    assert_true(now->mark_count < FIGURE_MARKS);
    now->mark[now->mark_count++] = mark;
}

static inline bool figure_begins(const char *line, const char *word) {
    return strncmp(line, word, strlen(word)) == 0;
}

static inline void figure_range(const char *line, double range[2]) {
    char *end;
    range[0] = strtod(strchr(line, '[') + 1, &end);
    assert_int_equal(*end, ':');
    range[1] = strtod(end + 1, &end);
    assert_int_equal(*end, ']');
}

/* "5", "auto" or "('1' 1, '2' 2)". */
static inline void figure_tics(figure_panel *now, const char *at, int axis) {
    char word[40];
    now->tic[axis] = *at == '(' ? 0 : strtod(at, NULL);
    now->tic_count[axis] = 0;
    for (at += *at == '('; *at && *at != ')' && *at != 'a' && now->tic[axis] == 0;) {
        at += strspn(at, ", ");
        if (*at == '\'')
            at = figure_quoted(at, word, sizeof word);
        char *end;
        assert_true(now->tic_count[axis] < 40);
        now->tics[axis][now->tic_count[axis]++] = strtod(at, &end);
        assert_true(end > at);
        at = end;
    }
}

/* One command that is no plot. */
static inline void figure_set(figure *f, figure_panel *now, const char *line) {
    static const char *const ranges[] = {"set xrange", "set yrange", "set x2range", "set y2range"},
                             *const labels[] = {"set xlabel", "set ylabel", "set y2label"},
                             *const margins[] = {"set lmargin", "set rmargin", "set bmargin", "set tmargin"},
                             *const kinds[] = {"label", "arrow", "object"};
    static const char axes[][4] = {"x", "y", "x2", "y2"};
    char word[40];
    for (int k = 0; k < 4; k++) {
        if (figure_begins(line, ranges[k]))
            figure_range(line, now->range[k]);
        if (figure_begins(line, margins[k]))
            now->frame[k] = strtod(strstr(line, "screen ") + 7, NULL);
        snprintf(word, sizeof word, "set logscale %s", axes[k]);
        if (strcmp(line, word) == 0)
            now->logarithmic[k] = true;
        snprintf(word, sizeof word, "unset logscale %s", axes[k]);
        if (strcmp(line, word) == 0 || strcmp(line, "unset logscale") == 0)
            now->logarithmic[k] = false;
    }
    for (int k = 0; k < 3; k++) {
        if (figure_begins(line, labels[k]))
            figure_quoted(line, now->label[k], sizeof now->label[k]);
        if (figure_begins(line, "un") && strcmp(line + 2, labels[k]) == 0)
            now->label[k][0] = '\0';
        snprintf(word, sizeof word, "set %s ", kinds[k]);
        if (figure_begins(line, word))
            figure_set_mark(now, line, kinds[k][0]);
        snprintf(word, sizeof word, "unset %s", kinds[k]);
        if (figure_begins(line, word))
            figure_drop(now, kinds[k][0], atoi(line + strlen(word)));
    }
    for (int k = 0; k < 2; k++) {
        snprintf(word, sizeof word, "set %ctics ", 'x' + k);
        if (figure_begins(line, word))
            figure_tics(now, line + strlen(word), k);
    }
    const char *key_rows = figure_begins(line, "set key ") ? strstr(line, "maxrows ") : NULL;
    if (key_rows)
        now->key_rows = atoi(key_rows + 8);
    if (figure_begins(line, "set key "))
        now->key = strcmp(line, "set key off") != 0;
    for (int k = 0; k < 2; k++) {
        snprintf(word, sizeof word, "set format %c ", 'x' + k);
        if (figure_begins(line, word) || figure_begins(line, "set format '"))
            figure_quoted(line, now->format[k], sizeof now->format[k]);
    }
    if (figure_begins(line, "set terminal"))
        snprintf(f->terminal, sizeof f->terminal, "%s", line + 13);
    if (figure_begins(line, "cut(x) = "))
        snprintf(f->function, sizeof f->function, "%s", line + 9);
    now->parametric = (now->parametric && !figure_begins(line, "unset parametric")) ||
                      figure_begins(line, "set parametric");
}

static inline const figure_rows *figure_find(const figure *f, const char *name) {
    for (int k = 0; k < f->block_count; k++)
        if (strcmp(f->block[k].name, name) == 0)
            return &f->block[k];
    return NULL;
}

/* What `using` makes of the rows of a block. */
static inline void figure_fill(const figure *f, figure_element *e) {
    char name[40], columns[FIGURE_COLUMNS][200];
    int count = 0, depth = 0;
    size_t used = 0;
    assert_int_equal(sscanf(e->text, "%39s", name), 1);
    const figure_rows *rows = figure_find(f, name);
    const char *at = strstr(e->text, " using ");
    if (!rows || !at)
        fail_msg("no block %s", name);
    for (at += 7; *at && (*at != ' ' || depth > 0); at++) {
        depth += *at == '(' ? 1 : *at == ')' ? -1 : 0;
        if (*at == ':' && depth == 0) {
            columns[count++][used] = '\0';
            used = 0;
            assert_true(count < FIGURE_COLUMNS);
        } else if (used + 1 < sizeof columns[0])
            columns[count][used++] = *at;
    }
    columns[count++][used] = '\0';
    snprintf(e->style, sizeof e->style, "%s", at);
    bool broken = false;
    for (int k = 0; k < rows->count; k++) {
        double row[FIGURE_COLUMNS] = {0};
        bool there = true;
        for (int c = 0; c < count; c++) {
            figure_sum sum = {.at = columns[c], .row = rows->at[k], .function = f->function};
            row[c] = columns[c][0] == '(' ? figure_choice(&sum) : rows->at[k][atoi(columns[c]) - 1];
            there = there && !isnan(row[c]);
        }
        if (there)
            figure_add(&e->values, row, rows->joined[k] && !broken);
        broken = !there;
    }
}

/* Cut a plot command into what it draws. */
static inline void figure_plot(const figure *f, figure_panel *panel, const char *at) {
    panel->element = calloc(FIGURE_ELEMENTS, sizeof *panel->element);
    assert_non_null(panel->element);
    while (*at) {
        assert_true(panel->element_count < FIGURE_ELEMENTS);
        figure_element *e = &panel->element[panel->element_count++];
        bool quoted = false;
        int depth = 0;
        size_t used = 0;
        at += strspn(at, " ");
        for (; *at && (*at != ',' || quoted || depth > 0); at++) {
            quoted = quoted != (*at == '\'');
            depth += quoted ? 0 : *at == '(' ? 1 : *at == ')' ? -1 : 0;
            if (used + 1 < sizeof e->text)
                e->text[used++] = *at;
        }
        at += *at == ',';
        snprintf(e->style, sizeof e->style, "%s", e->text);
        const char *title = strstr(e->text, " title "), *size = strstr(e->text, "binary array=(");
        if (title)
            figure_quoted(title, e->title, sizeof e->title);
        if (size)
            assert_int_equal(sscanf(size, "binary array=(%d,%d)", &e->width, &e->height), 2);
        if (e->text[0] == '$')
            figure_fill(f, e);
    }
}

/* Variables and choices */

static inline const char *figure_value(const figure *f, const char *name, size_t length) {
    for (int k = 0; k < f->variable_count; k++)
        if (strlen(f->variable[k].name) == length && strncmp(f->variable[k].name, name, length) == 0)
            return f->variable[k].value;
    return NULL;
}

/* A line with the values of its variables, outside quotes; a macro's without the quotes around it. */
static inline void figure_expand(const figure *f, const char *line, char *text) {
    size_t used = 0;
    char quote = '\0';
    while (*line) {
        size_t length = 0;
        bool word =
            !quote && (used == 0 || !(isalnum((unsigned char)text[used - 1]) || text[used - 1] == '_'));
        const char *name = line + (*line == '@');
        while (word && isupper((unsigned char)*name) &&
               (isalnum((unsigned char)name[length]) || name[length] == '_'))
            length++;
        const char *value = length ? figure_value(f, name, length) : NULL;
        assert_true(used + FIGURE_TEXT < FIGURE_LINE);
        if (value && *line == '@') {
            char own[FIGURE_LINE], inner[FIGURE_LINE];
            snprintf(own, sizeof own, "%.*s", (int)strlen(value) - 2, value + 1);
            figure_expand(f, own, inner);
            used += (size_t)snprintf(text + used, FIGURE_LINE - used, "%s", inner);
        } else if (value)
            used += (size_t)snprintf(text + used, FIGURE_LINE - used, "%s", value);
        if (value) {
            line = name + length;
            continue;
        }
        if (quote ? *line == quote : *line == '\'' || *line == '"')
            quote = quote ? '\0' : *line;
        text[used++] = *line++;
    }
    text[used] = '\0';
}

/* Whether a line is an assignment or the begin or end of a choice, which is then taken in; one that is left
 * out counts as taken in. */
static inline bool figure_flow(figure *f, const char *line) {
    char text[FIGURE_LINE];
    size_t length = strspn(line, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789");
    bool skipped = f->depth > 0 && f->skipped[f->depth - 1];
    if (strncmp(line, "if (", 4) == 0) {
        figure_expand(f, line + 3, text);
        figure_sum sum = {.at = text};
        assert_true(f->depth < FIGURE_DEPTH);
        f->skipped[f->depth] = skipped || figure_choice(&sum) == 0;
        f->depth++;
        return true;
    }
    if (strcmp(line, "}") == 0) {
        assert_true(f->depth > 0);
        f->depth--;
        return true;
    }
    if (skipped || !isupper((unsigned char)*line) || strncmp(line + length, " = ", 3) != 0)
        return skipped;
    figure_variable *variable = NULL;
    for (int k = 0; k < f->variable_count; k++)
        if (strlen(f->variable[k].name) == length && strncmp(f->variable[k].name, line, length) == 0)
            variable = &f->variable[k];
    if (!variable) {
        assert_true(f->variable_count < FIGURE_VARIABLES && length < sizeof variable->name);
        variable = &f->variable[f->variable_count++];
        snprintf(variable->name, sizeof variable->name, "%.*s", (int)length, line);
    }
    snprintf(variable->value, sizeof variable->value, "%s", line + length + 3);
    return true;
}

/* The script that the keeper was given last. */
static inline figure figure_taken(const char *folder) {
    figure f = {.script = NULL};
    figure_panel now = {.mark = calloc(FIGURE_MARKS, sizeof(figure_mark))};
    char path[300];
    snprintf(path, sizeof path, "%s/script", folder);
    f.script = read_all(path, &f.length);
    remove(path);
    f.block = calloc(FIGURE_BLOCKS, sizeof *f.block);
    assert_true(f.block && now.mark);
    for (char *line = f.script; line < f.script + f.length;) {
        if (*line == '$') {
            assert_true(f.block_count < FIGURE_BLOCKS);
            line = figure_block(&f.block[f.block_count++], line);
            continue;
        }
        char *end = strchr(line, '\n');
        assert_non_null(end);
        while (end[-1] == '\\') {
            end[-1] = *end = ' ';
            end = strchr(end, '\n');
            assert_non_null(end);
        }
        *end = '\0';
        char expanded[FIGURE_LINE];
        const char *command = line;
        if (figure_flow(&f, line)) {
            line = end + 1;
            continue;
        }
        if (strlen(line) < FIGURE_LINE - FIGURE_TEXT && !strstr(line, " binary ")) {
            figure_expand(&f, line, expanded);
            command = expanded;
        }
        if (figure_begins(command, "plot ")) {
            assert_true(f.panel_count < FIGURE_PANELS);
            figure_panel *panel = &f.panel[f.panel_count++];
            *panel = now;
            panel->mark = calloc((size_t)now.mark_count + 1, sizeof *panel->mark);
            assert_non_null(panel->mark);
            memcpy(panel->mark, now.mark, (size_t)now.mark_count * sizeof *panel->mark);
            figure_plot(&f, panel, command + 5);
            for (int k = 0; k < panel->element_count; k++)
                if (panel->element[k].width) {
                    panel->element[k].pixels = (unsigned char *)end + 1;
                    end += 4 * (size_t)panel->element[k].width * (size_t)panel->element[k].height;
                }
            assert_true(end < f.script + f.length);
        } else
            figure_set(&f, &now, command);
        line = end + 1;
    }
    free(now.mark);
    return f;
}

static inline void figure_rows_free(figure_rows *rows) {
    free(rows->at);
    free(rows->joined);
}

static inline void figure_free(figure *f) {
    for (int p = 0; p < f->panel_count; p++) {
        for (int k = 0; k < f->panel[p].element_count; k++)
            figure_rows_free(&f->panel[p].element[k].values);
        free(f->panel[p].element);
        free(f->panel[p].mark);
    }
    for (int k = 0; k < f->block_count; k++)
        figure_rows_free(&f->block[k]);
    free(f->block);
    free(f->script);
    *f = (figure){.script = NULL};
}

/* Questions */

/* The k-th label, arrow or object of a panel whose text or style holds some words, or NULL. */
static inline const figure_mark *figure_mark_of(const figure_panel *panel, char kind, const char *words,
                                                int k) {
    for (int m = 0; m < panel->mark_count; m++)
        if (panel->mark[m].kind == kind &&
            (strstr(panel->mark[m].text, words) || strstr(panel->mark[m].style, words)) && k-- == 0)
            return &panel->mark[m];
    return NULL;
}

/* The panel with these words in its heading, legend or axes' names; the page's caption is none of them. */
static inline const figure_panel *figure_panel_of(const figure *f, const char *words) {
    for (int p = 0; p < f->panel_count; p++) {
        const figure_panel *panel = &f->panel[p];
        if (strstr(panel->label[0], words) || strstr(panel->label[1], words) ||
            strstr(panel->label[2], words))
            return panel;
        const figure_mark *mark;
        for (int k = 0; (mark = figure_mark_of(panel, 'l', words, k)) != NULL; k++)
            if (mark->system[0][0] != 's' || mark->place[0][0] != 0.03)
                return panel;
    }
    fail_msg("no panel of %s", words);
    return NULL;
}

/* The k-th element of a panel whose words hold these, or NULL. */
static inline const figure_element *figure_element_of(const figure_panel *panel, const char *words, int k) {
    for (int e = 0; e < panel->element_count; e++)
        if (strstr(panel->element[e].text, words) && k-- == 0)
            return &panel->element[e];
    return NULL;
}

/* All that is written at the left of the page, above the panels, from top to bottom. */
static inline void figure_caption(const figure *f, char *text, size_t room) {
    size_t used = 0;
    double below = 2;
    text[0] = '\0';
    for (;;) {
        const figure_mark *next = NULL;
        for (int k = 0; f->panel_count && k < f->panel[0].mark_count; k++) {
            const figure_mark *mark = &f->panel[0].mark[k];
            bool left = mark->kind == 'l' && mark->system[0][0] == 's' && mark->system[0][1] == 's' &&
                        mark->place[0][0] == 0.03;
            if (left && mark->place[0][1] < below && (!next || mark->place[0][1] > next->place[0][1]))
                next = mark;
        }
        if (!next || used + sizeof next->text >= room)
            return;
        below = next->place[0][1];
        used += (size_t)snprintf(text + used, room - used, "%s ", next->text);
    }
}

static inline void figure_says(const figure *f, const char *words) {
    char text[8000];
    figure_caption(f, text, sizeof text);
    if (!strstr(text, words))
        fail_msg("the caption does not say '%s': %s", words, text);
}

/* The colour that a style names, -1 for none. */
static inline long figure_colour(const char *style) {
    size_t at = 0;
    while (style[at] && style[at] != '#')
        at++;
    return style[at] ? strtol(style + at + 1, NULL, 16) : -1;
}

/* The caption's lines begin so, from top to bottom at equal distances below the heading, in these colours. */
static inline void figure_check_lines(const figure *f, const char *const *begins, const long *colours,
                                      int count) {
    double below = 2, distance = 0;
    for (int line = 0; line < count; line++) {
        const figure_mark *mark = NULL;
        for (int k = 0; k < f->panel[0].mark_count && !mark; k++)
            if (f->panel[0].mark[k].kind == 'l' && figure_begins(f->panel[0].mark[k].text, begins[line]))
                mark = &f->panel[0].mark[k];
        if (!mark)
            fail_msg("no line of the caption begins with '%s'", begins[line]);
        assert_true(mark->place[0][0] == 0.03 && mark->place[0][1] < below);
        distance = line == 2 ? below - mark->place[0][1] : distance;
        if (line > 2)
            check_near(below - mark->place[0][1], distance, 2e-4);
        below = mark->place[0][1];
        if (figure_colour(mark->style) != colours[line])
            fail_msg("'%s' is in another colour: %s", begins[line], mark->style);
    }
    assert_true(count < 3 || (distance > 0.02 && distance < 0.03));
}

/* Tics are at round numbers, neither too few nor too many, and named ones are in the range; what is written
 * has as many braces that open as close. */
static inline void figure_check_tics(const figure_panel *panel) {
    for (int axis = 0; axis < 2; axis++) {
        double width = panel->range[axis][1] - panel->range[axis][0], step = panel->tic[axis];
        if (step > 0) {
            double digit = step / pow(10, floor(log10(step) + 1e-9));
            assert_true(fabs(digit - round(digit)) < 1e-6 && width / step > 1.5 && width / step < 20);
            assert_true(fabs(digit - 1) < 0.1 || fabs(digit - 2) < 0.1 || fabs(digit - 4) < 0.1 ||
                        fabs(digit - 5) < 0.1 || fabs(digit - 6) < 0.1);
        }
        for (int k = 0; k < panel->tic_count[axis]; k++)
            assert_true(panel->tics[axis][k] >= panel->range[axis][0] * (1 - 1e-9) &&
                        panel->tics[axis][k] <= panel->range[axis][1] * (1 + 1e-9) &&
                        (k == 0 || panel->tics[axis][k] > panel->tics[axis][k - 1]));
    }
    for (int m = 0; m < panel->mark_count; m++) {
        const char *text = panel->mark[m].kind == 'l' ? panel->mark[m].text : "";
        int depth = 0;
        for (; *text; text++) {
            depth += *text == '{' ? 1 : *text == '}' ? -1 : 0;
            text += *text == '\\' && text[1];
            assert_true(depth >= 0);
        }
        assert_int_equal(depth, 0);
    }
}

/* The number at the last tic across ends on the page: a digit cut off makes another number. */
static inline void figure_check_last_tic(const figure *f, const figure_panel *panel) {
    const double letter = 8.5, *range = panel->range[0], step = panel->tic[0];
    const int count = panel->tic_count[0];
    const char *size = strstr(f->terminal, "svg size ");
    if (!size || panel->format[0][0] == '\'' || (!count && !(step > 0)))
        return;
    const double page = strtod(size + strlen("svg size "), NULL),
                 last = count ? panel->tics[0][count - 1] : step * floor(range[1] / step + 1e-9);
    const double part = panel->logarithmic[0] ? log(last / range[0]) / log(range[1] / range[0])
                                              : (last - range[0]) / (range[1] - range[0]);
    char number[32];
    snprintf(number, sizeof number, "%g", fabs(last) < 1e-9 * fabs(step) ? 0 : last);
    assert_true((panel->frame[0] + part * (panel->frame[1] - panel->frame[0])) * page +
                    0.5 * letter * (double)strlen(number) <
                page);
}

/* Panels are on the page, beneath its caption, and none lies on another. */
static inline void figure_check_page(const figure *f) {
    double caption = 1;
    for (int k = 0; k < f->panel[0].mark_count; k++) {
        const figure_mark *mark = &f->panel[0].mark[k];
        if (mark->kind == 'l' && mark->system[0][1] == 's' && mark->place[0][0] == 0.03)
            caption = fmin(caption, mark->place[0][1]);
    }
    assert_true(f->panel_count > 0 && caption < 1);
    for (int p = 0; p < f->panel_count; p++) {
        const double *a = f->panel[p].frame;
        figure_check_tics(&f->panel[p]);
        assert_true(a[0] > 0 && a[0] < a[1] && a[1] < 1 && a[2] > 0 && a[2] < a[3] && a[3] < caption);
        figure_check_last_tic(f, &f->panel[p]);
        for (int o = 0; o < p; o++) {
            const double *b = f->panel[o].frame;
            assert_true(a[1] <= b[0] || b[1] <= a[0] || a[3] <= b[2] || b[3] <= a[2]);
        }
    }
}

/* The k-th command that begins so, outside blocks; NULL: there are not so many. */
static inline const char *figure_command(const figure *f, const char *words, int k) {
    for (const char *line = f->script; line < f->script + f->length; line += strcspn(line, "\n") + 1)
        if (figure_begins(line, words) && k-- == 0)
            return line;
    return NULL;
}

/* How many things the legend explains. */
static inline int figure_titles(const figure_panel *panel) {
    int count = 0;
    for (int e = 0; e < panel->element_count; e++)
        count += panel->element[e].title[0] != '\0';
    return count;
}

/* Every number of an element that is drawn as x and y lies in its panel. */
static inline void figure_check_inside(const figure_panel *panel, const figure_element *e) {
    for (int k = 0; k < e->values.count; k++)
        for (int axis = 0; axis < 2; axis++) {
            double v = e->values.at[k][axis];
            const double *range = panel->range[axis];
            double rounding = 1e-6 * (range[1] - range[0]);
            if (!(v >= range[0] - rounding && v <= range[1] + rounding))
                fail_msg("%s: %g is not between %g and %g", e->text, v, range[0], range[1]);
        }
}

/* A number as a figure gives it, to so many digits. */
static inline void figure_near(double shown, double value, double relative) {
    if (!(fabs(shown - value) <= relative * fabs(value) + 1e-300))
        fail_msg("%.12g is drawn, %.12g is meant", shown, value);
}

/* A colour of a raster's pixel as 0xRRGGBB, and its opacity. */
static inline unsigned figure_pixel(const figure_element *e, int x, int y, int *opacity) {
    assert_true(x >= 0 && x < e->width && y >= 0 && y < e->height);
    const unsigned char *p = e->pixels + 4 * ((size_t)y * (size_t)e->width + (size_t)x);
    if (opacity)
        *opacity = p[3];
    return (unsigned)p[0] << 16 | (unsigned)p[1] << 8 | p[2];
}

#endif
