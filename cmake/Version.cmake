# Run at every build (cmake -P): writes ${OUTPUT} when version or revision changed. A clone of another user is trusted as far as
# its revision goes. The repository must be this one: a tarball may lie inside a foreign repository. An archive that git made
# has its revision in cmake/revision.txt.
set(git git -c safe.directory=${SOURCE_DIR} -C ${SOURCE_DIR})
execute_process(COMMAND ${git} rev-parse --show-prefix --short=12 HEAD OUTPUT_VARIABLE answer
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR NOT answer MATCHES "^\n?([0-9a-f]+)$")
  file(READ ${SOURCE_DIR}/cmake/revision.txt revision)
  string(STRIP "${revision}" revision)
  if(NOT revision MATCHES "^[0-9a-f]+$")
    set(revision unknown)
  endif()
else()
  set(revision ${CMAKE_MATCH_1})
  execute_process(COMMAND ${git} diff --quiet HEAD -- RESULT_VARIABLE changed ERROR_QUIET)
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
