// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

Vector3 random_point(const Random& random, std::uint32_t i, double half_m) {
  return {random.uniform(-half_m, half_m, 0, i), random.uniform(-half_m, half_m, 1, i),
          random.uniform(-half_m, half_m, 2, i)};
}

// Random triangles of about a meter in a cube of 20 m.
Scene triangle_soup(int num_triangles) {
  const Random random(3, "test.soup");
  Mesh mesh;
  mesh.surface_class = SurfaceClass::kObject;
  for (int i = 0; i < num_triangles; ++i) {
    const Vector3 center = random_point(random, 4 * i, 10.0);
    for (int corner = 0; corner < 3; ++corner) {
      mesh.vertices_mesh_m.push_back((center + random_point(random, 4 * i + 1 + corner, 0.5)).cast<float>());
    }
    const auto first = static_cast<std::uint32_t>(3 * i);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  Scene scene;
  scene.materials.push_back({});
  scene.meshes.push_back(mesh);
  scene.instances.push_back({0, Eigen::Affine3f::Identity(), 7});
  return scene;
}

// Brute force, without any of the tracer's code: sample the triangle's closest point by projection and edges.
double distance_to_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (a + s * (b - a) - p).norm();
}
double distance_to_triangle(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 n = (b - a).cross(c - a).normalized();
  const Vector3 q = p - n.dot(p - a) * n;
  const bool inside =
      n.dot((b - a).cross(q - a)) >= 0 && n.dot((c - b).cross(q - b)) >= 0 && n.dot((a - c).cross(q - c)) >= 0;
  if (inside) return std::abs(n.dot(p - a));
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

TEST(StaticScene, MeasuresPlaneDistanceAlongItsNormal) {
  TestScene builder;
  builder.add_wall({5, -50, -50}, {5, 50, -50}, {5, 50, 50}, {5, -50, 50}, SurfaceClass::kWall, 3);
  const StaticScene scene(builder.scene());
  for (double angle = -1.2; angle <= 1.2; angle += 0.05) {
    const RayHit hit = scene.trace(Vector3::Zero(), {std::cos(angle), std::sin(angle), 0}, 100.0);
    EXPECT_NEAR(hit.range_m, 5.0 / std::cos(angle), 1e-5 * hit.range_m) << angle;
    EXPECT_NEAR(hit.cos_incidence, std::cos(angle), 1e-5) << angle;
    EXPECT_EQ(hit.surface_class, SurfaceClass::kWall);
    EXPECT_EQ(hit.instance, 3);
    EXPECT_EQ(hit.vehicle, kNoVehicle);
  }
  EXPECT_EQ(scene.trace(Vector3::Zero(), {-1, 0, 0}, 100.0).range_m, 0.0F);
  EXPECT_EQ(scene.trace(Vector3::Zero(), {1, 0, 0}, 4.9).range_m, 0.0F);
}

TEST(StaticScene, OcclusionLooksStrictlyBetweenTheEnds) {
  TestScene builder;
  builder.add_wall({5, -50, -50}, {5, 50, -50}, {5, 50, 50}, {5, -50, 50});
  const StaticScene scene(builder.scene());
  EXPECT_TRUE(scene.occluded({0, 0, 0}, {10, 1, 2}));
  EXPECT_TRUE(scene.occluded({10, 0, 0}, {0, 1, 2}));
  EXPECT_FALSE(scene.occluded({0, 0, 0}, {4.99, 1, 2}));
  EXPECT_FALSE(scene.occluded({0, 0, 0}, {5, 1, 2})) << "an end on the surface";
  EXPECT_FALSE(scene.occluded({5, 0, 0}, {9, 1, 2})) << "a start on the surface";
}

TEST(StaticScene, MatchesBruteForceNearestSurface) {
  const Scene soup = triangle_soup(500);
  const StaticScene scene(soup);
  const Random random(5, "test.query");
  const auto& v = soup.meshes[0].vertices_mesh_m;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vector3 p = random_point(random, i, 12.0);
    double expected = 1e9;
    for (const auto& t : soup.meshes[0].triangles) {
      expected = std::min(
          expected, distance_to_triangle(p, v[t[0]].cast<double>(), v[t[1]].cast<double>(), v[t[2]].cast<double>()));
    }
    const auto nearest = scene.nearest(p, 100.0);
    ASSERT_TRUE(nearest.has_value());
    EXPECT_NEAR(nearest->distance_m, expected, 1e-9);
    EXPECT_NEAR((nearest->point_world_m - p).norm(), expected, 1e-9);
    EXPECT_EQ(nearest->instance, 7);
    EXPECT_FALSE(scene.nearest(p, 0.999 * expected).has_value());
    EXPECT_TRUE(scene.nearest(p, 1.001 * expected).has_value());
  }
}

