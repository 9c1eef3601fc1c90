// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of the report of a run: the first byte tells which file of a finished run is damaged, the rest is that
// file.
#include <iterator>
#include <stdexcept>
#include <vector>

#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/report/run_report.hpp"
#include "tests/fuzz/support.hpp"

namespace {

constexpr const char* kNames[] = {"summary.json",          "scenario.yaml", "csv/uav1/state.csv",
                                  "trajectories/uav1.tum", "events.jsonl",  "trajectories/uav1.estimate.tum"};

/// A finished run, in memory.
class Run {
 public:
  Run() {
    std::filesystem::copy(SWIFTLET_SOURCE_DIR "/tests/fuzz/run", folder_.path(),
                          std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
    for (const char* name : kNames) {
      std::ifstream in(folder_.path() / name, std::ios::binary);
      contents_.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
  }
  const std::filesystem::path& damaged(std::size_t which, std::string_view content) {
    folder_.write(kNames[last_], contents_[last_]);
    last_ = which % std::size(kNames);
    folder_.write(kNames[last_], content);
    return folder_.path();
  }

 private:
  swiftlet::fuzz::Folder folder_;
  std::vector<std::string> contents_;
  std::size_t last_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static Run run;
  if (size == 0) return 0;
  try {
    (void)sim::write_run_report(run.damaged(data[0], fuzz::text_of({data + 1, size - 1})));
  } catch (const std::runtime_error& problem) {
    fuzz::require_message(problem);
  }
  return 0;
}
