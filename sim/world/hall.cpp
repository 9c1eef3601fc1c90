// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/hall.hpp"

#include <algorithm>

#include "sim/world/building.hpp"
#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// [m] Thickness of all walls, and largest extent of the crates from the outer ones.
constexpr double kHallWall_m = 0.25;
constexpr double kCrateZone_m = 1.0;

double hide_top_m(const HallConfig& config) {
  return config.hide_height_m > 0.0 ? config.hide_height_m : config.size_m.z();
}

// Both ends of the cover wall.
std::pair<Vector2d, Vector2d> hide_ends(const HallConfig& config) {
  const double yaw_rad = radians(config.hide_yaw_deg);
  const Vector2d half_m = 0.5 * config.hide_length_m * Vector2d(elementary::cos(yaw_rad), elementary::sin(yaw_rad));
  return {config.hide_center_m - half_m, config.hide_center_m + half_m};
}

Mesh make_walls(const HallConfig& config) {
  const double t = kHallWall_m;
  const double x = 0.5 * config.size_m.x() + 0.5 * t;
  const double y = 0.5 * config.size_m.y() + 0.5 * t;
  const double height_m = config.size_m.z();
  Mesh mesh;
  add_wall(mesh, {-x - 0.5 * t, -y}, {x + 0.5 * t, -y}, height_m, t);
  add_wall(mesh, {-x - 0.5 * t, y}, {x + 0.5 * t, y}, height_m, t);
  add_wall(mesh, {-x, -y + 0.5 * t}, {-x, y - 0.5 * t}, height_m, t);
  add_wall(mesh, {x, -y + 0.5 * t}, {x, y - 0.5 * t}, height_m, t);
  return mesh;
}

// Piles of one or two boxes, each touching one of the four walls.
void add_crates(SceneBuilder& scene, const HallConfig& config, std::uint64_t seed) {
  const Random random(seed, "world.hall.crates");
  const Vector2d half_m = 0.5 * config.size_m.head<2>();
  for (int i = 0; i < config.num_crates; ++i) {
    Dice dice(random, i);
    const int wall = dice.pick(4);
    const double depth_m = kCrateZone_m * dice.uniform(0.5, 1.0);
    const double width_m = dice.uniform(0.5, 1.2);
    const double height_m = std::min(dice.uniform(0.4, 1.0), 0.9 * config.size_m.z());
    const bool is_along_x = wall < 2;
    const double side = wall % 2 == 0 ? -1.0 : 1.0;
    const double free_m = (is_along_x ? half_m.x() : half_m.y()) - 0.5 * width_m;
    const double along_m = dice.uniform(-1.0, 1.0) * std::max(0.0, free_m);
    const double across_m = side * ((is_along_x ? half_m.y() : half_m.x()) - 0.5 * depth_m);
    const Vector3d center_m(is_along_x ? along_m : across_m, is_along_x ? across_m : along_m, 0.5 * height_m);
    const Vector3d size_m(is_along_x ? width_m : depth_m, is_along_x ? depth_m : width_m, height_m);
    Mesh mesh;
    add_box(mesh, (center_m - 0.5 * size_m).cast<float>(), (center_m + 0.5 * size_m).cast<float>());
    const std::uint16_t instance = scene.next_instance(SurfaceClass::kObject);
    scene.add(std::move(mesh), materials::cardboard(), SurfaceClass::kObject, instance);
    scene.add_object({instance,
                      SurfaceClass::kObject,
                      "crate",
                      center_m,
                      0.0,
                      {{"size_x_m", size_m.x()}, {"size_y_m", size_m.y()}, {"size_z_m", size_m.z()}}});
  }
}

}  // namespace

void HallConfig::visit(ConfigVisitor& v) {
  v.field("size_m", size_m, "[m] inner size along x, y, z; x and y centered at the origin, floor at z = 0",
          Range::positive());
  v.field("hide_center_m", hide_center_m, "[m] center of the free-standing wall");
  v.field("hide_length_m", hide_length_m, "[m] length of the free-standing wall", Range::positive());
  v.field("hide_height_m", hide_height_m, "[m] height of the free-standing wall; 0: up to the ceiling",
          Range::non_negative());
  v.field("hide_yaw_deg", hide_yaw_deg, "[deg] direction of the free-standing wall");
  v.field("num_crates", num_crates, "[-] number of crates along the outer walls", Range::between(0, 1000));
  const auto [start_m, end_m] = hide_ends(*this);
  const Vector2d half_m = 0.5 * size_m.head<2>();
  v.check((start_m.cwiseAbs().array() <= half_m.array()).all() && (end_m.cwiseAbs().array() <= half_m.array()).all(),
          "hide_length_m", "a free-standing wall inside the hall");
  v.check(hide_height_m <= size_m.z(), "hide_height_m", "at most the height of the hall");
}

Scene make_hall(const HallConfig& config, std::uint64_t seed) {
  SceneBuilder scene;
  const Vector2d half_m = 0.5 * config.size_m.head<2>() + Vector2d::Constant(kHallWall_m);
  Mesh floor;
  add_floor(floor, -half_m, half_m, 0.0);
  scene.add(std::move(floor), materials::concrete(), SurfaceClass::kGround);
  scene.add(make_walls(config), materials::plaster(), SurfaceClass::kWall, scene.next_instance(SurfaceClass::kWall));
  Mesh ceiling;
  const Vector3f low = Vector3d(-half_m.x(), -half_m.y(), config.size_m.z()).cast<float>();
  const Vector3f high = Vector3d(half_m.x(), half_m.y(), config.size_m.z() + 0.2).cast<float>();
  add_box(ceiling, low, high);
  scene.add(std::move(ceiling), materials::concrete(), SurfaceClass::kCeiling, 1);

  const auto [start_m, end_m] = hide_ends(config);
  Mesh hide;
  add_wall(hide, start_m, end_m, hide_top_m(config), kHallWall_m);
  const std::uint16_t instance = scene.next_instance(SurfaceClass::kWall);
  scene.add(std::move(hide), materials::brick(), SurfaceClass::kWall, instance);
  scene.add_object(
      {instance,
       SurfaceClass::kWall,
       "hide",
       {config.hide_center_m.x(), config.hide_center_m.y(), 0.5 * hide_top_m(config)},
       radians(config.hide_yaw_deg),
       {{"length_m", config.hide_length_m}, {"height_m", hide_top_m(config)}, {"thickness_m", kHallWall_m}}});
  add_crates(scene, config, seed);
  return scene.finish();
}

}  // namespace swiftlet::sim
