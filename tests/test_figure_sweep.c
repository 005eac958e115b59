/* Diagrams of sweeps over one axis draw the rows and clouds of their files: points, numbers, exponents and
 * the strip of classes. The sweeps are made up, so that every kind of row occurs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"
#include "figure_folder.h"
#include "made_sweep.h"

static const double digits = 1e-6; /* points are written with seven digits */

static saltus_scene scene_of(double d, saltus_sides sides) {
    saltus_scene scene = {.spec = oscillator_spec(0.125, 1.75, 1.5, 0.625), .initial_count = 0};
    add_stop(&scene.spec, d, 0.75, sides);
    strcpy(scene.name, "made_up");
    return scene;
}

static figure draw(const char *name, const saltus_sweep_view *view, const char *picture) {
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    check_ok(saltus_plot_sweep(path_in(picture, out), path_in(name, path), view, &message), &message);
    figure f = figure_taken(folder);
    figure_check_page(&f);
    return f;
}

/* Ranks of a file's points by increasing value of the axis. */
static void sort_points(const saltus_sweep_file *file, int *order) {
    for (int k = 0; k < file->axes[0].count; k++) {
        int rank = 0;
        for (int j = 0; j < file->axes[0].count; j++)
            rank += file->axes[0].list[j] < file->axes[0].list[k];
        order[rank] = k;
    }
}

static long long row_at(const saltus_sweep_file *file, int pass, int point, int seed) {
    return (pass * file->points + point) * file->options.seeds + seed;
}

/* The drawn element of a pass: the one with its legend colour. */
static const figure_element *element_of_pass(const figure_panel *panel, const saltus_sweep_file *file,
                                             int pass, const char *kind) {
    static const char *const words[] = {[SALTUS_PASS_RESET] = "from the initial state",
                                        [SALTUS_PASS_UP] = "upwards",
                                        [SALTUS_PASS_DOWN] = "downwards"};
    if (file->pass_count == 1)
        return figure_element_of(panel, kind, 0);
    const figure_element *entry = NULL, *found = NULL;
    for (int e = 0; e < panel->element_count; e++)
        if (strcmp(panel->element[e].title, words[file->passes[pass]]) == 0)
            entry = &panel->element[e];
    for (int k = 0; entry && (found = figure_element_of(panel, kind, k)) != NULL; k++)
        if ((figure_colour(found->style) & 0xffffff) == figure_colour(entry->style))
            return found;
    fail_msg("no points in the colour of '%s'", words[file->passes[pass]]);
    return NULL;
}

/* Clouds */

static double number_of(long long a, long long b) {
    return 0.03 * sin(1.7 * (double)a + 0.37 * (double)b + 0.2);
}

static void fill_clouds(made_place *m) {
    int turning = 0, impacts = 0, strobes = 0;
    for (int s = 0; s < m->seeds; s++) {
        m->row[s] = made_periodic(1 + (int)(m->point % 2), 1 + s);
        m->turning_count[s] = (m->point + s) % 4;
        m->impact_count[s] = (m->point + 2 * s) % 3;
        m->strobe_count[s] = 1 + s;
        for (int k = 0; k < m->turning_count[s]; k++)
            m->turning[turning++] = number_of(m->place, k + 10 * s);
        for (int k = 0; k < m->impact_count[s]; k++)
            m->impact[impacts++] = (saltus_sweep_impact){0.1 * k, 1 + number_of(m->place, k + 20 * s), 0};
        for (int k = 0; k < m->strobe_count[s]; k++)
            for (int i = 0; i < m->dimension; i++)
                m->strobe[strobes++] = number_of(m->place, k + 30 * s + 100 * i);
    }
}

static saltus_sweep_options cloud_options(void) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC;
    options.passes = 7;
    options.seeds = 2;
    return options;
}

static long long cloud_size(const saltus_sweep_file *file, saltus_view view, long long row) {
    return view == SALTUS_VIEW_TURNING   ? file->turning_count[row]
           : view == SALTUS_VIEW_IMPACTS ? file->impact_count[row]
                                         : file->strobe_count[row];
}

static double cloud_number(const saltus_sweep_file *file, saltus_view view, long long row, long long k) {
    return view == SALTUS_VIEW_TURNING   ? file->turning[file->turning_first[row] + k]
           : view == SALTUS_VIEW_IMPACTS ? file->impacts[file->impact_first[row] + k].speed
                                         : file->strobes[(file->strobe_first[row] + k) * file->dimension];
}

/* Exactly the points of a view, pass by pass, for the requested rows and values. */
static void check_cloud(const figure *f, const saltus_sweep_file *file, saltus_view view,
                        const double across[2], const double up[2]) {
    const figure_panel *panel = &f->panel[0];
    int order[64];
    sort_points(file, order);
    for (int pass = 0; pass < file->pass_count; pass++) {
        const figure_element *e = element_of_pass(panel, file, pass, "$cloud");
        int at = 0;
        for (int k = 0; k < file->points; k++)
            for (int s = 0; s < file->options.seeds; s++) {
                double x = file->axes[0].list[order[k]];
                long long row = row_at(file, pass, order[k], s);
                for (long long i = 0; i < cloud_size(file, view, row); i++) {
                    double y = cloud_number(file, view, row, i);
                    if (x < across[0] || x > across[1] || y < up[0] || y > up[1])
                        continue;
                    assert_true(at < e->values.count);
                    figure_near(e->values.at[at][0], x, digits);
                    figure_near(e->values.at[at++][1], y, digits);
                }
            }
        assert_int_equal(at, e->values.count);
        figure_check_inside(panel, e);
    }
}

static const double everything[2] = {-INFINITY, INFINITY};

/* The clouds of three passes, over an axis with unordered values. */
static void clouds_are_those_of_the_file(void **state) {
    (void)state;
    static const double values[] = {0.9, 0.5, 1.5, 0.75, 0.6};
    static const char *const names[] = {[SALTUS_VIEW_TURNING] = "displacement {/:Italic x}_1  where it turns",
                                        [SALTUS_VIEW_IMPACTS] = "speed of every impact",
                                        [SALTUS_VIEW_STROBOSCOPIC] =
                                            "displacement {/:Italic x}_1  at phase 0"};
    saltus_axis axis = {
        .key = "omega", .spacing = SALTUS_LIST, .count = 5, .low = 0.9, .high = 0.6, .list = values};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = cloud_options();
    char path[path_size];
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_clouds, 100);
    saltus_sweep_file file = made_read(path);
    for (saltus_view view = SALTUS_VIEW_TURNING; view <= SALTUS_VIEW_STROBOSCOPIC; view++) {
        saltus_sweep_view how = {.view = view};
        figure f = draw("s.h5", &how, "s.png");
        check_cloud(&f, &file, view, everything, everything);
        assert_string_equal(f.panel[0].label[1][0] ? f.panel[0].label[1] : "",
                            view == SALTUS_VIEW_IMPACTS ? f.panel[0].label[1] : names[view]);
        assert_non_null(strstr(f.panel[0].label[1], names[view]));
        /* No more room than the points need; an axis of speeds well above zero does not begin there. */
        assert_true(f.panel[0].range[1][1] - f.panel[0].range[1][0] < 0.07);
        assert_true(f.panel[1].label[0][0] && strstr(f.panel[1].label[0], "{/:Italic ω}"));
        figure_free(&f);
        const saltus_plot_part parts[] = {{"omega", 0.55, 0.9}, {"", -0.0123, 1.0123}};
        saltus_plot_part both[2] = {parts[0], parts[1]};
        strcpy(both[1].key, view == SALTUS_VIEW_TURNING   ? "turning"
                            : view == SALTUS_VIEW_IMPACTS ? "impacts"
                                                          : "stroboscopic");
        how.parts = both;
        how.part_count = 2;
        f = draw("s.h5", &how, "s.png");
        check_cloud(&f, &file, view, (const double[2]){0.55, 0.9}, (const double[2]){-0.0123, 1.0123});
        assert_true(f.panel[0].range[0][0] == 0.55 && f.panel[0].range[0][1] == 0.9);
        assert_true(f.panel[0].range[1][0] == -0.0123 && f.panel[0].range[1][1] == 1.0123);
        figure_free(&f);
        how.part_count = 1;
        f = draw("s.h5", &how, "s.png");
        check_cloud(&f, &file, view, (const double[2]){0.55, 0.9}, everything);
        int shown = 0;
        char words[64];
        for (int k = 0; k < file.axes[0].count; k++)
            shown += file.axes[0].list[k] >= 0.55 && file.axes[0].list[k] <= 0.9;
        snprintf(words, sizeof words, "%d of %d values of ", shown, file.axes[0].count);
        assert_true(shown > 0 && shown < file.axes[0].count);
        figure_says(&f, words);
        figure_free(&f);
    }
    saltus_sweep_file_clear(&file);
}

