// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/planning/team_plan.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/world/empty.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

/// Waypoints that algorithm 2 predicts visible, checked for true line of sight: plans on maps of known worlds,
/// evaluated by ray casts into the world's triangles.
namespace swiftlet::tools {
namespace {

using Sight = ViewpointRules::Sight;
constexpr std::array<Sight, 2> kSights = {Sight::kAtWaypoint, Sight::kInSpace};
constexpr std::array<const char*, 2> kSightNames = {"at_waypoint", "in_space"};
constexpr std::array<const char*, 3> kWorlds = {"forest", "warehouse", "hurdles"};
constexpr std::array<double, 4> kHigher_m = {0.0, 0.5, 1.0, 1.5};  // height of the primary above the secondary
constexpr int kDirections = 4;                                     // goal directions at each place
constexpr double kWay_m = 4.0, kSecondary_m = 1.0;                 // goal distance; height above ground
constexpr double kApart_m = 3.0;                                   // between primary and secondary at the start
constexpr double kWithin_m = 25.0;  // half the edge of the square of places around the origin
constexpr int kRays = 5000;
constexpr double kSeen_m = 10.0;  // sensing range of each mapping scan

/// Results over plans of one kind.
struct Tally {
  int plans = 0, found = 0, whole = 0;  // whole: all predicted waypoints are in sight
  int told = 0, in_sight = 0;           // waypoints predicted visible, and those in true sight

  Tally& operator+=(const Tally& other) {
    plans += other.plans;
    found += other.found;
    whole += other.whole;
    told += other.told;
    in_sight += other.in_sight;
    return *this;
  }
};
using Tallies = std::array<std::array<Tally, kHigher_m.size()>, kSights.size()>;

/// Evenly spaced directions on the sphere.
Vector3 direction_of(int i, int count) {
  const double z = 1.0 - (2.0 * i + 1.0) / count, level = std::sqrt(1.0 - z * z);
  const double turn_rad = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
  return {level * std::cos(turn_rad), level * std::sin(turn_rad), z};
}

/// Level ground with walls up to 1.4 m, and beams from 1.8 m upward. A vehicle 1 m above the ground passes below the
/// beams; a higher one has a view over the walls.
sim::Scene hurdles(std::uint64_t seed) {
  constexpr std::uint32_t kCount = 250;
  Module ground(sim::world_module_types(), "empty");
  ground.as<sim::EmptyConfig>().ground = true;
  sim::Scene scene = sim::make_world(ground, seed);
  const Random random(seed, "guidance-sight.hurdles");
  sim::Mesh mesh;
  mesh.surface_class = sim::SurfaceClass::kWall;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double x_m = random.uniform(-kWithin_m, kWithin_m, 0, i), y_m = random.uniform(-kWithin_m, kWithin_m, 1, i);
    const double yaw_rad = random.uniform(0.0, std::numbers::pi, 2, i);
    const bool hangs = i % 2 == 0;
    Eigen::Affine3f T(Eigen::Translation3f(Vector3(x_m, y_m, hangs ? 1.95 : 0.7).cast<float>()));
    T.rotate(Eigen::AngleAxisf(static_cast<float>(yaw_rad), Eigen::Vector3f::UnitZ()));
    sim::add_box(mesh, T, {3.0F, 0.3F, hangs ? 0.3F : 1.4F});
  }
  scene.instances.push_back({.mesh = static_cast<std::uint32_t>(scene.meshes.size())});
  scene.meshes.push_back(std::move(mesh));
  scene.bounds_m.extend(Vector3(0.0, 0.0, 2.1));
  return scene;
}

sim::Scene world_of(const std::string& name, std::uint64_t seed) {
  return name == "hurdles" ? hurdles(seed) : sim::make_world(Module(sim::world_module_types(), name), seed);
}

class Place {
 public:
  Place(const sim::StaticScene& scene, const Random& random, std::uint32_t index)
      : scene_(scene), random_(random), index_(index), map_(OccupancyMapConfig{}) {}

