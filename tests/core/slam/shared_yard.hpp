// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "core/slam/graph/submap_provider.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet::testing {

/// A yard of 40 m with walls in many directions, boxes and poles, all parts different.
inline std::vector<Vector3> shared_yard_m() {
  std::vector<Vector3> points_m;
  std::mt19937 random(7);
  std::normal_distribution<double> off(0.0, 0.005);
  const auto add_wall = [&](double x0, double y0, double x1, double y1, double height_m) {
    const int n = static_cast<int>(std::hypot(x1 - x0, y1 - y0) / 0.2), m = static_cast<int>(height_m / 0.2);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= m; ++j) {
        const double f = static_cast<double>(i) / n;
        points_m.emplace_back(x0 + f * (x1 - x0) + off(random), y0 + f * (y1 - y0) + off(random), 0.2 * j);
      }
    }
  };
  for (int i = -40; i <= 240; ++i) {
    for (int j = -60; j <= 80; ++j) points_m.emplace_back(0.2 * i, 0.2 * j, off(random));
  }
  add_wall(-6, -7, 14, -6, 4);
  add_wall(14, -6, 30, -9, 3);
  add_wall(30, -9, 44, -7, 5);
  add_wall(-6, 8, 5, 10, 4);
  add_wall(5, 10, 11, 7, 6);
  add_wall(16, 9, 27, 12, 4);
  add_wall(27, 12, 33, 6, 3);
  add_wall(36, 9, 46, 8, 4);
  add_wall(-7, -7, -6, 8, 3);
  add_wall(46, -7, 47, 8, 3);
  add_wall(3, 3, 5, 4, 2);
  add_wall(5, 4, 6, 2, 2);
  add_wall(18, -2, 20, -4, 3);
  add_wall(24, 3, 28, 4, 2);
  add_wall(38, -1, 39, 3, 3);
  return points_m;
}

/// Submaps along a path through such a world, without errors.
class YardFlight : public SubmapProvider {
 public:
  YardFlight(std::vector<Vector3> world_m, const Pose& T_local_world, double reach_m = 14.0)
      : world_m_(std::move(world_m)), T_local_world_(T_local_world), reach_m_(reach_m) {}

  /// Finishes the previous submap.
  void begin_submap(const Pose& T_world_submap) {
    const Pose T_local_submap = T_local_world_ * T_world_submap;
    const double step_m = T_.empty() ? 0.0 : (T_local_submap.translation() - T_.back().translation()).norm();
    path_m_.push_back(T_.empty() ? 0.0 : path_m_.back() + step_m);
    T_.push_back(T_local_submap);
    std::vector<Eigen::Vector3f>& points_m = points_m_.emplace_back();
    for (const Vector3& p_m : world_m_) {
      const Vector3 at_m = T_world_submap.inverse() * p_m;
      if (at_m.head<2>().norm() < reach_m_) points_m.push_back(at_m.cast<float>());
    }
    ++revision_;
  }
  /// Corrects the position of a submap.
  void move(int submap, const Vector3& by_local_m) {
    T_[static_cast<std::size_t>(submap)].translation() += by_local_m;
    ++revision_;
  }

  int num_submaps() const override { return static_cast<int>(T_.size()); }
  std::span<const Eigen::Vector3f> points_submap_m(int submap) const override {
    return points_m_[static_cast<std::size_t>(submap)];
  }
  const Pose& T_local_submap(int submap) const override { return T_[static_cast<std::size_t>(submap)]; }
  double path_length_m(int submap) const override { return path_m_[static_cast<std::size_t>(submap)]; }
  std::uint64_t places_revision() const override { return revision_; }

 private:
  std::vector<Vector3> world_m_;
  Pose T_local_world_;
  double reach_m_;
  std::vector<Pose> T_;
  std::vector<double> path_m_;
  std::vector<std::vector<Eigen::Vector3f>> points_m_;
  std::uint64_t revision_ = 0;
};

inline Pose level_at(double x_m, double y_m, double z_m, double yaw_rad) {
  return make_pose({x_m, y_m, z_m}, rotation_by({0.0, 0.0, yaw_rad}));
}

}  // namespace swiftlet::testing
