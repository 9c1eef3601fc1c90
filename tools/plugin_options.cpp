// SPDX-License-Identifier: BSD-3-Clause
#include "plugin_options.hpp"

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/plugin/plugin.hpp"

namespace swiftlet::tools {

void add_allow_plugins(Subcommand& command, bool& allowed) {
  command.flag("--allow-plugins", allowed, "Load the shared libraries of the scenario, which run code of their own");
}

void allow_plugins() { sim::allow_plugins(std::string(sim::version()) + " (" + sim::git_revision() + ")"); }

void PluginOptions::add_to(Subcommand& command) {
  command.option("--plugin", files, "Load the modules of this shared library (may be repeated)",
                 {.value_name = "FILE", .repeated = true});
}

void PluginOptions::load() const {
  if (files.empty()) return;
  allow_plugins();
  for (const std::string& file : files) {
    const std::string expected = sim::load_plugin(file, ".");
    if (!expected.empty()) throw sim::InputError("--plugin " + file + ": expected " + expected);
  }
}

}  // namespace swiftlet::tools
