/* Diagrams of sweeps over one axis: clouds of points, or one number per trajectory. Exponents have standard
 * errors, with one background colour above zero and another below.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"
#include "record/describe.h"
#include "record/fields.h"

#include <gsl/gsl_sort_float.h>
#include <math.h>
#include <stdlib.h>

static const char *name_of(const saltus_sweep_page *page, int pass) {
    static const char *const names[SALTUS_PASSES] = {[SALTUS_PASS_RESET] = "from the initial state",
                                                     [SALTUS_PASS_UP] = "upwards",
                                                     [SALTUS_PASS_DOWN] = "downwards"};
    return names[page->sweep->passes[pass]];
}

static uint32_t colour_of(const saltus_sweep_page *page, int pass) {
    static const uint32_t colours[SALTUS_PASSES] = {
        [SALTUS_PASS_RESET] = 0x3a3f47, [SALTUS_PASS_UP] = 0x1a5fa6, [SALTUS_PASS_DOWN] = 0xe0661c};
    return page->sweep->pass_count > 1 ? colours[page->sweep->passes[pass]]
           : page->over.count          ? 0x8a93a0
                                       : 0x14273d;
}

/* The k-th pass in the order of drawing, with up drawn over down. */
static int pass_drawn(const saltus_sweep_page *page, int k) {
    static const saltus_pass order[] = {SALTUS_PASS_DOWN, SALTUS_PASS_RESET, SALTUS_PASS_UP};
    for (int o = 0; o < SALTUS_PASSES; o++)
        for (int pass = 0; pass < page->sweep->pass_count; pass++)
            if (page->sweep->passes[pass] == order[o] && k-- == 0)
                return pass;
    return 0;
}

static double cloud_value(const saltus_sweep_page *page, long long row, long long k) {
    const saltus_sweep_file *sweep = page->sweep;
    const int n = saltus_system_dof(page->system), seeds = sweep->options.seeds;
    const double *state, *observer = page->observers;
    double number, sum = 0;
    int most = -1;
    switch (page->view) {
    case SALTUS_VIEW_TURNING:
        return sweep->turning[sweep->turning_first[row] + k];
    case SALTUS_VIEW_IMPACTS:
        number = sweep->impacts[sweep->impact_first[row] + k].speed;
        return page->sides ? number : fabs(number);
    case SALTUS_VIEW_STROBOSCOPIC:
        state = sweep->strobes + (sweep->strobe_first[row] + k) * sweep->dimension;
        observer += page->observer_count > 1 ? row / seeds % sweep->points * n : 0;
        for (int i = 0; i < n; i++)
            sum = fma(observer[i], state[i], sum);
        return sum;
    case SALTUS_VIEW_ATTRACTORS:
        /* Number of distinct attractors met at this grid point, shown only for the first seed. */
        for (int s = 0; s < seeds && row % seeds == 0; s++)
            most = sweep->rows[row + s].attractor > most ? sweep->rows[row + s].attractor : most;
        return most < 0 ? NAN : most + 1;
    default:
        number = saltus_sweep_measure(page->view, &sweep->rows[row]);
        return isinf(number) ? NAN : number; /* an exponent of -infinity has no place in a diagram */
    }
}

/* The value of the axis at the sorted cell k. */
static double axis_value(const saltus_sweep_page *page, int k) {
    return page->sweep->axes[0].list[page->x.order[k]];
}

/* The first row of a pass at the sorted cell k. */
static long long row_of(const saltus_sweep_page *page, int pass, int k) {
    return saltus_sweep_visit(page->sweep, page->x.order[k], pass * page->sweep->options.seeds);
}

/* A walk over the points of a pass in the cells from one to before another. */
typedef struct walk {
    int pass, cell, end;
    int seed;
    long long k, count; /* the next point of the row, and how many it has */
    double value;       /* of the point */
} walk;

static walk walk_of(const saltus_sweep_page *page, int pass) {
    return (walk){.pass = pass, .cell = page->x.first, .end = page->x.end};
}

