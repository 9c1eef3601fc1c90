// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/beam_index.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/math/random.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using testing::make_beams;
using testing::pose_at;

/// A sweep with random ranges from a sensor that moves and turns.
LocalCloud moving_sweep(const std::shared_ptr<const BeamTable>& beams, TimeNs stamp, TimeNs duration,
                        const Vector3& from_m, const Vector3& to_m, double turn_rad) {
  auto scan = std::make_shared<Scan>();
  scan->stamp = stamp;
  scan->duration = duration;
  scan->beams = beams;
  scan->range_m.assign(static_cast<std::size_t>(beams->size()), 0.0F);
  LocalCloud cloud;
  cloud.scan = scan;
  for (int c = 0; c < beams->cols; ++c) {
    const double part = static_cast<double>(c) / beams->cols;
    cloud.T_local_lidar.push_back(pose_at(from_m + part * (to_m - from_m), turn_rad * part));
  }
  return cloud;
}

/// Beams in random directions of the whole sphere, all fired at once.
std::shared_ptr<BeamTable> all_around(int rows, int cols) {
  auto beams = std::make_shared<BeamTable>(*make_beams(rows, cols));
  const Random random(1, "directions");
  for (std::uint32_t i = 0; i < beams->directions_lidar.size(); ++i) {
    const auto n = random.normal3(0, i);
    beams->directions_lidar[i] = Vector3(n[0], n[1], n[2]).normalized().cast<float>();
  }
  return beams;
}

// A sensor and a target that move together meet as in a sweep at rest.
TEST(BeamIndex, FollowsMotionDuringTheSweep) {
  const auto table = make_beams(40, 160, 88.0, -85.0);
  const Random random(2, "motion");
  int met = 0;
  for (std::uint32_t trial = 0; trial < 100; ++trial) {
    const auto vector = [&](std::uint32_t k) -> Vector3 {
      return Vector3(random.uniform(trial, k), random.uniform(trial, k + 1), random.uniform(trial, k + 2)).array() -
             0.5;
    };
    const Vector3 from_m = 4.0 * vector(0), v_mps = 20.0 * vector(3);
    RoundTarget target{.p_local_m = from_m + 8.0 * vector(6).normalized(), .sigma_m = 0.1, .radius_m = 0.3};
    BeamIndex index;
    index.assign(moving_sweep(table, 0, 100'000'000, from_m, from_m, 0.0));
    const double at_rest = index.exposure(target).shots;
    index.assign(moving_sweep(table, 0, 100'000'000, from_m, from_m + 0.1 * v_mps, 0.0));
    target.v_local_mps = v_mps;
    ASSERT_NEAR(index.exposure(target).shots, at_rest, 1e-3 * (1.0 + at_rest)) << trial;
    met += at_rest > 0.5;
  }
  EXPECT_GT(met, 50);
}

TEST(BeamIndex, IgnoresMaskedAndNonFiniteBeams) {
  const RoundTarget target{.p_local_m = {8.0, 0.0, 0.0}, .sigma_m = 0.1, .radius_m = 0.3};
  const auto shots = [&](bool masked, float x) {
    auto table = std::make_shared<BeamTable>(*make_beams(1, 2));
    table->directions_lidar = {Eigen::Vector3f::UnitX(), Eigen::Vector3f(x, 0.0F, 0.0F)};
    table->masked = {0, masked};
    BeamIndex index;
    index.assign(moving_sweep(table, 0, 0, Vector3::Zero(), Vector3::Zero(), 0.0));
    return index.exposure(target).shots;
  };
  EXPECT_NEAR(shots(false, 1.0F), 2.0 * shots(true, 1.0F), 1e-9);
  EXPECT_EQ(shots(false, std::numeric_limits<float>::quiet_NaN()), shots(true, 1.0F));
}

