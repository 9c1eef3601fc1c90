// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/guidance/flocking/guarded_reference.hpp"
#include "core/guidance/flocking/neighbor_memory.hpp"
#include "core/guidance/flocking/rbl_detour.hpp"
#include "core/guidance/flocking/rbl_separation.hpp"
#include "core/guidance/flocking/rbl_settling.hpp"
#include "core/guidance/flocking/rbl_sight.hpp"
#include "core/guidance/flocking/rbl_viewed.hpp"
#include "core/guidance/heading.hpp"
#include "core/guidance/path_overlay.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr double kShortestToFace_m = 0.3;  // shorter displacements give no heading
// Violation of a plane beyond which the vehicle evades without turning its sensor first.
constexpr double kPressed_m = 0.01;
// An evading vehicle's goal lies at most this many times as far away as planned. Larger values make it evade faster.
constexpr double kGoalExtension = 3.0;
// Neighbors unseen for longer than this no longer shrink the cell below kMinCellSize_m. Larger values slow the team
// down after a dropout.
constexpr double kLongUnseen_s = 5.0;
// Smallest cell radius left by the uncertainty of a neighbor unseen for long. At 0 the vehicle retreats indefinitely
// from a lost neighbor.
constexpr double kMinCellSize_m = 1.0;
constexpr double kClosing_mps = 0.5;  // lowest closing speed of a neighbor that is evaded
// A neighbor counts as approaching if its closing speed exceeds this many of its standard deviations.
constexpr double kClosing_sigmas = 0.5;
constexpr double kFaster_sigmas = 0.5;  // standard deviations added to the closing speed of an approaching neighbor
// Reserved capacity: a track that is lost and found again takes a second entry.
constexpr std::size_t kDodgedCapacity = 64;
constexpr double kMostBeside_m = 0.5;  // largest margin for the lateral uncertainty of an approaching neighbor
constexpr double kDodge_s = 0.5;       // time before the braking paths come too close at which evasion begins
constexpr double kOutOfPlane_s = 1.5;  // time after the last approach until the vehicle returns to its plane
constexpr double kSameHeight_m = 0.3;  // evades upwards unless the neighbor is higher by more than this
// Neighbors that meet the vehicle within this time at their present velocities stay in view.
constexpr double kMeetingHorizon_s = 3.0;
// Time for which the vehicle keeps its own pledge, beyond two samples and lost ones.
constexpr double kPledged_s = 1.0;
constexpr double kLookAround = 2.0;       // waiting time before the start, in longest sample intervals
constexpr double kShortInterval_s = 0.5;  // shorter sample intervals do not delay the start
constexpr double kAims_m = 1.0;           // distance of the goal on a straight part of the detour, in view
constexpr double kUnseen_m = 0.2;         // distance of that goal out of view, above or below
constexpr double kSeesFree_radii = 2.0;   // range within which a view proves a place free, in sensing radii
constexpr double kHeightStep_m = 0.2;     // step of the search for free height
constexpr double kLeastEdge_deg = 5.0, kMostEdge_deg = 60.0;  // bounds of the elevation of the view's edge
constexpr double kBetweenSamples = 0.87;                      // steps: half the diagonal between samples
constexpr double kFar_m = std::numeric_limits<double>::infinity();

/// Shortest range of the sensors that measure neighbors; infinite without a limit or a sensor.
double range_of(const AgentSetup& setup) {
  double range_m = kFar_m;
  for (const NeighborView& view : setup.neighbor_views) range_m = std::min(range_m, view.range_max_m);
  return range_m;
}

RblRules rules_of(const RblConfig& config) {
  RblRules rules = config.rules;
  rules.elevation_rule = rules.elevation_rule && config.variant == RblConfig::Variant::k3dZ;
  return rules;
}

class Rbl : public Guidance {
 public:
  Rbl(const RblConfig& config, const GuidanceSetup& setup)
      : config_(config),
        planar_(config.variant == RblConfig::Variant::k2d),
        clipped_(config.variant == RblConfig::Variant::k3dClipped || config.variant == RblConfig::Variant::k3dZ),
        period_(from_seconds(1.0 / config.update_rate_hz)),
        limits_(config.separation.enabled ? config.separation.within(setup.limits) : setup.limits),
        neighbors_(config.neighbors, setup.agent.neighbor_views),
        sensed_(config.cells.sensing_radius_m,
                config.lidar.enabled ? config.cells.step_m : config.cells.sensing_radius_m, planar_),
        planner_(config.cells, rules_of(config), planar_),
        reference_(limits_, planar_),
        range_m_(range_of(setup.agent)),
        settling_(config.settle_s),
        detour_(config.detour, config.cells.sensing_radius_m),
        viewed_(kSeesFree_radii * config.cells.sensing_radius_m, config.cells.encumbrance_m),
        sight_(setup.agent.neighbor_views) {
    goal_.position_m = setup.agent.T_local_body_start.translation();
    goal_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
    neighbors_local_m_.reserve(static_cast<std::size_t>(setup.agent.num_vehicles));
    coming_local_m_.reserve(static_cast<std::size_t>(setup.agent.num_vehicles));
    dodged_.reserve(std::max<std::size_t>(kDodgedCapacity, static_cast<std::size_t>(setup.agent.num_vehicles)));
    braking_cuts_.reserve(3 * static_cast<std::size_t>(setup.agent.num_vehicles));
  }

