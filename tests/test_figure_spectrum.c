/* Spectra and the convergence of exponents are drawn as in their tables, and commands draw what is requested,
 * with the numbers of their files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure_folder.h"

#include <hdf5.h>

static saltus_scene made_scene(void) {
    saltus_scene scene = {.spec = oscillator_spec(0.125, 1.75, 1.5, 0.625), .initial_count = 0};
    add_stop(&scene.spec, 0.25, 0.75, SALTUS_UPPER);
    strcpy(scene.name, "made_up");
    strcpy(scene.title, "it's {made} up");
    return scene;
}

/* Spectra */

static figure draw_spectra(const saltus_spectra *spectra, const char *label) {
    saltus_message message = {.text = ""};
    char path[path_size];
    saltus_scene scene = made_scene();
    saltus_system *system = build(&scene.spec);
    saltus_flow_options flow = saltus_flow_defaults();
    saltus_motion motion = {.verdict = SALTUS_PERIODIC, .periods = spectra->periods};
    strcpy(motion.label, label);
    check_ok(
        saltus_write_spectra(path_in("s.svg", path), &scene, system, &flow, &motion, spectra, NULL, &message),
        &message);
    saltus_system_free(system);
    figure f = figure_taken(folder);
    if (f.block_count)
        figure_check_page(&f);
    figure_says(&f, "made\\_up:  spectrum");
    figure_says(&f, label);
    figure_says(&f, "{/:Italic ω} = 0.625");
    static const char *const begins[] = {"{/=20:Bold made\\_up:  spectrum", "it's \\{made\\} up",
                                         "oscillator: "};
    figure_check_lines(&f, begins, (const long[]){-1, 0x606060, 0x202020}, 3);
    return f;
}

enum { lines_most = 1024 };

/* Lines at multiples of 1/p that decrease, alternately up and down. */
static void make_lines(saltus_spectrum *s, saltus_spectral_line *lines, int periods, int per_period,
                       double slope) {
    static double density[4];
    *s = (saltus_spectrum){.kind = SALTUS_SPECTRUM_LINES,
                           .per_period = per_period,
                           .mean = 0.25,
                           .variance = 0.375,
                           .bins = 4,
                           .resolution = 0.5,
                           .density = density,
                           .orbits = 2,
                           .periods = periods,
                           .lines = lines,
                           .line_count = periods * per_period / 2,
                           .between = 1e-11,
                           .broadband = 0.125,
                           .trustworthy = 9.375};
    assert_true(s->line_count <= lines_most);
    for (int k = 0; k < s->line_count; k++) {
        double decibels = -slope * k - 7 * (k % 3) - 2.5 * (k % 7);
        lines[k] = (saltus_spectral_line){.harmonic = k + 1,
                                          .frequency = (k + 1.0) / periods,
                                          .amplitude = 0.3 * pow(10, decibels / 20),
                                          .decibels = decibels};
    }
}

/* A panel's dots and stems are these lines: on its floor, red at multiples of omega. */
static void check_dots(const figure_panel *panel, const saltus_spectral_line *const *shown, int count,
                       int periods, double stems_end) {
    const char *colour[2];
    double floor = panel->range[1][0];
    for (int forced = 0; forced < 2; forced++) {
        const figure_element *stems = figure_element_of(panel, "with vectors", forced),
                             *dots = figure_element_of(panel, "with points", forced);
        int at = 0, stem = 0;
        assert_true(stems && dots);
        colour[forced] = strchr(dots->style, '#');
        assert_true(figure_colour(stems->style) == figure_colour(dots->style));
        for (int k = 0; k < count; k++) {
            if ((periods > 1 && shown[k]->harmonic % periods == 0) != forced)
                continue;
            assert_true(at < dots->values.count);
            figure_near(dots->values.at[at][0], shown[k]->frequency, 1e-8);
            figure_near(dots->values.at[at++][1], shown[k]->decibels, 1e-5);
            if (shown[k]->decibels <= floor || shown[k]->frequency > stems_end)
                continue;
            const double *v = stems->values.at[stem++];
            figure_near(v[0], shown[k]->frequency, 1e-8);
            figure_near(v[1], floor, 1e-9);
            assert_true(v[2] == 0);
            check_near(v[1] + v[3], shown[k]->decibels, 1e-3);
        }
        assert_int_equal(at, dots->values.count);
        assert_int_equal(stem, stems->values.count);
    }
    assert_true(strncmp(colour[0], colour[1], 7) != 0);
}

/* The low frequencies: every line up to the end of the axis, beyond which no line is within 60 dB. */
static void check_low(const figure_panel *panel, const saltus_spectrum *s) {
    const saltus_spectral_line *shown[lines_most];
    int count = 0;
    double end = panel->range[0][1];
    assert_true(panel->range[0][0] == 0 && end >= 4 && end <= 16 && end <= s->per_period / 2.0);
    for (int k = 0; k < s->line_count; k++) {
        if (s->lines[k].frequency <= end)
            shown[count++] = &s->lines[k];
        else
            assert_true(s->lines[k].decibels <= -60 || end == 16);
    }
    check_dots(panel, shown, count, s->periods, INFINITY);
    assert_true(panel->range[1][0] >= -100 && panel->range[1][1] > 0 && !panel->logarithmic[0]);
}

/* All frequencies: of lines closer than 1/96 of an octave the highest, otherwise each. */
static void check_whole(const figure_panel *panel, const saltus_spectrum *s) {
    const saltus_spectral_line *shown[lines_most];
    int count = 0;
    for (int k = 0; k < s->line_count;) {
        int highest = k, first = k;
        for (; k < s->line_count &&
               floor(96 * log2(s->lines[k].frequency)) == floor(96 * log2(s->lines[first].frequency));
             k++)
            if (s->lines[k].amplitude > s->lines[highest].amplitude)
                highest = k;
        shown[count++] = &s->lines[highest];
    }
    check_dots(panel, shown, count, s->periods, 24.0 / s->periods);
    assert_true(panel->logarithmic[0]);
    assert_true(panel->range[0][0] < s->lines[0].frequency && panel->range[0][1] == s->per_period / 2.0);
    for (int k = 0; k < s->line_count; k++)
        assert_true(s->lines[k].frequency > s->trustworthy || s->lines[k].decibels >= panel->range[1][0] ||
                    panel->range[1][0] == -200);
}

/* Grey from the trusted frequency to the end, and a line at it. */
static void check_trust(const figure_panel *panel, double trustworthy) {
    const figure_mark *grey = figure_mark_of(panel, 'o', "rectangle", 0);
    double end = panel->range[0][1];
    assert_true((grey != NULL) == (trustworthy < end));
    if (!grey)
        return;
    figure_near(grey->place[0][0], trustworthy, 1e-8);
    figure_near(grey->place[1][0], end, 1e-8);
    bool found = false;
    const figure_mark *edge;
    for (int k = 0; (edge = figure_mark_of(panel, 'a', "nohead", k)) != NULL; k++)
        found = found || (edge->place[0][0] == grey->place[0][0] && edge->place[1][0] == grey->place[0][0]);
    assert_true(found);
}