/* The caption states the fixed parameters, the number of values and how they were reached. */
static void captions_tell_how_the_sweep_was_made(void **state) {
    (void)state;
    saltus_axis axis = {.key = "omega", .count = 8, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(0.25, SALTUS_BOTH);
    saltus_sweep_options options = cloud_options();
    char path[path_size], text[8000];
    options.transient = 123;
    options.record = 45;
    for (int k = 0; k < 4; k++) {
        options.passes = k == 0 ? 7 : k == 1 ? 6 : k == 2 ? 4 : 1;
        options.seeds = k == 3 ? 3 : 1;
        options.adaptive = k != 1;
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_clouds, k == 2 ? 4 : 100);
        saltus_sweep_view how = {.view = k == 0 ? SALTUS_VIEW_TURNING : SALTUS_VIEW_AUTOMATIC,
                                 .look.title = k == 3 ? "own_title" : NULL};
        figure f = draw("s.h5", &how, "s.png");
        figure_says(&f, k == 3 ? "own\\_title" : "made\\_up:  displacement diagram in {/:Italic ω}");
        figure_says(&f, "{/:Italic c} = 0.125");
        figure_says(&f, "{/:Italic k} = 1.75");
        figure_says(&f, "stop: {/:Italic d} = 0.25, {/:Italic r} = 0.75, both sides");
        figure_says(&f, "8 values of {/:Italic ω}");
        figure_says(&f, k == 0   ? ", each from the initial state and carried up and down;"
                        : k == 1 ? ", carried up and down;"
                        : k == 2 ? ", carried down;"
                                 : ", each from 3 initial states;");
        figure_says(&f, k == 1 ? "recorded: 45 periods after 123"
                               : "recorded: one orbit, or 45 periods where no period is found after 123");
        figure_caption(&f, text, sizeof text);
        assert_null(strstr(text, "{/:Italic ω} ="));
        assert_true((strstr(text, "(interrupted: 50 % done)") != NULL) == (k == 2));
        figure_free(&f);
    }
}

/* Impacts on both sides keep their signs, those on one side are speeds. */
static void fill_signed(made_place *m) {
    m->row[0] = made_periodic(2, 1);
    m->impact_count[0] = 2;
    m->impact[0] = (saltus_sweep_impact){0.1, -1 - number_of(m->place, 1), 1};
    m->impact[1] = (saltus_sweep_impact){0.6, m->pass == SALTUS_PASS_UP ? -0.5 : 0.5, 0};
}

static void impacts_on_two_sides_keep_their_signs(void **state) {
    (void)state;
    saltus_axis axis = {.key = "omega", .count = 4, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(0.25, SALTUS_BOTH);
    saltus_sweep_options options = cloud_options();
    saltus_sweep_view how = {.view = SALTUS_VIEW_IMPACTS};
    char path[path_size];
    options.seeds = 1;
    for (int one = 0; one < 2; one++) {
        options.passes = one ? 1 << SALTUS_PASS_UP : 1;
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_signed, 100);
        figure f = draw("s.h5", &how, "s.png");
        const figure_element *e = figure_element_of(&f.panel[0], "$cloud", 0);
        assert_int_equal(e->values.count, 8);
        for (int k = 0; k < 4; k++) {
            double v = 1 + number_of(k, 1);
            figure_near(e->values.at[2 * k][1], one ? v : -v, digits);
            figure_near(e->values.at[2 * k + 1][1], 0.5, digits);
        }
        assert_true((f.panel[0].range[1][0] < 0) == !one);
        assert_non_null(strstr(f.panel[0].label[1], one ? "speed of every impact" : "velocity at impact"));
        figure_free(&f);
    }
}

/* If the place of a pipe's stop varies, so does the observed coordinate. */
static void fill_modes(made_place *m) {
    m->row[0] = made_periodic(0, 1);
    m->strobe_count[0] = 2;
    for (int k = 0; k < 2 * m->dimension; k++)
        m->strobe[k] = number_of(m->place, k);
}

static void sections_of_a_moving_stop_are_observed_at_it(void **state) {
    (void)state;
    enum { modes = 3, count = 5 };
    saltus_axis axis = {.key = "xi", .count = count, .low = 0.1, .high = 0.8};
    saltus_scene scene = {.spec = pipe_spec(modes, 20)};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep_view how = {.view = SALTUS_VIEW_STROBOSCOPIC};
    char path[path_size];
    add_stop(&scene.spec, 0.03, 0.75, SALTUS_UPPER);
    options.keep = SALTUS_KEEP_STROBOSCOPIC;
    options.passes = 3;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_modes, 100);
    saltus_sweep_file file = made_read(path);
    figure f = draw("s.h5", &how, "s.png");
    for (int pass = 0; pass < 2; pass++) {
        const figure_element *e = element_of_pass(&f.panel[0], &file, pass, "$cloud");
        assert_int_equal(e->values.count, 2 * count);
        for (int k = 0; k < 2 * count; k++) {
            double xi = file.axes[0].list[k / 2], eta = 0;
            for (int i = 0; i < modes; i++)
                eta +=
                    number_of(pass * count + k / 2, k % 2 * 2 * modes + i) * sin((i + 1) * acos(-1.0) * xi);
            figure_near(e->values.at[k][0], xi, digits);
            check_near(e->values.at[k][1], eta, 1e-7);
        }
    }
    assert_non_null(strstr(f.panel[0].label[1], "{/:Italic ξ}"));
    figure_free(&f);
    saltus_sweep_file_clear(&file);
}

/* Stops */

static void fill_near_stops(made_place *m) {
    m->row[0] = made_periodic(0, 1);
    m->row[0].largest = 0.2;
    m->turning_count[0] = 2;
    m->turning[0] = 0.24;
    m->turning[1] = -0.24;
}

/* The clearances of several stops are told apart. */
static void several_stops_have_numbers(void **state) {
    (void)state;
    saltus_scene scene = scene_of(0.25, SALTUS_UPPER);
    saltus_sweep_options options = saltus_sweep_defaults();
    const saltus_sweep_view how = {.view = SALTUS_VIEW_TURNING};
    const saltus_axis axis = {.key = "omega", .count = 4, .low = 0.5, .high = 1.5};
    char path[path_size];
    add_stop(&scene.spec, 0.26, 0.5, SALTUS_LOWER);
    options.keep = SALTUS_KEEP_TURNING;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_near_stops, 100);
    figure f = draw("s.h5", &how, "s.png");
    const figure_mark *first = figure_mark_of(&f.panel[0], 'l', "{/:Italic d}_{1}", 0),
                      *second = figure_mark_of(&f.panel[0], 'l', "−{/:Italic d}_{2}", 0);
    assert_true(first && first->text[0] == '{' && second);
    figure_near(first->place[0][1], 0.25, 1e-7);
    figure_near(second->place[0][1], -0.26, 1e-7);
    figure_free(&f);
}

/* A visible stop is a line with grey beyond it: horizontal, or rising if the clearance is the axis. Speeds
 * have no stop. */
static void stops_are_where_the_clearance_says(void **state) {
    (void)state;
    saltus_scene scene = scene_of(0.25, SALTUS_BOTH);
    saltus_sweep_options options = saltus_sweep_defaults();
    char path[path_size];
    options.keep = SALTUS_KEEP_TURNING;
    for (int k = 0; k < 4; k++) {
        const saltus_axis axis = {.count = 4,
                                  .low = k == 1 || k == 2 ? 0.05 : 0.5,
                                  .high = k == 1   ? 0.25
                                          : k == 2 ? 0.25
                                                   : 1.5};
        saltus_axis own = axis;
        strcpy(own.key, k == 1 ? "d" : k == 2 ? "d1" : "omega");
        made_write(path_in("s.h5", path), &scene, &own, 1, &options, fill_near_stops, 100);
        saltus_sweep_view how = {.view = k == 3 ? SALTUS_VIEW_SPEED : SALTUS_VIEW_TURNING};
        figure f = draw("s.h5", &how, "s.png");
        const figure_panel *panel = &f.panel[0];
        for (int face = 0; face < 2; face++) {
            const figure_element *fill = figure_element_of(panel, "filledcurves", face);
            char name[16];
            snprintf(name, sizeof name, "$face_%d", face);
            assert_true((fill != NULL) == (k < 3));
            if (!fill)
                continue;
            const figure_element *line = figure_element_of(panel, name, 1);
            double side = fill->values.at[0][1] > 0 ? 1 : -1;
            assert_true(line && strstr(line->style, "with lines"));
            assert_true(side == (face ? -1 : 1) && fill->values.count > 10);
            assert_int_equal(fill->values.count, line->values.count);
            for (int i = 0; i < fill->values.count; i++) {
                const double *at = fill->values.at[i];
                figure_near(at[1], side * (own.key[0] == 'd' ? at[0] : 0.25), 1e-7);
                figure_near(at[2], panel->range[1][side < 0 ? 0 : 1], 1e-7);
                assert_true(line->values.at[i][0] == at[0] && line->values.at[i][1] == at[1]);
            }
            check_near(fill->values.at[fill->values.count - 1][0], panel->range[0][1], 1e-6);
            assert_true(side > 0 ? panel->range[1][1] > 0.25 : panel->range[1][0] < -0.25);
            const figure_mark *label =
                figure_mark_of(panel, 'l', side < 0 ? "−{/:Italic d}" : "{/:Italic d}", 0);
            bool found = false;
            for (int i = 0; (label = figure_mark_of(panel, 'l', "{/:Italic d}", i)) != NULL; i++)
                found = found || (label->system[0][1] == 'f' &&
                                  fabs(label->place[0][1] -
                                       side * (own.key[0] == 'd' ? panel->range[0][1] : 0.25)) < 1e-6 &&
                                  (strncmp(label->text, "−", 3) == 0) == (side < 0));
            assert_true(found);
        }
        figure_free(&f);
    }
}

