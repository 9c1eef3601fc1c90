// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/share_paths.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/heading.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/shared_path.hpp"

namespace swiftlet {
namespace {

/// Constants of shared paths.
struct PathConstants {
  /// [s] longest duration of a plan. Larger values admit longer paths and take more time to plan.
  static constexpr double kLongest_s = 6.0;
  /// [s] interval between points of a predicted path, and [-] steps of the governor in it. Larger intervals save time
  /// and overlook short conflicts.
  static constexpr double kInterval_s = 0.1;
  static constexpr int kParts = 5;
  /// [s] interval between points of the path sent. Larger values save radio capacity.
  static constexpr double kReportInterval_s = 0.2;
  /// [m] distance to the goal at which the prediction of a path ends, at rest. Smaller values make paths longer.
  static constexpr double kAtRest_m = 0.05;
  /// [s] period of repeated messages, against losses. Larger values save radio capacity.
  static constexpr double kRepeat_s = 0.2;
  /// [m] least improvement of a plan over the flown path. Smaller values change paths more often.
  static constexpr double kBetter_m = 0.05;
  /// [m/s] cost of a path's duration, as a distance from the goal. Larger values prefer short paths.
  static constexpr double kDurationCost_mps = 0.2;
  /// Candidates of a plan: [s] greatest length at full speed, [m] least length, [-] shares of the greatest length,
  /// [deg] turns and climbs from the direction of the goal. More candidates find better plans and take more time.
  static constexpr double kHorizon_s = 2.0, kLeg_m = 0.5;
  static constexpr double kShares[] = {1.0, 0.5, 0.2};
  static constexpr double kTurns_deg[] = {0.0, -20.0, 20.0, -45.0, 45.0, -80.0, 80.0, -120.0, 120.0};
  static constexpr double kClimbs_deg[] = {0.0, 35.0, -35.0};
};

PathInTime received_path(const SharedPath& received, const FrameChange& to_local) {
  PathInTime path{received.t, received.interval_s, {}};
  for (const SharedPath::Place& place : received.places) {
    path.places_local_m.push_back(to_local.point(place.p_world_m.cast<double>()));
  }
  return path;
}

class SharePaths : public Guidance {
 public:
  SharePaths(const SharePathsConfig& config, const GuidanceSetup& setup)
      : config_(config), limits_(setup.limits), governor_(setup.limits) {
    // Planning times are staggered: simultaneous plans would all block each other.
    next_plan_ = from_seconds(config.period_s * setup.agent.self / std::max(1, setup.agent.num_vehicles));
    others_.resize(static_cast<std::size_t>(setup.agent.num_vehicles));
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    now_ = input.observation.t;
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    if (!started_) start(input.estimate);
    listen(input.observation, to_local);
    const Vector3 goal_local_m = to_local.point(config_.goal_m);
    if (plan_ && now_ >= checked_) decide();
    if (!plan_ && now_ >= next_plan_) {
      next_plan_ += from_seconds(config_.period_s);
      plan(goal_local_m, to_local);
      if (plan_) report(input.estimate, SharedPath::Kind::kPlan, plan_->path, outbox);
    }
    if (now_ >= next_report_) {
      next_report_ = now_ + from_seconds(PathConstants::kRepeat_s);
      report(input.estimate, SharedPath::Kind::kFlown, flown_.path, outbox);
      if (plan_) report(input.estimate, SharedPath::Kind::kPlan, plan_->path, outbox);
    }
    fly(input, output);
    Vector3 to_goal_m = goal_local_m - input.estimate.T_local_body.translation();
    if (config_.planar) to_goal_m.z() = 0.0;
    arrived_ = arrived_ || to_goal_m.norm() <= config_.arrival_radius_m;
    output.mission = arrived_ ? MissionStatus::kDone : MissionStatus::kRunning;
  }

 private:
  /// A path to a position, from the governor's state at some time.
  struct Flight {
    ReferenceGovernor from;
    Vector3 to_local_m = Vector3::Zero();
    PathInTime path;
  };
  struct Other {
    std::optional<PathInTime> flown, plan;
  };

  void start(const StateEstimate& estimate) {
    started_ = true;
    Reference here;
    here.position_m = estimate.T_local_body.translation();
    here.yaw_rad = yaw_of(estimate.T_local_body.linear());
    governor_.reset(here);
    flown_.to_local_m = here.position_m;
    flown_.path = {now_, PathConstants::kInterval_s, {here.position_m}};
  }

