/* The curves, signs and marks of a bifurcation diagram, as datablocks inside gnuplot's script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include <math.h>
#include <stdlib.h>

void saltus_plot_place(const saltus_plot_page *page, double x, double y, double place[2]) {
    place[0] = (page->frame.right - page->frame.left) * saltus_range_part(page->x, page->logarithmic[0], x);
    place[1] = (page->frame.top - page->frame.bottom) * saltus_range_part(page->y, page->logarithmic[1], y);
}

/* Write a place on the page as values of the axes. */
static void put_place(const saltus_plot_page *page, const double place[2]) {
    const saltus_frame *f = &page->frame;
    fprintf(page->paper->file, "%.12g %.9g\n",
            saltus_range_value(page->x, page->logarithmic[0], place[0] / (f->right - f->left)),
            saltus_range_value(page->y, page->logarithmic[1], place[1] / (f->top - f->bottom)));
}

void saltus_plot_place_visit(const saltus_plot_page *page, const saltus_plot_row *row, int v,
                             double place[2]) {
    const double first = row->point->value[0], value = row->visits[v].value;
    saltus_plot_place(page, page->swap ? value : first, page->swap ? first : value, place);
}

double saltus_plot_distance(const double at[2], const double a[2], const double b[2]) {
    double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    double part = square > 0 ? ((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / square : 0;
    part = fmin(fmax(part, 0), 1);
    return hypot(at[0] - a[0] - part * dx, at[1] - a[1] - part * dy);
}

/* A point of a curve: values of the axes, place on the page, whether the piece to the next point has the
 * current stroke, and whether the curve may have a corner here. */
typedef struct curve_point {
    double value[2], place[2];
    bool drawn, corner;
} curve_point;

/* The tangent at a point of a smooth run: of the parabola through it and its two neighbours, parametrised by
 * chord length; at the ends of the run through the nearest three points. */
static void tangent(const curve_point *run, int count, int k, double slope[2]) {
    int middle = k == 0 ? 1 : k == count - 1 ? k - 1 : k;
    const double *a = run[middle - 1].place, *b = run[middle].place, *c = run[middle + 1].place;
    double first = hypot(b[0] - a[0], b[1] - a[1]), second = hypot(c[0] - b[0], c[1] - b[1]);
    for (int i = 0; i < 2; i++) {
        double before = first > 0 ? (b[i] - a[i]) / first : 0,
               after = second > 0 ? (c[i] - b[i]) / second : 0;
        double bend = first + second > 0 ? (after - before) / (first + second) : 0;
        slope[i] = k < middle   ? before - bend * first
                   : k > middle ? after + bend * second
                                : (before * second + after * first) / fmax(first + second, 1e-300);
    }
}

/* Write intermediate rows between points k and k + 1 of a run: a cubic, if it visibly differs from the chord
 * and the points are close enough to determine it. */
static void put_arc(const saltus_plot_page *page, const curve_point *run, int count, int k) {
    enum { pieces = 8 };
    const double seen = 0.8, far = 0.25; /* in units; as a fraction of the panel's width */
    const double *a = run[k].place, *b = run[k + 1].place;
    double slope[2][2], way = hypot(b[0] - a[0], b[1] - a[1]);
    if (count < 3 || !(way <= far * (page->frame.right - page->frame.left)))
        return;
    tangent(run, count, k, slope[0]);
    tangent(run, count, k + 1, slope[1]);
    double across = slope[0][0] - slope[1][0], up = slope[0][1] - slope[1][1];
    if (!(way * hypot(across, up) / 8 >= seen))
        return;
    for (int n = 1; n < pieces; n++) {
        double t = (double)n / pieces, place[2];
        for (int i = 0; i < 2; i++)
            place[i] = (1 + 2 * t) * (1 - t) * (1 - t) * a[i] + t * t * (3 - 2 * t) * b[i] +
                       way * t * (1 - t) * ((1 - t) * slope[0][i] - t * slope[1][i]);
        put_place(page, place);
    }
}

/* Whether a place of a curve lies on an earlier dashed curve of the same file: the dashes of both would fill
 * each other's gaps and look solid. */
static bool covered(const saltus_plot_page *page, const saltus_plot_row *own, const double at[2]) {
    const double near = 2; /* units */
    for (int k = 0; k < page->row_count; k++) {
        const saltus_plot_row *row = &page->rows[k];
        double a[2], b[2];
        if (row->file != own->file || row->point->branch >= own->point->branch || !row->joined ||
            row->stroke != SALTUS_STROKE_UNSTABLE)
            continue;
        saltus_plot_place(page, row[0].point->value[0], row[0].point->value[0], a);
        saltus_plot_place(page, row[1].point->value[0], row[1].point->value[0], b);
        const double begin = a[page->swap], end = b[page->swap], along = at[page->swap];
        if (along < fmin(begin, end) - near || along > fmax(begin, end) + near)
            continue;
        for (int v = 0; v < row->count; v++) {
            if (row->visits[v].next < 0)
                continue;
            saltus_plot_place_visit(page, row, v, a);
            saltus_plot_place_visit(page, row + 1, row->visits[v].next, b);
            if (saltus_plot_distance(at, a, b) < near)
                return true;
        }
    }
    return false;
}

static void between(const double from[2], const double to[2], double part, double at[2]) {
    for (int i = 0; i < 2; i++)
        at[i] = from[i] + part * (to[i] - from[i]);
}

/* Whether a dashed piece of a branch is drawn whole. If it is covered nothing is drawn; if only one end is, a
 * straight line over the rest replaces it. */
static bool put_uncovered(const saltus_plot_page *page, const saltus_plot_row *own, const double from[2],
                          const double to[2]) {
    const double seen = 16; /* units */
    double ends[2][2], at[2], part[2] = {0, 1};
    saltus_plot_place(page, from[0], from[1], ends[0]);
    saltus_plot_place(page, to[0], to[1], ends[1]);
    const bool first = covered(page, own, ends[0]), last = covered(page, own, ends[1]);
    if (first == last) {
        between(ends[0], ends[1], 0.5, at);
        return !(first && covered(page, own, at));
    }
    while (part[1] - part[0] > 1e-4) {
        const double middle = 0.5 * (part[0] + part[1]);
        between(ends[0], ends[1], middle, at);
        part[covered(page, own, at) == last] = middle;
    }
    between(ends[0], ends[1], part[0], at);
    if (hypot(at[0] - ends[last][0], at[1] - ends[last][1]) < seen)
        return true;
    fprintf(page->paper->file, "\n%.12g %.9g\n", first ? to[0] : from[0], first ? to[1] : from[1]);
    put_place(page, at);
    return false;
}

/* Whether between two rows another impact becomes the largest, so that the curve of the largest has a
 * corner. */
static bool overtaken(const saltus_plot_row *a, const saltus_plot_row *b) {
    return a->strongest >= 0 && b->strongest >= 0 &&
           (a->strongest != b->strongest ||
            a->point->events[a->strongest].face != b->point->events[b->strongest].face);
}

/* Whether a curve may have a corner at a row: where impacts, chatter or sticking appear or vanish, or where
 * another impact becomes the largest. */
static bool has_corner(const saltus_plot_page *page, const saltus_plot_row *row) {
    const saltus_point_kind kind = row->point->kind;
    return kind == SALTUS_POINT_GR || kind == SALTUS_POINT_CH || kind == SALTUS_POINT_ST ||
           kind == SALTUS_POINT_EP ||
           (page->show == SALTUS_SHOW_SPEED && !page->locus &&
            ((row > page->rows && row[-1].joined && overtaken(row - 1, row)) ||
             (row->joined && overtaken(row, row + 1))));
}

/* The curve of a visit that begins at a row, where it has one stroke, without those of its dashes that
 * earlier branches of the file cover. */
static void put_curve(const saltus_plot_page *page, const saltus_plot_row *row, int begin,
                      saltus_stroke stroke, curve_point *p) {
    const bool dashed = stroke == SALTUS_STROKE_UNSTABLE && !page->locus;
    int count = 0;
    for (int v = begin; v >= 0; v = row[count++].visits[v].next) {
        const double value = row[count].visits[v].value;
        p[count].value[page->swap] = row[count].point->value[0];
        p[count].value[!page->swap] = value;
        p[count].corner = has_corner(page, &row[count]) || isnan(value);
        p[count].drawn = row[count].visits[v].next >= 0 && row[count].stroke == stroke;
    }
    for (int k = 0; k + 1 < count && dashed; k++)
        p[k].drawn = p[k].drawn && put_uncovered(page, row, p[k].value, p[k + 1].value);
    for (int k = 0; k < count; k++)
        saltus_plot_place(page, p[k].value[0], p[k].value[1], p[k].place);
    for (int first = 0, last; first + 1 < count; first = last) {
        for (last = first + 1; last + 1 < count && !p[last].corner;)
            last++;
        for (int k = first; k < last; k++) {
            if (!p[k].drawn)
                continue;
            if (k == 0 || !p[k - 1].drawn)
                fprintf(page->paper->file, "\n%.12g %.9g\n", p[k].value[0], p[k].value[1]);
            put_arc(page, p + first, last - first + 1, k - first);
            fprintf(page->paper->file, "%.12g %.9g\n", p[k + 1].value[0], p[k + 1].value[1]);
        }
    }
}

bool saltus_plot_data(const saltus_plot_page *page) {
    const double apart = 130; /* units between signs */
    FILE *file = page->paper->file;
    curve_point *p = calloc((size_t)page->row_count + 1, sizeof *p);
    const bool sound = p != NULL;
    for (int hue = 0; hue < SALTUS_HUES && sound; hue++) {
        for (int stroke = 0; stroke < SALTUS_STROKES; stroke++) {
            fprintf(file, "$curve_%d_%d << EOD\n# parameter, measure\nNaN NaN\n", hue, stroke);
            for (int k = 0; k < page->row_count; k++)
                for (int v = 0; v < page->rows[k].count; v++)
                    if (page->rows[k].hue == hue && page->rows[k].visits[v].begins)
                        put_curve(page, &page->rows[k], v, (saltus_stroke)stroke, p);
            fputs("\nEOD\n", file);
        }
        /* Signs along loci at equal distances on the page, so that kinds differ not only by hue. */
        double passed = 0;
        if (!page->locus)
            continue;
        fprintf(file, "$signs_%d << EOD\n# parameters\nNaN NaN\n", hue);
        for (int k = 0; k < page->row_count; k++) {
            const saltus_plot_row *row = &page->rows[k];
            double a[2], b[2];
            if (k == 0 || row->file != row[-1].file)
                passed = 0.5 * apart;
            if (k == 0 || !row[-1].joined || row->hue != hue || !saltus_plot_shown(page, row))
                continue;
            saltus_plot_place(page, row[-1].x, row[-1].y, a);
            saltus_plot_place(page, row->x, row->y, b);
            passed += hypot(b[0] - a[0], b[1] - a[1]);
            if (passed < apart || row->marked)
                continue;
            fprintf(file, "%.12g %.9g\n", row->x, row->y);
            passed = 0;
        }
        fputs("EOD\n", file);
    }
    free(p);
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_POINT_KINDS; kind++) {
        fprintf(file, "$marks_%d << EOD\n# parameter, measure\n", kind);
        for (int k = 0; k < page->row_count; k++)
            if ((int)page->rows[k].point->kind == kind && page->rows[k].marked)
                fprintf(file, "%.12g %.9g\n", page->rows[k].x, page->rows[k].y);
        fputs("EOD\n", file);
    }
    return sound;
}
