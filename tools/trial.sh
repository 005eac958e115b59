#!/bin/sh
# Installs missing packages, builds, tests the claims of the 2020 paper, and writes data/paper.md with its tables and
# figures: about ten minutes on two free cores. --quick writes a coarse page into build/trial/quick instead.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
. tools/setup.sh
cmake --preset release -DSALTUS_TESTS=OFF >/dev/null
cmake --build --preset release --target saltus_trial >/dev/null
trial="$PWD/build/saltus_trial"
place=data
if [ "${1:-}" = --quick ]; then
    trial="$trial --quick"
    place=build/trial/quick
fi
mkdir -p build/trial "$place/paper" "$place/figures"
$trial naive-points >build/trial/naive-points.dat
$trial page "$place"
gnuplot -d -e "points='build/trial/naive-points.dat'; picture='$place/figures/naive.png'" tools/trial/naive.gp
scripts="$PWD/tools/trial"
cd "$place"
gnuplot -d "$scripts/trial.gp"
