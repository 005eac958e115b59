/* Results as text, JSON, CSV and HDF5. Arguments of all writers, here and in figure.h, come in this order:
 * destination, scene, system, options, results, then look or origin.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_H
#define SALTUS_RECORD_H

#include "saltus/branch.h"
#include "saltus/equilibrium.h"
#include "saltus/harvest.h"
#include "saltus/lyapunov.h"
#include "saltus/motion.h"
#include "saltus/scene.h"
#include "saltus/spectrum.h"
#include "saltus/sweep.h"
#include "saltus/trajectory.h"

#include <stdio.h>

SALTUS_API_BEGIN

/* A motion as one JSON object and a newline; keys as in the manual of saltus classify. Numbers round-trip. */
void saltus_write_motion_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion);
/* The same for people: a few lines. */
void saltus_write_motion_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                              const saltus_motion *motion);

/* The attractors found from random initial states, with shares and verdicts: as text, or as one JSON object
 * with the keys `seeds` and `attractors` (a list of objects with `share` and `motion`). */
void saltus_write_attractors(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_attractors *attractors, bool json);

/* An equilibrium, in the same forms, with eigenvalues instead of multipliers. */
void saltus_write_equilibrium_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                   const saltus_equilibrium *equilibrium);
void saltus_write_equilibrium_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                   const saltus_equilibrium *equilibrium);

/* The periodic orbits harvested from a trajectory, as a table for people. */
void saltus_write_harvest_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_harvest *harvest);

/* Lyapunov exponents as one JSON object and a newline; null stands for -infinity. */
void saltus_write_lyapunov_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                const saltus_lyapunov_options *options, const saltus_lyapunov *lyapunov);
/* The same for people, with an interpretation of the numbers. */
void saltus_write_lyapunov_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                                const saltus_lyapunov_options *options, const saltus_lyapunov *lyapunov);
/* Spectra for people: what was analysed and how, total power, broadband fraction, trustworthy range, the ten
 * strongest lines. */
void saltus_write_spectra_text(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_motion *motion, const saltus_spectra *spectra);
/* The same as one JSON object and a newline, with all lines up to the highest trustworthy frequency. */
void saltus_write_spectra_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                               const saltus_motion *motion, const saltus_spectra *spectra);
/* How results were obtained, stored in HDF5 files as the texts `command`, `date` and `scene_text`. NULL
 * members are omitted. */
typedef struct saltus_origin {
    const char *command; /* the command line without arguments that do not affect the results */
    const char *date;    /* start of the run, such as 2026-01-31T12:00:00Z */
    const char *scene;   /* the scene's text, before changes by the command line */
} saltus_origin;

/* Write a record to a .csv or .h5 file (chosen by the ending), completely or not at all. The HDF5 file has
 * the same head as a branch file, the flow's options as attributes, and the groups /trajectory (samples),
 * /events and /strobe (stroboscopic points); of an interrupted record both say `complete` 0.
 * /trajectory/observed has what the scene observes. `origin` may be NULL. Errors: SALTUS_BAD_INPUT for
 * another ending, SALTUS_IO. */
saltus_status saltus_write_trajectory(const char *path, const saltus_scene *scene,
                                      const saltus_system *system, const saltus_flow_options *options,
                                      const saltus_trajectory *record, const saltus_origin *origin,
                                      saltus_message *message);

/* The kind of a file, judged by its beginning. */
typedef struct saltus_file_facts {
    /* "branch", "sweep", "basins" or "trajectory" (HDF5 files of Saltus); "sweep table", "sweep impacts
     * table", "branch points table" and the like (CSV of Saltus, by the words of their first line), "script"
     * (of Saltus, for gnuplot), "picture" (PNG, PDF, SVG), "empty", "hdf5" (damaged or cut off); "" for any
     * other or unreadable file. */
    char kind[32];
    bool hdf5;
    bool locus;    /* the branch is a curve of special points in two parameters */
    bool complete; /* false: written by an interrupted run */
} saltus_file_facts;
/* Reads only the head; the rest of the file may still be damaged. */
saltus_file_facts saltus_file_identify(const char *path);

