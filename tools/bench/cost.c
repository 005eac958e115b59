/* Costs of the parts of a run, measured on the pipe at omega = 42 unless a row says otherwise.
 *
 * Times are medians over repeated stretches of the same settled motion. Steps, and evaluations of the field
 * per step (for Taylor series: orders expanded), are counted by the library and free of noise; a scene that
 * does not use a feature should need no more of either.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cost.h"

#include "measure.h"

enum { stretches = 9 };

/* Features switched on in a run. */
typedef struct asked {
    const char *what;
    bool stop;
    double d;
    saltus_sides sides;
    unsigned watch;
    bool dense;
    int columns, directions;
    double rtol;
    saltus_integrator integrator;
} asked;

/* Means over a stretch. */
typedef struct spent {
    double us, steps, impacts, evaluations;
} spent;

static void add_row(cost_table *costs, const char *table, const char *what, const spent *s, double base) {
    cost_row *row = &costs->rows[costs->count < cost_rows_max - 1 ? costs->count++ : cost_rows_max - 1];
    *row = (cost_row){table, "", s->us, s->steps, s->evaluations, s->impacts, s->us / base};
    snprintf(row->what, sizeof row->what, "%s", what);
}

static void set_parameter(saltus_spec *spec, const char *name, double value) {
    spec->parameters[saltus_model_parameter_index(spec->model, name)] = value;
}

static saltus_spec pipe_of(double omega, int modes) {
    saltus_spec spec = saltus_spec_defaults(saltus_model_find("pipe"));
    set_parameter(&spec, "omega", omega);
    set_parameter(&spec, "N", modes);
    return spec;
}

static void set_stop(saltus_spec *spec, const asked *a) {
    spec->stop_count = a->stop;
    spec->stops[0] = saltus_stop_defaults();
    spec->stops[0].d = a->d;
    if (a->stop)
        spec->stops[0].sides = a->sides ? a->sides : SALTUS_UPPER;
}

/* Advance lane 0 to a period, stopping at the requested events. */
static bool advance(saltus_flow *flow, const asked *a, long long until) {
    const saltus_time end = {until, 0};
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_event event;
    do {
        if (saltus_flow_advance(flow, end, a->watch | (a->dense ? SALTUS_WATCH_STEP : 0), &event, NULL) !=
            SALTUS_OK)
            return false;
        if (a->dense && event.kind == SALTUS_STEP)
            saltus_flow_dense(flow, 0, 0.5 * saltus_flow_step_length(flow, 0), state);
    } while (event.kind != SALTUS_REACHED);
    return true;
}

/* The tangent vectors restart in each stretch: over a long run they would grow or shrink too far. */
static bool measure_stretches(saltus_flow *flow, const saltus_system *system, const asked *a, int settle,
                              int length, spent *s) {
    const int n = saltus_system_dimension(system);
    double seconds[stretches], *tangents = calloc((size_t)(a->columns * n) + 1, sizeof *tangents);
    bool done = tangents && advance(flow, &(asked){.what = ""}, settle);
    for (int c = 0; c < a->columns && tangents; c++)
        tangents[c * n + c % n] = 1;
    const saltus_flow_info before = saltus_flow_information(flow, 0);
    for (int k = 0; k < stretches && done; k++) {
        if (a->columns > 0)
            saltus_flow_set_tangents(flow, 0, tangents);
        const double start = processor_seconds();
        done = advance(flow, a, settle + (k + 1LL) * length);
        seconds[k] = (processor_seconds() - start) / length;
    }
    free(tangents);
    if (!done)
        return false;
    const saltus_flow_info after = saltus_flow_information(flow, 0);
    const double periods = (double)stretches * length;
    *s = (spent){.us = 1e6 * median(seconds, stretches),
                 .steps = (double)(after.steps - before.steps) / periods,
                 .impacts = (double)(after.impacts - before.impacts) / periods,
                 .evaluations = (double)(after.field_evaluations - before.field_evaluations) /
                                (double)(after.steps - before.steps)};
    return true;
}

