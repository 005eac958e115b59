/* Maps of sweeps over two axes: every pixel has the colour of its cell's row, and the legend or bar explains
 * the colour; both agree with the file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"
#include "figure_folder.h"
#include "made_sweep.h"

enum { columns = 6, rows = 5, nothing_colour = 0xc6c6c6 };

static saltus_scene made_scene(void) {
    saltus_scene scene = {.spec = oscillator_spec(0.125, 1.75, 1.5, 0.625), .initial_count = 0};
    add_stop(&scene.spec, 1, 0.75, SALTUS_UPPER);
    strcpy(scene.name, "made_up");
    return scene;
}

static figure draw(const saltus_sweep_view *view, const char *picture) {
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    check_ok(saltus_plot_sweep(path_in(picture, out), path_in("s.h5", path), view, &message), &message);
    figure f = figure_taken(folder);
    figure_check_page(&f);
    return f;
}

/* An unordered list across, equal or equal-ratio steps upwards. */
static void make_axes(saltus_axis axes[2], saltus_spacing up) {
    static const double values[columns] = {0.9, 0.5, 1.5, 0.75, 0.6, 1.2};
    axes[0] = (saltus_axis){
        .key = "omega", .spacing = SALTUS_LIST, .count = columns, .low = 0.9, .high = 1.2, .list = values};
    axes[1] = (saltus_axis){.key = "d", .spacing = up, .count = rows, .low = 0.125, .high = 8};
}

static double place_of(double value, bool logarithmic) {
    return logarithmic ? log(value) : value;
}

/* The axis entry of a pixel: the one whose cell, half way to its neighbours, holds the pixel's middle; -1
 * near an edge. */
static void find_cells(const saltus_axis *axis, const double range[2], int pixels, int *cell) {
    bool logarithmic = axis->spacing == SALTUS_LOGARITHMIC;
    int order[64];
    double edge[65] = {0};
    for (int k = 0; k < axis->count; k++) {
        int rank = 0;
        for (int j = 0; j < axis->count; j++)
            rank += axis->list[j] < axis->list[k];
        order[rank] = k;
    }
    for (int k = 1; k < axis->count; k++)
        edge[k] = 0.5 * (place_of(axis->list[order[k - 1]], logarithmic) +
                         place_of(axis->list[order[k]], logarithmic));
    edge[0] = 2 * place_of(axis->list[order[0]], logarithmic) - edge[1];
    edge[axis->count] = 2 * place_of(axis->list[order[axis->count - 1]], logarithmic) - edge[axis->count - 1];
    double low = place_of(range[0], logarithmic), width = place_of(range[1], logarithmic) - low;
    for (int x = 0; x < pixels; x++) {
        double at = low + width * (x + 0.5) / pixels, pixel = width / pixels;
        int k = 0;
        while (k < axis->count && edge[k + 1] < at)
            k++;
        bool clear = k < axis->count && at - edge[k] > 0.02 * pixel && edge[k + 1] - at > 0.02 * pixel;
        cell[x] = clear ? order[k] : -1;
    }
}

/* The grid point at each pixel, -1 near an edge; freed by the caller. */
static long long *points_of(const figure_panel *panel, const figure_element *e,
                            const saltus_sweep_file *file) {
    int *across = calloc((size_t)e->width, sizeof *across), *up = calloc((size_t)e->height, sizeof *up);
    long long *points = calloc((size_t)e->width * (size_t)e->height, sizeof *points);
    assert_true(across && up && points);
    assert_true(panel->range[2][0] == 0 && panel->range[2][1] == e->width);
    assert_true(panel->range[3][0] == 0 && panel->range[3][1] == e->height);
    for (int axis = 0; axis < 2; axis++)
        assert_true(panel->logarithmic[axis] == (file->axes[axis].spacing == SALTUS_LOGARITHMIC));
    find_cells(&file->axes[0], panel->range[0], e->width, across);
    find_cells(&file->axes[1], panel->range[1], e->height, up);
    for (int y = 0; y < e->height; y++)
        for (int x = 0; x < e->width; x++)
            points[y * e->width + x] =
                across[x] < 0 || up[y] < 0 ? -1 : across[x] + (long long)up[y] * file->axes[0].count;
    free(across);
    free(up);
    return points;
}

/* The words beside the legend's square of a colour; `figures` too if they are to its right. */
static const figure_mark *entry_of(const figure_panel *panel, unsigned colour, const char **figures) {
    char word[16];
    snprintf(word, sizeof word, "'#%06x'", colour);
    const figure_mark *square = figure_mark_of(panel, 'o', word, 0), *words = NULL;
    *figures = "";
    if (!square)
        return NULL;
    double middle = 0.5 * (square->place[0][1] + square->place[1][1]);
    for (int m = 0; m < panel->mark_count; m++) {
        const figure_mark *mark = &panel->mark[m];
        if (mark->kind != 'l' || mark->system[0][0] != 's' || fabs(mark->place[0][1] - middle) > 1e-4)
            continue;
        if (strstr(mark->style, "right"))
            *figures = mark->text;
        else if (!words && mark->place[0][0] > square->place[1][0])
            words = mark;
    }
    assert_non_null(words);
    return words;
}

/* Classes */

static const int verdicts[] = {SALTUS_CHAOTIC, SALTUS_HELD, SALTUS_FAILED, SALTUS_UNDECIDED};

static saltus_sweep_row class_row(long long point) {
    long long kind = point * point % 11;
    return kind < 3    ? made_periodic((int)kind, 1)
           : kind == 3 ? made_periodic(-1, 2)
           : kind < 8  ? made_other(verdicts[kind - 4])
                       : made_periodic((int)kind, 2);
}

static void fill_classes(made_place *m) {
    m->row[0] = class_row(m->point);
}

static void class_name(const saltus_sweep_row *row, char label[64]) {
    char own[32];
    saltus_sweep_label(row, own);
    snprintf(label, 64, "%s", row->verdict == SALTUS_HELD ? "held by the stop" : own);
    if (row->verdict == SALTUS_PERIODIC && row->impacts == 0)
        snprintf(label + strlen(label), 64 - strlen(label), "  no impact");
}

static void each_cell_has_the_colour_of_its_class(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2];
    char path[path_size];
    for (int k = 0; k < 2; k++) {
        make_axes(axes, k ? SALTUS_LOGARITHMIC : SALTUS_LINEAR);
        made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_classes, 100);
        saltus_sweep_file file = made_read(path);
        saltus_sweep_view how = {.view = k ? SALTUS_VIEW_CLASS : SALTUS_VIEW_AUTOMATIC};
        figure f = draw(&how, k ? "s.svg" : "s.png");
        const figure_panel *panel = &f.panel[0];
        const figure_element *e = figure_element_of(panel, "binary", 0);
        long long *point = points_of(panel, e, &file), seen = 0;
        unsigned colour[columns * rows] = {0};
        int votes[columns * rows] = {0};
        int pixels = (int)lround(1600 * (panel->frame[1] - panel->frame[0]));
        assert_int_equal(e->width, (k ? 2 : 1) * pixels);
        for (int n = 0; n < e->width * e->height; n++) {
            if (point[n] < 0)
                continue;
            int opacity;
            unsigned own = figure_pixel(e, n % e->width, n / e->width, &opacity);
            assert_int_equal(opacity, 255);
            /* Most of a cell has its colour, the rest its texture. */
            if (votes[point[n]] == 0)
                colour[point[n]] = own;
            votes[point[n]] += colour[point[n]] == own ? 1 : -1;
            seen++;
        }
        assert_true(seen > 0.97 * e->width * e->height);
        double above = 2, share_above = 101;
        for (int p = 0; p < columns * rows; p++) {
            char label[64], share[32];
            const char *figures;
            int same = 0;
            class_name(&file.rows[p], label);
            for (int q = 0; q < columns * rows; q++) {
                char other[64];
                class_name(&file.rows[q], other);
                same += strcmp(label, other) == 0;
                assert_true((strcmp(label, other) == 0) == (colour[p] == colour[q]));
            }
            const figure_mark *words = entry_of(panel, colour[p], &figures);
            double part = 100.0 * same / (columns * rows);
            assert_non_null(words);
            assert_string_equal(words->text, label);
            snprintf(share, sizeof share, "%.*f %%", part < 9.95, part);
            assert_string_equal(figures, share);
            if (p == 0) {
                above = words->place[0][1];
                share_above = part;
            } else if (part != share_above)
                assert_true((words->place[0][1] < above) == (part < share_above));
        }
        assert_non_null(strstr(panel->label[0], "{/:Italic ω}"));
        assert_non_null(strstr(panel->label[1], "{/:Italic d}"));
        figure_says(&f, "motions in {/:Italic ω} and {/:Italic d}");
        figure_says(&f, "6 values of {/:Italic ω} × 5 of {/:Italic d}, each from the initial state");
        free(point);
        figure_free(&f);
        saltus_sweep_file_clear(&file);
    }
}

