/* The printed table of a branch's special points, from made-up branches: a line with numbers for each, a
 * heading where a branch begins. Also a point's JSON, field by field.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "json.h"
#include "text_lines.h"

enum { most = 24, dimension = 4 };

typedef struct made {
    saltus_branch_file file;
    saltus_branch_point point[most];
    saltus_multiplier multiplier[most][dimension];
    double state[most][dimension];
    saltus_event event[most][2];
    saltus_scene scene;
    saltus_system *system;
} made;

static saltus_multiplier multiplier(double re, double im) {
    return (saltus_multiplier){re, im, log(hypot(re, im))};
}

static void make(made *m, saltus_point_kind locus) {
    *m = (made){.scene = {.name = "made"}};
    m->scene.spec = oscillator_spec(0.125, 2.5, 1, 1.75);
    set_parameter(&m->scene.spec, "N", 2);
    add_stop(&m->scene.spec, 0.375, 0.625, SALTUS_BOTH);
    m->system = build(&m->scene.spec);
    m->file = (saltus_branch_file){.dimension = dimension, .points = m->point, .point_count = most};
    m->file.options.locus = locus;
    strcpy(m->file.options.key[0], "omega");
    strcpy(m->file.options.key[1], locus ? "d" : "");
    for (int k = 0; k < most; k++) {
        saltus_branch_point *p = &m->point[k];
        *p = (saltus_branch_point){.kind = k % 2 ? (saltus_point_kind)(1 + k / 2 % (SALTUS_POINT_KINDS - 1))
                                                 : SALTUS_POINT_REGULAR,
                                   .locus = locus,
                                   .branch = k < 7    ? 0
                                             : k < 15 ? 1
                                                      : 2,
                                   .parent = k < 15 ? -1 : 1,
                                   .step = 100 + k,
                                   .arclength = 0.25 * k,
                                   .value = {1.5 + 0.0625 * k, locus ? 0.375 + 0.03125 * k : NAN},
                                   .heading = k < 7 ? 0.5 : -0.75,
                                   .spec = m->scene.spec,
                                   .periods = 3 + k,
                                   .impacts = k == 4 ? -1 : 50 + k,
                                   .sticking_intervals = k % 5,
                                   .dimension = dimension,
                                   .multiplier_count = dimension,
                                   .state = m->state[k],
                                   .events = m->event[k],
                                   .event_count = k % 3,
                                   .multipliers = m->multiplier[k],
                                   .unstable = k % 4,
                                   .stable = k % 3 == 0,
                                   .admissible = k % 5 != 0,
                                   .residual = 1e-13 * (k + 1),
                                   .iterations = 2 + k,
                                   .log_volume = -1.5 - k,
                                   .sum_rule = -1.25 - k,
                                   .accuracy = k % 4 == 1 ? 2e-5 * (k + 1) : 1e-12,
                                   .grazing_time = NAN,
                                   .contact_force = k % 5 == 2 ? 600.5 + k : NAN};
        if (p->kind == SALTUS_POINT_GR) {
            p->grazing_time = 0.03125 * k;
            p->grazing_stop = 1;
            p->grazing_side = locus ? -1 : 1;
        }
        snprintf(p->label, sizeof p->label, "%d/%d", 50 + k, 3 + k);
        if (k % 6 == 1)
            snprintf(p->label_after, sizeof p->label_after, "%d/%d", 80 + k, 3 + k);
        if (k % 6 == 3)
            strcpy(p->label_after, p->label);
        if (k % 4 == 3 || k == 6)
            snprintf(p->reason, sizeof p->reason, "reason %d", 900 + k);
        m->multiplier[k][0] = multiplier(-0.75 - k, 0);
        m->multiplier[k][1] = multiplier(k % 8 < 4 ? 0.5625 : 0.4375, 0);
        m->multiplier[k][2] = multiplier(0.25, 0);
        m->multiplier[k][3] = multiplier(0.75, 0);
        if (k % 8 >= 6) {
            m->multiplier[k][0] = multiplier(0.5, 1.5 + k);
            m->multiplier[k][1] = multiplier(0.5, -1.5 - k);
        }
        for (int i = 0; i < dimension; i++)
            m->state[k][i] = 0.01 * k + i;
        for (int i = 0; i < 2; i++)
            m->event[k][i] = (saltus_event){.kind = i ? SALTUS_STICK : SALTUS_IMPACT,
                                            .face = (k + i) % 2,
                                            .time = {i, 0.125 * (k % 7)},
                                            .velocity_before = 1.5 + k,
                                            .velocity_after = -0.5 - k};
    }
}

/* The numbers of a line in order, in `list`; returns how many. */
static int numbers_of(const made *m, int k, double *list) {
    const saltus_branch_point *p = &m->point[k];
    bool locus = m->file.options.locus != SALTUS_POINT_REGULAR;
    int count = 0;
    list[count++] = p->value[0];
    if (p->accuracy > 1e-11 * fabs(p->value[0]))
        list[count++] = p->accuracy;
    if (locus)
        list[count++] = p->value[1];
    list[count++] = 50 + k;
    list[count++] = 3 + k;
    if (p->label_after[0] && k % 6 == 1) {
        list[count++] = 80 + k;
        list[count++] = 3 + k;
    }
    if (p->kind != SALTUS_POINT_GR && m->file.options.locus != SALTUS_POINT_GR) {
        const saltus_multiplier *u = m->multiplier[k];
        list[count++] = u[0].re;
        if (u[0].im != 0)
            list[count++] = u[0].im;
        else if (u[1].re > 0.5)
            list[count++] = u[1].re;
    }
    if (p->reason[0])
        list[count++] = 900 + k;
    if (!isnan(p->contact_force) && !p->label_after[0])
        list[count++] = p->contact_force;
    return count;
}

