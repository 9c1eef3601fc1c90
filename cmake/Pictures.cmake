# Pictures are drawn by OpenGL in software, without a display. OSMesa or EGL makes the context; Mesa 25.1 removed OSMesa.
# Sets SWIFTLET_PICTURE_LIBRARY: OSMESA, EGL or none. sim/render links swiftlet_pictures.
set(SWIFTLET_PICTURES AUTO CACHE STRING "Library that draws pictures: OSMESA, EGL, OFF, or AUTO for the first of them that is installed")
set_property(CACHE SWIFTLET_PICTURES PROPERTY STRINGS AUTO OSMESA EGL OFF)
if(NOT SWIFTLET_PICTURES MATCHES "^(AUTO|OSMESA|EGL|OFF)$")
  message(FATAL_ERROR "SWIFTLET_PICTURES: expected AUTO, OSMESA, EGL or OFF, found ${SWIFTLET_PICTURES}")
endif()

find_path(OSMESA_INCLUDE_DIR GL/osmesa.h)
find_library(OSMESA_LIBRARY OSMesa)
find_path(EGL_INCLUDE_DIR EGL/eglext.h)
find_library(EGL_LIBRARY EGL)
find_path(GL_CORE_INCLUDE_DIR GL/glcorearb.h)  # libgl-dev: libosmesa6-dev and libegl-dev depend on it
set(SWIFTLET_PICTURE_LIBRARY none)
foreach(library OSMESA EGL)
  if(SWIFTLET_PICTURE_LIBRARY STREQUAL none AND SWIFTLET_PICTURES MATCHES "^(AUTO|${library})$" AND
     ${library}_INCLUDE_DIR AND ${library}_LIBRARY AND GL_CORE_INCLUDE_DIR)
    set(SWIFTLET_PICTURE_LIBRARY ${library})
  endif()
endforeach()

add_library(swiftlet_pictures INTERFACE)
if(SWIFTLET_PICTURE_LIBRARY STREQUAL none)
  if(SWIFTLET_PICTURES STREQUAL OSMESA)
    swiftlet_missing(libosmesa6-dev library)
  elseif(SWIFTLET_PICTURES STREQUAL EGL)
    swiftlet_missing(libegl-dev library)
  elseif(SWIFTLET_PICTURES STREQUAL OFF)
    message(STATUS "Pictures: none (SWIFTLET_PICTURES=OFF)")
  else()
    message(STATUS "Pictures: none; the Debian packages libegl-dev and libgl1-mesa-dri, or libosmesa6-dev, bring them")
  endif()
else()
  message(STATUS "Pictures: by ${SWIFTLET_PICTURE_LIBRARY}")
  target_include_directories(swiftlet_pictures SYSTEM INTERFACE
    ${${SWIFTLET_PICTURE_LIBRARY}_INCLUDE_DIR} ${GL_CORE_INCLUDE_DIR})
  target_link_libraries(swiftlet_pictures INTERFACE ${${SWIFTLET_PICTURE_LIBRARY}_LIBRARY})
endif()

# What of sim/render is compiled: everything that includes OpenGL with one source of contexts, or renderer_none.cpp.
set(opengl_sources gl_context_osmesa gl_context_egl gl_functions gl_objects mark_painter overlay_painter renderer
  shadow_painter vehicle_painter world_painter)
if(SWIFTLET_PICTURE_LIBRARY STREQUAL none)
  set(not_compiled ${opengl_sources})
elseif(SWIFTLET_PICTURE_LIBRARY STREQUAL OSMESA)
  set(not_compiled gl_context_egl renderer_none)
else()
  set(not_compiled gl_context_osmesa renderer_none)
endif()
list(TRANSFORM not_compiled REPLACE "(.+)" "sim/render/\\1.cpp")
set_source_files_properties(${not_compiled} PROPERTIES HEADER_FILE_ONLY ON)
# The headers of OSMesa and of the core profile exclude each other.
set_source_files_properties(sim/render/gl_context_osmesa.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
