#!/bin/sh
# Installs the build into an empty prefix and builds a user's project against it: CMake package (static and shared) and
# pkg-config. Arguments: build folder, the project's folder.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
build=$1 project=$2
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cmake --install "$build" --prefix "$place/prefix" >/dev/null
cmake -S "$project" -B "$place/user" -DCMAKE_PREFIX_PATH="$place/prefix" >/dev/null
cmake --build "$place/user" >/dev/null
"$place/user/use_static"
library=$(dirname "$(find "$place/prefix" -name libsaltus.so)")
LD_LIBRARY_PATH=$library "$place/user/use_shared"
PKG_CONFIG_PATH=$library/pkgconfig
export PKG_CONFIG_PATH
sed -i "s|^prefix=.*|prefix=$place/prefix|" "$library/pkgconfig/saltus.pc"
# shellcheck disable=SC2046
cc "$project/use.c" -o "$place/use_pkgconfig" $(pkg-config --cflags --libs saltus)
LD_LIBRARY_PATH=$library "$place/use_pkgconfig"
"$place/prefix/bin/saltus" check pipe >/dev/null