/* A stop that leaves the panel before the end of the axis is named where it leaves it. */
static void stops_that_leave_the_panel_are_named(void **state) {
    (void)state;
    saltus_scene scene = scene_of(0.25, SALTUS_BOTH);
    saltus_sweep_options options = saltus_sweep_defaults();
    const saltus_axis axis = {.key = "d", .count = 4, .low = 0.05, .high = 0.25};
    saltus_plot_part part = {"turning", -0.15, 0.15};
    char path[path_size];
    options.keep = SALTUS_KEEP_TURNING;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_near_stops, 100);
    for (int swap = 0; swap < 2; swap++) {
        const saltus_sweep_view how = {
            .view = SALTUS_VIEW_TURNING, .parts = &part, .part_count = 1, .look = {.swap = swap}};
        figure f = draw("s.h5", &how, "s.svg");
        const double *along = f.panel[0].range[swap];
        for (int lower = 0; lower < 2; lower++) {
            const figure_mark *name = NULL;
            for (int i = 0; !name || strcmp(name->text, lower ? "−{/:Italic d}" : "{/:Italic d}") != 0; i++)
                assert_non_null(name = figure_mark_of(&f.panel[0], 'l', "{/:Italic d}", i));
            assert_true(name->system[0][swap] == 'g' && name->system[0][!swap] == 'g');
            check_near(name->place[0][swap], (0.15 - along[0]) / (along[1] - along[0]), 0.01);
            assert_true(lower ? name->place[0][!swap] < 0.05 : name->place[0][!swap] > 0.99);
        }
        figure_free(&f);
    }
}

/* A stop less than a tenth of the points' range beyond them is shown too; everything has a margin of a
 * twentieth. */
static void fill_a_tenth(made_place *m) {
    m->row[0] = made_periodic(1, 1);
    m->turning_count[0] = 2;
    m->turning[0] = -0.1;
    m->turning[1] = 0.1;
}

static void stops_near_the_points_widen_the_range(void **state) {
    static const double stop[] = {0.119, 0.121, -0.119, -0.121, 0.05};
    (void)state;
    saltus_sweep_options options = saltus_sweep_defaults();
    const saltus_sweep_view how = {.view = SALTUS_VIEW_TURNING};
    const saltus_axis axis = {.key = "omega", .count = 3, .low = 0.5, .high = 1.5};
    char path[path_size];
    options.keep = SALTUS_KEEP_TURNING;
    for (int k = 0; k < 10; k++) {
        bool lower = k % 2;
        double place = stop[k / 2], low = -0.1, high = 0.1;
        saltus_scene scene = scene_of(lower ? -place : place, lower ? SALTUS_LOWER : SALTUS_UPPER);
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_a_tenth, 100);
        figure f = draw("s.h5", &how, "s.png");
        high = place == 0.119 ? place : high;
        low = place == -0.119 ? place : low;
        check_near(f.panel[0].range[1][0], low - 0.05 * (high - low), 1e-7);
        check_near(f.panel[0].range[1][1], high + 0.05 * (high - low), 1e-7);
        figure_free(&f);
    }
}

/* Options for branches are refused for a sweep, and only one sweep is drawn. */
static void wishes_for_branches_are_refused(void **state) {
    (void)state;
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = saltus_sweep_defaults();
    const saltus_axis axis = {.key = "omega", .count = 3, .low = 0.5, .high = 1.5};
    char path[path_size], picture[path_size], words[400];
    options.keep = SALTUS_KEEP_TURNING;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_a_tenth, 100);
    path_in("s.png", picture);
    const char *const paths[] = {path, path};
    for (int k = 0; k < 5; k++) {
        static const char *const said[] = {"is a sweep; what is shown of it is chosen as a view", "",
                                           "is a sweep, which is drawn alone or with branches"};
        /* A label is refused only where its place is in something that the figure does not show. */
        const saltus_plot_label label = {{"omega", "speed"}, {1, 0}, "here"};
        saltus_plot_options how = {.show = k == 0 ? SALTUS_SHOW_PERIOD : SALTUS_SHOW_AUTOMATIC,
                                   .labels = &label,
                                   .label_count = k == 1};
        saltus_message message = {.text = ""};
        saltus_status status = saltus_plot(picture, paths, k == 4 ? 0 : 1 + (k == 2), &how, &message);
        snprintf(words, sizeof words, "%s: %s", path, k < 3 ? said[k] : "");
        if (k == 1)
            strcpy(words, "label here: its place must be in what the figure shows, omega and turning");
        assert_int_equal(status, k == 3 ? SALTUS_OK : SALTUS_BAD_INPUT);
        if (k < 3)
            assert_string_equal(message.text, words);
    }
}

/* A label stands on a white ground at its place in the parameter and what is shown, also with exchanged or
 * logarithmic axes. */
static void labels_stand_at_their_places(void **state) {
    (void)state;
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = saltus_sweep_defaults();
    const saltus_axis axis = {.key = "omega", .count = 3, .low = 0.5, .high = 1.5};
    const saltus_plot_label labels[2] = {{{"omega", "turning"}, {0.8, 0.02}, "one_way"},
                                         {{"turning", "omega"}, {-0.03, 1.2}, "other"}};
    const char *const key = "omega";
    char path[path_size];
    options.keep = SALTUS_KEEP_TURNING;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_a_tenth, 100);
    for (int k = 0; k < 4; k++) {
        const bool swap = k % 2, logarithmic = k / 2;
        const saltus_sweep_view how = {
            .view = SALTUS_VIEW_TURNING,
            .labels = labels,
            .label_count = 2,
            .look = {.swap = swap, .logarithmic = &key, .logarithmic_count = logarithmic}};
        figure f = draw("s.h5", &how, "s.svg");
        for (int n = 0; n < 2; n++) {
            const figure_panel *panel = &f.panel[0];
            const figure_mark *label = figure_mark_of(panel, 'l', n ? "other" : "one\\_way", 0);
            assert_true(label && strstr(label->style, "boxed"));
            for (int side = 0; side < 2; side++) {
                const double *range = panel->range[side ^ swap], value = labels[n].value[side ^ n];
                const bool turned = side == 0 && logarithmic;
                check_near(label->place[0][side ^ swap],
                           turned ? log(value / range[0]) / log(range[1] / range[0])
                                  : (value - range[0]) / (range[1] - range[0]),
                           1e-4);
            }
        }
        figure_free(&f);
    }
}

/* Numbers */

enum { kinds_made = 24 };

static saltus_sweep_row made_row(long long point) {
    saltus_sweep_row row;
    switch (point / 2) {
    case 0:
        row = made_periodic(1, 1);
        break;
    case 1:
        row = made_periodic(2, 1);
        break;
    case 2:
        row = made_periodic(-1, 2);
        break;
    case 3:
        row = made_other(SALTUS_EQUILIBRIUM);
        break;
    case 4:
        row = made_other(SALTUS_HELD);
        break;
    case 5:
        row = made_other(SALTUS_QUASIPERIODIC);
        break;
    case 6:
        row = made_other(SALTUS_CHAOTIC);
        break;
    case 7:
        row = made_other(SALTUS_LONG_PERIOD);
        break;
    case 8:
        row = made_other(SALTUS_UNDECIDED);
        break;
    case 9:
        row = made_other(SALTUS_FAILED);
        break;
    case 10:
        row = made_periodic(3, 8);
        break;
    default:
        row = made_periodic(0, 1);
    }
    row.settled = 10 + point * point;
    row.largest = number_of(point, 1);
    row.smallest = -2;
    row.impact_rate = 1 + number_of(point, 2);
    row.largest_speed = 2 + number_of(point, 3);
    row.contact_fraction = 0.5 + number_of(point, 4);
    row.lyapunov = point == 12 ? -INFINITY : point == 17 ? NAN : 10 * number_of(point, 5);
    row.lyapunov_error = point % 3 ? 0.02 : 0;
    return row;
}

static void fill_kinds(made_place *m) {
    m->row[0] = made_row(m->point);
}

