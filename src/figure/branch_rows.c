/* The points of branch files as a diagram shows them: values, strokes, hues and marks, found once for curves,
 * names, ranges and legends alike; and the values in which the files differ.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include "orbit/lap.h"
#include "record/describe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_plot_shown(const saltus_plot_page *page, const saltus_plot_row *row) {
    const saltus_range first = page->swap ? page->y : page->x;
    const double *value = row->point->value;
    return value[0] >= first.low && value[0] <= first.high &&
           (!page->locus || (value[1] >= page->y.low && value[1] <= page->y.high));
}

bool saltus_plot_measured(const saltus_plot_page *page, const saltus_plot_row *row) {
    return saltus_plot_shown(page, row) &&
           (!page->logarithmic[!page->swap] || page->locus || row->point->kind != SALTUS_POINT_GR);
}

saltus_range saltus_plot_range(const saltus_plot_page *page, bool measure) {
    const bool up = measure != page->swap;
    saltus_range found = {INFINITY, -INFINITY};
    for (int k = 0; k < page->row_count; k++) {
        const saltus_plot_row *row = &page->rows[k];
        if (!(measure ? saltus_plot_measured(page, row) : saltus_plot_shown(page, row)))
            continue;
        for (int v = -1; v < (measure ? row->count : 0); v++) {
            const double value = v >= 0 ? row->visits[v].value : up ? row->y : row->x;
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

/* Speed of an impact; NAN for other events. */
static double impact_speed(const saltus_event *event) {
    return event->kind == SALTUS_IMPACT || event->kind == SALTUS_STICK ? fabs(event->velocity_before) : NAN;
}

static int strongest(const saltus_branch_point *point) {
    int found = -1;
    for (int k = 0; k < point->event_count; k++) {
        const double speed = impact_speed(&point->events[k]);
        if (!isnan(speed) && (found < 0 || speed > impact_speed(&point->events[found])))
            found = k;
    }
    return found;
}

/* The speed at which the mark of a grazing orbit stands among the speeds of all impacts: of the grazing
 * impact if it is known which one grazes, otherwise of the slowest. If it is not among the events the orbit
 * touches the stop without an impact: speed 0. */
static double grazing_speed(const saltus_plot_page *page, const saltus_branch_point *point) {
    const double same = 1e-4;
    double slowest = INFINITY;
    for (int k = 0; k < point->event_count; k++) {
        const saltus_face face = saltus_system_face(page->system, point->events[k].face);
        const double speed = impact_speed(&point->events[k]),
                     apart = remainder(saltus_time_periods(point->events[k].time) - point->grazing_time,
                                       fmax(1, point->periods));
        if (!isnan(speed) && fabs(apart) < same && face.stop + 1 == point->grazing_stop &&
            face.side == point->grazing_side)
            return speed;
        slowest = fmin(slowest, speed);
    }
    return isnan(point->grazing_time) && isfinite(slowest) ? slowest : 0;
}

/* The value at which a row's mark stands. */
static double measure(const saltus_plot_page *page, const saltus_plot_row *row) {
    const saltus_branch_point *point = row->point;
    if (page->turning) {
        double largest = NAN;
        /* For a grazing orbit the displacement at the touch; otherwise the largest displacement among its
         * visits. */
        for (int f = 0; f < saltus_system_face_count(page->system); f++) {
            saltus_face face = saltus_system_face(page->system, f);
            if (face.stop + 1 == point->grazing_stop && face.side == point->grazing_side &&
                saltus_system_stop_observed(page->system, face.stop))
                return face.side * point->spec.stops[face.stop].d;
        }
        for (int v = 0; v < row->count; v++)
            largest = fmax(largest, row->visits[v].value);
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
        if (page->show == SALTUS_SHOW_IMPACTS && point->kind == SALTUS_POINT_GR)
            return grazing_speed(page, point);
        return row->strongest < 0 ? 0 : impact_speed(&point->events[row->strongest]);
    }
}

