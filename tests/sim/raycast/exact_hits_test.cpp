// SPDX-License-Identifier: BSD-3-Clause
// The rule of sim/raycast/exact_hits_internal.hpp against a search through all triangles, under every instruction set
// that Embree supports on this processor.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>

#include "sim/raycast/exact_hits_internal.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/support/embree_settings.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Sets Embree's configuration during its lifetime.
class EmbreeSetting {
 public:
  explicit EmbreeSetting(const std::string& setting) { ::setenv("SWIFTLET_EMBREE", setting.c_str(), 1); }
  ~EmbreeSetting() { ::unsetenv("SWIFTLET_EMBREE"); }
};

const std::vector<std::string> kSettings = embree_settings();

struct Ray {
  Vector3f origin, direction;
};

struct NearestHit {
  std::uint32_t triangle = 0xFFFFFFFF;
  float range_m = 0.0F, cosine = 0.0F;
  bool operator==(const NearestHit&) const = default;
};

constexpr double kRange_m = 60.0;

Scene scene_of(Mesh mesh) {
  mesh.surface_class = SurfaceClass::kObject;
  Scene scene;
  scene.materials.push_back({});
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({0, Eigen::Affine3f::Identity(), 7});
  return scene;
}

void add_triangle(Mesh& mesh, const Vector3f& a, const Vector3f& b, const Vector3f& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_mesh_m.size());
  mesh.vertices_mesh_m.insert(mesh.vertices_mesh_m.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

void add_parallelogram(Mesh& mesh, const Vector3f& corner, const Vector3f& u, const Vector3f& v) {
  add_triangle(mesh, corner, corner + u, corner + u + v);
  add_triangle(mesh, corner, corner + u + v, corner + v);
}

/// A random point in a cube about the origin.
Vector3f point_in_cube(const Random& random, std::uint32_t i, double half_m) {
  return Vector3(random.uniform(-half_m, half_m, 0, i), random.uniform(-half_m, half_m, 1, i),
                 random.uniform(-half_m, half_m, 2, i))
      .cast<float>();
}

// Boxes on round numbers that touch and overlap in whole faces, leaves, needles, and triangles without area.
Mesh hard_mesh() {
  Mesh mesh;
  for (int i = 0; i < 4; ++i) {
    const Vector3f low(static_cast<float>(2 * i - 4), 3.0F, -1.0F);  // next to each other, faces in common
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3f u = 2.0F * Vector3f::Unit((axis + 1) % 3), v = 2.0F * Vector3f::Unit((axis + 2) % 3);
      add_parallelogram(mesh, low, u, v);
      add_parallelogram(mesh, low + 2.0F * Vector3f::Unit(axis), u, v);
    }
  }
  add_parallelogram(mesh, {-30, -30, -1}, {60, 0, 0}, {0, 60, 0});  // the ground, in the plane of the boxes' bottoms
  add_parallelogram(mesh, {-30, -30, -1}, {60, 0, 0}, {0, 60, 0});  // a duplicate
  const Random random(3, "test.hard_mesh");
  const auto point = [&](std::uint32_t i, double half_m) { return point_in_cube(random, i, half_m); };
  for (std::uint32_t i = 0; i < 3000; ++i) {  // leaves, many through each other
    const Vector3f center = point(4 * i, 2.5) + Vector3f(0, -6, 3);
    add_triangle(mesh, center + point(4 * i + 1, 0.06), center + point(4 * i + 2, 0.06),
                 center + point(4 * i + 3, 0.06));
  }
  for (std::uint32_t i = 0; i < 300; ++i) {  // needles: 0.1 mm thick, 1 m long
    const Vector3f foot = point(20000 + i, 3.0) + Vector3f(8, 0, 3), tip = foot + point(21000 + i, 0.5);
    add_triangle(mesh, foot, tip, 0.5F * (foot + tip) + point(22000 + i, 1e-4));
  }
  add_triangle(mesh, {1, 1, 1}, {1, 1, 1}, {1, 1, 1});
  add_triangle(mesh, {1, 1, 1}, {2, 2, 2}, {3, 3, 3});
  return mesh;
}

