// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/scan_to_map.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "swiftlet/core/localization/rotation.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

using testing::SyntheticRoom;

/// Points on the walls of a room as seen from a pose, in the world (which is the local frame here).
std::vector<Vector3> seen_from(const SyntheticRoom& room, const Pose& T_world_body, double sigma_m, unsigned seed,
                               int num = 8000) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<Vector3> points;
  points.reserve(num);
  for (int i = 0; i < num; ++i) {
    const Vector3 d = Vector3(normal(random), normal(random), normal(random)).normalized();
    const double range_m = room.range_m(T_world_body.translation(), d);
    if (range_m < 40.0) points.push_back(T_world_body.translation() + (range_m + sigma_m * normal(random)) * d);
  }
  return points;
}

std::vector<Eigen::Vector3f> in_body(const std::vector<Vector3>& points_world_m, const Pose& T_world_body) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(points_world_m.size());
  for (const Vector3& p : points_world_m) points.push_back((T_world_body.inverse() * p).cast<float>());
  return points;
}

const SyntheticRoom kRoom = SyntheticRoom::box({-5.3, -4.1, -0.2}, {6.4, 5.2, 3.7});

TEST(SurfaceMap, FindsPlaneAndScatterOfWalls) {
  SurfaceMap map({});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-4.0, 4.0);
  std::normal_distribution<double> normal(0.0, 0.02);
  const Vector3 n = Vector3(1.0, 0.5, -0.2).normalized();
  const Vector3 u = n.unitOrthogonal(), w = n.cross(u);
  std::vector<Vector3> points;
  points.reserve(4000);
  for (int i = 0; i < 4000; ++i)
    points.push_back((3.0 + normal(random)) * n + uniform(random) * u + uniform(random) * w);
  map.insert(points, Vector3::Zero());
  int planar = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector3 at = 3.0 * n + uniform(random) * u + uniform(random) * w;
    const SurfaceCell* cell = map.find(at, Vector3::Zero());
    ASSERT_NE(cell, nullptr);
    if (!cell->planar || cell->count_fitted < 30.0F) continue;
    ++planar;
    EXPECT_GT(std::abs(cell->normal.cast<double>().dot(n)), std::cos(0.05));
    EXPECT_NEAR(cell->normal.cast<double>().dot(at - cell->mean_m.cast<double>()), 0.0, 0.04);
    EXPECT_NEAR(std::sqrt(cell->variance_m2), 0.02, 0.008);
  }
  EXPECT_GT(planar, 400);
  EXPECT_EQ(map.find(Vector3(50.0, 0.0, 0.0), Vector3::Zero()), nullptr);
}

TEST(SurfaceMap, SubdividesOnlyWherePlanesAreMissing) {
  SurfaceMap map({});
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0.0, 10.0);
  const auto insert_wall = [&] {
    std::vector<Vector3> points;
    points.reserve(5000);
    for (int i = 0; i < 5000; ++i) points.emplace_back(0.5, uniform(random), uniform(random));
    map.insert(points, Vector3::Zero());
  };
  for (int i = 0; i < 4; ++i) insert_wall();
  const std::size_t known = map.num_cells();
  for (int i = 0; i < 10; ++i) insert_wall();
  EXPECT_LT(map.num_cells(), known + known / 50) << "a plane makes nothing new";
  // A bush in front of it has none.
  std::vector<Vector3> bush;
  bush.reserve(5000);
  for (int i = 0; i < 5000; ++i) bush.emplace_back(1.0 + 0.2 * uniform(random), 0.2 * uniform(random), uniform(random));
  for (int i = 0; i < 3; ++i) map.insert(bush, Vector3::Zero());
  EXPECT_GT(map.num_cells(), known + 500);
}

TEST(SurfaceMap, DistinguishesStemsFromWallsAndLogs) {
  SurfaceMap map({});
  std::mt19937 random(6);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal(0.0, 0.02);
  std::vector<Vector3> points;
  points.reserve(3000);
  for (int i = 0; i < 1000; ++i) {
    points.emplace_back(5.0 + 3.0 * normal(random), 5.0 + normal(random), 6.0 * uniform(random));
    points.emplace_back(15.0 + 6.0 * uniform(random), 5.0 + 3.0 * normal(random), 1.0 + normal(random));
    points.emplace_back(25.0 + normal(random), 6.0 * uniform(random), 6.0 * uniform(random));
  }
  map.insert(points, Vector3::Zero());
  const SurfaceCell* stem = map.find_pole({5.0, 5.0, 3.0});
  ASSERT_NE(stem, nullptr);
  EXPECT_GT(std::abs(stem->axis.z()), 0.99F);
  EXPECT_GT(std::abs(stem->normal.y()), 0.95F) << "across it is thinnest along y";
  EXPECT_GT(std::abs(stem->aside().x()), 0.95F);
  EXPECT_EQ(map.find_pole({18.0, 5.0, 1.0}), nullptr) << "lies";
  EXPECT_EQ(map.find_pole({25.0, 3.0, 3.0}), nullptr) << "is a plane";
  EXPECT_EQ(map.find_pole({5.0, 50.0, 3.0}), nullptr) << "not seen";
}

