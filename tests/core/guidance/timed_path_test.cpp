// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/timed_path.hpp"

#include <gtest/gtest.h>

#include "swiftlet/core/stages/guidances.hpp"

namespace swiftlet {
namespace {

const std::vector<Vector3> kBend = {{0, 0, 2}, {1, 0, 2}, {2, 0, 2}, {2, 1, 2.5}, {2, 2, 3}, {2, 3, 3}};

TEST(TimedPath, TellsPlaceVelocityAndAccelerationByTimeAndIsDoneAtTheEnd) {
  Module module(guidance_module_types(), "timed_path");
  module.as<TimedPathConfig>().points_m = kBend;
  module.as<TimedPathConfig>().interval_s = 0.5;
  AgentSetup agent;
  agent.T_local_body_start = make_pose(kBend.front(), Eigen::Quaterniond::Identity());
  const auto guidance = make_guidance(module, {agent, {}});
  const UniformSpline spline(kBend, 0.5);
  StateEstimate estimate;
  Observation observation;
  double last_yaw_rad = 0.0;
  for (int tick = 1; tick <= 1000; ++tick) {
    GuidanceOutput out;
    LocalPoses poses;
    Outbox outbox;
    guidance->step({.dt_s = 0.004, .estimate = estimate, .observation = observation, .poses = poses}, out, outbox);
    const auto expected = spline.at(0.004 * tick);
    ASSERT_LT((out.goal.position_m - expected.p_m).norm(), 1e-9);
    ASSERT_LT((out.goal.velocity_mps - expected.v_mps).norm(), 1e-9);
    ASSERT_LT((out.goal.acceleration_mps2 - expected.a_mps2).norm(), 1e-9);
    ASSERT_EQ(out.mission == MissionStatus::kDone, 0.004 * tick >= 3.5 - 1e-9) << tick;
    last_yaw_rad = out.goal.yaw_rad;
  }
  EXPECT_NEAR(last_yaw_rad, 1.5707963, 0.05);  // towards +y, as the last legs go
}

}  // namespace
}  // namespace swiftlet
