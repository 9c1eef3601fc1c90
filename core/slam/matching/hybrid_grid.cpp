// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/hybrid_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace swiftlet {
namespace {

std::uint64_t block_key(const Eigen::Vector3i& cell) { return cell_key(cell.x() >> 3, cell.y() >> 3, cell.z() >> 3); }

std::uint32_t cell_in_block(const Eigen::Vector3i& cell) {
  return static_cast<std::uint32_t>((cell.x() & 7) | (cell.y() & 7) << 3 | (cell.z() & 7) << 6);
}

/// A cubic from 0 to 1 with zero slope at its ends, and its slope.
struct Rise {
  double value, slope;
  explicit Rise(double t) : value(t * t * (3.0 - 2.0 * t)), slope(6.0 * t * (1.0 - t)) {}
};

double odds_of(double probability) { return probability / (1.0 - probability); }

}  // namespace

std::uint16_t grid_value::value_of(double probability) {
  const double share = (probability - kMinProbability) / (kMaxProbability - kMinProbability);
  return static_cast<std::uint16_t>(1.0 + std::floor(std::clamp(share, 0.0, 1.0) * (kMost - 1) + 0.5));
}

OddsTable::OddsTable(double probability) : table_(grid_value::kMost + 1) {
  table_[grid_value::kUnknown] = grid_value::value_of(probability);
  for (std::uint32_t value = 1; value <= grid_value::kMost; ++value) {
    const double odds = odds_of(probability) * odds_of(grid_value::probability_of(static_cast<std::uint16_t>(value)));
    table_[value] = grid_value::value_of(odds / (1.0 + odds));
  }
}

Eigen::Vector3i HybridGrid::cell_at(const Vector3& p_m) const {
  return ((p_m / resolution_m_).array() + 0.5).floor().cast<int>();
}

const HybridGrid::Block* HybridGrid::find(const Eigen::Vector3i& cell) const {
  const std::uint32_t found = table_.find(block_key(cell));
  return found == 0 ? nullptr : &blocks_[found - 1];
}

std::uint16_t HybridGrid::value(const Eigen::Vector3i& cell) const {
  const Block* block = find(cell);
  return block == nullptr ? grid_value::kUnknown : (*block)[cell_in_block(cell)];
}

HybridGrid::Interpolated HybridGrid::interpolate(const Vector3& p_m) const {
  const Vector3 at = p_m / resolution_m_;
  const Vector3 lower = at.array().floor();
  const Eigen::Vector3i cell = lower.cast<int>();
  // Corner i lies one cell further along x, y, z for its bits 0, 1, 2.
  std::array<double, 8> q;
  const bool one_block = (cell.x() & 7) < 7 && (cell.y() & 7) < 7 && (cell.z() & 7) < 7;
  if (one_block) {
    const Block* block = find(cell);
    if (block == nullptr) return {};
    const std::uint32_t first = cell_in_block(cell);
    for (std::uint32_t i = 0; i < 8; ++i)
      q[i] = grid_value::probability_of((*block)[first + (i & 1U) + ((i & 2U) << 2U) + ((i & 4U) << 4U)]);
  } else {
    for (int i = 0; i < 8; ++i) q[i] = probability(cell + Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2));
  }
  const Rise x(at.x() - lower.x()), y(at.y() - lower.y()), z(at.z() - lower.z());
  std::array<double, 4> along_x, by_x;
  for (int i = 0; i < 4; ++i) {
    by_x[i] = q[2 * i + 1] - q[2 * i];
    along_x[i] = q[2 * i] + by_x[i] * x.value;
  }
  const double low = along_x[0] + (along_x[1] - along_x[0]) * y.value;
  const double high = along_x[2] + (along_x[3] - along_x[2]) * y.value;
  const double by_x_low = by_x[0] + (by_x[1] - by_x[0]) * y.value;
  const double by_x_high = by_x[2] + (by_x[3] - by_x[2]) * y.value;
  const double by_y_low = along_x[1] - along_x[0], by_y_high = along_x[3] - along_x[2];
  Interpolated out;
  out.probability = low + (high - low) * z.value;
  out.slope_1_m = Vector3((by_x_low + (by_x_high - by_x_low) * z.value) * x.slope,
                          (by_y_low + (by_y_high - by_y_low) * z.value) * y.slope, (high - low) * z.slope) /
                  resolution_m_;
  return out;
}

void HybridGrid::insert(std::span<const Vector3> points_m, const Vector3& origin_m, const OddsTable& hit,
                        const OddsTable& miss, int cells_missed) {
  changed_.clear();
  for (const Vector3& p_m : points_m) change(cell_at(p_m), hit);
  const Eigen::Vector3i from = cell_at(origin_m);
  for (const Vector3& p_m : points_m) {
    // As many steps as cells along the longest axis.
    const Eigen::Vector3i offset = cell_at(p_m) - from;
    const int steps = offset.cwiseAbs().maxCoeff();
    for (int step = std::max(0, steps - cells_missed); step < steps; ++step) change(from + offset * step / steps, miss);
  }
  for (const Place& place : changed_) blocks_[place.block][place.cell] &= static_cast<std::uint16_t>(~kChanged);
}

void HybridGrid::change(const Eigen::Vector3i& cell, const OddsTable& table) {
  const std::uint64_t key = block_key(cell);
  if (blocks_.empty() || key != last_key_) {
    last_block_ = table_.find_or_insert(key);
    last_key_ = key;
    if (last_block_ == blocks_.size()) blocks_.emplace_back().fill(grid_value::kUnknown);
  }
  const std::uint32_t place = cell_in_block(cell);
  std::uint16_t& value = blocks_[last_block_][place];
  if ((value & kChanged) != 0) return;
  value = table.after(value) | kChanged;
  changed_.push_back({last_block_, place});
}

void HybridGrid::clear() {
  table_.clear();
  blocks_.clear();
}

std::size_t HybridGrid::bytes() const {
  return blocks_.capacity() * sizeof(Block) + table_.bytes() + changed_.capacity() * sizeof(Place);
}

}  // namespace swiftlet
