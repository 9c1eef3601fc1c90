// SPDX-License-Identifier: BSD-3-Clause
// Worlds out to files and back, and files that are not what they should be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "sim/world/dice.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/world/cloud.hpp"
#include "swiftlet/sim/world/export.hpp"
#include "swiftlet/sim/world/forest_thesis.hpp"
#include "swiftlet/sim/world/hall.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "swiftlet/sim/world/mesh_import.hpp"
#include "swiftlet/sim/world/point_cloud_file.hpp"
#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;

const fs::path kData = fs::path(SWIFTLET_SOURCE_DIR) / "tests/sim/world/data";

class WorldFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              (std::string("swiftlet_world_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  static std::string read(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }

  fs::path folder_;
};

Scene import_mesh(const fs::path& file) {
  MeshImportConfig config;
  config.file = file.string();
  return make_mesh_import(config, 1);
}

// The text of the InputError that a call must throw.
template <class Call>
std::string rejection(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

ForestThesisConfig few_trees() {
  ForestThesisConfig config;
  config.num_trees = 7;
  return config;
}

using Label = std::pair<SurfaceClass, std::uint16_t>;

std::set<Label> labels_of(const Scene& scene) {
  std::set<Label> labels;
  for (const Instance& instance : scene.instances)
    labels.insert({scene.meshes[instance.mesh].surface_class, instance.instance});
  return labels;
}

TEST_F(WorldFiles, RoundTripsObjTrianglesAndLabels) {
  const Scene scene = make_forest_thesis(few_trees(), 1);
  const auto written = export_world(scene, folder_ / "forest.obj");
  EXPECT_THAT(written,
              testing::ElementsAre(folder_ / "forest.obj", folder_ / "forest.mtl", folder_ / "forest.objects.csv"));
  const Scene back = import_mesh(folder_ / "forest.obj");
  EXPECT_EQ(back.num_triangles(), scene.num_triangles());
  EXPECT_TRUE(back.bounds_m.isApprox(scene.bounds_m, 1e-5));
  std::set<Label> expected = labels_of(scene);
  expected.erase({SurfaceClass::kGround, 0});
  expected.insert({SurfaceClass::kGround, 1});  // an unnumbered object gets the next number
  EXPECT_EQ(labels_of(back), expected);
}

TEST_F(WorldFiles, RoundTripsPlyTriangles) {
  const Scene scene = make_forest_thesis(few_trees(), 1);
  export_world(scene, folder_ / "forest.ply");
  const Scene back = import_mesh(folder_ / "forest.ply");
  EXPECT_EQ(back.num_triangles(), scene.num_triangles());
  EXPECT_TRUE(back.bounds_m.isApprox(scene.bounds_m, 1e-5));
  const Vector3d eye(0, 0, 40);
  for (int i = 0; i < 100; ++i) {
    const Vector3d direction = Vector3d(0.5 * std::sin(i), 0.7 * std::cos(2.3 * i), -1).normalized();
    const auto before = test::trace(scene, eye, direction);
    const auto after = test::trace(back, eye, direction);
    ASSERT_EQ(before.has_value(), after.has_value());
    if (before) {
      EXPECT_NEAR(before->range_m, after->range_m, 1e-4);
    }
  }
}

TEST_F(WorldFiles, PlyVerticesCarryTheTruth) {
  const Scene scene = make_forest_thesis(few_trees(), 1);
  export_world(scene, folder_ / "forest.ply");
  const std::string content = read(folder_ / "forest.ply");
  const std::size_t begin = content.find("end_header\n") + 11;
  constexpr std::size_t kStride = 12 + 3 + 2 + 2 + 4 + 1;
  std::size_t row = begin;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::size_t i = 0; i < mesh.vertices_mesh_m.size(); ++i, row += kStride) {
      std::uint16_t label[2];
      float reflectivity = 0;
      std::memcpy(label, content.data() + row + 15, sizeof label);
      std::memcpy(&reflectivity, content.data() + row + 19, sizeof reflectivity);
      ASSERT_EQ(label[0], static_cast<std::uint16_t>(mesh.surface_class));
      ASSERT_EQ(label[1], instance.instance);
      ASSERT_EQ(reflectivity, scene.materials[mesh.material].reflectivity);
    }
  }
  EXPECT_EQ(content.size() - row, 13 * scene.num_triangles());
}

TEST_F(WorldFiles, ObjectTableIsTheStemMap) {
  const Scene scene = make_forest_thesis(few_trees(), 1);
  export_world(scene, folder_ / "forest.ply");
  std::istringstream table(read(folder_ / "forest.objects.csv"));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "class,instance,kind,x_m,y_m,z_m,yaw_rad,dbh_m,height_m,crown_base_m,crown_radius_m");
  int rows = 0;
  for (; std::getline(table, line); ++rows) {
    std::istringstream fields(line);
    std::string name, kind, text;
    std::getline(fields, name, ',');
    std::getline(fields, text, ',');
    std::getline(fields, kind, ',');
    EXPECT_EQ(name, "trunk");
    EXPECT_EQ(text, std::to_string(rows + 1));
    std::vector<double> numbers;
    while (std::getline(fields, text, ',')) numbers.push_back(std::stod(text));
    const WorldObject& tree = scene.objects[rows];
    EXPECT_THAT(numbers,
                testing::ElementsAre(tree.position_world_m.x(), tree.position_world_m.y(), tree.position_world_m.z(),
                                     0.0, test::attribute(tree, "dbh_m"), test::attribute(tree, "height_m"),
                                     test::attribute(tree, "crown_base_m"), test::attribute(tree, "crown_radius_m")));
  }
  EXPECT_EQ(rows, 7);
}

