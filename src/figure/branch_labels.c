/* Text on a bifurcation diagram, placed without overlaps: n/p along each stretch of a branch, and names of
 * special points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include "record/describe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { places_max = 400 };

/* Height of a word in page units, and width of a letter in heights. */
static const double word_height = 20.2, letter_width = 0.62;

/* Places are in word heights, from the panel's lower left corner. */
typedef struct place {
    double x, y, half_width, half_height;
} place;

typedef struct places {
    place taken[places_max];
    int count;
    double (*lines)[2][2]; /* the pieces of all curves, also in word heights */
    int line_count;
    const saltus_branch_point *unnamed[places_max]; /* special points whose names found no place */
    int unnamed_count;
} places;

static double wide(const saltus_plot_page *page) {
    return (page->frame.right - page->frame.left) / word_height;
}

static double high(const saltus_plot_page *page) {
    return (page->frame.top - page->frame.bottom) / word_height;
}

static place place_at(const saltus_plot_page *page, double x, double y, double letters) {
    double at[2];
    saltus_plot_place(page, x, y, at);
    return (place){at[0] / word_height, at[1] / word_height, 0.5 * letter_width * letters + 0.5, 0.75};
}

static place place_of(const saltus_plot_page *page, const saltus_branch_point *point, size_t letters) {
    return place_at(page, saltus_plot_x(page, point), saltus_plot_y(page, point), (double)letters);
}

static double apart(place a, place b) {
    return hypot(a.x - b.x, a.y - b.y);
}

/* Distance on the page from row k - 1 to row k of a file. */
static double way_to(const saltus_plot_page *page, const saltus_branch_file *f, int k) {
    return apart(place_of(page, &f->points[k], 0), place_of(page, &f->points[k - 1], 0));
}

static bool is_free(const saltus_plot_page *page, const places *all, place wanted) {
    if (all->count == places_max || wanted.x < wanted.half_width ||
        !(wanted.x <= wide(page) - wanted.half_width) || wanted.y < 0.6 || !(wanted.y <= high(page) - 0.6))
        return false;
    for (int k = 0; k < all->count; k++)
        if (fabs(all->taken[k].x - wanted.x) < all->taken[k].half_width + wanted.half_width &&
            fabs(all->taken[k].y - wanted.y) < all->taken[k].half_height + wanted.half_height)
            return false;
    return true;
}

static void put_label(const saltus_plot_page *page, const saltus_line *line, place where, const char *style) {
    fputs("set label ", page->paper->file);
    saltus_put_quoted(page->paper->file, line->text, line->length);
    fprintf(page->paper->file, " at graph %.4f,%.4f %s\n", where.x / wide(page), where.y / high(page), style);
}

/* The pieces of all curves, one per branch or one per visit. Without memory, names are placed as if there
 * were no curves. */
static void find_lines(const saltus_plot_page *page, places *all) {
    size_t most = 1;
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++)
            most += page->visits ? (size_t)page->visits[i][k].count : 1;
    all->lines = calloc(most, sizeof *all->lines);
    for (int i = 0; i < page->count && all->lines; i++)
        for (int k = 0; k + 1 < page->files[i].point_count; k++) {
            const saltus_branch_point *p = &page->files[i].points[k];
            const saltus_plot_visits *visits = page->visits ? &page->visits[i][k] : NULL;
            for (int v = 0; p[0].branch == p[1].branch && v < (visits ? visits->count : 1); v++) {
                int next = visits ? saltus_plot_partner(page, i, k, v) : 0;
                for (int end = 0; end < 2 && next >= 0; end++) {
                    double *at = all->lines[all->line_count][end], x = saltus_plot_x(page, &p[end]),
                           y = saltus_plot_y(page, &p[end]);
                    if (visits)
                        *(page->swap ? &x : &y) = end ? visits[1].list[next].value : visits->list[v].value;
                    saltus_plot_place(page, x, y, at);
                    at[0] /= word_height;
                    at[1] /= word_height;
                }
                all->line_count += next >= 0;
            }
        }
}

/* Distance from a place to the nearest curve, exact only below `enough`. */
static double clearance(const places *all, place wanted, double enough) {
    double least = enough;
    for (int k = 0; k < all->line_count; k++)
        least = fmin(
            least, saltus_plot_distance((double[2]){wanted.x, wanted.y}, all->lines[k][0], all->lines[k][1]));
    return least;
}

/* The same for the whole width of a word. */
static double clearance_of_word(const places *all, place wanted) {
    const double enough = 1.3, half = wanted.half_width - 0.5;
    double least = enough;
    for (int k = -1; k <= 1; k++)
        least = fmin(least, clearance(all, (place){wanted.x + k * half, wanted.y, 0, 0}, enough));
    return least;
}

