/* Every public operation with one failing allocation, each in turn. The operation either refuses, with
 * SALTUS_NO_MEMORY and a message, or has the same result to the last bit. It leaks nothing (seen by the
 * address sanitizer), leaves an existing file unchanged or replaces it by a complete one, and leaves no other
 * file behind. Only allocations of this library fail, not those within GSL, LAPACKE, FFTW, HDF5 and LibYAML.
 * If there are very many, as many as time allows are tried, equally spaced; SALTUS_LONG_TESTS tries all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "allocations.h"
#include "feeder.h"
#include "folder.h"

#include <errno.h>
#include <limits.h>
#include <time.h>
#include <unistd.h>

static long allocations, failing = -1;

static bool refuse(void) {
    bool refused = ++allocations == failing;
    errno = refused ? ENOMEM : errno;
    return refused;
}

char *__real_strdup(const char *text);
char *__wrap_strdup(const char *text);
FILE *__real_open_memstream(char **text, size_t *length);
FILE *__wrap_open_memstream(char **text, size_t *length);

char *__wrap_strdup(const char *text) {
    return refuse() ? NULL : __real_strdup(text);
}
FILE *__wrap_open_memstream(char **text, size_t *length) {
    return refuse() ? NULL : __real_open_memstream(text, length);
}

/* One run of an operation: the folder of its files, its message, and a number that represents its result. */
typedef struct trial {
    char folder[64], path[128];
    saltus_message message;
    uint64_t hash;
} trial;

static void note(trial *t, const void *bytes, size_t length) {
    for (size_t k = 0; k < length; k++)
        t->hash = (t->hash ^ ((const unsigned char *)bytes)[k]) * 0x100000001b3u;
}

static void note_text(trial *t, const char *text) {
    note(t, text, strlen(text));
}

static void note_reals(trial *t, const double *values, size_t count) {
    note(t, values, count * sizeof *values);
}

static void note_file(trial *t, const char *path) {
    size_t length;
    long count = allocations, before = failing;
    failing = -1;
    void *bytes = read_all(path, &length);
    note(t, bytes, length);
    free(bytes);
    failing = before;
    allocations = count;
}

/* Scenes: an oscillator that hits a stop twice in a period, and the pipe. */
static void load(const char *name, saltus_scene *scene) {
    saltus_message message = {.text = ""};
    long count = allocations, before = failing;
    failing = -1;
    memset(scene, 0, sizeof *scene);
    check_ok(saltus_scene_load(name, scene, &message), &message);
    failing = before;
    allocations = count;
}

static saltus_status open_system(const saltus_scene *scene, saltus_system **system, double *state, trial *t) {
    saltus_status status = saltus_system_new(&scene->spec, system, &t->message);
    return status == SALTUS_OK ? saltus_system_default_state(*system, state, &t->message) : status;
}

static saltus_status read_scene(trial *t) {
    static const char text[] =
        "model: oscillator\nN: 2\nF: 0.5\nstops:\n  - {weight: [1, -1], d: 0.3}\n"
        "  - {weight: [0, 1], d: 1, r: 0.5, sides: both}\ninitial: {q: [0.1], v: [0, 1]}\n";
    saltus_scene scene;
    memset(&scene, 0, sizeof scene);
    saltus_status status = saltus_scene_parse(text, strlen(text), "text", &scene, &t->message);
    note(t, &scene.spec.parameters, sizeof scene.spec.parameters);
    if (status == SALTUS_OK)
        status = saltus_scene_load("fig7d", &scene, &t->message);
    note(t, &scene.spec.parameters, sizeof scene.spec.parameters);
    return status;
}

/* A refusal names the key, unless memory to find it is lacking. */
static saltus_status read_bad_scene(trial *t) {
    static const char text[] = "model: oscillator\nstops:\n  - {weight: [1, -1], d: 0.3}\n  - {d: 1, r: 2}\n";
    saltus_scene scene;
    saltus_status status = saltus_scene_parse(text, strlen(text), "text", &scene, &t->message);
    return status;
}

