// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/placed_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/map/cell_walk.hpp"
#include "swiftlet/core/base/rounding.hpp"

namespace swiftlet {
namespace {

constexpr int kSide = CellBlock::kSide;

/// [-] Step of rounded positions, as a share of a cell's edge. Larger values move pieces less often, and worse.
constexpr double kPoseStep = 0.25;

bool is_lattice_m(double p_m, double step_m, int& steps) {
  const double count = std::round(p_m / step_m);
  steps = static_cast<int>(count);
  return std::abs(p_m - count * step_m) < kRounding * step_m;
}

}  // namespace

PlacedCells::PlacedCells(std::shared_ptr<const SubmapCells> cells, double edge_m)
    : cells_(std::move(cells)), edge_m_(edge_m), middle_cells_m_(cells_->middle_m()), reach_m_(cells_->reach_m()) {}

Pose PlacedCells::rounded(const Pose& T_local_cells) const {
  const double step_m = kPoseStep * edge_m_, step = 0.5 * step_m / std::max(reach_m_, step_m);
  Eigen::Quaterniond q(T_local_cells.linear());
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  // A rotation is about twice the change of the quaternion.
  for (int i = 0; i < 4; ++i) q.coeffs()[i] = step * std::round(q.coeffs()[i] / step);
  Vector3 middle_local_m = T_local_cells * middle_cells_m_;
  for (int axis = 0; axis < 3; ++axis) middle_local_m[axis] = step_m * std::round(middle_local_m[axis] / step_m);
  Pose T = Pose::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = middle_local_m - T.linear() * middle_cells_m_;
  return T;
}

void PlacedCells::place(const Pose& T_local_cells) {
  T_local_cells_ = T_local_cells;
  const Matrix3 R_back = T_local_cells.linear().transpose();
  M_ = R_back * (edge_m_ / cells_->edge_m());
  M_back_ = T_local_cells.linear() * (cells_->edge_m() / edge_m_);
  o_cells_ = -(R_back * T_local_cells.translation()) / cells_->edge_m();
  aligned_ = cells_->edge_m() == edge_m_ && T_local_cells.linear() == Matrix3::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    const bool fits = is_lattice_m(T_local_cells.translation()[axis], kSide * edge_m_, offset_blocks_[axis]);
    aligned_ = aligned_ && fits;
  }
}

std::vector<Cell> PlacedCells::overlapped_groups() const {
  constexpr double kCells = SubmapCells::kGroup_cells;
  const Vector3 half = (0.5 * kCells) * (M_back_.cwiseAbs() * Vector3::Ones()).array() + kRounding;
  std::vector<Cell> groups;
  for (const Cell& group : cells_->groups()) {
    const Vector3 middle = M_back_ * (kCells * (group.cast<double>().array() + 0.5) - o_cells_.array()).matrix();
    const Cell low = ((middle - half) / kCells).array().floor().cast<int>();
    const Cell high = ((middle + half) / kCells).array().floor().cast<int>();
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) groups.emplace_back(x, y, z);
      }
    }
  }
  return groups;
}

bool PlacedCells::look(const Cell& block, const Bits& wanted, Overlap& overlap, Bits& occupied, Bits& free) const {
  if (aligned_) {
    const int i = cells_->find(block - offset_blocks_);
    if (i < 0) return false;
    const Bits* its_occupied = cells_->occupied_of(i);
    occupied = its_occupied != nullptr ? *its_occupied : Bits{};
    free = cells_->free_of(i);
    return true;
  }
  if (!find_overlap(block, overlap)) return false;
  sample_centers(block, wanted, overlap, occupied, free);
  if (!overlap.any_occupied) return true;
  mark_occupied(block, overlap, occupied);
  for (std::size_t z = 0; z < free.size(); ++z) free[z] &= ~occupied[z];
  return true;
}

bool PlacedCells::find_overlap(const Cell& block, Overlap& overlap) const {
  const Vector3 first = (kSide * block).cast<double>();
  const Vector3 middle = M_ * (first.array() + 0.5 * kSide).matrix() + o_cells_;
  const Vector3 half = (0.5 * kSide) * (M_.cwiseAbs() * Vector3::Ones()).array() + kRounding;
  overlap.low = ((middle - half) / kSide).array().floor().cast<int>();
  overlap.size = ((middle + half) / kSide).array().floor().cast<int>().matrix() - overlap.low + Cell::Ones();
  overlap.blocks.clear();
  overlap.any_occupied = false;
  bool any = false;
  for (int z = 0; z < overlap.size.z(); ++z) {
    for (int y = 0; y < overlap.size.y(); ++y) {
      for (int x = 0; x < overlap.size.x(); ++x) {
        const int i = cells_->find(overlap.low + Cell(x, y, z));
        overlap.blocks.push_back(i);
        any = any || i >= 0;
        overlap.any_occupied = overlap.any_occupied || (i >= 0 && cells_->occupied_of(i) != nullptr);
      }
    }
  }
  return any;
}

