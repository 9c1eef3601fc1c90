// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/pose_graph.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/slam/graph/block_cholesky.hpp"
#include "core/slam/graph/gnss_factors.hpp"
#include "core/slam/graph/graph_residuals.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "tests/core/slam/random_poses.hpp"

namespace swiftlet {
namespace {

using testing::random_pose;

double distance(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

/// The derivative of f(T) by changes of T, by central differences.
template <int Rows, class F>
Eigen::Matrix<double, Rows, 6> differences(const F& f, const Pose& T) {
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, Rows, 6> J;
  for (int i = 0; i < 6; ++i) {
    const Vector6 step = kStep * Vector6::Unit(i);
    J.col(i) = (f(moved(T, step)) - f(moved(T, -step))) / (2.0 * kStep);
  }
  return J;
}

TEST(BlockCholesky, SolvesAsADenseSolverDoes) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  constexpr int kBlocks = 40;
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i + 1 < kBlocks; ++i) pairs.emplace_back(i + 1, i);
  for (int i = 0; i < 25; ++i) {
    const int a = static_cast<int>(random() % kBlocks), b = static_cast<int>(random() % kBlocks);
    if (a != b) pairs.emplace_back(a, b);
  }
  BlockCholesky H(kBlocks, pairs);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6 * kBlocks, 6 * kBlocks);
  for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
    const auto [i, j] = pairs[pair];
    Matrix6 Ji, Jj;
    for (int k = 0; k < 36; ++k) Ji(k) = normal(random);
    for (int k = 0; k < 36; ++k) Jj(k) = normal(random);
    H.diagonal(i) += Ji.transpose() * Ji;
    H.diagonal(j) += Jj.transpose() * Jj;
    H.add(pair, Ji.transpose() * Jj);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, 6 * kBlocks);
    J.middleCols<6>(6 * i) += Ji;
    J.middleCols<6>(6 * j) += Jj;
    dense += J.transpose() * J;
  }
  for (int i = 0; i < kBlocks; ++i) H.diagonal(i) += Matrix6::Identity();
  dense += Eigen::MatrixXd::Identity(6 * kBlocks, 6 * kBlocks);
  std::vector<Vector6> b(kBlocks), x;
  Eigen::VectorXd b_dense(6 * kBlocks);
  for (int i = 0; i < 6 * kBlocks; ++i) b[i / 6](i % 6) = b_dense(i) = normal(random);
  ASSERT_TRUE(H.factorize(0.0));
  H.solve(b, x);
  const Eigen::VectorXd expected = dense.ldlt().solve(b_dense);
  for (int i = 0; i < 6 * kBlocks; ++i) EXPECT_NEAR(x[i / 6](i % 6), expected(i), 1e-10);
  ASSERT_TRUE(H.factorize(0.5));
  H.solve(b, x);
  dense.diagonal() *= 1.5;
  const Eigen::VectorXd damped = dense.ldlt().solve(b_dense);
  for (int i = 0; i < 6 * kBlocks; ++i) EXPECT_NEAR(x[i / 6](i % 6), damped(i), 1e-10);
}

TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
  const std::vector<std::pair<int, int>> pairs = {{0, 1}};
  BlockCholesky H(2, pairs);
  H.diagonal(0) = Matrix6::Identity();
  H.diagonal(1) = Matrix6::Identity();
  H.add(0, 2.0 * Matrix6::Identity());
  EXPECT_FALSE(H.factorize(0.0));
  EXPECT_TRUE(H.factorize(2.0)) << "with damping";
}

