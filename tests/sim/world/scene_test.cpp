// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/world/dice.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/world/cloud.hpp"
#include "swiftlet/sim/world/export.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "tests/sim/world/world_support.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

const Material kGray{"gray", 0.4F, false, {0.5F, 0.5F, 0.5F}};
const Material kTape{"tape", 0.9F, true, {1.0F, 0.25F, 0.0F}};

Mesh box_mesh(const Vector3f& low, const Vector3f& high) {
  Mesh mesh;
  add_box(mesh, low, high);
  return mesh;
}

TEST(SurfaceClasses, RoundTripThroughTheirNames) {
  std::size_t count = 0;
  for (const char* name : static_class_names()) {
    const auto found = surface_class_of(name);
    ASSERT_TRUE(found) << name;
    EXPECT_STREQ(name_of(*found), name);
    ++count;
  }
  EXPECT_EQ(count, 17U);
  EXPECT_STREQ(name_of(SurfaceClass::kVehicle), "vehicle");
  EXPECT_FALSE(surface_class_of("vehicle")) << "the static world has none";
  EXPECT_FALSE(surface_class_of("")) << "no name";
  EXPECT_STREQ(name_of(static_cast<SurfaceClass>(9999)), "unlabeled");
  EXPECT_STREQ(name_of(VehiclePart::kNone), "none");
  EXPECT_STREQ(name_of(VehiclePart::kMarker), "marker");
}

TEST(Pieces, ConnectByCornersOrTheirRepresentatives) {
  Mesh mesh;
  mesh.vertices_mesh_m.assign(11, Vector3f::Zero());
  mesh.triangles = {{8, 1, 4}, {2, 3, 5}, {4, 6, 0}, {9, 10, 10}};
  EXPECT_EQ(pieces_of(mesh), (std::vector<std::uint32_t>{0, 0, 2, 2, 0, 2, 0, 7, 0, 9, 9}));
  std::vector<std::uint32_t> welded = {0, 1, 2, 3, 4, 1, 6, 7, 8, 9, 10};  // corner 5 lies where corner 1 does
  EXPECT_EQ(pieces_of(mesh, welded), (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 0, 0, 7, 0, 9, 9}));
}

TEST(SceneBuilder, NumbersInstancesUpToLabelLimit) {
  SceneBuilder builder;
  EXPECT_EQ(builder.next_instance(SurfaceClass::kTrunk), 1);
  EXPECT_EQ(builder.next_instance(SurfaceClass::kTrunk), 2);
  EXPECT_EQ(builder.next_instance(SurfaceClass::kRack), 1);
  for (int i = 3; i < 65535; ++i) builder.next_instance(SurfaceClass::kTrunk);
  EXPECT_EQ(builder.next_instance(SurfaceClass::kTrunk), 65535);
  EXPECT_THROW(builder.next_instance(SurfaceClass::kTrunk), InputError);
  EXPECT_EQ(builder.next_instance(SurfaceClass::kRack), 2);
}

TEST(SceneBuilder, SharesMaterialsAndKeepsPlacedMeshes) {
  SceneBuilder builder;
  const std::uint32_t first = builder.add_mesh(box_mesh({0, 0, 0}, {1, 1, 1}), kGray, SurfaceClass::kWall);
  const std::uint32_t second = builder.add_mesh(box_mesh({0, 0, 0}, {2, 2, 2}), kTape, SurfaceClass::kMarking);
  const std::uint32_t third = builder.add_mesh(box_mesh({0, 0, 0}, {3, 3, 3}), kGray, SurfaceClass::kObject);
  EXPECT_EQ(std::tuple(first, second, third), std::tuple(0U, 1U, 2U));
  builder.place(third, 4, transform({10, 0, 0}));
  builder.place(first, 5, transform({0, 10, 0}));
  builder.place(third, 6, transform({0, 0, 10}));
  builder.add(Mesh(), kGray, SurfaceClass::kObject, 7);
  const Scene scene = builder.finish();
  EXPECT_EQ(scene.materials.size(), 2U);
  ASSERT_EQ(scene.meshes.size(), 2U);
  ASSERT_EQ(scene.instances.size(), 3U);
  EXPECT_EQ(scene.meshes[scene.instances[0].mesh].surface_class, SurfaceClass::kObject);
  EXPECT_EQ(scene.meshes[scene.instances[1].mesh].surface_class, SurfaceClass::kWall);
  EXPECT_EQ(scene.instances[0].mesh, scene.instances[2].mesh);
  EXPECT_EQ(scene.num_triangles(), 36U);
  EXPECT_TRUE(scene.bounds_m.isApprox(Eigen::AlignedBox3d(Vector3d(0, 0, 0), Vector3d(13, 11, 13)), 1e-6));
  EXPECT_TRUE(builder.finish().instances.empty()) << "the builder is empty afterwards";
}

TEST(SceneBuilder, SurroundingsExtendOnlyTheBoundsHeight) {
  SceneBuilder builder;
  builder.add(box_mesh({-1, -2, 0}, {1, 2, 3}), kGray, SurfaceClass::kWall);
  builder.add(box_mesh({0, 0, 0}, {5, 1, 1}), kGray, SurfaceClass::kWall);
  builder.begin_surroundings();
  builder.add(box_mesh({-9, -9, -4}, {9, 9, 7}), kGray, SurfaceClass::kWall);
  const Scene scene = builder.finish();
  EXPECT_TRUE(scene.bounds_m.isApprox(Eigen::AlignedBox3d(Vector3d(-1, -2, -4), Vector3d(5, 2, 7)), 1e-6));
  builder.begin_surroundings();
  builder.add(box_mesh({-9, -9, -4}, {9, 9, 7}), kGray, SurfaceClass::kWall);
  EXPECT_TRUE(builder.finish().bounds_m.isApprox(Eigen::AlignedBox3d(Vector3d(-9, -9, -4), Vector3d(9, 9, 7)), 1e-6))
      << "nothing is within";
}

