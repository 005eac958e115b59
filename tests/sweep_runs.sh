#!/bin/sh
# Sweeps as they are run: the same file for any number of lanes, threads and processes, after kills at random
# moments, and from disks that fill up.
# Argument: the saltus program. SALTUS_KILLS: how often a run is killed (default 8; 40 with SALTUS_LONG_TESTS=1).
# SPDX-License-Identifier: GPL-3.0-or-later
set -u
# Equal results give equal files, whenever they are made.
export SOURCE_DATE_EPOCH=0
saltus=$1
kills=${SALTUS_KILLS:-${SALTUS_LONG_TESTS:+40}}
kills=${kills:-8}
[ -z "${SALTUS_SANITIZED:-}" ] || kills=4
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place" || exit 1
failures=0

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
}

# The sweep of these tests: with chaos, whose exponents are measured.
measure="--measure 500 --lifetime 160" chaos=chaotic
# Sanitizers are slow: they measure chaos without looking for orbits amid it.
[ -z "${SALTUS_SANITIZED:-}" ] || { measure="--measure 200 --lifetime 60" chaos=irregular; }
every="sweep fig6 --set N=1 --over omega=12:54:10 --over d=0.03:0.036:2 --at-most 150 --start both --seeds 2
       $measure --quiet"
what="--what turning,impacts,stroboscopic,lyapunov"
sweep="$every --record 20 $what"

# run FILE ARGUMENTS...: --record and --what among them take the place of the usual ones.
run() {
    file=$1
    shift
    case "$*" in
    *--record*) line="$every $what" ;;
    *--what*) line="$every --record 20" ;;
    *) line=$sweep ;;
    esac
    # shellcheck disable=SC2086
    "$saltus" $line -o "$file" "$@"
}

same() {
    cmp -s "$1" "$2" || fail "$3: $1 and $2 differ"
    rm -f "$2"
}

# number NAME: of the summary in the file of that name.
number() {
    grep -o "\"$1\": [0-9]*" summary | head -1 | grep -o '[0-9]*$'
}

# classes: of the summary, one "label count" per line in its order.
classes() {
    sed 's/.*"classes": \[//; s/\].*//' summary | tr '{' '\n' | sed -n 's/"label": "\([^"]*\)", "count": \([0-9]*\).*/\1 \2/p'
}

run whole.h5 --threads 1 --json >summary || fail "the sweep does not run"
[ "$(number points) $(number rows) $(number computed) $(number seeds)" = '20 120 120 2' ] || fail "the summary says $(cat summary)"
[ ! -e whole.h5.journal ] || fail "a finished sweep leaves its journal"
"$saltus" export whole.h5 -o rows.csv >/dev/null || fail "the sweep's rows cannot be exported"
[ "$(grep -c ",$chaos," rows.csv)" -gt 20 ] || fail "the sweep has not met much chaos"
# The summary counts the rows of each class, the most frequent first.
classes >told
cp told told_whole
awk -F, '!/^#/ && $3 != "pass" {n[$5 == "periodic" ? ($6 < 0 ? "chatter" : $6) "/" $7 : $5]++}
         END {for (k in n) print k, n[k]}' rows.csv | sort -k2,2nr -k1,1 >counted
sort -k2,2nr -k1,1 told | cmp -s - counted || fail "the summary counts $(cat told), the rows are $(cat counted)"
sort -s -k2,2nr told | cmp -s - told || fail "the summary's classes are not in order: $(cat told)"
run whole.h5 --resume --json >again || fail "a finished sweep is not taken up"
mv again summary
[ "$(number rows) $(number computed)" = '120 0' ] && classes | cmp -s - told || fail "a finished sweep's summary is $(cat summary)"
# For people: the same numbers, the twelve most frequent motions each on a line, the others together.
# table FILE ROWS: "name trajectories share" of each line, from lines "name count" and the number of all.
table() {
    awk -v rows="$2" '{n++; rest += $2} n <= 12 {printf "%s %d %.2f %%\n", $1, $2, 100 * $2 / rows; rest -= $2}
                      END {if (n > 12) printf "%d others %d %.2f %%\n", n - 12, rest, 100 * rest / rows}' "$1"
}
run whole.h5 --resume >text || fail "a finished sweep is not taken up"
sed -n '/^motion/,$p' text | grep ' %$' | tr -s ' ' >shown
table told 120 | cmp -s - shown || fail "the table says $(cat shown), the summary $(cat told)"
grep -q '20 points, 120 trajectories$' text && grep -qx 'all were there' text || fail "a finished sweep says $(cat text)"
[ "$(grep -c '^irregular: ' text)" -eq "$(grep -c '^irregular ' told)" ] || fail "what could be decided: $(cat text)"
for lanes in 1 4; do
    run lanes.h5 --threads 1 --lanes "$lanes" >/dev/null || fail "$lanes lanes do not run"
    same whole.h5 lanes.h5 "$lanes lanes"