  void listen(const Observation& observation, const FrameChange& to_local) {
    for (const Message& message : observation.messages) {
      SharedPath received;
      if (read_message(message, received) != Reading::kDone || received.places.empty() || !(received.interval_s > 0.0))
        continue;
      if (message.from < 0 || message.from >= static_cast<VehicleId>(others_.size())) continue;
      Other& other = others_[static_cast<std::size_t>(message.from)];
      if (received.kind == SharedPath::Kind::kPlan) {
        other.plan = received_path(received, to_local);
        has_conflict_ = has_conflict_ || (plan_ && !keeps_clear(plan_->path, *other.plan));
      } else {
        other.flown = received_path(received, to_local);
        if (other.plan && other.plan->t <= other.flown->t) other.plan.reset();
      }
    }
  }

  bool keeps_clear(const PathInTime& own, const PathInTime& other) const {
    const double distance_m = 2.0 * config_.encumbrance_m + config_.margin_m;
    return least_distance_m(own, other, now_, distance_m, config_.planar ? distance_m : config_.vertical_m) >=
           distance_m;
  }
  bool keeps_clear(const PathInTime& own) const {
    return std::all_of(others_.begin(), others_.end(), [&](const Other& other) {
      return (!other.flown || keeps_clear(own, *other.flown)) && (!other.plan || keeps_clear(own, *other.plan));
    });
  }

  void decide() {
    if (!has_conflict_ && keeps_clear(plan_->path)) {
      flown_.to_local_m = plan_->to_local_m;
      flown_.path = plan_->path;
      next_report_ = now_;
    }
    plan_.reset();
  }

  /// The governor's path to a position, until it rests there.
  PathInTime path_to(ReferenceGovernor governor, const Vector3& to_local_m, TimeNs begins) const {
    PathInTime path{begins, PathConstants::kInterval_s, {governor.state().position_m}};
    Reference goal;
    goal.position_m = to_local_m;
    goal.yaw_rad = governor.state().yaw_rad;
    const int most = static_cast<int>(PathConstants::kLongest_s / PathConstants::kInterval_s);
    for (int i = 0; i < most; ++i) {
      for (int k = 0; k < PathConstants::kParts; ++k)
        governor.step(goal, PathConstants::kInterval_s / PathConstants::kParts, config_.speed_mps);
      path.places_local_m.push_back(governor.state().position_m);
      const bool there = (governor.state().position_m - to_local_m).norm() < PathConstants::kAtRest_m;
      if (there && governor.state().velocity_mps.norm() < kAtRest_mps) break;
    }
    return path;
  }

  void plan(const Vector3& goal_local_m, const FrameChange& to_local) {
    has_conflict_ = false;
    // Plans from the state at the end of the check.
    ReferenceGovernor from = governor_;
    Reference goal = from.state();
    goal.position_m = flown_.to_local_m;
    goal.velocity_mps.setZero();
    goal.acceleration_mps2.setZero();
    const TimeNs begins = now_ + from_seconds(config_.check_s);
    const double step_s = PathConstants::kInterval_s / PathConstants::kParts;
    for (TimeNs t = now_; t < begins; t += from_seconds(step_s)) from.step(goal, step_s, config_.speed_mps);
    const Vector3 p_m = from.state().position_m;
    Vector3 ahead_m = goal_local_m - p_m;
    if (config_.planar) ahead_m.z() = 0.0;
    double best_m = cost_m(flown_.path, goal_local_m) - PathConstants::kBetter_m;
    const auto consider = [&](Vector3 to_m) {
      if (!config_.planar) {
        to_m.z() = std::clamp(to_m.z(), to_local.height(config_.z_min_m), to_local.height(config_.z_max_m));
      }
      PathInTime path = path_to(from, to_m, begins);
      const double cost = cost_m(path, goal_local_m);
      if (cost >= best_m || !keeps_clear(path)) return;
      best_m = cost;
      plan_ = Flight{from, to_m, std::move(path)};
    };
    const double far_m = std::min(ahead_m.norm(), config_.speed_mps * PathConstants::kHorizon_s);
    if (far_m < kNearest_m) return;
    const Vector3 straight = ahead_m.normalized();
    for (const double share : PathConstants::kShares) {
      for (const double turn_deg : PathConstants::kTurns_deg) {
        for (const double climb_deg : PathConstants::kClimbs_deg) {
          if (climb_deg != 0.0 && config_.planar) continue;
          Vector3 direction = Eigen::AngleAxisd(turn_deg * kRadPerDeg, Vector3::UnitZ()) * straight;
          direction.z() += elementary::sin(climb_deg * kRadPerDeg);
          consider(p_m + std::max(share * far_m, std::min(far_m, PathConstants::kLeg_m)) * direction.normalized());
        }
      }
    }
    if (plan_) checked_ = begins;
  }

