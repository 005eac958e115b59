/* saltus continue: a branch of periodic orbits or equilibria, or a locus of special points in two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "branch/options.h"
#include "interrupt.h"
#include "motion/options.h"
#include "progress.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { values_max = 256, narrow = 60 /* columns of a terminal */ };

static const cli_option range = CLI_OPTION(
    "--in", CLI_TEXT, "key=lo:hi", "the parameter to continue in, and its range, which ends where scenes do");
static const cli_option second_range =
    CLI_OPTION("--and", CLI_TEXT, "key=lo:hi", "the second parameter of a locus");
static const cli_option periods = CLI_NUMBER(
    "--periods", "p", "period of the orbit to start from, where it is not that of --from", 0, 1, 1e6);
static const cli_option values =
    CLI_OPTION("--at", CLI_TEXT, "v[,v...]", "values of the parameter to compute a point (UZ) at");
static const cli_option json =
    CLI_OPTION("--json", CLI_FLAG, NULL, "one JSON object for each point on stdout");

/* One run: its start, its options and its results. */
typedef struct run_state {
    const cli_request *request;
    cli_setup setup;
    saltus_branch_options options;
    double values[values_max];
    saltus_branch *branch;
    saltus_branch_output *output;
    saltus_branch_file earlier; /* the file of the interrupted run */
    int rows, branches;
    bool interrupted;
} run_state;

/* The options of the continuation from the command line; false after a message. */
static bool read_options(run_state *run) {
    const cli_request *r = run->request;
    const char *range = cli_text(r, "--in"), *second = cli_text(r, "--and");
    saltus_branch_options *o = &run->options;
    *o = r->branch;
    o->values = run->values;
    if (!r->output || !range)
        return cli_refuse(false, "continue: needs --in key=low:high and -o branch.h5");
    if (!o->locus != !second)
        return cli_refuse(false, "continue: --locus and --and belong together");
    o->orbit.tolerance = fmax(o->orbit.tolerance, 100 * o->orbit.flow.rtol);
    /* If only the largest step is given, it also bounds the first step. */
    if (!cli_given(r, "--step"))
        o->step = fmin(o->step, o->step_max);
    if (!cli_parse_range("--in", range, o->key[0], &o->low[0], &o->high[0]) ||
        (second && !cli_parse_range("--and", second, o->key[1], &o->low[1], &o->high[1])))
        return false;
    for (const char *text = cli_text(r, "--at"); text;) {
        double value;
        const char *end = saltus_read_number_until(text, ",", &value);
        if (o->value_count == values_max)
            return cli_refuse(false, "--at %s: only %d values can be given", text, values_max);
        if (!end)
            return cli_refuse(false, "--at %s: must be numbers with commas between them", text);
        if (value < o->low[0] || value > o->high[0])
            return cli_refuse(false, "--at %g: is outside the range of --in, %g to %g", value, o->low[0],
                              o->high[0]);
        run->values[o->value_count++] = value;
        text = *end ? end + 1 : NULL;
    }
    return true;
}

/* Without --from: start from the orbit that the scene settles on, or without forcing from the equilibrium, at
 * the end of the range where the branch begins unless --set gives the parameter. */
