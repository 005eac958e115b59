/* Text on a bifurcation diagram: n/p along each stretch of a branch, and names of special points. Names do
 * not overlap. Each is beside what it names, nearer than anything else, or has a line to it; those for which
 * there is no such place are counted above the panel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include "record/describe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { places_max = 400 };

/* Height of a word's line in page units; in such heights half the width of a mark. */
static const double word_height = 20.2, mark_radius = 0.4;

/* Places are in word heights, from the panel's lower left corner. */
typedef struct place {
    double x, y, half_width, half_height;
} place;

/* The piece of a curve from a row to the next. */
typedef struct piece {
    double ends[2][2];
    int row;
} piece;

/* A stretch of one branch along which the label of the motion is the same. */
typedef struct stretch {
    int first, last; /* rows */
    double length;   /* on the page */
} stretch;

typedef struct places {
    const saltus_plot_page *page;
    double wide, high; /* of the panel */
    place taken[places_max];
    int count;
    piece *pieces; /* of all curves */
    int piece_count;
    /* Special points and stretches that have no name yet, and the stretches that have one. */
    const saltus_plot_row *unnamed[places_max];
    stretch unnamed_stretch[places_max], named_stretch[places_max];
    int unnamed_count, unnamed_stretch_count, named_stretch_count;
    int beyond; /* labels whose places are beyond the axes */
} places;

static place place_at(const saltus_plot_page *page, double x, double y) {
    double at[2];
    saltus_plot_place(page, x, y, at);
    return (place){at[0] / word_height, at[1] / word_height, 0, 0};
}

static place place_of(const saltus_plot_page *page, const saltus_plot_row *row) {
    return place_at(page, row->x, row->y);
}

static place place_of_visit(const saltus_plot_page *page, int row, int v) {
    double at[2];
    saltus_plot_place_visit(page, &page->rows[row], v, at);
    return (place){at[0] / word_height, at[1] / word_height, 0, 0};
}

/* The space of a word in type of `size` points, on a white ground if `boxed`. */
static place word_of(const saltus_plot_page *page, const char *word, double size, bool boxed) {
    const double type = saltus_page_type(page->paper, size);
    return (place){0, 0, 0.5 * saltus_page_width(word, type) / word_height + (boxed ? 0.25 : 0.05),
                   0.1 * saltus_page_type(page->paper, 10) * (boxed ? 0.46 : 0.4)};
}

static place moved(place word, double x, double y) {
    return (place){x, y, word.half_width, word.half_height};
}

static double apart(place a, place b) {
    return hypot(a.x - b.x, a.y - b.y);
}

/* Distance between the edges of two places; 0 if they overlap. */
static double gap(place a, place b) {
    return hypot(fmax(0, fabs(a.x - b.x) - a.half_width - b.half_width),
                 fmax(0, fabs(a.y - b.y) - a.half_height - b.half_height));
}

/* Whether a row has a mark in the panel. */
static bool is_visible(const places *all, const saltus_plot_row *row) {
    const saltus_plot_page *page = all->page;
    const double rim = 1e-6;
    const place at = place_of(page, row);
    return row->marked && saltus_plot_shown(page, row) && at.x >= -rim && at.x <= all->wide + rim &&
           at.y >= -rim && at.y <= all->high + rim;
}

static bool is_free(const places *all, place wanted) {
    const double rim = 0.1, beside = 0.13;
    if (all->count == places_max || !(wanted.x >= wanted.half_width + rim) ||
        !(wanted.x <= all->wide - wanted.half_width - rim) || !(wanted.y >= wanted.half_height + rim) ||
        !(wanted.y <= all->high - wanted.half_height - rim))
        return false;
    for (int k = 0; k < all->count; k++)
        if (gap(all->taken[k], wanted) < beside)
            return false;
    return true;
}

static void take_place(places *all, place taken) {
    if (all->count < places_max)
        all->taken[all->count++] = taken;
}

/* Write a name, on a white ground if `boxed`, and take its place. */
static void put_name(places *all, const saltus_line *name, place where, bool boxed, const char *colour,
                     const char *font, double size) {
    saltus_page_graph_label(all->page->paper, name, where.x / all->wide, where.y / all->high, 4,
                            "center front %stc rgb '%s' font '%s,%.4g'", boxed ? "boxed " : "", colour, font,
                            size);
    take_place(all, where);
}