TEST_F(WorldFiles, ExportLeavesNothingHalfWritten) {
  const Scene scene = make_hall({}, 1);
  EXPECT_THROW(export_world(scene, folder_ / "hall.glb"), InputError);
  EXPECT_THROW(export_world(scene, folder_ / "missing" / "hall.ply"), std::runtime_error);
  EXPECT_TRUE(fs::is_empty(folder_));
  export_world(scene, folder_ / "hall.ply");
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(WorldFiles, AssignsClassAndReflectivityByName) {
  MeshImportConfig config;
  config.file = write("two.obj",
                      "o GateLeft\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\no Sign.001\nv 0 5 0\nv 1 5 0\nv 0 5 1\nf 4 5 "
                      "6\no Rest\nv 0 9 0\nv 1 9 0\nv 0 9 1\nf 7 8 9\n")
                    .string();
  config.surfaces = {{"Gate", "door", 0.2, false}, {"Sign", "marking", 0.9, true}};
  config.surface_class = "wall";
  config.reflectivity = 0.6;
  const Scene scene = make_mesh_import(config, 1);
  ASSERT_EQ(scene.instances.size(), 3U);
  const auto material_at = [&](double y) {
    for (const Instance& instance : scene.instances) {
      const Mesh& mesh = scene.meshes[instance.mesh];
      if (std::abs(mesh.vertices_mesh_m[0].y() - y) < 0.1)
        return std::tuple(mesh.surface_class, scene.materials[mesh.material].reflectivity,
                          scene.materials[mesh.material].retroreflective);
    }
    return std::tuple(SurfaceClass::kUnlabeled, 0.0F, false);
  };
  EXPECT_EQ(material_at(0), std::tuple(SurfaceClass::kDoor, 0.2F, false));
  EXPECT_EQ(material_at(5), std::tuple(SurfaceClass::kMarking, 0.9F, true));
  EXPECT_EQ(material_at(9), std::tuple(SurfaceClass::kWall, 0.6F, false));
}

TEST_F(WorldFiles, PlacesMeshByConfiguredTransform) {
  MeshImportConfig config;
  // A pole of height 200 (cm) along the file's y axis, at x = 100.
  config.file = write("pole.obj", "v 100 0 0\nv 100 200 0\nv 110 0 0\nf 1 2 3\n").string();
  config.up_axis = MeshImportConfig::UpAxis::kY;
  config.scale = 0.01;
  config.yaw_deg = 90.0;
  config.position_m = {10, 20, 1};
  const Scene scene = make_mesh_import(config, 1);
  EXPECT_TRUE(scene.bounds_m.min().isApprox(Vector3d(10, 21, 1), 1e-5)) << scene.bounds_m.min().transpose();
  EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(10, 21.1, 3), 1e-5)) << scene.bounds_m.max().transpose();
}

std::string binary_stl(const Mesh& mesh) {
  std::string content(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  content.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& triangle : mesh.triangles) {
    content.append(12, '\0');
    for (const std::uint32_t corner : triangle)
      content.append(reinterpret_cast<const char*>(mesh.vertices_mesh_m[corner].data()), 12);
    content.append(2, '\0');
  }
  return content;
}

TEST_F(WorldFiles, StlIsRead) {
  Mesh ball;
  add_icosphere(ball, {1, 2, 3}, 0.5F, 2);
  const Scene scene = import_mesh(write("ball.stl", binary_stl(ball)));
  EXPECT_EQ(scene.num_triangles(), 320U);
  EXPECT_TRUE(scene.bounds_m.center().isApprox(Vector3d(1, 2, 3), 1e-4));
}

TEST_F(WorldFiles, StlOfWordsIsRead) {
  const Scene scene = import_mesh(write("one.stl",
                                        "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 2\nvertex 3 0 2\n"
                                        "vertex 0 4 2\nendloop\nendfacet\nendsolid one\n"));
  EXPECT_EQ(scene.num_triangles(), 1U);
  EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(3, 4, 2), 1e-6));
}

// "fence_3" is as long as "trunk_3", and no class of ours.
TEST_F(WorldFiles, UnknownNamesGetConfiguredClass) {
  MeshImportConfig config;
  config.surface_class = "wall";
  config.file = write("names.obj",
                      "o fence_3\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\no trunks\nv 0 5 0\nv 1 5 0\nv 0 5 1\nf 4 5 6\n"
                      "o trunk\nv 0 9 0\nv 1 9 0\nv 0 9 1\nf 7 8 9\n")
                    .string();
  const Scene scene = make_mesh_import(config, 1);
  ASSERT_EQ(scene.instances.size(), 3U);
  for (const Mesh& mesh : scene.meshes) EXPECT_EQ(mesh.surface_class, SurfaceClass::kWall);
}

