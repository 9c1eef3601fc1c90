// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "tests/support/airframes.hpp"
#include "tests/support/fine_plant.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kControlStep = 4'000'000;

/// The true pose, from which the vehicle should return wherever `too_far` holds.
class ShortSighted : public StateEstimator {
 public:
  explicit ShortSighted(std::function<bool(const Vector3&)> too_far) : too_far_(std::move(too_far)) {}
  const StateEstimate& update(const Observation& observation, Outbox&) override {
    const PoseSample& truth = observation.pose.back();
    estimate_.t = observation.t;
    estimate_.valid = true;
    estimate_.T_local_body = truth.T_world_body;
    estimate_.v_local_mps = truth.v_world_mps;
    estimate_.omega_body_radps = truth.omega_body_radps;
    return estimate_;
  }
  const char* fault() const override { return ""; }
  const char* warning() const override { return should_return() ? "degenerate" : ""; }
  bool should_return() const override { return too_far_(estimate_.T_local_body.translation()); }

 private:
  std::function<bool(const Vector3&)> too_far_;
  StateEstimate estimate_;
};

/// A vehicle whose waypoints lie to the north and then far to the east.
struct ReturningFlight {
  explicit ReturningFlight(std::function<bool(const Vector3&)> too_far, bool lands = false) : plant(testing::x500()) {
    plant.p = {0, 0, 5};
    plant.ground = true;
    AgentSetup setup;
    setup.airframe = testing::x500();
    setup.tick_s = to_seconds(kControlStep);
    setup.T_local_body_start = plant.T_world_body();
    Module module(guidance_module_types(), "waypoints");
    module.as<WaypointsConfig>().waypoints_m = {{0, 10, 5}, {30, 10, 5}};
    if (lands) module.as<WaypointsConfig>().waypoints_m = {{0, 3, 5}};
    module.as<WaypointsConfig>().land_at_end = lands;
    StackStages stages;
    stages.localization = std::make_unique<ShortSighted>(std::move(too_far));
    stages.guidance = make_guidance(module, {setup, MotionLimitsConfig{}.resolve()});
    agent = make_stack(std::move(stages), {}, setup);
  }
  /// Flies for `duration_s`, or until the mission ends.
  const Action& fly(double duration_s) {
    const Action* action = nullptr;
    for (double t_s = 0.0; t_s < duration_s; t_s += to_seconds(kControlStep)) {
      plant.advance(command, to_seconds(kControlStep));
      Observation observation;
      observation.t = plant.t;
      observation.pose = {plant.pose_sample()};
      action = &agent->step(observation);
      command = action->rotor_command;
      farthest_m = std::max(farthest_m, plant.p.x());
      off_path_m = std::max(off_path_m, std::min(std::abs(plant.p.x()), std::abs(plant.p.y() - 10.0)));
      if (action->mission != MissionStatus::kRunning) break;
    }
    return *action;
  }

  testing::FinePlant plant;
  std::unique_ptr<Agent> agent;
  std::array<double, kMaxRotors> command = {0.4, 0.4, 0.4, 0.4};
  double farthest_m = 0.0, off_path_m = 0.0;
};

TEST(WayBack, EndsWhereTheSensorsSeeEnough) {
  bool saw_too_little = false;
  ReturningFlight flight([&](const Vector3& p_m) {  // once lost, structure is recognized from 12 m on
    saw_too_little = p_m.x() > (saw_too_little ? 12.0 : 15.0);
    return saw_too_little;
  });
  const Action& action = flight.fly(60.0);
  EXPECT_EQ(action.mission, MissionStatus::kFailed);
  EXPECT_EQ(action.mission_note, "returned: too little to see ahead");
  EXPECT_GT(flight.farthest_m, 15.0);
  EXPECT_LT(flight.farthest_m, 20.0);
  for (int i = 0; i < 500; ++i) flight.fly(to_seconds(kControlStep));
  EXPECT_NEAR(flight.plant.p.x(), 12.0, 1.5);
  EXPECT_LT(flight.plant.v.norm(), 0.1) << "hovering";
}

TEST(WayBack, LeavesLandedVehiclesOnTheGround) {
  bool sees_too_little = false;
  ReturningFlight flight([&](const Vector3&) { return sees_too_little; }, true);
  EXPECT_EQ(flight.fly(60.0).mission, MissionStatus::kDone);
  sees_too_little = true;
  for (int i = 0; i < 500; ++i) EXPECT_EQ(flight.fly(to_seconds(kControlStep)).mission, MissionStatus::kDone);
  EXPECT_LT(flight.plant.p.z(), 0.05);
}

TEST(WayBack, FollowsThePathToItsStart) {
  bool saw_too_little = false;
  ReturningFlight flight([&](const Vector3& p_m) {
    saw_too_little = saw_too_little || p_m.x() > 10.0;
    return saw_too_little;
  });
  const Action& action = flight.fly(60.0);
  EXPECT_EQ(action.mission, MissionStatus::kFailed);
  for (int i = 0; i < 500; ++i) flight.fly(to_seconds(kControlStep));
  EXPECT_LT((flight.plant.p - Vector3(0, 0, 5)).norm(), 0.7);
  EXPECT_LT(flight.off_path_m, 1.0) << "around the corner of the path";
}

}  // namespace
}  // namespace swiftlet
