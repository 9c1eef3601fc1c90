// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target of the report of a run: the first byte selects the damaged file of a finished run, the rest is its
// content.
#include <iterator>
#include <stdexcept>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/report/run_report.hpp"
#include "tests/fuzz/support.hpp"

namespace {

constexpr const char* kSummary = R"({"scenario": "hover", "seed": 1, "outcome": "done"})";
constexpr const char* kPath = "# t_s x_m y_m z_m qx qy qz qw\n1 0 0 5 0 0 0 1\n2 3 0 5 0 0 0 1\n";

struct File {
  const char* run;
  const char* name;
  const char* content;
};

/// Each run has only the recorders that are read: states replace trajectories, and figures take most of the time.
constexpr File kFiles[] = {{"written", "summary.json", kSummary},
                           {"written", "scenario.yaml", "duration_s: 1\n"},
                           {"states", "csv/uav1/state.csv", "t_s,x_m,y_m,z_m\n1,0,0,5\n"},
                           {"paths", "trajectories/uav1.tum", kPath},
                           {"written", "events.jsonl", ""},
                           {"paths", "trajectories/uav1.estimate.tum", kPath}};

/// Finished runs, in memory.
class Runs {
 public:
  Runs() {
    for (const char* run : {"written", "states", "paths"}) folder_.write(std::string(run) + "/summary.json", kSummary);
    for (const File& file : kFiles) write(file, file.content);
  }
  std::filesystem::path damaged(std::size_t which, std::string_view content) {
    if (last_ != which) write(kFiles[last_], kFiles[last_].content);
    last_ = which;
    write(kFiles[which], content);
    return folder_.path() / kFiles[which].run;
  }

 private:
  void write(const File& file, std::string_view content) const {
    folder_.write(std::string(file.run) + "/" + file.name, content);
  }

  swiftlet::fuzz::Folder folder_;
  std::size_t last_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swiftlet;
  static Runs runs;
  if (size == 0) return 0;
  try {
    (void)sim::write_run_report(runs.damaged(data[0] % std::size(kFiles), fuzz::text_of({data + 1, size - 1})));
  } catch (const std::runtime_error& problem) {
    fuzz::require_message(problem);
  }
  return 0;
}
