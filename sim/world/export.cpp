// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/export.hpp"
#include "swiftlet/sim/errors.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "the PLY writer copies numbers as they lie in memory");

[[noreturn]] void fail(const fs::path& file) {
  throw std::runtime_error("cannot write " + file.string() + ": " + std::strerror(errno));
}

// Writes under a temporary name and renames, so that nobody finds half a file.
void write_file(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  fs::path partial = file;
  partial += ".partial";
  errno = 0;
  {
    std::ofstream stream(partial, std::ios::binary);
    if (!stream) fail(file);
    write(stream);
    stream.flush();
    if (!stream) {
      stream.close();
      std::error_code ignored;
      fs::remove(partial, ignored);
      fail(file);
    }
  }
  std::error_code error;
  fs::rename(partial, file, error);
  if (error) throw std::runtime_error("cannot write " + file.string() + ": " + error.message());
}

// Shortest text that reads back as the same number; no locale.
template <class Number>
void put_number(std::string& text, Number number) {
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  text.append(digits, end);
}

void flush(std::ostream& stream, std::string& buffer, std::size_t limit) {
  if (buffer.size() < limit) return;
  stream.write(buffer.data(), static_cast<std::streamsize>(buffer.size()));
  buffer.clear();
}

constexpr std::size_t kBuffer = 1 << 20;

template <class Value>
void put_bytes(std::string& buffer, Value value) {
  buffer.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::uint8_t to_byte(float unit) {
  return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(unit, 0.0F, 1.0F)));
}

std::size_t num_vertices(const Scene& scene) {
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) count += scene.meshes[instance.mesh].vertices_m.size();
  return count;
}

void write_ply(const Scene& scene, std::ostream& stream) {
  const std::size_t vertices = num_vertices(scene);
  if (vertices > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::runtime_error("PLY indices hold at most 2147483647 vertices, the world has " + std::to_string(vertices));
  }
  stream << "ply\nformat binary_little_endian 1.0\ncomment world frame: x east, y north, z up; meters\n"
         << "element vertex " << vertices << "\nproperty float x\nproperty float y\nproperty float z\n"
         << "property uchar red\nproperty uchar green\nproperty uchar blue\n"
         << "property ushort class\nproperty ushort instance\nproperty float reflectivity\nproperty uchar "
            "retroreflective\n"
         << "element face " << scene.num_triangles() << "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string buffer;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Material& material = scene.materials[mesh.material];
    for (const Eigen::Vector3f& vertex : mesh.vertices_m) {
      const Eigen::Vector3f p = instance.T_world_mesh * vertex;
      for (int axis = 0; axis < 3; ++axis) put_bytes(buffer, p[axis]);
      for (int channel = 0; channel < 3; ++channel) put_bytes(buffer, to_byte(material.color_rgb[channel]));
      put_bytes(buffer, static_cast<std::uint16_t>(mesh.surface_class));
      put_bytes(buffer, instance.instance);
      put_bytes(buffer, material.reflectivity);
      put_bytes(buffer, static_cast<std::uint8_t>(material.retroreflective));
      flush(stream, buffer, kBuffer);
    }
  }
  std::int32_t first = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const auto& triangle : mesh.triangles) {
      put_bytes(buffer, std::uint8_t{3});
      for (const std::uint32_t corner : triangle) put_bytes(buffer, static_cast<std::int32_t>(first + corner));
      flush(stream, buffer, kBuffer);
    }
    first += static_cast<std::int32_t>(mesh.vertices_m.size());
  }
  flush(stream, buffer, 0);
}

void write_mtl(const Scene& scene, std::ostream& stream) {
  std::string buffer;
  for (const Material& material : scene.materials) {
    buffer += "newmtl " + material.name + "\n# reflectivity ";
    put_number(buffer, material.reflectivity);
    buffer += material.retroreflective ? " retroreflective\nKd" : "\nKd";
    for (int channel = 0; channel < 3; ++channel) {
      buffer += ' ';
      put_number(buffer, material.color_rgb[channel]);
    }
    buffer += "\nillum 1\n\n";
  }
  stream << buffer;
}

void write_obj(const Scene& scene, const std::string& mtl_name, std::ostream& stream) {
  std::string buffer = "# world frame: x east, y north, z up; meters\nmtllib " + mtl_name + "\n";
  std::size_t first = 1;  // OBJ counts from 1
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[instance.mesh];
    buffer += std::string("o ") + name_of(mesh.surface_class) + "_" + std::to_string(instance.instance) + "_" +
              std::to_string(i) + "\nusemtl " + scene.materials[mesh.material].name + "\n";
    for (const Eigen::Vector3f& vertex : mesh.vertices_m) {
      const Eigen::Vector3f p = instance.T_world_mesh * vertex;
      buffer += 'v';
      for (int axis = 0; axis < 3; ++axis) {
        buffer += ' ';
        put_number(buffer, p[axis]);
      }
      buffer += '\n';
      flush(stream, buffer, kBuffer);
    }
    for (const auto& triangle : mesh.triangles) {
      buffer += 'f';
      for (const std::uint32_t corner : triangle) {
        buffer += ' ';
        put_number(buffer, first + corner);
      }
      buffer += '\n';
      flush(stream, buffer, kBuffer);
    }
    first += mesh.vertices_m.size();
  }
  flush(stream, buffer, 0);
}

// One row an object; a column for each attribute that any of them has, in the order of first appearance.
void write_objects(const Scene& scene, std::ostream& stream) {
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
    for (const double value : {object.position_m.x(), object.position_m.y(), object.position_m.z(), object.yaw_rad}) {
      buffer += ',';
      put_number(buffer, value);
    }
    for (const std::string& key : keys) {
      buffer += ',';
      for (const auto& [name, value] : object.attributes) {
        if (name == key) put_number(buffer, value);
      }
    }
    buffer += '\n';
    flush(stream, buffer, kBuffer);
  }
  flush(stream, buffer, 0);
}

}  // namespace

std::vector<fs::path> export_world(const Scene& scene, const fs::path& out) {
  const std::string extension = out.extension().string();
  std::vector<fs::path> written;
  if (extension == ".ply") {
    write_file(out, [&](std::ostream& stream) { write_ply(scene, stream); });
  } else if (extension == ".obj") {
    const fs::path mtl = fs::path(out).replace_extension(".mtl");
    write_file(mtl, [&](std::ostream& stream) { write_mtl(scene, stream); });
    write_file(out, [&](std::ostream& stream) { write_obj(scene, mtl.filename().string(), stream); });
    written.push_back(mtl);
  } else {
    throw InputError("world export: expected a file named .ply or .obj, found '" + out.string() + "'");
  }
  written.insert(written.begin(), out);
  const fs::path table = fs::path(out).replace_extension(".objects.csv");
  write_file(table, [&](std::ostream& stream) { write_objects(scene, stream); });
  written.push_back(table);
  return written;
}

}  // namespace swiftlet::sim
