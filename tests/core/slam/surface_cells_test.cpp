// SPDX-License-Identifier: BSD-3-Clause
// One cell of surfaces against plain statistics of its points, and which cells there are.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <vector>

#include "core/slam/matching/surface_map.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet {
namespace {

constexpr double kFace_m = -0.11;  // offset of cell faces, so that no wall at a round coordinate lies on a face

/// A map of one level of large cells.
SurfaceMapConfig one_level(double cell_m = 2.0) {
  SurfaceMapConfig config;
  config.cell_m = cell_m;
  config.levels = 1;
  return config;
}

struct PlainFit {
  Vector3 mean_m = Vector3::Zero();
  Matrix3 covariance = Matrix3::Zero();
  Eigen::SelfAdjointEigenSolver<Matrix3> eigen;

  explicit PlainFit(const std::vector<Vector3>& points) {
    const auto n = static_cast<double>(points.size());
    for (const Vector3& p : points) mean_m += p / n;
    for (const Vector3& p : points) covariance += (p - mean_m) * (p - mean_m).transpose() / (n - 1.0);
    eigen.compute(covariance);
  }
  double variance(int i) const { return eigen.eigenvalues()(i); }
};

TEST(SurfaceCells, AreTheStatisticsOfTheirPoints) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto spread = [&](double low, double high) { return low * std::pow(high / low, uniform(random)); };
  int planes = 0, poles = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    // Blobs, plates and rods of any attitude within one cell of 2 m.
    const double edge_m = 2.0;
    const Vector3 sigma_m = trial % 2 == 0 ? Vector3(spread(0.01, 0.2), spread(0.03, 0.3), spread(0.05, 0.5))
                                           : Vector3(spread(0.01, 0.12), spread(0.12, 0.5), spread(0.2, 0.5));
    const Vector3 tilt_rad = trial % 3 == 0 ? Vector3(Vector3::Random() * 3.0) : Vector3(Vector3::Random() * 0.6);
    const Eigen::Quaterniond q = rotation_by(tilt_rad);
    const Vector3 cell = Vector3(trial % 7 - 3, trial % 5 - 2, trial % 3 - 1);
    const Vector3 low_m = edge_m * cell + Vector3::Constant(kFace_m), middle_m = low_m + Vector3::Constant(1.0);
    const int num = 6 + static_cast<int>(60 * uniform(random));
    std::vector<Vector3> points;
    while (static_cast<int>(points.size()) < num) {
      const Vector3 p = middle_m + q * sigma_m.cwiseProduct(Vector3(normal(random), normal(random), normal(random)));
      if ((p - middle_m).cwiseAbs().maxCoeff() < 0.99) points.push_back(p);
    }
    SurfaceMap map(one_level());
    map.insert(points, middle_m);
    ASSERT_EQ(map.num_cells(), 1U);
    const SurfaceCell* found = map.find(middle_m, middle_m);
    ASSERT_NE(found, nullptr);
    const PlainFit plain(points);
    ASSERT_EQ(found->count, static_cast<float>(num));
    ASSERT_EQ(found->count_fitted, static_cast<float>(num));
    ASSERT_LT((found->mean_m.cast<double>() - plain.mean_m).norm(), 1e-5);
    const double most = plain.variance(2);
    // n - 1 points scatter freely about their mean, and n - 3 about their plane.
    ASSERT_NEAR(found->variance_m2, plain.variance(0) * (num - 1.0) / (num - 3.0), 3e-5 * most + 2e-6);
    ASSERT_NEAR(found->narrow_variance_m2, plain.variance(1), 1e-5 * most + 1e-6);
    ASSERT_NEAR(found->wide_variance_m2, plain.variance(2), 1e-5 * most + 1e-6);
    if (plain.variance(1) > 1.3 * plain.variance(0)) {
      ASSERT_GT(std::abs(found->normal.cast<double>().dot(plain.eigen.eigenvectors().col(0))), 0.999);
    }
    if (plain.variance(2) > 1.3 * plain.variance(1)) {
      ASSERT_GT(std::abs(found->axis.cast<double>().dot(plain.eigen.eigenvectors().col(2))), 0.999);
    }

    planes += found->planar;
    poles += found->pole;
    ASSERT_FALSE(found->planar && found->pole);
    ASSERT_EQ(map.find_pole(middle_m), found->pole ? found : nullptr);
  }
  EXPECT_GT(planes, 250);
  EXPECT_GT(poles, 40);
}

