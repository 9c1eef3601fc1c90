// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/global_slam.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet {
namespace {

constexpr double kSide_m = 8.0;  // side of the flown square

/// Around a square at constant height, nose ahead along x.
Vector3 on_square_m(double path_m, double side_m = kSide_m) {
  const double w = std::fmod(path_m, 4.0 * side_m);
  if (w < side_m) return {w, 0, 2};
  if (w < 2.0 * side_m) return {side_m, w - side_m, 2};
  if (w < 3.0 * side_m) return {3.0 * side_m - w, side_m, 2};
  return {0, 4.0 * side_m - w, 2};
}

/// Walls of a yard around the square, and boxes in it.
std::vector<Vector3> yard_world_m() {
  std::vector<Vector3> points;
  std::mt19937 random(1);
  std::normal_distribution<double> off(0.0, 0.005);
  const auto add_wall = [&](double x0, double y0, double x1, double y1, double height_m) {
    const int n = static_cast<int>(std::hypot(x1 - x0, y1 - y0) / 0.2), m = static_cast<int>(height_m / 0.2);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= m; ++j) {
        const double f = static_cast<double>(i) / n, dx = off(random), dy = off(random);
        points.emplace_back(x0 + f * (x1 - x0) + dx, y0 + f * (y1 - y0) + dy, 0.2 * j);
      }
    }
  };
  for (int i = -25; i <= 65; ++i) {
    for (int j = -25; j <= 65; ++j) points.emplace_back(0.2 * i, 0.2 * j, off(random));
  }
  add_wall(-5, -5, 13, -4, 4);
  add_wall(13, -4, 12, 13, 4);
  add_wall(-5, -5, -4, 12, 4);
  add_wall(3, 2.5, 5, 3, 3);
  add_wall(2.5, 6, 3.5, 4.5, 3);
  return points;
}

/// Another place: a round hut, and fences that stand in other directions.
std::vector<Vector3> other_place_world_m() {
  std::vector<Vector3> points;
  for (int i = -25; i <= 65; ++i) {
    for (int j = -25; j <= 65; ++j) points.emplace_back(0.2 * i, 0.2 * j, 0.0);
  }
  for (int i = 0; i <= 60; ++i) {
    for (int j = 0; j <= 15; ++j) {
      const double along_m = 0.2 * i, z_m = 0.2 * j, angle = 0.1 * i;
      points.emplace_back(-3.0 + 0.6 * along_m, 11.0 - 0.3 * along_m, z_m);
      points.emplace_back(4.0 + 1.7 * std::cos(angle), 4.5 + 1.7 * std::sin(angle), z_m);
      points.emplace_back(10.5 + 0.2 * along_m, -4.0 + 0.5 * along_m, 0.5 * z_m);
    }
  }
  return points;
}

struct Flight {
  explicit Flight(GlobalSlam its_slam) : slam(std::move(its_slam)) {}

  GlobalSlam slam;
  std::optional<Pose> correction;
  TimeNs t = 0;
  std::vector<Vector3> place_world_m = yard_world_m();
  Pose T_local_world = Pose::Identity();  // before any drift
  double from_m = 0.0;
  double side_m = kSide_m;
  int i = 0;  // steps of half a meter

  void step(const Vector3& drift_per_m) { fly(0.5 * i, drift_per_m); }

  /// Local SLAM drifts along `drift_per_m`. Its scans take a while: fixes of `gnss_ahead` later are there already.
  void fly(double path_m, const Vector3& drift_per_m, double gnss_every_m = 0.0,
           const Pose& T_world_true = Pose::Identity(), int gnss_ahead = 0) {
    for (; 0.5 * i <= path_m; ++i) {
      t += 250'000'000;
      const Vector3 p_world_m = on_square_m(from_m + 0.5 * i, side_m);
      const Vector3 p_local_m = T_local_world * p_world_m + 0.5 * i * drift_per_m;
      std::vector<Eigen::Vector3f> points;
      for (const Vector3& p : place_world_m) {
        if ((p - p_world_m).norm() < 9.0) points.push_back((p - p_world_m).cast<float>());
      }
      if (gnss_every_m > 0.0)
        slam.add_gnss({t + gnss_ahead * 250'000'000, T_world_true * on_square_m(0.5 * (i + gnss_ahead)),
                       Vector3::Zero(), Vector3::Constant(0.02), Vector3::Ones()});
      slam.add_scan(t, make_pose(p_local_m, Eigen::Quaterniond(T_local_world.linear())), points, Pose::Identity());
      if (const std::optional<Pose> c = slam.correction(t)) correction = c;
    }
  }
};

