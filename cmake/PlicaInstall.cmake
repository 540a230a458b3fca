# Install and export: after `cmake --install BUILD --component development --prefix DIR`, a program says
#   find_package(plica REQUIRED COMPONENTS dynamics)
#   target_link_libraries(mine PRIVATE plica::dynamics)
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
