// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/branch_and_bound.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

Eigen::Vector3i cell_of(const Vector3& p_m, double cell_m) { return (p_m / cell_m).array().floor().cast<int>(); }

/// A block of displacements starting at `offset`: 2^level along x and y, and along z.
struct Node {
  int level = 0;
  Eigen::Vector3i offset = Eigen::Vector3i::Zero();
  int score = 0;  // an upper bound
};

/// Branch and bound over the displacements of the cloud at one heading.
class Search {
 public:
  Search(const OccupancyPyramid& map, const SearchWindow& window, std::int64_t budget, SearchResult& result)
      : map_(map), window_(window), budget_(budget), result_(result) {}

  int best_score = 0;
  Eigen::Vector3i best_offset = Eigen::Vector3i::Zero();
  int best_yaw = -1;

  /// Excludes displacements whose distance (in cells) from `center` is less than `radius`.
  void run(int i_yaw, const std::vector<Eigen::Vector3i>& cells, const Eigen::Vector3d* center, double radius) {
    cells_ = &cells;
    center_ = center;
    radius_ = radius;
    i_yaw_ = i_yaw;
    const int top = map_.levels() - 1, step = 1 << top;
    std::vector<Node> nodes;
    for (int x = -window_.xy_cells; x <= window_.xy_cells; x += step) {
      for (int y = -window_.xy_cells; y <= window_.xy_cells; y += step) {
        for (int z = -window_.z_cells; z <= window_.z_cells; z += step) nodes.push_back({top, {x, y, z}, 0});
      }
    }
    branch(nodes);
  }

 private:
  int score(const Node& node) const {
    int sum = 0;
    for (const Eigen::Vector3i& c : *cells_) {
      sum += map_.at(node.level, c.x() + node.offset.x(), c.y() + node.offset.y(), c.z() + node.offset.z()) ? 1 : 0;
    }
    return sum;
  }

  void branch(std::vector<Node>& nodes) {
    for (Node& node : nodes) {
      ++result_.num_expanded;
      node.score = score(node);
    }
    std::stable_sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.score > b.score; });
    for (const Node& node : nodes) {
      if (node.score <= best_score) return;  // sorted: the following nodes score no higher
      if (result_.num_expanded > budget_) {
        result_.complete = false;
        return;
      }
      if (node.level == 0) {
        if (center_ != nullptr && (node.offset.cast<double>() - *center_).norm() < radius_) continue;
        best_score = node.score;
        best_offset = node.offset;
        best_yaw = i_yaw_;
        continue;
      }
      std::vector<Node> children;
      children.reserve(8);
      const int half = 1 << (node.level - 1);
      for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3i offset = node.offset + half * Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2 & 1);
        if (offset.x() <= window_.xy_cells && offset.y() <= window_.xy_cells && offset.z() <= window_.z_cells) {
          children.push_back({node.level - 1, offset, 0});
        }
      }
      branch(children);
    }
  }

  const OccupancyPyramid& map_;
  const SearchWindow& window_;
  std::int64_t budget_;
  SearchResult& result_;
  const std::vector<Eigen::Vector3i>* cells_ = nullptr;
  const Eigen::Vector3d* center_ = nullptr;
  double radius_ = 0.0;
  int i_yaw_ = 0;
};

/// Rotates the cloud about its own origin.
Pose turned(const Pose& T_map_cloud, double yaw_rad) {
  Pose T = T_map_cloud;
  T.linear() = rotation_by({0, 0, yaw_rad}).toRotationMatrix() * T_map_cloud.linear();
  return T;
}

double heading_apart_rad(const Pose& a, const Pose& b) {
  return std::abs(yaw_of(Matrix3(a.linear().transpose() * b.linear())));
}

}  // namespace

