// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/range_image.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "render_support.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {
namespace {

Eigen::Vector3f direction(double azimuth, double elevation) {
  return Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation))
      .cast<float>();
}

/// A clockwise spinning sensor whose rows are offset alternately in azimuth, as an Ouster's are.
BeamTable spinning(int rows, int cols) {
  BeamTable beams;
  beams.rows = rows;
  beams.cols = cols;
  for (int row = 0; row < rows; ++row) {
    const double elevation = (20.0 - 40.0 * row / (rows - 1)) * M_PI / 180.0;
    const double aside = (row % 4 - 1.5) * 2.8 * M_PI / 180.0;
    for (int col = 0; col < cols; ++col) {
      beams.directions_lidar.push_back(direction(1.0 + aside - 2.0 * M_PI * col / cols, elevation));
    }
  }
  beams.origins_lidar.assign(beams.directions_lidar.size(), Eigen::Vector3f::Zero());
  beams.column_offset_s.assign(static_cast<std::size_t>(cols), 0.0F);
  return beams;
}

TEST(BeamLookup, UndoesStaggerOfSpinningSensors) {
  const BeamTable beams = spinning(32, 256);
  const BeamLookup lookup(beams);
  ASSERT_TRUE(lookup.organized());
  for (int i = 0; i < beams.size(); ++i) {
    const Eigen::Vector3f& d = beams.directions_lidar[static_cast<std::size_t>(i)];
    ASSERT_EQ(lookup.beam_at(std::atan2(d.y(), d.x()), std::asin(d.z())), i);
  }
  EXPECT_EQ(lookup.beam_at(0.0, 0.6), -1) << "above the field of view";
}

TEST(BeamLookup, FindsTheNearestBeamWithoutRows) {
  BeamTable beams;
  beams.rows = 1;
  beams.cols = 5000;
  const Random random(3, "test.pattern");
  for (std::uint32_t i = 0; i < 5000; ++i) {
    beams.directions_lidar.push_back(direction(random.uniform(-M_PI, M_PI, 0, i), random.uniform(-0.12, 0.9, 1, i)));
  }
  const BeamLookup lookup(beams);
  ASSERT_FALSE(lookup.organized());
  int found = 0;
  for (std::uint32_t k = 0; k < 500; ++k) {
    const double azimuth = random.uniform(-7.0, 7.0, 2, k);
    const double elevation = random.uniform(-0.1, 0.88, 3, k);
    const int beam = lookup.beam_at(azimuth, elevation);
    if (beam < 0) continue;
    ++found;
    // No beam is much nearer (the search measures on the tangent plane).
    const Eigen::Vector3f target = direction(azimuth, elevation);
    float best = 1e9F;
    for (const Eigen::Vector3f& d : beams.directions_lidar) best = std::min(best, (d - target).norm());
    EXPECT_LT((beams.directions_lidar[static_cast<std::size_t>(beam)] - target).norm(), 1.05F * best + 1e-4F);
  }
  EXPECT_GT(found, 400);
}

Scan scan_of(const BeamTable& beams) {
  Scan scan;
  scan.beams = std::make_shared<const BeamTable>(beams);
  scan.range_m.assign(static_cast<std::size_t>(beams.size()), 0.0F);
  scan.intensity.assign(scan.range_m.size(), 0.0F);
  return scan;
}

TEST(RangeImage, CentersTheFrontInFirstStrip) {
  const BeamTable beams = spinning(64, 512);
  Scan scan = scan_of(beams);
  for (int i = 0; i < beams.size(); ++i) {
    const Eigen::Vector3f& d = beams.directions_lidar[static_cast<std::size_t>(i)];
    const double azimuth = std::atan2(d.y(), d.x());
    // A red (far) post ahead, a blue (near) one at the left, nothing elsewhere.
    if (std::abs(azimuth) < 0.1) scan.range_m[static_cast<std::size_t>(i)] = 38.0F;
    if (std::abs(azimuth - M_PI / 4) < 0.1) scan.range_m[static_cast<std::size_t>(i)] = 8.0F;
  }
  const Image image = painted(800, 450, Rgb::Zero(),
                              [&](Canvas& canvas) { draw_range_image(canvas, {}, scan, ScanQuantity::kRange, 40.0); });
  double ahead_x = 0.0, left_x = 0.0;
  int ahead = 0, left = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < 640; ++x) {  // without the color bar
      const std::uint8_t* p = image.pixel(x, y);
      if (p[0] > p[2] + 100) ahead_x += x, ++ahead;
      if (p[2] > p[0] + 100) left_x += x, ++left;
    }
  }
  ASSERT_GT(ahead, 200);
  ASSERT_GT(left, 200);
  EXPECT_LT(left_x / left + 50, ahead_x / ahead) << "azimuth grows to the left";
}

TEST(RangeImage, AcceptsAnEmptyScan) {
  const Scan scan = scan_of(spinning(16, 64));
  for (const auto quantity : {ScanQuantity::kRange, ScanQuantity::kIntensity}) {
    int left_px = 0;
    const Image image =
        painted(320, 180, Rgb::Zero(), [&](Canvas& canvas) { left_px = draw_range_image(canvas, {}, scan, quantity); });
    EXPECT_GT(left_px, 100);
    EXPECT_LT(left_px, 320) << "the bar has its own place";
  }
}

TEST(BeamLookup, OfNoBeamsFindsNone) { EXPECT_EQ(BeamLookup(BeamTable()).beam_at(0.0, 0.0), -1); }

// Weak and strong returns must be distinguishable at any power.
TEST(RangeImage, UsesTheFullScaleOfIntensities) {
  const BeamTable beams = spinning(64, 512);
  for (const float weak : {1e-4F, 0.1F}) {
    Scan scan = scan_of(beams);
    for (std::size_t i = 0; i < scan.range_m.size(); ++i) {
      scan.range_m[i] = 10.0F;
      scan.intensity[i] = weak * (i % 512 < 256 ? 1.0F : 10.0F);
    }
    int left_px = 0;  // width of the margin
    const Image image = painted(800, 450, Rgb::Zero(), [&](Canvas& canvas) {
      left_px = draw_range_image(canvas, {}, scan, ScanQuantity::kIntensity);
    });
    std::map<int, int> shades;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < left_px; ++x) {
        const std::uint8_t* p = image.pixel(x, y);
        if (p[0] == p[1] && p[1] == p[2]) ++shades[p[0]];
      }
    }
    EXPECT_GT(shades[255], 5000);
    EXPECT_GT(shades[31], 5000);  // 0.12 of white
  }
}

}  // namespace
}  // namespace swiftlet::sim
