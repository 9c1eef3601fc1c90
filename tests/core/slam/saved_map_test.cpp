// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/saved_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

struct MapParts {
  SavedMap map;
  RelativeFactor relative{0, 1, Pose::Identity(), Matrix6::Identity(), kNoHuber};
  PriorFactor prior{0, Pose::Identity(), Matrix6::Identity()};
  GravityFactor gravity{1, Vector3::UnitZ(), 0.1};
  PositionFactor position{0, 1, 0.5, Vector3::Zero(), Vector3::Ones(), 1.0};
  SavedMap::Node node{5, 1};
  SavedMap::Submap submap{0, {{1, 2, 3}}};
  std::vector<Pose> poses = {Pose::Identity(), make_pose({1, 2, 3}, rotation_by({0.1, 0.2, 0.3}))};

  /// Reported fault of the map; more poses allow factors that name poses beyond the map's.
  std::string fault() {
    SavedMap made;
    made.voxel_m = map.voxel_m;
    PoseGraph whole;
    for (int i = 0; i < 4; ++i) whole.add_pose(Pose::Identity());
    whole.add(relative);
    whole.add(prior);
    whole.add(gravity);
    whole.add(position);
    for (std::size_t i = 0; i < poses.size(); ++i) whole.set_pose(static_cast<int>(i), poses[i]);
    made.graph = whole;
    made.nodes = {node};
    made.submaps = {submap};
    return fault_of(made);
  }
};

std::string fault_with(const std::function<void(MapParts&)>& change) {
  MapParts parts;
  change(parts);
  return parts.fault();
}

Pose with(Pose T, int row, int column, double value) {
  T.matrix()(row, column) = value;
  return T;
}

TEST(SavedMap, IsFaultlessWhenConsistent) {
  EXPECT_EQ(MapParts().fault(), "");
  EXPECT_EQ(fault_of(SavedMap()), "") << "nothing is no fault";
  EXPECT_EQ(fault_with([](MapParts& m) { m.position.after = 0; }), "") << "a fix at a pose";
  EXPECT_EQ(fault_with([](MapParts& m) { m.relative.huber = 0.1; }), "");
  EXPECT_EQ(fault_with([](MapParts& m) { m.node.pose = 3; }), "") << "the last pose";
  EXPECT_EQ(fault_with([](MapParts& m) { m.submap.pose = 3; }), "");
}

TEST(SavedMap, SaysWhatDoesNotFitTogether) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double edge_m : {0.0, -0.1, kNoNumber, inf}) {
    EXPECT_EQ(fault_with([&](MapParts& m) { m.map.voxel_m = edge_m; }), "the edge of its voxels is not positive")
        << edge_m;
  }
  const std::vector<Pose> no_poses = {with(Pose::Identity(), 0, 3, kNoNumber), with(Pose::Identity(), 1, 1, kNoNumber),
                                      with(Pose::Identity(), 0, 0, 1.0 + 6e-7), with(Pose::Identity(), 2, 2, -1.0)};
  for (const Pose& T : no_poses) {
    EXPECT_EQ(fault_with([&](MapParts& m) { m.poses[1] = T; }), "pose 1 is none") << T.matrix();
    EXPECT_EQ(fault_with([&](MapParts& m) { m.relative.T_from_to = T; }), "a constraint between poses is invalid");
    EXPECT_EQ(fault_with([&](MapParts& m) { m.prior.T_world_pose = T; }), "the prior of a pose is invalid");
  }
  EXPECT_EQ(fault_with([](MapParts& m) { m.poses[1] = with(Pose::Identity(), 0, 0, 1.0 + 1e-7); }), "")
      << "rounded to single precision it still is one";
  const char* relative = "a constraint between poses is invalid";
  EXPECT_EQ(fault_with([](MapParts& m) { m.relative.information(2, 3) = kNoNumber; }), relative);
  for (const double huber : {0.0, -1.0, kNoNumber}) {
    EXPECT_EQ(fault_with([&](MapParts& m) { m.relative.huber = huber; }), relative) << huber;
    EXPECT_EQ(fault_with([&](MapParts& m) { m.position.huber = huber; }), "a measured position is invalid");
  }
  EXPECT_EQ(fault_with([&](MapParts& m) { m.prior.information(0, 0) = inf; }), "the prior of a pose is invalid");
  const char* gravity = "a direction of gravity is invalid";
  EXPECT_EQ(fault_with([](MapParts& m) { m.gravity.up_body.x() = kNoNumber; }), gravity);
  EXPECT_EQ(fault_with([&](MapParts& m) { m.gravity.sigma_rad = inf; }), gravity);
  const char* position = "a measured position is invalid";
  EXPECT_EQ(fault_with([](MapParts& m) { m.position.beta = kNoNumber; }), position);
  EXPECT_EQ(fault_with([](MapParts& m) { m.position.p_world_m.y() = kNoNumber; }), position);
  EXPECT_EQ(fault_with([](MapParts& m) { m.position.weight_world_1_m.z() = kNoNumber; }), position);
  for (const int none : {-1, 4, 1000}) {
    EXPECT_EQ(fault_with([&](MapParts& m) { m.node.pose = none; }), "a node has no pose");
    EXPECT_EQ(fault_with([&](MapParts& m) { m.submap.pose = none; }), "a submap has no pose");
  }
  EXPECT_EQ(fault_with([](MapParts& m) { m.submap.points_submap_m[0].z() = std::nanf(""); }), "a point is not finite");
}

SavedMap two_submaps() {
  SavedMap map;
  map.voxel_m = 0.5;
  map.graph.add_pose(make_pose({10, 0, 0}, rotation_by({0, 0, M_PI / 2})));
  map.graph.add_pose(make_pose({0, 20, 1}, Eigen::Quaterniond::Identity()));
  map.submaps = {{0, {{1, 2, 3}, {1.05F, 2.05F, 3.05F}}}, {1, {{-1, -2, -3}}}};
  return map;
}

TEST(SavedMap, PlacesPointsWithTheirSubmaps) {
  const std::vector<Eigen::Vector3f> points = points_world_m(two_submaps());
  ASSERT_EQ(points.size(), 3U);
  EXPECT_LT((points[0] - Eigen::Vector3f(8, 1, 3)).norm(), 1e-5F);
  EXPECT_LT((points[2] - Eigen::Vector3f(-1, 18, -2)).norm(), 1e-5F);
}

TEST(SavedMap, PlacesOccupiedVoxelsInRequestedFrame) {
  MapVoxels copy;
  append_voxels(two_submaps(), make_pose({-7.7, 0.1, 0.1}, Eigen::Quaterniond::Identity()), copy);
  EXPECT_EQ(copy.edge_m, 0.5);
  EXPECT_EQ(copy.states, (std::vector<std::string>{"free", "occupied"}));
  EXPECT_EQ(copy.occupied_from, 1);
  ASSERT_EQ(copy.size(), 2U) << "two points in one cube are one voxel";
  EXPECT_LT((copy.centers_local_m[0] - Eigen::Vector3f(0.25F, 1.25F, 3.25F)).norm(), 1e-6F);
  EXPECT_LT((copy.centers_local_m[1] - Eigen::Vector3f(-8.75F, 18.25F, -1.75F)).norm(), 1e-5F);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(copy.state[i], 1);
    EXPECT_EQ(copy.value[i], 1.0F);
  }
}

}  // namespace
}  // namespace swiftlet
