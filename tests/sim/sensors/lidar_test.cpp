// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/parallel/crew.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/fnv.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

using Scans = std::vector<std::shared_ptr<const LabeledScan>>;

/// A LiDAR in a small world; the shapes of the vehicles are points by default.
struct Rig {
  TestScene world;
  LidarConfig config;
  std::vector<Motion> motions = {resting({0, 0, 0})};
  std::vector<std::shared_ptr<const VehicleShape>> shapes;
  std::uint64_t seed = 1;

  Rig() { config.mount.position_m.setZero(); }

  std::unique_ptr<Sensor> make() const {
    SensorSetup setup = sensor_setup("lidar", seed, static_cast<int>(motions.size()));
    setup.scene = std::make_shared<const Scene>(world.scene());
    setup.world = std::make_shared<const StaticScene>(*setup.scene);
    for (std::size_t i = 0; i < shapes.size(); ++i) setup.vehicle_shapes[i] = shapes[i];
    return make_lidar(config, std::move(setup));
  }
  Scans run(int num_scans = 1) const {
    const auto sensor = make();
    Scans scans;
    drive(
        *sensor, motions, {.duration_s = num_scans / config.rate_hz + 1e-6, .tick = 10'000'000},
        [&](TimeNs, const Observation&) { scans.insert(scans.end(), sensor->scans().begin(), sensor->scans().end()); });
    return scans;
  }
};

LidarConfig uniform(int rows, int columns, double fov_vertical_deg, double fov_horizontal_deg = 360.0) {
  LidarConfig config;
  config.mount.position_m.setZero();
  config.pattern = Module(lidar_pattern_types(), "uniform");
  UniformConfig& pattern = config.pattern.as<UniformConfig>();
  pattern.rows = rows;
  pattern.columns = columns;
  pattern.fov_vertical_deg = fov_vertical_deg;
  pattern.fov_horizontal_deg = fov_horizontal_deg;
  return config;
}