TEST(ScanToMap, RecoversAKnownMotion) {
  SurfaceMap map({});
  for (unsigned seed = 1; seed <= 4; ++seed)
    map.insert(seen_from(kRoom, Pose::Identity(), 0.02, seed), Vector3::Zero());
  const Pose T_true = make_pose({0.15, -0.1, 0.08}, rotation_by({0.02, -0.03, 0.06}));
  const auto points = in_body(seen_from(kRoom, T_true, 0.02, 9), T_true);
  InertialConfig wide;
  wide.start_velocity_sigma_mps = 50.0;  // a prediction over 4 ms carries no information
  wide.gyro_noise_radps_sqrt_hz = 20.0;
  InertialFilter filter(wide, Pose::Identity());
  filter.predict({4'000'000, Vector3::Zero(), {0, 0, 9.81}});
  filter.predict({8'000'000, Vector3::Zero(), {0, 0, 9.81}});
  filter.update([&](const Pose& T) { return fit_scan(map, points, T, {}).evidence; }, 20);
  EXPECT_LT((filter.T_local_body().translation() - T_true.translation()).norm(), 0.004);
  EXPECT_LT(
      rotation_vector_rad(Eigen::Quaterniond(filter.T_local_body().linear().transpose() * T_true.linear())).norm(),
      0.0015);
}

TEST(ScanToMap, RepeatsBitwiseWithAReusedFitter) {
  SurfaceMap room_map({}), other_map({});
  room_map.insert(seen_from(kRoom, Pose::Identity(), 0.02, 1), Vector3::Zero());
  other_map.insert(seen_from(kRoom, Pose::Identity(), 0.05, 2, 300), Vector3::Zero());
  const auto many = in_body(seen_from(kRoom, Pose::Identity(), 0.02, 3), Pose::Identity());
  const std::vector<Eigen::Vector3f> few(many.begin(), many.begin() + 200);
  ScanFitter fitter;
  for (const SurfaceMap* map : {&room_map, &other_map, &room_map}) {
    for (const auto& points : {few, many, few}) {
      const ScanFit again = fitter.fit(*map, points, Pose::Identity(), {}),
                    once = fit_scan(*map, points, Pose::Identity(), {});
      EXPECT_EQ(again.evidence.information, once.evidence.information);
      EXPECT_EQ(again.evidence.gradient, once.evidence.gradient);
      EXPECT_EQ(again.map_share, once.map_share);
    }
  }
}

TEST(ScanToMap, CountsOpenDirectionsOfScans) {
  const auto degenerate = [](const SyntheticRoom& room) {
    SurfaceMap map({});
    for (unsigned seed = 1; seed <= 4; ++seed)
      map.insert(seen_from(room, Pose::Identity(), 0.02, seed), Vector3::Zero());
    const ScanFit fit =
        fit_scan(map, in_body(seen_from(room, Pose::Identity(), 0.02, 9), Pose::Identity()), Pose::Identity(), {});
    EXPECT_EQ(fit.num_held, 0) << "nothing stands free in it";
    return fit.num_degenerate;
  };
  EXPECT_EQ(degenerate(kRoom), 0);
  SyntheticRoom aisle = kRoom;
  aisle.walls.erase(aisle.walls.begin(), aisle.walls.begin() + 2);
  EXPECT_EQ(degenerate(aisle), 1) << "along an aisle nothing holds";
  SyntheticRoom plane;
  plane.walls.push_back({Vector3::UnitZ(), -2.0});
  EXPECT_EQ(degenerate(plane), 3) << "above a plane: to the sides, and the heading";
}

/// Ground 4 m below the origin, with stems that are thin and far between.
SyntheticRoom open_ground(const std::vector<Vector3>& stems_m) {
  SyntheticRoom room;
  room.walls.push_back({Vector3::UnitZ(), -4.0});
  for (const Vector3& at_m : stems_m) room.stems.push_back({at_m.x(), at_m.y(), 0.12, 4.0});
  return room;
}

constexpr int kManyBeams = 30000;

SurfaceMap map_of(const SyntheticRoom& room) {
  SurfaceMap map({});
  for (unsigned seed = 1; seed <= 6; ++seed)
    map.insert(seen_from(room, Pose::Identity(), 0.02, seed, kManyBeams), Vector3::Zero());
  return map;
}

const std::vector<Vector3> kFewStems = {{9, 2, 0}, {-3, 10, 0}, {-8, -6, 0}, {4, -9, 0}, {-11, 3, 0}};

