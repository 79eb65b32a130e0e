# SPDX-License-Identifier: MIT
# Integrates the program into a desktop: menu entry, icon, file types, and the man page and completion that the program
# prints from its table of options. Part of the component `program`.
set(desktop ${PROJECT_BINARY_DIR}/desktop)
file(MAKE_DIRECTORY ${desktop})
set(print ${CMAKE_COMMAND} -E env ASAN_OPTIONS=detect_leaks=0 $<TARGET_FILE:quadsplat>)
add_custom_command(OUTPUT ${desktop}/quadsplat.1.gz ${desktop}/quadsplat.bash
  COMMAND ${print} --man-page > ${desktop}/quadsplat.1
  COMMAND gzip -9nf ${desktop}/quadsplat.1
  COMMAND ${print} --bash-completion > ${desktop}/quadsplat.bash
  DEPENDS quadsplat VERBATIM
  COMMENT "Printing the man page and the completion")
add_custom_target(desktop ALL DEPENDS ${desktop}/quadsplat.1.gz ${desktop}/quadsplat.bash)

install(FILES ${desktop}/quadsplat.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${desktop}/quadsplat.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME quadsplat COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/desktop/quadsplat.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/desktop/quadsplat.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/desktop/quadsplat.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT program)