/* A view's number for a row; NAN if there is none. */
static double number_shown(saltus_view view, const saltus_sweep_row *row) {
    bool settled =
        row->verdict == SALTUS_PERIODIC || row->verdict == SALTUS_EQUILIBRIUM || row->verdict == SALTUS_HELD;
    if (view == SALTUS_VIEW_ATTRACTORS)
        return row->attractor < 0 ? NAN : row->attractor + 1;
    if (row->verdict == SALTUS_FAILED)
        return NAN;
    double number = view == SALTUS_VIEW_LARGEST       ? row->largest
                    : view == SALTUS_VIEW_RMS         ? row->rms
                    : view == SALTUS_VIEW_SPEED       ? row->largest_speed
                    : view == SALTUS_VIEW_RATE        ? row->impact_rate
                    : view == SALTUS_VIEW_CONTACT     ? row->contact_fraction
                    : view == SALTUS_VIEW_LYAPUNOV    ? row->lyapunov
                    : view == SALTUS_VIEW_SETTLED     ? (settled ? (double)row->settled : NAN)
                    : row->verdict == SALTUS_PERIODIC ? row->periods
                                                      : NAN;
    return isinf(number) ? NAN : number;
}

static bool same_class(const saltus_sweep_row *a, const saltus_sweep_row *b) {
    char own[32], other[32];
    saltus_sweep_label(a, own);
    saltus_sweep_label(b, other);
    return strcmp(own, other) == 0;
}

static saltus_sweep_options number_options(void) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = SALTUS_KEEP_LYAPUNOV;
    return options;
}

/* A motion that leans to one side, at some points to the other. */
static int leaning; /* its verdict */
static void fill_sides(made_place *m) {
    const double sign = m->point == 3 || m->point == 5 ? -1 : 1, high = 0.3 + 0.01 * (double)m->point;
    m->row[0] = leaning == SALTUS_PERIODIC ? made_periodic(1, 1) : made_other(leaning);
    m->row[0].largest = sign > 0 ? high : 0.1;
    m->row[0].smallest = sign > 0 ? -0.1 : -high;
    m->row[0].largest_speed = 1;
}

/* Mirror images met by turns are not joined where displacements are shown, as if they were one motion. */
static void mirror_images_are_not_joined(void **state) {
    (void)state;
    static const saltus_view views[] = {SALTUS_VIEW_LARGEST, SALTUS_VIEW_SPEED};
    saltus_scene scene = scene_of(1, SALTUS_BOTH);
    saltus_sweep_options options = saltus_sweep_defaults();
    const saltus_axis axis = {.key = "omega", .count = 8, .low = 0.5, .high = 1.5};
    char path[path_size];
    for (int k = 0; k < 4; k++) {
        const saltus_sweep_view how = {.view = views[k % 2]};
        leaning = k < 2 ? SALTUS_PERIODIC : SALTUS_IRREGULAR;
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_sides, 100);
        figure f = draw("s.h5", &how, "s.svg");
        const figure_element *links = figure_element_of(&f.panel[0], "$links", 0);
        assert_true(links && links->values.count == 8);
        for (int i = 1; i < 8; i++)
            assert_true(links->values.joined[i] == (k % 2 == 1 || i < 3 || i == 7));
        figure_free(&f);
    }
}

/* Each view's number for each row, joined to its neighbour if the motion is the same. */
static void numbers_are_those_of_the_rows(void **state) {
    (void)state;
    static const char *const names[] = {[SALTUS_VIEW_CLASS] = "period in",
                                        [SALTUS_VIEW_ATTRACTORS] = "number of attractors",
                                        [SALTUS_VIEW_LARGEST] = "largest displacement",
                                        [SALTUS_VIEW_RMS] = "root mean square of the",
                                        [SALTUS_VIEW_SPEED] = "largest impact speed",
                                        [SALTUS_VIEW_RATE] = "impacts per forcing period",
                                        [SALTUS_VIEW_CONTACT] = "part of the time in contact",
                                        [SALTUS_VIEW_LYAPUNOV] = "largest Lyapunov exponent",
                                        [SALTUS_VIEW_SETTLED] = "periods until settled"};
    saltus_axis axis = {.key = "omega", .count = kinds_made, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    char path[path_size];
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_kinds, 100);
    saltus_sweep_file file = made_read(path);
    for (saltus_view view = SALTUS_VIEW_CLASS; view <= SALTUS_VIEW_SETTLED; view++) {
        saltus_sweep_view how = {.view = view};
        figure f = draw("s.h5", &how, "s.png");
        const figure_panel *panel = &f.panel[0];
        const figure_element *dots = figure_element_of(panel, "$cloud", 0),
                             *lines = figure_element_of(panel, "$links", 0);
        int at = 0, last = -1;
        assert_true(strstr(dots->style, "with points") && strstr(lines->style, "with lines"));
        for (int k = 0; k < kinds_made; k++) {
            double y = number_shown(view, &file.rows[k]);
            if (isnan(y))
                continue;
            assert_true(at < dots->values.count && at < lines->values.count);
            for (int e = 0; e < 2; e++) {
                const figure_rows *rows = e ? &lines->values : &dots->values;
                figure_near(rows->at[at][0], file.axes[0].list[k], digits);
                figure_near(rows->at[at][1], y, digits);
            }
            assert_true(lines->values.joined[at] ==
                        (last == k - 1 && last >= 0 && same_class(&file.rows[k], &file.rows[last])));
            at++;
            last = k;
        }
        assert_int_equal(at, dots->values.count);
        assert_int_equal(at, lines->values.count);
        figure_check_inside(panel, dots);
        assert_true(strstr(panel->label[1], names[view]) == panel->label[1]);
        figure_free(&f);
    }
    saltus_sweep_file_clear(&file);
}

/* Without forcing numbers refer to returns to the section, or to time. */
static void unforced_numbers_are_named(void **state) {
    (void)state;
    static const char text[] = "model:\n  parameters: {mu: 1}\n  motion: {x: mu*(1 - x^2)*x' - x}\n"
                               "stop: {coordinate: x, d: 1.5, r: 0.7}\n";
    static const struct {
        saltus_view view;
        const char *name;
    } names[] = {{SALTUS_VIEW_CLASS, "returns to the section"},
                 {SALTUS_VIEW_RATE, "return to the section"},
                 {SALTUS_VIEW_SETTLED, "time until"}};
    saltus_axis axis = {.key = "mu", .count = kinds_made, .low = 0.5, .high = 1.5};
    saltus_message message = {.text = ""};
    saltus_scene scene;
    saltus_sweep_options options = number_options();
    char path[path_size];
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_kinds, 100);
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        saltus_sweep_view how = {.view = names[k].view};
        figure f = draw("s.h5", &how, "s.png");
        assert_non_null(strstr(f.panel[0].label[1], names[k].name));
        assert_null(strstr(f.panel[0].label[1], "forcing"));
        assert_null(strstr(f.panel[0].label[1], "{/:Italic T}"));
        figure_free(&f);
    }
    saltus_scene_clear(&scene);
}

/* The number of attractors from several starts is that of distinct ones. */
static void fill_attractors(made_place *m) {
    for (int s = 0; s < m->seeds; s++) {
        int latest = m->seeds - 1 - s;
        m->row[s] = made_periodic(1, 1 + s);
        m->row[s].attractor = (int)(m->point < latest ? m->point : latest);
    }
}

static void attractors_are_counted_by_point(void **state) {
    (void)state;
    saltus_axis axis = {.key = "omega", .count = 5, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    saltus_sweep_view how = {.view = SALTUS_VIEW_ATTRACTORS};
    char path[path_size];
    options.seeds = 4;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_attractors, 100);
    figure f = draw("s.h5", &how, "s.png");
    const figure_element *dots = figure_element_of(&f.panel[0], "$cloud", 0);
    assert_int_equal(dots->values.count, 5);
    for (int k = 0; k < 5; k++)
        assert_true(dots->values.at[k][1] == (k < 3 ? k + 1 : 4));
    assert_null(figure_element_of(&f.panel[0], "$links", 0));
    figure_free(&f);
}

/* Exponents: columns from zero, positive ones in one colour and negative in another, as wide as their cells;
 * bars of one standard error; a mark if all directions are lost. */
