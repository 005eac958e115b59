/* The heads of tables and the first members of JSON objects: trajectories, spectra and exponents of a scene
 * describe it in the same way, with numbers that reproduce it, and each with its run's options.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "json.h"
#include "made_record.h"

#include <signal.h>
#include <sys/resource.h>

enum { tables = 3, objects = 4 };

/* The rest of a head's line after these words; freed by the caller. NULL: there is none. */
static char *told(const char *text, const char *words) {
    char begin[120];
    snprintf(begin, sizeof begin, "\n# %s", words);
    const char *at = strstr(text, begin);
    if (!at)
        return NULL;
    at += strlen(begin);
    return strndup(at, strcspn(at, "\n"));
}

static void check_told(const char *text, const char *words, const char *wanted) {
    char *own = told(text, words);
    assert_non_null(own);
    assert_string_equal(own, wanted);
    free(own);
}

/* The number after "name = " in a line. */
static double number_of(const char *line, const char *name) {
    size_t length = strlen(name);
    for (const char *at = line; (at = strstr(at, name)) != NULL; at++)
        if ((at == line || at[-1] == ' ') && strncmp(at + length, " = ", 3) == 0)
            return strtod(at + length + 3 + (at[length + 3] == '['), NULL);
    fail_msg("no %s in %s", name, line);
    return NAN;
}

static void check_parameters(const char *line, const saltus_spec *spec) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    const char *at = line;
    for (int k = 0; k < count; k++) {
        assert_true(strncmp(at, p[k].name, strlen(p[k].name)) == 0);
        assert_true(number_of(at, p[k].name) == saltus_spec_get(spec, p[k].name));
        at = strstr(at, ", ") ? strstr(at, ", ") + 2 : at + strlen(at);
    }
    assert_true(*at == '\0');
}

static void check_stop(const char *line, const saltus_spec *spec, int s) {
    static const char *const sides[] = {"", "upper", "lower", "both"};
    const saltus_stop *stop = &spec->stops[s];
    char end[32];
    if (strcmp(saltus_model_name(spec->model), "pipe") == 0)
        assert_true(number_of(line, "xi") == stop->xi && !strstr(line, "weight"));
    else {
        assert_true(number_of(line, "weight") == stop->weight[0] && !strstr(line, "xi"));
        assert_true(strtod(strchr(line, ',') + 1, NULL) == stop->weight[1]);
    }
    assert_true(number_of(line, "d") == stop->d && number_of(line, "r") == stop->r);
    snprintf(end, sizeof end, ", sides = %s", sides[stop->sides]);
    assert_string_equal(line + strlen(line) - strlen(end), end);
}

/* A scene with as many stops as possible, all numbers different. */
static saltus_scene scene_with(bool pipe, int stops) {
    static const saltus_sides sides[] = {SALTUS_BOTH, SALTUS_UPPER, SALTUS_LOWER};
    saltus_scene scene = {.spec = pipe ? pipe_spec(3, 20) : oscillator_spec(0.125, 1.75, 1.5, 0.625)};
    if (!pipe)
        set_parameter(&scene.spec, "N", 2);
    for (int s = 0; s < stops; s++) {
        add_stop(&scene.spec, 0.5 + 0.1 * s, 0.75 - 0.06 * s, sides[s % 3]);
        scene.spec.stops[s].xi = pipe ? 0.3 + 0.05 * s : 0;
        if (!pipe) {
            scene.spec.stops[s].weight[0] = 1 + 0.1 * s;
            scene.spec.stops[s].weight[1] = -0.3 * s;
        }
    }
    snprintf(scene.name, sizeof scene.name, "scene of %d", stops);
    if (stops % 2)
        strcpy(scene.title, "a title, 100 %");
    return scene;
}