static void lines_are_drawn_where_they_are(void **state) {
    (void)state;
    static saltus_spectral_line lines[2][lines_most];
    static const double slopes[] = {0.9, 3, 0.2};
    for (int k = 0; k < 3; k++) {
        saltus_spectra spectra = {.count = 2, .periods = k == 1 ? 1 : 3, .per_period = 128, .analysed = 6};
        spectra.quantities[1].velocity = true;
        for (int q = 0; q < 2; q++)
            make_lines(&spectra.spectra[q], lines[q], spectra.periods, 128, slopes[k] * (1 + 0.3 * q));
        spectra.spectra[1].trustworthy = 70;
        figure f = draw_spectra(&spectra, "4/3");
        assert_int_equal(f.panel_count, 4);
        for (int q = 0; q < 2; q++) {
            const saltus_spectrum *s = &spectra.spectra[q];
            const figure_panel *whole = &f.panel[2 * q + 1];
            check_low(&f.panel[2 * q], s);
            check_whole(whole, s);
            check_trust(&f.panel[2 * q], s->trustworthy);
            check_trust(whole, s->trustworthy);
            const figure_mark *between = figure_mark_of(whole, 'a', "dt (6,5)", 0);
            /* A level between the lines that is below the axis is stated in words. */
            assert_true((between != NULL) == (20 * log10(s->between) > whole->range[1][0]));
            if (between) {
                assert_true(between->system[0][1] == 'f');
                check_near(between->place[0][1], 20 * log10(s->between), 1e-3);
                check_near(between->place[1][1], 20 * log10(s->between), 1e-3);
            } else
                assert_non_null(figure_mark_of(whole, 'l', "between them below −", 0));
            assert_null(figure_mark_of(&f.panel[2 * q], 'a', "dt (6,5)", 0));
        }
        assert_non_null(figure_mark_of(&f.panel[0], 'l', "displacement {/:Italic x}_1", 0));
        assert_non_null(figure_mark_of(&f.panel[2], 'l', "velocity d{/:Italic x}_1", 0));
        figure_says(&f, "displacement: total power 0.375, broadband fraction 0.12");
        figure_free(&f);
    }
}

enum { bins = 700 };

/* A density in decibels of its peak with its confidence band; close bins are averaged. */
static void densities_are_drawn_with_their_band(void **state) {
    (void)state;
    static double density[bins];
    saltus_spectral_line lines[] = {{0, 0.75, 0.5, 0, 0, 0.5},
                                    {0, 1.5, 0.1, 0, -14, 0.1},
                                    {0, 1.51, 0.05, 0, -20, 0.02},
                                    {0, 2.25, 1e-4, 0, -74, 0},
                                    {0, 9, 0.25, 0, -6, 0.1}};
    double peak = 0;
    for (int k = 0; k < bins; k++) {
        density[k] = 3 * exp(-0.02 * k) * (1.2 + sin(0.7 * k));
        peak = fmax(peak, density[k]);
    }
    saltus_spectra spectra = {.count = 2,
                              .quantities = {{0, false}, {1, true}},
                              .spectra = {{.kind = SALTUS_SPECTRUM_WELCH,
                                           .per_period = 35,
                                           .variance = 2.5,
                                           .bins = bins,
                                           .resolution = 0.025,
                                           .density = density,
                                           .segments = 7,
                                           .segment_periods = 40,
                                           .confidence = 0.9,
                                           .low = 0.5,
                                           .high = 2.25,
                                           .lines = lines,
                                           .line_count = 5,
                                           .between = NAN,
                                           .broadband = 0.75,
                                           .trustworthy = 8},
                                          {.kind = SALTUS_SPECTRUM_CONSTANT, .mean = -0.125}},
                              .per_period = 35};
    figure f = draw_spectra(&spectra, "chaotic");
    assert_int_equal(f.panel_count, 2);
    const figure_panel *low = &f.panel[0], *whole = &f.panel[1];
    const figure_element *line = figure_element_of(low, "with lines", 0),
                         *band = figure_element_of(low, "filledcurves", 0);
    double end = low->range[0][1];
    int count = (int)floor(end / 0.025 + 1e-9) + 1;
    assert_true(low->range[0][0] == 0 && line->values.count == count && band->values.count == count);
    for (int k = 0; k < count; k++) {
        figure_near(line->values.at[k][0], k * 0.025, 1e-8);
        check_near(line->values.at[k][1], 10 * log10(density[k] / peak), 1e-3);
        check_near(band->values.at[k][1], 10 * log10(0.5 * density[k] / peak), 1e-3);
        check_near(band->values.at[k][2], 10 * log10(2.25 * density[k] / peak), 1e-3);
    }
    for (int k = 0; k < bins; k++)
        assert_true(k * 0.025 <= end || density[k] <= 1e-6 * peak || end == 16);
    line = figure_element_of(whole, "with lines", 0);
    int at = 0;
    for (int k = 1; k < bins; at++) {
        double sum = 0, cell = floor(96 * log2(k * 0.025));
        int first = k;
        for (; k < bins && floor(96 * log2(k * 0.025)) == cell; k++)
            sum += density[k];
        assert_true(at < line->values.count);
        figure_near(line->values.at[at][0], 0.5 * 0.025 * (first + k - 1), 1e-8);
        check_near(line->values.at[at][1], 10 * log10(sum / (k - first) / peak), 1e-3);
    }
    assert_int_equal(at, line->values.count);
    assert_true(whole->logarithmic[0] && whole->range[0][0] == 0.025 && whole->range[0][1] == 17.5);
    for (int k = 1; k < bins; k++)
        assert_true(10 * log10(0.5 * density[k] / peak) >= whole->range[1][0]);
    check_trust(low, 8);
    check_trust(whole, 8);
    /* Strong lines are marked, the weaker of two overlapping ones is not. */
    static const bool marked[] = {true, true, false, false, true};
    for (int k = 0; k < 5; k++) {
        bool found = false;
        const figure_mark *mark;
        for (int m = 0; (mark = figure_mark_of(low, 'l', "▾", m)) != NULL; m++)
            found = found || fabs(mark->place[0][0] - lines[k].frequency) < 1e-8;
        assert_true(found == (marked[k] && lines[k].frequency < end));
    }
    figure_says(
        &f, "displacement: total power 2.5, broadband fraction 0.75;  {/:Italic x}′_{1}: −0.125 throughout");
    assert_non_null(figure_mark_of(low, 'l', "90 % confidence", 0));
    figure_free(&f);
    /* Nothing moves. */
    spectra.count = 1;
    spectra.spectra[0] = spectra.spectra[1];
    f = draw_spectra(&spectra, "equilibrium");
    assert_true(f.panel_count == 1 && f.block_count == 0);
    figure_says(&f, "displacement: −0.125 throughout");
    figure_free(&f);
}

