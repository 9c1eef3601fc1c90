// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/core/detection/vofod_stages.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;

/// Points that were measured from a place, without rays.
LocalCloud cloud_from(const Vector3& sensor_m, const std::vector<Eigen::Vector3f>& points_m) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = static_cast<int>(points_m.size());
  beams->column_offset_s.assign(beams->cols, 0.0F);
  beams->directions_lidar.assign(beams->size(), Eigen::Vector3f::UnitX());
  beams->origins_lidar.assign(beams->size(), Eigen::Vector3f::Zero());
  auto scan = std::make_shared<Scan>();
  scan->beams = beams;
  scan->range_m.assign(beams->size(), 3.0F);
  LocalCloud cloud;
  cloud.scan = scan;
  cloud.T_local_lidar.assign(beams->cols, pose_at(sensor_m));
  cloud.points_local_m = points_m;
  for (std::uint32_t i = 0; i < points_m.size(); ++i) cloud.beam.push_back(i);
  return cloud;
}

VofodConfig small_box() {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;
  config.map.center_m = {0.0, 0.0, 4.0};
  config.map.size_m = {10.0, 10.0, 8.0};
  return config;
}

/// A detector in whose map all air is known to be free.
class FreeAir {
 public:
  explicit FreeAir(const VofodConfig& config) : stages(config) {
    for (std::ptrdiff_t i = 0; i < stages.map().grid().num_cells(); ++i) {
      stages.map().set(i, static_cast<float>(config.map.g_free));
    }
  }
  std::vector<Detection> see(const std::vector<Eigen::Vector3f>& points_m, const Vector3& sensor_m = {0, 0, 4}) {
    std::vector<Detection> detections;
    stages.classify(cloud_from(sensor_m, points_m), detections);
    return detections;
  }
  void set(const Cell& cell, double G) { stages.map().set(stages.map().grid().index(cell), static_cast<float>(G)); }
  double G(const Cell& cell) const { return stages.map().value(stages.map().grid().index(cell)); }
  Cell cell_of(const Eigen::Vector3f& p_m) const { return stages.map().grid().cell_of(p_m.cast<double>()); }

  VofodStages stages;
};

const std::vector<Eigen::Vector3f> kInOneVoxel = {{1.1F, 1.1F, 3.1F}, {1.15F, 1.1F, 3.1F}, {1.1F, 1.15F, 3.15F}};

TEST(VofodConfidence, IsCertainInFreeAirAndFallsWithEveryVoxelWithinTheMarginThatIsNot) {
  FreeAir clear(small_box());
  ASSERT_EQ(clear.see(kInOneVoxel).size(), 1u);
  EXPECT_NEAR(FreeAir(small_box()).see(kInOneVoxel)[0].confidence, 1.0, 1e-6);
  const Cell own = clear.cell_of(kInOneVoxel[0]);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int away : {-3, -2, -1, 1, 2, 3}) {
      FreeAir air(small_box());
      Cell cell = own;
      cell[axis] += away;
      air.set(cell, -800.0);  // free still, so that the search passes
      const auto found = air.see(kInOneVoxel);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_NEAR(found[0].confidence, std::abs(away) <= 2 ? std::exp(-0.2) : 1.0, 1e-6) << axis << " " << away;
    }
  }
}

TEST(VofodConfidence, CornersOfTheBoxCountAndItIsSharedByTheOwnVoxels) {
  FreeAir air(small_box());
  const Cell own = air.cell_of(kInOneVoxel[0]);
  for (const int x : {-2, 2}) {
    for (const int y : {-2, 2}) {
      for (const int z : {-2, 2}) air.set(own + Cell(x, y, z), -900.0);
    }
  }
  EXPECT_NEAR(air.see(kInOneVoxel)[0].confidence, std::exp(-0.8), 1e-6);
  // Two voxels along x: the same doubt is shared by both.
  FreeAir two(small_box());
  two.set(own + Cell(3, 0, 0), -800.0);
  two.set(own, -900.0);  // its own voxels count as free
  std::vector<Eigen::Vector3f> points = kInOneVoxel;
  points.emplace_back(1.35F, 1.1F, 3.1F);
  EXPECT_NEAR(two.see(points)[0].confidence, std::exp(-0.1), 1e-6);
}

