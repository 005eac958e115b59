/* Names of the pipe's coefficients, shared by the model and its kernel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_PIPE_H
#define SALTUS_SYSTEM_PIPE_H

enum { pipe_alpha, pipe_root_beta, pipe_kappa, pipe_u0, pipe_sigma, pipe_omega };
enum { pipe_lambda2, pipe_damping, pipe_stiffness, pipe_rows };
enum { pipe_gyroscopic, pipe_gradient, pipe_couplings };

#endif
