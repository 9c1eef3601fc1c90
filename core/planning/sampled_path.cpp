// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/sampled_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

/// [-] factor on the radius of rewiring. Above 1 the tree is asymptotically optimal [Karaman 2011]; larger values are
/// slower.
constexpr double kRewiringFactor = 1.1;

/// Two axes perpendicular to a direction.
void axes_across(const Vector3& direction, Vector3& side, Vector3& other) {
  int least = 0;
  direction.cwiseAbs().minCoeff(&least);
  side = direction.cross(Vector3::Unit(least)).normalized();
  other = direction.cross(side);
}

/// A tree of clear straight legs from the start. Any frame, the same for all arguments.
class Tree {
 public:
  explicit Tree(const Vector3& root_m) { add(-1, root_m); }

  int size() const { return static_cast<int>(p_m_.size()); }
  const Vector3& at(int node) const { return p_m_[index(node)]; }
  double cost_m(int node) const { return cost_m_[index(node)]; }

  int add(int parent, const Vector3& p_m) {
    const int node = size();
    p_m_.push_back(p_m);
    parent_.push_back(parent);
    children_.emplace_back();
    cost_m_.push_back(parent < 0 ? 0.0 : cost_m(parent) + (p_m - at(parent)).norm());
    if (parent >= 0) children_[index(parent)].push_back(node);
    return node;
  }

  int nearest(const Vector3& p_m) const {
    int best = 0;
    double best_m2 = std::numeric_limits<double>::infinity();
    for (int i = 0; i < size(); ++i) {
      const double m2 = (at(i) - p_m).squaredNorm();
      if (m2 >= best_m2) continue;
      best_m2 = m2;
      best = i;
    }
    return best;
  }

  void within(const Vector3& p_m, double radius_m, std::vector<int>& nodes) const {
    nodes.clear();
    for (int i = 0; i < size(); ++i) {
      if ((at(i) - p_m).squaredNorm() <= radius_m * radius_m) nodes.push_back(i);
    }
  }

  /// Moves a node with its subtree to another parent, which shortens its path.
  void move(int node, int parent) {
    std::vector<int>& siblings = children_[index(parent_[index(node)])];
    siblings.erase(std::find(siblings.begin(), siblings.end(), node));
    children_[index(parent)].push_back(node);
    parent_[index(node)] = parent;
    std::vector<int> changed = {node};
    while (!changed.empty()) {
      const int next = changed.back();
      changed.pop_back();
      const int above = parent_[index(next)];
      cost_m_[index(next)] = cost_m(above) + (at(next) - at(above)).norm();
      changed.insert(changed.end(), children_[index(next)].begin(), children_[index(next)].end());
    }
  }

  std::vector<Vector3> path_to(int node) const {
    std::vector<Vector3> path_m;
    for (int i = node; i >= 0; i = parent_[index(i)]) path_m.push_back(at(i));
    std::reverse(path_m.begin(), path_m.end());
    return path_m;
  }

 private:
  static std::size_t index(int node) { return static_cast<std::size_t>(node); }

  std::vector<Vector3> p_m_;
  std::vector<double> cost_m_;
  std::vector<int> parent_;
  std::vector<std::vector<int>> children_;
};

class SampledPath {
 public:
  SampledPath(const ClearSpace& space, const ClearPathConfig& config, const SamplingConfig& sampling,
              SampledSearch search, const Vector3& start_m, const Vector3& goal_m, std::uint32_t draw)
      : space_(space),
        sampling_(sampling),
        star_(search == SampledSearch::kInformedRrtStar),
        goal_m_(goal_m),
        random_(sampling.seed, "sampled_path", std::to_string(draw)),
        tree_(start_m) {
    min_m_ = start_m.cwiseMin(goal_m).array() - sampling.margin_m;
    max_m_ = start_m.cwiseMax(goal_m).array() + sampling.margin_m;
    min_m_.z() = std::max(min_m_.z(), std::min(config.z_min_m, start_m.z()));
    max_m_.z() = std::min(max_m_.z(), std::max(config.z_max_m, start_m.z()));
    // Karaman 2011, theorem 38: (2 (1 + 1/d))^(1/d) (volume / volume of the unit ball)^(1/d), d = 3.
    const double volume_m3 = (max_m_ - min_m_).cwiseMax(sampling.step_m).prod();
    // Volume of the unit ball, 4 pi / 3.
    constexpr double kUnitBall = 4.18879020478639098;
    rewiring_m_ = kRewiringFactor * elementary::cbrt(8.0 / 3.0 * volume_m3 / kUnitBall);
    reach_goal(0);
  }

  std::vector<Vector3> run() {
    for (num_samples_ = 0; num_samples_ < sampling_.max_samples; ++num_samples_) {
      if (!goal_parents_.empty() && !star_) break;
      grow(sample());
    }
    if (goal_parents_.empty()) return {};
    std::vector<Vector3> path_m = tree_.path_to(best_parent());
    path_m.push_back(goal_m_);
    return path_m;
  }
  std::size_t num_samples() const { return static_cast<std::size_t>(num_samples_); }

 private:
  double uniform(std::uint32_t index) const { return random_.uniform(static_cast<std::uint32_t>(num_samples_), index); }

  Vector3 sample() const {
    if (uniform(0) < sampling_.goal_share && goal_parents_.empty()) return goal_m_;
    if (!goal_parents_.empty()) return sample_for_shorter_path();
    Vector3 p_m;
    for (int i = 0; i < 3; ++i) {
      p_m[i] = min_m_[i] + (max_m_[i] - min_m_[i]) * uniform(static_cast<std::uint32_t>(1 + i));
    }
    return p_m;
  }