/* A motion read from a file as a start. */
typedef struct saltus_start {
    saltus_spec spec; /* parameters and stops */
    int periods;      /* p of a periodic orbit; 0: not periodic */
    bool rests;       /* it is an equilibrium of a scene without forcing (recognised by its eigenvalues) */
    bool own_period;  /* no forcing: `spec` counts time in the orbit's own period */
    int dimension;    /* of the state */
    double state[SALTUS_SCENE_STATE_MAX]; /* at section phase 0 */
    char label[SALTUS_LABEL_MAX];         /* the motion's label in the file, such as "4/4" */
} saltus_start;

/* Read an orbit or an equilibrium: a JSON object of classify, orbit or continue (`orbit.json`;
 * `lines.json:12` takes line 12), a point of a branch file (`branch.h5:12` takes row 12 counted from 1,
 * `branch.h5:PD1` the first flip), or a row of a sweep or basins file (`sweep.h5:12`, counted from 1 in the
 * order of saltus_write_sweep_csv). Where an orbit without forcing has shrunk to an equilibrium it is that. A
 * row without a state in its file is computed again (saltus_sweep_row_again) until *stop is set (NULL: never
 * stopped). Errors: SALTUS_BAD_INPUT with a sentence that names the file and the fault, SALTUS_INTERRUPTED,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_start_read(const char *source, const volatile sig_atomic_t *stop, saltus_start *start,
                                saltus_message *message);
/* Release the model of a start made of equations. A zeroed start is accepted. */
void saltus_start_release(saltus_start *start);
/* Copy parameters and stops of a start into a scene of the same model and number of stops. Errors:
 * SALTUS_BAD_INPUT; the scene is then unchanged. */
saltus_status saltus_start_apply(const saltus_start *start, const char *source, saltus_scene *scene,
                                 saltus_message *message);

/* A point of a branch as one JSON object and a newline; `system` is any system of the branch, needed for its
 * stops. */
void saltus_write_point_json(FILE *file, const saltus_scene *scene, const saltus_system *system,
                             const saltus_branch_point *point);
/* A branch, with all it takes to continue from any point. Layout of the file (.h5), with attributes
 * `units` and `description` on every dataset:
 *
 *     /               attributes kind = "branch", version, scene, title, model, complete (0: interrupted);
 *                     datasets command, date and scene_text (saltus_origin)
 *     /parameters     an attribute for each parameter of the start; /parameters/stop_1, ... for the stops
 *     /start          attribute periods; dataset state
 *     /continuation   the options as attributes: key1, low1, high1, key2, low2, high2, locus, step, ...;
 *                     the datasets `values` (where UZ points are wanted) and `resume` (saved state of an
 *                     interrupted run, saltus_branch_save; empty in a complete file)
 *     /points         one row per point, in the order of computation: kind (enumeration regular, LP, ...),
 *                     branch, parent, step, arclength, value[2], heading, parameters[names],
 *                     stops[stop][xi, weight1, weight2, d, r], periods (0: an equilibrium), period, impacts
 *                     (-1: complete chatter), sticking_intervals, motion, motion_after, reason, state,
 *                     multipliers[k][re, im] (of equilibria eigenvalues), log_moduli, trivial_multiplier,
 *                     lyapunov_coefficient, unstable, stable, admissible, residual, iterations, log_volume,
 *                     sum_rule, accuracy, event_first and event_count (its own rows of /events, from 0)
 *     /events         the orbits' events one after the other: kind, stop, side, time (in T, from phase
 *                     0), phase, velocity_before, velocity_after, displacement
 */
typedef struct saltus_branch_file {
    char version[16];
    char scene[128], title[160];
    saltus_spec spec; /* of the start */
    int periods, dimension;
    double *state;                 /* of the start */
    saltus_branch_options options; /* `orbit.history` and `orbit.context` are NULL */
    bool complete;
    saltus_branch_point *points;
    int point_count;
    double *resume; /* saved state of an interrupted run (saltus_branch_resume); NULL: it restarts from the
                       beginning */
    int resume_count;
    double *values, *states; /* storage behind options.values and the points' arrays */
    saltus_event *events;
    saltus_multiplier *multipliers;
} saltus_branch_file;