TEST(VofodConfidence, AtTheEdgeOfTheMapWhatLiesInsideCounts) {
  VofodConfig config = small_box();
  config.search_distance_m = 0.5;
  for (const float height_m : {0.1F, 7.9F}) {
    FreeAir air(config);
    const auto found = air.see({{1.1F, 1.1F, height_m}, {1.15F, 1.1F, height_m}});
    for (const Detection& d : found) EXPECT_NEAR(d.confidence, 1.0, 1e-6);
  }
}

TEST(VofodInterpretations, PositionIsTheCentroidOrTheBoxsCenter) {
  const std::vector<Eigen::Vector3f> points = {{1.0F, 1.0F, 3.0F}, {1.0F, 1.0F, 3.0F}, {1.4F, 1.2F, 3.2F}};
  VofodConfig config = small_box();
  EXPECT_LT((FreeAir(config).see(points)[0].position_m - Vector3(3.4 / 3.0, 3.2 / 3.0, 9.2 / 3.0)).norm(), 1e-6);
  config.choices.position = VofodChoices::Position::kBoxCenter;
  EXPECT_LT((FreeAir(config).see(points)[0].position_m - Vector3(1.2, 1.1, 3.1)).norm(), 1e-6);
  EXPECT_NEAR(FreeAir(config).see(points)[0].extent_m.norm(), std::sqrt(0.24), 1e-6) << "along its own axes";
}

TEST(VofodInterpretations, LimitsOfPointsSizeAndRange) {
  VofodConfig config = small_box();
  config.min_points = 3;
  config.max_size_m = 0.5;
  config.max_range_m = 2.0;
  const auto count = [&](const std::vector<Eigen::Vector3f>& points_m, const Vector3& from_m) {
    return FreeAir(config).see(points_m, from_m).size();
  };
  const Vector3 near_m = {1.1, 1.1, 4.9}, far_m = {1.1, 1.1, 5.3};
  EXPECT_EQ(count(kInOneVoxel, near_m), 1u);
  EXPECT_EQ(count({kInOneVoxel[0], kInOneVoxel[1]}, near_m), 0u) << "two points";
  EXPECT_EQ(count(kInOneVoxel, far_m), 0u) << "2.2 m away";
  EXPECT_EQ(count({{1.1F, 1.1F, 3.1F}, {1.3F, 1.1F, 3.1F}, {1.58F, 1.1F, 3.1F}}, near_m), 1u) << "0.48 m";
  EXPECT_EQ(count({{1.1F, 1.1F, 3.1F}, {1.3F, 1.1F, 3.1F}, {1.62F, 1.1F, 3.1F}}, near_m), 0u) << "0.52 m";
  config.max_range_m = 0.0;
  EXPECT_EQ(count(kInOneVoxel, far_m), 1u) << "no limit";
}

// Unknown air leads out of a search when it reaches its border: 8 voxels away (the paper), or after about as many steps
// (the released code). A staircase of 8 steps ends 5 voxels away.
TEST(VofodInterpretations, SearchesASphereOrAnOctahedron) {
  for (const auto search : {VofodChoices::Search::kSphere, VofodChoices::Search::kOctahedron}) {
    VofodConfig config = small_box();
    config.search_distance_m = 2.0;
    config.choices.search = search;
    FreeAir staircase(config), straight(config);
    Cell cell = staircase.cell_of(kInOneVoxel[0]), along = cell;
    staircase.set(cell, -740.0);
    straight.set(cell, -740.0);
    for (int step = 0; step < 8; ++step) {
      cell[step % 3] -= 1;
      along.x() -= 1;
      staircase.set(cell, -740.0);
      straight.set(along, -740.0);
    }
    EXPECT_EQ(staircase.see(kInOneVoxel).size(), search == VofodChoices::Search::kSphere ? 1u : 0u);
    EXPECT_EQ(straight.see(kInOneVoxel).size(), 0u);
  }
}

