# SPDX-License-Identifier: MIT
# Makes builds faster without changing their result: ccache, a faster linker, precompiled headers.
# docs/log/build_times.md has the measurements.
option(QUADSPLAT_PCH "Precompile the headers that most files include. OFF checks that every file includes what it uses" OFF)

# A compiler cache works with precompiled headers only if it may ignore their macros and times. With paths relative to the
# source tree, objects of one clone serve every other clone.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(cache ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${CCACHE_PROGRAM})
  set(CMAKE_C_COMPILER_LAUNCHER ${cache})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${cache})
  set(CMAKE_CUDA_COMPILER_LAUNCHER ${cache})
  if(QUADSPLAT_PCH)
    add_compile_options("$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>"
                        "$<$<COMPILE_LANG_AND_ID:CXX,Clang>:SHELL:-Xclang -fno-pch-timestamp>")
  endif()
endif()

# The test programs hold much debug information: mold and lld link them several times faster than GNU ld.
if(NOT QUADSPLAT_STATIC)
  foreach(linker mold lld)
    find_program(QUADSPLAT_${linker} NAMES ld.${linker})
    if(QUADSPLAT_${linker})
      add_link_options(-fuse-ld=${linker})
      break()
    endif()
  endforeach()
endif()

# The files of a room are compiled together, at most this many of its .cpp at a time, so that headers are read once.
# Names of unnamed namespaces are therefore unique within a room (scripts/check_rooms). Kernels, generated files, files that Highway compiles once per
# instruction set, and files with a line "// Compiled alone: REASON" are compiled alone.
option(QUADSPLAT_UNITY "Compile the files of a room together: faster builds from nothing, slower ones after a change" OFF)
option(QUADSPLAT_UNITY_KERNELS "CUDA sources too: without optimisation a third of the time" OFF)
set(QUADSPLAT_UNITY_FILES 16 CACHE STRING "The most files that are compiled together")
if(QUADSPLAT_UNITY)
  include_directories(${PROJECT_SOURCE_DIR})  # of the includes in units
endif()

# compile_together(UNITS NAME SOURCES...) sets UNITS to the files that the target NAME compiles: files that include all sources of a
# room, and the sources that are compiled alone. CMake's own units name the folder of the clone, which keeps compiler
# caches from serving other clones.
function(compile_together units name)
  if(NOT QUADSPLAT_UNITY)
    set(${units} ${ARGN} PARENT_SCOPE)
    return()
  endif()
  set(result "")
  set(rooms "")
  foreach(source ${ARGN})
    set(alone "generated")
    if(EXISTS ${source})
      file(STRINGS ${source} alone LIMIT_COUNT 1 REGEX "^(#define HWY_TARGET_INCLUDE|// Compiled alone: )")
    endif()
    get_filename_component(ending ${source} LAST_EXT)
    if((ending STREQUAL .cu AND NOT QUADSPLAT_UNITY_KERNELS) OR alone)
      list(APPEND result ${source})
      continue()
    endif()
    file(RELATIVE_PATH source ${PROJECT_SOURCE_DIR} ${source})
    get_filename_component(room ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER ${room} room)
    list(APPEND rooms ${room})
    list(APPEND members_${room} ${source})
    set(ending_${room} ${ending})
  endforeach()
  list(REMOVE_DUPLICATES rooms)
  foreach(room ${rooms})
    list(LENGTH members_${room} count)
    math(EXPR parts "(${count} + ${QUADSPLAT_UNITY_FILES} - 1) / ${QUADSPLAT_UNITY_FILES}")
    foreach(part RANGE 1 ${parts})
      math(EXPR begin "${count} * (${part} - 1) / ${parts}")
      math(EXPR size "${count} * ${part} / ${parts} - ${begin}")
      list(SUBLIST members_${room} ${begin} ${size} members)
      list(TRANSFORM members REPLACE "(.+)" "#include \"\\1\"\n" OUTPUT_VARIABLE includes)
      string(JOIN "" includes ${includes})
      set(unit ${PROJECT_BINARY_DIR}/units/${name}/${room}_${part}${ending_${room}})
      file(CONFIGURE OUTPUT ${unit} CONTENT "${includes}" @ONLY)
      list(APPEND result ${unit})
    endforeach()
    list(APPEND together ${members_${room}})
  endforeach()
  set(${units} ${result} PARENT_SCOPE)
  get_property(is_checked DIRECTORY PROPERTY compiled_together SET)
  if(NOT is_checked)
    cmake_language(DEFER CALL check_compiled_together)
  endif()
  set_property(DIRECTORY APPEND PROPERTY compiled_together ${together})
endfunction()

# A part of a unit cannot have options or macros of its own: CMake would ignore them.
function(check_compiled_together)
  get_property(sources DIRECTORY PROPERTY compiled_together)
  foreach(source ${sources})
    foreach(property COMPILE_OPTIONS COMPILE_DEFINITIONS COMPILE_FLAGS INCLUDE_DIRECTORIES)
      get_source_file_property(own ${PROJECT_SOURCE_DIR}/${source} ${property})
      if(own)
        message(FATAL_ERROR "${source} has ${property} of its own: it needs a line \"// Compiled alone: REASON\"")
      endif()
    endforeach()
  endforeach()
endfunction()

set(QUADSPLAT_COMMON_HEADERS <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory>
  <optional> <span> <string> <string_view> <system_error> <utility> <vector> <fmt/format.h> <glm/vec2.hpp> <glm/vec3.hpp>
  <glm/mat3x3.hpp> <glm/geometric.hpp> <glm/common.hpp> <glm/gtc/quaternion.hpp>)

# precompile(TARGET [HEADERS...]) precompiles these headers. precompile(TARGET REUSE_FROM OTHER) reuses the headers of an
# earlier target that was compiled with the same options.
function(precompile target)
  get_target_property(is_imported ${target} IMPORTED)
  if(NOT QUADSPLAT_PCH OR is_imported)
    return()
  endif()
  if(ARGV1 STREQUAL REUSE_FROM)
    target_precompile_headers(${target} REUSE_FROM ${ARGV2})
  else()
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()