TEST_F(WorldFiles, RefusesInvalidMeshesWithReason) {
  EXPECT_THAT(rejection([&] { import_mesh(write("a.obj", "")); }), AllOf(HasSubstr("a.obj"), HasSubstr("empty")));
  EXPECT_THAT(rejection([&] { import_mesh(write("b.obj", "this is no mesh\n")); }), HasSubstr("b.obj"));
  EXPECT_THAT(rejection([&] { import_mesh(write("c.dae", "<xml/>")); }), HasSubstr(".obj, .ply or .stl"));
  EXPECT_THAT(
      rejection([&] {
        import_mesh(write(
            "d.ply",
            "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nelement face 1\nend_header\n1\n"));
      }),
      HasSubstr("truncated"));
  EXPECT_THAT(
      rejection([&] { import_mesh(write("e.stl", std::string(80, ' ') + std::string("\xff\xff\xff\x7f", 4))); }),
      HasSubstr("truncated"));
  EXPECT_THAT(rejection([&] {
                import_mesh(write("f.ply",
                                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float "
                                  "y\nproperty float z\nend_header\n0 0 0\n"));
              }),
              HasSubstr("face"));
  EXPECT_THAT(rejection([&] {
                import_mesh(write(
                    "l.ply",
                    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                    "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"));
              }),
              HasSubstr("elements 'face', found none"));
  EXPECT_THAT(rejection([&] { import_mesh({}); }), HasSubstr("expected the name"));
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  EXPECT_NO_THROW(import_mesh(write("h.ply", ply + "4 0 1 2 3\n")));
  for (const char* corners : {"2147483647", "4294967295", "-1"}) {
    EXPECT_THAT(rejection([&] { import_mesh(write("k.ply", ply + corners + " 0 1 2 3\n")); }),
                HasSubstr("face 0: expected a list"));
  }
  EXPECT_THROW(import_mesh(write("j.ply", ply + "4 0 1 2 7\n")), InputError);
  EXPECT_THROW(import_mesh(folder_ / "missing.obj"), InputError);
  EXPECT_THROW(import_mesh(write("g.obj", "v 0 0 0\nv nan 0 0\nv 0 inf 1\nf 1 2 3\n")), InputError);
}

// Data beyond the end of the file are not read as the length of a face.
TEST_F(WorldFiles, RefusesPlyMeshTruncatedInFaces) {
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uint int vertex_indices\nend_header\n";
  const std::string vertices(48, '\0'), face("\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\3\0\0\0", 20);
  EXPECT_THAT(rejection([&] { import_mesh(write("one.ply", head + vertices + face)); }),
              HasSubstr("truncated: it ends before 'vertex_indices' of face 1"));
}

// With another format, text would be read as the length of a list: gigabytes for a file of 800 bytes.
TEST_F(WorldFiles, RequiresOnePlyFormatVersionOne) {
  const auto with_formats = [](const std::string& lines) {
    return "ply\n" + lines +
           "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
  };
  EXPECT_NO_THROW(import_mesh(write("one.ply", with_formats("format ascii 1.0\n"))));
  EXPECT_THAT(rejection([&] {
                import_mesh(write("two.ply", with_formats("format binary_big_endian 1.0\nformat ascii 1.0\n")));
              }),
              HasSubstr("two.ply:3: PLY header: expected one format, found 'format ascii 1.0'"));
  for (const char* line : {"format ascii\n", "format ascii 2.0\n"}) {
    EXPECT_THAT(rejection([&] { import_mesh(write("version.ply", with_formats(line))); }),
                HasSubstr("expected a format of version 1.0"));
  }
}

// UTM: single precision resolves half a meter there.
TEST_F(WorldFiles, RecentersDistantMeshesWithoutPrecisionLoss) {
  const std::string a = "459120.300 5550319.300 312.300", b = "459120.500 5550319.300 312.300",
                    c = "459120.500 5550319.300 315.300", d = "459120.500 5550319.500 312.300";
  const fs::path files[] = {
      write("utm.obj", "v " + a + "\nv " + b + "\nv " + c + "\nv " + d + "\nf 1 2 3\nf 2 4 3\n"),
      write("utm.ply",
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
            "element face 2\nproperty list uchar int vertex_indices\nend_header\n" +
                a + "\n" + b + "\n" + c + "\n" + d + "\n3 0 1 2\n3 1 3 2\n"),
      write("utm.stl", "solid\nfacet\nouter loop\nvertex " + a + "\nvertex " + b + "\nvertex " + c +
                           "\nendloop\nendfacet\nfacet\nouter loop\nvertex " + b + "\nvertex " + d + "\nvertex " + c +
                           "\nendloop\nendfacet\nendsolid\n")};
  for (const fs::path& file : files) {
    MeshImportConfig config;
    config.file = file.string();
    config.position_m = {-459120.0, -5550319.0, -312.0};
    const Scene scene = make_mesh_import(config, 1);
    EXPECT_TRUE(scene.bounds_m.min().isApprox(Vector3d(0.3, 0.3, 0.3), 1e-5)) << file;
    EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(0.5, 0.5, 3.3), 1e-5)) << file;
    config.scale = 2.0;
    config.yaw_deg = 90.0;  // (x, y) to (-2 y, 2 x)
    config.position_m = {2.0 * 5550319.0, -2.0 * 459120.0, -2.0 * 312.0};
    const Scene turned = make_mesh_import(config, 1);
    EXPECT_TRUE(turned.bounds_m.min().isApprox(Vector3d(-1.0, 0.6, 0.6), 1e-5)) << file;
    EXPECT_TRUE(turned.bounds_m.max().isApprox(Vector3d(-0.6, 1.0, 6.6), 1e-5)) << file;
    EXPECT_THAT(rejection([&] { import_mesh(file); }),
                AllOf(HasSubstr(file.filename().string()), HasSubstr("within 100 km"),
                      HasSubstr("position_m: [-459120, -5550319, -312]")));
  }
}

