// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/stage_tables/relative_localizers.hpp"

namespace swiftlet {
namespace {

constexpr RelativeLocalizerType kRelativeLocalizerTypes[] = {
    {{"none", "no relative localization", make_module_config<NoRelativeConfig>}, make_no_relative_localizer, ""},
    {{"sliding_window",
      "one vehicle with markers, by sightings and the odometry that it reports [Pritzl 2024, sec. II-B]",
      make_module_config<SlidingWindowConfig>},
     make_sliding_window_localizer,
     "relative relative.window"},
    {{"shared_world", "one vehicle that reports its position in a common world frame",
      make_module_config<SharedWorldConfig>},
     make_shared_world_localizer,
     ""},
};

}  // namespace

Registry<RelativeLocalizerType>& relative_localizer_registry() {
  static Registry<RelativeLocalizerType> table("relative_localization", kRelativeLocalizerTypes);
  return table;
}

std::unique_ptr<RelativeLocalizer> make_relative_localizer(const Module& config, const AgentSetup& setup) {
  return relative_localizer_registry().make(config, setup);
}

}  // namespace swiftlet