/* The pieces of all curves, one per branch or one per visit. Without memory, names are placed as if there
 * were no curves. */
static void find_pieces(places *all) {
    const saltus_plot_page *page = all->page;
    size_t most = 1;
    for (int k = 0; k < page->row_count; k++)
        most += (size_t)page->rows[k].count;
    all->pieces = calloc(most, sizeof *all->pieces);
    for (int k = 0; k < page->row_count && all->pieces; k++)
        for (int v = 0; v < page->rows[k].count; v++) {
            const int next = page->rows[k].visits[v].next;
            if (next < 0)
                continue;
            const place from = place_of_visit(page, k, v), to = place_of_visit(page, k + 1, next);
            all->pieces[all->piece_count++] = (piece){{{from.x, from.y}, {to.x, to.y}}, k};
        }
}

/* Which curves count for a name's clearance. */
typedef enum count_curves { EVERY, OWN, OTHER } count_curves;

static bool is_part(const piece *p, const stretch *s) {
    return p->row >= s->first && p->row < s->last;
}

/* Whether a piece is of a stretch (NULL: none), or lies on it, is of the same motion and does not hide it. */
static bool is_own(const places *all, const piece *p, const stretch *s) {
    const saltus_plot_page *page = all->page;
    const double near = 0.12;
    if (!s || is_part(p, s))
        return s != NULL;
    const saltus_plot_row *its = &page->rows[p->row], *own = &page->rows[s->first];
    if (strcmp(its->point->label, own->point->label) != 0 ||
        (!page->locus && its->stroke == SALTUS_STROKE_STABLE && own->stroke != SALTUS_STROKE_STABLE))
        return false;
    for (int end = 0; end < 2; end++) {
        double least = INFINITY;
        for (int k = 0; k < all->piece_count; k++)
            if (is_part(&all->pieces[k], s))
                least = fmin(least, saltus_plot_distance(p->ends[end], all->pieces[k].ends[0],
                                                         all->pieces[k].ends[1]));
        if (!(least < near))
            return false;
    }
    return true;
}

/* Distance from the edge of a word to the nearest curve of those that count, exact only below `enough`. */
static double clearance(const places *all, place word, double enough, const stretch *s,
                        count_curves counted) {
    const int samples = word.half_width > 1 ? 3 : word.half_width > 0.2 ? 1 : 0;
    const double half = word.half_width - fmin(word.half_width, word.half_height);
    double least = enough + word.half_height;
    for (int k = 0; k < all->piece_count; k++) {
        const piece *p = &all->pieces[k];
        const double *a = p->ends[0], *b = p->ends[1], reach = least + half;
        if (fmin(a[0], b[0]) > word.x + reach || fmax(a[0], b[0]) < word.x - reach ||
            fmin(a[1], b[1]) > word.y + least || fmax(a[1], b[1]) < word.y - least ||
            (counted != EVERY && is_own(all, p, s) != (counted == OWN)))
            continue;
        for (int n = -samples; n <= samples; n++)
            least = fmin(least, saltus_plot_distance(
                                    (double[2]){word.x + (samples ? n * half / samples : 0), word.y}, a, b));
    }
    return least - word.half_height;
}

/* Whether an earlier point of the same kind, in the order of the files, has its mark at this place. */
static bool named_already(const saltus_plot_page *page, const saltus_plot_row *row) {
    for (const saltus_plot_row *other = page->rows; other < row; other++)
        if (other->point->kind == row->point->kind && apart(place_of(page, other), place_of(page, row)) < 0.8)
            return true;
    return false;
}

/* Whether a name at this place would be nearer to the mark of a point of another kind than to its own, or,
 * with a line to its own, near another. A line that may cross curves tells more clearly whose name it is. */
