// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/intercept.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/interception/chase_planner.hpp"
#include "core/interception/chase_team.hpp"
#include "core/interception/geofence.hpp"
#include "core/interception/intercept_overlays.hpp"
#include "core/interception/pursuit_laws.hpp"
#include "core/interception/surroundings.hpp"
#include "core/interception/target_prediction.hpp"
#include "core/interception/target_search.hpp"

namespace swiftlet {
namespace {

constexpr double kCheckStep_s = 0.01;      // step of the simulated motion that is checked before it is flown
constexpr double kLook_s = 0.2;            // period of updates of a search
constexpr double kReplan_s = 1.0;          // period of new goals of a search
constexpr double kGreatestBias_m = 0.5;    // limit by axis of the difference between estimate and reference
constexpr double kShortestToFace_m = 1.0;  // shorter displacements give no heading
constexpr double kSameTarget_mps = 3.0;    // growth of the gate kSameTarget_m with the time without a track
constexpr double kSecondTrack_m = 2.5;     // tracks within this distance of the target's belong to the same target
// Height above the target from which it is approached directly, and lateral offset below that, in target_clearance_m.
constexpr double kAboveBy = 0.8, kBesideBy = 1.7;
constexpr double kHighAbove_m = 1000.0;  // climb after the last capture, limited by the fence
constexpr double kReachShare = 0.8;      // share of the radius of a sure capture within which plans meet the target
constexpr double kSameHeight_m = 0.05;
constexpr double kNoSide_m = 0.05;
/// Time since the last measurement of the target within which a track that meets `sure_share` of the net is a capture.
constexpr double kSureFor_s = 0.5;
/// Limit of that time for a track that meets the net by its standard deviations. The net hangs where a level LiDAR sees
/// nothing. Beyond the limit, tracks of maneuvering targets are worse than their covariance.
constexpr double kPreciseFor_s = 1.0;
/// Standard deviations of the track inside the rim, and inside the top and bottom, required for a capture.
constexpr double kInsideRimSigmas = 2.0, kInsideHeightSigmas = 1.0;
constexpr double kReportedSigma_m = 0.5, kReportedSigma_mps = 1.0;  // standard deviations of a reported target
/// A leader without a capture for longer than the timeout reports its arrival later by the time beyond, up to the
/// penalty, so that another interceptor takes the lead.
constexpr double kLeadTimeout_s = 6.0, kMaxLeadPenalty_s = 4.0;
constexpr double kNeverThere_s = 1e3, kOccupiedPenalty_m = 1e6;
constexpr int kPathParts = 5;         // steps of the governor between points of a reported path
constexpr double kSlowest_mps = 0.5;  // slower velocities give no direction

class Intercept : public Guidance {
 public:
  Intercept(const InterceptConfig& config, const GuidanceSetup& setup)
      : config_(config),
        limits_(setup.limits),
        governor_(setup.limits),
        planner_(config.plan, setup.limits, kReachShare * config.sure_share * config.net.radius_m),
        search_(config.search),
        team_(setup.agent.self, setup.agent.num_vehicles),
        watch_local_m_(setup.agent.T_local_body_start.translation()),
        yaw_rad_(yaw_of(setup.agent.T_local_body_start.linear())) {
    sure_net_ = config.net;
    sure_net_.radius_m *= config.sure_share;
    sure_net_.height_m *= config.sure_share;
    surroundings_.clearance_m = config.clearance_m;
    surroundings_.moving_obstacles.reserve(64);
    surroundings_.cells_local_m.reserve(4096);
    if (!config.target.empty()) target_id_ = id_of(config.target, setup.agent.vehicle_names);
  }

