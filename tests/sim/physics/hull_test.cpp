// SPDX-License-Identifier: BSD-3-Clause
// Collision shape of a vehicle, probed with a tiny triangle and compared with its solids.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/physics/contacts.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

// Distances of a point to solids, negative inside. Body frame.
double to_cylinder_m(const Vector3& p_body_m, const Vector3& center_m, double radius_m, double half_height_m) {
  const Vector3 d = p_body_m - center_m;
  const double out = d.head<2>().norm() - radius_m, up = std::abs(d.z()) - half_height_m;
  return std::min(std::max(out, up), 0.0) + std::hypot(std::max(out, 0.0), std::max(up, 0.0));
}
double to_segment_m(const Vector3& p_body_m, const Vector3& a, const Vector3& b) {
  const double s = std::clamp((p_body_m - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (a + s * (b - a) - p_body_m).norm();
}

/// Distance to the nearest of body, propeller discs, arms and legs.
double to_hull_m(const Airframe& airframe, const Vector3& p_body_m) {
  double least_m = to_cylinder_m(p_body_m, Vector3::Zero(), airframe.body_radius_m, 0.5 * airframe.body_height_m);
  for (const Rotor& rotor : airframe.rotors) {
    least_m = std::min(least_m, to_cylinder_m(p_body_m, rotor.position_m, airframe.propeller_radius_m, 0.01));
    // Square arms of 24 mm, from the center to just below the disc.
    const Vector3 tip = rotor.position_m - 0.032 * Vector3::UnitZ(), along = tip.normalized();
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitX(), along);
    const Vector3 d = (turn.conjugate() * (p_body_m - 0.5 * tip)).cwiseAbs() - Vector3(0.5 * tip.norm(), 0.012, 0.012);
    least_m = std::min(least_m, std::min(d.maxCoeff(), 0.0) + d.cwiseMax(0.0).norm());
  }
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      // Feet of 12 mm radius stand at the ends of the skids; legs lead inwards from there, to the body.
      const Vector3 foot(1.5 * x * airframe.body_radius_m, 1.3 * y * airframe.body_radius_m,
                         -airframe.leg_height_m + 0.012);
      const Vector3 root(0.5 * foot.x(), 0.5 * foot.y(), std::max(-0.25 * airframe.body_height_m, foot.z() + 0.001));
      least_m = std::min(least_m, to_segment_m(p_body_m, foot, root) - 0.012);
    }
  }
  return least_m;
}

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
  for (const bool is_flat : {false, true}) {
    Airframe airframe = test_quad();
    airframe.body_radius_m = is_flat ? 0.09 : 0.12;
    airframe.body_height_m = is_flat ? 0.05 : 0.16;
    airframe.leg_height_m = is_flat ? 0.06 : 0.2;
    airframe.propeller_radius_m = 0.11;
    Probe probe(airframe);
    const Random random(is_flat ? 1 : 2, "hull");
    int inside = 0, outside = 0;
    double farthest_m = 0.0;
    for (std::uint32_t i = 0; i < 30'000; ++i) {
      const Vector3 p_body_m(random.uniform(-0.33, 0.33, 0, i), random.uniform(-0.33, 0.33, 1, i),
                             random.uniform(-0.23, 0.12, 2, i));
      const double distance_m = to_hull_m(airframe, p_body_m);
      if (std::abs(distance_m) < 0.0012 || std::abs(distance_m) > 0.006) continue;
      // The edge of the body is rounded by a tenth of its height.
      const double from_rim_m = std::max(std::abs(p_body_m.head<2>().norm() - airframe.body_radius_m),
                                         std::abs(std::abs(p_body_m.z()) - 0.5 * airframe.body_height_m));
      if (from_rim_m < 0.01) continue;
      ASSERT_EQ(probe.is_inside(p_body_m), distance_m < 0.0) << p_body_m.transpose() << ": " << distance_m;
      (distance_m < 0.0 ? inside : outside) += 1;
      if (distance_m < 0.0) farthest_m = std::max(farthest_m, p_body_m.norm());
    }
    EXPECT_GT(inside, 300);
    EXPECT_GT(outside, 500);
    EXPECT_GE(probe.reach_m(), farthest_m);
    EXPECT_LT(probe.reach_m(), 1.5 * farthest_m);
  }
}

}  // namespace
}  // namespace swiftlet::sim
