/* The numbers of a bifurcation diagram, as datablocks inside gnuplot's script.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include "orbit/lap.h"
#include "record/describe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_plot_shown(const saltus_plot_page *page, const saltus_branch_point *point) {
    saltus_range first = page->swap ? page->y : page->x;
    return point->value[0] >= first.low && point->value[0] <= first.high &&
           (!page->locus || (point->value[1] >= page->y.low && point->value[1] <= page->y.high));
}

saltus_range saltus_plot_range(const saltus_plot_page *page, bool measure) {
    const bool up = measure != page->swap;
    saltus_range found = {INFINITY, -INFINITY};
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *point = &page->files[i].points[k];
            const saltus_plot_visits *visits = page->visits ? &page->visits[i][k] : NULL;
            double own = up ? saltus_plot_y(page, point) : saltus_plot_x(page, point);
            /* At a grazing point the speed is a rounding error, which no logarithmic axis has to reach. */
            if (!saltus_plot_shown(page, point) ||
                (measure && page->logarithmic[up] && !page->locus && point->kind == SALTUS_POINT_GR))
                continue;
            for (int v = -1; v < (measure && visits ? visits->count : 0); v++) {
                double value = v < 0 ? own : visits->list[v].value;
                if (!page->logarithmic[up] || value > 0)
                    saltus_range_add(&found, value);
            }
        }
    return found;
}

bool saltus_plot_logarithmic(const saltus_figure_options *look, const char *key) {
    for (int k = 0; k < look->logarithmic_count; k++)
        if (strcmp(look->logarithmic[k], key) == 0)
            return true;
    return false;
}

const saltus_plot_part *saltus_plot_part_of(const saltus_plot_part *parts, int count, const char *key) {
    for (int k = 0; k < count; k++)
        if (strcmp(parts[k].key, key) == 0)
            return &parts[k];
    return NULL;
}

void saltus_plot_turn(saltus_branch_file *file) {
    saltus_branch_options *o = &file->options;
    char key[SALTUS_KEY_MAX];
    double low = o->low[0], high = o->high[0];
    memcpy(key, o->key[0], sizeof key);
    memcpy(o->key[0], o->key[1], sizeof key);
    memcpy(o->key[1], key, sizeof key);
    o->low[0] = o->low[1];
    o->high[0] = o->high[1];
    o->low[1] = low;
    o->high[1] = high;
    for (int k = 0; k < file->point_count; k++) {
        double *value = file->points[k].value, first = value[0];
        value[0] = value[1];
        value[1] = first;
    }
}

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

/* Speed of an impact; NAN for other events. */
static double impact_speed(const saltus_event *event) {
    return event->kind == SALTUS_IMPACT || event->kind == SALTUS_STICK ? fabs(event->velocity_before) : NAN;
}

/* The slowest and the fastest impact of an orbit; zeros without impacts. */
static saltus_range impact_speeds(const saltus_branch_point *point) {
    saltus_range found = {INFINITY, 0};
    for (int k = 0; k < point->event_count; k++)
        saltus_range_add(&found, impact_speed(&point->events[k]));
    return (saltus_range){isfinite(found.low) ? found.low : 0, found.high};
}

/* The speed of the grazing impact if it is known which one grazes, otherwise of the slowest impact. If it is
 * not among the events the orbit touches the stop without an impact: speed 0. */
static double grazing_speed(const saltus_plot_page *page, const saltus_branch_point *point) {
    const double same = 1e-4;
    if (isnan(point->grazing_time))
        return impact_speeds(point).low;
    for (int k = 0; k < point->event_count; k++) {
        saltus_face face = saltus_system_face(page->system, point->events[k].face);
        double speed = impact_speed(&point->events[k]),
               apart = remainder(saltus_time_periods(point->events[k].time) - point->grazing_time,
                                 fmax(1, point->periods));
        if (!isnan(speed) && fabs(apart) < same && face.stop + 1 == point->grazing_stop &&
            face.side == point->grazing_side)
            return speed;
    }
    return 0;
}

