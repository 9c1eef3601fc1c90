// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace swiftlet {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

struct KettleConfig : ModuleConfigOf<KettleConfig> {
  double volume_l = 1.7;
  void visit(ConfigVisitor& v) override { v.field("volume_l", volume_l, "[l] when full"); }
};

const ModuleType kTypes[] = {{"kettle", "boils water", make_module_config<KettleConfig>}};

TEST(Module, TakesTheDefaultsOfItsType) {
  Module module(kTypes, "kettle");
  EXPECT_EQ(module.type, "kettle");
  EXPECT_EQ(module.as<KettleConfig>().volume_l, 1.7);
}

TEST(Module, ACopyIsOfItsOwn) {
  Module module(kTypes, "kettle");
  Module copy = module;
  copy.as<KettleConfig>().volume_l = 0.5;
  EXPECT_EQ(module.as<KettleConfig>().volume_l, 1.7);
}

TEST(Module, ReportsUnknownNames) {
  EXPECT_THAT([] { Module(kTypes, "ketle"); }, ThrowsMessage<std::invalid_argument>(HasSubstr("'ketle'")));
}

}  // namespace
}  // namespace swiftlet
