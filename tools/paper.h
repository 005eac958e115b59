/* The list of the paper's figures, data/paper/figures, embedded by the build.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_PAPER_H
#define SALTUS_TOOLS_PAPER_H

extern const char paper_figures[];

#endif