  GuidanceNeeds needs() const override {
    return {.map = config_.walls == InterceptConfig::Walls::kMap, .track_modes = true};
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    now_ = input.observation.t;
    if (!started_) start(input.estimate);
    p_local_m_ = input.estimate.T_local_body.translation();
    look_around(input);
    const bool sees = find_target(input);
    if (sees) note_capture();
    decide(sees, input.dt_s, output);
    if (since_check_s_ >= config_.period_s) {
      divide_task();
      plan();
    }
    if (team_.is_report_due(now_)) report(input.estimate, outbox);
    fly(governor_, since_check_s_, 0.0, input.dt_s);
    since_check_s_ += input.dt_s;
    output.goal = governor_.state();
    output.goal_is_feasible = true;
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    append_fence(surroundings_.fence, overlays);
    append_net(config_.net, p_local_m_, governor_.state().yaw_rad, overlays);
    if (mode_ == Mode::kSearching) search_.append_overlay(overlays);
    if (mode_ != Mode::kChasing) return;
    append_curve(
        "intercept.prediction", "predicted positions of the target", {0.84F, 0.37F, 0.0F, 1.0F}, planner_.horizon_s(),
        [&](double t_s) { return target_.at(t_s).p_m; }, overlays);
    if (config_.method != InterceptConfig::Method::kMpc) return;
    append_curve(
        "intercept.plan", "plan of the interceptor", {0.0F, 0.45F, 0.70F, 1.0F}, planner_.horizon_s(),
        [&](double t_s) { return planner_.at(t_s).p_m; }, overlays);
  }

 private:
  enum class Mode { kWaiting, kChasing, kLeaving, kSearching, kAborted, kDone };

  static std::uint32_t id_of(const std::string& name, const std::vector<std::string>& names) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      throw std::invalid_argument("guidance intercept: target: expected the name of a vehicle, found '" + name + "'");
    return static_cast<std::uint32_t>(found - names.begin()) + 1;  // numbering of the tracker `ground_truth`
  }

  void start(const StateEstimate& estimate) {
    started_ = true;
    Reference reference;
    reference.position_m = estimate.T_local_body.translation();
    reference.velocity_mps = estimate.v_local_mps;
    reference.yaw_rad = yaw_of(estimate.T_local_body.linear());
    governor_.reset(reference);
    since_check_s_ = config_.period_s;
  }

  void look_around(const GuidanceInput& input) {
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    surroundings_.fence = Geofence(config_.fence, to_local);
    team_.listen(input.observation, to_local);
    team_.recognize(input.tracks, had_target_ ? target_id_ : 0);
    if (config_.target.empty() && had_target_ && team_.is_peer(target_id_)) forget_target();
    surroundings_.map = config_.walls == InterceptConfig::Walls::kMap ? input.map : nullptr;
    const Vector3 bias_m = p_local_m_ - governor_.state().position_m;
    bias_local_m_ = bias_m.cwiseMax(-kGreatestBias_m).cwiseMin(kGreatestBias_m);
  }

  /// Finds the target's track and its prediction; all other tracks become moving obstacles. True if there is a track.
  bool find_target(const GuidanceInput& input) {
    const Track* best = nullptr;
    double least_m = std::numeric_limits<double>::infinity();
    for (const Track& track : input.tracks) {
      if (to_seconds(now_ - track.t) > config_.track_timeout_s) continue;
      if (config_.target.empty() ? team_.is_peer(track.id) : track.id != target_id_) continue;
      double distance_m = (track.position_m - p_local_m_).norm();
      // Targets that no other interceptor leads come first.
      const bool is_free = config_.target.empty() && !team_.is_led(track.position_m, now_);
      if (config_.target.empty() && had_target_) {
        const double gone_s = to_seconds(now_ - seen_);
        const double off_m = (track.position_m - expected_m(gone_s)).norm();
        const bool same = track.id == target_id_;
        const bool other = mode_ == Mode::kChasing && !same && off_m > kSameTarget_m + kSameTarget_mps * gone_s;
        if (other && !(team_.yields() && is_free)) continue;
        if (!other) distance_m = same ? -1.0 : off_m;
      }
      if (!is_free) distance_m += kOccupiedPenalty_m;
      if (distance_m >= least_m) continue;
      least_m = distance_m;
      best = &track;
    }
    if (best != nullptr) {
      const auto modes = std::find_if(input.track_modes.begin(), input.track_modes.end(),
                                      [&](const TrackModes& m) { return m.id == best->id; });
      target_ = TargetPrediction(config_.prediction, *best, modes == input.track_modes.end() ? nullptr : &*modes, now_);
      if (best->id != target_id_ || !had_target_) {
        last_net_m_.reset();
        measured_.reset();
      }
      target_id_ = best->id;
      if (best->corrected) measured_ = best->t;
      had_target_ = true;
      seen_ = now_;
    }
    if (had_target_) {
      const double gone_s = to_seconds(now_ - seen_);
      team_.compare_targets(expected_m(gone_s), now_, kSameTarget_m + kSameTarget_mps * gone_s);
    }
    update_moving_obstacles(input, best);
    return best != nullptr;
  }

