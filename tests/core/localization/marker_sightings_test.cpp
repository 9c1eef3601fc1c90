// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/marker_sightings.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

/// Returns of an observer at the origin, each in its own column, at 5 s plus an offset.
struct Returns {
  static constexpr float kMarker = 18.0F, kHull = 0.3F, kWall = 0.8F;

  void add(const Vector3& p_m, float reflectivity) {
    points_m.push_back(p_m.cast<float>());
    reflectivities.push_back(reflectivity);
    offsets_s.push_back(now_s);
  }
  /// Legs with sleeves below a hull, as seen from the observer.
  void add_vehicle(const Vector3& middle_m) {
    for (const double y : {-0.12, 0.12}) {
      for (const double z : {-0.12, -0.08}) add(middle_m + Vector3(-0.1, y, z), kMarker);
    }
    for (const double y : {-0.22, -0.1, 0.0, 0.1, 0.22}) {
      add(middle_m + Vector3(-0.1, y, 0.12), kHull);
      add(middle_m + Vector3(0.1, y, 0.05), kHull);
    }
  }
  std::vector<Sighting> sightings() const {
    auto beams = std::make_shared<BeamTable>();
    beams->rows = 1;
    beams->cols = static_cast<int>(points_m.size());
    beams->column_offset_s = offsets_s;
    auto scan = std::make_shared<Scan>();
    scan->stamp = 5 * kNsPerSecond;
    scan->duration = kNsPerSecond / 10;
    scan->beams = beams;
    scan->reflectivity = reflectivities;
    LocalCloud cloud;
    cloud.scan = scan;
    cloud.points_local_m = points_m;
    cloud.T_local_lidar.assign(points_m.size(), Pose::Identity());
    for (std::uint32_t i = 0; i < points_m.size(); ++i) cloud.beam.push_back(i);
    std::vector<Sighting> found;
    MarkerSightings(3.0, 0.3).append(cloud, found);
    return found;
  }

  std::vector<Eigen::Vector3f> points_m;
  std::vector<float> reflectivities, offsets_s;
  float now_s = 0.0F;
};

TEST(MarkerSightings, SeparatesVehicleFromDoorwayPosts) {
  const Vector3 middle_m(5.0, 0.1, 0.3);
  Returns returns;
  returns.add_vehicle(middle_m);
  for (int i = -10; i <= 10; ++i) {
    returns.add({5.0, 0.1 - 0.45, 0.3 + 0.1 * i}, Returns::kWall);
    returns.add({5.0, 0.1 + 0.45, 0.3 + 0.1 * i}, Returns::kWall);
  }
  const std::vector<Sighting> found = returns.sightings();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT((found[0].p_local_m - middle_m).norm(), 0.02);
  EXPECT_EQ(found[0].t, 5 * kNsPerSecond);
  EXPECT_LT((found[0].covariance - 0.0025 * Matrix3::Identity()).norm(), 1e-9);
}

TEST(MarkerSightings, SeparatesTwoVehicles) {
  Returns returns;
  returns.add_vehicle({5.0, 0.0, 0.0});
  returns.add_vehicle({5.0, 1.0, 0.0});
  EXPECT_EQ(returns.sightings().size(), 2U);
}

TEST(MarkerSightings, IgnoresDullReturnsAndSingleGlints) {
  Returns returns;
  for (int i = 0; i < 20; ++i) returns.add({4.0, 0.02 * i, 0.0}, Returns::kWall);
  EXPECT_TRUE(returns.sightings().empty());
  returns.add({7.0, 1.0, 0.0}, Returns::kMarker);
  EXPECT_TRUE(returns.sightings().empty());
  returns.reflectivities.clear();
  EXPECT_TRUE(returns.sightings().empty()) << "a sensor without reflectivity";
}

TEST(MarkerSightings, StampsMidwayBetweenFirstAndLast) {
  Returns returns;
  returns.add({9.0, 3.0, 0.0}, Returns::kWall);
  for (const float offset_s : {0.02F, 0.03F, 0.06F}) {
    returns.now_s = offset_s;
    returns.add({5.0, 0.0, 0.1 * offset_s}, Returns::kMarker);
  }
  returns.now_s = 0.09F;
  returns.add({9.0, -3.0, 0.0}, Returns::kWall);
  const std::vector<Sighting> found = returns.sightings();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(to_seconds(found[0].t), 5.04, 1e-6);
}

}  // namespace
}  // namespace swiftlet
