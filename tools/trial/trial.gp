# Kinds of motion against the pulsation frequency, figure by figure, and against the clearance, with the ranges that the
# paper names above. Run in the folder of the page: reads paper/classes.csv, writes figures/trial.png and
# figures/trial-clearance.png.
# SPDX-License-Identifier: GPL-3.0-or-later
set datafile separator ','
set style fill solid 1 noborder
set ylabel 'share of starts, %'
set tics out
share(k) = 100.0 * column(k) / (column(3) + column(4) + column(5) + column(6) + column(7) + column(8))
rows(name) = sprintf("< awk -F, '$1 == \"%s\"' paper/classes.csv", name)
set key outside right center vertical Left reverse samplen 2 spacing 1.2
set lmargin 10
set rmargin 24

set macros
bars = "using 2:(100) with boxes lc rgb '#cf4a3c' title 'no period up to 20', \
  '' using 2:(share(3) + share(4) + share(5) + share(6)) with boxes lc rgb '#303030' title 'held', \
  '' using 2:(share(3) + share(4) + share(5)) with boxes lc rgb '#eac35a' title 'chatter', \
  '' using 2:(share(3) + share(4)) with boxes lc rgb '#4393c3' title 'n/p', \
  '' using 2:(share(3)) with boxes lc rgb '#d9d9d9' title 'no contact'"
claim(n, a, b, y, colour) = sprintf("set object %d rectangle from %g,%g to %g,%g fc rgb '%s' fs solid noborder front", n, a, y, b, y + 8, colour)

set terminal pngcairo size 1600,1700 enhanced font 'DejaVu Sans,13' background '#ffffff' rounded
set output 'figures/trial.png'
set boxwidth 0.106
set xrange [0:55]
set xtics 5 nomirror
set mxtics 5
set multiplot layout 6, 1
set title 'no stop (Figure 2); bars above: what the paper says'
set yrange [0:115]
set ytics 0, 25, 100
eval claim(1, 4, 14, 104, '#cf4a3c')
eval claim(2, 14, 55, 104, '#d9d9d9')
plot rows('2') @bars
unset object

set title 'd = 0.03, r = 0.9 (Figure 5)'
eval claim(1, 3, 24.6, 104, '#cf4a3c')
eval claim(2, 24.7, 35, 104, '#d9d9d9')
eval claim(3, 35.1, 40.4, 104, '#cf4a3c')
eval claim(4, 40.5, 43.7, 104, '#4393c3')
eval claim(5, 43.8, 52, 104, '#303030')
eval claim(6, 52.1, 54.4, 104, '#cf4a3c')
plot rows('5') @bars
unset object

set title 'd = 0.035, r = 0.9 (Figure 6)'
eval claim(1, 15.3, 20.5, 104, '#4393c3')
eval claim(2, 20.6, 24.6, 104, '#eac35a')
eval claim(3, 35.6, 46.3, 104, '#4393c3')
eval claim(4, 46.7, 49.1, 104, '#cf4a3c')
plot rows('6') @bars
unset object

set title 'd = 0.035, r = 0.8 (Figure 8)'
set yrange [0:100]
set boxwidth 0.212
plot rows('8a') @bars
set title 'd = 0.035, r = 0.7'
plot rows('8b') @bars
set title 'd = 0.035, r = 0.6'
set xlabel 'pulsation frequency {/:Italic ω}'
plot rows('8c') @bars
unset multiplot
unset mxtics
unset xlabel

set terminal pngcairo size 1600,800 enhanced font 'DejaVu Sans,13' background '#ffffff' rounded
set output 'figures/trial-clearance.png'
set boxwidth 0.000212
set xrange [0:0.046]
set xtics 0.005 nomirror
set yrange [0:115]
set multiplot layout 2, 1
set title '{/:Italic ω} = 10 (Figure 4a); bars above: what the paper says'
eval claim(1, 0, 0.025, 104, '#303030')
eval claim(2, 0.026, 0.046, 104, '#cf4a3c')
plot rows('4a') @bars
unset object
set title '{/:Italic ω} = 20 (Figure 4b)'
set xlabel 'clearance {/:Italic d}'
eval claim(1, 0, 0.027, 104, '#303030')
eval claim(2, 0.028, 0.035, 104, '#cf4a3c')
eval claim(3, 0.036, 0.040, 104, '#4393c3')
eval claim(4, 0.040, 0.046, 104, '#d9d9d9')
plot rows('4b') @bars
unset multiplot
