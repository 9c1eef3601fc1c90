// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/euclidean_clusters.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();  // no cell, or no cluster

// Edge of a cell, as a share of the tolerance: slightly less than 1 / sqrt(3), so that any two points of a cell are
// near each other. Points of cells three or more apart along an axis are not near.
constexpr double kCellEdge = 0.577;
// [cells] Largest distance along an axis of cells with near points.
constexpr int kReach = 2;

/// [bits] Cell index along one axis in a key; kRow / 2 makes indices positive.
constexpr int kAxisBits = 21;
constexpr std::int64_t kRow = std::int64_t{1} << kAxisBits;  // one step along y in a key
constexpr std::int64_t kLayer = kRow << kAxisBits;           // one step along z in a key

/// Index of the point's cell along one axis, or -1 when it is out of range.
std::int64_t axis_cell(float coordinate_m, double cells_per_m) {
  const double cell = std::floor(static_cast<double>(coordinate_m) * cells_per_m);
  if (!(std::abs(cell) < static_cast<double>(kRow / 2 - kReach))) return -1;  // catches NaN too
  return static_cast<std::int64_t>(cell) + kRow / 2;
}

/// Stable radix sort by key. A digit that all keys share is skipped after its histogram.
template <class Keyed>
void radix_sort(std::vector<Keyed>& items, std::vector<Keyed>& scratch) {
  // Bits of a digit of the key, and digits of the key. Longer digits need fewer passes and larger tables of counts.
  constexpr int kDigitBits = 9, kDigits = 3 * kAxisBits / kDigitBits;
  constexpr std::uint32_t kBuckets = 1U << kDigitBits;
  std::array<std::array<std::uint32_t, kBuckets>, kDigits> counts{};
  for (const Keyed& item : items) {
    for (int d = 0; d < kDigits; ++d) ++counts[d][(item.key >> (d * kDigitBits)) & (kBuckets - 1)];
  }
  scratch.resize(items.size());
  for (int d = 0; d < kDigits; ++d) {
    std::array<std::uint32_t, kBuckets>& count = counts[d];
    const auto digit = [d](const Keyed& item) { return (item.key >> (d * kDigitBits)) & (kBuckets - 1); };
    if (items.empty() || count[digit(items.front())] == items.size()) continue;
    std::uint32_t next = 0;
    for (std::uint32_t& c : count) {
      const std::uint32_t here = c;
      c = next;
      next += here;
    }
    for (const Keyed& item : items) scratch[count[digit(item)]++] = item;
    items.swap(scratch);
  }
}

float distance_sq_to_box(const Eigen::Vector3f& p, const Eigen::Vector3f& min, const Eigen::Vector3f& max) {
  return (p - p.cwiseMax(min).cwiseMin(max)).squaredNorm();
}

}  // namespace

void EuclideanClusters::compute(std::span<const Eigen::Vector3f> points_m, double tolerance_m) {
  fill_cells(points_m, tolerance_m);
  join_cells(points_m, static_cast<float>(tolerance_m));
  collect(points_m.size());
}

void EuclideanClusters::fill_cells(std::span<const Eigen::Vector3f> points, double tolerance_m) {
  const double cells_per_m = 1.0 / (kCellEdge * tolerance_m);
  keyed_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int64_t x = axis_cell(points[i].x(), cells_per_m), y = axis_cell(points[i].y(), cells_per_m),
                       z = axis_cell(points[i].z(), cells_per_m);
    if (x < 0 || y < 0 || z < 0) continue;
    keyed_.push_back({static_cast<std::uint64_t>(z * kLayer + y * kRow + x), static_cast<std::uint32_t>(i)});
  }
  radix_sort(keyed_, scratch_);

  cells_.clear();
  cell_of_.assign(points.size(), kNone);
  for (std::uint32_t k = 0; k < keyed_.size(); ++k) {
    const Eigen::Vector3f& p = points[keyed_[k].point];
    if (cells_.empty() || cells_.back().key != keyed_[k].key) cells_.push_back({keyed_[k].key, k, 0, p, p});
    Cell& cell = cells_.back();
    ++cell.count;
    cell.min = cell.min.cwiseMin(p);
    cell.max = cell.max.cwiseMax(p);
    cell_of_[keyed_[k].point] = static_cast<std::uint32_t>(cells_.size() - 1);
  }
}

