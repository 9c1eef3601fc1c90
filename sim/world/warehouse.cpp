// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/warehouse.hpp"

#include <algorithm>
#include <cmath>

#include "sim/world/building.hpp"
#include "sim/world/dice.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// [m] Thickness of the outer walls, least width of the cross aisles at both ends, and edge of the pillars.
constexpr double kOuterWall_m = 0.2;
constexpr double kEndAisle_m = 5.0;
constexpr double kPillar_m = 0.4;
constexpr double kFlue_m = 0.2;  // gap between the two racks of a double row
// [m] Edge of an upright, height of a beam, and width of the tape.
constexpr double kUpright_m = 0.1;
constexpr double kBeam_m = 0.11;
constexpr double kTape_m = 0.1;
constexpr double kApron_m = 15.0;          // concrete surface around the hall
constexpr double kPalletHeight_m = 0.144;  // EUR pallet: 1.2 x 0.8 x 0.144 m
constexpr double kPalletLength_m = 1.2;
constexpr double kPalletWidth_m = 0.8;
// [-] Distinct loads; pallets carry copies.
constexpr int kLoads = 16;

void add_box_at(Mesh& mesh, const Vector3d& low, const Vector3d& high) {
  add_box(mesh, low.cast<float>(), high.cast<float>());
}

double double_row_depth_m(const WarehouseConfig& config) { return 2.0 * config.rack_depth_m + kFlue_m; }
double racks_length_m(const WarehouseConfig& config) { return config.num_bays() * config.bay_width_m; }
double upright_height_m(const WarehouseConfig& config) {
  return std::min((config.levels - 1) * config.level_height_m + 1.0, config.size_m.z() - 0.1);
}

void add_shell(SceneBuilder& scene, const WarehouseConfig& config) {
  const double t = kOuterWall_m;
  const double x = 0.5 * (config.size_m.x() + t);
  const double y = 0.5 * (config.size_m.y() + t);
  const double height_m = config.size_m.z();
  Mesh floor;
  add_floor(floor, Vector2d(-x - kApron_m, -y - kApron_m), Vector2d(x + kApron_m, y + kApron_m), 0.0);
  scene.add(std::move(floor), materials::concrete(), SurfaceClass::kGround);

  Mesh walls;
  add_wall(walls, {-x - 0.5 * t, -y}, {x + 0.5 * t, -y}, height_m, t);
  add_wall(walls, {-x - 0.5 * t, y}, {x + 0.5 * t, y}, height_m, t);
  add_wall(walls, {-x, -y + 0.5 * t}, {-x, y - 0.5 * t}, height_m, t);
  const Vector2d start_m(x, -y + 0.5 * t);
  const Opening gate = {-start_m.y(), config.gate_width_m, 0.0, config.gate_height_m};
  add_wall(walls, start_m, {x, y - 0.5 * t}, height_m, t, {&gate, 1});
  scene.add(std::move(walls), materials::metal_sheet(), SurfaceClass::kWall, 1);

  // The leaves of the gate close it except for the door.
  Mesh leaves;
  const double gate_start_m = -0.5 * config.gate_width_m;
  const Opening door = {0.5 * config.gate_width_m, config.door_width_m, 0.0, config.door_height_m};
  add_wall(leaves, {x, gate_start_m}, {x, gate_start_m + config.gate_width_m}, config.gate_height_m, std::min(0.06, t),
           {&door, 1});
  scene.add(std::move(leaves), materials::steel_painted(), SurfaceClass::kDoor, 1);
  scene.add_object({1,
                    SurfaceClass::kDoor,
                    "door",
                    {x, 0.0, 0.5 * config.door_height_m},
                    0.0,
                    {{"width_m", config.door_width_m}, {"height_m", config.door_height_m}}});

  if (config.roof) {
    Mesh roof;
    add_box_at(roof, {-x - 0.5 * t, -y - 0.5 * t, height_m}, {x + 0.5 * t, y + 0.5 * t, height_m + 0.1});
    for (double truss_x = -0.5 * config.size_m.x() + 2.5; truss_x < 0.5 * config.size_m.x(); truss_x += 5.0) {
      add_box_at(roof, {truss_x - 0.1, -y, height_m - 0.4}, {truss_x + 0.1, y, height_m});
    }
    scene.add(std::move(roof), materials::metal_sheet(), SurfaceClass::kCeiling, 1);
  }
}

