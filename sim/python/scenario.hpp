// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::python {

/// A scenario with its sources, so that it can be read again with further changes.
struct ReadScenario {
  std::filesystem::path file;
  ConfigChanges changes;
  sim::Scenario scenario;
  std::optional<std::string> text;  ///< instead of the file
};

}  // namespace swiftlet::python
