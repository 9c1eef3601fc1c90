// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/scenario/config_files.hpp"

namespace swiftlet::sim {

struct Asset {
  std::string name;  ///< as a configuration names it: the file without .yaml
  std::string doc;   ///< first sentence of the comment at its head
};

/// What can be named from assets/<folder>, or, for "scenarios", the scenarios that come with Swiftlet; by name.
std::vector<Asset> list_assets(const std::string& folder, const ConfigFiles& files = system_files());

}  // namespace swiftlet::sim
