// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/map_join.hpp"

#include <gtest/gtest.h>

#include <random>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"
#include "tests/core/slam/shared_yard.hpp"

namespace swiftlet {
namespace {

using testing::level_at;

const Pose kT_own_other_local = level_at(12, -7, 1.5, 2.1);  // true transform of the local frames

/// Both vehicles fly along a line of the own frame, in opposite directions, with a submap every eight meters.
struct TwoPaths {
  std::vector<SubmapPlace> own, others;
  TwoPaths() {
    for (int i = 0; i < 8; ++i) {
      own.push_back({true, level_at(8.0 * i, 0.3 * i, 2, 0.1 * i), 8.0 * i});
      const Pose T_local = level_at(60.0 - 8.0 * i, 1.0, 2.5, 3.0);
      others.push_back({true, kT_own_other_local.inverse() * T_local, 8.0 * i});
    }
  }
  /// The true relative pose, with an error.
  MapClosure closure(int i, int j, const Pose& error = Pose::Identity()) const {
    const Pose T = own[static_cast<std::size_t>(i)].T_local_submap.inverse() * kT_own_other_local *
                   others[static_cast<std::size_t>(j)].T_local_submap;
    return {i, j, T * error};
  }
};

TEST(MapJoin, ClosesLoopsForTrueClosuresOnly) {
  const TwoPaths paths;
  const MapJoinConfig config;
  EXPECT_LT(loop_chi2(paths.closure(1, 6), paths.closure(4, 3), paths.own, paths.others, config), 1e-12);
  const Pose aside = level_at(0, 3, 0, 0), turned = level_at(0, 0, 0, 0.2);
  EXPECT_GT(loop_chi2(paths.closure(1, 6), paths.closure(4, 3, aside), paths.own, paths.others, config),
            config.chi2_max);
  EXPECT_GT(loop_chi2(paths.closure(1, 6, turned), paths.closure(4, 3), paths.own, paths.others, config),
            config.chi2_max);
}

TEST(MapJoin, MeasuresTheLoopInStandardDeviations) {
  // Without odometry and rotations in between, two closures that differ by d have d^2 / (2 sigma^2).
  TwoPaths paths;
  MapJoinConfig config;
  config.closure_attitude_deg = 1e-6;
  config.odometry_position_m_sqrt_m = config.odometry_attitude_deg_sqrt_m = 1e-9;
  config.closure_position_m = 0.1;
  const double chi2 =
      loop_chi2(paths.closure(2, 5), paths.closure(3, 4, level_at(0.3, 0, 0, 0)), paths.own, paths.others, config);
  EXPECT_NEAR(chi2, 0.3 * 0.3 / (2.0 * 0.1 * 0.1), 1e-6);
}

TEST(MapJoin, TakesTheLargestConsistentSet) {
  const TwoPaths paths;
  const std::vector<MapClosure> closures = {paths.closure(1, 6), paths.closure(2, 2, level_at(5.7, 0, 0, 0)),
                                            paths.closure(3, 4), paths.closure(5, 3), paths.closure(6, 1)};
  EXPECT_EQ(agreeing_closures(closures, paths.own, paths.others, {}), (std::vector<int>{0, 2, 3, 4}));
}

TEST(MapJoin, OneClosureIsNeverEnough) {
  const TwoPaths paths;
  const std::vector<MapClosure> one = {paths.closure(1, 6)};
  EXPECT_TRUE(agreeing_closures(one, paths.own, paths.others, {}).empty());
  const std::vector<MapClosure> contrary = {paths.closure(1, 6), paths.closure(3, 4, level_at(0, 4, 0, 0))};
  EXPECT_TRUE(agreeing_closures(contrary, paths.own, paths.others, {}).empty());
  const std::vector<MapClosure> twice = {paths.closure(1, 6), paths.closure(2, 6)};
  EXPECT_TRUE(agreeing_closures(twice, paths.own, paths.others, {}).empty())
      << "both closures use the same cloud of the other vehicle";
}

TEST(MapJoin, TakesNeitherOfTwoAmbiguousSets) {
  const TwoPaths paths;
  const Pose aisle = level_at(0, 5.68, 0, 0);  // equal offset of both closures in the second set
  const auto shifted = [&](int i, int j) {
    const Pose& T_own = paths.own[static_cast<std::size_t>(i)].T_local_submap;
    MapClosure c = paths.closure(i, j);
    c.T_own_other = T_own.inverse() * aisle * T_own * c.T_own_other;
    return c;
  };
  std::vector<MapClosure> closures = {paths.closure(1, 6), paths.closure(3, 4), shifted(2, 5), shifted(4, 3)};
  EXPECT_TRUE(agreeing_closures(closures, paths.own, paths.others, {}).empty());
  closures.push_back(paths.closure(5, 2));
  closures.push_back(paths.closure(6, 1));
  EXPECT_TRUE(agreeing_closures(closures, paths.own, paths.others, {}).size() == 4U) << "four against two";
}

TEST(MapJoin, OmitsUnknownPosesOfTheOther) {
  TwoPaths paths;
  paths.others[4].known = false;
  const std::vector<MapClosure> closures = {
      paths.closure(1, 6), paths.closure(3, 4), paths.closure(5, 3), {4, 99, Pose::Identity()}};
  EXPECT_EQ(agreeing_closures(closures, paths.own, paths.others, {}), (std::vector<int>{0, 2}));
}

TEST(MapJoin, FindsThePoseBetweenTheFrames) {
  const TwoPaths paths;
  const std::vector<MapClosure> closures = {paths.closure(1, 6), paths.closure(5, 3)};
  const MapJoin joined = join_maps(closures, std::vector<int>{0, 1}, paths.own, paths.others, {});
  EXPECT_LT((joined.T_local_otherlocal.matrix() - kT_own_other_local.matrix()).norm(), 1e-6);
  for (std::size_t i = 0; i < paths.others.size(); ++i) {
    EXPECT_LT(
        (joined.T_local_other[i].matrix() - (kT_own_other_local * paths.others[i].T_local_submap).matrix()).norm(),
        1e-6);
  }
}

TEST(MapJoin, ImprovesWithClosuresAndStaysConsistent) {
  const TwoPaths paths;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const MapJoinConfig config;
  const double sigma_m = config.closure_position_m, sigma_rad = config.closure_attitude_deg * kRadPerDeg;
  double all_sq_m2 = 0.0, two_sq_m2 = 0.0, reported_m2 = 0.0;
  for (int draw = 0; draw < 200; ++draw) {
    std::vector<MapClosure> closures;
    for (int i = 0; i < 6; ++i) {
      const double x = sigma_m * normal(random), y = sigma_m * normal(random), z = sigma_m * normal(random);
      closures.push_back(paths.closure(i + 1, 7 - i, level_at(x, y, z, sigma_rad * normal(random))));
    }
    const Vector3 p_m = paths.others.back().T_local_submap.translation();
    const auto error_sq_m2 = [&](const MapJoin& joined) {
      return (joined.T_local_otherlocal * p_m - kT_own_other_local * p_m).squaredNorm();
    };
    const MapJoin all = join_maps(closures, std::vector<int>{0, 1, 2, 3, 4, 5}, paths.own, paths.others, config);
    all_sq_m2 += error_sq_m2(all);
    reported_m2 += all.covariance.topLeftCorner<3, 3>().trace();
    two_sq_m2 += error_sq_m2(join_maps(closures, std::vector<int>{4, 5}, paths.own, paths.others, config));
  }
  EXPECT_LT(all_sq_m2, 0.7 * two_sq_m2);
  EXPECT_GT(reported_m2, all_sq_m2) << "odometry has no errors here";
}

TEST(PoseGraph, VariancesAddUpAlongAChain) {
  PoseGraph graph;
  const int a = graph.add_pose(Pose::Identity()), b = graph.add_pose(level_at(0, 0, 0, 0));
  graph.add(PriorFactor{a, Pose::Identity(), Matrix6::Identity() / 0.04});
  graph.add(RelativeFactor{a, b, Pose::Identity(), Matrix6::Identity() / 0.09, kNoHuber});
  EXPECT_LT((graph.covariance_of(a) - 0.04 * Matrix6::Identity()).norm(), 1e-9);
  EXPECT_LT((graph.covariance_of(b) - 0.13 * Matrix6::Identity()).norm(), 1e-9);
}

}  // namespace
}  // namespace swiftlet
