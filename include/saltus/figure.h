/* Figures, drawn by gnuplot.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_H
#define SALTUS_FIGURE_H

#include "saltus/record.h"

SALTUS_API_BEGIN

/* Layout and texts of a figure. Zeros are the defaults. Texts and lists are owned by the caller. */
typedef struct saltus_figure_options {
    double width, height; /* on paper, in mm, with type of 8 points. height 0: chosen by the figure; width 0:
                             a page for screens, 1600 x 1200 pixels, in a PDF file 297 x 223 mm; default 0,
                             0 */
    bool no_heading;   /* omit the heading and the lines with parameters and method above the panels; default
                          false */
    const char *title; /* replaces the default heading; "": no heading; default NULL: the default heading */
    bool swap; /* exchange the axes: a single parameter is vertical; only for figures of saltus_plot; default
                  false */
    const char *const *logarithmic; /* keys of the logarithmic axes: parameters, or "measure"; only for
                                       figures of saltus_plot */
    int logarithmic_count;          /* default 0 */
    const char *script; /* where to keep gnuplot's script, which ends in .gp, includes the data and draws the
                           figure again; default NULL: not kept */
} saltus_figure_options;

/* The defaults stated beside the options. */
saltus_figure_options saltus_figure_defaults(void);
/* Check, before a long computation, that a figure with these options can go to `path`: ending .png, .pdf or
 * .svg, size from 30 to 2000 mm, script ending .gp. Nothing is written. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_figure_check(const char *path, const saltus_figure_options *look,
                                  saltus_message *message);

/* Convergence of the largest exponent's estimate: a figure (.png, .pdf, .svg) or a table (.csv), written
 * completely or not at all. Here and below a NULL `look` means the defaults. Errors: SALTUS_BAD_INPUT for
 * another ending or a bad size, SALTUS_IO. */
saltus_status saltus_write_convergence(const char *path, const saltus_scene *scene,
                                       const saltus_system *system, const saltus_lyapunov_options *options,
                                       const saltus_lyapunov *lyapunov, const saltus_figure_options *look,
                                       saltus_message *message);
/* Check, before a long computation, that the path has one of these endings and can be written. Leaves nothing
 * behind. Errors: SALTUS_BAD_INPUT, SALTUS_IO. */
saltus_status saltus_convergence_check(const char *path, saltus_message *message);

/* Spectra as a table (.csv: all lines of whole orbits, or all bins of a density) or a figure (.png, .pdf,
 * .svg), written completely or not at all. Errors: SALTUS_BAD_INPUT for another ending, SALTUS_IO (file not
 * writable; gnuplot absent or failed). */
saltus_status saltus_write_spectra(const char *path, const saltus_scene *scene, const saltus_system *system,
                                   const saltus_flow_options *flow, const saltus_motion *motion,
                                   const saltus_spectra *spectra, const saltus_figure_options *look,
                                   saltus_message *message);

/* The data of a one-page diagnosis; all owned by the caller. */
typedef struct saltus_diagnosis {
    const saltus_motion *motion;
    const saltus_trajectory *record;  /* one orbit of a periodic motion, a stretch of any other */
    const saltus_trajectory *section; /* of a motion without a period: a long record, for section points and
                                         impacts; NULL: those of `record` */
    const saltus_spectra *spectra;    /* only the first one is shown; NULL: none */
} saltus_diagnosis;

/* The one-page diagnosis of a motion: phase portrait, time history, impact map, shapes, spectrum, multipliers
 * (without a period instead the stroboscopic section and the convergence of the largest exponent), caption.
 * `path` ends in .png, .pdf or .svg. If `data` (a .h5 path) is not NULL the record is written there, and
 * gnuplot's script beside it with the ending .gp, unless `look` names another place. Errors:
 * SALTUS_BAD_INPUT, SALTUS_IO (gnuplot absent or failed, file not writable). */
saltus_status saltus_write_sheet(const char *path, const saltus_scene *scene, const saltus_system *system,
                                 const saltus_flow_options *options, const saltus_diagnosis *diagnosis,
                                 const saltus_figure_options *look, const char *data,
                                 saltus_message *message);