void add_pillars(SceneBuilder& scene, const WarehouseConfig& config) {
  const double half_width_m = 0.5 * kPillar_m;
  for (int row = 0; row < config.num_double_rows(); ++row) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3d foot_m(side * (0.5 * racks_length_m(config) + 0.3 + half_width_m), config.row_center_y_m(row),
                            0.0);
      Mesh mesh;
      add_box_at(mesh, foot_m - Vector3d(half_width_m, half_width_m, 0),
                 foot_m + Vector3d(half_width_m, half_width_m, config.size_m.z()));
      const std::uint16_t instance = scene.next_instance(SurfaceClass::kPillar);
      scene.add(std::move(mesh), materials::concrete(), SurfaceClass::kPillar, instance);
      scene.add_object({instance, SurfaceClass::kPillar, "pillar", foot_m, 0.0, {{"width_m", kPillar_m}}});
    }
  }
}

// One rack: uprights at both sides of every bay boundary, beams and slats at every level above the floor.
void add_rack(SceneBuilder& scene, const WarehouseConfig& config, double low_y, std::uint16_t instance) {
  const double high_y = low_y + config.rack_depth_m;
  const double start_x = -0.5 * racks_length_m(config);
  const double top_m = upright_height_m(config);
  Mesh uprights, beams, slats, tape;
  for (int i = 0; i <= config.num_bays(); ++i) {
    const double x = start_x + i * config.bay_width_m;
    for (const double y : {low_y, high_y - kUpright_m}) {
      add_box_at(uprights, {x - 0.5 * kUpright_m, y, 0}, {x + 0.5 * kUpright_m, y + kUpright_m, top_m});
      for (const double z : {0.3, 1.5}) {
        // [m] Distance of the tape from the surface of an upright.
        constexpr double kOver_m = 0.002;
        add_box_at(tape, {x - 0.5 * kUpright_m - kOver_m, y - kOver_m, z},
                   {x + 0.5 * kUpright_m + kOver_m, y + kUpright_m + kOver_m, z + kTape_m});
      }
    }
    // Bracing between the two uprights of a frame.
    for (double z = 0.6; z + 0.6 < top_m; z += 1.2) {
      add_frustum(uprights, Vector3d(x, low_y + kUpright_m, z).cast<float>(), 0.015F,
                  Vector3d(x, high_y - kUpright_m, z + 0.6).cast<float>(), 0.015F, 4, Caps::kNone);
    }
  }
  for (int level = 1; level < config.levels; ++level) {
    const double z = level * config.level_height_m;
    for (int bay = 0; bay < config.num_bays(); ++bay) {
      const double from_x = start_x + bay * config.bay_width_m + 0.5 * kUpright_m;
      const double to_x = from_x + config.bay_width_m - kUpright_m;
      add_box_at(beams, {from_x, low_y, z - kBeam_m}, {to_x, low_y + 0.05, z});
      add_box_at(beams, {from_x, high_y - 0.05, z - kBeam_m}, {to_x, high_y, z});
      constexpr int kSlats = 8;
      for (int i = 0; i < kSlats; ++i) {
        const double x = from_x + (i + 0.5) * (to_x - from_x) / kSlats;
        add_box_at(slats, {x - 0.04, low_y + 0.05, z - 0.02}, {x + 0.04, high_y - 0.05, z});
      }
    }
  }
  scene.add(std::move(uprights), materials::steel_painted(), SurfaceClass::kRack, instance);
  scene.add(std::move(beams), materials::steel_beam(), SurfaceClass::kRack, instance);
  scene.add(std::move(slats), materials::steel_galvanized(), SurfaceClass::kRack, instance);
  if (config.tape)
    scene.add(std::move(tape), materials::retro_tape(), SurfaceClass::kMarking,
              scene.next_instance(SurfaceClass::kMarking));
  scene.add_object({instance,
                    SurfaceClass::kRack,
                    "rack",
                    {0.0, 0.5 * (low_y + high_y), 0.5 * top_m},
                    0.0,
                    {{"length_m", racks_length_m(config)}, {"depth_m", config.rack_depth_m}, {"height_m", top_m}}});
}

// Long side along y; origin at the bottom.
Mesh make_pallet() {
  Mesh mesh;
  constexpr double kLength = kPalletLength_m, kWidth = kPalletWidth_m;
  for (int i = 0; i < 3; ++i) {  // stringers
    const double x = -0.5 * kWidth + i * (kWidth - 0.1) / 2.0;
    add_box_at(mesh, {x, -0.5 * kLength, 0}, {x + 0.1, 0.5 * kLength, kPalletHeight_m - 0.022});
  }
  for (int i = 0; i < 7; ++i) {  // boards
    const double y = -0.5 * kLength + i * (kLength - 0.12) / 6.0;
    add_box_at(mesh, {-0.5 * kWidth, y, kPalletHeight_m - 0.022}, {0.5 * kWidth, y + 0.12, kPalletHeight_m});
  }
  return mesh;
}

