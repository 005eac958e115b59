/* The promises of system.h, map.h and status.h: tables, ranges at their ends, geometry, symmetries, scales,
 * maps and their derivatives, messages of failures.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"
#include "stress_field.h"

#include <gsl/gsl_eigen.h>

static void every_status_has_a_name(void **unused) {
    (void)unused;
    for (int a = SALTUS_INTERRUPTED - 1; a <= 1; a++) {
        assert_non_null(saltus_status_name((saltus_status)a));
        for (int b = SALTUS_INTERRUPTED - 1; b < a; b++)
            if (a <= 0 && b >= SALTUS_INTERRUPTED)
                assert_string_not_equal(saltus_status_name((saltus_status)a),
                                        saltus_status_name((saltus_status)b));
    }
    saltus_message message;
    char longer[700];
    memset(longer, 'x', sizeof longer);
    longer[sizeof longer - 1] = 0;
    assert_int_equal(saltus_fail(&message, SALTUS_IO, "%d of %s", 7, "nine"), SALTUS_IO);
    assert_string_equal(message.text, "7 of nine");
    assert_int_equal(saltus_fail(NULL, SALTUS_SINGULAR, "%d", 7), SALTUS_SINGULAR);
    saltus_fail(&message, SALTUS_IO, "%s", longer);
    assert_int_equal(strlen(message.text), sizeof message.text - 1);
}

/* A message that fits is kept whole; a longer one loses its middle, between two characters. */
static void long_sentences_keep_both_ends(void **unused) {
    static const char *const letters[] = {"x", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x8e\xb5"};
    enum { room = sizeof((saltus_message *)0)->text };
    (void)unused;
    for (size_t l = 0; l < 4; l++)
        for (size_t length = room - 6; length < room + 8; length++) {
            saltus_message message;
            char whole[room + 32] = "";
            size_t step = strlen(letters[l]), from = (length - 1) % step;
            memset(whole, 'a', from);
            while (strlen(whole) + step < length)
                strcat(whole, letters[l]);
            strcat(whole, "z");
            assert_int_equal(saltus_fail(&message, SALTUS_IO, "%s", whole), SALTUS_IO);
            const char *text = message.text, *dots = strstr(text, "...");
            size_t got = strlen(text);
            assert_true(got < room && (dots != NULL) == (strlen(whole) >= room));
            if (!dots) {
                assert_string_equal(text, whole);
                continue;
            }
            size_t before = (size_t)(dots - text), after = got - before - 3;
            assert_true(got > room - 2 * step - 1 && before > 100 && after > 100);
            assert_memory_equal(text, whole, before);
            assert_string_equal(dots + 3, whole + strlen(whole) - after);
            assert_true((before - from) % step == 0 && (after - 1) % step == 0);
        }
}

static void models_are_found_by_name_and_place(void **unused) {
    (void)unused;
    const int count = saltus_model_count();
    assert_true(count >= 2);
    assert_null(saltus_model_at(-1));
    assert_null(saltus_model_at(count));
    assert_null(saltus_model_find("no such model"));
    for (int k = 0; k < count; k++) {
        const saltus_model *model = saltus_model_at(k);
        assert_ptr_equal(saltus_model_find(saltus_model_name(model)), model);
        assert_true(strlen(saltus_model_summary(model)) > 10);
        int parameters;
        const saltus_parameter *table = saltus_model_parameters(model, &parameters);
        saltus_spec spec = saltus_spec_defaults(model);
        assert_true(parameters > 0 && parameters <= SALTUS_PARAMETERS_MAX && spec.stop_count == 0 &&
                    spec.model == model);
        for (int p = 0; p < parameters; p++) {
            const saltus_parameter *t = &table[p];
            assert_int_equal(saltus_model_parameter_index(model, t->name), p);
            assert_true(spec.parameters[p] == t->fallback && saltus_spec_get(&spec, t->name) == t->fallback);
            assert_true(t->fallback >= t->min && t->fallback <= t->max && t->min < t->max);
            assert_true(strlen(t->meaning) > 3);
        }
        assert_int_equal(saltus_model_parameter_index(model, "no such parameter"), -1);
        assert_true(isnan(saltus_spec_get(&spec, "no such parameter")));
        saltus_system_free(build(&spec));
    }
    saltus_system_free(NULL);
}

/* The defaults of model.md, section 1, and of a stop. */
static void defaults_are_those_of_the_specification(void **unused) {
    (void)unused;
    saltus_spec pipe = saltus_spec_defaults(saltus_model_find("pipe"));
    static const struct {
        const char *name;
        double value;
    } rows[] = {{"N", 5}, {"alpha", 0.005}, {"beta", 0.64}, {"kappa", 5000}, {"u0", 4.5}, {"sigma", 0.2}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++)
        assert_true(saltus_spec_get(&pipe, rows[k].name) == rows[k].value);
    saltus_stop stop = saltus_stop_defaults();
    assert_true(stop.xi == 0.5 && stop.weight[0] == 1 && stop.weight[1] == 0 && stop.d == 1 &&
                stop.r == 0.9 && stop.sides == SALTUS_UPPER);
    int count;
    const saltus_parameter *table = saltus_stop_parameters(&count);
    const double values[] = {stop.xi, stop.d, stop.r};
    const char *const names[] = {"xi", "d", "r"};
    assert_int_equal(count, 3);
    for (int k = 0; k < 3; k++) {
        assert_string_equal(table[k].name, names[k]);
        assert_true(table[k].fallback == values[k]);
    }
}

static void expect(const saltus_spec *spec, bool right, const char *name, double value) {
    saltus_message message = {.text = ""};
    saltus_system *system = (saltus_system *)1;
    saltus_status status = saltus_system_new(spec, &system, &message);
    if ((status == SALTUS_OK) != right || (status != SALTUS_OK && status != SALTUS_BAD_INPUT))
        fail_msg("%s = %.17g: %s: %s", name, value, saltus_status_name(status), message.text);
    assert_true((system != NULL) == right);
    if (!right) {
        char number[40];
        snprintf(number, sizeof number, "%s = %g", name, value);
        if (!strstr(message.text, number))
            fail_msg("\"%s\" does not say \"%s\"", message.text, number);
        assert_int_equal(saltus_system_new(spec, &system, NULL), SALTUS_BAD_INPUT);
    }
    saltus_system_free(system);
}

/* Ranges hold at their ends: these are admissible unless open, values beyond are not, whole numbers are
 * whole. */
static void ranges_hold_at_their_ends(void **unused) {
    (void)unused;
    for (int k = 0; k < saltus_model_count(); k++) {
        const saltus_model *model = saltus_model_at(k);
        int count;
        const saltus_parameter *table = saltus_model_parameters(model, &count);
        for (int p = 0; p < count; p++) {
            const saltus_parameter *t = &table[p];
            const struct {
                double value;
                bool right;
            } rows[] = {{t->min, !t->open_min},
                        {t->max, !t->open_max},
                        {t->min - (t->integer ? 1 : 1e-3 * fmax(1, fabs(t->min))), false},
                        {t->max + (t->integer ? 1 : 1e-3 * fmax(1, fabs(t->max))), false},
                        {t->min + 0.5, !t->integer},
                        {NAN, false},
                        {INFINITY, false}};
            for (size_t j = 0; j < sizeof rows / sizeof rows[0]; j++) {
                saltus_spec spec = saltus_spec_defaults(model);
                spec.parameters[p] = rows[j].value;
                bool right = rows[j].right && !(rows[j].value > t->max);
                if (j == 4 && t->min + 0.5 >= t->max)
                    continue;
                expect(&spec, right, t->name, rows[j].value);
            }
        }
    }
    static const struct {
        double xi, d, r;
        bool right;
        const char *name;
    } stops[] = {
        {0.5, 0.1, 0, true, "r"},      {0.5, 0.1, 1, true, "r"},         {0.5, 0.1, 1.001, false, "r"},
        {0.5, 0.1, -1e-3, false, "r"}, {0, 0.1, 0.5, false, "xi"},       {1, 0.1, 0.5, false, "xi"},
        {0.01, 0.1, 0.5, true, "xi"},  {0.5, 1e9, 0.5, true, "d"},       {0.5, 1.001e9, 0.5, false, "d"},
        {0.5, -1e9, 0.5, true, "d"},   {0.5, -1.001e9, 0.5, false, "d"}, {0.5, 0, 0.5, true, "d"}};
    for (size_t k = 0; k < sizeof stops / sizeof stops[0]; k++) {
        saltus_spec spec = pipe_spec(3, 20);
        add_stop(&spec, stops[k].d, stops[k].r, SALTUS_UPPER);
        spec.stops[0].xi = stops[k].xi;
        const double value = stops[k].name[0] == 'x'   ? stops[k].xi
                             : stops[k].name[0] == 'd' ? stops[k].d
                                                       : stops[k].r;
        expect(&spec, stops[k].right, stops[k].name, value);
    }
}

static void refuse(const saltus_spec *spec, const char *word) {
    saltus_message message = {.text = ""};
    saltus_system *system = (saltus_system *)1;
    assert_int_equal(saltus_system_new(spec, &system, &message), SALTUS_BAD_INPUT);
    assert_null(system);
    if (!strstr(message.text, word))
        fail_msg("\"%s\" does not say \"%s\"", message.text, word);
}

/* A scene's stops: their number, no face twice, room between two that face each other, also on parallel
 * coordinates of different length. */
static void stops_must_fit_together(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_system *system = NULL;
    saltus_spec spec = {.model = NULL};
    refuse(&spec, "model");
    spec = oscillator_spec(0.1, 1, 1, 1);
    spec.stop_count = SALTUS_STOPS_MAX + 1;
    refuse(&spec, "stops");
    spec.stop_count = -1;
    refuse(&spec, "stops");
    spec.stop_count = 0;
    /* Up to the largest number; the message names the offending one. */
    set_parameter(&spec, "N", 2);
    for (int k = 0; k < SALTUS_STOPS_MAX; k++) {
        add_stop(&spec, 0.4 + 0.1 * k, 0.5, SALTUS_BOTH);
        spec.stops[k].weight[0] = cos(k);
        spec.stops[k].weight[1] = sin(k);
    }
    check_ok(saltus_system_new(&spec, &system, &message), &message);
    assert_int_equal(saltus_system_face_count(system), 2 * SALTUS_STOPS_MAX);
    saltus_system_free(system);
    spec.stops[2].r = 2;
    refuse(&spec, "stop 3");
    spec.stops[2].r = 0.5;
    spec.stops[3].weight[0] = NAN;
    refuse(&spec, "weight");
    spec.stops[3].sides = (saltus_sides)4;
    spec.stops[3].weight[0] = 1;
    refuse(&spec, "sides");
    /* 2 x < 0.6 and x < d; -2 x < 0.6 is x > -0.3. */
    static const struct {
        double weight, d;
        saltus_sides sides;
        const char *word;
    } rows[] = {
        {1, 0.3, SALTUS_UPPER, "same"},    {1, 0.4, SALTUS_UPPER, NULL},    {-1, 0.3, SALTUS_LOWER, "same"},
        {-1, 0.3, SALTUS_UPPER, NULL},     {1, -0.29, SALTUS_LOWER, NULL},  {1, -0.31, SALTUS_LOWER, "room"},
        {-1, -0.31, SALTUS_UPPER, "room"}, {-1, -0.29, SALTUS_UPPER, NULL}, {4, 1.2, SALTUS_UPPER, "same"},
        {4, -1.21, SALTUS_LOWER, "room"},  {4, -1.19, SALTUS_LOWER, NULL}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        spec = oscillator_spec(0.1, 1, 1, 1);
        add_stop(&spec, 0.6, 0.5, SALTUS_UPPER);
        spec.stops[0].weight[0] = 2;
        add_stop(&spec, rows[k].d, 0.5, rows[k].sides);
        spec.stops[1].weight[0] = rows[k].weight;
        if (rows[k].word)
            refuse(&spec, rows[k].word);
        else
            saltus_system_free(build(&spec));
    }
}

/* Sizes, period, order of faces, gaps, observer, scale, shape and trace agree with the specification. */
static void a_system_tells_what_it_was_built_from(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++) {
        scene s = scene_of((scene_name)name);
        stress_model m;
        saltus_system *system = build(&s.spec);
        stress_model_read(&m, &s.spec);
        assert_true(saltus_system_dof(system) == m.dof && saltus_system_extra(system) == m.extra &&
                    saltus_system_dimension(system) == m.dimension);
        assert_memory_equal(saltus_system_spec(system), &s.spec, sizeof s.spec);
        check_near(saltus_system_period(system), 2 * M_PI / m.omega, 1e-14);
        assert_int_equal(saltus_system_face_count(system), m.face_count);
        int f = 0;
        for (int k = 0; k < s.spec.stop_count; k++)
            for (int side = 1; side >= -1; side -= 2) {
                const saltus_stop *stop = &s.spec.stops[k];
                if (!(stop->sides & (side > 0 ? SALTUS_UPPER : SALTUS_LOWER)))
                    continue;
                saltus_face face = saltus_system_face(system, f);
                assert_true(face.stop == k && face.side == side && face.d == stop->d && face.r == stop->r);
                for (int i = 0; i < m.dof; i++)
                    check_near(side * saltus_system_stop_normal(system, k)[i], m.face[f].normal[i], 1e-15);
                check_near(saltus_system_gap(system, f, s.state), stress_gap(&m, f, s.state), 1e-15);
                f++;
            }
        for (int i = 0; i < m.dof; i++) {
            double row = s.spec.stop_count ? saltus_system_stop_normal(system, 0)[i]
                         : m.pipe          ? stress_sine(i + 1, 0.5)
                                           : i == 0;
            check_near(saltus_system_observer(system)[i], row, 1e-15);
        }
        for (int i = 0; i < m.dimension; i++)
            assert_true(saltus_system_scale(system)[i] > 0 && isfinite(saltus_system_scale(system)[i]));
        check_near(saltus_system_trace(system, s.state, s.phase), stress_trace(&m, s.state), 1e-10);
        for (int k = 0; k <= 20; k++) {
            const double xi = k / 20.0;
            double shape = 0;
            if (m.pipe)
                for (int i = 0; i < m.dof; i++)
                    shape += stress_sine(i + 1, xi) * s.state[i];
            else if (m.dof == 1)
                shape = xi * s.state[0];
            else
                shape =
                    xi < 0.5 ? 2 * xi * s.state[0] : s.state[0] + (2 * xi - 1) * (s.state[1] - s.state[0]);
            check_near(saltus_system_shape(system, s.state, xi), shape, 1e-15);
        }
        assert_string_equal(saltus_system_integrator(system), "taylor");
        saltus_system_free(system);
    }
}

