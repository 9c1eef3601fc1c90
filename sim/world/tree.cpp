// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/tree.hpp"

#include <algorithm>
#include <cmath>

#include "sim/world/materials.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// [m] Height at which foresters measure the diameter of a trunk.
constexpr double kBreastHeight_m = 1.3;
constexpr double kRootDepth_m = 0.3;  // extends the trunk below the ground, so that slopes leave no gap
// [-] Sides of a trunk, and rings along the trunk.
constexpr int kTrunkSides = 10;
constexpr int kTrunkRings = 10;

struct SpeciesLaw {
  const char* name;
  double michailow_a_m, michailow_b_m;          // height curve; typical of central European stands
  double crown_length_ratio;                    // crown length / height
  double crown_radius_m, crown_radius_per_dbh;  // largest radius = first + second * dbh
  Material (*bark)();
  Material (*foliage)();
};

const SpeciesLaw& law_of(Species species) {
  static const SpeciesLaw kPine = {"pine", 29.0, 0.095, 0.40, 0.7, 4.5, materials::bark_pine, materials::needles_pine};
  static const SpeciesLaw kSpruce = {
      "spruce", 33.0, 0.105, 0.72, 0.8, 4.0, materials::bark_spruce, materials::needles_spruce};
  static const SpeciesLaw kBroadleaf = {"broadleaf",      28.0, 0.080, 0.55, 1.0, 7.0, materials::bark_broadleaf,
                                        materials::leaves};
  switch (species) {
    case Species::kPine:
      return kPine;
    case Species::kSpruce:
      return kSpruce;
    case Species::kBroadleaf:
      return kBroadleaf;
  }
  return kPine;
}

Vector3d axis_point(const Crown& crown, double z_m) { return {crown.lean_x * z_m, crown.lean_y * z_m, z_m}; }

Mesh make_trunk(const Tree& tree, bool is_far) {
  const int sides = is_far ? 5 : kTrunkSides;
  const int rings = is_far ? 6 : kTrunkRings;
  std::vector<Vector3f> points_m;
  std::vector<float> radii_m;
  const auto add_ring = [&](double z_m, double radius_m) {
    points_m.push_back(axis_point(tree.crown, z_m).cast<float>());
    radii_m.push_back(static_cast<float>(std::max(radius_m, 0.005)));
  };
  add_ring(-kRootDepth_m, 1.25 * trunk_radius_m(tree.dbh_m, tree.height_m, 0.0));
  // A ring at breast height, so that the diameter there equals that in the stem map.
  for (const double z_m : {0.0, 0.35, kBreastHeight_m}) add_ring(z_m, trunk_radius_m(tree.dbh_m, tree.height_m, z_m));
  for (int i = 1; i <= rings - 4; ++i) {
    const double z_m = kBreastHeight_m + (tree.height_m - kBreastHeight_m) * i / (rings - 4.0);
    add_ring(z_m, trunk_radius_m(tree.dbh_m, tree.height_m, z_m));
  }
  Mesh mesh;
  add_tube(mesh, points_m, radii_m, sides, Caps::kBoth);
  return mesh;
}

struct Branch {
  Vector3d from_m, to_m;
  double radius_m = 0.01;
};

void add_branch(Mesh& mesh, const Branch& branch, double bend_m, int sides) {
  const Vector3d middle_m = 0.5 * (branch.from_m + branch.to_m) + Vector3d(0, 0, bend_m);
  const std::array<Vector3f, 3> points_m = {branch.from_m.cast<float>(), middle_m.cast<float>(),
                                            branch.to_m.cast<float>()};
  const auto radius_m = static_cast<float>(branch.radius_m);
  const std::array<float, 3> radii_m = {radius_m, 0.6F * radius_m, 0.2F * radius_m};
  add_tube(mesh, points_m, radii_m, sides, Caps::kEnd);
}