  Vector3 expected_m(double gone_s) const { return target_.at(gone_s).p_m; }

  void update_moving_obstacles(const GuidanceInput& input, const Track* target) {
    surroundings_.moving_obstacles.clear();
    for (const Track& track : input.tracks) {
      if (&track == target || team_.is_peer(track.id)) continue;
      if (surroundings_.moving_obstacles.size() == surroundings_.moving_obstacles.capacity()) break;
      if (target != nullptr && config_.target.empty() &&
          (track.position_m - target->position_m).norm() < kSecondTrack_m)
        continue;
      const double age_s = to_seconds(now_ - track.t);
      surroundings_.moving_obstacles.push_back(
          {track.position_m + age_s * track.velocity_mps, track.velocity_mps, config_.bystander_clearance_m});
    }
    team_.append_moving_obstacles(now_, config_.bystander_clearance_m, config_.yield_clearance_m,
                                  surroundings_.moving_obstacles);
    if (target == nullptr || config_.target_clearance_m <= 0.0) return;
    const PointState now = target_.at(0.0);
    surroundings_.moving_obstacles.push_back(
        {now.p_m, now.v_mps, config_.target_clearance_m, config_.net.offset_m.z() < 0.0});
  }

  Vector3 net_m() const { return config_.net.center(p_local_m_, governor_.state().yaw_rad); }

  void note_capture() {
    const Vector3 target_net_m = target_.at(0.0).p_m - net_m();
    if (target_net_m.norm() > config_.net.rearm_m) armed_ = true;
    captured_now_ = armed_ && last_net_m_ && measured_ && shows_capture(*last_net_m_, target_net_m);
    last_net_m_ = target_net_m;
    if (!captured_now_) return;
    armed_ = false;
    ++captures_;
  }

  bool shows_capture(const Vector3& from_net_m, const Vector3& to_net_m) const {
    const double unmeasured_s = to_seconds(now_ - *measured_);
    if (unmeasured_s < kSureFor_s && sure_net_.met_m(from_net_m, to_net_m)) return true;
    const double sigma_m = target_.sigma_m(0.0);
    CaptureVolume inside = config_.net;
    inside.radius_m -= kInsideRimSigmas * sigma_m;
    if (inside.height_m > 0.0) inside.height_m -= 2.0 * kInsideHeightSigmas * sigma_m;
    return unmeasured_s < kPreciseFor_s && inside.radius_m > 0.0 && inside.height_m >= 0.0 &&
           inside.met_m(from_net_m, to_net_m);
  }

  void decide(bool sees, double dt_s, GuidanceOutput& output) {
    in_mode_s_ += dt_s;
    switch (mode_) {
      case Mode::kWaiting:
        output.note = "waiting for a target";
        if (sees)
          enter(Mode::kChasing);
        else if (const ChasePeer* peer = peer_with_target())
          go_to_reported_target(*peer);
        break;
      case Mode::kSearching:
        search(dt_s);
        output.note = had_target_ ? "the target is lost: searching" : "going where another one sees the target";
        if (sees)
          enter(Mode::kChasing);
        else if (in_mode_s_ > config_.search.timeout_s)
          give_up("gave up: the target was not found again");
        break;
      case Mode::kLeaving:
        output.note = "captured";
        if (armed_ || in_mode_s_ > config_.after_capture_s) enter(Mode::kChasing);
        break;
      case Mode::kChasing:
        output.note = "chasing";
        outside_s_ = surroundings_.fence.excess_m(target_.at(0.0).p_m) > 0.0 ? outside_s_ + dt_s : 0.0;
        if (!sees)
          lose();
        else if (outside_s_ > config_.fence.patience_s)
          give_up("gave up: the target left the fence");
        break;
      case Mode::kAborted:
        output.note = reason_;
        break;
      case Mode::kDone:
        break;
    }
    if (captured_now_ && mode_ != Mode::kAborted && mode_ != Mode::kDone) {
      captured_now_ = false;
      output.note = "captured";
      const bool enough = config_.captures > 0 && captures_ >= config_.captures;
      if (enough)
        enter(Mode::kDone);
      else if (config_.method == InterceptConfig::Method::kMpc)
        enter(Mode::kLeaving);
    }
    if (config_.captures > 0 && team_.has_caught() && mode_ != Mode::kAborted && mode_ != Mode::kDone) {
      output.note = "another one has captured it";
      enter(Mode::kDone);
    }
    output.mission = mode_ == Mode::kDone      ? MissionStatus::kDone
                     : mode_ == Mode::kAborted ? MissionStatus::kFailed
                                               : MissionStatus::kRunning;
  }

