// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/base/samples.hpp"
#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet::testing {

/// A room of flat walls, seen from inside: half-spaces. What is far away is not seen, so a missing wall leaves a room
/// open. Round stems may stand in it.
struct SyntheticRoom {
  struct Wall {
    Vector3 normal;   ///< toward the inside
    double offset_m;  ///< points inside: normal . p > offset
  };
  struct Stem {
    double x_m, y_m, radius_m, top_m;
  };
  std::vector<Wall> walls;
  std::vector<Stem> stems;

  static SyntheticRoom box(const Vector3& min_m, const Vector3& max_m) {
    SyntheticRoom room;
    for (int axis = 0; axis < 3; ++axis) {
      room.walls.push_back({Vector3::Unit(axis), min_m(axis)});
      room.walls.push_back({-Vector3::Unit(axis), -max_m(axis)});
    }
    return room;
  }

  double range_m(const Vector3& p_world_m, const Vector3& direction_world) const {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls) {
      const double toward = wall.normal.dot(direction_world);
      if (toward >= 0.0) continue;
      nearest_m = std::min(nearest_m, (wall.offset_m - wall.normal.dot(p_world_m)) / toward);
    }
    for (const Stem& stem : stems) {
      const Eigen::Vector2d d = direction_world.head<2>(),
                            to = Eigen::Vector2d(stem.x_m, stem.y_m) - p_world_m.head<2>();
      const double a = d.squaredNorm(), b = d.dot(to);
      const double root = b * b - a * (to.squaredNorm() - stem.radius_m * stem.radius_m);
      if (b <= 0.0 || root < 0.0) continue;
      const double range_m = (b - std::sqrt(root)) / a;
      if (p_world_m.z() + range_m * direction_world.z() < stem.top_m) nearest_m = std::min(nearest_m, range_m);
    }
    return nearest_m;
  }
};

/// 32 rows of 180 beams, -40 to +40 degrees, fired column by column over a tenth of a second.
inline std::shared_ptr<const BeamTable> synthetic_beams() {
  constexpr int kRows = 32, kCols = 180;
  auto beams = std::make_shared<BeamTable>();
  beams->rows = kRows;
  beams->cols = kCols;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kCols; ++column) {
      const double azimuth = 2.0 * M_PI * column / kCols, elevation = (-40.0 + 80.0 * row / (kRows - 1)) * M_PI / 180.0;
      beams->directions_lidar.push_back(
          Vector3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
              .cast<float>());
      beams->origins_lidar.push_back(Eigen::Vector3f::Zero());
    }
  }
  for (int column = 0; column < kCols; ++column) {
    beams->column_offset_s.push_back(0.1F * static_cast<float>(column) / kCols);
  }
  return beams;
}

/// A flight in closed form, and what a LiDAR and an IMU make of it.
class SyntheticFlight {
 public:
  using PoseAt = std::function<Pose(double t_s)>;

  SyntheticFlight(SyntheticRoom room, PoseAt T_world_body_at, unsigned seed = 1)
      : room_(std::move(room)), at_(std::move(T_world_body_at)), random_(seed) {}

  Vector3 gyro_bias_radps = Vector3::Zero(), accel_bias_mps2 = Vector3::Zero();
  double sigma_range_m = 0.02;

  Pose at(TimeNs t) const { return at_(to_seconds(t)); }
  Vector3 velocity_mps(TimeNs t) const {
    constexpr double kStep_s = 1e-5;
    const double s = to_seconds(t);
    return (at_(s + kStep_s).translation() - at_(s - kStep_s).translation()) / (2.0 * kStep_s);
  }

  /// Means over the 4 ms before t.
  ImuSample imu(TimeNs t) {
    constexpr TimeNs kPeriod = 4'000'000;
    const Eigen::Quaterniond q0(at(t - kPeriod).linear()), q1(at(t).linear());
    const Eigen::AngleAxisd turn(q0.conjugate() * q1);
    const Vector3 a_world = (velocity_mps(t) - velocity_mps(t - kPeriod)) / to_seconds(kPeriod);
    const Eigen::Quaterniond q_middle = q0.slerp(0.5, q1);
    ImuSample sample;
    sample.t = t;
    sample.omega_body_radps = turn.axis() * turn.angle() / to_seconds(kPeriod) + gyro_bias_radps + noise(5e-3);
    sample.specific_force_body_mps2 =
        q_middle.conjugate() * (a_world + kGravity_mps2 * Vector3::UnitZ()) + accel_bias_mps2 + noise(6e-2);
    return sample;
  }

  /// The sweep that ends at t.
  std::shared_ptr<const Scan> scan(TimeNs t) {
    auto scan = std::make_shared<Scan>();
    scan->sensor = "lidar";
    scan->duration = 100'000'000;
    scan->stamp = t - scan->duration;
    scan->range_max_m = 50.0;
    scan->sigma_range_m = sigma_range_m;
    scan->T_body_lidar = make_pose({0.05, 0.0, 0.1}, rotation_by({0.0, 0.1, 0.0}));
    scan->beams = beams_;
    scan->range_m.resize(beams_->size());
    std::normal_distribution<double> normal(0.0, sigma_range_m);
    for (int i = 0; i < scan->size(); ++i) {
      const Pose T_world_lidar = at(scan->time_of(i)) * scan->T_body_lidar;
      const double range_m = room_.range_m(T_world_lidar.translation(),
                                           T_world_lidar.linear() * beams_->directions_lidar[i].cast<double>());
      scan->range_m[i] = range_m < scan->range_max_m ? static_cast<float>(range_m + normal(random_)) : 0.0F;
    }
    return scan;
  }

 private:
  Vector3 noise(double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    return {normal(random_), normal(random_), normal(random_)};
  }

  SyntheticRoom room_;
  PoseAt at_;
  std::mt19937 random_;
  std::shared_ptr<const BeamTable> beams_ = synthetic_beams();
};

}  // namespace swiftlet::testing