/* A decreasing density with lines at random places, some of equal height. */
static saltus_spectra scattered_lines(saltus_spectral_line *lines, int count, unsigned seed) {
    static double density[129];
    for (int k = 0; k < 129; k++)
        density[k] = pow(10, -0.04 * k);
    for (int k = 0; k < count; k++) {
        seed = seed * 1103515245u + 12345u;
        double decibels = -(double)(seed >> 16 & 15) * 5;
        lines[k] = (saltus_spectral_line){.frequency = 0.2 + 0.16 * k + 0.1 * (seed >> 24 & 1),
                                          .amplitude = pow(10, decibels / 20),
                                          .decibels = decibels};
    }
    return (saltus_spectra){.count = 1,
                            .per_period = 32,
                            .analysed = 40,
                            .spectra = {{.kind = SALTUS_SPECTRUM_WELCH,
                                         .per_period = 32,
                                         .bins = 129,
                                         .resolution = 0.125,
                                         .density = density,
                                         .segments = 3,
                                         .segment_periods = 8,
                                         .confidence = 0.9,
                                         .low = 0.5,
                                         .high = 2.25,
                                         .lines = lines,
                                         .line_count = count,
                                         .between = NAN,
                                         .trustworthy = 8}}};
}

/* Every line of a continuum within 60 dB of the highest is marked, unless a stronger one is within 1.5
 * percent of the axis; equal lines both are. */
static void strong_lines_are_marked_where_they_stand_apart(void **state) {
    (void)state;
    enum { count = 90 };
    for (unsigned seed = 1; seed <= 4; seed++) {
        saltus_spectral_line lines[count];
        saltus_spectra spectra = scattered_lines(lines, count, seed);
        figure f = draw_spectra(&spectra, "chaotic");
        const figure_panel *low = &f.panel[0];
        double end = low->range[0][1];
        int marks = 0, wanted = 0;
        const figure_mark *mark;
        for (; (mark = figure_mark_of(low, 'l', "▾", marks)) != NULL && !strstr(mark->text, "Bold"); marks++)
            assert_true(mark->system[0][1] == 'g' && mark->place[0][1] == 1);
        for (int k = 0; k < count; k++) {
            bool strong = lines[k].frequency < end && lines[k].decibels > -60, found = false;
            for (int o = 0; o < count; o++)
                strong = strong && !(fabs(lines[o].frequency - lines[k].frequency) < 0.015 * end &&
                                     lines[o].amplitude > lines[k].amplitude);
            wanted += strong;
            for (int m = 0; (mark = figure_mark_of(low, 'l', "▾", m)) != NULL; m++)
                found = found || fabs(mark->place[0][0] - lines[k].frequency) < 1e-7;
            assert_true(found == strong);
        }
        for (int m = marks; (mark = figure_mark_of(low, 'l', "▾", m)) != NULL; m++)
            marks += !strstr(mark->text, "Bold");
        assert_int_equal(marks, wanted);
        assert_true(wanted > 20 && wanted < count - 10);
        figure_free(&f);
    }
}

static void check_heading(const figure_panel *panel, int letter, const char *words) {
    char text[300];
    const figure_mark *heading = figure_mark_of(panel, 'l', "{/:Bold (", 0);
    snprintf(text, sizeof text, "{/:Bold (%c)}  %s", 'a' + letter, words);
    assert_non_null(heading);
    assert_string_equal(heading->text, text);
    check_near(heading->place[0][0], panel->frame[0], 1e-5);
    check_near(heading->place[0][1], panel->frame[3], 1e-5);
}

/* Headings name exactly what their panels show. One quantity has the width of the page, two have a row
 * each. */
static void spectra_are_headed_by_what_they_show(void **state) {
    (void)state;
    static saltus_spectral_line lines[2][lines_most];
    static const struct {
        int periods, orbits, lines, quantities;
        double trustworthy;
        const char *low, *whole;
    } cases[] = {
        {3, 2, 1, 1, 9, ":  lines at multiples of {/:Italic ω}/3; squares: of {/:Italic ω}",
         "all lines; dashed: largest between them; grey: not trustworthy"},
        {1, 1, 1, 1, 64, ":  lines at multiples of {/:Italic ω}", "all lines"},
        {1, 2, 1, 2, NAN, ":  lines at multiples of {/:Italic ω}", "all lines; dashed: largest between them"},
        {2, 1, 1, 2, 0, ":  lines at multiples of {/:Italic ω}/2; squares: of {/:Italic ω}",
         "all lines; grey: not trustworthy"},
        {0, 1, 5, 1, 8, ":  density; pale: 90 % confidence; ▾ strong lines",
         "the whole density; grey: not trustworthy"},
        {0, 1, 0, 1, 16, ":  density; pale: 90 % confidence", "the whole density"},
    };
    for (int k = 0; k < 6; k++) {
        saltus_spectra spectra = scattered_lines(lines[0], cases[k].lines, 1);
        spectra.periods = cases[k].periods;
        spectra.count = cases[k].quantities;
        spectra.quantities[1] = (saltus_quantity){1, true};
        for (int q = 0; q < 2; q++) {
            if (cases[k].periods > 0)
                make_lines(&spectra.spectra[q], lines[q], cases[k].periods, 128, 1);
            spectra.spectra[q].orbits = cases[k].orbits;
            spectra.spectra[q].between = cases[k].orbits > 1 ? 1e-9 : NAN;
            spectra.spectra[q].trustworthy = cases[k].trustworthy;
        }
        figure f = draw_spectra(&spectra, "label");
        char words[200];
        assert_int_equal(f.panel_count, 2 * cases[k].quantities);
        for (int q = 0; q < cases[k].quantities; q++) {
            const figure_panel *low = &f.panel[2 * q], *whole = low + 1;
            const char *name = q ? "mass 1, {/:Italic x}′_{1}" : "displacement {/:Italic x}_1";
            snprintf(words, sizeof words, "%s%s", name, cases[k].low);
            check_heading(low, 2 * q, words);
            check_heading(whole, 2 * q + 1, cases[k].whole);
            assert_true((figure_mark_of(whole, 'a', "dt (6,5)", 0) != NULL) == (cases[k].orbits > 1));
            /* If nothing is trusted, all of the axis is grey. */
            const figure_mark *grey = figure_mark_of(whole, 'o', "rectangle", 0);
            assert_true((grey != NULL) == (cases[k].trustworthy < whole->range[0][1]));
            char edge[40];
            snprintf(edge, sizeof edge, "%.3g {/:Italic ω}", cases[k].trustworthy);
            const figure_mark *at = figure_mark_of(whole, 'l', edge, 0);
            assert_true((at != NULL) == (grey && cases[k].trustworthy > 0));
            if (at)
                figure_near(at->place[0][0], cases[k].trustworthy, 1e-8);
            if (grey)
                figure_near(grey->place[0][0], fmax(cases[k].trustworthy, whole->range[0][0]), 1e-8);
            const double *a = low->frame, *b = whole->frame;
            if (cases[k].quantities == 1)
                assert_true(a[0] == b[0] && a[1] == b[1] && a[2] > b[3] && a[1] - a[0] > 0.85);
            else
                assert_true(a[2] == b[2] && a[3] == b[3] && a[1] < b[0] && (q == 0) == (a[2] > 0.4));
            check_near(a[3] - a[2], b[3] - b[2], 1e-5);
        }
        figure_free(&f);
    }
}

/* Axes end slightly beyond their content: the low frequencies after the last strong line, between 4 and 16;
 * the decibels 10 to 30 below the lowest trusted one; there are three to seven tics. */