static double luminance(unsigned colour) {
    return 0.299 * (colour >> 16 & 0xff) + 0.587 * (colour >> 8 & 0xff) + 0.114 * (colour & 0xff);
}

/* A colour's perceived lightness, chroma and hue in degrees: Ottosson's Oklab, from the sRGB standard's
 * transfer curve. */
static void oklab_of(unsigned colour, double *lightness, double *chroma, double *hue) {
    double linear[3], cone[3], a, b;
    static const double cones[3][3] = {{0.4122214708, 0.5363325363, 0.0514459929},
                                       {0.2119034982, 0.6806995451, 0.1073969566},
                                       {0.0883024619, 0.2817188376, 0.6299787005}};
    for (int k = 0; k < 3; k++) {
        double c = (colour >> (16 - 8 * k) & 0xff) / 255.0;
        linear[k] = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
    }
    for (int k = 0; k < 3; k++)
        cone[k] = cbrt(cones[k][0] * linear[0] + cones[k][1] * linear[1] + cones[k][2] * linear[2]);
    *lightness = 0.2104542553 * cone[0] + 0.7936177850 * cone[1] - 0.0040720468 * cone[2];
    a = 1.9779984951 * cone[0] - 2.4285922050 * cone[1] + 0.4505937099 * cone[2];
    b = 0.0259040371 * cone[0] + 0.7827717662 * cone[1] - 0.8086757660 * cone[2];
    *chroma = hypot(a, b);
    *hue = atan2(b, a) * 180 / acos(-1.0);
}

static void looks(unsigned colour, double *lightness, double *hue) {
    double chroma;
    oklab_of(colour, lightness, &chroma, hue);
}

static double apart(double a, double b) {
    return fabs(remainder(a - b, 360));
}

static void fill_shades(made_place *m) {
    m->row[0] = made_periodic((int)(m->point % 4) + (m->point % 4 > 0) * 3 * (int)(m->point / 4 % 2),
                              1 + (int)(m->point / 8 % 2));
}

/* The hue shows the period; within a period more impacts are darker, in distinguishable steps. */
static void shades_tell_period_and_impacts(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2];
    char path[path_size];
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_shades, 100);
    figure f = draw(&how, "s.png");
    double light[3][7], hue[3][7];
    for (int p = 1; p <= 2; p++)
        for (int n = 0; n <= 6; n++) {
            bool found = false;
            char label[24];
            snprintf(label, sizeof label, "%d/%d%s", n, p, n ? "" : "  no impact");
            for (int m = 0; m < f.panel[0].mark_count && !found; m++) {
                const figure_mark *mark = &f.panel[0].mark[m];
                const char *figures;
                long colour = mark->kind == 'o' ? figure_colour(mark->text) : -1;
                found = colour >= 0 &&
                        strcmp(entry_of(&f.panel[0], (unsigned)colour, &figures)->text, label) == 0;
                if (found)
                    looks((unsigned)colour, &light[p][n], &hue[p][n]);
            }
            assert_true(found);
        }
    for (int p = 1; p <= 2; p++) {
        double step = light[p][1] - light[p][2];
        assert_true(light[p][0] > light[p][1] && step > 0.05);
        for (int n = 2; n < 6; n++)
            check_near(light[p][n] - light[p][n + 1], step, 0.012);
        for (int n = 2; n <= 6; n++)
            assert_true(apart(hue[p][n], hue[p][1]) < 30);
        assert_true(apart(hue[p][0], hue[p][3]) < 30);
    }
    for (int n = 0; n <= 6; n++)
        assert_true(apart(hue[1][n], hue[2][n]) > 60);
    figure_free(&f);
}

/* With several starts a cell shows the most frequent motion, with lines across if there are others. */
static void fill_several(made_place *m) {
    for (int s = 0; s < m->seeds; s++) {
        m->row[s] = made_periodic(1, 1);
        if (s >= m->point % 4)
            m->row[s] = made_periodic(2, 1);
        m->row[s].attractor = m->point % 4 > 0 && m->point % 4 < 3 && s >= m->point % 4;
    }
}

/* Starts without a motion hide none, and count as no attractor. */
static void fill_some_without(made_place *m) {
    for (int s = 0; s < m->seeds; s++) {
        const bool moves = m->point % 3 != 2 && s > m->point % 3;
        m->row[s] = moves               ? made_periodic(1, 1)
                    : m->point % 3 == 1 ? made_other(SALTUS_FAILED)
                                        : made_other(SALTUS_BEYOND);
        m->row[s].attractor = moves ? 0 : -1;
    }
}

static void starts_without_a_motion_hide_none(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2];
    char path[path_size];
    options.seeds = 3;
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_some_without, 100);
    saltus_sweep_file file = made_read(path);
    figure f = draw(&how, "s.png");
    const figure_element *e = figure_element_of(&f.panel[0], "binary", 0);
    long long *point = points_of(&f.panel[0], e, &file);
    const unsigned moving = saltus_class_paint(SALTUS_PERIODIC, 1, 1).colour;
    int asked = 0;
    for (int n = 0; n < e->width * e->height; n += 31) {
        if (point[n] < 0)
            continue;
        assert_true((figure_pixel(e, n % e->width, n / e->width, NULL) == moving) == (point[n] % 3 != 2));
        asked++;
    }
    assert_true(asked > 1000);
    assert_null(figure_mark_of(&f.panel[0], 'l', "more than one attractor", 0));
    assert_null(figure_mark_of(&f.panel[0], 'l', "failed", 0));
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "beyond a stop", 0));
    free(point);
    figure_free(&f);
    saltus_sweep_file_clear(&file);
}

static void the_motion_of_most_starts_is_shown(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2];
    char path[path_size];
    options.seeds = 3;
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_several, 100);
    saltus_sweep_file file = made_read(path);
    figure f = draw(&how, "s.png");
    const figure_element *e = figure_element_of(&f.panel[0], "binary", 0);
    long long *point = points_of(&f.panel[0], e, &file);
    int pixels[4] = {0}, ours[4] = {0}, others[4] = {0};
    unsigned own[4] = {0};
    for (int kind = 0; kind < 4; kind++) {
        const char *figures;
        for (int m = 0; m < f.panel[0].mark_count; m++) {
            const figure_mark *mark = &f.panel[0].mark[m];
            long colour = mark->kind == 'o' ? figure_colour(mark->text) : -1;
            if (colour >= 0 && strcmp(entry_of(&f.panel[0], (unsigned)colour, &figures)->text,
                                      kind < 2 ? "2/1" : "1/1") == 0)
                own[kind] = (unsigned)colour;
        }
        assert_true(own[kind]);
    }
    for (int n = 0; n < e->width * e->height; n++) {
        if (point[n] < 0)
            continue;
        int kind = (int)(point[n] % 4);
        unsigned colour = figure_pixel(e, n % e->width, n / e->width, NULL);
        pixels[kind]++;
        ours[kind] += colour == own[kind];
        others[kind] += colour == own[3 - kind] && own[3 - kind] != own[kind];
    }
    assert_true(ours[0] == pixels[0] && ours[3] == pixels[3]);
    for (int kind = 1; kind < 3; kind++) {
        double part = (double)ours[kind] / pixels[kind];
        assert_true(part > 0.8 && part < 0.95 && others[kind] == 0);
    }
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "more than one attractor", 0));
    free(point);
    figure_free(&f);
    saltus_sweep_file_clear(&file);
    /* How many there are. */
    how.view = SALTUS_VIEW_ATTRACTORS;
    f = draw(&how, "s.png");
    file = made_read(path);
    e = figure_element_of(&f.panel[0], "binary", 0);
    point = points_of(&f.panel[0], e, &file);
    for (int n = 0; n < e->width * e->height; n += 97) {
        const char *figures;
        if (point[n] < 0)
            continue;
        int kind = (int)(point[n] % 4);
        const figure_mark *words =
            entry_of(&f.panel[0], figure_pixel(e, n % e->width, n / e->width, NULL), &figures);
        assert_true(words != NULL);
        assert_string_equal(words->text, kind == 1 || kind == 2 ? "2 attractors" : "1 attractor");
    }
    free(point);
    figure_free(&f);
    saltus_sweep_file_clear(&file);
}

/* In passes motions also count as attractors; rows not computed do not count. */
static void fill_passes(made_place *m) {
    m->row[0] = made_periodic(1, m->pass == SALTUS_PASS_DOWN && m->point % 2 ? 2 : 1);
}

