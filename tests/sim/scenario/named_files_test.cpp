// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/named_files.hpp"

#include <gtest/gtest.h>

#include "swiftlet/sim/scenario/loader.hpp"

namespace swiftlet::sim {
namespace {

TEST(NamedFiles, AreToldWithTheirKeys) {
  const Scenario scenario = load_scenario("import_mesh");
  const auto files = named_files(scenario);
  ASSERT_EQ(files.size(), 1U);
  EXPECT_EQ(files[0].key, "world.file");
  EXPECT_TRUE(files[0].path.ends_with(".obj") || files[0].path.ends_with(".ply") || files[0].path.ends_with(".stl"));
}

TEST(NamedFiles, NoneWhereNoneIsNamed) { EXPECT_TRUE(named_files(load_scenario("square")).empty()); }

}  // namespace
}  // namespace swiftlet::sim
