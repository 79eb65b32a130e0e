# SPDX-License-Identifier: MIT
# Component `plugin`: the header of `bench --plugin` and a project to start from (docs/plugin.md).
include(GNUInstallDirs)
install(FILES src/quadsplat/plugin.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/quadsplat COMPONENT plugin)
install(DIRECTORY examples/plugin DESTINATION ${CMAKE_INSTALL_DATADIR}/quadsplat/examples COMPONENT plugin)
