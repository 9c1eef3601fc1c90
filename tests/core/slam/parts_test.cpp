// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/slam/symmetric_eigen.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

TEST(SymmetricEigen, ReconstructsMatrixWithAscendingEigenvalues) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    Matrix6 A;
    for (int i = 0; i < 36; ++i) A(i) = normal(random);
    A = (A * A.transpose()).eval();
    const SymmetricEigen<6> eigen = symmetric_eigen<6>(A);
    EXPECT_LT((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose() - A).norm(), 1e-12 * A.norm());
    EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Matrix6::Identity()).norm(), 1e-13);
    for (int i = 1; i < 6; ++i) EXPECT_LE(eigen.values(i - 1), eigen.values(i));
  }
}

TEST(SymmetricEigen, IsExactForDiagonalMatrices) {
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(Vector3(3.0, 1.0, 2.0).asDiagonal());
  EXPECT_EQ(eigen.values, Vector3(1.0, 2.0, 3.0));
  EXPECT_EQ(eigen.vectors.col(0).cwiseAbs(), Vector3(0.0, 1.0, 0.0));
  EXPECT_EQ(symmetric_eigen<3>(Matrix3::Zero()).values, Vector3::Zero());
}

TEST(RotationVector, InvertsItsRotation) {
  for (const double angle : {0.0, 1e-9, 1e-5, 0.1, 1.0, 3.0, 3.14}) {
    const Vector3 v = angle * Vector3(0.36, -0.48, 0.8);
    const Eigen::Quaterniond q = rotation_by(v);
    EXPECT_LT((rotation_vector_rad(q) - v).norm(), 1e-12);
    EXPECT_LT((rotation_vector_rad(Eigen::Quaterniond(-q.w(), -q.x(), -q.y(), -q.z())) - v).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace swiftlet