static void passes_that_differ_are_two_attractors(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2];
    char path[path_size], text[8000];
    options.passes = 6;
    make_axes(axes, SALTUS_LINEAR);
    for (int whole = 0; whole < 2; whole++) {
        made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_passes,
                   whole ? 100 : columns * rows + 12);
        saltus_sweep_file file = made_read(path);
        for (int counted = 0; counted < 2; counted++) {
            saltus_sweep_view how = {.view = counted ? SALTUS_VIEW_ATTRACTORS : SALTUS_VIEW_CLASS};
            figure f = draw(&how, "s.png");
            const figure_element *e = figure_element_of(&f.panel[0], "binary", 0);
            long long *point = points_of(&f.panel[0], e, &file);
            int hatched[2] = {0};
            unsigned last = 0;
            const figure_mark *words = NULL;
            for (int n = 0; n < e->width * e->height; n += 1 + 12 * counted) {
                const char *figures;
                if (point[n] < 0)
                    continue;
                bool two = point[n] % 2 && (whole || point[n] < 12);
                unsigned colour = figure_pixel(e, n % e->width, n / e->width, NULL);
                if (n == 0 || colour != last)
                    words = entry_of(&f.panel[0], colour, &figures);
                last = colour;
                if (counted)
                    assert_string_equal(words ? words->text : "", two ? "2 attractors" : "1 attractor");
                else if (words)
                    assert_string_equal(words->text, "1/1");
                hatched[two] += !words;
            }
            assert_true(hatched[0] == 0 && (hatched[1] > 0) == !counted);
            figure_caption(&f, text, sizeof text);
            assert_true((strstr(text, "(interrupted: 70 % done)") != NULL) == !whole);
            free(point);
            figure_free(&f);
        }
        saltus_sweep_file_clear(&file);
    }
}

/* Names are in a region of their motion, in readable letters. */
static void fill_regions(made_place *m) {
    m->row[0] = m->point % columns < 3 ? made_periodic(1, 1) : made_other(SALTUS_CHAOTIC);
    if (m->point / columns == 4)
        m->row[0] = made_periodic(5, 2);
}

static void names_stand_in_their_regions(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2] = {{.key = "omega", .count = columns, .low = 0.5, .high = 1.5},
                           {.key = "d", .count = rows, .low = 1, .high = 2}};
    char path[path_size];
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_regions, 100);
    figure f = draw(&how, "s.png");
    const figure_element *e = figure_element_of(&f.panel[0], "binary", 0);
    /* Middles of the three regions. */
    static const double middle[3][2] = {{0.25, 0.4}, {0.75, 0.4}, {0.5, 0.9}};
    static const char *const names[] = {"1/1", "chaotic", "5/2"};
    int found = 0;
    for (int m = 0; m < f.panel[0].mark_count; m++) {
        const figure_mark *mark = &f.panel[0].mark[m];
        if (mark->kind != 'l' || mark->system[0][0] != 'g')
            continue;
        const char *figures;
        unsigned colour =
            figure_pixel(e, (int)(mark->place[0][0] * e->width), (int)(mark->place[0][1] * e->height), NULL);
        assert_string_equal(entry_of(&f.panel[0], colour, &figures)->text, mark->text);
        assert_true(fabs(luminance((unsigned)figure_colour(mark->style)) - luminance(colour)) > 110);
        for (int k = 0; k < 3; k++)
            if (strcmp(names[k], mark->text) == 0) {
                check_near(mark->place[0][0], middle[k][0], 0.05);
                check_near(mark->place[0][1], middle[k][1], 0.05);
                found++;
            }
    }
    assert_int_equal(found, 3);
    figure_free(&f);
}

/* However rare, chaos and the like keep their own entry; if room is short the rarest periodic motions are
 * merged and counted. Entries are sorted by frequency and stay on the page. */
static const int other_verdicts[] = {SALTUS_EQUILIBRIUM,   SALTUS_HELD,        SALTUS_UNDECIDED,
                                     SALTUS_QUASIPERIODIC, SALTUS_LONG_PERIOD, SALTUS_CHAOTIC,
                                     SALTUS_FAILED};

static int crowd; /* number of periodic motions */

static void fill_crowd(made_place *m) {
    int k = (int)m->point;
    m->row[0] =
        k < 7 ? made_other(other_verdicts[k]) : made_periodic(1 + (k % crowd) / 8, 1 + (k % crowd) % 8);
}

static void the_rarest_chaos_keeps_its_entry(void **state) {
    static const char *const names[] = {
        "at rest, no contact",  "held by the stop", "undecided", "quasi-periodic",
        "long period, or slow", "chaotic",          "failed"};
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2] = {{.key = "omega", .count = 20, .low = 0.5, .high = 1.5},
                           {.key = "d", .count = 15, .low = 1, .high = 2}};
    char path[path_size];
    for (crowd = 10; crowd <= 80; crowd += 35) {
        made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_crowd, 1000);
        figure f = draw(&how, "s.png");
        int own = 0, more = 0;
        unsigned told = 0;
        double below = 1, share = 100, rest = 0, sum = 0;
        for (;;) {
            const figure_mark *next = NULL;
            const char *figures;
            for (int m = 0; m < f.panel[0].mark_count; m++) {
                const figure_mark *mark = &f.panel[0].mark[m];
                if (mark->kind == 'o' && figure_colour(mark->text) >= 0 && mark->place[0][1] < below &&
                    (!next || mark->place[0][1] > next->place[0][1]))
                    next = mark;
                if (mark->kind == 'l' && strstr(mark->text, " more motions"))
                    sscanf(mark->text, "%d more motions, %lf %%", &more, &rest);
            }
            if (!next)
                break;
            below = next->place[0][1];
            assert_true(below > 0.03 && next->place[1][0] < 1);
            const char *words = entry_of(&f.panel[0], (unsigned)figure_colour(next->text), &figures)->text;
            double part = strtod(figures, NULL);
            assert_true(part <= share);
            share = part;
            sum += part;
            int impacts, periods;
            if (sscanf(words, "%d/%d", &impacts, &periods) == 2)
                own++;
            for (int k = 0; k < 7; k++)
                if (strcmp(words, names[k]) == 0)
                    told |= 1u << k;
        }
        assert_int_equal(told, 127);
        assert_int_equal(own + more, crowd);
        assert_true((more > 0) == (crowd > 40) && own >= 10);
        check_near(sum + rest, 100, 2);
        figure_free(&f);
    }
}

/* A motion's look depends on its verdict and n/p alone, and those with one texture are distinguishable, also
 * without seeing red. */
static void without_red(const double colour[3], double seen[3]) {
    seen[0] = seen[1] = 0.11238 * colour[0] + 0.88762 * colour[1];
    seen[2] = fmax(0, 0.00401 * (colour[0] - colour[1]) + colour[2]);
}

static void seen_of(unsigned colour, bool red, double lab[3]) {
    double linear[3], seen[3];
    for (int k = 0; k < 3; k++) {
        double c = (colour >> (16 - 8 * k) & 0xff) / 255.0;
        linear[k] = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
    }
    without_red(linear, seen);
    const double *s = red ? linear : seen;
    double l = cbrt(0.4122214708 * s[0] + 0.5363325363 * s[1] + 0.0514459929 * s[2]),
           m = cbrt(0.2119034982 * s[0] + 0.6806995451 * s[1] + 0.1073969566 * s[2]),
           t = cbrt(0.0883024619 * s[0] + 0.2817188376 * s[1] + 0.6299787005 * s[2]);
    lab[0] = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * t;
    lab[1] = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * t;
    lab[2] = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * t;
}

static void motions_look_different_without_red(void **state) {
    (void)state;
    enum { most = 7, longest = 8, periodic = most * longest };
    static const saltus_verdict other[] = {SALTUS_EQUILIBRIUM, SALTUS_HELD,      SALTUS_QUASIPERIODIC,
                                           SALTUS_CHAOTIC,     SALTUS_FAILED,    SALTUS_LONG_PERIOD,
                                           SALTUS_UNDECIDED,   SALTUS_TRANSIENT, SALTUS_IRREGULAR};
    enum { count = periodic + sizeof other / sizeof other[0] };
    saltus_paint paint[count];
    for (int k = 0; k < count; k++)
        paint[k] = k < periodic ? saltus_class_paint(SALTUS_PERIODIC, k % most, 1 + k / most)
                                : saltus_class_paint(other[k - periodic], 0, 0);
    for (int red = 0; red < 2; red++)
        for (int a = 0; a < count; a++)
            for (int b = 0; b < a; b++) {
                double one[3], other[3];
                seen_of(paint[a].colour, red, one);
                seen_of(paint[b].colour, red, other);
                double apart =
                    sqrt(pow(one[0] - other[0], 2) + pow(one[1] - other[1], 2) + pow(one[2] - other[2], 2));
                if (paint[a].texture == paint[b].texture && apart < 0.035)
                    fail_msg("%d/%d and %d/%d (from 9 on other verdicts) are %.3f apart", a % most,
                             1 + a / most, b % most, 1 + b / most, apart);
            }
    /* The texture is visible: pixels of another colour, but few of them. */
    for (int k = 0; k < count; k++) {
        int other = 0;
        for (int n = 0; n < 90 * 90; n++)
            other += saltus_paint_at(paint[k], n % 90, n / 90) != paint[k].colour;
        assert_true((other > 0) == (paint[k].texture != 0) && other < 90 * 90 / 3);
    }
}

