#!/bin/sh
# Builds with coverage counters, runs all tests in their short versions, and lists the code they do not reach: by file
# in build-coverage/report.txt, error paths in build-coverage/errors.txt.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
extra_packages="libcmocka-dev binutils gcovr"
. tools/setup.sh
cmake -S . -B build-coverage -G Ninja -DCMAKE_BUILD_TYPE=Debug -DSALTUS_ALL_ISAS=OFF \
    -DCMAKE_C_FLAGS="--coverage -O1 -march=native -fprofile-update=atomic" >/dev/null
cmake --build build-coverage >/dev/null
find build-coverage -name '*.gcda' -delete
SALTUS_SANITIZED=1 ctest --test-dir build-coverage -j 2 -E '^(installed_package|library_state)$' >build-coverage/tests.txt ||
    tail -n 5 build-coverage/tests.txt
gcovr --root . --filter 'src/' --filter 'tools/[a-z_]*\.[ch]$' --exclude-unreachable-branches build-coverage \
    --csv build-coverage/report.csv --txt build-coverage/report.txt --json build-coverage/lines.json
# lines.json has one object for each source line; a count of 0 means that no test ran the line.
tr '{' '\n' <build-coverage/lines.json | awk -F'[:," ]+' '
    /"file":/ {for (k = 1; k <= NF; k++) if ($k == "file") file = $(k + 1)}
    /"line_number":/ {
        line = 0; runs = -1
        for (k = 1; k <= NF; k++) {
            if ($k == "line_number") line = $(k + 1) + 0
            if ($k == "count") runs = $(k + 1) + 0
        }
        if (runs == 0) print file, line
    }' | sort -u -k1,1 -k2,2n | while read -r file line; do
    text=$(sed -n "${line}p" "$file")
    case $text in
    *saltus_fail* | *SALTUS_NO_MEMORY* | *SALTUS_IO* | *CLI_FAILED* | *cli_report*) echo "$file:$line:$text" ;;
    esac
done >build-coverage/errors.txt
grep '^TOTAL' build-coverage/report.txt
echo "refusals and failures that no test reaches: $(wc -l <build-coverage/errors.txt), in build-coverage/errors.txt"
