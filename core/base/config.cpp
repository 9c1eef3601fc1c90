// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/config.hpp"

#include <stdexcept>

namespace swiftlet {

Module::Module(std::span<const ModuleType> types, std::string_view type_name) : type(type_name) {
  for (const ModuleType& candidate : types) {
    if (type_name != candidate.name) continue;
    config = candidate.make_config();
    if (!config) throw std::invalid_argument("the module type '" + type + "' makes no configuration");
  }
  if (!config) throw std::invalid_argument("no module type is named '" + type + "'");
}

}  // namespace swiftlet
