// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/neighbor_sight.hpp"

#include <algorithm>
#include <array>
#include <bitset>
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
/// Costs [-] of a heading; larger values favor headings that avoid the cost. For comparison, a near neighbor out of
/// view that was seen 1 s ago costs 2.
struct Cost {
  static constexpr double kAheadUnseen = 2.0;  ///< flight direction not in view
  static constexpr double kGlancePerS = 2.0;   ///< [1/s] azimuth to be viewed next not in view, per second since it was
  static constexpr double kFreshView_s = 1.0;  ///< [s] first part of that time, without cost
  static constexpr double kGlance = 4.0;       ///< upper limit of that cost
  static constexpr double kPerRad = 0.01;      ///< [1/rad] turn from the last heading; decides between equal headings
};

/// Time until the neighbor could be here, at its closing speed plus kSlow_mps; at least 1 s.
double time_to_meet_s(const Neighbor& neighbor, const Vector3& to_neighbor_m) {
  const double d = to_neighbor_m.norm();
  const double closing_mps = d > 0.0 ? std::max(0.0, -neighbor.velocity_local_mps.dot(to_neighbor_m) / d) : 0.0;
  return std::max(1.0, d / (kSlow_mps + closing_mps));
}

Vector3 azimuth_of(int i, int count) {
  const double azimuth_rad = 2.0 * kPi * i / count;
  return {elementary::cos(azimuth_rad), elementary::sin(azimuth_rad), 0.0};
}

}  // namespace

bool NeighborSight::sees(const Vector3& p_body_m) const {
  return std::any_of(views_.begin(), views_.end(), [&](const NeighborView& view) { return view.contains(p_body_m); });
}

void NeighborSight::look(const Matrix3& R_local_body, TimeNs now) {
  for (int i = 0; i < kHeadings; ++i) {
    if (sees(R_local_body.transpose() * azimuth_of(i, kHeadings))) looked_[i] = now;
  }
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
                              double last_yaw_rad, TimeNs now) {
  if (views_.empty()) return last_yaw_rad;
  look(T_local_body.linear(), now);
  const Vector3 p_local_m = T_local_body.translation();
  const Vector3 ahead_local_m = to_local_m - p_local_m;
  const bool flies = ahead_local_m.norm() > kNoDirection_m;
  const auto turn_rad = [](int i) { return std::remainder(2.0 * kPi * i / kHeadings, 2.0 * kPi); };
  std::array<Matrix3, kHeadings> R_body_local;
  std::array<bool, kHeadings> is_blind{};  // with this heading the flight direction is out of view
  std::array<std::bitset<kHeadings>, kHeadings> shows{};
  std::bitset<kHeadings> within_reach;
  for (int i = 0; i < kHeadings; ++i) {
    R_body_local[i] = Eigen::AngleAxisd(-(last_yaw_rad + turn_rad(i)), Vector3::UnitZ()).toRotationMatrix();
    is_blind[i] = flies && !sees_beside(R_body_local[i] * ahead_local_m.normalized());
    for (int k = 0; k < kHeadings; ++k) shows[i][k] = sees(R_body_local[i] * azimuth_of(k, kHeadings));
    if (!is_blind[i]) within_reach |= shows[i];
  }
  // Azimuths are viewed one after another: when one is in view, the azimuth not viewed for longest is next.
  if (glance_ >= 0 && (looked_[glance_] == now || !within_reach[glance_])) glance_ = -1;
  if (glance_ < 0) {
    for (int k = 0; k < kHeadings; ++k) {
      if (within_reach[k] && looked_[k] < now && (glance_ < 0 || looked_[k] < looked_[glance_])) glance_ = k;
    }
  }
  double best_rad = last_yaw_rad, least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kHeadings; ++i) {
    double cost = Cost::kPerRad * std::abs(turn_rad(i));
    for (const Neighbor& neighbor : neighbors) {
      const Vector3 to_m = neighbor.position_local_m - p_local_m;
      if (!sees(R_body_local[i] * to_m))
        cost += (1.0 + to_seconds(now - neighbor.seen)) / time_to_meet_s(neighbor, to_m);
    }
    if (flies && !sees(R_body_local[i] * ahead_local_m)) cost += Cost::kAheadUnseen;
    // In flight, only headings with the flight direction in view earn this term.
    if (glance_ >= 0 && (is_blind[i] || !shows[i][glance_])) {
      const double overdue_s = std::max(0.0, to_seconds(now - looked_[glance_]) - Cost::kFreshView_s);
      cost += std::min(Cost::kGlance, Cost::kGlancePerS * overdue_s);
    }
    if (cost < least) {
      least = cost;
      best_rad = std::remainder(last_yaw_rad + turn_rad(i), 2.0 * kPi);
    }
  }
  return best_rad;
}

}  // namespace swiftlet