// Random rays, at corners, along edges, at points common to several triangles, and along axes.
std::vector<Ray> hard_rays(const Mesh& mesh) {
  const Random random(5, "test.hard_rays");
  const auto uniform = [&](std::uint32_t i, std::uint32_t k) { return random.uniform(-1.0, 1.0, k, i); };
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < 16000; ++i) {
    const Vector3d origin = i % 4 == 0 ? Vector3d(std::round(4 * uniform(i, 0)), 0.0, std::round(uniform(i, 2)))
                                       : Vector3d(6 * uniform(i, 0), 2 * uniform(i, 1), 2 + 2 * uniform(i, 2));
    const auto& t =
        mesh.triangles[static_cast<std::size_t>(random.uniform(9, i) * static_cast<double>(mesh.triangles.size()))];
    const Vector3d a = mesh.vertices_mesh_m[t[0]].cast<double>(), b = mesh.vertices_mesh_m[t[1]].cast<double>();
    Vector3d aim = a;
    if (i % 5 == 1) aim = a + 0.5 * (1.0 + uniform(i, 3)) * (b - a);
    if (i % 5 == 2) aim = origin + Vector3d(uniform(i, 3), uniform(i, 4), uniform(i, 5));
    if (i % 5 == 3) aim = origin + Vector3d(Vector3f::Unit(static_cast<int>(i / 5) % 3).cast<double>());
    if ((aim - origin).norm() < 1e-3) continue;
    rays.push_back({origin.cast<float>(), (aim - origin).normalized().cast<float>()});
  }
  rays.resize(rays.size() / kPacketSize * kPacketSize);
  return rays;
}

enum class Batch { kTogether, kScattered, kSingly };
constexpr Batch kBatches[] = {Batch::kTogether, Batch::kScattered, Batch::kSingly};

std::vector<NearestHit> traced(const TriangleScene& scene, const std::vector<Ray>& rays, Batch batch) {
  std::vector<NearestHit> out;
  for (std::size_t first = 0; first < rays.size(); first += kPacketSize) {
    ExactQuery query(scene);
    for (int i = 0; i < kPacketSize; ++i) query.set_ray(i, rays[first + i].origin, rays[first + i].direction, kRange_m);
    if (batch == Batch::kTogether) query.trace_together();
    if (batch == Batch::kScattered) query.trace_scattered();
    if (batch == Batch::kSingly) query.trace_singly(kPacketSize);
    for (int i = 0; i < kPacketSize; ++i) {
      NearestHit hit;
      if (query.met(i)) hit = {query.triangle(i), query.range_m(i), query.cos_incidence(i)};
      out.push_back(hit);
    }
  }
  return out;
}

// The rule without a tree, from its description.
NearestHit searched(const TriangleScene& scene, const Ray& ray) {
  NearestHit nearest;
  double nearest_m = kRange_m;
  const Vector3d o = ray.origin.cast<double>(), d = ray.direction.cast<double>();
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Facet& facet = scene.facets[i];
    const Vector3d n = facet.normal.cast<double>(), corner = facet.corner_m.cast<double>();
    const double cosine = n.dot(d), height_m = n.dot(corner - o), range_m = height_m / cosine;
    if (!(range_m > 0.0) || range_m > nearest_m || std::abs(height_m) < kMinHeight_m) continue;
    if (std::abs(cosine) < std::max<double>(kMinCosine, facet.least_cosine_per_m * (range_m + 1.0))) continue;
    int left = 0, right = 0;
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = scene.corners_m[i][k].cast<double>() - o,
                     q = scene.corners_m[i][(k + 1) % 3].cast<double>() - o;
      const double volume = d.dot(p.cross(q));
      left += volume >= 0.0;
      right += volume <= 0.0;
    }
    if (left < 3 && right < 3) continue;
    if (range_m == nearest_m && nearest.triangle != 0xFFFFFFFF) continue;  // the first in the scene keeps it
    nearest_m = range_m;
    nearest = {static_cast<std::uint32_t>(i), static_cast<float>(range_m), static_cast<float>(std::abs(cosine))};
  }
  return nearest;
}