done
run threads.h5 --threads 3 >/dev/null || fail "three threads do not run"
same whole.h5 threads.h5 "three threads"

OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_ALLOW_RUN_AS_ROOT OMPI_ALLOW_RUN_AS_ROOT_CONFIRM
if [ -z "${SALTUS_SANITIZED:-}" ] && command -v mpirun >/dev/null && ldd "$saltus" | grep -q libmpi; then
    # What the MPI library leaves behind is not looked at.
    together="env LSAN_OPTIONS=detect_leaks=0 mpirun --oversubscribe"
    # More ranks than threads, and where the C library can watch over its blocks, none is written past its end.
    # The MPI library's word about an abort would wait for memory for ever.
    watched="env OMPI_MCA_opal_signal= GLIBC_TUNABLES=glibc.malloc.check=3 LD_PRELOAD=libc_malloc_debug.so.0"
    $watched "$saltus" check fig6 >/dev/null 2>&1 || watched=
    # shellcheck disable=SC2086
    $together -n 3 $watched "$saltus" $sweep -o ranks.h5 --threads 1 --json >summary 2>err || fail "three ranks do not run: $(cat err)"
    [ "$(number rows) $(number computed) $(number ranks)" = '120 120 3' ] && classes | cmp -s - told_whole ||
        fail "the summary of three ranks is $(cat summary)"
    same whole.h5 ranks.h5 "three ranks"
    # Many tasks, which are handed out several at a time: none is lost, and none is done twice.
    many="impact-oscillator --over omega=2:3:160 --over F=0.1:1:120 --transient 1 --record 1 --longest 1 --rtol 1e-3 --atol 1e-4 --quiet"
    # shellcheck disable=SC2086
    "$saltus" sweep $many -o many.h5 --threads 2 >/dev/null || fail "a sweep of many points does not run"
    # shellcheck disable=SC2086
    $together -n 2 "$saltus" sweep $many -o shared.h5 --threads 1 --json >summary || fail "many points on two ranks do not run"
    [ "$(number rows) $(number computed) $(number ranks)" = '19200 19200 2' ] || fail "many points on two ranks: $(cat summary)"
    same many.h5 shared.h5 "many points on two ranks"
    # Without forcing rows are counted by returns to the section; ranks change nothing of it.
    unforced="relief-valve --over q=1:7:9 --what turning,stroboscopic,impacts,lyapunov --transient 300 --measure 600 --lifetime 100 --quiet"
    # shellcheck disable=SC2086
    "$saltus" sweep $unforced -o unforced.h5 --threads 1 >/dev/null || fail "a sweep without forcing does not run"
    # shellcheck disable=SC2086
    $together -n 2 "$saltus" sweep $unforced -o unforced_ranks.h5 --threads 1 >/dev/null 2>err ||
        fail "a sweep without forcing on two ranks does not run: $(cat err)"
    same unforced.h5 unforced_ranks.h5 "a sweep without forcing on two ranks"
    # One point is done by one of them, and not by the first, who lets the others choose before; they learn that there
    # is nothing else to do.
    # shellcheck disable=SC2086,SC2016
    timeout -k 5 120 $together -n 3 sh -c '"$@"; code=$?; times >"cpu.$OMPI_COMM_WORLD_RANK"; exit "$code"' - \
        "$saltus" sweep impact-oscillator --over omega=1 --transient 50000 --record 1 --what max --quiet -o one.h5 --json >summary 2>err &&
        [ "$(number rows) $(number computed) $(number ranks)" = '1 1 3' ] || fail "three ranks and one point: $(cat summary err)"
    tail -qn 1 cpu.0 cpu.1 cpu.2 | awk -F '[ms ]+' '{cpu[NR] = 60 * $1 + $2} END {exit !(cpu[2] > cpu[1] + 0.05 || cpu[3] > cpu[1] + 0.05)}' ||
        fail "the first rank does the only point: $(tail -n 1 cpu.0 cpu.1 cpu.2)"
    # A signal that only the last of them gets ends all; the run goes on later.
    # shellcheck disable=SC2086
    $together -n 2 "$saltus" $every $what --record 800 -o ended.h5 >/dev/null 2>err &
    child=$!
    tries=0
    while [ ! -s ended.h5.journal ] && [ "$tries" -lt 1000 ] && kill -0 "$child"; do
        sleep 0.01
        tries=$((tries + 1))
    done
    if kill -TERM "$(pgrep -P "$child" | tail -1)" 2>/dev/null; then
        wait "$child" && fail "ranks do not end by a signal to one of them"
        [ "$(grep -c '^saltus: ' err)" -eq 1 ] && grep -q '^saltus: interrupted; .*--resume' err ||
            fail "ranks that are ended say $(cat err)"
        # shellcheck disable=SC2086
        $together -n 2 "$saltus" $every $what --record 800 -o ended.h5 --resume >/dev/null 2>err || fail "resumed ranks: $(cat err)"
        run whole_long.h5 --record 800 >/dev/null || fail "the longer sweep does not run"
        same whole_long.h5 ended.h5 "resumed ranks"
    else
        wait "$child" || fail "ranks fail: $(cat err)"
    fi
    # Where the file cannot be made all of them end, and one speaks.
    # shellcheck disable=SC2086
    $together -n 2 "$saltus" $sweep -o absent/ranks.h5 >/dev/null 2>err && fail "ranks accept an absent folder"
    [ "$(grep -c '^saltus: ' err)" -eq 1 ] && grep -q '^saltus: .*absent' err || fail "ranks without a folder say $(cat err)"