static void special_points_are_listed(void **state) {
    static const saltus_point_kind loci[] = {SALTUS_POINT_REGULAR, SALTUS_POINT_PD, SALTUS_POINT_GR};
    (void)state;
    for (int l = 0; l < 3; l++) {
        static made m;
        text_lines lines;
        make(&m, loci[l]);
        bool locus = loci[l] != SALTUS_POINT_REGULAR;
        int remarked = 0;
        lines_open(&lines);
        saltus_write_branch_text(lines.stream, &m.file);
        lines_read(&lines);
        assert_null(strstr(lines.text, " \n"));
        lines_next(&lines, "row", locus ? "label  omega           d  " : "label  omega           n/p", -1);
        assert_int_equal(strstr(lines.text, "beyond") != NULL, !locus);
        for (int k = 0; k < most; k++) {
            const saltus_branch_point *p = &m.point[k];
            char head[64];
            if (k == 0 || p->branch != p[-1].branch) {
                snprintf(head, sizeof head, "branch %d, %s%sfrom omega = ", p->branch,
                         p->parent >= 0 ? "off branch 1, " : "",
                         p->parent >= 0 || locus ? ""
                         : k                     ? "down "
                                                 : "up ");
                if (locus)
                    lines_next(&lines, head, l == 1 ? ": PD of " : ": GR of ", 4, p->value[0], p->value[1],
                               50. + k, 3. + k);
                else
                    lines_next(&lines, head, p->stable ? ", stable" : ", unstable", 3, p->value[0], 50. + k,
                               3. + k);
            }
            if (p->kind == SALTUS_POINT_REGULAR ? !p->reason[0] : p->kind == loci[l])
                continue;
            remarked += p->kind == SALTUS_POINT_REGULAR;
            snprintf(head, sizeof head, "%d  %-5s  ", k + 1, saltus_point_word(p->kind));
            double list[9] = {0};
            int count = numbers_of(&m, k, list);
            char line[700];
            snprintf(line, sizeof line, "%.*s", (int)strcspn(lines.at, "\n"), lines.at);
            bool told = !locus && k + 1 < most && p[1].branch == p->branch;
            assert_int_equal(strstr(line, "stable") != NULL, told);
            if (told)
                assert_int_equal(strstr(line, "unstable") == NULL, p[1].stable);
            assert_int_equal(strstr(line, " -> ") != NULL, k % 6 == 1);
            assert_int_equal(strstr(line, "i ") != NULL, p->kind != SALTUS_POINT_GR && l < 2 && k % 8 >= 6);
            lines_next(&lines, head, NULL, count, list[0], list[1], list[2], list[3], list[4], list[5],
                       list[6], list[7], list[8]);
        }
        assert_int_equal(remarked, 1);
        lines_end(&lines);
        saltus_system_free(m.system);
    }
}

