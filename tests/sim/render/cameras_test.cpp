// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/cameras.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;

const Eigen::AlignedBox3d kBounds(Vector3d(-30, -30, 0), Vector3d(30, 30, 20));

TEST(View, LevelsHorizonAndMatchesThePinhole) {
  const Random random(1, "test.views");
  for (std::uint32_t i = 0; i < 200; ++i) {
    const auto draw = [&](double most, std::uint32_t k) { return random.uniform(-most, most, i, k); };
    const Vector3d eye(draw(9, 0), draw(9, 1), draw(9, 2)), target(draw(9, 3), draw(9, 4), draw(9, 5)),
        p(draw(20, 6), draw(20, 7), draw(20, 8));
    const double fov_deg = random.uniform(20.0, 100.0, i, 9);
    const View view = perspective_view(eye, target, fov_deg, 300, 200);
    const Vector3d back = (eye - target).normalized(), right = Vector3d(-back.y(), back.x(), 0.0).normalized(),
                   up = back.cross(right);
    const double depth = -(p - eye).dot(back), f = 100.0 / std::tan(0.5 * fov_deg * M_PI / 180.0);
    const auto at = view.project(p);
    ASSERT_EQ(at.has_value(), depth >= view.near_m);
    if (!at) continue;
    EXPECT_NEAR(at->x(), 150.0 + f * (p - eye).dot(right) / depth, 1e-6);
    EXPECT_NEAR(at->y(), 100.0 - f * (p - eye).dot(up) / depth, 1e-6);
    EXPECT_NEAR(at->z(), depth, 1e-9);
    EXPECT_NEAR(view.pixels_per_m(depth), f / depth, 1e-9);
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

TEST(View, ReversesDepthFromOneToZero) {
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 200, 100);
  const auto depth = [&](double x) {
    const Eigen::Vector4d clip = view.clip_world() * Eigen::Vector4d(x, 0, 0, 1);
    return clip.z() / clip.w();
  };
  EXPECT_NEAR(depth(view.near_m), 1.0, 1e-9);
  EXPECT_NEAR(depth(view.far_m), 0.0, 1e-9);
}

TEST(View, ShowsNorthUpAtUniformScale) {
  const View view = top_view({10, 20}, 50.0, 0.0, 30.0, 200, 100);
  EXPECT_TRUE(view.project({10, 20, 5})->head<2>().isApprox(Eigen::Vector2d(100, 50), 1e-9));
  EXPECT_NEAR(view.project({10, 45, 5})->y(), 0.0, 1e-9);
  EXPECT_NEAR(view.project({15, 20, 25})->x(), 110.0, 1e-9);
}

std::vector<VehicleState> team_at(double t_s) {
  std::vector<VehicleState> states(4);
  for (int v = 0; v < 4; ++v) {
    const double a = 0.3 * t_s * (1 + 0.4 * v) + v;
    states[v].t = from_seconds(t_s);
    states[v].p_world_m = {(4 + 5 * v) * std::cos(a), (4 + 3 * v) * std::sin(a), 2 + v + std::sin(0.9 * t_s)};
  }
  return states;
}

TEST(CameraController, FollowsAWholeTeamSmoothly) {
  CameraConfig config;
  config.type = CameraConfig::Type::kFollow;
  const double radius_m = 0.5;
  CameraController controller(config, kNoVehicle, std::vector<float>(4, radius_m), kBounds);
  Vector3d last_eye = Vector3d::Zero();
  for (int k = 0; k <= 1500; ++k) {
    PictureScene picture;
    picture.states = team_at(0.02 * k);
    picture.t = picture.states[0].t;
    controller.update(picture.t, picture.states);
    const View view = controller.view(picture);
    for (const VehicleState& state : picture.states) {
      const auto at = view.project(state.p_world_m);
      ASSERT_TRUE(at);
      const double r = radius_m * view.pixels_per_m(at->z());
      ASSERT_GT(at->x() - r, 0.0) << k;
      ASSERT_LT(at->x() + r, config.width_px) << k;
      ASSERT_GT(at->y() - r, 0.0) << k;
      ASSERT_LT(at->y() + r, config.height_px) << k;
    }
    ASSERT_TRUE(k == 0 || (view.eye_world_m - last_eye).norm() < 0.6) << "a jump at " << k;
    last_eye = view.eye_world_m;
  }
}

TEST(CameraController, FollowingOneVehicleKeepsItsOffset) {
  CameraConfig config;
  config.type = CameraConfig::Type::kFollow;
  config.position_m = {-6, -3, 4};
  CameraController controller(config, 2, std::vector<float>(4, 0.5F), kBounds);
  PictureScene picture;
  picture.states = team_at(3.0);
  picture.t = picture.states[0].t;
  const View view = controller.view(picture);
  EXPECT_TRUE((view.eye_world_m - picture.states[2].p_world_m).isApprox(Vector3d(-6, -3, 4), 1e-9));
}

/// A wall of any length at x = -3, from the ground to 6 m, with a gap for y above `gap_m`.
bool behind_wall(const Vector3d& a, const Vector3d& b, double gap_m) {
  if ((a.x() + 3.0) * (b.x() + 3.0) >= 0.0) return false;
  const Vector3d at = a + (-3.0 - a.x()) / (b.x() - a.x()) * (b - a);
  return at.z() < 6.0 && at.y() < gap_m;
}

TEST(CameraController, AvoidsOcclusionAtTheStart) {
  CameraConfig config;
  config.type = CameraConfig::Type::kFollow;
  config.position_m = {-8, 0, 3};
  const auto blocks = [](const Vector3d& a, const Vector3d& b) { return behind_wall(a, b, 1e9); };
  PictureScene picture;
  picture.states.resize(1);
  picture.states[0].p_world_m = {0, 0, 2};
  const View blind = CameraController(config, 0, {0.5F}, kBounds).view(picture);
  ASSERT_TRUE(blocks(picture.states[0].p_world_m, blind.eye_world_m)) << "the test itself";
  const View view = CameraController(config, 0, {0.5F}, kBounds, blocks).view(picture);
  EXPECT_FALSE(blocks(picture.states[0].p_world_m, view.eye_world_m));
  const Vector3d at = *view.project(picture.states[0].p_world_m);
  EXPECT_TRUE(at.head<2>().isApprox(Eigen::Vector2d(640, 360), 1e-6))
      << "the vehicle stays at the center of the picture";
}

TEST(CameraController, KeepsSightAlongWallsAndReturns) {
  // The wall ends: from y = 12 on the configured place is free again.
  CameraConfig config;
  config.type = CameraConfig::Type::kFollow;
  config.position_m = {-8, 0, 3};
  const auto blocks = [](const Vector3d& a, const Vector3d& b) { return behind_wall(a, b, 12.0); };
  CameraController controller(config, 0, {0.4F}, kBounds, blocks);
  Vector3d last_eye = Vector3d::Zero();
  int blocked = 0;
  PictureScene picture;
  picture.states.resize(1);
  for (int k = 0; k <= 1500; ++k) {
    picture.t = from_seconds(0.02 * k);
    picture.states[0].t = picture.t;
    picture.states[0].p_world_m = {0.0, -10.0 + 1.5 * 0.02 * k, 2.0};
    controller.update(picture.t, picture.states);
    const Vector3d eye = controller.view(picture).eye_world_m;
    blocked += blocks(picture.states[0].p_world_m, eye) ? 1 : 0;
    ASSERT_TRUE(k == 0 || (eye - last_eye).norm() < 0.4) << "a jump at " << k;
    last_eye = eye;
  }
  EXPECT_LT(blocked, 30) << "views with the vehicle hidden, out of 1501";
  // 1.2 s of inertia at 1.5 m/s leave it behind a little.
  EXPECT_TRUE((last_eye - picture.states[0].p_world_m).isApprox(Vector3d(-8, 0, 3), 0.3))
      << (last_eye - picture.states[0].p_world_m).transpose();
}

TEST(CameraController, TakesTheBestOfBlockedPlaces) {
  CameraConfig config;
  config.type = CameraConfig::Type::kFollow;
  PictureScene picture;
  picture.states.resize(1);
  CameraController controller(config, 0, {0.5F}, kBounds, [](const auto&, const auto&) { return true; });
  const View view = controller.view(picture);
  EXPECT_TRUE(view.project(picture.states[0].p_world_m));
}

TEST(CameraController, FromTheTopShowsEveryTrail) {
  CameraConfig config;
  CameraController controller(config, kNoVehicle, std::vector<float>(4, 0.5F), kBounds);
  PictureScene picture;
  picture.states = team_at(0.0);
  picture.trails_m = {{{-25, 3, 1}, {0, 0, 1}}, {{0, 28, 2}}};
  const View view = controller.view(picture);
  for (const Vector3d& p : {Vector3d(-25, 3, 1), Vector3d(0, 28, 2)}) {
    const Vector3d at = *view.project(p);
    EXPECT_TRUE(at.x() > 0 && at.x() < config.width_px && at.y() > 0 && at.y() < config.height_px) << at.transpose();
  }
}

TEST(CameraController, OnBoardTurnsWithTheVehicle) {
  CameraConfig config;
  config.type = CameraConfig::Type::kOnboard;
  config.position_m = {0.2, 0, 0.1};
  config.target_m = {1.2, 0, 0.1};
  CameraController controller(config, 0, {0.5F}, kBounds);
  PictureScene picture;
  picture.states.resize(1);
  picture.states[0].p_world_m = {3, 4, 5};
  picture.states[0].q_world_body = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());  // facing north
  const View view = controller.view(picture);
  EXPECT_TRUE(view.eye_world_m.isApprox(Vector3d(3, 4.2, 5.1), 1e-9));
  const Vector3d ahead = *view.project({3, 14.2, 5.1});
  EXPECT_TRUE(ahead.head<2>().isApprox(Eigen::Vector2d(640, 360), 1e-6));
}

