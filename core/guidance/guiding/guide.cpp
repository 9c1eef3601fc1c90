// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/guide.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "core/guidance/guiding/guide_overlays.hpp"
#include "swiftlet/core/base/vehicle_named.hpp"
#include "swiftlet/core/math/latency.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"

namespace swiftlet {
namespace {

constexpr double kAtRest_mps = 0.25;  // slower vehicles count as hovering
constexpr double kClearBody_m = 0.6;  // clearance around the figure that a lost vehicle flies
constexpr double kLeastFigure_m = 0.3;
// Range of sight in multiples of the viewpoint's, since the guide flies to the next one.
constexpr double kSeenFarther = 1.5;
// Radius around a guided vehicle's estimate within which occupied cells may be the vehicle itself.
constexpr double kOwnRadius_m = 0.3;
// Remaining length of the guided vehicle's path at which the next leg is planned.
constexpr double kPlanAhead_m = 1.5;

/// The states of [Pritzl 2024, sec. II-A].
enum class GuideState { kIdle, kPlanning, kPrimaryMoving, kSecondaryMoving, kGoalReached, kFailure };

class Guide : public Guidance {
 public:
  Guide(const GuideConfig& config, const GuidanceSetup& setup)
      : config_(config),
        team_(team_of(config, setup.agent)),
        guiding_period_(from_seconds(1.0 / config.guiding_rate_hz)),
        planner_(config.planning_latency_s) {
    hold_.position_m = setup.agent.T_local_body_start.translation();
    hold_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
  }

  GuidanceNeeds needs() const override { return {.map = true, .relatives = true}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    now_ = input.observation.t;
    if (entered_ == kNever) enter(GuideState::kIdle);
    find_team(input);
    search(input);
    advance_state(input);
    send_messages(input, outbox);
    output.goal = hold_;
    output.speed_limit_mps = config_.speed_mps;
    fill(output);
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    if (!plan_) return;
    append_guide_overlays(*plan_, hold_.position_m.z(), overlays);
  }

  void append_counters(std::vector<Counter>& counters) const override {
    const char* what = "searches for a path that were given up";
    counters.push_back({what, num_given_up_primary_, num_plans_, "planner.primary.max_expansions"});
    counters.push_back({what, num_given_up_secondary_, num_plans_, "planner.secondary.max_expansions"});
  }

 private:
  static constexpr TimeNs kNever = std::numeric_limits<TimeNs>::min();

  void enter(GuideState state) {
    state_ = state;
    entered_ = now_;
  }
  bool waited(double seconds) const { return now_ - entered_ >= from_seconds(seconds); }

  /// State of a guided vehicle and its progress. One of them moves, the others hover.
  struct Guided {
    VehicleId id = kNoVehicle;
    std::vector<Eigen::Vector3d> goals_m;
    std::vector<double> goal_yaws_deg;
    std::optional<RelativeEstimate> estimate;  // from this tick's input
    bool known_well = false, linked = false, was_known = false;
    Vector3 last_place_local_m = Vector3::Zero();
    TimeNs last_known = 0;
    std::size_t num_reached = 0;
    std::optional<Vector3> began_local_m;
    double advanced_m = 0.0;

    bool ready() const { return known_well && linked; }
  };

  static std::vector<Guided> team_of(const GuideConfig& config, const AgentSetup& setup) {
    std::vector<Guided> team;
    const auto add = [&](const std::string& name, const char* key, const auto& goals_m, const auto& goal_yaws_deg) {
      Guided guided;
      guided.id = vehicle_named(name, setup, key);
      guided.goals_m = goals_m;
      guided.goal_yaws_deg = goal_yaws_deg;
      const bool twice = std::ranges::any_of(team, [&](const Guided& other) { return other.id == guided.id; });
      if (twice) throw std::invalid_argument(std::string(key) + ": expected each vehicle once, found it twice");
      team.push_back(std::move(guided));
    };
    if (config.secondaries.empty()) {
      add(config.secondary, "guidance.secondary", config.goals_m, config.goal_yaws_deg);
    }
    for (const GuidedVehicleConfig& one : config.secondaries) {
      add(one.name, "guidance.secondaries.name", one.goals_m, one.goal_yaws_deg);
    }
    return team;
  }