// Layers of boxes; the top layer may be incomplete.
Mesh make_load(double height_max_m, Dice dice) {
  const int columns = 1 + dice.pick(2);
  const int rows = 2 + dice.pick(2);
  const double layer_m = dice.uniform(0.25, 0.5);
  const int layers = std::clamp(static_cast<int>(height_max_m / layer_m) - dice.pick(3), 1, 6);
  const Vector3d cell_m(kPalletWidth_m / columns, kPalletLength_m / rows, layer_m);
  Mesh mesh;
  for (int layer = 0; layer < layers; ++layer) {
    for (int column = 0; column < columns; ++column) {
      for (int row = 0; row < rows; ++row) {
        const bool is_missing = layer > 0 && layer + 1 == layers && dice.chance(0.35);
        const double slack_m = dice.uniform(0.005, 0.02);
        if (is_missing) continue;
        const Vector3d low(-0.5 * kPalletWidth_m + column * cell_m.x(), -0.5 * kPalletLength_m + row * cell_m.y(),
                           kPalletHeight_m + layer * layer_m);
        const Vector3d slack(slack_m, slack_m, 0.0);
        add_box_at(mesh, low + slack, low + cell_m - slack - Vector3d(0, 0, 0.002));
      }
    }
  }
  return mesh;
}

void fill_racks(SceneBuilder& scene, const WarehouseConfig& config, std::uint64_t seed,
                const std::vector<double>& racks_low_y) {
  const double load_height_max_m = config.level_height_m - kBeam_m - kPalletHeight_m - 0.1;
  if (load_height_max_m < 0.25 || config.bay_width_m < 2.0 * kPalletWidth_m + 0.3) return;
  const std::uint32_t pallet = scene.add_mesh(make_pallet(), materials::wood_pallet(), SurfaceClass::kPallet);
  const Random shapes(seed, "world.warehouse.loads");
  std::vector<std::uint32_t> loads;
  for (std::uint32_t i = 0; i < kLoads; ++i) {
    loads.push_back(
        scene.add_mesh(make_load(load_height_max_m, Dice(shapes, i)), materials::cardboard(), SurfaceClass::kPallet));
  }
  const Random chance(seed, "world.warehouse.fill");
  std::uint32_t slot = 0;
  for (const double low_y : racks_low_y) {
    for (int bay = 0; bay < config.num_bays(); ++bay) {
      for (int level = 0; level < config.levels; ++level) {
        for (const double side : {-1.0, 1.0}) {
          Dice dice(chance, slot++);
          if (!dice.chance(config.fill)) continue;
          // Random offsets of a few centimeters and degrees, within the rack.
          const double play_m = std::max(0.0, 0.5 * (config.rack_depth_m - kPalletLength_m - 0.05));
          const double x = -0.5 * racks_length_m(config) + (bay + 0.5) * config.bay_width_m +
                           side * 0.25 * config.bay_width_m + dice.uniform(-0.05, 0.05);
          const double y = low_y + 0.5 * config.rack_depth_m + dice.uniform(-1.0, 1.0) * std::min(play_m, 0.05);
          const Vector3d foot_m(x, y, level * config.level_height_m + 0.001);
          const double skew_rad = dice.uniform(-0.03, 0.03);
          const double yaw_rad = skew_rad + (dice.chance(0.5) ? std::numbers::pi : 0.0);
          const Eigen::Affine3f T = transform(foot_m.cast<float>(), static_cast<float>(yaw_rad));
          const std::uint16_t instance = scene.next_instance(SurfaceClass::kPallet);
          scene.place(pallet, instance, T);
          scene.place(loads[dice.pick(kLoads)], instance, T);
          scene.add_object(
              {instance, SurfaceClass::kPallet, "pallet", foot_m, yaw_rad, {{"level", static_cast<double>(level)}}});
        }
      }
    }
  }
}

