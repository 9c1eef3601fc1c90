// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace swiftlet::sim {

/// A word of a command line, quoted where a shell needs it.
std::string in_shell_quotes(const std::string& text);

}  // namespace swiftlet::sim
