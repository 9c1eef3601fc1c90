// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/vofod_stages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "swiftlet/core/math/random.hpp"
#include "tests/bench/reference_detection.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;
constexpr TimeNs kPeriod = 100'000'000;

VofodConfig small_config() {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;
  config.map.center_m = {0.0, 0.0, 3.0};
  config.map.size_m = {26.0, 26.0, 8.0};
  config.ray_max_m = 12.0;
  config.ray_weight = 0.03;  // a fifth of an OS1's rays must clear the air within a few scans
  return config;
}

/// Scans of a world from a place, each through all three stages.
class Flight {
 public:
  explicit Flight(const VofodConfig& config) : stages(config) {}

  std::vector<Detection> scan(const World& world, const Vector3& from = {0.0, 0.0, 2.0}) {
    const auto full = scan_world(world, pose_at(from, 0.01 * count_), beams_, count_ * kPeriod);
    const auto cloud = cloud_of(knows_points_alone ? points_alone(*full) : full);
    ++count_;
    std::vector<Detection> detections;
    stages.cast_rays(*cloud);
    stages.classify(*cloud, detections);
    stages.apply_rays(1);
    if (removes_separate) {
      stages.find_separate();
      stages.remove_separate(1);
    }
    return detections;
  }
  void look_around(const World& world, int scans) {
    for (int i = 0; i < scans; ++i) scan(world);
  }

  VofodStages stages;
  bool knows_points_alone = false;
  bool removes_separate = true;  // needs confident voxels, so more points than these scans have

 private:
  std::shared_ptr<const BeamTable> beams_ = make_beams(64, 384, 30.0, -30.0);
  int count_ = 0;
};

TEST(VofodStages, LocatesFlyingObjectInExploredAir) {
  Flight flight(small_config());
  flight.look_around(ground(), 10);
  for (const double x : {4.0, 6.0, 8.0}) {
    const Vector3 at(x, 1.0, 2.5);
    const auto found = flight.scan(all_of({ground(), sphere(at, 0.3)}));
    ASSERT_EQ(found.size(), 1u) << "at " << x << " m";
    // Seen from one side only: off by at most the radius, towards the sensor.
    EXPECT_LT((found[0].position_m - at).norm(), 0.3);
    EXPECT_LT((found[0].position_m - Vector3(0.0, 0.0, 2.0)).norm(), (at - Vector3(0.0, 0.0, 2.0)).norm());
    EXPECT_GT(found[0].num_points, 5);
    EXPECT_GT(found[0].confidence, 0.0);
    EXPECT_LE(found[0].confidence, 1.0);
    EXPECT_LT(found[0].extent_m.norm(), 1.1);
  }
}

// The field of view is learned from the ground and a wall, or stated.
TEST(VofodStages, DetectsByPointsAlone) {
  for (const bool is_stated : {false, true}) {
    VofodConfig config = small_config();
    if (is_stated) config.field_of_view = {.bottom_deg = -30.0, .top_deg = 30.0};
    Flight flight(config);
    flight.knows_points_alone = true;
    const World background = all_of({ground(), bar({-9.0, 2.0, 0.0}, {-9.0, 2.0, 7.5}, 0.3)});
    flight.look_around(background, 20);
    int found = 0;
    for (int i = 0; i < 10; ++i) {
      const Vector3 at(5.0, 0.3 * i - 1.5, 2.5);
      const auto detections = flight.scan(all_of({background, sphere(at, 0.3)}));
      found += detections.size() == 1 && (detections[0].position_m - at).norm() < 0.31;
    }
    EXPECT_GE(found, 9) << (is_stated ? "stated" : "learned");
  }
}

// The lower end of a post is out of view, and rays that graze the edge of the view clear the voxel below it.
TEST(VofodStages, EdgeThingsFlyOnceMoved) {
  for (const double still_s : {0.0, 0.2}) {
    VofodConfig config = small_config();
    config.still_s = still_s;
    config.map.center_m = {0.0, 0.0, 0.0};
    Flight flight(config);
    std::size_t standing = 0, flying = 0;
    const auto post = [](double y_m) { return bar({4.0, y_m, -2.0}, {4.0, y_m, 0.0}, 0.2); };
    for (int i = 0; i < 30; ++i) standing += flight.scan(post(0.0)).size();
    for (int i = 1; i <= 20; ++i) flying += flight.scan(post(0.1 * i)).size();
    EXPECT_EQ(standing > 3, still_s == 0.0) << standing;
    EXPECT_GE(flying, 5U);
  }
}

