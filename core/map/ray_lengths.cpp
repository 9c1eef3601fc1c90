// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/ray_lengths.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/map/lanes.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

// [planes] Length of a stretch, the part of a ray that is processed at once. Affects time alone.
constexpr int kStretch = 96;
// [cells] Margin around the window that no ray reaches. It absorbs rounding and the unused third piece of a slab.
constexpr int kMargin = 2;
// [-] Finite bound of the inverse of a direction, beyond the end of any ray.
constexpr float kNever = 1e30F;

/// A ray in units of the edge, relative to the cell of its origin and mirrored so that it ascends along every axis:
/// small numbers keep single precision exact. a is its steepest axis, b and c are the others.
struct Ray {
  float o_b, o_c;                             // origin in its cell, 0..1
  float d_b, d_c;                             // direction, not negative; along a it follows from the planes
  float inv_b, inv_c;                         // 1 / direction, at most kNever
  std::int32_t base, step_a, step_b, step_c;  // index = base + j step_a + b step_b + c step_c
};

/// Pieces of the slabs between neighboring planes: three voxels each, the later ones possibly of length 0.
struct Pieces {
  alignas(32) std::array<float, kStretch> length_0, length_1, length_2;
  alignas(32) std::array<std::int32_t, kStretch> index_0, index_1, index_2;
  // a bit for each piece that leaves its first voxel sideways
  std::array<std::uint64_t, (kStretch + 63) / 64> crosses{};
};

/// Planes of a ray: the j-th is met at before + j * step, clamped to [0, end] [edges from the origin].
struct Planes {
  float before, step, end;
};

SWIFTLET_VECTOR_CLONES
void cut(const Ray& r, const Planes& planes, int first, int count, Pieces& out) {
  using namespace lanes;
  const Ints kCount = {0, 1, 2, 3, 4, 5, 6, 7}, kBits = {1, 2, 4, 8, 16, 32, 64, 128};
  const auto met = [&](const Ints& j) __attribute__((always_inline)) {
    return max(min(planes.before + to_float(j) * planes.step, planes.end + Floats{}), Floats{});
  };
  for (int j = 0; j < count; j += kLanes) {
    const Floats begin = met(j + kCount), end = met(j + 1 + kCount);
    const Ints b = truncated(r.o_b + begin * r.d_b), c = truncated(r.o_c + begin * r.d_c);
    // Where the ray would leave the first voxel of the slab sideways, if within the slab.
    const Floats t_b = min(max((to_float(b + 1) - r.o_b) * r.inv_b, begin), end);
    const Floats t_c = min(max((to_float(c + 1) - r.o_c) * r.inv_c, begin), end);
    const Floats near = min(t_b, t_c), far = max(t_b, t_c);
    const Ints index = r.base + (first + j + kCount) * r.step_a + b * r.step_b + c * r.step_c;
    store(near - begin, &out.length_0[j]);
    store(far - near, &out.length_1[j]);
    store(end - far, &out.length_2[j]);
    store(index, &out.index_0[j]);
    store(index + (t_b < t_c ? r.step_b + Ints{} : r.step_c + Ints{}), &out.index_1[j]);
    store(index + (r.step_b + r.step_c), &out.index_2[j]);
    out.crosses[j / 64] |= union_of((near < end) & kBits) << (j % 64);
  }
}

void accumulate(const Pieces& pieces, int count, float* __restrict lengths) {
#pragma GCC unroll 4
  for (int j = 0; j < count; ++j) lengths[pieces.index_0[j]] += pieces.length_0[j];
  for (int word = 0; 64 * word < count; ++word) {
    const int slabs = std::min(count - 64 * word, 64);
    for (std::uint64_t bits = pieces.crosses[word] & (~std::uint64_t{0} >> (64 - slabs)); bits != 0; bits &= bits - 1) {
      const int j = 64 * word + std::countr_zero(bits);
      lengths[pieces.index_1[j]] += pieces.length_1[j];
      lengths[pieces.index_2[j]] += pieces.length_2[j];
    }
  }
}

