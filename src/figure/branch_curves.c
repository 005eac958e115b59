/* The parts of a bifurcation diagram that can be drawn over other figures: curves, marks and their legend.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include <math.h>
#include <string.h>

static const char *const hues[SALTUS_HUES] = {"#2c5f8a", "#c44e2a", "#1f9e89", "#8a5aa0",
                                              "#b08a00", "#555555", "#b0006a"};

/* How special points are marked, and what they are. */
static const struct {
    int point_type;
    double size;
    const char *colour, *meaning;
} marks[SALTUS_PLOT_MARKS] = {
    [SALTUS_POINT_LP] = {5, 1.15, "#1c1c1c", "LP  fold"},
    [SALTUS_POINT_PD] = {13, 1.5, "#7b1fa2", "PD  flip"},
    [SALTUS_POINT_NS] = {9, 1.4, "#0077a8", "NS  torus"},
    [SALTUS_POINT_BP] = {7, 1.2, "#0a7d32", "BP  branch point"},
    [SALTUS_POINT_GR] = {11, 1.4, "#d95f02", "GR  grazing"},
    [SALTUS_POINT_CH] = {15, 1.4, "#7209b7", "CH  chatter"},
    [SALTUS_POINT_ST] = {4, 1.2, "#3a5a98", "ST  sticking"},
    [SALTUS_POINT_UZ] = {6, 1.1, "#404040", "UZ  wanted"},
    [SALTUS_POINT_EP] = {2, 1.1, "#606060", "EP  end"},
    [SALTUS_POINT_HB] = {3, 1.5, "#b00020", "HB  Hopf"},
    [SALTUS_POINT_BE] = {10, 1.4, "#00696b", "BE  equilibrium meets a stop"},
    [SALTUS_POINT_CP] = {12, 1.4, "#1c1c1c", "codimension two, as named"},
};

/* What occurs on a page: hues of curves, strokes long enough to be seen, and kinds of marks. */
typedef struct content {
    bool hue[SALTUS_HUES], stroke[SALTUS_STROKES], kind[SALTUS_PLOT_MARKS];
} content;

/* Strokes of branches and of loci; an empty meaning needs no explanation. */
typedef struct stroke_look {
    const char *line, *meaning;
} stroke_look;
static const stroke_look strokes[2][SALTUS_STROKES] = {
    {{"lw 2.6", "stable"}, {"dt (9,6) lw 1.9", "unstable"}, {"dt (2,5) lw 1.3", "not admissible"}},
    {{"lw 2.6", ""}, {"dt (7,9) lw 1.2", "bounds no stable orbit"}, {"lw 1", ""}}};

/* The distance between two points, as a part of the panel's width or height. */
static double part_of_panel(const saltus_plot_page *page, const saltus_branch_point *a,
                            const saltus_branch_point *b) {
    const double across = saltus_plot_x(page, b) - saltus_plot_x(page, a),
                 up = saltus_plot_y(page, b) - saltus_plot_y(page, a);
    return fmax(fabs(across) / (page->x.high - page->x.low), fabs(up) / (page->y.high - page->y.low));
}

static content find_content(const saltus_plot_page *page) {
    const double seen = 0.02; /* of the panel */
    double length[SALTUS_STROKES] = {0};
    content c = {.hue = {false}};
    for (int i = 0; i < page->count; i++) {
        const saltus_branch_file *f = &page->files[i];
        for (int k = 0; k < f->point_count; k++) {
            const saltus_branch_point *point = &f->points[k];
            if (k == 0 || point->branch != point[-1].branch)
                c.hue[saltus_plot_hue(page, i, point->branch)] = true;
            const bool shown = saltus_plot_shown(page, point);
            const double x = saltus_plot_x(page, point), y = saltus_plot_y(page, point);
            if (shown && x >= page->x.low && x <= page->x.high && y >= page->y.low && y <= page->y.high &&
                saltus_plot_marked(f, point))
                c.kind[saltus_plot_mark(point->kind)] = true;
            if (k > 0 && point->branch == point[-1].branch && (shown || saltus_plot_shown(page, point - 1)))
                length[saltus_plot_stroke(f, k - 1, k)] += part_of_panel(page, point - 1, point);
        }
    }
    for (int stroke = 0; stroke < SALTUS_STROKES; stroke++)
        c.stroke[stroke] = length[stroke] > seen;
    return c;
}