static void exponents_stand_on_zero(void **state) {
    (void)state;
    saltus_axis axis = {.key = "omega", .count = kinds_made, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    saltus_sweep_view how = {.view = SALTUS_VIEW_LYAPUNOV};
    char path[path_size];
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_kinds, 100);
    saltus_sweep_file file = made_read(path);
    figure f = draw("s.h5", &how, "s.png");
    const figure_panel *panel = &f.panel[0];
    const double cell = 1.0 / (kinds_made - 1), pixel = (panel->range[0][1] - panel->range[0][0]) / 1400;
    assert_true(panel->range[1][0] < 0 && panel->range[1][1] > 0);
    for (int below = 0; below < 2; below++) {
        const figure_element *columns = figure_element_of(panel, "boxxyerror", below);
        int at = 0;
        for (int k = 0; k < kinds_made; k++) {
            double exponent = number_shown(SALTUS_VIEW_LYAPUNOV, &file.rows[k]), x = file.axes[0].list[k];
            if (isnan(exponent) || (exponent < 0) != below)
                continue;
            const double *column = columns->values.at[at++];
            figure_near(column[0], x, digits);
            figure_near(column[1], exponent, digits);
            check_near(column[2], x - 0.5 * cell, 2 * pixel);
            check_near(column[3], x + 0.5 * cell, 2 * pixel);
            assert_true(column[4] == 0 && column[5] == column[1]);
        }
        assert_int_equal(at, columns->values.count);
    }
    const figure_element *bars = figure_element_of(panel, "with vectors", 0),
                         *lost = figure_element_of(panel, "$lost", 0);
    int at = 0;
    for (int k = 0; k < kinds_made; k++) {
        double exponent = number_shown(SALTUS_VIEW_LYAPUNOV, &file.rows[k]), error = k % 3 ? 0.02 : 0;
        if (isnan(exponent))
            continue;
        const double *bar = bars->values.at[at++];
        double low = fmax(exponent - error, panel->range[1][0]),
               high = fmin(exponent + error, panel->range[1][1]);
        figure_near(bar[0], file.axes[0].list[k], digits);
        check_near(bar[1], low, 1e-6);
        assert_true(bar[2] == 0);
        check_near(bar[3], high - low, 1e-6);
    }
    assert_int_equal(at, bars->values.count);
    assert_int_equal(lost->values.count, 1);
    figure_near(lost->values.at[0][0], file.axes[0].list[12], digits);
    figure_check_inside(panel, lost);
    figure_says(&f, "all directions lost");
    assert_true(figure_colour(figure_element_of(panel, "boxxyerror", 0)->style) !=
                figure_colour(figure_element_of(panel, "boxxyerror", 1)->style));
    figure_free(&f);
    saltus_sweep_file_clear(&file);
}

/* The strip */

/* Colours by label: one label has one colour, and no two labels the same. */
typedef struct legend {
    char label[32][32];
    unsigned colour[32];
    int count;
} legend;

static void check_legend(legend *l, const saltus_sweep_row *row, unsigned colour) {
    char label[32];
    saltus_paint paint = saltus_class_paint(row->verdict, row->impacts, row->periods);
    bool inked = false; /* a pixel of the texture counts for its class */
    for (int n = 0; n < 18 * 18 && paint.texture; n++)
        inked = inked || saltus_paint_at(paint, n % 18, n / 18) == colour;
    colour = inked ? paint.colour : colour;
    saltus_sweep_label(row, label);
    for (int k = 0; k < l->count; k++)
        if ((strcmp(l->label[k], label) == 0) != (l->colour[k] == colour))
            fail_msg("%s has colour %06x, %s has %06x", label, colour, l->label[k], l->colour[k]);
        else if (l->colour[k] == colour)
            return;
    assert_true(l->count < 32);
    snprintf(l->label[l->count], sizeof l->label[0], "%s", label);
    l->colour[l->count++] = colour;
}

static double luminance(unsigned colour) {
    return 0.299 * (colour >> 16 & 0xff) + 0.587 * (colour >> 8 & 0xff) + 0.114 * (colour & 0xff);
}

static double place_of(double value, bool logarithmic) {
    return logarithmic ? log(value) : value;
}

/* Edge k of the cells of sorted values: half way between neighbours. */
static double edge_of(const double *values, int count, int k, bool logarithmic) {
    double inner = k == 0 ? 1 : k == count ? count - 1 : k;
    double low = place_of(values[(int)inner - 1], logarithmic),
           high = place_of(values[(int)inner], logarithmic);
    double middle = 0.5 * (low + high);
    return k == 0 ? 2 * low - middle : k == count ? 2 * high - middle : middle;
}

/* Each pixel of a band has the colour of its cell's row, except at the very edges of cells. */
static void check_strip(const figure_panel *panel, const saltus_sweep_file *file, legend *l) {
    const figure_element *e = figure_element_of(panel, "binary", 0);
    int order[64], n = file->axes[0].count, passes = file->pass_count;
    bool logarithmic = file->axes[0].spacing == SALTUS_LOGARITHMIC;
    double sorted[64];
    sort_points(file, order);
    for (int k = 0; k < n; k++)
        sorted[k] = file->axes[0].list[order[k]];
    assert_true(panel->logarithmic[0] == logarithmic);
    double low = place_of(panel->range[0][0], logarithmic), high = place_of(panel->range[0][1], logarithmic);
    assert_true(panel->range[2][0] == 0 && panel->range[2][1] == e->width);
    assert_true(panel->range[3][0] == 0 && panel->range[3][1] == e->height);
    for (int pass = 0; pass < passes; pass++) {
        int y = (int)((passes - 1 - pass + 0.5) * e->height / passes);
        for (int x = 0; x < e->width; x++) {
            double at = low + (high - low) * (x + 0.5) / e->width, pixel = (high - low) / e->width;
            int cell = 0, opacity;
            while (cell < n && edge_of(sorted, n, cell + 1, logarithmic) < at)
                cell++;
            if (cell == n || fabs(at - edge_of(sorted, n, cell, logarithmic)) < 0.02 * pixel ||
                fabs(at - edge_of(sorted, n, cell + 1, logarithmic)) < 0.02 * pixel)
                continue;
            unsigned colour = figure_pixel(e, x, y, &opacity);
            assert_int_equal(opacity, 255);
            /* A band is filled up to the line between it and the next. */
            int high = e->height / passes, bottom = (passes - 1 - pass) * high;
            for (int up = 0; up < high; up++) {
                figure_pixel(e, x, bottom + up, &opacity);
                assert_int_equal(opacity, passes > 1 && up == high - 1 ? 0 : 255);
            }
            check_legend(l, &file->rows[row_at(file, pass, order[cell], 0)], colour);
        }
    }
}

/* Every name is on a stretch of its motion, in letters readable on its colour. */
static void check_names(const figure_panel *panel, const saltus_sweep_file *file, const legend *l,
                        int least) {
    const figure_element *e = figure_element_of(panel, "binary", 0);
    int found = 0;
    for (int m = 0; m < panel->mark_count; m++) {
        const figure_mark *mark = &panel->mark[m];
        if (mark->kind != 'l' || mark->system[0][0] != 'g' || mark->place[0][0] < 0)
            continue;
        unsigned colour =
            figure_pixel(e, (int)(mark->place[0][0] * e->width), (int)(mark->place[0][1] * e->height), NULL);
        for (int k = 0; k < l->count; k++)
            if (l->colour[k] == colour) {
                assert_string_equal(mark->text, l->label[k]);
                double ink = luminance((unsigned)figure_colour(mark->style));
                assert_true(fabs(ink - luminance(colour)) > 110);
                found++;
            }
    }
    assert_true(found >= least && file->row_count > 0);
}

static void fill_other_way(made_place *m) {
    m->row[0] = made_row(m->pass == SALTUS_PASS_UP ? m->point : (m->point * 7 + 3) % kinds_made);
}

/* The strip below a diagram: the motion at each value, pass by pass, in equal and logarithmic steps. */
static void the_strip_tells_the_motion_at_each_value(void **state) {
    (void)state;
    saltus_axis axis = {.key = "omega", .count = kinds_made, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    saltus_sweep_view how = {.view = SALTUS_VIEW_LARGEST};
    char path[path_size];
    for (int k = 0; k < 3; k++) {
        legend l = {.count = 0};
        axis.spacing = k == 1 ? SALTUS_LOGARITHMIC : SALTUS_LINEAR;
        axis.low = k == 1 ? 0.01 : 0.5;
        axis.count = k == 2 ? 9 : kinds_made;
        options.passes = k == 0 ? 6 : 1;
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, k ? fill_kinds : fill_other_way, 100);
        saltus_sweep_file file = made_read(path);
        figure f = draw("s.h5", &how, k == 1 ? "s.svg" : "s.png");
        assert_int_equal(f.panel_count, 2);
        check_strip(&f.panel[1], &file, &l);
        assert_int_equal(l.count, k == 2 ? 5 : 12);
        check_names(&f.panel[1], &file, &l, k == 2 ? 4 : 3);
        /* Both panels share the axis. */
        for (int end = 0; end < 2; end++) {
            assert_true(f.panel[0].range[0][end] == f.panel[1].range[0][end]);
            assert_true(f.panel[0].frame[end] == f.panel[1].frame[end]);
        }
        assert_true(f.panel[0].logarithmic[0] == (k == 1));
        double first = edge_of(file.axes[0].list, axis.count, 0, k == 1),
               last = edge_of(file.axes[0].list, axis.count, axis.count, k == 1);
        check_near(place_of(f.panel[0].range[0][0], k == 1), first, 1e-9);
        check_near(place_of(f.panel[0].range[0][1], k == 1), last, 1e-9);
        int pixels = (int)lround(1600 * (f.panel[1].frame[1] - f.panel[1].frame[0]));
        assert_int_equal(figure_element_of(&f.panel[1], "binary", 0)->width, (k == 1 ? 2 : 1) * pixels);
        if (k == 0) {
            assert_non_null(figure_mark_of(&f.panel[1], 'l', "up", 0));
            assert_true(figure_mark_of(&f.panel[1], 'l', "up", 0)->place[0][1] >
                        figure_mark_of(&f.panel[1], 'l', "down", 0)->place[0][1]);
        }
        figure_free(&f);
        saltus_sweep_file_clear(&file);
    }
}

