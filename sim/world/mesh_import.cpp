// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/mesh_import.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/world/input_file.hpp"
#include "sim/world/mesh_file.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/nearest_word.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

/// Largest coordinate of a placed vertex. Single precision resolves 8 mm there.
constexpr double kReach_m = 1e5;

struct Label {
  SurfaceClass surface_class = SurfaceClass::kUnlabeled;
  std::uint16_t instance = 0;  // 0: the next free number
  float reflectivity = 0.3F;
  bool retroreflective = false;
};

// Parses names of export_world(): "trunk_12_345" is tree 12.
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

std::vector<std::string> names_of(const MeshFile::Part& part) { return {part.object, part.group, part.material}; }

bool names_part(const SurfaceRuleConfig& rule, const MeshFile::Part& part) {
  const std::vector<std::string> names = names_of(part);
  return !rule.name.empty() && std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return name.find(rule.name) != std::string::npos;
  });
}

Label label_of(const MeshImportConfig& config, const MeshFile::Part& part) {
  Label label;
  label.reflectivity = static_cast<float>(config.reflectivity);
  for (const SurfaceRuleConfig& rule : config.surfaces) {
    if (!names_part(rule, part)) continue;
    label.surface_class = surface_class_of(rule.surface_class).value_or(SurfaceClass::kUnlabeled);
    label.reflectivity = static_cast<float>(rule.reflectivity);
    label.retroreflective = rule.retroreflective;
    return label;
  }
  if (!parse_exported_name(part.object, label) && !parse_exported_name(part.group, label))
    label.surface_class = surface_class_of(config.surface_class).value_or(SurfaceClass::kUnlabeled);
  return label;
}

/// Suggestion for a rule's word: a name part that differs only in case, or the nearest name; empty: none.
std::string likely_name(const std::string& word, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const std::size_t at = lower_case(name).find(lower_case(word));
    if (at != std::string::npos && !word.empty()) return name.substr(at, word.size());
  }
  const std::string* nearest = nearest_word(word, names);
  return nearest == nullptr ? "" : *nearest;
}