/* The tables of one scene. */
static void write_tables(const saltus_scene *scene, const saltus_system *system,
                         const saltus_flow_options *flow, const saltus_lyapunov_options *options,
                         const saltus_lyapunov *lyapunov, char *text[tables]) {
    static made_up m;
    static double density[2];
    saltus_spectra spectra = {
        .count = 1,
        .per_period = 24,
        .analysed = 7,
        .spectra = {{.kind = SALTUS_SPECTRUM_CONSTANT, .density = density, .mean = 0.25}}};
    saltus_motion motion = {.verdict = SALTUS_HELD, .label = "held"};
    saltus_message message = {.text = ""};
    char path[path_size];
    size_t length;
    make_record(&m, system, 1, NULL, 0);
    check_ok(saltus_write_trajectory(path_in("t.csv", path), scene, system, flow, &m.record, NULL, &message),
             &message);
    text[0] = read_all(path, &length);
    check_ok(saltus_write_spectra(path, scene, system, flow, &motion, &spectra, NULL, &message), &message);
    text[1] = read_all(path, &length);
    check_ok(saltus_write_convergence(path, scene, system, options, lyapunov, NULL, &message), &message);
    text[2] = read_all(path, &length);
}

static saltus_lyapunov lyapunov_of(double *exponent, double *error) {
    return (saltus_lyapunov){.count = 1,
                             .exponents = exponent,
                             .standard_errors = error,
                             .period = 2.5,
                             .periods = 345,
                             .transient = 67,
                             .members = 5};
}

static void tables_tell_their_scene(void **state) {
    (void)state;
    static const char *const kinds[tables] = {"trajectory", "spectrum", "largest Lyapunov exponent"};
    double exponent = 0.5, error = 0.25;
    saltus_lyapunov lyapunov = lyapunov_of(&exponent, &error);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    saltus_flow_options flow = saltus_flow_defaults();
    for (int k = 0; k < 2 * (SALTUS_STOPS_MAX + 1); k++) {
        int stops = k / 2;
        saltus_scene scene = scene_with(k % 2, stops);
        saltus_system *system = build(&scene.spec);
        char *text[tables], words[80];
        write_tables(&scene, system, &flow, &options, &lyapunov, text);
        for (int t = 0; t < tables; t++) {
            snprintf(words, sizeof words, "# Saltus " SALTUS_VERSION " %s\n# scene: scene of %d\n", kinds[t],
                     stops);
            assert_true(strncmp(text[t], words, strlen(words)) == 0);
            if (scene.title[0])
                check_told(text[t], "title: ", scene.title);
            else
                assert_null(strstr(text[t], "title"));
            check_told(text[t], "model: ", k % 2 ? "pipe" : "oscillator");
            char *line = told(text[t], "parameters: ");
            check_parameters(line, &scene.spec);
            free(line);
            for (int s = 0; s < stops; s++) {
                snprintf(words, sizeof words, "stop %d: ", s + 1);
                line = told(text[t], words);
                assert_non_null(line);
                check_stop(line, &scene.spec, s);
                free(line);
            }
            snprintf(words, sizeof words, "\n# stop %d", stops + 1);
            assert_true(!strstr(text[t], words) && !strstr(text[t], "\n# stop 0"));
            free(text[t]);
        }
        saltus_system_free(system);
    }
}

/* One JSON object from each writer, of a result with only the necessary content. */
static void write_objects(const saltus_scene *scene, const saltus_system *system, char *text[objects]) {
    double state[16] = {0}, exponent = 0.5, error = 0.25;
    int dimension = saltus_system_dimension(system);
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    saltus_lyapunov lyapunov = lyapunov_of(&exponent, &error);
    saltus_motion motion = {
        .verdict = SALTUS_HELD, .label = "held", .dimension = dimension, .state = state, .lyapunov = NAN};
    saltus_equilibrium rest = {.dimension = dimension, .state = state};
    saltus_spectra spectra = {.count = 1, .spectra = {{.kind = SALTUS_SPECTRUM_CONSTANT}}};
    assert_true(dimension <= 16);
    lyapunov.members = 1;
    lyapunov.member_exponents = &exponent;
    lyapunov.state = state;
    lyapunov.dimension = dimension;
    for (int k = 0; k < objects; k++) {
        size_t length;
        FILE *stream = open_memstream(&text[k], &length);
        assert_non_null(stream);
        if (k == 0)
            saltus_write_motion_json(stream, scene, system, &motion);
        else if (k == 1)
            saltus_write_equilibrium_json(stream, scene, system, &rest);
        else if (k == 2)
            saltus_write_lyapunov_json(stream, scene, system, &options, &lyapunov);
        else
            saltus_write_spectra_json(stream, scene, system, &motion, &spectra);
        fclose(stream);
    }
}

