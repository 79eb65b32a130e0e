# SPDX-License-Identifier: MIT
# Makes builds faster without changing their result: ccache, a faster linker, precompiled headers.
# docs/log/build_times.md has the measurements.
option(QUADSPLAT_PCH "Precompile the headers that most files include. OFF checks that every file includes what it uses" OFF)

# A compiler cache works with precompiled headers only if it may ignore their macros and times.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${CCACHE_PROGRAM})
  set(CMAKE_CUDA_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
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
# Names of unnamed namespaces are therefore unique within a room. Kernels, files that Highway compiles once per instruction
# set, and files with a line "// Compiled alone: REASON" are compiled alone.
option(QUADSPLAT_UNITY "Compile the files of a room together: faster builds from nothing, slower ones after a change" OFF)
set(QUADSPLAT_UNITY_FILES 16 CACHE STRING "The most files that are compiled together")

# compile_together(TARGET SOURCES...) does this for these sources of a target.
function(compile_together target)
  if(NOT QUADSPLAT_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  foreach(source ${ARGN})
    file(STRINGS ${source} alone LIMIT_COUNT 1 REGEX "^(#define HWY_TARGET_INCLUDE|// Compiled alone: )")
    if(source MATCHES "\\.cu$" OR alone)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      continue()
    endif()
    get_filename_component(room ${source} DIRECTORY)
    file(RELATIVE_PATH room ${PROJECT_SOURCE_DIR} ${room})
    string(MAKE_C_IDENTIFIER ${room} room)
    math(EXPR count_${room} "0${count_${room}} + 1")
    math(EXPR part "(${count_${room}} - 1) / ${QUADSPLAT_UNITY_FILES}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room}_${part})
  endforeach()
endfunction()

set(QUADSPLAT_COMMON_HEADERS <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory>
  <optional> <span> <string> <string_view> <system_error> <utility> <vector> <fmt/format.h> <glm/vec2.hpp> <glm/vec3.hpp>
  <glm/mat3x3.hpp> <glm/geometric.hpp> <glm/common.hpp> <glm/gtc/quaternion.hpp>)

# precompile(TARGET [HEADERS...]) precompiles these headers. precompile(TARGET REUSE_FROM OTHER) reuses the headers of an
# earlier target that was compiled with the same options.
function(precompile target)
  if(NOT QUADSPLAT_PCH)
    return()
  endif()
  if(ARGV1 STREQUAL REUSE_FROM)
    target_precompile_headers(${target} REUSE_FROM ${ARGV2})
  else()
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()
