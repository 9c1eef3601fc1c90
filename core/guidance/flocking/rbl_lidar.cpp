// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_lidar.hpp"

#include <algorithm>
#include <cmath>

#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/heading.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] Distance of the goal from the vehicle on a straight part of the detour in view. Larger values fly faster.
constexpr double kAims_m = 1.0;
/// [m] Distance of the goal from the vehicle on a part out of view, above or below. Larger values fly faster.
constexpr double kUnseen_m = 0.2;
/// [sensing radii] Range within which a view counts as evidence of free space. Larger values trust sparse returns.
constexpr double kSeesFree_radii = 2.0;
/// [s] Age of the last hit up to which a voxel counts as sensed now and cuts A'. Larger values keep ghosts for longer.
constexpr double kSensed_s = 0.5;
/// [m] Step of the search for a free height. Larger values may step over thin obstacles.
constexpr double kHeightStep_m = 0.2;
/// [deg] Bounds of the elevation of the edge of the field of view, for the distance from which the goal is in view. The
/// lower bound limits that distance, the upper one keeps it from 0.
constexpr double kMinEdge_deg = 5.0, kMaxEdge_deg = 60.0;
/// [lattice steps] Half the diagonal of a lattice cell, sqrt(3) / 2: a centroid this close to a sample of A' lies in
/// A'.
constexpr double kBetweenSamples = 0.87;

}  // namespace

RblLidar::RblLidar(const RblConfig& config, bool planar)
    : cells_(config.cells),
      config_(config.lidar),
      separated_(config.separation.enabled),
      sensed_(config.cells.sensing_radius_m, config.cells.step_m, planar),
      viewed_(kSeesFree_radii * config.cells.sensing_radius_m, config.cells.encumbrance_m) {}

void RblLidar::cut(const Situation& situation, RblPlanner& planner) {
  const Matrix3 R_local_body = situation.T_local_body.linear();
  const std::size_t first = planner.cuts().size();
  if (separated_) planner.harden();
  cut_by(planner.cell(), planner.cuts(), situation, kEver);
  cuts_.assign(planner.cuts().begin() + static_cast<std::ptrdiff_t>(first), planner.cuts().end());
  viewed_.look(situation.T_local_body.translation(), yaw_of(R_local_body), level_view(R_local_body));
}

/// Cuts a cell by the voxels with a hit since the time `since`. Voxels below the lowest flight level by more than the
/// encumbrance are left out, since the vehicle cannot touch them.
void RblLidar::cut_by(RblCell& cell, std::vector<HalfSpace>& cuts, const Situation& situation, TimeNs since) {
  const Vector3 p_local_m = situation.T_local_body.translation();
  const double edge_m = situation.map.edge_m();
  situation.map.occupied_within(p_local_m, cells_.sensing_radius_m / cells_.eta + cells_.encumbrance_m, since,
                                voxels_local_m_);
  const double floor_m = std::min(situation.z_min_m, p_local_m.z()) - cells_.encumbrance_m - 0.5 * edge_m;
  std::erase_if(voxels_local_m_, [&](const Vector3& voxel_local_m) { return voxel_local_m.z() < floor_m; });
  cutter_.cut(cell, p_local_m, voxels_local_m_, edge_m, cells_.encumbrance_m, cells_.eta, cuts);
}

double RblLidar::heading_to(const Situation& situation, const Vector3& q_local_m, double yaw_rad) {
  return heading_along(q_local_m - situation.T_local_body.translation(), kShortestToFace_m, yaw_rad);
}

Vector3 RblLidar::next_local_m(const Situation& situation, const RblCell& cell, const Vector3& centroid_local_m,
                               const std::optional<Vector3>& straight_local_m, double& yaw_rad) {
  if (straight_local_m) return straight_on(situation, cell, centroid_local_m, *straight_local_m, yaw_rad);
  return within_sight(situation, cell, centroid_local_m, yaw_rad);
}

/// The centroid if it lies in the presently sensed cell A', else the nearest sample of A'. The vehicle turns toward
/// the centroid, and stays until the heading is reached [Kamler 2025, sec. 3.3.1]. A goal within the own encumbrance is
/// approached without turning, because a goal right above or below never comes into view. Neither does a goal steeply
/// above or below; the vehicle approaches it slowly through positions viewed before.
Vector3 RblLidar::within_sight(const Situation& situation, const RblCell& cell, const Vector3& centroid_local_m,
                               double& yaw_rad) {
  const Pose& T_local_body = situation.T_local_body;
  const Vector3 p_local_m = T_local_body.translation();
  const Vector3 to_centroid_local_m = centroid_local_m - p_local_m;
  const double to_goal_m = (situation.goal_local_m - p_local_m).norm();
  yaw_rad = heading_along(to_centroid_local_m, kShortestToFace_m, yaw_rad);
  if (to_goal_m <= cells_.encumbrance_m) return centroid_local_m;
  const bool whole_cell = config_.legal == RblLidarConfig::Legal::kCell;
  if (whole_cell) {
    sensed_ = cell;
  } else {
    sensed_.reset(Vector3::Zero(), situation.z_min_m - p_local_m.z(), situation.z_max_m - p_local_m.z());
  }
  for (const HalfSpace& side : view(T_local_body.linear())) sensed_.cut(side);
  sensed_cuts_.clear();
  if (!whole_cell) cut_by(sensed_, sensed_cuts_, situation, situation.now - from_seconds(kSensed_s));
  const int sample = sensed_.nearest_partitioned(to_centroid_local_m);
  if (sample >= 0 && !faces(T_local_body, yaw_rad)) return p_local_m;
  const Vector3 seen_agent_m = sample >= 0 ? sensed_.point(sample) : Vector3::Zero();
  const bool inside = sample >= 0 && (seen_agent_m - to_centroid_local_m).norm() <= kBetweenSamples * sensed_.step_m();
  if (inside) return centroid_local_m;
  if (separated_ && to_goal_m <= cells_.sensing_radius_m) {
    if (const auto unviewed_local_m = slowly_local_m(situation, to_centroid_local_m)) return *unviewed_local_m;
  }
  return p_local_m + seen_agent_m;
}

