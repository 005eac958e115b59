/* A motion's page draws its record and verdict. The records are made up, so that every kind of event occurs
 * and the numbers are known.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/page.h"
#include "made_record.h"

static bool is_struck(const saltus_trajectory *r, long long row) {
    for (long long e = 0; e < r->event_count; e++)
        if (r->event_rows[e] == row && r->events[e].kind != SALTUS_RELEASE)
            return true;
    return false;
}

/* An element's line is displacement against velocity of the first rows, in pieces between impacts. */
static void check_trajectory(const figure_element *e, const saltus_trajectory *r, long long rows) {
    assert_non_null(e);
    assert_int_equal(e->values.count, rows);
    for (long long row = 0; row < rows; row++) {
        figure_near(e->values.at[row][0], r->displacement[row], digits);
        figure_near(e->values.at[row][1], r->velocity[row], digits);
        assert_true(e->values.joined[row] == (row > 0 && !is_struck(r, row - 1)));
    }
}

static void check_jumps(const figure_element *e, const saltus_trajectory *r, long long rows) {
    int at = 0;
    for (long long row = 0; row + 1 < rows; row++)
        for (int side = 0; side < 2 && is_struck(r, row); side++, at++) {
            assert_true(at < e->values.count);
            figure_near(e->values.at[at][0], r->displacement[row + side], digits);
            figure_near(e->values.at[at][1], r->velocity[row + side], digits);
            assert_true(e->values.joined[at] == (side == 1));
        }
    assert_int_equal(at, e->values.count);
}

/* Grey beyond a stop up to the edge, and a line at the stop; `axis` is that of the displacement. */
static void check_stop(const figure_panel *panel, int k, int axis, double d, double edge) {
    const figure_mark *grey = figure_mark_of(panel, 'o', "rectangle", k),
                      *line = figure_mark_of(panel, 'a', "nohead", k);
    assert_true(grey && line);
    figure_near(grey->place[0][axis], d, digits);
    figure_near(grey->place[1][axis], edge, digits);
    figure_near(line->place[0][axis], d, digits);
    figure_near(line->place[1][axis], d, digits);
    for (int end = 0; end < 2; end++) {
        assert_true(grey->system[end][axis] == 'f' && grey->system[end][!axis] == 'g');
        assert_true(line->system[end][axis] == 'f' && line->system[end][!axis] == 'g');
        assert_true(grey->place[end][!axis] == end && line->place[end][!axis] == end);
    }
}

/* One closed orbit: the record's rows up to the period only. */
static void a_portrait_is_the_record(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = orbit_of(2);
    make_record(&m, system, 3, two_impacts, 5);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    figure f = draw(system, &diagnosis);
    const figure_panel *panel = figure_panel_of(&f, "phase portrait");
    long long rows = 0;
    while (rows < m.record.samples && m.time[rows] <= 2)
        rows++;
    const figure_element *trajectory = figure_element_of(panel, "$orbit", 0),
                         *jumps = figure_element_of(panel, "$jumps", 0);
    assert_true(strstr(trajectory->style, "with lines") && strstr(jumps->style, "with lines"));
    check_trajectory(trajectory, &m.record, rows);
    check_jumps(jumps, &m.record, rows);
    for (int k = 0; k < 2; k++) {
        const figure_element *dots = figure_element_of(panel, "$strobe", k);
        assert_true(dots && strstr(dots->style, "with points"));
        assert_int_equal(dots->values.count, 2);
        for (int p = 0; p < 2; p++) {
            figure_near(dots->values.at[p][0], observed(system, m.strobes + 2 * p), digits);
            figure_near(dots->values.at[p][1], observed(system, m.strobes + 2 * p + 1), digits);
        }
    }
    for (int k = 0; k < panel->element_count; k++)
        figure_check_inside(panel, &panel->element[k]);
    check_stop(panel, 0, 0, 0.033, panel->range[0][1]);
    check_stop(panel, 1, 0, -0.033, panel->range[0][0]);
    assert_null(figure_mark_of(panel, 'o', "rectangle", 2));
    assert_non_null(strstr(panel->label[0], "displacement {/:Italic x}_1"));
    assert_non_null(strstr(panel->label[1], "velocity"));
    /* No more room than the data need. */
    assert_true(panel->range[0][1] - panel->range[0][0] < 1.2 * 0.068);
    figure_says(&f, "made\\_up:  3/2, stable");
    figure_says(&f, "it's \\{made\\} up");
    figure_says(&f, "{/:Italic ω} = 0.625");
    figure_says(&f, "{/:Italic c} = 0.125");
    figure_says(&f, "{/:Italic k} = 1.75");
    figure_says(&f, "{/:Italic F} = 1.5");
    figure_says(&f, "stop: {/:Italic d} = 0.033, {/:Italic r} = 0.75, both sides");
    figure_says(&f, "3 impacts in 2 {/:Italic T}, 1.5 per response cycle");
    figure_says(&f, "0.3 ± 0.4{/:Italic i} (modulus 0.5)");
    figure_says(&f, "/(2 {/:Italic T}) = −0.0625 per unit of time");
    figure_free(&f);
    saltus_system_free(system);
}

