/* Whatever stands in the texts of a scene or a file, a figure shows it as it stands: it is neither a command
 * of the script nor markup.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "made_record.h"
#include "made_sweep.h"

#include "figure/caption.h"

static const char *const hostile[] = {"x'\nsystem 'touch /tmp/saltus-was-here'\na='y",
                                      "`touch /tmp/saltus-was-here`",
                                      "'",
                                      "''",
                                      "'''\n'",
                                      "it's {made",
                                      "}}}{{{",
                                      "a_b^c@d&e~f\\g",
                                      "\\",
                                      "\\'",
                                      "\\\\'; exit error 'x' #",
                                      "\"\n!touch /tmp/saltus-was-here\n\"",
                                      "%s%n%d $1 @Trace # comment \\",
                                      "{/:Bold x} {/=99 y} _{z}",
                                      "\r\n\t\v\x01\x7f",
                                      "\xff\xfe \xe2\x88 \xc0\xaf' \xed\xa0\x80",
                                      "EOD\nset output '/tmp/saltus-was-here'\n",
                                      "μ ± ½ 测试"};
enum { texts = sizeof hostile / sizeof hostile[0] };

/* Check that the string in single quotes at `at` ends on its line and is whole letters with balanced braces;
 * returns what follows it. */
static const char *check_string(const char *at) {
    int depth = 0;
    for (at++; *at != '\'' || at[1] == '\''; at++) {
        if ((unsigned char)*at < 0x20 || *at == 0x7f)
            fail_msg("a control character is in a string: %.80s", at);
        if (*at == '\'') {
            at++;
            continue;
        }
        if (*at == '\\') {
            at++;
            assert_true(*at && (*at != '\'' || at[1] == '\''));
            at += *at == '\'';
        } else
            depth += *at == '{' ? 1 : *at == '}' ? -1 : 0;
        assert_true(depth >= 0);
    }
    assert_int_equal(depth, 0);
    return at + 1;
}

/* Check that a script consists of the commands that figures use and of nothing else. */
static void check_script(const char *script, size_t length) {
    static const char *const words[] = {"set ", "unset ", "plot ", "if (", "}", "#", "cut(x) = "};
    for (const char *line = script; line < script + length;) {
        bool known = *line >= 'A' && *line <= 'Z' && strstr(line, " = ");
        if (*line == '$') {
            line = strstr(line, "\nEOD\n");
            assert_non_null(line);
            line += 5;
            continue;
        }
        for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
            known = known || figure_begins(line, words[k]);
        if (!known)
            fail_msg("no command of a figure: %.80s", line);
        size_t pixels = 0;
        for (; *line != '\n'; line++) {
            int width, height;
            if (*line == '"' || *line == '`')
                line = *line == '"' ? strchr(line + 1, '"') : NULL;
            assert_non_null(line);
            if (figure_begins(line, "binary array=(") &&
                sscanf(line, "binary array=(%d,%d)", &width, &height) == 2)
                pixels += 4 * (size_t)width * (size_t)height;
            if (*line == '\'')
                line = check_string(line) - 1;
            else if (*line == '\\' && line[1] == '\n')
                line++;
        }
        line += 1 + pixels;
    }
}

static void check_drawn(void) {
    char path[path_size];
    size_t length;
    char *script = read_all(path_in("script", path), &length);
    check_script(script, length);
    free(script);
    figure f = figure_taken(folder);
    assert_true(f.panel_count > 0);
    figure_free(&f);
}

/* A model whose parameters are explained by a text, which it also has as its title. */
static saltus_scene scene_with(const char *text) {
    char yaml[2000] = "", quoted[600] = "";
    saltus_scene scene;
    saltus_message message = {.text = ""};
    for (const char *c = text; *c; c++)
        if ((unsigned char)*c < 0x80) /* what is no UTF-8 is no YAML */
            snprintf(quoted + strlen(quoted), sizeof quoted - strlen(quoted), "\\x%02x", (unsigned char)*c);
    snprintf(
        yaml, sizeof yaml,
        "model:\n  parameters: {c: {default: 0.2, meaning: \"%s\"}, omega: {default: 1.2, min: 0.1, meaning: "
        "\"%s\"}}\n  motion: {x: \"-c*x' - x + cos(omega*t)\"}\n  forcing: omega\n"
        "stop: {coordinate: x, d: 1.3, r: 0.8}\n",
        quoted, quoted);
    check_ok(saltus_scene_parse(yaml, strlen(yaml), "text", &scene, &message), &message);
    snprintf(scene.title, sizeof scene.title, "%s", text);
    snprintf(scene.name, sizeof scene.name, "%s", text);
    return scene;
}

