// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/slam/cell_keys.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Probabilities from 0.1 to 0.9 as integers 1 to 32767; 0 is unknown, and counts as 0.1.
namespace grid_value {

/// Value of a cell that was never observed, and largest value.
inline constexpr std::uint16_t kUnknown = 0, kMost = 32767;
/// [-] Bounds of the probability of a surface, as in Cartographer: no number of observations makes a cell certain.
/// Wider bounds make cells slower to change.
inline constexpr double kMinProbability = 0.1, kMaxProbability = 0.9;

inline double probability_of(std::uint16_t value) {
  if (value == kUnknown) return kMinProbability;
  return kMinProbability + (kMaxProbability - kMinProbability) / (kMost - 1) * (value - 1);
}
/// Value of the nearest representable probability, clamped at both ends.
std::uint16_t value_of(double probability);

}  // namespace grid_value

/// Update table for an observation with a given probability: multiplication of odds.
class OddsTable {
 public:
  explicit OddsTable(double probability);
  std::uint16_t after(std::uint16_t value) const { return table_[value]; }

 private:
  std::vector<std::uint16_t> table_;
};

/// Probability of a surface in each cell, in blocks of 8 x 8 x 8 cells, allocated on demand. A cell's center is its
/// index times the resolution, as in Cartographer, without an offset of half a cell.
///
/// Any frame, the same for all arguments. Results depend on the set of the points of each scan, not on their order.
class HybridGrid {
 public:
  explicit HybridGrid(double resolution_m) : resolution_m_(resolution_m) {}

  Eigen::Vector3i cell_at(const Vector3& p_m) const;
  Vector3 center_m(const Eigen::Vector3i& cell) const { return resolution_m_ * cell.cast<double>(); }
  std::uint16_t value(const Eigen::Vector3i& cell) const;
  double probability(const Eigen::Vector3i& cell) const { return grid_value::probability_of(value(cell)); }

  /// Interpolated probability and its gradient.
  struct Interpolated {
    double probability = grid_value::kMinProbability;
    Vector3 slope_1_m = Vector3::Zero();
  };
  /// Cubic interpolation along each axis through the values at cell centers, with zero slope there.
  Interpolated interpolate(const Vector3& p_m) const;

  /// Inserts a scan: its points are hits, and the last cells before them on the rays from the origin are misses. Each
  /// cell is updated once; hits take precedence.
  void insert(std::span<const Vector3> points_m, const Vector3& origin_m, const OddsTable& hit, const OddsTable& miss,
              int cells_missed);
  /// Keeps the memory.
  void clear();

  double resolution_m() const { return resolution_m_; }
  std::size_t num_blocks() const { return blocks_.size(); }
  std::size_t bytes() const;

 private:
  using Block = std::array<std::uint16_t, 512>;
  // Flag of cells updated by the present scan: the bit above the bits of a value.
  static constexpr std::uint16_t kChanged = grid_value::kMost + 1;

  const Block* find(const Eigen::Vector3i& cell) const;
  void change(const Eigen::Vector3i& cell, const OddsTable& table);

  double resolution_m_;
  KeyTable table_;
  std::vector<Block> blocks_;  // in the order of their creation
  struct Place {
    std::uint32_t block = 0, cell = 0;
  };
  std::vector<Place> changed_;
  std::uint64_t last_key_ = 0;    // key of the block that changed last, if there are any
  std::uint32_t last_block_ = 0;  // number of that block
};

}  // namespace swiftlet
