// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/rbl_sight.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr double kNoDirection_m = 0.3;  // nearer than this, a direction is noise
constexpr double kBesideTheView = 0.2;  // tangent of what is near enough
constexpr double kAheadUnseen = 2.0;    // as much as a neighbor next to it that was not seen for a second
constexpr double kUnlookedPerS = 0.02;  // of each azimuth, for one that stands

Vector3 azimuth_of(int i, int count) {
  const double azimuth_rad = 2.0 * kPi * i / count;
  return {elementary::cos(azimuth_rad), elementary::sin(azimuth_rad), 0.0};
}

}  // namespace

bool RblSight::sees(const Vector3& p_body_m) const {
  return std::any_of(views_.begin(), views_.end(), [&](const NeighborView& view) { return view.contains(p_body_m); });
}

void RblSight::look(const Matrix3& R_local_body, TimeNs now) {
  for (int i = 0; i < kHeadings; ++i) {
    if (sees(R_local_body.transpose() * azimuth_of(i, kHeadings))) looked_[i] = now;
  }
}

bool RblSight::sees_ahead(const Pose& T_local_body, const Vector3& to_local_m) const {
  if (views_.empty()) return true;
  const Vector3 ahead_body_m = T_local_body.linear().transpose() * (to_local_m - T_local_body.translation());
  const double d = ahead_body_m.norm();
  return d < kNoDirection_m || sees(ahead_body_m / d + kBesideTheView * Vector3::UnitX());
}

double RblSight::heading(const Pose& T_local_body, const Vector3& to_local_m, std::span<const Neighbor> neighbors,
                         double last_yaw_rad, TimeNs now) {
  if (views_.empty()) return last_yaw_rad;
  look(T_local_body.linear(), now);
  const Vector3 p_local_m = T_local_body.translation();
  const Vector3 ahead_local_m = to_local_m - p_local_m;
  const bool flies = ahead_local_m.norm() > kNoDirection_m;
  double best_rad = last_yaw_rad, least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kHeadings; ++i) {
    const double turn_rad = std::remainder(2.0 * kPi * i / kHeadings, 2.0 * kPi);
    const Matrix3 R_body_local = Eigen::AngleAxisd(-(last_yaw_rad + turn_rad), Vector3::UnitZ()).toRotationMatrix();
    double cost = 0.01 * std::abs(turn_rad);
    for (const Neighbor& neighbor : neighbors) {
      const Vector3 to_m = neighbor.position_local_m - p_local_m;
      if (!sees(R_body_local * to_m)) cost += (1.0 + to_seconds(now - neighbor.seen)) / std::max(1.0, to_m.norm());
    }
    if (flies && !sees(R_body_local * ahead_local_m)) cost += kAheadUnseen;
    for (int k = 0; k < kHeadings && !flies; ++k) {
      if (!sees(R_body_local * azimuth_of(k, kHeadings))) cost += kUnlookedPerS * to_seconds(now - looked_[k]);
    }
    if (cost < least) {
      least = cost;
      best_rad = std::remainder(last_yaw_rad + turn_rad, 2.0 * kPi);
    }
  }
  return best_rad;
}

}  // namespace swiftlet