TEST_F(WorldFiles, RecentersDistantCloudsBeforeVoxelization) {
  CloudConfig config;
  config.file = write("utm.pcd",
                      "FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nPOINTS 2\nDATA ascii\n459123.45 5550321.75 312.45\n"
                      "459124.45 5550321.75 312.45\n")
                    .string();
  EXPECT_THAT(rejection([&] { make_cloud(config, 1); }), AllOf(HasSubstr("utm.pcd"), HasSubstr("position_m")));
  config.position_m = {-459123.4, -5550321.7, -312.4};
  config.leaf_m = 0.1;
  const Scene scene = make_cloud(config, 1);
  EXPECT_EQ(scene.num_triangles(), 24U);  // two cubes
  EXPECT_TRUE(scene.bounds_m.min().isApprox(Vector3d(0.0, 0.0, 0.0), 1e-5));
  EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(1.1, 0.1, 0.1), 1e-5));
}

TEST_F(WorldFiles, RefusesCloudsWithoutRemainingPoints) {
  CloudConfig config;
  const std::string head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n";
  config.file = write("nan.pcd", head + "nan nan nan\n1 2 inf\n").string();
  EXPECT_THAT(rejection([&] { make_cloud(config, 1); }),
              AllOf(HasSubstr("nan.pcd"), HasSubstr("finite coordinates, found none")));
  config.file = write("thin.pcd", head + "1 1 1\n9 9 9\n").string();
  config.min_points = 2;
  EXPECT_THAT(rejection([&] { make_cloud(config, 1); }), AllOf(HasSubstr("thin.pcd"), HasSubstr("min_points = 2")));
}

/// A room of 12 x 8 x 3 m without its east wall.
const std::string kRoom =
    "v -6 -4 0\nv 6 -4 0\nv -6 4 0\nv 6 4 0\nv -6 -4 3\nv 6 -4 3\nv -6 4 3\nv 6 4 3\n"
    "f 1 2 4 3\nf 1 5 6 2\nf 4 8 7 3\nf 3 7 5 1\nf 5 6 8 7\n";

std::uint64_t num_left_out(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Counter& counter : scene.counters) {
    EXPECT_EQ(counter.setting, "world.file");
    count += counter.count;
  }
  return count;
}

TEST_F(WorldFiles, SkipsAndCountsBadFaces) {
  for (const char* face :
       {"f 1 2\n", "f 1\n", "f\n", "f 1 2 2\n", "f 1 2 9\n", "f 1 2 0\n", "f 1 2 -9\n", "f 1 2 x\n", "f 1 2 3x\n",
        "f 1 2 1 2\n", "v 0 nan 0\nf 1 2 9\n", "v 0 1\nf 1 2 9\n", "v 0 1,5 2\nf 1 2 9\n", "v 0 -4 0\nf 1 2 9\n"}) {
    const Scene scene = import_mesh(write("room.obj", kRoom + face));
    EXPECT_EQ(scene.num_triangles(), 10U) << face;
    EXPECT_EQ(num_left_out(scene), 1U) << face;
    EXPECT_TRUE(scene.bounds_m.isApprox(Eigen::AlignedBox3d(Vector3d(-6, -4, 0), Vector3d(6, 4, 3)))) << face;
  }
  const Scene scene = import_mesh(write("room.obj", kRoom + "f 1 2\nf 3 4\n"));
  ASSERT_EQ(scene.counters.size(), 1U);
  EXPECT_EQ(scene.counters[0].of, 7U);
  EXPECT_EQ(scene.counters[0].what, "faces left out: line 14: fewer than three different corners");
  EXPECT_EQ(num_left_out(import_mesh(write("room.obj", kRoom))), 0U);
  EXPECT_THAT(rejection([&] { import_mesh(write("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n")); }),
              AllOf(HasSubstr("bad.obj"), HasSubstr("line 3: fewer than three different corners")));
}

TEST_F(WorldFiles, DropsRepeatedCornersInEveryFormat) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const auto of_ply = [&](const char* faces) { return import_mesh(write("q.ply", ply + faces)); };
  EXPECT_EQ(of_ply("4 0 1 2 2\n3 0 1 3\n").num_triangles(), 2U);
  EXPECT_EQ(num_left_out(of_ply("4 0 1 2 2\n3 0 1 3\n")), 0U);
  for (const char* faces : {"4 0 1 2 3\n3 0 1 1\n", "4 0 1 2 3\n2 0 1\n", "4 0 1 2 3\n0\n", "4 0 1 2 3\n3 0 1 4\n",
                            "4 0 1 2 3\n3 0 1 -1\n", "4 0 1 2 3\n3 0 1 0.5\n"}) {
    EXPECT_EQ(of_ply(faces).num_triangles(), 2U) << faces;
    EXPECT_EQ(num_left_out(of_ply(faces)), 1U) << faces;
  }
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  EXPECT_EQ(import_mesh(write("q.obj", obj + "f 1 2 3 3\nf 1 2 4\n")).num_triangles(), 2U);
}

TEST_F(WorldFiles, ReadsObjFromOtherPrograms) {
  const char* const faces[] = {"f 1 2 3 # floor",     "f 1 2 3#floor",      "f 1/1 2/2 3/3", "f 1//7 2//7 3//7",
                               "f 1/1/1 2/2/2 3/3/3", "f 1/ 2/ 3/",         "f -3 -2 -1",    "  f\t1\t2  3 ",
                               "f 1 2 \\\n 3",        "f 1 \\\r\n2 \\\r\n3"};
  for (const std::string face : faces) {
    for (const char* end : {"\n", "\r\n", ""}) {
      const std::string head =
          "\xEF\xBB\xBF# a program in C:\\\r\nv 0 0 0 1.0\nv +3 0.0e0 0 0.5 0.5 0.5\nv 0 4. 0 # corner\n";
      const Scene scene = import_mesh(write("a.obj", head + "l 1 2\np 1\ns off\nvn 0 0 1\n" + face + end));
      EXPECT_EQ(scene.num_triangles(), 1U) << face;
      EXPECT_EQ(num_left_out(scene), 0U) << face;
      EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(3, 4, 0), 1e-6)) << face;
    }
  }
}

