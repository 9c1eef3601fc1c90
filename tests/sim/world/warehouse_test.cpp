// SPDX-License-Identifier: BSD-3-Clause
// The hall and its racks, measured with a tape: rays across and boxes around.
#include "swiftlet/sim/world/warehouse.hpp"

#include <gtest/gtest.h>

#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using test::bounds_of;
using test::bounds_of_each;
using test::free_width_m;

WarehouseConfig empty_racks() {
  WarehouseConfig config;
  config.fill = 0.0;
  config.end_aisle_m = 4.4;
  return config;
}

double racks_end_x_m(const WarehouseConfig& config) { return 0.5 * config.num_bays() * config.bay_width_m; }

TEST(Warehouse, KeepsPromisedAisleWidthBetweenRacks) {
  const WarehouseConfig config = empty_racks();
  const Scene scene = make_warehouse(config, 1);
  ASSERT_GE(config.aisle_width(), config.aisle_width_m);
  const double at_uprights_m = racks_end_x_m(config) - config.bay_width_m;
  for (int aisle = 0; aisle <= config.num_double_rows(); ++aisle) {
    EXPECT_NEAR(free_width_m(scene, {at_uprights_m, config.aisle_center_y_m(aisle), 0.2}, Vector3d::UnitY()),
                config.aisle_width(), 1e-4);
  }
}

TEST(Warehouse, FillsBaysLeavingEndAislesFree) {
  for (const double end_aisle_m : {3.0, 4.4, 5.0, 6.1}) {
    WarehouseConfig config;
    config.end_aisle_m = end_aisle_m;
    const double left_m = 0.5 * config.size_m.x() - racks_end_x_m(config);
    EXPECT_GE(left_m, end_aisle_m);
    EXPECT_LT(left_m, end_aisle_m + 0.5 * config.bay_width_m);
  }
}

TEST(Warehouse, KeepsBaysOpenBetweenTheirUprights) {
  const WarehouseConfig config = empty_racks();
  const Scene scene = make_warehouse(config, 1);
  const double face_m = config.row_center_y_m(1) + 0.1 + 0.05;  // inside the uprights of the northern rack
  for (const int bay : {0, 4, config.num_bays() - 1}) {
    const Vector3d in_bay(-racks_end_x_m(config) + (bay + 0.5) * config.bay_width_m, face_m, 0.2);
    EXPECT_NEAR(free_width_m(scene, in_bay, Vector3d::UnitX()), config.bay_width_m - 0.1, 1e-4);
    EXPECT_NEAR(free_width_m(scene, in_bay - Vector3d(0, 0.03, 0), Vector3d::UnitZ()), config.level_height_m - 0.11,
                1e-4);
  }
}

TEST(Warehouse, RoofCoversExactlyTheWalls) {
  const Scene scene = make_warehouse(empty_racks(), 1);
  const Eigen::AlignedBox3d walls = bounds_of(scene, SurfaceClass::kWall),
                            roof = bounds_of(scene, SurfaceClass::kCeiling);
  EXPECT_TRUE(roof.min().head<2>().isApprox(walls.min().head<2>(), 1e-5));
  EXPECT_TRUE(roof.max().head<2>().isApprox(walls.max().head<2>(), 1e-5));
  EXPECT_NEAR(walls.sizes().x(), 40.0 + 2 * 0.2, 1e-4);
  EXPECT_NEAR(walls.sizes().y(), 26.0 + 2 * 0.2, 1e-4);
}

TEST(Warehouse, FillsGateWithBothDoorLeaves) {
  WarehouseConfig config = empty_racks();
  config.door_offset_m = 1.5;
  const auto leaves = bounds_of(make_warehouse(config, 1), SurfaceClass::kDoor);
  EXPECT_NEAR(leaves.min().y(), 1.5 - 0.5 * config.gate_width_m, 1e-4);
  EXPECT_NEAR(leaves.max().y(), 1.5 + 0.5 * config.gate_width_m, 1e-4);
  EXPECT_NEAR(leaves.max().z(), config.gate_height_m, 1e-4);
}

TEST(Warehouse, TapesBothSidesOfEveryAisle) {
  const WarehouseConfig config = empty_racks();
  const Scene scene = make_warehouse(config, 1);
  const auto tapes = bounds_of_each(scene, SurfaceClass::kMarking);
  for (int aisle = 0; aisle <= config.num_double_rows(); ++aisle) {
    for (const double side : {-1.0, 1.0}) {
      const double y_m = config.aisle_center_y_m(aisle) + side * (0.5 * config.aisle_width() - 0.25);
      const auto lines = std::count_if(tapes.begin(), tapes.end(), [&](const auto& tape) {
        const Eigen::AlignedBox3d& box = tape.second;
        return std::abs(box.center().y() - y_m) < 1e-4 && std::abs(box.center().x()) < 1e-4 &&
               std::abs(box.sizes().x() - 2.0 * racks_end_x_m(config)) < 1e-4;
      });
      EXPECT_EQ(lines, 1) << "aisle " << aisle;
    }
  }
}

// EUR pallets, 1.2 x 0.8 x 0.144 m. A load stays on its pallet, and a pallet and its load stay in their place of the
// rack.
TEST(Warehouse, KeepsLoadsOnStandardSizePallets) {
  WarehouseConfig config;
  config.fill = 1.0;
  const Scene scene = make_warehouse(config, 3);
  std::map<std::uint32_t, Eigen::AlignedBox3f> meshes;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class != SurfaceClass::kPallet || meshes.contains(instance.mesh)) continue;
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) meshes[instance.mesh].extend(vertex);
  }
  ASSERT_GT(meshes.size(), 10U);  // the pallet and its loads
  const Eigen::AlignedBox3f pallet(Eigen::Vector3f(-0.4F, -0.6F, 0.0F), Eigen::Vector3f(0.4F, 0.6F, 0.144F));
  int num_pallets = 0;
  for (const auto& [mesh, box] : meshes) {
    if (box.min().z() < 0.1F) {
      ++num_pallets;
      EXPECT_TRUE(box.isApprox(pallet, 1e-5F));
      continue;
    }
    EXPECT_NEAR(box.min().z(), 0.144F, 1e-5F);
    EXPECT_GE(box.min().x(), -0.4F);
    EXPECT_GE(box.min().y(), -0.6F);
    EXPECT_LE(box.max().x(), 0.4F);
    EXPECT_LE(box.max().y(), 0.6F);
    EXPECT_LT(box.max().z(), config.level_height_m - 0.11);  // below the next beams
  }
  EXPECT_EQ(num_pallets, 1);
}

TEST(Warehouse, NumbersThingsPerClassWithoutGaps) {
  const Scene scene = make_warehouse({}, 1);
  for (const SurfaceClass surface_class :
       {SurfaceClass::kWall, SurfaceClass::kDoor, SurfaceClass::kCeiling, SurfaceClass::kPillar, SurfaceClass::kRack,
        SurfaceClass::kPallet, SurfaceClass::kMarking}) {
    const auto numbers = bounds_of_each(scene, surface_class);
    ASSERT_FALSE(numbers.empty()) << name_of(surface_class);
    EXPECT_EQ(numbers.begin()->first, 1) << name_of(surface_class);
    EXPECT_EQ(numbers.rbegin()->first, numbers.size()) << name_of(surface_class);
  }
}

}  // namespace
}  // namespace swiftlet::sim
