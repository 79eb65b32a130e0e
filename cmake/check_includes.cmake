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
room(app app/cli raster/base)
room(app/cli app/options app/serve app/viewer app/viewer/render app/remote app/train app/conformance app/film app/plugin app/report app/measure
     app/inspect app/session app/framing app/picture app/base io/scene io/cloud io/camera io/picture io/tensor io/bytes
     raster/api raster/scene raster/base)
room(app/serve app/viewer/panel_model app/viewer/commands app/viewer/render app/viewer/state app/remote app/session app/picture app/base
     io/camera io/picture io/bytes raster/scene raster/base)
room(app/viewer app/viewer/window app/viewer/panels app/viewer/render app/viewer/state app/remote app/session app/base
     io/camera io/picture io/bytes raster/api raster/base)
room(app/viewer/window app/viewer/panels app/viewer/commands app/viewer/render app/viewer/state app/picture app/base
     io/picture io/bytes raster/scene raster/base)
room(app/viewer/panels app/viewer/panel_model app/viewer/commands app/viewer/state app/train app/framing app/picture app/base io/scene
     raster/base)
room(app/viewer/panel_model app/viewer/commands app/viewer/state app/inspect app/picture)
room(app/viewer/commands app/viewer/render app/viewer/state app/film app/report app/measure app/inspect app/session
     app/picture app/base io/scene io/camera io/picture io/bytes raster/scene raster/base)
room(app/viewer/render app/viewer/state app/measure app/inspect app/session app/framing app/picture io/scene io/camera
     io/bytes raster/api raster/scene raster/kernel raster/base)
room(app/viewer/state app/remote app/train app/report app/measure app/inspect app/session app/framing app/picture app/base io/cloud
     io/camera io/bytes raster/api raster/base)
room(app/remote raster/scene raster/base)
room(app/conformance app/report app/picture app/base io/scene io/camera io/picture io/bytes raster/api raster/scene
     raster/kernel raster/base)
room(app/film app/measure app/inspect app/framing app/picture app/base io/picture io/bytes raster/api raster/scene raster/base)
room(app/plugin app/base io/bytes quadsplat raster/api raster/scene raster/base)
room(app/report app/train app/measure app/inspect app/session app/framing app/picture app/base io/scene io/camera io/picture
     io/bytes raster/api raster/clock raster/scene raster/kernel/cull raster/base)
room(app/measure app/session app/framing app/base io/scene io/camera io/bytes raster/api
     raster/clock raster/scene raster/base)
room(app/inspect app/picture app/base raster/api raster/scene raster/kernel/cull raster/kernel raster/base)
room(app/session app/framing app/base io/scene io/scene/compact io/cloud io/camera io/picture raster/api raster/field raster/scene
     raster/base)
room(app/framing app/base io/scene io/cloud raster/api raster/scene raster/kernel raster/base)
room(app/picture app/base io/picture io/bytes raster/api raster/scene raster/kernel/cull raster/kernel raster/base)
room(library app/train app/options io/scene io/cloud io/camera io/picture io/tensor io/bytes quadsplat raster/cpu/train raster/cpu/stages
     raster/cuda/stages raster/api raster/train raster/stages raster/scene raster/kernel raster/base)
room(app/train app/options app/base io/scene io/scene/compact io/camera io/picture io/bytes raster/api raster/train
     raster/field raster/scene raster/kernel/gradient raster/kernel/cull raster/kernel raster/base)
room(app/options app/base raster/api raster/scene raster/kernel/cull raster/base)
room(app/base io/bytes raster/base)
room(io/scene io/scene/gltf io/scene/compact io/scene/spz io/scene/ply io/scene/sog io/scene/splat io/cloud io/bytes
     raster/scene raster/base)
room(io/scene/gltf io/scene/spz io/scene/ply io/cloud io/bytes raster/scene raster/kernel raster/base)
room(io/scene/compact io/scene/ply io/cloud io/tensor io/bytes raster/scene raster/field raster/kernel raster/base)
room(io/scene/spz io/scene/ply io/cloud io/bytes raster/scene raster/base)
room(io/scene/ply io/cloud io/bytes raster/scene raster/kernel raster/base)
room(io/scene/sog io/cloud io/picture io/bytes raster/scene raster/base)
room(io/scene/splat io/cloud io/bytes raster/scene raster/kernel raster/base)
room(io/cloud raster/scene raster/field raster/kernel raster/base)
room(io/camera io/picture io/bytes raster/scene raster/base)
room(io/picture io/picture/oiio io/tensor io/bytes raster/scene raster/base)
room(io/picture/oiio raster/scene)
room(io/tensor io/bytes raster/lpips raster/kernel raster/base)
room(io/bytes raster/scene raster/base)
room(quadsplat)
room(raster/make raster/cpu/train raster/cpu/fast raster/cpu/classic raster/cpu raster/cuda/train raster/cuda/lpips
     raster/cuda/fast raster/cuda/classic raster/cuda raster/api raster/clock raster/base)
room(raster/cpu/train raster/cpu/stages raster/api raster/train raster/field raster/scene raster/kernel/gradient
     raster/kernel raster/base)
room(raster/cpu/stages raster/cpu/classic raster/stages raster/scene raster/kernel/gradient raster/kernel/cull
     raster/kernel raster/base)
room(raster/cpu/fast raster/cpu raster/scene raster/kernel/cull raster/kernel raster/base)
room(raster/cpu/classic raster/cpu raster/scene raster/kernel/cull raster/kernel)
room(raster/cpu raster/api raster/scene raster/kernel/cull raster/kernel raster/base)
room(raster/cuda/train raster/cuda/stages raster/cuda/fast raster/cuda raster/api raster/train raster/field raster/scene
     raster/kernel/gradient raster/kernel/cull raster/kernel raster/base)
room(raster/cuda/stages raster/cuda/fast raster/cuda raster/stages raster/scene raster/kernel/gradient raster/kernel/cull
     raster/kernel raster/base)
room(raster/cuda/lpips raster/cuda raster/lpips)
room(raster/cuda/fast raster/cuda raster/kernel/cull raster/kernel)
room(raster/cuda/classic raster/cuda raster/kernel/cull raster/kernel)
room(raster/cuda raster/api raster/scene raster/kernel/cull raster/kernel raster/base)
room(raster/api raster/lpips raster/train raster/scene raster/kernel/gradient raster/kernel/cull raster/kernel raster/base)
room(raster/lpips raster/scene raster/base)
room(raster/clock)
room(raster/stages raster/scene raster/kernel/gradient raster/kernel/cull raster/kernel raster/base)
room(raster/train raster/field raster/scene raster/kernel/gradient raster/kernel raster/base)
room(raster/field raster/kernel/gradient raster/kernel raster/base)
room(raster/scene raster/kernel raster/base)
room(raster/kernel/gradient raster/kernel)
room(raster/kernel/cull raster/kernel)
room(raster/kernel)
room(raster/base)
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
  if(file MATCHES "\\.cuh?$" AND NOT file MATCHES "^raster/(cuda|make)/")
    list(APPEND broken "src/${file}: device code belongs in src/raster/cuda")
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