static void check_stop_object(const json *o, const saltus_spec *spec, int s) {
    static const char *const sides[] = {"", "upper", "lower", "both"};
    const saltus_stop *stop = &spec->stops[s];
    if (strcmp(saltus_model_name(spec->model), "pipe") == 0)
        assert_true(json_number_at(o, "xi") == stop->xi && !json_find(o, "weight"));
    else
        assert_true(json_number_at(o, "weight.0") == stop->weight[0] &&
                    json_number_at(o, "weight.1") == stop->weight[1] && !json_find(o, "xi"));
    assert_true(json_number_at(o, "d") == stop->d && json_number_at(o, "r") == stop->r);
    assert_string_equal(json_text_at(o, "sides"), sides[stop->sides]);
}

/* So do all JSON objects; the first stop's numbers are also among the parameters. */
static void objects_tell_their_scene(void **state) {
    (void)state;
    for (int k = 0; k < 2 * (SALTUS_STOPS_MAX + 1); k++) {
        int stops = k / 2, count;
        saltus_scene scene = scene_with(k % 2, stops);
        saltus_system *system = build(&scene.spec);
        const saltus_parameter *p = saltus_model_parameters(scene.spec.model, &count);
        char *text[objects], path[40];
        write_objects(&scene, system, text);
        for (int t = 0; t < objects; t++) {
            json *o = json_read(text[t]);
            assert_string_equal(json_text_at(o, "version"), SALTUS_VERSION);
            assert_string_equal(json_text_at(o, "scene"), scene.name);
            const json *own = json_at(o, "parameters");
            assert_string_equal(json_text_at(own, "model"), k % 2 ? "pipe" : "oscillator");
            for (int i = 0; i < count; i++)
                assert_true(json_number_at(own, p[i].name) == saltus_spec_get(&scene.spec, p[i].name));
            assert_int_equal(json_count(json_at(own, "stops")), stops);
            for (int s = 0; s < stops; s++) {
                snprintf(path, sizeof path, "stops.%d", s);
                check_stop_object(json_at(own, path), &scene.spec, s);
            }
            if (stops)
                check_stop_object(own, &scene.spec, 0);
            else
                assert_null(json_find(own, "sides"));
            json_free(o);
            free(text[t]);
        }
        saltus_system_free(system);
    }
}

/* The options of a run are those given, the integrator is the one used. */
static void tables_tell_their_options(void **state) {
    (void)state;
    static const saltus_integrator asked[] = {SALTUS_AUTOMATIC, SALTUS_TAYLOR, SALTUS_RADAU};
    static const char *const words[2][3] = {
        {", integrator = automatic (taylor)", ", integrator = taylor (taylor)",
         ", integrator = radau (radau)"},
        {", integrator = automatic (mixed)", ", integrator = taylor (taylor)",
         ", integrator = radau (radau)"}};
    double exponent = 0.5, error = 0.25;
    saltus_lyapunov lyapunov = lyapunov_of(&exponent, &error);
    for (int k = 0; k < 6; k++) {
        saltus_scene scene = scene_with(false, 1);
        if (k % 2) /* damping that makes it stiff */
            set_parameter(&scene.spec, "c", 4000);
        saltus_system *system = build(&scene.spec);
        saltus_flow_options flow = saltus_flow_defaults();
        flow.rtol = 1e-7 / 3;
        flow.atol = 1e-9 / 7;
        flow.order = 11;
        flow.integrator = asked[k / 2];
        saltus_lyapunov_options options = {.flow = flow,
                                           .transient = 123,
                                           .periods = 4567,
                                           .members = 3,
                                           .seed = 89,
                                           .precision = 0.1 / 3,
                                           .interval = 0.25};
        char *text[tables];
        write_tables(&scene, system, &flow, &options, &lyapunov, text);
        for (int t = 0; t < tables; t++) {
            char *line = told(text[t], "options: ");
            assert_non_null(line);
            assert_true(number_of(line, "rtol") == flow.rtol && number_of(line, "atol") == flow.atol);
            assert_non_null(strstr(line, words[k % 2][k / 2]));
            if (t != 1)
                assert_true(number_of(line, "order") == 11);
            if (t == 2)
                assert_true(number_of(line, "transient") == 123 && number_of(line, "periods") == 4567 &&
                            number_of(line, "members") == 3 && number_of(line, "seed") == 89 &&
                            number_of(line, "precision") == options.precision &&
                            number_of(line, "interval") == 0.25);
            free(line);
        }
        char period[64];
        snprintf(period, sizeof period, "forcing periods T = %.17g\n", saltus_system_period(system));
        assert_non_null(strstr(text[0], period));
        check_told(text[1], "motion: ", "held");
        check_told(text[1], "analysed: ", "7 T, 24 samples a period");
        check_told(text[2], "measured: ", "345 periods, trajectories: 5, transient: 67 periods, T = 2.5");
        for (int t = 0; t < tables; t++)
            free(text[t]);
        saltus_system_free(system);
    }
}

