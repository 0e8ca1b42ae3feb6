# Installs the libraries, headers and a package config: find_package(piste) gives piste::piste, with COMPONENTS batch
# piste::batch as well; the same for pkg-config as piste and piste-batch. And the sensor files, which configurations name.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/piste)

install(TARGETS piste EXPORT pisteTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
install(DIRECTORY include/piste DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h")
install(EXPORT pisteTargets NAMESPACE piste:: DESTINATION ${_package_dir} COMPONENT development)
set(_pkg_config piste)
if(PISTE_BATCH)
  install(TARGETS piste_batch EXPORT pisteBatchTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
  install(EXPORT pisteBatchTargets NAMESPACE piste:: DESTINATION ${_package_dir} COMPONENT development)
  list(APPEND _pkg_config piste-batch)
endif()

configure_package_config_file(cmake/pisteConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/pisteConfig.cmake
  INSTALL_DESTINATION ${_package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/pisteConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pisteConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/pisteConfigVersion.cmake
  cmake/FindGeographicLib.cmake DESTINATION ${_package_dir} COMPONENT development)

# A shared library brings what it links with; whoever links with a static one has to.
file(RELATIVE_PATH PISTE_PC_TO_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
set(_others "fmt yaml-cpp")
if(PROJ_FOUND)
  string(APPEND _others " proj")
endif()
set(_solver "-lceres -lglog")
if(BUILD_SHARED_LIBS)
  set(PISTE_PC_REQUIRES "eigen3 geographiclib")
  set(PISTE_PC_PRIVATE "Requires.private: ${_others}")
  set(PISTE_PC_SOLVER "Libs.private: ${_solver}")
else()
  set(PISTE_PC_REQUIRES "eigen3 geographiclib ${_others}")
  set(PISTE_PC_PRIVATE "")
  set(PISTE_PC_SOLVER "")
  set(PISTE_PC_WITH_SOLVER " ${_solver}")
endif()
foreach(name IN LISTS _pkg_config)
  configure_file(cmake/${name}.pc.in ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endforeach()

# Scenarios name the sensor files beside them, so that the folders stand as they do in config/.
install(DIRECTORY config/sensors config/scenarios config/articles DESTINATION ${CMAKE_INSTALL_DATADIR}/piste COMPONENT programs)
