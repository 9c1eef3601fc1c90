# Run at every build (cmake -P): writes ${OUTPUT} when version or revision changed.
execute_process(COMMAND git -C ${SOURCE_DIR} rev-parse --short=12 HEAD OUTPUT_VARIABLE revision
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(revision unknown)
else()
  execute_process(COMMAND git -C ${SOURCE_DIR} diff --quiet HEAD -- RESULT_VARIABLE changed ERROR_QUIET)
  if(changed)
    string(APPEND revision "+")
  endif()
endif()
set(content "// Written by cmake/Version.cmake.
#include \"swiftlet/sim/run/version.hpp\"

namespace swiftlet::sim {

const char* version() { return \"${VERSION}\"; }
const char* git_revision() { return \"${revision}\"; }

}  // namespace swiftlet::sim
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL content)
  file(WRITE ${OUTPUT} "${content}")
endif()
