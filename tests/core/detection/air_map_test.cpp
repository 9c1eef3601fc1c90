// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/air_map.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "swiftlet/core/math/random.hpp"
#include "tests/support/config_checks.hpp"

namespace swiftlet {
namespace {

using testing::ConfigChecks;

/// The same by a table of the voxels that anything is known of, and by the part of a ray that lies in each.
class PlainAirMap {
 public:
  explicit PlainAirMap(const AirMapConfig& config) : config_(config) {
    for (int axis = 0; axis < 3; ++axis) {
      while (size_[axis] * config.voxel_m < config.size_m[axis]) size_[axis] *= 2;
    }
  }
  void follow(const Vector3& center_m) {
    for (int axis = 0; axis < 3; ++axis) min_[axis] = cell(center_m)[axis] - size_[axis] / 2;
    std::erase_if(counts_, [&](const auto& entry) { return !contains(entry.first); });
  }
  void pass(const Vector3& from_m, const Vector3& to_m) {
    for (int z = min_[2]; z < min_[2] + size_[2]; ++z) {
      for (int y = min_[1]; y < min_[1] + size_[1]; ++y) {
        for (int x = min_[0]; x < min_[0] + size_[0]; ++x) {
          if (meets(from_m / config_.voxel_m, to_m / config_.voxel_m, {x, y, z})) add({x, y, z}, 16, 0);
        }
      }
    }
  }
  void hit(const Vector3& p_m, double weight) {
    if (contains(cell(p_m))) add(cell(p_m), 0, static_cast<int>(std::lround(16.0 * std::clamp(weight, 0.0, 1.0))));
  }
  double clutter_share(const Vector3& p_m) const { return share(of(cell(p_m))); }
  bool is_free_around(const Vector3& p_m, int reach, double limit) const {
    bool free = true;
    around(p_m, reach, [&](const Counts& counts) { free = free && share(counts) <= limit; });
    return free;
  }
  bool is_hit_around(const Vector3& p_m, int reach, double limit) const {
    bool hit = false;
    around(p_m, reach, [&](const Counts& counts) {
      const double all = counts.hits + counts.passes;
      hit = hit || (all > 0.0 && counts.hits / all > limit);
    });
    return hit;
  }
  Vector3 middle_m(const Random& random, std::uint32_t i, double beyond) const {
    Vector3 p_m;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const double u = random.uniform(-beyond, 1.0 + beyond, i, 40 + axis);
      p_m[axis] = config_.voxel_m * (min_[axis] + u * size_[axis]);
    }
    return p_m;
  }

 private:
  using Voxel = std::array<int, 3>;
  struct Counts {
    int passes = 0, hits = 0;
  };
  Voxel cell(const Vector3& p_m) const {
    Voxel cell;
    for (int axis = 0; axis < 3; ++axis) cell[axis] = static_cast<int>(std::floor(p_m[axis] / config_.voxel_m));
    return cell;
  }
  bool contains(const Voxel& v) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (v[axis] < min_[axis] || v[axis] >= min_[axis] + size_[axis]) return false;
    }
    return true;
  }
  static bool meets(const Vector3& from, const Vector3& to, const Voxel& v) {
    double first = 0.0, last = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double way = to[axis] - from[axis];
      if (way == 0.0) {
        if (std::floor(from[axis]) != v[axis]) return false;
        continue;
      }
      const double a = (v[axis] - from[axis]) / way, b = (v[axis] + 1 - from[axis]) / way;
      first = std::max(first, std::min(a, b));
      last = std::min(last, std::max(a, b));
    }
    return first < last;
  }
  void add(const Voxel& v, int passes, int hits) {
    Counts& counts = counts_[v];
    counts.passes += passes;
    counts.hits += hits;
    if (counts.passes + counts.hits > 16 * config_.memory_beams) {
      counts.passes /= 2;
      counts.hits /= 2;
    }
  }
  Counts of(const Voxel& v) const {
    const auto found = counts_.find(v);
    return found == counts_.end() ? Counts{} : found->second;
  }
  double share(const Counts& counts) const {
    const double hits = counts.hits / 16.0 + config_.prior_hits, passes = counts.passes / 16.0 + config_.prior_passes;
    return hits / (hits + passes);
  }
  template <class Visit>
  void around(const Vector3& p_m, int reach, Visit&& visit) const {
    const Voxel middle = cell(p_m);
    for (int x = -reach; x <= reach; ++x) {
      for (int y = -reach; y <= reach; ++y) {
        for (int z = -reach; z <= reach; ++z) visit(of({middle[0] + x, middle[1] + y, middle[2] + z}));
      }
    }
  }

  AirMapConfig config_;
  std::array<int, 3> size_ = {1, 1, 1}, min_ = {0, 0, 0};
  std::map<Voxel, Counts> counts_;
};

