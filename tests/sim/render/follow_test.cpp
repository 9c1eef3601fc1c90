// SPDX-License-Identifier: BSD-3-Clause
// Cameras beside a second way to do the same: slow, plain, and without a frame of its own.
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

TEST(View, HasALevelHorizonAndSeesWhatThePinholeSees) {
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

TEST(View, BeginsFiveCentimetersBeforeTheEye) {
  const View view = perspective_view({0, 0, 0}, {1, 0, 0}, 60.0, 200, 100);
  EXPECT_FALSE(view.project({0.0499, 0, 0}));
  EXPECT_TRUE(view.project({0.0501, 0, 0}));
  EXPECT_EQ(view.pixels_per_m(0.0), view.pixels_per_m(0.05)) << "nothing is nearer";
  EXPECT_GT(view.pixels_per_m(0.05), view.pixels_per_m(0.06));
  EXPECT_EQ(view.far_m, 2000.0);
}

TEST(View, StraightDownHasNorthUpAndAlongTheHintXAtTheRight) {
  const View down = perspective_view({1, 2, 10}, {1, 2, 0}, 90.0, 200, 100);
  EXPECT_TRUE(down.project({2, 2, 0})->head<2>().isApprox(Eigen::Vector2d(105, 50), 1e-9)) << "east is at the right";
  EXPECT_TRUE(down.project({1, 3, 0})->head<2>().isApprox(Eigen::Vector2d(100, 45), 1e-9)) << "north is up";
  const View along = perspective_view({0, -10, 0}, {0, 0, 0}, 90.0, 200, 100, Vector3d::UnitY());
  EXPECT_TRUE(along.project({1, 0, 0})->head<2>().isApprox(Eigen::Vector2d(105, 50), 1e-9));
  EXPECT_TRUE(along.project({0, 0, 1})->head<2>().isApprox(Eigen::Vector2d(100, 45), 1e-9));
}

TEST(View, FromTheTopSeesAllBetweenItsHeights) {
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

/// A follow camera told in words: where it stands is an azimuth, an elevation and a share of its distance.
class PlainFollower {
 public:
  PlainFollower(const CameraConfig& config, VehicleId vehicle, std::vector<float> radii_m, BlocksSight blocks)
      : config_(config), vehicle_(vehicle), radii_m_(std::move(radii_m)), blocks_(std::move(blocks)) {
    const Vector3d d = config.position_m.normalized();
    home_ = goal_ = now_ = {std::atan2(d.y(), d.x()), std::asin(d.z()), 1.0};
  }

  void update(double t_s, const std::vector<Vector3d>& places) {
    const double dt_s = began_ ? t_s - t_s_ : 1e9;
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (is_watched(i)) box.extend(places[i]);
    }
    target_ += (1.0 - std::exp(-dt_s / 1.2)) * (box.center() - target_);
    if (!began_ || t_s - judged_s_ > 0.2 - 1e-9) judge(t_s, places);
    const double turn = 1.0 - std::exp(-dt_s / 0.7);
    now_.azimuth += turn * std::remainder(goal_.azimuth - now_.azimuth, 2.0 * M_PI);
    now_.elevation += turn * (goal_.elevation - now_.elevation);
    now_.reach += turn * (goal_.reach - now_.reach);
    const double needed_m = distance(now_, places);
    distance_m_ = std::max(needed_m, distance_m_ + (1.0 - std::exp(-dt_s / 1.2)) * (needed_m - distance_m_));
    t_s_ = t_s;
    began_ = true;
  }

  Vector3d eye() const { return target_ + distance_m_ * direction(now_); }

 private:
  struct Stand {
    double azimuth = 0.0, elevation = 0.0, reach = 1.0;
    bool operator==(const Stand&) const = default;
  };

  bool is_watched(std::size_t i) const { return vehicle_ == kNoVehicle || static_cast<int>(i) == vehicle_; }
  double radius(std::size_t i) const { return i < radii_m_.size() ? radii_m_[i] : 0.5; }
  static Vector3d direction(const Stand& s) {
    return {std::cos(s.elevation) * std::cos(s.azimuth), std::cos(s.elevation) * std::sin(s.azimuth),
            std::sin(s.elevation)};
  }

  /// A quarter of room around each vehicle: a ball 1.25 times as large, 1.25 times as far aside, touches no edge.
  double distance(const Stand& stand, const std::vector<Vector3d>& places) const {
    const auto [right, up, back] = axes_of(direction(stand));
    const double tan_y = std::tan(0.5 * config_.fov_deg * kRad);
    const double tan_x = tan_y * config_.width_px / config_.height_px;
    double most_m = stand.reach * config_.position_m.norm();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!is_watched(i)) continue;
      const Vector3d p = places[i] - target_;
      for (const auto& [aside, tangent] : {std::pair(p.dot(right), tan_x), std::pair(p.dot(up), tan_y)}) {
        const double to_edge = 1.25 * radius(i) * std::sqrt(1.0 + tangent * tangent);  // along the aside
        most_m = std::max(most_m, p.dot(back) + (1.25 * std::abs(aside) + to_edge) / tangent);
      }
    }
    return most_m;
  }

  double seen(const Stand& stand, const std::vector<Vector3d>& places) const {
    const auto [right, up, back] = axes_of(direction(stand));
    const Vector3d eye = target_ + distance(stand, places) * back;
    double seen = 0.0, asked = 0.0;
    int judged = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!is_watched(i) || ++judged > 8) continue;
      const double r = 0.8 * radius(i);
      for (const Vector3d& p : {places[i], Vector3d(places[i] + r * right), Vector3d(places[i] - r * right),
                                Vector3d(places[i] + r * up), Vector3d(places[i] - r * up)}) {
        seen += blocks_(p, eye) ? 0.0 : 1.0;
        asked += 1.0;
      }
    }
    return asked > 0.0 ? seen / asked : 1.0;
  }

  /// Turned by up to half a turn in steps of 20 deg, up to 60 deg higher, or nearer: what costs the least of the well
  /// seen.
  Stand best(const std::vector<Vector3d>& places) const {
    std::vector<std::pair<double, Stand>> list;
    for (int turn = -9; turn <= 9; ++turn) {
      for (const int raised : {0, 15, -15, 30, 45, 60}) {
        for (const double reach : {1.0, 0.6, 0.35}) {
          const Stand stand{home_.azimuth + turn * 20.0 * kRad, home_.elevation + raised * kRad, reach};
          if ((raised > 0 && stand.elevation > 80.0 * kRad) || (raised < 0 && stand.elevation < 5.0 * kRad)) continue;
          const double turned = std::abs(std::remainder(stand.azimuth - goal_.azimuth, 2.0 * M_PI));
          list.push_back({std::abs(turn) / 4.5 + std::abs(raised) / 50.0 + 1.5 * (1.0 - reach) + 0.4 * turned, stand});
        }
      }
    }
    std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    Stand chosen = home_;
    double most = -1.0;
    for (const auto& [cost, stand] : list) {
      const double share = seen(stand, places);
      if (share > most) most = share, chosen = stand;
      if (share >= 0.8) break;
    }
    return chosen;
  }

  void judge(double t_s, const std::vector<Vector3d>& places) {
    judged_s_ = t_s;
    const bool at_home = goal_ == home_, is_free = seen(home_, places) >= 0.6;
    if (!is_free) free_since_s_ = 1e9;
    if (is_free) free_since_s_ = std::min(free_since_s_, t_s);
    if (!(at_home && is_free)) {
      if (is_free && (!began_ || t_s - free_since_s_ > 2.0 - 1e-9)) {
        goal_ = home_;
      } else if (at_home || seen(goal_, places) < 0.6) {
        goal_ = best(places);
      }
    }
    if (!began_) now_ = goal_;
  }

  CameraConfig config_;
  VehicleId vehicle_;
  std::vector<float> radii_m_;
  BlocksSight blocks_;
  Stand home_, goal_, now_;
  double t_s_ = 0.0, judged_s_ = 0.0, free_since_s_ = 1e9, distance_m_ = 0.0;
  Vector3d target_ = Vector3d::Zero();
  bool began_ = false;
};

