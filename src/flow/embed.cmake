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
set(FILES ${OUTPUT}.text)
set(HEADER flow/fixed.h)
set(NAME saltus_kernel_text)
include(${SOURCES}/tools/embed.cmake)
