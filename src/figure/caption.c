/* Lines of text for figures, in gnuplot's enhanced text, and how text enters a script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/caption.h"

#include "record/describe.h"
#include "scene/document.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void saltus_line_add_list(saltus_line *l, const char *format, va_list arguments) {
    const size_t room = sizeof l->text - l->length;
    const int length = vsnprintf(l->text + l->length, room, format, arguments);
    if (length > 0)
        l->length += (size_t)length < room ? (size_t)length : room - 1;
}

void saltus_line_add(saltus_line *l, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    saltus_line_add_list(l, format, arguments);
    va_end(arguments);
}

saltus_line *saltus_line_next(saltus_line *l) {
    saltus_line_add(l, "%s", l->length ? ";  " : "");
    return l;
}

void saltus_line_plain(saltus_line *l, const char *text) {
    for (const char *c = text; *c; c++) {
        if (strchr("_^{}@&~\\", *c))
            saltus_line_add(l, "\\%c", *c);
        else
            saltus_line_add(l, "%c", (unsigned char)*c < 0x20 ? ' ' : *c);
    }
}

/* A number as printed by C: with minus signs, and an exponent as a power of ten. */
static void add_printed(saltus_line *l, const char *number) {
    for (const char *c = number; *c; c++) {
        int power = 0, length = 0;
        if (*c == 'e' && strchr("+-", c[1]) && sscanf(c + 1, "%d%n", &power, &length) == 1) {
            saltus_line_add(l, "·10^{%s%d}", power < 0 ? "−" : "", abs(power));
            c += length;
        } else if (*c == '-')
            saltus_line_add(l, "−");
        else
            saltus_line_add(l, "%c", *c);
    }
}

void saltus_line_number(saltus_line *l, const char *format, double value) {
    char text[128];
    snprintf(text, sizeof text, format, value == 0 ? 0 : value); /* no minus before a zero */
    add_printed(l, text);
}

/* The index after a letter (k2, F02, kz, mu_m); NULL if it is the rest of a word (gap). */
static const char *index_of(const char *rest) {
    bool index = strspn(rest, "0123456789") == strlen(rest) || (strlen(rest) == 1 && rest[0] != '_');
    return index ? rest : rest[0] == '_' && rest[1] && !strchr(rest + 1, '_') ? rest + 1 : NULL;
}

void saltus_line_symbol(saltus_line *l, const char *name) {
    static const char *const greek[][2] = {
        {"alpha", "α"},  {"beta", "β"}, {"gamma", "γ"}, {"delta", "δ"}, {"epsilon", "ε"}, {"eps", "ε"},
        {"zeta", "ζ"},   {"eta", "η"},  {"theta", "θ"}, {"kappa", "κ"}, {"lambda", "λ"},  {"mu", "μ"},
        {"nu", "ν"},     {"xi", "ξ"},   {"rho", "ρ"},   {"sigma", "σ"}, {"tau", "τ"},     {"phi", "φ"},
        {"chi", "χ"},    {"psi", "ψ"},  {"omega", "ω"}, {"Gamma", "Γ"}, {"Delta", "Δ"},   {"Theta", "Θ"},
        {"Lambda", "Λ"}, {"Xi", "Ξ"},   {"Pi", "Π"},    {"Sigma", "Σ"}, {"Phi", "Φ"},     {"Psi", "Ψ"},
        {"Omega", "Ω"}};
    char letter[8] = {name[0]};
    const char *index = NULL;
    for (size_t k = 0; k < sizeof greek / sizeof greek[0] && !index; k++) {
        size_t length = strlen(greek[k][0]);
        if (strncmp(name, greek[k][0], length) == 0 && (index = index_of(name + length)) != NULL)
            strcpy(letter, greek[k][1]);
    }
    index = index ? index : index_of(name + 1);
    saltus_line_add(l, "{/:Italic ");
    saltus_line_plain(l, index ? letter : name);
    saltus_line_add(l, "}");
    if (index && *index) {
        saltus_line_add(l, "_{");
        saltus_line_plain(l, index);
        saltus_line_add(l, "}");
    }
}