static bool misleads(const places *all, const saltus_plot_row *row, place wanted, bool led, bool across) {
    const saltus_plot_page *page = all->page;
    const double across_least = saltus_page_narrow(page->paper) ? 0.87 : 1;
    const double same = 0.1, overlapping = 0.4, off = 0.9, clearly = across ? across_least : 1.2;
    const place own = place_of(page, row);
    for (int k = 0; k < page->row_count; k++) {
        const saltus_plot_row *other = &page->rows[k];
        if (other->point->kind == row->point->kind || !is_visible(all, other))
            continue;
        const place its = place_of(page, other);
        const double away = apart(its, own), ratio = away < overlapping ? 1 : clearly;
        if (away > same && (apart(its, wanted) < ratio * apart(own, wanted) ||
                            (away >= overlapping && gap(its, wanted) < (led ? off : gap(own, wanted)))))
            return true;
    }
    return false;
}

/* The place of a word at a distance from something at an angle, edge to edge. */
static place beside(place own, place word, double distance, double angle) {
    const double across = cos(angle), up = sin(angle);
    const double way = fmin((own.half_width + word.half_width) / fmax(fabs(across), 1e-9),
                            (own.half_height + word.half_height) / fmax(fabs(up), 1e-9)) +
                       distance;
    return moved(word, own.x + way * across, own.y + way * up);
}

/* Whether a point touches a name, whose letters are lower than its line, or a mark. */
static bool touches(place taken, place at) {
    if (taken.half_width == mark_radius)
        return apart(taken, at) < mark_radius;
    taken.half_height -= 0.13;
    return gap(taken, at) < 0.04;
}

/* A name to be placed: of a special point, or of a stretch at one of its places. */
typedef struct naming {
    const saltus_plot_row *row; /* NULL: a stretch */
    const stretch *s;
    place own, word;
    bool across; /* the line to it may cross curves */
} naming;

/* Whether a line from what is named to a place passes no name and no mark except where it begins, and no
 * curve but those of its stretch. */
static bool leads(const places *all, const naming *n, place to) {
    const double step = 0.2, begin = n->s ? 0.2 : 0.7, near = 0.12;
    const place from = n->own;
    const double length = apart(from, to);
    for (double way = begin; way < length; way += step) {
        const place at = {from.x + way / length * (to.x - from.x), from.y + way / length * (to.y - from.y), 0,
                          0};
        if (!n->across && clearance(all, at, near, n->s, n->s ? OTHER : EVERY) < near)
            return false;
        for (int k = 0; k < all->count; k++)
            if (touches(all->taken[k], at) && !(apart(all->taken[k], from) < 0.5))
                return false;
    }
    return true;
}

/* How well a name would stand: the clearance from the curves, negative if it cannot stand there. */
static double rate(const places *all, const naming *n, place wanted, bool led) {
    const double enough = 0.8, nearer = 0.25;
    if (!is_free(all, wanted) || (n->row && misleads(all, n->row, wanted, led, n->across)))
        return -1;
    const double clear = clearance(all, wanted, enough, NULL, EVERY);
    if (clear < (led ? 0.2 : 0.08) || !n->s || led)
        return clear < (led ? 0.2 : 0.08) ? -1 : clear;
    /* A stretch's name is nearer to its own curve than to any other. */
    const double own = clearance(all, wanted, 2 * enough, n->s, OWN),
                 other = clearance(all, wanted, own + nearer, n->s, OTHER);
    return other < own + nearer ? -1 : clear;
}

/* Whether the line between two places meets a curve, other than one that passes as near as this to its
 * beginning. */
static bool meets_curve(const places *all, const double from[2], const double to[2], double passes) {
    const double dx = to[0] - from[0], dy = to[1] - from[1];
    for (int k = 0; k < all->piece_count; k++) {
        const double *a = all->pieces[k].ends[0], *b = all->pieces[k].ends[1];
        const double side_a = dx * (a[1] - from[1]) - dy * (a[0] - from[0]),
                     side_b = dx * (b[1] - from[1]) - dy * (b[0] - from[0]);
        const double ux = b[0] - a[0], uy = b[1] - a[1];
        const double begin = ux * (from[1] - a[1]) - uy * (from[0] - a[0]),
                     end = ux * (to[1] - a[1]) - uy * (to[0] - a[0]);
        if (side_a * side_b < 0 && begin * end < 0 && saltus_plot_distance(from, a, b) > passes)
            return true;
    }
    return false;
}