TEST(VofodStages, ReportsBrightestReturnOfEachCluster) {
  for (const auto clustering : {VofodChoices::Clustering::kPoints, VofodChoices::Clustering::kVoxels}) {
    VofodConfig config = small_config();
    config.choices.clustering = clustering;
    Flight flight(config);
    flight.look_around(ground(), 10);
    const Vector3 marked(5.0, 2.0, 2.5), plain(5.0, -2.0, 2.5);
    const World world = all_of({ground(), sphere(marked, 0.3), sphere(plain, 0.3)});
    const Pose T_local_lidar = pose_at({0.0, 0.0, 2.0}, 0.1);
    const auto scan =
        std::make_shared<Scan>(*scan_world(world, T_local_lidar, make_beams(64, 384, 30.0, -30.0), 20 * kPeriod));
    int bright = 0;
    scan->reflectivity.assign(scan->range_m.size(), 0.3F);
    for (int i = 0; i < scan->size(); ++i) {
      const Vector3 p = T_local_lidar * scan->point_lidar(i).cast<double>();
      if (!scan->hit(i) || (p - marked).norm() > 0.31 || bright > 0) continue;
      scan->reflectivity[i] = 18.0F;
      ++bright;
    }
    std::vector<Detection> found;
    flight.stages.classify(*cloud_of(scan), found);
    ASSERT_EQ(found.size(), 2U);
    for (const Detection& d : found) EXPECT_EQ(d.reflectivity, d.position_m.y() > 0.0 ? 18.0 : 0.3F);
  }
}

/// Detections in a world where nothing flies, or of what does in it, after the air around has been seen.
int found_in(const World& world, double cluster_distance_m, int scans, const VofodConfig& base = small_config()) {
  VofodConfig config = base;
  config.cluster_distance_m = cluster_distance_m;
  Flight flight(config);
  int found = 0;
  for (int i = 0; i < scans; ++i) found += static_cast<int>(flight.scan(all_of({ground(), world})).size());
  return found;
}
constexpr double kPapers_m = 0.25;  // d_cluster of Table II

// Leaves are farther apart than d_cluster of Table II, so each of them is a small object in the air that its neighbors'
// rays have cleared.
TEST(VofodStages, AThinCrownIsBackground) {
  const Random random(3, "leaves");
  std::vector<World> leaves;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const auto n = random.normal3(i, 0);
    const Vector3 at =
        Vector3(7.0, 0.0, 4.5) + 1.8 * std::cbrt(random.uniform(i, 4)) * Vector3(n[0], n[1], n[2]).normalized();
    leaves.push_back(sphere(at, 0.06));
  }
  EXPECT_EQ(found_in(all_of(leaves), VofodConfig{}.cluster_distance_m, 15), 0);
  EXPECT_GT(found_in(all_of(leaves), kPapers_m, 15), 20);
}

// A slowly rising wire meets a row of beams here and there; only an end without near points looks like an object.
TEST(VofodStages, TreatsFreeHangingStructuresAsBackground) {
  const std::vector<World> things = {bar({5.0, -4.0, 2.0}, {5.0, 3.2, 2.81}, 0.025),
                                     bar({-6.0, -3.0, 2.0}, {-6.0, 3.0, 4.0}, 0.025),
                                     bar({1.0, 6.0, 0.9}, {1.0, 6.0, 5.5}, 0.025)};
  EXPECT_LE(found_in(all_of(things), VofodConfig{}.cluster_distance_m, 15), 1);
  EXPECT_GT(found_in(all_of(things), kPapers_m, 15), 100);
}