TEST_F(WorldFiles, ReadsAsciiStlFromOtherPrograms) {
  const std::string text =
      "solid my room\n  facet normal 0 0 -nan(ind)\n    outer loop\n      vertex 0 0 2\n      vertex 3.0e+00 0 2\n"
      "      vertex 0 4 2\n    endloop\n  endfacet\nendsolid my room\n";
  std::string capitals = text, dos;
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const char c : text) dos += c == '\n' ? std::string("\r\n") : std::string(1, c);
  for (const std::string& content :
       {text, "\xEF\xBB\xBF" + text, " \n\t" + text, capitals, dos, "solid empty\nendsolid empty\n" + text,
        text + "solid\nendsolid\n", text.substr(0, text.find("endsolid")), text.substr(0, text.find("    endloop"))}) {
    const Scene scene = import_mesh(write("a.stl", content));
    EXPECT_EQ(scene.num_triangles(), 1U) << content;
    EXPECT_EQ(num_left_out(scene), 0U) << content;
    EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(3, 4, 2), 1e-6)) << content;
  }
  const Scene two =
      import_mesh(write("b.stl", text + "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n"));
  EXPECT_EQ(two.num_triangles(), 1U);
  EXPECT_EQ(num_left_out(two), 1U);
  EXPECT_THAT(rejection([&] { import_mesh(write("c.stl", "solid nothing\nendsolid nothing\n")); }),
              AllOf(HasSubstr("c.stl"), HasSubstr("expected faces, found none")));
  Mesh ball;
  add_icosphere(ball, {1, 2, 3}, 0.5F, 1);
  std::string binary = binary_stl(ball);
  binary.replace(0, 13, "solid of CAD\n");
  EXPECT_EQ(import_mesh(write("d.stl", binary)).num_triangles(), 80U);
  EXPECT_THAT(rejection([&] { import_mesh(write("e.stl", binary.substr(0, binary.size() - 1))); }),
              HasSubstr("truncated"));
}

TEST_F(WorldFiles, ReadsPlyWithAnyColumnNames) {
  const auto ply = [](const char* columns, const std::string& rows) {
    return "ply\nformat ascii 1.0\nelement vertex 4\n" + std::string(columns) +
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n" + rows + "4 0 1 2 3\n";
  };
  const char* const small = "property float x\nproperty float y\nproperty float z\n";
  const Scene scene = import_mesh(write("a.ply", ply(small, "-6.12 -4 0\n6 -4 0\n6 4 0\n-6.12 4 0\n")));
  EXPECT_EQ(scene.num_triangles(), 2U);
  EXPECT_TRUE(scene.bounds_m.sizes().isApprox(Vector3d(12.12, 8, 0), 1e-6));
  const char* const large = "property float X\nproperty float Y\nproperty float Z\n";
  EXPECT_TRUE(import_mesh(write("b.ply", ply(large, "-6 -4 1\n6 -4 1\n6 4 1\n-6 4 1\n")))
                  .bounds_m.max()
                  .isApprox(Vector3d(6, 4, 1), 1e-6));
  EXPECT_THAT(rejection([&] {
                import_mesh(write("c.ply", ply("property float x\nproperty float y\n", "0 0\n1 0\n1 1\n0 1\n")));
              }),
              AllOf(HasSubstr("c.ply"), HasSubstr("found no z")));
  // Every first byte of a binary file.
  for (int byte = 0; byte < 256; ++byte) {
    std::string content =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (const float value : {-6.12F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F})
      content.append(reinterpret_cast<const char*>(&value), 4);
    content[content.size() - 36] = static_cast<char>(byte);
    content += std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
    EXPECT_EQ(import_mesh(write("d.ply", content)).num_triangles(), 1U) << byte;
  }
}

// Simple polygons, by the area that is known of each.
TEST_F(WorldFiles, TriangulatesPolygonsWithoutOverlap) {
  const auto area_of = [&](const std::vector<Eigen::Vector2d>& corners) {
    std::string vertices, face = "f";
    for (std::size_t i = 0; i < corners.size(); ++i) {
      vertices += "v " + std::to_string(corners[i].x()) + " 7 " + std::to_string(corners[i].y()) + "\n";
      face += " " + std::to_string(i + 1);
    }
    const Scene scene = import_mesh(write("polygon.obj", vertices + face + "\n"));
    EXPECT_EQ(scene.num_triangles(), corners.size() - 2);
    return area_m2(scene.meshes.at(0));
  };
  EXPECT_NEAR(area_of({{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}}), 6.0, 1e-5) << "an L";
  EXPECT_NEAR(area_of({{0, 0}, {3, 0}, {0, 3}, {1, 1}}), 3.0, 1e-5) << "an arrow";
  EXPECT_NEAR(area_of({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}), 4.0, 1e-5) << "corners on edges";
  std::vector<Eigen::Vector2d> comb, star;
  for (int i = 0; i < 20; ++i) {
    for (const auto& [x, z] : {std::pair(0, 5), std::pair(0, 1), std::pair(1, 1), std::pair(1, 5)})
      comb.emplace_back(2 * i + x, z);
  }
  comb.erase(comb.begin());
  comb.back() = {39, 0};
  comb.emplace_back(0, 0);
  EXPECT_NEAR(area_of(comb), 39.0 + 19.0 * 4.0, 1e-4) << "teeth between the notches";
  double area = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double angle = 2.0 * std::acos(-1.0) * i / 50.0, radius = i % 2 == 0 ? 5.0 : 2.0;
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    area += 0.5 * 5.0 * 2.0 * std::sin(2.0 * std::acos(-1.0) / 50.0);
  }
  EXPECT_NEAR(area_of(star), area, 1e-3) << "a star";
}

