// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/registry.hpp"

#include <stdexcept>
#include <vector>

#include "core/guidance/hover.hpp"

namespace swiftlet {
namespace {

constexpr GuidanceType kTypes[] = {
    {{"hover", "stay at the start or at a point", make_module_config<HoverConfig>}, make_hover},
};

}  // namespace

std::span<const GuidanceType> guidance_types() { return kTypes; }

std::span<const ModuleType> guidance_module_types() {
  static const std::vector<ModuleType> modules = [] {
    std::vector<ModuleType> out;
    for (const GuidanceType& type : kTypes) out.push_back(type.module);
    return out;
  }();
  return modules;
}

std::unique_ptr<Guidance> make_guidance(const Module& config, const GuidanceSetup& setup) {
  for (const GuidanceType& type : kTypes) {
    if (config.type == type.module.name) return type.make(*config.config, setup);
  }
  throw std::invalid_argument("no guidance type is named '" + config.type + "'");
}

}  // namespace swiftlet
