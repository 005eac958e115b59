/* Bifurcation diagrams draw the rows of branch files: curves solid if stable and dashed if not, special
 * points with the marks of the legend, n/p on stretches of that motion. The branches are made up, so that
 * every kind of point occurs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"
#include "figure_folder.h"
#include "made_sweep.h"

enum { points = 90, dimension = 2, events_most = 3 };

/* A branch file being made; each test changes what it is about. */
typedef struct made_branch {
    saltus_scene scene;
    saltus_branch_options options;
    saltus_branch_point point[points];
    double state[points][dimension];
    saltus_event event[points][events_most];
    saltus_multiplier multiplier[points][dimension];
} made_branch;

static made_branch made;

/* An arc that leaves from omega = 1 and turns back near 2, so that it is no function of omega. */
static double omega_at(int k) {
    double t = (k % 30) / 29.0;
    return k < 60 ? 1 + (k < 30 ? 1 : 0.7) * sin(2.2 * t) : 1.2 + 0.02 * (k - 60);
}

/* Three branches of thirty points: 0 up, 1 down, 2 switched to from 0. Motions, stability and special points
 * change at different places. */
static void make_branch(void) {
    made = (made_branch){.scene = {.spec = oscillator_spec(0.125, 1.75, 1.5, 1)},
                         .options = saltus_branch_defaults()};
    add_stop(&made.scene.spec, 0.25, 0.75, SALTUS_BOTH);
    strcpy(made.scene.name, "made_up");
    strcpy(made.options.key[0], "omega");
    made.options.low[0] = 1;
    made.options.high[0] = 3;
    for (int k = 0; k < points; k++) {
        saltus_branch_point *p = &made.point[k];
        *p = (saltus_branch_point){.branch = k / 30,
                                   .parent = k < 60 ? -1 : 0,
                                   .step = k % 30,
                                   .arclength = 0.1 * (k % 30),
                                   .value = {omega_at(k), NAN},
                                   .heading = 1,
                                   .spec = made.scene.spec,
                                   .periods = k < 60 ? 1 : 2,
                                   .impacts = 2,
                                   .dimension = dimension,
                                   .multiplier_count = dimension,
                                   .state = made.state[k],
                                   .events = made.event[k],
                                   .event_count = 2,
                                   .multipliers = made.multiplier[k],
                                   .stable = k % 30 < 12 || k % 30 > 20,
                                   .admissible = true,
                                   .sum_rule = NAN,
                                   .grazing_time = NAN,
                                   .contact_force = NAN};
        set_parameter(&p->spec, "omega", p->value[0]);
        snprintf(p->label, sizeof p->label, "%d/%d", 2 + (k % 30 > 15), p->periods);
        made.state[k][0] = 0.03 * cos(0.1 * k) + 0.1 * p->branch;
        made.state[k][1] = 0.5 + 0.02 * sin(0.13 * k);
        for (int e = 0; e < 2; e++)
            made.event[k][e] =
                (saltus_event){.kind = SALTUS_IMPACT,
                               .face = e,
                               .time = {0, 0.2 + 0.5 * e + 0.001 * (k % 30)},
                               .velocity_before = (e ? -1 : 1) * (0.6 + 0.3 * e + 0.01 * (k % 30)),
                               .velocity_after = (e ? 1 : -1) * 0.4,
                               .displacement = e ? -0.25 : 0.25};
        for (int i = 0; i < dimension; i++)
            made.multiplier[k][i] = (saltus_multiplier){0.5 - 0.25 * i, 0, log(0.5 - 0.25 * i)};
    }
}

static void write_branch(const char *name) {
    saltus_message message = {.text = ""};
    saltus_branch_output *output = NULL;
    char path[path_size];
    check_ok(saltus_branch_output_open(path_in(name, path), &made.scene, 1, made.state[0], &made.options,
                                       NULL, &output, &message),
             &message);
    for (int k = 0; k < points; k++)
        check_ok(saltus_branch_output_add(output, &made.point[k], &message), &message);
    check_ok(saltus_branch_output_close(output, true, &message), &message);
}

/* The legend has the rows it needs: eight short names per row, or five. */
static void check_rows_of_legend(const figure_panel *panel, int in_a_row) {
    int count = figure_titles(panel);
    assert_true(panel->key_rows * in_a_row >= count && (panel->key_rows - 1) * in_a_row < count);
}

static figure draw_files(const char *const *names, int count, const saltus_plot_options *how) {
    saltus_message message = {.text = ""};
    char path[4][path_size], out[path_size];
    const char *paths[4];
    for (int k = 0; k < count; k++)
        paths[k] = path_in(names[k], path[k]);
    check_ok(saltus_plot(path_in("b.svg", out), paths, count, how, &message), &message);
    return figure_taken(folder);
}

static figure draw(const saltus_plot_options *how) {
    const char *const names[] = {"b.h5"};
    return draw_files(names, 1, how);
}

/* The value of a point drawn upwards. */
static double height(saltus_show show, const saltus_branch_point *p) {
    double largest = 0, slowest = INFINITY;
    for (int e = 0; e < p->event_count; e++)
        if (p->events[e].kind == SALTUS_IMPACT || p->events[e].kind == SALTUS_STICK) {
            largest = fmax(largest, fabs(p->events[e].velocity_before));
            slowest = fmin(slowest, fabs(p->events[e].velocity_before));
        }
    return show == SALTUS_SHOW_DISPLACEMENT                            ? p->state[0]
           : show == SALTUS_SHOW_VELOCITY                              ? p->state[1]
           : show == SALTUS_SHOW_PERIOD                                ? p->periods
           : show == SALTUS_SHOW_IMPACTS && p->kind == SALTUS_POINT_GR ? (isfinite(slowest) ? slowest : 0)
                                                                       : largest;
}

enum { solid, dashed, dotted };

/* A line's style, as in the legend. */
static int stroke_of(const figure_panel *panel, const char *style) {
    const char *dash = strstr(style, " dt ");
    const figure_element *unstable = figure_element_of(panel, "'unstable'", 0);
    const char *word = unstable ? strstr(unstable->style, " dt ") : NULL;
    return !dash ? solid : word && strncmp(dash, word, 10) == 0 ? dashed : dotted;
}

/* Count the pieces of line between two places, by strokes. */
static void count_pieces(const figure_panel *panel, const double from[2], const double to[2], int pieces[3]) {
    pieces[solid] = pieces[dashed] = pieces[dotted] = 0;
    for (int e = 0; e < panel->element_count; e++) {
        const figure_element *line = &panel->element[e];
        if (!strstr(line->style, "with lines") || line->text[0] != '$')
            continue;
        for (int k = 0; k < line->values.count; k++) {
            const double *a = line->values.at[k];
            if (hypot(a[0] - from[0], a[1] - from[1]) >= 1e-7)
                continue;
            /* Rows of a smooth curve may lie between. */
            for (int j = k + 1; j < line->values.count && j <= k + 8 && line->values.joined[j]; j++) {
                const double *b = line->values.at[j];
                if (hypot(b[0] - to[0], b[1] - to[1]) >= 1e-7)
                    continue;
                pieces[stroke_of(panel, line->style)]++;
                break;
            }
        }
    }
}

/* Whether a horizontal place is that of a row of the file. */
static bool of_the_file(double x) {
    for (int k = 0; k < points; k++)
        if (fabs(made.point[k].value[0] - x) < 1e-9 || fabs(made.point[k].value[1] - x) < 1e-9)
            return true;
    return false;
}

/* Count all pieces drawn from row to row of the file. */
static int all_pieces(const figure_panel *panel) {
    int count = 0;
    for (int e = 0; e < panel->element_count; e++)
        for (int k = 1; k < panel->element[e].values.count && strstr(panel->element[e].style, "with lines");
             k++)
            count += panel->element[e].values.joined[k] && of_the_file(panel->element[e].values.at[k][0]);
    return count;
}

static bool tells(const saltus_branch_point *p) {
    return p->kind == SALTUS_POINT_REGULAR || p->kind == SALTUS_POINT_UZ || p->kind == SALTUS_POINT_EP;
}

/* A piece is as stable as both its points; where stability changes at a special point, as the other point. */
static int stroke_between(const saltus_branch_point *a, const saltus_branch_point *b) {
    bool both = tells(a) && tells(b);
    if (!a->admissible && !b->admissible)
        return dotted;
    return (both ? a->stable && b->stable : tells(a) ? a->stable : b->stable) ? solid : dashed;
}

static void check_curves(const figure *f, saltus_show show) {
    const figure_panel *panel = &f->panel[0];
    int expected = 0;
    for (int k = 1; k < points; k++) {
        const saltus_branch_point *a = &made.point[k - 1], *b = &made.point[k];
        const double from[2] = {a->value[0], height(show, a)}, to[2] = {b->value[0], height(show, b)};
        int pieces[3];
        if (a->branch != b->branch)
            continue;
        expected++;
        count_pieces(panel, from, to, pieces);
        for (int stroke = 0; stroke < 3; stroke++)
            if (pieces[stroke] != (stroke == stroke_between(a, b)))
                fail_msg("from point %d to the next there are %d pieces of stroke %d", k - 1, pieces[stroke],
                         stroke);
    }
    assert_int_equal(all_pieces(panel), expected);
}

/* Each measure, and each kind of line. */
static void curves_are_the_rows_of_the_file(void **state) {
    (void)state;
    static const char *const names[] = {[SALTUS_SHOW_AUTOMATIC] = "largest impact speed",
                                        [SALTUS_SHOW_SPEED] = "largest impact speed",
                                        [SALTUS_SHOW_DISPLACEMENT] =
                                            "displacement {/:Italic x}_1  at phase 0",
                                        [SALTUS_SHOW_VELOCITY] = "velocity d{/:Italic x}_1",
                                        [SALTUS_SHOW_PERIOD] = "period in"};
    make_branch();
    made.point[40].admissible = made.point[41].admissible = made.point[42].admissible = false;
    made.point[70].kind = SALTUS_POINT_UZ;
    made.point[72].kind = SALTUS_POINT_PD;
    made.point[72].stable = false;
    made.point[81].kind = SALTUS_POINT_LP;
    made.point[51].kind = SALTUS_POINT_GR;
    made.event[5][0].kind = SALTUS_STICK;
    made.event[6][1].kind = SALTUS_RELEASE;
    made.event[6][1].velocity_before = 5;
    write_branch("b.h5");
    for (saltus_show show = SALTUS_SHOW_AUTOMATIC; show <= SALTUS_SHOW_PERIOD; show++) {
        saltus_plot_options how = saltus_plot_defaults();
        how.show = show;
        if (show == SALTUS_SHOW_IMPACTS)
            continue;
        figure f = draw(&how);
        check_curves(&f, show);
        assert_true(strstr(f.panel[0].label[1], names[show]) == f.panel[0].label[1]);
        assert_non_null(strstr(f.panel[0].label[0], "{/:Italic ω}"));
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < points; k++) {
            low = fmin(low, height(show, &made.point[k]));
            high = fmax(high, height(show, &made.point[k]));
        }
        const double *x = f.panel[0].range[0], *y = f.panel[0].range[1];
        assert_true(x[0] < 1 && x[1] > 2 && x[1] - x[0] < 1.1);
        assert_true(y[0] < low && y[1] > high && y[1] - y[0] < 1.3 * (high - low));
        figure_says(&f, "made\\_up:  periodic orbits in {/:Italic ω}");
        figure_says(&f, "{/:Italic c} = 0.125");
        figure_says(&f, "stop: {/:Italic d} = 0.25, {/:Italic r} = 0.75, both sides");
        char text[8000];
        figure_caption(&f, text, sizeof text);
        assert_null(strstr(text, "{/:Italic ω} ="));
        figure_free(&f);
    }
    /* Without impacts the displacement is shown. */
    for (int k = 0; k < points; k++)
        made.point[k].event_count = 0;
    write_branch("b.h5");
    const saltus_plot_options usual = saltus_plot_defaults();
    figure f = draw(&usual);
    check_curves(&f, SALTUS_SHOW_DISPLACEMENT);
    figure_free(&f);
}

