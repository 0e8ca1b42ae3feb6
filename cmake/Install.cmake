# Installs the libraries, headers and a package config: find_package(piste) gives piste::piste, with COMPONENTS batch
# piste::batch as well.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/piste)

install(TARGETS piste EXPORT pisteTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS piste_batch EXPORT pisteBatchTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/piste DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(EXPORT pisteTargets NAMESPACE piste:: DESTINATION ${_package_dir})
install(EXPORT pisteBatchTargets NAMESPACE piste:: DESTINATION ${_package_dir})

configure_package_config_file(cmake/pisteConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/pisteConfig.cmake
  INSTALL_DESTINATION ${_package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/pisteConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pisteConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/pisteConfigVersion.cmake
  cmake/FindGeographicLib.cmake DESTINATION ${_package_dir})
