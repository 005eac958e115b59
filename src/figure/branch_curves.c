/* The parts of a bifurcation diagram that can be drawn over other figures: curves, marks and their legend.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include <math.h>
#include <string.h>

enum { NONE = 0, DOT = 7, PLUS = 1, CROSS = 2 }; /* gnuplot's signs */
static const double inner_size = 0.4;

static const char *const hues[SALTUS_HUES] = {"#2c5f8a", "#c44e2a", "#1f9e89", "#8a5aa0",
                                              "#b08a00", "#555555", "#b0006a"};

/* How special points are marked, and what they are. Those of codimension two have open marks, which differ in
 * shape and in the sign `inner` amid them, so that each is known without its name. */
static const struct {
    int point_type;
    double size;
    const char *colour, *meaning;
    int inner;
} marks[SALTUS_POINT_KINDS] = {
    [SALTUS_POINT_LP] = {5, 1.15, "#1c1c1c", "LP  fold", NONE},
    [SALTUS_POINT_PD] = {13, 1.5, "#7b1fa2", "PD  flip", NONE},
    [SALTUS_POINT_NS] = {9, 1.4, "#0077a8", "NS  torus", NONE},
    [SALTUS_POINT_BP] = {7, 1.2, "#0a7d32", "BP  branch point", NONE},
    [SALTUS_POINT_GR] = {11, 1.4, "#d95f02", "GR  grazing", NONE},
    [SALTUS_POINT_CH] = {15, 1.4, "#7209b7", "CH  chatter", NONE},
    [SALTUS_POINT_ST] = {4, 1.2, "#3a5a98", "ST  sticking", NONE},
    [SALTUS_POINT_UZ] = {6, 1.1, "#404040", "UZ  wanted", NONE},
    [SALTUS_POINT_EP] = {2, 1.1, "#606060", "EP  end", NONE},
    [SALTUS_POINT_HB] = {3, 1.5, "#b00020", "HB  Hopf", NONE},
    [SALTUS_POINT_BE] = {10, 1.4, "#00696b", "BE  equilibrium meets a stop", NONE},
    [SALTUS_POINT_GR_LP] = {12, 1.8, "#1c1c1c", "GR-LP", NONE},
    [SALTUS_POINT_GR_PD] = {12, 1.8, "#1c1c1c", "GR-PD", DOT},
    [SALTUS_POINT_GR_NS] = {12, 1.8, "#1c1c1c", "GR-NS", PLUS},
    [SALTUS_POINT_GR_GR] = {12, 1.8, "#1c1c1c", "GR-GR", CROSS},
    [SALTUS_POINT_R1] = {14, 1.6, "#1c1c1c", "R1", NONE},
    [SALTUS_POINT_R2] = {14, 1.6, "#1c1c1c", "R2", DOT},
    [SALTUS_POINT_R3] = {14, 1.6, "#1c1c1c", "R3", PLUS},
    [SALTUS_POINT_R4] = {14, 1.6, "#1c1c1c", "R4", CROSS},
    [SALTUS_POINT_CP] = {8, 1.7, "#1c1c1c", "CP", NONE},
    [SALTUS_POINT_BT] = {8, 1.7, "#1c1c1c", "BT", DOT},
    [SALTUS_POINT_GH] = {8, 1.7, "#1c1c1c", "GH", PLUS},
    [SALTUS_POINT_GR_BP] = {8, 1.7, "#1c1c1c", "GR-BP", CROSS},
    [SALTUS_POINT_CH_GR] = {4, 1.4, "#1c1c1c", "CH-GR", DOT},
    [SALTUS_POINT_GPD] = {4, 1.4, "#1c1c1c", "GPD", PLUS},
    [SALTUS_POINT_LP_PD] = {4, 1.4, "#1c1c1c", "LP-PD", CROSS},
    [SALTUS_POINT_PD_NS] = {6, 1.4, "#1c1c1c", "PD-NS", DOT},
};

/* What occurs on a page: hues of curves, strokes long enough to be seen, and kinds of marks. */
typedef struct content {
    bool hue[SALTUS_HUES], stroke[SALTUS_STROKES], kind[SALTUS_POINT_KINDS];
} content;

