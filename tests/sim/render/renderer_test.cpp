// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "render_support.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

const Rgb kRed(0.9F, 0.08F, 0.08F);
const Rgb kGreen(0.08F, 0.85F, 0.08F);
const Rgb kBlue(0.08F, 0.1F, 0.9F);
const Rgb kGray(0.6F, 0.6F, 0.6F);
constexpr int kWidth = 160;
constexpr int kHeight = 120;

View view_along_x(const Eigen::Vector3d& eye = {0, 0, 1}) {
  return perspective_view(eye, eye + Eigen::Vector3d::UnitX(), 60.0, kWidth, kHeight);
}

Image draw_world(Scene& scene, const View& view, const PictureStyle& style = {}) {
  Renderer renderer(scene, {});
  return renderer.draw(view, {}, style);
}

TEST(Renderer, ShowsABoxAgainstTheSky) {
  BoxWorld world;
  world.add({5, -1, 0}, {6, 1, 2}, kRed);
  const Image image = draw_world(world.scene(), view_along_x());
  EXPECT_TRUE(is_dominated_by(color_at(image, 80, 60), 0)) << color_at(image, 80, 60).transpose();
  // The front face is 2 m at 5 m: half of it spans 120 px / (2 tan 30 deg) / 5 = 20.8 px.
  EXPECT_TRUE(is_dominated_by(color_at(image, 80 + 19, 60), 0));
  EXPECT_TRUE(is_dominated_by(color_at(image, 80, 60 - 19), 0));
  EXPECT_FALSE(is_dominated_by(color_at(image, 80 + 23, 60), 0));
  EXPECT_FALSE(is_dominated_by(color_at(image, 80, 60 - 23), 0));
  EXPECT_GT(color_at(image, 80, 5).z(), color_at(image, 80, 5).x()) << "the sky is blue";
}

TEST(Renderer, MeasuresDepthOfPlanesAndSky) {
  BoxWorld world;
  world.add({5, -50, -50}, {6, -0.5F, 50}, kGray).add({80, 0.5F, -50}, {81, 50, 50}, kGray);
  Renderer renderer(world.scene(), {});
  const DepthImage depth = renderer.draw_depth(view_along_x(), {}, {});
  // A plane across the axis has one depth; far away it is still right to a millimeter.
  for (const int y : {10, 60, 110}) {
    EXPECT_NEAR(depth.at(130, y), 5.0, 1e-3);
    EXPECT_NEAR(depth.at(30, y), 80.0, 1e-3);
  }
  BoxWorld floor;
  floor.add({-100, -100, -1}, {100, 100, 0}, kGray);
  Renderer floor_renderer(floor.scene(), {});
  const DepthImage slope = floor_renderer.draw_depth(view_along_x({0, 0, 2}), {}, {});
  for (const int y : {70, 90, 119}) {  // the ray through the pixel falls (y + 0.5 - 60) / f a meter
    const double f = 60.0 / std::tan(M_PI / 6.0);
    EXPECT_NEAR(slope.at(80, y), 2.0 * f / (y + 0.5 - 60.0), 0.01) << y;
  }
  EXPECT_EQ(slope.at(80, 20), 0.0F) << "sky";
}

TEST(Renderer, DrawsInstancesWhereTheyAre) {
  BoxWorld world;
  world.add({-0.5F, -0.5F, -0.5F}, {0.5F, 0.5F, 0.5F}, kBlue);
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.translate(Eigen::Vector3f(8, 2, 1)).rotate(Eigen::AngleAxisf(0.4F, Eigen::Vector3f::UnitZ())).scale(1.5F);
  world.scene().instances.push_back({0, T, 0});
  const View view = view_along_x();
  const Image image = draw_world(world.scene(), view);
  const Eigen::Vector3d at = *view.project({8, 2, 1});
  EXPECT_TRUE(is_dominated_by(color_at(image, static_cast<int>(at.x()), static_cast<int>(at.y())), 2));
  EXPECT_FALSE(is_dominated_by(color_at(image, kWidth - static_cast<int>(at.x()), static_cast<int>(at.y())), 2));
}

