// SPDX-License-Identifier: BSD-3-Clause
// Buildings taken apart: every board, post and pane, compared with the list that a carpenter would have.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "swiftlet/sim/world/campus.hpp"
#include "swiftlet/sim/world/hall.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "swiftlet/sim/world/two_rooms_gap.hpp"
#include "swiftlet/sim/world/warehouse.hpp"
#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::attribute;
using test::boxes_of_material;
using test::expect_boxes;
using test::expect_share;
using test::expect_uniform;
using test::objects_of;
using test::Piece;
using test::Ring;

AlignedBox3d box(double x0, double y0, double z0, double x1, double y1, double z1) {
  return {Vector3d(std::min(x0, x1), std::min(y0, y1), std::min(z0, z1)),
          Vector3d(std::max(x0, x1), std::max(y0, y1), std::max(z0, z1))};
}

AlignedBox3d around_line(const Vector3d& a, const Vector3d& b, const Vector3d& half) {
  return AlignedBox3d((a.cwiseMin(b) - half).eval(), (a.cwiseMax(b) + half).eval());
}

// One double row of racks with four bays of three levels.
WarehouseConfig small_warehouse() {
  WarehouseConfig config;
  config.size_m = {16.0, 9.4, 5.0};
  config.wall_thickness_m = 0.24;
  config.aisle_width_m = 2.1;
  config.end_aisle_m = 2.2;
  config.rack_depth_m = 1.25;
  config.bay_width_m = 2.7;
  config.levels = 3;
  config.level_height_m = 1.5;
  config.fill = 0.0;
  config.gate_width_m = 3.2;
  config.gate_height_m = 3.0;
  config.door_width_m = 1.1;
  config.door_height_m = 2.2;
  config.door_offset_m = 0.6;
  config.pillar_width_m = 0.36;
  return config;
}

TEST(WarehouseParts, ShellIsFourWallsWithAGateItsLeavesAFloorAndARoofOnTrusses) {
  const Scene scene = make_warehouse(small_warehouse(), 1);
  std::vector<AlignedBox3d> metal = {
      box(-8.24, -4.94, 0, 8.24, -4.7, 5),   box(-8.24, 4.7, 0, 8.24, 4.94, 5),
      box(-8.24, -4.7, 0, -8.0, 4.7, 5),     box(8.0, -4.7, 0, 8.24, -1.0, 5),  // beside the gate, and above it
      box(8.0, -1.0, 3, 8.24, 2.2, 5),       box(8.0, 2.2, 0, 8.24, 4.7, 5),
      box(-8.24, -4.94, 5, 8.24, 4.94, 5.1),  // roof
  };
  // Trusses of 0.2 x 0.4 m every 5 m, the first 2.5 m from the wall.
  for (const double x : {-5.5, -0.5, 4.5}) metal.push_back(box(x - 0.1, -4.82, 4.6, x + 0.1, 4.82, 5.0));
  expect_boxes(boxes_of_material(scene, "metal_sheet"), metal);

  const auto ground = test::bounds_of(scene, SurfaceClass::kGround);
  EXPECT_TRUE(ground.isApprox(box(-23.12, -19.82, 0, 23.12, 19.82, 0), 1e-5));  // 15 m around the walls' middle

  for (const double wall_m : {0.24, 0.04}) {
    WarehouseConfig config = small_warehouse();
    config.wall_thickness_m = wall_m;
    const double middle = 8.0 + 0.5 * wall_m, half = 0.5 * std::min(0.06, wall_m);
    const Scene other = make_warehouse(config, 1);
    std::vector<AlignedBox3d> leaves;
    for (const test::Piece& piece : test::pieces_of_material(other, "steel_painted")) {
      if (test::box_around(piece).min().x() > 7.0) leaves.push_back(test::box_around(piece));
    }
    expect_boxes(leaves, {box(middle - half, -1.0, 0, middle + half, 0.05, 3),
                          box(middle - half, 0.05, 2.2, middle + half, 1.15, 3),
                          box(middle - half, 1.15, 0, middle + half, 2.2, 3)});
  }
  const auto doors = objects_of(scene, SurfaceClass::kDoor);
  ASSERT_EQ(doors.size(), 1U);
  EXPECT_EQ(doors[0].instance, 1);
  EXPECT_EQ(doors[0].yaw_rad, 0.0);
  EXPECT_TRUE(doors[0].position_world_m.isApprox(Vector3d(8.12, 0.6, 1.1), 1e-9));
  EXPECT_EQ(attribute(doors[0], "width_m"), 1.1);
  EXPECT_EQ(attribute(doors[0], "height_m"), 2.2);

  WarehouseConfig open = small_warehouse();
  open.roof = false;
  EXPECT_TRUE(test::bounds_of_each(make_warehouse(open, 1), SurfaceClass::kCeiling).empty());
}

