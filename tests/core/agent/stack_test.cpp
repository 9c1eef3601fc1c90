// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/explore.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/agent/stage_notifier.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/guidance/agile.hpp"
#include "swiftlet/core/guidance/hover.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/share_paths.hpp"
#include "swiftlet/core/guidance/takeoff_land.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "swiftlet/core/stage_tables/trackers.hpp"
#include "tests/support/airframes.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/fine_plant.hpp"

namespace swiftlet {
namespace {

using testing::FinePlant;
constexpr TimeNs kTick = 4'000'000;

/// One vehicle in closed loop: the whole agent on one side, a fine plant and simple sensors on the other.
class ClosedLoop {
 public:
  ClosedLoop(const Airframe& airframe, const StackConfig& config, const Vector3& start) : plant(airframe) {
    plant.p = start;
    AgentSetup setup;
    setup.airframe = airframe;
    setup.T_local_body_start = plant.T_world_body();
    setup.tick_s = to_seconds(kTick);
    Module module(agent_module_types(), "stack");
    module.as<StackConfig>() = config;
    agent_ = make_agent(module, setup);
  }

  const Action& tick() {
    const Vector3 v_before = plant.v;
    plant.advance(command_, to_seconds(kTick));
    observation_.clear();
    observation_.t = plant.t;
    ++ticks_;
    if (pose_every > 0 && ticks_ % pose_every == 0) observation_.pose.push_back(plant.pose_sample());
    if (imu) {
      const Vector3 a = (plant.v - v_before) / to_seconds(kTick);
      observation_.imu.push_back({plant.t, plant.omega, plant.q.conjugate() * (a + 9.81 * Vector3::UnitZ())});
    }
    if (odometry_every > 0 && ticks_ % odometry_every == 0) {
      const Pose T_local_world = make_pose({7, 8, 9}, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Vector3::UnitZ())));
      observation_.odometry.push_back(
          {plant.t, T_local_world * plant.T_world_body(), T_local_world.linear() * plant.v});
    }
    if (gnss_every > 0 && ticks_ % gnss_every == 0) add_gnss();
    observation_.wants_overlays = wants_overlays;
    const Action& action = agent_->step(observation_);
    command_ = action.rotor_command;
    return action;
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / to_seconds(kTick)); ++i) last = &tick();
  }

  FinePlant plant;
  const Action* last = nullptr;
  int pose_every = 1, odometry_every = 0, gnss_every = 0;
  bool imu = false, wants_overlays = false;
  Observation& observation() { return observation_; }
  Agent& agent() { return *agent_; }

 private:
  void add_gnss() {
    const auto noise = [&](std::uint32_t k) {
      const auto n = random_.normal3(ticks_, k);
      return Vector3(n[0], n[1], n[2]);
    };
    GnssSample s{plant.t, plant.p + 0.3 * noise(0), plant.v + 0.05 * noise(1), Vector3::Constant(0.3),
                 Vector3::Constant(0.05)};
    observation_.gnss.push_back(s);
    observation_.compass.push_back({plant.t, yaw_of(plant.q.toRotationMatrix()) + 0.02 * noise(2).x(), 0.02});
  }

  std::unique_ptr<Agent> agent_;
  Observation observation_;
  std::array<double, kMaxRotors> command_ = hover_command();
  Random random_{1, "test.stack"};
  std::uint32_t ticks_ = 0;

  static std::array<double, kMaxRotors> hover_command() {
    std::array<double, kMaxRotors> u{};
    u.fill(0.4);
    return u;
  }
};

template <class Config>
StackConfig stack_with(const char* guidance, const Config& config,
                       MotionLimitsConfig::Set limits = MotionLimitsConfig::Set::kMedium,
                       const char* localization = "ground_truth") {
  StackConfig stack;
  stack.localization = Module(estimator_module_types(), localization);
  stack.guidance = Module(guidance_module_types(), guidance);
  stack.guidance.as<Config>() = config;
  stack.control.limits.set = limits;
  return stack;
}

TEST(Stack, EveryVehicleHoversWithinTwoCentimeters) {
  for (const auto& [name, airframe] : testing::all_airframes()) {
    ClosedLoop loop(airframe, StackConfig{}, {1, 2, 3});
    loop.run(4.0);
    double worst = 0.0;
    for (int i = 0; i < 2000; ++i) {
      loop.tick();
      worst = std::max(worst, (loop.plant.p - Vector3(1, 2, 3)).norm());
    }
    EXPECT_LT(worst, 0.02) << name;
  }
}

