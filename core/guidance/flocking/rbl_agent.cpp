// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl_agent.hpp"

#include "core/guidance/flocking/rbl_obstacles.hpp"
#include "core/guidance/flocking/rbl_planner.hpp"

namespace swiftlet {

struct RblAgent::Parts {
  RblCellConfig config;
  RblPlanner planner;
  ObstacleCutter cutter;
};

RblAgent::RblAgent(const RblCellConfig& config, const RblRules& rules, bool planar)
    : parts_(std::make_unique<Parts>(Parts{config, RblPlanner(config, rules, planar), {}})) {}
RblAgent::RblAgent(RblAgent&&) noexcept = default;
RblAgent& RblAgent::operator=(RblAgent&&) noexcept = default;
RblAgent::~RblAgent() = default;

RblAgent::Step RblAgent::step(const Situation& situation, double dt_s) {
  RblPlanner& planner = parts_->planner;
  planner.partition(situation.p_local_m, situation.neighbors_local_m, situation.z_min_m, situation.z_max_m);
  if (!situation.voxels_local_m.empty()) {
    parts_->cutter.cut(planner.cell(), situation.p_local_m, situation.voxels_local_m, situation.voxel_edge_m,
                       parts_->config.encumbrance_m, parts_->config.eta, planner.cuts());
  }
  const RblPlanner::Step step = planner.update(situation.goal_local_m, dt_s);
  const RblState& state = planner.state();
  return {.centroid_local_m = step.centroid_local_m,
          .sensing_local_m = step.sensing_local_m,
          .destination_local_m = step.destination_local_m,
          .empty_cell = step.empty_cell,
          .beta_m = state.beta_m,
          .theta_rad = state.theta_rad,
          .phi_rad = state.phi_rad};
}

}  // namespace swiftlet