/* Go to the next point; false if there is none. */
static bool next_point(const saltus_sweep_page *page, walk *w) {
    const int cloud = (int)(page->view - SALTUS_VIEW_TURNING);
    for (; w->cell < w->end; w->cell++, w->seed = 0)
        for (; w->seed < page->sweep->options.seeds; w->seed++, w->k = 0) {
            const long long row = row_of(page, w->pass, w->cell) + w->seed;
            w->count =
                saltus_view_is_cloud(page->view) ? saltus_sweep_entries_of(page->sweep, cloud).count[row] : 1;
            if (w->k == w->count)
                continue;
            w->value = cloud_value(page, row, w->k++);
            return true;
        }
    return false;
}

/* Position of a face at a value of the axis: its clearance with the face's sign. */
static double clearance(const saltus_sweep_page *page, saltus_face face, double value) {
    return face.side * (saltus_key_means(page->x.key, "d", face.stop) ? value : face.d);
}

static bool shows_displacement(const saltus_sweep_page *page) {
    return page->view == SALTUS_VIEW_TURNING || page->view == SALTUS_VIEW_STROBOSCOPIC ||
           page->view == SALTUS_VIEW_LARGEST;
}

/* Whether the figure shows displacements that the face limits. */
static bool limits(const saltus_sweep_page *page, saltus_face face) {
    return shows_displacement(page) && saltus_system_stop_observed(page->system, face.stop);
}

static saltus_status find_range(saltus_sweep_page *page, saltus_message *message) {
    saltus_range found = {INFINITY, -INFINITY}, speeds = {0, 0};
    /* Speeds have signs where both occur. */
    const saltus_sweep_file *sweep = page->sweep;
    const bool signs = page->view == SALTUS_VIEW_IMPACTS && !page->over.count;
    for (long long row = 0; row < sweep->row_count && signs; row++)
        for (long long k = 0; k < sweep->impact_count[row]; k++)
            saltus_range_add(&speeds, sweep->impacts[sweep->impact_first[row] + k].speed);
    page->sides = speeds.low < 0 && speeds.high > 0;
    for (int pass = 0; pass < page->sweep->pass_count; pass++)
        for (walk w = walk_of(page, pass); next_point(page, &w); page->shown++)
            if (!page->logarithmic || w.value > 0)
                saltus_range_add(&found, w.value);
            else
                page->below++;
    if (page->over.count) { /* also include the branches drawn over the cloud */
        const saltus_range curves = saltus_plot_range(&page->over, true);
        saltus_range_add(&found, curves.low);
        saltus_range_add(&found, curves.high);
    }
    if (!(found.low <= found.high) && page->view == SALTUS_VIEW_LYAPUNOV && saltus_sweep_any_lost(page))
        found = (saltus_range){-1, 0};
    if (!(found.low <= found.high))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: there is nothing to show in view %s from %s = %.6g to %.6g", page->path,
                           saltus_view_word(page->view), page->x.key, page->x.range.low, page->x.range.high);
    if (page->logarithmic && !((page->asked ? page->up.low : found.low) > 0))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: logarithmic axis %s: its values must be positive", page->path,
                           saltus_view_word(page->view));
    if (page->asked)
        return SALTUS_OK;
    page->up = found;
    if (page->logarithmic) {
        saltus_range_floor(&page->up);
        page->up = (saltus_range){page->up.low / 1.3, page->up.high * 1.3};
    } else {
        /* Extend a range by margins, to faces near the points, and to zero if that is near. */
        double width = page->up.high - page->up.low;
        bool from_zero = page->view != SALTUS_VIEW_LYAPUNOV && !shows_displacement(page) && page->up.low >= 0;
        for (int f = 0; f < saltus_system_face_count(page->system); f++) {
            saltus_face face = saltus_system_face(page->system, f);
            double d = clearance(page, face, page->x.range.high);
            if (limits(page, face) && d > page->up.low - 0.1 * width && d < page->up.high + 0.1 * width)
                saltus_range_add(&page->up, d);
        }
        if (page->view == SALTUS_VIEW_LYAPUNOV || (from_zero && page->up.low < 0.4 * page->up.high))
            saltus_range_add(&page->up, 0);
        saltus_range_pad(&page->up, 0.05, fmax(1e-3 * fabs(page->up.high), 1e-9));
        if (from_zero && page->up.low < 0)
            page->up.low = -0.015 * page->up.high;
    }
    return SALTUS_OK;
}