static saltus_status set_scene(trial *t) {
    static const char *const settings[] = {"N=7", "d=0.03", "q3=0.001", "v1=0.1", "sides=both"};
    saltus_scene scene;
    saltus_status status = SALTUS_OK;
    load("fig7d", &scene);
    for (size_t k = 0; k < sizeof settings / sizeof settings[0] && status == SALTUS_OK; k++) {
        saltus_scene before = scene;
        status = saltus_scene_set(&scene, settings[k], &t->message);
        assert_true(status == SALTUS_OK || memcmp(&before, &scene, sizeof before) == 0);
    }
    note_reals(t, scene.initial, 14);
    return status;
}

/* Several lanes with tangent vectors; one with directions, of either integrator. */
static saltus_status run_flow(trial *t, const saltus_system *system, const double *state, int lanes,
                              const saltus_flow_options *options) {
    const saltus_system *systems[16] = {system};
    saltus_flow *flow = NULL;
    double after[32];
    for (int l = 0; l < lanes; l++)
        systems[l] = system;
    saltus_status status = saltus_flow_new(systems, lanes, options, &flow, &t->message);
    for (int l = 0; l < lanes && status == SALTUS_OK; l++)
        status = saltus_flow_start(flow, l, (saltus_time){0, 0}, state, &t->message);
    for (int l = 0; l < lanes && status == SALTUS_OK; l++)
        saltus_flow_aim(flow, l, (saltus_time){2, 0}, 0);
    for (int l = 0; l < lanes && status == SALTUS_OK; l++) {
        saltus_event event;
        int lane;
        status = saltus_flow_run(flow, &lane, &event, &t->message);
        saltus_flow_state(flow, lane, after);
        note_reals(t, after, (size_t)saltus_system_dimension(system));
    }
    saltus_flow_free(flow);
    return status;
}

