// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/campus.hpp"

#include <algorithm>
#include <cmath>

#include "sim/world/building.hpp"
#include "sim/world/clutter.hpp"
#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/placement.hpp"
#include "sim/world/tree.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// [m] Thickness of the walls, and depth of the panes behind the surface.
constexpr double kWall_m = 0.35;
constexpr double kPaneInset_m = 0.12;
// [m] Overhang of the roof beyond the walls, and height of the kerbs.
constexpr double kEaves_m = 0.6;
constexpr double kKerbHeight_m = 0.12;
// [m] Distance of the paved path from the walls, and its width. Larger values leave less lawn in the free ring.
constexpr double kPathDistance_m = 3.0;
constexpr double kPathWidth_m = 2.0;
// [m] Width of the ring around the walls without obstacles taller than a kerb or a doorstep.
constexpr double kFreeRing_m = 9.0;
// [m] Smallest distance between trees, lamp posts and cars. Larger values let fewer of them fit.
constexpr double kSpacing_m = 6.0;
// [-] Draws of a position for one object; then the object is left out.
constexpr int kMaxAttempts = 400;

void add_building_box(Mesh& mesh, const Vector3d& low, const Vector3d& high) {
  add_box(mesh, low.cast<float>(), high.cast<float>());
}

double distance_to_building_m(const CampusConfig& config, const Vector2d& p) {
  return (p.cwiseAbs() - 0.5 * config.building_size_m).cwiseMax(0.0).norm();
}

// One facade, from left to right as seen from outside, with window panes set back from its surface.
struct Facade {
  Vector2d start_m, end_m;  // outer corners
  std::vector<Opening> windows, doors;
};

std::vector<Facade> make_facades(const CampusConfig& config) {
  const Vector2d half = 0.5 * config.building_size_m;
  const double top_m = std::min(2.4, config.wall_height_m - 0.3);
  const auto windows_of = [&](double length_m, bool with_door) {
    std::pair<std::vector<Opening>, std::vector<Opening>> result;
    const int count = std::max(1, static_cast<int>(length_m / 2.6));
    for (int i = 0; i < count; ++i) {
      const double center_m = length_m * (i + 0.5) / count;
      const bool is_door = with_door && i == count / 2;
      if (is_door)
        result.second.push_back({center_m, 1.1, 0.0, std::min(2.1, top_m)});
      else
        result.first.push_back({center_m, 1.3, 0.9, top_m});
    }
    return result;
  };
  std::vector<Facade> facades = {{{-half.x(), -half.y()}, {half.x(), -half.y()}, {}, {}},
                                 {{half.x(), -half.y()}, {half.x(), half.y()}, {}, {}},
                                 {{half.x(), half.y()}, {-half.x(), half.y()}, {}, {}},
                                 {{-half.x(), half.y()}, {-half.x(), -half.y()}, {}, {}}};
  for (std::size_t i = 0; i < facades.size(); ++i) {
    Facade& facade = facades[i];
    std::tie(facade.windows, facade.doors) = windows_of((facade.end_m - facade.start_m).norm(), i == 0 || i == 3);
  }
  return facades;
}

