/* The words on a motion's page: caption, headings of panels and names of axes, for every kind of motion, with
 * each item known or unknown.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/caption.h"
#include "made_record.h"

/* A text with single blanks, because lines may break at any. */
static void single_blanks(char *text) {
    char *to = text;
    for (const char *from = text; *from; from++)
        if (*from != ' ' || to == text || to[-1] != ' ')
            *to++ = *from;
    *to = '\0';
}

static bool says(const figure *f, const char *words) {
    char text[8000], wanted[2000];
    figure_caption(f, text, sizeof text);
    snprintf(wanted, sizeof wanted, "%s", words);
    single_blanks(text);
    single_blanks(wanted);
    return strstr(text, wanted) != NULL;
}

static void check_says(const figure *f, const char *words) {
    char text[8000];
    figure_caption(f, text, sizeof text);
    if (!says(f, words))
        fail_msg("the caption does not say '%s': %s", words, text);
}

static saltus_motion chaotic(void) {
    saltus_motion motion = irregular();
    motion.verdict = SALTUS_CHAOTIC;
    strcpy(motion.label, "chaotic");
    motion.lyapunov = 0.5625;
    motion.lyapunov_error = 0.03125;
    motion.evidence = (saltus_evidence){.periods = 77,
                                        .members = 5,
                                        .half = {NAN, NAN},
                                        .half_errors = {0.0625, 0.125},
                                        .zero_one = NAN,
                                        .dimension = NAN,
                                        .dimension_error = 0.0625,
                                        .broadband = NAN,
                                        .impacts_per_period = 1.625};
    return motion;
}

static figure draw_motion(const saltus_system *system, const saltus_motion *motion) {
    static made_up m;
    make_record(&m, system, 2, NULL, 0);
    const saltus_diagnosis diagnosis = {.motion = motion, .record = &m.record};
    return draw(system, &diagnosis);
}

/* Each number of the evidence is given if it is known and supports the verdict, with one semicolon, between
 * what was measured and what is shown. */
static void evidence_is_told_where_it_is_known(void **state) {
    (void)state;
    saltus_system *system = between_stops(0.5);
    for (int k = 0; k < 32; k++) {
        saltus_motion motion = chaotic();
        saltus_evidence *e = &motion.evidence;
        char wanted[600] = "by 5 trajectories ";
        if (k >= 16 && k < 32) {
            motion.verdict = SALTUS_QUASIPERIODIC;
            motion.lyapunov = 0;
        }
        if (k & 1) {
            e->half[0] = -0.5;
            e->half[1] = 0.625;
            if (k < 16)
                strcat(wanted, "exponent in the halves of the run −0.500 ± 0.062 and 0.62 ± 0.12; ");
        }
        if (k & 2) {
            e->zero_one = -0.25;
            strcat(wanted, "0–1 test −0.250; ");
        }
        if (k & 4) {
            e->dimension = 1.25;
            strcat(wanted, "correlation dimension 1.250 ± 0.062; ");
        }
        if (k & 8) {
            e->broadband = 0.375;
            strcat(wanted, "broadband fraction 0.38; ");
        }
        strcat(wanted, "1.625 impacts per {/:Italic T} shown: 2 periods, section 2");
        figure f = draw_motion(system, &motion);
        check_says(&f, wanted);
        figure_free(&f);
    }
    for (int k = 0; k < 2; k++) { /* a single half says nothing */
        saltus_motion motion = chaotic();
        motion.evidence.half[k] = 0.5;
        figure f = draw_motion(system, &motion);
        check_says(&f, "by 5 trajectories 1.625 impacts");
        figure_free(&f);
    }
    /* Complete chatter has no number of impacts. */
    saltus_motion endless = chaotic();
    endless.evidence.zero_one = 0.5;
    endless.evidence.impacts_per_period = NAN;
    figure without = draw_motion(system, &endless);
    check_says(&without, "0–1 test 0.500 shown:");
    figure_free(&without);
    /* Without measurement no numbers; an orbit needs none. */
    saltus_motion motion = chaotic(), orbit = orbit_of(1);
    orbit.evidence = motion.evidence;
    motion.evidence.periods = 0;
    for (int k = 0; k < 2; k++) {
        figure f = draw_motion(system, k ? &orbit : &motion);
        assert_false(says(&f, "1.625"));
        figure_free(&f);
    }
    saltus_system_free(system);
}

