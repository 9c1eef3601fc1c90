// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

const char* version();  ///< of the project, "0.1.0"
const char*
git_revision();  ///< short hash at build time, "+" appended when the tree was changed; "unknown" without git

}  // namespace swiftlet::sim
