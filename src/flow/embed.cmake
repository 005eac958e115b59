# Joins the kernel for systems from text and all headers of this project that it includes into one C text, and writes that as an
# array of characters.
#   cmake -DSOURCES=<top folder> -DOUTPUT=<file.c> -P embed.cmake
# SPDX-License-Identifier: GPL-3.0-or-later

cmake_minimum_required(VERSION 3.20)

file(READ ${SOURCES}/src/flow/kernel.c text)
string(REPLACE "#include SALTUS_MODEL_KERNEL" "#include \"system/tape_kernel.h\"" text "${text}")
set(done "")
while(text MATCHES "#include \"([^\"]*)\"")
  set(name ${CMAKE_MATCH_1})
  set(header "")
  if(NOT name IN_LIST done)
    list(APPEND done ${name})
    foreach(folder src include)
      if(EXISTS ${SOURCES}/${folder}/${name})
        file(READ ${SOURCES}/${folder}/${name} header)
      endif()
    endforeach()
  endif()
  string(FIND "${text}" "${CMAKE_MATCH_0}" place)
  string(LENGTH "${CMAKE_MATCH_0}" length)
  string(SUBSTRING "${text}" 0 ${place} before)
  math(EXPR place "${place} + ${length}")
  string(SUBSTRING "${text}" ${place} -1 after)
  set(text "${before}${header}${after}")
endwhile()

file(WRITE ${OUTPUT}.text "${text}")
file(READ ${OUTPUT}.text bytes HEX)
file(REMOVE ${OUTPUT}.text)
string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
# Twenty characters to a line.
string(REPEAT "." 140 line)
string(REGEX REPLACE "(${line})" "\\1\n    " bytes "${bytes}")
file(WRITE ${OUTPUT}.new "/* Made by the build from src/flow/kernel.c and what it includes. */
#include \"flow/fixed.h\"

const char saltus_kernel_text[] = {
    ${bytes}'\\0'};
")
file(RENAME ${OUTPUT}.new ${OUTPUT})