/* The points as numbers in the script. */
static void put_points(const saltus_sweep_page *page) {
    for (int pass = 0; pass < page->sweep->pass_count; pass++) {
        fprintf(page->paper.file, "$cloud_%d << EOD\n# parameter, measure\nNaN NaN\n", pass);
        for (walk w = walk_of(page, pass); next_point(page, &w);)
            if (w.value >= page->up.low && w.value <= page->up.high)
                fprintf(page->paper.file, "%.9g %.7g\n", axis_value(page, w.cell), w.value);
        fputs("EOD\n", page->paper.file);
    }
}

/* Whether a motion resembles the mirror image of another more than the motion itself: two attractors that are
 * mirror images of each other, met by turns, are not one that changes. Of motions without a period, whose
 * extremes scatter, both must lean clearly to their sides. */
static bool mirrored(const saltus_sweep_row *a, const saltus_sweep_row *b) {
    const double clearly = 0.2, itself = fabs(a->largest - b->largest) + fabs(a->smallest - b->smallest),
                 image = fabs(a->largest + b->smallest) + fabs(a->smallest + b->largest);
    return image < 0.5 * itself &&
           (a->verdict == SALTUS_PERIODIC || itself > clearly * (a->largest - a->smallest));
}

/* One number per trajectory, joined to the neighbour if both are of one class and, where displacements are
 * shown, of one side. */
static void put_links(const saltus_sweep_page *page) {
    for (int pass = 0; pass < page->sweep->pass_count; pass++) {
        const saltus_sweep_row *rows = page->sweep->rows;
        long long before = -1; /* the row of the neighbour; -1: it has no number */
        fprintf(page->paper.file, "$links_%d << EOD\n# parameter, measure\nNaN NaN\n", pass);
        for (int cell = 0; cell < page->x.count; cell++) {
            long long row = row_of(page, pass, cell);
            double y = cloud_value(page, row, 0);
            if (isnan(y) || before < 0 || page->classes.of_row[row] != page->classes.of_row[before] ||
                (page->view == SALTUS_VIEW_LARGEST && mirrored(&rows[row], &rows[before])))
                fputc('\n', page->paper.file);
            before = isnan(y) ? -1 : row;
            if (!isnan(y))
                fprintf(page->paper.file, "%.9g %.7g\n", axis_value(page, cell), y);
        }
        fputs("EOD\n", page->paper.file);
    }
}

/* Whether there is one point for each value of the axis and few enough to be joined. */
static bool linked(const saltus_sweep_page *page, bool dense) {
    return !dense && !saltus_view_is_cloud(page->view) && page->sweep->options.seeds == 1;
}

/* A cloud as a density: points counted per pixel. Every trajectory has weight 1, divided among its points:
 * periodic ones with few points are dark, others form a veil, and the length of the recording does not
 * matter. */
typedef struct tally {
    int width, height;
    float *cover;  /* how much of the pixel points cover */
    float *weight; /* total weight of the points in the pixel, spread like their cover */
} tally;

/* The fraction of pixel k between two positions. */
static double overlap(int k, double low, double high) {
    return fmax(0, fmin(high, k + 1) - fmax(low, k));
}

/* Add a point that extends from `left` to `right` and is `thick` pixels high around `y`; edges may be
 * fractions of pixels. */
static void add_point(tally *t, double left, double right, double y, double thick, double part) {
    double low = y - 0.5 * thick, high = y + 0.5 * thick;
    if (!(right > 0 && left < t->width && high > 0 && low < t->height))
        return;
    int x0 = left > 0 ? (int)left : 0, y0 = low > 0 ? (int)low : 0;
    for (int j = y0; j < t->height && j < high; j++)
        for (int i = x0; i < t->width && i < right; i++) {
            size_t place = (size_t)j * (size_t)t->width + (size_t)i;
            double covered = overlap(i, left, right) * overlap(j, low, high);
            t->cover[place] += (float)covered;
            t->weight[place] += (float)(part * covered);
        }
}

