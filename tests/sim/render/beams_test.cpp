// SPDX-License-Identifier: BSD-3-Clause
// Scans as pictures: beams found by looking at all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "noted_canvas.hpp"
#include "render_support.hpp"
#include "sim/render/captions.hpp"
#include "sim/render/range_image.hpp"
#include "sim/render/sight.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kRadians = M_PI / 180.0;

Eigen::Vector3f direction_of(double azimuth, double elevation) {
  return Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation))
      .cast<float>();
}

struct Pattern {
  int rows = 16, cols = 90;
  double low_deg = -10.0, high_deg = 20.0;
  double sweep_deg = 360.0;  // from the first to beyond the last column
  double first_deg = 40.0;
  bool clockwise = true;
  bool highest_first = true;
  double stagger_deg = 0.0;  // every second row looks aside by this
};

BeamTable beams_of(const Pattern& p) {
  BeamTable beams;
  beams.rows = p.rows;
  beams.cols = p.cols;
  for (int row = 0; row < p.rows; ++row) {
    const double share = static_cast<double>(row) / (p.rows - 1);
    const double elevation = (p.highest_first ? p.high_deg + share * (p.low_deg - p.high_deg)
                                              : p.low_deg + share * (p.high_deg - p.low_deg)) *
                             kRadians;
    for (int col = 0; col < p.cols; ++col) {
      const double turned = p.sweep_deg * col / p.cols * (p.clockwise ? -1.0 : 1.0);
      beams.directions_lidar.push_back(
          direction_of((p.first_deg + (row % 2 == 0 ? 0.0 : p.stagger_deg) + turned) * kRadians, elevation));
    }
  }
  beams.origins_lidar.assign(beams.directions_lidar.size(), Eigen::Vector3f::Zero());
  beams.column_offset_s.assign(static_cast<std::size_t>(p.cols), 0.0F);
  return beams;
}

double azimuth_of(const BeamTable& beams, int i) {
  const Eigen::Vector3f& d = beams.directions_lidar[static_cast<std::size_t>(i)];
  return std::atan2(d.y(), d.x());
}
double elevation_of(const BeamTable& beams, int i) {
  return std::asin(std::clamp<double>(beams.directions_lidar[static_cast<std::size_t>(i)].z(), -1.0, 1.0));
}

/// Within a cell's size of the nearest beam, that one; farther from all of them, none.
TEST(BeamLookup, FindsNearestOfScatteredBeams) {
  for (const std::uint32_t count : {300U, 4000U}) {
    const Random random(count, "test.scattered");
    BeamTable beams;
    beams.rows = 1;
    beams.cols = static_cast<int>(count);
    const double low = -0.12, high = 0.2;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double elevation = i == 0 ? low : i == 1 ? high : random.uniform(low, high, i, 1);
      beams.directions_lidar.push_back(direction_of(random.uniform(-M_PI, M_PI, i, 0), elevation));
    }
    const BeamLookup lookup(beams);
    ASSERT_FALSE(lookup.organized());
    EXPECT_NEAR(lookup.elevation_min_rad(), low, 1e-6);
    EXPECT_NEAR(lookup.elevation_max_rad(), high, 1e-6);
    const double cell = std::max(0.1 * kRadians, 1.3 * std::sqrt(2.0 * M_PI * (high - low) / count));
    int none = 0;
    for (std::uint32_t k = 0; k < 800; ++k) {
      const double azimuth = random.uniform(-8.0, 8.0, k, 2), elevation = random.uniform(low, high, k, 3);
      int best = -1;
      double least = std::numeric_limits<double>::infinity();
      for (int i = 0; i < beams.size(); ++i) {
        const double aside = std::remainder(azimuth_of(beams, i) - azimuth, 2.0 * M_PI) * std::cos(elevation);
        const double off = std::hypot(aside, elevation_of(beams, i) - elevation);
        if (off < least) least = off, best = i;
      }
      const int found = lookup.beam_at(azimuth, elevation);
      if (least < 0.97 * cell) {
        EXPECT_EQ(found, best) << k;
      } else if (least > 1.03 * cell) {
        EXPECT_EQ(found, -1) << k;
        ++none;
      }
    }
    EXPECT_GT(none, 0);
    EXPECT_LT(none, 60);
  }
}

Scan scan_with(const BeamTable& beams) {
  Scan scan;
  scan.beams = std::make_shared<const BeamTable>(beams);
  scan.range_m.assign(static_cast<std::size_t>(beams.size()), 5.0F);
  scan.intensity.assign(scan.range_m.size(), 0.5F);
  return scan;
}

TEST(RangeImage, DrawsOnlyTheBarWithoutSpace) {
  Look look;
  look.text_px = 10.0F;
  NotedCanvas canvas(120, 120);
  const int left_px = draw_range_image(canvas, look, scan_with(beams_of({})), ScanQuantity::kRange, 40.0);
  EXPECT_LT(left_px, 80);
  EXPECT_TRUE(canvas.pictures.empty());
}

// ---- Sight.

/// A number of leaves in a row, and a wall behind the last one.
BlocksSight leaves_and_wall(int leaves, double wall_behind_m) {
  Scene scene;
  scene.materials.resize(1);
  const auto add = [&](float x, SurfaceClass surface_class) {
    Mesh mesh;
    mesh.surface_class = surface_class;
    add_quad(mesh, {x, -1, -1}, {x, 1, -1}, {x, 1, 1}, {x, -1, 1});
    scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), Eigen::Affine3f::Identity(), 1});
    scene.meshes.push_back(mesh);
  };
  for (int i = 0; i < leaves; ++i)
    add(1.0F + 0.1F * static_cast<float>(i), i % 2 == 0 ? SurfaceClass::kVegetation : SurfaceClass::kUndergrowth);
  if (wall_behind_m > 0.0)
    add(1.0F + 0.1F * static_cast<float>(leaves - 1) + static_cast<float>(wall_behind_m), SurfaceClass::kWall);
  return sight_in(std::make_shared<const StaticScene>(scene));
}

TEST(Sight, Passes63LeavesAndAThinWall) {
  const Eigen::Vector3d a(0, 0, 0), b(20, 0, 0);
  EXPECT_FALSE(leaves_and_wall(63, 0.0)(a, b));
  EXPECT_TRUE(leaves_and_wall(64, 0.0)(a, b));
  // A leaf is a centimeter thick: what stands within it is not seen.
  EXPECT_TRUE(leaves_and_wall(3, 0.02)(a, b));
  EXPECT_FALSE(leaves_and_wall(3, 0.006)(a, b));
  EXPECT_FALSE(leaves_and_wall(1, 0.0)(a, {1.005, 0, 0})) << "it ends within a leaf";
  const BlocksSight wall = leaves_and_wall(1, 0.5);
  EXPECT_FALSE(wall({1.498, 0, 0}, {1.506, 0, 0})) << "as near as a leaf is thick";
  EXPECT_TRUE(wall({1.49, 0, 0}, {1.51, 0, 0}));
}

}  // namespace
}  // namespace swiftlet::sim
