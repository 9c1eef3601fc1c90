// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/air_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "swiftlet/core/base/rounding.hpp"

namespace swiftlet {
namespace {

/// [counts] One beam in the integer counts of a voxel; its inverse is the resolution of the weight of a hit.
constexpr int kBeam = 16;
/// [voxels] Largest map, and largest number along an axis; larger sizes in the configuration are refused. A voxel takes
/// 4 bytes.
constexpr double kMaxCells = 1e9, kMaxAxis = 4096.0;

int bits_of_axis(double size_m, double edge_m) {
  const auto cells = static_cast<unsigned>(std::clamp(std::ceil(size_m / edge_m), 1.0, kMaxAxis));
  return std::bit_width(cells - 1);
}

}  // namespace

void AirMapConfig::visit(ConfigVisitor& v) {
  v.field("size_m", size_m, "[m] edges of the box around the sensor; rounded up to a power of two in voxels",
          Range::positive());
  v.check((size_m / voxel_m).maxCoeff() <= kMaxAxis, "size_m", "at most 4096 voxels along each axis");
  v.check(bytes() <= kMaxCells * 4.0, "size_m", "at most 1e9 voxels in total");
}

double AirMapConfig::bytes() const {
  double bytes = 4.0;
  for (int axis = 0; axis < 3; ++axis) bytes *= static_cast<double>(1U << bits_of_axis(size_m[axis], voxel_m));
  return bytes;
}

AirMap::AirMap(const AirMapConfig& config)
    : edge_m_(config.voxel_m),
      cells_per_m_(1.0 / config.voxel_m),
      prior_hits_(kBeam * config.prior_hits),
      prior_sum_(kBeam * (config.prior_hits + config.prior_passes)),
      prior_share_(prior_hits_ / prior_sum_),
      max_count_(kBeam * config.memory_beams) {
  std::array<int, 3> bits{}, used{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    bits[a] = bits_of_axis(config.size_m[axis], edge_m_);
    mask_[axis] = (1 << bits[a]) - 1;
    fields_[a].assign(std::size_t{1} << bits[a], 0);
  }
  const int num_bits = bits[0] + bits[1] + bits[2];
  for (int bit = 0; bit < num_bits;) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (used[a] == bits[a]) continue;
      field_mask_[a] |= std::size_t{1} << bit;
      for (std::size_t i = 0; i < fields_[a].size(); ++i) {
        fields_[a][i] |= static_cast<std::uint32_t>((i >> used[a] & 1U) << bit);
      }
      ++used[a];
      ++bit;
    }
  }
  counts_.resize(std::size_t{1} << num_bits);
}

void AirMap::follow(const Vector3& center_m) {
  const Cell min_cell = cell_of(center_m) - (mask_ + Cell::Ones()) / 2;
  if (!centered_) min_cell_ = min_cell;
  centered_ = true;
  for (int axis = 0; axis < 3; ++axis) {
    const int shift = min_cell[axis] - min_cell_[axis], size = mask_[axis] + 1;
    if (shift > 0) forget_layers(axis, min_cell_[axis], std::min(shift, size));
    if (shift < 0) forget_layers(axis, min_cell[axis], std::min(-shift, size));
  }
  min_cell_ = min_cell;
}

// Layers that enter reuse the indices of those that leave, so these are reset.
void AirMap::forget_layers(int axis, int first, int count) {
  for (int layer = first; layer < first + count; ++layer) {
    Cell low = Cell::Zero(), high = mask_;
    low[axis] = high[axis] = layer & mask_[axis];
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) counts_[index({x, y, z})] = Counts{};
      }
    }
  }
}

// Ray traversal by Amanatides and Woo 1987, clipped to the box.
void AirMap::pass(const Vector3& from_m, const Vector3& to_m) {
  const Eigen::Array3d from = from_m.array() * cells_per_m_, displacement = to_m.array() * cells_per_m_ - from;
  const Eigen::Array3d low = min_cell_.array().cast<double>(), high = low + mask_.array().cast<double>() + 1.0;
  if (!from.allFinite() || !displacement.allFinite()) return;
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    // The margin keeps rounding from stepping out of the box.
    const double low_at = low[axis] + kRounding - from[axis], high_at = high[axis] - kRounding - from[axis];
    if (displacement[axis] == 0.0) {
      if (low_at > 0.0 || high_at < 0.0) return;
      continue;
    }
    const double a = low_at / displacement[axis], b = high_at / displacement[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (!(enter < leave)) return;

  // The bits of the axes are interleaved in an index. A step along an axis adds within its bits and wraps around.
  std::size_t field[3], field_step[3];
  const std::size_t field_mask[3] = {field_mask_[0], field_mask_[1], field_mask_[2]};
  double next[3], per_cell[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::floor(from[axis] + enter * displacement[axis]);
    const bool forward = displacement[axis] > 0.0, still = displacement[axis] == 0.0;
    const std::size_t mask = field_mask[axis], one = mask & (~mask + 1);
    field[axis] =
        fields_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(static_cast<int>(cell) & mask_[axis])];
    field_step[axis] = forward ? ~mask + one : ~one + 1;  // carries or borrows pass through the bits of other axes
    per_cell[axis] = still ? std::numeric_limits<double>::infinity() : 1.0 / std::abs(displacement[axis]);
    next[axis] = still ? per_cell[axis] : ((forward ? cell + 1.0 : cell) - from[axis]) / displacement[axis];
  }
  while (true) {
    add(counts_[field[0] | field[1] | field[2]], kBeam, 0);
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    if (next[axis] >= leave) return;
    field[axis] = (field[axis] + field_step[axis]) & field_mask[axis];
    next[axis] += per_cell[axis];
  }
}

void AirMap::hit(const Vector3& p_m, double weight) {
  const Cell cell = cell_of(p_m);
  if (contains(cell)) add(counts_[index(cell)], 0, static_cast<int>(std::lround(kBeam * std::clamp(weight, 0.0, 1.0))));
}

double AirMap::share_of(const Counts& counts) const {
  return (counts.hits + prior_hits_) / (counts.hits + counts.passes + prior_sum_);
}

double AirMap::clutter_share(const Vector3& p_m) const {
  const Cell cell = cell_of(p_m);
  return contains(cell) ? share_of(counts_[index(cell)]) : prior_share_;
}

template <class Test>
bool AirMap::any_around(const Vector3& p_m, int reach_voxels, Test&& test) const {
  const Cell center = cell_of(p_m);
  for (int z = -reach_voxels; z <= reach_voxels; ++z) {
    for (int y = -reach_voxels; y <= reach_voxels; ++y) {
      for (int x = -reach_voxels; x <= reach_voxels; ++x) {
        const Cell cell = center + Cell(x, y, z);
        if (test(contains(cell) ? counts_[index(cell)] : Counts{})) return true;
      }
    }
  }
  return false;
}

bool AirMap::is_free_around(const Vector3& p_m, int reach_voxels, double share) const {
  return !any_around(p_m, reach_voxels, [&](const Counts& counts) { return share_of(counts) > share; });
}

bool AirMap::is_hit_around(const Vector3& p_m, int reach_voxels, double share) const {
  return any_around(p_m, reach_voxels,
                    [&](const Counts& counts) { return counts.hits > share * (counts.hits + counts.passes); });
}

}  // namespace swiftlet
