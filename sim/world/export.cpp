// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/export.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/byte_buffer.hpp"
#include "swiftlet/sim/io/output_file.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
// [bytes] Size of the write buffer.
constexpr std::size_t kBuffer = 1 << 20;

// Writes the complete file before it appears under its name.
template <class Write>
void write_whole(const fs::path& path, const Write& write) {
  OutputFile file(path, kBuffer, MissingFolders::kRefused);
  write(file);
  file.finish();
}

std::uint8_t to_byte(float unit) {
  return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(unit, 0.0F, 1.0F)));
}

std::size_t num_vertices(const Scene& scene) {
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) count += scene.meshes[instance.mesh].vertices_mesh_m.size();
  return count;
}

void write_ply(const Scene& scene, OutputFile& file) {
  const std::size_t vertices = num_vertices(scene);
  if (vertices > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::runtime_error("PLY indices hold at most 2147483647 vertices, the world has " + std::to_string(vertices));
  }
  file.append(
      "ply\nformat binary_little_endian 1.0\ncomment world frame: x east, y north, z up; meters\nelement vertex " +
      std::to_string(vertices) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty ushort class\nproperty ushort instance\nproperty float reflectivity\n"
      "property uchar retroreflective\nelement face " +
      std::to_string(scene.num_triangles()) + "\nproperty list uchar int vertex_indices\nend_header\n");
  ByteBuffer row;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Material& material = scene.materials[mesh.material];
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) {
      const Eigen::Vector3f p = instance.T_world_mesh * vertex;
      row.clear();
      for (int axis = 0; axis < 3; ++axis) row.put(p[axis]);
      for (int channel = 0; channel < 3; ++channel) row.put(to_byte(material.color_rgb[channel]));
      row.put(static_cast<std::uint16_t>(mesh.surface_class));
      row.put(instance.instance);
      row.put(material.reflectivity);
      row.put(static_cast<std::uint8_t>(material.retroreflective));
      file.append(row.bytes());
    }
  }
  std::int32_t first = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const auto& triangle : mesh.triangles) {
      row.clear();
      row.put(std::uint8_t{3});
      for (const std::uint32_t corner : triangle) row.put(static_cast<std::int32_t>(first + corner));
      file.append(row.bytes());
    }
    first += static_cast<std::int32_t>(mesh.vertices_mesh_m.size());
  }
}

void flush(OutputFile& file, std::string& buffer) {
  file.append(buffer);
  buffer.clear();
}

void write_mtl(const Scene& scene, OutputFile& file) {
  std::string buffer;
  for (const Material& material : scene.materials) {
    buffer += "newmtl " + material.name + "\n# reflectivity ";
    append_number(buffer, material.reflectivity);
    buffer += material.retroreflective ? " retroreflective\nKd" : "\nKd";
    for (int channel = 0; channel < 3; ++channel) {
      buffer += ' ';
      append_number(buffer, material.color_rgb[channel]);
    }
    buffer += "\nillum 1\n\n";
  }
  file.append(buffer);
}

void write_obj(const Scene& scene, const std::string& mtl_name, OutputFile& file) {
  std::string buffer = "# world frame: x east, y north, z up; meters\nmtllib " + mtl_name + "\n";
  std::size_t first = 1;  // OBJ counts from 1
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    buffer += std::string("o ") + name_of(mesh.surface_class) + "_" + std::to_string(instance.instance) + "_" +
              std::to_string(i) + "\nusemtl " + scene.materials[mesh.material].name + "\n";
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) {
      const Eigen::Vector3f p = instance.T_world_mesh * vertex;
      buffer += 'v';
      for (int axis = 0; axis < 3; ++axis) {
        buffer += ' ';
        append_number(buffer, p[axis]);
      }
      buffer += '\n';
      flush(file, buffer);
    }
    for (const auto& triangle : mesh.triangles) {
      buffer += 'f';
      for (const std::uint32_t corner : triangle) {
        buffer += ' ';
        append_number(buffer, first + corner);
      }
      buffer += '\n';
      flush(file, buffer);
    }
    first += mesh.vertices_mesh_m.size();
  }
  file.append(buffer);
}

// One row per object; a column for each attribute of any object, in the order of first appearance.
void write_objects(const Scene& scene, OutputFile& file) {
  std::vector<std::string> keys;
  for (const WorldObject& object : scene.objects) {
    for (const auto& [key, value] : object.attributes) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  std::string buffer = "class,instance,kind,x_m,y_m,z_m,yaw_rad";
  for (const std::string& key : keys) buffer += ',' + key;
  buffer += '\n';
  for (const WorldObject& object : scene.objects) {
    buffer += std::string(name_of(object.surface_class)) + ',' + std::to_string(object.instance) + ',' + object.kind;
    for (const double value :
         {object.position_world_m.x(), object.position_world_m.y(), object.position_world_m.z(), object.yaw_rad}) {
      buffer += ',';
      append_number(buffer, value);
    }
    for (const std::string& key : keys) {
      buffer += ',';
      for (const auto& [name, value] : object.attributes) {
        if (name == key) append_number(buffer, value);
      }
    }
    buffer += '\n';
    flush(file, buffer);
  }
  file.append(buffer);
}

}  // namespace

std::vector<fs::path> export_world(const Scene& scene, const fs::path& out) {
  const std::string extension = out.extension().string();
  std::vector<fs::path> written;
  if (extension == ".ply") {
    write_whole(out, [&](OutputFile& file) { write_ply(scene, file); });
  } else if (extension == ".obj") {
    const fs::path mtl = fs::path(out).replace_extension(".mtl");
    write_whole(mtl, [&](OutputFile& file) { write_mtl(scene, file); });
    write_whole(out, [&](OutputFile& file) { write_obj(scene, mtl.filename().string(), file); });
    written.push_back(mtl);
  } else {
    throw InputError("world export: expected a file named .ply or .obj, found '" + out.string() + "'");
  }
  written.insert(written.begin(), out);
  const fs::path table = fs::path(out).replace_extension(".objects.csv");
  write_whole(table, [&](OutputFile& file) { write_objects(scene, file); });
  written.push_back(table);
  return written;
}

}  // namespace swiftlet::sim
