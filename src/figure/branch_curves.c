/* The parts of a bifurcation diagram that can be drawn over other figures: curves, marks and their legend.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include <math.h>
#include <string.h>

static const char *const hues[SALTUS_HUES] = {"#2c5f8a", "#c44e2a", "#2f8f6f", "#8a5aa0",
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

/* What occurs on a page: hues of curves, kinds of marks, and loci that bound no stable orbit. */
typedef struct content {
    bool hue[SALTUS_HUES], kind[SALTUS_PLOT_MARKS], dots;
} content;

static content find_content(const saltus_plot_page *page) {
    content c = {.dots = false};
    for (int i = 0; i < page->count; i++) {
        const saltus_branch_file *f = &page->files[i];
        for (int k = 0; k < f->point_count; k++) {
            const saltus_branch_point *point = &f->points[k];
            if (k == 0 || point->branch != point[-1].branch)
                c.hue[saltus_plot_hue(page, i, point->branch)] = true;
            if (!saltus_plot_shown(page, point))
                continue;
            if (saltus_plot_marked(f, point))
                c.kind[saltus_plot_mark(point->kind)] = true;
            c.dots = c.dots || (page->locus && k > 0 && point->branch == point[-1].branch &&
                                saltus_plot_stroke(f, k - 1, k) != SALTUS_STROKE_STABLE);
        }
    }
    return c;
}

static const char *hue_colour(const saltus_plot_page *page, int hue) {
    return page->locus ? marks[saltus_plot_locus(hue)].colour : hues[hue];
}

double saltus_plot_legend_height(const saltus_plot_page *page, double width, int *rows) {
    const double letter = 9.4, sign = 5.6 * letter, beside = 148;
    const content c = find_content(page);
    int most = (int)(width / (page->locus || page->count > 1 ? 310 : 190));
    /* gnuplot makes all entries as wide as the longest, in as many columns as fit into the panel. */
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_PLOT_MARKS && width < 1000; kind++)
        if (c.kind[kind])
            most = (int)fmin(most, (width - beside) / (letter * (double)strlen(marks[kind].meaning) + sign));
    const int columns = most > 1 ? most : 1;
    int entries = page->locus ? c.dots : page->count == 1 ? 2 : 2 + page->count;
    for (int hue = 0; hue < SALTUS_HUES; hue++)
        entries += page->locus && c.hue[hue];
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_PLOT_MARKS; kind++)
        entries += c.kind[kind];
    const int own = (entries + columns - 1) / columns;
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
    static const char *const look[SALTUS_STROKES] = {"lw 2.6", "dt (9,6) lw 1.9", "dt (2,5) lw 1.3"};
    static const char *const border[SALTUS_STROKES] = {"lw 2.6", "dt (7,9) lw 1.2", "lw 1"};
    for (int stroke = SALTUS_STROKES - 1; stroke >= 0; stroke--)
        for (int hue = 0; hue < SALTUS_HUES; hue++) {
            if (!c->hue[hue])
                continue;
            if (page->over_map)
                fprintf(page->paper->file,
                        "     $curve_%d_%d using 1:2 with lines lw %s lc rgb '#ffffff' notitle, \\\n", hue,
                        stroke, stroke ? "4" : "5.4");
            fprintf(page->paper->file, "     $curve_%d_%d using 1:2 with lines %s lc rgb '%s' notitle, \\\n",
                    hue, stroke, (page->locus ? border : look)[stroke], hue_colour(page, hue));
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
    static const char *const line = "     NaN with lines %s lc rgb '%s' title '%s', \\\n";
    for (int hue = 0; hue < SALTUS_HUES && page->locus; hue++)
        if (c.hue[hue])
            fprintf(file, "     NaN with linespoints lw 2.6 pt %d ps %g lc rgb '%s' title '%s', \\\n",
                    marks[saltus_plot_locus(hue)].point_type, 0.7 * marks[saltus_plot_locus(hue)].size,
                    hue_colour(page, hue), marks[saltus_plot_locus(hue)].meaning);
    for (int i = 0; i < page->count && page->count > 1 && !page->locus; i++) {
        saltus_line name = {.length = 0};
        saltus_line_plain(&name, page->files[i].scene);
        saltus_plot_add_differences(page, i, &name);
        fprintf(file, "     NaN with lines lw 2.6 lc rgb '%s' title ", hues[i % SALTUS_HUES]);
        saltus_put_quoted(file, name.text, name.length);
        fputs(", \\\n", file);
    }
    if (c.dots)
        fprintf(file, line, "dt (7,9) lw 1.2", "#404040", "bounds no stable orbit");
    if (!page->locus) {
        fprintf(file, line, "lw 2.6", "#404040", "stable");
        fprintf(file, line, "dt (9,6) lw 1.9", "#404040", "unstable");
    }
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_PLOT_MARKS; kind++)
        if (c.kind[kind])
            fprintf(file, "     NaN with points pt %d ps %g lw 1.6 lc rgb '%s' title '%s', \\\n",
                    marks[kind].point_type, marks[kind].size, marks[kind].colour, marks[kind].meaning);
    fputs("     NaN notitle\n", file);
}
