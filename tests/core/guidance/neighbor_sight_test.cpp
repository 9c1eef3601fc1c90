// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/neighbor_sight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

#include "core/guidance/separation/neighbor_memory.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// Looks ahead, 35 degrees to each side.
NeighborSight with_camera_ahead() {
  NeighborView view;
  view.cones.push_back({Vector3::UnitX(), std::cos(35.0 * kRadPerDeg)});
  return NeighborSight({view});
}

Neighbor neighbor_at_azimuth(double azimuth_deg, double distance_m) {
  Neighbor neighbor;
  neighbor.position_local_m =
      distance_m * Vector3(std::cos(azimuth_deg * kRadPerDeg), std::sin(azimuth_deg * kRadPerDeg), 0.0);
  return neighbor;
}

TEST(NeighborSight, TurnsToNeighborTheShortWay) {
  for (const double azimuth_deg : {-100.0, 100.0, -160.0, 160.0}) {
    NeighborSight sight = with_camera_ahead();
    const std::vector<Neighbor> neighbors = {neighbor_at_azimuth(azimuth_deg, 5.0)};
    const double turned_deg = sight.heading(Pose::Identity(), Vector3::Zero(), neighbors, 0.0, 0) / kRadPerDeg;
    const double least_deg = std::abs(azimuth_deg) - 35.0;  // headings are 15 degrees apart
    EXPECT_GT(turned_deg * azimuth_deg, 0.0) << azimuth_deg;
    EXPECT_GE(std::abs(turned_deg), least_deg) << azimuth_deg;
    EXPECT_LE(std::abs(turned_deg), least_deg + 15.0) << azimuth_deg;
  }
}

// Half of all directions ahead: the plane through the vehicle is the edge.
TEST(NeighborSight, SightMarginAppliesOnlyNearLevel) {
  NeighborView view;
  view.cones.push_back({Vector3::UnitX(), 0.0});
  const NeighborSight sight({view});
  const auto sees = [&](const Vector3& to_m) { return sight.sees_ahead(Pose::Identity(), to_m); };
  EXPECT_TRUE(sees({-0.3, 2.0, 0.0}));
  EXPECT_FALSE(sees({-0.5, 2.0, 0.0}));
  for (const double up : {-1.0, 1.0}) {
    EXPECT_TRUE(sees({0.1, 0.1, 6.0 * up}));
    EXPECT_FALSE(sees({-0.1, -0.1, 6.0 * up})) << "never in view";
  }
}

TEST(NeighborSight, KeepsHeadingWhileSeeingAllNeighbors) {
  NeighborSight sight = with_camera_ahead();
  const std::vector<Neighbor> neighbors = {neighbor_at_azimuth(20.0, 5.0), neighbor_at_azimuth(-30.0, 2.0)};
  EXPECT_EQ(sight.heading(Pose::Identity(), {3.0, 0.0, 0.0}, neighbors, 0.0, 0), 0.0);
}

TEST(NeighborSight, LooksAtTheMoreUrgentNeighbor) {
  for (const double side_deg : {90.0, -90.0}) {
    std::vector<Neighbor> longer_unseen = {neighbor_at_azimuth(side_deg, 5.0), neighbor_at_azimuth(-side_deg, 5.0)};
    longer_unseen[1].seen = 3 * kNsPerSecond;
    const std::vector<Neighbor> nearer = {neighbor_at_azimuth(side_deg, 1.1), neighbor_at_azimuth(-side_deg, 1.4)};
    std::vector<Neighbor> approaching = {neighbor_at_azimuth(side_deg, 9.0), neighbor_at_azimuth(-side_deg, 7.0)};
    approaching[0].velocity_local_mps = -4.0 * approaching[0].position_local_m.normalized();
    approaching[1].velocity_local_mps = 4.0 * approaching[1].position_local_m.normalized();
    for (const std::vector<Neighbor>& neighbors : {longer_unseen, nearer, approaching}) {
      NeighborSight sight = with_camera_ahead();
      const TimeNs now = neighbors[1].seen > 0 ? 4 * kNsPerSecond : 0;
      // The vehicle flies up, outside of its field of view.
      const double yaw_rad = sight.heading(Pose::Identity(), {0.0, 0.0, 9.0}, neighbors, 0.0, now);
      EXPECT_GT(yaw_rad * side_deg, 0.0);
      EXPECT_LE(std::abs(std::abs(yaw_rad) / kRadPerDeg - 90.0), 35.0);
    }
  }
}

TEST(NeighborSight, NeverTurnsWithAllRoundView) {
  NeighborSight sight({});
  const std::vector<Neighbor> behind = {neighbor_at_azimuth(180.0, 5.0)};
  EXPECT_EQ(sight.heading(Pose::Identity(), {-3, 0, 0}, behind, 0.7, 5 * kNsPerSecond), 0.7);
  EXPECT_TRUE(sight.sees_ahead(Pose::Identity(), {-3, 0, 0}));
}

}  // namespace
}  // namespace swiftlet