/* Very many points become a picture. Orbits of thirty points at every second value, recorded once or fifty
 * times, between motions that never repeat. */
enum { dense_count = 16, dense_each = 1500, dense_orbit = 30 };

static double dense_point(long long point, int k) {
    return point % 2 == 0 ? 0.015 * (k % dense_orbit) + 0.001 * (double)point
                          : 0.5 * fmod(0.6180339887 * k, 1);
}

static void fill_dense(made_place *m) {
    m->row[0] = m->point % 2 ? made_other(SALTUS_CHAOTIC) : made_periodic(1, 20);
    m->turning_count[0] = m->point == 4 ? dense_orbit : dense_each;
    for (int k = 0; k < dense_each; k++)
        m->turning[k] = m->pass == SALTUS_PASS_UP ? dense_point(m->point, k) : -0.2;
}

/* What is drawn with its axes exchanged is what is drawn without, across for up: numbers and their order, the
 * axes' names and scales, the strip at the left instead of below. */
static void check_exchanged(const figure *level, const figure *upright) {
    assert_int_equal(level->panel_count, 2);
    assert_int_equal(upright->panel_count, 2);
    const figure_panel *a = &level->panel[0], *b = &upright->panel[0];
    const figure_panel *strip = &upright->panel[1];
    for (int i = 0; i < 2; i++) {
        assert_string_equal(a->label[!i], b->label[i]); /* the parameter's name is at the strip */
        assert_string_equal(level->panel[1].label[!i], strip->label[i]);
        assert_true(a->logarithmic[i] == b->logarithmic[!i]);
        assert_true(b->range[1][i] == strip->range[1][i] && b->frame[2 + i] == strip->frame[2 + i]);
        for (int end = 0; end < 2; end++)
            figure_near(b->range[!i][end], a->range[i][end], 1e-9);
    }
    assert_true(strip->frame[1] < b->frame[0] && strip->frame[0] > 0.05);
    assert_int_equal(a->element_count, b->element_count);
    for (int e = 0; e < a->element_count; e++) {
        const figure_rows *rows = &a->element[e].values, *others = &b->element[e].values;
        const bool bars = strstr(a->element[e].text, "with vectors") != NULL;
        if (a->element[e].text[0] == '$')
            assert_int_equal(rows->count, others->count);
        assert_string_equal(a->element[e].title, b->element[e].title);
        for (int k = 0; k < rows->count; k++) {
            assert_true(rows->joined[k] == others->joined[k]);
            for (int i = 0; i < (bars ? 4 : 2); i++)
                figure_near(others->at[k][i ^ 1], rows->at[k][i], 1e-12);
        }
    }
    const figure_element *band = figure_element_of(&level->panel[1], "binary", 0),
                         *column = figure_element_of(strip, "binary", 0);
    assert_true(column->height > 10 * column->width && band->width > 10 * band->height);
}

/* The strip's colour of each value, in the middle of its cell and of the band of its pass. */
static void check_column(const figure *level, const figure *upright, const saltus_sweep_file *file) {
    const figure_element *band = figure_element_of(&level->panel[1], "binary", 0),
                         *column = figure_element_of(&upright->panel[1], "binary", 0);
    const int n = file->axes[0].count, passes = file->pass_count;
    for (int k = 0; k < n; k++)
        for (int pass = 0; pass < passes; pass++) {
            const double along = (k + 0.5) / n, across = (pass + 0.5) / passes;
            /* Textures are those of the page: any colour within the cell is looked for. */
            bool same = false;
            for (int x = -3; x <= 3; x++)
                for (int y = -3; y <= 3; y++)
                    same = same || figure_pixel(band, (int)(along * band->width) + x,
                                                (int)((1 - across) * band->height), NULL) ==
                                       figure_pixel(column, (int)(across * column->width),
                                                    (int)(along * column->height) + y, NULL);
            assert_true(same);
        }
    for (int pass = 0; pass < passes && passes > 1; pass++) {
        const figure_mark *name = figure_mark_of(&upright->panel[1], 'l', pass ? "down" : "up", 0);
        assert_non_null(name);
        check_near(name->place[0][0], (pass + 0.5) / passes, 1e-6);
    }
}

static void axes_can_be_exchanged(void **state) {
    (void)state;
    static const saltus_view views[] = {SALTUS_VIEW_LARGEST, SALTUS_VIEW_LYAPUNOV, SALTUS_VIEW_CLASS,
                                        SALTUS_VIEW_TURNING, SALTUS_VIEW_TURNING};
    static const char *const keys[] = {"omega", "largest"};
    saltus_scene scene = scene_of(0.25, SALTUS_BOTH);
    char path[path_size];
    for (int k = 0; k < 5; k++) {
        const bool dense = k == 3, clouds = k > 2;
        saltus_axis axis = {
            .key = "omega", .count = clouds ? dense_count : kinds_made, .low = 0.5, .high = 1.5};
        saltus_sweep_options options = number_options();
        options.passes = k < 2 ? 1 : 6;
        options.keep = clouds ? SALTUS_KEEP_TURNING : options.keep;
        strcpy(axis.key, k == 4 ? "d" : "omega");
        axis.low = k == 4 ? 0.05 : axis.low;
        axis.high = k == 4 ? 0.25 : axis.high;
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options,
                   dense    ? fill_dense
                   : clouds ? fill_near_stops
                            : fill_kinds,
                   100);
        saltus_sweep_file file = made_read(path);
        saltus_sweep_view how = {.view = views[k],
                                 .look = {.logarithmic = keys, .logarithmic_count = k ? k == 2 : 2}};
        figure level = draw("s.h5", &how, "s.png");
        how.look.swap = true;
        figure upright = draw("s.h5", &how, "s.png");
        check_exchanged(&level, &upright);
        check_column(&level, &upright, &file);
        if (dense) {
            /* A point of the cloud is at the same place of its axes. */
            const figure_element *a = figure_element_of(&level.panel[0], "binary", 1),
                                 *b = figure_element_of(&upright.panel[0], "binary", 1);
            const saltus_range up = {level.panel[0].range[1][0], level.panel[0].range[1][1]};
            for (int point = 0; point < dense_count; point += 2)
                for (int i = 0; i < dense_orbit; i++) {
                    const double at = (point + 0.5) / dense_count,
                                 part = saltus_range_part(up, false, dense_point(point, i));
                    int opacity[2];
                    figure_pixel(a, (int)(at * a->width), (int)(part * a->height), &opacity[0]);
                    figure_pixel(b, (int)(part * b->width), (int)(at * b->height), &opacity[1]);
                    assert_true(opacity[0] > 40 && opacity[1] > 40);
                }
        }
        if (clouds && !dense) {
            const figure_mark *name = figure_mark_of(&upright.panel[0], 'l', "−{/:Italic d}", 0);
            assert_true(name && name->system[0][0] == 'f' && name->system[0][1] == 'g');
            assert_true(figure_element_of(&upright.panel[0], "filledcurves x1=", 1) != NULL);
        }
        figure_free(&level);
        figure_free(&upright);
        saltus_sweep_file_clear(&file);
    }
}

/* With several starts motions are stacked, each as high as its share. */
static void fill_shares(made_place *m) {
    for (int s = 0; s < m->seeds; s++)
        m->row[s] = made_periodic(1, s < m->point ? 1 : 2);
}

static void shares_of_the_starts_are_heights(void **state) {
    (void)state;
    saltus_axis axis = {.key = "omega", .count = 5, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    saltus_sweep_view how = {.view = SALTUS_VIEW_RATE};
    char path[path_size];
    options.seeds = 4;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_shares, 100);
    figure f = draw("s.h5", &how, "s.png");
    const figure_element *e = figure_element_of(&f.panel[1], "binary", 0);
    unsigned all = figure_pixel(e, e->width - 20, 3, NULL), none = figure_pixel(e, 20, 3, NULL);
    assert_true(all != none);
    for (int k = 0; k < 5; k++) {
        int count = 0, x = (int)((k + 0.5) * e->width / 5);
        for (int y = 0; y < e->height; y++) {
            unsigned colour = figure_pixel(e, x, y, NULL);
            assert_true(colour == all || colour == none);
            count += colour == all;
        }
        assert_int_equal(count, e->height * k / 4);
    }
    figure_free(&f);
}