/* Read a branch file; on success free with saltus_branch_file_clear. Errors: SALTUS_BAD_INPUT (no file,
 * another kind of file, a damaged one), SALTUS_NO_MEMORY. */
saltus_status saltus_branch_file_read(const char *path, saltus_branch_file *file, saltus_message *message);
/* The special points of a branch file for people: a table for each branch; `row` is the point's row in the
 * file. */
void saltus_write_branch_text(FILE *out, const saltus_branch_file *file);
/* Free the arrays; a zeroed one is accepted. */
void saltus_branch_file_clear(saltus_branch_file *file);

/* A branch file being written. The file at `path` is replaced as a whole after the first point and then every
 * few seconds. However the run ends, `path` is always a complete, readable file: the old one, or one with the
 * points so far. */
typedef struct saltus_branch_output saltus_branch_output;

/* `state` is that of the start; `origin` may be NULL. Checks that the file can be written, but writes nothing
 * yet. Errors: SALTUS_BAD_INPUT (an ending other than .h5, not a plain file), SALTUS_IO, SALTUS_NO_MEMORY. */
saltus_status saltus_branch_output_open(const char *path, const saltus_scene *scene, int periods,
                                        const double *state, const saltus_branch_options *options,
                                        const saltus_origin *origin, saltus_branch_output **output,
                                        saltus_message *message);
/* Errors: SALTUS_NO_MEMORY, SALTUS_IO. */
saltus_status saltus_branch_output_add(saltus_branch_output *output, const saltus_branch_point *point,
                                       saltus_message *message);
/* Set the saved state after the points so far: `count` numbers from saltus_branch_save, which the output then
 * owns. With count = 0 the previous state stays. */
void saltus_branch_output_resume(saltus_branch_output *output, double *numbers, int count);
/* Take over the first `kept` points and the saved state of an interrupted run; call before adding points. The
 * file is replaced once all of them are in, and keeps the origin of the interrupted run. Errors:
 * SALTUS_NO_MEMORY, SALTUS_IO. */
saltus_status saltus_branch_output_take_over(saltus_branch_output *output, const saltus_branch_file *earlier,
                                             int kept, saltus_message *message);
/* Write what is left, if there is any point, and free the output (NULL is accepted). `complete` states that
 * the branch reached its end. Errors: SALTUS_IO. */
saltus_status saltus_branch_output_close(saltus_branch_output *output, bool complete,
                                         saltus_message *message);

/* A sweep written as an HDF5 file. While the sweep runs every result is appended to a journal beside the file
 * (`path` with ".journal" added), and every few seconds a new file made from the journal replaces the old
 * one. However the run ends, there is always a complete, readable file of the results so far. The finished
 * file depends on the results alone, not on their order or on how often the run was interrupted; the journal
 * is then removed. Layout of the file, with attributes `units` and `description` on every dataset:
 *
 *     /               attributes kind = "sweep" or "basins", version, scene, title, model, complete (0:
 *                     interrupted); datasets command, date and scene_text (saltus_origin)
 *     /parameters     an attribute for each parameter of the scene; /parameters/stop_1, ... for the stops
 *     /sweep          the options as attributes: keep, seeds, seed, adaptive, transient, record, measure,
 *                     longest, rtol, atol, order, integrator, dimension, passes ("reset,up,down"), axes,
 *                     key1, spacing1, key2, spacing2; dataset initial
 *     /axes           datasets axis1 and axis2 (where there are two): the values
 *     /rows           one dataset for each member of saltus_sweep_row, of shape [pass][axis2][axis1][seed]
 *                     (axis2 has length 1 where there is one axis): verdict (enumeration pending,
 *                     periodic, ...), impacts, periods, sticking, attractor, settled, ..., lyapunov; `label`,
 *                     the motion's label as text, n/p if periodic; and `attractors`, the number of distinct
 *                     ones, of shape [pass][axis2][axis1]
 *     /turning        where kept: first and count (of shape [pass][axis2][axis1][seed]) point into
 *                     displacement
 *     /impacts        first, count, phase, speed, face
 *     /stroboscopic   first, count, state
 *     /attractors     of basins: label, impacts, periods, stable, largest_multiplier, first and count
 *                     into state, the orbits' points at phase 0
 */