/* The stability beyond a point is that of a regular or requested point, not of another special point. */
/* Multipliers are listed from the largest on, never cut, as many as fit; omitted ones are indicated. */
static void many_multipliers_are_cut(void **state) {
    (void)state;
    static made m;
    make(&m, SALTUS_POINT_REGULAR);
    for (int pairs = 0; pairs < 2; pairs++)
        for (int count = 1; count < 40; count++) {
            saltus_multiplier list[40] = {{0}};
            saltus_branch_point point = m.point[1];
            text_lines lines;
            point.kind = SALTUS_POINT_LP;
            point.dimension = 40;
            point.multipliers = list;
            point.reason[0] = point.label_after[0] = '\0';
            for (int k = 0; k < 40; k++)
                list[k] = k >= count ? multiplier(0.125, 0)
                          : pairs    ? multiplier(0.9 - 0.001 * (k / 2), k % 2 ? -0.3125 : 0.3125)
                                     : multiplier(0.9995 - 0.001 * k, 0);
            if (pairs && count % 2)
                continue;
            saltus_branch_file file = m.file;
            file.points = &point;
            file.point_count = 1;
            lines_open(&lines);
            saltus_write_branch_text(lines.stream, &file);
            lines_read(&lines);
            const char *at = strstr(lines.text, pairs ? "0.9 +- 0.3125i" : "0.9995");
            assert_non_null(at);
            char whole[1000] = "";
            for (int k = 0; k < count; k += 1 + pairs)
                snprintf(whole + strlen(whole), 40, pairs ? "%s%.4g +- 0.3125i" : "%s%.4g", k ? ", " : "",
                         list[k].re);
            size_t length = strcspn(at, "\n"), kept = strlen(whole);
            const char *dots = strstr(at, ", ...");
            assert_true((dots != NULL) == (kept > 90));
            if (dots)
                kept = (size_t)(dots - at);
            assert_true(kept <= length && strncmp(at, whole, kept) == 0);
            assert_true(whole[kept] == (dots ? ',' : '\0'));
            /* One more would not have fitted. */
            assert_true(!dots || kept + 5 + (pairs ? 17 : 8) > 95);
            free(lines.text);
        }
    saltus_system_free(m.system);
}

static void stability_beyond_needs_a_plain_point(void **state) {
    (void)state;
    static made m;
    make(&m, SALTUS_POINT_REGULAR);
    for (int kind = 0; kind < SALTUS_POINT_KINDS; kind++) {
        m.file.point_count = 2;
        m.point[0].kind = SALTUS_POINT_LP;
        m.point[1].kind = (saltus_point_kind)kind;
        m.point[1].stable = true;
        text_lines lines;
        lines_open(&lines);
        saltus_write_branch_text(lines.stream, &m.file);
        lines_read(&lines);
        lines_next(&lines, "row", NULL, -1);
        lines_next(&lines, "branch", NULL, -1);
        const char *word = strstr(lines.at, " stable");
        assert_int_equal(word && word < lines.at + strcspn(lines.at, "\n"),
                         kind == SALTUS_POINT_REGULAR || kind == SALTUS_POINT_UZ);
        free(lines.text);
    }
    saltus_system_free(m.system);
}

