// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/intercept_overlays.hpp"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

namespace swiftlet {
namespace {

CaptureVolume net_of(double radius_m, double height_m) {
  CaptureVolume net;
  net.offset_m = {0.0, 0.0, -1.2};
  net.radius_m = radius_m;
  net.height_m = height_m;
  return net;
}

/// Ends of the lines that are not on the vehicle, seen from the net's middle.
std::vector<Vector3> rim_points(const Overlay& lines, const Vector3& p_local_m, const Vector3& middle_m) {
  std::vector<Vector3> rim;
  for (const Eigen::Vector3f& p : lines.positions) {
    if ((p.cast<double>() - p_local_m).norm() > 1e-4) rim.emplace_back(p.cast<double>() - middle_m);
  }
  return rim;
}

TEST(InterceptOverlays, DiscHangsFromFourRopes) {
  const Vector3 p_m(3, -2, 20), middle_m(3, -2, 18.8);
  std::vector<Overlay> overlays;
  append_net(net_of(2.0, 0.0), p_m, 0.4, overlays);
  const Overlay& lines = overlays.at(0);
  EXPECT_EQ(lines.kind, Overlay::Kind::kLines);
  EXPECT_NEAR(lines.size_m, 2.0, 0.9) << "thinner than a plan";
  EXPECT_EQ(lines.positions.size(), 2U * (36U + 4U)) << "round enough";
  double rim_m = 0.0;
  int ropes = 0;
  Eigen::Vector3f ends = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < lines.positions.size(); i += 2) {
    const Eigen::Vector3f a = lines.positions[i], b = lines.positions[i + 1];
    if ((a.cast<double>() - p_m).norm() > 1e-4) {
      rim_m += (a - b).norm();
    } else {
      ++ropes;
      ends += b;
    }
  }
  EXPECT_NEAR(rim_m, 2.0 * 3.14159 * 2.0, 0.05) << "once around";
  EXPECT_EQ(ropes, 4);
  EXPECT_LT((ends.cast<double>() / 4.0 - middle_m).norm(), 1e-5) << "a quarter of a turn apart";
  for (const Vector3& p : rim_points(lines, p_m, middle_m)) {
    EXPECT_NEAR(p.head<2>().norm(), 2.0, 1e-5);
    EXPECT_NEAR(p.z(), 0.0, 1e-5);
  }
}

TEST(InterceptOverlays, DrawsTwelveEdgesOfTheFence) {
  GeofenceConfig config;
  config.min_m = {-1.0, -2.0, 3.0};
  config.max_m = {4.0, 5.0, 6.0};
  std::vector<Overlay> overlays;
  append_fence(Geofence(config, FrameChange()), overlays);
  const Overlay& lines = overlays.at(0);
  ASSERT_EQ(lines.positions.size(), 24U);
  EXPECT_NEAR(lines.size_m, 2.0, 0.9);
  std::set<std::tuple<int, int, int, int>> edges;  // twice the middle, and along which axis
  for (std::size_t i = 0; i < 24; i += 2) {
    const Vector3 a = lines.positions[i].cast<double>(), b = lines.positions[i + 1].cast<double>(), d = b - a;
    int axis = 0;
    const double long_m = d.cwiseAbs().maxCoeff(&axis);
    EXPECT_NEAR(long_m, config.max_m[axis] - config.min_m[axis], 1e-5);
    EXPECT_NEAR(d.cwiseAbs().sum(), long_m, 1e-5) << "along one axis";
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(std::abs(a[k] - config.min_m[k]) < 1e-5 || std::abs(a[k] - config.max_m[k]) < 1e-5);
    }
    const Vector3 twice = a + b;
    edges.insert({static_cast<int>(std::lround(twice.x())), static_cast<int>(std::lround(twice.y())),
                  static_cast<int>(std::lround(twice.z())), axis});
  }
  EXPECT_EQ(edges.size(), 12U);
}

}  // namespace
}  // namespace swiftlet
