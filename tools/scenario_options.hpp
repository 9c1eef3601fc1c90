// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command_line.hpp"
#include "swiftlet/sim/scenario.hpp"

namespace swiftlet::tools {

/// The options by which every subcommand that takes a scenario changes it.
struct ScenarioOptions {
  std::string file;
  std::optional<std::uint64_t> seed;
  std::optional<double> duration_s;
  std::vector<std::string> set;

  void add_to(Subcommand& command);
  /// Reads the scenario with all overrides. Throws InputError.
  sim::Scenario load() const;
};

}  // namespace swiftlet::tools
