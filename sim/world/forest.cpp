// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/forest.hpp"

#include <algorithm>
#include <cmath>

#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/placement.hpp"
#include "sim/world/relief.hpp"
#include "sim/world/tree.hpp"
#include "sim/world/undergrowth.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// [-] Draws of a position for one stem; then the forest has no room.
constexpr int kAttemptsPerStem = 1000;
// [-] Relative standard deviation of the height of a tree about the curve of its species.
constexpr double kHeightScatter = 0.07;
// [-] Shape of the Weibull distribution of diameters. Larger values make the diameters more alike.
constexpr double kDiameterShape = 2.2;
constexpr int kNumSpecies = 3;
const double kLeafCluster_m = 0.28 / std::sqrt(2.0);

struct Stem {
  Vector2d place_m;
  double dbh_m = 0.0;
  double height_factor = 1.0;
  double yaw_rad = 0.0;
  Species species = Species::kPine;
};

double area_ha(const ForestConfig& config) { return config.size_m.prod() / 1e4; }

int count_of(const ForestConfig& config, double per_ha) {
  return static_cast<int>(std::lround(per_ha * area_ha(config)));
}

Vector3d on_ground(const Relief& relief, const Vector2d& p) { return {p.x(), p.y(), relief.height_m(p.x(), p.y())}; }

double weibull_quantile(const ForestConfig& config, double probability) {
  return config.dbh_min_m +
         config.dbh_scale_m * elementary::pow(-elementary::log(1.0 - probability), 1.0 / kDiameterShape);
}

Vector2d draw_place(const ForestConfig& config, Dice& dice) {
  const double x_m = dice.uniform(-0.5, 0.5) * config.size_m.x();
  const double y_m = dice.uniform(-0.5, 0.5) * config.size_m.y();
  return {x_m, y_m};
}

Species draw_species(const ForestConfig& config, Dice& dice) {
  const double sum = config.pine_share + config.spruce_share + config.broadleaf_share;
  const double draw = dice.uniform(0.0, sum);
  if (draw < config.pine_share) return Species::kPine;
  return draw < config.pine_share + config.spruce_share ? Species::kSpruce : Species::kBroadleaf;
}

/// Draws all properties of a stem except its position.
Stem draw_stem(const ForestConfig& config, Dice& dice) {
  Stem stem;
  stem.species = draw_species(config, dice);
  stem.dbh_m = weibull_quantile(config, dice.uniform());
  stem.height_factor = 1.0 + kHeightScatter * std::clamp(dice.normal(), -2.5, 2.5);
  stem.yaw_rad = dice.angle_rad();
  return stem;
}

std::vector<Stem> draw_stems(const ForestConfig& config, std::uint64_t seed) {
  const Random random(seed, "world.forest.stems");
  Spacing spacing(config.min_spacing_m);
  std::vector<Stem> stems(count_of(config, config.stems_per_ha));
  for (std::size_t i = 0; i < stems.size(); ++i) {
    Dice dice(random, static_cast<std::uint32_t>(i));
    Stem& stem = stems[i];
    stem = draw_stem(config, dice);
    int attempt = 0;
    do {
      if (++attempt > kAttemptsPerStem) {
        throw InputError("world forest: expected room for " + std::to_string(stems.size()) +
                         " stems at the distance of min_spacing_m, found room for " + std::to_string(i));
      }
      stem.place_m = draw_place(config, dice);
    } while (!spacing.try_add(stem.place_m));
  }
  return stems;
}

TreeOptions tree_options(const ForestConfig& config) {
  return {.leaf_area_density_per_m = config.leaf_area_density_per_m,
          .leaf_cluster_m = kLeafCluster_m / std::sqrt(config.detail),
          .lean_max_deg = config.lean_max_deg};
}

// Each species has trees at evenly spaced quantiles of the diameters.
TreeStock make_stock(SceneBuilder& scene, const ForestConfig& config, Species species, const TreeOptions& options,
                     std::uint64_t seed, const char* purpose) {
  std::vector<double> dbh_m(config.variants);
  for (int i = 0; i < config.variants; ++i) dbh_m[i] = weibull_quantile(config, (i + 0.5) / config.variants);
  return {scene, species, dbh_m, options, Random(seed, purpose, name_of(species))};
}

