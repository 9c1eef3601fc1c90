// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/localization/relative_odometry.hpp"

namespace swiftlet {

/// Position of an object in an observer's local frame, and the distance flown by that observer until then.
struct PathSample {
  TimeNs t = 0;
  Vector3 p_local_m = Vector3::Zero();
  Vector3 v_local_mps = Vector3::Zero();
  Matrix3 covariance = Matrix3::Identity();  ///< covariance of the position
  double yaw_rad = 0.0;                      ///< heading of the observer itself
  Flown flown;                               ///< accumulated by the observer
};

/// Samples of one object in the last seconds, in order of time. Memory is bounded.
class SampledPath {
 public:
  /// Adds a sample; false, and ignored, when it is not newer than the newest.
  bool push(const PathSample& sample);
  void forget_before(TimeNs t);
  bool empty() const { return samples_.empty(); }
  const PathSample& newest() const { return samples_.back(); }
  std::span<const PathSample> samples() const { return samples_; }
  /// Sample at a time between two samples: position by cubic interpolation of positions and velocities, the rest
  /// linear. Nothing outside, or in a longer gap.
  std::optional<PathSample> at(TimeNs t, double gap_max_s) const;

 private:
  /// [-] Largest number of samples; beyond it the oldest is dropped. Larger values use more memory.
  static constexpr std::size_t kCapacity = 256;
  std::vector<PathSample> samples_;
};

/// Path of one observer and paths of its tracks, in its local frame.
class ObserverHistory {
 public:
  struct Seen {
    std::uint32_t identity = 0;
    SampledPath path;
  };

  /// Adds a state of the observer, in order of time; the flown distance is computed here.
  bool push_self(TimeNs t, const Vector3& p_local_m, const Vector3& v_local_mps, double yaw_rad, double sigma_m);
  /// Adds a state of a track. Its flown distance is that of the observer's newest state.
  void push_track(std::uint32_t identity, TimeNs t, const Vector3& p_local_m, const Vector3& v_local_mps,
                  const Matrix3& covariance);
  /// Marks the history as complete until t: objects without a sample were not observed.
  void complete_until(TimeNs t) { until_ = t; }
  void forget_before(TimeNs t);
  void clear();

  const SampledPath& self() const { return self_; }
  std::span<const Seen> seen() const { return seen_; }  ///< sorted by identity
  TimeNs until() const { return until_; }

 private:
  SampledPath self_;
  Flown flown_;
  std::vector<Seen> seen_;
  TimeNs until_ = -1;
};

}  // namespace swiftlet