TEST(PoseGraph, IsBitIdenticalWithReusedWorkspace) {
  std::mt19937 random(3);
  GraphWorkspace workspace;
  for (const int num : {30, 8, 50}) {  // more, fewer, and more again
    PoseGraph graph;
    for (int i = 0; i < num; ++i) graph.add_pose(random_pose(random));
    graph.add(PriorFactor{0, graph.pose(0), Matrix6::Identity()});
    for (int i = 1; i < num; ++i) graph.add(RelativeFactor{i - 1, i, random_pose(random), Matrix6::Identity()});
    for (int i = 3; i < num; i += 3) graph.add(RelativeFactor{i - 3, i, random_pose(random), Matrix6::Identity(), 0.5});
    PoseGraph fresh = graph;
    const GraphReport report = graph.optimize({}, workspace), expected = fresh.optimize({});
    EXPECT_GT(expected.num_iterations, 2);
    EXPECT_EQ(report.num_iterations, expected.num_iterations);
    EXPECT_EQ(report.cost_after, expected.cost_after);
    for (int i = 0; i < num; ++i) EXPECT_EQ(graph.pose(i).matrix(), fresh.pose(i).matrix()) << i;
  }
}

TEST(PoseGraph, DerivativesAreThoseOfTheResiduals) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose A = random_pose(random), B = random_pose(random);
    RelativeFactor relative;
    relative.T_from_to = random_pose(random);
    const RelativeResidual e = residual_of(relative, A, B);
    if (e.r.tail<3>().norm() > 3.0) continue;  // half a turn: the rotation vector jumps
    const auto by_from = differences<6>([&](const Pose& T) { return residual_of(relative, T, B).r; }, A);
    const auto by_to = differences<6>([&](const Pose& T) { return residual_of(relative, A, T).r; }, B);
    EXPECT_LT((e.J_from - by_from).norm(), 1e-7 * (1.0 + by_from.norm()));
    EXPECT_LT((e.J_to - by_to).norm(), 1e-7 * (1.0 + by_to.norm()));
    for (const double off : {0.3, 1.2e-3, 9e-4, 1e-6}) {
      const PriorFactor prior{0, moved(A, off * Vector6::Ones()), Matrix6::Identity()};
      const auto of_prior = differences<6>([&](const Pose& T) { return residual_of(prior, T).r; }, A);
      EXPECT_LT((residual_of(prior, A).J - of_prior).norm(), 1e-7) << off;
    }
    const GravityFactor gravity{0, Vector3(0.1, 0.2, 0.97), 1.0};
    const auto of_gravity = differences<3>([&](const Pose& T) { return residual_of(gravity, T).r_body; }, A);
    EXPECT_LT((residual_of(gravity, A).J_turn - of_gravity.rightCols<3>()).norm(), 1e-7);
    EXPECT_EQ(of_gravity.leftCols<3>().norm(), 0.0);
    const PositionFactor gnss{0, 1, 0.3, Vector3(1, 2, 3), Vector3(2, 3, 4), kNoHuber};
    const auto of_before = differences<3>([&](const Pose& T) { return residual_of(gnss, T, B); }, A);
    Eigen::Matrix<double, 3, 6> expected = Eigen::Matrix<double, 3, 6>::Zero();
    expected.leftCols<3>().diagonal() = 0.7 * gnss.weight_world_1_m;
    EXPECT_LT((of_before - expected).norm(), 1e-7);
  }
}

/// A square of exactly measured poses with an estimate in error.
struct Loop {
  PoseGraph graph;
  std::vector<Pose> truth;

  explicit Loop(int num, unsigned seed = 3, double off = 0.2) {
    std::mt19937 random(seed);
    for (int i = 0; i < num; ++i) {
      const double a = 2.0 * M_PI * i / num;
      truth.push_back(make_pose({10.0 * std::cos(a), 10.0 * std::sin(a), std::sin(2.0 * a)}, rotation_by({0.1, 0, a})));
      graph.add_pose(i == 0 ? truth[0] : truth[i] * random_pose(random, off, 0.3 * off));
    }
    graph.add(PriorFactor{0, truth[0], 1e6 * Matrix6::Identity()});
    for (int i = 1; i < num; ++i) graph.add(edge(i - 1, i));
  }
  RelativeFactor edge(int i, int j) const {
    return {i, j, truth[i].inverse() * truth[j], 1e4 * Matrix6::Identity(), kNoHuber};
  }
  double worst() const {
    double worst = 0.0;
    for (int i = 0; i < graph.num_poses(); ++i) worst = std::max(worst, distance(graph.pose(i), truth[i]));
    return worst;
  }
};