static saltus_status follow_flow(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    double state[SALTUS_SCENE_STATE_MAX];
    load("fig7d", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    saltus_flow_options options = saltus_flow_defaults();
    options.columns = 3;
    if (status == SALTUS_OK)
        status = run_flow(t, system, state, saltus_flow_width(system, SALTUS_AUTOMATIC, LLONG_MAX), &options);
    options.directions = 1;
    if (status == SALTUS_OK)
        status = run_flow(t, system, state, 1, &options);
    options.integrator = SALTUS_RADAU;
    if (status == SALTUS_OK)
        status = run_flow(t, system, state, 1, &options);
    saltus_system_free(system);
    return status;
}

static saltus_status step_maps(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_flow_options options = saltus_flow_defaults();
    double state[SALTUS_SCENE_STATE_MAX] = {0}, point[8] = {0}, derivative[64]; /* from time 0 */
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    for (int kind = SALTUS_SECTION_STROBOSCOPIC; kind <= SALTUS_SECTION_TURNING; kind++) {
        saltus_section section = saltus_section_defaults();
        saltus_map *map = NULL;
        section.kind = (saltus_section_kind)kind;
        if (status == SALTUS_OK)
            status = saltus_map_new(system, &section, &options, true, &map, &t->message);
        if (status == SALTUS_OK)
            status = saltus_map_reset(map, state, &t->message);
        if (status == SALTUS_OK)
            status = saltus_map_step(map, point, NULL, &t->message);
        if (status == SALTUS_OK) {
            saltus_map_derivative(map, derivative);
            const size_t m = (size_t)saltus_map_dimension(map);
            note_reals(t, derivative, m * m);
        }
        saltus_map_free(map);
    }
    saltus_system_free(system);
    return status;
}

static saltus_status find_orbit(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_orbit orbit = {0};
    saltus_motion motion = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    const saltus_orbit_options how = saltus_orbit_defaults();
    const saltus_classify_options describing = saltus_classify_defaults();
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_motion_settle(system, &how.flow, 100, state, &t->message);
    if (status == SALTUS_OK)
        status = saltus_orbit_find(system, 1, state, &how, &orbit, &t->message);
    if (status == SALTUS_OK)
        status = saltus_motion_describe(system, &orbit, &describing, &motion, &t->message);
    if (status == SALTUS_OK) {
        note_reals(t, motion.state, 2);
        note(t, motion.multipliers, 2 * sizeof *motion.multipliers);
        note_text(t, motion.label);
    }
    saltus_motion_clear(&motion);
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
    return status;
}

static saltus_status find_rest(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_equilibrium rest = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    const saltus_equilibrium_options how = saltus_equilibrium_defaults();
    load("pipe", &scene);
    set_parameter(&scene.spec, "sigma", 0);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_equilibrium_find(system, state, &how, &rest, &t->message);
    if (status == SALTUS_OK)
        note_reals(t, rest.state, 2);
    saltus_equilibrium_clear(&rest);
    saltus_system_free(system);
    return status;
}

/* The same as a motion, with its exponents. */
static saltus_status describe_rest(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_motion motion = {0};
    saltus_lyapunov exponents = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    const saltus_classify_options how = saltus_classify_defaults();
    load("pipe", &scene);
    set_parameter(&scene.spec, "sigma", 0);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_motion_equilibrium(system, state, &how, &motion, &t->message);
    if (status == SALTUS_OK)
        status = saltus_motion_exponents(system, &motion, &how.flow, 2, &exponents, &t->message);
    if (status == SALTUS_OK)
        note_reals(t, exponents.exponents, 2);
    saltus_lyapunov_clear(&exponents);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return status;
}

/* A motion, with all that can be reported of it. */
static saltus_status classify(trial *t, const saltus_scene *scene, long long transient, long long measure) {
    saltus_system *system = NULL;
    saltus_motion motion = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_classify_options how = saltus_classify_defaults();
    how.transient = transient;
    how.measure = measure;
    how.lifetime = how.measure / 24;
    saltus_status status = open_system(scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_classify(system, state, &how, &motion, &t->message);
    if (status == SALTUS_OK) {
        note_text(t, motion.label);
        note_reals(t, motion.state, 2);
        note_reals(t, &motion.lyapunov, 1);
    }
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return status;
}

static saltus_status classify_periodic(trial *t) {
    saltus_scene scene;
    load("fig3", &scene);
    return classify(t, &scene, 200, 0);
}

static saltus_status classify_irregular(trial *t) {
    saltus_scene scene;
    load("impact-oscillator", &scene);
    set_parameter(&scene.spec, "c", 0);
    set_parameter(&scene.spec, "omega", 0.618034);
    scene.spec.stops[0].d = 3;
    return classify(t, &scene, 400, 16000);
}

static saltus_status find_attractors(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_attractors found = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_classify_options how = saltus_classify_defaults();
    how.transient = 100;
    how.measure = 0;
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_attractors_find(system, 2, 1, &how, &found, &t->message);
    for (int k = 0; k < found.count; k++)
        note_text(t, found.motions[k].label);
    saltus_attractors_clear(&found);
    saltus_system_free(system);
    return status;
}

static saltus_status measure_exponents(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_lyapunov result = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_lyapunov_options how = saltus_lyapunov_defaults();
    how.exponents = 0;
    how.members = 2;
    how.transient = 20;
    how.periods = 800;
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_lyapunov_run(system, state, &how, &result, &t->message);
    if (status == SALTUS_OK)
        note_reals(t, result.exponents, 2);
    saltus_lyapunov_clear(&result);
    saltus_system_free(system);
    return status;
}

static saltus_status analyse_spectrum(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_spectra spectra = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_spectrum_options how = saltus_spectrum_defaults();
    how.periods = 32;
    how.segment = 8;
    how.per_period = 32;
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_spectra_run(system, state, 0, &how, &spectra, &t->message);
    if (status == SALTUS_OK)
        note(t, spectra.spectra[0].lines,
             (size_t)spectra.spectra[0].line_count * sizeof *spectra.spectra[0].lines);
    saltus_spectra_clear(&spectra);
    saltus_system_free(system);
    return status;
}

/* Tests of a series: points of a closed curve. */
static saltus_status ask_series(trial *t) {
    enum { count = 400 };
    double values[2 * count], series[count];
    const saltus_series_points points = {.values = values, .count = count, .dimension = 2};
    const saltus_series_options options = saltus_series_defaults();
    saltus_series_chaos chaos;
    saltus_series_dimension dimension;
    saltus_series_curve curve;
    double broadband = 0;
    for (int k = 0; k < count; k++) {
        values[2 * k] = series[k] = cos(2.399963 * k);
        values[2 * k + 1] = sin(2.399963 * k);
    }
    saltus_status status = saltus_series_chaos_test(series, count, &options, &chaos, &t->message);
    if (status == SALTUS_OK)
        status = saltus_series_correlation_dimension(&points, &options, &dimension, &t->message);
    if (status == SALTUS_OK)
        status = saltus_series_closed_curve(&points, &options, &curve, &t->message);
    if (status == SALTUS_OK)
        status = saltus_series_broadband(series, count, &broadband, &t->message);
    note_reals(t, &broadband, 1);
    return status;
}

static saltus_status harvest_orbits(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_harvest harvest = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_harvest_options how = saltus_harvest_defaults();
    how.longest = 2;
    how.transient = 20;
    how.periods = 40;
    how.tries = 2;
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_harvest_run(system, &how, &harvest, &t->message);
    for (int k = 0; k < harvest.count; k++)
        note_reals(t, harvest.orbits[k].orbit.state, 2);
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
    return status;
}

/* A branch of the oscillator's orbits, and a curve of their grazing points, into files. */
static saltus_branch_options branch_options(void) {
    saltus_branch_options how = saltus_branch_defaults();
    strcpy(how.key[0], "F");
    how.low[0] = 0.05;
    how.high[0] = 0.6;
    how.direction = -1;
    how.points = 8;
    how.step = 0.1;
    how.step_max = 0.2;
    return how;
}

static saltus_status follow_from(trial *t, const saltus_branch_options *how, const saltus_scene *scene,
                                 int periods, const double *state, int most) {
    saltus_branch *branch = NULL;
    saltus_branch_output *output = NULL;
    const saltus_branch_point *point = NULL;
    int made = 0;
    saltus_status status = saltus_branch_new(&scene->spec, periods, state, how, &branch, &t->message);
    if (status == SALTUS_OK)
        status = saltus_branch_output_open(t->path, scene, periods, state, how, NULL, &output, &t->message);
    do {
        if (status == SALTUS_OK)
            status = saltus_branch_step(branch, &point, &t->message);
        if (status == SALTUS_OK && point) {
            note_reals(t, point->value, 1);
            note(t, &point->kind, sizeof point->kind);
            status = saltus_branch_output_add(output, point, &t->message);
        }
    } while (status == SALTUS_OK && point && ++made < most);
    saltus_status closed = saltus_branch_output_close(output, true, status == SALTUS_OK ? &t->message : NULL);
    saltus_branch_free(branch);
    return status == SALTUS_OK ? closed : status;
}

static saltus_status follow_branch(trial *t, const saltus_branch_options *how, double force, int most) {
    saltus_scene scene;
    saltus_system *system = NULL;
    double state[SALTUS_SCENE_STATE_MAX];
    load("impact-oscillator", &scene);
    set_parameter(&scene.spec, "F", force);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_motion_settle(system, &how->orbit.flow, 200, state, &t->message);
    if (status == SALTUS_OK)
        status = follow_from(t, how, &scene, 1, state, most);
    saltus_system_free(system);
    return status;
}

static saltus_status continue_branch(trial *t) {
    const saltus_branch_options how = branch_options();
    return follow_branch(t, &how, 0.5, 12);
}

static saltus_status continue_locus(trial *t) {
    saltus_branch_options how = branch_options();
    how.locus = SALTUS_POINT_GR;
    strcpy(how.key[1], "d");
    how.low[1] = 0.5;
    how.high[1] = 1.5;
    return follow_branch(t, &how, 0.105, 3); /* just above grazing */
}

/* Equilibria past a Hopf point and a stop, and the curve of Hopf points. */
static saltus_status follow_rests(trial *t, saltus_point_kind locus) {
    static const char text[] = "model:\n  parameters: {mu: {default: -0.2}, F: {default: 0}}\n"
                               "  motion: {x: mu*x' - x^2*x' - x + F + 4*mu}\n"
                               "stop: {coordinate: x, d: 1, r: 0.5, sides: upper}\n";
    saltus_branch_options how = branch_options();
    saltus_scene scene;
    const double rest[2] = {-0.8, 0};
    strcpy(how.key[0], "mu");
    how.low[0] = -0.2;
    how.high[0] = 0.4;
    how.direction = 1;
    how.locus = locus;
    strcpy(how.key[1], locus ? "F" : "");
    how.low[1] = -0.1;
    how.high[1] = 0.1;
    saltus_status status = saltus_scene_parse(text, sizeof text - 1, "rests", &scene, &t->message);
    if (status != SALTUS_OK)
        return status;
    status = follow_from(t, &how, &scene, 0, rest, 12);
    saltus_scene_clear(&scene);
    return status;
}

static saltus_status continue_rests(trial *t) {
    return follow_rests(t, SALTUS_POINT_REGULAR);
}

static saltus_status continue_hopf(trial *t) {
    return follow_rests(t, SALTUS_POINT_HB);
}

static saltus_status run_sweep(trial *t, const saltus_axis *axes, int count, bool basins) {
    saltus_scene scene;
    saltus_sweep *sweep = NULL;
    saltus_sweep_output *output = NULL;
    saltus_sweep_options how = saltus_sweep_defaults();
    how.threads = 1;
    how.seeds = basins ? 1 : 2;
    how.transient = 60;
    how.record = basins ? 1 : 4;
    how.measure = 600;
    how.lifetime = how.measure / 24;
    how.keep =
        basins ? 0
               : SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC | SALTUS_KEEP_LYAPUNOV;
    load("impact-oscillator", &scene);
    saltus_status status = saltus_sweep_new(&scene, axes, count, &how, &sweep, &t->message);
    if (status == SALTUS_OK)
        status = saltus_sweep_output_open(t->path, sweep, basins, false, NULL, &output, &t->message);
    const saltus_sweep_feed feed = {.context = output, .take = take_result};
    if (status == SALTUS_OK)
        status = saltus_sweep_run(sweep, &feed, &t->message);
    saltus_status closed = saltus_sweep_output_close(output, status == SALTUS_OK ? &t->message : NULL);
    saltus_sweep_free(sweep);
    return status == SALTUS_OK ? closed : status;
}

static saltus_status sweep_parameters(trial *t) {
    const saltus_axis axes[] = {{.key = "omega", .count = 2, .low = 0.8, .high = 1}};
    return run_sweep(t, axes, 1, false);
}

static saltus_status sweep_states(trial *t) {
    const saltus_axis axes[] = {{.key = "q1", .count = 2, .low = 0, .high = 0.25},
                                {.key = "v1", .count = 1, .low = 0, .high = 0}};
    return run_sweep(t, axes, 2, true);
}

static saltus_status read_axis(trial *t) {
    saltus_axis axis;
    double *list = NULL;
    saltus_status status = saltus_axis_read("d=1,2,3", &axis, &list, &t->message);
    note_reals(t, &axis.high, 1);
    free(list);
    return status;
}

/* A recorded trajectory as CSV or HDF5. */
static saltus_status record(trial *t, const char *ending) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_trajectory made = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    const saltus_flow_options how = saltus_flow_defaults();
    char path[160];
    snprintf(path, sizeof path, "%s%s", t->path, ending);
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_trajectory_record(system, state, &how, 2, 40, 4, &made, &t->message);
    if (status == SALTUS_OK)
        status = saltus_write_trajectory(path, &scene, system, &how, &made, NULL, &t->message);
    if (status == SALTUS_OK)
        note_file(t, path);
    saltus_trajectory_clear(&made);
    saltus_system_free(system);
    return status;
}

/* The second row of the second point of a pass up. */
static saltus_status sweep_again(trial *t) {
    const saltus_axis axis = {.key = "omega", .count = 2, .low = 0.8, .high = 1};
    saltus_scene scene;
    saltus_sweep *sweep = NULL;
    saltus_sweep_row row;
    double state[SALTUS_SCENE_STATE_MAX] = {0};
    saltus_sweep_options how = saltus_sweep_defaults();
    how.passes = 1u << SALTUS_PASS_UP;
    how.seeds = 2;
    how.transient = 60;
    load("impact-oscillator", &scene);
    saltus_status status = saltus_sweep_new(&scene, &axis, 1, &how, &sweep, &t->message);
    if (status == SALTUS_OK)
        status = saltus_sweep_row_again(sweep, 3, &row, state, &t->message);
    note_reals(t, state, 2);
    saltus_sweep_free(sweep);
    return status;
}

static saltus_status record_csv(trial *t) {
    return record(t, ".csv");
}

static saltus_status record_hdf5(trial *t) {
    return record(t, ".h5");
}

/* Files to read, in the folder of the program's run. */
static char kept_branch[128], kept_sweep[128], kept_basins[128], kept_orbit[128];

static saltus_status read_branch(trial *t) {
    saltus_branch_file file = {0};
    saltus_status status = saltus_branch_file_read(kept_branch, &file, &t->message);
    for (int k = 0; k < file.point_count; k++)
        note_reals(t, file.points[k].value, 1);
    saltus_branch_file_clear(&file);
    return status;
}

static saltus_status read_sweep(trial *t) {
    saltus_sweep_file file = {0};
    char path[160];
    snprintf(path, sizeof path, "%s.csv", t->path);
    saltus_status status = saltus_sweep_file_read(kept_sweep, &file, &t->message);
    for (int table = SALTUS_TABLE_ROWS; table <= SALTUS_TABLE_STROBES && status == SALTUS_OK; table++) {
        status = saltus_write_sweep_csv(path, &file, (saltus_table)table, &t->message);
        if (status == SALTUS_OK)
            note_file(t, path);
    }
    saltus_sweep_file_clear(&file);
    return status;
}

static saltus_status read_basins(trial *t) {
    saltus_sweep_file file = {0};
    saltus_status status = saltus_sweep_file_read(kept_basins, &file, &t->message);
    note(t, &file.attractor_count, sizeof file.attractor_count);
    saltus_sweep_file_clear(&file);
    return status;
}

static saltus_status read_start(trial *t) {
    char source[160];
    saltus_start start;
    saltus_scene scene;
    load("impact-oscillator", &scene);
    saltus_status status = saltus_start_read(kept_orbit, NULL, &start, &t->message);
    note_reals(t, start.state, 2);
    if (status == SALTUS_OK)
        status = saltus_start_apply(&start, kept_orbit, &scene, &t->message);
    snprintf(source, sizeof source, "%s:1", kept_branch);
    if (status == SALTUS_OK)
        status = saltus_start_read(source, NULL, &start, &t->message);
    note_reals(t, start.state, 2);
    return status;
}

/* The data of figures: gnuplot cannot be run (SALTUS_IO), but everything before it is. */
static saltus_status draw_branch(trial *t) {
    const char *const paths[] = {kept_branch};
    const saltus_plot_options how = saltus_plot_defaults();
    char figure[160];
    snprintf(figure, sizeof figure, "%s.svg", t->path);
    return saltus_plot(figure, paths, 1, &how, &t->message);
}

static saltus_status draw_sweep(trial *t) {
    char figure[160];
    const saltus_sweep_view turning = {.view = SALTUS_VIEW_TURNING}, plane = {.view = SALTUS_VIEW_AUTOMATIC};
    snprintf(figure, sizeof figure, "%s.svg", t->path);
    saltus_status status = saltus_plot_sweep(figure, kept_sweep, &turning, &t->message);
    return status == SALTUS_IO ? saltus_plot_sweep(figure, kept_basins, &plane, &t->message) : status;
}

static saltus_status draw_sheet(trial *t) {
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_motion motion = {0};
    saltus_trajectory made = {0};
    saltus_spectra spectra = {0};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_classify_options how = saltus_classify_defaults();
    saltus_spectrum_options lines = saltus_spectrum_defaults();
    char figure[160];
    how.transient = 200;
    lines.periods = 2;
    lines.per_period = 64;
    lines.quantity_count = 1;
    snprintf(figure, sizeof figure, "%s.svg", t->path);
    load("impact-oscillator", &scene);
    saltus_status status = open_system(&scene, &system, state, t);
    if (status == SALTUS_OK)
        status = saltus_classify(system, state, &how, &motion, &t->message);
    if (status == SALTUS_OK)
        status = saltus_trajectory_record(system, motion.state, &how.flow, 0, 1, 60, &made, &t->message);
    if (status == SALTUS_OK)
        status = saltus_motion_spectra(system, &motion, &lines, &spectra, &t->message);
    const saltus_diagnosis diagnosis = {&motion, &made, NULL, &spectra};
    if (status == SALTUS_OK)
        status = saltus_write_sheet(figure, &scene, system, &how.flow, &diagnosis, NULL, NULL, &t->message);
    saltus_spectra_clear(&spectra);
    saltus_trajectory_clear(&made);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return status;
}

/* One run with the k-th allocation failing (-1: none), in a folder with one existing file. */
static saltus_status attempt(saltus_status (*operation)(trial *), trial *t, long k) {
    static const char before[] = "what was there before\n";
    size_t length;
    t->hash = 0xcbf29ce484222325u;
    t->message.text[0] = '\0';
    FILE *file = fopen(t->path, "wb");
    assert_true(file && fputs(before, file) >= 0 && fclose(file) == 0);
    allocations = 0;
    failing = k;
    saltus_status status = operation(t);
    failing = -1;
    char *after = read_all(t->path, &length);
    bool whole = length > 24 && memcmp(after + length - 24, "saltus:", 7) == 0;
    if (strcmp(after, before) != 0 && !whole)
        fail_msg("allocation %ld: a file of %zu bytes that is not whole", k, length);
    if (whole && status == SALTUS_OK)
        note_file(t, t->path);
    free(after);
    return status;
}

/* Fail if there are files other than the target and a sweep's journal. */
static void check_folder(trial *t, long k) {
    DIR *folder = opendir(t->folder);
    assert_non_null(folder);
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder))
        if (strstr(entry->d_name, ".part"))
            fail_msg("allocation %ld leaves %s", k, entry->d_name);
    closedir(folder);
    folder_files(t->folder, true);
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The spacing of the allocations that fail: all, or as many as time allows. */
static long stride(long count, double once) {
    double most = getenv("SALTUS_SANITIZED") ? 0.3 : 0.7;
    double runs = fmax(most / fmax(once, 1e-6), 12);
    return long_version() || (double)count <= runs ? 1 : (long)((double)count / runs) + 1;
}

