// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/innovation_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

// [-] limit of the normalized square of one scan. Larger values let a single wrong scan scale the noise.
constexpr double kMaxSquare = 100.0;
// [-] share of the excess by which a scan scales the noise. Larger values adapt faster and overshoot.
constexpr double kAdaptation = 0.1;
// [-] largest share by which a scan lowers the noise again: by half in 35 scans. Larger values forget a disagreement
// that shows in maneuvers only.
constexpr double kRecovery = 0.02;
// [-] limits of the noise factor: of a warning, of a contradiction, and of the factor itself. The standard deviation of
// the noise grows by its square root. Larger values report later, and a larger last one recovers later.
constexpr double kDisagreement = 10.0, kContradiction = 100.0, kMaxNoise = 1e6;
// [m/s] Change of the velocity by ten scans that contradicts the IMU: in one second, 5 % of gravity. Scans change the
// velocity by up to 0.06 m/s with good IMUs, by 0.25 with ten times the noise, and by 0.7 to 4 with a LiDAR turned by
// 90 or 180 degrees. Larger values let wrong mounts pass, smaller ones refuse noisy IMUs.
constexpr double kWrongVelocity_mps = 0.5;
// [m/s] Limit like kWrongVelocity_mps while the time offset is unknown. Offsets of 10 and 20 ms change the velocity by
// up to 0.9 m/s, offsets of 40 ms by 1.2, a turned LiDAR by 1 within seven scans. Larger values notice a wrong mount
// later, smaller ones refuse late stamps.
constexpr double kWrongStart_mps = 1.0;
// [scans] Number of scans that must agree again after a change of the velocity beyond the limit. Larger values make the
// estimate invalid for longer after a collision.
constexpr int kContradictedScans = 100;

}  // namespace

void InnovationMonitor::add(double innovation_sq, int num_directions) {
  if (num_directions <= 0 || !(innovation_sq >= 0.0)) return;
  last_[next_] = std::min(innovation_sq / num_directions, kMaxSquare);
  next_ = (next_ + 1) % kScans;
  mean_ = 0.0;
  for (const double square : last_) mean_ += square / kScans;
  const double excess = elementary::log(mean_ / kAgreement);
  noise_factor_ *= elementary::exp(std::max(kAdaptation * excess, -kRecovery));
  noise_factor_ = std::clamp(noise_factor_, 1.0, kMaxNoise);
}

/// Accelerations that the IMU does not measure add up; those that noise suggests do not.
void InnovationMonitor::add_correction(const Vector3& v_local_mps, bool offset_known) {
  corrections_mps_.col(next_correction_) = v_local_mps;
  next_correction_ = (next_correction_ + 1) % kScans;
  const bool wrong = corrections_mps_.rowwise().sum().norm() > (offset_known ? kWrongVelocity_mps : kWrongStart_mps);
  if (wrong)
    scans_contradicted_ = kContradictedScans;
  else if (mean_ < kConsistent)
    scans_contradicted_ = std::max(scans_contradicted_ - 1, 0);
}

double InnovationMonitor::covariance_factor() const { return std::max(1.0, mean_ / kAgreement); }
bool InnovationMonitor::disagrees() const { return noise_factor_ > kDisagreement; }
bool InnovationMonitor::contradicts() const { return noise_factor_ > kContradiction || scans_contradicted_ > 0; }

void InnovationMonitor::begin(bool contradicted) {
  corrections_mps_.setZero();
  scans_contradicted_ = contradicted ? kContradictedScans : 0;
}

}  // namespace swiftlet