/* A stop far from the motion is neither drawn nor given room; a near one gets both. */
static void stops_are_shown_where_they_are_near(void **state) {
    (void)state;
    static made_up m;
    const double reach = 0.031; /* of the motion, on both sides */
    for (int k = 0; k < 2; k++) {
        double d = reach + (k ? 1.15 : 1.25) * 2 * reach * 0.5;
        saltus_system *system = between_stops(d);
        saltus_motion motion = orbit_of(1);
        make_record(&m, system, 1, NULL, 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "phase portrait");
        assert_true((figure_mark_of(panel, 'o', "rectangle", 0) != NULL) == (k == 1));
        assert_true((panel->range[0][1] > d) == (k == 1));
        assert_true((panel->range[0][0] < -d) == (k == 1));
        assert_null(figure_element_of(panel, "$jumps", 0));
        assert_non_null(strstr(figure_panel_of(&f, "one orbit")->label[0], "time"));
        figure_free(&f);
        saltus_system_free(system);
    }
}

/* Impacts and contacts of a record against time. */
static void check_history(const figure_panel *panel, const saltus_trajectory *r, double end,
                          const double (*contacts)[3], int count) {
    const figure_element *line = figure_element_of(panel, "$history", 0),
                         *dots = figure_element_of(panel, "$impacts", 0),
                         *bars = figure_element_of(panel, "$contacts", 0);
    int at = 0, struck = 0;
    assert_non_null(line);
    for (long long row = 0; row < r->samples && r->time[row] <= end; row++, at++) {
        assert_true(at < line->values.count);
        figure_near(line->values.at[at][0], r->time[row], digits);
        figure_near(line->values.at[at][1], r->displacement[row], digits);
    }
    assert_int_equal(at, line->values.count);
    for (long long e = 0; e < r->event_count; e++) {
        if (r->events[e].kind == SALTUS_RELEASE || r->time[r->event_rows[e]] > end)
            continue;
        assert_true(dots && struck < dots->values.count);
        figure_near(dots->values.at[struck][0], r->time[r->event_rows[e]], digits);
        figure_near(dots->values.at[struck++][1], r->displacement[r->event_rows[e]], digits);
    }
    assert_int_equal(dots ? dots->values.count : 0, struck);
    assert_int_equal(bars ? bars->values.count : 0, 2 * count);
    for (int k = 0; k < count; k++) {
        bool found = false;
        for (int b = 0; b < bars->values.count; b += 2) {
            const double *from = bars->values.at[b], *to = bars->values.at[b + 1];
            assert_true(!bars->values.joined[b] && bars->values.joined[b + 1]);
            found = found || (fabs(from[0] - contacts[k][0]) < 1e-7 && fabs(to[0] - contacts[k][1]) < 1e-7 &&
                              fabs(from[1] - contacts[k][2]) < 1e-7 && from[1] == to[1]);
        }
        if (!found)
            fail_msg("no contact from %g to %g at %g is drawn", contacts[k][0], contacts[k][1],
                     contacts[k][2]);
    }
    assert_true(panel->range[0][0] == 0);
    figure_near(panel->range[0][1], end, digits);
    assert_non_null(strstr(panel->label[0], "time"));
    check_stop(panel, 0, 1, 0.033, panel->range[1][1]);
    check_stop(panel, 1, 1, -0.033, panel->range[1][0]);
}

/* Contacts that begin and end, that hold from the start or to the end, on either face; an impact before a
 * release without a begin is no contact. */
static void contacts_are_drawn_from_stick_to_release(void **state) {
    (void)state;
    static made_up m;
    static const happening lists[][7] = {
        {{0.2, SALTUS_IMPACT, 0},
         {0.3, SALTUS_STICK, 0},
         {0.55, SALTUS_RELEASE, 0},
         {0.7, SALTUS_IMPACT, 1},
         {0.8, SALTUS_STICK, 1},
         {1.1, SALTUS_RELEASE, 1},
         {1.7, SALTUS_STICK, 0}},
        {{0.3, SALTUS_RELEASE, 1}, {0.9, SALTUS_STICK, 1}},
        {{0.3, SALTUS_IMPACT, 0}, {0.5, SALTUS_RELEASE, 0}, {0.9, SALTUS_STICK, 0}, {1.2, SALTUS_RELEASE, 0}},
        {{0.4, SALTUS_STICK, 0}, {0.9, SALTUS_RELEASE, 0}, {1.3, SALTUS_RELEASE, 0}},
        {{0.7, SALTUS_RELEASE, 0}, {0.9, SALTUS_RELEASE, 1}},
    };
    static const int lengths[] = {7, 2, 4, 3, 2}, counts[] = {3, 2, 1, 1, 2};
    static const double contacts[][3][3] = {{{0.3, 0.55, 0.033}, {0.8, 1.1, -0.033}, {1.7, 2, 0.033}},
                                            {{0, 0.3, -0.033}, {0.9, 2, -0.033}},
                                            {{0.9, 1.2, 0.033}},
                                            {{0.4, 0.9, 0.033}},
                                            {{0, 0.7, 0.033}, {0, 0.9, -0.033}}};
    static const char *const headings[] = {"marks: impacts, bar: contact", "marks: impacts, bar: contact",
                                           "marks: impacts, bar: contact", "marks: impacts, bar: contact",
                                           "bars: contact"};
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = orbit_of(2);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    for (int k = 0; k < 5; k++) {
        make_record(&m, system, 2, lists[k], lengths[k]);
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, headings[k]);
        check_history(panel, &m.record, 2, contacts[k], counts[k]);
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* A mass always held by a stop: no event shows it. */
static void a_contact_for_good_is_drawn_throughout(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = {.verdict = SALTUS_HELD, .label = "held", .lyapunov = NAN};
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    for (int face = 0; face < 3; face++) {
        double place = (face == 0 ? 1 : face == 1 ? -1 : 0.5) * 0.033;
        make_record(&m, system, 2, NULL, 0);
        for (long long row = 0; row < m.record.samples; row++) {
            m.states[2 * row] = m.displacement[row] = place;
            m.states[2 * row + 1] = m.velocity[row] = 0;
        }
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, face == 2 ? "time history" : "bars: contact");
        const figure_element *bars = figure_element_of(panel, "$contacts", 0);
        assert_true((bars != NULL) == (face < 2));
        if (bars) {
            assert_int_equal(bars->values.count, 2);
            assert_true(bars->values.at[0][0] == 0 && bars->values.at[1][0] == 2);
            figure_near(bars->values.at[0][1], place, digits);
        }
        figure_says(&f, "in contact for good");
        figure_free(&f);
    }
    /* It touches the stop at both ends and moves between. */
    for (long long row = 1; row + 1 < m.record.samples; row++)
        m.velocity[row] = 0.1;
    for (long long row = 0; row < m.record.samples; row += m.record.samples - 1)
        m.states[2 * row] = m.displacement[row] = 0.033;
    figure f = draw(system, &diagnosis);
    assert_null(figure_element_of(figure_panel_of(&f, "time history"), "$contacts", 0));
    figure_free(&f);
    saltus_system_free(system);
}

