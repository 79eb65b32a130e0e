# SPDX-License-Identifier: MIT
# Component `library`: libquadsplat with its headers, for find_package(quadsplat COMPONENTS library) and the target
# quadsplat::library, and examples (docs/library.md).
install(TARGETS quadsplat_library EXPORT quadsplat_library LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(FILES src/quadsplat/quadsplat.h src/quadsplat/quadsplat.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/quadsplat COMPONENT library)
install(EXPORT quadsplat_library FILE quadsplat-library.cmake NAMESPACE quadsplat:: DESTINATION ${config} COMPONENT library)
install(FILES ${package}/quadsplatConfig.cmake ${package}/quadsplatConfigVersion.cmake DESTINATION ${config} COMPONENT library)
install(DIRECTORY examples/library DESTINATION ${CMAKE_INSTALL_DATADIR}/quadsplat/examples COMPONENT library)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)