/// Next goal on a detour where the centroid of the cell keeps the vehicle at rest: the vehicle turns along the path,
/// and flies once the heading is reached. A point right above or below never comes into view. The vehicle approaches it
/// slowly, through positions where it has been or that it has viewed; through others, as within_sight().
Vector3 RblLidar::straight_on(const Situation& situation, const RblCell& cell, const Vector3& centroid_local_m,
                              const Vector3& next_local_m, double& yaw_rad) {
  const Vector3 p_local_m = situation.T_local_body.translation();
  const Vector3 to_next_m = next_local_m - p_local_m;
  yaw_rad = heading_along(to_next_m, kShortestToFace_m, yaw_rad);
  if (!faces(situation.T_local_body, yaw_rad)) return p_local_m;
  const std::array<HalfSpace, 2> view = level_view(situation.T_local_body.linear());
  const bool in_view = std::all_of(view.begin(), view.end(), [&](const HalfSpace& side) {
    return side.normal_local.dot(to_next_m) <= std::max(side.offset_m, 0.0);
  });
  if (in_view) return p_local_m + std::min(1.0, kAims_m / to_next_m.norm()) * to_next_m;
  const auto unviewed_local_m = slowly_local_m(situation, to_next_m);
  return unviewed_local_m ? *unviewed_local_m : within_sight(situation, cell, centroid_local_m, yaw_rad);
}

/// Position a short step along a displacement out of view; empty if the space ahead has not been viewed.
std::optional<Vector3> RblLidar::slowly_local_m(const Situation& situation, const Vector3& displacement_local_m) const {
  const Vector3 p_local_m = situation.T_local_body.translation();
  const double length_m = displacement_local_m.norm();
  if (length_m <= 0.0) return std::nullopt;
  const Vector3 step_m = std::min(1.0, kUnseen_m / length_m) * displacement_local_m;
  const Vector3 front_m = step_m + cells_.encumbrance_m / length_m * displacement_local_m;
  if (!viewed_.contains(p_local_m + front_m, situation.map)) return std::nullopt;
  return p_local_m + step_m;
}

bool RblLidar::faces(const Pose& T_local_body, double yaw_rad) const {
  const double off_rad = std::remainder(yaw_rad - yaw_of(T_local_body.linear()), 2.0 * kPi);
  return std::abs(off_rad) <= config_.facing_deg * kRadPerDeg;
}

std::array<HalfSpace, 2> RblLidar::view(const Matrix3& R_local_body) const {
  return field_of_view(R_local_body, config_.fov_lower_deg, config_.fov_deg, p_lidar_body_m_);
}

/// Field of view of the vehicle at zero roll and pitch, without the short tilts by which it accelerates.
std::array<HalfSpace, 2> RblLidar::level_view(const Matrix3& R_local_body) const {
  const Vector3 ahead_local = Vector3(R_local_body(0, 0), R_local_body(1, 0), 0.0).normalized();
  Matrix3 R_local_level;
  R_local_level << ahead_local, Vector3::UnitZ().cross(ahead_local), Vector3::UnitZ();
  return view(R_local_level);
}

double RblLidar::clear_height_local_m(const Situation& situation, double wanted_m) const {
  const Vector3 p_local_m = situation.T_local_body.translation();
  const double up = wanted_m >= p_local_m.z() ? 1.0 : -1.0;
  double clear_m = p_local_m.z();
  while (clear_m != wanted_m) {
    const double next_m = std::abs(wanted_m - clear_m) <= kHeightStep_m ? wanted_m : clear_m + up * kHeightStep_m;
    const Vector3 next_local_m(p_local_m.x(), p_local_m.y(), next_m);
    const Vector3 beyond_local_m = next_local_m + Vector3(0.0, 0.0, up * cells_.encumbrance_m);
    if (situation.map.distance_m(next_local_m, cells_.encumbrance_m) < cells_.encumbrance_m) break;
    if (!viewed_.contains(beyond_local_m, situation.map)) break;
    clear_m = next_m;
  }
  return clear_m;
}

double RblLidar::sees_goal_from_m(double up_m) const {
  const double edge_deg = up_m < 0.0 ? config_.fov_lower_deg : config_.fov_deg - config_.fov_lower_deg;
  const double steepest = elementary::tan(std::clamp(edge_deg, kMinEdge_deg, kMaxEdge_deg) * kRadPerDeg);
  return std::abs(up_m) / steepest + cells_.encumbrance_m;
}

}  // namespace swiftlet
