/* A sweep can be resumed only by the same sweep: everything on which its results depend is changed in turn,
 * and the message names what differs, with both values.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"
#include "made_sweep.h"

#include <unistd.h>

static const double clearances[] = {0.5, 0.25, 1.75};

/* A sweep's definition before it is created. */
typedef struct recipe {
    saltus_scene scene;
    saltus_axis axes[2];
    double list[3];
    int axis_count;
    saltus_sweep_options options;
    bool basins;
} recipe;

static void write_down(recipe *r, const char *model) {
    *r = (recipe){.scene = {.name = "made", .initial_count = 4}, .axis_count = 2};
    bool pipe = strcmp(model, "pipe") == 0;
    r->scene.spec = saltus_spec_defaults(saltus_model_find(model));
    set_parameter(&r->scene.spec, "N", 2);
    for (int s = 0; s < 2; s++) {
        add_stop(&r->scene.spec, 1 + s, 0.75 - 0.25 * s, s ? SALTUS_LOWER : SALTUS_UPPER);
        r->scene.spec.stops[s].xi = 0.25 + 0.5 * s;
        if (!pipe)
            r->scene.spec.stops[s].weight[1] = -0.5 * s - 0.5;
    }
    memcpy(r->list, clearances, sizeof clearances);
    r->axes[0] =
        (saltus_axis){.key = "omega", .spacing = SALTUS_LOGARITHMIC, .count = 4, .low = 30, .high = 40};
    r->axes[1] = (saltus_axis){.key = "d1", .spacing = SALTUS_LIST, .count = 3, .low = 0.5, .high = 1.75};
    r->options = saltus_sweep_defaults();
    r->options.keep = SALTUS_KEEP_TURNING;
    r->options.seeds = 2;
}

static saltus_sweep *make(recipe *r) {
    saltus_message message;
    saltus_sweep *sweep = NULL;
    r->axes[1].list = r->axes[1].spacing == SALTUS_LIST ? r->list : NULL;
    check_ok(saltus_sweep_new(&r->scene, r->axes, r->axis_count, &r->options, &sweep, &message), &message);
    return sweep;
}

static void fill(made_place *m) {
    for (int s = 0; s < m->seeds; s++)
        m->row[s] = made_periodic(1, 1);
}

static void check_difference(recipe *changed, const char *const path[2], const char *name) {
    saltus_sweep *sweep = make(changed);
    for (int k = 0; k < 2; k++) {
        saltus_message message = {.text = ""};
        saltus_sweep_output *output = NULL;
        char there[301] = "", now[301] = "";
        assert_int_equal(
            saltus_sweep_output_open(path[k], sweep, changed->basins, true, NULL, &output, &message),
            SALTUS_BAD_INPUT);
        const char *at = strstr(message.text, ": is of another sweep: ");
        if (!at || strncmp(at + 23, name, strlen(name)) != 0)
            fail_msg("'%s' does not name %s", message.text, name);
        at += 23 + strlen(name);
        if (strcmp(at, " is not among its entries") == 0)
            continue;
        if (sscanf(at, " is %300[^\n]", there) != 1 || !strstr(there, " there and "))
            fail_msg("'%s' does not say what differs", message.text);
        char *middle = strstr(there, " there and ");
        snprintf(now, sizeof now, "%.*s", (int)strlen(middle + 11) - 4, middle + 11);
        assert_string_equal(middle + strlen(middle) - 4, " now");
        *middle = '\0';
        if (strcmp(there, now) == 0)
            fail_msg("'%s' tells no difference", message.text);
    }
    saltus_sweep_free(sweep);
}

/* A numeric entry; the message has both values. */
static void check_numbers(recipe *changed, const char *const path[2], const char *name, double there,
                          double now) {
    char words[160];
    snprintf(words, sizeof words, "%s is %.17g there and %.17g now", name, there, now);
    saltus_sweep *sweep = make(changed);
    for (int k = 0; k < 2; k++) {
        saltus_message message = {.text = ""};
        saltus_sweep_output *output = NULL;
        assert_int_equal(
            saltus_sweep_output_open(path[k], sweep, changed->basins, true, NULL, &output, &message),
            SALTUS_BAD_INPUT);
        if (!strstr(message.text, words))
            fail_msg("'%s' instead of '%s'", message.text, words);
    }
    saltus_sweep_free(sweep);
}

