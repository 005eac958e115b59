#!/bin/sh
# Installs missing packages, builds, and draws Figures 2 to 8 of the paper into build/paper.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
. tools/setup.sh
cmake --preset release -DSALTUS_TESTS=OFF >/dev/null
cmake --build --preset release --target saltus >/dev/null
./build/saltus paper -o build/paper "$@"
