# SPDX-License-Identifier: MIT
# The dependency rule of docs/architecture.md. A room is a folder without its subfolders. Each row names a room and the
# rooms whose headers it includes, so the rows are the edges of the program's structure: an include that no row names
# is an error, and so is a room of a row that nothing includes. Rooms are listed from the top floor to the ground
# floor, and a row names only rooms below it, so there is no circle.
# To add a room, write its row. To add an edge, add the room to the row; check first if the code belongs into another
# room.
# Run as: cmake -DROOT=<source tree> -P check_includes.cmake. Fails with one line per broken rule.
cmake_minimum_required(VERSION 3.25)

set(rooms "")
function(room name)
  list(APPEND rooms ${name})
  set(rooms "${rooms}" PARENT_SCOPE)
  set(below_${name} ${ARGN} PARENT_SCOPE)
  set(unused_${name} ${ARGN} PARENT_SCOPE)
endfunction()

# ---- rooms: a room, then the rooms that it includes, top floor first
room(app app/cli base)
room(app/cli app/conformance app/plugin app/serve app/viewer app/viewer/render app/report app/remote app/film
     app/measure app/session app/framing app/inspect app/picture learn/lpips learn/run learn/step io/camera io/scene
     io/cloud io/picture io/bytes raster/api raster/scene options base)
room(app/conformance app/report app/picture io/camera io/scene io/picture io/bytes raster/api raster/scene
     raster/kernel base)
room(app/plugin quadsplat raster/api raster/scene base)
room(app/serve app/viewer/commands app/viewer/render app/viewer/state app/remote app/session app/inspect app/picture
     io/camera io/picture io/bytes raster/scene base)
room(app/viewer app/viewer/window app/viewer/panels app/viewer/render app/viewer/state app/remote app/session
     io/camera io/picture io/bytes raster/api base)
room(app/viewer/window app/viewer/panels app/viewer/commands app/viewer/render app/viewer/state app/picture
     io/picture io/bytes raster/scene base)
room(app/viewer/panels app/viewer/commands app/viewer/state app/framing app/inspect app/picture learn/run io/scene
     base)
room(app/viewer/commands app/viewer/render app/viewer/state app/report app/film app/measure app/session app/inspect
     app/picture io/camera io/scene io/picture io/bytes raster/scene base)
room(app/viewer/render app/viewer/state app/measure app/session app/framing app/inspect app/picture io/camera
     io/scene io/bytes raster/api raster/scene raster/kernel base)
room(app/viewer/state app/report app/remote app/measure app/session app/framing app/inspect app/picture learn/run
     io/camera io/cloud io/bytes raster/api raster/scene base)
room(app/report app/measure app/session app/framing app/inspect app/picture learn/run io/camera io/scene io/picture
     io/bytes raster/clock raster/api raster/kernel/cull raster/scene base)
room(app/remote raster/scene base)
room(app/film app/measure app/framing app/inspect app/picture io/picture io/bytes raster/api raster/scene base)
room(app/measure app/session app/framing io/camera io/scene io/bytes raster/clock raster/api raster/scene base)
room(app/session app/framing io/camera io/scene io/scene/compact io/cloud io/picture raster/field raster/api
     raster/scene base)
room(app/framing io/scene raster/api raster/scene raster/kernel base)
room(app/inspect app/picture raster/api raster/kernel/cull raster/scene raster/kernel base)
room(app/picture io/picture io/bytes raster/api raster/kernel/cull raster/scene raster/kernel base)
room(library learn/diff/cuda learn/step/cpu learn/diff/cpu learn/diff learn/lpips learn/run learn/step
     learn/gradient io/camera io/scene io/cloud io/picture io/bytes quadsplat raster/api raster/scene raster/kernel
     options base)
room(learn learn/lpips/cuda learn/step/cuda learn/step/cpu learn/lpips learn/step base)
room(learn/lpips/cuda learn/lpips raster/cuda/common)
room(learn/step/cuda learn/diff/cuda learn/step learn/gradient raster/cuda/fast raster/cuda/common raster/field
     raster/api raster/kernel/cull raster/scene raster/kernel base)
room(learn/diff/cuda learn/diff learn/gradient raster/cuda/fast raster/cuda/common raster/kernel/cull raster/scene
     raster/kernel base)
room(learn/step/cpu learn/diff/cpu learn/step learn/field learn/gradient raster/scene raster/kernel base)
room(learn/diff/cpu learn/diff learn/gradient raster/cpu/common raster/kernel/cull raster/scene raster/kernel base)
room(learn/diff learn/gradient raster/kernel/cull raster/scene raster/kernel base)
room(learn/lpips io/tensor raster/api raster/scene base)
room(learn/run learn/step learn/field learn/gradient io/camera io/scene io/scene/compact io/picture io/bytes
     raster/field raster/api raster/kernel/cull raster/scene raster/kernel options base)
