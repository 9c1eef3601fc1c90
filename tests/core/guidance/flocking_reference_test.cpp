// SPDX-License-Identifier: BSD-3-Clause
// Both models of flocking beside their rules written out plainly, among neighbors that come and go and among obstacles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "swiftlet/core/guidance/flocking.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;
using testing::ToldMap;

Vector3 level(const Vector3& v) { return {v.x(), v.y(), 0.0}; }

/// Of something that is that far away: none at `distance_m`, `gain` at half of it, as 1 / d - 1 / distance goes.
Vector3 push_from(const Vector3& p_m, const Vector3& other_m, double distance_m, double gain) {
  const Vector3 away_m = level(p_m - other_m);
  const double d = std::max(away_m.norm(), 1e-3);
  return d < distance_m ? Vector3(gain * (distance_m - d) / (d * d) * away_m) : Vector3(Vector3::Zero());
}

/// The nearest thing at the height of flight, looked up ten times a second.
class PlainObstacle {
 public:
  PlainObstacle(const FlockObstacleConfig& config, const std::vector<Vector3>& cells_m, double edge_m)
      : config_(config), cells_m_(cells_m), half_m_(0.5 * edge_m) {}
  Vector3 push(const Vector3& p_m, TimeNs now) {
    if (!config_.enabled) return Vector3::Zero();
    if (now >= next_) {
      next_ = now + kNsPerSecond / 10;
      seen_ = false;
      double least_m = config_.avoid_distance_m;
      for (const Vector3& cell_m : cells_m_) {
        const Vector3 low_m = cell_m - Vector3::Constant(half_m_), high_m = cell_m + Vector3::Constant(half_m_);
        const Vector3 near_m = p_m.cwiseMax(low_m).cwiseMin(high_m);
        const bool in_reach = (near_m - p_m).norm() <= config_.avoid_distance_m;
        if (!in_reach || std::abs(cell_m.z() - p_m.z()) > 0.6 || level(near_m - p_m).norm() >= least_m) continue;
        least_m = level(near_m - p_m).norm();
        near_m_ = near_m;
        seen_ = true;
      }
    }
    return seen_ ? push_from(p_m, near_m_, config_.avoid_distance_m, config_.avoid_gain_mps) : Vector3(Vector3::Zero());
  }

 private:
  FlockObstacleConfig config_;
  std::vector<Vector3> cells_m_;
  double half_m_;
  Vector3 near_m_ = Vector3::Zero();
  bool seen_ = false;
  TimeNs next_ = 0;
};

class PlainPacnav {
 public:
  PlainPacnav(const PacnavConfig& config, PlainObstacle obstacle) : c_(config), obstacle_(std::move(obstacle)) {}

  Vector3 velocity(const Vector3& p_m, std::span<const Neighbor> neighbors, TimeNs now) {
    remember(neighbors, now);
    Vector3 v = level((c_.informed ? c_.goal_m : behind_leader(p_m)) - p_m);
    v *= v.norm() > 1e-3 ? std::min(1.0, c_.speed_mps / v.norm()) : 0.0;
    for (const Neighbor& other : neighbors)
      v += push_from(p_m, other.position_local_m, c_.avoid_distance_m, c_.avoid_gain_mps);
    v += obstacle_.push(p_m, now);
    return v.norm() > c_.speed_mps ? Vector3(v.normalized() * c_.speed_mps) : v;
  }
  int num_led() const { return num_led_; }