void expect_nearest_triangles(const Mesh& mesh, const std::vector<Ray>& rays) {
  const Scene description = scene_of(mesh);
  std::vector<NearestHit> expected;
  for (const std::string& setting : kSettings) {
    const EmbreeSetting with_setting(setting);
    const StaticScene scene(description);
    scene.impl().expect_scattered_rays();
    const TriangleScene& triangles = scene.impl().world;
    if (expected.empty()) {
      for (const Ray& ray : rays) expected.push_back(searched(triangles, ray));
    }
    for (const Batch batch : kBatches) {
      const std::vector<NearestHit> found = traced(triangles, rays, batch);
      int different = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        // Two roundings of the search may differ from the rule's in the last bit; the triangle may not.
        const bool same = found[i].triangle == expected[i].triangle &&
                          std::abs(found[i].range_m - expected[i].range_m) <= 1e-6F * expected[i].range_m;
        if (same) continue;
        if (++different <= 3) {
          ADD_FAILURE() << setting << ", batch " << static_cast<int>(batch) << ": ray " << i << " hit "
                        << found[i].triangle << " at " << found[i].range_m << ", expected " << expected[i].triangle
                        << " at " << expected[i].range_m;
        }
      }
      EXPECT_EQ(different, 0) << "rays that differ, out of " << rays.size();
    }
  }
}

TEST(ExactHits, MatchBruteForceDespiteEmbreeRounding) {
  const Mesh mesh = hard_mesh();
  expect_nearest_triangles(mesh, hard_rays(mesh));
}

// Surfaces that cross, touch or cover each other without a common edge, and folds so sharp that both sides are near.
Mesh meeting_surfaces() {
  Mesh mesh;
  add_parallelogram(mesh, {-4, 0, 0}, {8, 0, 0}, {0, 0, 3});   // a wall,
  add_parallelogram(mesh, {-1, -2, 0}, {2, 4, 0}, {0, 0, 2});  // one through it, and one that ends on it
  add_parallelogram(mesh, {3, 0, 0}, {0.1F, 3, 0}, {0, 0, 2.5F});
  // Pictures in the plane of the wall, and in front of and behind it.
  add_parallelogram(mesh, {-3, 0, 1}, {1, 0, 0}, {0, 0, 1});
  add_parallelogram(mesh, {-2.5F, 0, 0.5F}, {2, 0, 0}, {0, 0, 1.2F});
  add_parallelogram(mesh, {1.2F, -3e-4F, 0.5F}, {1, 0, 0}, {0, 0, 1});
  add_parallelogram(mesh, {1.7F, 1e-5F, 0.7F}, {1, 0, 0}, {0, 0, 1});
  add_triangle(mesh, {-6, -6, -0.2F}, {7, -5, 0.1F}, {0, 8, 0.3F});  // the ground, through the feet of all
  // A roof with a T junction: one long edge, two short ones along it.
  add_triangle(mesh, {0, 0, 3}, {4, 0, 3}, {0, 3, 4});
  add_triangle(mesh, {0, 0, 3}, {1.3F, 0, 3}, {0, -2, 3.5F});
  add_triangle(mesh, {1.3F, 0, 3}, {4, 0, 3}, {0, -2, 3.5F});
  for (int i = 1; i <= 4; ++i) {  // folds of 6, 0.6, 0.06 and 0.006 degrees
    const auto gap_m = static_cast<float>(std::pow(0.1, i));
    const Vector3f foot(static_cast<float>(i) - 3.0F, 4, 0.5F), top = foot + Vector3f(0, 0, 1);
    add_triangle(mesh, foot, top, foot + Vector3f(0.3F, 1, 0.5F));
    add_triangle(mesh, foot, top, foot + Vector3f(0.3F + gap_m, 1, 0.5F));
  }
  const Random random(11, "test.meeting_surfaces");
  const auto point = [&](std::uint32_t i, double half_m) { return point_in_cube(random, i, half_m); };
  for (std::uint32_t i = 0; i < 40; ++i) {  // needles through the wall, and leaves through all
    const Vector3f foot = Vector3f(0, 0, 1.5F) + point(3 * i, 1.5);
    const float width_m = i % 2 == 0 ? 1e-4F : 0.2F;
    add_triangle(mesh, foot, foot + point(3 * i + 1, 1.0), foot + width_m * point(3 * i + 2, 1.0));
  }
  return mesh;
}