void add_walls(SceneBuilder& scene, const CampusConfig& config) {
  Mesh walls, panes, doors, frames;
  for (const Facade& facade : make_facades(config)) {
    const Vector2d along = (facade.end_m - facade.start_m).normalized();
    const Vector2d inward(-along.y(), along.x());
    std::vector<Opening> openings = facade.windows;
    openings.insert(openings.end(), facade.doors.begin(), facade.doors.end());
    std::sort(openings.begin(), openings.end(),
              [](const Opening& a, const Opening& b) { return a.center_m < b.center_m; });
    // The wall's middle plane lies half its thickness behind the surface; the corners belong to the walls along y.
    const Vector2d shift = 0.5 * kWall_m * inward;
    add_wall(walls, facade.start_m + shift, facade.end_m + shift, config.wall_height_m, kWall_m, openings);
    const auto add_leaf = [&](Mesh& mesh, const Opening& opening, double inset_m, double thickness_m) {
      const Vector2d from = facade.start_m + inset_m * inward + (opening.center_m - 0.5 * opening.width_m) * along;
      add_wall(mesh, from, from + opening.width_m * along, opening.top_m - opening.bottom_m, thickness_m, {},
               opening.bottom_m);
    };
    for (const Opening& window : facade.windows) {
      add_leaf(panes, window, kPaneInset_m, 0.02);
      add_leaf(frames, {window.center_m, 0.06, window.bottom_m, window.top_m}, kPaneInset_m - 0.02, 0.06);  // mullion
      add_leaf(frames, {window.center_m, window.width_m + 0.2, window.bottom_m - 0.06, window.bottom_m}, -0.03,
               0.2);  // sill
    }
    for (const Opening& door : facade.doors) {
      add_leaf(doors, door, kPaneInset_m, 0.05);
      const Vector2d middle = facade.start_m + door.center_m * along;
      const Vector2d outer = middle - 0.9 * inward;
      const Vector2d low = (middle - 0.8 * along)
                               .cwiseMin(outer + 0.8 * along)
                               .cwiseMin(middle + 0.8 * along)
                               .cwiseMin(outer - 0.8 * along);
      const Vector2d high = (middle - 0.8 * along)
                                .cwiseMax(outer + 0.8 * along)
                                .cwiseMax(middle + 0.8 * along)
                                .cwiseMax(outer - 0.8 * along);
      add_building_box(frames, {low.x(), low.y(), 0.0}, {high.x(), high.y(), 0.15});  // step
    }
  }
  scene.add(std::move(walls), materials::plaster(), SurfaceClass::kBuilding, 1);
  scene.add(std::move(panes), materials::glass(), SurfaceClass::kBuilding, 1);
  scene.add(std::move(frames), materials::concrete(), SurfaceClass::kBuilding, 1);
  scene.add(std::move(doors), materials::wood_painted(), SurfaceClass::kDoor, 1);
}

// Gabled roof, ridge along x, with gutters and a chimney; the gables close the walls up to it.
void add_roof(SceneBuilder& scene, const CampusConfig& config) {
  const Vector2d half = 0.5 * config.building_size_m;
  const double slope = config.roof_height_m / half.y();
  const double eaves_z = config.wall_height_m - slope * kEaves_m;
  const double ridge_z = config.wall_height_m + config.roof_height_m;
  const double end_x = half.x() + kEaves_m;
  const double edge_y = half.y() + kEaves_m;
  constexpr double kThickness_m = 0.18;
  Mesh roof, gables, details;
  for (const double side : {-1.0, 1.0}) {
    // A slab whose lower face extends from the eaves to the ridge.
    const Vector3f a = Vector3d(-end_x, side * edge_y, eaves_z).cast<float>();
    const Vector3f b = Vector3d(end_x, side * edge_y, eaves_z).cast<float>();
    const Vector3f c = Vector3d(end_x, 0, ridge_z).cast<float>();
    const Vector3f d = Vector3d(-end_x, 0, ridge_z).cast<float>();
    const Vector3f up(0, 0, kThickness_m);
    const auto quad = [&](const Vector3f& p, const Vector3f& q, const Vector3f& r, const Vector3f& s) {
      if (side < 0)
        add_quad(roof, p, q, r, s);
      else
        add_quad(roof, s, r, q, p);
    };
    quad(a + up, b + up, c + up, d + up);
    quad(d, c, b, a);
    quad(a, b, b + up, a + up);
    quad(b, c, c + up, b + up);
    quad(d, a, a + up, d + up);
    add_frustum(details, Vector3d(-end_x, side * (edge_y + 0.07), eaves_z + 0.05).cast<float>(), 0.07F,
                Vector3d(end_x, side * (edge_y + 0.07), eaves_z + 0.05).cast<float>(), 0.07F, 8);
    for (const double x : {-half.x() + 0.2, half.x() - 0.2}) {  // downpipes
      add_frustum(details, Vector3d(x, side * (half.y() + 0.06), 0.0).cast<float>(), 0.045F,
                  Vector3d(x, side * (half.y() + 0.06), eaves_z).cast<float>(), 0.045F, 8);
    }
    const double gable_x = side * (half.x() - 0.5 * kWall_m);
    for (const double face : {-0.5 * kWall_m, 0.5 * kWall_m}) {
      const Vector3f left = Vector3d(gable_x + face, -half.y(), config.wall_height_m).cast<float>();
      const Vector3f right = Vector3d(gable_x + face, half.y(), config.wall_height_m).cast<float>();
      const Vector3f top = Vector3d(gable_x + face, 0, ridge_z).cast<float>();
      if (face > 0)
        add_triangle(gables, left, right, top);
      else
        add_triangle(gables, right, left, top);
    }
  }
  const double chimney_z = config.wall_height_m + 0.5 * config.roof_height_m - 0.4;
  add_building_box(details, {0.25 * half.x(), 0.35 * half.y(), chimney_z},
                   {0.25 * half.x() + 0.7, 0.35 * half.y() + 0.7, ridge_z + 0.7});
  scene.add(std::move(roof), materials::roof_tiles(), SurfaceClass::kBuilding, 1);
  scene.add(std::move(gables), materials::plaster(), SurfaceClass::kBuilding, 1);
  scene.add(std::move(details), materials::brick(), SurfaceClass::kBuilding, 1);
}