  GuidanceNeeds needs() const override {
    return {.map = config_.lidar.enabled,
            .neighbors = config_.neighbors.source == NeighborSourceConfig::Source::kSensor};
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    const Pose& T_local_body = input.estimate.T_local_body;
    to_local_ = FrameChange::to_local(input.estimate);
    goal_local_m_ = to_local_.point(config_.goal_m);
    map_ = input.map;
    v_local_mps_ = input.estimate.v_local_mps;
    if (!input.observation.scans.empty()) {
      p_lidar_body_m_ = input.observation.scans.front()->T_body_lidar.translation();
    }
    neighbors_.update(input);
    if (next_update_ == 0) start(input.estimate, input.observation.t);
    if (input.observation.t >= next_update_) {
      next_update_ = next_update_ == 0 ? input.observation.t + period_ : next_update_ + period_;
      plan(input.estimate, input.observation.t);
      neighbors_.announce(input.estimate, outbox);
    }
    Vector3 to_goal_local_m = goal_local_m_ - T_local_body.translation();
    if (planar_) to_goal_local_m.z() = 0.0;
    arrived_ = arrived_ || to_goal_local_m.norm() <= config_.arrival_radius_m;
    glide(input.observation.t, from_seconds(input.dt_s));
    output.goal_is_feasible = config_.separation.enabled;
    output.goal = output.goal_is_feasible ? reference_.step(goal_, input.dt_s, speed_mps()) : goal_;
    output.speed_limit_mps = speed_mps();
    output.mission = arrived_ ? MissionStatus::kDone : status_.mission;
    output.note = arrived_ ? "" : status_.note;
  }

  void append_overlays(std::vector<Overlay>& overlays) const override;

  void append_counters(std::vector<Counter>& counters) const override {
    if (!config_.lidar.enabled || !config_.detour.enabled) return;
    counters.push_back({"searches for a path that were given up", detour_.num_given_up(), detour_.num_plans(),
                        "detour.planner.max_expansions"});
  }

 private:
  void start(const StateEstimate& estimate, TimeNs now) {
    started_ = now;
    Reference here;
    here.position_m = estimate.T_local_body.translation();
    here.velocity_mps = estimate.v_local_mps;
    here.yaw_rad = yaw_of(estimate.T_local_body.linear());
    reference_.reset(here);
  }

  void plan(const StateEstimate& estimate, TimeNs now) {
    const Pose& T_local_body = estimate.T_local_body;
    const Vector3 p_local_m = T_local_body.translation();
    neighbors_local_m_.clear();
    for (const Neighbor& neighbor : neighbors_.neighbors()) neighbors_local_m_.push_back(neighbor.position_local_m);
    planner_.partition(p_local_m, neighbors_local_m_, z_min_m(), z_max_m());
    if (config_.separation.enabled) cut_by_braking(p_local_m, config_.separation.sigmas, now);
    if (config_.separation.enabled && planner_.cell().is_empty()) {
      // The uncertainty of neighbors in the direction of evasion does not stop an evading vehicle.
      planner_.partition(p_local_m, neighbors_local_m_, z_min_m(), z_max_m());
      cut_by_braking(p_local_m, 0.0, now);
    }
    if (config_.lidar.enabled) cut_by_obstacles(T_local_body);
    step_ = planner_.update(next_goal_local_m(p_local_m, now), 1.0 / config_.update_rate_hz);
    from_local_m_ = goal_.position_m;
    to_local_m_ = next_local_m(T_local_body, now);
    if (config_.separation.enabled) keep_apart(T_local_body, now);
    if (planar_) to_local_m_.z() = evading_goal_local_m(p_local_m, now);
    status_ = status(p_local_m, now);
  }

  RblStatus status(const Vector3& p_local_m, TimeNs now) {
    const RblGoal goal{.p_local_m = goal_local_m_,
                       .z_min_m = z_min_m(),
                       .z_max_m = z_max_m(),
                       .reach_m = config_.cells.sensing_radius_m,
                       .encumbrance_m = config_.cells.encumbrance_m,
                       .apart_m = apart_m(),
                       .planar = planar_};
    const OccupancyView* map = config_.lidar.enabled && !detour_.is_looking() ? map_ : nullptr;
    const RblStatus settled = settling_.update(goal, p_local_m, neighbors_.neighbors(), map, now);
    if (settled.mission != MissionStatus::kRunning) return settled;
    if (detour_.has_failed()) return {MissionStatus::kFailed, detour_.note()};
    return {MissionStatus::kRunning, *detour_.note() != '\0' ? detour_.note() : settled.note};
  }

  /// Next goal without neighbors in the path. An evading vehicle takes the centroid at once, without looking first.
  Vector3 next_local_m(const Pose& T_local_body, TimeNs now) {
    if (!config_.lidar.enabled) return step_.centroid_local_m;
    if (pressed_) {
      const Vector3 to_centroid_local_m = step_.centroid_local_m - T_local_body.translation();
      goal_.yaw_rad = heading_along(to_centroid_local_m, kShortestToFace_m, goal_.yaw_rad);
      return step_.centroid_local_m;
    }
    if (detour_.straight_local_m()) return straight_on(T_local_body, *detour_.straight_local_m(), now);
    return within_sight(T_local_body, now);
  }

