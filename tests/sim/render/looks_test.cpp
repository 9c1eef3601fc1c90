// SPDX-License-Identifier: BSD-3-Clause
// What a viewer sees of small scenes: contrast, size and place of what is drawn, measured in pixels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "render_support.hpp"
#include "sim/render/renderer.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

const Rgb kLightGray(0.7F, 0.7F, 0.7F);
const Rgb kBlack(0.02F, 0.02F, 0.02F);

/// From above, `px_per_m` to a meter, of 96 x 96 pixels, at the middle of the scene.
View from_above(double px_per_m) { return top_view({0, 0}, 96.0 / px_per_m, -2.0, 8.0, 96, 96); }

BoxWorld floor_world() {
  BoxWorld world;
  world.add({-30, -30, -1}, {30, 30, 0}, kLightGray);
  return world;
}

/// Of the floor and one kind of vehicle, for all who need no more: a renderer takes longer to make than ten pictures.
Renderer& floor_renderer() {
  static BoxWorld* const world = new BoxWorld(floor_world());
  static Renderer* const renderer = new Renderer(world->scene(), std::vector{make_test_shape()});
  return *renderer;
}

PictureScene with_vehicle(const Eigen::Vector3d& p) {
  PictureScene picture;
  picture.states.resize(1);
  picture.states[0].p_world_m = p;
  return picture;
}

float difference(const Image& a, const Image& b, int x, int y) {
  return (color_at(a, x, y) - color_at(b, x, y)).cwiseAbs().maxCoeff();
}

/// Pixels of a column that differ.
int changed_in_column(const Image& a, const Image& b, int x, float least = 0.08F) {
  int count = 0;
  for (int y = 0; y < a.height; ++y) count += difference(a, b, x, y) > least;
  return count;
}

TEST(Looks, HazeCoversAFifthOfWhatIsAsFarAsTheWorldIsLarge) {
  for (const float size_m : {80.0F, 400.0F}) {
    BoxWorld world;
    const float far_m = size_m - 2.0F, near_m = 2.0F;
    world.add({near_m, 0.2F, -50}, {near_m + 0.5F, 40, 50}, kBlack)
        .add({far_m, -size_m, -50}, {far_m + 0.5F, -0.1F, 50}, kBlack);
    world.scene().bounds_m = Eigen::AlignedBox3d(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(size_m, 0, 0));
    Renderer renderer(world.scene(), {});
    const Image image = renderer.draw(perspective_view({0, 0, 0}, {1, 0, 0}, 40.0, 96, 64), {}, {});
    const Rgb haze(0.83F, 0.88F, 0.92F), near = color_at(image, 20, 32), far = color_at(image, 70, 32);
    const float share = (far - near).sum() / (haze - near).sum();
    EXPECT_NEAR(share, 0.19F, 0.06F) << size_m;
    EXPECT_LT(near.maxCoeff(), 0.25F) << "what is near is clear";
  }
}

TEST(Looks, TrailsAreARibbonWithADarkRimThatFadesTowardsItsPast) {
  Renderer& renderer = floor_renderer();
  const View view = from_above(4.0);  // 24 m
  PictureScene picture = with_vehicle({50.0, 0.0, 1.0});
  picture.states[0].p_world_m = {11.5, 0.0, 1.0};
  const Image plain = renderer.draw(view, picture, {});
  for (int i = 0; i <= 22; ++i)
    picture.trails_m.resize(1), picture.trails_m[0].emplace_back(-11.5F + static_cast<float>(i), 0.0F, 1.0F);
  PictureStyle style;
  const Image drawn = renderer.draw(view, picture, style);
  // At three quarters of its length: 3.2 px of color in a rim of 5.6 px.
  const int x = 70;
  int width = 0, colored = 0;
  for (int y = 30; y < 66; ++y) {
    width += difference(drawn, plain, x, y) > 0.06F;
    colored += is_dominated_by(color_at(drawn, x, y), 0);
  }
  EXPECT_NEAR(width, 6, 1);
  EXPECT_NEAR(colored, 3, 1);
  // Old parts are fainter, yet to be seen.
  const auto redness = [&](int at) {
    float most = 0.0F;
    for (int y = 44; y < 52; ++y) most = std::max(most, color_at(drawn, at, y).x() - color_at(drawn, at, y).y());
    return most;
  };
  EXPECT_GT(redness(80), 0.45F);
  EXPECT_NEAR(redness(3) / redness(80), 0.32F, 0.13F) << "at its very end";
  EXPECT_NEAR(redness(8) / redness(80), 0.34F, 0.14F);
  EXPECT_NEAR(redness(46) / redness(80), 0.7F, 0.15F);
  style.line_scale = 2.0F;
  EXPECT_NEAR(changed_in_column(renderer.draw(view, picture, style), plain, x, 0.06F), 11, 2);
  style.trails = false;
  EXPECT_EQ(changed_in_column(renderer.draw(view, picture, style), plain, x, 0.02F), 0);
}