static saltus_status classify_start(run_state *run, saltus_message *message) {
    saltus_classify_options how = cli_classify_options(run->request);
    how.measure = 0; /* without a period there is no orbit to start from, so the exponent is not needed */
    const saltus_branch_options *o = &run->options;
    const cli_list *settings = cli_values(run->request, "--set");
    cli_setup *setup = &run->setup;
    saltus_start *start = &setup->start;
    saltus_motion motion = {0};
    saltus_status status = SALTUS_OK;
    bool anywhere = !saltus_system_forced(setup->system);
    for (int k = 0; k < settings->count; k++)
        anywhere = anywhere && !saltus_scene_overrides(&setup->scene, o->key[0], settings->items[k]);
    if (anywhere) {
        char setting[SALTUS_KEY_MAX + 32];
        snprintf(setting, sizeof setting, "%s=%.17g", o->key[0], o->direction < 0 ? o->high[0] : o->low[0]);
        status = saltus_scene_set(&setup->scene, setting, message);
        saltus_system_free(setup->system);
        setup->system = NULL;
        if (status == SALTUS_OK)
            status = saltus_system_new(&setup->scene.spec, &setup->system, message);
        if (status == SALTUS_OK)
            status = saltus_scene_state(&setup->scene, setup->system, start->state, message);
    }
    if (status == SALTUS_OK)
        status = saltus_classify(setup->system, start->state, &how, &motion, message);
    cli_progress_end(run->request);
    start->rests = status == SALTUS_OK && motion.eigenvalues;
    if (status == SALTUS_OK && motion.periods < 1 && !start->rests)
        status =
            interrupt_asked()
                ? SALTUS_INTERRUPTED
                : saltus_fail(
                      message, SALTUS_BAD_INPUT,
                      "%s: its motion is no periodic orbit to start from, but %s%s%s; name one by --from",
                      run->setup.scene.name, motion.label, motion.reason[0] ? ": " : "", motion.reason);
    if (status == SALTUS_OK) {
        start->periods = motion.periods;
        start->own_period = motion.trivial_multiplier != 0;
        if (start->own_period)
            saltus_spec_set_omega(&run->setup.scene.spec, 2 * M_PI / motion.period);
        memcpy(start->state, motion.state, (size_t)motion.dimension * sizeof *motion.state);
    }
    saltus_motion_clear(&motion);
    return status;
}

static int begin_anew(run_state *run, saltus_message *message) {
    const long periods = cli_whole(run->request, "--periods");
    saltus_start *start = &run->setup.start;
    int code = cli_build(run->request, &run->setup);
    if (code != CLI_DONE)
        return code;
    const bool given = cli_on_orbit(&run->setup);
    saltus_status status = given ? SALTUS_OK : classify_start(run, message);
    if (periods && status == SALTUS_OK && start->rests)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "--periods %ld: the start is an equilibrium, which has no period", periods);
    if (periods)
        start->periods = (int)periods;
    return cli_report(status, message);
}

/* Restore the start, the options and the points of an interrupted run. */
static int begin_again(run_state *run, saltus_message *message) {
    saltus_branch_file *file = &run->earlier;
    saltus_scene *scene = &run->setup.scene;
    const saltus_branch_options *a = &run->options, *b = &file->options;
    saltus_status status = saltus_branch_file_read(run->request->output, file, message);
    if (status == SALTUS_OK)
        status = cli_read_scene(run->request->scene, scene, message);
    /* The command line must describe the run stored in the file. */
    saltus_scene changed = {.spec = file->spec};
    bool same = status == SALTUS_OK && strcmp(scene->name, file->scene) == 0 && a->locus == b->locus &&
                saltus_model_same(scene->spec.model, file->spec.model);
    for (int k = 0; k < 2; k++)
        same = same && strcmp(a->key[k], b->key[k]) == 0 &&
               (!a->key[k][0] || (a->low[k] == b->low[k] && a->high[k] == b->high[k]));
    same = same && cli_apply_settings(run->request, &changed, message) == SALTUS_OK &&
           saltus_spec_equal(&changed.spec, &file->spec);
    if (status == SALTUS_OK && !same)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "--resume: %.200s holds another run (of %.60s in %s from %g to %g); repeat its "
                             "command line",
                             run->request->output, file->scene, b->key[0], b->low[0], b->high[0]);
    if (status == SALTUS_OK && file->dimension > SALTUS_SCENE_STATE_MAX)
        status =
            saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: the state is too long", run->request->output);
    if (status == SALTUS_OK) {
        const saltus_model *own = scene->spec.model;
        scene->spec = file->spec;
        scene->spec.model = own;
        snprintf(scene->name, sizeof scene->name, "%s", file->scene);
        snprintf(scene->title, sizeof scene->title, "%s", file->title);
        run->setup.start.periods = file->periods;
        run->setup.start.rests = file->periods == 0;
        memcpy(run->setup.start.state, file->state, (size_t)file->dimension * sizeof *file->state);
        run->options = file->options;
        run->options.orbit.flow.stop = interrupt_flag();
        status = saltus_system_new(&file->spec, &run->setup.system, message);
    }
    return cli_report(status == SALTUS_IO ? SALTUS_BAD_INPUT : status, message);
}

/* Count a point and, with --json, print it. */
static void tell(run_state *run, const saltus_branch_point *point) {
    run->rows++;
    if (point->branch >= run->branches)
        run->branches = point->branch + 1;
    if (cli_given(run->request, "--json"))
        saltus_write_point_json(stdout, &run->setup.scene, run->setup.system, point);
}

