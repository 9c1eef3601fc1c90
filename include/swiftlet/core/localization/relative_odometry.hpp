// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/time.hpp"

namespace swiftlet {

/// [ns] Jump of the times in a vehicle's messages from which its clock counts as reset; drift is far smaller. Smaller
/// values start over after delayed messages.
inline constexpr TimeNs kClockJump = 5 * kNsPerSecond;

/// Drift model of an odometry: a random walk over distance flown, turning and time (as in sim/sensors/odometry). The
/// defaults are those of the preset odometry_vio.
struct OdometryDriftConfig {
  double position_m_psqrtm = 0.058;    ///< per axis
  double position_m_psqrtturn = 0.03;  ///< [m/sqrt(turn)] drift of the position in turns, per axis
  double position_m_psqrts = 0.0012;   ///< [m/sqrt(s)] drift of the position by time, per axis
  double yaw_deg_psqrtm = 0.1;
  double yaw_deg_psqrtturn = 0.5;  ///< [deg/sqrt(turn)] drift of the heading in turns
  double yaw_deg_psqrts = 0.01;    ///< [deg/sqrt(s)] drift of the heading by time

  void visit(ConfigVisitor& v);
};

/// Accumulated distance, turning and time; non-decreasing.
struct Flown {
  double path_m = 0.0, turn_rad = 0.0, time_s = 0.0;

  Flown operator-(const Flown& before) const {
    return {path_m - before.path_m, turn_rad - before.turn_rad, time_s - before.time_s};
  }
};

/// Drift variances accumulated over a flight.
class OdometryDrift {
 public:
  explicit OdometryDrift(const OdometryDriftConfig& config);
  double position_variance_m2(const Flown& flown) const { return variance(position_, flown); }  ///< per axis
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

/// Odometry reported by another vehicle, in its own local frame, which drifts.
struct OtherMotion {
  TimeNs t = 0;      ///< time by the own clock
  TimeNs stamp = 0;  ///< time by the other vehicle's clock
  Vector3 p_other_local_m = Vector3::Zero();
  Vector3 v_other_local_mps = Vector3::Zero();
  double yaw_rad = 0.0;  ///< heading in that frame
  double yaw_rate_radps = 0.0;
  Flown flown;  ///< accumulated since the first sample
};

/// Odometry reports of another vehicle: the last 64 samples, half a minute at 2 Hz.
class RelativeOdometry {
 public:
  /// Adds a sample; `flown` is computed here. False when it is not newer than the newest one, or not finite.
  bool push(OtherMotion sample);
  bool empty() const { return count_ == 0; }
  const OtherMotion& newest() const { return (*this)[count_ - 1]; }
  /// State at a time between two samples, by cubic interpolation of positions and velocities; nothing outside, or in a
  /// gap longer than gap_max_s.
  std::optional<OtherMotion> at(TimeNs t, double gap_max_s) const;

 private:
  /// [-] Stored samples, half a minute at 2 Hz. Smaller values lose the pairs of late sightings.
  static constexpr int kCapacity = 64;
  const OtherMotion& operator[](int i) const { return ring_[(first_ + i) % kCapacity]; }
  std::array<OtherMotion, kCapacity> ring_{};
  int first_ = 0, count_ = 0;
};

}  // namespace swiftlet
