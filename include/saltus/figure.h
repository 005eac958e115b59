/* Figures, drawn by gnuplot.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_H
#define SALTUS_FIGURE_H

#include "saltus/record.h"

SALTUS_API_BEGIN

/* How a figure is laid out and what it says of itself. Zeros are the defaults. Texts and lists are the
 * caller's. */
typedef struct saltus_figure_options {
    double width, height; /* on paper, in mm, with type of 8 points; height 0: chosen by the figure; width 0:
                             a page for screens, 1600 x 1200 dots, in a PDF file 297 x 223 mm; default 0, 0 */
    bool no_heading;   /* neither the heading nor the lines of parameters and method above the panels; default
                          false */
    const char *title; /* in place of the heading's own words; "": none; NULL: its own; default NULL */
    bool swap;         /* exchange the axes across and up the page (of what is drawn by saltus_plot, where
                          it has two parameters or shows branches); default false */
    const char *const *logarithmic; /* keys of the axes that are logarithmic, parameters or "measure"; of what
                                       is drawn by saltus_plot */
    int logarithmic_count;          /* default 0 */
    const char *script; /* keep gnuplot's script there, data included, as a file that ends in .gp and draws
                           the figure again; NULL: not kept; default NULL */
} saltus_figure_options;

/* As told beside the options. */
saltus_figure_options saltus_figure_defaults(void);
/* Whether a figure can be drawn so at a path, before a long computation: its ending is .png, .pdf or .svg,
 * its size from 30 to 2000 mm, its script's ending .gp. Nothing is written. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_figure_check(const char *path, const saltus_figure_options *look,
                                  saltus_message *message);

/* How the estimate of the largest exponent converged: a figure (.png, .pdf, .svg) or its rows (.csv),
 * complete or not at all. `look` may be NULL, here and below: the defaults. Errors: SALTUS_BAD_INPUT for
 * another ending or an unsound size, SALTUS_IO. */
saltus_status saltus_write_convergence(const char *path, const saltus_scene *scene,
                                       const saltus_system *system, const saltus_lyapunov_options *options,
                                       const saltus_lyapunov *lyapunov, const saltus_figure_options *look,
                                       saltus_message *message);
/* Whether the ending of a path is one of these and the file can be written, before a long computation.
 * Nothing is left behind. Errors: SALTUS_BAD_INPUT, SALTUS_IO. */
saltus_status saltus_convergence_check(const char *path, saltus_message *message);

/* As a table (.csv: all lines of whole orbits, all bins of a density) or a figure (.png, .pdf, .svg),
 * complete or not at all. Errors: SALTUS_BAD_INPUT for another ending, SALTUS_IO (file not writable; gnuplot
 * absent or failed). */
saltus_status saltus_write_spectra(const char *path, const saltus_scene *scene, const saltus_system *system,
                                   const saltus_flow_options *flow, const saltus_motion *motion,
                                   const saltus_spectra *spectra, const saltus_figure_options *look,
                                   saltus_message *message);

/* What the page of a motion is made of; all the caller's. */
typedef struct saltus_diagnosis {
    const saltus_motion *motion;
    const saltus_trajectory *record;  /* one orbit of periodic motion, a stretch of any other */
    const saltus_trajectory *section; /* of motion without a period: a long record, for its section points and
                                     impacts; NULL: those of `record` */
    const saltus_spectra *spectra;    /* the first one is shown; NULL: none */
} saltus_diagnosis;

/* The one-page diagnosis of a motion: phase portrait, time history, impact map, shapes, spectrum,
 * multipliers; without a period the stroboscopic section and the convergence of the largest exponent;
 * caption. `path` ends in .png, .pdf or .svg. With `data` (a .h5 path, may be NULL) the record goes there
 * and, unless `look` names another place, gnuplot's script beside it, with the ending .gp. Errors:
 * SALTUS_BAD_INPUT, SALTUS_IO (gnuplot absent or failed, file not writable). */
saltus_status saltus_write_sheet(const char *path, const saltus_scene *scene, const saltus_system *system,
                                 const saltus_flow_options *options, const saltus_diagnosis *diagnosis,
                                 const saltus_figure_options *look, const char *data,
                                 saltus_message *message);

