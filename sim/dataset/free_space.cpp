// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/free_space.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/elementary.hpp"

namespace swiftlet::sim {
namespace {

constexpr float kNotLookedAt = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoGround = std::numeric_limits<float>::infinity();
constexpr std::size_t kMaxCells = 40'000'000;
constexpr int kViews = 8;

}  // namespace

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
  // Nobody flies higher than the limit above the highest ground, which lies below the top of everything.
  const double height_m = bounds.sizes().z() + limits.height_max_m;
  grid_.size = {static_cast<int>(extent.x() / limits.cell_m) + 1, static_cast<int>(extent.y() / limits.cell_m) + 1,
                static_cast<int>(height_m / limits.cell_m) + 1};
  if (grid_.num_cells() > kMaxCells) {
    throw std::invalid_argument("flight.cell_m: expected a larger cell, found a grid of more than 40 million cells");
  }
  free_.assign(grid_.num_cells(), 0);
  ground_m_.assign(static_cast<std::size_t>(grid_.size.x()) * static_cast<std::size_t>(grid_.size.y()), kNotLookedAt);
  if (limits.indoors) indoors_.assign(free_.size(), 0);
}

std::optional<double> FreeSpace::ground_m(double x_m, double y_m) const {
  const double bottom_m = world_->bounds_m().min().z() - 1.0;
  for (double z = world_->bounds_m().max().z() + 1.0; z > bottom_m;) {
    const RayHit hit = world_->trace({x_m, y_m, z}, -Vector3::UnitZ(), z - bottom_m);
    if (hit.range_m <= 0.0F) break;
    z -= hit.range_m;
    if (hit.surface_class == SurfaceClass::kGround) return z;
    z -= 1e-3;
  }
  return std::nullopt;
}

// Level views in eight directions end at something, but for one that may go out through a door.
bool FreeSpace::is_indoors(const Vector3& p) const {
  const int index = grid_.index_of(grid_.cell_at(p));
  std::uint8_t& known = indoors_[static_cast<std::size_t>(index)];
  if (known != 0) return known == 1;
  const Vector3 center = grid_.center_of(index);
  const double far_m = world_->bounds_m().diagonal().norm();
  int ended = 0;
  for (int i = 0; i < kViews; ++i) {
    const double azimuth = i * 2.0 * std::numbers::pi / kViews;
    ended +=
        world_->trace(center, {elementary::cos(azimuth), elementary::sin(azimuth), 0.0}, far_m).range_m > 0.0F ? 1 : 0;
  }
  known = ended + 1 >= kViews ? 1 : 2;
  return known == 1;
}

bool FreeSpace::is_free(const Vector3& p, double radius_m) const {
  if (!area_m_.contains(p.head<2>().eval())) return false;
  // The ground of the column is near enough: the distance to surfaces is exact.
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