OccupancyPyramid::OccupancyPyramid(std::span<const Eigen::Vector3f> points_map_m, double cell_m, int levels)
    : cell_m_(cell_m) {
  ENSURE(cell_m > 0.0 && levels >= 1 && levels <= 12, cell_m, levels);
  Eigen::Vector3i max = Eigen::Vector3i::Constant(-1);
  for (std::size_t i = 0; i < points_map_m.size(); ++i) {
    const Eigen::Vector3i c = cell_of(points_map_m[i].cast<double>(), cell_m);
    min_ = i == 0 ? c : Eigen::Vector3i(min_.cwiseMin(c));
    max = i == 0 ? c : Eigen::Vector3i(max.cwiseMax(c));
  }
  // A cell of level h also covers up to 2^h - 1 cells below the box.
  const int reach = (1 << (levels - 1)) - 1;
  min_.array() -= reach;
  size_ = (max - min_).array() + 1;
  if (points_map_m.empty()) size_.setZero();
  const auto index = [&](int x, int y, int z) {
    return (static_cast<std::size_t>(x) * size_.y() + static_cast<std::size_t>(y)) * size_.z() +
           static_cast<std::size_t>(z);
  };
  bits_.resize(levels);
  bits_[0].assign(static_cast<std::size_t>(size_.x()) * size_.y() * size_.z(), 0);
  for (const Eigen::Vector3f& p : points_map_m) {
    const Eigen::Vector3i c = cell_of(p.cast<double>(), cell_m) - min_;
    bits_[0][index(c.x(), c.y(), c.z())] = 1;
  }
  for (int h = 1; h < levels; ++h) {
    // Per axis: a cell or the cell half an edge further.
    bits_[h] = bits_[h - 1];
    std::vector<std::uint8_t>& bits = bits_[h];
    const int half = 1 << (h - 1);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3i end = size_ - half * Eigen::Vector3i::Unit(axis);
      const std::size_t stride = axis == 0 ? index(half, 0, 0) : axis == 1 ? index(0, half, 0) : index(0, 0, half);
      for (int x = 0; x < end.x(); ++x) {
        for (int y = 0; y < end.y(); ++y) {
          for (int z = 0; z < end.z(); ++z) bits[index(x, y, z)] |= bits[index(x, y, z) + stride];
        }
      }
    }
  }
}

bool OccupancyPyramid::at(int level, int x, int y, int z) const {
  const int i = x - min_.x(), j = y - min_.y(), k = z - min_.z();
  if (i < 0 || j < 0 || k < 0 || i >= size_.x() || j >= size_.y() || k >= size_.z()) return false;
  return bits_[level][(static_cast<std::size_t>(i) * size_.y() + j) * size_.z() + k] != 0;
}

int num_yaws(const SearchWindow& window) {
  return 2 * static_cast<int>(std::floor(window.yaw_rad / window.yaw_step_rad)) + 1;
}

double yaw_offset_rad(const SearchWindow& window, int i) { return (i - num_yaws(window) / 2) * window.yaw_step_rad; }

SearchResult search_best_pose(const OccupancyPyramid& map, std::span<const Eigen::Vector3f> points_cloud_m,
                              const Pose& T_map_cloud_guess, const SearchWindow& window, double score_min,
                              std::int64_t budget, std::span<const std::uint8_t> yaws_allowed,
                              const Excluded* excluded) {
  SearchResult result;
  const int yaws = num_yaws(window), num = static_cast<int>(points_cloud_m.size());
  ENSURE(yaws_allowed.empty() || static_cast<int>(yaws_allowed.size()) == yaws, yaws_allowed.size(), yaws);
  if (num == 0) return result;
  Search search(map, window, budget, result);
  // Only scores above this bound are accepted.
  search.best_score = std::max(static_cast<int>(std::ceil(score_min * num - 1e-9)) - 1, 0);
  std::vector<Eigen::Vector3i> cells(points_cloud_m.size());
  for (int i = 0; i < yaws && result.complete; ++i) {
    if (!yaws_allowed.empty() && yaws_allowed[i] == 0) continue;
    const Pose T = turned(T_map_cloud_guess, yaw_offset_rad(window, i));
    for (int j = 0; j < num; ++j) cells[j] = cell_of(T * points_cloud_m[j].cast<double>(), map.cell_m());
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    const bool excludes = excluded != nullptr && heading_apart_rad(T, excluded->T_map_cloud) <= excluded->angle_rad;
    if (excludes) center = (excluded->T_map_cloud.translation() - T.translation()) / map.cell_m();
    search.run(i, cells, excludes ? &center : nullptr, excludes ? excluded->distance_m / map.cell_m() : 0.0);
  }
  if (search.best_yaw < 0) return result;
  GridMatch match;
  match.T_map_cloud = turned(T_map_cloud_guess, yaw_offset_rad(window, search.best_yaw));
  match.T_map_cloud.translation() += map.cell_m() * search.best_offset.cast<double>();
  match.score = static_cast<double>(search.best_score) / num;
  result.best = match;
  return result;
}

