/* The figure of a recorded trajectory: phase portrait and time history as on a sheet, of the whole record.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/trajectory.h"
#include "figure/sheet.h"
#include "record/describe.h"

/* Below the caption, which side of which stop has which sign, if there are several. */
static void put_faces(const saltus_sheet *sheet, saltus_page *page) {
    const double entry = 130, row = 22, begin = saltus_page_narrow(page) ? 18 : 54,
                 type = saltus_page_type(page, 11);
    const int columns = (int)((page->width - begin) / entry);
    int count = 0;
    for (int f = 0; f < sheet->face_count && sheet->face_count > 1; f++) {
        const saltus_sheet_face *face = &sheet->faces[f];
        char text[64];
        if (!face->hit)
            continue;
        const double x = begin + count % columns * entry, y = page->top - 6 - count / columns * row;
        saltus_page_label(page, "", x, y, "point pt %d ps 1.1 lc rgb '#%06x' front", face->sign,
                          face->colour);
        snprintf(text, sizeof text, "stop %d, %s", face->stop + 1, saltus_side_word(face->side));
        saltus_page_label(page, text, x + 12, y, "left front font ',%.4g' tc rgb '#303030'", type);
        count++;
    }
    page->top -= count ? 4 + (count + columns - 1) / columns * row : 0;
}

saltus_status saltus_plot_trajectory(const char *figure, const char *path, const saltus_figure_options *look,
                                     saltus_message *message) {
    saltus_trajectory_file file = {.system = NULL};
    saltus_page page;
    saltus_status status = saltus_figure_check(figure, look, message);
    if (status == SALTUS_OK)
        status = saltus_trajectory_file_read(path, &file, message);
    if (status == SALTUS_OK)
        status = saltus_page_open(&page, figure, look, message);
    if (status == SALTUS_OK) {
        /* Panels side by side; on a narrow page one above the other. */
        saltus_sheet sheet = {.page = &page, .system = file.system, .record = &file.record};
        const bool narrow = saltus_page_narrow(&page);
        const int columns = narrow ? 1 : 2, rows = narrow ? 2 : 1;
        saltus_sheet_choose_all(&sheet);
        saltus_line *head = saltus_page_scene(&page, file.head.title, file.system);
        saltus_line_plain(head, file.head.scene);
        saltus_line_add(head, ":  trajectory over %.6g %s",
                        file.record.time[file.record.samples - 1] - file.record.time[0],
                        saltus_system_forced(file.system) ? "{/:Italic T}" : "units of time");
        if (file.record.interrupted)
            saltus_line_add(head, "  (interrupted)");
        if (page.free_height) /* a narrow page is made higher for its caption when it begins */
            page.height =
                page.width * (narrow ? 1.5 : 0.5) + (narrow ? 0 : saltus_page_caption_height(&page));
        saltus_page_begin(&page);
        saltus_sheet_record_data(&sheet);
        fputs("set multiplot\n", page.file);
        saltus_page_caption(&page);
        put_faces(&sheet, &page);
        saltus_sheet_portrait(&sheet, saltus_page_cell(&page, 0, 1, columns, rows), 0);
        saltus_sheet_history(&sheet, saltus_page_cell(&page, 1, 1, columns, rows), 1);
        fputs("unset multiplot\n", page.file);
        status = saltus_page_close(&page, SALTUS_OK, message);
    }
    saltus_trajectory_file_clear(&file);
    return status;
}