// Points where edges of a triangle pierce another triangle: ends of their intersection.
void add_crossings(const Mesh& mesh, std::size_t i, std::size_t j, std::vector<Vector3d>& ends) {
  const auto corner = [&](std::size_t t, int k) -> Vector3d {
    return mesh.vertices_mesh_m[mesh.triangles[t][k % 3]].cast<double>();
  };
  const Vector3d a = corner(j, 0), ab = corner(j, 1) - a, ac = corner(j, 2) - a, normal = ab.cross(ac);
  for (int k = 0; k < 3; ++k) {
    const Vector3d p = corner(i, k), along = corner(i, k + 1) - p;
    const double s = normal.dot(a - p) / normal.dot(along);
    if (!(s >= 0.0 && s <= 1.0)) continue;
    const Vector3d at = p + s * along - a;
    const double u = at.cross(ac).dot(normal) / normal.squaredNorm(),
                 v = ab.cross(at).dot(normal) / normal.squaredNorm();
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) ends.emplace_back(a + at);
  }
}

// At intersection lines and at edges, up to 3 mm beside them, from 0.3 to 55 m away, some nearly parallel to a surface.
std::vector<Ray> rays_at_meetings(const Mesh& mesh) {
  std::vector<std::pair<Vector3d, Vector3d>> lines;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      lines.emplace_back(mesh.vertices_mesh_m[mesh.triangles[i][k]].cast<double>(),
                         mesh.vertices_mesh_m[mesh.triangles[i][(k + 1) % 3]].cast<double>());
    }
    for (std::size_t j = 0; j < i; ++j) {
      std::vector<Vector3d> ends;
      add_crossings(mesh, i, j, ends);
      add_crossings(mesh, j, i, ends);
      if (ends.size() >= 2) lines.emplace_back(ends[0], ends[1]);
    }
  }
  const Random random(12, "test.rays_at_meetings");
  const auto uniform = [&](std::uint32_t i, std::uint32_t k) { return random.uniform(-1.0, 1.0, k, i); };
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < 48000; ++i) {
    const auto& [from, to] = lines[i % lines.size()];
    const Vector3d on_line = from + 0.5 * (1.0 + uniform(i, 0)) * (to - from);
    const double beside_m = i % 3 == 0 ? 0.0 : 3e-3 * std::pow(10.0, -2.0 * (1.0 + uniform(i, 1)));
    const Vector3d aim = on_line + beside_m * Vector3d(uniform(i, 2), uniform(i, 3), uniform(i, 4));
    Vector3d away(uniform(i, 5), uniform(i, 6), uniform(i, 7));
    const auto& t = mesh.triangles[i / 7 % mesh.triangles.size()];
    const Vector3d a = mesh.vertices_mesh_m[t[0]].cast<double>();
    const Vector3d normal = (mesh.vertices_mesh_m[t[1]].cast<double>() - a)
                                .cross(mesh.vertices_mesh_m[t[2]].cast<double>() - a)
                                .normalized();
    if (i % 4 == 1) away += (0.03 * uniform(i, 8) - away.dot(normal)) * normal;
    const double distance_m = 0.3 * std::pow(180.0, 0.5 * (1.0 + uniform(i, 9)));
    const Vector3f origin = (aim + distance_m * away.normalized()).cast<float>();
    rays.push_back({origin, (aim - origin.cast<double>()).normalized().cast<float>()});
  }
  rays.resize(rays.size() / kPacketSize * kPacketSize);
  return rays;
}

