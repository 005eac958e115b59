#!/bin/sh
# The long version of the stress suite: runs ten times as long, all rows, all random scenes. Writes the results to
# data/bench/stress.txt.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
build=${1:-build}
log=$(mktemp)
trap 'rm -f "$log"' EXIT
passed=yes
for name in test_stress test_random_scenes; do
    SALTUS_LONG_TESTS=1 "$build/tests/$name" >>"$log" 2>&1 || passed=no
done
mkdir -p data/bench
{
    echo "# Stress suite, long version: tools/stress.sh"
    echo "# $(date -u +%Y-%m-%d), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(uname -sr)"
    echo "# Behind each name: the largest violation in units of what rounding and the tolerance allow; above 1 is a failure."
    grep -v '^\[' "$log"
    echo "# all passed: $passed"
} >data/bench/stress.txt
[ "$passed" = yes ]
