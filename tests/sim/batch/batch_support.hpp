// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "swiftlet/sim/batch/batch_plan.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {

/// A scenario of a fifth of a second and a folder for batch files beside it.
class BatchFolder {
 public:
  BatchFolder() {
    write("hover.yaml",
          "name: hover\nduration_s: 0.2\nworld: {type: empty}\nwind: {mean_mps: [1, 0, 0], gusts: true}\n"
          "vehicles:\n  - {name: a, start: {position_m: [0, 0, 5]}, agent: {localization: {type: ground_truth}}}\n"
          "  - {name: b, start: {position_m: [5, 0, 5]}, agent: {localization: {type: ground_truth}}}\n"
          "recorders: [{type: tum}]\n");
  }

  std::filesystem::path path(const std::string& name = "") const { return folder_.path() / name; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  BatchPlan plan(const std::string& text, const std::string& name = "batch.yaml") const {
    write(name, "name: test\nscenario: hover\n" + text);
    return BatchPlan(path(name));
  }

 private:
  TemporaryDirectory folder_;
};

}  // namespace swiftlet::sim
