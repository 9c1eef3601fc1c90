// SPDX-License-Identifier: BSD-3-Clause
// Maps that vehicles joined by radio, against how their local frames truly lie.
#include <gtest/gtest.h>

#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/submap_chunk.hpp"
#include "swiftlet/core/messages/submap_request.hpp"
#include "swiftlet/core/slam/joined_map.hpp"
#include "tests/sim/metrics/metrics_run.hpp"

namespace swiftlet::sim {
namespace {

/// An inactive agent with a known transform to another vehicle's frame.
class Joiner : public Agent, public JoinedMapProvider {
 public:
  const Action& step(const Observation&) override { return action_; }
  std::span<const JoinedMap> joined_maps() const override { return maps; }
  std::vector<JoinedMap> maps;

 private:
  Action action_;
};

Pose turned_at(const Vector3& p_world_m, double yaw_rad) {
  return make_pose(p_world_m, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
}

/// Two vehicles with arbitrary local frames in the world; the first one knows the transform.
struct JoinedPair : MetricsRun {
  const Pose T_world_local[2] = {turned_at({3, -2, 1}, 0.7), turned_at({-20, 9, 2}, -2.0)};
  Joiner* joiner = nullptr;

  JoinedPair() : MetricsRun(2) {
    for (int i = 0; i < 2; ++i) {
      states[i].p_world_m = Vector3(4.0 * i, 7, 3);
      states[i].q_world_body = Eigen::AngleAxisd(0.4 + i, Vector3::UnitZ());
      actions[i].estimate.valid = true;
      actions[i].estimate.T_local_body = T_world_local[i].inverse() * states[i].T_world_body();
      agents.push_back(std::make_unique<Joiner>());
    }
    joiner = dynamic_cast<Joiner*>(agents[0].get());
    JoinedMap joined;
    joined.other = 1;
    joined.T_local_otherlocal = T_world_local[0].inverse() * T_world_local[1];
    joined.covariance = 0.01 * Eigen::Matrix4d::Identity();
    joiner->maps.push_back(joined);
  }
};

TEST(JoinedMaps, AreExactWhenFramesMatchTruth) {
  JoinedPair run;
  run.tick();
  EXPECT_NEAR(run.value("joined_position_end_m"), 0.0, 1e-12);
  EXPECT_NEAR(run.value("joined_yaw_end_rad"), 0.0, 1e-12);
  EXPECT_NEAR(run.value("joined_s"), 0.01, 1e-12);
}

TEST(JoinedMaps, AreOffByTheFrameError) {
  JoinedPair run;
  run.joiner->maps[0].T_local_otherlocal.translation() += Vector3(0.3, 0.0, 0.4);
  run.tick();
  EXPECT_NEAR(run.value("joined_position_rmse_m"), 0.5, 1e-9);
  EXPECT_NEAR(run.value("joined_nees"), 25.0, 1e-6);
  run.joiner->maps.clear();
  run.tick();
  EXPECT_NEAR(run.value("joined_position_max_m"), 0.5, 1e-9) << "ticks without a joined map do not count";
}

TEST(JoinedMaps, CountMessagesByKind) {
  JoinedPair run;
  run.joiner->maps.clear();
  std::vector<Message>& sent = run.actions[1].messages;
  write_message(SubmapChunk{}, sent.emplace_back());
  write_message(SubmapRequest{}, sent.emplace_back());
  run.tick();
  EXPECT_EQ(run.value("map_clouds_bytes", "uav2"), static_cast<double>(sent[0].size_bytes()));
  EXPECT_EQ(run.value("map_words_bytes", "uav2"), static_cast<double>(sent[1].size_bytes()));
  EXPECT_EQ(run.value("map_looks_bytes", "uav2"), 0.0);
  EXPECT_TRUE(std::isnan(run.value("joined_s", "uav2")));
  EXPECT_EQ(run.metrics.report().find("joined_s", "uav1"), nullptr) << "uav1 has no joined map";
}

}  // namespace
}  // namespace swiftlet::sim