static void take_place(places *all, place taken) {
    if (all->count < places_max)
        all->taken[all->count++] = taken;
}

/* Whether an earlier point of the same kind, in the order of the files, has its mark at this place. */
static bool named_already(const saltus_plot_page *page, const saltus_branch_point *point) {
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *other = &page->files[i].points[k];
            if (other == point)
                return false;
            if (other->kind == point->kind && apart(place_of(page, other, 0), place_of(page, point, 0)) < 0.8)
                return true;
        }
    return false;
}

/* Whether a name at this place would be nearer to the mark of a point of another kind. */
static bool misleads(const saltus_plot_page *page, const saltus_branch_point *point, place wanted) {
    const double same = 0.3;
    const place own = place_of(page, point, 0);
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *other = &page->files[i].points[k];
            if (other->kind == point->kind || !saltus_plot_marked(&page->files[i], other) ||
                !saltus_plot_shown(page, other))
                continue;
            const place its = place_of(page, other, 0);
            if (apart(its, own) > same && apart(its, wanted) < apart(own, wanted))
                return true;
        }
    return false;
}

static void put_point_name(const saltus_plot_page *page, const char *word, place where, places *all) {
    saltus_line line = {.length = 0};
    saltus_line_plain(&line, word);
    put_label(page, &line, where,
              page->over_map ? "center front boxed tc rgb '#202020' font ',10'"
                             : "center front tc rgb '#303030' font ',10'");
    take_place(all, where);
}

/* Put a special point's name beside it, at the place farthest from the curves. */
static void name_point(const saltus_plot_page *page, const saltus_branch_point *point, places *all) {
    static const double shift[][2] = {
        {0, 1.2}, {1.7, 0.6}, {-1.7, 0.6}, {1.8, 0},    {-1.8, 0},   {1.7, -0.6},  {-1.7, -0.6}, {0, -1.2},
        {0, 1.9}, {0, -1.9},  {1.9, 1.5},  {-1.9, 1.5}, {1.9, -1.5}, {-1.9, -1.5}, {2.7, 0.4},   {-2.7, 0.4}};
    /* A curve nearer than this would strike the name through; kinds without a mark of their own are named
     * even then. */
    const double enough = 0.75, least = point->kind >= SALTUS_POINT_CP ? 0 : 0.3;
    const char *word = saltus_point_word(point->kind);
    place best = {0, 0, 0, 0};
    double widest = least;
    if (point->kind == SALTUS_POINT_UZ || point->kind == SALTUS_POINT_EP || named_already(page, point))
        return;
    for (size_t k = 0; k < sizeof shift / sizeof shift[0] && widest < enough; k++) {
        place wanted = place_of(page, point, strlen(word));
        /* The shifts are for names of two letters. */
        double longer = 0.5 * letter_width * ((double)strlen(word) - 2);
        wanted.x += shift[k][0] + (shift[k][0] > 0 ? longer : shift[k][0] < 0 ? -longer : 0);
        if (shift[k][0] == 0)
            wanted.x = fmin(fmax(wanted.x, wanted.half_width), wide(page) - wanted.half_width);
        wanted.y += shift[k][1];
        double away =
            is_free(page, all, wanted) && !misleads(page, point, wanted) ? clearance_of_word(all, wanted) : 0;
        if (away <= widest + 0.1)
            continue;
        widest = away;
        best = wanted;
    }
    if (widest > least)
        put_point_name(page, word, best, all);
    else if (all->unnamed_count < places_max)
        all->unnamed[all->unnamed_count++] = point;
}

/* Whether a line from a point to a place crosses no name, no mark except at the point, and no curve except
 * there. */
static bool leads(const places *all, place from, place to) {
    const double step = 0.2, begin = 0.9, near = 0.12, mark = 0.42; /* in heights of a word */
    const double length = apart(from, to);
    for (double way = begin; way < length; way += step) {
        const place at = {from.x + way / length * (to.x - from.x), from.y + way / length * (to.y - from.y), 0,
                          0};
        if (clearance(all, at, near) < near)
            return false;
        for (int k = 0; k < all->count; k++) {
            /* The space taken by a word includes a margin. */
            const place *taken = &all->taken[k];
            if (apart(*taken, from) > begin && fabs(taken->x - at.x) < fmax(mark, taken->half_width - 0.3) &&
                fabs(taken->y - at.y) < fmax(mark, taken->half_height - 0.25))
                return false;
        }
    }
    return true;
}

