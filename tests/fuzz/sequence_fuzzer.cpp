// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of a dataset's sequences: any bytes must end in a description or in a message, and a description that was
// read must survive being written and read again.
#include <stdexcept>

#include "swiftlet/sim/dataset/sequence_info.hpp"
#include "tests/fuzz/support.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static const fuzz::Folder folder;
  folder.write("sequence.json", fuzz::text_of({data, size}));
  std::string written;
  try {
    written = sim::to_json(sim::read_sequence_info(folder.path()));
  } catch (const std::runtime_error& problem) {
    fuzz::require_message(problem);
    return 0;
  }
  folder.write("sequence.json", written);
  if (sim::to_json(sim::read_sequence_info(folder.path())) != written) std::abort();
  return 0;
}
