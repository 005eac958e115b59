/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/radau.h"
saltus_status saltus_radau_open(saltus_radau **radau, const saltus_system *system, int columns, const saltus_work *t) {
    (void)system; (void)columns; (void)t; *radau = NULL; return SALTUS_STALLED;
}
void saltus_radau_close(saltus_radau *radau) { (void)radau; }
void saltus_radau_reset(saltus_radau *radau) { (void)radau; }
void saltus_radau_publish(saltus_radau *radau, const saltus_work *work) { (void)radau; (void)work; }
saltus_status saltus_radau_step(saltus_radau *radau, saltus_work *work, double limit, long long *evaluations) {
    (void)radau; (void)work; (void)limit; (void)evaluations; return SALTUS_STALLED;
}