/* Strokes of branches and of loci; an empty meaning needs no explanation. */
typedef struct stroke_look {
    const char *line, *meaning;
} stroke_look;
static const stroke_look strokes[2][SALTUS_STROKES] = {
    {{"lw 2.6", "stable"}, {"dt (9,6) lw 1.9", "unstable"}, {"dt (2,5) lw 1.3", "not admissible"}},
    {{"lw 2.6", ""}, {"dt (7,9) lw 1.2", "bounds no stable orbit"}, {"lw 1", ""}}};

static content find_content(const saltus_plot_page *page) {
    const double seen = 0.02, wide = page->x.high - page->x.low, high = page->y.high - page->y.low;
    double length[SALTUS_STROKES] = {0};
    content c = {.hue = {false}};
    for (int k = 0; k < page->row_count; k++) {
        const saltus_plot_row *row = &page->rows[k];
        const bool shown = saltus_plot_shown(page, row);
        c.hue[row->hue] = true;
        if (shown && row->marked && row->x >= page->x.low && row->x <= page->x.high &&
            row->y >= page->y.low && row->y <= page->y.high)
            c.kind[row->point->kind] = true;
        if (row->joined && (shown || saltus_plot_shown(page, row + 1)))
            length[row->stroke] += fmax(fabs(row[1].x - row->x) / wide, fabs(row[1].y - row->y) / high);
    }
    for (int stroke = 0; stroke < SALTUS_STROKES; stroke++)
        c.stroke[stroke] = length[stroke] > seen;
    return c;
}

static const char *hue_colour(const saltus_plot_page *page, int hue) {
    return page->locus ? marks[saltus_plot_locus(hue)].colour : hues[hue];
}

/* Lay the marks of codimension two out in rows of this width below `top`, and write them if `put`; returns
 * how many rows there are. */
static int lay_pairs(const saltus_plot_page *page, const content *c, double width, double top, bool put) {
    const double begin = (saltus_page_narrow(page->paper) ? 0.01 : 0.03) * page->paper->width + 26,
                 type = saltus_page_type(page->paper, 11), beside = 15, apart = 40, row = 19;
    double x = 0;
    int rows = 0;
    for (int kind = SALTUS_POINT_CP; kind < SALTUS_POINT_KINDS; kind++) {
        const double own = beside + saltus_page_width(marks[kind].meaning, type) + apart;
        if (!c->kind[kind])
            continue;
        if (!rows || x + own > width) {
            rows++;
            x = 0;
        }
        const double y = top - row * (rows - 0.5);
        if (put)
            saltus_page_label(page->paper, marks[kind].meaning, begin + x + beside, y,
                              "left front font ',%.4g' tc rgb '#303030'", type);
        for (int part = 0; part < (marks[kind].inner ? 2 : 1) && put; part++)
            saltus_page_label(page->paper, "", begin + x, y, "point pt %d ps %g lw 1.2 lc rgb '%s' front",
                              part ? marks[kind].inner : marks[kind].point_type,
                              part ? inner_size : marks[kind].size, marks[kind].colour);
        x += own;
    }
    return rows;
}

/* Write a file's name, broken into lines, as entries of the key, or only count them (`script` NULL); returns
 * how many there are. *longest is raised to the letters of the longest. */
static int put_file_name(const saltus_plot_page *page, int file, FILE *script, double *longest) {
    enum { most = 6 };
    const double before = 64, em = 15.2; /* the sample and margins; the height of the type */
    const double narrowest = 0.5;        /* letter */
    saltus_line name = {.length = 0}, piece;
    int lines = 0;
    saltus_line_plain(&name, page->files[file].scene);
    saltus_plot_add_differences(page, file, &name);
    for (const char *rest = name.text; *rest && lines < most; rest += piece.length, lines++) {
        size_t length = saltus_line_piece(rest, (page->paper->width - before) / em);
        length += strspn(rest + length, " ");
        piece.length = 0;
        saltus_line_add(&piece, "%.*s", (int)length, rest);
        *longest = fmax(*longest, saltus_line_width(piece.text) / narrowest);
        if (!script)
            continue;
        if (lines == 0)
            fprintf(script, "     NaN with lines lw 2.6 lc rgb '%s' title ", hues[file % SALTUS_HUES]);
        else
            fputs("     NaN with lines lt nodraw title ", script);
        saltus_put_quoted(script, piece.text, piece.length);
        fputs(", \\\n", script);
    }
    return lines;
}

/* Write the entries of the key, which gnuplot lays out, into a plot command, or only count them (`script`
 * NULL). Returns how many there are; *longest: the letters of the longest. */
