# Turns the templates of the figures into a C table.
#   cmake -DTEMPLATES=<folder of the .gp files> -DOUTPUT=<file.c> -P embed.cmake
# SPDX-License-Identifier: GPL-3.0-or-later

cmake_minimum_required(VERSION 3.20)

file(GLOB files ${TEMPLATES}/*.gp)
set(texts "")
set(table "")
foreach(file IN LISTS files)
  get_filename_component(name ${file} NAME_WE)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
  # Twenty characters to a line.
  string(REPEAT "." 140 line)
  string(REGEX REPLACE "(${line})" "\\1\n    " bytes "${bytes}")
  string(APPEND texts "static const char ${name}_text[] = {\n    ${bytes}'\\0'};\n")
  string(APPEND table "    {\"${name}\", ${name}_text},\n")
endforeach()
list(LENGTH files count)

file(WRITE ${OUTPUT}.new "/* Made by the build from the .gp files of src/figure. */
#include \"figure/page.h\"

${texts}
const saltus_template saltus_templates[] = {
${table}};
const int saltus_template_count = ${count};
")
file(RENAME ${OUTPUT}.new ${OUTPUT})