else
    echo "no mpirun, built without MPI or with sanitizers: ranks are not tested"
fi

# Basins: the same file, every row of it counted.
plane="basins fig3 --over q1=-0.03:0.03:8 --over v1=-1:1:5 --at-most 75 --quiet --json"
# shellcheck disable=SC2086
"$saltus" $plane -o basins.h5 --threads 1 >summary || fail "basins do not run"
# shellcheck disable=SC2086
"$saltus" $plane -o other.h5 --threads 3 --lanes 2 >/dev/null || fail "basins do not run on three threads"
"$saltus" export basins.h5 -o basins.csv >/dev/null || fail "the basins' rows cannot be exported"
sed 's/.*"attractors": //' summary | grep -o '"count": [0-9]*' | grep -o '[0-9]*' | sort -n | tr '\n' ' ' >told
awk -F, '!/^#/ && $3 != "pass" && $9 >= 0 {n[$9]++} END {for (k in n) print n[k]}' basins.csv | sort -n | tr '\n' ' ' >counted
cmp -s told counted || fail "the summary's attractors have $(cat told) rows, the table $(cat counted)"
# shellcheck disable=SC2086
"$saltus" ${plane% --json} -o basins.h5 --resume >text || fail "finished basins are not taken up"
sed 's/.*"attractors": //' summary | tr '{' '\n' |
    sed -n 's/"label": "\([^"]*\)", "largest_multiplier": \([^,]*\), "count": \([0-9]*\),.*/\1 \3 \2/p' >told
awk '{printf "%s %d %.2f %% %.4g\n", $1, $2, 100 * $2 / 40, $3; rest += $2}
     END {if (rest < 40) printf "none: irregular %d %.2f %%\n", 40 - rest, 100 * (40 - rest) / 40}' told >counted
sed -n '/^attractor/,$p' text | sed 1d | grep ' %' | tr -s ' ' | cmp -s - counted || fail "the basins' table says $(cat text), the summary $(cat told)"
[ "$(awk -F, '!/^#/ && $9 == -1 && $5 != "irregular"' basins.csv)" = '' ] || fail "a settled row has no attractor"
[ "$(awk -F, '!/^#/ && $9 >= 0 && $5 == "irregular"' basins.csv)" = '' ] || fail "a row that has not settled has an attractor"
[ "$(awk -F, '$5 == "irregular"' basins.csv | wc -l)" -gt 0 ] || fail "all rows of the basins have settled"
same basins.h5 other.h5 "basins on three threads"