TEST(GlobalSlam, ClosesLoopAndReportsDriftedFrame) {
  GlobalSlamConfig config;
  config.closure_gap_m = 20.0;
  Flight flight(GlobalSlam(config, true));
  const Vector3 drift_per_m(0.006, -0.004, 0.002);
  flight.fly(60.0, drift_per_m);
  EXPECT_GE(flight.slam.num_closures(), 1);
  ASSERT_TRUE(flight.correction);
  const Vector3 p_world_m = on_square_m(60.0), p_local_m = p_world_m + 60.0 * drift_per_m;
  const double before_m = (p_local_m - p_world_m).norm();
  EXPECT_GT(before_m, 0.4);
  EXPECT_LT((*flight.correction * p_local_m - p_world_m).norm(), 0.5 * before_m);
  EXPECT_EQ((*flight.correction).linear()(2, 2), 1.0) << "both frames have z up";

  std::vector<Overlay> overlays;
  flight.slam.append_overlays(overlays);
  std::map<std::string, std::size_t> sizes;
  for (const Overlay& overlay : overlays) sizes[overlay.name] = overlay.positions.size();
  EXPECT_EQ(sizes["slam.closures"], 2U * static_cast<std::size_t>(flight.slam.num_closures())) << "lines between two";
  EXPECT_EQ(sizes["slam.submaps"], static_cast<std::size_t>(flight.slam.num_submaps()));
  EXPECT_GT(sizes["slam.trajectory"], sizes["slam.submaps"]);
}

// On the second lap the surroundings are others: what is compared does not match.
TEST(GlobalSlam, CountsRefusedClosuresByReason) {
  GlobalSlamConfig config;
  config.closure_gap_m = 20.0;
  Flight flight(GlobalSlam(config, true));
  flight.fly(4.0 * kSide_m, Vector3::Zero());
  flight.place_world_m = other_place_world_m();
  flight.fly(7.0 * kSide_m, Vector3::Zero());
  std::vector<Counter> counters;
  flight.slam.append_counters(counters);
  std::uint64_t refused = 0, compared = 0;
  for (const Counter& counter : counters) {
    refused += counter.count;
    compared = std::max(compared, counter.of);
  }
  EXPECT_GT(refused, 0U);
  EXPECT_EQ(compared, refused + static_cast<std::uint64_t>(flight.slam.num_closures()));
  std::vector<Overlay> overlays;
  flight.slam.append_overlays(overlays);
  ASSERT_EQ(overlays.back().name, "slam.refused");
  EXPECT_EQ(overlays.back().positions.size(), 2 * refused) << "lines between two";
}

