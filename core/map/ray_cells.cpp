// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/ray_cells.hpp"

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/map/lanes.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

using Doubles = double __attribute__((vector_size(32)));
using Longs = std::int64_t __attribute__((vector_size(32)));

/// Distance [cells] to the next wall along an axis to which the ray is perpendicular.
constexpr double kNoWall = std::numeric_limits<double>::max();
constexpr double kLibraryCells = 32768.0;  // range of the library in cells, on both sides of the origin

/// One bit per set lane of a mask.
[[gnu::always_inline]] inline unsigned bits_of_lanes(const Longs& mask) {
#if defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_pd(std::bit_cast<__m256d>(mask)));
#else
  unsigned bits = 0;
  for (unsigned lane = 0; lane < 4; ++lane) bits |= (mask[lane] != 0 ? 1U : 0U) << lane;
  return bits;
#endif
}
[[gnu::always_inline]] inline Doubles where(const Longs& mask, const Doubles& v) { return (Doubles)((Longs)v & mask); }
[[gnu::always_inline]] inline Doubles least(const Doubles& a, const Doubles& b) { return a < b ? a : b; }

}  // namespace

void RayCells::begin(const Eigen::AlignedBox3d& origins_m, double reach_m) {
  ENSURE(busy_ == 0 && ends_.empty() == end_indices_.empty(), busy_);
  end_indices_.clear();
  ends_.clear();
  passed_ = -1;
  high_ = Cell::Constant(-1);
  low_ = Cell::Constant(std::numeric_limits<int>::max());
  if (origins_m.isEmpty()) return;
  const Eigen::Array3d first = ((origins_m.min().array() - reach_m) * cells_per_m_).floor() - kMargin;
  const Eigen::Array3d last = ((origins_m.max().array() + reach_m) * cells_per_m_).floor() + kMargin;
  ENSURE(first.abs().maxCoeff() < kFarthestCell && last.abs().maxCoeff() < kFarthestCell, origins_m.min(),
         origins_m.max(), reach_m);
  first_block_ = (first / kSide).floor().cast<int>();
  const Cell last_block = (last / kSide).floor().cast<int>();
  const int across = (last_block - first_block_).maxCoeff() + 1;
  while (1 << bits_ < across) ++bits_;
  if (blocks_.size() < std::size_t{1} << 3 * bits_) blocks_.assign(std::size_t{1} << 3 * bits_, Bits{});
  const std::int64_t field = (std::int64_t{1} << bits_) - 1;
  for (int axis = 0; axis < 3; ++axis) fields_[axis] = std::int64_t{7} << 3 * axis | field << (9 + axis * bits_);
  fields_[2] = ~(fields_[0] | fields_[1]);  // the highest field also holds all bits above
}

// As OcTreeBaseImpl::computeRayKeys of the library, in its types: points and directions are single precision, the rest
// is double.
void RayCells::add(const Eigen::Vector3f& origin_m, const Eigen::Vector3f& end_m, bool ends) {
  if (!origin_m.allFinite() || !end_m.allFinite()) return;
  const Eigen::Array3d from = (origin_m.cast<double>().array() * cells_per_m_).floor();
  const Eigen::Array3d to = (end_m.cast<double>().array() * cells_per_m_).floor();
  if (!(from >= -kLibraryCells && from < kLibraryCells && to >= -kLibraryCells && to < kLibraryCells).all()) return;
  const Cell cell = from.cast<int>(), window = kSide * first_block_;
  const Cell first = cell - window, last = to.cast<int>().matrix() - window;
  const int most = (kSide << bits_) - 1;
  if (first.minCoeff() < 1 || last.minCoeff() < 1 || first.maxCoeff() >= most || last.maxCoeff() >= most) return;

  const std::int64_t end = spread(0, last.x()) | spread(1, last.y()) | spread(2, last.z());
  if (ends) end_indices_.push_back(end);
  if (first == last) return;
  low_ = low_.cwiseMin((first.cwiseMin(last).array() - 1).matrix());
  high_ = high_.cwiseMax((first.cwiseMax(last).array() + 1).matrix());

  const Eigen::Vector3f displacement = end_m - origin_m;
  const float squared =
      displacement.x() * displacement.x() + displacement.y() * displacement.y() + displacement.z() * displacement.z();
  const float length = static_cast<float>(std::sqrt(static_cast<double>(squared)));
  const auto lane = static_cast<unsigned>(std::countr_one(busy_));
  for (int axis = 0; axis < 3; ++axis) {
    const float direction = displacement[axis] / length;
    const int step = direction > 0.0F ? 1 : direction < 0.0F ? -1 : 0;
    lanes_.place[axis][lane] = spread(axis, first[axis]) | ~fields_[axis];
    lanes_.step[axis][lane] = step > 0 ? std::int64_t{1} << 3 * axis : step < 0 ? fields_[axis] : 0;
    lanes_.next[axis][lane] = lanes_.per_cell[axis][lane] = kNoWall;
    if (step == 0) continue;
    double wall = (cell[axis] + 0.5) * edge_m_;
    wall += static_cast<float>(step * edge_m_ * 0.5);
    lanes_.next[axis][lane] = (wall - static_cast<double>(origin_m[axis])) / static_cast<double>(direction);
    lanes_.per_cell[axis][lane] = edge_m_ / static_cast<double>(std::abs(direction));
  }
  lanes_.length[lane] = static_cast<double>(length);
  lanes_.end[lane] = end;
  passed_ = lanes_.place[0][lane] & lanes_.place[1][lane] & lanes_.place[2][lane];
  mark(passed_);
  busy_ |= 1U << lane;
  if (busy_ == (1U << kLanes) - 1U) busy_ &= ~follow();
}

