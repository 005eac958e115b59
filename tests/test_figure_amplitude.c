/* Diagrams of unforced scenes: equilibria, and the largest and smallest displacement of cycles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "figure_folder.h"

#include "saltus/scene.h"

/* How many points of lines with one style are near a place. */
static int drawn_at(const figure_panel *panel, const char *look, double x, double y) {
    int count = 0;
    for (int e = 0; e < panel->element_count; e++) {
        const figure_element *line = &panel->element[e];
        for (int k = 0; k < line->values.count && strstr(line->style, "lines") && strstr(line->style, look);
             k++)
            count += hypot(line->values.at[k][0] - x, line->values.at[k][1] - y) < 1e-7;
    }
    return count;
}

/* An equilibrium at 0 loses its stability to cycles that are mirror symmetric: the equilibrium is drawn once,
 * solid and dashed, each cycle at its highest maximum and at minus that, also if there are two files. */
static void cycles_have_two_extremes_and_rests_one(void **state) {
    static const char text[] = "model:\n  parameters: {mu: {default: -0.2}}\n"
                               "  motion: {x: mu*x' - x^2*x' - x}\n";
    saltus_message message = {.text = ""};
    saltus_scene scene;
    saltus_branch_options options = branch_along("mu", -0.2, 0.3);
    saltus_branch_output *output = NULL;
    const double rest[2] = {0};
    const char *paths[2];
    char path[2][path_size], drawing[path_size];
    (void)state;
    options.direction = 1;
    options.switches = 1;
    check_ok(saltus_scene_parse(text, sizeof text - 1, "test", &scene, &message), &message);
    branch_record record = branch_run(&scene.spec, 0, rest, &options);
    for (int file = 0; file < 2; file++) {
        paths[file] = path_in(file ? "c.h5" : "b.h5", path[file]);
        check_ok(saltus_branch_output_open(paths[file], &scene, 0, rest, &options, NULL, &output, &message),
                 &message);
        for (int k = 0; k < record.count; k++)
            check_ok(saltus_branch_output_add(output, &record.point[k], &message), &message);
        check_ok(saltus_branch_output_close(output, true, &message), &message);
    }
    const saltus_plot_options how = saltus_plot_defaults();
    for (int files = 1; files <= 2; files++) {
        check_ok(saltus_plot(path_in("b.svg", drawing), paths, files, &how, &message), &message);
        figure f = figure_taken(folder);
        const figure_panel *panel = &f.panel[0];
        int cycles = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            const double mu = p->value[0], x = p->state[0];
            if (p->kind != SALTUS_POINT_REGULAR)
                continue;
            cycles += p->periods > 0;
            if (p->periods) {
                assert_true(drawn_at(panel, "lw 2.6", mu, x) > 0 && drawn_at(panel, "lw 2.6", mu, -x) > 0);
                assert_int_equal(drawn_at(panel, "dt (9,6)", mu, x), 0);
            } else {
                assert_true(drawn_at(panel, mu < 0 ? "lw 2.6" : "dt (9,6)", mu, 0) > 0);
                assert_int_equal(drawn_at(panel, mu < 0 ? "dt (9,6)" : "lw 2.6", mu, 0), 0);
            }
        }
        assert_true(cycles > 50);
        assert_non_null(figure_element_of(panel, "HB  Hopf", 0));
        figure_free(&f);
    }
    branch_forget(&record);
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(cycles_have_two_extremes_and_rests_one, open_folder, close_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
