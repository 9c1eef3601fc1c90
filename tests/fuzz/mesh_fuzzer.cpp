// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of the import of meshes: the first byte selects the format, the rest is the file.
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/world/mesh_import.hpp"
#include "tests/fuzz/support.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  const char* const names[] = {"mesh.obj", "mesh.ply", "mesh.stl"};
  sim::MeshImportConfig config;
  config.file = folder.write(names[data[0] % 3], fuzz::text_of({data + 1, size - 1})).string();
  try {
    const sim::Scene scene = sim::make_mesh_import(config, 1);
    for (const sim::Mesh& mesh : scene.meshes) {
      for (const auto& triangle : mesh.triangles) {
        for (const auto corner : triangle) {
          if (corner >= mesh.vertices_mesh_m.size()) std::abort();
        }
      }
    }
  } catch (const sim::InputError& problem) {
    fuzz::require_message(problem);
  }
  return 0;
}
