/* Reading and writing struct members described by fields.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/field.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *saltus_close_text(FILE *file, char **text) {
    const bool sound = file && !ferror(file);
    if ((file && fclose(file) != 0) || !sound) {
        free(*text);
        *text = NULL;
    }
    return *text;
}

void saltus_put_string(FILE *file, const char *text) {
    fputc('"', file);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++)
        if (*c == '"' || *c == '\\')
            fprintf(file, "\\%c", *c);
        else if (*c < 0x20 || *c == 0x7f)
            fprintf(file, "\\u%04x", *c);
        else
            fputc(*c, file);
    fputc('"', file);
}

const char *saltus_word_of(const saltus_word *words, int value) {
    while (words->word && words->value != value)
        words++;
    return words->word;
}

bool saltus_word_value(const saltus_word *words, const char *word, size_t length, int *value) {
    for (; words->word; words++)
        if (strlen(words->word) == length && memcmp(words->word, word, length) == 0) {
            *value = words->value;
            return true;
        }
    return false;
}

size_t saltus_field_bytes(const saltus_field *field) {
    static const size_t bytes[] = {
        [SALTUS_REAL] = sizeof(double),    [SALTUS_INT] = sizeof(int),
        [SALTUS_LONG] = sizeof(long long), [SALTUS_NATURAL] = sizeof(unsigned long),
        [SALTUS_FLAG] = sizeof(bool),      [SALTUS_CHOICE] = sizeof(int),
        [SALTUS_SET] = sizeof(unsigned)};
    return field->type == SALTUS_TEXT ? (size_t)field->length : bytes[field->type];
}

size_t saltus_field_shape(const saltus_field *field, const int *counts, int length[2]) {
    int entries = field->type == SALTUS_TEXT ? 0 : field->length;
    length[0] = entries < 0 ? counts[-entries - 1] : entries;
    length[1] = field->width;
    return (size_t)(entries ? length[0] : 1) * (size_t)(length[1] ? length[1] : 1);
}

/* Address of the field's first entry. */
static unsigned char *place_of(const saltus_field *field, const void *record) {
    unsigned char *place = (unsigned char *)record + field->offset, *entries;
    if (!field->indirect)
        return place;
    memcpy(&entries, place, sizeof entries);
    return entries + field->inner;
}

/* Copy row by row if the struct has gaps between the rows (stride). */
static void copy(const saltus_field *field, const int *counts, const void *record, unsigned char *entries,
                 bool out) {
    int length[2];
    size_t rows = 1, row = saltus_field_bytes(field) * saltus_field_shape(field, counts, length);
    unsigned char *place = row ? place_of(field, record) : NULL;
    if (field->stride && row) {
        rows = (size_t)length[0];
        row /= rows;
    }
    for (size_t k = 0; k < rows && row; k++) {
        unsigned char *there = place + k * field->stride, *here = entries + k * row;
        memcpy(out ? here : there, out ? there : here, row);
    }
    /* Zero the bytes after a text's NUL, so that equal records give equal entries. */
    size_t used = field->type == SALTUS_TEXT && out ? strnlen((const char *)entries, row - 1) : row;
    memset(entries + used, 0, row - used);
}

void saltus_field_pack(const saltus_field *field, const int *counts, const void *record, void *entries) {
    copy(field, counts, record, entries, true);
}

void saltus_field_unpack(const saltus_field *field, const int *counts, const void *entries, void *record) {
    copy(field, counts, record, (unsigned char *)entries, false);
}

/* One value of any type but text. */
typedef union value {
    double real;
    int whole;
    long long wide;
    unsigned long natural;
    bool flag;
    unsigned bits;
} value;

long long saltus_field_whole(const saltus_field *field, const void *record) {
    value v = {0};
    memcpy(&v, place_of(field, record), saltus_field_bytes(field));
    switch (field->type) {
    case SALTUS_INT:
    case SALTUS_CHOICE:
        return v.whole;
    case SALTUS_LONG:
        return v.wide;
    case SALTUS_NATURAL:
        return (long long)v.natural;
    case SALTUS_FLAG:
        return v.flag;
    case SALTUS_SET:
        return v.bits;
    default:
        return 0;
    }
}