TEST(WarehouseParts, RacksAreUprightsBeamsSlatsAndBraces) {
  for (const double hall_m : {5.0, 3.6}) {  // uprights end a meter above the last level, or below the roof
    WarehouseConfig config = small_warehouse();
    config.size_m.z() = hall_m;
    const double top = hall_m == 5.0 ? 4.0 : 3.5;
    const Scene scene = make_warehouse(config, 1);
    std::vector<AlignedBox3d> uprights, beams, slats, tapes;
    for (const double low_y : {-1.35, 0.1}) {  // two racks 1.25 m deep, 0.2 m apart
      const double high_y = low_y + 1.25;
      for (int i = 0; i <= 4; ++i) {
        const double x = -5.4 + 2.7 * i;
        for (const double y : {low_y, high_y - 0.1}) {
          uprights.push_back(box(x - 0.05, y, 0, x + 0.05, y + 0.1, top));
          for (const double z : {0.3, 1.5})
            tapes.push_back(box(x - 0.052, y - 0.002, z, x + 0.052, y + 0.102, z + 0.1));
        }
        // Braces of 3 cm, one to 1.2 m of height, rising 0.6 m from the front to the back.
        for (int k = 0; 0.6 + 1.2 * k + 0.6 < top; ++k) {
          const double z = 0.6 + 1.2 * k;
          uprights.push_back(
              around_line({x, low_y + 0.1, z}, {x, high_y - 0.1, z + 0.6}, Vector3d(0.0188, 0.0093, 0.0163)));
        }
      }
      for (int level = 1; level < 3; ++level) {
        const double z = 1.5 * level;
        for (int bay = 0; bay < 4; ++bay) {
          const double from = -5.4 + 2.7 * bay + 0.05, to = from + 2.6;
          beams.push_back(box(from, low_y, z - 0.11, to, low_y + 0.05, z));
          beams.push_back(box(from, high_y - 0.05, z - 0.11, to, high_y, z));
          for (int i = 0; i < 8; ++i) {
            const double x = from + (0.5 + i) * 2.6 / 8;
            slats.push_back(box(x - 0.04, low_y + 0.05, z - 0.02, x + 0.04, high_y - 0.05, z));
          }
        }
      }
    }
    std::vector<AlignedBox3d> painted;
    for (const Piece& piece : test::pieces_of_material(scene, "steel_painted")) {
      if (test::box_around(piece).max().x() < 7.0) painted.push_back(test::box_around(piece));  // without the gate
    }
    expect_boxes(painted, uprights, 4e-3);
    expect_boxes(boxes_of_material(scene, "steel_beam"), beams);
    expect_boxes(boxes_of_material(scene, "steel_galvanized"), slats);
    // Tape lies along both sides of the two aisles, and before the door.
    for (const double aisle_y : {-3.025, 3.025}) {
      for (const double side : {-1.0, 1.0}) {
        const double y = aisle_y + side * (0.5 * 3.35 - 0.25);
        tapes.push_back(box(-5.4, y - 0.05, 0.003, 5.4, y + 0.05, 0.003));
      }
    }
    tapes.push_back(box(7.0, -1.0, 0.003, 7.1, 2.2, 0.003));
    expect_boxes(boxes_of_material(scene, "retro_tape"), tapes);

    const auto racks = objects_of(scene, SurfaceClass::kRack);
    ASSERT_EQ(racks.size(), 2U);
    for (int i = 0; i < 2; ++i) {
      EXPECT_TRUE(racks[i].position_world_m.isApprox(Vector3d(0, i == 0 ? -0.725 : 0.725, 0.5 * top), 1e-9));
      EXPECT_EQ(racks[i].yaw_rad, 0.0);
      EXPECT_NEAR(attribute(racks[i], "length_m"), 10.8, 1e-9);
      EXPECT_NEAR(attribute(racks[i], "depth_m"), 1.25, 1e-9);
      EXPECT_NEAR(attribute(racks[i], "height_m"), top, 1e-9);
    }
  }
}

TEST(WarehouseParts, PillarsStandThreeTenthsBeforeTheRacksInTheMiddleOfTheirRow) {
  const Scene scene = make_warehouse(small_warehouse(), 1);
  std::vector<AlignedBox3d> pillars;
  for (const auto& [number, bounds] : test::bounds_of_each(scene, SurfaceClass::kPillar)) pillars.push_back(bounds);
  expect_boxes(pillars, {box(5.7, -0.18, 0, 6.06, 0.18, 5), box(-6.06, -0.18, 0, -5.7, 0.18, 5)});
  const auto objects = objects_of(scene, SurfaceClass::kPillar);
  ASSERT_EQ(objects.size(), 2U);
  for (const WorldObject& pillar : objects) {
    EXPECT_NEAR(std::abs(pillar.position_world_m.x()), 5.88, 1e-9);
    EXPECT_EQ(pillar.position_world_m.z(), 0.0);
    EXPECT_EQ(pillar.yaw_rad, 0.0);
    EXPECT_EQ(attribute(pillar, "width_m"), 0.36);
  }
}

TEST(Warehouse, HoldsAsManyRowsAndBaysAsFit) {
  WarehouseConfig config = small_warehouse();
  for (const double depth_m : {0.6, 1.1}) {
    for (double size_m = 2.0; size_m < 30.0; size_m += 0.37) {
      config.rack_depth_m = depth_m;
      config.size_m = {size_m, size_m, 5.0};
      const double row_m = 2.0 * depth_m + 0.2;
      const auto fits = [&](int rows) { return rows * row_m + (rows + 1) * config.aisle_width_m <= size_m; };
      const int rows = config.num_double_rows();
      EXPECT_TRUE(rows == 0 || fits(rows)) << size_m;
      EXPECT_FALSE(fits(rows + 1)) << size_m;
      EXPECT_NEAR(rows * row_m + (rows + 1) * config.aisle_width(), size_m, 1e-9);
      EXPECT_NEAR(config.aisle_center_y_m(0) - 0.5 * config.aisle_width(), -0.5 * size_m, 1e-9);
      EXPECT_NEAR(config.aisle_center_y_m(rows) + 0.5 * config.aisle_width(), 0.5 * size_m, 1e-9);
      const int bays = config.num_bays();
      EXPECT_TRUE(bays == 0 || bays * config.bay_width_m + 2.0 * config.end_aisle_m <= size_m) << size_m;
      EXPECT_GT((bays + 1) * config.bay_width_m + 2.0 * config.end_aisle_m, size_m);
    }
  }
  config.size_m = {3.0, 2.0, 5.0};
  EXPECT_EQ(config.num_bays(), 0);
  EXPECT_EQ(config.num_double_rows(), 0);
  config.size_m = {6.0, 9.0, 5.0};  // room for rows, for no bay
  config.gate_width_m = 1.5;
  const Scene bare = make_warehouse(config, 1);
  EXPECT_TRUE(test::bounds_of_each(bare, SurfaceClass::kPillar).empty());
  EXPECT_TRUE(test::bounds_of_each(bare, SurfaceClass::kRack).empty());
  config.size_m.x() = 7.2;
  EXPECT_FALSE(test::bounds_of_each(make_warehouse(config, 1), SurfaceClass::kRack).empty());
}