/* Every impact is its own curve, from its birth to its death. */
static void impacts_are_curves_of_their_own(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    /* The second impact exists for points 10 to 19 of branch 0 only, followed by one on another face; in
     * branch 1 it passes through phase 0, in branch 2 it jumps too far to be the same. */
    for (int k = 0; k < 10; k++)
        made.point[k].event_count = 1;
    for (int k = 20; k < 30; k++)
        made.event[k][1].face = 0;
    for (int k = 30; k < 60; k++) {
        double time = 0.9 + 0.008 * (k - 30);
        made.event[k][1].time.phase = time - floor(time);
    }
    for (int k = 70; k < 90; k++)
        made.event[k][1].time.phase -= 0.25;
    write_branch("b.h5");
    how.show = SALTUS_SHOW_IMPACTS;
    figure f = draw(&how);
    int expected = 0;
    for (int k = 1; k < points; k++) {
        const saltus_branch_point *a = &made.point[k - 1], *b = &made.point[k];
        if (a->branch != b->branch)
            continue;
        for (int e = 0; e < 2; e++) {
            bool both = e < a->event_count && e < b->event_count && k != 20 && k != 70;
            const double from[2] = {a->value[0], fabs(a->events[e].velocity_before)},
                         to[2] = {b->value[0], fabs(b->events[e].velocity_before)};
            int pieces[3];
            count_pieces(&f.panel[0], from, to, pieces);
            for (int stroke = 0; stroke < 3; stroke++)
                if (pieces[stroke] != ((e == 0 || both) && stroke == stroke_between(a, b)))
                    fail_msg("impact %d from point %d to the next: %d pieces of stroke %d", e, k - 1,
                             pieces[stroke], stroke);
            expected += e == 0 || both;
        }
    }
    assert_int_equal(all_pieces(&f.panel[0]), expected);
    assert_true(strstr(f.panel[0].label[1], "speed of every impact") == f.panel[0].label[1]);
    /* A slow impact gets room, too. */
    assert_true(f.panel[0].range[1][0] < 0.6 && f.panel[0].range[1][1] > 1.19);
    figure_free(&f);
}

/* Marks */

static const struct {
    const char *word, *meaning;
} kinds[SALTUS_POINT_CP] = {
    [SALTUS_POINT_LP] = {"LP", "fold"},         [SALTUS_POINT_PD] = {"PD", "flip"},
    [SALTUS_POINT_NS] = {"NS", "torus"},        [SALTUS_POINT_BP] = {"BP", "branch point"},
    [SALTUS_POINT_GR] = {"GR", "grazing"},      [SALTUS_POINT_CH] = {"CH", "chatter"},
    [SALTUS_POINT_ST] = {"ST", "sticking"},     [SALTUS_POINT_UZ] = {"UZ", "wanted"},
    [SALTUS_POINT_EP] = {"EP", "end"},          [SALTUS_POINT_HB] = {"HB", "Hopf"},
    [SALTUS_POINT_BE] = {"BE", "meets a stop"},
};

/* The legend's mark of a kind, as "pt N", or none. */
static bool mark_of(const figure_panel *panel, int kind, char mark[16]) {
    for (int e = 0; e < panel->element_count; e++) {
        const char *title = panel->element[e].title, *type = strstr(panel->element[e].style, " pt ");
        if (!type || strncmp(title, kinds[kind].word, 2) != 0 || !strstr(title, kinds[kind].meaning))
            continue;
        snprintf(mark, 16, "%.*s ", (int)strcspn(type + 4, " ") + 4, type);
        return true;
    }
    return false;
}

/* Marks of a kind near a place. */
static int count_marks(const figure_panel *panel, const char *mark, double x, double y) {
    int count = 0;
    for (int e = 0; e < panel->element_count; e++)
        for (int k = 0; k < panel->element[e].values.count && strstr(panel->element[e].style, mark) &&
                        !strstr(panel->element[e].style, "#ffffff");
             k++)
            count +=
                hypot(panel->element[e].values.at[k][0] - x, panel->element[e].values.at[k][1] - y) < 1e-7;
    return count;
}

/* A mark as its signs, "pt N " for each: in the legend, where those of codimension two are labels ... */
static void look_of(const figure_panel *panel, int kind, char look[40]) {
    look[0] = '\0';
    if (kind < SALTUS_POINT_CP) {
        char mark[16];
        assert_true(mark_of(panel, kind, mark));
        sprintf(look, "%s", strstr(mark, "pt "));
        return;
    }
    const figure_mark *name = NULL;
    for (int m = 0; m < panel->mark_count && !name; m++)
        if (panel->mark[m].system[0][0] == 's' &&
            strcmp(panel->mark[m].text, saltus_point_word((saltus_point_kind)kind)) == 0)
            name = &panel->mark[m];
    assert_true(name && name->place[0][1] > panel->frame[3]);
    for (int m = 0; m < panel->mark_count; m++) {
        const figure_mark *sign = &panel->mark[m];
        const double before = name->place[0][0] - sign->place[0][0];
        const char *type = strstr(sign->style, "pt ");
        if (sign->kind == 'l' && type && sign->place[0][1] == name->place[0][1] && before > 0 &&
            before < 0.02)
            sprintf(look + strlen(look), "%.*s ", (int)strcspn(type + 3, " ") + 3, type);
    }
}

/* ... and at a place of the panel. */
static void look_at(const figure_panel *panel, double x, double y, char look[40]) {
    look[0] = '\0';
    for (int e = 0; e < panel->element_count; e++) {
        const char *style = panel->element[e].style, *type = strstr(style, "pt ");
        for (int k = 0; k < panel->element[e].values.count && type && !strstr(style, "#ffffff"); k++)
            if (hypot(panel->element[e].values.at[k][0] - x, panel->element[e].values.at[k][1] - y) < 1e-7)
                sprintf(look + strlen(look), "%.*s ", (int)strcspn(type + 3, " ") + 3, type);
    }
}

/* Every kind of special point is at its row's place, with the legend's mark; ends on the border of the range
 * have none. */
static void special_points_are_marked_at_their_rows(void **state) {
    (void)state;
    for (int show = SALTUS_SHOW_SPEED; show <= SALTUS_SHOW_IMPACTS; show++) {
        saltus_plot_options how = saltus_plot_defaults();
        char used[SALTUS_POINT_KINDS][40], look[40];
        how.show = (saltus_show)show;
        make_branch();
        for (int kind = SALTUS_POINT_LP; kind < SALTUS_POINT_EP; kind++)
            for (int b = 0; b < 2; b++)
                made.point[3 * kind + 30 * b].kind = (saltus_point_kind)kind;
        for (int kind = SALTUS_POINT_CP; kind < SALTUS_POINT_KINDS; kind++)
            made.point[kind + 21].kind = (saltus_point_kind)kind;
        made.point[50].kind = SALTUS_POINT_HB;
        made.point[51].kind = SALTUS_POINT_BE;
        made.point[89].kind = made.point[60].kind = SALTUS_POINT_EP;
        made.options.low[0] = made.point[60].value[0];
        write_branch("b.h5");
        figure f = draw(&how);
        const figure_panel *panel = &f.panel[0];
        used[SALTUS_POINT_REGULAR][0] = '\0';
        for (int kind = SALTUS_POINT_LP; kind < SALTUS_POINT_KINDS; kind++) {
            look_of(panel, kind, used[kind]);
            for (int j = SALTUS_POINT_REGULAR; j < kind; j++)
                assert_string_not_equal(used[kind], used[j]);
        }
        for (int k = 0; k < points; k++) {
            const saltus_branch_point *p = &made.point[k];
            look_at(panel, p->value[0], height(how.show, p), look);
            assert_string_equal(look, used[k == 60 ? SALTUS_POINT_REGULAR : p->kind]);
        }
        figure_free(&f);
    }
}

/* The legend explains exactly what is shown. */
static void the_legend_explains_what_there_is(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    saltus_plot_part part = {"omega", 1.2, 1.9};
    char mark[16];
    make_branch();
    made.point[70].kind = SALTUS_POINT_PD; /* omega = 1.4 */
    made.point[1].kind = SALTUS_POINT_BP;  /* omega = 1.08 */
    made.point[15].kind = SALTUS_POINT_NS; /* omega = 1.91 */
    write_branch("b.h5");
    for (int k = 0; k < 2; k++) {
        how.parts = &part;
        how.part_count = k;
        figure f = draw(&how);
        assert_true(mark_of(&f.panel[0], SALTUS_POINT_PD, mark));
        assert_true(mark_of(&f.panel[0], SALTUS_POINT_BP, mark) == !k);
        assert_true(mark_of(&f.panel[0], SALTUS_POINT_NS, mark) == !k);
        assert_false(mark_of(&f.panel[0], SALTUS_POINT_EP, mark));
        check_rows_of_legend(&f.panel[0], 8);
        assert_non_null(figure_element_of(&f.panel[0], "title 'stable'", 0));
        assert_non_null(figure_element_of(&f.panel[0], "title 'unstable'", 0));
        const double *x = f.panel[0].range[0], *y = f.panel[0].range[1];
        double low = INFINITY, high = -INFINITY;
        for (int p = 0; p < points && k; p++)
            if (made.point[p].value[0] >= 1.2 && made.point[p].value[0] <= 1.9) {
                low = fmin(low, height(SALTUS_SHOW_SPEED, &made.point[p]));
                high = fmax(high, height(SALTUS_SHOW_SPEED, &made.point[p]));
            }
        if (k)
            assert_true(x[0] == 1.2 && x[1] == 1.9 && y[0] < low && y[1] > high &&
                        y[1] - y[0] < 1.2 * (high - low));
        figure_free(&f);
    }
    saltus_message message;
    char path[path_size], out[path_size];
    const char *paths[] = {path_in("b.h5", path)};
    part = (saltus_plot_part){"omega", 2.2, 2.4};
    assert_int_equal(saltus_plot(path_in("b.svg", out), paths, 1, &how, &message), SALTUS_BAD_INPUT);
    part = (saltus_plot_part){"d", 0.2, 2.4};
    assert_int_equal(saltus_plot(path_in("b.svg", out), paths, 1, &how, &message), SALTUS_BAD_INPUT);
}

/* A label's place in the axes' numbers. */
static void place_of(const figure_panel *panel, const figure_mark *label, double place[2]) {
    for (int i = 0; i < 2; i++) {
        assert_int_equal(label->system[0][i], 'g');
        place[i] = panel->range[i][0] + label->place[0][i] * (panel->range[i][1] - panel->range[i][0]);
    }
}

