/* Exponents along an axis: what is above zero filled in one colour and what is below in another, standard
 * errors, and where all directions are lost.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include <math.h>

static const uint32_t error_colour = 0xc0392b;
static const double overlap = 0.5;  /* pixels */
static const double raised = 0.012; /* of the page: where what is lost is marked */

/* An edge of a cell, moved by so many pixels: columns overlap a little, or thin gaps would be seen between
 * them. */
static double edge_of(const saltus_sweep_page *page, int edge, double pixels) {
    double moved = pixels / (page->frame.right - page->frame.left);
    return saltus_cells_value(&page->x, fmin(fmax(saltus_cells_edge(&page->x, edge) + moved, 0), 1));
}

static double within(const saltus_range *range, double value) {
    return fmin(fmax(value, range->low), range->high);
}

/* The rows in the order of the axis: value, its cell, exponent and standard error; columns without one are
 * left out. */
static void put_block(const saltus_sweep_page *page, bool lost) {
    const saltus_cells *x = &page->x;
    for (int cell = 0; cell < x->count; cell++)
        for (int k = 0; k < saltus_sweep_visits(page->sweep); k++) {
            const saltus_sweep_row *row =
                &page->sweep->rows[saltus_sweep_visit(page->sweep, x->order[cell], k)];
            double value = page->sweep->axes[0].list[x->order[cell]],
                   exponent = saltus_sweep_measure(SALTUS_VIEW_LYAPUNOV, row), error = row->lyapunov_error;
            if (isnan(exponent) || (exponent == -INFINITY) != lost)
                continue;
            error = isfinite(error) ? error : 0;
            fprintf(page->file, "%.9g %.9g %.9g %.7g %.7g %.7g\n", value, edge_of(page, cell, -overlap),
                    edge_of(page, cell + 1, overlap),
                    lost ? page->up.low + raised * (page->up.high - page->up.low)
                         : within(&page->up, exponent),
                    lost ? 0 : within(&page->up, exponent - error),
                    lost ? 0 : within(&page->up, exponent + error));
        }
}

bool saltus_sweep_any_lost(const saltus_sweep_page *page) {
    bool lost = false;
    for (long long k = 0; k < page->sweep->row_count; k++)
        lost |= saltus_sweep_measure(SALTUS_VIEW_LYAPUNOV, &page->sweep->rows[k]) == -INFINITY;
    return lost;
}

void saltus_sweep_put_exponents(const saltus_sweep_page *page) {
    fputs("$exponents << EOD\n# parameter, its cell, exponent, less and plus its standard error\n",
          page->file);
    fputs("NaN NaN NaN NaN NaN NaN\n", page->file);
    put_block(page, false);
    fputs("EOD\n$lost << EOD\n# parameter where all directions are lost\nNaN NaN NaN NaN NaN NaN\n",
          page->file);
    put_block(page, true);
    fputs("EOD\n", page->file);
}

/* Beneath the points. */
void saltus_sweep_put_exponent_elements(const saltus_sweep_page *page) {
    static const struct {
        const char *sign;
        uint32_t colour;
    } sides[] = {{">", 0xf3cfc4}, {"<", 0xdfe9f3}};
    double zero = within(&page->up, 0);
    /* Columns only where each value of the axis has one exponent. */
    for (int k = 0; k < 2 && saltus_sweep_visits(page->sweep) == 1; k++)
        fprintf(page->file,
                "     $exponents using 1:($4%s0?$4:NaN):2:3:(%.9g):4 with boxxyerror fs solid noborder fc "
                "rgb '#%06x' notitle, \\\n",
                sides[k].sign, zero, (unsigned)sides[k].colour);
    if (zero == 0)
        fputs("     0 with lines lc rgb '#707070' lw 1.2 notitle, \\\n", page->file);
    fprintf(page->file,
            "     $exponents using 1:5:(0):($6-$5) with vectors nohead lw 1.3 lc rgb '#40%06x' notitle, \\\n",
            (unsigned)error_colour);
    if (saltus_sweep_any_lost(page))
        fputs("     $lost using 1:4 with points pt 11 ps 0.9 lc rgb '#404040' notitle, \\\n", page->file);
}