  /// Cost of a path: distance of its end from the goal, plus its duration as a distance.
  double cost_m(const PathInTime& path, const Vector3& goal_local_m) const {
    const Vector3 rest_m = goal_local_m - path.places_local_m.back();
    const double left_m = config_.planar ? elementary::hypot(rest_m.x(), rest_m.y()) : rest_m.norm();
    return left_m + PathConstants::kDurationCost_mps * std::max(0.0, to_seconds(path.end() - now_));
  }

  void report(const StateEstimate& estimate, SharedPath::Kind kind, const PathInTime& path, Outbox& outbox) {
    sent_.kind = kind;
    sent_.t = std::max(now_, path.t);
    sent_.interval_s = PathConstants::kReportInterval_s;
    sent_.places.clear();
    for (TimeNs t = sent_.t;; t += from_seconds(PathConstants::kReportInterval_s)) {
      sent_.places.push_back({(estimate.T_world_local * path.at_local_m(t)).cast<float>()});
      if (t >= path.end()) break;
    }
    write_message(sent_, outbox.add());
  }

  void fly(const GuidanceInput& input, GuidanceOutput& output) {
    Reference goal = governor_.state();
    goal.position_m = flown_.to_local_m;
    goal.velocity_mps.setZero();
    goal.acceleration_mps2.setZero();
    output.goal = governor_.step(goal, input.dt_s, config_.speed_mps);
    output.goal_is_feasible = true;
    output.speed_limit_mps = config_.speed_mps;
  }

  SharePathsConfig config_;
  MotionLimits limits_;
  ReferenceGovernor governor_;
  TimeNs now_ = 0, next_plan_ = 0, checked_ = 0, next_report_ = 0;
  bool started_ = false, has_conflict_ = false, arrived_ = false;
  Flight flown_{ReferenceGovernor(MotionLimits{}), Vector3::Zero(), {}};
  std::optional<Flight> plan_;
  std::vector<Other> others_;  // indexed by VehicleId
  SharedPath sent_;            // kept to reuse its memory
};

}  // namespace

Vector3 PathInTime::at_local_m(TimeNs now) const {
  const double i = to_seconds(now - t) / interval_s;
  if (i <= 0.0) return places_local_m.front();
  const auto before = static_cast<std::size_t>(i);
  if (before + 1 >= places_local_m.size()) return places_local_m.back();
  const double share = i - static_cast<double>(before);
  return (1.0 - share) * places_local_m[before] + share * places_local_m[before + 1];
}

double least_distance_m(const PathInTime& a, const PathInTime& b, TimeNs from, double distance_m, double vertical_m) {
  const Vector3 scale(1.0, 1.0, distance_m / vertical_m);
  double least_m = std::numeric_limits<double>::infinity();
  const TimeNs last = std::max(a.end(), b.end());
  for (TimeNs t = std::max(from, a.t);; t += from_seconds(PathConstants::kInterval_s)) {
    least_m = std::min(least_m, scale.cwiseProduct(a.at_local_m(t) - b.at_local_m(t)).norm());
    if (t >= last) return least_m;
  }
}

void SharePathsConfig::visit(ConfigVisitor& v) {
  v.field("goal_m", goal_m, "[m] world");
  v.field("arrival_radius_m", arrival_radius_m, "[m] distance to the goal within which the mission is done",
          Range::positive());
  v.field("speed_mps", speed_mps, "[m/s] largest speed", Range::positive());
  v.field("encumbrance_m", encumbrance_m, "[m] radius of the sphere that a vehicle occupies", Range::positive());
  v.field("margin_m", margin_m, "[m] margin added to the sum of the encumbrances", Range::non_negative());
  v.field("vertical_m", vertical_m, "[m] vertical distance to keep between two vehicles, because of the downwash",
          Range::positive());
  v.field("check_s", check_s,
          "[s] delay check: time in which a conflicting path cancels a plan; at least the delay of the radio",
          Range::non_negative());
  v.field("z_min_m", z_min_m, "[m] lowest flight level");
  v.field("z_max_m", z_max_m, "[m] highest flight level");
  v.field("planar", planar, "[-] flight at the height of the start");
  if (!planar) v.destinations("goal_m", goal_m);
  v.check(z_max_m > z_min_m, "z_max_m", "more than z_min_m");
}

std::unique_ptr<Guidance> make_share_paths(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<SharePaths>(dynamic_cast<const SharePathsConfig&>(config), setup);
}

}  // namespace swiftlet
