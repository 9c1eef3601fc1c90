// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/registry.hpp"

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

TEST(Registry, ListsProgramRowsAfterSwiftletRows) {
  Registry<Row> registry("number", kRows);
  registry.add(kThree);
  EXPECT_EQ(registry.named("two").make(), 2);
  EXPECT_EQ(registry.named("three").make(), 3);
  ASSERT_EQ(registry.modules().size(), 3U);
  EXPECT_STREQ(registry.modules()[0].name, "one");
  EXPECT_EQ(Module(registry.modules(), "three").type, "three");
}

TEST(Registry, RefusesTakenNames) {
  Registry<Row> registry("number", kRows);
  registry.add(kThree);
  try {
    registry.add(kThree);
    FAIL();
  } catch (const std::invalid_argument& refused) {
    EXPECT_STREQ(refused.what(), "there is a number named 'three' already");
  }
}

TEST(Registry, RefusesIncompleteRows) {
  Registry<Row> registry("number", kRows);
  const auto refusal = [&](const Row& row) -> std::string {
    try {
      registry.add(row);
    } catch (const std::invalid_argument& refused) {
      return refused.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({{nullptr, "a note", make_module_config<Nothing>}, kThree.make}), "a number has no name");
  EXPECT_EQ(refusal({{"four", nullptr, make_module_config<Nothing>}, kThree.make}),
            "the number 'four' has no description");
  EXPECT_EQ(refusal({{"four", "a note", nullptr}, kThree.make}), "the number 'four' has no maker");
  EXPECT_EQ(refusal({{"four", "a note", make_module_config<Nothing>}, nullptr}), "the number 'four' has no maker");
  EXPECT_EQ(registry.rows().size(), 2U);
  registry.add({{"four", "a note", []() -> std::unique_ptr<ModuleConfig> { return nullptr; }}, kThree.make});
  EXPECT_THROW(Module(registry.modules(), "four"), std::invalid_argument);
}

struct Made {
  int number = 0;
};
struct MadeRow {
  ModuleType module;
  std::unique_ptr<Made> (*make)(const ModuleConfig&, int);
};
using Maker = decltype(MadeRow::make);

std::string made_by(const char* name, Maker maker) {
  Registry<MadeRow> registry("thing", {});
  registry.add({{name, "a note", make_module_config<Nothing>}, maker});
  try {
    const auto made = registry.make(Module(registry.modules(), name), 7);
    return made == nullptr ? "nothing" : std::to_string(made->number);
  } catch (const std::exception& problem) {
    return problem.what();
  }
}

TEST(Registry, AMakerThatFailsIsNamed) {
  EXPECT_EQ(made_by("own", [](const ModuleConfig&, int n) { return std::make_unique<Made>(Made{n}); }), "7");
  const Maker nothing = [](const ModuleConfig&, int) -> std::unique_ptr<Made> { return nullptr; };
  EXPECT_EQ(made_by("own", nothing), "the maker of the thing 'own' returned nothing");
  EXPECT_EQ(made_by("none", nothing), "nothing") << "a stage that is left out";
  EXPECT_EQ(made_by("own", [](const ModuleConfig&, int) -> std::unique_ptr<Made> { throw 42; }),
            "the maker of the thing 'own' threw something that is no std::exception");
  EXPECT_EQ(made_by("own", [](const ModuleConfig&, int) -> std::unique_ptr<Made> { throw std::runtime_error("so"); }),
            "so");
}

TEST(Registry, ReportsUnknownNamesWithTheirKind) {
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
