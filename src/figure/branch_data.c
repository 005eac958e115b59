/* The numbers of a bifurcation diagram, as datablocks inside gnuplot's script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include <math.h>

double saltus_plot_x(const saltus_branch_point *point) {
    return point->value[0];
}

bool saltus_plot_shown(const saltus_plot_page *page, const saltus_branch_point *point) {
    double x = saltus_plot_x(point), y = page->locus ? point->value[1] : page->y.low;
    return x >= page->x.low && x <= page->x.high && y >= page->y.low && y <= page->y.high;
}

/* Whether a point lies on the border of what was asked for. */
static bool on_border(const saltus_branch_options *o, const saltus_branch_point *point) {
    for (int k = 0; k < 2; k++) {
        double near = 1e-9 * (o->high[k] - o->low[k]);
        if (o->key[k][0] &&
            (fabs(point->value[k] - o->low[k]) <= near || fabs(point->value[k] - o->high[k]) <= near))
            return true;
    }
    return false;
}

double saltus_impact_speed(const saltus_event *event) {
    return event->kind == SALTUS_IMPACT || event->kind == SALTUS_STICK ? fabs(event->velocity_before) : NAN;
}

static double largest_speed(const saltus_branch_point *point) {
    double largest = 0;
    for (int k = 0; k < point->event_count; k++)
        largest = fmax(largest, saltus_impact_speed(&point->events[k]));
    return largest;
}

/* Where all impacts are shown a grazing one is the slowest of them. */
static double slowest(const saltus_branch_point *point) {
    double least = INFINITY;
    for (int k = 0; k < point->event_count; k++)
        least = fmin(least, saltus_impact_speed(&point->events[k]));
    return isfinite(least) ? least : 0;
}

saltus_point_kind saltus_plot_mark(saltus_point_kind kind) {
    return kind > SALTUS_POINT_CP ? SALTUS_POINT_CP : kind;
}

double saltus_plot_y(const saltus_plot_page *page, const saltus_branch_point *point) {
    if (page->locus)
        return point->value[1];
    switch (page->show) {
    case SALTUS_SHOW_DISPLACEMENT:
        return saltus_system_observed(page->system, point->state);
    case SALTUS_SHOW_VELOCITY:
        return saltus_system_observed(page->system, point->state + saltus_system_dof(page->system));
    case SALTUS_SHOW_PERIOD:
        return point->periods;
    case SALTUS_SHOW_IMPACTS:
        return point->kind == SALTUS_POINT_GR ? slowest(point) : largest_speed(point);
    default:
        return largest_speed(point);
    }
}

static const saltus_branch_point *first_of(const saltus_branch_file *f, int branch) {
    for (int k = 0; k < f->point_count; k++)
        if (f->points[k].branch == branch)
            return &f->points[k];
    return NULL;
}

int saltus_plot_hue(const saltus_plot_page *page, int file, int branch) {
    const saltus_branch_point *first = first_of(&page->files[file], branch);
    if (page->locus)
        return ((first ? first->locus : page->files[file].options.locus) - SALTUS_POINT_LP) % SALTUS_HUES;
    if (page->count > 1)
        return file % SALTUS_HUES;
    int depth = 0;
    for (; first && first->parent >= 0 && depth <= SALTUS_HUES; depth++)
        first = first_of(&page->files[file], first->parent);
    return depth % SALTUS_HUES;
}

/* How far a multiplier is from making a point one of that kind. */
static double from_critical(const saltus_multiplier *m, saltus_point_kind kind) {
    if (kind == SALTUS_POINT_NS)
        return m->im != 0 ? fabs(m->log_modulus) : INFINITY;
    return hypot(m->re - (kind == SALTUS_POINT_PD ? -1 : 1), m->im);
}

/* Whether multipliers are outside the unit circle other than those that make the point special. */
static bool others_outside(const saltus_branch_point *point, saltus_point_kind kind) {
    const double inside = 1e-6;
    int critical = 0, outside = 0;
    for (int k = 1; k < point->dimension; k++)
        if (from_critical(&point->multipliers[k], kind) < from_critical(&point->multipliers[critical], kind))
            critical = k;
    for (int k = 0; k < point->dimension; k++)
        if (k != critical && !(kind == SALTUS_POINT_NS && k == critical + 1))
            outside += !(point->multipliers[k].log_modulus < inside);
    return outside > 0;
}

