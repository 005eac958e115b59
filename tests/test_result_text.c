/* Printed texts about equilibria, exponents, spectra and branches: each line appears if it applies, with the
 * numbers of made-up results in their places, which are those of JSON and CSV.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"
#include "json.h"
#include "text_lines.h"

#include <unistd.h>

typedef struct setting {
    saltus_scene scene;
    saltus_system *system;
} setting;

static void make(setting *s, double force) {
    *s = (setting){.scene = {.name = "made"}};
    s->scene.spec = oscillator_spec(0.125, 2.5, force, 1.75);
    set_parameter(&s->scene.spec, "N", 2);
    add_stop(&s->scene.spec, 0.375, 0.625, SALTUS_BOTH);
    s->system = build(&s->scene.spec);
}

static void check_scene(text_lines *lines) {
    lines_next(lines, "oscillator", NULL, -1);
    lines_next(lines, "stop 1 ", "both sides", 4, 1., 0., 0.375, 0.625);
}

static void rests_are_told(void **state) {
    (void)state;
    setting s;
    make(&s, 0);
    double x[] = {0.125, -0.75, 0, 0};
    saltus_eigenvalue values[] = {{0.5, 0},    {-0.25, 1.5}, {-0.25, -1.5},
                                  {-0.375, 0}, {-0.4375, 0}, {-0.625, 0}};
    for (int kind = 0; kind < 3; kind++) {
        saltus_equilibrium e = {.dimension = 4,
                                .state = x,
                                .contacts = kind == 1 ? 2 : 0,
                                .contact_force = {1.25, 2.25},
                                .gap = {-0.25, -0.5},
                                .eigenvalues = values + (kind == 2),
                                .eigenvalue_count = kind == 0   ? 6
                                                    : kind == 1 ? 4
                                                                : 3,
                                .instability = kind == 2 ? 0 : 1,
                                .stable = kind == 2,
                                .iterations = 3 - kind,
                                .residual = 2.5e-14};
        text_lines lines;
        lines_open(&lines);
        saltus_write_equilibrium_text(lines.stream, &s.scene, s.system, &e);
        lines_read(&lines);
        lines_next(&lines,
                   kind == 0   ? "made: equilibrium, unstable"
                   : kind == 1 ? "made: held, unstable"
                               : "made: equilibrium, stable",
                   NULL, 0);
        check_scene(&lines);
        lines_next(&lines, "contacts", "stop 1 upper: free, gap", 2, 1., -0.25);
        if (kind == 1)
            lines_next(&lines, "stop 1 lower", "held, force", 1, 2.25);
        else
            lines_next(&lines, "stop 1 lower", "free, gap", 1, -0.5);
        if (kind == 0)
            lines_next(&lines, "eigenvalues", ", ...; 1 with", 6, 0.5, -0.25, 1.5, -0.375, -0.4375, 1.);
        else if (kind == 1)
            lines_next(&lines, "eigenvalues", "1 with a positive real part (of the motion", 5, 0.5, -0.25,
                       1.5, -0.375, 1.);
        else
            lines_next(&lines, "eigenvalues", NULL, 3, -0.25, 1.5, -0.375);
        assert_true(kind == 0 || !strstr(lines.text, "..."));
        assert_true(kind == 1 || !strstr(lines.text, "keeps in contact"));
        lines_next(&lines, "state", NULL, 2, 0.125, -0.75);
        lines_next(&lines, "rest", kind == 2 ? "Newton step" : "Newton steps", 2, 2.5e-14, 3. - kind);
        assert_int_equal(kind == 2, lines.at[-2] == 'p');
        lines_end(&lines);

        lines_open(&lines);
        saltus_write_equilibrium_json(lines.stream, &s.scene, s.system, &e);
        lines_read(&lines);
        json *o = json_read(lines.text);
        assert_string_equal(json_text_at(o, "label"), kind == 1 ? "held" : "equilibrium");
        assert_string_equal(json_text_at(o, "kind"), kind == 1 ? "held" : "equilibrium");
        static const char *const zero[] = {"impacts", "periods", "sticking_intervals"}, *const none[] = {
                                                                                            "events",
                                                                                            "multipliers",
                                                                                            "log_moduli"};
        for (int k = 0; k < 3; k++) {
            assert_true(json_number_at(o, zero[k]) == 0);
            assert_int_equal(json_count(json_at(o, none[k])), 0);
        }
        assert_int_equal(json_count(json_at(o, "state")), 4);
        assert_true(json_number_at(o, "state.1") == -0.75);
        assert_int_equal(json_count(json_at(o, "eigenvalues")), e.eigenvalue_count);
        for (int k = 0; k < e.eigenvalue_count; k++) {
            char path[32];
            snprintf(path, sizeof path, "eigenvalues.%d.0", k);
            assert_true(json_number_at(o, path) == e.eigenvalues[k].re);
            path[strlen(path) - 1] = '1';
            assert_true(json_number_at(o, path) == e.eigenvalues[k].im);
        }
        for (int f = 0; f < 2; f++) {
            char path[40];
            snprintf(path, sizeof path, "contact_force.%d.force", f);
            assert_true(json_number_at(o, path) == e.contact_force[f]);
            snprintf(path, sizeof path, "contact_force.%d.gap", f);
            assert_true(json_number_at(o, path) == e.gap[f]);
            snprintf(path, sizeof path, "contact_force.%d.stop", f);
            assert_true(json_number_at(o, path) == 1);
            snprintf(path, sizeof path, "contact_force.%d.side", f);
            assert_string_equal(json_text_at(o, path), f ? "lower" : "upper");
        }
        assert_true(json_at(o, "stable")->kind == (kind == 2 ? JSON_TRUE : JSON_FALSE));
        assert_true(json_number_at(o, "instability") == e.instability &&
                    json_number_at(o, "iterations") == e.iterations &&
                    json_number_at(o, "residual") == e.residual);
        json_free(o);
        free(lines.text);
    }
    saltus_system_free(s.system);
}

typedef struct exponents {
    saltus_lyapunov l;
    saltus_lyapunov_options o;
    double value[4], error[4], member[3], state[4];
} exponents;

/* Errors of 0.0031 leave four decimals, so rounding does not matter here. */
static void make_exponents(exponents *e) {
    *e = (exponents){.value = {0.2512, -0.1378, -0.5213, -1.1004},
                     .error = {0.0031, 0.0042, 0.0053, 0.0064},
                     .member = {0.2498, 0.2547, 0.2511},
                     .o = saltus_lyapunov_defaults()};
    e->o.transient = 700;
    e->o.precision = 0.05;
    e->l = (saltus_lyapunov){.dimension = 4,
                             .count = 4,
                             .exponents = e->value,
                             .standard_errors = e->error,
                             .state = e->state,
                             .sum = -1.5083,
                             .sum_rule = -1.5081,
                             .kaplan_yorke = 2.217,
                             .impacts_per_period = 1.375,
                             .sticks_per_period = 0.625,
                             .period = 2.5,
                             .time = 7812.5,
                             .periods = 3125,
                             .transient = 900,
                             .half = {0.2433, 0.2591},
                             .half_errors = {0.0047, 0.0059},
                             .members = 3,
                             .member_exponents = e->member,
                             .agree = true,
                             .precise = true};
}

