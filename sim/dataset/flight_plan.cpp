// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/flight_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/math/random.hpp"
#include "sim/dataset/free_space.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kSpacing_m = 0.1;       // of the points of a way on which speeds are worked out
constexpr double kSmoothing_m = 0.6;     // standard deviation with which corners are rounded
constexpr double kInterval_s = 0.2;      // between control points of the spline
constexpr double kSmoothedMargin = 0.5;  // what rounding a corner may cost of the margin
constexpr double kSlowdown = 0.75;       // mean speed over cruise speed, for estimates of time
constexpr int kMaxPlaces = 60;           // draws for one goal
constexpr int kMaxLegs = 400;
constexpr int kMaxWays = 12;  // draws for one vehicle

/// Draws of one vehicle's planning, each used once.
class Draws {
 public:
  Draws(std::uint64_t seed, const std::string& entity) : random_(seed, "dataset.flight", entity) {}
  double uniform(double min = 0.0, double max = 1.0) { return random_.uniform(min, max, 0, index_++); }

 private:
  Random random_;
  std::uint32_t index_ = 0;
};

std::vector<Vector3> dense(const std::vector<Vector3>& corners) {
  std::vector<Vector3> points = {corners.front()};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vector3 leg = corners[i] - corners[i - 1];
    const int steps = std::max(1, static_cast<int>(std::ceil(leg.norm() / kSpacing_m)));
    for (int k = 1; k <= steps; ++k) points.push_back(corners[i - 1] + leg * (static_cast<double>(k) / steps));
  }
  return points;
}

// Three moving averages are nearly a Gaussian. Beginning and end stay where they are.
std::vector<Vector3> smooth(std::vector<Vector3> points, double sigma_m) {
  const int half = static_cast<int>(std::lround(sigma_m / kSpacing_m));
  const int n = static_cast<int>(points.size());
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<Vector3> averaged = points;
    for (int i = 1; i + 1 < n; ++i) {
      const int reach = std::min({half, i, n - 1 - i});
      Vector3 sum = Vector3::Zero();
      for (int k = -reach; k <= reach; ++k) sum += points[static_cast<std::size_t>(i + k)];
      averaged[static_cast<std::size_t>(i)] = sum / (2 * reach + 1);
    }
    points = std::move(averaged);
  }
  return points;
}

// Speeds that keep the limits in bends and on slopes, from rest to rest.
std::vector<double> speeds_along(const std::vector<Vector3>& points, double cruise_mps, const FlightConfig& config) {
  constexpr double kFlat = 1e-9;
  const int n = static_cast<int>(points.size());
  std::vector<double> speed(points.size(), cruise_mps), acceleration(points.size(), config.acceleration_mps2);
  const auto at = [&](int i) { return points[static_cast<std::size_t>(std::clamp(i, 0, n - 1))]; };
  for (int i = 0; i < n; ++i) {
    const Vector3 before = at(i) - at(i - 2), after = at(i + 2) - at(i);
    const double length = 0.5 * (before.norm() + after.norm());
    if (length < kFlat) continue;
    const Vector3 tangent = (before + after).normalized();
    const Vector3 curvature = (after.normalized() - before.normalized()) / length;
    double& v = speed[static_cast<std::size_t>(i)];
    v = std::min(v, std::sqrt(config.acceleration_mps2 / std::max(curvature.head<2>().norm(), kFlat)));
    v = std::min(v, std::sqrt(config.vertical_acceleration_mps2 / std::max(std::abs(curvature.z()), kFlat)));
    v = std::min(v, config.vertical_speed_mps / std::max(std::abs(tangent.z()), kFlat));
    double& a = acceleration[static_cast<std::size_t>(i)];
    a = std::min(a, config.vertical_acceleration_mps2 / std::max(std::abs(tangent.z()), kFlat));
  }
  const auto limit = [&](std::size_t from, std::size_t to) {
    const double step = (points[to] - points[from]).norm();
    speed[to] = std::min(speed[to], std::sqrt(speed[from] * speed[from] + 2.0 * acceleration[to] * step));
  };
  speed.front() = speed.back() = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) limit(i - 1, i);
  for (std::size_t i = points.size() - 1; i > 0; --i) limit(i, i - 1);
  return speed;
}