static double density_at(const tally *t, size_t k) {
    return t->weight[k] / fmin(t->cover[k], 1);
}

/* Paint a density. Opacity grows with its logarithm, so that single points of a long trajectory stay visible
 * and frequently visited places are dark. */
static void paint_tally(const tally *t, uint32_t colour, saltus_raster *raster) {
    enum { sample = 20000 };
    const double least_ratio = 40, rare = 0.02, common = 0.97;
    const double faintest = 0.16, levels = 24; /* few levels keep compressed files small */
    size_t size = (size_t)t->width * (size_t)t->height, filled = 0, count = 0, seen = 0;
    float *densities = malloc(sample * sizeof *densities);
    double low = 0, high = 0; /* logarithms of density between which opacity grows */
    for (size_t k = 0; k < size; k++)
        filled += t->cover[k] > 0;
    for (size_t k = 0; k < size && densities && count < sample; k++)
        if (t->cover[k] > 0 && seen++ % (1 + filled / sample) == 0)
            densities[count++] = (float)density_at(t, k);
    if (count) {
        gsl_sort_float(densities, 1, count);
        low = log(densities[(size_t)(rare * (double)(count - 1))]);
        high = log(densities[(size_t)(common * (double)(count - 1))]);
    }
    low = fmin(low, high - log(least_ratio));
    free(densities);
    for (size_t k = 0; k < size; k++) {
        if (t->cover[k] <= 0)
            continue;
        double tone = fmin(fmax((log(density_at(t, k)) - low) / (high - low), 0), 1);
        double opacity = fmin(t->cover[k], 1) * (faintest + (1 - faintest) * tone);
        saltus_raster_set(raster, (int)(k % (size_t)t->width), (int)(k / (size_t)t->width), colour,
                          round(opacity * levels) / levels);
    }
}

/* The cloud of a pass as a density. Points fill the width of their cells, or are dots if cells are wider than
 * a few pixels. */
static bool paint_pass(const saltus_sweep_page *page, int pass, int fineness, saltus_raster *raster) {
    const double widest = 4, dot = 2.4, flat = 1.6;
    const size_t size = (size_t)raster->width * (size_t)raster->height;
    tally t = {raster->width, raster->height, calloc(size, sizeof(float)), calloc(size, sizeof(float))};
    const bool sound = t.cover && t.weight;
    const double along = page->swap ? raster->height : raster->width,
                 across = page->swap ? raster->width : raster->height;
    for (int cell = page->x.first; cell < page->x.end && sound; cell++) {
        double middle = along * saltus_cells_part(&page->x, axis_value(page, cell));
        double own = along * (saltus_cells_edge(&page->x, cell + 1) - saltus_cells_edge(&page->x, cell));
        bool apart = own > widest * fineness;
        const double wide = apart ? dot * fineness : fmax(own, fineness),
                     thick = (apart ? dot : flat) * fineness;
        for (walk w = {.pass = pass, .cell = cell, .end = cell + 1}; next_point(page, &w);) {
            const double value = page->logarithmic ? fmax(w.value, 1e-300) : w.value,
                         place = across * saltus_range_part(page->up, page->logarithmic, value),
                         share = 1 / (double)w.count;
            if (page->swap)
                add_point(&t, place - 0.5 * thick, place + 0.5 * thick, middle, wide, share);
            else
                add_point(&t, middle - 0.5 * wide, middle + 0.5 * wide, place, thick, share);
        }
    }
    if (sound)
        paint_tally(&t, colour_of(page, pass), raster);
    free(t.cover);
    free(t.weight);
    return sound;
}

