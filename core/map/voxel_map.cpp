// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/voxel_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/map/lanes.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// [-] largest number of voxels of a map.
constexpr double kMaxCells = 4e9;
/// [voxels] distance of the vehicle from the center at which a scrolling map moves. Smaller values copy the map more
/// often.
constexpr int kScrollStep = 16;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// G after n updates towards g. The difference form keeps the fixed point g and the limit n = infinity exact.
float updated(float G, float weight, float g) { return g + weight * (G - g); }

/// 2^-n for n in [0, 126], relative error below 2e-7.
[[gnu::always_inline]] inline lanes::Floats half_to_the(const lanes::Floats& n) {
  const lanes::Ints whole = lanes::truncated(n);
  const lanes::Floats x = -0.69314718F * (n - lanes::to_float(whole));  // (-ln 2, 0]
  lanes::Floats e = 1.0F / 5040.0F + lanes::Floats{};                   // Taylor's series of exp
  e = e * x + 1.0F / 720.0F;
  e = e * x + 1.0F / 120.0F;
  e = e * x + 1.0F / 24.0F;
  e = e * x + 1.0F / 6.0F;
  e = e * x + 0.5F;
  e = e * x + 1.0F;
  e = e * x + 1.0F;
  return e * std::bit_cast<lanes::Floats>((127 - whole) << 23);
}

/// update() for eight voxels: infinite values stay, because the weight never becomes 0.
[[gnu::always_inline]] inline lanes::Floats moved(const lanes::Floats& values, const lanes::Floats& n, float g) {
  const lanes::Floats weight = half_to_the(lanes::min(n, 126.0F + lanes::Floats{}));
  return n > 0.0F ? g + weight * (values - g) : values;
}

SWIFTLET_VECTOR_CLONES
void move_row(const float* n, std::size_t size, float g, float* values) {
  using lanes::kLanes, lanes::Floats;
  std::size_t i = 0;
  for (; i + kLanes <= size; i += kLanes) {
    lanes::store(moved(lanes::load<Floats>(values + i), lanes::load<Floats>(n + i), g), values + i);
  }
  if (i == size) return;
  Floats last_n{}, last_values{};
  std::memcpy(&last_n, n + i, (size - i) * sizeof(float));
  std::memcpy(&last_values, values + i, (size - i) * sizeof(float));
  last_values = moved(last_values, last_n, g);
  std::memcpy(values + i, &last_values, (size - i) * sizeof(float));
}

}  // namespace

void VoxelMapConfig::visit(ConfigVisitor& v) {
  v.field("voxel_m", voxel_m, "[m] edge of a voxel, s_v", Range::between(0.01, 100.0));
  v.field("g_occupied", g_occupied, "[-] update coefficient of points of the background");
  v.field("g_unknown", g_unknown, "[-] update coefficient of unknown points and of detections; value at the start");
  v.field("g_free", g_free, "[-] update coefficient of rays and of separate background");
  v.field("G_confident", G_confident, "[-] value from which a voxel is confident occupied");
  v.field("G_tentative", G_tentative, "[-] value from which a voxel is tentative occupied");
  v.field("G_uncertain", G_uncertain, "[-] value from which a voxel is uncertain; below, confident free");
  v.choice("extent", extent, {"scrolling", "bounded"},
           "a box that follows the vehicle, or one that stays (operation area)");
  v.field("center_m", center_m, "[m] center of a bounded map's box", Range::between(-1e5, 1e5));
  v.field("size_m", size_m, "[m] edges of the box", Range{0.0, 1e5, true});
  v.check(G_confident > G_tentative && G_tentative > G_uncertain, "G_tentative",
          "thresholds that fall from G_confident over G_tentative to G_uncertain");
  v.check(g_occupied >= G_confident && g_unknown >= G_uncertain && g_unknown < G_tentative && g_free < G_uncertain,
          "g_unknown", "g_occupied confident, g_unknown uncertain and g_free free by the thresholds");
  v.check(size_m.prod() / elementary::pow(voxel_m, 3) <= kMaxCells, "size_m", "a box of at most 4e9 voxels");
}

VoxelMap::VoxelMap(const VoxelMapConfig& config)
    : config_(config),
      grid_(VoxelGrid::covering(config.center_m, config.size_m, config.voxel_m)),
      g_unknown_(static_cast<float>(config.g_unknown)),
      G_confident_(static_cast<float>(config.G_confident)),
      G_tentative_(static_cast<float>(config.G_tentative)),
      G_uncertain_(static_cast<float>(config.G_uncertain)),
      words_per_row_((grid_.size.x() + 63) / 64),
      values_(grid_.num_cells(), g_unknown_),
      bits_(static_cast<std::size_t>(num_rows()) * words_per_row_, 0) {}

VoxelState VoxelMap::state_at(const Vector3& p_m) const {
  return grid_.contains(p_m) ? state(grid_.index(grid_.cell_of(p_m))) : VoxelState::kUncertain;
}