TEST(Renderer, CullingChangesNoPixel) {
  BoxWorld world;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3f at(static_cast<float>(i % 10) * 4 - 18, static_cast<float>(i / 10) * 4 - 18, 0);
    world.add(at, at + Eigen::Vector3f(1, 1, 1 + 0.3F * static_cast<float>(i % 7)), i % 2 == 0 ? kRed : kGreen);
  }
  Renderer renderer(world.scene(), {});
  PictureStyle culled;
  PictureStyle complete;
  complete.cull = false;
  for (const Eigen::Vector3d& target : {Eigen::Vector3d(5, 3, 0), Eigen::Vector3d(-20, 1, 2)}) {
    const View view = perspective_view({-2, -3, 2}, target, 60.0, kWidth, kHeight);
    EXPECT_EQ(renderer.draw(view, {}, culled).rgb, renderer.draw(view, {}, complete).rgb);
  }
}

TEST(Renderer, IsIndependentOfTheThread) {
  BoxWorld world;
  world.add({5, -1, 0}, {6, 1, 2}, kRed).add({-20, -20, -1}, {20, 20, 0}, kGray, SurfaceClass::kGround);
  Renderer renderer(world.scene(), {});
  const Image first = renderer.draw(view_along_x(), {}, {});
  const DepthImage first_depth = renderer.draw_depth(view_along_x(), {}, {});
  for (int i = 0; i < 3; ++i) {
    Image image;
    DepthImage depth;
    std::thread([&] {
      image = renderer.draw(view_along_x(), {}, {});
      depth = renderer.draw_depth(view_along_x(), {}, {});
    }).join();
    EXPECT_EQ(image.rgb, first.rgb);
    EXPECT_EQ(depth.depth_m, first_depth.depth_m);
  }
  EXPECT_EQ(renderer.draw(view_along_x(), {}, {}).rgb, first.rgb);
}

TEST(Renderer, LooksUnderARoofWhenCutting) {
  BoxWorld world;
  world.add({-5, -5, 4}, {5, 5, 4.2F}, kGreen).add({-5, -5, -0.2F}, {5, 5, 0}, kRed);
  Renderer renderer(world.scene(), {});
  const View view = top_view({0, 0}, 8.0, -1.0, 5.0, kWidth, kHeight);
  PictureStyle style;
  EXPECT_TRUE(is_dominated_by(color_at(renderer.draw(view, {}, style), 80, 60), 1));
  style.cut_above = true;
  style.cut_height_m = 3.0;
  const Rgb floor = color_at(renderer.draw(view, {}, style), 80, 60);
  EXPECT_TRUE(is_dominated_by(floor, 0));
  EXPECT_GT(floor.x(), 0.5F) << "the roof that is cut away throws no shadow";
}

TEST(Renderer, CastsShadowsOfWorldAndVehicles) {
  // The sun stands at (-0.62, 0.28, 0.80): a thing at height h shades the ground at (+0.775, -0.35) h.
  BoxWorld world;
  world.add({-20, -20, -1}, {20, 20, 0}, kGray).add({-7, -1, 5}, {-5, 1, 5.2F}, kGray);
  const auto shape = make_test_shape();
  Renderer renderer(world.scene(), std::vector{shape});
  PictureScene picture;
  picture.states.resize(1);
  picture.states[0].p_world_m = {4.0, 3.0, 4.0};
  const View view = top_view({0, 0}, 20.0, -1.0, 6.0, 400, 400);  // 20 px a meter
  const Image image = renderer.draw(view, picture, {});
  const auto ground = [&](double x, double y) {
    return brightness(color_at(image, static_cast<int>(200 + 20 * x), static_cast<int>(200 - 20 * y)));
  };
  const float lit = ground(-3.0, 6.0);
  EXPECT_LT(ground(-6.0 + 0.775 * 5.0, -0.35 * 5.0), 0.8F * lit);
  EXPECT_LT(ground(4.0 + 0.775 * 4.0, 3.0 - 0.35 * 4.0), 0.8F * lit);
  EXPECT_NEAR(ground(8.0, -8.0), lit, 0.1F);
}

