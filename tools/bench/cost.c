/* Costs of the parts of a run, measured on the pipe at omega = 42 unless a row says otherwise.
 *
 * Times are medians over repeated stretches of the same settled motion. Steps, and evaluations of the field
 * per step (for Taylor series: orders expanded), are counted by the library and free of noise; a scene that
 * does not use a feature should need no more of either.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "bench.h"

enum { stretches = 9 };

/* A run, and what is switched on in it. */
typedef struct asked {
    const char *table, *what;
    double d; /* of the stop; 0: none */
    saltus_sides sides;
    unsigned watch;
    bool dense;
    int columns, directions;
    bool undamped; /* a straight pipe (u0 = 2) that oscillates for ever, with these terms of the field */
    double sigma, kappa;
    double rtol;
    saltus_integrator integrator;
} asked;

/* Append a row; its ratio is to a time. */
static void add_row(cost_table *costs, const char *table, const char *what, cost_row row, double base) {
    row.table = table;
    row.ratio = row.us / base;
    snprintf(row.what, sizeof row.what, "%s", what);
    costs->rows[costs->count++] = row;
}

static saltus_spec pipe_of(const asked *a, int modes) {
    saltus_spec spec = saltus_spec_defaults(saltus_model_find("pipe"));
    saltus_spec_set(&spec, "omega", 42, NULL);
    saltus_spec_set(&spec, "N", modes, NULL);
    if (a->undamped) {
        saltus_spec_set(&spec, "u0", 2, NULL);
        saltus_spec_set(&spec, "alpha", 0, NULL);
        saltus_spec_set(&spec, "sigma", a->sigma, NULL);
        saltus_spec_set(&spec, "kappa", a->kappa, NULL);
    }
    spec.stop_count = a->d > 0;
    spec.stops[0] = saltus_stop_defaults();
    spec.stops[0].d = a->d;
    spec.stops[0].sides = a->sides ? a->sides : SALTUS_UPPER;
    return spec;
}

/* Advance lane 0 to a period, stopping at the requested events. */
static void advance(saltus_flow *flow, const asked *a, long long until) {
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_event event;
    saltus_message message = {.text = ""};
    do {
        must(saltus_flow_advance(flow, (saltus_time){until, 0}, a->watch | (a->dense ? SALTUS_WATCH_STEP : 0),
                                 &event, &message),
             &message);
        if (a->dense && event.kind == SALTUS_STEP)
            saltus_flow_dense(flow, 0, 0.5 * saltus_flow_step_length(flow, 0), state);
    } while (event.kind != SALTUS_REACHED);
}

/* Run, settle, and measure stretches of `length` periods. The tangent vectors restart in each: over a long
 * run they would grow or shrink too far. */
static cost_row measure_run(const asked *a, int modes, int settle, int length) {
    const saltus_spec spec = pipe_of(a, modes);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_direction direction;
    saltus_message message = {.text = ""};
    double state[SALTUS_SCENE_STATE_MAX], seconds[stretches];
    double *tangents = must_allocate((size_t)(2 * modes * a->columns) + 1, sizeof *tangents);
    for (int c = 0; c < a->columns; c++)
        tangents[c * 2 * modes + c % (2 * modes)] = 1;
    options.columns = a->columns;
    options.directions = a->directions;
    options.integrator = a->integrator;
    if (a->rtol > 0) {
        options.rtol = a->rtol;
        options.atol = 1e-3 * a->rtol;
    }
    must(saltus_system_new(&spec, &system, &message), &message);
    must(saltus_system_default_state(system, state, &message), &message);
    must(saltus_flow_new(&(const saltus_system *){system}, 1, &options, &flow, &message), &message);
    if (a->undamped)
        memcpy(state, (const double[10]){0.01, 0.002}, 10 * sizeof *state);
    if (a->directions > 0) {
        must(saltus_spec_direction(saltus_system_spec(system), "omega", &direction, NULL, &message),
             &message);
        saltus_flow_set_directions(flow, &direction);
    }
    must(saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, &message), &message);
    advance(flow, &(asked){.what = ""}, settle);
    const saltus_flow_info before = saltus_flow_information(flow, 0);
    for (int k = 0; k < stretches; k++) {
        if (a->columns > 0)
            saltus_flow_set_tangents(flow, 0, tangents);
        const double start = processor_seconds();
        advance(flow, a, settle + (k + 1LL) * length);
        seconds[k] = (processor_seconds() - start) / length;
    }
    const saltus_flow_info after = saltus_flow_information(flow, 0);
    const double periods = (double)stretches * length, steps = (double)(after.steps - before.steps);
    saltus_flow_free(flow);
    saltus_system_free(system);
    free(tangents);
    return (cost_row){.us = 1e6 * median(seconds, stretches),
                      .steps = steps / periods,
                      .impacts = (double)(after.impacts - before.impacts) / periods,
                      .evaluations = (double)(after.field_evaluations - before.field_evaluations) / steps};
}