/* `start` may be NULL: the default state. */
static bool measure_run(const saltus_spec *spec, const asked *a, const double *start, int settle, int length,
                        spent *s) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_direction direction;
    saltus_message message = {.text = ""};
    double state[SALTUS_SCENE_STATE_MAX];
    options.columns = a->columns;
    options.directions = a->directions;
    options.integrator = a->integrator;
    if (a->rtol > 0) {
        options.rtol = a->rtol;
        options.atol = 1e-3 * a->rtol;
    }
    bool done = saltus_system_new(spec, &system, &message) == SALTUS_OK &&
                saltus_system_default_state(system, state, &message) == SALTUS_OK &&
                saltus_flow_new(&(const saltus_system *){system}, 1, &options, &flow, NULL) == SALTUS_OK;
    if (done && a->directions > 0 &&
        saltus_spec_direction(saltus_system_spec(system), "omega", &direction, NULL, NULL) == SALTUS_OK)
        saltus_flow_set_directions(flow, &direction);
    done = done &&
           saltus_flow_start(flow, 0, (saltus_time){0, 0}, start ? start : state, &message) == SALTUS_OK &&
           measure_stretches(flow, system, a, settle, length, s);
    if (!done)
        fprintf(stderr, "saltus_bench: %s: %s\n", a->what, message.text);
    saltus_flow_free(flow);
    saltus_system_free(system);
    return done;
}

static bool cost_of_features(cost_table *costs, int settle, int length) {
    static const asked features[] = {
        {.what = "no stop"},
        {.what = "stop that is never reached", .stop = true, .d = 1},
        {.what = "two-sided stop that is never reached", .stop = true, .d = 1, .sides = SALTUS_BOTH},
        {.what = "stop at d = 0.035", .stop = true, .d = 0.035},
        {.what = "the same, every impact handed out", .stop = true, .d = 0.035, .watch = SALTUS_WATCH_IMPACT},
        {.what = "no stop, turning points located", .watch = SALTUS_WATCH_TURNING},
        {.what = "no stop, dense output once in a step", .dense = true},
        {.what = "no stop, 1 tangent vector", .columns = 1},
        {.what = "no stop, 2 tangent vectors", .columns = 2},
        {.what = "no stop, 10 tangent vectors", .columns = 10},
        {.what = "no stop, 1 parameter column", .columns = 1, .directions = 1},
        {.what = "stop at d = 0.035, 10 tangent vectors", .stop = true, .d = 0.035, .columns = 10},
    };
    double base = NAN;
    for (size_t k = 0; k < sizeof features / sizeof features[0]; k++) {
        saltus_spec spec = pipe_of(42, 5);
        spent s;
        set_stop(&spec, &features[k]);
        if (!measure_run(&spec, &features[k], NULL, settle, length, &s))
            return false;
        base = k == 0 ? s.us : base;
        add_row(costs, "features", features[k].what, &s, base);
    }
    return true;
}

/* Terms of the field: in all four scenes an undamped straight pipe (u0 = 2) oscillates forever. */
static bool cost_of_terms(cost_table *costs, int length) {
    static const struct {
        const char *what;
        double sigma, kappa;
    } terms[] = {
        {"all terms", 0.2, 5000}, {"sigma = 0", 0, 5000}, {"kappa = 0", 0.2, 0}, {"sigma = kappa = 0", 0, 0}};
    const double start[SALTUS_SCENE_STATE_MAX] = {0.01, 0.002};
    double base = NAN;
    for (size_t k = 0; k < sizeof terms / sizeof terms[0]; k++) {
        saltus_spec spec = pipe_of(42, 5);
        spent s;
        set_parameter(&spec, "u0", 2);
        set_parameter(&spec, "alpha", 0);
        set_parameter(&spec, "sigma", terms[k].sigma);
        set_parameter(&spec, "kappa", terms[k].kappa);
        if (!measure_run(&spec, &(asked){.what = terms[k].what}, start, 0, length, &s))
            return false;
        s.us /= s.steps;
        base = k == 0 ? s.us : base;
        add_row(costs, "terms", terms[k].what, &s, base);
    }
    return true;
}