TEST(PoseGraph, FindsTheKnownOptimum) {
  Loop loop(60);
  loop.graph.add(loop.edge(59, 0));
  loop.graph.add(loop.edge(12, 40));
  const GraphReport report = loop.graph.optimize({});
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.num_iterations, 12);
  EXPECT_LT(report.cost_after, 1e-12 * report.cost_before);
  EXPECT_LT(loop.worst(), 1e-6);
}

// A stiff trajectory of 400 m has to rotate by 0.4 rad about a prior at its far end. Straight steps bend it, so that
// the cost rises.
TEST(PoseGraph, ConvergesQuicklyAfterGlobalRotation) {
  PoseGraph graph;
  constexpr int kPoses = 400;
  const Matrix6 stiff = 1e6 * Matrix6::Identity();
  std::mt19937 random(5);
  std::vector<Pose> truth = {Pose::Identity()};
  for (int i = 1; i < kPoses; ++i) {
    truth.push_back(truth.back() * make_pose({1, 0, 0}, rotation_by(0.01 * random_pose(random).translation())));
  }
  const Pose turned = make_pose({3, -2, 1}, rotation_by({0.1, -0.1, 0.4}));
  for (const Pose& T : truth) graph.add_pose(turned * T);
  for (int i = 1; i < kPoses; ++i) graph.add(RelativeFactor{i - 1, i, truth[i - 1].inverse() * truth[i], stiff});
  graph.add(PriorFactor{kPoses - 1, truth.back(), 1e4 * Matrix6::Identity()});
  GraphSolverConfig config;
  config.iterations = 10;
  const GraphReport report = graph.optimize(config);
  EXPECT_TRUE(report.converged) << report.num_iterations;
  for (int i = 0; i < kPoses; i += 50) EXPECT_LT(distance(graph.pose(i), truth[i]), 1e-4) << i;
}

TEST(PoseGraph, SharesErrorAmongEqualEdges) {
  // Four edges of 1 m in a row, and one of 4.5 m over the whole: each takes its fifth of the half meter.
  PoseGraph graph;
  for (int i = 0; i <= 4; ++i) graph.add_pose(make_pose({1.0 * i, 0, 0}, Eigen::Quaterniond::Identity()));
  graph.add(PriorFactor{0, Pose::Identity(), 1e9 * Matrix6::Identity()});
  for (int i = 0; i < 4; ++i) {
    graph.add(RelativeFactor{i, i + 1, make_pose({1, 0, 0}, Eigen::Quaterniond::Identity()), Matrix6::Identity()});
  }
  graph.add(RelativeFactor{0, 4, make_pose({4.5, 0, 0}, Eigen::Quaterniond::Identity()), Matrix6::Identity()});
  EXPECT_TRUE(graph.optimize({}).converged);
  for (int i = 0; i <= 4; ++i) EXPECT_NEAR(graph.pose(i).translation().x(), 1.1 * i, 1e-7);
}

TEST(PoseGraph, RemovesUnobservedTiltByGravity) {
  Loop loop(20, 5, 0.01);
  loop.graph.clear_priors();
  Matrix6 weak = 1e6 * Matrix6::Identity();
  weak(3, 3) = weak(4, 4) = 1e-3;  // the start hardly constrains the tilt
  const Pose tilted = loop.truth[0] * make_pose(Vector3::Zero(), rotation_by({0.05, -0.04, 0}));
  loop.graph.add(PriorFactor{0, tilted, weak});
  for (int i = 0; i < 20; ++i) {
    loop.graph.add(GravityFactor{i, loop.truth[i].linear().transpose() * Vector3::UnitZ(), 0.01});
  }
  EXPECT_TRUE(loop.graph.optimize({}).converged);
  for (int i = 0; i < 20; ++i) {
    const Vector3 up = loop.graph.pose(i).linear().transpose() * Vector3::UnitZ();
    EXPECT_LT((up - loop.truth[i].linear().transpose() * Vector3::UnitZ()).norm(), 1e-4);
  }
}

