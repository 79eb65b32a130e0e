# SPDX-License-Identifier: MIT
# Adds the scene format that docs/extending.md shows to a copy of src, as that page says: the page's two files, an include
# and a row in reader.cpp and in writer.cpp, and the rows of the new room in a copy of check_includes.cmake, which then
# checks the copy. FOLDER receives the format's folder, reader.cpp and writer.cpp.
# Run as: cmake -DSOURCE=<source tree> -DFOLDER=<folder> -P add_format.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/../extending_page.cmake)
set(scene io/scene)
file(REMOVE_RECURSE ${FOLDER})
open_section("A scene format")

next_block(cpp)
file(WRITE ${FOLDER}/${scene}/dots/dots.h "${block}")
next_block(cpp)
file(WRITE ${FOLDER}/${scene}/dots/dots.cpp "${block}")

foreach(file reader.cpp writer.cpp)
  next_block(cpp)
  file(READ ${SOURCE}/src/${scene}/${file} text)
  edit(${scene}/${file} "(#include \"base/fail\\.h\"\n)" "#include \"${scene}/dots/dots.h\"\n\\1")
  edit(${scene}/${file} "},\n}" "},\n${block}}")  # the end of the table
  file(WRITE ${FOLDER}/${scene}/${file} "${text}")
endforeach()

next_block(cmake)
file(READ ${SOURCE}/cmake/check_includes.cmake text)
edit(check_includes.cmake "\n(room\\(${scene} [^)]*)\\)\n" "\n\\1 ${scene}/dots)\n${block}")
file(WRITE ${FOLDER}/check_includes.cmake "${text}")
file(COPY ${SOURCE}/src DESTINATION ${FOLDER}/checked)
file(COPY ${SOURCE}/docs/architecture.md DESTINATION ${FOLDER}/checked/docs)
file(COPY ${FOLDER}/io DESTINATION ${FOLDER}/checked/src)
execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${FOLDER}/checked -P ${FOLDER}/check_includes.cmake COMMAND_ERROR_IS_FATAL ANY)
file(REMOVE_RECURSE ${FOLDER}/checked)
