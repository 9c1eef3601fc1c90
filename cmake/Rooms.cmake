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

# Files of a target in one translation unit: what they include is read and instantiated once, which takes a third to a half of the
# time of files alone. With more than this many the largest units outgrow SWIFTLET_COMPILER_MB. A file still compiles alone (the preset
# "debug" does so), and names in anonymous namespaces are unique within a folder.
set(SWIFTLET_FILES_TOGETHER 20)
function(swiftlet_compile_together target)
  if(SWIFTLET_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${SWIFTLET_FILES_TOGETHER})
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # Every type of an anonymous namespace looks to it as if it came from a header then.
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
endfunction()

# Rooms whose time is not that of a flight (files, tables, commands) are optimized less: -O1 takes a fifth of clang's time from them.
# GCC's precompiled headers fit one level only.
function(swiftlet_optimize_less)
  foreach(room ${ARGN})
    string(REPLACE "/" "_" name ${room})
    target_compile_options(swiftlet_${name} PRIVATE $<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:Clang>>:-O1>)
  endforeach()
endfunction()

# The law of the house stands in the lines swiftlet_room(...) of CMakeLists.txt, and nowhere else:
#   swiftlet_room(core/math USES core/x INSIDE core/y LIBS Eigen3::Eigen PRIVATE_LIBS foo [LISTED_BY core/z] [PARTS a b] [COMPONENT pcl])
# A room is the folder core/math with what is its own, the folder include/swiftlet/core/math with what others may use, and
# one static library swiftlet_core_math. Its public headers may use what USES names, its other files what INSIDE names as
# well. No other header is on a target's include path: each room has two folders of links, ${PROJECT_BINARY_DIR}/rooms.
# USES hands on, so whoever uses a room finds what that room's headers name.
# LISTED_BY names a room further down whose tables have a row of it: that room uses it inside.
# A room comes after those that it uses, so there are no circles. core/base and sim/errors are what every room may use.
# Sources are every .cpp of the folder: adding a module means adding its file and a line in a registry.
# PARTS names folders of a room, in their order: what stands in a part may include the headers that stand directly in the room's
# folder and those of the parts before it. The room's own files include all of them.
# A room with a component is not part of swiftlet::core or swiftlet::sim: it is swiftlet::<component>.
file(REMOVE_RECURSE ${PROJECT_BINARY_DIR}/rooms)

# In core/ a conversion that may lose digits is written out; clang checks it.
function(swiftlet_warn_of_conversions target)
  if(target MATCHES "^swiftlet_core_" AND CMAKE_CXX_COMPILER_ID MATCHES Clang)
    target_compile_options(${target} PRIVATE -Wconversion -Wno-sign-conversion)
  endif()
endfunction()

function(swiftlet_link_headers room folder)
  cmake_path(GET room PARENT_PATH parent)
  file(MAKE_DIRECTORY ${folder}/public/swiftlet/${parent} ${folder}/private/${parent})
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/include/swiftlet/${room} ${folder}/public/swiftlet/${room} SYMBOLIC)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${room} ${folder}/private/${room} SYMBOLIC)
endfunction()

# The libraries of rooms by their names: core/math -> swiftlet_core_math. They stand above.
function(swiftlet_targets_of out)
  set(targets)
  foreach(room ${ARGN})
    string(REPLACE "/" "_" target swiftlet_${room})
    if(NOT TARGET ${target})
      message(FATAL_ERROR "${room}: no such room so far; a room comes after those that it uses")
    endif()
    list(APPEND targets ${target})
  endforeach()
  set(${out} ${targets} PARENT_SCOPE)
endfunction()

