/* Records as files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/record.h"

#include "io/output.h"

saltus_status saltus_record_write(const saltus_record *record, const saltus_scene *scene,
                                  const saltus_system *system, const saltus_flow_options *options,
                                  const char *path, saltus_message *message) {
    bool csv = saltus_path_ends(path, ".csv"), hdf5 = saltus_path_ends(path, ".h5");
    if (!csv && !hdf5)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .csv or .h5", path);
    const saltus_source source = {record, scene, system, options};
    saltus_output output;
    saltus_status status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    if (csv)
        saltus_record_csv(&source, output.file);
    else
        status = saltus_record_hdf5(&source, output.file, message);
    return saltus_output_close(&output, status, message);
}
