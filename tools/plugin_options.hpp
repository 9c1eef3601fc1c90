// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "command_line.hpp"

namespace swiftlet::tools {

/// Adds the flag --allow-plugins, with which the user permits scenarios to load their plugins (shared libraries).
void add_allow_plugins(Subcommand& command, bool& allowed);
/// Permits this process to load plugins built for exactly this version and git revision.
void allow_plugins();

/// Option --plugin FILE of subcommands that read no scenario. Plugins named in this option need no --allow-plugins.
struct PluginOptions {
  std::vector<std::string> files;

  void add_to(Subcommand& command);
  /// Loads the named plugins. Throws InputError when a file cannot be loaded as a plugin.
  void load() const;
};

}  // namespace swiftlet::tools