static void write_exponents(exponents *e, const setting *s, text_lines *lines) {
    lines_open(lines);
    saltus_write_lyapunov_text(lines->stream, &s->scene, s->system, &e->o, &e->l);
    lines_read(lines);
}

static void skip_to(text_lines *lines, const char *head) {
    while (*lines->at && strncmp(lines->at + strspn(lines->at, " "), head, strlen(head)) != 0)
        lines_next(lines, "", NULL, -1);
}

static void exponents_are_told(void **state) {
    (void)state;
    setting s, pushed;
    exponents e;
    text_lines lines;
    make(&s, 0);
    make(&pushed, 1);
    for (int forced = 0; forced < 2; forced++) {
        make_exponents(&e);
        write_exponents(&e, forced ? &pushed : &s, &lines);
        lines_next(&lines, "made: largest Lyapunov exponent", NULL, 2, 0.2512, 0.0031);
        check_scene(&lines);
        lines_next(&lines, "exponent", NULL, 5, 0.2512, 0.0031, 0.628, 0.00775, 2.5);
        lines_next(&lines, "meaning", "positive", 1, 1 / 0.628);
        if (!forced)
            lines_next(&lines, "not forced", NULL, 0);
        lines_next(&lines, "exponents", NULL, 0);
        for (int k = 0; k < 4; k++)
            lines_next(&lines, "", NULL, 4, k + 1., e.value[k], e.error[k], 2.5 * e.value[k]);
        lines_next(&lines, "sum rule", NULL, 3, -1.5083, -1.5081, -0.0002);
        if (forced)
            lines_next(&lines, "dimension", "with time", 2, 2.217, 3.217);
        else
            lines_next(&lines, "dimension", NULL, 1, 2.217);
        lines_next(&lines, "halves", "standard errors apart", 5, 0.2433, 0.0047, 0.2591, 0.0059,
                   0.0158 / hypot(0.0047, 0.0059));
        lines_next(&lines, "trajectories", "they agree", 3, 3., 0.2498, 0.2547);
        lines_next(&lines, "impacts", NULL, 2, 1.375, 0.625);
        lines_next(&lines, "measured", NULL, 2, 3125., 7812.5);
        lines_next(&lines, "transient", "as asked for", 2, 900., 700.);
        lines_next(&lines, "precision", "reached", 1, 100 * 0.0031 / 0.2512);
        lines_end(&lines);
    }

    /* One trajectory, no transient beyond the requested one, one exponent; equal halves. */
    make_exponents(&e);
    e.l.members = e.l.count = 1;
    e.l.transient = 700;
    e.l.half_errors[0] = e.l.half_errors[1] = 0;
    e.value[0] = -0.25;
    e.l.precise = false;
    e.o.precision = 0.001;
    write_exponents(&e, &pushed, &lines);
    lines_next(&lines, "made:", NULL, -1);
    check_scene(&lines);
    lines_next(&lines, "exponent", NULL, -1);
    lines_next(&lines, "meaning", "negative", 1, 1.6);
    lines_next(&lines, "halves", NULL, 4, 0.2433, 0., 0.2591, 0.);
    lines_next(&lines, "trajectories", NULL, 1, 1.);
    lines_next(&lines, "impacts", NULL, -1);
    lines_next(&lines, "measured", NULL, -1);
    lines_next(&lines, "transient", NULL, 1, 700.);
    lines_next(&lines, "precision", "NOT reached: the standard error", 2, 100 * 0.0031 / 0.25, 0.1);
    lines_end(&lines);

    /* The precision is not reached despite a small error, or reached despite a large one. */
    make_exponents(&e);
    e.l.precise = e.l.agree = false;
    write_exponents(&e, &pushed, &lines);
    skip_to(&lines, "trajectories");
    lines_next(&lines, "trajectories", "NOT AGREE", -1);
    lines_next(&lines, "they do not", NULL, 0);
    skip_to(&lines, "precision");
    lines_next(&lines, "precision", "NOT reached: too few values", 1, 100 * 0.0031 / 0.2512);
    lines_end(&lines);
    make_exponents(&e);
    e.error[0] = 0.1;
    write_exponents(&e, &pushed, &lines);
    skip_to(&lines, "meaning");
    lines_next(&lines, "meaning", "zero within the error", 0);
    skip_to(&lines, "precision");
    lines_next(&lines, "precision", "reached: ", 1, 0.25);
    lines_end(&lines);
    make_exponents(&e);
    e.error[0] = INFINITY;
    e.l.precise = false;
    write_exponents(&e, &pushed, &lines);
    skip_to(&lines, "meaning");
    lines_next(&lines, "meaning", "undecided: too few", 0);
    skip_to(&lines, "precision");
    lines_next(&lines, "precision", "NOT reached: too few values for", 0);
    lines_end(&lines);

    /* Some directions are lost, or some exponents not requested. */
    make_exponents(&e);
    e.l.lost = 1;
    e.value[3] = -INFINITY;
    e.l.kaplan_yorke = NAN;
    write_exponents(&e, &pushed, &lines);
    skip_to(&lines, "4 ");
    lines_next(&lines, "4 ", "-infinity  lost", 0);
    lines_next(&lines, "sum rule", "does not apply", 2, 1., 4.);
    lines_next(&lines, "dimension", "needs more", 0);
    free(lines.text);
    make_exponents(&e);
    e.l.sum_rule = NAN;
    write_exponents(&e, &pushed, &lines);
    skip_to(&lines, "sum rule");
    lines_next(&lines, "sum rule", "not checked: the trace is not known", 1, e.l.sum);
    free(lines.text);
    make_exponents(&e);
    e.l.count = 3;
    write_exponents(&e, &pushed, &lines);
    skip_to(&lines, "sum rule");
    lines_next(&lines, "sum rule", "needs all", 1, 4.);
    free(lines.text);
    saltus_system_free(s.system);
    saltus_system_free(pushed.system);
}