  Guided& moving() { return team_[moving_]; }
  const Guided& moving() const { return team_[moving_]; }
  /// Estimate of the moving vehicle; it must exist.
  const RelativeEstimate& there() const { return *team_[moving_].estimate; }

  /// Updates the estimates of the guided vehicles: known well enough to guide them, and linked.
  void find_team(const GuidanceInput& input) {
    for (Guided& guided : team_) {
      guided.estimate.reset();
      for (const RelativeEstimate& relative : input.relatives) {
        if (relative.other == guided.id) guided.estimate = relative;
      }
      guided.known_well =
          guided.estimate &&
          std::sqrt(guided.estimate->covariance.topLeftCorner<3, 3>().diagonal().maxCoeff()) < config_.sigma_max_m;
      guided.linked = guided.estimate && now_ - guided.estimate->report_t < from_seconds(config_.link_timeout_s);
      guided.was_known = guided.was_known || guided.ready();
      if (!guided.estimate) continue;
      guided.last_place_local_m = guided.estimate->position_m;
      guided.last_known = now_;
    }
  }

  /// The heading of a hovering vehicle is not observable. If the moving vehicle has no estimate any more, it is
  /// requested to fly a figure where its surroundings are clear, as before it was first found.
  void search(const GuidanceInput& input) {
    figure_m_ = 0.0;
    const Guided& lost = moving();
    if (lost.estimate || !lost.was_known || now_ - lost.last_known < from_seconds(config_.search_after_s)) return;
    double room_m = input.map->distance_m(lost.last_place_local_m, 2.0) - kClearBody_m;
    for (const Vector3& p_local_m : hovering_local_m()) {
      room_m = std::min(room_m, (p_local_m - lost.last_place_local_m).head<2>().norm() - 2.0 * kClearBody_m);
    }
    if (room_m >= kLeastFigure_m) figure_m_ = room_m;
  }

  /// Present or last known positions of the hovering vehicles.
  std::vector<Vector3> hovering_local_m() const {
    std::vector<Vector3> places_local_m;
    places_local_m.reserve(team_.size());
    for (const Guided& guided : team_) {
      if (guided.id != moving().id) places_local_m.push_back(guided.last_place_local_m);
    }
    return places_local_m;
  }

  void advance_state(const GuidanceInput& input) {
    switch (state_) {
      case GuideState::kIdle:
        if (std::ranges::all_of(team_, &Guided::ready)) {
          if (team_has_more_goals() && (has_more_goals(moving()) || choose_next())) next_goal(input);
        } else if (team_has_more_goals() && waited(config_.stage_timeout_s)) {
          failures_ = config_.retries;  // no retry for a vehicle that was never found
          fail("the guided vehicle was not found");
        }
        return;
      case GuideState::kPlanning:
        plan(input);
        return;
      case GuideState::kPrimaryMoving:
        move_primary(input);
        return;
      case GuideState::kSecondaryMoving:
        move_secondary(input);
        return;
      case GuideState::kGoalReached:
        if (!team_has_more_goals() || !(planner_.idle() || planner_.due(now_))) return;
        if (choose_next()) {
          next_goal(input);
        } else if (waited(config_.stage_timeout_s)) {
          fail("the guided vehicle was lost");
        }
        return;
      case GuideState::kFailure:
        if (failures_ <= config_.retries && waited(config_.retry_after_s)) retry(input);
        return;
    }
  }

  // Goals.

  bool advances() const { return config_.advance.step_m.squaredNorm() > 0.0; }
  bool has_more_goals(const Guided& guided) const {
    if (advances()) return guided.advanced_m < config_.advance.distance_m;
    return config_.loop || guided.num_reached < guided.goals_m.size();
  }
  bool team_has_more_goals() const {
    return std::ranges::any_of(team_, [this](const Guided& guided) { return has_more_goals(guided); });
  }

  /// Chooses the next vehicle in turn, goal by goal, so that the team stays together in view of the guide. False if no
  /// vehicle with goals left has an estimate.
  bool choose_next() {
    for (std::size_t i = 1; i <= team_.size(); ++i) {
      const std::size_t next = (moving_ + i) % team_.size();
      if (!has_more_goals(team_[next]) || !team_[next].estimate) continue;
      moving_ = next;
      return true;
    }
    return false;
  }