static void fill(made_place *m) {
    for (int s = 0; s < m->seeds; s++) {
        m->row[s] = made_periodic((int)(m->point % 3), 1 + (int)(m->point % 2));
        m->row[s].settled = 3;
    }
}

static void draw_sweeps(const saltus_scene *scene, saltus_figure_options look) {
    static const double omega[] = {1, 1.1, 1.2, 1.3}, c[] = {0.1, 0.2, 0.3};
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    saltus_axis axes[2] = {{.key = "omega", .list = (double *)omega, .count = 4},
                           {.key = "c", .list = (double *)c, .count = 3}};
    saltus_sweep_options options = saltus_sweep_defaults();
    for (int count = 1; count <= 2; count++)
        for (int numbers = 0; numbers < count; numbers++) {
            const saltus_sweep_view how = {.view = numbers ? SALTUS_VIEW_LARGEST : SALTUS_VIEW_CLASS,
                                           .look = look};
            if (!numbers)
                made_write(path_in("s.h5", path), scene, axes, count, &options, fill, 100);
            check_ok(saltus_plot_sweep(path_in("s.svg", out), path, &how, &message), &message);
            check_drawn();
        }
}

static void draw_branches(const saltus_scene *scene, saltus_figure_options look, const char *text) {
    enum { rows = 12 };
    saltus_message message = {.text = ""};
    saltus_branch_options options = saltus_branch_defaults();
    saltus_branch_output *output = NULL;
    char path[path_size], out[path_size];
    double state[2] = {0.5, 0.25};
    saltus_multiplier multipliers[2] = {{0.5, 0, log(0.5)}, {0.25, 0, log(0.25)}};
    strcpy(options.key[0], "omega");
    options.low[0] = 1;
    options.high[0] = 2;
    check_ok(
        saltus_branch_output_open(path_in("b.h5", path), scene, 1, state, &options, NULL, &output, &message),
        &message);
    for (int k = 0; k < rows; k++) {
        saltus_branch_point p = {.parent = -1,
                                 .step = k,
                                 .arclength = k,
                                 .kind = k == 6 ? SALTUS_POINT_LP : SALTUS_POINT_REGULAR,
                                 .value = {1 + 0.05 * k, NAN},
                                 .heading = 1,
                                 .spec = scene->spec,
                                 .periods = 1,
                                 .dimension = 2,
                                 .multiplier_count = 2,
                                 .state = state,
                                 .multipliers = multipliers,
                                 .stable = true,
                                 .admissible = true,
                                 .sum_rule = NAN,
                                 .grazing_time = NAN,
                                 .contact_force = NAN};
        set_parameter(&p.spec, "omega", p.value[0]);
        state[0] = 0.5 + 0.01 * k;
        snprintf(p.label, sizeof p.label, "%s", text);
        check_ok(saltus_branch_output_add(output, &p, &message), &message);
    }
    check_ok(saltus_branch_output_close(output, true, &message), &message);
    saltus_plot_options how = saltus_plot_defaults();
    how.look = look;
    for (int files = 1; files <= 2; files++) {
        check_ok(
            saltus_plot(path_in("b.svg", out), (const char *const[2]){path, path}, files, &how, &message),
            &message);
        check_drawn();
    }
}

static void draw_motions(const saltus_scene *scene, saltus_figure_options look) {
    static made_up m;
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    saltus_system *system = build(&scene->spec);
    const saltus_flow_options flow = saltus_flow_defaults();
    saltus_motion motion = irregular();
    make_record(&m, system, 2, NULL, 0);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &m.record};
    snprintf(motion.reason, sizeof motion.reason, "%s", scene->title);
    check_ok(
        saltus_write_sheet(path_in("d.svg", out), scene, system, &flow, &diagnosis, &look, NULL, &message),
        &message);
    check_drawn();
    check_ok(saltus_write_trajectory(path_in("t.h5", path), scene, system, &flow, &m.record, NULL, &message),
             &message);
    check_ok(saltus_plot_trajectory(out, path, &look, &message), &message);
    check_drawn();
    saltus_system_free(system);
}

