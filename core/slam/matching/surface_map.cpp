// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/surface_map.hpp"

#include <algorithm>
#include <cmath>

#include "core/slam/symmetric_eigen.hpp"

namespace swiftlet {
namespace {

constexpr int kMinPoints = 6;          // fewest points of a fit
constexpr int kSettledPoints = 30;     // points from which a plane is final
constexpr double kPoleSigma_m = 0.15;  // largest sigma across a pole: half of a stem 0.5 m thick
constexpr double kPoleUpright = 0.9;   // least cosine of a pole's axis against the vertical
// [-] Least sine of the angle between a plane and a ray that meets it from behind. Larger values mix the faces of a
// wall that is seen edge-on, smaller ones divide surfaces whose normals are off.
constexpr float kBehind = 0.05F;
constexpr float kGrowth = 1.25F;  // growth of a cell's number of points that triggers a new fit
// Offset of the grid: floors and walls often lie at round coordinates, where their points would fall on both sides of a
// cell face.
constexpr double kShift_m = 0.11;
// [entries] First size of the hash table of a level, which grows as needed; a power of two.
constexpr std::size_t kFirstTable = 1U << 12;
// [bits] Width of a coordinate in the key of a cell, its mask, and the offset that makes it positive.
constexpr std::uint64_t kAxisBits = 21, kAxisMask = (1U << kAxisBits) - 1, kAxisHalf = 1U << (kAxisBits - 1);

// Bit of the key of a cell that holds the other face of a plane.
constexpr std::uint64_t kOtherFace = 1ULL << 3 * kAxisBits;

std::uint64_t slot_of(std::uint64_t key, std::size_t table_size) {  // Fibonacci hashing
  return (key * 0x9E3779B97F4A7C15ULL >> 20U) & (table_size - 1);
}

Vector3 corner_of(std::uint64_t key, double edge_m) {
  const auto axis = [&](std::uint64_t bits) {
    return (static_cast<double>(bits & kAxisMask) - static_cast<double>(kAxisHalf)) * edge_m - kShift_m;
  };
  return {axis(key), axis(key >> kAxisBits), axis(key >> 2 * kAxisBits)};
}

}  // namespace

std::uint64_t SurfaceMap::Level::key_of(const Vector3& p_m) const {
  const auto axis = [&](double x) {
    return (static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor((x + kShift_m) / edge_m))) + kAxisHalf) &
           kAxisMask;
  };
  return axis(p_m.x()) | axis(p_m.y()) << kAxisBits | axis(p_m.z()) << 2 * kAxisBits;
}

SurfaceCell* SurfaceMap::Level::find(std::uint64_t key) {
  for (std::size_t slot = slot_of(key, table.size());; slot = (slot + 1) & (table.size() - 1)) {
    if (table[slot] == 0) return nullptr;
    if (keys[table[slot] - 1] == key) return &cells[table[slot] - 1];
  }
}

std::uint64_t SurfaceMap::Level::face_of(std::uint64_t key, const Vector3& origin_m) const {
  const SurfaceCell* cell = find(key);
  if (cell == nullptr || !cell->planar) return key;
  const Eigen::Vector3f ray_m = cell->mean_m - origin_m.cast<float>();
  return cell->normal.dot(ray_m) > kBehind * ray_m.norm() ? key | kOtherFace : key;
}

std::uint32_t SurfaceMap::Level::find_or_make(std::uint64_t key) {
  std::size_t slot = slot_of(key, table.size());
  for (; table[slot] != 0; slot = (slot + 1) & (table.size() - 1)) {
    if (keys[table[slot] - 1] == key) return table[slot] - 1;
  }
  keys.push_back(key);
  cells.emplace_back();
  table[slot] = static_cast<std::uint32_t>(cells.size());
  if (2 * cells.size() > table.size()) rebuild(2 * table.size());
  return static_cast<std::uint32_t>(cells.size() - 1);
}

void SurfaceMap::Level::rebuild(std::size_t table_size) {
  table.assign(table_size, 0);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::size_t slot = slot_of(keys[i], table_size);
    while (table[slot] != 0) slot = (slot + 1) & (table_size - 1);
    table[slot] = static_cast<std::uint32_t>(i + 1);
  }
}

SurfaceMap::SurfaceMap(const SurfaceMapConfig& config) : config_(config), levels_(config.levels) {
  double edge_m = config.cell_m;
  for (Level& level : levels_) {
    level.edge_m = edge_m;
    level.table.assign(kFirstTable, 0);
    edge_m *= 0.5;
  }
}

void SurfaceMap::insert(std::span<const Vector3> points_m, const Vector3& origin_m) {
  touched_.clear();
  for (const Vector3& p_m : points_m) {
    // Distant surfaces are seen by few beams and need no small cells.
    const double least_edge_m = config_.fineness * (p_m - origin_m).norm();
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      Level& level = levels_[l];
      const std::uint64_t key = key_in(level, p_m, origin_m);
      const std::uint32_t index = level.find_or_make(key);
      SurfaceCell& cell = level.cells[index];
      if (cell.count < static_cast<float>(config_.points_per_cell)) {
        add(level, key, cell, p_m);
        if (cell.count >= kMinPoints && cell.count >= kGrowth * cell.count_fitted) {
          // Marks the cell as due once, until it is fitted.
          cell.count_fitted = static_cast<float>(config_.points_per_cell);
          touched_.push_back({static_cast<std::uint32_t>(l), index});
        }
      }
      // A cell that is a final plane, or has too few points for a fit, needs no finer level.
      if (cell.settled || cell.count < kMinPoints || 0.5 * level.edge_m < least_edge_m) break;
    }
  }
  for (const Touched& t : touched_) {
    Level& level = levels_[t.level];
    fit(level, level.keys[t.cell], level.cells[t.cell], origin_m);
  }
}