TEST(Looks, WhatAWallHidesOfVehiclesAndTrailsShinesThroughFaintly) {
  BoxWorld world;
  world.add({4, -3, -3}, {4.5F, 3, 3}, kLightGray).add({30, -60, -60}, {31, 60, 60}, kLightGray);
  Renderer renderer(world.scene(), std::vector{make_test_shape()});
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 96, 72);
  PictureScene picture = with_vehicle({8.0, 1.0, 0.0});
  picture.trails_m = {{{8.0F, -2.0F, 0.0F}}};
  const Image drawn = renderer.draw(view, picture, {});
  PictureStyle hidden;
  hidden.hidden_vehicle = 0;
  hidden.trails = false;
  const Image plain = renderer.draw(view, picture, hidden);
  const Eigen::Vector3d vehicle = *view.project({8.0, 1.0, 0.0}), trail = *view.project({8.0, -0.5, 0.0});
  const auto share = [&](const Eigen::Vector3d& at) {  // of the vehicle's color in what is seen
    const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
    const Rgb from = color_at(plain, x, y), to = vehicle_color(0);
    return (color_at(drawn, x, y) - from).dot(to - from) / (to - from).squaredNorm();
  };
  EXPECT_GT(share(vehicle), 0.2F);
  EXPECT_LT(share(vehicle), 0.85F);
  EXPECT_NEAR(share(trail), 0.3F, 0.15F);
  EXPECT_GT(share(trail), 0.1F);
}

TEST(Looks, PointsOfACloudAreSevenCentimetersWideAndTwoPixelsAtLeast) {
  Renderer& renderer = floor_renderer();
  PictureStyle style;
  style.cloud = CloudColors::kLabel;
  for (const auto& [px_per_m, expected] : {std::pair(100.0, 7.0), {10.0, 2.2}}) {
    const View view = from_above(px_per_m);
    PictureScene picture;
    const Image plain = renderer.draw(view, picture, style);
    PictureCloud cloud;
    cloud.points_world_m = {{0.0F, 0.0F, 1.0F}};
    cloud.surface_class = {static_cast<std::uint16_t>(SurfaceClass::kVehicle)};
    picture.clouds = {cloud};
    const Image drawn = renderer.draw(view, picture, style);
    double area = 0.0;
    for (int y = 0; y < 96; ++y) {
      for (int x = 0; x < 96; ++x) area += std::min(1.0F, difference(drawn, plain, x, y) / 0.55F);
    }
    EXPECT_NEAR(2.0 * std::sqrt(area / M_PI), expected, 0.3 * expected) << px_per_m;
  }
}

TEST(Looks, CloudsHaveTheColorsThatTheirStyleNames) {
  Renderer& renderer = floor_renderer();
  const View view = from_above(8.0);
  PictureScene picture;
  picture.clouds.resize(2);
  for (int i = 0; i < 2; ++i) {
    PictureCloud& cloud = picture.clouds[i];
    cloud.vehicle = i + 1;
    for (int k = 0; k < 3; ++k) {
      cloud.points_world_m.emplace_back(-4.0F + 4.0F * static_cast<float>(k), 2.0F - 4.0F * static_cast<float>(i),
                                        1.0F + static_cast<float>(k));
      cloud.intensity.push_back(k == 0 ? -0.5F : k == 1 ? 0.25F : 1.0F);
      cloud.surface_class.push_back(static_cast<std::uint16_t>(k == 0 ? SurfaceClass::kTrunk : SurfaceClass::kMarking));
    }
  }
  PictureStyle style;
  style.point_px = 8.0F;
  const auto color = [&](int cloud, int point) {
    const Eigen::Vector3d at = *view.project(picture.clouds[cloud].points_world_m[point].cast<double>());
    return color_at(renderer.draw(view, picture, style), static_cast<int>(at.x()), static_cast<int>(at.y()));
  };
  const auto expect_color = [&](int cloud, int point, const Rgb& expected) {
    EXPECT_LT((color(cloud, point) - expected).cwiseAbs().maxCoeff(), 0.02F) << cloud << " " << point;
  };
  style.cloud = CloudColors::kVehicle;
  expect_color(0, 1, vehicle_color(1));
  expect_color(1, 1, vehicle_color(2));
  style.cloud = CloudColors::kLabel;
  expect_color(0, 0, class_color(static_cast<std::uint16_t>(SurfaceClass::kTrunk)));
  expect_color(1, 2, class_color(static_cast<std::uint16_t>(SurfaceClass::kMarking)));
  style.cloud = CloudColors::kIntensity;
  expect_color(0, 0, viridis_like(0.0F));
  expect_color(0, 1, viridis_like(0.5F));  // the root of a quarter
  expect_color(0, 2, viridis_like(1.0F));
  style.cloud = CloudColors::kHeight;
  style.heights = HeightScale{1.0F, 5.0F};
  expect_color(0, 1, height_color(0.25F));
  expect_color(1, 2, height_color(0.5F));
  style.heights.reset();
  expect_color(0, 1, height_color(0.5F));
  expect_color(0, 2, height_color(1.0F));
  picture.clouds[0].intensity.pop_back();
  style.cloud = CloudColors::kIntensity;
  const Rgb unknown = color(0, 2);
  EXPECT_NEAR(unknown.x(), 0.9F, 0.06F) << "light gray where nobody knows";
  EXPECT_EQ(unknown.x(), unknown.z());
}