// Conifers: rings of branches around the trunk. Spruce branches hang, pine branches rise.
Mesh make_whorls(const Tree& tree, Dice& dice) {
  const bool is_spruce = tree.species == Species::kSpruce;
  const double spacing_m = is_spruce ? 0.75 : 0.9;
  Mesh mesh;
  for (double z_m = tree.crown.base_m + 0.2; z_m < tree.crown.top_m - 0.6; z_m += spacing_m * dice.uniform(0.8, 1.2)) {
    const int count = 4 + dice.pick(2);
    const double turn_rad = dice.angle_rad();
    for (int i = 0; i < count; ++i) {
      const double angle_rad = turn_rad + 2.0 * std::numbers::pi * (i + dice.uniform(-0.2, 0.2)) / count;
      const double length_m = 0.92 * dice.uniform(0.75, 1.0) * tree.crown.outer_radius_m(z_m);
      const double rise_m = length_m * (is_spruce ? dice.uniform(-0.25, 0.0) : dice.uniform(0.05, 0.35));
      const Vector3d from_m = axis_point(tree.crown, z_m);
      const Vector3d to_m =
          from_m + Vector3d(length_m * elementary::cos(angle_rad), length_m * elementary::sin(angle_rad), rise_m);
      const double thickness_m =
          std::min(0.012 + 0.012 * length_m, 0.8 * trunk_radius_m(tree.dbh_m, tree.height_m, z_m));
      add_branch(mesh, {from_m, to_m, thickness_m}, (is_spruce ? 0.04 : -0.04) * length_m, 4);
    }
  }
  // Dead stubs below a pine's crown.
  for (int i = 0; !is_spruce && i < 8; ++i) {
    const double z_m = tree.crown.base_m * dice.uniform(0.45, 0.98);
    const double angle_rad = dice.angle_rad();
    const double length_m = trunk_radius_m(tree.dbh_m, tree.height_m, z_m) + dice.uniform(0.15, 0.6);
    const Vector3d from_m = axis_point(tree.crown, z_m);
    add_branch(
        mesh,
        {from_m, from_m + Vector3d(length_m * elementary::cos(angle_rad), length_m * elementary::sin(angle_rad), -0.05),
         0.012},
        0.0, 3);
  }
  return mesh;
}

// Broadleaf trees: rising boughs with forks.
Mesh make_boughs(const Tree& tree, Dice& dice) {
  const Crown& crown = tree.crown;
  const double length_m = crown.top_m - crown.base_m;
  Mesh mesh;
  for (int i = 0; i < 13; ++i) {
    const double z_m = crown.base_m + length_m * (0.02 + 0.7 * i / 12.0) * dice.uniform(0.95, 1.0);
    const double angle_rad = 2.399963 * i + dice.uniform(-0.3, 0.3);  // golden angle
    const double top_z_m = std::min(z_m + length_m * dice.uniform(0.12, 0.25), crown.top_m - 0.1 * length_m);
    const double reach_m = 0.88 * dice.uniform(0.8, 1.0) * crown.outer_radius_m(top_z_m);
    const Vector3d from_m = axis_point(crown, z_m);
    const Vector3d to_m =
        axis_point(crown, top_z_m) + reach_m * Vector3d(elementary::cos(angle_rad), elementary::sin(angle_rad), 0);
    const double radius_m = std::min(0.02 + 0.015 * reach_m, 0.7 * trunk_radius_m(tree.dbh_m, tree.height_m, z_m));
    add_branch(mesh, {from_m, to_m, radius_m}, -0.06 * reach_m, 5);
    for (int fork = 0; fork < 4; ++fork) {
      const double along = dice.uniform(0.35, 0.85);
      const Vector3d start_m =
          from_m + along * (to_m - from_m) - Vector3d(0, 0, 0.12 * reach_m * std::min(along, 1.0 - along));
      Vector3d end_m = start_m + 0.45 * reach_m * dice.direction().cast<double>();
      end_m.z() += 0.15 * reach_m;
      if (!crown.contains(end_m)) continue;
      add_branch(mesh, {start_m, end_m, 0.4 * radius_m}, 0.0, 3);
    }
  }
  return mesh;
}

// One leaf cluster: a triangle (needles) or a rhombus (leaves) with the given area and random orientation.
void add_leaf(Mesh& mesh, const Vector3f& center_m, float size_m, bool is_rhombus, Dice& dice) {
  const Vector3f normal = dice.direction();
  const auto turn = Eigen::AngleAxisf(static_cast<float>(dice.angle_rad()), normal);
  const Vector3f along = turn * normal.unitOrthogonal();
  const Vector3f across = normal.cross(along);
  if (is_rhombus) {
    add_quad(mesh, center_m + 0.5F * size_m * along, center_m + 0.4F * size_m * across,
             center_m - 0.5F * size_m * along, center_m - 0.4F * size_m * across);
  } else {
    add_triangle(mesh, center_m + 2.0F / 3.0F * size_m * along,
                 center_m - 1.0F / 3.0F * size_m * along + 0.4F * size_m * across,
                 center_m - 1.0F / 3.0F * size_m * along - 0.4F * size_m * across);
  }
}

double crown_volume_m3(const Crown& crown) {
  // [-] Slices of a crown in the integral of its volume.
  constexpr int kSlices = 400;
  const double slice_m = (crown.top_m - crown.base_m) / kSlices;
  double volume_m3 = 0.0;
  for (int i = 0; i < kSlices; ++i) {
    const double z_m = crown.base_m + (i + 0.5) * slice_m;
    const double outer_m = crown.outer_radius_m(z_m);
    const double inner_m = crown.inner_radius_m(z_m);
    volume_m3 += std::numbers::pi * (outer_m * outer_m - inner_m * inner_m) * slice_m;
  }
  return volume_m3;
}