/* The time dependence and the mirror symmetry agree with the field. */
static void symmetries_are_those_of_the_field(void **unused) {
    (void)unused;
    static const char *const keys[] = {"F", "F0", "F2", "F02"};
    for (int k = 0; k < 16 * 6 * 2; k++) {
        const bool two = k >= 16 * 6;
        const int sides = k / 16 % 6;
        scene s = two ? scene_chain(0.1, 1, 0.8, 1.1) : scene_mass(0.1, 1, 0.8, 1.1);
        for (int j = 0; j < 4; j++)
            set_parameter(&s.spec, keys[j], k >> j & 1 ? 0.3 : 0);
        if (sides > 0)
            scene_stop(&s, 1, 0.7, sides == 1 ? SALTUS_BOTH : sides == 5 ? SALTUS_LOWER : SALTUS_UPPER);
        if (sides > 1 && sides < 5) /* the other side as a stop of its own */
            scene_stop(&s, sides == 3 ? 0.9 : 1, sides == 4 ? 0.6 : 0.7, SALTUS_LOWER);
        stress_model m;
        saltus_system *system = build(&s.spec);
        stress_model_read(&m, &s.spec);
        double a[4][2], size[2], mirrored[5] = {0};
        for (int i = 0; i < m.dimension; i++)
            mirrored[i] = -s.state[i];
        stress_field(&m, 0.1, s.state, a[0], size);
        stress_field(&m, 0.3, s.state, a[1], size);
        stress_field(&m, 0.1, mirrored, a[2], size);
        stress_field(&m, 0.6, mirrored, a[3], size);
        bool forced = false, plain = true, shifted = true, shift = false;
        for (int i = 0; i < m.dof; i++) {
            forced |= fabs(a[1][i] - a[0][i]) > 1e-9;
            plain &= fabs(a[2][i] + a[0][i]) < 1e-9;
            shifted &= fabs(a[3][i] + a[0][i]) < 1e-9;
        }
        bool symmetric = sides < 3;
        assert_true(saltus_system_forced(system) == forced);
        bool told = saltus_system_mirror_symmetric(system, &shift);
        assert_true(told == (symmetric && (plain || shifted)));
        if (told)
            assert_true(shift == !plain);
        saltus_system_free(system);
    }
    static const double rows[][3] = {{0.2, 4.5, true}, {0, 4.5, false}, {0.2, 0, false}};
    for (int k = 0; k < 3; k++)
        for (int sides = SALTUS_UPPER; sides <= SALTUS_BOTH; sides++) {
            saltus_spec spec = pipe_spec(2, 20);
            set_parameter(&spec, "sigma", rows[k][0]);
            set_parameter(&spec, "u0", rows[k][1]);
            add_stop(&spec, 0.03, 0.9, (saltus_sides)sides);
            saltus_system *system = build(&spec);
            bool shift = true;
            assert_true(saltus_system_forced(system) == (rows[k][2] != 0));
            assert_true(saltus_system_mirror_symmetric(system, &shift) == (sides == SALTUS_BOTH));
            assert_false(shift);
            saltus_system_free(system);
        }
}