TEST(Looks, ScaleOfHeightsLeavesOutOneInAHundredAtBothEnds) {
  PictureCloud cloud;
  for (int i = 0; i < 1000; ++i) {
    const float z = i < 8 ? -50.0F : i < 992 ? 0.01F * static_cast<float>(i) : 90.0F;
    cloud.points_world_m.emplace_back(0.0F, 0.0F, z);
  }
  const HeightScale scale = height_scale_of(std::vector{cloud});
  EXPECT_NEAR(scale.low_m, 0.09F, 0.03F);
  EXPECT_NEAR(scale.high_m, 9.89F, 0.03F);
  for (int i = 0; i < 1000; ++i) cloud.points_world_m[i].z() = i < 12 ? -50.0F : i < 986 ? 3.0F : 90.0F;
  EXPECT_EQ(height_scale_of(std::vector{cloud}).low_m, -50.0F);
  EXPECT_EQ(height_scale_of(std::vector{cloud}).high_m, 90.0F);
  for (auto& p : cloud.points_world_m) p.z() = 3.0F;
  EXPECT_EQ(height_scale_of(std::vector{cloud}).low_m, 3.0F);
  EXPECT_EQ(height_scale_of(std::vector{cloud}).high_m, 3.5F) << "half a meter at least";
  EXPECT_EQ(height_scale_of({}).high_m, 1.0F);
}

TEST(Looks, PointsOutsideOfTheViewAreNotShown) {
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 90.0, 100, 100);  // a quarter turn both ways
  PictureCloud cloud;
  const std::pair<Eigen::Vector3f, bool> points[] = {
      {{10, 9.9F, 0}, true},   {{10, 10.1F, 0}, false}, {{10, 0, -9.9F}, true}, {{10, 0, -10.1F}, false},
      {{10, 0, 10.1F}, false}, {{0.06F, 0, 0}, true},   {{0.04F, 0, 0}, false}, {{1990, 0, 0}, true},
      {{2010, 0, 0}, false},   {{-5, 0, 0}, false}};
  std::vector<Eigen::Vector3f> expected;
  for (const auto& [p, is_shown] : points) {
    cloud.points_world_m.push_back(p);
    if (is_shown) expected.push_back(p);
  }
  EXPECT_EQ(shown_of(std::vector{cloud}, view, {}).at(0).points_world_m, expected);
  PictureStyle style;
  style.cut_above = true;
  style.cut_height_m = -1.0;
  EXPECT_EQ(shown_of(std::vector{cloud}, view, style).at(0).points_world_m.size(), 1U);
}

TEST(Looks, OfAnOverlayWithoutColorsIsOrangeAndOfFewerTheLastHolds) {
  Renderer& renderer = floor_renderer();
  const View view = from_above(8.0);
  PictureScene picture;
  picture.overlays.push_back({"a", Overlay::Kind::kPoints, {{0, 0, 1}}, {}, 2.0F, {}});
  PictureStyle style;
  style.overlays = {"*"};
  const Rgb orange = color_at(renderer.draw(view, picture, style), 48, 48);
  EXPECT_GT(orange.x(), 0.9F);
  EXPECT_NEAR(orange.y(), 0.75F, 0.15F);
  EXPECT_LT(orange.z(), 0.25F);
  picture.overlays = {
      {"a", Overlay::Kind::kPoints, {{-3, 0, 1}, {0, 0, 1}, {3, 0, 1}}, {{1, 0, 0, 1}, {0, 0, 1, 1}}, 1.0F, {}}};
  const Image image = renderer.draw(view, picture, style);
  EXPECT_TRUE(is_dominated_by(color_at(image, 24, 48), 0));
  EXPECT_TRUE(is_dominated_by(color_at(image, 48, 48), 2));
  EXPECT_TRUE(is_dominated_by(color_at(image, 72, 48), 2));
}

TEST(Looks, TranslucentOverlaysLieOverOpaqueOnesAndFarOnesUnderNearOnes) {
  Renderer& renderer = floor_renderer();
  const View view = from_above(8.0);
  PictureScene picture;
  const Eigen::Vector4f red(1, 0, 0, 0.5F), blue(0, 0, 1, 0.5F), green(0, 1, 0, 1);
  // Named first, drawn last; the higher one over the lower one whatever their order.
  for (const bool turned : {false, true}) {
    Overlay cubes{"cubes", Overlay::Kind::kCubes, {{0, 0, 1}, {0, 0, 4}}, {red, blue}, 2.0F, {}};
    if (turned) std::swap(cubes.positions[0], cubes.positions[1]), std::swap(cubes.colors[0], cubes.colors[1]);
    picture.overlays = {
        cubes, {"below", Overlay::Kind::kTriangles, {{-6, -6, 0.1F}, {6, -6, 0.1F}, {0, 9, 0.1F}}, {green}, 1.0F, {}}};
    PictureStyle style;
    style.overlays = {"*"};
    const Rgb both = color_at(renderer.draw(view, picture, style), 48, 48);
    EXPECT_GT(both.z(), both.x() + 0.1F) << "the near one counts twice as much as the far one";
    EXPECT_GT(both.x(), 0.15F);
    EXPECT_GT(both.y(), 0.1F) << "and what lies below shines through";
  }
}

