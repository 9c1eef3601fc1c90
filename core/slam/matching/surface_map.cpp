// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/surface_map.hpp"

#include <algorithm>
#include <cmath>

#include "core/slam/symmetric_eigen.hpp"

namespace swiftlet {
namespace {

// [-] Fewest points of a fit. Smaller values fit noise.
constexpr int kMinPoints = 6;
// [-] Points from which a plane is final. Larger values fill smaller cells in planes, which costs time and memory.
constexpr int kSettledPoints = 30;
// [-] Least cosine of a pole's axis against the vertical. Smaller values count leaning structure, such as logs.
constexpr double kPoleUpright = 0.9;
// [-] Least sine of the angle between a plane and a ray that meets it from behind. Larger values mix the faces of a
// wall that is seen edge-on, smaller ones divide surfaces whose normals are off.
constexpr float kBehind = 0.05F;
// [-] Growth of a cell's number of points that triggers a new fit. Smaller values cost time.
constexpr float kGrowth = 1.25F;
// [m] Offset of the grid: floors and walls often lie at round coordinates, where their points would fall on both sides
// of a cell face. Values at which no cell has a face near a round coordinate are as good.
constexpr double kShift_m = 0.11;
// Topmost bit of the key of a cell that holds the other face of a plane.
constexpr std::uint64_t kOtherFace = 1ULL << 3 * kAxisBits;

Vector3 corner_of(std::uint64_t key, double edge_m) {
  const auto along = [&](int axis) { return static_cast<double>(cell_index(key, axis)) * edge_m - kShift_m; };
  return {along(0), along(1), along(2)};
}

}  // namespace

std::uint64_t SurfaceMap::Level::key_of(const Vector3& p_m) const {
  const auto index = [&](double x) { return static_cast<std::int64_t>(std::floor((x + kShift_m) / edge_m)); };
  return cell_key(index(p_m.x()), index(p_m.y()), index(p_m.z()));
}

const SurfaceCell* SurfaceMap::Level::find(std::uint64_t key) const {
  const std::uint32_t found = table.find(key);
  return found == 0 ? nullptr : &cells[found - 1];
}

std::uint32_t SurfaceMap::Level::find_or_make(std::uint64_t key) {
  const std::uint32_t index = table.find_or_insert(key);
  if (index == cells.size()) cells.emplace_back();
  return index;
}

SurfaceMap::SurfaceMap(const SurfaceMapConfig& config) : config_(config), levels_(config.levels) {
  double edge_m = config.cell_m;
  for (Level& level : levels_) {
    level.edge_m = edge_m;
    edge_m *= 0.5;
  }
}

bool SurfaceMap::is_behind(const SurfaceCell& cell, const Vector3& origin_m) const {
  if (!config_.two_faced || !cell.planar) return false;
  const Eigen::Vector3f ray_m = cell.mean_m - origin_m.cast<float>();
  const float along_m = cell.normal.dot(ray_m);
  return along_m > 0.0F && along_m > kBehind * ray_m.norm();
}

void SurfaceMap::insert(std::span<const Vector3> points_m, const Vector3& origin_m) {
  touched_.clear();
  for (const Vector3& p_m : points_m) {
    // Distant surfaces are seen by few beams and need no small cells.
    const double least_edge_m = config_.fineness * (p_m - origin_m).norm();
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      Level& level = levels_[l];
      std::uint64_t key = level.key_of(p_m);
      std::uint32_t index = level.find_or_make(key);
      if (is_behind(level.cells[index], origin_m)) {
        key |= kOtherFace;
        index = level.find_or_make(key);
      }
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
    fit(level, level.table.keys[t.cell], level.cells[t.cell], origin_m);
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
    const std::uint64_t key = level.key_of(p_m);
    const SurfaceCell* cell = level.find(key);
    if (cell != nullptr && is_behind(*cell, origin_m)) cell = level.find(key | kOtherFace);
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
    level.table.erase_if(level.cells, [&](std::uint64_t key, const SurfaceCell&) {
      const Vector3 middle_m = corner_of(key, level.edge_m) + Vector3::Constant(0.5 * level.edge_m);
      return (middle_m - center_m).squaredNorm() > config_.keep_radius_m * config_.keep_radius_m;
    });
  }
}

void SurfaceMap::clear() {
  for (Level& level : levels_) {
    level.table.clear();
    level.cells.clear();
  }
}

std::size_t SurfaceMap::num_cells() const {
  std::size_t num = 0;
  for (const Level& level : levels_) num += level.cells.size();
  return num;
}

std::size_t SurfaceMap::bytes() const {
  std::size_t bytes = 0;
  for (const Level& level : levels_) bytes += level.cells.capacity() * sizeof(SurfaceCell) + level.table.bytes();
  return bytes;
}

void SurfaceMapConfig::visit(ConfigVisitor& v) {
  v.field("cell_m", cell_m, "[m] edge of the largest cells", Range::between(0.1, 10.0));
  v.field("keep_radius_m", keep_radius_m, "[m] distance from the vehicle above which cells are dropped",
          Range::between(5.0, 2000.0));
}

}  // namespace swiftlet
