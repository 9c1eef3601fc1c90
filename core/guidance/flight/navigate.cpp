// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/navigate.hpp"

#include <algorithm>
#include <optional>

#include "core/guidance/flight/planned_flight.hpp"
#include "core/guidance/path_overlay.hpp"
#include "swiftlet/core/guidance/kept_apart.hpp"

namespace swiftlet {
namespace {

/// [-] share of the acceleration that paths use; the rest is for corrections. Larger values fly faster, and farther off
/// the path.
constexpr double kPathShare = 0.8;

/// Limits of a path that the reference governor can follow.
PathLimits path_limits(double speed_mps, const MotionLimits& limits) {
  return {.speed_mps = std::min(speed_mps, limits.horizontal_speed_mps),
          .vertical_speed_mps = std::min(speed_mps, limits.vertical_speed_mps),
          .acceleration_mps2 = kPathShare * limits.horizontal_acceleration_mps2,
          .vertical_acceleration_mps2 = kPathShare * limits.vertical_acceleration_mps2};
}

class Navigate : public PlannedFlight {
 public:
  Navigate(const NavigateConfig& config, const GuidanceSetup& setup)
      : PlannedFlight(setup,
                      {.speed_mps = config.speed_mps,
                       .planning_latency_s = config.planning_latency_s,
                       .retry_after_s = config.retry_after_s,
                       .retries = config.retries,
                       .first = State::kPlanning,
                       .end = config.goals_m.empty() ? MissionStatus::kEndless : MissionStatus::kDone},
                      PathFollower(config.planner, config.visited_m)),
        config_(config),
        limits_(path_limits(config.speed_mps, setup.limits)) {}

  void append_overlays(std::vector<Overlay>& overlays) const override {
    if (follower_.corners_local_m().empty()) return;
    Overlay path = path_overlay("navigate.path", follower_.corners_local_m(), 4.0F);
    path.kind = Overlay::Kind::kPolyline;
    path.legend = {{"planned path", path.colors.front()}};
    overlays.push_back(std::move(path));
  }

  void append_counters(std::vector<Counter>& counters) const override {
    const bool cells = config_.search == NavigateConfig::Search::kAStar;
    counters.push_back({"path searches that ended at their budget", num_given_up_, num_plans_,
                        cells ? "planner.max_expansions" : "sampling.max_samples"});
  }

 private:
  void plan(const GuidanceInput& input) override {
    if (next_goal_ == config_.goals_m.size() && !config_.goals_m.empty() && ++rounds_flown_ != config_.rounds) {
      next_goal_ = 0;
    }
    if (next_goal_ == config_.goals_m.size()) {
      enter(State::kDone);
    } else if (planner_.due(now_)) {
      take_plan(input);
    } else if (planner_.idle() && input.estimate.v_local_mps.norm() < PathFollower::kHovers_mps) {
      const Vector3 goal_local_m = FrameChange::to_local(input.estimate).point(config_.goals_m[next_goal_]);
      path_ = search(*input.map, input.estimate.T_local_body.translation(), goal_local_m);
      ++num_plans_;
      if (path_.status == ClearPathStatus::kBudgetSpent) ++num_given_up_;
      planner_.start(now_);
    } else if (waited(config_.stage_timeout_s)) {
      fail("the vehicle does not come to rest");
    }
  }

  ClearPath search(const OccupancyView& map, const Vector3& p_local_m, const Vector3& goal_local_m) const {
    if (config_.search == NavigateConfig::Search::kAStar) {
      return find_clear_path(map, config_.planner, p_local_m, goal_local_m);
    }
    const SampledSearch sampled_search =
        config_.search == NavigateConfig::Search::kRrt ? SampledSearch::kRrt : SampledSearch::kInformedRrtStar;
    return find_sampled_path(map, config_.planner, config_.sampling, sampled_search, p_local_m, goal_local_m,
                             static_cast<std::uint32_t>(num_plans_));
  }