TEST(Looks, ManyCubesInTwoColorsStayEachWhereTheyAre) {
  Renderer& renderer = floor_renderer();
  const View view = from_above(8.0);
  PictureScene picture;
  Overlay cubes{"cubes", Overlay::Kind::kCubes, {}, {}, 0.8F, {}};
  for (int i = 0; i < 25; ++i) {
    cubes.positions.emplace_back(-4 + 2 * (i % 5), -4 + 2 * (i / 5), 1);
    cubes.colors.push_back(i % 2 == 0 ? Eigen::Vector4f(1, 0, 0, 1) : Eigen::Vector4f(0, 0, 1, 1));
  }
  picture.overlays = {cubes};
  PictureStyle style;
  style.overlays = {"*"};
  const Image image = renderer.draw(view, picture, style);
  for (int i = 0; i < 25; ++i) {
    const Eigen::Vector3d at = *view.project(cubes.positions[i].cast<double>());
    EXPECT_TRUE(
        is_dominated_by(color_at(image, static_cast<int>(at.x()), static_cast<int>(at.y())), i % 2 == 0 ? 0 : 2))
        << i;
    // 0.8 m of 2 m: 6.4 of 16 px, so that 5 px away there is floor.
    EXPECT_FALSE(is_dominated_by(color_at(image, static_cast<int>(at.x()) + 5, static_cast<int>(at.y()) + 5), 0));
    EXPECT_TRUE(is_dominated_by(color_at(image, static_cast<int>(at.x()) + 2, static_cast<int>(at.y()) + 2),
                                i % 2 == 0 ? 0 : 2))
        << i;
  }
}

// ---- Rotors.

/// Width of what is dark in a column of pixels.
int dark_in_column(const Image& image, int x) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) count += brightness(color_at(image, x, y)) < 0.38F;
  return count;
}

TEST(Looks, BladesAreWidestAtAThirdOfTheirLengthAndEndAtTheTip) {
  auto shape = std::make_shared<VehicleShape>();
  shape->materials.push_back({"frame", 0.3F, false, {0.2F, 0.2F, 0.2F}});
  shape->rotors.push_back({{0.0F, 0.0F, 0.4F}, 1.0F, 2, 0.3F, 1.0F});
  shape->circumscribed_radius_m = 1.1F;
  BoxWorld world = floor_world();
  Renderer renderer(world.scene(), std::vector<std::shared_ptr<const VehicleShape>>{shape});
  const View view = top_view({0, 0}, 2.4, -1.0, 4.0, 240, 240);  // 100 px a meter
  const Image image = renderer.draw(view, with_vehicle({0, 0, 2}), {});
  // Shares of the chord of 30 px at shares of the radius.
  for (const auto& [radius, chord] :
       {std::pair(0.17, 0.73), {0.3, 1.0}, {0.5, 0.9}, {0.7, 0.8}, {0.85, 0.575}, {0.98, 0.38}}) {
    for (const double side : {-1.0, 1.0})
      EXPECT_NEAR(dark_in_column(image, static_cast<int>(120 + side * 100 * radius)), 30.0 * chord, 2.5)
          << side * radius;
  }
  EXPECT_EQ(dark_in_column(image, 120 + 102), 0);
  EXPECT_EQ(dark_in_column(image, 120 - 102), 0);
}

struct Slab {
  std::vector<std::array<Eigen::Vector3d, 3>> triangles;

  void quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }
  /// Moeller and Trumbore; 0: no hit.
  double range_m(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    double nearest = 0.0;
    for (const auto& [a, b, c] : triangles) {
      const Eigen::Vector3d ab = b - a, ac = c - a, p = direction.cross(ac), from = origin - a, q = from.cross(ab);
      const double det = ab.dot(p), u = from.dot(p) / det, v = direction.dot(q) / det, range = ac.dot(q) / det;
      if (!(u >= 0 && v >= 0 && u + v <= 1 && range > 0)) continue;
      if (nearest == 0.0 || range < nearest) nearest = range;
    }
    return nearest;
  }
};