/* The impacts shown by one face's marks: triangles up for upper sides, in the order of events. */
static void check_face(const figure_panel *panel, const saltus_system *system, const saltus_trajectory *r,
                       long long events, int face, bool size_alone) {
    saltus_face own = saltus_system_face(system, face);
    const figure_element *e = &panel->element[face];
    char title[40];
    int at = 0;
    snprintf(title, sizeof title, "stop %d, %s side", own.stop + 1, own.side > 0 ? "upper" : "lower");
    assert_string_equal(e->title, title);
    assert_non_null(strstr(e->style, own.side > 0 ? "pt 9 " : "pt 11 "));
    for (long long k = 0; k < events; k++) {
        double v = r->events[k].velocity_before;
        if (r->events[k].kind == SALTUS_RELEASE || r->events[k].face != face)
            continue;
        assert_true(at < e->values.count);
        figure_near(e->values.at[at][0], r->events[k].time.phase, digits);
        figure_near(e->values.at[at++][1], size_alone ? fabs(v) : v, digits);
    }
    assert_int_equal(at, e->values.count);
    figure_check_inside(panel, e);
}

/* Phase and normal velocity before each impact, by stop and side; of chatter on a logarithmic axis. */
static void an_impact_map_is_the_events(void **state) {
    (void)state;
    static made_up m;
    static const happening list[] = {{0.1, SALTUS_IMPACT, 0},  {0.35, SALTUS_IMPACT, 2},
                                     {0.7, SALTUS_IMPACT, 1},  {0.9, SALTUS_STICK, 2},
                                     {1.2, SALTUS_RELEASE, 2}, {1.31, SALTUS_IMPACT, 1}};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 0.6);
    set_parameter(&spec, "N", 2);
    add_stop(&spec, 0.033, 0.75, SALTUS_BOTH);
    add_stop(&spec, 0.02, 0.5, SALTUS_UPPER);
    spec.stops[1].weight[0] = -1;
    spec.stops[1].weight[1] = 1;
    saltus_system *system = build(&spec);
    saltus_motion motion = orbit_of(2);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    assert_int_equal(saltus_system_face_count(system), 3);
    for (int slow = 0; slow < 2; slow++) {
        make_record(&m, system, 2, list, 6);
        if (slow)
            m.events[0].velocity_before = 1e-5;
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, slow ? "impact speed" : "velocity before impact");
        assert_true(panel->logarithmic[1] == slow && !panel->logarithmic[0]);
        assert_int_equal(panel->element_count, 3);
        for (int face = 0; face < 3; face++)
            check_face(panel, system, &m.record, 6, face, slow);
        assert_true(panel->range[0][0] == 0 && panel->range[0][1] == 1);
        assert_true((panel->range[1][0] > 0) == slow);
        /* A panel's scale does not affect the next. */
        for (int p = 0; p < f.panel_count; p++)
            assert_true(&f.panel[p] == panel || !f.panel[p].logarithmic[1]);
        /* The stop that does not limit the coordinate shown has no line. */
        assert_null(figure_mark_of(figure_panel_of(&f, "phase portrait"), 'o', "rectangle", 2));
        figure_says(&f, "stop 1: {/:Italic x}_1, {/:Italic d} = 0.033, {/:Italic r} = 0.75, both sides");
        figure_says(&f, "stop 2: −{/:Italic x}_1 + {/:Italic x}_2, {/:Italic d} = 0.02, {/:Italic r} = 0.5, "
                        "upper");
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Without a period: section points and impacts of the long record, the trajectory of the short one, with
 * twenty periods as time history. */