typedef struct place {
    char folder[32], path[2][64];
} place;

/* An unfinished sweep with its journal, and a finished one. */
static void write_both(place *p, const char *model) {
    recipe r;
    strcpy(p->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(p->folder));
    write_down(&r, model);
    r.axes[1].list = r.list;
    for (int k = 0; k < 2; k++) {
        snprintf(p->path[k], sizeof p->path[k], "%s/%d.h5", p->folder, k);
        made_write(p->path[k], &r.scene, r.axes, 2, &r.options, fill, k ? 1000 : 3);
    }
}

static void clear(place *p) {
    assert_int_equal(folder_files(p->folder, true), 3);
    rmdir(p->folder);
}

static void every_choice_tells_sweeps_apart(void **state) {
    (void)state;
    place p;
    recipe r;
    write_both(&p, "oscillator");
    const char *const path[] = {p.path[0], p.path[1]};
    write_down(&r, "oscillator");
    const saltus_sweep_options o = r.options;
#define CHANGED(statement) (write_down(&r, "oscillator"), (statement), &r)
    check_difference(CHANGED(r.options.passes |= 1u << SALTUS_PASS_UP), path, "passes");
    check_numbers(CHANGED(r.options.seeds++), path, "seeds", o.seeds, o.seeds + 1);
    check_numbers(CHANGED(r.options.seed += 3), path, "seed", (double)o.seed, (double)o.seed + 3);
    check_difference(CHANGED(r.options.keep = 0), path, "keep (--what)");
    check_difference(CHANGED(r.options.keep = SALTUS_KEEP_IMPACTS), path, "keep (--what)");
    check_difference(CHANGED(r.options.adaptive = !r.options.adaptive), path, "adaptive");
    check_numbers(CHANGED(r.options.transient++), path, "transient (--at-most)", (double)o.transient,
                  (double)o.transient + 1);
    check_numbers(CHANGED(r.options.record++), path, "record", (double)o.record, (double)o.record + 1);
    check_numbers(CHANGED(r.options.measure += 500), path, "measure", (double)o.measure,
                  (double)o.measure + 500);
    check_numbers(CHANGED(r.options.longest--), path, "longest", o.longest, o.longest - 1);
    check_numbers(CHANGED(r.options.flow.rtol *= 2), path, "rtol", o.flow.rtol, 2 * o.flow.rtol);
    check_numbers(CHANGED(r.options.flow.atol *= 2), path, "atol", o.flow.atol, 2 * o.flow.atol);
    check_difference(CHANGED(r.options.flow.integrator = SALTUS_RADAU), path, "integrator");
    check_difference(CHANGED(r.options.flow.integrator = SALTUS_TAYLOR), path, "integrator");
    check_numbers(CHANGED(r.options.flow.order = 12), path, "order", o.flow.order, 12);
    check_difference(CHANGED(r.axes[0].spacing = SALTUS_LINEAR), path, "omega spacing");
    check_numbers(CHANGED(r.axes[0].count--), path, "omega values", 4, 3);
    check_numbers(CHANGED(r.axes[0].low = 29), path, "omega value 1", 30, 29);
    check_numbers(CHANGED(r.axes[0].high = 41), path, "omega value 4", 40, 41);
    check_difference(CHANGED(strcpy(r.axes[0].key, "k")), path, "axis 1");
    check_difference(CHANGED(strcpy(r.axes[1].key, "d2")), path, "axis 2");
    for (int k = 0; k < 3; k++) {
        char name[32];
        snprintf(name, sizeof name, "d1 value %d", k + 1);
        check_numbers(CHANGED(r.list[k] = 0.625), path, name, clearances[k], 0.625);
    }
    check_numbers(CHANGED(r.axes[1].count = 2), path, "d1 values", 3, 2);
    check_numbers(CHANGED(r.axis_count = 1), path, "axes", 2, 1);
    for (int k = 0; k < 4; k++) {
        char name[32];
        snprintf(name, sizeof name, "initial entry %d", k + 1);
        check_numbers(CHANGED(r.scene.initial[k] = 0.125), path, name, 0, 0.125);
    }
    check_numbers(CHANGED(r.scene.initial_count = 0), path, "initial entries", 4, 0);
#undef CHANGED
    clear(&p);
}

