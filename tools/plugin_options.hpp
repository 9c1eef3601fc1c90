// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "command_line.hpp"

namespace swiftlet::tools {

/// The flag --allow-plugins: this process loads the plugins that scenarios name.
void add_allow_plugins(Subcommand& command, bool& allowed);
void allow_plugins();

/// --plugin FILE, for subcommands that read no scenario; naming a plugin also allows it.
struct PluginOptions {
  std::vector<std::string> files;

  void add_to(Subcommand& command);
  /// Throws InputError.
  void load() const;
};

}  // namespace swiftlet::tools