static bool cost_of_modes(cost_table *costs, int settle, int length) {
    static const int modes[] = {1, 2, 5, 10, 20, 32};
    for (int stop = 0; stop < 2; stop++) {
        double base = NAN;
        for (size_t k = 0; k < sizeof modes / sizeof modes[0]; k++) {
            const asked a = {.what = stop ? "stop at d = 0.035" : "no stop", .stop = stop, .d = 0.035};
            saltus_spec spec = pipe_of(42, modes[k]);
            char what[96];
            spent s;
            set_stop(&spec, &a);
            if (!measure_run(&spec, &a, NULL, settle, length, &s))
                return false;
            base = modes[k] <= 5 ? s.us : base;
            snprintf(what, sizeof what, "N = %d, %s", modes[k], a.what);
            add_row(costs, "modes", what, &s, modes[k] < 5 ? NAN : base);
        }
    }
    return true;
}

/* The automatically chosen integrator compared with the other one; the ratio should be about one where the
 * choice changes. */
static bool cost_of_choice(cost_table *costs, int settle, int length) {
    static const int modes[] = {8, 9, 10, 11, 12, 13, 14, 16};
    for (int kind = 0; kind < 3; kind++)
        for (size_t k = 0; k < sizeof modes / sizeof modes[0]; k++) {
            const bool stop = kind > 0, tangents = kind == 2;
            asked a = {.what = stop ? "stop at d = 0.035" : "no stop",
                       .stop = stop,
                       .d = 0.035,
                       .rtol = 1e-10,
                       .columns = tangents ? 2 * modes[k] : 0};
            saltus_spec spec = pipe_of(42, modes[k]);
            saltus_system *system = NULL;
            char what[96];
            spent s, other;
            set_stop(&spec, &a);
            if (saltus_system_new(&spec, &system, NULL) != SALTUS_OK)
                return false;
            const bool stiff = strcmp(saltus_system_integrator(system), "mixed") == 0;
            saltus_system_free(system);
            snprintf(what, sizeof what, "N = %d, %s%s: %s", modes[k], a.what,
                     tangents ? ", 2 N tangent vectors" : "", stiff ? "mixed" : "Taylor");
            bool done = measure_run(&spec, &a, NULL, settle, tangents ? length / 4 : length, &s);
            a.integrator = stiff ? SALTUS_TAYLOR : SALTUS_MIXED;
            done = done && measure_run(&spec, &a, NULL, settle, tangents ? length / 4 : length, &other);
            if (!done)
                return false;
            add_row(costs, "choice", what, &s, other.us);
        }
    return true;
}

/* Classification compared with the flow over the same periods until it settles. */
static bool cost_of_classification(cost_table *costs) {
    enum { repeats = 5 };
    saltus_spec spec = pipe_of(42, 5);
    saltus_system *system = NULL;
    saltus_classify_options options = saltus_classify_defaults();
    double state[SALTUS_SCENE_STATE_MAX], end[SALTUS_SCENE_STATE_MAX], seconds[2][repeats];
    spent plain = {.steps = NAN, .impacts = NAN, .evaluations = NAN}, classified = plain;
    options.measure = 0;
    set_stop(&spec, &(asked){.stop = true, .d = 0.035});
    bool done = saltus_system_new(&spec, &system, NULL) == SALTUS_OK &&
                saltus_system_default_state(system, state, NULL) == SALTUS_OK;
    for (int k = 0; k < repeats && done; k++) {
        saltus_motion motion = {0};
        double start = processor_seconds();
        done = saltus_classify(system, state, &options, &motion, NULL) == SALTUS_OK;
        if (!done)
            break;
        seconds[1][k] = (processor_seconds() - start) / (double)motion.transient;
        memcpy(end, state, (size_t)saltus_system_dimension(system) * sizeof *end);
        start = processor_seconds();
        done = saltus_motion_settle(system, &options.flow, motion.transient, end, NULL) == SALTUS_OK;
        seconds[0][k] = (processor_seconds() - start) / (double)motion.transient;
        saltus_motion_clear(&motion);
    }
    if (done) {
        plain.us = 1e6 * median(seconds[0], repeats);
        classified.us = 1e6 * median(seconds[1], repeats);
        add_row(costs, "classification", "flow alone until it has settled", &plain, plain.us);
        add_row(costs, "classification", "classified: period found, orbit polished, multipliers", &classified,
                plain.us);
    }
    saltus_system_free(system);
    return done;
}