// Present points stand still in the vehicle's local frame. Old submaps move to their places relative to them.
TEST(GlobalSlam, ClosureMovesOldSubmapsNotNewest) {
  GlobalSlamConfig config;
  config.closure_gap_m = 20.0;
  Flight flight(GlobalSlam(config, true));
  const Vector3 drift_per_m(0.006, -0.004, 0.002);
  flight.fly(25.0, drift_per_m);
  EXPECT_EQ(flight.slam.num_closures(), 0);
  const SubmapPoses before = flight.slam.submap_poses();
  ASSERT_EQ(before.T_local_own.size(), static_cast<std::size_t>(flight.slam.num_submaps()));
  EXPECT_LT((before.T_local_own[0].translation() - on_square_m(0.0)).norm(), 1e-9);
  Flight longer(GlobalSlam(config, true));
  longer.fly(60.0, drift_per_m);
  ASSERT_GE(longer.slam.num_closures(), 1);
  ASSERT_TRUE(longer.correction);
  const SubmapPoses& after = longer.slam.submap_poses();
  EXPECT_GT(after.revision, before.revision);
  const Vector3 drift_m = 60.0 * drift_per_m;
  const Vector3 off_before_m = before.T_local_own[0].translation() - on_square_m(0.0) - drift_m;
  const Vector3 off_after_m = after.T_local_own[0].translation() - on_square_m(0.0) - drift_m;
  EXPECT_LT(off_after_m.norm(), 0.5 * off_before_m.norm());
  const Pose& T_newest = after.T_local_own.back();
  EXPECT_EQ(T_newest.linear(), Matrix3::Identity()) << "as local SLAM placed it";
}

TEST(GlobalSlam, MovesSubmapsWhenCorrectionBecomesKnown) {
  GlobalSlamConfig config;
  config.closure_gap_m = 20.0;
  config.latency_s = 3.0;
  Flight flight(GlobalSlam(config, true));
  bool moved_early = false;
  const Vector3 drift_per_m(0.006, -0.004, 0.002);
  while (!flight.correction && flight.i < 200) {
    const bool closed = flight.slam.num_closures() > 0;
    const double p_m = flight.slam.submap_poses().T_local_own.empty()
                           ? 0.0
                           : flight.slam.submap_poses().T_local_own[0].translation().x();
    moved_early = moved_early || (closed && p_m != 0.0);
    flight.step(drift_per_m);
  }
  ASSERT_TRUE(flight.correction);
  EXPECT_FALSE(moved_early);
  EXPECT_NE(flight.slam.submap_poses().T_local_own[0].translation().x(), 0.0);
}

// Round after round through the same yard. Clouds of later rounds hold nothing new.
TEST(GlobalSlam, MemoryGrowsWithSpaceNotDistance) {
  const auto points_after = [](double rounds, double covered_share) {
    GlobalSlamConfig config;
    config.closure_gap_m = 20.0;
    config.covered_share = covered_share;
    Flight flight(GlobalSlam(config, true));
    flight.fly(rounds * 4.0 * kSide_m, {0.002, -0.001, 0.001});
    return static_cast<double>(flight.slam.num_points());
  };
  const double one = points_after(1.3, 0.7), five = points_after(5.3, 0.7), all = points_after(5.3, 1.0);
  EXPECT_GT(all, 3.0 * one) << "else there is nothing to forget";
  EXPECT_LT(five, 1.5 * one);
}

// A drift of 3 mm a meter comes to 0.5 m over the flight: closures hold it.
TEST(GlobalSlam, BoundsStationaryGraphWhileClosingLoops) {
  GlobalSlamConfig config;
  config.visits_kept = 2;
  config.searches = 1;
  const Vector3 drift_per_m(0.002, -0.002, 0.001);
  Flight flight(GlobalSlam(config, true));
  flight.side_m = 4.0;
  const auto sizes = [&] {
    const auto map = flight.slam.saved_map();
    EXPECT_EQ(fault_of(*map), "");
    EXPECT_EQ(map->submaps.size(), flight.slam.submap_poses().T_local_own.size());
    const PoseGraph& graph = map->graph;
    return std::vector<std::size_t>{map->submaps.size(), map->nodes.size(), graph.relative_factors().size(),
                                    flight.slam.num_points()};
  };
  flight.fly(100.0, drift_per_m);
  const std::vector<std::size_t> before = sizes();
  const int closures = flight.slam.num_closures();
  flight.fly(180.0, drift_per_m);
  const std::vector<std::size_t> after = sizes();
  EXPECT_LE(after[0], before[0] + 1) << "submaps, of which ten would be new";
  EXPECT_LE(after[1], before[1] + 20) << "nodes, of which 160 would be new";
  EXPECT_LE(after[2], before[2] + 50) << "factors";
  EXPECT_LE(after[3], before[3] * 11 / 10) << "points";
  EXPECT_GT(flight.slam.num_closures(), closures + 5);
  EXPECT_GT(flight.slam.submap_poses().dropped.count, 8U);
  ASSERT_TRUE(flight.correction);
  const Vector3 p_world_m = on_square_m(180.0, 4.0), p_local_m = p_world_m + 180.0 * drift_per_m;
  EXPECT_LT((*flight.correction * p_local_m - p_world_m).norm(), 0.15);
}