static void spectra_end_where_they_have_nothing_left(void **state) {
    (void)state;
    static saltus_spectral_line lines[lines_most];
    static double density[200];
    for (int k = 0; k < 24; k++) {
        bool welch = k % 2;
        double slope = 0.3 + 0.75 * k, last = 4, lowest = 0;
        saltus_spectra spectra = scattered_lines(lines, 0, 1);
        saltus_spectrum *s = &spectra.spectra[0];
        if (welch) {
            s->density = density;
            s->bins = 200;
            s->per_period = 50;
            for (int b = 0; b < 200; b++) {
                density[b] = 3 * pow(10, -0.006 * slope * b);
                double decibels = 10 * log10(density[b] / density[0]);
                last = decibels > -60 ? fmax(last, 0.125 * b) : last;
                lowest = b ? fmin(lowest, decibels + 10 * log10(s->low)) : lowest;
            }
        } else {
            spectra.periods = 2;
            make_lines(s, lines, 2, 64, slope);
            s->between = k % 4 ? NAN : 1e-16;
            s->trustworthy = 12;
            lowest = 0;
            if (k % 3 == 0) /* a line that vanishes by symmetry does not deepen the axis */
                lines[3].decibels = -INFINITY;
            for (int l = 0; l < s->line_count; l++) {
                last = lines[l].decibels > -60 ? fmax(last, lines[l].frequency) : last;
                lowest = lines[l].frequency <= 12 && isfinite(lines[l].decibels)
                             ? fmin(lowest, lines[l].decibels)
                             : lowest;
            }
        }
        figure f = draw_spectra(&spectra, "label");
        const figure_panel *low = &f.panel[0], *whole = &f.panel[1];
        double most = fmin(16, s->per_period / 2.0), end = low->range[0][1], deepest = -200;
        assert_true(end == most || (end >= last + 0.25 && end < last + 1.25));
        assert_true(end < most || last + 1.25 > most);
        double floor = whole->range[1][0];
        assert_true(floor == deepest || (floor <= lowest - 10 && floor > lowest - 30));
        assert_true(floor > deepest || lowest < deepest + 30);
        /* The low frequencies have a floor of their own, below what is drawn there. */
        double lowest_shown = -20;
        for (int b = 1; b < 200 && welch; b++)
            if (0.125 * b <= end)
                lowest_shown = fmin(lowest_shown, 10 * log10(density[b] / density[0] * s->low));
        for (int l = 0; l < s->line_count && !welch; l++)
            if (lines[l].frequency <= end && lines[l].decibels > -100)
                lowest_shown = fmin(lowest_shown, lines[l].decibels);
        const double own = low->range[1][0];
        assert_true(own == -100 || (own <= lowest_shown - 10 && own > lowest_shown - 30 && own >= -100));
        assert_true(own > -100 || lowest_shown < -70);
        assert_true(low->tic[0] == (end > 10 ? 2 : 1));
        for (int p = 0; p < 2; p++) {
            const double *range = f.panel[p].range[1];
            check_near(range[1], -0.04 * range[0], 1e-4);
            assert_true(-range[0] / f.panel[p].tic[1] >= (range[0] < -20 ? 3 : 2));
            assert_true(-range[0] / f.panel[p].tic[1] <= 6);
        }
        assert_true(whole->range[0][0] == (welch ? 0.125 : 0.4));
        figure_free(&f);
    }
}

/* Convergence */

static figure draw_convergence(const saltus_lyapunov *l) {
    saltus_message message = {.text = ""};
    char path[path_size];
    saltus_scene scene = made_scene();
    saltus_system *system = build(&scene.spec);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    check_ok(saltus_write_convergence(path_in("c.svg", path), &scene, system, &options, l, NULL, &message),
             &message);
    saltus_system_free(system);
    figure f = figure_taken(folder);
    figure_check_page(&f);
    figure_says(&f, "made\\_up:  largest Lyapunov exponent");
    figure_says(&f, "{/:Italic k} = 1.75");
    return f;
}

/* The history with its band, complete or as differences from its end; a level at zero if that is near. */
static void histories_converge_to_their_end(void **state) {
    (void)state;
    enum { most = 40 };
    saltus_lyapunov_progress history[most];
    static const double exponents[] = {0.25, 5, 0.01, -0.5, 1};
    static const double sizes[] = {0.08, 1e-3, 0.05, 0.1, 0.2};
    static const int counts[] = {most, 12, 25, 1, most};
    for (int c = 0; c < 5; c++) {
        double exponent = exponents[c], error = 0.125 * sizes[c], low = exponent, high = exponent;
        for (int k = 0; k < counts[c]; k++) {
            double t = 20 * pow(c == 4 ? 1.5 : 1.15, k);
            history[k] =
                (saltus_lyapunov_progress){t, exponent + sizes[c] * cos(k) / (k + 1), sizes[c] / (k + 2)};
            low = fmin(low, history[k].exponent);
            high = fmax(high, history[k].exponent);
        }
        const saltus_lyapunov l = {.dimension = 2,
                                   .count = 1,
                                   .exponents = &exponent,
                                   .standard_errors = &error,
                                   .period = 2,
                                   .periods = 345,
                                   .transient = 67,
                                   .impacts_per_period = 1.25,
                                   .members = 5,
                                   .agree = c != 2,
                                   .precise = c != 2,
                                   .history = history,
                                   .history_count = counts[c]};
        figure f = draw_convergence(&l);
        const figure_panel *panel = &f.panel[0];
        const figure_element *line = figure_element_of(panel, "title 'estimate'", 0),
                             *band = figure_element_of(panel, "standard error'", 0);
        bool differences = strstr(panel->label[1], "final value") != NULL;
        double origin = differences ? exponent : 0;
        assert_true(differences == (c == 1));
        assert_true(panel->logarithmic[0] && line->values.count == counts[c]);
        for (int k = 0; k < counts[c]; k++) {
            figure_near(line->values.at[k][0], history[k].time, 1e-8);
            check_near(line->values.at[k][1], history[k].exponent - origin, 1e-12);
            for (int side = -1; side <= 1; side += 2) {
                double edge = history[k].exponent + side * history[k].standard_error - origin;
                edge = fmin(fmax(edge, panel->range[1][0]), panel->range[1][1]);
                check_near(band->values.at[k][side < 0 ? 1 : 2], edge, 1e-8);
            }
        }
        figure_check_inside(panel, line);
        /* After the begin the band is complete. */
        double whole = panel->range[0][0] * pow(panel->range[0][1] / panel->range[0][0], 0.2);
        for (int k = 0; k < counts[c]; k++)
            if (history[k].time > whole * 1.001)
                assert_true(history[k].exponent + history[k].standard_error - origin < panel->range[1][1] &&
                            history[k].exponent - history[k].standard_error - origin > panel->range[1][0]);
        const figure_mark *end = figure_mark_of(panel, 'a', "dt (12,9)", 0),
                          *zero = figure_mark_of(panel, 'a', "#707070", 0);
        check_near(end->place[0][1], exponent - origin, 1e-10);
        check_near(end->place[1][1], exponent - origin, 1e-10);
        assert_true((zero != NULL) == (panel->range[1][0] < 0 && panel->range[1][1] > 0 && !differences));
        assert_true(panel->range[0][0] <= history[0].time * (1 + 1e-8) &&
                    panel->range[0][1] >= history[counts[c] - 1].time * (1 - 1e-8));
        assert_true((figure_element_of(panel, "pt 7", 0) != NULL) == (counts[c] < 30));
        assert_true((panel->tic_count[0] >= 2) == (panel->range[0][1] <= 3000 * panel->range[0][0]));
        for (int k = 0; k < panel->tic_count[0]; k++) {
            double power = pow(10, floor(log10(panel->tics[0][k]) + 1e-9)), digit = panel->tics[0][k] / power;
            assert_true(fabs(digit - 1) < 1e-6 || fabs(digit - 2) < 1e-6 || fabs(digit - 5) < 1e-6);
        }
        if (c == 3) {
            const figure_element *bar = figure_element_of(panel, "yerrorbars", 0);
            assert_true(bar && fabs(bar->values.at[0][2] - history[0].standard_error) < 1e-9);
        }
        if (c == 0) {
            figure_says(&f, "0.250 ± 0.010");
            figure_says(&f,
                        "0.500 ± 0.020 per period {/:Italic T} = 2;  345 periods measured by 5 trajectories "
                        "together after a transient of 67;  impacts per period: 1.25");
            assert_non_null(figure_element_of(panel, "final value 0.250 ± 0.010", 0));
        }
        char text[8000];
        figure_caption(&f, text, sizeof text);
        assert_true((strstr(text, "was not reached") != NULL) == (c == 2));
        assert_true((strstr(text, "do not agree") != NULL) == (c == 2));
        figure_free(&f);
    }
    double lost = -INFINITY, error = 0;
    const saltus_lyapunov l = {.dimension = 2,
                               .count = 1,
                               .exponents = &lost,
                               .standard_errors = &error,
                               .period = 2,
                               .members = 1,
                               .agree = true,
                               .precise = true};
    figure f = draw_convergence(&l);
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "the largest exponent is −∞", 0));
    figure_says(&f, "exponent  −∞");
    figure_free(&f);
    /* A number without a history. */
    saltus_lyapunov bare = l;
    lost = 0.5;
    f = draw_convergence(&bare);
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "too few values", 0));
    assert_null(figure_element_of(&f.panel[0], "$convergence", 0));
    figure_free(&f);
}