/* n/p is on a point of a stretch of that motion, and no label is on another. */
static void names_stand_on_their_stretches(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    made.point[70].kind = SALTUS_POINT_PD;
    made.point[5].kind = SALTUS_POINT_LP;
    write_branch("b.h5");
    how.show = SALTUS_SHOW_DISPLACEMENT;
    figure f = draw(&how);
    const figure_panel *panel = &f.panel[0];
    int names = 0, words = 0;
    bool named[3] = {false};
    for (int m = 0; m < panel->mark_count; m++) {
        const figure_mark *label = &panel->mark[m];
        double at[2], near = INFINITY;
        if (label->kind != 'l' || label->system[0][0] != 'g')
            continue;
        place_of(panel, label, at);
        int nearest = 0;
        for (int k = 0; k < points; k++) {
            double away = hypot((made.point[k].value[0] - at[0]) / (panel->range[0][1] - panel->range[0][0]),
                                (made.state[k][0] - at[1]) / (panel->range[1][1] - panel->range[1][0]));
            if (away < near) {
                near = away;
                nearest = k;
            }
        }
        if (strchr(label->text, '/')) {
            assert_true(near < 1e-3);
            assert_string_equal(label->text, made.point[nearest].label);
            named[nearest / 30] = true;
            names++;
        } else {
            /* A special point's name is beside its mark. */
            int k = strcmp(label->text, "PD") == 0 ? 70 : 5;
            assert_true(k == 70 || strcmp(label->text, "LP") == 0);
            double away = hypot((made.point[k].value[0] - at[0]) / (panel->range[0][1] - panel->range[0][0]),
                                (made.state[k][0] - at[1]) / (panel->range[1][1] - panel->range[1][0]));
            assert_true(away > 0.005 && away < 0.06);
            words++;
        }
        for (int o = 0; o < m; o++) {
            const figure_mark *other = &panel->mark[o];
            if (other->kind == 'l' && other->system[0][0] == 'g')
                assert_true(fabs(other->place[0][0] - label->place[0][0]) > 0.015 ||
                            fabs(other->place[0][1] - label->place[0][1]) > 0.02);
        }
    }
    assert_true(names >= 4 && words == 2 && named[0] && named[1] && named[2]);
    figure_free(&f);
}

/* However close special points are, no name is closer to the mark of another kind, or floats. */
static void names_are_nearest_to_their_own_marks(void **state) {
    (void)state;
    static const saltus_point_kind list[] = {SALTUS_POINT_LP, SALTUS_POINT_PD, SALTUS_POINT_GR,
                                             SALTUS_POINT_NS};
    saltus_plot_options how = saltus_plot_defaults();
    int names = 0;
    how.show = SALTUS_SHOW_DISPLACEMENT;
    for (int apart = 1; apart <= 3; apart++)
        for (int column = 0; column < 2; column++) {
            make_branch();
            for (int k = 2, n = 0; k < points - 1; k += k % 30 < 20 ? apart : 11, n++)
                made.point[k].kind = list[n % 4];
            write_branch("b.h5");
            how.look.width = column ? 85 : 0;
            figure f = draw(&how);
            const figure_panel *panel = &f.panel[0];
            for (int m = 0; m < panel->mark_count; m++) {
                const figure_mark *label = &panel->mark[m];
                if (label->kind != 'l' || label->system[0][0] != 'g' || strlen(label->text) != 2)
                    continue;
                double least[2] = {INFINITY, INFINITY}, at[2];
                place_of(panel, label, at);
                for (int k = 0; k < points; k++) {
                    double away =
                        hypot((made.point[k].value[0] - at[0]) * (panel->frame[1] - panel->frame[0]) * 4 /
                                  (panel->range[0][1] - panel->range[0][0]),
                              (made.state[k][0] - at[1]) * (panel->frame[3] - panel->frame[2]) * 3 /
                                  (panel->range[1][1] - panel->range[1][0]));
                    bool own = strcmp(saltus_point_word(made.point[k].kind), label->text) == 0;
                    if (made.point[k].kind != SALTUS_POINT_REGULAR && made.point[k].kind != SALTUS_POINT_EP)
                        least[own] = fmin(least[own], away);
                }
                if (!(least[1] < least[0] * (column ? 1.2 : 1.02)))
                    fail_msg("%s stands by another mark: %g, %g", label->text, least[1], least[0]);
                /* It is beside its mark, or a line leads to it. */
                bool led = false;
                const figure_mark *arrow;
                for (int k = 0; (arrow = figure_mark_of(panel, 'a', "nohead", k)) != NULL; k++)
                    led = led || hypot(arrow->place[1][0] - label->place[0][0],
                                       arrow->place[1][1] - label->place[0][1]) < (column ? 0.06 : 0.03);
                if (!led && least[1] > (column ? 0.33 : 0.11))
                    fail_msg("%s is %g away from its mark, without a line", label->text, least[1]);
                names++;
            }
            figure_free(&f);
        }
    assert_true(names > 20);
}

/* Where marks overlap, names without room beside them are placed farther away, with lines from the marks. */
static void crowded_marks_have_their_names(void **state) {
    (void)state;
    static const saltus_point_kind list[] = {SALTUS_POINT_LP, SALTUS_POINT_PD, SALTUS_POINT_NS,
                                             SALTUS_POINT_GR, SALTUS_POINT_BP, SALTUS_POINT_CH};
    enum { crowd = 6, first = 48 };
    saltus_plot_options how = saltus_plot_defaults();
    int led = 0;
    make_branch();
    how.show = SALTUS_SHOW_DISPLACEMENT;
    how.look.width = 85;
    for (int k = 0; k < crowd; k++) {
        made.point[first + k].kind = list[k];
        made.point[first + k].value[0] = made.point[first].value[0] + 1e-4 * k;
        made.state[first + k][0] = made.state[first][0] - 1e-5 * k;
    }
    write_branch("b.h5");
    figure f = draw(&how);
    const figure_panel *panel = &f.panel[0];
    for (int k = 0; k < crowd; k++) {
        const char *word = saltus_point_word(list[k]);
        const figure_mark *label = NULL, *arrow;
        for (int m = 0; m < panel->mark_count; m++)
            if (panel->mark[m].kind == 'l' && strcmp(panel->mark[m].text, word) == 0) {
                assert_null(label);
                label = &panel->mark[m];
            }
        if (!label)
            fail_msg("%s has no name", word);
        const double own[2] = {
            (made.point[first + k].value[0] - panel->range[0][0]) / (panel->range[0][1] - panel->range[0][0]),
            (made.state[first + k][0] - panel->range[1][0]) / (panel->range[1][1] - panel->range[1][0])};
        for (int a = 0; (arrow = figure_mark_of(panel, 'a', "nohead", a)) != NULL; a++) {
            /* From the mark towards the name, and short of it. */
            const double *from = arrow->place[0], *to = arrow->place[1], *end = label->place[0];
            if (hypot(from[0] - own[0], from[1] - own[1]) > 1e-3 ||
                hypot(to[0] - end[0], to[1] - end[1]) > 0.06)
                continue;
            assert_true(hypot(to[0] - end[0], to[1] - end[1]) < hypot(from[0] - end[0], from[1] - end[1]));
            led++;
        }
    }
    assert_true(led > 0);
    /* With the long name of branch points a column fits one entry per row. */
    check_rows_of_legend(panel, 1);
    figure_free(&f);
}

/* The names of two files with the same curves do not overlap. */
static void names_do_not_lie_on_each_other(void **state) {
    (void)state;
    const char *const names[] = {"b.h5", "b.h5", "b.h5"};
    saltus_plot_options how = saltus_plot_defaults();
    int count = 0;
    make_branch();
    made.point[70].kind = SALTUS_POINT_PD;
    made.point[5].kind = SALTUS_POINT_LP;
    write_branch("b.h5");
    how.show = SALTUS_SHOW_DISPLACEMENT;
    figure f = draw_files(names, 3, &how);
    const figure_panel *panel = &f.panel[0];
    for (int m = 0; m < panel->mark_count; m++)
        for (int o = 0; o < m; o++) {
            const figure_mark *a = &panel->mark[m], *b = &panel->mark[o];
            if (a->kind != 'l' || b->kind != 'l' || a->system[0][0] != 'g' || b->system[0][0] != 'g')
                continue;
            /* Room for the letters of both, about a hundredth of the page wide and twice as high. */
            double wide = 0.004 * (double)(strlen(a->text) + strlen(b->text));
            assert_true(fabs(a->place[0][0] - b->place[0][0]) > wide ||
                        fabs(a->place[0][1] - b->place[0][1]) > 0.02);
            count++;
        }
    assert_true(count > 15);
    figure_free(&f);
}

/* A file over itself gives the same curves; over one with another parameter the legend distinguishes them. */
static void files_over_each_other_have_their_own_colour(void **state) {
    (void)state;
    const char *const names[] = {"a.h5", "b.h5"};
    saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    write_branch("a.h5");
    set_parameter(&made.scene.spec, "c", 0.375);
    made.scene.spec.stops[0].r = 0.5;
    for (int k = 0; k < points; k++)
        made.state[k][0] += 1;
    write_branch("b.h5");
    how.show = SALTUS_SHOW_DISPLACEMENT;
    figure f = draw_files(names, 2, &how);
    const figure_panel *panel = &f.panel[0];
    const figure_element *first = figure_element_of(panel, "{/:Italic c} = 0.125, {/:Italic r} = 0.75", 0),
                         *second = figure_element_of(panel, "{/:Italic c} = 0.375, {/:Italic r} = 0.5", 0);
    assert_true(first && second);
    long own[2] = {figure_colour(first->style), figure_colour(second->style)};
    assert_true(own[0] != own[1]);
    int pieces[2] = {0};
    for (int e = 0; e < panel->element_count; e++) {
        const figure_element *line = &panel->element[e];
        for (int k = 0; k < line->values.count && strstr(line->style, "with lines"); k++) {
            int file = line->values.at[k][1] > 0.5;
            assert_true(figure_colour(line->style) == own[file]);
            pieces[file] += line->values.joined[k] && of_the_file(line->values.at[k][0]);
        }
    }
    assert_true(pieces[0] == 87 && pieces[1] == 87);
    figure_says(&f, "where nothing else is said");
    figure_free(&f);
    /* In one file a branch's colour shows its number of switches. */
    f = draw_files(names, 1, &how);
    long colour[3] = {-1, -1, -1};
    for (int e = 0; e < f.panel[0].element_count; e++) {
        const figure_element *line = &f.panel[0].element[e];
        for (int k = 0; k < line->values.count && strstr(line->style, "with lines"); k++)
            for (int p = 0; p < points; p++)
                if (fabs(made.point[p].value[0] - line->values.at[k][0]) < 1e-9 &&
                    fabs(made.state[p][0] - 1 - line->values.at[k][1]) < 1e-7)
                    colour[p / 30] = figure_colour(line->style);
    }
    assert_true(colour[0] == colour[1] && colour[2] != colour[0] && colour[0] >= 0 && colour[2] >= 0);
    figure_free(&f);
}