void add_trees(SceneBuilder& scene, const ForestConfig& config, std::uint64_t seed, const Relief& relief) {
  const auto stock_of = [&](Species species) {
    return make_stock(scene, config, species, tree_options(config), seed, "world.forest.stock");
  };
  const TreeStock stocks[] = {stock_of(Species::kPine), stock_of(Species::kSpruce), stock_of(Species::kBroadleaf)};
  // Upper limit of the free zones, above the highest possible ground.
  const double clear_top_m = config.relief.amplitude_m + config.keep_clear.clear_height_m;
  for (const Stem& stem : draw_stems(config, seed)) {
    const TreeStock& stock = stocks[static_cast<int>(stem.species)];
    const TreeStock::Measures tree = stock.measures(stem.dbh_m, stem.height_factor);
    const Vector3d foot_m = on_ground(relief, stem.place_m);
    const bool crown_is_above = foot_m.z() + tree.crown_base_m >= clear_top_m;
    const double trunk_reach_m = stem.dbh_m + 1.0 + elementary::tan(radians(config.lean_max_deg)) * tree.height_m;
    const double reach_m = crown_is_above ? std::min(trunk_reach_m, tree.crown_radius_m) : tree.crown_radius_m;
    if (config.keep_clear.distance_m(stem.place_m) < reach_m) continue;
    stock.place(scene, foot_m, stem.dbh_m, stem.height_factor, stem.yaw_rad);
  }
}

void add_undergrowth(SceneBuilder& scene, const ForestConfig& config, std::uint64_t seed, const Relief& relief) {
  using Kind = UndergrowthStock::Kind;
  const UndergrowthStock stock(scene, config.detail, Random(seed, "world.forest.undergrowth", "stock"));
  const auto scatter = [&](Kind kind, double per_ha, double scale_min, double scale_max, const char* entity) {
    const Random random(seed, "world.forest.undergrowth", entity);
    for (int i = 0; i < count_of(config, per_ha); ++i) {
      Dice dice(random, i);
      const Vector2d place_m = draw_place(config, dice);
      const double scale = dice.uniform(scale_min, scale_max);
      if (config.keep_clear.distance_m(place_m) < stock.reach_m(kind, scale)) continue;
      stock.place(scene, kind, on_ground(relief, place_m), scale, dice);
    }
  };
  scatter(Kind::kBush, config.bushes_per_ha, 0.6, 1.6, "bushes");
  scatter(Kind::kGrass, config.grass_per_ha, 0.7, 1.5, "grass");
}

// Trunks lying on the ground, with stubs of broken branches.
void add_fallen_trunks(SceneBuilder& scene, const ForestConfig& config, std::uint64_t seed, const Relief& relief) {
  constexpr int kRings = 6;
  // [m] Longest stub of a broken branch.
  constexpr double kSnag_m = 0.5;
  const Random random(seed, "world.forest.fallen");
  for (int i = 0; i < count_of(config, config.fallen_per_ha); ++i) {
    Dice dice(random, i);
    const Vector2d foot_m = draw_place(config, dice);
    const double yaw_rad = dice.angle_rad();
    const double length_m = dice.uniform(4.0, 12.0);
    const double radius_m = dice.uniform(0.08, 0.22);
    const Vector2d along(elementary::cos(yaw_rad), elementary::sin(yaw_rad));
    const Vector2d half_m = 0.5 * config.size_m;
    const Vector2d tip_m = (foot_m + length_m * along).cwiseMax(-half_m).cwiseMin(half_m);

    Mesh mesh;
    std::vector<Vector3f> points_m;
    std::vector<float> radii_m;
    bool is_clear = true;
    for (int ring = 0; ring < kRings; ++ring) {
      const double t = ring / (kRings - 1.0);
      const Vector2d p = foot_m + t * (tip_m - foot_m);
      const double radius_here_m = radius_m * (1.0 - 0.6 * t);
      is_clear = is_clear && config.keep_clear.distance_m(p) > 0.5 * length_m / (kRings - 1) + radius_m + kSnag_m;
      points_m.push_back((on_ground(relief, p) + Vector3d(0, 0, 0.7 * radius_here_m)).cast<float>());
      radii_m.push_back(static_cast<float>(radius_here_m));
    }
    if (!is_clear || (tip_m - foot_m).norm() < 1.0) continue;
    add_tube(mesh, points_m, radii_m, 8, Caps::kBoth);
    for (int snag = 0; snag < 6; ++snag) {
      const int ring = 1 + dice.pick(kRings - 1);
      Vector3f direction = dice.direction();
      direction.z() = std::abs(direction.z());
      const auto snag_m = static_cast<float>(kSnag_m * dice.uniform(0.4, 0.95));
      add_frustum(mesh, points_m[ring], 0.03F, points_m[ring] + (snag_m + radii_m[ring]) * direction, 0.012F, 4,
                  Caps::kEnd);
    }
    const std::uint16_t instance = scene.next_instance(SurfaceClass::kFallenTrunk);
    scene.add(std::move(mesh), materials::dead_wood(), SurfaceClass::kFallenTrunk, instance);
    scene.add_object({instance,
                      SurfaceClass::kFallenTrunk,
                      "fallen_trunk",
                      on_ground(relief, foot_m),
                      yaw_rad,
                      {{"length_m", (tip_m - foot_m).norm()}, {"diameter_m", 2.0 * radius_m}}});
  }
}