// A vehicle that is one plate across the body's x axis.
std::shared_ptr<const VehicleShape> plate(float half_width_m, float half_height_m) {
  auto shape = std::make_shared<VehicleShape>();
  Mesh mesh;
  mesh.vertices_mesh_m = {{0, -half_width_m, -half_height_m},
                          {0, half_width_m, -half_height_m},
                          {0, half_width_m, half_height_m},
                          {0, -half_width_m, half_height_m}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.part = VehiclePart::kArm;
  shape->meshes.push_back(mesh);
  shape->materials = {{"frame", 0.5F, false, {}}};
  return shape;
}

std::uint64_t fingerprint(const Scans& scans) {
  test::Fnv1a hash;
  for (const auto& s : scans) {
    hash.add(s->scan.range_m.data(), s->scan.range_m.size() * sizeof(float));
    hash.add(s->scan.intensity.data(), s->scan.intensity.size() * sizeof(float));
    hash.add(s->truth.instance.data(), s->truth.instance.size() * sizeof(std::uint16_t));
    hash.add(s->truth.incidence_rad.data(), s->truth.incidence_rad.size() * sizeof(float));
    for (const StampedPose& pose : s->scan.external_poses)
      hash.add(pose.T_world_body.matrix().data(), 16 * sizeof(double));
  }
  return hash.value();
}

// ---- geometry
// ---------------------------------------------------------------------------------------------------------

TEST(Lidar, MeasuresAPlaneAtFiveMeters) {
  for (const char* pattern : {"ouster", "livox_mid360", "velodyne_puck", "uniform"}) {
    Rig rig;
    rig.world.add_wall({5, -400, -400}, {5, 400, -400}, {5, 400, 400}, {5, -400, 400}, SurfaceClass::kWall, 6);
    rig.config.pattern = Module(lidar_pattern_types(), pattern);
    rig.config.ideal = true;
    const Scans scans = rig.run();
    ASSERT_EQ(scans.size(), 1U);
    const Scan& scan = scans[0]->scan;
    int num_hits = 0;
    for (int i = 0; i < scan.size(); ++i) {
      const float along = scan.beams->directions_lidar[i].x();
      const double expected = along > 0 ? (5.0 - scan.beams->origins_lidar[i].x()) / along : 1e9;
      if (expected > 119.9) {
        EXPECT_TRUE(expected < 120.1 || !scan.hit(i)) << pattern << i;
        continue;
      }
      ++num_hits;
      ASSERT_NEAR(scan.range_m[i], expected, 2e-5 * expected) << pattern << i;
      ASSERT_NEAR(scan.point_lidar(i).x(), 5.0, 2e-4) << pattern << i;
      ASSERT_EQ(scans[0]->truth.range_m[i], scan.range_m[i]);
      ASSERT_EQ(scans[0]->truth.surface_class[i], static_cast<int>(SurfaceClass::kWall));
      ASSERT_EQ(scans[0]->truth.instance[i], 6);
      const double angle_rad = std::acos(static_cast<double>(along));
      if (angle_rad > 1.5) continue;  // edge-on
      ASSERT_NEAR(scans[0]->truth.incidence_rad[i], angle_rad, angle_rad > 0.3 ? 2e-6 : 1e-3) << pattern << i;
    }
    EXPECT_NEAR(static_cast<double>(num_hits) / scan.size(), 0.49, 0.02) << pattern;
  }
}

TEST(Lidar, RotatesAndShiftsByTheMount) {
  Rig rig;
  rig.world.add_wall({-400, -400, -2}, {400, -400, -2}, {400, 400, -2}, {-400, 400, -2}, SurfaceClass::kGround);
  rig.config = uniform(1, 8, 0.0);
  rig.config.ideal = true;
  rig.config.mount.position_m = {0.3, 0.0, 0.1};
  rig.config.mount.rpy_deg = {0.0, 30.0, 0.0};  // nose down
  rig.motions = {resting({0, 0, 1}, 0.7)};
  const auto scans = rig.run();
  const Scan& scan = scans[0]->scan;
  EXPECT_NEAR(scan.range_m[0], (1.0 + 2.0 + 0.1) / std::sin(30.0 / kDegPerRad), 1e-4);
  EXPECT_EQ(scan.range_m[4], 0.0F) << "behind, the beam goes up";
  EXPECT_TRUE(scan.T_body_lidar.isApprox(rig.config.mount.T_body_lidar()));
}

TEST(Lidar, HidesMountErrorFromTheScan) {
  Rig rig;
  rig.world.add_wall({10, -40, -40}, {10, 40, -40}, {10, 40, 40}, {10, -40, 40});
  rig.config = uniform(8, 64, 20.0, 60.0);
  rig.config.ideal = true;
  rig.config.mount_error = {.position_m = {0.2, 0, 0}, .rotation_deg = {0, 0, 3}};
  const auto scans = rig.run();
  const LabeledScan& s = *scans[0];
  EXPECT_TRUE(s.scan.T_body_lidar.isApprox(Pose::Identity()));
  EXPECT_TRUE(s.truth.T_world_lidar[0].isApprox(s.truth.T_body_lidar)) << "the vehicle rests at the origin";
  for (int i = 0; i < s.scan.size(); ++i) {
    const Vector3 p_lidar_m = s.scan.point_lidar(i).cast<double>();
    ASSERT_NEAR((s.truth.T_body_lidar * p_lidar_m).x(), 10.0, 1e-4);
    ASSERT_NEAR(p_lidar_m.x() * std::cos(3.0 / kDegPerRad) - p_lidar_m.y() * std::sin(3.0 / kDegPerRad), 9.8, 1e-4);
  }
}

TEST(Lidar, ReturnsAllBeamsInClosedRooms) {
  Rig rig;
  rig.world.add_box({-8, -6, -3}, {9, 7, 4});
  rig.config.detection.always = true;
  rig.config.range_min_m = 0.1;
  for (const char* pattern : {"ouster", "livox_mid360", "velodyne_puck", "uniform"}) {
    rig.config.pattern = Module(lidar_pattern_types(), pattern);
    const Scans scans = rig.run(2);
    for (const auto& s : scans) {
      for (int i = 0; i < s->scan.size(); ++i) ASSERT_TRUE(s->scan.hit(i)) << pattern << i;
    }
  }
}

TEST(Lidar, HitsSpheresByTheirSolidAngle) {
  Rig rig;
  const double radius = 0.5, distance = 10.0;
  rig.world.add_sphere({10, 0, 0}, 0.5F, 96);
  rig.config = uniform(256, 4096, 20.0);
  rig.config.ideal = true;
  const auto scans = rig.run();
  const Scan& scan = scans[0]->scan;
  int num_hits = 0, num_expected = 0;
  const double cos_half = std::cos(std::asin(radius / distance));
  for (int i = 0; i < scan.size(); ++i) {
    num_hits += scan.hit(i) ? 1 : 0;
    num_expected += scan.beams->directions_lidar[i].x() > cos_half ? 1 : 0;
    if (!scan.hit(i)) continue;
    // Nearest intersection of the line with the sphere.
    const double along = distance * scan.beams->directions_lidar[i].x();
    const double expected = along - std::sqrt(std::max(0.0, radius * radius - distance * distance + along * along));
    if (along * along - distance * distance < -0.24) continue;  // grazing: the facets matter
    EXPECT_NEAR(scan.range_m[i], expected, 2e-3);
  }
  EXPECT_NEAR(num_hits, num_expected, 0.01 * num_expected);
  // In closed form: solid angle over the solid angle of a beam at the horizon.
  const double solid_angle = 2.0 * std::numbers::pi * (1.0 - cos_half);
  const double beam = (20.0 / 255 / kDegPerRad) * (2.0 * std::numbers::pi / 4096);
  EXPECT_NEAR(num_hits, solid_angle / beam, 0.02 * num_hits);
}

// ---- time
// -------------------------------------------------------------------------------------------------------------

TEST(Lidar, DeliversScansAtTheSweepEnd) {
  Rig rig;
  rig.world.add_box({-8, -6, -3}, {9, 7, 4});
  rig.config = uniform(4, 64, 20.0);
  for (const bool rolling : {true, false}) {
    rig.config.rolling = rolling;
    const auto sensor = rig.make();
    EXPECT_GE(sensor->look_back_s(), 0.1);
    std::vector<TimeNs> delivered;
    drive(*sensor, rig.motions, {.duration_s = 0.35, .tick = 4'000'000},
          [&](TimeNs now, const Observation& observation) {
            ASSERT_EQ(observation.scans.size(), sensor->scans().size());
            for (const auto& scan : observation.scans) {
              delivered.push_back(now);
              const TimeNs end = static_cast<TimeNs>(delivered.size()) * 100'000'000;
              EXPECT_EQ(scan->stamp, rolling ? end - 100'000'000 : end);
              EXPECT_EQ(scan->duration, rolling ? 100'000'000 : 0);
              for (int i = 0; i < scan->size(); ++i) {
                EXPECT_GE(scan->time_of(i), scan->stamp);
                EXPECT_LE(scan->time_of(i), scan->stamp + scan->duration);
              }
            }
          });
    EXPECT_EQ(delivered, (std::vector<TimeNs>{100'000'000, 200'000'000, 300'000'000}));
  }
}

TEST(Lidar, MatchesFrozenSweepsWithoutMotion) {
  Rig rig;
  rig.world.add_box({-8, -6, -3}, {9, 7, 4});
  rig.shapes = {plate(0.0F, 0.0F), plate(0.5F, 0.5F)};
  rig.motions = {resting({0, 0, 0}, 0.3), resting({4, 1, 0}, 0.2)};
  rig.config.range_min_m = 0.1;
  const auto rolling = rig.run(2);
  rig.config.rolling = false;
  const auto frozen = rig.run(2);
  ASSERT_EQ(rolling.size(), frozen.size());
  for (std::size_t s = 0; s < rolling.size(); ++s) {
    EXPECT_EQ(rolling[s]->scan.range_m, frozen[s]->scan.range_m);
    EXPECT_EQ(rolling[s]->truth.instance, frozen[s]->truth.instance);
  }
  EXPECT_GT(std::count(rolling[0]->truth.instance.begin(), rolling[0]->truth.instance.end(), 2), 10);
}

TEST(Lidar, ShearsMovingTargetsUnlessFrozen) {
  // A plate 10 m ahead moves sideways with v while the sensor scans a sector of 40 deg from right to left: column at
  // azimuth a fires at t(a); the plate's left edge is met where 10 tan a = y0 + w + v t(a).
  Rig rig;
  const double v = 12.0, half_width = 1.0;
  rig.config = uniform(1, 4000, 0.0, 40.0);
  rig.config.ideal = true;
  rig.shapes = {plate(0.0F, 0.0F), plate(static_cast<float>(half_width), 1.0F)};
  rig.motions = {resting({0, 0, 0}), straight({10, -0.6, 0}, {0, v, 0})};
  for (const bool rolling : {true, false}) {
    rig.config.rolling = rolling;
    const auto scans = rig.run();
    const Scan& scan = scans[0]->scan;
    int first = -1, last = -1;
    for (int c = 0; c < scan.cols(); ++c) {
      if (!scan.hit(c)) continue;
      if (first < 0) first = c;
      last = c;
      EXPECT_NEAR(scan.point_lidar(c).x(), 10.0, 1e-4);
      EXPECT_EQ(scans[0]->truth.instance[c], 2);
      EXPECT_EQ(scans[0]->truth.part[c], static_cast<int>(VehiclePart::kArm));
    }
    const auto y_of_edge = [&](double side, int column) {
      const double t = rolling ? scan.beams->column_offset_s[column] : 0.1;
      return -0.6 + side * half_width + v * t;
    };
    const double step = 10.0 * 40.0 / 3999 / kDegPerRad * 1.1;  // one column on the plate
    EXPECT_NEAR(scan.point_lidar(first).y(), y_of_edge(-1, first), step) << rolling;
    EXPECT_NEAR(scan.point_lidar(last).y(), y_of_edge(+1, last), step) << rolling;
    const double width = scan.point_lidar(last).y() - scan.point_lidar(first).y();
    if (rolling) {
      EXPECT_GT(width, 2.0 * half_width + 0.3) << "stretched by v * (time between the edges)";
    } else {
      EXPECT_NEAR(width, 2.0 * half_width, 2 * step);
    }
  }
}

// 7 m/s and 167 deg/s: what independent checks flew.
TEST(Lidar, PlacesPointsOnSurfacesWhileTurning) {
  Rig rig;
  const Vector3 half_room_m(12, 9, 4);
  rig.world.add_box((-half_room_m).cast<float>(), half_room_m.cast<float>());
  rig.config.ideal = true;
  rig.config.mount.rpy_deg = {5, 20, 90};
  rig.motions = {[](double t) {
    VehicleState state = state_at({7.0 * (t - 0.25), 2.0, 0.5}, 0.0);
    state.v_world_mps = {7.0, 0.0, 0.0};
    state.q_world_body = Eigen::AngleAxisd(167.0 / kDegPerRad * t, Vector3(0.2, 0.1, 1).normalized());
    return state;
  }};
  const auto scans = rig.run(3);
  const LabeledScan& s = *scans[2];
  const auto off_m = [&](const Vector3& p_world_m) {
    const Vector3 outside = p_world_m.cwiseAbs() - half_room_m;
    return outside.maxCoeff() > 0.0 ? outside.cwiseMax(0.0).norm() : -outside.maxCoeff();
  };
  double worst_m = 0.0, frozen_sum_m = 0.0;
  int points = 0;
  for (int i = 0; i < s.scan.size(); ++i) {
    if (!s.scan.hit(i)) continue;
    const Vector3 p_lidar_m = s.scan.point_lidar(i).cast<double>();
    worst_m = std::max(worst_m, off_m(s.truth.T_world_lidar[i % s.scan.cols()] * p_lidar_m));
    frozen_sum_m += off_m(s.truth.T_world_lidar[0] * p_lidar_m);
    ++points;
  }
  ASSERT_GT(points, 100000);
  EXPECT_LT(worst_m, 3e-4);
  EXPECT_GT(frozen_sum_m / points, 0.2) << "if the sweep were an instant";
}

// ---- measurement
// ------------------------------------------------------------------------------------------------------

TEST(Lidar, AddsWhiteNoiseToReturnsOnly) {
  Rig rig;
  rig.world.add_wall({20, -30, -30}, {20, 30, -30}, {20, 30, 30}, {20, -30, 30});
  rig.config.detection.always = true;
  rig.config.noise.sigma_range_m = 0.05;
  const auto scans = rig.run(2);
  SampleStatistics error, lag_product, frame_product;
  const std::size_t size = scans[0]->scan.range_m.size();
  for (std::size_t i = 0; i < size; ++i) {
    const bool met = scans[0]->truth.range_m[i] > 0;
    ASSERT_EQ(scans[0]->scan.hit(static_cast<int>(i)), met);
    if (!met) continue;
    const auto error_of = [&](int s, std::size_t k) { return scans[s]->scan.range_m[k] - scans[s]->truth.range_m[k]; };
    error.add(error_of(0, i));
    frame_product.add(error_of(0, i) * error_of(1, i));
    if (i + 1 < size && scans[0]->truth.range_m[i + 1] > 0) lag_product.add(error_of(0, i) * error_of(0, i + 1));
  }
  ASSERT_GT(error.size(), 30000);
  EXPECT_NEAR(error.mean(), 0.0, mean_bound(0.05, error.size()));
  EXPECT_NEAR(error.variance(), 0.0025, variance_bound(0.0025, error.size()));
  EXPECT_NEAR(lag_product.mean(), 0.0, mean_bound(0.0025, lag_product.size()));
  EXPECT_NEAR(frame_product.mean(), 0.0, mean_bound(0.0025, frame_product.size()));
}

TEST(Lidar, DetectsDarkTargetsAtRatedRange) {
  for (const auto& [reflectivity, range_m] : {std::pair{0.1F, 40.0F}, std::pair{0.8F, 120.0F}}) {
    Rig rig;
    const std::uint32_t material = rig.world.add_material(reflectivity);
    rig.world.add_wall({range_m, -2, -2}, {range_m, 2, -2}, {range_m, 2, 2}, {range_m, -2, 2}, SurfaceClass::kWall, 0,
                       material);
    rig.config = uniform(256, 256, 1.0, 1.0);
    rig.config.range_max_m = 150.0;
    const auto scans = rig.run();
    int num_met = 0, num_returned = 0;
    for (int i = 0; i < scans[0]->scan.size(); ++i) {
      num_met += scans[0]->truth.range_m[i] > 0 ? 1 : 0;
      num_returned += scans[0]->scan.hit(i) ? 1 : 0;
    }
    ASSERT_GT(num_met, 60000);
    EXPECT_NEAR(static_cast<double>(num_returned) / num_met, 0.9, share_bound(0.9, num_met) + 0.003) << reflectivity;
  }
}

TEST(Lidar, IntensityAloneFallsWithSquaredRange) {
  for (const float distance : {5.0F, 10.0F, 20.0F}) {
    Rig rig;
    const std::uint32_t white = rig.world.add_material(1.0F);
    rig.world.add_wall({distance, -9, -9}, {distance, 9, -9}, {distance, 9, 9}, {distance, -9, 9}, SurfaceClass::kWall,
                       0, white);
    rig.config = uniform(1, 3, 0.0, 40.0);
    rig.config.ideal = true;
    const auto scans = rig.run();
    const Scan& scan = scans[0]->scan;
    EXPECT_NEAR(scan.intensity[1], 100.0 / (distance * distance), 1e-3 * scan.intensity[1]);
    EXPECT_NEAR(scan.reflectivity[1], 1.0, 1e-4);
    EXPECT_NEAR(scan.reflectivity[0], std::cos(20.0 / kDegPerRad), 1e-4) << "Lambert's law";
  }
}

TEST(Lidar, SeesRetroReflectorsAtAnyIncidence) {
  Rig rig;
  const std::uint32_t tape = rig.world.add_material(0.9F, true);
  rig.world.add_wall({1, 5, -5}, {41, 5.4F, -5}, {41, 5.4F, 5}, {1, 5, 5}, SurfaceClass::kMarking, 0, tape);
  rig.config = uniform(1, 721, 0.0);
  rig.config.ideal = true;
  const auto scans = rig.run();
  int num_met = 0;
  for (int i = 0; i < scans[0]->scan.size(); ++i) {
    if (!scans[0]->scan.hit(i)) continue;
    ++num_met;
    EXPECT_NEAR(scans[0]->scan.reflectivity[i], 0.9 * rig.config.detection.retro_gain, 1e-3);
  }
  EXPECT_GT(num_met, 50);
}

TEST(Lidar, ReturnsNothingBelowTheMinimumRange) {
  Rig rig;
  rig.world.add_wall({0.5F, -9, -9}, {0.5F, 9, -9}, {0.5F, 9, 9}, {0.5F, -9, 9});
  rig.config = uniform(1, 3, 0.0, 20.0);
  rig.config.range_min_m = 0.8;
  const auto scans = rig.run();
  EXPECT_EQ(scans[0]->scan.range_m[1], 0.0F);
  EXPECT_NEAR(scans[0]->truth.range_m[1], 0.5, 1e-5) << "the truth has the near wall";
}

TEST(Lidar, MixesEdgeRangesInWideBeams) {
  // Half of the field is a wall at 10 m, the other half one at 10.3 m: within a pulse, hence mixed; at 14 m: not mixed.
  for (const float behind : {0.3F, 4.0F}) {
    Rig rig;
    rig.world.add_wall({10, 0, -9}, {10, 9, -9}, {10, 9, 9}, {10, 0, 9}, SurfaceClass::kWall, 1);
    rig.world.add_wall({10 + behind, -9, -9}, {10 + behind, 9, -9}, {10 + behind, 9, 9}, {10 + behind, -9, 9},
                       SurfaceClass::kWall, 2);
    rig.config = uniform(1, 2001, 0.0, 2.0);
    rig.config.beam.divergence_deg = 0.2;
    rig.config.detection.always = true;
    rig.config.noise.sigma_range_m = 0.0;
    for (const int sub_rays : {1, 9}) {
      rig.config.beam.sub_rays = sub_rays;
      const auto scans = rig.run();
      int num_mixed = 0;
      for (int i = 0; i < scans[0]->scan.size(); ++i) {
        const float range = scans[0]->scan.range_m[i];
        ASSERT_GT(range, 9.99F);
        ASSERT_LT(range, 10.02F + behind);
        num_mixed += range > 10.02F && range < 9.98F + behind ? 1 : 0;
      }
      if (sub_rays == 1 || behind > 1.0F) {
        EXPECT_LE(num_mixed, 3) << sub_rays << " " << behind;
      } else {
        EXPECT_GT(num_mixed, 50) << "about the width of a beam, in steps of 0.001 degrees";
        EXPECT_LT(num_mixed, 400);
      }
    }
  }
}

// A wire 3 mm thick, 20 m away: the beams' axes miss it mostly, the cone of beams does not.
TEST(Lidar, FindsWiresWithWideBeams) {
  Rig rig;
  rig.world.add_wall({20, 0.05F, -9}, {20, 0.053F, -9}, {20, 0.053F, 9}, {20, 0.05F, 9});
  rig.config = uniform(200, 361, 40.0, 30.0);
  rig.config.beam.divergence_deg = 0.3;
  rig.config.detection.always = true;
  const auto hits_with = [&](int sub_rays) {
    rig.config.beam.sub_rays = sub_rays;
    const auto scans = rig.run();
    return std::count_if(scans[0]->scan.range_m.begin(), scans[0]->scan.range_m.end(), [](float r) { return r > 0; });
  };
  const auto thin = hits_with(1), five = hits_with(5);
  EXPECT_GT(five, thin);
  EXPECT_GE(hits_with(9), five);
}

TEST(Lidar, ScalesSignalByTheHitFraction) {
  Rig rig;
  const std::uint32_t white = rig.world.add_material(1.0F);
  rig.world.add_wall({10, 0, -9}, {10, 9, -9}, {10, 9, 9}, {10, 0, 9}, SurfaceClass::kWall, 1, white);
  rig.config = uniform(1, 3, 0.0, 0.001);
  rig.config.beam.sub_rays = 9;
  rig.config.detection.always = true;
  rig.motions = {resting({0, 1e-4, 0})};  // the axis just on the wall
  const auto scans = rig.run();
  EXPECT_GT(scans[0]->scan.reflectivity[1], 0.5);
  EXPECT_LT(scans[0]->scan.reflectivity[1], 0.95);
}

// ---- own vehicle
// ------------------------------------------------------------------------------------------------------

TEST(Lidar, SeesItsVehicleUnlessMasked) {
  Rig rig;
  rig.world.add_box({-8, -6, -5}, {9, 7, 4});
  rig.shapes = {quadrotor_shape()};
  rig.motions = {[](double t) {
    VehicleState state = state_at({0.5 * t, 0, 0}, t);
    state.rotor_speed_radps.fill(500.0);
    for (int r = 0; r < 4; ++r) state.rotor_angle_rad[r] = (r % 2 == 0 ? 500.0 : -500.0) * t;
    return state;
  }};
  rig.config = uniform(64, 512, 90.0);
  rig.config.ideal = true;
  rig.config.range_min_m = 0.0;
  rig.config.mount.position_m = {0.0, 0.0, 0.15};
  const auto seen = rig.run();
  rig.config.self_mask = true;
  const auto masked = rig.run();
  const BeamTable& beams = *seen[0]->scan.beams;
  ASSERT_EQ(beams.masked.size(), static_cast<std::size_t>(beams.size()));
  int num_own = 0, num_rotor = 0, num_masked = 0, num_between_blades = 0;
  for (int i = 0; i < beams.size(); ++i) {
    const bool own = seen[0]->truth.instance[i] == 1 && seen[0]->truth.surface_class[i] == 300;
    num_own += own ? 1 : 0;
    num_rotor += own && seen[0]->truth.part[i] == static_cast<int>(VehiclePart::kRotor) ? 1 : 0;
    num_masked += beams.masked[i];
    num_between_blades += beams.masked[i] && !own ? 1 : 0;
    if (own) {
      EXPECT_EQ(beams.masked[i], 1) << "what meets the own vehicle is masked";
      EXPECT_LT(seen[0]->scan.range_m[i], 0.7F);
    }
    if (beams.masked[i]) {
      EXPECT_EQ(masked[0]->scan.range_m[i], 0.0F);
    } else {
      EXPECT_EQ(masked[0]->scan.range_m[i], seen[0]->scan.range_m[i]);
      EXPECT_GT(seen[0]->scan.range_m[i], 2.0F) << "what is not masked sees the room";
    }
  }
  EXPECT_GT(num_own, 200);
  EXPECT_GT(num_rotor, 10);
  EXPECT_GT(num_between_blades, 5 * num_rotor) << "the mask takes whole rotor discs";
  EXPECT_LT(num_masked, beams.size() / 2);
}

// ---- external poses
// -------------------------------------------------------------------------------------------------------

TEST(Lidar, DisturbsExternalPosesBySigmaW) {
  Rig rig;
  rig.config = uniform(1, 4, 0.0);
  rig.config.rolling = false;
  rig.config.rate_hz = 100;
  rig.config.external_pose.enabled = true;
  rig.config.mount.position_m = {0.1, 0.2, 0.3};
  rig.config.mount.rpy_deg = {10, 20, 30};
  rig.motions = {resting({3, -2, 5}, 0.8)};
  constexpr int kScans = 2000;
  SampleStatistics x, roll, product;
  double previous = 0;
  for (const auto& s : rig.run(kScans)) {
    ASSERT_EQ(s->scan.external_poses.size(), 1U);
    EXPECT_EQ(s->scan.external_poses[0].t, s->scan.stamp);
    const Pose T_body_lidar = s->scan.T_body_lidar;
    const Pose truth = rig.motions[0](0).T_world_body() * T_body_lidar;
    const Pose reported = s->scan.external_poses[0].T_world_body * T_body_lidar;
    // Eqs. (40), (41): t_gt = t_m + t_n, R_gt = R_m R_n.
    const Vector3 t_n = truth.translation() - reported.translation();
    const Matrix3 R_n = reported.linear().transpose() * truth.linear();
    x.add(t_n.x());
    roll.add(std::atan2(R_n(2, 1), R_n(2, 2)));
    if (x.size() > 1) product.add(t_n.x() * previous);
    previous = t_n.x();
  }
  EXPECT_NEAR(x.mean(), 0.0, mean_bound(0.05, kScans));
  EXPECT_NEAR(x.variance(), 0.0025, variance_bound(0.0025, kScans));
  EXPECT_NEAR(roll.variance(), 25e-6, variance_bound(25e-6, kScans));
  EXPECT_NEAR(product.mean(), 0.0, mean_bound(0.0025, kScans)) << "white";
}

TEST(Lidar, CorrelatesExternalPosesOverTheirTime) {
  Rig rig;
  rig.config = uniform(1, 4, 0.0);
  rig.config.rolling = false;
  rig.config.rate_hz = 100;
  rig.config.external_pose.enabled = true;
  rig.config.external_pose.correlation_time_s = 0.05;
  std::vector<double> x;
  for (const auto& s : rig.run(6000)) x.push_back(s->scan.external_poses[0].T_world_body.translation().x());
  double variance = 0, lagged = 0;
  for (std::size_t i = 0; i + 5 < x.size(); ++i) {
    variance += x[i] * x[i] / x.size();
    lagged += x[i] * x[i + 5] / x.size();
  }
  EXPECT_NEAR(variance, 0.0025, 5.0 * 0.0025 * std::sqrt(2.0 * 2.0 * 5.0 / x.size()));
  EXPECT_NEAR(lagged / variance, std::exp(-1.0), 0.1);
}

TEST(Lidar, ReportsSweepPosesUnlessIdeal) {
  Rig rig;
  rig.config = uniform(1, 4, 0.0);
  rig.config.external_pose.enabled = true;
  rig.motions = {straight({0, 0, 0}, {5, 0, 0})};
  const auto noisy = rig.run();
  ASSERT_EQ(noisy[0]->scan.external_poses.size(), 11U);
  EXPECT_EQ(noisy[0]->scan.external_poses.back().t, 100'000'000);
  rig.config.ideal = true;
  const auto ideal = rig.run();
  for (const StampedPose& pose : ideal[0]->scan.external_poses) {
    EXPECT_NEAR(pose.T_world_body.translation().x(), 5.0 * to_seconds(pose.t), 1e-9);
  }
  rig.config.external_pose.enabled = false;
  EXPECT_TRUE(rig.run()[0]->scan.external_poses.empty());
}

// White noise is drawn once a sweep: its poses are wrong by the same.
TEST(Lidar, KeepsWhitePoseErrorsPerSweep) {
  Rig rig;
  rig.config = uniform(1, 4, 0.0);
  rig.config.external_pose.enabled = true;
  rig.config.external_pose.correlation_time_s = 0.0;
  rig.motions = {straight({0, 0, 0}, {5, 0, 0})};
  const auto scans = rig.run(2);
  ASSERT_EQ(scans.size(), 2U);
  std::vector<Vector3> errors;
  for (const auto& s : scans) {
    const auto error_of = [](const StampedPose& pose) -> Vector3 {
      return pose.T_world_body.translation() - Vector3(5.0 * to_seconds(pose.t), 0, 0);
    };
    errors.push_back(error_of(s->scan.external_poses.front()));
    EXPECT_GT(errors.back().norm(), 1e-6);
    for (const StampedPose& pose : s->scan.external_poses) EXPECT_TRUE(error_of(pose).isApprox(errors.back(), 1e-9));
  }
  EXPECT_GT((errors[0] - errors[1]).norm(), 1e-6);
}

// As low as possible, with no part of the vehicle or its turning rotors above the cone of the lowest beams.
TEST(LidarMount, StandsJustClearOfTheHull) {
  const auto shape = quadrotor_shape();
  for (const double down_deg : {15.0, 30.0, 45.0}) {
    for (const double aside_m : {0.0, 0.07}) {
      const LidarConfig config = uniform(16, 64, 2.0 * down_deg);
      MountConfig mount;
      mount.position_m = {aside_m, 0.0, 0.0};
      mount.clear_of_hull = true;
      const Vector3 place = mount.place_on(*shape, config.pattern).translation();
      double highest_deg = -90.0;
      const auto look_at = [&](const Vector3& p) {
        const Vector3 sight = p - place;
        highest_deg = std::max(highest_deg, std::atan2(sight.z(), sight.head<2>().norm()) * kDegPerRad);
      };
      for (const Mesh& mesh : shape->meshes) {
        if (mesh.part == VehiclePart::kSensor) continue;
        for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) look_at(vertex.cast<double>());
      }
      for (const auto& rotor : shape->rotors) {
        for (int i = 0; i < 720; ++i) {
          const double angle = i * kPi / 360.0;
          look_at(rotor.hub_body_m.cast<double>() + rotor.radius_m * Vector3(std::cos(angle), std::sin(angle), 0.0));
        }
      }
      EXPECT_LT(highest_deg, -down_deg);
      EXPECT_GT(highest_deg, -down_deg - 3.0);
    }
  }
}