TEST(WarehousePallets, AreSevenBoardsOnThreeStringers) {
  WarehouseConfig config = small_warehouse();
  config.fill = 1.0;
  const Scene scene = make_warehouse(config, 1);
  const Mesh* pallet = nullptr;
  for (const Mesh& mesh : scene.meshes) {
    if (scene.materials[mesh.material].name == "wood_pallet") pallet = &mesh;
  }
  ASSERT_NE(pallet, nullptr);
  std::vector<AlignedBox3d> boxes, expected;
  for (const Piece& piece : test::pieces_in(*pallet)) boxes.push_back(test::box_around(piece));
  for (const double x : {-0.4, -0.05, 0.3}) expected.push_back(box(x, -0.6, 0, x + 0.1, 0.6, 0.122));
  for (int i = 0; i < 7; ++i) expected.push_back(box(-0.4, -0.6 + 0.18 * i, 0.122, 0.4, -0.48 + 0.18 * i, 0.144));
  expect_boxes(boxes, expected);
}

TEST(WarehousePallets, StandTwoToABayAndLevelAFewCentimetersOff) {
  for (const double depth_m : {1.2, 1.31, 1.9}) {  // no play, 3 cm, 5 cm at most
    std::vector<double> along, across, skew;
    int turned = 0;
    for (const std::uint64_t seed : {1, 2, 3}) {
      WarehouseConfig config;
      config.rack_depth_m = depth_m;
      config.fill = 1.0;
      const auto pallets = objects_of(make_warehouse(config, seed), SurfaceClass::kPallet);
      std::size_t next = 0;
      for (int rack = 0; rack < 2 * config.num_double_rows(); ++rack) {
        const double side_m = 0.1 + 0.5 * depth_m;
        const double y = config.row_center_y_m(rack / 2) + (rack % 2 == 0 ? -side_m : side_m);
        for (int bay = 0; bay < config.num_bays(); ++bay) {
          for (int level = 0; level < config.levels; ++level) {
            for (const double quarter : {0.25, 0.75}) {
              ASSERT_LT(next, pallets.size());
              const WorldObject& pallet = pallets[next++];
              const double x = config.bay_width_m * (bay + quarter - 0.5 * config.num_bays());
              along.push_back(pallet.position_world_m.x() - x);
              across.push_back(pallet.position_world_m.y() - y);
              EXPECT_NEAR(pallet.position_world_m.z(), 1.6 * level + 0.001, 1e-9);
              EXPECT_EQ(attribute(pallet, "level"), level);
              skew.push_back(std::remainder(pallet.yaw_rad, std::numbers::pi));
              turned += std::abs(pallet.yaw_rad) > 1.5;
            }
          }
        }
      }
      EXPECT_EQ(next, pallets.size());
    }
    expect_uniform(along, -0.05, 0.05);
    expect_uniform(skew, -0.03, 0.03);
    expect_share(turned, static_cast<double>(skew.size()), 0.5);
    const double play_m = depth_m == 1.2 ? 0.0 : depth_m == 1.31 ? 0.03 : 0.05;
    if (play_m > 0.0) {
      expect_uniform(across, -play_m, play_m);
    } else {
      for (const double off_m : across) EXPECT_NEAR(off_m, 0.0, 1e-9);
    }
  }
}

TEST(WarehousePallets, AreLeftOutWhereNoneFits) {
  WarehouseConfig config = small_warehouse();
  config.fill = 1.0;
  const auto pallets = [&] { return objects_of(make_warehouse(config, 1), SurfaceClass::kPallet).size(); };
  config.bay_width_m = 1.89;
  EXPECT_EQ(pallets(), 0U);
  config.bay_width_m = 1.91;
  EXPECT_GT(pallets(), 0U);
  // A beam, the pallet, a load of a quarter of a meter, and a hand's breadth.
  config.level_height_m = 0.11 + 0.144 + 0.25 + 0.1 - 0.01;
  EXPECT_EQ(pallets(), 0U);
  config.level_height_m += 0.02;
  EXPECT_GT(pallets(), 0U);
}