/* What a bifurcation diagram shows of an orbit, up the page. */
typedef enum saltus_show {
    SALTUS_SHOW_AUTOMATIC, /* impact speeds where there are impacts, otherwise displacements; without forcing
                              amplitudes */
    SALTUS_SHOW_SPEED,     /* of its fastest impact */
    SALTUS_SHOW_IMPACTS,   /* of all of them */
    SALTUS_SHOW_DISPLACEMENT, /* observed displacement at phase 0 */
    SALTUS_SHOW_VELOCITY,     /* its rate */
    SALTUS_SHOW_PERIOD,
    SALTUS_SHOW_AMPLITUDE /* largest and smallest observed displacement of an orbit, that of an equilibrium */
} saltus_show;

/* A part of an axis. */
typedef struct saltus_plot_part {
    char key[SALTUS_KEY_MAX];
    double low, high;
} saltus_plot_part;

/* A name written at a place in the plane of two parameters, such as n/p into its region. */
typedef struct saltus_plot_label {
    char key[2][SALTUS_KEY_MAX];
    double value[2];
    const char *text; /* the caller's */
} saltus_plot_label;

typedef struct saltus_plot_options {
    saltus_show show;
    const saltus_plot_part *parts; /* shown of the parameters' ranges, one for each at most; the caller's */
    int part_count;
    const saltus_plot_label *labels; /* the caller's */
    int label_count;
    saltus_figure_options look;
} saltus_plot_options;

/* Automatic measure, whole ranges, no labels. */
saltus_plot_options saltus_plot_defaults(void);

/* Draw branch files over each other, with the parameter across the page; or curves of special points over
 * their two parameters, which need not come in the same order in all files. `figure` ends in .png, .pdf or
 * .svg. A sweep file alone is drawn in its automatic view (saltus_plot_sweep). Errors: SALTUS_BAD_INPUT
 * (files that cannot be read, do not fit together or have no point in the range), SALTUS_IO (gnuplot absent
 * or failed, figure not writable), SALTUS_NO_MEMORY. */
saltus_status saltus_plot(const char *figure, const char *const *paths, int count,
                          const saltus_plot_options *options, saltus_message *message);

/* What a figure of a sweep shows. */
typedef enum saltus_view {
    SALTUS_VIEW_AUTOMATIC, /* clouds over one axis, classes over two, attractors of basins */
    SALTUS_VIEW_TURNING,   /* displacement diagram */
    SALTUS_VIEW_IMPACTS,   /* velocity diagram */
    SALTUS_VIEW_STROBOSCOPIC,
    SALTUS_VIEW_CLASS,      /* n/p */
    SALTUS_VIEW_ATTRACTORS, /* how many, or which one of basins */
    SALTUS_VIEW_LARGEST,    /* displacement */
    SALTUS_VIEW_RMS,        /* its root mean square */
    SALTUS_VIEW_SPEED,      /* largest impact speed */
    SALTUS_VIEW_RATE,       /* impacts per period */
    SALTUS_VIEW_CONTACT,    /* part of the time in contact */
    SALTUS_VIEW_LYAPUNOV,
    SALTUS_VIEW_SETTLED /* periods until the verdict */
} saltus_view;

typedef struct saltus_sweep_view {
    saltus_view view;
    const saltus_plot_part *parts; /* shown of the axes' ranges; the caller's */
    int part_count;
    const char *const *branches; /* files drawn over it: of periodic orbits over a diagram, of curves of
                                    special points over a map; the caller's */
    int branch_count;
    saltus_figure_options look;
} saltus_sweep_view;

/* Draw a sweep file. Errors as saltus_plot. */
saltus_status saltus_plot_sweep(const char *figure, const char *path, const saltus_sweep_view *view,
                                saltus_message *message);
/* Draw a recorded trajectory: phase portrait and time history, with points where a forcing period begins.
 * `look` may be NULL; its axes are neither swapped nor logarithmic. Errors as saltus_plot. */
saltus_status saltus_plot_trajectory(const char *figure, const char *path, const saltus_figure_options *look,
                                     saltus_message *message);

SALTUS_API_END
#endif