enum { line_count = 14, bins = 9 };

typedef struct made_spectra {
    saltus_spectra s;
    saltus_spectral_line lines[2][line_count];
    double density[2][bins];
} made_spectra;

static void make_spectra(made_spectra *m, saltus_spectrum_kind kind) {
    *m = (made_spectra){
        .s = {
            .count = 2, .periods = kind == SALTUS_SPECTRUM_LINES ? 3 : 0, .analysed = 96, .per_period = 40}};
    m->s.quantities[1] = (saltus_quantity){2, true};
    for (int q = 0; q < 2; q++) {
        saltus_spectrum *s = &m->s.spectra[q];
        *s = (saltus_spectrum){.kind = kind,
                               .per_period = 40,
                               .mean = 0.125 + q,
                               .variance = 0.5 + q,
                               .parseval = 1e-12 * (q + 1),
                               .bins = bins,
                               .resolution = kind == SALTUS_SPECTRUM_LINES ? 1 / 96. : 1 / 24.,
                               .density = m->density[q],
                               .orbits = kind == SALTUS_SPECTRUM_LINES ? 32 : 0,
                               .periods = kind == SALTUS_SPECTRUM_LINES ? 3 : 0,
                               .segments = 7,
                               .segment_periods = 24,
                               .degrees = 12.5 + q,
                               .confidence = 0.75,
                               .low = 0.25,
                               .high = 4 + q,
                               .lines = m->lines[q],
                               .line_count = line_count,
                               .between = 0.0625 * (q + 1),
                               .broadband = 0.375 + q,
                               .trustworthy = 4.5};
        for (int k = 0; k < line_count; k++) {
            double amplitude = 1 + (k * 5 % line_count) * 0.25 + q;
            m->lines[q][k] = (saltus_spectral_line){.harmonic = kind == SALTUS_SPECTRUM_LINES ? k + 1 : 0,
                                                    .frequency = (k + 1) / 3.,
                                                    .amplitude = amplitude,
                                                    .phase = 0.1 * k - 0.5,
                                                    .decibels = 20 * log10(amplitude / (5 + q)),
                                                    .share = 0.01 * (k + 1)};
        }
        for (int k = 0; k < bins; k++)
            m->density[q][k] = 1 + (k * 4 % bins) + q;
    }
}