Mesh make_leaves(const Crown& crown, const TreeOptions& options, Dice& dice) {
  const bool is_rhombus = crown.species == Species::kBroadleaf;
  const auto size_m = static_cast<float>(options.leaf_cluster_m);
  const double area_of_one_m2 = 0.4 * size_m * size_m;  // for both shapes
  const auto count =
      static_cast<int>(std::lround(options.leaf_area_density_per_m * crown_volume_m3(crown) / area_of_one_m2));
  Mesh mesh;
  for (int i = 0; i < count;) {
    const double z_m = dice.uniform(crown.base_m, crown.top_m);
    const double x_m = dice.uniform(-crown.radius_m, crown.radius_m);
    const double y_m = dice.uniform(-crown.radius_m, crown.radius_m);
    const Vector3d point_tree_m = axis_point(crown, z_m) + Vector3d(x_m, y_m, 0);
    if (!crown.contains(point_tree_m)) continue;
    add_leaf(mesh, point_tree_m.cast<float>(), size_m, is_rhombus, dice);
    ++i;
  }
  return mesh;
}

}  // namespace

const char* name_of(Species species) { return law_of(species).name; }

double height_by_diameter_m(Species species, double dbh_m) {
  const SpeciesLaw& law = law_of(species);
  return kBreastHeight_m + law.michailow_a_m * elementary::exp(-law.michailow_b_m / dbh_m);
}

double trunk_radius_m(double dbh_m, double height_m, double z_m) {
  const double above = std::clamp((height_m - z_m) / (height_m - kBreastHeight_m), 0.0, 2.0);
  const double butt_swell = 0.35 * elementary::exp(-z_m / 0.25) - 0.35 * elementary::exp(-kBreastHeight_m / 0.25);
  return 0.5 * dbh_m * (elementary::pow(above, 0.8) + std::max(butt_swell, 0.0) * (z_m < kBreastHeight_m ? 1.0 : 0.0));
}

double Crown::outer_radius_m(double z_m) const {
  const double t = std::clamp((z_m - base_m) / (top_m - base_m), 0.0, 1.0);
  switch (species) {
    case Species::kSpruce:
      return radius_m * std::min(t / 0.08, (1.0 - t) / 0.92);  // cone
    case Species::kPine:
      return radius_m * elementary::pow(elementary::sin(std::numbers::pi * elementary::pow(t, 0.8)), 0.6);  // dome
    case Species::kBroadleaf:
      return radius_m * std::sqrt(std::max(0.0, 1.0 - (2.0 * t - 1.0) * (2.0 * t - 1.0)));  // ellipsoid
  }
  return 0.0;
}

double Crown::inner_radius_m(double z_m) const {
  return (species == Species::kBroadleaf ? 0.35 : 0.2) * outer_radius_m(z_m);
}

bool Crown::contains(const Vector3d& point_tree_m) const {
  if (point_tree_m.z() < base_m || point_tree_m.z() > top_m) return false;
  const double radius = (point_tree_m - axis_point(*this, point_tree_m.z())).norm();
  return radius <= outer_radius_m(point_tree_m.z()) && radius >= inner_radius_m(point_tree_m.z());
}

Tree make_tree(Species species, double dbh_m, const TreeOptions& options, Dice dice) {
  const SpeciesLaw& law = law_of(species);
  const double lean = elementary::tan(radians(dice.uniform(0.0, options.lean_max_deg)));
  const double lean_direction_rad = dice.angle_rad();
  Tree tree;
  tree.species = species;
  tree.dbh_m = dbh_m;
  tree.height_m = height_by_diameter_m(species, dbh_m);
  tree.crown.species = species;
  tree.crown.top_m = tree.height_m;
  tree.crown.base_m = tree.height_m * (1.0 - law.crown_length_ratio * dice.uniform(0.9, 1.1));
  tree.crown.radius_m = (law.crown_radius_m + law.crown_radius_per_dbh * dbh_m) * dice.uniform(0.9, 1.1);
  tree.crown.lean_x = lean * elementary::cos(lean_direction_rad);
  tree.crown.lean_y = lean * elementary::sin(lean_direction_rad);
  tree.trunk = make_trunk(tree, options.is_far);
  if (!options.is_far)
    tree.branches = species == Species::kBroadleaf ? make_boughs(tree, dice) : make_whorls(tree, dice);
  tree.leaves = make_leaves(tree.crown, options, dice);
  return tree;
}

