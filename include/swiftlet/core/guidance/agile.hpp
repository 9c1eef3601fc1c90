// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {

/// Random smooth flight as in the simulated trajectories of Vrba 2025, Table IV and Fig. 8 (8.2 m/s, 4.5 m/s^2,
/// altitude 4-10 m).
struct AgileConfig : ModuleConfigOf<AgileConfig> {
  std::uint64_t seed = 1;
  double speed_max_mps = 8.2;
  double acceleration_max_mps2 = 4.5;
  Eigen::Vector3d area_min_m = {-30.0, -30.0, 4.0};
  Eigen::Vector3d area_max_m = {30.0, 30.0, 10.0};
  double leg_min_m = 15.0;  ///< [m] least distance between successive targets; smaller values turn more often
  double pace_min = 1.0;    ///< smallest share of speed_max_mps and acceleration_max_mps2 drawn for a leg
  double knot_s = 0.5;      ///< [s] interval of the spline's knots; smaller values allow more jerk
  enum class Yaw { kAlongPath, kFixed };
  Yaw yaw = Yaw::kAlongPath;
  double yaw_deg = 0.0;

  void visit(ConfigVisitor& v) override;
};

/// An endless trajectory: a uniform quartic B-spline (C3) with control points drawn during the flight. Any frame, the
/// same for all arguments.
///
/// The derivatives of a B-spline are B-splines of the differences of its control points (de Boor, A Practical Guide to
/// Splines, ch. X), hence convex combinations of them. The first differences are at most v h, the second at most a h^2,
/// and the points lie in the box. So speed, acceleration and position keep their bounds at every instant, and jerk is
/// at most 2 a / h. The control points head for random targets in the area, at least `leg_min_m` apart, and can always
/// brake in time.
class AgileSpline {
 public:
  /// Begins at rest at `start`; the area is extended to contain it. Vertical limits may be lower than those of the
  /// whole motion.
  AgileSpline(const AgileConfig& config, const Vector3& start_m, double vertical_speed_mps,
              double vertical_acceleration_mps2);

  void advance(double dt_s);
  /// Heads for this point from now on and comes to rest there. @param pace  share of the maximum speed and acceleration
  void rest_at(const Vector3& point_m, double pace);
  /// Heads for a new random target from now on.
  void roam();
  /// Position, velocity, acceleration now.
  Reference reference() const;
  Vector3 jerk_mps3() const;

 private:
  void add_control_point();
  void pick_target(const Vector3& from_m);
  Vector3 desired_step(const Vector3& point) const;
  Vector3 cut_step(const Vector3& step) const;
  Vector3 brake(const Vector3& step) const;
  double braking_per_knot(const Vector3& step) const;
  bool can_stop_inside(const Vector3& point, const Vector3& step) const;

  AgileConfig config_;
  Random random_;
  double step_max_m_, step_max_z_m_;      ///< per knot
  double change_max_m_, change_max_z_m_;  ///< change of the step per knot
  Vector3 box_min_m_, box_max_m_;
  std::array<Vector3, 5> control_m_;
  Vector3 target_m_;
  bool rests_ = false;  ///< stops at the target instead of passing it
  double pace_ = 1.0;   ///< pace of this leg: share of the maximum speed and acceleration
  std::uint32_t num_targets_ = 0;
  double u_ = 0.0;  ///< progress within the knot interval, 0 to 1
};

/// Throws std::invalid_argument when speed or acceleration are beyond the motion limits.
std::unique_ptr<Guidance> make_agile(const ModuleConfig& config, const GuidanceSetup& setup);

}  // namespace swiftlet