// The limit also holds without closures.
TEST(GlobalSlam, BoundsGraphInPlaceWithoutClosures) {
  GlobalSlamConfig config;
  config.visits_kept = 2;
  config.searches = 0;
  Flight flight(GlobalSlam(config, true));
  flight.side_m = 4.0;
  flight.fly(100.0, Vector3::Zero());
  const int submaps = flight.slam.num_submaps(), nodes = flight.slam.num_nodes();
  flight.fly(400.0, Vector3::Zero());
  EXPECT_EQ(flight.slam.num_submaps(), submaps);
  EXPECT_LE(flight.slam.num_nodes(), nodes + 20);
  EXPECT_FALSE(flight.correction);
  const PoseGraph& graph = flight.slam.graph();
  EXPECT_LT((graph.pose(graph.num_poses() - 1).translation() - on_square_m(400.0, 4.0)).norm(), 9.0);
}

// The flight leaves a known place for a larger round and comes back to it.
TEST(GlobalSlam, ClosesLoopWhenRevisitingKnownPlace) {
  GlobalSlamConfig config;
  config.visits_kept = 2;
  config.closure_gap_m = 20.0;
  const Vector3 drift_per_m(0.003, -0.003, 0.001);
  Flight flight(GlobalSlam(config, true));
  flight.side_m = 4.0;
  flight.fly(63.5, drift_per_m);
  ASSERT_GT(flight.slam.submap_poses().dropped.count, 0U);
  flight.side_m = 8.0;
  flight.fly(95.5, drift_per_m);
  flight.side_m = 4.0;
  flight.fly(160.0, drift_per_m);
  const auto map = flight.slam.saved_map();
  int on_the_round = 0;
  for (const SavedMap::Node& node : map->nodes) {
    const double path_m = 2.0 * (to_seconds(node.t) - 0.25);
    const bool on_round = path_m >= 64.0 && path_m < 96.0;
    on_the_round += on_round;
    const Vector3 off_m = map->graph.pose(node.pose).translation() - on_square_m(path_m, on_round ? 8.0 : 4.0);
    EXPECT_LT(off_m.norm(), 0.2) << path_m << " m, where " << (path_m * drift_per_m).norm() << " m have drifted";
  }
  EXPECT_GE(on_the_round, 30) << "new space stays";
}

TEST(GlobalSlam, KeepsSubmapOfChangedSurroundings) {
  GlobalSlamConfig config;
  config.visits_kept = 1;
  config.searches = 0;
  config.covered_share = 0.9;
  Flight flight(GlobalSlam(config, true));
  flight.side_m = 4.0;
  flight.fly(60.0, Vector3::Zero());
  ASSERT_GT(flight.slam.submap_poses().dropped.count, 0U);
  const int submaps = flight.slam.num_submaps();
  flight.place_world_m = other_place_world_m();
  flight.fly(85.0, Vector3::Zero());
  EXPECT_GE(flight.slam.num_submaps(), submaps + 2);
}