 private:
  struct Path {
    std::vector<Vector3> points_m;
    TimeNs last = 0;
  };
  void remember(std::span<const Neighbor> neighbors, TimeNs now) {
    const auto most = static_cast<std::size_t>(c_.memory_s / c_.sample_s) + 1;
    for (const Neighbor& other : neighbors) {
      if (paths_.count(other.key) == 0) order_.push_back(other.key);
      Path& path = paths_[other.key];
      if (!path.points_m.empty() && now < path.last + from_seconds(c_.sample_s)) continue;
      path.points_m.push_back(other.position_local_m);
      path.last = now;
      if (path.points_m.size() > most) path.points_m.erase(path.points_m.begin());
    }
    const auto is_old = [&](std::int64_t key) { return now > paths_[key].last + from_seconds(c_.memory_s); };
    for (const std::int64_t key : std::vector(order_)) {
      if (!is_old(key)) continue;
      paths_.erase(key);
      std::erase(order_, key);
    }
  }
  static double straightness(const Path& path) {
    double way_m = 0.0;
    for (std::size_t i = 0; i + 1 < path.points_m.size(); ++i)
      way_m += (path.points_m[i + 1] - path.points_m[i]).norm();
    return way_m > 1e-3 ? (path.points_m.back() - path.points_m.front()).norm() / way_m : 0.0;
  }
  double likeness(std::int64_t key) const {
    const Vector3 own = level(paths_.at(key).points_m.back() - paths_.at(key).points_m.front());
    std::vector<double> cosines;
    for (const auto& [other, path] : paths_) {
      const Vector3 its = level(path.points_m.back() - path.points_m.front());
      if (other == key || path.points_m.size() < 2 || own.norm() * its.norm() < 1e-3) continue;
      cosines.push_back(own.dot(its) / (own.norm() * its.norm()));
    }
    double mean = 0.0;
    for (const double cosine : cosines) mean += cosine / static_cast<double>(cosines.size());
    return mean;
  }
  Vector3 behind_leader(const Vector3& p_m) {
    double best = 0.0;
    const Path* leader = nullptr;
    for (const std::int64_t key : order_) {
      const Path& path = paths_.at(key);
      const double straight = straightness(path), score = straight * (1.0 + std::max(0.0, likeness(key)));
      if (path.points_m.size() < 3 || straight < c_.least_persistence || score <= best) continue;
      best = score;
      leader = &path;
    }
    if (leader == nullptr) return p_m;
    ++num_led_;
    const Vector3 off_m = level(p_m - leader->points_m.back());
    if (off_m.norm() <= c_.follow_radius_m) return p_m;
    return leader->points_m.back() + c_.follow_radius_m * off_m.normalized();
  }

  PacnavConfig c_;
  PlainObstacle obstacle_;
  std::map<std::int64_t, Path> paths_;
  std::vector<std::int64_t> order_;
  int num_led_ = 0;
};

/// Others that fly about, turn once in a while, and are out of sight once in a while.
class Others {
 public:
  Others(std::uint64_t seed, double speed_mps) : random_(seed, "test.others"), speed_mps_(speed_mps) {
    for (std::uint32_t i = 0; i < 5; ++i) {
      const double x = random_.uniform(-9.0, 9.0, 0, 2 * i);
      places_m_.emplace_back(x, random_.uniform(-9.0, 9.0, 0, 2 * i + 1), 2.0 + 0.3 * i);
    }
  }
  void show(std::uint32_t tick, GuidanceDriver& driver) {
    for (std::uint32_t i = 0; i < 5; ++i) {
      const std::uint32_t leg = 1000 + (tick + 7 * i) / 30;
      const double turn = random_.uniform(-3.2, 3.2, leg, 3 * i), v_mps = random_.uniform(leg, 3 * i + 1) * speed_mps_;
      places_m_[i] += driver.dt_s * v_mps * Vector3(std::cos(turn), std::sin(turn), 0.1);
      const bool hidden = random_.uniform((tick + 5 * i) / 60, 900 + i) < 0.3;
      if (!hidden) driver.sees(static_cast<VehicleId>(i) + 1, places_m_[i]);
    }
  }

 private:
  Random random_;
  double speed_mps_;
  std::vector<Vector3> places_m_;
};

std::vector<Vector3> trees_m(std::uint64_t seed) {
  const Random random(seed, "test.trees");
  std::vector<Vector3> cells_m;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const double x = random.uniform(-8.0, 8.0, 0, 3 * i), y = random.uniform(-8.0, 8.0, 0, 3 * i + 1);
    cells_m.emplace_back(x, y, random.uniform(0.8, 3.2, 0, 3 * i + 2));
  }
  return cells_m;
}

FlockObstacleConfig among_trees(bool enabled) {
  FlockObstacleConfig lidar;
  lidar.enabled = enabled;
  lidar.avoid_distance_m = 1.7;
  lidar.avoid_gain_mps = 0.4;
  return lidar;
}

/// The neighbors as known in the driver's last tick.
std::span<const Neighbor> known(NeighborMemory& memory, const GuidanceDriver& driver, Observation observation) {
  observation.t = driver.observation.t;
  memory.update({.dt_s = driver.dt_s, .estimate = driver.estimate, .observation = observation, .poses = driver.poses});
  return memory.neighbors();
}

