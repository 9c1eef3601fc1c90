# `cmake --install` gives a package: find_package(swiftlet), targets swiftlet::core and swiftlet::sim.
include(CMakePackageConfigHelpers)

get_property(rooms GLOBAL PROPERTY SWIFTLET_ROOMS)
add_library(swiftlet_core INTERFACE)
set_target_properties(swiftlet_core PROPERTIES EXPORT_NAME core)
add_library(swiftlet_sim INTERFACE)
set_target_properties(swiftlet_sim PROPERTIES EXPORT_NAME sim)
target_link_libraries(swiftlet_sim INTERFACE swiftlet_core)
set(room_targets)
foreach(room ${rooms})
  string(REPLACE "/" "_" name ${room})
  list(APPEND room_targets swiftlet_${name})
  if(room MATCHES "^core/")
    target_link_libraries(swiftlet_core INTERFACE swiftlet_${name})
  else()
    target_link_libraries(swiftlet_sim INTERFACE swiftlet_${name})
  endif()
endforeach()
add_library(swiftlet::core ALIAS swiftlet_core)
add_library(swiftlet::sim ALIAS swiftlet_sim)

if(SWIFTLET_PCL)
  install(TARGETS swiftlet_core_pcl swiftlet_libpcl EXPORT swiftletPclTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/swiftlet)
  install(EXPORT swiftletPclTargets NAMESPACE swiftlet:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/swiftlet)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/swiftlet)
install(TARGETS ${room_targets} swiftlet_core swiftlet_sim swiftlet_options swiftlet_bullet swiftlet_osmesa
  EXPORT swiftletTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/swiftlet)
install(EXPORT swiftletTargets NAMESPACE swiftlet:: DESTINATION ${package_dir})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/swiftletConfig.cmake.in
  ${PROJECT_BINARY_DIR}/swiftletConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/swiftletConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/swiftletConfig.cmake ${PROJECT_BINARY_DIR}/swiftletConfigVersion.cmake
  DESTINATION ${package_dir})
install(DIRECTORY include/swiftlet DESTINATION ${SWIFTLET_INSTALL_INCLUDE} FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY assets scenarios DESTINATION ${CMAKE_INSTALL_DATADIR}/swiftlet)
