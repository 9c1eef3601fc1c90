// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/sim/scenario/config_files.hpp"

namespace swiftlet::sim {

struct Asset {
  std::string name;  ///< name in configurations: the file name without .yaml
  std::string doc;   ///< first sentence of the comment at its beginning
};

/// Assets available in assets/<folder>, or, for "scenarios", the scenarios of Swiftlet; sorted by name.
std::vector<Asset> list_assets(const std::string& folder, const ConfigFiles& files = system_files());

}  // namespace swiftlet::sim
