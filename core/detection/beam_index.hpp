// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/localization/local_cloud.hpp"

namespace swiftlet {

/// Number of beams expected on a round target of uncertain position in one sweep.
struct BeamExposure {
  double shots = 0.0;  ///< expected number of beams that hit the disc of the target, given that the target exists
  double beams_per_sr = 0.0;  ///< density of beams around the target, regardless of their ranges
};

/// A moving round target with normally distributed position.
struct RoundTarget {
  TimeNs t = 0;  ///< validity time of the position
  Vector3 p_local_m = Vector3::Zero();
  Vector3 v_local_mps = Vector3::Zero();
  double sigma_m = 0.0;  ///< standard deviation of the position, across the line of sight
  double radius_m = 0.3;
};

/// Beams of one sweep sorted by direction in the local frame, each with its own origin and firing time. From the
/// sensor's beam table the class computes how often a target would have been hit, and so the likelihood of a sweep
/// without returns. Reuses its memory from sweep to sweep.
class BeamIndex {
 public:
  /// @param empty_lidar  further directions without return, from EmptyDirections
  void assign(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar = {});

  /// Expected beams on the target. A beam that ended before the target carries no information about it. The range of
  /// the target is uncertain, so a beam counts by the probability that it reached the target's near side. The target is
  /// a Gaussian of the disc's solid angle, convolved with that of its position. Let alpha be the angle of the radius
  /// and sigma the deviation of the position as an angle. A beam that passes the center at delta then hits it with a
  /// probability of alpha^2 / (alpha^2 + 2 sigma^2) exp(-delta^2 / (alpha^2 + 2 sigma^2)).
  BeamExposure exposure(const RoundTarget& target) const;

  /// Range [m] of the nearest return among the beams around a direction, up to 1.4 to 7 degrees away; infinite without
  /// any. Bounds the air that a beam without return clears: a surface at grazing incidence returns only some beams.
  double nearest_return_m(const Vector3& direction_local) const;

  /// Start and mid-time of the sweep.
  TimeNs stamp() const { return stamp_; }
  TimeNs middle() const { return middle_; }
  /// Position of the sensor at mid-sweep.
  const Vector3& p_local_lidar_m() const { return p_local_lidar_m_; }
  const Matrix3& R_local_lidar() const { return R_local_lidar_; }

 private:
  struct Beam {
    Eigen::Vector3f direction_local;
    float range_m;  // 0: no return
    int column;
  };
  static constexpr int kAzimuths = 256, kRows = 64;  // azimuth bins, and elevation bins from nadir to zenith
  static int bin_of(const Vector3& direction_local);
  void add(const Eigen::Vector3f& direction_lidar, float range_m, int column);

  TimeNs stamp_ = 0, middle_ = 0;
  Vector3 p_local_lidar_m_ = Vector3::Zero();
  Matrix3 R_local_lidar_ = Matrix3::Identity();
  std::vector<Vector3> origins_local_m_;    // indexed by column
  std::vector<Eigen::Matrix3f> rotations_;  // from the sensor to the local frame; indexed by column
  std::vector<double> offset_s_;            // relative to mid-sweep; indexed by column
  double sensor_moved_m_ = 0.0;  // largest displacement of the sensor between mid-sweep and the ends of the sweep
  double half_sweep_s_ = 0.0;
  std::vector<Beam> unsorted_, beams_;  // beams_ is sorted by bin
  std::vector<std::uint16_t> bin_of_;
  std::vector<std::uint32_t> starts_;    // first beam of each bin
  std::vector<float> nearest_return_m_;  // indexed by bin
};

}  // namespace swiftlet