static bool zoomed; /* the same motions among others that are more frequent */

static void fill_zoomed(made_place *m) {
    long long k = m->point;
    m->row[0] = made_periodic(1 + (int)(k % 4), 1 + (int)(k % 3) + (zoomed && k >= 12 ? 3 : 0));
}

/* A motion's colour in a legend, -1 if it has no entry. */
static long colour_in(const figure_panel *panel, const char *words) {
    for (int m = 0; m < panel->mark_count; m++) {
        const char *figures;
        long colour = panel->mark[m].kind == 'o' ? figure_colour(panel->mark[m].text) : -1;
        if (colour >= 0 && strcmp(entry_of(panel, (unsigned)colour, &figures)->text, words) == 0)
            return colour;
    }
    return -1;
}

/* No two motions of up to eight periods and thirty impacts, or with chatter, look the same. */
static void each_motion_has_its_own_paint(void **state) {
    (void)state;
    enum { impacts = 31, longest = 8, count = impacts * longest, all = count + 12 };
    saltus_paint paint[all];
    for (int k = 0; k < all; k++)
        paint[k] = k < count ? saltus_class_paint(SALTUS_PERIODIC, k % impacts, 1 + k / impacts)
                             : saltus_class_paint(SALTUS_PERIODIC, -1, 1 + k - count);
    for (int a = 0; a < all; a++)
        for (int b = 0; b < a; b++)
            if (paint[a].colour == paint[b].colour && paint[a].texture == paint[b].texture)
                fail_msg("motions %d and %d have the same paint", a, b);
}

/* A motion has the same colour in every map; a part of a map explains what it shows, with shares of that
 * part. */
static void a_motion_has_one_colour(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2] = {{.key = "omega", .count = 10, .low = 0.5, .high = 1.5},
                           {.key = "d", .count = 10, .low = 1, .high = 2}};
    const saltus_plot_part lowest = {"d", 0.9, 1.05};
    char path[path_size];
    figure f[3];
    for (int k = 0; k < 3; k++) {
        zoomed = k > 0;
        const saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS, .parts = &lowest, .part_count = k == 2};
        made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_zoomed, 100);
        f[k] = draw(&how, "s.png");
    }
    for (int n = 1; n <= 4; n++)
        for (int p = 1; p <= 6; p++) {
            char label[16];
            snprintf(label, sizeof label, "%d/%d", n, p);
            long colour[3];
            for (int k = 0; k < 3; k++)
                colour[k] = colour_in(&f[k].panel[0], label);
            assert_true((colour[0] >= 0) == (p <= 3) && colour[1] >= 0);
            assert_true(p > 3 || colour[0] == colour[1]);
            /* The ten points of the lowest row are of periods 1 to 3. */
            assert_true(colour[2] < 0 || (p <= 3 && colour[2] == colour[1]));
        }
    const char *figures;
    assert_non_null(entry_of(&f[2].panel[0], (unsigned)colour_in(&f[2].panel[0], "1/1"), &figures));
    assert_string_equal(figures, "10 %");
    for (int k = 0; k < 3; k++)
        figure_free(&f[k]);
}

/* In any part of a map the legend has an entry for exactly the colours in it, even of a part of a cell. */
static void a_part_explains_what_it_shows(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2] = {{.key = "omega", .count = 10, .low = 0.5, .high = 1.4},
                           {.key = "d", .count = 10, .low = 1, .high = 1.9}};
    char path[path_size];
    unsigned random = 7;
    zoomed = true;
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_zoomed, 100);
    for (int trial = 0; trial < 12; trial++) {
        saltus_plot_part parts[2] = {{.key = "omega"}, {.key = "d"}};
        for (int k = 0; k < 2; k++) {
            /* Some borders are just beyond an edge between cells. */
            random = random * 1103515245u + 12345u;
            double from = (random >> 16) % 700 / 1000.0, wide = 0.04 + (random >> 8) % 200 / 1000.0;
            if (trial % 3 == 0)
                from = round(10 * from) / 10 + 0.05 - 0.03;
            parts[k].low = axes[k].low + from;
            parts[k].high = parts[k].low + wide;
        }
        const saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS, .parts = parts, .part_count = 2};
        figure f = draw(&how, "s.png");
        const figure_element *e = figure_element_of(&f.panel[0], "binary", 0);
        bool painted[5][7] = {{false}};
        unsigned last = 0;
        for (int k = 0; k < e->width * e->height; k++) {
            unsigned colour = figure_pixel(e, k % e->width, k / e->width, NULL);
            for (int c = 0; c < 24 && colour != last; c++)
                if (colour == saltus_class_paint(SALTUS_PERIODIC, 1 + c % 4, 1 + c / 4).colour)
                    painted[1 + c % 4][1 + c / 4] = true;
            last = colour;
        }
        for (int n = 1; n <= 4; n++)
            for (int p = 1; p <= 6; p++) {
                long colour = (long)saltus_class_paint(SALTUS_PERIODIC, n, p).colour;
                char label[16];
                snprintf(label, sizeof label, "%d/%d", n, p);
                if (painted[n][p] != (colour_in(&f.panel[0], label) == colour))
                    fail_msg("%s %s from %g to %g, %g to %g", label,
                             painted[n][p] ? "has no entry" : "is not there", parts[0].low, parts[0].high,
                             parts[1].low, parts[1].high);
            }
        figure_free(&f);
    }
}

/* Shares have two digits or, from a tenth on, those of whole numbers. */
static int few_points;

static void fill_few(made_place *m) {
    m->row[0] = made_periodic(m->point < few_points ? 2 : 1, 1);
}

static void shares_have_two_digits(void **state) {
    (void)state;
    static const struct {
        int columns, rows, few;
        const char *share;
    } grids[] = {{11, 11, 12, "9.9 %"}, {7, 43, 30, "10 %"}, {10, 10, 1, "1.0 %"}, {20, 20, 39, "9.8 %"}};
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    char path[path_size];
    for (int g = 0; g < 4; g++) {
        saltus_axis axes[2] = {{.key = "omega", .count = grids[g].columns, .low = 0.5, .high = 1.5},
                               {.key = "d", .count = grids[g].rows, .low = 1, .high = 2}};
        few_points = grids[g].few;
        made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_few, 1000);
        figure f = draw(&how, "s.png");
        assert_non_null(figure_mark_of(&f.panel[0], 'l', grids[g].share, 0));
        assert_string_equal(figure_mark_of(&f.panel[0], 'l', grids[g].share, 0)->text, grids[g].share);
        figure_free(&f);
    }
}

/* An undecided motion is called so, whether exponents were measured or not. */
static void fill_undecided(made_place *m) {
    m->row[0] = m->point ? made_other(SALTUS_UNDECIDED) : made_periodic(1, 1);
}

static void undecided_is_called_so(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2];
    char path[path_size];
    make_axes(axes, SALTUS_LINEAR);
    for (int k = 0; k < 4; k++) {
        options.keep = k % 2 ? SALTUS_KEEP_LYAPUNOV : 0;
        options.measure = k / 2;
        made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_undecided, 100);
        figure f = draw(&how, "s.png");
        assert_null(figure_mark_of(&f.panel[0], 'l', "no period up to 20", 0));
        int told = 0;
        for (int m = 0; m < f.panel[0].mark_count; m++)
            told += strcmp(f.panel[0].mark[m].text, "undecided") == 0;
        assert_int_equal(told, 1);
        figure_free(&f);
    }
}

/* The distance from each place to the nearest of another kind, or off the map: the least sum of steps to the
 * eight neighbours, of which a vertical one counts `tall` and a horizontal one 1. */
static void measure_room(const unsigned *kind, int wide, int high, double tall, double *room) {
    for (int k = 0; k < wide * high; k++)
        room[k] = INFINITY;
    for (bool changed = true; changed;) {
        changed = false;
        for (int n = 0; n < 2 * wide * high; n++) {
            int k = n < wide * high ? n : 2 * wide * high - 1 - n;
            double least = room[k];
            for (int i = 0; i < 9; i++) {
                int x = k % wide + i % 3 - 1, y = k / wide + i / 3 - 1;
                bool same = x >= 0 && x < wide && y >= 0 && y < high && kind[y * wide + x] == kind[k];
                if (i != 4)
                    least = fmin(least, (same ? room[y * wide + x] : 0) + (i / 3 != 1 ? tall : 1));
            }
            changed = changed || least < room[k];
            room[k] = least;
        }
    }
}