static const saltus_motion made_motion = {.label = "chaotic", .verdict = SALTUS_CHAOTIC};

/* The strongest lines up to the trusted frequency, strongest first. */
static int strongest(const saltus_spectrum *s, const saltus_spectral_line *list[line_count]) {
    int count = 0;
    for (int k = 0; k < s->line_count; k++) {
        if (s->lines[k].frequency > s->trustworthy || s->lines[k].decibels <= -220)
            continue;
        int place = count++;
        for (; place > 0 && list[place - 1]->amplitude < s->lines[k].amplitude; place--)
            list[place] = list[place - 1];
        list[place] = &s->lines[k];
    }
    return count < 10 ? count : 10;
}

static void check_lines(text_lines *lines, const saltus_spectrum *s) {
    const saltus_spectral_line *list[line_count];
    int count = strongest(s, list);
    lines_next(lines, "line: f/omega", NULL, 0);
    for (int k = 0; k < count; k++) {
        const saltus_spectral_line *l = list[k];
        if (l->harmonic && s->periods > 1)
            lines_next(lines, "", " = ", 7, (double)l->harmonic, (double)s->periods, l->frequency,
                       l->amplitude, l->phase, l->decibels, l->share);
        else
            lines_next(lines, "", NULL, 5, l->frequency, l->amplitude, l->phase, l->decibels, l->share);
    }
    if (count < s->line_count)
        lines_next(lines, "... the", NULL, 1, (double)count);
}

static void write_spectra(const made_spectra *m, const setting *s, text_lines *lines) {
    lines_open(lines);
    saltus_write_spectra_text(lines->stream, &s->scene, s->system, &made_motion, &m->s);
    lines_read(lines);
    lines_next(lines, "made: chaotic", NULL, 0);
    check_scene(lines);
}