void VoxelMap::update(std::ptrdiff_t index, double n, double g) {
  ENSURE(index >= 0 && index < grid_.num_cells(), index, grid_.num_cells());
  const float before = values_[index];
  if (!std::isfinite(before)) return;
  const double weight = n == 1.0 ? 0.5 : elementary::exp2(-n);  // updates by single points are the most frequent
  set(index, updated(before, static_cast<float>(weight), static_cast<float>(g)));
}

void VoxelMap::set(std::ptrdiff_t index, float value) {
  const bool was = occupied(index);
  values_[index] = value;
  if (occupied(index) != was) set_bit(index, !was);
}

void VoxelMap::set_bit(std::ptrdiff_t index, bool occupied) {
  const std::ptrdiff_t row = index / grid_.size.x();
  const int x = static_cast<int>(index - row * grid_.size.x());
  std::uint64_t& word = bits_[row * words_per_row_ + x / 64];
  const std::uint64_t bit = std::uint64_t{1} << (x % 64);
  word = occupied ? word | bit : word & ~bit;
}

void VoxelMap::move_to_free(const Cell& first, std::span<const float> n) {
  ENSURE(grid_.contains(first) && first.x() + static_cast<int>(n.size()) <= grid_.min_cell.x() + grid_.size.x(), first,
         n.size(), grid_.min_cell, grid_.size);
  const std::ptrdiff_t index = grid_.index(first);
  move_row(n.data(), n.size(), static_cast<float>(config_.g_free), values_.data() + index);
  // Updates towards free only clear bits.
  const std::ptrdiff_t row = index / grid_.size.x();
  const int x = static_cast<int>(index - row * grid_.size.x());
  for (int w = x / 64; w <= (x + static_cast<int>(n.size()) - 1) / 64; ++w) {
    if (bits_[row * words_per_row_ + w] != 0) bits_[row * words_per_row_ + w] = bits_of(row, w);
  }
}

std::uint64_t VoxelMap::bits_of(std::ptrdiff_t row, int word) const {
  const float* values = values_.data() + row * grid_.size.x() + 64 * word;
  const int count = std::min(64, grid_.size.x() - 64 * word);
  std::uint64_t bits = 0;
  for (int i = 0; i < count; ++i) bits |= static_cast<std::uint64_t>(values[i] >= G_tentative_) << i;
  return bits;
}

void VoxelMap::set_prior(const PriorMap& prior) {
  const auto to_cells = [&](const std::vector<Eigen::Vector3f>& points, std::vector<Cell>& cells) {
    cells.clear();
    for (const Eigen::Vector3f& p : points) {
      const Eigen::Array3d at = p.cast<double>().array() / grid_.edge_m;
      if (p.allFinite()) cells.push_back(at.floor().max(-kFarthestCell).min(kFarthestCell).cast<int>());
    }
    const auto before = [](const Cell& a, const Cell& b) {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    };
    std::sort(cells.begin(), cells.end(), before);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  };
  to_cells(prior.free_world_m, prior_free_);
  to_cells(prior.occupied_world_m, prior_occupied_);
  num_prior_outside_ = num_prior();
  stamp_prior();
}

void VoxelMap::stamp_prior() {
  std::size_t num_within = 0;
  const auto stamp = [&](const std::vector<Cell>& cells, float value) {
    for (const Cell& cell : cells) {
      if (!grid_.contains(cell)) continue;
      set(grid_.index(cell), value);
      ++num_within;
    }
  };
  stamp(prior_free_, -kInfinity);
  stamp(prior_occupied_, kInfinity);
  if (config_.extent == VoxelMapConfig::Extent::kBounded) {
    num_prior_outside_ = num_prior() - num_within;
  } else if (num_within > 0) {
    num_prior_outside_ = 0;
  }
}

void VoxelMap::clear() {
  std::fill(values_.begin(), values_.end(), g_unknown_);
  std::fill(bits_.begin(), bits_.end(), 0);
  stamp_prior();
}

void VoxelMap::follow(const Vector3& p_m) {
  if (config_.extent != VoxelMapConfig::Extent::kScrolling) return;
  if (!((p_m.array() / grid_.edge_m).abs() < kFarthestCell).all()) return;
  const Cell wanted = grid_.cell_of(p_m) - grid_.size / 2;
  const Cell shift = wanted - grid_.min_cell;
  if (shift.cwiseAbs().maxCoeff() < kScrollStep) return;
  grid_.min_cell = wanted;
  if ((shift.cwiseAbs().array() >= grid_.size.array()).any()) {
    clear();
    return;
  }

  // Remaining voxels move by -shift; the order of rows avoids overwriting those not yet moved.
  const Cell n = grid_.size;
  const int keep = n.x() - std::abs(shift.x());
  const int from = std::max(shift.x(), 0), to = std::max(-shift.x(), 0);
  for (int k = 0; k < n.z(); ++k) {
    const int z = shift.z() >= 0 ? k : n.z() - 1 - k;
    for (int j = 0; j < n.y(); ++j) {
      const int y = shift.y() >= 0 ? j : n.y() - 1 - j;
      float* row = values_.data() + (static_cast<std::ptrdiff_t>(z) * n.y() + y) * n.x();
      const int z_from = z + shift.z(), y_from = y + shift.y();
      if (z_from < 0 || z_from >= n.z() || y_from < 0 || y_from >= n.y()) {
        std::fill(row, row + n.x(), g_unknown_);
        continue;
      }
      const float* source = values_.data() + (static_cast<std::ptrdiff_t>(z_from) * n.y() + y_from) * n.x();
      std::memmove(row + to, source + from, keep * sizeof(float));
      std::fill(row, row + to, g_unknown_);
      std::fill(row + to + keep, row + n.x(), g_unknown_);
    }
  }
  rebuild_bits();
  stamp_prior();
}

