plot $envelope using 1:2:3 with filledcurves fc rgb '#f0f0f0', \
     $shapes using 1:2:3 with lines palette lw 1.6
unset colorbox