  void take_plan(const GuidanceInput& input) {
    if (path_.status != ClearPathStatus::kFound) {
      fail(text_of(path_.status));
      return;
    }
    std::optional<SplineTrajectory> timed;
    if (config_.follow == NavigateConfig::Follow::kTimed) {
      const ClearSpace space(*input.map, config_.planner, path_.corners_local_m.front());
      const auto is_clear = [&space](const Vector3& p_local_m) { return space.is_clear(p_local_m); };
      timed = time_path(path_.corners_local_m, limits_, is_clear, 0.0);  // without room, corners are taken slowly
    }
    if (timed) {
      follower_.start(std::move(path_.corners_local_m), std::move(*timed));
    } else {  // no room to round the corners
      follower_.start(std::move(path_.corners_local_m));
    }
    enter(State::kFlying);
  }

  void follow(const GuidanceInput& input) override {
    const PathFollower::Outcome outcome = follower_.step(input);
    const double yaw_rad = hold_.yaw_rad;
    hold_ = follower_.target_local();
    hold_.yaw_rad = yaw_rad;
    if (outcome == PathFollower::Outcome::kArrived) {
      succeed();
      // A correction may have moved the goal since the path was planned; then the rest is planned again.
      const Vector3 goal_local_m = FrameChange::to_local(input.estimate).point(config_.goals_m[next_goal_]);
      if ((goal_local_m - follower_.corners_local_m().back()).norm() < config_.visited_m) ++next_goal_;
    }
    if (outcome != PathFollower::Outcome::kFlying) {
      hold_ = {.position_m = hold_.position_m, .yaw_rad = yaw_rad};
      enter(State::kPlanning);
    } else if (waited(config_.stage_timeout_s)) {
      fail("the vehicle does not reach its goal");
    }
  }

  const char* note_of(State state) const override {
    return state == State::kPlanning ? "planning"
           : state == State::kFlying ? "flying to the goal"
                                     : "all goals reached";
  }

  NavigateConfig config_;
  PathLimits limits_;
  ClearPath path_;
  std::size_t next_goal_ = 0;
  int rounds_flown_ = 0;
};

}  // namespace

void NavigateConfig::visit(ConfigVisitor& v) {
  v.field("goals_m", goals_m, "[m] goals in order, world frame", Range::between(-1e5, 1e5));
  v.destinations("goals_m", goals_m);
  v.field("rounds", rounds, "[-] number of rounds through all goals; 0: without end", Range::between(0, 1e6));
  v.choice("search", search, {"a_star", "rrt", "informed_rrt_star"},
           "[-] cell by cell (a_star), or by random samples: the first path (rrt), or one that gets ever shorter");
  v.choice("follow", follow, {"corners", "timed"},
           "[-] from corner to corner, or along a smooth path with its times; where that has no room, by corners");
  v.field("speed_mps", speed_mps, "[m/s] largest horizontal speed, and largest vertical speed", Range::positive());
  v.field("visited_m", visited_m, "[m] distance within which a corner of the path counts as visited",
          Range::positive());
  v.field("planning_latency_s", planning_latency_s,
          "[s] delay from the start of a search to its result, as of the onboard computer",
          Range::between(0.0, 1000.0));
  v.field("stage_timeout_s", stage_timeout_s,
          "[s] duration of planning, or of a flight to a goal, after which it has failed", Range::positive());
  v.field("retries", retries, "[-] new plans after failures; the next failure then fails the mission",
          Range::between(0, 1e6));
  v.object("planner", planner, "limits of the path, and search by a_star");
  v.object("sampling", sampling, "search by rrt and informed_rrt_star");
  v.object("separation", separation, "separation from neighbors, in addition to the avoidance of the guidance itself");
}

std::unique_ptr<Guidance> make_navigate(const ModuleConfig& config, const GuidanceSetup& setup) {
  const auto& navigate = dynamic_cast<const NavigateConfig&>(config);
  return kept_apart(std::make_unique<Navigate>(navigate, setup), navigate.separation, setup);
}

}  // namespace swiftlet
