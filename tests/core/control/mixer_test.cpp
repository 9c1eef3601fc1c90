// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/mixer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/core/math/random.hpp"
#include "tests/support/airframes.hpp"

namespace swiftlet {
namespace {

using testing::all_airframes;

TEST(Mixer, ReproducesEveryFeasibleWrench) {
  for (const int n : {4, 6, 8}) {
    const Airframe airframe = testing::ring_of_rotors(n);
    const Mixer mixer(airframe);
    const Random random(n, "test.mixer");
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const double thrust = 0.4 * airframe.max_thrust_N();
      const Wrench wanted{thrust, 0.05 * thrust *
                                      Vector3(random.uniform(-1, 1, i, 0), random.uniform(-1, 1, i, 1),
                                              0.05 * random.uniform(-1, 1, i, 2))};
      const Wrench got = mixer.wrench(mixer.forces(wanted));
      ASSERT_NEAR(got.thrust_N, wanted.thrust_N, 1e-9);
      ASSERT_LT((got.torque_body_Nm - wanted.torque_body_Nm).norm(), 1e-9);
    }
  }
}

TEST(Mixer, ClosedFormOfTheQuadX) {
  // One newton meter of roll on arms of d = L / sqrt(2): each rotor 1 / (4 d), more on the left.
  const Airframe airframe = testing::x500();
  const Mixer mixer(airframe);
  const double thrust = 0.5 * airframe.max_thrust_N();
  const auto f = mixer.forces({thrust, {1.0, 0.0, 0.0}});
  const double d = 0.25 * std::sqrt(0.5);
  EXPECT_NEAR(f[0], thrust / 4 - 1 / (4 * d), 1e-9);  // front right
  EXPECT_NEAR(f[1], thrust / 4 + 1 / (4 * d), 1e-9);  // rear left
  EXPECT_NEAR(f[2], thrust / 4 + 1 / (4 * d), 1e-9);  // front left
  EXPECT_NEAR(f[3], thrust / 4 - 1 / (4 * d), 1e-9);  // rear right
  // Turning left (positive yaw) needs more thrust of the clockwise rotors.
  const auto y = mixer.forces({thrust, {0.0, 0.0, 0.1}});
  EXPECT_GT(y[2], y[0]);
  EXPECT_NEAR(y[2] - y[0], 0.1 / (2 * airframe.torque_to_thrust_m), 1e-9);
}

TEST(Mixer, SacrificesYawThenThrustThenTilt) {
  const Airframe airframe = testing::x500();
  const Mixer mixer(airframe);
  const double thrust = 0.5 * airframe.max_thrust_N();

  // Too much yaw: thrust and tilt torques stay.
  Wrench got = mixer.wrench(mixer.forces({thrust, {0.5, -0.4, 5.0}}));
  EXPECT_NEAR(got.thrust_N, thrust, 1e-9);
  EXPECT_NEAR(got.torque_body_Nm.x(), 0.5, 1e-9);
  EXPECT_NEAR(got.torque_body_Nm.y(), -0.4, 1e-9);
  EXPECT_GT(got.torque_body_Nm.z(), 0.05);
  EXPECT_LT(got.torque_body_Nm.z(), 5.0);

  // Zero or full thrust is raised or lowered so that the tilt torques are kept.
  for (const double extreme : {0.0, 1.5 * airframe.max_thrust_N()}) {
    got = mixer.wrench(mixer.forces({extreme, {1.0, 0.6, 0.0}}));
    EXPECT_NEAR(got.torque_body_Nm.x(), 1.0, 1e-9) << extreme;
    EXPECT_NEAR(got.torque_body_Nm.y(), 0.6, 1e-9) << extreme;
  }

  // More tilt torque than the rotors have: its direction stays.
  got = mixer.wrench(mixer.forces({thrust, {40.0, 20.0, 3.0}}));
  EXPECT_GT(got.torque_body_Nm.x(), 3.0);
  EXPECT_NEAR(got.torque_body_Nm.y() / got.torque_body_Nm.x(), 0.5, 1e-9);
}

TEST(Mixer, LimitsThrustRaisedForTilting) {
  for (const auto& [name, airframe] : all_airframes()) {
    const Mixer mixer(airframe);
    const double weight = airframe.mass_kg * 9.81;
    // Excessive torque: the thrust stays at its limit, or at the wanted thrust if that is larger.
    for (const double thrust : {0.0, 0.2 * weight, weight, 1.2 * weight}) {
      const Wrench got = mixer.wrench(mixer.forces({thrust, {30.0, -12.0, 0.0}}, weight));
      EXPECT_NEAR(got.thrust_N, std::max(thrust, weight), 1e-9 * weight) << name << " " << thrust;
      EXPECT_NEAR(got.torque_body_Nm.y() / got.torque_body_Nm.x(), -0.4, 1e-9) << name;
      EXPECT_GT(got.torque_body_Nm.x(), 0.1) << name;
    }
    // Feasible commands are met in full.
    const Vector3 small(0.02 * weight * airframe.arm_length_m, 0.0, 0.0);
    EXPECT_NEAR(mixer.wrench(mixer.forces({weight, small}, weight)).torque_body_Nm.x(), small.x(), 1e-9) << name;
  }
}

TEST(Mixer, KeepsForcesWithinTheRotorRange) {
  for (const auto& [name, airframe] : all_airframes()) {
    const Mixer mixer(airframe);
    const Random random(1, "test.mixer", name);
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const double big = 3 * airframe.max_thrust_N();
      const auto f = mixer.forces(
          {random.uniform(0, big, i, 0),
           Vector3(random.uniform(-big, big, i, 1), random.uniform(-big, big, i, 2), random.uniform(-big, big, i, 3))});
      for (int k = 0; k < 4; ++k) {
        ASSERT_GE(f[k], mixer.min_force_N());
        ASSERT_LE(f[k], mixer.max_force_N());
      }
    }
  }
}

TEST(Mixer, RefusesAirframesThatCannotBeControlled) {
  Airframe airframe;  // no rotors
  EXPECT_THROW(Mixer{airframe}, std::invalid_argument);
  airframe = testing::x500();
  airframe.rotors.pop_back();
  EXPECT_THROW(Mixer{airframe}, std::invalid_argument);
  airframe = testing::x500();
  for (Rotor& rotor : airframe.rotors) rotor.spin = Rotor::Spin::kCw;  // yaw torque only together with thrust
  EXPECT_THROW(Mixer{airframe}, std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