  void enter(Mode mode) {
    if (mode == Mode::kChasing && mode_ != Mode::kLeaving) outside_s_ = 0.0;
    planner_.forget();
    mode_ = mode;
    in_mode_s_ = 0.0;
    since_check_s_ = config_.period_s;  // plan at once
  }

  void lose() {
    // Last known state of the target and its uncertainty.
    last_net_m_.reset();
    search_.begin(target_.at(0.0), std::max(0.5, target_.sigma_m(0.0)), 1.0);
    since_look_s_ = since_replan_s_ = 0.0;
    goal_local_m_ = target_.at(config_.track_timeout_s).p_m;
    highest_m_ = search_.highest_near_m(p_local_m_);
    enter(Mode::kSearching);
  }

  /// The target was another interceptor.
  void forget_target() {
    had_target_ = false;
    last_net_m_.reset();
    if (mode_ == Mode::kChasing || mode_ == Mode::kLeaving || mode_ == Mode::kSearching) enter(Mode::kWaiting);
  }

  void give_up(const char* reason) {
    reason_ = reason;
    enter(Mode::kAborted);
  }

  /// An interceptor that sees a target. With `target` set, only that vehicle's track counts.
  const ChasePeer* peer_with_target() const {
    return config_.target.empty() ? team_.chasing(p_local_m_, now_) : nullptr;
  }

  /// Searches where another interceptor sees its target.
  void go_to_reported_target(const ChasePeer& peer) {
    const PointState reported = peer.target_at(now_);
    search_.begin(reported, kReportedSigma_m, kReportedSigma_mps);
    goal_local_m_ = reported.p_m;
    highest_m_ = search_.highest_near_m(p_local_m_);
    if (mode_ == Mode::kWaiting) {
      since_look_s_ = since_replan_s_ = 0.0;
      enter(Mode::kSearching);
    }
    in_mode_s_ = 0.0;
  }

  void search(double dt_s) {
    since_look_s_ += dt_s;
    since_replan_s_ += dt_s;
    if (since_look_s_ < kLook_s) return;
    if (const ChasePeer* peer = peer_with_target()) go_to_reported_target(*peer);
    search_.advance(since_look_s_, surroundings_.fence);
    search_.look(p_local_m_, since_look_s_, surroundings_.map);
    since_look_s_ = 0.0;
    highest_m_ = search_.highest_near_m(p_local_m_);
    if (since_replan_s_ < kReplan_s) return;
    since_replan_s_ = 0.0;
    goal_local_m_ = search_.most_probable();
  }

  bool chases() const { return mode_ == Mode::kChasing || mode_ == Mode::kLeaving; }

  /// The interceptor with the earliest arrival leads. A leader without a capture for long adds to its arrival time, so
  /// that others try: it may be held off by what its estimate does not model.
  void divide_task() {
    const double change_s = team_.leads() && chases() ? since_check_s_ : -since_check_s_;
    led_for_s_ = std::clamp(led_for_s_ + change_s, 0.0, kLeadTimeout_s + kMaxLeadPenalty_s);
    arrival_s_ = kNeverThere_s;
    const bool could = chases() && outside_s_ == 0.0;
    if (could) {
      const Reference& r = governor_.state();
      arrival_s_ = planner_.least_time_s({r.position_m, r.velocity_mps, r.acceleration_mps2}, target_, to_target_m());
      arrival_s_ += std::max(0.0, led_for_s_ - kLeadTimeout_s);
      if (mode_ == Mode::kLeaving) arrival_s_ += config_.after_capture_s;
    }
    team_.decide(now_, could ? std::optional(arrival_s_) : std::nullopt);
  }

  void report(const StateEstimate& estimate, Outbox& outbox) {
    const bool caught = mode_ == Mode::kDone && captures_ >= config_.captures;
    const ChaseReport::Status status = chases()
                                           ? team_.leads() ? ChaseReport::Status::kLeads : ChaseReport::Status::kYields
                                       : caught                    ? ChaseReport::Status::kCaught
                                       : mode_ == Mode::kSearching ? ChaseReport::Status::kSearches
                                                                   : ChaseReport::Status::kIdle;
    const PointState target = chases() ? target_.at(0.0) : PointState{goal_local_m_, Vector3::Zero(), Vector3::Zero()};
    team_.report(status, now_, arrival_s_, target, path_ahead(), FrameChange::to_world(estimate), outbox);
  }

