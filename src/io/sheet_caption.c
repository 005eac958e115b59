/* The words of a sheet, in gnuplot's enhanced text inside single quotes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/describe.h"
#include "io/sheet.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

/* Text under construction; what does not fit is cut off. */
typedef struct line {
    char text[1024];
    size_t length;
} line;

static void add(line *l, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(l->text + l->length, sizeof l->text - l->length, format, arguments);
    va_end(arguments);
    if (length > 0)
        l->length +=
            (size_t)length < sizeof l->text - l->length ? (size_t)length : sizeof l->text - l->length - 1;
}

/* Text that is not ours, with nothing that enhanced text or a quoted string takes for a command. */
static void add_plain(line *l, const char *text) {
    for (const char *c = text; *c; c++) {
        if (strchr("_^{}@&~\\", *c))
            add(l, "\\%c", *c);
        else if (*c == '\'')
            add(l, "''");
        else if ((unsigned char)*c >= 0x20 && *c != 0x7f)
            add(l, "%c", *c);
    }
}

/* Numbers with a true minus sign. */
static void add_number(line *l, const char *format, double value) {
    char text[64];
    snprintf(text, sizeof text, format, fabs(value));
    add(l, "%s%s", value < 0 ? "−" : "", text);
}

/* The symbol of a parameter: a Greek letter or an italic Latin one, digits as subscripts. */
static void add_symbol(line *l, const char *name) {
    static const char *const greek[][2] = {{"alpha", "α"}, {"beta", "β"},  {"kappa", "κ"},
                                           {"sigma", "σ"}, {"omega", "ω"}, {"xi", "ξ"}};
    for (size_t k = 0; k < sizeof greek / sizeof greek[0]; k++)
        if (strcmp(name, greek[k][0]) == 0) {
            add(l, "{/:Italic %s}", greek[k][1]);
            return;
        }
    add(l, "{/:Italic %c}", name[0]);
    if (name[1])
        add(l, "_{%s}", name + 1);
}

/* The coordinate that a stop limits, w1 x1 + w2 x2, without zeros and ones. */
static void add_weights(line *l, const double weight[2]) {
    bool first = true;
    for (int i = 0; i < 2; i++) {
        if (weight[i] == 0)
            continue;
        add(l, "%s", weight[i] < 0 ? (first ? "−" : " − ") : first ? "" : " + ");
        if (fabs(weight[i]) != 1)
            add(l, "%.6g ", fabs(weight[i]));
        add(l, "{/:Italic x}_%d", i + 1);
        first = false;
    }
}

static void add_stop(line *l, const saltus_sheet *sheet, int s) {
    const saltus_spec *spec = saltus_system_spec(sheet->system);
    const saltus_stop *stop = &spec->stops[s];
    static const char *const side[] = {"", "upper", "lower", "both sides"};
    add(l, spec->stop_count > 1 ? "stop %d: " : "stop: ", s + 1);
    if (saltus_is_pipe(sheet->system)) {
        add_symbol(l, "xi");
        add(l, " = %.6g, ", stop->xi);
    } else if (saltus_system_dof(sheet->system) > 1) {
        add_weights(l, stop->weight);
        add(l, ", ");
    }
    add_symbol(l, "d");
    add(l, " = ");
    add_number(l, "%.6g", stop->d);
    add(l, ", ");
    add_symbol(l, "r");
    add(l, " = %.6g, %s", stop->r, side[stop->sides]);
}

static void add_parameters(line *l, const saltus_sheet *sheet) {
    const saltus_spec *spec = saltus_system_spec(sheet->system);
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    add(l, "%s: ", saltus_model_name(spec->model));
    const char *separator = "";
    for (int k = 0; k < count; k++)
        if (saltus_parameter_shown(spec, k)) {
            add(l, "%s", separator);
            add_symbol(l, p[k].name);
            add(l, " = ");
            add_number(l, "%.6g", spec->parameters[k]);
            separator = ", ";
        }
    for (int s = 0; s < spec->stop_count; s++) {
        add(l, ";  ");
        add_stop(l, sheet, s);
    }
    if (spec->stop_count == 0)
        add(l, ";  no stop");
}

static void add_motion(line *l, const saltus_sheet *sheet) {
    const saltus_motion *m = sheet->motion;
    if (m->kind == SALTUS_UNDECIDED)
        add_plain(l, m->reason);
    else if (m->kind == SALTUS_EQUILIBRIUM)
        add(l, "at rest, clear of every stop");
    else if (m->kind == SALTUS_HELD)
        add(l, "in contact for good");
    else if (m->impacts < 0)
        add(l, "complete chatter, %d sticking interval%s in %d {/:Italic T}", m->sticking_intervals,
            m->sticking_intervals == 1 ? "" : "s", m->periods);
    else if (m->impacts == 0)
        add(l, "no impact in %d {/:Italic T}", m->periods);
    else
        add(l, "%lld impact%s in %d {/:Italic T}, %.4g per response cycle%s", m->impacts,
            m->impacts == 1 ? "" : "s", m->periods, saltus_impacts_per_response(sheet->system, m),
            saltus_is_pipe(sheet->system) ? " 2{/:Italic T}" : "");
    if (m->kind == SALTUS_PERIODIC && m->mirror != SALTUS_MIRROR_NONE)
        add(l, ";  %s", m->mirror == SALTUS_MIRROR_SELF ? "its own mirror image" : "one of a mirror pair");
}

