// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/free_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

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
  origin_m_ << area_m_.min(), bounds.min().z();
  const Eigen::Vector2d extent = area_m_.sizes();
  // Nobody flies higher than the limit above the highest ground, which lies below the top of everything.
  const double height_m = bounds.sizes().z() + limits.height_max_m;
  size_ = {static_cast<int>(extent.x() / limits.cell_m) + 1, static_cast<int>(extent.y() / limits.cell_m) + 1,
           static_cast<int>(height_m / limits.cell_m) + 1};
  const std::size_t columns = static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y());
  if (columns * static_cast<std::size_t>(size_.z()) > kMaxCells) {
    throw std::invalid_argument("flight.cell_m: expected a larger cell, found a grid of more than 40 million cells");
  }
  free_.assign(columns * static_cast<std::size_t>(size_.z()), 0);
  ground_m_.assign(columns, kNotLookedAt);
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
  std::uint8_t& known = indoors_[static_cast<std::size_t>(index_of(cell_of(p)))];
  if (known != 0) return known == 1;
  const Vector3 center = center_of(index_of(cell_of(p)));
  const double far_m = world_->bounds_m().diagonal().norm();
  int ended = 0;
  for (int i = 0; i < kViews; ++i) {
    const double azimuth = i * 2.0 * std::numbers::pi / kViews;
    ended += world_->trace(center, {std::cos(azimuth), std::sin(azimuth), 0.0}, far_m).range_m > 0.0F ? 1 : 0;
  }
  known = ended + 1 >= kViews ? 1 : 2;
  return known == 1;
}

bool FreeSpace::is_free(const Vector3& p, double radius_m) const {
  if (!area_m_.contains(p.head<2>().eval())) return false;
  // The ground of the column is near enough: the distance to surfaces is exact.
  const Cell cell = cell_of(p);
  float& ground = ground_m_[static_cast<std::size_t>(cell.y) * static_cast<std::size_t>(size_.x()) + cell.x];
  if (std::isnan(ground)) {
    const Vector3 center = center_of(index_of(cell));
    ground = static_cast<float>(ground_m(center.x(), center.y()).value_or(kNoGround));
  }
  const double height_m = p.z() - static_cast<double>(ground);
  if (!(height_m >= limits_.height_min_m && height_m <= limits_.height_max_m)) return false;
  if (world_->nearest(p, radius_m).has_value()) return false;
  return indoors_.empty() || is_indoors(p);
}

bool FreeSpace::is_free(const Vector3& p) const { return is_free(p, limits_.radius_m); }

bool FreeSpace::is_free(const Vector3& a, const Vector3& b) const {
  const int steps = std::max(1, static_cast<int>(std::ceil((b - a).norm() / (0.5 * limits_.cell_m))));
  for (int i = 0; i <= steps; ++i) {
    if (!is_free(a + (b - a) * (static_cast<double>(i) / steps))) return false;
  }
  return true;
}

std::vector<Vector3> FreeSpace::find_way(const Vector3& from, const Vector3& to) const {
  if (!is_free(from) || !is_free(to)) return {};
  const std::vector<int> cells = search(index_of(cell_of(from)), index_of(cell_of(to)));
  if (cells.empty()) return {};
  std::vector<Vector3> way = {from};
  for (std::size_t i = 1; i + 1 < cells.size(); ++i) way.push_back(center_of(cells[i]));
  way.push_back(to);
  return without_needless_corners(way);
}

FreeSpace::Cell FreeSpace::cell_of(const Vector3& p) const {
  const Eigen::Vector3i cell = ((p - origin_m_) / limits_.cell_m).array().floor().cast<int>();
  return {std::clamp(cell.x(), 0, size_.x() - 1), std::clamp(cell.y(), 0, size_.y() - 1),
          std::clamp(cell.z(), 0, size_.z() - 1)};
}

Vector3 FreeSpace::center_of(int index) const {
  const Vector3 cell(index % size_.x(), index / size_.x() % size_.y(), index / size_.x() / size_.y());
  return origin_m_ + limits_.cell_m * (cell + Vector3::Constant(0.5));
}

bool FreeSpace::is_free_cell(int index) const {
  std::uint8_t& known = free_[static_cast<std::size_t>(index)];
  if (known == 0) known = is_free(center_of(index)) ? 1 : 2;
  return known == 1;
}

// A*; start and goal count as free. Equal costs are told apart by the index, so that the way is always the same.
std::vector<int> FreeSpace::search(int start, int goal) const {
  struct Open {
    float cost;  // so far and the rest as the crow flies, in cells
    int index;
    bool operator<(const Open& other) const { return cost != other.cost ? cost > other.cost : index > other.index; }
  };
  const Vector3 goal_m = center_of(goal);
  const auto rest = [&](int index) { return static_cast<float>((center_of(index) - goal_m).norm() / limits_.cell_m); };
  std::vector<float> cost(free_.size(), std::numeric_limits<float>::infinity());
  std::vector<int> parent(free_.size(), -1);
  std::priority_queue<Open> open;
  cost[static_cast<std::size_t>(start)] = 0.0F;
  open.push({rest(start), start});
  while (!open.empty()) {
    const Open next = open.top();
    open.pop();
    if (next.index == goal) break;
    const float so_far = cost[static_cast<std::size_t>(next.index)];
    if (next.cost > so_far + rest(next.index) + 1e-3F) continue;  // found a shorter way to it since
    const Cell cell = {next.index % size_.x(), next.index / size_.x() % size_.y(), next.index / size_.x() / size_.y()};
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Cell to = {cell.x + dx, cell.y + dy, cell.z + dz};
          if ((dx == 0 && dy == 0 && dz == 0) || to.x < 0 || to.y < 0 || to.z < 0 || to.x >= size_.x() ||
              to.y >= size_.y() || to.z >= size_.z()) {
            continue;
          }
          const int index = index_of(to);
          const float length = std::sqrt(static_cast<float>(dx * dx + dy * dy + dz * dz));
          if (so_far + length >= cost[static_cast<std::size_t>(index)]) continue;
          if (index != goal && !is_free_cell(index)) continue;
          cost[static_cast<std::size_t>(index)] = so_far + length;
          parent[static_cast<std::size_t>(index)] = next.index;
          open.push({so_far + length + rest(index), index});
        }
      }
    }
  }
  if (start != goal && parent[static_cast<std::size_t>(goal)] < 0) return {};
  std::vector<int> way;
  for (int index = goal; index >= 0; index = index == start ? -1 : parent[static_cast<std::size_t>(index)]) {
    way.push_back(index);
  }
  std::reverse(way.begin(), way.end());
  return way;
}

std::vector<Vector3> FreeSpace::without_needless_corners(const std::vector<Vector3>& way) const {
  std::vector<Vector3> corners = {way.front()};
  for (std::size_t i = 0; i + 1 < way.size();) {
    // The farthest corner that can be reached straight, looked for by doubling.
    std::size_t reach = i + 1;
    for (std::size_t step = 1; reach + step < way.size() && is_free(way[i], way[reach + step]); step *= 2)
      reach += step;
    while (reach + 1 < way.size() && is_free(way[i], way[reach + 1])) ++reach;
    corners.push_back(way[reach]);
    i = reach;
  }
  return corners;
}

}  // namespace swiftlet::sim
