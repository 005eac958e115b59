# Turns text files into C arrays of characters: one file into a text, or several into a table of names and texts.
#   cmake -DFILES=<list> -DHEADER=<to include> -DNAME=<of the text, or saltus_builtin for saltus_builtins[] and
#         saltus_builtin_count> [-DTYPE=<of a table's entries>] -DOUTPUT=<file.c> -P embed.cmake
# Arrays, because ISO C promises string literals of 4095 bytes only and because nothing in them needs escaping then.
# SPDX-License-Identifier: GPL-3.0-or-later

cmake_minimum_required(VERSION 3.20)

set(texts "")
set(table "")
set(count 0)
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME_WE)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
  # Twenty characters to a line.
  string(REPEAT "." 140 line)
  string(REGEX REPLACE "(${line})" "\\1\n    " bytes "${bytes}")
  string(APPEND texts "static const char text_${count}[] = {\n    ${bytes}'\\0'};\n")
  string(APPEND table "    {\"${name}\", text_${count}},\n")
  math(EXPR count "${count} + 1")
endforeach()
if(TYPE)
  string(APPEND texts "\nconst ${TYPE} ${NAME}s[] = {\n${table}};\nconst int ${NAME}_count = ${count};\n")
else()
  string(REPLACE "static const char text_0" "const char ${NAME}" texts "${texts}")
endif()
file(WRITE ${OUTPUT}.new "/* Made by the build. */\n#include \"${HEADER}\"\n\n${texts}")
file(RENAME ${OUTPUT}.new ${OUTPUT})
