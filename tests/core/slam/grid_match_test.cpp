// SPDX-License-Identifier: BSD-3-Clause
// The least squares of the document's local SLAM: derivatives, and displacements that are known.
#include "core/slam/matching/grid_match.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <type_traits>
#include <vector>

#include "swiftlet/core/localization/rotation.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

using testing::SyntheticRoom;

const SyntheticRoom kChamber = SyntheticRoom::box({-5.33, -4.11, -1.72}, {6.42, 3.87, 2.61});

Pose moved_by(const Pose& T, const Vector6& d) {
  return make_pose(T.translation() + d.head<3>(), Eigen::Quaterniond(T.linear()) * rotation_by(d.tail<3>()));
}

/// Returns of a sensor at the body's origin, in the body frame.
std::vector<Eigen::Vector3f> seen_from(const SyntheticRoom& room, const Pose& T_world_body, int num, unsigned seed,
                                       double sigma_m = 0.01) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3f> points_body_m;
  for (int i = 0; i < num; ++i) {
    const Vector3 direction = Vector3(normal(random), normal(random), normal(random)).normalized();
    const double range_m =
        room.range_m(T_world_body.translation(), T_world_body.linear() * direction) + sigma_m * normal(random);
    if (range_m < 60.0) points_body_m.push_back((range_m * direction).cast<float>());
  }
  return points_body_m;
}

GridSubmap submap_of(const SyntheticRoom& room, int scans = 12) {
  GridSubmapConfig config;
  config.scans = 1000;
  GridSubmaps submaps(config);
  for (int scan = 0; scan < scans; ++scan) {
    std::vector<Vector3> points_m;
    const Pose T = make_pose({0.02 * scan, -0.01 * scan, 0}, rotation_by({0, 0, 0.03 * scan}));
    for (const Eigen::Vector3f& p : seen_from(room, T, 9000, 100 + scan)) points_m.push_back(T * p.cast<double>());
    submaps.insert(points_m, T.translation());
  }
  return submaps.older();
}

/// Central difference of fourth order.
template <class F>
std::invoke_result_t<F, double> derivative(F&& f, double h) {
  return ((f(-2.0 * h) - f(2.0 * h)) + 8.0 * (f(h) - f(-h))) / (12.0 * h);
}

TEST(GridCost, ThePointsTermHasItsDerivatives) {
  const GridSubmap submap = submap_of(kChamber, 4);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  int num_sloped = 0;
  for (const HybridGrid* grid : {&submap.high, &submap.low}) {
    for (const Eigen::Vector3f& point : seen_from(kChamber, Pose::Identity(), 300, 2)) {
      Vector6 off = Vector6::Zero();
      for (double& x : off) x = uniform(random);
      const Pose T = moved_by(Pose::Identity(), 0.2 * off);
      const grid_cost::Miss miss = grid_cost::miss_of(*grid, point, T);
      EXPECT_NEAR(miss.r, 1.0 - grid->interpolate(T * point.cast<double>()).probability, 1e-12);
      num_sloped += miss.by_pose.head<3>().norm() > 0.1;
      for (int i = 0; i < 6; ++i) {
        const double numeric = derivative(
            [&](double h) { return grid_cost::miss_of(*grid, point, moved_by(T, h * Vector6::Unit(i))).r; }, 2e-6);
        EXPECT_NEAR(miss.by_pose(i), numeric, 2e-3 * std::max(1.0, std::abs(numeric)));
      }
    }
  }
  EXPECT_GT(num_sloped, 100);
}

TEST(GridCost, MatchesDerivativesOfThePredictionTerms) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    Vector6 a = Vector6::Zero(), b = Vector6::Zero();
    for (double& x : a) x = normal(random);
    for (double& x : b) x = 0.5 * normal(random);
    const Pose T_predicted = moved_by(Pose::Identity(), a), T = moved_by(T_predicted, b);
    const grid_cost::Change change = grid_cost::change_of(T, T_predicted);
    EXPECT_LT((change.r.head<3>() - b.head<3>()).norm(), 1e-12);
    const double angle = b.tail<3>().norm();
    EXPECT_LT((change.r.tail<3>() - std::sin(0.5 * angle) / angle * b.tail<3>()).norm(), 1e-9);
    for (int i = 0; i < 6; ++i) {
      const Vector6 numeric = derivative(
          [&](double h) -> Vector6 { return grid_cost::change_of(moved_by(T, h * Vector6::Unit(i)), T_predicted).r; },
          1e-3);
      EXPECT_LT((change.by_pose.col(i) - numeric).norm(), 1e-9);
    }
  }
}

TEST(GridsMatch, DerivesEvidenceFromTheCostGradient) {
  const GridSubmap submap = submap_of(kChamber, 4);
  const auto points_body_m = seen_from(kChamber, Pose::Identity(), 400, 4);
  const std::array<GridCloud, 2> clouds{GridCloud{&submap.high, points_body_m, 1.0},
                                        GridCloud{&submap.low, points_body_m, 6.0}};
  GridMatchConfig still;  // prevents any step
  still.translation_weight_1_m = still.rotation_weight = 1e6;
  const Pose T = make_pose({0.03, -0.02, 0.04}, rotation_by({0.01, 0.02, -0.01}));
  const GridsMatch here = match_to_grids(clouds, submap.origin_local_m, T, still);
  EXPECT_LT(here.moved.norm(), 1e-9);
  for (int i = 0; i < 6; ++i) {
    const double numeric = derivative(
        [&](double h) {
          return match_to_grids(clouds, submap.origin_local_m, moved_by(T, h * Vector6::Unit(i)), still).evidence.cost;
        },
        1e-6);
    EXPECT_NEAR(2.0 * here.evidence.g(i), numeric, 2e-3 * here.evidence.g.norm()) << "r^2 has the slope 2 r J";
  }
}