void SurfaceMap::add(Level& level, std::uint64_t key, SurfaceCell& cell, const Vector3& p_m) const {
  const Eigen::Vector3f d = (p_m - corner_of(key, level.edge_m)).cast<float>();
  cell.count += 1.0F;
  cell.sum_m += d;
  cell.sum_xx += d.x() * d.x();
  cell.sum_xy += d.x() * d.y();
  cell.sum_xz += d.x() * d.z();
  cell.sum_yy += d.y() * d.y();
  cell.sum_yz += d.y() * d.z();
  cell.sum_zz += d.z() * d.z();
}

void SurfaceMap::fit(const Level& level, std::uint64_t key, SurfaceCell& cell, const Vector3& origin_m) const {
  cell.count_fitted = cell.count;
  const double n = cell.count;
  const Vector3 mean = cell.sum_m.cast<double>() / n;
  Matrix3 C;
  C << cell.sum_xx, cell.sum_xy, cell.sum_xz, cell.sum_xy, cell.sum_yy, cell.sum_yz, cell.sum_xz, cell.sum_yz,
      cell.sum_zz;
  C = (C / n - mean * mean.transpose()) * (n / (n - 1.0));
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(C);
  cell.mean_m = (corner_of(key, level.edge_m) + mean).cast<float>();
  cell.normal = eigen.vectors.col(0).cast<float>();
  if (cell.normal.dot(origin_m.cast<float>() - cell.mean_m) < 0.0F) cell.normal = -cell.normal;
  // The plane uses three degrees of freedom: six points leave hardly any scatter.
  cell.variance_m2 = static_cast<float>(std::max(eigen.values(0), 0.0) * (n - 1.0) / (n - 3.0));
  cell.narrow_variance_m2 = static_cast<float>(std::max(eigen.values(1), 0.0));
  cell.wide_variance_m2 = static_cast<float>(std::max(eigen.values(2), 0.0));
  // A plane is thin, and wide in two directions: at least a tenth of the cell, as of points that fill a third of its
  // width.
  const double narrow_m2 = std::max(0.01 * level.edge_m * level.edge_m, 9.0 * eigen.values(0));
  cell.planar = eigen.values(0) < config_.plane_sigma_m * config_.plane_sigma_m && eigen.values(1) > narrow_m2;
  // A pole is at least three times as long as thick, as of points that fill half of the cell's height.
  const double long_m2 = std::max(0.02 * level.edge_m * level.edge_m, 9.0 * eigen.values(1));
  cell.axis = eigen.vectors.col(2).cast<float>();
  cell.pole = !cell.planar && eigen.values(1) < kPoleSigma_m * kPoleSigma_m && eigen.values(2) > long_m2 &&
              std::abs(eigen.vectors(2, 2)) > kPoleUpright;
  cell.settled = cell.planar && cell.count >= kSettledPoints;
}

const SurfaceCell* SurfaceMap::find(const Vector3& p_m, const Vector3& origin_m) const {
  const SurfaceCell* best = nullptr;
  for (const Level& level : levels_) {
    const SurfaceCell* cell = level.find(key_in(level, p_m, origin_m));
    if (cell == nullptr) break;
    if (cell->count_fitted < kMinPoints) break;
    best = cell;
    if (cell->planar) break;
  }
  return best;
}

const SurfaceCell* SurfaceMap::find_pole(const Vector3& p_m) const {
  for (const Level& level : levels_) {
    const SurfaceCell* cell = level.find(level.key_of(p_m));
    if (cell == nullptr || cell->count_fitted < kMinPoints) break;
    if (cell->pole) return cell;
  }
  return nullptr;
}

void SurfaceMap::keep_around(const Vector3& center_m) {
  for (Level& level : levels_) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < level.keys.size(); ++i) {
      const Vector3 middle_m = corner_of(level.keys[i], level.edge_m) + Vector3::Constant(0.5 * level.edge_m);
      if ((middle_m - center_m).squaredNorm() > config_.keep_radius_m * config_.keep_radius_m) continue;
      level.keys[kept] = level.keys[i];
      level.cells[kept] = level.cells[i];
      ++kept;
    }
    if (kept == level.keys.size()) continue;
    level.keys.resize(kept);
    level.cells.resize(kept);
    level.rebuild(level.table.size());
  }
}

void SurfaceMap::clear() {
  for (Level& level : levels_) {
    level.keys.clear();
    level.cells.clear();
    level.table.assign(level.table.size(), 0);
  }
}

std::size_t SurfaceMap::num_cells() const {
  std::size_t num = 0;
  for (const Level& level : levels_) num += level.cells.size();
  return num;
}

std::size_t SurfaceMap::bytes() const {
  std::size_t bytes = 0;
  for (const Level& level : levels_) {
    bytes += level.cells.capacity() * (sizeof(SurfaceCell) + sizeof(std::uint64_t)) +
             level.table.capacity() * sizeof(std::uint32_t);
  }
  return bytes;
}

void SurfaceMapConfig::visit(ConfigVisitor& v) {
  v.field("cell_m", cell_m, "[m] edge of the largest cells", Range::between(0.1, 10.0));
  v.field("levels", levels, "[-] number of cell sizes, each half of the next larger one", Range::between(1, 6));
  v.field("keep_radius_m", keep_radius_m, "[m] distance from the vehicle above which cells are dropped",
          Range::between(5.0, 2000.0));
}

}  // namespace swiftlet