/* The clouds of all passes, at a lower resolution if the file would become too large. */
static bool paint(const saltus_sweep_page *page, saltus_raster rasters[SALTUS_PASSES]) {
    const long long most_changes = 750000;
    for (int fineness = saltus_sweep_fineness(page); fineness > 0; fineness--) {
        long long changes = 0;
        bool sound = true;
        for (int pass = 0; pass < page->sweep->pass_count && sound; pass++) {
            saltus_raster_close(&rasters[pass]);
            sound =
                saltus_raster_open(&rasters[pass], (int)(fineness * (page->frame.right - page->frame.left)),
                                   (int)(fineness * (page->frame.top - page->frame.bottom))) &&
                paint_pass(page, pass, fineness, &rasters[pass]);
            changes += sound ? saltus_raster_changes(&rasters[pass]) : 0;
        }
        if (!sound)
            return false;
        if (changes < most_changes)
            break;
    }
    return true;
}

/* Each face that limits the quantity shown: its position along the axis, and the edge of the page beyond
 * it. */
static void put_faces(const saltus_sweep_page *page) {
    enum { steps = 240 };
    for (int f = 0; f < saltus_system_face_count(page->system); f++) {
        saltus_face face = saltus_system_face(page->system, f);
        double beyond = face.side > 0 ? page->up.high : page->up.low;
        fprintf(page->paper.file, "$face_%d << EOD\n# parameter, clearance, edge of the page\nNaN NaN NaN\n",
                f);
        for (int k = 0; k <= steps && limits(page, face); k++) {
            double x = saltus_cells_value(&page->x, (double)k / steps), d = clearance(page, face, x);
            if (d > page->up.low && d < page->up.high)
                fprintf(page->paper.file, "%.9g %.9g %.9g\n", x, d, beyond);
        }
        fputs("EOD\n", page->paper.file);
    }
}

/* The blocks of exponents, which a density does without, and of the line at zero where that is upright: along
 * the axis value, cell, exponent, and the exponent less and plus its standard error; and the points where all
 * directions are lost, marked near the lower edge. Rows without an exponent are omitted. */
static void put_exponents(const saltus_sweep_page *page, bool dense) {
    FILE *file = page->paper.file;
    /* Columns overlap slightly to avoid visible thin gaps. */
    const saltus_frame *f = &page->frame;
    const double overlap = 0.5 / (page->swap ? f->top - f->bottom : f->right - f->left), raised = 0.012;
    const saltus_cells *x = &page->x;
    const saltus_range up = page->up;
    if (page->swap)
        fprintf(file, "$zero << EOD\n# exponent, parameter\n0 %.12g\n0 %.12g\nEOD\n", x->range.low,
                x->range.high);
    for (int lost = 0; lost < 2 && !dense; lost++) {
        fputs(lost ? "$lost << EOD\n# parameter where all directions are lost\n"
                   : "$exponents << EOD\n# parameter, its cell, exponent, less and plus its standard error\n",
              file);
        fputs("NaN NaN NaN NaN NaN NaN\n", file);
        for (int k = 0; k < x->count * saltus_sweep_visits(page->sweep); k++) {
            const int cell = k / saltus_sweep_visits(page->sweep);
            const saltus_sweep_row *row = &page->sweep->rows[saltus_sweep_visit(
                page->sweep, x->order[cell], k % saltus_sweep_visits(page->sweep))];
            const double exponent = saltus_sweep_measure(SALTUS_VIEW_LYAPUNOV, row),
                         error = isfinite(row->lyapunov_error) ? row->lyapunov_error : 0;
            const double edge[2] = {saltus_cells_edge(x, cell) - overlap,
                                    saltus_cells_edge(x, cell + 1) + overlap};
            double told[3] = {up.low + raised * (up.high - up.low), 0, 0};
            if (isnan(exponent) || (exponent == -INFINITY) != lost)
                continue;
            for (int i = 0; i < 3 && !lost; i++)
                told[i] = fmin(fmax(exponent + (i == 1 ? -error : i == 2 ? error : 0), up.low), up.high);
            fprintf(file, "%.9g %.9g %.9g %.7g %.7g %.7g\n", axis_value(page, cell),
                    saltus_cells_value(x, fmin(fmax(edge[0], 0), 1)),
                    saltus_cells_value(x, fmin(fmax(edge[1], 0), 1)), told[0], told[1], told[2]);
        }
        fputs("EOD\n", file);
    }
}

