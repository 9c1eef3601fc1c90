// SPDX-License-Identifier: BSD-3-Clause
// Cells of the rule-based Lloyd algorithm, sample by sample.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/guidance/flocking/rbl_cell.hpp"
#include "tests/support/draws.hpp"

namespace swiftlet {
namespace {

using testing::Draws;

/// Reference: a list of all samples.
struct PlainCell {
  struct Sample {
    Vector3 p_m;
    bool in = true, close = false;  // close: to a border, where single precision may decide otherwise
  };
  PlainCell(double radius_m_in, double step_m, bool planar, const Vector3& lattice_m, double z_low_m, double z_high_m)
      : radius_m(radius_m_in) {
    Vector3 origin_m = lattice_m - step_m * (lattice_m / step_m).array().round().matrix();
    if (planar) origin_m.z() = 0.0;
    const int n = static_cast<int>(radius_m / step_m) + 2;
    for (int k = planar ? 0 : -n; k <= (planar ? 0 : n); ++k) {
      for (int j = -n; j <= n; ++j) {
        for (int i = -n; i <= n; ++i) {
          const Vector3 p_m = origin_m + step_m * Vector3(i, j, k);
          const bool at_height = planar || (p_m.z() >= z_low_m - 1e-6 && p_m.z() <= z_high_m + 1e-6);
          if (p_m.norm() <= radius_m * (1.0 + 1e-8) && at_height) samples.push_back({p_m});
        }
      }
    }
  }
  void keep(const std::function<double(const Vector3&)>& beyond_m) {
    for (Sample& sample : samples) {
      const double d = beyond_m(sample.p_m);
      sample.close = sample.close || std::abs(d) < 1e-5;
      sample.in = sample.in && d <= 0.0;
    }
  }
  int num_in() const {
    return static_cast<int>(std::count_if(samples.begin(), samples.end(), [](const Sample& s) { return s.in; }));
  }
  bool is_clear() const {
    return std::none_of(samples.begin(), samples.end(), [](const Sample& s) { return s.close; });
  }
  Vector3 centroid(const Vector3& destination_m, double beta_m, bool of_all) const {
    double least_m = std::numeric_limits<double>::infinity(), sum = 0.0;
    for (const Sample& s : samples) least_m = std::min(least_m, (s.p_m - destination_m).norm());
    Vector3 moment = Vector3::Zero();
    for (const Sample& s : samples) {
      if (!s.in && !of_all) continue;
      const double weight = std::exp((least_m - (s.p_m - destination_m).norm()) / beta_m);
      sum += weight;
      moment += weight * s.p_m;
    }
    return sum > 0.0 ? Vector3(moment / sum) : Vector3(Vector3::Zero());
  }