// Calls add_strip for the sides of a rectangular ring around the building, between two distances from its walls.
template <class AddStrip>
void for_each_side(const CampusConfig& config, double from_m, double to_m, const AddStrip& add_strip) {
  const Vector2d in = 0.5 * config.building_size_m + Vector2d::Constant(from_m);
  const Vector2d out = 0.5 * config.building_size_m + Vector2d::Constant(to_m);
  add_strip(Vector2d(-out.x(), -out.y()), Vector2d(out.x(), -in.y()));
  add_strip(Vector2d(-out.x(), in.y()), Vector2d(out.x(), out.y()));
  add_strip(Vector2d(-out.x(), -in.y()), Vector2d(-in.x(), in.y()));
  add_strip(Vector2d(in.x(), -in.y()), Vector2d(out.x(), in.y()));
}

void add_path(SceneBuilder& scene, const CampusConfig& config) {
  // [m] Width of the kerbs, and height of the path above the ground.
  constexpr double kKerb_m = 0.12;
  constexpr double kPathHeight_m = 0.01;
  Mesh path, kerbs;
  const double end_m = kPathDistance_m + kPathWidth_m;
  for_each_side(config, kPathDistance_m, end_m,
                [&](const Vector2d& low, const Vector2d& high) { add_floor(path, low, high, kPathHeight_m); });
  const auto add_kerb = [&](const Vector2d& low, const Vector2d& high) {
    add_building_box(kerbs, {low.x(), low.y(), -0.1}, {high.x(), high.y(), kKerbHeight_m});
  };
  for_each_side(config, kPathDistance_m - kKerb_m, kPathDistance_m, add_kerb);
  for_each_side(config, end_m, end_m + kKerb_m, add_kerb);
  scene.add(std::move(path), materials::asphalt(), SurfaceClass::kGround);
  scene.add(std::move(kerbs), materials::concrete(), SurfaceClass::kKerb, scene.next_instance(SurfaceClass::kKerb));
}

// A position for an object with this radius outside the free ring, separated from the others.
std::optional<Vector2d> find_place(const CampusConfig& config, double reach_m, Spacing& spacing, Dice& dice) {
  const Vector2d half = 0.5 * config.size_m - Vector2d::Constant(1.0);
  for (int i = 0; i < kMaxAttempts; ++i) {
    const double x_m = dice.uniform(-half.x(), half.x());
    const double y_m = dice.uniform(-half.y(), half.y());
    const Vector2d p(x_m, y_m);
    if (distance_to_building_m(config, p) < kFreeRing_m + reach_m || config.keep_clear.distance_m(p) < reach_m)
      continue;
    if (spacing.try_add(p)) return p;
  }
  return std::nullopt;
}

