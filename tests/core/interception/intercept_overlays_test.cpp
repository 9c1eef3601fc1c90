// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/intercept_overlays.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace swiftlet {
namespace {

TEST(InterceptOverlays, DrawsTheNetAsARing) {
  const Vector3 p_m(3, -2, 20), middle_m(3, -2, 18.8);
  std::vector<Overlay> overlays;
  append_net({.offset_m = {0.0, 0.0, -1.2}, .radius_m = 2.0, .height_m = 0.0}, p_m, 0.4, overlays);
  const Overlay& lines = overlays.at(0);
  EXPECT_EQ(lines.kind, Overlay::Kind::kLines);
  double rim_m = 0.0;
  for (std::size_t i = 0; i < lines.positions.size(); i += 2) {
    const Vector3 a = lines.positions[i].cast<double>(), b = lines.positions[i + 1].cast<double>();
    EXPECT_NEAR((b - middle_m).head<2>().norm(), 2.0, 1e-5);
    EXPECT_NEAR(b.z(), middle_m.z(), 1e-5);
    if ((a - p_m).norm() > 1e-4) rim_m += (a - b).norm();  // segments from the vehicle are ropes
  }
  EXPECT_NEAR(rim_m, 2.0 * 3.14159 * 2.0, 0.05);
}

TEST(InterceptOverlays, DrawsTwelveEdgesOfTheFence) {
  GeofenceConfig config;
  config.min_m = {-1.0, -2.0, 3.0};
  config.max_m = {4.0, 5.0, 6.0};
  std::vector<Overlay> overlays;
  append_fence(Geofence(config, FrameChange()), overlays);
  const Overlay& lines = overlays.at(0);
  ASSERT_EQ(lines.positions.size(), 24U);
  double sum_m = 0.0;
  for (std::size_t i = 0; i < 24; i += 2) {
    const Vector3 a = lines.positions[i].cast<double>(), b = lines.positions[i + 1].cast<double>();
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(std::abs(a[k] - config.min_m[k]) < 1e-5 || std::abs(a[k] - config.max_m[k]) < 1e-5);
    }
    EXPECT_EQ(((b - a).array().abs() > 1e-5).count(), 1) << "along one axis";
    sum_m += (b - a).norm();
  }
  EXPECT_NEAR(sum_m, 4.0 * (config.max_m - config.min_m).sum(), 1e-4);
}

}  // namespace
}  // namespace swiftlet