/* A defect of the measurement is stated last, in red, alone. */
static void convergence_tells_its_doubts(void **state) {
    (void)state;
    static const char *const begins[] = {"{/=20:Bold made\\_up:  largest Lyapunov exponent",
                                         "it's \\{made\\} up", "oscillator: ", "0.500 ± 0.020 per period",
                                         NULL};
    static const long colours[] = {-1, 0x606060, 0x202020, 0x202020, 0xc44e2a};
    static const char *const doubts[] = {
        "", "the precision asked for, 1 %, was not reached",
        "the trajectories do not agree: they do not measure the same motion",
        "the precision asked for, 1 %, was not reached;  the trajectories do not agree: they do not measure"};
    for (int k = 0; k < 8; k++) {
        double exponent = k < 4 ? 0.25 : -INFINITY, error = k < 4 ? 0.01 : 0;
        saltus_lyapunov_progress history[] = {{10, 0.25, 0.02}, {20, 0.25, 0.01}};
        const saltus_lyapunov l = {.dimension = 2,
                                   .count = 1,
                                   .exponents = &exponent,
                                   .standard_errors = &error,
                                   .period = 2,
                                   .periods = 345,
                                   .transient = 67,
                                   .members = k % 2 ? 1 : 5,
                                   .agree = !(k & 2),
                                   .precise = !(k & 1),
                                   .impacts_per_period = k % 4 == 3 ? INFINITY : 1.5,
                                   .history = history,
                                   .history_count = 2};
        const char *lines[5];
        figure f = draw_convergence(&l);
        memcpy(lines, begins, sizeof begins);
        lines[3] = k < 4 ? begins[3] : "345 periods measured by ";
        lines[4] = doubts[k % 4];
        figure_check_lines(&f, lines, colours, k % 4 ? 5 : 4);
        figure_says(&f, k % 4 == 3 ? "complete chatter" : "impacts per period: 1.5");
        figure_says(&f, k % 2 ? "345 periods measured by 1 trajectory after a transient of 67; "
                              : "345 periods measured by 5 trajectories together after a transient of 67; ");
        for (int m = 0; m < f.panel[0].mark_count; m++)
            assert_true(k % 4 || f.panel[0].mark[m].kind != 'l' ||
                        figure_colour(f.panel[0].mark[m].style) != 0xc44e2a);
        figure_free(&f);
    }
}

/* Few estimates are marked; those that differ by less than three thousandths are drawn as differences; tics
 * of times are numbers over up to a factor of 3000, powers of ten beyond. The axis of times is never
 * empty. */
static void histories_choose_their_axes(void **state) {
    (void)state;
    static saltus_lyapunov_progress history[31];
    static const struct {
        int count;
        double width, last; /* spread of all estimates over the exponent, of the times */
    } cases[] = {{29, 0.1, 100},  {30, 0.1, 100}, {30, 0.00265, 100}, {30, 0.0024, 100}, {30, 0.1, 2999},
                 {30, 0.1, 3001}, {2, 0.1, 1.21}, {2, 0.1, 1.19},     {30, 1e-13, 50}};
    for (int k = 0; k < 18; k++) {
        int c = k / 2, count = cases[c].count;
        double exponent = k % 2 ? -0.5 : 0.5, error = 0.001, width = cases[c].width * 0.5;
        for (int i = 0; i < count; i++)
            history[i] = (saltus_lyapunov_progress){20 * pow(cases[c].last, i / (count - 1.0)),
                                                    exponent + (i == 1 ? width : 0), 0};
        const saltus_lyapunov l = {.dimension = 2,
                                   .count = 1,
                                   .exponents = &exponent,
                                   .standard_errors = &error,
                                   .period = 2,
                                   .members = 1,
                                   .agree = true,
                                   .precise = true,
                                   .history = history,
                                   .history_count = count};
        figure f = draw_convergence(&l);
        const figure_panel *panel = &f.panel[0];
        assert_true((figure_element_of(panel, "pt 7", 0) != NULL) == (count < 30));
        assert_true((strstr(panel->label[1], "final value") != NULL) == (cases[c].width < 0.0025));
        assert_true((panel->tic_count[0] > 0) == (cases[c].last <= 3000));
        assert_string_equal(panel->label[0], "time {/:Italic t} measured, all trajectories together");
        double first = history[0].time, last = history[count - 1].time, *range = f.panel[0].range[0];
        bool narrow = cases[c].last < 1.2;
        figure_near(range[0], narrow ? first / 2 : first, 1e-8);
        figure_near(range[1], narrow ? 2 * last : last, 1e-8);
        assert_true(panel->range[1][1] - panel->range[1][0] >= 1.15 * width);
        assert_true(panel->range[1][1] - panel->range[1][0] <= fmax(1.17 * width, 2e-12));
        for (int tic = 0; tic < panel->tic_count[0]; tic++)
            assert_true(tic == 0 || panel->tics[0][tic] <= 2.6 * panel->tics[0][tic - 1]);
        if (panel->tic_count[0])
            assert_true(panel->tics[0][0] <= 2.6 * range[0] &&
                        panel->tics[0][panel->tic_count[0] - 1] * 2.6 >= range[1]);
        figure_free(&f);
    }
}