typedef struct saltus_sweep_output saltus_sweep_output;

/* With `resume` the journal of an interrupted run is continued. Without a journal a finished file of the same
 * sweep counts as all done; an unfinished one, or a file of another sweep, is refused with a sentence that
 * names the difference. With `basins` attractors are numbered over the whole plane. `origin` may be NULL;
 * with `resume` the file keeps the origin of the interrupted run. Errors: SALTUS_BAD_INPUT, SALTUS_IO,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_output_open(const char *path, const saltus_sweep *sweep, bool basins, bool resume,
                                       const saltus_origin *origin, saltus_sweep_output **output,
                                       saltus_message *message);
/* Whether the result of a place is already stored. */
bool saltus_sweep_output_has(const saltus_sweep_output *output, long long place);
/* Store a result; a place already stored is left as it is. Errors: SALTUS_IO (earlier results remain),
 * SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_output_take(saltus_sweep_output *output, const saltus_sweep_result *result,
                                       saltus_message *message);
/* Update the file and free the output (NULL is accepted). When all places are stored the file is complete and
 * the journal is removed. Errors: SALTUS_IO. */
saltus_status saltus_sweep_output_close(saltus_sweep_output *output, saltus_message *message);

/* A sweep file read back. */
typedef struct saltus_sweep_file {
    char version[16];
    char scene[128], title[160];
    bool basins, complete;
    saltus_spec spec;                       /* of the scene, before the axes' keys are varied */
    double initial[SALTUS_SCENE_STATE_MAX]; /* the scene's initial state, initial_count entries; 0: the
                                               default */
    int initial_count;
    int axis_count;
    saltus_axis axes[SALTUS_AXES_MAX]; /* `list` holds all values for any spacing */
    saltus_sweep_options options;
    int pass_count;
    saltus_pass passes[SALTUS_PASSES];
    long long points, row_count;
    saltus_sweep_row *rows;
    int dimension;
    /* Clouds if kept, otherwise NULL. Entries of a row: first[row] ... first[row] + count[row] - 1. */
    long long *turning_first, *turning_count, *impact_first, *impact_count, *strobe_first, *strobe_count;
    double *turning, *strobes;
    saltus_sweep_impact *impacts;
    /* Basins: label, modulus of the largest multiplier, and points at phase 0 of each attractor. */
    int attractor_count;
    char (*attractor_label)[32];
    double *attractor_multiplier;
    long long *attractor_first, *attractor_points;
    double *attractor_states;
} saltus_sweep_file;

/* On success free with saltus_sweep_file_clear. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_sweep_file_read(const char *path, saltus_sweep_file *file, saltus_message *message);
void saltus_sweep_file_clear(saltus_sweep_file *file);

/* The kind of the table that the file has under this name (NULL: its first), in the words of
 * saltus_file_identify; "" if it has no such table. */
void saltus_table_kind(const saltus_file_facts *file, const char *name, char kind[32]);

/* Which table of a sweep file is exported to CSV. */
typedef enum saltus_table {
    SALTUS_TABLE_ROWS,
    SALTUS_TABLE_TURNING,
    SALTUS_TABLE_IMPACTS,
    SALTUS_TABLE_STROBES
} saltus_table;
/* One line per row or cloud entry, beginning with the axes' values, pass and seed; written completely or not
 * at all. Errors: SALTUS_BAD_INPUT if the file does not hold the table, SALTUS_IO. */
saltus_status saltus_write_sweep_csv(const char *path, const saltus_sweep_file *file, saltus_table table,
                                     saltus_message *message);

/* A table of a branch file ("points", "events") or a trajectory file ("samples", "events", "strobe") as CSV,
 * written completely or not at all; `name` NULL: the first table. Columns have the names of parameters,
 * stops and states, and a legend. Errors: SALTUS_BAD_INPUT, SALTUS_IO, SALTUS_NO_MEMORY. */
saltus_status saltus_write_csv(const char *to, const char *path, const char *name, saltus_message *message);

SALTUS_API_END
#endif