// ---- determinism, memory
// ----------------------------------------------------------------------------------------------

Rig busy_rig() {
  Rig rig;
  rig.world.add_box({-18, -16, -5}, {19, 17, 14});
  rig.world.add_sphere({6, 2, 0}, 1.0F, 48);
  rig.shapes = {quadrotor_shape(), quadrotor_shape(), quadrotor_shape()};
  rig.motions = {straight({0, 0, 0}, {3, 1, 0}), straight({5, -3, 0}, {-4, 6, 0}), straight({-4, 3, 1}, {4, 0, 1})};
  rig.config.external_pose.enabled = true;
  rig.config.mount.position_m = {0, 0, 0.15};
  rig.config.faults = {.dropout_probability = 0.05,
                       .tail_probability = 0.05,
                       .range_step_m = 0.001,
                       .reflectivity_spread = 0.4,
                       .near_per_sweep = 5.0,
                       .rig = {{}}};
  return rig;
}

TEST(Lidar, IsIndependentOfThreadCount) {
  for (const char* pattern : {"ouster", "livox_mid360", "velodyne_puck"}) {
    Rig rig = busy_rig();
    rig.config.pattern = Module(lidar_pattern_types(), pattern);
    rig.config.beam.sub_rays = pattern[0] == 'l' ? 5 : 1;
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4}) {
      Crew crew(threads);
      const Crew::Duty duty(crew);
      hashes.push_back(fingerprint(rig.run(2)));
    }
    EXPECT_EQ(hashes[0], hashes[1]) << pattern;
    EXPECT_EQ(hashes[0], hashes[2]) << pattern;
    rig.seed = 2;
    EXPECT_NE(fingerprint(rig.run(2)), hashes[0]) << pattern;
  }
}