/* Commands */

/* Run the program in the folder; its standard output goes to `out`. */
static void run(const char *arguments) {
    char command[900];
    snprintf(command, sizeof command, "cd '%s' && '%s' %s >out 2>err", folder, SALTUS_COMMAND, arguments);
    if (system(command) != 0)
        fail_msg("saltus %s fails", arguments);
}

static void write_scene(const char *name, const char *text) {
    char path[path_size];
    FILE *file = fopen(path_in(name, path), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static const char struck[] = "model: oscillator\nc: 0.4\nF: 1\nomega: 2\nstop: {d: 0.25, r: 0.8}\n";

/* Numbers of one dataset; freed by the caller. */
static double *dataset(hid_t file, const char *name, int *count) {
    hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(set);
    *count = (int)H5Sget_simple_extent_npoints(space);
    double *values = calloc((size_t)*count + 1, sizeof *values);
    assert_true(set >= 0 && values &&
                H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Sclose(space);
    H5Dclose(set);
    return values;
}

/* A table of numbers below comment lines and names; columns are found by name. */
typedef struct table {
    char *text;
    int count;
    double at[4096][8];
    char name[8][48];
} table;

static void read_table(const char *name, table *t) {
    char path[path_size];
    size_t length;
    t->text = read_all(path_in(name, path), &length);
    char *line = t->text;
    while (*line == '#')
        line = strchr(line, '\n') + 1;
    char *names = line;
    line = strchr(line, '\n') + 1;
    names[strcspn(names, "\n")] = '\0';
    for (int c = 0; c < 8 && *names; c++) {
        size_t width = strcspn(names, ",");
        snprintf(t->name[c], sizeof t->name[c], "%.*s", (int)width, names);
        names += width + (names[width] == ',');
    }
    for (t->count = 0; *line; t->count++) {
        assert_true(t->count < 4096);
        for (int c = 0; *line != '\n'; c++) {
            t->at[t->count][c] = strtod(line, &line);
            line += *line == ',';
        }
        line++;
    }
    free(t->text);
}

static int column(const table *t, const char *name) {
    for (int c = 0; c < 8; c++)
        if (strcmp(t->name[c], name) == 0)
            return c;
    fail_msg("no column %s", name);
    return 0;
}

/* `diagnose` draws the trajectory it writes, with the multipliers of `classify`. */
static void diagnose_draws_the_data_that_it_keeps(void **state) {
    (void)state;
    char path[path_size];
    size_t length;
    write_scene("scene.yaml", struck);
    run("diagnose scene.yaml --set d=0.2 -o s.svg --data sheet.h5 --quiet");
    figure f = figure_taken(folder);
    figure_check_page(&f);
    hid_t file = H5Fopen(path_in("sheet.h5", path), H5F_ACC_RDONLY, H5P_DEFAULT);
    int rows, strobes, events, own;
    double *time = dataset(file, "trajectory/time", &rows),
           *x = dataset(file, "trajectory/displacement", &own),
           *v = dataset(file, "trajectory/velocity", &own), *at = dataset(file, "strobe/states", &strobes),
           *before = dataset(file, "events/velocity_before", &events),
           *when = dataset(file, "events/time", &own);
    H5Fclose(file);
    const figure_panel *portrait = figure_panel_of(&f, "phase portrait");
    const figure_element *line = figure_element_of(portrait, "$orbit", 0),
                         *dots = figure_element_of(portrait, "$strobe", 0),
                         *history = figure_element_of(figure_panel_of(&f, "one orbit"), "$history", 0),
                         *map = figure_element_of(figure_panel_of(&f, "velocity before"), "$impact_map", 0);
    assert_true(line->values.count == rows && history->values.count == rows && rows > 900);
    for (int k = 0; k < rows; k++) {
        check_near(line->values.at[k][0], x[k], 1e-8);
        check_near(line->values.at[k][1], v[k], 1e-8);
        check_near(history->values.at[k][0], time[k], 1e-8);
        check_near(history->values.at[k][1], x[k], 1e-8);
    }
    assert_int_equal(dots->values.count, strobes / 2);
    check_near(dots->values.at[0][0], at[0], 1e-8);
    check_near(dots->values.at[0][1], at[1], 1e-8);
    assert_true(events > 0 && map->values.count == events);
    for (int k = 0; k < events; k++) {
        check_near(map->values.at[k][0], when[k] - floor(when[k]), 1e-8);
        check_near(map->values.at[k][1], before[k], 1e-8);
    }
    figure_says(&f, "{/:Italic d} = 0.2");
    run("classify scene.yaml --set d=0.2 --json --quiet");
    char *json = read_all(path_in("out", path), &length), *list = strstr(json, "\"multipliers\": [");
    const figure_element *circle = figure_element_of(figure_panel_of(&f, "unit circle"), "$multipliers", 0);
    assert_true(list && circle->values.count == 2);
    list = strchr(list, '[') + 1;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 2; i++) {
            list += strcspn(list, "-0123456789");
            check_near(circle->values.at[k][i], strtod(list, &list), 1e-8);
        }
    /* The spectrum's lines are those of `spectrum`. */
    static table t;
    run("spectrum scene.yaml --set d=0.2 --of displacement --samples 1024 --periods 2 -o s.csv --quiet");
    read_table("s.csv", &t);
    const figure_element *lines = figure_element_of(figure_panel_of(&f, "frequency"), "with points", 0);
    assert_true(lines->values.count >= 4);
    for (int k = 0; k < lines->values.count; k++) {
        check_near(lines->values.at[k][0], t.at[k][column(&t, "frequency_over_omega")], 1e-8);
        check_near(lines->values.at[k][1], t.at[k][column(&t, "displacement_dB")], 1e-3);
    }
    free(json);
    free(time);
    free(x);
    free(v);
    free(at);
    free(before);
    free(when);
    figure_free(&f);
}

/* Without a period the section is long, and includes the points of the record shown. */
static void diagnose_looks_longer_at_what_has_no_period(void **state) {
    (void)state;
    write_scene("scene.yaml", struck);
    run("diagnose scene.yaml --set c=0.1 d=0.2 omega=2.6 --transient 50 --longest 2 --measure 0 -o s.svg "
        "--quiet");
    figure f = figure_taken(folder);
    figure_check_page(&f);
    figure_says(&f, "irregular");
    figure_says(&f, "section 2000");
    const figure_element *shown = figure_element_of(figure_panel_of(&f, "phase portrait"), "$strobe", 0),
                         *section =
                             figure_element_of(figure_panel_of(&f, "stroboscopic section"), "$section", 0);
    assert_true(section->values.count == 2000 && shown->values.count >= 200);
    for (int k = 0; k < 5; k++)
        for (int i = 0; i < 2; i++)
            check_near(shown->values.at[k][i], section->values.at[k][i], 1e-6);
    assert_non_null(figure_panel_of(&f, "frequency"));
    figure_free(&f);
}

/* `spectrum` draws the table it writes, with the requested quantities in order. */
static void spectrum_draws_its_table(void **state) {
    (void)state;
    static table t;
    write_scene("scene.yaml", struck);
    run("spectrum scene.yaml --of v1 --of displacement --samples 64 -o s.svg --quiet");
    figure f = figure_taken(folder);
    run("spectrum scene.yaml --of v1 --of displacement --samples 64 -o s.csv --quiet");
    read_table("s.csv", &t);
    assert_int_equal(f.panel_count, 4);
    for (int q = 0; q < 2; q++) {
        const figure_panel *panel = &f.panel[2 * q];
        const figure_element *dots = figure_element_of(panel, "with points", 0);
        int values = column(&t, q ? "displacement_dB" : "v1_dB"), shown = 0;
        assert_non_null(figure_mark_of(panel, 'l', q ? "displacement" : "mass 1, {/:Italic x}′", 0));
        for (int k = 0; k < t.count && t.at[k][1] <= panel->range[0][1]; k++, shown++) {
            check_near(dots->values.at[k][0], t.at[k][column(&t, "frequency_over_omega")], 1e-8);
            check_near(dots->values.at[k][1], t.at[k][values], 1e-3);
        }
        assert_int_equal(shown, dots->values.count);
        assert_true(f.panel[2 * q + 1].range[0][1] == 32);
    }
    figure_free(&f);
}

/* `lyapunov` draws the rows it writes, up to the number it reports. */
static void lyapunov_draws_its_table(void **state) {
    (void)state;
    static table t;
    char path[path_size];
    size_t length;
    write_scene("scene.yaml", struck);
    run("lyapunov scene.yaml --transient 20 --periods 400 --members 2 --seed 3 --json -o c.svg --quiet");
    figure f = figure_taken(folder);
    char *json = read_all(path_in("out", path), &length), *at = strstr(json, "\"exponents\": [");
    assert_non_null(at);
    double exponent = strtod(strchr(at, '[') + 1, NULL);
    free(json);
    run("lyapunov scene.yaml --transient 20 --periods 400 --members 2 --seed 3 -o c.csv --quiet");
    read_table("c.csv", &t);
    const figure_panel *panel = &f.panel[0];
    const figure_rows *drawn = figure_find(&f, "$convergence");
    assert_true(drawn && drawn->count == t.count && t.count > 0);
    for (int k = 0; k < t.count; k++)
        for (int c = 0; c < 3; c++)
            figure_near(drawn->at[k][c], t.at[k][c], 1e-8);
    const figure_element *line = figure_element_of(panel, "title 'estimate'", 0);
    const figure_mark *end = figure_mark_of(panel, 'a', "dt (12,9)", 0);
    double origin = t.at[0][1] - line->values.at[0][1];
    check_near(end->place[0][1] + origin, exponent, 1e-9);
    figure_free(&f);
}

/* Over a displacement diagram a branch shows its orbits' turning points: where a trajectory settled on it,
 * the cloud's points are on its curves. */
static void branches_turn_where_the_cloud_does(void **state) {
    (void)state;
    write_scene("scene.yaml", struck);
    run("sweep scene.yaml --over omega=1.95:2.05:6 --what turning -o s.h5 --quiet");
    run("continue scene.yaml --set omega=2 --in omega=1.94:2.06 -o b.h5 --quiet");
    run("plot s.h5 --view turning --over b.h5 -o s.svg");
    figure f = figure_taken(folder);
    const figure_panel *panel = &f.panel[0];
    const figure_element *cloud = figure_element_of(panel, "$cloud", 0);
    double height = panel->range[1][1] - panel->range[1][0];
    int met = 0;
    for (int i = 0; i < cloud->values.count; i++) {
        const double *dot = cloud->values.at[i];
        double nearest = INFINITY;
        for (int e = 0; e < panel->element_count; e++) {
            const figure_rows *rows = &panel->element[e].values;
            for (int k = 1; k < rows->count && strstr(panel->element[e].text, "$curve"); k++) {
                const double *a = rows->at[k - 1], *b = rows->at[k];
                double part = (dot[0] - a[0]) / (b[0] - a[0]);
                if (rows->joined[k] && part >= 0 && part <= 1)
                    nearest = fmin(nearest, fabs(a[1] + part * (b[1] - a[1]) - dot[1]));
            }
        }
        met += nearest < 0.004 * height;
    }
    assert_true(cloud->values.count >= 6 && met > 0.9 * cloud->values.count);
    figure_free(&f);
}

/* Each option of `plot` reaches the figure. */
static void plot_draws_what_is_asked_for(void **state) {
    (void)state;
    static const char *const views[][2] = {{"turning", "displacement diagram"},
                                           {"impacts", "velocity diagram"},
                                           {"stroboscopic", "stroboscopic diagram"},
                                           {"class", "period in"},
                                           {"attractors", "number of attractors"},
                                           {"largest", "largest displacement"},
                                           {"rms", "root mean square"},
                                           {"speed", "largest impact speed"},
                                           {"rate", "impacts per period"},
                                           {"contact", "time in contact"},
                                           {"lyapunov", "largest Lyapunov exponent"},
                                           {"settled", "periods until settled"}};
    static const char *const shows[][2] = {{"speed", "largest impact speed"},
                                           {"impacts", "speed of every impact"},
                                           {"displacement", "displacement"},
                                           {"velocity", "velocity"},
                                           {"period", "period in"}};
    char arguments[300];
    write_scene("scene.yaml", struck);
    run("sweep scene.yaml --over omega=1.9:2.1:5 --what turning,impacts,stroboscopic,lyapunov -o s.h5 "
        "--quiet");
    for (int k = 0; k < 11; k++) {
        snprintf(arguments, sizeof arguments, "plot s.h5 --view %s -o s.png", views[k][0]);
        run(arguments);
        figure f = figure_taken(folder);
        figure_says(&f, views[k][1]);
        assert_true(figure_begins(f.terminal, "pngcairo"));
        figure_free(&f);
    }
    run("plot s.h5 --view speed --range omega=1.92:2.03 --range speed=0.1:3 --title 'own title' -o s.pdf");
    figure f = figure_taken(folder);
    figure_says(&f, "own title");
    assert_true(figure_begins(f.terminal, "pdfcairo"));
    assert_true(f.panel[0].range[0][0] == 1.92 && f.panel[0].range[0][1] == 2.03);
    assert_true(f.panel[0].range[1][0] == 0.1 && f.panel[0].range[1][1] == 3);
    figure_free(&f);
    run("classify scene.yaml --json --quiet");
    char command[300];
    snprintf(command, sizeof command, "cp '%s/out' '%s/orbit.json'", folder, folder);
    assert_int_equal(system(command), 0);
    run("continue scene.yaml --from orbit.json --in omega=1.95:2.05 -o b.h5 --quiet");
    for (int k = 0; k < 5; k++) {
        snprintf(arguments, sizeof arguments, "plot b.h5 --show %s -o b.svg", shows[k][0]);
        run(arguments);
        f = figure_taken(folder);
        assert_true(strstr(f.panel[0].label[1], shows[k][1]) == f.panel[0].label[1]);
        figure_free(&f);
    }
    run("plot b.h5 --range omega=1.97:2.01 -o b.svg");
    f = figure_taken(folder);
    assert_true(f.panel[0].range[0][0] == 1.97 && f.panel[0].range[0][1] == 2.01);
    figure_free(&f);
    run("plot s.h5 --view impacts --over b.h5 --label omega=2,impacts=0.2,Mine -o s.svg");
    f = figure_taken(folder);
    assert_non_null(figure_element_of(&f.panel[0], "$curve", 0));
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "Mine", 0));
    figure_free(&f);
    /* A label beyond the axes is counted above the panel. */
    run("plot b.h5 --label omega=2,speed=0.9,Mine --label omega=2,speed=99,there -o s.svg");
    f = figure_taken(folder);
    assert_true(f.panel[0].range[1][0] < 0.9 && f.panel[0].range[1][1] > 0.9);
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "Mine", 0));
    assert_null(figure_mark_of(&f.panel[0], 'l', "there", 0));
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "labels beyond the axes: 1", 0));
    figure_free(&f);
    /* Over a map, with and without curves; names of regions leave it its place. */
    run("sweep scene.yaml --over omega=1.9:2.1:5 --over d=0:0.4:3 -o m.h5 --quiet");
    run("continue scene.yaml --in d=-0.5:1 --locus GR --and omega=1.9:2.1 -o g.h5 --quiet");
    for (int k = 0; k < 2; k++) {
        run(k ? "plot m.h5 --label d=0.1,omega=2,Mine -o s.svg"
              : "plot m.h5 --over g.h5 --label omega=2,d=0.1,Mine -o s.svg");
        f = figure_taken(folder);
        const figure_mark *label = figure_mark_of(&f.panel[0], 'l', "Mine", 0);
        assert_true(label && strstr(label->style, "boxed"));
        assert_true((figure_element_of(&f.panel[0], "$curve", 0) != NULL) == !k);
        figure_free(&f);
    }
}