TEST(WarehousePallets, LoadsAreLayersOfBoxesTheTopOneNotAlwaysComplete) {
  for (const double level_m : {1.6, 5.0}) {
    const double most_m = level_m - 0.11 - 0.144 - 0.1;
    std::vector<double> slacks, layers_m;
    std::set<std::pair<int, int>> grids;
    std::map<int, int> lacking, counts;  // layers fewer than would fit; layers
    double boxes_on_top = 0, places_on_top = 0;
    std::size_t loads = 0;
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
      WarehouseConfig config;
      config.size_m.z() = 6.0;
      config.levels = level_m < 2.0 ? 4 : 2;
      config.level_height_m = level_m;
      config.fill = 1.0;
      const Scene scene = make_warehouse(config, seed);
      for (const Mesh& mesh : scene.meshes) {
        if (scene.materials[mesh.material].name != "cardboard") continue;
        ++loads;
        std::map<long, std::vector<AlignedBox3d>> by_layer;  // by the height of their foot [mm]
        for (const Piece& piece : test::pieces_in(mesh)) {
          const AlignedBox3d one = test::box_around(piece);
          EXPECT_TRUE(test::is_box(piece));
          by_layer[std::lround(1e3 * one.min().z())].push_back(one);
        }
        ASSERT_FALSE(by_layer.empty());
        EXPECT_EQ(by_layer.begin()->first, 144);
        const std::vector<AlignedBox3d>& first = by_layer.begin()->second;
        const int columns = static_cast<int>(std::lround(0.8 / (first[0].sizes().x() + 0.025)));
        const int rows = static_cast<int>(std::lround(1.2 / (first[0].sizes().y() + 0.025)));
        grids.insert({columns, rows});
        const double layer_m = first[0].sizes().z() + 0.002;
        layers_m.push_back(layer_m);
        const int layers = static_cast<int>(by_layer.size());
        ++counts[layers];
        ++lacking[static_cast<int>(most_m / layer_m) - layers];
        for (auto layer = by_layer.begin(); layer != by_layer.end(); ++layer) {
          const bool is_top = std::next(layer) == by_layer.end() && layers > 1;
          const auto places = static_cast<std::size_t>(columns * rows);
          if (!is_top) {
            EXPECT_EQ(layer->second.size(), places);
          } else if (places == 6) {  // hardly ever all of them are missing
            boxes_on_top += static_cast<double>(layer->second.size());
            places_on_top += 6;
          }
          const auto number = std::distance(by_layer.begin(), layer);
          for (const AlignedBox3d& one : layer->second) {
            EXPECT_NEAR(one.min().z(), 0.144 + layer_m * static_cast<double>(number), 1e-5);
            EXPECT_NEAR(one.sizes().z(), layer_m - 0.002, 1e-5);
            const Vector2d cell(0.8 / columns, 1.2 / rows);
            const Vector2d low = one.min().head<2>() + Vector2d(0.4, 0.6);
            const Vector2d corner(cell.x() * std::floor(low.x() / cell.x()), cell.y() * std::floor(low.y() / cell.y()));
            const double slack_m = low.x() - corner.x();
            slacks.push_back(slack_m);
            EXPECT_NEAR(low.y() - corner.y(), slack_m, 1e-5);
            EXPECT_TRUE(one.sizes().head<2>().isApprox((cell.array() - 2.0 * slack_m).matrix(), 1e-4));
          }
        }
      }
    }
    EXPECT_GT(loads, 390U) << "16 in each hall";
    EXPECT_LE(loads, 400U);
    expect_uniform(slacks, 0.005, 0.02);
    expect_uniform(layers_m, 0.25, 0.5);
    EXPECT_EQ(grids, (std::set<std::pair<int, int>>{{1, 2}, {1, 3}, {2, 2}, {2, 3}}));
    EXPECT_EQ(counts.rbegin()->first, level_m > 2.0 ? 6 : 4);
    expect_share(places_on_top - boxes_on_top, places_on_top, 0.35);
    if (level_m > 2.0) continue;
    EXPECT_EQ(counts.begin()->first, 1);
    // Up to two layers fewer than would fit, each as often.
    EXPECT_GE(lacking.begin()->first, 0);
    EXPECT_LE(lacking.rbegin()->first, 3) << "with a top layer of which all is missing";
    EXPECT_GT(lacking[0], 0.2 * static_cast<double>(loads));
    EXPECT_GT(lacking[1], 0.2 * static_cast<double>(loads));
    EXPECT_GT(lacking[2], 0.05 * static_cast<double>(loads));
  }
}

TEST(WarehousePallets, EveryLoadIsUsedAsOften) {
  WarehouseConfig config;
  config.fill = 1.0;
  const Scene scene = make_warehouse(config, 1);
  std::map<std::uint32_t, int> uses;
  int pallets = 0;
  for (const Instance& instance : scene.instances) {
    const std::string& material = scene.materials[scene.meshes[instance.mesh].material].name;
    if (material == "cardboard") ++uses[instance.mesh];
    if (material == "wood_pallet") ++pallets;
  }
  ASSERT_EQ(uses.size(), 16U);
  for (const auto& [mesh, count] : uses) expect_share(count, pallets, 1.0 / 16.0);
}

TEST(TwoRoomsGapParts, AreFiveWallsAFloorAndACeiling) {
  TwoRoomsGapConfig config;
  config.room_size_m = {6.0, 5.0};
  config.height_m = 3.0;
  config.wall_thickness_m = 0.3;
  config.gap_width_m = 1.4;
  config.gap_offset_m = 0.5;
  config.gap_height_m = 2.0;
  const Scene scene = make_two_rooms_gap(config, 1);
  expect_boxes(
      boxes_of_material(scene, "plaster"),
      {box(-6.45, -2.3, 0, 6.45, -2.0, 3), box(-6.45, 3.0, 0, 6.45, 3.3, 3), box(-6.45, -2.0, 0, -6.15, 3.0, 3),
       box(6.15, -2.0, 0, 6.45, 3.0, 3), box(-0.15, -2.0, 0, 0.15, -0.7, 3), box(-0.15, -0.7, 2, 0.15, 0.7, 3),
       box(-0.15, 0.7, 0, 0.15, 3.0, 3)});
  // Floor 5 m around the middle of the walls; a slab of 0.15 m above.
  expect_boxes(boxes_of_material(scene, "concrete"),
               {box(-11.3, -7.15, 0, 11.3, 8.15, 0), box(-6.45, -2.3, 3, 6.45, 3.3, 3.15)});
  ASSERT_EQ(scene.objects.size(), 1U);
  EXPECT_EQ(scene.objects[0].instance, 1);
  EXPECT_TRUE(scene.objects[0].position_world_m.isApprox(Vector3d(0, 0, 1.0), 1e-9));
  EXPECT_EQ(attribute(scene.objects[0], "width_m"), 1.4);
  EXPECT_EQ(attribute(scene.objects[0], "height_m"), 2.0);
  for (const SurfaceClass surface_class : {SurfaceClass::kWall, SurfaceClass::kCeiling})
    EXPECT_EQ(test::bounds_of_each(scene, surface_class).begin()->first, 1);
  EXPECT_EQ(test::bounds_of_each(scene, SurfaceClass::kGround).begin()->first, 0);

  config.gap_height_m = 0.0;  // up to the ceiling
  config.ceiling = false;
  const Scene open = make_two_rooms_gap(config, 1);
  EXPECT_EQ(boxes_of_material(open, "plaster").size(), 6U);
  EXPECT_EQ(boxes_of_material(open, "concrete").size(), 1U);
  EXPECT_EQ(attribute(open.objects[0], "height_m"), 3.0);
}

