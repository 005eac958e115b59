/* Words, numbers and near misses, for reading scenes and for settings.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"
#include "system/system.h"
#include "system/text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { number_size = 256 };

const char *const saltus_stop_keys[stop_keys] = {"xi", "d", "r", "sides", "weight", "coordinate"};
const char *const saltus_initial_keys[initial_lists] = {"q", "v", "z"};

int saltus_key_index(const char *key, const char *const *keys, int count) {
    int k = 0;
    while (k < count && strcmp(key, keys[k]) != 0)
        k++;
    return k;
}

int saltus_top_keys(const saltus_model *model, const char **keys) {
    int count = 0;
    keys[count++] = "model";
    keys[count++] = "title";
    for (int k = 0; model && k < model->parameter_count; k++)
        keys[count++] = model->parameters[k].name;
    keys[count++] = "stop";
    keys[count++] = "stops";
    keys[count++] = "initial";
    keys[count++] = "observe";
    return count;
}

int saltus_model_stop_keys(const saltus_model *model, const char **keys) {
    int count = 0;
    keys[count++] = model->stop_key;
    for (int k = 0; k < stop_keys; k++)
        if (k != stop_xi && k != stop_weight && k != stop_coordinate)
            keys[count++] = saltus_stop_keys[k];
    return count;
}

bool saltus_model_has_stop_key(const saltus_model *model, int key) {
    bool places = key == stop_xi || key == stop_weight || key == stop_coordinate;
    return !places || strcmp(saltus_stop_keys[key], model->stop_key) == 0;
}

const char *saltus_read_number(const char *text, double *value) {
    /* Decimal numbers only; this excludes nan, inf and hexadecimal, which strtod accepts. */
    char *end = NULL;
    const bool plain = *text && text[strspn(text, "0123456789+-.eE")] == '\0';
    double read = plain ? strtod(text, &end) : NAN;
    if (!plain || end == text || *end) {
        /* Otherwise an expression of numbers and pi, such as 2*pi. */
        bool tight = *text && *text != ' ' && text[strlen(text) - 1] != ' ';
        if (tight && saltus_constant_value(text, value, NULL) == SALTUS_OK)
            return NULL;
        bool infinite = !plain && *text && (strpbrk(text, "nN") || strchr(text, 'f'));
        return infinite ? "must be a finite number" : "must be a number";
    }
    if (!isfinite(read))
        return "must be a finite number; this one is too large";
    *value = read;
    return NULL;
}

const char *saltus_read_number_until(const char *text, const char *ends, double *value) {
    char word[number_size];
    size_t length = 0;
    for (int depth = 0; text[length] && (depth > 0 || !strchr(ends, text[length])); length++)
        depth += (text[length] == '(') - (text[length] == ')');
    if (length >= sizeof word)
        return NULL;
    memcpy(word, text, length);
    word[length] = '\0';
    return saltus_read_number(word, value) ? NULL : text + length;
}

const char *saltus_read_stop(saltus_stop *stop, int key, const char *text) {
    static const char *const names[] = {
        [SALTUS_UPPER] = "upper", [SALTUS_LOWER] = "lower", [SALTUS_BOTH] = "both"};
    double *const number[] = {[stop_xi] = &stop->xi, [stop_d] = &stop->d, [stop_r] = &stop->r};
    if (key != stop_sides)
        return saltus_read_number(text, number[key]);
    for (int side = SALTUS_UPPER; side <= SALTUS_BOTH; side++)
        if (strcmp(text, names[side]) == 0) {
            stop->sides = (saltus_sides)side;
            return NULL;
        }
    return "must be upper, lower or both";
}

saltus_quoted saltus_quote(const char *text) {
    enum { shown = 40 };
    saltus_quoted quoted;
    size_t length = strlen(text), kept = length < shown ? length : shown;
    /* Cut before the first byte of a character, not within one. */
    while (kept > 0 && kept < length && ((unsigned char)text[kept] & 0xc0) == 0x80)
        kept--;
    char *out = quoted.text;
    *out++ = '"';
    for (size_t k = 0; k < kept; k++)
        *out++ = (unsigned char)text[k] < 0x20 || text[k] == 0x7f ? ' ' : text[k];
    strcpy(out, kept < length ? "...\"" : "\"");
    return quoted;
}

saltus_words saltus_words_of(const char *const *words, int count) {
    saltus_words list = {""};
    for (int k = 0; k < count; k++)
        saltus_words_add(&list, words[k]);
    return list;
}

void saltus_words_add(saltus_words *words, const char *word) {
    size_t used = strlen(words->text);
    snprintf(words->text + used, sizeof words->text - used, "%s%s", used ? ", " : "", word);
}

saltus_status saltus_kind_fail(const saltus_source *source, const saltus_node *node, const char *wanted) {
    return saltus_node_fail(source, node, "%s: must be %s", node->key, wanted);
}

saltus_status saltus_unknown_key(const saltus_source *source, int line, const char *key,
                                 const char *const *keys, int count) {
    saltus_quoted name = saltus_quote(key);
    const char *nearest = saltus_nearest_word(key, keys, count);
    saltus_source_fail(source, line, SALTUS_BAD_INPUT, "%s: unknown key; %s %s%s", name.text,
                       nearest ? "did you mean" : "the keys here are",
                       nearest ? nearest : saltus_words_of(keys, count).text, nearest ? "?" : "");
    if (source->message)
        snprintf(source->message->key, sizeof source->message->key, "%s", key);
    return SALTUS_BAD_INPUT;
}