static void spectra_are_told(void **state) {
    (void)state;
    setting s;
    made_spectra m;
    text_lines lines;
    make(&s, 1);
    make_spectra(&m, SALTUS_SPECTRUM_LINES);
    m.s.spectra[1].periods = m.s.spectra[1].orbits = 1;
    m.s.spectra[1].line_count = 10;
    m.s.spectra[1].trustworthy = 10 / 3.;
    write_spectra(&m, &s, &lines);
    lines_next(&lines, "analysed", "32 orbits of 3 T", 3, 32., 3., 40.);
    lines_next(&lines, "displacement", "mean", 3, 0.125, 0.5, 0.375);
    lines_next(&lines, "lines at multiples of omega/3, bins every omega/96", "between the lines", 1, 0.0625);
    lines_next(&lines, "highest trustworthy", NULL, 3, 4.5, 1., 20.);
    check_lines(&lines, &m.s.spectra[0]);
    lines_next(&lines, "v2", "mean", 3, 1.125, 1.5, 1.375);
    lines_next(&lines, "lines at multiples of omega, bins every omega/1", NULL, 0);
    lines_next(&lines, "highest trustworthy", NULL, -1);
    check_lines(&lines, &m.s.spectra[1]);
    lines_end(&lines);

    /* Fewer than ten lines, without faint ones; none; trust not examined. */
    m.s.spectra[0].trustworthy = 2;
    m.lines[0][1].decibels = -221;
    m.s.spectra[1].trustworthy = 0.25;
    write_spectra(&m, &s, &lines);
    skip_to(&lines, "highest");
    lines_next(&lines, "highest", NULL, 3, 2., 1., 20.);
    check_lines(&lines, &m.s.spectra[0]);
    skip_to(&lines, "highest");
    lines_next(&lines, "highest", NULL, 3, 0.25, 1., 20.);
    lines_next(&lines, "no line below that frequency", NULL, 0);
    lines_end(&lines);

    make_spectra(&m, SALTUS_SPECTRUM_WELCH);
    m.s.spectra[1].line_count = 0;
    m.s.spectra[1].trustworthy = NAN;
    write_spectra(&m, &s, &lines);
    lines_next(&lines, "analysed", "7 segments of 24 T", 4, 96., 40., 7., 24.);
    lines_next(&lines, "displacement", "mean", 3, 0.125, 0.5, 0.375);
    lines_next(&lines, "resolution omega/24; ", NULL, 4, 12.5, 75., 10 * log10(0.25), 10 * log10(4));
    lines_next(&lines, "highest trustworthy", NULL, 3, 4.5, 1., 20.);
    check_lines(&lines, &m.s.spectra[0]);
    lines_next(&lines, "v2", "mean", -1);
    lines_next(&lines, "resolution", NULL, -1);
    lines_next(&lines, "aliasing was not looked at", NULL, 0);
    lines_next(&lines, "no line stands out", NULL, 0);
    lines_end(&lines);

    /* A quantity at rest has only its mean; the method is given for moving ones. */
    m.s.spectra[0].kind = SALTUS_SPECTRUM_CONSTANT;
    m.s.spectra[1].segments = 1;
    write_spectra(&m, &s, &lines);
    lines_next(&lines, "analysed", "1 segment of", -1);
    lines_next(&lines, "displacement", "does not move", 1, 0.125);
    lines_next(&lines, "v2", "mean", -1);
    free(lines.text);
    m.s.spectra[1].kind = SALTUS_SPECTRUM_CONSTANT;
    write_spectra(&m, &s, &lines);
    lines_next(&lines, "analysed", NULL, 2, 96., 40.);
    lines_next(&lines, "displacement", "does not move", 1, 0.125);
    lines_next(&lines, "v2", "does not move", 1, 1.125);
    lines_end(&lines);
    saltus_system_free(s.system);
}

/* Numbers of a CSV row by the header's names; moves to the next row. */
static double cell(const char *header, const char *row, const char *name) {
    const char *at = row;
    for (const char *c = header; *c && *c != '\n';) {
        size_t length = strcspn(c, ",\n");
        if (strlen(name) == length && strncmp(c, name, length) == 0)
            return strtod(at, NULL);
        c += length + (c[length] == ',');
        at += strcspn(at, ",\n");
        at += *at == ',';
    }
    fail_msg("there is no column %s", name);
    return NAN;
}