/// Slabs that taper from a third of the radius outward and inward; the leading edge is higher.
Slab blades(const VehicleShape::RotorShape& rotor, double angle_rad) {
  Slab slab;
  const double half = 0.06 * rotor.chord_m;
  const double stations[][2] = {{0.04, 0.45}, {0.3, 1.0}, {0.7, 0.8}, {1.0, 0.35}};
  for (int blade = 0; blade < rotor.blades; ++blade) {
    const Eigen::AngleAxisd turn(angle_rad + 2.0 * M_PI * blade / rotor.blades, Eigen::Vector3d::UnitZ());
    const auto corner = [&](int station, double side, double up) -> Eigen::Vector3d {
      const double chord = stations[station][1] * rotor.chord_m;
      return turn * Eigen::Vector3d(stations[station][0] * rotor.radius_m, 0.5 * side * chord,
                                    up * half + 0.06 * side * chord * rotor.direction);
    };
    for (int s = 0; s < 3; ++s) {
      for (const double up : {-1.0, 1.0})
        slab.quad(corner(s, -1, up), corner(s + 1, -1, up), corner(s + 1, 1, up), corner(s, 1, up));
      for (const double side : {-1.0, 1.0})
        slab.quad(corner(s, side, -1), corner(s + 1, side, -1), corner(s + 1, side, 1), corner(s, side, 1));
    }
    slab.quad(corner(3, -1, -1), corner(3, 1, -1), corner(3, 1, 1), corner(3, -1, 1));
  }
  return slab;
}

// From every side, so that no face may be missing or out of place.
TEST(Looks, BladesAreTaperedSlabsPitchedByTheirSenseOfRotation) {
  auto shape = std::make_shared<VehicleShape>();
  shape->materials.push_back({"frame", 0.3F, false, {0.2F, 0.2F, 0.2F}});
  for (int i = 0; i < 2; ++i)
    shape->rotors.push_back({{2.0F * static_cast<float>(i), 0.5F, 0.4F}, 1.0F, 3 - i, 0.6F, i == 0 ? 1.0F : -1.0F});
  shape->circumscribed_radius_m = 3.1F;
  BoxWorld world;
  world.add({200, -1, -1}, {201, 1, 1}, kLightGray);
  Renderer renderer(world.scene(), std::vector<std::shared_ptr<const VehicleShape>>{shape});
  PictureScene picture = with_vehicle({0, 0, 0});
  picture.states[0].q_world_body = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
  picture.states[0].rotor_angle_rad = {0.4, -0.9 - 20.0 * M_PI};
  Slab all;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Isometry3d T = Eigen::Isometry3d(picture.states[0].T_world_body()) *
                                Eigen::Translation3d(shape->rotors[i].hub_body_m.cast<double>());
    for (auto triangle : blades(shape->rotors[i], i == 0 ? 0.4 : -0.9).triangles) {
      for (Eigen::Vector3d& p : triangle) p = T * p;
      all.triangles.push_back(triangle);
    }
  }
  int seen = 0, unlike = 0;
  for (const Eigen::Vector3d& from :
       {Eigen::Vector3d(0, 0, 6), Eigen::Vector3d(0, 0.1, -6), Eigen::Vector3d(6, 1, 0.5), Eigen::Vector3d(-6, 2, 0.8),
        Eigen::Vector3d(1, 6, 0.2), Eigen::Vector3d(1, -6, 1.2), Eigen::Vector3d(4, 4, -2)}) {
    const View view = perspective_view(from, {1, 0.5, 0.4}, 40.0, 80, 60, {0.1, 0.2, 1.0});
    const DepthImage depth = renderer.draw_depth(view, picture, {});
    const Eigen::Matrix3d R = view.T_camera_world.topLeftCorner<3, 3>().transpose();
    for (int y = 0; y < 60; y += 2) {
      for (int x = 0; x < 80; x += 2) {
        const double f = 30.0 / std::tan(20.0 * M_PI / 180.0);
        const auto expected = [&](double dx, double dy) {
          return all.range_m(from, R * Eigen::Vector3d((x + 0.5 + dx - 40.0) / f, -(y + 0.5 + dy - 30.0) / f, -1.0));
        };
        const double here = expected(0, 0);
        // Edges may fall to either side.
        if (std::abs(expected(0.2, 0.2) - here) > 0.05 || std::abs(expected(-0.2, -0.2) - here) > 0.05) continue;
        seen += here > 0.0;
        unlike += std::abs(depth.at(x, y) - here) > 0.02;
      }
    }
  }
  EXPECT_GT(seen, 250);
  EXPECT_LE(unlike, 1);
}

TEST(Looks, RotorsShowDiscsFromThirtyRadiansASecondOnWithABrighterRim) {
  BoxWorld world;
  world.add({-30, -30, -1}, {30, 30, 0}, Rgb(0.05F, 0.05F, 0.05F));
  Renderer renderer(world.scene(), std::vector{make_test_shape()});
  const View view = top_view({0, 0}, 2.4, -1.0, 4.0, 120, 120);  // 50 px a meter, the rotor's radius is a meter
  PictureScene picture = with_vehicle({0, 0, 2});
  const Image still = renderer.draw(view, picture, {});
  const auto veil = [&](const Image& image, double radius) {  // between the blades, which lie along x
    return difference(image, still, 60, static_cast<int>(60 - 50 * radius));
  };
  picture.states[0].rotor_speed_radps[0] = 29.0;
  EXPECT_EQ(veil(renderer.draw(view, picture, {}), 0.7), 0.0F);
  picture.states[0].rotor_speed_radps[0] = 31.0;
  const Image spinning = renderer.draw(view, picture, {});
  EXPECT_GT(veil(spinning, 0.7), 0.05F);
  EXPECT_NEAR(veil(spinning, 0.95) / veil(spinning, 0.7), 1.68F, 0.3F);
  EXPECT_NEAR(veil(spinning, 0.6) / veil(spinning, 0.75), 1.0F, 0.06F) << "the same all over its inside";
  EXPECT_EQ(veil(spinning, 1.05), 0.0F);
  EXPECT_GT(veil(spinning, 0.98), 0.05F);
  EXPECT_LT(veil(spinning, 0.7), 0.25F) << "one sees through it";
  // All the way round.
  for (const double turn : {0.4, 1.1, 2.2, 3.6, 4.5, 5.9}) {
    const int x = static_cast<int>(60 + 50 * 0.9 * std::cos(turn)),
              y = static_cast<int>(60 - 50 * 0.9 * std::sin(turn));
    EXPECT_GT(difference(spinning, still, x, y), 0.05F) << turn;
  }
}

