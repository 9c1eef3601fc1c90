// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/placement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/sim/world/keep_clear_config.hpp"

namespace swiftlet::sim {

void TrailConfig::visit(ConfigVisitor& v) {
  v.field("points_m", points_m, "[m] corners of the trail's center line; z is not used");
  v.field("width_m", width_m, "[m] width of the free zone", Range::positive());
}

void ClearingConfig::visit(ConfigVisitor& v) {
  v.field("center_m", center_m, "[m] x and y of the center");
  v.field("radius_m", radius_m, "[m]", Range::positive());
}

void KeepClearConfig::visit(ConfigVisitor& v) {
  v.list("trails", trails, "trails without stems, undergrowth, branches and crowns");
  v.list("clearings", clearings, "discs without stems, undergrowth, branches and crowns");
  v.field("clear_height_m", clear_height_m, "[m] height of trails and clearings above the highest ground",
          Range::non_negative());
}

double distance_to_segment_m(const Eigen::Vector2d& point_world_m, const Eigen::Vector2d& a_world_m,
                             const Eigen::Vector2d& b_world_m) {
  const Eigen::Vector2d ab = b_world_m - a_world_m;
  const double length_sq = ab.squaredNorm();
  const double along = length_sq > 0.0 ? std::clamp((point_world_m - a_world_m).dot(ab) / length_sq, 0.0, 1.0) : 0.0;
  return (point_world_m - a_world_m - along * ab).norm();
}

double KeepClearConfig::distance_m(const Eigen::Vector2d& point_world_m) const {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const TrailConfig& trail : trails) {
    for (std::size_t i = 0; i < trail.points_m.size(); ++i) {
      const Eigen::Vector2d a = trail.points_m[i == 0 ? 0 : i - 1].head<2>();
      const Eigen::Vector2d b = trail.points_m[i].head<2>();
      nearest_m = std::min(nearest_m, distance_to_segment_m(point_world_m, a, b) - 0.5 * trail.width_m);
    }
  }
  for (const ClearingConfig& clearing : clearings) {
    nearest_m = std::min(nearest_m, (point_world_m - clearing.center_m).norm() - clearing.radius_m);
  }
  return nearest_m;
}

std::int64_t Spacing::cell_of(double x_m, double y_m) const {
  const auto index = [&](double value) { return static_cast<std::int64_t>(std::floor(value / spacing_m_)); };
  return (index(x_m) << 32) ^ (index(y_m) & 0xFFFFFFFF);
}

bool Spacing::try_add(const Eigen::Vector2d& point_world_m) {
  if (spacing_m_ <= 0.0) return true;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      const auto [begin, end] =
          points_.equal_range(cell_of(point_world_m.x() + dx * spacing_m_, point_world_m.y() + dy * spacing_m_));
      for (auto it = begin; it != end; ++it) {
        if ((it->second - point_world_m).squaredNorm() < spacing_m_ * spacing_m_) return false;
      }
    }
  }
  points_.emplace(cell_of(point_world_m.x(), point_world_m.y()), point_world_m);
  return true;
}

}  // namespace swiftlet::sim