/* `paper` runs a figure's commands with the options of a trial, in the named folder. */
static void paper_draws_the_figure_asked_for(void **state) {
    (void)state;
    char path[path_size];
    saltus_sweep_file sweep;
    saltus_message message = {.text = ""};
    run("paper --quick --figure 2 -o there/in --format svg --quiet");
    figure f = figure_taken(folder);
    figure_says(&f, "fig2:  displacement diagram in {/:Italic ω}");
    assert_true(figure_begins(f.terminal, "svg"));
    assert_int_equal(folder_files(path_in("there/in", path), false), 2);
    assert_int_equal(access(path_in("there/in/fig2.svg", path), F_OK), 0);
    check_ok(saltus_sweep_file_read(path_in("there/in/fig2.h5", path), &sweep, &message), &message);
    assert_true(sweep.axis_count == 1 && sweep.axes[0].count == 125 && sweep.axes[0].low == 0.055 &&
                sweep.axes[0].high == 55 && strcmp(sweep.axes[0].key, "omega") == 0);
    assert_true(sweep.options.transient == 200 && sweep.options.keep == SALTUS_KEEP_TURNING &&
                sweep.complete);
    long long points = 0;
    for (long long row = 0; row < sweep.row_count; row++)
        points += sweep.turning_count[row];
    assert_true(points > 0);
    saltus_sweep_file_clear(&sweep);
    figure_free(&f);
    run("paper --figure 3 --quiet");
    f = figure_taken(folder);
    figure_says(&f, "fig3:  2/2");
    assert_true(figure_begins(f.terminal, "pngcairo"));
    assert_int_equal(access(path_in("paper/fig3.png", path), F_OK), 0);
    assert_int_equal(access(path_in("paper/fig3.h5", path), F_OK), 0);
    figure_free(&f);
    /* In a size of their own, without words: a column of a journal has 1004 dots. */
    for (int k = 2; k < 4; k++) {
        char line[120];
        snprintf(line, sizeof line, "paper --quick --figure %d --size column --no-heading --quiet", k);
        run(line);
        f = figure_taken(folder);
        assert_non_null(strstr(f.terminal, "size 1004,"));
        assert_null(figure_mark_of(&f.panel[0], 'l', k == 2 ? "fig2:" : "fig3:", 0));
        figure_free(&f);
    }
}

