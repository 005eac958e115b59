# One style for all figures.
set encoding utf8
set border 3 lc rgb '#606060' lw 1
set tics out nomirror scale 0.6 tc rgb '#303030'
set grid lt 1 lc rgb '#eeeeee' lw 1 back
set key off
set minussign
set style fill solid 1 noborder
set style textbox opaque noborder fillcolor '#ffffff' margins 0.4,0.2
set palette defined (0 '#3b2a6b', 0.25 '#33628d', 0.5 '#21908d', 0.75 '#5cb85c', 1 '#d4b020')
unset colorbox
