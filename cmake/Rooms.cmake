# Most of the time to compile a file of this project goes into the same few headers (Eigen's above all): they are
# precompiled once for all targets that have the same compiler options. A file still includes what it uses; the preset
# "debug" builds without.
#   swiftlet_share_headers(target name-of-the-set [LIBS foo::foo] HEADERS <header>...)
function(swiftlet_share_headers target set)
  cmake_parse_arguments(ARG "" "" "LIBS;HEADERS" ${ARGN})
  if(NOT TARGET ${set})
    file(WRITE ${PROJECT_BINARY_DIR}/${set}.cpp "")
    add_library(${set} OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/${set}.cpp)
    target_link_libraries(${set} PRIVATE swiftlet_options Eigen3::Eigen ${ARG_LIBS})
    target_precompile_headers(${set} PRIVATE ${ARG_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${set})
endfunction()

# Several files of a target in one translation unit: what they include is read, instantiated and optimized once. A file
# still compiles alone (the preset "debug" does so), and names in anonymous namespaces are unique within a folder.
function(swiftlet_compile_together target)
  if(SWIFTLET_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # Every type of an anonymous namespace looks to it as if it came from a header then.
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
endfunction()

# A room is a folder of the house (docs/architecture.md) and one static library: core/math -> swiftlet_core_math.
#   swiftlet_room(core/math USES core/x sim/y LIBS Eigen3::Eigen PRIVATE_LIBS foo [COMPONENT pcl])
# A room with a component is not part of swiftlet::core or swiftlet::sim: it is swiftlet::<component>.
# Sources are every .cpp of the folder: adding a module means adding its file and a line in the room's registry.
function(swiftlet_room room)
  cmake_parse_arguments(ARG "" "COMPONENT" "USES;LIBS;PRIVATE_LIBS" ${ARGN})
  string(REPLACE "/" "_" name ${room})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${room}/*.cpp)
  set(target swiftlet_${name})
  if(ARG_COMPONENT)
    set(name ${ARG_COMPONENT})
  else()
    set_property(GLOBAL APPEND PROPERTY SWIFTLET_ROOMS ${room})
  endif()
  if(NOT sources)
    # A room without sources yet still hands on what it uses.
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE ${ARG_LIBS})
    foreach(used ${ARG_USES})
      string(REPLACE "/" "_" used_name ${used})
      target_link_libraries(${target} INTERFACE swiftlet_${used_name})
    endforeach()
    return()
  endif()
  add_library(${target} STATIC ${sources})
  if(ARG_COMPONENT)
    add_library(swiftlet::${ARG_COMPONENT} ALIAS ${target})
  endif()
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${SWIFTLET_INSTALL_INCLUDE}>)
  target_compile_definitions(${target} PUBLIC EIGEN_MAX_ALIGN_BYTES=16)  # whatever the processor that a user builds for
  target_link_libraries(${target} PUBLIC ${ARG_LIBS} PRIVATE swiftlet_options ${ARG_PRIVATE_LIBS})
  swiftlet_share_headers(${target} swiftlet_house_headers HEADERS
    <Eigen/Cholesky> <Eigen/Geometry> <algorithm> <array> <charconv> <cmath> <cstring> <filesystem> <functional> <map> <memory>
    <numbers> <optional> <span> <stdexcept> <string> <vector>)
  swiftlet_compile_together(${target})
  foreach(used ${ARG_USES})
    string(REPLACE "/" "_" used_name ${used})
    target_link_libraries(${target} PUBLIC swiftlet_${used_name})
  endforeach()
endfunction()

# swiftlet_tests(core/math LIBS ... [LABELS unit] [SUPPORT allocation_counter]): every .cpp of tests/<room> in one
# GoogleTest program test_core_math, with the named files of tests/support. Tests that match SLOW run only when the label
# slow is asked for.
function(swiftlet_tests folder)
  cmake_parse_arguments(ARG "" "SLOW" "LIBS;LABELS;SUPPORT" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${folder}/*.cpp)
  if(NOT sources)
    return()
  endif()
  string(REPLACE "/" "_" name ${folder})
  string(REPLACE "/" "_" room_target swiftlet_${folder})
  list(TRANSFORM ARG_SUPPORT PREPEND ${PROJECT_SOURCE_DIR}/tests/support/)
  list(TRANSFORM ARG_SUPPORT APPEND .cpp)
  add_executable(test_${name} ${sources} ${ARG_SUPPORT})
  if(TARGET ${room_target})
    target_link_libraries(test_${name} PRIVATE ${room_target})
  endif()
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBS} swiftlet_test_options GTest::gtest GTest::gmock GTest::gtest_main)
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/include)
  target_compile_definitions(test_${name} PRIVATE SWIFTLET_SOURCE_DIR="${PROJECT_SOURCE_DIR}" SWIFTLET_BINARY_DIR="${PROJECT_BINARY_DIR}")
  swiftlet_share_headers(test_${name} swiftlet_test_headers LIBS swiftlet_test_options GTest::gtest GTest::gmock HEADERS
    <gtest/gtest.h> <gmock/gmock.h> <Eigen/Cholesky> <Eigen/Geometry> <algorithm> <array> <cmath> <filesystem> <map> <memory>
    <numbers> <span> <string> <vector>)
  swiftlet_compile_together(test_${name})
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  if(ARG_SLOW)
    gtest_discover_tests(test_${name} TEST_FILTER "${ARG_SLOW}" TEST_LIST test_${name}_slow
      PROPERTIES LABELS slow TIMEOUT 7200 DISCOVERY_TIMEOUT 60)
    set(filter TEST_FILTER "-${ARG_SLOW}")
  endif()
  gtest_discover_tests(test_${name} ${filter} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT 300 DISCOVERY_TIMEOUT 60)
endfunction()
