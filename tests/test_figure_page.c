/* A motion's page as a whole: its panels, their places, and that none affects the next.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/page.h"
#include "made_record.h"

/* The possible panels in order, and words of their headings. */
typedef enum part { portrait, history, section, map, structure, spectrum, convergence, circle, parts } part;

static const char *part_words[parts] = {[portrait] = "phase portrait",
                                        [section] = "stroboscopic section",
                                        [map] = "impacts",
                                        [spectrum] = "displacement",
                                        [convergence] = "convergence of the largest exponent",
                                        [circle] = "Floquet multipliers"};

static saltus_lyapunov_progress estimates[] = {{10, 0.625, 0.125}, {20, 0.5, 0.0625}, {40, 0.5625, 0.03125}};

/* Lines of a motion of two periods, or a density. */
static saltus_spectra made_spectra(bool lines) {
    static saltus_spectral_line list[] = {
        {1, 0.5, 0.25, 0, -20, 0.1}, {2, 1, 2.5, 0, 0, 0.8}, {3, 1.5, 0.5, 0, -14, 0.1}};
    static double density[17] = {0,     1,     4,     2,     1, 0.5, 0.25, 0.25, 0.125,
                                 0.125, 0.125, 0.125, 0.125, 1, 1,   1,    1};
    saltus_spectra spectra = {.count = 1,
                              .periods = lines ? 2 : 0,
                              .per_period = 16,
                              .spectra = {{.kind = lines ? SALTUS_SPECTRUM_LINES : SALTUS_SPECTRUM_WELCH,
                                           .per_period = 16,
                                           .bins = 17,
                                           .resolution = 0.5,
                                           .density = density,
                                           .orbits = lines,
                                           .periods = lines ? 2 : 0,
                                           .lines = list,
                                           .line_count = lines ? 3 : 0,
                                           .low = 0.5,
                                           .high = 2,
                                           .confidence = 0.95,
                                           .between = NAN,
                                           .trustworthy = 3}}};
    return spectra;
}

/* An oscillator, two masses or a pipe, with stops on both sides of the observed coordinate. */
static saltus_system *structure_of(int kind) {
    saltus_spec spec = kind == 2 ? pipe_spec(2, 20) : oscillator_spec(0.125, 1.75, 1.5, 0.625);
    if (kind == 1)
        set_parameter(&spec, "N", 2);
    add_stop(&spec, 0.033, 0.75, SALTUS_BOTH);
    return build(&spec);
}

static const figure_mark *heading_of(const figure_panel *panel, int p) {
    char letter[32];
    snprintf(letter, sizeof letter, "{/:Bold (%c)}  ", 'a' + p);
    const figure_mark *heading = figure_mark_of(panel, 'l', letter, 0);
    assert_non_null(heading);
    return heading;
}

static const figure_panel *map_of(const figure *f) {
    for (int p = 0; p < f->panel_count; p++)
        if (figure_element_of(&f->panel[p], "$impact_map", 0))
            return &f->panel[p];
    fail_msg("no impact map");
    return NULL;
}

/* A grid of two rows, or one for two panels; with an odd number of panels the history has two places. */
static void check_grid(const figure *f, const part *there) {
    int count = f->panel_count, columns = count > 4 ? 3 : 2, cell = 0;
    double edge[parts][4], width = 0, gap = 0, height = 0;
    for (int p = 0; p < count; p++) {
        memcpy(edge[p], f->panel[p].frame, sizeof edge[p]);
        edge[p][1] += there[p] == structure && strstr(part_words[structure], "pipe") ? 0.05 : 0;
        edge[p][3] += there[p] == convergence ? 62.0 / 1200 : 0;
        edge[p][1] += there[p] == map && f->panel[p].key ? 156.0 / 1600 : 0; /* the legend beside it */
    }
    for (int p = 0; p + 1 < count; p++)
        if (there[p] != history && there[p + 1] != history && edge[p + 1][0] > edge[p][1]) {
            gap = edge[p + 1][0] - edge[p][1];
            width = edge[p][1] - edge[p][0];
        }
    for (int p = 0; p < count; p++) {
        const double *own = edge[p];
        int row = cell / columns, column = cell % columns;
        bool wide = there[p] == history && count % 2 == 1;
        cell += 1 + wide;
        check_near(own[0], column == 0 ? edge[0][0] : edge[p - 1][1] + gap,
                   gap > 0 || column == 0 ? 1e-5 : 1);
        check_near(own[2], row == 0 ? edge[0][2] : edge[count - 1][2], 1e-5);
        check_near(own[3], row == 0 ? edge[0][3] : edge[count - 1][3], 1e-5);
        if (width > 0)
            check_near(own[1] - own[0], wide ? 2 * width + gap : width, 1e-5);
        if (p + 1 == count || cell % columns == 0)
            assert_true(own[1] > 0.95 && own[1] < 0.985);
        height += own[3] - own[2];
    }
    assert_int_equal(cell % columns, 0);
    check_near(height / count, edge[0][3] - edge[0][2], 1e-5);
    assert_true(edge[0][0] > 0.06 && edge[0][0] < 0.1 && edge[count - 1][2] > 0.06 &&
                edge[count - 1][2] < 0.1);
    assert_true((edge[0][2] > edge[count - 1][3] + 0.1) == (count > 2) && edge[0][3] > 0.7);
}