/* The value that the diagram shows for a point. */
static double measure(const saltus_plot_page *page, const saltus_branch_point *point) {
    if (page->turning) {
        /* For a grazing orbit the displacement at the touch; otherwise the largest displacement among its
         * visits. */
        double largest = NAN;
        for (int i = 0; i < page->count && page->visits; i++) {
            /* Pointers into different arrays have no difference. */
            const size_t size = sizeof *point,
                         k = ((uintptr_t)point - (uintptr_t)page->files[i].points) / size;
            if ((uintptr_t)point < (uintptr_t)page->files[i].points ||
                k >= (size_t)page->files[i].point_count)
                continue;
            for (int v = 0; v < page->visits[i][k].count; v++)
                largest = fmax(largest, page->visits[i][k].list[v].value);
        }
        for (int f = 0; f < saltus_system_face_count(page->system); f++) {
            saltus_face face = saltus_system_face(page->system, f);
            if (face.stop + 1 == point->grazing_stop && face.side == point->grazing_side &&
                saltus_system_stop_observed(page->system, face.stop))
                return face.side * point->spec.stops[face.stop].d;
        }
        return largest;
    }
    switch (page->show) {
    case SALTUS_SHOW_DISPLACEMENT:
        return saltus_system_observed(page->system, point->state);
    case SALTUS_SHOW_VELOCITY:
        return saltus_system_observed(page->system, point->state + saltus_system_dof(page->system));
    case SALTUS_SHOW_PERIOD:
        return point->trivial_multiplier != 0 || !point->periods ? point->period : point->periods;
    default:
        return page->show == SALTUS_SHOW_IMPACTS && point->kind == SALTUS_POINT_GR
                   ? grazing_speed(page, point)
                   : impact_speeds(point).high;
    }
}

double saltus_plot_x(const saltus_plot_page *page, const saltus_branch_point *point) {
    return page->swap ? measure(page, point) : point->value[0];
}

double saltus_plot_y(const saltus_plot_page *page, const saltus_branch_point *point) {
    return page->locus ? point->value[1] : page->swap ? point->value[0] : measure(page, point);
}

/* The displacements at the turning points of an orbit, free or at a stop, from one revolution of the flow; of
 * an equilibrium its displacement. Where the flow cannot start, as beyond a stop, no turning points are
 * found. */
static saltus_status find_turnings(const saltus_plot_page *page, const saltus_branch_point *point,
                                   saltus_plot_visits *visits, saltus_message *message) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_lap lap = {.keeps_events = true, .keeps_turnings = true};
    saltus_message unfollowed = {.text = ""};
    saltus_status status = saltus_system_new(&point->spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_flow_new((const saltus_system *const *)&system, 1, &options, &flow, message);
    bool sound = status == SALTUS_OK;
    /* For an orbit with its own period the system's period is that of the orbit. */
    const int periods = point->trivial_multiplier != 0 ? 1 : point->periods;
    if (sound && saltus_flow_start(flow, 0, (saltus_time){0, 0}, point->state, &unfollowed) == SALTUS_OK) {
        saltus_lap_begin(&lap, system, point->state);
        saltus_lap_run(&lap, flow, (saltus_time){periods, 0}, true, &unfollowed);
    }
    visits->list = sound ? calloc((size_t)lap.event_count + 2, sizeof *visits->list) : NULL;
    if (sound && !visits->list)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the turning points of a branch");
    /* The state of an equilibrium, or of an orbit with its own period at its highest maximum. Turning events
     * near that time are skipped: whether they are found depends on rounding. */
    const double apart = 1e-6;
    const bool own = point->trivial_multiplier != 0;
    if ((own || !point->periods) && visits->list)
        visits->list[visits->count++] =
            (saltus_plot_visit){.value = saltus_system_observed(system, point->state), .face = -1};
    for (int k = 0; k < lap.event_count && visits->list; k++) {
        const saltus_event *event = &lap.events[k];
        const double time = saltus_time_periods(event->time);
        if (own && (time < apart || time > periods - apart))
            continue;
        bool turns = event->kind == SALTUS_TURNING ||
                     (event->kind != SALTUS_RELEASE &&
                      saltus_system_stop_observed(system, saltus_system_face(system, event->face).stop));
        if (turns)
            visits->list[visits->count++] = (saltus_plot_visit){time, event->displacement, -1};
    }
    if (page->amplitude && point->periods && visits->count) {
        /* Include the state itself, which may be the largest or smallest value. */
        double own = saltus_system_observed(page->system, point->state);
        saltus_range found = {own, own};
        for (int k = 0; k < visits->count; k++)
            saltus_range_add(&found, visits->list[k].value);
        visits->list[0] = (saltus_plot_visit){.value = found.high, .face = -1};
        visits->list[1] = (saltus_plot_visit){.value = found.low, .face = -1};
        visits->count = 2;
    }
    saltus_lap_close(&lap);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return status;
}