  void next_goal(const GuidanceInput& input) {
    failures_ = 0;
    take_goal(input);
  }

  /// Retries with the next vehicle, which may have blocked the path.
  void retry(const GuidanceInput& input) {
    if (team_.size() > 1 && choose_next()) {
      take_goal(input);
    } else {
      start_planning();
    }
  }

  void take_goal(const GuidanceInput& input) {
    const PlannedPose here{there().position_m, there().yaw_rad};
    if (!moving().began_local_m) moving().began_local_m = here.p_local_m;
    goal_ = goal_after(moving().num_reached, here, FrameChange::to_local(input.estimate));
    if (plan_ahead_ && (plan_ahead_->goal_local_m - goal_.p_local_m).norm() < 2.0 * config_.planner.tolerance_m) {
      plan_ = std::move(plan_ahead_);
      plan_ahead_.reset();
      take_plan();
      return;
    }
    start_planning();
  }

  /// The goal of the moving vehicle after `num_reached` goals.
  PlannedPose goal_after(std::size_t num_reached, const PlannedPose& from, const FrameChange& to_local) const {
    PlannedPose goal = from;
    if (advances()) {
      const Vector3 step_local_m = to_local.direction(config_.advance.step_m);
      goal.p_local_m += step_local_m;
      goal.p_local_m.z() = moving().began_local_m->z() + step_local_m.z();
      return goal;
    }
    const Guided& guided = moving();
    const std::size_t i = num_reached % guided.goals_m.size();
    goal.p_local_m = to_local.point(guided.goals_m[i]);
    if (i < guided.goal_yaws_deg.size()) {
      goal.yaw_rad = to_local.yaw(guided.goal_yaws_deg[i] * std::numbers::pi / 180.0);
    }
    return goal;
  }

  // Planning, while both hover.

  void start_planning(const char* cause = "planning") {
    planning_note_ = cause;
    path_.clear();
    plan_ahead_.reset();
    settled_since_.reset();
    planner_.stop();
    enter(GuideState::kPlanning);
  }

  void plan(const GuidanceInput& input) {
    if (!planner_.idle()) {
      if (planner_.due(now_)) take_plan();
      return;
    }
    if (!settled(input)) {
      if (waited(config_.stage_timeout_s)) fail("the guided vehicle is not localized, or does not come to rest");
      return;
    }
    plan_ = plan_team(*input.map, config_.planner, input.estimate.T_local_body.translation(),
                      {there().position_m, there().yaw_rad}, goal_, {.hovering_local_m = hovering_local_m()});
    count(*plan_);
    planner_.start(now_);
  }

  void count(const TeamPlan& plan) {
    ++num_plans_;
    if (plan.primary_search == ClearPathStatus::kBudgetSpent) ++num_given_up_primary_;
    if (plan.secondary_search == ClearPathStatus::kBudgetSpent) ++num_given_up_secondary_;
  }

  /// Both vehicles hover, and the position of the guided one is known.
  bool settled(const GuidanceInput& input) {
    const bool still = moving().ready() && there().velocity_mps.norm() < kAtRest_mps &&
                       input.estimate.v_local_mps.norm() < kAtRest_mps;
    if (!still) settled_since_.reset();
    if (still && !settled_since_) settled_since_ = now_;
    return settled_since_ && now_ - *settled_since_ >= from_seconds(config_.settle_s);
  }

  void take_plan() {
    planner_.stop();
    switch (plan_->next) {
      case TeamPlan::Next::kFail:
        fail(plan_->reason);
        return;
      case TeamPlan::Next::kGoalReached:
        reach();
        return;
      case TeamPlan::Next::kMovePrimary:
        next_corner_ = 1;
        enter(GuideState::kPrimaryMoving);
        return;
      case TeamPlan::Next::kMoveSecondary:
        start_guiding();
        return;
    }
  }

  void fail(const std::string& reason) {
    reason_ = reason;
    ++failures_;
    path_.clear();
    enter(GuideState::kFailure);
  }

  void reach() {
    Guided& guided = moving();
    ++guided.num_reached;
    if (guided.began_local_m && guided.estimate) {
      guided.advanced_m = (guided.estimate->position_m - *guided.began_local_m).head<2>().norm();
    }
    path_.clear();
    enter(GuideState::kGoalReached);
  }

  // Motion.

