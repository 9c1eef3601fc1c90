// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/building.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {

void add_wall(Mesh& mesh, const Eigen::Vector2d& start_m, const Eigen::Vector2d& end_m, double height_m,
              double thickness_m, std::span<const Opening> openings, double foot_z_m) {
  const Eigen::Vector2d along = (end_m - start_m).normalized();
  const double length_m = (end_m - start_m).norm();
  const double yaw_rad = elementary::atan2(along.y(), along.x());
  // Adds the part of the wall between two positions along it and two heights.
  const auto add_piece = [&](double from_m, double to_m, double low_m, double high_m) {
    if (to_m - from_m <= 1e-9 || high_m - low_m <= 1e-9) return;
    const Eigen::Vector2d center_m = start_m + 0.5 * (from_m + to_m) * along;
    Eigen::Affine3f T = Eigen::Affine3f::Identity();
    T.translate(Eigen::Vector3d(center_m.x(), center_m.y(), foot_z_m + 0.5 * (low_m + high_m)).cast<float>());
    T.rotate(Eigen::AngleAxisf(static_cast<float>(yaw_rad), Eigen::Vector3f::UnitZ()));
    add_box(mesh, T, Eigen::Vector3d(to_m - from_m, thickness_m, high_m - low_m).cast<float>());
  };
  double done_m = 0.0;
  for (const Opening& opening : openings) {
    const double from_m = opening.center_m - 0.5 * opening.width_m;
    const double to_m = opening.center_m + 0.5 * opening.width_m;
    add_piece(done_m, from_m, 0.0, height_m);
    add_piece(from_m, to_m, 0.0, opening.bottom_m);
    add_piece(from_m, to_m, opening.top_m, height_m);
    done_m = to_m;
  }
  add_piece(done_m, length_m, 0.0, height_m);
}

void add_floor(Mesh& mesh, const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m, double z_m) {
  const Eigen::Vector2f low = min_m.cast<float>();
  const Eigen::Vector2f high = max_m.cast<float>();
  const auto z = static_cast<float>(z_m);
  add_quad(mesh, {low.x(), low.y(), z}, {high.x(), low.y(), z}, {high.x(), high.y(), z}, {low.x(), high.y(), z});
}

}  // namespace swiftlet::sim
