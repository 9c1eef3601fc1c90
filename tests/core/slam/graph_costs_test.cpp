// SPDX-License-Identifier: BSD-3-Clause
// Optima of pose graphs in closed form.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>
#include <vector>

#include "core/slam/graph/gnss_factors.hpp"
#include "core/slam/graph/graph_residuals.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"
#include "tests/core/slam/random_poses.hpp"

namespace swiftlet {
namespace {

using testing::random_information;
using testing::random_pose;

Pose at_place(const Vector3& p_m) { return make_pose(p_m, Eigen::Quaterniond::Identity()); }

Vector3 turn_from(const Pose& a, const Pose& b) {
  const Eigen::AngleAxisd turn(Matrix3(a.linear().transpose() * b.linear()));
  return turn.axis() * std::remainder(turn.angle(), 2.0 * M_PI);
}

TEST(GraphCosts, HuberForceIsConstantBeyondScale) {
  // A prior of weight 1 at the origin; what pulls at it is 50 m away, and its weight is 10 /m.
  for (const double huber : {1.0, 3.0}) {
    PoseGraph fixes;
    fixes.add_pose(Pose::Identity());
    fixes.add(PriorFactor{0, Pose::Identity(), Matrix6::Identity()});
    fixes.add(PositionFactor{0, 0, 0.0, {50, 0, 0}, Vector3::Constant(10.0), huber});
    EXPECT_NEAR(fixes.cost(), huber * 500.0 - 0.5 * huber * huber, 1e-9);
    GraphSolverConfig config;
    config.iterations = 60;
    EXPECT_TRUE(fixes.optimize(config).converged);
    EXPECT_NEAR(fixes.pose(0).translation().x(), 10.0 * huber, 1e-4);

    PoseGraph edges;
    for (int i = 0; i < 2; ++i) edges.add_pose(Pose::Identity());
    edges.add(PriorFactor{0, Pose::Identity(), 1e8 * Matrix6::Identity()});
    edges.add(PriorFactor{1, Pose::Identity(), Matrix6::Identity()});
    edges.add(RelativeFactor{0, 1, at_place({0, 50, 0}), 100.0 * Matrix6::Identity(), huber});
    EXPECT_TRUE(edges.optimize(config).converged);
    EXPECT_NEAR(edges.pose(1).translation().y(), 10.0 * huber, 1e-3);
  }
  // Within the scale it is a spring: 100 : 1 between 0 and 0.05 m, a weighted residual of 0.005.
  PoseGraph near;
  near.add_pose(Pose::Identity());
  near.add(PriorFactor{0, Pose::Identity(), Matrix6::Identity()});
  near.add(PositionFactor{0, 0, 0.0, {0.05, 0, 0}, Vector3::Constant(10.0), 1.0});
  EXPECT_TRUE(near.optimize({}).converged);
  EXPECT_NEAR(near.pose(0).translation().x(), 0.05 * 100.0 / 101.0, 1e-9);
}

TEST(GraphCosts, SolvesLinearProblemsInOneStep) {
  // Two poses side by side, each with a spring, a fix between them and one edge: two unknowns along each axis, and a
  // minimum in closed form.
  for (const double beta : {0.0, 0.25, 0.8}) {
    PoseGraph graph;
    graph.add_pose(at_place({0, 1, 2}));
    graph.add_pose(at_place({4, -1, 0}));
    const double kept[] = {2.0, 0.5}, edge = 3.0;
    const Vector3 fix_m(1.0, 2.0, -1.0), weight(0.7, 1.5, 0.2), step_m(3.5, -1.0, 0.0);
    for (int i = 0; i < 2; ++i) {
      Matrix6 information = 1e12 * Matrix6::Identity();  // they do not turn
      information.topLeftCorner<3, 3>() = kept[i] * Matrix3::Identity();
      graph.add(PriorFactor{i, graph.pose(i), information});
    }
    graph.add(PositionFactor{0, 1, beta, fix_m, weight, kNoHuber});
    graph.add(RelativeFactor{0, 1, at_place(step_m), edge * Matrix6::Identity(), kNoHuber});
    Vector3 expected[2];
    for (int axis = 0; axis < 3; ++axis) {
      const double w = weight[axis] * weight[axis], a = 1.0 - beta;
      Eigen::Matrix2d H;
      H << kept[0] + w * a * a + edge, w * a * beta - edge, w * a * beta - edge, kept[1] + w * beta * beta + edge;
      const Eigen::Vector2d g(
          kept[0] * graph.pose(0).translation()[axis] + w * a * fix_m[axis] - edge * step_m[axis],
          kept[1] * graph.pose(1).translation()[axis] + w * beta * fix_m[axis] + edge * step_m[axis]);
      const Eigen::Vector2d x = H.inverse() * g;
      for (int i = 0; i < 2; ++i) expected[i][axis] = x[i];
    }
    GraphSolverConfig one;
    one.iterations = 1;
    graph.optimize(one);
    for (int i = 0; i < 2; ++i) EXPECT_LT((graph.pose(i).translation() - expected[i]).norm(), 1e-6) << beta << " " << i;
  }
}

TEST(GraphCosts, ConvergesQuadraticallyNearTheMinimum) {
  std::mt19937 random(22);
  std::vector<Pose> truth;
  PoseGraph graph;
  for (int i = 0; i < 8; ++i) {
    truth.push_back(random_pose(random, 4.0, 0.8));
    graph.add_pose(moved(truth.back(), 1e-4 * Vector6::Random()));
  }
  const auto up_of = [&](int i) { return Vector3(truth[static_cast<std::size_t>(i)].linear().row(2).transpose()); };
  for (int i = 0; i < 8; ++i) {
    const int j = (i + 3) % 8;
    graph.add(RelativeFactor{i, j, truth[i].inverse() * truth[j], random_information(random), kNoHuber});
    graph.add(RelativeFactor{j, (j + 3) % 8, truth[j].inverse() * truth[(j + 3) % 8], random_information(random), 1.0});
    graph.add(GravityFactor{i, up_of(i), 0.5});
    const Vector3 fix_m = 0.3 * truth[i].translation() + 0.7 * truth[j].translation();
    graph.add(PositionFactor{i, j, 0.7, fix_m, Vector3(1.0, 2.0, 3.0), 1.0});
    if (i % 3 == 0) graph.add(PriorFactor{i, truth[i], random_information(random)});
  }
  GraphSolverConfig one;
  one.iterations = 1;
  const GraphReport report = graph.optimize(one);
  EXPECT_FALSE(report.converged) << "the step was not small yet";
  for (int i = 0; i < 8; ++i) {
    EXPECT_LT((graph.pose(i).translation() - truth[i].translation()).norm(), 1e-6) << i;
    EXPECT_LT(turn_from(graph.pose(i), truth[i]).norm(), 1e-6) << i;
  }
}

TEST(GraphCosts, NeverGrowFromAnyInitialEstimate) {
  std::mt19937 random(23);
  for (int trial = 0; trial < 10; ++trial) {
    PoseGraph graph;
    std::vector<Pose> truth;
    for (int i = 0; i < 10; ++i) {
      truth.push_back(random_pose(random, 5.0, 1.0));
      graph.add_pose(random_pose(random, 5.0, 2.0));
    }
    graph.add(PriorFactor{0, truth[0], Matrix6::Identity()});
    for (int i = 0; i < 10; ++i) {
      graph.add(RelativeFactor{i, (i + 1) % 10, truth[i].inverse() * truth[(i + 1) % 10], Matrix6::Identity(), 2.0});
    }
    double last = graph.cost();
    GraphSolverConfig few;
    few.iterations = 3;
    for (int i = 0; i < 12; ++i) {
      const GraphReport report = graph.optimize(few);
      EXPECT_LE(report.num_iterations, 3);
      EXPECT_LE(graph.cost(), last + 1e-9) << trial << " " << i;
      last = graph.cost();
    }
  }
}

double sum_of_squares(const std::vector<MatchedPosition>& points, const Pose& T) {
  double sum = 0.0;
  for (const MatchedPosition& m : points) sum += m.weight * (T * m.p_local_m - m.p_world_m).squaredNorm();
  return sum;
}

TEST(GraphCosts, WeightedAlignmentMinimizesSquaredError) {
  std::mt19937 random(24);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 40; ++trial) {
    const Pose T = make_pose({10, -5, 2}, rotation_by({0, 0, 0.4 * trial}));
    std::vector<MatchedPosition> points;
    double mean_x = 0.0, mean_y = 0.0, weight = 0.0;
    for (int i = 0; i < 12; ++i) {
      const Vector3 p(3.0 * normal(random), 2.0 * normal(random), normal(random));
      const Vector3 off(normal(random), normal(random), normal(random));
      points.push_back({p, T * p + 0.5 * off, 0.2 + std::abs(normal(random))});
      mean_x += points.back().weight * p.x();
      mean_y += points.back().weight * p.y();
      weight += points.back().weight;
    }
    const Pose best = fit_to_world(points, 0.0, 0.1);
    const double least = sum_of_squares(points, best);
    for (const double sign : {-1.0, 1.0}) {
      for (int axis = 0; axis < 3; ++axis) {
        Pose other = best;
        other.translation() += sign * 1e-3 * Vector3::Unit(axis);
        EXPECT_GT(sum_of_squares(points, other), least);
      }
      const Vector3 middle(mean_x / weight, mean_y / weight, 0.0);
      Pose other = best;
      other.linear() = rotation_by({0, 0, sign * 1e-3}).toRotationMatrix() * best.linear();
      other.translation() = best * middle - other.linear() * middle;
      EXPECT_GT(sum_of_squares(points, other), least) << trial;
    }
    // Horizontal spread: slightly less than the limit suffices, slightly more does not.
    double spread_m2 = 0.0;
    for (const MatchedPosition& m : points) {
      spread_m2 += m.weight / weight * (m.p_local_m.head<2>() - Eigen::Vector2d(mean_x, mean_y) / weight).squaredNorm();
    }
    EXPECT_NEAR(yaw_of(fit_to_world(points, 0.123, 0.99 * std::sqrt(spread_m2)).linear()), yaw_of(best.linear()), 1e-9);
    const Pose kept = fit_to_world(points, 0.123, 1.01 * std::sqrt(spread_m2));
    EXPECT_NEAR(yaw_of(kept.linear()), 0.123, 1e-12);
  }
}

}  // namespace
}  // namespace swiftlet