TEST(AirMap, IsThatOfAPlainTable) {
  int free = 0, hit = 0;
  for (std::uint32_t trial = 0; trial < 6; ++trial) {
    const Random random(trial, "air");
    AirMapConfig config;
    config.voxel_m = 0.3 + 0.2 * trial;
    config.size_m = config.voxel_m * Vector3(3.5 + trial, 7.5 - trial, trial % 2 == 0 ? 0.7 : 8.0);
    config.memory_beams = 8;
    config.prior_hits = 0.25;
    config.prior_passes = 0.5;
    AirMap map(config);
    PlainAirMap plain(config);
    Vector3 center_m = Vector3::Zero();
    for (std::uint32_t i = 0; i < 300; ++i) {
      const auto u = [&](std::uint32_t k) { return random.uniform(i, k); };
      if (i % 30 == 0) {
        const double reach = i % 120 == 0 ? 20.0 : 2.0;  // sometimes nothing of the box stays
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
          center_m[axis] += config.voxel_m * reach * (random.uniform(i, 50 + axis) - 0.5);
        }
        map.follow(center_m);
        plain.follow(center_m);
      }
      const Vector3 a_m = plain.middle_m(random, 2 * i, i % 3 == 0 ? 1.0 : 0.0);
      Vector3 b_m = plain.middle_m(random, 2 * i + 1, 0.5);
      if (i % 5 == 1) b_m.z() = a_m.z();              // along layers
      if (i % 5 == 2) b_m.tail<2>() = a_m.tail<2>();  // and along one axis
      if (i % 5 == 3) b_m.head<2>() = a_m.head<2>();
      for (int repeat = 0; repeat < 1 + static_cast<int>(4.0 * u(2)); ++repeat) {
        map.pass(a_m, b_m);
        plain.pass(a_m, b_m);
      }
      const Vector3 hit_m = plain.middle_m(random, 1000 + i, 0.2);
      map.hit(hit_m, 2.0 * u(3) - 0.5);
      plain.hit(hit_m, 2.0 * u(3) - 0.5);
      for (std::uint32_t k = 0; k < 12; ++k) {
        const Vector3 at_m = plain.middle_m(random, 5000 + 20 * i + k, 0.3);
        ASSERT_NEAR(map.clutter_share(at_m), plain.clutter_share(at_m), 1e-12) << trial << " " << i;
        const int reach = static_cast<int>(k) % 3;
        const double limit = 0.35 * random.uniform(i, 100 + k);
        ASSERT_EQ(map.is_free_around(at_m, reach, limit), plain.is_free_around(at_m, reach, limit)) << i;
        ASSERT_EQ(map.is_hit_around(at_m, reach, limit), plain.is_hit_around(at_m, reach, limit)) << i;
        free += plain.is_free_around(at_m, reach, limit);
        hit += plain.is_hit_around(at_m, reach, limit);
      }
    }
    EXPECT_DOUBLE_EQ(map.prior_share(), 1.0 / 3.0);
    EXPECT_EQ(map.voxel_m(), config.voxel_m);
  }
  EXPECT_GT(free, 1000);
  EXPECT_GT(hit, 1000);
}