TreeStock::TreeStock(SceneBuilder& scene, Species species, std::vector<double> dbh_m, const TreeOptions& options,
                     const Random& random)
    : species_(species) {
  const SpeciesLaw& law = law_of(species);
  for (std::size_t i = 0; i < dbh_m.size(); ++i) {
    Tree tree = make_tree(species, dbh_m[i], options, Dice(random, static_cast<std::uint32_t>(i)));
    Kind kind;
    kind.dbh_m = tree.dbh_m;
    kind.height_m = tree.height_m;
    kind.crown_radius_m = tree.crown.radius_m;
    // Branches and leaf clusters protrude slightly from the crown's body; the truth uses their actual extent.
    kind.crown_base_m = std::min<double>(tree.crown.base_m, bounds_m(tree.leaves).min().z());
    for (const Mesh* mesh : {&tree.trunk, &tree.branches, &tree.leaves}) {
      for (const Vector3f& vertex : mesh->vertices_mesh_m)
        kind.reach_m = std::max<double>(kind.reach_m, vertex.head<2>().norm());
    }
    kind.trunk = scene.add_mesh(std::move(tree.trunk), law.bark(), SurfaceClass::kTrunk);
    kind.branches = scene.add_mesh(std::move(tree.branches), law.bark(), SurfaceClass::kBranch);
    kind.leaves = scene.add_mesh(std::move(tree.leaves), law.foliage(), SurfaceClass::kVegetation);
    kinds_.push_back(kind);
  }
}

const TreeStock::Kind& TreeStock::nearest(double dbh_m) const {
  return *std::min_element(kinds_.begin(), kinds_.end(), [&](const Kind& a, const Kind& b) {
    return std::abs(a.dbh_m - dbh_m) < std::abs(b.dbh_m - dbh_m);
  });
}

// Scale that gives the trunk its diameter at 1.3 m above ground, which is another height in the unscaled tree.
double TreeStock::horizontal_scale(const Kind& kind, double dbh_m, double vertical_scale) const {
  return 0.5 * dbh_m / trunk_radius_m(kind.dbh_m, kind.height_m, kBreastHeight_m / vertical_scale);
}

TreeStock::Measures TreeStock::measures(double dbh_m, double height_factor) const {
  const Kind& kind = nearest(dbh_m);
  const double height_m = height_factor * height_by_diameter_m(species_, dbh_m);
  const double vertical = height_m / kind.height_m;
  return {height_m, vertical * kind.crown_base_m, horizontal_scale(kind, dbh_m, vertical) * kind.reach_m};
}

void TreeStock::place_meshes(SceneBuilder& scene, std::uint16_t instance, const Vector3d& foot_world_m, double dbh_m,
                             double height_factor, double yaw_rad) const {
  const Kind& kind = nearest(dbh_m);
  const double vertical = height_factor * height_by_diameter_m(species_, dbh_m) / kind.height_m;
  const double horizontal = horizontal_scale(kind, dbh_m, vertical);
  const Vector3f scale = Vector3d(horizontal, horizontal, vertical).cast<float>();
  const Eigen::Affine3f T_world_tree = transform(foot_world_m.cast<float>(), static_cast<float>(yaw_rad), scale);
  for (const std::uint32_t mesh : {kind.trunk, kind.branches, kind.leaves}) scene.place(mesh, instance, T_world_tree);
}

void TreeStock::place_nameless(SceneBuilder& scene, const Vector3d& foot_world_m, double dbh_m, double height_factor,
                               double yaw_rad) const {
  place_meshes(scene, 0, foot_world_m, dbh_m, height_factor, yaw_rad);
}

void TreeStock::place(SceneBuilder& scene, const Vector3d& foot_world_m, double dbh_m, double height_factor,
                      double yaw_rad) const {
  const std::uint16_t instance = scene.next_instance(SurfaceClass::kTrunk);
  place_meshes(scene, instance, foot_world_m, dbh_m, height_factor, yaw_rad);
  const Kind& kind = nearest(dbh_m);
  const double height_m = height_factor * height_by_diameter_m(species_, dbh_m);
  const double vertical = height_m / kind.height_m;
  const double horizontal = horizontal_scale(kind, dbh_m, vertical);
  scene.add_object({instance,
                    SurfaceClass::kTrunk,
                    name_of(species_),
                    foot_world_m,
                    yaw_rad,
                    {{"dbh_m", dbh_m},
                     {"height_m", height_m},
                     {"crown_base_m", vertical * kind.crown_base_m},
                     {"crown_radius_m", horizontal * kind.crown_radius_m}}});
}

}  // namespace swiftlet::sim
