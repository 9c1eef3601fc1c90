// SPDX-License-Identifier: BSD-3-Clause
// Views and where cameras stand.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "sim/render/cameras.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kRad = M_PI / 180.0;
const Eigen::AlignedBox3d kWorld(Vector3d(-30, -20, 0), Vector3d(30, 20, 15));

// Right, up and back of a camera that looks along a direction; its horizon is level.
std::tuple<Vector3d, Vector3d, Vector3d> axes_of(const Vector3d& back) {
  const Vector3d right = Vector3d(-back.y(), back.x(), 0.0).normalized();
  return {right, back.cross(right), back};
}

TEST(View, LevelsHorizonAndMatchesThePinhole) {
  const Random random(1, "test.views");
  for (std::uint32_t i = 0; i < 200; ++i) {
    const auto draw = [&](double most, std::uint32_t k) { return random.uniform(-most, most, i, k); };
    const Vector3d eye(draw(9, 0), draw(9, 1), draw(9, 2)), target(draw(9, 3), draw(9, 4), draw(9, 5)),
        p(draw(20, 6), draw(20, 7), draw(20, 8));
    const double fov_deg = random.uniform(20.0, 100.0, i, 9);
    const View view = perspective_view(eye, target, fov_deg, 300, 200);
    EXPECT_EQ(view.eye_world_m, eye);
    EXPECT_FALSE(view.orthographic);
    const auto [right, up, back] = axes_of((eye - target).normalized());
    const double depth = -(p - eye).dot(back), f = 100.0 / std::tan(0.5 * fov_deg * kRad);
    const auto at = view.project(p);
    ASSERT_EQ(at.has_value(), depth >= 0.05) << "nearer than 5 cm nothing is seen";
    if (!at) continue;
    EXPECT_NEAR(at->x(), 150.0 + f * (p - eye).dot(right) / depth, 1e-6);
    EXPECT_NEAR(at->y(), 100.0 - f * (p - eye).dot(up) / depth, 1e-6);
    EXPECT_NEAR(at->z(), depth, 1e-9);
    EXPECT_NEAR(view.pixels_per_m(depth), f / depth, 1e-9);
    const Vector4d clip = view.clip_world() * p.homogeneous();
    EXPECT_NEAR(clip.w(), depth, 1e-9);
    EXPECT_NEAR(clip.z() / clip.w(), 0.05 * (2000.0 / depth - 1.0) / (2000.0 - 0.05), 1e-9);
  }
}

TEST(View, OrientsVerticalViewByHint) {
  const View down = perspective_view({1, 2, 10}, {1, 2, 0}, 90.0, 200, 100);
  EXPECT_TRUE(down.project({2, 2, 0})->head<2>().isApprox(Eigen::Vector2d(105, 50), 1e-9)) << "east is at the right";
  EXPECT_TRUE(down.project({1, 3, 0})->head<2>().isApprox(Eigen::Vector2d(100, 45), 1e-9)) << "north is up";
  const View along = perspective_view({0, -10, 0}, {0, 0, 0}, 90.0, 200, 100, Vector3d::UnitY());
  EXPECT_TRUE(along.project({1, 0, 0})->head<2>().isApprox(Eigen::Vector2d(105, 50), 1e-9));
  EXPECT_TRUE(along.project({0, 0, 1})->head<2>().isApprox(Eigen::Vector2d(100, 45), 1e-9));
}

TEST(View, SeesAllHeightsFromTheTop) {
  const View view = top_view({10, 20}, 50.0, -4.0, 30.0, 200, 100);
  const auto depth = [&](double z_m) { return (view.clip_world() * Vector4d(3, 4, z_m, 1)).z(); };
  EXPECT_NEAR(depth(30.5), 1.0, 1e-9) << "half a meter above";
  EXPECT_NEAR(depth(-5.0), 0.0, 1e-9) << "a meter below";
  EXPECT_NEAR(depth(0.5 * (30.5 - 5.0)), 0.5, 1e-9);
  EXPECT_TRUE(view.orthographic);
  EXPECT_EQ(view.eye_world_m, Vector3d(10, 20, 31));
  for (const double depth_m : {0.1, 7.0}) EXPECT_NEAR(view.pixels_per_m(depth_m), 2.0, 1e-12);
  EXPECT_NEAR(view.project({10, 20, 4})->z(), 27.0, 1e-9);
  EXPECT_NEAR(view.project({60, 20, 4})->x(), 200.0, 1e-9);
  EXPECT_NEAR(view.project({10, -5, 4})->y(), 100.0, 1e-9);
}

