// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/flight_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "sim/dataset/free_space.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/planning/grid_search.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
// [-] Share of the margin that must remain after smoothing of corners. Larger values reject more paths.
constexpr double kSmoothedMargin = 0.5;
// [-] Mean speed of a leg / cruise speed, for estimates of durations. Larger values underestimate durations.
constexpr double kMeanSpeedShare = 0.75;
// [-] Estimated duration of a path / duration of the flight, and growth of a path that turns out too short. Larger
// values take longer, smaller ones time a path more often.
constexpr double kDurationMargin = 1.2;
// [s] Longest prediction of the first vehicle. Larger values draw goals farther from its present place.
constexpr double kMaxPrediction_s = 10.0;
// [-] Positions drawn for one goal before it is given up. Larger values find goals in cluttered worlds and take longer.
constexpr int kMaxPlaces = 60;
// [-] Legs drawn before a path is timed, which bounds the time where goals are not reachable.
constexpr int kMaxLegs = 400;
// [-] Paths drawn for one vehicle before the attempt fails. Larger values plan denser teams and take longer.
constexpr int kMaxPaths = 12;
// Least share of the ground enclosed by walls [-] for which `indoors: auto` restricts flights to the interior.
constexpr double kInteriorShare = 0.1;

/// Random draws for planning one vehicle, each used once.
class Draws {
 public:
  Draws(std::uint64_t seed, const std::string& entity) : random_(seed, "dataset.flight", entity) {}
  double uniform(double min = 0.0, double max = 1.0) { return random_.uniform(min, max, 0, index_++); }

 private:
  Random random_;
  std::uint32_t index_ = 0;
};

/// Plans one team, vehicle after vehicle.
class Planner {
 public:
  Planner(const FlightConfig& config, const std::shared_ptr<const StaticScene>& world,
          const std::vector<double>& radii_m, double duration_s, std::uint64_t seed, int attempt)
      : config_(config),
        world_(world),
        radii_m_(radii_m),
        duration_s_(duration_s),
        seed_(seed),
        attempt_(attempt),
        space_(world, {*std::max_element(radii_m.begin(), radii_m.end()) + config.margin_m, config.height_min_m,
                       config.height_max_m, config.border_m, config.cell_m, stays_indoors(config, *world)}) {}

  std::optional<std::vector<SplineTrajectory>> plan() {
    if (space_.area_m().isEmpty()) return std::nullopt;
    for (std::size_t vehicle = 0; vehicle < radii_m_.size(); ++vehicle) {
      if (!add_path(vehicle)) return std::nullopt;
    }
    return paths_;
  }

 private:
  bool add_path(std::size_t vehicle) {
    for (int i = 0; i < kMaxPaths; ++i) {
      Draws draws(seed_, std::to_string(vehicle) + "#" + std::to_string(attempt_) + "." + std::to_string(i));
      const auto path = draw_path(vehicle, draws);
      if (!path || !keeps_apart(*path)) continue;
      paths_.push_back(*path);
      return true;
    }
    return false;
  }

  /// Corners of a path that is drawn leg by leg.
  struct Course {
    std::vector<Vector3> corners, visited;
    double t_s = 0.0;  // estimated duration
  };

  // Appends at least one leg, until the estimated duration is reached or too many draws have failed.
  void extend(Course& course, double until_s, std::size_t vehicle, double speed_mps, Draws& draws) const {
    for (int leg = 0; leg < kMaxLegs && (leg == 0 || course.t_s < until_s); ++leg) {
      const auto goal = vehicle == 0 ? draw_goal(draws, course.corners.back(), course.visited)
                                     : draw_near_first(draws, course.t_s, &course.corners.back());
      if (!goal) continue;
      const std::vector<Vector3> path = find_path(space_, course.corners.back(), *goal).corners_world_m;
      for (std::size_t i = 1; i < path.size(); ++i) {
        course.t_s += (path[i] - course.corners.back()).norm() / (kMeanSpeedShare * speed_mps);
        course.corners.push_back(path[i]);
      }
      if (!path.empty()) course.visited.push_back(*goal);
    }
  }

  std::optional<SplineTrajectory> draw_path(std::size_t vehicle, Draws& draws) const {
    const double speed_mps = draws.uniform(config_.speed_min_mps, config_.speed_max_mps);
    const auto start = vehicle == 0 ? draw_place(draws) : draw_near_first(draws, 0.0, nullptr);
    if (!start) return std::nullopt;
    const double hard_m = radii_m_[vehicle] + kSmoothedMargin * config_.margin_m;
    const PathLimits limits{speed_mps, config_.vertical_speed_mps, config_.acceleration_mps2,
                            config_.vertical_acceleration_mps2};
    // Rounded corners shorten a path, so legs are added until the timed path lasts the flight.
    Course course{{*start}, {*start}};
    std::optional<SplineTrajectory> path;
    double until_s = duration_s_;
    while (!path || path->spline().duration_s() < duration_s_) {
      const std::size_t num_corners = course.corners.size();
      until_s *= kDurationMargin;
      extend(course, until_s, vehicle, speed_mps, draws);
      if (course.corners.size() == num_corners) return std::nullopt;
      path =
          time_path(course.corners, limits, [&](const Vector3& p) { return !world_->nearest(p, hard_m).has_value(); });
      if (!path) return std::nullopt;
    }
    cut(*path);
    return path;
  }