// Half-buried spheres with random dents.
void add_rocks(SceneBuilder& scene, const ForestConfig& config, std::uint64_t seed, const Relief& relief) {
  const Random random(seed, "world.forest.rocks");
  for (int i = 0; i < count_of(config, config.rocks_per_ha); ++i) {
    Dice dice(random, i);
    const Vector2d place_m = draw_place(config, dice);
    const double radius_m = dice.uniform(0.15, 0.6);
    // Sequential draws: the evaluation order of function arguments is unspecified.
    const auto height_m = static_cast<float>(radius_m * dice.uniform(0.5, 0.9));
    const auto depth_m = static_cast<float>(radius_m * dice.uniform(0.8, 1.2));
    const auto width_m = static_cast<float>(radius_m * dice.uniform(0.8, 1.2));
    const Vector3f scale(width_m, depth_m, height_m);
    Mesh mesh;
    add_icosphere(mesh, Vector3f::Zero(), 1.0F, 1);
    const Vector3d foot_m = on_ground(relief, place_m);
    for (Vector3f& vertex : mesh.vertices_mesh_m) {
      vertex *= static_cast<float>(dice.uniform(0.85, 1.1));
      vertex = vertex.cwiseProduct(scale) + foot_m.cast<float>();
    }
    if (config.keep_clear.distance_m(place_m) < 1.4 * radius_m) continue;
    const std::uint16_t instance = scene.next_instance(SurfaceClass::kObject);
    scene.add(std::move(mesh), materials::rock(), SurfaceClass::kObject, instance);
    scene.add_object({instance, SurfaceClass::kObject, "rock", foot_m, 0.0, {{"radius_m", radius_m}}});
  }
}

/// Distant trees with few triangles; two stocks, because leaf clusters of a meter are visible as such from near.
void add_far_trees(SceneBuilder& scene, const ForestConfig& config, std::uint64_t seed, const Relief& relief) {
  constexpr double kNear_m = 12.0;  // distance from the edge
  // [m] Size of leaf clusters near the edge, and farther out.
  constexpr double kLeaves_m[] = {0.9, 2.0};
  std::vector<TreeStock> stocks;
  stocks.reserve(2 * kNumSpecies);
  for (const double leaves_m : kLeaves_m) {
    for (const Species species : {Species::kPine, Species::kSpruce, Species::kBroadleaf}) {
      TreeOptions options = tree_options(config);
      options.leaf_cluster_m = std::max(leaves_m, options.leaf_cluster_m);
      options.is_far = true;
      stocks.push_back(make_stock(scene, config, species, options, seed, "world.forest.far"));
    }
  }
  const Vector2d half_m = 0.5 * config.size_m, outer_m = half_m.array() + config.surroundings_m;
  const double area_ha = 4.0 * (outer_m.prod() - half_m.prod()) / 1e4;
  const Random random(seed, "world.forest.far.stems");
  Spacing spacing(config.min_spacing_m);
  for (int i = 0; i < static_cast<int>(std::lround(config.stems_per_ha * area_ha)); ++i) {
    Dice dice(random, static_cast<std::uint32_t>(i));
    Stem stem = draw_stem(config, dice);
    double beyond_m = 0.0;
    bool has_room = false;
    for (int attempt = 0; attempt < kAttemptsPerStem && !has_room; ++attempt) {
      const double x_m = dice.uniform(-1.0, 1.0) * outer_m.x();
      stem.place_m = {x_m, dice.uniform(-1.0, 1.0) * outer_m.y()};
      beyond_m = (stem.place_m.cwiseAbs() - half_m).maxCoeff();
      // No trunk is nearer to the area than the spacing.
      has_room = beyond_m >= config.min_spacing_m && spacing.try_add(stem.place_m);
    }
    if (!has_room) break;
    const TreeStock& stock = stocks[static_cast<int>(stem.species) + (beyond_m < kNear_m ? 0 : kNumSpecies)];
    const TreeStock::Measures tree = stock.measures(stem.dbh_m, stem.height_factor);
    if (config.keep_clear.distance_m(stem.place_m) < tree.crown_radius_m) continue;
    stock.place_nameless(scene, on_ground(relief, stem.place_m), stem.dbh_m, stem.height_factor, stem.yaw_rad);
  }
}