/* The vertical axis of a bifurcation diagram. */
typedef enum saltus_show {
    SALTUS_SHOW_AUTOMATIC,    /* without forcing AMPLITUDE; otherwise SPEED if there are impacts, else
                                 DISPLACEMENT */
    SALTUS_SHOW_SPEED,        /* of the orbit's fastest impact */
    SALTUS_SHOW_IMPACTS,      /* speeds of all impacts */
    SALTUS_SHOW_DISPLACEMENT, /* observed displacement at phase 0 */
    SALTUS_SHOW_VELOCITY,     /* velocity of the observed displacement at phase 0 */
    SALTUS_SHOW_PERIOD,
    SALTUS_SHOW_AMPLITUDE /* largest and smallest observed displacement of an orbit; of an equilibrium its
                             displacement */
} saltus_show;

/* A range of an axis. */
typedef struct saltus_plot_part {
    char key[SALTUS_KEY_MAX];
    double low, high;
} saltus_plot_part;

/* A text at a point of a figure, such as n/p in its region: a place in the two parameters, or in the
 * parameter and what is shown over it, by the word of saltus plot (speed, turning, ...). */
typedef struct saltus_plot_label {
    char key[2][SALTUS_KEY_MAX];
    double value[2];
    const char *text; /* owned by the caller */
} saltus_plot_label;

typedef struct saltus_plot_options {
    saltus_show show;
    const saltus_plot_part *parts; /* ranges shown, at most one for each parameter; owned by the caller */
    int part_count;
    const saltus_plot_label *labels; /* owned by the caller */
    int label_count;
    saltus_figure_options look;
} saltus_plot_options;

/* Automatic vertical axis, whole ranges, no labels. */
saltus_plot_options saltus_plot_defaults(void);

/* Draw branch files over each other, with the parameter on the horizontal axis; or loci over their two
 * parameters, which may come in a different order in each file. `figure` ends in .png, .pdf or .svg. A single
 * sweep file is drawn in its automatic view (saltus_plot_sweep). Errors: SALTUS_BAD_INPUT (files that cannot
 * be read, do not fit together or have no point in the range), SALTUS_IO (gnuplot absent or failed, figure
 * not writable), SALTUS_NO_MEMORY. */
saltus_status saltus_plot(const char *figure, const char *const *paths, int count,
                          const saltus_plot_options *options, saltus_message *message);

/* What a figure of a sweep shows. */
typedef enum saltus_view {
    SALTUS_VIEW_AUTOMATIC, /* clouds over one axis, classes over two; for basins the attractors */
    SALTUS_VIEW_TURNING,   /* displacement diagram */
    SALTUS_VIEW_IMPACTS,   /* velocity diagram */
    SALTUS_VIEW_STROBOSCOPIC,
    SALTUS_VIEW_CLASS,      /* n/p */
    SALTUS_VIEW_ATTRACTORS, /* number of attractors; for basins which one */
    SALTUS_VIEW_LARGEST,    /* displacement */
    SALTUS_VIEW_RMS,        /* root mean square of the displacement */
    SALTUS_VIEW_SPEED,      /* largest impact speed */
    SALTUS_VIEW_RATE,       /* impacts per period */
    SALTUS_VIEW_CONTACT,    /* part of the time in contact */
    SALTUS_VIEW_LYAPUNOV,
    SALTUS_VIEW_SETTLED /* periods until the verdict */
} saltus_view;

typedef struct saltus_sweep_view {
    saltus_view view;
    const saltus_plot_part *parts; /* ranges of the axes that are shown; owned by the caller */
    int part_count;
    const saltus_plot_label *labels; /* owned by the caller */
    int label_count;
    const char *const *branches; /* branch files to overlay: periodic orbits on a diagram, loci on a map;
                                    owned by the caller */
    int branch_count;
    saltus_figure_options look;
} saltus_sweep_view;

/* Draw a sweep file. Errors: as saltus_plot. */
saltus_status saltus_plot_sweep(const char *figure, const char *path, const saltus_sweep_view *view,
                                saltus_message *message);
/* Draw a recorded trajectory: phase portrait and time history, with points at the beginning of each forcing
 * period. `look` may be NULL; its options for swapped and logarithmic axes are ignored. Errors: as
 * saltus_plot. */
saltus_status saltus_plot_trajectory(const char *figure, const char *path, const saltus_figure_options *look,
                                     saltus_message *message);

SALTUS_API_END
#endif