/* Put names that found no place beside their points farther away, with a line to the point; only as many as
 * remain readable. */
static void lead_to_names(const saltus_plot_page *page, places *all) {
    enum { ways = 36, most = 40 };
    const double nearest = 2.2, farthest = 8, step = 0.6, enough = 0.6;
    for (int u = 0; u < all->unnamed_count && u < most; u++) {
        const saltus_branch_point *point = all->unnamed[u];
        const char *word = saltus_point_word(point->kind);
        const place own = place_of(page, point, 0);
        bool named = false;
        for (double away = nearest; away < farthest && !named; away += step)
            for (int k = 0; k < ways && !named; k++) {
                const double angle = 2 * M_PI * k / ways, across = cos(angle), up = sin(angle);
                place wanted = place_of(page, point, strlen(word));
                wanted.x += away * across;
                wanted.y += away * up;
                /* The line ends at the edge of the word. */
                const double rest = fmin(fabs((wanted.half_width - 0.4) / across), fabs(0.5 / up));
                const place end = {wanted.x - rest * across, wanted.y - rest * up, 0, 0};
                named = is_free(page, all, wanted) && !misleads(page, point, wanted) &&
                        clearance_of_word(all, wanted) >= enough && leads(all, own, end);
                if (!named)
                    continue;
                fprintf(
                    page->paper->file,
                    "set arrow from graph %.4f,%.4f to graph %.4f,%.4f nohead back lc rgb '#808080' lw 0.8\n",
                    own.x / wide(page), own.y / high(page), end.x / wide(page), end.y / high(page));
                put_point_name(page, word, wanted, all);
            }
    }
}

/* A stretch of one branch along which the label of the motion is the same. */
typedef struct stretch {
    int first, last; /* rows of the file */
    double length;   /* on the page */
} stretch;

static stretch find_stretch(const saltus_plot_page *page, const saltus_branch_file *f, int first) {
    stretch s = {first, first, 0};
    for (int k = first + 1;
         k < f->point_count && f->points[k].branch == f->points[first].branch &&
         saltus_plot_shown(page, &f->points[k]) == saltus_plot_shown(page, &f->points[first]) &&
         strcmp(f->points[k].label, f->points[first].label) == 0 &&
         (k == first + 1 || page->locus ||
          saltus_plot_stroke(f, k - 1, k) == saltus_plot_stroke(f, first, first + 1));
         k++) {
        s.length += way_to(page, f, k);
        s.last = k;
    }
    return s;
}

/* The row nearest to a fraction `part` of a stretch's length. */
static int row_at(const saltus_plot_page *page, const saltus_branch_file *f, stretch s, double part) {
    double passed = 0;
    for (int k = s.first + 1; k <= s.last; k++) {
        passed += way_to(page, f, k);
        if (passed >= part * s.length)
            return k;
    }
    return s.first;
}

/* Distance from a place to the piece of a curve between row k of a file and the next. */
static double from_piece(const saltus_plot_page *page, const saltus_branch_file *f, int k, place at) {
    const place a = place_of(page, &f->points[k], 0), b = place_of(page, &f->points[k + 1], 0);
    return saltus_plot_distance((double[2]){at.x, at.y}, (double[2]){a.x, a.y}, (double[2]){b.x, b.y});
}

/* Whether a row lies on an earlier curve with the same label, which is named already. */
static bool named_below(const saltus_plot_page *page, const saltus_branch_file *f, int row) {
    const double near = 0.15;
    const saltus_branch_point *own = &f->points[row];
    for (int k = 0; k + 1 < f->point_count && f->points[k].branch < own->branch; k++)
        if (strcmp(f->points[k].label, own->label) == 0 && f->points[k].branch == f->points[k + 1].branch &&
            f->points[k].stable == own->stable && from_piece(page, f, k, place_of(page, own, 0)) < near)
            return true;
    return false;
}

/* Whether a name at this place would be nearer to another curve than to its own stretch. */
static bool strays(const saltus_plot_page *page, const saltus_branch_file *f, stretch s, place wanted,
                   const places *all) {
    const double slack = 0.1;
    double own = INFINITY;
    for (int k = s.first; k < s.last; k++)
        own = fmin(own, from_piece(page, f, k, wanted));
    return clearance(all, wanted, own) < own - slack;
}

/* Put the name of a stretch on its curve if that is long enough, otherwise beside it; returns whether there
 * was a place. */