TEST(Lidar, IgnoresVehiclesOutOfSight) {
  Rig rig = busy_rig();
  const auto alone = fingerprint(rig.run(2));
  rig.shapes.push_back(quadrotor_shape());
  rig.motions.push_back(resting({500, 0, 0}));
  EXPECT_EQ(fingerprint(rig.run(2)), alone);
}

TEST(Lidar, AHeldScanIsNotOverwritten) {
  Rig rig = busy_rig();
  rig.config.pattern = Module(lidar_pattern_types(), "livox_mid360");
  const auto sensor = rig.make();
  std::shared_ptr<const Scan> held;
  std::vector<float> ranges;
  std::vector<Eigen::Vector3f> directions;
  drive(*sensor, rig.motions, {.duration_s = 0.55, .tick = 10'000'000}, [&](TimeNs, const Observation& observation) {
    if (observation.scans.empty() || held) return;
    held = observation.scans[0];
    ranges = held->range_m;
    directions = held->beams->directions_lidar;
  });
  EXPECT_EQ(held->range_m, ranges);
  EXPECT_EQ(held->beams->directions_lidar, directions);
}

/// A LiDAR whose sweeps are traced in parts, the last part first, before they are requested.
class InParts final : public Sensor {
 public:
  explicit InParts(std::unique_ptr<Sensor> lidar) : Sensor({}), lidar_(std::move(lidar)) {}
  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    const int num_parts = lidar_->begin_sweep(now, truth);
    EXPECT_EQ(num_parts > 0, lidar_->makes_scan_by(now));
    for (int part = num_parts - 1; part >= 0; --part) {
      EXPECT_GE(lidar_->heading_of_part(part), 0);
      lidar_->trace_part(part);
    }
    lidar_->measure(now, truth, out);
  }
  std::span<const std::shared_ptr<LabeledScan>> scans() const override { return lidar_->scans(); }

 private:
  std::unique_ptr<Sensor> lidar_;
};

