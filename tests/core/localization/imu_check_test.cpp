// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/imu_check.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace swiftlet {
namespace {

std::string check(const Vector3& specific_force, const Vector3& omega, std::size_t count = kImuCheckSamples) {
  return check_imu(std::vector<ImuSample>(count, ImuSample{0, omega, specific_force}));
}

TEST(ImuCheck, AcceptsRestAndFlight) {
  EXPECT_EQ(check({0.1, -0.2, 9.8}, {0.0, 0.0, 0.01}), "");
  EXPECT_EQ(check({6.0, 0.0, 25.0}, {5.0, 0.0, 3.0}), "");
  EXPECT_EQ(check(Vector3::Zero(), Vector3::Zero()), "") << "free fall";
}

TEST(ImuCheck, NamesUnitsAndSign) {
  EXPECT_NE(check({0.02, 0.0, 1.0}, Vector3::Zero()).find("if it is in g"), std::string::npos);
  EXPECT_NE(check({0.0, 0.0, 9.8}, {0.0, 60.0, 0.0}).find("deg/s"), std::string::npos);
  EXPECT_NE(check({0.0, 0.3, -9.8}, Vector3::Zero()).find("negate"), std::string::npos);
}

TEST(ImuCheck, WaitsForEnoughSamples) { EXPECT_EQ(check({0.0, 0.0, -9.8}, Vector3::Zero(), kImuCheckSamples - 1), ""); }

}  // namespace
}  // namespace swiftlet
