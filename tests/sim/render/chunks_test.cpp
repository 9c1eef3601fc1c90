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

Vector3f place_of(const RenderVertex& v) { return Vector3f(v.position_m.data()); }
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
TEST(RenderMesh, SmoothsEdgesUpToFortyTwoDegrees) {
  for (const double turn_deg : {10.0, 41.0, 43.5, 80.0}) {
    const RenderMesh ready = prepare_mesh(roof(turn_deg));
    const bool smooth = turn_deg < 42.0;
    EXPECT_EQ(ready.vertices.size(), smooth ? 6U : 8U) << turn_deg;
    for (const RenderVertex& v : ready.vertices) {
      EXPECT_EQ(v.normal_open[3], 127) << "open to the sky";
      EXPECT_EQ(v.leaf_offset, (std::array<std::int16_t, 4>{}));
      if (std::abs(v.position_m[0]) > 0.01F || !smooth) continue;
      // On the ridge the mean of both, by their areas as the corners have them.
      const double half = 0.5 * turn_deg * M_PI / 180.0;
      EXPECT_NEAR(std::atan2(packed_normal(v).x(), packed_normal(v).z()), half, 0.4 * half);
    }
  }
}

TEST(RenderMesh, NormalsAreTheSumOfTheTrianglesAroundWithinTheCrease) {
  Mesh mesh;
  const Random random(1, "test.normals");
  std::vector<float> heights;
  for (std::uint32_t i = 0; i < 100; ++i) heights.push_back(static_cast<float>(random.uniform(0.0, 1.5, i, 0)));
  add_heightfield(mesh, {0, 0}, {1, 1}, 10, 10, heights);
  const RenderMesh ready = prepare_mesh(mesh);
  const auto normal_of_face = [&](const std::array<std::uint32_t, 3>& t) -> Vector3f {
    const Vector3f& a = mesh.vertices_mesh_m[t[0]];
    return (mesh.vertices_mesh_m[t[1]] - a).cross(mesh.vertices_mesh_m[t[2]] - a);
  };
  std::size_t corners = 0;
  for (std::size_t i = 0; i < ready.indices.size(); i += 3) {
    const Vector3f a = place_of(ready.vertices[ready.indices[i]]), b = place_of(ready.vertices[ready.indices[i + 1]]),
                   c = place_of(ready.vertices[ready.indices[i + 2]]);
    const Vector3f own = (b - a).cross(c - a);
    for (std::size_t k = 0; k < 3; ++k, ++corners) {
      const RenderVertex& v = ready.vertices[ready.indices[i + k]];
      Vector3f sum = Vector3f::Zero();
      bool is_clear = true;
      for (const auto& t : mesh.triangles) {
        const bool touches =
            std::any_of(t.begin(), t.end(), [&](std::uint32_t n) { return mesh.vertices_mesh_m[n] == place_of(v); });
        if (!touches) continue;
        const Vector3f other = normal_of_face(t);
        const float cosine = other.normalized().dot(own.normalized());
        is_clear = is_clear && std::abs(cosine - 0.74F) > 1e-4F;
        if (cosine >= 0.74F) sum += other;
      }
      if (!is_clear) continue;
      EXPECT_LT((packed_normal(v) - sum.normalized()).cwiseAbs().maxCoeff(), 0.0051F) << "to half of a step";
    }
  }
  EXPECT_EQ(corners, 3 * mesh.triangles.size());
}

TEST(RenderMesh, CornersAtOnePlaceAreOneUnlessTheirNormalsDiffer) {
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

/// A crown of squares of one size, and a few solid triangles that hang together.
Mesh crown(int leaves, int solid_triangles, float spread_m, SurfaceClass surface_class = SurfaceClass::kVegetation) {
  Mesh mesh;
  mesh.surface_class = surface_class;
  const Random random(2, "test.crown");
  for (int i = 0; i < leaves; ++i) {
    const auto n = static_cast<std::uint32_t>(i);
    const auto draw = [&](std::uint32_t k) { return static_cast<float>(random.uniform(-0.5, 0.5, n, k)); };
    const Vector3f at(spread_m * draw(0), spread_m * draw(1), 4.0F * draw(2));
    const Vector3f u = 0.2F * Vector3f(1.0F, draw(3), draw(4)).normalized(),
                   w = 0.2F * u.cross(Vector3f(draw(5), draw(6), 1.0F)).normalized();
    add_quad(mesh, at - u, at - w, at + u, at + w);
  }
  if (solid_triangles > 0) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices_mesh_m.size());
    for (int i = 0; i <= solid_triangles + 1; ++i)
      mesh.vertices_mesh_m.emplace_back(0.1F * static_cast<float>(i), i % 2 == 0 ? 0.0F : 0.1F, 0.0F);
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(solid_triangles); ++i)
      mesh.triangles.push_back({first + i, first + i + 1, first + i + 2});
  }
  return mesh;
}