/* A grazing point bounds stable orbits when the orbit is stable without the impact that grazes. With it the
 * largest multiplier has no bound, and the others tell nothing of those without it. */
static bool counts_grazing_impact(const saltus_branch_point *point) {
    const double huge = 50;
    return point->dimension > 0 && !(exp(point->multipliers[0].log_modulus) < huge);
}

/* Whether a point of a curve of special points bounds stable orbits; where its multipliers do not tell, what
 * those of the nearest point that do tell. */
static bool bounds_stable(const saltus_branch_file *f, int k) {
    const saltus_branch_point *points = f->points;
    if (points[k].locus != SALTUS_POINT_GR)
        return !others_outside(&points[k], points[k].locus);
    for (int reach = 0; reach < f->point_count; reach++)
        for (int side = -1; side <= 1; side += 2) {
            int j = k + side * reach;
            if (j >= 0 && j < f->point_count && points[j].branch == points[k].branch &&
                !counts_grazing_impact(&points[j]))
                return points[j].dimension == 0 || points[j].multipliers[0].log_modulus < 0;
        }
    return true;
}

/* Whether an end is worth a mark: not that of the range, nor one of a curve that bounds nothing stable. */
static bool ends_early(const saltus_branch_file *f, const saltus_branch_point *point) {
    int k = (int)(point - f->points);
    if (on_border(&f->options, point))
        return false;
    return f->options.locus == SALTUS_POINT_REGULAR ||
           (k > 0 && f->points[k - 1].branch == point->branch && bounds_stable(f, k - 1));
}

bool saltus_plot_marked(const saltus_branch_file *file, const saltus_branch_point *point) {
    /* A curve that ends at a point of codimension two has that one's mark. */
    if (point->kind == SALTUS_POINT_EP)
        return ends_early(file, point) && !(point > file->points && point[-1].kind >= SALTUS_POINT_CP);
    return point->kind != SALTUS_POINT_REGULAR && point->kind != point->locus;
}

/* Whether a point of a branch is as stable as its neighbours: not one at which that changes. */
static bool tells(const saltus_branch_point *point) {
    return point->kind == SALTUS_POINT_REGULAR || point->kind == SALTUS_POINT_UZ ||
           point->kind == SALTUS_POINT_EP;
}

/* How the curve runs from a point to the next one: at a special point the side tells, not the point. */
static saltus_stroke stroke_between(const saltus_branch_file *f, int from, int to) {
    const saltus_branch_point *a = &f->points[from], *b = &f->points[to];
    if (f->options.locus != SALTUS_POINT_REGULAR)
        return bounds_stable(f, from) && bounds_stable(f, to) ? SALTUS_STROKE_STABLE : SALTUS_STROKE_UNSTABLE;
    if (!a->admissible && !b->admissible)
        return SALTUS_STROKE_FOREIGN;
    const saltus_branch_point *side = tells(a) ? a : b;
    bool stable = tells(a) && tells(b) ? a->stable && b->stable : side->stable;
    return stable ? SALTUS_STROKE_STABLE : SALTUS_STROKE_UNSTABLE;
}

static void put_pieces(const saltus_plot_page *page, const saltus_branch_file *f, int branch,
                       saltus_stroke stroke) {
    int last = -1;
    bool drawing = false;
    for (int k = 0; k < f->point_count; k++) {
        const saltus_branch_point *point = &f->points[k];
        if (point->branch != branch)
            continue;
        bool wanted = last >= 0 && stroke_between(f, last, k) == stroke;
        if (wanted && !drawing)
            fprintf(page->file, "\n%.12g %.9g\n", saltus_plot_x(&f->points[last]),
                    saltus_plot_y(page, &f->points[last]));
        if (wanted)
            fprintf(page->file, "%.12g %.9g\n", saltus_plot_x(point), saltus_plot_y(page, point));
        drawing = wanted;
        last = k;
    }
}

static int branch_count(const saltus_branch_file *f) {
    int count = 0;
    for (int k = 0; k < f->point_count; k++)
        if (f->points[k].branch >= count)
            count = f->points[k].branch + 1;
    return count;
}

