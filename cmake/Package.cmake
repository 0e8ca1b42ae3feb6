# Debian packages, by cpack in the folder of the build (scripts/package): `piste` with the programs, `libpiste-dev` with the
# libraries and headers, and for a shared build `libpiste` with the libraries alone.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME piste)
set(CPACK_PACKAGE_VENDOR "the piste authors")
set(CPACK_PACKAGE_CONTACT "the piste authors <maintainers@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "trajectory and IMU errors from raw logs of a MEMS-IMU and GNSS")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL programs development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

# The distribution is part of the version, as 1~deb12u1: packages for 12 and 13 differ in name, and that for 13 is the newer one.
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release _release REGEX "^(ID|VERSION_ID)=")
  string(REGEX REPLACE "\"" "" _release "${_release}")
  if(_release MATCHES "(^|;)ID=debian(;|$)" AND _release MATCHES "VERSION_ID=([0-9]+)")
    set(CPACK_DEBIAN_PACKAGE_RELEASE 1~deb${CMAKE_MATCH_1}u1)
  elseif(_release MATCHES "(^|;)ID=ubuntu(;|$)" AND _release MATCHES "VERSION_ID=([0-9.]+)")
    set(CPACK_DEBIAN_PACKAGE_RELEASE 1~ubuntu${CMAKE_MATCH_1})
  endif()
endif()

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME piste)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "Programs that turn raw logs of a body-worn MEMS-IMU, a GNSS receiver and, if there is
 one, a reference IMU into a trajectory and the errors of the IMU, each with its standard deviation.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libpiste-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# A static library needs the fmt that it was compiled with: another major version has other symbols.
math(EXPR _next_fmt "${fmt_VERSION_MAJOR} + 1")
string(CONCAT CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4), libgeographiclib-dev (>= 2.1), "
  "libyaml-cpp-dev (>= 0.7), libfmt-dev (>= ${fmt_VERSION_MAJOR}), libfmt-dev (<< ${_next_fmt})")
if(PROJ_FOUND)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libproj-dev (>= 9)")
endif()
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "libceres-dev (>= 2.1)")  # piste::batch alone
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "The library of piste, for programs of one's own: headers, libraries, and how CMake and
 pkg-config find them.")

if(BUILD_SHARED_LIBS)
  list(APPEND CPACK_COMPONENTS_ALL library)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libpiste)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_GENERATE_SHLIBS ON)
  set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "The shared libraries of piste.")
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
  set(CPACK_COMPONENT_PROGRAMS_DEPENDS library)
  set(CPACK_COMPONENT_DEVELOPMENT_DEPENDS library)
endif()

# The manual as it stands in the sources, so that its links lead where they do there. The index links to the pages of the
# headers, which only the site has. A source distribution for Python has no manual.
if(EXISTS ${PROJECT_SOURCE_DIR}/docs/index.md)
  set(_doc ${CMAKE_INSTALL_DATADIR}/doc/piste)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/index.md)
  file(READ docs/index.md _index)
  string(REGEX REPLACE "<a href=\"library/[^>]*>([^<]*)</a>" "\\1" _index "${_index}")
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/manual/index.md CONTENT "${_index}" @ONLY)
  install(FILES README.md CONTRIBUTING.md DESTINATION ${_doc} COMPONENT programs)
  install(DIRECTORY docs DESTINATION ${_doc} COMPONENT programs PATTERN index.md EXCLUDE)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/manual/index.md DESTINATION ${_doc}/docs COMPONENT programs)
endif()

# Where Debian looks for a licence.
foreach(package IN ITEMS programs:piste development:libpiste-dev)
  string(REPLACE ":" ";" package ${package})
  list(GET package 0 component)
  list(GET package 1 name)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} RENAME copyright COMPONENT ${component})
  install(FILES CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endforeach()
include(CPack)
