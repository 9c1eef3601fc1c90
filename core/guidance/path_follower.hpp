// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/planning/clear_path.hpp"

namespace swiftlet {

/// Flies a path from corner to corner. Whenever the map has changed, it asks whether the rest is still clear.
class PathFollower {
 public:
  enum class Outcome { kFlying, kBlocked, kArrived };
  static constexpr double kHovers_mps = 0.25;  ///< slower than this, it hovers

  /// @param visited_m  nearer than this, a corner was visited
  PathFollower(const ClearPathConfig& rules, double visited_m) : rules_(rules), visited_m_(visited_m) {}

  /// @param corners_local_m  at least two: where it starts, and where it ends
  void start(std::vector<Vector3> corners_local_m);
  /// Where to fly next is in `target_local_m` then; when blocked, where the vehicle is.
  Outcome step(const GuidanceInput& input);
  const Vector3& target_local_m() const { return target_local_m_; }
  const std::vector<Vector3>& corners_local_m() const { return corners_local_m_; }

 private:
  bool is_blocked(const OccupancyView& map, const Vector3& p_local_m);

  ClearPathConfig rules_;
  double visited_m_;
  std::vector<Vector3> corners_local_m_;
  std::size_t next_ = 1;
  std::uint64_t checked_ = 0;  // revision of the map for which the path was found clear
  Vector3 target_local_m_ = Vector3::Zero();
};

}  // namespace swiftlet
