# SPDX-License-Identifier: MIT
# Adds the culling mode that docs/extending.md shows to copies of the tables, as that page says: the page's header, its
# row behind the row of `exact`, an include and an entry. FOLDER receives the three headers.
# Run as: cmake -DSOURCE=<source tree> -DFOLDER=<folder> -P add_mode.cmake
cmake_minimum_required(VERSION 3.25)
set(cull raster/kernel/cull)
file(REMOVE_RECURSE ${FOLDER})

file(READ ${SOURCE}/docs/extending.md page)
string(REGEX REPLACE ".*\n## A culling mode\n" "" page "${page}")
string(REGEX REPLACE "\n## .*" "" page "${page}")
# The page's next block of code, without its indentation, in `block`.
macro(next_block)
  if(NOT page MATCHES "   ```cpp\n([^`]*)   ```\n")
    message(FATAL_ERROR "docs/extending.md shows no code of the new mode")
  endif()
  set(block "\n${CMAKE_MATCH_1}")
  string(REPLACE "${CMAKE_MATCH_0}" "" page "${page}")
  string(REPLACE "\n   " "\n" block "${block}")
  string(REGEX REPLACE "^\n" "" block "${block}")
endmacro()

# Replaces a pattern that the file has once.
function(edit file pattern replacement)
  string(REGEX MATCHALL "${pattern}" found "${text}")
  list(LENGTH found count)
  if(NOT count EQUAL 1)
    message(FATAL_ERROR "src/${cull}/${file} has ${count} places like ${pattern}")
  endif()
  string(REGEX REPLACE "${pattern}" "${replacement}" text "${text}")
  set(text "${text}" PARENT_SCOPE)
endfunction()

next_block()
file(WRITE ${FOLDER}/${cull}/opacity_square.h "${block}")

next_block()
file(READ ${SOURCE}/src/${cull}/table.h text)
edit(table.h "({\\.name = \"exact\"[^}]*},\n)" "\\1${block}")
file(WRITE ${FOLDER}/${cull}/table.h "${text}")

file(READ ${SOURCE}/src/${cull}/modes.h text)
edit(modes.h "(#include \"${cull}/table.h\"\n)" "\\1#include \"${cull}/opacity_square.h\"\n")
edit(modes.h " Exact," " Exact, OpacitySquare,")
file(WRITE ${FOLDER}/${cull}/modes.h "${text}")