/// A patch of a level plane of so many points around (1, 1) in the cell from 0.
std::vector<Vector3> patch(int num, double height_m = 0.5) {
  std::vector<Vector3> points;
  for (int i = 0; i < num; ++i) {
    points.emplace_back(1.0 + 0.7 * std::cos(2.4 * i), 1.0 + 0.7 * std::sin(2.4 * i), height_m + 0.01 * (i % 3));
  }
  return points;
}

TEST(SurfaceCells, LimitTheNumberOfPoints) {
  SurfaceMapConfig config = one_level();
  config.points_per_cell = 40;
  SurfaceMap map(config);
  const Vector3 at_m(1.0, 1.0, 0.5);
  map.insert(patch(39), at_m);
  EXPECT_FALSE(map.is_full(*map.find(at_m, at_m)));
  map.insert(patch(1), at_m);
  EXPECT_TRUE(map.is_full(*map.find(at_m, at_m)));
  const Eigen::Vector3f mean_m = map.find(at_m, at_m)->mean_m;
  map.insert(patch(50, 1.5), at_m);
  EXPECT_EQ(map.find(at_m, at_m)->count, 40.0F);
  EXPECT_EQ(map.find(at_m, at_m)->mean_m, mean_m) << "what was seen early stays the reference";
}

TEST(SurfaceCells, KeepFacesOfWallsApart) {
  constexpr double kThickness_m = 0.06;
  const auto face = [](double x_m) {
    std::vector<Vector3> points;
    for (int i = 0; i < 100; ++i) points.emplace_back(x_m, 0.1 + 0.17 * (i % 10), 0.1 + 0.17 * (i / 10));
    return points;
  };
  const Vector3 inside_m(-3.0, 1.0, 1.0), outside_m(3.0, 1.0, 1.0), front_m(0.8, 1.0, 1.0);
  for (const bool two_faced : {true, false}) {
    SurfaceMapConfig config = one_level();
    config.two_faced = two_faced;
    SurfaceMap map(config);
    map.insert(face(front_m.x()), inside_m);
    map.insert(face(front_m.x() + kThickness_m), outside_m);
    EXPECT_EQ(map.num_cells(), two_faced ? 2U : 1U);
    const SurfaceCell* front = map.find(front_m, inside_m);
    const SurfaceCell* back = map.find(front_m, outside_m);
    const double scatter_m = two_faced ? 0.0 : 0.5 * kThickness_m, between_m = two_faced ? kThickness_m : 0.0;
    EXPECT_NEAR(back->mean_m.x() - front->mean_m.x(), between_m, 1e-4);
    EXPECT_NEAR(std::sqrt(front->variance_m2), scatter_m, 1e-3);
    if (two_faced) EXPECT_LT(front->normal.x(), 0.0F) << "towards the sensor";
  }
}

/// A blob that is no plane, within 0.2 m of a place that lies in the same cell at every level.
std::vector<Vector3> blob(int num, const Vector3& around_m) {
  std::vector<Vector3> points;
  for (int i = 0; i < num; ++i) {
    points.emplace_back(around_m + 0.1 * Vector3(std::cos(2.4 * i), std::sin(2.4 * i), std::cos(1.1 * i)));
  }
  return points;
}

TEST(SurfaceCells, LimitResolutionByRange) {
  // At the center of a smallest cell of 0.25 m, and of all cells above it.
  const Vector3 at_m = Vector3::Constant(kFace_m + 0.125);
  std::size_t last = 5;
  for (const double range_m : {1.0, 30.0, 60.0, 120.0}) {
    SurfaceMap map({});
    map.insert(blob(60, at_m), at_m + Vector3(0.0, range_m, 0.0));
    EXPECT_LT(map.num_cells(), last) << range_m;
    last = map.num_cells();
  }
  EXPECT_EQ(last, 1U);
}