void VoxelMap::rebuild_bits() {
  for (std::ptrdiff_t row = 0; row < num_rows(); ++row) {
    for (int w = 0; w < words_per_row_; ++w) bits_[row * words_per_row_ + w] = bits_of(row, w);
  }
}

std::ptrdiff_t VoxelMap::num_occupied() const {
  std::ptrdiff_t count = 0;
  for (const std::uint64_t word : bits_) count += __builtin_popcountll(word);
  return count;
}

void VoxelMap::append_centers(VoxelState at_least, std::vector<Vector3>& centers) const {
  if (at_least >= VoxelState::kTentative) {
    for_each_occupied([&](std::ptrdiff_t i) {
      if (state(i) >= at_least) centers.push_back(grid_.center_m(grid_.cell(i)));
    });
    return;
  }
  for (std::ptrdiff_t i = 0; i < grid_.num_cells(); ++i) {
    if (state(i) >= at_least) centers.push_back(grid_.center_m(grid_.cell(i)));
  }
}

void VoxelMap::append_voxels(MapVoxels& copy) const {
  copy.edge_m = grid_.edge_m;
  copy.states = {"free", "uncertain", "tentative", "confident"};
  copy.occupied_from = static_cast<std::uint8_t>(VoxelState::kTentative);
  for (std::ptrdiff_t i = 0; i < grid_.num_cells(); ++i) {
    if (values_[i] == g_unknown_) continue;
    copy.add(grid_.center_m(grid_.cell(i)), static_cast<std::uint8_t>(state(i)), values_[i]);
  }
}

template <class Visit>
bool VoxelMap::visit_row(std::ptrdiff_t row, int x_first, int x_last, Visit&& visit) const {
  const std::uint64_t* words = row_bits(row);
  for (int w = x_first / 64; w <= x_last / 64; ++w) {
    std::uint64_t bits = words[w];
    if (w == x_first / 64) bits &= ~std::uint64_t{0} << (x_first % 64);
    if (w == x_last / 64) bits &= ~std::uint64_t{0} >> (63 - x_last % 64);
    for (; bits != 0; bits &= bits - 1) {
      if (!visit(64 * w + __builtin_ctzll(bits))) return false;
    }
  }
  return true;
}

// Calls visit(x, y, z) for occupied cells, counted from the corner of the box, whose centers may lie within the radius,
// while it returns true. For a point that is not finite there are none.
template <class Visit>
void VoxelMap::visit_box(const Vector3& p_m, double radius_m, Visit&& visit) const {
  const Eigen::Array3d at = p_m.array() / grid_.edge_m - grid_.min_cell.array().cast<double>() - 0.5;
  const Eigen::Array3d first = (at - radius_m / grid_.edge_m).ceil().max(0.0);
  const Eigen::Array3d last = (at + radius_m / grid_.edge_m).floor().min((grid_.size.array() - 1).cast<double>());
  if (!(first <= last).all()) return;
  const Cell from = first.cast<int>(), to = last.cast<int>();
  for (int z = from.z(); z <= to.z(); ++z) {
    for (int y = from.y(); y <= to.y(); ++y) {
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(z) * grid_.size.y() + y;
      if (!visit_row(row, from.x(), to.x(), [&](int x) { return visit(x, y, z); })) return;
    }
  }
}

bool VoxelMap::any_within(const Vector3& p_m, double radius_m, VoxelState at_least) const {
  const double radius_sq = radius_m * radius_m;
  const auto counts = [&](const Cell& cell) {
    return (grid_.center_m(cell) - p_m).squaredNorm() <= radius_sq && state(grid_.index(cell)) >= at_least;
  };
  // Background points mostly lie in an occupied voxel.
  const std::ptrdiff_t own = grid_.index_of(p_m);
  if (own >= 0 && state(own) >= at_least && (grid_.center_m(grid_.cell_of(p_m)) - p_m).squaredNorm() <= radius_sq)
    return true;
  bool found = false;
  visit_box(p_m, radius_m, [&](int x, int y, int z) {
    found = counts(grid_.min_cell + Cell(x, y, z));
    return !found;
  });
  return found;
}

}  // namespace swiftlet
