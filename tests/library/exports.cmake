# SPDX-License-Identifier: MIT
# The library exports the functions of quadsplat.h, all of them, and nothing else. Run as:
# cmake -DLIBRARY=... -DHEADER=... -DNM=... -P exports.cmake
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND ${NM} -D --defined-only ${LIBRARY} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "\n$" "" symbols "${symbols}")
string(REPLACE "\n" ";" symbols "${symbols}")
list(TRANSFORM symbols REPLACE "^.* " "")
file(STRINGS ${HEADER} functions REGEX "^QS_LIBRARY_FUNCTION ")
list(TRANSFORM functions REPLACE "^QS_LIBRARY_FUNCTION [a-z0-9_]+ (qs_[a-z0-9_]+)\\(.*" "\\1")
list(SORT functions)
list(SORT symbols)
if(NOT symbols STREQUAL functions)
  message(FATAL_ERROR "the library exports\n${symbols}\nand the header declares\n${functions}")
endif()
list(LENGTH functions count)
message("${count} functions, as declared")