TEST(TwoRoomsGap, RandomYawIsAddedToTheYawAndTurnsAllTheWay) {
  TwoRoomsGapConfig config;
  config.random_yaw = true;
  std::vector<double> turns_rad;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    config.yaw_deg = 0.0;
    const double turn_rad = make_two_rooms_gap(config, seed).objects[0].yaw_rad;
    turns_rad.push_back(turn_rad);
    config.yaw_deg = 30.0;
    EXPECT_NEAR(make_two_rooms_gap(config, seed).objects[0].yaw_rad, turn_rad + std::numbers::pi / 6.0, 1e-12);
  }
  expect_uniform(turns_rad, 0.0, 2.0 * std::numbers::pi);
}

TEST(HallParts, AreFourWallsAFloorACeilingAndAWallToHideBehind) {
  HallConfig config;
  config.size_m = {9.0, 7.0, 4.0};
  config.wall_thickness_m = 0.3;
  config.hide_center_m = {1.2, -0.4};
  config.hide_length_m = 3.0;
  config.num_crates = 0;
  for (const double height_m : {0.0, 2.5}) {
    config.hide_height_m = height_m;
    const double top = height_m > 0.0 ? height_m : 4.0;
    const Scene scene = make_hall(config, 1);
    expect_boxes(boxes_of_material(scene, "plaster"),
                 {box(-4.8, -3.8, 0, 4.8, -3.5, 4), box(-4.8, 3.5, 0, 4.8, 3.8, 4), box(-4.8, -3.5, 0, -4.5, 3.5, 4),
                  box(4.5, -3.5, 0, 4.8, 3.5, 4)});
    expect_boxes(boxes_of_material(scene, "concrete"),
                 {box(-4.8, -3.8, 0, 4.8, 3.8, 0), box(-4.8, -3.8, 4.0, 4.8, 3.8, 4.2)});
    expect_boxes(boxes_of_material(scene, "brick"), {box(1.05, -1.9, 0, 1.35, 1.1, top)});
    const auto hides = objects_of(scene, SurfaceClass::kWall);
    ASSERT_EQ(hides.size(), 1U);
    EXPECT_EQ(hides[0].instance, 2);
    EXPECT_TRUE(hides[0].position_world_m.isApprox(Vector3d(1.2, -0.4, 0.5 * top), 1e-9));
    EXPECT_NEAR(hides[0].yaw_rad, 0.5 * std::numbers::pi, 1e-12);
    EXPECT_EQ(attribute(hides[0], "height_m"), top);
    EXPECT_EQ(attribute(hides[0], "length_m"), 3.0);
    EXPECT_EQ(attribute(hides[0], "thickness_m"), 0.3);
    const auto ceilings = test::bounds_of_each(scene, SurfaceClass::kCeiling);
    ASSERT_EQ(ceilings.size(), 1U);
    EXPECT_EQ(ceilings.begin()->first, 1);
  }
  config.hide_yaw_deg = 0.0;
  config.ceiling = false;
  const Scene along = make_hall(config, 1);
  expect_boxes(boxes_of_material(along, "brick"), {box(-0.3, -0.55, 0, 2.7, -0.25, 2.5)});
  EXPECT_EQ(boxes_of_material(along, "concrete").size(), 1U);
}

TEST(Hall, CratesHaveTheirSizesAndStandAlongAllFourWalls) {
  for (const double ceiling_m : {6.0, 0.7}) {
    HallConfig config;
    config.size_m = {12.0, 8.0, ceiling_m};
    config.hide_length_m = 1.0;
    config.crate_zone_m = 0.8;
    config.num_crates = 600;
    std::map<std::pair<int, int>, int> at_wall;
    std::vector<double> depths_m, widths_m, heights_m, along;
    const Scene scene = make_hall(config, 5);
    const auto boxes = test::bounds_of_each(scene, SurfaceClass::kObject);
    ASSERT_EQ(boxes.size(), 600U);
    for (const WorldObject& crate : objects_of(scene, SurfaceClass::kObject)) {
      const AlignedBox3d& bounds = boxes.at(crate.instance);
      EXPECT_TRUE(bounds.center().isApprox(crate.position_world_m, 1e-5));
      EXPECT_EQ(crate.yaw_rad, 0.0);
      const Vector3d size(attribute(crate, "size_x_m"), attribute(crate, "size_y_m"), attribute(crate, "size_z_m"));
      EXPECT_TRUE(bounds.sizes().isApprox(size, 1e-5));
      EXPECT_NEAR(bounds.min().z(), 0.0, 1e-6);
      const Vector2d half(6.0, 4.0);
      const Vector2d gaps = half - crate.position_world_m.head<2>().cwiseAbs() - 0.5 * size.head<2>();
      const int axis = gaps.x() < gaps.y() ? 0 : 1;  // across the wall
      EXPECT_NEAR(gaps[axis], 0.0, 1e-6);
      ++at_wall[{axis, crate.position_world_m[axis] > 0.0}];
      depths_m.push_back(size[axis]);
      widths_m.push_back(size[1 - axis]);
      heights_m.push_back(size.z());
      along.push_back(crate.position_world_m[1 - axis] / (half[1 - axis] - 0.5 * size[1 - axis]));
    }
    ASSERT_EQ(at_wall.size(), 4U);
    for (const auto& [wall, count] : at_wall) expect_share(count, 600, 0.25);
    expect_uniform(depths_m, 0.4, 0.8);
    expect_uniform(widths_m, 0.5, 1.2);
    expect_uniform(along, -1.0, 1.0);
    if (ceiling_m > 1.2) {
      expect_uniform(heights_m, 0.4, 1.0);
    } else {  // nine tenths of the hall at most
      EXPECT_NEAR(*std::max_element(heights_m.begin(), heights_m.end()), 0.63, 1e-6);
      EXPECT_NEAR(*std::min_element(heights_m.begin(), heights_m.end()), 0.4, 0.02);
    }
  }
}

