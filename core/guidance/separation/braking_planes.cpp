// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/braking_planes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/guidance/guidance_constants.hpp"
#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

/// Limit along a unit direction, such that its horizontal and its vertical part keep their own limits.
double along(const Vector3& direction, double level, double vertical) {
  const double level_share = elementary::hypot(direction.x(), direction.y()), vertical_share = std::abs(direction.z());
  return 1.0 / std::max(level_share / level, vertical_share / vertical);
}

/// Nearest points of the segments a + s A and b + t B, with s and t between 0 and 1.
std::pair<Vector3, Vector3> nearest_points(const Vector3& a, const Vector3& A, const Vector3& b, const Vector3& B) {
  const Vector3 r = a - b;
  const double AA = A.squaredNorm(), BB = B.squaredNorm(), AB = A.dot(B), Ar = A.dot(r), Br = B.dot(r);
  const double point_m2 = kSamePlace_m * kSamePlace_m;  // a shorter segment counts as a point
  double s = 0.0, t = 0.0;
  if (AA > point_m2) {
    const double parallel = AA * BB - AB * AB;
    s = parallel > kNegligible * AA * BB ? std::clamp((AB * Br - Ar * BB) / parallel, 0.0, 1.0) : 0.0;
    if (BB <= point_m2) s = std::clamp(-Ar / AA, 0.0, 1.0);
  }
  if (BB > point_m2) {
    t = (AB * s + Br) / BB;
    if (t < 0.0 || t > 1.0) {
      t = std::clamp(t, 0.0, 1.0);
      if (AA > point_m2) s = std::clamp((AB * t - Ar) / AA, 0.0, 1.0);
    }
  }
  return {a + s * A, b + t * B};
}

}  // namespace

Braking braking_of(const Vector3& p_local_m, const Vector3& v_local_mps, double reaction_s,
                   const MotionLimits& limits) {
  const double speed_mps = v_local_mps.norm();
  if (speed_mps < kNegligible) return {p_local_m, p_local_m};
  const Vector3 direction = v_local_mps / speed_mps;
  const double braking_mps2 = along(direction, limits.horizontal_acceleration_mps2, limits.vertical_acceleration_mps2);
  return {p_local_m, p_local_m + (reaction_s + 0.5 * speed_mps / braking_mps2) * v_local_mps};
}

HalfSpace braking_plane(const Braking& self, const Braking& other, double distance_m, double vertical_m,
                        double uncertainty_m) {
  // Compressing the vertical axis turns the ellipsoid of distances into a ball.
  const Vector3 scale(1.0, 1.0, distance_m / vertical_m);
  const auto scaled = [&](const Vector3& v) -> Vector3 { return scale.cwiseProduct(v); };
  const Vector3 a = scaled(self.p_local_m), b = scaled(other.p_local_m);
  const auto [nearest_self, nearest_other] =
      nearest_points(a, scaled(self.stop_local_m) - a, b, scaled(other.stop_local_m) - b);
  Vector3 gap = nearest_other - nearest_self;
  if (gap.norm() < kSamePlace_m) gap = b - a;  // crossing paths: away from the neighbor's present position
  const double d = (nearest_other - nearest_self).norm();
  const Vector3 normal = unit_along(gap);
  // If the distance is already missing, the vehicle yields alone.
  const double room_m = d - distance_m, share_m = room_m > 0.0 ? 0.5 * room_m : room_m;
  const double offset_m =
      normal.dot(nearest_self - a) + std::max(share_m - 0.5 * uncertainty_m, std::min(share_m, 0.0));
  const Vector3 unscaled = scaled(normal);  // n' . (S q) = (S n') . q
  const double stretch = unscaled.norm();
  return {unscaled / stretch, offset_m / stretch};
}

HalfSpace pledge_plane(const Vector3& own_seen_local_m, const Vector3& other_seen_local_m, const Vector3& p_local_m,
                       double distance_m, double vertical_m, double uncertainty_m, double share) {
  const Vector3 scale(1.0, 1.0, distance_m / vertical_m);
  const Vector3 gap = scale.cwiseProduct(other_seen_local_m - own_seen_local_m);
  const double d = gap.norm();
  const Vector3 normal = unit_along(gap);
  const double used_m = normal.dot(scale.cwiseProduct(p_local_m - own_seen_local_m));
  const double offset_m = share * std::max(0.0, d - distance_m - uncertainty_m) - used_m;
  const Vector3 unscaled = scale.cwiseProduct(normal);
  const double stretch = unscaled.norm();
  return {unscaled / stretch, offset_m / stretch};
}

std::optional<HalfSpace> evasion_plane(const Braking& self, const Vector3& p_other_local_m,
                                       const Vector3& v_other_local_mps, double distance_m, double vertical_m,
                                       const MotionLimits& limits) {
  const Vector3 scale(1.0, 1.0, distance_m / vertical_m);
  const Vector3 to_self = scale.cwiseProduct(self.stop_local_m - p_other_local_m);
  const Vector3 displacement = scale.cwiseProduct(v_other_local_mps);
  if (displacement.norm() < kSamePlace_m || to_self.dot(displacement) <= 0.0) return std::nullopt;
  const Vector3 ahead = displacement.normalized();
  const Vector3 beside = to_self - to_self.dot(ahead) * ahead;
  if (beside.norm() >= distance_m) return std::nullopt;

  // Direction and length of the evasion in the scaled space, and its duration from rest.
  struct Escape {
    Vector3 out = Vector3::Zero();
    double path_length_m = 0.0, time_s = std::numeric_limits<double>::infinity();
  };
  // Shortest evasion along `out` to the required distance from the other's path.
  const auto escape = [&](const Vector3& out) {
    const double out_m = out.dot(beside);
    const double over_m2 = std::max(0.0, beside.squaredNorm() - out_m * out_m);
    const double path_length_m = std::max(0.0, std::sqrt(distance_m * distance_m - over_m2) - out_m);
    const Vector3 direction = out.cwiseQuotient(scale);
    const double length = direction.norm();
    const double mps2 =
        along(direction / length, limits.horizontal_acceleration_mps2, limits.vertical_acceleration_mps2);
    return Escape{out, path_length_m, std::sqrt(2.0 * path_length_m * length / mps2)};
  };
  Escape best;
  if (beside.norm() > kSamePlace_m) best = escape(beside.normalized());
  Vector3 across = ahead.cross(Vector3::UnitZ());  // to the right of the approaching vehicle
  if (across.norm() > kSamePlace_m) {
    across.normalize();
    const Escape level = escape(across.dot(beside) < -kSamePlace_m ? Vector3(-across) : across);
    if (level.time_s < best.time_s) best = level;
  } else if (best.time_s == std::numeric_limits<double>::infinity()) {
    best = escape(Vector3::UnitX());  // the other falls vertically onto the vehicle
  }
  const Vector3 unscaled = scale.cwiseProduct(best.out);
  const double stretch = unscaled.norm();
  const double out_m = best.path_length_m + unscaled.dot(self.stop_local_m - self.p_local_m);
  return HalfSpace{-unscaled / stretch, -out_m / stretch};
}

// The stopping distances v t + v^2 / 2a of both vehicles and the distance to keep fill the range.
double speed_into_unknown_mps(double range_m, double unknown_s, double distance_m, double braking_mps2) {
  const double path_length_m = std::max(0.0, 0.5 * (range_m - distance_m));
  if (path_length_m == std::numeric_limits<double>::infinity()) return path_length_m;
  return braking_mps2 * (std::sqrt(unknown_s * unknown_s + 2.0 * path_length_m / braking_mps2) - unknown_s);
}

}  // namespace swiftlet
