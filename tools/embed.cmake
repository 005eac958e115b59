# Turns a text file into a C array of characters.
#   cmake -DINPUT=<file> -DOUTPUT=<file.c> -P embed.cmake
# SPDX-License-Identifier: GPL-3.0-or-later

cmake_minimum_required(VERSION 3.20)

file(READ ${INPUT} bytes HEX)
string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
# Twenty characters to a line.
string(REPEAT "." 140 line)
string(REGEX REPLACE "(${line})" "\\1\n    " bytes "${bytes}")
file(WRITE ${OUTPUT}.new "/* Made by the build from data/paper/figures. */
#include \"paper.h\"

const char paper_figures[] = {
    ${bytes}'\\0'};
")
file(RENAME ${OUTPUT}.new ${OUTPUT})
