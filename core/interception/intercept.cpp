// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/intercept.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "core/interception/capture_judge.hpp"
#include "core/interception/chase_team.hpp"
#include "core/interception/intercept_flight.hpp"
#include "core/interception/intercept_overlays.hpp"
#include "core/interception/intercept_states.hpp"
#include "core/interception/search_planner.hpp"
#include "core/interception/target_selection.hpp"

namespace swiftlet {
namespace {

using State = InterceptStates::State;

struct InterceptTuning {
  /// [m] Tracks within this distance of the target's track belong to the same target and are no obstacles.
  double second_track_m = 2.5;
  double climb_m = 1000.0;  ///< [m] climb after the last capture, limited by the fence
  /// [s] Time in the lead without a capture beyond which a leader reports its arrival later by the excess, up to
  /// max_lead_penalty_s, so that another interceptor takes the lead.
  double lead_timeout_s = 6.0, max_lead_penalty_s = 4.0;
  double no_arrival_s = 1e3;                         ///< [s] reported arrival of a vehicle without a target
  std::size_t max_obstacles = 64, max_cells = 4096;  ///< [-] capacities; more moving obstacles are ignored
};
constexpr InterceptTuning kIntercept;

class Intercept : public Guidance {
 public:
  Intercept(const InterceptConfig& config, const GuidanceSetup& setup)
      : config_(config),
        selection_(config, track_of(config.target, setup.agent.vehicle_names)),
        judge_(config.net),
        states_(config),
        team_(setup.agent.self, setup.agent.num_vehicles),
        search_(config.search),
        flight_(config, setup),
        wait_local_m_(setup.agent.T_local_body_start.translation()) {
    surroundings_.clearance_m = config.clearance_m;
    surroundings_.moving_obstacles.reserve(kIntercept.max_obstacles);
    surroundings_.cells_local_m.reserve(kIntercept.max_cells);
  }

  GuidanceNeeds needs() const override {
    return {.map = config_.walls == InterceptConfig::Walls::kMap, .track_modes = true};
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    now_ = input.observation.t;
    p_local_m_ = input.estimate.T_local_body.translation();
    flight_.begin_tick(input.estimate);
    look_around(input);
    const Track* target = select_target(input);
    decide(target != nullptr, input.dt_s);
    flight_.set_task(task(), states_.take_entry());
    if (flight_.is_plan_due()) {
      divide_task();
      flight_.plan();
    }
    if (team_.is_report_due(now_)) report(input.estimate, outbox);
    output.goal = flight_.step(input.dt_s);
    output.goal_is_feasible = true;
    output.note = states_.note();
    output.mission = states_.status();
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    append_fence(surroundings_.fence, overlays);
    append_net(config_.net, p_local_m_, flight_.yaw_rad(), overlays);
    if (states_.is(State::kSearching)) search_.append_overlay(overlays);
    if (!states_.is(State::kChasing)) return;
    const ChasePlanner& planner = flight_.planner();
    append_curve(
        "intercept.prediction", "predicted positions of the target", {0.84F, 0.37F, 0.0F, 1.0F}, planner.horizon_s(),
        [&](double t_s) { return target().at(t_s).p_m; }, overlays);
    if (config_.method != InterceptConfig::Method::kMpc) return;
    append_curve(
        "intercept.plan", "plan of the interceptor", {0.0F, 0.45F, 0.70F, 1.0F}, planner.horizon_s(),
        [&](double t_s) { return planner.at(t_s).p_m; }, overlays);
  }

 private:
  /// Track of the vehicle with this name, as numbered by the tracker `ground_truth`; empty: no name.
  static std::optional<std::uint32_t> track_of(const std::string& name, const std::vector<std::string>& names) {
    if (name.empty()) return std::nullopt;
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      throw std::invalid_argument("guidance intercept: target: expected the name of a vehicle, found '" + name + "'");
    return static_cast<std::uint32_t>(found - names.begin()) + 1;
  }

  const TargetPrediction& target() const { return selection_.prediction(); }

  void look_around(const GuidanceInput& input) {
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    surroundings_.fence = Geofence(config_.fence, to_local);
    surroundings_.map = config_.walls == InterceptConfig::Walls::kMap ? input.map : nullptr;
    team_.listen(input.observation, to_local);
    team_.recognize(input.tracks, selection_.id().value_or(0));
    if (selection_.is_named() || !selection_.id() || !team_.is_teammate(*selection_.id())) return;
    selection_.forget();
    judge_.forget();
    states_.drop_target();
  }

  /// Selects the target's track; all other tracks become moving obstacles.
  const Track* select_target(const GuidanceInput& input) {
    const Track* track = selection_.select(input, team_, states_.is(State::kChasing));
    if (selection_.id()) team_.compare_targets(selection_.expected_m(now_), now_, selection_.gate_m(now_));
    update_moving_obstacles(input.tracks, track);
    return track;
  }