static void every_parameter_tells_sweeps_apart(void **state) {
    static const char *const models[] = {"oscillator", "pipe"};
    (void)state;
    for (int m = 0; m < 2; m++) {
        place p;
        recipe r;
        int count;
        write_both(&p, models[m]);
        const char *const path[] = {p.path[0], p.path[1]};
        const saltus_parameter *table = saltus_model_parameters(saltus_model_find(models[m]), &count);
        for (int k = 0; k < count; k++) {
            write_down(&r, models[m]);
            double before = r.scene.spec.parameters[k];
            r.scene.spec.parameters[k] = table[k].integer ? 1 : 0.5 * before + 0.125;
            if (strcmp(table[k].name, "kz") == 0 || table[k].integer)
                r.scene.initial_count = 0;
            if (table[k].integer && m == 0)
                r.scene.spec.stops[0].weight[1] = r.scene.spec.stops[1].weight[1] = 0;
            if (table[k].integer && m == 0)
                r.scene.spec.stops[1].weight[0] = 2;
            check_numbers(&r, path, table[k].name, before, r.scene.spec.parameters[k]);
        }
        for (int s = 0; s < 2; s++)
            for (int change = 0; change < 5; change++) {
                char name[16];
                write_down(&r, models[m]);
                saltus_stop *stop = &r.scene.spec.stops[s];
                stop->d += change == 0 ? 0.25 : 0;
                stop->r -= change == 1 ? 0.125 : 0;
                stop->sides = change == 2 ? SALTUS_BOTH : stop->sides;
                stop->xi += change == 3 && m == 1 ? 0.125 : 0;
                stop->weight[0] += change == 3 && m == 0 ? 0.125 : 0;
                stop->weight[1] += change == 4 && m == 0 ? 0.125 : 0;
                if (change == 4 && m == 1)
                    continue;
                snprintf(name, sizeof name, "stop %d", s + 1);
                check_difference(&r, path, name);
            }
        write_down(&r, models[m]);
        r.scene.spec.stop_count = 1;
        check_numbers(&r, path, "stops", 2, 1);
        write_down(&r, models[1 - m]);
        check_difference(&r, path, "model");
        clear(&p);
    }
}

/* A sweep of basins is a different sweep, and so is one over fewer initial values. */
static void basins_are_another_kind(void **state) {
    (void)state;
    place p;
    recipe r;
    strcpy(p.folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(p.folder));
    for (int k = 0; k < 2; k++) {
        write_down(&r, "oscillator");
        r.options.keep = 0;
        r.options.seeds = 1;
        r.axes[0] =
            (saltus_axis){.key = "q1", .spacing = SALTUS_LINEAR, .count = 3, .low = -0.5, .high = 0.5};
        r.axes[1] = (saltus_axis){.key = "v1", .spacing = SALTUS_LINEAR, .count = 2, .low = -1, .high = 1};
        snprintf(p.path[k], sizeof p.path[k], "%s/%d.h5", p.folder, k);
        made_write(p.path[k], &r.scene, r.axes, 2, &r.options, fill, k ? 1000 : 3);
    }
    const char *const path[] = {p.path[0], p.path[1]};
    r.basins = true;
    check_difference(&r, path, "kind");
    r.basins = false;
    r.axes[1].count = 1;
    r.axes[1].high = -1;
    check_difference(&r, path, "v1 values");
    clear(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_choice_tells_sweeps_apart),
        cmocka_unit_test(every_parameter_tells_sweeps_apart),
        cmocka_unit_test(basins_are_another_kind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