  double radius_m;
  std::vector<Sample> samples;
};

void compare(RblCell& cell, const PlainCell& plain, Draws& draws) {
  ASSERT_EQ(cell.num_samples(), static_cast<int>(plain.samples.size()));
  int num_in = 0;
  for (int i = 0; i < cell.num_samples(); ++i) {
    const PlainCell::Sample& sample = plain.samples[static_cast<std::size_t>(i)];
    ASSERT_LT((cell.point(i) - sample.p_m).norm(), 1e-6);
    if (!sample.close) {
      ASSERT_EQ(cell.contains(i), sample.in) << sample.p_m.transpose();
    }
    num_in += cell.contains(i);
  }
  ASSERT_EQ(cell.num_partitioned(), num_in);
  ASSERT_EQ(cell.is_empty(), num_in == 0);
  if (!plain.is_clear()) return;

  const Vector3 wanted_m = draws.vector(1.5 * plain.radius_m);
  double least_m = std::numeric_limits<double>::infinity();
  for (const PlainCell::Sample& s : plain.samples) {
    if (!s.in) continue;
    least_m = std::min(least_m, (s.p_m - wanted_m).norm());
  }
  const int nearest = cell.nearest_partitioned(wanted_m);
  ASSERT_EQ(nearest < 0, num_in == 0);
  if (num_in > 0) {
    ASSERT_TRUE(cell.contains(nearest));
    ASSERT_NEAR((cell.point(nearest) - wanted_m).norm(), least_m, 1e-6);
  }
  for (const double beta_m : {0.3, 1.5, 20.0}) {
    const Vector3 destination_m = draws.vector(3.0 * plain.radius_m);
    const CellCentroids centroids = cell.centroids(destination_m, beta_m);
    ASSERT_LT((centroids.sensing_agent_m - plain.centroid(destination_m, beta_m, true)).norm(), 2e-5);
    ASSERT_LT((centroids.partitioned_agent_m - plain.centroid(destination_m, beta_m, false)).norm(), 2e-5);
    ASSERT_LT((cell.partitioned_centroid(destination_m, beta_m) - plain.centroid(destination_m, beta_m, false)).norm(),
              2e-5);
  }
  // A vanishing beta leaves the nearest one alone.
  if (num_in == 0) return;
  const Vector3 tended_m = cell.point(cell.nearest_partitioned(wanted_m));
  ASSERT_LT((cell.partitioned_centroid(wanted_m, 1e-4) - tended_m).norm(), 1e-6);
}

TEST(RblCell, HoldsTheSamplesThatCutsLeave) {
  int empty = 0;
  for (std::uint32_t round = 0; round < 300; ++round) {
    Draws draws("test.rbl-cell", 1, round);
    const bool planar = draws.below(3) == 0;
    const double radius_m = draws.between(0.9, 3.6), step_m = radius_m / draws.between(3.0, planar ? 16.0 : 8.0);
    RblCell cell(radius_m, step_m, planar);
    // Used before: nothing of that is left.
    cell.reset(draws.vector(9.0), -radius_m, 0.3 * radius_m);
    cell.cut({Vector3::UnitX(), 0.0});
    const Vector3 lattice_m = draws.coin() ? Vector3(Vector3::Zero()) : draws.vector(7.0);
    double z_low_m = draws.between(-1.2, 0.2) * radius_m, z_high_m = draws.between(0.0, 1.2) * radius_m;
    if (round % 10 == 0) {  // aligned with layers of the lattice
      z_low_m = -2.0 * step_m;
      z_high_m = step_m;
    }
    cell.reset(lattice_m, z_low_m, z_high_m);
    PlainCell plain(radius_m, step_m, planar, lattice_m, z_low_m, z_high_m);
    if (draws.below(4) == 0) {
      ASSERT_NO_FATAL_FAILURE(compare(cell, plain, draws)) << round;
    }
    const int num_cuts = 1 + draws.below(5);
    for (int i = 0; i < num_cuts; ++i) {
      Vector3 normal = draws.vector(1.0);
      if (draws.below(6) == 0) normal.x() = 0.0;  // parallel to the rows
      const HalfSpace half{normal.normalized(), draws.between(-0.3, 1.1) * radius_m};
      cell.cut(half);
      plain.keep([&](const Vector3& q) { return half.normal_local.dot(q) - half.offset_m; });
      if (draws.below(4) == 0) {
        ASSERT_NO_FATAL_FAILURE(compare(cell, plain, draws)) << round << ", cut " << i;
      }
    }
    ASSERT_NO_FATAL_FAILURE(compare(cell, plain, draws)) << round;
    empty += cell.is_empty();
  }
  EXPECT_GT(empty, 20);
}

TEST(RblCell, CountsSamplesOnItsBorders) {
  RblCell cell(2.5, 0.5, false);
  PlainCell plain(2.5, 0.5, false, Vector3::Zero(), -2.5, 2.5);
  ASSERT_EQ(cell.num_samples(), static_cast<int>(plain.samples.size()));
  // (1.5, 2, 0) and its like lie on the sphere.
  const auto on_sphere = [](const PlainCell::Sample& s) { return std::abs(s.p_m.norm() - 2.5) < 1e-9; };
  EXPECT_EQ(std::count_if(plain.samples.begin(), plain.samples.end(), on_sphere), 30);
  for (const Vector3& normal : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, -1)}) {
    for (const double offset_m : {-1.0, 0.0, 0.5, 2.5, 2.6}) {
      cell.reset(Vector3::Zero(), -2.5, 2.5);
      cell.cut({normal, offset_m});
      for (int i = 0; i < cell.num_samples(); ++i) {
        ASSERT_EQ(cell.contains(i), normal.dot(cell.point(i)) <= offset_m) << normal.transpose() << " " << offset_m;
      }
    }
  }
}

TEST(RblCell, FindsTheNearestLeastViolatingSample) {
  for (std::uint32_t round = 0; round < 60; ++round) {
    Draws draws("test.rbl-cell", 2, round);
    RblCell cell(2.0, 0.31, draws.coin());
    cell.reset(draws.vector(1.0), -2.0, 2.0);
    std::vector<HalfSpace> cuts;
    const int count = 1 + draws.below(5);
    for (int i = 0; i < count; ++i) cuts.push_back({draws.vector(1.0).normalized(), draws.between(-1.0, 0.5)});
    const auto cost_m = [&](const Vector3& q) {
      double violation_m = 0.0;
      for (const HalfSpace& cut : cuts) violation_m = std::max(violation_m, cut.normal_local.dot(q) - cut.offset_m);
      return violation_m + 1e-6 * q.norm();
    };
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < cell.num_samples(); ++i) least = std::min(least, cost_m(cell.point(i)));
    EXPECT_NEAR(cost_m(cell.least_violating(cuts)), least, 1e-9);
  }
}

}  // namespace
}  // namespace swiftlet
