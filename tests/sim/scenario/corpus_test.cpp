// SPDX-License-Identifier: BSD-3-Clause
// The corpus of the fuzz target, replayed in every build, through the whole scenario as well.
#include <gtest/gtest.h>

#include <filesystem>

#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace swiftlet::sim {
namespace {

std::vector<std::filesystem::path> corpus() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(SWIFTLET_SOURCE_DIR "/tests/fuzz/corpus/scenario")) {
    files.push_back(entry.path());
  }
  return files;
}

TEST(Corpus, EveryInputGivesConfigurationOrMessage) {
  const auto files = corpus();
  ASSERT_GE(files.size(), 30u);
  for (const std::filesystem::path& path : files) {
    SCOPED_TRACE(path.string());
    const std::string text = read_whole_file(path);
    // Aborts on anything but a clean result.
    EXPECT_EQ(LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()), 0);
  }
}

TEST(Corpus, EveryInputGivesScenarioOrMessage) {
  for (const std::filesystem::path& path : corpus()) {
    SCOPED_TRACE(path.string());
    try {
      (void)write_scenario(load_scenario(path));
    } catch (const InputError& problem) {
      EXPECT_NE(std::string(problem.what()).find("expected"), std::string::npos) << problem.what();
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
