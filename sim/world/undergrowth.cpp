// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/undergrowth.hpp"

#include <algorithm>
#include <cmath>

#include "sim/world/materials.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3f;

// [-] Distinct meshes of each kind of plant; placed ones are scaled and rotated copies.
constexpr int kVariants = 6;

// Leaves in the upper half of an ellipsoid on a few bare stems.
Mesh make_bush(double detail, Dice dice) {
  Mesh mesh;
  const int num_leaves = std::max(12, static_cast<int>(std::lround(70 * detail)));
  const auto leaf_m = static_cast<float>(0.16 / std::sqrt(std::max(detail, 0.1)));
  for (int i = 0; i < num_leaves; ++i) {
    const Vector3f direction = dice.direction();
    const auto radius = static_cast<float>(elementary::cbrt(dice.uniform(0.1, 1.0)));
    const Vector3f center(0.55F * radius * direction.x(), 0.55F * radius * direction.y(),
                          0.15F + 0.8F * radius * std::abs(direction.z()));
    const Vector3f normal = dice.direction();
    const Vector3f along = normal.unitOrthogonal();
    const Vector3f across = normal.cross(along);
    add_triangle(mesh, center + leaf_m * along, center - 0.5F * leaf_m * along + 0.7F * leaf_m * across,
                 center - 0.5F * leaf_m * along - 0.7F * leaf_m * across);
  }
  for (int i = 0; i < 4; ++i) {
    const double angle_rad = dice.angle_rad();
    const Vector3f tip(static_cast<float>(0.4 * elementary::cos(angle_rad)),
                       static_cast<float>(0.4 * elementary::sin(angle_rad)), 0.7F);
    add_frustum(mesh, {0, 0, -0.1F}, 0.012F, tip, 0.004F, 3, Caps::kNone);
  }
  return mesh;
}

// Blades that rise from one foot and bend outward.
Mesh make_grass(double detail, Dice dice) {
  Mesh mesh;
  const int num_blades = std::max(6, static_cast<int>(std::lround(14 * detail)));
  for (int i = 0; i < num_blades; ++i) {
    const double angle_rad = dice.angle_rad();
    const Vector3f outward(static_cast<float>(elementary::cos(angle_rad)),
                           static_cast<float>(elementary::sin(angle_rad)), 0);
    const Vector3f side = Vector3f::UnitZ().cross(outward);
    const auto height_m = static_cast<float>(dice.uniform(0.25, 0.55));
    const auto bend_m = static_cast<float>(dice.uniform(0.05, 0.3));
    const Vector3f foot = static_cast<float>(dice.uniform(0.0, 0.08)) * outward - Vector3f(0, 0, 0.05F);
    add_triangle(mesh, foot - 0.02F * side, foot + 0.02F * side, foot + bend_m * outward + Vector3f(0, 0, height_m));
  }
  return mesh;
}

double horizontal_reach_m(const Mesh& mesh) {
  double reach = 0.0;
  for (const Vector3f& vertex : mesh.vertices_mesh_m) reach = std::max<double>(reach, vertex.head<2>().norm());
  return reach;
}

}  // namespace

UndergrowthStock::UndergrowthStock(SceneBuilder& scene, double detail, const Random& random) {
  for (std::uint32_t i = 0; i < kVariants; ++i) {
    Mesh bush = make_bush(detail, Dice(random, 2 * i));
    Mesh grass = make_grass(detail, Dice(random, 2 * i + 1));
    bush_reach_m_ = std::max(bush_reach_m_, horizontal_reach_m(bush));
    grass_reach_m_ = std::max(grass_reach_m_, horizontal_reach_m(grass));
    bushes_.push_back(scene.add_mesh(std::move(bush), materials::leaves(), SurfaceClass::kUndergrowth));
    grass_.push_back(scene.add_mesh(std::move(grass), materials::grass(), SurfaceClass::kUndergrowth));
  }
}

double UndergrowthStock::reach_m(Kind kind, double scale) const {
  return scale * (kind == Kind::kBush ? bush_reach_m_ : grass_reach_m_);
}

void UndergrowthStock::place(SceneBuilder& scene, Kind kind, const Eigen::Vector3d& foot_world_m, double scale,
                             Dice& dice) const {
  const std::uint32_t mesh = (kind == Kind::kBush ? bushes_ : grass_)[dice.pick(kVariants)];
  const std::uint16_t instance = scene.next_instance(SurfaceClass::kUndergrowth);
  const double yaw_rad = dice.angle_rad();
  scene.place(mesh, instance,
              transform(foot_world_m.cast<float>(), static_cast<float>(yaw_rad),
                        Vector3f::Constant(static_cast<float>(scale))));
  scene.add_object({instance,
                    SurfaceClass::kUndergrowth,
                    kind == Kind::kBush ? "bush" : "grass",
                    foot_world_m,
                    yaw_rad,
                    {{"scale", scale}}});
}

}  // namespace swiftlet::sim
