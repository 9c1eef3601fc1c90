// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/reference.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/scenario/retired_keys.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "tests/sim/scenario/example_config.hpp"
#include "tests/support/numeric_bounds.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;

TEST(Reference, ShowsAllAttributesOfEachKey) {
  FleetConfig fleet;
  const std::string text = reference_tables([&](ConfigVisitor& v) { fleet.visit(v); }, "Fleet");
  EXPECT_THAT(
      text,
      HasSubstr("| `boats[].noise.drop_probability` | number | `0` |  | 0 to 1 | chance that a return is lost |"));
  EXPECT_THAT(text, HasSubstr("| `boats[].speed_mps` | number | `1` | m/s | > -10, < 10 | cruise |"));
  EXPECT_THAT(text, HasSubstr("| `sky` | choice | `clear` |  | `clear`, `cloudy`, `overcast` | weather |"));
  EXPECT_THAT(text, HasSubstr("| `size_m` | 2 numbers | `[10, 20]` | m | > 0 | of the water |"));
  // Modules have sections of their own, nested ones too, each registry once.
  EXPECT_THAT(text, HasSubstr("## `boats[].crew`"));
  EXPECT_THAT(text, HasSubstr("### `type: pilot`"));
  EXPECT_THAT(text, HasSubstr("| `reaction_s` | number | `0.3` | s | >= 0 | until something is done |"));
  EXPECT_EQ(text.find("### `type: engine`"), text.rfind("### `type: engine`"));
  // One of the two boats is enough.
  EXPECT_EQ(text.find("`boats[].tilt_deg`"), text.rfind("`boats[].tilt_deg`"));
}

TEST(Reference, NamesEveryModuleOfEveryRegistry) {
  const std::string text = write_reference();
  for (const auto types :
       {world_module_types(), sensor_module_types(), recorder_module_types(), agent_module_types()}) {
    for (const ModuleType& type : types) EXPECT_THAT(text, HasSubstr("### `type: " + std::string(type.name) + "`"));
  }
}

TEST(Reference, AcceptsNumericKeysOnlyWithinBounds) {
  std::size_t num_keys = 0;
  const auto visit = [](ConfigVisitor& v) {
    Scenario fresh;
    fresh.visit(v);
  };
  EXPECT_THAT(testing::wrong_bounds(visit, num_keys), ::testing::IsEmpty());
  EXPECT_GT(num_keys, 700U);
}

// A resolved scenario holds every default, and must fly again.
TEST(Reference, EveryDefaultCanBeRead) {
  const std::string text = write_reference();
  for (const char* unreadable : {".inf`", ".nan`"}) EXPECT_THAT(text, Not(HasSubstr(unreadable)));
}

TEST(Reference, RetiredKeysNameTheirReplacement) {
  const std::string reference = write_reference();
  const auto is_key = [&](std::string_view key) {
    for (const char* before : {"| `", "."}) {
      for (const char* after : {"`", "."}) {
        if (reference.find(std::string(before).append(key).append(after)) != std::string::npos) return true;
      }
    }
    return false;
  };
  for (const RetiredKey& retired : kRetiredKeys) {
    EXPECT_TRUE(is_key(retired.replacement)) << retired.replacement;
    EXPECT_FALSE(is_key(retired.key)) << retired.key;
    Scenario scenario;
    const Overrides old = {{"vehicles[0].agent.localization." + std::string(retired.key), "{}"}};
    try {
      read_config_text(
          "vehicles: [{agent: {localization: {type: slam}}}]", "old.yaml", [&](ConfigVisitor& v) { scenario.visit(v); },
          old);
      ADD_FAILURE() << retired.key << " is accepted";
    } catch (const InputError& problem) {
      EXPECT_THAT(problem.what(), HasSubstr("replaced by \"" + std::string(retired.replacement) + "\""));
    }
  }
}

TEST(Reference, TheDocumentIsUpToDate) {
  const std::string document = read_whole_file(SWIFTLET_SOURCE_DIR "/docs/reference.md");
  EXPECT_TRUE(document == write_reference()) << "docs/reference.md is stale: a key or its documentation has changed.\n"
                                                "Regenerate it: build/release/swiftlet reference > docs/reference.md";
}

}  // namespace
}  // namespace swiftlet::sim
