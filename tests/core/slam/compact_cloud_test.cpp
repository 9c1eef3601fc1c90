// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/compact_cloud.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <tuple>
#include <utility>

#include "core/slam/sharing/submap_look.hpp"
#include "tests/core/slam/shared_yard.hpp"

namespace swiftlet {
namespace {

std::vector<Eigen::Vector3f> cloud_of_yard_m(const Pose& T_world_submap) {
  testing::YardFlight path(testing::shared_yard_m(), Pose::Identity());
  path.begin_submap(T_world_submap);
  return {path.points_submap_m(0).begin(), path.points_submap_m(0).end()};
}

TEST(CompactCloud, RestoresPointsToHalfAStep) {
  const std::vector<Eigen::Vector3f> cloud_m = cloud_of_yard_m(testing::level_at(8, 0, 2, 0.4));
  const double voxel_m = 0.5;
  for (const int bits : {3, 5}) {
    const std::vector<PackedPoints> parts = pack_points(cloud_m, voxel_m, bits, 700);
    std::vector<Eigen::Vector3f> read_m;
    std::size_t num_bytes = 0;
    for (const PackedPoints& part : parts) {
      EXPECT_LE(part.data.size(), 700U);
      num_bytes += part.data.size();
      ASSERT_TRUE(unpack_points(part.data, part.num_points, voxel_m, bits, read_m));
    }
    // A point in each voxel, the first one, and no voxel twice.
    std::map<std::tuple<int, int, int>, Eigen::Vector3f> first;
    const auto voxel_of = [&](const Eigen::Vector3f& p) {
      const Vector3 at = (p.cast<double>() / voxel_m).array().floor();
      return std::tuple(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z()));
    };
    for (const Eigen::Vector3f& p : cloud_m) first.try_emplace(voxel_of(p), p);
    ASSERT_EQ(read_m.size(), first.size());
    const double half_step_m = 0.5 * voxel_m / (1 << bits);
    for (const Eigen::Vector3f& p : read_m) {
      const auto found = first.find(voxel_of(p));
      ASSERT_NE(found, first.end());
      EXPECT_LE((found->second - p).cwiseAbs().maxCoeff(), half_step_m + 1e-5);
      first.erase(found);
    }
    const double bits_of_point = 8.0 * static_cast<double>(num_bytes) / static_cast<double>(read_m.size());
    EXPECT_LT(bits_of_point, 3.0 * bits + 8.0) << "a plain code of 256 voxels takes 24 more";
  }
}

// A wall 15 m long, in any direction, keeps its share of columns: with 25 to 30 columns and one in four selected at
// random, fewer than two are left of one wall in 200.
TEST(CompactCloud, ThinsWallsOfAllDirectionsAlike) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  for (const int one_in : {2, 3, 4}) {
    int num_bare = 0;
    double share = 0.0;
    constexpr int kWalls = 600;
    for (int wall = 0; wall < kWalls; ++wall) {
      const float heading = 3.1416F * uniform(random), x_m = 10.0F * uniform(random), y_m = 10.0F * uniform(random);
      std::vector<Eigen::Vector3f> points_m;
      std::map<std::pair<int, int>, int> columns, kept;  // number of points
      const auto column_of = [](const Eigen::Vector3f& p) {
        return std::pair(static_cast<int>(std::floor(p.x() / 0.5F)), static_cast<int>(std::floor(p.y() / 0.5F)));
      };
      for (int i = 0; i < 60; ++i) {
        for (int level = 0; level < 8; ++level) {
          const float along_m = 0.25F * static_cast<float>(i) - 7.5F;
          points_m.emplace_back(x_m + along_m * std::cos(heading), y_m + along_m * std::sin(heading),
                                0.5F * static_cast<float>(level) + 0.3F);
          ++columns[column_of(points_m.back())];
        }
      }
      CompactCloudConfig config;
      config.flat_voxel_m = 1000.0;  // a point more in each quadrant
      config.upright_points = static_cast<int>(8 * columns.size()) / one_in + 1;
      for (const Eigen::Vector3f& p : points_to_share_m(points_m, config, 60.0)) ++kept[column_of(p)];
      const auto full = std::ranges::count_if(kept, [](const auto& column) { return column.second >= 8; });
      num_bare += full < 2 ? 1 : 0;
      share += static_cast<double>(full) / static_cast<double>(columns.size()) / kWalls;
    }
    EXPECT_LT(num_bare, kWalls / 100) << "one in " << one_in;
    EXPECT_NEAR(share, 1.0 / one_in, 0.05) << "one in " << one_in;
  }
}