static void the_section_is_of_the_long_record(void **state) {
    (void)state;
    static made_up shown, lasting;
    static const happening more[] = {
        {0.15, SALTUS_IMPACT, 1}, {3.4, SALTUS_IMPACT, 0}, {7.8, SALTUS_STICK, 0}};
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = irregular();
    make_record(&shown, system, 22, two_impacts, 5);
    make_record(&lasting, system, 9, more, 3);
    const saltus_diagnosis diagnosis = {
        .motion = &motion, .record = &shown.record, .section = &lasting.record};
    figure f = draw(system, &diagnosis);
    const figure_panel *section = figure_panel_of(&f, "stroboscopic section, 9 points"),
                       *map = figure_panel_of(&f, "impacts of 9");
    const figure_element *dots = figure_element_of(section, "$section", 0);
    assert_int_equal(dots->values.count, 9);
    for (int k = 0; k < 9; k++) {
        figure_near(dots->values.at[k][0], observed(system, lasting.strobes + 2 * k), digits);
        figure_near(dots->values.at[k][1], observed(system, lasting.strobes + 2 * k + 1), digits);
    }
    figure_check_inside(section, dots);
    for (int face = 0; face < 2; face++)
        check_face(map, system, &lasting.record, 3, face, false);
    check_trajectory(figure_element_of(figure_panel_of(&f, "phase portrait"), "$orbit", 0), &shown.record,
                     shown.record.samples);
    check_history(figure_panel_of(&f, "time history; marks: impacts"), &shown.record, 20, NULL, 0);
    figure_says(&f, "exponent 0.1 ± 0.2 and 0.3 ± 0.4 so far ");
    figure_says(&f, "shown: 22 periods, section 9");
    assert_null(figure_find(&f, "$multipliers"));
    figure_free(&f);
    saltus_system_free(system);
}

/* Multipliers are at their places, the unit circle is round for any shape of the panel, and all of them
 * fit. */
