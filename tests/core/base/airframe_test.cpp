// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/airframe.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace swiftlet {
namespace {

Airframe cross() {
  Airframe airframe;
  airframe.rotors.resize(4);
  airframe.rotors[0].position_m = {0.3, 0.4, 0.05};  // 0.5 m from the axis
  airframe.rotors[1].position_m = {-0.1, 0.1, 0.0};
  airframe.propeller_radius_m = 0.1;
  airframe.body_radius_m = 0.1;
  airframe.body_height_m = 0.1;
  airframe.leg_height_m = 0.1;
  return airframe;
}

TEST(Airframe, BoundingSphereReachesFarthestPropellerTip) {
  EXPECT_DOUBLE_EQ(cross().circumscribed_radius_m(), std::hypot(0.5 + 0.1, 0.05));
}

TEST(Airframe, BoundingSphereEnclosesTheSkids) {
  Airframe airframe = cross();
  airframe.body_radius_m = 0.6;
  airframe.leg_height_m = 0.5;
  EXPECT_DOUBLE_EQ(airframe.circumscribed_radius_m(), std::hypot(2.0 * 0.6, 0.5));
}

TEST(Airframe, RotorsCarryItsWeightInHover) {
  const Airframe airframe = cross();
  const double speed_radps = airframe.hover_rotor_speed_radps(9.81);
  EXPECT_NEAR(4.0 * airframe.thrust_constant_N_per_radps2 * speed_radps * speed_radps, airframe.mass_kg * 9.81, 1e-9);
}

}  // namespace
}  // namespace swiftlet