/* Whether a choice's value, or each bit of a set, has a word. */
static bool has_words(const saltus_field *field, long long whole) {
    unsigned known = 0;
    if (field->type == SALTUS_CHOICE)
        return whole >= INT_MIN && whole <= INT_MAX && saltus_word_of(field->words, (int)whole);
    for (const saltus_word *w = field->words; w->word; w++)
        known |= (unsigned)w->value;
    return whole >= 0 && whole <= UINT_MAX && !((unsigned)whole & ~known);
}

bool saltus_field_set_whole(const saltus_field *field, long long whole, void *record) {
    value v = {0};
    bool fits = !field->words || has_words(field, whole);
    switch (field->type) {
    case SALTUS_INT:
    case SALTUS_CHOICE:
        v.whole = (int)whole;
        fits &= whole >= INT_MIN && whole <= INT_MAX;
        break;
    case SALTUS_LONG:
        v.wide = whole;
        break;
    case SALTUS_NATURAL:
        v.natural = (unsigned long)whole;
        break;
    case SALTUS_FLAG:
        v.flag = whole != 0;
        fits = whole == 0 || whole == 1;
        break;
    case SALTUS_SET:
        v.bits = (unsigned)whole;
        break;
    default:
        fits = false;
    }
    if (fits)
        memcpy(place_of(field, record), &v, saltus_field_bytes(field));
    return fits;
}

double saltus_field_number(const saltus_field *field, const void *record) {
    double real;
    if (field->type == SALTUS_NATURAL)
        return (double)(unsigned long)saltus_field_whole(field, record);
    if (field->type != SALTUS_REAL)
        return (double)saltus_field_whole(field, record);
    memcpy(&real, place_of(field, record), sizeof real);
    return real;
}

bool saltus_field_set_number(const saltus_field *field, double number, void *record) {
    if (field->type == SALTUS_REAL) {
        memcpy(place_of(field, record), &number, sizeof number);
        return true;
    }
    double least = field->type == SALTUS_NATURAL ? 0 : -0x1p63;
    return number >= least && number < 0x1p63 && number == floor(number) &&
           saltus_field_set_whole(field, (long long)number, record);
}

const char *saltus_field_text(const saltus_field *field, const void *record,
                              char text[SALTUS_FIELD_TEXT_MAX]) {
    const char *word;
    size_t used = 0;
    switch (field->type) {
    case SALTUS_REAL:
        return saltus_number(saltus_field_number(field, record), text);
    case SALTUS_FLAG:
        return saltus_field_whole(field, record) ? "yes" : "no";
    case SALTUS_CHOICE:
        word = saltus_word_of(field->words, (int)saltus_field_whole(field, record));
        return word ? word : "unknown";
    case SALTUS_SET:
        text[0] = '\0';
        for (const saltus_word *w = field->words; w->word && used < SALTUS_FIELD_TEXT_MAX; w++)
            if (saltus_field_whole(field, record) & (unsigned)w->value)
                used += (size_t)snprintf(text + used, SALTUS_FIELD_TEXT_MAX - used, "%s%s", used ? "," : "",
                                         w->word);
        return text;
    case SALTUS_TEXT:
        snprintf(text, SALTUS_FIELD_TEXT_MAX, "%s", (const char *)place_of(field, record));
        return text;
    case SALTUS_NATURAL:
        snprintf(text, SALTUS_FIELD_TEXT_MAX, "%lu", (unsigned long)saltus_field_whole(field, record));
        return text;
    default:
        snprintf(text, SALTUS_FIELD_TEXT_MAX, "%lld", saltus_field_whole(field, record));
        return text;
    }
}

/* Read a number that must take up the whole text. */
static bool read_number(const saltus_field *field, const char *text, void *record) {
    char *end;
    if (!*text || strspn(text, " \t\n\v\f\r"))
        return false;
    if (field->type == SALTUS_REAL) {
        double real = strtod(text, &end);
        return !*end && saltus_field_set_number(field, real, record);
    }
    errno = 0;
    if (field->type == SALTUS_NATURAL) {
        unsigned long natural = strtoul(text, &end, 10);
        return !*end && !errno && *text != '-' && saltus_field_set_whole(field, (long long)natural, record);
    }
    long long whole = strtoll(text, &end, 10);
    return !*end && !errno && saltus_field_set_whole(field, whole, record);
}

