// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// An analytic curve, flown with its exact velocity and acceleration. The vehicle first flies to the start of the
/// curve, rests there, and then accelerates smoothly. It decelerates as smoothly at the end of the last lap.
struct TrajectoryConfig : ModuleConfigOf<TrajectoryConfig> {
  enum class Shape { kCircle, kLissajous, kLine };
  Shape shape = Shape::kCircle;
  double speed_mps = 2.0;
  int laps = 0;
  Eigen::Vector3d center_m = {0.0, 0.0, 3.0};
  double radius_m = 5.0;
  double phase_deg = 0.0;
  bool clockwise = false;
  Eigen::Vector3d amplitude_m = {10.0, 5.0, 0.0};
  Eigen::Vector3d frequency_ratio = {1.0, 2.0, 1.0};
  Eigen::Vector3d from_m = {-10.0, 0.0, 3.0};
  Eigen::Vector3d to_m = {10.0, 0.0, 3.0};
  enum class Yaw { kAlongPath, kFixed };
  Yaw yaw = Yaw::kAlongPath;
  double yaw_deg = 0.0;

  void visit(ConfigVisitor& v) override;
};

/// Throws std::invalid_argument when the curve at this speed violates the motion limits.
std::unique_ptr<Guidance> make_trajectory(const ModuleConfig& config, const GuidanceSetup& setup);

/// Travel along a length with smooth acceleration and deceleration (quintic steps of the speed, so that acceleration
/// and jerk are continuous).
struct RampedTravel {
  /// [-] Greatest slope of the quintic step from 0 to 1 in unit time: that of x^3 (10 - 15 x + 6 x^2) in its middle.
  static constexpr double kSteepest = 1.875;

  double length = 0.0;  ///< infinity: never slows down
  double speed = 0.0;   ///< cruise speed; lowered by the constructor when the length is too short for it
  double ramp_s = 0.0;

  RampedTravel() = default;
  RampedTravel(double length, double speed, double ramp_s);
  double duration_s() const { return length / speed + ramp_s; }
  struct State {
    double s, ds, dds;
  };
  State at(double t_s) const;
};

}  // namespace swiftlet