/* Features, and terms of the field: these by the step. */
static void cost_of_features(cost_table *costs, int settle, int length) {
    static const char features[] = "features", terms[] = "terms";
    static const asked runs[] = {
        {.table = features, .what = "no stop"},
        {.table = features, .what = "stop that is never reached", .d = 1},
        {.table = features, .what = "two-sided stop that is never reached", .d = 1, .sides = SALTUS_BOTH},
        {.table = features, .what = "stop at d = 0.035", .d = 0.035},
        {.table = features,
         .what = "the same, every impact handed out",
         .d = 0.035,
         .watch = SALTUS_WATCH_IMPACT},
        {.table = features, .what = "no stop, turning points located", .watch = SALTUS_WATCH_TURNING},
        {.table = features, .what = "no stop, dense output once in a step", .dense = true},
        {.table = features, .what = "no stop, 1 tangent vector", .columns = 1},
        {.table = features, .what = "no stop, 2 tangent vectors", .columns = 2},
        {.table = features, .what = "no stop, 10 tangent vectors", .columns = 10},
        {.table = features, .what = "no stop, 1 parameter column", .columns = 1, .directions = 1},
        {.table = features, .what = "stop at d = 0.035, 10 tangent vectors", .d = 0.035, .columns = 10},
        {.table = terms, .what = "all terms", .undamped = true, .sigma = 0.2, .kappa = 5000},
        {.table = terms, .what = "sigma = 0", .undamped = true, .kappa = 5000},
        {.table = terms, .what = "kappa = 0", .undamped = true, .sigma = 0.2},
        {.table = terms, .what = "sigma = kappa = 0", .undamped = true},
    };
    double base = NAN;
    for (size_t k = 0; k < sizeof runs / sizeof runs[0]; k++) {
        const asked *a = &runs[k];
        cost_row s = measure_run(a, 5, a->undamped ? 0 : settle, a->undamped ? length / 20 : length);
        s.us /= a->undamped ? s.steps : 1;
        base = k == 0 || a->table != a[-1].table ? s.us : base;
        add_row(costs, a->table, a->what, s, base);
    }
}

/* The automatically chosen integrator compared with the other one; the ratio should be about one where the
 * choice changes. */
static void cost_of_choice(cost_table *costs, int settle, int length) {
    static const int modes[] = {8, 9, 10, 11, 12, 13, 14, 16};
    for (int kind = 0; kind < 3; kind++)
        for (size_t k = 0; k < sizeof modes / sizeof modes[0]; k++) {
            const bool stop = kind > 0, tangents = kind == 2;
            asked a = {.what = stop ? "stop at d = 0.035" : "no stop",
                       .d = stop ? 0.035 : 0,
                       .rtol = 1e-10,
                       .columns = tangents ? 2 * modes[k] : 0};
            const saltus_spec spec = pipe_of(&a, modes[k]);
            saltus_system *system = NULL;
            saltus_message message = {.text = ""};
            char what[96];
            must(saltus_system_new(&spec, &system, &message), &message);
            const bool stiff = strcmp(saltus_system_integrator(system), "mixed") == 0;
            saltus_system_free(system);
            snprintf(what, sizeof what, "N = %d, %s%s: %s", modes[k], a.what,
                     tangents ? ", 2 N tangent vectors" : "", stiff ? "mixed" : "Taylor");
            const cost_row row = measure_run(&a, modes[k], settle, tangents ? length / 4 : length);
            a.integrator = stiff ? SALTUS_TAYLOR : SALTUS_MIXED;
            add_row(costs, "choice", what, row,
                    measure_run(&a, modes[k], settle, tangents ? length / 4 : length).us);
        }
}