// A hull and six motors on arms too thin to be hit: 2 m across.
TEST(VofodStages, ALargeTargetIsOneDetection) {
  for (const double d_cluster_m : {VofodConfig{}.cluster_distance_m, kPapers_m}) {
    VofodConfig config = small_config();
    config.cluster_distance_m = d_cluster_m;
    Flight flight(config);
    flight.look_around(ground(), 12);
    std::size_t found = 0;
    for (int i = 0; i < 8; ++i) {
      const Vector3 at(4.5, 0.2 * i - 0.8, 2.5);
      std::vector<World> parts = {ground(), sphere(at, 0.28)};
      for (int k = 0; k < 6; ++k) {
        const double angle = std::numbers::pi / 3.0 * k;
        parts.push_back(sphere(at + 0.87 * Vector3(std::cos(angle), std::sin(angle), 0.0), 0.14));
      }
      found += flight.scan(all_of(parts)).size();
    }
    if (d_cluster_m == kPapers_m) {
      EXPECT_GT(found, 16u);
    } else {
      EXPECT_EQ(found, 8u);
    }
  }
}

TEST(VofodStages, DetectsNothingInUnexploredAir) {
  Flight flight(small_config());
  EXPECT_TRUE(flight.scan(all_of({ground(), sphere({6.0, 1.0, 2.5}, 0.3)})).empty());
}

TEST(VofodStages, TreatsGroundedObjectsAsBackground) {
  Flight flight(small_config());
  flight.look_around(ground(), 10);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(flight.scan(all_of({ground(), sphere({6.0, 1.0, 0.3}, 0.3)})).empty());
}

TEST(VofodStages, DetectsTakeoffAndClearsItsPlace) {
  Flight flight(small_config());
  flight.look_around(all_of({ground(), sphere({5.0, 1.0, 0.3}, 0.3)}), 12);
  std::size_t found = 0;
  for (int i = 0; i < 40; ++i) {
    found += flight.scan(all_of({ground(), sphere({5.0, 1.0, std::min(0.3 + 0.1 * i, 3.0)}, 0.3)})).size();
  }
  EXPECT_GT(found, 10u);
  // No trail between the ground and the object.
  for (const double z : {1.2, 1.6, 2.0}) {
    EXPECT_LT(flight.stages.map().state_at({5.0, 1.0, z}), VoxelState::kTentative) << z;
  }
}

TEST(VofodStages, TheGroundBecomesBackground) {
  VofodConfig config = small_config();
  config.ray_weight = 0.003;  // Table II: points outweigh the rays that graze the ground
  Flight flight(config);
  flight.removes_separate = false;
  flight.look_around(ground(0.1), 10);
  EXPECT_GE(flight.stages.map().state_at({4.0, 1.0, 0.1}), VoxelState::kTentative);
  EXPECT_LT(flight.stages.map().state_at({5.0, 2.0, 2.0}), VoxelState::kTentative);
}

TEST(VofodStages, FindsNoBackgroundWithoutASeed) {
  VofodConfig config = small_config();
  config.seed = VofodSeed::kNone;
  config.ray_weight = 0.003;
  Flight flight(config);
  flight.removes_separate = false;
  const auto low = [&] { flight.scan(ground(0.1), {0.0, 0.0, 1.0}); };
  for (int i = 0; i < 5; ++i) low();
  EXPECT_EQ(flight.stages.map().num_occupied(), 0);
  flight.stages.seed_ground({2.0, 0.0, 0.1});
  flight.stages.seed_ground({2.0, 0.0, 0.1});  // twice: tentative
  for (int i = 0; i < 5; ++i) low();
  EXPECT_GT(flight.stages.map().num_occupied(), 200);
}

TEST(VofodStages, AKnownMapSeedsTheBackground) {
  VofodConfig config = small_config();
  config.seed = VofodSeed::kNone;
  Flight flight(config);
  flight.stages.map().set_prior(known_ground());
  flight.look_around(ground(), 10);
  EXPECT_EQ(flight.stages.map().state_at({4.0, 1.0, -0.01}), VoxelState::kConfident);
  EXPECT_EQ(flight.scan(all_of({ground(), sphere({6.0, 1.0, 2.5}, 0.3)})).size(), 1u);
}

class VofodStagesByDistance : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(ClusterDistance, VofodStagesByDistance, ::testing::Values(kPapers_m, 0.7));