/* A parameter whose name extends the axis's belongs to no stop and distinguishes files. */
static void longer_names_are_other_parameters(void **state) {
    (void)state;
    const char *const names[] = {"a.h5", "b.h5"};
    saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    strcpy(made.options.key[0], "c");
    write_branch("a.h5");
    set_parameter(&made.scene.spec, "c2", 0.375);
    set_parameter(&made.scene.spec, "c", 0.25);
    write_branch("b.h5");
    how.show = SALTUS_SHOW_DISPLACEMENT;
    figure f = draw_files(names, 2, &how);
    assert_non_null(figure_element_of(&f.panel[0], "{/:Italic c}_{2} = 0.375", 0));
    assert_null(figure_element_of(&f.panel[0], "{/:Italic c} = ", 0));
    figure_free(&f);
}

/* A branch that is all zero has axes around it, also in one column. */
static void zero_has_an_axis(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    how.show = SALTUS_SHOW_DISPLACEMENT;
    make_branch();
    for (int k = 0; k < points; k++)
        made.state[k][0] = 0;
    write_branch("b.h5");
    for (int column = 0; column < 2; column++) {
        how.look.width = column ? 85 : 0;
        figure f = draw(&how);
        const double *range = f.panel[0].range[1];
        assert_true(range[0] < 0 && range[1] > 0 && (!column || f.panel[0].tic[1] > 0));
        figure_free(&f);
    }
}

/* Curves of special points */

static void make_locus(saltus_point_kind kind) {
    make_branch();
    strcpy(made.options.key[1], "d");
    made.options.low[1] = 0.1;
    made.options.high[1] = 0.5;
    made.options.locus = kind;
    for (int k = 0; k < points; k++) {
        saltus_branch_point *p = &made.point[k];
        p->kind = p->locus = kind;
        p->value[1] = 0.2 + 0.002 * k + 0.03 * p->branch;
        double critical = kind == SALTUS_POINT_PD ? -1 : 1;
        made.multiplier[k][0] = (saltus_multiplier){critical, 0, 0};
        made.multiplier[k][1] = (saltus_multiplier){0.25, 0, log(0.25)};
    }
}

/* A curve of special points is solid where it bounds stable orbits: where only its own multiplier is
 * critical. */
static void loci_are_solid_where_they_bound_stable_orbits(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    for (int kind = SALTUS_POINT_LP; kind <= SALTUS_POINT_GR; kind++) {
        bool solid_at[points];
        if (kind == SALTUS_POINT_BP)
            continue;
        make_locus((saltus_point_kind)kind);
        for (int k = 0; k < points; k++) {
            solid_at[k] = true;
            if (kind == SALTUS_POINT_NS) {
                /* A pair on the circle, in a system with two multipliers only. */
                made.multiplier[k][0] = (saltus_multiplier){0.6, 0.8, 0};
                made.multiplier[k][1] = (saltus_multiplier){0.6, -0.8, 0};
            } else if (kind == SALTUS_POINT_GR) {
                double modulus = k % 30 < 10 ? 1.5 : k % 30 < 20 ? 1e4 : 0.5;
                made.multiplier[k][0] = (saltus_multiplier){modulus, 0, log(modulus)};
                /* For an infinite multiplier the nearest point that decides counts. */
                solid_at[k] = k % 30 >= 15;
            } else if (k % 30 > 9 && k % 30 < 20) {
                solid_at[k] = false;
                made.multiplier[k][1] = made.multiplier[k][0];
                made.multiplier[k][0] = (saltus_multiplier){-made.multiplier[k][1].re * 1.5, 0, log(1.5)};
            } else if (k % 30 < 5) {
                /* Too small to be resolved. */
                made.multiplier[k][1] = (saltus_multiplier){0, 0, NAN};
            }
        }
        write_branch("b.h5");
        figure f = draw(&how);
        int expected = 0;
        for (int k = 1; k < points; k++) {
            const saltus_branch_point *a = &made.point[k - 1], *b = &made.point[k];
            int pieces[3];
            if (a->branch != b->branch)
                continue;
            /* Two points in the middle are equally near to both sides. */
            bool tie = kind == SALTUS_POINT_GR && k % 30 >= 14 && k % 30 <= 16;
            count_pieces(&f.panel[0], a->value, b->value, pieces);
            assert_int_equal(pieces[solid] + pieces[dotted], 1);
            if (!tie)
                assert_int_equal(pieces[solid], solid_at[k - 1] && solid_at[k]);
            expected++;
        }
        assert_int_equal(all_pieces(&f.panel[0]), expected);
        assert_non_null(figure_element_of(&f.panel[0], kinds[kind].meaning, 0));
        bool dots = false;
        for (int k = 0; k < points; k++)
            dots = dots || !solid_at[k];
        assert_int_equal(figure_element_of(&f.panel[0], "bounds no stable orbit", 0) != NULL, dots);
        assert_non_null(strstr(f.panel[0].label[1], "{/:Italic d}"));
        const double *y = f.panel[0].range[1];
        assert_true(y[0] < 0.2 && y[1] > 0.438 && y[1] - y[0] < 1.2 * 0.24);
        figure_says(&f, "special points in {/:Italic ω} and {/:Italic d}");
        /* The curve's own points have no marks; its symbol appears now and then. */
        char mark[16];
        int signs = 0;
        assert_true(mark_of(&f.panel[0], kind, mark));
        for (int k = 0; k < points; k++)
            signs += count_marks(&f.panel[0], mark, made.point[k].value[0], made.point[k].value[1]);
        assert_in_range(signs, 1, points / 3);
        figure_free(&f);
    }
}

/* A locus with its parameters in the other order is the same curve; names are written on request; a range of
 * either parameter clips. */
static void planes_turn_and_clip(void **state) {
    (void)state;
    const char *const names[] = {"a.h5", "b.h5"};
    saltus_plot_label label = {{"d", "omega"}, {0.3, 1.5}, "own_name"};
    saltus_plot_part parts[2] = {{"d", 0.25, 0.4}, {"omega", 1.1, 1.7}};
    saltus_plot_options how = saltus_plot_defaults();
    make_locus(SALTUS_POINT_LP);
    write_branch("a.h5");
    for (int k = 0; k < points; k++) {
        double first = made.point[k].value[0];
        made.point[k].value[0] = made.point[k].value[1] + 0.05;
        made.point[k].value[1] = first;
    }
    strcpy(made.options.key[0], "d");
    strcpy(made.options.key[1], "omega");
    made.options.low[0] = 0.1;
    made.options.high[0] = 0.5;
    made.options.low[1] = 1;
    made.options.high[1] = 3;
    write_branch("b.h5");
    how.labels = &label;
    how.label_count = 1;
    for (int clip = 0; clip < 3; clip++) {
        how.parts = parts + (clip == 2);
        how.part_count = clip == 0 ? 0 : clip == 1 ? 2 : 1;
        figure f = draw_files(names, 2, &how);
        const figure_panel *panel = &f.panel[0];
        assert_int_equal(all_pieces(panel), 2 * 87);
        for (int k = 1; k < 30; k++) {
            int pieces[3];
            const double from[2] = {made.point[k - 1].value[1], made.point[k - 1].value[0]},
                         to[2] = {made.point[k].value[1], made.point[k].value[0]};
            count_pieces(panel, from, to, pieces);
            assert_int_equal(pieces[solid], 1);
        }
        const figure_mark *name = figure_mark_of(panel, 'l', "own\\_name", 0);
        double at[2];
        assert_non_null(name);
        place_of(panel, name, at);
        check_near(at[0], 1.5, 1e-3);
        check_near(at[1], 0.3, 1e-3);
        if (clip) {
            assert_true(panel->range[0][0] == 1.1 && panel->range[0][1] == 1.7);
            assert_true((panel->range[1][0] == 0.25 && panel->range[1][1] == 0.4) == (clip == 1));
        }
        figure_free(&f);
    }
}

/* A requested name that would lie on a curve is moved beside it, by a few heights of its type at most, or
 * where there is no such place has a white ground. */
static void requested_names_are_legible(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    saltus_plot_label label = {{"omega", "d"}, {0, 0}, "Here"};
    how.labels = &label;
    how.label_count = 1;
    make_locus(SALTUS_POINT_LP);
    write_branch("b.h5");
    for (int k = 3; k < 27; k += 4)
        for (int size = 0; size < 2; size++) {
            how.look.width = size ? 85 : 0;
            label.value[0] = 0.5 * (made.point[k].value[0] + made.point[k + 1].value[0]);
            label.value[1] = 0.5 * (made.point[k].value[1] + made.point[k + 1].value[1]);
            figure f = draw(&how);
            const figure_panel *panel = &f.panel[0];
            const figure_mark *name = figure_mark_of(panel, 'l', "Here", 0);
            const double page = size ? 522 : 1600;
            double at[2], height = 0;
            assert_non_null(name);
            assert_true(sscanf(strstr(f.terminal, "size "), "size %*f,%lf", &height) == 1);
            place_of(panel, name, at);
            const double unit[2] = {
                page * (panel->frame[1] - panel->frame[0]) / (panel->range[0][1] - panel->range[0][0]),
                height * (panel->frame[3] - panel->frame[2]) / (panel->range[1][1] - panel->range[1][0])};
            double away = hypot((at[0] - label.value[0]) * unit[0], (at[1] - label.value[1]) * unit[1]),
                   least = INFINITY;
            for (int p = 0; p + 1 < 30; p++) {
                double ends[2][2];
                for (int end = 0; end < 2; end++)
                    for (int axis = 0; axis < 2; axis++)
                        ends[end][axis] = (made.point[p + end].value[axis] - at[axis]) * unit[axis];
                least = fmin(least, saltus_plot_distance((const double[2]){0, 0}, ends[0], ends[1]));
            }
            assert_true(away < 4.5 * 20.2);
            assert_true(least > 6 || strstr(name->style, "boxed"));
            figure_free(&f);
        }
}

/* All requested names are written, except beyond the page's edges; the curves' own share with them the room
 * for four hundred. */
static void no_more_than_four_hundred_names(void **state) {
    (void)state;
    enum { most = 400, names = most + 2 };
    static const double beyond[4][2] = {{0.4, 0.5}, {3.1, 0.5}, {2, 0.05}, {2, 1.05}};
    static const int counts[] = {0, 4, most + 2, most + 3, most + 4, most + 5};
    static saltus_plot_label labels[4 + names];
    saltus_plot_part parts[2] = {{"omega", 0.5, 3}, {"d", 0.1, 1}};
    saltus_plot_options how = saltus_plot_defaults();
    int plenty = 0;
    make_locus(SALTUS_POINT_LP);
    write_branch("b.h5");
    for (int k = 0; k < 4 + names; k++) {
        labels[k] = (saltus_plot_label){{"omega", "d"}, {0.75, 0.9}, "Here"};
        if (k < 4)
            memcpy(labels[k].value, beyond[k], sizeof beyond[k]);
    }
    how.labels = labels;
    how.parts = parts;
    how.part_count = 2;
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++) {
        how.label_count = counts[c];
        int asked = counts[c] < 4 ? 0 : counts[c] - 4, here = 0, own = 0;
        figure f = draw(&how);
        for (int m = 0; m < f.panel[0].mark_count; m++) {
            const figure_mark *label = &f.panel[0].mark[m];
            here += label->kind == 'l' && strcmp(label->text, "Here") == 0;
            own += label->kind == 'l' && strncmp(label->text, "LP ", 3) == 0;
        }
        assert_int_equal(here, asked);
        if (c == 0)
            plenty = own;
        assert_int_equal(own, asked + plenty <= most ? plenty : asked < most ? most - asked : 0);
        figure_free(&f);
    }
    assert_true(plenty > 2);
}