  /// Predicted path of the vehicle from its present plan.
  PathAhead path_ahead() {
    const double yaw_rad = yaw_rad_;
    ReferenceGovernor tried = governor_;
    PathAhead path;
    path.places_local_m[0] = tried.state().position_m + bias_local_m_;
    double ahead_s = 0.0;
    for (path.num_places = 1; path.num_places < PathAhead::kMaxPlaces; ++path.num_places) {
      for (int i = 0; i < kPathParts; ++i, ahead_s += path.interval_s / kPathParts)
        fly(tried, since_check_s_ + ahead_s, ahead_s, path.interval_s / kPathParts);
      path.places_local_m[static_cast<std::size_t>(path.num_places)] = tried.state().position_m + bias_local_m_;
    }
    yaw_rad_ = yaw_rad;
    return path;
  }

  /// Simulates the next period and brakes instead if the vehicle could not stop in time after it.
  void plan() {
    const double since_last_s = since_check_s_;
    since_check_s_ = 0.0;
    if (mode_ == Mode::kChasing && config_.method == InterceptConfig::Method::kMpc) {
      const Reference& r = governor_.state();
      planner_.plan({r.position_m, r.velocity_mps, r.acceleration_mps2}, target_, to_target_m(), side(), surroundings_,
                    since_last_s);
    }
    brakes_ = false;
    ReferenceGovernor tried = governor_;
    const int steps = std::max(1, static_cast<int>(std::ceil(config_.period_s / kCheckStep_s)));
    for (int i = 0; i < steps; ++i) fly(tried, i * kCheckStep_s, i * kCheckStep_s, kCheckStep_s);
    const double allowed_m = std::max(0.0, surroundings_.intrusion_m(governor_.state().position_m, 0.0));
    brakes_ = !can_stop(tried, surroundings_, config_.period_s, allowed_m);
  }

  /// Displacement from the reference's goal to the target at which the net meets the target.
  Vector3 to_target_m() const {
    const Vector3 offset_m = config_.net.center(Vector3::Zero(), governor_.state().yaw_rad);
    const PointState target = target_.at(0.0);
    return offset_m + bias_local_m_ - beside_m(target, offset_m);
  }

  /// Side of the target on which the net is, 1: above; 0 for a volume, which catches from any side.
  double side() {
    const double above_m = net_m().z() - target_.at(0.0).p_m.z();
    if (std::abs(above_m) > kSameHeight_m) side_ = above_m > 0.0 ? 1.0 : -1.0;
    return config_.net.height_m > 0.0 ? 0.0 : side_;
  }

  /// From below with a net below the vehicle, the vehicle first flies past the target, not through it.
  Vector3 beside_m(const PointState& target, const Vector3& offset_m) const {
    const Vector3 from_target = p_local_m_ - target.p_m;
    const double clear_m = config_.target_clearance_m;
    if (offset_m.z() >= 0.0 || clear_m <= 0.0 || from_target.z() > kAboveBy * clear_m) return Vector3::Zero();
    Vector3 side(from_target.x(), from_target.y(), 0.0);
    if (side.norm() < kNoSide_m) side = Vector3(-target.v_mps.y(), target.v_mps.x(), 0.0);
    if (side.norm() < kNoSide_m) side = Vector3::UnitX();
    return kBesideBy * clear_m * side.normalized();
  }