TEST(Renderer, DrawsVehiclesExceptTheCameraCarrier) {
  BoxWorld world;
  world.add({-20, -20, -1}, {20, 20, 0}, kGray);
  const auto shape = make_test_shape();
  Renderer renderer(world.scene(), std::vector{shape, shape});
  PictureScene picture;
  picture.states.resize(2);
  picture.states[0].p_world_m = {4.0, 1.2, 1.0};
  picture.states[1].p_world_m = {4.0, -1.2, 1.0};
  const View view = view_along_x();
  const Image image = renderer.draw(view, picture, {});
  const auto pixel_of = [&](std::size_t v) {
    const Eigen::Vector3d at = *view.project(picture.states[v].p_world_m);
    return std::pair(static_cast<int>(at.x()), static_cast<int>(at.y()));
  };
  const auto [x0, y0] = pixel_of(0);
  const auto [x1, y1] = pixel_of(1);
  EXPECT_TRUE(is_dominated_by(color_at(image, x0, y0), 0)) << "the first one is red";
  EXPECT_TRUE(is_dominated_by(color_at(image, x1, y1), 2)) << "the second one is blue";
  PictureStyle style;
  style.hidden_vehicle = 0;
  EXPECT_FALSE(is_dominated_by(color_at(renderer.draw(view, picture, style), x0, y0), 0));
}

TEST(Renderer, BlursSpinningRotorsAndTurnsBlades) {
  BoxWorld world;
  world.add({-20, -20, -1}, {20, 20, 0}, kGray);
  Renderer renderer(world.scene(), std::vector{make_test_shape()});
  PictureScene picture;
  picture.states.resize(1);
  picture.states[0].p_world_m = {0.0, 0.0, 2.0};
  const View view = top_view({0, 0}, 3.0, -1.0, 4.0, 300, 300);  // 100 px a meter; the rotor's radius is 1 m
  const Image still = renderer.draw(view, picture, {});
  picture.states[0].rotor_speed_radps[0] = 400.0;
  const Image spinning = renderer.draw(view, picture, {});
  // At angle 0 the blades are along x. Between them a spinning rotor blurs the ground.
  EXPECT_LT(brightness(color_at(still, 150 + 60, 150)), 0.5F * brightness(color_at(still, 150, 150 - 60)));
  EXPECT_GT((color_at(still, 150, 150 - 60) - color_at(spinning, 150, 150 - 60)).cwiseAbs().maxCoeff(), 0.02F);
  picture.states[0].rotor_angle_rad[0] = M_PI / 2 + 40 * M_PI;
  const Image turned = renderer.draw(view, picture, {});
  EXPECT_LT(brightness(color_at(turned, 150, 150 - 60)), 0.5F * brightness(color_at(turned, 150 + 60, 150)));
}

