// SPDX-License-Identifier: BSD-3-Clause
// Share of beams that return from a forest, and where in it they return.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "sim/world/relief.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

LidarConfig os1_128() {
  LidarConfig lidar;
  lidar.mount.position_m.setZero();
  lidar.rolling = false;
  return lidar;
}

LidarConfig os0_128() {
  LidarConfig lidar = os1_128();
  lidar.pattern.as<OusterConfig>().elevation_top_deg = 45.75;
  lidar.pattern.as<OusterConfig>().elevation_bottom_deg = -46.26;
  lidar.range_min_m = 0.3;
  lidar.range_max_m = 55.0;
  lidar.detection.range_10_percent_m = 18.3;
  lidar.detection.range_80_percent_m = 55.0;
  return lidar;
}

/// Share of the beams of scans at 2 to 5 m above the ground of the forest that return.
double share_in(const ForestConfig& forest, const LidarConfig& lidar, int num_places) {
  constexpr std::uint64_t kSeed = 1;
  SensorSetup setup = sensor_setup("lidar");
  setup.scene = std::make_shared<const Scene>(make_forest(forest, kSeed));
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  const Relief relief(forest.relief, kSeed);
  const Random random(7, "test.places");
  int fired = 0, returned = 0;
  for (int place = 0; place < num_places; ++place) {
    const auto sensor = make_lidar(lidar, setup);
    const double x = random.uniform(-22.0, 22.0, place, 0), y = random.uniform(-22.0, 22.0, place, 1);
    const Vector3 p_world_m(x, y, relief.height_m(x, y) + random.uniform(2.0, 5.0, place, 2));
    drive(*sensor, {resting(p_world_m)}, {.duration_s = 0.1001, .tick = 10'000'000}, [&](TimeNs, const Observation&) {
      for (const auto& s : sensor->scans()) {
        for (int i = 0; i < s->scan.size(); ++i) returned += s->scan.hit(i) ? 1 : 0;
        fired += s->scan.size();
      }
    });
  }
  return static_cast<double>(returned) / fired;
}

TEST(ForestReturns, MatchReturnShareOfRealForests) {
  ForestConfig alone;
  alone.surroundings_m = 0.0;
  constexpr int kPlaces = 6;
  double sum = 0.0;
  for (const LidarConfig& lidar : {os1_128(), os0_128()}) {
    const double with = share_in({}, lidar, kPlaces);
    EXPECT_GT(with, share_in(alone, lidar, kPlaces) + 0.05) << "a forest that ends at its edge returns less";
    sum += with;
  }
  EXPECT_NEAR(sum / 2.0, 0.82, 0.03) << "mean share of returns; 0.82 in a real flight";
}

/// Airborne first returns from vegetation above 2 m, in fifths of the stand's height (that of 95 % of the returns).
struct Profile {
  double fifths[5] = {}, mean = 0.0, cover = 0.0;
};

Profile airborne_profile(const ForestConfig& forest) {
  const StaticScene world(make_forest(forest, 1));
  const Relief relief(forest.relief, 1);
  const Random random(8, "test.airborne");
  std::vector<double> heights_m;
  constexpr int kShots = 40000;
  heights_m.reserve(kShots);
  for (int i = 0; i < kShots; ++i) {
    const double x = random.uniform(-25.0, 25.0, i, 0), y = random.uniform(-25.0, 25.0, i, 1);
    const RayHit hit = world.trace({x, y, 80.0}, -Vector3::UnitZ(), 100.0);
    const double height_m = 80.0 - static_cast<double>(hit.range_m) - relief.height_m(x, y);
    if (hit.range_m > 0.0F && height_m > 2.0) heights_m.push_back(height_m);
  }
  const auto count = static_cast<double>(heights_m.size());
  Profile profile;
  profile.cover = count / kShots;
  std::sort(heights_m.begin(), heights_m.end());
  const double stand_m = heights_m[heights_m.size() * 95 / 100];
  for (const double height_m : heights_m) {
    profile.fifths[std::min(4, static_cast<int>(5.0 * height_m / stand_m))] += 1.0 / count;
    profile.mean += height_m / stand_m / count;
  }
  return profile;
}

Profile profile_of(double detail, double pine, double spruce, double broadleaf) {
  ForestConfig forest;
  forest.surroundings_m = 0.0;
  forest.detail = detail;
  forest.pine_share = pine;
  forest.spruce_share = spruce;
  forest.broadleaf_share = broadleaf;
  return airborne_profile(forest);
}

// Returns of 5428 even-aged stands lie lowest in spruces, and closed crowns gather them [Racine 2021].
TEST(ForestReturns, LieLowestInSpruces) {
  constexpr double kCoarse = 0.25;
  const Profile pine = profile_of(kCoarse, 1, 0, 0), spruce = profile_of(kCoarse, 0, 1, 0),
                broadleaf = profile_of(kCoarse, 0, 0, 1), mixed = profile_of(kCoarse, 0.4, 0.35, 0.25);
  EXPECT_LT(spruce.mean, pine.mean - 0.1);
  EXPECT_LT(spruce.mean, broadleaf.mean - 0.1);
  EXPECT_GT(mixed.mean, spruce.mean);
  EXPECT_GT(broadleaf.cover, spruce.cover);
  // A crown's gaps are those of its leaf area, whatever it is made of.
  const Profile fine = profile_of(1.0, 0.4, 0.35, 0.25);
  EXPECT_NEAR(mixed.cover, fine.cover, 0.02);
  for (int fifth = 0; fifth < 5; ++fifth) EXPECT_NEAR(mixed.fifths[fifth], fine.fifths[fifth], 0.03) << fifth;
}

}  // namespace
}  // namespace swiftlet::sim