static void a_point_is_told_in_json(void **state) {
    (void)state;
    static made m;
    int touched[2] = {0}, pressed[2] = {0};
    for (int locus = 0; locus < 2; locus++) {
        make(&m, locus ? SALTUS_POINT_PD : SALTUS_POINT_REGULAR);
        for (int k = 0; k < most; k++) {
            const saltus_branch_point *p = &m.point[k];
            text_lines lines;
            lines_open(&lines);
            saltus_write_point_json(lines.stream, &m.scene, m.system, p);
            lines_read(&lines);
            json *o = json_read(lines.text);
            const struct {
                const char *key;
                double value; /* NAN: null */
            } numbers[] = {{"branch", p->branch},
                           {"parent", p->parent < 0 ? NAN : p->parent},
                           {"step", p->step},
                           {"arclength", p->arclength},
                           {"values.0", p->value[0]},
                           {"heading", p->heading},
                           {"periods", p->periods},
                           {"impacts", p->impacts < 0 ? NAN : (double)p->impacts},
                           {"sticking_intervals", p->sticking_intervals},
                           {"unstable", p->unstable},
                           {"residual", p->residual},
                           {"iterations", p->iterations},
                           {"log_volume", p->log_volume},
                           {"sum_rule", p->sum_rule},
                           {"accuracy", p->accuracy},
                           {"state.0", p->state[0]},
                           {"state.3", p->state[3]},
                           {"multipliers.1.0", p->multipliers[1].re},
                           {"multipliers.1.1", p->multipliers[1].im},
                           {"log_moduli.2", p->multipliers[2].log_modulus},
                           {"parameters.omega", saltus_spec_get(&p->spec, "omega")},
                           {"parameters.stops.0.d", p->spec.stops[0].d}};
            for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
                if (isnan(numbers[i].value))
                    assert_int_equal(json_at(o, numbers[i].key)->kind, JSON_NULL);
                else
                    assert_true(json_number_at(o, numbers[i].key) == numbers[i].value);
            const struct {
                const char *key, *text;
            } texts[] = {{"scene", "made"},
                         {"locus", saltus_point_word(p->locus)},
                         {"label", saltus_point_word(p->kind)},
                         {"motion", p->label},
                         {"motion_after", p->label_after},
                         {"reason", p->reason}};
            for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
                assert_string_equal(json_text_at(o, texts[i].key), texts[i].text);
            assert_int_equal(json_count(json_at(o, "values")), 1 + locus);
            assert_true(!locus || json_number_at(o, "values.1") == p->value[1]);
            assert_int_equal(json_count(json_at(o, "state")), dimension);
            assert_int_equal(json_count(json_at(o, "multipliers")), dimension);
            assert_int_equal(json_count(json_at(o, "log_moduli")), dimension);
            assert_int_equal(json_at(o, "stable")->kind, p->stable ? JSON_TRUE : JSON_FALSE);
            assert_int_equal(json_at(o, "admissible")->kind, p->admissible ? JSON_TRUE : JSON_FALSE);
            assert_int_equal(json_count(json_at(o, "events")), p->event_count);
            for (int i = 0; i < p->event_count; i++) {
                char path[32];
                snprintf(path, sizeof path, "events.%d", i);
                const json *e = json_at(o, path);
                const saltus_event *event = &p->events[i];
                assert_string_equal(json_text_at(e, "type"), i ? "stick" : "impact");
                assert_string_equal(json_text_at(e, "event"), i ? "stick" : "impact");
                assert_string_equal(json_text_at(e, "side"), event->face ? "lower" : "upper");
                assert_true(json_number_at(e, "stop") == 1 &&
                            json_number_at(e, "phase") == event->time.phase &&
                            json_number_at(e, "time_over_T") == saltus_time_periods(event->time) &&
                            json_number_at(e, "normal_velocity_before") == event->velocity_before &&
                            json_number_at(e, "normal_velocity_after") == (i ? 0 : event->velocity_after));
            }
            bool presses = !isnan(p->contact_force);
            assert_int_equal(json_at(o, "contact_force")->kind, presses ? JSON_NUMBER : JSON_NULL);
            assert_true(!presses || json_number_at(o, "contact_force") == p->contact_force);
            pressed[locus] += presses;
            bool grazes = p->kind == SALTUS_POINT_GR;
            const json *touch = json_at(o, "grazing");
            assert_int_equal(touch->kind, grazes ? JSON_OBJECT : JSON_NULL);
            if (grazes) {
                assert_true(json_number_at(touch, "time_over_T") == p->grazing_time);
                assert_true(json_number_at(touch, "stop") == p->grazing_stop);
                assert_string_equal(json_text_at(touch, "side"), p->grazing_side > 0 ? "upper" : "lower");
                touched[locus]++;
            }
            json_free(o);
            free(lines.text);
        }
        saltus_system_free(m.system);
        assert_true(touched[locus] > 0 && pressed[locus] > 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(special_points_are_listed),
        cmocka_unit_test(many_multipliers_are_cut),
        cmocka_unit_test(stability_beyond_needs_a_plain_point),
        cmocka_unit_test(a_point_is_told_in_json),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
