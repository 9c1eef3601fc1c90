// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/guide.hpp"

#include <optional>
#include <utility>

#include "core/guidance/guiding/guide_constants.hpp"
#include "core/guidance/guiding/guide_overlays.hpp"
#include "core/guidance/guiding/guide_reporter.hpp"
#include "core/guidance/guiding/leg_planner.hpp"
#include "core/guidance/guiding/viewpoint_flight.hpp"

namespace swiftlet {
namespace {

/// The states of [Pritzl 2024, sec. II-A].
enum class GuideState { kIdle, kPlanning, kPrimaryMoving, kSecondaryMoving, kGoalReached, kFailure };

class Guide : public Guidance {
 public:
  Guide(const GuideConfig& config, const GuidanceSetup& setup)
      : config_(config),
        together_(config.motion == GuideConfig::Motion::kTogether),
        team_(config_, setup.agent),
        planner_(config_),
        flight_(config_.planner),
        reporter_(config_) {
    hold_.position_m = setup.agent.T_local_body_start.translation();
    hold_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
  }

  GuidanceNeeds needs() const override { return {.map = true, .relatives = true}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    now_ = input.observation.t;
    if (!entered_) entered_ = now_;
    team_.update(input);
    step_state(input);
    output.mission = mission();
    output.note = note();
    output.goal = hold_;
    output.speed_limit_mps = config_.speed_mps;
    reporter_.send(input, team_, path_, output.mission, outbox);
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    if (planner_.plan()) append_guide_overlays(*planner_.plan(), hold_.position_m.z(), overlays);
  }

  void append_counters(std::vector<Counter>& counters) const override { planner_.append_counters(counters); }

 private:
  void enter(GuideState state) {
    state_ = state;
    entered_ = now_;
  }
  bool waited(double seconds) const { return now_ - *entered_ >= from_seconds(seconds); }

  // The states.

  void step_state(const GuidanceInput& input) {
    switch (state_) {
      case GuideState::kIdle:
        return idle(input);
      case GuideState::kPlanning:
        return plan(input);
      case GuideState::kPrimaryMoving:
        return move_primary(input);
      case GuideState::kSecondaryMoving:
        return move_secondary(input);
      case GuideState::kGoalReached:
        return hold_goal(input);
      case GuideState::kFailure:
        return retry(input);
    }
  }

  void idle(const GuidanceInput& input) {
    if (team_.all_ready()) {
      if (team_.choose()) start_leg(input);
    } else if (team_.has_more_goals() && waited(config_.stage_timeout_s)) {
      failures_ = config_.retries;  // no retry for a vehicle that was never found
      fail("the guided vehicle was not found");
    }
  }

  void plan(const GuidanceInput& input) {
    if (planner_.ready(now_)) {
      take_plan();
    } else if (planner_.idle() && settled(input)) {
      planner_.start(input, team_.pose(), goal_, {.hovering_local_m = team_.hovering_local_m()});
    } else if (planner_.idle() && waited(config_.stage_timeout_s)) {
      fail("the guided vehicle is not localized, or does not come to rest");
    }
  }

  void move_primary(const GuidanceInput& input) {
    if (map_has_changed(*input.map) && flight_.is_blocked(*input.map, input.estimate.T_local_body.translation())) {
      stop_and_plan(input);
    } else if (flight_.step(input.estimate, hold_.position_m)) {
      start_guiding();
    } else if (waited(config_.stage_timeout_s)) {
      fail("the guide does not reach its viewpoint");
    }
  }