// A cluster of background with too little confidence is removed: its voxels alone (the paper), or all around them.
TEST(VofodInterpretations, SeparateBackgroundIsRemovedByTheClusterOrInTheSphere) {
  VofodConfig config = small_box();
  for (const auto reach : {VofodChoices::SeparateReach::kCluster, VofodChoices::SeparateReach::kSphere}) {
    for (const auto becomes : {VofodChoices::SeparateBecomes::kUnknown, VofodChoices::SeparateBecomes::kFree}) {
      config.choices.separate_reach = reach;
      config.choices.separate_becomes = becomes;
      FreeAir air(config);
      const VoxelGrid& grid = air.stages.map().grid();
      for (std::ptrdiff_t i = 0; i < grid.num_cells(); ++i) air.stages.map().set(i, -400.0F);
      const Cell a = air.cell_of({1.1F, 1.1F, 3.1F}), b = a + Cell(1, 0, 0);
      for (const Cell& cell : {a, b}) air.set(cell, -200.0);  // tentative
      air.stages.find_separate();
      air.stages.remove_separate(1);
      const double g = becomes == VofodChoices::SeparateBecomes::kFree ? -1000.0 : -740.0;
      const double reach_voxels =
          reach == VofodChoices::SeparateReach::kSphere ? config.separate_distance_m / config.map.voxel_m : 0.0;
      for (std::ptrdiff_t i = 0; i < grid.num_cells(); ++i) {
        const Cell cell = grid.cell(i);
        const double away = std::min((cell - a).cast<double>().norm(), (cell - b).cast<double>().norm());
        const bool own = away == 0.0;
        const double before = own ? -200.0 : -400.0;
        ASSERT_NEAR(air.stages.map().value(i), away <= reach_voxels ? 0.5 * (before + g) : before, 1e-3)
            << cell.transpose();
      }
      // It is done once, not again.
      const double after = air.G(a);
      air.stages.remove_separate(1);
      EXPECT_EQ(air.G(a), after);
    }
  }
}

// At d_sep exactly, which here is three edges of a voxel.
TEST(VofodInterpretations, SphereReachesToItsRadiusAndWithIt) {
  VofodConfig config = small_box();
  config.separate_distance_m = 0.75;
  config.choices.separate_reach = VofodChoices::SeparateReach::kSphere;
  for (const Cell& way : {Cell(1, 0, 0), Cell(0, -1, 0), Cell(0, 0, 1)}) {
    FreeAir air(config);
    const Cell middle = air.cell_of({1.1F, 1.1F, 3.1F});
    air.set(middle, -200.0);
    air.stages.find_separate();
    air.stages.remove_separate(1);
    EXPECT_GT(air.G(middle + 3 * way), -999.0);
    EXPECT_EQ(air.G(middle + 4 * way), -1000.0);
  }
}

TEST(VofodInterpretations, SphereEndsAtTheMapsBorder) {
  VofodConfig config = small_box();
  config.choices.separate_reach = VofodChoices::SeparateReach::kSphere;
  FreeAir air(config);
  const VoxelGrid& grid = air.stages.map().grid();
  const Cell last = grid.min_cell + grid.size - Cell::Ones();
  for (const Cell& corner : {grid.min_cell, last}) air.set(corner, -200.0);
  air.stages.find_separate();
  air.stages.remove_separate(1);
  EXPECT_GT(air.G(grid.min_cell + Cell(2, 0, 0)), -999.0);
  EXPECT_GT(air.G(last - Cell(0, 0, 2)), -999.0);
  EXPECT_EQ(air.G(grid.min_cell + Cell(3, 0, 0)), -1000.0);
}

TEST(VofodInterpretations, RaysMayEndAVoxelBeforeTheirPoint) {
  for (const auto end : {VofodChoices::RayEnd::kPoint, VofodChoices::RayEnd::kVoxelBefore}) {
    VofodConfig config = small_box();
    config.choices.ray_end = end;
    config.ray_weight = 1.0;
    VofodStages stages(config);
    auto beams = std::make_shared<BeamTable>(*make_beams(1, 4, 0.1, -0.1));
    for (int i = 0; i < 4; ++i) beams->directions_lidar[i] = Eigen::Vector3f::UnitX();
    auto scan = std::make_shared<Scan>(*scan_world(ground(), pose_at({0.125, 0.125, 4.125}), beams, 0));
    scan->range_m.assign(4, 2.0F);
    stages.cast_rays(*cloud_of(scan));
    stages.apply_rays(1);
    const auto passed = [&](double x_m) {
      return stages.map().value_at(stages.map().grid().cell_of({x_m, 0.125, 4.125})) < -741.0F;
    };
    EXPECT_TRUE(passed(1.625));
    EXPECT_EQ(passed(2.01), end == VofodChoices::RayEnd::kPoint);
    EXPECT_FALSE(passed(2.375));
  }
}

}  // namespace
}  // namespace swiftlet