/* Compute the points; print each one and write it to the file, with the saved state after it. */
static saltus_status follow(run_state *run, saltus_message *message) {
    const bool shown = cli_shows_progress(run->request);
    const saltus_branch_point *point = NULL;
    saltus_status status;
    double *numbers;
    int count;
    while ((status = saltus_branch_step(run->branch, &point, message)) == SALTUS_OK && point) {
        if (!run->rows && !run->options.locus)
            status = cli_same_orbit(run->request, &run->setup, point->state, message);
        if (status == SALTUS_OK) {
            tell(run, point);
            status = saltus_branch_output_add(run->output, point, message);
        }
        if (status == SALTUS_OK)
            status = saltus_branch_save(run->branch, &numbers, &count, message);
        if (status == SALTUS_OK)
            saltus_branch_output_resume(run->output, numbers, count);
        const double leading = point->multiplier_count ? point->multipliers[0].log_modulus : -INFINITY;
        if (shown && progress_columns() < narrow)
            progress_line("%s=%.6g step %d %s %s", run->options.key[0], point->value[0], point->step,
                          point->label, saltus_point_word(point->kind));
        else if (shown)
            progress_line("%s = %.9g  branch %d  step %d  %s  largest %s %.4g%s%s", run->options.key[0],
                          point->value[0], point->branch, point->step, point->label,
                          point->periods ? "multiplier" : "real part",
                          point->periods ? exp(leading) : leading,
                          point->kind == SALTUS_POINT_REGULAR ? "" : "  ", saltus_point_word(point->kind));
        if (status != SALTUS_OK || ferror(stdout))
            break;
    }
    run->interrupted = status == SALTUS_INTERRUPTED;
    cli_progress_end(run->request);
    return run->interrupted ? SALTUS_OK : status;
}

/* If Newton's method fails at the start, the start is no orbit: SALTUS_BAD_INPUT. */
static int open_branch(run_state *run, saltus_message *message) {
    const saltus_start *start = &run->setup.start;
    run->options.orbit.free_period = start->own_period || run->options.orbit.free_period;
    saltus_status status = saltus_branch_new(&run->setup.scene.spec, start->periods, start->state,
                                             &run->options, &run->branch, message);
    if (status != SALTUS_OK && status != SALTUS_NO_MEMORY && status != SALTUS_BAD_INPUT &&
        !interrupt_asked()) {
        saltus_message reason = *message;
        status =
            start->rests
                ? saltus_fail(message, SALTUS_BAD_INPUT, "the start is no equilibrium: %.400s", reason.text)
                : saltus_fail(message, SALTUS_BAD_INPUT, "the start is no orbit of period %d T: %.400s",
                              start->periods, reason.text);
    }
    cli_origin origin = {.command = NULL};
    if (status == SALTUS_OK)
        status = cli_origin_new(run->request, &origin, message);
    if (status == SALTUS_OK)
        status = saltus_branch_output_open(run->request->output, &run->setup.scene, start->periods,
                                           start->state, &run->options, &origin.told, &run->output, message);
    cli_origin_clear(&origin);
    return cli_report(status, message);
}

