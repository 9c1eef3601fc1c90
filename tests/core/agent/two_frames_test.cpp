// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "tests/support/airframes.hpp"
#include "tests/support/fine_plant.hpp"

namespace swiftlet {
namespace {

using testing::FinePlant;

constexpr TimeNs kStep = 4'000'000;
// True pose of the vehicle's local frame in the world.
const Pose kT_world_local = make_pose({6.0, -4.0, 0.5}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3::UnitZ())));

/// Exact local motion; the pose of the local frame becomes known at `learns_at`.
class LateEstimator : public StateEstimator {
 public:
  explicit LateEstimator(TimeNs learns_at) : learns_at_(learns_at) {}

  const StateEstimate& update(const Observation& observation, Outbox& outbox) override {
    const PoseSample& truth = observation.pose.back();
    const Pose T_local_world = kT_world_local.inverse();
    estimate_.t = observation.t;
    estimate_.valid = true;
    estimate_.T_local_body = T_local_world * truth.T_world_body;
    estimate_.v_local_mps = T_local_world.linear() * truth.v_world_mps;
    estimate_.omega_body_radps = truth.omega_body_radps;
    if (observation.t >= learns_at_) estimate_.correct(kT_world_local);
    outbox.add().topic = "estimator";
    return estimate_;
  }
  const char* fault() const override { return ""; }
  const char* warning() const override { return seeks || estimate_.t < learns_at_ ? "" : "half lost"; }
  Search search() const override {
    if (!seeks || estimate_.t >= learns_at_) return Search::kNone;
    return estimate_.t < in_vain_from ? Search::kActive : Search::kFailed;
  }

  bool seeks = false;  // until then, in a map
  TimeNs in_vain_from = 10 * kNsPerSecond;

 private:
  TimeNs learns_at_;
  StateEstimate estimate_;
};

/// A step of ten meters that no reference governor would allow, as a feasible reference or as a goal.
class StepGuidance : public Guidance {
 public:
  explicit StepGuidance(bool feasible) : feasible_(feasible) {}
  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    output.goal.position_m = input.observation.t < kNsPerSecond ? Vector3(0, 0, 5) : Vector3(10, 0, 5);
    output.goal_is_feasible = feasible_;
    outbox.add(3).topic = "guidance";
  }

 private:
  bool feasible_;
};

/// Keeps the clouds and the map that it receives.
class WatchingGuidance : public Guidance {
 public:
  explicit WatchingGuidance(GuidanceNeeds needs) : needs_(needs) {}
  GuidanceNeeds needs() const override { return needs_; }
  void step(const GuidanceInput& input, GuidanceOutput&, Outbox&) override {
    num_clouds += static_cast<int>(input.clouds.size());
    for (const auto& cloud : input.clouds) points_m = cloud->points_local_m;
    had_map = had_map || input.map != nullptr;
  }

  int num_clouds = 0;
  std::vector<Eigen::Vector3f> points_m;
  bool had_map = false;

 private:
  GuidanceNeeds needs_;
};

AgentSetup setup_of_x500() {
  AgentSetup setup;
  setup.self = 1;
  setup.airframe = testing::x500();
  setup.tick_s = to_seconds(kStep);
  return setup;
}

std::unique_ptr<Guidance> waypoints(std::vector<Vector3> waypoints_m, WaypointsConfig::Frame frame) {
  Module module(guidance_module_types(), "waypoints");
  module.as<WaypointsConfig>().waypoints_m = std::move(waypoints_m);
  module.as<WaypointsConfig>().frame = frame;
  return make_guidance(module, {setup_of_x500(), MotionLimitsConfig{}.resolve()});
}

/// A flight on the late estimator.
struct Flight {
  Flight(TimeNs learns_at, std::unique_ptr<Guidance> guidance, bool seeks = false) : plant(testing::x500()) {
    plant.p = kT_world_local.translation();
    plant.q = kT_world_local.linear();
    StackStages stages;
    auto estimator = std::make_unique<LateEstimator>(learns_at);
    estimator->seeks = seeks;
    stages.localization = std::move(estimator);
    stages.guidance = std::move(guidance);
    agent = make_stack(std::move(stages), {}, setup_of_x500());
  }
  const Action& tick() {
    plant.advance(command, to_seconds(kStep));
    Observation observation;
    observation.self = 1;
    observation.t = plant.t;
    observation.pose = {plant.pose_sample()};
    const Action& action = agent->step(observation);
    command = action.rotor_command;
    return action;
  }
  /// Flies until the mission is done, or for so many ticks.
  const Action& run_until_done(int most_ticks) {
    const Action* action = &tick();
    for (int i = 1; i < most_ticks && action->mission != MissionStatus::kDone; ++i) action = &tick();
    return *action;
  }