static void fail_each(const char *name, saltus_status (*operation)(trial *)) {
    trial t = {.hash = 0};
    strcpy(t.folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(t.folder));
    snprintf(t.path, sizeof t.path, "%s/result.h5", t.folder);
    attempt(operation, &t, -1); /* allocations that libraries make only once */
    check_folder(&t, 0);
    double begin = seconds();
    saltus_status expected = attempt(operation, &t, -1);
    saltus_message said = t.message;
    uint64_t hash = t.hash;
    /* Without a failure the operation completes, unless it is meant to be refused. */
    const saltus_status meant = strncmp(name, "draw", 4) == 0         ? SALTUS_IO
                                : strcmp(name, "read_bad_scene") == 0 ? SALTUS_BAD_INPUT
                                                                      : SALTUS_OK;
    if (expected != meant || (meant == SALTUS_IO && !strstr(said.text, "gnuplot")))
        fail_msg("%s: %s, '%s'", name, saltus_status_name(expected), said.text);
    long count = allocations, apart = stride(count, seconds() - begin), refused = 0, tried = 0;
    check_folder(&t, 0);
    for (long k = 1; k <= count; k += apart, tried++) {
        saltus_status status = attempt(operation, &t, k);
        bool same = status == expected && t.hash == hash && strcmp(t.message.text, said.text) == 0;
        if (!same && (status != SALTUS_NO_MEMORY || !t.message.text[0]))
            fail_msg("%s: allocation %ld of %ld: %s, '%s'%s", name, k, count, saltus_status_name(status),
                     t.message.text, status == expected ? " (another result)" : "");
        refused += status == SALTUS_NO_MEMORY;
        check_folder(&t, k);
    }
    assert_true(refused > 0);
    saltus_status again = attempt(operation, &t, -1);
    check_folder(&t, 0);
    assert_int_equal(again, expected);
    assert_true(t.hash == hash);
    rmdir(t.folder);
    print_message("%s: %ld allocations, %ld of them failing, %ld refused\n", name, count, tried, refused);
}