TEST(Stack, TracksAgileTrajectoriesWithinThirtyCentimeters) {
  for (const auto& [name, airframe] : testing::all_airframes()) {
    for (const std::uint64_t seed : {1u, 2u}) {
      AgileConfig config;
      config.seed = seed;
      ClosedLoop loop(airframe, stack_with("agile", config, MotionLimitsConfig::Set::kAgile), {0, 0, 6});
      double sum_sq = 0.0, fastest = 0.0;
      constexpr int kTicks = 10000;
      for (int i = 0; i < kTicks; ++i) {
        const Vector3 asked = loop.last == nullptr ? loop.plant.p : loop.last->reference.position_m;
        loop.last = &loop.tick();
        sum_sq += (loop.plant.p - asked).squaredNorm();
        fastest = std::max(fastest, loop.plant.v.norm());
      }
      EXPECT_GT(fastest, 7.5) << name;
      EXPECT_LT(std::sqrt(sum_sq / kTicks), 0.3) << name;
    }
  }
}

TEST(Stack, TakesOffAndLands) {
  TakeoffLandConfig config;
  config.hover_s = 1.0;
  ClosedLoop loop(testing::x500(), stack_with("takeoff_land", config), {0, 0, 0.2});
  loop.plant.ground = true;
  loop.plant.ground_z = 0.2;
  double highest = 0.0;
  for (int i = 0; i < 15 * 250; ++i) {
    loop.last = &loop.tick();
    highest = std::max(highest, loop.plant.p.z());
    if (loop.last->mission != MissionStatus::kRunning) break;
  }
  EXPECT_NEAR(highest, 2.2, 0.05);
  EXPECT_EQ(loop.last->mission, MissionStatus::kDone);
  EXPECT_EQ(loop.last->mission_note, "landed");
  EXPECT_NEAR(loop.plant.p.z(), 0.2, 1e-9);
  loop.run(1.0);
  for (const double u : loop.last->rotor_command) EXPECT_EQ(u, 0.0);
}

TEST(Stack, FliesOnOdometryInOwnFrame) {
  WaypointsConfig config;
  config.waypoints_m = {{4, 2, 3}};
  ClosedLoop loop(testing::x500(), stack_with("waypoints", config, MotionLimitsConfig::Set::kSlow, "odometry"),
                  {0, 0, 2});
  loop.pose_every = 0;
  loop.odometry_every = 8;
  loop.imu = true;
  loop.run(15.0);
  EXPECT_EQ(loop.last->mission, MissionStatus::kDone);
  EXPECT_LT((loop.plant.p - Vector3(4, 2, 3)).norm(), 0.05);
}

TEST(Stack, HoversOnInsWithNoisyGnss) {
  ClosedLoop loop(testing::x500(), stack_with("hover", HoverConfig{}, MotionLimitsConfig::Set::kMedium, "ins"),
                  {0, 0, 5});
  loop.pose_every = 0;
  loop.gnss_every = 25;
  loop.imu = true;
  double worst = 0.0;
  for (int i = 0; i < 10000; ++i) {
    loop.last = &loop.tick();
    worst = std::max(worst, (loop.plant.p - Vector3(0, 0, 5)).norm());
  }
  EXPECT_LT(worst, 0.8);
  EXPECT_EQ(loop.last->mission, MissionStatus::kEndless) << loop.last->mission_note;
}

TEST(Stack, WithoutPoseFailsAndIdlesMotors) {
  ClosedLoop loop(testing::x500(), StackConfig{}, {0, 0, 5});
  loop.run(1.0);
  EXPECT_EQ(loop.last->mission, MissionStatus::kEndless);
  loop.pose_every = 0;
  loop.run(0.4);
  EXPECT_EQ(loop.last->mission, MissionStatus::kEndless) << "a short gap is bridged";
  loop.run(0.2);
  EXPECT_EQ(loop.last->mission, MissionStatus::kFailed);
  EXPECT_EQ(loop.last->mission_note, "no external pose");
  for (const double u : loop.last->rotor_command) EXPECT_EQ(u, 0.0);
  // When the poses come back it catches itself, but the mission stays failed.
  loop.pose_every = 1;
  loop.plant.p = {0, 0, 30};
  loop.run(10.0);
  EXPECT_EQ(loop.last->mission, MissionStatus::kFailed);
  EXPECT_LT(loop.plant.v.norm(), 2.5);
  EXPECT_LT(loop.plant.tilt_rad(), 0.3);
}

