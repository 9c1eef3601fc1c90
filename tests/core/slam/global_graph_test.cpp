// SPDX-License-Identifier: BSD-3-Clause
// The graph of a flight: nodes, submaps, fixes and their weights.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/slam/graph/global_slam.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kNodeTick = 100'000'000;

/// A straight flight that sees three points only, so that nothing is ever found again.
struct PlainFlight {
  GlobalSlam slam;
  TimeNs t = 0;
  std::vector<std::pair<TimeNs, Pose>> corrections;

  explicit PlainFlight(const GlobalSlamConfig& config) : slam(config, true) {}
  void node_at(const Pose& T_local_body, const Pose& T_world_local = Pose::Identity()) {
    t += kNodeTick;
    const std::vector<Eigen::Vector3f> points = {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {0.01F, 0, 3}};
    slam.add_scan(t, T_local_body, points, T_world_local);
    if (const auto c = slam.correction(t)) corrections.emplace_back(t, *c);
  }
  void along_x(double to_m, double step_m = 0.5) {
    for (int i = 0; step_m * i <= to_m + 1e-9; ++i) {
      node_at(make_pose({step_m * i, 1, 2}, rotation_by({0.1, -0.05, 0.3})));
    }
  }
};

TEST(GlobalGraph, JoinsNodesByOdometryWithCovariance) {
  GlobalSlamConfig config;
  config.node_every_m = 0.02;
  PlainFlight flight(config);
  const double paths_m[] = {0.0, 0.4, 1.2, 3.2};  // steps of 0.4, 0.8 and 2 m
  for (const double path_m : paths_m) flight.node_at(make_pose({path_m, 0, 1}, rotation_by({0, 0, path_m})));
  ASSERT_EQ(flight.slam.num_nodes(), 4);
  ASSERT_EQ(flight.slam.num_submaps(), 1);
  // In the order of creation: submap and node, then odometry and submap again.
  const auto all = flight.slam.graph().relative_factors();
  ASSERT_EQ(all.size(), 7U);
  for (std::size_t i = 0; i < 3; ++i) {
    const RelativeFactor& f = all[1 + 2 * i];
    const double step_m = paths_m[i + 1] - paths_m[i];
    // A random walk: the variance is proportional to the distance.
    EXPECT_NEAR(f.information(1, 1) * step_m, all[1].information(1, 1) * 0.4, 1e-6 * f.information(1, 1)) << i;
    EXPECT_NEAR(f.information(4, 4) * step_m, all[1].information(4, 4) * 0.4, 1e-6 * f.information(4, 4)) << i;
    EXPECT_NEAR(f.T_from_to.translation().norm(), step_m, 1e-9);
    EXPECT_NEAR(yaw_of(f.T_from_to.linear()), step_m, 1e-9);
    EXPECT_TRUE(std::isinf(f.huber));
  }
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(all[2 * i].from, all[0].from) << "the submap";
  ASSERT_EQ(flight.slam.graph().gravity_factors().size(), 4U);
  for (const GravityFactor& f : flight.slam.graph().gravity_factors()) {
    EXPECT_LT((f.up_body - Vector3::UnitZ()).norm(), 1e-12);
  }
}

TEST(GlobalGraph, AddsNodesAfterMotionAndTime) {
  PlainFlight flight({});
  for (const double path_m : {0.0, 0.49, 0.5, 0.99, 1.0})
    flight.node_at(make_pose({path_m, 0, 1}, Eigen::Quaterniond::Identity()));
  EXPECT_EQ(flight.slam.num_nodes(), 3);
  flight.t -= 3 * kNodeTick;
  flight.node_at(make_pose({9, 0, 1}, Eigen::Quaterniond::Identity()));
  EXPECT_EQ(flight.slam.num_nodes(), 3) << "an older scan is ignored";
}

TEST(GlobalGraph, LimitsSubmapLengthAndStartsAnother) {
  for (const auto& [to_m, num] :
       std::vector<std::pair<double, int>>{{8.0, 1}, {8.5, 2}, {16.5, 2}, {17.0, 3}, {25.5, 4}}) {
    PlainFlight flight({});
    flight.along_x(to_m);
    EXPECT_EQ(flight.slam.num_submaps(), num) << to_m;
    const auto map = flight.slam.saved_map();
    ASSERT_EQ(map->submaps.size(), static_cast<std::size_t>(num));
    EXPECT_EQ(map->nodes.size(), static_cast<std::size_t>(flight.slam.num_nodes()));
    // The submap is upright at its first node and has one point per cube of 0.2 m.
    const Pose& T = map->T_world_submap(map->submaps.back());
    EXPECT_LT((T.linear() * Vector3::UnitZ() - Vector3::UnitZ()).norm(), 1e-9);
    EXPECT_LT((T.translation() - Vector3(8.5 * (num - 1), 1, 2)).norm(), 1e-9);
    const std::size_t nodes = static_cast<std::size_t>(std::lround((to_m - 8.5 * (num - 1)) / 0.5)) + 1;
    EXPECT_NEAR(static_cast<double>(map->submaps.back().points_submap_m.size()), 3.0 * static_cast<double>(nodes), 2.0)
        << "a scan has four points, two of them within a centimeter";
    const Eigen::Vector3f first = map->submaps.back().points_submap_m[0];
    const Vector3 seen = make_pose({8.5 * (num - 1), 1, 2}, rotation_by({0.1, -0.05, 0.3})) * Vector3(1, 0, 0);
    EXPECT_LT((T * first.cast<double>() - seen).norm(), 1e-5);
  }
}