bool saltus_field_read(const saltus_field *field, const char *text, void *record) {
    unsigned bits = 0;
    int choice;
    switch (field->type) {
    case SALTUS_FLAG:
        return (strcmp(text, "yes") == 0 || strcmp(text, "no") == 0) &&
               saltus_field_set_whole(field, text[0] == 'y', record);
    case SALTUS_CHOICE:
        return saltus_word_value(field->words, text, strlen(text), &choice) &&
               saltus_field_set_whole(field, choice, record);
    case SALTUS_SET:
        for (size_t length; *text; text += length + (text[length] == ',')) {
            length = strcspn(text, ",");
            if (!saltus_word_value(field->words, text, length, &choice))
                return false;
            bits |= (unsigned)choice;
        }
        return saltus_field_set_whole(field, bits, record);
    case SALTUS_TEXT:
        if (strlen(text) >= (size_t)field->length)
            return false;
        memset(place_of(field, record), 0, (size_t)field->length);
        memcpy(place_of(field, record), text, strlen(text));
        return true;
    default:
        return read_number(field, text, record);
    }
}

const saltus_option *saltus_option_find(const saltus_option_table *table, const char *name) {
    for (int k = 0; k < table->count; k++)
        if (strcmp(table->options[k].field.name, name) == 0)
            return &table->options[k];
    return NULL;
}

void saltus_options_fill(const saltus_option_table *table, void *record) {
    for (int k = 0; k < table->count; k++) {
        const saltus_option *o = &table->options[k];
        if (o->field.type == SALTUS_TEXT)
            saltus_field_read(&o->field, "", record);
        else
            saltus_field_set_number(&o->field, o->fallback, record);
    }
}

const char *saltus_option_demand(const saltus_option *o, char text[SALTUS_FIELD_TEXT_MAX]) {
    size_t used = (size_t)snprintf(text, SALTUS_FIELD_TEXT_MAX, "must be %s", o->automatic ? "0 or " : "");
    size_t room = SALTUS_FIELD_TEXT_MAX - used;
    const char *most = o->below ? "less than" : "at most", *least = o->above ? "greater than" : "at least";
    int words = 0;
    while (o->field.words && o->field.words[words].word)
        words++;
    for (int k = 0; k < words && used < SALTUS_FIELD_TEXT_MAX; k++)
        used += (size_t)snprintf(text + used, SALTUS_FIELD_TEXT_MAX - used, "%s%s",
                                 k == 0          ? ""
                                 : k < words - 1 ? ", "
                                                 : " or ",
                                 o->field.words[k].word);
    if (o->field.type == SALTUS_SET && used < SALTUS_FIELD_TEXT_MAX)
        snprintf(text + used, SALTUS_FIELD_TEXT_MAX - used, ", with commas between them");
    if (o->field.words)
        return text;
    if (!(o->high < INFINITY))
        snprintf(text + used, room, "%s %.10g", least, o->low);
    else if (o->field.type == SALTUS_REAL && (o->above || o->below))
        snprintf(text + used, room, "%s %.10g and %s %.10g", least, o->low, most, o->high);
    else
        snprintf(text + used, room, "from %.10g to %.10g", o->low, o->high);
    return text;
}

bool saltus_option_admits(const saltus_option *o, const void *record) {
    const saltus_field *field = &o->field;
    if (field->type == SALTUS_TEXT || field->type == SALTUS_FLAG)
        return true;
    if (field->words)
        return has_words(field, saltus_field_whole(field, record));
    double number = saltus_field_number(field, record);
    return (o->automatic && number == 0) || ((o->above ? number > o->low : number >= o->low) &&
                                             (o->below ? number < o->high : number <= o->high));
}

saltus_status saltus_options_check(const saltus_option_table *table, const void *record,
                                   saltus_message *message) {
    char demand[SALTUS_FIELD_TEXT_MAX];
    for (int k = 0; k < table->count; k++) {
        const saltus_option *o = &table->options[k];
        if (saltus_option_admits(o, record))
            continue;
        saltus_option_demand(o, demand);
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s = %.10g: %s", o->field.name,
                           saltus_field_number(&o->field, record), demand);
    }
    return SALTUS_OK;
}
