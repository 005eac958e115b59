#!/bin/sh
# Installs missing packages for building, testing and drawing on Debian. Sourced by demo.sh, paper.sh and test.sh.
# MPI (libopenmpi-dev, openmpi-bin) is optional: installed before the build, it lets sweeps run on several machines.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
needed="gcc cmake ninja-build pkgconf libgsl-dev libfftw3-dev liblapacke-dev libyaml-dev libhdf5-dev gnuplot-nox fonts-dejavu-core"
missing=""
for package in $needed ${extra_packages:-}; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q "ok installed" || missing="$missing $package"
done
if [ -n "$missing" ]; then
    echo "installing:$missing"
    as_root=""
    [ "$(id -u)" -eq 0 ] || as_root=sudo
    $as_root apt-get update -qq
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
fi