TEST(ExactHits, MatchBruteForceWhereSurfacesMeet) {
  const Mesh mesh = meeting_surfaces();
  expect_nearest_triangles(mesh, rays_at_meetings(mesh));
}

TEST(ExactHits, MatchAcrossInstructionSetsWithinWall) {
  Mesh wall;
  wall.vertices_mesh_m = {{3, -5, -5}, {3.2F, 5, -5}, {3.2F, 5, 5}, {3, -5, 5}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Scene description = scene_of(wall);
  Airframe airframe;
  for (const double x_m : {-0.2, 0.2}) {
    airframe.rotors.push_back({Vector3(x_m, 0.2, 0.03), Rotor::Spin::kCcw});
    airframe.rotors.push_back({Vector3(x_m, -0.2, 0.03), Rotor::Spin::kCw});
  }
  const auto shape = std::make_shared<const VehicleShape>(make_vehicle_shape(airframe));
  StateHistory history(2, 8);
  for (TimeNs t = 0; t <= 8'000'000; t += 2'000'000) {
    VehicleState own, other;
    own.t = other.t = t;
    other.p_world_m = {3.1 + 5.0 * to_seconds(t), 0.02, 0.03};
    other.q_world_body = Eigen::AngleAxisd(0.4 + 9.0 * to_seconds(t), Vector3::UnitY());
    history.push(0, own);
    history.push(1, other);
  }
  std::vector<Firing> firings(kPacketSize);
  for (int i = 0; i < kPacketSize; ++i) firings[i].offset_s = 5e-4F * static_cast<float>(i);
  std::vector<PacketHits> expected;
  for (const std::string& setting : kSettings) {
    const EmbreeSetting with_setting(setting);
    SweepScene scene(std::make_shared<const StaticScene>(description), {shape, shape}, 0, Pose::Identity(), 100.0);
    scene.set_firings(firings);
    scene.begin(history, 0, 8'000'000);
    std::vector<PacketHits> hits(2000);
    int on_vehicle = 0, on_wall = 0;
    for (std::size_t k = 0; k < hits.size(); ++k) {
      BeamPacket beams;
      for (int i = 0; i < kPacketSize; ++i) {
        const double azimuth_rad = 0.15 * (static_cast<double>(k % 50) / 25.0 - 1.0) + 4e-4 * i;
        const double elevation_rad = 0.12 * (static_cast<double>(k) / 1000.0 - 1.0);
        beams.direction_x[i] = static_cast<float>(std::cos(elevation_rad) * std::cos(azimuth_rad));
        beams.direction_y[i] = static_cast<float>(std::cos(elevation_rad) * std::sin(azimuth_rad));
        beams.direction_z[i] = static_cast<float>(std::sin(elevation_rad));
        beams.firing[i] = i;
      }
      scene.trace(beams, false, hits[k]);
      for (const std::uint32_t surface : hits[k].surface) {
        (scene.surfaces()[surface].vehicle == 1 ? on_vehicle : on_wall) += 1;
      }
    }
    EXPECT_GT(on_vehicle, 1000);
    EXPECT_GT(on_wall, 1000);
    if (expected.empty()) expected = hits;
    for (std::size_t k = 0; k < hits.size(); ++k) {
      ASSERT_EQ(hits[k].range_m, expected[k].range_m) << setting << ", packet " << k;
      ASSERT_EQ(hits[k].cos_incidence, expected[k].cos_incidence) << setting << ", packet " << k;
      ASSERT_EQ(hits[k].surface, expected[k].surface) << setting << ", packet " << k;
    }
  }
}

TEST(ExactHits, MatchAcrossInstructionSetsInForest) {
  ForestConfig forest;
  forest.size_m = {20.0, 20.0};
  const Scene description = make_forest(forest, 4);
  const Random random(8, "test.rays");
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < 64000; ++i) {
    const double azimuth_rad = 2.0 * std::numbers::pi * (i % 1600) / 1600.0;
    const double elevation_rad = 0.4 * random.uniform(-1.0, 1.0, 0, i / kPacketSize);
    const Vector3d direction(std::cos(elevation_rad) * std::cos(azimuth_rad),
                             std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad));
    rays.push_back({Vector3f(0.5F, 0.25F, 4.0F), direction.cast<float>()});
  }
  std::vector<NearestHit> expected;
  for (const std::string& setting : kSettings) {
    const EmbreeSetting with_setting(setting);
    const StaticScene scene(description);
    scene.impl().expect_scattered_rays();
    for (const Batch batch : kBatches) {
      const std::vector<NearestHit> found = traced(scene.impl().world, rays, batch);
      if (expected.empty()) expected = found;
      EXPECT_TRUE(found == expected) << setting << ", batch " << static_cast<int>(batch);
    }
  }
  const auto hits =
      std::count_if(expected.begin(), expected.end(), [](const NearestHit& m) { return m.range_m > 0.0F; });
  EXPECT_GT(hits, 10000);
}

