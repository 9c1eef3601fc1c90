// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/planning/clear_path.hpp"
#include "swiftlet/core/planning/path_timing.hpp"

namespace swiftlet {

/// Follows a path, from corner to corner or by its times. Checks after each change of the map whether the rest is
/// clear.
class PathFollower {
 public:
  enum class Outcome { kFlying, kBlocked, kArrived };
  /// [m/s] speed below which a vehicle counts as hovering. Smaller values delay plans, larger ones plan for a place
  /// that the vehicle leaves.
  static constexpr double kHovers_mps = 0.25;

  /// @param visited_m  distance within which a corner counts as visited
  PathFollower(const ClearPathConfig& rules, double visited_m) : rules_(rules), visited_m_(visited_m) {}

  /// @param corners_local_m  at least two: start and end
  void start(std::vector<Vector3> corners_local_m);
  /// Follows the path by its times; its clock waits for a vehicle that stays behind.
  /// @param path_local  in the local frame
  void start(std::vector<Vector3> corners_local_m, SplineTrajectory path_local);
  /// Sets `target_local_m` and `target_local`; when blocked, to the vehicle's position.
  Outcome step(const GuidanceInput& input);
  const Vector3& target_local_m() const { return target_local_.position_m; }
  const Reference& target_local() const { return target_local_; }
  const std::vector<Vector3>& corners_local_m() const { return corners_local_m_; }

 private:
  bool is_blocked(const OccupancyView& map, const Vector3& p_local_m);
  Outcome step_by_corners(const Vector3& p_local_m, double speed_mps);
  Outcome step_by_time(const Vector3& p_local_m, double speed_mps, double dt_s);

  ClearPathConfig rules_;
  double visited_m_;
  std::vector<Vector3> corners_local_m_;
  std::vector<Vector3> legs_local_m_;  // flown polyline: the corners, or the control points of the spline
  std::size_t next_ = 1;               // index of the next point of the legs
  bool timed_ = false;
  UniformSpline spline_local_;
  double interval_s_ = 0.0, t_s_ = 0.0;
  std::uint64_t checked_ = 0;  // revision of the map in which the path was checked
  Reference target_local_;
};

}  // namespace swiftlet