static void put_curves(const saltus_plot_page *page, int hue, saltus_stroke stroke) {
    fprintf(page->file, "$curve_%d_%d << EOD\n# parameter, measure\n", hue, (int)stroke);
    for (int i = 0; i < page->count; i++)
        for (int branch = 0; branch < branch_count(&page->files[i]); branch++)
            if (saltus_plot_hue(page, i, branch) == hue)
                put_pieces(page, &page->files[i], branch, stroke);
    fputs("\nEOD\n", page->file);
}

/* The impact of point b that is nearest in time to event e of point a, on the same face; -1 when there is
 * none near. Where an impact is born or dies it has no partner. */
static int nearest_impact(const saltus_branch_point *a, int e, const saltus_branch_point *b) {
    const double near = 0.2; /* of a forcing period */
    const saltus_event *from = &a->events[e];
    double least = near, p = a->periods;
    int nearest = -1;
    for (int k = 0; k < b->event_count; k++) {
        double apart =
            fabs(remainder(saltus_time_periods(b->events[k].time) - saltus_time_periods(from->time), p));
        if (isnan(saltus_impact_speed(&b->events[k])) || b->events[k].face != from->face || apart >= least)
            continue;
        least = apart;
        nearest = k;
    }
    return nearest;
}

/* The same impact at the next point of a branch: each must be the other's nearest. */
static int partner(const saltus_branch_point *a, int e, const saltus_branch_point *b) {
    int found =
        a->periods == b->periods && !isnan(saltus_impact_speed(&a->events[e])) ? nearest_impact(a, e, b) : -1;
    return found >= 0 && nearest_impact(b, found, a) == e ? found : -1;
}

/* Whether the points k and k + 1 of a file follow each other on a branch of that hue with that stroke. */
static bool linked(const saltus_plot_page *page, int file, int k, int hue, saltus_stroke stroke) {
    const saltus_branch_file *f = &page->files[file];
    return k >= 0 && k + 1 < f->point_count && f->points[k].branch == f->points[k + 1].branch &&
           saltus_plot_hue(page, file, f->points[k].branch) == hue && stroke_between(f, k, k + 1) == stroke;
}

/* An impact from the point where it begins to have this stroke to where it ends. */
static void put_impact(const saltus_plot_page *page, int file, int k, int e, int hue, saltus_stroke stroke) {
    const saltus_branch_point *points = page->files[file].points;
    if (linked(page, file, k - 1, hue, stroke) && partner(&points[k], e, &points[k - 1]) >= 0)
        return;
    for (bool first = true; linked(page, file, k, hue, stroke); k++, first = false) {
        int next = partner(&points[k], e, &points[k + 1]);
        if (next < 0)
            return;
        if (first)
            fprintf(page->file, "\n%.12g %.9g\n", saltus_plot_x(&points[k]),
                    saltus_impact_speed(&points[k].events[e]));
        e = next;
        fprintf(page->file, "%.12g %.9g\n", saltus_plot_x(&points[k + 1]),
                saltus_impact_speed(&points[k + 1].events[e]));
    }
}

/* Each impact as a curve of its own. */
static void put_impacts(const saltus_plot_page *page, int hue, saltus_stroke stroke) {
    fprintf(page->file, "$curve_%d_%d << EOD\n# parameter, speed\n", hue, (int)stroke);
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++)
            for (int e = 0; linked(page, i, k, hue, stroke) && e < page->files[i].points[k].event_count; e++)
                put_impact(page, i, k, e, hue, stroke);
    fputs("\nEOD\n", page->file);
}

static void put_marks(const saltus_plot_page *page, saltus_point_kind kind) {
    fprintf(page->file, "$marks_%d << EOD\n# parameter, measure\n", (int)kind);
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *point = &page->files[i].points[k];
            if (saltus_plot_mark(point->kind) == kind && saltus_plot_marked(&page->files[i], point))
                fprintf(page->file, "%.12g %.9g\n", saltus_plot_x(point), saltus_plot_y(page, point));
        }
    fputs("EOD\n", page->file);
}

void saltus_plot_data(const saltus_plot_page *page) {
    for (int hue = 0; hue < SALTUS_HUES; hue++)
        for (int stroke = 0; stroke < SALTUS_STROKES; stroke++) {
            if (page->show == SALTUS_SHOW_IMPACTS && !page->locus)
                put_impacts(page, hue, (saltus_stroke)stroke);
            else
                put_curves(page, hue, (saltus_stroke)stroke);
        }
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_PLOT_MARKS; kind++)
        put_marks(page, (saltus_point_kind)kind);
}
