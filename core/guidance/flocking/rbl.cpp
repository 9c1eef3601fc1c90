// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/guidance/flocking/rbl_detour.hpp"
#include "core/guidance/flocking/rbl_lidar.hpp"
#include "core/guidance/flocking/rbl_overlays.hpp"
#include "core/guidance/flocking/rbl_planner.hpp"
#include "core/guidance/flocking/rbl_settling.hpp"
#include "core/guidance/gliding_goal.hpp"
#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/path_overlay.hpp"
#include "core/guidance/separation/neighbor_memory.hpp"
#include "core/guidance/separation/neighbor_safety.hpp"

namespace swiftlet {
namespace {

RblRules rules_of(const RblConfig& config) {
  RblRules rules = config.rules;
  rules.elevation_rule = config.variant == RblConfig::Variant::k3dZ;
  return rules;
}

/// One update [Kamler 2025]: the cell S is cut by neighbors (2.3), braking planes and obstacles (3.1); the goal glides
/// to the centroid of the remaining cell A (2.5, 2.10), and the rules (2.7 to 2.20) adapt weighting and destination.
/// The equations of chapter 2 are in RblPlanner, those of chapter 3 in RblLidar; NeighborSafety is not in the document.
class Rbl : public Guidance {
 public:
  Rbl(const RblConfig& config, const GuidanceSetup& setup)
      : config_(config),
        planar_(config.variant == RblConfig::Variant::k2d),
        clipped_(config.variant == RblConfig::Variant::k3dClipped || config.variant == RblConfig::Variant::k3dZ),
        period_(from_seconds(kUpdatePeriod_s)),
        neighbors_(config.neighbors, setup.agent.neighbor_views),
        planner_(config.cells, rules_of(config), planar_),
        settling_(config.settle_s),
        detour_(config.detour, config.cells.sensing_radius_m) {
    goal_.position_m = setup.agent.T_local_body_start.translation();
    goal_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
    neighbors_local_m_.reserve(static_cast<std::size_t>(setup.agent.num_vehicles));
    if (config.lidar.enabled) lidar_.emplace(config, planar_);
    if (!config.separation.enabled) return;
    safety_.emplace(config.separation, NeighborSafety::Vehicle{.limits = setup.limits,
                                                               .views = setup.agent.neighbor_views,
                                                               .encumbrance_m = config.cells.encumbrance_m,
                                                               .period = period_,
                                                               .planar = planar_,
                                                               .num_vehicles = setup.agent.num_vehicles,
                                                               .turns = !config.lidar.enabled});
  }

  GuidanceNeeds needs() const override {
    return {.map = config_.lidar.enabled,
            .neighbors = config_.neighbors.source == NeighborSourceConfig::Source::kSensor};
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    const TimeNs now = input.observation.t;
    to_local_ = FrameChange::to_local(input.estimate);
    goal_local_m_ = to_local_.point(config_.goal_m);
    map_ = config_.lidar.enabled ? input.map : nullptr;
    if (lidar_ && !input.observation.scans.empty())
      lidar_->mount(input.observation.scans.front()->T_body_lidar.translation());
    neighbors_.update(input);
    if (safety_ && next_update_ == 0) safety_->start(input.estimate);
    if (now >= next_update_) {
      next_update_ = next_update_ == 0 ? now + period_ : next_update_ + period_;
      plan(input.estimate, now);
      neighbors_.announce(input.estimate, outbox);
    }
    Vector3 to_goal_local_m = goal_local_m_ - input.estimate.T_local_body.translation();
    if (planar_) to_goal_local_m.z() = 0.0;
    arrived_ = arrived_ || to_goal_local_m.norm() <= config_.arrival_radius_m;
    goal_.position_m = glide_.at(now, next_update_, period_, from_seconds(input.dt_s));
    output.goal_is_feasible = safety_.has_value();
    output.goal = safety_ ? safety_->step(goal_, input.dt_s, speed_mps()) : goal_;
    output.speed_limit_mps = speed_mps();
    output.mission = arrived_ ? MissionStatus::kDone : status_.mission;
    output.note = arrived_ ? "" : status_.note;
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    if (map_ != nullptr) append_rbl_voxels(*map_, planner_.p_local_m(), overlays);
    if (detour_.on_path()) {
      Overlay path = path_overlay("rbl.path", detour_.corners_local_m(), 3.0F);
      path.kind = Overlay::Kind::kPolyline;
      overlays.push_back(std::move(path));
    }
    append_rbl_overlays(planner_, step_, goal_local_m_, overlays);
  }

