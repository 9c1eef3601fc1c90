# A library that is missing is named by its Debian package, all of them in one message:
#   swiftlet_find(fmt libfmt-dev library)             find_package(fmt)
#   swiftlet_find(Eigen3 libeigen3-dev library 3.4)   what follows goes to find_package
#   swiftlet_find_module(zstd libzstd libzstd-dev)    PkgConfig::zstd by the name of its .pc file
#   swiftlet_find_header(xxhash.h libxxhash-dev)      a library of headers alone, without a description for CMake
#   swiftlet_stop_if_missing()
set(SWIFTLET_MISSING)
set(SWIFTLET_MISSING_KINDS)

macro(swiftlet_missing debian kind)
  list(APPEND SWIFTLET_MISSING ${debian})
  list(APPEND SWIFTLET_MISSING_KINDS ${kind})
endmacro()

macro(swiftlet_find package debian kind)
  find_package(${package} ${ARGN} QUIET)
  if(NOT ${package}_FOUND)
    swiftlet_missing(${debian} ${kind})
  endif()
endmacro()

macro(swiftlet_find_module name module debian)
  if(PkgConfig_FOUND)
    pkg_check_modules(${name} QUIET IMPORTED_TARGET ${module})
  endif()
  if(NOT ${name}_FOUND)
    swiftlet_missing(${debian} library)
  endif()
endmacro()

macro(swiftlet_find_header header debian)
  string(MAKE_C_IDENTIFIER SWIFTLET_HEADER_${header} folder)
  find_path(${folder} ${header})
  if(NOT ${folder})
    swiftlet_missing(${debian} library)
  endif()
endmacro()

macro(swiftlet_stop_if_missing)
  if(SWIFTLET_MISSING)
    list(REMOVE_DUPLICATES SWIFTLET_MISSING)
    list(REMOVE_DUPLICATES SWIFTLET_MISSING_KINDS)
    list(JOIN SWIFTLET_MISSING " " packages)
    list(JOIN SWIFTLET_MISSING_KINDS " " kinds)
    message(FATAL_ERROR "Missing Debian packages: ${packages}\n`tools/setup ${kinds}` installs them. On other systems install the same libraries.")
  endif()
endmacro()
