// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/compact_cloud.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <span>
#include <tuple>

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

/// Number of columns that have most of their points, of a wall 30 m long and eight voxels high across the x or y axis.
int num_full_columns(std::span<const Eigen::Vector3f> points_m, int axis, float at_m) {
  std::map<int, int> num_points;
  for (const Eigen::Vector3f& p : points_m) {
    if (p[axis] == at_m) ++num_points[static_cast<int>(std::floor(p[1 - axis] / 0.5F))];
  }
  return static_cast<int>(std::ranges::count_if(num_points, [](const auto& column) { return column.second >= 6; }));
}

TEST(CompactCloud, ThinsEveryWallAlike) {
  const std::vector<float> places_m = {-20.25F, 20.75F, -17.75F, 17.25F};  // in odd and even voxels
  for (std::size_t num_places = 2; num_places <= places_m.size(); ++num_places) {
    std::vector<Eigen::Vector3f> points_m;
    for (std::size_t i = 0; i < num_places; ++i) {
      for (int column = -30; column < 30; ++column) {
        for (int level = 0; level < 8; ++level) {
          const float along_m = 0.5F * static_cast<float>(column) + 0.3F, z_m = 0.5F * static_cast<float>(level) + 0.3F;
          points_m.emplace_back(places_m[i], along_m, z_m);
          points_m.emplace_back(along_m, places_m[i], z_m);
        }
      }
    }
    const std::vector<Eigen::Vector3f> shared_m = points_to_share_m(points_m, {}, 60.0);
    const double expected = 60.0 / static_cast<double>(num_places);  // 960 points a place, of which 1200 may stay
    for (std::size_t i = 0; i < num_places; ++i) {
      for (const int axis : {0, 1}) {
        const int found = num_full_columns(shared_m, axis, places_m[i]);
        EXPECT_GT(found, 0.5 * expected) << places_m[i] << " m along axis " << axis << ", one in " << num_places;
        EXPECT_LT(found, 2.0 * expected) << places_m[i] << " m along axis " << axis << ", one in " << num_places;
      }
    }
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