  void append_counters(std::vector<Counter>& counters) const override {
    if (!config_.lidar.enabled || !config_.detour.enabled) return;
    counters.push_back({"detour searches that ended at their budget", detour_.num_given_up(), detour_.num_plans(),
                        "detour.planner.max_expansions"});
  }

 private:
  void plan(const StateEstimate& estimate, TimeNs now) {
    const Vector3 p_local_m = estimate.T_local_body.translation();
    const NeighborSafety::Situation situation{
        estimate, neighbors_.neighbors(), neighbors_.timing(), z_min_m(), z_max_m(), now};
    cut_cell(situation);
    step_ = planner_.update(detour_goal_local_m(p_local_m, now), kUpdatePeriod_s);
    glide_ = {goal_.position_m, step_.centroid_local_m};
    if (lidar_) look_ahead(estimate.T_local_body, now);
    if (safety_) keep_apart(situation);
    if (planar_) glide_.to_local_m.z() = height_local_m(situation);
    status_ = status(p_local_m, now);
  }

  /// The cell A: S cut by the neighbors, the planes of the separation and the obstacles.
  void cut_cell(const NeighborSafety::Situation& situation) {
    const Vector3 p_local_m = situation.estimate.T_local_body.translation();
    neighbors_local_m_.clear();
    for (const Neighbor& neighbor : situation.neighbors) neighbors_local_m_.push_back(neighbor.position_local_m);
    planner_.partition(p_local_m, neighbors_local_m_, z_min_m(), z_max_m());
    if (safety_) cut_by_separation(situation, false);
    if (safety_ && planner_.cell().is_empty()) {
      planner_.partition(p_local_m, neighbors_local_m_, z_min_m(), z_max_m());
      cut_by_separation(situation, true);
    }
    if (lidar_) lidar_->cut(in_map(situation.estimate.T_local_body, situation.now), planner_);
  }

  void cut_by_separation(const NeighborSafety::Situation& situation, bool certain) {
    safety_->update(situation, certain);
    for (const HalfSpace& plane : safety_->planes()) {
      if (plane.offset_m >= config_.cells.sensing_radius_m) continue;
      planner_.cuts().push_back(plane);
      planner_.cell().cut(plane);
    }
  }

  /// Limits the goal to the sensed part of the cell, and turns the LiDAR to it. An evading vehicle flies to the
  /// centroid without waiting for the turn.
  void look_ahead(const Pose& T_local_body, TimeNs now) {
    const RblLidar::Situation here = in_map(T_local_body, now);
    if (safety_ && safety_->evades()) {
      goal_.yaw_rad = RblLidar::heading_to(here, step_.centroid_local_m, goal_.yaw_rad);
      return;
    }
    glide_.to_local_m =
        lidar_->next_local_m(here, planner_.cell(), step_.centroid_local_m, detour_.straight_local_m(), goal_.yaw_rad);
  }

  void keep_apart(const NeighborSafety::Situation& situation) {
    NeighborSafety::Goal wanted{glide_.from_local_m, glide_.to_local_m, goal_.yaw_rad, speed_mps()};
    wanted = lidar_ ? safety_->admit(situation, wanted, lidar_->cuts()) : safety_->admit(situation, wanted);
    glide_.to_local_m = wanted.position_local_m;
    goal_.yaw_rad = wanted.yaw_rad;
  }