/* Branches of scenes with different stops cannot share a page. */
static void other_structures_have_other_pages(void **state) {
    (void)state;
    const saltus_plot_options how = saltus_plot_defaults();
    char a[path_size], b[path_size], out[path_size];
    make_branch();
    write_branch("a.h5");
    add_stop(&made.scene.spec, 0.5, 0.75, SALTUS_UPPER);
    made.scene.spec.stops[0].sides = SALTUS_LOWER;
    write_branch("b.h5");
    for (int turned = 0; turned < 2; turned++) {
        const char *const paths[2] = {path_in(turned ? "b.h5" : "a.h5", a),
                                      path_in(turned ? "a.h5" : "b.h5", b)};
        saltus_message message = {.text = ""};
        assert_int_equal(saltus_plot(path_in("b.svg", out), paths, 2, &how, &message), SALTUS_BAD_INPUT);
        if (strncmp(message.text, paths[1], strlen(paths[1])) != 0 || !strstr(message.text, "stops differ"))
            fail_msg("%s", message.text);
    }
}

/* Curves of several kinds in one plane have their own colours, named in the legend. */
static void kinds_of_loci_have_their_own_colours(void **state) {
    (void)state;
    static const saltus_point_kind own[] = {SALTUS_POINT_LP, SALTUS_POINT_PD, SALTUS_POINT_NS,
                                            SALTUS_POINT_GR};
    static const char *const names[] = {"0.h5", "1.h5", "2.h5", "3.h5"};
    const saltus_plot_options how = saltus_plot_defaults();
    long colour[4];
    for (int i = 0; i < 4; i++) {
        make_locus(own[i]);
        for (int k = 0; k < points; k++)
            made.point[k].value[1] += 0.001 * i;
        if (i == 1) {
            made.point[40].kind = SALTUS_POINT_CH;
            made.point[41].kind = SALTUS_POINT_ST;
        }
        write_branch(names[i]);
    }
    figure f = draw_files(names, 4, &how);
    const figure_panel *panel = &f.panel[0];
    check_rows_of_legend(panel, 5);
    assert_int_equal(figure_titles(panel), 7);
    for (int i = 0; i < 4; i++) {
        const figure_element *entry = figure_element_of(panel, kinds[own[i]].meaning, 0);
        assert_true(entry && strstr(entry->style, "with lines"));
        colour[i] = figure_colour(entry->style);
        for (int j = 0; j < i; j++)
            assert_true(colour[i] != colour[j]);
    }
    for (int e = 0; e < panel->element_count; e++) {
        const figure_element *line = &panel->element[e];
        for (int k = 0; k < line->values.count && strstr(line->style, "with lines"); k++)
            for (int i = 0; i < 4; i++)
                for (int p = 0; p < points; p++)
                    if (fabs(made.point[p].value[0] - line->values.at[k][0]) < 1e-9 &&
                        fabs(made.point[p].value[1] - 0.001 * (3 - i) - line->values.at[k][1]) < 1e-7)
                        assert_true(figure_colour(line->style) == colour[i]);
    }
    figure_free(&f);
}

/* Branches over a sweep */

static void fill_sweep(made_place *m) {
    m->row[0] = made_periodic(2, 1);
    m->row[0].largest_speed = 0.9 + 0.001 * (double)m->point;
    m->impact_count[0] = 2;
    m->impact[0] = (saltus_sweep_impact){0.1, -0.8, 1};
    m->impact[1] = (saltus_sweep_impact){0.6, 0.7, 0};
    m->strobe_count[0] = 1;
    m->strobe[0] = 0.02;
    m->strobe[1] = 3;
}

/* Over a cloud the curves show the cloud's quantity, in the same axes, and fit in completely. */
static void branches_lie_over_clouds(void **state) {
    (void)state;
    static const saltus_view views[] = {SALTUS_VIEW_IMPACTS, SALTUS_VIEW_SPEED, SALTUS_VIEW_STROBOSCOPIC};
    static const saltus_show shows[] = {SALTUS_SHOW_IMPACTS, SALTUS_SHOW_SPEED, SALTUS_SHOW_DISPLACEMENT};
    saltus_axis axis = {.key = "omega", .count = 11, .low = 0.9, .high = 2.1};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message = {.text = ""};
    char path[path_size], branch[path_size], out[path_size], mark[16];
    const char *paths[] = {path_in("b.h5", branch)};
    make_branch();
    made.point[70].kind = SALTUS_POINT_PD;
    write_branch("b.h5");
    options.keep = SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC;
    made_write(path_in("s.h5", path), &made.scene, &axis, 1, &options, fill_sweep, 100);
    saltus_sweep_view how = {.branches = paths, .branch_count = 1};
    for (int k = 0; k < 3; k++) {
        how.view = views[k];
        check_ok(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), &message);
        figure f = figure_taken(folder);
        const figure_panel *panel = &f.panel[0];
        figure_check_page(&f);
        for (int p = 1; p < points; p++) {
            const saltus_branch_point *a = &made.point[p - 1], *b = &made.point[p];
            const double from[2] = {a->value[0], height(shows[k], a)},
                         to[2] = {b->value[0], height(shows[k], b)};
            int pieces[3];
            if (a->branch != b->branch)
                continue;
            count_pieces(panel, from, to, pieces);
            assert_int_equal(pieces[stroke_between(a, b)], 1);
            assert_true(from[1] > panel->range[1][0] && from[1] < panel->range[1][1]);
        }
        const figure_element *cloud = figure_element_of(panel, "$cloud", 0);
        figure_check_inside(panel, cloud);
        assert_int_equal(cloud->values.count, k == 0 ? 22 : 11);
        for (int i = 0; i < cloud->values.count; i++)
            assert_true(cloud->values.at[i][1] > 0);
        assert_true(mark_of(panel, SALTUS_POINT_PD, mark));
        assert_int_equal(count_marks(panel, mark, made.point[70].value[0], height(shows[k], &made.point[70])),
                         1);
        assert_non_null(figure_element_of(panel, "title 'stable'", 0));
        /* With the axes exchanged all of it is at the same values. */
        how.look.swap = true;
        check_ok(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), &message);
        how.look.swap = false;
        figure upright = figure_taken(folder);
        assert_int_equal(upright.panel[0].element_count, panel->element_count);
        for (int p = 1; p < points; p++) {
            const saltus_branch_point *a = &made.point[p - 1], *b = &made.point[p];
            const double from[2] = {height(shows[k], a), a->value[0]},
                         to[2] = {height(shows[k], b), b->value[0]};
            int pieces[3];
            if (a->branch == b->branch) {
                count_pieces(&upright.panel[0], from, to, pieces);
                assert_int_equal(pieces[stroke_between(a, b)], 1);
            }
        }
        for (int i = 0; i < 2; i++) {
            figure_near(upright.panel[0].range[i][0], panel->range[!i][0], 1e-9);
            figure_near(upright.panel[0].range[i][1], panel->range[!i][1], 1e-9);
        }
        assert_int_equal(
            count_marks(&upright.panel[0], mark, height(shows[k], &made.point[70]), made.point[70].value[0]),
            1);
        figure_free(&upright);
        figure_free(&f);
    }
    /* Unsuitable branches over a sweep are refused: another view, system or key. */
    how.view = SALTUS_VIEW_LARGEST;
    assert_int_equal(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), SALTUS_BAD_INPUT);
    how.view = SALTUS_VIEW_SPEED;
    const saltus_spec own = made.scene.spec;
    for (int k = 0; k < 5; k++) {
        made.scene.spec = own;
        saltus_stop *stop = &made.scene.spec.stops[0];
        if (k == 0)
            set_parameter(&made.scene.spec, "c", 0.13);
        else if (k == 1)
            stop->d = 0.26;
        else if (k == 2)
            stop->r = 0.76;
        else if (k == 3)
            stop->sides = SALTUS_UPPER;
        else
            set_parameter(&made.scene.spec, "omega", 1.1); /* the axis's own */
        made_write(path, &made.scene, &axis, 1, &options, fill_sweep, 100);
        assert_int_equal(saltus_plot_sweep(path_in("s.png", out), path, &how, &message),
                         k < 4 ? SALTUS_BAD_INPUT : SALTUS_OK);
    }
    made.scene.spec = own;
    strcpy(axis.key, "k");
    made_write(path, &made.scene, &axis, 1, &options, fill_sweep, 100);
    assert_int_equal(saltus_plot_sweep(path_in("s.png", out), path, &how, &message), SALTUS_BAD_INPUT);
    /* A sweep is no branch, with its own message. */
    saltus_branch_file file;
    char expected[2 * path_size];
    snprintf(expected, sizeof expected, "%s: holds a sweep, not a branch of orbits", path);
    assert_int_equal(saltus_branch_file_read(path, &file, &message), SALTUS_BAD_INPUT);
    assert_string_equal(message.text, expected);
}

/* With long names, of curves of special points or several files, fewer are in a row. */
static void long_names_leave_room_for_fewer(void **state) {
    (void)state;
    static const saltus_point_kind marks[] = {SALTUS_POINT_PD, SALTUS_POINT_NS, SALTUS_POINT_BP,
                                              SALTUS_POINT_GR, SALTUS_POINT_CH, SALTUS_POINT_ST,
                                              SALTUS_POINT_UZ};
    static const char *const names[] = {"0.h5", "1.h5"};
    const saltus_plot_options how = saltus_plot_defaults();
    for (int count = 2; count <= 7; count++)
        for (int kind = 0; kind < 3; kind++) {
            if (kind == 2)
                make_locus(SALTUS_POINT_LP);
            else
                make_branch();
            for (int k = 0; k < count; k++)
                made.point[3 + 2 * k].kind = marks[k];
            write_branch(names[0]);
            if (kind == 1)
                write_branch(names[1]);
            figure f = draw_files(names, kind == 1 ? 2 : 1, &how);
            assert_int_equal(figure_titles(&f.panel[0]), count + (kind == 1 ? 4 : kind == 0 ? 2 : 1));
            check_rows_of_legend(&f.panel[0], kind == 0 ? 8 : 5);
            figure_free(&f);
        }
}

/* The name of a tip is beyond it, where there is no curve: above one that points up, at the right of one that
 * points there. */
static void tips_have_their_names_beyond_them(void **state) {
    (void)state;
    for (int way = 0; way < 2; way++) {
        saltus_plot_options how = saltus_plot_defaults();
        how.show = SALTUS_SHOW_DISPLACEMENT;
        make_branch();
        for (int k = 0; k < points; k++) {
            double along = (k % 30 - 15) / 15.0, away = 1 - fabs(along);
            made.point[k].value[0] = way == 0 ? 2 + along : 1.7 + 0.3 * away;
            made.state[k][0] = way == 0 ? away : along;
            if (k >= 60) { /* far below, over all of the page */
                made.point[k].value[0] = 2 + along;
                made.state[k][0] = -1.5;
            }
            set_parameter(&made.point[k].spec, "omega", made.point[k].value[0]);
        }
        made.point[15].kind = SALTUS_POINT_LP;
        write_branch("b.h5");
        figure f = draw(&how);
        const figure_panel *panel = &f.panel[0];
        const figure_mark *name = NULL;
        for (int k = 0; k < panel->mark_count; k++)
            if (panel->mark[k].kind == 'l' && strcmp(panel->mark[k].text, "LP") == 0)
                name = &panel->mark[k];
        double at[2], width = panel->range[0][1] - panel->range[0][0],
                      height = panel->range[1][1] - panel->range[1][0];
        assert_non_null(name);
        place_of(panel, name, at);
        if (way == 0) {
            check_near(at[0], 2, 1e-3 * width);
            assert_true(at[1] > 1 + 0.02 * height && at[1] < 1 + 0.06 * height);
        } else {
            double beyond = at[0] - 2;
            assert_true(beyond > 0.015 * width && beyond < 0.06 * width);
            assert_true(fabs(at[1]) < 0.05 * height);
        }
        figure_free(&f);
    }
}

