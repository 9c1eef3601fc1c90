// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lidar_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace swiftlet::sim {
namespace {

// Cells of about equal solid angle, each with 16 to 20 shots of a Mid-360 frame.
constexpr int kBands = 28;
constexpr int kSectors = 72;
constexpr int kStripCols = 16;  // a cache line of ranges; a multiple of the block width

/// Height of the image blocks that makes 16 beams as square in angle as possible.
int block_rows(const LidarPattern& pattern, const BeamTable& beams) {
  const auto at = [&](int r, int c) -> const Eigen::Vector3f& {
    const int column = ((c - pattern.column_shift(r)) % beams.cols + beams.cols) % beams.cols;
    return beams.directions_lidar[static_cast<std::size_t>(r) * beams.cols + column];
  };
  const int middle = beams.rows / 2;
  const double step_up = beams.rows > 1 ? (at(middle, 0) - at(middle - 1, 0)).norm() : 1e3;
  const double step_across = beams.cols > 1 ? (at(middle, 1) - at(middle, 0)).norm() : 1e3;
  int best = 1;
  double best_extent = 1e9;
  for (const int rows : {1, 2, 4, 8, 16}) {
    const double extent = std::max((rows - 1) * step_up, (kPacketSize / rows - 1) * step_across);
    if (rows > beams.rows || extent >= best_extent) continue;
    best = rows;
    best_extent = extent;
  }
  return best;
}

// Strip by strip, each from top to bottom: data used by one strip is still in the cache for the next. Rings around the
// sensor would reuse it only after a whole turn.
std::vector<std::int32_t> image_blocks(const LidarPattern& pattern, const BeamTable& beams) {
  std::vector<std::int32_t> order;
  const int rows = block_rows(pattern, beams);
  const int cols = kPacketSize / rows;
  const auto add_block = [&](int r0, int c0) {
    for (int r = r0; r < r0 + rows; ++r) {
      for (int c = c0; c < c0 + cols; ++c) {
        const bool inside = r < beams.rows && c < beams.cols;
        const int column = inside ? ((c - pattern.column_shift(r)) % beams.cols + beams.cols) % beams.cols : 0;
        order.push_back(inside ? r * beams.cols + column : -1);
      }
    }
  };
  for (int strip = 0; strip < beams.cols; strip += kStripCols) {
    for (int r0 = 0; r0 < beams.rows; r0 += rows) {
      for (int c0 = strip; c0 < std::min(strip + kStripCols, beams.cols); c0 += cols) add_block(r0, c0);
    }
  }
  return order;
}

}  // namespace

// Bands of z, each a row of sectors in alternating direction. Sectors use the diamond angle, which is fast and
// monotonic.
int direction_cell(const Eigen::Vector3f& d) {
  const int band = std::clamp(static_cast<int>((d.z() + 1.0F) * (0.5F * kBands)), 0, kBands - 1);
  const float sum = std::abs(d.x()) + std::abs(d.y());
  const float ratio = sum > 0.0F ? d.x() / sum : 1.0F;
  const float diamond = d.y() >= 0.0F ? 1.0F - ratio : 3.0F + ratio;  // 0..4
  const int sector = std::clamp(static_cast<int>(diamond * (0.25F * kSectors)), 0, kSectors - 1);
  return band * kSectors + (band % 2 == 0 ? sector : kSectors - 1 - sector);
}

LidarTiler::LidarTiler(const LidarPattern& pattern, const BeamTable& beams, bool one_firing_a_column)
    : is_image_(pattern.is_image()), one_firing_a_column_(one_firing_a_column) {
  if (is_image_) {
    order_ = image_blocks(pattern, beams);
    return;
  }
  order_.assign((beams.size() + kPacketSize - 1) / kPacketSize * kPacketSize, -1);
  cell_.resize(beams.size());
  first_.resize(kBands * kSectors + 1);
}

// Counting sort by cell; stable, so that the order depends only on the beams.
void LidarTiler::arrange_scattered(const BeamTable& beams) {
  std::fill(first_.begin(), first_.end(), 0);
  for (int i = 0; i < beams.size(); ++i) {
    cell_[i] = direction_cell(beams.directions_lidar[i]);
    ++first_[cell_[i] + 1];
  }
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  for (int i = 0; i < beams.size(); ++i) order_[first_[cell_[i]]++] = i;
}

void LidarTiler::arrange(const BeamTable& beams, std::vector<LidarTile>& tiles) {
  if (!is_image_) arrange_scattered(beams);
  tiles.resize(order_.size() / kPacketSize);
  for (std::size_t k = 0; k < order_.size(); ++k) tiles[k / kPacketSize].beam[k % kPacketSize] = order_[k];
}

void LidarTiler::load(const BeamTable& beams, LidarTile& tile) const {
  int last = *std::max_element(tile.beam.begin(), tile.beam.end());
  for (int i = 0; i < kPacketSize; ++i) {
    // Unused lanes repeat another lane.
    const int beam = tile.beam[i] >= 0 ? tile.beam[i] : last;
    tile.beams.direction_x[i] = beams.directions_lidar[beam].x();
    tile.beams.direction_y[i] = beams.directions_lidar[beam].y();
    tile.beams.direction_z[i] = beams.directions_lidar[beam].z();
    tile.beams.firing[i] = one_firing_a_column_ ? beam % beams.cols : beam;
  }
}

}  // namespace swiftlet::sim
