# Compiler options for every target of the project, not for those who link it.
add_library(swiftlet_options INTERFACE)
# The same bits from every compiler: no fused multiply-add where the source has none.
target_compile_options(swiftlet_options INTERFACE -ffp-contract=off -fno-math-errno -fno-trapping-math -Wall -Wextra)
# GCC 12 sees overlaps, overflows and unset temporaries that are not there (-Wrestrict, -Wstringop-overflow, -Warray-bounds,
# -Wmaybe-uninitialized in Eigen).
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(swiftlet_options INTERFACE -Wshadow=local -Wno-psabi -Wno-restrict -Wno-stringop-overflow -Wno-array-bounds
    -Wno-maybe-uninitialized)
endif()
# GCC frees memory less often, which saves a twentieth of the compile time and takes 250 MB more a process.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(swiftlet_options INTERFACE "SHELL:--param ggc-min-heapsize=1000000")
endif()
# Only libraries need -fPIC, but the options are the same everywhere so that the precompiled headers fit every target.
target_compile_options(swiftlet_options INTERFACE -fPIC)
# Eigen must not start threads of its own: agents and sensors run in parallel already.
target_compile_definitions(swiftlet_options INTERFACE EIGEN_DONT_PARALLELIZE)
target_compile_features(swiftlet_options INTERFACE cxx_std_20)
if(SWIFTLET_WERROR)
  target_compile_options(swiftlet_options INTERFACE -Werror)
endif()
# Every x86 processor since 2015 has AVX2, and all that have it give the same bits (docs/testing.md). GCC 12 fuses alternating
# sums and differences even where -ffp-contract=off forbids it (vfmaddsub), here or there as it inlines; so it gets no such
# instructions. Eigen's alignment stays that of programs built without AVX.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND NOT SWIFTLET_NATIVE)
  target_compile_options(swiftlet_options INTERFACE -march=x86-64-v3 -mno-fma)
endif()
target_compile_definitions(swiftlet_options INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
if(SWIFTLET_NATIVE)
  target_compile_options(swiftlet_options INTERFACE -march=native)
endif()
if(SWIFTLET_SANITIZE)
  add_compile_options(-fsanitize=${SWIFTLET_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${SWIFTLET_SANITIZE})
  # Eigen would align by hand in our code, but not in PCL's library, and one frees what the other allocates.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
if(SWIFTLET_SANITIZE MATCHES undefined)
  # What the address sanitizer or the processor notices as well, at four times the time to compile Eigen.
  add_compile_options(-fno-sanitize=null,alignment,vptr,object-size,nonnull-attribute,returns-nonnull-attribute)
endif()
if(SWIFTLET_SANITIZE MATCHES thread)
  # cmake/tsan/openmp.cpp says what this is for.
  add_library(swiftlet_tsan STATIC ${PROJECT_SOURCE_DIR}/cmake/tsan/openmp.cpp)
  target_link_libraries(swiftlet_tsan PUBLIC OpenMP::OpenMP_CXX)
  target_link_libraries(swiftlet_options INTERFACE $<BUILD_INTERFACE:swiftlet_tsan>)
  foreach(entry parallel parallel_loop_dynamic parallel_loop_guided parallel_loop_nonmonotonic_dynamic parallel_loop_nonmonotonic_guided)
    add_link_options(-Wl,--wrap=GOMP_${entry})
  endforeach()
endif()

# Tests need to be compiled soon more than to run fast; what they test is optimized in full. Tests that compute little are not
# optimized at all: that takes less than half the time.
foreach(entry "test_options -O1" "plain_test_options -O0")
  separate_arguments(entry)
  list(GET entry 0 name)
  list(GET entry 1 level)
  add_library(swiftlet_${name} INTERFACE)
  target_link_libraries(swiftlet_${name} INTERFACE swiftlet_options)
  target_compile_options(swiftlet_${name} INTERFACE $<$<CONFIG:Release>:${level}>)
endforeach()