TEST(Lidar, IsIndependentOfPartOrder) {
  for (const char* pattern : {"ouster", "livox_mid360", "velodyne_puck"}) {
    Rig rig = busy_rig();
    rig.config.pattern = Module(lidar_pattern_types(), pattern);
    const Scans whole = rig.run(3);
    InParts in_parts(rig.make());
    Scans scans;
    drive(in_parts, rig.motions, {.duration_s = 0.3 + 1e-6, .tick = 10'000'000}, [&](TimeNs, const Observation&) {
      scans.insert(scans.end(), in_parts.scans().begin(), in_parts.scans().end());
    });
    ASSERT_EQ(scans.size(), 3U) << pattern;
    EXPECT_EQ(fingerprint(scans), fingerprint(whole)) << pattern;
  }
}

TEST(Lidar, AllocatesNothingAfterTheFirstScans) {
  for (const char* pattern : {"ouster", "livox_mid360"}) {
    Rig rig = busy_rig();
    rig.config.pattern = Module(lidar_pattern_types(), pattern);
    const auto sensor = rig.make();
    StateHistory history(3, 300);
    Observation observation;
    std::uint64_t before = 0;
    for (int scan = 1; scan <= 8; ++scan) {
      for (TimeNs t = (scan - 1) * 100'000'000LL; t <= scan * 100'000'000LL; t += 1'000'000) {
        for (int v = 0; v < 3; ++v) {
          VehicleState state = rig.motions[v](to_seconds(t));
          state.t = t;
          history.push(v, state);
        }
      }
      observation.clear();
      sensor->measure(scan * 100'000'000LL, history, observation);
      ASSERT_EQ(observation.scans.size(), 1U);
      if (scan == 4) before = test::num_allocations();
    }
    EXPECT_EQ(test::num_allocations(), before) << pattern;
  }
}

}  // namespace
}  // namespace swiftlet::sim