// Cells are sorted by key, so cells that can be near lie in windows that only move forward: one for each row of cells
// within reach. Half of the rows suffice, because nearness is symmetric.
void EuclideanClusters::join_cells(std::span<const Eigen::Vector3f> points, float tolerance_m) {
  parents_.resize(cells_.size());
  for (std::uint32_t i = 0; i < parents_.size(); ++i) parents_[i] = i;
  keys_.resize(cells_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) keys_[i] = cells_[i].key;
  for (std::int64_t dz = 0; dz <= kReach; ++dz) {
    for (std::int64_t dy = dz == 0 ? 0 : -kReach; dy <= kReach; ++dy) {
      const bool own_row = dz == 0 && dy == 0;
      const std::int64_t offset = dz * kLayer + dy * kRow;
      std::size_t window = 0;
      for (std::uint32_t i = 0; i < cells_.size(); ++i) {
        const std::int64_t center = static_cast<std::int64_t>(cells_[i].key) + offset;
        const std::int64_t begin = own_row ? center + 1 : center - kReach;
        while (window < cells_.size() && static_cast<std::int64_t>(keys_[window]) < begin) ++window;
        if (window == cells_.size() || static_cast<std::int64_t>(keys_[window]) > center + kReach) continue;
        std::uint32_t a = root(i);
        for (std::size_t j = window; j < cells_.size(); ++j) {
          if (static_cast<std::int64_t>(keys_[j]) > center + kReach) break;
          const std::uint32_t b = root(static_cast<std::uint32_t>(j));
          if (a == b || !are_near(points, cells_[i], cells_[j], tolerance_m)) continue;
          parents_[std::max(a, b)] = std::min(a, b);
          a = std::min(a, b);
        }
      }
    }
  }
}

bool EuclideanClusters::are_near(std::span<const Eigen::Vector3f> points, const Cell& a, const Cell& b,
                                 float tolerance_m) const {
  const float tolerance_sq = tolerance_m * tolerance_m;
  const Eigen::Vector3f gap = (a.min - b.max).cwiseMax(b.min - a.max).cwiseMax(0.0F);
  if (gap.squaredNorm() > tolerance_sq) return false;  // no pair of points is nearer: rounding is monotonic
  for (std::uint32_t i = a.first; i < a.first + a.count; ++i) {
    const Eigen::Vector3f& p = points[keyed_[i].point];
    if (distance_sq_to_box(p, b.min, b.max) > tolerance_sq) continue;
    for (std::uint32_t j = b.first; j < b.first + b.count; ++j) {
      if ((p - points[keyed_[j].point]).squaredNorm() <= tolerance_sq) return true;
    }
  }
  return false;
}

std::uint32_t EuclideanClusters::root(std::uint32_t cell) {
  while (parents_[cell] != cell) {
    parents_[cell] = parents_[parents_[cell]];
    cell = parents_[cell];
  }
  return cell;
}

void EuclideanClusters::collect(std::size_t num_points) {
  labels_.assign(cells_.size(), kNone);
  starts_.assign(1, 0);
  for (std::size_t i = 0; i < num_points; ++i) {
    if (cell_of_[i] == kNone) continue;
    const std::uint32_t r = root(cell_of_[i]);
    if (labels_[r] == kNone) {
      labels_[r] = static_cast<std::uint32_t>(starts_.size() - 1);
      starts_.push_back(0);
    }
    cell_of_[i] = labels_[r];
    ++starts_[labels_[r] + 1];
  }
  for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
  members_.resize(starts_.back());
  labels_.assign(starts_.begin(), starts_.end());  // index of the next member of each cluster
  for (std::size_t i = 0; i < num_points; ++i) {
    if (cell_of_[i] != kNone) members_[labels_[cell_of_[i]]++] = static_cast<std::uint32_t>(i);
  }
}

}  // namespace swiftlet
