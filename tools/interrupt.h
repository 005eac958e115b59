/* Signals that ask to stop: what is under way is ended in an orderly way, at the next place where that can
 * be.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_INTERRUPT_H
#define SALTUS_TOOLS_INTERRUPT_H

#include <signal.h>
#include <stdbool.h>

/* From here on, to the end of the program, SIGINT, SIGTERM and SIGHUP only raise the flag below; one that
 * comes seconds later ends the program at once. The flag is never lowered, and nothing else takes these
 * signals: whoever works for long looks at it. They are let through if they were blocked; those that are
 * ignored stay so. SIGXFSZ is ignored. */
void interrupt_catch(void);
/* For saltus_flow_options.stop. */
const volatile sig_atomic_t *interrupt_flag(void);
bool interrupt_asked(void);
/* "saltus: interrupted; ..." on stderr; returns the exit code. */
int interrupt_report(const char *what);

#endif