/// Range of a row's nonzero lengths; both 0 when all are zero.
std::pair<int, int> used(const float* row, int count) {
  // Lengths that are tested at once for zeros.
  constexpr int kBlock = 8;
  const auto empty = [row](int from) {
    std::array<std::uint64_t, kBlock / 2> bits;  // lengths are 0 or more
    std::memcpy(bits.data(), row + from, sizeof bits);
    return (bits[0] | bits[1] | bits[2] | bits[3]) == 0;
  };
  int begin = 0, end = count;
  while (begin + kBlock <= end && empty(begin)) begin += kBlock;
  while (begin < end && row[begin] == 0.0F) ++begin;
  if (begin == end) return {0, 0};
  while (end - kBlock >= begin && empty(end - kBlock)) end -= kBlock;
  while (row[end - 1] == 0.0F) --end;
  return {begin, end};
}

}  // namespace

void RayLengths::begin(const Eigen::AlignedBox3d& origins_m, double reach_m, double edge_m, const VoxelGrid* within) {
  clear();
  origins_m_ = origins_m;
  reach_m_ = reach_m;
  window_.edge_m = edge_m;
  if (origins_m.isEmpty()) return;
  Eigen::Array3d first = ((origins_m.min().array() - reach_m) / edge_m).floor();
  Eigen::Array3d end = ((origins_m.max().array() + reach_m) / edge_m).ceil();
  cut_ = false;
  if (within != nullptr) {  // the window always includes the origins
    const Eigen::Array3d least =
        (origins_m.min().array() / edge_m).floor().min(within->min_cell.array().cast<double>());
    const Eigen::Array3d most =
        (origins_m.max().array() / edge_m).ceil().max((within->min_cell + within->size).array().cast<double>());
    cut_ = (first < least).any() || (end > most).any();
    first = first.max(least);
    end = end.min(most);
  }
  // Voxels of the window have 32-bit indices.
  const double cells = (end - first + 2.0 * kMargin).prod();
  ENSURE(cells < static_cast<double>(std::numeric_limits<std::int32_t>::max()), cells, origins_m.sizes(), reach_m,
         edge_m);
  window_.min_cell = first.cast<int>() - kMargin;
  window_.size = (end.cast<int>() + kMargin).matrix() - window_.min_cell;
  edges_per_m_ = 1.0 / edge_m;
  first_cell_ = window_.min_cell.cast<double>();
  if (static_cast<std::ptrdiff_t>(lengths_.size()) < window_.num_cells()) lengths_.resize(window_.num_cells(), 0.0F);
}

void RayLengths::clear() {
  if (window_.num_cells() > 0) std::fill_n(lengths_.begin(), window_.num_cells(), 0.0F);
  window_.size.setZero();
}

