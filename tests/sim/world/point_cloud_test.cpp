// SPDX-License-Identifier: BSD-3-Clause
// Point clouds and heads of PLY files byte by byte: what is just enough is read, what is one less is refused.
#include "swiftlet/sim/world/point_cloud_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "sim/world/input_file.hpp"
#include "sim/world/mesh_file.hpp"
#include "sim/world/ply_file.hpp"
#include "swiftlet/sim/world/mesh_import.hpp"
#include "tests/support/file_test.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Points = std::vector<Vector3d>;

class CloudFiles : public FileTest {
 protected:
  Points pcd(const std::string& content) const { return read_point_cloud(write("a.pcd", content)); }
  Points ply(const std::string& content) const { return read_point_cloud(write("a.ply", content)); }
  std::string pcd_refusal(const std::string& content) const {
    return refusal_of([&] { pcd(content); });
  }
  std::string ply_refusal(const std::string& content) const {
    return refusal_of([&] { ply(content); });
  }
};

/// LZF without copies: runs of up to 32 bytes.
std::string lzf_of(const std::string& in) {
  std::string out;
  for (std::size_t i = 0; i < in.size(); i += 32) {
    const std::string run = in.substr(i, 32);
    out += static_cast<char>(run.size() - 1) + run;
  }
  return out;
}

const std::string kXyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";

TEST_F(CloudFiles, ReadNumbersOfAsciiPcd) {
  const std::string head =
      "# a comment\n\nVERSION 0.7\nCOLUMNS x extra y z\r\nSIZE 4 4 4 8\nTYPE F U F f\nCOUNT 1 2 1 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\n";
  const Points expected = {{1.5, -2, 3e3}, {4, 5, 6}};
  EXPECT_EQ(pcd(head + "POINTS 2\nDATA ascii\n+1.5 7 8 -2 3e3\r\n\t4 7 8 5\n 6"), expected);
  EXPECT_EQ(pcd(head + "WIDTH 1\nHEIGHT 2\nDATA ascii\n1.5 7 8 -2 3e3\n4 7 8 5 6\n"), expected);
  // Points with values that are not finite, or out of range, are left out.
  EXPECT_EQ(pcd(head + "POINTS 4\nDATA ascii\n1.5 7 8 -2 3e3\nnan 7 8 5 6\n1 7 8 inf 2\n1 7 8 2 1e999\n").size(), 1U);
  EXPECT_EQ(pcd(head + "POINTS 0\nDATA ascii\n").size(), 0U);
  EXPECT_EQ(pcd(head + "WIDTH 7\nHEIGHT 0\nDATA ascii\n").size(), 0U);
  EXPECT_THAT(pcd_refusal(head + "POINTS 2\nDATA ascii\n1 7 8 2 3\n4 7 8 5\n"),
              AllOf(HasSubstr("point 1"), HasSubstr("'z'")));
  EXPECT_THAT(pcd_refusal(head + "POINTS 1\nDATA ascii\n1 7 x 2 3\n"),
              AllOf(HasSubstr("point 0"), HasSubstr("'extra'")));
  EXPECT_THAT(pcd_refusal(head + "POINTS 1\nDATA ascii\n1 7 8 2 3x\n"), HasSubstr("'z'"));
  EXPECT_THAT(pcd_refusal(head + "POINTS 99\nDATA ascii\n1 7 8 2 3\n"), HasSubstr("point 1: "));
  EXPECT_THAT(pcd_refusal(head + "POINTS 2\nDATA ascii\n1 7 8 2 3\n1 7 8 x 3\n"), HasSubstr("a.pcd:12: point 1: "));
  EXPECT_THAT(pcd_refusal(head + "POINTS 9999\nDATA ascii\n1 7 8 2 3\n"), HasSubstr("announces 9999 points"));
}

TEST_F(CloudFiles, SkipPcdFieldsOfZeroCount) {
  EXPECT_EQ(pcd("FIELDS x none y z\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 0 1 1\nPOINTS 1\nDATA ascii\n1 2 3\n"),
            (Points{{1, 2, 3}}));
  EXPECT_THAT(pcd_refusal("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 0\nPOINTS 1\nDATA ascii\n1 2 3\n"),
              HasSubstr("no z"));
}

