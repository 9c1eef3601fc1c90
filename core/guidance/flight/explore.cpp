// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/explore.hpp"

#include "core/guidance/flight/path_follower.hpp"
#include "core/guidance/path_overlay.hpp"
#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {
namespace {

constexpr int kMoreRays = 16;  // factor on the rays of a view, to find what stays unknown
// Share of a view's unknown rays that are known before arrival, at which the flight to it ends.
constexpr double kSeenEnough = 0.5;

class Explore : public Guidance {
 public:
  Explore(const ExploreConfig& config, const GuidanceSetup& setup)
      : config_(config),
        given_up_(config.view.grain_m),
        planner_(config.planning_latency_s),
        follower_(config.view.path, config.visited_m) {
    hold_.position_m = setup.agent.T_local_body_start.translation();
    hold_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
  }

  GuidanceNeeds needs() const override { return {.map = true}; }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    now_ = input.observation.t;
    if (!started_) enter(State::kLooking);
    started_ = true;
    switch (state_) {
      case State::kLooking:
        look(input);
        break;
      case State::kPlanning:
        plan(input);
        break;
      case State::kFlying:
        follow(input);
        break;
      case State::kFailure:
        if (failures_ <= config_.retries && waited(config_.retry_after_s)) enter(State::kLooking);
        break;
      case State::kDone:
        break;
    }
    output.goal = hold_;
    output.speed_limit_mps = config_.speed_mps;
    fill(output);
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    const std::vector<Vector3>& corners_local_m = follower_.corners_local_m();
    if (corners_local_m.empty()) return;
    overlays.push_back(path_overlay("explore.path", corners_local_m, 0.1F));
    overlays.push_back(path_overlay("explore.view", {&corners_local_m.back(), 1}, 0.3F));
  }

  void append_counters(std::vector<Counter>& counters) const override {
    counters.push_back({"searches for a view that were given up", num_given_up_, num_plans_, "view.max_expansions"});
  }

 private:
  enum class State { kLooking, kPlanning, kFlying, kFailure, kDone };

  void enter(State state) {
    state_ = state;
    entered_ = now_;
    planner_.stop();
  }
  bool waited(double seconds) const { return now_ - entered_ >= from_seconds(seconds); }

  WorldBox box(const StateEstimate& estimate) const {
    return {config_.box_min_world_m, config_.box_max_world_m, estimate.T_world_local};
  }

  /// Unknown space in sight of a position.
  void see(const GuidanceInput& input, const Vector3& p_local_m, int num_rays) {
    unknown_in_sight(*input.map, config_.view, box(input.estimate), given_up_, p_local_m, num_rays, dark_local_m_);
  }

  /// Abandons space that is still unknown after some scans from here: it is not visible from here, and hardly from
  /// elsewhere.
  void look(const GuidanceInput& input) {
    const bool hovers = input.estimate.v_local_mps.norm() < PathFollower::kHovers_mps;
    if (!hovers && waited(config_.stage_timeout_s)) return fail("the vehicle does not come to rest");
    if (!hovers || !waited(config_.look_s)) return;
    if (at_view_) {
      see(input, input.estimate.T_local_body.translation(), kMoreRays * config_.view.num_rays);
      for (const Vector3& p_local_m : dark_local_m_) given_up_.add(p_local_m);
    }
    enter(State::kPlanning);
  }

  void plan(const GuidanceInput& input) {
    if (planner_.idle()) {
      found_ = find_next_view(*input.map, config_.view, box(input.estimate), given_up_,
                              input.estimate.T_local_body.translation());
      ++num_plans_;
      if (found_.status == NextViewStatus::kBudgetSpent) ++num_given_up_;
      planner_.start(now_);
    } else if (planner_.due(now_)) {
      take_plan();
    }
  }

  void take_plan() {
    switch (found_.status) {
      case NextViewStatus::kFound:
        expected_share_ = found_.share;
        follower_.start(std::move(found_.corners_local_m));
        return enter(State::kFlying);
      case NextViewStatus::kNothingLeft:
        return enter(State::kDone);
      case NextViewStatus::kStartEnclosed:
        return fail("no clear space around the start");
      case NextViewStatus::kBudgetSpent:
        return fail("the search for a view was given up");
    }
  }