TEST(Stack, SurvivesJumpsAndStandstillsOfTime) {
  ClosedLoop loop(testing::x500(), StackConfig{}, {0, 0, 5});
  loop.run(1.0);
  Observation observation = loop.observation();
  const Action before = *loop.last;
  EXPECT_EQ(loop.agent().step(observation).rotor_command, before.rotor_command)
      << "a second step at one instant keeps the rotor command";
  for (const TimeNs jump : {TimeNs{700'000'000}, TimeNs{3'600} * kNsPerSecond}) {
    observation.t += jump;
    observation.pose = {loop.plant.pose_sample()};
    observation.pose[0].t = observation.t;
    const Action& action = loop.agent().step(observation);
    EXPECT_EQ(action.mission, MissionStatus::kEndless);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(action.rotor_command[i], before.rotor_command[i], 0.05);
  }
}

TEST(Stack, NeverAllocatesInFlight) {
  for (const GuidanceType& guidance : guidance_registry().rows()) {
    for (const EstimatorType& estimator : estimator_registry().rows()) {
      StackConfig config;
      config.localization = Module(estimator_module_types(), estimator.module.name);
      config.guidance = Module(guidance_module_types(), guidance.module.name);
      // A search for a view takes memory; looking around does not.
      if (auto* explore = dynamic_cast<ExploreConfig*>(config.guidance.config.get())) explore->look_s = 100.0;
      // Planning is disabled too; flight and reports of the plan go on.
      if (auto* share = dynamic_cast<SharePathsConfig*>(config.guidance.config.get())) share->period_s = 100.0;
      config.mapping = Module(mapper_module_types(), "occupancy");  // required by some guidance
      // required by some guidance
      config.relative_localization = Module(relative_localizer_module_types(), "shared_world");
      config.control.limits.set = MotionLimitsConfig::Set::kAgile;
      ClosedLoop loop(testing::x500(), config, {0, 0, 6});
      loop.imu = true;
      loop.odometry_every = 8;
      loop.gnss_every = 25;
      loop.run(2.0);
      const std::uint64_t before = test::num_allocations();
      loop.run(4.0);
      EXPECT_EQ(test::num_allocations(), before) << guidance.module.name << " on " << estimator.module.name;
    }
  }
}

TEST(Stack, ReusesMessageMemory) {
  RblConfig config;
  config.neighbors.source = NeighborSourceConfig::Source::kRadio;
  ClosedLoop loop(testing::x500(), stack_with("rbl", config), {0, 0, 6});
  loop.run(2.0);
  std::size_t num_messages = 0;
  const std::uint64_t before = test::num_allocations();
  for (int i = 0; i < 500; ++i) num_messages += loop.tick().messages.size();
  EXPECT_EQ(test::num_allocations(), before);
  EXPECT_GT(num_messages, 5U);
}

TEST(Stack, SameObservationsGiveTheSameBits) {
  AgileConfig config;
  ClosedLoop a(testing::x500(), stack_with("agile", config, MotionLimitsConfig::Set::kAgile), {0, 0, 6});
  ClosedLoop b(testing::x500(), stack_with("agile", config, MotionLimitsConfig::Set::kAgile), {0, 0, 6});
  a.run(5.0);
  b.wants_overlays = true;  // pictures change nothing
  b.run(5.0);
  EXPECT_EQ(a.plant.p, b.plant.p);
  EXPECT_EQ(a.last->rotor_command, b.last->rotor_command);
  EXPECT_TRUE(a.last->overlays.empty());
  ASSERT_FALSE(b.last->overlays.empty());
  EXPECT_EQ(b.last->overlays[0].name, "reference");
  EXPECT_GT(b.last->overlays[0].positions.size(), 90u);
}

TEST(Agents, CreatesEveryTypeFromDefaults) {
  AgentSetup setup;
  setup.airframe = testing::x500();
  for (const AgentType& type : agent_registry().rows()) {
    const auto agent = make_agent(Module(agent_module_types(), type.module.name), setup);
    Observation observation;
    observation.t = kTick;
    EXPECT_NE(agent->step(observation).mission, MissionStatus::kFailed) << type.module.name;
  }
  EXPECT_THROW(Module(agent_module_types(), "pilot"), std::invalid_argument);
  setup.airframe.rotors.clear();
  EXPECT_THROW(make_agent(Module(agent_module_types(), "stack"), setup), std::invalid_argument);
}

TEST(Agents, DeclareNeedsBesideSensors) {
  Module stack(agent_module_types(), "stack");
  EXPECT_TRUE(needs_of(stack).true_pose);
  EXPECT_FALSE(needs_of(stack).true_neighbors || needs_of(stack).detects || needs_of(stack).tracks);
  stack.as<StackConfig>().localization = Module(estimator_module_types(), "ins");
  EXPECT_FALSE(needs_of(stack).true_pose);
  stack.as<StackConfig>().detector = Module(detector_module_types(), "vofod");
  stack.as<StackConfig>().detector.as<VofodConfig>().prior.world = true;
  EXPECT_TRUE(needs_of(stack).detects && needs_of(stack).prior.world);
  EXPECT_FALSE(needs_of(stack).true_neighbors);
  stack.as<StackConfig>().tracker = Module(tracker_module_types(), "ground_truth");
  EXPECT_TRUE(needs_of(stack).tracks && needs_of(stack).true_neighbors);
  EXPECT_EQ(guidance_of(stack), &stack.as<StackConfig>().guidance);

  Module none(agent_module_types(), "none");
  EXPECT_FALSE(needs_of(none).true_pose);
  EXPECT_EQ(guidance_of(none), nullptr);
}

TEST(Guidances, DeclareNeedForWorldPosition) {
  AgentSetup agent;
  agent.airframe = testing::x500();
  MotionLimitsConfig limits;
  limits.set = MotionLimitsConfig::Set::kAgile;
  const auto needs_world = [&](const Module& module) {
    return make_guidance(module, {agent, limits.resolve()})->needs().world;
  };
  for (const char* name : {"takeoff_land", "hover", "timed_path"}) {
    EXPECT_FALSE(needs_world(Module(guidance_module_types(), name))) << name;
  }
  for (const char* name : {"waypoints", "navigate", "explore", "rbl", "orca", "intercept", "target"}) {
    EXPECT_TRUE(needs_world(Module(guidance_module_types(), name))) << name;
  }
  Module hover(guidance_module_types(), "hover");
  hover.as<HoverConfig>().at = HoverConfig::At::kPoint;
  EXPECT_TRUE(needs_world(hover)) << "a point of the world";
  Module waypoints(guidance_module_types(), "waypoints");
  waypoints.as<WaypointsConfig>().frame = WaypointsConfig::Frame::kStart;
  EXPECT_FALSE(needs_world(waypoints));
}

TEST(Stack, NamesCountersAndMapsByStage) {
  StackConfig config = stack_with("hover", HoverConfig{});
  config.detector = Module(detector_module_types(), "vofod");
  ClosedLoop loop(testing::all_airframes()[0].airframe, config, {0, 0, 3});
  loop.run(0.1);
  std::vector<Counter> counters;
  loop.agent().append_counters(counters);
  ASSERT_FALSE(counters.empty());
  for (const Counter& counter : counters) EXPECT_EQ(counter.setting.rfind("detector.", 0), 0U) << counter.setting;
  std::vector<MapVoxels> maps;
  loop.agent().append_maps(maps);
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0].name, "detector");
}