/* The displacements at the turning points of an orbit, free or at a stop, from one revolution of the flow; of
 * an equilibrium its displacement. Where the flow cannot start, as beyond a stop, no turning points are
 * found. */
static saltus_status find_turnings(const saltus_plot_page *page, saltus_plot_row *row,
                                   saltus_message *message) {
    const saltus_branch_point *point = row->point;
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
    saltus_plot_visit *visits = row->visits =
        sound ? calloc((size_t)lap.event_count + 2, sizeof *visits) : NULL;
    if (sound && !visits)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the turning points of a branch");
    /* The state of an equilibrium, or of an orbit with its own period at its highest maximum. Turning events
     * near that time are skipped: whether they are found depends on rounding. */
    const double apart = 1e-6;
    const bool own = point->trivial_multiplier != 0;
    if ((own || !point->periods) && visits)
        visits[row->count++] =
            (saltus_plot_visit){.value = saltus_system_observed(system, point->state), .face = -1};
    for (int k = 0; k < lap.event_count && visits; k++) {
        const saltus_event *event = &lap.events[k];
        const double time = saltus_time_periods(event->time);
        if (own && (time < apart || time > periods - apart))
            continue;
        bool turns = event->kind == SALTUS_TURNING ||
                     (event->kind != SALTUS_RELEASE &&
                      saltus_system_stop_observed(system, saltus_system_face(system, event->face).stop));
        if (turns)
            visits[row->count++] =
                (saltus_plot_visit){.time = time, .value = event->displacement, .face = -1};
    }
    if (page->show == SALTUS_SHOW_AMPLITUDE && point->periods && row->count) {
        /* Include the state itself, which may be the largest or smallest value. */
        double own = saltus_system_observed(page->system, point->state);
        saltus_range found = {own, own};
        for (int k = 0; k < row->count; k++)
            saltus_range_add(&found, visits[k].value);
        visits[0] = (saltus_plot_visit){.value = found.high, .face = -1};
        visits[1] = (saltus_plot_visit){.value = found.low, .face = -1};
        row->count = 2;
    }
    saltus_lap_close(&lap);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return status;
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

static int hue_of(const saltus_plot_page *page, int file, int branch) {
    const saltus_branch_point *first = first_of(&page->files[file], branch);
    for (int hue = 0; hue < SALTUS_HUES && page->locus; hue++)
        if (loci[hue] == first->locus)
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
    for (int k = 1; k < point->multiplier_count; k++)
        if (from_critical(&point->multipliers[k], kind) < from_critical(&point->multipliers[critical], kind))
            critical = k;
    for (int k = 0; k < point->multiplier_count; k++)
        if (k != critical && !(kind == SALTUS_POINT_NS && k == critical + 1))
            outside += isnan(point->multipliers[k].re) || point->multipliers[k].log_modulus >= inside;
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

/* Whether a point gets a mark. The end of a branch deserves one neither at the limits of the range nor on a
 * locus that bounds nothing stable; where a curve ends at another special point, also one of another curve,
 * that has the mark instead. */
static bool is_marked(const saltus_branch_file *f, int row) {
    const saltus_branch_options *o = &f->options;
    const saltus_branch_point *point = &f->points[row];
    if (point->kind != SALTUS_POINT_EP)
        return point->kind != SALTUS_POINT_REGULAR && point->kind != point->locus;
    for (int k = 0; k < f->point_count; k++) {
        const saltus_branch_point *other = &f->points[k];
        bool same = true;
        for (int axis = 0; axis < 2 && *o->key[axis]; axis++)
            same =
                same && fabs(other->value[axis] - point->value[axis]) < 1e-6 * (o->high[axis] - o->low[axis]);
        if (other->kind != SALTUS_POINT_REGULAR && other->kind != SALTUS_POINT_EP &&
            other->kind != point->locus && (same || (k + 1 == row && other->kind >= SALTUS_POINT_CP)))
            return false;
    }
    for (int k = 0; k < 2; k++) {
        double near = 1e-9 * (o->high[k] - o->low[k]);
        if (o->key[k][0] &&
            (fabs(point->value[k] - o->low[k]) <= near || fabs(point->value[k] - o->high[k]) <= near))
            return false;
    }
    return o->locus == SALTUS_POINT_REGULAR ||
           (row > 0 && point[-1].branch == point->branch && bounds_stable(f, row - 1));
}

/* Whether the stability of this point is that of its neighbours, so not a point where it changes. */
static bool tells(const saltus_branch_point *point) {
    return point->kind == SALTUS_POINT_REGULAR || point->kind == SALTUS_POINT_UZ ||
           point->kind == SALTUS_POINT_EP;
}

/* The stroke from a point to the next. At a special point the stability of the neighbouring point decides. */
static saltus_stroke stroke_from(const saltus_branch_file *f, int k) {
    const saltus_branch_point *a = &f->points[k], *b = a + 1;
    if (f->options.locus != SALTUS_POINT_REGULAR)
        return bounds_stable(f, k) && bounds_stable(f, k + 1) ? SALTUS_STROKE_STABLE : SALTUS_STROKE_UNSTABLE;
    if (!a->admissible && !b->admissible)
        return SALTUS_STROKE_FOREIGN;
    bool stable = tells(a) && tells(b) ? a->stable && b->stable : tells(a) ? a->stable : b->stable;
    return stable ? SALTUS_STROKE_STABLE : SALTUS_STROKE_UNSTABLE;
}

/* The visit of a row on the same face that is nearest in time to another; -1 if none is near, as for an
 * impact that appears or vanishes. */
static int nearest_visit(const saltus_plot_visit *from, const saltus_plot_row *row, int periods) {
    double least = 0.2; /* of a forcing period */
    int nearest = -1;
    for (int k = 0; k < row->count; k++) {
        double apart = fabs(remainder(row->visits[k].time - from->time, (double)periods));
        if (row->visits[k].face != from->face || apart >= least)
            continue;
        least = apart;
        nearest = k;
    }
    return nearest;
}

/* Find how the visits of a row go on in the next one; of several only mutually nearest ones do. */
static void join_visits(const saltus_plot_page *page, saltus_plot_row *row) {
    saltus_plot_row *after = row + 1;
    const bool several = !page->locus && page->show != SALTUS_SHOW_AMPLITUDE &&
                         (page->turning || page->show == SALTUS_SHOW_IMPACTS);
    const int periods = row->point->periods ? row->point->periods : 1;
    for (int v = 0; v < row->count; v++) {
        int next = v < after->count ? v : -1;
        if (several) {
            next = row->point->periods == after->point->periods
                       ? nearest_visit(&row->visits[v], after, periods)
                       : -1;
            if (next >= 0 && nearest_visit(&after->visits[next], row, periods) != v)
                next = -1;
        }
        row->visits[v].next = next;
        if (next >= 0)
            after->visits[next].begins = false;
    }
}

/* Find the visits of a row and its mark. */
static saltus_status find_visits(const saltus_plot_page *page, saltus_plot_row *row,
                                 saltus_message *message) {
    const saltus_branch_point *point = row->point;
    const bool impacts = !page->locus && !page->turning && page->show == SALTUS_SHOW_IMPACTS;
    if (page->turning) {
        saltus_status status = find_turnings(page, row, message);
        if (status != SALTUS_OK)
            return status;
    } else
        row->visits = calloc((size_t)(impacts ? point->event_count : 0) + 1, sizeof *row->visits);
    if (!row->visits)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the impacts of a branch");
    for (int e = 0; e < point->event_count && impacts; e++) {
        const double speed = impact_speed(&point->events[e]);
        if (!isnan(speed))
            row->visits[row->count++] =
                (saltus_plot_visit){.time = saltus_time_periods(point->events[e].time),
                                    .value = speed,
                                    .face = point->events[e].face};
    }
    const double value = page->locus ? point->value[1] : measure(page, row);
    row->x = page->swap ? value : point->value[0];
    row->y = page->swap ? point->value[0] : value;
    if (!impacts && !page->turning)
        row->visits[row->count++] = (saltus_plot_visit){.value = value, .face = -1};
    for (int v = 0; v < row->count; v++) {
        row->visits[v].next = -1;
        row->visits[v].begins = true;
    }
    return SALTUS_OK;
}

saltus_status saltus_plot_open(saltus_plot_page *page, saltus_message *message) {
    size_t most = 1;
    for (int i = 0; i < page->count; i++)
        most += (size_t)page->files[i].point_count;
    page->rows = calloc(most, sizeof *page->rows);
    if (!page->rows)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the curves of %d files", page->count);
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_file *f = &page->files[i];
            const saltus_branch_point *point = &f->points[k];
            saltus_plot_row *row = &page->rows[page->row_count++];
            *row = (saltus_plot_row){
                .point = point, .file = i, .marked = is_marked(f, k), .strongest = strongest(point)};
            row->joined = k + 1 < f->point_count && point[1].branch == point->branch;
            if (row->joined)
                row->stroke = stroke_from(f, k);
            const bool first = k == 0 || !row[-1].joined;
            row->hue = first ? hue_of(page, i, point->branch) : row[-1].hue;
            saltus_status status = find_visits(page, row, message);
            if (status != SALTUS_OK)
                return status;
            if (!first)
                join_visits(page, row - 1);
        }
    return SALTUS_OK;
}

void saltus_plot_close(saltus_plot_page *page) {
    for (int k = 0; k < page->row_count; k++)
        free(page->rows[k].visits);
    free(page->rows);
    page->rows = NULL;
    page->row_count = 0;
}

bool saltus_plot_value_of(const saltus_spec *spec, int k, const char *const axes[2], saltus_plot_value *v) {
    int count, keys;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    const saltus_parameter *s = saltus_stop_parameters(&keys);
    const int last = count + keys * spec->stop_count; /* of the values; the sides of stops follow */
    const int own = k < count ? k : (k - count) % keys, stop = k < count  ? -1
                                                               : k < last ? (k - count) / keys
                                                                          : k - last;
    const char *name = k < count ? p[own].name : k < last ? s[own].name : "sides";
    if (stop >= spec->stop_count)
        return false;
    snprintf(v->key, sizeof v->key, stop < 0 || spec->stop_count == 1 ? "%s" : "%s%d", name, stop + 1);
    v->sides = k >= last;
    v->stop = stop;
    const saltus_stop *of = &spec->stops[stop < 0 ? 0 : stop];
    v->value = stop < 0   ? spec->parameters[own]
               : v->sides ? (double)of->sides
                          : (const double[]){of->xi, of->d, of->r}[own];
    v->on_axis = false;
    for (int a = 0; a < 2 && !v->sides; a++)
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

/* Whether another file has the same scene and values. */
static bool has_twin(const saltus_plot_page *page, int file) {
    bool twin = false, differs;
    for (int i = 0; i < page->count && !twin; i++) {
        saltus_plot_value a, b;
        twin = i != file && strcmp(page->files[i].scene, page->files[file].scene) == 0;
        for (int k = 0; twin && value_in(page, file, k, &a, &differs) && value_in(page, i, k, &b, &differs);
             k++)
            twin = a.on_axis || a.value == b.value;
    }
    return twin;
}

void saltus_plot_add_differences(const saltus_plot_page *page, int file, saltus_line *line) {
    saltus_plot_value v;
    bool differs;
    for (int k = 0; value_in(page, file, k, &v, &differs); k++) {
        if (!differs)
            continue;
        saltus_line_add(line, ", ");
        if (v.sides && page->files[file].spec.stop_count > 1)
            saltus_line_add(line, "stop %d: ", v.stop + 1);
        if (v.sides)
            saltus_line_add(line, "%s",
                            v.value == SALTUS_BOTH ? "both sides"
                                                   : saltus_side_word(v.value == SALTUS_UPPER ? 1 : -1));
        else
            saltus_line_value(line, v.key, v.value);
    }
    if (!page->locus && has_twin(page, file))
        saltus_line_add(line, ", file %d", file + 1);
}