/// Walls that stand and go: some directions of sight are blocked for a while, some parts of a vehicle as well.
BlocksSight walls(const double& t_s, std::uint32_t number, double share) {
  return [&t_s, number, share](const Vector3d& a, const Vector3d& b) {
    const Vector3d d = (b - a).normalized();
    const auto cell = [](double x) { return static_cast<std::uint32_t>(static_cast<int>(std::floor(x)) + 1000); };
    const std::uint32_t sector = cell(4.0 * std::atan2(d.y(), d.x())) * 64U + cell(5.0 * d.z()) % 64U;
    const auto while_s = cell(t_s / 1.7);
    const double of_direction = Random(number, "test.walls").uniform(0.0, 1.0, sector, while_s);
    const double of_place = Random(number, "test.walls").uniform(0.0, 1.0, cell(3.1 * a.z()), 7U + cell(2.3 * a.x()));
    return of_direction < share || of_place < 0.15;
  };
}

void compare_with_plain(const CameraConfig& config, VehicleId vehicle, std::size_t count, double blocked) {
  for (const std::uint32_t number : {1U, 2U, 3U}) {
    const std::vector<float> radii_m(count > 2 ? count - 1 : count, 0.45F);  // the last one's is not known
    double t_s = 0.0;
    const BlocksSight blocks = walls(t_s, number, blocked);
    Cameraman cameraman(config, vehicle, radii_m, kWorld, blocks);
    PlainFollower plain(config, vehicle, radii_m, blocks);
    const Random random(number, "test.paths");
    for (int k = 0; k < 260; ++k) {
      t_s = 0.04 * k;
      std::vector<Vector3d> places;
      for (std::size_t v = 0; v < count; ++v) {
        const auto n = static_cast<std::uint32_t>(v);
        const double pace = random.uniform(0.2, 1.0, n, 0), spread = random.uniform(0.5, 6.0, n, 1);
        places.emplace_back(spread * std::cos(pace * t_s + n), spread * std::sin(1.3 * pace * t_s),
                            3.0 + std::sin(t_s + n));
        if (k > 130) places.back() += Vector3d(4.0, -2.0, 0.5);  // a leap
      }
      const auto states = states_at(places, t_s);
      cameraman.update(from_seconds(t_s), states);
      plain.update(t_s, places);
      PictureScene picture;
      picture.t = from_seconds(t_s);
      picture.states = states;
      ASSERT_LT((cameraman.view(picture).eye_world_m - plain.eye()).norm(), 1e-6) << number << " at " << t_s;
    }
  }
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

TEST(Cameraman, FollowsAsThePlainOneDoesWhenNothingIsInTheWay) {
  compare_with_plain(follow_camera({-9, 3, 4}), 0, 1, -1.0);
  compare_with_plain(follow_camera({-2, 3, 1}), kNoVehicle, 4, -1.0);
}

TEST(Cameraman, GoesRoundWhatIsInTheWayAsThePlainOneDoes) {
  compare_with_plain(follow_camera({-6, 2, 4}), 1, 2, 0.5);
  compare_with_plain(follow_camera({-7, -7, 5}), kNoVehicle, 3, 0.6);
  compare_with_plain(follow_camera({3, 2, 9}), 0, 1, 0.7);     // steep: 60 deg more would be over the top
  compare_with_plain(follow_camera({8, -3, 1.0}), 0, 1, 0.7);  // low: 15 deg less would be in the ground
  compare_with_plain(follow_camera({-7, -7, 5}), kNoVehicle, 11, 0.5);
}

// From the south-west and a little above, so near that the vehicle takes 18 % of the picture's height.
TEST(Cameraman, StandsByTheSizeOfItsVehicleWhenNoPlaceIsGiven) {
  PictureScene picture;
  picture.states = states_at({{1, 2, 3}, {9, 9, 9}}, 0.0);
  for (const float radius_m : {0.1F, 0.4F, 3.0F}) {
    const View view = Cameraman(follow_camera(Vector3d::Zero()), 0, {radius_m, 7.0F}, kWorld).view(picture);
    const Vector3d offset = view.eye_world_m - Vector3d(1, 2, 3);
    EXPECT_NEAR(2.0 * radius_m * view.pixels_per_m(offset.norm()), 0.18 * 200.0, 0.5) << radius_m;
    EXPECT_NEAR(offset.x(), offset.y(), 1e-9);
    EXPECT_LT(offset.x(), 0.0);
    EXPECT_NEAR(std::asin(offset.z() / offset.norm()), 12.0 * kRad, 1.0 * kRad);
  }
}

TEST(Cameraman, OfNobodyLooksAtTheMiddleOfTheWorld) {
  const View view = Cameraman(follow_camera({-9, 3, 4}), kNoVehicle, {}, kWorld).view(PictureScene());
  EXPECT_TRUE(view.eye_world_m.isApprox(kWorld.center() + Vector3d(-9, 3, 4), 1e-9));
  const View without = Cameraman(follow_camera({-9, 3, 4}), kNoVehicle, {}, {}).view(PictureScene());
  EXPECT_TRUE(without.eye_world_m.isApprox(Vector3d(-9, 3, 6.5), 1e-9)) << "of one of 20 x 20 x 5 m";
}

TEST(Cameraman, StaysWhereItIsWhenItsPictureBecomesWider) {
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

TEST(Cameraman, OnBoardSitsInFrontAndLooksAheadALittleDown) {
  for (const auto type : {CameraConfig::Type::kOnboard, CameraConfig::Type::kDepth}) {
    for (const bool known : {true, false}) {
      CameraConfig config;
      config.type = type;
      PictureScene picture;
      picture.states = states_at({{1, 2, 3}, {4, 5, 6}}, 0.0);
      picture.states[1].q_world_body = Eigen::AngleAxisd(0.3, Vector3d::UnitX());
      const std::vector<float> radii_m = known ? std::vector<float>{0.3F, 0.6F} : std::vector<float>{0.3F};
      const View view = Cameraman(config, 1, radii_m, kWorld).view(picture);
      const Pose T = picture.states[1].T_world_body();
      const double front_m = known ? 0.3 : 0.1;
      EXPECT_TRUE((T.inverse() * view.eye_world_m).isApprox(Vector3d(front_m, 0, 0.05), 1e-6));
      const auto ahead = view.project(T * Vector3d(front_m + 1.0, 0, -0.05));
      ASSERT_TRUE(ahead);
      EXPECT_TRUE(ahead->head<2>().isApprox(Eigen::Vector2d(640, 360), 1e-6));
      // It rolls with the vehicle.
      const auto above = view.project(T * Vector3d(front_m + 1.0, 0, 0.2));
      EXPECT_NEAR(above->x(), 640.0, 1e-6);
    }
  }
}

TEST(Cameraman, ACameraOfAVehicleThatIsNotThereStaysAtTheOrigin) {
  CameraConfig config;
  config.type = CameraConfig::Type::kOnboard;
  config.position_m = {1, 0, 0};
  PictureScene picture;
  picture.states = states_at({{9, 9, 9}}, 0.0);
  for (const VehicleId vehicle : {-1, 1})
    EXPECT_TRUE(Cameraman(config, vehicle, {0.3F}, kWorld).view(picture).eye_world_m.isApprox(Vector3d(1, 0, 0)));
}

TEST(Cameraman, AFixedOneLooksAtTheWorldFromItsSouthWesternSide) {
  for (const double fov_deg : {40.0, 80.0}) {
    CameraConfig config;
    config.type = CameraConfig::Type::kFixed;
    config.fov_deg = fov_deg;
    const View view = Cameraman(config, kNoVehicle, {}, kWorld).view(PictureScene());
    EXPECT_TRUE(view.project(kWorld.center())->head<2>().isApprox(Eigen::Vector2d(640, 360), 1e-6));
    const Vector3d from = view.eye_world_m - kWorld.center();
    EXPECT_NEAR(from.norm() * std::tan(0.5 * fov_deg * kRad), 0.6 * kWorld.diagonal().norm(), 1e-9);
    EXPECT_NEAR(std::atan2(from.y(), from.x()), -130.0 * kRad, 6.0 * kRad) << "a little from the south";
    EXPECT_NEAR(std::asin(from.z() / from.norm()), 31.0 * kRad, 6.0 * kRad);
  }
  CameraConfig placed;
  placed.type = CameraConfig::Type::kFixed;
  placed.position_m = {1, 2, 3};
  EXPECT_EQ(Cameraman(placed, kNoVehicle, {}, kWorld).view(PictureScene()).eye_world_m, Vector3d(1, 2, 3));
}

TEST(Cameraman, FromTheTopShowsAllWithAQuarterOfRoomAndAtLeastTwelveMeters) {
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

TEST(Cameraman, FromTheTopTrailsCountWhereTheyAreDrawn) {
  CameraConfig config;
  config.width_px = config.height_px = 200;
  PictureScene picture;
  picture.states = states_at({{0, 0, 3}, {5, 0, 3}}, 0.0);
  picture.trails_m = {{{0, 30, 1}, {0, 0, 1}}};
  for (const bool trails : {true, false}) {
    config.trails = trails;
    const View view = Cameraman(config, kNoVehicle, {}, kWorld).view(picture);
    EXPECT_NEAR(view.pixels_per_m(1.0), 200.0 / (trails ? 1.25 * 30 + 4 : 12.0), 1e-9);
  }
  config.trails = true;
  EXPECT_NEAR(Cameraman(config, 1, {}, kWorld).view(picture).pixels_per_m(1.0), 200.0 / 12.0, 1e-9)
      << "of the second one there is no trail";
  picture.states.clear();
  EXPECT_TRUE(Cameraman(config, kNoVehicle, {}, kWorld)
                  .view(picture)
                  .project({0, 0, 1})
                  ->head<2>()
                  .isApprox(Eigen::Vector2d(100, 100), 1e-9))
      << "the middle of the world";
}

TEST(Cameraman, FromTheTopASpanIsKeptAroundItsTargetOrItsVehicle) {
  CameraConfig config;
  config.width_px = config.height_px = 200;
  config.span_m = 50.0;
  config.target_m = {7, 8, 0};
  PictureScene picture;
  picture.states = states_at({{0, 0, 3}, {5, 1, 40}, {9, 9, -9}}, 0.0);
  const View all = Cameraman(config, kNoVehicle, {}, kWorld).view(picture);
  EXPECT_NEAR(all.pixels_per_m(1.0), 4.0, 1e-12);
  EXPECT_TRUE(all.project({7, 8, 1})->head<2>().isApprox(Eigen::Vector2d(100, 100), 1e-9));
  const View one = Cameraman(config, 1, {}, kWorld).view(picture);
  EXPECT_TRUE(one.project({5, 1, 1})->head<2>().isApprox(Eigen::Vector2d(100, 100), 1e-9));
  // Two meters above the highest vehicle, two below the lowest.
  EXPECT_NEAR(all.eye_world_m.z(), 43.0, 1e-9);
  EXPECT_NEAR((all.clip_world() * Vector4d(0, 0, -12, 1)).z(), 0.0, 1e-9);
  picture.states.clear();
  const View bare = Cameraman(config, kNoVehicle, {}, kWorld).view(picture);
  EXPECT_NEAR(bare.eye_world_m.z(), 16.0, 1e-9);
  EXPECT_NEAR((bare.clip_world() * Vector4d(0, 0, -1, 1)).z(), 0.0, 1e-9);
}

TEST(Cameraman, FromTheTopInPerspectiveSeesItsSpanOnTheGround) {
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