saltus_status saltus_plot_find_visits(saltus_plot_page *page, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    if (page->locus || !(page->turning || page->show == SALTUS_SHOW_IMPACTS))
        return SALTUS_OK;
    page->visits = calloc((size_t)page->count, sizeof *page->visits);
    bool memory = page->visits != NULL;
    for (int i = 0; i < page->count && memory && status == SALTUS_OK; i++) {
        const saltus_branch_file *f = &page->files[i];
        saltus_plot_visits *visits = page->visits[i] = calloc((size_t)f->point_count + 1, sizeof *visits);
        memory = visits != NULL;
        for (int k = 0; k < f->point_count && memory && status == SALTUS_OK; k++) {
            const saltus_branch_point *point = &f->points[k];
            if (page->turning) {
                status = find_turnings(page, point, &visits[k], message);
                continue;
            }
            visits[k].list = calloc((size_t)point->event_count + 1, sizeof *visits[k].list);
            memory = visits[k].list != NULL;
            for (int e = 0; e < point->event_count && memory; e++) {
                const saltus_event *event = &point->events[e];
                double speed = impact_speed(event);
                if (!isnan(speed))
                    visits[k].list[visits[k].count++] =
                        (saltus_plot_visit){saltus_time_periods(event->time), speed, event->face};
            }
        }
    }
    return memory ? status : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the impacts of a branch");
}

void saltus_plot_free_visits(saltus_plot_page *page) {
    for (int i = 0; i < page->count && page->visits; i++) {
        for (int k = 0; k < page->files[i].point_count && page->visits[i]; k++)
            free(page->visits[i][k].list);
        free(page->visits[i]);
    }
    free(page->visits);
    page->visits = NULL;
}

static const saltus_branch_point *first_of(const saltus_branch_file *f, int branch) {
    for (int k = 0; k < f->point_count; k++)
        if (f->points[k].branch == branch)
            return &f->points[k];
    return NULL;
}

static const saltus_point_kind loci[SALTUS_HUES] = {SALTUS_POINT_LP, SALTUS_POINT_PD, SALTUS_POINT_NS,
                                                    SALTUS_POINT_BP, SALTUS_POINT_GR, SALTUS_POINT_HB,
                                                    SALTUS_POINT_BE};

saltus_point_kind saltus_plot_locus(int hue) {
    return loci[hue];
}

int saltus_plot_hue(const saltus_plot_page *page, int file, int branch) {
    const saltus_branch_point *first = first_of(&page->files[file], branch);
    const saltus_point_kind locus = first ? first->locus : page->files[file].options.locus;
    for (int hue = 0; hue < SALTUS_HUES && page->locus; hue++)
        if (loci[hue] == locus)
            return hue;
    if (page->locus)
        return 0;
    if (page->count > 1)
        return file % SALTUS_HUES;
    int depth = 0;
    for (; first && first->parent >= 0 && depth <= SALTUS_HUES; depth++)
        first = first_of(&page->files[file], first->parent);
    return depth % SALTUS_HUES;
}

/* Distance of a multiplier from the critical value of this kind. */
static double from_critical(const saltus_multiplier *m, saltus_point_kind kind) {
    if (kind == SALTUS_POINT_NS)
        return m->im != 0 ? fabs(m->log_modulus) : INFINITY;
    return hypot(m->re - (kind == SALTUS_POINT_PD ? -1 : 1), m->im);
}

