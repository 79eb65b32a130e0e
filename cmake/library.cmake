# SPDX-License-Identifier: MIT
# libquadsplat, a shared library with the C interface of src/quadsplat/quadsplat.h (docs/library.md). It exports the functions
# of that header alone. With QUADSPLAT_STATIC it contains the other libraries, as the program does, and the C++ library;
# libgcc stays shared, so that exceptions work in processes that have other C++ libraries.
include(GNUInstallDirs)  # before the first CMAKE_INSTALL_*DIR
file(STRINGS src/quadsplat/quadsplat.h version REGEX "^#define QS_LIBRARY_VERSION [0-9]+$")
string(REGEX REPLACE ".* " "" version "${version}")

quadsplat_library(quadsplat_library SHARED src/library/*.cpp src/library/*/*.cpp)
set_property(TARGET quadsplat_library PROPERTY EXPORT_NAME library)
set_target_properties(quadsplat_library PROPERTIES OUTPUT_NAME quadsplat VERSION ${version} SOVERSION ${version}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR} LINK_DEPENDS ${PROJECT_SOURCE_DIR}/src/library/quadsplat.map)
target_include_directories(quadsplat_library PRIVATE ${PROJECT_BINARY_DIR}/generated)
target_include_directories(quadsplat_library INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(quadsplat_library PRIVATE quadsplat_learn)
if(QUADSPLAT_HAVE_CUDA)
  target_compile_definitions(quadsplat_library PRIVATE QUADSPLAT_HAVE_CUDA)
endif()
# A process keeps the library once it is loaded, because its threads and thread-local objects cannot be unloaded.
target_link_options(quadsplat_library PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/src/library/quadsplat.map
  -Wl,-z,nodelete -Wl,--gc-sections)
if(QUADSPLAT_STATIC)
  set_source_files_properties(src/library/static_stderr.cpp PROPERTIES COMPILE_DEFINITIONS QUADSPLAT_WRAPS_STDERR)
  target_link_options(quadsplat_library PRIVATE -Wl,--wrap=stderr)
  # Highway stays shared, because Debian has no static one. The Python package has it beside this library.
  set_target_properties(quadsplat_library PROPERTIES INSTALL_RPATH "$ORIGIN")
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL x86_64)
    set_source_files_properties(src/library/static_hypot.cpp PROPERTIES COMPILE_DEFINITIONS QUADSPLAT_WRAPS_HYPOT)
    target_link_options(quadsplat_library PRIVATE -Wl,--wrap=hypot)
  endif()
endif()
if(NOT QUADSPLAT_SANITIZE)
  target_link_options(quadsplat_library PRIVATE -Wl,-z,defs)
endif()
precompile(quadsplat_library REUSE_FROM quadsplat_base)