void add_trees(SceneBuilder& scene, const CampusConfig& config, std::uint64_t seed, Spacing& spacing) {
  const TreeOptions options{
      .leaf_area_density_per_m = 0.55, .leaf_cluster_m = 0.3 / std::sqrt(config.detail), .lean_max_deg = 2.0};
  const TreeStock broadleaf(scene, Species::kBroadleaf, {0.2, 0.3, 0.4}, options,
                            Random(seed, "world.campus.trees", "broadleaf"));
  const TreeStock spruce(scene, Species::kSpruce, {0.25, 0.4}, options, Random(seed, "world.campus.trees", "spruce"));
  const Random random(seed, "world.campus.trees", "places");
  for (int i = 0; i < config.num_trees; ++i) {
    Dice dice(random, i);
    const TreeStock& stock = dice.chance(0.75) ? broadleaf : spruce;
    const double dbh_m = dice.uniform(0.15, 0.45);
    const double height_factor = dice.uniform(0.5, 0.7);
    const double yaw_rad = dice.angle_rad();
    const auto place_m = find_place(config, stock.measures(dbh_m, height_factor).crown_radius_m, spacing, dice);
    if (place_m) stock.place(scene, {place_m->x(), place_m->y(), 0.0}, dbh_m, height_factor, yaw_rad);
  }
}

void add_lamps(SceneBuilder& scene, const CampusConfig& config, std::uint64_t seed, Spacing& spacing) {
  // [m] Radius of a lamp post with its arm.
  constexpr double kReach_m = 1.6;
  Mesh mesh;
  add_frustum(mesh, {0, 0, -0.1F}, 0.08F, {0, 0, 5.0F}, 0.05F, 10);
  add_frustum(mesh, {0, 0, 4.95F}, 0.04F, {1.1F, 0, 5.2F}, 0.03F, 8);
  add_box(mesh, Vector3f(0.9F, -0.12F, 5.15F), Vector3f(1.5F, 0.12F, 5.27F));
  const std::uint32_t lamp = scene.add_mesh(std::move(mesh), materials::steel_galvanized(), SurfaceClass::kPillar);
  const Random random(seed, "world.campus.lamps");
  for (int i = 0; i < config.num_lamps; ++i) {
    Dice dice(random, i);
    const auto place_m = find_place(config, kReach_m, spacing, dice);
    if (!place_m) continue;
    const double yaw_rad = elementary::atan2(-place_m->y(), -place_m->x());  // the arm points to the building
    const Vector3d foot_m(place_m->x(), place_m->y(), 0.0);
    const std::uint16_t instance = scene.next_instance(SurfaceClass::kPillar);
    scene.place(lamp, instance, transform(foot_m.cast<float>(), static_cast<float>(yaw_rad)));
    scene.add_object({instance, SurfaceClass::kPillar, "lamp_post", foot_m, yaw_rad, {{"height_m", 5.27}}});
  }
}

