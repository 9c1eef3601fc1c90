// SPDX-License-Identifier: BSD-3-Clause
// Worlds out to files and back, and files that are not what they should be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "sim/world/dice.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/world/cloud.hpp"
#include "swiftlet/sim/world/export.hpp"
#include "swiftlet/sim/world/forest_thesis.hpp"
#include "swiftlet/sim/world/hall.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "swiftlet/sim/world/mesh_import.hpp"
#include "swiftlet/sim/world/point_cloud_file.hpp"
#include "tests/sim/world/world_support.hpp"
#include "tests/support/file_test.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;

const fs::path kData = fs::path(SWIFTLET_SOURCE_DIR) / "tests/sim/world/data";

using WorldFiles = FileTest;

Scene import_mesh(const fs::path& file) {
  MeshImportConfig config;
  config.file = file.string();
  return make_mesh_import(config, 1);
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

TEST_F(WorldFiles, RoundTripsTrianglesAndObjLabels) {
  const Scene scene = make_forest_thesis(few_trees(), 1);
  EXPECT_THAT(export_world(scene, folder_ / "forest.obj"),
              testing::ElementsAre(folder_ / "forest.obj", folder_ / "forest.mtl", folder_ / "forest.objects.csv"));
  export_world(scene, folder_ / "forest.ply");
  for (const char* name : {"forest.obj", "forest.ply"}) {
    const Scene back = import_mesh(folder_ / name);
    EXPECT_EQ(back.num_triangles(), scene.num_triangles()) << name;
    EXPECT_TRUE(back.bounds_m.isApprox(scene.bounds_m, 1e-5)) << name;
    for (int i = 0; i < 100; ++i) {
      const Vector3d eye(0, 0, 40), direction(0.5 * std::sin(i), 0.7 * std::cos(2.3 * i), -1);
      const auto before = test::trace(scene, eye, direction), after = test::trace(back, eye, direction);
      ASSERT_EQ(before.has_value(), after.has_value()) << name;
      if (before) {
        EXPECT_NEAR(before->range_m, after->range_m, 1e-4) << name;
      }
    }
  }
  std::set<Label> expected = labels_of(scene);
  expected.erase({SurfaceClass::kGround, 0});
  expected.insert({SurfaceClass::kGround, 1});  // an unnumbered object gets the next number
  EXPECT_EQ(labels_of(import_mesh(folder_ / "forest.obj")), expected);
}

TEST_F(WorldFiles, PlyVerticesCarryTheTruth) {
  const Scene scene = make_forest_thesis(few_trees(), 1);
  export_world(scene, folder_ / "forest.ply");
  const std::string content = read_whole_file(folder_ / "forest.ply");
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
  // A pole 200 cm high along the file's y axis.
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

TEST_F(WorldFiles, RefusesInvalidMeshesWithReason) {
  const std::string ascii = "ply\nformat ascii 1.0\n", xyz = "property float x\nproperty float y\nproperty float z\n",
                    indices = "property list uint int vertex_indices\nend_header\n",
                    square = ascii + "element vertex 4\n" + xyz + "element face 1\n" + indices +
                             "0 0 0\n1 0 0\n1 1 0\n0 1 0\n",
                    corners = "face 0: expected a list";
  const std::tuple<const char*, std::string, std::string> files[] = {
      {"a.obj", "", "empty"},
      {"b.obj", "this is no mesh\n", "b.obj"},
      {"c.dae", "<xml/>", ".obj, .ply or .stl"},
      {"d.ply", ascii + "element vertex 4000000000\nproperty float x\nelement face 1\nend_header\n1\n", "truncated"},
      {"e.stl", std::string(80, ' ') + std::string("\xff\xff\xff\x7f", 4), "truncated"},
      {"f.ply", ascii + "element vertex 1\n" + xyz + "end_header\n0 0 0\n", "face"},
      {"g.ply", ascii + "element vertex 1\n" + xyz + "element face 0\n" + indices + "0 0 0\n",
       "elements 'face', found none"},
      {"h.ply", square + "2147483647 0 1 2 3\n", corners},
      {"i.ply", square + "4294967295 0 1 2 3\n", corners},
      {"j.ply", square + "-1 0 1 2 3\n", corners},
      {"k.ply", square + "4 0 1 2 7\n", "k.ply"},
      {"l.obj", "v 0 0 0\nv nan 0 0\nv 0 inf 1\nf 1 2 3\n", "l.obj"}};
  for (const auto& [name, content, reason] : files) {
    const fs::path file = write(name, content);
    EXPECT_THAT(refusal_of([&] { import_mesh(file); }), AllOf(HasSubstr(name), HasSubstr(reason)));
  }
  EXPECT_NO_THROW(import_mesh(write("m.ply", square + "4 0 1 2 3\n")));
  EXPECT_THAT(refusal_of([&] { import_mesh({}); }), HasSubstr("expected the name"));
  EXPECT_THROW(import_mesh(folder_ / "missing.obj"), InputError);
}

// With another format, text would be read as the length of a list: gigabytes for a file of 800 bytes.
TEST_F(WorldFiles, RequiresOnePlyFormatVersionOne) {
  const auto with_formats = [](const std::string& lines) {
    return "ply\n" + lines +
           "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
  };
  EXPECT_NO_THROW(import_mesh(write("one.ply", with_formats("format ascii 1.0\n"))));
  EXPECT_THAT(refusal_of([&] {
                import_mesh(write("two.ply", with_formats("format binary_big_endian 1.0\nformat ascii 1.0\n")));
              }),
              HasSubstr("two.ply:3: PLY header: expected one format, found 'format ascii 1.0'"));
  for (const char* line : {"format ascii\n", "format ascii 2.0\n"}) {
    EXPECT_THAT(refusal_of([&] { import_mesh(write("version.ply", with_formats(line))); }),
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
    EXPECT_THAT(refusal_of([&] { import_mesh(file); }),
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
  EXPECT_THAT(refusal_of([&] { make_cloud(config, 1); }), AllOf(HasSubstr("utm.pcd"), HasSubstr("position_m")));
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
  EXPECT_THAT(refusal_of([&] { make_cloud(config, 1); }),
              AllOf(HasSubstr("nan.pcd"), HasSubstr("finite coordinates, found none")));
  config.file = write("thin.pcd", head + "1 1 1\n9 9 9\n").string();
  config.min_points = 2;
  EXPECT_THAT(refusal_of([&] { make_cloud(config, 1); }), AllOf(HasSubstr("thin.pcd"), HasSubstr("min_points = 2")));
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
  EXPECT_THAT(refusal_of([&] { import_mesh(write("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n")); }),
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
  EXPECT_THAT(refusal_of([&] { import_mesh(write("c.stl", "solid nothing\nendsolid nothing\n")); }),
              AllOf(HasSubstr("c.stl"), HasSubstr("expected faces, found none")));
  Mesh ball;
  add_icosphere(ball, {1, 2, 3}, 0.5F, 1);
  std::string binary = binary_stl(ball);
  binary.replace(0, 13, "solid of CAD\n");
  EXPECT_EQ(import_mesh(write("d.stl", binary)).num_triangles(), 80U);
  EXPECT_THAT(refusal_of([&] { import_mesh(write("e.stl", binary.substr(0, binary.size() - 1))); }),
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
  EXPECT_EQ(import_mesh(write("b.ply", ply(large, "-6 -4 1\n6 -4 1\n6 4 1\n-6 4 1\n"))).num_triangles(), 2U);
  EXPECT_THAT(refusal_of([&] {
                import_mesh(write("c.ply", ply("property float x\nproperty float y\n", "0 0\n1 0\n1 1\n0 1\n")));
              }),
              AllOf(HasSubstr("c.ply"), HasSubstr("found no z")));
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
  std::vector<Eigen::Vector2d> star;
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
    return refusal_of([&] { make_mesh_import(config, 1); });
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

// Literal bytes; copies of up to 8 bytes with their distance less one; longer copies with a byte of length.
TEST(PointClouds, DecodesLzfOnlyAtExactLength) {
  const std::string abc(
      "\x02"
      "abc",
      4);
  const std::tuple<std::string, std::size_t, std::string> cases[] = {
      {abc + std::string("\x20\x02", 2), 6, "abcabc"},
      {abc + std::string("\xc0\x02", 2), 11, "abcabcabcab"},
      {abc + std::string("\xe0\x00\x02", 3), 12, "abcabcabcabc"},
      {abc + std::string("\xe0\x14\x00", 3), 32, "abc" + std::string(29, 'c')},
      {abc, 4, "no"},                                   // less than promised
      {abc + std::string("\xe0\x14\x00", 3), 8, "no"},  // more than promised
      {abc + std::string("\x20\x03", 2), 6, "no"},      // from before the first byte
      {abc + std::string("\xe0\x00", 2), 12, "no"},     // the distance is missing
      {abc + "\x20", 6, "no"},
      {std::string("\x01"
                   "a",
                   2),
       2, "no"},  // a literal is missing
      {"", 0, ""}};
  for (const auto& [packed, size, expected] : cases) {
    std::string out(size, '\0');
    EXPECT_EQ(decompress_lzf(packed, out) ? out : "no", expected);
  }
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
    EXPECT_THAT(refusal_of([&] { read_point_cloud(write("cut.pcd", content.substr(0, content.size() - 1))); }),
                HasSubstr("truncated"));
  }
}

TEST_F(WorldFiles, EmptyCompressedCloudHasNoPoints) {
  const std::string head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 0\nDATA binary_compressed\n";
  EXPECT_TRUE(read_point_cloud(write("empty.pcd", head + std::string(8, '\0'))).empty());
  EXPECT_THAT(refusal_of([&] { read_point_cloud(write("cut.pcd", head + std::string(7, '\0'))); }),
              HasSubstr("truncated"));
}

class BrokenFiles : public FileTest {
 protected:
  BrokenFiles() {
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
  }
  /// Reads a broken copy of a file; @return whether it was refused.
  bool refuses(const std::string& name, const std::string& content) const {
    const fs::path file = write("broken_" + name, content);
    const std::string reason =
        refusal_of([&] { file.extension() == ".pcd" ? (void)read_point_cloud(file) : (void)import_mesh(file); });
    if (reason == "nothing was thrown") return false;
    EXPECT_THAT(reason, HasSubstr(file.filename().string()));
    EXPECT_EQ(reason.find('\n'), std::string::npos) << reason;
    return true;
  }
};

TEST_F(BrokenFiles, NeverCrashWhenTruncated) {
  int refused = 0;
  for (const char* name : {"ball.ply", "ball.obj", "ball.stl", "ascii.pcd", "binary.pcd", "compressed.pcd"}) {
    const std::string whole = read_whole_file(folder_ / name);
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 120)
      refused += refuses(name, whole.substr(0, length));
  }
  EXPECT_GT(refused, 300);
}

TEST_F(BrokenFiles, NeverCrashWhenDamaged) {
  const Random random(1, "test");
  for (const char* name : {"ball.ply", "ball.stl", "ascii.pcd", "binary.pcd", "compressed.pcd"}) {
    const std::string whole = read_whole_file(folder_ / name);
    for (std::uint32_t i = 0; i < 60; ++i) {
      Dice dice(random, i);
      std::string damaged = whole;
      for (std::uint32_t k = 0; k < 1 + i % 5; ++k)
        damaged[dice.pick(static_cast<int>(whole.size()))] = static_cast<char>(dice.pick(256));
      refuses(name, damaged);
    }
  }
}

TEST_F(WorldFiles, RefusesInvalidCloudsWithReason) {
  const std::tuple<const char*, const char*, const char*> files[] = {
      {"a.xyz", "1 2 3\n", ".pcd or .ply"},
      {"b.pcd", "hello\nDATA ascii\n", "expected a PCD header"},
      {"c.pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1\nPOINTS 0\nDATA ascii\n", "COUNT 1 1"},
      {"d.pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 4000000000000\nDATA binary\n", "truncated"},
      {"e.ply", "ply\nformat ascii 1.0\nelement face 0\nend_header\n", "vertex"},
      {"f.ply", "ply\nformat utf8 1.0\nend_header\n", "utf8"}};
  for (const auto& [name, content, reason] : files) {
    const fs::path file = write(name, content);
    EXPECT_THAT(refusal_of([&] { read_point_cloud(file); }), AllOf(HasSubstr(name), HasSubstr(reason)));
  }
  EXPECT_THROW(read_point_cloud(folder_ / "missing.pcd"), InputError);
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

TEST(Voxels, RefuseCloudsTooLargeForEdge) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vector3d p = Vector3d::Constant(0.5);
      p[axis] = sign * 1e6 + 0.5;
      EXPECT_EQ(bounds_m(voxelize({{p}}, 1.0, 1)).min()[axis], static_cast<float>(sign * 1e6));
      p[axis] = sign * 1.1e6;
      EXPECT_THROW(voxelize({{p}}, 1.0, 1), InputError);
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