/* Over a map */

static void fill_map(made_place *m) {
    m->row[0] = made_periodic(1 + (int)(m->point % 3), 1);
}

static figure draw_over(const char *const *names, int count, const saltus_figure_options *look) {
    saltus_message message = {.text = ""};
    char paths[3][path_size], sweep[path_size], out[path_size];
    const char *list[3];
    for (int k = 0; k < count; k++)
        list[k] = path_in(names[k], paths[k]);
    saltus_sweep_view how = {.branches = list, .branch_count = count};
    if (look)
        how.look = *look;
    check_ok(saltus_plot_sweep(path_in("s.png", out), path_in("map.h5", sweep), &how, &message), &message);
    return figure_taken(folder);
}

/* No curve crosses the name of a region. */
static void check_names_are_clear(const figure_panel *panel) {
    const double page[2] = {1600, 1200}, letter = 0.6, high = 0.7; /* of the type's size */
    double size[2];
    int names = 0;
    for (int i = 0; i < 2; i++)
        size[i] = page[i] * (panel->frame[2 * i + 1] - panel->frame[2 * i]);
    for (int m = 0; m < panel->mark_count; m++) {
        const figure_mark *name = &panel->mark[m];
        const char *type = name->kind == 'l' ? strstr(name->style, "Bold,") : NULL;
        if (!type || name->system[0][0] != 'g')
            continue;
        names++;
        double pixels = strtod(type + 5, NULL) * 4 / 3,
               half[2] = {0.5 * letter * pixels * (double)strlen(name->text), 0.5 * high * pixels};
        for (int e = 0; e < panel->element_count; e++) {
            const figure_rows *rows = &panel->element[e].values;
            for (int k = 1; k < rows->count && strstr(panel->element[e].text, "$curve_"); k++)
                for (int n = 0; n <= 50 && rows->joined[k]; n++) {
                    bool through = true;
                    for (int i = 0; i < 2; i++) {
                        double value = rows->at[k - 1][i] + n * (rows->at[k][i] - rows->at[k - 1][i]) / 50,
                               part =
                                   (value - panel->range[i][0]) / (panel->range[i][1] - panel->range[i][0]);
                        through = through && fabs(part - name->place[0][i]) * size[i] < half[i];
                    }
                    if (through)
                        fail_msg("a curve runs through %s", name->text);
                }
        }
    }
    assert_true(names > 3);
}

/* Curves of special points over a map of their two parameters, in any order: in the map's axes, above its
 * colours, with a rim; the map keeps its legend. */
static void special_points_lie_over_maps(void **state) {
    (void)state;
    const char *const names[] = {"a.h5", "b.h5"};
    saltus_axis axes[2] = {{.key = "omega", .count = 8, .low = 0.9, .high = 2.1},
                           {.key = "d", .count = 6, .low = 0.1, .high = 0.6}};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    make_locus(SALTUS_POINT_PD);
    write_branch("a.h5");
    saltus_scene scene = made.scene;
    made_write(path_in("map.h5", path), &scene, axes, 2, &options, fill_map, 100);
    made.options.locus = SALTUS_POINT_GR;
    for (int k = 0; k < points; k++) {
        double first = made.point[k].value[0];
        made.point[k].kind = SALTUS_POINT_GR;
        made.point[k].value[0] = made.point[k].value[1] + 0.1;
        made.point[k].value[1] = first;
    }
    strcpy(made.options.key[0], "d");
    strcpy(made.options.key[1], "omega");
    write_branch("b.h5");
    for (int swap = 0; swap < 2; swap++) {
        const saltus_figure_options look = {.swap = swap};
        figure f = draw_over(names, 2, &look);
        const figure_panel *panel = &f.panel[0];
        figure_check_page(&f);
        assert_non_null(strstr(panel->label[swap], "{/:Italic ω}"));
        assert_non_null(strstr(panel->label[!swap], "{/:Italic d}"));
        assert_true(panel->element[0].width > 0);
        for (int k = 1; k < 30; k++) {
            double a[2] = {made.point[k - 1].value[1], made.point[k - 1].value[0]},
                   b[2] = {made.point[k].value[1], made.point[k].value[0]};
            for (int file = 0; file < 2; file++) {
                const double from[2] = {a[swap] - (swap && !file) * 0.1, a[!swap] - (!swap && !file) * 0.1},
                             to[2] = {b[swap] - (swap && !file) * 0.1, b[!swap] - (!swap && !file) * 0.1};
                int pieces[3];
                count_pieces(panel, from, to, pieces);
                /* The curve and its rim. */
                assert_int_equal(pieces[solid] + pieces[dashed] + pieces[dotted], 2);
            }
        }
        assert_non_null(figure_element_of(panel, kinds[SALTUS_POINT_PD].meaning, 0));
        assert_non_null(figure_element_of(panel, kinds[SALTUS_POINT_GR].meaning, 0));
        assert_non_null(figure_mark_of(panel, 'l', "1/1", 0));
        check_names_are_clear(panel);
        figure_free(&f);
    }
    /* In one column the map keeps its height, however many rows the legend of the curves has. */
    const saltus_sweep_view bare = {.look = {.width = 85}};
    const saltus_figure_options column = {.width = 85};
    check_ok(saltus_plot_sweep(path_in("s.svg", out), path, &bare, &message), &message);
    figure alone = figure_taken(folder), both = draw_over(names, 2, &column);
    double high[2];
    for (int k = 0; k < 2; k++) {
        const figure *f = k ? &both : &alone;
        double wide = 0;
        assert_int_equal(sscanf(strstr(f->terminal, "size "), "size %lf,%lf", &wide, &high[k]), 2);
        high[k] *= (f->panel[0].frame[3] - f->panel[0].frame[2]) / wide;
    }
    assert_true(high[1] > 0.95 * high[0]);
    figure_free(&alone);
    figure_free(&both);
    /* In two columns the legend of the curves is above the panel, which is narrow beside that of the map:
     * gnuplot makes as many columns as its entries have room in the panel. */
    const saltus_figure_options columns = {.width = 175};
    make_locus(SALTUS_POINT_PD);
    for (int k = 0; k < points; k++) /* bounds no stable orbit, as its entry says at length */
        made.multiplier[k][1] = (saltus_multiplier){1.5, 0, log(1.5)};
    write_branch("a.h5");
    both = draw_over(names, 2, &columns);
    const figure_panel *over = &both.panel[0];
    size_t longest = 1;
    for (int e = 0; e < over->element_count; e++)
        longest = strlen(over->element[e].title) > longest ? strlen(over->element[e].title) : longest;
    const int in_a_row = (int)((over->frame[1] - over->frame[0]) * 1075 / (9.9 * (double)longest + 55));
    assert_true(in_a_row >= 1 && in_a_row < figure_titles(over) &&
                over->key_rows * in_a_row >= figure_titles(over));
    figure_free(&both);
    /* Other parameters are refused, and so is a branch of orbits. */
    const char *list[] = {path_in("a.h5", out)};
    const saltus_sweep_view how = {.branches = list, .branch_count = 1};
    strcpy(axes[1].key, "c");
    made_write(path, &scene, axes, 2, &options, fill_map, 100);
    assert_int_equal(saltus_plot_sweep("s.png", path, &how, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "the sweep is over omega and c"));
    strcpy(axes[1].key, "d");
    set_parameter(&scene.spec, "c", 0.25);
    made_write(path, &scene, axes, 2, &options, fill_map, 100);
    assert_int_equal(saltus_plot_sweep("s.png", path, &how, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "has another c than the sweep"));
    make_branch();
    write_branch("a.h5");
    assert_int_equal(saltus_plot_sweep("s.png", path, &how, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "are periodic orbits in omega"));
}

/* What a reader makes of the curves */

/* Two coinciding unstable branches are dashed once; a stable one below them stays. */
static void dashes_do_not_fill_each_other(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    how.show = SALTUS_SHOW_DISPLACEMENT;
    make_branch();
    for (int k = 0; k < points; k++) {
        made.point[k].stable = made.point[k].branch == 2;
        made.point[k].value[0] = 1 + 0.03 * (k % 30);
        made.state[k][0] = 0.2 + 0.001 * (k % 30);
    }
    write_branch("b.h5");
    figure f = draw(&how);
    for (int k = 1; k < 30; k++) {
        const double from[2] = {made.point[k - 1].value[0], made.state[k - 1][0]},
                     to[2] = {made.point[k].value[0], made.state[k][0]};
        int pieces[3];
        count_pieces(&f.panel[0], from, to, pieces);
        assert_true(pieces[solid] == 1 && pieces[dashed] == 1 && pieces[dotted] == 0);
    }
    figure_free(&f);
    /* The same where each impact is a curve. */
    how.show = SALTUS_SHOW_IMPACTS;
    f = draw(&how);
    for (int k = 1; k < 30; k++)
        for (int e = 0; e < 2; e++) {
            const double from[2] = {made.point[k - 1].value[0], fabs(made.event[k - 1][e].velocity_before)},
                         to[2] = {made.point[k].value[0], fabs(made.event[k][e].velocity_before)};
            int pieces[3];
            count_pieces(&f.panel[0], from, to, pieces);
            assert_true(pieces[solid] == 1 && pieces[dashed] == 1 && pieces[dotted] == 0);
        }
    figure_free(&f);
}

/* Count the dashed lines that cross a horizontal place. */
static int dashes_over(const figure_panel *panel, double x) {
    int count = 0;
    for (int e = 0; e < panel->element_count; e++) {
        const figure_element *line = &panel->element[e];
        for (int k = 1; k < line->values.count && line->text[0] == '$' && strstr(line->style, "with lines");
             k++)
            count += line->values.joined[k] && stroke_of(panel, line->style) == dashed &&
                     (line->values.at[k - 1][0] < x) != (line->values.at[k][0] < x);
    }
    return count;
}

/* Where an unstable branch joins another and leaves it within steps, all of it is dashed, once. */
static void dashes_end_where_others_begin(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    how.show = SALTUS_SHOW_DISPLACEMENT;
    make_branch();
    for (int k = 0; k < points; k++) {
        static const double first[3] = {1.7, 1.2, 1}, step[3] = {0.011, 0.049, 0.01};
        const int b = made.point[k].branch;
        made.point[k].stable = b == 2;
        made.point[k].value[0] = first[b] + step[b] * (k % 30);
        made.state[k][0] = b == 2 ? 0.9 : 0.2 + 0.1 * made.point[k].value[0];
    }
    write_branch("b.h5");
    figure f = draw(&how);
    for (double x = 1.2031; x < 2.62; x += 0.0037)
        if (fabs(x - 1.7) > 0.006 && fabs(x - 2.019) > 0.006)
            assert_int_equal(dashes_over(&f.panel[0], x), 1);
    figure_free(&f);
}