struct WorstError {
  double off_m, off_rad;
};

/// Largest distance of the least-cost pose from the truth, over ten predictions with errors up to 0.1 m and 0.01 rad.
WorstError worst_of(const SyntheticRoom& room, const GridMatchConfig& config) {
  const GridSubmap submap = submap_of(room);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  WorstError worst{0.0, 0.0};
  for (int trial = 0; trial < 10; ++trial) {
    Vector6 off = Vector6::Zero();
    for (double& x : off) x = uniform(random);
    off.head<3>() *= 0.1;
    off.tail<3>() *= 0.01;
    const Pose T_true = make_pose({0.1, -0.05, 0.02}, rotation_by({0.02, -0.01, 0.2}));
    const auto points_body_m = seen_from(room, T_true, 3000, 10 + trial);
    const GridsMatch match = match_to_grids({GridCloud{&submap.high, points_body_m, config.high_weight},
                                             GridCloud{&submap.low, points_body_m, config.low_weight}},
                                            submap.origin_local_m, moved_by(T_true, off), config);
    const Matrix3 turn = T_true.linear().transpose() * match.T_local_body.linear();
    worst.off_m = std::max(worst.off_m, (match.T_local_body.translation() - T_true.translation()).norm());
    worst.off_rad = std::max(worst.off_rad, rotation_vector_rad(Eigen::Quaterniond(turn)).norm());
  }
  return worst;
}

GridMatchConfig of_points_alone() {
  GridMatchConfig config;
  config.translation_weight_1_m = config.rotation_weight = 1e-3;
  config.iterations = 50;
  return config;
}

TEST(GridsMatch, FindsDisplacementForCellCenteredWalls) {
  // Whole numbers of cells of both grids, 0.1 and 0.45 m, from where the submap begins.
  const WorstError worst = worst_of(SyntheticRoom::box({-5.4, -4.5, -1.8}, {6.3, 3.6, 2.7}), of_points_alone());
  EXPECT_LT(worst.off_m, 0.005);
  EXPECT_LT(worst.off_rad, 0.001);
}

TEST(GridsMatch, ErrsByWallOffsetWithinCells) {
  const WorstError both = worst_of(kChamber, of_points_alone());
  EXPECT_LT(both.off_m, 0.5 * 0.45);
  EXPECT_LT(both.off_rad, 0.01);
  GridMatchConfig fine = of_points_alone();
  fine.low_weight = 0.01;
  const WorstError alone = worst_of(kChamber, fine);
  EXPECT_LT(alone.off_m, 0.5 * 0.1);
  EXPECT_LT(alone.off_rad, 0.005);
}

TEST(GridsMatch, IsHeldToPredictionByWeights) {
  const GridSubmap submap = submap_of(kChamber);
  const auto points_body_m = seen_from(kChamber, Pose::Identity(), 3000, 20);
  const std::array<GridCloud, 2> clouds{GridCloud{&submap.high, points_body_m, 1.0},
                                        GridCloud{&submap.low, points_body_m, 6.0}};
  const Pose T_off = make_pose({0.06, 0.0, 0.0}, Eigen::Quaterniond::Identity());
  double last_m = 1.0;
  for (const double weight : {0.1, 5.0, 20.0, 1000.0}) {
    GridMatchConfig config;
    config.translation_weight_1_m = weight;
    config.iterations = 100;
    const GridsMatch match = match_to_grids(clouds, submap.origin_local_m, T_off, config);
    const double moved_m = match.moved.head<3>().norm();
    EXPECT_LT(moved_m, last_m) << weight;
    last_m = moved_m;
    // At the least cost a further step is zero.
    const Vector6 gradient = match.evidence.g + match.held.cwiseProduct(match.moved);
    const Matrix6 H = match.evidence.H + Matrix6(match.held.asDiagonal());
    const Vector6 step = H.inverse() * gradient;
    EXPECT_LT(step.head<3>().norm(), 2e-3) << weight;
    EXPECT_LT(step.tail<3>().norm(), 2e-4) << weight;
  }
  EXPECT_LT(last_m, 1e-3);
}

TEST(GridsMatch, StaysAtPredictionWithoutOverlap) {
  const GridSubmap submap = submap_of(kChamber, 1);
  const Pose T_far = make_pose({100, 0, 0}, rotation_by({0.1, 0, 0}));
  const auto points_body_m = seen_from(kChamber, Pose::Identity(), 300, 21);
  const GridsMatch match =
      match_to_grids({GridCloud{&submap.high, points_body_m, 1.0}, GridCloud{&submap.low, points_body_m, 6.0}},
                     submap.origin_local_m, T_far, {});
  EXPECT_LT(match.moved.norm(), 1e-9);
  EXPECT_TRUE(match.evidence.H.isZero());
}

}  // namespace
}  // namespace swiftlet