void saltus_line_value(saltus_line *l, const char *name, double value) {
    saltus_line_symbol(l, name);
    saltus_line_number(l, " = %.6g", value);
}

void saltus_line_state(saltus_line *l, const saltus_system *system, int entry) {
    const int dof = saltus_system_dof(system);
    const bool rate = entry >= dof && entry < 2 * dof;
    saltus_state_name name = saltus_system_state_name(system, rate ? entry - dof : entry);
    saltus_line_add(l, "{/:Italic ");
    saltus_line_plain(l, name.text);
    saltus_line_add(l, "}%s", rate ? "′" : "");
}

/* Whether one of two keys (may be NULL) is the property `name` of stop s. */
static bool varies(const char *const varied[2], const char *name, int s) {
    return (varied[0] && saltus_key_means(varied[0], name, s)) ||
           (varied[1] && saltus_key_means(varied[1], name, s));
}

static void add_stop(saltus_line *l, const saltus_system *system, int s, const char *const varied[2]) {
    const saltus_spec *spec = saltus_system_spec(system);
    const saltus_stop *stop = &spec->stops[s];
    static const char *const side[] = {"", "upper", "lower", "both sides"};
    saltus_line_add(l, spec->stop_count > 1 ? "stop %d: " : "stop: ", s + 1);
    const char *key = saltus_model_stop_key(spec->model);
    int count;
    const double *place = saltus_stop_place(spec->model, stop, &count);
    if (count == 1 && !varies(varied, key, s)) {
        saltus_line_value(l, key, *place);
        saltus_line_add(l, ", ");
    } else if (count > 1 && saltus_system_dof(system) > 1) {
        /* w1 x1 + w2 x2, without zeros and ones */
        for (int i = 0, terms = 0; i < 2; i++) {
            if (place[i] == 0)
                continue;
            saltus_line_add(l, "%s", place[i] < 0 ? (terms ? " − " : "−") : terms ? " + " : "");
            if (fabs(place[i]) != 1)
                saltus_line_number(l, "%.6g ", fabs(place[i]));
            saltus_line_add(l, "{/:Italic x}_%d", i + 1);
            terms++;
        }
        saltus_line_add(l, ", ");
    } else if (count == 0) {
        saltus_line_add(l, "{/:Italic ");
        saltus_line_plain(l, saltus_stop_text(spec, s, SALTUS_STOP_COORDINATE));
        saltus_line_add(l, "}, ");
    }
    if (!varies(varied, "d", s)) {
        saltus_line_value(l, "d", stop->d);
        saltus_line_add(l, ", ");
    }
    if (!varies(varied, "r", s)) {
        const char *law = saltus_restitution_law(spec, s);
        if (law) {
            saltus_line_symbol(l, "r");
            saltus_line_add(l, " = ");
            saltus_line_plain(l, law);
        } else
            saltus_line_value(l, "r", stop->r);
        saltus_line_add(l, ", ");
    }
    saltus_line_add(l, "%s", side[stop->sides]);
}

void saltus_line_parameters(saltus_line *l, const saltus_system *system, const char *const varied[2]) {
    const saltus_spec *spec = saltus_system_spec(system);
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    saltus_line_add(l, "%s: ", saltus_model_name(spec->model));
    for (int k = 0, shown = 0; k < count; k++) {
        bool left_out = (varied[0] && strcmp(varied[0], p[k].name) == 0) ||
                        (varied[1] && strcmp(varied[1], p[k].name) == 0);
        if (left_out || !saltus_parameter_shown(spec, k))
            continue;
        saltus_line_add(l, "%s", shown++ ? ", " : "");
        saltus_line_value(l, p[k].name, spec->parameters[k]);
    }
    for (int s = 0; s < spec->stop_count; s++) {
        saltus_line_add(l, ";  ");
        add_stop(l, system, s, varied);
    }
    if (spec->stop_count == 0)
        saltus_line_add(l, ";  no stop");
}

