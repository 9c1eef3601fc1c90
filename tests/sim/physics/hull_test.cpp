// SPDX-License-Identifier: BSD-3-Clause
// Collision shape of a vehicle, probed with a tiny triangle.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "sim/physics/contacts.hpp"
#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

class Probe {
 public:
  explicit Probe(const Airframe& airframe)
      : vehicles_{vehicle_at({0, 0, 0}, airframe)}, contacts_(vehicles_, PhysicsConfig{}) {
    TestScene builder;
    builder.add_mesh({{0, 0, 0}, {2e-4F, 0, 0}, {0, 2e-4F, 0}}, {{0, 1, 2}}, SurfaceClass::kObject, 0, 0);
    scene_ = std::make_unique<StaticScene>(builder.scene());
  }
  bool is_inside(const Vector3& p_body_m) {
    const Vector3 half = Vector3::Constant(3.0);
    contacts_.gather_triangles(0, *scene_, {-half, half});
    return contacts_.overlap(0, -p_body_m, Eigen::Quaterniond::Identity()).depth_m > 0.0;
  }
  double reach_m() const { return contacts_.reach_m(0); }

 private:
  std::vector<PhysicsVehicle> vehicles_;
  Contacts contacts_;
  std::unique_ptr<StaticScene> scene_;
};

TEST(Hull, IsBodyDiscsArmsAndLegs) {
  for (const double scale : {0.7, 1.0}) {
    Airframe airframe = test_quad();
    airframe.body_radius_m = 0.12 * scale;
    airframe.body_height_m = 0.16 * scale;
    airframe.leg_height_m = 0.2 * scale;
    airframe.propeller_radius_m = 0.11 * scale;
    Probe probe(airframe);
    const double r_m = airframe.body_radius_m, h_m = 0.5 * airframe.body_height_m, disc_m = airframe.propeller_radius_m;
    EXPECT_TRUE(probe.is_inside({0, 0, 0}));
    EXPECT_TRUE(probe.is_inside({0.9 * r_m, 0, 0}));
    EXPECT_TRUE(probe.is_inside({0, 0, 0.9 * h_m}));
    EXPECT_FALSE(probe.is_inside({1.1 * r_m, 0, 0})) << "between two arms";
    EXPECT_FALSE(probe.is_inside({0, 0, 1.1 * h_m}));
    for (const Rotor& rotor : airframe.rotors) {
      const Vector3 hub_m = rotor.position_m, out = Vector3(hub_m.x(), hub_m.y(), 0.0).normalized();
      for (const double turn : {0.0, 1.5, 3.0, 4.5}) {
        const Vector3 side = Eigen::AngleAxisd(turn, Vector3::UnitZ()) * out;
        EXPECT_TRUE(probe.is_inside(hub_m + 0.95 * disc_m * side)) << turn;
        EXPECT_FALSE(probe.is_inside(hub_m + 0.95 * disc_m * side + Vector3(0, 0, 0.03))) << turn;
      }
      EXPECT_FALSE(probe.is_inside(hub_m + 1.05 * disc_m * out));
      bool has_arm = false;  // between the body and the disc
      for (double z_m = -0.05; z_m < hub_m.z(); z_m += 0.005) {
        has_arm = has_arm || probe.is_inside({0.53 * hub_m.x(), 0.53 * hub_m.y(), z_m});
      }
      EXPECT_TRUE(has_arm);
      EXPECT_GE(probe.reach_m(), hub_m.norm() + disc_m);
      EXPECT_LT(probe.reach_m(), 1.5 * (hub_m.norm() + disc_m));
    }
    int feet = 0;
    for (double x_m = -0.3; x_m <= 0.3; x_m += 0.01) {
      for (double y_m = -0.3; y_m <= 0.3; y_m += 0.01) {
        feet += probe.is_inside({x_m, y_m, -airframe.leg_height_m + 0.005}) ? 1 : 0;
        EXPECT_FALSE(probe.is_inside({x_m, y_m, -airframe.leg_height_m - 0.005}));
      }
    }
    EXPECT_GT(feet, 3) << "legs reach down to their height";
    EXPECT_LT(feet, 100) << "legs are thin";
  }
}

}  // namespace
}  // namespace swiftlet::sim
