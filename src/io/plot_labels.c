/* Words on a bifurcation diagram: n/p along each stretch of a branch and the names of special points, where
 * they do not lie on each other.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/caption.h"
#include "io/plot.h"

#include <math.h>
#include <string.h>

enum { places_max = 400 };

/* Size of the diagram and of a word in it, roughly, in units of a word's height. */
static const double page_width = 70, page_height = 46, letter_width = 0.62;

typedef struct place {
    double x, y, half_width;
} place;

typedef struct places {
    place taken[places_max];
    int count;
} places;

static place place_of(const saltus_plot_page *page, const saltus_branch_point *point, size_t letters) {
    return (place){page_width * (saltus_plot_x(point) - page->x.low) / (page->x.high - page->x.low),
                   page_height * (saltus_plot_y(page, point) - page->y.low) / (page->y.high - page->y.low),
                   0.5 * letter_width * (double)letters + 0.5};
}

static bool is_free(const places *all, place wanted) {
    if (all->count == places_max || wanted.x < wanted.half_width ||
        wanted.x > page_width - wanted.half_width || wanted.y < 0.6 || wanted.y > page_height - 0.6)
        return false;
    for (int k = 0; k < all->count; k++)
        if (fabs(all->taken[k].x - wanted.x) < all->taken[k].half_width + wanted.half_width &&
            fabs(all->taken[k].y - wanted.y) < 1.5)
            return false;
    return true;
}

static void put_label(const saltus_plot_page *page, const char *text, place where, const char *style) {
    saltus_line line = {.length = 0};
    saltus_line_plain(&line, text);
    fprintf(page->file, "set label '%s' at graph %.4f,%.4f %s\n", line.text, where.x / page_width,
            where.y / page_height, style);
}

/* How far the curves stay away from a place, as far as it matters. */
static double clearance(const saltus_plot_page *page, place wanted) {
    const double enough = 1.3;
    double least = enough;
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k + 1 < page->files[i].point_count; k++) {
            const saltus_branch_point *points = page->files[i].points;
            place a = place_of(page, &points[k], 0), b = place_of(page, &points[k + 1], 0);
            if (points[k].branch != points[k + 1].branch)
                continue;
            /* Distance to the chord between the two points. */
            double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
            double part = square > 0 ? ((wanted.x - a.x) * dx + (wanted.y - a.y) * dy) / square : 0;
            part = fmin(fmax(part, 0), 1);
            least = fmin(least, hypot(wanted.x - a.x - part * dx, wanted.y - a.y - part * dy));
        }
    return least;
}

static void take_place(places *all, place taken) {
    if (all->count < places_max)
        all->taken[all->count++] = taken;
}

/* Whether an earlier point of the same kind, in the order of the files, lies under this one. */
static bool named_already(const saltus_plot_page *page, const saltus_branch_point *point) {
    place own = place_of(page, point, 0);
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *other = &page->files[i].points[k];
            place its = place_of(page, other, 0);
            if (other == point)
                return false;
            if (other->kind == point->kind && hypot(its.x - own.x, its.y - own.y) < 0.8)
                return true;
        }
    return false;
}

/* A special point's name beside it, where it is farthest from the curves. */
static void name_point(const saltus_plot_page *page, const saltus_branch_point *point, places *all) {
    static const double shift[][2] = {{0, 1.5},    {1.8, 0.9},   {-1.8, 0.9}, {2.1, 0}, {-2.1, 0},
                                      {1.8, -0.9}, {-1.8, -0.9}, {0, -1.5},   {0, 2.4}, {0, -2.4}};
    const char *word = saltus_point_word(point->kind);
    place best = {0, 0, 0};
    double widest = 0;
    if (point->kind == SALTUS_POINT_UZ || point->kind == SALTUS_POINT_EP || named_already(page, point))
        return;
    for (size_t k = 0; k < sizeof shift / sizeof shift[0]; k++) {
        place wanted = place_of(page, point, strlen(word));
        wanted.x += shift[k][0];
        wanted.y += shift[k][1];
        double away = is_free(all, wanted) ? clearance(page, wanted) : 0;
        if (away <= widest + 0.1)
            continue;
        widest = away;
        best = wanted;
    }
    if (widest == 0)
        return;
    put_label(page, word, best, "center front tc rgb '#303030' font ',10'");
    take_place(all, best);
}

/* A stretch of one branch on which the motion has one name. */
typedef struct stretch {
    int first, last; /* rows of the file */
    double length;   /* on the page */
} stretch;

static stretch find_stretch(const saltus_plot_page *page, const saltus_branch_file *f, int first) {
    stretch s = {first, first, 0};
    for (int k = first + 1;
         k < f->point_count && f->points[k].branch == f->points[first].branch &&
         saltus_plot_shown(page, &f->points[k]) == saltus_plot_shown(page, &f->points[first]) &&
         strcmp(f->points[k].label, f->points[first].label) == 0;
         k++) {
        place a = place_of(page, &f->points[k - 1], 0), b = place_of(page, &f->points[k], 0);
        s.length += hypot(b.x - a.x, b.y - a.y);
        s.last = k;
    }
    return s;
}

/* The row nearest to a part of a stretch's length. */
static int row_at(const saltus_plot_page *page, const saltus_branch_file *f, stretch s, double part) {
    double passed = 0;
    for (int k = s.first + 1; k <= s.last; k++) {
        place a = place_of(page, &f->points[k - 1], 0), b = place_of(page, &f->points[k], 0);
        passed += hypot(b.x - a.x, b.y - a.y);
        if (passed >= part * s.length)
            return k;
    }
    return s.first;
}

static void name_stretch(const saltus_plot_page *page, const saltus_branch_file *f, stretch s, int hue,
                         places *all) {
    static const double parts[] = {0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9};
    static const char *const colour[SALTUS_HUES] = {"#1d4566", "#8f3719", "#1f6650",
                                                    "#634078", "#7a5c00", "#444444"};
    char name[SALTUS_LABEL_MAX + 8];
    snprintf(name, sizeof name, "%s%s%s", saltus_point_word(f->options.locus), page->locus ? " " : "",
             f->points[s.first].label);
    char style[96];
    snprintf(style, sizeof style, "center front boxed tc rgb '%s' font ',11'", colour[hue]);
    if (s.length < 1.5 * letter_width * (double)strlen(name) + 1)
        return;
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) {
        place wanted = place_of(page, &f->points[row_at(page, f, s, parts[k])], strlen(name) + 1);
        if (!is_free(all, wanted))
            continue;
        put_label(page, name, wanted, style);
        take_place(all, wanted);
        return;
    }
}

/* The special points of all files: their marks are taken before any name looks for its place. */
static void name_points(const saltus_plot_page *page, places *all) {
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < page->count; i++)
            for (int k = 0; k < page->files[i].point_count; k++) {
                const saltus_branch_point *point = &page->files[i].points[k];
                if (!saltus_plot_marked(&page->files[i], point))
                    continue;
                if (pass == 0)
                    take_place(all, place_of(page, point, 1));
                else
                    name_point(page, point, all);
            }
}

void saltus_plot_labels(const saltus_plot_page *page) {
    places all = {.count = 0};
    fputs("set style textbox opaque noborder fillcolor '#ffffff' margins 0.4,0.2\n", page->file);
    name_points(page, &all);
    for (int i = 0; i < page->count; i++) {
        const saltus_branch_file *f = &page->files[i];
        for (int k = 0; k < f->point_count;) {
            stretch s = find_stretch(page, f, k);
            name_stretch(page, f, s, saltus_plot_hue(page, i, f->points[k].branch), &all);
            k = s.last + 1;
        }
    }
}