/* Find a place that touches what is named. */
static bool find_beside(const places *all, const naming *n, place *found) {
    static const double gaps[] = {0.2, 0.4, 0.6};
    enum { ways = 24 };
    const double much = 0.05;
    double best = -1;
    for (size_t g = 0; g < sizeof gaps / sizeof gaps[0]; g++)
        for (int k = 0; k < ways; k++) {
            /* From straight up to both sides in turn. */
            const double angle = M_PI / 2 + (k % 2 ? 1 : -1) * ((k + 1) / 2) * 2 * M_PI / ways;
            const place wanted = beside(n->own, n->word, gaps[g], angle);
            const double clear = rate(all, n, wanted, false),
                         straight = (k + 1) / 2 % (ways / 4) == 0 ? 0.2 : 0,
                         score = clear + straight - 0.4 * gaps[g];
            if (clear < 0 || score <= best + much)
                continue;
            /* No curve that does not pass the mark itself may be between the mark and the word. */
            const double from[2] = {n->own.x, n->own.y},
                         to[2] = {
                             fmin(fmax(from[0], wanted.x - wanted.half_width), wanted.x + wanted.half_width),
                             fmin(fmax(from[1], wanted.y - wanted.half_height),
                                  wanted.y + wanted.half_height)};
            if (n->row && meets_curve(all, from, to, 0.15))
                continue;
            best = score;
            *found = wanted;
        }
    return best > -1;
}

/* Find a place farther away that a line can lead to, and draw that line. */
static bool find_led(const places *all, const naming *n, place *found) {
    enum { ways = 72 };
    const double nearest = 0.9, farthest = 8, step = 0.4;
    for (double away = nearest; away < farthest; away += step) {
        double best = -1;
        place end = {0, 0, 0, 0};
        for (int k = 0; k < ways; k++) {
            const double angle = 2 * M_PI * k / ways;
            const place wanted = beside(n->own, n->word, away, angle);
            const double clear = rate(all, n, wanted, true);
            if (clear <= best)
                continue;
            /* The line ends at the edge of the word. */
            const double rest = fmin((n->word.half_width + 0.1) / fmax(fabs(cos(angle)), 1e-9),
                                     (n->word.half_height + 0.1) / fmax(fabs(sin(angle)), 1e-9));
            const place to = {wanted.x - rest * cos(angle), wanted.y - rest * sin(angle), 0, 0};
            if (!leads(all, n, to))
                continue;
            best = clear;
            end = to;
            *found = wanted;
        }
        if (best < 0)
            continue;
        fprintf(all->page->paper->file,
                "set arrow from graph %.4f,%.4f to graph %.4f,%.4f nohead back lc rgb '#808080' lw 0.8\n",
                n->own.x / all->wide, n->own.y / all->high, end.x / all->wide, end.y / all->high);
        return true;
    }
    return false;
}

/* How a name is joined to what it names: it stands beside it, or there is a line to it, which may have to
 * cross curves. */
typedef enum joint { BESIDE, LED, LED_ACROSS } joint;

/* The place of the visit of a row with the largest value, or the smallest; the row has visits. */
static place outer_place(const saltus_plot_page *page, int row, bool smallest) {
    const double sign = smallest ? -1 : 1;
    const saltus_plot_visit *visits = page->rows[row].visits;
    int found = 0;
    for (int v = 1; v < page->rows[row].count; v++)
        if (sign * visits[v].value > sign * visits[found].value)
            found = v;
    return place_of_visit(page, row, found);
}

/* Distance on the page between two rows; `none` if either has no place. */
static double way_between(const saltus_plot_page *page, int a, int b, double none) {
    if (!page->rows[a].count || !page->rows[b].count)
        return none;
    const double way = apart(outer_place(page, a, false), outer_place(page, b, false));
    return isfinite(way) ? way : none;
}

/* Whether a row and the next are of one branch and one motion, and both are shown or both are not. */
static bool continues(const saltus_plot_page *page, int k) {
    const saltus_plot_row *row = &page->rows[k];
    return row->joined && strcmp(row[0].point->label, row[1].point->label) == 0 &&
           saltus_plot_shown(page, row) == saltus_plot_shown(page, row + 1);
}

