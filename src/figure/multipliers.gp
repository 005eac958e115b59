set object circle at 0,0 size first 1 back fillstyle empty border lc rgb '#808080' lw 1.5
plot $multipliers using 1:2 with points pt 7 ps 1.3 lc rgb '#2c5f8a'