  /// Moves the reference by one step of the present motion, `since_s` after it was decided. Moving obstacles are known
  /// as of `ahead_s` ago: simulations look ahead, the flight does not.
  void fly(ReferenceGovernor& governor, double since_s, double ahead_s, double dt_s) {
    if (brakes_) {
      governor.accelerate(braking_mps2(governor.state(), surroundings_, ahead_s, limits_), yaw_rad_, dt_s);
    } else if (mode_ == Mode::kChasing && config_.method == InterceptConfig::Method::kMpc) {
      const PointState planned = planner_.at(since_s + dt_s);
      Reference goal;
      goal.position_m = planned.p_m;
      goal.velocity_mps = planned.v_mps;
      goal.acceleration_mps2 = planned.a_mps2;
      goal.yaw_rad = face(target_.at(ahead_s).p_m);
      governor.step(goal, dt_s);
    } else if (mode_ == Mode::kChasing) {
      governor.accelerate(law_mps2(governor.state(), ahead_s), face(target_.at(ahead_s).p_m), dt_s);
    } else if (mode_ == Mode::kLeaving) {
      governor.accelerate(leaving_mps2(governor.state()), face(target_.at(ahead_s).p_m), dt_s);
    } else {
      Reference goal;
      goal.position_m = watch_local_m_;
      // The net, not the vehicle, flies to the probable position of a lost target.
      if (mode_ == Mode::kSearching) {
        const Vector3 to_net_m = config_.net.center(Vector3::Zero(), governor.state().yaw_rad);
        goal.position_m = goal_local_m_ - to_net_m;
        // Targets that may be below, unseen, stay below.
        if (to_net_m.z() < 0.0) goal.position_m.z() = std::max(goal.position_m.z(), highest_m_ - to_net_m.z());
      }
      if (mode_ == Mode::kDone) goal.position_m.z() += kHighAbove_m;  // above all others after the last capture
      goal.position_m = surroundings_.fence.inside(goal.position_m);
      goal.yaw_rad = face(goal.position_m);
      governor.step(goal, dt_s);
    }
  }

  Vector3 law_mps2(const Reference& self, double ahead_s) const {
    const PointState target = target_.at(ahead_s);
    const Vector3 net = config_.net.center(self.position_m + bias_local_m_, self.yaw_rad);
    const RelativeMotion relative{target.p_m - net, target.v_mps - self.velocity_mps};
    const Vector3 a_mps2 = config_.method == InterceptConfig::Method::kFrpn ? frpn_mps2(config_.gains, relative)
                           : config_.method == InterceptConfig::Method::kProportionalNavigation
                               ? proportional_navigation_mps2(config_.gains, relative)
                               : pure_pursuit_mps2(config_.gains, relative);
    return within_acceleration(a_mps2, limits_);
  }

  /// Leaves a caught target until the net is armed again, along the present motion past it.
  Vector3 leaving_mps2(const Reference& self) const {
    const PointState target = target_.at(0.0);
    Vector3 away = self.velocity_mps - target.v_mps;
    if (away.head<2>().norm() < kSlowest_mps) away = -target.v_mps;
    away.z() = 0.0;
    if (away.norm() < kSlowest_mps) away = Vector3::UnitX();
    return away.normalized() * limits_.horizontal_acceleration_mps2;
  }

  double face(const Vector3& place_local_m) {
    const Vector3 to = place_local_m - p_local_m_;
    if (to.head<2>().norm() > kShortestToFace_m) yaw_rad_ = elementary::atan2(to.y(), to.x());
    return yaw_rad_;
  }

  InterceptConfig config_;
  MotionLimits limits_;
  ReferenceGovernor governor_;  // flown reference, in the local frame
  ChasePlanner planner_;
  TargetSearch search_;
  ChaseTeam team_;
  Surroundings surroundings_;
  TargetPrediction target_;
  std::uint32_t target_id_ = 0;
  CaptureVolume sure_net_;          // part of the net in which the track must be for a capture
  std::optional<TimeNs> measured_;  // time of the last measurement of the target; its track continues by prediction
  TimeNs seen_ = 0;
  bool had_target_ = false;
  Vector3 watch_local_m_;
  Vector3 goal_local_m_ = Vector3::Zero();  // goal of a search
  double highest_m_ = 0.0;                  // greatest possible height of a lost target near the vehicle
  Vector3 p_local_m_ = Vector3::Zero();
  Vector3 bias_local_m_ = Vector3::Zero();  // difference between estimate and reference
  double yaw_rad_;
  Mode mode_ = Mode::kWaiting;
  const char* reason_ = "";
  double in_mode_s_ = 0.0, outside_s_ = 0.0, since_check_s_ = 0.0, since_look_s_ = 0.0, since_replan_s_ = 0.0;
  double side_ = 1.0;
  bool started_ = false, brakes_ = false;
  std::optional<Vector3> last_net_m_;  // last position of the target relative to the net
  bool armed_ = true, captured_now_ = false;
  TimeNs now_ = 0;
  double arrival_s_ = 0.0, led_for_s_ = 0.0;
  int captures_ = 0;
};

}  // namespace

std::unique_ptr<Guidance> make_intercept(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Intercept>(dynamic_cast<const InterceptConfig&>(config), setup);
}

}  // namespace swiftlet
