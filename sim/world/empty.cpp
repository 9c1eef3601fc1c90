// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/empty.hpp"

#include "sim/world/clutter.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {

void EmptyConfig::visit(ConfigVisitor& v) {
  v.field("ground", ground, "[-] whether there is a flat ground at z = 0; false: empty space");
  v.field("size_m", size_m, "[m] extent of the ground along x and y, centered at the origin", Range::positive());
  v.field("reflectivity", reflectivity, "[-] Lambertian reflectivity of the ground", Range::probability());
  v.object("clutter", clutter, "posts, people and signs on the ground");
}

Scene make_empty(const EmptyConfig& config, std::uint64_t seed) {
  SceneBuilder scene;
  if (config.ground) {
    const Eigen::Vector2f half = (0.5 * config.size_m).cast<float>();
    Mesh mesh;
    add_quad(mesh, {-half.x(), -half.y(), 0}, {half.x(), -half.y(), 0}, {half.x(), half.y(), 0},
             {-half.x(), half.y(), 0});
    Material material{"ground", static_cast<float>(config.reflectivity), false, {0.5F, 0.5F, 0.48F}};
    scene.add(std::move(mesh), material, SurfaceClass::kGround);
    add_clutter(scene, config.clutter, seed, {[](const auto&) { return 0.0; }, [](const auto&) { return true; }});
  }
  return scene.finish();
}

}  // namespace swiftlet::sim
