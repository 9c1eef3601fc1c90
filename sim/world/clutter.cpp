// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/clutter.hpp"

#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {

void ClutterThingConfig::visit(ConfigVisitor& v) {
  v.choice("kind", kind, {"post", "person", "sign"}, "[-] kind of the thing");
  v.field("position_m", position_m, "[m] position, world frame; its foot is on the ground");
  v.field("yaw_deg", yaw_deg, "[deg] heading, counter-clockwise from east");
  v.field("scale", scale, "[-] size relative to a post of 0.4 x 0.4 x 0.95 m, a person of 1.75 m, a sign of 2.4 m",
          Range::between(0.1, 10.0));
}

void ClutterConfig::visit(ConfigVisitor& v) {
  v.list("things", things, "things at chosen places");
  v.field("num_posts", num_posts, "[-] largest number of random posts, limited by space", Range::between(0, 10000));
  v.field("num_people", num_people, "[-] largest number of random standing people, limited by space",
          Range::between(0, 10000));
  v.field("num_signs", num_signs, "[-] largest number of random retro-reflective signs on thin poles, limited by space",
          Range::between(0, 10000));
  v.field("center_m", center_m, "[m] center of the ring for random things, world frame");
  v.field("radius_min_m", radius_min_m, "[m] inner radius of the ring", Range::non_negative());
  v.field("radius_max_m", radius_max_m, "[m] outer radius of the ring", Range::positive());
  v.check(radius_max_m > radius_min_m, "radius_max_m", "more than radius_min_m");
}

namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;
using ThingKind = ClutterThingConfig::Kind;

// [-] Draws of a position for one object; then the object is left out.
constexpr int kPlacesPerThing = 50;
constexpr int kLimbSides = 10;  // sides of round limbs and poles
constexpr const char* kThingNames[] = {"post", "person", "sign"};

/// Things at unit scale, foot at the origin, looking along x.
class ThingStock {
 public:
  explicit ThingStock(SceneBuilder& scene) : scene_(scene) {}

  void place(const ClutterThingConfig& thing, double ground_m) {
    const std::uint16_t instance = scene_.next_instance(SurfaceClass::kObject);
    const auto scale = static_cast<float>(thing.scale);
    const Eigen::Vector3d foot_m(thing.position_m.x(), thing.position_m.y(), ground_m);
    const double yaw_rad = thing.yaw_deg * kRadPerDeg;
    const Eigen::Affine3f T = transform(foot_m.cast<float>(), static_cast<float>(yaw_rad), Vector3f::Constant(scale));
    for (const std::uint32_t mesh : meshes_of(thing.kind)) scene_.place(mesh, instance, T);
    scene_.add_object({instance,
                       SurfaceClass::kObject,
                       kThingNames[static_cast<std::size_t>(thing.kind)],
                       foot_m,
                       yaw_rad,
                       {{"scale", thing.scale}}});
  }

 private:
  const std::vector<std::uint32_t>& meshes_of(ThingKind kind) {
    std::vector<std::uint32_t>& meshes = meshes_[static_cast<std::size_t>(kind)];
    if (!meshes.empty()) return meshes;
    const auto add = [&](Mesh mesh, const Material& material) {
      meshes.push_back(scene_.add_mesh(std::move(mesh), material, SurfaceClass::kObject));
    };
    Mesh mesh;
    switch (kind) {
      case ThingKind::kPost:
        add_box(mesh, {-0.2F, -0.2F, 0.0F}, {0.2F, 0.2F, 0.95F});
        add(std::move(mesh), materials::plastic_dark());
        break;
      case ThingKind::kPerson:
        for (const float side : {-0.1F, 0.1F})
          add_frustum(mesh, {0, side, 0}, 0.07F, {0, side, 0.85F}, 0.09F, kLimbSides);
        add_frustum(mesh, {0, 0, 0.85F}, 0.17F, {0, 0, 1.45F}, 0.2F, kLimbSides);
        for (const float side : {-0.25F, 0.25F})
          add_frustum(mesh, {0, side, 0.8F}, 0.05F, {0, side, 1.4F}, 0.06F, kLimbSides);
        add(std::move(mesh), materials::clothing());
        mesh = {};
        add_icosphere(mesh, {0, 0, 1.62F}, 0.13F, 2);
        add(std::move(mesh), materials::skin());
        break;
      case ThingKind::kSign:
        add_frustum(mesh, {0, 0, 0}, 0.015F, {0, 0, 1.8F}, 0.015F, kLimbSides);
        add(std::move(mesh), materials::plastic_dark());
        mesh = {};
        add_box(mesh, {-0.01F, -0.3F, 1.8F}, {0.01F, 0.3F, 2.4F});
        add(std::move(mesh), materials::retro_tape());
        break;
    }
    return meshes;
  }

  SceneBuilder& scene_;
  std::vector<std::uint32_t> meshes_[3];
};

}  // namespace

void add_clutter(SceneBuilder& scene, const ClutterConfig& config, std::uint64_t seed, const ClutterGround& ground) {
  ThingStock stock(scene);
  for (const ClutterThingConfig& thing : config.things) stock.place(thing, ground.height_m(thing.position_m));
  const std::pair<ThingKind, int> random_things[] = {{ThingKind::kPost, config.num_posts},
                                                     {ThingKind::kPerson, config.num_people},
                                                     {ThingKind::kSign, config.num_signs}};
  for (const auto& [kind, count] : random_things) {
    const Random random(seed, "world.clutter", kThingNames[static_cast<std::size_t>(kind)]);
    for (int i = 0; i < count; ++i) {
      Dice dice(random, i);
      ClutterThingConfig thing{kind, {}, dice.uniform(0.0, 360.0), dice.uniform(0.9, 1.1)};
      for (int attempt = 0; attempt < kPlacesPerThing; ++attempt) {
        // Uniform over the ring's area.
        const double inner_m2 = config.radius_min_m * config.radius_min_m;
        const double outer_m2 = config.radius_max_m * config.radius_max_m;
        const double radius_m = std::sqrt(dice.uniform(inner_m2, outer_m2)), angle_rad = dice.angle_rad();
        thing.position_m =
            config.center_m + radius_m * Vector2d(elementary::cos(angle_rad), elementary::sin(angle_rad));
        if (!ground.is_free(thing.position_m)) continue;
        stock.place(thing, ground.height_m(thing.position_m));
        break;
      }
    }
  }
}

}  // namespace swiftlet::sim