static void multipliers_lie_about_the_unit_circle(void **state) {
    (void)state;
    static made_up m;
    saltus_multiplier list[] = {{-3.5, 0, 0}, {0.25, 2.25, 0}, {0.25, -2.25, 0}, {0.5, 0, 0}, {0.125, 0, 0}};
    saltus_system *system = between_stops(0.033);
    for (int many = 0; many < 3; many++) {
        saltus_motion motion = orbit_of(1);
        motion.multipliers = many == 2 ? &list[1] : list;
        motion.multiplier_count = many == 0 ? 5 : many == 1 ? 1 : 2;
        motion.stable = false;
        make_record(&m, system, 1, two_impacts, many == 1 ? 0 : 2);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "Floquet multipliers");
        const figure_element *dots = figure_element_of(panel, "$multipliers", 0);
        assert_int_equal(dots->values.count, motion.multiplier_count);
        for (int k = 0; k < motion.multiplier_count; k++) {
            assert_true(dots->values.at[k][0] == motion.multipliers[k].re);
            assert_true(dots->values.at[k][1] == motion.multipliers[k].im);
        }
        figure_check_inside(panel, dots);
        assert_non_null(figure_mark_of(panel, 'o', "circle at 0,0 size first 1 ", 0));
        double across =
                   1600 * (panel->frame[1] - panel->frame[0]) / (panel->range[0][1] - panel->range[0][0]),
               up = 1200 * (panel->frame[3] - panel->frame[2]) / (panel->range[1][1] - panel->range[1][0]);
        check_near(across / up, 1, 1e-3);
        assert_true(panel->range[0][1] > 1 && panel->range[1][1] > 1);
        assert_true(panel->range[0][0] == -panel->range[0][1] && panel->range[1][0] == -panel->range[1][1]);
        figure_says(&f, "unstable");
        figure_says(&f, many == 0   ? "multipliers −3.5,  0.25 ± 2.25{/:Italic i} (modulus 1),  0.5, …"
                        : many == 1 ? "multipliers −3.5"
                                    : "multipliers 0.25 ± 2.25{/:Italic i}");
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* A pipe bent by its modes: sums of sines at sixteen times of the orbit, and the region that they sweep. */
static void shapes_are_sums_of_sines(void **state) {
    (void)state;
    static made_up m;
    enum { modes = 3, shapes = 16 };
    saltus_spec spec = pipe_spec(modes, 20);
    add_stop(&spec, 0.02, 0.75, SALTUS_UPPER);
    add_stop(&spec, 0.025, 0.5, SALTUS_LOWER);
    spec.stops[0].xi = 0.25;
    spec.stops[1].xi = 0.625;
    saltus_system *system = build(&spec);
    saltus_motion motion = orbit_of(2);
    make_record(&m, system, 2, NULL, 0);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    figure f = draw(system, &diagnosis);
    const figure_panel *panel = figure_panel_of(&f, "shapes of the pipe");
    const figure_element *lines = figure_element_of(panel, "$shapes", 0),
                         *swept = figure_element_of(panel, "$envelope", 0);
    int places = swept->values.count, shape = -1;
    assert_true(places > 20 && lines->values.count == shapes * places);
    for (int k = 0; k < lines->values.count; k++) {
        const double *at = lines->values.at[k];
        double eta = 0;
        shape += !lines->values.joined[k];
        /* 24 rows per period, two periods: every third row. */
        long long row = 3LL * shape;
        for (int i = 0; i < modes; i++)
            eta += m.states[row * 2 * modes + i] * sin((i + 1) * acos(-1.0) * at[0]);
        check_near(at[1], eta, 3e-5);
        check_near(at[2], m.time[row], 1e-5);
        assert_true(k % places == 0 ? at[0] == 0 : at[0] > lines->values.at[k - 1][0]);
        assert_true(k % places < places - 1 || at[0] == 1);
    }
    assert_int_equal(shape, shapes - 1);
    for (int k = 0; k < places; k++) {
        double low = INFINITY, high = -INFINITY, xi = swept->values.at[k][0];
        for (long long row = 0; row < m.record.samples; row++) {
            double eta = 0;
            for (int i = 0; i < modes; i++)
                eta += m.states[row * 2 * modes + i] * sin((i + 1) * acos(-1.0) * xi);
            low = fmin(low, eta);
            high = fmax(high, eta);
        }
        check_near(swept->values.at[k][1], low, 3e-5);
        check_near(swept->values.at[k][2], high, 3e-5);
    }
    figure_check_inside(panel, lines);
    for (int s = 0; s < 2; s++) {
        const figure_mark *block = figure_mark_of(panel, 'o', "polygon", s);
        double d = s ? -0.025 : 0.02;
        assert_non_null(block);
        figure_near(block->place[0][0], spec.stops[s].xi, digits);
        figure_near(block->place[0][1], d, digits);
        /* The stop is beyond its tip. */
        assert_true(s ? block->place[1][1] < d : block->place[1][1] > d);
        assert_true(d > panel->range[1][0] && d < panel->range[1][1]);
    }
    assert_true(panel->range[0][0] == 0 && panel->range[0][1] == 1);
    /* The phase portrait is of the first stop's place. */
    assert_non_null(strstr(figure_panel_of(&f, "phase portrait")->label[0], "(0.25, "));
    figure_says(&f, "stop 1: {/:Italic ξ} = 0.25, {/:Italic d} = 0.02");
    figure_says(&f, "stop 2: {/:Italic ξ} = 0.625, {/:Italic d} = 0.025, {/:Italic r} = 0.5, lower");
    figure_free(&f);
    saltus_system_free(system);
}

/* The two masses' displacements against each other, and each stop as the line where its coordinate equals the
 * clearance. */
static void masses_are_drawn_against_their_stops(void **state) {
    (void)state;
    static made_up m;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 0.6);
    set_parameter(&spec, "N", 2);
    add_stop(&spec, 0.03, 0.75, SALTUS_BOTH);
    spec.stops[0].weight[0] = 0.5;
    spec.stops[0].weight[1] = -1.25;
    saltus_system *system = build(&spec);
    saltus_motion motion = orbit_of(1);
    make_record(&m, system, 1, NULL, 0);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    figure f = draw(system, &diagnosis);
    const figure_panel *panel = figure_panel_of(&f, "both masses");
    const figure_element *line = figure_element_of(panel, "$masses", 0);
    assert_int_equal(line->values.count, m.record.samples);
    for (int k = 0; k < line->values.count; k++) {
        figure_near(line->values.at[k][0], m.states[4 * k], digits);
        figure_near(line->values.at[k][1], m.states[4 * k + 1], digits);
    }
    figure_check_inside(panel, line);
    assert_true(panel->parametric && panel->element_count == 5);
    for (int face = 0; face < 2; face++)
        for (int end = -1; end <= 1; end++) {
            double x[2];
            for (int i = 0; i < 2; i++) {
                figure_sum sum = {.at = panel->element[2 * face + i].text, .t = end};
                x[i] = figure_choice(&sum);
            }
            check_near(0.5 * x[0] - 1.25 * x[1], saltus_system_face(system, face).side * 0.03, 1e-8);
            /* The line crosses the whole panel. */
            assert_true(end == 0 || fabs(x[0]) > panel->range[0][1] || fabs(x[1]) > panel->range[1][1]);
        }
    figure_says(&f, "stop: 0.5 {/:Italic x}_1 − 1.25 {/:Italic x}_2, {/:Italic d} = 0.03");
    assert_non_null(strstr(figure_panel_of(&f, "phase portrait")->label[0], "contact coordinate"));
    for (int p = 0; p < f.panel_count; p++)
        assert_true(&f.panel[p] == panel || !f.panel[p].parametric);
    figure_free(&f);
    saltus_system_free(system);
}