TEST_P(VofodStagesByDistance, MatchesReferenceImplementationOfThePaper) {
  const Random random(1, "flight");
  VofodConfig config = small_config();
  config.cluster_distance_m = GetParam();
  config.ray_weight = 0.06;
  config.still_s = 0.0;  // a rule that the paper does not have
  VofodStages stages(config);
  reference::Vofod reference(config);
  const auto beams = make_beams(48, 320, 30.0, -30.0);
  std::size_t found = 0;
  for (int i = 0; i < 25; ++i) {
    const double phase = 0.15 * i;
    std::vector<World> things = {ground(0.05), sphere({-8.0, 3.0, 1.0}, 1.5)};
    if (i > 8) things.push_back(sphere({5.0 * std::cos(phase), 5.0 * std::sin(phase), 2.5}, 0.35));
    if (i > 12) things.push_back(sphere({-4.0, -4.0, 0.2 + 0.2 * (i - 12)}, 0.3));
    const Pose pose = pose_at({0.05 * i, 0.3 * random.uniform(i, 0), 2.0}, 0.1 * i);
    const auto cloud = cloud_of(scan_world(all_of(things), pose, beams, i * kPeriod));
    std::vector<Detection> ours;
    stages.cast_rays(*cloud);
    stages.classify(*cloud, ours);
    stages.apply_rays(1);
    stages.find_separate();
    stages.remove_separate(1);
    const auto theirs = reference.classify(*cloud);
    reference.cast_rays(*cloud, 1);
    reference.remove_separate(1);

    ASSERT_EQ(ours.size(), theirs.size()) << "scan " << i;
    for (std::size_t k = 0; k < ours.size(); ++k) {
      EXPECT_LT((ours[k].position_m - theirs[k].position_m).norm(), 1e-4);
      EXPECT_EQ(ours[k].num_points, theirs[k].num_points);
    }
    found += ours.size();
    for (std::ptrdiff_t v = 0; v < stages.map().grid().num_cells(); ++v) {
      const double G = reference.map.G[reference.map.index(stages.map().grid().cell(v))];
      ASSERT_NEAR(stages.map().value(v), G, 0.05)
          << "scan " << i << " voxel " << stages.map().grid().cell(v).transpose();
    }
  }
  EXPECT_GT(found, 10u);
}

TEST(VofodStages, EveryReadingFindsTheObject) {
  const auto with = [](auto&& change) {
    VofodConfig config = small_config();
    change(config.choices);
    Flight flight(config);
    flight.stages.map().set_prior(known_ground());  // some interpretations need confident background
    flight.look_around(ground(), 12);
    std::size_t found = 0;
    for (int i = 0; i < 8; ++i) {
      found += flight.scan(all_of({ground(), sphere({4.5 + 0.3 * i, 1.0, 2.3}, 0.35)})).size();
    }
    return found;
  };
  EXPECT_GE(with([](VofodChoices&) {}), 6u);
  EXPECT_GE(with([](VofodChoices& c) { c.clustering = VofodChoices::Clustering::kVoxels; }), 3u);
  EXPECT_GE(with([](VofodChoices& c) { c.position = VofodChoices::Position::kBoxCenter; }), 6u);
  EXPECT_GE(with([](VofodChoices& c) { c.search = VofodChoices::Search::kOctahedron; }), 6u);
  EXPECT_GE(with([](VofodChoices& c) { c.map_update = VofodChoices::MapUpdate::kBefore; }), 6u);
  EXPECT_GE(with([](VofodChoices& c) { c.separate_becomes = VofodChoices::SeparateBecomes::kFree; }), 6u);
}

TEST(VofodStages, WidensLateralCovarianceByPoseNoise) {
  VofodConfig config = small_config();
  config.covariance = DetectionCovariance::kPoseNoise;
  config.sigma_m = 0.01;
  config.sigma_attitude_rad = 0.05;
  Flight flight(config);
  flight.look_around(ground(), 10);
  const auto found = flight.scan(all_of({ground(), sphere({8.0, 0.0, 2.0}, 0.3)}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].covariance(1, 1), std::pow(7.75 * 0.05, 2) + 0.05 * 0.05 + 0.01 * 0.01, 0.01);
  EXPECT_NEAR(found[0].covariance(0, 0), 0.03 * 0.03 + 0.05 * 0.05 + 0.01 * 0.01, 0.002);
}