  FinePlant plant;
  std::unique_ptr<Agent> agent;
  std::array<double, kMaxRotors> command = {0.4, 0.4, 0.4, 0.4};
};

TEST(TwoFrames, CorrectionLeavesControlAndReferenceSmooth) {
  // Two legs of the local frame: one vehicle never learns where that lies, the other one in the middle of the flight.
  const std::vector<Vector3> legs = {{3, 0, 1}, {3, 3, 1}};
  Flight unaware(100 * kNsPerSecond, waypoints(legs, WaypointsConfig::Frame::kStart)),
      learns(2 * kNsPerSecond, waypoints(legs, WaypointsConfig::Frame::kStart));
  Vector3 last_m = Vector3::Zero();
  for (int i = 0; i < 1500; ++i) {
    const Action& a = unaware.tick();
    const Action& b = learns.tick();
    ASSERT_EQ(a.rotor_command, b.rotor_command) << i;
    ASSERT_EQ(a.estimate.T_local_body.matrix(), b.estimate.T_local_body.matrix());
    ASSERT_EQ(b.estimate.correction_revision, learns.plant.t >= 2 * kNsPerSecond ? 1U : 0U);
    // The reference in the world jumps by the correction; in the local frame it is smooth.
    const Vector3 reference_m = b.estimate.T_world_local.inverse() * b.reference.position_m;
    ASSERT_LT((reference_m - a.reference.position_m).norm(), 1e-12);
    ASSERT_TRUE(i == 0 || (reference_m - last_m).norm() < 0.02) << i;
    last_m = reference_m;
  }
}

TEST(TwoFrames, ReachesWorldWaypointsAfterTheCorrection) {
  const Vector3 target(9.0, 1.0, 3.0);
  Flight flight(2 * kNsPerSecond, waypoints({target}, WaypointsConfig::Frame::kWorld));
  const Action* action = nullptr;
  Vector3 last_m = flight.plant.p;
  for (int i = 0; i < 6000 && (action == nullptr || action->mission != MissionStatus::kDone); ++i) {
    action = &flight.tick();
    const Vector3 reference_m =
        kT_world_local * (action->estimate.T_world_local.inverse() * action->reference.position_m);
    ASSERT_LT((reference_m - last_m).norm(), 0.04) << "the reference has no jump at " << i;
    last_m = reference_m;
  }
  EXPECT_EQ(action->mission, MissionStatus::kDone);
  EXPECT_LT((flight.plant.p - target).norm(), 0.6);
  EXPECT_LT((action->estimate.T_world_body().translation() - flight.plant.p).norm(), 0.05);
}

TEST(TwoFrames, TurnsInPlaceWhileItRelocalizes) {
  const Vector3 target(9.0, 1.0, 3.0);
  Flight flight(8 * kNsPerSecond, waypoints({target}, WaypointsConfig::Frame::kWorld), true);
  const Vector3 start_m = flight.plant.p;
  double turned_rad = 0.0, yaw_rad = yaw_of(flight.plant.q.toRotationMatrix());
  while (flight.plant.t < 8 * kNsPerSecond) {
    const Action& action = flight.tick();
    ASSERT_LT((flight.plant.p - start_m).norm(), 0.1) << to_seconds(flight.plant.t);
    ASSERT_EQ(action.mission, MissionStatus::kRunning);
    const double now_rad = yaw_of(flight.plant.q.toRotationMatrix());
    turned_rad += std::remainder(now_rad - yaw_rad, 2.0 * kPi);
    yaw_rad = now_rad;
  }
  EXPECT_GT(turned_rad, 2.5) << "turn in place until the relocalization";
  EXPECT_EQ(flight.run_until_done(6000).mission, MissionStatus::kDone);
  EXPECT_LT((flight.plant.p - target).norm(), 0.6);
}

TEST(TwoFrames, StopsAndFailsAfterUnsuccessfulSearch) {
  Flight flight(100 * kNsPerSecond, waypoints({{9.0, 1.0, 3.0}}, WaypointsConfig::Frame::kWorld), true);
  const Vector3 start_m = flight.plant.p;
  const Action* action = nullptr;
  while (flight.plant.t < 13 * kNsPerSecond) action = &flight.tick();
  EXPECT_EQ(action->mission, MissionStatus::kFailed);
  EXPECT_EQ(action->mission_note, "localization in the saved map failed");
  EXPECT_LT((flight.plant.p - start_m).norm(), 0.1);
  EXPECT_LT(flight.plant.omega.norm(), 0.02);
}

