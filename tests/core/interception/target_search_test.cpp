// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/target_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "swiftlet/core/base/overlay.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

Geofence fence_of(const Vector3& min_m, const Vector3& max_m) {
  GeofenceConfig config;
  config.min_m = min_m;
  config.max_m = max_m;
  return Geofence(config, FrameChange());
}

/// Present positions of the particles.
std::vector<Vector3> places_of(const TargetSearch& search) {
  std::vector<Overlay> overlays;
  search.append_overlay(overlays);
  std::vector<Vector3> places;
  for (const Eigen::Vector3f& p : overlays.at(0).positions) places.emplace_back(p.cast<double>());
  return places;
}

struct Spread {
  Vector3 mean = Vector3::Zero(), sigma = Vector3::Zero();
};

Spread spread_of(const std::vector<Vector3>& places) {
  Spread s;
  for (const Vector3& p : places) s.mean += p / static_cast<double>(places.size());
  for (const Vector3& p : places) s.sigma += (p - s.mean).cwiseAbs2() / static_cast<double>(places.size());
  s.sigma = s.sigma.cwiseSqrt();
  return s;
}

TargetSearch begun(const TargetSearchConfig& config, const PointState& target, double sigma_m, double sigma_mps) {
  TargetSearch search(config);
  search.begin(target, sigma_m, sigma_mps);
  return search;
}

TEST(TargetSearch, StartsWithTheGivenSpread) {
  const TargetSearch search = begun({}, {{20, -5, 15}, {4, 0, 0}, {}}, 2.0, 1.0);
  const Spread s = spread_of(places_of(search));
  EXPECT_LT((s.mean - Vector3(20, -5, 15)).cwiseAbs().maxCoeff(), 0.5);
  EXPECT_LT((s.sigma - Vector3(2, 2, 2)).cwiseAbs().maxCoeff(), 0.35);
  EXPECT_EQ(search.remaining(), 1.0);
  EXPECT_LT((search.most_probable() - Vector3(20, -5, 15)).norm(), 1.0);
}

// Steps of white noise: velocities spread as the square root of time.
TEST(TargetSearch, AccelerationsSpreadParticlesForAnyStep) {
  TargetSearchConfig config;
  config.acceleration_mps2 = 2.0;
  config.speed_max_mps = 1e6;
  const Geofence fence = fence_of({-5000, -5000, 0}, {5000, 5000, 5000});
  for (const double dt_s : {0.05, 0.25}) {
    TargetSearch search = begun(config, {{0, 0, 2000}, {0, 0, 0}, {}}, 1e-9, 1e-9);
    const double duration_s = 4.0;
    for (int i = 0; i < std::lround(duration_s / dt_s); ++i) search.advance(dt_s, fence);
    // Integrated white noise of strength q: the variance of the place is q t^3 / 3.
    const double sigma_m = std::sqrt(2.0 * 2.0 / 0.7 * duration_s * duration_s * duration_s / 3.0);
    const Spread s = spread_of(places_of(search));
    EXPECT_NEAR(s.sigma.x(), sigma_m, 0.2 * sigma_m) << dt_s;
    EXPECT_NEAR(s.sigma.y(), sigma_m, 0.2 * sigma_m) << dt_s;
    EXPECT_NEAR(s.sigma.z(), sigma_m, 0.2 * sigma_m) << dt_s;
  }
}

TEST(TargetSearch, LimitsParticlesToTargetSpeed) {
  TargetSearchConfig config;
  config.speed_max_mps = 3.0;
  TargetSearch search = begun(config, {{0, 0, 50}, {30, 0, 0}, {}}, 1e-9, 1e-9);
  const Geofence fence = fence_of({-500, -500, 0}, {500, 500, 500});
  search.advance(0.5, fence);
  for (const Vector3& p : places_of(search)) {
    EXPECT_LE((p - Vector3(0, 0, 50)).norm(), 1.5 + 1e-4);
    EXPECT_GT(p.x(), 1.4) << "on the way that it flew";
  }
  search.advance(50.0, fence);
  for (const Vector3& p : places_of(search))
    EXPECT_LE((p - Vector3(0, 0, 50)).norm(), 1.5 + 3.0 + 1e-4) << "a step is a second";
}

TEST(TargetSearch, TargetsTurnBackAtTheFence) {
  TargetSearchConfig config;
  config.acceleration_mps2 = 1e-6;
  TargetSearch search = begun(config, {{8, 0, 10}, {4, 1, 0}, {}}, 1e-9, 1e-9);
  const Geofence fence = fence_of({-10, -10, 2}, {10, 10, 20});
  search.advance(1.0, fence);
  for (const Vector3& p : places_of(search)) EXPECT_LT((p - Vector3(10, 1, 10)).norm(), 1e-3) << "at the side";
  search.advance(1.0, fence);
  for (const Vector3& p : places_of(search)) EXPECT_LT((p - Vector3(6, 2, 10)).norm(), 1e-3) << "particles turned back";
}

