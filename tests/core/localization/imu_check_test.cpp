// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/imu_check.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "swiftlet/core/base/gravity.hpp"

namespace swiftlet {
namespace {

/// Fault after one second of equal samples.
std::string fault_of(const Vector3& specific_force_body_mps2, const Vector3& omega_body_radps = Vector3::Zero()) {
  ImuCheck check;
  for (int i = 0; i < 200; ++i) check.add({i * 5'000'000, omega_body_radps, specific_force_body_mps2});
  return check.fault();
}

TEST(ImuCheck, AcceptsRestAndFlight) {
  EXPECT_EQ(fault_of({0.1, -0.2, 9.8}, {0.0, 0.0, 0.01}), "");
  EXPECT_EQ(fault_of({6.0, 0.0, 20.0}, {5.0, 0.0, 3.0}), "") << "climb";
  EXPECT_EQ(fault_of({0.0, 8.6, 8.4}), "") << "tilted by 45 degrees";
}

TEST(ImuCheck, NamesUnitsAndAxes) {
  EXPECT_NE(fault_of({0.02, 0.0, 1.0}).find("found (0.02, 0, 1); multiply it by 9.80665"), std::string::npos);
  EXPECT_NE(fault_of({0.0, 0.0, 9.8}, {0.0, 60.0, 0.0}).find("found (0, 60, 0)"), std::string::npos);
  for (const Vector3& turned : {Vector3(0.0, 0.3, -9.8), Vector3(9.8, 0.0, 0.0), Vector3(0.0, -9.8, 0.0)})
    EXPECT_NE(fault_of(turned).find("negate it"), std::string::npos) << turned;
}

TEST(ImuCheck, AcceptsSingleErrors) {
  ImuCheck check;
  for (int i = 0; i < 200; ++i) {
    const bool wrong = i % 10 == 0;
    check.add({i * 5'000'000, {0.0, 0.0, wrong ? 100.0 : 1.0}, {0.0, 0.0, wrong ? -kGravity_mps2 : kGravity_mps2}});
    check.add({i * 5'000'000, Vector3::Zero(), {0.0, 0.0, std::numeric_limits<double>::quiet_NaN()}});
  }
  EXPECT_EQ(check.fault(), "");
}

TEST(ImuCheck, KeepsItsFirstFault) {
  ImuCheck check;
  for (int i = 0; i < 200; ++i) check.add({i * 5'000'000, Vector3::Zero(), {0.0, 0.0, i < 100 ? 1.0 : kGravity_mps2}});
  EXPECT_NE(check.fault().find("if it is in g"), std::string::npos);
}

}  // namespace
}  // namespace swiftlet