TEST_F(WorldFiles, RefusesUnmatchedRuleWithSuggestion) {
  MeshImportConfig config;
  config.file = write("plot.obj",
                      "o plot\nv 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl terrain\nf 1 2 3\nusemtl Leaf.001\nf 3 2 1\n"
                      "g porch\nf 1 2 3\no NoFaces\n")
                    .string();
  const auto with = [&](const char* name) {
    config.surfaces = {{"terrain", "ground", 0.2, false}, {name, "vegetation", 0.5, false}};
    return rejection([&] { make_mesh_import(config, 1); });
  };
  for (const char* name : {"Leaf", "plot", "porch", "terrain"}) EXPECT_EQ(with(name), "nothing was thrown") << name;
  EXPECT_THAT(with("leaf"), AllOf(HasSubstr("world.surfaces[1].name"), HasSubstr("plot.obj"), HasSubstr("terrain"),
                                  HasSubstr("found \"leaf\"; did you mean \"Leaf\"?")));
  EXPECT_THAT(with("terain"), HasSubstr("did you mean \"terrain\"?"));
  EXPECT_THAT(with("roof of tiles"), testing::Not(HasSubstr("did you mean")));
  EXPECT_THAT(with("NoFaces"), HasSubstr("found \"NoFaces\""));
  EXPECT_THAT(with(""), HasSubstr("world.surfaces[1].name"));
  config.file =
      write("plain.stl", "solid\nfacet\nouter loop\nvertex 0 0 2\nvertex 3 0 2\nvertex 0 4 2\nendloop\n").string();
  EXPECT_THAT(with("roof"), HasSubstr("which names nothing"));
}

TEST_F(WorldFiles, TruncatedFilesNeverCrash) {
  Mesh ball;
  add_icosphere(ball, {1, 2, 3}, 0.5F, 1);
  SceneBuilder builder;
  builder.add(ball, {"gray", 0.4F, false, {0.5F, 0.5F, 0.5F}}, SurfaceClass::kObject, 1);
  const Scene scene = builder.finish();
  export_world(scene, folder_ / "ball.ply");
  export_world(scene, folder_ / "ball.obj");
  write("ball.stl", binary_stl(ball));
  for (const auto& entry : fs::directory_iterator(kData))
    fs::copy_file(entry.path(), folder_ / entry.path().filename());

  int rejected = 0;
  int read_anyway = 0;
  for (const char* name : {"ball.ply", "ball.obj", "ball.stl", "ascii.pcd", "binary.pcd", "compressed.pcd"}) {
    const std::string whole = read(folder_ / name);
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 120) {
      const fs::path cut = write(std::string("cut_") + name, whole.substr(0, length));
      try {
        cut.extension() == ".pcd" ? (void)read_point_cloud(cut) : (void)import_mesh(cut);
        ++read_anyway;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr(cut.filename().string()));
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        ++rejected;
      }
    }
  }
  EXPECT_GT(rejected, 300);
  // Text without a count (OBJ), and numbers that lose their last digits (ascii PCD), can be cut and still make sense.
  EXPECT_LT(read_anyway, 130);
}

TEST_F(WorldFiles, DamagedFilesNeverCrash) {
  Mesh ball;
  add_icosphere(ball, {1, 2, 3}, 0.5F, 1);
  SceneBuilder builder;
  builder.add(ball, {"gray", 0.4F, false, {0.5F, 0.5F, 0.5F}}, SurfaceClass::kObject, 1);
  const Scene scene = builder.finish();
  export_world(scene, folder_ / "ball.ply");
  write("ball.stl", binary_stl(ball));
  for (const auto& entry : fs::directory_iterator(kData))
    fs::copy_file(entry.path(), folder_ / entry.path().filename());
  const Random random(1, "test");
  int runs = 0;
  for (const char* name : {"ball.ply", "ball.stl", "ascii.pcd", "binary.pcd", "compressed.pcd"}) {
    const std::string whole = read(folder_ / name);
    for (std::uint32_t i = 0; i < 60; ++i) {
      Dice dice(random, i);
      std::string damaged = whole;
      for (int k = 0; k < 1 + static_cast<int>(i) % 5; ++k)
        damaged[dice.pick(static_cast<int>(whole.size()))] = static_cast<char>(dice.pick(256));
      const fs::path file = write(std::string("damaged_") + name, damaged);
      try {
        file.extension() == ".pcd" ? (void)read_point_cloud(file) : (void)import_mesh(file);
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr(file.filename().string()));
      }
      ++runs;
    }
  }
  EXPECT_EQ(runs, 300);
}

// Written by PCL 1.13: 5 x 4 x 3 points, the one with index 7 has no x.
TEST(PointClouds, ReadsPclFilesInEveryEncoding) {
  for (const char* name : {"ascii.pcd", "binary.pcd", "compressed.pcd"}) {
    const auto points = read_point_cloud(kData / name);
    ASSERT_EQ(points.size(), 59U) << name;
    for (int i = 0, row = 0; i < 60; ++i) {
      if (i == 7) continue;
      EXPECT_TRUE(points[row++].isApprox(Vector3d(0.5 * (i % 5), 0.25 * (i / 5 % 4), i / 20), 1e-6))
          << name << " " << i;
    }
  }
}