/* The estimate's last finite stretch with its band, beside the spectrum's lines. */
static void exponents_and_lines_are_those_measured(void **state) {
    (void)state;
    static made_up m;
    saltus_lyapunov_progress history[] = {{10, 0.9, 0.3},     {20, NAN, 0.1},    {30, 0.8, INFINITY},
                                          {40, 0.625, 0.125}, {60, 0.5, 0.0625}, {100, 0.5625, 0.03125}};
    saltus_spectral_line lines[] = {{1, 0.5, 0.25, 0, -20, 0.1},
                                    {2, 1, 2.5, 0, 0, 0.8},
                                    {3, 1.5, 0.5, 0, -14, 0.1},
                                    {4, 2, 0.025, 0, -40, 0.01},
                                    {9, 4.5, 0.00125, 0, -66, 0}};
    double density[9] = {0};
    saltus_spectra spectra = {.count = 1,
                              .quantities = {{0, false}},
                              .spectra = {{.kind = SALTUS_SPECTRUM_LINES,
                                           .per_period = 64,
                                           .bins = 9,
                                           .resolution = 0.5,
                                           .density = density,
                                           .orbits = 1,
                                           .periods = 2,
                                           .lines = lines,
                                           .line_count = 5,
                                           .between = NAN,
                                           .trustworthy = 3.75}},
                              .periods = 2};
    saltus_system *system = between_stops(0.033);
    saltus_motion motion = irregular();
    motion.verdict = SALTUS_CHAOTIC;
    strcpy(motion.label, "chaotic");
    motion.lyapunov = 0.5625;
    motion.lyapunov_error = 0.03125;
    motion.evidence = (saltus_evidence){.periods = 77,
                                        .members = 5,
                                        .half = {0.5, 0.625},
                                        .half_errors = {0.0625, 0.0625},
                                        .zero_one = 0.875,
                                        .dimension = 1.25,
                                        .dimension_error = 0.0625,
                                        .broadband = 0.375,
                                        .impacts_per_period = 1.625,
                                        .history = history,
                                        .history_count = 6};
    make_record(&m, system, 3, two_impacts, 5);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record, .spectra = &spectra};
    figure f = draw(system, &diagnosis);
    const figure_panel *panel = figure_panel_of(&f, "convergence of the largest exponent");
    const figure_element *band = figure_element_of(panel, "filledcurves", 0),
                         *line = figure_element_of(panel, "'estimate'", 0);
    assert_true(band && line && band->values.count == 3 && line->values.count == 3);
    for (int k = 0; k < 3; k++) {
        const saltus_lyapunov_progress *p = &history[3 + k];
        assert_true(line->values.at[k][0] == p->time && line->values.at[k][1] == p->exponent);
        assert_true(band->values.at[k][0] == p->time);
        check_near(band->values.at[k][1], fmax(p->exponent - p->standard_error, panel->range[1][0]), 1e-8);
        check_near(band->values.at[k][2], fmin(p->exponent + p->standard_error, panel->range[1][1]), 1e-8);
    }
    figure_check_inside(panel, line);
    assert_true(panel->logarithmic[0]);
    const figure_mark *last = figure_mark_of(panel, 'a', "dt (12,9)", 0);
    assert_true(last && last->place[0][1] == 0.5625 && last->place[1][1] == 0.5625);
    const figure_panel *low = figure_panel_of(&f, "frequency");
    int at[2] = {0, 0};
    for (int k = 0; k < 5; k++) {
        int forced = lines[k].harmonic % 2 == 0;
        const figure_element *dots = figure_element_of(low, "with points", forced);
        if (lines[k].frequency > low->range[0][1])
            continue;
        assert_true(dots->values.at[at[forced]][0] == lines[k].frequency);
        assert_true(dots->values.at[at[forced]++][1] == lines[k].decibels);
    }
    for (int forced = 0; forced < 2; forced++)
        assert_int_equal(figure_element_of(low, "with points", forced)->values.count, at[forced]);
    assert_true(at[0] >= 2 && at[1] == 2);
    figure_says(&f, "0.562 ± 0.031 per unit of time");
    figure_says(&f, "over 77 periods by 5 trajectories");
    figure_says(&f, "exponent in the halves of the run 0.500 ± 0.062 and 0.625 ± 0.062;  0–1 test 0.875;  "
                    "correlation dimension 1.250 ± 0.062;  broadband fraction 0.38; ");
    figure_says(&f, ";  1.625 impacts per {/:Italic T}");
    figure_free(&f);
    saltus_system_free(system);
}