TEST(CameraController, DefaultsToOverviewFromTheSouthwest) {
  CameraConfig config;
  config.type = CameraConfig::Type::kFixed;
  CameraController controller(config, kNoVehicle, {}, kBounds);
  const View view = controller.view(PictureScene());
  EXPECT_LT(view.eye_world_m.x(), 0.0);
  EXPECT_LT(view.eye_world_m.y(), 0.0);
  EXPECT_GT(view.eye_world_m.z(), kBounds.max().z());
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = view.project(kBounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
    ASSERT_TRUE(at);
    EXPECT_TRUE(at->x() > 0 && at->x() < config.width_px && at->y() > 0 && at->y() < config.height_px);
  }
}

TEST(CameraController, StaysWithItsVehicleByDefault) {
  PictureScene picture;
  picture.states = team_at(0.0);
  for (const auto type : {CameraConfig::Type::kFollow, CameraConfig::Type::kOnboard, CameraConfig::Type::kDepth}) {
    CameraConfig config;
    config.type = type;
    CameraController controller(config, 1, std::vector<float>(4, 0.5F), kBounds);
    controller.update(picture.t, picture.states);
    const double away_m = (controller.view(picture).eye_world_m - picture.states[1].p_world_m).norm();
    EXPECT_GT(away_m, 0.1);
    EXPECT_LT(away_m, type == CameraConfig::Type::kFollow ? 20.0 : 0.5);
  }
}

TEST(CameraController, StepsBackForNarrowerPictures) {
  CameraConfig config;
  config.type = CameraConfig::Type::kFollow;
  config.position_m = {-1, 0, 1};
  config.width_px = 300;
  config.height_px = 200;
  CameraController controller(config, kNoVehicle, {0.5F, 0.5F}, kBounds);
  PictureScene picture;
  picture.states.resize(2);
  picture.states[0].p_world_m = {0, -6, 2};
  picture.states[1].p_world_m = {0, 6, 2};
  controller.update(0, picture.states);
  const double usual_m = controller.view(picture).eye_world_m.norm();
  controller.set_size(150, 200);
  EXPECT_GT(controller.view(picture).eye_world_m.norm(), 1.5 * usual_m);
  controller.set_size(600, 200);
  EXPECT_NEAR(controller.view(picture).eye_world_m.norm(), usual_m, 1e-9);
}

}  // namespace
}  // namespace swiftlet::sim