/* Pass one letter of a text, or an element that only formats it: a brace with its command, an index. Returns
 * the letter's width; 0 if nothing is visible. */
static double pass_letter(const char **text, int *depth) {
    /* Advances of the ASCII letters from the blank on, in hundredths. */
    static const unsigned char ascii[] = {
        32, 40, 46, 84, 64, 95, 78, 27, 39,  39, 50, 84, 32, 36, 32, 34, 64, 64, 64, 64, 64, 64, 64, 64,
        64, 64, 34, 34, 84, 84, 84, 53, 100, 68, 69, 70, 77, 63, 58, 77, 75, 29, 29, 66, 56, 86, 75, 79,
        60, 79, 69, 63, 61, 73, 68, 99, 69,  61, 69, 39, 34, 39, 84, 50, 50, 61, 63, 55, 63, 62, 35, 63,
        63, 28, 28, 58, 28, 97, 63, 61, 63,  63, 41, 52, 39, 63, 59, 82, 59, 59, 52, 64, 34, 64, 84};
    static const struct {
        const char *letter;
        double width;
    } others[] = {{"·", 0.32}, {"′", 0.23}, {"∂", 0.52}, {"–", 0.5}, {"ω", 0.84},
                  {"±", 0.84}, {"×", 0.84}, {"½", 0.97}, {"−", 0.84}};
    const double two_bytes = 0.66, more_bytes = 1;
    const char *begin = *text;
    const unsigned char c = (unsigned char)*(*text)++;
    if (c == '\\' && **text) { /* an escaped letter is itself */
        const unsigned char own = (unsigned char)*(*text)++;
        return own >= ' ' && own < 0x7f ? 0.01 * ascii[own - ' '] : two_bytes;
    }
    if (c == '{' || c == '}')
        *depth += c == '{' ? 1 : -1;
    if (c == '{' && **text == '/')
        *text += strcspn(*text, " ") + (strchr(*text, ' ') != NULL);
    if (strchr("{}_^", c) || (c & 0xc0) == 0x80)
        return 0;
    if (c < 0x7f)
        return c < ' ' ? 0 : 0.01 * ascii[c - ' '];
    for (size_t k = 0; k < sizeof others / sizeof others[0]; k++)
        if (strncmp(begin, others[k].letter, strlen(others[k].letter)) == 0)
            return others[k].width;
    return c < 0xe0 ? two_bytes : more_bytes;
}

/* Where the parenthesis that begins at a text ends, if it is short and stays on one line; else the text. */
static const char *short_parenthesis(const char *text) {
    const double most = 4;
    const char *end = text;
    int depth = 0;
    double width = 0;
    while (*end && *end != ')' && width < most)
        width += pass_letter(&end, &depth);
    return *end == ')' ? end : text;
}

size_t saltus_line_piece(const char *text, double width) {
    size_t fits = 0, word = 0;
    int depth = 0;
    double shown = 0;
    const char *held = text; /* no line ends before */
    for (const char *c = text; *c;) {
        const size_t k = (size_t)(c - text);
        if (*c == '(')
            held = short_parenthesis(c);
        const double letter = pass_letter(&c, &depth);
        const bool signed_number =
            strncmp(c, "±", strlen("±")) == 0 || (k > 1 && strncmp(text + k - 2, "±", 2) == 0);
        if (text[k] == ' ' && depth == 0 && text + k >= held && !signed_number) {
            word = k;
            if (k && shown > 0.45 * width && strchr(",;", text[k - 1]))
                fits = k;
        }
        shown += letter;
        if (letter > 0 && shown > width && (word || depth == 0)) /* a word longer than the line is broken */
            return fits ? fits : word ? word : k ? k : (size_t)(c - text);
    }
    return strlen(text);
}

double saltus_line_width(const char *text) {
    int depth = 0;
    double width = 0;
    while (*text)
        width += pass_letter(&text, &depth);
    return width;
}