// At most the range of any return within half a degree, and exactly that of one nearby return, at any azimuth.
TEST(BeamIndex, FindsNearestReturnAroundADirection) {
  const auto table = all_around(60, 200);
  const Random random(5, "returns");
  LocalCloud cloud = moving_sweep(table, 0, 0, Vector3::Zero(), Vector3::Zero(), 0.0);
  auto scan = std::make_shared<Scan>(*cloud.scan);
  for (std::uint32_t i = 0; i < scan->range_m.size(); ++i) {
    if (random.uniform(0, i) < 0.03) scan->range_m[i] = static_cast<float>(5.0 + 30.0 * random.uniform(1, i));
  }
  cloud.scan = scan;
  BeamIndex index;
  index.assign(cloud);
  int empty = 0, beside = 0;
  for (std::size_t i = 0; i < scan->range_m.size(); ++i) {
    const Vector3 d = table->directions_lidar[i].cast<double>();
    const double nearest_m = index.nearest_return_m(d);
    double least_apart_rad = 4.0;
    for (std::size_t k = 0; k < scan->range_m.size(); ++k) {
      if (scan->range_m[k] == 0.0F) continue;
      const double apart_rad = std::acos(std::min(d.dot(table->directions_lidar[k].cast<double>()), 1.0));
      if (scan->range_m[k] == static_cast<float>(nearest_m)) least_apart_rad = std::min(least_apart_rad, apart_rad);
      if (apart_rad > 0.009 || std::abs(d.z()) > 0.75) continue;
      ASSERT_LE(nearest_m, scan->range_m[k]) << i << " and " << k;
      beside += k != i;
    }
    if (std::isinf(nearest_m)) {
      ++empty;
      continue;
    }
    EXPECT_LT(least_apart_rad, std::abs(d.z()) < 0.75 ? 0.12 : 0.5) << i << " at height " << d.z();
  }
  EXPECT_GT(beside, 30);
  EXPECT_GT(empty, 2000);
  EXPECT_LT(empty, 11500);
}

TEST(BeamIndex, HitsTargetsAlongTheAxes) {
  const Vector3 axes[] = {Vector3::UnitX(),  Vector3::UnitY(),  Vector3::UnitZ(),
                          -Vector3::UnitX(), -Vector3::UnitY(), -Vector3::UnitZ()};
  auto table = std::make_shared<BeamTable>(*make_beams(1, 6));
  for (std::size_t i = 0; i < 6; ++i) table->directions_lidar[i] = axes[i].cast<float>();
  BeamIndex index;
  index.assign(moving_sweep(table, 0, 0, Vector3::Zero(), Vector3::Zero(), 0.0));
  for (const Vector3& axis : axes) {
    EXPECT_NEAR(index.exposure({.p_local_m = 4.0 * axis, .radius_m = 0.2}).shots, 1.0, 1e-6) << axis.transpose();
    EXPECT_EQ(
        index.exposure({.p_local_m = Vector3(4.0 * axis + axis.cwiseAbs().cross(Vector3(2, 3, 5))), .radius_m = 0.2})
            .shots,
        0.0)
        << axis.transpose();
  }
}

// Bins are not equally wide by azimuth, but in the mean around they are.
TEST(BeamIndex, MeasuresBeamDensityAroundTheTarget) {
  auto table = all_around(128, 256);
  table->masked.assign(table->directions_lidar.size(), 0);
  for (std::size_t i = 0; i < table->masked.size(); ++i) {  // half as dense below
    table->masked[i] = table->directions_lidar[i].z() < 0.0F && i % 2 == 0;
  }
  BeamIndex index;
  index.assign(moving_sweep(table, 0, 0, Vector3::Zero(), Vector3::Zero(), 0.0));
  const double above = 128.0 * 256.0 / (4.0 * std::numbers::pi);
  for (const double z : {-1.0, -0.97, -0.8, -0.5, -0.2, 0.2, 0.5, 0.8, 0.97, 1.0}) {
    for (const double radius_m : {0.1, 1.9}) {
      double sum = 0.0;
      for (int k = 0; k < 64; ++k) {
        const double part = (k % 16 + 0.5) / 16.0;  // evenly by the share of y
        const Vector3 flat = Eigen::AngleAxisd(k / 16 * std::numbers::pi / 2.0, Vector3::UnitZ()) *
                             Vector3(1.0 - part, part, 0.0).normalized();
        sum += index
                   .exposure({.p_local_m = 20.0 * Vector3(std::sqrt(1.0 - z * z) * flat.x(),
                                                          std::sqrt(1.0 - z * z) * flat.y(), z),
                              .radius_m = radius_m})
                   .beams_per_sr;
      }
      EXPECT_NEAR(sum / 64.0, z > 0.0 ? above : 0.5 * above, 0.12 * above) << z << " " << radius_m;
    }
  }
}

}  // namespace
}  // namespace swiftlet