  void update_moving_obstacles(std::span<const Track> tracks, const Track* target_track) {
    std::vector<MovingObstacle>& obstacles = surroundings_.moving_obstacles;
    obstacles.clear();
    for (const Track& track : tracks) {
      if (&track == target_track || team_.is_teammate(track.id)) continue;
      if (obstacles.size() == obstacles.capacity()) break;
      if (target_track != nullptr && !selection_.is_named() &&
          (track.position_m - target_track->position_m).norm() < kIntercept.second_track_m)
        continue;
      const double age_s = to_seconds(now_ - track.t);
      obstacles.push_back(
          {track.position_m + age_s * track.velocity_mps, track.velocity_mps, config_.bystander_clearance_m});
    }
    team_.append_moving_obstacles(now_, config_.bystander_clearance_m, config_.yield_clearance_m, obstacles);
    if (target_track == nullptr || config_.target_clearance_m <= 0.0) return;
    const PointState now = target().at(0.0);
    obstacles.push_back({now.p_m, now.v_mps, config_.target_clearance_m, config_.net.offset_m.z() < 0.0});
  }

  void decide(bool sees_target, double dt_s) {
    InterceptStates::Inputs inputs;
    inputs.sees_target = sees_target;
    inputs.had_target = selection_.id().has_value();
    inputs.is_outside = states_.is(State::kChasing) && surroundings_.fence.excess_m(target().at(0.0).p_m) > 0.0;
    inputs.is_reported = follow_report(sees_target, dt_s);
    if (sees_target) {
      inputs.captures =
          judge_.captures({*selection_.id(), target().at(0.0).p_m - flight_.net_m(), selection_.unmeasured_s(now_)});
    }
    inputs.is_armed = judge_.is_armed();
    inputs.num_captures = judge_.num_captures();
    inputs.teammate_captured = team_.has_captured();
    const State before = states_.state();
    states_.step(inputs, dt_s);
    if (before != State::kChasing || !states_.is(State::kSearching)) return;
    judge_.forget();
    search_.begin(target());
  }

  /// Searches where a teammate sees its target, and continues a search. True when it goes to a reported target. With
  /// `target` set, only that vehicle's track counts.
  bool follow_report(bool sees_target, double dt_s) {
    const auto reporter = [&] { return selection_.is_named() ? nullptr : team_.chasing(p_local_m_, now_); };
    if (states_.is(State::kSearching)) {
      if (!search_.tick(dt_s)) return false;
      const Teammate* teammate = reporter();
      search_.update(teammate, now_, p_local_m_, surroundings_);
      return teammate != nullptr;
    }
    if (!states_.is(State::kWaiting) || sees_target) return false;
    const Teammate* teammate = reporter();
    if (teammate != nullptr) search_.begin(*teammate, now_);
    return teammate != nullptr;
  }

  FlightTask task() const {
    FlightTask task;
    task.kind = states_.is(State::kChasing)   ? FlightTask::Kind::kChase
                : states_.is(State::kLeaving) ? FlightTask::Kind::kLeave
                                              : FlightTask::Kind::kGoTo;
    task.target = &target();
    task.surroundings = &surroundings_;
    task.goal_local_m = wait_local_m_;
    if (states_.is(State::kSearching)) {
      task.goal_local_m = search_.goal_local_m();
      task.net_to_goal = true;
    }
    if (states_.is(State::kDone)) task.goal_local_m.z() += kIntercept.climb_m;
    return task;
  }

  /// The interceptor with the earliest arrival leads. A leader without a capture for long adds to its arrival time, so
  /// that others try: it may be held off by what its estimate does not model.
  void divide_task() {
    const double change_s = team_.leads() && states_.has_target() ? flight_.since_plan_s() : -flight_.since_plan_s();
    led_for_s_ = std::clamp(led_for_s_ + change_s, 0.0, kIntercept.lead_timeout_s + kIntercept.max_lead_penalty_s);
    arrival_s_ = kIntercept.no_arrival_s;
    const bool can_lead = states_.has_target() && states_.outside_s() == 0.0;
    if (can_lead) {
      arrival_s_ = flight_.arrival_s(target()) + std::max(0.0, led_for_s_ - kIntercept.lead_timeout_s);
      if (states_.is(State::kLeaving)) arrival_s_ += InterceptStates::kAfterCapture_s;
    }
    team_.decide(now_, can_lead ? std::optional(arrival_s_) : std::nullopt);
  }

  void report(const StateEstimate& estimate, Outbox& outbox) {
    using Status = ChaseReport::Status;
    const Status status = states_.has_target() ? team_.leads() ? Status::kLeads : Status::kYields
                          : states_.is(State::kDone) && judge_.num_captures() >= config_.captures ? Status::kCaptured
                          : states_.is(State::kSearching)                                         ? Status::kSearches
                                                                                                  : Status::kIdle;
    const PointState reported =
        states_.has_target() ? target().at(0.0) : PointState{search_.goal_local_m(), Vector3::Zero(), Vector3::Zero()};
    team_.report(status, now_, arrival_s_, reported, flight_.path_ahead(), FrameChange::to_world(estimate), outbox);
  }

  InterceptConfig config_;
  TargetSelection selection_;
  CaptureJudge judge_;
  InterceptStates states_;
  ChaseTeam team_;
  SearchPlanner search_;
  InterceptFlight flight_;
  Surroundings surroundings_;
  Vector3 wait_local_m_;
  Vector3 p_local_m_ = Vector3::Zero();
  TimeNs now_ = 0;
  double arrival_s_ = 0.0, led_for_s_ = 0.0;
};

}  // namespace

std::unique_ptr<Guidance> make_intercept(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Intercept>(dynamic_cast<const InterceptConfig&>(config), setup);
}

}  // namespace swiftlet
