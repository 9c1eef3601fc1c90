// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/free_space.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {
namespace {

// Marks of a column: height not determined yet, and no ground.
constexpr float kNotLookedAt = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoGround = std::numeric_limits<float>::infinity();
// [-] Largest number of cells of the grid, of one byte each; larger grids are refused. Limits the memory.
constexpr std::size_t kMaxCells = 40'000'000;
// [-] Horizontal rays from a position that test for enclosing walls. With fewer, gaps in walls are missed.
constexpr int kViews = 8;
// [-] Samples of the ground along x and along y. More of them measure the enclosed share more finely and cost time.
constexpr int kColumns = 24;
// [m] Step beyond a surface from which a ray is continued. Smaller values may meet the same surface again.
constexpr double kPast_m = 1e-3;

bool is_plant(SurfaceClass surface_class) {
  return surface_class == SurfaceClass::kVegetation || surface_class == SurfaceClass::kTrunk ||
         surface_class == SurfaceClass::kBranch || surface_class == SurfaceClass::kUndergrowth ||
         surface_class == SurfaceClass::kFallenTrunk;
}

bool ends_at_wall(const StaticScene& world, Vector3 from, const Vector3& direction) {
  double left_m = world.bounds_m().diagonal().norm();
  while (left_m > 0.0) {
    const RayHit hit = world.trace(from, direction, left_m);
    if (hit.range_m <= 0.0F) return false;
    if (!is_plant(hit.surface_class)) return hit.surface_class != SurfaceClass::kGround;
    const double step_m = static_cast<double>(hit.range_m) + kPast_m;
    from += step_m * direction;
    left_m -= step_m;
  }
  return false;
}

std::optional<double> ground_of(const StaticScene& world, double x_m, double y_m) {
  const double bottom_m = world.bounds_m().min().z() - 1.0;
  for (double z = world.bounds_m().max().z() + 1.0; z > bottom_m;) {
    const RayHit hit = world.trace({x_m, y_m, z}, -Vector3::UnitZ(), z - bottom_m);
    if (hit.range_m <= 0.0F) break;
    z -= hit.range_m;
    if (hit.surface_class == SurfaceClass::kGround) return z;
    z -= kPast_m;
  }
  return std::nullopt;
}

}  // namespace

bool is_enclosed(const StaticScene& world, const Vector3& p_world_m) {
  int open = 0;
  for (int i = 0; i < kViews && open < 2; ++i) {
    const double azimuth = i * 2.0 * std::numbers::pi / kViews;
    if (!ends_at_wall(world, p_world_m, {elementary::cos(azimuth), elementary::sin(azimuth), 0.0})) ++open;
  }
  return open < 2;
}

double enclosed_share(const StaticScene& world, double height_m) {
  const Eigen::AlignedBox3d& bounds = world.bounds_m();
  int columns = 0, enclosed = 0;
  for (int i = 0; i < kColumns * kColumns && !bounds.isEmpty(); ++i) {
    const double x_m = bounds.min().x() + (i % kColumns + 0.5) / kColumns * bounds.sizes().x();
    const double y_m = bounds.min().y() + (i / kColumns + 0.5) / kColumns * bounds.sizes().y();
    const auto ground_m = ground_of(world, x_m, y_m);
    if (!ground_m) continue;
    ++columns;
    enclosed += is_enclosed(world, {x_m, y_m, *ground_m + height_m}) ? 1 : 0;
  }
  return columns > 0 ? static_cast<double>(enclosed) / columns : 0.0;
}

FreeSpace::FreeSpace(std::shared_ptr<const StaticScene> world, const Limits& limits)
    : world_(std::move(world)), limits_(limits) {
  const Eigen::AlignedBox3d& bounds = world_->bounds_m();
  if (bounds.isEmpty()) return;
  area_m_.min() = bounds.min().head<2>().array() + limits.border_m;
  area_m_.max() = bounds.max().head<2>().array() - limits.border_m;
  if (area_m_.isEmpty()) return;
  grid_.cell_m = limits.cell_m;
  grid_.origin_world_m << area_m_.min(), bounds.min().z();
  const Eigen::Vector2d extent = area_m_.sizes();
  // Flights are at most height_max_m above the highest ground, which lies below the top of the world's bounds.
  const double height_m = bounds.sizes().z() + limits.height_max_m;
  const Eigen::Array3d cells = (Eigen::Array3d(extent.x(), extent.y(), height_m) / limits.cell_m).floor() + 1.0;
  if (!(cells.prod() <= static_cast<double>(kMaxCells))) {
    throw std::invalid_argument("flight.cell_m: expected a larger cell, found a grid of more than 40 million cells");
  }
  grid_.size = cells.cast<int>().matrix();
  free_.assign(grid_.num_cells(), 0);
  ground_m_.assign(static_cast<std::size_t>(grid_.size.x()) * static_cast<std::size_t>(grid_.size.y()), kNotLookedAt);
  if (limits.indoors) indoors_.assign(free_.size(), 0);
}

std::optional<double> FreeSpace::ground_m(double x_m, double y_m) const { return ground_of(*world_, x_m, y_m); }

bool FreeSpace::is_indoors(const Vector3& p) const {
  const int index = grid_.index_of(grid_.cell_at(p));
  std::uint8_t& known = indoors_[static_cast<std::size_t>(index)];
  if (known == 0) known = is_enclosed(*world_, grid_.center_of(index)) ? 1 : 2;
  return known == 1;
}

bool FreeSpace::is_free(const Vector3& p, double radius_m) const {
  if (!area_m_.contains(p.head<2>().eval())) return false;
  // The ground of the whole column is a sufficient approximation; the distance to surfaces is exact.
  const Eigen::Vector3i cell = grid_.cell_at(p);
  float& ground = ground_m_[static_cast<std::size_t>(grid_.index_of({cell.x(), cell.y(), 0}))];
  if (std::isnan(ground)) {
    const Vector3 center = grid_.center_of(grid_.index_of(cell));
    ground = static_cast<float>(ground_m(center.x(), center.y()).value_or(kNoGround));
  }
  const double height_m = p.z() - static_cast<double>(ground);
  if (!(height_m >= limits_.height_min_m && height_m <= limits_.height_max_m)) return false;
  if (world_->nearest(p, radius_m).has_value()) return false;
  return indoors_.empty() || is_indoors(p);
}

bool FreeSpace::is_free(const Vector3& p) const { return is_free(p, limits_.radius_m); }

bool FreeSpace::is_free_cell(int index) const {
  std::uint8_t& known = free_[static_cast<std::size_t>(index)];
  if (known == 0) known = is_free(grid_.center_of(index)) ? 1 : 2;
  return known == 1;
}

}  // namespace swiftlet::sim