# Compiles a part of a room into the room's library.
function(swiftlet_part room part seen)
  string(REPLACE "/" "_" target swiftlet_${room})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${room}/${part}/*.cpp)
  file(GLOB links CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/${room} ${PROJECT_SOURCE_DIR}/${room}/*.hpp)
  set(folder ${PROJECT_BINARY_DIR}/rooms/${room}_parts/${part})
  file(MAKE_DIRECTORY ${folder}/${room})
  foreach(link ${links} ${seen} ${part})
    file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${room}/${link} ${folder}/${room}/${link} SYMBOLIC)
  endforeach()
  add_library(${target}_${part} OBJECT ${sources})
  target_include_directories(${target}_${part} PRIVATE ${folder} ${PROJECT_BINARY_DIR}/rooms/${room}/public)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  target_link_libraries(${target}_${part} PRIVATE ${libraries})
  swiftlet_share_headers(${target}_${part} swiftlet_house_headers)
  swiftlet_compile_together(${target}_${part})
  swiftlet_warn_of_conversions(${target}_${part})
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:${target}_${part}>)
endfunction()

function(swiftlet_room room)
  cmake_parse_arguments(ARG "" "COMPONENT;LISTED_BY" "USES;INSIDE;LIBS;PRIVATE_LIBS;PARTS" ${ARGN})
  string(REPLACE "/" "_" name ${room})
  set(target swiftlet_${name})
  if(room MATCHES "^sim/")
    list(PREPEND ARG_USES sim/errors)
  endif()
  list(PREPEND ARG_USES core/base)
  list(REMOVE_ITEM ARG_USES ${room})
  swiftlet_targets_of(uses ${ARG_USES})
  get_property(listed GLOBAL PROPERTY SWIFTLET_LISTED_BY_${room})
  if(ARG_LISTED_BY)
    set_property(GLOBAL APPEND PROPERTY SWIFTLET_LISTED_BY_${ARG_LISTED_BY} ${room})
  endif()
  swiftlet_targets_of(inside ${ARG_INSIDE} ${listed})
  set(folder ${PROJECT_BINARY_DIR}/rooms/${room})
  swiftlet_link_headers(${room} ${folder})
  if(ARG_COMPONENT)
    set(name ${ARG_COMPONENT})
  else()
    set_property(GLOBAL APPEND PROPERTY SWIFTLET_ROOMS ${room})
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${room}/*.cpp)
  set(reach PUBLIC)
  if(sources OR ARG_PARTS)
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PRIVATE ${folder}/private)
    target_link_libraries(${target} PRIVATE swiftlet_options ${inside} ${ARG_PRIVATE_LIBS})
    set_property(TARGET ${target} PROPERTY SWIFTLET_INSIDE ${inside})
    swiftlet_share_headers(${target} swiftlet_house_headers HEADERS
      <Eigen/Cholesky> <Eigen/Geometry> <algorithm> <array> <charconv> <cmath> <cstring> <filesystem> <functional> <map> <memory>
      <numbers> <optional> <span> <stdexcept> <string> <vector>)
    swiftlet_compile_together(${target})
    swiftlet_warn_of_conversions(${target})
  else()
    add_library(${target} INTERFACE)  # headers only
    set(reach INTERFACE)
  endif()
  add_library(swiftlet::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} ${reach} cxx_std_20)
  target_include_directories(${target} ${reach}
    $<BUILD_INTERFACE:${folder}/public> $<INSTALL_INTERFACE:${SWIFTLET_INSTALL_INCLUDE}>)
  target_compile_definitions(${target} ${reach} EIGEN_MAX_ALIGN_BYTES=16)  # whatever the processor that a user builds for
  target_link_libraries(${target} ${reach} ${ARG_LIBS} ${uses})
  set(seen)
  foreach(part ${ARG_PARTS})
    swiftlet_part(${room} ${part} "${seen}")
    list(APPEND seen ${part})
  endforeach()
endfunction()

# Who is no room (a program, a test) sees the public headers of the rooms named here, and with INSIDE all of those.
#   swiftlet_uses(target [PUBLIC|PRIVATE] sim/run core/agent [INSIDE sim/raycast])
function(swiftlet_uses target reach)
  cmake_parse_arguments(ARG "" "" "INSIDE" ${ARGN})
  swiftlet_targets_of(uses ${ARG_UNPARSED_ARGUMENTS} ${ARG_INSIDE})
  target_link_libraries(${target} ${reach} ${uses})
  foreach(room ${ARG_INSIDE})
    string(REPLACE "/" "_" name ${room})
    target_link_libraries(${target} ${reach} $<TARGET_PROPERTY:swiftlet_${name},SWIFTLET_INSIDE>)
    target_include_directories(${target} PRIVATE ${PROJECT_BINARY_DIR}/rooms/${room}/private)
  endforeach()
endfunction()

# Tests and benchmarks include their own headers as "tests/support/...".
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/rooms/tests)
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/tests ${PROJECT_BINARY_DIR}/rooms/tests/tests SYMBOLIC)

# swiftlet_tests(core/math USES core/x LIBS ... [LABELS unit] [SUPPORT allocation_counter]): every .cpp of tests/<room> in
# one GoogleTest program test_core_math, with the named files of tests/support. It sees all of its room, and the public
# headers of the rooms that it uses. Tests that match SLOW run only when the label slow is asked for. SWIFTLET_PLAIN_TESTS lists the
# folders whose tests compute little.
function(swiftlet_tests folder)
  cmake_parse_arguments(ARG "" "SLOW" "USES;LIBS;LABELS;SUPPORT" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${folder}/*.cpp)
  string(REPLACE "/" "_" name ${folder})
  list(TRANSFORM ARG_SUPPORT PREPEND ${PROJECT_SOURCE_DIR}/tests/support/)
  list(TRANSFORM ARG_SUPPORT APPEND .cpp)
  add_executable(test_${name} ${sources} ${ARG_SUPPORT})
  if(TARGET swiftlet_${name})
    swiftlet_uses(test_${name} PRIVATE INSIDE ${folder})
  endif()
  swiftlet_uses(test_${name} PRIVATE ${ARG_USES})
  set(kind test)
  if(folder IN_LIST SWIFTLET_PLAIN_TESTS)
    set(kind plain_test)
  endif()
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBS} swiftlet_${kind}_options GTest::gtest GTest::gmock GTest::gtest_main)
  target_include_directories(test_${name} PRIVATE ${PROJECT_BINARY_DIR}/rooms/tests)
  target_compile_definitions(test_${name} PRIVATE SWIFTLET_SOURCE_DIR="${PROJECT_SOURCE_DIR}" SWIFTLET_BINARY_DIR="${PROJECT_BINARY_DIR}")
  swiftlet_share_headers(test_${name} swiftlet_${kind}_headers LIBS swiftlet_${kind}_options GTest::gtest GTest::gmock HEADERS
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
  gtest_discover_tests(test_${name} ${filter} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${SWIFTLET_TEST_TIMEOUT_S} DISCOVERY_TIMEOUT 60)
endfunction()