/* Classification compared with the flow over the same periods until it settles. */
static void cost_of_classification(cost_table *costs) {
    enum { repeats = 5 };
    const saltus_spec spec = pipe_of(&(asked){.d = 0.035}, 5);
    saltus_system *system = NULL;
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    double state[SALTUS_SCENE_STATE_MAX], end[SALTUS_SCENE_STATE_MAX], seconds[2][repeats];
    options.measure = 0;
    must(saltus_system_new(&spec, &system, &message), &message);
    must(saltus_system_default_state(system, state, &message), &message);
    for (int k = 0; k < repeats; k++) {
        saltus_motion motion;
        double start = processor_seconds();
        must(saltus_classify(system, state, &options, &motion, &message), &message);
        seconds[1][k] = (processor_seconds() - start) / (double)motion.transient;
        memcpy(end, state, (size_t)saltus_system_dimension(system) * sizeof *end);
        start = processor_seconds();
        must(saltus_motion_settle(system, &options.flow, motion.transient, end, &message), &message);
        seconds[0][k] = (processor_seconds() - start) / (double)motion.transient;
        saltus_motion_clear(&motion);
    }
    cost_row row = {.steps = NAN, .impacts = NAN, .evaluations = NAN};
    const double plain = 1e6 * median(seconds[0], repeats);
    row.us = plain;
    add_row(costs, "classification", "flow alone until it has settled", row, plain);
    row.us = 1e6 * median(seconds[1], repeats);
    add_row(costs, "classification", "classified: period found, orbit polished, multipliers", row, plain);
    saltus_system_free(system);
}

void cost_measure(cost_table *costs, bool quick) {
    const int settle = quick ? 50 : 100, length = quick ? 20 : 100;
    cost_of_features(costs, settle, 4 * length);
    cost_of_classification(costs);
    cost_of_choice(costs, settle, length / 2);
}

void cost_csv(FILE *file, const cost_table *costs) {
    fprintf(file, "table,what,us,steps,evaluations_per_step,impacts,ratio\n");
    for (int k = 0; k < costs->count; k++) {
        const cost_row *row = &costs->rows[k];
        fprintf(file, "%s,\"%s\",%.4g,", row->table, row->what, row->us);
        report_number(file, "%.4g", row->steps, ",");
        report_number(file, "%.4g", row->evaluations, ",");
        report_number(file, "%.4g", row->impacts, ",");
        report_number(file, "%.3f", row->ratio, "\n");
    }
}

void cost_print(FILE *file, const cost_table *costs) {
    static const struct {
        const char *table, *head, *unit, *before;
    } tables[] = {
        {"features", "what you pay for (pipe, N = 5, omega = 42)", "µs a period", ""},
        {"terms", "terms of the field (u0 = 2, alpha = 0)", "µs a step", ""},
        {"classification", "a verdict (d = 0.035)", "µs a period", ""},
        {"choice", "choice of the integrator", "µs a period",
         "Settled motion, rtol 1e-13. Evaluations of the field: orders of a Taylor series, or nodes of all "
         "sweeps of collocation.\n\nThe integrator that is chosen, rtol 1e-10, and the ratio to the other "
         "one.\n\n"}};
    for (size_t t = 0; t < sizeof tables / sizeof tables[0] && costs->count > 0; t++) {
        fprintf(file,
                "%s| %s | %s | ratio | steps | evaluations in a step | impacts |\n"
                "| --- | --- | --- | --- | --- | --- |\n",
                tables[t].before, tables[t].head, tables[t].unit);
        for (int k = 0; k < costs->count; k++) {
            const cost_row *row = &costs->rows[k];
            if (strcmp(row->table, tables[t].table) != 0)
                continue;
            fprintf(file, "| %s | %.4g | ", row->what, row->us);
            report_number(file, "%.2f", row->ratio, " | ");
            report_number(file, "%.1f", row->steps, " | ");
            report_number(file, "%.4g", row->evaluations, " | ");
            report_number(file, "%.1f", row->impacts, " |\n");
        }
        fprintf(file, "\n");
    }
}
