// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl_obstacles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr float kInside_m = 0.01F;  // below this distance the direction to a voxel is that to its center

Matrix3 turn_y(double angle_rad) { return Eigen::AngleAxisd(angle_rad, Vector3::UnitY()).toRotationMatrix(); }

/// The plane that keeps the agent clear of a voxel; an agent inside of a voxel leaves it.
HalfSpace voxel_cut(const Vector3& nearest_agent_m, const Vector3& center_agent_m, double encumbrance_m, double eta) {
  if (nearest_agent_m.norm() > kInside_m) return obstacle_cut(nearest_agent_m, encumbrance_m, eta);
  return {center_agent_m.norm() > kInside_m ? Vector3(center_agent_m.normalized()) : Vector3(Vector3::UnitZ()),
          -encumbrance_m};
}

/// Whether q lies beyond obstacle_cut(point): q . point / d > offset(d), where the offset is gain * d - less.
class PlaneTest {
 public:
  PlaneTest(double encumbrance_m, double eta)
      : twice_sq_(static_cast<float>(4.0 * encumbrance_m * encumbrance_m)),
        near_{1.0F, static_cast<float>(encumbrance_m)},
        far_{static_cast<float>(eta), static_cast<float>((2.0 * eta - 1.0) * encumbrance_m)} {}

  bool operator()(const Eigen::Vector3f& q, const Eigen::Vector3f& point) const {
    const float d_sq = point.squaredNorm();
    const Offset& offset = d_sq < twice_sq_ ? near_ : far_;
    const float over = q.dot(point) - offset.gain * d_sq;  // beyond when more than -less * d
    const bool within_less = over * over < offset.less * offset.less * d_sq;
    return offset.less >= 0.0F ? over > 0.0F || within_less : over > 0.0F && !within_less;
  }

 private:
  struct Offset {
    float gain, less;
  };
  float twice_sq_;
  Offset near_, far_;
};

}  // namespace

void ObstacleCutter::cut_convex(RblCell& cell, const Vector3& p_local_m, std::span<const Vector3> voxels_local_m,
                                double edge_m, double encumbrance_m, double eta, std::vector<HalfSpace>& cuts) {
  const std::size_t first = cuts.size();
  convex_planes(p_local_m, voxels_local_m, edge_m, encumbrance_m, eta, cuts);
  for (std::size_t i = first; i < cuts.size(); ++i) cell.cut(cuts[i]);
}

void ObstacleCutter::convex_planes(const Vector3& p_local_m, std::span<const Vector3> voxels_local_m, double edge_m,
                                   double encumbrance_m, double eta, std::vector<HalfSpace>& cuts) {
  left_.clear();
  for (const Vector3& voxel_local_m : voxels_local_m) {
    const Vector3 center = voxel_local_m - p_local_m;
    const Eigen::Vector3f nearest = nearest_in_voxel(Vector3::Zero(), center, edge_m).cast<float>();
    left_.push_back({nearest, center.cast<float>(), nearest.squaredNorm()});
  }
  while (!left_.empty()) {
    const auto first = std::min_element(left_.begin(), left_.end(), [](const Candidate& a, const Candidate& b) {
      return a.distance_sq < b.distance_sq;
    });
    const Candidate at = *first;
    const HalfSpace cut =
        voxel_cut(at.nearest_agent_m.cast<double>(), at.center_agent_m.cast<double>(), encumbrance_m, eta);
    cuts.push_back(cut);
    // Voxels beyond the plane through the nearest point are at least as far from the cell as that point.
    const Eigen::Vector3f normal = cut.normal_local.cast<float>();
    const float beyond = std::sqrt(at.distance_sq) - 1e-4F;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (&left_[i] == &*first || normal.dot(left_[i].nearest_agent_m) >= beyond) continue;
      left_[kept++] = left_[i];
    }
    left_.resize(kept);
  }
}

