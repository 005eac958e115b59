/* A model's description beside its equations: where its stops are, which parameters have an effect, how it is
 * written.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "record/describe.h"
#include "system/system.h"

/* A specification with two degrees of freedom and a stop. */
static saltus_spec with_stop(const saltus_model *model) {
    saltus_spec spec = saltus_spec_defaults(model);
    set_parameter(&spec, "N", 2);
    add_stop(&spec, 0.5, 0.75, SALTUS_UPPER);
    return spec;
}

/* A stop's place is given by exactly the numbers on which its contact coordinate depends. */
static void stops_sit_where_their_key_says(void **state) {
    (void)state;
    for (int m = 0; m < saltus_model_count(); m++) {
        const saltus_model *model = saltus_model_at(m);
        saltus_spec spec = with_stop(model);
        saltus_system *system = build(&spec);
        int count;
        const double *place = saltus_stop_place(model, &spec.stops[0], &count);
        double *const numbers[] = {&spec.stops[0].xi, &spec.stops[0].weight[0], &spec.stops[0].weight[1]};
        int seen = 0;
        for (int k = 0; k < 3; k++) {
            bool placing = numbers[k] >= place && numbers[k] < place + count;
            double before = *numbers[k];
            *numbers[k] += 0.125;
            saltus_system *moved = build(&spec);
            const double *a = saltus_system_stop_normal(system, 0), *b = saltus_system_stop_normal(moved, 0);
            assert_int_equal(a[0] != b[0] || a[1] != b[1], placing);
            *numbers[k] = before;
            seen += placing;
            saltus_system_free(moved);
        }
        assert_int_equal(seen, count);
        saltus_system_free(system);
    }
}

/* The written form of a specification; freed by the caller. */
static char *written(const saltus_spec *spec, bool json) {
    char *text = NULL;
    size_t length;
    FILE *stream = open_memstream(&text, &length);
    if (json) {
        saltus_scene scene = {.name = "made", .spec = *spec};
        saltus_system *system = build(spec);
        saltus_motion motion = {.dimension = 4};
        saltus_write_motion_json(stream, &scene, system, &motion);
        saltus_system_free(system);
    } else
        saltus_put_stop(stream, spec, 0);
    fclose(stream);
    return text;
}

/* A model other than the pipe that places stops in the same way: they are written with xi. */
static void another_model_is_written_by_its_own_key(void **state) {
    (void)state;
    saltus_model beam = saltus_pipe, chain = saltus_oscillator;
    beam.name = "beam";
    chain.name = "chain";
    static const char *const wanted[2][2] = {{"\"xi\": 0.25", "xi = 0.25"},
                                             {"\"weight\": [0.25, -2]", "weight = [0.25, -2]"}};
    static const char *const others[] = {"weight", "xi"};
    for (int m = 0; m < 2; m++)
        for (int form = 0; form < 2; form++) {
            saltus_spec spec = with_stop(m ? &chain : &beam);
            spec.stops[0].xi = spec.stops[0].weight[0] = 0.25;
            spec.stops[0].weight[1] = -2;
            char *text = written(&spec, form == 0);
            assert_non_null(strstr(text, wanted[m][form]));
            assert_null(strstr(text, others[m]));
            free(text);
        }
}

/* The state after a while from the same start, with the k-th parameter multiplied by this factor. */
static void follow(const saltus_spec *spec, int k, double factor, double *end, int *dimension) {
    saltus_spec changed = *spec;
    changed.parameters[k] *= factor;
    saltus_system *system = build(&changed);
    double start[SALTUS_STATE_MAX];
    for (int i = 0; i < SALTUS_STATE_MAX; i++)
        start[i] = 0.01 * (i + 1);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, 0.25, 0);
    *dimension = saltus_system_dimension(system);
    saltus_flow_state(flow, 0, end);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A parameter without effect changes no bit; one with an effect does. */
static void parameters_matter_where_they_say(void **state) {
    (void)state;
    int idle = 0;
    for (int m = 0; m < saltus_model_count(); m++) {
        const saltus_model *model = saltus_model_at(m);
        int count;
        const saltus_parameter *p = saltus_model_parameters(model, &count);
        for (int variant = 0; variant < 4; variant++) {
            saltus_spec spec = saltus_spec_defaults(model);
            for (int k = 0; k < count; k++)
                if (!p[k].integer)
                    spec.parameters[k] = p[k].fallback != 0 ? p[k].fallback : 0.5;
            set_parameter(&spec, "N", 1 + variant % 2);
            if (saltus_model_parameter_index(model, "kz") >= 0)
                set_parameter(&spec, "kz", variant / 2);
            for (int k = 0; k < count; k++) {
                double a[SALTUS_STATE_MAX], b[SALTUS_STATE_MAX];
                int n, same;
                if (p[k].integer || spec.parameters[k] == 0)
                    continue;
                follow(&spec, k, 1, a, &n);
                follow(&spec, k, 1.25, b, &same);
                assert_int_equal(n, same);
                bool equal = memcmp(a, b, (size_t)n * sizeof *a) == 0;
                if (equal == saltus_spec_matters(&spec, k))
                    fail_msg("%s of the model %s, variant %d", p[k].name, saltus_model_name(model), variant);
                idle += equal;
            }
        }
    }
    assert_true(idle > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stops_sit_where_their_key_says),
        cmocka_unit_test(another_model_is_written_by_its_own_key),
        cmocka_unit_test(parameters_matter_where_they_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
