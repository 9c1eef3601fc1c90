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

#include "core/guidance/heading.hpp"
#include "core/guidance/path_overlay.hpp"
#include "core/guidance/rbl_sight.hpp"
#include "swiftlet/core/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr double kShortestToFace_m = 0.3;  // nearer than this, a direction is noise
constexpr double kPressed_m = 0.01;        // farther behind a plane, there is no time to look around
constexpr double kHurry = 3.0;
constexpr double kLongUnseen_s = 5.0;   // then doubt says little about where somebody is
constexpr double kDoubtLeaves_m = 1.0;  // of the cell by then; one cut at the vehicle itself drives it away, on and on
constexpr double kComing_mps = 0.5;     // slower than this, nobody need be dodged
constexpr double kComes_sigmas = 0.5;   // of the speed, above which it is taken for one that comes
constexpr double kFaster_sigmas = 0.5;  // by which it may come faster than it seems
constexpr std::size_t kDodgedAtOnce = 64;  // tracks that end and begin anew are others
constexpr double kMostBeside_m = 0.5;      // that it may pass nearer than it seems
constexpr double kDodge_s = 0.5;           // before somebody's braking way comes too near, who then does not brake
constexpr double kOutOfPlane_s = 1.5;      // after that nobody came any more, it returns to its plane
constexpr double kSameHeight_m = 0.3;      // of one no higher than that above, it gets out of the way upwards
constexpr double kWatch_s = 3.0;           // before two meet as they fly now, they keep each other in view
constexpr double kPledged_s = 1.0;         // beyond two samples and those lost, for which one keeps to its pledges
constexpr double kLookAround = 2.0;        // times the longest interval of samples, before it starts
constexpr double kSeldom_s = 0.5;          // an interval of samples that is worth waiting for
constexpr double kAims_m = 1.0;            // that it aims ahead where its cell holds it on its path
constexpr double kUnseen_m = 0.2;          // the same where that leads out of its view: up or down
constexpr double kSeesFree_radii = 2.0;    // sensing radii as far as it sees that a place is free
constexpr double kHeightStep_m = 0.2;      // by which it asks what is above and below
constexpr double kLeastEdge_deg = 5.0, kMostEdge_deg = 60.0;  // of a view, as far as a goal is looked at by it
constexpr double kBetweenSamples = 0.87;                      // steps: half the diagonal between samples
constexpr double kFar_m = std::numeric_limits<double>::infinity();