// During a hover of an hour with GNSS the last fixes are kept: the next node uses the newest fix that is not newer.
TEST(GlobalSlam, KeepsNextNodesFixAfterHovering) {
  Flight flight(GlobalSlam({}, true));
  flight.fly(0.0, Vector3::Zero());
  TimeNs t = flight.t;
  for (int i = 0; i < 36'000; ++i) {
    t += 100'000'000;
    flight.slam.add_gnss({t, Vector3(i, 0, 0), Vector3::Zero(), Vector3::Constant(0.02), Vector3::Ones()});
  }
  flight.slam.add_scan(t - 550'000'000, make_pose({0.6, 0, 2}, Eigen::Quaterniond::Identity()), {}, Pose::Identity());
  const auto fixes = flight.slam.graph().position_factors();
  ASSERT_EQ(fixes.size(), 1U);
  EXPECT_EQ(fixes[0].p_world_m.x(), 35'993.0) << "the newest that is not newer than the scan";
}

TEST(GlobalSlam, ForgetsOnlyPointsInOlderSubmaps) {
  GlobalSlamConfig config;
  config.closure_gap_m = 20.0;
  Flight flight(GlobalSlam(config, true));
  flight.fly(3.3 * 4.0 * kSide_m, Vector3::Zero());
  const std::shared_ptr<const SavedMap> map = flight.slam.saved_map();
  std::vector<Vector3> kept_m;
  for (const SavedMap::Submap& submap : map->submaps) {
    for (const Eigen::Vector3f& p : submap.points_submap_m) {
      kept_m.push_back(map->graph.pose(submap.pose) * p.cast<double>());
    }
  }
  int missing = 0, seen = 0;
  for (const Vector3& p_m : flight.place_world_m) {
    if ((p_m - Vector3(4, 4, 2)).head<2>().norm() > 11.0) continue;  // farther points were out of range
    ++seen;
    missing += std::none_of(kept_m.begin(), kept_m.end(), [&](const Vector3& k) { return (k - p_m).norm() < 0.5; });
  }
  EXPECT_GT(seen, 1000);
  EXPECT_LT(missing, seen / 100);
}

TEST(GlobalSlam, ClosesLoopFromUnknownStart) {
  GlobalSlamConfig config;
  config.closure_gap_m = 20.0;
  Flight flight(GlobalSlam(config, false));
  flight.fly(60.0, {0.006, -0.004, 0.002});
  EXPECT_GE(flight.slam.num_closures(), 1);
}

TEST(GlobalSlam, CorrectsNothingWithoutARevisit) {
  Flight flight(GlobalSlam({}, true));
  flight.fly(25.0, Vector3(0.01, 0, 0));
  EXPECT_EQ(flight.slam.num_closures(), 0);
  EXPECT_FALSE(flight.correction);
  EXPECT_GE(flight.slam.num_submaps(), 3);
}

// Scans take a while to match, so newer fixes arrive before the node of their scan.
TEST(GlobalSlam, FitsUnknownStartToEnuAxes) {
  GlobalSlamConfig config;
  config.optimize_every_s = 2.0;
  const Pose T = make_pose({200, -100, 30}, rotation_by({0, 0, 1.2}));
  for (const int gnss_ahead : {0, 2}) {
    Flight flight(GlobalSlam(config, false));
    flight.fly(30.0, Vector3::Zero(), 0.5, T, gnss_ahead);
    ASSERT_TRUE(flight.correction) << gnss_ahead;
    EXPECT_LT((*flight.correction * on_square_m(30.0) - T * on_square_m(30.0)).norm(), 0.1) << gnss_ahead;
    EXPECT_NEAR(yaw_of(flight.correction->linear()), 1.2, 0.02) << gnss_ahead;
  }
}

std::shared_ptr<const SavedMap> map_of_the_yard() {
  Flight flight(GlobalSlam({}, true));
  flight.fly(30.0, Vector3::Zero());
  return flight.slam.saved_map();
}

TEST(GlobalSlam, SavesGraphAndCloudsForReuse) {
  const auto map = map_of_the_yard();
  EXPECT_EQ(fault_of(*map), "");
  EXPECT_EQ(map->nodes.size(), 61U);
  EXPECT_GE(map->submaps.size(), 3U);
  for (const Eigen::Vector3f& p : points_world_m(*map)) {
    EXPECT_GT(p.x(), -5.2F);
    EXPECT_LT(p.x(), 13.2F);
  }
  for (const SavedMap::Node& node : map->nodes) {
    const Vector3 p_world_m = map->graph.pose(node.pose).translation();
    EXPECT_LT((p_world_m - on_square_m(2.0 * (to_seconds(node.t) - 0.25))).norm(), 0.02);
  }
}

TEST(GlobalSlam, LocatesUninformedFlightInLoadedMap) {
  GlobalSlamConfig config;
  config.loaded_map = map_of_the_yard();
  for (const double yaw_rad : {0.3, 2.0, -2.6}) {
    Flight flight(GlobalSlam(config, false));
    const Pose T_world_local = make_pose({40, -70, 5}, rotation_by({0, 0, yaw_rad}));
    flight.T_local_world = T_world_local.inverse();
    flight.from_m = 13.0;
    flight.fly(12.0, Vector3::Zero());
    ASSERT_TRUE(flight.slam.located()) << yaw_rad;
    ASSERT_TRUE(flight.correction);
    const SubmapPoses& poses = flight.slam.submap_poses();
    ASSERT_EQ(poses.num_given, config.loaded_map->submaps.size());
    ASSERT_EQ(poses.T_local_given.size(), poses.num_given) << "poses of the loaded submaps";
    EXPECT_EQ(poses.given.size(), poses.num_given) << "points of the loaded submaps";
    const Vector3 given_world_m = config.loaded_map->T_world_submap(config.loaded_map->submaps[1]).translation();
    EXPECT_LT((poses.T_local_given[1].translation() - flight.T_local_world * given_world_m).norm(), 0.1) << yaw_rad;
    const Vector3 p_world_m = on_square_m(25.0), p_local_m = flight.T_local_world * p_world_m;
    EXPECT_LT((*flight.correction * p_local_m - p_world_m).norm(), 0.05) << yaw_rad;
    EXPECT_LT(std::abs(yaw_of(Matrix3(flight.correction->linear() * flight.T_local_world.linear()))), 0.005);
    const auto both = flight.slam.saved_map();
    EXPECT_GT(both->submaps.size(), config.loaded_map->submaps.size())
        << "the saved map contains loaded and new submaps";
    EXPECT_EQ(fault_of(*both), "");
  }
}

/// Scans of a vehicle that hovers, of which each sees one side only, after the first one.
void turn_at_one_place(Flight& flight, int num_scans) {
  const Vector3 p_world_m = on_square_m(13.0);
  for (int i = 0; i < num_scans; ++i) {
    flight.t += 1'000'000'000;
    const double yaw_rad = 0.4 * i;
    const Vector3 ahead(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
    std::vector<Eigen::Vector3f> points;
    for (const Vector3& p : flight.place_world_m) {
      const Vector3 d = p - p_world_m;
      if (d.norm() < 9.0 && d.dot(ahead) > 0.85 * d.norm()) points.push_back(d.cast<float>());
    }
    flight.slam.add_scan(flight.t, flight.T_local_world * make_pose(p_world_m, Eigen::Quaterniond::Identity()), points,
                         Pose::Identity());
  }
}

TEST(GlobalSlam, LocatesHoveringVehicleOnceItTurns) {
  GlobalSlamConfig config;
  config.loaded_map = map_of_the_yard();
  Flight flight(GlobalSlam(config, false));
  flight.T_local_world = make_pose({40, -70, 5}, rotation_by({0, 0, 0.3})).inverse();
  turn_at_one_place(flight, 1);
  ASSERT_FALSE(flight.slam.located()) << "one side is ambiguous";
  turn_at_one_place(flight, 17);
  EXPECT_TRUE(flight.slam.located());
  EXPECT_LE(flight.slam.num_nodes(), 10);
}

TEST(GlobalSlam, StopsSearchingWhenHoveringElsewhere) {
  GlobalSlamConfig config;
  config.loaded_map = map_of_the_yard();
  Flight flight(GlobalSlam(config, false));
  flight.place_world_m = other_place_world_m();
  turn_at_one_place(flight, 200);
  EXPECT_FALSE(flight.slam.located());
  EXPECT_EQ(flight.slam.num_nodes(), 10) << "memory does not grow with time";
}

TEST(GlobalSlam, LeavesMapUnchangedWhenElsewhere) {
  GlobalSlamConfig config;
  config.loaded_map = map_of_the_yard();
  Flight flight(GlobalSlam(config, false));
  flight.place_world_m = other_place_world_m();
  flight.fly(30.0, Vector3::Zero());
  EXPECT_FALSE(flight.slam.located());
  EXPECT_TRUE(flight.slam.submap_poses().T_local_given.empty());
  EXPECT_TRUE(flight.slam.submap_poses().given.empty());
  EXPECT_FALSE(flight.correction);
  EXPECT_EQ(flight.slam.num_closures(), 0);
  EXPECT_EQ(flight.slam.saved_map(), config.loaded_map);
}

TEST(GlobalSlam, PlacesLoadedSubmapsFromKnownStart) {
  GlobalSlamConfig config;
  config.loaded_map = map_of_the_yard();
  Flight flight(GlobalSlam(config, true));
  flight.fly(0.0, Vector3::Zero());
  const SubmapPoses& poses = flight.slam.submap_poses();
  ASSERT_EQ(poses.T_local_given.size(), config.loaded_map->submaps.size());
  for (std::size_t i = 0; i < poses.num_given; ++i) {
    const Pose& T_world_submap = config.loaded_map->T_world_submap(config.loaded_map->submaps[i]);
    EXPECT_LT((poses.T_local_given[i].matrix() - T_world_submap.matrix()).norm(), 1e-9);
  }
}

// The map that a later flight saves has the cells that mappers of both flights have seen.
TEST(GlobalSlam, KeepsCellsOfEarlierFlight) {
  const auto piece_of = [](int submap) {
    CellBlock block;
    block.free[0] = 1;
    const CellBlock blocks[] = {block};
    return MapPiece{submap, Pose::Identity(), std::make_shared<const SubmapCells>(0.2, blocks)};
  };
  const auto earlier = std::make_shared<SavedMap>(*map_of_the_yard());
  ASSERT_GE(earlier->submaps.size(), 3U);
  earlier->pieces = {piece_of(1), piece_of(2)};
  GlobalSlamConfig config;
  config.loaded_map = earlier;
  Flight flight(GlobalSlam(config, true));
  flight.fly(0.0, Vector3::Zero());
  const SubmapPoses& poses = flight.slam.submap_poses();
  const MapPiece own = piece_of(0);
  const auto saved = with_pieces(flight.slam.saved_map(), poses, {&own, 1});
  ASSERT_EQ(saved->pieces.size(), 3U);
  for (int i : {0, 1}) {
    EXPECT_EQ(saved->pieces[i].submap, 1 + i);
    EXPECT_EQ(saved->pieces[i].cells, earlier->pieces[i].cells);
  }
  EXPECT_EQ(saved->pieces[2].submap, static_cast<int>(poses.num_given));
  EXPECT_EQ(fault_of(*saved), "");
  EXPECT_EQ(pieces_of(*saved).size(), saved->submaps.size()) << "submaps without cells have those of their points";
}

TEST(GlobalSlam, KnownStartClosesLoopsAcrossFlights) {
  GlobalSlamConfig config;
  config.loaded_map = map_of_the_yard();
  Flight flight(GlobalSlam(config, true));
  const Vector3 drift_per_m(0.006, -0.004, 0.002);
  flight.fly(28.0, drift_per_m);
  EXPECT_GE(flight.slam.num_closures(), 2) << "on the first lap, where it has none of its own to close";
  ASSERT_TRUE(flight.correction);
  const Vector3 p_world_m = on_square_m(28.0), p_local_m = p_world_m + 28.0 * drift_per_m;
  EXPECT_LT((*flight.correction * p_local_m - p_world_m).norm(), 0.7 * (p_local_m - p_world_m).norm());
}

}  // namespace
}  // namespace swiftlet
