# One function declares a module of the engine: a static library plica::NAME built from
# cpp/plica/NAME/*.cpp that sees the headers of the modules it names, and of no others.
#
#   plica_module(NAME [TESTS_ONLY] ALONE kernels.cpp DEPENDS core mesh LINK Eigen3::Eigen PRIVATE CGAL::CGAL
#     PUBLIC_HEADERS scene.hpp)
#
# PUBLIC_HEADERS  those of its headers that are for embedders; all others are internal. See InstallHeaders.cmake
# DEPENDS  modules whose headers its own headers may include
# LINK     third parties that appear in its headers
# TESTS_ONLY  built where a test links it, neither installed nor listed
# PRIVATE  third parties of its sources only: header-only ones, so an installed module does not need them
# ALONE    sources that PLICA_UNITY leaves by themselves: kernels, whose short names are their own
#
# Each module's headers are staged into an include root of its own, so that including a header of a
# module that is not among the dependencies does not build. PLICA_MODULES lists what was declared.
include_guard(GLOBAL)
include(GNUInstallDirs)

function(plica_module name)
  cmake_parse_arguments(ARG "TESTS_ONLY" "" "ALONE;DEPENDS;LINK;PRIVATE;PUBLIC_HEADERS" ${ARGN})
  set(target plica_${name})
  set(source_dir ${PROJECT_SOURCE_DIR}/cpp/plica/${name})
  file(GLOB sources CONFIGURE_DEPENDS ${source_dir}/*.cpp)
  if(NOT sources)
    file(TOUCH ${PROJECT_BINARY_DIR}/empty.cpp)
    set(sources ${PROJECT_BINARY_DIR}/empty.cpp)
  endif()

  set(include_root ${PROJECT_BINARY_DIR}/include/${name})
  file(MAKE_DIRECTORY ${include_root}/plica)
  file(CREATE_LINK ${source_dir} ${include_root}/plica/${name} SYMBOLIC)

  add_library(${target} STATIC ${sources})
  add_library(plica::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name}
    POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    UNITY_BUILD ${PLICA_UNITY}
    UNITY_BUILD_BATCH_SIZE 10)
  list(TRANSFORM ARG_ALONE PREPEND ${source_dir}/)
  set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  target_compile_features(${target} PUBLIC cxx_std_17)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${include_root}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  foreach(dependency IN LISTS ARG_DEPENDS)
    target_link_libraries(${target} PUBLIC plica_${dependency})
  endforeach()
  target_link_libraries(${target} PUBLIC ${ARG_LINK})
  foreach(library IN LISTS ARG_PRIVATE ITEMS plica_warnings)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:${library}>)
  endforeach()

  if(ARG_TESTS_ONLY)
    set_target_properties(${target} PROPERTIES EXCLUDE_FROM_ALL TRUE)
    return()
  endif()
  install(TARGETS ${target} EXPORT plicaTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  list(TRANSFORM ARG_PUBLIC_HEADERS PREPEND plica/${name}/)
  set_property(GLOBAL APPEND PROPERTY PLICA_PUBLIC_HEADERS ${ARG_PUBLIC_HEADERS})
  set(PLICA_MODULES ${PLICA_MODULES} ${name} PARENT_SCOPE)
endfunction()
