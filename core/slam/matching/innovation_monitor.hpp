// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Agreement of the scans with the filter's predictions [Mehra 1970]: the innovations of the last scans, normalized by
/// their covariance. The IMU's noise is scaled until they agree.
class InnovationMonitor {
 public:
  /// [-] Mean of the normalized squares below which scans are consistent, as of exact noise models: 0.1 to 0.6 in
  /// simulated flights, 2 to 6 with a turned LiDAR. Larger values miss time offsets of 10 ms, and let a wrong mount
  /// pass while the vehicle hardly speeds up.
  static constexpr double kConsistent = 1.0;
  /// [-] Mean of the normalized squares that still counts as agreement: 0.2 to 0.4 after the start with a wrong time
  /// offset, 6 to 11 with a LiDAR turned by 90 or 180 degrees. Smaller values react to the errors of the map's own
  /// model, larger ones let wrong mounts pass.
  static constexpr double kAgreement = 4.0;

  /// @param innovation_sq  normalized square of an innovation in `num_directions` directions
  void add(double innovation_sq, int num_directions);
  /// @param v_local_mps  change of the velocity by a scan
  /// @param offset_known  the time offset between LiDAR and IMU has been estimated, or given
  void add_correction(const Vector3& v_local_mps, bool offset_known = true);

  /// Factor of the reported covariance, at least 1.
  double covariance_factor() const;
  /// Factor of the variances of the IMU's noise, at least 1.
  double noise_factor() const { return noise_factor_; }
  /// The scans disagree with the IMU by more than its noise explains.
  bool disagrees() const;
  /// The IMU does not measure the motion that the scans show.
  bool contradicts() const;
  /// Begins after the start: the changes of the velocity by the first scans are due to the unknown start.
  /// @param contradicted  whether the IMU counts as contradicted from here on
  void begin(bool contradicted);

 private:
  /// [scans] Length of the mean. Larger values detect disagreement later and more reliably.
  static constexpr int kScans = 10;
  std::array<double, kScans> last_{};  // normalized squares per direction
  int next_ = 0;
  double mean_ = 0.0;
  double noise_factor_ = 1.0;
  using Corrections = Eigen::Matrix<double, 3, kScans>;
  Corrections corrections_mps_ = Corrections::Zero();  // changes of the velocity by the last scans
  int next_correction_ = 0;
  int scans_contradicted_ = 0;  // number of scans for which the contradiction still holds
};

}  // namespace swiftlet