TEST(Stack, NotifiesListenerOfStagesInOrder) {
  StackConfig all = stack_with("hover", HoverConfig{});
  all.detector = Module(detector_module_types(), "vofod");
  all.tracker = Module(tracker_module_types(), "vofod");
  all.relative_localization = Module(relative_localizer_module_types(), "shared_world");
  all.mapping = Module(mapper_module_types(), "occupancy");
  using Stages = std::vector<std::string>;
  const std::vector<std::pair<StackConfig, Stages>> stacks = {
      {all,
       {"localization", "clouds", "detection", "tracking", "relative_localization", "mapping", "guidance", "control",
        "other"}},
      {StackConfig{}, {"localization", "clouds", "guidance", "control", "other"}}};
  for (const auto& [config, stages] : stacks) {
    ClosedLoop loop(testing::x500(), config, {0, 0, 3});
    auto* const agent = dynamic_cast<StageNotifier*>(&loop.agent());
    ASSERT_NE(agent, nullptr);
    Stages notified;
    agent->set_stage_listener(
        [&](AgentStage stage) { notified.emplace_back(kAgentStageNames[static_cast<std::size_t>(stage)]); });
    for (int i = 0; i < 3; ++i) {
      notified.clear();
      loop.tick();
      EXPECT_EQ(notified, stages);
    }
    loop.pose_every = 0;  // lost: nothing but localization
    loop.run(1.0);
    notified.clear();
    EXPECT_EQ(loop.tick().mission, MissionStatus::kFailed);
    EXPECT_EQ(notified, Stages({"localization", "other"}));

    notified.clear();
    agent->set_stage_listener({});
    loop.tick();
    EXPECT_TRUE(notified.empty());
  }
}

TEST(NoneAgent, KeepsTheMotorsAtIdle) {
  const auto agent = make_agent(Module(agent_module_types(), "none"), {});
  Observation observation;
  observation.self = 1;
  const Action& action = agent->step(observation);
  for (const double u : action.rotor_command) EXPECT_EQ(u, 0.0);
  EXPECT_FALSE(action.estimate.valid);
}

}  // namespace
}  // namespace swiftlet
