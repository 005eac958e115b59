/* Finding keys in a scene's text, for messages.
 *
 * libcyaml hands out strings without their places. This scanner follows just enough of YAML (comments,
 * quotes, flow brackets, list dashes, columns) to know below which top-level key and in which list entry a
 * key stands. On text that defeats it a message lacks its line; nothing else depends on it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"

#include <limits.h>
#include <string.h>

enum { no_dashes = INT_MAX };

/* A key or a value: its text without quotes. */
typedef struct word {
    const char *text;
    size_t length;
    int line, column;
    bool key;
} word;

typedef struct scanner {
    const char *at, *end, *line_start;
    int line;
    int flow;                 /* depth of brackets */
    int top_flow, top_column; /* of the top-level keys; column < 0: none was seen yet */
    word top;                 /* the last top-level key */
    int entry;                /* list item below it; -1 before the first */
    int dash_column;          /* of its dashes; < 0: none yet; no_dashes: a key came before any */
} scanner;

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

static bool blank_at(const scanner *s, const char *p) {
    return p >= s->end || is_blank(*p);
}

static bool ends_plain(const scanner *s, const char *p) {
    if (*p == '\n' || (*p == '#' && is_blank(p[-1])))
        return true;
    if (s->flow > 0 && strchr(",[]{}", *p) && *p)
        return true;
    return *p == ':' && (blank_at(s, p + 1) || (s->flow > 0 && strchr(",[]{}", p[1]) && p[1]));
}

static const char *skip_quoted(scanner *s) {
    char quote = *s->at++;
    while (s->at < s->end && *s->at != quote) {
        if (*s->at == '\\' && quote == '"' && s->at + 1 < s->end)
            s->at++;
        if (*s->at == '\n')
            s->line++;
        s->at++;
    }
    const char *close = s->at;
    if (s->at < s->end)
        s->at++;
    return close;
}

static word read_word(scanner *s) {
    word w = {.text = s->at, .line = s->line, .column = (int)(s->at - s->line_start)};
    const char *close;
    if (*s->at == '"' || *s->at == '\'') {
        w.text++;
        close = skip_quoted(s);
        while (s->at < s->end && *s->at == ' ')
            s->at++;
    } else {
        s->at++;
        while (s->at < s->end && !ends_plain(s, s->at))
            s->at++;
        close = s->at;
        while (close > w.text && is_blank(close[-1]))
            close--;
    }
    w.key = s->at < s->end && *s->at == ':';
    w.length = (size_t)(close - w.text);
    if (w.key)
        s->at++;
    return w;
}

/* Pass blanks, comments and indicators up to the next word; false at the end. */
static bool next_word(scanner *s, word *w) {
    while (s->at < s->end) {
        char c = *s->at;
        bool line_begins = s->at == s->line_start || is_blank(s->at[-1]);
        if (c == '#' && line_begins) {
            while (s->at < s->end && *s->at != '\n')
                s->at++;
        } else if (c == '\n') {
            s->line++;
            s->line_start = ++s->at;
        } else if (c == '{' || c == '[') {
            s->entry += c == '{' && s->flow > s->top_flow;
            s->flow++;
            s->at++;
        } else if (c == '}' || c == ']') {
            s->flow--;
            s->at++;
        } else if (c == '-' && blank_at(s, s->at + 1)) {
            /* It opens an entry if it belongs to the list below the top-level key, not to one deeper down. */
            int column = (int)(s->at++ - s->line_start);
            if (s->dash_column < 0)
                s->dash_column = column;
            s->entry += column == s->dash_column;
        } else if (is_blank(c) || c == ',' || c == ':' || c == '?') {
            s->at++;
        } else {
            *w = read_word(s);
            return true;
        }
    }
    return false;
}

static bool same(const word *w, const char *name) {
    return strlen(name) == w->length && memcmp(w->text, name, w->length) == 0;
}

static scanner begin(const saltus_source *source) {
    scanner s = {.at = source->text, .end = source->text + source->length, .line = 1};
    s.top_column = s.entry = s.dash_column = -1;
    if (source->length >= 3 && memcmp(s.at, "\xef\xbb\xbf", 3) == 0)
        s.at += 3;
    s.line_start = s.at;
    return s;
}

/* Go to the next key at this place; its line, or 0 at the end. */
static int next_key_at(scanner *s, saltus_place place) {
    word w;
    while (next_word(s, &w)) {
        if (!w.key)
            continue;
        if (s->top_column < 0) {
            s->top_column = w.column;
            s->top_flow = s->flow;
        }
        bool top = s->flow == s->top_flow && (s->flow > 0 || w.column == s->top_column);
        if (top) {
            s->top = w;
            s->entry = s->dash_column = -1;
        } else if (s->dash_column < 0)
            s->dash_column = no_dashes;
        int entry = s->entry < 0 ? 0 : s->entry;
        bool here = top ? !place.top : place.top && same(&s->top, place.top) && entry == place.entry;
        if (here && same(&w, place.key))
            return w.line;
    }
    return 0;
}

int saltus_place_line(const saltus_source *source, saltus_place place, bool last) {
    scanner s = begin(source);
    int found = next_key_at(&s, place);
    for (int line = found; last && line; line = next_key_at(&s, place))
        found = line;
    return found;
}

bool saltus_place_value(const saltus_source *source, saltus_place place, char *value, size_t size) {
    scanner s = begin(source);
    word w;
    if (!next_key_at(&s, place) || !next_word(&s, &w) || w.key || w.length >= size)
        return false;
    memcpy(value, w.text, w.length);
    value[w.length] = '\0';
    return true;
}