  void move_primary(const GuidanceInput& input) {
    if (map_has_changed(*input.map) && own_path_is_blocked(input)) {
      stop_and_plan(input);
    } else if (follow_own_path(input)) {
      start_guiding();
    } else if (waited(config_.stage_timeout_s)) {
      fail("the guide does not reach its viewpoint");
    }
  }

  /// True when the guide hovers at the end of its path.
  bool follow_own_path(const GuidanceInput& input) {
    const std::vector<Vector3>& corners_local_m = plan_->primary_local_m;
    if (corners_local_m.empty()) return true;  // the guide is at its viewpoint
    const bool last = next_corner_ + 1 >= corners_local_m.size();
    hold_.position_m = corners_local_m[std::min(next_corner_, corners_local_m.size() - 1)];
    const double distance_m = (input.estimate.T_local_body.translation() - hold_.position_m).norm();
    if (distance_m >= config_.planner.tolerance_m) return false;
    if (!last) ++next_corner_;
    return last && input.estimate.v_local_mps.norm() < kAtRest_mps;
  }

  /// The path may lead through space that was unknown when it was planned.
  bool own_path_is_blocked(const GuidanceInput& input) {
    const std::vector<Vector3>& corners_local_m = plan_->primary_local_m;
    return corners_local_m.size() > 1 &&
           is_blocked(*input.map, config_.planner.primary, input.estimate.T_local_body.translation(), corners_local_m,
                      std::min(next_corner_, corners_local_m.size() - 1));
  }
  /// Skips the path's beginning: cells there may be the guided vehicle itself, which has moved since its last report.
  bool path_is_blocked(const GuidanceInput& input) {
    const ClearPathConfig& rules = config_.planner.secondary;
    double skipped_m =
        rules.clearance_m + kOwnRadius_m + there().velocity_mps.norm() * to_seconds(now_ - there().report_t);
    std::vector<Vector3> corners_local_m = {there().position_m};
    for (const PlannedPose& pose : path_) {
      const Vector3 leg_m = pose.p_local_m - corners_local_m.back();
      if (skipped_m > 0.0) {
        const double share = std::min(1.0, skipped_m / std::max(leg_m.norm(), 1e-9));
        corners_local_m.back() += share * leg_m;
        skipped_m -= leg_m.norm();
      }
      if (skipped_m <= 0.0) corners_local_m.push_back(pose.p_local_m);
    }
    return corners_local_m.size() > 1 && is_blocked(*input.map, rules, there().position_m, corners_local_m);
  }
  /// Does the guide fly to a viewpoint while the guided vehicle flies?
  bool flies_along(const GuidanceInput& input) const {
    if (config_.motion != GuideConfig::Motion::kTogether || plan_->primary_local_m.empty()) return false;
    const Vector3 left_m = plan_->primary_local_m.back() - input.estimate.T_local_body.translation();
    return left_m.norm() >= config_.planner.tolerance_m;
  }
  void stop_and_plan(const GuidanceInput& input) {
    hold_.position_m = input.estimate.T_local_body.translation();
    start_planning("planning anew: the way to the viewpoint is not clear any more");
  }
  bool map_has_changed(const OccupancyView& map) { return std::exchange(checked_, map.revision()) != map.revision(); }

  void start_guiding() {
    path_.assign(plan_->secondary_path.begin() + 1, plan_->secondary_path.end());
    was_path_sent_ = tried_ahead_ = false;
    enter(GuideState::kSecondaryMoving);
  }

  void move_secondary(const GuidanceInput& input) {
    if (waited(config_.stage_timeout_s)) {
      fail(moving().ready() ? "the guided vehicle does not reach its goal" : "the guided vehicle was lost on its way");
      return;
    }
    if (!moving().ready()) {  // both vehicles hover
      if (config_.motion == GuideConfig::Motion::kTogether) hold_.position_m = rest_place_m(input);
      return;
    }
    hovers_.reset();
    if (config_.motion != GuideConfig::Motion::kAlternate) plan_next_leg(input);
    const Vector3& p_local_m = there().position_m;
    while (path_.size() > 1 && (path_.front().p_local_m - p_local_m).norm() < config_.visited_m) {
      path_.erase(path_.begin());
    }
    if (map_has_changed(*input.map)) {
      if (path_is_blocked(input)) {
        start_planning("planning anew: the guided vehicle's path is not clear any more");
        return;
      }
      if (flies_along(input) && own_path_is_blocked(input)) {
        stop_and_plan(input);
        return;
      }
    }
    if (path_.size() > 1 || (path_.back().p_local_m - p_local_m).norm() >= config_.planner.tolerance_m) return;
    if (there().velocity_mps.norm() < kAtRest_mps) reach();
  }