/* The leading multipliers; a complex pair is named once, with its modulus. */
static void add_multipliers(line *l, const saltus_motion *m) {
    enum { leading = 4 };
    if (m->kind == SALTUS_UNDECIDED || m->multiplier_count == 0)
        return;
    add(l, ";  Floquet multipliers ");
    for (int k = 0; k < m->multiplier_count && k < leading; k++) {
        const saltus_multiplier *f = &m->multipliers[k];
        bool pair = saltus_multiplier_pair(m, k);
        add(l, k ? ",  " : "");
        add_number(l, "%.4g", f->re);
        if (f->im != 0)
            add(l, " %s %.4g{/:Italic i} (modulus %.4g)",
                pair        ? "±"
                : f->im < 0 ? "−"
                            : "+",
                fabs(f->im), exp(f->log_modulus));
        k += pair;
    }
    add(l, m->multiplier_count > leading ? ", …" : "");
}

/* What is shown of a motion that is no closed orbit. */
static void add_stretch(line *l, const saltus_sheet *sheet) {
    const saltus_record *r = sheet->record;
    if (!sheet->orbit)
        add(l, ";  shown: %.6g periods", r->time[sheet->rows - 1] - r->time[0]);
}

/* Length of the piece of enhanced text that fits into one line of the sheet, broken at a blank outside
 * braces. */
static size_t piece(const char *text) {
    enum { widest = 150 };
    size_t fits = 0, word = 0;
    int depth = 0, shown = 0;
    for (size_t k = 0; text[k]; k++) {
        if (strncmp(text + k, "{/:Italic ", 10) == 0) {
            k += 9;
            depth++;
        } else if (text[k] == '{' || text[k] == '}')
            depth += text[k] == '{' ? 1 : -1;
        else if (text[k] == ' ' && depth == 0) {
            word = k;
            if (k && shown > widest / 2 && strchr(",;", text[k - 1]))
                fits = k;
            shown++;
        } else if (text[k] != '_' && text[k] != '\\' && ((unsigned char)text[k] & 0xc0) != 0x80)
            shown++;
        if (shown > widest && word)
            return fits ? fits : word;
    }
    return strlen(text);
}

/* One line or more of the header; the height of the next in *height. */
static void put_lines(FILE *file, const line *l, const char *colour, double *height) {
    const char *text = l->text;
    while (*text) {
        size_t length = piece(text);
        fprintf(file, "set label '%.*s' at screen 0.03,%.4f left front tc rgb '%s'\n", (int)length, text,
                *height, colour);
        *height -= 0.0255;
        text += length;
        text += strspn(text, " ");
    }
}

double saltus_sheet_caption(const saltus_sheet *sheet) {
    char verdict[64];
    line head = {.length = 0}, title = {.length = 0}, parameters = {.length = 0}, motion = {.length = 0};
    double height = 0.932;
    saltus_verdict(sheet->motion, verdict);
    add_plain(&head, sheet->scene->name);
    add(&head, ":  ");
    add_plain(&head, verdict);
    add_plain(&title, sheet->scene->title);
    add_parameters(&parameters, sheet);
    add_motion(&motion, sheet);
    add_multipliers(&motion, sheet->motion);
    add_stretch(&motion, sheet);
    fprintf(sheet->file, "set label '{/=20:Bold %s}' at screen 0.03,0.967 left front\n", head.text);
    put_lines(sheet->file, &title, "#606060", &height);
    put_lines(sheet->file, &parameters, "#202020", &height);
    put_lines(sheet->file, &motion, "#202020", &height);
    return height;
}

static const char *bracketed(const saltus_sheet *sheet, char *text, size_t room) {
    const saltus_spec *spec = saltus_system_spec(sheet->system);
    double xi = spec->stop_count ? spec->stops[0].xi : 0.5;
    if (xi == 0.5)
        snprintf(text, room, "(½, {/:Italic τ})");
    else
        snprintf(text, room, "(%.4g, {/:Italic τ})", xi);
    return text;
}

/* The observed coordinate of an oscillator; false when it is no single mass. */
static bool single_mass(const saltus_sheet *sheet, int *mass) {
    const double *observer = saltus_system_observer(sheet->system);
    bool two = saltus_system_dof(sheet->system) > 1;
    *mass = observer[0] == 1 ? 1 : 2;
    return two ? observer[0] + observer[1] == 1 && observer[0] * observer[1] == 0 : observer[0] == 1;
}

void saltus_sheet_displacement_name(const saltus_sheet *sheet, char *text, size_t room) {
    char place[64];
    int mass;
    if (saltus_is_pipe(sheet->system))
        snprintf(text, room, "displacement {/:Italic η}%s", bracketed(sheet, place, sizeof place));
    else if (single_mass(sheet, &mass))
        snprintf(text, room, "displacement {/:Italic x}_%d", mass);
    else
        snprintf(text, room, "contact coordinate {/:Italic g}");
}

void saltus_sheet_velocity_name(const saltus_sheet *sheet, char *text, size_t room) {
    char place[64];
    int mass;
    if (saltus_is_pipe(sheet->system))
        snprintf(text, room, "velocity ∂{/:Italic η}/∂{/:Italic τ} %s",
                 bracketed(sheet, place, sizeof place));
    else if (single_mass(sheet, &mass))
        snprintf(text, room, "velocity d{/:Italic x}_%d/d{/:Italic t}", mass);
    else
        snprintf(text, room, "velocity d{/:Italic g}/d{/:Italic t}");
}
