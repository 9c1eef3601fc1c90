// SPDX-License-Identifier: BSD-3-Clause
// The vehicles that come with Swiftlet against the published figures of their simulators.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "swiftlet/sim/scenario/scenario.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

struct Published {
  const char* model;
  int rotors;
  double mass_kg;
  double arm_m;
  double max_thrust_N;  ///< all rotors at full speed
  double max_rpm;
};
// ctu-mrs/mrs_multirotor_simulator config/uavs/*.yaml; larics/ardupilot_gazebo for the Kopterworx.
constexpr Published kPublished[] = {
    {"t650", 4, 3.5, 0.325, 99.8, 5832}, {"f330", 4, 1.4, 0.165, 35.6, 9722}, {"f450", 4, 1.7, 0.225, 40.2, 9068},
    {"f550", 6, 2.3, 0.27, 60.3, 9068},  {"x500", 4, 2.0, 0.25, 65.9, 7800},  {"kopterworx", 4, 9.0, 0.52, 434.0, 6369},
};

Airframe airframe_of(const std::string& model) {
  const TemporaryDirectory folder;
  const std::filesystem::path file = folder.path() / (model + "_alone.yaml");
  std::ofstream(file) << "vehicles:\n  - model: " << model << "\n";
  return load_scenario(file).vehicles.at(0).airframe;
}

TEST(VehicleAssets, MatchPublishedMassesSizesAndThrusts) {
  for (const Published& published : kPublished) {
    SCOPED_TRACE(published.model);
    const Airframe airframe = airframe_of(published.model);
    EXPECT_EQ(airframe.num_rotors(), published.rotors);
    EXPECT_DOUBLE_EQ(airframe.mass_kg, published.mass_kg);
    EXPECT_DOUBLE_EQ(airframe.arm_length_m, published.arm_m);
    EXPECT_NEAR(airframe.max_thrust_N(), published.max_thrust_N, 0.5);
    EXPECT_NEAR(airframe.rotor_speed_max_radps * 30.0 / M_PI, published.max_rpm, 1.0);
  }
}

TEST(VehicleAssets, AreBalanced) {
  for (const Published& published : kPublished) {
    SCOPED_TRACE(published.model);
    const Airframe airframe = airframe_of(published.model);
    // Equal rotors at equal speed: no torque about any axis; hubs at the arm's length; discs clear of each other.
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    double spin = 0.0;
    for (const Rotor& rotor : airframe.rotors) {
      moment += rotor.position_m;
      spin += rotor.direction();
      EXPECT_NEAR(rotor.position_m.head<2>().norm(), airframe.arm_length_m, 1e-4);
      for (const Rotor& other : airframe.rotors) {
        if (&other == &rotor) continue;
        EXPECT_GT((other.position_m - rotor.position_m).norm(), 2.0 * airframe.propeller_radius_m);
      }
    }
    EXPECT_NEAR(moment.head<2>().norm(), 0.0, 1e-9);
    EXPECT_EQ(spin, 0.0);
    EXPECT_LT(airframe.hover_rotor_speed_radps(), 0.8 * airframe.rotor_speed_max_radps);
    EXPECT_GT(airframe.hover_rotor_speed_radps(), airframe.rotor_speed_min_radps);
  }
}

TEST(VehicleAssets, DeriveUnpublishedInertiaFromCylinders) {
  for (const char* model : {"t650", "f330", "f450", "f550", "x500"}) {
    SCOPED_TRACE(model);
    const Airframe a = airframe_of(model);
    const double L = a.arm_length_m;
    const double h = a.body_height_m;
    EXPECT_NEAR(a.inertia_diagonal_kgm2.x() / (a.mass_kg * (3 * L * L + h * h) / 12), 1.0, 1e-5);
    EXPECT_NEAR(a.inertia_diagonal_kgm2.z() / (a.mass_kg * L * L / 2), 1.0, 1e-5);
  }
}

}  // namespace
}  // namespace swiftlet::sim