void saltus_put_quoted(FILE *script, const char *text, size_t length) {
    int open = 0;
    fputc('\'', script);
    for (size_t k = 0, bytes; k < length; k += bytes) {
        const bool escape = text[k] == '\\';
        const size_t at = k + escape;
        bytes = at < length ? saltus_letter_bytes(text + at, length - at) : 0;
        const bool control = bytes == 1 && ((unsigned char)text[at] < 0x20 || text[at] == 0x7f);
        if (!bytes || control || (!escape && text[at] == '}' && open == 0)) {
            bytes = 1 + escape;
            continue;
        }
        open += escape ? 0 : (text[at] == '{') - (text[at] == '}');
        if (escape)
            fputc('\\', script);
        if (text[at] == '\'')
            fputc('\'', script);
        fwrite(text + at, 1, bytes, script);
        bytes += escape;
    }
    for (; open > 0; open--)
        fputc('}', script);
    fputc('\'', script);
}

void saltus_line_observed(saltus_line *l, const saltus_system *system, bool velocity) {
    const double *observer = saltus_system_observer(system), xi = saltus_system_observed_place(system);
    bool single_mass = saltus_system_dof(system) > 1
                           ? observer[0] + observer[1] == 1 && observer[0] * observer[1] == 0
                           : observer[0] == 1;
    saltus_line number = {.length = 0};
    saltus_line_number(&number, "%.4g", xi);
    const char *place = xi == 0.5 ? "½" : number.text;
    const saltus_notation *n = saltus_notation_of(system);
    const char *x = n->displacement, *t = n->time, *own = saltus_system_observed_name(system);
    const int mass = observer[0] == 1 ? 1 : 2;
    if (own) {
        char shown[120];
        snprintf(shown, velocity ? 80 : sizeof shown, "%s", own);
        saltus_line_add(l, velocity ? "velocity d({/:Italic " : "{/:Italic ");
        saltus_line_plain(l, shown);
        saltus_line_add(l, velocity ? "})/d{/:Italic %s}" : "}", t);
    } else if (n->structure == SALTUS_STRUCTURE_LINE && velocity)
        saltus_line_add(l, "velocity ∂{/:Italic %s}/∂{/:Italic %s} (%s, {/:Italic %s})", x, t, place, t);
    else if (n->structure == SALTUS_STRUCTURE_LINE)
        saltus_line_add(l, "displacement {/:Italic %s}(%s, {/:Italic %s})", x, place, t);
    else if (single_mass && velocity)
        saltus_line_add(l, "velocity d{/:Italic %s}_%d/d{/:Italic %s}", x, mass, t);
    else if (single_mass)
        saltus_line_add(l, "displacement {/:Italic %s}_%d", x, mass);
    else if (velocity)
        saltus_line_add(l, "velocity d{/:Italic g}/d{/:Italic %s}", t);
    else
        saltus_line_add(l, "contact coordinate {/:Italic g}");
}

void saltus_line_parameter(saltus_line *line, const saltus_spec *spec, const char *key) {
    int count, stops;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    const saltus_parameter *s = saltus_stop_parameters(&stops);
    const char *meaning = "";
    for (int k = 0; k < stops; k++)
        if (strncmp(key, s[k].name, strlen(s[k].name)) == 0)
            meaning = s[k].meaning;
    for (int k = 0; k < count; k++)
        if (strcmp(key, p[k].name) == 0)
            meaning = p[k].meaning;
    if (!strchr(meaning, '^') && *meaning) {
        char words[256];
        snprintf(words, sizeof words, "%.*s", (int)strcspn(meaning, ",;("), meaning);
        saltus_line_plain(line, words);
        saltus_line_add(line, "  ");
    }
    saltus_line_symbol(line, key);
}

void saltus_line_uncertain(saltus_line *line, double value, double error) {
    const saltus_uncertain number = saltus_uncertain_text(value, error);
    add_printed(line, number.value);
    saltus_line_add(line, " ± ");
    add_printed(line, number.error);
}
