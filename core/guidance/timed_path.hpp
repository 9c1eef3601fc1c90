// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/guidance/guidance.hpp"

namespace swiftlet {

/// A smooth curve by time: the uniform cubic B-spline of its control points, at rest in the first one at t = 0 and in
/// the last one at the end. Velocity and acceleration are continuous; the curve stays in the convex hull of any four
/// neighbors.
class UniformSpline {
 public:
  UniformSpline() = default;
  /// @param control_points_m  at least one
  /// @param interval_s        between neighbors
  UniformSpline(std::vector<Vector3> control_points_m, double interval_s);

  struct State {
    Vector3 p_m, v_mps, a_mps2;
  };
  /// Clamped to [0, duration_s()].
  State at(double t_s) const;
  double duration_s() const;

 private:
  std::vector<Vector3> points_m_;
  double interval_s_ = 1.0;
};

/// A way that was planned in advance with its times, flown as a spline with its exact velocity and acceleration. For
/// flights whose meeting points and clearances somebody else has made sure of.
struct TimedPathConfig : ModuleConfigOf<TimedPathConfig> {
  std::vector<Eigen::Vector3d> points_m;
  double interval_s = 0.5;
  std::string yaw = "along_path";
  double yaw_deg = 0.0;

  void visit(ConfigVisitor& v) override;
};

std::unique_ptr<Guidance> make_timed_path(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
