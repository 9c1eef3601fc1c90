// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of the reader of point clouds: the first byte selects the format, the rest is the file.
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/world/point_cloud_file.hpp"
#include "tests/fuzz/support.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  const char* const name = data[0] % 2 == 0 ? "cloud.pcd" : "cloud.ply";
  try {
    for (const auto& p_m : sim::read_point_cloud(folder.write(name, fuzz::text_of({data + 1, size - 1})))) {
      if (!p_m.allFinite()) std::abort();
    }
  } catch (const sim::InputError& problem) {
    fuzz::require_message(problem);
  }
  return 0;
}