/* Settings of a panel apply to it alone. */
static void check_apart(const figure *f, const part *there) {
    for (int p = 0; p < f->panel_count; p++) {
        const figure_panel *panel = &f->panel[p];
        int pages = 0, own = 0, objects = 0, arrows = 0;
        bool stops = there[p] == portrait || there[p] == history,
             pipe = strstr(part_words[structure], "pipe");
        for (int k = 0; k < panel->mark_count; k++) {
            const figure_mark *mark = &panel->mark[k];
            bool begins = strstr(mark->text, "{/:Bold (") != NULL, heading = begins || mark->tag > 90;
            own += mark->kind == 'l' && (begins || mark->system[0][0] != 's' || mark->system[0][1] != 's');
            pages += mark->kind == 'l' && !heading && mark->system[0][0] == 's' && mark->system[0][1] == 's';
            objects += mark->kind == 'o';
            arrows += mark->kind == 'a';
        }
        assert_true((pages > 0) == (p == 0));
        /* Words beside headings: the times of the shapes, and the trusted frequency of a spectrum. */
        assert_int_equal(own, 1 + ((there[p] == structure && pipe) || there[p] == spectrum));
        assert_int_equal(objects, stops || (there[p] == structure && pipe)
                                      ? 2
                                      : there[p] == spectrum || there[p] == circle);
        assert_int_equal(arrows, stops ? 2 : there[p] == spectrum || there[p] == convergence);
        assert_true(panel->logarithmic[0] == (there[p] == convergence) && !panel->logarithmic[1]);
        assert_true(panel->parametric == (there[p] == structure && !pipe));
        assert_true(panel->key == (there[p] == map || there[p] == convergence));
        assert_true(panel->label[0][0] && panel->label[1][0] && !panel->label[2][0]);
        if (panel->format[1][0])
            assert_string_equal(panel->format[1], "% h");
    }
}

/* All available content has its panel, once, in order; the structure's has the remaining room. */
static void a_page_has_all_there_is(void **state) {
    (void)state;
    static made_up m;
    for (int kind = 0; kind < 3; kind++) {
        saltus_system *system = structure_of(kind);
        int few = kind == 2 ? 1 : 2; /* multipliers, or estimates of the exponent */
        part_words[structure] = kind == 2 ? "shapes of the pipe" : "both masses";
        for (int k = 0; k < 16; k++) {
            bool settled = k & 1, struck = k & 2, moving = k & 4, more = k & 8;
            saltus_spectra spectra = made_spectra(settled);
            saltus_motion motion = settled ? orbit_of(1) : irregular();
            motion.multiplier_count = more && settled ? few : 0;
            motion.lyapunov = motion.lyapunov_error = 0.5625;
            /* An orbit's exponent follows from its multipliers; its history is not drawn. */
            motion.evidence.history = estimates;
            motion.evidence.history_count = more || settled ? few : 0;
            make_record(&m, system, settled ? 1 : 3, two_impacts, struck ? 2 : 0);
            if (!moving)
                spectra.spectra[0] = (saltus_spectrum){.kind = SALTUS_SPECTRUM_CONSTANT};
            const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record, .spectra = &spectra};
            const bool want[parts] = {true,
                                      true,
                                      !settled,
                                      struck,
                                      kind > 0 && 2 + !settled + struck + moving + more < 6,
                                      moving,
                                      more && !settled,
                                      more && settled};
            part there[parts];
            int count = 0;
            part_words[history] = settled ? "one orbit" : "time history";
            for (int p = 0; p < parts; p++)
                if (want[p])
                    there[count++] = (part)p;
            if (count == 3) {
                there[1] = there[2];
                there[2] = history;
            }
            figure f = draw(system, &diagnosis);
            assert_int_equal(f.panel_count, count);
            for (int p = 0; p < count; p++)
                assert_non_null(strstr(heading_of(&f.panel[p], p)->text, part_words[there[p]]));
            check_grid(&f, there);
            check_apart(&f, there);
            figure_free(&f);
        }
        saltus_system_free(system);
    }
}