static stretch find_stretch(const saltus_plot_page *page, int first) {
    stretch s = {first, first, 0};
    for (; continues(page, s.last) &&
           (s.last == first || page->locus || page->rows[s.last].stroke == page->rows[first].stroke);
         s.last++)
        s.length += way_between(page, s.last + 1, s.last, 0);
    return s;
}

/* The row nearest to a fraction `part` of a stretch's length. */
static int row_at(const saltus_plot_page *page, const stretch *s, double part) {
    double passed = 0;
    for (int k = s->first + 1; k <= s->last; k++) {
        passed += way_between(page, k, k - 1, 0);
        if (passed >= part * s->length)
            return k;
    }
    return s->first;
}

/* Whether a row lies on a curve with the same label that is named for both: an earlier one of the same
 * stability, or a stable one that covers an unstable one. */
static bool named_below(const saltus_plot_page *page, const saltus_plot_row *row) {
    const double near = 0.15;
    const saltus_branch_point *own = row->point;
    const place at = place_of(page, row);
    for (int k = 0; k < page->row_count; k++) {
        const saltus_plot_row *other = &page->rows[k];
        const saltus_branch_point *p = other->point;
        if (other->file != row->file || !other->joined || p->branch == own->branch ||
            strcmp(p->label, own->label) != 0 ||
            !(p->stable == own->stable ? p->branch < own->branch : p->stable))
            continue;
        const place a = place_of(page, other), b = place_of(page, other + 1);
        if (saltus_plot_distance((double[2]){at.x, at.y}, (double[2]){a.x, a.y}, (double[2]){b.x, b.y}) <
            near)
            return true;
    }
    return false;
}

/* Find a place for the name of a stretch: on its curve where no other is or, if `led`, anyway; beside it or,
 * if `led`, at the end of a line. */
static bool find_on_stretch(const places *all, const stretch *s, const char *text, bool on_curve, bool led,
                            place *found) {
    const saltus_plot_page *page = all->page;
    static const double parts[] = {0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9};
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) {
        const int row = row_at(page, s, parts[k]);
        for (int n = 0; n < page->rows[row].count && n < 2; n++) {
            naming name = {.s = s, .word = word_of(page, text, 11, on_curve || page->over_sweep)};
            name.own = outer_place(page, row, n > 0);
            name.own.half_width = name.own.half_height = 0.05;
            const place there = moved(name.word, name.own.x, name.own.y);
            if (!isfinite(name.own.x) || !isfinite(name.own.y))
                continue;
            bool marked = false; /* a line that ends at a mark names that */
            for (int t = 0; t < all->count && led; t++)
                marked = marked || touches(all->taken[t], name.own);
            if (on_curve && is_free(all, there) && (led || clearance(all, there, 0.2, s, OTHER) > 0.1)) {
                *found = there;
                return true;
            }
            if (!on_curve && !marked && (led ? find_led : find_beside)(all, &name, found))
                return true;
        }
    }
    return false;
}

/* Whether a stretch goes on from one that has a name, in the same stroke and of the same motion. */
static bool goes_on(const places *all, const stretch *s) {
    const saltus_plot_page *page = all->page;
    const double near = 0.15;
    const saltus_plot_row *row = &page->rows[s->first];
    for (int k = 0; k < all->named_stretch_count; k++) {
        const stretch *other = &all->named_stretch[k];
        const saltus_plot_row *its = &page->rows[other->first];
        if (its->file != row->file || strcmp(its->point->label, row->point->label) != 0 ||
            its->stroke != row->stroke)
            continue;
        for (int ends = 0; ends < 4; ends++)
            if (way_between(page, ends % 2 ? s->last : s->first, ends / 2 ? other->last : other->first,
                            INFINITY) < near)
                return true;
    }
    return false;
}

/* Put the name of a stretch; if there is no place it is kept for a name with a line. Returns whether there
 * was a place. */