// Parks a lane without a ray in a cell that is passed anyway.
void RayCells::idle(int lane) {
  for (int axis = 0; axis < 3; ++axis) {
    lanes_.next[axis][lane] = lanes_.per_cell[axis][lane] = 0.0;
    lanes_.step[axis][lane] = 0;
    lanes_.place[axis][lane] = passed_ | ~fields_[axis];
  }
  lanes_.length[lane] = std::numeric_limits<double>::infinity();
  lanes_.end[lane] = -1;
}

// Advances all lanes from cell to cell until at least one ray ends; returns the ended lanes as bits.
unsigned RayCells::follow() {
  using lanes::load, lanes::store;
  Doubles t0 = load<Doubles>(lanes_.next[0]), t1 = load<Doubles>(lanes_.next[1]), t2 = load<Doubles>(lanes_.next[2]);
  const Doubles d0 = load<Doubles>(lanes_.per_cell[0]), d1 = load<Doubles>(lanes_.per_cell[1]),
                d2 = load<Doubles>(lanes_.per_cell[2]), length = load<Doubles>(lanes_.length);
  Longs x = load<Longs>(lanes_.place[0]), y = load<Longs>(lanes_.place[1]), z = load<Longs>(lanes_.place[2]);
  const Longs step_x = load<Longs>(lanes_.step[0]), step_y = load<Longs>(lanes_.step[1]),
              step_z = load<Longs>(lanes_.step[2]), end = load<Longs>(lanes_.end);
  const std::int64_t others_x = ~fields_[0], others_y = ~fields_[1], others_z = ~fields_[2];
  auto* const words = reinterpret_cast<std::uint64_t*>(blocks_.data());
  unsigned done = 0;
  alignas(32) std::int64_t index[kLanes];
  do {
    // Ties are broken as in the library.
    const Longs x_before_y = t0 < t1;
    const Longs along_x = x_before_y & (t0 < t2), along_y = ~x_before_y & (t1 < t2), along_z = ~(along_x | along_y);
    t0 += where(along_x, d0);
    t1 += where(along_y, d1);
    t2 += where(along_z, d2);
    x = (x + (step_x & along_x)) | others_x;
    y = (y + (step_y & along_y)) | others_y;
    z = (z + (step_z & along_z)) | others_z;
    const Longs cell = x & y & z;
    done = bits_of_lanes((cell == end) | (least(least(t0, t1), t2) > length));
    store(cell, index);
    if (done != 0) break;
    for (const std::int64_t i : index) words[i >> 6] |= std::uint64_t{1} << (i & 63);
  } while (true);
  for (unsigned lane = 0; lane < kLanes; ++lane) {
    if ((done >> lane & 1U) == 0) mark(index[lane]);
  }
  store(t0, lanes_.next[0]), store(t1, lanes_.next[1]), store(t2, lanes_.next[2]);
  store(x, lanes_.place[0]), store(y, lanes_.place[1]), store(z, lanes_.place[2]);
  return done;
}

void RayCells::finish() {
  for (int lane = 0; lane < kLanes; ++lane) {
    if ((busy_ >> lane & 1U) == 0) idle(lane);
  }
  while (busy_ != 0) {
    const unsigned done = follow();
    busy_ &= ~done;
    for (int lane = 0; lane < kLanes; ++lane) {
      if ((done >> lane & 1U) != 0) idle(lane);
    }
  }
  // A cell in which a ray ends counts as hit only.
  auto* const words = reinterpret_cast<std::uint64_t*>(blocks_.data());
  ends_.clear();
  for (const std::int64_t i : end_indices_) {
    words[i >> 6] &= ~(std::uint64_t{1} << (i & 63));
    const auto block = i >> 9;
    const std::int64_t most = (std::int64_t{1} << bits_) - 1;
    const Cell at(static_cast<int>(block & most), static_cast<int>(block >> bits_ & most),
                  static_cast<int>(block >> 2 * bits_));
    ends_.push_back(kSide * (first_block_ + at) +
                    Cell(static_cast<int>(i & 7), static_cast<int>(i >> 3 & 7), static_cast<int>(i >> 6 & 7)));
  }
}

}  // namespace swiftlet