/* The connected places around one, as marks in `region`; their number and middle. */
static int hang_together(const unsigned *kind, int wide, int high, int start, bool *region,
                         double middle[2]) {
    int count = 1, known = 0;
    memset(region, 0, (size_t)wide * (size_t)high * sizeof *region);
    region[start] = true;
    while (known != count) {
        known = count;
        for (int n = 0; n < 2 * wide * high; n++) {
            int k = n < wide * high ? n : 2 * wide * high - 1 - n, x = k % wide, y = k / wide;
            if (region[k] || kind[k] != kind[start])
                continue;
            region[k] = (x > 0 && region[k - 1]) || (x + 1 < wide && region[k + 1]) ||
                        (y > 0 && region[k - wide]) || (y + 1 < high && region[k + wide]);
            count += region[k];
        }
    }
    middle[0] = middle[1] = 0;
    for (int k = 0; k < wide * high; k++)
        if (region[k]) {
            middle[0] += (double)(k % wide) / count;
            middle[1] += (double)(k / wide) / count;
        }
    return count;
}

/* Regions of many shapes: bent, a ring, two parts, one cell, at the edges. */
static const char *const shapes[] = {"kaaaaaaaacccc", "abbbbbbbaaccc", "abdddddbaeecc",
                                     "abdbbbdbaeecc", "abdddddbaeeac", "abbbbbbbaeeaa",
                                     "aaaffaaaaeeag", "ahhhhhhhhhhag", "aaaaaaaaaaaag"};

static void fill_shapes(made_place *m) {
    int columns_here = (int)strlen(shapes[0]);
    char c = shapes[m->point / columns_here][m->point % columns_here];
    m->row[0] = c == 'g'   ? made_other(SALTUS_HELD)
                : c == 'd' ? made_other(SALTUS_CHAOTIC)
                : c == 'h' ? made_other(SALTUS_QUASIPERIODIC)
                : c == 'f' ? made_periodic(123, 7)
                : c == 'k' ? made_periodic(12345678, 17)
                           : made_periodic(1 + (c - 'a') / 3, 1 << (c - 'a') % 3);
}

/* The colour of one of these motions; a pixel may belong to the texture. */
static unsigned untextured(unsigned colour) {
    const saltus_paint paints[2] = {saltus_class_paint(SALTUS_PERIODIC, 123, 7),
                                    saltus_class_paint(SALTUS_PERIODIC, 12345678, 17)};
    for (int n = 0; n < 2 * 18 * 18; n++)
        if (saltus_paint_at(paints[n % 2], n / 2 % 18, n / 36) == colour)
            return paints[n % 2].colour;
    return colour;
}

/* A region's name is where it has most room, nearest to the region's middle, in letters as large as this room
 * allows within readable sizes; regions with less room have none. */
static void names_stand_where_there_is_most_room(void **state) {
    (void)state;
    enum { step = 4 };
    const double tall = 1.9, letter = 0.8, least = 10, most = 17;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2] = {
        {.key = "omega", .count = (int)strlen(shapes[0]), .low = 0.5, .high = 1.5},
        {.key = "d", .count = (int)(sizeof shapes / sizeof shapes[0]), .low = 1, .high = 2}};
    char path[path_size];
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_shapes, 1000);
    figure f = draw(&how, "s.png");
    const figure_panel *panel = &f.panel[0];
    const figure_element *e = figure_element_of(panel, "binary", 0);
    int wide = e->width / step, high = e->height / step, named = 0, unnamed = 0, smaller = 0;
    unsigned *kind = calloc((size_t)wide * (size_t)high, sizeof *kind);
    double *room = calloc((size_t)wide * (size_t)high, sizeof *room);
    bool *region = calloc((size_t)wide * (size_t)high, sizeof *region),
         *done = calloc((size_t)wide * (size_t)high, sizeof *done);
    assert_true(kind && room && region && done);
    for (int k = 0; k < wide * high; k++)
        kind[k] = untextured(figure_pixel(e, k % wide * step + step / 2, k / wide * step + step / 2, NULL));
    measure_room(kind, wide, high, tall, room);
    for (int start = 0; start < wide * high; start++) {
        double middle[2], widest = 0, nearest = INFINITY, at[2] = {0}, there = 0;
        const char *figures;
        if (done[start])
            continue;
        hang_together(kind, wide, high, start, region, middle);
        const char *text = entry_of(panel, kind[start], &figures)->text;
        for (int k = 0; k < wide * high; k++)
            if (region[k])
                widest = fmax(widest, room[k]);
        for (int k = 0; k < wide * high; k++) {
            double away = hypot(k % wide - middle[0], tall * ((int)(k / wide) - middle[1]));
            done[k] = done[k] || region[k];
            if (!region[k] || room[k] < 0.9 * widest - 1e-3 || away >= nearest - 1e-9)
                continue;
            nearest = away;
            there = room[k];
            at[0] = (k % wide + 0.5) / wide;
            at[1] = ((int)(k / wide) + 0.5) / high;
        }
        double size = 2 * step * there / (letter * ((double)strlen(text) + 0.6));
        bool nameless = strcmp(text, "held by the stop") == 0 || size < least;
        int found = 0;
        for (int m = 0; m < panel->mark_count; m++) {
            const figure_mark *mark = &panel->mark[m];
            if (mark->kind != 'l' || mark->system[0][0] != 'g')
                continue;
            int x = (int)(mark->place[0][0] * wide), y = (int)(mark->place[0][1] * high);
            if (!region[y * wide + x])
                continue;
            const char *font = strstr(mark->style, ":Bold,");
            found++;
            assert_string_equal(mark->text, text);
            check_near(mark->place[0][0], at[0], 1e-5);
            check_near(mark->place[0][1], at[1], 1e-5);
            assert_non_null(font);
            check_near(strtod(font + 6, NULL), fmin(most, size), 0.06);
        }
        assert_int_equal(found, !nameless);
        named += found;
        smaller += found && size < most;
        unnamed += !found;
    }
    assert_true(named > 5 && unnamed > 1 && smaller > 0);
    free(kind);
    free(room);
    free(region);
    free(done);
    figure_free(&f);
}

/* Numbers */

static double number_of(long long a, long long b) {
    return sin(1.7 * (double)a + 0.37 * (double)b + 0.2);
}

static void fill_numbers(made_place *m) {
    long long p = m->point;
    saltus_sweep_row *row = &m->row[0];
    *row = p == 3   ? made_other(SALTUS_FAILED)
           : p == 7 ? made_other(SALTUS_UNDECIDED)
                    : made_periodic(1, 1 + (int)(p % 5));
    row->settled = 1 + p * p * p;
    row->largest = number_of(p, 1);
    row->rms = number_of(p, 6);
    row->impact_rate = 3 + number_of(p, 2);
    row->largest_speed = 2 + number_of(p, 3);
    row->contact_fraction = 0.5 + 0.25 * number_of(p, 4);
    row->lyapunov = p == 11 ? -INFINITY : p == 17 ? NAN : 0.5 + number_of(p, 5);
}

static double number_shown(saltus_view view, const saltus_sweep_row *row) {
    if (row->verdict == SALTUS_FAILED)
        return NAN;
    return view == SALTUS_VIEW_LARGEST        ? row->largest
           : view == SALTUS_VIEW_RMS          ? row->rms
           : view == SALTUS_VIEW_SPEED        ? row->largest_speed
           : view == SALTUS_VIEW_RATE         ? row->impact_rate
           : view == SALTUS_VIEW_CONTACT      ? row->contact_fraction
           : view == SALTUS_VIEW_LYAPUNOV     ? row->lyapunov
           : row->verdict == SALTUS_UNDECIDED ? NAN
                                              : (double)row->settled;
}

/* The number of a colour, from the bar beside the map: the middle of its steps. */
static double read_bar(const figure_panel *bar, unsigned colour, double *width) {
    const figure_element *e = figure_element_of(bar, "binary", 0);
    int first = -1, last = -1;
    for (int y = 0; y < e->height; y++)
        if (figure_pixel(e, 0, y, NULL) == colour) {
            first = first < 0 ? y : first;
            last = y;
        }
    const double *range = bar->range[3];
    double part;
    if (first >= 0)
        part = (0.5 * (first + last) + 0.5) / e->height;
    else {
        /* If no step has it exactly, the nearest one. */
        double least = INFINITY;
        int nearest = 0;
        for (int y = 0; y < e->height; y++) {
            unsigned other = figure_pixel(e, 0, y, NULL);
            double away = 0;
            for (int c = 0; c < 24; c += 8)
                away += fabs((double)(other >> c & 0xff) - (double)(colour >> c & 0xff));
            nearest = away < least ? y : nearest;
            least = fmin(least, away);
        }
        assert_true(least < 6);
        part = (nearest + 0.5) / e->height;
        last = first = nearest;
    }
    *width = (2.0 + last - first) / e->height;
    return bar->logarithmic[3] ? range[0] * pow(range[1] / range[0], part)
                               : range[0] + part * (range[1] - range[0]);
}