/* Each kind of figure is accepted by the real gnuplot; for an empty curve it prints a message. */
static void gnuplot_takes_every_script(void **state) {
    (void)state;
    static const char *const figures[] = {
        "diagnose scene.yaml --quiet",
        "plot s.h5 --view class",
        "plot b.h5",
        "plot m.h5",
        "plot m.h5 --view speed",
        "spectrum scene.yaml --samples 64 --quiet",
        "lyapunov scene.yaml --transient 20 --periods 400 --members 2 --quiet"};
    char command[600], path[path_size];
    size_t length;
    /* The gnuplot after the script keeper in the PATH. */
    const char *others = strchr(getenv("PATH"), ':') + 1;
    snprintf(command, sizeof command, "PATH='%s' gnuplot --version >'%s/version' 2>&1", others, folder);
    if (system(command) != 0)
        skip();
    write_scene("scene.yaml", struck);
    run("sweep scene.yaml --over omega=1.9:2.1:5 -o s.h5 --quiet");
    run("sweep scene.yaml --over omega=1.9:2.1:4 --over d=0.2:0.3:3 -o m.h5 --quiet");
    run("continue scene.yaml --in omega=1.95:2.05 -o b.h5 --quiet");
    for (int k = 0; k < 7; k++) {
        snprintf(command, sizeof command, "%s -o f.png", figures[k]);
        run(command);
        snprintf(command, sizeof command,
                 "cd '%s' && PATH='%s' gnuplot --default-settings <script >picture 2>words && ! grep -v -e "
                 "'no valid points' -e '^$' words",
                 folder, others);
        if (system(command) != 0)
            fail_msg("gnuplot does not take %s", figures[k]);
        unsigned char *picture = read_all(path_in("picture", path), &length);
        assert_true(length > 5000 && memcmp(picture, "\x89PNG", 4) == 0);
        free(picture);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_are_drawn_where_they_are),
        cmocka_unit_test(densities_are_drawn_with_their_band),
        cmocka_unit_test(strong_lines_are_marked_where_they_stand_apart),
        cmocka_unit_test(spectra_are_headed_by_what_they_show),
        cmocka_unit_test(spectra_end_where_they_have_nothing_left),
        cmocka_unit_test(histories_converge_to_their_end),
        cmocka_unit_test(convergence_tells_its_doubts),
        cmocka_unit_test(histories_choose_their_axes),
        cmocka_unit_test(diagnose_draws_the_data_that_it_keeps),
        cmocka_unit_test(diagnose_looks_longer_at_what_has_no_period),
        cmocka_unit_test(spectrum_draws_its_table),
        cmocka_unit_test(lyapunov_draws_its_table),
        cmocka_unit_test(branches_turn_where_the_cloud_does),
        cmocka_unit_test(plot_draws_what_is_asked_for),
        cmocka_unit_test(paper_draws_the_figure_asked_for),
        cmocka_unit_test(gnuplot_takes_every_script),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