TEST(PointClouds, DecodesLzfCopiesAndRuns) {
  std::string out(10, '\0');
  // "ab" as literals, then 8 bytes from 2 back: length 8 - 2 = 6, distance 2 - 1 = 1.
  ASSERT_TRUE(decompress_lzf(std::string("\x01"
                                         "ab"
                                         "\xc0\x01",
                                         5),
                             out));
  EXPECT_EQ(out, "ababababab");
  // A long copy: length byte 7 + 20, distance 0 (the last byte again).
  out.assign(1 + 29, '\0');
  ASSERT_TRUE(decompress_lzf(std::string("\x00"
                                         "z"
                                         "\xe0\x14\x00",
                                         5),
                             out));
  EXPECT_EQ(out, std::string(30, 'z'));
  EXPECT_FALSE(decompress_lzf(std::string("\x01"
                                          "a",
                                          2),
                              out));  // literals missing
  EXPECT_FALSE(decompress_lzf(std::string("\x00"
                                          "z"
                                          "\x20\x05",
                                          4),
                              out));  // before the beginning of the output
  EXPECT_FALSE(decompress_lzf(std::string("\xe0", 1), out));
  out.assign(5, '\0');
  EXPECT_FALSE(decompress_lzf(std::string("\x00"
                                          "z"
                                          "\xe0\x14\x00",
                                          5),
                              out));  // more than declared
}

TEST_F(WorldFiles, ReadsPlyCloudsOfEitherEndianness) {
  const std::string properties =
      "element vertex 2\nproperty uchar red\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  const double values[] = {1.5, -2.25, 1e-3, 4, 5, 6};
  std::string little, big;
  for (int i = 0; i < 6; ++i) {
    if (i % 3 == 0) little += '\x07', big += '\x07';
    std::string bytes(reinterpret_cast<const char*>(&values[i]), 8);
    little += bytes;
    big += std::string(bytes.rbegin(), bytes.rend());
  }
  const std::vector<Vector3d> expected = {{1.5, -2.25, 1e-3}, {4, 5, 6}};
  EXPECT_EQ(read_point_cloud(write("l.ply", "ply\nformat binary_little_endian 1.0\n" + properties + little)), expected);
  EXPECT_EQ(read_point_cloud(write("b.ply", "ply\nformat binary_big_endian 1.0\n" + properties + big)), expected);
  EXPECT_EQ(
      read_point_cloud(write(
          "a.ply",
          "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement vertex 2\r\nproperty uchar red\r\nproperty double "
          "x\r\nproperty double y\r\nproperty double z\r\nend_header\r\n7 1.5 -2.25 1e-3\r\n7 +4 5 6\r\n")),
      expected);
}

TEST_F(WorldFiles, SkipsPlyElementsBeforeVertices) {
  const std::string elements =
      "element camera 2\nproperty float focal\nproperty uchar id\nelement vertex 2\nproperty float x\nproperty float "
      "y\nproperty float z\nend_header\n";
  const std::vector<Vector3d> expected = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(read_point_cloud(write("a.ply", "ply\nformat ascii 1.0\n" + elements + "9 8\n7 6\n1 2 3\n4 5 6\n")),
            expected);
  std::string bytes(10, '\x55');
  for (const float value : {1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F}) bytes.append(reinterpret_cast<const char*>(&value), 4);
  EXPECT_EQ(read_point_cloud(write("b.ply", "ply\nformat binary_little_endian 1.0\n" + elements + bytes)), expected);
}

