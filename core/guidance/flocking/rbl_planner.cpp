// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_planner.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

double offset_of(RblCellConfig::Cut cut, double d, double Delta, double eta) {
  if (cut == RblCellConfig::Cut::kBuffered) return 0.5 * (d - Delta);
  if (cut == RblCellConfig::Cut::kContinued) return Delta + eta * (d - 2.0 * Delta);
  return obstacle_offset_m(d, Delta, eta);  // as in the authors' program: the plane is at least Delta from the neighbor
}

}  // namespace

HalfSpace neighbor_cut(const Vector3& to_neighbor_local_m, double Delta_m, double eta, RblCellConfig::Cut cut) {
  return {unit_along(to_neighbor_local_m), offset_of(cut, to_neighbor_local_m.norm(), Delta_m, eta)};
}

HalfSpace obstacle_cut(const Vector3& to_point_local_m, double encumbrance_m, double eta) {
  return {unit_along(to_point_local_m), obstacle_offset_m(to_point_local_m.norm(), encumbrance_m, eta)};
}

RblPlanner::RblPlanner(const RblCellConfig& config, const RblRules& rules, bool planar)
    : config_(config), rules_(rules), planar_(planar), cell_(config.sensing_radius_m, config.step_m, planar) {
  state_.beta_m = rules.beta_desired_m;
  cuts_.reserve(256);
}

void RblPlanner::partition(const Vector3& p_local_m, std::span<const Vector3> neighbors_local_m, double z_min_m,
                           double z_max_m) {
  p_local_m_ = p_local_m;
  // The cell of an agent outside the height limits keeps one layer of samples next to them, so that S is not empty.
  z_low_m_ = std::min(z_min_m - p_local_m.z(), config_.sensing_radius_m - config_.step_m);
  z_high_m_ = std::max(z_max_m - p_local_m.z(), -config_.sensing_radius_m + config_.step_m);
  cell_.reset(config_.lattice == RblCellConfig::Lattice::kWorld ? Vector3(-p_local_m) : Vector3(Vector3::Zero()),
              z_low_m_, z_high_m_);
  cuts_.clear();
  num_soft_ = std::numeric_limits<std::size_t>::max();
  const double Delta_m = 2.0 * config_.encumbrance_m;
  for (const Vector3& neighbor_local_m : neighbors_local_m) {
    Vector3 to_local_m = neighbor_local_m - p_local_m;
    if (planar_) to_local_m.z() = 0.0;
    if (to_local_m.norm() > config_.sensing_radius_m / config_.eta + Delta_m)
      continue;  // the neighbor's plane does not cut S
    cuts_.push_back(neighbor_cut(to_local_m, Delta_m, config_.eta, config_.cut));
    cell_.cut(cuts_.back());
  }
}

RblPlanner::Step RblPlanner::update(const Vector3& goal_local_m, double dt_s) {
  Vector3 to_goal_local_m = goal_local_m - p_local_m_;
  if (planar_) to_goal_local_m.z() = 0.0;
  const Vector3 destination_agent_m = rbl_destination(rules_, to_goal_local_m, state_);
  const CellCentroids centroids = cell_.centroids(destination_agent_m, state_.beta_m);

  RblSituation now;
  now.goal_agent_m = to_goal_local_m;
  now.sensing_agent_m = centroids.sensing_agent_m;
  Step step;
  step.empty_cell = cell_.is_empty();
  if (step.empty_cell) {
    now.partitioned_agent_m = now.unrotated_agent_m = cell_.least_violating(cuts_, num_soft_);
  } else {
    const bool turned = state_.theta_rad != 0.0 || state_.phi_rad != 0.0;
    now.partitioned_agent_m = centroids.partitioned_agent_m;
    now.unrotated_agent_m =
        turned ? cell_.partitioned_centroid(to_goal_local_m, state_.beta_m) : centroids.partitioned_agent_m;
  }
  state_ = apply_rules(rules_, now, state_, dt_s, planar_);
  step.centroid_local_m = p_local_m_ + now.partitioned_agent_m;
  step.sensing_local_m = p_local_m_ + now.sensing_agent_m;
  step.unrotated_local_m = p_local_m_ + now.unrotated_agent_m;
  step.destination_local_m = p_local_m_ + rbl_destination(rules_, to_goal_local_m, state_);
  return step;
}

}  // namespace swiftlet