CampusConfig bare_campus() {
  CampusConfig config;
  config.building_size_m = {11.0, 8.2};
  config.num_trees = config.num_lamps = config.num_cars = 0;
  return config;
}

// The same in the frame of a facade: along it from its left corner, into the house, up.
struct FacadeFrame {
  int number = 0;
  Vector2d half = Vector2d::Zero();

  double length_m() const { return 2.0 * (number % 2 == 0 ? half.x() : half.y()); }
  AlignedBox3d box(double s0, double s1, double d0, double d1, double z0, double z1) const {
    const double turn_rad = 0.5 * std::numbers::pi * number;
    const Vector2d along(std::cos(turn_rad), std::sin(turn_rad)), inward(-along.y(), along.x());
    const double face_m = number % 2 == 0 ? half.y() : half.x();
    AlignedBox3d found;
    for (const double s : {s0, s1}) {
      for (const double d : {d0, d1}) {
        const Vector2d p = along * (s - 0.5 * length_m()) + inward * (d - face_m);
        found.extend(Vector3d(p.x(), p.y(), z0));
        found.extend(Vector3d(p.x(), p.y(), z1));
      }
    }
    return found;
  }
};

TEST(CampusParts, WallsHaveWindowsWithPanesMullionsAndSillsAndTwoDoorsWithSteps) {
  for (const double wall_m : {4.5, 2.5, 2.2}) {  // windows end 2.4 m up, or 0.3 m below the roof; doors at 2.1 m
    CampusConfig config = bare_campus();
    config.wall_height_m = wall_m;
    const double top = std::min(2.4, wall_m - 0.3), door_top = std::min(2.1, top);
    const Scene scene = make_campus(config, 1);
    std::vector<AlignedBox3d> walls, panes, concrete, doors;
    for (int number = 0; number < 4; ++number) {
      const FacadeFrame facade{number, 0.5 * config.building_size_m};
      const int count = number % 2 == 0 ? 4 : 3;  // one to 2.6 m
      double done = 0.0;
      for (int i = 0; i < count; ++i) {
        const double s = facade.length_m() * (i + 0.5) / count;
        if ((number == 0 && i == 2) || (number == 3 && i == 1)) {  // the door
          walls.push_back(facade.box(done, s - 0.55, 0, 0.35, 0, wall_m));
          walls.push_back(facade.box(s - 0.55, s + 0.55, 0, 0.35, door_top, wall_m));
          doors.push_back(facade.box(s - 0.55, s + 0.55, 0.095, 0.145, 0, door_top));
          concrete.push_back(facade.box(s - 0.8, s + 0.8, -0.9, 0.0, 0, 0.15));
          done = s + 0.55;
          continue;
        }
        walls.push_back(facade.box(done, s - 0.65, 0, 0.35, 0, wall_m));
        walls.push_back(facade.box(s - 0.65, s + 0.65, 0, 0.35, 0, 0.9));
        walls.push_back(facade.box(s - 0.65, s + 0.65, 0, 0.35, top, wall_m));
        panes.push_back(facade.box(s - 0.65, s + 0.65, 0.11, 0.13, 0.9, top));
        concrete.push_back(facade.box(s - 0.03, s + 0.03, 0.07, 0.13, 0.9, top));
        concrete.push_back(facade.box(s - 0.75, s + 0.75, -0.13, 0.07, 0.84, 0.9));
        done = s + 0.65;
      }
      walls.push_back(facade.box(done, facade.length_m(), 0, 0.35, 0, wall_m));
    }
    // Gables on both sides of the end walls.
    for (const double x : {-5.5, -5.15, 5.15, 5.5}) walls.push_back(box(x, -4.1, wall_m, x, 4.1, wall_m + 2.8));
    // Kerbs 0.12 m wide, inside of the path and outside of it; 0.1 m of them are in the ground.
    for (const double from : {2.88, 5.0}) {
      const Vector2d in(5.5 + from, 4.1 + from), out(in.x() + 0.12, in.y() + 0.12);
      for (const double side : {-1.0, 1.0}) {
        concrete.push_back(box(-out.x(), side * in.y(), -0.1, out.x(), side * out.y(), 0.12));
        concrete.push_back(box(side * in.x(), -in.y(), -0.1, side * out.x(), in.y(), 0.12));
      }
    }
    expect_boxes(boxes_of_material(scene, "plaster"), walls);
    expect_boxes(boxes_of_material(scene, "glass"), panes);
    expect_boxes(boxes_of_material(scene, "concrete"), concrete);
    expect_boxes(boxes_of_material(scene, "wood_painted"), doors);
  }
}

