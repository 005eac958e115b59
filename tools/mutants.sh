#!/bin/sh
# Mutation test of the test suite: plants small random mistakes in src and in the commands and counts how many the
# tests catch. `sh tools/mutants.sh --help` lists the options; the results are in build-mutants/report.txt.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
extra_packages="libcmocka-dev binutils clang python3 python3-clang-14 ccache"
. tools/setup.sh
exec /usr/bin/python3 tools/mutants/mutants.py "$@"