static void check_numbers(const figure *f, const saltus_sweep_file *file, saltus_view view) {
    const figure_panel *panel = &f->panel[0], *bar = &f->panel[1];
    const figure_element *e = figure_element_of(panel, "binary", 0);
    long long *point = points_of(panel, e, file);
    unsigned colour[columns * rows];
    bool there[columns * rows] = {false};
    for (int n = 0; n < e->width * e->height; n++) {
        if (point[n] < 0)
            continue;
        unsigned own = figure_pixel(e, n % e->width, n / e->width, NULL);
        const bool failed = file->rows[point[n]].verdict == SALTUS_FAILED; /* has a texture */
        assert_true(!there[point[n]] || colour[point[n]] == own || failed);
        if (!failed || n == 0 || entry_of(panel, own, &(const char *){NULL}))
            colour[point[n]] = own;
        there[point[n]] = true;
    }
    free(point);
    const double *range = bar->range[3];
    for (int p = 0; p < columns * rows; p++) {
        const saltus_sweep_row *row = &file->rows[p];
        const char *figures;
        double number = number_shown(view, row), width;
        if (!there[p])
            continue;
        if (isnan(number)) {
            const figure_mark *words = entry_of(panel, colour[p], &figures);
            assert_string_equal(words ? words->text : "", row->verdict == SALTUS_FAILED  ? "failed"
                                                          : view == SALTUS_VIEW_LYAPUNOV ? "not measured"
                                                                                         : "no period found");
        } else if (isinf(number))
            assert_true(colour[p] == 0);
        else {
            double read = read_bar(bar, colour[p], &width), meant = fmin(fmax(number, range[0]), range[1]);
            if (bar->logarithmic[3])
                check_near(log(read), log(meant), width * log(range[1] / range[0]));
            else
                check_near(read, meant, width * (range[1] - range[0]));
        }
    }
}

/* Each number's colour is that of the bar at this number. */
static void colours_read_back_from_the_bar(void **state) {
    (void)state;
    static const char *const names[] = {[SALTUS_VIEW_LARGEST] = "largest displacement",
                                        [SALTUS_VIEW_RMS] = "root mean square of the",
                                        [SALTUS_VIEW_SPEED] = "largest impact speed",
                                        [SALTUS_VIEW_RATE] = "impacts per forcing period",
                                        [SALTUS_VIEW_CONTACT] = "part of the time in contact",
                                        [SALTUS_VIEW_LYAPUNOV] = "largest Lyapunov exponent",
                                        [SALTUS_VIEW_SETTLED] = "periods until settled"};
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2];
    char path[path_size];
    options.keep = SALTUS_KEEP_LYAPUNOV;
    make_axes(axes, SALTUS_LOGARITHMIC);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_numbers, 100);
    saltus_sweep_file file = made_read(path);
    for (saltus_view view = SALTUS_VIEW_LARGEST; view <= SALTUS_VIEW_SETTLED; view++) {
        saltus_sweep_view how = {.view = view};
        double low = INFINITY, high = -INFINITY;
        for (int p = 0; p < columns * rows; p++) {
            double number = number_shown(view, &file.rows[p]);
            low = isfinite(number) ? fmin(low, number) : low;
            high = isfinite(number) ? fmax(high, number) : high;
        }
        figure f = draw(&how, "s.png");
        assert_int_equal(f.panel_count, 2);
        check_numbers(&f, &file, view);
        assert_true(strstr(f.panel[1].label[2], names[view]) == f.panel[1].label[2]);
        assert_null(strstr(f.panel[1].label[2], "colours end"));
        check_near(f.panel[1].range[3][0], low, 1e-6 * fabs(low));
        check_near(f.panel[1].range[3][1], high, 1e-6 * fabs(high));
        assert_true(f.panel[1].logarithmic[3] == (view == SALTUS_VIEW_SETTLED));
        figure_free(&f);
        if (view == SALTUS_VIEW_LARGEST || view == SALTUS_VIEW_RATE || view == SALTUS_VIEW_CONTACT)
            continue;
        /* With a part of the range, numbers beyond it have the colours of its ends. */
        saltus_plot_part part = {.low = low + 0.2 * (high - low), .high = high - 0.3 * (high - low)};
        static const char *const words[] = {
            [SALTUS_VIEW_LARGEST] = "largest", [SALTUS_VIEW_SPEED] = "speed",
            [SALTUS_VIEW_RMS] = "rms",         [SALTUS_VIEW_RATE] = "rate",
            [SALTUS_VIEW_CONTACT] = "contact", [SALTUS_VIEW_LYAPUNOV] = "lyapunov",
            [SALTUS_VIEW_SETTLED] = "settled"};
        strcpy(part.key, words[view]);
        how.parts = &part;
        how.part_count = 1;
        f = draw(&how, "s.png");
        check_numbers(&f, &file, view);
        check_near(f.panel[1].range[3][0], part.low, 1e-6 * fabs(part.low));
        check_near(f.panel[1].range[3][1], part.high, 1e-6 * fabs(part.high));
        assert_non_null(strstr(f.panel[1].label[2], "(colours end at the range)"));
        assert_true(f.panel[1].logarithmic[3] == (view == SALTUS_VIEW_SETTLED));
        figure_free(&f);
        /* From zero on equal ratios are impossible. */
        part.low = 0;
        f = draw(&how, "s.png");
        assert_false(f.panel[1].logarithmic[3]);
        figure_free(&f);
    }
    saltus_sweep_file_clear(&file);
}

static void fill_some_apart(made_place *m) {
    fill_numbers(m);
    if (m->point % 3 == 1)
        m->row[0].contact_fraction = 0;
}

/* Numbers at or below 0, which logarithmic colours do not reach, are counted. */
static void what_has_no_logarithm_is_counted(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CONTACT};
    saltus_axis axes[2];
    char path[path_size], said[64];
    int below = 0;
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_some_apart, 100);
    saltus_sweep_file file = made_read(path);
    for (int p = 0; p < columns * rows; p++)
        below += number_shown(how.view, &file.rows[p]) <= 0;
    assert_true(below > 0);
    how.look.logarithmic = (const char *const[]){"contact"};
    how.look.logarithmic_count = 1;
    figure f = draw(&how, "s.png");
    assert_true(f.panel[1].logarithmic[3]);
    snprintf(said, sizeof said, "at or below 0, so in the lowest colour: %d", below);
    figure_says(&f, said);
    figure_free(&f);
    saltus_sweep_file_clear(&file);
}

/* Exponents have zero in the middle: the palest step of the bar. */
static void zero_is_the_palest_of_exponents(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_LYAPUNOV};
    saltus_axis axes[2];
    char path[path_size];
    options.keep = SALTUS_KEEP_LYAPUNOV;
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_numbers, 100);
    figure f = draw(&how, "s.png");
    const figure_element *e = figure_element_of(&f.panel[1], "binary", 0);
    const double *range = f.panel[1].range[3];
    double palest = 0, at = 0;
    for (int y = 0; y < e->height; y++)
        if (luminance(figure_pixel(e, 0, y, NULL)) > palest) {
            palest = luminance(figure_pixel(e, 0, y, NULL));
            at = range[0] + (y + 0.5) / e->height * (range[1] - range[0]);
        }
    check_near(at, 0, 0.01 * (range[1] - range[0]));
    assert_true(luminance(figure_pixel(e, 0, 0, NULL)) < 120 &&
                luminance(figure_pixel(e, 0, e->height - 1, NULL)) < 120);
    figure_says(&f, "black: all directions lost");
    figure_free(&f);
}

/* The bar shows that its colours end exactly if a number is beyond it. */
static void cut_ranges_say_so(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_plot_part part = {"speed", 0, 0};
    saltus_sweep_view how = {.view = SALTUS_VIEW_SPEED, .parts = &part, .part_count = 1};
    saltus_axis axes[2];
    char path[path_size];
    double most = -INFINITY, least = INFINITY;
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_numbers, 100);
    saltus_sweep_file file = made_read(path);
    for (int p = 0; p < columns * rows; p++)
        if (file.rows[p].verdict != SALTUS_FAILED) {
            most = fmax(most, file.rows[p].largest_speed);
            least = fmin(least, file.rows[p].largest_speed);
        }
    for (int cut = 0; cut < 3; cut++) {
        part.low = least + (cut == 1 ? 1e-4 : -1e-4);
        part.high = most + (cut == 2 ? -1e-4 : 1e-4);
        figure f = draw(&how, "s.png");
        assert_true((strstr(f.panel[1].label[2], "colours end") != NULL) == (cut > 0));
        figure_free(&f);
    }
    saltus_sweep_file_clear(&file);
}