static int compute(run_state *run) {
    saltus_message message = {.text = ""}, closing = {.text = ""};
    int code = (cli_given(run->request, "--resume") ? begin_again : begin_anew)(run, &message);
    if (code == CLI_DONE)
        code = open_branch(run, &message);
    if (code != CLI_DONE)
        return code;
    /* The points of the interrupted run that remain valid go into the new file. */
    const saltus_branch_file *file = &run->earlier;
    saltus_message why = {.text = ""};
    int kept = file->complete ? file->point_count : 0;
    saltus_status status = SALTUS_OK;
    if (!file->complete && file->resume_count)
        status = saltus_branch_resume(run->branch, file->resume, file->resume_count, &kept, &why);
    if (status == SALTUS_OK && kept > file->point_count)
        status = saltus_fail(&why, SALTUS_BAD_INPUT, "it has %d points and goes on after the %dth",
                             file->point_count, kept);
    if (status != SALTUS_OK)
        saltus_fail(&message, status, "--resume: %.200s: %.300s", run->request->output, why.text);
    else if (cli_given(run->request, "--resume"))
        status = saltus_branch_output_take_over(run->output, file, kept, &message);
    for (int k = 0; k < kept && status == SALTUS_OK; k++)
        tell(run, &file->points[k]);
    if (status == SALTUS_OK && !run->earlier.complete)
        status = follow(run, &message);
    bool complete = status == SALTUS_OK && !run->interrupted && !ferror(stdout);
    saltus_status written = saltus_branch_output_close(run->output, complete, &closing);
    run->output = NULL;
    /* The special points in the file as a table. */
    if (!cli_given(run->request, "--json") && status == SALTUS_OK && written == SALTUS_OK && run->rows) {
        saltus_branch_file made = {.point_count = 0};
        status = saltus_branch_file_read(run->request->output, &made, &message);
        if (status == SALTUS_OK) {
            const bool quiet = cli_given(run->request, "--quiet");
            printf("%s: %d point%s on %d branch%s%s%s\n", run->setup.scene.name, run->rows,
                   run->rows == 1 ? "" : "s", run->branches, run->branches == 1 ? "" : "es",
                   quiet ? "" : " in ", quiet ? "" : run->request->output);
            saltus_write_branch_text(stdout, &made);
        }
        saltus_branch_file_clear(&made);
    }
    if (status != SALTUS_OK || written != SALTUS_OK)
        return cli_report(status != SALTUS_OK ? status : written, status != SALTUS_OK ? &message : &closing);
    if (run->interrupted && !run->rows)
        return interrupt_report("no point was found yet");
    if (run->interrupted)
        return cli_refuse(CLI_FAILED, "interrupted; %s holds the %d point%s so far, --resume goes on",
                          run->request->output, run->rows, run->rows == 1 ? "" : "s");
    return CLI_DONE;
}

static int run(const cli_request *request) {
    run_state *state = calloc(1, sizeof *state);
    if (!state)
        return cli_refuse(CLI_FAILED, "no memory");
    state->request = request;
    int code = read_options(state) ? compute(state) : CLI_BAD_INPUT;
    saltus_branch_output_close(state->output, false, NULL);
    saltus_branch_free(state->branch);
    saltus_branch_file_clear(&state->earlier);
    cli_clear(&state->setup);
    free(state);
    return code;
}