/* The columns of a block of parameter and measure that are the coordinates of a point. */
static const char *columns(const saltus_sweep_page *page) {
    return page->swap ? "2:1" : "1:2";
}

/* The cloud as elements of the plot command, rasters or points, with the legend of its colours. */
static void put_cloud_elements(const saltus_sweep_page *page, const saltus_raster *rasters, bool dense) {
    const unsigned faint = 0xa0; /* transparency out of 255 */
    FILE *file = page->paper.file;
    for (int k = 0; k < page->sweep->pass_count; k++) {
        const int pass = pass_drawn(page, k);
        const unsigned colour = colour_of(page, pass);
        if (linked(page, dense))
            fprintf(file, "     $links_%d using %s with lines lw 1 lc rgb '#%02x%06x' notitle, \\\n", pass,
                    columns(page), faint, colour);
        fputs("     ", file);
        if (dense)
            saltus_raster_element(file, &rasters[pass], "x2y2");
        else
            fprintf(file, "$cloud_%d using %s with points pt 7 ps %g lc rgb '#%06x' notitle", pass,
                    columns(page), page->shown < 2000 ? 0.45 : 0.32, colour);
        fputs(", \\\n", file);
    }
    for (int pass = 0; pass < page->sweep->pass_count && page->sweep->pass_count > 1; pass++)
        fprintf(file, "     NaN with points pt 7 ps 1.1 lc rgb '#%06x' title '%s', \\\n",
                (unsigned)colour_of(page, pass), name_of(page, pass));
}

/* The exponents as elements of the plot command, below the points: columns from zero, which are drawn only if
 * each value of the axis has one exponent, a line at zero, standard errors. */
static void put_exponent_elements(const saltus_sweep_page *page, bool dense) {
    static const uint32_t positive = 0xf3cfc4, negative = 0xdfe9f3, error_colour = 0xc0392b;
    const double zero = fmin(fmax(0, page->up.low), page->up.high);
    const bool swap = page->swap;
    FILE *file = page->paper.file;
    const char *line = swap ? "$zero using 1:2" : "0";
    if (dense) {
        fprintf(file, "     %s with lines lc rgb '#909090' lw 1.2 notitle, \\\n", line);
        return;
    }
    for (int k = 0; k < 2 && saltus_sweep_visits(page->sweep) == 1; k++) {
        fprintf(file,
                swap ? "     $exponents using ($4%s0?$4:NaN):1:(%.9g):4:2:3"
                     : "     $exponents using 1:($4%s0?$4:NaN):2:3:(%.9g):4",
                k ? "<" : ">", zero);
        fprintf(file, " with boxxyerror fs solid noborder fc rgb '#%06x' notitle, \\\n",
                (unsigned)(k ? negative : positive));
    }
    if (zero == 0)
        fprintf(file, "     %s with lines lc rgb '#707070' lw 1.2 notitle, \\\n", line);
    fprintf(file, "     $exponents using %s with vectors nohead lw 1.3 lc rgb '#40%06x' notitle, \\\n",
            swap ? "5:1:($6-$5):(0)" : "1:5:(0):($6-$5)", (unsigned)error_colour);
    if (saltus_sweep_any_lost(page))
        fprintf(file, "     $lost using %s with points pt 11 ps 0.9 lc rgb '#404040' notitle, \\\n",
                swap ? "4:1" : "1:4");
}

/* The faces that limit what is shown: each is named at the end of its line, at the edge of the panel where
 * that leaves it. gnuplot needs the names before the plot command. */