room(learn/step learn/field learn/gradient raster/field raster/api raster/scene raster/kernel base)
room(learn/field learn/gradient raster/field raster/kernel base)
room(learn/gradient raster/kernel)
room(io/camera io/picture io/bytes raster/scene base)
room(io/scene io/scene/sog io/scene/compact io/scene/splat io/scene/gltf io/scene/spz io/scene/ply io/cloud io/bytes
     raster/scene base)
room(io/scene/sog io/cloud io/picture io/bytes raster/scene base)
room(io/scene/compact io/scene/ply io/cloud io/tensor io/bytes raster/field raster/scene raster/kernel base)
room(io/scene/splat io/cloud io/bytes raster/scene raster/kernel base)
room(io/scene/gltf io/scene/spz io/scene/ply io/cloud io/bytes raster/scene raster/kernel base)
room(io/scene/spz io/scene/ply io/cloud io/bytes raster/scene base)
room(io/scene/ply io/cloud io/bytes raster/scene raster/kernel base)
room(io/cloud raster/field raster/scene base)
room(io/picture io/tensor io/bytes io/picture/oiio raster/scene base)
room(io/tensor io/bytes raster/kernel base)
room(io/bytes raster/scene base)
room(io/picture/oiio raster/scene)
room(raster raster/cuda raster/cpu raster/cuda/common raster/clock raster/api base)
room(raster/cuda raster/cuda/classic raster/cuda/fast raster/cuda/common raster/api)
room(raster/cuda/classic raster/cuda/common raster/kernel/cull raster/kernel)
room(raster/cpu raster/cpu/fast raster/cpu/classic raster/cpu/common raster/api base)
room(raster/cpu/fast raster/cpu/common raster/kernel/cull raster/scene raster/kernel base)
room(raster/cpu/classic raster/cpu/common raster/kernel/cull raster/scene raster/kernel)
room(raster/cuda/fast raster/cuda/common raster/kernel/cull raster/kernel)
room(raster/cuda/common raster/api raster/kernel/cull raster/scene raster/kernel base)
room(raster/cpu/common raster/api raster/kernel/cull raster/scene raster/kernel base)
room(quadsplat)
room(raster/field raster/kernel base)
room(raster/clock)
room(raster/api raster/kernel/cull raster/scene raster/kernel base)
room(raster/kernel/cull raster/kernel)
room(raster/scene raster/kernel base)
room(raster/kernel)
room(options base)
room(base)
# ---- end of rooms

set(broken "")
foreach(room ${rooms})
  list(FIND rooms ${room} floor)
  foreach(lower ${below_${room}})
    list(FIND rooms ${lower} lower_floor)
    if(NOT lower_floor GREATER floor)
      list(APPEND broken "the row of ${room} names ${lower}, which is not below it")
    endif()
  endforeach()
endforeach()

file(GLOB_RECURSE sources RELATIVE ${ROOT}/src ${ROOT}/src/*.h ${ROOT}/src/*.cpp ${ROOT}/src/*.cu ${ROOT}/src/*.cuh)
foreach(file ${sources})
  get_filename_component(room ${file} DIRECTORY)
  if(NOT room IN_LIST rooms)
    list(APPEND broken "src/${file} is in no room: add a row to cmake/check_includes.cmake")
    continue()
  endif()
  if(file MATCHES "\\.cuh?$" AND NOT file MATCHES "^(raster|learn/[a-z]+)/cuda/")
    list(APPEND broken "src/${file}: device code belongs in a folder named cuda")
  endif()
  file(STRINGS ${ROOT}/src/${file} lines REGEX "^[ \t]*#[ \t]*include[ \t]*\"")
  foreach(line ${lines})
    string(REGEX REPLACE ".*\"([^\"]+)\".*" "\\1" header "${line}")
    get_filename_component(target ${header} DIRECTORY)
    if(header STREQUAL "version.h" OR target STREQUAL room)  # version.h is generated
      continue()
    endif()
    list(REMOVE_ITEM unused_${room} "${target}")
    if(NOT target IN_LIST below_${room})
      list(APPEND broken "src/${file} includes \"${header}\": the row of ${room} does not name '${target}'")
    endif()
  endforeach()
endforeach()
foreach(room ${rooms})
  foreach(lower ${unused_${room}})
    list(APPEND broken "the row of ${room} names ${lower}, from which it includes nothing")
  endforeach()
endforeach()
if(broken)
  string(REPLACE ";" "\n  " broken "${broken}")
  message(FATAL_ERROR "the dependency rule is broken:\n  ${broken}")
endif()