TEST(Looks, VehiclesAreDrawnAtTheirScaleAndTheirShadowsWithThem) {
  Renderer& renderer = floor_renderer();
  const View view = from_above(8.0);
  const PictureScene none;
  for (const double scale : {1.0, 4.0}) {
    PictureStyle style;
    style.vehicle_scale = scale;
    const Image image = renderer.draw(view, with_vehicle({-2, 1, 3}), style);
    const Image plain = renderer.draw(view, none, style);
    int red = 0;
    for (int x = 0; x < 96; ++x) red += is_dominated_by(color_at(image, x, 40), 0);
    EXPECT_NEAR(red, 0.5 * 8.0 * scale, 1.6) << "half a meter of body";
    // Its shadow falls where the sun sends it, and is about as wide.
    const int y = static_cast<int>(48 - 8 * (1 - 0.35 * 3)), middle = static_cast<int>(48 + 8 * (-2 + 0.775 * 3));
    int shaded = 0;
    for (int x = 0; x < 96; ++x)
      shaded += brightness(color_at(image, x, y)) < 0.8F * brightness(color_at(plain, x, y)) &&
                !is_dominated_by(color_at(image, x, y), 0);
    EXPECT_GT(shaded, 0) << scale;
    if (scale < 2.0) {
      EXPECT_LT(brightness(color_at(image, middle, y)), 0.8F * brightness(color_at(plain, middle, y)));
    }
  }
}

// ---- The world.

TEST(Looks, GroundHasAGridOfMetersAndOtherSurfacesHaveNone) {
  BoxWorld world;
  world.add({-30, 0, -1}, {30, 30, 0}, kLightGray, SurfaceClass::kGround)
      .add({-30, -30, -1}, {30, 0, 0}, kLightGray, SurfaceClass::kObject);
  Renderer renderer(world.scene(), {});
  // 16 px to a meter, and the middles of pixels 47 + 16 k at whole meters.
  const Image image = renderer.draw(top_view({0.5 / 16.0, 0}, 6.0, -2.0, 8.0, 96, 96), {}, {});
  for (const bool is_ground : {true, false}) {
    float on = 0.0F, between = 0.0F;
    for (const int x : {15, 31, 63, 79}) {
      for (int i = 4; i < 12; ++i) {
        const int y = is_ground ? i : 95 - i;
        on += brightness(color_at(image, x, y)) / 32.0F;
        between += (brightness(color_at(image, x - 3, y)) + brightness(color_at(image, x + 3, y))) / 64.0F;
      }
    }
    if (is_ground) {
      EXPECT_NEAR(on / between, 0.95F, 0.02F) << "to be seen, but faint";
    } else {
      EXPECT_NEAR(on, between, 0.01F);
    }
  }
}

TEST(Looks, LinesOfTheGroundThatFallBetweenTwoPixelsDarkenBoth) {
  BoxWorld world;
  world.add({-30, -30, -1}, {30, 30, 0}, kLightGray, SurfaceClass::kGround);
  Renderer renderer(world.scene(), {});
  const Image image = renderer.draw(top_view({0, 0}, 6.0, -2.0, 8.0, 96, 96), {}, {});
  float on = 0.0F, between = 0.0F;
  for (const int right : {16, 32, 64, 80}) {  // of a whole meter, which lies on the border before this pixel
    for (int y = 4; y < 12; ++y) {
      on += (brightness(color_at(image, right - 1, y)) + brightness(color_at(image, right, y))) / 64.0F;
      between += (brightness(color_at(image, right - 4, y)) + brightness(color_at(image, right + 3, y))) / 64.0F;
    }
  }
  EXPECT_NEAR(on / between, 0.975F, 0.015F) << "as dark in all as a line in the middle of a pixel";
}