static const char *hue_colour(const saltus_plot_page *page, int hue) {
    return page->locus ? marks[saltus_plot_locus(hue)].colour : hues[hue];
}

enum { name_lines = 6 };

/* Break a file's name in a legend on a page of this width into lines: their lengths in bytes. Returns how
 * many there are. */
static int name_file(const saltus_plot_page *page, int file, double width, saltus_line *name,
                     size_t length[name_lines]) {
    const double before = 64, em = 15.2; /* the sample and margins; the height of the type */
    int lines = 0;
    *name = (saltus_line){.length = 0};
    saltus_line_plain(name, page->files[file].scene);
    saltus_plot_add_differences(page, file, name);
    for (const char *rest = name->text; *rest && lines < name_lines; rest += length[lines++]) {
        length[lines] = saltus_line_piece(rest, (width - before) / em);
        length[lines] += strspn(rest + length[lines], " ");
    }
    return lines;
}

double saltus_plot_legend_height(const saltus_plot_page *page, double width, int *rows) {
    const double letter = 9.9, sign = 5.6 * letter, beside = width < 1000 ? 148 : 187, narrowest = 0.5;
    const bool files = page->count > 1 && !page->locus;
    const content c = find_content(page);
    int most = (int)(width / (page->locus || page->count > 1 ? 310 : 190)), entries = 0;
    /* gnuplot makes all entries as wide as the longest, in as many columns as fit into the panel. */
    double longest = 1; /* letters */
    for (int i = 0; i < page->count && files; i++) {
        saltus_line name, piece;
        size_t length[name_lines];
        const int lines = name_file(page, i, width, &name, length);
        const char *rest = name.text;
        for (int k = 0; k < lines; rest += length[k++]) {
            piece.length = 0;
            saltus_line_add(&piece, "%.*s", (int)length[k], rest);
            longest = fmax(longest, saltus_line_width(piece.text) / narrowest);
        }
        entries += lines;
    }
    for (int stroke = 0; stroke < SALTUS_STROKES; stroke++) {
        const char *meaning = strokes[page->locus][stroke].meaning;
        const bool named = c.stroke[stroke] && *meaning;
        longest = named ? fmax(longest, (double)strlen(meaning)) : longest;
        entries += named;
    }
    for (int hue = 0; hue < SALTUS_HUES; hue++)
        entries += page->locus && c.hue[hue];
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_PLOT_MARKS; kind++) {
        longest = c.kind[kind] ? fmax(longest, (double)strlen(marks[kind].meaning)) : longest;
        entries += c.kind[kind];
    }
    if (width < 1000 || files)
        most = (int)fmin(most, (width - beside) / (letter * longest + sign));
    const int columns = most > 1 ? most : 1, own = (entries + columns - 1) / columns;
    if (rows)
        *rows = own;
    return 10 + 19 * own;
}

double saltus_plot_legend_place(const saltus_plot_page *page) {
    int rows;
    double height = saltus_plot_legend_height(page, page->paper->width, &rows);
    saltus_page_legend(page->paper, rows);
    return height;
}

