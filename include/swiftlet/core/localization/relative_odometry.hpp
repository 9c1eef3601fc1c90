// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// What an odometry may drift: a random walk by distance flown, by turning and by time (sim/sensors/odometry has the
/// same law). The defaults are those of the preset odometry_vio.
struct OdometryDriftConfig {
  double position_m_psqrtm = 0.058;  ///< by axis
  double position_m_psqrtturn = 0.03;
  double position_m_psqrts = 0.0012;
  double yaw_deg_psqrtm = 0.1;
  double yaw_deg_psqrtturn = 0.5;
  double yaw_deg_psqrts = 0.01;

  void visit(ConfigVisitor& v);
};

/// How much was flown: path, turning, time. They only grow.
struct Flown {
  double path_m = 0.0, turn_rad = 0.0, time_s = 0.0;

  Flown operator-(const Flown& before) const {
    return {path_m - before.path_m, turn_rad - before.turn_rad, time_s - before.time_s};
  }
};

/// Variances that the drift adds over what was flown.
class OdometryDrift {
 public:
  explicit OdometryDrift(const OdometryDriftConfig& config);
  double position_variance_m2(const Flown& flown) const { return variance(position_, flown); }  ///< by axis
  double yaw_variance_rad2(const Flown& flown) const { return variance(yaw_, flown); }

 private:
  struct Rates {
    double per_m, per_rad, per_s;
  };
  static double variance(const Rates& rates, const Flown& flown) {
    return rates.per_m * flown.path_m + rates.per_rad * flown.turn_rad + rates.per_s * flown.time_s;
  }
  Rates position_, yaw_;
};

/// Where another vehicle says that it is, in its own local frame, which drifts.
struct OtherMotion {
  TimeNs t = 0;      ///< by the own clock
  TimeNs stamp = 0;  ///< by its own
  Vector3 p_other_local_m = Vector3::Zero();
  Vector3 v_other_local_mps = Vector3::Zero();
  double yaw_rad = 0.0;  ///< in that frame
  double yaw_rate_radps = 0.0;
  Flown flown;  ///< since the first sample
};

/// What another vehicle told of its odometry: the last 64 samples, half a minute of two a second.
class RelativeOdometry {
 public:
  /// False when it is not newer than the newest, or not finite; `flown` is found here.
  bool push(OtherMotion sample);
  bool empty() const { return count_ == 0; }
  const OtherMotion& newest() const { return (*this)[count_ - 1]; }
  /// Between two samples, by a cubic through positions and velocities; nothing outside, or in a gap longer than this.
  std::optional<OtherMotion> at(TimeNs t, double gap_max_s) const;

 private:
  static constexpr int kCapacity = 64;
  const OtherMotion& operator[](int i) const { return ring_[(first_ + i) % kCapacity]; }
  std::array<OtherMotion, kCapacity> ring_{};
  int first_ = 0, count_ = 0;
};

}  // namespace swiftlet