TEST_F(CloudFiles, AcceptPcdFieldsInAnyOrder) {
  const std::string head = "FIELDS intensity z x y\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nPOINTS 1\n";
  EXPECT_EQ(pcd(head + "DATA ascii\n9 3 1 2\n"), (Points{{1, 2, 3}}));
  std::string bytes = head + "DATA binary\n";
  for (const float value : {9.0F, 3.0F, 1.0F, 2.0F}) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  EXPECT_EQ(pcd(bytes), (Points{{1, 2, 3}}));
}

TEST_F(CloudFiles, ColumnsMayBeNamedByCapitals) {
  EXPECT_EQ(pcd("FIELDS X Y Z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 3\n"), (Points{{1, 2, 3}}));
  EXPECT_EQ(ply("ply\nformat ascii 1.0\nelement vertex 1\nproperty float X\nproperty float Y\nproperty float Z\n"
                "end_header\n1 2 3\n"),
            (Points{{1, 2, 3}}));
}

TEST_F(CloudFiles, DescribeErrorsInPcdHeaders) {
  for (const char* points : {"many", "-1", "1.200", "1 200", "200abc", "2e2", "0x10", ""}) {
    EXPECT_THAT(pcd_refusal(kXyz + "POINTS " + points + "\nDATA ascii\n1 2 3\n"),
                AllOf(HasSubstr("a.pcd:5: "), HasSubstr("'POINTS " + std::string(points) + "'")));
  }
  const std::string fields = "FIELDS x y z\n", ascii = "POINTS 0\nDATA ascii\n", points = "expected POINTS";
  const std::pair<std::string, std::string> cases[] = {
      {fields + "SIZE 4 4 4a\n" + ascii, "'SIZE 4 4 4a'"},
      {fields + "SIZE 4 4 4 4\n" + ascii, "'SIZE 4 4 4 4'"},
      {fields + "SIZE 2 4 4\nTYPE F F F\n" + ascii, "size of 4 or 8 for type F of field 'x'"},
      {fields + "SIZE 4 4 4\nTYPE F F D\n" + ascii, "'TYPE F F D'"},
      {fields + "COUNT 1 1 -1\n" + ascii, "'COUNT 1 1 -1'"},
      {fields + "COUNT 1 1 100000\n" + ascii, "COUNT"},
      {kXyz + "WIDTH 2\nHEIGHT 1\nPOINTS 1\nDATA ascii\n", "expected WIDTH x HEIGHT = POINTS, found 2 and 1"},
      {kXyz + "WIDTH 2\nDATA ascii\n", points},
      {kXyz + "HEIGHT 2\nDATA ascii\n", points},
      {kXyz + "WIDTH 549755813889\nHEIGHT 2\nDATA ascii\n", points},
      {kXyz + "POINTS 1\nDATA\n", "expected a kind of data"},
      {kXyz + "POINTS 1\nDATA base64\n", "found 'base64'"},
      {kXyz + "POINTS 1\n", "ends with 'DATA'"},
      {"# " + std::string(1 << 20, 'x') + "\n" + kXyz + ascii, "ends with 'DATA'"}};  // headers end within a mebibyte
  for (const auto& [content, reason] : cases) EXPECT_THAT(pcd_refusal(content), HasSubstr(reason));
  EXPECT_THAT(pcd(fields + "SIZE 1 2 8\nTYPE U I i\n" + ascii), IsEmpty());
}

