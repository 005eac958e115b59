#!/bin/sh
# A trial of branches: random pipes and oscillators with impacts, a third of them with stops so near that they chatter,
# each followed in a random parameter, and special points of each located anew in 128 bits. A change of the number of multipliers outside the unit circle must
# have its point in between.
# usage: branches.sh saltus precise_points [branches [points of each [seed]]]
# SPDX-License-Identifier: GPL-3.0-or-later
set -u
saltus=$1 precise=$2 count=${3:-3} points=${4:-2} seed=${5:-1}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
wrong=0 done=0 located=0

# Each line: scene, settings, parameter, its range.
random_branches() {
    awk -v count="$count" -v seed="$seed" 'function between(a, b) { return a + (b - a) * rand() }
    BEGIN {
        srand(seed)
        for (k = 0; k < count; k++) {
            split("upper lower both", sides, " ")
            side = sides[1 + int(3 * rand())]
            split("omega d r u0", keys, " ")
            oscillator = k % 3 == 0
            chatters = k % 3 == 2
            key = keys[1 + int((chatters ? 4 : 3) * rand())]
            delete value
            if (oscillator) {
                value["omega"] = between(0.5, 2.5); value["d"] = between(0.1, 1.2); value["r"] = between(0.3, 0.9)
                printf "impact-oscillator c=%.4f sides=%s", between(0.05, 0.3), side
            } else {
                value["omega"] = between(10, 50); value["d"] = between(0.01, 0.04); value["r"] = between(0.3, 0.9)
                value["u0"] = between(3.8, 5)
                if (chatters) {
                    value["d"] = between(0.004, 0.02); value["r"] = between(0.2, 0.7)
                }
                printf "pipe N=%d alpha=%.5f sigma=%.3f sides=%s", 1 + int(2 * rand()), between(0.002, 0.01),
                       between(0.1, 0.5), side
            }
            for (name in value)
                printf " %s=%.5f", name, value[name]
            printf " %s=%.6f:%.6f\n", key, value[key] * 0.7, value[key] * (key == "r" ? 1.1 : 1.3)
        }
    }'
}

# Between points with a label, multipliers outside the unit circle stay as many as they are; the last point before
# a change and the first one after it are unlabelled.
count_multipliers() {
    awk '{
        match($0, /"branch": [0-9]+/); branch = substr($0, RSTART + 10, RLENGTH - 10)
        match($0, /"label": "[A-Z]*"/); label = substr($0, RSTART + 10, RLENGTH - 11)
        unstable = match($0, /"unstable": [0-9]+/) ? substr($0, RSTART + 12, RLENGTH - 12) : "none"
        match($0, /"arclength": [-+.e0-9]+/); at = substr($0, RSTART + 13, RLENGTH - 13)
        if (label != "" || branch != last_branch) known = "none"
        if (label == "") {
            if (known != "none" && unstable != known) {
                printf "multipliers outside the unit circle: %s, then %s at arclength %s\n", known, unstable, at
                wrong = 1
            }
            known = unstable
        }
        last_branch = branch
    } END { exit wrong }'
}

random_branches >"$folder/scenes"
while read -r scene settings; do
    range=${settings##* } settings=${settings% *}
    # shellcheck disable=SC2086 # the settings are words
    timeout 600 "$saltus" continue "$scene" --set $settings --in "$range" --points 300 --transient 2000 --quiet --force \
        --json -o "$folder/branch.h5" >"$folder/points" 2>"$folder/message"
    status=$?
    if [ "$status" -ne 0 ]; then
        grep -q 'no periodic orbit to start from' "$folder/message" && continue
        echo "$scene $settings $range: status $status: $(cat "$folder/message")"
        wrong=$((wrong + 1))
        continue
    fi
    done=$((done + 1))
    count_multipliers <"$folder/points" >"$folder/counts" || {
        echo "$scene $settings $range"
        cat "$folder/counts"
        wrong=$((wrong + 1))
    }
    "$precise" "${range%%=*}" "$points" <"$folder/points" >"$folder/checks" || {
        echo "$scene $settings $range"
        grep -v 'off.*[0-9]$' "$folder/checks"
        wrong=$((wrong + 1))
    }
    located=$((located + $(grep -c . "$folder/checks")))
    [ -n "${TRIAL_VERBOSE:-}" ] && cat "$folder/checks"
done <"$folder/scenes"
echo "$done branches of $count, $located special points located in 128 bits, $wrong branches wrong"
[ "$wrong" -eq 0 ] && [ "$done" -gt 0 ]
