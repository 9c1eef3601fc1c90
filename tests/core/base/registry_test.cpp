// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/registry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace swiftlet {
namespace {

struct Nothing : ModuleConfigOf<Nothing> {
  void visit(ConfigVisitor&) override {}
};

struct Row {
  ModuleType module;
  int (*make)();
};

constexpr Row kRows[] = {{{"one", "the first", make_module_config<Nothing>}, [] { return 1; }},
                         {{"two", "the second", make_module_config<Nothing>}, [] { return 2; }}};
constexpr Row kThree = {{"three", "a program's own", make_module_config<Nothing>}, [] { return 3; }};

TEST(Registry, RowsOfAProgramComeAfterThoseOfSwiftlet) {
  Registry<Row> registry("number", kRows);
  registry.add(kThree);
  EXPECT_EQ(registry.named("two").make(), 2);
  EXPECT_EQ(registry.named("three").make(), 3);
  ASSERT_EQ(registry.modules().size(), 3U);
  EXPECT_STREQ(registry.modules()[0].name, "one");
  EXPECT_EQ(Module(registry.modules(), "three").type, "three");
}

TEST(Registry, ANameThatIsTakenIsRefused) {
  Registry<Row> registry("number", kRows);
  registry.add(kThree);
  try {
    registry.add(kThree);
    FAIL();
  } catch (const std::invalid_argument& refused) {
    EXPECT_STREQ(refused.what(), "there is a number named 'three' already");
  }
}

TEST(Registry, ANameThatNobodyHasIsToldWithItsKind) {
  const Registry<Row> registry("number", kRows);
  try {
    registry.named("four");
    FAIL();
  } catch (const std::invalid_argument& refused) {
    EXPECT_STREQ(refused.what(), "no number is named 'four'");
  }
}

}  // namespace
}  // namespace swiftlet