void RayLengths::add(const Vector3& origin_m, const Vector3& direction, double length_m) {
  if (!(length_m > 0.0) || length_m > reach_m_ || !origins_m_.contains(origin_m)) return;
  const Vector3 d = direction.cwiseAbs();
  const int a = d.x() >= d.y() ? (d.x() >= d.z() ? 0 : 2) : (d.y() >= d.z() ? 1 : 2);
  if (!(d[a] > 0.0 && std::isfinite(d.sum()))) return;
  const int b = a == 2 ? 0 : a + 1, c = b == 2 ? 0 : b + 1;
  const std::array<std::int32_t, 3> stride = {1, window_.size.x(), window_.size.x() * window_.size.y()};

  // The window begins before every origin, so coordinates are positive and truncation rounds down.
  const Vector3 origin = edges_per_m_ * origin_m - first_cell_;
  const double length = length_m * edges_per_m_;
  std::array<double, 3> inside;
  std::array<std::int32_t, 3> step;
  std::int32_t base = 0;
  for (int k = 0; k < 3; ++k) {
    const std::int32_t cell = static_cast<std::int32_t>(origin[k]);
    const double low = origin[k] - cell;
    const bool climbs = direction[k] >= 0.0;
    inside[k] = climbs ? low : 1.0 - low;
    step[k] = climbs ? stride[k] : -stride[k];
    base += cell * stride[k];
  }
  const double spacing = 1.0 / d[a];
  const double first_plane = (1.0 - inside[a]) * spacing;

  Ray r;
  r.o_b = static_cast<float>(inside[b]), r.o_c = static_cast<float>(inside[c]);
  r.d_b = static_cast<float>(d[b]), r.d_c = static_cast<float>(d[c]);
  r.inv_b = r.d_b > 1.0F / kNever ? 1.0F / r.d_b : kNever, r.inv_c = r.d_c > 1.0F / kNever ? 1.0F / r.d_c : kNever;
  r.step_a = step[a], r.step_b = step[b], r.step_c = step[c];
  r.base = base;

  // Slab j lies between planes j - 1 and j; the first begins at the origin, the last ends at the ray's end. The length
  // is slightly extended, so that rounding never drops the last piece.
  int num_slabs = 1 + std::max(0, static_cast<int>((length - first_plane) * d[a] + 1.0001));
  if (cut_) {  // up to the slab in which the ray leaves; the margin covers the rest of that slab
    const double exit = exit_edges(origin, direction);
    if (exit < length)
      num_slabs = std::min(num_slabs, 1 + std::max(0, static_cast<int>((exit - first_plane) * d[a] + 1.0)));
  }
  for (int first = 0; first < num_slabs; first += kStretch) {
    const int count = std::min(kStretch, num_slabs - first);
    const Planes planes{static_cast<float>(first_plane + (first - 1) * spacing), static_cast<float>(spacing),
                        static_cast<float>(length)};
    Pieces pieces;
    cut(r, planes, first, count, pieces);
    accumulate(pieces, count, lengths_.data());
  }
}

// Distance from an origin in the window to where the ray leaves it, in edges.
double RayLengths::exit_edges(const Vector3& origin, const Vector3& direction) const {
  double exit = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double room = direction[k] >= 0.0 ? window_.size[k] - kMargin - origin[k] : origin[k] - kMargin;
    if (direction[k] != 0.0) exit = std::min(exit, room / std::abs(direction[k]));
  }
  return exit;
}

double RayLengths::length_m(const Cell& cell) const {
  return window_.contains(cell) ? window_.edge_m * lengths_[window_.index(cell)] : 0.0;
}

std::vector<Cell> RayLengths::cells() const {
  std::vector<Cell> out;
  for (std::ptrdiff_t i = 0; i < window_.num_cells(); ++i) {
    if (lengths_[i] > 0.0F) out.push_back(window_.cell(i));
  }
  return out;
}

void RayLengths::apply(double updates_per_edge, VoxelMap& map) {
  const VoxelGrid& grid = map.grid();
  const int first_x = std::max(grid.min_cell.x() - window_.min_cell.x(), 0);
  const int end_x = std::min(grid.min_cell.x() + grid.size.x() - window_.min_cell.x(), window_.size.x());
  const float factor = static_cast<float>(updates_per_edge);
  weights_.resize(std::max(window_.size.x(), 0));
  float* lengths = lengths_.data();
  for (int z = 0; z < window_.size.z(); ++z) {
    for (int y = 0; y < window_.size.y(); ++y, lengths += window_.size.x()) {
      const auto [begin, end] = used(lengths, window_.size.x());
      const int from = std::max(begin, first_x), to = std::min(end, end_x);
      const Cell cell = window_.min_cell + Cell(from, y, z);
      if (from < to && grid.contains(cell)) {
        for (int x = from; x < to; ++x) weights_[x - from] = factor * lengths[x];
        map.move_to_free(cell, {weights_.data(), static_cast<std::size_t>(to - from)});
      }
      std::fill(lengths + begin, lengths + end, 0.0F);
    }
  }
  window_.size.setZero();
}

}  // namespace swiftlet