static bool name_stretch(const saltus_plot_page *page, int file, stretch s, places *all) {
    static const double parts[] = {0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9};
    static const double shift[][2] = {{0, 0},     {0.9, 0.8},  {-0.9, 0.8}, {0.9, -0.8}, {-0.9, -0.8},
                                      {1.6, 0.9}, {-1.6, 0.9}, {1.6, -0.9}, {-1.6, -0.9}};
    static const char *const colour[SALTUS_HUES] = {"#1d4566", "#8f3719", "#1f6650", "#634078",
                                                    "#7a5c00", "#444444", "#7d004b"};
    const saltus_branch_file *f = &page->files[file];
    saltus_line name = {.length = 0};
    /* The label; on loci also the kind of point and the parameters in which the files differ. */
    if (page->locus)
        saltus_line_add(&name, "%s ", saltus_point_word(f->options.locus));
    saltus_line_plain(&name, f->points[s.first].label);
    int letters = (int)name.length;
    if (page->locus)
        saltus_plot_add_differences(page, file, &name);
    letters += (int)name.length > letters ? 10 : 0;
    int hue = saltus_plot_hue(page, file, f->points[s.first].branch);
    bool long_enough = s.length >= 1.5 * letter_width * letters + 1;
    const size_t ways = page->locus ? 1 : sizeof shift / sizeof shift[0];
    if (s.length < 0.8 || (page->locus && !long_enough) || named_below(page, f, row_at(page, f, s, 0.5)))
        return false;
    for (size_t way = long_enough ? 0 : 1; way < ways; way++)
        for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) {
            char style[96];
            int row = row_at(page, f, s, parts[k]);
            place wanted = place_of(page, &f->points[row], (size_t)letters + (way == 0));
            wanted.x += shift[way][0] + (shift[way][0] > 0   ? 1
                                         : shift[way][0] < 0 ? -1
                                                             : 0) *
                                            fmax(0, 0.5 * letter_width * (letters - 3));
            wanted.y += shift[way][1];
            /* A row without visits has no curve here. */
            if ((page->visits && !page->visits[file][row].count) || !is_free(page, all, wanted) ||
                (way > 0 && (clearance_of_word(all, wanted) < 0.75 || strays(page, f, s, wanted, all))))
                continue;
            snprintf(style, sizeof style, "center front %stc rgb '%s' font ',11'", way ? "" : "boxed ",
                     page->locus ? "#202020" : colour[hue]);
            put_label(page, &name, wanted, style);
            take_place(all, wanted);
            return true;
        }
    return false;
}

/* Name the stable or the unstable stretches; equal names at the same place of the page are written once. */
static void name_stretches(const saltus_plot_page *page, bool stable, places *all) {
    for (int i = 0; i < page->count; i++) {
        const saltus_branch_file *f = &page->files[i];
        const saltus_branch_point *begun = NULL; /* where the last named stretch began */
        for (int k = 0; k < f->point_count;) {
            stretch s = find_stretch(page, f, k);
            bool solid =
                s.last > s.first && saltus_plot_stroke(f, s.first, s.first + 1) == SALTUS_STROKE_STABLE;
            bool begins = k == 0 || f->points[k - 1].branch != f->points[k].branch;
            /* Several branches from the same orbit are named once. */
            bool known = begins && begun && begun->branch != f->points[k].branch &&
                         strcmp(begun->label, f->points[k].label) == 0 &&
                         apart(place_of(page, begun, 0), place_of(page, &f->points[k], 0)) < 0.1;
            if (saltus_plot_shown(page, &f->points[s.first]) && solid == stable && !known &&
                name_stretch(page, i, s, all))
                begun = &f->points[k];
            k = s.last > s.first && s.last + 1 < f->point_count &&
                        f->points[s.last + 1].branch == f->points[s.last].branch &&
                        strcmp(f->points[s.last + 1].label, f->points[s.last].label) == 0 &&
                        saltus_plot_shown(page, &f->points[s.last + 1]) ==
                            saltus_plot_shown(page, &f->points[s.last])
                    ? s.last
                    : s.last + 1;
        }
    }
}

/* Special points of all files: reserve the places of their marks, or write their names. */
static void name_points(const saltus_plot_page *page, bool marks, places *all) {
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *point = &page->files[i].points[k];
            if (!saltus_plot_marked(&page->files[i], point) || !saltus_plot_shown(page, point))
                continue;
            place mark = place_of(page, point, 0);
            mark.half_width = mark.half_height = 0.42;
            if (marks)
                take_place(all, mark);
            else
                name_point(page, point, all);
        }
}

