// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/localization/local_cloud.hpp"

namespace swiftlet {

/// What a sensor could see of a round target of uncertain place in one sweep.
struct BeamExposure {
  double shots = 0.0;         ///< expected number of beams that meet the disc of the target, if it is there
  double beams_per_sr = 0.0;  ///< density of beams around it, whatever stopped them
};

/// A moving round target whose place is normally distributed.
struct RoundTarget {
  TimeNs t = 0;  ///< for which the place holds
  Vector3 p_local_m = Vector3::Zero();
  Vector3 v_local_mps = Vector3::Zero();
  double sigma_m = 0.0;  ///< of its place, across the line of sight
  double radius_m = 0.3;
};

/// The beams of one sweep by their directions in the local frame, each from its own place and at its own firing. By the
/// sensor's own beam table it tells how often a target would have been met. So it also says what silence means. Keeps
/// its memory from sweep to sweep.
class BeamIndex {
 public:
  void assign(const LocalCloud& cloud);

  /// A beam that ended before the target says nothing of it. All others could have met it. How far away the target is
  /// is uncertain, so a beam counts by the probability that it came as far as the target's near side. The target is a
  /// Gaussian of
  /// the disc's solid angle, convolved with that of its place. Let alpha be the angle of the radius and sigma the
  /// deviation of the place as an angle. A beam that passes the center at delta then meets it with a probability of
  /// alpha^2 / (alpha^2 + 2 sigma^2) exp(-delta^2 / (alpha^2 + 2 sigma^2)).
  BeamExposure exposure(const RoundTarget& target) const;

  /// The nearest return of the beams about a direction, up to 1.4 to 7 degrees away; infinite without any. A beam that
  /// was not returned may have been lost at the surface that returned its neighbors: one that it grazes returns few.
  double nearest_return_m(const Vector3& direction_local) const;

  /// Start and middle of the sweep.
  TimeNs stamp() const { return stamp_; }
  TimeNs middle() const { return middle_; }
  /// Place of the sensor in the middle of the sweep.
  const Vector3& p_local_lidar_m() const { return p_local_lidar_m_; }
  const Matrix3& R_local_lidar() const { return R_local_lidar_; }

 private:
  struct Beam {
    Eigen::Vector3f direction_local;
    float range_m;  // 0: no return
    int column;
  };
  static constexpr int kTurn = 256, kRows = 64;  // bins around, and from nadir to zenith
  static int bin_of(const Vector3& direction_local);

  TimeNs stamp_ = 0, middle_ = 0;
  Vector3 p_local_lidar_m_ = Vector3::Zero();
  Matrix3 R_local_lidar_ = Matrix3::Identity();
  std::vector<Vector3> origins_local_m_;    // by column
  std::vector<Eigen::Matrix3f> rotations_;  // from the sensor to the local frame, by column
  std::vector<double> offset_s_;            // by column, from the middle of the sweep
  double moved_m_ = 0.0;                    // the sensor's way from the middle of the sweep to its ends, at most
  double half_sweep_s_ = 0.0;
  std::vector<Beam> unsorted_, beams_;  // the latter by bin
  std::vector<std::uint16_t> bin_of_;
  std::vector<std::uint32_t> starts_;    // of each bin
  std::vector<float> nearest_return_m_;  // by bin
};

}  // namespace swiftlet
