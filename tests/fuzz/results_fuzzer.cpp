// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of a batch's database of results: any bytes must end in rows or in a message.
#include <stdexcept>

#include "swiftlet/sim/batch/result_store.hpp"
#include "tests/fuzz/support.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static const fuzz::Folder folder;
  const auto file = folder.write("results.sqlite", fuzz::text_of({data, size}));
  try {
    const sim::ResultStore store(file, sim::ResultStore::Mode::kRead);
    (void)store.info();
    (void)store.count_by_status();
    (void)store.dump();
    (void)store.episodes(true);
  } catch (const std::runtime_error& problem) {
    fuzz::require_message(problem);
  }
  return 0;
}