TEST(Renderer, DrawsTrailsCloudsAndChosenOverlays) {
  BoxWorld world;
  world.add({-20, -20, -1}, {20, 20, 0}, kGray);
  const auto shape = make_test_shape();
  Renderer renderer(world.scene(), std::vector{shape});
  PictureScene picture;
  picture.states.resize(1);
  picture.states[0].p_world_m = {-8.0, 8.0, 1.0};
  picture.trails_m = {{{8, 8, 1}, {0, 8, 1}}};
  PictureCloud cloud;
  for (int i = 0; i < 400; ++i) {
    cloud.points_world_m.emplace_back(4 + 0.02F * static_cast<float>(i % 20), -4 + 0.02F * static_cast<float>(i / 20),
                                      1);
    cloud.surface_class.push_back(static_cast<std::uint16_t>(SurfaceClass::kVehicle));
  }
  picture.clouds.push_back(cloud);
  const Eigen::Vector4f blue(0.1F, 0.2F, 1.0F, 1.0F);
  const Eigen::Vector4f half_green(0.0F, 1.0F, 0.0F, 0.5F);
  picture.overlays.push_back({"voxels", Overlay::Kind::kCubes, {{-4, -4, 1}}, {blue}, 1.0F, {}});
  picture.overlays.push_back({"ball", Overlay::Kind::kSpheres, {{0, 4, 1}}, {blue}, 0.7F, {}});
  picture.overlays.push_back({"rung", Overlay::Kind::kLines, {{-8, -6, 1}, {8, -6, 1}}, {blue, blue}, 5.0F, {}});
  picture.overlays.push_back({"path", Overlay::Kind::kPolyline, {{-8, -8, 1}, {8, -8, 1}}, {blue}, 5.0F, {}});
  picture.overlays.push_back(
      {"area", Overlay::Kind::kTriangles, {{-2, -2, 1}, {2, -2, 1}, {0, 2, 1}}, {half_green}, 1.0F, {}});
  picture.overlays.push_back({"other", Overlay::Kind::kPoints, {{8, 0, 1}}, {blue}, 1.0F, {}});
  const View view = top_view({0, 0}, 20.0, -1.0, 6.0, 400, 400);
  const auto color = [](const Image& image, double x, double y) {
    return color_at(image, static_cast<int>(200 + 20 * x), static_cast<int>(200 - 20 * y));
  };

  PictureStyle style;
  style.trails = false;
  const Image plain = renderer.draw(view, picture, style);
  for (const auto& [x, y] : {std::pair(-4, -4), std::pair(0, 4), std::pair(0, -8), std::pair(4, 8), std::pair(8, 0)}) {
    EXPECT_LT((color(plain, x, y) - color(plain, 6, 4)).cwiseAbs().maxCoeff(), 0.1F) << x << " " << y;
  }

  style.trails = true;
  style.cloud = CloudColors::kLabel;
  style.overlays = {"voxels", "ball", "rung", "path", "area"};
  const Image drawn = renderer.draw(view, picture, style);
  EXPECT_TRUE(is_dominated_by(color(drawn, -4, -4), 2)) << "a cube";
  EXPECT_TRUE(is_dominated_by(color(drawn, 0, 4), 2)) << "a sphere";
  EXPECT_TRUE(is_dominated_by(color(drawn, 0, -6), 2)) << "a line";
  EXPECT_TRUE(is_dominated_by(color(drawn, 0, -8), 2)) << "a path";
  EXPECT_TRUE(is_dominated_by(color(drawn, -4, 8), 0)) << "a trail";
  EXPECT_TRUE(is_dominated_by(color(drawn, 4.2, -3.8), 0)) << "a cloud of vehicle points";
  EXPECT_LT((color(drawn, 8, 0) - color(plain, 8, 0)).cwiseAbs().maxCoeff(), 0.05F) << "an overlay that is not listed";
  // Half transparent: half of the ground, half of the color.
  EXPECT_NEAR(color(drawn, 0, -1).x(), 0.5F * color(plain, 0, -1).x(), 0.06F);

  style.overlays = {"*"};
  EXPECT_TRUE(is_dominated_by(color(renderer.draw(view, picture, style), 8, 0), 2));
}

TEST(Renderer, DrawsIdenticallyWithACachedWorld) {
  BoxWorld world;
  world.add({-20, -20, -1}, {20, 20, 0}, kGray).add({4, -3, 0}, {5, -1, 2}, {0.8F, 0.1F, 0.1F});
  const auto shape = make_test_shape();
  for (const bool quick : {false, true}) {
    PictureStyle style;
    style.quick = quick;
    Renderer kept(world.scene(), std::vector{shape});
    for (int k = 0; k < 5; ++k) {
      PictureScene picture;
      picture.states.resize(1);
      picture.states[0].p_world_m = {6.0, -2.0 + k, 1.0};
      picture.trails_m = {{{6.0F, -4.0F, 1.0F}}};
      // Two cameras by turns, one of which is new each time.
      for (const View& view : {view_along_x(), view_along_x({0.1 * k, 0, 2})}) {
        Renderer fresh(world.scene(), std::vector{shape});
        EXPECT_EQ(kept.draw(view, picture, style).rgb, fresh.draw(view, picture, style).rgb) << k << quick;
      }
    }
    // Other settings of the world's appearance require a new image.
    style.cut_above = true;
    style.cut_height_m = 1.0;
    Renderer fresh(world.scene(), std::vector{shape});
    EXPECT_EQ(kept.draw(view_along_x(), {}, style).rgb, fresh.draw(view_along_x(), {}, style).rgb);
  }
}

