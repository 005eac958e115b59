/* saltus check: prints how a scene is understood.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"
#include "flow/fixed.h"
#include "interrupt.h"
#include "record/describe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const cli_option derivatives =
    CLI_OPTION("--derivatives", CLI_FLAG, NULL, "compare all derivatives with differences of whole runs");

/* The entries of the state, and the equations of a text model. */
static void print_equations(const saltus_system *system) {
    const int dof = saltus_system_dof(system), extra = saltus_system_extra(system),
              dimension = saltus_system_dimension(system);
    printf("state: %d numbers (", dimension);
    for (int i = 0; i < dimension; i++)
        if (i < 6 || i + 1 == dimension)
            printf("%s%s", i ? ", " : "", saltus_system_state_name(system, i).text);
        else if (i == 6)
            fputs(", ...", stdout);
    puts(")");
    for (int i = 0; i < dof + extra; i++) {
        char *right = saltus_system_right_side(system, i);
        if (right)
            printf("  %s%s = %s\n", saltus_system_state_name(system, i < dof ? i : i + dof).text,
                   i < dof ? "''" : "'", right);
        free(right);
    }
}

/* The mass matrix, the metric of impacts; the system has its inverse. */
static void print_metric(const saltus_system *system) {
    const int n = saltus_system_dof(system);
    const double *inverse = saltus_system_inverse_mass(system);
    bool identity = true, diagonal = true;
    for (int i = 0; i < n * n; i++) {
        bool on = i / n == i % n;
        identity = identity && inverse[i] == on;
        diagonal = diagonal && (on || inverse[i] == 0);
    }
    fputs("metric of impacts: ", stdout);
    if (identity || !diagonal)
        puts(identity ? "the identity" : "the mass matrix, which couples displacements; its inverse is");
    for (int i = 0; i < n && diagonal && !identity; i++)
        printf("%s%.9g%s", i ? ", " : "masses ", 1 / inverse[i * n + i], i + 1 < n ? "" : "\n");
    for (int i = 0; i < n * n && !diagonal; i++)
        printf("%s%.9g%s", i % n ? ", " : "  ", inverse[i], i % n + 1 < n ? "" : "\n");
}

/* A line for each column; fails if one is wrong. */
static saltus_status print_derivatives(const saltus_scene *scene, const saltus_system *system,
                                       saltus_message *message) {
    saltus_column_check *checks = calloc(SALTUS_COLUMN_CHECKS_MAX, sizeof *checks);
    double state[SALTUS_STATE_MAX];
    int count = 0, wrong = 0;
    saltus_status status = checks ? saltus_scene_state(scene, system, state, message) : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        status = saltus_columns_check(system, state, interrupt_flag(), checks, &count, message);
    if (status == SALTUS_OK)
        puts("derivatives of the flow, beside differences");
    for (int k = 0; k < count && status == SALTUS_OK; k++) {
        const saltus_column_check *c = &checks[k];
        printf("  by %-8s %s", c->name, c->agrees ? "" : "WRONG, ");
        if (isnan(c->difference))
            puts("not compared: no neighbouring run passes the same events");
        else
            printf("differs by %.1e of its size\n", c->difference);
        wrong += !c->agrees;
    }
    free(checks);
    return wrong ? saltus_fail(message, SALTUS_NO_CONVERGENCE,
                               "%d of %d derivatives do not agree with differences", wrong, count)
                 : status;
}

static saltus_status check_scene(const cli_request *request, cli_setup *setup, const char **cut,
                                 saltus_message *message) {
    int count;
    bool shift = false, symmetric = saltus_system_mirror_symmetric(setup->system, &shift);
    (void)cut;
    const saltus_spec *spec = &setup->scene.spec;
    const saltus_parameter *table = saltus_model_parameters(spec->model, &count);
    printf("%s: ok\nmodel: %s (%s)\n", setup->scene.name, saltus_model_name(spec->model),
           saltus_model_summary(spec->model));
    print_equations(setup->system);
    for (int k = 0; k < count; k++)
        printf("  %-6s %-12.9g %s\n", table[k].name, spec->parameters[k], table[k].meaning);
    const saltus_spec *built = saltus_system_spec(setup->system);
    for (int s = 0; s < built->stop_count; s++) {
        const saltus_stop *stop = &built->stops[s];
        const char *law = saltus_restitution_law(built, s);
        printf("stop %d: %s side%s, d = %g, r = %g, ", s + 1, saltus_sides_word(stop->sides),
               stop->sides == SALTUS_BOTH ? "s" : "", stop->d, stop->r);
        if (law)
            printf("which is the limit of %s at small closing speeds, ", law);
        saltus_put_stop_place(stdout, built, s, 6);
        fputc('\n', stdout);
    }
    if (spec->stop_count)
        print_metric(setup->system);
    printf("symmetry: %s\n", !symmetric ? "none found under a change of all signs"
                             : shift    ? "all signs changed, with half a period's shift"
                                        : "all signs changed");
    if (saltus_system_forced(setup->system))
        printf("forcing period T = %.15g, ", saltus_system_period(setup->system));
    else
        printf("no forcing: time is counted in units of %.15g, ", saltus_system_period(setup->system));
    printf("integrator %s\n", saltus_system_integrator(setup->system));
    char how[512];
    if (saltus_fixed_tell(setup->system, how, sizeof how))
        printf("equations: %s\n", how);
    return cli_given(request, "--derivatives") ? print_derivatives(&setup->scene, setup->system, message)
                                               : SALTUS_OK;
}

const cli_command cmd_check = {
    .name = "check",
    .summary = "what a scene means",
    .usage = "SCENE [--set key=value ...] [--derivatives]",
    .help = "Read a scene, check it and show what it means: the state, equations in normal form (masses "
            "divided out, numbers folded), parameters, stops, the metric of impacts, symmetry and forcing, "
            "and how the equations of a text are run (saltus help text, SPEED).\n"
            "With --derivatives the scene is run from its start over its first contact, where one comes "
            "within ten periods, otherwise over a quarter of one; the derivatives of the end by all entries "
            "of the start, all parameters and properties of stops are compared with differences of "
            "neighbouring runs. Exit status 1 when one is wrong.",
    .needs_scene = true,
    .options = CLI_OPTIONS(&cli_set, &derivatives),
    .examples =
        CLI_EXAMPLES({"check pipe --set N=4 omega=40", "parameters and stops of a scene with changes"},
                     {"scenes two-stops | saltus check -", "one from standard input"},
                     {"check duffing --derivatives", "the equations, and that all derivatives are right"}),
    .see = "text scenes",
    .work = check_scene,
};