/* Whether multipliers are outside the unit circle besides the critical ones. */
static bool others_outside(const saltus_branch_point *point, saltus_point_kind kind) {
    if (!point->periods) {
        /* Whether an equilibrium has eigenvalues with positive real part besides the critical ones. */
        const double still = 1e-6;
        const int critical = kind == SALTUS_POINT_HB ? 2 : kind == SALTUS_POINT_LP ? 1 : 0;
        int growing = 0, near = 0;
        for (int k = 0; k < point->multiplier_count; k++) {
            growing += point->multipliers[k].re > still;
            near += fabs(point->multipliers[k].re) <= still;
        }
        return growing > (near < critical ? critical - near : 0);
    }
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

/* Whether a point of a locus bounds stable orbits. On a grazing locus: whether the orbit is stable without
 * the grazing impact. With that impact the largest multiplier is unbounded and the others say nothing about
 * the orbit without it; then the nearest point with a moderate multiplier decides. */
static bool bounds_stable(const saltus_branch_file *f, int k) {
    const double huge = 50;
    const saltus_branch_point *points = f->points;
    if (points[k].locus != SALTUS_POINT_GR)
        return !others_outside(&points[k], points[k].locus);
    for (int reach = 0; reach < f->point_count; reach++)
        for (int side = -1; side <= 1; side += 2) {
            int j = k + side * reach;
            if (j < 0 || j >= f->point_count || points[j].branch != points[k].branch)
                continue;
            if (points[j].dimension == 0 || exp(points[j].multipliers[0].log_modulus) < huge)
                return points[j].dimension == 0 || points[j].multipliers[0].log_modulus < 0;
        }
    return true;
}

/* Whether the end of a branch deserves a mark: not at the limits of the range, nor on a locus that bounds
 * nothing stable. */
static bool ends_early(const saltus_branch_file *f, const saltus_branch_point *point) {
    const saltus_branch_options *o = &f->options;
    int row = (int)(point - f->points);
    for (int k = 0; k < 2; k++) {
        double near = 1e-9 * (o->high[k] - o->low[k]);
        if (o->key[k][0] &&
            (fabs(point->value[k] - o->low[k]) <= near || fabs(point->value[k] - o->high[k]) <= near))
            return false;
    }
    return o->locus == SALTUS_POINT_REGULAR ||
           (row > 0 && point[-1].branch == point->branch && bounds_stable(f, row - 1));
}

bool saltus_plot_marked(const saltus_branch_file *file, const saltus_branch_point *point) {
    /* A curve that ends at another special point, also one of another curve, has that point's mark instead.
     */
    if (point->kind == SALTUS_POINT_EP) {
        const saltus_branch_options *o = &file->options;
        for (int k = 0; k < file->point_count; k++) {
            const saltus_branch_point *other = &file->points[k];
            bool same = true;
            for (int axis = 0; axis < 2 && *o->key[axis]; axis++)
                same = same &&
                       fabs(other->value[axis] - point->value[axis]) < 1e-6 * (o->high[axis] - o->low[axis]);
            if (other->kind != SALTUS_POINT_REGULAR && other->kind != SALTUS_POINT_EP &&
                other->kind != point->locus &&
                (same || (other + 1 == point && other->kind >= SALTUS_POINT_CP)))
                return false;
        }
        return ends_early(file, point);
    }
    return point->kind != SALTUS_POINT_REGULAR && point->kind != point->locus;
}

/* Whether the stability of this point is that of its neighbours, so not a point where it changes. */
static bool tells(const saltus_branch_point *point) {
    return point->kind == SALTUS_POINT_REGULAR || point->kind == SALTUS_POINT_UZ ||
           point->kind == SALTUS_POINT_EP;
}

/* At a special point the stability of the neighbouring point decides. */
saltus_stroke saltus_plot_stroke(const saltus_branch_file *f, int from, int to) {
    const saltus_branch_point *a = &f->points[from], *b = &f->points[to];
    if (f->options.locus != SALTUS_POINT_REGULAR)
        return bounds_stable(f, from) && bounds_stable(f, to) ? SALTUS_STROKE_STABLE : SALTUS_STROKE_UNSTABLE;
    if (!a->admissible && !b->admissible)
        return SALTUS_STROKE_FOREIGN;
    const saltus_branch_point *side = tells(a) ? a : b;
    bool stable = tells(a) && tells(b) ? a->stable && b->stable : side->stable;
    return stable ? SALTUS_STROKE_STABLE : SALTUS_STROKE_UNSTABLE;
}

/* A point of a curve: values of the axes, place on the page, whether the piece to the next point has the
 * current stroke, and whether the curve may have a corner here. */
typedef struct curve_point {
    double value[2], place[2];
    bool drawn, corner;
} curve_point;

/* Whether a branch may have a corner at a point: where impacts, chatter or sticking appear or vanish. */
static bool corner(const saltus_branch_point *point) {
    return point->kind == SALTUS_POINT_GR || point->kind == SALTUS_POINT_CH ||
           point->kind == SALTUS_POINT_ST || point->kind == SALTUS_POINT_EP;
}

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

double saltus_plot_distance(const double at[2], const double a[2], const double b[2]) {
    double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    double part = square > 0 ? ((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / square : 0;
    part = fmin(fmax(part, 0), 1);
    return hypot(at[0] - a[0] - part * dx, at[1] - a[1] - part * dy);
}

void saltus_plot_place_visit(const saltus_plot_page *page, int file, int row, int v, double place[2]) {
    const saltus_branch_point *point = &page->files[file].points[row];
    if (!page->visits)
        saltus_plot_place(page, saltus_plot_x(page, point), saltus_plot_y(page, point), place);
    else if (page->swap)
        saltus_plot_place(page, page->visits[file][row].list[v].value, point->value[0], place);
    else
        saltus_plot_place(page, point->value[0], page->visits[file][row].list[v].value, place);
}

/* Whether a place of a curve lies on an earlier dashed curve of the same file: the dashes of both would fill
 * each other's gaps and look solid. */
static bool covered(const saltus_plot_page *page, int file, int branch, const double at[2]) {
    const double near = 2; /* units */
    const saltus_branch_file *f = &page->files[file];
    for (int k = 0; k + 1 < f->point_count; k++) {
        const saltus_branch_point *p = &f->points[k];
        double a[2], b[2];
        if (p[0].branch >= branch || p[0].branch != p[1].branch ||
            saltus_plot_stroke(f, k, k + 1) != SALTUS_STROKE_UNSTABLE)
            continue;
        saltus_plot_place(page, p[0].value[0], p[0].value[0], a);
        saltus_plot_place(page, p[1].value[0], p[1].value[0], b);
        const double begin = a[page->swap], end = b[page->swap], own = at[page->swap];
        if (own < fmin(begin, end) - near || own > fmax(begin, end) + near)
            continue;
        const int visits = page->visits ? page->visits[file][k].count : 1;
        for (int v = 0; v < visits; v++) {
            const int next = page->visits ? saltus_plot_partner(page, file, k, v) : 0;
            if (next < 0)
                continue;
            saltus_plot_place_visit(page, file, k, v, a);
            saltus_plot_place_visit(page, file, k + 1, next, b);
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
static bool put_uncovered(const saltus_plot_page *page, int file, int branch, const double from[2],
                          const double to[2]) {
    const double seen = 16; /* units */
    double ends[2][2], at[2], part[2] = {0, 1};
    saltus_plot_place(page, from[0], from[1], ends[0]);
    saltus_plot_place(page, to[0], to[1], ends[1]);
    const bool first = covered(page, file, branch, ends[0]), last = covered(page, file, branch, ends[1]);
    if (first == last) {
        between(ends[0], ends[1], 0.5, at);
        return !(first && covered(page, file, branch, at));
    }
    while (part[1] - part[0] > 1e-4) {
        const double middle = 0.5 * (part[0] + part[1]);
        between(ends[0], ends[1], middle, at);
        part[covered(page, file, branch, at) == last] = middle;
    }
    between(ends[0], ends[1], part[0], at);
    if (hypot(at[0] - ends[last][0], at[1] - ends[last][1]) < seen)
        return true;
    fprintf(page->paper->file, "\n%.12g %.9g\n", first ? to[0] : from[0], first ? to[1] : from[1]);
    put_place(page, at);
    return false;
}

/* A curve of one stroke, without those of its dashes that earlier branches of the file cover. */
static void put_curve(const saltus_plot_page *page, int file, int branch, saltus_stroke stroke,
                      curve_point *p, int count) {
    for (int k = 0; k + 1 < count && stroke == SALTUS_STROKE_UNSTABLE && !page->locus; k++)
        p[k].drawn = p[k].drawn && put_uncovered(page, file, branch, p[k].value, p[k + 1].value);
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

/* Which of a point's events is the largest impact; -1: there is none. */
static int strongest(const saltus_branch_point *point) {
    int found = -1;
    for (int k = 0; k < point->event_count; k++) {
        const double speed = impact_speed(&point->events[k]);
        if (!isnan(speed) && (found < 0 || speed > impact_speed(&point->events[found])))
            found = k;
    }
    return found;
}

/* Whether between two points another impact becomes the largest, so that the curve of the largest has a
 * corner. */
static bool overtaken(const saltus_branch_point *a, const saltus_branch_point *b) {
    const int one = strongest(a), other = strongest(b);
    return one >= 0 && other >= 0 && (one != other || a->events[one].face != b->events[other].face);
}

/* A branch of one stroke, with one value per point. */
static void put_branch(const saltus_plot_page *page, int file, int first, int last, saltus_stroke stroke,
                       curve_point *p) {
    const saltus_branch_file *f = &page->files[file];
    const int count = last - first + 1;
    for (int k = 0; k < count; k++) {
        const saltus_branch_point *point = &f->points[first + k];
        p[k].value[0] = saltus_plot_x(page, point);
        p[k].value[1] = saltus_plot_y(page, point);
        p[k].corner =
            corner(point) || isnan(p[k].value[1]) ||
            (page->show == SALTUS_SHOW_SPEED && !page->locus &&
             ((k > 0 && overtaken(point - 1, point)) || (k + 1 < count && overtaken(point, point + 1))));
        p[k].drawn = k + 1 < count && saltus_plot_stroke(f, first + k, first + k + 1) == stroke;
    }
    put_curve(page, file, f->points[first].branch, stroke, p, count);
}

/* The visit of point b on the same face that is nearest in time to a visit of point a; -1 if none is near, as
 * for an impact that appears or vanishes. */
static int nearest_visit(const saltus_plot_visit *from, const saltus_plot_visits *b, int periods) {
    const double near = 0.2; /* of a forcing period */
    double least = near;
    int nearest = -1;
    for (int k = 0; k < b->count; k++) {
        double apart = fabs(remainder(b->list[k].time - from->time, (double)periods));
        if (b->list[k].face != from->face || apart >= least)
            continue;
        least = apart;
        nearest = k;
    }
    return nearest;
}

/* Accept only mutually nearest visits. */
int saltus_plot_partner(const saltus_plot_page *page, int file, int k, int v) {
    const saltus_branch_point *points = page->files[file].points;
    const saltus_plot_visits *a = &page->visits[file][k], *b = &page->visits[file][k + 1];
    if (page->amplitude)
        return points[k].branch == points[k + 1].branch && v < b->count ? v : -1;
    const int periods = points[k].periods ? points[k].periods : 1;
    int found = points[k].periods == points[k + 1].periods && points[k].branch == points[k + 1].branch
                    ? nearest_visit(&a->list[v], b, periods)
                    : -1;
    return found >= 0 && nearest_visit(&b->list[found], a, periods) == v ? found : -1;
}

/* Each visit as a curve of its own, from where it appears to where it vanishes. */
static void put_visits(const saltus_plot_page *page, int file, int first, int last, saltus_stroke stroke,
                       curve_point *p) {
    const saltus_branch_file *f = &page->files[file];
    for (int k = first; k < last; k++)
        for (int v = 0; v < page->visits[file][k].count; v++) {
            /* A curve begins here if no visit of the previous point leads to it. */
            bool begins = true;
            for (int w = 0; k > first && begins && w < page->visits[file][k - 1].count; w++)
                begins = saltus_plot_partner(page, file, k - 1, w) != v;
            int count = 0;
            for (int at = k, visit = v; begins && visit >= 0 && at <= last; at++, count++) {
                p[count].value[page->swap] = f->points[at].value[0];
                p[count].value[!page->swap] = page->visits[file][at].list[visit].value;
                p[count].corner = corner(&f->points[at]);
                visit = at < last ? saltus_plot_partner(page, file, at, visit) : -1;
                p[count].drawn = visit >= 0 && saltus_plot_stroke(f, at, at + 1) == stroke;
            }
            put_curve(page, file, f->points[first].branch, stroke, p, count);
        }
}

static bool put_curves(const saltus_plot_page *page, int hue, saltus_stroke stroke) {
    bool sound = true;
    fprintf(page->paper->file, "$curve_%d_%d << EOD\n# parameter, measure\nNaN NaN\n", hue, (int)stroke);
    for (int i = 0; i < page->count; i++) {
        const saltus_branch_file *f = &page->files[i];
        for (int first = 0, last; first < f->point_count; first = last + 1) {
            for (last = first;
                 last + 1 < f->point_count && f->points[last + 1].branch == f->points[first].branch;)
                last++;
            if (saltus_plot_hue(page, i, f->points[first].branch) != hue)
                continue;
            curve_point *p = calloc((size_t)(last - first) + 1, sizeof *p);
            sound = sound && p;
            if (p)
                (page->visits ? put_visits : put_branch)(page, i, first, last, stroke, p);
            free(p);
        }
    }
    fputs("\nEOD\n", page->paper->file);
    return sound;
}

/* Signs along loci at equal distances on the page, so that kinds differ not only by hue. */
static void put_signs(const saltus_plot_page *page, int hue) {
    const double apart = 130; /* units */
    fprintf(page->paper->file, "$signs_%d << EOD\n# parameters\nNaN NaN\n", hue);
    for (int i = 0; i < page->count; i++) {
        const saltus_branch_file *f = &page->files[i];
        double passed = 0.5 * apart;
        for (int k = 1; k < f->point_count; k++) {
            double a[2], b[2];
            const saltus_branch_point *p = &f->points[k - 1], *q = &f->points[k];
            if (p->branch != q->branch || saltus_plot_hue(page, i, q->branch) != hue ||
                !saltus_plot_shown(page, q))
                continue;
            saltus_plot_place(page, p->value[0], p->value[1], a);
            saltus_plot_place(page, q->value[0], q->value[1], b);
            passed += hypot(b[0] - a[0], b[1] - a[1]);
            if (passed < apart || saltus_plot_marked(f, q))
                continue;
            fprintf(page->paper->file, "%.12g %.9g\n", q->value[0], q->value[1]);
            passed = 0;
        }
    }
    fputs("EOD\n", page->paper->file);
}

bool saltus_plot_data(const saltus_plot_page *page) {
    bool sound = true;
    for (int hue = 0; hue < SALTUS_HUES; hue++) {
        for (int stroke = 0; stroke < SALTUS_STROKES; stroke++)
            sound = put_curves(page, hue, (saltus_stroke)stroke) && sound;
        if (page->locus)
            put_signs(page, hue);
    }
    for (int kind = SALTUS_POINT_LP; kind < SALTUS_POINT_KINDS; kind++) {
        fprintf(page->paper->file, "$marks_%d << EOD\n# parameter, measure\n", kind);
        for (int i = 0; i < page->count; i++)
            for (int k = 0; k < page->files[i].point_count; k++) {
                const saltus_branch_point *point = &page->files[i].points[k];
                if ((int)point->kind == kind && saltus_plot_marked(&page->files[i], point))
                    fprintf(page->paper->file, "%.12g %.9g\n", saltus_plot_x(page, point),
                            saltus_plot_y(page, point));
            }
        fputs("EOD\n", page->paper->file);
    }
    return sound;
}
