# PCL is optional: where libpcl-dev is installed, the room core/pcl is built and its choices are in the program. Its own
# package would look for VTK and Qt, so the few libraries are found one by one.
option(SWIFTLET_PCL "Build the component swiftlet::pcl where PCL is installed" ON)

find_path(PCL_INCLUDE_DIR pcl/point_cloud.h PATH_SUFFIXES pcl-1.12 pcl-1.13 pcl-1.14 pcl-1.15)
set(pcl_libraries)
foreach(part registration segmentation features filters sample_consensus search octree kdtree common)
  find_library(PCL_${part}_LIBRARY pcl_${part})
  list(APPEND pcl_libraries ${PCL_${part}_LIBRARY})
endforeach()
if(NOT PCL_INCLUDE_DIR OR pcl_libraries MATCHES NOTFOUND)
  set(SWIFTLET_PCL OFF)
elseif(SWIFTLET_NATIVE)
  message(STATUS "Without PCL: Debian's is compiled for any processor, and wider registers change the layout of Eigen's types")
  set(SWIFTLET_PCL OFF)
endif()
if(SWIFTLET_PCL)
  add_library(swiftlet_libpcl INTERFACE)
  set_target_properties(swiftlet_libpcl PROPERTIES EXPORT_NAME libpcl)
  target_include_directories(swiftlet_libpcl SYSTEM INTERFACE ${PCL_INCLUDE_DIR})
  target_link_libraries(swiftlet_libpcl INTERFACE ${pcl_libraries} Eigen3::Eigen)
  # With AVX, Eigen takes memory in a way of its own. Debian's PCL is compiled without, and takes and frees it by malloc and
  # free. What one side takes and the other frees would end the program.
  target_compile_options(swiftlet_libpcl INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-mno-avx>)
endif()
