// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command_line.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::tools {

/// Options common to all subcommands that take a scenario.
struct ScenarioOptions {
  std::string file;
  std::optional<std::uint64_t> seed;
  std::optional<double> duration_s;
  std::vector<std::string> set;
  bool allow_plugins = false;

  void add_to(Subcommand& command);
  /// Reads the scenario with all overrides. Throws InputError.
  sim::Scenario load() const;
};

/// "key=value" of each --set, in the given order. Throws InputError.
ConfigChanges parse_assignments(const std::vector<std::string>& set);

}  // namespace swiftlet::tools