  /// The goal, or the next point of the detour around an obstacle.
  Vector3 next_goal_local_m(const Vector3& p_local_m, TimeNs now) {
    return detour_.next_goal_local_m({.goal_local_m = goal_local_m_,
                                      .p_local_m = p_local_m,
                                      .z_min_m = z_min_m(),
                                      .z_max_m = z_max_m(),
                                      .encumbrance_m = config_.cells.encumbrance_m,
                                      .planar = planar_,
                                      .sees_goal_from_m = sees_goal_from_m(p_local_m),
                                      .neighbors = neighbors_.neighbors(),
                                      .map = config_.lidar.enabled ? map_ : nullptr,
                                      .now = now});
  }

  /// Horizontal distance from the goal at which the goal lies within the vertical field of view, at the vehicle's
  /// height.
  double sees_goal_from_m(const Vector3& p_local_m) const {
    if (planar_) return 0.0;
    const double up_m = goal_local_m_.z() - p_local_m.z();
    const double edge_deg =
        up_m < 0.0 ? config_.lidar.fov_lower_deg : config_.lidar.fov_deg - config_.lidar.fov_lower_deg;
    const double steepest = elementary::tan(std::clamp(edge_deg, kLeastEdge_deg, kMostEdge_deg) * kRadPerDeg);
    return std::abs(up_m) / steepest + config_.cells.encumbrance_m;
  }

  /// Turns the sensor along the flight, waits until the vehicle sees its path, and limits the goal to where it can
  /// stop.
  void keep_apart(const Pose& T_local_body, TimeNs now) {
    const Vector3 p_local_m = T_local_body.translation();
    if (!config_.lidar.enabled) {
      goal_.yaw_rad =
          sight_.heading(T_local_body, to_local_m_, neighbors_.neighbors(), coming_local_m_, goal_.yaw_rad, now);
      if (!pressed_ && !sight_.sees_ahead(T_local_body, to_local_m_)) to_local_m_ = reference_.rest_local_m();
    }
    if (!pressed_ && looks_around(now)) to_local_m_ = reference_.rest_local_m();
    if (pressed_) {
      to_local_m_ = extended_goal_local_m(p_local_m);
      braking_cuts_.insert(braking_cuts_.end(), obstacle_cuts_.begin(), obstacle_cuts_.end());
    }
    to_local_m_ =
        reference_.admit(from_local_m_, to_local_m_, braking_cuts_, p_local_m, to_seconds(period_), speed_mps());
  }

  /// The governor approaches near goals slowly, so the goal of an evading vehicle lies farther away. It stays within
  /// the heights of flight, the sensing radius and the obstacle planes.
  Vector3 extended_goal_local_m(const Vector3& p_local_m) const {
    const Vector3 aside_m = to_local_m_ - p_local_m;
    double farther = kGoalExtension;
    if (config_.lidar.enabled) farther = std::min(farther, config_.cells.sensing_radius_m / aside_m.norm());
    for (const HalfSpace& cut : obstacle_cuts_) {
      const double towards_m = cut.normal_local.dot(aside_m);
      if (towards_m > 0.0) farther = std::min(farther, cut.offset_m / towards_m);
    }
    Vector3 extended_local_m = p_local_m + std::max(farther, 1.0) * aside_m;
    extended_local_m.z() =
        std::clamp(extended_local_m.z(), std::min(z_min_m(), p_local_m.z()), std::max(z_max_m(), p_local_m.z()));
    return extended_local_m;
  }

  /// Height of a planar vehicle: that of its goal, or above or below a neighbor that does not brake.
  ///
  /// A crowd may leave no room to evade in the plane. The horizontal distance to all others is kept meanwhile, so that
  /// no other vehicle is above or below.
  double evading_goal_local_m(const Vector3& p_local_m, TimeNs now) {
    const RblSeparationConfig& separation = config_.separation;
    const double height_m = goal_local_m_.z();
    if (!separation.enabled || passed_.t < 0 || now - passed_.t > from_seconds(kOutOfPlane_s)) {
      rises_.reset();
      return height_m;
    }
    const auto to_m = [&](bool rises) { return passed_.height_local_m + (rises ? 1.0 : -1.0) * separation.vertical_m; };
    const auto is_free = [&](bool rises) { return rises ? to_m(true) <= z_max_m() : to_m(false) >= z_min_m(); };
    if (!rises_) rises_ = p_local_m.z() >= passed_.height_local_m - kSameHeight_m;
    if (!is_free(*rises_) && is_free(!*rises_)) rises_ = !*rises_;
    const double aside_m = *rises_ ? std::max(height_m, to_m(true)) : std::min(height_m, to_m(false));
    const double within_m = std::clamp(aside_m, std::min(z_min_m(), height_m), std::max(z_max_m(), height_m));
    return config_.lidar.enabled ? clear_height_local_m(p_local_m, within_m) : within_m;
  }

