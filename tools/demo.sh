#!/bin/sh
# Installs missing packages, builds, and draws the diagnosis of a pipe that hits a rigid stop.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
. tools/setup.sh
cmake --preset release -DSALTUS_TESTS=OFF >/dev/null
cmake --build --preset release --target saltus >/dev/null
./build/saltus diagnose fig7d -o build/fig7d.png
