// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/neighbor_sight.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] Displacement below which the flight direction is undefined. Larger values turn the sensor less in slow flight.
constexpr double kNoDirection_m = 0.3;
/// [-] Tangent of the horizontal angle outside the view that still counts as in view. Larger values turn the vehicle
/// less.
constexpr double kViewTolerance = 0.2;
/// [m/s] Speed added to the closing speed of a neighbor. Larger values rate distant neighbors as more urgent.
constexpr double kSlow_mps = 1.0;
/// [-] Cost of a heading with the flight direction out of view; a near neighbor out of view that was seen 1 s ago costs
/// 2. Larger values favor the flight direction over neighbors behind.
constexpr double kAheadUnseenCost = 2.0;
/// [1/rad] Cost of a turn from the last heading: decides between headings that are equal otherwise.
constexpr double kTurnCostPerRad = 0.01;

/// Time until the neighbor could be here, at its closing speed plus kSlow_mps; at least 1 s.
double time_to_meet_s(const Neighbor& neighbor, const Vector3& to_neighbor_m) {
  const double d = to_neighbor_m.norm();
  const double closing_mps = d > 0.0 ? std::max(0.0, -neighbor.velocity_local_mps.dot(to_neighbor_m) / d) : 0.0;
  return std::max(1.0, d / (kSlow_mps + closing_mps));
}

}  // namespace

bool NeighborSight::sees(const Vector3& p_body_m) const {
  return std::any_of(views_.begin(), views_.end(), [&](const NeighborView& view) { return view.contains(p_body_m); });
}

bool NeighborSight::sees_beside(const Vector3& direction_body) const {
  // The tolerance is 0 right above and below, where azimuths are undefined.
  const double level = elementary::hypot(direction_body.x(), direction_body.y());
  return sees(direction_body + kViewTolerance * level * Vector3::UnitX());
}

bool NeighborSight::sees_ahead(const Pose& T_local_body, const Vector3& to_local_m) const {
  if (views_.empty()) return true;
  const Vector3 ahead_body_m = T_local_body.linear().transpose() * (to_local_m - T_local_body.translation());
  const double d = ahead_body_m.norm();
  return d < kNoDirection_m || sees_beside(ahead_body_m / d);
}

double NeighborSight::heading(const Pose& T_local_body, const Vector3& to_local_m, std::span<const Neighbor> neighbors,
                              double last_yaw_rad, TimeNs now) const {
  if (views_.empty()) return last_yaw_rad;
  const Vector3 p_local_m = T_local_body.translation();
  const Vector3 ahead_local_m = to_local_m - p_local_m;
  const bool flies = ahead_local_m.norm() > kNoDirection_m;
  double best_rad = last_yaw_rad, least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kHeadings; ++i) {
    const double turn_rad = std::remainder(2.0 * kPi * i / kHeadings, 2.0 * kPi);
    const Matrix3 R_body_local = Eigen::AngleAxisd(-(last_yaw_rad + turn_rad), Vector3::UnitZ()).toRotationMatrix();
    double cost = kTurnCostPerRad * std::abs(turn_rad);
    for (const Neighbor& neighbor : neighbors) {
      const Vector3 to_m = neighbor.position_local_m - p_local_m;
      if (!sees(R_body_local * to_m)) cost += (1.0 + to_seconds(now - neighbor.seen)) / time_to_meet_s(neighbor, to_m);
    }
    if (flies && !sees(R_body_local * ahead_local_m)) cost += kAheadUnseenCost;
    if (cost >= least) continue;
    least = cost;
    best_rad = std::remainder(last_yaw_rad + turn_rad, 2.0 * kPi);
  }
  return best_rad;
}

}  // namespace swiftlet
