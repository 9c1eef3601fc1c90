// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of the import of meshes: the first byte tells the format, the rest is the file.
#include <new>

#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/world/mesh_import.hpp"
#include "tests/fuzz/support.hpp"

namespace {

/// The library takes 1 MB for each file, 16 MB for an OBJ file. To get these from the system takes longer than all
/// else, so they are kept for the next input.
struct Buffer {
  std::size_t size = 0;
  void* memory = nullptr;
  bool is_taken = false;
};
Buffer buffers[] = {{std::size_t{1} << 20}, {std::size_t{1} << 24}};

void* allocated(std::size_t size) {
  for (Buffer& buffer : buffers) {
    if (buffer.size != size || buffer.is_taken) continue;
    if (buffer.memory == nullptr) buffer.memory = std::malloc(size);
    buffer.is_taken = buffer.memory != nullptr;
    return buffer.memory;
  }
  return std::malloc(size);
}

}  // namespace

void* operator new(std::size_t size) {
  if (void* const memory = allocated(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocated(size); }
void operator delete(void* memory) noexcept {
  for (Buffer& buffer : buffers) {
    if (memory == nullptr || buffer.memory != memory) continue;
    buffer.is_taken = false;
    return;
  }
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { operator delete(memory); }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  // It clears those 16 MB, too, so only one value of the byte means OBJ.
  const char* const name = data[0] == 1 ? "mesh.obj" : data[0] % 2 == 0 ? "mesh.ply" : "mesh.stl";
  sim::MeshImportConfig config;
  config.file = folder.write(name, fuzz::text_of({data + 1, size - 1})).string();
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