/* In one column a long name of the bar has two lines, for which there is room beside its numbers. */
static void names_of_bars_stay_on_the_page(void **state) {
    (void)state;
    const double letter = 9.8, bar_and_tics = 15, line = 22;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2];
    char path[path_size], out[path_size];
    options.keep = SALTUS_KEEP_LYAPUNOV;
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_numbers, 100);
    for (int long_name = 0; long_name < 2; long_name++) {
        const saltus_sweep_view how = {.view = long_name ? SALTUS_VIEW_LYAPUNOV : SALTUS_VIEW_SETTLED,
                                       .look = {.width = 85}};
        saltus_message message = {.text = ""};
        check_ok(saltus_plot_sweep(path_in("s.svg", out), path, &how, &message), &message);
        figure f = figure_taken(folder);
        const char *title = figure_command(&f, "set y2label", 0);
        const bool two_lines = strstr(title, ".\"\\n\".") != NULL;
        const double *range = f.panel[1].range[3];
        const size_t letters = saltus_page_tic_letters(
            (saltus_range){range[0], range[1]}, saltus_page_tic_step((saltus_range){range[0], range[1]}, 5));
        assert_true(two_lines == long_name);
        assert_true((1 - f.panel[1].frame[1]) * 522 >
                    bar_and_tics + letter * (double)letters + line * (1 + two_lines));
        figure_free(&f);
    }
}

/* Single numbers far from all others do not stretch the colours; nearer ones do. */
static double outlier;

static void fill_outlier(made_place *m) {
    m->row[0] = made_periodic(1, 1);
    m->row[0].largest = m->point == 100 ? outlier : m->point == 200 ? -outlier : number_of(m->point, 1);
}

static void far_numbers_do_not_stretch_the_colours(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_LARGEST};
    saltus_axis axes[2] = {{.key = "omega", .count = 21, .low = 0.5, .high = 1.5},
                           {.key = "d", .count = 20, .low = 1, .high = 2}};
    char path[path_size];
    for (int far = 0; far < 2; far++) {
        outlier = far ? 2.2 : 1.8; /* half the width beyond the end is at 2 */
        made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_outlier, 1000);
        figure f = draw(&how, "s.png");
        check_near(f.panel[1].range[3][0], far ? -1 : -outlier, 1e-2);
        check_near(f.panel[1].range[3][1], far ? 1 : outlier, 1e-2);
        assert_true((strstr(f.panel[1].label[2], "percentiles") != NULL) == far);
        /* Absent kinds are not explained. */
        assert_true(!figure_mark_of(&f.panel[0], 'l', "failed", 0) &&
                    !figure_mark_of(&f.panel[0], 'l', "not computed", 0) &&
                    !figure_mark_of(&f.panel[0], 'l', "no period found", 0));
        figure_free(&f);
    }
}

/* With more values than pixels a pixel shows its most frequent motion. */
enum { fine = 5400 };

static void fill_fine(made_place *m) {
    m->row[0] = made_periodic(1, m->point % fine % 11 < 5 ? 2 : 1);
}

static void a_pixel_shows_what_most_of_its_cells_are(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    saltus_axis axes[2] = {{.key = "omega", .count = fine, .low = 0.5, .high = 1.5},
                           {.key = "d", .count = 1, .low = 1, .high = 1}};
    char path[path_size];
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_fine, 2 * fine);
    figure f = draw(&how, "s.png");
    const figure_panel *panel = &f.panel[0];
    const figure_element *e = figure_element_of(panel, "binary", 0);
    unsigned colour[2] = {0};
    int asked = 0;
    for (int x = 0; x < e->width; x++) {
        int count[2] = {0};
        double low = panel->range[0][0], width = (panel->range[0][1] - low) / e->width;
        for (int k = (int)floor((double)x / e->width * fine) - 2; k < (x + 1.0) / e->width * fine + 2; k++) {
            double value = 0.5 + k / (fine - 1.0);
            if (k >= 0 && k < fine && value >= low + x * width && value < low + (x + 1) * width)
                count[k % 11 < 5]++;
        }
        if (abs(count[0] - count[1]) < 2)
            continue;
        unsigned own = figure_pixel(e, x, e->height / 2, NULL);
        int most = count[1] > count[0];
        assert_true(!colour[most] || colour[most] == own);
        colour[most] = own;
        asked++;
    }
    assert_true(asked > 300 && colour[0] && colour[0] != colour[1]);
    figure_free(&f);
}

/* ... and the mean of the numbers, without cells that have none. */
static void fill_fine_numbers(made_place *m) {
    long long k = m->point % fine;
    m->row[0] = made_periodic(1, 1);
    m->row[0].largest = k % 7 == 3 ? 4 : (double)(k % 5);
    if (k % 13 == 6 || (k > 2000 && k < 2100))
        m->row[0] = made_other(SALTUS_FAILED);
}

static void a_pixel_shows_the_mean_of_its_cells(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_LARGEST};
    saltus_axis axes[2] = {{.key = "omega", .count = fine, .low = 0.5, .high = 1.5},
                           {.key = "d", .count = 1, .low = 1, .high = 1}};
    char path[path_size];
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_fine_numbers, 2 * fine);
    saltus_sweep_file file = made_read(path);
    figure f = draw(&how, "s.png");
    const figure_panel *panel = &f.panel[0], *bar = &f.panel[1];
    const figure_element *e = figure_element_of(panel, "binary", 0);
    int asked = 0, nothing = 0;
    for (int x = 0; x < e->width; x++) {
        double low = panel->range[0][0], wide = (panel->range[0][1] - low) / e->width, sum = 0, width;
        int count = 0;
        bool clear = true;
        for (int k = (int)floor((double)x / e->width * fine) - 2; k < (x + 1.0) / e->width * fine + 2; k++) {
            double place = (0.5 + k / (fine - 1.0) - low) / wide - x;
            if (k < 0 || k >= fine)
                continue;
            clear = clear && fabs(place) > 1e-6 && fabs(place - 1) > 1e-6;
            if (place < 0 || place >= 1 || file.rows[k].verdict == SALTUS_FAILED)
                continue;
            sum += file.rows[k].largest;
            count++;
        }
        unsigned colour = figure_pixel(e, x, e->height / 2, NULL);
        if (!clear)
            continue;
        if (!count) {
            const char *figures;
            const figure_mark *words = entry_of(panel, colour, &figures);
            assert_string_equal(words ? words->text : "", "failed");
            nothing++;
            continue;
        }
        double read = read_bar(bar, colour, &width), wanted = sum / count;
        check_near(read, wanted, width * (bar->range[3][1] - bar->range[3][0]));
        asked++;
    }
    assert_true(asked > 1000 && nothing > 10);
    figure_free(&f);
    saltus_sweep_file_clear(&file);
}

/* Basins: the colour of a start is that of its attractor, whose orbit is drawn there as dots; paler if
 * reached sooner. */
