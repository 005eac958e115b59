/* Signals that ask to stop: computations end cleanly at the next opportunity.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_INTERRUPT_H
#define SALTUS_TOOLS_INTERRUPT_H

#include <signal.h>
#include <stdbool.h>

/* From here on SIGINT, SIGTERM and SIGHUP only set the flag below; a second signal that comes half a second
 * later ends the program at once. The flag is never cleared and nothing else handles these signals, so long
 * computations must check it. Blocked signals are unblocked; ignored ones remain ignored. SIGXFSZ is
 * ignored. */
void interrupt_catch(void);
/* For saltus_flow_options.stop. */
const volatile sig_atomic_t *interrupt_flag(void);
bool interrupt_asked(void);
/* Files, then their folder, that a signal which ends the program at once removes, if they are there; NULL:
 * none any more. The texts must last. */
enum { INTERRUPT_CLEARED = 3 };
void interrupt_clears(const char *const paths[INTERRUPT_CLEARED]);
/* "saltus: interrupted; ..." on stderr; returns the exit code. */
int interrupt_report(const char *what);

#endif