  void move_secondary(const GuidanceInput& input) {
    const bool ready = team_.moving().ready();
    if (waited(config_.stage_timeout_s)) {
      return fail(ready ? "the guided vehicle does not reach its goal" : "the guided vehicle was lost before its goal");
    }
    const Vector3 own_local_m = input.estimate.T_local_body.translation();
    if (!ready) {  // both vehicles hover
      if (together_ && !stopped_local_m_) stopped_local_m_ = own_local_m;
      if (together_) hold_.position_m = *stopped_local_m_;
      return;
    }
    stopped_local_m_.reset();
    if (config_.motion != GuideConfig::Motion::kAlternate) plan_next_leg(input);
    const RelativeEstimate& there = team_.there();
    path_.drop_visited(there.position_m, config_.visited_m);
    if (map_has_changed(*input.map)) {
      if (path_.is_blocked(*input.map, config_.planner.secondary, there, now_)) {
        return start_planning("replanning: the path of the guided vehicle is blocked");
      }
      const bool flies = together_ && flight_.is_away(own_local_m);
      if (flies && flight_.is_blocked(*input.map, own_local_m)) return stop_and_plan(input);
    }
    const bool arrived = path_.is_reached_from(there.position_m, config_.planner.tolerance_m);
    if (arrived && there.velocity_mps.norm() < PathFollower::kHovers_mps) reach();
  }

  void hold_goal(const GuidanceInput& input) {
    const bool plans = !planner_.idle() && !planner_.ready(now_);
    if (plans || !team_.has_more_goals()) return;
    if (team_.choose_next()) {
      start_leg(input);
    } else if (waited(config_.stage_timeout_s)) {
      fail("the guided vehicle was lost");
    }
  }

  /// Retries with the next vehicle, which may have blocked the path.
  void retry(const GuidanceInput& input) {
    if (has_failed() || !waited(GuideConstants::kRetryAfter_s)) return;
    if (team_.vehicles().size() > 1 && team_.choose_next()) {
      take_goal(input);
    } else {
      start_planning();
    }
  }

  // Changes of state.

  void start_leg(const GuidanceInput& input) {
    failures_ = 0;
    take_goal(input);
  }

  void take_goal(const GuidanceInput& input) {
    goal_ = team_.take_goal(FrameChange::to_local(input.estimate));
    const std::optional<TeamPlan>& next = planner_.next();
    if (!next || (next->goal_local_m - goal_.p_local_m).norm() >= 2.0 * config_.planner.tolerance_m) {
      return start_planning();
    }
    planner_.take_next();
    take_plan();
  }

  void start_planning(const char* cause = "planning") {
    planning_note_ = cause;
    path_.clear();
    planner_.reset();
    settled_since_.reset();
    enter(GuideState::kPlanning);
  }

  void stop_and_plan(const GuidanceInput& input) {
    hold_.position_m = input.estimate.T_local_body.translation();
    start_planning("replanning: the path to the viewpoint is blocked");
  }

  void take_plan() {
    planner_.finish();
    const TeamPlan& plan = *planner_.plan();
    flight_.start(plan.primary_local_m);
    switch (plan.next) {
      case TeamPlan::Next::kFail:
        return fail(plan.reason.c_str());
      case TeamPlan::Next::kGoalReached:
        return reach();
      case TeamPlan::Next::kMovePrimary:
        return enter(GuideState::kPrimaryMoving);
      case TeamPlan::Next::kMoveSecondary:
        return start_guiding();
    }
  }

  void start_guiding() {
    path_.append(*planner_.plan());
    reporter_.start_path();
    tried_ahead_ = false;
    enter(GuideState::kSecondaryMoving);
  }

  void reach() {
    team_.reach();
    path_.clear();
    enter(GuideState::kGoalReached);
  }

  void fail(const char* reason) {
    reason_ = reason;
    ++failures_;
    path_.clear();
    enter(GuideState::kFailure);
  }

  // Decisions of the states.

  /// Both vehicles hover, and the position of the guided one is known.
  bool settled(const GuidanceInput& input) {
    const bool still = team_.moving().ready() && team_.there().velocity_mps.norm() < PathFollower::kHovers_mps &&
                       input.estimate.v_local_mps.norm() < PathFollower::kHovers_mps;
    if (!still) settled_since_.reset();
    if (still && !settled_since_) settled_since_ = now_;
    return settled_since_ && now_ - *settled_since_ >= from_seconds(config_.settle_s);
  }

