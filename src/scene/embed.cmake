# Turns the built-in scenes into a C table.
#   cmake -DSCENES=<folder of the YAML files> -DOUTPUT=<file.c> -P embed.cmake
# The texts become arrays of characters, because ISO C promises string literals of 4095 bytes only and because nothing
# in them needs escaping then.
# SPDX-License-Identifier: GPL-3.0-or-later

cmake_minimum_required(VERSION 3.20)

# The order of listing.
set(names
    pipe
    fig2 fig3 fig4a fig4b fig5 fig6 fig7a fig7b fig7c fig7d fig8
    chatter
    impact-oscillator near-grazing budd-dux budd-chatter bouncing-ball vibrating-table impact-pair two-stops two-mass
    duffing gear-rattle impact-damper chain relief-valve flutter van-der-pol)

file(GLOB files RELATIVE ${SCENES} ${SCENES}/*.yaml)
foreach(file IN LISTS files)
  string(REGEX REPLACE "\\.yaml$" "" name ${file})
  if(NOT name IN_LIST names)
    message(FATAL_ERROR "${SCENES}/${file} is not in the list of built-in scenes in ${CMAKE_CURRENT_LIST_FILE}")
  endif()
endforeach()

set(texts "")
set(table "")
set(count 0)
foreach(name IN LISTS names)
  file(READ ${SCENES}/${name}.yaml bytes HEX)
  string(LENGTH "${bytes}" length)
  math(EXPR length "${length} / 2")
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
  # Twenty characters to a line.
  string(REPEAT "." 140 line)
  string(REGEX REPLACE "(${line})" "\\1\n    " bytes "${bytes}")
  string(APPEND texts "static const char text_${count}[] = {\n    ${bytes}'\\0'};\n")
  string(APPEND table "    {\"${name}\", text_${count}, ${length}},\n")
  math(EXPR count "${count} + 1")
endforeach()

file(WRITE ${OUTPUT}.new "/* Made by the build from data/scenes. */
#include \"scene/scene.h\"

${texts}
const saltus_builtin saltus_builtins[] = {
${table}};
const int saltus_builtin_count = ${count};
")
file(RENAME ${OUTPUT}.new ${OUTPUT})
