/* Spectra of motions, sampled on the flow's dense output. Frequencies are in units of the forcing frequency
 * omega, times in forcing periods T.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SPECTRUM_H
#define SALTUS_SPECTRUM_H

#include "saltus/motion.h"
#include "saltus/signal.h"

SALTUS_API_BEGIN

enum { SALTUS_QUANTITIES_MAX = 2 };

/* Which quantity of a motion is analysed. */
typedef struct saltus_quantity {
    int coordinate; /* 0: the observed displacement (saltus_system_observer); k: the k-th displacement, and
                       after the last displacement the extra states; -k: the k-th quantity that a text
                       observes, of which samples jump where it does */
    bool velocity;  /* its rate instead; displacements only */
} saltus_quantity;

/* Read "displacement", "velocity", the name of an entry of the state, "q3", "v2", or of a quantity that a
 * text observes. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_quantity_parse(const saltus_system *system, const char *word, saltus_quantity *quantity,
                                    saltus_message *message);
/* The word that saltus_quantity_parse reads back as the quantity. */
saltus_state_name saltus_quantity_name(const saltus_system *system, saltus_quantity quantity);

typedef struct saltus_spectrum_options {
    saltus_flow_options flow;
    saltus_quantity quantities[SALTUS_QUANTITIES_MAX];
    int quantity_count; /* default 2: observed displacement and its velocity */
    int per_period; /* samples per forcing period, a multiple of 4 from 16 to 65536; 0: as few as make `reach`
                       trustworthy; default 0 */
    double reach; /* highest frequency wanted, if per_period is 0; 0: 32 for lines, 16 for densities; default
                     0 */
    long long periods; /* periods to analyse; of a periodic motion the whole orbits within them, at least 2;
                          0: 8 orbits (fewer where p is long), or 2048 periods without a period; default 0 */
    long long segment; /* length of Welch's segments in periods; if given, Welch's method is used for periodic
                          motions too; 0: a sixteenth of `periods`, and whole orbits for periodic motions;
                          default 0 */
    double confidence; /* of the band, between 0 and 1; default 0.95 */
    bool resting;      /* the system is at rest: motion below 1e-8 of the scale is ignored; default false */
    bool anew; /* restart each orbit from the given state, for unstable orbits; otherwise the trajectory runs
                  on; default false */
} saltus_spectrum_options;

/* The defaults stated beside the options. */
saltus_spectrum_options saltus_spectrum_defaults(void);

/* The spectra of one motion. */
typedef struct saltus_spectra {
    int count;
    saltus_quantity quantities[SALTUS_QUANTITIES_MAX];
    saltus_spectrum spectra[SALTUS_QUANTITIES_MAX];
    int periods;        /* p, as passed */
    long long analysed; /* forcing periods analysed */
    int per_period;
} saltus_spectra;

/* Sample a motion from a state at section phase 0 and analyse it: by whole orbits if its period p is known
 * (`periods` > 0, the state on the orbit), otherwise by Welch's method. Lines and density of a velocity are
 * those of the displacement, differentiated; a velocity sample exactly at a jump is the mean of both sides.
 * Free with saltus_spectra_clear. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY, those of the flow. */
saltus_status saltus_spectra_run(const saltus_system *system, const double *state, int periods,
                                 const saltus_spectrum_options *options, saltus_spectra *spectra,
                                 saltus_message *message);
/* The same for a classified motion, from its state and period; an unstable orbit is restarted in each period
 * p. */
saltus_status saltus_motion_spectra(const saltus_system *system, const saltus_motion *motion,
                                    const saltus_spectrum_options *options, saltus_spectra *spectra,
                                    saltus_message *message);
/* Zeroed spectra are accepted. */
void saltus_spectra_clear(saltus_spectra *spectra);

SALTUS_API_END
#endif
