/* Clouds of very many points are drawn as densities: each pixel is covered as far as points cover it, and is
 * darker the larger their share of their trajectories' points. Computed again here from the file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure_folder.h"
#include "made_sweep.h"

enum { levels = 24 };

/* A picture: how much of each pixel is covered, and by which shares of trajectories. */
typedef struct picture {
    int width, height;
    double *cover, *weight;
} picture;

static double shared(double low, double high, int pixel) {
    double from = low > pixel ? low : pixel, to = high < pixel + 1 ? high : pixel + 1;
    return to > from ? to - from : 0;
}

static void cover(picture *p, double left, double right, double low, double high, double part) {
    for (int y = (int)floor(low); y <= (int)floor(high); y++)
        for (int x = (int)floor(left); x <= (int)floor(right); x++)
            if (x >= 0 && y >= 0 && x < p->width && y < p->height) {
                double area = shared(left, right, x) * shared(low, high, y);
                p->cover[y * p->width + x] += area;
                p->weight[y * p->width + x] += part * area;
            }
}

/* Draw all points of a sweep on a panel, as wide as their cells, or as dots if cells are wide. */
static picture cover_all(const figure_panel *panel, const figure_element *e, const saltus_sweep_file *file) {
    picture p = {e->width, e->height, NULL, NULL};
    p.cover = calloc((size_t)p.width * (size_t)p.height, sizeof *p.cover);
    p.weight = calloc((size_t)p.width * (size_t)p.height, sizeof *p.weight);
    assert_true(p.cover && p.weight);
    const double *across = panel->range[0], *up = panel->range[1], *list = file->axes[0].list;
    double fine = round(p.width / ((panel->frame[1] - panel->frame[0]) * 1600)),
           cell = p.width * (list[1] - list[0]) / (across[1] - across[0]);
    bool dots = cell > 4 * fine;
    double wide = dots ? 2.4 * fine : fmax(cell, fine), thick = (dots ? 2.4 : 1.6) * fine;
    assert_true(fine >= 1);
    for (int k = 0; k < file->axes[0].count; k++) {
        double x = p.width * (list[k] - across[0]) / (across[1] - across[0]);
        for (long long i = 0; i < file->turning_count[k]; i++) {
            double y = p.height * (file->turning[file->turning_first[k] + i] - up[0]) / (up[1] - up[0]);
            cover(&p, x - 0.5 * wide, x + 0.5 * wide, y - 0.5 * thick, y + 0.5 * thick,
                  1 / (double)file->turning_count[k]);
        }
    }
    return p;
}

static int by_size(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static double density_of(const picture *p, int k) {
    return p->weight[k] / fmin(p->cover[k], 1);
}

/* Opacity grows with the logarithm of the density, over a factor of at least 40, from the second to the 97th
 * percentile of pixels, in 24 levels. */
static void check_opacities(const picture *p, const figure_element *e, int allowed) {
    int size = p->width * p->height, count = 0, far = 0, most = 0, least = 255;
    unsigned colour = 0;
    double *list = calloc((size_t)size, sizeof *list);
    assert_non_null(list);
    for (int k = 0; k < size; k++)
        if (p->cover[k] > 0)
            list[count++] = density_of(p, k);
    assert_true(count > 100);
    qsort(list, (size_t)count, sizeof *list, by_size);
    double high = log(list[(int)(0.97 * (count - 1))]),
           low = fmin(log(list[(int)(0.02 * (count - 1))]), high - log(40));
    for (int k = 0; k < size; k++) {
        int shown;
        unsigned own = figure_pixel(e, k % p->width, k / p->width, &shown);
        assert_true(!shown || !colour || own == colour);
        colour = shown ? own : colour;
        if (p->cover[k] < 1e-7) {
            assert_true(shown == 0);
            continue;
        }
        double tone = fmin(fmax((log(density_of(p, k)) - low) / (high - low), 0), 1);
        double opacity = fmin(p->cover[k], 1) * (0.16 + 0.84 * tone);
        assert_true(fabs(shown / 255.0 - opacity) < 0.6 / levels + 0.002 + 0.01 * (allowed > 0));
        check_near(shown * levels / 255.0, round(shown * levels / 255.0), 0.06);
        far += shown != lround(255 * round(opacity * levels) / levels);
        most = shown > most ? shown : most;
        least = shown && shown < least ? shown : least;
    }
    /* Rounding at the border of two levels. */
    assert_true(far <= count / 100 + allowed);
    assert_true(most == 255 && least < 0.2 * 255);
    free(list);
}

static int values;

/* Orbits of few and of many points alternate, with motions that never repeat. */
static void fill(made_place *m) {
    static const int counts[] = {1, 2, 3, 6, 12, 25, 40, 90};
    bool orbit = values > 100 ? m->point % 3 > 0 : m->point % 2 == 0;
    int count = values > 100 ? 40 : 1550;
    m->row[0] = orbit ? made_periodic(1, 1) : made_other(SALTUS_CHAOTIC);
    if (orbit)
        count = values > 100 ? (int)(m->point % 25) + 20 : counts[m->point / 2 % 8];
    if (values == 72) { /* most places have orbits of few points, so that densities differ by more than 40 */
        orbit = m->point % 9 > 0;
        count = orbit ? counts[m->point % 4] : 1100 + 130 * (int)(m->point / 9);
        m->row[0] = orbit ? made_periodic(1, 1) : made_other(SALTUS_CHAOTIC);
    }
    m->turning_count[0] = count;
    double step = values == 72 ? 0.16 : 0.013, reach = values == 72 ? 0.4 : 0.8;
    for (int k = 0; k < count; k++)
        m->turning[k] = orbit ? step * (k % 7 ? k : 0) + 0.0007 * (double)(m->point % 31)
                              : reach * fmod(0.6180339887 * k + 0.01 * (double)m->point, 1);
}

static void densities_are_those_of_the_points(void **state) {
    (void)state;
    saltus_scene scene = {.spec = oscillator_spec(0.125, 1.75, 1.5, 0.625), .initial_count = 0};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_plot_part part = {"turning", 0.1037, 0.7083};
    char path[path_size], out[path_size];
    options.keep = SALTUS_KEEP_TURNING;
    strcpy(scene.name, "made_up");
    for (int k = 0; k < 5; k++) {
        values = k == 4 ? 72 : k % 2 ? 500 : 16;
        saltus_axis axis = {.key = "omega", .count = values, .low = 0.5, .high = 1.5};
        saltus_sweep_view how = {.view = SALTUS_VIEW_TURNING, .parts = &part, .part_count = k / 2 == 1};
        saltus_message message = {.text = ""};
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill, 1000);
        saltus_sweep_file file = made_read(path);
        check_ok(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), &message);
        figure f = figure_taken(folder);
        const figure_panel *panel = &f.panel[0];
        const figure_element *e = figure_element_of(panel, "binary", 0);
        assert_non_null(e);
        picture p = cover_all(panel, e, &file);
        int filled = 0;
        for (int i = 0; i < p.width * p.height; i++)
            filled += p.cover[i] > 0;
        /* With more pixels only a part is examined. */
        assert_true(filled < 20000 || k % 4);
        check_opacities(&p, e, filled > 20000 ? filled : 0);
        free(p.cover);
        free(p.weight);
        figure_free(&f);
        saltus_sweep_file_clear(&file);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(densities_are_those_of_the_points)};
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
