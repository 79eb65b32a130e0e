# SPDX-License-Identifier: MIT
# All libraries the project uses; scripts/setup installs them. ImGui, zstd, libwebp, libzip and OpenImageIO are found
# through pkg-config, because Debian's CMake files for them are missing or broken.
# QUADSPLAT_STATIC, used by scripts/bundle, links static libraries if the system has them, the C++ library included.
# Shared libraries are loaded from ../lib beside the program.
if(QUADSPLAT_STATIC)
  list(PREPEND CMAKE_FIND_LIBRARY_SUFFIXES .a)
  add_compile_definitions(FMT_HEADER_ONLY)  # Debian has no static fmt
  set(CMAKE_INSTALL_RPATH "$ORIGIN/../lib")
  set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)
  add_link_options(-static-libstdc++ -static-libgcc -Wl,--as-needed -Wl,--gc-sections
                   -Wl,--disable-new-dtags)
endif()
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(glm CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(hwy CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
find_package(ZLIB REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(WEBP REQUIRED IMPORTED_TARGET libwebp)
pkg_check_modules(ZIP REQUIRED IMPORTED_TARGET libzip)
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)  # one header; src/io/scene/gltf/tinygltf.cpp compiles it
pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
find_package(glfw3 3.3 CONFIG REQUIRED)
if(QUADSPLAT_PORTAL)
  pkg_check_modules(DBUS IMPORTED_TARGET dbus-1)
  if(NOT DBUS_FOUND)
    message(STATUS "libdbus was not found: the viewer always uses its own dialog for opening files")
    set(QUADSPLAT_PORTAL OFF)
  endif()
endif()
if(QUADSPLAT_OIIO)
  pkg_check_modules(OIIO IMPORTED_TARGET OpenImageIO)
  if(NOT OIIO_FOUND)
    message(WARNING "OpenImageIO was not found: only png, ppm and pfm pictures will be read and written, and jpg read")
    set(QUADSPLAT_OIIO OFF)
  endif()
endif()