/* The panels have the letters a, b, c, ... from left to right and from the top. */
static void panels_are_lettered_as_they_are_read(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = between_stops(0.033);
    for (int impacts = 0; impacts < 3; impacts++) {
        saltus_motion motion = orbit_of(1);
        motion.multiplier_count = impacts == 2 ? 0 : 2;
        make_record(&m, system, 1, two_impacts, impacts ? 2 : 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
        figure f = draw(system, &diagnosis);
        assert_int_equal(f.panel_count, impacts == 1 ? 4 : 3);
        for (int p = 0; p < f.panel_count; p++) {
            char words[32];
            snprintf(words, sizeof words, "{/:Bold (%c)}", 'a' + p);
            const figure_mark *heading = figure_mark_of(&f.panel[p], 'l', words, 0);
            assert_non_null(heading);
            check_near(heading->place[0][0], f.panel[p].frame[0], 1e-5);
            check_near(heading->place[0][1], f.panel[p].frame[3], 1e-5);
            if (p == 0)
                continue;
            const double *a = f.panel[p - 1].frame, *b = f.panel[p].frame;
            assert_true((b[0] > a[1] && fabs(b[3] - a[3]) < 0.06) || b[3] < a[2]);
        }
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Records too long for a picture are cut at whole periods. */
static void long_records_are_cut_at_whole_periods(void **state) {
    (void)state;
    enum { samples = 61000, a_period = 500 };
    saltus_system *system = between_stops(5);
    saltus_motion motion = irregular();
    double *time = calloc(samples, sizeof *time), *states = calloc(2 * samples, sizeof *states);
    double strobes[2 * (samples / a_period + 1)];
    saltus_trajectory record = {.dimension = 2,
                                .samples = samples,
                                .time = time,
                                .states = states,
                                .displacement = states,
                                .velocity = states + samples,
                                .strobe_states = strobes};
    assert_true(time && states);
    for (int k = 0; k < samples; k++)
        time[k] = (k + 130.0) / a_period - 130.0 / a_period;
    for (int k = 0; k * a_period + a_period < samples; k++) {
        strobes[2 * k] = k;
        strobes[2 * k + 1] = -k;
        record.strobes = k + 1;
    }
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &record};
    figure f = draw(system, &diagnosis);
    const figure_element *line = figure_element_of(figure_panel_of(&f, "phase portrait"), "$orbit", 0),
                         *dots = figure_element_of(figure_panel_of(&f, "phase portrait"), "$strobe", 0),
                         *history = figure_element_of(figure_panel_of(&f, "time history"), "$history", 0);
    assert_true(line->values.count % a_period == 1 && line->values.count <= 60001);
    assert_true(line->values.count > 60001 - a_period);
    assert_int_equal(dots->values.count, line->values.count / a_period);
    assert_int_equal(history->values.count, 20 * a_period + 1);
    figure_free(&f);
    free(time);
    free(states);
    saltus_system_free(system);
}

/* A caption too long for a line continues on the next, between words, and nothing is lost. */
static void long_captions_are_broken_between_words(void **state) {
    (void)state;
    static made_up m;
    saltus_spec spec = oscillator_spec(0.123456, 1.23456, 1.34567, 0.654321);
    saltus_motion motion = orbit_of(1);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    set_parameter(&spec, "N", 2);
    for (int s = 0; s < 4; s++) {
        add_stop(&spec, 0.0312345 + 0.001 * s, 0.712345, s % 2 ? SALTUS_UPPER : SALTUS_BOTH);
        spec.stops[s].weight[0] = 0.512345;
        spec.stops[s].weight[1] = -1.12345 - s;
    }
    saltus_system *system = build(&spec);
    make_record(&m, system, 1, NULL, 0);
    figure f = draw(system, &diagnosis);
    int lines = 0;
    for (int k = 0; k < f.panel[0].mark_count; k++) {
        const figure_mark *mark = &f.panel[0].mark[k];
        int letters = 0;
        if (mark->kind != 'l' || mark->system[0][0] != 's' || mark->place[0][0] != 0.03)
            continue;
        for (const char *c = mark->text; *c; c++) {
            if (strncmp(c, "{/:Italic ", 10) == 0)
                c += 10;
            letters += (*c & 0xc0) != 0x80 && !strchr("{}_", *c);
        }
        assert_true(letters < 160 && mark->text[0] != ' ');
        lines++;
    }
    assert_in_range(lines, 6, 8);
    for (int s = 0; s < 4; s++) {
        char words[200];
        snprintf(
            words, sizeof words,
            "stop %d: 0.512345 {/:Italic x}_1 − %.6g {/:Italic x}_2, {/:Italic d} = %.6g, {/:Italic r} = "
            "0.712345, %s",
            s + 1, 1.12345 + s, spec.stops[s].d, s % 2 ? "upper" : "both sides");
        figure_says(&f, words);
    }
    figure_free(&f);
    saltus_system_free(system);
}

/* Constant values have a margin, and a motion at rest is named so. */
static void a_rest_has_room_about_it(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = between_stops(50);
    saltus_motion motion = {.verdict = SALTUS_EQUILIBRIUM, .label = "equilibrium", .lyapunov = NAN};
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    for (int k = 0; k < 2; k++) {
        make_record(&m, system, 2, NULL, 0);
        for (long long row = 0; row < m.record.samples; row++) {
            m.displacement[row] = m.states[2 * row] = k ? -7 : 0.01;
            m.velocity[row] = m.states[2 * row + 1] = 0;
        }
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "phase portrait");
        double place = k ? -7 : 0.01, size = fmax(saltus_system_scale(system)[0], fabs(place));
        check_near(panel->range[0][0], place - 1.14 * size, 1e-6 * size);
        check_near(panel->range[0][1], place + 1.14 * size, 1e-6 * size);
        assert_true(panel->range[1][0] < 0 && panel->range[1][1] > 0);
        figure_says(&f, "at rest, clear of every stop");
        figure_free(&f);
    }
    saltus_system_free(system);
}

static double page_height(const figure *f) {
    double height = 0;
    assert_int_equal(sscanf(f->terminal, "svg size %*f,%lf", &height), 1);
    return height;
}

/* The names of the stops' sides have room beside the impacts, or in one column above them. */
static void names_of_sides_stay_on_the_page(void **state) {
    (void)state;
    static made_up m;
    const double sign = 37, letter = 7.6; /* widths, in the page's units */
    saltus_system *system = between_stops(0.033);
    saltus_scene scene = scene_of(system);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_motion motion = orbit_of(1);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    make_record(&m, system, 1, two_impacts, 2);
    for (int column = 0; column < 2; column++) {
        const saltus_figure_options look = {.width = column ? 85 : 0};
        saltus_message message = {.text = ""};
        char path[path_size];
        check_ok(saltus_write_sheet(path_in("sheet.svg", path), &scene, system, &options, &diagnosis, &look,
                                    NULL, &message),
                 &message);
        figure f = figure_taken(folder);
        const figure_panel *panel = figure_panel_of(&f, "(mod 1)");
        const figure_element *side = figure_element_of(panel, column ? "1, lower" : "lower side", 0);
        double page = strtod(f.terminal + strlen("svg size "), NULL);
        assert_true(side && panel->key && page > 400);
        assert_true((1 - panel->frame[!column]) * page >
                    sign + letter * (double)strlen(column ? "stop 1, upper" : "stop 1, upper side"));
        const figure_mark *heading = figure_mark_of(panel, 'l', "{/:Bold (", 0);
        double above = (heading->place[0][1] - panel->frame[3]) * page_height(&f);
        assert_true(column ? above > 2 * 17 && above < 2 * 30 : fabs(above) < 0.1);
        /* Between columns of panels the names of axes do not reach into the headings. */
        for (int p = 0; p < f.panel_count && column; p++) {
            const double *frame = f.panel[p].frame;
            assert_true(frame[1] - frame[0] >= 0.5 || saltus_page_width(f.panel[p].label[1], 11.375) <
                                                          (frame[3] - frame[2]) * page_height(&f) + 7);
        }
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* A trajectory is drawn from its file with stops, jumps and impacts as on a sheet, also in one column, where
 * its headings fit. */
static void a_trajectory_has_its_stops(void **state) {
    (void)state;
    static made_up m;
    saltus_system *system = between_stops(0.033);
    saltus_scene scene = scene_of(system);
    saltus_flow_options options = saltus_flow_defaults();
    char data[path_size], picture[path_size];
    saltus_message message = {.text = ""};
    make_record(&m, system, 3, two_impacts, 5);
    check_ok(
        saltus_write_trajectory(path_in("run.h5", data), &scene, system, &options, &m.record, NULL, &message),
        &message);
    for (int column = 0; column < 2; column++) {
        const saltus_figure_options look = {.width = column ? 85 : 0};
        check_ok(saltus_plot_trajectory(path_in("run.svg", picture), data, &look, &message), &message);
        figure f = figure_taken(folder);
        const figure_panel *portrait = figure_panel_of(&f, "phase portrait"),
                           *history = figure_panel_of(&f, "time history; marks: impacts");
        check_trajectory(figure_element_of(portrait, "$orbit", 0), &m.record, m.record.samples);
        check_jumps(figure_element_of(portrait, "$jumps", 0), &m.record, m.record.samples);
        assert_int_equal(figure_element_of(portrait, "$strobe", 0)->values.count, m.record.strobes);
        for (int k = 0; k < 2; k++) {
            const double d = k ? -0.033 : 0.033;
            check_stop(portrait, k, 0, d, portrait->range[0][!k]);
            check_stop(history, k, 1, d, history->range[1][!k]);
        }
        int struck = 0;
        for (long long row = 0; row < m.record.samples; row++)
            struck += is_struck(&m.record, row);
        assert_int_equal(figure_element_of(history, "$impacts", 0)->values.count, struck);
        assert_true(column ? portrait->frame[2] > history->frame[3] : portrait->frame[1] < history->frame[0]);
        /* Each side is named beside its sign in its colour, between caption and panels. */
        for (int side = 0; side < 2; side++) {
            const figure_mark *name =
                                  figure_mark_of(portrait, 'l', side ? "stop 1, lower" : "stop 1, upper", 0),
                              *dot = NULL;
            assert_non_null(name);
            for (int k = 0; k < portrait->mark_count; k++)
                if (portrait->mark[k].kind == 'l' && !*portrait->mark[k].text &&
                    portrait->mark[k].place[0][1] == name->place[0][1] &&
                    portrait->mark[k].place[0][0] < name->place[0][0])
                    dot = &portrait->mark[k];
            assert_true(dot && name->place[0][1] > portrait->frame[3]);
            const figure_rows *impacts = &figure_element_of(history, "$impacts", 0)->values;
            for (int k = 0; k < impacts->count; k++)
                assert_true((impacts->at[k][1] < 0) != side ||
                            impacts->at[k][3] == (double)figure_colour(dot->style));
        }
        for (int p = 0; p < f.panel_count; p++)
            for (int k = 0; k < f.panel[p].mark_count && column; k++) {
                const figure_mark *mark = &f.panel[p].mark[k];
                assert_true(mark->kind != 'l' ||
                            mark->place[0][0] * 522 + saltus_page_width(mark->text, 11.5) < 523);
            }
        figure_free(&f);
    }
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_portrait_is_the_record),
        cmocka_unit_test(stops_are_shown_where_they_are_near),
        cmocka_unit_test(contacts_are_drawn_from_stick_to_release),
        cmocka_unit_test(a_contact_for_good_is_drawn_throughout),
        cmocka_unit_test(an_impact_map_is_the_events),
        cmocka_unit_test(the_section_is_of_the_long_record),
        cmocka_unit_test(multipliers_lie_about_the_unit_circle),
        cmocka_unit_test(shapes_are_sums_of_sines),
        cmocka_unit_test(masses_are_drawn_against_their_stops),
        cmocka_unit_test(exponents_and_lines_are_those_measured),
        cmocka_unit_test(panels_are_lettered_as_they_are_read),
        cmocka_unit_test(long_records_are_cut_at_whole_periods),
        cmocka_unit_test(long_captions_are_broken_between_words),
        cmocka_unit_test(a_rest_has_room_about_it),
        cmocka_unit_test(names_of_sides_stay_on_the_page),
        cmocka_unit_test(a_trajectory_has_its_stops),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
