# SPDX-License-Identifier: MIT
# The dependency rule of docs/architecture.md: for each folder, which folders its files may include.
# Run as: cmake -DROOT=<source tree> -P check_includes.cmake. Fails with one line per broken rule.
set(rules
  "src/raster/kernel|raster/kernel/"
  "src/raster/scene|raster/scene/,raster/kernel/"
  "src/raster/cpu|raster/renderer.h,raster/scene/,raster/kernel/,raster/cpu/"
  "src/raster/cuda|raster/renderer.h,raster/scene/,raster/kernel/,raster/cuda/"
  "src/io|raster/scene/,raster/kernel/,io/"
  "src/app|raster/renderer.h,raster/scene/,raster/kernel/,io/,app/,version.h")
set(broken "")
foreach(rule ${rules})
  string(REGEX REPLACE "[|,]" ";" parts "${rule}")
  list(POP_FRONT parts folder)
  set(allowed ${parts})
  file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/${folder}/*.h ${ROOT}/${folder}/*.cpp
       ${ROOT}/${folder}/*.cu ${ROOT}/${folder}/*.cuh)
  foreach(file ${files})
    file(STRINGS ${ROOT}/${file} lines REGEX "^[ \t]*#[ \t]*include[ \t]*\"")
    foreach(line ${lines})
      string(REGEX REPLACE ".*\"([^\"]+)\".*" "\\1" header "${line}")
      set(ok FALSE)
      foreach(prefix ${allowed})
        string(FIND "${header}" "${prefix}" at)
        if(at EQUAL 0)
          set(ok TRUE)
        endif()
      endforeach()
      if(NOT ok)
        list(APPEND broken "${file} includes \"${header}\": ${folder} may include only ${allowed}")
      endif()
    endforeach()
  endforeach()
  # .cu and .cuh exist only under raster/cuda.
  if(NOT folder STREQUAL "src/raster/cuda")
    file(GLOB_RECURSE device_files RELATIVE ${ROOT} ${ROOT}/${folder}/*.cu ${ROOT}/${folder}/*.cuh)
    foreach(file ${device_files})
      list(APPEND broken "${file}: device code belongs into src/raster/cuda")
    endforeach()
  endif()
endforeach()
if(broken)
  string(REPLACE ";" "\n  " broken "${broken}")
  message(FATAL_ERROR "the dependency rule is broken:\n  ${broken}")
endif()
