# SPDX-License-Identifier: MIT
# The Debian package of the components `program` and `plugin`: scripts/deb. dpkg-shlibdeps finds the packages of linked
# libraries. The libraries that the program loads while it runs, and the programs that it starts, are named here. Without a
# maintainer, as in a source archive without git's history, there is no package.
set(maintainer "${QUADSPLAT_MAINTAINER}")
if(NOT maintainer)
  execute_process(COMMAND git log -1 "--format=%an <%ae>" WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    OUTPUT_VARIABLE maintainer OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT maintainer MATCHES "^[^<>]+ <[^<>@ ]+@[^<>@ ]+>$")
  file(REMOVE ${PROJECT_BINARY_DIR}/CPackConfig.cmake)
  return()
endif()
string(TIMESTAMP today "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${PROJECT_BINARY_DIR}/debian/changelog "quadsplat (${PROJECT_VERSION}) unstable; urgency=medium\n
  * CHANGELOG.md lists the changes.\n\n -- ${maintainer}  ${today}\n")
execute_process(COMMAND gzip -9nf ${PROJECT_BINARY_DIR}/debian/changelog)
install(FILES ${PROJECT_BINARY_DIR}/debian/changelog.gz ${PROJECT_SOURCE_DIR}/cmake/desktop/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT debian)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME quadsplat)
set(CPACK_PACKAGE_VENDOR quadsplat)
set(CPACK_PACKAGE_CONTACT ${maintainer})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "viewer and laboratory for 3D Gaussian Splatting")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "quadsplat shows scenes of 3D Gaussians (.ply, .spz, .splat, .ksplat, .sog and
others) in a window and renders pictures and films of them. It compares the
tile culling modes of several papers: their tile pairs, times and errors.
.
It also trains scenes from photographs, converts between formats, and explains
which Gaussians make a pixel.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program plugin debian)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_NAME quadsplat)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS libgl1)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libgl1-mesa-dri, ffmpeg")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "gnuplot-nox, snakemake")
include(CPack)
