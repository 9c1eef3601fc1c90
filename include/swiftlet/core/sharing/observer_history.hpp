// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/localization/relative_odometry.hpp"

namespace swiftlet {

/// Where something was in an observer's local frame, and what that observer had flown by then.
struct PathSample {
  TimeNs t = 0;
  Vector3 p_local_m = Vector3::Zero();
  Vector3 v_local_mps = Vector3::Zero();
  Matrix3 covariance = Matrix3::Identity();  ///< of the position
  double yaw_rad = 0.0;                      ///< of the observer itself
  Flown flown;                               ///< by the observer
};

/// The samples of one thing in the last seconds, by time. Memory is bounded.
class SampledPath {
 public:
  /// One that is not newer than the newest is passed over: false.
  bool push(const PathSample& sample);
  void forget_before(TimeNs t);
  bool empty() const { return samples_.empty(); }
  const PathSample& newest() const { return samples_.back(); }
  std::span<const PathSample> samples() const { return samples_; }
  /// Between two samples: position by a cubic through positions and velocities, the rest linear. Nothing outside, or in
  /// a longer gap.
  std::optional<PathSample> at(TimeNs t, double gap_max_s) const;

 private:
  static constexpr std::size_t kCapacity = 256;
  std::vector<PathSample> samples_;
};

/// What one observer knows: where it was itself, and where it saw others. All in its local frame.
class ObserverHistory {
 public:
  struct Seen {
    std::uint32_t identity = 0;
    SampledPath path;
  };

  /// Of the observer, in order of time; what it flew is found here.
  bool push_self(TimeNs t, const Vector3& p_local_m, const Vector3& v_local_mps, double yaw_rad, double sigma_m);
  /// Of a track. What the observer had flown is that of its newest own sample.
  void push_track(std::uint32_t identity, TimeNs t, const Vector3& p_local_m, const Vector3& v_local_mps,
                  const Matrix3& covariance);
  /// Everything up to here is told: what is not there was not seen.
  void complete_until(TimeNs t) { until_ = t; }
  void forget_before(TimeNs t);
  void clear();

  const SampledPath& self() const { return self_; }
  std::span<const Seen> seen() const { return seen_; }  ///< by identity
  TimeNs until() const { return until_; }

 private:
  SampledPath self_;
  Flown flown_;
  std::vector<Seen> seen_;
  TimeNs until_ = -1;
};

}  // namespace swiftlet
