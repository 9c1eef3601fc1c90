// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/foliage.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/world/forest.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kOneMs = 1'000'000;
constexpr double kTop_m = 8.0;

FoliageConfig storm() {
  FoliageConfig config;
  config.sway_m = 0.5;
  config.flutter_m = 0.1;
  return config;
}

Mesh upright(float x_m, float half_m, float bottom_m, float top_m, SurfaceClass surface_class) {
  Mesh mesh;
  mesh.vertices_mesh_m = {
      {x_m, -half_m, bottom_m}, {x_m, half_m, bottom_m}, {x_m, half_m, top_m}, {x_m, -half_m, top_m}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.surface_class = surface_class;
  return mesh;
}

/// A tree 10 m east: leaves in the upper half and a trunk in the lower one, both across the beams.
Scene one_tree(const FoliageConfig& foliage) {
  Scene scene;
  scene.materials.resize(1);
  scene.meshes = {upright(0.0F, 2.0F, 4.0F, kTop_m, SurfaceClass::kVegetation),
                  upright(0.0F, 2.0F, 0.0F, 4.0F, SurfaceClass::kTrunk)};
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.translate(Eigen::Vector3f(10.0F, 0.0F, 0.0F));
  scene.instances = {{0, T, 5}, {1, T, 5}};
  scene.foliage = foliage;
  scene.foliage_seed = 42;
  return scene;
}

BeamPacket packet_along(const Eigen::Vector3f& direction) {
  BeamPacket beams;
  beams.direction_x.fill(direction.x());
  beams.direction_y.fill(direction.y());
  beams.direction_z.fill(direction.z());
  beams.firing.fill(0);
  return beams;
}

/// One sensor that stands still.
class Sweeper {
 public:
  Sweeper(const Scene& scene, const Vector3& p_m, bool coherent = true)
      : sweep_(std::make_shared<const StaticScene>(scene), {std::make_shared<const VehicleShape>()}, 0,
               Pose::Identity(), 200.0),
        history_(1, 300) {
    VehicleState state;
    state.p_world_m = p_m;
    for (state.t = 0; state.t <= 100'000 * kOneMs; state.t += 1000 * kOneMs) history_.push(0, state);
    sweep_.set_firings(std::vector<Firing>(1), coherent);
  }
  PacketHits look(TimeNs start, TimeNs duration, const BeamPacket& beams) {
    sweep_.begin(history_, start, duration);
    PacketHits hits;
    sweep_.trace(beams, false, hits);
    return hits;
  }
  const SweepSurface& surface(std::uint32_t i) const { return sweep_.surfaces()[i]; }

 private:
  SweepScene sweep_;
  StateHistory history_;
};

// The leaf's middle hangs at three quarters of the tree's height. It is hit in the middle of the sweep.
TEST(WavingFoliage, MatchesClosedFormForLeaves) {
  const FoliageMotion motion(storm(), 42);
  for (const bool coherent : {true, false}) {
    Sweeper leaves(one_tree(storm()), {0.0, 0.0, 6.0}, coherent), trunk(one_tree(storm()), {0.0, 0.0, 2.0}, coherent);
    double least_m = 1e9, most_m = 0.0;
    for (TimeNs t = 30'000 * kOneMs; t < 40'000 * kOneMs; t += 370 * kOneMs) {
      const PacketHits hits = leaves.look(t, 100 * kOneMs, packet_along(Eigen::Vector3f::UnitX()));
      const double t_s = to_seconds(t + 50 * kOneMs);
      const Vector3 offset_m = 0.75 * 0.75 * motion.sway_m(0, t_s) + motion.flutter_m(motion.pattern_of(0, 0), t_s);
      for (int i = 0; i < kPacketSize; ++i) ASSERT_NEAR(hits.range_m[i], 10.0 + offset_m.x(), 2e-6);
      EXPECT_EQ(leaves.surface(hits.surface[0]).surface_class, SurfaceClass::kVegetation);
      EXPECT_EQ(leaves.surface(hits.surface[0]).instance, 5);
      least_m = std::min(least_m, static_cast<double>(hits.range_m[0]));
      most_m = std::max(most_m, static_cast<double>(hits.range_m[0]));
      const PacketHits still = trunk.look(t, 100 * kOneMs, packet_along(Eigen::Vector3f::UnitX()));
      ASSERT_EQ(still.range_m[0], 10.0F);
      EXPECT_EQ(trunk.surface(still.surface[0]).surface_class, SurfaceClass::kTrunk);
    }
    EXPECT_GT(most_m - least_m, 0.4) << "the leaves move";
  }
}

TEST(WavingFoliage, HangsStillWithoutWind) {
  Sweeper still(one_tree({}), {0.0, 0.0, 6.0});
  for (const TimeNs t : {TimeNs{0}, 7'300 * kOneMs}) {
    EXPECT_EQ(still.look(t, 100 * kOneMs, packet_along(Eigen::Vector3f::UnitX())).range_m[0], 10.0F);
  }
}

/// The forest with each leaf cluster shifted to where it is at a time, and no wind.
Scene frozen_at(Scene scene, double t_s) {
  const FoliageMotion motion(scene.foliage, scene.foliage_seed);
  std::uint32_t tree = 0;
  const std::size_t count = scene.instances.size();
  for (std::size_t i = 0; i < count; ++i) {
    Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class != SurfaceClass::kVegetation) continue;
    Mesh moved = mesh;
    double top_m = -1e9;
    for (Eigen::Vector3f& v : moved.vertices_mesh_m) {
      v = instance.T_world_mesh * v;
      top_m = std::max(top_m, static_cast<double>(v.z()));
    }
    const double foot_m = static_cast<double>(instance.T_world_mesh.translation().z());
    const std::vector<std::uint32_t> piece = pieces_of(mesh);
    std::vector<double> sum_m(piece.size(), 0.0), of(piece.size(), 0.0);
    for (std::size_t v = 0; v < piece.size(); ++v) {
      sum_m[piece[v]] += static_cast<double>(moved.vertices_mesh_m[v].z());
      of[piece[v]] += 1.0;
    }
    for (std::size_t v = 0; v < piece.size(); ++v) {
      const double height = (sum_m[piece[v]] / of[piece[v]] - foot_m) / (top_m - foot_m);
      const Vector3 offset_m = FoliageMotion::share_of_sway(height) * motion.sway_m(tree, t_s) +
                               motion.flutter_m(motion.pattern_of(tree, piece[v]), t_s);
      moved.vertices_mesh_m[v] += offset_m.cast<float>();
    }
    ++tree;
    instance.mesh = static_cast<std::uint32_t>(scene.meshes.size());
    instance.T_world_mesh.setIdentity();
    scene.meshes.push_back(std::move(moved));
  }
  scene.foliage = {};
  return scene;
}

TEST(WavingFoliage, MatchesAForestFrozenInPlace) {
  ForestConfig config;
  config.size_m = {14.0, 14.0};
  config.surroundings_m = 0.0;
  config.foliage = storm();
  const Scene forest = make_forest(config, 5);
  constexpr TimeNs kNow = 12'340 * kOneMs;
  const Random random(1, "beams");
  for (const bool coherent : {true, false}) {
    Sweeper waving(forest, {0.0, 0.0, 6.0}, coherent),
        frozen(frozen_at(forest, to_seconds(kNow)), {0.0, 0.0, 6.0}, coherent);
    Sweeper still(frozen_at(forest, 0.0), {0.0, 0.0, 6.0}, coherent);
    int hits = 0, same = 0, moved = 0;
    for (std::uint32_t k = 0; k < 1200; ++k) {
      const auto n = random.normal3(k, 0);
      const Eigen::Vector3f d = Vector3(n[0], n[1], 0.3 * n[2]).normalized().cast<float>();
      const float frozen_m = frozen.look(kNow, 0, packet_along(d)).range_m[0];
      const float range_m = waving.look(kNow, 0, packet_along(d)).range_m[0];
      hits += frozen_m > 0.0F;
      same += std::abs(range_m - frozen_m) < 1e-3F;
      moved += std::abs(range_m - still.look(kNow, 0, packet_along(d)).range_m[0]) > 1e-3F;
    }
    EXPECT_GT(hits, 100);
    EXPECT_GE(same, 1191) << "equal ranges out of 1200; a few rays graze the edge of a leaf";
    EXPECT_GT(moved, 40) << "elsewhere than at another time";
  }
}

}  // namespace
}  // namespace swiftlet::sim
