# How an estimate converged: its error band, itself and the value that it ended at. Values are less Origin. The band is
# cut off at the panel's edges by hand: gnuplot lets filled areas run out of a panel at its left.
if (Zero) {
set arrow from graph 0, first 0 to graph 1, first 0 nohead front lc rgb '#707070' lw 1.4
}
set arrow from graph 0, first Final to graph 1, first Final nohead front lc rgb '#c44e2a' dt (12,9) lw 1.6
set key at graph @KeyPlace Left reverse samplen 1.8 width -1 font Small textcolor rgb '#303030'
cut(x) = x < Low ? Low : x > High ? High : x
Marks = ""
if (Points < 30) {
Marks = "$convergence using 1:($2 - Origin) with points pt 7 ps 0.8 lw 1.4 lc rgb '#2c5f8a' notitle, "
}
if (Points == 1) {
Marks = "$convergence using 1:($2 - Origin):3 with yerrorbars pt 7 ps 0.8 lw 1.4 lc rgb '#2c5f8a' notitle, "
}
plot $convergence using 1:(cut($2 - Origin - $3)):(cut($2 - Origin + $3)) with filledcurves fc rgb '#d3dfe9' fs solid noborder title '± standard error', \
     $convergence using 1:($2 - Origin) with lines lw 2 lc rgb '#2c5f8a' title 'estimate', \
     @Marks NaN with lines dt (12,9) lw 1.6 lc rgb '#c44e2a' title Result
