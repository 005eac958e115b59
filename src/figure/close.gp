# The panel is drawn; nothing of it stays for the next one.
unset label
unset object
unset arrow
unset logscale
unset xlabel
unset ylabel
set format '% h'
set xtics auto
set ytics auto
unset mxtics
set key off