/* Curves, the stable ones on top; on a map each has a white rim. Loci also get signs. */
static void put_curves(const saltus_plot_page *page, const content *c) {
    for (int stroke = SALTUS_STROKES - 1; stroke >= 0; stroke--)
        for (int hue = 0; hue < SALTUS_HUES; hue++) {
            if (!c->hue[hue])
                continue;
            if (page->over_map)
                fprintf(page->paper->file,
                        "     $curve_%d_%d using 1:2 with lines lw %s lc rgb '#ffffff' notitle, \\\n", hue,
                        stroke, stroke ? "4" : "5.4");
            fprintf(page->paper->file, "     $curve_%d_%d using 1:2 with lines %s lc rgb '%s' notitle, \\\n",
                    hue, stroke, strokes[page->locus][stroke].line, hue_colour(page, hue));
        }
    /* Where loci lie on each other the lower ones show through as dashes. */
    int highest = 0;
    for (int hue = 0; hue < SALTUS_HUES; hue++)
        highest = c->hue[hue] ? hue : highest;
    for (int hue = 0; hue < highest && page->locus; hue++)
        if (c->hue[hue])
            fprintf(page->paper->file,
                    "     $curve_%d_%d using 1:2 with lines dt (7,7) lw 2.6 lc rgb '%s' notitle, \\\n", hue,
                    (int)SALTUS_STROKE_STABLE, hue_colour(page, hue));
    for (int hue = 0; hue < SALTUS_HUES && page->locus; hue++)
        if (c->hue[hue]) {
            const saltus_point_kind kind = saltus_plot_locus(hue);
            fprintf(page->paper->file,
                    "     $signs_%d using 1:2 with points pt %d ps %g lc rgb '#ffffff' notitle, \\\n"
                    "     $signs_%d using 1:2 with points pt %d ps %g lc rgb '%s' notitle, \\\n",
                    hue, marks[kind].point_type, 0.7 * marks[kind].size + 0.4, hue, marks[kind].point_type,
                    0.7 * marks[kind].size, marks[kind].colour);
        }
}

void saltus_plot_elements(const saltus_plot_page *page) {
    FILE *file = page->paper->file;
    const content c = find_content(page);
    put_curves(page, &c);
    /* Marks have a white rim that separates them from the curves. Kinds that would often be covered by others
     * are drawn last. */
    for (int kind = SALTUS_PLOT_MARKS - 1; kind >= SALTUS_POINT_LP; kind--) {
        bool solid = kind != SALTUS_POINT_EP && kind != SALTUS_POINT_UZ && kind != SALTUS_POINT_ST &&
                     kind != SALTUS_POINT_BE;
        if (c.kind[kind] && solid)
            fprintf(file, "     $marks_%d using 1:2 with points pt %d ps %g lc rgb '#ffffff' notitle, \\\n",
                    kind, marks[kind].point_type, marks[kind].size + 0.45);
        if (c.kind[kind])
            fprintf(file, "     $marks_%d using 1:2 with points pt %d ps %g lw 1.6 lc rgb '%s' notitle, \\\n",
                    kind, marks[kind].point_type, marks[kind].size, marks[kind].colour);
    }
    /* Legend of the lines: kinds of special points, or files. */
    for (int hue = 0; hue < SALTUS_HUES && page->locus; hue++)
        if (c.hue[hue])
            fprintf(file, "     NaN with linespoints lw %s pt %d ps %g lc rgb '%s' title '%s', \\\n",
                    saltus_plot_locus(hue) == SALTUS_POINT_HB ? "1.6"
                                                              : "2.6", /* a star of thick lines is a blot */
                    marks[saltus_plot_locus(hue)].point_type, 0.7 * marks[saltus_plot_locus(hue)].size,
                    hue_colour(page, hue), marks[saltus_plot_locus(hue)].meaning);
    for (int i = 0; i < page->count && page->count > 1 && !page->locus; i++) {
        saltus_line name;
        size_t length[name_lines];
        const int lines = name_file(page, i, page->paper->width, &name, length);
        const char *rest = name.text;
        for (int k = 0; k < lines; rest += length[k++]) {
            if (k == 0)
                fprintf(file, "     NaN with lines lw 2.6 lc rgb '%s' title ", hues[i % SALTUS_HUES]);
            else
                fputs("     NaN with lines lt nodraw title ", file);
            saltus_put_quoted(file, rest, length[k]);
            fputs(", \\\n", file);
        }
    }
    for (int stroke = 0; stroke < SALTUS_STROKES; stroke++) {
        const stroke_look *look = &strokes[page->locus][stroke];
        if (c.stroke[stroke] && *look->meaning)
            fprintf(file, "     NaN with lines %s lc rgb '#404040' title '%s', \\\n", look->line,
                    look->meaning);
    }
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_PLOT_MARKS; kind++)
        if (c.kind[kind])
            fprintf(file, "     NaN with points pt %d ps %g lw 1.6 lc rgb '%s' title '%s', \\\n",
                    marks[kind].point_type, marks[kind].size, marks[kind].colour, marks[kind].meaning);
    fputs("     NaN notitle\n", file);
}
