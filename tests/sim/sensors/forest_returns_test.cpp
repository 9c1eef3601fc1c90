// SPDX-License-Identifier: BSD-3-Clause
// Share of beams that return from a forest, and where in it they return.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/relief.hpp"
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

/// Share of the beams of scans at 2 to 5 m above the ground of the forest that return, and the time of a scan.
struct Returns {
  double share = 0.0, scan_ms = 0.0, build_s = 0.0;
  std::size_t num_triangles = 0;
};

Returns returns_in(const ForestConfig& forest, const LidarConfig& lidar, int num_places) {
  const auto seconds_since = [](std::clock_t start) {
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  Returns returns;
  constexpr std::uint64_t kSeed = 1;
  const auto start = std::clock();
  SensorSetup setup = sensor_setup("lidar");
  setup.scene = std::make_shared<const Scene>(make_forest(forest, kSeed));
  setup.world = std::make_shared<const StaticScene>(*setup.scene);
  returns.build_s = seconds_since(start);
  returns.num_triangles = setup.scene->num_triangles();
  const Relief relief(forest.relief, kSeed);
  const Random random(7, "test.places");
  int fired = 0, returned = 0;
  for (int place = 0; place < num_places; ++place) {
    const auto sensor = make_lidar(lidar, setup);
    const double x = random.uniform(-22.0, 22.0, place, 0), y = random.uniform(-22.0, 22.0, place, 1);
    const Vector3 p_world_m(x, y, relief.height_m(x, y) + random.uniform(2.0, 5.0, place, 2));
    const auto first = std::clock();
    drive(*sensor, {resting(p_world_m)}, {.duration_s = 0.1001, .tick = 10'000'000}, [&](TimeNs, const Observation&) {
      for (const auto& s : sensor->scans()) {
        for (int i = 0; i < s->scan.size(); ++i) returned += s->scan.hit(i) ? 1 : 0;
        fired += s->scan.size();
      }
    });
    returns.scan_ms += 1e3 * seconds_since(first) / num_places;
  }
  returns.share = static_cast<double>(returned) / fired;
  return returns;
}

void print(const char* what, const Returns& r) {
  std::printf("%-40s %5.1f %% return, %7zu triangles, built in %.2f s, %.1f ms a scan\n", what, 100.0 * r.share,
              r.num_triangles, r.build_s, r.scan_ms);
}

// 82 % of the beams returned on a recorded flight through a forest.
TEST(ForestReturns, MatchReturnShareOfRealForests) {
  ForestConfig alone;
  alone.surroundings_m = 0.0;
  constexpr int kPlaces = 6;
  double sum = 0.0;
  for (const bool is_wide : {false, true}) {
    const LidarConfig lidar = is_wide ? os0_128() : os1_128();
    const Returns without = returns_in(alone, lidar, kPlaces), with = returns_in({}, lidar, kPlaces);
    print(is_wide ? "OS0-128, the forest ends at its edge" : "OS1-128, the forest ends at its edge", without);
    print(is_wide ? "OS0-128, the forest goes on" : "OS1-128, the forest goes on", with);
    EXPECT_LT(without.share, 0.73);
    EXPECT_GT(with.share, without.share + 0.05);
    // Far trees are cheap: most triangles are still those of the place.
    EXPECT_LT(with.num_triangles, 1.25 * static_cast<double>(without.num_triangles));
    sum += with.share;
  }
  EXPECT_NEAR(sum / 2.0, 0.82, 0.03);
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

Profile profile_of(const char* what, double detail, double pine, double spruce, double broadleaf) {
  ForestConfig forest;
  forest.surroundings_m = 0.0;
  forest.detail = detail;
  forest.pine_share = pine;
  forest.spruce_share = spruce;
  forest.broadleaf_share = broadleaf;
  const Profile profile = airborne_profile(forest);
  std::printf("%-10s detail %.1f: cover %2.0f %%, center at %2.0f %% of the stand, fifths from below", what, detail,
              100.0 * profile.cover, 100.0 * profile.mean);
  for (const double share : profile.fifths) std::printf(" %4.1f", 100.0 * share);
  std::printf(" %%\n");
  return profile;
}

// Returns of 5428 even-aged stands lie lowest in spruces, and closed crowns gather them [Racine 2021].
TEST(ForestReturns, LieLowestInSpruces) {
  const auto profiles = [](double detail) {
    return std::array{profile_of("pine", detail, 1, 0, 0), profile_of("spruce", detail, 0, 1, 0),
                      profile_of("broadleaf", detail, 0, 0, 1), profile_of("mixed", detail, 0.4, 0.35, 0.25)};
  };
  const auto large = profiles(0.25), small = profiles(1.0);
  const auto& [pine, spruce, broadleaf, mixed] = small;
  EXPECT_LT(spruce.mean, pine.mean - 0.1);
  EXPECT_LT(spruce.mean, broadleaf.mean - 0.1);
  EXPECT_GT(mixed.mean, spruce.mean);
  EXPECT_GT(broadleaf.cover, spruce.cover);
  // A crown's gaps are those of its leaf area, whatever it is made of.
  for (std::size_t i = 0; i < small.size(); ++i) {
    EXPECT_NEAR(large[i].cover, small[i].cover, 0.02) << i;
    for (int fifth = 0; fifth < 5; ++fifth) EXPECT_NEAR(large[i].fifths[fifth], small[i].fifths[fifth], 0.03) << i;
  }
}

}  // namespace
}  // namespace swiftlet::sim