TEST(RenderMesh, IsLeavesWhenThreeQuartersOfItAreLoosePiecesOfUpToFourTriangles) {
  EXPECT_GT(prepare_mesh(crown(30, 20, 3.0F)).leaf_size_m, 0.0F) << "60 of 80 triangles";
  EXPECT_EQ(prepare_mesh(crown(30, 21, 3.0F)).leaf_size_m, 0.0F);
  EXPECT_GT(prepare_mesh(crown(0, 4, 3.0F)).leaf_size_m, 0.0F);
  EXPECT_EQ(prepare_mesh(crown(0, 5, 3.0F)).leaf_size_m, 0.0F);
  EXPECT_GT(prepare_mesh(crown(10, 0, 3.0F, SurfaceClass::kUndergrowth)).leaf_size_m, 0.0F);
  EXPECT_EQ(prepare_mesh(crown(10, 0, 3.0F, SurfaceClass::kTrunk)).leaf_size_m, 0.0F);
  EXPECT_EQ(prepare_mesh(crown(10, 0, 3.0F, SurfaceClass::kBranch)).leaf_size_m, 0.0F);
  // The root of the mean area of a leaf.
  EXPECT_NEAR(prepare_mesh(crown(40, 0, 3.0F)).leaf_size_m, std::sqrt(area_m2(crown(40, 0, 3.0F)) / 40.0), 1e-4);
}

TEST(RenderMesh, LeavesAreLitAsTheCrownIsRoundAndDarkerInside) {
  for (const float spread_m : {6.0F, 24.0F, 60.0F}) {
    const Mesh mesh = crown(400, 0, spread_m);
    const RenderMesh ready = prepare_mesh(mesh);
    const Eigen::AlignedBox3f box = bounds_m(mesh);
    const bool is_crown = box.sizes().head<2>().maxCoeff() < 25.0F;
    EXPECT_EQ(is_crown, spread_m < 30.0F);
    // Its middle is a little below that of the box.
    const Vector3f center = box.center() - Vector3f(0, 0, 0.15F * box.sizes().z()), half = 0.5F * box.sizes();
    ASSERT_EQ(ready.vertices.size(), 1600U);
    for (std::size_t leaf = 0; leaf < 400; ++leaf) {
      const Vector3f* corner = &mesh.vertices_mesh_m[4 * leaf];
      // Of two triangles, the diagonal counts twice.
      const Vector3f middle = (2.0F * corner[0] + corner[1] + 2.0F * corner[2] + corner[3]) / 6.0F;
      Vector3f normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
      if (normal.z() < 0.0F) normal = -normal;
      const Vector3f off = (middle - center).cwiseQuotient(half);
      const float open = is_crown ? std::clamp(0.25F + 0.6F * off.norm() + 0.15F * off.z(), 0.2F, 1.0F) : 0.8F;
      const Vector3f outward = is_crown ? Vector3f(off.cwiseQuotient(half).normalized()) : Vector3f::UnitZ();
      const Vector3f expected = (0.75F * outward + 0.45F * normal).normalized();
      for (std::size_t k = 0; k < 4; ++k) {
        const auto v = std::find_if(ready.vertices.begin(), ready.vertices.end(),
                                    [&](const RenderVertex& r) { return place_of(r) == corner[k]; });
        ASSERT_NE(v, ready.vertices.end());
        EXPECT_NEAR(v->normal_open[3] / 127.0F, open, 0.006F);
        EXPECT_LT((packed_normal(*v) - expected).cwiseAbs().maxCoeff(), 0.006F);
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(v->leaf_offset[c] * kLeafUnit_m, (corner[k] - middle)[c], 1.01F * kLeafUnit_m);
      }
      if (leaf > 60) break;
    }
  }
  // What is larger than the unit allows is cut, not wrapped around.
  Mesh large;
  large.surface_class = SurfaceClass::kVegetation;
  add_quad(large, {-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0});
  for (const RenderVertex& v : prepare_mesh(large).vertices) {
    EXPECT_EQ(std::abs(v.leaf_offset[0]), 32767);
    EXPECT_EQ(v.leaf_offset[0] > 0, v.position_m[0] > 0.0F);
  }
}

