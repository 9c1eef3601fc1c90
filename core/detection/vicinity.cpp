// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/vicinity.hpp"

#include <algorithm>

namespace swiftlet {

void Vicinity::begin(const VoxelGrid& box, double distance_m) {
  edge_m_ = 1.0001 * std::max(distance_m, box.edge_m);  // margin for rounding
  origin_m_ = box.edge_m * box.min_cell.cast<double>() - Vector3::Constant(edge_m_);
  size_ = (box.edge_m / edge_m_ * box.size.cast<double>()).array().ceil().cast<int>() + 3;
  words_per_row_ = (size_.x() + 63) / 64;
  bits_.assign(static_cast<std::size_t>(size_.y()) * size_.z() * words_per_row_, 0);
}

// Coordinates in the box are positive, so truncation rounds down.
Cell Vicinity::cell_of(const Eigen::Vector3f& p_m) const {
  return ((p_m.cast<double>() - origin_m_) / edge_m_).cast<int>();
}

void Vicinity::add(const Eigen::Vector3f& p_m) {
  const Cell cell = cell_of(p_m);
  for (int z = cell.z() - 1; z <= cell.z() + 1; ++z) {
    for (int y = cell.y() - 1; y <= cell.y() + 1; ++y) {
      std::uint64_t* words = bits_.data() + row(y, z);
      for (int x = cell.x() - 1; x <= cell.x() + 1; ++x) words[x / 64] |= std::uint64_t{1} << (x % 64);
    }
  }
}

bool Vicinity::contains(const Eigen::Vector3f& p_m) const {
  const Cell cell = cell_of(p_m);
  return (bits_[row(cell.y(), cell.z()) + cell.x() / 64] >> (cell.x() % 64)) & 1U;
}

}  // namespace swiftlet