/// The share of places that stay possible after a long look at a single place.
double left_of(const TargetSearchConfig& config, const Vector3& target_local_m, const Vector3& eye_local_m) {
  TargetSearch search = begun(config, {target_local_m, {0, 0, 0}, {}}, 1e-9, 1e-9);
  search.look(eye_local_m, 100.0, nullptr);
  return search.remaining();
}

TEST(TargetSearch, KeepsPlacesOutOfSightPossible) {
  TargetSearchConfig config;
  config.range_m = 20.0;
  config.fov_bottom_deg = -10.0;
  config.fov_top_deg = 30.0;
  const Vector3 eye(5, 0, 9);
  for (const auto& [range_m, elevation_deg, seen] : {std::tuple(19.9, 0.0, true),
                                                     {20.1, 0.0, false},
                                                     {10.0, 29.5, true},
                                                     {10.0, 30.5, false},
                                                     {10.0, -9.5, true},
                                                     {10.0, -10.5, false}}) {
    const double e = elevation_deg * std::acos(-1.0) / 180.0;
    const Vector3 to_m = range_m * Vector3(0.6 * std::cos(e), 0.8 * std::cos(e), std::sin(e));
    EXPECT_EQ(left_of(config, eye + to_m, eye) < 0.01, seen) << range_m << " m, " << elevation_deg;
  }
}

TEST(TargetSearch, ReducesProbabilityAtTheDetectionRate) {
  TargetSearchConfig config;
  config.detection_rate_per_s = 3.0;
  TargetSearch search = begun(config, {{5, 0, 10}, {0, 0, 0}, {}}, 1e-9, 1e-9);
  search.look({0, 0, 10}, 0.1, nullptr);
  EXPECT_NEAR(search.remaining(), std::exp(-0.3), 1e-9);
  search.look({0, 0, 10}, 0.2, nullptr);
  EXPECT_NEAR(search.remaining(), std::exp(-0.9), 1e-9);
  search.look({0, 0, 10}, 1e3, nullptr);
  EXPECT_GT(search.remaining(), 0.0) << "a place may become possible again";
  EXPECT_LT(search.remaining(), 1e-5);
}

TEST(TargetSearch, KeepsPlacesBehindObstaclesPossible) {
  testing::CellListMap wall(0.5);
  wall.occupy_box({2, -1, 9}, {2.5, 1, 11});
  TargetSearch search = begun({}, {{5, 0, 10}, {0, 0, 0}, {}}, 1e-9, 1e-9);
  search.look({0, 0, 10}, 10.0, &wall);
  EXPECT_EQ(search.remaining(), 1.0);
  search.look({3, 0, 10}, 10.0, &wall);
  EXPECT_LT(search.remaining(), 1e-5);
}

// Most particles start around one place; after a look there, the target is expected outside of the view.
TEST(TargetSearch, ExpectsTargetOutsideObservedSpace) {
  TargetSearchConfig config;
  config.range_m = 6.0;
  TargetSearch search = begun(config, {{0, 0, 15}, {0, 0, 0}, {}}, 8.0, 1e-9);
  for (int i = 0; i < 20; ++i) search.look({0, 0, 15}, 0.5, nullptr);
  EXPECT_GT((search.most_probable() - Vector3(0, 0, 15)).norm(), 4.0);
}

TEST(TargetSearch, FadesPlacesSeenEmptyInOverlays) {
  TargetSearch search = begun({}, {{5, 0, 10}, {0, 0, 0}, {}}, 1e-9, 1e-9);
  std::vector<Overlay> overlays;
  search.append_overlay(overlays);
  search.look({0, 0, 10}, 0.2, nullptr);
  search.append_overlay(overlays);
  search.look({0, 0, 10}, 10.0, nullptr);
  search.append_overlay(overlays);
  ASSERT_EQ(overlays.size(), 3U);
  EXPECT_EQ(overlays[0].kind, Overlay::Kind::kPoints);
  EXPECT_GT(overlays[0].colors[0].w(), overlays[1].colors[0].w());
  EXPECT_GT(overlays[1].colors[0].w(), overlays[2].colors[0].w());
  EXPECT_GT(overlays[2].colors[0].w(), 0.0F) << "but are still there";
}

}  // namespace
}  // namespace swiftlet
