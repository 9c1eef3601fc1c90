// SPDX-License-Identifier: BSD-3-Clause
// Results that change must change on purpose.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "tests/support/embree_settings.hpp"
#include "tests/support/fnv.hpp"

namespace swiftlet::sim {
namespace {

const std::string kFolder = SWIFTLET_SOURCE_DIR "/tests/golden/";

/// A line of tests/golden/hashes.txt: SCENARIO [KEY=VALUE ...] HASH.
struct GoldenRun {
  std::string scenario;
  std::vector<std::pair<std::string, std::string>> settings;
  std::string hash;
};

std::ostream& operator<<(std::ostream& out, const GoldenRun& run) {
  out << run.scenario;
  for (const auto& [key, value] : run.settings) out << " " << key << "=" << value;
  return out;
}

std::vector<GoldenRun> golden_runs() {
  std::ifstream file(kFolder + "hashes.txt");
  std::vector<GoldenRun> runs;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    GoldenRun run;
    words >> run.scenario;
    for (std::string word; words >> word;) {
      const std::size_t equals = word.find('=');
      if (equals == std::string::npos) {
        run.hash = word;
      } else {
        run.settings.emplace_back(word.substr(0, equals), word.substr(equals + 1));
      }
    }
    runs.push_back(std::move(run));
  }
  return runs;
}

/// Digest of the C library's functions, which affect the results: there are versions for processors with and without
/// FMA.
std::string c_library_here() {
  test::Fnv1a digest;
  for (int i = 1; i <= 4096; ++i) {
    volatile double x = i / 512.0;  // at run time, not by the compiler
    for (const double y : {std::sin(x), std::cos(x), std::atan2(x, 3.0), std::exp(x), std::log(x), std::pow(x, 0.37),
                           std::asin(x / 8.0), std::tan(x), std::cbrt(x), std::hypot(x, 1.7)}) {
      digest.mix(std::bit_cast<std::uint64_t>(y));
    }
  }
  std::ostringstream text;
  text << std::hex << digest.value();
  return text.str();
}

std::string c_library_of_the_file() {
  std::ifstream file(kFolder + "hashes.txt");
  const std::string key = "# c library ";
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(key)) return line.substr(key.size());
  }
  return "";
}

std::string golden_hash_of(const GoldenRun& run) {
  Simulation simulation(load_scenario(kFolder + run.scenario, run.settings));
  while (!simulation.finished()) simulation.tick();
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(simulation.state_hash()));
  return text;
}

class Golden : public testing::TestWithParam<GoldenRun> {};

TEST_P(Golden, MatchesRecordedRunBits) {
  EXPECT_EQ(golden_hash_of(GetParam()), GetParam().hash)
      << GetParam() << ": results differ from those in tests/golden/hashes.txt.\n"
      << (c_library_here() == c_library_of_the_file() ? ""
                                                      : "This C library computes other functions than Debian 12's.\n")
      << "If they were meant to change, write them anew with\n"
      << "  tests/golden/renew build/release/swiftlet\n"
      << "and say in CHANGELOG.md what changed and why. If not, look for what this run has and others have not.";
}

// Embree finds its code by the processor. What it may find elsewhere gives the same bits.
class GoldenInstructionSets : public Golden {};

TEST_P(GoldenInstructionSets, RunHasTheSameBits) {
  const std::string expected = golden_hash_of(GetParam());
  for (const std::string& setting : embree_settings()) {
    ::setenv("SWIFTLET_EMBREE", setting.c_str(), 1);
    EXPECT_EQ(golden_hash_of(GetParam()), expected) << GetParam() << " with " << setting;
    ::unsetenv("SWIFTLET_EMBREE");
  }
}

std::string name_of_run(const testing::TestParamInfo<GoldenRun>& info) {
  std::string name = std::filesystem::path(info.param.scenario).stem();
  if (!info.param.settings.empty()) name += "_" + info.param.settings.front().second;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

/// The runs of the scenarios that come with Swiftlet (`shipped`), or those of small scenarios for this test alone.
std::vector<GoldenRun> golden_runs(bool shipped) {
  std::vector<GoldenRun> runs = golden_runs();
  std::erase_if(runs, [&](const GoldenRun& run) { return run.scenario.starts_with("../../scenarios/") != shipped; });
  return runs;
}

INSTANTIATE_TEST_SUITE_P(Runs, Golden, testing::ValuesIn(golden_runs()), name_of_run);
INSTANTIATE_TEST_SUITE_P(Runs, GoldenInstructionSets, testing::ValuesIn(golden_runs(false)), name_of_run);
INSTANTIATE_TEST_SUITE_P(InFull, GoldenInstructionSets, testing::ValuesIn(golden_runs(true)), name_of_run);

TEST(GoldenFile, KnowsItsCLibrary) {
  std::cout << "c library " << c_library_here() << '\n';  // for tests/golden/renew
  EXPECT_GE(c_library_of_the_file().size(), 12U) << "tests/golden/renew writes it";
}

TEST(GoldenFile, HasEveryTypeOfWorld) {
  std::set<std::string> covered;
  for (const GoldenRun& run : golden_runs()) {
    for (const auto& [key, value] : run.settings) {
      if (key == "world.type") covered.insert(value);
    }
  }
  for (const ModuleType& type : world_module_types()) {
    EXPECT_TRUE(covered.contains(type.name)) << "add a line `world.yaml world.type=" << type.name
                                             << " 0` to tests/golden/hashes.txt and run tests/golden/renew";
  }
}

}  // namespace
}  // namespace swiftlet::sim