  void follow(const GuidanceInput& input) {
    const PathFollower::Outcome outcome = follower_.step(input);
    hold_.position_m = follower_.target_local_m();
    at_view_ = outcome == PathFollower::Outcome::kArrived;
    if (at_view_) failures_ = 0;
    if (outcome == PathFollower::Outcome::kFlying && shows_enough(input)) {
      hold_.position_m = input.estimate.T_local_body.translation();
      enter(State::kLooking);
    } else if (outcome != PathFollower::Outcome::kFlying) {
      enter(State::kLooking);
    } else if (waited(config_.stage_timeout_s)) {
      fail("the vehicle does not reach its view");
    }
  }

  /// Is most of the unknown space expected in the view known before arrival?
  bool shows_enough(const GuidanceInput& input) {
    if (tested_revision_ == input.map->revision()) return false;
    tested_revision_ = input.map->revision();
    see(input, follower_.corners_local_m().back(), config_.view.num_rays);
    return static_cast<double>(dark_local_m_.size()) < (1.0 - kSeenEnough) * expected_share_ * config_.view.num_rays;
  }

  void fail(const char* reason) {
    reason_ = reason;
    ++failures_;
    enter(State::kFailure);
  }

  void fill(GuidanceOutput& output) const {
    output.mission = MissionStatus::kRunning;
    switch (state_) {
      case State::kLooking:
        output.note = "looks around";
        return;
      case State::kPlanning:
        output.note = "looks for a view";
        return;
      case State::kFlying:
        output.note = "flies to a view";
        return;
      case State::kDone:
        output.note = "nothing unknown is left that it can see";
        output.mission = MissionStatus::kDone;
        return;
      case State::kFailure:
        output.note = reason_;
        if (failures_ > config_.retries) output.mission = MissionStatus::kFailed;
        return;
    }
  }

  ExploreConfig config_;
  TimeNs now_ = 0, entered_ = 0;
  bool started_ = false;
  State state_ = State::kLooking;
  bool at_view_ = true;  // at the end of a path; false where a flight was ended
  int failures_ = 0;
  const char* reason_ = "";
  GivenUp given_up_;
  std::vector<Vector3> dark_local_m_;
  Worker planner_;
  NextView found_;
  PathFollower follower_;
  double expected_share_ = 0.0;        // share of the rays that end in unknown space at the view
  std::uint64_t tested_revision_ = 0;  // map revision at the last test
  Reference hold_;
  std::uint64_t num_plans_ = 0, num_given_up_ = 0;
};

}  // namespace

void ExploreConfig::visit(ConfigVisitor& v) {
  v.field("box_min_m", box_min_world_m, "[m] lowest corner of the explored box, world frame",
          Range::between(-1e5, 1e5));
  v.field("box_max_m", box_max_world_m, "[m] highest corner of the explored box, world frame",
          Range::between(-1e5, 1e5));
  v.field("speed_mps", speed_mps, "[m/s] highest speed, horizontal and vertical each", Range::positive());
  v.field("visited_m", visited_m, "[m] distance within which a corner of the path counts as visited",
          Range::positive());
  v.field("look_s", look_s, "[s] time to hover at a view while scans are integrated", Range::between(0.0, 1000.0));
  v.field("planning_latency_s", planning_latency_s, "[s] computing time of a plan on board",
          Range::between(0.0, 1000.0));
  v.field("stage_timeout_s", stage_timeout_s, "[s] after which a flight to a view has failed", Range::positive());
  v.field("retries", retries, "[-] plans after failures before the mission fails", Range::between(0, 1e6));
  v.field("retry_after_s", retry_after_s, "[s] to wait after a failure", Range::non_negative());
  v.object("view", view, "evaluation and search of views");
  v.check((box_max_world_m.array() > box_min_world_m.array()).all(), "box_max_m",
          "more than box_min_m along each axis");
}

std::unique_ptr<Guidance> make_explore(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Explore>(dynamic_cast<const ExploreConfig&>(config), setup);
}

}  // namespace swiftlet