// Tape lines along both sides of every aisle, and one across before the door.
void add_floor_tape(SceneBuilder& scene, const WarehouseConfig& config) {
  // [m] Height of the markings above the floor.
  constexpr double kHeight_m = 0.003;
  const double half_length_m = 0.5 * racks_length_m(config);
  const auto add_strip = [&](const Vector2d& low, const Vector2d& high) {
    Mesh mesh;
    add_floor(mesh, low, high, kHeight_m);
    const std::uint16_t instance = scene.next_instance(SurfaceClass::kMarking);
    scene.add(std::move(mesh), materials::retro_tape(), SurfaceClass::kMarking, instance);
  };
  for (int aisle = 0; aisle <= config.num_double_rows(); ++aisle) {
    for (const double side : {-1.0, 1.0}) {
      const double y = config.aisle_center_y_m(aisle) + side * (0.5 * config.aisle_width() - 0.25);
      add_strip({-half_length_m, y - 0.5 * kTape_m}, {half_length_m, y + 0.5 * kTape_m});
    }
  }
  const double door_x = 0.5 * config.size_m.x() - 1.0;
  add_strip({door_x, -0.5 * config.gate_width_m}, {door_x + kTape_m, 0.5 * config.gate_width_m});
}

}  // namespace

void WarehouseConfig::visit(ConfigVisitor& v) {
  v.field("size_m", size_m, "[m] inner size along x, y, z; x and y centered at the origin, floor at z = 0",
          Range::positive());
  v.field("roof", roof, "[-] whether the building has a roof");
  v.field("aisle_width_m", aisle_width_m, "[m] minimum width of the aisles between the racks", Range::positive());
  v.field("rack_depth_m", rack_depth_m, "[m]", Range::between(0.5, 3.0));
  v.field("bay_width_m", bay_width_m, "[m] distance between the uprights of a rack; from 1.9 m it holds two pallets",
          Range::between(0.5, 10.0));
  v.field("levels", levels, "[-] levels of a rack, the floor being the first", Range::between(1, 20));
  v.field("level_height_m", level_height_m, "[m] height difference between levels", Range::between(0.5, 5.0));
  v.field("fill", fill, "[-] probability that a storage place holds a pallet", Range::probability());
  v.field("gate_width_m", gate_width_m,
          "[m] width of the opening in the east wall, closed by the leaves of the gate except for the door",
          Range::positive());
  v.field("gate_height_m", gate_height_m, "[m]", Range::positive());
  v.field("door_width_m", door_width_m,
          "[m] width left open by the leaves of the gate [Pritzl 2024, Table III: 1.2, 1.1, 1.0, 0.9]",
          Range::positive());
  v.field("door_height_m", door_height_m, "[m]", Range::positive());
  v.field("tape", tape, "[-] retro-reflective tape on the floor and on the uprights");
  v.check(door_width_m <= gate_width_m, "door_width_m", "at most gate_width_m");
  v.check(door_height_m <= gate_height_m, "door_height_m", "at most gate_height_m");
  v.check(gate_height_m <= size_m.z(), "gate_height_m", "at most the height of the hall");
  v.check(gate_width_m <= size_m.y(), "gate_width_m", "at most the size of the hall along y");
  v.check(2.0 * kEndAisle_m < size_m.x(), "size_m", "more than 10 m along x, for both cross aisles");
}

int WarehouseConfig::num_double_rows() const {
  return std::max(
      0, static_cast<int>(std::floor((size_m.y() - aisle_width_m) / (double_row_depth_m(*this) + aisle_width_m))));
}
double WarehouseConfig::aisle_width() const {
  return (size_m.y() - num_double_rows() * double_row_depth_m(*this)) / (num_double_rows() + 1);
}
double WarehouseConfig::aisle_center_y_m(int aisle) const {
  return -0.5 * size_m.y() + 0.5 * aisle_width() + aisle * (aisle_width() + double_row_depth_m(*this));
}
double WarehouseConfig::row_center_y_m(int row) const {
  return aisle_center_y_m(row) + 0.5 * aisle_width() + 0.5 * double_row_depth_m(*this);
}
int WarehouseConfig::num_bays() const {
  return std::max(0, static_cast<int>(std::floor((size_m.x() - 2.0 * kEndAisle_m) / bay_width_m)));
}

Scene make_warehouse(const WarehouseConfig& config, std::uint64_t seed) {
  SceneBuilder scene;
  add_shell(scene, config);
  if (config.num_bays() > 0) {
    add_pillars(scene, config);
    std::vector<double> racks_low_y;
    for (int row = 0; row < config.num_double_rows(); ++row) {
      racks_low_y.push_back(config.row_center_y_m(row) - 0.5 * kFlue_m - config.rack_depth_m);
      racks_low_y.push_back(config.row_center_y_m(row) + 0.5 * kFlue_m);
    }
    for (const double low_y : racks_low_y) add_rack(scene, config, low_y, scene.next_instance(SurfaceClass::kRack));
    fill_racks(scene, config, seed, racks_low_y);
  }
  if (config.tape) add_floor_tape(scene, config);
  return scene.finish();
}

}  // namespace swiftlet::sim
