#!/usr/bin/env bash
# Fuzzes every target of tests/fuzz for the given seconds (default 60), two at a time, under the address and
# undefined-behaviour sanitizers. Fails on a crash, a leak, a hang or too much memory; the input responsible is
# then in build-asan+ubsan/fuzz/found: fix the fault and copy the input to tests/fuzz/corpus.
#     tools/fuzz.sh [seconds [target ...]]
# SPDX-License-Identifier: GPL-3.0-or-later
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(hdf5 set scene orbit_json)
build=build-asan+ubsan
found=$build/fuzz/found
export ASAN_OPTIONS=intercept_tls_get_addr=0 # tests/leaks.supp says why

cmake --preset asan+ubsan >/dev/null
cmake --build --preset asan+ubsan --target "${targets[@]/#/fuzz_}" >/dev/null
rm -rf "$found"
mkdir -p "$found"

# fuzz TARGET: new inputs are kept in build-asan+ubsan/fuzz/corpus for the next run.
fuzz() {
    local target=$1 seeds=(tests/fuzz/corpus/"$1")
    [ "$target" != scene ] || seeds+=(data/scenes)
    mkdir -p "$build/fuzz/corpus/$target"
    if "$build/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=3000 \
        -artifact_prefix="$found/$target-" -print_final_stats=1 "$build/fuzz/corpus/$target" "${seeds[@]}" \
        >"$found/$target.log" 2>&1; then
        echo "$target: $(sed -n 's/stat::number_of_executed_units: *//p' "$found/$target.log") inputs, none fails"
    else
        grep -m 1 -A 40 'ERROR:\|out of memory\|FAILS' "$found/$target.log" || tail -n 40 "$found/$target.log"
        echo "$target: FAILS; see $found"
        return 1
    fi
}

failures=0
for ((k = 0; k < ${#targets[@]}; k += 2)); do
    jobs=()
    for target in "${targets[@]:k:2}"; do
        fuzz "$target" &
        jobs+=($!)
    done
    for job in "${jobs[@]}"; do
        wait "$job" || failures=$((failures + 1))
    done
done
exit "$((failures > 0))"