TEST(TwoFrames, ClearsTheSearchNoteOnceRelocalized) {
  // Relocalized while still searching, and after the search was given up.
  for (const TimeNs found_at : {4 * kNsPerSecond, 12 * kNsPerSecond}) {
    Flight flight(found_at, waypoints({{9.0, 1.0, 3.0}}, WaypointsConfig::Frame::kWorld), true);
    const Action* action = nullptr;
    while (flight.plant.t < found_at + kStep) action = &flight.tick();
    EXPECT_EQ(action->mission, MissionStatus::kRunning) << found_at;
    EXPECT_EQ(action->mission_note, "") << found_at;
  }
}

TEST(TwoFrames, FliesLocalMissionsWhileItRelocalizes) {
  Flight flight(100 * kNsPerSecond, waypoints({{3, 0, 1}}, WaypointsConfig::Frame::kStart), true);
  EXPECT_EQ(flight.run_until_done(4000).mission, MissionStatus::kDone);
}

TEST(Stack, LimitsGoalsButNotFeasibleReferences) {
  for (const bool feasible : {false, true}) {
    Flight flight(100 * kNsPerSecond, std::make_unique<StepGuidance>(feasible));
    Vector3 before = Vector3::Zero(), after = Vector3::Zero();
    for (int i = 0; i < 260; ++i) {
      const Action& action = flight.tick();
      if (action.estimate.t == kNsPerSecond - kStep) before = action.reference.position_m;
      if (action.estimate.t == kNsPerSecond) after = action.reference.position_m;
    }
    if (feasible) {
      EXPECT_EQ(before, Vector3(0, 0, 5));
      EXPECT_EQ(after, Vector3(10, 0, 5));
    } else {
      EXPECT_LT((after - before).norm(), 0.02);
    }
  }
}

TEST(Stack, NamesTheStageOfEveryMessage) {
  Flight flight(0, std::make_unique<StepGuidance>(false));
  flight.tick();
  const Action& action = flight.tick();
  ASSERT_EQ(action.messages.size(), 2U);
  EXPECT_EQ(action.messages[0].topic, "estimator");
  EXPECT_EQ(action.messages[0].from, 1);
  EXPECT_EQ(action.messages[0].to, kNoVehicle);
  EXPECT_EQ(action.messages[1].topic, "guidance");
  EXPECT_EQ(action.messages[1].to, 3);
}

TEST(Stack, ExplainsProblemsOfAValidEstimate) {
  Flight flight(kNsPerSecond, std::make_unique<StepGuidance>(false));
  while (flight.plant.t < kNsPerSecond - kStep) EXPECT_EQ(flight.tick().mission_note, "");
  const Action& action = flight.tick();
  EXPECT_EQ(action.mission_note, "half lost");
  EXPECT_EQ(action.mission, MissionStatus::kRunning) << "a valid estimate with a problem does not end the mission";
}

TEST(Stack, PlacesScansOnlyOnGuidanceRequest) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = beams->cols = 1;
  beams->directions_lidar = {Eigen::Vector3f::UnitX()};
  beams->origins_lidar = {Eigen::Vector3f::Zero()};
  beams->column_offset_s = {0.0F};
  for (const bool needs : {false, true}) {
    StackStages stages;
    stages.localization = std::make_unique<LateEstimator>(0);
    auto guidance = std::make_unique<WatchingGuidance>(GuidanceNeeds{.clouds = needs});
    const WatchingGuidance& seen = *guidance;
    stages.guidance = std::move(guidance);
    const auto agent = make_stack(std::move(stages), {}, setup_of_x500());
    auto scan = std::make_shared<Scan>();
    scan->beams = beams;
    scan->range_m = {5.0F};
    Observation observation;
    observation.self = 1;
    observation.t = kStep;
    observation.pose = {{kStep, kT_world_local, Vector3::Zero(), Vector3::Zero()}};
    observation.scans = {scan};
    agent->step(observation);
    ASSERT_EQ(seen.num_clouds, needs ? 1 : 0);
    EXPECT_FALSE(seen.had_map);
    if (!needs) continue;
    EXPECT_LT((seen.points_m.front() - Eigen::Vector3f(5, 0, 0)).norm(), 1e-5F) << "in the local frame";
  }
}

TEST(Stack, RefusesMapGuidanceWithoutAMap) {
  StackStages stages;
  stages.localization = std::make_unique<LateEstimator>(0);
  stages.guidance = std::make_unique<WatchingGuidance>(GuidanceNeeds{.map = true});
  EXPECT_THROW(make_stack(std::move(stages), {}, setup_of_x500()), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
