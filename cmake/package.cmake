# Debian package: cmake --build build/portable --target package. The program prints its own manual page and completion.
add_custom_command(OUTPUT whorl.1.gz whorl.bash
                   COMMAND sh -c "$<TARGET_FILE:whorl> manual | gzip -9nc > whorl.1.gz"
                   COMMAND sh -c "$<TARGET_FILE:whorl> manual --bash > whorl.bash"
                   DEPENDS whorl VERBATIM)
add_custom_command(OUTPUT changelog.gz COMMAND sh -c "gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md > changelog.gz" DEPENDS CHANGELOG.md VERBATIM)
# Debian's changelog describes only the packaging.
set(maintainer "Whorl <whorl@example.org>")
string(TIMESTAMP today "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian "whorl (${PROJECT_VERSION}-1) unstable; urgency=medium

  * Whorl ${PROJECT_VERSION}; for changes see the project's changelog.

 -- ${maintainer}  ${today}
")
add_custom_command(OUTPUT changelog.Debian.gz COMMAND sh -c "gzip -9nc changelog.Debian > changelog.Debian.gz" VERBATIM)
add_custom_target(manual ALL DEPENDS whorl.1.gz whorl.bash changelog.gz changelog.Debian.gz)

# Builds the files below in case only the program was built.
install(CODE "execute_process(COMMAND \"${CMAKE_COMMAND}\" --build \"${CMAKE_BINARY_DIR}\" --target manual COMMAND_ERROR_IS_FATAL ANY)")
set(doc ${CMAKE_INSTALL_DATADIR}/doc/whorl)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/whorl.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/whorl.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME whorl)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian.gz LICENSE
        DESTINATION ${doc})
install(FILES LICENSE DESTINATION ${doc} RENAME copyright)
# README.md, docs and scenes keep their relative positions, so that links between them work.
install(FILES README.md DESTINATION ${doc})
install(DIRECTORY docs DESTINATION ${doc})
file(CREATE_LINK ../../whorl/scenes ${CMAKE_CURRENT_BINARY_DIR}/scenes.link SYMBOLIC)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scenes.link DESTINATION ${doc} RENAME scenes)

set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Opened at run time by name (libepoxy, and libegl1 for its drivers) or started (ffmpeg), so shlibdeps does not see them.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libegl1, libgl1, libegl-mesa0, libgl1-mesa-dri, ffmpeg")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "simulation and videos of viscous fluids and vortices")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Whorl simulates honey, lava and paint that coil, fold and pile up, water that
splashes, and vortices, with smoothed particle hydrodynamics. A scene is one
text file; whorl computes it, draws it and writes a video. It needs no
graphics card.")
include(CPack)