static bool name_stretch(places *all, const stretch *s, bool led) {
    const saltus_plot_page *page = all->page;
    static const char *const colour[SALTUS_HUES] = {"#1d4566", "#8f3719", "#136b5c", "#634078",
                                                    "#7a5c00", "#444444", "#7d004b"};
    const saltus_plot_row *row = &page->rows[s->first];
    saltus_line name = {.length = 0};
    place found;
    /* The label; on loci also the kind of point and the parameters in which the files differ. */
    if (page->locus)
        saltus_line_add(&name, "%s ", saltus_point_word(page->files[row->file].options.locus));
    saltus_line_plain(&name, row->point->label);
    if (page->locus)
        saltus_plot_add_differences(page, row->file, &name);
    const bool long_enough = s->length >= 2 * word_of(page, name.text, 11, true).half_width + 1.2;
    if (s->length < 0.8 || (page->locus && !long_enough) ||
        named_below(page, &page->rows[row_at(page, s, 0.5)]))
        return false;
    const bool on_curve = !led && long_enough &&
                          (find_on_stretch(all, s, name.text, true, false, &found) ||
                           (page->locus && find_on_stretch(all, s, name.text, true, true, &found)));
    if (!on_curve && (page->locus || !find_on_stretch(all, s, name.text, false, led, &found))) {
        if (!led && !page->locus && all->unnamed_stretch_count < places_max)
            all->unnamed_stretch[all->unnamed_stretch_count++] = *s;
        return false;
    }
    put_name(all, &name, found, on_curve || page->over_sweep, page->locus ? "#202020" : colour[row->hue], "",
             saltus_page_type(page->paper, 11));
    if (all->named_stretch_count < places_max)
        all->named_stretch[all->named_stretch_count++] = *s;
    return true;
}

/* Name the stable or the unstable stretches; equal names at the same place of the page are written once. */
static void name_stretches(places *all, bool stable) {
    const saltus_plot_page *page = all->page;
    const saltus_plot_row *begun = NULL; /* where the last named stretch of the file began */
    for (int k = 0; k < page->row_count;) {
        const saltus_plot_row *row = &page->rows[k];
        const stretch s = find_stretch(page, k);
        const bool solid = s.last > k && row->stroke == SALTUS_STROKE_STABLE;
        if (begun && begun->file != row->file)
            begun = NULL;
        /* Several branches from the same orbit are named once. */
        const bool known = begun && !row[-1].joined && begun->point->branch != row->point->branch &&
                           strcmp(begun->point->label, row->point->label) == 0 &&
                           apart(place_of(page, begun), place_of(page, row)) < 0.1;
        if (saltus_plot_shown(page, row) && solid == stable && !known && name_stretch(all, &s, false))
            begun = row;
        k = s.last > k && continues(page, s.last) ? s.last : s.last + 1;
    }
}

/* List the special points of all files, which have no names yet, and reserve the places of their marks, first
 * of the kinds whose marks are drawn over those of others. */
static void find_points(places *all) {
    const saltus_plot_page *page = all->page;
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_POINT_KINDS; kind++)
        for (int k = 0; k < page->row_count; k++) {
            const saltus_plot_row *row = &page->rows[k];
            if ((int)row->point->kind != kind || !is_visible(all, row))
                continue;
            place mark = place_of(page, row);
            mark.half_width = mark.half_height = mark_radius;
            take_place(all, mark);
            if (all->unnamed_count < places_max)
                all->unnamed[all->unnamed_count++] = row;
        }
}

/* Move a word off the curves, to the nearest place that no curve divides from where it was; false if there is
 * none. */
static bool find_in_region(const places *all, place *word) {
    enum { ways = 32 };
    const double farthest = 4, step = 0.2, clear = 0.12;
    for (double away = 0; away < farthest; away += step)
        for (int k = 0; k < (away > 0 ? ways : 1); k++) {
            const double angle = 2 * M_PI * k / ways;
            const place wanted = moved(*word, word->x + away * cos(angle), word->y + away * sin(angle));
            if (!is_free(all, wanted) || clearance(all, wanted, 2 * clear, NULL, EVERY) < clear ||
                meets_curve(all, (const double[2]){word->x, word->y}, (const double[2]){wanted.x, wanted.y},
                            0))
                continue;
            *word = wanted;
            return true;
        }
    return false;
}

