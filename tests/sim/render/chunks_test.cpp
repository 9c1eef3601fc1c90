// SPDX-License-Identifier: BSD-3-Clause
// Meshes made ready for drawing: normals, leaves, chunks and their order, each computed by looking at every triangle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/render/picture_scene.hpp"
#include "sim/render/render_mesh.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/render/render_config.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3f;

Vector3f packed_normal(const RenderVertex& v) {
  return Vector3f(v.normal_open[0], v.normal_open[1], v.normal_open[2]) / 127.0F;
}

/// Two squares that meet at an angle along the y axis.
Mesh roof(double turn_deg) {
  const auto c = static_cast<float>(std::cos(turn_deg * M_PI / 180.0)),
             s = static_cast<float>(std::sin(turn_deg * M_PI / 180.0));
  Mesh mesh;
  add_quad(mesh, {-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0});
  add_quad(mesh, {0, 0, 0}, {c, 0, -s}, {c, 1, -s}, {0, 1, 0});
  return mesh;
}

// 42 degrees: flatter edges look round, sharper ones are edges.
TEST(RenderMesh, SmoothsEdgesUpTo42Degrees) {
  for (const double turn_deg : {10.0, 41.0, 43.5, 80.0}) {
    const RenderMesh ready = prepare_mesh(roof(turn_deg));
    const bool smooth = turn_deg < 42.0;
    EXPECT_EQ(ready.vertices.size(), smooth ? 6U : 8U) << turn_deg;
    for (const RenderVertex& v : ready.vertices) {
      EXPECT_EQ(v.normal_open[3], 127) << "open to the sky";
      EXPECT_EQ(v.leaf_offset, (std::array<std::int16_t, 4>{}));
      if (std::abs(v.position_m[0]) > 0.01F || !smooth) continue;
      // On the ridge the mean of both normals, weighted by their areas at the corners.
      const double half = 0.5 * turn_deg * M_PI / 180.0;
      EXPECT_NEAR(std::atan2(packed_normal(v).x(), packed_normal(v).z()), half, 0.4 * half);
    }
  }
}