// The boxes of triangles, with a hair of slack, and no others.
TEST(StaticScene, SelectsTrianglesByTouchingBoundingBoxes) {
  const Random random(2, "test.boxes");
  TestScene builder;
  std::vector<Eigen::AlignedBox3d> bounds;
  for (std::uint32_t i = 0; i < 700; ++i) {
    std::vector<Eigen::Vector3f> corners;
    Eigen::AlignedBox3d box;
    const auto middle = random.normal3(0, i);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto n = random.normal3(1 + k, i);
      corners.emplace_back(3.0 * middle[0] + 0.4 * n[0], 3.0 * middle[1] + 0.4 * n[1], 3.0 * middle[2] + 0.4 * n[2]);
      box.extend(corners.back().cast<double>());
    }
    builder.add_mesh(corners, {{0, 1, 2}}, SurfaceClass::kObject, 0, 0);
    bounds.push_back(box);
  }
  const StaticScene scene(builder.scene());
  for (std::uint32_t k = 0; k < 200; ++k) {
    const auto n = random.normal3(10, k);
    const Vector3 middle(2.0 * n[0], 2.0 * n[1], 2.0 * n[2]);
    const Vector3 half(0.1 + random.uniform(11, k), 0.1 + 2.0 * random.uniform(12, k), 0.05);
    const Eigen::AlignedBox3d box(middle - half, middle + half);
    const Eigen::AlignedBox3d with_slack(box.min() - Vector3::Constant(1.01e-4),
                                         box.max() + Vector3::Constant(1.01e-4));
    std::vector<int> found;
    scene.triangles_near_box(
        box, [&](const Vector3&, const Vector3&, const Vector3&, int index) { found.push_back(index); });
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    for (int i = 0; i < 700; ++i) {
      const bool is_found = std::binary_search(found.begin(), found.end(), i);
      EXPECT_TRUE(is_found || !bounds[static_cast<std::size_t>(i)].intersects(box)) << k << " " << i;
      EXPECT_TRUE(!is_found || bounds[static_cast<std::size_t>(i)].intersects(with_slack)) << k << " " << i;
    }
  }
}

TEST(StaticScene, NothingEscapesAClosedRoom) {
  TestScene builder;
  builder.add_box({-4, -3, -2}, {4, 3, 2});
  const StaticScene scene(builder.scene());
  const Random random(1, "test.room");
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto n = random.normal3(0, i);
    const Vector3 direction = Vector3(n[0], n[1], n[2]).normalized();
    const double expected =
        std::min({4.0 / std::abs(direction.x()), 3.0 / std::abs(direction.y()), 2.0 / std::abs(direction.z())});
    EXPECT_NEAR(scene.trace(Vector3::Zero(), direction, 100.0).range_m, expected, 1e-5);
  }
  // Exactly into edges and corners as well.
  for (const Vector3& into : {Vector3(4, 3, 0), Vector3(4, 3, 2), Vector3(-4, 0, 2), Vector3(4, 0, 0)}) {
    EXPECT_NEAR(scene.trace(Vector3::Zero(), into.normalized(), 100.0).range_m, into.norm(), 1e-5);
  }
}

TEST(StaticScene, PlacesInstancesByTheirTransform) {
  TestScene builder;
  builder.add_box({-1, -1, -1}, {1, 1, 1}, SurfaceClass::kRack, 4);
  Scene scene = builder.scene();
  scene.instances[0].T_world_mesh =
      Eigen::Translation3f(10, 0, 0) * Eigen::AngleAxisf(std::numbers::pi_v<float> / 4, Eigen::Vector3f::UnitZ());
  const StaticScene ready(scene);
  EXPECT_NEAR(ready.trace(Vector3(0, 0, 0.3), {1, 0, 0}, 100.0).range_m, 10.0 - std::sqrt(2.0), 1e-5);
  EXPECT_EQ(ready.num_triangles(), 12U);
}

TEST(StaticScene, AnEmptyWorldIsEmpty) {
  const StaticScene scene{Scene{}};
  EXPECT_EQ(scene.trace(Vector3::Zero(), {1, 0, 0}, 100.0).range_m, 0.0F);
  EXPECT_FALSE(scene.occluded({0, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(scene.nearest(Vector3::Zero(), 1000.0).has_value());
}

TEST(StaticScene, PrefersFirstOfEquallyNearSurfaces) {
  TestScene builder;
  for (std::uint16_t i = 1; i <= 6; ++i) builder.add_box({-1, -1, -1}, {1, 1, 1}, SurfaceClass::kObject, i);
  const StaticScene scene(builder.scene());
  for (const Vector3& p_m : {Vector3(3, 0.2, 0.1), Vector3(2, 2, 2), Vector3(0.1, -4, 0.3)}) {
    const auto nearest = scene.nearest(p_m, 50.0);
    ASSERT_TRUE(nearest);
    EXPECT_EQ(nearest->instance, 1);
    EXPECT_LT((nearest->point_world_m - p_m.cwiseMax(-1.0).cwiseMin(1.0)).norm(), 1e-9);
  }
}

TEST(StaticScene, RefusesMoreThanBillionTriangles) {
  Scene scene;
  Mesh mesh;
  mesh.vertices_mesh_m.resize(3, Eigen::Vector3f::Zero());
  mesh.triangles.assign(1'000'000, {0, 1, 2});
  scene.meshes.push_back(mesh);
  scene.instances.resize(1001);
  EXPECT_THROW(StaticScene{scene}, std::invalid_argument);
}

TEST(StaticScene, RefusesNonFiniteVertices) {
  TestScene builder;
  builder.add_mesh({{0, 0, 0}, {1, 0, 0}, {0, std::numeric_limits<float>::infinity(), 0}}, {{0, 1, 2}},
                   SurfaceClass::kObject, 0, 0);
  EXPECT_THROW(StaticScene{builder.scene()}, std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet::sim