  /// Height nearest to the wanted one that the map shows free and the vehicle has viewed, step by step.
  double clear_height_local_m(const Vector3& p_local_m, double wanted_m) const {
    const double encumbrance_m = config_.cells.encumbrance_m;
    const double up = wanted_m >= p_local_m.z() ? 1.0 : -1.0;
    double clear_m = p_local_m.z();
    while (clear_m != wanted_m) {
      const double next_m = std::abs(wanted_m - clear_m) <= kHeightStep_m ? wanted_m : clear_m + up * kHeightStep_m;
      const Vector3 next_local_m(p_local_m.x(), p_local_m.y(), next_m);
      const Vector3 beyond_local_m = next_local_m + Vector3(0.0, 0.0, up * encumbrance_m);
      if (map_->distance_m(next_local_m, encumbrance_m) < encumbrance_m) break;
      if (!viewed_.contains(beyond_local_m, *map_)) break;
      clear_m = next_m;
    }
    return clear_m;
  }

  /// Cuts the cell by the planes between the braking paths, which neither vehicle crosses.
  void cut_by_braking(const Vector3& p_local_m, double sigmas, TimeNs now) {
    const RblSeparationConfig& separation = config_.separation;
    const double distance_m = apart_m();
    const double reaction_s = separation.reaction_s + to_seconds(period_);
    const Vector3 here_local_m = level(p_local_m);
    const Braking self{here_local_m, level(reference_.rest_local_m())};
    braking_cuts_.clear();
    coming_local_m_.clear();
    const Vector3 v_own_mps = level(v_local_mps_);
    pressed_ = false;
    double nearest_m = kFar_m;
    for (const Neighbor& neighbor : neighbors_.neighbors()) {
      const Vector3 other_local_m = level(neighbor.position_local_m);
      const Vector3 v_local_mps = level(neighbor.velocity_local_mps);
      const Braking other = braking_of(other_local_m, v_local_mps, reaction_s + neighbor.unpredicted_s, limits_);
      const Vector3 to_other_local_m = other_local_m - self.p_local_m;
      const double d = to_other_local_m.norm();
      const auto sigma = [&](const Matrix3& covariance) {
        return d > 0.0 ? std::sqrt(to_other_local_m.dot(covariance * to_other_local_m)) / d : 0.0;
      };
      // Derivative of the neighbor's stopping distance v t + v^2 / 2a with respect to its closing speed.
      const double closing_mps = d > 0.0 ? std::max(0.0, -v_local_mps.dot(to_other_local_m) / d) : 0.0;
      const double velocity_gain_s = reaction_s + closing_mps / limits_.horizontal_acceleration_mps2;
      const double sigma_m =
          sigma(neighbor.covariance_local_m2) + velocity_gain_s * sigma(neighbor.velocity_covariance_local_m2ps2);
      const double vertical_m = planar_ ? distance_m : separation.vertical_m;
      // While a neighbor's pledge holds, only the uncertainty of its last measured position counts.
      const double seen_m = sigmas * sigma(neighbor.seen_covariance_local_m2);
      const double uncertainty_m = is_pledged(neighbor, now) ? std::min(seen_m, sigmas * sigma_m) : sigmas * sigma_m;
      const HalfSpace cut = braking_cut(self, other, distance_m, vertical_m, uncertainty_m);
      pressed_ = pressed_ || cut.offset_m < -kPressed_m;
      double cell_m = cut.offset_m;
      if (to_seconds(now - neighbor.seen) > kLongUnseen_s) {
        const double sure_m = braking_cut(self, other, distance_m, vertical_m, 0.0).offset_m;
        cell_m = std::max(cell_m, std::min(sure_m, kMinCellSize_m));
      }
      keep_behind(cut, cell_m);
      const double meeting_mps = d > 0.0 ? (v_own_mps - v_local_mps).dot(to_other_local_m) / d : 0.0;
      if (meeting_mps > kClosing_mps && d - distance_m < kMeetingHorizon_s * meeting_mps)
        coming_local_m_.push_back(other_local_m);
      // A braking neighbor is already slow. A poorly measured one is taken to be faster: its filter starts at rest.
      const double speed_sigma_mps = sigma(neighbor.velocity_covariance_local_m2ps2);
      if (closing_mps > std::max(kClosing_mps, kClosing_sigmas * speed_sigma_mps)) {
        const double faster_mps = closing_mps + kFaster_sigmas * speed_sigma_mps;
        const Braking faster = braking_of(other_local_m, faster_mps / closing_mps * v_local_mps,
                                          reaction_s + neighbor.unpredicted_s, limits_);
        const double sure_m = braking_cut(self, faster, distance_m, vertical_m, 0.0).offset_m;
        if (sure_m < 0.5 * kDodge_s * faster_mps) {
          if (d < nearest_m) {
            nearest_m = d;
            passed_ = {now, neighbor.position_local_m.z()};
          }
          dodge(self, neighbor, d / closing_mps, distance_m, vertical_m, now);
        }
      }
      if (separation.pledge_share <= 0.0 || to_seconds(now - neighbor.seen) > kept_for_s()) continue;
      HalfSpace pledged = pledged_cut(level(neighbor.own_seen_local_m), level(neighbor.seen_local_m), self.p_local_m,
                                      distance_m, vertical_m, seen_m, separation.pledge_share);
      // The plane leaves the vehicle's own point of rest.
      const double least_m = std::max(0.0, pledged.normal_local.dot(self.stop_local_m - self.p_local_m));
      pledged.offset_m = std::max(pledged.offset_m, least_m);
      keep_behind(pledged);
    }
    if (!pressed_) return;
    // The cell of an evading vehicle respects the full planes.
    for (const HalfSpace& cut : braking_cuts_) planner_.cell().cut(cut);
  }
  /// Evades a neighbor that approaches without braking, always to the same side.
  void dodge(const Braking& self, const Neighbor& neighbor, double comes_in_s, double distance_m, double vertical_m,
             TimeNs now) {
    const Vector3 other_local_m = level(neighbor.position_local_m), v_local_mps = level(neighbor.velocity_local_mps);
    std::erase_if(dodged_, [&](const Dodged& dodged) { return now - dodged.t > from_seconds(kOutOfPlane_s); });
    const auto known =
        std::find_if(dodged_.begin(), dodged_.end(), [&](const Dodged& dodged) { return dodged.key == neighbor.key; });
    // Margin for the neighbor's lateral uncertainty.
    const double aside_m = distance_m + std::min(kMostBeside_m, side_sigma_m(neighbor, v_local_mps, comes_in_s));
    const auto beside = dodging_cut(self, other_local_m, v_local_mps, aside_m, vertical_m * aside_m / distance_m,
                                    limits_, known != dodged_.end() ? &known->normal_local : nullptr);
    if (!beside) return;
    pressed_ = pressed_ || beside->offset_m < -kPressed_m;
    keep_behind(*beside);
    const Dodged dodged{neighbor.key, now, beside->normal_local};
    if (known != dodged_.end()) {
      *known = dodged;
    } else {
      dodged_.push_back(dodged);
    }
  }
  /// Standard deviation of the neighbor's lateral position after that time.
  static double side_sigma_m(const Neighbor& neighbor, const Vector3& v_local_mps, double time_s) {
    const Vector3 across(v_local_mps.y(), -v_local_mps.x(), 0.0);
    if (across.norm() < kClosing_mps) return 0.0;
    const Vector3 side = across.normalized();
    return std::sqrt(side.dot(neighbor.covariance_local_m2 * side) +
                     time_s * time_s * side.dot(neighbor.velocity_covariance_local_m2ps2 * side));
  }
  void keep_behind(const HalfSpace& cut) { keep_behind(cut, cut.offset_m); }
  /// @param cell_offset_m  offset of the plane for the cell, which may be larger than the one for the goal
  void keep_behind(const HalfSpace& cut, double cell_offset_m) {
    braking_cuts_.push_back(cut);
    if (cell_offset_m >= config_.cells.sensing_radius_m) return;
    planner_.cuts().push_back({cut.normal_local, cell_offset_m});
    planner_.cell().cut(planner_.cuts().back());
  }
  /// Highest speed at which the vehicle can stop before a neighbor that enters the sensing range.
  double speed_mps() const {
    if (!config_.separation.enabled || range_m_ == kFar_m) return config_.speed_mps;
    const double unknown_s =
        neighbors_.longest_s() + neighbors_.latency_s() + config_.separation.reaction_s + to_seconds(period_);
    return std::min(config_.speed_mps,
                    speed_into_unknown_mps(range_m_, unknown_s, apart_m(), limits_.horizontal_acceleration_mps2));
  }
  /// With long sample intervals, a near neighbor may not have been measured yet.
  bool looks_around(TimeNs now) const {
    const double longest_s = neighbors_.longest_s();
    return longest_s > kShortInterval_s && to_seconds(now - started_) < kLookAround * longest_s;
  }
  /// Time after a sample during which the neighbor counts as keeping its pledge.
  double pledged_for_s() const { return neighbors_.shortest_s() + neighbors_.latency_s() + to_seconds(period_); }
  /// Time for which the vehicle keeps its own pledge; longer, because samples may be lost.
  double kept_for_s() const { return 2.0 * pledged_for_s() + neighbors_.longest_s() + kPledged_s; }
  bool is_pledged(const Neighbor& neighbor, TimeNs now) const {
    return config_.separation.pledge_share > 0.0 && neighbors_.shortest_s() > 0.0 &&
           to_seconds(now - neighbor.seen) <= pledged_for_s();
  }
  /// Horizontal distance to keep between two centers.
  double apart_m() const { return 2.0 * config_.cells.encumbrance_m + config_.separation.margin_m; }
  Vector3 level(const Vector3& v) const { return planar_ ? Vector3(v.x(), v.y(), 0.0) : v; }