/// Every rule must match a part; otherwise a typing error would silently change labels and intensities.
void require_rules_to_match(const MeshImportConfig& config, const MeshFile& source) {
  constexpr std::size_t kMaxShown = 8;
  for (std::size_t i = 0; i < config.surfaces.size(); ++i) {
    const SurfaceRuleConfig& rule = config.surfaces[i];
    if (std::any_of(source.parts.begin(), source.parts.end(), [&](const auto& part) { return names_part(rule, part); }))
      continue;
    std::vector<std::string> names;
    for (const MeshFile::Part& part : source.parts) {
      for (const std::string& name : names_of(part)) {
        if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
    }
    std::string known;
    for (std::size_t k = 0; k < std::min(names.size(), kMaxShown); ++k) known += (k == 0 ? "" : ", ") + names[k];
    if (names.size() > kMaxShown) known += ", ...";
    const std::string similar = likely_name(rule.name, names);
    throw InputError("world.surfaces[" + std::to_string(i) + "].name: expected part of a name in " + config.file +
                     " (" + (known.empty() ? "which names nothing" : known) + "), found \"" + rule.name + "\"" +
                     (similar.empty() ? "" : "; did you mean \"" + similar + "\"?"));
  }
}

MeshFile read_mesh(const fs::path& file) {
  const std::string extension = extension_of(file);
  if (extension != "obj" && extension != "ply" && extension != "stl")
    reject_file(file, "expected a mesh named .obj, .ply or .stl");
  const std::string content = read_whole_file(file);
  if (content.empty()) reject_file(file, "expected a mesh, found an empty file");
  if (extension == "obj") return read_obj(file, content);
  return extension == "ply" ? read_ply_mesh(file, without_mark(content)) : read_stl(file, content);
}

class Converter {
 public:
  Converter(const MeshImportConfig& config, const MeshFile& source)
      : config_(config), source_(source), local_(source.vertices_mesh.size(), MeshFile::kNoVertex) {
    T_world_file_ = placement(config.position_m, config.yaw_deg, config.scale);
    if (config.up_axis == MeshImportConfig::UpAxis::kY)
      T_world_file_.rotate(Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitX()));
  }

  Scene run() {
    for (std::size_t i = 0; i < source_.parts.size(); ++i) {
      const bool is_last = i + 1 == source_.parts.size();
      add_part(source_.parts[i], is_last ? source_.num_faces() : source_.parts[i + 1].first_face);
    }
    Scene scene = scene_.finish();
    if (scene.num_triangles() == 0) {
      reject_file(config_.file, num_bad_ == 0 ? "expected faces, found none"
                                              : "expected a face with an area, found none; " + first_bad_);
    }
    scene.counters.push_back({"faces left out: " + first_bad_, num_bad_, source_.num_faces(), "world.file"});
    return scene;
  }

 private:
  void add_part(const MeshFile::Part& part, std::size_t faces_end) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t face = part.first_face; face < faces_end; ++face) {
      const char* const problem = append_triangles(source_, face, triangles);
      if (problem != nullptr && num_bad_++ == 0) first_bad_ = source_.place_of(face) + ": " + problem;
    }
    if (triangles.empty()) return;
    Label label = label_of(config_, part);
    if (label.instance == 0) label.instance = scene_.next_instance(label.surface_class);
    // Parts of one material may have different labels, hence the class in the name.
    const Material material{(part.material.empty() ? "default" : part.material) + ":" + name_of(label.surface_class) +
                                ":" + std::to_string(label.reflectivity),
                            label.reflectivity, label.retroreflective, part.color_rgb};
    scene_.add(placed(std::move(triangles)), material, label.surface_class, label.instance);
  }

  /// The triangles with vertices in the world frame, converted to single precision.
  Mesh placed(std::vector<std::array<std::uint32_t, 3>> triangles) {
    Mesh mesh;
    std::vector<std::uint32_t> used;  // vertices of the file, in the order of the new mesh
    for (auto& triangle : triangles) {
      for (std::uint32_t& corner : triangle) {
        std::uint32_t& local = local_[corner];
        if (local == MeshFile::kNoVertex) {
          local = static_cast<std::uint32_t>(used.size());
          used.push_back(corner);
        }
        corner = local;
      }
    }
    for (const std::uint32_t vertex : used) {
      local_[vertex] = MeshFile::kNoVertex;
      const Eigen::Vector3d p_world_m = T_world_file_ * source_.vertices_mesh[vertex];
      if (!(p_world_m.cwiseAbs().maxCoeff() <= kReach_m)) reject_distance(p_world_m);
      mesh.vertices_mesh_m.push_back(p_world_m.cast<float>());
    }
    mesh.triangles = std::move(triangles);
    return mesh;
  }

  [[noreturn]] void reject_distance(const Eigen::Vector3d& p_world_m) const {
    const auto triple = [](const Eigen::Vector3d& p) {
      std::string text;
      for (int axis = 0; axis < 3; ++axis) text += (axis == 0 ? "[" : ", ") + shortest(std::round(p[axis]));
      return text + "]";
    };
    reject_file(config_.file, "expected vertices within 100 km of the world's origin, found one at " +
                                  triple(p_world_m) + " m; position_m: " + triple(config_.position_m - p_world_m) +
                                  " of a world of type mesh moves it");
  }

  const MeshImportConfig& config_;
  const MeshFile& source_;
  Eigen::Affine3d T_world_file_;
  std::vector<std::uint32_t> local_;  // scratch: new index of each vertex of the file
  SceneBuilder scene_;
  std::uint64_t num_bad_ = 0;
  std::string first_bad_;
};

}  // namespace

void SurfaceRuleConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] part of the name of a mesh, object, group or material in the file");
  v.choice("class", surface_class, static_class_names(), "[-] truth class of the matching parts");
  v.field("reflectivity", reflectivity, "[-] Lambertian reflectivity of the matching parts", Range::probability());
  v.field("retroreflective", retroreflective, "[-] retro-reflective: returns the beam to its source");
}

void MeshImportConfig::visit(ConfigVisitor& v) {
  v.file("file", file, "[-] mesh: .obj, .ply or .stl");
  v.choice("up_axis", up_axis, {"z", "y"}, "[-] axis of the file that points up");
  v.field("scale", scale, "[-] meters per unit of the file", Range::positive());
  v.field("yaw_deg", yaw_deg, "[deg] turn about the vertical, after scaling");
  v.field("position_m", position_m, "[m] position of the file's origin in the world");
  v.choice("class", surface_class, static_class_names(), "[-] truth class of parts without a matching rule");
  v.field("reflectivity", reflectivity, "[-] Lambertian reflectivity of parts without a matching rule",
          Range::probability());
  v.list("surfaces", surfaces, "rules for parts of the file; the first matching one applies");
}

Scene make_mesh_import(const MeshImportConfig& config, std::uint64_t) {
  if (config.file.empty()) throw InputError("world mesh: file: expected the name of a mesh, found none");
  const MeshFile source = read_mesh(config.file);
  Scene scene = Converter(config, source).run();
  require_rules_to_match(config, source);
  return scene;
}

}  // namespace swiftlet::sim