int columns_unlike(const Image& image, const Image& plain, int y) {
  int count = 0;
  for (int x = 0; x < image.width; ++x)
    count += (color_at(image, x, y) - color_at(plain, x, y)).cwiseAbs().maxCoeff() > 0.2F ? 1 : 0;
  return count;
}

TEST(Renderer, PointSizeIsIndependentOfDistance) {
  BoxWorld world;
  world.add({-20, -20, -1}, {20, 20, 0}, kGray);
  Renderer renderer(world.scene(), {});
  PictureStyle style;
  style.cloud = CloudColors::kLabel;
  for (const float distance_m : {2.0F, 60.0F}) {
    PictureScene picture;
    const Image plain = renderer.draw(view_along_x(), picture, style);
    PictureCloud cloud;
    cloud.points_world_m = {{distance_m, 0.0F, 1.0F}};
    cloud.surface_class = {static_cast<std::uint16_t>(SurfaceClass::kVehicle)};
    picture.clouds = {cloud};
    const auto at = view_along_x().project(cloud.points_world_m[0].cast<double>());
    for (const float wanted_px : {5.0F, 20.0F}) {
      style.point_px = wanted_px;
      const Image image = renderer.draw(view_along_x(), picture, style);
      EXPECT_NEAR(columns_unlike(image, plain, static_cast<int>(at->y())), wanted_px, 1.6F) << distance_m;
    }
  }
}

TEST(Renderer, LeavesEmptyPaperWhite) {
  BoxWorld world;
  world.add({3, -1, 0}, {5, 1, 2}, kGray);
  Renderer renderer(world.scene(), {});
  PictureStyle style;
  const auto corner = [&] { return color_at(renderer.draw(view_along_x(), {}, style), 2, 2); };
  EXPECT_LT(corner().minCoeff(), 0.97F) << "the sky";
  style.white = true;
  EXPECT_EQ(corner(), Rgb::Ones());
}

TEST(ShownPoints, LieInViewBelowCut) {
  PictureCloud cloud;
  cloud.vehicle = 3;
  cloud.points_world_m = {{5, 0, 1}, {-5, 0, 1}, {5, 0, 4}, {5, 40, 1}, {8, 0, 2}};
  cloud.surface_class = {1, 2, 3, 4, 5};
  cloud.intensity = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F};
  PictureStyle style;
  style.cut_above = true;
  style.cut_height_m = 3.0;
  const std::vector<PictureCloud> shown = shown_of(std::vector{cloud}, view_along_x(), style);
  ASSERT_EQ(shown.size(), 1U);
  EXPECT_EQ(shown[0].vehicle, 3);
  EXPECT_EQ(shown[0].surface_class, (std::vector<std::uint16_t>{1, 5}));
  EXPECT_EQ(shown[0].intensity, (std::vector<float>{0.1F, 0.5F}));
  EXPECT_EQ(shown[0].points_world_m, (std::vector<Eigen::Vector3f>{{5, 0, 1}, {8, 0, 2}}));
}

TEST(Renderer, ShowsAFollowedVehicleThroughLeaves) {
  // A wall of loose leaves between camera and vehicle.
  const Scene scene = leaf_wall(0.4F, 20, -3.0F);
  Renderer renderer(scene, std::vector{make_test_shape()});
  PictureScene picture;
  picture.states.resize(1);
  picture.states[0].p_world_m = {9.0, 0.0, 1.0};
  const View view = view_along_x();
  PictureStyle style;
  EXPECT_TRUE(is_dominated_by(color_at(renderer.draw(view, picture, style), 60, 60), 1));
  style.watched = {0};
  const Image image = renderer.draw(view, picture, style);
  EXPECT_TRUE(is_dominated_by(color_at(image, 80, 61), 0)) << "the vehicle";
  EXPECT_TRUE(is_dominated_by(color_at(image, 22, 60), 1)) << "leaves beside the line of sight stay";
}

}  // namespace
}  // namespace swiftlet::sim