/* Tics of a logarithmic axis are within its range, at round numbers. */
static void logarithmic_tics_are_round(void **state) {
    (void)state;
    static const double ends[][2] = {{0.5, 1.5}, {0.5, 0.9}, {0.02, 1.5}, {0.5, 1.2}, {3, 110}};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    saltus_sweep_view how = {.view = SALTUS_VIEW_LARGEST};
    char path[path_size];
    for (int k = 0; k < 5; k++) {
        saltus_axis axis = {
            .key = "omega", .spacing = SALTUS_LOGARITHMIC, .count = 9, .low = ends[k][0], .high = ends[k][1]};
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_kinds, 100);
        saltus_message message = {.text = ""};
        char out[path_size];
        size_t length;
        check_ok(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), &message);
        char *script = read_all(path_in("script", out), &length), *at = strstr(script, "set xtics (");
        assert_non_null(at);
        double last = 0, ratio = ends[k][1] / ends[k][0];
        int count = 0;
        for (at += 11; *at != ')'; at += strspn(at, ", ")) {
            double tic = strtod(at, &at), power = pow(10, floor(log10(tic) + 1e-9));
            assert_true(tic > last && tic > ends[k][0] / ratio && tic < ends[k][1] * ratio);
            check_near(tic / power * 10, round(tic / power * 10), 1e-9);
            last = tic;
            count++;
        }
        assert_in_range(count, 4, 14);
        free(script);
        figure f = figure_taken(folder);
        assert_true(last <= f.panel[0].range[0][1]);
        figure_free(&f);
    }
}

/* Every point is painted, and nothing far from all points; returns the most opaque pixel near each value. */
static void check_painted(const figure_panel *panel, const figure_element *e, const saltus_sweep_file *file,
                          int pass, int darkest[dense_count]) {
    unsigned char *near = calloc((size_t)e->width * (size_t)e->height, 1);
    assert_non_null(near);
    for (int k = 0; k < dense_count; k++) {
        double part =
            (file->axes[0].list[k] - panel->range[0][0]) / (panel->range[0][1] - panel->range[0][0]);
        int x = (int)(part * e->width);
        long long row = pass * dense_count + k;
        darkest[k] = 0;
        for (int i = 0; i < file->turning_count[row]; i++) {
            double v = file->turning[file->turning_first[row] + i];
            int opacity,
                y = (int)(e->height * (v - panel->range[1][0]) / (panel->range[1][1] - panel->range[1][0]));
            figure_pixel(e, x, y, &opacity);
            assert_true(opacity > 0);
            darkest[k] = opacity > darkest[k] ? opacity : darkest[k];
            for (int b = -2; b <= 2; b++)
                for (int a = -2; a <= 2; a++)
                    if (y + b >= 0 && y + b < e->height)
                        near[(y + b) * e->width + x + a] = 1;
        }
    }
    for (int y = 0; y < e->height; y++)
        for (int x = 0; x < e->width; x++) {
            int opacity;
            figure_pixel(e, x, y, &opacity);
            assert_true(opacity == 0 || near[y * e->width + x]);
        }
    free(near);
}

static void dense_clouds_are_painted_where_the_points_are(void **state) {
    (void)state;
    saltus_axis axis = {.key = "omega", .count = dense_count, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    saltus_sweep_view how = {.view = SALTUS_VIEW_TURNING};
    char path[path_size];
    options.keep = SALTUS_KEEP_TURNING;
    options.passes = 6;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_dense, 100);
    saltus_sweep_file file = made_read(path);
    figure f = draw("s.h5", &how, "s.png");
    const figure_panel *panel = &f.panel[0];
    int darkest[dense_count];
    assert_null(figure_element_of(panel, "$cloud", 0));
    assert_true(panel->range[2][1] == figure_element_of(panel, "binary", 0)->width);
    assert_true(panel->range[3][1] == figure_element_of(panel, "binary", 0)->height);
    /* Upwards lies over downwards. */
    check_painted(panel, figure_element_of(panel, "binary", 0), &file, 1, darkest);
    check_painted(panel, figure_element_of(panel, "binary", 1), &file, 0, darkest);
    for (int k = 0; k < dense_count; k++)
        assert_true(k % 2 ? darkest[k] < 0.75 * 255 && darkest[k] > 40 : darkest[k] > 0.9 * 255);
    figure_free(&f);
    saltus_sweep_file_clear(&file);
}

/* On a small page fewer points can be told apart: there a cloud becomes a density earlier. */
static void small_pages_hold_fewer_points(void **state) {
    (void)state;
    const saltus_axis axis = {.key = "omega", .count = 5, .low = 0.5, .high = 1.5};
    const saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = number_options();
    char path[path_size];
    options.keep = SALTUS_KEEP_TURNING;
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_dense, 100);
    for (int column = 0; column < 2; column++) {
        const saltus_sweep_view how = {.view = SALTUS_VIEW_TURNING, .look = {.width = column ? 85 : 0}};
        saltus_message message = {.text = ""};
        char out[path_size];
        check_ok(saltus_plot_sweep(path_in("s.svg", out), path, &how, &message), &message);
        figure f = figure_taken(folder);
        assert_true((figure_element_of(&f.panel[0], "$cloud", 0) != NULL) == !column);
        assert_true((figure_element_of(&f.panel[0], "binary", 0) != NULL) == column);
        figure_free(&f);
    }
}

/* By default clouds are drawn if there are any, otherwise the largest displacement. */
static void views_are_chosen_by_what_there_is(void **state) {
    (void)state;
    static const unsigned keep[] = {SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS, SALTUS_KEEP_IMPACTS,
                                    SALTUS_KEEP_STROBOSCOPIC, 0};
    static const char *const words[] = {"displacement diagram", "velocity diagram", "stroboscopic diagram",
                                        "largest displacement"};
    static const saltus_view lacking[] = {SALTUS_VIEW_STROBOSCOPIC, SALTUS_VIEW_TURNING, SALTUS_VIEW_IMPACTS,
                                          SALTUS_VIEW_LYAPUNOV};
    saltus_axis axis = {.key = "omega", .count = 5, .low = 0.5, .high = 1.5};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message;
    char path[path_size], out[path_size];
    for (int k = 0; k < 4; k++) {
        options.keep = keep[k];
        made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill_clouds, 100);
        saltus_sweep_view how = {.view = SALTUS_VIEW_AUTOMATIC};
        figure f = draw("s.h5", &how, "s.png");
        figure_says(&f, words[k]);
        figure_free(&f);
        how.view = lacking[k];
        assert_int_equal(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), SALTUS_BAD_INPUT);
    }
    /* Ranges of keys not shown, and ranges without data, are refused. */
    static const saltus_plot_part wrong[] = {{"d", 0, 1}, {"omega", 1.7, 2}, {"omega", 0.1, 0.2}};
    for (int k = 0; k < 3; k++) {
        saltus_sweep_view how = {.parts = &wrong[k], .part_count = 1};
        assert_int_equal(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), SALTUS_BAD_INPUT);
    }
}