  /// Draws a free start, 1 m above the ground.
  bool settle() {
    constexpr std::uint32_t kTries = 200;
    for (std::uint32_t i = 0; i < kTries; ++i) {
      const double x_m = random_.uniform(-kWithin_m, kWithin_m, index_, 3 * i);
      const double y_m = random_.uniform(-kWithin_m, kWithin_m, index_, 3 * i + 1);
      const std::optional<double> ground_m = ground_height_m(x_m, y_m);
      if (!ground_m) continue;
      secondary_m_ = {x_m, y_m, *ground_m + kSecondary_m};
      const double yaw_rad = random_.uniform(0.0, 2.0 * std::numbers::pi, index_, 3 * i + 2);
      primary_m_ = secondary_m_ + kApart_m * Vector3(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
      if (is_open(secondary_m_, 0.9) && is_open(primary_m_, 0.9)) return true;
    }
    return false;
  }

  /// Fills the map with scans from a grid of free points around the start.
  void map() {
    for (int x = -2; x <= 2; ++x) {
      for (int y = -2; y <= 2; ++y) {
        for (const double up_m : {0.0, 1.5}) {
          const Vector3 from_m = secondary_m_ + Vector3(2.5 * x, 2.5 * y, up_m);
          if (is_open(from_m, 0.3)) look_from(from_m);
        }
      }
    }
  }

  void plan(Tallies& tallies) const {
    for (int direction = 0; direction < kDirections; ++direction) {
      const double yaw_rad = 2.0 * std::numbers::pi * direction / kDirections;
      const Vector3 goal_m = secondary_m_ + kWay_m * Vector3(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
      for (std::size_t higher = 0; higher < kHigher_m.size(); ++higher) {
        const Vector3 primary_m = primary_m_ + kHigher_m[higher] * Vector3::UnitZ();
        if (!is_open(primary_m, 0.9)) continue;
        for (std::size_t sight = 0; sight < kSights.size(); ++sight) {
          judge(primary_m, goal_m, kSights[sight], tallies[sight][higher]);
        }
      }
    }
  }

 private:
  bool is_open(const Vector3& p_m, double radius_m) const { return !scene_.nearest(p_m, radius_m); }

  /// Height of the lowest surface, below anything that hangs above it.
  std::optional<double> ground_height_m(double x_m, double y_m) const {
    constexpr int kMostAbove = 50;
    Vector3 from_m(x_m, y_m, 60.0);
    for (int i = 0; i < kMostAbove; ++i) {
      const sim::RayHit hit = scene_.trace(from_m, -Vector3::UnitZ(), 120.0);
      if (hit.range_m <= 0.0F) return std::nullopt;
      from_m.z() -= static_cast<double>(hit.range_m) + 1e-3;
      if (hit.surface_class == sim::SurfaceClass::kGround) return from_m.z();
    }
    return std::nullopt;
  }

  void look_from(const Vector3& from_m) {
    std::vector<OccupancyMap::Ray> rays;
    rays.reserve(kRays);
    for (int i = 0; i < kRays; ++i) {
      const Vector3 direction = direction_of(i, kRays);
      const sim::RayHit hit = scene_.trace(from_m, direction, kSeen_m);
      const double length_m = hit.range_m > 0.0F ? hit.range_m : kSeen_m;
      rays.push_back({from_m.cast<float>(), (from_m + length_m * direction).cast<float>(), hit.range_m > 0.0F});
    }
    map_.insert(rays, 0);
  }

  void judge(const Vector3& primary_m, const Vector3& goal_m, Sight sight, Tally& tally) const {
    TeamPlannerConfig config;
    config.secondary.clearance_m = 0.5;
    config.secondary.z_min_m = secondary_m_.z() - 0.3;
    config.secondary.z_max_m = secondary_m_.z() + 0.3;
    config.primary.z_min_m = primary_m.z() - 0.3;
    config.primary.z_max_m = primary_m.z() + 0.3;
    config.viewpoint.sight = sight;
    const TeamPlan plan = plan_team(map_, config, primary_m, {secondary_m_, 0.0}, {goal_m, 0.0});
    // Plans without a path for the secondary need no viewpoint.
    if (plan.secondary_path.size() < 2) return;
    ++tally.plans;
    if (plan.next == TeamPlan::Next::kFail) return;
    ++tally.found;
    const bool stays = plan.next == TeamPlan::Next::kMoveSecondary;
    const Vector3& from_m = stays ? primary_m : plan.viewpoint.p_local_m;
    const int first = plan.viewpoint.first_visible;
    int in_sight = 0;
    for (int i = first; i < first + plan.viewpoint.num_visible; ++i) {
      in_sight += !scene_.occluded(from_m, plan.secondary_path[static_cast<std::size_t>(i)].p_local_m);
    }
    tally.told += plan.viewpoint.num_visible;
    tally.in_sight += in_sight;
    tally.whole += in_sight == plan.viewpoint.num_visible;
  }

  const sim::StaticScene& scene_;
  const Random& random_;
  std::uint32_t index_;
  OccupancyMap map_;
  Vector3 secondary_m_, primary_m_;
};

double share(int of, int all) { return all > 0 ? static_cast<double>(of) / all : std::nan(""); }

}  // namespace

void guidance_sight(Experiment& experiment) {
  const int places = experiment.repetitions(40, 3);
  const std::size_t count = kWorlds.size() * static_cast<std::size_t>(places);
  std::vector<Tallies> tallies(count);
  parallel_for(experiment, count, "places", [&](std::size_t i) {
    const std::size_t world = i / static_cast<std::size_t>(places);
    const auto seed = static_cast<std::uint64_t>(i % static_cast<std::size_t>(places) + 1);
    const sim::StaticScene scene(world_of(kWorlds[world], seed));
    const Random random(seed, "guidance-sight", kWorlds[world]);
    Place place(scene, random, 0);
    if (!place.settle()) return;
    place.map();
    place.plan(tallies[i]);
  });

  CsvTable csv({"world_and_sight", "higher_m", "plans", "found", "waypoints_told", "waypoints_in_sight", "whole"});
  sim::plot::Figure figure("Is what is called visible in sight? By how much higher the primary flies", 3);
  for (std::size_t world = 0; world < kWorlds.size(); ++world) {
    sim::plot::Panel& panel = figure.add_panel(kWorlds[world]);
    panel.x.label = "primary above secondary [m]";
    panel.y.label = "plans of which all is in sight";
    panel.y.min = 0.8;
    panel.y.max = 1.01;
    for (std::size_t sight = 0; sight < kSights.size(); ++sight) {
      std::vector<double> higher_m, all_in_sight;
      Tally whole;
      for (std::size_t higher = 0; higher < kHigher_m.size(); ++higher) {
        Tally tally;
        for (int i = 0; i < places; ++i) {
          tally += tallies[world * static_cast<std::size_t>(places) + static_cast<std::size_t>(i)][sight][higher];
        }
        whole += tally;
        higher_m.push_back(kHigher_m[higher]);
        all_in_sight.push_back(share(tally.whole, tally.found));
        csv.row(
            fmt::format("{}/{}", kWorlds[world], kSightNames[sight]),
            {kHigher_m[higher], static_cast<double>(tally.plans), static_cast<double>(tally.found),
             static_cast<double>(tally.told), static_cast<double>(tally.in_sight), static_cast<double>(tally.whole)});
      }
      panel.line(kSightNames[sight], higher_m, all_in_sight, {.marker = sim::plot::Marker::kCircle});
      const std::string of = fmt::format("{}, sight: {}", kWorlds[world], kSightNames[sight]);
      const double seen = share(whole.in_sight, whole.told);
      experiment.row({of + ": waypoints in sight of those called visible [-]", short_number(seen, 3),
                      Verdict::kNotJudged,
                      fmt::format("{} waypoints; {} of {} plans are wholly in sight, {} found no viewpoint", whole.told,
                                  whole.whole, whole.found, whole.plans - whole.found),
                      seen});
    }
  }
  experiment.write("guidance-sight.csv", csv);
  experiment.write("guidance-sight.svg", figure);
}

}  // namespace swiftlet::tools