GnssSample fix_at(TimeNs t, const Vector3& p_world_m, const Vector3& sigma_m = Vector3::Constant(0.5)) {
  return {t, p_world_m, Vector3::Zero(), sigma_m, Vector3::Ones()};
}

TEST(GlobalGraph, PlacesFixesProportionallyBetweenTwoNodes) {
  GlobalSlamConfig config;
  config.gnss.weighting = GnssWeighting::kPerAxis;
  config.gnss.a = 2.0;
  config.gnss.huber = 1.7;
  PlainFlight flight(config);
  flight.slam.add_gnss(fix_at(50'000'000, {0, 0, 0}));  // before any node
  flight.along_x(0.0);
  flight.slam.add_gnss(fix_at(kNodeTick - 1, {0, 0, 0}));  // also before the last one
  flight.slam.add_gnss(fix_at(kNodeTick + 10'000'000, {1, 1, 1}));
  flight.slam.add_gnss(fix_at(kNodeTick + 30'000'000, {2, 3, 4}, {0.5, 0.25, 1.0}));
  flight.slam.add_gnss(fix_at(kNodeTick + 140'000'000, {5, 5, 5}));
  flight.slam.add_gnss(
      {kNodeTick + 35'000'000, Vector3::Constant(std::nan("")), Vector3::Zero(), Vector3::Ones(), Vector3::Ones()});
  flight.slam.add_gnss(fix_at(kNodeTick + 36'000'000, {7, 7, 7}, Vector3::Constant(std::nan(""))));
  flight.node_at(make_pose({0.5, 1, 2}, Eigen::Quaterniond::Identity()));
  const auto fixes = [&] { return flight.slam.graph().position_factors(); };
  ASSERT_EQ(fixes().size(), 1U) << "the newest that is not newer than the node";
  EXPECT_NEAR(fixes()[0].beta, 0.3, 1e-9);
  EXPECT_EQ(fixes()[0].p_world_m, Vector3(2, 3, 4));
  EXPECT_LT((fixes()[0].weight_world_1_m - Vector3(4, 8, 2)).norm(), 1e-12);
  EXPECT_EQ(fixes()[0].huber, 1.7);
  flight.node_at(make_pose({1.0, 1, 2}, Eigen::Quaterniond::Identity()));
  ASSERT_EQ(fixes().size(), 2U) << "the newer fix waited for its node";
  EXPECT_NEAR(fixes()[1].beta, 0.4, 1e-9);
  EXPECT_NE(fixes()[1].before, fixes()[0].before);
  EXPECT_EQ(fixes()[1].before, fixes()[0].after);
  config.use_gnss = false;
  PlainFlight blind(config);
  blind.along_x(0.0);
  blind.slam.add_gnss(fix_at(kNodeTick + 10'000'000, {1, 1, 1}));
  blind.along_x(1.0);
  EXPECT_TRUE(blind.slam.graph().position_factors().empty());
}

TEST(GlobalGraph, OptimizesPeriodicallyAndAppliesAfterLatency) {
  GlobalSlamConfig config;
  config.optimize_every_s = 1.0;
  config.latency_s = 0.3;
  PlainFlight flight(config);
  for (int i = 0; i <= 24; ++i) {
    flight.slam.add_gnss(fix_at(flight.t + kNodeTick, {0.5 * i, 1, 2}));
    flight.node_at(make_pose({0.5 * i, 1, 2}, Eigen::Quaterniond::Identity()));
  }
  // Optimized 1.0 s after the first node and every second from then on, known three nodes later.
  ASSERT_EQ(flight.corrections.size(), 2U);
  EXPECT_EQ(flight.corrections[0].first, 14 * kNodeTick);
  EXPECT_EQ(flight.corrections[1].first, 24 * kNodeTick);
  EXPECT_LT((flight.corrections[0].second.matrix() - Pose::Identity().matrix()).norm(), 1e-3);
  PlainFlight without(config);
  without.along_x(12.0);
  EXPECT_TRUE(without.corrections.empty()) << "nothing new, nothing to optimize";
}

}  // namespace
}  // namespace swiftlet