  // Removes the part after the end of the flight.
  void cut(SplineTrajectory& path) const {
    const auto needed = static_cast<std::size_t>(std::ceil(duration_s_ / path.interval_s)) + 4;
    if (path.control_points_m.size() > needed) path.control_points_m.resize(needed);
  }

  bool keeps_apart(const SplineTrajectory& path) const {
    return std::all_of(paths_.begin(), paths_.end(), [&](const SplineTrajectory& other) {
      return least_distance_m(path.spline(), other.spline()) >= config_.separation_m;
    });
  }

  std::optional<Vector3> at_some_height(Draws& draws, double x_m, double y_m) const {
    const double height_m = draws.uniform(config_.height_min_m, config_.height_max_m);
    if (!space_.area_m().contains(Eigen::Vector2d(x_m, y_m))) return std::nullopt;
    const auto ground_m = space_.ground_m(x_m, y_m);
    if (!ground_m) return std::nullopt;
    const Vector3 p(x_m, y_m, *ground_m + height_m);
    return space_.is_free(p) ? std::optional(p) : std::nullopt;
  }

  std::optional<Vector3> draw_place(Draws& draws) const {
    for (int i = 0; i < kMaxPlaces; ++i) {
      const double x_m = draws.uniform(space_.area_m().min().x(), space_.area_m().max().x());
      const double y_m = draws.uniform(space_.area_m().min().y(), space_.area_m().max().y());
      if (const auto p = at_some_height(draws, x_m, y_m)) return p;
    }
    return std::nullopt;
  }

  std::optional<Vector3> draw_goal(Draws& draws, const Vector3& from, const std::vector<Vector3>& visited) const {
    if (visited.size() > 2 && draws.uniform() < config_.revisit_share) {
      const auto pick = static_cast<std::size_t>(draws.uniform() * static_cast<double>(visited.size() - 1));
      if ((visited[pick] - from).norm() > config_.leg_min_m) return visited[pick];
    }
    for (int i = 0; i < kMaxPlaces; ++i) {
      const double distance_m = draws.uniform(config_.leg_min_m, config_.leg_max_m);
      const double azimuth = draws.uniform(0.0, kTwoPi);
      const auto p = at_some_height(draws, from.x() + distance_m * elementary::cos(azimuth),
                                    from.y() + distance_m * elementary::sin(azimuth));
      if (p) return p;
    }
    return std::nullopt;
  }

  // Draws a goal at a random distance from the predicted position of the first vehicle.
  std::optional<Vector3> draw_near_first(Draws& draws, double t_s, const Vector3* from) const {
    const UniformSpline first = paths_.front().spline();
    // Log-uniform distance between partner_min_m and partner_max_m.
    const double log_ratio = elementary::log(config_.partner_max_m / config_.partner_min_m);
    const double distance_m = config_.partner_min_m * elementary::exp(log_ratio * draws.uniform());
    const bool in_view = draws.uniform() < config_.in_view_share;
    std::optional<Vector3> otherwise;
    for (int i = 0; i < kMaxPlaces; ++i) {
      Vector3 center = first.at(t_s).p_m;
      if (from != nullptr) {
        // At the largest speed: the shortest duration of the leg.
        const double leg_s = (center - *from).norm() / (kMeanSpeedShare * config_.speed_max_mps);
        center = first.at(t_s + std::min(leg_s, kMaxPrediction_s)).p_m;
      }
      const double azimuth = draws.uniform(0.0, kTwoPi);
      const auto p = at_some_height(draws, center.x() + distance_m * elementary::cos(azimuth),
                                    center.y() + distance_m * elementary::sin(azimuth));
      if (!p) continue;
      if (!in_view || !world_->occluded(center, *p)) return p;
      if (!otherwise) otherwise = p;
    }
    return otherwise;
  }

  FlightConfig config_;
  std::shared_ptr<const StaticScene> world_;
  std::vector<double> radii_m_;
  double duration_s_;
  std::uint64_t seed_;
  int attempt_;
  FreeSpace space_;
  std::vector<SplineTrajectory> paths_;
};

}  // namespace

bool stays_indoors(const FlightConfig& config, const StaticScene& world) {
  if (config.indoors != FlightConfig::Indoors::kAuto) return config.indoors == FlightConfig::Indoors::kTrue;
  return enclosed_share(world, config.height_min_m) >= kInteriorShare;
}

std::optional<std::vector<SplineTrajectory>> plan_flight(const FlightConfig& config,
                                                         const std::shared_ptr<const StaticScene>& world,
                                                         const std::vector<double>& radii_m, double duration_s,
                                                         std::uint64_t seed, int attempt) {
  return Planner(config, world, radii_m, duration_s, seed, attempt).plan();
}

}  // namespace swiftlet::sim