TEST(Transform, ScalesThenTurnsThenShifts) {
  const Eigen::Affine3f T = transform({10, 20, 30}, static_cast<float>(M_PI / 2), {2, 3, 4});
  EXPECT_TRUE((T * Vector3f(1, 0, 0)).isApprox(Vector3f(10, 22, 30), 1e-5F));
  EXPECT_TRUE((T * Vector3f(0, 1, 0)).isApprox(Vector3f(7, 20, 30), 1e-5F));
  EXPECT_TRUE((T * Vector3f(0, 0, 1)).isApprox(Vector3f(10, 20, 34), 1e-5F));
}

TEST(Dice, ThrowsEvenlyAndIndependentlyPerKey) {
  const Random random(1, "test.dice");
  std::vector<double> picks, angles, direction_z, direction_angles;
  for (std::uint32_t i = 0; i < 500; ++i) {
    Dice dice(random, i), again(random, i);
    EXPECT_EQ(dice.uniform(2.0, 3.0), again.uniform(2.0, 3.0));
    picks.push_back(dice.pick(5));
    angles.push_back(dice.angle_rad());
    const Vector3f d = dice.direction();
    EXPECT_NEAR(d.norm(), 1.0F, 1e-5F);
    direction_z.push_back(d.z());
    direction_angles.push_back(std::atan2(d.y(), d.x()));
  }
  for (const int pick : {0, 1, 2, 3, 4})
    test::expect_share(static_cast<double>(std::count(picks.begin(), picks.end(), pick)), 500, 0.2);
  test::expect_uniform(angles, 0.0, 2.0 * M_PI);
  test::expect_uniform(direction_z, -1.0, 1.0);
  test::expect_uniform(direction_angles, -M_PI, M_PI);
}

Scene two_boxes() {
  SceneBuilder builder;
  const std::uint32_t mesh = builder.add_mesh(box_mesh({0, 0, 0}, {1, 2, 4}), kTape, SurfaceClass::kMarking);
  builder.add(box_mesh({-1, -1, -1}, {0, 0, 0}), kGray, SurfaceClass::kWall, 3);
  builder.place(mesh, 1, transform({10, 0, 0}, static_cast<float>(M_PI / 2)));
  builder.place(mesh, 2, transform({0, 20, 0}));
  builder.add_object({3, SurfaceClass::kWall, "hide", {1.5, -2, 3}, 0.25, {{"length_m", 4.0}}});
  builder.add_object({1, SurfaceClass::kMarking, "sign", {0, 0.5, 0}, -1.0, {{"height_m", 2.0}, {"length_m", 0.125}}});
  return builder.finish();
}

TEST(Export, ListsMaterialsAndObjects) {
  const TemporaryDirectory folder;
  export_world(two_boxes(), folder.path() / "w.obj");
  const std::string mtl = read_whole_file(folder.path() / "w.mtl");
  EXPECT_THAT(mtl, testing::HasSubstr("newmtl gray\n# reflectivity 0.4\nKd 0.5 0.5 0.5\n"));
  EXPECT_THAT(mtl, testing::HasSubstr("newmtl tape\n# reflectivity 0.9 retroreflective\nKd 1 0.25 0\n"));
  EXPECT_EQ(read_whole_file(folder.path() / "w.objects.csv"),
            "class,instance,kind,x_m,y_m,z_m,yaw_rad,length_m,height_m\n"
            "wall,3,hide,1.5,-2,3,0.25,4,\n"
            "marking,1,sign,0,0.5,0,-1,0.125,2\n");
}

TEST(Cloud, IsScaledTurnedAndShifted) {
  const TemporaryDirectory folder;
  write_file(folder.path() / "a.pcd",
             "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 1\nDATA ascii\n100 210 300\n");
  CloudConfig config;
  config.file = (folder.path() / "a.pcd").string();
  config.scale = 0.01;
  config.leaf_m = 0.4;
  config.surface_class = "building";
  config.reflectivity = 0.7;
  config.yaw_deg = 90.0;
  config.position_m = {10.0, 0.0, 1.1};  // to 7.9, 1, 4.1 m
  const Scene scene = make_cloud(config, 1);
  EXPECT_TRUE(scene.bounds_m.min().isApprox(Vector3d(7.6, 0.8, 4.0), 1e-5)) << scene.bounds_m.min().transpose();
  EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(8.0, 1.2, 4.4), 1e-5));
  ASSERT_EQ(scene.instances.size(), 1U);
  EXPECT_EQ(scene.instances[0].instance, 1);
  EXPECT_EQ(scene.meshes[0].surface_class, SurfaceClass::kBuilding);
  EXPECT_EQ(scene.materials[0].reflectivity, 0.7F);
  config.file.clear();
  EXPECT_THROW(make_cloud(config, 1), InputError);
}

}  // namespace
}  // namespace swiftlet::sim
