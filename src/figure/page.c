/* A page of a figure: its size, style, caption and script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/page.h"

#include "record/output.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

/* Pages of a requested size have type of eight points, where 13 are asked for. */
static const double smallest_type = 7 * 13 / 8.0;
static const double type_height = 96 / 72.0; /* units per point of type */
static const double tallest = 235;           /* of a journal's page, in millimetres */
static const double mm_per_unit = 8 * 25.4 / 72 / (13 * 96 / 72.0), usual_width = 1600, usual_height = 1200;

saltus_figure_options saltus_figure_defaults(void) {
    return (saltus_figure_options){.no_heading = false};
}

saltus_status saltus_figure_check(const char *path, const saltus_figure_options *look,
                                  saltus_message *message) {
    const double least = 30, most = 2000; /* millimetres */
    if (!saltus_path_ends(path, ".png") && !saltus_path_ends(path, ".pdf") && !saltus_path_ends(path, ".svg"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: the ending must be .png, .pdf or .svg", path);
    if (!look)
        return SALTUS_OK;
    if (look->width != 0 && (!(look->width >= least && look->width <= most) ||
                             (look->height != 0 && !(look->height >= least && look->height <= most))))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "a figure of %g x %g mm: width and height must be from %g to %g mm", look->width,
                           look->height, least, most);
    if (look->script && !saltus_path_ends(look->script, ".gp"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: the ending of a script must be .gp",
                           look->script);
    return SALTUS_OK;
}

saltus_status saltus_page_open(saltus_page *page, const char *path, const saltus_figure_options *look,
                               saltus_message *message) {
    saltus_status status = saltus_figure_check(path, look, message);
    if (status != SALTUS_OK)
        return status;
    *page = (saltus_page){.path = path, .look = look ? *look : saltus_figure_defaults()};
    page->lacking = &page->lack;
    page->width = page->look.width > 0 ? page->look.width / mm_per_unit : usual_width;
    page->free_height = page->look.width > 0 && !(page->look.height > 0);
    page->height = page->free_height       ? page->width * usual_height / usual_width
                   : page->look.height > 0 ? page->look.height / mm_per_unit
                                           : usual_height;
    page->file = saltus_nameless_file();
    return page->file ? SALTUS_OK
                      : saltus_fail(message, SALTUS_IO, "no temporary file can be made: %s", strerror(errno));
}

/* Copy the picture to its place; in an SVG file the size in units is replaced by the size on paper. */
static saltus_status deliver(const saltus_page *page, FILE *picture, saltus_message *message) {
    saltus_output output;
    char block[65536], units[64];
    size_t length, skipped = 0;
    saltus_status status = saltus_output_open(&output, page->path, message);
    if (status != SALTUS_OK)
        return status;
    rewind(picture);
    length = fread(block, 1, sizeof block - 1, picture);
    block[length] = '\0';
    snprintf(units, sizeof units, "width=\"%.0f\" height=\"%.0f\"", page->width, page->height);
    const char *place =
        page->look.width > 0 && saltus_path_ends(page->path, ".svg") ? strstr(block, units) : NULL;
    if (place) {
        skipped = (size_t)(place - block) + strlen(units);
        fwrite(block, 1, (size_t)(place - block), output.file);
        fprintf(output.file, "width=\"%.6gmm\" height=\"%.6gmm\"", page->width * mm_per_unit,
                page->height * mm_per_unit);
    }
    fwrite(block + skipped, 1, length - skipped, output.file);
    while ((length = fread(block, 1, sizeof block, picture)) > 0)
        fwrite(block, 1, length, output.file);
    if (ferror(picture))
        status = saltus_fail(message, SALTUS_IO, "the picture could not be read back: %s", strerror(errno));
    return saltus_output_close(&output, status, message);
}

/* Copy the script, and after its second line, the terminal, add the name of the figure, which will be drawn
 * in the current folder. */
static saltus_status keep_script(const saltus_page *page, saltus_message *message) {
    const char *name = saltus_path_name(page->path);
    saltus_output output;
    int lines = 0;
    saltus_status status = saltus_output_open(&output, page->look.script, message);
    if (status != SALTUS_OK)
        return status;
    rewind(page->file);
    for (int c; (c = fgetc(page->file)) != EOF;) {
        fputc(c, output.file);
        if (c != '\n' || ++lines != 2)
            continue;
        fputs("set output ", output.file);
        saltus_put_quoted(output.file, name, strlen(name));
        fputs("\n", output.file);
    }
    return saltus_output_close(&output, SALTUS_OK, message);
}

saltus_status saltus_page_close(saltus_page *page, saltus_status status, saltus_message *message) {
    FILE *picture = NULL;
    if (status == SALTUS_OK && (page->lack.width > 0 || page->lack.height > 0))
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "a figure of %.0f x %.0f mm has no room for its panels: %.0f x %.0f mm would be "
                             "enough%s",
                             page->width * mm_per_unit, page->height * mm_per_unit,
                             ceil((page->width + 3 * page->lack.width) * mm_per_unit),
                             ceil((page->height + page->lack.height * page->lack.rows) * mm_per_unit),
                             page->look.no_heading ? "" : ", or less without the heading (--no-heading)");
    if (status == SALTUS_OK && page->look.script)
        status = keep_script(page, message);
    if (status == SALTUS_OK)
        status = saltus_gnuplot_run(page->file, &picture, message);
    if (status == SALTUS_OK)
        status = deliver(page, picture, message);
    if (picture)
        fclose(picture);
    fclose(page->file);
    return status;
}

bool saltus_page_narrow(const saltus_page *page) {
    return page->width < 1000;
}

double saltus_page_type(const saltus_page *page, double size) {
    return page->look.width > 0 ? fmax(size, smallest_type) : size;
}

void saltus_page_label(const saltus_page *page, const char *text, double x, double y, const char *style,
                       ...) {
    va_list arguments;
    fputs("set label ", page->file);
    saltus_put_quoted(page->file, text, strlen(text));
    fprintf(page->file, " at screen %.6g,%.6g ", x / page->width, y / page->height);
    va_start(arguments, style);
    vfprintf(page->file, style, arguments);
    va_end(arguments);
    fputc('\n', page->file);
}

void saltus_page_graph_label(const saltus_page *page, const saltus_line *text, double x, double y,
                             int decimals, const char *style, ...) {
    va_list arguments;
    fputs("set label ", page->file);
    saltus_put_quoted(page->file, text->text, text->length);
    fprintf(page->file, " at graph %.*f,%.*f ", decimals, x, decimals, y);
    va_start(arguments, style);
    vfprintf(page->file, style, arguments);
    va_end(arguments);
    fputc('\n', page->file);
}

double saltus_page_width(const char *text, double size) {
    return size * type_height * saltus_line_width(text);
}

/* Lay out the caption from the page's upper edge downwards, and write it if `put`. */
static void lay_caption(saltus_page *page, bool put) {
    /* Type of a line of words and of the heading, and the steps from line to line. */
    static const struct {
        double margin, type[2], step[2], above;
    } layouts[] = {{48, {13, 20}, {30.6, 42}, 39.6}, {12, {11.5, 16}, {26, 34}, 26}};
    const double bold = 1.15; /* over regular type */
    const bool narrow = saltus_page_narrow(page);
    const double margin = layouts[narrow].margin, room = page->width - 2 * margin;
    page->top = page->height - (page->caption_lines ? layouts[narrow].above : 6);
    for (int k = 0; k < page->caption_lines; k++) {
        const bool heading = k == 0;
        const double usual = layouts[narrow].type[heading],
                     fits = floor(room / (bold * saltus_page_width(page->caption[k].text, 1)));
        /* A heading that is a little too long for one line is set in smaller type. */
        const double type = heading && fits >= 0.8 * usual ? fmin(usual, fits) : usual;
        const double width = room / (type * type_height * (heading ? bold : 1));
        char style[64] = "";
        if (!heading)
            snprintf(style, sizeof style, " tc rgb '%s'%s", page->colour[k], narrow ? " font ',11.5'" : "");
        for (const char *text = page->caption[k].text; *text; page->top -= layouts[narrow].step[heading]) {
            const int length = (int)saltus_line_piece(text, width);
            saltus_line piece = {.length = 0};
            if (heading)
                saltus_line_add(&piece, "{/=%.0f:Bold ", type);
            saltus_line_add(&piece, "%.*s%s", length, text, heading ? "}" : "");
            if (put)
                saltus_page_label(page, piece.text, margin, page->top, "%s", style);
            text += length;
            text += strspn(text, " ");
        }
        if (put && heading && !narrow)
            saltus_page_label(page, "Saltus " SALTUS_VERSION, page->width - 24, 14.4,
                              "right tc rgb '#909090' font ',9' front");
    }
}

saltus_line *saltus_page_words(saltus_page *page, const char *colour) {
    page->unseen.length = 0;
    if (page->look.no_heading || page->caption_lines == SALTUS_CAPTION_LINES)
        return &page->unseen;
    page->colour[page->caption_lines] = colour;
    return &page->caption[page->caption_lines++];
}

saltus_line *saltus_page_heading(saltus_page *page) {
    saltus_line *line = saltus_page_words(page, NULL);
    if (!page->look.title)
        return line;
    saltus_line_plain(line, page->look.title);
    return &page->unseen;
}

double saltus_page_caption_height(saltus_page *page) {
    lay_caption(page, false);
    return page->height - page->top;
}

void saltus_page_caption(saltus_page *page) {
    lay_caption(page, true);
}

void saltus_page_legend(const saltus_page *page, int rows) {
    fprintf(page->file,
            "set key at screen %.4f, screen %.4f left top horizontal Left reverse samplen 1.8 width 1 "
            "maxrows %d font ',%.4g' textcolor rgb '#303030'\n",
            saltus_page_narrow(page) ? 0.01 : 0.03, fmin(page->top + 9.6, page->height - 4) / page->height,
            rows, saltus_page_type(page, 11));
}

saltus_line *saltus_page_scene(saltus_page *page, const char *title, const saltus_system *system) {
    saltus_line *heading = saltus_page_heading(page);
    saltus_line_plain(saltus_page_words(page, "#606060"), title);
    saltus_line_parameters(saltus_page_words(page, "#202020"), system, (const char *const[2]){NULL, NULL});
    return heading;
}

double saltus_page_room(saltus_page *page) {
    return (page->free_height ? tallest / mm_per_unit : page->height) - saltus_page_caption_height(page);
}

void saltus_page_begin(saltus_page *page) {
    if (page->free_height && saltus_page_narrow(page))
        page->height += saltus_page_caption_height(page);
    if (page->free_height)
        page->height = fmin(page->height, tallest / mm_per_unit);
    lay_caption(page, false);
    /* Pages without a requested size are for screens; the others are for print, with 300 dots per inch. */
    const double inch = mm_per_unit / 25.4, dot = 300 * inch, points = 72 * inch;
    double w = page->width, h = page->height;
    bool sized = page->look.width > 0;
    fputs("# Saltus " SALTUS_VERSION ": a figure\nset terminal ", page->file);
    if (saltus_path_ends(page->path, ".png")) {
        fprintf(page->file, "pngcairo size %.0f,%.0f enhanced font 'DejaVu Sans,13' ", sized ? w * dot : w,
                sized ? h * dot : h);
        if (sized)
            fprintf(page->file, "fontscale %.5g linewidth %.5g pointscale %.5g ", dot, dot, dot);
        fputs("background '#ffffff' rounded\n", page->file);
    } else if (saltus_path_ends(page->path, ".svg"))
        fprintf(page->file,
                "svg size %.0f,%.0f %s enhanced font 'DejaVu Sans,17' background '#ffffff' rounded\n", w, h,
                sized ? "fixed" : "dynamic");
    else if (sized) /* in this terminal a font of 13 has 52/3 points */
        fprintf(page->file,
                "pdfcairo size %.5gin,%.5gin enhanced font 'DejaVu Sans,13' fontscale %.5g linewidth %.5g "
                "pointscale %.5g rounded\n",
                w * inch, h * inch, points, 1.42 * points, 1.42 * points);
    else
        fputs("pdfcairo size 11.69in,8.77in enhanced font 'DejaVu Sans,13' fontscale 0.58 linewidth 0.75 "
              "pointscale 0.75 rounded\n",
              page->file);
    saltus_page_template(page, "style");
}

saltus_frame saltus_page_rest(const saltus_page *page, double below) {
    bool narrow = saltus_page_narrow(page);
    return (saltus_frame){narrow ? 124 : 144, page->width - (narrow ? 24 : 43.2), narrow ? 74 : 93.6,
                          page->top - below};
}

saltus_frame saltus_page_cell(const saltus_page *page, int cell, int span, int columns, int rows) {
    /* Margins of the page and gaps between panels: on a wide page, on a narrow one, and there with several
     * columns, where headings have two lines. */
    static const struct {
        double left, right, beside, below, bottom, above;
    } layouts[] = {
        {128, 43.2, 156, 153.6, 100, 60}, {124, 24, 156, 125, 76, 60}, {102, 22, 112, 145, 76, 70}};
    const int kind = !saltus_page_narrow(page) ? 0 : columns > 1 ? 2 : 1;
    const double left = layouts[kind].left, below = layouts[kind].below, bottom = layouts[kind].bottom,
                 beside = kind == 0 && columns > 2 ? 140.8 : layouts[kind].beside;
    int column = cell % columns, row = rows - 1 - cell / columns;
    double width = (page->width - left - layouts[kind].right - (columns - 1) * beside) / columns,
           height = (page->top - layouts[kind].above - bottom - (rows - 1) * below) / rows;
    double x = left + column * (width + beside), y = bottom + row * (height + below);
    return (saltus_frame){x, x + span * width + (span - 1) * beside, y, y + height};
}

void saltus_page_panel(const saltus_page *page, saltus_frame frame, int letter, const char *heading, ...) {
    va_list arguments;
    bool narrow = saltus_page_narrow(page);
    const double left = narrow ? 62 : 0, size = narrow ? saltus_page_type(page, 11) : 13,
                 room = fmin(frame.right + (narrow ? 30 : 90), page->width - 6) - frame.left + left;
    saltus_line line = {.length = 0};
    saltus_page_frame(page, frame, SALTUS_PANEL_LEAST);
    saltus_line_add(&line, "{/:Bold (%c)}  ", 'a' + letter);
    va_start(arguments, heading);
    saltus_line_add_list(&line, heading, arguments);
    va_end(arguments);
    enum { most = 4 };
    const char *from[most + 1] = {line.text};
    size_t length[most];
    int lines = 0;
    for (; *from[lines] && lines < most; lines++) {
        length[lines] = saltus_line_piece(from[lines], room / (size * type_height));
        from[lines + 1] = from[lines] + length[lines];
        from[lines + 1] += strspn(from[lines + 1], " ");
    }
    for (int k = 0; k < lines; k++) {
        fprintf(page->file, "set label %d ", 99 - k);
        saltus_put_quoted(page->file, from[k], length[k]);
        fprintf(page->file, " at screen %.6g, screen %.6g offset 0,%g left front tc rgb '#202020'",
                (frame.left - left) / page->width, frame.top / page->height, 1.1 * (lines - k));
        fprintf(page->file, narrow ? " font ',%.4g'\n" : "\n", size);
    }
}

void saltus_page_frame(const saltus_page *page, saltus_frame frame, double least) {
    const double least_width = 10;
    const double high = frame.top - frame.bottom;
    page->lacking->width = fmax(page->lacking->width, least_width - (frame.right - frame.left));
    page->lacking->height = fmax(page->lacking->height, least - high);
    page->lacking->rows += least > 0 && page->lacking->bottom != frame.bottom;
    page->lacking->bottom = least > 0 ? frame.bottom : page->lacking->bottom;
    fprintf(page->file,
            "set lmargin at screen %.8f\nset rmargin at screen %.8f\nset bmargin at screen %.8f\n"
            "set tmargin at screen %.8f\n",
            frame.left / page->width, frame.right / page->width, frame.bottom / page->height,
            frame.top / page->height);
}

/* Tics of a logarithmic axis of this length: at 1, 2 and 5 times powers of ten, as far as their numbers fit;
 * over many decades at powers of ten only, as many as fit; over less than one equally spaced. Numbers may
 * extend `beyond` the end. */
static void put_log_tics(const saltus_page *page, const char *axis, double length, double beyond,
                         saltus_range range) {
    static const double parts[] = {1, 2, 5};
    const double letter = 9.5, apart = 8;
    double values[24], ratio = range.high / range.low, width = range.high - range.low;
    int count = 0, put = 0;
    if (ratio > 3000) {
        const double needed = *axis == 'x' ? 64 : 26, decades = log10(ratio),
                     step = ceil(decades * needed / length);
        fprintf(page->file, "set format %s '10^{%%T}'\nset %stics ", axis, axis);
        if (step > 1) {
            fputc('(', page->file);
            for (double power = step * ceil(log10(range.low) / step); power <= log10(range.high);
                 power += step)
                fprintf(page->file, "%s1e%.0f", put++ ? ", " : "", power);
            fputs(")\n", page->file);
        } else
            fputs("auto\n", page->file);
        return;
    }
    if (ratio < 4) { /* less than a decade: tics at 1, 2 and 5 would be too few */
        double decade = pow(10, floor(log10(width / 6)));
        double step = decade * (width / 6 < 1.5 * decade ? 1 : width / 6 < 3.5 * decade ? 2 : 5);
        for (double k = ceil(range.low / step); k * step <= range.high && count < 24; k++)
            values[count++] = k * step;
    } else
        for (double decade = pow(10, floor(log10(range.low))); decade <= range.high; decade *= 10)
            for (int k = 0; k < 3 && count < 24; k++)
                values[count++] = parts[k] * decade;
    fprintf(page->file, "set %stics (", axis);
    /* Skip numbers that would touch the one before or leave the page. */
    double taken = -INFINITY;
    for (int k = 0; k < count; k++) {
        char number[32];
        snprintf(number, sizeof number, "%.9g", values[k]);
        double place = length * saltus_range_part(range, true, values[k]),
               half = *axis == 'x' ? 0.5 * letter * (double)strlen(number) : letter;
        if (place < -1e-6 || place > length + 1e-6 || place - half < taken || place + half > length + beyond)
            continue;
        fprintf(page->file, "%s%s", put++ ? ", " : "", number);
        taken = place + half + apart;
    }
    fputs(")\n", page->file);
}

void saltus_page_axis(const saltus_page *page, const char *axis, saltus_frame panel, bool logarithmic,
                      const char *name, saltus_range range) {
    const bool narrow = saltus_page_narrow(page), across = *axis == 'x';
    /* Overhang at the ends; between columns of panels it would reach into their headings. */
    const double usual = 13,
                 over = narrow && !across && panel.right - panel.left < 0.5 * page->width ? 6 : 36;
    const double length = across ? panel.right - panel.left : panel.top - panel.bottom,
                 size = (length + over) / saltus_page_width(name, 1);
    fprintf(page->file, "set %slabel ", axis);
    /* A title that would not even fit in the smallest type has two lines, the second from a wide blank on if
     * there is one. */
    const size_t all = strlen(name);
    size_t first = all;
    if (page->look.width > 0 && size < smallest_type && *axis == 'y') {
        const char *wide = strstr(name, "  ");
        const double whole = saltus_line_width(name), after = wide ? saltus_line_width(wide + 2) : 0;
        first = 4 * after > whole ? (size_t)(wide - name) : saltus_line_piece(name, 0.62 * whole);
    }
    saltus_put_quoted(page->file, name, first);
    if (first < all) {
        const char *second = name + first + strspn(name + first, " ");
        fputs(".\"\\n\".", page->file);
        saltus_put_quoted(page->file, second, strlen(second));
    }
    fprintf(page->file, "%s",
            across                    ? ""
            : strcmp(axis, "y2") == 0 ? (narrow ? " offset -1,0" : " offset 0.8,0")
            : narrow                  ? " offset -0.2,0"
                                      : " offset -0.6,0");
    if (page->look.width > 0 && size < usual)
        fprintf(page->file, " font ',%.4g'", fmax(size, smallest_type));
    fprintf(page->file, "\nset %srange [%.12g:%.12g]\n", axis, range.low, range.high);
    if (logarithmic) {
        fprintf(page->file, "set logscale %s\n", axis);
        put_log_tics(page, axis, length, across ? fmin(page->width - panel.right, 20) : 20, range);
    } else if (narrow || length < 220) {
        /* Long numbers need room beside each other, but an axis needs at least two or three of them. */
        double tics = fmin(fmax(length / (across ? 45 : 24), 2), 5), step = saltus_page_tic_step(range, tics);
        if (floor(range.high / step) - ceil(range.low / step) < (tics < 5 ? 1 : 2))
            step /= 2;
        fprintf(page->file, "set %stics %.9g\n", axis, step);
    } else if (across) {
        /* Where the tics that gnuplot chooses would touch each other there are fewer. */
        const double usual_step = saltus_page_tic_step(range, 9),
                     needed = 10 * (double)saltus_page_tic_letters(range, usual_step) + 16;
        if (length * usual_step / (range.high - range.low) < needed)
            fprintf(page->file, "set xtics %.9g\n", saltus_page_tic_step(range, length / needed));
    }
}

size_t saltus_page_tic_letters(saltus_range range, double step) {
    size_t longest = 1;
    for (double tic = ceil(range.low / step); tic * step <= range.high; tic++) {
        char number[32];
        snprintf(number, sizeof number, "%.6g", fabs(tic) < 0.5 ? 0 : tic * step);
        longest = strlen(number) > longest ? strlen(number) : longest;
    }
    return longest;
}

double saltus_page_tic_step(saltus_range range, double tics) {
    static const double round[] = {1, 2, 5, 10};
    double least = (range.high - range.low) / tics;
    double power = pow(10, floor(log10(least)));
    int k = 0;
    while (k < 3 && round[k] * power < least)
        k++;
    return round[k] * power;
}

void saltus_page_number(const saltus_page *page, const char *name, double value) {
    fprintf(page->file, "%s = %.12g\n", name, value);
}

void saltus_page_text(const saltus_page *page, const char *name, const char *text, ...) {
    va_list arguments;
    saltus_line line = {.length = 0};
    va_start(arguments, text);
    saltus_line_add_list(&line, text, arguments);
    va_end(arguments);
    fprintf(page->file, "%s = ", name);
    saltus_put_quoted(page->file, line.text, line.length);
    fputc('\n', page->file);
}

void saltus_page_template(const saltus_page *page, const char *name) {
    for (int k = 0; k < saltus_template_count; k++)
        if (strcmp(saltus_templates[k].name, name) == 0)
            fputs(saltus_templates[k].text, page->file);
}

void saltus_page_draw(const saltus_page *page, const char *name) {
    saltus_page_template(page, name);
    saltus_page_template(page, "close");
}

void saltus_range_add(saltus_range *range, double value) {
    if (!isfinite(value))
        return;
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

void saltus_range_pad(saltus_range *range, double part, double scale) {
    double width = range->high - range->low, middle = 0.5 * (range->low + range->high);
    double size = fmax(scale, fabs(middle));
    size = size > 0 ? size : 1;
    if (!(width > 1e-6 * size)) {
        range->low = middle - size;
        range->high = middle + size;
        width = 2 * size;
    }
    range->low -= part * width;
    range->high += part * width;
}

double saltus_range_part(saltus_range range, bool logarithmic, double value) {
    return logarithmic ? log(value / range.low) / log(range.high / range.low)
                       : (value - range.low) / (range.high - range.low);
}

double saltus_range_value(saltus_range range, bool logarithmic, double part) {
    return logarithmic ? range.low * pow(range.high / range.low, part)
                       : range.low + part * (range.high - range.low);
}

void saltus_range_floor(saltus_range *range) {
    range->low = fmax(range->low, 1e-10 * range->high);
}