TEST(CompactCloud, DropsPointsBeyondTheOctree) {
  const std::vector<Eigen::Vector3f> cloud_m = {{63.9F, -63.9F, 0.0F}, {64.1F, 0.0F, 0.0F}, {0.0F, -64.1F, 0.0F}};
  const std::vector<PackedPoints> parts = pack_points(cloud_m, 0.5, 5, 1000);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].num_points, 1);
}

TEST(CompactCloud, DecodesOrRefusesArbitraryBytes) {
  const std::vector<PackedPoints> parts = pack_points(cloud_of_yard_m(testing::level_at(8, 0, 2, 0.0)), 0.5, 5, 300);
  std::mt19937 random(3);
  int refused = 0;
  for (int i = 0; i < 5000; ++i) {
    PackedPoints part = parts[static_cast<std::size_t>(i) % parts.size()];
    const int num_points = i % 3 == 0 ? part.num_points + 1 : part.num_points;
    if (i % 3 == 1) part.data.resize(random() % part.data.size());
    if (i % 3 == 2) part.data[random() % part.data.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    std::vector<Eigen::Vector3f> read_m = {{1.0F, 2.0F, 3.0F}};
    const bool done = unpack_points(part.data, num_points, 0.5, 5, read_m);
    refused += !done;
    ASSERT_EQ(read_m.size(), done ? 1U + static_cast<std::size_t>(num_points) : 1U);
    for (const Eigen::Vector3f& p : read_m) ASSERT_LE(p.cwiseAbs().maxCoeff(), 64.0F);
    if (i % 3 != 2) {
      ASSERT_FALSE(done) << "another number of points, or fewer bytes";
    }
  }
  EXPECT_GT(refused, 3300);
  std::vector<Eigen::Vector3f> read_m;
  EXPECT_FALSE(unpack_points({}, 0, 0.5, 5, read_m));
  EXPECT_FALSE(unpack_points(parts[0].data, parts[0].num_points, 0.5, 0, read_m));
  EXPECT_FALSE(unpack_points(parts[0].data, parts[0].num_points, 0.5, 11, read_m));
}

TEST(SubmapLook, DependsOnPlaceNotHeading) {
  const auto look_at = [](double x_m, double yaw_rad) {
    return look_of(cloud_of_yard_m(testing::level_at(x_m, 0, 2, yaw_rad)), 0.5, 25.0);
  };
  const SubmapLook here = look_at(2, 0.0);
  for (const double yaw_rad : {0.7, 1.9, -2.6}) EXPECT_GT(likeness(here, look_at(2, yaw_rad)), 0.93) << yaw_rad;
  EXPECT_GT(likeness(here, here), 0.999);
  EXPECT_LT(likeness(here, look_at(36, 0.0)), 0.9) << "walls in other directions, of other heights";
}

TEST(SubmapLook, SurvivesQuantization) {
  const SubmapLook look = look_of(cloud_of_yard_m(testing::level_at(2, 0, 2, 0.3)), 0.5, 25.0);
  const std::vector<std::uint8_t> directions = look.directions.quantized();
  const std::optional<SubmapLook> decoded = SubmapLook::from_quantized(directions, look.heights);
  ASSERT_TRUE(decoded);
  EXPECT_GT(likeness(look, *decoded), 0.999);
  EXPECT_FALSE(SubmapLook::from_quantized(std::span(directions).first(119), look.heights));
  EXPECT_FALSE(SubmapLook::from_quantized(directions, std::span(look.heights).first(3)));
}

}  // namespace
}  // namespace swiftlet
