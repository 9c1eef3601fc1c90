// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/mesh_import.hpp"

#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/world/input_file.hpp"
#include "sim/world/ply_file.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kMaxCorners = 100'000;  // of a face

struct Label {
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;  // 0: the next free number
  float reflectivity = 0.3F;
  bool retroreflective = false;
};

// "trunk_12_345" is tree 12 as export_world() names it.
bool parse_exported_name(const std::string& name, Label& label) {
  for (const char* candidate : static_class_names()) {
    const std::size_t length = std::strlen(candidate);
    if (name.compare(0, length, candidate) != 0 || name.size() <= length + 1 || name[length] != '_') continue;
    unsigned number = 0;
    const char* end = name.data() + name.size();
    const auto result = std::from_chars(name.data() + length + 1, end, number);
    if (result.ec != std::errc() || number > std::numeric_limits<std::uint16_t>::max() ||
        (result.ptr != end && *result.ptr != '_'))
      continue;
    label.surface_class = *surface_class_of(candidate);
    label.instance = static_cast<std::uint16_t>(number);
    return true;
  }
  return false;
}

Label label_of(const MeshImportConfig& config, const std::string& mesh_name, const std::string& material_name) {
  Label label;
  label.reflectivity = static_cast<float>(config.reflectivity);
  for (const SurfaceRuleConfig& rule : config.surfaces) {
    const bool matches = !rule.name.empty() && (mesh_name.find(rule.name) != std::string::npos ||
                                                material_name.find(rule.name) != std::string::npos);
    if (!matches) continue;
    label.surface_class = surface_class_of(rule.surface_class).value_or(SurfaceClass::kUnlabeled);
    label.reflectivity = static_cast<float>(rule.reflectivity);
    label.retroreflective = rule.retroreflective;
    return label;
  }
  if (!parse_exported_name(mesh_name, label))
    label.surface_class = surface_class_of(config.surface_class).value_or(SurfaceClass::kUnlabeled);
  return label;
}

// The library believes the number of triangles in the head of an STL file before it looks how long the file is.
void check_stl(const fs::path& file, const std::string& content) {
  if (content.compare(0, 5, "solid") == 0) return;
  if (content.size() < 84)
    reject_file(file, "truncated: expected 84 bytes of STL header, found " + std::to_string(content.size()));
  std::uint32_t triangles = 0;
  std::memcpy(&triangles, content.data() + 80, sizeof triangles);
  const std::uint64_t expected = 84 + 50ULL * triangles;
  if (content.size() < expected) {
    reject_file(file, "truncated: expected " + std::to_string(expected) + " bytes for " + std::to_string(triangles) +
                          " triangles, found " + std::to_string(content.size()));
  }
}

/// The library reads a PLY file that we wrote: its own reader reads on behind the end, and takes text for lengths.
const aiScene* read_scene(Assimp::Importer& importer, const fs::path& file, const std::string& extension) {
  const std::string content = read_whole_file(file);
  if (content.empty()) reject_file(file, "expected a mesh, found an empty file");
  if (extension == "ply") {
    const std::string plain = to_plain_ply(read_ply_mesh(file, content));
    return importer.ReadFileFromMemory(plain.data(), plain.size(), 0, "ply");
  }
  if (extension == "stl") check_stl(file, content);
  return importer.ReadFile(file, 0);
}

// The library triangulates polygons by assertions, not by messages.
void check_faces(const fs::path& file, const aiMesh& mesh) {
  std::vector<unsigned> corners;
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    const std::string name = "face " + std::to_string(i);
    if (face.mNumIndices > kMaxCorners || (face.mNumIndices > 0 && face.mIndices == nullptr))
      reject_file(file, name + ": expected at most " + std::to_string(kMaxCorners) + " corners, found " +
                            std::to_string(face.mNumIndices));
    corners.assign(face.mIndices, face.mIndices + face.mNumIndices);
    std::sort(corners.begin(), corners.end());
    if (!corners.empty() && corners.back() >= mesh.mNumVertices)
      reject_file(file, name + " names a vertex that does not exist");
    if (corners.size() > 3 && std::adjacent_find(corners.begin(), corners.end()) != corners.end())
      reject_file(file, name + " has a corner twice");
  }
}

// From the file to the world: up axis, scale, yaw, position.
Eigen::Affine3f placement(const MeshImportConfig& config) {
  Eigen::Affine3f T =
      transform(config.position_m.cast<float>(), static_cast<float>(config.yaw_deg * std::numbers::pi / 180.0),
                Eigen::Vector3f::Constant(static_cast<float>(config.scale)));
  if (config.up_axis == MeshImportConfig::UpAxis::kY)
    T.rotate(Eigen::AngleAxisf(std::numbers::pi_v<float> / 2.0F, Eigen::Vector3f::UnitX()));
  return T;
}

