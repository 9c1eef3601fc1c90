// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/interception/chase_team.hpp"
#include "core/interception/target_search.hpp"

namespace swiftlet {

/// Goals of a vehicle that searches its lost target, or a target reported by a teammate. Local frame.
class SearchPlanner {
 public:
  explicit SearchPlanner(const TargetSearchConfig& config) : search_(config) {}

  /// Begins at the last prediction of a lost target.
  void begin(const TargetPrediction& lost);
  /// Begins at the present position of a target reported by a teammate.
  void begin(const Teammate& teammate, TimeNs now);
  /// Counts the time of a tick. True when update() is due.
  bool tick(double dt_s);
  /// @param teammate  sees a target, which is searched instead; null: none
  void update(const Teammate* teammate, TimeNs now, const Vector3& own_local_m, const Surroundings& surroundings);

  const Vector3& goal_local_m() const { return goal_local_m_; }
  void append_overlay(std::vector<Overlay>& overlays) const { search_.append_overlay(overlays); }

 private:
  void restart(const PointState& target, double sigma_m);

  TargetSearch search_;
  Vector3 goal_local_m_ = Vector3::Zero();
  double since_update_s_ = 0.0, since_goal_s_ = 0.0;
};

}  // namespace swiftlet