saltus_status saltus_plot_check_labels(const saltus_plot_page *page, saltus_message *message) {
    for (int k = 0; k < page->label_count; k++) {
        const saltus_plot_label *label = &page->labels[k];
        const bool turned = strcmp(label->key[0], page->keys[0]) != 0;
        if (strcmp(label->key[turned], page->keys[0]) != 0 || strcmp(label->key[!turned], page->keys[1]) != 0)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "label %.60s: its place must be in what the figure shows, %s and %s",
                               label->text, page->keys[page->swap], page->keys[!page->swap]);
    }
    return SALTUS_OK;
}

/* The labels requested by the caller, in larger type than the other names. One that lies on a curve where the
 * region has no room for it, or over a map or a cloud, gets a white ground. */
static void name_regions(places *all) {
    const saltus_plot_page *page = all->page;
    const double size = saltus_page_narrow(page->paper) ? 12 : 17, bold = 1.15;
    for (int k = 0; k < page->label_count; k++) {
        const saltus_plot_label *label = &page->labels[k];
        const bool turned = strcmp(label->key[0], page->keys[0]) != 0;
        double x = label->value[turned], y = label->value[!turned];
        saltus_line line = {.length = 0};
        place where = place_at(page, x, y);
        saltus_line_plain(&line, label->text);
        where.half_width = 0.5 * saltus_page_width(line.text, bold * size) / word_height;
        where.half_height = 0.035 * size;
        if (x < page->x.low || x > page->x.high || y < page->y.low || y > page->y.high) {
            all->beyond++;
            continue;
        }
        const bool clear = find_in_region(all, &where);
        put_name(all, &line, where, !clear || page->over_sweep, "#101010", ":Bold", size);
    }
}

/* Try to name the first `most` points of those without a name. */
static void name_points(places *all, joint how, int most) {
    const saltus_plot_page *page = all->page;
    const int count = all->unnamed_count;
    all->unnamed_count = 0;
    for (int k = 0; k < count; k++) {
        const saltus_plot_row *row = all->unnamed[k];
        const saltus_point_kind kind = row->point->kind;
        const char *word = saltus_point_word(kind);
        naming n = {.row = row,
                    .own = place_of(page, row),
                    .word = word_of(page, word, 10, page->over_sweep),
                    .across = how == LED_ACROSS};
        place found;
        saltus_line line = {.length = 0};
        if (kind == SALTUS_POINT_UZ || kind == SALTUS_POINT_EP || named_already(page, row))
            continue;
        n.own.half_width = n.own.half_height = mark_radius;
        if (k >= most || !(how == BESIDE ? find_beside : find_led)(all, &n, &found)) {
            all->unnamed[all->unnamed_count++] = row;
            continue;
        }
        saltus_line_plain(&line, word);
        put_name(all, &line, found, page->over_sweep, page->over_sweep ? "#202020" : "#303030", "",
                 saltus_page_type(page->paper, 10));
    }
}

/* The same once more for stretches; those that go on from one with a name need none. */
static void name_stretches_again(places *all, int most) {
    const int count = all->unnamed_stretch_count;
    all->unnamed_stretch_count = 0;
    for (int k = 0; k < count; k++) {
        const stretch s = all->unnamed_stretch[k];
        if (!goes_on(all, &s) && (k >= most || !name_stretch(all, &s, true)))
            all->unnamed_stretch[all->unnamed_stretch_count++] = s;
    }
}

/* Say above the panel how many numbers and labels are not on its axes and how many marks, and stretches
 * longer than a name, have no name: the marks by their kinds, if that is short enough. */