TEST(ScanToMap, ConstrainsOpenGroundByFewStems) {
  const SyntheticRoom room = open_ground(kFewStems);
  const SurfaceMap map = map_of(room);
  const auto points = in_body(seen_from(room, Pose::Identity(), 0.02, 9, kManyBeams), Pose::Identity());
  const ScanFit fit = fit_scan(map, points, Pose::Identity(), {});
  EXPECT_EQ(fit.num_degenerate, 0);
  EXPECT_GE(fit.num_held, 1) << "planes alone leave directions open";
  ScanToMapConfig planes_alone;
  planes_alone.standing_points = 1000000;
  EXPECT_EQ(fit_scan(map, points, Pose::Identity(), planes_alone).num_degenerate, fit.num_held);
  // The evidence is correct: from an offset of a few centimeters and an error of heading back to the truth.
  Pose T = make_pose({0.06, -0.05, 0.0}, rotation_by({0.0, 0.0, 0.004}));
  for (int i = 0; i < 20; ++i) {
    const PoseEvidence evidence = fit_scan(map, points, T, {}).evidence;
    const Eigen::Matrix<double, 6, 1> step = evidence.information.ldlt().solve(evidence.gradient);
    T = make_pose(T.translation() - step.head<3>(), Eigen::Quaterniond(T.linear()) * rotation_by(-step.tail<3>()));
  }
  EXPECT_LT(T.translation().norm(), 0.012);
  EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(T.linear())).norm(), 0.0015);
}

TEST(ScanToMap, RecognizesStemsWithinPredictedUncertainty) {
  const SyntheticRoom room = open_ground({{6.0, 2.0, 0.0}, {-5.0, 4.0, 0.0}, {1.0, -7.0, 0.0}, {7.0, -3.0, 0.0}});
  const SurfaceMap map = map_of(room);
  const auto points = in_body(seen_from(room, Pose::Identity(), 0.02, 9, kManyBeams), Pose::Identity());
  const Vector3 error_m(0.25, 0.2, 0.0);
  const auto found = [&](double position_sigma_m) {
    return fit_scan(map, points, make_pose(error_m, Eigen::Quaterniond::Identity()), {}, 0.0, 0.0, position_sigma_m);
  };
  EXPECT_GT(found(0.01).num_degenerate, 0);
  const ScanFit held = found(0.2);
  EXPECT_EQ(held.num_degenerate, 0);
  const Eigen::Matrix<double, 6, 1> step = held.evidence.information.ldlt().solve(held.evidence.gradient);
  EXPECT_GT(step.head<2>().dot(error_m.head<2>()), 0.0) << "towards the truth";
}

TEST(ScanToMap, LeavesRotationAroundOneStemOpen) {
  const Vector3 stem_m(6.0, 2.0, 0.0);
  const SyntheticRoom room = open_ground({stem_m});
  const SurfaceMap map = map_of(room);
  const ScanFit fit = fit_scan(map, in_body(seen_from(room, Pose::Identity(), 0.02, 9, kManyBeams), Pose::Identity()),
                               Pose::Identity(), {});
  EXPECT_EQ(fit.num_degenerate, 1);
  EXPECT_EQ(fit.num_held, 2) << "toward it and aside";
  // A turn about the stem moves the vehicle by z x (0 - stem) and turns it by z.
  Eigen::Matrix<double, 6, 1> around, toward;
  around << Vector3::UnitZ().cross(-stem_m), Vector3::UnitZ();
  toward << stem_m.normalized(), Vector3::Zero();
  const double around_it = around.dot(fit.evidence.information * around) / around.head<3>().squaredNorm();
  EXPECT_LT(around_it, 0.05 * toward.dot(fit.evidence.information * toward));
}

TEST(ScanToMap, ClaimsNothingAboutOpenDirections) {
  SyntheticRoom aisle = kRoom;
  aisle.walls.erase(aisle.walls.begin(), aisle.walls.begin() + 2);
  SurfaceMap map({});
  for (unsigned seed = 1; seed <= 4; ++seed)
    map.insert(seen_from(aisle, Pose::Identity(), 0.02, seed), Vector3::Zero());
  const ScanFit fit = fit_scan(map, in_body(seen_from(aisle, Pose::Identity(), 0.02, 9), Pose::Identity()),
                               make_pose({0.1, 0.0, 0.0}, Eigen::Quaterniond::Identity()), {});
  const Vector3 along = fit.evidence.information.col(0).head<3>();
  EXPECT_LT(along.norm(), 0.05 * fit.evidence.information.col(1).head<3>().norm());
}

TEST(ScanToMap, DownweightsPointsFarFromEverySurface) {
  SurfaceMap map({});
  for (unsigned seed = 1; seed <= 4; ++seed)
    map.insert(seen_from(kRoom, Pose::Identity(), 0.01, seed), Vector3::Zero());
  auto points = in_body(seen_from(kRoom, Pose::Identity(), 0.01, 9), Pose::Identity());
  const ScanFit clean = fit_scan(map, points, Pose::Identity(), {});
  // A person before the wall: 300 points, 0.4 m off.
  for (int i = 0; i < 300; ++i) points.emplace_back(6.0F, -1.0F + 0.005F * static_cast<float>(i), 1.0F);
  const ScanFit disturbed = fit_scan(map, points, Pose::Identity(), {});
  const Eigen::Matrix<double, 6, 1> shift_clean = clean.evidence.information.ldlt().solve(clean.evidence.gradient);
  const Eigen::Matrix<double, 6, 1> shift = disturbed.evidence.information.ldlt().solve(disturbed.evidence.gradient);
  EXPECT_LT((shift - shift_clean).head<3>().norm(), 0.001);
}

}  // namespace
}  // namespace swiftlet