/* No direction of the unforced linear part contracts faster than the bound, and with strong damping the bound
 * is close. */
static void nothing_decays_faster_than_the_bound(void **unused) {
    (void)unused;
    for (int k = 0; k < 12; k++) {
        scene s = k < 4   ? scene_mass(0.1 + 4 * k, 1, 0, 1)
                  : k < 8 ? scene_chain(0.1 + 2 * (k - 4), 1, 0, 1)
                          : scene_pipe(1 + k % 4, 20);
        if (k >= 4 && k < 8) {
            set_parameter(&s.spec, "c2", 3);
            set_parameter(&s.spec, "F2", 0);
        } else if (k >= 8) {
            set_parameter(&s.spec, "sigma", 0);
            set_parameter(&s.spec, "u0", 2);
        }
        if (k % 4 == 3 && k < 8) {
            set_parameter(&s.spec, "kz", 0.7);
            set_parameter(&s.spec, "tz", 0.02);
        }
        saltus_system *system = build(&s.spec);
        saltus_flow_options options = saltus_flow_defaults();
        const int n = saltus_system_dimension(system);
        double zero[scene_dimension_max] = {0}, columns[scene_dimension_max * scene_dimension_max],
               fastest = 0;
        options.columns = n;
        saltus_flow *flow = open_flow(system, &options, 0, zero);
        saltus_flow_tangent_field(flow, 0, columns);
        gsl_matrix *matrix = gsl_matrix_alloc((size_t)n, (size_t)n);
        gsl_vector_complex *values = gsl_vector_complex_alloc((size_t)n);
        gsl_eigen_nonsymm_workspace *work = gsl_eigen_nonsymm_alloc((size_t)n);
        for (int i = 0; i < n * n; i++)
            gsl_matrix_set(matrix, (size_t)(i % n), (size_t)(i / n), columns[i]);
        assert_int_equal(gsl_eigen_nonsymm(matrix, values, work), 0);
        for (int i = 0; i < n; i++)
            fastest = fmax(fastest, -GSL_REAL(gsl_vector_complex_get(values, (size_t)i)));
        double bound = saltus_system_fastest_decay(system);
        if (!(fastest <= bound * (1 + 1e-12)))
            fail_msg("case %d: a direction decays at %.9g, beyond the bound %.9g", k, fastest, bound);
        assert_true(bound <= 3 * fastest);
        gsl_eigen_nonsymm_free(work);
        gsl_vector_complex_free(values);
        gsl_matrix_free(matrix);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* The default initial state is small, beyond no stop, and not at rest in the origin; also between pre-loaded
 * stops. Stops that exclude each other are reported. */
static void default_states_are_admissible(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    double state[scene_dimension_max];
    for (int k = 0; k < 40; k++) {
        scene s = k % 2 ? scene_pipe(1 + k % 4, 20) : scene_chain(0.1, 1, 0.5, 1);
        const double d[] = {0.03, 0, -0.01, 0.001, 1};
        scene_stop(&s, d[k % 5], 0.5, k % 7 < 3 ? SALTUS_LOWER : SALTUS_UPPER)->xi = 0.2 + 0.015 * k;
        if (k % 3 == 0 && k % 8 >= 4) {
            scene_stop(&s, 0.02, 0.5, k % 7 < 3 ? SALTUS_UPPER : SALTUS_LOWER)->xi = 0.8;
            s.spec.stops[1].weight[0] = 0.3;
            s.spec.stops[1].weight[1] = k % 2 ? 0 : -1;
        }
        saltus_system *system = build(&s.spec);
        const int n = saltus_system_dimension(system), dof = saltus_system_dof(system);
        check_ok(saltus_system_default_state(system, state, &message), &message);
        check_ok(saltus_system_check_state(system, state, &message), &message);
        double size = 0;
        for (int f = 0; f < saltus_system_face_count(system); f++)
            assert_true(saltus_system_gap(system, f, state) < 0);
        for (int i = 0; i < dof; i++)
            size = fmax(size, fabs(state[i]) / saltus_system_scale(system)[i]);
        for (int i = dof; i < n; i++)
            assert_true(state[i] == 0);
        assert_true(size > 0.01 && size < 20);
        saltus_system_free(system);
    }
    scene s = scene_pipe(2, 20);
    scene_stop(&s, -0.02, 0.5, SALTUS_UPPER)->xi = 0.4;
    scene_stop(&s, -0.02, 0.5, SALTUS_LOWER)->xi = 0.4 + 1e-5;
    saltus_system *system = build(&s.spec);
    assert_int_equal(saltus_system_default_state(system, state, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "contradict"));
    saltus_system_free(system);
}

/* A state on a stop is not beyond it, up to rounding; an entry that is not finite is refused by its index. */
static void states_are_checked(void **unused) {
    (void)unused;
    scene s = scene_of(scene_struck_chain);
    saltus_system *system = build(&s.spec);
    saltus_message message = {.text = ""};
    const double d = s.spec.stops[1].d, weight = s.spec.stops[1].weight[1];
    double state[4] = {0.3, d / weight, 0, 0};
    check_ok(saltus_system_check_state(system, state, &message), &message);
    state[1] *= 1 + 1e-12;
    assert_int_equal(saltus_system_check_state(system, state, &message), SALTUS_BAD_INPUT);
    assert_true(strstr(message.text, "stop 2") && strstr(message.text, "upper"));
    state[1] = -d / weight * (1 + 1e-12);
    state[0] = -0.3;
    assert_int_equal(saltus_system_check_state(system, state, &message), SALTUS_BAD_INPUT);
    assert_true(strstr(message.text, "stop 2") && strstr(message.text, "lower"));
    state[1] = 0.1;
    state[2] = INFINITY;
    assert_int_equal(saltus_system_check_state(system, state, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "entry 3"));
    assert_int_equal(saltus_system_check_state(system, state, NULL), SALTUS_BAD_INPUT);
    saltus_system_free(system);
}

/* A direction changes only its key; a common key changes all stops. */
static void directions_move_their_key_alone(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    scene s = scene_pipe(3, 20);
    scene_stop(&s, 0.03, 0.9, SALTUS_UPPER);
    scene_stop(&s, 0.03, 0.9, SALTUS_LOWER)->xi = 0.3;
    static const char *const keys[] = {"alpha", "beta", "kappa", "u0", "sigma", "omega", "d",
                                       "r",     "d1",   "d2",    "r1", "r2",    "xi1",   "xi2"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        saltus_direction direction;
        double value = NAN;
        check_ok(saltus_spec_direction(&s.spec, keys[k], &direction, &value, &message), &message);
        saltus_spec moved = saltus_spec_shifted(&s.spec, &direction, 0.25);
        const char last = keys[k][strlen(keys[k]) - 1];
        for (int p = 0; p < 7; p++) {
            bool own = p == saltus_model_parameter_index(s.spec.model, keys[k]);
            assert_true(moved.parameters[p] == s.spec.parameters[p] + (own ? 0.25 : 0));
            if (own)
                assert_true(value == s.spec.parameters[p]);
        }
        for (int j = 0; j < 2; j++) {
            bool all = last != '1' && last != '2', own = all || last == '1' + j;
            bool d = strncmp(keys[k], "d", 1) == 0, r = keys[k][0] == 'r', xi = keys[k][0] == 'x';
            const saltus_stop *a = &s.spec.stops[j], *b = &moved.stops[j];
            assert_true(b->d == a->d + (d && own ? 0.25 : 0) && b->r == a->r + (r && own ? 0.25 : 0) &&
                        b->xi == a->xi + (xi && own ? 0.25 : 0));
            if (own && (d || r || xi))
                assert_true(value == (d ? a->d : r ? a->r : a->xi));
        }
    }
    static const char *const wrong[] = {"xi", "N", "d3", "d0", "d01", "r1x", "x", "", "xi0", "sides"};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        saltus_direction direction;
        assert_int_equal(saltus_spec_direction(&s.spec, wrong[k], &direction, NULL, &message),
                         SALTUS_BAD_INPUT);
    }
}

/* A system copies its specification: later changes by the caller, and the fields of stops that the model does
 * not use, do not matter. */
static void a_system_keeps_its_own_specification(void **unused) {
    (void)unused;
    for (int pipe = 0; pipe < 2; pipe++) {
        scene s = pipe ? scene_pipe(2, 20) : scene_chain(0.1, 1, 0.5, 1);
        saltus_stop *stop = scene_stop(&s, 0.5, 0.7, SALTUS_BOTH);
        stop->xi = 0.3;
        saltus_system *plain = build(&s.spec);
        if (pipe)
            stop->weight[0] = stop->weight[1] = NAN;
        else
            stop->xi = NAN;
        saltus_spec copy = s.spec;
        saltus_system *system = build(&s.spec);
        memset(&s.spec, 0, sizeof s.spec);
        assert_memory_equal(saltus_system_spec(system), &copy, sizeof copy);
        for (int i = 0; i < 2; i++)
            assert_true(saltus_system_stop_normal(system, 0)[i] == saltus_system_stop_normal(plain, 0)[i]);
        bool shift;
        assert_true(saltus_system_mirror_symmetric(system, &shift) ==
                    saltus_system_mirror_symmetric(plain, &shift));
        double state[2][scene_dimension_max];
        for (int k = 0; k < 2; k++) {
            saltus_flow_options options = saltus_flow_defaults();
            saltus_flow *flow = open_flow(k ? system : plain, &options, s.phase, s.state);
            advance(flow, 1.5, 0);
            saltus_flow_state(flow, 0, state[k]);
            saltus_flow_free(flow);
        }
        assert_memory_equal(state[0], state[1], (size_t)saltus_system_dimension(system) * sizeof(double));
        saltus_system_free(system);
        saltus_system_free(plain);
    }
}

/* Maps, searches and verdicts use their own tangent vectors: those requested in the flow's options have no
 * effect. */
static void columns_of_the_caller_do_not_matter(void **unused) {
    (void)unused;
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_message message = {.text = ""};
    double image[2][2], derivative[2][4], found[2][2], settled[2][2];
    for (int asked = 0; asked < 2; asked++) {
        saltus_flow_options options = saltus_flow_defaults();
        saltus_section section = saltus_section_defaults();
        saltus_orbit_options search = saltus_orbit_defaults();
        saltus_classify_options classify = saltus_classify_defaults();
        saltus_motion motion;
        saltus_orbit orbit;
        options.columns = asked ? 3 : 0;
        options.directions = asked ? 2 : 0;
        for (int with = 0; with < 2; with++) {
            saltus_map *map = NULL;
            check_ok(saltus_map_new(system, &section, &options, with, &map, &message), &message);
            assert_int_equal(saltus_flow_columns(saltus_map_flow(map)), with ? 2 : 0);
            check_ok(saltus_map_reset(map, s.state, &message), &message);
            check_ok(saltus_map_step(map, image[asked], NULL, &message), &message);
            if (with)
                saltus_map_derivative(map, derivative[asked]);
            saltus_map_free(map);
        }
        classify.flow = search.flow = options;
        check_ok(saltus_classify(system, s.state, &classify, &motion, &message), &message);
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        memcpy(settled[asked], motion.state, sizeof settled[asked]);
        check_ok(saltus_orbit_find(system, motion.periods, motion.state, &search, &orbit, &message),
                 &message);
        memcpy(found[asked], orbit.state, sizeof found[asked]);
        saltus_orbit_clear(&orbit);
        saltus_motion_clear(&motion);
    }
    assert_memory_equal(image[0], image[1], sizeof image[0]);
    assert_memory_equal(derivative[0], derivative[1], sizeof derivative[0]);
    assert_memory_equal(found[0], found[1], sizeof found[0]);
    assert_memory_equal(settled[0], settled[1], sizeof settled[0]);
    saltus_system_free(system);
}

/* Cleared and never filled results can be cleared. */
static void zeroed_results_are_accepted(void **unused) {
    (void)unused;
    saltus_motion motion = {.state = NULL};
    saltus_attractors attractors = {.motions = NULL};
    saltus_harvest harvest = {.orbits = NULL};
    saltus_lyapunov lyapunov = {.exponents = NULL};
    saltus_spectrum spectrum = {.lines = NULL};
    saltus_spectra spectra = {.count = 0};
    for (int k = 0; k < 2; k++) {
        saltus_motion_clear(&motion);
        saltus_attractors_clear(&attractors);
        saltus_harvest_clear(&harvest);
        saltus_lyapunov_clear(&lyapunov);
        saltus_spectrum_clear(&spectrum);
        saltus_spectra_clear(&spectra);
    }
    assert_true(!motion.state && !attractors.motions && !harvest.orbits && !lyapunov.exponents);
    assert_true(!spectrum.density && !spectrum.lines && spectra.count == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_status_has_a_name),
        cmocka_unit_test(long_sentences_keep_both_ends),
        cmocka_unit_test(models_are_found_by_name_and_place),
        cmocka_unit_test(defaults_are_those_of_the_specification),
        cmocka_unit_test(ranges_hold_at_their_ends),
        cmocka_unit_test(stops_must_fit_together),
        cmocka_unit_test(a_system_tells_what_it_was_built_from),
        cmocka_unit_test(symmetries_are_those_of_the_field),
        cmocka_unit_test(nothing_decays_faster_than_the_bound),
        cmocka_unit_test(default_states_are_admissible),
        cmocka_unit_test(states_are_checked),
        cmocka_unit_test(directions_move_their_key_alone),
        cmocka_unit_test(a_system_keeps_its_own_specification),
        cmocka_unit_test(columns_of_the_caller_do_not_matter),
        cmocka_unit_test(zeroed_results_are_accepted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
