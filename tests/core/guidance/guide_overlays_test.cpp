// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/guiding/guide_overlays.hpp"

#include <gtest/gtest.h>

#include <map>

#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "swiftlet/core/tracking/track_overlays.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet {
namespace {

std::map<std::string, Overlay> overlays_of(const TeamPlan& plan, double height_local_m) {
  std::vector<Overlay> overlays;
  append_guide_overlays(plan, height_local_m, overlays);
  std::map<std::string, Overlay> by_name;
  for (const Overlay& overlay : overlays) by_name[overlay.name] = overlay;
  return by_name;
}

double drawn_length_m(const Overlay& lines) {
  double sum_m = 0.0;
  for (std::size_t i = 0; i + 1 < lines.positions.size(); i += 2)
    sum_m += (lines.positions[i + 1] - lines.positions[i]).norm();
  return sum_m;
}

Ring rectangle(double x_m, double y_m, double width_m, double depth_m) {
  return {{x_m, y_m}, {x_m + width_m, y_m}, {x_m + width_m, y_m + depth_m}, {x_m, y_m + depth_m}};
}

TEST(GuideOverlays, DrawsPathsAsLinesBetweenPoints) {
  TeamPlan plan;
  plan.secondary_path = {{{0, 0, 1}, 0.0}, {{3, 0, 1}, 0.0}, {{3, 4, 1}, 0.0}};
  plan.primary_local_m = {{0, 0, 2}, {0, 0, 4}};
  auto overlays = overlays_of(plan, 1.5);
  ASSERT_EQ(overlays.size(), 5U);
  for (const char* name : {"guide.secondary_path", "guide.primary_path", "guide.visible", "guide.overlap"}) {
    EXPECT_EQ(overlays[name].kind, Overlay::Kind::kLines);
  }
  EXPECT_EQ(overlays["guide.secondary_path"].positions.size(), 4U);
  EXPECT_NEAR(drawn_length_m(overlays["guide.secondary_path"]), 7.0, 1e-6);
  EXPECT_EQ(overlays["guide.secondary_path"].positions.back(), Eigen::Vector3f(3, 4, 1));
  EXPECT_EQ(overlays["guide.primary_path"].positions.size(), 2U);
  EXPECT_NEAR(drawn_length_m(overlays["guide.primary_path"]), 2.0, 1e-6);
  EXPECT_TRUE(overlays["guide.visible"].positions.empty());
  EXPECT_TRUE(overlays["guide.viewpoint"].positions.empty());
}

TEST(GuideOverlays, DrawsRegionBordersAtObserverHeight) {
  TeamPlan plan;
  // Two that overlap: their common border is that of the whole.
  plan.visible = {inside_of(rectangle(0, 0, 2, 2)), inside_of(rectangle(1, 0, 3, 2))};
  plan.viewpoint.overlap = inside_of(rectangle(1, 0, 1, 2));
  plan.viewpoint.num_visible = 1;
  plan.viewpoint.p_local_m = {1.5, 1.0, 2.5};
  auto overlays = overlays_of(plan, 2.5);
  EXPECT_NEAR(drawn_length_m(overlays["guide.visible"]), 2 * (4.0 + 2.0), 1e-4);
  EXPECT_NEAR(drawn_length_m(overlays["guide.overlap"]), 2 * (1.0 + 2.0), 1e-4);
  for (const char* name : {"guide.visible", "guide.overlap"}) {
    const Overlay& border = overlays[name];
    for (std::size_t i = 0; i < border.positions.size(); ++i) {
      EXPECT_EQ(border.positions[i].z(), 2.5F);
      // Around without a gap: each line begins where the one before ends.
      if (i % 2 == 0) continue;
      EXPECT_EQ(border.positions[i], border.positions[(i + 1) % border.positions.size()]);
    }
  }
  ASSERT_EQ(overlays["guide.viewpoint"].positions.size(), 1U);
  EXPECT_EQ(overlays["guide.viewpoint"].positions[0], Eigen::Vector3f(1.5F, 1.0F, 2.5F));
}

// Beside the map, the teammate and its track, as the scenario forest_guidance draws them.
TEST(GuideOverlays, UsesDistinctColors) {
  AgentSetup setup;
  setup.num_vehicles = 2;
  setup.vehicle_names = {"primary", "secondary"};
  Module relative(relative_localizer_module_types(), "sliding_window");
  relative.as<SlidingWindowConfig>().other = "secondary";
  Track track;
  track.id = 1;
  std::vector<Overlay> overlays;
  append_guide_overlays({}, 2.0, overlays);
  TrackOverlays().append(std::array{track}, overlays);
  make_mapper(Module(mapper_module_types(), "occupancy"), setup)->append_overlays(overlays);
  make_relative_localizer(relative, setup)->append_overlays(overlays);
  std::map<std::string, Eigen::Vector3f> colors;
  for (const Overlay& overlay : overlays) {
    for (const Overlay::Key& key : overlay.legend) {
      if (overlay.name != "relative.window" && !key.dashed) colors[key.meaning] = key.color.head<3>();
    }
  }
  EXPECT_GT(colors.size(), 5U);
  for (const auto& [a, color_a] : colors) {
    for (const auto& [b, color_b] : colors) {
      if (a < b) {
        EXPECT_GE(sim::color_difference(color_a, color_b), 0.15F) << a << " and " << b;
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet
