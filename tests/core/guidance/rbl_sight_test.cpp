// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/rbl_sight.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// Looks ahead, 35 degrees to each side.
RblSight with_camera_ahead() {
  NeighborView view;
  view.cones.push_back({Vector3::UnitX(), std::cos(35.0 * kRadPerDeg)});
  return RblSight({view});
}

Neighbor neighbor_at_azimuth(double azimuth_deg, double distance_m) {
  Neighbor neighbor;
  neighbor.position_local_m =
      distance_m * Vector3(std::cos(azimuth_deg * kRadPerDeg), std::sin(azimuth_deg * kRadPerDeg), 0.0);
  return neighbor;
}

TEST(RblSight, TurnsToANeighborTheShortWayAndNoFurtherThanItMust) {
  for (const double azimuth_deg : {-100.0, 100.0, -160.0, 160.0}) {
    RblSight sight = with_camera_ahead();
    const std::vector<Neighbor> neighbors = {neighbor_at_azimuth(azimuth_deg, 5.0)};
    const double turned_deg = sight.heading(Pose::Identity(), Vector3::Zero(), neighbors, {}, 0.0, 0) / kRadPerDeg;
    const double least_deg = std::abs(azimuth_deg) - 35.0;  // headings are 15 degrees apart
    EXPECT_GT(turned_deg * azimuth_deg, 0.0) << azimuth_deg;
    EXPECT_GE(std::abs(turned_deg), least_deg) << azimuth_deg;
    EXPECT_LE(std::abs(turned_deg), least_deg + 15.0) << azimuth_deg;
  }
}

TEST(RblSight, KeepsItsHeadingWhileItSeesEverybody) {
  RblSight sight = with_camera_ahead();
  const std::vector<Neighbor> neighbors = {neighbor_at_azimuth(20.0, 5.0), neighbor_at_azimuth(-30.0, 2.0)};
  EXPECT_EQ(sight.heading(Pose::Identity(), {3.0, 0.0, 0.0}, neighbors, {}, 0.0, 0), 0.0);
}

TEST(RblSight, OfTwoThatItCannotSeeAtOnceItLooksAtTheOneUnseenForLonger) {
  for (const double longer_deg : {90.0, -90.0}) {
    RblSight sight = with_camera_ahead();
    std::vector<Neighbor> neighbors = {neighbor_at_azimuth(longer_deg, 5.0), neighbor_at_azimuth(-longer_deg, 5.0)};
    neighbors[1].seen = 3 * kNsPerSecond;
    // It flies up, where it never sees.
    const double yaw_rad = sight.heading(Pose::Identity(), {0.0, 0.0, 9.0}, neighbors, {}, 0.0, 4 * kNsPerSecond);
    EXPECT_GT(yaw_rad * longer_deg, 0.0);
    EXPECT_LE(std::abs(std::abs(yaw_rad) / kRadPerDeg - 90.0), 35.0);
  }
}

TEST(RblSight, OfTwoThatItCannotSeeAtOnceItLooksAtTheNearerOne) {
  for (const double nearer_deg : {90.0, -90.0}) {
    RblSight sight = with_camera_ahead();
    const std::vector<Neighbor> neighbors = {neighbor_at_azimuth(nearer_deg, 1.1),
                                             neighbor_at_azimuth(-nearer_deg, 1.4)};
    const double yaw_rad = sight.heading(Pose::Identity(), {0.0, 0.0, 9.0}, neighbors, {}, 0.0, 0);
    EXPECT_GT(yaw_rad * nearer_deg, 0.0);
    EXPECT_LE(std::abs(std::abs(yaw_rad) / kRadPerDeg - 90.0), 35.0);
  }
}

}  // namespace
}  // namespace swiftlet