static void put_face_names(const saltus_sweep_page *page) {
    enum { steps = 240 };
    const double least = 40; /* units from the panel's left edge */
    for (int f = 0; f < saltus_system_face_count(page->system); f++) {
        saltus_face face = saltus_system_face(page->system, f);
        int k = steps;
        double d = NAN;
        for (; limits(page, face) && k >= 0 && !(d > page->up.low && d < page->up.high); k--)
            d = clearance(page, face, saltus_cells_value(&page->x, (double)k / steps));
        if (!(d > page->up.low && d < page->up.high))
            continue;
        const double part = (k + 1.0) / steps;
        fprintf(page->paper.file, "set label '%s{/:Italic d}", face.side < 0 ? "−" : "");
        if (saltus_system_spec(page->system)->stop_count > 1)
            fprintf(page->paper.file, "_{%d}", face.stop + 1);
        fputs("' at ", page->paper.file);
        if (k < steps - 1 && face.side < 0) /* in the grey, as the strip is beyond the edge */
            fprintf(page->paper.file,
                    page->swap ? "graph 0.04, graph %.4f center offset 0,-2"
                               : "graph %.4f, graph 0.04 center offset -3,0",
                    part);
        else if (k < steps - 1)
            fprintf(page->paper.file,
                    page->swap ? "graph 1.008, graph %.4f left" : "graph %.4f, graph 1 center offset 0,0.6",
                    part);
        else if (page->swap) /* clear of the names above the strip */
            fprintf(page->paper.file, "first %.9g, graph 1 %s offset 0,0.6", d,
                    saltus_range_part(page->up, page->logarithmic, d) *
                                (page->frame.right - page->frame.left) <
                            least
                        ? "left"
                        : "center");
        else
            fprintf(page->paper.file, "graph 1.008, first %.9g left", d);
        fputs(" front tc rgb '#606060'\n", page->paper.file);
    }
}

/* The plot command: grey beyond faces, what is shown, branches over it. */
static void put_plot(const saltus_sweep_page *page, const saltus_raster *rasters, bool dense) {
    FILE *file = page->paper.file;
    if (dense)
        saltus_sweep_put_raster_ranges(file, rasters[0].width, rasters[0].height);
    put_face_names(page);
    fputs("plot \\\n", file);
    for (int f = 0; f < saltus_system_face_count(page->system); f++) {
        const saltus_face face = saltus_system_face(page->system, f);
        if (!limits(page, face))
            continue;
        fprintf(file, "     $face_%d using ", f);
        if (page->swap)
            fprintf(file, "2:1 with filledcurves x1=%.9g", face.side > 0 ? page->up.high : page->up.low);
        else
            fputs("1:2:3 with filledcurves", file);
        fprintf(file,
                " fc rgb '#ececec' notitle, \\\n"
                "     $face_%d using %s with lines lc rgb '#9a9a9a' lw 1.2 notitle, \\\n",
                f, columns(page));
    }
    if (page->view == SALTUS_VIEW_LYAPUNOV)
        put_exponent_elements(page, dense);
    put_cloud_elements(page, rasters, dense);
    if (page->over.count)
        saltus_plot_elements(&page->over);
    else
        fputs("     NaN notitle\n", file);
    for (int k = 0; k < page->sweep->pass_count && dense; k++)
        saltus_raster_bytes(file, &rasters[pass_drawn(page, k)]);
}

/* Rows of the legend of passes; on a narrow page each name needs its own row. */
static int pass_rows(const saltus_sweep_page *page) {
    return saltus_page_narrow(&page->paper) ? page->sweep->pass_count : 1;
}

/* The frame of a diagram that fills the page from `below` units under the caption. */
static saltus_frame whole_frame(const saltus_sweep_page *page, double below) {
    const bool narrow = saltus_page_narrow(&page->paper);
    const saltus_frame rest = saltus_page_rest(&page->paper, below);
    return (saltus_frame){narrow ? 124 : 150, page->paper.width - (narrow ? 34 : 50), rest.bottom, rest.top};
}

/* Place the diagram, the strip of classes below it or, if it is upright, to its left, and the legends
 * needed. */