/// How the copies of a mesh differ in color: mean over the faces of many.
TEST(Looks, TreesDifferALittleInColorAndNamelessThingsDoNot) {
  for (const SurfaceClass surface_class : {SurfaceClass::kVegetation, SurfaceClass::kTrunk}) {
    Scene scene;
    scene.materials.push_back({"paint", 0.5F, false, {0.5F, 0.5F, 0.5F}});
    Mesh mesh;
    mesh.surface_class = surface_class;
    add_box(mesh, Eigen::Vector3f(-0.45F, -0.45F, 0), Eigen::Vector3f(0.45F, 0.45F, 0.2F));
    scene.meshes.push_back(mesh);
    for (int i = 0; i < 144; ++i) {
      const Eigen::Vector3f at(static_cast<float>(i % 12) - 5.5F, static_cast<float>(i / 12) - 5.5F, 0);
      scene.instances.push_back(
          {0, Eigen::Affine3f(Eigen::Translation3f(at)), static_cast<std::uint16_t>(i < 12 ? 0 : i)});
      scene.bounds_m.extend(at.cast<double>());
    }
    Renderer renderer(scene, {});
    const Image image = renderer.draw(from_above(8.0), {}, {});
    std::vector<float> lights, reds, blues;
    for (int i = 0; i < 144; ++i) {
      const Rgb color = color_at(image, 4 + 8 * (i % 12), 91 - 8 * (i / 12));
      if (i < 12) {
        EXPECT_LT((color - color_at(image, 4, 91)).cwiseAbs().maxCoeff(), 0.03F);
        continue;
      }
      lights.push_back(color.y());
      reds.push_back(color.x() / color.y());
      blues.push_back(color.z() / color.y());
    }
    const auto spread = [](const std::vector<float>& values) {
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      return *high - *low;
    };
    const float amount = surface_class == SurfaceClass::kVegetation ? 1.0F : 0.5F;
    EXPECT_NEAR(spread(reds), 0.165F * amount, 0.05F * amount) << name_of(surface_class);
    EXPECT_NEAR(spread(blues), 0.20F * amount, 0.06F * amount) << name_of(surface_class);
    EXPECT_GT(spread(lights), 0.06F * amount);
    EXPECT_LT(spread(lights), 0.2F * amount);
  }
}

// A wall of leaves far away: fewer and larger ones cover as much.
TEST(Looks, DistantLeavesCoverAsMuchWithFewerOfThem) {
  Scene scene;
  scene.materials.push_back({"leaves", 0.5F, false, {0.05F, 0.5F, 0.05F}});
  Mesh leaves;
  leaves.surface_class = SurfaceClass::kVegetation;
  for (int i = 0; i < 3000; ++i) {
    const auto a = static_cast<float>(std::fmod(0.7548776662 * i, 1.0)),
               b = static_cast<float>(std::fmod(0.5698402910 * i, 1.0));
    const Eigen::Vector3f at(0, 12.0F * a - 6.0F, 12.0F * b - 6.0F);
    add_quad(leaves, at + Eigen::Vector3f(0, -0.1F, -0.1F), at + Eigen::Vector3f(0, 0.1F, -0.1F),
             at + Eigen::Vector3f(0, 0.1F, 0.1F), at + Eigen::Vector3f(0, -0.1F, 0.1F));
  }
  scene.meshes.push_back(leaves);
  scene.instances.push_back({0, Eigen::Affine3f::Identity(), 1});
  scene.bounds_m = Eigen::AlignedBox3d(Eigen::Vector3d(-60, -6, -6), Eigen::Vector3d(0, 6, 6));
  Renderer renderer(scene, {});
  for (const double distance_m : {6.0, 25.0, 60.0}) {
    const View view =
        perspective_view({-distance_m, 0, 0}, {0, 0, 0}, 2.0 * std::atan(4.0 / distance_m) * 180.0 / M_PI, 96, 96);
    const auto covered = [&](bool reduce) {
      PictureStyle style;
      style.reduce = reduce;
      const Image image = renderer.draw(view, {}, style);
      double sum = 0.0;
      for (int y = 0; y < 96; ++y) {
        for (int x = 0; x < 96; ++x) sum += is_dominated_by(color_at(image, x, y), 1) ? 1.0 : 0.0;
      }
      return sum / (96.0 * 96.0);
    };
    const double all = covered(false), fewer = covered(true);
    EXPECT_GT(all, 0.3);
    EXPECT_NEAR(fewer, all, 0.12) << distance_m;
  }
}

// To the pixel: a square of 40 px around the middle, and a plane up to all four borders.
TEST(Looks, PicturesAreNeitherShiftedNorCutAtTheirBorders) {
  BoxWorld world;
  world.add({-30, -30, -1}, {30, 30, 0}, Rgb(0.2F, 0.2F, 0.9F))
      .add({-2, -2, -0.5F}, {2, 2, 0.001F}, Rgb(0.9F, 0.1F, 0.1F));
  Renderer renderer(world.scene(), {});
  for (const auto& [width, height] : {std::pair(96, 96), {97, 63}}) {
    const View view = top_view({0, 0}, height / 10.0, -2.0, 8.0, width, height);  // 10 px a meter
    for (const bool quick : {false, true}) {
      PictureStyle style;
      style.quick = quick;
      const Image image = renderer.draw(view, {}, style);
      ASSERT_EQ(image.width, width);
      ASSERT_EQ(image.height, height);
      const Rgb blue = color_at(image, 3, 3);
      EXPECT_TRUE(is_dominated_by(blue, 2));
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const double off = std::max(std::abs(x + 0.5 - 0.5 * width), std::abs(y + 0.5 - 0.5 * height)) - 20.0;
          if (std::abs(off) < 0.6) continue;  // on the edge itself
          const Rgb color = color_at(image, x, y);
          ASSERT_EQ(is_dominated_by(color, 0), off < 0.0) << x << " " << y << " " << quick;
          if (off > 3.0) {
            ASSERT_LT((color - blue).cwiseAbs().maxCoeff(), 0.03F) << x << " " << y << " " << quick;
          }
        }
      }
    }
    const DepthImage depth = renderer.draw_depth(view, {}, {});
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) ASSERT_NEAR(depth.at(x, y), 9.0, 0.01) << x << " " << y;
    }
  }
}