/* Impossible requests are refused with a message that names the file, the request and what there is. */
static void views_that_cannot_be_shown_are_named(void **state) {
    (void)state;
    static const char *const none[] = {"none.h5"};
    static const saltus_plot_part parts[] = {{"d", 0, 1},         {"turning", 0, 1}, {"omega", 2, 3},
                                             {"omega", 0, 0.5},   {"omega", -1, 1},  {"speed", 0, 1},
                                             {"omega", 1.05, 1.1}};
    static const struct {
        const char *file;
        saltus_view view;
        int part, branches;
        const char *words;
    } cases[] = {
        {"one.h5", SALTUS_VIEW_TURNING, -1, 0, "holds no data for view turning"},
        {"one.h5", SALTUS_VIEW_STROBOSCOPIC, -1, 0, "holds no data for view stroboscopic"},
        {"one.h5", SALTUS_VIEW_LYAPUNOV, -1, 0, "holds no data for view lyapunov"},
        {"one.h5", SALTUS_VIEW_IMPACTS, 0, 0, "range of d: the figure shows omega and impacts"},
        {"one.h5", SALTUS_VIEW_IMPACTS, 1, 0, "range of turning: the figure shows omega and impacts"},
        {"one.h5", SALTUS_VIEW_IMPACTS, 2, 0,
         "there is nothing from omega = 2 to 3: the sweep goes from 0.5 to 1.5"},
        {"one.h5", SALTUS_VIEW_IMPACTS, 6, 0,
         "there is nothing to show in view impacts from omega = 1.05 to 1.1"},
        {"one.h5", SALTUS_VIEW_LARGEST, -1, 1, "impacts, speed and stroboscopic, not largest"},
        {"log.h5", SALTUS_VIEW_SPEED, 3, 0, "range of omega: the axis is logarithmic"},
        {"log.h5", SALTUS_VIEW_SPEED, 4, 0, "range of omega: the axis is logarithmic"},
        {"log.h5", SALTUS_VIEW_SPEED, 0, 0, "range of d: the figure shows omega and speed"},
        {"two.h5", SALTUS_VIEW_IMPACTS, -1, 0,
         "view impacts is over one axis, the file has two (omega and d)"},
        {"two.h5", SALTUS_VIEW_LARGEST, 5, 0, "range of speed: the figure shows omega, d and largest"},
        {"basins.h5", SALTUS_VIEW_ATTRACTORS, -1, 0,
         "is not complete, and attractors are told apart at the end"},
    };
    saltus_axis axes[2] = {{.key = "omega", .count = 5, .low = 0.5, .high = 1.5},
                           {.key = "d", .count = 2, .low = 0.5, .high = 1}};
    saltus_scene scene = scene_of(1, SALTUS_UPPER);
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    options.keep = SALTUS_KEEP_IMPACTS;
    made_write(path_in("one.h5", path), &scene, axes, 1, &options, fill_clouds, 100);
    made_write(path_in("two.h5", path), &scene, axes, 2, &options, fill_clouds, 100);
    axes[0].spacing = SALTUS_LOGARITHMIC;
    made_write(path_in("log.h5", path), &scene, axes, 1, &options, fill_clouds, 100);
    strcpy(axes[0].key, "q1");
    strcpy(axes[1].key, "v1");
    axes[0].high = 0.75;
    saltus_sweep *sweep = NULL;
    saltus_sweep_output *output = NULL;
    check_ok(saltus_sweep_new(&scene, axes, 2, &options, &sweep, &message), &message);
    check_ok(
        saltus_sweep_output_open(path_in("basins.h5", path), sweep, true, false, NULL, &output, &message),
        &message);
    check_ok(saltus_sweep_output_close(output, &message), &message);
    saltus_sweep_free(sweep);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const saltus_sweep_view how = {.view = cases[k].view,
                                       .parts = &parts[cases[k].part < 0 ? 0 : cases[k].part],
                                       .part_count = cases[k].part >= 0,
                                       .branches = none,
                                       .branch_count = cases[k].branches};
        path_in(cases[k].file, path);
        saltus_status status = saltus_plot_sweep(path_in("s.png", out), path, &how, &message);
        if (status != SALTUS_BAD_INPUT || strncmp(message.text, path, strlen(path)) != 0 ||
            !strstr(message.text, cases[k].words))
            fail_msg("'%s' does not say '%s'", status ? message.text : "drawn", cases[k].words);
    }
}

enum { slivered = 1000 };

static void fill_slivers(made_place *m) {
    const int k = (int)m->point;
    m->row[0] = k == 447 || k == 453    ? made_other(SALTUS_UNDECIDED)
                : k > 420 && k < 480    ? made_periodic(0, 1)
                : k > 600 && k % 97 < 4 ? made_periodic(1 + k % 5, 3)
                                        : made_periodic(k / 100, 2);
}

static void make_slivered(made_fill *fill, char path[path_size]) {
    const saltus_axis axis = {.key = "omega", .count = slivered, .low = 0.5, .high = 1.5};
    const saltus_scene scene = scene_of(1, SALTUS_UPPER);
    const saltus_sweep_options options = number_options();
    made_write(path_in("s.h5", path), &scene, &axis, 1, &options, fill, slivered);
}

/* On any page each motion of the strip has its name in it or an entry above. */
static void each_motion_has_its_name(void **state) {
    (void)state;
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    make_slivered(fill_slivers, path);
    saltus_sweep_file file = made_read(path);
    for (int size = 80; size <= 180; size += 4)
        for (int way = 0; way < 4; way++) { /* in pixels of a screen or finer, the strip level or upright */
            saltus_sweep_view how = {.view = SALTUS_VIEW_LARGEST, .look = {.width = size, .swap = way > 1}};
            check_ok(saltus_plot_sweep(path_in(way % 2 ? "s.png" : "s.svg", out), path, &how, &message),
                     &message);
            figure f = figure_taken(folder);
            for (long long row = 0; row < file.row_count; row++) {
                char label[32];
                bool told = false;
                saltus_sweep_label(&file.rows[row], label);
                for (int m = 0; m < f.panel[1].mark_count; m++)
                    told = told || strncmp(f.panel[1].mark[m].text, label, strlen(label)) == 0;
                for (int m = 0; m < f.panel[0].mark_count; m++)
                    told = told || strncmp(f.panel[0].mark[m].text, label, strlen(label)) == 0;
                if (!told && file.rows[row].verdict == SALTUS_PERIODIC)
                    fail_msg("%d mm: %s is neither in the strip nor above", size, label);
            }
            figure_free(&f);
        }
    saltus_sweep_file_clear(&file);
}

static int gap; /* values of another motion amid the axis */

static void fill_gap(made_place *m) {
    const int k = (int)m->point - slivered / 2;
    m->row[0] = k >= 0 && k < gap ? made_other(SALTUS_UNDECIDED) : made_periodic(1, 1);
}

/* Of two windows of one motion that only a sliver of another divides one has the name, the wider. */
static void neighbours_have_one_name(void **state) {
    (void)state;
    const saltus_sweep_view how = {.view = SALTUS_VIEW_LARGEST};
    char path[path_size];
    static const int gaps[] = {1, 3, 8, 20, 60};
    for (int k = 0; k < 5; k++) {
        gap = gaps[k];
        make_slivered(fill_gap, path);
        figure f = draw("s.h5", &how, "s.png");
        const figure_mark *name = figure_mark_of(&f.panel[1], 'l', "1/1", 0);
        assert_non_null(name);
        assert_true(name->place[0][0] < 0.5);
        assert_true((figure_mark_of(&f.panel[1], 'l', "1/1", 1) != NULL) == (gap >= 20));
        figure_free(&f);
    }
}

static void fill_of_all_kinds(made_place *m) {
    const int k = (int)m->point;
    m->row[0] = k < 900 ? made_periodic(k / 300, 1) : made_periodic(k - 900, 2 + k % 19);
}

/* Of very many motions the most frequent have entries, and how many have none is said, with the largest share
 * that one of these has in what is shown: all values or the last hundred. */
static void legends_of_many_motions_are_short(void **state) {
    (void)state;
    const double edge = 0.5 + 899.5 / (slivered - 1);
    const saltus_plot_part last = {.key = "omega", .low = edge, .high = 1.5};
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size], words[64];
    make_slivered(fill_of_all_kinds, path);
    for (int k = 0; k < 6; k++) {
        const int size = 80 + 20 * (k / 2), zoomed = k % 2;
        saltus_sweep_view how = {
            .view = SALTUS_VIEW_LARGEST, .parts = &last, .part_count = zoomed, .look = {.width = size}};
        check_ok(saltus_plot_sweep(path_in("s.svg", out), path, &how, &message), &message);
        figure f = figure_taken(folder);
        int entries = 0, left_out = 0;
        for (int m = 0; m < f.panel[0].mark_count; m++) {
            const char *text = f.panel[0].mark[m].text;
            int periods = 0;
            if (sscanf(text, "and %d more", &left_out) == 1) {
                snprintf(words, sizeof words, "and %d more, none above %s %%", left_out,
                         zoomed ? "1" : "0.1");
                assert_string_equal(text, words);
            } else
                entries += sscanf(text, "%*d/%d", &periods) == 1 && periods > 1;
        }
        assert_true(entries >= 8 && left_out > 0);
        assert_int_equal(entries + left_out, 100);
        figure_free(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clouds_are_those_of_the_file),
        cmocka_unit_test(captions_tell_how_the_sweep_was_made),
        cmocka_unit_test(impacts_on_two_sides_keep_their_signs),
        cmocka_unit_test(sections_of_a_moving_stop_are_observed_at_it),
        cmocka_unit_test(several_stops_have_numbers),
        cmocka_unit_test(stops_are_where_the_clearance_says),
        cmocka_unit_test(stops_that_leave_the_panel_are_named),
        cmocka_unit_test(stops_near_the_points_widen_the_range),
        cmocka_unit_test(wishes_for_branches_are_refused),
        cmocka_unit_test(labels_stand_at_their_places),
        cmocka_unit_test(numbers_are_those_of_the_rows),
        cmocka_unit_test(mirror_images_are_not_joined),
        cmocka_unit_test(unforced_numbers_are_named),
        cmocka_unit_test(attractors_are_counted_by_point),
        cmocka_unit_test(exponents_stand_on_zero),
        cmocka_unit_test(the_strip_tells_the_motion_at_each_value),
        cmocka_unit_test(each_motion_has_its_name),
        cmocka_unit_test(neighbours_have_one_name),
        cmocka_unit_test(legends_of_many_motions_are_short),
        cmocka_unit_test(axes_can_be_exchanged),
        cmocka_unit_test(shares_of_the_starts_are_heights),
        cmocka_unit_test(logarithmic_tics_are_round),
        cmocka_unit_test(dense_clouds_are_painted_where_the_points_are),
        cmocka_unit_test(small_pages_hold_fewer_points),
        cmocka_unit_test(views_are_chosen_by_what_there_is),
        cmocka_unit_test(views_that_cannot_be_shown_are_named),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
