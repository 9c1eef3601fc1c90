// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/explore.hpp"

#include "core/guidance/flight/planned_flight.hpp"
#include "core/guidance/path_overlay.hpp"

namespace swiftlet {
namespace {

/// [-] factor on the rays of a view in the test for remaining unknown space. Smaller values overlook such space, which
/// is then visited again.
constexpr int kMoreRays = 16;
/// [-] share of a view's unknown rays that are known before arrival, at which the flight to it ends. Smaller values
/// plan more often.
constexpr double kSeenEnough = 0.5;
/// [m] edge of the cubes in which unknown space is abandoned. Larger values also abandon space that a later view shows.
constexpr double kGrain_m = 0.5;

class Explore : public PlannedFlight {
 public:
  Explore(const ExploreConfig& config, const GuidanceSetup& setup)
      : PlannedFlight(setup,
                      {.speed_mps = config.speed_mps,
                       .planning_latency_s = config.planning_latency_s,
                       .retry_after_s = config.retry_after_s,
                       .retries = config.retries,
                       .first = State::kLooking},
                      PathFollower(config.view.path, config.visited_m)),
        config_(config),
        given_up_(kGrain_m) {}

  void append_overlays(std::vector<Overlay>& overlays) const override {
    const std::vector<Vector3>& corners_local_m = follower_.corners_local_m();
    if (corners_local_m.empty()) return;
    overlays.push_back(path_overlay("explore.path", corners_local_m, 0.1F));
    overlays.push_back(path_overlay("explore.view", {&corners_local_m.back(), 1}, 0.3F));
  }

  void append_counters(std::vector<Counter>& counters) const override {
    counters.push_back({"view searches that ended at their budget", num_given_up_, num_plans_, "view.max_expansions"});
  }

 private:
  WorldBox box(const StateEstimate& estimate) const {
    return {config_.box_min_world_m, config_.box_max_world_m, estimate.T_world_local};
  }

  /// Unknown space in sight of a position.
  void see(const GuidanceInput& input, const Vector3& p_local_m, int num_rays) {
    unknown_in_sight(*input.map, config_.view, box(input.estimate), given_up_, p_local_m, num_rays, dark_local_m_);
  }

  /// Abandons space that is still unknown after some scans from here: it is not visible from here, and hardly from
  /// elsewhere.
  void look(const GuidanceInput& input) override {
    const bool hovers = input.estimate.v_local_mps.norm() < PathFollower::kHovers_mps;
    if (!hovers && waited(config_.stage_timeout_s)) return fail("the vehicle does not come to rest");
    if (!hovers || !waited(config_.look_s)) return;
    if (at_view_) {
      see(input, input.estimate.T_local_body.translation(), kMoreRays * config_.view.num_rays);
      for (const Vector3& p_local_m : dark_local_m_) given_up_.add(p_local_m);
    }
    enter(State::kPlanning);
  }

  void plan(const GuidanceInput& input) override {
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
        return fail("no view was found within the search budget");
    }
  }

  void follow(const GuidanceInput& input) override {
    const PathFollower::Outcome outcome = follower_.step(input);
    hold_.position_m = follower_.target_local_m();
    at_view_ = outcome == PathFollower::Outcome::kArrived;
    if (at_view_) succeed();
    if (outcome == PathFollower::Outcome::kFlying && shows_enough(input)) {
      hold_.position_m = input.estimate.T_local_body.translation();
      enter(State::kLooking);
    } else if (outcome != PathFollower::Outcome::kFlying) {
      enter(State::kLooking);
    } else if (waited(config_.stage_timeout_s)) {
      fail("the vehicle does not reach its view");
    }
  }

  /// True if most of the unknown space that the view was to show is known before arrival.
  bool shows_enough(const GuidanceInput& input) {
    if (tested_revision_ == input.map->revision()) return false;
    tested_revision_ = input.map->revision();
    see(input, follower_.corners_local_m().back(), config_.view.num_rays);
    return static_cast<double>(dark_local_m_.size()) < (1.0 - kSeenEnough) * expected_share_ * config_.view.num_rays;
  }

  const char* note_of(State state) const override {
    return state == State::kLooking    ? "looking around"
           : state == State::kPlanning ? "planning a view"
           : state == State::kFlying   ? "flying to a view"
                                       : "exploration complete: no visible unknown space is left";
  }

  ExploreConfig config_;
  bool at_view_ = true;  // at the end of a path; false where a flight was ended
  GivenUp given_up_;
  std::vector<Vector3> dark_local_m_;
  NextView found_;
  double expected_share_ = 0.0;        // share of the rays that end in unknown space at the view
  std::uint64_t tested_revision_ = 0;  // map revision at the last test
};

}  // namespace

void ExploreConfig::visit(ConfigVisitor& v) {
  v.field("box_min_m", box_min_world_m, "[m] lowest corner of the explored box, world frame",
          Range::between(-1e5, 1e5));
  v.field("box_max_m", box_max_world_m, "[m] highest corner of the explored box, world frame",
          Range::between(-1e5, 1e5));
  v.field("speed_mps", speed_mps, "[m/s] largest horizontal speed, and largest vertical speed", Range::positive());
  v.field("visited_m", visited_m, "[m] distance within which a corner of the path counts as visited",
          Range::positive());
  v.field("look_s", look_s, "[s] time to hover at a view while scans are integrated", Range::between(0.0, 1000.0));
  v.field("planning_latency_s", planning_latency_s,
          "[s] delay from the start of a search to its result, as of the onboard computer",
          Range::between(0.0, 1000.0));
  v.field("stage_timeout_s", stage_timeout_s, "[s] time after which a flight to a view has failed", Range::positive());
  v.field("retries", retries, "[-] new plans after failures; the next failure then fails the mission",
          Range::between(0, 1e6));
  v.object("view", view, "evaluation and search of views");
  v.check((box_max_world_m.array() > box_min_world_m.array()).all(), "box_max_m",
          "more than box_min_m along each axis");
}

std::unique_ptr<Guidance> make_explore(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Explore>(dynamic_cast<const ExploreConfig&>(config), setup);
}

}  // namespace swiftlet