// A renderer that has drawn other sizes, styles and depths draws as a new one does.
TEST(Looks, PicturesDoNotDependOnThoseBefore) {
  BoxWorld world = floor_world();
  world.add({2, -2, 0}, {3, 2, 2}, Rgb(0.9F, 0.1F, 0.1F));
  const auto shape = make_test_shape();
  Renderer used(world.scene(), std::vector{shape});
  const PictureScene picture = with_vehicle({1, 0.5, 1});
  PictureStyle quick;
  quick.quick = true;
  const auto view = [](int width, int height) { return perspective_view({-4, 1, 3}, {2, 0, 1}, 60.0, width, height); };
  std::vector<float> first_depth_m;
  std::map<std::pair<int, bool>, Image> alone;
  for (const auto& [height, is_quick] :
       {std::pair(64, false), {48, false}, {48, true}, {64, true}, {64, false}, {48, true}}) {
    const PictureStyle style = is_quick ? quick : PictureStyle{};
    const View its_view = view(height == 64 ? 96 : 64, height);
    const Image drawn = used.draw(its_view, picture, style);
    if (height == 64 || is_quick) {
      Image& expected = alone[{height, is_quick}];
      if (expected.rgb.empty()) expected = Renderer(world.scene(), std::vector{shape}).draw(its_view, picture, style);
      EXPECT_EQ(drawn.rgb, expected.rgb) << height << " " << is_quick;
    }
    const std::vector<float> depth_m = used.draw_depth(view(60, 80), picture, {}).depth_m;
    if (first_depth_m.empty()) first_depth_m = depth_m;
    EXPECT_EQ(depth_m, first_depth_m);
  }
}

// Where a wall meets the floor it is darker, on the side of the sun as well.
TEST(Looks, CornersAreDarkerThanOpenFloor) {
  BoxWorld world = floor_world();
  world.add({0, -6, 0}, {0.5F, 6, 3}, kLightGray);
  Renderer renderer(world.scene(), {});
  const View view = perspective_view({-6, 0, 5}, {0, 0, 0}, 40.0, 96, 96);
  const Image image = renderer.draw(view, {}, {});
  const auto floor = [&](double x, double y) {
    const Eigen::Vector3d at = *view.project({x, y, 0.0});
    return brightness(color_at(image, static_cast<int>(at.x()), static_cast<int>(at.y())));
  };
  for (const double y : {-0.7, 0.0, 0.7}) {
    EXPECT_LT(floor(-0.15, y), 0.97F * floor(-2.0, y)) << y;
    EXPECT_GT(floor(-0.15, y), 0.6F * floor(-2.0, y)) << "it is no shadow";
    EXPECT_NEAR(floor(-1.6, y), floor(-2.0, y), 0.02F) << "as far as 0.9 m from the wall";
  }
}

// A hole in the leaves, 0.4 m and 1.6 of its radius wide where the vehicle is, narrower towards the camera.
TEST(Looks, LeavesBeforeAFollowedVehicleAreLeftOutAsFarAsItReaches) {
  const Scene scene = leaf_wall(0.2F, 40, -4.0F);
  auto shape = std::make_shared<VehicleShape>(*make_test_shape());
  shape->circumscribed_radius_m = 0.5F;
  Renderer renderer(scene, std::vector<std::shared_ptr<const VehicleShape>>{shape});
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 96, 72);
  PictureScene picture = with_vehicle({9.0, 0.0, 0.0});
  picture.states.resize(3);  // two more than have a shape
  picture.states[1].p_world_m = picture.states[2].p_world_m = {9.0, 2.0, 0.0};
  for (const double scale : {1.0, 2.0}) {
    PictureStyle style;
    style.vehicle_scale = scale;
    style.watched = {-1, 0, 2, 7};
    const Image image = renderer.draw(view, picture, style);
    const double radius_m = (0.4 + 1.6 * 0.5 * scale) * (0.7 + 0.3 * 5.0 / 9.0);
    for (const double side : {-1.0, 1.0}) {
      for (const auto& [y, is_free] : {std::pair(0.72 * radius_m, true), {1.25 * radius_m, false}}) {
        const Eigen::Vector3d at = *view.project({5.0, side * y, 0.02});
        EXPECT_EQ(is_dominated_by(color_at(image, static_cast<int>(at.x()), static_cast<int>(at.y())), 1), !is_free)
            << side * y << " " << scale;
      }
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