template <class Value>
void append_bytes(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// x without sign, y with one, z a real number, whatever their sizes; a field of two values lies between.
TEST_F(WorldFiles, ReadsPcdNumbersOfAnySize) {
  for (const int size : {1, 2, 4, 8}) {
    const int real_size = size < 4 ? 4 : size;
    const std::string text = std::to_string(size);
    std::string content =
        "VERSION .7\nFIELDS x y extra z\nSIZE " + text + " " + text + " 1 " + std::to_string(real_size) +
        "\nTYPE U I U F\nCOUNT 1 1 2 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA binary\n";
    const std::int64_t whole = size == 8 ? 5'000'000'000 : size == 4 ? 3'000'000'000 : size == 2 ? 60'000 : 200;
    for (const int point : {0, 1}) {
      for (const std::int64_t value : {whole + point, -whole / 2 - point}) {  // the lowest bytes first
        content.append(reinterpret_cast<const char*>(&value), static_cast<std::size_t>(size));
      }
      content += "ab";
      real_size == 4 ? append_bytes(content, 0.5F + static_cast<float>(point)) : append_bytes(content, 0.5 + point);
    }
    const auto x = static_cast<double>(whole);
    const std::vector<Vector3d> expected = {{x, -0.5 * x, 0.5}, {x + 1, -0.5 * x - 1, 1.5}};
    EXPECT_EQ(read_point_cloud(write("n.pcd", content)), expected) << size;
    EXPECT_THAT(rejection([&] { read_point_cloud(write("cut.pcd", content.substr(0, content.size() - 1))); }),
                HasSubstr("truncated"));
  }
}

TEST_F(WorldFiles, EmptyCompressedCloudHasNoPoints) {
  const std::string head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 0\nDATA binary_compressed\n";
  EXPECT_TRUE(read_point_cloud(write("empty.pcd", head + std::string(8, '\0'))).empty());
  EXPECT_THAT(rejection([&] { read_point_cloud(write("cut.pcd", head + std::string(7, '\0'))); }),
              HasSubstr("truncated"));
}

TEST_F(WorldFiles, RefusesInvalidCloudsWithReason) {
  EXPECT_THAT(rejection([&] { read_point_cloud(write("a.xyz", "1 2 3\n")); }), HasSubstr(".pcd or .ply"));
  EXPECT_THAT(rejection([&] { read_point_cloud(write("b.pcd", "hello\nDATA ascii\n")); }),
              HasSubstr("expected a PCD header"));
  EXPECT_THAT(
      rejection([&] {
        read_point_cloud(write(
            "c.pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2\n"));
      }),
      HasSubstr("no z"));
  EXPECT_THAT(rejection([&] {
                read_point_cloud(write(
                    "d.pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 4000000000000\nDATA binary\n"));
              }),
              HasSubstr("truncated"));
  EXPECT_THAT(rejection([&] {
                read_point_cloud(write(
                    "e.pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 1\nDATA ascii\n1 2 three\n"));
              }),
              AllOf(HasSubstr("e.pcd"), HasSubstr("point 0"), HasSubstr("'z'")));
  EXPECT_THAT(rejection([&] { read_point_cloud(write("f.pcd", "FIELDS x y z\nSIZE 4 4 3\n")); }),
              HasSubstr("SIZE 4 4 3"));
  EXPECT_THAT(
      rejection([&] {
        read_point_cloud(write("i.pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1\nPOINTS 0\nDATA ascii\n"));
      }),
      HasSubstr("COUNT 1 1"));
  EXPECT_THAT(
      rejection([&] { read_point_cloud(write("g.ply", "ply\nformat ascii 1.0\nelement face 0\nend_header\n")); }),
      HasSubstr("vertex"));
  EXPECT_THAT(rejection([&] { read_point_cloud(write("h.ply", "ply\nformat utf8 1.0\nend_header\n")); }),
              HasSubstr("utf8"));
  EXPECT_THROW(read_point_cloud(folder_ / "missing.pcd"), InputError);
}

TEST(Voxels, SolidBlockKeepsOnlyOuterFaces) {
  std::vector<Vector3d> points;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < 2; ++z) points.emplace_back(0.5 * x + 0.1, 0.5 * y - 3.0 + 0.2, 0.5 * z + 0.3);
    }
  }
  const Mesh mesh = voxelize(points, 0.5, 1);
  EXPECT_EQ(mesh.triangles.size(), 12U);  // merged to a box
  EXPECT_NEAR(signed_volume_m3(mesh), 2.0 * 1.5 * 1.0, 1e-5);
  EXPECT_NEAR(area_m2(mesh), 2 * (2.0 * 1.5 + 2.0 * 1.0 + 1.5 * 1.0), 1e-5);
  EXPECT_TRUE(bounds_m(mesh).min().isApprox(Eigen::Vector3f(0, -3, 0)));
}

TEST(Voxels, MatchesVoxelVolumeAndFaceArea) {
  const Random random(1, "test");
  Dice dice(random, 0);
  std::set<std::array<int, 3>> voxels;
  std::vector<Vector3d> points;
  for (int i = 0; i < 400; ++i) {
    const std::array<int, 3> voxel = {dice.pick(9) - 4, dice.pick(9) - 4, dice.pick(9) - 4};
    voxels.insert(voxel);
    points.emplace_back(0.2 * (voxel[0] + 0.5), 0.2 * (voxel[1] + 0.5), 0.2 * (voxel[2] + 0.5));
  }
  int faces = 0;
  for (const auto& voxel : voxels) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        auto neighbor = voxel;
        neighbor[axis] += side;
        faces += !voxels.contains(neighbor);
      }
    }
  }
  const Mesh mesh = voxelize(points, 0.2, 1);
  EXPECT_NEAR(signed_volume_m3(mesh), 0.008 * static_cast<double>(voxels.size()), 1e-4);
  EXPECT_NEAR(area_m2(mesh), 0.04 * faces, 1e-3);
  EXPECT_LT(mesh.triangles.size(), 2U * static_cast<std::size_t>(faces));
}

TEST(Voxels, ThinlyPopulatedVoxelsAreLeftOut) {
  const std::vector<Vector3d> points = {{0.1, 0.1, 0.1}, {0.2, 0.1, 0.1}, {5, 5, 5}};
  EXPECT_EQ(voxelize(points, 1.0, 2).triangles.size(), 12U);
  EXPECT_EQ(voxelize(points, 1.0, 3).triangles.size(), 0U);
}

TEST(Voxels, RefusesCloudTooLargeForLeaf) {
  const std::vector<Vector3d> points = {{0, 0, 0}, {1e7, 0, 0}};
  EXPECT_THROW(voxelize(points, 0.1, 1), InputError);
}

TEST(Cloud, PlacesVoxelWorldAtItsPosition) {
  CloudConfig config;
  config.file = (kData / "binary.pcd").string();
  config.leaf_m = 0.25;
  config.position_m = {100, 0, 5};
  config.surface_class = "building";
  config.reflectivity = 0.7;
  const Scene scene = make_cloud(config, 1);
  EXPECT_TRUE(scene.bounds_m.min().isApprox(Vector3d(100, 0, 5), 1e-5));
  EXPECT_TRUE(scene.bounds_m.max().isApprox(Vector3d(102.25, 1, 7.25), 1e-5));
  EXPECT_EQ(scene.meshes[0].surface_class, SurfaceClass::kBuilding);
  EXPECT_EQ(scene.materials[0].reflectivity, 0.7F);
}

}  // namespace
}  // namespace swiftlet::sim