  /// Without the limits of (2.14), the encumbrance above the ground is the lowest height.
  double z_min_m() const {
    return to_local_.height(clipped_ ? config_.z_min_m : config_.ground_m + config_.cells.encumbrance_m);
  }
  /// Also bounds the height to which a planar vehicle evades.
  double z_max_m() const {
    if (planar_) return std::max(to_local_.height(config_.z_max_m), goal_local_m_.z());
    return to_local_.height(clipped_ ? config_.z_max_m : kFar_m);
  }

  /// Cuts the cell by occupied voxels. If no room is left, obstacles take precedence over neighbors, which may yield.
  void cut_by_obstacles(const Pose& T_local_body) {
    const Vector3 p_local_m = T_local_body.translation();
    const std::size_t first = planner_.cuts().size();
    if (config_.separation.enabled) planner_.harden();
    cut_by(planner_.cell(), planner_.cuts(), p_local_m, kEver);
    obstacle_cuts_.assign(planner_.cuts().begin() + static_cast<std::ptrdiff_t>(first), planner_.cuts().end());
    viewed_.look(p_local_m, yaw_of(T_local_body.linear()), level_view(T_local_body.linear()));
  }

  /// Cuts a cell by the voxels hit since then. Voxels below the lowest flight level by more than the encumbrance cannot
  /// be met.
  void cut_by(RblCell& cell, std::vector<HalfSpace>& cuts, const Vector3& p_local_m, TimeNs since) {
    const RblCellConfig& cells = config_.cells;
    const double edge_m = map_->edge_m();
    map_->occupied_within(p_local_m, cells.sensing_radius_m / cells.eta + cells.encumbrance_m, since, voxels_local_m_);
    const double floor_m = std::min(z_min_m(), p_local_m.z()) - cells.encumbrance_m - 0.5 * edge_m;
    std::erase_if(voxels_local_m_, [&](const Vector3& voxel_local_m) { return voxel_local_m.z() < floor_m; });
    cutter_.cut(cell, p_local_m, voxels_local_m_, edge_m, cells.encumbrance_m, cells.eta, cuts);
  }

