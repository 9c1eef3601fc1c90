# `cmake --install` gives a package: find_package(swiftlet) with the targets swiftlet::core and swiftlet::sim. Who asks for
# COMPONENTS core needs Eigen and Clipper alone.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/swiftlet)
get_property(rooms GLOBAL PROPERTY SWIFTLET_ROOMS)
set(core_targets swiftlet_core swiftlet_options)
set(sim_targets)
add_library(swiftlet_core INTERFACE)
foreach(room ${rooms})
  string(REPLACE "/" "_" name ${room})
  if(room MATCHES "^core/")
    list(APPEND core_targets swiftlet_${name})
    target_link_libraries(swiftlet_core INTERFACE swiftlet_${name})
  else()
    list(APPEND sim_targets swiftlet_${name})
  endif()
endforeach()
add_library(swiftlet::core ALIAS swiftlet_core)
set_target_properties(swiftlet_core PROPERTIES EXPORT_NAME core)
install(TARGETS ${core_targets} EXPORT swiftletCoreTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/swiftlet)
install(EXPORT swiftletCoreTargets NAMESPACE swiftlet:: DESTINATION ${package_dir})

if(SWIFTLET_SIM)
  add_library(swiftlet_sim INTERFACE)
  target_link_libraries(swiftlet_sim INTERFACE swiftlet_core ${sim_targets})
  add_library(swiftlet::sim ALIAS swiftlet_sim)
  set_target_properties(swiftlet_sim PROPERTIES EXPORT_NAME sim)
  install(TARGETS ${sim_targets} swiftlet_sim swiftlet_bullet swiftlet_osmesa EXPORT swiftletTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/swiftlet)
  install(EXPORT swiftletTargets NAMESPACE swiftlet:: DESTINATION ${package_dir})
  install(DIRECTORY assets scenarios DESTINATION ${CMAKE_INSTALL_DATADIR}/swiftlet)
endif()

if(SWIFTLET_PCL)
  install(TARGETS swiftlet_core_pcl swiftlet_libpcl EXPORT swiftletPclTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/swiftlet)
  install(EXPORT swiftletPclTargets NAMESPACE swiftlet:: DESTINATION ${package_dir})
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/swiftletConfig.cmake.in
  ${PROJECT_BINARY_DIR}/swiftletConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/swiftletConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/swiftletConfig.cmake ${PROJECT_BINARY_DIR}/swiftletConfigVersion.cmake
  DESTINATION ${package_dir})
if(SWIFTLET_SIM)
  install(DIRECTORY include/swiftlet DESTINATION ${SWIFTLET_INSTALL_INCLUDE} FILES_MATCHING PATTERN "*.hpp")
else()
  install(DIRECTORY include/swiftlet/core DESTINATION ${SWIFTLET_INSTALL_INCLUDE}/swiftlet FILES_MATCHING PATTERN "*.hpp")
endif()
