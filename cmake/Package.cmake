# `cmake --install` gives a package: find_package(swiftlet) with the targets swiftlet::core and swiftlet::sim. Who asks for
# COMPONENTS core needs Eigen and Clipper alone.
include(CMakePackageConfigHelpers)

# Folders that every account can read, whatever the umask of the installing one.
set(CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS ${CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS})

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
  install(TARGETS ${sim_targets} swiftlet_sim swiftlet_bullet swiftlet_pictures EXPORT swiftletTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/swiftlet)
  install(EXPORT swiftletTargets NAMESPACE swiftlet:: DESTINATION ${package_dir})
  install(DIRECTORY assets scenarios DESTINATION ${CMAKE_INSTALL_DATADIR}/swiftlet COMPONENT program)
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

# The program with its pages and examples as a Debian package (tools/package). The pictures of the pages would make it three times as large.
# The version names the system, because each release has libraries of its own: 0.1.0-1~debian12.
if(SWIFTLET_SIM)
  cmake_host_system_information(RESULT system QUERY DISTRIB_INFO)
  file(GLOB pages CONFIGURE_DEPENDS docs/*.md)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/swiftlet RENAME copyright COMPONENT program)
  install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/swiftlet COMPONENT program)
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/swiftlet/docs COMPONENT program)
  install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/swiftlet COMPONENT program)
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_CONTACT "The Swiftlet authors <noreply@swiftlet.invalid>")
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_COMPONENTS_ALL program)
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_DEBIAN_PACKAGE_RELEASE "1~${system_ID}${system_VERSION_ID}")
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME swiftlet)
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
  set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "One program that reads one scenario file. It needs a processor with AVX2, and no display.")
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  if(SWIFTLET_PICTURE_LIBRARY STREQUAL EGL)
    set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS libgl1-mesa-dri)  # loaded by EGL
  endif()
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS ffmpeg)  # videos
  include(CPack)
endif()