  // The next leg, while the guided vehicle flies.

  /// Position of the guide while the guided vehicle is lost.
  Vector3 rest_place_m(const GuidanceInput& input) {
    if (!hovers_) hovers_ = input.estimate.T_local_body.translation();
    return *hovers_;
  }

  void plan_next_leg(const GuidanceInput& input) {
    const bool together = config_.motion == GuideConfig::Motion::kTogether;
    const bool arrived = !together || follow_own_path(input);
    if (planner_.due(now_)) {
      planner_.stop();
      if (together) fly_on();
      return;
    }
    if (!planner_.idle() || tried_ahead_ || !arrived || !has_goal_after_this()) return;
    if (!together && length_left_m() > kPlanAhead_m) return;
    tried_ahead_ = true;
    const PlannedPose from{plan_->goal_local_m, goal_.yaw_rad};
    next_goal_ = goal_after(moving().num_reached + 1, from, FrameChange::to_local(input.estimate));
    TeamPlan ahead =
        plan_team(*input.map, config_.planner, input.estimate.T_local_body.translation(), from, next_goal_,
                  {.flying = together ? std::span<const PlannedPose>(path_) : std::span<const PlannedPose>()});
    count(ahead);
    const bool usable = ahead.next == TeamPlan::Next::kMovePrimary || ahead.next == TeamPlan::Next::kMoveSecondary;
    if (!usable) return;  // planned again, with its reason, when both hover
    plan_ahead_ = std::move(ahead);
    planner_.start(now_);
  }

  bool has_goal_after_this() const {
    if (advances()) return (goal_.p_local_m - *moving().began_local_m).head<2>().norm() < config_.advance.distance_m;
    return config_.loop || moving().num_reached + 1 < moving().goals_m.size();
  }

  double length_left_m() const {
    double left_m = (path_.front().p_local_m - there().position_m).norm();
    for (std::size_t i = 1; i < path_.size(); ++i) left_m += (path_[i].p_local_m - path_[i - 1].p_local_m).norm();
    return left_m;
  }

  /// The goal becomes a waypoint of the continued path.
  void fly_on() {
    plan_ = std::move(plan_ahead_);
    plan_ahead_.reset();
    path_.insert(path_.end(), plan_->secondary_path.begin() + 1, plan_->secondary_path.end());
    goal_ = next_goal_;
    ++moving().num_reached;
    next_corner_ = 1;
    tried_ahead_ = false;
    entered_ = now_;
  }

  /// Number of remaining waypoints in sight of the guide, from the first one on.
  std::size_t num_in_sight(const OccupancyView& map, const Vector3& p_local_m) const {
    std::size_t seen = 0;
    const double far_m = kSeenFarther * config_.planner.viewpoint.ray_max_m;
    while (seen < path_.size() && (path_[seen].p_local_m - p_local_m).head<2>().norm() <= far_m &&
           !map.first_hit(p_local_m, path_[seen].p_local_m)) {
      ++seen;
    }
    return seen;
  }

  // Messages to the others: the rest of their path in their level body frame, or an empty path, on which they hover.

  void send_messages(const GuidanceInput& input, Outbox& outbox) {
    if (now_ < next_report_ || std::ranges::none_of(team_, &Guided::was_known)) return;
    next_report_ = now_ + guiding_period_;
    ++num_reports_;
    for (std::size_t i = 0; i < team_.size(); ++i) {
      if (team_[i].was_known) send_guidance(i, input, outbox);
    }
  }

