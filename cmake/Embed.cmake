# Files of another kind than C++ (shaders, style sheets, scripts, SQL, a font) stand as files of their own and become part of
# the program:
#   swiftlet_embed(sim/render shaders/mesh.vert shaders/mesh.frag)
# gives the room's sources <embedded/sim_render.hpp> with swiftlet::sim::embedded::mesh_vert and mesh_frag, a
# std::string_view each that ends with a zero, and mesh_vert_sha256 with its digest, in hexadecimal digits.
# An edit of a file compiles that file alone again. A file with an absolute path may lie anywhere.
if(CMAKE_SCRIPT_MODE_FILE)
  # cmake -DINPUT=file -DNAME=name -DSPACE=namespace -DOUTPUT=file.cpp -P Embed.cmake
  file(SHA256 ${INPUT} sha256)
  file(SIZE ${INPUT} size)
  string(MAKE_C_IDENTIFIER ${SPACE}_${NAME} bytes)
  file(WRITE ${OUTPUT} "#include <string_view>\n\n"
    "asm(R\"(.pushsection .rodata\n.global ${bytes}\n.hidden ${bytes}\n${bytes}: .incbin \"${INPUT}\"\n.byte 0\n.popsection)\");\n"
    "extern \"C\" const char ${bytes}[];\n\nnamespace ${SPACE} {\n\n"
    "extern const std::string_view ${NAME};\nconstinit const std::string_view ${NAME}{${bytes}, ${size}};\n"
    "extern const std::string_view ${NAME}_sha256;\nconstinit const std::string_view ${NAME}_sha256 = \"${sha256}\";\n\n}  // namespace ${SPACE}\n")
  return()
endif()

set(SWIFTLET_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(swiftlet_embed room)
  string(REPLACE "/" "_" prefix ${room})
  string(REGEX REPLACE "/.*" "" space ${room})
  set(space swiftlet::${space}::embedded)
  set(folder ${PROJECT_BINARY_DIR}/generated/embedded)
  set(outputs)
  set(header "#pragma once\n\n#include <string_view>\n\nnamespace ${space} {\n\n")
  foreach(file ${ARGN})
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${PROJECT_SOURCE_DIR}/${room})
    get_filename_component(name ${file} NAME)
    string(MAKE_C_IDENTIFIER ${name} name)
    set(output ${folder}/${prefix}.${name}.cpp)
    add_custom_command(OUTPUT ${output} DEPENDS ${file} ${SWIFTLET_EMBED_SCRIPT} VERBATIM
      COMMAND ${CMAKE_COMMAND} -DINPUT=${file} -DNAME=${name} -DSPACE=${space} -DOUTPUT=${output}
              -P ${SWIFTLET_EMBED_SCRIPT})
    target_sources(swiftlet_${prefix} PRIVATE ${output})
    list(APPEND outputs ${output})
    string(APPEND header "extern const std::string_view ${name}, ${name}_sha256;  // ${file}\n")
  endforeach()
  # A target without dependencies: otherwise the generated files, and with them the room's objects, wait for the libraries of other rooms.
  add_custom_target(${prefix}_embedded DEPENDS ${outputs})
  add_dependencies(swiftlet_${prefix} ${prefix}_embedded)
  file(CONFIGURE OUTPUT ${folder}/${prefix}.hpp CONTENT "${header}\n}  // namespace ${space}\n" @ONLY)
  target_include_directories(swiftlet_${prefix} PRIVATE ${PROJECT_BINARY_DIR}/generated)
endfunction()