TEST(CampusParts, PathIsARingAndALawnIsUnderEverything) {
  const CampusConfig config = bare_campus();
  const Scene scene = make_campus(config, 1);
  std::vector<AlignedBox3d> path;
  const Vector2d in(8.5, 7.1), out(10.5, 9.1);
  for (const double side : {-1.0, 1.0}) {
    path.push_back(box(-out.x(), side * in.y(), 0.01, out.x(), side * out.y(), 0.01));
    path.push_back(box(side * in.x(), -in.y(), 0.01, side * out.x(), in.y(), 0.01));
  }
  expect_boxes(boxes_of_material(scene, "asphalt"), path);
  expect_boxes(boxes_of_material(scene, "grass"), {box(-45, -45, 0, 45, 45, 0)});
  const auto houses = objects_of(scene, SurfaceClass::kBuilding);
  ASSERT_EQ(houses.size(), 1U);
  EXPECT_EQ(houses[0].instance, 1);
  EXPECT_TRUE(houses[0].position_world_m.isApprox(Vector3d(0, 0, 2.25)));
  EXPECT_EQ(houses[0].yaw_rad, 0.0);
  EXPECT_EQ(attribute(houses[0], "size_x_m"), 11.0);
  EXPECT_EQ(attribute(houses[0], "size_y_m"), 8.2);
  EXPECT_NEAR(attribute(houses[0], "height_m"), 7.3, 1e-9);
  for (const SurfaceClass surface_class : {SurfaceClass::kDoor, SurfaceClass::kKerb, SurfaceClass::kBuilding}) {
    const auto each = test::bounds_of_each(scene, surface_class);
    ASSERT_EQ(each.size(), 1U);
    EXPECT_EQ(each.begin()->first, 1);
  }
}

// Two slabs that meet at the ridge; gutters and pipes of eight sides, a chimney.
TEST(CampusParts, RoofHasTwoSlabsGuttersDownpipesAndAChimney) {
  const CampusConfig config = bare_campus();
  const Scene scene = make_campus(config, 1);
  const double slope = 2.8 / 4.1, eaves = 4.5 - 0.6 * slope, ridge = 7.3, end_x = 6.1, edge_y = 4.7;
  std::vector<AlignedBox3d> slabs, details;
  for (const double side : {-1.0, 1.0}) {
    const double y = side * edge_y;
    slabs.push_back(box(-end_x, y, eaves, end_x, 0, ridge));
    slabs.push_back(box(-end_x, y, eaves + 0.18, end_x, 0, ridge + 0.18));
    slabs.push_back(box(-end_x, y, eaves, end_x, y, eaves + 0.18));
    for (const double x : {-end_x, end_x}) slabs.push_back(box(x, y, eaves, x, 0, ridge + 0.18));
    const double gutter_y = side * (edge_y + 0.07), pipe_y = side * 4.16;
    details.push_back(
        around_line({-end_x, gutter_y, eaves + 0.05}, {end_x, gutter_y, eaves + 0.05}, Vector3d(0, 0.07, 0.07)));
    for (const double x : {-5.3, 5.3})
      details.push_back(around_line({x, pipe_y, 0}, {x, pipe_y, eaves}, Vector3d(0.045, 0.045, 0)));
  }
  details.push_back(box(0.25 * 5.5, 0.35 * 4.1, 4.5 + 1.4 - 0.4, 0.25 * 5.5 + 0.7, 0.35 * 4.1 + 0.7, ridge + 0.7));
  expect_boxes(boxes_of_material(scene, "roof_tiles"), slabs);
  expect_boxes(boxes_of_material(scene, "brick"), details, 6e-3);

  // Every triangle looks out of its slab, or out of the house.
  const auto in_slab = [&](const Vector3d& p) {
    const double low = ridge - slope * std::abs(p.y());
    return std::abs(p.x()) < end_x && std::abs(p.y()) < edge_y && p.z() > low && p.z() < low + 0.18;
  };
  int looked_at = 0;
  for (const Mesh& mesh : scene.meshes) {
    const std::string& material = scene.materials[mesh.material].name;
    for (const auto& [i, j, k] : mesh.triangles) {
      const Vector3d a = mesh.vertices_mesh_m[i].cast<double>(), b = mesh.vertices_mesh_m[j].cast<double>(),
                     c = mesh.vertices_mesh_m[k].cast<double>();
      const Vector3d normal = (b - a).cross(c - a).normalized(), middle = (a + b + c) / 3.0;
      if (material == "roof_tiles") {
        EXPECT_FALSE(in_slab(middle + 1e-3 * normal)) << middle.transpose();
        EXPECT_TRUE(in_slab(middle - 1e-3 * normal)) << middle.transpose();
        ++looked_at;
      } else if (material == "plaster" && std::abs(normal.x()) > 0.99 && middle.z() > 4.6) {
        const bool outer = std::abs(middle.x()) > 5.3;
        EXPECT_EQ(normal.x() * middle.x() > 0.0, outer) << middle.transpose();
        ++looked_at;
      }
    }
  }
  EXPECT_EQ(looked_at, 2 * 5 * 2 + 4);
}

const Mesh& mesh_of_material(const Scene& scene, const std::string& material) {
  for (const Mesh& mesh : scene.meshes) {
    if (scene.materials[mesh.material].name == material) return mesh;
  }
  throw std::logic_error("no mesh of " + material);
}

void expect_tube(const Piece& piece, std::size_t sides, const Ring& from, const Ring& to) {
  const std::vector<Ring> rings = test::rings_of(piece, sides);
  ASSERT_EQ(rings.size(), 2U);
  EXPECT_TRUE(rings[0].center.isApprox(from.center, 1e-4)) << rings[0].center.transpose();
  EXPECT_TRUE(rings[1].center.isApprox(to.center, 1e-4)) << rings[1].center.transpose();
  EXPECT_NEAR(rings[0].radius_m, from.radius_m, 1e-4);
  EXPECT_NEAR(rings[1].radius_m, to.radius_m, 1e-4);
}