/* Few points of a circle become a curve as round on the page, and no name is where its point is cut off. */
static void sparse_points_give_smooth_curves(void **state) {
    (void)state;
    const double step = 2 * acos(-1.0) / 24;
    saltus_plot_options how = saltus_plot_defaults();
    how.show = SALTUS_SHOW_DISPLACEMENT;
    make_branch();
    for (int k = 0; k < points; k++) {
        double angle = step * (k % 30);
        made.point[k].value[0] = 1.5 + 0.4 * cos(angle);
        made.state[k][0] = 0.3 * sin(angle);
        made.point[k].stable = true;
    }
    made.point[5].kind = SALTUS_POINT_LP;
    write_branch("b.h5");
    figure f = draw(&how);
    int between = 0;
    for (int e = 0; e < f.panel[0].element_count; e++) {
        const figure_element *line = &f.panel[0].element[e];
        for (int k = 0; k < line->values.count && line->text[0] == '$' && strstr(line->style, "lines"); k++) {
            double x = (line->values.at[k][0] - 1.5) / 0.4, y = line->values.at[k][1] / 0.3;
            /* Chords differ from the circle by 0.86 %. */
            assert_true(fabs(hypot(x, y) - 1) < 1.5e-3);
            between += !of_the_file(line->values.at[k][0]);
        }
    }
    assert_true(between > 100);
    assert_non_null(figure_mark_of(&f.panel[0], 'l', "LP", 0));
    figure_free(&f);
    const saltus_plot_part part = {"omega", 1.1, 1.4};
    how.parts = &part;
    how.part_count = 1;
    f = draw(&how);
    for (int m = 0; m < f.panel[0].mark_count; m++)
        assert_string_not_equal(f.panel[0].mark[m].text, "LP");
    figure_free(&f);
}

/* The look of a page */

static void pages_have_the_size_asked_for(void **state) {
    (void)state;
    static const struct {
        const char *picture, *terminal;
    } cases[] = {
        {"b.png", "pngcairo size 1004,"}, {"b.pdf", "fontscale 0.46154 "}, {"b.svg", "svg size 522,"}};
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    const char *const paths[] = {path_in("b.h5", path)};
    make_branch();
    write_branch("b.h5");
    for (int k = 0; k < 3; k++) {
        saltus_plot_options how = saltus_plot_defaults();
        how.look.width = 85;
        how.look.no_heading = true;
        check_ok(saltus_plot(path_in(cases[k].picture, out), paths, 1, &how, &message), &message);
        figure f = figure_taken(folder);
        const double *frame = f.panel[0].frame;
        assert_non_null(strstr(f.terminal, cases[k].terminal));
        assert_true(frame[0] > 0.1 && frame[1] < 0.99 && frame[2] > 0.05 && frame[3] > 0.7 && frame[3] < 1);
        for (int m = 0; m < f.panel[0].mark_count; m++)
            assert_true(f.panel[0].mark[m].system[0][0] != 's');
        figure_free(&f);
    }
    /* Type of eight points: 13 points on a page for screens have 52/3 dots. */
    saltus_plot_options how = saltus_plot_defaults();
    double top[3];
    for (int k = 0; k < 3; k++) {
        how.look.title = k == 0 ? NULL : k == 1 ? "own {title}" : "";
        check_ok(saltus_plot(path_in("b.svg", out), paths, 1, &how, &message), &message);
        figure f = figure_taken(folder);
        top[k] = f.panel[0].frame[3];
        assert_true((figure_mark_of(&f.panel[0], 'l', "own \\{title\\}", 0) != NULL) == (k == 1));
        assert_true((figure_mark_of(&f.panel[0], 'l', "periodic orbits", 0) != NULL) == (k == 0));
        figure_free(&f);
    }
    assert_true(top[0] == top[1] && top[2] > top[0] + 0.03);
    static const double sizes[][2] = {{10, 60}, {85, 2}, {1e9, 60}, {NAN, 60}};
    for (int k = 0; k < 4; k++) {
        how.look.width = sizes[k][0];
        how.look.height = sizes[k][1];
        assert_int_equal(saltus_plot(out, paths, 1, &how, &message), SALTUS_BAD_INPUT);
    }
}

/* Axes can be swapped, and be logarithmic if possible. */
static void axes_are_laid_out_as_asked(void **state) {
    (void)state;
    static const char *const keys[] = {"omega", "speed", "displacement"};
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    const char *const paths[] = {path_in("b.h5", path)};
    saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    write_branch("b.h5");
    how.look.swap = true;
    how.look.logarithmic = keys;
    how.look.logarithmic_count = 2;
    figure f = draw(&how);
    const figure_panel *panel = &f.panel[0];
    assert_non_null(strstr(panel->label[1], "{/:Italic ω}"));
    assert_non_null(strstr(panel->label[0], "largest impact speed"));
    assert_true(panel->logarithmic[0] && panel->logarithmic[1] && panel->range[0][0] > 0);
    for (int k = 1; k < 30; k++) {
        const double from[2] = {height(SALTUS_SHOW_SPEED, &made.point[k - 1]), made.point[k - 1].value[0]},
                     to[2] = {height(SALTUS_SHOW_SPEED, &made.point[k]), made.point[k].value[0]};
        int pieces[3];
        count_pieces(panel, from, to, pieces);
        assert_int_equal(pieces[solid] + pieces[dashed], 1);
    }
    double least = panel->range[0][0], largest = panel->range[0][1];
    figure_free(&f);
    /* A speed that is only rounding does not stretch its axis. */
    for (int k = 0; k < made.point[3].event_count; k++)
        made.point[3].events[k].velocity_before = 1e-17;
    write_branch("b.h5");
    f = draw(&how);
    assert_true(f.panel[0].range[0][0] < least && f.panel[0].range[0][0] > 1e-12 * largest);
    figure_free(&f);
    make_branch();
    write_branch("b.h5");
    how.look.logarithmic = keys + 2;
    how.look.logarithmic_count = 1;
    assert_int_equal(saltus_plot(path_in("b.svg", out), paths, 1, &how, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "displacement: the figure shows omega and speed"));
    how.show = SALTUS_SHOW_DISPLACEMENT;
    for (int k = 0; k < points; k++)
        made.state[k][0] -= 1;
    write_branch("b.h5");
    assert_int_equal(saltus_plot(path_in("b.svg", out), paths, 1, &how, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "positive"));
}

/* The kept script is the one drawn, and names the figure. */
static void scripts_are_kept(void **state) {
    (void)state;
    char kept[path_size], drawn[path_size];
    size_t own, other;
    saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    write_branch("b.h5");
    how.look.script = path_in("kept.gp", kept);
    figure f = draw(&how);
    figure_free(&f);
    how.look.script = NULL;
    char *script = read_all(kept, &own);
    saltus_message message = {.text = ""};
    char path[path_size], out[path_size];
    const char *const paths[] = {path_in("b.h5", path)};
    check_ok(saltus_plot(path_in("b.svg", out), paths, 1, &how, &message), &message);
    char *plain = read_all(path_in("script", drawn), &other);
    const char *named = strstr(script, "set output 'b.svg'\n");
    assert_non_null(named);
    assert_int_equal(own, other + strlen("set output 'b.svg'\n"));
    assert_memory_equal(script, plain, (size_t)(named - script));
    assert_string_equal(named + strlen("set output 'b.svg'\n"), plain + (named - script));
    remove(drawn);
    free(script);
    free(plain);
    how.look.script = "kept.txt";
    assert_int_equal(saltus_plot(out, paths, 1, &how, &message), SALTUS_BAD_INPUT);
}

/* The speed of a grazing impact, a rounding error, does not stretch a logarithmic axis, and its mark, below
 * the panel, has no name; orbits without impacts, which it does not reach, are counted; an end at a Hopf
 * point has the mark of that alone. */
static void marks_that_say_nothing_are_left_out(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    made.point[20].kind = SALTUS_POINT_GR;
    made.event[20][0].velocity_before = made.event[20][1].velocity_before = 1e-13;
    made.point[10].event_count = made.point[11].event_count = 0;
    made.point[28].kind = SALTUS_POINT_HB;
    made.point[29].kind = SALTUS_POINT_EP;
    made.point[29].value[0] = made.point[28].value[0];
    set_parameter(&made.point[29].spec, "omega", made.point[29].value[0]);
    write_branch("b.h5");
    how.look.logarithmic = (const char *const[]){"speed"};
    how.look.logarithmic_count = 1;
    figure f = draw(&how);
    const figure_panel *panel = &f.panel[0];
    assert_true(panel->logarithmic[1] && panel->range[1][0] > 0.1 && panel->range[1][1] < 10);
    assert_null(figure_mark_of(panel, 'a', "nohead", 0));
    assert_non_null(figure_mark_of(panel, 'l', "at or below 0, so not shown: 2", 0));
    for (int k = 0; k < panel->mark_count; k++)
        assert_true(panel->mark[k].kind != 'l' || strcmp(panel->mark[k].text, "GR") != 0);
    assert_non_null(figure_element_of(panel, "'HB  Hopf'", 0));
    assert_null(figure_element_of(panel, "'EP  end'", 0));
    assert_null(figure_element_of(panel, "'GR  grazing'", 0));
    figure_free(&f);
}

/* Where another impact becomes the largest the curve of the largest has a corner: it is nowhere below both
 * impacts. */
static void the_largest_of_two_has_a_corner(void **state) {
    (void)state;
    const saltus_plot_options how = saltus_plot_defaults();
    make_branch();
    for (int k = 0; k < points; k++) {
        const double along = k % 30 / 29.0;
        made.point[k].value[0] = 1 + along;
        set_parameter(&made.point[k].spec, "omega", made.point[k].value[0]);
        for (int e = 0; e < 2; e++)
            made.event[k][e].velocity_before = e ? -(0.1 + along * along) : 1.1 - along * (1.5 - 0.4 * along);
    }
    write_branch("b.h5");
    figure f = draw(&how);
    int arcs = 0;
    for (int e = 0; e < f.panel[0].element_count; e++) {
        const figure_element *line = &f.panel[0].element[e];
        for (int k = 0; k < line->values.count && strstr(line->text, "$curve"); k++) {
            const double along = line->values.at[k][0] - 1, other = 0.1 + along * along,
                         first = 1.1 - along * (1.5 - 0.4 * along);
            assert_true(line->values.at[k][1] > fmax(first, other) - 2e-3);
            arcs++;
        }
    }
    assert_true(arcs > 60);
    figure_free(&f);
}

/* A name on a curve is on its own alone: where an unstable motion lies on a stable one of another label, and
 * where curves cross, neither name is. */