TEST(RenderMesh, ChunksHaveUpToFourThousandTrianglesInWholePiecesAndLieApart) {
  for (const int leaves : {2048, 2049, 6000}) {
    const RenderMesh ready = prepare_mesh(crown(leaves, 0, 8.0F));
    EXPECT_EQ(ready.chunks.size(), leaves <= 2048 ? 1U : leaves < 4096 ? 2U : 4U) << leaves;
    std::uint32_t next = 0;
    for (const RenderChunk& chunk : ready.chunks) {
      EXPECT_EQ(chunk.first_index, next);
      next += chunk.num_indices;
      EXPECT_EQ(chunk.num_indices % 6, 0U);
      EXPECT_LE(chunk.num_indices, 3U * 4096U);
      Eigen::AlignedBox3f box;
      for (std::uint32_t i = chunk.first_index; i < next; ++i) box.extend(place_of(ready.vertices[ready.indices[i]]));
      EXPECT_TRUE(box.isApprox(chunk.box_m));
    }
    EXPECT_EQ(next, ready.indices.size());
    // Cut across their longest side: half as long each.
    if (ready.chunks.size() == 2) {
      EXPECT_LT(std::min(ready.chunks[0].box_m.sizes().head<2>().minCoeff(),
                         ready.chunks[1].box_m.sizes().head<2>().minCoeff()),
                5.0F);
    }
  }
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

TEST(RenderMesh, BranchesOfAChunkComeByTheirLengthTheLongestFirst) {
  Mesh mesh;
  mesh.surface_class = SurfaceClass::kBranch;
  const Random random(3, "test.branches");
  double lengths_m = 0.0;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const auto draw = [&](std::uint32_t k) { return static_cast<float>(random.uniform(-1.0, 1.0, i, k)); };
    const Vector3f from(draw(0), draw(1), draw(2)),
        way = Vector3f(draw(3), draw(4), draw(5)).normalized() * (0.4F + 0.3F * draw(6));
    add_frustum(mesh, from, 0.01F, from + way, 0.01F, 6, Caps::kNone);
    lengths_m += way.norm();
  }
  const RenderMesh ready = prepare_mesh(mesh);
  ASSERT_EQ(ready.chunks.size(), 1U);
  float before = 1e9F;
  for (std::size_t branch = 0; branch < 60; ++branch) {
    Eigen::AlignedBox3f box;
    for (std::size_t i = 36 * branch; i < 36 * (branch + 1); ++i)
      box.extend(place_of(ready.vertices[ready.indices[i]]));
    EXPECT_LE(box.diagonal().norm(), before + 1e-6F);
    before = box.diagonal().norm();
  }
  // The area of a tube is pi times thickness times length.
  EXPECT_NEAR(ready.branch_thickness_m, 0.02, 0.003);
  EXPECT_EQ(prepare_mesh(crown(10, 0, 3.0F)).branch_thickness_m, 0.0F);
}

// ---- What changes between two pictures.

TEST(PictureScene, OverlaysAreChosenByTheirNameWithOrWithoutTheVehicle) {
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

TEST(PictureScene, TrailsTakeAPointEveryFiveCentimeters) {
  std::vector<Eigen::Vector3f> trail;
  for (int i = 0; i <= 1000; ++i) extend_trail(trail, {0.01F * static_cast<float>(i), 0, 0});
  ASSERT_GT(trail.size(), 150U);
  for (std::size_t i = 1; i < trail.size(); ++i) EXPECT_NEAR(trail[i].x() - trail[i - 1].x(), 0.05F, 0.0101F);
}

// When it has grown to eight thousand, every other point of its older half goes.
TEST(PictureScene, LongTrailsAreThinnedInTheirOlderHalf) {
  std::vector<Eigen::Vector3f> trail;
  int count = 0;
  while (count < 8191) extend_trail(trail, {static_cast<float>(count++), 0, 0});
  EXPECT_EQ(trail.size(), 8191U);
  extend_trail(trail, {static_cast<float>(count++), 0, 0});
  ASSERT_EQ(trail.size(), 8192U - 2048U);
  for (std::size_t i = 0; i < trail.size(); ++i)
    EXPECT_EQ(trail[i].x(), i < 2048 ? 2.0F * static_cast<float>(i) : 2048.0F + static_cast<float>(i)) << i;
}

TEST(PictureScene, CloudsKeepClassAndReflectivityOfEachReturn) {
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

TEST(CameraConfig, IsDueAtEachMultipleOfItsPeriodAndInTheFirstTick) {
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

TEST(CameraConfig, OnPaperHasThePixelsOfItsMillimeters) {
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