TEST(PacnavReference, EveryWantedVelocityIsThatOfTheRules) {
  int num_led = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Random random(seed, "test.pacnav");
    PacnavConfig config;
    config.informed = seed % 4 == 0;
    config.goal_m = {20.0, -11.0, 5.0};
    config.speed_mps = random.uniform(0.5, 2.0, 0, 0);
    config.memory_s = random.uniform(1.0, 8.0, 0, 1);
    config.sample_s = random.uniform(0.1, 0.5, 0, 2);
    config.avoid_distance_m = random.uniform(1.0, 5.0, 0, 3);
    config.avoid_gain_mps = random.uniform(0.0, 0.5, 0, 4);
    config.least_persistence = random.uniform(0.2, 0.8, 0, 5);
    config.follow_radius_m = random.uniform(1.0, 4.0, 0, 6);
    config.lidar = among_trees(seed % 3 != 0);
    const std::vector<Vector3> cells_m = trees_m(seed);
    const ToldMap map(cells_m);
    GuidanceDriver driver("pacnav", config, {0.0, 0.0, 2.0});
    driver.map = &map;
    driver.dt_s = seed % 2 == 0 ? 0.1 : 0.04;
    NeighborMemory memory(config.neighbors);
    PlainPacnav plain(config, PlainObstacle(config.lidar, cells_m, 0.2));
    Others others(seed, seed % 3 == 0 ? 0.1 : 1.5);
    for (std::uint32_t tick = 0; tick < 300; ++tick) {
      others.show(tick, driver);
      const Observation seen = driver.observation;
      const Vector3 p_m = driver.p_m();
      driver.step();
      Vector3 wanted_m = p_m + plain.velocity(p_m, known(memory, driver, seen), driver.observation.t);
      wanted_m.z() = 2.0;
      ASSERT_LT((driver.out.goal.position_m - wanted_m).norm(), 1e-9) << seed << ", " << tick;
      ASSERT_EQ(driver.out.speed_limit_mps, config.speed_mps);
      driver.put(p_m + driver.dt_s * (wanted_m - p_m));
    }
    num_led += plain.num_led();
  }
  EXPECT_GT(num_led, 500);
}

/// Each pixel looks at the middle of its part of the circle; a disc is seen by all pixels that it meets.
VisualResponse plain_response(const MezeyConfig& config, const Vector3& p_m, double heading_rad,
                              std::span<const Neighbor> neighbors) {
  const double width = 2.0 * M_PI / config.retina_pixels;
  const auto sees = [&](int i) {
    return std::any_of(neighbors.begin(), neighbors.end(), [&](const Neighbor& other) {
      const Vector3 to_m = level(other.position_local_m - p_m);
      const double bearing = std::remainder(std::atan2(to_m.y(), to_m.x()) - heading_rad, 2.0 * M_PI);
      const double half = to_m.norm() > config.body_radius_m ? std::asin(config.body_radius_m / to_m.norm()) : M_PI / 2;
      for (const double round : {-2.0 * M_PI, 0.0, 2.0 * M_PI}) {
        const double from = -M_PI + i * width + round;
        if (from <= bearing + half && from + width > bearing - half) return true;
      }
      return false;
    });
  };
  VisualResponse response;
  for (int i = 0; i < config.retina_pixels; ++i) {
    const double middle = -M_PI + (i + 0.5) * width, end = -M_PI + (i + 1) * width;
    if (sees(i)) {
      response.acceleration_mps2 -= config.alpha0 * width * std::cos(middle);
      response.turn_radps -= config.beta0 * width * std::sin(middle);
    }
    if (sees(i) != sees((i + 1) % config.retina_pixels)) {
      response.acceleration_mps2 += config.alpha0 * config.alpha1 * std::cos(end);
      response.turn_radps += config.beta0 * config.beta1 * std::sin(end);
    }
  }
  return response;
}

