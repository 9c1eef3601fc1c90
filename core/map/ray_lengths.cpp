// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/ray_lengths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/map/lanes.hpp"

namespace swiftlet {
namespace {

// A ray is worked on in stretches of this many planes.
constexpr int kStretch = 96;
// Cells around the window that no ray reaches: rounding and the unused third piece of a slab stay inside.
constexpr int kMargin = 2;
// Later than the end of any ray, but finite.
constexpr float kNever = 1e30F;

/// A ray in edges, mirrored so that it climbs along every axis, from within the cell of its origin: small numbers keep
/// single precision exact. a is its steepest axis, b and c are the others.
struct Ray {
  float o_b, o_c;                             // origin in its cell, 0..1
  float d_b, d_c;                             // direction, not negative; along a the planes say it
  float inv_b, inv_c;                         // 1 / direction, at most kNever
  std::int32_t base, step_a, step_b, step_c;  // index = base + j step_a + b step_b + c step_c
};

/// Pieces of the slabs between neighbouring planes: three voxels each, of which the later ones may have length 0.
struct Pieces {
  alignas(32) std::array<float, kStretch + 8> t;  // where the planes are met, in edges from the origin
  alignas(32) std::array<float, kStretch> length_0, length_1, length_2;
  alignas(32) std::array<std::int32_t, kStretch> index_0, index_1, index_2;
  alignas(32) std::array<std::int32_t, kStretch> crosses;  // leaves its first voxel sideways
};

SWIFTLET_VECTOR_CLONES
void cut(const Ray& r, int first, int count, Pieces& out) {
  using namespace lanes;
  const Ints kCount = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int j = 0; j < count; j += kLanes) {
    const auto begin = load<Floats>(&out.t[j]), end = load<Floats>(&out.t[j + 1]);
    const Ints b = truncated(r.o_b + begin * r.d_b), c = truncated(r.o_c + begin * r.d_c);
    // Where the voxel of the slab's begin would be left sideways, if that is within the slab.
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
    store(near < end ? Ints{} + 1 : Ints{}, &out.crosses[j]);
  }
}

void accumulate(const Pieces& pieces, int count, float* __restrict lengths) {
  std::array<std::int32_t, kStretch + 1> crossing;
  int num_crossing = 0;
  for (int j = 0; j < count; ++j) {
    lengths[pieces.index_0[j]] += pieces.length_0[j];
    crossing[num_crossing] = j;
    num_crossing += pieces.crosses[j];
  }
  for (int k = 0; k < num_crossing; ++k) {
    const int j = crossing[k];
    lengths[pieces.index_1[j]] += pieces.length_1[j];
    lengths[pieces.index_2[j]] += pieces.length_2[j];
  }
}

/// Where a row's lengths begin that are not 0, and where they end. Both 0 when all are.
std::pair<int, int> used(const float* row, int count) {
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

void RayLengths::begin(const Eigen::AlignedBox3d& origins_m, double reach_m, double edge_m) {
  clear();
  origins_m_ = origins_m;
  reach_m_ = reach_m;
  window_.edge_m = edge_m;
  if (origins_m.isEmpty()) return;
  window_.min_cell = ((origins_m.min().array() - reach_m) / edge_m).floor().cast<int>() - kMargin;
  const Cell end = ((origins_m.max().array() + reach_m) / edge_m).ceil().cast<int>() + kMargin;
  window_.size = end - window_.min_cell;
  if (static_cast<std::ptrdiff_t>(lengths_.size()) < window_.num_cells()) lengths_.resize(window_.num_cells(), 0.0F);
}

void RayLengths::clear() {
  if (window_.num_cells() > 0) std::fill_n(lengths_.begin(), window_.num_cells(), 0.0F);
  window_.size.setZero();
}

void RayLengths::add(const Vector3& origin_m, const Vector3& direction, double length_m) {
  if (!(length_m > 0.0) || length_m > reach_m_ || !origins_m_.contains(origin_m) || !direction.allFinite()) return;
  int a = 0;
  direction.cwiseAbs().maxCoeff(&a);
  if (direction[a] == 0.0) return;
  const int b = (a + 1) % 3, c = (a + 2) % 3;
  const std::array<std::int32_t, 3> stride = {1, window_.size.x(), window_.size.x() * window_.size.y()};

  const Vector3 origin = origin_m / window_.edge_m - window_.min_cell.cast<double>();
  const double length = length_m / window_.edge_m;
  const Eigen::Array3d cell = origin.array().floor();
  const auto climbs = (direction.array() >= 0.0).eval();
  const Vector3 inside = climbs.select(origin.array() - cell, cell + 1.0 - origin.array());
  const Vector3 d = direction.cwiseAbs();
  const double spacing = 1.0 / d[a];
  const double first_plane = (1.0 - inside[a]) * spacing;

  Ray r;
  r.o_b = static_cast<float>(inside[b]), r.o_c = static_cast<float>(inside[c]);
  r.d_b = static_cast<float>(d[b]), r.d_c = static_cast<float>(d[c]);
  r.inv_b = r.d_b > 1.0F / kNever ? 1.0F / r.d_b : kNever, r.inv_c = r.d_c > 1.0F / kNever ? 1.0F / r.d_c : kNever;
  r.step_a = climbs[a] ? stride[a] : -stride[a];
  r.step_b = climbs[b] ? stride[b] : -stride[b];
  r.step_c = climbs[c] ? stride[c] : -stride[c];
  r.base = static_cast<std::int32_t>(window_.index(window_.min_cell + cell.cast<int>().matrix()));

  // Slab j lies between planes j - 1 and j; the first begins at the origin, the last ends at the ray's end.
  const int num_slabs = 1 + std::max(0, static_cast<int>(std::ceil((length - first_plane) / spacing)));
  const float end = static_cast<float>(length);
  Pieces pieces;
  for (int first = 0; first < num_slabs; first += kStretch) {
    const int count = std::min(kStretch, num_slabs - first);
    const float before = static_cast<float>(first_plane + (first - 1) * spacing);
    const float step = static_cast<float>(spacing);
    for (int j = 0; j <= count; ++j) {
      const float t = before + static_cast<float>(j) * step;
      pieces.t[j] = t < end ? t : end;
    }
    if (first == 0) pieces.t[0] = 0.0F;
    if (first + count == num_slabs) pieces.t[count] = end;
    for (int j = count + 1; (j - 1) % lanes::kLanes != 0; ++j) pieces.t[j] = end;  // lanes that nobody asks
    cut(r, first, count, pieces);
    accumulate(pieces, count, lengths_.data());
  }
}

void RayLengths::leave_out(std::span<const Cell> cells) {
  for (const Cell& cell : cells) {
    if (window_.contains(cell)) lengths_[window_.index(cell)] = 0.0F;
  }
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
