#!/bin/sh
# Measures error against run time and the cost of each feature (saltus_bench, about five minutes), writes tables and
# figures to data/bench. --quick, half a minute: into build/bench.
# SPDX-License-Identifier: GPL-3.0-or-later
set -eu
cd "$(dirname "$0")/.."
build=${SALTUS_BUILD:-build}
case "$*" in
"" | --quick) ;;
*)
    echo "usage: tools/bench.sh [--quick]" >&2
    exit 2
    ;;
esac
if [ ! -f "$build/CMakeCache.txt" ]; then
    echo "bench.sh: nothing is configured in $build: build Saltus first, or name its folder in SALTUS_BUILD" >&2
    exit 1
fi
cmake --build "$build" --target saltus_bench >/dev/null
place=data/bench
[ "$*" = "" ] || place=$build/bench
mkdir -p "$place"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
csv=$place/work-precision.csv

"$build/saltus_bench" "$@" --to "$place" data/reference

problems=$(awk -F, '!/^#/ && $1 != "problem" && !seen[$1]++ {printf "%s ", $1}' "$csv")

# figure NAME TITLE X-COLUMN X-LABEL Y-LABEL Y-COLUMN
figure() {
    cat >"$work/figure.gp" <<END
set terminal pngcairo size 1680,880 font "sans,15"
set output "$place/$1.png"
set datafile separator comma
problems = "$problems"
methods = "taylor radau mixed gsl arkode adams bdf dopri5 fehlberg78"
titles = '"Saltus Taylor" "Saltus Radau" "Saltus mixed" "GSL rk8pd" "SUNDIALS ARKODE 8(7)" "SUNDIALS CVODE Adams" "SUNDIALS CVODE BDF" "Boost.Odeint dopri5" "Boost.Odeint Fehlberg 7(8)"'
colours = "#c00000 #e8a000 #d0509a #1f5fb4 #2a9d3a #7b4fa6 #808080 #17a2b8 #202020"
do for [k=1:words(methods)] {
    set style line k linecolor rgb word(colours, k) linewidth (k <= 3 ? 3 : 1.6) pointtype (k <= 3 ? 7 : 2 + k) pointsize (k <= 3 ? 1.2 : 0.9)
}
panels = words(problems) + 1
wide = panels > 6 ? 4 : panels > 2 ? 3 : panels
high = (panels + wide - 1) / wide
error(e) = e < 0.5 ? (e < 1e-16 ? 1e-16 : e) : NaN
set logscale xy
set format x "10^{%T}"
set format y "10^{%T}"
set yrange [1e-16:1e-1]
set ytics 1e-16,1e4,1
unset mytics
set grid xtics ytics back linetype 1 linewidth 0.7 linecolor rgb "#c8c8c8"
set xlabel "$4" offset 0,0.4
unset key
set multiplot layout high,wide title "$2"
do for [p=1:words(problems)] {
    set title word(problems, p) offset 0,-0.4
    set ylabel ((p - 1) % wide == 0 ? "$5" : "") offset 1.2,0
    plot for [k=1:words(methods)] "$csv" using ((strcol(1) eq word(problems, p) && strcol(2) eq word(methods, k)) ? \$$3 : NaN):(error($6)) with linespoints linestyle k
}
unset title
unset xlabel
unset ylabel
unset logscale
unset grid
set key at graph 0.02,0.96 left top Left reverse samplen 2 spacing 1.25 font "sans,15"
unset border
unset tics
set xrange [0:1]
set yrange [0:1]
plot for [k=1:words(methods)] NaN with linespoints linestyle k title word(titles, k)
unset multiplot
END
    gnuplot "$work/figure.gp"
}

figure work-precision "Error of the event times (of an orbit without impacts: of the state) against CPU time" 6 "CPU time, µs" "error" \
    "valid(4) ? \$4 : \$5"
figure work-precision-evaluations "Error of the event times against evaluations of the vector field (Taylor: orders)" 7 "evaluations" "error" \
    "valid(4) ? \$4 : \$5"
figure work-precision-state "Relative error of the final state against CPU time" 6 "CPU time, µs" "error" "\$5"
figure work-precision-multipliers "Error of the two leading multipliers against CPU time, tangent vectors included" 10 "CPU time, µs" \
    "error" "\$9"
