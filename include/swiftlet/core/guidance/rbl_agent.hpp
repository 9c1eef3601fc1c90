// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/guidance/rbl_config.hpp"

namespace swiftlet {

/// Rule-based Lloyd algorithm of one agent, step by step, for analysis outside of a flight: cells, centroids and rules,
/// (2.3) to (2.20) and (3.1). Between steps it only stores beta, theta and phi.
class RblAgent {
 public:
  /// @param planar  cells are discs in the agent's horizontal plane instead of balls
  RblAgent(const RblCellConfig& config, const RblRules& rules, bool planar);
  RblAgent(RblAgent&& other) noexcept;
  RblAgent& operator=(RblAgent&& other) noexcept;
  ~RblAgent();

  /// Situation of the agent in one step.
  struct Situation {
    Vector3 p_local_m = Vector3::Zero();
    std::span<const Vector3> neighbors_local_m = {};
    Vector3 goal_local_m = Vector3::Zero();
    double z_min_m = 0.0, z_max_m = 100.0;         ///< height limits in the local frame
    std::span<const Vector3> voxels_local_m = {};  ///< centers of occupied voxels
    double voxel_edge_m = 0.2;
  };
  struct Step {
    Vector3 centroid_local_m = Vector3::Zero();     ///< c_A, the target position
    Vector3 sensing_local_m = Vector3::Zero();      ///< c_S
    Vector3 destination_local_m = Vector3::Zero();  ///< d of the next step
    bool empty_cell = false;
    double beta_m = 0.0;
    double theta_rad = 0.0;  ///< rotation of the destination to the right
    double phi_rad = 0.0;    ///< rotation of the destination upward
  };
  /// Computes the centroids with the last destination, then applies the rules, then sets the next destination.
  Step step(const Situation& situation, double dt_s);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace swiftlet