// Cars as a body, a cabin and four wheels.
void add_cars(SceneBuilder& scene, const CampusConfig& config, std::uint64_t seed, Spacing& spacing) {
  // [m] Radius of a parked car.
  constexpr double kReach_m = 2.5;
  Mesh body, cabin, wheels;
  add_box(body, Vector3f(-2.15F, -0.88F, 0.25F), Vector3f(2.15F, 0.88F, 0.85F));
  add_box(cabin, Vector3f(-1.7F, -0.85F, 0.85F), Vector3f(1.2F, 0.85F, 1.45F));
  for (Vector3f& vertex : cabin.vertices_mesh_m) {  // narrower towards the roof
    if (vertex.z() > 1.0F) vertex.head<2>() = Eigen::Vector2f(0.62F * vertex.x() - 0.1F, 0.8F * vertex.y());
  }
  for (const float x : {-1.35F, 1.35F}) {
    for (const float y : {-0.8F, 0.8F})
      add_frustum(wheels, {x, y - 0.1F, 0.31F}, 0.31F, {x, y + 0.1F, 0.31F}, 0.31F, 14);
  }
  const std::uint32_t body_mesh = scene.add_mesh(std::move(body), materials::car_paint(), SurfaceClass::kObject);
  const std::uint32_t cabin_mesh = scene.add_mesh(std::move(cabin), materials::glass(), SurfaceClass::kObject);
  const std::uint32_t wheel_mesh = scene.add_mesh(std::move(wheels), materials::plastic_dark(), SurfaceClass::kObject);
  const Random random(seed, "world.campus.cars");
  for (int i = 0; i < config.num_cars; ++i) {
    Dice dice(random, i);
    const auto place_m = find_place(config, kReach_m, spacing, dice);
    if (!place_m) continue;
    const double yaw_rad = dice.angle_rad();
    const Vector3d foot_m(place_m->x(), place_m->y(), 0.0);
    const std::uint16_t instance = scene.next_instance(SurfaceClass::kObject);
    for (const std::uint32_t mesh : {body_mesh, cabin_mesh, wheel_mesh}) {
      scene.place(mesh, instance, transform(foot_m.cast<float>(), static_cast<float>(yaw_rad)));
    }
    scene.add_object({instance, SurfaceClass::kObject, "car", foot_m, yaw_rad, {{"height_m", 1.45}}});
  }
}

}  // namespace

void CampusConfig::visit(ConfigVisitor& v) {
  v.field("size_m", size_m, "[m] extent of the ground along x and y, centered at the origin", Range::positive());
  v.field("building_size_m", building_size_m, "[m] outer size of the building along x and y, centered at the origin",
          Range::between(4.0, 1000.0));
  v.field("wall_height_m", wall_height_m, "[m] height of the walls below the roof", Range::between(2.0, 100.0));
  v.field("roof_height_m", roof_height_m, "[m] height of the ridge above the walls", Range::positive());
  v.field("num_trees", num_trees, "[-] largest number of trees, limited by space", Range::between(0, 10000));
  v.field("num_lamps", num_lamps, "[-] largest number of lamp posts, limited by space", Range::between(0, 10000));
  v.field("num_cars", num_cars, "[-] largest number of parked cars, limited by space", Range::between(0, 10000));
  v.field("detail", detail, "[-] number of leaf clusters, relative to the default", Range::between(0.05, 20.0));
  v.object("foliage", foliage, "motion of leaves in wind, visible to LiDARs");
  v.object("clutter", clutter, "posts, people and signs on the ground");
  v.object("keep_clear", keep_clear, "zones kept free for flights");
  v.check((building_size_m.array() + 2.0 * (kPathDistance_m + kPathWidth_m) < size_m.array()).all(), "size_m",
          "a ground larger than the building with its path");
}

Scene make_campus(const CampusConfig& config, std::uint64_t seed) {
  SceneBuilder scene;
  Mesh lawn;
  add_floor(lawn, -0.5 * config.size_m, 0.5 * config.size_m, 0.0);
  scene.add(std::move(lawn), materials::grass(), SurfaceClass::kGround);
  add_walls(scene, config);
  add_roof(scene, config);
  scene.add_object({1,
                    SurfaceClass::kBuilding,
                    "building",
                    {0.0, 0.0, 0.5 * config.wall_height_m},
                    0.0,
                    {{"size_x_m", config.building_size_m.x()},
                     {"size_y_m", config.building_size_m.y()},
                     {"height_m", config.wall_height_m + config.roof_height_m}}});
  add_path(scene, config);
  Spacing spacing(kSpacing_m);
  add_trees(scene, config, seed, spacing);
  add_lamps(scene, config, seed, spacing);
  add_cars(scene, config, seed, spacing);
  add_clutter(scene, config.clutter, seed,
              {[](const Vector2d&) { return 0.0; },
               [&](const Vector2d& p) {
                 return distance_to_building_m(config, p) > kPathDistance_m &&
                        config.keep_clear.distance_m(p) > kClutterReach_m;
               }});
  scene.move_foliage(config.foliage, seed);
  return scene.finish();
}

}  // namespace swiftlet::sim
