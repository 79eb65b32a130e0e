# SPDX-License-Identifier: MIT
# Code that scripts/test compiles once, though it is linked into two builds: `optimised`, and `checked`, which compiles
# with sanitizers only where bytes, memory and threads are. The objects of this code have no sanitizers in either build.
# libstdc++ annotates no containers unless it is asked to, so objects with and without sanitizers go together.
set(QUADSPLAT_PLAIN_FOLDER "" CACHE PATH "A build folder without sanitizers. Plain code, and objects of it, come from there")
add_custom_target(plain_objects)  # all that other builds may link

# quadsplat_plain(NAME SOURCES... [LINK LIBRARIES...] [OPTIONS...] [FOLDERS OF HEADERS...] [HEADERS TARGET] [HERE] [APART])
# adds the object library NAME. HEADERS names the target whose precompiled headers it uses. HERE: this build compiles it in any
# case. APART: each file is compiled alone.
function(quadsplat_plain name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "HERE;APART" "HEADERS" "SOURCES;LINK;OPTIONS;FOLDERS")
  set(objects ${QUADSPLAT_PLAIN_FOLDER}/objects/${name}.txt)
  if(QUADSPLAT_PLAIN_FOLDER AND NOT arg_HERE)
    if(NOT EXISTS ${objects})
      message(FATAL_ERROR "${objects} is missing: first run cmake --preset optimised "
                          "&& cmake --build --preset optimised --target plain_objects")
    endif()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${objects})
    file(STRINGS ${objects} objects)
    add_library(${name} OBJECT IMPORTED GLOBAL)
    set_target_properties(${name} PROPERTIES IMPORTED_OBJECTS "${objects}")
    return()
  endif()
  set(sources "")
  foreach(source ${arg_SOURCES})
    get_filename_component(source ${source} ABSOLUTE)
    list(APPEND sources ${source})
  endforeach()
  set(units ${sources})
  if(NOT arg_APART)
    compile_together(units ${name} ${sources})
  endif()
  add_library(${name} OBJECT ${units})
  target_include_directories(${name} PRIVATE ${arg_FOLDERS} ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(${name} PRIVATE ${arg_LINK} quadsplat_flags)
  target_compile_options(${name} PRIVATE ${arg_OPTIONS})
  if(QUADSPLAT_PLAIN_FOLDER)
    target_compile_options(${name} PRIVATE -fno-sanitize=all)
  endif()
  add_dependencies(${name} check_includes)
  if(arg_HEADERS)
    precompile(${name} REUSE_FROM ${arg_HEADERS})
  endif()
  if(NOT arg_HERE)
    add_dependencies(plain_objects ${name})
    file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/objects/${name}.txt CONTENT "$<JOIN:$<TARGET_OBJECTS:${name}>,\n>\n")
  endif()
endfunction()