RotationalHistogram::RotationalHistogram(std::span<const Eigen::Vector3f> points_cloud_m) {
  // [m] Height of a slice, and least and largest distance of neighbors about its centroid that are taken for one
  // surface. Higher slices mix surfaces; a larger distance counts directions from one surface to another.
  constexpr float kSlice_m = 0.2F, kNear_m = 0.2F, kFar_m = 0.9F;
  struct Point {
    int slice = 0;
    double angle_rad = 0.0;
    Eigen::Vector2f p;
  };
  std::vector<Point> points(points_cloud_m.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {static_cast<int>(std::floor(points_cloud_m[i].z() / kSlice_m)), 0.0, points_cloud_m[i].head<2>()};
  }
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.slice < b.slice; });
  for (std::size_t first = 0, last = 0; first < points.size(); first = last) {
    Eigen::Vector2f centroid_m = Eigen::Vector2f::Zero();
    for (last = first; last < points.size() && points[last].slice == points[first].slice; ++last) {
      centroid_m += points[last].p;
    }
    centroid_m /= static_cast<float>(last - first);
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector2f d = points[i].p - centroid_m;
      points[i].angle_rad = elementary::atan2(d.y(), d.x());
    }
    std::stable_sort(points.begin() + static_cast<std::ptrdiff_t>(first),
                     points.begin() + static_cast<std::ptrdiff_t>(last),
                     [](const Point& a, const Point& b) { return a.angle_rad < b.angle_rad; });
    for (std::size_t i = first; i + 1 < last; ++i) {
      const Eigen::Vector2f d = points[i + 1].p - points[i].p, out = points[i].p - centroid_m;
      const float length_m = d.norm(), out_m = out.norm();
      if (length_m < kNear_m || length_m > kFar_m || out_m < kNear_m) continue;
      double direction = elementary::atan2(d.y(), d.x());
      if (direction < 0.0) direction += kPi;
      const int bucket = std::min(static_cast<int>(direction / kPi * kBuckets), kBuckets - 1);
      weight_[bucket] += 1.0 - std::abs(d.dot(out)) / (length_m * out_m);
    }
  }
}

RotationalHistogram::RotationalHistogram(std::span<const std::uint8_t, kBuckets> quantized) {
  std::copy(quantized.begin(), quantized.end(), weight_.begin());
}

std::vector<std::uint8_t> RotationalHistogram::quantized() const {
  const double most = *std::max_element(weight_.begin(), weight_.end());
  std::vector<std::uint8_t> quantized(kBuckets, 0);
  if (!(most > 0.0)) return quantized;
  for (std::size_t i = 0; i < quantized.size(); ++i) {
    quantized[i] = static_cast<std::uint8_t>(std::floor(255.0 * weight_[i] / most + 0.5));
  }
  return quantized;
}

double RotationalHistogram::similarity(const RotationalHistogram& other, double yaw_rad) const {
  const double shift = yaw_rad / kPi * kBuckets;
  const int whole = static_cast<int>(std::floor(shift));
  const double part = shift - whole;
  double dot = 0.0, own = 0.0, others = 0.0;
  for (int i = 0; i < kBuckets; ++i) {
    const auto at = [&](int j) { return weight_[((j % kBuckets) + kBuckets) % kBuckets]; };
    const double turned_weight = (1.0 - part) * at(i - whole) + part * at(i - whole - 1);
    dot += turned_weight * other.weight_[i];
    own += turned_weight * turned_weight;
    others += other.weight_[i] * other.weight_[i];
  }
  return own > 0.0 && others > 0.0 ? dot / std::sqrt(own * others) : 1.0;
}

}  // namespace swiftlet