bool saltus_plot_value_of(const saltus_spec *spec, int k, const char *const axes[2], saltus_plot_value *v) {
    int count, keys;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    const saltus_parameter *s = saltus_stop_parameters(&keys);
    const int stop = k < count ? -1 : (k - count) / keys, own = k < count ? k : (k - count) % keys;
    const char *name = stop < 0 ? p[own].name : s[own].name;
    if (stop >= spec->stop_count)
        return false;
    if (stop < 0 || spec->stop_count == 1)
        snprintf(v->key, sizeof v->key, "%s", name);
    else
        snprintf(v->key, sizeof v->key, "%s%d", name, stop + 1);
    if (stop < 0)
        v->value = spec->parameters[own];
    else
        v->value = (const double[]){spec->stops[stop].xi, spec->stops[stop].d, spec->stops[stop].r}[own];
    v->on_axis = false;
    for (int a = 0; a < 2; a++)
        v->on_axis = v->on_axis || (stop < 0 ? strcmp(axes[a], name) == 0
                                             : *axes[a] && saltus_key_means(axes[a], name, stop));
    return true;
}

/* The k-th value of a file; false beyond the last. *differs: not the same in all files. */
static bool value_in(const saltus_plot_page *page, int file, int k, saltus_plot_value *v, bool *differs) {
    const saltus_branch_options *o = &page->files[0].options;
    const char *const axes[2] = {o->key[0], o->key[1]};
    saltus_plot_value first;
    *differs = false;
    for (int i = 1; i < page->count && saltus_plot_value_of(&page->files[0].spec, k, axes, &first); i++)
        *differs = *differs || (saltus_plot_value_of(&page->files[i].spec, k, axes, v) && !v->on_axis &&
                                v->value != first.value);
    return saltus_plot_value_of(&page->files[file].spec, k, axes, v);
}

void saltus_plot_difference(const saltus_plot_page *page, int rank, char key[SALTUS_KEY_MAX]) {
    saltus_plot_value v;
    bool differs;
    key[0] = '\0';
    for (int k = 0; rank >= 0 && value_in(page, 0, k, &v, &differs); k++)
        if (differs && rank-- == 0)
            memcpy(key, v.key, sizeof v.key);
}

void saltus_plot_add_differences(const saltus_plot_page *page, int file, saltus_line *line) {
    saltus_plot_value v;
    bool differs;
    for (int k = 0; value_in(page, file, k, &v, &differs); k++) {
        if (!differs)
            continue;
        saltus_line_add(line, ", ");
        saltus_line_symbol(line, v.key);
        saltus_line_add(line, " = ");
        saltus_line_number(line, "%.6g", v.value);
    }
}

void saltus_plot_labels(const saltus_plot_page *page, saltus_plot_block *block, void *context) {
    const double h = word_height, step = 0.2, rim = 0.2; /* in word heights */
    places all = {.count = 0};
    find_lines(page, &all);
    /* The labels requested by the caller, in larger type than the other names. */
    for (int k = 0; k < page->options->label_count; k++) {
        const saltus_plot_label *label = &page->options->labels[k];
        const bool turned = strcmp(label->key[0], page->files[0].options.key[0]) != 0;
        const double x = label->value[turned], y = label->value[!turned];
        const place where = place_at(page, x, y, 2 * (double)strlen(label->text));
        saltus_line line = {.length = 0};
        if (x < page->x.low || x > page->x.high || y < page->y.low || y > page->y.high)
            continue;
        saltus_line_plain(&line, label->text);
        put_label(page, &line, where, "center front tc rgb '#101010' font ':Bold,17'");
        take_place(&all, where);
    }
    name_points(page, true, &all);
    /* On a map the colours identify the motions; on loci the names of points come first. */
    if (!page->over_map && !page->locus)
        name_stretches(page, true, &all);
    name_points(page, false, &all);
    if (!page->over_map && page->locus)
        name_stretches(page, true, &all);
    if (!page->over_map) {
        name_stretches(page, false, &all);
        lead_to_names(page, &all);
    }
    for (int k = 0; k < all.count && block; k++) {
        const place *p = &all.taken[k];
        block(context, (saltus_frame){h * (p->x - p->half_width), h * (p->x + p->half_width),
                                      h * (p->y - p->half_height), h * (p->y + p->half_height)});
    }
    for (int k = 0; k < all.line_count && block; k++) {
        const double *a = all.lines[k][0], *b = all.lines[k][1];
        int steps = 1 + (int)fmin(hypot(b[0] - a[0], b[1] - a[1]) / step, 1e5);
        for (int n = 0; n <= steps; n++) {
            double x = a[0] + n * (b[0] - a[0]) / steps, y = a[1] + n * (b[1] - a[1]) / steps;
            block(context, (saltus_frame){h * (x - rim), h * (x + rim), h * (y - rim), h * (y + rim)});
        }
    }
    free(all.lines);
}