/* Tics are as close as their numbers allow at round distances: between a 23rd and a 7th of the page apart. */
static void tics_leave_room_for_their_numbers(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = between_stops(0.5);
    for (int k = 0; k < 12; k++) {
        saltus_motion motion = k % 3 == 2 ? orbit_of(1) : irregular();
        motion.multiplier_count = k % 3 == 2 ? 2 : 0;
        make_record(&m, system, 3, two_impacts, k % 2 ? 2 : 0);
        for (long long row = 0; row < m.record.samples; row++)
            m.displacement[row] *= 1 + 0.37 * k;
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        for (int p = 0; p < f.panel_count; p++) {
            const figure_panel *panel = &f.panel[p];
            double width = (panel->frame[1] - panel->frame[0]) / (panel->range[0][1] - panel->range[0][0]);
            assert_true(panel->tic[0] * width > 1 / 23.0 && panel->tic[0] * width < 1 / 7.0);
        }
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Headings agree with the drawing: that of the history names marks and bars only if there are any. */
static void the_history_says_what_it_shows(void **state) {
    (void)state;
    static made_up m;
    static const happening lists[][2] = {{{0.4, SALTUS_RELEASE, 0}, {0.6, SALTUS_RELEASE, 1}},
                                         {{0.3, SALTUS_STICK, 0}, {0.6, SALTUS_RELEASE, 0}},
                                         {{0.3, SALTUS_IMPACT, 0}, {0.6, SALTUS_IMPACT, 1}}};
    static const char *const words[2][4] = {
        {"time history; bars: contact", "time history; marks: impacts, bars: contact",
         "time history; marks: impacts", "time history"},
        {"time history; bars: contact", "one orbit; marks: impacts, bar: contact",
         "one orbit; marks: impacts", "one orbit"}};
    saltus_system *system = between_stops(0.033);
    for (int k = 0; k < 8; k++) {
        bool settled = k & 1;
        saltus_motion motion = settled ? orbit_of(1) : irregular();
        make_record(&m, system, 1, lists[k / 2 % 3], k / 2 < 3 ? 2 : 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, words[settled][k / 2]);
        char heading[200];
        snprintf(heading, sizeof heading, "  %s", words[settled][k / 2]);
        int own = (int)(panel - f.panel);
        const char *said = heading_of(panel, own)->text;
        assert_string_equal(said + strlen(said) - strlen(heading), heading);
        assert_true((figure_element_of(panel, "$impacts", 0) != NULL) == (strstr(said, "marks") != NULL));
        assert_true((figure_element_of(panel, "$contacts", 0) != NULL) == (strstr(said, "bar") != NULL));
        figure_free(&f);
    }
    saltus_system_free(system);
}

enum { many = 20050 };

/* A trajectory without rows of interest and a section with many events. */
static saltus_trajectory record_of_events(made_up *m, saltus_event *events, long long *rows, double *time,
                                          long long count) {
    saltus_trajectory r = m->record;
    for (long long k = 0; k < count; k++) {
        double own = (double)k / 64;
        events[k] = (saltus_event){.kind = SALTUS_IMPACT,
                                   .face = k % 3 == 2,
                                   .time = {k / 64, own - floor(own)},
                                   .velocity_before = (k % 3 == 2 ? -1 : 1) * (0.25 + 0.5 * (double)(k % 7))};
        time[k] = own;
        rows[k] = k;
    }
    r.time = time;
    r.samples = count;
    r.events = events;
    r.event_rows = rows;
    r.event_count = count;
    return r;
}

/* Marks of the impact map shrink with their number; beyond twenty thousand only the first are drawn; the
 * heading states their number of periods. */
static void marks_get_smaller_as_they_become_more(void **state) {
    (void)state;
    static made_up m;
    static saltus_event events[many];
    static long long rows[many];
    static double time[many];
    static const struct {
        long long count;
        double size;
        const char *heading;
    } cases[] = {{60, 1.3, "impacts of 0.921875 "},   {61, 0.8, "impacts of 0.9375 "},
                 {400, 0.8, "impacts of 6.23438 "},   {401, 0.5, "impacts of 6.25 "},
                 {20000, 0.5, "impacts of 312.484 "}, {20001, 0.5, "impacts of 312.5 "}};
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = irregular();
    make_record(&m, system, 1, NULL, 0);
    for (int k = 0; k < 6; k++) {
        saltus_trajectory lasting = record_of_events(&m, events, rows, time, cases[k].count);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record, .section = &lasting};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, cases[k].heading);
        int shown = 0;
        for (int face = 0; face < 2; face++) {
            const figure_element *e = &panel->element[face];
            assert_true(strstr(e->style, " ps ") &&
                        strtod(strstr(e->style, " ps ") + 4, NULL) == cases[k].size);
            assert_true((strstr(e->style, "'#60") != NULL) == (cases[k].count > 400));
            shown += e->values.count;
            /* Also where marks are small the legend shows them large. */
            const figure_element *named = &panel->element[cases[k].size < 1.3 ? 2 + face : face];
            assert_true(strstr(named->text, "title 'stop 1, ") && strstr(named->style, " ps 1.3"));
            assert_int_equal(figure_colour(named->style) & 0xffffff, figure_colour(e->style) & 0xffffff);
        }
        assert_int_equal(shown, cases[k].count < 20000 ? cases[k].count : 20000);
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Speeds over more than three decades have a logarithmic axis. Events other than impacts, and impacts without
 * speed, do not count for it; a linear axis includes zero and little more. */
static void speeds_choose_their_axis(void **state) {
    (void)state;
    static made_up m;
    static const happening list[] = {{0.1, SALTUS_IMPACT, 0},
                                     {0.3, SALTUS_STICK, 1},
                                     {0.5, SALTUS_RELEASE, 1},
                                     {0.6, SALTUS_IMPACT, 0},
                                     {0.8, SALTUS_IMPACT, 1}};
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = orbit_of(1);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    for (int k = 0; k < 5; k++) {
        /* The last one is only rounding: no axis goes down to it. */
        double fast = k == 3 ? -2 : 2, slow = k == 4 ? 1e-17 : k % 2 ? fast / 990 : -fast / 1010;
        make_record(&m, system, 1, list, 5);
        m.events[0].velocity_before = fast;
        m.events[1].velocity_before = 0;
        m.events[2].velocity_before = k < 2 ? 1e9 : 1e-9;
        m.events[3].velocity_before = m.events[4].velocity_before = slow;
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = map_of(&f);
        const double *range = panel->range[1];
        assert_true(panel->logarithmic[1] == (k % 2 == 0));
        assert_string_equal(panel->format[1], k % 2 ? "% h" : "10^{%T}");
        if (k % 2 == 0) {
            figure_near(range[0], fmax(fabs(slow), 1e-10 * fast) / 3, 1e-6);
            figure_near(range[1], 3 * fabs(fast), 1e-6);
        } else {
            check_near(range[0], fmin(fast, 0) - 0.16, 1e-6);
            check_near(range[1], fmax(fast, 0) + 0.16, 1e-6);
        }
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Speeds over many decades have numbers that do not touch. */
static void decades_have_room_for_their_numbers(void **state) {
    (void)state;
    static made_up m;
    static const happening list[] = {{0.1, SALTUS_IMPACT, 0}, {0.6, SALTUS_IMPACT, 0}};
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = orbit_of(1);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    const saltus_scene scene = scene_of(system);
    const saltus_flow_options options = saltus_flow_defaults();
    for (int decades = 4; decades <= 10; decades++) {
        const saltus_figure_options look = {.width = 85};
        saltus_message message = {.text = ""};
        char path[path_size];
        make_record(&m, system, 1, list, 2);
        m.events[0].velocity_before = 2;
        m.events[1].velocity_before = 2 * pow(10, -decades);
        check_ok(saltus_write_sheet(path_in("d.svg", path), &scene, system, &options, &diagnosis, &look, NULL,
                                    &message),
                 &message);
        figure f = figure_taken(folder);
        const figure_panel *panel = map_of(&f);
        double wide = 0, high = 0;
        assert_int_equal(sscanf(f.terminal, "svg size %lf,%lf", &wide, &high), 2);
        const double length = (panel->frame[3] - panel->frame[2]) * high,
                     shown = log10(panel->range[1][1] / panel->range[1][0]);
        assert_true(panel->logarithmic[1]);
        /* gnuplot's own tics are one for each decade. */
        assert_true(panel->tic_count[1] == 0 ? length / shown >= 26 : panel->tic_count[1] >= 2);
        for (int k = 1; k < panel->tic_count[1]; k++)
            assert_true(length * log10(panel->tics[1][k] / panel->tics[1][k - 1]) / shown >= 25.9);
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Each side of a stop has its own colour. A single face needs no legend. */
static void stops_have_their_colours(void **state) {
    (void)state;
    static made_up m;
    static const happening list[] = {{0.2, SALTUS_IMPACT, 0}, {0.7, SALTUS_IMPACT, 0}};
    for (int stops = 1; stops <= SALTUS_STOPS_MAX; stops++) {
        saltus_spec spec = oscillator_spec(0.125, 1.75, 1.5, 0.625);
        set_parameter(&spec, "N", 2);
        for (int s = 0; s < stops; s++)
            add_stop(&spec, 0.5 + 0.1 * s, 0.75, stops > 1 ? SALTUS_BOTH : SALTUS_LOWER);
        saltus_system *system = build(&spec);
        saltus_motion motion = orbit_of(1);
        make_record(&m, system, 1, list, 2);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = map_of(&f);
        /* Of more than eight faces only those that are hit. */
        assert_int_equal(panel->element_count, stops > 4 ? 1 : saltus_system_face_count(system));
        assert_true(panel->key == (stops > 1));
        for (int a = 0; a < panel->element_count; a++) {
            const figure_element *trajectory = figure_element_of(&f.panel[0], "$orbit", 0);
            assert_true(figure_colour(panel->element[a].style) != figure_colour(trajectory->style));
            for (int b = 0; b < a; b++)
                assert_true(figure_colour(panel->element[a].style) != figure_colour(panel->element[b].style));
        }
        figure_free(&f);
        saltus_system_free(system);
    }
}

/* An impact has the colour of its side in portrait, history and map, and in the latter two its sign. */
static void sides_have_one_colour(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = orbit_of(2);
    make_record(&m, system, 3, two_impacts, 5);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    figure f = draw(system, &diagnosis);
    const figure_panel *map = map_of(&f);
    const double colour[2] = {(double)figure_colour(map->element[0].style),
                              (double)figure_colour(map->element[1].style)};
    static const char *const blocks[] = {"$jumps", "$impacts"};
    for (int b = 0; b < 2; b++) {
        const figure_element *e = figure_element_of(&f.panel[b], blocks[b], 0);
        assert_non_null(e);
        assert_true(e->values.count == (b ? 4 : 8) && strstr(e->style, "lc rgb variable"));
        for (int k = 0; k < e->values.count; k++) {
            const bool lower = b ? e->values.at[k][1] < 0 : e->values.at[k][0] < 0;
            char sign[40];
            snprintf(sign, sizeof sign, " pt %g ", e->values.at[k][2]);
            assert_true(e->values.at[k][2 + b] == colour[lower]);
            assert_true(!b || (strstr(e->style, "pt variable") && strstr(map->element[lower].style, sign)));
        }
    }
    assert_true(colour[0] != colour[1]);
    figure_free(&f);
    saltus_system_free(system);
}

/* Multipliers and unit circle have a margin of 15 percent around whichever is larger. */
static void the_circle_has_room_about_it(void **state) {
    (void)state;
    static made_up m;
    static const double reach[][2] = {{0.5, 0.1}, {1.3, 0.2}, {-4, 0}, {0.2, 2.5}, {0.1, -7}, {1, 0.99}};
    saltus_system *system = between_stops(0.033);
    for (int k = 0; k < 12; k++) {
        saltus_multiplier one = {reach[k / 2][0], reach[k / 2][1], 0};
        saltus_motion motion = orbit_of(1);
        motion.multipliers = &one;
        motion.multiplier_count = 1;
        make_record(&m, system, 1, two_impacts, k % 2 ? 2 : 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "Floquet multipliers");
        double filled =
            fmax(fmax(1, fabs(one.re)) / panel->range[0][1], fmax(1, fabs(one.im)) / panel->range[1][1]);
        check_near(filled, 1 / 1.15, 1e-4);
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Shapes of a motion without a period are those of its first two periods, sixteen at equal distances, with a
 * colour bar beside the panel. */
static void shapes_are_spread_over_two_periods(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = structure_of(2);
    for (int periods = 1; periods <= 3; periods++) {
        saltus_motion motion = irregular();
        double shown = periods < 2 ? periods : 2;
        make_record(&m, system, periods, NULL, 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "shapes of the pipe");
        const figure_element *lines = figure_element_of(panel, "$shapes", 0);
        int places = figure_element_of(panel, "$envelope", 0)->values.count;
        assert_int_equal(lines->values.count, 16 * places);
        for (int k = 0; k < lines->values.count; k++) {
            double wanted = shown * (k / places) / 16;
            assert_true(lines->values.at[k][2] > wanted - 1e-6 &&
                        lines->values.at[k][2] < wanted + 1.0 / per_period);
        }
        double range[2], tic, at[2], size[2];
        assert_int_equal(
            sscanf(figure_command(&f, "set cbrange", 0), "set cbrange [%lf:%lf]", &range[0], &range[1]), 2);
        assert_true(range[0] == 0 && range[1] == shown);
        assert_int_equal(sscanf(figure_command(&f, "set cbtics", 0), "set cbtics %lf", &tic), 1);
        assert_true(shown / tic >= 2 && shown / tic <= 5);
        assert_int_equal(sscanf(figure_command(&f, "set colorbox", 0),
                                "set colorbox user origin screen %lf,%lf size %lf,%lf", &at[0], &at[1],
                                &size[0], &size[1]),
                         4);
        assert_true(at[0] > panel->frame[1] && at[0] + size[0] < panel->frame[1] + 0.05);
        check_near(at[1], panel->frame[2], 1e-5);
        check_near(size[1], panel->frame[3] - panel->frame[2], 1e-5);
        const figure_mark *bar = figure_mark_of(panel, 'l', "{/:Italic τ}/{/:Italic T}", 0);
        assert_non_null(bar);
        check_near(bar->place[0][0], at[0], 1e-5);
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* A stop within the shapes' width of them is drawn as a whole block, with its tip in the middle; a more
 * distant one is omitted and takes no room. */
static void blocks_are_shown_where_they_are_near(void **state) {
    (void)state;
    static made_up m;
    double low = 0, high = 0;
    for (int k = 0; k < 5; k++) {
        double width = high - low, d = k == 0  ? 9
                                       : k < 3 ? high + (k == 1 ? 0.95 : 1.05) * width
                                               : -low + (k == 3 ? 0.95 : 1.05) * width;
        saltus_spec spec = pipe_spec(2, 20);
        add_stop(&spec, d, 0.75, k < 3 ? SALTUS_UPPER : SALTUS_LOWER);
        spec.stops[0].xi = 0.375;
        saltus_system *system = build(&spec);
        saltus_motion motion = orbit_of(1);
        make_record(&m, system, 1, NULL, 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "shapes of the pipe");
        const figure_element *swept = figure_element_of(panel, "$envelope", 0);
        for (int j = 0; j < swept->values.count; j++) {
            low = fmin(low, swept->values.at[j][1]);
            high = fmax(high, swept->values.at[j][2]);
        }
        const figure_mark *block = figure_mark_of(panel, 'o', "polygon", 0);
        assert_true((block != NULL) == (k % 2 == 1));
        if (!block)
            check_near(panel->range[1][1] - panel->range[1][0], 1.1 * (high - low), 1e-4 * (high - low));
        if (block) {
            double corner[3][2], last[2];
            assert_int_equal(sscanf(strstr(block->text, "from "),
                                    "from %lf,%lf to %lf,%lf to %lf,%lf to %lf,%lf", &corner[0][0],
                                    &corner[0][1], &corner[1][0], &corner[1][1], &corner[2][0], &corner[2][1],
                                    &last[0], &last[1]),
                             8);
            assert_true(last[0] == corner[0][0] && last[1] == corner[0][1] && corner[0][0] == 0.375);
            assert_true(corner[1][1] == corner[2][1] && corner[1][0] > 0.375);
            check_near(corner[1][0] + corner[2][0], 0.75, 1e-9);
            assert_true(corner[1][1] > panel->range[1][0] && corner[1][1] < panel->range[1][1]);
            assert_true(fabs(corner[1][1] - corner[0][1]) > 0.05 * (panel->range[1][1] - panel->range[1][0]));
        }
        figure_free(&f);
        saltus_system_free(system);
    }
}

/* Long numbers of small exponents have room on the left. */
static void small_exponents_have_room_for_their_digits(void **state) {
    (void)state;
    static made_up m;
    static const double sizes[][2] = {{5e-4, 3e-4}, {-5e-4, 3e-4}, {5e-4, 6e-4}, {-5e-4, 6e-4}, {-2, 0.1}};
    saltus_system *system = between_stops(0.033);
    double left[5];
    for (int k = 0; k < 5; k++) {
        saltus_motion motion = irregular();
        saltus_lyapunov_progress list[2] = {{10, sizes[k][0], sizes[k][1]},
                                            {20, sizes[k][0] / 2, sizes[k][1] / 2}};
        motion.lyapunov = sizes[k][0];
        motion.lyapunov_error = sizes[k][1];
        motion.evidence.history = list;
        motion.evidence.history_count = 2;
        make_record(&m, system, 1, NULL, 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        left[k] = figure_panel_of(&f, "convergence")->frame[0];
        figure_free(&f);
    }
    assert_true(left[0] == left[1] && left[0] > left[2] + 0.01 && left[2] == left[3] && left[3] == left[4]);
    saltus_system_free(system);
}

/* A stop's line crosses the picture of both masses from edge to edge, for any coordinate of the stop and
 * place of the masses; the picture shows the motion with a small margin. */
static void a_stop_crosses_the_picture_of_both_masses(void **state) {
    (void)state;
    static made_up m;
    static const double weights[][2] = {{1, 0}, {0, 1}, {1, -1}, {1, 0.002}, {-0.002, 1}, {3, 4}};
    static const double middles[][2] = {{0.1, 0.2}, {10, 0}, {-10, 0}, {0, 10}, {0, -10}, {-7, 7}};
    for (int k = 0; k < 36; k++) {
        const double *w = weights[k % 6], *middle = middles[k / 6];
        double d = w[0] * middle[0] + w[1] * middle[1], low[2], high[2];
        saltus_spec spec = oscillator_spec(0.125, 1.75, 1.5, 0.625);
        set_parameter(&spec, "N", 2);
        add_stop(&spec, fmax(fabs(d), 0.001), 0.75, d < 0 ? SALTUS_LOWER : SALTUS_UPPER);
        memcpy(spec.stops[0].weight, w, sizeof spec.stops[0].weight);
        saltus_system *system = build(&spec);
        saltus_motion motion = orbit_of(1);
        make_record(&m, system, 1, NULL, 0);
        for (int i = 0; i < 2; i++) {
            low[i] = INFINITY;
            high[i] = -INFINITY;
            for (long long row = 0; row < m.record.samples; row++) {
                double *x = &m.states[4 * row + i];
                *x = middle[i] + 10 * *x;
                low[i] = fmin(low[i], *x);
                high[i] = fmax(high[i], *x);
            }
        }
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "both masses");
        double from = -INFINITY, to = INFINITY;
        for (int i = 0; i < 2; i++) {
            figure_sum sum = {.at = panel->element[i].text, .t = 0},
                       end = {.at = panel->element[i].text, .t = 1};
            double foot = figure_choice(&sum), slope = figure_choice(&end) - foot;
            const double *range = panel->range[i];
            check_near(range[0], low[i] - 0.08 * (high[i] - low[i]), 1e-6);
            check_near(range[1], high[i] + 0.08 * (high[i] - low[i]), 1e-6);
            if (fabs(slope) > 1e-12) {
                double a = (range[0] - foot) / slope, b = (range[1] - foot) / slope;
                from = fmax(from, fmin(a, b));
                to = fmin(to, fmax(a, b));
            }
        }
        assert_true(from < to && from >= -1 && to <= 1);
        figure_free(&f);
        saltus_system_free(system);
    }
}

/* The kept script is the one drawn, and names its picture's file, whatever its name; the record beside it is
 * the one shown. */
static void the_script_kept_is_the_one_drawn(void **state) {
    (void)state;
    static made_up m;
    static const char *const names[][2] = {{"it's.svg", "set output 'it''s.svg'\n"},
                                           {"''.pdf", "set output '''''.pdf'\n"},
                                           {"plain.png", "set output 'plain.png'\n"}};
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = orbit_of(1);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_scene scene = scene_of(system);
    make_record(&m, system, 2, two_impacts, 2);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    for (int k = 0; k < 3; k++) {
        saltus_message message = {.text = ""};
        char picture[path_size], data[path_size], path[path_size];
        size_t length, other;
        check_ok(saltus_write_sheet(path_in(names[k][0], picture), &scene, system, &options, &diagnosis, NULL,
                                    path_in("d.x.h5", data), &message),
                 &message);
        char *kept = read_all(path_in("d.x.gp", path), &length),
             *drawn = read_all(path_in("script", path), &other), *at = strstr(kept, names[k][1]);
        size_t own = strlen(names[k][1]);
        assert_true(at && length == other + own && !strstr(drawn, "set output"));
        assert_true(strstr(kept, "set terminal") < at && at[-1] == '\n');
        assert_memory_equal(kept, drawn, (size_t)(at - kept));
        assert_string_equal(at + own, drawn + (at - kept));
        free(kept);
        free(drawn);
        assert_int_equal(access(picture, F_OK), 0);
        remove(picture);
    }
    saltus_system_free(system);
}

/* Impossible pages are refused, and leave nothing behind. */
static void what_is_no_page_is_refused(void **state) {
    (void)state;
    static made_up m, other, one;
    saltus_system *system = between_stops(0.033), *masses = structure_of(1);
    saltus_motion motion = irregular();
    saltus_flow_options options = saltus_flow_defaults();
    saltus_scene scene = scene_of(system);
    make_record(&m, system, 2, two_impacts, 2);
    make_record(&other, masses, 2, NULL, 0);
    make_record(&one, system, 2, NULL, 0);
    one.record.samples = 1;
    const struct {
        const saltus_trajectory *record, *section;
        const char *picture, *data, *words;
    } cases[] = {{&m.record, &m.record, "s.svg", "d.h5", NULL},
                 {&m.record, NULL, "s.jpg", NULL, "s.jpg: the ending must be .png, .pdf or .svg"},
                 {&m.record, NULL, "s.svg", "d.csv", "d.csv: the ending must be .h5"},
                 {&one.record, NULL, "s.svg", NULL, "the record does not belong to the system"},
                 {&other.record, NULL, "s.svg", NULL, "the record does not belong to the system"},
                 {&m.record, &other.record, "s.svg", NULL, "the record does not belong to the system"}};
    for (int k = 0; k < 6; k++) {
        saltus_message message = {.text = ""};
        char picture[path_size], data[path_size];
        const saltus_diagnosis diagnosis = {
            .motion = &motion, .record = cases[k].record, .section = cases[k].section};
        saltus_status status =
            saltus_write_sheet(path_in(cases[k].picture, picture), &scene, system, &options, &diagnosis, NULL,
                               cases[k].data ? path_in(cases[k].data, data) : NULL, &message);
        assert_int_equal(status, cases[k].words ? SALTUS_BAD_INPUT : SALTUS_OK);
        assert_true(!cases[k].words || strstr(message.text, cases[k].words));
        assert_int_equal(access(picture, F_OK) == 0, !cases[k].words);
        if (cases[k].data)
            assert_int_equal(access(data, F_OK) == 0, !cases[k].words);
        remove(picture);
    }
    saltus_system_free(system);
    saltus_system_free(masses);
}

/* An orbit needs no long record, and a first quantity at rest has no spectrum. */
static void an_orbit_is_shown_by_itself(void **state) {
    (void)state;
    static made_up m, lasting;
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = orbit_of(1);
    saltus_spectra spectra = made_spectra(true);
    make_record(&m, system, 1, two_impacts, 2);
    make_record(&lasting, system, 5, two_impacts, 5);
    spectra.spectra[1] = spectra.spectra[0];
    const saltus_diagnosis diagnosis = {
        .motion = &motion, .record = &m.record, .section = &lasting.record, .spectra = &spectra};
    for (int k = 0; k < 3; k++) {
        spectra.count = k == 2 ? 0 : 2;
        spectra.spectra[0].kind = k == 1 ? SALTUS_SPECTRUM_CONSTANT : SALTUS_SPECTRUM_LINES;
        figure f = draw(system, &diagnosis);
        assert_int_equal(f.panel_count, k == 0 ? 5 : 4);
        assert_true((figure_find(&f, "$low1") != NULL) == (k == 0));
        const figure_panel *panel = map_of(&f);
        int shown = 0;
        for (int e = 0; e < panel->element_count; e++)
            shown += panel->element[e].values.count;
        assert_int_equal(shown, 2);
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* On a narrow page an axis has three to six tics, for any range. */
static void narrow_axes_have_enough_tics(void **state) {
    (void)state;
    for (double width = 0.01; width < 200; width *= 1.013)
        for (double low = -3; low < 40; low += 1.7) {
            char text[400] = "";
            double step = 0;
            FILE *file = fmemopen(text, sizeof text, "w");
            const saltus_page page = {.file = file, .width = 600, .height = 600};
            saltus_page_axis(&page, "x", (saltus_frame){.right = 450}, false, "x",
                             (saltus_range){low, low + width});
            fclose(file);
            assert_int_equal(sscanf(strstr(text, "set xtics "), "set xtics %lf", &step), 1);
            double tics = floor((low + width) / step) - ceil(low / step) + 1;
            assert_true(tics >= 3 && tics <= 6);
        }
}

/* A sheet of one column or two is no taller than a journal's page, has all panels beside or below each other,
 * and no heading that leaves the page or reaches into another panel. */
static void a_sheet_fits_a_journal(void **state) {
    (void)state;
    static made_up m;
    const double tallest = 235, mm = 8 * 25.4 / 72 * 3 / 52, type = 7 * 13 / 8.0; /* of a unit of the page */
    saltus_spectra spectra = made_spectra(true);
    saltus_flow_options options = saltus_flow_defaults();
    for (int kind = 0; kind < 3; kind++)
        for (int width = 85; width <= 175; width += 90)
            for (int bare = 0; bare < 2; bare++) {
                saltus_system *system = structure_of(kind);
                saltus_motion motion = orbit_of(2);
                saltus_scene scene = scene_of(system);
                saltus_message message = {.text = ""};
                char picture[path_size];
                make_record(&m, system, 3, two_impacts, 5);
                const saltus_diagnosis diagnosis = {
                    .motion = &motion, .record = &m.record, .spectra = &spectra};
                const saltus_figure_options look = {.width = width, .no_heading = bare};
                check_ok(saltus_write_sheet(path_in("sheet.svg", picture), &scene, system, &options,
                                            &diagnosis, &look, NULL, &message),
                         &message);
                figure f = figure_taken(folder);
                double page[2] = {0};
                assert_int_equal(sscanf(f.terminal, "svg size %lf,%lf", &page[0], &page[1]), 2);
                check_near(page[0] * mm, width, 0.2);
                assert_true(page[1] * mm <= tallest + 0.2 && f.panel_count >= 4);
                for (int p = 0; p < f.panel_count; p++) {
                    const double *own = f.panel[p].frame;
                    assert_true(own[0] > 0 && own[0] < own[1] && own[1] < 1 && own[2] > 0 && own[2] < own[3]);
                    assert_true((own[1] - own[0]) * page[0] > 70 && (own[3] - own[2]) * page[1] > 90);
                    for (int o = 0; o < f.panel_count; o++) {
                        const double *other = f.panel[o].frame;
                        bool apart = own[1] < other[0] || other[1] < own[0] || own[3] < other[2] ||
                                     other[3]<own[2], beside = other[0]> own[1] && other[2] < own[3] + 1e-6 &&
                                         own[2] < other[3];
                        assert_true(o == p || apart);
                        const figure_mark *line;
                        for (int k = 0; k < f.panel[p].mark_count && width == 85; k++) {
                            line = &f.panel[p].mark[k];
                            if (line->kind != 'l' || line->tag < 90)
                                continue;
                            double end = line->place[0][0] * page[0] + saltus_page_width(line->text, type);
                            assert_true(end < page[0] && (!beside || end < other[0] * page[0]));
                        }
                    }
                }
                figure_free(&f);
                saltus_system_free(system);
            }
}

/* A page without room for its panels below the caption is refused, and the size told instead is enough. */
static void a_page_too_small_says_so(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = structure_of(0);
    saltus_motion motion = orbit_of(2);
    saltus_scene scene = scene_of(system);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    make_record(&m, system, 3, two_impacts, 5);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    double enough[2] = {0};
    for (int k = 0; k < 3; k++) {
        const saltus_figure_options look = {.width = k == 2 ? enough[0] : 85,
                                            .height = k == 0   ? 30
                                                      : k == 1 ? 60
                                                               : enough[1]};
        char path[path_size];
        saltus_status status = saltus_write_sheet(path_in("small.svg", path), &scene, system, &options,
                                                  &diagnosis, &look, NULL, &message);
        assert_int_equal(status, k < 2 ? SALTUS_BAD_INPUT : SALTUS_OK);
        if (k == 2)
            continue;
        const char *size = strstr(message.text, "no room for its panels: ");
        assert_non_null(size);
        assert_int_equal(sscanf(size + 24, "%lf x %lf mm would be enough", &enough[0], &enough[1]), 2);
        assert_true(enough[0] == 85 && enough[1] > 85 && enough[1] < 280);
        assert_int_equal(access(path, F_OK), -1);
    }
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_page_has_all_there_is),
        cmocka_unit_test(tics_leave_room_for_their_numbers),
        cmocka_unit_test(the_history_says_what_it_shows),
        cmocka_unit_test(marks_get_smaller_as_they_become_more),
        cmocka_unit_test(speeds_choose_their_axis),
        cmocka_unit_test(decades_have_room_for_their_numbers),
        cmocka_unit_test(stops_have_their_colours),
        cmocka_unit_test(sides_have_one_colour),
        cmocka_unit_test(the_circle_has_room_about_it),
        cmocka_unit_test(shapes_are_spread_over_two_periods),
        cmocka_unit_test(blocks_are_shown_where_they_are_near),
        cmocka_unit_test(a_stop_crosses_the_picture_of_both_masses),
        cmocka_unit_test(the_script_kept_is_the_one_drawn),
        cmocka_unit_test(what_is_no_page_is_refused),
        cmocka_unit_test(an_orbit_is_shown_by_itself),
        cmocka_unit_test(small_exponents_have_room_for_their_digits),
        cmocka_unit_test(narrow_axes_have_enough_tics),
        cmocka_unit_test(a_sheet_fits_a_journal),
        cmocka_unit_test(a_page_too_small_says_so),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
