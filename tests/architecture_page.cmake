# SPDX-License-Identifier: MIT
# Checks statements of docs/architecture.md and docs/inside about the source, besides the includes, which cmake/check_includes.cmake checks.
# Run as: cmake -DROOT=<source tree> -P architecture_page.cmake. Fails with one line per broken statement.
cmake_minimum_required(VERSION 3.25)
set(broken "")

# statement(TEXT FOLDERS... PATTERN REGEX [EXCEPT FILES...]): no line of the folders matches the expression, except in these files.
function(statement text)
  cmake_parse_arguments(PARSE_ARGV 1 rule "" "PATTERN" "FOLDERS;EXCEPT")
  foreach(folder ${rule_FOLDERS})
    file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/src/${folder}/*.h ${ROOT}/src/${folder}/*.cpp ${ROOT}/src/${folder}/*.cu
      ${ROOT}/src/${folder}/*.cuh)
    foreach(file ${sources})
      file(STRINGS ${ROOT}/${file} lines REGEX "${rule_PATTERN}")
      list(FILTER lines EXCLUDE REGEX "^ *//")
      if(lines AND NOT file IN_LIST rule_EXCEPT)
        list(APPEND broken "${file}: ${text}")
      endif()
    endforeach()
  endforeach()
  foreach(file ${rule_EXCEPT})
    file(STRINGS ${ROOT}/${file} lines REGEX "${rule_PATTERN}")
    if(NOT lines)
      list(APPEND broken "${file} is no exception any more: ${text}")
    endif()
  endforeach()
  set(broken "${broken}" PARENT_SCOPE)
endfunction()

statement("Renderer and TrainingModel are the only classes with virtual functions in raster and learn" FOLDERS raster learn
  PATTERN "(^|[^a-z_])virtual " EXCEPT src/raster/api/renderer.h src/learn/step/training_model.h)
statement("raster, io and learn create no thread pool, except pools of one thread, which start none" FOLDERS raster io learn
  PATTERN "(^|[^&*:<a-z_] ?)ThreadPool [a-z_]+([({]([^1]|1[^)}])|;)|make_unique<ThreadPool>")
statement("the viewer's state uses of io/bytes only the rule for names of existing files and the text of JSON" FOLDERS app/viewer/state
  PATTERN "#include \"io/bytes/" EXCEPT src/app/viewer/state/hud_text.cpp src/app/viewer/state/keyframe_actions.cpp)
statement("the network library is included by app/serve alone" FOLDERS base options raster io learn library app/cli app/viewer app/remote
  PATTERN "#include <boost/")

if(broken)
  string(REPLACE ";" "\n  " broken "${broken}")
  message(FATAL_ERROR "docs/architecture.md is not true any more:\n  ${broken}")
endif()
