// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/field.hpp"

#include <algorithm>
#include <cmath>

#include "sim/world/clutter.hpp"
#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/placement.hpp"
#include "sim/world/relief.hpp"
#include "sim/world/tree.hpp"
#include "sim/world/undergrowth.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;

// [-] Draws of a position for one plant; then the field counts as full.
constexpr int kTriesPerThing = 200;

// A position at least `reach_m` from every zone to keep free; empty when the field is full.
std::optional<Vector2d> find_place(const FieldConfig& config, double reach_m, Spacing& spacing, Dice& dice) {
  const Vector2d half_m = 0.5 * config.size_m;
  for (int i = 0; i < kTriesPerThing; ++i) {
    const double x_m = dice.uniform(-half_m.x(), half_m.x());
    const double y_m = dice.uniform(-half_m.y(), half_m.y());
    const Vector2d point_m(x_m, y_m);
    if (point_m.norm() < config.clear_radius_m + reach_m || config.keep_clear.distance_m(point_m) < reach_m) continue;
    if (spacing.try_add(point_m)) return point_m;
  }
  return std::nullopt;
}

void add_trees(SceneBuilder& scene, const FieldConfig& config, std::uint64_t seed, const Relief& relief,
               Spacing& spacing) {
  const TreeOptions options{
      .leaf_area_density_per_m = 0.5, .leaf_cluster_m = 0.35 / std::sqrt(config.detail), .lean_max_deg = 3.0};
  const TreeStock broadleaf(scene, Species::kBroadleaf, {0.2, 0.35, 0.5}, options,
                            Random(seed, "world.field.trees", "broadleaf"));
  const TreeStock pine(scene, Species::kPine, {0.25, 0.4}, options, Random(seed, "world.field.trees", "pine"));
  const Random random(seed, "world.field.trees", "places");
  for (int i = 0; i < config.num_trees; ++i) {
    Dice dice(random, i);
    const TreeStock& stock = dice.chance(0.7) ? broadleaf : pine;
    const double dbh_m = dice.uniform(0.2, 0.5);
    const double height_factor = dice.uniform(0.6, 0.8);  // solitary trees are lower than those in a stand
    const double yaw_rad = dice.angle_rad();
    const auto place_m = find_place(config, stock.measures(dbh_m, height_factor).crown_radius_m, spacing, dice);
    if (!place_m) continue;
    stock.place(scene, {place_m->x(), place_m->y(), relief.height_m(place_m->x(), place_m->y())}, dbh_m, height_factor,
                yaw_rad);
  }
}

void add_bushes(SceneBuilder& scene, const FieldConfig& config, std::uint64_t seed, const Relief& relief) {
  const UndergrowthStock stock(scene, config.detail, Random(seed, "world.field.bushes"));
  const Random random(seed, "world.field.bushes", "places");
  Spacing spacing(0.0);
  for (int i = 0; i < config.num_bushes; ++i) {
    Dice dice(random, i);
    const double scale = dice.uniform(0.8, 2.0);
    const auto place_m = find_place(config, stock.reach_m(UndergrowthStock::Kind::kBush, scale), spacing, dice);
    if (!place_m) continue;
    const Eigen::Vector3d foot_m(place_m->x(), place_m->y(), relief.height_m(place_m->x(), place_m->y()));
    stock.place(scene, UndergrowthStock::Kind::kBush, foot_m, scale, dice);
  }
}

}  // namespace

void FieldConfig::visit(ConfigVisitor& v) {
  v.field("size_m", size_m, "[m] extent along x and y, centered at the origin", Range::positive());
  v.object("relief", relief, "hills");
  v.field("ground_cell_m", ground_cell_m, "[m] cell size of the ground mesh where it is not flat",
          Range::between(0.1, 100.0));
  v.field("num_trees", num_trees, "[-] largest number of trees, limited by space", Range::between(0, 20000));
  v.field("min_distance_m", min_distance_m, "[m] smallest distance between two trees", Range::non_negative());
  v.field("num_bushes", num_bushes, "[-] largest number of bushes, limited by space", Range::between(0, 60000));
  v.field("clear_radius_m", clear_radius_m, "[m] radius around the origin without plants", Range::non_negative());
  v.field("detail", detail, "[-] number of leaf clusters, relative to the default", Range::between(0.05, 20.0));
  v.object("foliage", foliage, "motion of leaves in wind, visible to LiDARs");
  v.object("keep_clear", keep_clear, "zones kept free for flights");
  v.object("clutter", clutter, "posts, people and signs on the ground");
}

Scene make_field(const FieldConfig& config, std::uint64_t seed) {
  SceneBuilder scene;
  const Relief relief(config.relief, seed);
  const bool flat = config.relief.amplitude_m == 0.0;
  scene.add(make_ground(relief, flat, -0.5 * config.size_m, 0.5 * config.size_m, config.ground_cell_m),
            materials::grass(), SurfaceClass::kGround);
  Spacing spacing(config.min_distance_m);
  if (config.num_trees > 0) add_trees(scene, config, seed, relief, spacing);
  if (config.num_bushes > 0) add_bushes(scene, config, seed, relief);
  add_clutter(scene, config.clutter, seed,
              {[&](const Vector2d& p) { return relief.height_m(p.x(), p.y()); },
               [&](const Vector2d& p) { return config.keep_clear.distance_m(p) > kClutterReach_m; }});
  scene.move_foliage(config.foliage, seed);
  return scene.finish();
}

}  // namespace swiftlet::sim