  bool map_has_changed(const OccupancyView& map) { return std::exchange(checked_, map.revision()) != map.revision(); }

  /// Plans the next leg while the guided vehicle flies: once a leg, near its goal, or when the guide hovers at its
  /// viewpoint if both fly at the same time.
  void plan_next_leg(const GuidanceInput& input) {
    const bool hovers = !together_ || flight_.step(input.estimate, hold_.position_m);
    if (planner_.ready(now_)) {
      planner_.finish();
      if (together_) fly_on();
      return;
    }
    if (!planner_.idle() || tried_ahead_ || !hovers || !team_.has_goal_after(goal_.p_local_m)) return;
    if (!together_ && path_.length_from_m(team_.there().position_m) > GuideConstants::kPlanAhead_m) return;
    tried_ahead_ = true;
    const double yaw_rad = goal_.yaw_rad;
    next_goal_ = team_.goal_after({planner_.plan()->goal_local_m, yaw_rad}, FrameChange::to_local(input.estimate));
    TeamTraffic traffic;
    if (together_) traffic.flying = path_.poses();
    planner_.start_next(input, next_goal_, yaw_rad, traffic);
  }

  /// The goal becomes a waypoint of the continued path.
  void fly_on() {
    planner_.take_next();
    flight_.start(planner_.plan()->primary_local_m);
    path_.append(*planner_.plan());
    goal_ = next_goal_;
    team_.reach();
    tried_ahead_ = false;
    entered_ = now_;
  }

  // Outputs.

  bool has_failed() const { return state_ == GuideState::kFailure && failures_ > config_.retries; }

  MissionStatus mission() const {
    if (has_failed()) return MissionStatus::kFailed;
    const bool over = !team_.has_more_goals();
    if (over && state_ == GuideState::kIdle) return MissionStatus::kEndless;
    return over && state_ == GuideState::kGoalReached ? MissionStatus::kDone : MissionStatus::kRunning;
  }

  const char* note() const {
    switch (state_) {
      case GuideState::kIdle:
        return team_.all_were_known() ? "idle: no goal" : "idle: the guided vehicle is not localized yet";
      case GuideState::kPlanning:
        return team_.moving().ready()   ? planning_note_
               : team_.figure_m() > 0.0 ? "hovering: moving the guided vehicle to localize it again"
                                        : "hovering: the guided vehicle is lost";
      case GuideState::kPrimaryMoving:
        return "primary moving";
      case GuideState::kSecondaryMoving:
        return !team_.moving().linked       ? "hovering: link to the guided vehicle lost"
               : !team_.moving().known_well ? "hovering: the position of the guided vehicle is too uncertain"
                                            : "secondary moving";
      case GuideState::kGoalReached:
        return "goal reached";
      case GuideState::kFailure:
        return reason_.c_str();
    }
    return "";
  }

  GuideConfig config_;
  bool together_;
  GuidedTeam team_;
  LegPlanner planner_;
  ViewpointFlight flight_;
  GuidedPath path_;  // empty, unless the guided vehicle moves
  GuideReporter reporter_;
  TimeNs now_ = 0;

  GuideState state_ = GuideState::kIdle;
  std::optional<TimeNs> entered_;  // time of the last change of state
  int failures_ = 0;
  std::string reason_;
  const char* planning_note_ = "planning";

  PlannedPose goal_, next_goal_;
  std::optional<TimeNs> settled_since_;
  std::optional<Vector3> stopped_local_m_;  // position while the guided vehicle is lost
  bool tried_ahead_ = false;                // for this leg
  Reference hold_;
  std::uint64_t checked_ = 0;  // revision of the map in which the remaining paths were checked
};

}  // namespace

std::unique_ptr<Guidance> make_guide(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Guide>(dynamic_cast<const GuideConfig&>(config), setup);
}

}  // namespace swiftlet