static void spectra_are_the_same_in_every_format(void **state) {
    (void)state;
    setting s;
    made_spectra m;
    saltus_message message;
    saltus_flow_options flow = saltus_flow_defaults();
    char folder[] = "/tmp/saltus-test-XXXXXX", path[64], name[48];
    make(&s, 1);
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/s.csv", folder);
    for (int welch = 0; welch < 2; welch++)
        for (int still = 0; still < 4; still++) {
            make_spectra(&m, welch ? SALTUS_SPECTRUM_WELCH : SALTUS_SPECTRUM_LINES);
            for (int q = 0; q < 2; q++)
                if (still >> q & 1)
                    m.s.spectra[q].kind = SALTUS_SPECTRUM_CONSTANT;
            check_ok(
                saltus_write_spectra(path, &s.scene, s.system, &flow, &made_motion, &m.s, NULL, &message),
                &message);
            size_t length;
            char *csv = read_all(path, &length);
            const char *row = strstr(csv, "frequency_over_omega,");
            row = strstr(csv, "\nharmonic,frequency_over_omega");
            row = row ? row : strstr(csv, "\nfrequency_over_omega");
            assert_non_null(row);
            const char *header = ++row;
            assert_int_equal(strncmp(header, "harmonic", 8) == 0, !welch && still < 3);
            int rows = still == 3 ? 0 : welch ? bins : line_count;
            static const char *const names[] = {"displacement", "v2"};
            row = strchr(row, '\n') + 1;
            for (int k = 0; k < rows; k++, row = strchr(row, '\n') + 1) {
                const saltus_spectrum *any = &m.s.spectra[still == 1];
                check_near(cell(header, row, "frequency_over_omega"),
                           welch ? k * any->resolution : any->lines[k].frequency, 1e-15);
                if (!welch)
                    assert_true(cell(header, row, "harmonic") == k + 1);
                for (int q = 0; q < 2; q++) {
                    const saltus_spectrum *p = &m.s.spectra[q];
                    snprintf(name, sizeof name, "%s_", names[q]);
                    const char *column = strstr(header, name);
                    assert_int_equal(column && column < strchr(header, '\n'),
                                     p->kind != SALTUS_SPECTRUM_CONSTANT);
                    if (p->kind == SALTUS_SPECTRUM_CONSTANT)
                        continue;
                    const double lines[] = {p->lines[k].amplitude, p->lines[k].phase, p->lines[k].decibels},
                                 densities[] = {p->density[k % bins], p->low * p->density[k % bins],
                                                p->high * p->density[k % bins],
                                                10 * log10(p->density[k % bins] / (9. + q))};
                    static const char *const columns[2][4] = {{"amplitude", "phase", "dB"},
                                                              {"psd", "psd_low", "psd_high", "dB"}};
                    for (int c = 0; c < 3 + welch; c++) {
                        snprintf(name, sizeof name, "%s_%s", names[q], columns[welch][c]);
                        check_near(cell(header, row, name), welch ? densities[c] : lines[c], 1e-14);
                    }
                }
            }
            assert_int_equal(*row, 0);

            text_lines text;
            lines_open(&text);
            saltus_write_spectra_json(text.stream, &s.scene, s.system, &made_motion, &m.s);
            lines_read(&text);
            json *o = json_read(text.text);
            assert_true(json_number_at(o, "periods") == m.s.periods &&
                        json_number_at(o, "analysed_periods") == 96 &&
                        json_number_at(o, "samples_per_period") == 40);
            for (int q = 0; q < 2; q++) {
                const saltus_spectrum *p = &m.s.spectra[q];
                bool moves = p->kind != SALTUS_SPECTRUM_CONSTANT, lines = p->kind == SALTUS_SPECTRUM_LINES,
                     dense = p->kind == SALTUS_SPECTRUM_WELCH;
                const struct {
                    const char *key;
                    bool there;
                    double value;
                } member[] = {{"mean", true, p->mean},
                              {"total_power", true, p->variance},
                              {"broadband_fraction", moves, p->broadband},
                              {"highest_trustworthy", moves, p->trustworthy},
                              {"resolution", moves, p->resolution},
                              {"parseval", moves, p->parseval},
                              {"orbits", lines, p->orbits},
                              {"between_lines", lines, p->between},
                              {"segments", dense, (double)p->segments},
                              {"segment_periods", dense, (double)p->segment_periods},
                              {"degrees_of_freedom", dense, p->degrees},
                              {"confidence", dense, p->confidence},
                              {"band_low", dense, p->low},
                              {"band_high", dense, p->high}};
                snprintf(name, sizeof name, "spectra.%d", q);
                const json *one = json_at(o, name);
                assert_string_equal(json_text_at(one, "quantity"), names[q]);
                assert_string_equal(json_text_at(one, "kind"), lines   ? "lines"
                                                               : dense ? "density"
                                                                       : "constant");
                for (size_t k = 0; k < sizeof member / sizeof member[0]; k++) {
                    assert_int_equal(json_find(one, member[k].key) != NULL, member[k].there);
                    if (member[k].there)
                        assert_true(json_number_at(one, member[k].key) == member[k].value);
                }
                /* Lines up to and including the trusted frequency, and beyond. */
                assert_int_equal(json_count(json_at(one, "lines")), 13);
                for (int k = 0; k < 13; k++) {
                    snprintf(name, sizeof name, "lines.%d", k);
                    const json *line = json_at(one, name);
                    const saltus_spectral_line *l = &p->lines[k];
                    assert_int_equal(json_find(line, "harmonic") != NULL, l->harmonic != 0);
                    assert_true(!l->harmonic || json_number_at(line, "harmonic") == (double)l->harmonic);
                    assert_true(json_number_at(line, "frequency_over_omega") == l->frequency &&
                                json_number_at(line, "amplitude") == l->amplitude &&
                                json_number_at(line, "phase") == l->phase &&
                                json_number_at(line, "decibels") == l->decibels &&
                                json_number_at(line, "share") == l->share);
                }
            }
            json_free(o);
            free(text.text);

            /* The head of the table. */
            for (int q = 0; q < 2; q++) {
                const saltus_spectrum *p = &m.s.spectra[q];
                char head[64];
                snprintf(head, sizeof head, "# %s: mean = ", names[q]);
                text_lines csv_lines = {.text = csv, .at = strstr(csv, head)};
                assert_non_null(csv_lines.at);
                if (p->kind == SALTUS_SPECTRUM_CONSTANT) {
                    lines_next(&csv_lines, head, "does not move", 2, p->mean, p->variance);
                    continue;
                }
                lines_next(&csv_lines, head, NULL, 3, p->mean, p->variance, p->broadband);
                snprintf(head, sizeof head, "# %s: highest", names[q]);
                if (!welch)
                    lines_next(&csv_lines, head, NULL, 3, p->trustworthy, 1., p->between);
                else {
                    lines_next(&csv_lines, head, NULL, 4, p->trustworthy, 1., p->degrees, p->confidence);
                    snprintf(head, sizeof head, "# %s line:", names[q]);
                    for (int k = 0; k < line_count; k++)
                        lines_next(&csv_lines, head, NULL, 4, p->lines[k].frequency, p->lines[k].amplitude,
                                   p->lines[k].phase, p->lines[k].share);
                }
            }
            free(csv);
        }
    folder_files(folder, true);
    rmdir(folder);
    saltus_system_free(s.system);
}

