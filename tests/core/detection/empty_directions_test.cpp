// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/empty_directions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/detection/direction_bins.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;

constexpr double kDeg = std::numbers::pi / 180.0;

double elevation_deg(const Eigen::Vector3f& d) { return std::asin(d.z()) / kDeg; }

/// Largest cosine between a direction and the returns of a scan.
double nearest_cosine(const Scan& scan, const Eigen::Vector3f& d) {
  double nearest = -1.0;
  for (int i = 0; i < scan.size(); ++i) {
    if (scan.hit(i)) nearest = std::max(nearest, static_cast<double>(scan.beams->directions_lidar[i].dot(d)));
  }
  return nearest;
}

TEST(DirectionBins, InvertsThePseudoAngle) {
  for (int k = 0; k < 400; ++k) {
    const double turn = 0.01 * k, z = -0.99 + 0.004 * k;
    const Vector3 d = direction_at(turn, std::min(z, 0.99));
    EXPECT_NEAR(d.norm(), 1.0, 1e-12);
    EXPECT_NEAR(turn_of(d.x(), d.y()), turn, 1e-9);
  }
}

TEST(EmptyDirections, AreOmittedForKnownBeams) {
  EmptyDirections empty(FieldOfView{});
  const auto scan = scan_world(sphere({5.0, 0.0, 1.0}, 0.5), pose_at({0.0, 0.0, 0.0}), make_beams(32, 256), 0);
  EXPECT_TRUE(empty.find(*scan).empty());
}

TEST(EmptyDirections, FillViewAroundReturns) {
  EmptyDirections empty({.bottom_deg = -10.0, .top_deg = 50.0});
  const auto beams = make_beams(60, 720, 50.0, -10.0);
  double covered = 0.0;
  for (int k = 0; k < 8; ++k) {
    const auto scan =
        points_alone(*scan_world(sphere({5.0, 0.0, 1.0}, 0.5), pose_at({0.0, 0.0, 0.0}), beams, 100'000'000 * k));
    const auto found = empty.find(*scan);
    for (const Eigen::Vector3f& d : found) {
      EXPECT_NEAR(d.norm(), 1.0F, 1e-5F);
      EXPECT_GE(elevation_deg(d), -10.01);
      EXPECT_LE(elevation_deg(d), 50.01);
      EXPECT_LT(nearest_cosine(*scan, d), std::cos(0.9 * kDeg)) << "next to a return";
    }
    // Where they are dense: away from the sphere, each cone of 3 deg has one.
    int cones = 0, filled = 0;
    for (double azimuth = 20.0; azimuth < 340.0; azimuth += 20.0) {
      for (double elevation = -7.0; elevation < 48.0; elevation += 5.0) {
        const Eigen::Vector3f axis(std::cos(elevation * kDeg) * std::cos(azimuth * kDeg),
                                   std::cos(elevation * kDeg) * std::sin(azimuth * kDeg), std::sin(elevation * kDeg));
        ++cones;
        filled += std::any_of(found.begin(), found.end(),
                              [&](const Eigen::Vector3f& d) { return d.dot(axis) > std::cos(3.0 * kDeg); });
      }
    }
    covered += static_cast<double>(filled) / cones / 8.0;
  }
  EXPECT_GT(covered, 0.99);
}

TEST(EmptyDirections, StayWithinWhatHasReturned) {
  EmptyDirections empty(FieldOfView{});
  // Pillars ahead, 5 deg high at most.
  const World pillars = [](const Vector3&, const Vector3& d) {
    return d.x() > 0.7 && d.z() < 0.087 && std::fmod(std::abs(d.y()), 0.2) < 0.05 ? 6.0 / d.x() : 0.0;
  };
  const World speck = sphere({20.0, 0.0, 0.0}, 0.1);
  std::size_t num_found = 0;
  for (int k = 0; k < 10; ++k) {
    const World& world = k < 5 ? pillars : speck;
    const auto scan = scan_world(world, pose_at({0.0, 0.0, 0.0}), make_beams(60, 720, 50.0, -10.0), k);
    for (const Eigen::Vector3f& d : empty.find(*points_alone(*scan))) {
      ++num_found;
      EXPECT_LT(elevation_deg(d), 5.5);
      EXPECT_GT(d.x(), 0.68F);
    }
  }
  EXPECT_GT(num_found, 500U);
}

TEST(EmptyDirections, StayWithinViewWidth) {
  EmptyDirections empty({.bottom_deg = -20.0, .top_deg = 20.0, .width_deg = 70.0});
  Scan nothing;
  auto beams = std::make_shared<BeamTable>(*make_beams(1, 4));
  for (Eigen::Vector3f& d : beams->directions_lidar) d.setZero();
  nothing.beams = beams;
  nothing.range_m.assign(4, 0.0F);
  const auto found = empty.find(nothing);
  EXPECT_GT(found.size(), 1000U);
  for (const Eigen::Vector3f& d : found) EXPECT_GT(std::atan2(d.x(), std::abs(d.y())), 54.9 * kDeg);
}

}  // namespace
}  // namespace swiftlet
