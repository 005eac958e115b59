#!/bin/sh
# Builds for 64-bit ARM with Debian's cross compiler and runs tests under emulation. All files, also the ARM libraries,
# stay in build-aarch64. Argument: a regular expression that selects tests (default: those that check the numerics
# within minutes).
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
tests=${1:-'test_(system|isolate|closed_forms|reference|grazing|map|scene|average|orbit|io)$'}
extra_packages="gcc-aarch64-linux-gnu qemu-user"
. tools/setup.sh

place=$(pwd)/build-aarch64
root=$place/root
library=usr/lib/aarch64-linux-gnu
mkdir -p "$place"

# Download the ARM packages with a separate package database, and only unpack them.
unpack() {
    base=$place/packages
    mkdir -p "$base/lists/partial" "$base/cache/archives/partial" "$root/usr/lib" "$root/usr/bin" "$root/usr/sbin"
    : >"$base/status"
    set -- -q -o "Dir::State=$base" -o "Dir::State::status=$base/status" -o "Dir::Cache=$base/cache" \
        -o APT::Architecture=arm64 -o APT::Architectures::=arm64
    apt-get "$@" update
    apt-get "$@" install -y --no-install-recommends --download-only libc6-dev libgomp1 libgsl-dev liblapacke-dev \
        libfftw3-dev libhdf5-dev libyaml-dev libcmocka-dev
    for name in lib bin sbin; do
        ln -sfn "usr/$name" "$root/$name"
    done
    for package in "$base"/cache/archives/*.deb; do
        dpkg-deb --fsys-tarfile "$package" | tar -x -C "$root" --keep-directory-symlink
    done
    # Choose the alternatives that installing the packages would choose.
    for name in blas lapack; do
        for ending in so so.3 a; do
            ln -sf "$name/lib$name.$ending" "$root/$library/lib$name.$ending"
        done
        ln -sf "$name-netlib.pc" "$root/$library/pkgconfig/$name.pc"
    done
    : >"$place/unpacked"
}
[ -e "$place/unpacked" ] || unpack >"$place/unpack.log" 2>&1 || {
    cat "$place/unpack.log"
    exit 1
}

cat >"$place/toolchain.cmake" <<END
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_SYSROOT $root)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L $root -E LD_LIBRARY_PATH=/$library/hdf5/serial)
END
# CMake finds HDF5 by running its compiler wrapper, which is an ARM program; this script replaces it.
cat >"$place/h5cc" <<END
#!/bin/sh
flags="-I$root/usr/include/hdf5/serial -L$root/$library/hdf5/serial -lhdf5_hl -lhdf5"
case "\$*" in
*-show*) echo "aarch64-linux-gnu-gcc \$flags" ;;
*) exec aarch64-linux-gnu-gcc --sysroot="$root" "\$@" \$flags ;;
esac
END
chmod +x "$place/h5cc"

# -O2: gcc 12's cross compiler fails with an internal error on one vectorized loop of the tests at -O3.
PKG_CONFIG_SYSROOT_DIR=$root PKG_CONFIG_LIBDIR=$root/$library/pkgconfig \
    cmake -S . -B "$place/build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$place/toolchain.cmake" \
    -DCMAKE_BUILD_TYPE=RelWithDebInfo -DSALTUS_WERROR=ON -DHDF5_C_COMPILER_EXECUTABLE="$place/h5cc" >/dev/null
cmake --build "$place/build" >"$place/build.log" 2>&1 || {
    tail -40 "$place/build.log"
    exit 1
}
SALTUS_SANITIZED=1 ctest --test-dir "$place/build" --output-on-failure -j 2 -R "$tests"