static int put_key(const saltus_plot_page *page, const content *c, FILE *script, double *longest) {
    int entries = 0;
    *longest = 1;
    for (int hue = 0; hue < SALTUS_HUES && page->locus; hue++) {
        const saltus_point_kind kind = saltus_plot_locus(hue);
        if (c->hue[hue] && script)
            fprintf(script, "     NaN with linespoints lw %s pt %d ps %g lc rgb '%s' title '%s', \\\n",
                    kind == SALTUS_POINT_HB ? "1.6" : "2.6", /* a star of thick lines is a blot */
                    marks[kind].point_type, 0.7 * marks[kind].size, hue_colour(page, hue),
                    marks[kind].meaning);
        entries += c->hue[hue];
    }
    for (int i = 0; i < page->count && page->count > 1 && !page->locus; i++)
        entries += put_file_name(page, i, script, longest);
    for (int stroke = 0; stroke < SALTUS_STROKES; stroke++) {
        const stroke_look *look = &strokes[page->locus][stroke];
        if (!c->stroke[stroke] || !*look->meaning)
            continue;
        if (script)
            fprintf(script, "     NaN with lines %s lc rgb '#404040' title '%s', \\\n", look->line,
                    look->meaning);
        *longest = fmax(*longest, (double)strlen(look->meaning));
        entries++;
    }
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_POINT_CP; kind++) {
        if (!c->kind[kind])
            continue;
        if (script)
            fprintf(script, "     NaN with points pt %d ps %g lw 1.6 lc rgb '%s' title '%s', \\\n",
                    marks[kind].point_type, marks[kind].size, marks[kind].colour, marks[kind].meaning);
        *longest = fmax(*longest, (double)strlen(marks[kind].meaning));
        entries++;
    }
    return entries;
}

double saltus_plot_legend(const saltus_plot_page *page, double width, bool put) {
    const double letter = 9.9, sign = 5.6 * letter, whole = page->paper->width;
    const content c = find_content(page);
    double longest;
    const int entries = put_key(page, &c, NULL, &longest);
    /* gnuplot makes all entries as wide as the longest, in as many columns as fit into the panel. */
    int most = (int)(whole / (page->locus || page->count > 1 ? 310 : 190));
    if (width < 0.8 * whole || (page->count > 1 && !page->locus))
        most = (int)fmin(most, width / (letter * longest + sign));
    const int columns = most > 1 ? most : 1, rows = (entries + columns - 1) / columns;
    if (put)
        saltus_page_legend(page->paper, rows);
    return 10 + 19 * (rows + lay_pairs(page, &c, width, page->paper->top - 19 * rows, put));
}

/* Curves, the stable ones on top; on a map each has a white rim. Loci also get signs. */
static void put_curves(const saltus_plot_page *page, const content *c) {
    for (int stroke = SALTUS_STROKES - 1; stroke >= 0; stroke--)
        for (int hue = 0; hue < SALTUS_HUES; hue++) {
            if (!c->hue[hue])
                continue;
            if (page->locus && page->over_sweep)
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
    /* Marks have a white rim that separates them from the curves, and open ones of codimension two a white
     * ground. Kinds that would often be covered by others are drawn last. */
    for (int kind = SALTUS_POINT_KINDS - 1; kind >= SALTUS_POINT_LP; kind--) {
        const bool pair = kind >= SALTUS_POINT_CP;
        const bool solid = kind != SALTUS_POINT_EP && kind != SALTUS_POINT_UZ && kind != SALTUS_POINT_ST &&
                           kind != SALTUS_POINT_BE;
        if (c.kind[kind] && solid)
            fprintf(file, "     $marks_%d using 1:2 with points pt %d ps %g lc rgb '#ffffff' notitle, \\\n",
                    kind, marks[kind].point_type + pair, marks[kind].size + 0.45);
        for (int part = 0; part < (marks[kind].inner ? 2 : 1) && c.kind[kind]; part++)
            fprintf(file, "     $marks_%d using 1:2 with points pt %d ps %g lw %g lc rgb '%s' notitle, \\\n",
                    kind, part ? marks[kind].inner : marks[kind].point_type,
                    part ? inner_size : marks[kind].size, pair ? 1.2 : 1.6, marks[kind].colour);
    }
    double longest;
    put_key(page, &c, file, &longest);
    fputs("     NaN notitle\n", file);
}
