// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/forest_thesis.hpp"

#include <algorithm>

#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/placement.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3f;

// [-] Sides of a trunk, and subdivisions of the icosahedron of a crown.
constexpr int kThesisTrunkSides = 24;
constexpr int kCrownSubdivisions = 3;
// [-] Draws of a position for one tree; then the area has no room.
constexpr int kTriesPerTree = 20000;
// [m] Width of the ground around the area.
constexpr double kGroundMargin_m = 10.0;
constexpr float kThesisRootDepth_m = 0.1F;  // extends the trunk below the ground without a gap

struct ThesisTree {
  double trunk_radius_m = 0.0;
  double height_m = 0.0;
  double crown_radius_m = 0.0;
};

double draw(Dice& dice, double mean, double half_width) { return dice.uniform(mean - half_width, mean + half_width); }

ThesisTree draw_tree(const ForestThesisConfig& config, const Random& random, int i_tree) {
  Dice dice(random, i_tree);
  ThesisTree tree;
  tree.trunk_radius_m = draw(dice, config.trunk_radius_m, config.trunk_radius_spread_m);
  tree.height_m = draw(dice, config.tree_height_m, config.tree_height_spread_m);
  tree.crown_radius_m = draw(dice, config.crown_radius_m, config.crown_radius_spread_m);
  return tree;
}

// Horizontal reach of the tree into a zone to keep free up to clear_height_m.
double reach_m(const ForestThesisConfig& config, const ThesisTree& tree) {
  const bool crown_is_above = tree.height_m - tree.crown_radius_m >= config.keep_clear.clear_height_m;
  return crown_is_above ? tree.trunk_radius_m : std::max(tree.trunk_radius_m, tree.crown_radius_m);
}

Eigen::Vector2d find_place(const ForestThesisConfig& config, const ThesisTree& tree, const Random& random, int i_tree,
                           Spacing& spacing) {
  Dice dice(random, i_tree);
  for (int i = 0; i < kTriesPerTree; ++i) {
    const double x_m = dice.uniform(config.area_min_m.x(), config.area_max_m.x());
    const double y_m = dice.uniform(config.area_min_m.y(), config.area_max_m.y());
    if (config.keep_clear.distance_m({x_m, y_m}) < reach_m(config, tree)) continue;
    if (spacing.try_add({x_m, y_m})) return {x_m, y_m};
  }
  throw InputError("world forest_thesis: expected room for " + std::to_string(config.num_trees) +
                   " trees at the distance of min_distance_m, found room for " + std::to_string(i_tree));
}

}  // namespace

void ForestThesisConfig::visit(ConfigVisitor& v) {
  v.field("area_min_m", area_min_m, "[m] corner of the area with the smallest x and y");
  v.field("area_max_m", area_max_m, "[m] corner of the area with the largest x and y");
  v.field("num_trees", num_trees, "[-] number of trees", Range::between(0, 60000));
  v.field("min_distance_m", min_distance_m, "[m] smallest distance between the axes of two trunks",
          Range::non_negative());
  v.field("trunk_radius_m", trunk_radius_m, "[m] mean radius of the trunks", Range::positive());
  v.field("trunk_radius_spread_m", trunk_radius_spread_m, "[m] half-width of the uniform distribution of that radius",
          Range::non_negative());
  v.field("tree_height_m", tree_height_m, "[m] mean height of the trunks, and of the centers of the crowns",
          Range::positive());
  v.field("tree_height_spread_m", tree_height_spread_m, "[m] half-width of the uniform distribution of that height",
          Range::non_negative());
  v.field("crown_radius_m", crown_radius_m, "[m] mean radius of the crowns", Range::positive());
  v.field("crown_radius_spread_m", crown_radius_spread_m, "[m] half-width of the uniform distribution of that radius",
          Range::non_negative());
  v.object("keep_clear", keep_clear, "zones kept free for flights");
  v.check(area_max_m.x() > area_min_m.x() && area_max_m.y() > area_min_m.y(), "area_max_m", "more than area_min_m");
  v.check(trunk_radius_m > trunk_radius_spread_m, "trunk_radius_spread_m",
          "a spread that leaves every radius positive");
  v.check(tree_height_m > tree_height_spread_m, "tree_height_spread_m", "a spread that leaves every height positive");
  v.check(crown_radius_m > crown_radius_spread_m, "crown_radius_spread_m",
          "a spread that leaves every radius positive");
}

Scene make_forest_thesis(const ForestThesisConfig& config, std::uint64_t seed) {
  const Random trees(seed, "world.forest_thesis.trees");
  const Random places(seed, "world.forest_thesis.places");
  SceneBuilder scene;

  Mesh ground;
  const Eigen::Vector2f low = (config.area_min_m.array() - kGroundMargin_m).cast<float>();
  const Eigen::Vector2f high = (config.area_max_m.array() + kGroundMargin_m).cast<float>();
  add_quad(ground, {low.x(), low.y(), 0}, {high.x(), low.y(), 0}, {high.x(), high.y(), 0}, {low.x(), high.y(), 0});
  scene.add(std::move(ground), materials::forest_floor(), SurfaceClass::kGround);

  // One cylinder and one sphere, scaled for each tree.
  Mesh cylinder;
  add_frustum(cylinder, Vector3f::Zero(), 1.0F, Vector3f::UnitZ(), 1.0F, kThesisTrunkSides);
  Mesh sphere;
  add_icosphere(sphere, Vector3f::Zero(), 1.0F, kCrownSubdivisions);
  const std::uint32_t trunk = scene.add_mesh(std::move(cylinder), materials::bark_pine(), SurfaceClass::kTrunk);
  const std::uint32_t crown = scene.add_mesh(std::move(sphere), materials::leaves(), SurfaceClass::kVegetation);

  Spacing spacing(config.min_distance_m);
  for (int i = 0; i < config.num_trees; ++i) {
    const ThesisTree tree = draw_tree(config, trees, i);
    const Eigen::Vector2d place_m = find_place(config, tree, places, i, spacing);
    const Eigen::Vector2f xy = place_m.cast<float>();
    const auto radius = static_cast<float>(tree.trunk_radius_m);
    const auto height = static_cast<float>(tree.height_m);
    const auto crown_radius = static_cast<float>(tree.crown_radius_m);
    const std::uint16_t instance = scene.next_instance(SurfaceClass::kTrunk);
    scene.place(trunk, instance,
                transform({xy.x(), xy.y(), -kThesisRootDepth_m}, 0.0F, {radius, radius, height + kThesisRootDepth_m}));
    scene.place(crown, instance, transform({xy.x(), xy.y(), height}, 0.0F, Vector3f::Constant(crown_radius)));
    scene.add_object({instance,
                      SurfaceClass::kTrunk,
                      "thesis_tree",
                      {place_m.x(), place_m.y(), 0.0},
                      0.0,
                      {{"dbh_m", 2.0 * tree.trunk_radius_m},
                       {"height_m", tree.height_m},
                       {"crown_base_m", tree.height_m - tree.crown_radius_m},
                       {"crown_radius_m", tree.crown_radius_m}}});
  }
  return scene.finish();
}

}  // namespace swiftlet::sim