Mesh convert(const fs::path& file, const aiMesh& source) {
  Mesh mesh;
  mesh.vertices_mesh_m.reserve(source.mNumVertices);
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D& p = source.mVertices[i];
    mesh.vertices_mesh_m.emplace_back(p.x, p.y, p.z);
    if (!mesh.vertices_mesh_m.back().allFinite())
      reject_file(file, "expected finite coordinates, vertex " + std::to_string(i) + " has others");
  }
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    if (face.mNumIndices != 3) continue;
    for (unsigned k = 0; k < 3; ++k) {
      if (face.mIndices[k] >= source.mNumVertices)
        reject_file(file, "face " + std::to_string(i) + " names a vertex that does not exist");
    }
    mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  return mesh;
}

Eigen::Affine3f to_eigen(const aiMatrix4x4& m) {
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4;
  return T;
}

class Converter {
 public:
  Converter(const MeshImportConfig& config, const aiScene& source) : config_(config), source_(source) {}

  Scene run() {
    add_node(*source_.mRootNode, placement(config_), 0);
    Scene scene = scene_.finish();
    if (scene.num_triangles() == 0) reject_file(config_.file, "expected triangles, found none");
    return scene;
  }

 private:
  void add_node(const aiNode& node, const Eigen::Affine3f& T_world_parent, int depth) {
    if (depth > 100) reject_file(config_.file, "expected at most 100 nested groups");
    const Eigen::Affine3f T_world_node = T_world_parent * to_eigen(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
      add_mesh(*source_.mMeshes[node.mMeshes[i]], node.mName.C_Str(), T_world_node);
    for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(*node.mChildren[i], T_world_node, depth + 1);
  }

  void add_mesh(const aiMesh& source, const std::string& node_name, const Eigen::Affine3f& T) {
    Mesh mesh = convert(config_.file, source);
    if (mesh.triangles.empty()) return;
    const std::string mesh_name = source.mName.length > 0 ? source.mName.C_Str() : node_name;
    const aiMaterial& source_material = *source_.mMaterials[source.mMaterialIndex];
    aiString material_name;
    source_material.Get(AI_MATKEY_NAME, material_name);
    aiColor3D color(0.6F, 0.6F, 0.6F);
    source_material.Get(AI_MATKEY_COLOR_DIFFUSE, color);
    Label label = label_of(config_, mesh_name, material_name.C_Str());
    if (label.instance == 0) label.instance = scene_.next_instance(label.surface_class);

    // Parts of one material in the file may have different labels, hence the class in the name.
    Material material{std::string(material_name.C_Str()) + ":" + name_of(label.surface_class) + ":" +
                          std::to_string(label.reflectivity),
                      label.reflectivity,
                      label.retroreflective,
                      {color.r, color.g, color.b}};
    scene_.place(scene_.add_mesh(std::move(mesh), material, label.surface_class), label.instance, T);
  }

  const MeshImportConfig& config_;
  const aiScene& source_;
  SceneBuilder scene_;
};

}  // namespace

void SurfaceRuleConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] part of the name of a mesh, object, group or material in the file");
  v.choice("class", surface_class, static_class_names(), "[-] its truth class");
  v.field("reflectivity", reflectivity, "[-] its Lambertian reflectivity", Range::probability());
  v.field("retroreflective", retroreflective, "[-] sends the beam back to its source");
}

void MeshImportConfig::visit(ConfigVisitor& v) {
  v.file("file", file, "[-] mesh: .obj, .ply or .stl");
  v.choice("up_axis", up_axis, {"z", "y"}, "[-] axis of the file that points up");
  v.field("scale", scale, "[-] meters for a unit of the file", Range::positive());
  v.field("yaw_deg", yaw_deg, "[deg] turn about the vertical, after scaling");
  v.field("position_m", position_m, "[m] where the file's origin goes");
  v.choice("class", surface_class, static_class_names(), "[-] truth class of what no rule names");
  v.field("reflectivity", reflectivity, "[-] Lambertian reflectivity of what no rule names", Range::probability());
  v.list("surfaces", surfaces, "rules for parts of the file; the first that matches holds");
}

Scene make_mesh_import(const MeshImportConfig& config, std::uint64_t) {
  if (config.file.empty()) throw InputError("world mesh: file: expected the name of a mesh, found none");
  const std::string extension = extension_of(config.file);
  if (extension != "obj" && extension != "ply" && extension != "stl")
    reject_file(config.file, "expected a mesh named .obj, .ply or .stl");
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const auto require = [&](const aiScene* scene) {
    if (scene == nullptr || scene->mRootNode == nullptr)
      reject_file(config.file, std::string("cannot be read as a mesh: ") + importer.GetErrorString());
  };
  const aiScene* source = read_scene(importer, config.file, extension);
  require(source);
  for (unsigned i = 0; i < source->mNumMeshes; ++i) check_faces(config.file, *source->mMeshes[i]);
  source = importer.ApplyPostProcessing(aiProcess_ValidateDataStructure | aiProcess_Triangulate |
                                        aiProcess_SortByPType | aiProcess_JoinIdenticalVertices);
  require(source);
  return Converter(config, *source).run();
}

}  // namespace swiftlet::sim
