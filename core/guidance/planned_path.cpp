// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/planned_path.hpp"

#include <algorithm>

#include "core/guidance/path_overlay.hpp"
#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {
namespace {

constexpr double kHovers_mps = 0.25;  // slower than this, it hovers
constexpr double kArrived_m = 0.3;

/// Of the segment from a to b.
Vector3 nearest_on(const Vector3& a_m, const Vector3& b_m, const Vector3& p_m) {
  const Vector3 way_m = b_m - a_m;
  const double share = way_m.dot(p_m - a_m) / std::max(way_m.squaredNorm(), 1e-12);
  return a_m + std::clamp(share, 0.0, 1.0) * way_m;
}

class PlannedPath : public Guidance {
 public:
  PlannedPath(const PlannedPathConfig& config, const GuidanceSetup& setup)
      : config_(config), planner_(config.planning_latency_s) {
    hold_.position_m = setup.agent.T_local_body_start.translation();
    hold_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
  }

  GuidanceNeeds needs() const override { return {.map = true}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    now_ = input.observation.t;
    switch (state_) {
      case State::kPlanning:
        plan(input);
        break;
      case State::kFlying:
        follow(input);
        break;
      case State::kFailure:
        if (failures_ <= config_.retries && waited(config_.retry_after_s)) enter(State::kPlanning);
        break;
      case State::kDone:
        break;
    }
    output.goal = hold_;
    output.speed_limit_mps = config_.speed_mps;
    tell(output);
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    if (!path_.corners_local_m.empty()) overlays.push_back(path_overlay("planned_path", path_.corners_local_m, 0.1F));
  }

 private:
  enum class State { kPlanning, kFlying, kFailure, kDone };

  void enter(State state) {
    state_ = state;
    entered_ = now_;
    planner_.stop();
  }
  bool waited(double seconds) const { return now_ - entered_ >= from_seconds(seconds); }

  void plan(const GuidanceInput& input) {
    if (next_goal_ == config_.goals_m.size()) {
      enter(State::kDone);
    } else if (planner_.due(now_)) {
      take_plan();
    } else if (planner_.idle() && input.estimate.v_local_mps.norm() < kHovers_mps) {
      const Vector3 goal_local_m = FrameChange::to_local(input.estimate).point(config_.goals_m[next_goal_]);
      path_ = find_clear_path(*input.map, config_.planner, input.estimate.T_local_body.translation(), goal_local_m);
      planner_.start(now_);
    } else if (waited(config_.stage_timeout_s)) {
      fail("the vehicle does not come to rest");
    }
  }

  void take_plan() {
    if (path_.status != ClearPathStatus::kFound) {
      fail(text_of(path_.status));
      return;
    }
    next_corner_ = 1;
    checked_ = 0;
    enter(State::kFlying);
  }

  void follow(const GuidanceInput& input) {
    const Vector3 p_local_m = input.estimate.T_local_body.translation();
    if (is_blocked(*input.map, p_local_m)) {
      hold_.position_m = p_local_m;
      enter(State::kPlanning);
      return;
    }
    const std::vector<Vector3>& corners_local_m = path_.corners_local_m;
    hold_.position_m = corners_local_m[next_corner_];
    const double distance_m = (p_local_m - hold_.position_m).norm();
    const bool last = next_corner_ + 1 == corners_local_m.size();
    if (!last && distance_m < config_.visited_m) ++next_corner_;
    if (last && distance_m < kArrived_m && input.estimate.v_local_mps.norm() < kHovers_mps) {
      failures_ = 0;
      ++next_goal_;
      enter(State::kPlanning);
    } else if (waited(config_.stage_timeout_s)) {
      fail("the vehicle does not reach its goal");
    }
  }

  /// Has the map changed so that the rest of the path is not clear any more?
  bool is_blocked(const OccupancyView& map, const Vector3& p_local_m) {
    if (checked_ == map.revision()) return false;
    checked_ = map.revision();
    // A cell's edge less than it was planned with: an obstacle whose cells flicker makes no other path.
    ClearPathConfig rules = config_.planner;
    rules.clearance_m = std::max(rules.clearance_m - map.edge_m(), 0.5 * map.edge_m());
    const ClearSpace space(map, rules, p_local_m);
    const std::vector<Vector3>& corners_local_m = path_.corners_local_m;
    Vector3 from_local_m = nearest_on(corners_local_m[next_corner_ - 1], corners_local_m[next_corner_], p_local_m);
    for (std::size_t i = next_corner_; i < corners_local_m.size(); ++i) {
      if (!space.is_clear_segment(from_local_m, corners_local_m[i])) return true;
      from_local_m = corners_local_m[i];
    }
    return false;
  }

  void fail(const char* reason) {
    reason_ = reason;
    ++failures_;
    enter(State::kFailure);
  }

  void tell(GuidanceOutput& output) const {
    output.mission = MissionStatus::kRunning;
    switch (state_) {
      case State::kPlanning:
        output.note = "planning";
        return;
      case State::kFlying:
        output.note = "flies to its goal";
        return;
      case State::kDone:
        output.note = "all goals reached";
        output.mission = config_.goals_m.empty() ? MissionStatus::kEndless : MissionStatus::kDone;
        return;
      case State::kFailure:
        output.note = reason_;
        if (failures_ > config_.retries) output.mission = MissionStatus::kFailed;
        return;
    }
  }

  PlannedPathConfig config_;
  TimeNs now_ = 0, entered_ = 0;
  State state_ = State::kPlanning;
  int failures_ = 0;
  const char* reason_ = "";
  Worker planner_;
  ClearPath path_;
  std::size_t next_goal_ = 0, next_corner_ = 1;
  std::uint64_t checked_ = 0;  // revision of the map for which the path was found clear
  Reference hold_;
};

}  // namespace

void PlannedPathConfig::visit(ConfigVisitor& v) {
  v.field("goals_m", goals_m, "[m] where to go, one after the other, world frame", Range::between(-1e5, 1e5));
  v.field("speed_mps", speed_mps, "[m/s] at most, horizontal and vertical each", Range::positive());
  v.field("visited_m", visited_m, "[m] nearer than this, a corner of the path was visited", Range::positive());
  v.field("planning_latency_s", planning_latency_s, "[s] that planning takes on board", Range::between(0.0, 1000.0));
  v.field("stage_timeout_s", stage_timeout_s, "[s] after which planning or a flight has failed", Range::positive());
  v.field("retries", retries, "[-] plans that may follow a failure before the mission fails", Range::between(0, 1e6));
  v.field("retry_after_s", retry_after_s, "[s] to wait after a failure", Range::non_negative());
  v.object("planner", planner, "how the path is searched");
}

std::unique_ptr<Guidance> make_planned_path(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<PlannedPath>(dynamic_cast<const PlannedPathConfig&>(config), setup);
}

}  // namespace swiftlet
