#!/bin/sh
# Installs the build into an empty prefix and builds the example against it: CMake package (static and shared) and
# pkg-config. Then the Debian packages, where the tools that make them are there.
# Arguments: build folder, the example's folder.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
build=$1 example=$2
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
# is_right PROGRAM: it tells an impact.
is_right() {
    "$1" pipe omega=43 | grep -q '^first impact at [0-9.]* T, speed [0-9.]*$'
}

cmake --install "$build" --prefix "$place/prefix" >/dev/null
library=$(dirname "$(find "$place/prefix" -name libsaltus.so)")
LD_LIBRARY_PATH=$library
PKG_CONFIG_PATH=$library/pkgconfig
export LD_LIBRARY_PATH PKG_CONFIG_PATH
for kind in static shared; do
    cmake -S "$example" -B "$place/$kind" -DCMAKE_PREFIX_PATH="$place/prefix" -DSALTUS_KIND=$kind >/dev/null
    cmake --build "$place/$kind" >/dev/null
    is_right "$place/$kind/first_impact"
done
# shellcheck disable=SC2046
cc "$example/first_impact.c" -o "$place/first_impact" $(pkg-config --cflags --libs saltus)
is_right "$place/first_impact"
"$place/prefix/bin/saltus" check pipe >/dev/null
for file in man/man1/saltus.1 man/man1/saltus-sweep.1 bash-completion/completions/saltus; do
    [ -s "$place/prefix/share/$file" ] || { echo "no $file is installed"; exit 1; }
done

command -v dpkg-shlibdeps >/dev/null || exit 0
(cd "$build" && cpack -G DEB -B "$place" >/dev/null)
for package in saltus libsaltus0 libsaltus-dev; do
    set -- "$place/${package}"*_[0-9]*.deb
    [ -f "$1" ] || { echo "no package $package"; exit 1; }
    dpkg-deb -x "$1" "$place/root"
done
for file in bin/saltus include/saltus/saltus.h share/saltus/scenes/pipe.yaml \
    share/man/man1/saltus-classify.1 share/bash-completion/completions/saltus; do
    [ -f "$place/root/usr/$file" ] || { echo "the packages hold no $file"; exit 1; }
done
"$place/root/usr/bin/saltus" check pipe >/dev/null
# A program of a user against the unpacked packages, wherever they lie, with the shared library and the static one.
library=$(dirname "$(find "$place/root" -name libsaltus.so)")
LD_LIBRARY_PATH=$library
PKG_CONFIG_PATH=$library/pkgconfig
# shellcheck disable=SC2046
cc "$example/first_impact.c" -o "$place/first_impact" $(pkg-config --cflags --libs saltus)
is_right "$place/first_impact"
# shellcheck disable=SC2046
cc "$example/first_impact.c" -Wl,--as-needed "$library/libsaltus.a" -o "$place/first_impact" \
    $(pkg-config --cflags --static --libs saltus)
LD_LIBRARY_PATH= is_right "$place/first_impact"
for wanted in $(pkg-config --print-requires-private saltus); do
    pkg-config --exists "$wanted" || { echo "$wanted, which saltus.pc names, is not there"; exit 1; }
done
