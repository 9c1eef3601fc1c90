// SPDX-License-Identifier: BSD-3-Clause
// Pictures of small scenes: visibility, color, size and position of the drawn objects, measured in pixels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "render_support.hpp"
#include "sim/render/renderer.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

const Rgb kLightGray(0.7F, 0.7F, 0.7F);

/// Top view of the center of the scene, 96 x 96 pixels.
View from_above(double px_per_m) { return top_view({0, 0}, 96.0 / px_per_m, -2.0, 8.0, 96, 96); }

BoxWorld floor_world() {
  BoxWorld world;
  world.add({-30, -30, -1}, {30, 30, 0}, kLightGray);
  return world;
}

/// Renderer of the floor and one vehicle shape, shared by the tests, because its creation takes longer than ten
/// pictures.
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

TEST(Renderer, ShowsOccludedVehiclesAndTrailsFaintly) {
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
  const auto share = [&](const Eigen::Vector3d& at) {  // weight of the vehicle's color in the drawn pixel
    const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
    const Rgb from = color_at(plain, x, y), to = vehicle_color(0);
    return (color_at(drawn, x, y) - from).dot(to - from) / (to - from).squaredNorm();
  };
  EXPECT_GT(share(vehicle), 0.2F);
  EXPECT_LT(share(vehicle), 0.85F);
  EXPECT_NEAR(share(trail), 0.3F, 0.15F);
  EXPECT_GT(share(trail), 0.1F);
}

TEST(Renderer, ColorsCloudsByStyle) {
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
  expect_color(0, 1, viridis_like(0.5F));  // intensities are colored by their square root
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
  EXPECT_NEAR(unknown.x(), 0.9F, 0.06F) << "light gray without a reflectivity";
  EXPECT_EQ(unknown.x(), unknown.z());
}

TEST(Renderer, BlendsTranslucentOverlaysInDepthOrder) {
  Renderer& renderer = floor_renderer();
  const View view = from_above(8.0);
  PictureScene picture;
  const Eigen::Vector4f red(1, 0, 0, 0.5F), blue(0, 0, 1, 0.5F), green(0, 1, 0, 1);
  // Translucent cubes are listed first, but drawn after opaque overlays, and the higher cube after the lower one in
  // either order.
  for (const bool swapped : {false, true}) {
    Overlay cubes{"cubes", Overlay::Kind::kCubes, {{0, 0, 1}, {0, 0, 4}}, {red, blue}, 2.0F, {}};
    if (swapped) std::swap(cubes.positions[0], cubes.positions[1]), std::swap(cubes.colors[0], cubes.colors[1]);
    picture.overlays = {
        cubes, {"below", Overlay::Kind::kTriangles, {{-6, -6, 0.1F}, {6, -6, 0.1F}, {0, 9, 0.1F}}, {green}, 1.0F, {}}};
    PictureStyle style;
    style.overlays = {"*"};
    const Rgb both = color_at(renderer.draw(view, picture, style), 48, 48);
    EXPECT_GT(both.z(), both.x() + 0.1F) << "the near cube has twice the weight of the far one";
    EXPECT_GT(both.x(), 0.15F);
    EXPECT_GT(both.y(), 0.1F) << "the opaque triangle below both is visible";
  }
}

// Checked to the pixel: a square of 40 px is centered in the picture, and the floor reaches all four borders.
TEST(Renderer, NeitherShiftsNorCropsPictures) {
  BoxWorld world;
  world.add({-30, -30, -1}, {30, 30, 0}, Rgb(0.2F, 0.2F, 0.9F))
      .add({-2, -2, -0.5F}, {2, 2, 0.001F}, Rgb(0.9F, 0.1F, 0.1F));
  Renderer renderer(world.scene(), {});
  for (const auto& [width, height] : {std::pair(96, 96), {97, 63}}) {
    const View view = top_view({0, 0}, height / 10.0, -2.0, 8.0, width, height);  // 10 px per meter
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
          if (std::abs(off) < 0.6) continue;  // pixel on the square's edge, with a blended color
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

// A renderer draws the same picture as a new one, whatever sizes, styles and depth images it has drawn before.
TEST(Renderer, DrawsIndependentlyOfEarlierPictures) {
  BoxWorld world = floor_world();
  world.add({2, -2, 0}, {3, 2, 2}, Rgb(0.9F, 0.1F, 0.1F));
  const auto shape = make_test_shape();
  Renderer used(world.scene(), std::vector{shape});
  const PictureScene picture = with_vehicle({1, 0.5, 1});
  PictureStyle quick;
  quick.quick = true;
  const auto view = [](int width, int height) { return perspective_view({-4, 1, 3}, {2, 0, 1}, 60.0, width, height); };
  std::vector<float> first_depth_m;
  std::map<std::pair<int, bool>, Image> by_new_renderer;
  for (const auto& [height, is_quick] :
       {std::pair(64, false), {48, false}, {48, true}, {64, true}, {64, false}, {48, true}}) {
    const PictureStyle style = is_quick ? quick : PictureStyle{};
    const View same_view = view(height == 64 ? 96 : 64, height);
    const Image drawn = used.draw(same_view, picture, style);
    if (height == 64 || is_quick) {
      Image& expected = by_new_renderer[{height, is_quick}];
      if (expected.rgb.empty()) expected = Renderer(world.scene(), std::vector{shape}).draw(same_view, picture, style);
      EXPECT_EQ(drawn.rgb, expected.rgb) << height << " " << is_quick;
    }
    const std::vector<float> depth_m = used.draw_depth(view(60, 80), picture, {}).depth_m;
    if (first_depth_m.empty()) first_depth_m = depth_m;
    EXPECT_EQ(depth_m, first_depth_m);
  }
}

}  // namespace
}  // namespace swiftlet::sim