// A near object has more points per voxel, but no higher confidence.
TEST(VofodStages, ConfidenceCountsVoxels) {
  std::vector<Eigen::Vector3f> points = {{1.1F, 1.1F, 3.1F}, {1.3F, 1.1F, 3.1F}, {1.1F, 1.3F, 3.3F}};
  std::vector<double> confidences;
  for (const int copies : {1, 30}) {
    VofodStages stages(small_config());
    for (std::ptrdiff_t i = 0; i < stages.map().grid().num_cells(); ++i) stages.map().set(i, -990.0F);
    std::vector<Eigen::Vector3f> all;
    for (int k = 0; k < copies; ++k) all.insert(all.end(), points.begin(), points.end());
    std::vector<Detection> detections;
    stages.classify(cloud_from({0.0, 0.0, 2.0}, all), detections);
    ASSERT_EQ(detections.size(), 1u);
    confidences.push_back(detections[0].confidence);
  }
  EXPECT_DOUBLE_EQ(confidences[0], confidences[1]);
  EXPECT_LT(confidences[0], 0.9);
}

TEST(VofodStages, NoCloudBreaksIt) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  std::vector<std::vector<Eigen::Vector3f>> clouds = {
      {},
      {{1.0F, 1.0F, 1.0F}},
      std::vector<Eigen::Vector3f>(100'000, {1.0F, 1.0F, 4.0F}),
      {{kNaN, 0.0F, 0.0F}, {kInf, -kInf, kNaN}, {3e38F, -3e38F, 0.0F}, {0.0F, 0.0F, 4.0F}},
  };
  const Random random(5, "fuzz");
  std::vector<Eigen::Vector3f> wild;
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    const float scale = std::pow(10.0F, static_cast<float>(40.0 * random.uniform(i, 0) - 20.0));
    wild.emplace_back(scale * static_cast<float>(random.normal(i, 1)), scale * static_cast<float>(random.normal(i, 2)),
                      i % 17 == 0 ? kNaN : scale * static_cast<float>(random.normal(i, 3)));
  }
  clouds.push_back(wild);
  for (const auto clustering : {VofodChoices::Clustering::kPoints, VofodChoices::Clustering::kVoxels}) {
    VofodConfig config = small_config();
    config.choices.clustering = clustering;
    VofodStages stages(config);
    std::vector<Detection> detections;
    for (int repeat = 0; repeat < 3; ++repeat) {
      for (const auto& points : clouds) {
        const LocalCloud cloud = cloud_from({0.0, 0.0, 2.0}, points);
        stages.cast_rays(cloud);
        stages.classify(cloud, detections);
        stages.apply_rays(1);
        stages.find_separate();
        stages.remove_separate(1);
      }
    }
    for (const Detection& d : detections) EXPECT_TRUE(d.position_m.allFinite() && d.covariance.allFinite());
    for (std::ptrdiff_t i = 0; i < stages.map().grid().num_cells(); ++i) {
      ASSERT_TRUE(std::isfinite(stages.map().value(i)));
    }
  }
}

TEST(VofodStages, IgnoresNonFiniteRays) {
  auto beams = std::make_shared<BeamTable>(*make_beams(4, 16));
  beams->directions_lidar[3] = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  beams->origins_lidar[5] = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
  auto scan = std::make_shared<Scan>(*scan_world(ground(), pose_at({0.0, 0.0, 4.0}), beams, 0));
  scan->range_m[7] = std::numeric_limits<float>::quiet_NaN();
  scan->range_m[8] = std::numeric_limits<float>::infinity();
  scan->range_m[9] = -1.0F;
  VofodStages stages(small_config());
  stages.cast_rays(*cloud_of(scan));
  stages.apply_rays(1);
  for (std::ptrdiff_t i = 0; i < stages.map().grid().num_cells(); ++i) {
    ASSERT_TRUE(std::isfinite(stages.map().value(i)));
  }
  EXPECT_LT(stages.map().value(stages.map().grid().index(stages.map().grid().cell_of({0.1, 0.1, 4.1}))), -740.0F);
}

}  // namespace
}  // namespace swiftlet
