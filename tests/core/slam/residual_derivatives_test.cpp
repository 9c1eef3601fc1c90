// SPDX-License-Identifier: BSD-3-Clause
// The derivatives of the pose graph's residuals against automatic differentiation of the residuals as they are defined.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <unsupported/Eigen/AutoDiff>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {
namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Dual = Eigen::AutoDiffScalar<Vector12>;  // derivatives by the steps of two poses
using DualVector = Eigen::Matrix<Dual, 3, 1>;
using DualMatrix = Eigen::Matrix<Dual, 3, 3>;

struct DualPose {
  DualMatrix R;
  DualVector p;
};

DualMatrix skew(const DualVector& v) {
  const Dual zero(0.0);
  DualMatrix K;
  K << zero, -v.z(), v.y(), v.z(), zero, -v.x(), -v.y(), v.x(), zero;
  return K;
}

/// A pose moved by six of the twelve steps, which are zero: of the exponential the linear term is all that counts.
DualPose stepped(const Pose& T, int first) {
  DualVector shift, turn;
  for (int i = 0; i < 3; ++i) {
    shift(i) = Dual(0.0, 12, first + i);
    turn(i) = Dual(0.0, 12, first + 3 + i);
  }
  const DualMatrix R = T.linear().cast<Dual>(), I = DualMatrix::Identity();
  return {R * (I + skew(turn)), T.translation().cast<Dual>() + shift};
}

/// The rotation vector of a turn that is neither none nor half a turn.
DualVector logarithm(const DualMatrix& R) {
  const Dual half(0.5);
  const DualVector v(half * (R(2, 1) - R(1, 2)), half * (R(0, 2) - R(2, 0)), half * (R(1, 0) - R(0, 1)));
  const Dual sine = sqrt(Dual(v.squaredNorm())), cosine = half * (R.trace() - Dual(1.0));
  const Dual angle = atan2(sine, cosine);
  return v * Dual(angle / sine);
}

DualMatrix of(const Matrix3& R) { return R.cast<Dual>(); }
DualVector of(const Vector3& v) { return v.cast<Dual>(); }

template <int Rows>
void expect_row_wise(const DualVector& expected, const Eigen::Matrix<double, Rows, 1>& r,
                     const Eigen::Matrix<double, Rows, 12>& J, int first_row) {
  for (int i = 0; i < 3; ++i) {
    const int row = first_row + i;
    EXPECT_NEAR(r(row), expected(i).value(), 1e-12 * (1.0 + std::abs(r(row)))) << row;
    EXPECT_LT((J.row(row).transpose() - expected(i).derivatives()).norm(), 1e-9 * (1.0 + J.row(row).norm())) << row;
  }
}

class ResidualDerivatives : public ::testing::Test {
 protected:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  /// Turned by 0.02 to 3 rad.
  Pose pose() { return make_pose(vector(50.0), rotation_by(uniform(0.02, 3.0) * vector(1.0).normalized())); }

  std::mt19937 random_{11};
};

TEST_F(ResidualDerivatives, RelativePoseMatchesItsDefinition) {
  for (int trial = 0; trial < 200; ++trial) {
    const Pose T_from = pose(), T_to = pose();
    // The residual is a rotation of 0.02 to 2.5 rad.
    const Pose left = make_pose(vector(2.0), rotation_by(uniform(0.02, 2.5) * vector(1.0).normalized()));
    const RelativeFactor factor{0, 1, T_from.inverse() * T_to * left.inverse(), Matrix6::Identity()};
    const RelativeResidual result = residual_of(factor, T_from, T_to);
    Eigen::Matrix<double, 6, 12> J;
    J << result.J_from, result.J_to;
    const DualPose from = stepped(T_from, 0), to = stepped(T_to, 6);
    expect_row_wise<6>(from.R.transpose() * (to.p - from.p) - of(Vector3(factor.T_from_to.translation())), result.r, J,
                       0);
    const DualMatrix turn = of(Matrix3(factor.T_from_to.linear().transpose())) * from.R.transpose() * to.R;
    expect_row_wise<6>(logarithm(turn), result.r, J, 3);
  }
}

TEST_F(ResidualDerivatives, WorldPositionMatchesItsDefinition) {
  for (int trial = 0; trial < 200; ++trial) {
    const Pose T = pose();
    const PriorFactor factor{0, T * make_pose(vector(2.0), rotation_by(uniform(0.02, 2.5) * vector(1.0).normalized())),
                             Matrix6::Identity()};
    const PriorResidual result = residual_of(factor, T);
    Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
    J.leftCols<6>() = result.J;
    const DualPose its = stepped(T, 0);
    expect_row_wise<6>(its.p - of(Vector3(factor.T_world_pose.translation())), result.r, J, 0);
    expect_row_wise<6>(logarithm(of(Matrix3(factor.T_world_pose.linear().transpose())) * its.R), result.r, J, 3);
  }
}

TEST_F(ResidualDerivatives, GravityMatchesItsDefinition) {
  for (int trial = 0; trial < 200; ++trial) {
    const Pose T = pose();
    const GravityFactor factor{0, vector(1.0).normalized(), 0.01};
    const GravityResidual result = residual_of(factor, T);
    Eigen::Matrix<double, 3, 12> J = Eigen::Matrix<double, 3, 12>::Zero();
    J.middleCols<3>(3) = result.J_turn;
    const DualVector up = stepped(T, 0).R.transpose() * of(Vector3(Vector3::UnitZ()));
    expect_row_wise<3>(up - of(factor.up_body), result.r_body, J, 0);
  }
}

// Its derivatives are (1 - beta) and beta times the weights [Orsulic 2021, eqs. 3 and 4].
TEST_F(ResidualDerivatives, FixBetweenPosesMatchesItsDefinition) {
  for (int trial = 0; trial < 200; ++trial) {
    const Pose T_before = pose(), T_after = pose();
    const PositionFactor factor{0, 1, uniform(0.0, 1.0), vector(50.0), vector(3.0).cwiseAbs()};
    Eigen::Matrix<double, 3, 12> J = Eigen::Matrix<double, 3, 12>::Zero();
    J.leftCols<3>() = (1.0 - factor.beta) * factor.weight_world_1_m.asDiagonal().toDenseMatrix();
    J.middleCols<3>(6) = factor.beta * factor.weight_world_1_m.asDiagonal().toDenseMatrix();
    const DualVector p = stepped(T_before, 0).p * Dual(1.0 - factor.beta) + stepped(T_after, 6).p * Dual(factor.beta);
    expect_row_wise<3>((p - of(factor.p_world_m)).cwiseProduct(of(factor.weight_world_1_m)),
                       residual_of(factor, T_before, T_after), J, 0);
  }
}

}  // namespace
}  // namespace swiftlet