std::vector<VehicleState> states_at(const std::vector<Vector3d>& places, double t_s) {
  std::vector<VehicleState> states(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    states[i].t = from_seconds(t_s);
    states[i].p_world_m = places[i];
  }
  return states;
}

CameraConfig follow_camera(const Vector3d& offset) {
  CameraConfig config;
  config.type = CameraConfig::Type::kFollow;
  config.position_m = offset;
  config.width_px = 300;
  config.height_px = 200;
  config.fov_deg = 50.0;
  return config;
}

TEST(Cameraman, KeepsItsPositionForWiderPictures) {
  // A narrower one has to step back.
  Cameraman cameraman(follow_camera({-1, 0, 1}), kNoVehicle, {0.5F, 0.5F}, kWorld);
  PictureScene picture;
  picture.states = states_at({{0, -6, 2}, {0, 6, 2}}, 0.0);
  cameraman.update(0, picture.states);
  const double usual_m = cameraman.view(picture).eye_world_m.norm();
  cameraman.set_size(150, 200);
  EXPECT_GT(cameraman.view(picture).eye_world_m.norm(), 1.5 * usual_m);
  EXPECT_EQ(cameraman.view(picture).width_px, 150);
  cameraman.set_size(600, 200);
  EXPECT_NEAR(cameraman.view(picture).eye_world_m.norm(), usual_m, 1e-9);
}

TEST(Cameraman, StaysAtOriginWithoutItsVehicle) {
  CameraConfig config;
  config.type = CameraConfig::Type::kOnboard;
  config.position_m = {1, 0, 0};
  PictureScene picture;
  picture.states = states_at({{9, 9, 9}}, 0.0);
  for (const VehicleId vehicle : {-1, 1})
    EXPECT_TRUE(Cameraman(config, vehicle, {0.3F}, kWorld).view(picture).eye_world_m.isApprox(Vector3d(1, 0, 0)));
}

TEST(Cameraman, FramesEverythingFromTopWithMargin) {
  struct Case {
    std::vector<Vector3d> places;
    double span_m;
  };
  const double aspect = 300.0 / 200.0;
  for (const auto& [places, span_m] : {Case{{{1, 2, 3}}, 12.0}, Case{{{0, 0, 3}, {0, 20, 3}}, 1.25 * 20 + 4},
                                       Case{{{0, 0, 3}, {40, 8, 3}}, (1.25 * 40 + 4) / aspect}}) {
    CameraConfig config;
    config.width_px = 300;
    config.height_px = 200;
    PictureScene picture;
    picture.states = states_at(places, 0.0);
    const View view = Cameraman(config, kNoVehicle, {}, kWorld).view(picture);
    EXPECT_NEAR(view.pixels_per_m(1.0), 200.0 / span_m, 1e-9);
    const Vector3d middle = 0.5 * (places.front() + places.back());
    EXPECT_TRUE(view.project(middle)->head<2>().isApprox(Eigen::Vector2d(150, 100), 1e-9));
  }
}

TEST(Cameraman, SpansTheGroundInTopPerspective) {
  for (const double bottom_m : {-6.0, 3.0}) {
    CameraConfig config;
    config.width_px = 300;
    config.height_px = 200;
    config.span_m = 40.0;
    config.fov_deg = 50.0;
    config.perspective = true;
    const Eigen::AlignedBox3d bounds(Vector3d(-9, -9, bottom_m), Vector3d(9, 9, 20));
    const View view = Cameraman(config, kNoVehicle, {}, bounds).view(PictureScene());
    EXPECT_FALSE(view.orthographic);
    const double ground_m = std::max(0.0, bottom_m);
    EXPECT_TRUE(view.project({0, 0, ground_m})->head<2>().isApprox(Eigen::Vector2d(150, 100), 1e-9));
    EXPECT_NEAR(view.project({0, 20, ground_m})->y(), 0.0, 1e-6);
    EXPECT_NEAR(view.project({30, 0, ground_m})->x(), 300.0, 1e-6);
  }
}

}  // namespace
}  // namespace swiftlet::sim