static void check_basins(const char *omega, const char *d, bool shaded) {
    char path[path_size], command[700];
    path_in("s.h5", path);
    remove(path);
    snprintf(
        command, sizeof command,
        "cd %s && printf 'model: oscillator\\nc: 0.05\\nF: 1\\nomega: %s\\nstop: {d: %s, r: 0.9}\\n' "
        ">scene.yaml && '%s' basins scene.yaml --over q1=-1:0.35:8 --over v1=-2:2:6 -o s.h5 --quiet >out",
        folder, omega, d, SALTUS_COMMAND);
    assert_int_equal(system(command), 0);
    saltus_sweep_file file = made_read(path);
    assert_true(file.attractor_count >= 2);
    saltus_sweep_view how = {.view = SALTUS_VIEW_CLASS};
    figure classes = draw(&how, "s.png");
    how.view = SALTUS_VIEW_AUTOMATIC;
    figure f = draw(&how, "s.png");
    const figure_panel *panel = &f.panel[0];
    const figure_element *e = figure_element_of(panel, "binary", 0);
    unsigned own[8] = {0};
    for (int k = 0; k < file.attractor_count; k++) {
        char name[32], expected[48];
        const char *figures;
        snprintf(name, sizeof name, "$orbit_%d", k);
        const figure_element *rim = figure_element_of(panel, name, 0),
                             *dots = figure_element_of(panel, name, 1);
        assert_true(rim && dots && k < 8);
        own[k] = (unsigned)figure_colour(dots->style);
        /* The motion's colour in every figure; of two attractors with one motion the later is darker. */
        snprintf(expected, sizeof expected, "%s%s", file.attractor_label[k],
                 strncmp(file.attractor_label[k], "0/", 2) == 0 ? "  no impact" : "");
        long everywhere = colour_in(&classes.panel[0], expected);
        int twins = 0;
        for (int j = 0; j < k; j++)
            twins += strcmp(file.attractor_label[j], file.attractor_label[k]) == 0;
        assert_true(everywhere >= 0 && (twins ? luminance(own[k]) < luminance((unsigned)everywhere)
                                              : own[k] == (unsigned)everywhere));
        const figure_mark *words = entry_of(panel, own[k], &figures);
        assert_non_null(words);
        assert_string_equal(words->text, file.attractor_label[k]);
        int count = 0;
        for (long long row = 0; row < file.row_count; row++)
            count += file.rows[row].attractor == k;
        double share = 100.0 * count / (double)file.row_count;
        snprintf(expected, sizeof expected, "|{/:Italic μ}| = %.3g,  %.*f %%", file.attractor_multiplier[k],
                 share < 9.95, share);
        assert_string_equal(figures, expected);
        assert_int_equal(dots->values.count, file.attractor_points[k]);
        assert_int_equal(rim->values.count, file.attractor_points[k]);
        for (int p = 0; p < dots->values.count; p++)
            for (int i = 0; i < 2; i++)
                figure_near(dots->values.at[p][i],
                            file.attractor_states[(file.attractor_first[k] + p) * file.dimension + i], 1e-8);
        for (int j = 0; j < k; j++)
            assert_true(own[j] != own[k]);
    }
    long long *point = points_of(panel, e, &file);
    double paleness[64];
    int pixels[2] = {0};
    for (int n = 0; n < 64; n++)
        paleness[n] = -1;
    for (int n = 0; n < e->width * e->height; n += 53) {
        if (point[n] < 0)
            continue;
        const saltus_sweep_row *row = &file.rows[point[n]];
        unsigned colour = figure_pixel(e, n % e->width, n / e->width, NULL);
        if (row->attractor < 0) {
            /* A start beyond the stop has its own look. */
            double start = file.axes[0].list[point[n] % file.axes[0].count];
            bool beyond = start > file.spec.stops[0].d;
            assert_true((row->verdict == SALTUS_BEYOND) == beyond);
            assert_true(beyond                          ? luminance(colour) > 180
                        : row->verdict == SALTUS_FAILED ? colour == 0xff2d78
                                                        : colour == nothing_colour);
            continue;
        }
        /* Mixed with white: the same share for all three channels. */
        double part[3] = {0}, mean = 0;
        int told = 0; /* by channels that are not nearly full */
        for (int c = 0; c < 3; c++) {
            double full = own[row->attractor] >> (8 * c) & 0xff;
            if (full > 240)
                continue;
            part[told] = ((colour >> (8 * c) & 0xff) - full) / (255 - full);
            mean += part[told++];
        }
        mean /= told;
        bool plain = mean > -0.04;
        for (int c = 0; c < told; c++)
            plain = plain && fabs(part[c] - mean) < 0.03;
        pixels[plain]++; /* others are of a texture */
        if (plain)
            paleness[point[n]] = mean;
    }
    assert_true(pixels[1] > 2 * pixels[0]);
    double palest = 0, fullest = 1;
    for (int a = 0; a < 48; a++)
        if (paleness[a] >= 0) {
            palest = fmax(palest, paleness[a]);
            fullest = fmin(fullest, paleness[a]);
        }
    assert_true((shaded ? palest > 0.3 && palest < 0.6 : palest < 0.02) && fullest < 0.02);
    assert_true((figure_mark_of(panel, 'l', "pale: soon settled", 0) != NULL) == shaded);
    for (int a = 0; a < 48 && shaded; a++)
        for (int b = 0; b < 48; b++)
            if (paleness[a] >= 0 && paleness[b] >= 0 &&
                file.rows[a].settled > 1.1 * (double)file.rows[b].settled)
                assert_true(paleness[a] < paleness[b] + 0.01);
    assert_non_null(strstr(panel->label[0], "initial displacement  {/:Italic q}_{1}"));
    assert_non_null(strstr(panel->label[1], "initial velocity  {/:Italic q}′_{1}"));
    assert_non_null(figure_mark_of(panel, 'l', "dots: the orbits at phase 0", 0));
    /* In one column the notes stand in one line below the legend, on the page. */
    how.look.width = 85;
    saltus_message message = {.text = ""};
    char out[path_size];
    check_ok(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), &message);
    figure column = figure_taken(folder);
    const figure_mark *note = figure_mark_of(&column.panel[0], 'l', "dots: the orbits at phase 0", 0);
    assert_true(note && (strstr(note->text, "pale: soon settled") != NULL) == shaded);
    assert_true(note->place[0][0] > 0 && note->place[0][1] > 0);
    for (int m = 0; m < column.panel[0].mark_count; m++) {
        const figure_mark *other = &column.panel[0].mark[m];
        assert_true(other == note || other->kind != 'l' || other->system[0][1] != 's' ||
                    other->place[0][1] > note->place[0][1]);
    }
    figure_free(&column);
    free(point);
    figure_free(&f);
    figure_free(&classes);
    saltus_sweep_file_clear(&file);
    remove(path);
}

/* Shades show how soon a start settles, unless motions of one period, with similar colours, would be
 * confused. */
static void basins_show_where_each_start_goes(void **state) {
    (void)state;
    check_basins("2.8", "0.2", false);
    check_basins("2.2", "0.5", true);
}

/* Over the force of a Maxwell element the orbits' points are at that force. */
static void forces_have_their_axis(void **state) {
    (void)state;
    char path[path_size], command[700];
    path_in("s.h5", path);
    snprintf(command, sizeof command,
             "cd %s && '%s' basins impact-oscillator --set kz=0.5 tz=0.25 --over z1=0:1:3 --over v1=-1:1:3 "
             "-o s.h5 --quiet >out",
             folder, SALTUS_COMMAND);
    assert_int_equal(system(command), 0);
    saltus_sweep_file file = made_read(path);
    assert_true(file.attractor_count >= 1 && file.dimension == 3);
    saltus_sweep_view how = {.view = SALTUS_VIEW_AUTOMATIC};
    figure f = draw(&how, "z.svg");
    const figure_element *dots = figure_element_of(&f.panel[0], "$orbit_0", 1);
    assert_true(dots && dots->values.count == file.attractor_points[0]);
    for (int p = 0; p < dots->values.count; p++) {
        const double *orbit = file.attractor_states + (file.attractor_first[0] + p) * 3;
        figure_near(dots->values.at[p][0], orbit[2], 1e-8);
        figure_near(dots->values.at[p][1], orbit[1], 1e-8);
    }
    assert_non_null(strstr(f.panel[0].label[0], "initial force  {/:Italic z}_{1}"));
    assert_non_null(strstr(f.panel[0].label[1], "initial velocity  {/:Italic q}′_{1}"));
    figure_free(&f);
    saltus_sweep_file_clear(&file);
    remove(path);
}

static void fill_nothing(made_place *m) {
    m->row[0] = made_periodic(0, 1);
}

/* Where nothing is anywhere in contact the colours begin at zero, and the bar's name is on the page. */
static void nothing_is_the_begin_of_a_range(void **state) {
    (void)state;
    saltus_scene scene = made_scene();
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2];
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    make_axes(axes, SALTUS_LINEAR);
    made_write(path_in("s.h5", path), &scene, axes, 2, &options, fill_nothing, 100);
    for (int sized = 0; sized < 2; sized++) {
        const saltus_sweep_view how = {.view = SALTUS_VIEW_CONTACT, .look = {.width = sized ? 85 : 0}};
        check_ok(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), &message);
        figure f = figure_taken(folder);
        assert_true(f.panel[1].range[3][0] == 0 && f.panel[1].range[3][1] == 1);
        assert_true((1 - f.panel[1].frame[1]) * (sized ? 522 : 1600) > 100);
        figure_free(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_cell_has_the_colour_of_its_class),
        cmocka_unit_test(shades_tell_period_and_impacts),
        cmocka_unit_test(the_motion_of_most_starts_is_shown),
        cmocka_unit_test(starts_without_a_motion_hide_none),
        cmocka_unit_test(passes_that_differ_are_two_attractors),
        cmocka_unit_test(names_stand_in_their_regions),
        cmocka_unit_test(the_rarest_chaos_keeps_its_entry),
        cmocka_unit_test(motions_look_different_without_red),
        cmocka_unit_test(a_motion_has_one_colour),
        cmocka_unit_test(each_motion_has_its_own_paint),
        cmocka_unit_test(a_part_explains_what_it_shows),
        cmocka_unit_test(shares_have_two_digits),
        cmocka_unit_test(undecided_is_called_so),
        cmocka_unit_test(names_stand_where_there_is_most_room),
        cmocka_unit_test(colours_read_back_from_the_bar),
        cmocka_unit_test(what_has_no_logarithm_is_counted),
        cmocka_unit_test(zero_is_the_palest_of_exponents),
        cmocka_unit_test(cut_ranges_say_so),
        cmocka_unit_test(names_of_bars_stay_on_the_page),
        cmocka_unit_test(nothing_is_the_begin_of_a_range),
        cmocka_unit_test(far_numbers_do_not_stretch_the_colours),
        cmocka_unit_test(a_pixel_shows_what_most_of_its_cells_are),
        cmocka_unit_test(a_pixel_shows_the_mean_of_its_cells),
        cmocka_unit_test(basins_show_where_each_start_goes),
        cmocka_unit_test(forces_have_their_axis),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