/* Another file ending is refused, and a failed write leaves nothing. */
static void spectra_go_where_they_can(void **state) {
    (void)state;
    static const struct {
        const char *name;
        saltus_status status;
    } rows[] = {{"s.txt", SALTUS_BAD_INPUT},     {"s", SALTUS_BAD_INPUT},      {"csv", SALTUS_BAD_INPUT},
                {"missing/s.csv", SALTUS_IO},    {"missing/s.svg", SALTUS_IO}, {"s.csv", SALTUS_OK},
                {"s.csv/inside.csv", SALTUS_IO}, {"s.h5", SALTUS_BAD_INPUT}};
    setting s;
    made_spectra m;
    saltus_flow_options flow = saltus_flow_defaults();
    char folder[] = "/tmp/saltus-test-XXXXXX", path[96];
    make(&s, 1);
    make_spectra(&m, SALTUS_SPECTRUM_LINES);
    assert_non_null(mkdtemp(folder));
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_message message = {.text = ""};
        snprintf(path, sizeof path, "%s/%s", folder, rows[k].name);
        saltus_status status =
            saltus_write_spectra(path, &s.scene, s.system, &flow, &made_motion, &m.s, NULL, &message);
        assert_int_equal(status, rows[k].status);
        assert_int_equal(message.text[0] != 0, status != SALTUS_OK);
    }
    assert_int_equal(folder_files(folder, true), 1);
    assert_int_equal(rmdir(folder), 0);
    saltus_system_free(s.system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rests_are_told),
        cmocka_unit_test(exponents_are_told),
        cmocka_unit_test(spectra_are_told),
        cmocka_unit_test(spectra_are_the_same_in_every_format),
        cmocka_unit_test(spectra_go_where_they_can),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