static void small_fractions_are_powers_of_ten(void **state) {
    (void)state;
    static const double fractions[] = {1, 0.001, 0.00099, 2.5e-7, 0};
    static const char *const words[] = {"1", "0.001", "9.9·10^{−4}", "2.5·10^{−7}", "0"};
    saltus_system *system = between_stops(0.5);
    for (int k = 0; k < 5; k++) {
        saltus_motion motion = chaotic();
        char wanted[80];
        motion.evidence.broadband = fractions[k];
        snprintf(wanted, sizeof wanted, "broadband fraction %s; ", words[k]);
        figure f = draw_motion(system, &motion);
        check_says(&f, wanted);
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* So are small parameters, restitutions and places of stops. */
static void small_values_are_powers_of_ten(void **state) {
    (void)state;
    static const char *const wanted[2][3] = {
        {"{/:Italic α} = 2.5·10^{−7}", "{/:Italic ξ} = 1·10^{−5}", "{/:Italic r} = 2·10^{−6}"},
        {"{/:Italic k} = 3·10^{10}", "{/:Italic x}_1 − 4·10^{−5} {/:Italic x}_2",
         "{/:Italic r} = 2·10^{−6}"}};
    for (int pipe = 1; pipe >= 0; pipe--) {
        saltus_spec spec = pipe ? pipe_spec(1, 40) : oscillator_spec(0.125, 3e10, 1.5, 0.625);
        saltus_line line = {.length = 0};
        set_parameter(&spec, pipe ? "alpha" : "N", pipe ? 2.5e-7 : 2);
        add_stop(&spec, 0.25, 2e-6, SALTUS_UPPER);
        spec.stops[0].xi = 1e-5;
        spec.stops[0].weight[1] = -4e-5;
        saltus_system *system = build(&spec);
        saltus_line_parameters(&line, system, (const char *const[2]){NULL, NULL});
        for (int k = 0; k < 3; k++)
            if (!strstr(line.text, wanted[!pipe][k]))
                fail_msg("'%s' is not in '%s'", wanted[!pipe][k], line.text);
        saltus_system_free(system);
    }
}

/* The exponent of a motion without a period and its meaning; curves and laminar phases if there are any. */
static void irregular_motions_are_told_by_their_exponent(void **state) {
    (void)state;
    static const struct {
        saltus_verdict kind;
        double exponent;
        int curves, laminar;
        const char *said, *unsaid;
    } cases[] = {
        {SALTUS_CHAOTIC, 0.5625, 0, 0, "0.562 ± 0.031 per unit of time, positive in both halves of the run;",
         "closed curve"},
        {SALTUS_CHAOTIC, 0.01, 0, 1,
         "intermittent: 26 % of the time near a motion of period {/:Italic T}, up to 43 periods", "zero"},
        {SALTUS_QUASIPERIODIC, -0.09375, 1, 3,
         "−0.094 ± 0.031 per unit of time, zero within its error; measured over 77 periods by 5 "
         "trajectories; "
         "section points fill 1 closed curve 1.625",
         "positive"},
        {SALTUS_QUASIPERIODIC, 0.09376, 2, 0,
         "next to zero; measured over 77 periods by 5 trajectories; section points fill 2 closed curves "
         "1.625",
         "intermittent"},
        {SALTUS_QUASIPERIODIC, -0.09376, 2, 2,
         "near a motion of period 2 {/:Italic T}, up to 43 periods at a", "zero within"},
        {SALTUS_UNDECIDED, 0.5, 3, 0, "2, exponent 0.1 ± 0.2 and 0.3 ± 0.4 so far", "unit of time"},
    };
    saltus_system *system = between_stops(0.5);
    for (int k = 0; k < 6; k++) {
        saltus_motion motion = chaotic();
        motion.verdict = cases[k].kind;
        motion.lyapunov = cases[k].exponent;
        motion.evidence.curves = cases[k].curves;
        motion.evidence.laminar = 0.256;
        motion.evidence.laminar_period = cases[k].laminar;
        motion.evidence.longest_phase = 43;
        strcpy(motion.reason, "2, exponent 0.1 +- 0.2 and 0.3 +- 0.4 so far");
        figure f = draw_motion(system, &motion);
        check_says(&f, cases[k].said);
        assert_false(says(&f, cases[k].unsaid));
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* The description of an orbit or equilibrium, with singulars. A pipe responds in two periods. */
static void settled_motions_are_told_by_their_impacts(void **state) {
    (void)state;
    static const struct {
        saltus_verdict kind;
        int periods, sticks;
        long long impacts;
        saltus_mirror mirror;
        const char *said[2]; /* of an oscillator and of a pipe */
    } cases[] = {
        {SALTUS_EQUILIBRIUM, 0, 0, 0, SALTUS_MIRROR_SELF, {"at rest, clear of every stop; Floquet", NULL}},
        {SALTUS_HELD, 0, 1, 0, SALTUS_MIRROR_PAIR, {"in contact for good; Floquet", NULL}},
        {SALTUS_PERIODIC,
         2,
         1,
         -1,
         SALTUS_MIRROR_NONE,
         {"complete chatter, 1 sticking interval in 2 {/:Italic T}; Floquet", NULL}},
        {SALTUS_PERIODIC,
         1,
         2,
         -1,
         SALTUS_MIRROR_SELF,
         {"complete chatter, 2 sticking intervals in 1 {/:Italic T}; its own mirror image; Floquet", NULL}},
        {SALTUS_PERIODIC,
         3,
         0,
         0,
         SALTUS_MIRROR_PAIR,
         {"no impact in 3 {/:Italic T}; one of a mirror pair; Floquet", NULL}},
        {SALTUS_PERIODIC,
         4,
         0,
         1,
         SALTUS_MIRROR_NONE,
         {"1 impact in 4 {/:Italic T}, 0.25 per response cycle; Floquet",
          "1 impact in 4 {/:Italic T}, 0.5 per response cycle 2{/:Italic T}; Floquet"}},
        {SALTUS_PERIODIC,
         2,
         0,
         3,
         SALTUS_MIRROR_NONE,
         {"3 impacts in 2 {/:Italic T}, 1.5 per response cycle; Floquet",
          "3 impacts in 2 {/:Italic T}, 3 per response cycle 2{/:Italic T}; Floquet"}},
    };
    saltus_spec spec = pipe_spec(2, 20);
    saltus_system *systems[2] = {between_stops(0.5), build(&spec)};
    for (int k = 0; k < 14; k++) {
        saltus_motion motion = orbit_of(cases[k / 2].periods);
        const char *const *said = cases[k / 2].said;
        motion.verdict = cases[k / 2].kind;
        motion.impacts = cases[k / 2].impacts;
        motion.sticking_intervals = cases[k / 2].sticks;
        motion.mirror = cases[k / 2].mirror;
        figure f = draw_motion(systems[k % 2], &motion);
        check_says(&f, said[said[1] ? k % 2 : 0]);
        figure_free(&f);
    }
    for (int k = 0; k < 2; k++)
        saltus_system_free(systems[k]);
}

/* The first four multipliers, a pair as one; a complex one without its partner alone. */
static void leading_multipliers_are_told(void **state) {
    (void)state;
    static const struct {
        int count;
        saltus_multiplier list[6];
        const char *said;
    } cases[] = {
        {1, {{-0.5, 0, 0}}, "multipliers −0.5 largest"},
        {2, {{0.5, 0, 0}, {0.5, 0, 0}}, "multipliers 0.5, 0.5 largest"},
        {1,
         {{0.3, 0.4, -0.69314718055994531}, {0.3, -0.4, -0.69314718055994531}},
         "multipliers 0.3 + 0.4{/:Italic i} (modulus 0.5) largest"},
        {4,
         {{0.5, 0, 0}, {0.25, 0, 0}, {-0.125, 0, 0}, {1e-9, 0, 0}},
         "multipliers 0.5, 0.25, −0.125, 1·10^{−9} largest"},
        {5,
         {{0.5, 0, 0}, {0.25, 0, 0}, {-0.125, 0, 0}, {0.0625, 0, 0}, {0, 0, 0}},
         "multipliers 0.5, 0.25, −0.125, 0.0625, … largest"},
        {4,
         {{0.3, 0.4, -0.69314718055994531},
          {0.3, -0.4, -0.69314718055994531},
          {-0.06, -0.08, -2.3025850929940457},
          {-0.06, 0.08, -2.3025850929940457}},
         "multipliers 0.3 ± 0.4{/:Italic i} (modulus 0.5), −0.06 ± 0.08{/:Italic i} (modulus 0.1) largest"},
        {6,
         {{2, 0, 0},
          {0.3, 0.4, -0.69314718055994531},
          {0.3, -0.4, -0.69314718055994531},
          {0.25, 0, 0},
          {0.125, 0, 0},
          {0, 0, 0}},
         "multipliers 2, 0.3 ± 0.4{/:Italic i} (modulus 0.5), 0.25, … largest"},
        {3,
         {{0.3, 0.4, -0.69314718055994531}, {0.3, -0.3, 0}, {0.25, 0.3, 0}},
         "multipliers 0.3 + 0.4{/:Italic i} (modulus 0.5), 0.3 − 0.3{/:Italic i} (modulus 1), 0.25 + "
         "0.3{/:Italic i} (modulus 1) largest"},
    };
    saltus_system *system = between_stops(0.5);
    for (int k = 0; k < 8; k++) {
        saltus_motion motion = orbit_of(1);
        saltus_multiplier list[6];
        memcpy(list, cases[k].list, sizeof list);
        motion.multipliers = list;
        motion.multiplier_count = cases[k].count;
        figure f = draw_motion(system, &motion);
        check_says(&f, cases[k].said);
        figure_free(&f);
    }
    saltus_motion bare = orbit_of(1), none = chaotic();
    bare.multiplier_count = 0;
    none.multipliers = pair_of_multipliers;
    none.multiplier_count = 2;
    for (int k = 0; k < 2; k++) {
        figure f = draw_motion(system, k ? &bare : &none);
        assert_false(says(&f, "Floquet"));
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* An orbit's exponent, and over how many periods; not given for an equilibrium or if unknown. */
static void exponents_of_orbits_are_told(void **state) {
    (void)state;
    static const struct {
        saltus_verdict kind;
        int periods;
        double exponent;
        const char *said;
    } cases[] = {
        {SALTUS_PERIODIC, 1, 0.5, "largest exponent ln|{/:Italic μ}_1|/{/:Italic T} = 0.5 per unit of time"},
        {SALTUS_PERIODIC, 2, -0.25, "ln|{/:Italic μ}_1|/(2 {/:Italic T}) = −0.25 per unit of time"},
        {SALTUS_PERIODIC, 1, -INFINITY, "ln|{/:Italic μ}_1|/{/:Italic T} = −∞ per unit of time"},
        {SALTUS_PERIODIC, 1, NAN, NULL},
        {SALTUS_HELD, 0, -0.25, NULL}};
    saltus_system *system = between_stops(0.5);
    for (int k = 0; k < 5; k++) {
        saltus_motion motion = orbit_of(cases[k].periods);
        motion.verdict = cases[k].kind;
        motion.lyapunov = cases[k].exponent;
        figure f = draw_motion(system, &motion);
        if (cases[k].said)
            check_says(&f, cases[k].said);
        else
            assert_false(says(&f, "exponent"));
        figure_free(&f);
    }
    saltus_system_free(system);
}

/* Lines or a density of the first quantity. */
static saltus_spectra spectra_of(saltus_spectrum_kind kind, int periods, saltus_spectral_line *lines,
                                 int count) {
    static double density[9] = {0, 1, 4, 2, 1, 0.5, 0.25, 0.25, 0.125};
    saltus_spectra spectra = {.count = 1,
                              .periods = periods,
                              .per_period = 16,
                              .analysed = 30,
                              .spectra = {{.kind = kind,
                                           .per_period = 16,
                                           .bins = 9,
                                           .resolution = 1,
                                           .density = density,
                                           .orbits = 3,
                                           .periods = periods,
                                           .segments = periods ? 0 : 1,
                                           .segment_periods = 20,
                                           .lines = lines,
                                           .line_count = count,
                                           .low = 0.5,
                                           .high = 2,
                                           .confidence = 0.875,
                                           .between = NAN,
                                           .trustworthy = 3}}};
    return spectra;
}

/* The spectrum's heading names its lines; red ones only if some are visible. */
static void spectra_are_headed_by_their_lines(void **state) {
    (void)state;
    static made_up m;
    static const struct {
        saltus_spectrum_kind kind;
        int periods, count;
        double forced; /* decibels of the line at omega */
        const char *said;
    } cases[] = {{SALTUS_SPECTRUM_LINES, 1, 2, 0, ": multiples of {/:Italic ω}"},
                 {SALTUS_SPECTRUM_LINES, 2, 2, -99, "; squares: multiples of {/:Italic ω}"},
                 {SALTUS_SPECTRUM_LINES, 2, 2, -101, ": multiples of {/:Italic ω}/2"},
                 {SALTUS_SPECTRUM_LINES, 2, 1, 0, ": multiples of {/:Italic ω}/2"},
                 {SALTUS_SPECTRUM_WELCH, 0, 2, -20, "; 87.5 % band; ▾ lines"},
                 {SALTUS_SPECTRUM_WELCH, 0, 0, 0, "; 87.5 % band"}};
    saltus_system *system = between_stops(0.5);
    for (int k = 0; k < 12; k++) {
        bool irregular_too = k >= 6;
        int c = k % 6, p = cases[c].periods;
        saltus_spectral_line lines[2] = {{p > 0, 1.0 / fmax(p, 1), 0.5, 0, 0, 0.9},
                                         {p > 0 ? 2 : 0, 2.0 / fmax(p, 1), 0.25, 0, cases[c].forced, 0.1}};
        saltus_spectra spectra = spectra_of(cases[c].kind, p, lines, cases[c].count);
        saltus_motion motion = irregular_too ? chaotic() : orbit_of(1);
        char wanted[200];
        make_record(&m, system, 2, NULL, 0);
        const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record, .spectra = &spectra};
        figure f = draw(system, &diagnosis);
        const figure_panel *panel = figure_panel_of(&f, "frequency");
        const figure_mark *heading = figure_mark_of(panel, 'l', "{/:Bold (", 0);
        snprintf(wanted, sizeof wanted, "  displacement {/:Italic x}_1%s", cases[c].said);
        assert_true(heading && strlen(heading->text) > strlen(wanted));
        assert_string_equal(heading->text + strlen(heading->text) - strlen(wanted), wanted);
        /* The origin is given with what else is shown, unless the motion is a closed orbit. */
        check_says(&f, irregular_too ? "shown: 2 periods, section 2;  spectrum from " : "made\\_up");
        if (irregular_too && p)
            check_says(&f,
                       p == 1 ? "from 3 orbits of 1 T, 16 samples a period" : "3 orbits of 2 T, 16 samples");
        if (irregular_too && !p)
            check_says(&f, "from 30 T, 16 samples a period; 1 segment of 20 T (Welch");
        assert_true(says(&f, "shown") == irregular_too);
        figure_free(&f);
    }
    /* An equilibrium is no closed orbit and has no section. */
    saltus_motion motion = orbit_of(0);
    motion.verdict = SALTUS_EQUILIBRIUM;
    figure f = draw_motion(system, &motion);
    check_says(&f, "shown: 2 periods");
    assert_false(says(&f, "section"));
    figure_free(&f);
    saltus_system_free(system);
}

/* The name of the observed coordinate: a place of the pipe, a mass, or the coordinate of the first stop. */
static void axes_name_what_is_observed(void **state) {
    (void)state;
    static const struct {
        double xi, weight[2];
        const char *words[2];
    } cases[] = {
        {0.5,
         {0, 0},
         {"displacement {/:Italic η}(½, {/:Italic τ})",
          "velocity ∂{/:Italic η}/∂{/:Italic τ} (½, {/:Italic τ})"}},
        {0.375,
         {0, 0},
         {"displacement {/:Italic η}(0.375, {/:Italic τ})", "{/:Italic τ} (0.375, {/:Italic τ})"}},
        {-1, {0, 0}, {"displacement {/:Italic η}(½, {/:Italic τ})", "{/:Italic τ} (½, {/:Italic τ})"}},
        {0, {1, 0}, {"displacement {/:Italic x}_1", "velocity d{/:Italic x}_1/d{/:Italic t}"}},
        {0, {0, 1}, {"displacement {/:Italic x}_2", "velocity d{/:Italic x}_2/d{/:Italic t}"}},
        {0, {0.5, 0.5}, {"contact coordinate {/:Italic g}", "velocity d{/:Italic g}/d{/:Italic t}"}},
        {0, {2, -1}, {"contact coordinate {/:Italic g}", "velocity d{/:Italic g}/d{/:Italic t}"}},
        {0, {0, 2}, {"contact coordinate {/:Italic g}", "velocity d{/:Italic g}/d{/:Italic t}"}},
        {0, {0.5, 0}, {"contact coordinate {/:Italic g}", "velocity d{/:Italic g}/d{/:Italic t}"}},
        {0, {-1, 0}, {"contact coordinate {/:Italic g}", "velocity d{/:Italic g}/d{/:Italic t}"}},
    };
    for (int k = 0; k < 10; k++) {
        saltus_spec spec = cases[k].xi ? pipe_spec(2, 20) : oscillator_spec(0.125, 1.75, 1.5, 0.625);
        if (!cases[k].xi)
            set_parameter(&spec, "N", 2);
        if (cases[k].xi >= 0) {
            add_stop(&spec, 0.5, 0.75, SALTUS_UPPER);
            spec.stops[0].xi = cases[k].xi;
            memcpy(spec.stops[0].weight, cases[k].weight, sizeof cases[k].weight);
        }
        saltus_system *system = build(&spec);
        saltus_motion motion = orbit_of(1);
        figure f = draw_motion(system, &motion);
        const figure_panel *portrait = figure_panel_of(&f, "phase portrait"),
                           *history = figure_panel_of(&f, "one orbit");
        assert_string_equal(portrait->label[0], cases[k].words[0]);
        assert_string_equal(history->label[1], cases[k].words[0]);
        assert_non_null(strstr(portrait->label[1], cases[k].words[1]));
        figure_free(&f);
        saltus_system_free(system);
    }
}

/* Lines of the caption are equally spaced: title and what is shown grey, all between dark. */
static void captions_have_an_order(void **state) {
    (void)state;
    static const char *const begins[] = {
        "{/=20:Bold made\\_up:", "it's \\{made\\} up", "oscillator: ", "largest exponent",
        "1.625 impacts",         "intermittent",       "shown: "};
    static const long colours[] = {-1, 0x606060, 0x202020, 0x202020, 0x202020, 0x202020, 0x606060};
    saltus_system *system = between_stops(0.5);
    saltus_motion motion = chaotic();
    motion.evidence.laminar_period = 1;
    figure f = draw_motion(system, &motion);
    figure_check_lines(&f, begins, colours, 7);
    figure_free(&f);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(evidence_is_told_where_it_is_known),
        cmocka_unit_test(small_fractions_are_powers_of_ten),
        cmocka_unit_test(small_values_are_powers_of_ten),
        cmocka_unit_test(irregular_motions_are_told_by_their_exponent),
        cmocka_unit_test(settled_motions_are_told_by_their_impacts),
        cmocka_unit_test(leading_multipliers_are_told),
        cmocka_unit_test(exponents_of_orbits_are_told),
        cmocka_unit_test(spectra_are_headed_by_their_lines),
        cmocka_unit_test(axes_name_what_is_observed),
        cmocka_unit_test(captions_have_an_order),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