  /// The centroid if it lies in the presently sensed cell A', else the nearest sample of A'. The vehicle turns towards
  /// it, and stays until the heading is reached [Kamler 2025, sec. 3.3.1]. A goal within the own encumbrance is
  /// approached without turning, because right above or below the vehicle it would never come into view.
  Vector3 within_sight(const Pose& T_local_body, TimeNs now) {
    const Vector3 p_local_m = T_local_body.translation();
    const Vector3 to_centroid_local_m = step_.centroid_local_m - p_local_m;
    goal_.yaw_rad = heading_along(to_centroid_local_m, kShortestToFace_m, goal_.yaw_rad);
    if ((goal_local_m_ - p_local_m).norm() <= config_.cells.encumbrance_m) return step_.centroid_local_m;
    const bool whole_cell = config_.lidar.legal == RblLidarConfig::Legal::kCell;
    if (whole_cell) {
      sensed_ = planner_.cell();
    } else {
      sensed_.reset(Vector3::Zero(), z_min_m() - p_local_m.z(), z_max_m() - p_local_m.z());
    }
    for (const HalfSpace& cut :
         field_of_view(T_local_body.linear(), config_.lidar.fov_lower_deg, config_.lidar.fov_deg, p_lidar_body_m_)) {
      sensed_.cut(cut);
    }
    sensed_cuts_.clear();
    if (!whole_cell) cut_by(sensed_, sensed_cuts_, p_local_m, now - from_seconds(config_.lidar.sensed_s));
    const int sample = sensed_.nearest_partitioned(to_centroid_local_m);
    if (sample >= 0 && !faces(T_local_body)) return T_local_body.translation();
    const Vector3 seen_agent_m = sample >= 0 ? sensed_.point(sample) : Vector3::Zero();
    const bool inside =
        sample >= 0 && (seen_agent_m - to_centroid_local_m).norm() <= kBetweenSamples * sensed_.step_m();
    if (inside) return step_.centroid_local_m;
    if (const auto blindly_local_m = down_to_goal_local_m(p_local_m)) return *blindly_local_m;
    return p_local_m + seen_agent_m;
  }

  /// A goal nearly above or below does not come into view, but may have been viewed before.
  std::optional<Vector3> down_to_goal_local_m(const Vector3& p_local_m) const {
    const bool is_near = (goal_local_m_ - p_local_m).norm() <= config_.cells.sensing_radius_m;
    if (!config_.separation.enabled || !is_near) return std::nullopt;
    return slowly_local_m(p_local_m, step_.centroid_local_m - p_local_m);
  }

  bool faces(const Pose& T_local_body) const {
    const double off_rad = std::remainder(goal_.yaw_rad - yaw_of(T_local_body.linear()), 2.0 * kPi);
    return std::abs(off_rad) <= config_.lidar.facing_deg * kRadPerDeg;
  }

  /// Field of view of the level vehicle: acceleration tilts the sensor for a moment.
  std::array<HalfSpace, 2> level_view(const Matrix3& R_local_body) const {
    const Vector3 ahead_local = Vector3(R_local_body(0, 0), R_local_body(1, 0), 0.0).normalized();
    Matrix3 R_local_level;
    R_local_level << ahead_local, Vector3::UnitZ().cross(ahead_local), Vector3::UnitZ();
    return field_of_view(R_local_level, config_.lidar.fov_lower_deg, config_.lidar.fov_deg, p_lidar_body_m_);
  }

  /// On a detour where the cell holds the vehicle: turns along the path, and flies once the heading is reached. A place
  /// right above or below never comes into view; the vehicle approaches it slowly, and only where it has been or has
  /// viewed from farther away. Elsewhere its cell decides.
  Vector3 straight_on(const Pose& T_local_body, const Vector3& next_local_m, TimeNs now) {
    const Vector3 p_local_m = T_local_body.translation();
    const Vector3 to_next_m = next_local_m - p_local_m;
    goal_.yaw_rad = heading_along(to_next_m, kShortestToFace_m, goal_.yaw_rad);
    if (!faces(T_local_body)) return p_local_m;
    const auto ahead_m = [&](double m) -> Vector3 {
      return std::min(1.0, m / std::max(to_next_m.norm(), kShortestToFace_m)) * to_next_m;
    };
    const std::array<HalfSpace, 2> view = level_view(T_local_body.linear());
    const bool in_view = std::all_of(view.begin(), view.end(), [&](const HalfSpace& side) {
      return side.normal_local.dot(to_next_m) <= std::max(side.offset_m, 0.0);
    });
    if (in_view) return p_local_m + ahead_m(kAims_m);
    const auto blindly_local_m = slowly_local_m(p_local_m, to_next_m);
    return blindly_local_m ? *blindly_local_m : within_sight(T_local_body, now);
  }