TEST(PoseGraph, AppliesGnssBetweenKeyFrames) {
  Loop loop(40, 6, 0.0);
  loop.graph.clear_priors();
  const Pose shift = make_pose({30, -20, 4}, rotation_by({0, 0, 0.3}));
  for (int i = 0; i + 1 < 40; ++i) {
    PositionFactor fix{i, i + 1, 0.25, Vector3::Zero(), Vector3::Constant(1.0 / 1.5), kNoHuber};
    fix.p_world_m = shift * Vector3(0.75 * loop.truth[i].translation() + 0.25 * loop.truth[i + 1].translation());
    loop.graph.add(fix);
  }
  GraphSolverConfig config;
  config.iterations = 50;
  EXPECT_TRUE(loop.graph.optimize(config).converged);
  for (int i = 0; i < 40; ++i) EXPECT_LT(distance(loop.graph.pose(i), shift * loop.truth[i]), 1e-4);
}

TEST(PoseGraph, CountsAKeyFrameFixOnce) {
  // With a prior of equal weight the pose settles halfway, in a single step because the problem is linear.
  for (const double beta : {0.0, 0.3, 0.5, 1.0}) {
    PoseGraph graph;
    graph.add_pose(Pose::Identity());
    PriorFactor prior;
    prior.information = Matrix6::Identity();
    graph.add(prior);
    PositionFactor fix{0, 0, beta, Vector3(2, -4, 6), Vector3::Ones(), kNoHuber};
    graph.add(fix);
    GraphSolverConfig config;
    config.iterations = 1;
    graph.optimize(config);
    EXPECT_LT((graph.pose(0).translation() - Vector3(1, -2, 3)).norm(), 1e-3) << beta;
  }
}

TEST(PoseGraph, WeightsGnssAsDocumented) {
  GnssFactorConfig config;
  const Vector3 sigma_m(1.0, 2.0, 4.0);
  config.a = 3.0;
  config.b_1_m = 0.5;
  config.weighting = GnssWeighting::kPerAxis;  // eq. 5 and 7
  EXPECT_LT((gnss_weight_1_m(config, sigma_m) - Vector3(3.5, 2.0, 1.25)).norm(), 1e-12);
  config.weighting = GnssWeighting::kIsotropic;  // eq. 6
  EXPECT_LT((gnss_weight_1_m(config, sigma_m) - Vector3::Constant(1.25)).norm(), 1e-12);
  config.weighting = GnssWeighting::kReleased;
  EXPECT_LT((gnss_weight_1_m(config, sigma_m) - Vector3(3.5, 1.25, 0.6875)).norm(), 1e-12);
  EXPECT_TRUE(gnss_weight_1_m(config, Vector3::Zero()).allFinite());
}

TEST(PoseGraph, MatchesAPrefixGraphWhenTruncated) {
  std::mt19937 random(3);
  PoseGraph graph, first;
  constexpr int kPoses = 9, kKept = 6;
  for (int i = 0; i < kPoses; ++i) {
    const Pose T = random_pose(random);
    graph.add_pose(T);
    if (i < kKept) first.add_pose(T);
  }
  const auto add = [&](const auto& factor, int newest) {
    graph.add(factor);
    if (newest < kKept) first.add(factor);
  };
  for (int from = 0; from < kPoses; ++from) {
    for (int to = 0; to < kPoses; ++to) {
      if (from != to) add(RelativeFactor{from, to, random_pose(random), Matrix6::Identity(), 2.0}, std::max(from, to));
      add(PositionFactor{from, to, 0.3, Vector3(1, 2, 3), Vector3::Ones(), 1.0}, std::max(from, to));
    }
    add(PriorFactor{from, random_pose(random), Matrix6::Identity()}, from);
    add(GravityFactor{from, Vector3::UnitZ(), 0.1}, from);
  }
  graph.truncate(kKept);
  EXPECT_EQ(graph.num_poses(), kKept);
  EXPECT_EQ(graph.cost(), first.cost());
  graph.optimize({});
  first.optimize({});
  for (int i = 0; i < kKept; ++i) EXPECT_EQ(graph.pose(i).matrix(), first.pose(i).matrix());
}

}  // namespace
}  // namespace swiftlet