  /// Height [m] at which a planar vehicle flies: that of the goal, or of an evasion.
  double height_local_m(const NeighborSafety::Situation& situation) {
    const double goal_m = goal_local_m_.z();
    if (!safety_) return goal_m;
    const std::optional<double> evasion_m = safety_->evasion_height_local_m(situation, goal_m);
    if (!evasion_m) return goal_m;
    return lidar_ ? lidar_->clear_height_local_m(in_map(situation.estimate.T_local_body, situation.now), *evasion_m)
                  : *evasion_m;
  }

  /// The goal, or the next point of the detour around an obstacle.
  Vector3 detour_goal_local_m(const Vector3& p_local_m, TimeNs now) {
    const double up_m = goal_local_m_.z() - p_local_m.z();
    return detour_.next_goal_local_m({.goal_local_m = goal_local_m_,
                                      .p_local_m = p_local_m,
                                      .z_min_m = z_min_m(),
                                      .z_max_m = z_max_m(),
                                      .encumbrance_m = config_.cells.encumbrance_m,
                                      .planar = planar_,
                                      .sees_goal_from_m = lidar_ && !planar_ ? lidar_->sees_goal_from_m(up_m) : 0.0,
                                      .neighbors = neighbors_.neighbors(),
                                      .map = map_,
                                      .now = now});
  }

  RblStatus status(const Vector3& p_local_m, TimeNs now) {
    const RblGoal goal{.p_local_m = goal_local_m_,
                       .z_min_m = z_min_m(),
                       .z_max_m = z_max_m(),
                       .reach_m = config_.cells.sensing_radius_m,
                       .encumbrance_m = config_.cells.encumbrance_m,
                       .apart_m = config_.separation.distance_m(config_.cells.encumbrance_m),
                       .planar = planar_};
    const OccupancyView* map = detour_.is_looking() ? nullptr : map_;
    const RblStatus settled = settling_.update(goal, p_local_m, neighbors_.neighbors(), map, now);
    if (settled.mission != MissionStatus::kRunning) return settled;
    if (detour_.has_failed()) return {MissionStatus::kFailed, detour_.note()};
    return {MissionStatus::kRunning, *detour_.note() != '\0' ? detour_.note() : settled.note};
  }

  RblLidar::Situation in_map(const Pose& T_local_body, TimeNs now) const {
    return {T_local_body, *map_, goal_local_m_, z_min_m(), z_max_m(), now};
  }

  double speed_mps() const {
    return safety_ ? std::min(config_.speed_mps, safety_->speed_limit_mps(neighbors_.timing())) : config_.speed_mps;
  }

  /// Without the limits of (2.14), the encumbrance above the ground is the lowest height.
  double z_min_m() const {
    return to_local_.height(clipped_ ? config_.z_min_m : config_.ground_m + config_.cells.encumbrance_m);
  }
  /// Also bounds the height to which a planar vehicle evades.
  double z_max_m() const {
    if (planar_) return std::max(to_local_.height(config_.z_max_m), goal_local_m_.z());
    return to_local_.height(clipped_ ? config_.z_max_m : std::numeric_limits<double>::infinity());
  }

  RblConfig config_;
  bool planar_, clipped_;
  TimeNs period_, next_update_ = 0;
  const OccupancyView* map_ = nullptr;  // from this tick's input; null without LiDAR mode
  FrameChange to_local_;                // from this tick's input
  Vector3 goal_local_m_ = Vector3::Zero();
  NeighborMemory neighbors_;
  std::vector<Vector3> neighbors_local_m_;
  RblPlanner planner_;
  RblPlanner::Step step_;
  std::optional<RblLidar> lidar_;
  std::optional<NeighborSafety> safety_;
  GlidingGoal glide_;
  Reference goal_;
  bool arrived_ = false;
  RblSettling settling_;
  RblStatus status_;
  RblDetour detour_;
};

}  // namespace

std::unique_ptr<Guidance> make_rbl(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Rbl>(dynamic_cast<const RblConfig&>(config), setup);
}

}  // namespace swiftlet