  /// Next short step outside the view, if the vehicle has been or viewed there.
  std::optional<Vector3> slowly_local_m(const Vector3& p_local_m, const Vector3& displacement_m) const {
    const double length_m = displacement_m.norm();
    if (length_m <= 0.0) return std::nullopt;
    const Vector3 bit_m = std::min(1.0, kUnseen_m / length_m) * displacement_m;
    const Vector3 front_m = bit_m + config_.cells.encumbrance_m / length_m * displacement_m;
    if (!viewed_.contains(p_local_m + front_m, *map_)) return std::nullopt;
    return p_local_m + bit_m;
  }

  // The centroid jumps at every update. The goal moves there linearly until the next one, because the governor would
  // respond to each jump with full jerk. Without ticks between updates the goal jumps, too.
  void glide(TimeNs now, TimeNs tick) {
    const bool jumps = period_ <= tick;
    const double left = jumps ? 0.0 : std::clamp(to_seconds(next_update_ - now) / to_seconds(period_), 0.0, 1.0);
    goal_.position_m = left * from_local_m_ + (1.0 - left) * to_local_m_;
  }

  RblConfig config_;
  bool planar_, clipped_;
  TimeNs period_, next_update_ = 0, started_ = 0;
  MotionLimits limits_;
  NeighborMemory neighbors_;
  const OccupancyView* map_ = nullptr;     // from this tick's input
  FrameChange to_local_;                   // from this tick's input
  Vector3 v_local_mps_ = Vector3::Zero();  // from this tick's input
  Vector3 goal_local_m_ = Vector3::Zero();
  RblCell sensed_;                            // A'
  Vector3 p_lidar_body_m_ = Vector3::Zero();  // mounting position of the first LiDAR, from its scans
  std::vector<HalfSpace> sensed_cuts_;
  std::vector<Vector3> voxels_local_m_;
  ObstacleCutter cutter_;
  RblPlanner planner_;
  RblPlanner::Step step_;
  GuardedReference reference_;            // used with `separation`
  double range_m_;                        // range of the sensors of neighbors
  std::vector<HalfSpace> braking_cuts_;   // relative to the vehicle
  std::vector<HalfSpace> obstacle_cuts_;  // relative to the vehicle
  std::vector<Vector3> coming_local_m_;   // approaching neighbors, which stay in view
  struct Passing {
    TimeNs t = -1;  // negative: none yet
    double height_local_m = 0.0;
  };
  Passing passed_;             // the last neighbor that approached without braking
  std::optional<bool> rises_;  // evades it upwards; empty: no evasion
  struct Dodged {
    std::int64_t key = 0;
    TimeNs t = 0;
    Vector3 normal_local = Vector3::Zero();  // normal of the evasion plane
  };
  std::vector<Dodged> dodged_;  // recent evasions, one for each neighbor
  bool pressed_ = false;        // a plane is violated: evade at once
  std::vector<Vector3> neighbors_local_m_;
  Vector3 from_local_m_ = Vector3::Zero(), to_local_m_ = Vector3::Zero();  // goal at the last and at the next update
  Reference goal_;
  bool arrived_ = false;
  RblSettling settling_;
  RblStatus status_;
  RblDetour detour_;
  RblViewed viewed_;
  RblSight sight_;
};

Overlay marks(const char* name, Overlay::Kind kind, float size_m, std::vector<Eigen::Vector4f> colors = {}) {
  Overlay overlay;
  overlay.name = name;
  overlay.kind = kind;
  overlay.colors = std::move(colors);
  overlay.size_m = size_m;
  return overlay;
}

/// The cell A at the agent's height: the disc of S, cut by the half-spaces; corners in order, relative to the agent.
std::vector<Vector3> level_outline(double radius_m, std::span<const HalfSpace> cuts) {
  constexpr int kCorners = 72;
  std::vector<Vector3> corners, left;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    corners.emplace_back(radius_m * elementary::cos(angle), radius_m * elementary::sin(angle), 0.0);
  }
  for (const HalfSpace& cut : cuts) {
    left.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector3 &from = corners[i], &to = corners[(i + 1) % corners.size()];
      const double out_from = cut.normal_local.dot(from) - cut.offset_m,
                   out_to = cut.normal_local.dot(to) - cut.offset_m;
      if (out_from <= 0.0) left.push_back(from);
      if ((out_from <= 0.0) != (out_to <= 0.0)) left.push_back(from + out_from / (out_from - out_to) * (to - from));
    }
    corners.swap(left);
  }
  return corners;
}