// A share that equals the limit is not greater than it.
TEST(AirMap, AShareThatEqualsTheLimitIsNotAboveIt) {
  AirMapConfig config;
  config.size_m = {4.0, 4.0, 4.0};
  config.prior_hits = 0.25;
  config.prior_passes = 0.75;
  AirMap map(config);
  map.follow(Vector3::Zero());
  EXPECT_TRUE(map.is_free_around(Vector3::Zero(), 1, 0.25));
  EXPECT_FALSE(map.is_free_around(Vector3::Zero(), 1, 0.249));
  map.hit({0.1, 0.1, 0.1}, 1.0);
  for (int i = 0; i < 3; ++i) map.pass({0.1, 0.1, 0.1}, {0.2, 0.1, 0.1});
  EXPECT_FALSE(map.is_hit_around({0.1, 0.1, 0.1}, 0, 0.25));
  EXPECT_TRUE(map.is_hit_around({0.1, 0.1, 0.1}, 0, 0.249));
  EXPECT_FALSE(map.is_hit_around({0.9, 0.1, 0.1}, 0, 0.0)) << "nothing is known there";
}

TEST(AirMap, ABeamThatIsNowhereChangesNothing) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  AirMapConfig config;
  config.size_m = {4.0, 4.0, 4.0};
  AirMap map(config);
  map.follow(Vector3::Zero());
  for (const double bad : {kNaN, kInf, -kInf}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vector3 at_m(0.3, 0.3, 0.3);
      at_m[axis] = bad;
      map.pass(at_m, {0.1, 0.2, 0.3});
      map.pass({0.1, 0.2, 0.3}, at_m);
    }
  }
  for (double x = -1.75; x < 2.0; x += 0.5) {
    for (double y = -1.75; y < 2.0; y += 0.5) {
      for (double z = -1.75; z < 2.0; z += 0.5) ASSERT_EQ(map.clutter_share({x, y, z}), map.prior_share());
    }
  }
}

TEST(AirMap, ItsBoxIsRoundedUpToPowersOfTwo) {
  AirMapConfig config;
  config.voxel_m = 0.5;
  const auto voxels = [&](double x, double y, double z) {
    config.size_m = 0.5 * Vector3(x, y, z);
    return config.bytes() / 4.0;
  };
  EXPECT_EQ(voxels(4.0, 5.0, 8.0), 4.0 * 8.0 * 8.0);
  EXPECT_EQ(voxels(9.0, 1.0, 0.2), 16.0);
  EXPECT_EQ(voxels(2.0, 3.0, 1.0), 2.0 * 4.0);
  EXPECT_EQ(voxels(1e6, 1.0, 1.0), 4096.0) << "no axis is longer";
}

TEST(AirMap, ItsSettingsAreBounded) {
  AirMapConfig config;
  config.voxel_m = 0.5;
  const auto refuses = [&](double x, double y, double z) {
    config.size_m = 0.5 * Vector3(x, y, z);
    return ConfigChecks(config).refuses("size_m");
  };
  EXPECT_TRUE(ConfigChecks(AirMapConfig{}).refuses_nothing());
  EXPECT_FALSE(refuses(4096.0, 4096.0, 4.0));
  EXPECT_TRUE(refuses(4097.0, 1.0, 1.0));
  EXPECT_TRUE(refuses(1.0, 1.0, 4097.0));
  EXPECT_FALSE(refuses(1024.0, 1024.0, 512.0));
  EXPECT_TRUE(refuses(1024.0, 1024.0, 1024.0)) << "1.07e9 voxels";
  // Counts of 1/16 beam are kept in 16 bits, with one beam more for a moment.
  EXPECT_EQ(ConfigChecks(AirMapConfig{}).range("memory_beams").max, 1000.0);
}

}  // namespace
}  // namespace swiftlet