TEST(ExactHits, LetNoRayThroughClosedSurfaces) {
  // A ball of triangles, seen from within: at its corners, along its edges, anywhere.
  Mesh mesh;
  constexpr int kRings = 24, kSides = 36;
  for (int r = 0; r <= kRings; ++r) {
    for (int s = 0; s < kSides; ++s) {
      const double polar = std::numbers::pi * r / kRings, around = 2.0 * std::numbers::pi * s / kSides;
      mesh.vertices_mesh_m.push_back(
          (7.0 * Vector3d(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)))
              .cast<float>());
    }
  }
  for (std::uint32_t r = 0; r < kRings; ++r) {
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const std::uint32_t a = r * kSides + s, b = r * kSides + (s + 1) % kSides;
      mesh.triangles.push_back({a, b, a + kSides});
      mesh.triangles.push_back({b, b + kSides, a + kSides});
    }
  }
  const StaticScene scene(scene_of(mesh));
  const Random random(6, "test.ball");
  const Vector3f origin(0.3F, -0.2F, 0.1F);
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < 40000; ++i) {
    const auto& t =
        mesh.triangles[static_cast<std::size_t>(random.uniform(0, i) * static_cast<double>(mesh.triangles.size()))];
    const Vector3f a = mesh.vertices_mesh_m[t[0]], b = mesh.vertices_mesh_m[t[1]], c = mesh.vertices_mesh_m[t[2]];
    const auto u = static_cast<float>(random.uniform(0.0, 1.0, 1, i));
    const Vector3f aim = i % 3 == 0   ? a
                         : i % 3 == 1 ? Vector3f(a + u * (b - a))
                                      : Vector3f((a + u * (b + c)) / (1 + 2 * u));
    rays.push_back({origin, (aim - origin).normalized()});
  }
  scene.impl().expect_scattered_rays();
  for (const Batch batch : kBatches) {
    for (const NearestHit& hit : traced(scene.impl().world, rays, batch)) ASSERT_NEAR(hit.range_m, 7.0F, 0.6F);
  }
}

TEST(ExactHits, MissSurfacesSeenEdgeOn) {
  Mesh mesh;
  mesh.vertices_mesh_m = {{1, -5, 0}, {21, -5, 0}, {21, 5, 0}, {1, 5, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const StaticScene scene(scene_of(mesh));
  const auto range_m = [&](double cosine) {
    const Vector3d direction(std::sqrt(1.0 - cosine * cosine), 0.0, -cosine);
    return scene.trace(Vector3d(10.0, 0.5, 0.0) - 5.0 * direction, direction, 50.0).range_m;
  };
  EXPECT_NEAR(range_m(1.5 * kMinCosine), 5.0, 1e-4);
  EXPECT_EQ(range_m(0.5 * kMinCosine), 0.0F);
  EXPECT_EQ(range_m(0.0), 0.0F);
}

}  // namespace
}  // namespace swiftlet::sim