/// Of the sensors of neighbors; infinite when they have no limit, or there is none.
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
    dodged_.reserve(std::max<std::size_t>(kDodgedAtOnce, static_cast<std::size_t>(setup.agent.num_vehicles)));
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
      // Who has to make way for somebody is not held by what may be where it goes.
      planner_.partition(p_local_m, neighbors_local_m_, z_min_m(), z_max_m());
      cut_by_braking(p_local_m, 0.0, now);
    }
    if (config_.lidar.enabled) cut_by_obstacles(T_local_body);
    step_ = planner_.update(next_goal_local_m(p_local_m, now), 1.0 / config_.update_rate_hz);
    from_local_m_ = goal_.position_m;
    to_local_m_ = next_local_m(T_local_body, now);
    if (config_.separation.enabled) keep_apart(T_local_body, now);
    if (planar_) to_local_m_.z() = out_of_the_way_local_m(p_local_m, now);
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
    if (detour_.gave_up()) return {MissionStatus::kFailed, detour_.note()};
    return {MissionStatus::kRunning, *detour_.note() != '\0' ? detour_.note() : settled.note};
  }

  /// Where it flies to if nobody is in its way. Who gives way does so at once: there is no time to look first.
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

  /// The goal, or the next point of a path around what keeps the vehicle from it.
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

  /// How far beside the goal the vehicle has it between the planes of its sensor, at its own height.
  double sees_goal_from_m(const Vector3& p_local_m) const {
    if (planar_) return 0.0;
    const double up_m = goal_local_m_.z() - p_local_m.z();
    const double edge_deg =
        up_m < 0.0 ? config_.lidar.fov_lower_deg : config_.lidar.fov_deg - config_.lidar.fov_lower_deg;
    const double steepest = elementary::tan(std::clamp(edge_deg, kLeastEdge_deg, kMostEdge_deg) * kRadPerDeg);
    return std::abs(up_m) / steepest + config_.cells.encumbrance_m;
  }

  /// Looks where it flies, waits until it sees, and flies no faster than it can stop.
  void keep_apart(const Pose& T_local_body, TimeNs now) {
    const Vector3 p_local_m = T_local_body.translation();
    if (!config_.lidar.enabled) {
      goal_.yaw_rad =
          sight_.heading(T_local_body, to_local_m_, neighbors_.neighbors(), coming_local_m_, goal_.yaw_rad, now);
      if (!pressed_ && !sight_.sees_ahead(T_local_body, to_local_m_)) to_local_m_ = reference_.rest_local_m();
    }
    if (!pressed_ && looks_around(now)) to_local_m_ = reference_.rest_local_m();
    if (pressed_) {
      to_local_m_ = hurry_local_m(p_local_m);
      braking_cuts_.insert(braking_cuts_.end(), obstacle_cuts_.begin(), obstacle_cuts_.end());
    }
    to_local_m_ =
        reference_.admit(from_local_m_, to_local_m_, braking_cuts_, p_local_m, to_seconds(period_), speed_mps());
  }

  /// The governor goes slowly to what is near. Whoever gives way aims farther, as far as it is admitted. That leads
  /// neither below nor above the heights of flight, nor beyond what it senses, nor into an obstacle.
  Vector3 hurry_local_m(const Vector3& p_local_m) const {
    const Vector3 aside_m = to_local_m_ - p_local_m;
    double farther = kHurry;
    if (config_.lidar.enabled) farther = std::min(farther, config_.cells.sensing_radius_m / aside_m.norm());
    for (const HalfSpace& cut : obstacle_cuts_) {
      const double towards_m = cut.normal_local.dot(aside_m);
      if (towards_m > 0.0) farther = std::min(farther, cut.offset_m / towards_m);
    }
    Vector3 hurried_local_m = p_local_m + std::max(farther, 1.0) * aside_m;
    hurried_local_m.z() =
        std::clamp(hurried_local_m.z(), std::min(z_min_m(), p_local_m.z()), std::max(z_max_m(), p_local_m.z()));
    return hurried_local_m;
  }

  /// The height of a vehicle in a plane: that of its goal, or above or below somebody who flies on whatever it meets.
  ///
  /// In a crowd nobody may have the room to step aside in the plane. The level distance to all others is kept on the
  /// way, so that nobody else is above or below.
  double out_of_the_way_local_m(const Vector3& p_local_m, TimeNs now) {
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

  /// As far up or down as there is room in the map, and as it has been or looked there.
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

  /// Cells of vehicles that can stop: neither crosses the plane between their braking ways.
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
      // What the other's way v t + v^2 / 2a would be if it came faster.
      const double closing_mps = d > 0.0 ? std::max(0.0, -v_local_mps.dot(to_other_local_m) / d) : 0.0;
      const double way_s = reaction_s + closing_mps / limits_.horizontal_acceleration_mps2;
      const double sigma_m =
          sigma(neighbor.covariance_local_m2) + way_s * sigma(neighbor.velocity_covariance_local_m2ps2);
      const double vertical_m = planar_ ? distance_m : separation.vertical_m;
      // Whoever keeps to what it pledged is not feared beyond that, but for how badly its place is known.
      const double seen_m = sigmas * sigma(neighbor.seen_covariance_local_m2);
      const double unsure_m = is_pledged(neighbor, now) ? std::min(seen_m, sigmas * sigma_m) : sigmas * sigma_m;
      const HalfSpace cut = braking_cut(self, other, distance_m, vertical_m, unsure_m);
      pressed_ = pressed_ || cut.offset_m < -kPressed_m;
      double cell_m = cut.offset_m;
      if (to_seconds(now - neighbor.seen) > kLongUnseen_s) {
        const double sure_m = braking_cut(self, other, distance_m, vertical_m, 0.0).offset_m;
        cell_m = std::max(cell_m, std::min(sure_m, kDoubtLeaves_m));
      }
      keep_behind(cut, cell_m);
      const double meeting_mps = d > 0.0 ? (v_own_mps - v_local_mps).dot(to_other_local_m) / d : 0.0;
      if (meeting_mps > kComing_mps && d - distance_m < kWatch_s * meeting_mps)
        coming_local_m_.push_back(other_local_m);
      // Who brakes is slow by now. Who is seen badly comes faster than it seems: at first it is believed to stand.
      const double speed_sigma_mps = sigma(neighbor.velocity_covariance_local_m2ps2);
      if (closing_mps > std::max(kComing_mps, kComes_sigmas * speed_sigma_mps)) {
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
      // It may stop where it would stop anyway.
      const double least_m = std::max(0.0, pledged.normal_local.dot(self.stop_local_m - self.p_local_m));
      pledged.offset_m = std::max(pledged.offset_m, least_m);
      keep_behind(pledged);
    }
    if (!pressed_) return;
    for (const HalfSpace& cut : braking_cuts_) planner_.cell().cut(cut);  // who hurries aims where it may go at once
  }
  /// Out of the way of somebody who comes and does not brake, always to the same side.
  void dodge(const Braking& self, const Neighbor& neighbor, double comes_in_s, double distance_m, double vertical_m,
             TimeNs now) {
    const Vector3 other_local_m = level(neighbor.position_local_m), v_local_mps = level(neighbor.velocity_local_mps);
    std::erase_if(dodged_, [&](const Dodged& dodged) { return now - dodged.t > from_seconds(kOutOfPlane_s); });
    const auto known =
        std::find_if(dodged_.begin(), dodged_.end(), [&](const Dodged& dodged) { return dodged.key == neighbor.key; });
    // It may pass nearer than it seems.
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
  /// How badly it is known on which side somebody passes after that time.
  static double side_sigma_m(const Neighbor& neighbor, const Vector3& v_local_mps, double time_s) {
    const Vector3 across(v_local_mps.y(), -v_local_mps.x(), 0.0);
    if (across.norm() < kComing_mps) return 0.0;
    const Vector3 side = across.normalized();
    return std::sqrt(side.dot(neighbor.covariance_local_m2 * side) +
                     time_s * time_s * side.dot(neighbor.velocity_covariance_local_m2ps2 * side));
  }
  void keep_behind(const HalfSpace& cut) { keep_behind(cut, cut.offset_m); }
  /// What bounds the cell may lie farther than what bounds the way.
  void keep_behind(const HalfSpace& cut, double cell_offset_m) {
    braking_cuts_.push_back(cut);
    if (cell_offset_m >= config_.cells.sensing_radius_m) return;
    planner_.cuts().push_back({cut.normal_local, cell_offset_m});
    planner_.cell().cut(planner_.cuts().back());
  }
  /// Nobody flies faster than it could stop before whom it does not see yet.
  double speed_mps() const {
    if (!config_.separation.enabled || range_m_ == kFar_m) return config_.speed_mps;
    const double unknown_s =
        neighbors_.longest_s() + neighbors_.latency_s() + config_.separation.reaction_s + to_seconds(period_);
    return std::min(config_.speed_mps,
                    speed_into_unknown_mps(range_m_, unknown_s, apart_m(), limits_.horizontal_acceleration_mps2));
  }
  /// Where many samples are lost, somebody next to it may not have been seen yet.
  bool looks_around(TimeNs now) const {
    const double longest_s = neighbors_.longest_s();
    return longest_s > kSeldom_s && to_seconds(now - started_) < kLookAround * longest_s;
  }
  /// Until the next sample of a neighbor should have come, it may count on what was pledged.
  double pledged_for_s() const { return neighbors_.shortest_s() + neighbors_.latency_s() + to_seconds(period_); }
  /// The vehicle itself keeps to it for longer: samples may be lost.
  double kept_for_s() const { return 2.0 * pledged_for_s() + neighbors_.longest_s() + kPledged_s; }
  bool is_pledged(const Neighbor& neighbor, TimeNs now) const {
    return config_.separation.pledge_share > 0.0 && neighbors_.shortest_s() > 0.0 &&
           to_seconds(now - neighbor.seen) <= pledged_for_s();
  }
  /// Between two centers that are level with each other.
  double apart_m() const { return 2.0 * config_.cells.encumbrance_m + config_.separation.margin_m; }
  Vector3 level(const Vector3& v) const { return planar_ ? Vector3(v.x(), v.y(), 0.0) : v; }

  /// Without the limits of (2.14) the ground is one.
  double z_min_m() const {
    return to_local_.height(clipped_ ? config_.z_min_m : config_.ground_m + config_.cells.encumbrance_m);
  }
  /// Who flies in a plane leaves it upwards only as far.
  double z_max_m() const {
    if (planar_) return std::max(to_local_.height(config_.z_max_m), goal_local_m_.z());
    return to_local_.height(clipped_ ? config_.z_max_m : kFar_m);
  }

  /// What the map shows bounds the cell. With no room left it counts before the neighbors, who may make way.
  void cut_by_obstacles(const Pose& T_local_body) {
    const Vector3 p_local_m = T_local_body.translation();
    const std::size_t first = planner_.cuts().size();
    if (config_.separation.enabled) planner_.harden();
    cut_by(planner_.cell(), planner_.cuts(), p_local_m, kEver);
    const bool needs_planes = config_.lidar.cut == RblLidarConfig::Cut::kNearest && config_.separation.enabled &&
                              (pressed_ || planner_.cell().is_empty());
    if (needs_planes) {
      cutter_.convex_planes(p_local_m, voxels_local_m_, map_->edge_m(), config_.cells.encumbrance_m, config_.cells.eta,
                            planner_.cuts());
    }
    obstacle_cuts_.assign(planner_.cuts().begin() + static_cast<std::ptrdiff_t>(first), planner_.cuts().end());
    viewed_.look(p_local_m, yaw_of(T_local_body.linear()), level_view(T_local_body.linear()));
  }

  /// Cuts a cell by the voxels hit since then. What lies deeper below the lowest flight level than the vehicle needs
  /// for itself cannot be met.
  void cut_by(RblCell& cell, std::vector<HalfSpace>& cuts, const Vector3& p_local_m, TimeNs since) {
    const RblCellConfig& cells = config_.cells;
    const double edge_m = map_->edge_m();
    map_->occupied_within(p_local_m, cells.sensing_radius_m / cells.eta + cells.encumbrance_m, since, voxels_local_m_);
    const double floor_m = std::min(z_min_m(), p_local_m.z()) - cells.encumbrance_m - 0.5 * edge_m;
    std::erase_if(voxels_local_m_, [&](const Vector3& voxel_local_m) { return voxel_local_m.z() < floor_m; });
    if (config_.lidar.cut == RblLidarConfig::Cut::kConvex) {
      cutter_.cut_convex(cell, p_local_m, voxels_local_m_, edge_m, cells.encumbrance_m, cells.eta, cuts);
    } else {
      cutter_.cut_nearest(cell, p_local_m, voxels_local_m_, edge_m, cells.encumbrance_m, cells.eta);
    }
  }

  /// The centroid when it lies in the cell A' that is sensed now, else the nearest place that does; turns to it, and
  /// stays until it faces it [Kamler 2025, sec. 3.3.1]. A goal within the own encumbrance is flown to without: one
  /// right above or below would never come into sight.
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

  /// A goal nearly above or below does not come into view, but it may have been seen.
  std::optional<Vector3> down_to_goal_local_m(const Vector3& p_local_m) const {
    const bool is_near = (goal_local_m_ - p_local_m).norm() <= config_.cells.sensing_radius_m;
    if (!config_.separation.enabled || !is_near) return std::nullopt;
    return slowly_local_m(p_local_m, step_.centroid_local_m - p_local_m);
  }

  bool faces(const Pose& T_local_body) const {
    const double off_rad = std::remainder(goal_.yaw_rad - yaw_of(T_local_body.linear()), 2.0 * kPi);
    return std::abs(off_rad) <= config_.lidar.facing_deg * kRadPerDeg;
  }

  /// What it sees while it is level: whoever speeds up bows its sensor for a moment.
  std::array<HalfSpace, 2> level_view(const Matrix3& R_local_body) const {
    const Vector3 ahead_local = Vector3(R_local_body(0, 0), R_local_body(1, 0), 0.0).normalized();
    Matrix3 R_local_level;
    R_local_level << ahead_local, Vector3::UnitZ().cross(ahead_local), Vector3::UnitZ();
    return field_of_view(R_local_level, config_.lidar.fov_lower_deg, config_.lidar.fov_deg, p_lidar_body_m_);
  }

  /// On the path where a cell holds the vehicle: turns to it, and flies there once it faces it. What is right above or
  /// below never comes into view. There it goes slowly, and only where it has been or looked as it came from farther
  /// away. Elsewhere its cell decides.
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

  /// The next bit of a way that is not in view, if the vehicle has been or looked there.
  std::optional<Vector3> slowly_local_m(const Vector3& p_local_m, const Vector3& way_m) const {
    const double length_m = way_m.norm();
    if (length_m <= 0.0) return std::nullopt;
    const Vector3 bit_m = std::min(1.0, kUnseen_m / length_m) * way_m;
    const Vector3 front_m = bit_m + config_.cells.encumbrance_m / length_m * way_m;
    if (!viewed_.contains(p_local_m + front_m, *map_)) return std::nullopt;
    return p_local_m + bit_m;
  }

  // The centroid jumps at every update; the vehicle's goal glides there until the next one, or each jump would shake
  // it. When every tick brings an update, there is no time to glide.
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
  const OccupancyView* map_ = nullptr;     // of this tick
  FrameChange to_local_;                   // of this tick
  Vector3 v_local_mps_ = Vector3::Zero();  // of this tick
  Vector3 goal_local_m_ = Vector3::Zero();
  RblCell sensed_;                            // A'
  Vector3 p_lidar_body_m_ = Vector3::Zero();  // of the first LiDAR, as its scans tell it
  std::vector<HalfSpace> sensed_cuts_;
  std::vector<Vector3> voxels_local_m_;
  ObstacleCutter cutter_;
  RblPlanner planner_;
  RblPlanner::Step step_;
  GuardedReference reference_;            // while vehicles keep apart by braking
  double range_m_;                        // of the sensor of neighbors
  std::vector<HalfSpace> braking_cuts_;   // relative to the vehicle
  std::vector<HalfSpace> obstacle_cuts_;  // the same
  std::vector<Vector3> coming_local_m_;   // who may have to be dodged
  struct Passing {
    TimeNs t = -1;  // negative: nobody yet
    double height_local_m = 0.0;
  };
  Passing passed_;             // the last one who came and did not brake
  std::optional<bool> rises_;  // out of its way: upwards
  struct Dodged {
    std::int64_t key = 0;
    TimeNs t = 0;
    Vector3 normal_local = Vector3::Zero();  // of the plane that it stepped behind
  };
  std::vector<Dodged> dodged_;  // of late, one each
  bool pressed_ = false;        // somebody comes too near: no time to look where it goes
  std::vector<Vector3> neighbors_local_m_;
  Vector3 from_local_m_ = Vector3::Zero(), to_local_m_ = Vector3::Zero();  // the goal on its way between two updates
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

// What has no color of its own is drawn in the vehicle's.
void Rbl::append_overlays(std::vector<Overlay>& overlays) const {
  const RblCell& cell = planner_.cell();
  const Vector3& p_local_m = planner_.p_local_m();
  const auto place = [&](const Vector3& q) { return Eigen::Vector3f((p_local_m + q).cast<float>()); };
  // Of a ball the slice at the agent's height is shown: the whole would hide what it explains.
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
  // The destination lies far away: its direction is what matters.
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
          "[s] no nearer to the goal for so long, the vehicle says what is there, or that it lies out of the limits; "
          "0: never",
          Range::non_negative());
  v.field("update_rate_hz", update_rate_hz, "[Hz] of cells, rules and the centroid to fly to",
          Range::between(1e-3, 1e5));
  v.field("speed_mps", speed_mps, "[m/s] at most, below the motion limits", Range::positive());
  v.field("ground_m", ground_m,
          "[m] height of the ground in 3d, which has no limits of height; the encumbrance above it is kept");
  v.field("z_min_m", z_min_m, "[m] lowest flight level (2.14)");
  v.field("z_max_m", z_max_m, "[m] highest flight level (2.14)");
  v.object("cells", cells, "cells S and A");
  v.object("rules", rules, "weighting, azimuth and elevation rules");
  v.object("separation", separation, "what keeps vehicles apart where their cells alone do not");
  v.object("neighbors", neighbors, "where the neighbors are known from");
  v.object("lidar", lidar, "obstacles");
  // With a map the vehicle keeps clear of what is at its goal, and reports it (settle_s).
  if (variant != Variant::k2d && !lidar.enabled) v.destinations("goal_m", goal_m);
  v.object("detour", detour, "the way out of a pocket between obstacles");
  v.check(z_max_m > z_min_m, "z_max_m", "more than z_min_m");
}

std::unique_ptr<Guidance> make_rbl(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Rbl>(dynamic_cast<const RblConfig&>(config), setup);
}

}  // namespace swiftlet