/// States of the piece at the centers of the block's cells.
void PlacedCells::sample_centers(const Cell& block, const Bits& wanted, const Overlap& overlap, Bits& occupied,
                                 Bits& free) const {
  // [-] Binary digits of a fraction of a cell: coordinates along a row of cells are sums of integers. Fewer digits
  // sample beside the centers.
  constexpr int kBits = 24;
  const Vector3 first = (kSide * block).cast<double>();
  const Vector3 from = M_ * (first.array() + 0.5).matrix() + o_cells_ - (kSide * overlap.low).cast<double>();
  const auto whole = [](double x) { return static_cast<std::int64_t>(std::floor(x * (1U << kBits))); };
  const std::int64_t dx = whole(M_(0, 0)), dy = whole(M_(1, 0)), dz = whole(M_(2, 0));
  for (int z = 0; z < kSide; ++z) {
    std::uint64_t layer_occupied = 0, layer_free = 0;
    const std::uint64_t layer_wanted = wanted[static_cast<std::size_t>(z)];
    for (int y = 0; y < kSide; ++y) {
      if ((layer_wanted >> (kSide * y) & 0xFFU) == 0) continue;
      const Vector3 row = from + y * M_.col(1) + z * M_.col(2);
      std::int64_t px = whole(row.x()), py = whole(row.y()), pz = whole(row.z());
      for (int x = 0; x < kSide; ++x, px += dx, py += dy, pz += dz) {
        const Cell at(static_cast<int>(px >> kBits), static_cast<int>(py >> kBits), static_cast<int>(pz >> kBits));
        const int place = ((at.z() >> 3) * overlap.size.y() + (at.y() >> 3)) * overlap.size.x() + (at.x() >> 3);
        const int i = overlap.blocks[static_cast<std::size_t>(place)];
        if (i < 0) continue;
        const int bit = (at.y() & 7) << 3 | (at.x() & 7), to = y << 3 | x;
        const auto word = static_cast<std::size_t>(at.z() & 7);
        layer_free |= (cells_->free_of(i)[word] >> bit & 1U) << to;
        if (const Bits* its = cells_->occupied_of(i); its != nullptr)
          layer_occupied |= ((*its)[word] >> bit & 1U) << to;
      }
    }
    occupied[static_cast<std::size_t>(z)] = layer_occupied;
    free[static_cast<std::size_t>(z)] = layer_free;
  }
}

/// Occupied cells of the piece whose centers lie in the block: thin structure may lie between the sampled centers.
void PlacedCells::mark_occupied(const Cell& block, const Overlap& overlap, Bits& occupied) const {
  const Vector3 first = (kSide * block).cast<double>();
  std::size_t next = 0;
  for (int z = 0; z < overlap.size.z(); ++z) {
    for (int y = 0; y < overlap.size.y(); ++y) {
      for (int x = 0; x < overlap.size.x(); ++x, ++next) {
        const Bits* its = overlap.blocks[next] >= 0 ? cells_->occupied_of(overlap.blocks[next]) : nullptr;
        if (its == nullptr) continue;
        const Vector3 corner = (kSide * (overlap.low + Cell(x, y, z))).cast<double>() - o_cells_;
        for (int layer = 0; layer < kSide; ++layer) {
          for (std::uint64_t left = (*its)[static_cast<std::size_t>(layer)]; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const Vector3 center = corner + Vector3((bit & 7) + 0.5, (bit >> 3) + 0.5, layer + 0.5);
            const Cell to = (M_back_ * center - first).array().floor().cast<int>();
            if ((to.array() < 0).any() || (to.array() >= kSide).any()) continue;
            occupied[static_cast<std::size_t>(to.z())] |= std::uint64_t{1} << (to.y() << 3 | to.x());
          }
        }
      }
    }
  }
}

/// The piece's cell at the center of the map's cell, and those whose centers lie in it.
void PlacedCells::append_deciding(const Cell& map_cell, std::vector<Cell>& cells) const {
  const Vector3 half = 0.5 * (M_.cwiseAbs() * Vector3::Ones()).array() + kRounding;
  const Vector3 middle = M_ * (map_cell.cast<double>().array() + 0.5).matrix() + o_cells_;
  cells.emplace_back(middle.array().floor().cast<int>());
  const Cell low = (middle - half).array().floor().cast<int>(), high = (middle + half).array().floor().cast<int>();
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Vector3 center(x + 0.5, y + 0.5, z + 0.5);
        const Cell to = (M_back_ * (center - o_cells_)).array().floor().cast<int>();
        if (to == map_cell) cells.emplace_back(x, y, z);
      }
    }
  }
}

}  // namespace swiftlet