void add_surroundings(SceneBuilder& scene, const ForestConfig& config, std::uint64_t seed, const Relief& relief,
                      bool is_flat) {
  scene.begin_surroundings();
  scene.add(make_ground_around(relief, is_flat, -0.5 * config.size_m, 0.5 * config.size_m, config.ground_cell_m,
                               2.0 * config.surroundings_m),
            materials::forest_floor(), SurfaceClass::kGround);
  add_far_trees(scene, config, seed, relief);
}

}  // namespace

void ForestConfig::visit(ConfigVisitor& v) {
  v.field("size_m", size_m, "[m] extent along x and y, centered at the origin", Range::between(1.0, 2000.0));
  v.object("relief", relief, "hills");
  v.field("ground_cell_m", ground_cell_m, "[m] cell size of the ground mesh", Range::between(0.1, 100.0));
  v.field("stems_per_ha", stems_per_ha, "[1/ha] trees before trails and clearings are cut",
          Range::between(0.0, 20000.0));
  v.field("min_spacing_m", min_spacing_m, "[m] smallest distance between the axes of two trunks",
          Range::non_negative());
  v.field("dbh_min_m", dbh_min_m, "[m] location of the Weibull distribution of diameters at breast height",
          Range::between(0.03, 1.0));
  v.field("dbh_scale_m", dbh_scale_m, "[m] scale of the Weibull distribution of diameters", Range::positive());
  v.field("pine_share", pine_share, "[-] weight in the mixture: high crowns on bare trunks", Range::non_negative());
  v.field("spruce_share", spruce_share, "[-] weight in the mixture: cones nearly down to the ground",
          Range::non_negative());
  v.field("broadleaf_share", broadleaf_share, "[-] weight in the mixture: wide crowns on forked boughs",
          Range::non_negative());
  v.field("leaf_area_density_per_m", leaf_area_density_per_m,
          "[m^2/m^3] one-sided leaf area in a volume of crown; a ray passes a crown of depth s with probability "
          "exp(-density s / 2)",
          Range::between(0.0, 10.0));
  v.field("variants", variants, "[-] distinct trees per species; all other trees are scaled and rotated copies",
          Range::between(1, 200));
  v.field("bushes_per_ha", bushes_per_ha, "[1/ha]", Range::non_negative());
  v.field("grass_per_ha", grass_per_ha, "[1/ha] clumps of grass", Range::non_negative());
  v.field("fallen_per_ha", fallen_per_ha, "[1/ha] fallen trunks", Range::non_negative());
  v.field("rocks_per_ha", rocks_per_ha, "[1/ha]", Range::non_negative());
  v.field("detail", detail, "[-] number of leaf clusters, relative to the default; the leaf area stays",
          Range::between(0.05, 20.0));
  v.field("surroundings_m", surroundings_m,
          "[m] width of the surrounding belt of trees with few triangles; its ground extends twice as far; 0: no belt",
          Range::between(0.0, 200.0));
  v.object("foliage", foliage, "motion of leaves in wind, visible to LiDARs");
  v.object("keep_clear", keep_clear, "zones kept free for flights");
  v.check(pine_share + spruce_share + broadleaf_share > 0.0, "pine_share", "at least one share above 0");
}

Scene make_forest(const ForestConfig& config, std::uint64_t seed) {
  SceneBuilder scene;
  const Relief relief(config.relief, seed);
  const bool is_flat = config.relief.amplitude_m == 0.0;
  scene.add(make_ground(relief, is_flat, -0.5 * config.size_m, 0.5 * config.size_m, config.ground_cell_m),
            materials::forest_floor(), SurfaceClass::kGround);
  add_trees(scene, config, seed, relief);
  add_undergrowth(scene, config, seed, relief);
  add_fallen_trunks(scene, config, seed, relief);
  add_rocks(scene, config, seed, relief);
  if (config.surroundings_m > 0.0) add_surroundings(scene, config, seed, relief, is_flat);
  scene.move_foliage(config.foliage, seed);
  return scene.finish();
}

}  // namespace swiftlet::sim
