# SPDX-License-Identifier: MIT
# Writes the samples of docs/extending.md that are whole functions into a header each, so that extending_test.cpp
# compiles them: the first block of C++ of a section, up to a line that begins with "// in".
# Run as: cmake -DPAGE=<docs/extending.md> -DFOLDER=<folder> -P extending_samples.cmake
cmake_minimum_required(VERSION 3.25)
file(READ ${PAGE} page)
foreach(sample "A command/command" "A training strategy/strategy" "A viewer action/action" "A panel/panel")
  string(REPLACE "/" ";" sample "${sample}")
  list(GET sample 0 title)
  list(GET sample 1 name)
  if(NOT page MATCHES "\n## ${title}\n")
    message(FATAL_ERROR "docs/extending.md has no section ${title}")
  endif()
  string(REGEX REPLACE ".*\n## ${title}\n" "" section "${page}")
  if(NOT section MATCHES "   ```cpp\n([^`]*)   ```\n")
    message(FATAL_ERROR "docs/extending.md: no C++ in the section ${title}")
  endif()
  string(REGEX REPLACE "\n *// in .*" "\n" code "${CMAKE_MATCH_1}")
  file(CONFIGURE OUTPUT ${FOLDER}/extending_${name}.h CONTENT "#pragma once\n${code}" @ONLY)
endforeach()
