# Run at every build (cmake -P): writes ${OUTPUT} when version or revision changed. The repository is named, so it may belong to
# another user, and a foreign one around a tarball does not count. An archive that git made has its revision in cmake/revision.txt.
set(git git --no-optional-locks -C ${SOURCE_DIR} --git-dir=.git --work-tree=.)
execute_process(COMMAND ${git} rev-parse --verify HEAD OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
execute_process(COMMAND ${git} diff --quiet HEAD -- RESULT_VARIABLE changed ERROR_QUIET)
if(NOT revision)
  file(STRINGS ${SOURCE_DIR}/cmake/revision.txt revision LIMIT_COUNT 1)
  set(changed 0)
endif()
if(revision MATCHES "^[0-9a-f]+$")
  string(SUBSTRING ${revision} 0 12 revision)
  if(changed)
    string(APPEND revision "+")
  endif()
else()
  set(revision unknown)
endif()
set(content "// Written by cmake/Version.cmake.
#include \"swiftlet/sim/run/version.hpp\"

namespace swiftlet::sim {

// Found in the file of a plugin before that is opened.
extern const char plugin_mark[];
[[gnu::used]] const char plugin_mark[] = \"swiftlet plugin mark: ${VERSION} (${revision})\";

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