#define OPERATIONS(X)                                                                                        \
    X(read_scene)                                                                                            \
    X(read_bad_scene)                                                                                        \
    X(set_scene)                                                                                             \
    X(follow_flow)                                                                                           \
    X(step_maps)                                                                                             \
    X(find_orbit)                                                                                            \
    X(find_rest)                                                                                             \
    X(classify_periodic)                                                                                     \
    X(classify_irregular)                                                                                    \
    X(find_attractors)                                                                                       \
    X(measure_exponents)                                                                                     \
    X(analyse_spectrum)                                                                                      \
    X(ask_series)                                                                                            \
    X(harvest_orbits)                                                                                        \
    X(continue_branch)                                                                                       \
    X(continue_locus)                                                                                        \
    X(continue_rests)                                                                                        \
    X(continue_hopf)                                                                                         \
    X(read_axis)                                                                                             \
    X(sweep_parameters)                                                                                      \
    X(sweep_states)                                                                                          \
    X(sweep_again)                                                                                           \
    X(describe_rest)                                                                                         \
    X(record_csv)                                                                                            \
    X(record_hdf5)                                                                                           \
    X(read_branch)                                                                                           \
    X(read_sweep)                                                                                            \
    X(read_basins)                                                                                           \
    X(read_start)                                                                                            \
    X(draw_branch)                                                                                           \
    X(draw_sweep)                                                                                            \
    X(draw_sheet)