static void put_note(const places *all) {
    const saltus_plot_page *page = all->page;
    const double size = 9, type = saltus_page_type(page->paper, size), above = 10, least = 2;
    int below = 0, stretches = 0;
    saltus_line line = {.length = 0};
    for (int k = 0; k < page->row_count && page->logarithmic[!page->swap] && !page->locus; k++) {
        const saltus_plot_row *row = &page->rows[k];
        for (int v = 0; v < row->count; v++)
            below += saltus_plot_measured(page, row) && !(row->visits[v].value > 0);
        below += saltus_plot_measured(page, row) && row->count == 0 && !((page->swap ? row->x : row->y) > 0);
    }
    for (int k = 0; k < all->unnamed_stretch_count; k++)
        stretches += all->unnamed_stretch[k].length >= least;
    const bool unnamed = all->unnamed_count || stretches;
    for (int kinds = 1; kinds >= 0; kinds--) {
        line.length = 0;
        if (below)
            saltus_line_add(&line, "at or below 0, so not shown: %d", below);
        if (all->beyond)
            saltus_line_add(saltus_line_next(&line), "labels beyond the axes: %d", all->beyond);
        if (unnamed)
            saltus_line_add(saltus_line_next(&line), "no room to name:");
        for (int kind = SALTUS_POINT_LP, first = 1; kind < SALTUS_POINT_KINDS && kinds; kind++) {
            int count = 0;
            for (int k = 0; k < all->unnamed_count; k++)
                count += (int)all->unnamed[k]->point->kind == kind;
            if (count)
                saltus_line_add(&line, "%s %d %s", first ? "" : ",", count, saltus_point_word(kind));
            first = first && !count;
        }
        if (!kinds && all->unnamed_count)
            saltus_line_add(&line, " %d mark%s", all->unnamed_count, saltus_plural(all->unnamed_count));
        if (stretches)
            saltus_line_add(&line, "%s %d piece%s of curve", all->unnamed_count ? "," : "", stretches,
                            saltus_plural(stretches));
        if (saltus_page_width(line.text, type) < page->frame.right - page->frame.left)
            break;
    }
    if (line.length)
        saltus_page_label(page->paper, line.text, page->frame.right, page->frame.top + above,
                          "right front font ',%.4g' tc rgb '#606060'", type);
}

void saltus_plot_labels(const saltus_plot_page *page, saltus_plot_block *block, void *context) {
    const double h = word_height, step = 0.2, rim = 0.2, margin = 0.3; /* in word heights */
    enum { most_led = 40 };
    places all = {.page = page,
                  .wide = (page->frame.right - page->frame.left) / word_height,
                  .high = (page->frame.top - page->frame.bottom) / word_height};
    const bool over_map = page->locus && page->over_sweep;
    const int few = (int)fmax(6, all.wide * all.high / 130); /* the more, the larger the panel */
    find_pieces(&all);
    name_regions(&all);
    find_points(&all);
    /* On a map the colours identify the motions; on loci the names of points come first. */
    if (!over_map && !page->locus)
        name_stretches(&all, true);
    const int stable = all.unnamed_stretch_count;
    name_points(&all, BESIDE, places_max);
    if (!over_map)
        name_stretches(&all, page->locus);
    if (!over_map && page->locus)
        name_stretches(&all, false);
    /* Lines only as many as remain readable: to stable stretches and to points, but across curves and to
     * unstable stretches only if they are few. */
    name_stretches_again(&all, stable < most_led ? stable : most_led);
    if (!over_map) {
        name_points(&all, LED, most_led);
        name_points(&all, LED_ACROSS, all.unnamed_count <= few ? few : 0);
        name_stretches_again(&all, all.unnamed_stretch_count <= few ? few : 0);
    }
    put_note(&all);
    for (int k = 0; k < all.count && block; k++) {
        const place *p = &all.taken[k];
        block(context,
              (saltus_frame){h * (p->x - p->half_width - margin), h * (p->x + p->half_width + margin),
                             h * (p->y - p->half_height - margin), h * (p->y + p->half_height + margin)});
    }
    for (int k = 0; k < all.piece_count && block; k++) {
        const double *a = all.pieces[k].ends[0], *b = all.pieces[k].ends[1];
        int steps = 1 + (int)fmin(hypot(b[0] - a[0], b[1] - a[1]) / step, 1e5);
        for (int n = 0; n <= steps; n++) {
            double x = a[0] + n * (b[0] - a[0]) / steps, y = a[1] + n * (b[1] - a[1]) / steps;
            block(context, (saltus_frame){h * (x - rim), h * (x + rim), h * (y - rim), h * (y + rim)});
        }
    }
    free(all.pieces);
}