const cli_command cmd_continue = {
    .name = "continue",
    .summary = "branches of orbits and curves of bifurcations",
    .usage = "SCENE [--set key=value ...] [--from orbit] --in omega=lo:hi [--locus PD --and d=lo:hi] -o "
             "branch.h5 [--json]",
    .help =
        "Follow a periodic orbit as a parameter changes, stable or not, and find where it folds (LP), flips "
        "(PD), bifurcates to a torus (NS), meets another branch (BP) or grazes a stop (GR), and where "
        "chatter completes (CH) or sticking changes (ST). Without --from the start is the orbit that the "
        "scene settles on; with it, the file's parameters hold where --set does not say otherwise. A scene "
        "without forcing starts at the range's first value (with --direction down its last), if --set gives "
        "no other, and may rest there: then equilibria are followed, to folds (LP), branch points (BP), Hopf "
        "points (HB) and stops (BE). With --locus such points are followed in two parameters, through points "
        "of codimension two; there --switch also follows the other curves that meet: that of grazing, those "
        "of folds, flips, tori and branch points at grazing, the grazing of orbits that branch off where a "
        "flip or branch point grazes, tori and folds or flips at a double multiplier 1 (R1) or -1 (R2), the "
        "other impact's where two graze, and of equilibria Hopf points or folds at BT and Hopf points or "
        "folds of cycles at GH. At R3 and R4 only orbits of period 3 and 4 begin, which are "
        "branches, no such curves. The file can be plotted, and read, while it grows; with --resume the "
        "options are those of the interrupted run, and the file becomes the one that it would have left.",
    .needs_scene = true,
    .endings = (const char *const[]){".h5", NULL},
    .kind = "branch",
    .resumes = true,
    .tables = CLI_TABLES(CLI_TABLE(saltus_branch_table, branch, "--segments"),
                         CLI_TABLE(saltus_classify_table, classify, "--measure --lifetime")),
    .options = CLI_OPTIONS(&cli_set, &cli_section, &cli_from, &range, &second_range, &periods, &values,
                           &cli_resume, &json, &cli_output),
    .notes =
        "Labels: LP fold, PD flip, NS torus (Neimark-Sacker), BP branch point, GR grazing, CH complete "
        "chatter begins or ends, ST sticking begins, splits or ends, UZ a value asked for by --at, EP end of "
        "a branch, with its reason. Without forcing: HB Hopf, an orbit shrinks to an equilibrium, or cycles "
        "are born at one, stable ones where the first Lyapunov coefficient is negative (supercritical); BE "
        "an equilibrium meets a stop, on which it rests from there on, or leaves it, and cycles with "
        "impacts may begin, whose size is in proportion to the distance. A branch of cycles whose period "
        "grows without bound ends at a homoclinic orbit, whose saddle and place are told. Where the "
        "contact is permanent (held) a point tells its smallest force over the orbit: where that is zero the "
        "contact lets go. On a curve of grazing multipliers are those without the impact. Points of "
        "codimension two on a curve: CP cusp, R1 to R4 resonances (double "
        "multipliers 1 and -1, pairs at a third and a quarter of the circle), GR-LP, GR-PD, GR-NS, GR-BP "
        "where the curve meets grazing, GR-GR two grazings, CH-GR grazing meets the end of chatter, GPD a "
        "flip neither super- nor subcritical, LP-PD multipliers 1 and -1, PD-NS -1 and a pair on the unit "
        "circle, where curves of orbits of twice the period end; of equilibria, whose curves are LP, HB and "
        "BE, CP, BT two eigenvalues zero (Bogdanov-Takens) and GH a "
        "first Lyapunov coefficient zero (generalised Hopf); on BE also HB and LP, where curves of these "
        "meet the stop.\n"
        "An orbit is followed with its sequence of events as given, so a branch does not lose its way where "
        "a multiplier grows without bound at grazing. The event-driven flow then checks every point: it is "
        "admissible if the flow has the same events and closes. Where that ends, the place is located (GR, "
        "CH, ST) and the branch goes on with the new sequence, or says why not. At grazing an impact is born "
        "or dies; the branch goes through, or turns back there like a fold but with a corner. --switch k "
        "also follows what branches off at PD and BP, orbits of twice the period at GR, what a branch joins "
        "there, and cycles from the HB of equilibria, to depth k.\n"
        "Nothing is followed twice: a branch that comes back to a special point, or reaches another "
        "branch's, ends there and says so. Every few seconds, and when interrupted, all points go to the "
        "file; its layout stands in saltus/record.h. FILE.h5:12 (row) and FILE.h5:PD1 (first flip) are "
        "orbits for --from.\n"
        "--json gives one object for each point: label, values (of the continued parameters), motion (n/p, "
        "equilibrium or held), motion_after (GR, CH, ST, BE), impacts, periods, sticking_intervals, stable, "
        "unstable (multipliers outside the unit circle; at LP, PD, NS, BP, HB without the critical ones), "
        "admissible, state, events, grazing (GR, BE: side, "
        "stop and time_over_T of the touch), multipliers, log_moduli (of equilibria, whose periods is 0, "
        "eigenvalues in their place, and lyapunov_coefficient at HB), arclength, heading, branch, parent, "
        "step, residual, iterations, log_volume, sum_rule, accuracy, reason, parameters, scene, version. A "
        "branch file has the same in columns, the touch as grazing_time, grazing_stop, grazing_side.",
    .examples =
        CLI_EXAMPLES({"continue impact-oscillator --in omega=0.9:1.1 -o branch.h5",
                      "follow the orbit over frequencies; it flips at 0.96"},
                     {"plot branch.h5 -o branch.png", "draw the branch"},
                     {"continue impact-oscillator --in omega=0.9:1.1 --direction down --locus PD --and "
                      "d=0.9:1.1 -o flip.h5",
                      "the curve of flips in two parameters"},
                     {"continue relief-valve --set q=9 --in q=7:9.5 --switch 1 -o valve.h5",
                      "an equilibrium over the flow rate, and the cycles born at its Hopf point"},
                     {"continue impact-oscillator --from branch.h5:PD1 --in omega=0.9:1.1 -o again.h5",
                      "from the first flip of the file"}),
    .see = "orbit plot",
    .run = run,
};
