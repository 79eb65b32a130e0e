# SPDX-License-Identifier: MIT
# The culling modes as a header-only package: cmake --install BUILD --component cull --prefix FOLDER, then
# find_package(quadsplat COMPONENTS cull) and the target quadsplat::cull. docs/package.md describes it.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
set(package ${PROJECT_BINARY_DIR}/package)

add_library(quadsplat_cull INTERFACE)
set_target_properties(quadsplat_cull PROPERTIES EXPORT_NAME cull)
target_compile_features(quadsplat_cull INTERFACE cxx_std_20)
target_include_directories(quadsplat_cull INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(quadsplat_cull INTERFACE glm::glm)

# Without contraction of a*b+c the host and the device list the same tiles.
add_library(quadsplat_same_bits INTERFACE)
set_target_properties(quadsplat_same_bits PROPERTIES EXPORT_NAME same_bits)
target_compile_options(quadsplat_same_bits INTERFACE
  $<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang,AppleClang>:-ffp-contract=off>
  "$<$<COMPILE_LANG_AND_ID:CUDA,NVIDIA>:--fmad=false;-Xcompiler=-ffp-contract=off>")

# The headers name each other by their installed places.
install(CODE "set(SOURCE \"${PROJECT_SOURCE_DIR}\")\nset(PACKAGE \"${package}\")" COMPONENT cull)
install(SCRIPT ${PROJECT_SOURCE_DIR}/cmake/package_headers.cmake COMPONENT cull)
install(DIRECTORY ${package}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT cull)

set(config ${CMAKE_INSTALL_LIBDIR}/cmake/quadsplat)
install(TARGETS quadsplat_cull quadsplat_same_bits EXPORT quadsplat_cull COMPONENT cull)
install(EXPORT quadsplat_cull FILE quadsplat-cull.cmake NAMESPACE quadsplat:: DESTINATION ${config} COMPONENT cull)
configure_package_config_file(cmake/quadsplatConfig.cmake.in ${package}/quadsplatConfig.cmake INSTALL_DESTINATION ${config})
write_basic_package_version_file(${package}/quadsplatConfigVersion.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${package}/quadsplatConfig.cmake ${package}/quadsplatConfigVersion.cmake DESTINATION ${config} COMPONENT cull)
install(FILES tests/vectors/cull.json DESTINATION ${CMAKE_INSTALL_DATADIR}/quadsplat/vectors COMPONENT cull)
install(DIRECTORY examples/cull DESTINATION ${CMAKE_INSTALL_DATADIR}/quadsplat/examples COMPONENT cull)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT cull)
