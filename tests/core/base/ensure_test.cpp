// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/ensure.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace swiftlet {
namespace {

enum class Color { kRed, kBlue };

template <class Act>
std::string message_of(Act act) {
  try {
    act();
  } catch (const ContractViolation& violation) {
    return violation.what();
  }
  return "nothing was thrown";
}

TEST(Ensure, AConditionThatHoldsDoesNothing) {
  EXPECT_NO_THROW(ENSURE(1 + 1 == 2));
  EXPECT_NO_THROW(ENSURE(true, 1, 2));
}

TEST(Ensure, ReportsPlaceExpressionAndNamedValues) {
  const std::size_t index = 7;
  const std::vector<int> list = {1, 2, 3};
  const int line = __LINE__ + 1;
  const std::string message = message_of([&] { ENSURE(index < list.size(), index, list.size()); });
  EXPECT_EQ(message, "tests/core/base/ensure_test.cpp:" + std::to_string(line) +
                         ": ENSURE(index < list.size()): index = 7, list.size() = 3");
}

TEST(Ensure, ReportsTheExpressionWithoutValues) {
  EXPECT_TRUE(message_of([] { ENSURE(2 < 1); }).ends_with(": ENSURE(2 < 1)"));
}

TEST(Ensure, ReportsValuesOfEveryKind) {
  const std::string name = "uav1";
  const Eigen::Vector3d p_world_m(1.0, -0.5, std::numeric_limits<double>::quiet_NaN());
  const std::string message =
      message_of([&] { ENSURE(false, name, p_world_m, Color::kBlue, 0.1, -3, true, std::max(2, 5)); });
  EXPECT_TRUE(
      message.ends_with("name = \"uav1\", p_world_m = (1, -0.5, nan), Color::kBlue = 1, 0.1 = 0.1, -3 = -3, "
                        "true = true, std::max(2, 5) = 5"))
      << message;
}

TEST(Ensure, ValuesAreEvaluatedOnFailureOnly) {
  int evaluated = 0;
  const auto value = [&] { return ++evaluated; };
  ENSURE(true, value());
  EXPECT_EQ(evaluated, 0);
  EXPECT_THROW(ENSURE(false, value()), ContractViolation);
  EXPECT_EQ(evaluated, 1);
}

}  // namespace
}  // namespace swiftlet