# A kill after a random part of a second, again and again; each resumed run goes on with what there is.
killed=0
finished=0
while [ "$killed" -lt "$kills" ] && [ "$finished" -lt 200 ]; do
    rm -f killed.h5 killed.h5.journal
    first=1
    while [ "$killed" -lt "$kills" ]; do
        resume=--resume
        [ "$first" -eq 1 ] && resume=
        first=0
        # shellcheck disable=SC2086
        "$saltus" $sweep -o killed.h5 $resume >/dev/null 2>err &
        child=$!
        sleep "0.$(od -An -N2 -tu2 /dev/urandom | awk '{printf "%03d", $1 % 200}')"
        if kill -9 "$child" 2>/dev/null; then
            killed=$((killed + 1))
            wait "$child" 2>/dev/null
            [ ! -e killed.h5 ] || "$saltus" export killed.h5 -o rows.csv >/dev/null 2>err || fail "a killed run's file: $(cat err)"
        else
            wait "$child" || fail "a resumed run fails: $(cat err)"
            same whole.h5 killed.h5 "resumed after kills"
            finished=$((finished + 1))
            break
        fi
    done
done
if [ -e killed.h5.journal ]; then
    run killed.h5 --resume >/dev/null 2>err || fail "the last resumed run fails: $(cat err)"
    same whole.h5 killed.h5 "resumed after the last kill"
fi

# A polite end: one sentence, exit status 1, nothing lost.
# shellcheck disable=SC2086
"$saltus" $sweep -o stopped.h5 --threads 1 >/dev/null 2>err &
child=$!
sleep 0.1
if kill -TERM "$child" 2>/dev/null; then
    wait "$child"
    got=$?
    if [ "$got" -ne 0 ]; then
        [ "$got" -eq 1 ] || fail "an interrupted sweep exits with $got"
        [ "$(wc -l <err)" -eq 1 ] && grep -q -- --resume err || fail "an interrupted sweep says: $(cat err)"
        there=$(sed -n 's/.*holds \([0-9]*\) of 60 points.*/\1/p' err)
        run stopped.h5 --resume --json >summary 2>err || fail "resumed after SIGTERM: $(cat err)"
        [ "$(number computed)" -eq $((120 - 2 * there)) ] || fail "after $there points the resumed sweep says $(cat summary)"
        classes | cmp -s - told_whole || fail "a resumed sweep's summary is $(cat summary)"
    fi
    same whole.h5 stopped.h5 "resumed after SIGTERM"
fi

# A full disk, imitated by a limit on the size of files.
(
    trap '' XFSZ
    ulimit -f 40
    run full.h5 >/dev/null 2>full.err
    echo $? >full.status
)
[ "$(cat full.status)" -eq 1 ] || fail "a full disk gives exit status $(cat full.status)"
[ "$(wc -l <full.err)" -eq 1 ] && ! grep -q interrupted full.err || fail "a full disk gives $(cat full.err)"
run full.h5 --resume >/dev/null 2>err || fail "resumed after a full disk: $(cat err)"
same whole.h5 full.h5 "resumed after a full disk"

# Of a table there is but the journal until the end: told is that it is full, not what goes wrong on the way out.
run table.csv --what max --json >summary || fail "the table does not run"
(
    trap '' XFSZ
    ulimit -f 16
    run full.csv --what max >/dev/null 2>full.err
    echo $? >full.status
)
[ "$(cat full.status)" -eq 1 ] && [ "$(wc -l <full.err)" -eq 1 ] && grep -q '^saltus: full.csv.journal: .*--resume' full.err ||
    fail "a full disk gives exit status $(cat full.status), $(cat full.err)"
run full.csv --what max --resume --json >summary 2>err || fail "a table after a full disk: $(cat err)"
[ "$(number computed)" -gt 0 ] && [ "$(number computed)" -lt 120 ] || fail "after a full disk the summary says $(cat summary)"
same table.csv full.csv "a table after a full disk"

# Places that cannot be written are refused before anything is computed.
for target in absent/sweep.h5 . /dev/null; do
    run "$target" >/dev/null 2>err && fail "$target is accepted"
    [ "$(wc -l <err)" -eq 1 ] || fail "$target: $(cat err)"
done

# Another sweep's journal is not taken up.
# shellcheck disable=SC2086
"$saltus" $sweep -o other.h5 >/dev/null 2>&1 &
child=$!
sleep 0.1
kill -9 "$child" 2>/dev/null && wait "$child" 2>/dev/null
if [ -e other.h5.journal ]; then
    "$saltus" sweep fig6 --over omega=12:54:25 --resume --quiet -o other.h5 >/dev/null 2>err && fail "another sweep's journal is taken up"
    [ "$(wc -l <err)" -eq 1 ] || fail "another sweep's journal: $(cat err)"
fi

[ "$failures" -eq 0 ] && echo "sweeps: the same file every time, $killed kills"
exit "$((failures > 0))"