#define TEST(operation)                                                                                      \
    static void test_##operation(void **unused) {                                                            \
        (void)unused;                                                                                        \
        fail_each(#operation, operation);                                                                    \
    }
OPERATIONS(TEST)

/* Write the files to be read. */
static int keep_files(void **state) {
    static trial t;
    static const struct {
        saltus_status (*make)(trial *);
        char *path;
    } kept[] = {{continue_branch, kept_branch}, {sweep_parameters, kept_sweep}, {sweep_states, kept_basins}};
    strcpy(t.folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(t.folder));
    for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) {
        snprintf(kept[k].path, sizeof kept_branch, "%s/%zu.h5", t.folder, k);
        snprintf(t.path, sizeof t.path, "%s", kept[k].path);
        check_ok(kept[k].make(&t), &t.message);
    }
    snprintf(kept_orbit, sizeof kept_orbit, "%s/orbit.json", t.folder);
    FILE *file = fopen(kept_orbit, "w");
    assert_non_null(file);
    fputs(
        "{\"version\": \"0\", \"label\": \"1/1\", \"periods\": 1, \"parameters\": {\"model\": \"oscillator\"",
        file);
    saltus_spec spec = saltus_spec_defaults(saltus_model_find("oscillator"));
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec.model, &count);
    for (int k = 0; k < count; k++)
        fprintf(file, ", \"%s\": %.17g", p[k].name, spec.parameters[k]);
    fputs(", \"stops\": [{\"weight\": [1], \"d\": 1}]}, \"state\": [0.5, 0.25]}\n", file);
    assert_int_equal(fclose(file), 0);
    setenv("PATH", "/nonexistent", 1);
    *state = t.folder;
    return 0;
}

static int remove_files(void **state) {
    folder_files(*state, true);
    return rmdir(*state);
}

int main(void) {
#define ENTRY(operation) cmocka_unit_test(test_##operation),
    const struct CMUnitTest tests[] = {OPERATIONS(ENTRY)};
    return cmocka_run_group_tests(tests, keep_files, remove_files);
}
