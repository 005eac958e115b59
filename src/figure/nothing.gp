# A panel of words alone.
set xrange [0:1]
set yrange [0:1]
unset xtics
unset ytics
set label Reason at graph 0.5, graph 0.5 center front tc rgb '#303030'
plot NaN notitle