static void texts_are_no_commands(void **state) {
    (void)state;
    for (int k = 0; k < texts; k++) {
        saltus_scene scene = scene_with(hostile[k]);
        saltus_figure_options look = {.width = k % 2 ? 85 : 0, .title = k % 2 ? hostile[k] : NULL};
        draw_sweeps(&scene, look);
        draw_branches(&scene, look, hostile[k]);
        draw_motions(&scene, look);
        saltus_scene_clear(&scene);
    }
}

/* What gnuplot shows of a string: quotes and escapes taken off. */
static void read_back(FILE *file, char *shown, size_t room) {
    char string[6000] = "";
    size_t used = 0;
    rewind(file);
    size_t length = fread(string, 1, sizeof string - 1, file);
    assert_ptr_equal(check_string(string), string + length);
    for (const char *c = string + 1; c < string + length - 1 && used + 1 < room; c++) {
        c += *c == '\\';
        c += *c == '\'';
        shown[used++] = *c;
    }
    shown[used] = '\0';
}

/* Every letter is shown, whatever it is, and control characters as blanks. */
static void texts_are_shown_as_they_stand(void **state) {
    (void)state;
    unsigned long random = 1;
    for (int k = 0; k < 3000; k++) {
        static const char letters[] = "'\\{}_^@&~ab \"`$%#\n\xc2\xb1\xe2\x88\x9e\x01";
        char text[64] = "", shown[400];
        for (int n = 0; n < k % 40; n++) {
            random = random * 6364136223846793005UL + 1442695040888963407UL;
            text[n] = letters[(random >> 40) % (sizeof letters - 1)];
        }
        FILE *file = tmpfile();
        saltus_line line = {.length = 0};
        saltus_line_plain(&line, text);
        saltus_put_quoted(file, line.text, line.length);
        read_back(file, shown, sizeof shown);
        fclose(file);
        const char *s = shown;
        for (const char *c = text; *c; c++) {
            const unsigned char own = (unsigned char)*c;
            if (own < 0x80)
                for (s += *s && (unsigned char)*s >= 0x80 ? strcspn(s, " !\"#$%&'@\\^_`ab{}~") : 0;
                     *s != (own < 0x20 ? ' ' : *c);)
                    fail_msg("of '%s' only '%s' is shown", text, shown);
            s += own < 0x80;
        }
        /* Markup that was not escaped cannot break the script either. */
        file = tmpfile();
        saltus_put_quoted(file, text, strlen(text));
        read_back(file, shown, sizeof shown);
        fclose(file);
    }
}

/* Texts are as wide as DejaVu Sans makes them, whatever markup they have, and are broken into lines that fit
 * and together are the text. */
static void lines_are_filled(void **state) {
    (void)state;
    assert_float_equal(saltus_line_width("periodic orbits in x"), 9.31, 0.005);
    assert_float_equal(saltus_line_width("{/:Bold MMMM}"), saltus_line_width("MMMM"), 1e-12);
    assert_true(saltus_line_width("MMMM") > 3 * saltus_line_width("llll"));
    assert_float_equal(saltus_line_width("a\\_b"), saltus_line_width("a") + saltus_line_width("b") + 0.5,
                       1e-9);
    assert_float_equal(saltus_line_width("{/:Italic ω}_{12}"), 0.84 + 2 * 0.64, 1e-9);
    static const char text[] = "pipe: {/:Italic N} = 5, {/:Italic α} = 0.005, {/:Italic u}_{0} = 4.5;  stop: "
                               "{/:Italic ξ} = 0.5, {/:Italic d} = 0.035, upper, some words {/:Italic η}(½, "
                               "{/:Italic τ}) and 0.5 ± 0.25 more";
    for (double width = 6; width < 80; width += 0.7) {
        const char *rest = text;
        while (*rest) {
            const size_t length = saltus_line_piece(rest, width);
            char piece[sizeof text];
            snprintf(piece, sizeof piece, "%.*s", (int)length, rest);
            assert_true(length > 0 && saltus_line_width(piece) <= width);
            assert_true((strchr(piece, '(') != NULL) == (strchr(piece, ')') != NULL));
            assert_true((strstr(piece, "0.5 ±") != NULL) == (strstr(piece, "± 0.25") != NULL));
            rest += length;
            rest += strspn(rest, " ");
        }
        const char *first = text + saltus_line_piece(text, width);
        assert_true(!*first || *first == ' ');
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(texts_are_no_commands),
                                       cmocka_unit_test(lines_are_filled),
                                       cmocka_unit_test(texts_are_shown_as_they_stand)};
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