static bool place_frames(saltus_sweep_page *page, saltus_frame *strip) {
    const double band = 20, apart = 7, above = page->sweep->pass_count > 1 ? 42 : 6;
    page->frame = whole_frame(page, 26.4);
    if (page->over.count)
        page->frame.top -= saltus_plot_legend(&page->over, page->frame.right - page->frame.left, true);
    else if (page->sweep->pass_count > 1) {
        saltus_page_legend(&page->paper, pass_rows(page));
        page->frame.top -= 3 + 19 * pass_rows(page);
    }
    const double top = page->frame.top + 22;
    page->frame.top -= page->swap ? above : 0; /* names of stops and passes */
    /* The height of the legend of classes: below it lies the strip, if that is upright, and the shorter the
     * strip the fewer names have room in it. */
    double height = 0, last = -1;
    for (int k = 0; k < 8 && height != last && height >= 0; k++) {
        saltus_frame rest = page->frame;
        last = height;
        rest.top -= page->swap ? last : 0;
        const double found = saltus_sweep_put_strip_legend(page, rest, 0, false);
        height = found < 0 ? found : fmax(found, last);
    }
    page->frame.top -= height;
    const saltus_frame whole = *strip = page->frame;
    if (page->swap) {
        strip->right = page->frame.left + band * page->sweep->pass_count;
        page->frame.left = strip->right + apart;
    } else {
        strip->top = page->frame.bottom + band * page->sweep->pass_count;
        page->frame.bottom = strip->top + apart;
    }
    return height >= 0 && saltus_sweep_put_strip_legend(page, whole, top, true) >= 0;
}

saltus_status saltus_sweep_put_diagram(saltus_sweep_page *page, saltus_message *message) {
    saltus_raster rasters[SALTUS_PASSES] = {{0}};
    saltus_frame strip;
    saltus_line name = {.length = 0};
    FILE *file = page->paper.file;
    saltus_status status = find_range(page, message);
    if (status != SALTUS_OK)
        return status;
    bool sound = true;
    if (page->paper.free_height) { /* with room for the legends */
        page->frame = whole_frame(page, 0);
        const double height = saltus_sweep_put_strip_legend(page, page->frame, 0, false);
        sound = height >= 0;
        page->paper.height += height + 19 * (pass_rows(page) - 1);
        if (page->over.count)
            page->paper.height +=
                saltus_plot_legend(&page->over, page->frame.right - page->frame.left, false);
    }
    saltus_sweep_caption(page);
    saltus_page_begin(&page->paper);
    /* More points than a page of this size can hold apart are drawn as densities. */
    const double singly = 12000.0 / (1600 * 1200) * page->paper.width * page->paper.height;
    const bool dense = (double)page->shown > fmin(singly, 12000);
    put_faces(page);
    if (!dense)
        put_points(page);
    if (linked(page, dense))
        put_links(page);
    *(page->swap ? &page->over.x : &page->over.y) = page->up;
    fputs("set multiplot\n", file);
    saltus_page_caption(&page->paper);
    sound = sound && place_frames(page, &strip);
    page->over.frame = page->frame;
    if (page->over.count)
        sound = saltus_plot_data(&page->over) && sound;
    if (page->view == SALTUS_VIEW_LYAPUNOV)
        put_exponents(page, dense);
    if (dense)
        sound = sound && paint(page, rasters);
    if (sound) {
        saltus_page_frame(&page->paper, page->frame, SALTUS_PANEL_LEAST);
        saltus_sweep_put_axis(page, page->swap ? "y" : "x", &page->x);
        saltus_sweep_name_measure(page, &name);
        saltus_page_axis(&page->paper, page->swap ? "x" : "y", page->frame, page->logarithmic, name.text,
                         page->up);
        fputs(page->swap ? "unset ylabel\nset format y ''\n" : "unset xlabel\nset format x ''\n", file);
        saltus_plot_labels(&page->over, NULL, NULL);
        put_plot(page, rasters, dense);
        saltus_page_template(&page->paper, "close");
        sound = saltus_sweep_put_strip(page, strip);
        fputs("unset multiplot\n", file);
    }
    for (int pass = 0; pass < SALTUS_PASSES; pass++)
        saltus_raster_close(&rasters[pass]);
    return sound ? SALTUS_OK
                 : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for drawing %.200s", page->path);
}
