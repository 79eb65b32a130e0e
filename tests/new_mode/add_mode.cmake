# SPDX-License-Identifier: MIT
# Adds the culling mode that docs/extending.md shows to copies of the tables, as that page says: the page's header, its
# row behind the row of `exact`, an include and an entry, and its key in viewer.md. FOLDER receives the three headers and
# the page.
# Run as: cmake -DSOURCE=<source tree> -DFOLDER=<folder> -P add_mode.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/../extending_page.cmake)
set(cull raster/kernel/cull)
file(REMOVE_RECURSE ${FOLDER})
open_section("A culling mode")

next_block(cpp)
file(WRITE ${FOLDER}/${cull}/opacity_square.h "${block}")

next_block(cpp)
file(READ ${SOURCE}/src/${cull}/table.h text)
edit(${cull}/table.h "({\\.name = \"exact\"[^}]*},\n)" "\\1${block}")
file(WRITE ${FOLDER}/${cull}/table.h "${text}")

file(READ ${SOURCE}/src/${cull}/modes.h text)
edit(${cull}/modes.h "(#include \"${cull}/table.h\"\n)" "\\1#include \"${cull}/opacity_square.h\"\n")
edit(${cull}/modes.h " Exact," " Exact, OpacitySquare,")
file(WRITE ${FOLDER}/${cull}/modes.h "${text}")

if(NOT page MATCHES "Add the row `` ([^\n]*) `` to the keys in `docs/viewer.md`")
  message(FATAL_ERROR "docs/extending.md shows no row for the keys of viewer.md")
endif()
set(row "${CMAKE_MATCH_1}")
file(READ ${SOURCE}/docs/viewer.md text)
edit(docs/viewer.md "(\n\\| `6` \\| exact \\|\n)" "\\1${row}\n")
file(WRITE ${FOLDER}/viewer.md "${text}")
