// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

const char* version();       ///< version of the project, "0.1.0"
const char* git_revision();  ///< short hash at build time, with "+" for a modified tree; "unknown" without git

}  // namespace swiftlet::sim