static void names_on_curves_are_where_no_other_curve_is(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    how.show = SALTUS_SHOW_DISPLACEMENT;
    make_branch();
    for (int k = 0; k < points; k++) {
        const double along = k % 30 / 29.0;
        /* A line, one that lies on it but for its last part, and one that crosses both in their middle. */
        made.point[k].value[0] = 1 + along;
        made.state[k][0] = k < 30 ? 0.5 : k < 60 ? 0.5 + fmax(0, along - 0.7) : 0.5 + 0.8 * (along - 0.5);
        made.point[k].stable = k < 30;
        snprintf(made.point[k].label, sizeof made.point[k].label, "%d/1", 7 + k / 30);
        set_parameter(&made.point[k].spec, "omega", made.point[k].value[0]);
    }
    write_branch("b.h5");
    figure f = draw(&how);
    const figure_panel *panel = &f.panel[0];
    int names = 0;
    for (int m = 0; m < panel->mark_count; m++) {
        const figure_mark *label = &panel->mark[m];
        double at[2];
        if (label->kind != 'l' || label->system[0][0] != 'g')
            continue;
        place_of(panel, label, at);
        const int own = label->text[0] - '7';
        double least[3] = {INFINITY, INFINITY, INFINITY};
        for (int k = 0; k < points; k++)
            least[k / 30] =
                fmin(least[k / 30],
                     hypot((made.point[k].value[0] - at[0]) / (panel->range[0][1] - panel->range[0][0]),
                           (made.state[k][0] - at[1]) / (panel->range[1][1] - panel->range[1][0])));
        for (int k = 0; k < 3; k++)
            assert_true(k == own || least[k] > least[own] + 0.005);
        names++;
    }
    assert_int_equal(names, 3);
    figure_free(&f);
}

/* Files that differ in the sides of a stop are told apart by them, equal systems by their order. */
static void files_are_told_apart(void **state) {
    (void)state;
    const char *const names[] = {"a.h5", "b.h5", "c.h5"};
    saltus_plot_options how = saltus_plot_defaults();
    for (int equal = 0; equal < 2; equal++) {
        make_branch();
        write_branch("a.h5");
        write_branch("b.h5");
        for (int k = 0; k < points && !equal; k++)
            for (int e = 0; e < events_most; e++)
                made.event[k][e].face = 0;
        if (!equal)
            made.scene.spec.stops[0].sides = SALTUS_LOWER;
        write_branch("c.h5");
        figure f = draw_files(names, 3, &how);
        static const char *const words[2][3] = {
            {", both sides, file 1'", ", both sides, file 2'", ", lower'"},
            {"made\\_up, file 1'", "made\\_up, file 2'", "made\\_up, file 3'"}};
        for (int k = 0; k < 3; k++)
            assert_non_null(figure_element_of(&f.panel[0], words[equal][k], 0));
        char caption[8000];
        figure_caption(&f, caption, sizeof caption);
        assert_true((strstr(caption, "where nothing else is said") != NULL) == !equal);
        figure_free(&f);
    }
}

/* A name too long for the page has several lines in the legend, which has their rows. */
static void long_names_have_several_lines(void **state) {
    (void)state;
    const char *const names[] = {"a.h5", "b.h5"};
    saltus_plot_options how = saltus_plot_defaults();
    for (int size = 0; size < 3; size++) {
        how.look.width = size == 0 ? 85 : size == 1 ? 175 : 0;
        make_branch();
        write_branch("a.h5");
        set_parameter(&made.scene.spec, "c", 0.375123);
        set_parameter(&made.scene.spec, "k", 1.751234);
        set_parameter(&made.scene.spec, "F", 1.51236);
        made.scene.spec.stops[0].r = 0.512345;
        write_branch("b.h5");
        figure f = draw_files(names, 2, &how);
        const figure_panel *panel = &f.panel[0];
        static const char *const words[] = {"{/:Italic c} = 0.375123", "{/:Italic k} = 1.75123",
                                            "{/:Italic F} = 1.51236", "{/:Italic r} = 0.512345"};
        for (int k = 0; k < 4; k++)
            assert_non_null(figure_element_of(panel, words[k], 0));
        const double page = size == 2 ? 1600 : how.look.width / (8 * 25.4 / 72 * 3 / 52);
        for (int e = 0; e < panel->element_count; e++)
            assert_true(saltus_page_width(panel->element[e].title, 11.375) < page - 60);
        assert_true((figure_element_of(panel, "nodraw", 0) != NULL) == (size == 0));
        check_rows_of_legend(panel, 1);
        figure_free(&f);
    }
}

/* A heading that hardly fits keeps its last letter on its line. */
static void headings_have_one_line(void **state) {
    (void)state;
    saltus_plot_options how = saltus_plot_defaults();
    how.look.width = 85;
    for (int letters = 2; letters < 26; letters++) {
        make_branch();
        memset(made.scene.name, 'n', (size_t)letters);
        made.scene.name[letters] = '\0';
        write_branch("b.h5");
        figure f = draw(&how);
        const figure_mark *heading = figure_mark_of(&f.panel[0], 'l', "Bold ", 0),
                          *rest = figure_mark_of(&f.panel[0], 'l', "Bold ", 1);
        const double size = strtod(strstr(heading->text, "{/=") + 3, NULL);
        assert_true(size >= 12.8 && size <= 16);
        assert_true(12 + 1.15 * saltus_page_width(heading->text, size) < 522);
        assert_true(!rest || saltus_line_width(rest->text) > 3);
        figure_free(&f);
    }
}

/* The legend names the strokes that occur and no others, and an end that lies under another mark has none. */
static void the_legend_names_only_what_occurs(void **state) {
    (void)state;
    static const char *const titles[] = {"'stable'", "'unstable'", "'not admissible'"};
    saltus_plot_options how = saltus_plot_defaults();
    for (int kind = 0; kind < 3; kind++)
        for (int joined = 0; joined < 2; joined++) {
            make_branch();
            for (int k = 0; k < points; k++) {
                made.point[k].stable = kind == 0;
                made.point[k].admissible = kind < 2;
            }
            made.point[35].kind = SALTUS_POINT_GR;
            made.point[89].kind = SALTUS_POINT_EP;
            if (joined) {
                made.point[89].value[0] = made.point[35].value[0];
                set_parameter(&made.point[89].spec, "omega", made.point[89].value[0]);
            }
            write_branch("b.h5");
            figure f = draw(&how);
            for (int title = 0; title < 3; title++)
                assert_true((figure_element_of(&f.panel[0], titles[title], 0) != NULL) == (title == kind));
            assert_true((figure_element_of(&f.panel[0], "'EP  end'", 0) != NULL) == !joined);
            check_rows_of_legend(&f.panel[0], 8);
            figure_free(&f);
        }
}

/* Every mark has a name or is counted above the panel, but for those at a mark of the same kind. */
static void marks_without_a_name_are_counted(void **state) {
    (void)state;
    static const saltus_point_kind list[] = {SALTUS_POINT_LP, SALTUS_POINT_PD, SALTUS_POINT_GR,
                                             SALTUS_POINT_NS};
    const double near = 0.8 * 20.2; /* units */
    saltus_plot_options how = saltus_plot_defaults();
    int counted = 0, whole = 0;
    how.show = SALTUS_SHOW_DISPLACEMENT;
    for (int apart = 1; apart <= 12; apart++)
        for (int size = 0; size < 3; size++) {
            make_branch();
            for (int k = 2, n = 0; k < points - 1; k += apart, n++)
                made.point[k].kind = list[n % 4];
            write_branch("b.h5");
            how.look.width = size == 0 ? 0 : size == 1 ? 85 : 175;
            figure f = draw(&how);
            const figure_panel *panel = &f.panel[0];
            const double page = size == 0 ? 1600 : how.look.width / (8 * 25.4 / 72 * 3 / 52);
            double height = 0;
            assert_true(sscanf(strstr(f.terminal, "size "), "size %*f,%lf", &height) == 1);
            const char *note = "";
            for (int m = 0; m < panel->mark_count; m++)
                if (strncmp(panel->mark[m].text, "no room to name:", 16) == 0) {
                    note = panel->mark[m].text;
                    assert_true(panel->mark[m].place[0][1] > panel->frame[3]);
                    assert_true(panel->mark[m].place[0][0] * page - saltus_page_width(note, 9) > 0);
                }
            int all = 0, named = 0;
            for (int kind = 0; kind < 4; kind++) {
                const char *word = saltus_point_word(list[kind]), *told;
                char sought[16];
                int own = 0, count = 0, names = 0;
                for (int k = 0; k < points; k++) {
                    bool again = made.point[k].kind != list[kind];
                    for (int other = 0; other < k && !again; other++)
                        again = made.point[other].kind == list[kind] &&
                                hypot((made.point[k].value[0] - made.point[other].value[0]) * page *
                                          (panel->frame[1] - panel->frame[0]) /
                                          (panel->range[0][1] - panel->range[0][0]),
                                      (made.state[k][0] - made.state[other][0]) * height *
                                          (panel->frame[3] - panel->frame[2]) /
                                          (panel->range[1][1] - panel->range[1][0])) < near;
                    own += !again;
                }
                for (int m = 0; m < panel->mark_count; m++)
                    names += panel->mark[m].kind == 'l' && strcmp(panel->mark[m].text, word) == 0;
                snprintf(sought, sizeof sought, " %s", word);
                for (told = strstr(note, sought); told && told > note && told[-1] >= '0' && told[-1] <= '9';)
                    told--;
                count = told ? atoi(told) : 0;
                if (strstr(note, " mark")) /* only their sum is told */
                    assert_true(names <= own);
                else
                    assert_int_equal(names + count, own);
                all += own;
                named += names;
            }
            if (strstr(note, " mark"))
                assert_int_equal(atoi(strchr(note, ':') + 1), all - named);
            counted += *note != '\0';
            whole += *note == '\0';
            figure_free(&f);
        }
    assert_true(counted > 3 && whole > 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_are_the_rows_of_the_file),
        cmocka_unit_test(impacts_are_curves_of_their_own),
        cmocka_unit_test(special_points_are_marked_at_their_rows),
        cmocka_unit_test(the_legend_explains_what_there_is),
        cmocka_unit_test(names_stand_on_their_stretches),
        cmocka_unit_test(names_do_not_lie_on_each_other),
        cmocka_unit_test(names_are_nearest_to_their_own_marks),
        cmocka_unit_test(marks_that_say_nothing_are_left_out),
        cmocka_unit_test(the_largest_of_two_has_a_corner),
        cmocka_unit_test(names_on_curves_are_where_no_other_curve_is),
        cmocka_unit_test(crowded_marks_have_their_names),
        cmocka_unit_test(files_over_each_other_have_their_own_colour),
        cmocka_unit_test(longer_names_are_other_parameters),
        cmocka_unit_test(zero_has_an_axis),
        cmocka_unit_test(loci_are_solid_where_they_bound_stable_orbits),
        cmocka_unit_test(planes_turn_and_clip),
        cmocka_unit_test(long_names_leave_room_for_fewer),
        cmocka_unit_test(tips_have_their_names_beyond_them),
        cmocka_unit_test(other_structures_have_other_pages),
        cmocka_unit_test(no_more_than_four_hundred_names),
        cmocka_unit_test(requested_names_are_legible),
        cmocka_unit_test(kinds_of_loci_have_their_own_colours),
        cmocka_unit_test(branches_lie_over_clouds),
        cmocka_unit_test(special_points_lie_over_maps),
        cmocka_unit_test(dashes_do_not_fill_each_other),
        cmocka_unit_test(dashes_end_where_others_begin),
        cmocka_unit_test(sparse_points_give_smooth_curves),
        cmocka_unit_test(pages_have_the_size_asked_for),
        cmocka_unit_test(axes_are_laid_out_as_asked),
        cmocka_unit_test(scripts_are_kept),
        cmocka_unit_test(the_legend_names_only_what_occurs),
        cmocka_unit_test(headings_have_one_line),
        cmocka_unit_test(files_are_told_apart),
        cmocka_unit_test(long_names_have_several_lines),
        cmocka_unit_test(marks_without_a_name_are_counted),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