// Points at equal times.
std::vector<Vector3> at_equal_times(const std::vector<Vector3>& points, const std::vector<double>& speed) {
  std::vector<Vector3> samples = {points.front()};
  double t = 0.0, next = kInterval_s;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double step = (points[i] - points[i - 1]).norm();
    const double mean = std::max(0.5 * (speed[i - 1] + speed[i]), 1e-3);
    const double duration = step / mean;
    for (; next <= t + duration && duration > 0.0; next += kInterval_s) {
      samples.push_back(points[i - 1] + (points[i] - points[i - 1]) * ((next - t) / duration));
    }
    t += duration;
  }
  samples.push_back(points.back());
  return samples;
}

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
                       config.height_max_m, config.border_m, config.cell_m, config.indoors}) {}

  std::optional<std::vector<TimedWay>> plan() {
    if (space_.area_m().isEmpty()) return std::nullopt;
    for (std::size_t vehicle = 0; vehicle < radii_m_.size(); ++vehicle) {
      if (!add_way(vehicle)) return std::nullopt;
    }
    return ways_;
  }

 private:
  bool add_way(std::size_t vehicle) {
    for (int i = 0; i < kMaxWays; ++i) {
      Draws draws(seed_, std::to_string(vehicle) + "#" + std::to_string(attempt_) + "." + std::to_string(i));
      const auto way = draw_way(vehicle, draws);
      if (!way || !keeps_apart(*way)) continue;
      ways_.push_back(*way);
      return true;
    }
    return false;
  }

  std::optional<TimedWay> draw_way(std::size_t vehicle, Draws& draws) {
    const double speed_mps = draws.uniform(config_.speed_min_mps, config_.speed_max_mps);
    const auto start = vehicle == 0 ? draw_place(draws) : draw_near_first(draws, 0.0, nullptr);
    if (!start) return std::nullopt;
    std::vector<Vector3> corners = {*start}, visited = {*start};
    double t_s = 0.0;
    for (int leg = 0; leg < kMaxLegs && t_s < 1.2 * duration_s_; ++leg) {
      const auto goal =
          vehicle == 0 ? draw_goal(draws, corners.back(), visited) : draw_near_first(draws, t_s, &corners.back());
      if (!goal) continue;
      const std::vector<Vector3> way = space_.find_way(corners.back(), *goal);
      for (std::size_t i = 1; i < way.size(); ++i) {
        t_s += (way[i] - corners.back()).norm() / (kSlowdown * speed_mps);
        corners.push_back(way[i]);
      }
      if (!way.empty()) visited.push_back(*goal);
    }
    if (corners.size() < 2) return std::nullopt;
    const double hard_m = radii_m_[vehicle] + kSmoothedMargin * config_.margin_m;
    auto way = time_way(corners, speed_mps, config_,
                        [&](const Vector3& p) { return !world_->nearest(p, hard_m).has_value(); });
    if (way) cut(*way);
    return way;
  }

  // What lies behind the end of the flight is of no use.
  void cut(TimedWay& way) const {
    const auto needed = static_cast<std::size_t>(std::ceil(duration_s_ / way.interval_s)) + 4;
    if (way.control_points_m.size() > needed) way.control_points_m.resize(needed);
  }

  bool keeps_apart(const TimedWay& way) const {
    return std::all_of(ways_.begin(), ways_.end(),
                       [&](const TimedWay& other) { return least_distance_m(way, other) >= config_.separation_m; });
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
      const auto p =
          at_some_height(draws, from.x() + distance_m * std::cos(azimuth), from.y() + distance_m * std::sin(azimuth));
      if (p) return p;
    }
    return std::nullopt;
  }

  // A place at a chosen distance from where the first vehicle will be by then.
  std::optional<Vector3> draw_near_first(Draws& draws, double t_s, const Vector3* from) const {
    const UniformSpline first = ways_.front().spline();
    const double octaves = std::log(config_.partner_max_m / config_.partner_min_m);
    const double distance_m = config_.partner_min_m * std::exp(octaves * draws.uniform());
    const bool in_view = draws.uniform() < config_.in_view_share;
    std::optional<Vector3> otherwise;
    for (int i = 0; i < kMaxPlaces; ++i) {
      Vector3 center = first.at(t_s).p_m;
      if (from != nullptr) {
        // Met at the end of the leg, whose length is known roughly only.
        const double leg_s = (center - *from).norm() / (kSlowdown * config_.speed_max_mps);
        center = first.at(t_s + std::min(leg_s, 10.0)).p_m;
      }
      const double azimuth = draws.uniform(0.0, kTwoPi);
      const auto p = at_some_height(draws, center.x() + distance_m * std::cos(azimuth),
                                    center.y() + distance_m * std::sin(azimuth));
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
  std::vector<TimedWay> ways_;
};

}  // namespace

std::optional<TimedWay> time_way(const std::vector<Vector3>& corners_m, double speed_mps, const FlightConfig& config,
                                 const std::function<bool(const Vector3&)>& free) {
  const std::vector<Vector3> points = dense(corners_m);
  for (const double sigma_m : {kSmoothing_m, 0.5 * kSmoothing_m}) {
    const std::vector<Vector3> smoothed = smooth(points, sigma_m);
    if (!std::all_of(smoothed.begin(), smoothed.end(), free)) continue;
    TimedWay way;
    way.interval_s = kInterval_s;
    way.control_points_m = at_equal_times(smoothed, speeds_along(smoothed, speed_mps, config));
    const Vector3 first_leg = corners_m[1] - corners_m[0];
    way.yaw_rad = std::atan2(first_leg.y(), first_leg.x());
    return way;
  }
  return std::nullopt;
}

double least_distance_m(const TimedWay& a, const TimedWay& b) {
  constexpr double kStep_s = 0.05;
  const UniformSpline spline_a = a.spline(), spline_b = b.spline();
  const double end_s = std::max(spline_a.duration_s(), spline_b.duration_s());
  double least_sq = std::numeric_limits<double>::infinity();
  Vector3 before = spline_a.at(0.0).p_m - spline_b.at(0.0).p_m;
  for (double t_s = kStep_s; t_s < end_s + kStep_s; t_s += kStep_s) {
    // In between the two move nearly straight: the point of closest approach of the relative motion.
    const Vector3 after = spline_a.at(t_s).p_m - spline_b.at(t_s).p_m;
    const Vector3 motion = after - before;
    const double length_sq = motion.squaredNorm();
    const double s = length_sq > 0.0 ? std::clamp(-before.dot(motion) / length_sq, 0.0, 1.0) : 0.0;
    least_sq = std::min(least_sq, (before + s * motion).squaredNorm());
    before = after;
  }
  return std::sqrt(least_sq);
}

std::optional<std::vector<TimedWay>> plan_flight(const FlightConfig& config,
                                                 const std::shared_ptr<const StaticScene>& world,
                                                 const std::vector<double>& radii_m, double duration_s,
                                                 std::uint64_t seed, int attempt) {
  return Planner(config, world, radii_m, duration_s, seed, attempt).plan();
}

}  // namespace swiftlet::sim
