// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of the reader of OctoMap's octrees: the first byte selects the format, the rest is the file.
#include <cmath>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/octomap/octomap_file.hpp"
#include "tests/fuzz/support.hpp"

namespace {

constexpr double kMaxBytes = 1e5;  // one leaf near the root stands for 2^48 cells

void refuse_large(double bytes) {
  if (bytes > kMaxBytes) throw swiftlet::sim::InputError("octree: too large");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  const char* const name = data[0] % 2 == 0 ? "tree.ot" : "tree.bt";
  try {
    const sim::OctomapCells cells =
        sim::read_octomap(folder.write(name, fuzz::text_of({data + 1, size - 1})), refuse_large);
    for (const auto* centers_m : {&cells.occupied_m, &cells.free_m}) {
      for (const auto& p_m : *centers_m) {
        if (p_m.array().isNaN().any()) std::abort();
      }
    }
  } catch (const sim::InputError& problem) {
    fuzz::require_message(problem);
  }
  return 0;
}