TEST(RenderMesh, MergesCornersOfEqualNormals) {
  Mesh twice;
  add_quad(twice, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  add_quad(twice, {1, 0, 0}, {2, 0, -0.0F}, {2, 1, 0}, {1, 1, -0.0F});  // -0 is 0
  EXPECT_EQ(prepare_mesh(twice).vertices.size(), 6U);
  Mesh flat;
  flat.vertices_mesh_m = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.triangles = {{0, 1, 2}};  // has no normal: up
  for (const RenderVertex& v : prepare_mesh(flat).vertices) EXPECT_EQ(packed_normal(v), Vector3f::UnitZ());
  EXPECT_TRUE(prepare_mesh(Mesh()).chunks.empty());
}

// Any first part of a chunk is spread over all of it.
TEST(RenderMesh, LeavesOfAChunkAreShuffled) {
  Mesh row;
  row.surface_class = SurfaceClass::kVegetation;
  for (int i = 0; i < 1000; ++i) {
    const auto x = 0.01F * static_cast<float>(i);
    add_triangle(row, {x, 0, 0}, {x + 0.005F, 0, 0}, {x, 0.005F, 0});
  }
  const RenderMesh ready = prepare_mesh(row);
  ASSERT_EQ(ready.chunks.size(), 1U);
  std::set<int> numbers;
  double sum_m = 0.0;
  for (std::size_t i = 0; i < 300; i += 3) {
    const float x =
        std::min({ready.vertices[ready.indices[i]].position_m[0], ready.vertices[ready.indices[i + 1]].position_m[0],
                  ready.vertices[ready.indices[i + 2]].position_m[0]});
    numbers.insert(static_cast<int>(std::lround(100.0F * x)));
    sum_m += x;
  }
  EXPECT_EQ(numbers.size(), 100U);
  EXPECT_NEAR(sum_m / 100.0, 5.0, 5.0 * 10.0 / std::sqrt(1200.0));
  EXPECT_LT(*numbers.begin(), 60);
  EXPECT_GT(*numbers.rbegin(), 940);
  EXPECT_EQ(prepare_mesh(row).indices, ready.indices) << "the same for the same mesh";
}

// ---- What changes between two pictures.

TEST(PictureScene, MatchesOverlayNamesWithOptionalVehicle) {
  const auto chosen = [](const std::string& name, std::vector<std::string> names) {
    Overlay overlay;
    overlay.name = name;
    return is_chosen(overlay, names);
  };
  EXPECT_TRUE(chosen("uav1/path", {"path"}));
  EXPECT_TRUE(chosen("uav1/path", {"other", "uav1/path"}));
  EXPECT_TRUE(chosen("uav1/path", {"*"}));
  EXPECT_TRUE(chosen("path", {"path"}));
  EXPECT_FALSE(chosen("uav1/path", {"uav2/path"}));
  EXPECT_FALSE(chosen("uav1/path", {"uav1"}));
  EXPECT_FALSE(chosen("uav1/path", {}));
}

// When it has grown to eight thousand, every other point of its older half goes.
TEST(PictureScene, ThinsOlderHalvesOfLongTrails) {
  std::vector<Eigen::Vector3f> trail;
  int count = 0;
  while (count < 8191) extend_trail(trail, {static_cast<float>(count++), 0, 0});
  EXPECT_EQ(trail.size(), 8191U);
  extend_trail(trail, {static_cast<float>(count++), 0, 0});
  ASSERT_EQ(trail.size(), 8192U - 2048U);
  for (std::size_t i = 0; i < trail.size(); ++i)
    EXPECT_EQ(trail[i].x(), i < 2048 ? 2.0F * static_cast<float>(i) : 2048.0F + static_cast<float>(i)) << i;
}

TEST(PictureScene, KeepsClassAndReflectivityOfReturns) {
  LabeledScan labeled;
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 2;
  beams->cols = 3;
  beams->directions_lidar.assign(6, Eigen::Vector3f::UnitX());
  beams->origins_lidar.assign(6, Eigen::Vector3f::Zero());
  labeled.scan.beams = beams;
  labeled.scan.range_m = {1, 0, 3, 4, 5, 0};
  labeled.scan.reflectivity = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};
  labeled.truth.surface_class = {10, 11, 12, 13, 14, 15};
  EXPECT_TRUE(cloud_of(labeled, 2).points_world_m.empty()) << "nobody knows where it was";
  for (int column = 0; column < 3; ++column)
    labeled.truth.T_world_lidar.push_back(make_pose({100.0 * column, 0, 0}, Eigen::Quaterniond::Identity()));
  const PictureCloud rolling = cloud_of(labeled, 2);
  EXPECT_EQ(rolling.vehicle, 2);
  EXPECT_EQ(rolling.points_world_m, (std::vector<Eigen::Vector3f>{{1, 0, 0}, {203, 0, 0}, {4, 0, 0}, {105, 0, 0}}));
  EXPECT_EQ(rolling.surface_class, (std::vector<std::uint16_t>{10, 12, 13, 14}));
  EXPECT_EQ(rolling.intensity, (std::vector<float>{0.1F, 0.3F, 0.4F, 0.5F}));
  labeled.truth.T_world_lidar.resize(1);
  labeled.scan.reflectivity.clear();
  labeled.truth.surface_class.pop_back();
  const PictureCloud frozen = cloud_of(labeled, 2);
  EXPECT_EQ(frozen.points_world_m[1], Eigen::Vector3f(3, 0, 0));
  EXPECT_TRUE(frozen.intensity.empty() && frozen.surface_class.empty());
}

TEST(CameraConfig, IsDueAtPeriodMultiples) {
  CameraConfig camera;
  camera.every_s = 0.5;
  EXPECT_TRUE(camera.is_due(-1, 0));
  EXPECT_FALSE(camera.is_due(0, 0));
  EXPECT_FALSE(camera.is_due(0, 499'999'999));
  EXPECT_TRUE(camera.is_due(0, 500'000'000));
  EXPECT_TRUE(camera.is_due(499'999'999, 500'000'001));
  EXPECT_FALSE(camera.is_due(500'000'000, 500'000'001));
  EXPECT_FALSE(camera.is_due(-2, -1));
  camera.every_s = 0.0;
  EXPECT_FALSE(camera.is_due(-1, 0));
  camera.times_s = {1.0};
  EXPECT_TRUE(camera.is_due(999'999'999, 1'000'000'000));
  EXPECT_FALSE(camera.is_due(1'000'000'000, 1'000'000'001));
  EXPECT_FALSE(camera.is_due(0, 999'999'999));
  EXPECT_FALSE(wants_picture(std::vector<CameraConfig>{}, -1, 0));
  EXPECT_TRUE(wants_picture(std::vector<CameraConfig>{CameraConfig(), camera}, 0, 1'000'000'000));
}

TEST(CameraConfig, ConvertsPaperMillimetersToPixels) {
  CameraConfig camera;
  camera.style = PictureMedium::kPaper;
  camera.dpi = 254.0;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(1280, 720)) << "none are given";
  camera.width_mm = 80.06;
  camera.height_mm = 30.0;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(801, 300));
  camera.height_mm = 0.0;
  camera.width_px = 400, camera.height_px = 100;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(801, 200));
  camera.width_mm = 0.0;
  camera.height_mm = 20.0;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(800, 200));
  camera.height_mm = 1e300;
  EXPECT_EQ(camera.size_px().y(), 1000000) << "no overflow";
}

}  // namespace
}  // namespace swiftlet::sim
