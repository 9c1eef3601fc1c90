// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/guidance/flocking/rbl_cell.hpp"
#include "core/guidance/flocking/rbl_rules.hpp"
#include "core/guidance/half_space.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/guidance/rbl_config.hpp"

namespace swiftlet {

/// Half-space of the cell on the agent's side of a neighbor (2.3). For all interpretations, a neighbor nearer than
/// Delta places the agent outside of its own cell, so that it retreats.
/// @param to_neighbor_local_m  position of the neighbor relative to the agent
/// @param Delta_m        sum of the two encumbrances
HalfSpace neighbor_cut(const Vector3& to_neighbor_local_m, double Delta_m, double eta, RblCellConfig::Cut cut);

/// Distance [m] that an agent may advance toward an obstacle point at distance `d` with its encumbrance kept clear.
inline double obstacle_offset_m(double distance_m, double encumbrance_m, double eta) {
  return distance_m >= 2.0 * encumbrance_m ? encumbrance_m + eta * (distance_m - 2.0 * encumbrance_m)
                                           : distance_m - encumbrance_m;
}
/// Half-space of the cell on the agent's side of an obstacle point, at obstacle_offset_m().
HalfSpace obstacle_cut(const Vector3& to_point_local_m, double encumbrance_m, double eta);

/// Cells, centroids and rules of one agent: all of (2.3) to (2.20). Between updates it only stores beta, theta and phi.
class RblPlanner {
 public:
  RblPlanner(const RblCellConfig& config, const RblRules& rules, bool planar);

  /// Resets S (between the heights, local frame) and cuts it by the neighbors. Obstacles may then cut cell() further.
  void partition(const Vector3& p_local_m, std::span<const Vector3> neighbors_local_m, double z_min_m, double z_max_m);

  struct Step {
    Vector3 centroid_local_m = Vector3::Zero();     ///< c_A, the target position
    Vector3 sensing_local_m = Vector3::Zero();      ///< c_S
    Vector3 unrotated_local_m = Vector3::Zero();    ///< c_A with the goal as destination
    Vector3 destination_local_m = Vector3::Zero();  ///< d of the next update
    bool empty_cell = false;
  };
  /// Computes the centroids with the last destination, then applies the rules, then sets the next destination.
  Step update(const Vector3& goal_local_m, double dt_s);

  RblCell& cell() { return cell_; }
  const RblCell& cell() const { return cell_; }
  std::vector<HalfSpace>& cuts() { return cuts_; }
  /// Cuts added from now on are hard, unlike those of neighbors, which may yield: an empty cell violates soft cuts
  /// first.
  void harden() { num_soft_ = cuts_.size(); }
  const std::vector<HalfSpace>& cuts() const { return cuts_; }
  const RblState& state() const { return state_; }
  const Vector3& p_local_m() const { return p_local_m_; }

 private:
  RblCellConfig config_;
  RblRules rules_;
  bool planar_;
  RblCell cell_;
  std::vector<HalfSpace> cuts_;
  std::size_t num_soft_ = std::numeric_limits<std::size_t>::max();
  RblState state_;
  Vector3 p_local_m_ = Vector3::Zero();
  double z_low_m_ = 0.0, z_high_m_ = 0.0;  // height limits relative to the agent
};

}  // namespace swiftlet