  void send_guidance(std::size_t i, const GuidanceInput& input, Outbox& outbox) {
    GuidingPath report;
    report.path = num_reports_;
    const bool its_turn = i == moving_;
    if (its_turn) {
      const bool guides = state_ == GuideState::kSecondaryMoving && moving().ready();
      if (guides && !config_.periodic && was_path_sent_) return;
      if (guides) append_path(input, report);
      was_path_sent_ = guides;
    }
    report.command = is_done()                     ? GuidingPath::Command::kDone
                     : has_failed()                ? GuidingPath::Command::kFailed
                     : its_turn && figure_m_ > 0.0 ? GuidingPath::Command::kMove
                                                   : GuidingPath::Command::kGuide;
    report.radius_m = its_turn ? figure_m_ : 0.0;
    write_message(report, outbox.add(team_[i].id));
  }

  /// The path in the level body frame at the time of the newest odometry, so that the radio's delay does not shift it.
  void append_path(const GuidanceInput& input, GuidingPath& report) const {
    report.has_instant = true;
    report.t = there().report_stamp;
    const double yaw_rad = there().report_yaw_rad;
    const double s = elementary::sin(yaw_rad), c = elementary::cos(yaw_rad);
    const std::size_t num_sent = config_.motion == GuideConfig::Motion::kTogether
                                     ? num_in_sight(*input.map, input.estimate.T_local_body.translation())
                                     : path_.size();
    report.waypoints.reserve(num_sent);
    for (const PlannedPose& pose : std::span(path_).first(num_sent)) {
      const Vector3 d_m = pose.p_local_m - there().report_position_m;
      GuidingWaypoint& waypoint = report.waypoints.emplace_back();
      waypoint.p_body_m = Vector3(c * d_m.x() + s * d_m.y(), c * d_m.y() - s * d_m.x(), d_m.z()).cast<float>();
      waypoint.yaw_rad = static_cast<float>(std::remainder(pose.yaw_rad - yaw_rad, 2.0 * std::numbers::pi));
    }
  }

  bool is_done() const { return state_ == GuideState::kGoalReached && !team_has_more_goals(); }
  bool has_failed() const { return state_ == GuideState::kFailure && failures_ > config_.retries; }

  void fill(GuidanceOutput& output) const {
    output.mission = MissionStatus::kRunning;
    switch (state_) {
      case GuideState::kIdle:
        output.note = std::ranges::all_of(team_, &Guided::was_known) ? "idle: no goal"
                                                                     : "idle: the guided vehicle is not localized yet";
        if (!team_has_more_goals()) output.mission = MissionStatus::kEndless;
        return;
      case GuideState::kPlanning:
        output.note = moving().ready()  ? planning_note_
                      : figure_m_ > 0.0 ? "hovers: the guided vehicle is to move, to be found again"
                                        : "hovers: the guided vehicle is lost";
        return;
      case GuideState::kPrimaryMoving:
        output.note = "primary moving";
        return;
      case GuideState::kSecondaryMoving:
        output.note = !moving().linked       ? "hovers: the link to the guided vehicle is lost"
                      : !moving().known_well ? "hovers: the place of the guided vehicle is not sure enough"
                                             : "secondary moving";
        return;
      case GuideState::kGoalReached:
        output.note = "goal reached";
        if (is_done()) output.mission = MissionStatus::kDone;
        return;
      case GuideState::kFailure:
        output.note = reason_.c_str();
        if (has_failed()) output.mission = MissionStatus::kFailed;
        return;
    }
  }

  GuideConfig config_;
  std::vector<Guided> team_;  // in the order of turns
  std::size_t moving_ = 0;    // index of the moving vehicle
  TimeNs guiding_period_;
  TimeNs now_ = 0;

  GuideState state_ = GuideState::kIdle;
  TimeNs entered_ = kNever;
  int failures_ = 0;
  std::string reason_;

  double figure_m_ = 0.0;  // radius of the figure that a lost vehicle flies; 0: none

  PlannedPose goal_;

  Worker planner_;
  std::optional<TimeNs> settled_since_;
  std::optional<TeamPlan> plan_, plan_ahead_;
  PlannedPose next_goal_;
  bool tried_ahead_ = false;       // for this leg
  std::optional<Vector3> hovers_;  // position while the guided vehicle is lost
  std::size_t next_corner_ = 1;
  Reference hold_;
  std::vector<PlannedPose> path_;  // remaining path of the guided vehicle
  std::uint64_t checked_ = 0;      // revision of the map in which the remaining paths were checked
  const char* planning_note_ = "planning";

  TimeNs next_report_ = 0;
  std::uint32_t num_reports_ = 0;
  bool was_path_sent_ = false;