  Vector3 sample_for_shorter_path() const {
    Vector3 in_ball;
    std::uint32_t index = 1;
    do {
      for (int i = 0; i < 3; ++i) in_ball[i] = 2.0 * uniform(index++) - 1.0;
    } while (in_ball.squaredNorm() > 1.0);
    return point_in_spheroid(tree_.at(0), goal_m_, cost_over_m(best_parent()), in_ball)
        .cwiseMax(min_m_)
        .cwiseMin(max_m_);
  }

  void grow(const Vector3& toward_m) {
    const int nearest = tree_.nearest(toward_m);
    const Vector3 displacement_m = toward_m - tree_.at(nearest);
    const double length_m = displacement_m.norm();
    if (length_m < 1e-9) return;
    const Vector3 p_m = tree_.at(nearest) + std::min(1.0, sampling_.step_m / length_m) * displacement_m;
    if (!space_.is_clear_segment(tree_.at(nearest), p_m)) return;
    const int added = star_ ? add_rewired(nearest, p_m) : tree_.add(nearest, p_m);
    reach_goal(added);
  }

  /// Adds a node below the neighbor with the shortest path. Neighbors that it shortens become its children.
  int add_rewired(int nearest, const Vector3& p_m) {
    const double n = tree_.size() + 1.0;
    tree_.within(p_m, std::min(rewiring_m_ * elementary::cbrt(elementary::log(n) / n), 2.0 * sampling_.step_m),
                 neighbors_);
    int parent = nearest;
    double cost_m = tree_.cost_m(nearest) + (p_m - tree_.at(nearest)).norm();
    for (const int other : neighbors_) {
      const double other_m = tree_.cost_m(other) + (p_m - tree_.at(other)).norm();
      if (other_m >= cost_m || !space_.is_clear_segment(tree_.at(other), p_m)) continue;
      parent = other;
      cost_m = other_m;
    }
    const int added = tree_.add(parent, p_m);
    for (const int other : neighbors_) {
      const double other_m = cost_m + (p_m - tree_.at(other)).norm();
      if (other_m < tree_.cost_m(other) && space_.is_clear_segment(p_m, tree_.at(other))) tree_.move(other, added);
    }
    return added;
  }

  /// Records a node from which the goal is one clear leg away.
  void reach_goal(int node) {
    const double rest_m = (goal_m_ - tree_.at(node)).norm();
    if (rest_m > sampling_.step_m || !space_.is_clear_segment(tree_.at(node), goal_m_)) return;
    goal_parents_.push_back(node);
  }

  double cost_over_m(int node) const { return tree_.cost_m(node) + (goal_m_ - tree_.at(node)).norm(); }
  int best_parent() const {
    return *std::min_element(goal_parents_.begin(), goal_parents_.end(),
                             [&](int a, int b) { return cost_over_m(a) < cost_over_m(b); });
  }

  const ClearSpace& space_;
  SamplingConfig sampling_;
  bool star_;
  Vector3 goal_m_;
  Random random_;
  Tree tree_;
  Vector3 min_m_, max_m_;  // bounds of samples
  double rewiring_m_ = 0.0;
  std::vector<int> goal_parents_, neighbors_;
  int num_samples_ = 0;
};

}  // namespace

Vector3 point_in_spheroid(const Vector3& focus_m, const Vector3& other_focus_m, double length_m,
                          const Vector3& in_ball) {
  const Vector3 between_m = other_focus_m - focus_m;
  const double least_m = between_m.norm();
  const Vector3 along = least_m > 0.0 ? Vector3(between_m / least_m) : Vector3::UnitX();
  Vector3 side, other;
  axes_across(along, side, other);
  const double across_m = 0.5 * std::sqrt(std::max(0.0, length_m * length_m - least_m * least_m));
  return 0.5 * (focus_m + other_focus_m) + 0.5 * length_m * in_ball.x() * along +
         across_m * (in_ball.y() * side + in_ball.z() * other);
}

ClearPath find_sampled_path(const OccupancyView& view, const ClearPathConfig& config, const SamplingConfig& sampling,
                            SampledSearch search, const Vector3& start_local_m, const Vector3& goal_local_m,
                            std::uint32_t draw) {
  const ClearSpace space(view, config, start_local_m);
  const ClearPathStatus refused = refusal_reason(view, space, config, start_local_m, goal_local_m);
  if (refused != ClearPathStatus::kFound) return {refused, {}, 0};
  SampledPath sampled(space, config, sampling, search, start_local_m, goal_local_m, draw);
  std::vector<Vector3> path_local_m = sampled.run();
  if (path_local_m.empty()) return {ClearPathStatus::kBudgetSpent, {}, sampled.num_samples()};
  return {ClearPathStatus::kFound, shortened_path(space, std::move(path_local_m), config.max_shortenings),
          sampled.num_samples()};
}

void SamplingConfig::visit(ConfigVisitor& v) {
  v.field("step_m", step_m, "[m] largest length of a new branch", Range::between(0.01, 100.0));
  v.field("margin_m", margin_m, "[m] margin around the box of start and goal in which samples lie",
          Range::between(0.0, 1e4));
  v.field("max_samples", max_samples, "[-] largest number of samples", Range::between(1, 20'000));
  v.field("seed", seed, "[-] random seed of the samples");
}

}  // namespace swiftlet