template <class Value>
void put(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

TEST_F(CloudFiles, CompressedPcdLiesFieldByField) {
  const std::string head =
      "FIELDS x tag y z\nSIZE 4 2 4 8\nTYPE F U F F\nCOUNT 2 3 1 1\nPOINTS 50\nDATA binary_compressed\n";
  Points expected;
  std::string x, tag, y, z;
  for (int i = 0; i < 50; ++i) {
    expected.emplace_back(0.5 * i, -i, 2.25);
    put(x, static_cast<float>(0.5 * i));
    put(x, -7.0F);  // the first of two values counts
    tag += "ababab";
    put(y, static_cast<float>(-i));
    put(z, 2.25);
  }
  const std::string plain = x + tag + y + z, packed = lzf_of(plain);
  const auto file = [&](std::size_t compressed, std::size_t uncompressed, const std::string& data) {
    std::string content = head;
    put(content, static_cast<std::uint32_t>(compressed));
    put(content, static_cast<std::uint32_t>(uncompressed));
    return content + data;
  };
  EXPECT_EQ(pcd(file(packed.size(), plain.size(), packed)), expected);
  EXPECT_EQ(pcd(file(packed.size(), plain.size(), packed + "and more")), expected);
  EXPECT_THAT(pcd_refusal(file(packed.size() + 1, plain.size(), packed)), HasSubstr("compressed bytes, found"));
  EXPECT_THAT(pcd_refusal(file(packed.size(), plain.size() + 1, packed)), HasSubstr("do not decompress"));
  EXPECT_THAT(pcd_refusal(file(0, 0, "")), HasSubstr("truncated: expected 50 points of 26 bytes, found 0 bytes"));
  // Three bytes stand for 264.
  EXPECT_THAT(pcd_refusal(file(3, 88 * 4 + 1, "abc")), HasSubstr("cannot hold 353 bytes"));
  EXPECT_THAT(pcd_refusal(file(3, 88 * 4, "abc")), HasSubstr("do not decompress"));
}

// Each type name, with values at the ends of its range.
TEST_F(CloudFiles, ReadAnyPlyTypeAndOrder) {
  struct Type {
    const char* name;
    int size;
    double low, high;
  };
  const Type types[] = {{"char", 1, -128, 127},
                        {"int8", 1, -128, 127},
                        {"uchar", 1, 0, 255},
                        {"uint8", 1, 0, 255},
                        {"short", 2, -32768, 32767},
                        {"int16", 2, -32768, 32767},
                        {"ushort", 2, 0, 65535},
                        {"uint16", 2, 0, 65535},
                        {"int", 4, -2147483648.0, 2147483647},
                        {"int32", 4, -2147483648.0, 2147483647},
                        {"uint", 4, 0, 4294967295.0},
                        {"uint32", 4, 0, 4294967295.0},
                        {"float", 4, -0.25, 1.5},
                        {"float32", 4, -0.25, 1.5},
                        {"double", 8, -1e-9, 3e9},
                        {"float64", 8, -1e-9, 3e9}};
  for (const Type& type : types) {
    const std::string name(type.name);
    const auto bytes_of = [&](double value) {
      std::string bytes;
      if (type.size == 8) {
        put(bytes, value);
      } else if (name.starts_with("float")) {
        put(bytes, static_cast<float>(value));
      } else {
        put(bytes, static_cast<std::int64_t>(value));
      }
      return bytes.substr(0, static_cast<std::size_t>(type.size));
    };
    for (const bool big : {false, true}) {
      std::string data;
      for (const double value : {type.low, type.high, 1.0}) {
        const std::string bytes = bytes_of(value);
        data += big ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
      }
      const std::string head = std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
                               " 1.0\nobj_info nothing\nelement vertex 1\nproperty " + name + " x\nproperty " + name +
                               " y\nproperty " + name + " z\nend_header\n";
      const Points points = ply(head + data);
      ASSERT_EQ(points.size(), 1U) << name;
      EXPECT_EQ(points[0], Vector3d(type.low, type.high, 1.0)) << name << big;
      EXPECT_THAT(ply_refusal(head + data.substr(1)), HasSubstr("truncated")) << name;
    }
  }
}

const std::string kVertex = "property float x\nproperty float y\nproperty float z\n";

TEST_F(CloudFiles, ReadAsciiPlyOfMinimumLength) {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 2\n" + kVertex + "end_header\n";
  EXPECT_EQ(ply(head + "1 2 3 4 5 6"), (Points{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(
      ply("ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement vertex 1\r\nproperty double x\r\nproperty double "
          "y\r\nproperty double z\r\nend_header\r\n+1 2 3\r\n"),
      (Points{{1, 2, 3}}));
  EXPECT_EQ(ply(head + "1 2 3 nan 5 6").size(), 1U);
  EXPECT_THAT(ply_refusal(head + "1 2 3 4 5 "), HasSubstr("truncated: the PLY header announces 2 elements 'vertex'"));
  EXPECT_THAT(ply_refusal(head + "1 2 3 4 5  "),
              HasSubstr("a.ply:8: expected a number, found none for 'z' of vertex 1"));
  EXPECT_THAT(ply_refusal(head + "1 2 3\n4 five 6"),
              HasSubstr("a.ply:9: expected a number, found none for 'y' of vertex 1"));
  const std::string none = "ply\nformat ascii 1.0\nelement vertex 0\n" + kVertex + "end_header\n";
  EXPECT_THAT(ply(none), IsEmpty());
}

TEST_F(CloudFiles, DescribeErrorsInPlyHeaders) {
  const std::string begin = "ply\nformat ascii 1.0\n", vertex = begin + "element vertex 0\n";
  const std::pair<std::string, const char*> cases[] = {
      {"plyy\n", "begins with 'ply'"},
      {"format ascii 1.0\nply\nend_header\n", "begins with 'ply'"},
      {"ply\nelement vertex 0\n" + kVertex + "end_header\n", "expected a format"},
      {begin + "element vertex\n", "expected the number of elements"},
      {begin + "element vertex 3x\n", "'element vertex 3x'"},
      {begin + "element vertex -3\n", "expected the number of elements"},
      {begin + "element vertex 99999999999999999999\n", "expected the number"},
      {"ply\nformat binary_big_endian 1.0\nelement n 4611686018427387904\nproperty int a\nend_header\n", "truncated"},
      {begin + "property float x\n", "expected an element before"},
      {vertex + "property real x\n", "expected a property type"},
      {vertex + "property float\n", "expected a property name"},
      {begin + "element face 0\nproperty list float int v\n", "whole-number type"},
      {begin + "elements vertex 0\n", "found 'elements vertex 0'"},
      {vertex, "ends with 'end_header'"},
      {vertex + "property float x\nproperty float z\nend_header\n", "found no y"},
      {vertex + "comment " + std::string(1 << 20, 'x') + "\n" + kVertex + "end_header\n", "ends with 'end_header'"}};
  for (const auto& [content, reason] : cases) EXPECT_THAT(ply_refusal(content), HasSubstr(reason));
}

TEST_F(CloudFiles, SkipListsInPlyClouds) {
  const Points expected = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const std::string views = "element vertex 3\n" + kVertex + "property list uchar int view\nend_header\n";
  EXPECT_EQ(ply("ply\nformat ascii 1.0\n" + views + "0 0 0 2 4 5\n1 0 0 0\n1 1 0 1 7\n"), expected);
  EXPECT_EQ(ply("ply\nformat ascii 1.0\nelement camera 2\nproperty list uchar float focal\n" + views +
                "2 1.5 2.5\n0\n0 0 0 2 4 5\n1 0 0 0\n1 1 0 1 7\n"),
            expected);
  std::string bytes = "ply\nformat binary_little_endian 1.0\n" + views;
  for (const Vector3d& point : expected) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<float>(point[axis]));
    bytes += std::string("\1\7\0\0\0", 5);
  }
  EXPECT_EQ(ply(bytes), expected);
}

TEST(InputFile, HasLowerCaseExtensionsWithoutDot) {
  EXPECT_EQ(extension_of("a/b.PLY"), "ply");
  EXPECT_EQ(extension_of("a/b.c.Obj"), "obj");
  EXPECT_EQ(extension_of("a/b"), "");
}

std::string refused(const std::string& content) {
  return refusal_of([&] { read_ply_mesh("a.ply", content); });
}

/// A binary file of two vertices, an unknown element between them and two faces of 3 and 200 corners.
class PlyMeshOf : public ::testing::TestWithParam<std::string> {
 protected:
  template <class Value>
  std::string bytes(Value value) const {
    std::string out(sizeof value, ' ');
    std::memcpy(out.data(), &value, sizeof value);
    if (GetParam() == "big") std::reverse(out.begin(), out.end());
    return out;
  }
  std::string face(int length, int corner) const {
    std::string out = "t" + bytes(static_cast<std::uint8_t>(length));
    for (int i = 0; i < length; ++i) out += bytes(std::int32_t{corner});
    return out + "a";
  }
  std::string head() const {
    return "ply\nformat binary_" + GetParam() +
           "_endian 1.0\nelement vertex 2\nproperty short tag\nproperty double x\nproperty float z\nproperty int y\n"
           "element n 7\nelement m 1\nproperty list ushort float values\nelement face 2\nproperty uchar tag\n"
           "property list uchar int vertex_index\nproperty uchar after\nend_header\n";
  }
  std::string vertices() const {
    return bytes(std::int16_t{7}) + bytes(1.5) + bytes(2.5F) + bytes(std::int32_t{-3}) +  //
           bytes(std::int16_t{8}) + bytes(4.0) + bytes(5.0F) + bytes(std::int32_t{6}) +   //
           bytes(std::uint16_t{2}) + bytes(9.0F) + bytes(9.5F);
  }
};
INSTANTIATE_TEST_SUITE_P(Orders, PlyMeshOf, ::testing::Values("little", "big"));

TEST_P(PlyMeshOf, ReadsBinaryFilesByValue) {
  const MeshFile mesh = read_ply_mesh("a.ply", head() + vertices() + face(3, 1) + face(200, 0));
  EXPECT_THAT(mesh.vertices_mesh, ElementsAre(Vector3d(1.5, -3.0, 2.5), Vector3d(4.0, 6.0, 5.0)));
  EXPECT_THAT(mesh.faces_end, ElementsAre(3U, 203U));
  EXPECT_EQ(mesh.corners[2], 1U);
  EXPECT_EQ(mesh.corners[3], 0U);
}

TEST_P(PlyMeshOf, RefusesTruncatedBinaryFiles) {
  const std::string whole = head() + vertices() + face(3, 1) + face(4, 0);
  EXPECT_NO_THROW(read_ply_mesh("a.ply", whole + "more"));
  EXPECT_THAT(refused(whole.substr(0, whole.size() - 1)), HasSubstr("truncated: it ends before 'after' of face 1"));
  EXPECT_THAT(refused(whole.substr(0, whole.size() - 18)), HasSubstr("it ends before 'vertex_index' of face 1"));
  // Five values of four bytes are in the twenty-one that follow, six are not.
  const std::string begun = head() + vertices() + "t";
  EXPECT_THAT(refused(begun + bytes(std::uint8_t{6}) + std::string(21, '\0')),
              HasSubstr("face 0: expected a list 'vertex_index' that fits into the file, found one of 6 values"));
  EXPECT_THAT(refused(begun + bytes(std::uint8_t{5}) + std::string(21, '\0')), HasSubstr("face 1"));
}

TEST(PlyMesh, ReadsAsciiFilesByTheirHeader) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_indices\nproperty int id\n"
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  const std::string vertices = "1 2 3\n-4e1 +5 6\n";
  const MeshFile mesh = read_ply_mesh("a.ply", head + "3 0 1 0 7\n 2 1 1 8\n" + vertices);
  EXPECT_THAT(mesh.vertices_mesh, ElementsAre(Vector3d(1, 2, 3), Vector3d(-40, 5, 6)));
  EXPECT_THAT(mesh.corners, ElementsAre(0U, 1U, 0U, 1U, 1U));
  EXPECT_THAT(mesh.faces_end, ElementsAre(3U, 5U));
  EXPECT_THAT(refused(head + "3 0 1 0 7\n 2 1 1 8\n1 2 3\n4 5"),
              HasSubstr("expected a number, found none for 'z' of vertex 1"));
  EXPECT_THAT(refused(head + "3 0 1 0 7\n 2 1 1 8\n1 2 3x\n4 5 6"), HasSubstr("'z' of vertex 0"));
  for (const char* length : {"-1", "1.5", "nan", "99", "1e300", "4294967295"}) {
    EXPECT_THAT(refused(head + "3 0 1 0 7\n" + length + " 0 1\n" + vertices), HasSubstr("face 1: expected a list"))
        << length;
  }
  for (const char* corner : {"-1", "0.5", "2", "4294967295", "1e300", "nan"}) {
    const MeshFile wrong = read_ply_mesh("a.ply", head + "3 0 1 0 7\n2 " + corner + " 1 8\n" + vertices);
    EXPECT_GE(wrong.corners[3], wrong.vertices_mesh.size()) << corner;
  }
}

// ---- Meshes.

TEST_F(CloudFiles, RefuseIncompleteBinaryStl) {
  const auto import = [&](const std::string& content) {
    MeshImportConfig config;
    config.file = write("a.stl", content).string();
    return make_mesh_import(config, 1).num_triangles();
  };
  std::string head(80, ' '), triangle(12, '\0');
  for (const float value : {0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F}) put(triangle, value);
  triangle += std::string(2, '\0');
  const auto counted = [&](std::uint32_t count) {
    std::string content = head;
    put(content, count);
    return content;
  };
  EXPECT_EQ(import(counted(1) + triangle), 1U);
  EXPECT_THAT(refusal_of([&] { import(counted(1) + triangle.substr(1)); }),
              HasSubstr("expected 134 bytes for 1 triangles, found 133"));
  EXPECT_THAT(refusal_of([&] { import(counted(2) + triangle); }),
              HasSubstr("expected 184 bytes for 2 triangles, found 134"));
  EXPECT_THAT(refusal_of([&] { import(counted(0).substr(1)); }),
              HasSubstr("expected 84 bytes of STL header, found 83"));
  EXPECT_THAT(refusal_of([&] { import(counted(0)); }), testing::Not(HasSubstr("STL header")));
}

TEST_F(CloudFiles, DeriveClassAndNumberFromNames) {
  struct Case {
    const char* name;
    SurfaceClass surface_class;
    std::uint16_t number;
  };
  // An unknown name is a wall, numbered from 1.
  const Case cases[] = {{"trunk_12_345", SurfaceClass::kTrunk, 12},
                        {"trunk_7", SurfaceClass::kTrunk, 7},
                        {"fallen_trunk_3_1", SurfaceClass::kFallenTrunk, 3},
                        {"object_65535_2", SurfaceClass::kObject, 65535},
                        {"object_65536_2", SurfaceClass::kWall, 1},
                        {"trunk_", SurfaceClass::kWall, 1},
                        {"trunk_x", SurfaceClass::kWall, 1},
                        {"trunk_4x", SurfaceClass::kWall, 1},
                        {"trunk4", SurfaceClass::kWall, 1},
                        {"my_trunk_4", SurfaceClass::kWall, 1},
                        {"rack_0_9", SurfaceClass::kRack, 1}};
  for (const Case& one : cases) {
    MeshImportConfig config;
    config.surface_class = "wall";
    config.file = write("named.obj", std::string("o ") + one.name + "\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n").string();
    const Scene scene = make_mesh_import(config, 1);
    ASSERT_EQ(scene.instances.size(), 1U);
    EXPECT_EQ(scene.meshes[0].surface_class, one.surface_class) << one.name;
    EXPECT_EQ(scene.instances[0].instance, one.number) << one.name;
  }
}

TEST_F(CloudFiles, ColorMaterialsWithGrayDefault) {
  write("paint.mtl", "newmtl red\nKd 0.9 0.2 0.1\n");
  MeshImportConfig config;
  config.file = write("a.obj", "mtllib paint.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n").string();
  EXPECT_TRUE(make_mesh_import(config, 1).materials.at(0).color_rgb.isApprox(Eigen::Vector3f(0.9F, 0.2F, 0.1F), 1e-5F));
  std::string stl =
      "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 2\nvertex 3 0 2\nvertex 0 4 2\nendloop\nendfacet\n";
  config.file = write("b.stl", stl + "endsolid one\n").string();
  const Eigen::Vector3f plain = make_mesh_import(config, 1).materials.at(0).color_rgb;
  EXPECT_EQ(plain.x(), plain.y());
  EXPECT_EQ(plain.x(), plain.z());
}

}  // namespace
}  // namespace swiftlet::sim