  std::uint64_t num_plans_ = 0, num_given_up_primary_ = 0, num_given_up_secondary_ = 0;
};

}  // namespace

void GuideAdvanceConfig::visit(ConfigVisitor& v) {
  v.field("step_m", step_m, "[m] displacement from the guided vehicle to its next goal, world axes; 0: goals_m",
          Range::between(-1000.0, 1000.0));
  v.field("distance_m", distance_m, "[m] horizontal distance from the first position at which the mission is done",
          Range::positive());
}

void GuidedVehicleConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the vehicle");
  v.field("goals_m", goals_m, "[m] goals of the guided vehicle in order, world frame", Range::between(-1e5, 1e5));
  v.field("goal_yaws_deg", goal_yaws_deg, "[deg] headings at the goals; none: keeps its heading");
  v.check(goal_yaws_deg.empty() || goal_yaws_deg.size() == goals_m.size(), "goal_yaws_deg",
          "as many as goals_m, or none");
}

void GuideConfig::visit(ConfigVisitor& v) {
  v.field("secondary", secondary, "[-] name of the vehicle that is guided");
  v.list("secondaries", secondaries,
         "several that are guided, goal by goal in turn: one moves, the others hover; then secondary and goals_m stay "
         "empty");
  v.field("goals_m", goals_m, "[m] goals of the guided vehicle in order, world frame", Range::between(-1e5, 1e5));
  v.field("goal_yaws_deg", goal_yaws_deg, "[deg] headings at the goals; none: keeps its heading");
  v.object("advance", advance, "goals relative to the guided vehicle's position, instead of goals_m");
  v.field("loop", loop, "[-] go on with the first goal after the last");
  v.field("periodic", periodic, "[-] send the rest of the path periodically; otherwise the path once");
  v.choice("motion", motion, {"alternate", "ahead", "together"},
           "[-] the next leg is planned while both hover, while the guided vehicle flies, or so that both fly at once");
  v.field("guiding_rate_hz", guiding_rate_hz, "[Hz] rate of guiding messages", Range::between(0.01, 1000.0));
  v.field("visited_m", visited_m, "[m] distance within which a waypoint counts as visited", Range::positive());
  v.field("speed_mps", speed_mps, "[m/s] highest speed of the guide, horizontal and vertical each", Range::positive());
  v.field("planning_latency_s", planning_latency_s, "[s] computing time of a plan on board",
          Range::between(0.0, 1000.0));
  v.field("settle_s", settle_s, "[s] time for which both hover before planning", Range::between(0.0, 1000.0));
  v.field("link_timeout_s", link_timeout_s, "[s] time without odometry of the guided vehicle after which both hover",
          Range::positive());
  v.field("sigma_max_m", sigma_max_m,
          "[m] standard deviation of the guided vehicle's position along the worst axis above which both hover",
          Range::positive());
  v.field("search_after_s", search_after_s,
          "[s] time without an estimate after which the guided vehicle is asked to move, to be found again",
          Range::positive());
  v.field("stage_timeout_s", stage_timeout_s, "[s] time after which the search, planning or a motion has failed",
          Range::positive());
  v.field("retries", retries, "[-] plans after failures before the mission fails", Range::between(0, 1e6));
  v.field("retry_after_s", retry_after_s, "[s] to wait after a failure", Range::non_negative());
  v.object("planner", planner, "paths of both vehicles and the viewpoint");
  v.check(goal_yaws_deg.empty() || goal_yaws_deg.size() == goals_m.size(), "goal_yaws_deg",
          "as many as goals_m, or none");
  v.check(secondaries.empty() || secondary.empty(), "secondary", "none beside secondaries");
  v.check(secondaries.empty() || goals_m.empty(), "goals_m", "none beside secondaries, which have their own");
  v.check(secondaries.empty() || motion == Motion::kAlternate, "motion", "alternate with secondaries");
  const bool all_have_goals =
      secondaries.empty() ? !goals_m.empty()
                          : std::ranges::none_of(secondaries, [](const auto& one) { return one.goals_m.empty(); });
  v.check(!loop || all_have_goals, "loop", "false without goals_m");
}

std::unique_ptr<Guidance> make_guide(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Guide>(dynamic_cast<const GuideConfig&>(config), setup);
}

}  // namespace swiftlet
