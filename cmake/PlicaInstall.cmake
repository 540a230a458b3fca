# Install and export: after `cmake --install BUILD --component development --prefix DIR`, a program says
#   find_package(plica REQUIRED COMPONENTS dynamics)
#   target_link_libraries(mine PRIVATE plica::dynamics)
# and one built without CMake takes its flags from `pkg-config --cflags --libs plica`.
# Licence, README, what it links to and the examples lie in ${plica_DOC_DIR}.
include_guard(GLOBAL)
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(PLICA_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/plica)
set(PLICA_DOC_DIR ${CMAKE_INSTALL_DATADIR}/doc/plica)
configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/plicaConfig.cmake.in ${PROJECT_BINARY_DIR}/plicaConfig.cmake
  INSTALL_DESTINATION ${PLICA_CMAKE_DIR} PATH_VARS PLICA_DOC_DIR)
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/plicaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/plicaConfig.cmake ${PROJECT_BINARY_DIR}/plicaConfigVersion.cmake
  DESTINATION ${PLICA_CMAKE_DIR} COMPONENT development)
install(EXPORT plicaTargets NAMESPACE plica:: DESTINATION ${PLICA_CMAKE_DIR} COMPONENT development)
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${PLICA_DOC_DIR} COMPONENT development)
install(DIRECTORY docs DESTINATION ${PLICA_DOC_DIR} COMPONENT development)
install(DIRECTORY examples DESTINATION ${PLICA_DOC_DIR} COMPONENT development
  FILES_MATCHING PATTERN "*.toml" PATTERN "*.py" PATTERN "*.cpp")

# ---- Headers: the public ones, and what they include -------------------------------------------
get_property(public_headers GLOBAL PROPERTY PLICA_PUBLIC_HEADERS)
set(PLICA_HEADERS_DIR ${PROJECT_BINARY_DIR}/installed_headers)
configure_file(${PROJECT_SOURCE_DIR}/cmake/InstallHeaders.cmake ${PROJECT_BINARY_DIR}/InstallHeaders.cmake @ONLY)
install(SCRIPT ${PROJECT_BINARY_DIR}/InstallHeaders.cmake COMPONENT development)
install(DIRECTORY ${PLICA_HEADERS_DIR}/plica DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)

# ---- For builds without CMake: every module, dependents before what they depend on -------------
set(libraries ${PLICA_MODULES})
list(REVERSE libraries)
list(TRANSFORM libraries PREPEND "-lplica_")
list(JOIN libraries " " PLICA_LIBRARIES)
if(PLICA_GPL)
  string(APPEND PLICA_LIBRARIES " ${CHOLMOD_LIBRARY}")
endif()
get_target_property(definitions plica_core INTERFACE_COMPILE_DEFINITIONS)
list(TRANSFORM definitions PREPEND "-D")
list(JOIN definitions " " PLICA_DEFINITIONS)
file(RELATIVE_PATH PLICA_PREFIX_FROM_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" PLICA_PREFIX_FROM_PC ${PLICA_PREFIX_FROM_PC})
configure_file(${PROJECT_SOURCE_DIR}/cmake/plica.pc.in ${PROJECT_BINARY_DIR}/plica.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/plica.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