TEST(MezeyReference, EveryGoalIsThatOfTheModel) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Random random(seed, "test.mezey");
    MezeyConfig config;
    config.goal_m = {20.0, -11.0, 5.0};
    config.goal_weight_radps = seed % 3 == 0 ? 0.0 : random.uniform(0.2, 1.0, 0, 0);
    config.cruise_speed_mps = random.uniform(0.5, 2.0, 0, 1);
    config.relaxation_radps = random.uniform(0.2, 1.0, 0, 2);
    config.alpha0 = random.uniform(0.2, 2.0, 0, 3);
    config.alpha1 = random.uniform(0.05, 0.3, 0, 4);
    config.beta0 = random.uniform(0.2, 2.0, 0, 5);
    config.beta1 = random.uniform(0.05, 0.3, 0, 6);
    config.body_radius_m = random.uniform(0.3, 1.5, 0, 7);
    config.retina_pixels = 8 + 7 * static_cast<int>(seed);
    config.lidar = among_trees(seed % 2 == 0);
    const std::vector<Vector3> cells_m = trees_m(seed);
    const ToldMap map(cells_m);
    double heading_rad = random.uniform(-3.0, 3.0, 0, 8), v_mps = 0.0;
    bool arrived = false;
    GuidanceDriver driver("mezey", config, {0.0, 0.0, 2.0}, heading_rad);
    driver.map = &map;
    NeighborMemory memory(config.neighbors);
    PlainObstacle obstacle(config.lidar, cells_m, 0.2);
    Others others(seed + 100, 1.0);
    for (std::uint32_t tick = 0; tick < 250; ++tick) {
      others.show(tick, driver);
      const Observation seen = driver.observation;
      const Vector3 p_m = driver.p_m();
      driver.step();
      const VisualResponse response = plain_response(config, p_m, heading_rad, known(memory, driver, seen));
      const Vector3 to_goal_m = level(config.goal_m - p_m);
      const double off_rad = std::atan2(to_goal_m.y(), to_goal_m.x()) - heading_rad;
      v_mps += driver.dt_s * (config.relaxation_radps * (config.cruise_speed_mps - v_mps) + response.acceleration_mps2);
      v_mps = std::max(0.0, std::min(v_mps, 2.0 * config.cruise_speed_mps));
      heading_rad += driver.dt_s * (response.turn_radps + config.goal_weight_radps * std::sin(off_rad));
      heading_rad = std::remainder(heading_rad, 2.0 * M_PI);
      arrived = arrived || (config.goal_weight_radps > 0.0 && to_goal_m.norm() <= config.arrival_radius_m);
      Vector3 wanted_m = p_m;
      if (!arrived) wanted_m += v_mps * Vector3(std::cos(heading_rad), std::sin(heading_rad), 0.0);
      wanted_m += obstacle.push(p_m, driver.observation.t);
      wanted_m.z() = 2.0;
      ASSERT_LT((driver.out.goal.position_m - wanted_m).norm(), 1e-9) << seed << ", " << tick;
      ASSERT_NEAR(std::remainder(driver.out.goal.yaw_rad - heading_rad, 2.0 * M_PI), 0.0, 1e-9);
      ASSERT_EQ(driver.out.speed_limit_mps, 2.0 * config.cruise_speed_mps);
      ASSERT_EQ(driver.out.mission, arrived                          ? MissionStatus::kDone
                                    : config.goal_weight_radps > 0.0 ? MissionStatus::kRunning
                                                                     : MissionStatus::kEndless);
      driver.put(p_m + driver.dt_s * level(wanted_m - p_m));
    }
  }
}

// What is nearer than a millimeter has no direction.
TEST(PacnavReference, MillimetersDoNotCount) {
  PacnavConfig config;
  config.goal_m = {1.2e-3, 0.0, 2.0};
  EXPECT_NEAR(GuidanceDriver("pacnav", config, {0, 0, 2}).step().goal.position_m.x(), 1.2e-3, 1e-9);
  config.goal_m = {0.8e-3, 0.0, 2.0};
  EXPECT_EQ(GuidanceDriver("pacnav", config, {0, 0, 2}).step().goal.position_m.x(), 0.0);
  config.goal_m.x() = 0.0;
  config.avoid_gain_mps = 1e-4;
  GuidanceDriver driver("pacnav", config, {0, 0, 2});
  driver.sees(1, {-5e-4, 0, 2});
  EXPECT_NEAR(driver.step().goal.position_m.x(), 1e-4 * (3.0 - 1e-3) / 1e-6 * 5e-4, 1e-6) << "as at a millimeter";
  for (const double way_m : {0.8e-3, 1.2e-3}) {
    const std::vector<Vector3> straight = {{0, 0, 0}, {0.5 * way_m, 0, 0}, {way_m, 0, 0}};
    EXPECT_NEAR(path_persistence(straight), way_m > 1e-3 ? 1.0 : 0.0, 1e-9);
  }
}

TEST(MezeyReference, AtItsGoalNoDirectionLeadsThere) {
  MezeyConfig config;
  for (const double off_m : {0.8e-3, 1.2e-3}) {
    config.goal_m = {0.0, off_m, 2.0};
    GuidanceDriver driver("mezey", config, {0, 0, 2});
    EXPECT_EQ(driver.step().goal.yaw_rad != 0.0, off_m > 1e-3) << off_m;
  }
}

// A cell at the height of flight pushes as at a millimeter when the vehicle is in it.
TEST(MezeyReference, WhoIsInAnObstacleIsPushedNoHarderThanFromAMillimeter) {
  MezeyConfig config;
  config.lidar = among_trees(true);
  config.lidar.avoid_gain_mps = 1e-4;
  const ToldMap map({{0.1005, 0.0, 2.0}});
  GuidanceDriver driver("mezey", config, {0, 0, 2}, 0.5 * M_PI);
  driver.map = &map;
  driver.dt_s = 1e-6;
  EXPECT_NEAR(driver.step().goal.position_m.x(), -1e-4 * (1.7 - 1e-3) / 1e-6 * 5e-4, 1e-5);
}

}  // namespace
}  // namespace swiftlet