TEST(CampusParts, ALampIsAPoleWithAnArmAndAHeadThatLooksAtTheHouse) {
  CampusConfig config = bare_campus();
  config.num_lamps = 30;
  const Scene scene = make_campus(config, 1);
  const auto pieces = test::pieces_in(mesh_of_material(scene, "steel_galvanized"));
  ASSERT_EQ(pieces.size(), 3U);
  expect_tube(pieces[0], 10, {{0, 0, -0.1}, 0.08}, {{0, 0, 5.0}, 0.05});
  expect_tube(pieces[1], 8, {{0, 0, 4.95}, 0.04}, {{1.1, 0, 5.2}, 0.03});
  EXPECT_TRUE(test::box_around(pieces[2]).isApprox(box(0.9, -0.12, 5.15, 1.5, 0.12, 5.27), 1e-5));
  for (const WorldObject& lamp : objects_of(scene, SurfaceClass::kPillar)) {
    const Vector2d at = lamp.position_world_m.head<2>();
    EXPECT_NEAR(Vector2d(std::cos(lamp.yaw_rad), std::sin(lamp.yaw_rad)).dot(-at.normalized()), 1.0, 1e-9);
    EXPECT_NEAR(attribute(lamp, "height_m"), 5.27, 1e-9);
  }
}

TEST(CampusParts, ACarIsABodyACabinThatNarrowsAndFourWheels) {
  CampusConfig config = bare_campus();
  config.num_cars = 3;
  const Scene scene = make_campus(config, 1);
  EXPECT_TRUE(bounds_m(mesh_of_material(scene, "car_paint"))
                  .cast<double>()
                  .isApprox(box(-2.15, -0.88, 0.25, 2.15, 0.88, 0.85), 1e-5));
  Eigen::AlignedBox3d waist, roof;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.surface_class != SurfaceClass::kObject || scene.materials[mesh.material].name != "glass") continue;
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m)
      (vertex.z() < 1.0F ? waist : roof).extend(vertex.cast<double>());
  }
  EXPECT_TRUE(waist.isApprox(box(-1.7, -0.85, 0.85, 1.2, 0.85, 0.85), 1e-5));
  EXPECT_TRUE(roof.isApprox(box(-1.154, -0.68, 1.45, 0.644, 0.68, 1.45), 1e-5));
  const auto wheels = test::pieces_in(mesh_of_material(scene, "plastic_dark"));
  ASSERT_EQ(wheels.size(), 4U);
  std::size_t next = 0;
  for (const double x : {-1.35, 1.35}) {
    for (const double y : {-0.8, 0.8})
      expect_tube(wheels[next++], 14, {{x, y - 0.1, 0.31}, 0.31}, {{x, y + 0.1, 0.31}, 0.31});
  }
  for (const WorldObject& car : objects_of(scene, SurfaceClass::kObject))
    EXPECT_NEAR(attribute(car, "height_m"), 1.45, 1e-9);
}

// Things stand right up to the free ring, the keep-clear zones and a meter from the border, and no nearer.
TEST(Campus, ThingsStandAsNearToWhatStaysFreeAsTheyReachAndNoNearer) {
  for (const bool cars : {false, true}) {
    CampusConfig config = bare_campus();
    config.size_m = {70.0, 60.0};
    config.tree_spacing_m = 0.2;
    config.keep_clear.clearings = {{{28.0, 20.0}, 4.0}};
    (cars ? config.num_cars : config.num_lamps) = 2500;
    const double reach_m = cars ? 2.5 : 1.6;
    double to_walls_m = 1e9, to_zone_m = 1e9;
    Vector2d farthest = Vector2d::Zero();
    std::vector<double> yaws_rad;
    for (const WorldObject& thing :
         objects_of(make_campus(config, 3), cars ? SurfaceClass::kObject : SurfaceClass::kPillar)) {
      const Vector2d p = thing.position_world_m.head<2>();
      to_walls_m = std::min(to_walls_m, (p.cwiseAbs() - Vector2d(5.5, 4.1)).cwiseMax(0.0).norm());
      to_zone_m = std::min(to_zone_m, (p - Vector2d(28, 20)).norm() - 4.0);
      farthest = farthest.cwiseMax(p.cwiseAbs());
      yaws_rad.push_back(thing.yaw_rad);
    }
    EXPECT_GE(to_walls_m, 9.0 + reach_m);
    EXPECT_LT(to_walls_m, 9.0 + reach_m + 0.1);
    EXPECT_GE(to_zone_m, reach_m);
    EXPECT_LT(to_zone_m, reach_m + 0.2);
    EXPECT_LE(farthest.x(), 34.0);
    EXPECT_GT(farthest.x(), 33.9);
    EXPECT_LE(farthest.y(), 29.0);
    EXPECT_GT(farthest.y(), 28.9);
    if (cars) expect_uniform(yaws_rad, 0.0, 2.0 * std::numbers::pi);
  }
}

TEST(Campus, TreesAreLowBroadleafTreesAndSpruces) {
  CampusConfig config = bare_campus();
  config.size_m = {300.0, 300.0};
  config.num_trees = 1500;
  config.tree_spacing_m = 1.0;
  config.detail = 0.05;
  std::vector<double> diameters_m, yaws_rad;
  const auto trees = objects_of(make_campus(config, 1), SurfaceClass::kTrunk);
  ASSERT_EQ(trees.size(), 1500U);
  int broadleaf = 0;
  for (const WorldObject& tree : trees) {
    broadleaf += tree.kind == "broadleaf";
    EXPECT_EQ(tree.position_world_m.z(), 0.0);
    diameters_m.push_back(attribute(tree, "dbh_m"));
    yaws_rad.push_back(tree.yaw_rad);
  }
  expect_share(broadleaf, 1500, 0.75);
  expect_uniform(diameters_m, 0.15, 0.45);
  expect_uniform(yaws_rad, 0.0, 2.0 * std::numbers::pi);
}

}  // namespace
}  // namespace swiftlet::sim