TEST(SurfaceCells, AreForgottenOnlyBeyondTheRadius) {
  SurfaceMapConfig config = one_level(1.0);
  config.keep_radius_m = 6.0;
  SurfaceMap map(config);
  std::vector<Vector3> middles_m, points;
  for (int i = 0; i < 20 * 20; ++i) {
    const Vector3 corner_m = Vector3(i % 20 - 10, i / 20 - 10, 0.0) + Vector3::Constant(kFace_m);
    middles_m.emplace_back(corner_m + Vector3::Constant(0.5));
    for (int k = 0; k < 7; ++k) points.push_back(corner_m + Vector3::Constant(0.1 + 0.1 * k));
  }
  map.insert(points, Vector3::Zero());
  ASSERT_EQ(map.num_cells(), 400U);
  const Vector3 center_m(1.3, -0.4, 0.6);
  map.keep_around(center_m);
  std::size_t kept = 0;
  for (const Vector3& middle_m : middles_m) {
    const bool near = (middle_m - center_m).norm() <= 6.0;
    kept += near ? 1 : 0;
    EXPECT_EQ(map.find(middle_m, Vector3::Zero()) != nullptr, near) << middle_m.transpose();
    if (near) {
      EXPECT_LT((map.find(middle_m, Vector3::Zero())->mean_m.cast<double>() - middle_m + Vector3::Constant(0.1)).norm(),
                1e-5);
    }
  }
  EXPECT_EQ(map.num_cells(), kept);
  EXPECT_GT(kept, 80U);
  // Forgotten surfaces are mapped again.
  map.insert(points, Vector3::Zero());
  EXPECT_EQ(map.num_cells(), 400U);
  map.clear();
  EXPECT_EQ(map.num_cells(), 0U);
  EXPECT_EQ(map.find(middles_m[0], Vector3::Zero()), nullptr);
}

TEST(SurfaceCells, AreAllFoundInLargeMap) {
  // More cells than its table begins with.
  SurfaceMap map(one_level(0.5));
  std::vector<Vector3> points;
  constexpr int kSide = 16;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const Vector3 cell(i % kSide - 8, i / kSide % kSide - 8, i / kSide / kSide - 8);
    for (int k = 0; k < 6; ++k) points.push_back(0.5 * cell + Vector3::Constant(kFace_m + 0.05 + 0.08 * k));
  }
  map.insert(points, Vector3::Zero());
  ASSERT_EQ(map.num_cells(), static_cast<std::size_t>(kSide * kSide * kSide));
  for (std::size_t i = 0; i < points.size(); i += 6) {
    const Vector3 mean_m = points[i] + Vector3::Constant(0.2);
    ASSERT_NE(map.find(points[i], Vector3::Zero()), nullptr);
    ASSERT_LT((map.find(points[i], Vector3::Zero())->mean_m.cast<double>() - mean_m).norm(), 1e-5);
  }
  EXPECT_GE(map.bytes(), map.num_cells() * sizeof(SurfaceCell));
}

TEST(SurfaceCells, ReturnTheLargestPlaneAcrossSizes) {
  // A wall and a bush in one cell of 2 m: the wall has its plane in a smaller cell, and the bush has none.
  SurfaceMap map({});
  std::mt19937 random(32);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto draw = [&] { return uniform(random); };
  std::vector<Vector3> points;
  for (int i = 0; i < 250; ++i) {
    points.emplace_back(kFace_m + 0.1 + 0.02 * draw(), kFace_m + 2.0 * draw(), kFace_m + 2.0 * draw());
    points.emplace_back(kFace_m + 1.0 + 0.95 * draw(), kFace_m + 2.0 * draw(), kFace_m + 2.0 * draw());
  }
  for (int i = 0; i < 3; ++i) map.insert(points, Vector3::Zero());
  const Vector3 wall_m(kFace_m + 0.11, kFace_m + 0.5, kFace_m + 0.5),
      bush_m(kFace_m + 1.5, kFace_m + 0.5, kFace_m + 0.5);
  ASSERT_NE(map.find(wall_m, Vector3::Zero()), nullptr);
  EXPECT_TRUE(map.find(wall_m, Vector3::Zero())->planar);
  EXPECT_GT(std::abs(map.find(wall_m, Vector3::Zero())->normal.x()), 0.99F);
  ASSERT_NE(map.find(bush_m, Vector3::Zero()), nullptr);
  EXPECT_FALSE(map.find(bush_m, Vector3::Zero())->planar);
  EXPECT_LT(map.find(bush_m, Vector3::Zero())->count, 250.0F) << "points of the bush come from a smaller cell";
}

}  // namespace
}  // namespace swiftlet