bool cost_measure(cost_table *costs, bool quick) {
    const int settle = quick ? 50 : 100, length = quick ? 20 : 100;
    return cost_of_features(costs, settle, 4 * length) && cost_of_terms(costs, length / 5) &&
           cost_of_classification(costs) && cost_of_modes(costs, settle, length / 2) &&
           cost_of_choice(costs, settle, length / 2);
}

/* A number as text; empty if not applicable. */
static const char *number(const char *format, double value, char text[32]) {
    text[0] = '\0';
    if (!isnan(value))
        snprintf(text, 32, format, value);
    return text;
}

void cost_csv(FILE *file, const cost_table *costs) {
    char us[32], steps[32], evaluations[32], impacts[32], ratio[32];
    fprintf(file, "table,what,us,steps,evaluations_per_step,impacts,ratio\n");
    for (int k = 0; k < costs->count; k++) {
        const cost_row *row = &costs->rows[k];
        fprintf(file, "%s,\"%s\",%s,%s,%s,%s,%s\n", row->table, row->what, number("%.4g", row->us, us),
                number("%.4g", row->steps, steps), number("%.4g", row->evaluations, evaluations),
                number("%.4g", row->impacts, impacts), number("%.3f", row->ratio, ratio));
    }
}

static void print_table(FILE *file, const cost_table *costs, const char *table, const char *head,
                        const char *unit) {
    char steps[32], evaluations[32], impacts[32], ratio[32];
    fprintf(file,
            "| %s | %s | ratio | steps | evaluations in a step | impacts |\n"
            "| --- | --- | --- | --- | --- | --- |\n",
            head, unit);
    for (int k = 0; k < costs->count; k++) {
        const cost_row *row = &costs->rows[k];
        if (strcmp(row->table, table) != 0)
            continue;
        fprintf(file, "| %s | %.4g | %s | %s | %s | %s |\n", row->what, row->us,
                number("%.2f", row->ratio, ratio), number("%.1f", row->steps, steps),
                number("%.4g", row->evaluations, evaluations), number("%.1f", row->impacts, impacts));
    }
    fprintf(file, "\n");
}

void cost_print(FILE *file, const cost_table *costs) {
    if (costs->count == 0)
        return;
    print_table(file, costs, "features", "what you pay for (pipe, N = 5, omega = 42)", "µs a period");
    print_table(file, costs, "terms", "terms of the field (u0 = 2, alpha = 0)", "µs a step");
    print_table(file, costs, "classification", "a verdict (d = 0.035)", "µs a period");
    fprintf(file,
            "Settled motion, rtol 1e-13. Evaluations of the field: orders of a Taylor series, or nodes of "
            "all sweeps of collocation.\n\n");
    print_table(file, costs, "modes", "modes (ratio to N = 5)", "µs a period");
    fprintf(file, "The integrator that is chosen, rtol 1e-10, and the ratio to the other one.\n\n");
    print_table(file, costs, "choice", "choice of the integrator", "µs a period");
}
