#!/bin/sh
# Installs missing packages, builds, and runs all tests.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
extra_packages="libcmocka-dev binutils"
. tools/setup.sh
cmake --preset release -DSALTUS_TESTS=ON >/dev/null
cmake --build --preset release
ctest --preset release
