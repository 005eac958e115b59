/* Spectra of motions, sampled on the flow's dense output. Frequencies are in units of the forcing frequency
 * omega, times in forcing periods T.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SPECTRUM_H
#define SALTUS_SPECTRUM_H

#include "saltus/motion.h"
#include "saltus/signal.h"

SALTUS_API_BEGIN

enum { SALTUS_QUANTITIES_MAX = 2 };

/* What is analysed of a motion. */
typedef struct saltus_quantity {
    int coordinate; /* 0: the observed one (saltus_system_observer); k: the k-th displacement, beyond all of
                       them the further states */
    bool velocity;  /* the rate of a displacement */
} saltus_quantity;

/* Read "displacement", "velocity" or the name of an entry of the state: "q3", "v2". Errors:
 * SALTUS_BAD_INPUT. */
saltus_status saltus_quantity_parse(const saltus_system *system, const char *word, saltus_quantity *quantity,
                                    saltus_message *message);
/* The word that reads back as the quantity. */
saltus_state_name saltus_quantity_name(const saltus_system *system, saltus_quantity quantity);

typedef struct saltus_spectrum_options {
    saltus_flow_options flow;
    saltus_quantity quantities[SALTUS_QUANTITIES_MAX];
    int quantity_count; /* default 2, displacement and velocity of the observed coordinate */
    int per_period; /* samples a forcing period, a multiple of 4 from 16 to 65536; 0: as few as make `reach`
                       trustworthy; default 0 */
    double reach; /* frequency up to which the spectra are wanted, where per_period is 0; 0: 32 for lines, 16
                     for densities; default 0 */
    long long periods; /* to analyse; 0: 8 orbits (fewer where p is long), or 2048 periods of motion without
                          period. Of periodic motion the whole orbits in it, 2 at least; default 0 */
    long long segment; /* length of Welch's segments in periods, then for periodic motion too; 0: a sixteenth
                          of `periods`, and whole orbits where the motion is periodic; default 0 */
    double confidence; /* of the band, between 0 and 1; default 0.95 */
    bool resting;      /* the system is at rest: what moves less than 1e-8 of the scale does not move; default
                          false */
    bool anew; /* start each orbit from the given state, for unstable orbits; otherwise run on; default
                          false */
} saltus_spectrum_options;

/* As told beside the options. */
saltus_spectrum_options saltus_spectrum_defaults(void);

/* The spectra of one motion. */
typedef struct saltus_spectra {
    int count;
    saltus_quantity quantities[SALTUS_QUANTITIES_MAX];
    saltus_spectrum spectra[SALTUS_QUANTITIES_MAX];
    int periods;        /* p as given */
    long long analysed; /* forcing periods analysed */
    int per_period;
} saltus_spectra;

/* Sample a motion from a state at section phase 0 and analyse it: by whole orbits where its period p is known
 * (`periods` > 0, the state on the orbit), otherwise by Welch's method. A velocity's lines and density
 * are those of the displacement, differentiated; a sample of it at the very time of a jump is the mean of
 * both sides. On success to be cleared. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY, those of the flow. */
saltus_status saltus_spectra_run(const saltus_system *system, const double *state, int periods,
                                 const saltus_spectrum_options *options, saltus_spectra *spectra,
                                 saltus_message *message);
/* The same of a classified motion: its state and period, each orbit anew where it is unstable. */
saltus_status saltus_motion_spectra(const saltus_system *system, const saltus_motion *motion,
                                    const saltus_spectrum_options *options, saltus_spectra *spectra,
                                    saltus_message *message);
/* Zeroed spectra are accepted. */
void saltus_spectra_clear(saltus_spectra *spectra);

SALTUS_API_END
#endif