void ObstacleCutter::cut_nearest(RblCell& cell, const Vector3& p_local_m, std::span<const Vector3> voxels_local_m,
                                 double edge_m, double encumbrance_m, double eta) {
  if (voxels_local_m.empty() || cell.is_empty()) return;
  const int half = static_cast<int>(std::ceil(cell.radius_m() / eta / edge_m)) + 1;
  const VoxelGrid around{edge_m, (p_local_m.array() / edge_m).floor().cast<int>() - half, Cell::Constant(2 * half + 1)};
  const Vector3 from_corner_m = p_local_m - around.min_cell.cast<double>() * edge_m;
  // Inside the grid all coordinates are positive, so truncation rounds down.
  const auto counted_cell = [&](const Vector3& q) { return Cell(((q + from_corner_m) / edge_m).cast<int>()); };
  const auto [low_m, high_m] = cell.bounds();
  const Cell low = counted_cell(low_m), high = counted_cell(high_m);
  nearest_.compute(voxels_local_m, around, {edge_m, around.min_cell + low, high - low + Cell::Ones()});
  if (nearest_.empty()) return;

  // Evaluated for every sample: single precision, no root.
  const auto edge = static_cast<float>(edge_m), per_edge = static_cast<float>(1.0 / edge_m);
  const Eigen::Vector3f to_face = Eigen::Vector3f::Constant(0.5F * edge);
  const Eigen::Vector3f to_box_cells = (from_corner_m / edge_m - low.cast<double>()).cast<float>();
  const Eigen::Vector3f first_center = (Vector3::Constant(0.5 * edge_m) - from_corner_m).cast<float>();
  const PlaneTest beyond_plane(encumbrance_m, eta);
  const Cell last = high - low;
  cell.exclude([&](const Eigen::Vector3f& q) {
    const Cell in_box = (per_edge * q + to_box_cells).cast<int>().cwiseMin(last);
    const Eigen::Vector3f center = first_center + edge * nearest_.nearest(in_box).cast<float>();
    const Eigen::Vector3f nearest = q.cwiseMax(center - to_face).cwiseMin(center + to_face);
    if (nearest.squaredNorm() > kInside_m * kInside_m) return beyond_plane(q, nearest);
    const HalfSpace cut = voxel_cut(nearest.cast<double>(), center.cast<double>(), encumbrance_m, eta);
    return cut.normal_local.dot(q.cast<double>()) > cut.offset_m;
  });
}

std::array<HalfSpace, 2> field_of_view(const Matrix3& R_local_body, double fov_lower_deg, double fov_deg,
                                       const Vector3& p_lidar_body_m) {
  const Vector3 lidar_agent_m = R_local_body * p_lidar_body_m;
  const Vector3 n1 = R_local_body * turn_y(fov_lower_deg * kRadPerDeg) * Vector3::UnitZ();
  const Vector3 n2 = R_local_body * turn_y((fov_lower_deg - fov_deg) * kRadPerDeg) * Vector3::UnitZ();
  return {HalfSpace{-n1, -n1.dot(lidar_agent_m)}, HalfSpace{n2, n2.dot(lidar_agent_m)}};
}

void RblLidarConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled, "[-] keep clear of what the map shows (mapping) [Kamler 2025, chapter 3]");
  v.choice("cut", cut, {"convex", "nearest"},
           "[-] half-spaces at one voxel after the other, or each sample by the voxel nearest to it (3.1)");
  v.choice(
      "legal", legal, {"sensed", "cell"},
      "[-] cell A' of admissible goals: what is sensed now, or the whole cell A (authors' experiment files), each in "
      "view");
  v.field("fov_lower_deg", fov_lower_deg, "[deg] gamma of (3.2): the sensor sees down to this below the horizon ahead",
          Range::between(-90.0, 90.0));
  v.field("fov_deg", fov_deg, "[deg] alpha of (3.3): vertical field of view", Range::between(1.0, 180.0));
  v.field("facing_deg", facing_deg, "[deg] fly only when the centroid is less than this off the heading",
          Range::between(1.0, 180.0));
  v.field("sensed_s", sensed_s, "[s] a voxel hit within this time counts as actively sensed (cell A')",
          Range::positive());
}

}  // namespace swiftlet
