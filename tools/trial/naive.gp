# The naive method at d = 0.03, omega = 43 against its step, beside the exact 3/5 orbit.
# Variables: points, from `saltus_trial naive-points`; picture.
# SPDX-License-Identifier: GPL-3.0-or-later
set terminal pngcairo size 1600,1100 enhanced font 'DejaVu Sans,13' background '#ffffff' rounded
set output picture
set logscale x
set xrange [1e-5:0.02]
set format x '10^{%T}'
set tics out nomirror
set mxtics 10
set lmargin 12
set grid xtics lc rgb '#dddddd'
stats points using 1 index 1 nooutput
set multiplot layout 2, 1
set title 'naive method (fixed step, contact tested at step ends), {/:Italic d} = 0.03, {/:Italic ω} = 43; lines: the exact 3/5 orbit'
set ylabel 'displacement at the stop, phase 0'
set key at graph 0.01, 0.355 left Left reverse samplen 2
plot points index 1 using (1e-5):2:(0.02 - 1e-5):(0) with vectors nohead lc rgb '#b2182b' lw 1.2 title 'exact orbit, five section points', \
     points index 0 using 1:2 with points pt 7 ps 0.3 lc rgb '#2166ac' title 'naive method, 61 section points of each of 8 starts'
set title ''
set key at graph 0.01, 0.3 left Left reverse samplen 2
set xlabel 'step {/:Italic h}, fraction of the unit of time'
set ylabel 'impacts per forcing period'
set yrange [0:*]
plot points index 1 using (1e-5):3:(0.02 - 1e-5):(0) with vectors nohead lc rgb '#b2182b' lw 1.2 title 'exact: 3/5', \
     0.8 with lines dt 2 lc rgb '#777777' title '4/5, as the paper says', \
     points index 0 using 1:3 with points pt 7 ps 0.45 lc rgb '#2166ac' title 'naive method'
unset multiplot