/* An exponent is reported with its error if known, and lost directions as such. */
static void tables_tell_what_is_not_known(void **state) {
    (void)state;
    static const double numbers[][2] = {{0.5, 0.25}, {-0.5, INFINITY}, {-INFINITY, 0}};
    static const char *const words[] = {"exponent = 0.5, standard_error = 0.25",
                                        "exponent = -0.5, standard_error = unknown",
                                        "exponent = -infinity: every direction is lost for good"};
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    saltus_flow_options flow = saltus_flow_defaults();
    saltus_scene scene = scene_with(false, 1);
    saltus_system *system = build(&scene.spec);
    for (int k = 0; k < 3; k++) {
        double exponent = numbers[k][0], error = numbers[k][1];
        saltus_lyapunov lyapunov = lyapunov_of(&exponent, &error);
        char *text[tables];
        write_tables(&scene, system, &flow, &options, &lyapunov, text);
        check_told(text[2], "result: ", words[k]);
        for (int t = 0; t < tables; t++)
            free(text[t]);
    }
    saltus_system_free(system);
}

/* A failing write leaves nothing behind, and existing files unchanged. */
static void what_does_not_fit_leaves_nothing(void **state) {
    (void)state;
    static made_up m;
    saltus_scene scene = scene_with(false, 1);
    saltus_system *system = build(&scene.spec);
    saltus_flow_options flow = saltus_flow_defaults();
    struct rlimit before, small;
    char path[path_size];
    size_t length;
    make_record(&m, system, 4, NULL, 0);
    int others = folder_files(folder, false);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*action)(int) = signal(SIGXFSZ, SIG_IGN);
    for (int there = 0; there < 2; there++) {
        saltus_message message = {.text = ""};
        path_in("full.csv", path);
        if (there) {
            FILE *file = fopen(path, "w");
            assert_true(file && fputs("kept", file) >= 0);
            fclose(file);
        }
        small = before;
        small.rlim_cur = 2000;
        setrlimit(RLIMIT_FSIZE, &small);
        saltus_status status =
            saltus_write_trajectory(path, &scene, system, &flow, &m.record, NULL, &message);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_int_equal(status, SALTUS_IO);
        assert_non_null(strstr(message.text, "could not be written completely: File too large"));
        assert_int_equal(folder_files(folder, false), others + there);
        if (there) {
            char *text = read_all(path, &length);
            assert_string_equal(text, "kept");
            free(text);
        }
    }
    signal(SIGXFSZ, action);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_tell_their_scene),          cmocka_unit_test(objects_tell_their_scene),
        cmocka_unit_test(tables_tell_their_options),        cmocka_unit_test(tables_tell_what_is_not_known),
        cmocka_unit_test(what_does_not_fit_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