// Overlays without a color take the vehicle's.
void Rbl::append_overlays(std::vector<Overlay>& overlays) const {
  const RblCell& cell = planner_.cell();
  const Vector3& p_local_m = planner_.p_local_m();
  const auto place = [&](const Vector3& q) { return Eigen::Vector3f((p_local_m + q).cast<float>()); };
  // For a ball, only the slice at the agent's height is shown.
  const std::vector<Vector3> corners = level_outline(cell.radius_m(), planner_.cuts());
  Overlay area = marks("rbl.cell", Overlay::Kind::kTriangles, 0.0F);
  Overlay outline = marks("rbl.cell_outline", Overlay::Kind::kPolyline, 2.0F);
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    for (const Vector3& corner : {corners.front(), corners[i], corners[i + 1]}) area.positions.push_back(place(corner));
  }
  for (std::size_t i = 0; i <= corners.size() && !corners.empty(); ++i) {
    outline.positions.push_back(place(corners[i % corners.size()]));
  }
  Overlay sensing = marks("rbl.sensing", Overlay::Kind::kPolyline, 1.0F, {{0.1F, 0.1F, 0.1F, 0.6F}});
  const std::vector<Vector3> disc = level_outline(cell.radius_m(), {});
  for (std::size_t i = 0; i <= disc.size(); ++i) sensing.positions.push_back(place(disc[i % disc.size()]));
  Overlay samples = marks("rbl.samples", Overlay::Kind::kPoints, 0.06F, {{0.05F, 0.05F, 0.05F, 0.8F}});
  for (int i = 0; i < cell.num_samples(); ++i) {
    const Vector3 q = cell.point(i);
    if (std::abs(q.z()) <= 0.51 * cell.step_m() && cell.contains(i)) samples.positions.push_back(place(q));
  }
  Overlay centroid = marks("rbl.centroid", Overlay::Kind::kSpheres, 0.16F);
  centroid.positions = {step_.centroid_local_m.cast<float>()};
  Overlay sensing_centroid =
      marks("rbl.sensing_centroid", Overlay::Kind::kSpheres, 0.1F, {{0.05F, 0.05F, 0.05F, 1.0F}});
  sensing_centroid.positions = {step_.sensing_local_m.cast<float>()};
  // The destination is far away, so only its direction is shown.
  const Vector3 to_destination = step_.destination_local_m - p_local_m;
  const double shown_m = std::min(to_destination.norm(), cell.radius_m() + 1.0);
  Overlay destination = marks("rbl.destination", Overlay::Kind::kLines, 3.0F);
  destination.positions = {p_local_m.cast<float>(), place(shown_m * to_destination.normalized())};
  Overlay goal = marks("rbl.goal", Overlay::Kind::kSpheres, 0.22F);
  goal.positions = {goal_local_m_.cast<float>()};
  if (config_.lidar.enabled && map_ != nullptr) {
    Overlay voxels =
        marks("rbl.voxels", Overlay::Kind::kCubes, static_cast<float>(map_->edge_m()), {{0.45F, 0.32F, 0.2F, 1.0F}});
    std::vector<Vector3> centers_local_m;
    map_->occupied_within(p_local_m, 12.0, kEver, centers_local_m);
    for (const Vector3& center_local_m : centers_local_m) voxels.positions.push_back(center_local_m.cast<float>());
    overlays.push_back(std::move(voxels));
  }
  if (detour_.on_path()) {
    Overlay path = path_overlay("rbl.path", detour_.corners_local_m(), 3.0F);
    path.kind = Overlay::Kind::kPolyline;
    overlays.push_back(std::move(path));
  }
  for (Overlay* overlay : {&area, &outline, &sensing, &samples, &centroid, &sensing_centroid, &destination, &goal}) {
    overlays.push_back(std::move(*overlay));
  }
}

}  // namespace

void RblConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "guidance",
          "preset: rbl_thesis (the document's own settings) or rbl_thesis_files (its authors' experiment files)");
  v.choice("variant", variant, kVariants,
           "[-] disc at one height; ball; ball between z_min_m and z_max_m (2.14); that with the z-rule (2.15-2.19)");
  v.field("goal_m", goal_m, "[m] world");
  v.field("arrival_radius_m", arrival_radius_m, "[m] nearer than this, the goal is reached (r_g)", Range::positive());
  v.field("settle_s", settle_s,
          "[s] time without progress after which the vehicle reports what is at its goal, or that it is out of limits; "
          "0: never",
          Range::non_negative());
  v.field("update_rate_hz", update_rate_hz, "[Hz] rate of updates of cells, rules and centroid",
          Range::between(1e-3, 1e5));
  v.field("speed_mps", speed_mps, "[m/s] at most, below the motion limits", Range::positive());
  v.field("ground_m", ground_m,
          "[m] height of the ground in 3d, which has no height limits; the vehicle stays an encumbrance above it");
  v.field("z_min_m", z_min_m, "[m] lowest flight level (2.14)");
  v.field("z_max_m", z_max_m, "[m] highest flight level (2.14)");
  v.object("cells", cells, "cells S and A");
  v.object("rules", rules, "weighting, azimuth and elevation rules");
  v.object("separation", separation, "braking planes, pledges and evasion beyond the cells of the document");
  v.object("neighbors", neighbors, "source of the neighbors");
  v.object("lidar", lidar, "obstacles");
  // With a map the vehicle keeps clear of what is at its goal, and reports it (settle_s).
  if (variant != Variant::k2d && !lidar.enabled) v.destinations("goal_m", goal_m);
  v.object("detour", detour, "detour out of a pocket between obstacles");
  v.check(z_max_m > z_min_m, "z_max_m", "more than z_min_m");
}

std::unique_ptr<Guidance> make_rbl(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Rbl>(dynamic_cast<const RblConfig&>(config), setup);
}

}  // namespace swiftlet
